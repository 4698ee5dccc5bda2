//! How a range of triangles is divided, and which way a box around it is turned.
//!
//! Division: the plane with the least surface-area cost (count times box area, summed over both sides: J. Goldsmith, J. Salmon 1987; bins
//! after I. Wald 2007) among those square to the axes of three frames: the principal one, the mesh's own, and the largest triangle's.
//! Machine parts are mostly boxes and cylinders whose axes are the mesh's; the others find what stands askew. Large ranges are judged by a
//! sample at equal strides, which costs little and depends on nothing but the order of the triangles.
//!
//! Here all is `f32` and without bounds of error: it decides how good the tree is, never whether it is right.

use crate::geometry::{Point, Triangle, covariance};
use nalgebra::{Matrix3, Vector3};

/// Bins per axis, at most.
const BINS: usize = 16;
/// Triangles that a division is judged by, at most.
const SAMPLE: usize = 384;
/// Triangles that a box's frame is judged by, at most.
const FRAME_SAMPLE: usize = 128;

type Corner = [f32; 3];
/// Three axes, as columns padded to four: `frame[k]` holds the k-th coordinates of all axes.
type Columns = [[f32; 4]; 3];

/// A triangle on its way into the tree: its corners relative to the middle of the mesh, mm, and its face number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    corners: [Corner; 3],
    pub face: u32,
}

impl Item {
    pub fn new(triangle: &Triangle, middle: &Point, face: u32) -> Self {
        Self { corners: triangle.corners.map(|p| (p - middle).map(|x| x as f32).into()), face }
    }

    /// The cross product of two edges.
    fn normal(&self) -> Vector3<f32> {
        let [p, q, r] = self.corners.map(Vector3::from);
        (q - p).cross(&(r - p))
    }
}

/// Bounds along three axes as (low, -high), padded to four, so that joining is one minimum; and how many triangles.
#[derive(Clone, Copy)]
struct Bounds([f32; 8], f32);

impl Bounds {
    const EMPTY: Self = Self([f32::MAX; 8], 0.0);

    #[inline(always)]
    fn join(&mut self, other: &Self) {
        for k in 0..8 {
            self.0[k] = if other.0[k] < self.0[k] { other.0[k] } else { self.0[k] };
        }
        self.1 += other.1;
    }

    /// Half of half the surface area; 0 of nothing.
    #[inline(always)]
    fn area(&self) -> f32 {
        if self.1 == 0.0 {
            return 0.0;
        }
        let d = [0, 1, 2].map(|k| -self.0[k] - self.0[k + 4]);
        d[0] * d[1] + d[1] * d[2] + d[2] * d[0]
    }
}

/// A plane: items whose centroid lies below `at` along `axis` are on the left.
struct Cut {
    cost: f32,
    axis: Corner,
    at: f32,
    areas: [f32; 2],
}

/// Divides `items` in place: how many are on the left (at least one, and not all), and the sizes of both sides, which are comparable among
/// divisions of one mesh.
pub(super) fn divide(items: &mut [Item]) -> (usize, [f32; 2]) {
    let stride = items.len().div_ceil(SAMPLE);
    let mut best: Option<Cut> = None;
    for frame in frames(items, stride) {
        cheapest(items, stride, &columns(&frame), &mut best);
    }
    let Some(cut) = best else { return (items.len() / 2, [1.0; 2]) };
    let mut left = 0;
    for i in 0..items.len() {
        if along(&cut.axis, &items[i]) < cut.at {
            items.swap(i, left);
            left += 1;
        }
    }
    if left == 0 || left == items.len() {
        // Rounding, or a sample that misses a few: halves then.
        left = items.len() / 2;
    }
    (left, cut.areas)
}

/// Three times the coordinate of a triangle's centroid along a direction.
#[inline(always)]
fn along(axis: &Corner, item: &Item) -> f32 {
    let sum = |k: usize| item.corners[0][k] + item.corners[1][k] + item.corners[2][k];
    axis[0] * sum(0) + axis[1] * sum(1) + axis[2] * sum(2)
}

/// The candidate frames: principal, the mesh's own, the largest triangle's.
fn frames(items: &[Item], stride: usize) -> impl Iterator<Item = Matrix3<f64>> {
    [Some(principal(items, stride)), Some(Matrix3::identity()), largest(items, stride)].into_iter().flatten()
}

/// The principal axes of the surface: [`covariance::area_weighted`] in `f32`, about the first corner.
fn principal(items: &[Item], stride: usize) -> Matrix3<f64> {
    let origin = Vector3::from(items[0].corners[0]);
    let (mut total, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for item in items.iter().step_by(stride) {
        let [p, q, r] = item.corners.map(|corner| Vector3::from(corner) - origin);
        let weight = (q - p).cross(&(r - p)).norm();
        let sum = p + q + r;
        total += weight;
        first += sum * (weight / 3.0);
        for one in [sum, p, q, r] {
            second += one * (one * (weight / 12.0)).transpose();
        }
    }
    if total <= 0.0 {
        return Matrix3::identity();
    }
    let mean: Vector3<f32> = first / total;
    covariance::principal_frame(&(second / total - mean * mean.transpose()).map(f64::from))
}

/// The axes of the largest triangle: along its longest edge, in its plane, and normal. `None` when none has area.
fn largest(items: &[Item], stride: usize) -> Option<Matrix3<f64>> {
    let mut best: Option<(f32, &Item)> = None;
    for item in items.iter().step_by(stride) {
        let area = item.normal().norm_squared();
        if best.is_none_or(|(most, _)| area > most) {
            best = Some((area, item));
        }
    }
    let corners = best?.1.corners.map(|c| Point::from(c.map(f64::from)));
    Triangle { corners }.frame()
}

fn columns(frame: &Matrix3<f64>) -> Columns {
    [0, 1, 2].map(|k| [frame[(k, 0)] as f32, frame[(k, 1)] as f32, frame[(k, 2)] as f32, 0.0])
}

/// Three times the centroid's coordinates, and the bounds, along three axes.
#[inline(always)]
fn project(item: &Item, frame: &Columns) -> ([f32; 4], Bounds) {
    let on = |p: &Corner| -> [f32; 4] {
        std::array::from_fn(|j| frame[0][j] * p[0] + frame[1][j] * p[1] + frame[2][j] * p[2])
    };
    let [p, q, r] = item.corners.each_ref().map(on);
    let less = |x: f32, y: f32| if x < y { x } else { y };
    let mut bounds = [0.0; 8];
    for k in 0..4 {
        bounds[k] = less(less(p[k], q[k]), r[k]);
        bounds[k + 4] = less(less(-p[k], -q[k]), -r[k]);
    }
    (std::array::from_fn(|k| p[k] + q[k] + r[k]), Bounds(bounds, 1.0))
}

/// Replaces `best` by the cheapest boundary of bins along the axes of `frame` if that is cheaper.
fn cheapest(items: &[Item], stride: usize, frame: &Columns, best: &mut Option<Cut>) {
    let projected: Vec<([f32; 4], Bounds)> = items.iter().step_by(stride).map(|item| project(item, frame)).collect();
    let (mut low, mut high) = ([f32::MAX; 4], [f32::MIN; 4]);
    for (centre, _) in &projected {
        for k in 0..4 {
            low[k] = if centre[k] < low[k] { centre[k] } else { low[k] };
            high[k] = if centre[k] > high[k] { centre[k] } else { high[k] };
        }
    }
    let count = (projected.len() / 2).clamp(4, BINS);
    for axis in 0..3 {
        let scale = count as f32 / (high[axis] - low[axis]);
        if !(high[axis] > low[axis] && scale.is_finite()) {
            continue;
        }
        let mut bins = [Bounds::EMPTY; BINS];
        for (centre, bounds) in &projected {
            bins[(((centre[axis] - low[axis]) * scale) as usize).min(count - 1)].join(bounds);
        }
        let mut right = [Bounds::EMPTY; BINS];
        let mut sum = Bounds::EMPTY;
        for bin in (1..count).rev() {
            sum.join(&bins[bin]);
            right[bin] = sum;
        }
        let mut left = Bounds::EMPTY;
        for bin in 1..count {
            left.join(&bins[bin - 1]);
            let right = &right[bin];
            let areas = [left.area(), right.area()];
            let cost = left.1 * areas[0] + right.1 * areas[1];
            if right.1 > 0.0 && left.1 > 0.0 && best.as_ref().is_none_or(|best| cost < best.cost) {
                let axis_columns = [0, 1, 2].map(|k| frame[k][axis]);
                *best = Some(Cut { cost, axis: axis_columns, at: low[axis] + bin as f32 / scale, areas });
            }
        }
    }
}

/// Of the candidate frames the one whose box around the items has the least surface.
pub(super) fn least_frame(items: &[Item]) -> Matrix3<f64> {
    let stride = items.len().div_ceil(FRAME_SAMPLE);
    let mut best: Option<(f32, Matrix3<f64>)> = None;
    for frame in frames(items, stride) {
        let columns = columns(&frame);
        let mut bounds = Bounds::EMPTY;
        for item in items.iter().step_by(stride) {
            bounds.join(&project(item, &columns).1);
        }
        let area = bounds.area();
        if best.is_none_or(|(least, _)| area < least) {
            best = Some((area, frame));
        }
    }
    best.map_or_else(Matrix3::identity, |(_, frame)| frame)
}

/// The axes of a triangle that may have no area: then along the segment that it is.
pub(super) fn frame_of(triangle: &Triangle) -> Matrix3<f64> {
    triangle.frame().unwrap_or_else(|| {
        let covariance = covariance::vertex_weighted(std::slice::from_ref(triangle)).1;
        covariance::principal_frame(&covariance)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

    fn item(corners: [[f64; 3]; 3], face: u32) -> Item {
        Item::new(&Triangle { corners: corners.map(Point::from) }, &Point::origin(), face)
    }

    /// A right triangle with legs of 1 in the plane x = const.
    fn upright(x: f64, face: u32) -> Item {
        item([[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]], face)
    }

    #[test]
    fn two_groups_are_told_apart() {
        let mut items: Vec<Item> =
            [0.0, 9.0, 1.0, 8.0, 0.5, 9.5].into_iter().zip(0..).map(|(x, face)| upright(x, face)).collect();
        let (left, _) = divide(&mut items);
        assert_eq!(left, 3);
        let mut faces: Vec<u32> = items[..3].iter().map(|item| item.face).collect();
        faces.sort_unstable();
        assert!(faces == [0, 2, 4] || faces == [1, 3, 5]);
    }

    #[test]
    fn equal_triangles_are_halved() {
        let mut items: Vec<Item> = (0..7).map(|face| upright(3.0, face)).collect();
        assert_eq!(divide(&mut items).0, 3);
    }

    #[test]
    fn the_frame_of_a_slanted_plate_lies_in_it() {
        // A 3 x 1 rectangle in the plane y = z.
        let (p, q, r, s) = ([0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 1.0], [0.0, 1.0, 1.0]);
        let frame = least_frame(&[item([p, q, r], 0), item([p, r, s], 1)]);
        let normal = Vector::new(0.0, 1.0, -1.0).normalize();
        assert!((0..3).any(|k| frame.column(k).dot(&normal).abs() > 1.0 - 1e-6), "{frame}");
    }

    #[test]
    fn a_segment_has_axes_too() {
        let segment = Triangle { corners: [[0.0; 3], [1.0, 2.0, 2.0], [2.0, 4.0, 4.0]].map(Point::from) };
        assert_eq!(segment.frame(), None);
        let along = Vector::new(1.0, 2.0, 2.0) / 3.0;
        assert!(frame_of(&segment).column(0).dot(&along).abs() > 1.0 - 1e-9);
    }
}
