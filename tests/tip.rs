//! The tip of the tool along a real program, held against a forward chain that is written out here.

use bvbench::check::Path as ToolPath;
use bvbench::scene::Scene;
use std::path::Path;

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
