//! How a range of triangles is divided, and which way a box around it is turned.
//!
//! Division: the plane with the least surface-area cost (count times box area, summed over both sides: J. Goldsmith, J. Salmon 1987; bins
//! after I. Wald 2007) among those square to the axes of up to three frames: of the principal one, the mesh's own and the largest triangle's
//! those whose boxes are nearly the smallest. Machine parts are mostly boxes and cylinders whose axes are the mesh's; the others find what
//! stands askew. Large ranges are judged by a sample at equal strides, which costs little and depends on nothing but the order of the triangles;
//! in small ones sides that fill their nodes are a little cheaper.
//!
//! Here all is `f32` and without bounds of error: it decides how good the tree is, never whether it is right.

use super::lanes::{Machine, Simd, Work};
use super::node::WIDTH;
use super::patches::Patch;
use crate::engine::geometry::{Point, Triangle, eigen};
use nalgebra::{Matrix3, Vector3};

/// Bins per axis, at most.
const BINS: usize = 16;
/// Triangles that a division is judged by, at most.
const SAMPLE: usize = 1024;
/// Triangles that a box's frame is judged by, at most.
const FRAME_SAMPLE: usize = 512;
/// A frame is tried if its box has at most this many times the surface of the smallest. Counted in divisions of machine parts, the cheapest
/// plane belongs to such a frame 19 times out of 20; without a limit a build takes a third more instructions, and its tree is a hundredth
/// better.
const NEARLY: f32 = 1.1;
/// Ranges of at most this many triangles count nodes as well: as many as a node of nodes of triangles holds.
const FEW: usize = WIDTH * WIDTH;
/// The share of whole nodes in what their triangles count for. It decides between planes that are nearly equal: without it 90.4 bytes per triangle
/// where all triangles are alike, with it 88.9 at most; of eleven scenes' node tests three thousandths more.
const WHOLE: f32 = 0.1;
/// What may be left outside the diagonal of a range's second moments along its principal axes, as a share of the largest: a frame
/// needs no more.
const ROUND_OFF: f64 = 1e-6;

type Corner = [f32; 3];
/// Three axes, as columns padded to four: `frame[k]` holds the k-th coordinates of all axes.
type Columns = [[f32; 4]; 3];

/// A patch on its way into the tree: its corners relative to the middle of the mesh, mm, of a single triangle also its centroid; and its number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    corners: [Corner; 4],
    pub patch: u32,
    /// True for two triangles, false for one.
    pub is_pair: bool,
}

impl Item {
    pub fn new(patch: &Patch, middle: &Point, number: u32) -> Self {
        let [p, q, r, _] = patch.corners.map(|p| p - middle);
        let last = if patch.is_pair() { patch.corners[3] - middle } else { (p + q + r) / 3.0 };
        let corners = [p, q, r, last].map(|p| p.map(|x| x as f32).into());
        Self { corners, patch: number, is_pair: patch.is_pair() }
    }
}

/// Bounds along three axes as (low, -high), padded to four, so that joining is one minimum.
type Bounds = [f32; 8];
const NOTHING: Bounds = [f32::MAX; 8];

/// Half of half the surface area of bounds that are not empty.
#[inline(always)]
fn area(bounds: &Bounds) -> f32 {
    let (x, y, z) = (-bounds[0] - bounds[4], -bounds[1] - bounds[5], -bounds[2] - bounds[6]);
    x * y + y * z + z * x
}

/// A patch along the axes of a frame: four times the coordinates of its middle, and its bounds.
#[derive(Clone, Copy, Default)]
struct Projected {
    centre: [f32; 4],
    bounds: Bounds,
}

/// What the bins along three axes hold: the bounds of their triangles, and how many they are.
#[derive(Default)]
struct Bins {
    bounds: [[Bounds; BINS]; 3],
    members: [[u32; BINS]; 3],
}

/// Memory that divisions reuse.
#[derive(Default)]
pub(super) struct Scratch {
    projected: Vec<Projected>,
    bins: Bins,
}

/// The candidate frames of a range: of the principal one, the mesh's own and the largest triangle's those whose boxes around it are nearly the
/// smallest, the very smallest first. Its box is turned like the first, and its division into a node's children tries the axes of all. (Boxes
/// along the mesh's axes divided along those of all three frames open a twentieth more nodes than along the mesh's alone.)
#[derive(Clone, Copy)]
pub(super) struct Frames {
    frames: [Matrix3<f64>; 3],
    count: usize,
}

impl Frames {
    /// Where boxes do not turn, the mesh's frame alone.
    pub fn of(items: &[Item], turns: bool) -> Self {
        let mut candidates = Self { frames: [Matrix3::identity(); 3], count: 1 };
        if turns {
            let stride = items.len().div_ceil(FRAME_SAMPLE);
            let (principal, largest) = principal_and_largest(items, stride);
            for frame in std::iter::once(principal).chain(largest) {
                candidates.frames[candidates.count] = frame;
                candidates.count += 1;
            }
            let areas = Simd::in_use().run(Areas { items, stride, frames: candidates.each() });
            candidates.keep_nearly_least(areas);
        }
        candidates
    }

    /// Keeps those whose `areas` are nearly the least, which goes first.
    fn keep_nearly_least(&mut self, mut areas: [f32; 3]) {
        let least = (1..self.count).fold(0, |least, k| if areas[k] < areas[least] { k } else { least });
        areas.swap(0, least);
        self.frames.swap(0, least);
        let most = areas[0] * NEARLY;
        for k in (1..self.count).rev() {
            if areas[k] > most {
                self.count -= 1;
                self.frames.swap(k, self.count);
            }
        }
    }

    fn each(&self) -> &[Matrix3<f64>] {
        &self.frames[..self.count]
    }

    /// The one whose box around the items has the least surface.
    pub const fn least(&self) -> &Matrix3<f64> {
        &self.frames[0]
    }
}

/// The surfaces of boxes along some frames, up to a factor.
struct Areas<'a> {
    items: &'a [Item],
    stride: usize,
    frames: &'a [Matrix3<f64>],
}

impl Work for Areas<'_> {
    type Output = [f32; 3];

    #[inline(always)]
    fn run<M: Machine>(self) -> [f32; 3] {
        let mut areas = [0.0; 3];
        for (frame, of_frame) in self.frames.iter().zip(&mut areas) {
            let columns = columns(frame);
            let mut bounds = NOTHING;
            for item in self.items.iter().step_by(self.stride) {
                M::join(&mut bounds, &project(item, &columns).bounds);
            }
            *of_frame = area(&bounds);
        }
        areas
    }
}

/// A plane: items whose centroid lies below `at` along `axis` are on the left.
struct Cut {
    cost: f32,
    axis: Corner,
    at: f32,
    areas: [f32; 2],
}

/// How a range has been divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Halves {
    /// How many items are on the left: at least one, and not all.
    pub left: usize,
    /// The sizes of both sides, which are comparable among divisions of one mesh.
    pub sizes: [f32; 2],
}

/// Divides `items` in place by the axes of `frames`.
pub(super) fn divide(items: &mut [Item], frames: &Frames, scratch: &mut Scratch) -> Halves {
    let Some(cut) = Simd::in_use().run(Cheapest { items, frames, scratch }) else {
        return Halves { left: items.len() / 2, sizes: [1.0; 2] };
    };
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
    Halves { left, sizes: cut.areas }
}

/// The cheapest plane among those square to the axes of some frames, if there is any.
struct Cheapest<'a> {
    items: &'a [Item],
    frames: &'a Frames,
    scratch: &'a mut Scratch,
}

impl Work for Cheapest<'_> {
    type Output = Option<Cut>;

    #[inline(always)]
    fn run<M: Machine>(self) -> Option<Cut> {
        let stride = self.items.len().div_ceil(SAMPLE);
        let Scratch { projected, bins } = self.scratch;
        let seen = self.items.len().div_ceil(stride);
        if projected.len() < seen {
            projected.resize(seen, Projected::default());
        }
        let projected = &mut projected[..seen];
        let mut best = None;
        for frame in self.frames.each() {
            let columns = columns(frame);
            for (projected, item) in projected.iter_mut().zip(self.items.iter().step_by(stride)) {
                *projected = project(item, &columns);
            }
            cheapest::<M>(projected, bins, &columns, &mut best);
        }
        best
    }
}

/// Four times the coordinate of a patch's middle along a direction.
#[inline(always)]
fn along(axis: &Corner, item: &Item) -> f32 {
    let [p, q, r, s] = &item.corners;
    let sum = |k: usize| p[k] + q[k] + r[k] + s[k];
    axis[0] * sum(0) + axis[1] * sum(1) + axis[2] * sum(2)
}

/// The principal axes of the surface, by equations (4) and (5) of [`covariance`](crate::engine::geometry::covariance) in `f32` about the first corner, and the axes of the largest triangle
/// if it has any.
fn principal_and_largest(items: &[Item], stride: usize) -> (Matrix3<f64>, Option<Matrix3<f64>>) {
    let origin = items[0].corners[0];
    let (mut total, mut first) = (0.0, [0.0_f32; 3]);
    // Of the symmetric matrix xx, yy, zz, xy, yz, zx.
    let mut second = [0.0_f32; 6];
    let mut largest = (-1.0, [origin; 3]);
    let from = |c: &Corner| [c[0] - origin[0], c[1] - origin[1], c[2] - origin[2]];
    let mut count = |corners: [&Corner; 3]| {
        let (p, q, r) = (from(corners[0]), from(corners[1]), from(corners[2]));
        let edge = |to: [f32; 3]| Vector3::new(to[0] - p[0], to[1] - p[1], to[2] - p[2]);
        let weight = edge(q).cross(&edge(r)).norm();
        if weight > largest.0 {
            largest = (weight, corners.map(|c| *c));
        }
        let sum = [p[0] + q[0] + r[0], p[1] + q[1] + r[1], p[2] + q[2] + r[2]];
        total += weight;
        for k in 0..3 {
            let k1 = (k + 1) % 3;
            first[k] += sum[k] * (weight / 3.0);
            second[k] += (sum[k] * sum[k] + p[k] * p[k] + q[k] * q[k] + r[k] * r[k]) * (weight / 12.0);
            second[3 + k] += (sum[k] * sum[k1] + p[k] * p[k1] + q[k] * q[k1] + r[k] * r[k1]) * (weight / 12.0);
        }
    };
    for Item { corners: [p, u, v, q], is_pair, .. } in items.iter().step_by(stride) {
        count([p, u, v]);
        if *is_pair {
            count([q, v, u]);
        }
    }
    let corners = largest.1.map(|c| Point::from(c.map(f64::from)));
    let largest = Triangle { corners }.frame();
    if total <= 0.0 {
        return (Matrix3::identity(), largest);
    }
    let mean = Vector3::from(first) / total;
    let [xx, yy, zz, xy, yz, zx] = second;
    let second = Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz) / total;
    (eigen::axes(&(second - mean * mean.transpose()).map(f64::from), ROUND_OFF).1, largest)
}

fn columns(frame: &Matrix3<f64>) -> Columns {
    [0, 1, 2].map(|k| [frame[(k, 0)] as f32, frame[(k, 1)] as f32, frame[(k, 2)] as f32, 0.0])
}

#[inline(always)]
fn on(frame: &Columns, p: &Corner) -> [f32; 4] {
    let mut x = [0.0; 4];
    for k in 0..4 {
        x[k] = frame[0][k] * p[0] + frame[1][k] * p[1] + frame[2][k] * p[2];
    }
    x
}

#[inline(always)]
fn project(item: &Item, frame: &Columns) -> Projected {
    let less = |x: f32, y: f32| if x < y { x } else { y };
    let more = |x: f32, y: f32| if x > y { x } else { y };
    let (p, q) = (on(frame, &item.corners[0]), on(frame, &item.corners[1]));
    let (r, s) = (on(frame, &item.corners[2]), on(frame, &item.corners[3]));
    let (mut centre, mut bounds) = ([0.0; 4], [0.0; 8]);
    for k in 0..4 {
        centre[k] = p[k] + q[k] + r[k] + s[k];
        bounds[k] = less(less(p[k], q[k]), less(r[k], s[k]));
        bounds[k + 4] = -more(more(p[k], q[k]), more(r[k], s[k]));
    }
    Projected { centre, bounds }
}

/// The bins of a centroid along the axes, the first at `low`, `scale` of them in a unit, none behind `last`. Whole numbers come of a sum with
/// 1.5·2²³, around which `f32` has no fractions: a cast would ask of each whether it has a place among the integers.
#[inline(always)]
fn bins_of(centre: &[f32; 4], low: &[f32; 4], scale: &[f32; 4], last: f32) -> [usize; 3] {
    const NO_FRACTIONS: f32 = 12_582_912.0;
    // The sum is rounded to the nearest number, and should be to the one below.
    const DOWN: f32 = 0.499_99;
    let mut bits = [0; 4];
    for k in 0..4 {
        let x = (centre[k] - low[k]) * scale[k] - DOWN;
        let x = if x < last { x } else { last };
        bits[k] = (x + NO_FRACTIONS).to_bits();
    }
    [bits[0], bits[1], bits[2]].map(|bits| bits as usize % BINS)
}

/// What a side of so many triangles counts for: their number, a share `whole` of it rounded up to full nodes.
#[inline(always)]
fn weight(members: u32, whole: f32) -> f32 {
    let free = members.wrapping_neg() % WIDTH as u32;
    members as f32 + whole * free as f32
}

/// Replaces `best` by the cheapest boundary of bins along the axes of `frame` if that is cheaper.
#[inline(always)]
fn cheapest<M: Machine>(projected: &[Projected], bins: &mut Bins, frame: &Columns, best: &mut Option<Cut>) {
    let (mut low, mut high) = ([f32::MAX; 4], [f32::MIN; 4]);
    for Projected { centre, .. } in projected {
        for k in 0..4 {
            low[k] = if centre[k] < low[k] { centre[k] } else { low[k] };
            high[k] = if centre[k] > high[k] { centre[k] } else { high[k] };
        }
    }
    let count = (projected.len() / 2).clamp(4, BINS);
    // Along an axis on which nothing is to be told apart all goes into the first bin.
    let scale: [f32; 4] = std::array::from_fn(|axis| {
        let scale = count as f32 / (high[axis] - low[axis]);
        if high[axis] > low[axis] && scale.is_finite() { scale } else { 0.0 }
    });
    let last = (count - 1) as f32;
    let whole = if projected.len() <= FEW { WHOLE } else { 0.0 };
    for axis in 0..3 {
        bins.bounds[axis][..count].fill(NOTHING);
        bins.members[axis][..count].fill(0);
    }
    // Neighbours often share a bin, whose bounds one waits for after the other: the three axes take turns.
    for Projected { centre, bounds } in projected {
        for (axis, bin) in bins_of(centre, &low, &scale, last).into_iter().enumerate() {
            M::join(&mut bins.bounds[axis][bin], bounds);
            bins.members[axis][bin] += 1;
        }
    }
    for axis in (0..3).filter(|&axis| scale[axis] > 0.0) {
        let (inside, held) = (&bins.bounds[axis], &bins.members[axis]);
        // The cost of what is right of each boundary, and its area.
        let mut right = [(0.0_f32, 0.0_f32); BINS];
        let (mut bounds, mut members) = (NOTHING, 0);
        for bin in (1..count).rev() {
            M::join(&mut bounds, &inside[bin]);
            members += held[bin];
            // The last bin holds the highest centroid, so this is not empty.
            let area = area(&bounds);
            right[bin] = (weight(members, whole) * area, area);
        }
        let (mut bounds, mut members) = (NOTHING, 0);
        for bin in 1..count {
            M::join(&mut bounds, &inside[bin - 1]);
            members += held[bin - 1];
            let (area, right) = (area(&bounds), right[bin]);
            let cost = weight(members, whole) * area + right.0;
            if best.as_ref().is_none_or(|best| cost < best.cost) {
                let axis_columns = [frame[0][axis], frame[1][axis], frame[2][axis]];
                let at = low[axis] + bin as f32 / scale[axis];
                *best = Some(Cut { cost, axis: axis_columns, at, areas: [area, right.1] });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::geometry::Vector;

    fn item(corners: [[f64; 3]; 3], face: u32) -> Item {
        Item::new(&Patch::one(corners.map(Point::from), face), &Point::origin(), face)
    }

    fn divided(items: &mut [Item]) -> Halves {
        let frames = Frames::of(items, true);
        divide(items, &frames, &mut Scratch::default())
    }

    /// A right triangle with legs of 1 in the plane x = const.
    fn upright(x: f64, face: u32) -> Item {
        item([[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]], face)
    }

    #[test]
    fn two_groups_are_told_apart() {
        let mut items: Vec<Item> =
            [0.0, 9.0, 1.0, 8.0, 0.5, 9.5].into_iter().zip(0..).map(|(x, face)| upright(x, face)).collect();
        let Halves { left, .. } = divided(&mut items);
        assert_eq!(left, 3);
        let mut faces: Vec<u32> = items[..3].iter().map(|item| item.patch).collect();
        faces.sort_unstable();
        assert!(faces == [0, 2, 4] || faces == [1, 3, 5]);
    }

    #[test]
    fn equal_triangles_are_halved() {
        let mut items: Vec<Item> = (0..7).map(|face| upright(3.0, face)).collect();
        assert_eq!(divided(&mut items).left, 3);
    }

    /// At 4 096 mm an `f32` steps by 2⁻¹¹ mm, and four times that at 16 384 mm, where centroids are compared: the first boundary of the four bins
    /// between two neighbours is rounded to the lower one, so that nothing is below it.
    #[test]
    fn what_no_plane_parts_for_rounding_is_halved() {
        let places = [4096.0, 4096.0 + 1.0 / 2048.0];
        let mut items: Vec<Item> = (0..6).map(|face| upright(places[face as usize % 2], face)).collect();
        let frames = Frames::of(&items, false);
        assert_eq!(divide(&mut items, &frames, &mut Scratch::default()).left, 3);
    }

    #[test]
    fn the_frame_of_a_slanted_plate_lies_in_it() {
        // A 3 x 1 rectangle in the plane y = z.
        let (p, q, r, s) = ([0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 1.0, 1.0], [0.0, 1.0, 1.0]);
        let items = [item([p, q, r], 0), item([p, r, s], 1)];
        let frame = *Frames::of(&items, true).least();
        let normal = Vector::new(0.0, 1.0, -1.0).normalize();
        assert!((0..3).any(|k| frame.column(k).dot(&normal).abs() > 1.0 - 1e-6), "{frame}");
    }

    #[test]
    fn frames_with_larger_boxes_are_left_out() {
        // The plate above and one 0.1 above it: 3 x 1.5 x 0.07 along its own axes, half a surface of 4.8; 3 x 1 x 1.1 along the mesh's, 7.4.
        let plate = |z: f64| {
            let (p, q, r, s) = ([0.0, 0.0, z], [3.0, 0.0, z], [3.0, 1.0, 1.0 + z], [0.0, 1.0, 1.0 + z]);
            [item([p, q, r], 0), item([p, r, s], 1)]
        };
        let items = [plate(0.0), plate(0.1)].concat();
        let frames = Frames::of(&items, true);
        assert!(frames.count < 3 && !frames.each().contains(&Matrix3::identity()), "{:?}", frames.each());
        assert_eq!(Frames::of(&items, false).each(), [Matrix3::identity()]);
    }

    #[test]
    fn full_nodes_count_for_what_they_hold_and_others_for_more() {
        assert_eq!([1, 8, 9, 16, 1000].map(|members| weight(members, 0.0)), [1.0, 8.0, 9.0, 16.0, 1000.0]);
        assert_eq!([1, 8, 9, 16].map(|members| weight(members, 0.5)), [4.5, 8.0, 12.5, 16.0]);
    }

    #[test]
    fn bins_are_numbered_from_below_and_none_is_left_out() {
        // Bins of a half from 1 on, eight of them: 1.49 is in the first, 1.5 in the second, what is at the end in the last.
        let bins = |x: f32| bins_of(&[x, 1.0, 1.0, 0.0], &[1.0; 4], &[2.0, 0.0, 0.0, 0.0], 7.0);
        assert_eq!([1.0, 1.49, 1.5, 4.99, 5.0].map(|x| bins(x)[0]), [0, 0, 1, 7, 7]);
        assert_eq!(bins(3.0)[1..], [0, 0]);
    }
}
