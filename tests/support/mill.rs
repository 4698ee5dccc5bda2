//! A small mill, and what `check` finds of a program on it.

#![allow(dead_code, reason = "each test uses its own part")]
#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::support::{Folder, in_memory, run_own, with_zones};
use bvbench::check::Outcome;
use bvbench::scene::Scene;

/// A cutter of 10 mm over a block of 100 x 100 x 20 whose top is at Z 0, and a clamp beside it.
pub const MILL: &str = r#"
title = "A small mill"
machine.links = [
  { name = "table", joint = { axis = "X", direction = [-1, 0, 0], min_mm = -200, max_mm = 200 } },
  { name = "head", joint = { axis = "Z", direction = [0, 0, 1], min_mm = -50, max_mm = 200 } },
]
parts = [
  { name = "block", link = "table", role = "workpiece", at = { xyz_mm = [0, 0, -10] }, shape = { kind = "rounded-box", size_mm = [100, 100, 20], fillet_mm = 1 } },
  { name = "clamp", link = "table", at = { xyz_mm = [70, 0, 0] }, shape = { kind = "rounded-box", size_mm = [20, 20, 40], fillet_mm = 1 } },
  { name = "cutter", link = "head", role = "cutter", shape = { kind = "cylinder", radius_mm = 5, height_mm = 30 } },
]
[program]
file = "own.ngc"
start = { z_mm = 50 }
[check]
rapid_mm_min = 6000
"#;

pub fn scene_of(text: &str, program: &str) -> Scene {
    in_memory("mill", &[("scene.toml", text), ("own.ngc", program)])
}

/// The same in a folder.
pub fn folder_of(text: &str, program: &str) -> Folder {
    Folder::with(&[("scene.toml", text), ("own.ngc", program)])
}

pub fn mill(program: &str) -> Scene {
    scene_of(MILL, program)
}

/// The same from another place, with pairs that the scene names.
pub fn mill_from(start: &str, pairs: &str, program: &str) -> Scene {
    let title = "title = \"A small mill\"\n";
    scene_of(&MILL.replace("start = { z_mm = 50 }", start).replace(title, &format!("{title}{pairs}\n")), program)
}

pub fn outcome_of(text: &str, program: &str) -> Outcome {
    run_own(&scene_of(text, program), &with_zones(&[]))
}

pub fn told(program: &str) -> Vec<(&'static str, u32)> {
    told_by(MILL, program)
}

pub fn told_by(text: &str, program: &str) -> Vec<(&'static str, u32)> {
    outcome_of(text, program).events.iter().map(|event| (event.kind.name(), event.first.line)).collect()
}

/// The mill with the cutter as tool 1, a longer tool 2, and tool 3, whose shank begins 10 mm above its tip.
pub fn mill_with_tools() -> String {
    let tools = r#"
  { name = "long", link = "head", role = "cutter", tool = 2, at = { xyz_mm = [0, 0, -20] }, shape = { kind = "cylinder", radius_mm = 5, height_mm = 50 } },
  { name = "tip", link = "head", role = "cutter", tool = 3, shape = { kind = "cylinder", radius_mm = 5, height_mm = 10 } },
  { name = "shank", link = "head", role = "shank", tool = 3, at = { xyz_mm = [0, 0, 10] }, shape = { kind = "cylinder", radius_mm = 6, height_mm = 20 } },
]
[program]
tool = 1
"#;
    MILL.replacen("role = \"cutter\"", "role = \"cutter\", tool = 1", 1).replacen("]\n[program]\n", tools, 1)
}
