//! Posed colliders with boxes around them, and which pairs may touch: sort and sweep along one axis (D. Baraff, 1992).
//!
//! A sweep of a few lines, not a library's tree: the crate brings at most 25 crates, and the smallest maintained tree that would do (`rstar` 0.14) adds eight to
//! its 22, `parry3d-f64` more still.

use crate::collider::Collider;
use crate::mesh::power_of_two;
use nalgebra::{Isometry3, Point3, Vector3};
use std::ops::RangeInclusive;

/// What rounding may do to a corner: of a pose, relative to the coordinates involved.
const ROUNDING: f64 = power_of_two(-44);
/// The same of the engine's grid, as an exponent of two relative to its unit: more than three times half the diagonal of a cell.
const GRID: i32 = -24;
/// Squared lengths whose root is right: above them squares overflow, and below them small components are lost.
const PLAIN_SQUARES: RangeInclusive<f64> = 1e-250..=f64::MAX;

/// A posed collider.
#[derive(Clone, Debug)]
pub(crate) struct Item<'a> {
    pub name: &'a str,
    pub collider: &'a Collider,
    pub pose: Isometry3<f64>,
    pub bounds: Bounds,
}

impl<'a> Item<'a> {
    pub fn new(name: &'a str, collider: &'a Collider, pose: Isometry3<f64>) -> Self {
        Self { name, collider, pose, bounds: Bounds::new(collider, &pose) }
    }
}

/// A box along the axes of the world that contains a posed mesh, as the engine sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl Bounds {
    pub fn new(collider: &Collider, pose: &Isometry3<f64>) -> Self {
        let [low, high] = collider.bounds();
        let middle = pose * nalgebra::center(&low, &high);
        let turn = pose.rotation.to_rotation_matrix().into_inner().abs();
        let largest = low.coords.amax().max(high.coords.amax()) + pose.translation.vector.amax();
        let pad = ROUNDING * largest + power_of_two(collider.frame().exponent + GRID);
        let half = turn * ((high - low) * 0.5) + Vector3::repeat(pad);
        Self { low: middle - half, high: middle + half }
    }

    /// The smallest that contains both.
    pub fn joined(self, other: Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Its longest edge.
    pub fn size(&self) -> f64 {
        (self.high - self.low).amax()
    }

    /// No point of one is nearer to a point of the other.
    pub fn gap(&self, other: &Self) -> f64 {
        let way = (self.low - other.high).sup(&(other.low - self.high)).sup(&Vector3::zeros());
        let squared = way.norm_squared();
        if PLAIN_SQUARES.contains(&squared) { squared.sqrt() } else { scaled_norm(&way) }
    }
}

/// The length of a vector whose squares may overflow or underflow.
fn scaled_norm(way: &Vector3<f64>) -> f64 {
    let largest = way.amax();
    if largest > 0.0 { (way / largest).norm() * largest } else { 0.0 }
}

/// The pairs of numbers `i < j` whose bounds are no more than `reach` apart, in order.
pub(crate) fn near(items: &[Item], reach: f64) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    sweep_within(items, reach, |pair, _| {
        pairs.push(pair);
        reach
    });
    pairs.sort_unstable();
    pairs
}

/// The same of pairs (number in `ours`, number in `theirs`).
pub(crate) fn near_between(ours: &[Item], theirs: &[Item], reach: f64) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    sweep_between(ours, theirs, reach, |pair, _| {
        pairs.push(pair);
        reach
    });
    pairs.sort_unstable();
    pairs
}

/// The least gap between the bounds of two items whose pair is `wanted`, without a list of pairs; `None` where there is no such pair.
pub(crate) fn least_gap(items: &[Item], wanted: impl Fn(usize, usize) -> bool) -> Option<f64> {
    let mut least = None;
    sweep_within(items, f64::INFINITY, |(i, j), gap| lessen(&mut least, gap, wanted(i, j)));
    least
}

/// The same of pairs (number in `ours`, number in `theirs`).
pub(crate) fn least_gap_between(ours: &[Item], theirs: &[Item], wanted: impl Fn(usize, usize) -> bool) -> Option<f64> {
    let mut least = None;
    sweep_between(ours, theirs, f64::INFINITY, |(i, j), gap| lessen(&mut least, gap, wanted(i, j)));
    least
}

/// Takes a gap that is no larger than the least so far, if it is wanted. The least then.
fn lessen(least: &mut Option<f64>, gap: f64, is_wanted: bool) -> f64 {
    if is_wanted {
        *least = Some(gap);
    }
    least.unwrap_or(f64::INFINITY)
}

fn sweep_within(items: &[Item], reach: f64, meet: impl FnMut((usize, usize), f64) -> f64) {
    sweep(items.len(), |i| &items[i].bounds, |_, _| true, reach, meet);
}

fn sweep_between(ours: &[Item], theirs: &[Item], reach: f64, mut meet: impl FnMut((usize, usize), f64) -> f64) {
    let bounds = |i: usize| if i < ours.len() { &ours[i].bounds } else { &theirs[i - ours.len()].bounds };
    let wanted = |i: usize, j: usize| i < ours.len() && ours.len() <= j;
    sweep(ours.len() + theirs.len(), bounds, wanted, reach, |(i, j), gap| meet((i, j - ours.len()), gap));
}

/// Calls `meet` with each wanted pair of numbers `i < j` whose bounds are no more than `reach` apart, and with their gap; it returns the reach from there on,
/// which is no larger.
fn sweep<'a>(
    count: usize,
    bounds: impl Fn(usize) -> &'a Bounds,
    wanted: impl Fn(usize, usize) -> bool,
    mut reach: f64,
    mut meet: impl FnMut((usize, usize), f64) -> f64,
) {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&i, &j| bounds(i).low.x.total_cmp(&bounds(j).low.x));
    let mut open = Vec::<usize>::new();
    for next in order {
        // The difference that is part of the gap, so that rounding drops no pair that is in reach.
        open.retain(|&i| bounds(next).low.x - bounds(i).high.x <= reach);
        for &i in &open {
            let pair = (i.min(next), i.max(next));
            if wanted(pair.0, pair.1) {
                let gap = bounds(i).gap(bounds(next));
                if gap <= reach {
                    reach = meet(pair, gap);
                }
            }
        }
        open.push(next);
    }
}
