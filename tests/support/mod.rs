//! What tests from outside share: a scratch folder, the program run in it, and what `check` finds in a scene in memory.

#![allow(dead_code, reason = "each test uses its own part")]
#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use bvbench::check::{Outcome, Settings, check};
use bvbench::measure::Silent;
use bvbench::registry;
use bvbench::scene::{Clearances, Overrides, ProgramRun, Scene};
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

/// A scene of files in memory, by name and text.
pub fn in_memory(name: &str, files: &[(&str, &str)]) -> Scene {
    let contents = files.iter().map(|(file, text)| ((*file).to_owned(), text.as_bytes().to_vec())).collect();
    Scene::from_memory(name, contents, &Overrides::default())
        .unwrap_or_else(|error| panic!("{name}: {error}\n{files:?}"))
}

pub fn with_zones(zones_mm: &[f64]) -> Settings {
    Settings { clearances: Some(Clearances::everywhere(zones_mm)), ..Settings::standard() }
}

/// Checks a run with the fastest variant.
pub fn checked(scene: &Scene, run: &ProgramRun, settings: &Settings) -> Outcome {
    let registry = registry::standard();
    check(scene, run, registry.fastest().unwrap(), &registry, settings, &Silent).unwrap()
}

pub fn run_own(scene: &Scene, settings: &Settings) -> Outcome {
    checked(scene, scene.program.as_ref().unwrap(), settings)
}

/// Arguments without spaces, from one line.
pub fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

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

    /// Runs the program: exit code, standard output and standard error.
    pub fn told(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let output = self.run(arguments);
        let [shown, told] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (output.status.code(), shown, told)
    }

    /// Runs what must succeed, and returns what it prints.
    pub fn done(&self, arguments: &[&str]) -> String {
        let (code, shown, told) = self.told(arguments);
        assert_eq!(code, Some(0), "{arguments:?}: {shown}\n{told}");
        shown
    }

    /// Runs what must be refused, and returns the message.
    pub fn refused(&self, arguments: &[&str]) -> String {
        let (code, _, message) = self.told(arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
        message
    }
}
