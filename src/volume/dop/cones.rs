//! The directions of a k-DOP, and which three of them surround any other direction.
//!
//! The unit normals ±u of the slabs are points on the unit sphere. The facets of their convex hull, seen from the origin,
//! are cones that cover space: 8, 12, 24, 32 and 48 of them for k = 6, 8, 14, 18 and 26.

use crate::geometry::Vector;
use nalgebra::Matrix3;
use parry3d_f64::transformation::convex_hull;

/// Directions and cones of one kind of k-DOP with `N` slabs.
#[derive(Clone, Debug)]
pub struct Cones<const N: usize> {
    directions: [Vector; N],
    cones: Vec<Cone>,
    corners: [FacetCorners; N],
}

/// Three of the directions, and how to combine others from them.
#[derive(Clone, Debug)]
struct Cone {
    slabs: [usize; 3],
    /// Direction `slabs[j]` points away from the cone where this is -1.
    signs: Vector,
    /// Takes a direction to its factors for the three signed directions; all are positive inside the cone.
    inverse: Matrix3<f64>,
}

/// How to find the corners of the parallelogram that two other slabs cut from the facets of one.
#[derive(Clone, Debug)]
pub(super) struct FacetCorners {
    /// The two other slabs: those that stand steepest to it and to one another.
    pub others: [usize; 2],
    /// Takes distances along the slab and the two others to the point.
    pub inverse: Matrix3<f64>,
}

impl<const N: usize> Cones<N> {
    /// From directions of any length, none parallel to another, at least three of them independent.
    ///
    /// # Panics
    /// When they are not: they are constants of the program.
    #[must_use]
    pub fn new(directions: [[f64; 3]; N]) -> Self {
        let directions = directions.map(|d| Vector::from(d).normalize());
        let cones = cones_of(&directions);
        let corners = std::array::from_fn(|slab| FacetCorners::new(&directions, slab));
        Self { directions, cones, corners }
    }

    /// The unit directions.
    #[must_use]
    pub const fn directions(&self) -> &[Vector; N] {
        &self.directions
    }

    pub(super) const fn facet_corners(&self, slab: usize) -> &FacetCorners {
        &self.corners[slab]
    }

    /// Three directions and the factors with which they add up to `e`, from the cone that contains `e`. Exact up to
    /// rounding; a factor is negative where the direction itself points away from `e`.
    #[must_use]
    pub fn combination(&self, e: &Vector) -> ([usize; 3], [f64; 3]) {
        let mut best = (f64::NEG_INFINITY, [0; 3], [0.0; 3]);
        for cone in &self.cones {
            let factors = cone.inverse * e;
            let smallest = factors.min();
            if smallest > best.0 {
                best = (smallest, cone.slabs, factors.component_mul(&cone.signs).into());
                if smallest >= 0.0 {
                    break;
                }
            }
        }
        (best.1, best.2)
    }
}

impl FacetCorners {
    fn new(directions: &[Vector], slab: usize) -> Self {
        let basis =
            |j: usize, k: usize| Matrix3::from_columns(&[directions[slab], directions[j], directions[k]]).transpose();
        let mut best = (0.0, [0; 2]);
        for j in 0..directions.len() {
            for k in j + 1..directions.len() {
                let steepness = basis(j, k).determinant().abs();
                if steepness > best.0 {
                    best = (steepness, [j, k]);
                }
            }
        }
        let [j, k] = best.1;
        Self { others: [j, k], inverse: basis(j, k).try_inverse().expect("three directions are independent") }
    }
}

/// The facets of the convex hull of the directions and their opposites.
fn cones_of(directions: &[Vector]) -> Vec<Cone> {
    let normals: Vec<_> = directions.iter().flat_map(|d| [(*d).into(), (-d).into()]).collect();
    let (points, facets) = convex_hull(&normals);
    let cone = |facet: &[u32; 3]| {
        let corners = facet.map(|corner| Vector::from(points[corner as usize]));
        let slabs = corners.map(|c| nearest(directions, &c));
        let signs = Vector::from_fn(|j, _| directions[slabs[j]].dot(&corners[j]).signum());
        let signed = std::array::from_fn::<_, 3, _>(|j| directions[slabs[j]] * signs[j]);
        let inverse = Matrix3::from_columns(&signed).try_inverse().expect("a facet of the hull spans a cone");
        Cone { slabs, signs, inverse }
    };
    facets.iter().map(cone).collect()
}

/// The direction most nearly parallel to `e`, either way round.
fn nearest(directions: &[Vector], e: &Vector) -> usize {
    let along = |i: &usize| directions[*i].dot(e).abs();
    (0..directions.len()).max_by(|i, j| along(i).total_cmp(&along(j))).expect("there are directions")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const COORDINATE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const CORNER: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0]];
    const EDGE: [[f64; 3]; 6] =
        [[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [0.0, 1.0, 1.0], [0.0, 1.0, -1.0]];

    fn join<const N: usize>(parts: &[&[[f64; 3]]]) -> [[f64; 3]; N] {
        parts.concat().try_into().unwrap()
    }

    #[test]
    fn there_are_as_many_cones_as_the_hull_has_facets() {
        assert_eq!(Cones::new(COORDINATE).cones.len(), 8);
        assert_eq!(Cones::new(CORNER).cones.len(), 12);
        assert_eq!(Cones::new(join::<7>(&[&COORDINATE, &CORNER])).cones.len(), 24);
        assert_eq!(Cones::new(join::<9>(&[&COORDINATE, &EDGE])).cones.len(), 32);
        assert_eq!(Cones::new(join::<13>(&[&COORDINATE, &CORNER, &EDGE])).cones.len(), 48);
    }

    #[test]
    fn the_x_axis_is_half_the_sum_of_two_opposite_corners_of_the_cube() {
        // (1,1,1)/√3 · √3/2 + (1,-1,-1)/√3 · √3/2 = (1,0,0), on the diagonal of a square facet of the hull.
        let (_, weights) = Cones::new(CORNER).combination(&Vector::x());
        let total: f64 = weights.iter().map(|w| w.abs()).sum();
        assert!((total - 3.0_f64.sqrt()).abs() < 1e-12);
    }

    fn check<const N: usize>(directions: [[f64; 3]; N], e: Vector) -> Result<(), TestCaseError> {
        let cones = Cones::new(directions);
        let (slabs, weights) = cones.combination(&e);
        let sum: Vector = slabs.iter().zip(weights).map(|(&i, w)| cones.directions[i] * w).sum();
        prop_assert!((sum - e).amax() < 1e-14, "{sum} is not {e}");
        // Inside a cone the factors of the signed directions are not negative, up to rounding.
        let inside = cones.cones.iter().any(|cone| (cone.inverse * e).min() > -1e-14);
        prop_assert!(inside);
        Ok(())
    }

    proptest! {
        #[test]
        fn every_direction_is_a_combination_of_three(x in -1.0..1.0, y in -1.0..1.0, z in -1.0..1.0) {
            let e = Vector::new(x, y, z);
            prop_assume!(e.norm() > 1e-3);
            check(CORNER, e.normalize())?;
            check(join::<13>(&[&COORDINATE, &CORNER, &EDGE]), e.normalize())?;
        }
    }
}
