//! Engines as data: who they are, how they were built, and how their runners are started.

use super::PeersError;
use crate::record::RecordError;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// An engine, and how its runner is started.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Engine {
    /// Name in the records.
    pub name: String,
    /// Version, as its maker or packager gives it; empty when unknown.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub version: String,
    /// How the engine and the runner were built: package, compiler, flags; empty when unknown.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub build: String,
    /// Program and its first arguments; mode, folders and rounds follow.
    pub command: Vec<String>,
}

/// A file of engines.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Engines {
    #[serde(default)]
    engine: Vec<Engine>,
}

/// Largest file of engines, bytes.
const MOST_BYTES: u64 = 1 << 20;

impl Engine {
    /// By name and command alone.
    ///
    /// # Errors
    /// What is wrong, when either is empty.
    pub fn new(name: &str, command: Vec<String>) -> Result<Self, String> {
        Self { name: name.to_owned(), version: String::new(), build: String::new(), command }.checked()
    }

    fn checked(self) -> Result<Self, String> {
        if self.name.is_empty() {
            return Err("an engine has no name".to_owned());
        }
        match self.command.first() {
            Some(program) if !program.is_empty() => Ok(self),
            _ => Err(format!("engine `{}` has no command", self.name)),
        }
    }
}

/// Reads engines from a TOML file: tables `[[engine]]` with `name`, `version`, `build` and `command`.
///
/// # Errors
/// When the file cannot be read, or an engine has no name or no command.
pub fn read(path: &Path) -> Result<Vec<Engine>, PeersError> {
    let wrong = |message: String| PeersError::Engines { path: path.to_owned(), message };
    let bytes = fs::metadata(path).map_err(RecordError::io("read", path))?.len();
    if bytes > MOST_BYTES {
        return Err(wrong(format!("{bytes} bytes are more than {MOST_BYTES}: this is no list of engines")));
    }
    let text = fs::read_to_string(path).map_err(RecordError::io("read", path))?;
    let engines: Engines = toml::from_str(&text).map_err(|cause| wrong(cause.to_string()))?;
    engines.engine.into_iter().map(|engine| engine.checked().map_err(wrong)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Vec<Engine>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("engines.toml");
        fs::write(&path, text).unwrap();
        read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn engines_are_read_with_what_they_were_built_by() {
        let text = "[[engine]]\nname = \"one\"\nversion = \"1.2\"\nbuild = \"g++ -O3\"\ncommand = [\"a\", \"b c\"]\n\
                    [[engine]]\nname = \"two\"\ncommand = [\"x\"]\n";
        let engines = read_text(text).unwrap();
        let command = vec!["a".to_owned(), "b c".to_owned()];
        assert_eq!(engines[0], Engine { name: "one".into(), version: "1.2".into(), build: "g++ -O3".into(), command });
        assert_eq!(engines[1], Engine::new("two", vec!["x".into()]).unwrap());
        assert_eq!(read_text("").unwrap(), []);
    }

    #[test]
    fn what_names_no_engine_is_refused_with_the_reason() {
        for (text, reason) in [
            ("[[engine]]\nname = \"\"\ncommand = [\"x\"]\n", "no name"),
            ("[[engine]]\nname = \"one\"\ncommand = []\n", "engine `one` has no command"),
            ("[[engine]]\nname = \"one\"\ncommand = [\"\"]\n", "engine `one` has no command"),
            ("[[engine]]\nname = \"one\"\n", "missing field `command`"),
            ("[[engine]]\nname = \"one\"\ncommand = [\"x\"]\nflags = 1\n", "unknown field `flags`"),
            ("[[engines]]\n", "unknown field `engines`"),
            ("name", "TOML parse error"),
        ] {
            let error = read_text(text).unwrap_err();
            assert!(error.contains(reason) && error.contains("engines.toml"), "{error}");
        }
        assert!(read(Path::new("no-such-file")).unwrap_err().to_string().contains("no-such-file"));
    }
}
