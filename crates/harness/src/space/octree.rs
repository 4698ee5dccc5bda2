//! An octree over triangles: a cube around the mesh, divided into eight while it holds too many triangles.
//!
//! D. Meagher, "Geometric modeling using octree encoding", Computer Graphics and Image Processing 19, 1982; triangles in the
//! leaves as in A. S. Glassner, "Space subdivision for fast ray tracing", IEEE CG&A 4(10), 1984. A query descends both octrees
//! together, opening the larger cube. Empty octants are not stored.

use super::grid::nearest;
use super::{bounds_overlap, may_reach, padded_bounds};
use crate::geometry::grid::Placement;
use crate::geometry::separating_axes::{gap_mm, separated};
use crate::geometry::{Isometry, Point, Triangle, Vector, certified};
use crate::tree::traverse::Probe;
use crate::volume::shape::aligned_box::AlignedPose;
use std::ops::ControlFlow;

/// Largest number of triangles of an octant that stays a leaf.
const CAPACITY: usize = 8;

/// Additional levels beyond those that would separate all triangles of an even surface, assuming that the surface meets four of eight
/// octants at each level.
const SPARE_LEVELS: u32 = 2;

/// A cube, mm, and its contents.
#[derive(Clone, Debug)]
struct Octant {
    centre: Point,
    /// Half the edge length, including the pad.
    half: f64,
    /// Start of its children among the octants, or of its triangles among the faces of leaves.
    first: u32,
    count: u32,
    is_leaf: bool,
}

/// An octree over one mesh, in the mesh's frame, mm.
#[derive(Clone, Debug)]
pub struct Octree {
    /// The octants; the root comes first, and siblings are adjacent, after their parent.
    octants: Vec<Octant>,
    /// The triangles of the leaves.
    faces: Vec<u32>,
    /// The triangles, in the order of the mesh's faces.
    triangles: Vec<Triangle>,
    depth: u32,
}

/// Buffers that queries reuse.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    stack: Vec<(u32, u32)>,
    moved: Vec<(Triangle, u32)>,
}

impl Octree {
    /// The octree over `triangles` (mm, mesh frame; at least one).
    pub fn build(triangles: Vec<Triangle>) -> Self {
        let (low, high, pad) = padded_bounds(&triangles);
        let root = Octant {
            centre: nalgebra::center(&low, &high),
            half: (high - low).max() / 2.0 + pad,
            first: 0,
            count: 0,
            is_leaf: true,
        };
        let levels = triangles.len().ilog2().div_ceil(2) + SPARE_LEVELS;
        let all = (0..triangles.len() as u32).collect();
        let mut tree = Self { octants: vec![root], faces: Vec::new(), triangles, depth: 0 };
        tree.divide(0, all, levels, pad);
        tree.depth = tree.depths().into_iter().max().unwrap_or(0);
        tree
    }

    /// Divides an octant that holds `faces`, or leaves it as a leaf.
    fn divide(&mut self, octant: usize, faces: Vec<u32>, levels: u32, pad: f64) {
        let children = if faces.len() <= CAPACITY || levels == 0 { None } else { self.eighths(octant, &faces, pad) };
        let Some(children) = children else {
            (self.octants[octant].first, self.octants[octant].count) = (self.faces.len() as u32, faces.len() as u32);
            self.faces.extend(faces);
            return;
        };
        let half = (self.octants[octant].half - pad) / 2.0 + pad;
        let first = self.octants.len();
        let parent = &mut self.octants[octant];
        (parent.first, parent.count, parent.is_leaf) = (first as u32, children.len() as u32, false);
        self.octants.extend(children.iter().map(|(centre, _)| Octant {
            centre: *centre,
            half,
            first: 0,
            count: 0,
            is_leaf: true,
        }));
        for (number, (_, faces)) in children.into_iter().enumerate() {
            self.divide(first + number, faces, levels - 1, pad);
        }
    }

    /// The centres of an octant's eighths that hold triangles, each with the subset of `faces` in it. `None` when no eighth holds fewer
    /// triangles than the octant: triangles that coincide, or all lie within the pad, cannot be separated by smaller cubes.
    fn eighths(&self, octant: usize, faces: &[u32], pad: f64) -> Option<Vec<(Point, Vec<u32>)>> {
        let Octant { centre, half, .. } = self.octants[octant];
        let quarter = (half - pad) / 2.0;
        let padded = Vector::repeat(quarter + pad);
        let eighth = |number: usize| {
            let side = |bit: usize| if number >> bit & 1 == 1 { quarter } else { -quarter };
            let centre = centre + Vector::new(side(0), side(1), side(2));
            let reaches = |face: &&u32| may_reach(&self.triangles[**face as usize], &centre, &padded);
            (centre, faces.iter().filter(reaches).copied().collect::<Vec<u32>>())
        };
        let mut children: Vec<_> = (0..8).map(eighth).collect();
        children.retain(|(_, held)| !held.is_empty());
        children.iter().any(|(_, held)| held.len() < faces.len()).then_some(children)
    }

    /// The depth of every leaf; the root's is 0.
    fn depths(&self) -> Vec<u32> {
        let mut depths = vec![0; self.octants.len()];
        for (index, octant) in self.octants.iter().enumerate().filter(|(_, octant)| !octant.is_leaf) {
            for child in octant.first..octant.first + octant.count {
                depths[child as usize] = depths[index] + 1;
            }
        }
        depths.into_iter().zip(&self.octants).filter(|(_, octant)| octant.is_leaf).map(|(depth, _)| depth).collect()
    }

    /// All triangles, mm, mesh frame, in the order of the mesh's faces.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Number of octants.
    pub const fn octant_count(&self) -> usize {
        self.octants.len()
    }

    /// Number of leaves, depth of the deepest, and mean depth of a triangle's entry in a leaf.
    pub fn leaves(&self) -> (usize, u32, f64) {
        let leaves = self.octants.iter().filter(|octant| octant.is_leaf);
        let weighted: f64 = leaves.zip(self.depths()).map(|(leaf, d)| f64::from(leaf.count) * f64::from(d)).sum();
        (self.depths().len(), self.depth, weighted / self.faces.len() as f64)
    }

    /// Sum of the surface areas of all octants, divided by that of the root.
    pub fn relative_area(&self) -> f64 {
        self.octants.iter().map(|octant| (octant.half / self.octants[0].half).powi(2)).sum()
    }

    /// Memory the octree holds, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.octants.as_slice())
            + size_of_val(self.faces.as_slice())
            + size_of_val(self.triangles.as_slice())
    }

    fn faces_in(&self, leaf: &Octant) -> &[u32] {
        &self.faces[leaf.first as usize..(leaf.first + leaf.count) as usize]
    }

    /// Calls the visitor with pairs of touching triangles, `(face of self, face of other)`, until it breaks. A pair that shares several
    /// pairs of leaves is visited several times. A volume test compares two octants, or a moved triangle's bounds with a leaf.
    pub fn visit<B>(
        &self,
        other: &Self,
        a_from_b: &Isometry,
        scratch: &mut Scratch,
        probe: &mut impl Probe,
        mut on_contact: impl FnMut(u32, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let (turn, placement) = (AlignedPose::new(a_from_b), Placement::new(a_from_b));
        let apart = |i: u32, j: u32| {
            let (a, b) = (&self.octants[i as usize], &other.octants[j as usize]);
            let t = turn.point(&b.centre) - a.centre;
            separated(&t, &turn.rotation, &turn.widened, &Vector::repeat(a.half), &Vector::repeat(b.half))
        };
        scratch.stack.clear();
        probe.volume_test();
        if !apart(0, 0) {
            scratch.stack.push((0, 0));
        }
        while let Some((i, j)) = scratch.stack.pop() {
            let (a, b) = (&self.octants[i as usize], &other.octants[j as usize]);
            if a.is_leaf && b.is_leaf {
                let half = Vector::repeat(a.half);
                scratch.moved.clear();
                for &face in other.faces_in(b) {
                    probe.volume_test();
                    let moved = placement.triangle(&other.triangles[face as usize]);
                    if bounds_overlap(&moved, &a.centre, &half) {
                        scratch.moved.push((moved, face));
                    }
                }
                for &face in self.faces_in(a) {
                    for (moved, their_face) in &scratch.moved {
                        probe.triangle_test();
                        if certified::touch(&self.triangles[face as usize], moved) {
                            on_contact(face, *their_face)?;
                        }
                    }
                }
                continue;
            }
            let opens_first = !a.is_leaf && (b.is_leaf || a.half >= b.half);
            let opened = if opens_first { a } else { b };
            for child in opened.first..opened.first + opened.count {
                let (i, j) = if opens_first { (child, j) } else { (i, child) };
                probe.volume_test();
                if !apart(i, j) {
                    scratch.stack.push((i, j));
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// The distance between the meshes, mm, if it is below `below_mm`; otherwise infinity. 0 when they touch. Uses branch and bound with
    /// the gap between two octants; the nearest pair is opened first.
    pub fn distance_mm(&self, other: &Self, a_from_b: &Isometry, below_mm: f64) -> f64 {
        let (turn, placement) = (AlignedPose::new(a_from_b), Placement::new(a_from_b));
        let gap = |i: u32, j: u32| {
            let (a, b) = (&self.octants[i as usize], &other.octants[j as usize]);
            let t = turn.point(&b.centre) - a.centre;
            gap_mm(&t, &turn.rotation, &turn.widened, &Vector::repeat(a.half), &Vector::repeat(b.half))
        };
        let mut least = below_mm;
        let mut stack = vec![(gap(0, 0), 0, 0)];
        while let Some((bound, i, j)) = stack.pop() {
            if bound >= least {
                continue;
            }
            let (a, b) = (&self.octants[i as usize], &other.octants[j as usize]);
            if a.is_leaf && b.is_leaf {
                let moved = other.faces_in(b).iter().map(|&face| placement.triangle(&other.triangles[face as usize]));
                let mine = self.faces_in(a).iter().map(|&face| &self.triangles[face as usize]);
                least = nearest(mine, &moved.collect::<Vec<_>>(), least);
                continue;
            }
            let opens_first = !a.is_leaf && (b.is_leaf || a.half >= b.half);
            let opened = if opens_first { a } else { b };
            let pairs = (opened.first..opened.first + opened.count).map(|k| if opens_first { (k, j) } else { (i, k) });
            let mut next: Vec<_> = pairs.map(|(i, j)| (gap(i, j), i, j)).filter(|(bound, ..)| *bound < least).collect();
            next.sort_by(|x, y| y.0.total_cmp(&x.0));
            stack.extend(next);
        }
        if least < below_mm { least } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::traverse::Counts;
    use obbtree::cases::meshes;

    #[test]
    fn a_cube_is_divided_until_its_corners_are_apart() {
        let tree = Octree::build(meshes::cuboid(2.0, 2.0, 2.0).triangles());
        // Twelve triangles are too many for a leaf. At a corner three faces meet, of whose six triangles between three and
        // six reach into the octant: eight leaves.
        assert_eq!((tree.octant_count(), tree.leaves().0, tree.leaves().1), (9, 8, 1));
        assert!(tree.faces.len() >= 24 && tree.faces.len() <= 48);
        assert!((tree.relative_area() - 3.0).abs() < 1e-6); // 1 + 8/4
        assert_eq!(tree.bytes(), 9 * size_of::<Octant>() + tree.faces.len() * 4 + 12 * 72);
    }

    #[test]
    fn what_cannot_be_told_apart_is_not_divided() {
        let p = |x: f64, y: f64| Point::new(4000.0 + x, y, 4000.0 - x);
        let large = Triangle::new(p(0.0, 0.0), p(90.0, 3.0), p(40.0, 70.0));
        assert_eq!(Octree::build(vec![large; 200]).octant_count(), 1);
        // A thousandth of the pad.
        let tiny = |i: i32| p(f64::from(i) * 1e-12, 0.0);
        let crumbs = (0..200).map(|i| Triangle::new(tiny(i), tiny(i + 1), tiny(i + 2))).collect();
        assert_eq!(Octree::build(crumbs).octant_count(), 1);
        // One more triangle parts from them at the first cut, and they stay together.
        let apart = Triangle::new(p(0.0, 300.0), p(1.0, 300.0), p(0.0, 301.0));
        let tree = Octree::build([vec![large; 200], vec![apart]].concat());
        assert!(tree.octant_count() < 20 && tree.faces.len() < 2000, "{} {}", tree.octant_count(), tree.faces.len());
    }

    #[test]
    fn roots_apart_cost_one_test() {
        let cube = Octree::build(meshes::cuboid(2.0, 2.0, 2.0).triangles());
        let mut counts = Counts::default();
        let pose = Isometry::translation(2.1, 0.0, 0.0);
        let stop = |_, _| ControlFlow::Break(());
        assert!(cube.visit(&cube, &pose, &mut Scratch::default(), &mut counts, stop).is_continue());
        assert_eq!(counts, Counts { volume_tests: 1, triangle_tests: 0 });
    }
}
