//! `check` as a command: what it prints and writes, its options and exit codes.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

#[path = "support/mill.rs"]
mod mill;
mod support;

use bvbench::scene::Scene;
use mill::*;
use serde_json::Value;
use std::path::Path;
use support::{Folder, run_own, with_zones};

/// Runs `check --quiet` on the scene of a folder: exit code, what is printed, what is told beside it.
fn check(folder: &Folder, arguments: &[&str]) -> (Option<i32>, String, String) {
    folder.told(&[&["check", "--quiet", "."], arguments].concat())
}

fn check_json(folder: &Folder, arguments: &[&str]) -> (Option<i32>, Value) {
    let (code, shown, told) = check(folder, &[&["--json"], arguments].concat());
    (code, serde_json::from_str(&shown).unwrap_or_else(|_| panic!("{told}")))
}

/// Both shipped programs are what `path` writes, byte for byte.
#[test]
fn the_programs_over_the_free_form_part_are_those_that_path_writes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("bench-scenes/freeform-5axis");
    for (file, flaws) in [("clean.ngc", &[][..]), ("program.ngc", &["--gouge", "0.05@0.3", "--lean", "66@0.53"])] {
        let path = ["program", "path", "freeform-5axis", "--rows", "8", "--step", "1.2", "--lead", "5", "--tilt", "3"];
        let written = Folder::with(&[]).done(&[&path[..], flaws].concat());
        assert_eq!(written, std::fs::read_to_string(folder.join(file)).unwrap(), "{file}");
    }
}

#[test]
fn allowed_contact_is_no_collision() {
    let program = "G0 Z5\nG1 X70 F100\nG0 Z50\nM2";
    let text = format!("{MILL}allow = [[\"cutter\", \"clamp\"]]\n");
    assert_eq!((told(program).len(), told_by(&text, program).len()), (1, 0));
    let (_, shown, _) = folder_of(&text, program).told(&["scene", "pairs", "."]);
    assert!(shown.lines().any(|line| line.contains("clamp:cutter") && line.contains("may touch")), "{shown}");
}

/// The walls of a prism around z, without its ends.
fn walls(outline: &[[f64; 2]], [low, high]: [f64; 2]) -> String {
    let mut text = String::from("solid walls\n");
    for (k, p) in outline.iter().enumerate() {
        let q = outline[(k + 1) % outline.len()];
        for corners in [[(*p, low), (q, low), (q, high)], [(*p, low), (q, high), (*p, high)]] {
            text += "facet normal 0 0 0\nouter loop\n";
            corners.iter().for_each(|([x, y], z)| text += &format!("vertex {x} {y} {z}\n"));
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid walls\n"
}

/// What `check` tells of a mill one of whose shapes is an open mesh: text, and code of exit.
fn told_of_open(text: &str, shape: &str, stl: &str, program: &str) -> (Vec<(&'static str, u32)>, String, Option<i32>) {
    assert_eq!(text.matches(shape).count(), 1, "{shape}");
    let folder = folder_of(&text.replace(shape, "mesh = \"open.stl\""), program);
    folder.write("open.stl", stl);
    let outcome = run_own(&Scene::load(folder.root()).unwrap(), &with_zones(&[]));
    let told = outcome.events.iter().map(|event| (event.kind.name(), event.first.line)).collect();
    let (code, shown, _) = check(&folder, &[]);
    (told, shown, code)
}

#[test]
fn what_open_meshes_cut_is_unresolved_and_never_clear() {
    let around: Vec<[f64; 2]> =
        (0..24).map(|k| f64::from(k) * std::f64::consts::TAU / 24.0).map(|a| [5.0 * a.cos(), 5.0 * a.sin()]).collect();
    let cutter = "shape = { kind = \"cylinder\", radius_mm = 5, height_mm = 30 }";
    let block = "shape = { kind = \"rounded-box\", size_mm = [100, 100, 20], fillet_mm = 1 }";
    let tube = walls(&around, [0.0, 30.0]);
    let square = walls(&[[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]], [-10.0, 10.0]);
    let through = "M3 S1000 G0 X-60\nG0 Z-10\nG1 X-30 F500\nG0 X40\nG0 Z50\nM2";
    let beside = "M3 S1000 G0 X-60\nG0 Z-10\nG0 X-70\nG0 Z50\nM2";
    for (shape, stl, name, line) in [(cutter, &tube, "cutter", 4), (block, &square, "block", 3)] {
        let (told, shown, code) = told_of_open(MILL, shape, stl, through);
        assert!(told.contains(&("unresolved", line)) && code == Some(1), "{name}: {told:?}\n{shown}");
        assert!(shown.contains("UNRESOLVED") && shown.contains("not watertight"), "{name}: {shown}");
        let (told, shown, code) = told_of_open(MILL, shape, stl, beside);
        assert!(told.is_empty() && code == Some(0), "{name}: {told:?}\n{shown}");
        let what = if name == "cutter" { "what `cutter` cuts" } else { "what is cut away from `block`" };
        assert!(shown.contains(&format!("not examined: {what}")), "{name}: {shown}");
    }
    // A clamp without top and bottom, beside which the cutter goes down.
    let clamp = "shape = { kind = \"rounded-box\", size_mm = [20, 20, 40], fillet_mm = 1 }";
    let frame = walls(&[[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]], [-20.0, 20.0]);
    let (told, shown, code) = told_of_open(MILL, clamp, &frame, "G0 X90\nG0 Z0\nG0 Z50\nM2");
    assert!(told.is_empty() && code == Some(0), "{told:?}\n{shown}");
    assert!(shown.contains("not examined: what lies wholly inside `clamp`"), "{shown}");
    // An open shank is asked of the uncut block, which it meets at Z -10.
    let ring: Vec<[f64; 2]> = around.iter().map(|p| p.map(|x| 1.2 * x)).collect();
    let shank = "shape = { kind = \"cylinder\", radius_mm = 6, height_mm = 20 }";
    let (stl, program) = (walls(&ring, [0.0, 20.0]), "G0 Z5\nT3 M6\nM3 S1000 G1 Z-11 F100\nG0 Z50\nM2");
    assert_eq!(told_of_open(&mill_with_tools(), shank, &stl, program).0, [("collision", 3)]);
}

#[test]
fn a_workpiece_that_stays_whole_is_named() {
    let folder = folder_of(MILL, "M3 S1000 G0 X-60\nG0 Z-10\nG1 X-30 F500\nG0 X40\nG0 Z50\nM2");
    let (code, shown, _) = check(&folder, &["--stock-resolution", "none"]);
    assert!(
        code == Some(0) && shown.contains("nothing collides, but rapids through the workpiece are not examined"),
        "{shown}"
    );
    let (code, shown, _) = check(&folder, &[]);
    assert!(code == Some(1) && shown.contains("`block` is cut: contact is told from a depth of 0.1 mm on"), "{shown}");
}

#[test]
fn what_is_left_is_written_and_compared_with_the_wanted_part() {
    let folder = folder_of(MILL, "M3 S1000 G0 X-60\nG0 Z-5\nG1 X40 F500\nG0 Z50\nM2");
    let (code, text, error) = check(&folder, &["--stock-resolution", "0.5", "--stock-out", "left.stl"]);
    assert_eq!(code, Some(0), "{text}{error}");
    assert!(text.contains("all that may be left of `block`"), "{text}");
    let mesh = bvbench::geometry::import::load(&folder.path("left.stl"), None).unwrap().mesh;
    assert!(mesh.edge_report().is_watertight());
    // A block of 100 x 100 x 20 with edges of 1 mm less a slot of 10 x 5, 90 long and half round at its end.
    let volume = 200_000.0 - 50.0 * 90.0 - 5.0 * 0.5 * std::f64::consts::PI * 25.0;
    assert!(mesh.signed_volume() > volume - 400.0 && mesh.signed_volume() < volume * 1.04, "{}", mesh.signed_volume());
    // What may be left, as the part that is wanted: no certain gouge, no rest. The uncut block as the wanted part: a gouge 5 mm deep.
    let beside = |target: &str| check_json(&folder, &["--stock-resolution", "0.5", "--target", target]);
    folder.done(&["scene", "export", ".", "--out", "parts"]);
    let (code, uncut) = beside("left.stl");
    let target = &uncut["stock"]["workpieces"][0]["target"];
    assert_eq!((code, &target["gouge"]["greatest_mm"]), (Some(1), &0.0.into()), "{target}");
    assert!((0.5..1.0).contains(&target["gouge"]["at_most_mm"].as_f64().unwrap()), "{target}");
    assert_eq!(target["rest"]["at_most_mm"], 0.0, "{target}");
    // The exported block is where the machine has it at first: 10 mm under the frame of its mesh.
    let block = bvbench::geometry::import::load(&folder.path("parts/block.stl"), None).unwrap().mesh;
    let raised = block.triangles().into_iter().map(|t| t.map(|p| p + nalgebra::Vector3::new(0.0, 0.0, 10.0)));
    let raised: Vec<_> = raised.collect();
    for (unit_mm, unit) in [(1.0, ""), (25.4, ":inch")] {
        let text = raised.iter().map(|t| {
            let vertices = t.corners.map(|p| p / unit_mm).map(|p| format!("vertex {} {} {}\n", p.x, p.y, p.z)).concat();
            format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        });
        folder.write("block.stl", &format!("solid block\n{}endsolid block\n", text.collect::<String>()));
        let (code, gouged) = beside(&format!("block.stl{unit}"));
        let gouge = &gouged["stock"]["workpieces"][0]["target"]["gouge"];
        let (depth, volume) = (gouge["greatest_mm"].as_f64().unwrap(), gouge["volume_mm3"].as_f64().unwrap());
        assert!(code == Some(1) && gouged["clear"] == false, "{unit}: {gouged}");
        assert!((4.0..=5.01).contains(&depth) && (3000.0..=4800.0).contains(&volume), "{unit}: {gouge}");
    }
    let (code, _, error) = check(&folder, &["--target", "no.stl"]);
    assert!(code == Some(2) && error.contains("--target"), "{error}");
    let (code, _, error) = check(&folder, &["--stock-resolution", "0"]);
    assert!(code == Some(2) && error.contains("--stock-resolution"), "{error}");
}

#[test]
fn an_answer_that_is_not_decided_to_the_last_tenth_says_so() {
    let folder = folder_of(MILL, "G0 X-60\nG0 Z5\nG0 X0\nG0 Z0\nG0 Z50\nM2");
    let (code, shown, _) = check(&folder, &[]);
    assert_eq!(code, Some(0), "{shown}");
    assert!(shown.contains("nothing collides, but for what may touch the stock by at most 0.0"), "{shown}");
    assert!(shown.contains("not decided: whether block:cutter touch in"), "{shown}");
    let (_, json) = check_json(&folder, &[]);
    let touch = &json["stock"]["touches"][0];
    assert!(touch["at_most_mm"].as_f64().unwrap() <= 0.1 && touch["line"] == 4, "{json}");
}

#[test]
fn an_axis_beyond_its_limits_hides_no_collision() {
    // Z goes to 260 of 200 on line 4, X to 300 and -300 of 200; the clamp is hit on lines 1 and 6.
    let program = "M3 S1000 G0 X70 Z0\nG0 Z50\nG0 X0\nZ260\nX300 Z50\nG1 X70 Z0 F1000\nX-300\nM2";
    let outcome = outcome_of(MILL, program);
    let over: Vec<_> = outcome.over_travel.iter().map(|over| (over.line, over.cause.axis, over.cause.value)).collect();
    assert_eq!(over, [(4, 'Z', 260.0), (5, 'X', 300.0), (7, 'X', -300.0)]);
    assert_eq!(outcome.events.iter().map(|event| event.first.line).collect::<Vec<_>>(), [1, 6]);
    let (code, shown, _) = check(&folder_of(MILL, program), &[]);
    assert_eq!(code, Some(1));
    assert!(
        shown.contains("OVER-TRAVEL") && shown.contains("axis Z at 260 mm is outside its limits -50 to 200 mm"),
        "{shown}"
    );
    // Over-travel alone is not clear either.
    let folder = folder_of(MILL, "G0 Z260\nM2");
    let (code, json) = check_json(&folder, &[]);
    assert_eq!((code, &json["clear"], &json["collides"]), (Some(1), &false.into(), &false.into()));
    assert_eq!(json["over_travel"][0]["line"], 1);
    let (_, csv, _) = check(&folder, &["--csv"]);
    assert!(csv.lines().nth(1).unwrap().starts_with("over-travel,,Z,,1,"), "{csv}");
}

#[test]
fn what_is_written_never_replaces_what_is_read() {
    let folder = folder_of(MILL, "G0 Z20\nM2");
    folder.write("other.ngc", "G0 Z10\nM2\n");
    folder.write("shop.toml", "");
    folder.write("blank.stl", "");
    std::fs::create_dir(folder.path("folder.png")).unwrap();
    let before = |name: &str| std::fs::read(folder.path(name)).ok();
    let refused = |verb: &[&str], option: &str, name: &str| {
        let [scene, file] = [folder.root(), &folder.path(name)].map(|path| path.to_str().unwrap().to_owned());
        folder.refused(&[verb, &[&scene, option, &file]].concat())
    };
    for (verb, option, name) in [
        (&["check", "--quiet"][..], "--stock-out", "blank.stl"),
        (&["check", "--quiet"], "--sarif", "shop.toml"),
        (&["check", "--quiet"], "--junit", "scene.toml"),
        (&["view", "--quiet"], "--out", "other.ngc"),
        (&["scene", "picture"], "--out", "scene.toml"),
        (&["scene", "picture"], "--out", "folder.png"),
        (&["program", "path"], "--out", "scene.toml"),
        (&["program", "path"], "--out", "own.ngc"),
    ] {
        let content = before(name);
        let error = refused(verb, option, name);
        assert!(error.contains(option) && error.contains(name), "{option} {name}: {error}");
        assert_eq!(before(name), content, "{option} {name}");
    }
    for (verb, option, name, ending) in
        [(&["check"][..], "--stock-out", "left.obj", ".stl"), (&["scene", "picture"], "--out", "picture.jpg", ".png")]
    {
        let error = refused(verb, option, name);
        assert!(error.contains(&format!("ends with {ending}")), "{name}: {error}");
        assert!(!folder.path(name).exists(), "{name}");
    }
    // Reports of an earlier run are replaced.
    for _ in 0..2 {
        assert_eq!(check(&folder, &["--sarif", "own.sarif"]).0, Some(0));
    }
}

#[test]
fn what_a_scene_reads_elsewhere_is_not_replaced() {
    let tetrahedron = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|face: [usize; 3]| {
        let corner = |v: usize| ["0 0 0", "9 0 0", "0 9 0", "0 0 9"][v];
        let vertices = face.map(|v| format!("vertex {}\n", corner(v))).concat();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    });
    let stl = format!("solid clamp\n{}endsolid clamp\n", tetrahedron.concat());
    let clamp = "shape = { kind = \"rounded-box\", size_mm = [20, 20, 40], fillet_mm = 1 }";
    let block = "shape = { kind = \"rounded-box\", size_mm = [100, 100, 20], fillet_mm = 1 }";
    let text = MILL.replace(clamp, "mesh = \"../clamp.stl\"").replace(block, "mesh = \"meshes/block.stl\"");
    let folder = Folder::with(&[
        ("clamp.stl", stl.as_str()),
        ("scene/meshes/block.stl", &stl),
        ("scene/scene.toml", &text),
        ("scene/own.ngc", "G0 Z20\nM2"),
    ]);
    let path = |name: &str| folder.path(name).to_str().unwrap().to_owned();
    let refused = |verb: &[&str], out: &str| folder.refused(&[verb, &[&path(out)]].concat());
    let scene = path("scene");
    for (verb, out) in [
        (&["check", "--quiet", &scene, "--stock-out"][..], "clamp.stl"),
        (&["check", "--quiet", &scene, "--sarif"], "clamp.stl"),
        (&["view", "--quiet", &scene, "--out"], "clamp.stl"),
        (&["scene", "picture", &scene, "--out"], "clamp.stl"),
        (&["scene", "export", &scene, "--out"], "."),
        (&["scene", "export", &scene, "--out"], "scene/meshes"),
    ] {
        let error = refused(verb, out);
        assert!(error.contains("would replace what is read"), "{verb:?}: {error}");
        for file in ["clamp.stl", "scene/meshes/block.stl"] {
            assert_eq!(std::fs::read_to_string(path(file)).unwrap(), stl, "{verb:?}");
        }
    }
    for file in ["cutter.stl", "scene/meshes/cutter.stl"] {
        assert!(!folder.path(file).exists(), "nothing is written");
    }
    // Subroutines in files, of a program and of one that is wrong; stock and a target whose names have `@` and `:`.
    let subroutine = "o<sub> sub\nG0 Z30\no<sub> endsub\nM2\n";
    let texts = [
        ("job/sub.ngc", subroutine),
        ("job/main.ngc", "o<sub> call\nG0 Z20\nM2\n"),
        ("job/wrong.ngc", "o<sub> call\nG77\nM2\n"),
        ("job/a@b:c.stl", stl.as_str()),
    ];
    for (name, text) in texts {
        folder.write(name, text);
    }
    let [main, wrong, mesh] = ["job/main.ngc", "job/wrong.ngc", "job/a@b:c.stl"].map(path);
    let stock = format!("{mesh}:mm@0,0,-9");
    for (verb, out, told) in [
        (&["check", "--quiet", &scene, &main, "--sarif"][..], "job/sub.ngc", "would replace what is read"),
        (&["view", "--quiet", &scene, &main, "--out"], "job/sub.ngc", "would replace what is read"),
        (&["check", "--quiet", &scene, &wrong, "--junit"], "job/sub.ngc", "wrong.ngc:2"),
        (
            &["check", "--quiet", &scene, "--stock", &stock, "--stock-out"],
            "job/a@b:c.stl",
            "would replace what is read",
        ),
        (
            &["check", "--quiet", &scene, "--target", &mesh, "--sarif"],
            "job/../job/a@b:c.stl",
            "would replace what is read",
        ),
    ] {
        let error = refused(verb, out);
        assert!(error.contains(told), "{verb:?}: {error}");
        for (name, text) in texts {
            assert_eq!(std::fs::read_to_string(path(name)).unwrap(), text, "{verb:?}");
        }
    }
    // Two parts, one file.
    let text = text.replace("\"clamp\"", "\"a/b\"").replace("\"cutter\", l", "\"a-b\", l");
    folder.write("scene/scene.toml", &text);
    let error = refused(&["scene", "export", &scene, "--out"], "out");
    assert!(error.contains("parts `a/b` and `a-b` would both"), "{error}");
}

#[test]
fn formats_and_exit_codes() {
    assert_eq!(check(&folder_of(MILL, "G0 Z20\nM2"), &[]).0, Some(0));
    let folder = folder_of(MILL, "G21 G0 Z5\nG0 Z-2\nG0 Z50\nG0 X70\nG0 Z0\nM2");
    let run = |arguments: &[&str]| {
        let (code, shown, _) = check(&folder, arguments);
        assert_eq!(code, Some(1), "{arguments:?}");
        shown
    };
    let json: Value = serde_json::from_str(&run(&["--json"])).unwrap();
    assert_eq!((&json["collides"], &json["notes"]), (&true.into(), &serde_json::json!([])));
    assert_eq!(json["events"].as_array().unwrap().iter().filter(|e| e["kind"] != "near").count(), 2);
    let first: Value = serde_json::from_str(&run(&["--json", "--first", "--clearance", "0"])).unwrap();
    assert_eq!(first["events"].as_array().unwrap().len(), 1);
    assert_eq!(first["events"][0]["block"], "G0 Z-2");
    let csv = run(&["--csv", "--clearance", "0"]);
    assert_eq!(csv.lines().count(), 3);
    assert!(csv.starts_with("kind,zone_mm,a,b,first_line"), "{csv}");
    let shown = run(&[]);
    let is_path = |line: &str| line.contains("own.ngc");
    assert!(shown.lines().all(|line| is_path(line) || line.chars().count() <= 100), "{shown}");
    assert!(csv.lines().next().unwrap().contains(",inside,to_the_end,"), "{csv}");
    // One thread or two: the same bytes.
    assert_eq!(run(&["--csv", "--threads", "1"]), run(&["--csv", "--threads", "2"]));
}

#[test]
fn a_program_that_looks_like_another_controls_is_named_unless_a_dialect_is() {
    let program = "%\nO0001 (VISE PART)\nG21 G0 Z20.\nM30\n%";
    let run = |text: &str, arguments: &[&str]| {
        let (code, shown, told) = check(&folder_of(text, program), arguments);
        assert_eq!(code, Some(0), "{shown}{told}");
        shown
    };
    let of_scene = MILL.replacen("file = \"own.ngc\"\n", "file = \"own.ngc\"\ndialect = \"haas\"\n", 1);
    let note = "not examined: line 2: the program looks as if it were written for a Fanuc or Haas control (O0001)";
    for (text, arguments, dialect, is_noted) in [
        (MILL, &[][..], "linuxcnc", true),
        (MILL, &["--dialect", "linuxcnc"], "linuxcnc", false),
        (MILL, &["--dialect", "haas"], "haas", false),
        (of_scene.as_str(), &[], "haas", false),
    ] {
        let shown = run(text, arguments);
        let is_right = shown.contains(note) == is_noted && shown.contains(&format!(", read as {dialect}: nothing"));
        assert!(is_right, "{arguments:?}: {shown}");
        let json: Value = serde_json::from_str(&run(text, &[arguments, &["--json"]].concat())).unwrap();
        assert_eq!(json["dialect"], dialect);
        let notes = json["notes"].as_array().unwrap();
        assert_eq!(notes.iter().filter(|note| note["not_examined"] == true).count(), usize::from(is_noted), "{json}");
    }
}

#[test]
fn clearances_hold_for_pairs_and_roles() {
    // The cutter passes 6 mm over the clamp, which is a part of the machine.
    let program = "G0 Z26\nG0 X70\nG0 X0\nM2";
    let zones = |text: &str, asked: &[&str]| {
        let asked: Vec<&str> = asked.iter().flat_map(|asked| ["--clearance", asked]).collect();
        let (code, json) = check_json(&folder_of(text, program), &asked);
        assert_eq!(code, Some(0));
        let events = json["events"].as_array().unwrap();
        events.iter().map(|event| event["zone_mm"].as_f64().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(zones(MILL, &[]), [14.0, 8.0]);
    assert_eq!(zones(MILL, &["5"]), [0.0; 0]);
    assert_eq!(zones(MILL, &["5", "clamp:cutter=7"]), [7.0]);
    assert_eq!(zones(MILL, &["machine=9", "machine=20", "20"]), [20.0, 9.0]);
    assert_eq!(zones(MILL, &["holder=9"]), [14.0, 8.0]);
    assert_eq!(zones(MILL, &["cutter=0"]), [0.0; 0]);
    let own = MILL.replacen("[check]\n", "[check]\nclearance = [\"0\", \"cutter:machine=7\"]\n", 1);
    assert_eq!(zones(&own, &[]), [7.0]);
    assert_eq!(zones(&own, &["5"]), [0.0; 0]);
}

#[test]
fn a_clearance_of_nothing_is_refused_with_its_place() {
    let folder = folder_of(MILL, "G0 Z20\nM2");
    for (asked, part) in [("holdr=5", "no part and no role `holdr`"), ("-1", "from 0"), ("clamp=x", "`x` is no number")]
    {
        let told = folder.refused(&["check", "--quiet", ".", &format!("--clearance={asked}")]);
        assert!(told.contains(part) && told.contains("--clearance"), "{told}");
    }
    let text = MILL.replacen("[check]\n", "[check]\nclearance = [\"5\", \"clamb=2\"]\n", 1);
    folder.write("scene.toml", &text);
    let told = folder.refused(&["check", "--quiet", "."]);
    assert!(told.contains("scene.toml:16") && told.contains("`clamb`") && told.contains("clamp"), "{told}");
}

#[test]
fn a_machine_changes_tools_where_it_says() {
    // Tool 2 is 20 mm longer: changed at Z 10 it is in the block. The machine goes up to Z 150 first, Z before X, and comes back on line 3.
    let program = "G0 X70 Z25\nG0 X-60\nT2 M6\nG0 X0 Z30\nM2";
    let text = mill_with_tools();
    let changes = text.replacen("[program]\n", "[program]\ntool_change = { Z = 150, X = -150 }\n", 1);
    assert_eq!(told_by(&text, "G0 Z10\nT2 M6\nG0 Z50\nM2"), [("tool-change-into-workpiece", 2)]);
    assert_eq!(told_by(&changes, "G0 Z10\nT2 M6\nG0 Z50\nM2"), []);
    let moves = scene_of(&changes, program).program.unwrap().program.moves;
    let moves: Vec<_> = moves.iter().map(|m| (m.line, m.kind.name(), m.end)).collect();
    let at = |x: f64, z: f64| rs274::Position([x, 0.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let wanted = [
        (1, "rapid", at(70.0, 25.0)),
        (2, "rapid", at(-60.0, 25.0)),
        (3, "rapid", at(-60.0, 150.0)),
        (3, "rapid", at(-150.0, 150.0)),
        (3, "tool", at(-150.0, 150.0)),
        (4, "rapid", at(0.0, 30.0)),
    ];
    assert_eq!(moves, wanted);
    let wrong = text.replacen("[program]\n", "[program]\ntool_change = { Q = 1 }\n", 1);
    let (_, _, told) = check(&folder_of(&wrong, program), &[]);
    assert!(told.contains("tool_change: `Q` is not an axis"), "{told}");
}

#[test]
fn another_program_runs_though_the_scenes_own_is_missing_and_offsets_and_tools_come_from_the_command_line() {
    let folder = Folder::with(&[("scene.toml", MILL), ("other.ngc", "G0 X0 Z-25\nM2")]);
    let program = "other.ngc";
    assert_eq!(check(&folder, &[program]).0, Some(1));
    assert_eq!(check(&folder, &[]).0, Some(2));
    // 50 mm higher all is clear; so it is with a tool of 50 mm.
    assert_eq!(check(&folder, &[program, "--offset", "G54=0,0,50"]).0, Some(0));
    folder.write(program, "G43 H7 G0 X0 Z-25\nM2");
    let (code, _, error) = check(&folder, &[program]);
    assert!(code == Some(2) && error.contains("--tool-table"), "{error}");
    folder.write("mill.tbl", "T7 P7 Z50 D10\n");
    assert_eq!(check(&folder, &[program, "--tool-table", "mill.tbl"]).0, Some(0));
    for (offset, message) in [
        ("G54", "must be like"),
        ("G60=1,2,3", "is not one of"),
        ("G54=1,2", "2 numbers"),
        ("G54=1,2,inf", "not finite"),
    ] {
        let (code, _, error) = check(&folder, &[program, "--offset", offset]);
        assert!(code == Some(2) && error.contains(message), "{offset}: {error}");
    }
}

#[test]
fn near_misses_are_one_line_for_each_pair() {
    // Three times 1 mm over the clamp, within all three zones; then into it.
    let program = "G0 Z21\nG0 X70\nG0 X0\nG0 X70\nG0 X140\nG0 Z15\nG0 X70\nM2";
    let (_, shown, _) = check(&folder_of(MILL, program), &[]);
    let lines: Vec<&str> = shown.lines().filter(|line| line.trim_start().starts_with("clamp:cutter")).collect();
    assert!(shown.contains("NEAR MISSES") && lines.len() == 2, "{shown}");
    assert!(lines[1].contains("1.000") && lines[1].split_whitespace().nth(1) == Some("2"), "{shown}");
    // No table without a row: what is near here leads to the collision.
    let (_, shown, _) = check(&folder_of(MILL, "G0 X140\nG0 Z15\nG0 X70\nM2"), &[]);
    assert!(shown.contains("COLLISION") && !shown.contains("NEAR MISSES"), "{shown}");
}

#[test]
fn a_certificate_tells_the_first_touch_of_a_line_once() {
    // Pecks of one line into the clamp, up to Z20: the later ones begin in contact.
    let folder = folder_of(MILL, "G0 X70\nG98 G73 Z10 R25 Q4 F100\nM2");
    let (_, shown, _) = check(&folder, &["--certify", "a.cert"]);
    let lines: Vec<&str> = shown.lines().filter(|line| line.starts_with("proved: line 2, move ")).collect();
    let later = lines.iter().filter(|line| line.ends_with("in contact from the beginning of the move on")).count();
    assert!(lines.len() > 2 && lines[0].contains("first touch") && later == lines.len() - 1, "{shown}");
    let moves: std::collections::BTreeSet<&str> = lines.iter().filter_map(|line| line.split(':').nth(1)).collect();
    assert_eq!(moves.len(), lines.len(), "{shown}");
}

#[test]
fn lines_with_a_slash_are_skipped_when_asked() {
    let folder = folder_of(MILL, "G0 Z20\n/G0 Z-2\nM2");
    folder.write("other.ngc", "/G0 Z-2\nG0 Z20\nM2");
    for (arguments, code) in
        [(&[][..], 1), (&["--block-delete"], 0), (&["other.ngc"], 1), (&["other.ngc", "--block-delete"], 0)]
    {
        assert_eq!(check(&folder, arguments).0, Some(code), "{arguments:?}");
    }
}

#[test]
fn x_words_of_a_lathe_are_what_its_control_begins_with() {
    for (dialect, program, meets) in [
        ("linuxcnc", "G21 G0 Z5\nG0 X70\nM2", true),
        ("linuxcnc", "G21 G7 G0 Z5\nG0 X70\nM2", false),
        ("grbl", "G21 G0 Z5\nG0 X70\nM2", true),
        ("fanuc", "G21 G0 Z5.\nG0 X70.\nM30", false),
        ("haas", "G21 G0 Z5.\nG0 X70.\nM30", false),
    ] {
        let control = format!("[program]\ncontroller = \"lathe\"\ndialect = \"{dialect}\"\n");
        let told = told_by(&MILL.replacen("[program]\n", &control, 1), program);
        assert_eq!(!told.is_empty(), meets, "{dialect} {program}: {told:?}");
    }
}

#[test]
fn a_program_without_a_unit_is_read_as_mm_with_a_note_or_as_asked() {
    // The clamp is from X60 to X80, up to Z20: 2.7 inches are 68.6 mm, 0.2 inches are 5.1 mm.
    let program = "G90 G0 Z0.2\nG0 X2.7\nM2";
    let scene = MILL.replacen("[program]\n", "[program]\nunits = \"inch\"\n", 1);
    for (text, options, code, is_told) in [
        (MILL, &[][..], 0, true),
        (MILL, &["--units", "mm"], 0, false),
        (MILL, &["--units", "inch"], 1, false),
        (scene.as_str(), &[], 1, false),
        (scene.as_str(), &["--units", "mm"], 0, false),
    ] {
        let (found, _, told) = check(&folder_of(text, program), &[&["--clearance", "0"], options].concat());
        assert_eq!((found, told.contains("read as mm")), (Some(code), is_told), "{options:?}: {told}");
    }
}

#[test]
fn a_variable_is_set_before_the_program() {
    let folder = folder_of(MILL, "G0 Z20\nG0 Z#510\nM2");
    for (options, code) in
        [(&[][..], 2), (&["--variable", "510=20"], 0), (&["--variable", "510=-2"], 1), (&["--variable", "5221=20"], 2)]
    {
        assert_eq!(check(&folder, &[&["--dialect", "fanuc"], options].concat()).0, Some(code), "{options:?}");
    }
}

#[test]
fn what_a_program_leaves_unknown_is_named() {
    for (program, dialect, told) in [
        ("G0 Z20\nM60\nG0 Z30\nM2", "linuxcnc", "line 2: M60 changes the pallet"),
        ("G0 Z40\nG38.2 Z30 F100\nG0 Z40\nM2", "linuxcnc", "line 2: nothing stops a probe here"),
        ("G0 Z40.\nG31 Z30. F100.\nG0 Z40.\nM30", "haas", "line 2: nothing stops a probe here"),
    ] {
        let folder = folder_of(MILL, program);
        let (code, shown, error) =
            check(&folder, &["--dialect", dialect, "--sarif", "out.sarif", "--junit", "out.xml"]);
        assert_eq!(code, Some(0), "{program}: {error}");
        assert!(shown.contains(&format!("not examined: {told}")), "{program}: {shown}");
        for report in ["out.sarif", "out.xml"] {
            let text = std::fs::read_to_string(folder.path(report)).unwrap();
            assert!(text.contains(told), "{program}: {text}");
        }
    }
}

#[test]
fn a_tool_without_parts_is_named_beside_the_csv() {
    let folder = folder_of(&mill_with_tools(), "T8 M6\nG0 Z40\nM2");
    let (code, rows, told) = check(&folder, &["--csv"]);
    assert_eq!((code, rows.lines().count()), (Some(1), 2), "{rows}");
    assert!(rows.contains("\ntool-without-part,,tool 8,,1,"), "{rows}");
    assert!(told.contains("not examined: tool 8"), "{told}");
}

#[test]
fn bad_input_ends_with_2_and_names_the_place() {
    let folder = folder_of(MILL, "G0 Z20\nM2");
    let refused = |program: &str, message: &str| {
        folder.write("bad.ngc", program);
        let error = folder.refused(&["check", "--quiet", ".", "bad.ngc"]);
        assert!(error.contains(message), "{error}");
    };
    refused(
        "G0 X1\nG77\nM2",
        "bad.ngc:2:1: code is not supported; if it moves nothing, ignore it (`--ignore G77`): `G77`",
    );
    refused("M2", "no moves");
    refused("G0 X1\nA90\nM2", "bad.ngc:2: the program moves axis A to 90 degrees, and no joint of the machine");
    refused("G0 X1\nG0 Z40 U-10\nM2", "bad.ngc:2: the program moves axis U to -10 mm");
    // A program or a mesh in the place of the scene.
    std::fs::write(folder.path("part.stl"), b"solid \xff").unwrap();
    for (verb, file) in [("check", "own.ngc"), ("view", "own.ngc"), ("try", "own.ngc"), ("check", "part.stl")] {
        let error = folder.refused(&[verb, file]);
        let told = format!("{file} is no scene: give a folder with scene.toml");
        assert!(error.contains(&told), "{verb} {file}: {error}");
    }
    folder.refused(&["check", "--quiet", "no-such-scene"]);
    for arguments in [&["no/such.ngc"][..], &["--method", "nothing"], &["--step", "0"]] {
        folder.refused(&[&["check", "--quiet", "."], arguments].concat());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_program_whose_name_is_not_unicode_is_checked() {
    use std::os::unix::ffi::OsStrExt;
    let folder = folder_of(MILL, "G0 Z20\nM2");
    let program = folder.root().join(std::ffi::OsStr::from_bytes(b"caf\xe9.ngc"));
    std::fs::write(&program, "G0 Z20\nM2").unwrap();
    let output = folder.command(&["check", "--quiet", "--json", "."]).arg(&program).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(json["program"].as_str().unwrap().ends_with("caf\u{fffd}.ngc"), "{json}");
}

#[test]
fn a_machine_whose_parts_are_all_neighbours_is_refused() {
    let [clamp, cutter] = ["clamp", "cutter"].map(|name| MILL.find(&format!("  {{ name = \"{name}\"")).unwrap());
    let table = ", joint = { axis = \"X\", direction = [-1, 0, 0], min_mm = -200, max_mm = 200 }";
    let text = [&MILL[..clamp], &MILL[cutter..]].concat().replacen(table, "", 1);
    let text = text.replace("role = \"workpiece\", ", "").replace("role = \"cutter\", ", "");
    let error = folder_of(&text, "G0 Z1\nM2").refused(&["check", "--quiet", "."]);
    assert!(error.contains("no two parts that could collide"), "{error}");
}

#[test]
fn scene_tells_what_it_holds_and_writes_its_meshes() {
    let folder = folder_of(MILL, "G0 Z20\nG0 X50\nM2");
    let text = |arguments: &[&str]| folder.done(&[&["scene"], arguments].concat());
    let info: Value = serde_json::from_str(&text(&["info", ".", "--json"])).unwrap();
    assert_eq!(info["parts"].as_array().unwrap().len(), 3);
    assert_eq!(info["links"][0]["joint"]["max"], 200.0);
    let pairs: Value = serde_json::from_str(&text(&["pairs", ".", "--json"])).unwrap();
    let kept = pairs.as_array().unwrap().iter().filter(|pair| pair["kept"] == true).count();
    assert_eq!((pairs.as_array().unwrap().len(), kept), (3, 2)); // block and clamp are rigid
    assert!(text(&["pairs", "."]).contains("no joint between them"));
    text(&["export", ".", "--out", "meshes"]);
    let stl = stl_io::read_stl(&mut std::fs::File::open(folder.path("meshes/clamp.stl")).unwrap()).unwrap();
    let x: Vec<f32> = stl.vertices.iter().map(|v| v[0]).collect();
    assert!((x.iter().copied().fold(f32::INFINITY, f32::min) - 60.0).abs() < 1e-3);
    assert!((x.iter().copied().fold(f32::NEG_INFINITY, f32::max) - 80.0).abs() < 1e-3);
}

#[test]
fn a_tool_vector_has_two_solutions() {
    let inverse =
        |arguments: &[&str]| Folder::with(&[]).told(&[&["scene", "inverse", "trunnion-impeller"], arguments].concat());
    // tan A = 3 / 4, towards x, which C turns to y and y is where A tilts: C 90 or -90.
    let (code, text, _) = inverse(&["--direction", "0.6,0,0.8", "--from", "A-5,C-60", "--json"]);
    assert_eq!(code, Some(0));
    let found: Value = serde_json::from_str(&text).unwrap();
    let axes = |name: &str| ["A", "C"].map(|axis| found[name]["position"][axis].as_f64().unwrap());
    assert_eq!((axes("chosen"), axes("other")), ([-36.869_898, -90.0], [36.869_898, 90.0]));
    assert!(found["other"]["forbidden"].as_str().unwrap().contains("axis A at 36.8"), "{text}");
    let (code, text, _) = inverse(&["--direction=0,0,1", "--from", "C12", "--tip", "10,0,60"]);
    assert_eq!(code, Some(0));
    assert!(text.contains("C does not matter") && !text.contains("other"), "{text}");
    for (arguments, message) in [
        (["--direction", "0,0,-1"].as_slice(), "both ways to tilt the tool leave the limits"),
        (&["--direction", "0,0,0"], "the direction has no length"),
        (&["--direction", "0,1"], "there must be three numbers"),
        (&["--direction", "0,1,1", "--from", "Q1"], "does not begin with one of X Y Z"),
    ] {
        let (code, _, error) = inverse(arguments);
        assert!(code == Some(2) && error.contains(message), "{code:?} {error}");
    }
}

#[test]
fn a_tool_vector_is_in_the_axes_of_the_program_however_the_machine_is_drawn() {
    // A horizontal mill with the spindle along Y of the drawing, over a table that turns about B on a trunnion that tilts about A.
    let scene = r#"
title = "A horizontal mill"
machine.links = [
  { name = "x", joint = { axis = "X", direction = [-1, 0, 0] } },
  { name = "trunnion", parent = "x", joint = { axis = "A", direction = [-1, 0, 0] } },
  { name = "table", parent = "trunnion", joint = { axis = "B", direction = [0, 0, -1] } },
  { name = "y", joint = { axis = "Y", direction = [0, 0, 1] } },
  { name = "head", parent = "y", joint = { axis = "Z", direction = [0, -1, 0] } },
]
parts = [
  { name = "cutter", link = "head", role = "cutter", shape = { kind = "sphere", radius_mm = 2 } },
  { name = "post", link = "table", role = "fixture", at = { xyz_mm = [0, 100, 0] }, shape = { kind = "sphere", radius_mm = 2 } },
]
[program]
file = "own.ngc"
[program.tool_centre_point]
tool_link = "head"
work_link = "table"
direction = [0, 1, 0]
"#;
    let folder = folder_of(scene, "M2");
    for (direction, tilt) in [("0,0,1", 0.0), ("0,-0.5,0.8660254037844386", 30.0)] {
        let text = folder.done(&["scene", "inverse", ".", "--direction", direction, "--json"]);
        let found: Value = serde_json::from_str(&text).unwrap();
        let angles = ["A", "B"].map(|axis| found["chosen"]["position"][axis].as_f64().unwrap());
        assert_eq!(angles, [tilt, 0.0], "{direction}");
    }
}
