//! The uncut workpiece: its triangles, or, of one that turns, the body of revolution around it as squares of (ρ, z) meet it.

use super::convex::{Cube as Around, Least};
use super::round::Round;
use super::tile::Cube;
use super::{ROUNDING_MM, StockError};
use crate::geometry::plane::Plane;
use crate::geometry::{Isometry, Mesh, Point, Triangle, Vector};
use crate::interference::ROUND;
use crate::truth::Solid;
use std::sync::Arc;

/// The uncut workpiece.
#[derive(Debug)]
pub(super) enum Blank {
    Mesh {
        triangles: Vec<Triangle>,
        solid: Solid,
    },
    Turned {
        round: Round,
        /// Takes a place (ρ, 0, z) to the body's frame.
        body_from_axis: Isometry,
        /// Takes the workpiece's frame to that of its axis.
        axis_from_stock: Isometry,
    },
}

impl Blank {
    /// The body of revolution around a mesh.
    ///
    /// # Errors
    /// [`StockError::NotRound`] when the mesh is not round about z of the axis's frame.
    pub fn turned(mesh: &Arc<Mesh>, axis_from_stock: Isometry) -> Result<Self, StockError> {
        let round = Round::stock(mesh);
        let body_from_axis = round.body_from_part * axis_from_stock.inverse();
        let direction = body_from_axis * Vector::z();
        let origin = body_from_axis * Point::origin();
        let size = round.radius_mm.max(1.0);
        // A turn by this is off by less than rounding at the end of the workpiece.
        let is_one =
            direction.x.hypot(direction.y) * size.max(round.span_mm[1] - round.span_mm[0]) <= 10.0 * ROUNDING_MM;
        if !is_one || origin.x.hypot(origin.y) > 10.0 * ROUNDING_MM || round.filled < ROUND || !round.is_known() {
            return Err(StockError::NotRound);
        }
        Ok(Self::Turned { round, body_from_axis, axis_from_stock })
    }

    pub const fn is_turned(&self) -> bool {
        matches!(self, Self::Turned { .. })
    }

    /// A point of the workpiece's frame where the tiles have it.
    pub fn place(&self, point: &Point) -> Point {
        match self {
            Self::Mesh { .. } => *point,
            Self::Turned { axis_from_stock, .. } => {
                let at = axis_from_stock * point;
                Point::new(at.x.hypot(at.y), 0.0, at.z)
            }
        }
    }

    /// Which of the borders may run through a cell; of one that turns the only one has number 0.
    pub fn meeting(&self, borders: &[u32], cube: &Cube) -> Vec<u32> {
        match self {
            Self::Mesh { triangles, .. } => borders
                .iter()
                .filter(|&&index| may_meet(&triangles[index as usize], &cube.centre, cube.half))
                .copied()
                .collect(),
            Self::Turned { .. } => {
                let is_border = |_: &&u32| {
                    let Least { high, deep, .. } = self.least(&cube.centre, cube.half);
                    deep < ROUNDING_MM && high > -cube.radius() - ROUNDING_MM
                };
                borders.iter().filter(is_border).copied().collect()
            }
        }
    }

    /// Whether a place is in the workpiece; asked only of cells through which no border runs.
    pub fn holds(&self, place: &Point) -> bool {
        match self {
            Self::Mesh { solid, .. } => solid.holds(place),
            Self::Turned { .. } => self.least(place, 0.0).high < 0.0,
        }
    }

    fn least(&self, place: &Point, half: f64) -> Least {
        let Self::Turned { round, body_from_axis, .. } = self else {
            return Least { low: 0.0, high: 0.0, deep: 0.0 };
        };
        let axes = [Vector::x(), Vector::y(), Vector::z()].map(|axis| body_from_axis * axis);
        let around = Around { half, radius: half * 3f64.sqrt(), axes, inside: f64::NEG_INFINITY, outside: 0.0 };
        round.least(&(body_from_axis * place).coords, &Vector::zeros(), &around)
    }
}

/// Whether a triangle may meet a cube: no axis parts them by more than rounding. Such axes are the cube's, the triangle's normal, and the products of
/// their edges (T. Akenine-Möller 2001).
fn may_meet(triangle: &Triangle, centre: &Point, half: f64) -> bool {
    let (low, high) = triangle.bounds();
    let in_box = (0..3).all(|k| low[k] <= centre[k] + half && high[k] >= centre[k] - half);
    in_box
        && Plane::of(triangle).may_meet_box(centre, &Vector::repeat(half))
        && !is_parted_by_edges(triangle, centre, half)
}

/// Whether a plane along an edge of the cube and an edge of the triangle lies between the two.
fn is_parted_by_edges(triangle: &Triangle, centre: &Point, half: f64) -> bool {
    let corners = triangle.corners.map(|corner| corner - centre);
    let parts = |axis: Vector| {
        let [p, q, r] = corners.map(|corner| corner.dot(&axis));
        let reach = (half + ROUNDING_MM) * axis.abs().sum();
        p.min(q).min(r) > reach || p.max(q).max(r) < -reach
    };
    let edges = [0, 1, 2].map(|k| corners[(k + 1) % 3] - corners[k]);
    edges.iter().any(|edge| [Vector::x(), Vector::y(), Vector::z()].iter().any(|side| parts(edge.cross(side))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Corners of the part of a triangle that lies in a cube; none where it lies outside.
    fn clipped(triangle: &Triangle, centre: &Point, half: f64) -> Vec<Point> {
        let mut left = triangle.corners.to_vec();
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let beyond = |p: &Point| sign * (p[axis] - centre[axis]) - half;
            let mut next = Vec::new();
            for (p, q) in left.iter().zip(left.iter().cycle().skip(1)) {
                let (from, to) = (beyond(p), beyond(q));
                if from <= 0.0 {
                    next.push(*p);
                }
                if (from <= 0.0) != (to <= 0.0) {
                    next.push(p + (q - p) * (from / (from - to)));
                }
            }
            left = next;
        }
        left
    }

    proptest! {
        #[test]
        fn a_triangle_may_meet_a_cube_where_something_is_left_of_it_there(
            corners in prop::array::uniform3(prop::array::uniform3(-10.0..10.0_f64)),
            centre in prop::array::uniform3(-8.0..8.0_f64),
            half in 0.1..4.0_f64,
        ) {
            let triangle = Triangle { corners: corners.map(Point::from) };
            let centre = Point::from(centre);
            let found = may_meet(&triangle, &centre, half);
            prop_assert!(found || clipped(&triangle, &centre, half).is_empty());
            prop_assert!(!found || !clipped(&triangle, &centre, half + 1e-6).is_empty());
        }
    }
}
