//! A small mill for the tests of this crate.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::judge::Dynamics;
use bvbench::scene::{Overrides, ProgramRun, Scene};
use std::collections::BTreeMap;
use std::io::Write;

/// A block of 20 mm sides on a table, and a holder of 20 mm sides above it that moves in X, Y and Z; at zero the holder stands 50 mm to the
/// left of the block, at the same height.
pub(crate) const SCENE: &str = r#"
title = "block"
description = "A holder and a block."
provenance = "Made for a test."
[[machine.links]]
name = "x"
joint = { axis = "X", direction = [1, 0, 0], min_mm = -200, max_mm = 200 }
[[machine.links]]
name = "y"
parent = "x"
joint = { axis = "Y", direction = [0, 1, 0], min_mm = -200, max_mm = 200 }
[[machine.links]]
name = "z"
parent = "y"
joint = { axis = "Z", direction = [0, 0, 1], min_mm = -200, max_mm = 200 }
[[parts]]
name = "block"
role = "fixture"
at = { xyz_mm = [70, 0, 0] }
shape = { kind = "rounded-box", size_mm = [20, 20, 20], fillet_mm = 1 }
[[parts]]
name = "holder"
role = "holder"
link = "z"
shape = { kind = "rounded-box", size_mm = [20, 20, 20], fillet_mm = 1 }
[program]
file = "program.ngc"
"#;

/// The scene.
pub(crate) fn mill() -> Scene {
    scene(SCENE)
}

/// The same, where the holder belongs to tool 1, and a smaller one far above it to tool 2.
pub(crate) fn tools() -> Scene {
    const SMALL: &str = r#"
[[parts]]
name = "small"
role = "holder"
link = "z"
tool = 2
at = { xyz_mm = [0, 0, 100] }
shape = { kind = "rounded-box", size_mm = [5, 5, 5], fillet_mm = 1 }
[program]"#;
    scene(&SCENE.replace("link = \"z\"", "link = \"z\"\ntool = 1").replace("\n[program]", SMALL))
}

/// A scene of a text.
pub(crate) fn scene(text: &str) -> Scene {
    let files = [("scene.toml", text), ("program.ngc", "G21 G90 G94\nG1 X1 F100\n")];
    let files: BTreeMap<String, Vec<u8>> = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec())).into();
    Scene::from_memory("mill", files, &Overrides::default()).unwrap()
}

/// A program on the scene's machine.
pub(crate) fn run(scene: &Scene, text: &str) -> ProgramRun {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    write!(file, "G21 G90 G94\n{text}").unwrap();
    scene.program.as_ref().unwrap().with_program(file.path()).unwrap()
}

/// The same acceleration for every axis, mm/s² and radians/s².
pub(crate) fn dynamics(acceleration: f64) -> Dynamics {
    Dynamics { acceleration: [acceleration; 9], deceleration: [acceleration; 9], resolution: [0.001; 9] }
}
