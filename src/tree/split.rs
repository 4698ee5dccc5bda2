//! Split rules: how a node's triangles are divided in two, independent of the volume that surrounds them.
//!
//! The rule picks a place along the longest axis and every triangle goes to the side of its centroid. When that leaves a
//! side empty the next axis is tried; when all three fail, as for triangles with one common centroid, the list is halved.

use super::policy::SplitRule;
use crate::geometry::{Triangle, Vector, covariance, triangle};
use nalgebra::Unit;

/// A triangle on its way into the tree.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// The triangle, mm, mesh frame.
    pub triangle: Triangle,
    /// Its face number in the mesh.
    pub face: u32,
}

/// Number of bins of [`SplitRule::Sah16`].
const BINS: usize = 16;

/// Divides `items` (at least two) in place and returns how many went left: at least one, and not all. `axes` are
/// orthogonal, longest first. Within each side the order of `items` is kept, so that the result depends on nothing else.
pub fn divide(items: &mut [Item], rule: SplitRule, axes: &[Unit<Vector>; 3]) -> usize {
    if rule == SplitRule::Sah16 {
        if let Some((axis, threshold)) = cheapest_bin_boundary(items, axes)
            && let Some(left) = partition(items, |t| along(t, &axes[axis]) < threshold)
        {
            return left;
        }
        return halve(items, &axes[0]);
    }
    if rule == SplitRule::Median {
        return halve(items, &axes[0]);
    }
    for axis in axes {
        let threshold = threshold_along(items, rule, axis);
        if let Some(left) = partition(items, |t| along(t, axis) <= threshold) {
            return left;
        }
    }
    halve(items, &axes[0])
}

/// The coordinate of a triangle's centroid along a direction, mm.
fn along(triangle: &Triangle, axis: &Unit<Vector>) -> f64 {
    triangle.centroid().coords.dot(axis)
}

/// Where a mean or midpoint rule divides, mm along `axis`.
fn threshold_along(items: &[Item], rule: SplitRule, axis: &Unit<Vector>) -> f64 {
    let centroid_mean = || items.iter().map(|i| along(&i.triangle, axis)).sum::<f64>() / items.len() as f64;
    match rule {
        SplitRule::AreaMean => {
            let (mut area, mut moment) = (0.0, 0.0);
            for item in items {
                let weight = item.triangle.area();
                area += weight;
                moment += weight * along(&item.triangle, axis);
            }
            if area > 0.0 { moment / area } else { centroid_mean() }
        }
        SplitRule::Midpoint => {
            let (low, high) = extent(items.iter().flat_map(|i| &i.triangle.corners).map(|p| p.coords.dot(axis)));
            f64::midpoint(low, high)
        }
        // The mean of the corners is the mean of the centroids: every triangle has three corners.
        SplitRule::VertexMean | SplitRule::Median | SplitRule::Sah16 => centroid_mean(),
    }
}

/// Smallest and largest of some numbers; (∞, -∞) of none.
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// Moves the items for which `is_left` holds to the front, keeping the order on both sides; `None`, with nothing moved,
/// when one side would be empty.
fn partition(items: &mut [Item], is_left: impl Fn(&Triangle) -> bool) -> Option<usize> {
    let (left, right): (Vec<Item>, Vec<Item>) = items.iter().partition(|item| is_left(&item.triangle));
    if left.is_empty() || right.is_empty() {
        return None;
    }
    items[..left.len()].copy_from_slice(&left);
    items[left.len()..].copy_from_slice(&right);
    Some(left.len())
}

/// Sorts by centroid along `axis` (ties by face) and cuts the list in the middle.
fn halve(items: &mut [Item], axis: &Unit<Vector>) -> usize {
    items.sort_by(|a, b| along(&a.triangle, axis).total_cmp(&along(&b.triangle, axis)).then(a.face.cmp(&b.face)));
    items.len() / 2
}

/// The bin boundary with the smallest surface-area cost: the axis' index and the coordinate, mm. `None` when all
/// centroids coincide.
///
/// The cost of a cut is count × box area, summed over both sides (Goldsmith and Salmon 1987; binned by Wald 2007), with
/// boxes along `axes`.
fn cheapest_bin_boundary(items: &[Item], axes: &[Unit<Vector>; 3]) -> Option<(usize, f64)> {
    let frame = covariance::frame_of(axes);
    let mut best: Option<(f64, usize, f64)> = None;
    for axis in 0..3 {
        let (low, high) = extent(items.iter().map(|i| along(&i.triangle, &axes[axis])));
        if high <= low {
            continue;
        }
        let width = (high - low) / BINS as f64;
        let mut bins: [Option<(usize, Vector, Vector)>; BINS] = [None; BINS];
        for item in items {
            let bin = (((along(&item.triangle, &axes[axis]) - low) / width) as usize).min(BINS - 1);
            let (l, h) = item
                .triangle
                .corners
                .iter()
                .map(|p| frame.tr_mul(&p.coords))
                .fold((Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)), |(l, h), x| {
                    (l.inf(&x), h.sup(&x))
                });
            bins[bin] = merge(bins[bin], Some((1, l, h)));
        }
        let mut right = [None; BINS + 1];
        for bin in (0..BINS).rev() {
            right[bin] = merge(bins[bin], right[bin + 1]);
        }
        let mut left = None;
        for boundary in 1..BINS {
            left = merge(left, bins[boundary - 1]);
            if let (Some(l), Some(r)) = (left, right[boundary]) {
                let cost = weighted_area(&l) + weighted_area(&r);
                if best.is_none_or(|(cheapest, ..)| cost < cheapest) {
                    best = Some((cost, axis, low + width * boundary as f64));
                }
            }
        }
    }
    best.map(|(_, axis, threshold)| (axis, threshold))
}

/// Count, low and high corner of two bins together.
fn merge(a: Option<(usize, Vector, Vector)>, b: Option<(usize, Vector, Vector)>) -> Option<(usize, Vector, Vector)> {
    match (a, b) {
        (Some((n, low, high)), Some((m, l, h))) => Some((n + m, low.inf(&l), high.sup(&h))),
        (one, None) | (None, one) => one,
    }
}

/// Triangle count times half the surface area of the box.
fn weighted_area((count, low, high): &(usize, Vector, Vector)) -> f64 {
    let d = high - low;
    *count as f64 * (d.x * d.y + d.y * d.z + d.z * d.x)
}

/// The axes of the area-weighted covariance, ordered by the extent of the triangles along them: what
/// [`super::policy::Axes::Shared`] splits along.
#[must_use]
pub fn shared_axes(triangles: &[Triangle]) -> [Unit<Vector>; 3] {
    let frame = covariance::principal_frame(&covariance::area_weighted(triangles).1);
    let mut order = [0, 1, 2].map(|column| {
        let axis = Unit::new_unchecked(frame.column(column).into_owned());
        let (low, high) = extent(triangle::corners(triangles).map(|p| p.coords.dot(&axis)));
        (high - low, axis)
    });
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    order.map(|(_, axis)| axis)
}
