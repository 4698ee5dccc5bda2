//! Convex meshes as solids: how deep they penetrate and what is inside, for the place of trimesh's manager.
//!
//! Two convex polytopes overlap least along the normal of a face of either, or across an edge of each; edges count where their arcs on the Gauss map
//! cross (D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013). Of equal depths the first counts: faces of the first solid,
//! then of the second, then pairs of edges, each in the order of the mesh.
//!
//! A solid is the convex hull of the corners of its mesh, which is closed, in one part, has an extent along the normal of each face, and no corner far above
//! one: a dent that rounding to single precision makes does not count. Faces without area, and those that rounding may have tilted at will, have no normal.

use crate::convert::{coordinates, pose, value_error};
use crate::pair::{Collider, mesh_of};
use obbtree::engine::geometry::exact;
use obbtree::engine::{Point, Triangle};
use obbtree::nalgebra::{Isometry3, Point3, Vector3};
use pyo3::prelude::*;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// How far a corner may lie above a face, relative to the size of the mesh.
const FLAT: f64 = 1e-5;
/// What rounding to single precision may do to a coordinate, relative to the size of the mesh: 2⁻²², four units of rounding. No face that is lower has a
/// normal, and no mesh that is thinner is a solid.
const SINGLE: f64 = 1.0 / 4_194_304.0;
/// Height, relative to the size of the mesh, up to which a face of the hull has no normal, and a corner above a face counts as on it: 2⁻²⁷. Rounding
/// tilts a higher one by 2⁻²⁵ at most, so that a solid is larger than its hull by no more than that part of its size.
const LOW: f64 = 1.0 / 134_217_728.0;
/// Squared sine of an angle between faces or edges below which they count as parallel.
const PARALLEL: f64 = 1e-20;

#[derive(Clone, Copy, PartialEq)]
struct Plane {
    /// The highest corner of the solid along the normal.
    point: Point3<f64>,
    /// Outward, of length 1.
    normal: Vector3<f64>,
    /// The face of the mesh that has the most of its corners.
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

/// The corners of a convex mesh, and the faces and edges of their convex hull. Where the faces of the mesh form the hull, they are kept.
#[derive(Clone)]
struct Solid {
    corners: Corners,
    planes: Vec<Plane>,
    edges: Vec<Edge>,
}

impl Solid {
    /// The solid, or why the mesh is none. Takes time in proportion to faces times corners.
    fn new(mesh: &obbtree::Mesh) -> Result<Self, String> {
        let across = neighbours(mesh.faces())?;
        if !is_connected(&across) {
            return Err("the mesh is in several parts".to_owned());
        }
        let mut corners = BTreeMap::new();
        for (face, vertices) in (0..).zip(mesh.faces()) {
            for (&vertex, point) in vertices.iter().zip(mesh.triangle(face)) {
                corners.entry(vertex).or_insert((point, face));
            }
        }
        let (vertices, corners): (Vec<u32>, Corners) = corners.into_iter().unzip();
        let [low, high] = mesh.bounds();
        let size = (high - low).amax();
        let facets = (0..mesh.faces().len() as u32).map(|face| facet(mesh, face, (&vertices, &corners), size));
        let facets = facets.collect::<Result<Vec<Option<Facet>>, String>>()?;
        let first = facets.iter().flatten().next().ok_or("no face of the mesh has an area")?.simplex;
        let is_hull = facets.iter().all(|facet| facet.as_ref().is_some_and(|facet| facet.is_of_hull));
        let mut faces: Vec<(u32, [u32; 3])> = (0..).zip(mesh.faces().iter().copied()).collect();
        if !(is_hull && winds_one_way(mesh.faces())) {
            let incident = incident(mesh);
            let hull = hull(mesh, &vertices, first).into_iter();
            faces = hull.map(|face| (nearest_face(mesh, &incident, &face), face)).collect();
            // Of equal depths the first counts.
            faces.sort_unstable();
        }
        let planes: Vec<Option<Plane>> = faces.iter().map(|&face| plane(mesh, face, &corners, size)).collect();
        let faces: Vec<[u32; 3]> = faces.into_iter().map(|(_, face)| face).collect();
        let edges = edges(mesh, &faces, &planes)?;
        Ok(Self { corners, planes: planes.into_iter().flatten().collect(), edges })
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
fn neighbours(all: &[[u32; 3]]) -> Result<Vec<[usize; 3]>, String> {
    let mut sides: BTreeMap<(u32, u32), Vec<(usize, usize)>> = BTreeMap::new();
    for (face, corners) in all.iter().enumerate() {
        (0..3).for_each(|k| sides.entry(side(corners, k)).or_default().push((face, k)));
    }
    let mut across = vec![[0; 3]; all.len()];
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

/// Corners of a mesh, each with a face that has it.
type Corners = Vec<(Point3<f64>, u32)>;

/// A face of a mesh that has a normal.
struct Facet {
    /// Its vertices, and the corner that is farthest from its plane.
    simplex: [u32; 4],
    /// It winds as seen from outside, and no corner is above it by more than rounding.
    is_of_hull: bool,
}

/// A face of a mesh of some size, or why the mesh is no solid; `None` where it has no normal. Faces may wind either way round: no corner is above them.
fn facet(
    mesh: &obbtree::Mesh,
    face: u32,
    (vertices, corners): (&[u32], &[(Point3<f64>, u32)]),
    size: f64,
) -> Result<Option<Facet>, String> {
    let [p, q, r] = mesh.triangle(face);
    let sides = [q - p, r - q, p - r];
    let largest = sides.iter().map(Vector3::amax).fold(0.0, f64::max);
    if largest == 0.0 {
        return Ok(None);
    }
    // Of lengths about 1, whose squares are numbers.
    let scaled = sides.map(|side| side / largest);
    let longest = scaled.iter().map(Vector3::norm).fold(0.0, f64::max);
    let double_area = scaled[0].cross(&scaled[1]);
    let height = double_area.norm() / longest * largest;
    let Some(normal) = unit(&double_area).filter(|_| height > SINGLE * size) else { return Ok(None) };
    let [a, b, c] = mesh.faces()[face as usize];
    let (mut lowest, mut highest) = ((0.0, a), (0.0, a));
    for (&vertex, (corner, _)) in vertices.iter().zip(corners) {
        let height = normal.dot(&(corner - p));
        if height > highest.0 {
            highest = (height, vertex);
        } else if height < lowest.0 {
            lowest = (height, vertex);
        }
    }
    if highest.0 - lowest.0 <= SINGLE * size {
        return Err("the mesh is flat".to_owned());
    }
    let is_outward = highest.0 <= -lowest.0;
    let (above, tip) = if is_outward { (highest.0, lowest.1) } else { (-lowest.0, highest.1) };
    // A low face is tilted by rounding, which lifts corners far away.
    if above > size * FLAT.max(SINGLE * (size / height)) {
        return Err(format!("the mesh is not convex: a corner lies above face {face}"));
    }
    Ok(Some(Facet { simplex: [a, b, c, tip], is_of_hull: is_outward && above <= LOW * size }))
}

/// Whether each side of a face goes the other way in the next. Closed, and on the hull with every face winding as seen from outside, such faces leave no part of
/// it out.
fn winds_one_way(faces: &[[u32; 3]]) -> bool {
    let sides = faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    sides.collect::<BTreeSet<[u32; 2]>>().len() == 3 * faces.len()
}

/// The faces of the convex hull of vertices, counter-clockwise as seen from outside: each vertex that is outside takes the place of the faces that it sees
/// (M. Kallay, 1981). Exact; no three corners of a face are in a line, and faces may lie in one plane.
fn hull(mesh: &obbtree::Mesh, vertices: &[u32], [a, b, c, d]: [u32; 4]) -> Vec<[u32; 3]> {
    // Products of coordinates about 1 are numbers; a power of two rounds nothing.
    let largest = mesh.bounds().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let scale = 2.0_f64.powi(-(largest.log2() as i32));
    let points: Vec<Point> = mesh.vertices().iter().map(|p| p * scale).collect();
    let point = |vertex: u32| points[vertex as usize];
    let sees = |vertex: u32, face: &[u32; 3]| exact::side(&Triangle { corners: face.map(point) }, &point(vertex)) < 0;
    let mut faces = vec![[a, b, c], [a, d, b], [b, d, c], [c, d, a]];
    if sees(d, &faces[0]) {
        faces.iter_mut().for_each(|face| face.swap(0, 1));
    }
    for &vertex in vertices {
        let (seen, kept): (Vec<_>, Vec<_>) = faces.into_iter().partition(|face| sees(vertex, face));
        let sides: BTreeSet<[u32; 2]> = seen.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let horizon = sides.iter().filter(|[from, to]| !sides.contains(&[*to, *from]));
        faces = kept;
        faces.extend(horizon.map(|&[from, to]| [from, to, vertex]));
    }
    faces
}

/// The faces that have each vertex.
fn incident(mesh: &obbtree::Mesh) -> Vec<Vec<u32>> {
    let mut incident = vec![Vec::new(); mesh.vertices().len()];
    for (number, face) in (0..).zip(mesh.faces()) {
        face.iter().for_each(|&vertex| incident[vertex as usize].push(number));
    }
    incident
}

/// The first of the faces of a mesh that have the most vertices of a face of its hull.
fn nearest_face(mesh: &obbtree::Mesh, incident: &[Vec<u32>], face: &[u32; 3]) -> u32 {
    let shared = |of: u32| mesh.faces()[of as usize].iter().filter(|vertex| face.contains(vertex)).count();
    let beside = face.iter().flat_map(|&vertex| incident[vertex as usize].iter().copied());
    beside.max_by_key(|&number| (shared(number), Reverse(number))).unwrap_or(0)
}

/// The plane of a face of the hull of a mesh of some size, if it has a normal.
fn plane(
    mesh: &obbtree::Mesh,
    (number, face): (u32, [u32; 3]),
    corners: &[(Point3<f64>, u32)],
    size: f64,
) -> Option<Plane> {
    let [p, q, r] = face.map(|vertex| mesh.vertices()[vertex as usize]);
    // Of lengths about 1, whose squares are numbers.
    let [along, across, third] = [q - p, r - p, r - q].map(|side| side / size);
    let double_area = along.cross(&across);
    let longest = along.norm().max(across.norm()).max(third.norm());
    let normal = unit(&double_area).filter(|_| double_area.norm() > LOW * longest)?;
    let mut highest = (0.0, p);
    for (corner, _) in corners {
        let height = normal.dot(&(corner - p));
        if height > highest.0 {
            highest = (height, *corner);
        }
    }
    Some(Plane { point: highest.1, normal, face: number })
}

/// The edges between faces of the hull that are not parallel. Fails when no face of the hull has a normal.
fn edges(mesh: &obbtree::Mesh, hull: &[[u32; 3]], planes: &[Option<Plane>]) -> Result<Vec<Edge>, String> {
    let across = neighbours(hull)?;
    // A face without a normal lies in an edge of two others, and counts as part of one of them.
    let mut planes = planes.to_vec();
    while planes.contains(&None) {
        let before = planes.clone();
        for (plane, beside) in planes.iter_mut().zip(&across) {
            *plane = plane.or_else(|| beside.iter().find_map(|&face| before[face]));
        }
        if planes == before {
            return Err("no face of the mesh has an area".to_owned());
        }
    }
    let planes: Vec<Plane> = planes.into_iter().flatten().collect();
    let edge = |f: usize, k: usize| {
        let g = across[f][k];
        let (from, to) = side(&hull[f], k);
        let [from, to] = [from, to].map(|vertex| mesh.vertices()[vertex as usize]);
        let (f, g) = (planes[f], planes[g]);
        let turn = g.normal.cross(&f.normal);
        let edge = Edge { from, along: unit(&(to - from))?, normals: [f.normal, g.normal], turn, face: f.face };
        (turn.norm_squared() > PARALLEL).then_some(edge)
    };
    let sides = (0..hull.len()).flat_map(|f| (0..3).map(move |k| (f, k))).filter(|&(f, k)| f < across[f][k]);
    Ok(sides.filter_map(|(f, k)| edge(f, k)).collect())
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
