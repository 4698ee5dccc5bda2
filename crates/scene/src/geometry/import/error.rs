//! Why a file is not a mesh.

use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Position of an error in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
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
    #[cfg(feature = "3mf")]
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
            #[cfg(feature = "3mf")]
            Self::Part { part, line, column } => write!(f, "{part}: line {line}, column {column}"),
        }
    }
}

/// Why a file cannot be read as a mesh.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}: {message}", path.display())]
pub struct ImportError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong, after its place in the file where it has one.
    pub message: String,
}

impl ImportError {
    /// An error of the file as a whole.
    pub(super) fn of_file(path: &Path, message: impl fmt::Display) -> Self {
        Self { path: path.into(), message: format!("{message}") }
    }

    /// An error at a place of the file.
    pub(super) fn at(path: &Path, place: &Place, message: impl fmt::Display) -> Self {
        Self::of_file(path, format!("{place}: {message}"))
    }
}

/// Quotes text from a file, shortened to a readable length.
pub(super) fn quote(text: &str) -> String {
    const LONGEST: usize = 60;
    let text = text.trim();
    let short: String = text.chars().take(LONGEST).collect();
    if short.len() < text.len() { format!("`{short}...`") } else { format!("`{short}`") }
}
