//! The surface as an octree: gray cubes hold samples; the other cubes lie outside (white) or inside (black) the surface.
//!
//! Wang (2006) approximates the free-form surface by an octree and keeps the surface's points in its gray leaves. A cube is divided while
//! it holds more points than a cap and is above the greatest depth. Layout: the children of a node are adjacent, 12 bytes each. The points
//! of a leaf are adjacent too. Cubes are not stored but computed during the descent.

use super::sample::Samples;
use crate::geometry::{Point, Vector};

/// How far an octree is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Division {
    /// Largest number of points in a leaf above the greatest depth.
    pub cap: u32,
    /// Greatest depth; the root has 0. At most [`MOST_DEPTH`].
    pub depth: u8,
}

/// Largest permitted depth: the root's side over 2²⁰ is below any spacing.
pub const MOST_DEPTH: u8 = 20;

impl Default for Division {
    fn default() -> Self {
        Self { cap: 16, depth: 12 }
    }
}

/// A cube, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octant {
    /// Its middle.
    pub centre: Point,
    /// Half its side.
    pub half: f64,
}

impl Octant {
    /// The eighth with this number: bit i set on the upper side of axis i.
    pub fn child(&self, number: u8) -> Self {
        let half = 0.5 * self.half;
        let side = |i: u8| if number >> i & 1 == 1 { half } else { -half };
        Self { centre: self.centre + Vector::new(side(0), side(1), side(2)), half }
    }

    fn number_of(&self, p: &Point) -> u8 {
        u8::from(p.x >= self.centre.x) | u8::from(p.y >= self.centre.y) << 1 | u8::from(p.z >= self.centre.z) << 2
    }

    /// Whether the closed cubes share a point, with `slack_mm` as the tolerance for rounded centres.
    pub fn touches(&self, other: &Self, slack_mm: f64) -> bool {
        (self.centre - other.centre).amax() <= self.half + other.half + slack_mm
    }
}

/// A gray octant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Index of the first gray child, or of the first point of a leaf.
    first: u32,
    /// Number of points of a leaf; 0 for a divided octant.
    count: u32,
    /// Bit set of the gray children; 0 for a leaf.
    gray: u8,
    /// Bit set of the black children among the others.
    black: u8,
}

/// An octree over samples.
#[derive(Clone, Debug)]
pub struct SurfaceOctree {
    root: Octant,
    nodes: Vec<Node>,
    points: Vec<Point>,
    faces: Vec<u32>,
    leaves: u32,
    /// The samples' covering radius, mm.
    pub covering_mm: f64,
}

/// A gray octant reached during the descent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    pub(super) node: u32,
    /// Its cube.
    pub octant: Octant,
}

/// The colour of an octant without samples, or of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// On the surface, to the resolution of the octree.
    Gray,
    /// Outside.
    White,
    /// Inside.
    Black,
}

impl SurfaceOctree {
    /// Builds the octree. `is_inside` is called with the middle of each octant without samples. The surface may still cut an octant without
    /// samples when the octant is smaller than the covering radius.
    pub fn new(samples: Samples, division: Division, is_inside: &dyn Fn(&Point) -> bool) -> Self {
        let Samples { points, faces, covering_mm, .. } = samples;
        let wider = |(low, high): (Point, Point), (p, _): (Point, Point)| (low.inf(&p), high.sup(&p));
        let (low, high) = points.iter().map(|p| (*p, *p)).reduce(wider).unwrap_or_default();
        let centre = nalgebra::center(&low, &high);
        // A little wider, so that no sample lies on the outer faces.
        let half = 0.5 * (high - low).amax() * (1.0 + 1e-9) + 1e-9;
        let mut items: Vec<(Point, u32)> = points.into_iter().zip(faces).collect();
        let mut tree = Self {
            root: Octant { centre, half },
            nodes: Vec::new(),
            points: Vec::new(),
            faces: Vec::new(),
            leaves: 0,
            covering_mm,
        };
        let division = Division { depth: division.depth.min(MOST_DEPTH), cap: division.cap.max(1) };
        tree.nodes.push(Node { first: 0, count: 0, gray: 0, black: 0 });
        if !items.is_empty() {
            tree.divide(0, tree.root, &mut items, 0, division, is_inside);
        }
        (tree.points, tree.faces) = items.into_iter().unzip();
        tree
    }

    /// Fills in a node over `items`, which it sorts. `at` is the index of the first item among all samples.
    fn divide(
        &mut self,
        node: usize,
        octant: Octant,
        items: &mut [(Point, u32)],
        at: u32,
        division: Division,
        is_inside: &dyn Fn(&Point) -> bool,
    ) {
        if items.len() <= division.cap as usize || division.depth == 0 {
            self.nodes[node] = Node { first: at, count: items.len() as u32, gray: 0, black: 0 };
            self.leaves += 1;
            return;
        }
        items.sort_by_key(|(p, _)| octant.number_of(p));
        let ends: [usize; 8] = std::array::from_fn(|n| items.partition_point(|(p, _)| octant.number_of(p) <= n as u8));
        let range = |n: usize| if n == 0 { 0..ends[0] } else { ends[n - 1]..ends[n] };
        let bits = |test: &dyn Fn(usize) -> bool| (0..8).filter(|&n| test(n)).fold(0, |bits, n| bits | 1 << n);
        let gray: u8 = bits(&|n| !range(n).is_empty());
        let black = bits(&|n| range(n).is_empty() && is_inside(&octant.child(n as u8).centre));
        let first = self.nodes.len();
        self.nodes[node] = Node { first: first as u32, count: 0, gray, black };
        let empty = Node { first: 0, count: 0, gray: 0, black: 0 };
        self.nodes.resize(first + gray.count_ones() as usize, empty);
        let deeper = Division { depth: division.depth - 1, ..division };
        let grays = (0..8).filter(|n| gray >> n & 1 == 1);
        for (child, n) in grays.enumerate() {
            let range = range(n);
            let start = at + range.start as u32;
            self.divide(first + child, octant.child(n as u8), &mut items[range], start, deeper, is_inside);
        }
    }

    /// The root.
    pub const fn root(&self) -> Visit {
        Visit { node: 0, octant: self.root }
    }

    /// The gray children of an octant; none of a leaf.
    pub fn children(&self, visit: &Visit) -> impl Iterator<Item = Visit> + use<> {
        let Node { first, gray, .. } = self.nodes[visit.node as usize];
        let octant = visit.octant;
        let grays = (0..8).filter(move |n| gray >> n & 1 == 1);
        grays.zip(first..).map(move |(n, node)| Visit { node, octant: octant.child(n) })
    }

    /// Whether an octant is a leaf.
    pub fn is_leaf(&self, visit: &Visit) -> bool {
        self.nodes[visit.node as usize].gray == 0
    }

    /// Indices of a leaf's points in [`SurfaceOctree::points`]; empty for a divided octant.
    pub fn range(&self, visit: &Visit) -> std::ops::Range<usize> {
        let Node { first, count, gray, .. } = self.nodes[visit.node as usize];
        if gray == 0 { first as usize..(first + count) as usize } else { 0..0 }
    }

    /// All samples, mm, in the order of the leaves.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The triangle of each sample, in the same order.
    pub fn faces(&self) -> &[u32] {
        &self.faces
    }

    /// All gray leaves in order.
    pub fn leaves(&self) -> Vec<Visit> {
        let (mut leaves, mut stack) = (Vec::with_capacity(self.leaves as usize), vec![self.root()]);
        while let Some(visit) = stack.pop() {
            if self.is_leaf(&visit) {
                leaves.push(visit);
            } else {
                let children: Vec<Visit> = self.children(&visit).collect();
                stack.extend(children.into_iter().rev());
            }
        }
        leaves
    }

    /// The gray leaves that touch `leaf`, without `leaf` itself, ordered by the distance of their centres.
    pub fn neighbours(&self, leaf: &Visit) -> Vec<Visit> {
        let slack = self.root.half * 1e-12;
        let (mut found, mut stack) = (Vec::new(), vec![self.root()]);
        while let Some(visit) = stack.pop() {
            if !visit.octant.touches(&leaf.octant, slack) || visit.node == leaf.node {
                continue;
            }
            if self.is_leaf(&visit) {
                found.push(visit);
            } else {
                stack.extend(self.children(&visit));
            }
        }
        let apart = |visit: &Visit| (visit.octant.centre - leaf.octant.centre).norm_squared();
        found.sort_by(|u, v| apart(u).total_cmp(&apart(v)).then(u.node.cmp(&v.node)));
        found
    }

    /// The colour of the smallest octant around a point; everything outside the root is white.
    pub fn colour(&self, place: &Point) -> Colour {
        if (place - self.root.centre).amax() > self.root.half {
            return Colour::White;
        }
        let mut visit = self.root();
        loop {
            let Node { gray, black, .. } = self.nodes[visit.node as usize];
            if gray == 0 {
                return Colour::Gray;
            }
            let number = visit.octant.number_of(place);
            if gray >> number & 1 == 0 {
                return if black >> number & 1 == 1 { Colour::Black } else { Colour::White };
            }
            let octant = visit.octant.child(number);
            let Some(child) = self.children(&visit).find(|child| child.octant == octant) else {
                return Colour::Gray; // Not reached: the child is gray.
            };
            visit = child;
        }
    }

    /// Number of gray octants, including leaves.
    pub const fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether the octree holds no samples.
    pub const fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.points.as_slice()) + size_of_val(self.faces.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::Solid;
    use obbtree::cases::meshes;
    use std::sync::Arc;

    fn torus() -> (SurfaceOctree, Vec<Point>) {
        let mesh = Arc::new(meshes::torus(12.0, 4.0, 24, 12));
        let samples = Samples::of(&mesh, 0.8);
        let points = samples.points.clone();
        let solid = Solid::new(Arc::clone(&mesh));
        (SurfaceOctree::new(samples, Division { cap: 8, depth: 9 }, &|p| solid.holds(p)), points)
    }

    #[test]
    fn every_sample_is_in_one_leaf_and_in_its_cube() {
        let (tree, points) = torus();
        let mut covered = vec![0; points.len()];
        for leaf in tree.leaves() {
            assert!(tree.range(&leaf).len() <= 8 && !tree.range(&leaf).is_empty());
            for i in tree.range(&leaf) {
                covered[i] += 1;
                assert!((tree.points()[i] - leaf.octant.centre).amax() <= leaf.octant.half);
            }
        }
        assert!(covered.iter().all(|&times| times == 1));
        let sorted = |points: &[Point]| {
            let mut bits: Vec<[u64; 3]> = points.iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect();
            bits.sort_unstable();
            bits
        };
        assert_eq!(sorted(tree.points()), sorted(&points));
        assert_eq!(size_of::<Node>(), 12);
    }

    #[test]
    fn black_is_inside_and_white_outside() {
        let (tree, _) = torus();
        assert_eq!(tree.colour(&Point::origin()), Colour::White); // the hole
        assert_eq!(tree.colour(&Point::new(12.0, 0.0, 0.0)), Colour::Black);
        assert_eq!(tree.colour(&Point::new(99.0, 0.0, 0.0)), Colour::White);
        assert_eq!(tree.colour(&tree.points()[5]), Colour::Gray);
    }

    #[test]
    fn neighbours_are_the_leaves_whose_cubes_touch() {
        let (tree, _) = torus();
        let leaves = tree.leaves();
        for leaf in leaves.iter().step_by(37) {
            let mut found: Vec<u32> = tree.neighbours(leaf).iter().map(|visit| visit.node).collect();
            let touching =
                leaves.iter().filter(|other| other.node != leaf.node && other.octant.touches(&leaf.octant, 1e-9));
            let mut expected: Vec<u32> = touching.map(|visit| visit.node).collect();
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected);
            assert!(!found.is_empty());
        }
    }

    #[test]
    fn many_points_in_one_place_end_at_the_greatest_depth() {
        let samples = Samples {
            points: vec![Point::new(1.0, 2.0, 3.0); 50],
            faces: vec![0; 50],
            covering_mm: 0.1,
            spacing_mm: 0.1,
        };
        let tree = SurfaceOctree::new(samples, Division { cap: 4, depth: 40 }, &|_| false);
        assert_eq!(tree.leaves().len(), 1);
        let none = Samples { points: vec![], faces: vec![], covering_mm: 0.0, spacing_mm: 0.0 };
        assert!(SurfaceOctree::new(none, Division::default(), &|_| false).is_empty());
    }
}
