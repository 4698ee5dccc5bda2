//! Which parts a scene takes, from whatever source: their names, and how many of them and of their triangles.

use super::Part;
use super::error::{Place, SceneError};
use std::fmt;

/// Largest number of triangles of all parts together, sixteen times the largest scene that was tried. It stops a mistake in a file before
/// memory runs out.
const MOST_TRIANGLES: usize = 1 << 24;
/// Most parts of a scene: they form 8 million pairs, each of which is decided on.
const MOST_PARTS: usize = 1 << 12;

/// Why a part cannot be added to a scene.
#[derive(Debug)]
pub(super) enum Unfit {
    /// The scene has a part of that name.
    Duplicate {
        /// The name.
        name: String,
    },
    /// The name or a limit of the scene forbids it.
    Meaning(String),
}

impl Unfit {
    /// The error at the place where the part is declared.
    pub(super) fn at(self, place: Place) -> SceneError {
        match self {
            Self::Duplicate { name } => place.error(format!("there are two parts named `{name}`")),
            Self::Meaning(message) => place.error(message),
        }
    }
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Duplicate { name } => write!(f, "the scene has a part named `{name}` already"),
            Self::Meaning(message) => f.write_str(message),
        }
    }
}

/// Checks a part's name, and that the scene has room for one part more.
pub(super) fn admit(parts: &[Part], name: &str) -> Result<(), Unfit> {
    if let Some(message) = unfit_name(name) {
        return Err(Unfit::Meaning(message));
    }
    if parts.iter().any(|part| part.name == *name) {
        return Err(Unfit::Duplicate { name: name.to_owned() });
    }
    if parts.len() >= MOST_PARTS {
        let message =
            format!("with part `{name}` the scene has more than {MOST_PARTS} parts; join those that move together");
        return Err(Unfit::Meaning(message));
    }
    Ok(())
}

/// Adds a part from any source, after the checks that hold for all of them.
///
/// # Errors
/// A name that is unfit or taken, and too many parts or triangles.
pub(super) fn push_part(parts: &mut Vec<Part>, part: Part) -> Result<(), Unfit> {
    admit(parts, &part.name)?;
    let triangles = parts.iter().map(|part| part.mesh.faces().len()).sum::<usize>() + part.mesh.faces().len();
    if triangles > MOST_TRIANGLES {
        let name = &part.name;
        return Err(Unfit::Meaning(format!(
            "with part `{name}` the scene has {triangles} triangles, and at most {MOST_TRIANGLES} are taken"
        )));
    }
    parts.push(part);
    Ok(())
}

/// Why a name is not permitted; `None` when it is. Names are written to terminals and to CSV files, in which a
/// spreadsheet takes some first characters for the start of a formula.
fn unfit_name(name: &str) -> Option<String> {
    let is_formula = name.starts_with(['=', '+', '-', '@', '\t', '\r']);
    let wrong = match name {
        "" => "is empty",
        _ if is_formula => "begins like a spreadsheet's formula",
        _ if name.chars().any(char::is_control) => "has a control character",
        _ => return None,
    };
    Some(format!("the name `{}` {wrong}", name.escape_debug()))
}
