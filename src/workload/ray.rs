//! Lines along which part `b` approaches part `a`, and first contact on them.

use crate::geometry::{Isometry, Mesh, Point, Triangle, Vector, triangle};
use crate::truth::PairOracle;
use nalgebra::{Translation3, Unit, UnitQuaternion};
use obbtree::cases::Draw;

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
    #[must_use]
    pub fn in_frames(&self, turn_a: &UnitQuaternion<f64>, turn_b: &UnitQuaternion<f64>) -> Self {
        let first_contact = *turn_a * self.first_contact * turn_b.inverse();
        Self { first_contact, direction: turn_a * self.direction }
    }

    /// The pose at a travel past first contact, mm; negative before it.
    pub fn at_depth(&self, depth_mm: f64) -> Isometry {
        moved(&self.first_contact, &self.direction, depth_mm)
    }
}

fn moved(pose: &Isometry, direction: &Unit<Vector>, travel_mm: f64) -> Isometry {
    Isometry::from_parts(Translation3::from(pose.translation.vector + **direction * travel_mm), pose.rotation)
}
