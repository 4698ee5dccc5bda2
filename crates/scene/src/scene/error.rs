//! Errors in a scene, with their place.

use rs274::GcodeError;
use std::fmt;
use std::path::PathBuf;
use thiserror::Error;

/// A place in a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Place {
    /// The line and column of a byte in a text.
    pub fn of_byte(file: PathBuf, text: &str, byte: usize) -> Self {
        let before = text.get(..byte).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Self { file, line: before.matches('\n').count() + 1, column: before[line_start..].chars().count() + 1 }
    }

    /// The error of what is wrong here.
    pub(super) fn error(self, message: impl fmt::Display) -> SceneError {
        SceneError::At { place: self, message: format!("{message}") }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file.display(), self.line, self.column)
    }
}

/// Why a scene cannot be loaded.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The text is neither a path nor the name of a shipped scene.
    #[error("there is no scene `{wanted}`: no such folder or file, and the shipped scenes are {known}")]
    Missing {
        /// The text given.
        wanted: String,
        /// The shipped scenes.
        known: String,
    },
    /// The folder exists, but holds no scene file.
    #[error("{folder}: the folder has no {file}, so it is not a scene", folder = folder.display(), file = super::load::SCENE_FILE)]
    NoSceneFile {
        /// The folder.
        folder: PathBuf,
    },
    /// A file that is not TOML was given in the place of a scene.
    #[error(
        "{file} is no scene: give a folder with {scene}, or its .toml file; a program comes after the scene ({cause})",
        file = file.display(), scene = super::load::SCENE_FILE
    )]
    NoScene {
        /// The file.
        file: PathBuf,
        /// Why it cannot be read as one.
        cause: Box<SceneError>,
    },
    /// A file cannot be read.
    #[error("{file}: {cause}", file = file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The cause.
        #[source]
        cause: std::io::Error,
    },
    /// A file is not TOML, a name is not defined or there twice, or a value is invalid.
    #[error("{place}: {message}")]
    At {
        /// Where.
        place: Place,
        /// What is wrong.
        message: String,
    },
    /// A part has no usable mesh.
    #[error("{place}: part `{part}`: {cause}")]
    Mesh {
        /// Place of the part's declaration.
        place: Place,
        /// The part.
        part: String,
        /// Why not.
        cause: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A program cannot be interpreted.
    #[error(transparent)]
    Program(#[from] GcodeError),
    /// The scene has no parts.
    #[error("{file}: the scene has no parts", file = file.display())]
    NoParts {
        /// The scene file.
        file: PathBuf,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_from_one_in_characters() {
        let text = "ab\nü = 1\n";
        let at = |byte| {
            let Place { line, column, .. } = Place::of_byte(PathBuf::new(), text, byte);
            (line, column)
        };
        assert_eq!(at(0), (1, 1));
        assert_eq!(at(3), (2, 1));
        assert_eq!(at(5), (2, 2)); // after the two bytes of ü
        assert_eq!(at(10_000), (3, 1));
    }
}
