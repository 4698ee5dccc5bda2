//! A static tree of axis-aligned boxes over a mesh, and conservative motion of these boxes.

use crate::geometry::grid::STEP_MM;
use crate::geometry::{Isometry, Point, Triangle, Vector, rigid};
use nalgebra::Matrix3;

/// An axis-aligned box, mm, closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub low: Point,
    pub high: Point,
}

impl Bounds {
    pub fn of(triangle: &Triangle) -> Self {
        let (low, high) = triangle.bounds();
        Self { low, high }
    }

    /// The box around points; the origin when there are none.
    pub fn around(points: impl Iterator<Item = Point>) -> Self {
        let wider = |(low, high): (Point, Point), (point, _): (Point, Point)| (low.inf(&point), high.sup(&point));
        let (low, high) =
            points.map(|point| (point, point)).reduce(wider).unwrap_or((Point::origin(), Point::origin()));
        Self { low, high }
    }

    /// Whether the boxes share a point. Exact.
    #[inline(always)]
    pub fn overlap(&self, other: &Self) -> bool {
        // `&` instead of `&&`: one branch, not six.
        self.overlap_in_xy(other) & (self.low.z <= other.high.z) & (other.low.z <= self.high.z)
    }

    /// Whether the projections of the boxes to the xy plane share a point. Exact.
    #[inline(always)]
    pub fn overlap_in_xy(&self, other: &Self) -> bool {
        (self.low.x <= other.high.x)
            & (other.low.x <= self.high.x)
            & (self.low.y <= other.high.y)
            & (other.low.y <= self.high.y)
    }

    /// Square of the distance between the boxes, mm², 0 when they overlap; rounded to nearest.
    #[inline(always)]
    pub fn gap_squared(&self, other: &Self) -> f64 {
        let gap = |i: usize| (self.low[i] - other.high[i]).max(other.low[i] - self.high[i]).max(0.0);
        let (x, y, z) = (gap(0), gap(1), gap(2));
        x * x + y * y + z * z
    }

    /// Whether the ray from `from` along +x meets the box. Exact.
    #[inline(always)]
    pub fn meets_ray_along_x(&self, from: &Point) -> bool {
        (from.x <= self.high.x)
            & (self.low.y <= from.y)
            & (from.y <= self.high.y)
            & (self.low.z <= from.z)
            & (from.z <= self.high.z)
    }

    pub fn contains(&self, point: &Point) -> bool {
        (0..3).all(|i| self.low[i] <= point[i] && point[i] <= self.high[i])
    }

    /// The eight corners.
    pub fn corners(&self) -> [Point; 8] {
        std::array::from_fn(|bits| {
            let pick = |i: usize| if bits >> i & 1 == 1 { self.high[i] } else { self.low[i] };
            Point::new(pick(0), pick(1), pick(2))
        })
    }

    fn widest(&self) -> (usize, f64) {
        let size = self.high - self.low;
        (size.imax(), size.max())
    }
}

/// A node. An inner node has `count` 0, its left child directly behind it and its right child at `next`. A leaf holds `count` triangles,
/// starting at `next`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub bounds: Bounds,
    next: u32,
    count: u32,
}

/// A binary tree of tight boxes, depth-first in memory; triangles are sorted so that those of a leaf are adjacent.
#[derive(Clone, Debug)]
pub(crate) struct BoxTree {
    pub nodes: Vec<Node>,
    pub triangles: Vec<Triangle>,
    /// The number in the mesh of each triangle, in tree order.
    pub faces: Vec<u32>,
    /// The box of each triangle, in tree order.
    pub bounds: Vec<Bounds>,
}

/// Triangles per leaf.
const LEAF: usize = 4;

impl BoxTree {
    /// Builds the tree by halving the triangles at the median of their centroids, along the widest axis of the centroids' box.
    pub fn new(triangles: &[Triangle]) -> Self {
        let mut tree = Self { nodes: Vec::new(), triangles: Vec::new(), faces: Vec::new(), bounds: Vec::new() };
        let mut items: Vec<(Triangle, u32)> = triangles.iter().copied().zip(0..).collect();
        // Halving keeps the depth below 32, so recursion is safe.
        tree.grow(&mut items, 0);
        (tree.triangles, tree.faces) = items.into_iter().unzip();
        tree.bounds = tree.triangles.iter().map(Bounds::of).collect();
        tree
    }

    /// Adds the nodes over `items`, and sorts the items; `first` is the index of the first one in tree order.
    fn grow(&mut self, items: &mut [(Triangle, u32)], first: usize) {
        let corners = items.iter().flat_map(|(triangle, _)| triangle.corners);
        let bounds = Bounds::around(corners);
        let node = self.nodes.len();
        if items.len() <= LEAF {
            self.nodes.push(Node { bounds, next: first as u32, count: items.len() as u32 });
            return;
        }
        self.nodes.push(Node { bounds, next: 0, count: 0 });
        let (axis, _) = Bounds::around(items.iter().map(|(triangle, _)| triangle.centroid())).widest();
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |s, t| s.0.centroid()[axis].total_cmp(&t.0.centroid()[axis]));
        let (left, right) = items.split_at_mut(middle);
        self.grow(left, first);
        self.nodes[node].next = self.nodes.len() as u32;
        self.grow(right, first + middle);
    }

    /// The children of an inner node; `None` for a leaf.
    #[inline(always)]
    pub fn children(&self, node: u32) -> Option<[u32; 2]> {
        let Node { next, count, .. } = self.nodes[node as usize];
        (count == 0).then_some([node + 1, next])
    }

    /// Range of a leaf's triangles; empty for an inner node.
    #[inline(always)]
    pub fn range(&self, node: u32) -> std::ops::Range<usize> {
        let Node { next, count, .. } = self.nodes[node as usize];
        next as usize..(next + count) as usize
    }

    /// The longest side of a node's box, mm; it decides which of two nodes is opened.
    #[inline(always)]
    pub fn size(&self, node: u32) -> f64 {
        let Bounds { low, high } = &self.nodes[node as usize].bounds;
        (high.x - low.x).max(high.y - low.y).max(high.z - low.z)
    }
}

/// Cache of the nodes of a tree at one pose. A search visits many nodes repeatedly, so each is moved once and kept. Nodes that are not
/// visited, most of a large mesh, are never moved.
pub(super) struct Memo<T> {
    /// For each node, one more than the start of its items; 0 for a node that was not visited.
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T> Memo<T> {
    /// An empty cache for the nodes of a tree.
    pub fn new(tree: &BoxTree) -> Self {
        Self { starts: vec![0; tree.nodes.len()], items: Vec::new() }
    }

    /// The `count` items of a node, computed at the first call.
    #[inline(always)]
    pub fn of(&mut self, node: u32, count: usize, make: impl Fn(usize) -> T) -> &[T] {
        let start = &mut self.starts[node as usize];
        if *start == 0 {
            *start = self.items.len() as u32 + 1;
            self.items.extend((0..count).map(make));
        }
        let start = *start as usize - 1;
        &self.items[start..start + count]
    }
}

/// Moves boxes conservatively: the moved box contains every moved and snapped vertex of the box's contents.
///
/// For v in the box c ± h, the exact product M v + t lies in M c + t ± |M| h, for whatever matrix M the floating-point rotation really is.
/// Rounding adds less than 2⁻⁴⁸ (|M| (|c| + h) + |t|): evaluating a vertex and evaluating the box each take fewer than 16 roundings of 2⁻⁵³
/// relative to that magnitude. Snapping moves a coordinate by at most half a step.
pub(super) struct Mover {
    matrix: Matrix3<f64>,
    magnitudes: Matrix3<f64>,
    translation: Vector,
    pad_mm: f64,
}

/// Bound on the relative rounding error of a moved coordinate, as derived at [`Mover`].
const ROUNDING: f64 = 3.552_713_678_800_501e-15; // 2^-48

impl Mover {
    /// A mover for boxes inside `root`.
    pub fn new(a_from_b: &Isometry, root: &Bounds) -> Self {
        Self::of(rigid::rotation(a_from_b), a_from_b.translation.vector, root)
    }

    /// A mover by v -> `matrix` v + `translation`, for boxes inside `root`.
    pub fn of(matrix: Matrix3<f64>, translation: Vector, root: &Bounds) -> Self {
        let magnitudes = matrix.abs();
        let farthest = root.low.coords.abs().sup(&root.high.coords.abs());
        let largest = (magnitudes * farthest * 2.0 + translation.abs()).max();
        Self { matrix, magnitudes, translation, pad_mm: largest * ROUNDING + STEP_MM }
    }

    /// A box that contains the moved contents of `bounds`.
    #[inline(always)]
    pub fn bounds(&self, bounds: &Bounds) -> Bounds {
        let half = (bounds.high - bounds.low) * 0.5;
        let centre = self.matrix * (bounds.low.coords + half) + self.translation;
        let reach = (self.magnitudes * half).add_scalar(self.pad_mm);
        Bounds { low: Point::from(centre - reach), high: Point::from(centre + reach) }
    }

    /// A point, rounded but not snapped.
    #[inline(always)]
    pub fn point(&self, point: &Point) -> Point {
        Point::from(self.matrix * point.coords + self.translation)
    }
}

#[cfg(test)]
mod tests {
    use super::super::solids;
    use super::*;
    use crate::geometry::grid::Placement;
    use proptest::prelude::*;
    use std::cell::Cell;

    #[test]
    fn what_is_worked_out_of_a_node_is_kept() {
        let tree = BoxTree::new(&solids::torus(10.0, 3.0, 8, 4).triangles());
        let (mut memo, made) = (Memo::new(&tree), Cell::new(0));
        let mut ask = |node: u32| {
            let make = |k| {
                made.set(made.get() + 1);
                10 * node + k as u32
            };
            memo.of(node, 2, make).to_vec()
        };
        assert_eq!([ask(2), ask(0), ask(2), ask(0)], [[20, 21], [0, 1], [20, 21], [0, 1]]);
        assert_eq!(made.get(), 4);
    }

    #[test]
    fn every_triangle_is_in_one_leaf_and_inside_all_nodes_above_it() {
        let mesh = solids::torus(10.0, 3.0, 24, 12);
        let tree = BoxTree::new(&mesh.triangles());
        let mut seen = vec![0; tree.triangles.len()];
        let mut stack = vec![(0, Vec::new())];
        while let Some((node, mut above)) = stack.pop() {
            above.push(tree.nodes[node as usize].bounds);
            for i in tree.range(node) {
                seen[i] += 1;
                assert!(above.iter().all(|bounds| tree.triangles[i].corners.iter().all(|p| bounds.contains(p))));
            }
            stack.extend(tree.children(node).into_iter().flatten().map(|child| (child, above.clone())));
        }
        assert!(seen.iter().all(|&times| times == 1));
    }

    proptest! {
        #[test]
        fn moved_boxes_hold_what_they_held(
            corner in prop::array::uniform3(-4096.0..4096.0f64),
            other in prop::array::uniform3(-4096.0..4096.0f64),
            weight in prop::array::uniform3(prop::sample::select(vec![0.0, 0.25, 1.0])),
            turn in prop::array::uniform3(-3.0..3.0f64),
            shift in prop::array::uniform3(-1e4..1e4f64),
        ) {
            let (p, q) = (Point::from(corner), Point::from(other));
            let bounds = Bounds { low: p.inf(&q), high: p.sup(&q) };
            let pose = Isometry::new(Vector::from(shift), Vector::from(turn));
            let moved = Mover::new(&pose, &bounds).bounds(&bounds);
            let inside = Point::from(
                bounds.low.coords + (bounds.high - bounds.low).component_mul(&Vector::from(weight)),
            );
            prop_assert!(moved.contains(&Placement::new(&pose).point(&inside)));
        }
    }
}
