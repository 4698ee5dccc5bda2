//! `check` from outside: the planted collisions of the shipped scenes and no others, agreement with the exact truth along
//! the path, the rule for cutting, and the command's formats and exit codes.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use assert_cmd::Command;
use bvbench::check::{Cutting, Event, Kind, Outcome, Path as ToolPath, Settings, check};
use bvbench::measure::Silent;
use bvbench::registry::{Registry, Variant};
use bvbench::scene::{Clearances, Pair, ProgramRun, Scene};
use bvbench::truth::PairOracle;
use std::path::Path;
use std::sync::Arc;

fn standard(registry: &Registry) -> &Variant {
    registry.fastest().unwrap()
}

fn run_own(scene: &Scene, settings: &Settings) -> Outcome {
    check(
        scene,
        scene.program.as_ref().unwrap(),
        standard(&Registry::standard()),
        &Registry::standard(),
        settings,
        &Silent,
    )
    .unwrap()
}

fn sorted(pair: Pair) -> [usize; 2] {
    [pair.a.min(pair.b), pair.a.max(pair.b)]
}

#[test]
fn shipped_scenes_have_their_planted_collisions_and_no_others() {
    // Of the size family the two that take no time; the others have the same shape.
    let families = ["size-1e3", "size-1e4", "grading-1", "grading-10", "grading-100"];
    for name in Scene::SHIPPED.iter().chain(&families) {
        let scene = Scene::find(name).unwrap();
        assert!(!scene.expected.is_empty(), "{name} says nothing of what to expect");
        let outcome = run_own(&scene, &Settings::standard());
        let collisions = outcome.events.iter().filter(|event| event.kind.is_collision());
        let found: Vec<_> = collisions.map(|event| (event.first.line, sorted(event.pair))).collect();
        let expected: Vec<_> = scene.expected.iter().map(|e| (e.line, sorted(e.pair))).collect();
        assert_eq!(found, expected, "{name}");
        // Contact begins in the zones, which begin in order of their width.
        for event in outcome.events.iter().filter(|event| event.kind == Kind::Collision) {
            let zones: Vec<f64> = outcome
                .events
                .iter()
                .filter(|near| near.pair == event.pair)
                .filter_map(|near| match near.kind {
                    Kind::Near { zone_mm }
                        if near.first.time_s <= event.first.time_s && near.last.time_s >= event.first.time_s =>
                    {
                        Some(zone_mm)
                    }
                    _ => None,
                })
                .collect();
            assert_eq!(zones, [14.0, 8.0, 2.0], "{name}");
            assert!(event.last.time_s > event.first.time_s && event.least_mm == 0.0);
        }
    }
}

/// Every sample of the path at which the exact truth sees contact lies in a contact that was found, and the other way round
/// but for the tolerance.
#[test]
fn contact_along_the_path_is_that_of_the_exact_truth() {
    let settings = Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() };
    for name in Scene::SHIPPED {
        let scene = Scene::find(name).unwrap();
        let path = ToolPath::new(&scene, scene.program.as_ref().unwrap()).unwrap();
        let outcome = run_own(&scene, &settings);
        // How deep a cutter gouges no two triangles tell; that has a test of its own.
        for expected in scene.expected.iter().filter(|expected| !scene.is_cutting(expected.pair)) {
            let pair = Pair { a: sorted(expected.pair)[0], b: sorted(expected.pair)[1] };
            let mesh = |part: usize| Arc::clone(&scene.parts[part].mesh);
            let oracle = PairOracle::new(mesh(pair.a), mesh(pair.b));
            let mut touching = 0;
            for place in 1..=path.samples().len() {
                let poses = scene.machine.forward(&path.position(place));
                let exact = oracle.touches(&scene.a_from_b(pair, &poses));
                let time = path.time_s(place as f64);
                let told = outcome
                    .events
                    .iter()
                    .any(|event| event.pair == pair && event.first.time_s <= time && time <= event.last.time_s);
                assert_eq!(told, exact, "{name}, sample {place}, line {}", path.samples()[place - 1].line);
                touching += u32::from(exact);
            }
            assert!(touching > 5, "{name}: {touching}");
        }
    }
}

/// The finished part of a five-axis scene: a gouge of 0.05 mm and a holder that touches, by boxes and by the octree method, which is asked
/// about the tool; and nothing on the program without the two.
#[test]
fn a_gouge_and_a_holder_are_found_on_their_lines_and_nothing_on_the_clean_program() {
    let registry = Registry::standard();
    let scene = Scene::find("freeform-5axis").unwrap();
    let flawed = scene.program.as_ref().unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("bench-scenes/freeform-5axis");
    let clean = flawed.with_program(&folder.join("clean.ngc")).unwrap();
    let settings = Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() };
    for variant in
        registry.variants().iter().filter(|v| v.info.safe && (v.is_reference || v.is_fastest || v.is_for_tools))
    {
        let outcome = check(&scene, flawed, variant, &registry, &settings, &Silent).unwrap();
        let found: Vec<_> = outcome.events.iter().map(|event| (event.first.line, event.kind.name())).collect();
        assert_eq!(found, [(185, "gouge"), (339, "collision")], "{}", variant.info.id);
        // Sunk by 0.05 mm into a mesh whose chords are within 0.01 mm of the surface, which is sampled within 0.01 mm.
        let depth = -outcome.events[0].least_mm;
        assert!((0.03..=0.06).contains(&depth), "{depth}");
        let outcome = check(&scene, &clean, variant, &registry, &settings, &Silent).unwrap();
        assert!(outcome.events.is_empty(), "{}: {:?}", variant.info.id, outcome.events);
    }
}

/// Both shipped programs are what `path` writes, byte for byte.
#[test]
fn the_programs_over_the_free_form_part_are_those_that_path_writes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("bench-scenes/freeform-5axis");
    for (file, flaws) in [("clean.ngc", &[][..]), ("program.ngc", &["--gouge", "0.05@0.3", "--lean", "66@0.53"])] {
        let path = ["program", "path", "freeform-5axis", "--rows", "8", "--step", "1.2", "--lead", "5", "--tilt", "3"];
        let output = bvbench().args(path).args(flaws).output().unwrap();
        assert!(output.status.success());
        assert_eq!(
            String::from_utf8(output.stdout).unwrap(),
            std::fs::read_to_string(folder.join(file)).unwrap(),
            "{file}"
        );
    }
}

#[test]
fn every_safe_variant_tells_the_same() {
    let registry = Registry::standard();
    let scene = Scene::find(Scene::SHIPPED[0]).unwrap();
    let run = scene.program.as_ref().unwrap();
    let settings = Settings { clearances: Some(Clearances::everywhere(&[2.0])), ..Settings::standard() };
    let told = |variant: &Variant| {
        let outcome = check(&scene, run, variant, &registry, &settings, &Silent).unwrap();
        outcome.events.iter().map(|e| (e.first.line, e.last.line, sorted(e.pair), e.kind.name())).collect::<Vec<_>>()
    };
    let expected = told(standard(&registry));
    let reference = registry.reference().unwrap().info.id;
    for id in ["aabb", "obb-vertex", reference] {
        assert_eq!(told(registry.find(id).unwrap()), expected, "{id}");
    }
}

/// A cutter of 10 mm over a block of 100 x 100 x 20 whose top is at Z 0, and a clamp beside it.
const MILL: &str = r#"
title = "A small mill"
[[machine.links]]
name = "table"
joint = { axis = "X", direction = [-1, 0, 0], min_mm = -200, max_mm = 200 }
[[machine.links]]
name = "head"
joint = { axis = "Z", direction = [0, 0, 1], min_mm = -50, max_mm = 200 }
[[parts]]
name = "block"
link = "table"
role = "workpiece"
at = { xyz_mm = [0, 0, -10] }
shape = { kind = "rounded-box", size_mm = [100, 100, 20], fillet_mm = 1 }
[[parts]]
name = "clamp"
link = "table"
at = { xyz_mm = [70, 0, 0] }
shape = { kind = "rounded-box", size_mm = [20, 20, 40], fillet_mm = 1 }
[[parts]]
name = "cutter"
link = "head"
role = "cutter"
shape = { kind = "cylinder", radius_mm = 5, height_mm = 30 }
[program]
file = "own.ngc"
start = { z_mm = 50 }
[check]
rapid_mm_min = 6000
"#;

fn scene_of(text: &str, program: &str) -> (tempfile::TempDir, Scene) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    std::fs::write(folder.path().join("own.ngc"), program).unwrap();
    let scene = Scene::load(folder.path()).unwrap();
    (folder, scene)
}

fn mill(program: &str) -> (tempfile::TempDir, Scene) {
    scene_of(MILL, program)
}

/// The same from another place, with pairs that the scene names.
fn mill_from(start: &str, pairs: &str, program: &str) -> (tempfile::TempDir, Scene) {
    let title = "title = \"A small mill\"\n";
    scene_of(&MILL.replace("start = { z_mm = 50 }", start).replace(title, &format!("{title}{pairs}\n")), program)
}

fn told(program: &str) -> Vec<(&'static str, u32)> {
    told_by(MILL, program)
}

fn told_by(text: &str, program: &str) -> Vec<(&'static str, u32)> {
    let (_folder, scene) = scene_of(text, program);
    let settings = Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() };
    run_own(&scene, &settings).events.iter().map(|event| (event.kind.name(), event.first.line)).collect()
}

#[test]
fn feeding_into_the_workpiece_is_cutting_and_a_rapid_is_not() {
    assert_eq!(told("M3 S1000 G0 Z5\nG1 Z-2 F100\nG1 X20\nG0 Z50\nM2"), []);
    assert_eq!(told("G0 Z5\nG0 Z-2\nG0 Z50\nM2"), [("rapid-into-workpiece", 2)]);
    // Along a finished slot at rapid rate: the retreat belongs to the cut. But a new way in at rapid rate does not.
    assert_eq!(told("M3 S1000 G0 Z5\nG1 Z-2 F100\nG0 Z5\nG0 X20\nG0 Z-2\nG0 Z50\nM2"), [("rapid-into-workpiece", 5)]);
    // What is in contact stays so while the machine waits.
    assert_eq!(told("G0 Z5\nG0 Z-2\nG4 P1\nG0 Z50\nM2"), [("rapid-into-workpiece", 2)]);
    // The clamp is never to be touched.
    assert_eq!(told("G0 Z5\nG1 X70 F100\nG0 Z50\nM2"), [("collision", 2)]);
}

#[test]
fn a_rapid_into_the_workpiece_is_told_though_a_cut_on_the_same_line_came_just_before() {
    // Every move of a subroutine file is on the call's line. Half a millimetre above the block is less than parts two contacts.
    let folder = scene_of(MILL, "G0 Z5\nM2");
    let sub = "O<cut> sub\nM3 S1000 G1 Z-2 F100\nG0 Z0.5\nX20\nZ-2\nZ50\nO<cut> endsub\n";
    std::fs::write(folder.0.path().join("cut.ngc"), sub).unwrap();
    std::fs::write(folder.0.path().join("own.ngc"), "G0 Z5\nO<cut> call\nM2\n").unwrap();
    let scene = Scene::load(folder.0.path()).unwrap();
    let settings = Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() };
    let told: Vec<_> = run_own(&scene, &settings).events.iter().map(|e| (e.kind.name(), e.first.line)).collect();
    assert_eq!(told, [("rapid-into-workpiece", 2)]);
}

#[test]
fn a_finished_part_may_be_touched_in_a_feed_move_only() {
    let part = format!("{MILL}gouge_mm = 0.1\n");
    let told = |program: &str| told_by(&part, &format!("G0 X-100\n{program}\nM2"));
    assert_eq!(told("G0 Z-0.09\nG1 X40 F1000\nG0 Z50"), []);
    // Less deep than a gouge, but at rapid rate; and so after a cut that has left the part.
    assert_eq!(told("G0 Z-0.09\nG0 X0\nG0 Z50"), [("rapid-into-workpiece", 3)]);
    assert_eq!(told("G1 Z-0.09 F1000\nX40\nX-60\nG0 X0"), [("rapid-into-workpiece", 5)]);
    assert_eq!(told("G0 Z-0.5\nG0 X0\nG0 Z50"), [("rapid-into-workpiece", 3)]);
    assert_eq!(told("G0 Z-0.09\nG0 X0\nG1 Z-0.5 F100\nG0 Z50"), [("rapid-into-workpiece", 3), ("gouge", 4)]);
    assert_eq!(told("G0 Z1\nG0 X40\nG0 Z50"), []);
}

/// The mill with the cutter as tool 1, a longer tool 2, and tool 3, whose shank begins 10 mm above its tip.
fn mill_with_tools() -> String {
    let tools = r#"
[[parts]]
name = "long"
link = "head"
role = "cutter"
tool = 2
at = { xyz_mm = [0, 0, -20] }
shape = { kind = "cylinder", radius_mm = 5, height_mm = 50 }
[[parts]]
name = "tip"
link = "head"
role = "cutter"
tool = 3
shape = { kind = "cylinder", radius_mm = 5, height_mm = 10 }
[[parts]]
name = "shank"
link = "head"
role = "shank"
tool = 3
at = { xyz_mm = [0, 0, 10] }
shape = { kind = "cylinder", radius_mm = 6, height_mm = 20 }
[program]
tool = 1
"#;
    MILL.replacen("role = \"cutter\"\n", "role = \"cutter\"\ntool = 1\n", 1).replacen("[program]\n", tools, 1)
}

#[test]
fn a_tool_is_there_only_while_it_is_in_the_spindle() {
    // The clamp reaches from X 60 to 80 and up to Z 20. At Z 25 tool 1 ends 5 above it, tool 2 at 25 - 20 = 5 within.
    let program = "G0 Z25\nG0 X70\nG0 X0\nT2 M6\nG0 X70\nG0 X0\nT1 M6\nG0 X70\nT2 M6\nT0 M6\nG0 X0\nM2";
    assert_eq!(told_by(&mill_with_tools(), program), [("collision", 5), ("collision", 9)]);
    let (_folder, scene) = scene_of(&mill_with_tools(), program);
    let outcome = run_own(&scene, &Settings::standard());
    let why = |a: &str, b: &str| {
        let of = |pair: Pair| [pair.a, pair.b].map(|part| scene.parts[part].name.as_str());
        let found = outcome.decisions.iter().find(|decision| of(decision.pair) == [a, b]).unwrap();
        found.dropped.as_ref().map(ToString::to_string)
    };
    assert_eq!(why("clamp", "long"), None);
    assert_eq!(why("block", "tip").unwrap(), "tool 3 is never in the spindle");
    assert!(outcome.tools_without_parts.is_empty());
    let (_folder, strange) = scene_of(&mill_with_tools(), "T2 M6\nG0 Z40\nT8 M6\nG0 X70\nM2");
    assert_eq!(run_own(&strange, &Settings::standard()).tools_without_parts, [8]);
    // What comes near in the zone of a tool that is there ends when it goes: tool 2 at X 0 is 5 above the block.
    let near = |line| outcome.events.iter().any(|e| e.first.line == line && scene.pair_name(e.pair) == "clamp:long");
    assert!(near(5) && near(9) && !near(2) && !near(8));
}

#[test]
fn a_tool_that_is_put_into_the_spindle_inside_the_workpiece_is_told() {
    let program = "G0 Z10\nT2 M6\nG0 Z50\nM2"; // tool 2 is 20 mm longer
    assert_eq!(told_by(&mill_with_tools(), program), [("tool-change-into-workpiece", 2)]);
}

#[test]
fn only_the_cutter_cuts() {
    let feed_to = |z: i32| told_by(&mill_with_tools(), &format!("G0 Z5\nT3 M6\nM3 S1000 G1 Z{z} F100\nG0 Z50\nM2"));
    assert_eq!(feed_to(-9), []);
    assert_eq!(feed_to(-11), [("collision", 3)]); // the shank, 1 mm deep
}

#[test]
fn allowed_contact_is_no_collision() {
    let program = "G0 Z5\nG1 X70 F100\nG0 Z50\nM2";
    let text = format!("{MILL}allow = [[\"cutter\", \"clamp\"]]\n");
    assert_eq!((told(program).len(), told_by(&text, program).len()), (1, 0));
    let (folder, _scene) = scene_of(&text, program);
    let output = bvbench().args(["scene", "pairs"]).arg(folder.path()).output().unwrap();
    let shown = String::from_utf8(output.stdout).unwrap();
    assert!(shown.lines().any(|line| line.contains("clamp:cutter") && line.contains("may touch")), "{shown}");
}

#[test]
fn a_thin_wall_between_two_samples_is_not_jumped_over() {
    let (_folder, scene) = mill("G0 Z10\nG0 X140\nM2");
    let own = scene.program.as_ref().unwrap();
    let mut coarse: ProgramRun = own.clone();
    coarse.sampling.step_mm = 500.0; // both samples of line 2 are far beside the clamp, which is 20 mm wide
    // The clamp's top is at 20; the cutter's lower end is at 10.
    let settings = Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() };
    let outcome =
        check(&scene, &coarse, standard(&Registry::standard()), &Registry::standard(), &settings, &Silent).unwrap();
    assert_eq!(outcome.events.iter().map(|event| event.first.line).collect::<Vec<_>>(), [2]);
    let event = &outcome.events[0];
    // Contact from X 70 - 10 - 5 = 55 to 85; at 6000 mm/min, after 0.4 s for the 40 mm of line 1.
    for (extent, x) in [(&event.first, 55.0), (&event.last, 85.0)] {
        assert!((extent.position.0[0] - x).abs() < 0.1, "{x}: {:?}", extent.position);
        assert!((extent.time_s - (0.4 + x / 100.0)).abs() < 0.01, "{x}: {}", extent.time_s);
    }
}

#[test]
fn a_rapid_that_clears_the_clamp_as_a_line_hits_it_as_a_dog_leg() {
    // From X -100, Z 10 to X 100, Z 150. As a line the cutter passes the clamp (X 55 to 85 with its radius, top at 20) at Z 118 and
    // above. As a dog-leg at 1000 mm/s in X and 50 in Z it is at X 55 after 0.155 s, and at Z 10 + 7.75.
    let program = "G0 X-100 Z10\nG0 X100 Z150\nM2";
    let rates = format!("{MILL}rapid_rates = {{ X = 60000, Z = 3000 }}\n");
    assert_eq!(told_by(&rates, program), []);
    assert_eq!(told_by(&format!("{rates}rapid = \"dog-leg\"\n"), program), [("collision", 2)]);
}

#[test]
fn an_axis_at_the_limit_of_its_feed_holds_up_the_program() {
    // 40 mm of Z and 55 mm of X to the clamp at 100 mm/s: 0.95 s; with X at 50 mm/s at most 0.4 + 1.1 s.
    let time_s = |text: &str| {
        let (_folder, scene) = scene_of(text, "G1 Z10 F6000\nG1 X140\nM2");
        let outcome =
            run_own(&scene, &Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() });
        assert_eq!(outcome.events.len(), 1);
        outcome.events[0].first.time_s
    };
    assert!((time_s(MILL) - 0.95).abs() < 0.01);
    assert!((time_s(&format!("{MILL}feed_limits = {{ X = 3000 }}\n")) - 1.5).abs() < 0.01);
}

#[test]
fn a_direction_of_any_length_moves_its_axis() {
    // A thin wall in the way of a ball: a direction whose square overflows or vanishes moves it as any other does.
    let text = |direction: &str| {
        format!(
            r#"
title = "a ball and a wall"
pairs = [["wall", "ball"]]
[[machine.links]]
name = "slide"
joint = {{ axis = "X", direction = {direction} }}
[[parts]]
name = "wall"
at = {{ xyz_mm = [50, 0, 0] }}
shape = {{ kind = "sphere", radius_mm = 5 }}
[[parts]]
name = "ball"
link = "slide"
shape = {{ kind = "sphere", radius_mm = 5 }}
[program]
file = "own.ngc"
"#
        )
    };
    for direction in ["[1, 0, 0]", "[1e200, 0, 0]", "[1e-200, 0, 0]", "[1e308, 1e-300, 0]", "[5e-324, 0, 0]"] {
        assert_eq!(told_by(&text(direction), "G0 X100\nM2"), [("collision", 1)], "{direction}");
    }
}

fn outcome_of(text: &str, program: &str) -> Outcome {
    let (_folder, scene) = scene_of(text, program);
    run_own(&scene, &Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() })
}

#[test]
fn a_rapid_through_uncut_stock_after_a_cut_is_told_with_its_depth() {
    // Into the edge by 25 mm, and on at rapid rate through 70 mm.
    let outcome = outcome_of(MILL, "M3 S1000 G0 X-60\nG0 Z-10\nG1 X-30 F500\nG0 X40\nG0 Z50\nM2");
    let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
    assert_eq!((event.kind, event.first.line, event.last.line), (Kind::RapidIntoWorkpiece, 4, 5));
    // The cutter's axis is in the stock, 5 mm from its side.
    let [low, high] = event.depth_mm.unwrap();
    assert!((4.7..=5.0).contains(&low) && (5.0..=5.3).contains(&high), "{low} {high}");
    assert!((event.first.position.0[0] + 30.0).abs() < 0.3, "{:?}", event.first);
}

#[test]
fn what_has_been_cut_may_be_entered_at_rapid_rate() {
    for (what, program) in [
        ("pecks", "M3 S1000 G0 Z5\nG98 G83 X0 Z-15 R2 Q4 F100\nG80 G0 Z50\nM2"),
        ("second level", "M3 S1000 G0 Z5\nG1 Z-5 F200\nX30\nX0\nG0 Z5\nG0 Z-4.5\nG1 Z-10\nX30\nG0 Z50\nM2"),
        ("back along a slot", "M3 S1000 G0 X-60\nG0 Z-2\nG1 X40 F500\nG0 X-60\nG0 Z50\nM2"),
        ("drilled hole again", "M3 S1000 G0 Z5\nG1 Z-15 F200\nG0 Z5\nG0 Z-15\nG0 Z50\nM2"),
        ("touching the uncut top", "G0 Z0\nG0 X20\nG0 Z50\nM2"),
    ] {
        let outcome = outcome_of(MILL, program);
        assert!(outcome.events.is_empty() && outcome.is_clear(), "{what}: {:?}", outcome.events);
        // What is not decided is never deeper than the resolution.
        assert!(outcome.touches.iter().all(|touch| touch.at_most_mm <= 0.1), "{what}: {:?}", outcome.touches);
    }
    // A tenth deeper than the resolution is told; twice as deep a rapid beside the hole, too.
    for (program, line) in [
        ("M3 S1000 G0 X-60\nG0 Z-2\nG1 X40 F500\nG0 X-60\nG0 Z-2.2\nG0 X40\nG0 Z50\nM2", 6),
        ("M3 S1000 G0 Z5\nG1 Z-15 F200\nG0 Z5\nG0 X0.3\nG0 Z-15\nG0 Z50\nM2", 5),
    ] {
        let told: Vec<_> = outcome_of(MILL, program).events.iter().map(|e| (e.kind, e.first.line)).collect();
        assert_eq!(told, [(Kind::RapidIntoWorkpiece, line)], "{program}");
    }
}

#[test]
fn a_shank_is_held_against_what_is_left() {
    // A shank of 6 mm radius 10 mm above the tip of a cutter of 5 mm.
    let text = mill_with_tools();
    let told = |text: &str, program: &str| {
        let outcome = outcome_of(text, program);
        outcome.events.iter().map(|e| (e.kind, e.first.line, e.depth_mm.unwrap())).collect::<Vec<_>>()
    };
    let feed = |first: &str| format!("G0 Z5\nT3 M6\nM3 S1000 G0 X-60\n{first}G0 Z-15\nG1 X0 F300\nG0 X-60\nG0 Z50\nM2");
    // Fed sideways 15 mm deep: nothing has cut the upper 5 mm, and the point of them on the shank's axis is as deep in it.
    let [(Kind::Collision, 5, [low, high])] = told(&text, &feed(""))[..] else { panic!() };
    assert!((4.7..=5.0).contains(&low) && (5.0..=5.3).contains(&high), "{low} {high}");
    // Plunged 15 mm deep: the cutter has been there first, and leaves a ring of 1 mm.
    let [(Kind::Collision, 4, [low, high])] = told(&text, "G0 Z5\nT3 M6\nM3 S1000\nG1 Z-15 F100\nG0 Z50\nM2")[..]
    else {
        panic!()
    };
    assert!((0.8..=1.0).contains(&low) && (1.0..=1.2).contains(&high), "{low} {high}");
    // In a slot of 16 mm that was cut before it is free. A change of tools stops the spindle.
    let wide = text.replacen("radius_mm = 5, height_mm = 30", "radius_mm = 8, height_mm = 30", 1);
    let first = "T1 M6\nM3 S1000\nG0 Z-8\nG1 X10 F300\nG0 X-60\nT3 M6\nM3 S1000\n";
    assert_eq!(told(&wide, &feed(first)), []);
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
fn told_of_open(shape: &str, stl: &str, program: &str) -> (Vec<(&'static str, u32)>, String, Option<i32>) {
    assert_eq!(MILL.matches(shape).count(), 1, "{shape}");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("open.stl"), stl).unwrap();
    std::fs::write(folder.path().join("scene.toml"), MILL.replace(shape, "mesh = \"open.stl\"")).unwrap();
    std::fs::write(folder.path().join("own.ngc"), program).unwrap();
    let scene = Scene::load(folder.path()).unwrap();
    let outcome = run_own(&scene, &Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() });
    let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).output().unwrap();
    let told = outcome.events.iter().map(|event| (event.kind.name(), event.first.line)).collect();
    (told, String::from_utf8(output.stdout).unwrap(), output.status.code())
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
        let (told, shown, code) = told_of_open(shape, stl, through);
        assert!(told.contains(&("unresolved", line)) && code == Some(1), "{name}: {told:?}\n{shown}");
        assert!(shown.contains("UNRESOLVED") && shown.contains("not watertight"), "{name}: {shown}");
        let (told, shown, code) = told_of_open(shape, stl, beside);
        assert!(told.is_empty() && code == Some(0), "{name}: {told:?}\n{shown}");
        assert!(shown.contains("not examined: what"), "{name}: {shown}");
    }
    // A clamp without top and bottom, beside which the cutter goes down.
    let clamp = "shape = { kind = \"rounded-box\", size_mm = [20, 20, 40], fillet_mm = 1 }";
    let frame = walls(&[[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]], [-20.0, 20.0]);
    let (told, shown, code) = told_of_open(clamp, &frame, "G0 X90\nG0 Z0\nG0 Z50\nM2");
    assert!(told.is_empty() && code == Some(0), "{told:?}\n{shown}");
    assert!(shown.contains("not examined: what lies wholly inside `clamp`"), "{shown}");
}

#[test]
fn a_workpiece_that_stays_whole_is_named() {
    let (folder, _scene) = mill("M3 S1000 G0 X-60\nG0 Z-10\nG1 X-30 F500\nG0 X40\nG0 Z50\nM2");
    let run = |arguments: &[&str]| {
        let output = bvbench().args(["check", "--quiet"]).args(arguments).arg(folder.path()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap())
    };
    let (code, shown) = run(&["--stock-resolution", "none"]);
    assert!(
        code == Some(0) && shown.contains("nothing collides, but rapids through the workpiece are not examined"),
        "{shown}"
    );
    let (code, shown) = run(&[]);
    assert!(code == Some(1) && shown.contains("`block` is cut: contact is told from a depth of 0.1 mm on"), "{shown}");
}

#[test]
fn a_stock_that_takes_too_much_work_is_unresolved() {
    // A turn of the helix is cut; then a rapid through the uncut block.
    let (_folder, scene) = mill("M3 S1000 G0 X-60\nG0 Z-2\nG3 I10 Z-4 F500\nG1 X-30\nG0 X40\nG0 Z50\nM2");
    let told = |stock_budget: u64| {
        let settings = Settings { clearances: Some(Clearances::everywhere(&[])), stock_budget, ..Settings::standard() };
        let outcome = run_own(&scene, &settings);
        let events: Vec<_> = outcome.events.iter().map(|e| (e.kind, e.first.line)).collect();
        (events, outcome.remaining[0].given_up, outcome.is_clear())
    };
    assert_eq!(told(Settings::standard().stock_budget), (vec![(Kind::RapidIntoWorkpiece, 5)], None, false));
    let (events, given_up, is_clear) = told(0);
    assert!(
        matches!(events[..], [(Kind::Unresolved, _)]) && given_up.is_some() && !is_clear,
        "{events:?} {given_up:?}"
    );
}

#[test]
fn a_finer_resolution_decides_what_a_coarse_one_leaves_open() {
    // 0.15 mm into the floor of a slot.
    let program = "M3 S1000 G0 X-60\nG0 Z-2\nG1 X40 F500\nG0 X-60\nG0 Z-2.15\nG0 X40\nG0 Z50\nM2";
    let (_folder, scene) = mill(program);
    let told = |resolution_mm: f64| {
        let cutting = Cutting::At(resolution_mm);
        let outcome = run_own(
            &scene,
            &Settings { clearances: Some(Clearances::everywhere(&[])), cutting, ..Settings::standard() },
        );
        (outcome.events.iter().map(|e| (e.kind, e.first.line)).collect::<Vec<_>>(), outcome.touches.len())
    };
    assert_eq!(told(0.02).0, [(Kind::RapidIntoWorkpiece, 6)]);
    let (events, touches) = told(1.0);
    assert!(events.is_empty() && touches == 1, "{events:?} {touches}");
}

#[test]
fn what_is_left_is_written_and_compared_with_the_wanted_part() {
    let (folder, _scene) = mill("M3 S1000 G0 X-60\nG0 Z-5\nG1 X40 F500\nG0 Z50\nM2");
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let run = |arguments: &[&str]| {
        let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let left = path("left.stl");
    let (code, text, error) = run(&["--stock-resolution", "0.5", "--stock-out", &left]);
    assert_eq!(code, Some(0), "{text}{error}");
    assert!(text.contains("all that may be left of `block`"), "{text}");
    let mesh = bvbench::geometry::import::load(Path::new(&left), None).unwrap().mesh;
    assert!(mesh.edge_report().is_watertight());
    // A block of 100 x 100 x 20 with edges of 1 mm less a slot of 10 x 5, 90 long and half round at its end.
    let volume = 200_000.0 - 50.0 * 90.0 - 5.0 * 0.5 * std::f64::consts::PI * 25.0;
    assert!(mesh.signed_volume() > volume - 400.0 && mesh.signed_volume() < volume * 1.04, "{}", mesh.signed_volume());
    // What is left, as the part that is wanted: no gouge, no rest. The uncut block as the wanted part: a gouge 5 mm deep.
    let json = |arguments: &[&str]| {
        let (code, text, error) = run(&[&["--json", "--stock-resolution", "0.5"], arguments].concat());
        (code, serde_json::from_str::<serde_json::Value>(&text).unwrap_or_else(|_| panic!("{error}")))
    };
    let export =
        bvbench().args(["scene", "export"]).arg(folder.path()).args(["--out", &path("parts")]).output().unwrap();
    assert!(export.status.success());
    let (code, uncut) = json(&["--target", &left]);
    let target = &uncut["stock"]["workpieces"][0]["target"];
    assert_eq!((code, &target["gouge"]["volume_mm3"]), (Some(0), &0.0.into()), "{target}");
    // The exported block is where the machine has it at first: 10 mm under the frame of its mesh.
    let block = bvbench::geometry::import::load(Path::new(&path("parts/block.stl")), None).unwrap().mesh;
    let raised = block.triangles().into_iter().map(|t| t.map(|p| p + nalgebra::Vector3::new(0.0, 0.0, 10.0)));
    let raised: Vec<_> = raised.collect();
    let text = raised.iter().map(|t| {
        let vertices = t.corners.map(|p| format!("vertex {} {} {}\n", p.x, p.y, p.z)).concat();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    });
    std::fs::write(path("block.stl"), format!("solid block\n{}endsolid block\n", text.collect::<String>())).unwrap();
    let (code, gouged) = json(&["--target", &path("block.stl")]);
    let gouge = &gouged["stock"]["workpieces"][0]["target"]["gouge"];
    let (depth, volume) = (gouge["greatest_mm"].as_f64().unwrap(), gouge["volume_mm3"].as_f64().unwrap());
    assert!(code == Some(1) && gouged["clear"] == false, "{gouged}");
    assert!((4.0..=5.01).contains(&depth) && (3000.0..=4800.0).contains(&volume), "{gouge}");
    let (code, _, error) = run(&["--target", &path("no.stl")]);
    assert!(code == Some(2) && error.contains("--target"), "{error}");
    let (code, _, error) = run(&["--stock-resolution", "0"]);
    assert!(code == Some(2) && error.contains("--stock-resolution"), "{error}");
}

#[test]
fn an_answer_that_is_not_decided_to_the_last_tenth_says_so() {
    let (folder, _scene) = mill("G0 X-60\nG0 Z5\nG0 X0\nG0 Z0\nG0 Z50\nM2");
    let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).output().unwrap();
    let shown = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{shown}");
    assert!(shown.contains("nothing collides, but for what may touch the stock by at most 0.0"), "{shown}");
    assert!(shown.contains("not decided: whether block:cutter touch in"), "{shown}");
    let arguments = ["check", "--quiet", "--json"];
    let output = bvbench().args(arguments).arg(folder.path()).output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let touch = &json["stock"]["touches"][0];
    assert!(touch["at_most_mm"].as_f64().unwrap() <= 0.1 && touch["line"] == 4, "{json}");
}

#[test]
fn a_part_wholly_inside_another_collides() {
    // The cutter, 30 mm long, fits into the clamp, which reaches from -20 to 20 and is 20 mm wide.
    let (_folder, scene) = mill("G0 X140\nG0 Z-15\nG1 X70 F1000\nG4 P1\nG1 X140\nM2");
    for zones_mm in [vec![], vec![14.0, 0.5]] {
        let outcome =
            run_own(&scene, &Settings { clearances: Some(Clearances::everywhere(&zones_mm)), ..Settings::standard() });
        let contacts: Vec<_> = outcome.events.iter().filter(|event| event.kind.is_collision()).collect();
        assert_eq!(contacts.len(), 1, "{contacts:?}");
        let event = contacts[0];
        assert_eq!((event.first.line, event.last.line, event.inside, event.least_mm), (3, 5, true, 0.0));
        // Contact begins where the cutter's side reaches 80: at 85, 55 of 70 mm into the move and as far out of it.
        for (extent, fraction) in [(&event.first, 55.0 / 70.0), (&event.last, 15.0 / 70.0)] {
            assert!(
                (extent.position.0[0] - 85.0).abs() < 0.02 && (extent.fraction - fraction).abs() < 1e-3,
                "{extent:?}"
            );
        }
    }
    // Inside from the first place on, and never through a surface.
    let (_folder, scene) =
        mill_from("start = { x_mm = 70, z_mm = -15 }", "pairs = [[\"clamp\", \"cutter\"]]", "G1 X69 F1000\nM2");
    let outcome = run_own(&scene, &Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() });
    assert_eq!(outcome.events.len(), 1);
    assert!(outcome.events[0].inside && outcome.events[0].to_the_end && outcome.events[0].first.line == 0);
}

#[test]
fn contact_before_the_first_move_is_told_whether_or_not_the_scene_names_the_pair() {
    let program = "G1 X60 F1000\nG1 X40\nG1 X60\nM2"; // out of the clamp at X 55, and in again
    let start = "start = { x_mm = 70, z_mm = 0 }";
    for pairs in ["", "pairs = [[\"clamp\", \"cutter\"]]"] {
        let (_folder, scene) = mill_from(start, pairs, program);
        let outcome =
            run_own(&scene, &Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() });
        let with_clamp = outcome.events.iter().filter(|event| scene.pair_name(event.pair).contains("clamp"));
        assert_eq!(with_clamp.map(|event| event.first.line).collect::<Vec<_>>(), [0, 3], "{pairs}");
    }
    // Cutter in the workpiece before the first move, a feed: nobody knows how it came there.
    let (_folder, scene) = mill_from("start = { z_mm = -5 }", "", "M3 S1000 G1 X20 F100\nG0 Z50\nM2");
    let outcome = run_own(&scene, &Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() });
    let found: Vec<_> = outcome.events.iter().map(|event| (event.kind, event.first.line)).collect();
    assert_eq!(found, [(Kind::Collision, 0)]);
    // A holder wholly inside a block.
    let holder = MILL.replace("role = \"cutter\"", "role = \"holder\"").replace("[100, 100, 20]", "[100, 100, 200]");
    let told = told_by(&holder.replace("start = { z_mm = 50 }", "start = { z_mm = -25 }"), "G0 X1\nM2");
    assert_eq!(told, [("collision", 0)]);
}

#[test]
fn only_the_structure_of_the_machine_has_neighbours() {
    // A post that stands on the frame as the head does: one joint is between them.
    let post = MILL.replace("name = \"clamp\"\nlink = \"table\"", "name = \"clamp\"");
    let told_of = |role: &str| {
        let text = post.replace("role = \"cutter\"", &format!("role = \"{role}\""));
        told_by(&text.replace("[70, 0, 0]", "[0, 0, 21]"), "G0 Z20\nG0 Z50\nM2")
    };
    for role in ["cutter", "shank", "holder", "fixture", "workpiece"] {
        assert_eq!(told_of(role), [("collision", 1)], "{role}");
    }
    assert_eq!(told_of("machine"), []);
}

#[test]
fn a_feed_into_the_workpiece_while_the_spindle_stands_still_is_told() {
    let stopped = "stopped-spindle-into-workpiece";
    assert_eq!(told("G0 Z5\nG1 Z-2 F100\nX20\nG0 Z50\nM2"), [(stopped, 2), (stopped, 3)]);
    assert_eq!(told("M3 S1000 G0 Z5\nG1 Z-2 F100\nX20\nM5\nX30\nG0 Z50\nM2"), [(stopped, 5)]);
    assert_eq!(told("M3 G0 Z5\nG1 Z-2 F100\nG0 Z50\nM2"), [(stopped, 2)]); // M3 without S
    assert_eq!(told("M4 S1 G0 Z5\nG1 Z-2 F100\nG0 Z50\nM2"), []);
    // The same where the workpiece stays whole; the program is within it all the way from line 2.
    let (_folder, scene) = mill("G0 Z5\nG1 Z-2 F100\nX20\nG0 Z50\nM2");
    let clearances = Some(Clearances::everywhere(&[]));
    let outcome = run_own(&scene, &Settings { clearances, cutting: Cutting::Never, ..Settings::standard() });
    let lines = |event: &Event| [event.first.line, event.nearest.line, event.last.line];
    let told: Vec<_> = outcome.events.iter().map(|event| (event.kind.name(), lines(event))).collect();
    assert_eq!(told, [(stopped, [2; 3]), (stopped, [3; 3])]);
}

#[test]
fn an_axis_beyond_its_limits_hides_no_collision() {
    // Z goes to 260 of 200 on line 4, X to 300 and -300 of 200; the clamp is hit on lines 1 and 6.
    let program = "M3 S1000 G0 X70 Z0\nG0 Z50\nG0 X0\nZ260\nX300 Z50\nG1 X70 Z0 F1000\nX-300\nM2";
    let (folder, scene) = mill(program);
    let outcome = run_own(&scene, &Settings { clearances: Some(Clearances::everywhere(&[])), ..Settings::standard() });
    let over: Vec<_> = outcome.over_travel.iter().map(|over| (over.line, over.cause.axis, over.cause.value)).collect();
    assert_eq!(over, [(4, 'Z', 260.0), (5, 'X', 300.0), (7, 'X', -300.0)]);
    assert_eq!(outcome.events.iter().map(|event| event.first.line).collect::<Vec<_>>(), [1, 6]);
    let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).output().unwrap();
    let shown = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        shown.contains("OVER-TRAVEL") && shown.contains("axis Z at 260 mm is outside its limits -50 to 200 mm"),
        "{shown}"
    );
    // Over-travel alone is not clear either.
    let (folder, _) = mill("G0 Z260\nM2");
    let output = bvbench().args(["check", "--quiet", "--json"]).arg(folder.path()).output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((output.status.code(), &json["clear"], &json["collides"]), (Some(1), &false.into(), &false.into()));
    assert_eq!(json["over_travel"][0]["line"], 1);
}

#[test]
fn a_zone_entered_and_left_between_two_samples_is_told() {
    // Past the clamp's edge, parallel to Y, 1.5 mm from the cutter's side: there is no Y axis, so past its top in X.
    let (_folder, scene) = mill("G0 Z21.5\nG0 X140\nM2");
    let mut coarse: ProgramRun = scene.program.clone().unwrap();
    coarse.sampling.step_mm = 500.0;
    let settings = Settings { clearances: Some(Clearances::everywhere(&[30.0, 2.0])), ..Settings::standard() };
    let outcome =
        check(&scene, &coarse, standard(&Registry::standard()), &Registry::standard(), &settings, &Silent).unwrap();
    let clamp = outcome.events.iter().filter(|event| scene.pair_name(event.pair).contains("clamp"));
    let near: Vec<_> = clamp.map(|event| (event.kind, event.first.line, (10.0 * event.least_mm).round())).collect();
    assert_eq!(near, [(Kind::Near { zone_mm: 30.0 }, 2, 15.0), (Kind::Near { zone_mm: 2.0 }, 2, 15.0)]);
}

#[test]
fn a_zone_left_and_entered_again_within_two_samples_is_two_events() {
    // 10 mm beside the clamp, whose top is at 20: 14 mm away at Z 29.8, two thirds of the way up to 40, where it is free.
    let (_folder, scene) = mill("G0 X45\nG0 Z10\nG0 Z40\nG0 Z10\nG0 Z40\nM2");
    let mut coarse: ProgramRun = scene.program.clone().unwrap();
    coarse.sampling.step_mm = 500.0;
    let settings = Settings { clearances: Some(Clearances::everywhere(&[14.0])), ..Settings::standard() };
    let outcome =
        check(&scene, &coarse, standard(&Registry::standard()), &Registry::standard(), &settings, &Silent).unwrap();
    let near = outcome.events.iter().filter(|event| scene.pair_name(event.pair).contains("clamp"));
    assert_eq!(near.map(|event| (event.first.line, event.last.line)).collect::<Vec<_>>(), [(2, 3), (4, 5)]);
}

fn bvbench() -> Command {
    Command::cargo_bin("bvbench").unwrap()
}

#[test]
fn formats_and_exit_codes() {
    let clear = mill("G0 Z20\nM2").0;
    bvbench().args(["check", "--quiet"]).arg(clear.path()).assert().code(0);
    let (folder, _) = mill("G0 Z5\nG0 Z-2\nG0 Z50\nG0 X70\nG0 Z0\nM2");
    let run = |arguments: &[&str]| {
        let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let json: serde_json::Value = serde_json::from_str(&run(&["--json"])).unwrap();
    assert_eq!(json["collides"], true);
    assert_eq!(json["events"].as_array().unwrap().iter().filter(|e| e["kind"] != "near").count(), 2);
    let first: serde_json::Value = serde_json::from_str(&run(&["--json", "--first", "--clearance", "0"])).unwrap();
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
fn clearances_hold_for_pairs_and_roles() {
    // The cutter passes 6 mm over the clamp, which is a part of the machine.
    let program = "G0 Z26\nG0 X70\nG0 X0\nM2";
    let zones = |text: &str, asked: &[&str]| {
        let (folder, _scene) = scene_of(text, program);
        let mut command = bvbench();
        command.args(["check", "--json", "--quiet"]).arg(folder.path());
        let output = command.args(asked.iter().flat_map(|asked| ["--clearance", asked])).output().unwrap();
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(0));
        let zones: Vec<f64> =
            json["events"].as_array().unwrap().iter().map(|event| event["zone_mm"].as_f64().unwrap()).collect();
        zones
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
    let (folder, _scene) = scene_of(MILL, "G0 Z20\nM2");
    let refused = |asked: &[&str]| {
        let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).args(asked).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{asked:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    for (asked, part) in [("holdr=5", "no part and no role `holdr`"), ("-1", "from 0"), ("clamp=x", "`x` is no number")]
    {
        let told = refused(&[&format!("--clearance={asked}")]);
        assert!(told.contains(part) && told.contains("--clearance"), "{told}");
    }
    let text = MILL.replacen("[check]\n", "[check]\nclearance = [\"5\", \"clamb=2\"]\n", 1);
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    let told = refused(&[]);
    assert!(told.contains("scene.toml:29") && told.contains("`clamb`") && told.contains("clamp"), "{told}");
}

#[test]
fn a_machine_changes_tools_where_it_says() {
    // Tool 2 is 20 mm longer: changed at Z 10 it is in the block. The machine goes up to Z 150 first, Z before X, and comes back on line 3.
    let program = "G0 X70 Z25\nG0 X-60\nT2 M6\nG0 X0 Z30\nM2";
    let text = mill_with_tools();
    let changes = text.replacen("[program]\n", "[program]\ntool_change = { Z = 150, X = -150 }\n", 1);
    assert_eq!(told_by(&text, "G0 Z10\nT2 M6\nG0 Z50\nM2"), [("tool-change-into-workpiece", 2)]);
    assert_eq!(told_by(&changes, "G0 Z10\nT2 M6\nG0 Z50\nM2"), []);
    let (_folder, scene) = scene_of(&changes, program);
    let moves: Vec<_> =
        scene.program.as_ref().unwrap().program.moves.iter().map(|m| (m.line, m.kind.name(), m.end)).collect();
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
    let (folder, _scene) = scene_of(&text, program);
    std::fs::write(
        folder.path().join("scene.toml"),
        text.replacen("[program]\n", "[program]\ntool_change = { Q = 1 }\n", 1),
    )
    .unwrap();
    let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).output().unwrap();
    assert!(String::from_utf8(output.stderr).unwrap().contains("tool_change: `Q` is not an axis"));
}

#[test]
fn another_program_runs_though_the_scenes_own_is_missing_and_offsets_and_tools_come_from_the_command_line() {
    let (folder, _) = mill("G0 Z20\nM2");
    let other = folder.path().join("other.ngc");
    std::fs::write(&other, "G0 X0 Z-25\nM2").unwrap();
    std::fs::remove_file(folder.path().join("own.ngc")).unwrap();
    let run =
        |arguments: &[&str]| bvbench().args(["check", "--quiet"]).arg(folder.path()).args(arguments).output().unwrap();
    let program = other.to_str().unwrap();
    assert_eq!(run(&[program]).status.code(), Some(1));
    assert_eq!(run(&[]).status.code(), Some(2));
    // 50 mm higher all is clear; so it is with a tool of 50 mm.
    assert_eq!(run(&[program, "--offset", "G54=0,0,50"]).status.code(), Some(0));
    std::fs::write(&other, "G43 H7 G0 X0 Z-25\nM2").unwrap();
    let unknown = run(&[program]);
    let error = String::from_utf8(unknown.stderr).unwrap();
    assert!(unknown.status.code() == Some(2) && error.contains("--tool-table"), "{error}");
    let table = folder.path().join("mill.tbl");
    std::fs::write(&table, "T7 P7 Z50 D10\n").unwrap();
    assert_eq!(run(&[program, "--tool-table", table.to_str().unwrap()]).status.code(), Some(0));
    for (offset, message) in [
        ("G54", "must be like"),
        ("G60=1,2,3", "is not one of"),
        ("G54=1,2", "2 numbers"),
        ("G54=1,2,inf", "not finite"),
    ] {
        let output = run(&[program, "--offset", offset]);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && error.contains(message), "{offset}: {error}");
    }
}

#[test]
fn near_misses_are_one_line_for_each_pair() {
    // Three times 1 mm over the clamp, within all three zones; then into it.
    let (folder, _) = mill("G0 Z21\nG0 X70\nG0 X0\nG0 X70\nG0 X140\nG0 Z15\nG0 X70\nM2");
    let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).output().unwrap();
    let shown = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = shown.lines().filter(|line| line.trim_start().starts_with("clamp:cutter")).collect();
    assert!(shown.contains("NEAR MISSES") && lines.len() == 2, "{shown}");
    assert!(lines[1].contains("1.000") && lines[1].split_whitespace().nth(1) == Some("2"), "{shown}");
}

#[test]
fn lines_with_a_slash_are_skipped_when_asked() {
    let (folder, _) = mill("G0 Z20\n/G0 Z-2\nM2");
    let other = folder.path().join("other.ngc");
    std::fs::write(&other, "/G0 Z-2\nG0 Z20\nM2").unwrap();
    for (program, block_delete, code) in
        [(None, false, 1), (None, true, 0), (Some(&other), false, 1), (Some(&other), true, 0)]
    {
        let mut command = bvbench();
        command.args(["check", "--quiet"]).arg(folder.path()).args(program);
        if block_delete {
            command.arg("--block-delete");
        }
        command.assert().code(code);
    }
}

#[test]
fn a_tool_without_parts_is_named_beside_the_csv() {
    let (folder, _) = scene_of(&mill_with_tools(), "T8 M6\nG0 Z40\nM2");
    let output = bvbench().args(["check", "--quiet", "--csv"]).arg(folder.path()).output().unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 1);
    assert!(String::from_utf8(output.stderr).unwrap().contains("not examined: tool 8"));
}

#[test]
fn bad_input_ends_with_2_and_names_the_place() {
    let (folder, _) = mill("G0 Z20\nM2");
    let bad = folder.path().join("bad.ngc");
    let refused = |program: &str, message: &str| {
        std::fs::write(&bad, program).unwrap();
        let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).arg(&bad).output().unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(message), "{error}");
    };
    refused(
        "G0 X1\nG77\nM2",
        "bad.ngc:2:1: code is not supported; if it moves nothing, ignore it (`--ignore G77`): `G77`",
    );
    refused("M2", "no moves");
    refused("G0 X1\nA90\nM2", "bad.ngc:2: the program moves axis A to 90 degrees, and no joint of the machine");
    refused("G0 X1\nG0 Z40 U-10\nM2", "bad.ngc:2: the program moves axis U to -10 mm");
    let missing = Path::new("no/such.ngc");
    bvbench().args(["check", "--quiet"]).arg(folder.path()).arg(missing).assert().code(2);
    bvbench().args(["check", "--quiet", "no-such-scene"]).assert().code(2);
    bvbench().args(["check", "--quiet"]).arg(folder.path()).args(["--method", "nothing"]).assert().code(2);
    bvbench().args(["check", "--quiet"]).arg(folder.path()).args(["--step", "0"]).assert().code(2);
}

#[cfg(target_os = "linux")]
#[test]
fn a_program_whose_name_is_not_unicode_is_checked() {
    use std::os::unix::ffi::OsStrExt;
    let (folder, _) = mill("G0 Z20\nM2");
    let program = folder.path().join(std::ffi::OsStr::from_bytes(b"caf\xe9.ngc"));
    std::fs::write(&program, "G0 Z20\nM2").unwrap();
    let output = bvbench().args(["check", "--quiet", "--json"]).arg(folder.path()).arg(&program).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(json["program"].as_str().unwrap().ends_with("caf\u{fffd}.ngc"), "{json}");
}

#[test]
fn a_machine_whose_parts_are_all_neighbours_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let head = MILL.find("[[parts]]\nname = \"clamp\"").unwrap();
    let (first, rest) = MILL.split_at(head);
    let table = "name = \"table\"\njoint = { axis = \"X\", direction = [-1, 0, 0], min_mm = -200, max_mm = 200 }";
    let cutter = &rest[rest.find("[[parts]]\nname = \"cutter\"").unwrap()..];
    let text = format!("{}{cutter}", first.replacen(table, "name = \"table\"", 1));
    let text = text.replace("role = \"workpiece\"", "").replace("role = \"cutter\"", "");
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    std::fs::write(folder.path().join("own.ngc"), "G0 Z1\nM2").unwrap();
    let output = bvbench().args(["check", "--quiet"]).arg(folder.path()).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && error.contains("no two parts that could collide"), "{error}");
}

#[test]
fn an_axis_that_the_machine_lacks_may_be_named_where_it_stays() {
    assert_eq!(told("G0 Z20 Y0 A0\nG28 Y0\nM2"), []);
}

#[test]
fn scene_tells_what_it_holds_and_writes_its_meshes() {
    let (folder, _) = mill("G0 Z20\nG0 X50\nM2");
    let text = |arguments: &[&str]| {
        let output =
            bvbench().arg("scene").arg(arguments[0]).arg(folder.path()).args(&arguments[1..]).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    };
    let info: serde_json::Value = serde_json::from_str(&text(&["info", "--json"])).unwrap();
    assert_eq!(info["parts"].as_array().unwrap().len(), 3);
    assert_eq!(info["links"][0]["joint"]["max"], 200.0);
    let pairs: serde_json::Value = serde_json::from_str(&text(&["pairs", "--json"])).unwrap();
    let kept = pairs.as_array().unwrap().iter().filter(|pair| pair["kept"] == true).count();
    assert_eq!((pairs.as_array().unwrap().len(), kept), (3, 2)); // block and clamp are rigid
    assert!(text(&["pairs"]).contains("no joint between them"));
    let out = folder.path().join("meshes");
    text(&["export", "--out", out.to_str().unwrap()]);
    let stl = stl_io::read_stl(&mut std::fs::File::open(out.join("clamp.stl")).unwrap()).unwrap();
    let x: Vec<f32> = stl.vertices.iter().map(|v| v[0]).collect();
    assert!((x.iter().copied().fold(f32::INFINITY, f32::min) - 60.0).abs() < 1e-3);
    assert!((x.iter().copied().fold(f32::NEG_INFINITY, f32::max) - 80.0).abs() < 1e-3);
}

#[test]
fn a_tool_vector_has_two_solutions() {
    let inverse = |arguments: &[&str]| {
        let output = bvbench().args(["scene", "inverse", "trunnion-impeller"]).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    // tan A = 3 / 4, towards x, which C turns to y and y is where A tilts: C 90 or -90.
    let (code, text, _) = inverse(&["--direction", "0.6,0,0.8", "--from", "A-5,C-60", "--json"]);
    assert_eq!(code, Some(0));
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
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
