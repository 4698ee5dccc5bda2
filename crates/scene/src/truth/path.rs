//! Depth of the poses of a path: the travel past first contact.
//!
//! The length of a step from one pose to the next is the largest displacement of a corner of `b`'s bounding box, in the frame of `a`;
//! within a step, length grows in proportion. Between two poses, `b` turns at a constant rate about an axis of fixed direction, and its
//! origin moves along a straight line.

use super::{PairOracle, Verdict};
use crate::geometry::Isometry;

/// Accuracy, along the path, of the entries into contact and the exits from it, mm: a tenth of the limit between `grazing` and deeper.
pub const RESOLUTION_MM: f64 = 1e-7;

/// Sine of half the angle between two rotations that count as opposite, below which there is no shortest rotation; no unit.
const OPPOSITE: f64 = 1e-9;

/// The travel past first contact, mm, for every colliding pose of a path (consecutive poses of one cluster); `None` for a free pose. It is
/// the smaller of two path lengths: since contact was last entered, and until contact is left. It is infinite when neither is known, as for
/// a recording that never leaves contact, so an unknown depth counts as deep. Where one solid lies wholly inside the other, a pose has no
/// depth, but contact is neither entered nor left there. `verdicts` holds the exact verdicts of the poses.
///
/// Entry and exit are found by bisection, with exact verdicts at interpolated poses, between a free pose and its colliding neighbour. When
/// contact changes more than once within that step, one of the changes is found. A path that starts in contact has no entry; one that ends
/// in contact has no exit. A gap that lies wholly between two colliding poses is not detected. When the lists differ in length, the surplus
/// is ignored.
pub fn path_depths(oracle: &PairOracle, poses: &[Isometry], verdicts: &[Verdict]) -> Vec<Option<f64>> {
    let count = poses.len().min(verdicts.len());
    let (poses, verdicts) = (&poses[..count], &verdicts[..count]);
    let steps: Vec<f64> = poses.windows(2).map(|pair| step_length_mm(oracle, &pair[0], &pair[1])).collect();
    let mut depths = vec![None; count];
    let mut first = 0;
    while first < count {
        if !verdicts[first].collides() {
            first += 1;
            continue;
        }
        let last = (first..count).take_while(|&i| verdicts[i].collides()).last().unwrap_or(first);
        let entered = match first.checked_sub(1) {
            Some(before) => past_contact_mm(oracle, &poses[before], &poses[first], steps[before]),
            None => f64::INFINITY,
        };
        let left = match poses.get(last + 1) {
            Some(after) => past_contact_mm(oracle, after, &poses[last], steps[last]),
            None => f64::INFINITY,
        };
        fill(&mut depths[first..=last], &steps[first..last], entered, left);
        first = last + 1;
    }
    depths.iter_mut().zip(verdicts).filter(|(_, verdict)| !verdict.touches()).for_each(|(depth, _)| *depth = None);
    depths
}

/// Fills in the depths of one run of colliding poses, which are `steps` apart. The first is `entered` past the entry, and the last is
/// `left` before the exit.
fn fill(depths: &mut [Option<f64>], steps: &[f64], entered: f64, left: f64) {
    let total: f64 = steps.iter().sum();
    let mut since_first = 0.0;
    for (i, depth) in depths.iter_mut().enumerate() {
        *depth = Some((entered + since_first).min((total - since_first).max(0.0) + left));
        since_first += steps.get(i).copied().unwrap_or(0.0);
    }
}

/// The length of path between the change of contact and `colliding`; the whole step from `free` has `length_mm`.
fn past_contact_mm(oracle: &PairOracle, free: &Isometry, colliding: &Isometry, length_mm: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while (high - low) * length_mm > RESOLUTION_MM {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break; // A step so long that its fractions run out.
        }
        if oracle.judge(&between(free, colliding, middle)).collides() { high = middle } else { low = middle }
    }
    (1.0 - high) * length_mm
}

/// The interpolated pose at a fraction of the step; for opposite rotations, the nearer end.
fn between(from: &Isometry, to: &Isometry, fraction: f64) -> Isometry {
    from.try_lerp_slerp(to, fraction, OPPOSITE).unwrap_or(if fraction < 0.5 { *from } else { *to })
}

/// The largest displacement of a corner of `b`'s bounding box between two poses, mm.
fn step_length_mm(oracle: &PairOracle, from: &Isometry, to: &Isometry) -> f64 {
    oracle.b.bounds().corners().iter().map(|corner| (to * corner - from * corner).norm()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::solids;
    use super::*;
    use crate::geometry::Vector;
    use std::sync::Arc;

    fn blocks() -> PairOracle {
        PairOracle::new(Arc::new(solids::block(4.0, 4.0, 4.0)), Arc::new(solids::block(2.0, 2.0, 2.0)))
    }

    fn depths(oracle: &PairOracle, poses: &[Isometry]) -> Vec<Option<f64>> {
        let verdicts: Vec<Verdict> = poses.iter().map(|pose| oracle.judge(pose)).collect();
        path_depths(oracle, poses, &verdicts)
    }

    fn assert_near(found: &[Option<f64>], expected: &[Option<f64>]) {
        assert_eq!(found.len(), expected.len());
        for (f, e) in found.iter().zip(expected) {
            match (f, e) {
                (Some(f), Some(e)) => assert!((f - e).abs() < 2e-7, "{found:?} {expected:?}"),
                _ => assert_eq!(f, e, "{found:?} {expected:?}"),
            }
        }
    }

    #[test]
    fn a_straight_pass_over_the_top_counts_from_both_ends() {
        // The tool's lower face is at z = 2 - 0.5: in contact for |x| <= 3.
        let poses: Vec<Isometry> =
            [-5.0, -3.5, -2.9, -2.0, 1.0, 2.0, 4.0].iter().map(|&x| Isometry::translation(x, 0.0, 2.5)).collect();
        let expected = [None, None, Some(0.1), Some(1.0), Some(2.0), Some(1.0), None];
        assert_near(&depths(&blocks(), &poses), &expected);
    }

    #[test]
    fn a_path_that_starts_or_ends_in_contact_has_one_end() {
        let pose = |x: f64| Isometry::translation(x, 0.0, 2.5);
        let out = [pose(-1.0), pose(-2.0), pose(-4.0)];
        assert_near(&depths(&blocks(), &out), &[Some(2.0), Some(1.0), None]);
        let into = [pose(-4.0), pose(-2.0), pose(-1.0), pose(-1.0)];
        assert_near(&depths(&blocks(), &into), &[None, Some(1.0), Some(2.0), Some(2.0)]);
        // How deep, nobody knows: as deep as can be.
        assert_eq!(depths(&blocks(), &[pose(-2.0)]), [Some(f64::INFINITY)]);
        assert_eq!(depths(&blocks(), &[pose(-2.0); 3]), [Some(f64::INFINITY); 3]);
        assert!(depths(&blocks(), &[]).is_empty());
    }

    /// The tool lies wholly inside for |x| < 1 and touches from there to |x| = 3.
    #[test]
    fn a_pose_wholly_inside_is_no_way_out() {
        let pose = |x: f64| Isometry::translation(x, 0.0, 0.0);
        let into = [-5.0, -2.9, -1.0005, 0.0].map(pose);
        assert_near(&depths(&blocks(), &into), &[None, Some(0.1), Some(1.9995), None]);
        let through = [-5.0, -1.5, 0.0, 2.0, 5.0].map(pose);
        assert_near(&depths(&blocks(), &through), &[None, Some(1.5), None, Some(1.0), None]);
        // From a free pose straight into the solid: the entry is where the surfaces first touch.
        let out = [-5.0, 0.0, 1.5].map(pose);
        assert_near(&depths(&blocks(), &out), &[None, None, Some(4.5)]);
    }

    #[test]
    fn a_turn_is_as_long_as_the_way_of_the_farthest_corner() {
        let oracle = blocks();
        let turned = Isometry::new(Vector::zeros(), Vector::z() * std::f64::consts::FRAC_PI_2);
        // A corner at (1, 1) goes to (-1, 1).
        assert!((step_length_mm(&oracle, &Isometry::identity(), &turned) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn opposite_rotations_and_unequal_lists_do_no_harm() {
        let half_turn = Isometry::new(Vector::new(9.0, 0.0, 0.0), Vector::z() * std::f64::consts::PI);
        let poses = [half_turn, Isometry::translation(2.5, 0.0, 0.0)];
        assert!(depths(&blocks(), &poses)[1].is_some_and(f64::is_finite));
        assert_eq!(path_depths(&blocks(), &poses, &[Verdict::default()]).len(), 1);
    }
}
