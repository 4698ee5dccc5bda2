//! The sweep of the separating-axis test's ε: how many pairs of boxes that overlap does rounding take for apart?
//!
//! When two edges are nearly parallel their product is nearly zero, and with it both sides of the inequality along it; what
//! rounding leaves then decides, unless ε is added to every |R_ij| (Gottschalk 2000, section on degenerate axes). Pairs of boxes
//! are drawn nearly parallel and overlapping by far more than rounding could undo, so that every separation is wrong.
//! Each is tested by the one function all boxes use, in double and in single precision, in millimetres and in metres: the
//! poses are drawn in double precision, and everything from the two boxes' world frames on is computed in the
//! precision under trial.

use super::{Amount, GROUPS, chunk_number};
use crate::measure::study::Rows;
use crate::record::manifest::VariantEntry;
use crate::record::rows::CaseKey;
use crate::record::{CaseRow, CountRow, Kind, Stratum};
use crate::volume::shape::separating_axes::separated;
use nalgebra::{Matrix3, RealField, Vector3};
use obbtree::cases::Draw;
use rayon::prelude::*;

/// Half-lengths of the boxes, mm.
const HALF_MM: [f64; 2] = [0.5, 200.0];
/// Tilt between nearly parallel boxes, radians: from below what double precision can tell to what a machine may have.
const TILT: [f64; 2] = [1e-17, 1e-2];
/// How far from the world's origin boxes lie, mm.
const REACH_MM: f64 = 500.0;
/// The point the boxes share lies this part of the half-lengths inside both: at least 0.005 mm, of which single precision at
/// [`REACH_MM`] (6e-5 mm) loses about a hundredth.
const INSIDE: f64 = 0.01;
/// Pairs for each line of approach that the other sweeps have.
const PAIRS_PER_LINE: usize = 1000;

/// An arithmetic: its name, whether it is double precision, and its units in a millimetre.
const ARITHMETICS: [(&str, &str, bool, f64); 4] = [
    ("f64-mm", "double precision, mm", true, 1.0),
    ("f64-m", "double precision, m", true, 1e-3),
    ("f32-mm", "single precision, mm", false, 1.0),
    ("f32-m", "single precision, m", false, 1e-3),
];

/// Two boxes in the world, mm, that overlap.
struct Pair {
    axes: [Matrix3<f64>; 2],
    centres: [Vector3<f64>; 2],
    halves: [Vector3<f64>; 2],
}

/// The arithmetics as the manifest and the figure name them.
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

/// The arithmetics, and a count for each of them and each group of pairs, at one ε.
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

/// Two boxes with a point in common, their axes nearly parallel.
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

/// The separating-axis test from the boxes' world frames on, in one arithmetic.
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

    /// The shared point is inside both boxes, so that they do overlap.
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
