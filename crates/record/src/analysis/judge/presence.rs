//! Claims that an effect is present or absent: overhang, drift, and the gap opposite the overhang. Each is counted or computed from the
//! trees and the drawing of their roots, without sampling, so there is no interval.

use super::{CaseKey, Expectation, Finding, Judged, OutlineRow, Verdict, names};
use crate::record::MESH_OUTLINE;
use nalgebra::{Matrix3, Vector3};

/// The gap counts as equal to the overhang when their ratio is within this of 1. The drawing holds only some of the mesh's edges, so the
/// two are rarely exactly equal.
const GAP_TOLERANCE: f64 = 0.1;

/// The verdict on whether the effect is present.
fn presence(present: bool, expected: Expectation) -> Verdict {
    if present == (expected == Expectation::Present) { Verdict::Supported } else { Verdict::Refuted }
}

/// The verdict on whether boxes are displaced toward the dense side, given whether one is displaced to the dense and one to the sparse side.
fn drift_verdict(expected: Expectation, dense: bool, sparse: bool) -> Verdict {
    match expected {
        // Displaced nowhere, or somewhere toward the other side: not as the sentence says.
        Expectation::Present => presence(dense && !sparse, expected),
        // A box that is displaced toward the sparse side is not displaced toward dense triangles.
        Expectation::Absent => presence(dense, expected),
    }
}

impl Judged<'_> {
    pub(super) fn overhang(&self, case: &CaseKey, above_pct: f64, expected: Expectation) -> Finding {
        let Some(worst) = self
            .levels(case)
            .max_by(|a, b| a.outside_corners_pct.total_cmp(&b.outside_corners_pct).then(b.level.cmp(&a.level)))
        else {
            return Finding::not_measured("no tree of this case in this run");
        };
        let reach = self.levels(case).map(|row| row.overhang_mm).fold(0.0, f64::max);
        let root =
            self.levels(case).filter(|row| row.level == 0).map(|row| row.outside_corners_pct).fold(0.0, f64::max);
        let note = format!(
            "worst level {} of {}; at the roots up to {root:.1} %; reaches {reach:.3} mm outside",
            worst.level, worst.part
        );
        let verdict = presence(worst.outside_corners_pct > above_pct, expected);
        Finding::of_trees(verdict, Some(worst.outside_corners_pct), vec![note])
    }

    pub(super) fn drift(&self, case: &CaseKey, above_mm: f64, expected: Expectation) -> Finding {
        let Some(largest) = self.trees(case).max_by(|a, b| a.drift_mm.abs().total_cmp(&b.drift_mm.abs())) else {
            return Finding::not_measured("no tree of this case in this run");
        };
        let displaced = || self.trees(case).filter(|row| row.drift_mm.abs() > above_mm);
        let dense = names(displaced().filter(|row| row.drift_mm > 0.0).map(|row| row.part.as_str()));
        let sparse = names(displaced().filter(|row| row.drift_mm < 0.0).map(|row| row.part.as_str()));
        let verdict = drift_verdict(expected, !dense.is_empty(), !sparse.is_empty());
        let mut note = vec![format!("largest on {}", largest.part)];
        for (parts, side) in [(dense, "dense"), (sparse, "sparse")] {
            if !parts.is_empty() {
                note.push(format!("toward the {side} side: {parts}"));
            }
        }
        Finding::of_trees(verdict, Some(largest.drift_mm), note)
    }

    /// Whether a root box of the case is displaced toward the dense side of its part.
    pub(super) fn drifts_to_the_dense_side(&self, case: &CaseKey, above_mm: f64) -> bool {
        self.trees(case).any(|row| row.drift_mm > above_mm)
    }

    pub(super) fn gap(&self, case: &CaseKey, above_mm: f64, expected: Expectation) -> Finding {
        let mut parts: Vec<&str> = self.drawn(&case.variant).map(|row| row.part.as_str()).collect();
        parts.sort_unstable();
        parts.dedup();
        let displaced = parts.into_iter().filter_map(|part| Some((part, self.displacement(part, &case.variant)?)));
        let Some((part, found)) = displaced.max_by(|a, b| a.1.overhang_mm.total_cmp(&b.1.overhang_mm)) else {
            return Finding::not_measured("no box of this variant was drawn in this run");
        };
        if found.overhang_mm <= above_mm {
            let note = vec!["no corner of a drawn edge lies outside a root box".to_owned()];
            return Finding::of_trees(presence(false, expected), None, note);
        }
        let ratio = found.gap_mm / found.overhang_mm;
        let note = vec![format!("{part}: overhang {:.3} mm, gap {:.3} mm", found.overhang_mm, found.gap_mm)];
        let present = (ratio - 1.0).abs() <= GAP_TOLERANCE;
        Finding::of_trees(presence(present, expected), Some(ratio), note)
    }

    fn drawn<'b>(&'b self, variant: &'b str) -> impl Iterator<Item = &'b OutlineRow> {
        self.evidence.outlines.iter().filter(move |row| row.scene == self.scene_name && row.variant == variant)
    }

    /// The largest overhang of a part's drawn edges over the root box of a variant, and the gap at the opposite side.
    fn displacement(&self, part: &str, variant: &str) -> Option<Displacement> {
        let ends = |variant| self.drawn(variant).filter(|row| row.part == part).flat_map(ends).collect::<Vec<_>>();
        displacement(&ends(variant), &ends(MESH_OUTLINE))
    }
}

/// How far a mesh sticks out of one side of a box, and how far it stays short of the opposite side.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Displacement {
    overhang_mm: f64,
    gap_mm: f64,
}

fn ends(row: &OutlineRow) -> [Vector3<f64>; 2] {
    [Vector3::new(row.x1_mm, row.y1_mm, row.z1_mm), Vector3::new(row.x2_mm, row.y2_mm, row.z2_mm)]
}

/// Measures the displacement. `corners` are the ends of the box's edges, alternately start and end. `None` when they do not form a box, or
/// there is no mesh.
fn displacement(corners: &[Vector3<f64>], mesh: &[Vector3<f64>]) -> Option<Displacement> {
    if corners.is_empty() || mesh.is_empty() {
        return None;
    }
    let centre = corners.iter().sum::<Vector3<f64>>() / corners.len() as f64;
    box_axes(corners)?
        .column_iter()
        .map(|axis| {
            let reach = corners.iter().map(|p| (p - centre).dot(&axis).abs()).fold(0.0, f64::max);
            let along = mesh.iter().map(|p| (p - centre).dot(&axis));
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            let (ahead, behind) = (high - reach, -low - reach);
            Displacement { overhang_mm: ahead.max(behind), gap_mm: -ahead.min(behind) }
        })
        .max_by(|a, b| a.overhang_mm.total_cmp(&b.overhang_mm))
}

/// Three orthogonal unit directions among the edges of a drawn box.
fn box_axes(corners: &[Vector3<f64>]) -> Option<Matrix3<f64>> {
    /// Cosine below which two drawn edges are orthogonal; drawings carry full precision.
    const ORTHOGONAL: f64 = 1e-6;
    let mut axes: Vec<Vector3<f64>> = Vec::new();
    for edge in corners.chunks_exact(2) {
        let Some(direction) = (edge[1] - edge[0]).try_normalize(0.0) else { continue };
        if axes.iter().all(|axis| axis.dot(&direction).abs() < ORTHOGONAL) {
            axes.push(direction);
        }
    }
    (axes.len() == 3).then(|| Matrix3::from_columns(&axes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box(shift: f64) -> Vec<Vector3<f64>> {
        let corner = |i: usize| Vector3::new((i & 1) as f64 + shift, (i >> 1 & 1) as f64, (i >> 2) as f64);
        let edges = (0..8).flat_map(|i| (0..3).filter(move |bit| i >> bit & 1 == 0).map(move |bit| [i, i | 1 << bit]));
        edges.flatten().map(corner).collect()
    }

    /// `No longer displaced toward dense triangles` is refuted by a box that is displaced there, not by one that is displaced the other way.
    #[test]
    fn a_drift_to_the_sparse_side_refutes_a_drift_to_the_dense_one_only() {
        use Expectation::{Absent, Present};
        let verdicts = |expected| {
            [(false, false), (true, false), (false, true), (true, true)]
                .map(|(d, s)| drift_verdict(expected, d, s).id())
        };
        assert_eq!(verdicts(Present), ["refuted", "supported", "refuted", "refuted"]);
        assert_eq!(verdicts(Absent), ["supported", "refuted", "supported", "refuted"]);
    }

    /// A unit box moved by 0.25 along x over contents that fill the unit cube: a quarter outside, a quarter empty.
    #[test]
    fn a_shifted_box_leaves_as_much_empty_as_it_cuts_off() {
        let found = displacement(&unit_box(0.25), &unit_box(0.0)).unwrap();
        assert!((found.overhang_mm - 0.25).abs() < 1e-12 && (found.gap_mm - 0.25).abs() < 1e-12, "{found:?}");
        let tight = displacement(&unit_box(0.0), &unit_box(0.0)).unwrap();
        assert!(tight.overhang_mm.abs() < 1e-12);
        assert_eq!(displacement(&[], &unit_box(0.0)), None);
    }
}
