//! The tip of the tool along a real program, held against a forward chain that is written out here.

use bvbench::check::Path as ToolPath;
use bvbench::scene::{Overrides, Scene};
use rs274::Axis;
use std::path::Path;

/// A head that B turns about a point 300 mm above the tool's tip, a hundred times in one block, sampled at its ends alone: the axes lead it within `chord_mm` of the
/// circle all the same, 300 (1 - cos(φ/2)) of pieces of φ.
#[test]
fn a_turn_of_many_revolutions_is_followed_however_coarse_the_samples_are() {
    let text = r#"
title = "A head that turns"
[[machine.links]]
name = "x"
joint = { axis = "X", direction = [1, 0, 0] }
[[machine.links]]
name = "y"
parent = "x"
joint = { axis = "Y", direction = [0, 1, 0] }
[[machine.links]]
name = "z"
parent = "y"
joint = { axis = "Z", direction = [0, 0, 1] }
[[machine.links]]
name = "b"
parent = "z"
at = { xyz_mm = [0, 0, 200] }
joint = { axis = "B", direction = [0, 1, 0] }
[[parts]]
name = "tool"
link = "b"
role = "cutter"
at = { xyz_mm = [0, 0, -300] }
shape = { kind = "cylinder", radius_mm = 3, height_mm = 50 }
[program]
file = "own.ngc"
step_mm = 10000
step_deg = 1000000
tool = 1
tools = [{ number = 1, offset = { z_mm = 100 } }]
tool_centre_point = { tool_link = "b", gauge_mm = [0, 0, -200] }
"#;
    let files = [("scene.toml", text), ("own.ngc", "G21 G90 G43.4 H1\nG1 Z0 F1000\nG1 B36000\nM2\n")];
    let files = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
    let scene = Scene::from_memory("head", files.into(), &Overrides::default()).unwrap();
    let path = ToolPath::new(&scene, scene.program.as_ref().unwrap()).unwrap();
    let turns: Vec<f64> = path.samples().iter().map(|sample| sample.position[Axis::B]).collect();
    let widest = turns.windows(2).map(|two| two[1] - two[0]).fold(0.0, f64::max);
    assert!((turns[turns.len() - 1] - 200.0 * std::f64::consts::PI).abs() < 1e-9);
    assert!(300.0 * (1.0 - (0.5 * widest).cos()) <= 0.01, "{} samples, {widest} rad", turns.len());
}

/// On LinuxCNC's 5-axis mill, made by `scripts/real-scenes`: at every pose of the 4 500 lines the tip is where the program says, by the
/// kinematics of that machine written out here.
#[test]
#[ignore = "needs the scenes that scripts/real-scenes makes"]
fn the_tip_follows_the_impeller_program() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/real-scenes/xyzac-trt");
    let scene = Scene::load(&folder).unwrap();
    let run = scene.program.as_ref().unwrap();
    let programmed = rs274::sample(&run.program, &run.start, &run.sampling, &scene.rates.rapid_path).unwrap();
    let path = ToolPath::new(&scene, run).unwrap();
    let (mut worst, mut compared): (f64, u32) = (0.0, 0);
    let mut found = path.samples().iter();
    for wanted in &programmed {
        // Between the samples of the program there may be others, for the axes that follow.
        let is_it = |found: &&rs274::Sample| (found.move_index, found.fraction) == (wanted.move_index, wanted.fraction);
        let found = found.find(is_it).unwrap();
        if run.program.moves[wanted.move_index].tip_mm.is_none() {
            continue;
        }
        let [x, y, z, a, _, c, ..] = found.position.0;
        // The tip, at (0, 0, 200), seen from the table: slides taken back, then A about the line y = 20, z = 210, then C.
        let slid = [x, y + 0.0 - 20.0, 200.0 + z - 210.0];
        let (sin, cos) = (-a).sin_cos();
        let tilted = [slid[0], cos * slid[1] - sin * slid[2] + 20.0, sin * slid[1] + cos * slid[2] + 10.0];
        let (sin, cos) = (-c).sin_cos();
        let tip = [cos * tilted[0] - sin * tilted[1], sin * tilted[0] + cos * tilted[1], tilted[2]];
        let apart = tip.iter().zip(&wanted.position.0).map(|(found, wanted)| (found - wanted).abs());
        worst = apart.fold(worst, f64::max);
        compared += 1;
    }
    assert!(compared > 4000, "{compared} poses under tool-centre-point control");
    assert!(worst < 1e-9, "{worst} mm");
}
