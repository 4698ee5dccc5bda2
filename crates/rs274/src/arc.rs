//! Arcs: from the words of a block to centre and sweep, in program coordinates.
//!
//! Formats and tolerances as LinuxCNC documents them ("G2, G3 Arc Move"): in centre format the two radii may differ by
//! 0.005 mm, or by 0.1 % of the radius up to 0.5 mm. The end point is kept as programmed: the radius then changes
//! linearly with the angle.

use super::error::Cause;
use std::f64::consts::TAU;

/// Radii that differ by no more than this are equal: LinuxCNC's 0.005 mm.
pub const RADIUS_TOLERANCE_MM: f64 = 0.005;

/// Radii that differ by more than this are never accepted: LinuxCNC's 0.5 mm.
pub const RADIUS_TOLERANCE_LARGEST_MM: f64 = 0.5;

/// Between the two: the part of the radius by which radii may differ.
pub const RADIUS_TOLERANCE_RELATIVE: f64 = 1e-3;

/// A sweep smaller than this, radians, is a full turn: start and end are the same point but for rounding
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

/// Centre format: `centre` is resolved already.
pub(super) fn from_centre(
    start: [f64; 2],
    end: [f64; 2],
    centre: [f64; 2],
    clockwise: bool,
    turns: i32,
) -> Result<Circle, Cause> {
    let start_mm = (start[0] - centre[0]).hypot(start[1] - centre[1]);
    let end_mm = (end[0] - centre[0]).hypot(end[1] - centre[1]);
    let difference = (start_mm - end_mm).abs();
    let relative = RADIUS_TOLERANCE_RELATIVE * start_mm.max(end_mm);
    if difference > RADIUS_TOLERANCE_LARGEST_MM || (difference > RADIUS_TOLERANCE_MM && difference > relative) {
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
    if !(FULL_TURN_TOLERANCE..=TAU - FULL_TURN_TOLERANCE).contains(&angle) {
        angle = TAU;
    }
    direction * (angle + f64::from(turns - 1) * TAU)
}
