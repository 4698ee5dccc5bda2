//! `view` and `scene export --format glb` from outside: what the page is given, what is refused, and what another reader makes of
//! the GLB file.

#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use base64::prelude::{BASE64_STANDARD, Engine};
use bvbench::check::Path as ToolPath;
use bvbench::scene::Scene;
use bvbench::view::glb;
use nalgebra::{Isometry3, Matrix4, Point3, Quaternion, Translation3, UnitQuaternion};
use serde_json::Value;
use support::Folder;

/// Two cubes of 10 mm on one line; the second slides.
const SCENE: &str = r#"
title = "hammer & anvil"
pairs = [["anvil", "hammer"]]

machine.links = [{ name = "slide", joint = { axis = "X", direction = [1, 0, 0], min_mm = -100, max_mm = 100 } }]
parts = [
  { name = "anvil", shape = { kind = "rounded-box", size_mm = [10, 10, 10] } },
  { name = "hammer", link = "slide", shape = { kind = "rounded-box", size_mm = [10, 10, 10] }, at = { xyz_mm = [0, 1, 2] } },
]
[program]
file = "blow.ngc"
start = { x_mm = -50 }
"#;

const PROGRAM: &str = "G21 G90 G94\nG0 X-30\nG1 X0 F600\nM2\n";

fn folder() -> Folder {
    Folder::with(&[("scene.toml", SCENE), ("blow.ngc", PROGRAM)])
}

/// The data of a page.
fn data(page: &str) -> Value {
    let (_, after) = page.split_once("<script type=\"application/json\">").unwrap();
    serde_json::from_str(after.split_once("</script>").unwrap().0).unwrap()
}

fn f32s(packed: &Value) -> Vec<f64> {
    let bytes = BASE64_STANDARD.decode(packed.as_str().unwrap()).unwrap();
    bytes.as_chunks::<4>().0.iter().map(|&bytes| f64::from(f32::from_le_bytes(bytes))).collect()
}

#[test]
fn the_page_says_when_and_where_the_hammer_meets_the_anvil() {
    let folder = folder();
    folder.done(&["view", ".", "--out", "blow.html", "--quiet", "--levels", "2"]);
    let page = std::fs::read_to_string(folder.path("blow.html")).unwrap();
    let data = data(&page);
    assert_eq!((&data["format"], &data["title"]), (&"bvbench-view/2".into(), &"hammer & anvil".into()));
    let program = &data["program"];
    // 20 mm at 15 000 mm/min, then 30 mm at 600 mm/min.
    assert!((program["duration_s"].as_f64().unwrap() - 3.08).abs() < 1e-9);
    let times: Vec<f64> = f32s(&program["durations"])
        .iter()
        .scan(0.0, |time, duration| {
            *time += duration;
            Some(*time)
        })
        .collect();
    let events = data["events"].as_array().unwrap();
    let kinds: Vec<_> = events.iter().map(|event| event["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["near", "near", "near", "collision"]);
    let hit = &events[3];
    // The faces are 20 mm apart at X-30: 2 s into line 3.
    let key = hit["first"].as_f64().unwrap();
    assert!((times[key as usize] - 2.08).abs() < 0.01 && key.fract() == 0.0, "{key} {times:?}");
    assert_eq!((&hit["line"], &hit["to_the_end"]), (&3.into(), &true.into()));
    // Where the faces overlap: y from -4 to 5, z from -3 to 5, on the anvil's face at x = -5.
    let first = &hit["contacts"][0];
    let [x, y, z] = [0, 1, 2].map(|axis| first["at"][axis].as_f64().unwrap());
    assert!((x + 5.0).abs() < 0.02 && (-4.0..=5.0).contains(&y) && (-3.0..=5.0).contains(&z), "{x} {y} {z}");
    // The nearest pair half way through line 3's way to contact: 10 mm after 1.08 s.
    let (keys, mm) = (f32s(&data["distances"]["keys"]), f32s(&data["distances"]["mm"]));
    let axis = f32s(&program["values"]);
    for (key, mm) in keys.iter().zip(mm).filter(|(key, _)| key.fract() == 0.0) {
        let gap = (-5.0 - (axis[*key as usize] + 5.0)).max(0.0);
        assert!((mm - gap).abs() < 1e-4, "at key {key}: {mm} but {gap}");
    }
    assert_eq!(data["variants"].as_array().unwrap().len(), 2);
    assert_eq!(data["variants"][0]["trees"][0]["levels"].as_array().unwrap().len(), 2);
}

#[test]
fn the_page_has_whatever_fails_the_check() {
    let folder = Folder::with(&[("scene.toml", SCENE), ("blow.ngc", "T7 M6\nG0 X-60\nG1 X-120 F6000\nG1 X-90\nM2\n")]);
    assert_eq!(folder.run(&["check", ".", "--quiet"]).status.code(), Some(1));
    folder.done(&["view", ".", "--out", "blow.html", "--quiet"]);
    let data = data(&std::fs::read_to_string(folder.path("blow.html")).unwrap());
    let faults = data["faults"].as_array().unwrap();
    let told: Vec<_> = faults.iter().map(|fault| (fault["kind"].as_str().unwrap(), fault["line"].as_u64())).collect();
    assert_eq!(told, [("over-travel", Some(3)), ("tool-without-part", Some(1))]);
    let place = |fault: usize, name: &str| faults[fault][name].as_f64().unwrap();
    assert!(faults[0]["text"].as_str().unwrap().contains("axis X at -120 mm"), "{faults:?}");
    assert!(place(0, "first") < place(0, "last"), "{faults:?}");
    assert_eq!(place(1, "last") + 1.0, data["program"]["keys"].as_f64().unwrap());
    let notes = data["notes"].as_array().unwrap();
    assert!(notes.iter().any(|note| note.as_str().unwrap().contains("tool 7")), "{notes:?}");
}

/// A bit that turns 20 mm from the spindle's axis, and a pin on the other side of the axis, out of reach of the bit as drawn.
const TURNED: &str = r#"
title = "a bit and a pin"
machine.links = [{ name = "head", joint = { axis = "X", direction = [1, 0, 0] } }]
parts = [
  { name = "pin", role = "fixture", at = { xyz_mm = [0, -20, 0] }, shape = { kind = "rounded-box", size_mm = [4, 4, 4] } },
  { name = "bit", role = "cutter", tool = 70000, link = "head", at = { xyz_mm = [0, 20, 0] }, shape = { kind = "rounded-box", size_mm = [4, 4, 10] } },
]
[program]
file = "turn.ngc"
tool = 70000
tool_centre_point = { tool_link = "head" }
"#;

#[test]
fn a_pair_within_reach_only_as_it_turns_is_examined_and_shown() {
    let folder = Folder::with(&[("scene.toml", TURNED), ("turn.ngc", "M3 S1000\nG1 X5 F100\nM2\n")]);
    let output = folder.run(&["check", ".", "--json", "--quiet", "--junit", "found.xml"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&found["events"][0]["kind"], &found["pairs_not_examined"]),
        (&"unresolved".into(), &Value::Array(vec![]))
    );
    let junit = std::fs::read_to_string(folder.path("found.xml")).unwrap();
    assert!(junit.contains("failures=\"1\"") && junit.contains("pin:bit"), "{junit}");
    folder.done(&["view", ".", "--out", "turn.html", "--quiet"]);
    let data = data(&std::fs::read_to_string(folder.path("turn.html")).unwrap());
    assert_eq!(data["events"][0]["kind"], "unresolved");
    // Numbers of tools and of pairs have 32 bits.
    let u32s = |packed: &Value| -> Vec<u32> {
        let bytes = BASE64_STANDARD.decode(packed.as_str().unwrap()).unwrap();
        bytes.as_chunks::<4>().0.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect()
    };
    let tools = u32s(&data["program"]["moves"]["tool"]);
    assert!(!tools.is_empty() && tools.iter().all(|&tool| tool == 70_000), "{tools:?}");
    let nearest = u32s(&data["distances"]["nearest"]);
    assert_eq!(nearest.len(), f32s(&data["distances"]["keys"]).len());
    assert!(nearest.iter().all(|&pair| pair == 0 || pair == u32::MAX), "{nearest:?}");
}

#[test]
fn the_page_is_the_same_for_any_number_of_threads() {
    let folder = folder();
    for threads in ["1", "2"] {
        let out = format!("{threads}.html");
        folder.done(&["view", ".", "-q", "--out", &out, "--threads", threads]);
    }
    let read = |name: &str| std::fs::read(folder.path(name)).unwrap();
    assert!(read("1.html") == read("2.html"));
}

#[test]
fn what_cannot_be_shown_is_refused_by_name() {
    let folder = folder();
    for (arguments, complaint) in [
        (&["--levels", "0"][..], "1 to 12 levels"),
        (&["--variant", "brute"][..], "no tree that could be drawn"),
        (&["--variant", "aabb,rss,dop-8"][..], "names 3 variants"),
        (&["--variant", "moon"][..], "no variant `moon`"),
        (&["--out", "nowhere/x.html"][..], "cannot write nowhere/x.html"),
    ] {
        let output = folder.run(&[&["view", ".", "-q"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains(complaint), "{said}");
    }
}

/// A GLB file as the `gltf` crate, which checks it against the specification, reads it.
struct Glb {
    document: gltf::Document,
    bytes: Vec<u8>,
}

impl Glb {
    fn read(content: &[u8]) -> Self {
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(content).unwrap();
        Self { document, bytes: blob.unwrap() }
    }

    /// World from the node of a part, metres, with what the animation says at key `key`.
    fn world_from_part(&self, name: &str, key: usize) -> Matrix4<f64> {
        let parents = self.document.nodes().flat_map(|node| {
            let parent = node.index();
            node.children().map(move |child| (child.index(), parent)).collect::<Vec<_>>()
        });
        let parent_of: std::collections::BTreeMap<usize, usize> = parents.collect();
        let mut node = self.document.nodes().find(|node| node.name() == Some(name) && node.mesh().is_some()).unwrap();
        let mut place = self.local(&node, key);
        while let Some(&parent) = parent_of.get(&node.index()) {
            node = self.document.nodes().nth(parent).unwrap();
            place = self.local(&node, key) * place;
        }
        place
    }

    fn local(&self, node: &gltf::Node, key: usize) -> Matrix4<f64> {
        use gltf::animation::util::ReadOutputs;
        let (mut shift, mut turn, mut scale) = node.transform().decomposed();
        for channel in self.document.animations().flat_map(|animation| animation.channels().collect::<Vec<_>>()) {
            if channel.target().node().index() != node.index() {
                continue;
            }
            let reader = channel.reader(|_| Some(&self.bytes));
            match reader.read_outputs().unwrap() {
                ReadOutputs::Translations(mut values) => shift = values.nth(key).unwrap(),
                ReadOutputs::Rotations(values) => turn = values.into_f32().nth(key).unwrap(),
                ReadOutputs::Scales(mut values) => scale = values.nth(key).unwrap(),
                ReadOutputs::MorphTargetWeights(_) => unreachable!("nothing morphs"),
            }
        }
        let [i, j, k, w] = turn.map(f64::from);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        let rigid = Isometry3::from_parts(Translation3::from(shift.map(f64::from)), rotation);
        rigid.to_homogeneous() * Matrix4::new_nonuniform_scaling(&scale.map(f64::from).into())
    }

    fn times(&self) -> Vec<f32> {
        let animation = self.document.animations().next().unwrap();
        let channel = animation.channels().next().unwrap();
        channel.reader(|_| Some(&self.bytes)).read_inputs().unwrap().collect()
    }
}

#[test]
fn another_reader_sees_the_machine_move_as_we_do() {
    for name in ["trunnion-impeller", "robot-cell"] {
        let scene = Scene::find(name).unwrap();
        let run = scene.program.as_ref().unwrap();
        let glb = Glb::read(&glb::export(&scene, Some(run)).unwrap());
        let path = ToolPath::new(&scene, run).unwrap();
        let times = glb.times();
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{name}");
        assert!((f64::from(*times.last().unwrap()) - path.duration_s()).abs() < 1e-3);
        // The first key, the last, and the corners of a part there.
        for (key, place) in [(0, 0), (times.len() - 1, path.samples().len())] {
            let poses = scene.machine.forward(&path.position(place));
            for (index, part) in scene.parts.iter().enumerate() {
                if part.tool.is_some_and(|own| own != path.tool(place)) {
                    continue;
                }
                let world = glb.world_from_part(&part.name, key);
                for corner in part.mesh.vertices().iter().step_by(997) {
                    let ours = scene.world_from_part(index, &poses) * corner;
                    // Up along y, metres.
                    let expected = Point3::new(ours.x, ours.z, -ours.y) * 1e-3;
                    let seen = world.transform_point(corner);
                    assert!((seen - expected).norm() < 2e-6, "{name} {}: {seen} but {expected}", part.name);
                }
            }
        }
        // The surfaces, too.
        let mesh = glb.document.meshes().find(|mesh| mesh.name() == Some(&scene.parts[0].name)).unwrap();
        let primitive = mesh.primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(&glb.bytes));
        let ours = &scene.parts[0].mesh;
        assert_eq!(reader.read_positions().unwrap().len(), ours.vertices().len());
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, ours.faces().as_flattened());
    }
}

#[test]
fn the_command_writes_glb_into_a_folder_or_a_file() {
    let folder = folder();
    let glb = &["--format", "glb"][..];
    for (format, out, file) in [
        (glb, "some/where", "some/where/hammer.glb"),
        (glb, "x/y.glb", "x/y.glb"),
        (&[], "by/ending.glb", "by/ending.glb"),
    ] {
        let scene = folder.path("hammer");
        std::fs::create_dir_all(&scene).unwrap();
        for name in ["scene.toml", "blow.ngc"] {
            std::fs::copy(folder.path(name), scene.join(name)).unwrap();
        }
        folder.done(&[&["scene", "export", "hammer", "--out", out][..], format].concat());
        let glb = Glb::read(&std::fs::read(folder.path(file)).unwrap());
        // The hammer ends 1 mm and 2 mm off the axis at X0: in metres, up along y.
        let seen = glb.world_from_part("hammer", glb.times().len() - 1).transform_point(&Point3::origin());
        assert!((seen - Point3::new(0.0, 2e-3, -1e-3)).norm() < 1e-9, "{seen}");
    }
    let message = folder.refused(&["scene", "export", "hammer", "--format", "stl", "--out", "parts.glb"]);
    assert!(message.contains("name a folder") && !folder.path("parts.glb").exists(), "{message}");
}
