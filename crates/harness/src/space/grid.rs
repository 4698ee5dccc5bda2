//! A uniform grid: the box around a mesh, divided into equal cubes (voxels), each with a list of the triangles in it.
//!
//! As for ray tracing in J. G. Cleary, G. Wyvill, "Analysis of an algorithm for fast ray tracing using uniform space subdivision", The
//! Visual Computer 4, 1988, the number of voxels is proportional to the number of triangles, and voxels are addressed directly. For two
//! meshes, every voxel of the second that reaches the grid of the first is bounded there by an aligned box, and meets the voxels under that
//! box. Deviation: both meshes have a grid. Usually one grid holds all objects of a scene, but such a grid would have to be rebuilt for
//! every pose.

use super::{bounds_overlap, may_reach, padded_bounds};
use crate::geometry::grid::Placement;
use crate::geometry::separating_axes::gap_mm;
use crate::geometry::{Isometry, Point, Triangle, Vector, certified, rigid, triangle_distance};
use crate::tree::traverse::Probe;
use crate::volume::shape::aligned_box::AlignedPose;
use std::ops::{ControlFlow, RangeInclusive};

/// Number of voxels per triangle; I. Wald, T. Ize, A. Kensler, A. Knoll, S. G. Parker, "Ray Tracing Animated Scenes using Coherent Grid
/// Traversal", 2006, use 5.
const VOXELS_PER_TRIANGLE: f64 = 5.0;

/// Smallest thickness of a grid, as a fraction of its longest side, when the pitch is chosen; it gives flat meshes a grid.
const LEAST_THICKNESS: f64 = 0.01;

/// A uniform grid over one mesh, in the mesh's frame, mm.
#[derive(Clone, Debug)]
pub struct Grid {
    /// The triangles, in the order of the mesh's faces.
    triangles: Vec<Triangle>,
    low: Point,
    high: Point,
    /// Edge length of a voxel, mm.
    pitch: f64,
    pad: f64,
    /// Voxels along each axis.
    size: [usize; 3],
    /// Start of each voxel's list in `faces`, and the end of the last list.
    starts: Vec<u32>,
    faces: Vec<u32>,
}

/// Buffers that queries reuse.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// For each triangle of the first mesh, the last voxel visit that tested it (a mailbox; Amanatides and Woo 1987).
    seen: Vec<u64>,
    visit: u64,
    moved: Vec<(Triangle, u32)>,
}

impl Grid {
    /// The grid over `triangles` (mm, mesh frame; at least one).
    pub fn build(triangles: Vec<Triangle>) -> Self {
        let (low, high, pad) = padded_bounds(&triangles);
        let extent = high - low;
        let thick = extent.map(|x| x.max(extent.max() * LEAST_THICKNESS));
        let pitch = (thick.product() / (VOXELS_PER_TRIANGLE * triangles.len() as f64)).cbrt();
        let size = [0, 1, 2].map(|i| (extent[i] / pitch).ceil().max(1.0) as usize);
        let mut grid = Self { triangles, low, high, pitch, pad, size, starts: Vec::new(), faces: Vec::new() };
        let entries = grid.entries();
        let mut starts = vec![0_u32; size.iter().product::<usize>() + 1];
        entries.iter().for_each(|&(voxel, _)| starts[voxel as usize + 1] += 1);
        for voxel in 1..starts.len() {
            starts[voxel] += starts[voxel - 1];
        }
        (grid.starts, grid.faces) = (starts, entries.into_iter().map(|(_, face)| face).collect());
        grid
    }

    /// Every pair (voxel, face) in which the face reaches into the voxel, sorted.
    fn entries(&self) -> Vec<(u32, u32)> {
        let mut entries = Vec::new();
        let half = Vector::repeat(self.pitch / 2.0 + self.pad);
        for (triangle, face) in self.triangles.iter().zip(0..) {
            let (low, high) = triangle.bounds();
            let margin = Vector::repeat(self.pad);
            let within = |voxel: usize| may_reach(triangle, &self.centre(voxel), &half);
            let voxels = self.voxels(&(low - margin), &(high + margin)).filter(|&voxel| within(voxel));
            entries.extend(voxels.map(|voxel| (voxel as u32, face)));
        }
        entries.sort_unstable();
        entries
    }

    /// Index along an axis of the voxel that contains a coordinate; the nearest voxel for coordinates outside.
    fn index(&self, axis: usize, x: f64) -> usize {
        (((x - self.low[axis]) / self.pitch).max(0.0) as usize).min(self.size[axis] - 1)
    }

    /// The voxels that an aligned box overlaps; none for a box outside the grid.
    fn voxels(&self, low: &Point, high: &Point) -> impl Iterator<Item = usize> + use<> {
        let outside = (0..3).any(|i| high[i] < self.low[i] || low[i] > self.high[i]);
        let along = |i: usize| -> RangeInclusive<usize> {
            if outside { RangeInclusive::new(1, 0) } else { self.index(i, low[i])..=self.index(i, high[i]) }
        };
        let (x, y, [nx, ny, _]) = (along(0), along(1), self.size);
        along(2).flat_map(move |k| {
            let x = x.clone();
            y.clone().flat_map(move |j| x.clone().map(move |i| (k * ny + j) * nx + i))
        })
    }

    fn centre(&self, voxel: usize) -> Point {
        let [nx, ny, _] = self.size;
        let at = Vector::new((voxel % nx) as f64, (voxel / nx % ny) as f64, (voxel / (nx * ny)) as f64);
        self.low + (at + Vector::repeat(0.5)) * self.pitch
    }

    fn faces_in(&self, voxel: usize) -> &[u32] {
        &self.faces[self.starts[voxel] as usize..self.starts[voxel + 1] as usize]
    }

    /// All triangles, mm, mesh frame, in the order of the mesh's faces.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Number of voxels, empty ones included.
    pub const fn voxel_count(&self) -> usize {
        self.starts.len() - 1
    }

    /// The voxels that hold triangles.
    pub fn occupied(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.voxel_count()).filter(|&voxel| self.starts[voxel] < self.starts[voxel + 1])
    }

    /// Sum of the surface areas of the occupied voxels, divided by the surface area of the whole grid.
    pub fn relative_area(&self) -> f64 {
        let e = self.high - self.low;
        let whole = 2.0 * (e.x * e.y + e.y * e.z + e.z * e.x);
        6.0 * self.pitch * self.pitch * self.occupied().count() as f64 / whole
    }

    /// Memory the grid holds, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.triangles.as_slice())
            + size_of_val(self.starts.as_slice())
            + size_of_val(self.faces.as_slice())
    }

    /// Calls the visitor with pairs of touching triangles, `(face of self, face of other)`, until it breaks. A pair that shares several
    /// voxels is visited several times. A volume test compares a voxel of the second mesh with the grid of the first, or a triangle of the
    /// first with such a voxel.
    pub fn visit<B>(
        &self,
        other: &Self,
        a_from_b: &Isometry,
        scratch: &mut Scratch,
        probe: &mut impl Probe,
        mut on_contact: impl FnMut(u32, u32) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let (turn, back) = (AlignedPose::new(a_from_b), AlignedPose::new(&rigid::inverse(a_from_b)));
        let placement = Placement::new(a_from_b);
        let pad = self.pad.max(other.pad);
        scratch.seen.resize(self.triangles.len().max(scratch.seen.len()), 0);
        let reach = turn.widened * Vector::repeat(other.pitch / 2.0 + pad) + Vector::repeat(pad);
        let middle = back.point(&nalgebra::center(&self.low, &self.high));
        let whole = back.widened * ((self.high - self.low) / 2.0) + Vector::repeat(2.0 * pad);
        probe.volume_test();
        for voxel in other.voxels(&(middle - whole), &(middle + whole)) {
            let theirs = other.faces_in(voxel);
            if theirs.is_empty() {
                continue;
            }
            probe.volume_test();
            let centre = turn.point(&other.centre(voxel));
            scratch.visit += 1;
            scratch.moved.clear();
            for mine in self.voxels(&(centre - reach), &(centre + reach)) {
                for &face in self.faces_in(mine) {
                    if std::mem::replace(&mut scratch.seen[face as usize], scratch.visit) == scratch.visit {
                        continue;
                    }
                    let triangle = &self.triangles[face as usize];
                    probe.volume_test();
                    if !bounds_overlap(triangle, &centre, &reach) {
                        continue;
                    }
                    if scratch.moved.is_empty() {
                        let moved = |&face: &u32| (placement.triangle(&other.triangles[face as usize]), face);
                        scratch.moved.extend(theirs.iter().map(moved));
                    }
                    for (moved, their_face) in &scratch.moved {
                        probe.triangle_test();
                        if certified::touch(triangle, moved) {
                            on_contact(face, *their_face)?;
                        }
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// The distance between the meshes, mm, if it is below `below_mm`; otherwise infinity. 0 when they touch. Every pair of occupied voxels
    /// is compared with the least distance so far, because a grid has no order by distance.
    pub fn distance_mm(&self, other: &Self, a_from_b: &Isometry, below_mm: f64) -> f64 {
        let (turn, placement) = (AlignedPose::new(a_from_b), Placement::new(a_from_b));
        let half = |grid: &Self| Vector::repeat(grid.pitch / 2.0 + grid.pad);
        let (half_a, half_b) = (half(self), half(other));
        let mine: Vec<usize> = self.occupied().collect();
        let mut least = below_mm;
        for voxel in other.occupied() {
            let centre = turn.point(&other.centre(voxel));
            let gap =
                |voxel: usize| gap_mm(&(centre - self.centre(voxel)), &turn.rotation, &turn.widened, &half_a, &half_b);
            let mut moved: Vec<Triangle> = Vec::new();
            for &voxel_a in &mine {
                if gap(voxel_a) >= least {
                    continue;
                }
                if moved.is_empty() {
                    let theirs = other.faces_in(voxel).iter();
                    moved.extend(theirs.map(|&face| placement.triangle(&other.triangles[face as usize])));
                }
                let faces = self.faces_in(voxel_a).iter().map(|&face| &self.triangles[face as usize]);
                least = nearest(faces, &moved, least);
            }
        }
        if least < below_mm { least } else { f64::INFINITY }
    }
}

/// The least distance between two lists of triangles, mm; `least` when that is smaller.
pub(super) fn nearest<'a>(mine: impl Iterator<Item = &'a Triangle>, theirs: &[Triangle], mut least: f64) -> f64 {
    for still in mine {
        for moved in theirs {
            if triangle_distance::exceeds(still, moved, least * least) {
                continue;
            }
            if certified::touch(still, moved) {
                return 0.0;
            }
            least = least.min(triangle_distance::squared(still, moved).sqrt());
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::traverse::Counts;
    use obbtree::cases::meshes;

    fn first(a: &Grid, b: &Grid, pose: &Isometry) -> (bool, Counts) {
        let mut counts = Counts::default();
        let stop = |_, _| ControlFlow::Break(());
        (a.visit(b, pose, &mut Scratch::default(), &mut counts, stop).is_break(), counts)
    }

    #[test]
    fn a_cuboid_is_divided_into_cubes() {
        // 12 triangles, 60 voxels wanted: 2 x 4 x 6 / 60 = 0.8, the pitch its cube root 0.928, so 3 x 5 x 7 voxels.
        let grid = Grid::build(meshes::cuboid(2.0, 4.0, 6.0).triangles());
        assert_eq!(grid.size, [3, 5, 7]);
        assert!((grid.pitch - 0.8_f64.cbrt()).abs() < 1e-6);
        // The inner 1 x 3 x 5 voxels hold nothing.
        assert_eq!((grid.voxel_count(), grid.occupied().count()), (105, 105 - 15));
        let bytes = 12 * 72 + 106 * 4 + grid.faces.len() * 4;
        assert_eq!(grid.bytes(), bytes);
    }

    #[test]
    fn a_quaternion_that_is_a_little_off_misplaces_nothing() {
        // Length 1 + 1e-9, as from a file with nine digits: the way back of 4000 mm is off by 8e-6 mm. Two cubes that share a face.
        let quaternion = nalgebra::Quaternion::new(0.5, 0.5, 0.5, 0.5) * (1.0 + 1e-9);
        let turn = nalgebra::UnitQuaternion::new_unchecked(quaternion);
        let pose = Isometry::from_parts(nalgebra::Translation3::new(-2000.0, 4000.0, -1000.0), turn);
        let near = Grid::build(meshes::cuboid(2.0, 2.0, 2.0).triangles());
        for side in [Vector::x(), -Vector::x(), Vector::y(), -Vector::y(), Vector::z(), -Vector::z()] {
            let by = Vector::new(-2000.0, 4000.0, -1000.0) + side * 2.0;
            let far = near.triangles().iter().map(|t| Triangle { corners: t.corners.map(|p| p + by) }).collect();
            assert!(first(&Grid::build(far), &near, &pose).0, "{side:?}");
        }
    }

    #[test]
    fn grids_apart_cost_one_test_and_a_flat_mesh_has_one_layer() {
        let cube = Grid::build(meshes::cuboid(2.0, 2.0, 2.0).triangles());
        let (touching, counts) = first(&cube, &cube, &Isometry::translation(2.1, 0.0, 0.0));
        assert_eq!((touching, counts), (false, Counts { volume_tests: 1, triangle_tests: 0 }));
        assert!(first(&cube, &cube, &Isometry::translation(2.0, 0.0, 0.0)).0);
        let flat = Grid::build(meshes::cuboid(2.0, 2.0, 2.0).triangles()[..1].to_vec());
        assert_eq!(flat.size.iter().filter(|&&n| n == 1).count(), 1);
    }
}
