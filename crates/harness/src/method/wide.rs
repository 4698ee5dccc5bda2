//! Methods that test eight volumes at a time, with the trees of [`obbtree`].

use super::wide_shape::{drawn, report};
use super::{Model, same};
use crate::geometry::Isometry;
use crate::tree::distance::Proximity;
use crate::tree::levels::Drawn;
use crate::tree::tightness::TreeReport;
use crate::tree::traverse::Counts;
use crate::tree::validate::TreeFault;
use crate::volume::Info;
use obbtree::engine::traverse::{self, Scratch};
use obbtree::engine::{Coherence, Memory, Simd, WideTree, WideVolume, distance};
use std::cell::RefCell;

thread_local! {
    /// Memory that the queries of a thread reuse, as those of [`obbtree::Collider`] do, so that single queries allocate nothing.
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Trees of oriented boxes.
pub const ORIENTED: Info = Info {
    id: "obb-wide",
    label: "OBB, 8-wide nodes",
    reference: "Gottschalk, Lin and Manocha 1996, on vectors of eight boxes; least-surface frames",
    safe: true,
};
/// Trees of boxes along the axes.
pub const ALIGNED: Info = Info {
    id: "aabb-wide",
    label: "AABB, 8-wide nodes",
    reference: "G. van den Bergen 1997, on vectors of eight boxes",
    safe: true,
};
/// Trees of balls.
pub const BALL: Info = Info {
    id: "sphere-wide",
    label: "sphere, 8-wide nodes",
    reference: "P. M. Hubbard 1996, on vectors of eight spheres",
    safe: true,
};

impl<V: WideVolume> Model for WideTree<V> {
    fn first(&self, other: &dyn Model, a_from_b: &[Isometry], verdicts: &mut Vec<bool>) {
        let (other, simd) = (same::<Self>(other), Simd::in_use());
        SCRATCH.with_borrow_mut(|scratch| {
            verdicts.extend(a_from_b.iter().map(|pose| traverse::first(self, other, pose, simd, scratch)));
        });
    }

    fn along(
        &self,
        other: &dyn Model,
        a_from_b: &[Isometry],
        coherence: Coherence,
        memory: &mut Memory,
        verdicts: &mut Vec<bool>,
    ) {
        let (other, simd) = (same::<Self>(other), Simd::in_use());
        verdicts.extend(a_from_b.iter().map(|pose| memory.first(self, other, pose, simd, coherence)));
    }

    fn first_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (bool, Counts) {
        SCRATCH.with_borrow_mut(|scratch| {
            let verdict = traverse::first(self, same(other), a_from_b, Simd::in_use(), scratch);
            (verdict, scratch.counts())
        })
    }

    fn all_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (Vec<(u32, u32)>, Counts) {
        SCRATCH.with_borrow_mut(|scratch| {
            let contacts = traverse::all(self, same(other), a_from_b, Simd::in_use(), scratch);
            (contacts, scratch.counts())
        })
    }

    fn distance_mm(&self, other: &dyn Model, a_from_b: &Isometry, below_mm: f64, proximity: &mut Proximity) -> f64 {
        distance::distance_mm(self, same(other), a_from_b, Simd::in_use(), below_mm, proximity)
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }

    fn tree_report(&self) -> Option<TreeReport> {
        Some(report(self))
    }

    fn drawn(&self, levels: u32) -> Vec<Drawn> {
        drawn(self, levels)
    }

    fn check_structure(&self) -> Result<(), TreeFault> {
        self.check_structure()
    }

    fn check_containment(&self, slack_mm: f64) -> Result<(), TreeFault> {
        self.check_containment(slack_mm)
    }
}
