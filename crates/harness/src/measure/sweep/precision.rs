//! The sweep of ε in the separating-axis test: how many overlapping pairs of boxes are reported as disjoint because of rounding.
//!
//! When two edges are nearly parallel, their cross product is nearly zero, and so are both sides of the inequality along it. Rounding
//! errors then decide, unless ε is added to every |R_ij| (Gottschalk 2000, section on degenerate axes). The pairs of boxes are nearly
//! parallel, and overlap by far more than the rounding error, so every reported separation is wrong. Each pair is tested by the function
//! that all boxes use, in double and in single precision, in millimetres and in metres. Poses are drawn in double precision; everything
//! after the world frames of the two boxes is computed in the precision under test.

use super::{Amount, GROUPS, chunk_number};
use crate::geometry::separating_axes::separated;
use crate::measure::study::Rows;
use crate::record::manifest::VariantEntry;
use crate::record::rows::CaseKey;
use crate::record::{CaseRow, CountRow, Kind, Stratum};
use nalgebra::{Matrix3, RealField, Vector3};
use obbtree::cases::Draw;
use rayon::prelude::*;

/// Half-lengths of the boxes, mm.
const HALF_MM: [f64; 2] = [0.5, 200.0];
/// Tilt between nearly parallel boxes, radians: from below the resolution of double precision to the tilts of real machines.
const TILT: [f64; 2] = [1e-17, 1e-2];
/// Largest distance of boxes from the world's origin, mm.
const REACH_MM: f64 = 500.0;
/// Depth of the common point in both boxes, as a fraction of the half-lengths: at least 0.005 mm, about a hundred times the rounding error
/// of single precision at [`REACH_MM`] (6e-5 mm).
const INSIDE: f64 = 0.01;
/// Number of pairs for each line of approach of the other sweeps.
const PAIRS_PER_LINE: usize = 1000;

/// The arithmetics: id, label, whether it is double precision, and its units per millimetre.
const ARITHMETICS: [(&str, &str, bool, f64); 4] = [
    ("f64-mm", "double precision, mm", true, 1.0),
    ("f64-m", "double precision, m", true, 1e-3),
    ("f32-mm", "single precision, mm", false, 1.0),
    ("f32-m", "single precision, m", false, 1e-3),
];

/// Two overlapping boxes in the world frame, mm.
struct Pair {
    axes: [Matrix3<f64>; 2],
    centres: [Vector3<f64>; 2],
    halves: [Vector3<f64>; 2],
}

/// The arithmetics, as listed in the manifest and the figure.
pub fn entries() -> Vec<VariantEntry> {
    let entry = |&(id, label, _, _): &(&str, &str, bool, f64)| VariantEntry {
        id: id.to_owned(),
        label: label.to_owned(),
        reference: "separating-axis test of two boxes, Gottschalk, Lin and Manocha 1996".to_owned(),
        safe: true,
        kind: Kind::Control,
        policies: Vec::new(),
    };
    ARITHMETICS.iter().map(entry).collect()
}

fn case_row(&(id, label, _, _): &(&str, &str, bool, f64)) -> CaseRow {
    CaseRow::new(CaseKey::without_tree(id), label, Kind::Control, true)
}

/// The rows of each arithmetic at one ε: one count for each group of pairs.
pub fn rows(scene: &str, epsilon: f64, amount: Amount, seed: u64) -> Rows {
    let pairs = amount.lines * PAIRS_PER_LINE / GROUPS as usize;
    let row = |(arithmetic, group): (usize, u32)| {
        let (id, _, is_double, units_per_mm) = ARITHMETICS[arithmetic];
        let mut draw = Draw::new(seed, &["sweep", "precision"], u64::from(group));
        let is_missed = |pair: &Pair| {
            let in_units = |v: &Vector3<f64>| v * units_per_mm;
            let (centres, halves) = (pair.centres.each_ref().map(in_units), pair.halves.each_ref().map(in_units));
            if is_double {
                is_apart(&pair.axes, &centres, &halves, epsilon)
            } else {
                let single = |v: &Vector3<f64>| v.map(|x| x as f32);
                let axes = pair.axes.each_ref().map(|m| m.map(|x| x as f32));
                is_apart(&axes, &centres.each_ref().map(single), &halves.each_ref().map(single), epsilon as f32)
            }
        };
        let missed = (0..pairs).filter(|_| is_missed(&overlapping(&mut draw))).count() as u64;
        let stratum = Stratum::Colliding;
        let pairs = pairs as u64;
        CountRow {
            poses: pairs,
            queries: pairs,
            volume_tests: pairs,
            touching: pairs,
            missed,
            ..CountRow::new(scene, id, chunk_number(group, stratum), Some(stratum))
        }
    };
    let all: Vec<(usize, u32)> =
        (0..ARITHMETICS.len()).flat_map(|arithmetic| (0..GROUPS).map(move |group| (arithmetic, group))).collect();
    let counts = all.into_par_iter().map(row).collect();
    Rows { cases: ARITHMETICS.iter().map(case_row).collect(), counts, ..Rows::default() }
}

/// Draws two boxes with a common point and nearly parallel axes.
fn overlapping(draw: &mut Draw) -> Pair {
    let half = |draw: &mut Draw| Vector3::from_fn(|_, _| draw.log_uniform(HALF_MM[0], HALF_MM[1]));
    let inside = |draw: &mut Draw, half: &Vector3<f64>| half.map(|h| (1.0 - INSIDE) * h * draw.signed_unit());
    let first = draw.rotation();
    let tilt = nalgebra::UnitQuaternion::from_axis_angle(&draw.direction(), draw.log_uniform(TILT[0], TILT[1]));
    let axes = [first, first * tilt].map(|turn| turn.to_rotation_matrix().into_inner());
    let halves = [half(draw), half(draw)];
    let centre = draw.in_ball() * REACH_MM;
    let common = centre + axes[0] * inside(draw, &halves[0]);
    let other = common - axes[1] * inside(draw, &halves[1]);
    Pair { axes, centres: [centre, other], halves }
}

/// The separating-axis test in one arithmetic, starting from the world frames of the boxes.
fn is_apart<T: RealField + Copy>(
    axes: &[Matrix3<T>; 2],
    centres: &[Vector3<T>; 2],
    halves: &[Vector3<T>; 2],
    epsilon: T,
) -> bool {
    let r = axes[0].tr_mul(&axes[1]);
    let t = axes[0].tr_mul(&(centres[1] - centres[0]));
    separated(&t, &r, &r.map(|x| x.abs() + epsilon), &halves[0], &halves[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const AMOUNT: Amount = Amount { lines: 24, blocks: 1, density: 0.5 };

    fn missed(epsilon: f64) -> Vec<u64> {
        let rows = rows("precision", epsilon, AMOUNT, 1).counts;
        let of =
            |(id, ..): &(&str, &str, bool, f64)| rows.iter().filter(|row| row.case == *id).map(|row| row.missed).sum();
        ARITHMETICS.iter().map(of).collect()
    }

    #[test]
    fn without_epsilon_overlaps_are_lost_and_with_enough_none() {
        let none = missed(0.0);
        assert!(none.iter().all(|missed| *missed > 0), "{none:?}");
        // 1e-12 is enough for double precision and nothing for single; 1e-5 is enough for both.
        let small = missed(1e-12);
        assert!(small[..2] == [0, 0] && small[2] > 0 && small[3] > 0, "{small:?}");
        assert_eq!(missed(1e-5), [0; 4]);
    }

    /// The common point is inside both boxes, so they overlap.
    #[test]
    fn drawn_boxes_overlap() {
        let mut draw = Draw::new(1, &["precision test"], 0);
        for _ in 0..1000 {
            let pair = overlapping(&mut draw);
            let tilt = (pair.axes[0].tr_mul(&pair.axes[1]) - Matrix3::identity()).amax();
            assert!(tilt < 1.5e-2);
            // Of the other centre's coordinates none is farther than both boxes reach, with the tilt.
            let t = pair.axes[0].tr_mul(&(pair.centres[1] - pair.centres[0]));
            let reach = pair.halves[0] + pair.halves[1] + Vector3::repeat(pair.halves[1].sum() * 1.5e-2);
            assert!((0..3).all(|i| t[i].abs() < reach[i]));
        }
    }
}
