//! Convex meshes as solids: how deep they penetrate and what is inside, for the place of trimesh's manager.
//!
//! Two convex polytopes overlap least along the normal of a face of either, or across an edge of each; edges count where their arcs on the Gauss map
//! cross (D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013). Of equal depths the first counts: faces of the first solid,
//! then of the second, then pairs of edges, each in the order of the mesh.

use crate::convert::{coordinates, pose, value_error};
use crate::pair::{Collider, mesh_of};
use obbtree::nalgebra::{Isometry3, Point3, Vector3};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// How far a neighbour's corner may lie above a face, relative to the size of the mesh: what rounding to single precision leaves.
const FLAT: f64 = 1e-5;
/// Squared sine of an angle between faces or edges below which they count as parallel.
const PARALLEL: f64 = 1e-12;

#[derive(Clone, Copy)]
struct Plane {
    point: Point3<f64>,
    /// Outward, of length 1.
    normal: Vector3<f64>,
    face: u32,
}

impl Plane {
    fn height(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&(point - self.point))
    }
}

#[derive(Clone, Copy)]
struct Edge {
    from: Point3<f64>,
    along: Vector3<f64>,
    /// The normals of the faces on both sides.
    normals: [Vector3<f64>; 2],
    face: u32,
}

/// The corners, faces and edges of a convex mesh.
#[derive(Clone)]
struct Solid {
    /// With a face that has it.
    corners: Vec<(Point3<f64>, u32)>,
    planes: Vec<Plane>,
    edges: Vec<Edge>,
}

impl Solid {
    /// The solid, or why the mesh is none.
    fn new(mesh: &obbtree::Mesh) -> Result<Self, String> {
        let [low, high] = mesh.bounds();
        let tolerance = FLAT * (high - low).norm();
        let middle = obbtree::nalgebra::center(&low, &high);
        let mut corners = BTreeMap::new();
        let mut sides: BTreeMap<(u32, u32), Vec<(u32, u32)>> = BTreeMap::new();
        let (mut planes, mut plane_of) = (Vec::new(), Vec::new());
        for (&[a, b, c], face) in mesh.faces().iter().zip(0..) {
            let [p, q, r] = mesh.triangle(face);
            for (corner, point) in [(a, p), (b, q), (c, r)] {
                corners.entry(corner).or_insert((point, face));
            }
            for (from, to, opposite) in [(a, b, c), (b, c, a), (c, a, b)] {
                sides.entry((from.min(to), from.max(to))).or_default().push((face, opposite));
            }
            let normal = (q - p).cross(&(r - p)).try_normalize(0.0);
            plane_of.push(normal.map(|normal| Plane { point: p, normal, face }));
            planes.extend(normal.map(|normal| Plane { point: p, normal, face }));
        }
        // Faces may wind either way round: as the middle sees them.
        let inward = planes.iter().filter(|plane| plane.height(&middle) > 0.0).count();
        if 2 * inward > planes.len() {
            planes.iter_mut().chain(plane_of.iter_mut().flatten()).for_each(|plane| plane.normal = -plane.normal);
        }
        let mut edges = Vec::new();
        for (&(from, to), faces) in &sides {
            let [(f, opposite_f), (g, opposite_g)] = faces[..] else {
                return Err(format!("the mesh is not closed at the edge of vertices {from} and {to}"));
            };
            let (Some(f), Some(g)) = (plane_of[f as usize], plane_of[g as usize]) else { continue };
            let point = |vertex: u32| mesh.vertices()[vertex as usize];
            if f.height(&point(opposite_g)) > tolerance || g.height(&point(opposite_f)) > tolerance {
                return Err(format!("the mesh is not convex at the edge of vertices {from} and {to}"));
            }
            if f.normal.cross(&g.normal).norm_squared() > PARALLEL {
                let along = point(to) - point(from);
                edges.push(Edge { from: point(from), along, normals: [f.normal, g.normal], face: f.face });
            }
        }
        Ok(Self { corners: corners.into_values().collect(), planes, edges })
    }

    fn moved(&self, pose: &Isometry3<f64>) -> Self {
        let plane = |plane: &Plane| Plane { point: pose * plane.point, normal: pose * plane.normal, ..*plane };
        let edge = |edge: &Edge| Edge {
            from: pose * edge.from,
            along: pose * edge.along,
            normals: edge.normals.map(|normal| pose * normal),
            ..*edge
        };
        Self {
            corners: self.corners.iter().map(|(p, face)| (pose * p, *face)).collect(),
            planes: self.planes.iter().map(plane).collect(),
            edges: self.edges.iter().map(edge).collect(),
        }
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        self.planes.iter().all(|plane| plane.height(point) <= 0.0)
    }

    /// The corner that is farthest against a direction.
    fn deepest(&self, direction: &Vector3<f64>) -> (Point3<f64>, u32) {
        let below = |x: &&(Point3<f64>, u32), y: &&(Point3<f64>, u32)| {
            direction.dot(&x.0.coords).total_cmp(&direction.dot(&y.0.coords))
        };
        *self.corners.iter().min_by(below).expect("a mesh has a corner")
    }
}

/// The least motion that parts two solids.
#[derive(Clone, Copy)]
struct Depth {
    depth: f64,
    /// From the first solid to the second.
    normal: Vector3<f64>,
    points: [Point3<f64>; 2],
    faces: [u32; 2],
}

/// How deep two solids, in one frame, penetrate; `None` where they are apart.
fn penetration(a: &Solid, b: &Solid) -> Option<Depth> {
    let mut least: Option<Depth> = None;
    let mut keep = |found: Depth| {
        if least.is_none_or(|least| found.depth < least.depth * (1.0 - 1e-9)) {
            least = Some(found);
        }
    };
    for plane in &a.planes {
        let (corner, face) = b.deepest(&plane.normal);
        let depth = -plane.height(&corner);
        if depth < 0.0 {
            return None;
        }
        let points = [corner + plane.normal * depth, corner];
        keep(Depth { depth, normal: plane.normal, points, faces: [plane.face, face] });
    }
    for plane in &b.planes {
        let (corner, face) = a.deepest(&plane.normal);
        let depth = -plane.height(&corner);
        if depth < 0.0 {
            return None;
        }
        let points = [corner, corner + plane.normal * depth];
        keep(Depth { depth, normal: -plane.normal, points, faces: [face, plane.face] });
    }
    for e in &a.edges {
        for f in &b.edges {
            if !arcs_cross(e, f) {
                continue;
            }
            let across = e.along.cross(&f.along);
            let squared = across.norm_squared();
            if squared <= PARALLEL * e.along.norm_squared() * f.along.norm_squared() {
                continue;
            }
            // Outward from the first: both its faces turn away from the edge's inside.
            let outward = across.dot(&(e.normals[0] + e.normals[1])).signum();
            let normal = across * (outward / squared.sqrt());
            let between = f.from - e.from;
            let depth = -normal.dot(&between);
            if depth < 0.0 {
                return None;
            }
            let p = e.from + e.along * (between.cross(&f.along).dot(&across) / squared);
            let q = f.from + f.along * (between.cross(&e.along).dot(&across) / squared);
            keep(Depth { depth, normal, points: [p, q], faces: [e.face, f.face] });
        }
    }
    least
}

/// Whether the arcs between the normals of both edges cross, one of them mirrored: whether the edges make a face of the Minkowski difference.
fn arcs_cross(e: &Edge, f: &Edge) -> bool {
    let [a, b] = &e.normals;
    let [c, d] = f.normals.map(|normal| -normal);
    let (of_e, of_f) = (b.cross(a), d.cross(&c));
    let (c_side, d_side, a_side, b_side) = (c.dot(&of_e), d.dot(&of_e), a.dot(&of_f), b.dot(&of_f));
    c_side * d_side < 0.0 && a_side * b_side < 0.0 && c_side * b_side > 0.0
}

/// A convex mesh as a solid.
#[pyclass(frozen, module = "obbtree")]
pub struct Convex(Solid);

#[pymethods]
impl Convex {
    #[new]
    fn new(py: Python<'_>, mesh: &Bound<'_, PyAny>) -> PyResult<Self> {
        let mesh = mesh_of(mesh)?;
        py.detach(|| Solid::new(&mesh)).map(Self).map_err(value_error)
    }

    #[pyo3(signature = (other, pose = None))]
    fn penetration(
        &self,
        py: Python<'_>,
        other: &Self,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Option<Penetration>> {
        let pose = self::pose(pose)?;
        Ok(py.detach(|| penetration(&self.0, &other.0.moved(&pose))).map(Penetration))
    }

    #[pyo3(signature = (collider, pose = None))]
    fn contains_corner_of(
        &self,
        py: Python<'_>,
        collider: &Collider,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<bool> {
        Ok(self.corner_inside(py, collider, pose)?.is_some())
    }

    #[pyo3(signature = (collider, pose = None))]
    fn corner_inside(
        &self,
        py: Python<'_>,
        collider: &Collider,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Option<(u32, u32)>> {
        let (pose, mesh) = (self::pose(pose)?, collider.0.mesh());
        let is_inside = |&vertex: &u32| self.0.contains(&(pose * mesh.vertices()[vertex as usize]));
        let find = || mesh.faces().as_flattened().iter().zip(0..).find(|(vertex, _)| is_inside(vertex));
        Ok(py.detach(find).map(|(&vertex, corner)| (corner / 3, vertex)))
    }
}

/// How deep two convex solids penetrate.
#[pyclass(frozen, module = "obbtree")]
pub struct Penetration(Depth);

#[pymethods]
impl Penetration {
    #[getter]
    fn depth(&self) -> f64 {
        self.0.depth
    }

    #[getter]
    fn normal(&self) -> [f64; 3] {
        self.0.normal.into()
    }

    #[getter]
    fn points(&self) -> Vec<Vec<f64>> {
        coordinates(&self.0.points)
    }

    #[getter]
    fn faces(&self) -> (u32, u32) {
        self.0.faces.into()
    }
}
