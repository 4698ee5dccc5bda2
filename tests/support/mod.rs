//! What tests from outside share: a scratch folder, and the program run in it.

#![allow(dead_code, reason = "each test uses its own part")]
#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A small scene of its own, so that tests do not depend on the shipped ones and take seconds.
pub const BALL_AND_RING: &str = r#"
title = "a ball against a ring"
pairs = [["ring", "ball"]]

machine.links = [{ name = "slide", joint = { axis = "X", direction = [1, 0, 0], min_mm = -500, max_mm = 500 } }]
parts = [
  { name = "ring", shape = { kind = "torus", ring_radius_mm = 40, tube_radius_mm = 12 }, tessellation = { density = 0.3 } },
  { name = "ball", link = "slide", shape = { kind = "sphere", radius_mm = 20 }, tessellation = { density = 0.3 } },
]
"#;

/// A scratch folder, gone with the value.
pub struct Folder(tempfile::TempDir);

impl Folder {
    /// With files, by name and text.
    pub fn with(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            folder.write(name, text);
        }
        folder
    }

    /// With [`BALL_AND_RING`] as `scene`.
    pub fn with_scene() -> Self {
        Self::with(&[("scene/scene.toml", BALL_AND_RING)])
    }

    pub fn root(&self) -> &Path {
        self.0.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
        path
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bvbench"));
        command.current_dir(self.0.path()).args(arguments);
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs what must be refused, and returns the message.
    pub fn refused(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
        message
    }
}
