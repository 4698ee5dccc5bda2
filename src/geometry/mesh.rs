//! A triangle mesh that has been checked: finite, in range, on the grid, not empty.

use super::{Point, Triangle, grid};
use std::collections::HashMap;
use thiserror::Error;

/// Why vertices and faces do not make a mesh.
#[derive(Debug, Error, PartialEq)]
pub enum MeshError {
    /// No triangle at all.
    #[error("the mesh has no triangle")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not finite: ({x}, {y}, {z})")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Its first coordinate.
        x: f64,
        /// Its second coordinate.
        y: f64,
        /// Its third coordinate.
        z: f64,
    },
    /// A coordinate is outside the range in which the truth is exact.
    #[error(
        "vertex {vertex} at ({x}, {y}, {z}) mm is farther than {limit} mm from the origin on one axis; is the unit right?",
        limit = grid::LIMIT_MM
    )]
    OutOfRange {
        /// Index of the vertex.
        vertex: usize,
        /// Its first coordinate, mm.
        x: f64,
        /// Its second coordinate, mm.
        y: f64,
        /// Its third coordinate, mm.
        z: f64,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}, but there are only {vertices}")]
    NoSuchVertex {
        /// Index of the face.
        face: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
}

/// Vertices and faces, mm, in the part's own frame. Vertices lie on the grid of [`grid`]; every face index is valid;
/// there is at least one face.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
}

/// How the edges of a mesh fit together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EdgeReport {
    /// Edges used by exactly one triangle: the rims of holes.
    pub open: usize,
    /// Edges used by more than two triangles.
    pub non_manifold: usize,
    /// Edges used twice in the same direction: neighbours that disagree about the outside.
    pub flipped: usize,
}

impl EdgeReport {
    /// Whether every edge joins exactly two triangles that agree about the outside.
    #[must_use]
    pub const fn is_watertight(&self) -> bool {
        self.open == 0 && self.non_manifold == 0 && self.flipped == 0
    }
}

impl Mesh {
    /// Checks the parts and snaps the vertices to the grid.
    ///
    /// # Errors
    /// [`MeshError`] when there is no face, a coordinate is not finite or beyond ±4096 mm, or a face names a missing
    /// vertex.
    pub fn new(mut vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if faces.is_empty() {
            return Err(MeshError::Empty);
        }
        for (vertex, p) in vertices.iter_mut().enumerate() {
            let (x, y, z) = (p.x, p.y, p.z);
            if !(x.is_finite() && y.is_finite() && z.is_finite()) {
                return Err(MeshError::NotFinite { vertex, x, y, z });
            }
            if p.coords.amax() > grid::LIMIT_MM {
                return Err(MeshError::OutOfRange { vertex, x, y, z });
            }
            *p = grid::snap(p);
        }
        for (face, corners) in faces.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices.len()) {
                return Err(MeshError::NoSuchVertex { face, vertex, vertices: vertices.len() });
            }
        }
        Ok(Self { vertices, faces })
    }

    /// A mesh from loose triangles; corners with equal coordinates become one vertex.
    ///
    /// # Errors
    /// As [`Mesh::new`].
    pub fn from_triangles(triangles: &[Triangle]) -> Result<Self, MeshError> {
        let mut vertices = Vec::new();
        let mut index_of = HashMap::new();
        let mut faces = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            faces.push(triangle.corners.map(|corner| {
                // +0.0 turns -0.0 into 0.0, so that the two zeros weld.
                let key = grid::snap(&corner).coords.map(|x| (x + 0.0).to_bits());
                *index_of.entry([key.x, key.y, key.z]).or_insert_with(|| {
                    vertices.push(corner);
                    (vertices.len() - 1) as u32
                })
            }));
        }
        Self::new(vertices, faces)
    }

    /// The vertices, mm.
    #[must_use]
    pub fn vertices(&self) -> &[Point] {
        &self.vertices
    }

    /// The faces, as indices into [`Mesh::vertices`].
    #[must_use]
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The triangles, in face order, mm.
    #[must_use]
    pub fn triangles(&self) -> Vec<Triangle> {
        let corner = |v: u32| self.vertices[v as usize];
        self.faces.iter().map(|f| Triangle { corners: f.map(corner) }).collect()
    }

    /// How the edges fit together.
    #[must_use]
    pub fn edge_report(&self) -> EdgeReport {
        let mut uses: HashMap<(u32, u32), (u32, u32)> = HashMap::new();
        for face in &self.faces {
            for (from, to) in [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])] {
                let entry = uses.entry((from.min(to), from.max(to))).or_default();
                if from < to { entry.0 += 1 } else { entry.1 += 1 }
            }
        }
        let mut report = EdgeReport::default();
        for (forward, backward) in uses.into_values() {
            match (forward, backward) {
                (1, 1) => {}
                (1, 0) | (0, 1) => report.open += 1,
                (2, 0) | (0, 2) => report.flipped += 1,
                _ => report.non_manifold += 1,
            }
        }
        report
    }

    /// The volume enclosed by a watertight mesh, mm³; positive when the winding is outward.
    #[must_use]
    pub fn signed_volume(&self) -> f64 {
        let about = self.vertices[0];
        self.triangles()
            .iter()
            .map(|t| {
                let [a, b, c] = t.corners.map(|p| p - about);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum()
    }

    /// For every face, the number of its connected component (faces that share vertices), counted from 0 in the order
    /// in which components first appear; and how many there are.
    #[must_use]
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut parent: Vec<u32> = (0..self.vertices.len() as u32).collect();
        fn root(parent: &mut [u32], mut v: u32) -> u32 {
            while parent[v as usize] != v {
                parent[v as usize] = parent[parent[v as usize] as usize];
                v = parent[v as usize];
            }
            v
        }
        for &[a, b, c] in &self.faces {
            let (ra, rb, rc) = (root(&mut parent, a), root(&mut parent, b), root(&mut parent, c));
            parent[rb as usize] = ra;
            let rc = if rc == rb { ra } else { rc };
            parent[rc as usize] = ra;
        }
        let mut number_of = HashMap::new();
        let labels = self
            .faces
            .iter()
            .map(|face| {
                let next = number_of.len() as u32;
                *number_of.entry(root(&mut parent, face[0])).or_insert(next)
            })
            .collect();
        (labels, number_of.len())
    }

    /// A hash of the snapped vertices and the faces, as hexadecimal text: equal for equal meshes on every machine.
    #[must_use]
    pub fn content_hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for p in &self.vertices {
            for x in [p.x, p.y, p.z] {
                hasher.update(&(x + 0.0).to_le_bytes());
            }
        }
        for v in self.faces.iter().flatten() {
            hasher.update(&v.to_le_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Mesh {
        let vertices =
            vec![Point::origin(), Point::new(6.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0), Point::new(0.0, 0.0, 1.0)];
        Mesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
    }

    #[test]
    fn tetrahedron_is_watertight_with_the_volume_of_a_sixth_box() {
        let mesh = tetrahedron();
        assert!(mesh.edge_report().is_watertight());
        assert!((mesh.signed_volume() - 1.0).abs() < 1e-12); // 6·1·1 / 6
        assert_eq!(mesh.components().1, 1);
    }

    #[test]
    fn a_missing_face_opens_three_edges_and_a_turned_one_flips_three() {
        let mesh = tetrahedron();
        let open = Mesh::new(mesh.vertices().to_vec(), mesh.faces()[..3].to_vec()).unwrap();
        assert_eq!(open.edge_report().open, 3);
        let mut faces = mesh.faces().to_vec();
        faces[0].swap(0, 1);
        assert_eq!(Mesh::new(mesh.vertices().to_vec(), faces).unwrap().edge_report().flipped, 3);
    }

    #[test]
    fn bad_input_is_refused() {
        let p = |x: f64| Point::new(x, 0.0, 0.0);
        assert_eq!(Mesh::new(vec![], vec![]), Err(MeshError::Empty));
        let vertices = vec![p(0.0), p(f64::NAN), p(1.0)];
        assert!(matches!(Mesh::new(vertices, vec![[0, 1, 2]]), Err(MeshError::NotFinite { vertex: 1, .. })));
        let vertices = vec![p(0.0), p(1.0), p(5000.0)];
        assert!(matches!(Mesh::new(vertices, vec![[0, 1, 2]]), Err(MeshError::OutOfRange { vertex: 2, .. })));
        assert!(matches!(Mesh::new(vec![p(0.0)], vec![[0, 0, 7]]), Err(MeshError::NoSuchVertex { vertex: 7, .. })));
    }

    #[test]
    fn loose_triangles_are_welded() {
        let mesh = tetrahedron();
        let welded = Mesh::from_triangles(&mesh.triangles()).unwrap();
        assert_eq!(welded.vertices().len(), 4);
        assert!(welded.edge_report().is_watertight());
    }

    #[test]
    fn two_bodies_are_two_components() {
        let mut triangles = tetrahedron().triangles();
        triangles.extend(tetrahedron().triangles().iter().map(|t| t.map(|p| p + nalgebra::Vector3::x() * 100.0)));
        let (labels, count) = Mesh::from_triangles(&triangles).unwrap().components();
        assert_eq!(count, 2);
        assert_eq!(labels, [0, 0, 0, 0, 1, 1, 1, 1]);
    }
}
