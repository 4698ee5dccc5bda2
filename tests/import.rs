//! Mesh files and scene files from outside: what `scene info` says of a part's surface, and what it refuses, with the exit code.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use serde_json::Value;
use std::fs;
use support::Folder;

/// A slide along X that carries `part` before a block.
const SCENE: &str = r#"title = "A slide"
[[machine.links]]
name = "slide"
joint = { axis = "X", direction = [1, 0, 0] }
[[parts]]
name = "part"
link = "slide"
mesh = "part.off"
[[parts]]
name = "block"
at = { xyz_mm = [100, 0, 0] }
shape = { kind = "rounded-box", size_mm = [2, 3, 4] }
"#;

/// A tetrahedron of 1 mm³, one face twice; beside it one with its last corner 0.001 mm aside in the last face.
const GAP: &str = "OFF 9 9 0\n0 0 0\n6 0 0\n0 1 0\n0 0 1\n20 0 0\n26 0 0\n20 1 0\n20 0 1\n20.001 0 1\n\
    3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n3 3 1 2\n3 4 6 5\n3 4 5 7\n3 4 7 6\n3 5 6 8\n";

fn folder(scene: &str, mesh: &str) -> Folder {
    Folder::with(&[("scene.toml", scene), ("part.off", mesh)])
}

fn info(folder: &Folder, more: &[&str]) -> (Option<i32>, String, String) {
    folder.told(&[&["scene", "info", "."], more].concat())
}

fn surface(scene: &str) -> Value {
    let (code, shown, told) = info(&folder(scene, GAP), &["--json"]);
    assert_eq!(code, Some(0), "{told}");
    let mut value: Value = serde_json::from_str(&shown).unwrap();
    value["parts"][0]["surface"].take()
}

#[test]
fn scene_info_reports_gaps_and_what_welding_closes() {
    let open = surface(SCENE);
    // The gap is at a corner: on each side of it the two edges from there are on one triangle.
    assert_eq!(
        (&open["open_edges"], &open["components"], &open["leaking_components"]),
        (&4.into(), &2.into(), &1.into())
    );
    assert_eq!((&open["import"]["duplicates_dropped"], &open["import"]["welded_vertices"]), (&1.into(), &0.into()));
    let closed = surface(&SCENE.replace("\"part.off\"", "\"part.off\"\nweld_mm = 0.01"));
    assert_eq!((&closed["open_edges"], &closed["leaking_components"]), (&0.into(), &0.into()));
    assert_eq!((&closed["import"]["weld_mm"], &closed["import"]["welded_vertices"]), (&0.01.into(), &1.into()));
    assert!((closed["volume_mm3"].as_f64().unwrap() - 2.0).abs() < 1e-6); // twice 6·1·1 / 6

    let (_, text, _) = info(&folder(SCENE, GAP), &[]);
    assert!(text.contains("not watertight: 4 edges on one triangle, 2 components, 1 leaking"), "{text}");
    assert!(
        text.contains("part from part.off: OFF in units of 1 mm, 9 triangles, 1 duplicate triangles dropped"),
        "{text}"
    );
    assert!(
        text.lines().any(|line| line.trim_start().starts_with("block")
            && line.contains("24.0")
            && line.ends_with("watertight")),
        "{text}"
    );
}

#[test]
fn whatever_is_wrong_is_said_with_its_place_and_exit_code_2() {
    let scene = |from: &str, to: &str| {
        assert!(SCENE.contains(from), "{from}");
        (SCENE.replacen(from, to, 1), GAP.to_owned())
    };
    let mesh = |from: &str, to: &str| {
        assert!(GAP.contains(from), "{from}");
        (SCENE.to_owned(), GAP.replacen(from, to, 1))
    };
    for ((scene, mesh), message) in [
        (mesh("6 0 0\n", "nan 0 0\n"), "part.off: line 3: `nan 0 0` is not finite"),
        (mesh("OFF 9", "OFF 4000000000"), "part.off: line 19: the file ends before vertex 18 of 4000000000"),
        (mesh("3 0 2 1\n", "3 0 2 9\n"), "part.off: line 11: there is no vertex 9, only 9"),
        ((SCENE.to_owned(), GAP[..120].to_owned()), "part.off: line "),
        ((SCENE.to_owned(), "OFF 0 0 0\n".to_owned()), "part.off: the mesh has no triangle"),
        ((SCENE.to_owned(), String::new()), "part.off: line 1: the file ends before its header"),
        (mesh("6 0 0\n", "6000 0 0\n"), "is the unit right?"),
        (scene("\"part.off\"", "\"part.off\"\nweld_mm = 2"), "vertices cannot be welded within 2 mm"),
        (scene("[2, 3, 4] }", "[2, 3, 4] }\nweld_mm = 0.1"), "`weld_mm` goes with `mesh`"),
        (
            scene("\"slide\"\njoint", "\"slide\"\nparent = \"slide\"\njoint"),
            "scene.toml:3:8: links stand on one another in a circle",
        ),
        (scene("link =", "links ="), "scene.toml:7:1: unknown field `links`"),
        (
            scene("size_mm = [2, 3, 4]", "size_mm = [2, 3, 1e9]"),
            "scene.toml:10:8: part `block`: size_mm[2]: 1000000000 is outside",
        ),
        (
            scene("shape = {", "tessellation = { density = 1e9 }\nshape = {"),
            "scene.toml:10:8: part `block`: density: 1000000000 is outside 0.05 to 20",
        ),
    ] {
        let (code, _, error) = info(&folder(&scene, &mesh), &[]);
        assert_eq!(code, Some(2), "{error}");
        assert!(error.contains(message), "{error}\ndoes not say\n{message}");
    }
}

/// Every reader, given a file that ends too early or names what is not there.
#[test]
fn every_reader_refuses_a_cut_file_with_its_place_and_exit_code_2() {
    let seed = |name: &str| fs::read(format!("{}/fuzz/corpus/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    for (seeds, place) in [
        ("stl/binary.stl", "the header announces 4 triangles, 284 bytes, but the file has 213 bytes"),
        ("stl/text.stl", "line "),
        ("off/tetrahedron.off", "line 9: the file ends before face 2 of 4"),
        ("ply/text.ply", "line "),
        ("ply/little.ply", "byte "),
        ("ply/big.ply", "byte "),
        ("glb/placed.glb", "byte 8: the header announces"),
        ("three_mf/deflated.3mf", if cfg!(feature = "3mf") { "archive, " } else { "3MF is read by a build with" }),
        ("obj/tetrahedron.obj", "line 10: "),
    ] {
        let mut content = seed(seeds);
        if seeds.starts_with("obj") {
            // What is left of a text of this format may be a mesh; a vertex that is gone makes it none.
            content = String::from_utf8(content).unwrap().replacen("v 0 0 1\n", "", 1).into_bytes();
        } else {
            content.truncate(content.len() * 3 / 4);
        }
        let name = format!("part.{}", seeds.rsplit('.').next().unwrap());
        let folder = folder(&SCENE.replace("part.off", &name), "");
        fs::write(folder.path(&name), content).unwrap();
        let (code, _, error) = info(&folder, &[]);
        assert_eq!(code, Some(2), "{seeds}: {error}");
        assert!(error.contains(&format!("{name}: {place}")), "{seeds}: {error}");
    }
}
