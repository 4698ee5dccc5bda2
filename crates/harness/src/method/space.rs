//! Spatial decomposition as methods: the grid and the octree of [`crate::space`].

use super::{Model, same};
use crate::geometry::Isometry;
use crate::space::grid::{self, Grid};
use crate::space::octree::{self, Octree};
use crate::tree::distance::Proximity;
use crate::tree::tightness::TreeReport;
use crate::tree::traverse::{Counts, NoProbe};
use crate::volume::Info;
use std::ops::ControlFlow;

/// Name and reference of the grid.
pub const GRID: Info = Info {
    id: "uniform-grid",
    label: "uniform grid",
    reference: "spatial decomposition: Cleary and Wyvill 1988, five voxels per triangle, a grid per mesh",
    safe: true,
};

/// Name and reference of the octree.
pub const OCTREE: Info = Info {
    id: "triangle-octree",
    label: "octree of triangles",
    reference: "spatial decomposition: Meagher 1982, leaves of at most eight triangles, an octree per mesh",
    safe: true,
};

/// Implements [`Model`] for the grid and the octree, whose queries differ only in names.
macro_rules! answer_by_visiting {
    ($structure:ty, $scratch:ty, $report:expr) => {
        impl Model for $structure {
            fn first(&self, other: &dyn Model, a_from_b: &[Isometry], verdicts: &mut Vec<bool>) {
                let (other, mut scratch): (&Self, _) = (same(other), <$scratch>::default());
                verdicts.extend(a_from_b.iter().map(|pose| {
                    self.visit(other, pose, &mut scratch, &mut NoProbe, |_, _| ControlFlow::Break(())).is_break()
                }));
            }

            /// A contact is reported only after the shared test of two triangles: without a witness the answer is no.
            fn first_given(
                &self,
                other: &dyn Model,
                a_from_b: &[Isometry],
                witnesses: &[Option<(u32, u32)>],
                verdicts: &mut Vec<bool>,
            ) {
                let (other, mut scratch): (&Self, _) = (same(other), <$scratch>::default());
                let stop = |_, _| ControlFlow::Break(());
                verdicts.extend(a_from_b.iter().zip(witnesses).map(|(pose, witness)| {
                    witness.is_some() && self.visit(other, pose, &mut scratch, &mut NoProbe, stop).is_break()
                }));
            }

            fn first_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (bool, Counts) {
                let (mut counts, mut scratch) = (Counts::default(), <$scratch>::default());
                let stop = |_, _| ControlFlow::Break(());
                (self.visit(same(other), a_from_b, &mut scratch, &mut counts, stop).is_break(), counts)
            }

            fn all_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (Vec<(u32, u32)>, Counts) {
                let (mut counts, mut contacts) = (Counts::default(), Vec::new());
                let _ = self.visit(same(other), a_from_b, &mut <$scratch>::default(), &mut counts, |mine, theirs| {
                    contacts.push((mine, theirs));
                    ControlFlow::<()>::Continue(())
                });
                contacts.sort_unstable();
                contacts.dedup();
                (contacts, counts)
            }

            fn distance_mm(&self, other: &dyn Model, a_from_b: &Isometry, below_mm: f64, _: &mut Proximity) -> f64 {
                self.distance_mm(same(other), a_from_b, below_mm)
            }

            fn bytes(&self) -> usize {
                self.bytes()
            }

            fn tree_report(&self) -> Option<TreeReport> {
                Some($report(self))
            }
        }
    };
}

answer_by_visiting!(Grid, grid::Scratch, |grid: &Grid| TreeReport {
    nodes: grid.voxel_count() + 1,
    leaves: grid.occupied().count(),
    depth_max: 1,
    depth_mean: 1.0,
    sah_cost: 1.0 + grid.relative_area(),
    ..TreeReport::not_binary()
});

answer_by_visiting!(Octree, octree::Scratch, |tree: &Octree| {
    let (leaves, depth_max, depth_mean) = tree.leaves();
    let (nodes, sah_cost) = (tree.octant_count(), tree.relative_area());
    TreeReport { nodes, leaves, depth_max, depth_mean, sah_cost, ..TreeReport::not_binary() }
});
