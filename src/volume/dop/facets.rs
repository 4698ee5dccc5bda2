//! The facets of a k-DOP as polygons: for its volume, its area and its drawing.
//!
//! A facet starts as the parallelogram that two other slabs cut from its plane and is clipped by the remaining ones
//! (I. E. Sutherland, G. W. Hodgman, "Reentrant Polygon Clipping", CACM 17(1), 1974).

use super::{Directions, Dop};
use crate::geometry::{Point, Vector};

impl<D: Directions<N>, const N: usize> Dop<D, N> {
    /// Calls `visit(slab, side, corners)` for each facet, `side` being +1 or -1 and the corners in order around the facet
    /// (mm, mesh frame). Facets that other slabs cut away entirely are left out.
    pub(super) fn for_each_facet(&self, mut visit: impl FnMut(usize, f64, &[Point])) {
        let cones = D::cones();
        let (mut corners, mut clipped) = (Vec::with_capacity(2 * N), Vec::with_capacity(2 * N));
        for slab in 0..N {
            let start = cones.facet_corners(slab);
            let [j, k] = start.others;
            for side in [-1.0, 1.0] {
                corners.clear();
                corners.extend([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(u, v)| {
                    let along = Vector::new(
                        self.middle[slab] + side * self.half[slab],
                        self.middle[j] + u * self.half[j],
                        self.middle[k] + v * self.half[k],
                    );
                    Point::from(start.inverse * along)
                }));
                for other in (0..N).filter(|other| ![slab, j, k].contains(other)) {
                    let direction = &cones.directions()[other];
                    for sign in [-1.0, 1.0] {
                        let limit = sign * self.middle[other] + self.half[other];
                        clip(&corners, &(direction * sign), limit, &mut clipped);
                        std::mem::swap(&mut corners, &mut clipped);
                    }
                }
                if corners.len() >= 3 {
                    visit(slab, side, &corners);
                }
            }
        }
    }
}

/// The part of a convex polygon where `normal`·x ≤ `limit`.
fn clip(corners: &[Point], normal: &Vector, limit: f64, clipped: &mut Vec<Point>) {
    clipped.clear();
    for (i, corner) in corners.iter().enumerate() {
        let next = &corners[(i + 1) % corners.len()];
        let (here, there) = (normal.dot(&corner.coords) - limit, normal.dot(&next.coords) - limit);
        if here <= 0.0 {
            clipped.push(*corner);
        }
        if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
            clipped.push(corner + (next - corner) * (here / (here - there)));
        }
    }
}

/// Area of a plane convex polygon, mm².
pub(super) fn area(corners: &[Point]) -> f64 {
    let fan = corners[1..].windows(2).map(|pair| (pair[0] - corners[0]).cross(&(pair[1] - corners[0])));
    0.5 * fan.sum::<Vector>().norm()
}
