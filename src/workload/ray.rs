//! Lines along which part `b` comes to part `a` from far away, and first contact on them.

use super::draw::Draw;
use crate::geometry::{Isometry, Mesh, Point, Triangle, Vector, triangle};
use crate::truth::PairOracle;
use nalgebra::{Translation3, Unit};

/// A part as the rays see it: a ball around it, and its surface to pick points from.
pub struct Target {
    /// Centre of the bounding box, part frame, mm.
    pub centre: Point,
    /// Distance of the farthest corner from `centre`, mm.
    pub radius: f64,
    triangles: Vec<Triangle>,
    /// Area of the triangles up to and with each, mm².
    areas: Vec<f64>,
}

impl Target {
    /// What the rays need to know of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let triangles = mesh.triangles();
        let (low, high) = triangle::bounds(&triangles).expect("a mesh has a triangle");
        let centre = nalgebra::center(&low, &high);
        let radius = mesh.vertices().iter().map(|vertex| (vertex - centre).norm()).fold(0.0, f64::max);
        let mut total = 0.0;
        let areas = triangles.iter().map(|triangle| {
            total += triangle.area();
            total
        });
        Self { centre, radius, areas: areas.collect(), triangles }
    }

    /// A point uniform over the surface, part frame, mm.
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
    /// Who knows when the surfaces touch.
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
    /// The line through a relative pose along a direction (frame of `a`), run through from so far away that `b` is clear of
    /// `a` by more than `margin_mm`: before first contact the pair is apart, back to at least that margin. `None` when `b`
    /// passes by.
    pub fn cast(contact: &Contact<'_>, through: &Isometry, direction: Unit<Vector>, margin_mm: f64) -> Option<Self> {
        let offset = through * contact.b.centre - contact.a.centre;
        let along = offset.dot(&direction);
        let reach = contact.a.radius + contact.b.radius;
        if (offset - *direction * along).norm() > reach {
            return None;
        }
        let start = moved(through, &direction, -(along + reach + margin_mm));
        let travel = contact.oracle.first_contact_mm(&start, &direction)?;
        Some(Self { first_contact: moved(&start, &direction, travel), direction })
    }

    /// The pose a travel past first contact, mm; negative is before it.
    pub fn at_depth(&self, depth_mm: f64) -> Isometry {
        moved(&self.first_contact, &self.direction, depth_mm)
    }
}

fn moved(pose: &Isometry, direction: &Unit<Vector>, travel_mm: f64) -> Isometry {
    Isometry::from_parts(Translation3::from(pose.translation.vector + **direction * travel_mm), pose.rotation)
}
