//! Meshes from STL files.

use super::{Mesh, MeshError, Point, Triangle};
use serde::Deserialize;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;
use thiserror::Error;

/// What a number in a mesh file means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Millimetre.
    #[default]
    Mm,
    /// Metre.
    M,
    /// Inch.
    Inch,
}

impl Unit {
    /// Its length, mm.
    #[must_use]
    pub const fn in_mm(self) -> f64 {
        match self {
            Self::Mm => 1.0,
            Self::M => 1000.0,
            Self::Inch => 25.4,
        }
    }
}

/// Why a file is not a mesh.
#[derive(Debug, Error)]
pub enum ImportError {
    /// It cannot be read, or not as STL.
    #[error("{file}: {cause}", file = file.display())]
    Read {
        /// The file.
        file: std::path::PathBuf,
        /// Why not.
        #[source]
        cause: io::Error,
    },
    /// Its triangles are not a mesh.
    #[error("{file}: {cause}", file = file.display())]
    Mesh {
        /// The file.
        file: std::path::PathBuf,
        /// Why not.
        #[source]
        cause: MeshError,
    },
}

/// Reads an STL file, ASCII or binary; corners that coincide become one vertex.
///
/// # Errors
/// [`ImportError`] when the file cannot be read or its triangles are not a mesh.
pub fn load(path: &Path, unit: Unit) -> Result<Mesh, ImportError> {
    let read = |cause| ImportError::Read { file: path.to_owned(), cause };
    let mut file = BufReader::new(File::open(path).map_err(read)?);
    let mut triangles = Vec::new();
    for triangle in stl_io::create_stl_reader(&mut file).map_err(read)? {
        let corners = triangle.map_err(read)?.vertices;
        let point = |i: usize| Point::from([0, 1, 2].map(|axis| f64::from(corners[i][axis]) * unit.in_mm()));
        triangles.push(Triangle::new(point(0), point(1), point(2)));
    }
    Mesh::from_triangles(&triangles).map_err(|cause| ImportError::Mesh { file: path.to_owned(), cause })
}
