//! `check` as a library: the planted collisions of the shipped scenes and no others, agreement with the exact truth along
//! the path, and the rule for cutting.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

#[path = "support/mill.rs"]
mod mill;
mod support;

use bvbench::check::{Cutting, Event, Kind, Path as ToolPath, Settings, check};
use bvbench::measure::Silent;
use bvbench::registry::{self, Variant};
use bvbench::scene::{Pair, Scene};
use bvbench::stock::Material;
use bvbench::truth::PairOracle;
use mill::*;
use std::path::Path;
use std::sync::Arc;
use support::{checked, run_own, with_zones};

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
    let settings = with_zones(&[]);
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
    let registry = registry::standard();
    let scene = Scene::find("freeform-5axis").unwrap();
    let flawed = scene.program.as_ref().unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("bench-scenes/freeform-5axis");
    let clean = flawed.with_program(&folder.join("clean.ngc")).unwrap();
    let settings = with_zones(&[]);
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

#[test]
fn every_safe_variant_tells_the_same() {
    let registry = registry::standard();
    let scene = Scene::find(Scene::SHIPPED[0]).unwrap();
    let run = scene.program.as_ref().unwrap();
    let settings = with_zones(&[2.0]);
    let told = |variant: &Variant| {
        let outcome = check(&scene, run, variant, &registry, &settings, &Silent).unwrap();
        outcome.events.iter().map(|e| (e.first.line, e.last.line, sorted(e.pair), e.kind.name())).collect::<Vec<_>>()
    };
    let expected = told(registry.fastest().unwrap());
    let reference = registry.reference().unwrap().info.id;
    for id in ["aabb", "obb-vertex", reference] {
        assert_eq!(told(registry.find(id).unwrap()), expected, "{id}");
    }
}

#[test]
fn feeding_into_the_workpiece_is_cutting_and_a_rapid_is_not() {
    assert_eq!(told("M3 S1000 G0 Z5\nG1 Z-2 F100\nG1 X20\nG0 Z50\nM2"), []);
    assert_eq!(told("G0 Z5\nG0 Z-2\nG0 Z50\nM2"), [("rapid-into-workpiece", 2)]);
    // Along a finished slot at rapid rate: the retreat belongs to the cut. But a new way in at rapid rate does not.
    assert_eq!(told("M3 S1000 G0 Z5\nG1 Z-2 F100\nG0 Z5\nG0 X20\nG0 Z-2\nG0 Z50\nM2"), [("rapid-into-workpiece", 5)]);
    // What is in contact stays so while the machine waits.
    assert_eq!(told("G0 Z5\nG0 Z-2\nG4 P1\nG0 Z50\nM2"), [("rapid-into-workpiece", 2)]);
    // Out of the uncut block by X -55 and in again: for a sixth of the last sample the cutter is between the two.
    let twice = "G0 X-60\nG0 Z-2\nG0 X-45\nG0 X-55\nG0 X-45\nG0 X-60\nG0 Z50\nM2";
    assert_eq!(told(twice), [("rapid-into-workpiece", 3), ("rapid-into-workpiece", 5)]);
    // The clamp is never to be touched.
    assert_eq!(told("G0 Z5\nG1 X70 F100\nG0 Z50\nM2"), [("collision", 2)]);
}

#[test]
fn a_rapid_into_the_workpiece_is_told_though_a_cut_on_the_same_line_came_just_before() {
    // Every move of a subroutine file is on the call's line. Half a millimetre above the block is less than parts two contacts.
    let sub = "O<cut> sub\nM3 S1000 G1 Z-2 F100\nG0 Z0.5\nX20\nZ-2\nZ50\nO<cut> endsub\n";
    let folder = folder_of(MILL, "G0 Z5\nO<cut> call\nM2\n");
    folder.write("cut.ngc", sub);
    let scene = Scene::load(folder.root()).unwrap();
    let told: Vec<_> = run_own(&scene, &with_zones(&[])).events.iter().map(|e| (e.kind.name(), e.first.line)).collect();
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

#[test]
fn a_cutter_wholly_inside_a_finished_part_is_told() {
    // Tool 2 is a ball 60 mm below the nose: at Z 50 it is in the middle of the block, its surface 7 mm below the top.
    let text = mill_with_tools()
        .replace("[0, 0, -20]", "[0, 0, -60]")
        .replace("{ kind = \"cylinder\", radius_mm = 5, height_mm = 50 }", "{ kind = \"sphere\", radius_mm = 3 }");
    let text = format!("{text}gouge_mm = 0.1\n");
    let told = |program: &str| {
        let scene = scene_of(&text, program);
        run_own(&scene, &with_zones(&[])).events
    };
    let found = told("T2 M6\nG1 X30 F1000\nG0 X-30\nM2");
    let [event] = &found[..] else { panic!("{found:?}") };
    assert_eq!((event.kind, event.first.line, event.inside), (Kind::ToolChangeIntoWorkpiece, 1, true));
    assert!((event.least_mm + 7.0).abs() < 0.2, "{event:?}");
    // The ball's lowest point comes to Z 0 of the block where the nose is at Z 63.
    let found = told("G0 Z70\nT2 M6\nG1 Z50 F1000\nG1 X30\nM2");
    let [event] = &found[..] else { panic!("{found:?}") };
    assert_eq!((event.kind, event.first.line, event.last.line, event.inside), (Kind::Gouge, 3, 4, true));
}

#[test]
fn a_needle_that_goes_into_a_finished_part_is_told_wherever_it_does() {
    let part = MILL.replace("radius_mm = 5,", "radius_mm = 0.05,");
    let part = format!("{part}gouge_mm = 0.02\n");
    for (way, kind) in [("G1 Z-5 F1000", "gouge"), ("G0 Z-5", "rapid-into-workpiece")] {
        let places = [-23.29, -7.71, 3.13, 13.37, 31.07];
        let program: String = places.iter().map(|x| format!("G0 X{x}\n{way}\nG0 Z5\n")).collect();
        let expected: Vec<_> = (1..=5).map(|k| (kind, 3 * k)).collect();
        assert_eq!(told_by(&part, &format!("G0 Z5\n{program}M2")), expected);
    }
    // Where its radius is no more than 0.05 mm above what it may go deep it is named: of the two parts after the block it is the second.
    for (radius_mm, allowed_mm, thin) in [(0.05, 0.02, &[2][..]), (0.05, 0.06, &[2]), (0.08, 0.02, &[])] {
        let part = part.replace("radius_mm = 0.05", &format!("radius_mm = {radius_mm}"));
        let scene = scene_of(&part.replace("gouge_mm = 0.02", &format!("gouge_mm = {allowed_mm}")), "G0 Z5\nM2");
        assert_eq!(run_own(&scene, &Settings::standard()).thin_cutters, thin);
    }
    // With its middle inside, 30 mm long, it is told all the same; the surface is 0.05 mm in it.
    let scene = scene_of(&part.replace("gouge_mm = 0.02", "gouge_mm = 0.06"), "G0 Z5\nG1 Z-18 F1000\nM2");
    let found = run_own(&scene, &Settings::standard()).events;
    assert!(found.iter().any(|event| event.kind == Kind::Gouge && event.least_mm < -0.04), "{found:?}");
}

/// A blade of 20 mm across the spindle's axis, beside a clamp that is 5 mm from the axis's way.
fn fly_cutter(of_program: &str) -> String {
    format!(
        r#"
title = "fly cutter"
machine.links = [{{ name = "head", joint = {{ axis = "X", direction = [1, 0, 0] }} }}]
parts = [
  {{ name = "clamp", role = "fixture", at = {{ xyz_mm = [50, 15, 0] }}, shape = {{ kind = "rounded-box", size_mm = [20, 20, 20] }} }},
  {{ name = "post", role = "fixture", at = {{ xyz_mm = [115, 45, 0] }}, shape = {{ kind = "rounded-box", size_mm = [10, 10, 10] }} }},
  {{ name = "ram", link = "head", at = {{ xyz_mm = [0, 40, 0] }}, shape = {{ kind = "rounded-box", size_mm = [10, 10, 10] }} }},
  {{ name = "fly", role = "cutter", link = "head", shape = {{ kind = "rounded-box", size_mm = [20, 2, 10] }} }},
]
[program]
file = "own.ngc"
{of_program}
"#
    )
}

#[test]
fn a_cutter_that_is_not_round_is_at_every_angle() {
    let tip = "tool_centre_point = { tool_link = \"head\", gauge_mm = [0, 0, 0] }";
    let turning = "M3 S1000\nG1 X100 F500\nM2";
    let found = outcome_of(&fly_cutter(tip), turning);
    let [event] = &found.events[..] else { panic!("{:?}", found.events) };
    assert_eq!((event.kind, event.first.line, found.is_clear()), (Kind::Unresolved, 2, false));
    // The circle of 10 mm, by its corners a little more, meets the clamp's corner at (40, 5), 8.66 mm before it.
    let expected = 40.0 - (101_f64 - 25.0).sqrt();
    assert!((event.first.position.0[0] - expected).abs() < 0.05, "{:?}", event.first);
    assert!(found.as_drawn.is_empty());
    // With a standing spindle it is as drawn, 4 mm beside the clamp.
    assert!(outcome_of(&fly_cutter(tip), "G1 X100 F500\nM2").is_clear());
    // Where its axis is not known, that is told.
    let found = outcome_of(&fly_cutter(""), turning);
    assert_eq!((found.is_clear(), found.as_drawn), (true, vec![3]));
}

/// A jaw that a drive moves on the spindle turns with the chuck, within whose rings it is.
#[test]
fn what_turns_together_does_not_meet_by_turning() {
    let text = r#"
title = "A chuck with a driven jaw"
machine.links = [
  { name = "spindle", joint = { axis = "C", direction = [0, 0, 1] } },
  { name = "drive", parent = "spindle", joint = { axis = "U", direction = [1, 0, 0] } },
  { name = "carriage", joint = { axis = "X", direction = [1, 0, 0] } },
]
parts = [
  { name = "bar", role = "workpiece", link = "spindle", shape = { kind = "cylinder", radius_mm = 10, height_mm = 50 } },
  { name = "chuck", role = "fixture", link = "spindle", at = { xyz_mm = [0, 0, -20] }, shape = { kind = "rounded-box", size_mm = [100, 20, 20] } },
  { name = "jaw", role = "fixture", link = "drive", at = { xyz_mm = [0, 30, -20] }, shape = { kind = "rounded-box", size_mm = [10, 10, 10] } },
  { name = "insert", role = "cutter", link = "carriage", at = { xyz_mm = [120, 0, -20] }, shape = { kind = "rounded-box", size_mm = [10, 4, 10] } },
]
[program]
file = "own.ngc"
controller = "lathe"
"#;
    let found = outcome_of(text, "G7 M3 S100 G1 X-100 F200\nM2");
    assert!(found.is_clear(), "{:?}", found.events);
    assert_eq!(found.as_drawn, [2]);
    // X counts as a diameter: 20 mm nearer the insert meets the chuck's end, as drawn or not.
    let found = outcome_of(text, "G7 M3 S100 G1 X-150 F200\nM2");
    assert!(!found.is_clear());
}

#[test]
fn feeding_with_an_empty_spindle_is_told() {
    let text = MILL.replace("role = \"cutter\"", "role = \"cutter\", tool = 1");
    let empty = |program: &str| outcome_of(&text, program).tools_without_parts;
    assert_eq!(empty("M3 S1000 G0 X10\nG1 X20 F100\nM2"), [0]);
    assert!(empty("G0 X10\nT1 M6\nM3 S1000 G1 X20 F100\nM2").is_empty());
}

#[test]
fn a_tool_is_missed_where_no_part_is_of_a_tool() {
    let nose = MILL.replace("role = \"cutter\", ", "");
    let holder = MILL.replace("role = \"cutter\"", "role = \"holder\"");
    let no_workpiece = nose.replace("role = \"workpiece\", ", "");
    let (feed, change) = ("M3 S1000 G1 X20 F100\nM2", "T5 M6\nG0 X10\nM2");
    for (text, program, expected) in [
        (&nose, feed, &[0][..]),
        (&nose, change, &[5]),
        (&holder, feed, &[0]),
        (&holder, change, &[5]),
        (&no_workpiece, change, &[5]),
        // A press or a robot feeds without a spindle, and a machine alone may be jogged.
        (&nose, "G1 X20 F100\nM2", &[]),
        (&no_workpiece, feed, &[]),
        // A cutter without a number is there with every tool.
        (&MILL.to_owned(), feed, &[]),
        (&MILL.to_owned(), change, &[]),
    ] {
        let outcome = outcome_of(text, program);
        assert_eq!(
            (&outcome.tools_without_parts[..], outcome.is_clear()),
            (expected, expected.is_empty()),
            "{program}\n{text}"
        );
    }
}

#[test]
fn a_tool_is_there_only_while_it_is_in_the_spindle() {
    // The clamp reaches from X 60 to 80 and up to Z 20. At Z 25 tool 1 ends 5 above it, tool 2 at 25 - 20 = 5 within.
    let program = "G0 Z25\nG0 X70\nG0 X0\nT2 M6\nG0 X70\nG0 X0\nT1 M6\nG0 X70\nT2 M6\nT0 M6\nG0 X0\nM2";
    assert_eq!(told_by(&mill_with_tools(), program), [("collision", 5), ("collision", 9)]);
    let scene = scene_of(&mill_with_tools(), program);
    let outcome = run_own(&scene, &Settings::standard());
    let why = |a: &str, b: &str| {
        let of = |pair: Pair| [pair.a, pair.b].map(|part| scene.parts[part].name.as_str());
        let found = outcome.decisions.iter().find(|decision| of(decision.pair) == [a, b]).unwrap();
        found.dropped.as_ref().map(ToString::to_string)
    };
    assert_eq!(why("clamp", "long"), None);
    assert_eq!(why("block", "tip").unwrap(), "tool 3 is never in the spindle");
    assert!(outcome.tools_without_parts.is_empty());
    let strange = scene_of(&mill_with_tools(), "T2 M6\nG0 Z40\nT8 M6\nG0 X70\nM2");
    assert_eq!(run_own(&strange, &Settings::standard()).tools_without_parts, [8]);
    // A holder alone is not its tool; a tool of any other role, as a probe, is.
    for (role, expected) in [("holder", &[2][..]), ("machine", &[])] {
        let of_two = "role = \"cutter\", tool = 2";
        let text = mill_with_tools().replacen(of_two, &format!("role = \"{role}\", tool = 2"), 1);
        assert_eq!(outcome_of(&text, "T2 M6\nG0 X10\nM2").tools_without_parts, expected, "{role}");
    }
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
fn a_thin_wall_between_two_samples_is_not_jumped_over() {
    let scene = mill("G0 Z10\nG0 X140\nM2");
    let mut coarse = scene.program.clone().unwrap();
    coarse.sampling.step_mm = 500.0; // both samples of line 2 are far beside the clamp, which is 20 mm wide
    // The clamp's top is at 20; the cutter's lower end is at 10.
    let outcome = checked(&scene, &coarse, &with_zones(&[]));
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
fn a_dog_leg_is_one_in_a_plane_that_is_not_tilted_too() {
    // From X 0, Y 0 to X 100, Y 50, by way of X 50, Y 50 beside the clamp; the straight line passes it.
    let scene = r#"
title = "A clamp beside a rapid, over a table that turns"
machine.links = [
  { name = "x", joint = { axis = "X", direction = [1, 0, 0] } },
  { name = "y", parent = "x", joint = { axis = "Y", direction = [0, 1, 0] } },
  { name = "z", parent = "y", joint = { axis = "Z", direction = [0, 0, 1] } },
  { name = "a", joint = { axis = "A", direction = [-1, 0, 0] } },
  { name = "c", parent = "a", joint = { axis = "C", direction = [0, 0, -1] } },
]
parts = [
  { name = "ball", link = "z", role = "shank", shape = { kind = "sphere", radius_mm = 2 } },
  { name = "clamp", link = "c", role = "fixture", at = { xyz_mm = [50, 47, 5] }, shape = { kind = "sphere", radius_mm = 8 } },
]
[program]
file = "own.ngc"
[program.tool_centre_point]
tool_link = "z"
work_link = "c"
[check]
rapid = "dog-leg"
"#;
    for moves in ["G0 X100 Y50", "G81 X0 Y0 Z4 R5 F500\nX100 Y50\nG80"] {
        let told_in = |plane: &str| told_by(scene, &format!("G0 Z5\n{plane}\n{moves}\nM2"));
        let told = told_in("G4 P0\nG4 P0");
        assert_eq!(told.len(), 1, "{moves}: {told:?}");
        assert_eq!(told_in("G68.2 X0 Y0 Z0 I0 J0 K0\nG53.1"), told, "{moves}");
    }
}

#[test]
fn an_axis_at_the_limit_of_its_feed_holds_up_the_program() {
    // 40 mm of Z and 55 mm of X to the clamp at 100 mm/s: 0.95 s; with X at 50 mm/s at most 0.4 + 1.1 s.
    let time_s = |text: &str| {
        let scene = scene_of(text, "G1 Z10 F6000\nG1 X140\nM2");
        let outcome = run_own(&scene, &with_zones(&[]));
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
machine.links = [{{ name = "slide", joint = {{ axis = "X", direction = {direction} }} }}]
parts = [
  {{ name = "wall", at = {{ xyz_mm = [50, 0, 0] }}, shape = {{ kind = "sphere", radius_mm = 5 }} }},
  {{ name = "ball", link = "slide", shape = {{ kind = "sphere", radius_mm = 5 }} }},
]
[program]
file = "own.ngc"
"#
        )
    };
    for direction in ["[1, 0, 0]", "[1e200, 0, 0]", "[1e-200, 0, 0]", "[1e308, 1e-300, 0]", "[5e-324, 0, 0]"] {
        assert_eq!(told_by(&text(direction), "G0 X100\nM2"), [("collision", 1)], "{direction}");
    }
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
    assert_eq!(event.least_mm, -low);
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
    // Cells reach 0.011 mm above the top, so that all three moves may touch it.
    let touches = outcome_of(MILL, "G0 Z0\nG0 X20\nG0 Z50\nM2").touches;
    assert_eq!(touches.iter().map(|touch| (touch.line, touch.moves)).collect::<Vec<_>>(), [(1, 3)]);
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
fn cutting_ends_with_the_first_collision_when_asked() {
    // A slot in the block's middle, 4 mm deep, behind a rapid 2 mm into the block, or behind a way into the clamp.
    let slot = "G0 Z50\nG0 X-40\nG1 Z-4 F500\nX40\nG0 Z50\nM2";
    for (before, wanted) in
        [("G0 Z5\nG0 Z-2\n", (Kind::RapidIntoWorkpiece, 3)), ("G0 Z25\nG0 X70\nG0 Z15\n", (Kind::Collision, 4))]
    {
        let scene = scene_of(MILL, &format!("M3 S1000\n{before}{slot}"));
        let run = |stop_at_first: bool, is_solid: bool| {
            let mut outcome = run_own(&scene, &Settings { stop_at_first, is_solid, ..with_zones(&[]) });
            let told: Vec<_> = outcome.events.iter().map(|event| (event.kind, event.first.line)).collect();
            assert_eq!(told, [wanted], "{:?}", outcome.events);
            // In the slot, in the frame of the block, whose middle is at Z-10.
            outcome.remaining[0].stock.material_at(&nalgebra::Point3::new(30.0, 0.0, 8.0))
        };
        assert_eq!([run(false, false), run(true, false)], [Material::Gone, Material::Solid]);
        // What is left at the end is asked for.
        assert_eq!(run(true, true), Material::Gone);
    }
}

#[test]
fn contact_with_what_is_left_begins_no_earlier_than_with_the_uncut_workpiece() {
    // The holder's flat face, as wide as the block, is 4 mm above the tip: it meets the block's top at Z-4.
    let cutter = "{ kind = \"cylinder\", radius_mm = 2, height_mm = 4 } }";
    let holder = "{ name = \"holder\", link = \"head\", role = \"holder\", at = { xyz_mm = [0, 0, 4] }, shape = { kind = \"cylinder\", radius_mm = 50, height_mm = 3 } }";
    let text = MILL.replacen("size_mm = [100, 100, 20]", "size_mm = [100, 60, 20]", 1);
    let text = text.replacen("xyz_mm = [70, 0, 0]", "xyz_mm = [150, 0, 0]", 1);
    let old = "{ kind = \"cylinder\", radius_mm = 5, height_mm = 30 } }";
    let text = text.replacen(old, &format!("{cutter},\n  {holder}"), 1);
    let outcome = outcome_of(&text, "M3 S1000\nG0 Z5\nG1 Z-6 F333\nG1 Z5\nM2");
    let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
    assert_eq!((event.kind, event.first.line), (Kind::Collision, 3));
    let z = event.first.position.0[2];
    assert!((-4.3..=-4.0 + 1e-6).contains(&z), "{z}");
}

/// A block on X, a cube of 10 mm on U, 200 mm beside it at first, and a cutter of 20 mm on Z.
const TWO_WORKPIECES: &str = r#"
title = "two workpieces"
machine.links = [
  { name = "table", joint = { axis = "X", direction = [1, 0, 0] } },
  { name = "head", joint = { axis = "Z", direction = [0, 0, 1] } },
  { name = "second", joint = { axis = "U", direction = [1, 0, 0] } },
]
parts = [
  { name = "block", link = "table", role = "workpiece", shape = { kind = "rounded-box", size_mm = [80, 80, 50] } },
  { name = "cube", link = "second", role = "workpiece", shape = { kind = "rounded-box", size_mm = [10, 10, 10] } },
  { name = "cutter", link = "head", role = "cutter", shape = { kind = "cylinder", radius_mm = 10, height_mm = 60 } },
]
[program]
file = "own.ngc"
start = { z_mm = 100, u_mm = 200 }
"#;

#[test]
fn of_two_workpieces_each_is_what_the_program_leaves_of_it() {
    // A slot of 20 mm through the block, or down to the middle of the cube; a side of the cube away.
    let slot = |z: i32| format!("G0 X-80\nG0 Z{z}\nG1 X80 F1000\nG0 Z100\nG0 X0\n");
    let side = "G0 X-200\nG0 Z0\nG1 U14 F1000\nG0 U200\nG0 Z100\n";
    for (what, cuts, wanted) in [
        ("neither cut", "G0 X-80\nG0 Z-30\nG1 Z-31 F1000\nG0 Z100\nG0 X0\n".to_owned(), vec![(Kind::Collision, 8)]),
        ("through a slot", slot(-30), vec![]),
        ("into the floor of a slot", slot(0), vec![(Kind::Collision, 8)]),
        ("both cut, through a slot", side.to_owned() + &slot(-30), vec![]),
        ("both cut, into the floor of a slot", side.to_owned() + &slot(0), vec![(Kind::Unresolved, 13)]),
    ] {
        let scene = scene_of(TWO_WORKPIECES, &format!("G21 G90\nS3000 M3\n{cuts}G0 U42\nG0 U200\nM2"));
        let outcome = run_own(&scene, &Settings { cutting: Cutting::At(0.5), ..with_zones(&[]) });
        let told: Vec<_> = outcome.events.iter().map(|event| (event.kind, event.first.line)).collect();
        assert_eq!(told, wanted, "{what}: {:?}", outcome.events);
        let touches = outcome.touches.iter().filter(|touch| sorted(touch.pair) == [0, 1]).count();
        assert!(touches <= usize::from(!wanted.is_empty()), "{what}: {:?}", outcome.touches);
    }
}

#[test]
fn a_certain_contact_is_told_on_its_line_though_an_uncertain_one_goes_on_into_it() {
    // A slot down to Z-10, and all below Z-10 cut from the side: up through the film between the two on line 8, 1 mm into the wall on line 9.
    let program = "M3 S1000 G0 X-60\nG0 Z-10\nG1 X40 F1000\nG0 Z50\nG0 X-60\nG0 Z-40\nG1 X40\nG0 Z-15\nG0 X41\nG0 X40\nG0 Z50\nM2";
    let told: Vec<_> = outcome_of(MILL, program).events.iter().map(|e| (e.kind, e.first.line)).collect();
    assert_eq!(told, [(Kind::Unresolved, 8), (Kind::RapidIntoWorkpiece, 9)]);
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
    assert!((0.8..=1.0).contains(&low) && (1.0..=2.0 * low).contains(&high), "{low} {high}");
    // In a slot of 16 mm that was cut before it is free. A change of tools stops the spindle.
    let wide = text.replacen("radius_mm = 5, height_mm = 30", "radius_mm = 8, height_mm = 30", 1);
    let first = "T1 M6\nM3 S1000\nG0 Z-8\nG1 X10 F300\nG0 X-60\nT3 M6\nM3 S1000\n";
    assert_eq!(told(&wide, &feed(first)), []);
}

#[test]
fn a_stock_that_takes_too_much_work_is_unresolved() {
    // A turn of the helix is cut; then a rapid through the uncut block.
    let head = "  { name = \"head\",";
    let cross = r#"  { name = "cross", joint = { axis = "Y", direction = [0, 1, 0] } },"#;
    let text = MILL.replacen(head, &format!("{cross}\n{head} parent = \"cross\","), 1);
    let scene = scene_of(&text, "M3 S1000 G0 X-60\nG0 Z-2\nG3 I10 Z-4 F500\nG1 X-30\nG0 X40\nG0 Z50\nM2");
    let told = |stock_budget: u64| {
        let outcome = run_own(&scene, &Settings { stock_budget, ..with_zones(&[]) });
        let events: Vec<_> = outcome.events.iter().map(|e| (e.kind, e.first.line)).collect();
        (events, outcome.remaining[0].given_up, outcome.is_clear())
    };
    assert_eq!(told(Settings::standard().stock_budget), (vec![(Kind::RapidIntoWorkpiece, 5)], None, false));
    let (events, given_up, is_clear) = told(0);
    assert!(
        matches!(events[..], [(Kind::Unresolved, _)]) && given_up.is_some() && !is_clear,
        "{events:?} {given_up:?}"
    );
    // Given up at the first place, and unresolved from there on.
    let outcome = run_own(&scene, &Settings { stock_budget: 0, ..Settings::standard() });
    assert!(outcome.events.iter().any(|event| event.kind == Kind::Unresolved && event.first.place < 1.0));
    assert_eq!(outcome.remaining[0].given_up, Some(1));
}

#[test]
fn a_finer_resolution_decides_what_a_coarse_one_leaves_open() {
    // 0.15 mm into the floor of a slot.
    let program = "M3 S1000 G0 X-60\nG0 Z-2\nG1 X40 F500\nG0 X-60\nG0 Z-2.15\nG0 X40\nG0 Z50\nM2";
    let scene = mill(program);
    let told = |resolution_mm: f64| {
        let cutting = Cutting::At(resolution_mm);
        let outcome = run_own(&scene, &Settings { cutting, ..with_zones(&[]) });
        (outcome.events.iter().map(|e| (e.kind, e.first.line)).collect::<Vec<_>>(), outcome.touches.len())
    };
    assert_eq!(told(0.02).0, [(Kind::RapidIntoWorkpiece, 6)]);
    let (events, touches) = told(1.0);
    assert!(events.is_empty() && touches == 1, "{events:?} {touches}");
}

#[test]
fn a_part_wholly_inside_another_collides() {
    // The cutter, 30 mm long, fits into the clamp, which reaches from -20 to 20 and is 20 mm wide.
    let scene = mill("G0 X140\nG0 Z-15\nG1 X70 F1000\nG4 P1\nG1 X140\nM2");
    for zones_mm in [vec![], vec![14.0, 0.5]] {
        let outcome = run_own(&scene, &with_zones(&zones_mm));
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
    let scene = mill_from("start = { x_mm = 70, z_mm = -15 }", "pairs = [[\"clamp\", \"cutter\"]]", "G1 X69 F1000\nM2");
    let outcome = run_own(&scene, &with_zones(&[]));
    assert_eq!(outcome.events.len(), 1);
    assert!(outcome.events[0].inside && outcome.events[0].to_the_end && outcome.events[0].first.line == 0);
}

#[test]
fn contact_before_the_first_move_is_told_whether_or_not_the_scene_names_the_pair() {
    let program = "G1 X60 F1000\nG1 X40\nG1 X60\nM2"; // out of the clamp at X 55, and in again
    let start = "start = { x_mm = 70, z_mm = 0 }";
    for pairs in ["", "pairs = [[\"clamp\", \"cutter\"]]"] {
        let scene = mill_from(start, pairs, program);
        let outcome = run_own(&scene, &with_zones(&[]));
        let with_clamp = outcome.events.iter().filter(|event| scene.pair_name(event.pair).contains("clamp"));
        assert_eq!(with_clamp.map(|event| event.first.line).collect::<Vec<_>>(), [0, 3], "{pairs}");
    }
    // Cutter in the workpiece before the first move, a feed: nobody knows how it came there.
    let scene = mill_from("start = { z_mm = -5 }", "", "M3 S1000 G1 X20 F100\nG0 Z50\nM2");
    let outcome = run_own(&scene, &with_zones(&[]));
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
    let post = MILL.replace("name = \"clamp\", link = \"table\"", "name = \"clamp\"");
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
    // An arc of 41 steps is one event.
    let arc = "G0 X-20\nG0 Z5\nG1 Z-2 F100\nG18 G2 X20 Z-2 R100\nG0 Z50\nM2";
    assert_eq!(told(arc), [(stopped, 3), (stopped, 4)]);
    // The same where the workpiece stays whole; the program is within it all the way from line 2.
    let scene = mill("G0 Z5\nG1 Z-2 F100\nX20\nG0 Z50\nM2");
    let outcome = run_own(&scene, &Settings { cutting: Cutting::Never, ..with_zones(&[]) });
    let lines = |event: &Event| [event.first.line, event.nearest.line, event.last.line];
    let told: Vec<_> = outcome.events.iter().map(|event| (event.kind.name(), lines(event))).collect();
    assert_eq!(told, [(stopped, [2; 3]), (stopped, [3; 3])]);
}

#[test]
fn a_zone_entered_and_left_between_two_samples_is_told() {
    // Past the clamp's edge, parallel to Y, 1.5 mm from the cutter's side: there is no Y axis, so past its top in X.
    let scene = mill("G0 Z21.5\nG0 X140\nM2");
    let mut coarse = scene.program.clone().unwrap();
    coarse.sampling.step_mm = 500.0;
    let outcome = checked(&scene, &coarse, &with_zones(&[30.0, 2.0]));
    let clamp = outcome.events.iter().filter(|event| scene.pair_name(event.pair).contains("clamp"));
    let near: Vec<_> = clamp.map(|event| (event.kind, event.first.line, (10.0 * event.least_mm).round())).collect();
    assert_eq!(near, [(Kind::Near { zone_mm: 30.0 }, 2, 15.0), (Kind::Near { zone_mm: 2.0 }, 2, 15.0)]);
}

#[test]
fn a_zone_left_and_entered_again_within_two_samples_is_two_events() {
    // 10 mm beside the clamp, whose top is at 20: 14 mm away at Z 29.8, two thirds of the way up to 40, where it is free.
    let scene = mill("G0 X45\nG0 Z10\nG0 Z40\nG0 Z10\nG0 Z40\nM2");
    let mut coarse = scene.program.clone().unwrap();
    coarse.sampling.step_mm = 500.0;
    let outcome = checked(&scene, &coarse, &with_zones(&[14.0]));
    let near = outcome.events.iter().filter(|event| scene.pair_name(event.pair).contains("clamp"));
    assert_eq!(near.map(|event| (event.first.line, event.last.line)).collect::<Vec<_>>(), [(2, 3), (4, 5)]);
}

#[test]
fn an_axis_that_the_machine_lacks_may_be_named_where_it_stays() {
    assert_eq!(told("G0 Z20 Y0 A0\nG28 Y0\nM2"), []);
}

#[test]
fn what_an_arc_may_take_away_between_its_chords_is_not_left_for_sure() {
    // Every straight move is one sample, the arc two, half a millimetre from it.
    let scene = mill("M3 S1000 G0 X-20\nG0 Z5\nG1 Z-2 F500\nG18 G2 X20 Z-2 R100\nG0 Z50\nM2");
    let mut coarse = scene.program.clone().unwrap();
    (coarse.sampling.step_mm, coarse.sampling.chord_mm) = (500.0, 1.0);
    let mut outcome = checked(&scene, &coarse, &with_zones(&[]));
    assert_eq!(outcome.samples, 6);
    // The plunge goes straight on from a rapid, and is none.
    assert!(outcome.events.iter().all(|event| event.first.line > 3), "{:?}", outcome.events);
    // At X -10 the arc is at Z -3.52 and its chord at -3.01.
    let material = outcome.remaining[0].stock.material_at(&nalgebra::Point3::new(-10.0, 4.9, 6.7));
    assert_ne!(material, Material::Solid);
}

#[test]
fn a_turn_is_cut_in_pieces_fine_enough_to_go_back_at_rapid_rate() {
    let slide = "joint = { axis = \"X\", direction = [-1, 0, 0], min_mm = -200, max_mm = 200 }";
    let text = MILL.replacen(slide, "joint = { axis = \"C\", direction = [0, 0, 1] }", 1).replacen(
        "role = \"cutter\"",
        "role = \"cutter\", at = { xyz_mm = [30, 0, 0] }",
        1,
    );
    let program = "M3 S1000 G0 Z5\nG1 Z-2 F100\nG1 C90 F1000\nG0 C0\nG0 C-60\nG0 Z50\nM2";
    let scene = scene_of(&text, program);
    let mut coarse = scene.program.clone().unwrap();
    (coarse.sampling.step_mm, coarse.sampling.step_deg) = (500.0, 360.0);
    let outcome = checked(&scene, &coarse, &with_zones(&[]));
    // Back along the slot is free; on beyond its end is not.
    let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
    assert_eq!((event.kind, event.first.line), (Kind::RapidIntoWorkpiece, 5));
    assert!((-2.0..=0.0).contains(&event.first.position.0[5].to_degrees()), "{:?}", event.first);
}

#[test]
fn a_shank_is_asked_of_the_stock_only_where_it_touches_the_uncut_block() {
    let of_shank = |scene: &Scene, pair: Pair| scene.pair_name(pair) == "block:shank";
    // 5 mm deep in the side at X 0; at X 30 it passes 0.03 mm above the block, which cells of 0.45 mm cannot tell from touching.
    let program =
        "G0 Z5\nT3 M6\nM3 S1000 G0 X-60\nG0 Z-15\nG1 X0 F300\nG0 X-60\nG0 Z50\nG0 X30\nG1 Z-9.97 F100\nG0 Z50\nM2";
    let scene = scene_of(&mill_with_tools(), program);
    let outcome = run_own(&scene, &Settings { cutting: Cutting::At(1.0), ..with_zones(&[]) });
    let lines: Vec<_> = outcome.events.iter().filter(|e| of_shank(&scene, e.pair)).map(|e| e.first.line).collect();
    assert_eq!(lines, [5]);
    assert!(!outcome.touches.iter().any(|touch| of_shank(&scene, touch.pair)), "{:?}", outcome.touches);
    // How near it comes is told all the same: 1 mm.
    let scene = scene_of(&mill_with_tools(), "G0 Z5\nT3 M6\nM3 S1000 G1 Z-9 F100\nG0 Z50\nM2");
    let events = run_own(&scene, &with_zones(&[2.0])).events;
    assert!(events.iter().all(|event| of_shank(&scene, event.pair)), "{events:?}");
    assert_eq!(events.iter().map(|e| (e.kind, e.first.line)).collect::<Vec<_>>(), [(Kind::Near { zone_mm: 2.0 }, 3)]);
}
