//! Lines along which part `b` approaches part `a`, and first contact on them.

use super::PosedPair;
use crate::geometry::{Isometry, Mesh, Point, Triangle, Vector, triangle};
use crate::truth::PairOracle;
use nalgebra::{Translation3, Unit, UnitQuaternion};
use obbtree::cases::Draw;

/// Depths of a round: travel past first contact, mm, log-uniform in each interval, with one interval per depth band of the specification.
/// The first interval starts at twice the grazing limit, so that rounding makes none of its poses grazing. The deepest band is open-ended;
/// its interval ends at about the thickness of small tools.
const DEPTHS_MM: [(f64, f64); 6] = [(2e-6, 1e-3), (1e-3, 0.01), (0.01, 0.1), (0.1, 1.0), (1.0, 5.0), (5.0, 15.0)];

/// Like [`DEPTHS_MM`], before first contact: two intervals each for near miss, medium and far, so that a round has as many free as
/// colliding poses.
const DISTANCES_MM: [(f64, f64); 6] =
    [(1e-4, 1.0), (1e-4, 1.0), (1.0, 10.0), (1.0, 10.0), (10.0, 100.0), (10.0, 100.0)];

/// Poses of a round: one in each interval.
pub const POSES_PER_ROUND: usize = DEPTHS_MM.len() + DISTANCES_MM.len();

/// The data of a part for casting rays: its size, and its surface for drawing points.
pub struct Target {
    /// Half the diagonal of the bounding box, mm.
    pub radius: f64,
    triangles: Vec<Triangle>,
    /// Cumulated area of the triangles up to and including each, mm².
    areas: Vec<f64>,
}

impl Target {
    /// Computes the data of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let triangles = mesh.triangles();
        let (low, high) = triangle::bounds(&triangles).expect("a mesh has a triangle");
        let radius = (high - low).norm() / 2.0;
        let mut total = 0.0;
        let areas = triangles.iter().map(|triangle| {
            total += triangle.area();
            total
        });
        Self { radius, areas: areas.collect(), triangles }
    }

    /// A random point, uniform over the surface, in the part's frame, mm.
    pub fn point(&self, draw: &mut Draw) -> Point {
        let wanted = draw.unit() * self.areas[self.areas.len() - 1];
        let index = self.areas.partition_point(|&area| area <= wanted).min(self.triangles.len() - 1);
        let [a, b, c] = self.triangles[index].corners;
        let (mut u, mut v) = (draw.unit(), draw.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v); // folds the parallelogram onto the triangle
        }
        a + (b - a) * u + (c - a) * v
    }
}

/// A pair ready for rays.
pub struct Contact<'a> {
    /// Decides when the surfaces touch.
    pub oracle: &'a PairOracle,
    /// Part `a`.
    pub a: &'a Target,
    /// Part `b`.
    pub b: &'a Target,
}

/// A line of approach with its first contact.
#[derive(Clone, Debug)]
pub struct Ray {
    first_contact: Isometry,
    direction: Unit<Vector>,
}

impl Ray {
    /// The line through a relative pose along a direction (frame of `a`). Before first contact, the parts are disjoint at any distance.
    /// `None` when `b` passes without contact.
    pub fn cast(contact: &Contact<'_>, through: &Isometry, direction: Unit<Vector>) -> Option<Self> {
        let travel = contact.oracle.first_contact_mm(through, &direction)?;
        Some(Self { first_contact: moved(through, &direction, travel), direction })
    }

    /// The same line after the frames of both parts are rotated, `a`'s by `turn_a` and `b`'s by `turn_b`, while the parts stay in place.
    pub fn in_frames(&self, turn_a: &UnitQuaternion<f64>, turn_b: &UnitQuaternion<f64>) -> Self {
        let first_contact = *turn_a * self.first_contact * turn_b.inverse();
        Self { first_contact, direction: turn_a * self.direction }
    }

    /// The pose at a travel past first contact, mm; negative before it.
    pub fn at_depth(&self, depth_mm: f64) -> Isometry {
        moved(&self.first_contact, &self.direction, depth_mm)
    }

    /// The same pose as one of a cluster.
    pub fn posed(&self, cluster: usize, depth_mm: f64) -> PosedPair {
        PosedPair { a_from_b: self.at_depth(depth_mm), cluster: cluster as u32, line: None, depth_mm: Some(depth_mm) }
    }

    /// Poses at random depths and distances, in whole rounds.
    pub fn rounds(&self, cluster: usize, count: usize, draw: &mut Draw) -> Vec<PosedPair> {
        let depths = DEPTHS_MM.map(|(low, high)| (1.0, low, high));
        let distances = DISTANCES_MM.map(|(low, high)| (-1.0, low, high));
        let round = || depths.into_iter().chain(distances);
        let intervals = (0..count).flat_map(|_| round());
        intervals.map(|(sign, low, high)| self.posed(cluster, sign * draw.log_uniform(low, high))).collect()
    }
}

fn moved(pose: &Isometry, direction: &Unit<Vector>, travel_mm: f64) -> Isometry {
    Isometry::from_parts(Translation3::from(pose.translation.vector + **direction * travel_mm), pose.rotation)
}
