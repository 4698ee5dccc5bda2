//! Spatial decomposition over the triangles of one mesh: space is divided, not the mesh, and a triangle belongs to every
//! piece of space that it reaches into.
//!
//! The other family of methods beside trees of bounding volumes, here so that both are measured on the same poses: a
//! [`grid`] of equal voxels, and an [`octree`]. Both stay in their mesh's frame like the trees do; a query finds pieces of the
//! two meshes that overlap and hands their triangles to the test all methods share.
//!
//! Why nothing is missed: a point that a moved, snapped triangle of the second mesh shares with one of the first lies in some
//! piece of the first mesh, and brought back within [`grid::SNAP_RADIUS_MM`](crate::geometry::grid::SNAP_RADIUS_MM) of the triangle
//! in some piece of the second. Both triangles are entered in these pieces, because a triangle is entered in every piece
//! within a pad of it, and the pieces overlap, because they are widened by a pad ([`pad_mm`]) too.

pub mod grid;
pub mod octree;

use crate::geometry::plane::Plane;
use crate::geometry::{Isometry, Point, Triangle, Vector, rigid, triangle};
use crate::volume::shape::separating_axes::{pad_mm, widened_abs};
use nalgebra::Matrix3;

/// Effect of a pose's rotation on axis-aligned boxes, computed once per query.
struct Turn {
    rotation: Matrix3<f64>,
    widened: Matrix3<f64>,
    translation: Vector,
}

impl Turn {
    fn new(pose: &Isometry) -> Self {
        let rotation = rigid::rotation(pose);
        Self { rotation, widened: widened_abs(&rotation), translation: pose.translation.vector }
    }

    fn point(&self, p: &Point) -> Point {
        Point::from(self.rotation * p.coords + self.translation)
    }
}

/// The bounds of triangles, widened by twice their pad, mm; and the pad. Without triangles the origin.
fn padded_bounds(triangles: &[Triangle]) -> (Point, Point, f64) {
    let (low, high) = triangle::bounds(triangles).unwrap_or((Point::origin(), Point::origin()));
    let pad = pad_mm(low.coords.amax().max(high.coords.amax()));
    let margin = Vector::repeat(2.0 * pad);
    (low - margin, high + margin, pad)
}

/// Whether a triangle may reach into the box about `centre` with half-lengths `half`, mm: apart by the box's normals or the
/// triangle's is apart; what only the products of edges would tell apart is let in.
fn may_reach(triangle: &Triangle, centre: &Point, half: &Vector) -> bool {
    let (low, high) = triangle.bounds();
    if (0..3).any(|i| low[i] > centre[i] + half[i] || high[i] < centre[i] - half[i]) {
        return false;
    }
    Plane::of(triangle).may_meet_box(centre, half)
}

/// Whether the bounds of a triangle overlap the box about `centre` with half-lengths `half`, mm.
#[inline(always)]
fn bounds_overlap(triangle: &Triangle, centre: &Point, half: &Vector) -> bool {
    let [a, b, c] = &triangle.corners;
    (0..3).all(|i| {
        let (low, high) = (a[i].min(b[i]).min(c[i]), a[i].max(b[i]).max(c[i]));
        low <= centre[i] + half[i] && high >= centre[i] - half[i]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_is_told_apart_by_its_bounds_and_by_its_plane() {
        let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
        // The plane x + y + z = 3 passes the unit cube about the origin at distance √3 and the cube's corner at √3/2 lies below.
        let slanted = Triangle::new(p(3.0, 0.0, 0.0), p(0.0, 3.0, 0.0), p(0.0, 0.0, 3.0));
        let half = Vector::repeat(0.5);
        assert!(!may_reach(&slanted, &Point::origin(), &half)); // its bounds hold the cube's corner (0.5, 0.5, 0.5)
        assert!(bounds_overlap(&slanted, &Point::origin(), &half));
        assert!(may_reach(&slanted, &Point::origin(), &Vector::repeat(1.0))); // the corner (1, 1, 1) lies on the plane
        assert!(!bounds_overlap(&slanted, &p(-0.6, 0.0, 0.0), &half));
    }
}
