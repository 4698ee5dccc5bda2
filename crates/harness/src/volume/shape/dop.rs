//! Discrete oriented polytopes: slabs along K fixed directions of the mesh frame, tested at any relative pose by cone
//! duality.
//!
//! J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral, K. Zikan, "Efficient Collision Detection Using Bounding Volume Hierarchies of
//! k-DOPs", 1998; C. Ericson, "Real-Time Collision Detection", 2005, section 4.6. Deviation: they re-fit or hill-climb for a rotated
//! polytope. Here the extent along a direction e is bounded from outside. If e = λ₁u₁ + λ₂u₂ + λ₃u₃ with λ >= 0 over three outward normals
//! of the polytope, then every point x of the polytope has e·x <= λ₁h₁ + λ₂h₂ + λ₃h₃ (weak duality of linear programming). The triples
//! depend on the pose only, so a node pair costs three multiplications per slab and side.

use super::polytope::Polytope;
use crate::geometry::separating_axes::pad_mm;
use crate::geometry::{Isometry, Point, Triangle, Vector, rigid, triangle};
use crate::volume::{Segment, Shape, Solid, coordinate_axes_by_extent};
use nalgebra::{Matrix3, Unit};
use std::fmt::Debug;
use std::marker::PhantomData;
use std::sync::OnceLock;

/// A set of K directions.
pub trait Directions<const K: usize>: Clone + Debug + Send + Sync + 'static {
    /// K unit vectors; no two are opposite, and at least three are independent.
    const NORMALS: &'static [Vector; K];
    /// The cones over the facets of the hull of all 2K normals, computed once.
    fn cones() -> &'static OnceLock<Vec<Cone>>;
}

/// Three outward normals (indices 0..K for `+u`, K..2K for `-u`), and the matrix that gives the coordinates of a direction in them.
#[derive(Clone, Debug)]
pub struct Cone {
    members: [usize; 3],
    resolve: Matrix3<f64>,
}

/// Slabs along K directions, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct Dop<D, const K: usize> {
    /// Largest coordinate along `+u`.
    pub high: [f64; K],
    /// Largest coordinate along `-u` (the negated smallest along `+u`).
    pub negated_low: [f64; K],
    pub(super) directions: PhantomData<D>,
}

/// A direction of one polytope in the frame of the other, with the data that bound the other's extent along it.
#[derive(Clone, Copy, Debug)]
struct Bound {
    members: [usize; 3],
    weights: [f64; 3],
    /// Coordinate of the other mesh's origin along the direction, mm.
    shift: f64,
}

/// The bounds along the directions of the first polytope and of the second.
#[derive(Clone, Debug)]
pub struct DopPose<const K: usize> {
    along_a: [Bound; K],
    along_b: [Bound; K],
}

impl<D: Directions<K>, const K: usize> Dop<D, K> {
    /// The slabs around `triangles`, with a margin for rounding errors.
    pub fn around(triangles: &[Triangle]) -> Self {
        let (mut high, mut negated_low) = ([f64::NEG_INFINITY; K], [f64::NEG_INFINITY; K]);
        let mut reach: f64 = 0.0;
        for corner in triangle::corners(triangles) {
            for (k, normal) in D::NORMALS.iter().enumerate() {
                let x = normal.dot(&corner.coords);
                high[k] = high[k].max(x);
                negated_low[k] = negated_low[k].max(-x);
            }
            reach = reach.max(corner.coords.amax());
        }
        // Coordinates along a unit vector grow up to √3 times the largest coordinate.
        let pad = pad_mm(2.0 * reach);
        Self { high: high.map(|x| x + pad), negated_low: negated_low.map(|x| x + pad), directions: PhantomData }
    }

    /// Extent along an outward normal, mm.
    #[inline(always)]
    fn support(&self, member: usize) -> f64 {
        if member < K { self.high[member] } else { self.negated_low[member - K] }
    }

    /// An outer bound of this polytope's interval along a direction of the other mesh, in that mesh's frame: (-low, high).
    #[inline(always)]
    fn interval(&self, bound: &Bound) -> (f64, f64) {
        let (mut high, mut negated_low) = (bound.shift, -bound.shift);
        for (&member, weight) in bound.members.iter().zip(bound.weights) {
            let opposite = if member < K { member + K } else { member - K };
            high += weight * self.support(member);
            negated_low += weight * self.support(opposite);
        }
        (negated_low, high)
    }

    /// The point closest to the middle of all slabs in the least-squares sense. It can lie outside the polytope when slabs are wider than
    /// it.
    fn middle_of_slabs(&self) -> Point {
        let (mut gram, mut moment) = (Matrix3::zeros(), Vector::zeros());
        for (k, normal) in D::NORMALS.iter().enumerate() {
            gram += normal * normal.transpose();
            moment += normal * (0.5 * (self.high[k] - self.negated_low[k]));
        }
        Point::from(gram.try_inverse().unwrap_or_else(Matrix3::identity) * moment)
    }

    fn polytope(&self) -> Polytope {
        // The three widest-apart normals bound the polytope; a cube about its middle, twice its largest extent along any
        // slab divided by how flat the cones are, holds it.
        let size = self.high.iter().zip(&self.negated_low).map(|(high, low)| high + low).fold(0.0, f64::max);
        let normals = D::NORMALS;
        let slabs = normals.iter().zip(self.high.iter().zip(&self.negated_low));
        Polytope::cube(&self.middle_of_slabs(), 4.0 * size + 1.0)
            .clip(slabs.flat_map(|(n, (high, negated_low))| [(*n, *high), (-n, *negated_low)]))
    }
}

impl<D: Directions<K>, const K: usize> Shape for Dop<D, K> {
    type Pose = DopPose<K>;

    #[inline]
    fn pose(a_from_b: &Isometry) -> DopPose<K> {
        let rotation = rigid::rotation(a_from_b);
        let translation = a_from_b.translation.vector;
        let normals = D::NORMALS;
        DopPose {
            along_a: normals.map(|d| bound::<D, K>(&rotation.tr_mul(&d), d.dot(&translation))),
            along_b: normals.map(|d| bound::<D, K>(&(rotation * d), -(rotation * d).dot(&translation))),
        }
    }

    #[inline]
    fn overlaps(&self, other: &Self, pose: &DopPose<K>) -> bool {
        let disjoint = |own_high: f64, own_negated_low: f64, (negated_low, high): (f64, f64)| {
            high < -own_negated_low || -negated_low > own_high
        };
        for k in 0..K {
            if disjoint(self.high[k], self.negated_low[k], other.interval(&pose.along_a[k])) {
                return false;
            }
        }
        (0..K).all(|k| !disjoint(other.high[k], other.negated_low[k], self.interval(&pose.along_b[k])))
    }

    /// The widest gap along a normal of either polytope.
    fn gap_mm(&self, other: &Self, pose: &DopPose<K>) -> f64 {
        let gap = |own_high: f64, own_negated_low: f64, (negated_low, high): (f64, f64)| {
            (-own_negated_low - high).max(-negated_low - own_high)
        };
        (0..K).fold(0.0, |widest: f64, k| {
            let along_a = gap(self.high[k], self.negated_low[k], other.interval(&pose.along_a[k]));
            let along_b = gap(other.high[k], other.negated_low[k], self.interval(&pose.along_b[k]));
            widest.max(along_a).max(along_b)
        })
    }

    fn size(&self) -> f64 {
        self.high.iter().zip(&self.negated_low).map(|(high, negated_low)| (high + negated_low).powi(2)).sum()
    }

    /// The slabs are not orthogonal, so the split axes are the coordinate axes, ordered by the extent of the contents.
    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        let extents = triangle::bounds(triangles).map_or_else(Vector::zeros, |(low, high)| high - low);
        coordinate_axes_by_extent(&extents)
    }
}

impl<D: Directions<K>, const K: usize> Solid for Dop<D, K> {
    /// The slack applies to each slab, so beyond an edge or a corner a contained point may be slightly farther away than the slack.
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        D::NORMALS.iter().enumerate().all(|(k, normal)| {
            let x = normal.dot(&point.coords);
            x <= self.high[k] + slack_mm && -x <= self.negated_low[k] + slack_mm
        })
    }

    /// The mean of the corners; a corner counts once for every edge that ends there.
    fn centre(&self) -> Point {
        let ends = self.polytope().edges().into_iter().flatten().map(|end| end.coords);
        let (count, sum) = ends.fold((0.0, Vector::zeros()), |(count, sum), end| (count + 1.0, sum + end));
        if count > 0.0 { Point::from(sum / count) } else { self.middle_of_slabs() }
    }

    fn volume(&self) -> f64 {
        self.polytope().volume()
    }

    fn surface_area(&self) -> f64 {
        self.polytope().surface_area()
    }

    fn outline(&self) -> Vec<Segment> {
        self.polytope().edges()
    }
}

/// The cone that contains `direction` (unit length), and the weights of its normals. Rounding may make the smallest weight about -1e-16; it
/// is then set to zero, and the pad of the polytopes covers the difference.
fn bound<D: Directions<K>, const K: usize>(direction: &Vector, shift: f64) -> Bound {
    let cones = D::cones().get_or_init(|| cones_over_facets(D::NORMALS));
    let mut best = (f64::NEG_INFINITY, [0; 3], Vector::zeros());
    for cone in cones {
        let weights = cone.resolve * direction;
        let smallest = weights.min();
        if smallest > best.0 {
            best = (smallest, cone.members, weights);
            if smallest >= 0.0 {
                break;
            }
        }
    }
    Bound { members: best.1, weights: best.2.map(|weight| weight.max(0.0)).into(), shift }
}

/// The facets of the convex hull of all normals and their opposites, each divided into triangles.
fn cones_over_facets(normals: &[Vector]) -> Vec<Cone> {
    /// Unit normals of one facet agree in height to rounding; those of different facets differ by far more.
    const COPLANAR: f64 = 1e-9;
    let all: Vec<Vector> = normals.iter().copied().chain(normals.iter().map(|n| -n)).collect();
    let mut facets: Vec<Vec<usize>> = Vec::new();
    for i in 0..all.len() {
        for j in i + 1..all.len() {
            for k in j + 1..all.len() {
                let Some(mut outward) = (all[j] - all[i]).cross(&(all[k] - all[i])).try_normalize(COPLANAR) else {
                    continue;
                };
                if outward.dot(&all[i]) < 0.0 {
                    outward = -outward;
                }
                let height = outward.dot(&all[i]);
                if height < COPLANAR || all.iter().any(|n| outward.dot(n) > height + COPLANAR) {
                    continue;
                }
                let members: Vec<usize> =
                    (0..all.len()).filter(|&m| outward.dot(&all[m]) > height - COPLANAR).collect();
                let u = (all[members[0]] - outward * height).normalize();
                let v = outward.cross(&u);
                let mut facet = members;
                facet.sort_by(|&a, &b| {
                    let angle = |m: usize| v.dot(&all[m]).atan2(u.dot(&all[m]));
                    angle(a).total_cmp(&angle(b))
                });
                if facets.iter().all(|known| facet.iter().any(|m| !known.contains(m))) {
                    facets.push(facet);
                }
            }
        }
    }
    let fan = |facet: &Vec<usize>| facet.windows(2).skip(1).map(|w| [facet[0], w[0], w[1]]).collect::<Vec<_>>();
    let cone = |members: [usize; 3]| {
        let matrix = Matrix3::from_columns(&members.map(|m| all[m]));
        matrix.try_inverse().map(|resolve| Cone { members, resolve })
    };
    facets.iter().flat_map(fan).filter_map(cone).collect()
}

#[cfg(test)]
mod tests;
