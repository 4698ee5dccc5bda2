//! Bytes as the text of a scene, and behind a line `----` of its machine's file: an error, or a scene.

use bvbench::scene::{Overrides, Scene};
use std::collections::BTreeMap;

const MESH: &str = "OFF 4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const PROGRAM: &str = "G21 G90 G54\nG0 X1 Y2\nG1 Z-1 A3 F100\nT1 M6\nG43 H1\nM428\nG0 X0\nM429\nG2 X1 I0.5\nM2\n";
const POSES: &str = "part,qw,qx,qy,qz,tx,ty,tz\na,1,0,0,0,5,0,0\na,1,0,0,0,6,0,0\n";

/// Loads the bytes as a scene that finds `a.off`, `p.ngc`, `poses.csv` and `machine.toml` beside it. Shapes are coarse, so that what is
/// slow is what has no bound.
pub fn run(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let (scene, machine) = text.split_once("\n----\n").unwrap_or((&text, ""));
    let files =
        [("scene.toml", scene), ("machine.toml", machine), ("a.off", MESH), ("p.ngc", PROGRAM), ("poses.csv", POSES)];
    let files: BTreeMap<String, Vec<u8>> =
        files.into_iter().map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec())).collect();
    let overrides = Overrides { density: Some(0.05), ..Overrides::default() };
    if let Ok(scene) = Scene::from_memory("scene", files, &overrides) {
        assert!(!scene.parts.is_empty() && !scene.pairs.is_empty());
        assert!(scene.parts.iter().all(|part| part.link.is_none_or(|link| link < scene.machine.links().len())));
    }
}
