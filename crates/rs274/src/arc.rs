//! Arcs: from the words of a block to centre and sweep, in program coordinates.
//!
//! Formats as LinuxCNC documents them ("G2, G3 Arc Move"), tolerances as its interpreter has them by default: in centre format the two
//! radii may differ by [`CENTRE_TOLERANCE_MM`] in G21 and [`CENTRE_TOLERANCE_INCH`] in G20, or by 0.1 % of the radius up to a hundred
//! times as much. The end point is kept as programmed: the radius then changes linearly with the angle, a spiral.

use super::error::Cause;
use std::f64::consts::{SQRT_2, TAU};

/// In G21, radii that differ by no more than this, mm, are equal: LinuxCNC's `CENTER_ARC_RADIUS_TOLERANCE_MM`, the diagonal of a
/// square whose side is twice the last of two decimals.
pub const CENTRE_TOLERANCE_MM: f64 = 0.02 * SQRT_2;

/// The same in G20, inches: LinuxCNC's `CENTER_ARC_RADIUS_TOLERANCE_INCH`, for three decimals.
pub const CENTRE_TOLERANCE_INCH: f64 = 0.002 * SQRT_2;

/// Radii that differ by more than this many tolerances are never accepted.
const LARGEST_TOLERANCES: f64 = 100.0;

/// The chord of an R arc may exceed its diameter by twice this, mm.
pub const RADIUS_TOLERANCE_MM: f64 = 0.005;

/// Between tolerance and a hundred tolerances: the part of the radius by which radii may differ.
pub const RADIUS_TOLERANCE_RELATIVE: f64 = 1e-3;

/// A sweep smaller than this, radians, is one more turn: start and end are the same point but for rounding
/// (LinuxCNC's `CIRCLE_FUZZ`).
const FULL_TURN_TOLERANCE: f64 = 1e-6;

/// Points closer than this, mm, are one point for the R format, which has no answer for them.
const COINCIDENT_MM: f64 = 1e-9;

/// Centre and sweep in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Circle {
    pub centre: [f64; 2],
    /// Radians, positive counter-clockwise.
    pub sweep: f64,
}

/// Centre format: `centre` is resolved already; radii that differ by up to `tolerance_mm` are equal.
pub(super) fn from_centre(
    start: [f64; 2],
    end: [f64; 2],
    centre: [f64; 2],
    clockwise: bool,
    turns: i32,
    tolerance_mm: f64,
) -> Result<Circle, Cause> {
    let start_mm = (start[0] - centre[0]).hypot(start[1] - centre[1]);
    let end_mm = (end[0] - centre[0]).hypot(end[1] - centre[1]);
    let difference = (start_mm - end_mm).abs();
    let relative = RADIUS_TOLERANCE_RELATIVE * start_mm.max(end_mm);
    if difference > LARGEST_TOLERANCES * tolerance_mm || (difference > tolerance_mm && difference > relative) {
        return Err(Cause::RadiusMismatch { start_mm, end_mm });
    }
    if start_mm < COINCIDENT_MM || end_mm < COINCIDENT_MM {
        return Err(Cause::Arc("its radius is zero"));
    }
    Ok(Circle { centre, sweep: sweep(start, end, centre, clockwise, turns) })
}

/// R format: a positive radius is the shorter arc, a negative one the longer.
pub(super) fn from_radius(
    start: [f64; 2],
    end: [f64; 2],
    radius: f64,
    clockwise: bool,
    turns: i32,
) -> Result<Circle, Cause> {
    let chord = [end[0] - start[0], end[1] - start[1]];
    let length = chord[0].hypot(chord[1]);
    if length < COINCIDENT_MM {
        return Err(Cause::Arc("R with start and end at one point"));
    }
    if radius.abs() < COINCIDENT_MM {
        return Err(Cause::Arc("its radius is zero"));
    }
    if length / 2.0 > radius.abs() + RADIUS_TOLERANCE_MM {
        return Err(Cause::Arc("R is less than half the distance from start to end"));
    }
    // Distance of the centre from the chord's middle, towards the chord's left for a short counter-clockwise arc.
    let height = (radius * radius - length * length / 4.0).max(0.0).sqrt();
    let side = if clockwise == (radius > 0.0) { -height } else { height };
    let centre = [
        f64::midpoint(start[0], end[0]) - chord[1] / length * side,
        f64::midpoint(start[1], end[1]) + chord[0] / length * side,
    ];
    Ok(Circle { centre, sweep: sweep(start, end, centre, clockwise, turns) })
}

fn sweep(start: [f64; 2], end: [f64; 2], centre: [f64; 2], clockwise: bool, turns: i32) -> f64 {
    let from = (start[1] - centre[1]).atan2(start[0] - centre[0]);
    let to = (end[1] - centre[1]).atan2(end[0] - centre[0]);
    let direction = if clockwise { -1.0 } else { 1.0 };
    let mut angle = (direction * (to - from)).rem_euclid(TAU);
    if angle < FULL_TURN_TOLERANCE {
        angle += TAU;
    }
    direction * (angle + f64::from(turns - 1) * TAU)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn is_near(circle: Circle, centre: [f64; 2], sweep: f64) -> bool {
        let off = (circle.centre[0] - centre[0]).hypot(circle.centre[1] - centre[1]);
        off < 1e-9 && (circle.sweep - sweep).abs() < 1e-9
    }

    #[test]
    fn the_sign_of_r_and_the_direction_choose_one_of_four_arcs() {
        // From (10, 0) to (0, 10) at radius 10: the centre is (0, 0) or (10, 10), the sweep a quarter or three.
        for (radius, clockwise, centre, sweep) in [
            (10.0, false, [0.0, 0.0], FRAC_PI_2),
            (-10.0, false, [10.0, 10.0], 3.0 * FRAC_PI_2),
            (10.0, true, [10.0, 10.0], -FRAC_PI_2),
            (-10.0, true, [0.0, 0.0], -3.0 * FRAC_PI_2),
        ] {
            let circle = from_radius([10.0, 0.0], [0.0, 10.0], radius, clockwise, 1).unwrap();
            assert!(is_near(circle, centre, sweep), "R{radius} clockwise {clockwise}: {circle:?}");
        }
    }

    #[test]
    fn the_centre_of_an_r_arc_has_both_coordinates() {
        // Chord (1, 2) to (7, 10): middle (4, 6), half length 5. With R 13 the centre is 12 to the left, along (-0.8, 0.6).
        let circle = from_radius([1.0, 2.0], [7.0, 10.0], 13.0, false, 1).unwrap();
        assert!(is_near(circle, [4.0 - 9.6, 6.0 + 7.2], 2.0 * (5.0_f64 / 13.0).asin()), "{circle:?}");
    }

    #[test]
    fn r_may_fall_short_of_half_the_chord_by_the_tolerance() {
        let arc = |radius| from_radius([0.0, 0.0], [20.0, 0.0], radius, false, 1);
        for radius in [9.996, -9.996] {
            assert!(is_near(arc(radius).unwrap(), [10.0, 0.0], PI), "{radius}");
        }
        assert!(arc(9.994).is_err() && arc(-9.994).is_err());
        assert!(arc(0.0).is_err() && from_radius([1.0, 2.0], [1.0, 2.0], 5.0, false, 1).is_err());
        // A radius of zero is named before a chord it cannot span.
        assert!(matches!(arc(0.0), Err(Cause::Arc("its radius is zero"))));
    }

    #[test]
    fn radii_may_differ_by_a_tolerance_that_grows_with_them() {
        // Tolerance, radius, by how much radii may differ, by how much not: the tolerance, 0.1 %, never more than a hundred tolerances.
        for (tolerance, radius, allowed, refused) in [
            (CENTRE_TOLERANCE_MM, 1.0, 0.028, 0.029),
            (CENTRE_TOLERANCE_MM, 100.0, 0.099, 0.102),
            (CENTRE_TOLERANCE_MM, 4000.0, 2.82, 2.83),
            (CENTRE_TOLERANCE_INCH * 25.4, 1.0, 0.0718, 0.0719),
            (CENTRE_TOLERANCE_INCH * 25.4, 9000.0, 7.18, 7.19),
        ] {
            for sign in [-1.0, 1.0] {
                let arc = |difference: f64| {
                    let end = [3.0, 4.0 + radius + sign * difference];
                    from_centre([3.0 + radius, 4.0], end, [3.0, 4.0], false, 1, tolerance)
                };
                assert!(is_near(arc(allowed).unwrap(), [3.0, 4.0], FRAC_PI_2), "{radius}");
                assert!(matches!(arc(refused), Err(Cause::RadiusMismatch { .. })), "{radius} {sign}");
            }
        }
        // Exactly the tolerances, which are numbers of few digits here: 0.01 - 0.005 and 1000.5 - 1000.
        let arc = |start, end, centre| from_centre(start, end, centre, false, 1, 0.005);
        assert!(arc([0.005, 0.0], [0.0, 0.01], [0.0, 0.0]).is_ok());
        assert!(arc([1000.0, 0.0], [0.0, 1000.5], [0.0, 0.0]).is_ok());
        assert!(matches!(arc([1.0, 1.0], [1.0, 1.0], [1.0, 1.0]), Err(Cause::Arc(_))));
        assert!(matches!(arc([1.0, 1.0], [1.004, 1.0], [1.0, 1.0]), Err(Cause::Arc(_))));
    }

    #[test]
    fn tolerances_are_met_by_what_is_exactly_as_large() {
        let origin = [0.0, 0.0];
        // A thousandth of 125 mm is 0.125 mm, exactly in floating point.
        assert!(from_centre([125.0, 0.0], [0.0, 124.875], origin, false, 1, 0.005).is_ok());
        let tiny = COINCIDENT_MM;
        assert!(from_centre([tiny, 0.0], [0.0, tiny], origin, false, 1, 0.005).is_ok());
        for (start, end) in [(0.5 * tiny, tiny), (tiny, 0.5 * tiny), (0.004, 0.0)] {
            assert_eq!(
                from_centre([start, 0.0], [0.0, end], origin, false, 1, 0.005),
                Err(Cause::Arc("its radius is zero"))
            );
        }
        assert!(from_radius(origin, [tiny, 0.0], 1.0, false, 1).is_ok());
        assert!(from_radius(origin, [tiny, 0.0], tiny, false, 1).is_ok());
        // Half of 0.02 mm is 0.005 mm more than R 0.005.
        assert!(from_radius(origin, [0.02, 0.0], 0.005, false, 1).is_ok());
    }

    #[test]
    fn an_arc_back_to_its_start_is_a_full_turn_and_turns_add_up() {
        let arc =
            |end, clockwise, turns| from_centre([5.0, 2.0], end, [3.0, 2.0], clockwise, turns, 0.005).unwrap().sweep;
        assert_eq!(arc([5.0, 2.0], false, 1), TAU);
        assert_eq!(arc([5.0, 2.0], true, 2), -2.0 * TAU);
        // Five ten-millionths of a radian past the start are a full turn and as much; five millionths are an arc. The sweep leads to the end.
        let end = |angle: f64| [3.0 + 2.0 * angle.cos(), 2.0 + 2.0 * angle.sin()];
        for past in [5e-7, -5e-7] {
            assert!((arc(end(past), false, 1) - TAU - past).abs() < 1e-12);
            assert!((arc(end(past), true, 1) + TAU - past).abs() < 1e-12);
        }
        assert!(
            (arc(end(5e-6), false, 1) - 5e-6).abs() < 1e-12 && (arc(end(-5e-6), false, 1) - (TAU - 5e-6)).abs() < 1e-9
        );
        // A quarter counter-clockwise is three quarters clockwise; two more turns add two.
        assert!((arc([3.0, 4.0], true, 1) + 1.5 * PI).abs() < 1e-12);
        assert!((arc([3.0, 4.0], false, 3) - (FRAC_PI_2 + 2.0 * TAU)).abs() < 1e-12);
    }
}
