//! Convex meshes as solids: how deep they penetrate and what is inside, for the place of trimesh's manager.
//!
//! Two convex polytopes overlap least along the normal of a face of either, or across an edge of each; edges count where their arcs on the Gauss map
//! cross (D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013). Of equal depths the first counts: faces of the first solid,
//! then of the second, then pairs of edges, each in the order of the mesh.
//!
//! A solid is closed, in one part, has an extent along the normal of each face, and no corner above one. Faces without area, and those that rounding to
//! single precision may have tilted at will, have no normal: they are slivers, and what meets at an edge is the faces beyond them.

use crate::convert::{coordinates, pose, value_error};
use crate::pair::{Collider, mesh_of};
use obbtree::nalgebra::{Isometry3, Point3, Vector3};
use pyo3::prelude::*;
use std::collections::BTreeMap;

/// How far a corner may lie above a face, relative to the size of the mesh.
const FLAT: f64 = 1e-5;
/// What rounding to single precision may do to a coordinate, relative to the size of the mesh: 2⁻²², four units of rounding. No face that is lower has a
/// normal, and no mesh that is thinner is a solid.
const SINGLE: f64 = 1.0 / 4_194_304.0;
/// Squared sine of an angle between faces or edges below which they count as parallel.
const PARALLEL: f64 = 1e-12;

#[derive(Clone, Copy)]
struct Plane {
    /// The highest corner of the solid along the normal, one of the face's own where these are the highest.
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
    /// Of length 1.
    along: Vector3<f64>,
    /// The normals of the faces on both sides.
    normals: [Vector3<f64>; 2],
    /// The second of them times the first, across.
    turn: Vector3<f64>,
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

/// A face as part of a solid.
#[derive(Clone, Copy)]
enum Facet {
    Plane(Plane),
    /// Of no normal; with its longest side.
    Sliver(usize),
}

impl Solid {
    /// The solid, or why the mesh is none. Takes time in proportion to faces times corners.
    fn new(mesh: &obbtree::Mesh) -> Result<Self, String> {
        let across = neighbours(mesh)?;
        if !is_connected(&across) {
            return Err("the mesh is in several parts".to_owned());
        }
        let mut corners = BTreeMap::new();
        for (face, vertices) in (0..).zip(mesh.faces()) {
            for (&vertex, point) in vertices.iter().zip(mesh.triangle(face)) {
                corners.entry(vertex).or_insert((point, face));
            }
        }
        let corners: Vec<(Point3<f64>, u32)> = corners.into_values().collect();
        let [low, high] = mesh.bounds();
        let size = (high - low).amax();
        let facet = |face| facet(mesh, face, &corners, size);
        let facets = (0..mesh.faces().len() as u32).map(facet).collect::<Result<Vec<Facet>, String>>()?;
        let plane = |facet: &Facet| if let Facet::Plane(plane) = facet { Some(*plane) } else { None };
        let planes: Vec<Plane> = facets.iter().filter_map(plane).collect();
        if planes.is_empty() {
            return Err("no face of the mesh has an area".to_owned());
        }
        let edges = edges(mesh, &across, &facets)?;
        Ok(Self { corners, planes, edges })
    }

    fn moved(&self, pose: &Isometry3<f64>) -> Self {
        let plane = |plane: &Plane| Plane { point: pose * plane.point, normal: pose * plane.normal, ..*plane };
        let edge = |edge: &Edge| Edge {
            from: pose * edge.from,
            along: pose * edge.along,
            normals: edge.normals.map(|normal| pose * normal),
            turn: pose * edge.turn,
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

/// Side k of a face is from its corner k to the next; its vertices, the lower first.
fn side(corners: &[u32; 3], k: usize) -> (u32, u32) {
    let (from, to) = (corners[k], corners[(k + 1) % 3]);
    (from.min(to), from.max(to))
}

/// The face across each side of each face.
fn neighbours(mesh: &obbtree::Mesh) -> Result<Vec<[usize; 3]>, String> {
    let mut sides: BTreeMap<(u32, u32), Vec<(usize, usize)>> = BTreeMap::new();
    for (face, corners) in mesh.faces().iter().enumerate() {
        (0..3).for_each(|k| sides.entry(side(corners, k)).or_default().push((face, k)));
    }
    let mut across = vec![[0; 3]; mesh.faces().len()];
    for ((from, to), faces) in sides {
        let [(f, i), (g, j)] = faces[..] else {
            return Err(format!("the mesh is not closed at the edge of vertices {from} and {to}"));
        };
        (across[f][i], across[g][j]) = (g, f);
    }
    Ok(across)
}

fn is_connected(across: &[[usize; 3]]) -> bool {
    let (mut met, mut open) = (vec![false; across.len()], vec![0]);
    met[0] = true;
    while let Some(face) = open.pop() {
        open.extend(across[face].into_iter().filter(|&next| !std::mem::replace(&mut met[next], true)));
    }
    met.into_iter().all(|met| met)
}

/// A vector of any length as one of length 1, if it is not zero.
fn unit(vector: &Vector3<f64>) -> Option<Vector3<f64>> {
    let largest = vector.amax();
    if largest > 0.0 { (vector / largest).try_normalize(0.0) } else { None }
}

/// A face of a mesh of some size, or why the mesh is no solid. Faces may wind either way round: no corner is above them.
fn facet(mesh: &obbtree::Mesh, face: u32, corners: &[(Point3<f64>, u32)], size: f64) -> Result<Facet, String> {
    let [p, q, r] = mesh.triangle(face);
    let sides = [q - p, r - q, p - r];
    let largest = sides.iter().map(Vector3::amax).fold(0.0, f64::max);
    if largest == 0.0 {
        return Ok(Facet::Sliver(0));
    }
    // Of lengths about 1, whose squares are numbers.
    let scaled = sides.map(|side| side / largest);
    let lengths = scaled.map(|side| side.norm());
    let longest = (1..3).fold(0, |longest, k| if lengths[k] > lengths[longest] { k } else { longest });
    let double_area = scaled[0].cross(&scaled[1]);
    let height = double_area.norm() / lengths[longest] * largest;
    let Some(normal) = unit(&double_area).filter(|_| height > SINGLE * size) else {
        return Ok(Facet::Sliver(longest));
    };
    let (mut lowest, mut highest) = ((0.0, p), (0.0, p));
    for (corner, _) in corners {
        let height = normal.dot(&(corner - p));
        if height > highest.0 {
            highest = (height, *corner);
        } else if height < lowest.0 {
            lowest = (height, *corner);
        }
    }
    if highest.0 - lowest.0 <= SINGLE * size {
        return Err("the mesh is flat".to_owned());
    }
    let (above, point, normal) =
        if highest.0 <= -lowest.0 { (highest.0, highest.1, normal) } else { (-lowest.0, lowest.1, -normal) };
    // A low face is tilted by rounding, which lifts corners far away.
    if above > size * FLAT.max(SINGLE * (size / height)) {
        return Err(format!("the mesh is not convex: a corner lies above face {face}"));
    }
    Ok(Facet::Plane(Plane { point, normal, face }))
}

/// The edges between faces that are not parallel.
fn edges(mesh: &obbtree::Mesh, across: &[[usize; 3]], facets: &[Facet]) -> Result<Vec<Edge>, String> {
    // Slivers are crossed over their longest sides, which are no edges then: their other sides are.
    let beyond = |mut face: usize| {
        for _ in 0..facets.len() {
            match facets[face] {
                Facet::Plane(plane) => return Some(plane),
                Facet::Sliver(longest) => face = across[face][longest],
            }
        }
        None
    };
    let is_crossed = |face: usize, of: (u32, u32)| match facets[face] {
        Facet::Plane(_) => false,
        Facet::Sliver(longest) => side(&mesh.faces()[face], longest) == of,
    };
    let mut edges = Vec::new();
    for (f, corners) in mesh.faces().iter().enumerate() {
        for (k, &g) in across[f].iter().enumerate() {
            let of = side(corners, k);
            if f > g || is_crossed(f, of) || is_crossed(g, of) {
                continue;
            }
            let [from, to] = [of.0, of.1].map(|vertex| mesh.vertices()[vertex as usize]);
            let Some(along) = unit(&(to - from)) else { continue };
            let (Some(f), Some(g)) = (beyond(f), beyond(g)) else {
                let (from, to) = of;
                return Err(format!("no face with an area is beside the edge of vertices {from} and {to}"));
            };
            let turn = g.normal.cross(&f.normal);
            if turn.norm_squared() > PARALLEL {
                edges.push(Edge { from, along, normals: [f.normal, g.normal], turn, face: f.face });
            }
        }
    }
    Ok(edges)
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

/// How deep two solids, in one frame, penetrate; `None` where they are apart. Takes time in proportion to the edges of one times those of the other.
fn penetration(a: &Solid, b: &Solid) -> Option<Depth> {
    let mut least: Option<Depth> = None;
    for plane in &a.planes {
        let (corner, face) = b.deepest(&plane.normal);
        let depth = -plane.height(&corner);
        if depth < 0.0 {
            return None;
        }
        let points = [corner + plane.normal * depth, corner];
        keep(&mut least, Depth { depth, normal: plane.normal, points, faces: [plane.face, face] });
    }
    for plane in &b.planes {
        let (corner, face) = a.deepest(&plane.normal);
        let depth = -plane.height(&corner);
        if depth < 0.0 {
            return None;
        }
        let points = [corner, corner + plane.normal * depth];
        keep(&mut least, Depth { depth, normal: -plane.normal, points, faces: [face, plane.face] });
    }
    for e in &a.edges {
        for f in &b.edges {
            if !arcs_cross(e, f) {
                continue;
            }
            let across = e.along.cross(&f.along);
            let squared = across.norm_squared();
            if squared <= PARALLEL {
                continue;
            }
            // Outward from the first: both its faces turn away from the edge's inside.
            let outward = across.dot(&(e.normals[0] + e.normals[1])).signum();
            let normal = across * (outward / squared.sqrt());
            let between = f.from - e.from;
            if !is_less(&least, -normal.dot(&between)) {
                continue;
            }
            // A short edge may be tilted by rounding: along any direction the corners say how deep it is.
            let depth = normal.dot(&(a.deepest(&-normal).0 - b.deepest(&normal).0));
            if depth < 0.0 {
                return None;
            }
            let p = e.from + e.along * (between.cross(&f.along).dot(&across) / squared);
            keep(&mut least, Depth { depth, normal, points: [p, p - normal * depth], faces: [e.face, f.face] });
        }
    }
    least
}

/// Whether a depth is less than the least so far, by more than rounding.
fn is_less(least: &Option<Depth>, depth: f64) -> bool {
    least.is_none_or(|least| depth < least.depth * (1.0 - 1e-9))
}

fn keep(least: &mut Option<Depth>, found: Depth) {
    if is_less(least, found.depth) {
        *least = Some(found);
    }
}

/// Whether the arcs between the normals of both edges cross, one of them mirrored: whether the edges make a face of the Minkowski difference.
fn arcs_cross(e: &Edge, f: &Edge) -> bool {
    // The sides of the plane of one arc that the ends of the other are on: most pairs are left out by the first two.
    let [c_side, d_side] = f.normals.map(|normal| -normal.dot(&e.turn));
    if c_side * d_side >= 0.0 {
        return false;
    }
    let [a_side, b_side] = e.normals.map(|normal| normal.dot(&f.turn));
    a_side * b_side < 0.0 && c_side * b_side > 0.0
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
