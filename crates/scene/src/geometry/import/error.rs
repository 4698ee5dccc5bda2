//! Why a file is not a mesh.

use super::super::MeshError;
use std::fmt;
use std::path::PathBuf;
use thiserror::Error;

/// Position of an error in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line, counted from 1.
    Line(usize),
    /// A triangle, counted from 0, and the byte at which it begins.
    Triangle {
        /// Its number.
        index: usize,
        /// Offset from the beginning of the file.
        byte: usize,
    },
    /// A byte, counted from 0.
    Byte(usize),
    /// A named object of the file, such as `meshes[0].primitives[1]`.
    Object(String),
    /// A line and a column of a file within an archive, both counted from 1.
    Part {
        /// Its name.
        part: String,
        /// The line.
        line: usize,
        /// The column, in bytes.
        column: usize,
    },
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Triangle { index, byte } => write!(f, "triangle {index} at byte {byte}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Object(name) => write!(f, "{name}"),
            Self::Part { part, line, column } => write!(f, "{part}: line {line}, column {column}"),
        }
    }
}

/// Why a file cannot be read as a mesh.
#[derive(Debug, Error)]
pub enum ImportError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is too large.
    #[error("{}: {bytes} bytes, and at most {most} are read", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The limit, bytes.
        most: u64,
    },
    /// The welding tolerance is outside the permitted range.
    #[error("{}: vertices cannot be welded within {weld_mm} mm; it must be 0, or from {least} to {most}", path.display())]
    Tolerance {
        /// The file.
        path: PathBuf,
        /// The requested tolerance, mm.
        weld_mm: f64,
        /// The smallest permitted tolerance, mm.
        least: f64,
        /// The largest permitted tolerance, mm.
        most: f64,
    },
    /// Neither the name nor the content of the file identifies its format.
    #[error("{}: not an STL, OBJ, OFF, PLY, GLB or 3MF file{hint}", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The format it seems to be in, and the command that converts it; empty if neither is known.
        hint: &'static str,
    },
    /// The format needs a build feature that this build does not have.
    #[error("{}: {format} is read by a build with `--features {feature}`; this one was built without", path.display())]
    NotBuiltIn {
        /// The file.
        path: PathBuf,
        /// The format's name.
        format: &'static str,
        /// Name of the feature.
        feature: &'static str,
    },
    /// The header announces another size than the file has.
    #[error("{}: the header announces {declared} triangles, {expected} bytes, but the file has {bytes} bytes", path.display())]
    WrongSize {
        /// The file.
        path: PathBuf,
        /// Number of triangles in the header.
        declared: u64,
        /// Bytes that these triangles would take, with the header.
        expected: u64,
        /// Bytes of the file.
        bytes: u64,
    },
    /// Something in the file is wrong.
    #[error("{}: {place}: {message}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Position of the error.
        place: Place,
        /// Description of the error.
        message: String,
    },
    /// The triangles do not make a mesh.
    #[error("{}: {source}", path.display())]
    NotAMesh {
        /// The file.
        path: PathBuf,
        /// The reason why they do not.
        source: MeshError,
    },
}

/// Quotes text from a file, shortened to a readable length.
pub(super) fn quote(text: &str) -> String {
    const LONGEST: usize = 60;
    let text = text.trim();
    let short: String = text.chars().take(LONGEST).collect();
    if short.len() < text.len() { format!("`{short}...`") } else { format!("`{short}`") }
}
