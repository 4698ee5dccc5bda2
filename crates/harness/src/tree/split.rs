//! Split rules: how a node's triangles are divided in two, independent of the volume around them.
//!
//! The rule chooses a position along the longest axis, and every triangle goes to the side of its centroid. If that leaves a side empty,
//! the next axis is tried. If all three axes fail, as for triangles with one common centroid, the list is halved. The surface-area
//! heuristic tries the given axes and those of the mesh, along which most surfaces of a machine part lie.

use super::policy::SplitRule;
use crate::geometry::{Triangle, Vector, covariance, triangle};
use nalgebra::Unit;

/// A triangle on its way into the tree.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// The triangle, mm, mesh frame.
    pub triangle: Triangle,
    /// Face number of the triangle in the mesh.
    pub face: u32,
}

/// Number of bins of [`SplitRule::Sah16`].
const BINS: usize = 16;

/// Divides `items` (at least two) in place and returns the number on the left: at least one, and not all. `axes` are orthogonal, longest
/// extent first. The order of `items` is kept within each side, so the result depends on nothing but the input.
pub fn divide(items: &mut [Item], rule: SplitRule, axes: &[Unit<Vector>; 3]) -> usize {
    if rule == SplitRule::Sah16 {
        let mesh_axes = [Vector::x_axis(), Vector::y_axis(), Vector::z_axis()];
        let own = cheapest_bin_boundary(items, axes);
        let cheapest = match cheapest_bin_boundary(items, &mesh_axes) {
            Some(mesh) if own.as_ref().is_none_or(|own| mesh.cost < own.cost) => Some(mesh),
            _ => own,
        };
        if let Some(Boundary { axis, threshold, .. }) = cheapest
            && let Some(left) = partition(items, |t| along(t, &axis) < threshold)
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

/// Position at which a mean or midpoint rule divides, mm, along `axis`.
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

/// Smallest and largest of the values; (∞, -∞) without values.
fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// Moves the items for which `is_left` holds to the front and returns their number; the order is kept on both sides. `None`, with nothing
/// moved, when one side would be empty.
fn partition(items: &mut [Item], is_left: impl Fn(&Triangle) -> bool) -> Option<usize> {
    let (left, right): (Vec<Item>, Vec<Item>) = items.iter().partition(|item| is_left(&item.triangle));
    if left.is_empty() || right.is_empty() {
        return None;
    }
    items[..left.len()].copy_from_slice(&left);
    items[left.len()..].copy_from_slice(&right);
    Some(left.len())
}

/// Sorts by centroid along `axis` (ties by face) and divides the list in the middle.
fn halve(items: &mut [Item], axis: &Unit<Vector>) -> usize {
    items.sort_by(|a, b| along(&a.triangle, axis).total_cmp(&along(&b.triangle, axis)).then(a.face.cmp(&b.face)));
    items.len() / 2
}

/// A boundary between bins: centroids with a coordinate along `axis` below `threshold`, mm, are on the left.
struct Boundary {
    /// Triangle count times half the box area, summed over both sides, mm².
    cost: f64,
    axis: Unit<Vector>,
    threshold: f64,
}

/// The bin boundary with the smallest surface-area cost. `None` when all centroids coincide.
///
/// The cost of a cut is count × box area, summed over both sides (Goldsmith and Salmon 1987; binned by Wald 2007), with
/// boxes along `axes`.
fn cheapest_bin_boundary(items: &[Item], axes: &[Unit<Vector>; 3]) -> Option<Boundary> {
    let frame = covariance::frame_of(axes);
    let mut best: Option<Boundary> = None;
    for direction in axes {
        let (low, high) = extent(items.iter().map(|i| along(&i.triangle, direction)));
        if high <= low {
            continue;
        }
        let width = (high - low) / BINS as f64;
        let mut bins: [Option<(usize, Vector, Vector)>; BINS] = [None; BINS];
        for item in items {
            let bin = (((along(&item.triangle, direction) - low) / width) as usize).min(BINS - 1);
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
                if best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(Boundary { cost, axis: *direction, threshold: low + width * boundary as f64 });
                }
            }
        }
    }
    best
}

/// Union of two bins: count, and low and high corner.
fn merge(a: Option<(usize, Vector, Vector)>, b: Option<(usize, Vector, Vector)>) -> Option<(usize, Vector, Vector)> {
    match (a, b) {
        (Some((n, low, high)), Some((m, l, h))) => Some((n + m, low.inf(&l), high.sup(&h))),
        (one, None) | (None, one) => one,
    }
}

/// Triangle count times half the surface area of the bin's box.
fn weighted_area((count, low, high): &(usize, Vector, Vector)) -> f64 {
    let d = high - low;
    *count as f64 * (d.x * d.y + d.y * d.z + d.z * d.x)
}

/// The axes of the area-weighted covariance, ordered by the extent of the triangles along them; [`super::policy::Axes::Shared`] splits
/// along them.
pub fn shared_axes(triangles: &[Triangle]) -> [Unit<Vector>; 3] {
    let frame = covariance::principal_frame(&covariance::area_weighted(triangles).1);
    let axis = |column: usize| {
        let axis = Unit::new_unchecked(frame.column(column).into_owned());
        let (low, high) = extent(triangle::corners(triangles).map(|p| p.coords.dot(&axis)));
        (high - low, axis)
    };
    let mut order = [axis(0), axis(1), axis(2)];
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    order.map(|(_, axis)| axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use proptest::prelude::*;

    /// Right triangles in planes x = const, with legs `size`, placed so that the centroid is at that x.
    fn items(specification: &[(f64, f64)]) -> Vec<Item> {
        let triangle = |x: f64, size: f64| {
            Triangle::new(Point::new(x, 0.0, 0.0), Point::new(x, size, 0.0), Point::new(x, 0.0, size))
        };
        specification.iter().zip(0..).map(|(&(x, size), face)| Item { triangle: triangle(x, size), face }).collect()
    }

    fn xyz() -> [Unit<Vector>; 3] {
        [Vector::x_axis(), Vector::y_axis(), Vector::z_axis()]
    }

    fn faces(items: &[Item]) -> Vec<u32> {
        items.iter().map(|item| item.face).collect()
    }

    #[test]
    fn the_rules_on_one_row_of_triangles() {
        // x = 0, 1, 2, 9, 10; the second has the area 8 (legs of 4), all others 1/2 (legs of 1).
        let row = items(&[(0.0, 1.0), (1.0, 4.0), (2.0, 1.0), (9.0, 1.0), (10.0, 1.0)]);
        for (rule, left) in [
            (SplitRule::VertexMean, 3), // 22/5 = 4.4
            (SplitRule::AreaMean, 2),   // (8 + (0 + 2 + 9 + 10)/2) / 10 = 1.85
            (SplitRule::Median, 2),     // 5 / 2
            (SplitRule::Midpoint, 3),   // 10 / 2 = 5
            // Two left: 2 (4·4 + 2·1·4) + 3 (1·1 + 2·8·1) = 99; three left: 3 (4·4 + 2·2·4) + 2 (1·1 + 2·1·1) = 102; others more.
            (SplitRule::Sah16, 2),
        ] {
            let mut items = row.clone();
            assert_eq!(divide(&mut items, rule, &xyz()), left, "{rule}");
            assert_eq!(faces(&items), [0, 1, 2, 3, 4], "{rule} keeps the order");
        }
    }

    #[test]
    fn thresholds_are_means_and_the_middle() {
        let row = items(&[(0.0, 1.0), (1.0, 4.0), (2.0, 1.0), (9.0, 1.0), (10.0, 1.0)]);
        for (rule, threshold) in [
            (SplitRule::VertexMean, 4.4),
            (SplitRule::Median, 4.4),
            (SplitRule::AreaMean, 1.85),
            (SplitRule::Midpoint, 5.0),
        ] {
            assert!((threshold_along(&row, rule, &Vector::x_axis()) - threshold).abs() < 1e-12, "{rule}");
        }
    }

    #[test]
    fn sides_keep_their_order() {
        let mut items = items(&[(9.0, 1.0), (0.0, 1.0), (8.0, 1.0), (1.0, 1.0)]);
        assert_eq!(divide(&mut items, SplitRule::Midpoint, &xyz()), 2);
        assert_eq!(faces(&items), [1, 3, 0, 2]);
    }

    #[test]
    fn the_next_axis_is_tried_when_the_first_does_not_divide() {
        // All at x = 5: the mean along x puts everything to the left; along y the centroids are at 1/3 and 4/3.
        let mut items = items(&[(5.0, 4.0), (5.0, 1.0), (5.0, 4.0), (5.0, 1.0)]);
        assert_eq!(divide(&mut items, SplitRule::VertexMean, &xyz()), 2);
        assert_eq!(faces(&items), [1, 3, 0, 2]);
    }

    #[test]
    fn equal_triangles_are_halved() {
        for rule in SplitRule::ALL {
            let mut items = items(&[(5.0, 1.0); 7]);
            assert_eq!(divide(&mut items, rule, &xyz()), 3, "{rule}");
        }
    }

    #[test]
    fn the_surface_area_heuristic_takes_the_cheaper_of_given_and_mesh_axes() {
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector::z_axis(), std::f64::consts::FRAC_PI_4);
        let diagonal = xyz().map(|axis| turn * axis);
        let divided = |is_turned: bool, axes: &[Unit<Vector>; 3]| {
            let place = |n: u32| Point::new(f64::from(n % 2) * 10.0, f64::from(n / 2) * 10.0, 0.0);
            let corner = |p: Point| if is_turned { turn * p } else { p };
            let item = |face: u32| {
                let p = place(face);
                let corners = [p, p + Vector::x(), p + Vector::y()].map(corner);
                Item { triangle: Triangle::new(corners[0], corners[1], corners[2]), face }
            };
            let mut items: Vec<Item> = (0..12).map(item).collect();
            let left = divide(&mut items, SplitRule::Sah16, axes);
            let mut sides = [faces(&items[..left]), faces(&items[left..])];
            sides.sort();
            sides
        };
        // Two columns of six triangles, 10 mm apart: two thin boxes along the columns, wide ones along the diagonals.
        let halves = [0, 1].map(|column| (0..12).filter(|face| face % 2 == column).collect::<Vec<u32>>());
        assert_eq!(divided(false, &xyz()), halves);
        assert_eq!(divided(false, &diagonal), halves, "the mesh's axes are cheaper");
        assert_eq!(divided(true, &diagonal), halves, "the given axes are cheaper");
    }

    #[test]
    fn triangles_without_area_are_divided_by_their_corners() {
        let mut items = items(&[(0.0, 0.0), (1.0, 0.0), (10.0, 0.0)]);
        assert_eq!(divide(&mut items, SplitRule::AreaMean, &xyz()), 2); // 11/3
    }

    #[test]
    fn shared_axes_run_along_the_longest_extent_first() {
        let triangles: Vec<Triangle> =
            items(&[(0.0, 1.0), (30.0, 1.0), (60.0, 2.0)]).iter().map(|i| i.triangle).collect();
        let axes = shared_axes(&triangles);
        assert!(axes[0].x.abs() > 0.99);
        assert!((covariance::frame_of(&axes).determinant().abs() - 1.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn both_sides_get_something_and_nothing_is_lost(
            row in prop::collection::vec((0..4_i32, 0..3_i32), 2..40),
        ) {
            let row: Vec<(f64, f64)> = row.into_iter().map(|(x, size)| (f64::from(x), f64::from(size))).collect();
            for rule in SplitRule::ALL {
                let mut items = items(&row);
                let left = divide(&mut items, rule, &xyz());
                prop_assert!(left > 0 && left < items.len());
                let mut kept = faces(&items);
                kept.sort_unstable();
                prop_assert!(kept.iter().copied().eq(0..row.len() as u32));
            }
        }
    }
}
