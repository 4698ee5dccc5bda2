//! What is so of two meshes at a pose: every pair of triangles, by integers; and their distance.

use super::integers::Corners;
use bvbench::geometry::grid::Placement;
use bvbench::geometry::{Isometry, Mesh, Point, Triangle, Vector};

/// Two meshes.
pub struct Truth {
    a: Vec<Triangle>,
    b: Vec<Triangle>,
    corners: Vec<Corners>,
}

impl Truth {
    pub fn new(a: &Mesh, b: &Mesh) -> Self {
        let (a, b) = (a.triangles(), b.triangles());
        let corners = a.iter().map(|triangle| Corners::new(triangle.corners)).collect();
        Self { a, b, corners }
    }

    /// Whether any two triangles share a point.
    pub fn touches(&self, a_from_b: &Isometry) -> bool {
        let placement = Placement::new(a_from_b);
        self.b.iter().any(|triangle| {
            let moved = Corners::new(placement.triangle(triangle).corners);
            self.corners.iter().any(|still| still.touch(&moved))
        })
    }

    /// Every pair of triangles that share a point, as (face of `a`, face of `b`), sorted.
    pub fn contacts(&self, a_from_b: &Isometry) -> Vec<(u32, u32)> {
        let placement = Placement::new(a_from_b);
        let moved: Vec<Corners> = self.b.iter().map(|t| Corners::new(placement.triangle(t).corners)).collect();
        let pairs = (0..).zip(&self.corners).flat_map(|(i, still)| (0..).zip(&moved).map(move |pair| (i, still, pair)));
        pairs.filter(|(_, still, (_, moved))| still.touch(moved)).map(|(i, _, (j, _))| (i, j)).collect()
    }

    /// The distance of meshes that do not touch, mm, in `f64`, and the size of everything, mm.
    pub fn distance_and_size_mm(&self, a_from_b: &Isometry) -> (f64, f64) {
        let placement = Placement::new(a_from_b);
        let moved: Vec<Triangle> = self.b.iter().map(|triangle| placement.triangle(triangle)).collect();
        let squared = |still| moved.iter().map(move |moved| distance_squared(still, moved));
        let squared = self.a.iter().flat_map(squared).fold(f64::INFINITY, f64::min);
        let from = self.a[0].corners[0];
        let corners = self.a.iter().chain(&moved).flat_map(|triangle| &triangle.corners);
        (squared.sqrt(), corners.map(|p| (p - from).amax()).fold(0.0, f64::max))
    }
}

/// Square of the distance of triangles that do not touch, mm²: the least over pairs of edges, and over corners and faces.
fn distance_squared(a: &Triangle, b: &Triangle) -> f64 {
    let edges = |t: &Triangle| [0, 1, 2].map(|k| [t.corners[k], t.corners[(k + 1) % 3]]);
    let (edges_a, edges_b) = (edges(a), edges(b));
    let between = edges_a.iter().flat_map(|e| edges_b.iter().map(|f| of_edges_squared(e, f)));
    let above = |of: &Triangle, face: &Triangle| of.corners.map(|p| above_squared(&p, face));
    between.chain(above(a, b)).chain(above(b, a)).fold(f64::INFINITY, f64::min)
}

/// Between two segments: where both lines are nearest to each other, if that is inside both, or from an end of one. Only differences of corners are
/// added up: they are exact, also where the origin is far away.
fn of_edges_squared([p, q]: &[Point; 2], [r, s]: &[Point; 2]) -> f64 {
    let (d, e, w) = (q - p, s - r, r - p);
    let normal = d.cross(&e);
    let [u, v] = [w.cross(&e), w.cross(&d)].map(|x| x.dot(&normal) / normal.norm_squared());
    let inside = |x: f64| (0.0..=1.0).contains(&x);
    let lines = if inside(u) && inside(v) { (d * u - e * v - w).norm_squared() } else { f64::INFINITY };
    let end = |p: &Point, [r, s]: [&Point; 2]| {
        let e = s - r;
        let along = if e == Vector::zeros() { 0.0 } else { ((p - r).dot(&e) / e.norm_squared()).clamp(0.0, 1.0) };
        ((p - r) - e * along).norm_squared()
    };
    lines.min(end(p, [r, s])).min(end(q, [r, s])).min(end(r, [p, q])).min(end(s, [p, q]))
}

/// From a point to its foot in a face, mm²; infinity where the foot is outside.
fn above_squared(p: &Point, face: &Triangle) -> f64 {
    let [a, b, c] = &face.corners;
    let (e, f, w) = (b - a, c - a, p - a);
    let normal = e.cross(&f);
    let [u, v] = [w.cross(&f), e.cross(&w)].map(|x| x.dot(&normal) / normal.norm_squared());
    // A face without area has no inside: u and v are not numbers.
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 { (w - e * u - f * v).norm_squared() } else { f64::INFINITY }
}
