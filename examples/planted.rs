//! A variant with a planted slow-down: the area-weighted box that asks again at 3 of 100 poses, and beside it the same that asks again at none. A protocol
//! that cannot tell the two apart cannot tell anything of that size; `scripts/power` asks.
//! The area-weighted box of the registry is no fair original, since the detour of every call through this file has a price of its own.
//!
//! ```sh
//! cargo run --release --example planted -- stage measure --scene lathe-tailstock --variant obb-area --variant obb-area-asked --variant obb-area-slow --out results/planted
//! ```
//!
//! The poses that are asked again change from call to call, so that over many passes every pose is, equally often. They are asked after all
//! others of the call, where they find in the caches what those left. Answers and counts are the original's.

use bvbench::geometry::{Isometry, Mesh};
use bvbench::method::{Kind, Model};
use bvbench::registry::{self, Variant};
use bvbench::tree::distance::Proximity;
use bvbench::tree::tightness::TreeReport;
use bvbench::tree::traverse::Counts;
use bvbench::tree::{Policy, SplitRule};
use bvbench::volume::Info;
use bvbench::volume::obb_area::ObbArea;
use std::any::Any;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

/// Multiples of the golden ratio modulo 1 fill the unit interval evenly, wherever they begin: here in units of 2^-64.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A model that asks again at so many of 100 poses.
struct Asked<const PERCENT: u64> {
    original: Box<dyn Model>,
    /// Poses asked so far.
    asked: AtomicU64,
}

impl<const PERCENT: u64> Asked<PERCENT> {
    fn variant(id: &'static str, label: &'static str) -> Variant {
        let info = Info { id, label, reference: "a planted effect (examples/planted.rs)", safe: true };
        let mut variant = Variant::without_tree(info, Kind::Volume, Self::prepare);
        variant.policy = Some(Policy::own(SplitRule::AreaMean));
        variant
    }

    fn prepare(mesh: &Mesh, policy: Policy) -> Box<dyn Model> {
        let original = Variant::of::<ObbArea>(SplitRule::AreaMean).prepare(mesh, Some(policy));
        Box::new(Self { original, asked: AtomicU64::new(0) })
    }

    /// Whether the pose of this number is asked again.
    const fn is_asked_again(number: u64) -> bool {
        number.wrapping_mul(GOLDEN) < PERCENT * (u64::MAX / 100)
    }

    /// The original behind a model of this variant.
    fn original(other: &dyn Model) -> &dyn Model {
        let any: &dyn Any = other;
        any.downcast_ref::<Self>().map_or(other, |asked| asked.original.as_ref())
    }
}

impl<const PERCENT: u64> Model for Asked<PERCENT> {
    fn first(&self, other: &dyn Model, a_from_b: &[Isometry], verdicts: &mut Vec<bool>) {
        let other = Self::original(other);
        self.original.first(other, a_from_b, verdicts);
        let start = self.asked.fetch_add(a_from_b.len() as u64, Ordering::Relaxed);
        let again: Vec<Isometry> = (start..)
            .zip(a_from_b)
            .filter(|(number, _)| Self::is_asked_again(*number))
            .map(|(_, pose)| *pose)
            .collect();
        // A call about nothing has its price too, which would come on top at every pose of a program.
        if again.is_empty() {
            return;
        }
        let before = verdicts.len();
        self.original.first(other, &again, verdicts);
        verdicts.truncate(std::hint::black_box(before));
    }

    fn first_given(
        &self,
        other: &dyn Model,
        a_from_b: &[Isometry],
        witnesses: &[Option<(u32, u32)>],
        verdicts: &mut Vec<bool>,
    ) {
        self.original.first_given(Self::original(other), a_from_b, witnesses, verdicts);
    }

    fn first_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (bool, Counts) {
        self.original.first_counted(Self::original(other), a_from_b)
    }

    fn all_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (Vec<(u32, u32)>, Counts) {
        self.original.all_counted(Self::original(other), a_from_b)
    }

    fn distance_mm(&self, other: &dyn Model, a_from_b: &Isometry, below_mm: f64, proximity: &mut Proximity) -> f64 {
        self.original.distance_mm(Self::original(other), a_from_b, below_mm, proximity)
    }

    fn bytes(&self) -> usize {
        self.original.bytes()
    }

    fn tree_report(&self) -> Option<TreeReport> {
        self.original.tree_report()
    }
}

fn main() -> ExitCode {
    let registry = registry::standard()
        .with(Asked::<0>::variant("obb-area-asked", "area-weighted OBB, asked once"))
        .with(Asked::<3>::variant("obb-area-slow", "area-weighted OBB, 3 % slower"));
    bvbench::cli::main_with(registry)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the poses of any 1000 passes over a chunk three of a hundred are asked again, and of each pose as many as of the others: some 30.
    #[test]
    fn three_of_a_hundred_are_asked_again_and_every_pose_equally_often() {
        for poses in [16, 400, 1000] {
            let mut again = vec![0_u32; poses];
            (0..1000 * poses)
                .filter(|&number| Asked::<3>::is_asked_again(number as u64))
                .for_each(|number| again[number % poses] += 1);
            let share = f64::from(again.iter().sum::<u32>()) / (1000 * poses) as f64;
            assert!((share - 0.03).abs() < 1e-3, "{poses} poses: {share}");
            assert!(again.iter().all(|count| (20..=40).contains(count)), "{poses} poses: {again:?}");
        }
    }
}
