//! The traits of a bounding volume: one for its fit, one for its tests, and one for drawings and sizes.
//!
//! A variant ([`BoundingVolume`]) puts a shape around triangles; a shape ([`Shape`]) is what a tree tests. Variants that differ only in the
//! fit share a shape, and therefore every instruction of a query. The variants that ship are files of the package `bvbench`, each named in
//! a `mod` line and a line of its registry. A variant with a shape of its own implements all three traits in its file.
//! Another crate can add a variant without touching this one, by [`crate::registry::Registry::with`] (`examples/my_volume.rs`).

pub mod consistency;
pub mod fit;
pub mod shape;
/// The variants of the package `bvbench`, for tests.
#[cfg(test)]
#[path = "../../../../src/volume/mod.rs"]
mod variants;

#[cfg(test)]
pub use variants::*;

use crate::geometry::{Isometry, Point, Triangle, Vector};
use nalgebra::{Matrix3, Unit};
use shape::obb::Obb;
use std::fmt::Debug;

/// Name, source and safety of a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Info {
    /// Id in every file and on the command line, lower case with hyphens, such as `sphere-ritter`.
    pub id: &'static str,
    /// Name in tables and plots.
    pub label: &'static str,
    /// Source: authors, year, section.
    pub reference: &'static str,
    /// Whether `overlaps` is true whenever the contents touch. Variants that cannot guarantee it are measured too, but never ranked by
    /// speed: a method can look fast because it misses collisions.
    pub safe: bool,
}

/// A line segment for drawing, mm, in the frame of the mesh.
pub type Segment = [Point; 2];

/// A variant: the fit of a shape around triangles.
pub trait BoundingVolume: 'static {
    /// Name of the variant, and whether it is safe.
    const INFO: Info;

    /// The shape that the fit produces.
    type Shape: Shape;

    /// The shape around `triangles` (mm, mesh frame). `triangles` is never empty, but may hold degenerate triangles, a single triangle, or
    /// the same triangle many times. A safe volume contains every corner, with a margin for rounding errors.
    fn fit(triangles: &[Triangle]) -> Self::Shape;
}

/// A volume around some triangles of one mesh, in the mesh's own frame (mm); each node of a tree holds one.
///
/// The tree over a mesh never moves. A query computes the constants of the relative pose of the two meshes once ([`Shape::pose`]) and
/// passes them to every overlap test of that query. A shape owns no memory besides its own size (no `Vec`, no `Box`), which
/// [`crate::tree::Tree::bytes`] asserts when it is compiled.
pub trait Shape: Solid + Clone + Debug + 'static {
    /// The constants of one relative pose: computed once per query, never per node.
    type Pose;

    /// The constants for overlap tests between volumes of mesh `a` (left) and mesh `b` (right). The rotation comes from
    /// [`crate::geometry::rigid`], like the rotation of the leaves. A quaternion of length 1 ± 1e-7, if used unchanged, would stretch the
    /// volumes of `b` by 2e-7 of their distance from the origin, and a safe volume would miss contacts.
    fn pose(a_from_b: &Isometry) -> Self::Pose;

    /// Whether this volume of mesh `a` and `other` of mesh `b` may touch at the pose. For a safe volume it is true whenever their contents
    /// touch, with the vertices of `b` moved and snapped by [`crate::geometry::grid::Placement`]. It may be true for disjoint volumes.
    fn overlaps(&self, other: &Self, pose: &Self::Pose) -> bool;

    /// A lower bound of the distance between this volume of mesh `a` and `other` of mesh `b` at the pose, mm; at least 0. For a safe
    /// volume, it is also a lower bound of the distance between their contents.
    fn gap_mm(&self, other: &Self, pose: &Self::Pose) -> f64;

    /// Size of the volume, by which the traversal chooses which of two nodes to open. It may be any measure that grows with the extent, and
    /// must be cheap, because it is computed for every node of a tree. Sizes are compared only between volumes of one shape.
    fn size(&self) -> f64;

    /// Three orthogonal directions along which a node may be split, longest extent first. Shapes without axes of their own compute them
    /// from `triangles`, to which the volume was fitted.
    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3];
}

/// A body in space: the operations that drawings, tightness and containment checks need of a shape. No query calls them.
pub trait Solid: Send + Sync {
    /// Whether `point` (mm, mesh frame) lies inside or within `slack_mm` of the volume.
    fn contains(&self, point: &Point, slack_mm: f64) -> bool;

    /// The middle of the volume (mm, mesh frame).
    fn centre(&self) -> Point;

    /// Volume, mm³.
    fn volume(&self) -> f64;

    /// Surface area, mm².
    fn surface_area(&self) -> f64;

    /// Line segments that show the volume (mm, mesh frame). Drawings use them, and `hausdorff_mm` and `sibling_overlap_mm3` of
    /// `tightness.csv` and `trees.csv` are measured on the hull of their ends. They must therefore extend as far as the volume.
    fn outline(&self) -> Vec<Segment>;

    /// Orthogonal directions (columns) along which `outline` reaches as far as the volume, and in which the volume fills most of the box
    /// around it. The overlap of siblings is sampled in such a box.
    fn axes(&self) -> Matrix3<f64> {
        self.as_box().map_or_else(Matrix3::identity, |own| own.axes)
    }

    /// The volume as an oriented box, for shapes that are boxes; `None` for others. It is used to count where separating-axis tests end
    /// ([`shape::obb::exit`]).
    fn as_box(&self) -> Option<Obb> {
        None
    }
}

/// The coordinate axes ordered by decreasing `extents`; equal extents keep the order x, y, z.
pub fn coordinate_axes_by_extent(extents: &Vector) -> [Unit<Vector>; 3] {
    axes_by_extent(&Matrix3::identity(), extents)
}

/// Axes (columns) ordered by decreasing `extents` along them; equal extents keep their order.
pub fn axes_by_extent(axes: &Matrix3<f64>, extents: &Vector) -> [Unit<Vector>; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| extents[j].total_cmp(&extents[i]));
    order.map(|column| Unit::new_unchecked(axes.column(column).into_owned()))
}

/// The surface area of a box with the given half-lengths (mm), mm².
pub fn box_area(half: &Vector) -> f64 {
    8.0 * (half.x * half.y + half.y * half.z + half.z * half.x)
}

/// The twelve edges of a box with the given centre (mm), axes (columns) and half-lengths (mm).
pub fn box_outline(centre: &Point, axes: &Matrix3<f64>, half: &Vector) -> Vec<Segment> {
    let corner = |signs: [f64; 3]| centre + axes * Vector::from(signs).component_mul(half);
    let mut edges = Vec::with_capacity(12);
    for along in 0..3 {
        for (s, t) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let mut ends = [[0.0; 3]; 2];
            for (end, sign) in ends.iter_mut().zip([-1.0, 1.0]) {
                end[along] = sign;
                end[(along + 1) % 3] = s;
                end[(along + 2) % 3] = t;
            }
            edges.push(ends.map(corner));
        }
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::grid::SNAP_RADIUS_MM;
    use obbtree::cases::meshes;

    /// Checks that a safe volume contains its moved corners after snapping, which displaces them by up to the snap radius in any direction.
    fn holds_snapped_corners<V: BoundingVolume>() {
        let turn = Isometry::new(Vector::new(7.0, -3.0, 2.0), Vector::new(0.4, -0.7, 0.3));
        for mesh in [meshes::cuboid(2.0, 3.0, 5.0), meshes::stepped_tool(8, 4)] {
            let triangles: Vec<Triangle> = mesh.triangles().iter().map(|t| t.map(|p| turn * p)).collect();
            for part in [&triangles[..], &triangles[..1]] {
                let volume = V::fit(part);
                for corner in part.iter().flat_map(|t| t.corners) {
                    for direction in [Vector::x(), Vector::y(), Vector::z(), corner - volume.centre()] {
                        for way in [-SNAP_RADIUS_MM, SNAP_RADIUS_MM] {
                            let snapped = corner + direction.normalize() * way;
                            assert!(
                                volume.contains(&snapped, 0.0),
                                "{}: {corner} by {way} along {direction}",
                                V::INFO.id
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn safe_volumes_hold_what_snapping_moves_out_of_their_contents() {
        holds_snapped_corners::<sphere_ritter::SphereRitter>();
        holds_snapped_corners::<sphere_welzl::SphereWelzl>();
        holds_snapped_corners::<sphere_mean::SphereMean>();
        holds_snapped_corners::<aabb::Aabb>();
        holds_snapped_corners::<dop_6::Dop6>();
        holds_snapped_corners::<dop_8::Dop8>();
        holds_snapped_corners::<dop_14::Dop14>();
        holds_snapped_corners::<dop_26::Dop26>();
        holds_snapped_corners::<rss::Rss>();
        holds_snapped_corners::<obbrss::ObbRss>();
        holds_snapped_corners::<obb_vertex::ObbVertex>();
        holds_snapped_corners::<obb_area::ObbArea>();
        holds_snapped_corners::<obb_dito14::ObbDito14>();
        holds_snapped_corners::<obb_min::ObbMin>();
        holds_snapped_corners::<obb_hull_area::ObbHullArea>();
    }

    /// A cuboid of 20 by 12 by 4 mm far from its origin, against itself turned about its own middle and shifted.
    fn says_where_a_cuboid_is<V: BoundingVolume>() {
        let (id, middle) = (V::INFO.id, Point::new(30.0, -20.0, 10.0));
        let place = Isometry::translation(middle.x, middle.y, middle.z);
        let cuboid = |scale: f64| meshes::moved(&meshes::cuboid(20.0, 12.0, 4.0), scale, &place).triangles();
        let volume = V::fit(&cuboid(1.0));
        assert!((volume.centre() - middle).norm() < 2.0, "{id}: {}", volume.centre());
        assert!(volume.contains(&middle, 0.0) && !volume.contains(&Point::origin(), 1.0), "{id}");
        // What is convex and holds the cuboid has no less volume or surface.
        assert!(volume.volume() >= 960.0 - 1e-6 && volume.surface_area() >= 736.0 - 1e-6, "{id}");
        let sizes = [0.25, 0.5, 1.0, 2.0].map(|scale| V::fit(&cuboid(scale)).size());
        assert!(sizes[0] > 0.0 && sizes.windows(2).all(|pair| pair[1] > 1.5 * pair[0]), "{id}: {sizes:?}");
        // What is drawn is the volume's own surface, all around its contents.
        let ends: Vec<Point> = volume.outline().into_iter().flatten().collect();
        let is_on_surface = |end: &Point| {
            let beyond = middle + (end - middle) * 1.001;
            volume.contains(end, 1e-4) && !volume.contains(&beyond, 0.0)
        };
        assert!(ends.iter().all(is_on_surface), "{id}");
        for corner in cuboid(1.0).iter().flat_map(|triangle| triangle.corners) {
            for way in [Vector::x(), Vector::y(), Vector::z()] {
                let way = way * way.dot(&(corner - middle)).signum();
                assert!(ends.iter().any(|end| way.dot(&(end - corner)) > -1e-6), "{id}: {corner} along {way}");
            }
        }
        // Its half-lengths along the axes where it stands turned, and as it is.
        for (turn, [x, y, z]) in [
            ([0.0; 3], [10.0, 6.0, 2.0]),
            ([0.0, 0.0, 180.0], [10.0, 6.0, 2.0]),
            ([0.0, 0.0, 90.0], [6.0, 10.0, 2.0]),
            ([0.0, 90.0, 0.0], [2.0, 6.0, 10.0]),
            ([90.0, 0.0, 0.0], [10.0, 2.0, 6.0]),
        ] {
            let [roll, pitch, yaw] = turn.map(f64::to_radians);
            let rotation = nalgebra::UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            for (axis, way) in [10.0 + x, 6.0 + y, 2.0 + z].into_iter().enumerate() {
                for sign in [-1.0, 1.0] {
                    let at = |shift: f64| {
                        let to = middle.coords + Vector::ith(axis, sign * shift) - rotation * middle.coords;
                        V::Shape::pose(&Isometry::from_parts(to.into(), rotation))
                    };
                    let gap = volume.gap_mm(&volume, &at(100.0));
                    assert!(gap > 25.0 && gap <= 100.0 - way + 1e-6, "{id}: {gap} along {axis} by {sign}, {turn:?}");
                    assert!(!volume.overlaps(&volume, &at(100.0)), "{id}: apart along {axis} by {sign}, {turn:?}");
                    let touching = at(way - 0.1);
                    assert!(volume.overlaps(&volume, &touching), "{id}: touching along {axis} by {sign}, {turn:?}");
                    assert!(
                        volume.gap_mm(&volume, &touching) < 1e-9,
                        "{id}: touching along {axis} by {sign}, {turn:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn every_shape_says_where_a_cuboid_is() {
        says_where_a_cuboid_is::<sphere_ritter::SphereRitter>();
        says_where_a_cuboid_is::<sphere_ritter_f32::SphereRitterF32>();
        says_where_a_cuboid_is::<aabb::Aabb>();
        says_where_a_cuboid_is::<aabb_f32::AabbF32>();
        says_where_a_cuboid_is::<aabb_sat6::AabbSat6>();
        says_where_a_cuboid_is::<aabb_refit::AabbRefit>();
        says_where_a_cuboid_is::<dop_6::Dop6>();
        says_where_a_cuboid_is::<dop_8::Dop8>();
        says_where_a_cuboid_is::<dop_8_f32::Dop8F32>();
        says_where_a_cuboid_is::<dop_8_vertex::Dop8Vertex>();
        says_where_a_cuboid_is::<dop_14::Dop14>();
        says_where_a_cuboid_is::<dop_18::Dop18>();
        says_where_a_cuboid_is::<dop_26::Dop26>();
        says_where_a_cuboid_is::<rss::Rss>();
        says_where_a_cuboid_is::<obbrss::ObbRss>();
        says_where_a_cuboid_is::<obb_area::ObbArea>();
        says_where_a_cuboid_is::<obb_area_f32::ObbAreaF32>();
    }

    #[test]
    fn boxes_have_areas_and_edges() {
        // Sides of 2, 4 and 6 mm: 2 (8 + 24 + 12) = 88 mm²; four edges of each length, 48 mm in all.
        let half = Vector::new(1.0, 2.0, 3.0);
        assert_eq!(box_area(&half), 88.0);
        let edges = box_outline(&Point::new(1.0, 1.0, 1.0), &Matrix3::identity(), &half);
        let mut lengths: Vec<f64> = edges.iter().map(|[p, q]| (q - p).norm()).collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths, [2.0, 2.0, 2.0, 2.0, 4.0, 4.0, 4.0, 4.0, 6.0, 6.0, 6.0, 6.0]);
        let is_corner = |p: &Point| (p - Point::new(1.0, 1.0, 1.0)).abs() == half;
        assert!(edges.iter().flatten().all(is_corner));
        let is_once =
            |[p, q]: &Segment| edges.iter().filter(|[r, s]| [r, s] == [p, q] || [s, r] == [p, q]).count() == 1;
        assert!(edges.iter().all(is_once));
        let axes = coordinate_axes_by_extent(&Vector::new(2.0, 3.0, 2.0));
        assert_eq!(axes, [Vector::y_axis(), Vector::x_axis(), Vector::z_axis()]);
    }
}
