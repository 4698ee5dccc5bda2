//! Bytes as the text of a scene, behind a line `----` of its machine's file, and behind another one of a tool and a stock as a command line
//! has them, a line each: an error, or a scene that is set up for a job.

use bvbench::scene::set_up::SetUp;
use bvbench::scene::{Overrides, ProgramRun, Scene, StockSpec, ToolEntry};
use std::collections::BTreeMap;

const MESH: &str = "OFF 4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const PROGRAM: &str = "G21 G90 G54\nG0 X1 Y2\nG1 Z-1 A3 F100\nT1 M6\nG43 H1\nM428\nG0 X0\nM429\nG2 X1 I0.5\nM2\n";
const POSES: &str = "part,qw,qx,qy,qz,tx,ty,tz\na,1,0,0,0,5,0,0\na,1,0,0,0,6,0,0\n";

/// Loads the bytes as a scene that finds `a.off`, `p.ngc`, `poses.csv` and `machine.toml` beside it. Shapes are coarse, so that what is
/// slow is what has no bound.
pub fn run(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let (scene, rest) = text.split_once("\n----\n").unwrap_or((&text, ""));
    let (machine, job) = rest.split_once("\n----\n").unwrap_or((rest, ""));
    let files =
        [("scene.toml", scene), ("machine.toml", machine), ("a.off", MESH), ("p.ngc", PROGRAM), ("poses.csv", POSES)];
    let files: BTreeMap<String, Vec<u8>> =
        files.into_iter().map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec())).collect();
    let overrides = Overrides { density: Some(0.05), ..Overrides::default() };
    if let Ok(mut scene) = Scene::from_memory("scene", files, &overrides) {
        set_up(&mut scene, job);
        assert!(!scene.parts.is_empty());
        assert!(scene.parts.iter().all(|part| part.link.is_none_or(|link| link < scene.machine.links().len())));
    }
}

/// A tool on the first line, stock on the second. Stock from files is left out: the search would read what it finds on the disk.
fn set_up(scene: &mut Scene, job: &str) {
    let (tool, stock) = job.split_once('\n').unwrap_or((job, ""));
    let is_shape = stock.starts_with("box:") || stock.starts_with("cylinder:");
    let job = SetUp {
        spindle: Some("world".to_owned()),
        tools: ToolEntry::parse(tool).into_iter().collect(),
        stock: StockSpec::parse(stock).ok().filter(|_| is_shape),
        ..SetUp::default()
    };
    let mut run = scene.program.clone().unwrap_or_else(ProgramRun::of_mill);
    // An error may leave the scene half set up; its parts and pairs fit each other all the same.
    let _ = scene.set_up(&mut run, &job);
    let parts = scene.parts.len();
    assert!(scene.pairs.iter().chain(&scene.random).all(|pair| pair.a < parts && pair.b < parts));
}
