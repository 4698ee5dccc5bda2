//! A checked triangle mesh: finite, in range, on the grid, and not empty.

use super::{Point, Triangle, grid, weld};
use std::fmt;

/// Why vertices and faces do not make a mesh.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// There are no triangles.
    Empty,
    /// A coordinate is NaN or infinite.
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
    /// A coordinate is outside the permitted range.
    OutOfRange {
        /// Index of the vertex.
        vertex: usize,
        /// Its first coordinate.
        x: f64,
        /// Its second coordinate.
        y: f64,
        /// Its third coordinate.
        z: f64,
        /// Largest magnitude of a coordinate.
        limit: f64,
    },
    /// The faces have no coordinate that is large enough, and not all are 0.
    TooSmall {
        /// Largest magnitude of a coordinate.
        largest: f64,
        /// What it has to be at least.
        limit: f64,
    },
    /// There are more faces than can be numbered.
    TooManyFaces {
        /// How many there are.
        faces: usize,
        /// Largest permitted number.
        limit: usize,
    },
    /// A face refers to a vertex that does not exist.
    NoSuchVertex {
        /// Index of the face.
        face: usize,
        /// The missing vertex.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => f.write_str("the mesh has no triangle"),
            Self::NotFinite { vertex, x, y, z } => {
                write!(f, "vertex {vertex} has a coordinate that is not finite: ({x}, {y}, {z})")
            }
            Self::OutOfRange { vertex, x, y, z, limit } => write!(
                f,
                "vertex {vertex} at ({x:?}, {y:?}, {z:?}) is farther than {limit:?} from the origin on one axis; is the unit right?"
            ),
            Self::TooSmall { largest, limit } => write!(
                f,
                "no coordinate of the faces is beyond {largest:?} in magnitude; {limit:?} is needed at least: take a smaller unit"
            ),
            Self::TooManyFaces { faces, limit } => {
                write!(f, "the mesh has {faces} faces; at most {limit} can be numbered: divide it into several")
            }
            Self::NoSuchVertex { face, vertex, vertices } => {
                write!(f, "face {face} names vertex {vertex}, but there are only {vertices}")
            }
        }
    }
}

impl std::error::Error for MeshError {}

/// Vertices and faces, mm, in the part's own frame. Vertices lie on the grid of [`grid`]; every face index is valid;
/// there is at least one face.
#[derive(Clone, Debug, PartialEq)]
pub struct GridMesh {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
}

impl GridMesh {
    /// Checks the parts and snaps the vertices to the grid.
    ///
    /// # Errors
    /// [`MeshError`] when there is no face, a coordinate is not finite or beyond ±4096 mm, or a face names a missing
    /// vertex.
    pub fn new(mut vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        check(&vertices, &faces, grid::LIMIT_MM)?;
        vertices.iter_mut().for_each(|p| *p = grid::snap(p));
        Ok(Self { vertices, faces })
    }

    /// Makes a mesh from separate triangles; corners on the same point of the grid become one vertex.
    ///
    /// # Errors
    /// As [`GridMesh::new`].
    pub fn from_triangles(triangles: &[Triangle]) -> Result<Self, MeshError> {
        let snapped: Vec<Point> = triangles.iter().flat_map(|t| &t.corners).map(grid::snap).collect();
        let vertex_of = weld::equal(&snapped);
        Self::new(snapped, vertex_of.as_chunks::<3>().0.to_vec()).map(Self::without_unused_vertices)
    }

    /// The same faces without unused vertices; vertices are in the order in which faces first use them.
    #[must_use]
    pub fn without_unused_vertices(self) -> Self {
        const UNUSED: u32 = u32::MAX;
        let (mut number_of, mut vertices) = (vec![UNUSED; self.vertices.len()], Vec::new());
        let mut faces = self.faces;
        for corner in faces.as_flattened_mut() {
            let number = &mut number_of[*corner as usize];
            if *number == UNUSED {
                *number = vertices.len() as u32;
                vertices.push(self.vertices[*corner as usize]);
            }
            *corner = *number;
        }
        vertices.shrink_to_fit();
        Self { vertices, faces }
    }

    /// The vertices, mm.
    #[must_use]
    pub fn vertices(&self) -> &[Point] {
        &self.vertices
    }

    /// The vertices, mm, and the faces.
    #[must_use]
    pub fn into_parts(self) -> (Vec<Point>, Vec<[u32; 3]>) {
        (self.vertices, self.faces)
    }

    /// The faces, as indices into [`GridMesh::vertices`].
    #[must_use]
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The triangle of a face, given by its vertex indices, mm.
    #[inline]
    #[must_use]
    pub fn triangle(&self, face: [u32; 3]) -> Triangle {
        Triangle { corners: face.map(|v| self.vertices[v as usize]) }
    }

    /// The triangles, in face order, mm.
    #[must_use]
    pub fn triangles(&self) -> Vec<Triangle> {
        self.faces.iter().map(|&face| self.triangle(face)).collect()
    }
}

/// Whether vertices and faces make a mesh whose coordinates reach to `limit`.
pub(crate) fn check(vertices: &[Point], faces: &[[u32; 3]], limit: f64) -> Result<(), MeshError> {
    if faces.is_empty() {
        return Err(MeshError::Empty);
    }
    for (vertex, p) in vertices.iter().enumerate() {
        let (x, y, z) = (p.x, p.y, p.z);
        if !(x.is_finite() && y.is_finite() && z.is_finite()) {
            return Err(MeshError::NotFinite { vertex, x, y, z });
        }
        if p.coords.amax() > limit {
            return Err(MeshError::OutOfRange { vertex, x, y, z, limit });
        }
    }
    for (face, corners) in faces.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices.len()) {
            return Err(MeshError::NoSuchVertex { face, vertex, vertices: vertices.len() });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> GridMesh {
        let vertices =
            vec![Point::origin(), Point::new(6.0, 0.0, 0.0), Point::new(0.0, 1.0, 0.0), Point::new(0.0, 0.0, 1.0)];
        GridMesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
    }

    #[test]
    fn bad_input_is_refused() {
        let p = |x: f64| Point::new(x, 0.0, 0.0);
        assert_eq!(GridMesh::new(vec![], vec![]), Err(MeshError::Empty));
        let vertices = vec![p(0.0), p(f64::NAN), p(1.0)];
        assert!(matches!(GridMesh::new(vertices, vec![[0, 1, 2]]), Err(MeshError::NotFinite { vertex: 1, .. })));
        let vertices = vec![p(0.0), p(1.0), p(5000.0)];
        assert!(matches!(GridMesh::new(vertices, vec![[0, 1, 2]]), Err(MeshError::OutOfRange { vertex: 2, .. })));
        assert!(matches!(GridMesh::new(vec![p(0.0)], vec![[0, 0, 7]]), Err(MeshError::NoSuchVertex { vertex: 7, .. })));
    }

    #[test]
    fn loose_triangles_are_welded() {
        let mesh = tetrahedron();
        let welded = GridMesh::from_triangles(&mesh.triangles()).unwrap();
        assert_eq!(welded.vertices().len(), 4);
        assert!(welded.edge_report().is_watertight());
    }
}
