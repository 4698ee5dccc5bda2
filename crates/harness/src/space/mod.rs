//! Spatial decomposition over the triangles of one mesh: space is divided instead of the mesh, and a triangle belongs to every cell that it
//! reaches into.
//!
//! Spatial decomposition is the second family of methods besides trees of bounding volumes, and is measured at the same poses. There is a [`grid`] of
//! equal voxels, and an [`octree`]. Like the trees, both stay in their mesh's frame. A query finds overlapping cells of the two meshes and
//! passes their triangles to the triangle test that all methods share.
//!
//! No contact is missed. Take a point that a moved, snapped triangle of the second mesh shares with a triangle of the first. It lies in
//! some cell of the first mesh. Moved back to the second mesh's frame, it is within
//! [`grid::SNAP_RADIUS_MM`](crate::geometry::grid::SNAP_RADIUS_MM) of the triangle there, in some cell of the second mesh. Both triangles
//! are entered in these cells, because a triangle is entered in every cell within a pad of it. The cells overlap in the test, because they
//! too are widened by a pad ([`pad_mm`]).

pub mod grid;
pub mod octree;

use crate::geometry::plane::Plane;
use crate::geometry::separating_axes::pad_mm;
use crate::geometry::{Point, Triangle, Vector, triangle};

/// Low corner and high corner of the bounding box of triangles, widened by twice the pad, and the pad itself; all mm. Without triangles, the
/// box is the origin.
fn padded_bounds(triangles: &[Triangle]) -> (Point, Point, f64) {
    let (low, high) = triangle::bounds(triangles).unwrap_or((Point::origin(), Point::origin()));
    let pad = pad_mm(low.coords.amax().max(high.coords.amax()));
    let margin = Vector::repeat(2.0 * pad);
    (low - margin, high + margin, pad)
}

/// Whether a triangle may reach into the box about `centre` with half-lengths `half`, mm. Tests the normals of the box and of the triangle;
/// the cross products of edges are not tested, so the answer may be true for disjoint pairs.
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
