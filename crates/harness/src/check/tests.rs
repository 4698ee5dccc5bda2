mod stock;
mod turning;

use super::event::{EventWriter, runs};
use super::motion::axes_s;
use super::scan::{Scan, Stretch};
use super::turning::{Turning, WorkAxis};
use super::{Bodies, Cutting, Event, Gouge, Kind, Outcome, Path, Settings, check, is_tool_and_workpiece};
use crate::geometry::Point;
use crate::measure::Silent;
use crate::registry;
use crate::scene::{Clearances, Overrides, Pair, Role, Scene};
use crate::stock::{Body, Material, Step, Stock};
use rs274::{Axis, MoveKind, Position, Sample};
use std::collections::BTreeMap;

/// A cube of 20 mm on a slide along Z that stands at 100 at first, over one that is fixed, both about their origins: they are Z - 20
/// apart. X slides it sideways. Rapids at 100 mm/s.
pub(super) const CUBES: &str = r#"
title = "Two cubes"
[[machine.links]]
name = "cross"
joint = { axis = "X", direction = [1, 0, 0] }
[[machine.links]]
name = "head"
parent = "cross"
joint = { axis = "Z", direction = [0, 0, 1] }
[[parts]]
name = "fixed"
shape = { kind = "extrude", height_mm = 20, outline_mm = [[-10, -10], [10, -10], [10, 10], [-10, 10]] }
at = { xyz_mm = [0, 0, -10] }
[[parts]]
name = "moved"
link = "head"
shape = { kind = "extrude", height_mm = 20, outline_mm = [[-10, -10], [10, -10], [10, 10], [-10, 10]] }
at = { xyz_mm = [0, 0, -10] }
[program]
file = "own.ngc"
start = { z_mm = 100 }
[check]
rapid_mm_min = 6000
"#;

/// [`CUBES`] with an axis Y and a tool of 10 mm whose tip may be led.
pub(super) fn with_tip() -> String {
    CUBES
        .replacen("name = \"cross\"\n", "name = \"side\"\njoint = { axis = \"Y\", direction = [0, 1, 0] }\n[[machine.links]]\nname = \"cross\"\nparent = \"side\"\n", 1)
        .replacen("[program]\n", "[program]\ntools = [{ number = 1, offset = { z_mm = 10 } }]\ntool_centre_point = { tool_link = \"head\" }\n", 1)
}

/// A tetrahedron of 10 mm without its base.
const OPEN: &str = "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

/// Programs of LinuxCNC's lathes give diameters, too.
pub(super) fn scene(text: &str, program: &str) -> Scene {
    let is_lathe = text.contains("controller = \"lathe\"") && !text.contains("dialect = ");
    let diameters = if is_lathe { "G7 " } else { "" };
    let program = format!("{diameters}{program}");
    let files = [("scene.toml", text), ("own.ngc", program.as_str()), ("open.obj", OPEN)];
    let files = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
    Scene::from_memory("cubes", BTreeMap::from(files), &Overrides::default()).unwrap()
}

fn checked(scene: &Scene, settings: &Settings) -> Outcome {
    let registry = registry::standard();
    check(scene, scene.program.as_ref().unwrap(), registry.fastest().unwrap(), &registry, settings, &Silent).unwrap()
}

fn with_zones(zones_mm: &[f64]) -> Settings {
    Settings { clearances: Some(Clearances::everywhere(zones_mm)), ..Settings::standard() }
}

#[test]
fn a_zone_begins_where_the_distance_says_however_many_samples_are_skipped() {
    // From 80 mm apart down to 5 in steps of 1 mm, and up again. Zones of 14 and 8 mm begin at Z 34 and Z 28.
    let scene = scene(CUBES, "G0 Z25\nG0 Z100\nM2");
    let outcome = checked(&scene, &with_zones(&[14.0, 8.0]));
    assert_eq!(outcome.events.len(), 2);
    for (event, zone_mm) in outcome.events.iter().zip([14.0, 8.0]) {
        assert_eq!(event.kind, Kind::Near { zone_mm });
        for (extent, line) in [(&event.first, 1), (&event.last, 2)] {
            assert_eq!(extent.line, line);
            assert!((extent.position[Axis::Z] - 20.0 - zone_mm).abs() < 0.02, "{extent:?}");
        }
        assert!((event.least_mm - 5.0).abs() < 1e-9 && event.nearest.position[Axis::Z] == 25.0);
        // At 100 mm/s down from 100, and up from 25 after 0.75 s.
        assert!((event.first.time_s - (80.0 - zone_mm) / 100.0).abs() < 1e-3);
        assert!((event.last.time_s - (0.75 + (zone_mm - 5.0) / 100.0)).abs() < 1e-3);
    }
    // Most of the 150 samples are skipped, though not those in a zone.
    assert_eq!(outcome.samples, 150);
    assert!((20..130).contains(&outcome.queries), "{}", outcome.queries);
}

#[test]
fn contact_is_found_where_it_begins_and_ends() {
    // Touching from Z 20 on. X does not matter there: the cubes are 20 mm wide and 5 mm aside.
    let outcome = checked(&scene(CUBES, "G0 X5\nG0 Z15\nG0 Z60\nM2"), &with_zones(&[]));
    let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
    assert_eq!((event.kind, event.first.line, event.last.line, event.least_mm), (Kind::Collision, 2, 3, 0.0));
    for extent in [&event.first, &event.last] {
        assert!((extent.position[Axis::Z] - 20.0).abs() < 0.02, "{extent:?}");
    }
    assert!(outcome.collides() && !event.to_the_end && !event.inside);
    // All of the contact has distance 0; the first place counts.
    assert_eq!(event.nearest, event.first);
    // 0.05 s aside, 0.85 s down, 0.45 s up.
    assert!((outcome.duration_s - 1.35).abs() < 1e-9);
    // That no spindle turns matters to a cutter in its workpiece alone.
    let fed = checked(&scene(CUBES, "G1 Z15 F6000\nG1 X2\nG0 Z60\nM2"), &with_zones(&[]));
    assert_eq!(fed.events.iter().map(|event| event.kind).collect::<Vec<_>>(), [Kind::Collision]);
}

#[test]
fn what_swings_past_a_post_between_two_of_its_samples_is_found() {
    // A cube of 4 mm that swings 100 mm from the axis, and a post where it is after an eighth of a turn: 1.7 mm a degree.
    let cube = "shape = { kind = \"rounded-box\", size_mm = [4, 4, 4] }\n";
    let text = [
        "title = \"Arm\"\n[[machine.links]]\nname = \"slide\"\njoint = { axis = \"Z\", direction = [0, 0, 1] }\n",
        "[[machine.links]]\nname = \"arm\"\nparent = \"slide\"\njoint = { axis = \"C\", direction = [0, 0, 1] }\n",
        "[[parts]]\nname = \"post\"\nat = { xyz_mm = [70.7, 70.7, 0] }\n",
        cube,
        "[[parts]]\nname = \"cube\"\nlink = \"arm\"\nat = { xyz_mm = [100, 0, 0] }\n",
        cube,
        "[program]\nfile = \"own.ngc\"\n",
    ]
    .concat();
    let outcome = checked(&scene(&text, "G0 C90\nM2"), &with_zones(&[]));
    let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
    // The two are 4 mm wide, and stand at an angle to each other at first: from 42 to 48 degrees they touch for sure, from 41 to 49 at most.
    for (extent, degrees) in [(&event.first, 42.0), (&event.last, 48.0)] {
        assert!((extent.position[Axis::C].to_degrees() - degrees).abs() < 1.0, "{extent:?}");
    }
}

/// A scene with a smaller moved part: 4 mm wide, and 8 mm high, from 2 to 10 mm below Z.
fn with_small_part(text: &str) -> String {
    let at = text.rfind("height_mm = 20, outline_mm = [[-10, -10], [10, -10], [10, 10], [-10, 10]]").unwrap();
    let outline = ["[[-10, -10], [10, -10], [10, 10], [-10, 10]]", "[[-2, -2], [2, -2], [2, 2], [-2, 2]]"];
    let small = text[at..].replacen("height_mm = 20", "height_mm = 8", 1).replacen(outline[0], outline[1], 1);
    format!("{}{small}", &text[..at])
}

#[test]
fn what_goes_wholly_into_another_part_is_told_as_inside() {
    let outcome = checked(&scene(&with_small_part(CUBES), "G0 Z5\nG0 Z60\nM2"), &with_zones(&[]));
    let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
    assert_eq!((event.kind, event.inside, event.least_mm), (Kind::Collision, true, 0.0));
    assert!([&event.first, &event.last].iter().all(|end| (end.position[Axis::Z] - 20.0).abs() < 0.02), "{event:?}");
    // Also where the surfaces never meet.
    let within = with_small_part(CUBES).replace("z_mm = 100", "z_mm = 5");
    let outcome = checked(&scene(&within, "G0 Z6\nM2"), &with_zones(&[]));
    let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
    assert_eq!((event.kind, event.inside, event.least_mm, event.first.place), (Kind::Collision, true, 0.0, 0.0));
}

#[test]
fn a_cutter_within_a_finished_workpiece_is_as_deep_as_the_next_surface_is_far() {
    // At Z 6 the small cutter is from 4 mm below to 4 mm above the middle of the cube, 6 mm from its upper and lower faces. Where it cuts the
    // surface it is 2.83 mm deep, half its diagonal.
    let feed = "M3 S1000\nG1 Z5 F6000\nG1 Z60\nM2";
    let mut scene = scene(&with_small_part(&with_cutter()), feed);
    for allowed_mm in [0.1, 0.5] {
        scene.gouge_mm = Some(allowed_mm);
        let outcome = checked(&scene, &with_zones(&[]));
        let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
        assert_eq!((event.kind, event.inside, event.first.line, event.last.line), (Kind::Gouge, true, 2, 3));
        assert!((event.least_mm + 6.0).abs() < 0.05 && event.nearest.position[Axis::Z] == 6.0, "{event:?}");
    }
}

#[test]
fn a_feed_through_a_fin_between_two_samples_is_a_gouge() {
    // 0.3 mm thick, and a pin of 0.5 mm; 10.5 mm away at first, with samples 1 mm apart: 0.5 mm in front of the fin and behind it.
    let text = r#"
title = "Fin"
[[machine.links]]
name = "slide"
joint = { axis = "X", direction = [1, 0, 0] }
[[machine.links]]
name = "table"
joint = { axis = "B", direction = [0, 1, 0], point_mm = [0, 0, -100] }
[[parts]]
name = "fin"
link = "table"
role = "workpiece"
shape = { kind = "rounded-box", size_mm = [0.3, 20, 20] }
[[parts]]
name = "pin"
link = "slide"
role = "cutter"
shape = { kind = "cylinder", radius_mm = 0.25, height_mm = 40 }
[program]
file = "own.ngc"
start = { x_mm = -10.5 }
[check]
gouge_mm = 0.05
"#;
    for (program, line) in [
        ("M3 S1000\nG1 X10.5 F1000\nG0 X20\nM2", Some(2)),
        ("M3 S1000\nG1 X-0.42 F1000\nG0 X-20\nM2", None),
        // The fin swings past the pin: 10.5 mm are 5 degrees of it at 120 mm.
        ("M3 S1000\nG1 B-10 F1000\nM2", Some(2)),
    ] {
        let told = checked(&scene(text, program), &with_zones(&[]));
        let found: Vec<_> = told.events.iter().map(|event| (event.kind, event.first.line)).collect();
        assert_eq!(found, Vec::from_iter(line.map(|line| (Kind::Gouge, line))), "{program}");
        // It gets as deep as its surface and the pin's axis allow.
        assert!(told.events.iter().all(|event| event.least_mm < -0.05), "{:?}", told.events);
    }
    // Also beside the middle of the two samples: a pin of 0.2 mm and a fin of 0.1 mm meet from 0.15 mm before its axis to 0.15 mm behind it, and samples are at -0.8
    // and 0.2 mm.
    let thin = [("0.3, 20", "0.1, 20"), ("0.25", "0.1"), ("-10.5", "-10.8"), ("gouge_mm = 0.05", "gouge_mm = 0.01")];
    let text = thin.iter().fold(text.to_owned(), |text, (from, to)| text.replace(from, to));
    let told = checked(&scene(&text, "M3 S1000\nG1 X10.2 F1000\nM2"), &with_zones(&[]));
    let [event] = &told.events[..] else { panic!("{:?}", told.events) };
    assert!(event.kind == Kind::Gouge && (event.first.position[Axis::X] + 0.14).abs() < 0.02, "{event:?}");
}

#[test]
fn a_rapid_may_not_even_touch_a_finished_workpiece() {
    for (program, told) in [
        ("M3 S1000\nG1 Z19.8 F6000\nG1 X2\nG0 Z60\nM2", None),
        ("M3 S1000\nG0 Z19.8\nG0 Z60\nM2", Some((Kind::RapidIntoWorkpiece, 2))),
        ("M3 S1000\nG1 Z19.2 F6000\nG0 Z60\nM2", Some((Kind::Gouge, 2))),
    ] {
        let mut scene = scene(&with_cutter(), program);
        scene.gouge_mm = Some(0.5);
        let outcome = checked(&scene, &with_zones(&[]));
        let found: Vec<_> = outcome.events.iter().map(|event| (event.kind, event.first.line)).collect();
        assert_eq!(found, Vec::from_iter(told), "{program}");
        let depth_mm = if told.is_some_and(|(kind, _)| kind == Kind::Gouge) { 0.8 } else { 0.2 };
        assert!(outcome.events.iter().all(|event| (event.least_mm + depth_mm).abs() < 0.05), "{:?}", outcome.events);
    }
}

/// [`CUBES`] as a workpiece and a cutter.
pub(super) fn with_cutter() -> String {
    let with_role = |text: &str, name: &str, role: &str| {
        let name = format!("name = \"{name}\"\n");
        text.replacen(&name, &format!("{name}role = \"{role}\"\n"), 1)
    };
    with_role(&with_role(CUBES, "fixed", "workpiece"), "moved", "cutter")
}

#[test]
fn parts_and_cutters_with_open_meshes_are_named() {
    let opened = |text: &str| {
        let from = text.rfind("shape = ").unwrap();
        let to = from + text[from..].find('\n').unwrap();
        format!("{}mesh = \"open.obj\"{}", &text[..from], &text[to..])
    };
    let named = |text: &str| {
        let told = checked(&scene(text, "M3 S1000\nG1 Z15 F500\nM2"), &with_zones(&[]));
        (told.open_parts, told.open_cutters)
    };
    assert_eq!([CUBES, &with_cutter()].map(named), [(vec![], vec![]), (vec![], vec![])]);
    assert_eq!(named(&opened(CUBES)), (vec![1], vec![]));
    assert_eq!(named(&opened(&with_cutter())).1, [1]);
}

#[test]
fn a_tool_in_use_needs_a_part_that_is_no_holder() {
    let of_tool = |role: &str, tool: u32| {
        let shape = "{ kind = \"cylinder\", radius_mm = 1, height_mm = 5 }";
        format!(
            "[[parts]]\nname = \"{role}-{tool}\"\nlink = \"head\"\nrole = \"{role}\"\ntool = {tool}\nshape = {shape}\n"
        )
    };
    let text = CUBES.replacen("[program]", &format!("{}{}[program]", of_tool("cutter", 1), of_tool("holder", 2)), 1);
    let missing = |program: &str| checked(&scene(&text, program), &with_zones(&[])).tools_without_parts;
    for (program, tools) in [
        ("T1 M6\nG1 Z90 F500\nM2", vec![]),
        ("T1 M6\nT2 M6\nG1 Z90 F500\nM2", vec![2]),
        ("G1 Z90 F500\nT1 M6\nG1 Z80\nM2", vec![0]),
        ("G0 Z90\nT1 M6\nG1 Z80 F500\nM2", vec![]),
    ] {
        assert_eq!(missing(program), tools, "{program}");
    }
    // Without any tool, a spindle that turns beside a workpiece tells that one is missing.
    let without = CUBES.replacen("name = \"fixed\"\n", "name = \"fixed\"\nrole = \"workpiece\"\n", 1);
    for (text, program, tools) in [
        (without.as_str(), "M3 S500\nG1 Z90 F500\nM2", vec![0]),
        (&without, "G1 Z90 F500\nM2", vec![]),
        (&without, "M3 S500\nG0 Z90\nM2", vec![]),
        (CUBES, "M3 S500\nG1 Z90 F500\nM2", vec![]),
    ] {
        assert_eq!(checked(&scene(text, program), &with_zones(&[])).tools_without_parts, tools, "{program}");
    }
}

#[test]
fn in_a_workpiece_that_stays_whole_a_standing_cutter_is_told_on_each_line_on_which_it_feeds() {
    // Inside from place 80 on, the spindle off from 85 to 89. Contact that begins in a feed move is meant, and the rapid is a retreat.
    let program = "M3 S1000\nG1 Z15 F6000\nM5\nG1 X2\nG1 X4\nM3 S500\nG1 X6\nG0 Z60\nM2";
    let settings = Settings { cutting: Cutting::Never, ..with_zones(&[]) };
    let told = checked(&scene(&with_cutter(), program), &settings);
    assert_eq!(told.events.len(), 2, "{:?}", told.events);
    for (event, line, from) in [(&told.events[0], 4, 85.0), (&told.events[1], 5, 87.0)] {
        assert_eq!((event.kind, event.first.line), (Kind::StoppedSpindleIntoWorkpiece, line));
        assert!((event.first.place - from).abs() < 1e-9 && event.first.place > from, "{event:?}");
        assert_eq!((event.last.place, event.nearest.place, event.least_mm), (from + 2.0, from + 1.0, 0.0));
    }
    assert!(told.stays_whole && !told.is_clear());
    let clear = checked(&scene(&with_cutter(), "M3 S1000\nG1 Z15 F6000\nG0 Z60\nM2"), &settings);
    assert!(clear.is_clear() && clear.stays_whole, "{:?}", clear.events);
    let rapid = checked(&scene(&with_cutter(), "M3 S1000\nG0 Z15\nG0 Z60\nM2"), &settings);
    assert_eq!(rapid.events.iter().map(|event| event.kind).collect::<Vec<_>>(), [Kind::RapidIntoWorkpiece]);
}

#[test]
fn a_probe_may_touch_the_workpiece_on_its_way_there_and_back_and_cuts_nothing() {
    let whole = Settings { cutting: Cutting::Never, ..with_zones(&[]) };
    for (settings, gouge_mm) in [(with_zones(&[]), None), (whole, None), (with_zones(&[]), Some(0.1))] {
        for (program, line) in [
            ("G38.2 Z15 F500\nG0 Z60\nM2", None),
            ("G38.2 Z15 F500\nG4 P1\nG1 Z17\nG38.2 Z14 F50\nG0 Z60\nM2", None),
            // Aside, with another tool, on beyond where the probe set out, and once it has left its way.
            ("G38.2 Z15 F500\nG0 X5\nG0 Z60\nM2", Some(2)),
            ("G38.2 Z15 F500\nT1 M6\nG0 Z60\nM2", Some(2)),
            ("G0 X40\nG0 Z10\nG38.2 X60 F500\nG0 X0\nM2", Some(4)),
            ("G38.2 Z15 F500\nG0 Z60\nG0 X50\nG0 Z15\nG0 X0\nM2", Some(5)),
            ("M3 S1000\nG38.2 Z15 F500\nG0 Z60\nG0 X1\nG0 Z18\nM2", Some(5)),
            // Forward again, from where the probe set out or from a place on its way, and with the spindle standing.
            ("G38.2 Z15 F500\nG0 Z60\nG0 Z15\nG0 Z60\nM2", Some(3)),
            ("G38.2 Z15 F500\nG0 Z18\nG0 Z15\nG0 Z60\nM2", Some(3)),
            ("G38.2 Z15 F500\nG0 Z60\nG1 Z15 F500\nG0 Z60\nM2", Some(3)),
            ("G38.2 Z15 F500\nG0 Z18\nG38.2 Z14 F50\nG0 Z60\nM2", None),
        ] {
            let mut scene = scene(&with_cutter(), program);
            scene.gouge_mm = gouge_mm;
            let told = checked(&scene, &settings);
            let first = told.events.first().map(|event| event.first.line);
            assert_eq!(first, line, "{program} {gouge_mm:?} {:?}", told.events);
        }
    }
}

#[test]
fn what_is_left_of_a_workpiece_that_no_cutter_comes_near_is_all_of_it() {
    let scene = scene(&with_cutter(), "M3 S1000\nG1 Z80 F6000\nM2");
    for (is_solid, count) in [(false, 0), (true, 1)] {
        let told = checked(&scene, &Settings { is_solid, ..with_zones(&[]) });
        assert!(told.is_clear() && told.remaining.len() == count, "{:?}", told.events);
        for volume in told.remaining.iter().map(|left| left.stock.clone().volume()) {
            assert!(volume.low <= 8000.0 && 8000.0 <= volume.high && volume.high - volume.low < 1000.0, "{volume:?}");
        }
    }
}

#[test]
fn contact_that_gets_deeper_is_told_where_it_is_deepest() {
    let told = checked(&scene(&with_cutter(), "G0 X50\nG0 Z19.7\nG0 X5\nG0 Z17\nG0 Z60\nM2"), &with_zones(&[]));
    let [event] = &told.events[..] else { panic!("{:?}", told.events) };
    assert_eq!((event.kind, event.first.line, event.nearest.line), (Kind::RapidIntoWorkpiece, 3, 4));
    assert!((event.least_mm + 3.0).abs() < 0.2, "{event:?}");
    // What is within the resolution is told once, with the number of its moves.
    let told = checked(&scene(&with_cutter(), "G0 X50\nG0 Z19.95\nG0 X5\nG0 X-5\nG0 X5\nG0 Z60\nM2"), &with_zones(&[]));
    let [touch] = &told.touches[..] else { panic!("{:?}", told.touches) };
    assert_eq!((touch.line, touch.moves, told.events.len()), (3, 4, 0));
}

#[test]
fn behind_the_first_cut_of_an_open_workpiece_nothing_is_certain() {
    let text = with_cutter();
    let (from, to) = (text.find("shape = ").unwrap(), text.find("at = ").unwrap());
    let text = format!("{}mesh = \"open.obj\"\n{}", &text[..from], &text[to..]);
    let told = |program: &str| {
        let told = checked(&scene(&text, program), &with_zones(&[]));
        told.events.iter().map(|event| (event.kind, event.first.line)).collect::<Vec<_>>()
    };
    let rapid = (Kind::RapidIntoWorkpiece, 2);
    let cut = [(Kind::Unresolved, 4), (Kind::Unresolved, 6), (Kind::Unresolved, 9)];
    let program = "M3 S1000\nG0 Z5\nG0 Z60\nG1 Z5 F5000\nG0 Z60\nG0 Z5\nG0 Z60\nM5\nG1 Z5\nM2";
    assert_eq!(told(program), [vec![rapid], cut.to_vec()].concat());
}

#[test]
fn of_two_workpieces_the_one_that_is_cut_first_decides_on_their_contact() {
    let with_role = |text: &str, name: &str| {
        let name = format!("name = \"{name}\"\n");
        text.replacen(&name, &format!("{name}role = \"workpiece\"\n"), 1)
    };
    // A mill of 15 mm whose lower end is 5 mm below the top of the lower workpiece, and which comes past the upper one.
    let arm = "[[machine.links]]\nname = \"arm\"\njoint = { axis = \"Y\", direction = [0, 1, 0] }\n";
    let mill = "[[parts]]\nname = \"mill\"\nlink = \"arm\"\nrole = \"cutter\"\nat = { xyz_mm = [0, -40, 5] }\nshape = { kind = \"cylinder\", radius_mm = 15, height_mm = 30 }\n";
    let text =
        with_role(&with_role(CUBES, "fixed"), "moved").replacen("[program]", &format!("{arm}{mill}[program]"), 1);
    // The upper one comes down to 1 mm above what is left.
    for (cut, is_clear) in [("M3 S1000\nG1 Y100 F6000\n", true), ("M3 S1000\nG0 Z120\n", false)] {
        let told = checked(&scene(&text, &format!("{cut}G0 Z16\nG0 Z60\nM2")), &with_zones(&[]));
        assert_eq!((told.remaining.len() == 2, told.is_clear()), (is_clear, is_clear), "{cut}: {:?}", told.events);
    }
}

#[test]
fn a_holder_that_comes_near_what_is_cut_is_told() {
    // 20 mm wide, and 25 mm above the cutter's lower end: 5 mm above the workpiece at Z 0.
    let holder = "[[parts]]\nname = \"holder\"\nlink = \"head\"\nrole = \"holder\"\nat = { xyz_mm = [0, 0, 15] }\nshape = { kind = \"cylinder\", radius_mm = 10, height_mm = 10 }\n";
    let text = with_cutter().replacen("[program]", &format!("{holder}[program]"), 1);
    let told = checked(&scene(&text, "M3 S1000\nG1 Z0 F6000\nG0 Z60\nM2"), &with_zones(&[8.0]));
    let [event] = &told.events[..] else { panic!("{:?}", told.events) };
    assert_eq!((event.kind, event.first.line, told.remaining.len()), (Kind::Near { zone_mm: 8.0 }, 2, 1));
    assert!((event.first.position[Axis::Z] - 3.0).abs() < 0.02 && (event.least_mm - 5.0).abs() < 1e-6, "{event:?}");
}

#[test]
fn the_search_ends_with_the_first_collision_when_asked() {
    let near = scene(CUBES, "G0 Z15\nG0 Z60\nG0 Z15\nG0 Z60\nM2");
    // More samples than are scanned before it is looked whether there is a collision among them.
    let far = scene(CUBES, "G0 Z15\nG0 Z60\nG0 X8200\nG0 X0\nG0 Z15\nM2");
    let lines = |scene: &Scene, stop_at_first| {
        let outcome = checked(scene, &Settings { stop_at_first, ..with_zones(&[]) });
        outcome.events.iter().map(|event| event.first.line).collect::<Vec<_>>()
    };
    assert_eq!((lines(&near, false), lines(&near, true)), (vec![1, 3], vec![1]));
    assert_eq!((lines(&far, false), lines(&far, true)), (vec![1, 5], vec![1]));
    // What is left is that after the whole program all the same: 5 mm less in height, and half of the cube 10 mm less again.
    let cut = scene(&with_cutter(), "G0 Z15\nG0 Z60\nM3 S1000\nG0 X10\nG1 Z5 F6000\nM2");
    for (stop_at_first, is_solid) in [(true, true), (false, true)] {
        let told = checked(&cut, &Settings { stop_at_first, is_solid, ..with_zones(&[]) });
        assert_eq!(told.events.iter().map(|event| event.first.line).collect::<Vec<_>>(), [1]);
        let volume = told.remaining[0].stock.clone().volume();
        assert!(volume.low <= 4000.0 && 4000.0 <= volume.high && volume.high - volume.low < 1500.0, "{volume:?}");
    }
}

#[test]
fn the_next_place_is_not_nearer_than_the_widest_zone() {
    let scene = scene(CUBES, "G0 Z25\nM2");
    let path = Path::new(&scene, scene.program.as_ref().unwrap()).unwrap();
    let (pair, registry) = (Pair { a: 0, b: 1 }, registry::standard());
    let variant = registry.fastest().unwrap();
    let bodies = Bodies::new(&scene, [variant, variant], &[pair]);
    let poses: Vec<_> = (0..=75).map(|at| scene.machine.forward(&path.position(at))).collect();
    // 60 mm apart at place 20, 80 - 60; each place is 1 mm of travel. 60 - 14 places are free for sure; two more are not.
    let borders = [1.0, 14.0];
    let mut scan = Scan::new(&scene, &path, &bodies, pair, &borders, 0.01);
    let here = scan.measure(20.0, &poses[20]);
    let (next, travel) = scan.farthest(20, 75, &here, &poses[20..]);
    assert!((65..=66).contains(&next), "{next}");
    assert!((travel - (next - 20) as f64).abs() < 1e-9, "{travel}");
    // Inside a zone it is the very next one.
    let near = scan.measure(70.0, &poses[70]);
    assert_eq!(scan.farthest(70, 75, &near, &poses[70..]).0, 71);
    assert_eq!((here.nearness, near.nearness, scan.queries), (3, 2, 2));
    // Half way between two places 10 mm from the other part the way left is half of d1 + d2 - travel: 10 mm of 20 gives 5.
    assert!(!scan.may_come_nearer(&near, &near, 17.9) && scan.may_come_nearer(&near, &near, 18.0 + 0.11));
    assert!(!scan.may_come_nearer(&here, &here, 92.0) && scan.may_come_nearer(&here, &here, 92.2));
    // 0.5 mm apart: half of 0.5 + 0.5 - travel.
    let mut position = Position::default();
    position[Axis::Z] = 20.5;
    let close = scan.measure(75.0, &scene.machine.forward(&position));
    assert_eq!(close.nearness, 1);
    assert!(!scan.may_come_nearer(&close, &close, 0.9) && scan.may_come_nearer(&close, &close, 1.1));
}

#[test]
fn the_way_takes_as_long_as_its_slowest_axis() {
    let sample = |x: f64, y: f64| {
        let mut position = Position::default();
        (position[Axis::X], position[Axis::Y]) = (x, y);
        Sample { position, line: 1, rapid: false, move_index: 0, fraction: 1.0 }
    };
    let mut rates = [f64::INFINITY; 9];
    (rates[0], rates[1]) = (1000.0, 100.0);
    // 100 mm of X take 0.1 min and 30 of Y 0.3: 18 s. Then 200 of X alone take 12 s more, and 5 of Y back 3 s.
    let samples = [sample(100.0, 30.0), sample(300.0, 30.0), sample(300.0, 25.0)];
    for (count, seconds) in [(0, 0.0), (1, 18.0), (2, 30.0), (3, 33.0)] {
        assert!((axes_s(&Position::default(), &samples[..count], &rates) - seconds).abs() < 1e-9, "{count}");
    }
}

#[test]
fn a_feed_takes_as_long_as_x_y_and_z_need_for_it() {
    let side = "name = \"side\"\njoint = { axis = \"U\", direction = [0, 1, 0] }\n[[machine.links]]\nname = \"cross\"\nparent = \"side\"\n";
    let text = CUBES.replacen("name = \"cross\"\n", side, 1);
    for (program, seconds) in [("G1 X100 U100 F100\nM2", 60.0), ("G1 U50 F100\nM2", 30.0)] {
        let scene = scene(&text, program);
        let path = Path::new(&scene, scene.program.as_ref().unwrap()).unwrap();
        assert!((path.duration_s() - seconds).abs() < 1e-9, "{program}: {}", path.duration_s());
    }
}

#[test]
fn times_and_fractions_along_a_program() {
    // 50 mm down at 100 mm/s; 2 s of rest; 20 mm at 10 mm/s, which X may; 30 mm at 5 mm/s, though 10 are asked for.
    let text = format!("{CUBES}feed_limits = {{ Z = 300 }}\n");
    let scene = scene(&text, "G0 Z50\nG4 P2\nG1 X20 F600\nG1 Z80\nM2");
    let path = Path::new(&scene, scene.program.as_ref().unwrap()).unwrap();
    assert!((path.duration_s() - (0.5 + 2.0 + 2.0 + 6.0)).abs() < 1e-9, "{}", path.duration_s());
    // Places: 50 samples of the rapid, one of the rest, 20, 30.
    assert_eq!(path.samples().len(), 101);
    for (place, line, fraction, time_s, [x, z]) in [
        (0.0, 1, 0.0, 0.0, [0.0, 100.0]),
        (0.5, 1, 0.01, 0.005, [0.0, 99.5]),
        (25.0, 1, 0.5, 0.25, [0.0, 75.0]),
        (50.0, 1, 1.0, 0.5, [0.0, 50.0]),
        (50.25, 2, 0.25, 1.0, [0.0, 50.0]),
        (51.5, 3, 0.025, 2.55, [0.5, 50.0]),
        (61.5, 3, 0.525, 3.55, [10.5, 50.0]),
        (101.0, 4, 1.0, 10.5, [20.0, 80.0]),
    ] {
        assert_eq!(path.sample_at(place).line, line, "{place}");
        assert!((path.fraction(place) - fraction).abs() < 1e-9, "{place}: {}", path.fraction(place));
        assert!((path.time_s(place) - time_s).abs() < 1e-9, "{place}: {}", path.time_s(place));
        let position = path.position_at(place);
        assert!((position[Axis::X] - x).abs() < 1e-9 && (position[Axis::Z] - z).abs() < 1e-9, "{place}");
    }
    assert!(matches!(path.step(50.5).kind, MoveKind::Dwell { .. }) && path.step(51.5).kind == MoveKind::Feed);
    assert_eq!((path.block(3), path.block(0), path.block(99)), ("G1 X20 F600", "", ""));
    assert_eq!(path.chord_mm(), 0.01);
}

#[test]
fn stretches_that_join_are_one_run() {
    let stretch = |nearness, from, to, least_mm, goes_on| {
        let (least_at, inside) = (to, nearness == 0);
        Stretch { nearness, from, to, least_mm, least_at, inside, goes_on }
    };
    let stretches = [
        stretch(2, 0.0, 1.0, 9.0, false),
        stretch(1, 1.0, 2.0, 3.0, true),
        stretch(0, 2.0, 3.0, 0.0, true),
        stretch(2, 3.0, 4.0, 8.0, true),
        // A chunk begins where the one before it ended.
        stretch(2, 4.0, 5.0, 7.0, false),
        // Free from 5 to 6.
        stretch(1, 6.0, 7.0, 4.0, false),
    ];
    let of =
        |nearness| runs(&stretches, nearness).iter().map(|run| (run.from, run.to, run.least_mm)).collect::<Vec<_>>();
    assert_eq!(of(2), [(0.0, 5.0, 0.0), (6.0, 7.0, 4.0)]);
    assert_eq!(of(1), [(1.0, 3.0, 0.0), (6.0, 7.0, 4.0)]);
    assert_eq!(of(0), [(2.0, 3.0, 0.0)]);
    let whole = runs(&stretches, 2);
    assert!(whole[0].inside && !whole[1].inside && whole[0].least_at == 3.0);
    // Of equal distances the first counts.
    let level = [stretch(1, 0.0, 1.0, 3.0, false), stretch(2, 1.0, 2.0, 3.0, true)];
    assert_eq!(runs(&level, 2)[0].least_at, 1.0);
    assert!(stretches[1].is_in(&whole[0]) && !stretches[5].is_in(&whole[0]) && !whole[0].is_in(&stretches[1]));
}

#[test]
fn only_nearness_is_no_collision() {
    let kinds = [
        Kind::Collision,
        Kind::RapidIntoWorkpiece,
        Kind::ToolChangeIntoWorkpiece,
        Kind::StoppedSpindleIntoWorkpiece,
        Kind::Gouge,
    ];
    let names =
        ["collision", "rapid-into-workpiece", "tool-change-into-workpiece", "stopped-spindle-into-workpiece", "gouge"];
    assert!(kinds.iter().map(Kind::name).eq(names) && Kind::Near { zone_mm: 2.0 }.name() == "near");
    assert!(kinds.iter().all(Kind::is_collision) && !Kind::Near { zone_mm: 2.0 }.is_collision());
    let mut settings = with_zones(&[14.0, 8.0]);
    let mut scene = scene(CUBES, "G0 Z25\nM2");
    assert_eq!(settings.distances(&scene, Pair { a: 0, b: 1 }).borders_mm, [1.0, 8.0, 14.0]);
    // A cutter that may go 0.25 mm deep touches where it may go 0.24 deeper; where it may go less than the tolerance, that is a gouge.
    scene.gouge_mm = Some(0.25);
    assert_eq!(settings.distances(&scene, Pair { a: 0, b: 1 }).borders_mm, [0.24, 1.0, 8.0, 14.0]);
    settings.tolerance_mm = 0.25;
    assert_eq!(settings.touching_mm(&scene), None);
}

#[test]
fn tools_and_workpieces_are_told_by_their_roles() {
    let mut scene = scene(CUBES, "G0 Z25\nM2");
    scene.gouge_mm = Some(0.1);
    for one in Role::ALL {
        for other in Role::ALL {
            (scene.parts[0].role, scene.parts[1].role) = (one, other);
            let is_tool = |role| [Role::Cutter, Role::Shank, Role::Holder].contains(&role);
            let wanted = (one == Role::Workpiece && is_tool(other)) || (is_tool(one) && other == Role::Workpiece);
            let pair = Pair { a: 0, b: 1 };
            assert_eq!(is_tool_and_workpiece(&scene, pair), wanted, "{one:?} {other:?}");
            let gouges = [one, other].contains(&Role::Cutter) && [one, other].contains(&Role::Workpiece);
            assert_eq!(Gouge::of(&scene, pair, &mut BTreeMap::new()).is_some(), gouges, "{one:?} {other:?}");
        }
    }
}

/// A rod of 4 mm in a cube of 20, and what is the cutter turns: where the rod is 5 mm in, the cube's surface is 2.83 mm deep in the turning rod, and
/// the rod's 5 mm in the turning cube.
#[test]
fn how_deep_a_cutter_goes_is_found_on_the_surface_of_the_workpiece() {
    let at = CUBES.rfind("outline_mm").unwrap();
    let rod =
        CUBES[at..].replacen("[[-10, -10], [10, -10], [10, 10], [-10, 10]]", "[[-2, -2], [2, -2], [2, 2], [-2, 2]]", 1);
    let mut scene = scene(&format!("{}{rod}", &CUBES[..at]), "G0 Z15\nM2");
    scene.gouge_mm = Some(0.1);
    let pair = Pair { a: 0, b: 1 };
    for (roles, depth) in [((Role::Workpiece, Role::Cutter), 8_f64.sqrt()), ((Role::Cutter, Role::Workpiece), 5.0)] {
        (scene.parts[0].role, scene.parts[1].role) = roles;
        let gouge = Gouge::of(&scene, pair, &mut BTreeMap::new()).unwrap();
        let pose = |z: f64| {
            let mut position = Position::default();
            position[Axis::Z] = z;
            scene.a_from_b(pair, &scene.machine.forward(&position))
        };
        for (z, spare) in [(100.0, 20.0), (25.0, 5.1), (20.05, 0.15), (19.95, 0.05), (15.0, 0.1 - depth)] {
            let found = gouge.spare_mm(&pose(z), 20.0);
            assert!((found - spare).abs() < 0.06 * depth.min(spare.abs()).max(0.01), "{roles:?} {z}: {found}");
        }
        // The middle of either is in the other at Z 5, and in neither at Z 15.
        assert_eq!([15.0, 5.0].map(|z| gouge.is_inside(&pose(z))), [false, true], "{roles:?}");
    }
    // Where the rod is the cutter, nothing is deeper in it than 2.83 mm.
    (scene.parts[0].role, scene.parts[1].role) = (Role::Workpiece, Role::Cutter);
    let thin = [0.1, 3.0].map(|allowed_mm| {
        scene.gouge_mm = Some(allowed_mm);
        checked(&scene, &with_zones(&[])).thin_cutters
    });
    assert_eq!(thin, [vec![], vec![1]]);
}

#[test]
fn a_cutter_with_a_thin_blade_is_named_whatever_its_hub() {
    let at = CUBES.rfind("shape = ").unwrap();
    let to = CUBES.find("[program]").unwrap();
    // What is 0.05 mm deeper than allowed may be missed between samples: 0.3 mm is half of 0.6 mm.
    for (blade_mm, thin) in [(0.4, vec![1]), (0.59, vec![1]), (0.64, vec![])] {
        let profile = format!("[[0, 0], [30, 0], [30, {blade_mm}], [8, {blade_mm}], [8, 10], [0, 10]]");
        let saw = format!("shape = {{ kind = \"revolve\", profile_mm = {profile} }}\n");
        let mut scene = scene(&[&CUBES[..at], &saw, &CUBES[to..]].concat(), "G0 Z15\nM2");
        (scene.parts[0].role, scene.parts[1].role) = (Role::Workpiece, Role::Cutter);
        scene.gouge_mm = Some(0.25);
        assert_eq!(checked(&scene, &with_zones(&[])).thin_cutters, thin, "{blade_mm}");
    }
    // Also one that comes near only as the spindle turns it, and one that does as drawn, too.
    let text = with_tip();
    let (at, to) = (text.rfind("shape = ").unwrap(), text.find("[program]").unwrap());
    let beside = "[[390, -5], [410, -5], [410, 5], [390, 5]]";
    let above = "[[-410, -410], [410, -410], [410, 410], [-410, 410]]";
    for (outline, blade_mm, thin) in
        [(beside, 0.4, vec![1]), (beside, 0.64, vec![]), (above, 0.4, vec![1]), (above, 0.64, vec![])]
    {
        let blade = format!("shape = {{ kind = \"extrude\", height_mm = {blade_mm}, outline_mm = {outline} }}\n");
        let program = "M3 S1000\nG1 X400 F6000\nG1 Z9\nM2";
        let mut scene = scene(&[&text[..at], &blade, &text[to..]].concat(), program);
        (scene.parts[0].role, scene.parts[1].role) = (Role::Workpiece, Role::Cutter);
        scene.gouge_mm = Some(0.25);
        let told = checked(&scene, &with_zones(&[]));
        assert_eq!(told.thin_cutters, thin, "{blade_mm}");
        // Out of reach as drawn, it is examined all the same.
        assert!(told.decisions.iter().all(|decision| decision.dropped.is_none()), "{:?}", told.decisions);
    }
}

/// A bar of 50 x 4 mm passes a cube of 20 mm at 8 mm. Once it has turned by a quarter it would be in it.
#[test]
fn a_spindle_that_starts_or_is_oriented_between_moves_has_turned_what_it_holds() {
    let text = with_tip();
    let (at, to) = (text.rfind("shape = ").unwrap(), text.find("[program]").unwrap());
    let bar = "shape = { kind = \"extrude\", height_mm = 4, outline_mm = [[-25, -2], [25, -2], [25, 2], [-25, 2]] }\n";
    for (between, expected) in [
        ("", None),
        ("M3", None),
        ("S1000", None),
        ("M3 S1000\nM0\nM5", Some(Kind::Unresolved)),
        ("M3 S1000\nM5", Some(Kind::Unresolved)),
        ("M3 S0\nS1000\nM5", Some(Kind::Unresolved)),
        ("M3 S1000\nG4 P1\nM5", Some(Kind::Unresolved)),
        ("M19 R90", Some(Kind::Unresolved)),
    ] {
        let program = format!("G0 Y20\nG0 Z0\n{between}\nG0 Z100\nM2");
        let mut scene = scene(&[&text[..at], bar, &text[to..]].concat(), &program);
        (scene.parts[0].role, scene.parts[1].role) = (Role::Fixture, Role::Cutter);
        let told = checked(&scene, &with_zones(&[]));
        assert_eq!(told.events.first().map(|event| event.kind), expected, "{between}");
        assert_eq!(told.is_clear(), expected.is_none(), "{between}");
    }
}

/// A bar of 20 mm radius from 25 to 45 mm along a spindle at (3, 4, 100), and an insert of 4 x 2 x 4 mm. X is slanted; at X 12 the insert is from 11.77
/// to 15.77 mm beside the axis.
pub(super) const LATHE: &str = r#"
title = "A bar that turns"
[[machine.links]]
name = "carriage"
joint = { axis = "Z", direction = [0, 0, 1] }
[[machine.links]]
name = "slide"
parent = "carriage"
joint = { axis = "X", direction = [1, 0, 0.2] }
[[machine.links]]
name = "cross"
parent = "slide"
joint = { axis = "Y", direction = [0, 1, 0] }
[[machine.links]]
name = "spindle"
at = { xyz_mm = [3, 4, 100], rpy_deg = [0, 0, 30] }
joint = { axis = "C", direction = [0, 0, 1] }
[[machine.links]]
name = "chuck"
parent = "spindle"
at = { xyz_mm = [0, 0, 20] }
[[parts]]
name = "bar"
link = "chuck"
role = "workpiece"
at = { xyz_mm = [0, 0, 5] }
shape = { kind = "cylinder", radius_mm = 20, height_mm = 20 }
[[parts]]
name = "insert"
link = "cross"
role = "cutter"
at = { xyz_mm = [5, 4, 130] }
shape = { kind = "rounded-box", size_mm = [4, 2, 4] }
[program]
file = "own.ngc"
controller = "lathe"
start = { x_mm = 24 }
"#;

#[test]
fn the_axis_of_what_turns_is_found_wherever_it_lies() {
    let axis_of = |text: &str| {
        let scene = scene(text, "G0 X50\nM2");
        let path = Path::new(&scene, scene.program.as_ref().unwrap()).unwrap();
        WorkAxis::of(&scene, &path, 0)
    };
    let is_at = |axis: &WorkAxis, point: [f64; 3], z: f64| {
        (axis.axis_from_stock * Point::from(point) - Point::new(0.0, 0.0, z)).norm() < 1e-3
    };
    // The axis' frame stands at the spindle's point, 20 and 5 mm behind the bar.
    let axis = axis_of(LATHE).unwrap();
    assert!(is_at(&axis, [0.0; 3], 25.0) && is_at(&axis, [0.0, 0.0, 20.0], 45.0));
    // Without a joint it is that of the bar, here 7 mm beside x of its mesh.
    let bar = "at = { xyz_mm = [0, 0, 5] }\nshape = { kind = \"cylinder\", radius_mm = 20, height_mm = 20 }";
    let own = |shape: &str| {
        let part = format!("at = {{ xyz_mm = [0, 0, 5], rpy_deg = [0, -90, 0] }}\nshape = {shape}");
        axis_of(&LATHE.replacen("link = \"chuck\"\n", "", 1).replacen(bar, &part, 1))
    };
    let lying = r#"{ kind = "compound", parts = [{ shape = { kind = "cylinder", radius_mm = 20, height_mm = 30 }, at = { xyz_mm = [0, 7, 0], rpy_deg = [0, 90, 0] } }] }"#;
    let axis = own(lying).unwrap();
    assert!(is_at(&axis, [0.0, 7.0, 0.0], -15.0) && is_at(&axis, [30.0, 7.0, 0.0], 15.0));
    // A bore takes nothing from what is round, nor does a slot as wide as 10 degrees; half a tube is not round.
    let cylinder = "{ kind = \"cylinder\", radius_mm = 20, height_mm = 20 }";
    let is_round = |shape: &str| {
        let text = LATHE.replacen("link = \"chuck\"\n", "", 1).replacen(cylinder, shape, 1);
        axis_of(&text).is_some_and(|axis| is_at(&axis, [0.0; 3], 0.0))
    };
    let slotted = |slot_deg: f64| {
        let arc = |radius_mm: f64, k: u32| {
            let degrees = 0.5 * slot_deg + (360.0 - slot_deg) * f64::from(k) / 90.0;
            let (sin, cos) = degrees.to_radians().sin_cos();
            format!("[{:.6}, {:.6}]", radius_mm * cos, radius_mm * sin)
        };
        let corners: Vec<String> = (0..=90).map(|k| arc(20.0, k)).chain((0..=90).rev().map(|k| arc(12.0, k))).collect();
        format!("{{ kind = \"extrude\", height_mm = 60, outline_mm = [{}] }}", corners.join(", "))
    };
    let tube = "{ kind = \"revolve\", profile_mm = [[12, 0], [20, 0], [20, 60], [12, 60]] }";
    for (shape, expected) in [(tube, true), (slotted(10.0).as_str(), true), (slotted(180.0).as_str(), false)] {
        assert_eq!(is_round(shape), expected, "{shape}");
    }
    // What is not round, and the workpiece of a mill, have none.
    assert!(own("{ kind = \"rounded-box\", size_mm = [40, 40, 20] }").is_none());
    assert!(axis_of(&LATHE.replacen("controller = \"lathe\"\n", "", 1)).is_none());
}

/// The second part of a lathe beside the first, whose stock is a half section, and the axis of that.
fn turning_of(scene: &Scene) -> (Turning, WorkAxis) {
    let path = Path::new(scene, scene.program.as_ref().unwrap()).unwrap();
    let axis = WorkAxis::of(scene, &path, 0).unwrap();
    let body = Body::turning(&scene.parts[1].mesh, 0.0);
    (Turning::new(scene, &path, &axis, true, 1, &body), axis)
}

#[test]
fn a_tool_beside_the_axis_is_as_deep_as_its_section_up_to_what_is_not_known() {
    let piece = |scene: &Scene, turning: &Turning, x: f64, y: [f64; 2], z: [f64; 2]| {
        let [from, to] = [0, 1].map(|k| Position([x, y[k], z[k], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        turning.to_base.piece(&scene.machine, &from, &to, 0, 1)
    };
    let depth_of = |scene: &Scene, x: f64, y: [f64; 2], z: [f64; 2], chord_mm: f64| {
        let (turning, axis) = turning_of(scene);
        let mut stock = Stock::turned(&scene.parts[0].mesh, axis.axis_from_stock, 0.1).unwrap();
        let examined = vec![turning.sweep(&piece(scene, &turning, x, y, z), chord_mm)];
        let depth = stock.run(&[Step { examined, cutting: Vec::new() }], 0.01)[0].depth;
        (depth.low, depth.high)
    };
    let plain = scene(LATHE, "G0 X50\nM2");
    // A ring of 4 mm around the bar, 5 mm of it in the bar.
    let (from, to) = (LATHE.rfind("role = ").unwrap(), LATHE.find("[program]").unwrap());
    let ring = "role = \"holder\"\nat = { xyz_mm = [3, 4, 130] }\nshape = { kind = \"revolve\", profile_mm = [[15, 0], [30, 0], [30, 4], [15, 4]] }\n";
    let around = scene(&[&LATHE[..from], ring, &LATHE[to..].replace("x_mm = 24", "x_mm = 0")].concat(), "G0 X50\nM2");
    // The middle of the section is 2 mm deep. Beside the plane half the way across is not known, nor is a chord's distance.
    for (scene, x, y, z, pad) in [
        (&plain, 12.0, [0.0, 0.0], [0.0, 1.0], 0.3),
        (&plain, 12.0, [0.5, 0.9], [0.0, 0.0], 0.5),
        (&around, 0.0, [0.0, 0.0], [0.0, 1.0], 0.3),
    ] {
        let (low, high) = depth_of(scene, x, y, z, 0.3);
        assert!((1.75 - pad..=2.0 - pad + 1e-5).contains(&low), "{x} {y:?}: {low}");
        assert!((2.0 + pad - 1e-5..=2.25 + pad).contains(&high), "{x} {y:?}: {high}");
    }
    assert!((turning_of(&plain).0.deepest_mm(0.1) - 2.0).abs() < 0.05, "{}", turning_of(&plain).0.deepest_mm(0.1));
    // In the middle of this way the insert is beside the plane: nothing is certain.
    let (low, high) = depth_of(&plain, 12.0, [0.9, 1.3], [0.0, 0.0], 0.0);
    assert!(low == 0.0 && high > 0.1, "{low} {high}");
    // What it takes away is known wherever it stays beside the axis, and not where it goes across.
    let (turning, _) = turning_of(&plain);
    let is_known = |y: [f64; 2], z: [f64; 2]| !turning.cut(&piece(&plain, &turning, 12.0, y, z), 0.0).is_vague();
    assert!(is_known([0.0, 0.0], [0.0, 1.0]) && is_known([0.5, 0.5], [0.0, 1.0]));
    assert!(!is_known([0.0, 0.4], [0.0, 0.0]));
}

#[test]
fn only_under_standing_tools_and_where_no_solid_is_wanted_the_stock_is_a_half_section() {
    let stock_of = |text: &str, cutting: Cutting, is_solid: bool| {
        let outcome = checked(&scene(text, "G1 X50 F100\nM2"), &Settings { cutting, is_solid, ..Settings::standard() });
        let stock = &outcome.remaining[0].stock;
        // Tiles of the half section, 20 x 20 mm, are smaller than those of the bar, 40 mm wide.
        (stock.resolution_mm(), stock.tile_mm() < 4.0)
    };
    let standing = "at = { xyz_mm = [5, 4, 130] }\nshape = { kind = \"rounded-box\", size_mm = [4, 2, 4] }";
    let driven = "at = { xyz_mm = [5, 4, 130], rpy_deg = [0, 90, 0] }\nshape = { kind = \"cylinder\", radius_mm = 3, height_mm = 10 }";
    let driven = LATHE.replacen(standing, driven, 1);
    let cylinder = "{ kind = \"cylinder\", radius_mm = 20, height_mm = 20 }";
    let tube = "{ kind = \"revolve\", profile_mm = [[12, 0], [20, 0], [20, 20], [12, 20]] }";
    assert_eq!(stock_of(&LATHE.replacen(cylinder, tube, 1), Cutting::Standard, false), (0.1, true));
    for (cutting, is_solid, stands, turns) in [
        (Cutting::Standard, false, (0.1, true), (0.5, false)),
        (Cutting::Standard, true, (0.1, false), (0.1, false)),
        (Cutting::At(0.2), false, (0.2, true), (0.2, false)),
    ] {
        let found = (stock_of(LATHE, cutting, is_solid), stock_of(&driven, cutting, is_solid));
        assert_eq!(found, (stands, turns), "{cutting:?} {is_solid}");
    }
}

/// What is told of the two cubes where they are as near as this.
fn told(scene: &Scene, zones_mm: &[f64], stretches: &[Stretch]) -> Vec<Event> {
    let path = Path::new(scene, scene.program.as_ref().unwrap()).unwrap();
    let (pairs, settings) = ([Pair { a: 0, b: 1 }], with_zones(zones_mm));
    let distances = [settings.distances(scene, pairs[0])];
    let (is_stock, stays_whole) = (|_: Pair| false, |_: Pair| false);
    let writer = EventWriter {
        scene,
        path: &path,
        pairs: &pairs,
        distances: &distances,
        is_stock: &is_stock,
        stays_whole: &stays_whole,
    };
    writer.events(&[vec![stretches.to_vec()]], &[], &settings)
}

fn part(nearness: usize, [from, to]: [f64; 2], least_mm: f64) -> Stretch {
    Stretch { nearness, from, to, least_mm, least_at: to, inside: false, goes_on: true }
}

#[test]
fn contacts_on_a_line_that_hardly_part_are_one() {
    // The one border is 1 mm, so that places 10 to 18 are one episode.
    let scene = scene(CUBES, "G0 Z25\nM2");
    let mut parts = [
        part(0, [10.0, 12.0], 0.5),
        part(1, [12.0, 14.0], 0.7),
        part(0, [14.0, 16.0], 0.2),
        part(1, [16.0, 17.0], 0.7),
        part(0, [17.0, 18.0], 0.2),
        part(0, [20.0, 22.0], 0.0),
    ];
    (parts[2].inside, parts[5].goes_on) = (true, false);
    let told = told(&scene, &[], &parts);
    let told: Vec<_> =
        told.iter().map(|e| (e.first.place, e.last.place, e.least_mm, e.nearest.place, e.inside)).collect();
    assert_eq!(told, [(10.0, 18.0, 0.2, 16.0, true), (20.0, 22.0, 0.0, 22.0, false)]);
}

#[test]
fn what_begins_together_is_told_from_the_widest_zone_to_contact() {
    let scene = scene(CUBES, "G0 Z25\nM2");
    let told = told(&scene, &[14.0, 8.0], &[part(0, [0.0, 5.0], 0.0)]);
    let kinds: Vec<_> = told.iter().map(|event| event.kind).collect();
    assert_eq!(kinds, [Kind::Near { zone_mm: 14.0 }, Kind::Near { zone_mm: 8.0 }, Kind::Collision]);
    assert!(told.iter().all(|event| !event.first.rapid && event.last.rapid));
}

#[test]
fn contact_of_a_cutter_hangs_on_where_it_begins() {
    let told = |gouge_mm, program: &str, stretches: &[Stretch]| {
        let mut scene = scene(CUBES, program);
        (scene.parts[0].role, scene.parts[1].role) = (Role::Workpiece, Role::Cutter);
        scene.gouge_mm = gouge_mm;
        told(&scene, &[], stretches).iter().map(|event| (event.kind, event.first.line)).collect::<Vec<_>>()
    };
    assert_eq!(told(None, "G0 Z25\nM2", &[part(0, [0.0, 5.0], 0.0)]), [(Kind::Collision, 0)]);
    // What touches a finished part where the machine stands at first has not come there. Borders of 0.24 and 1 mm.
    assert_eq!(told(Some(0.25), "G0 Z25\nM2", &[part(1, [0.0, 5.0], 0.1)]), []);
    // A rapid goes deep from where a feed move touched, which it may. `G1 Z80` is places 1 to 20.
    let deeper = [part(1, [10.0, 22.0], 0.1), part(0, [22.0, 25.0], -0.1)];
    assert_eq!(told(Some(0.25), "G1 Z80 F6000\nG0 Z25\nM2", &deeper), [(Kind::RapidIntoWorkpiece, 2)]);
}

#[test]
fn only_a_rapid_outside_may_come_to_touch_a_finished_part_between_samples() {
    // Up to place 20 a feed move.
    let mut scene = scene(CUBES, "G1 Z80 F6000\nG0 Z25\nM2");
    (scene.parts[0].role, scene.parts[1].role) = (Role::Workpiece, Role::Cutter);
    scene.gouge_mm = Some(0.1);
    let path = Path::new(&scene, scene.program.as_ref().unwrap()).unwrap();
    let (pair, registry) = (Pair { a: 0, b: 1 }, registry::standard());
    let variant = registry.fastest().unwrap();
    let bodies = Bodies::new(&scene, [variant, variant], &[pair]);
    let mut scan = Scan::new(&scene, &path, &bodies, pair, &[0.09, 1.0], 0.01);
    let mut measure = |place: f64, z: f64| {
        let mut position = Position::default();
        position[Axis::Z] = z;
        scan.measure(place, &scene.machine.forward(&position))
    };
    // 5 mm above it a cutter may go 5.1 mm farther: of 10.2 - travel half is left.
    let (feed, rapid) = (measure(10.0, 25.0), measure(30.0, 25.0));
    assert!(!scan.may_come_nearer(&rapid, &rapid, 10.0) && scan.may_come_nearer(&rapid, &rapid, 10.2));
    assert!(!scan.may_come_nearer(&rapid, &feed, 10.2));
    // Where it touches at both ends, it may go through something between; in what it touches, it may still gouge.
    let mut measure = |z: f64| {
        let mut position = Position::default();
        position[Axis::Z] = z;
        scan.measure(30.0, &scene.machine.forward(&position))
    };
    let (touching, within) = (measure(20.0), measure(19.93));
    assert!(!scan.may_come_nearer(&touching, &touching, 0.09) && scan.may_come_nearer(&touching, &touching, 0.11));
    assert!(!scan.may_come_nearer(&within, &within, 0.05) && scan.may_come_nearer(&within, &within, 0.07));
}

#[test]
fn each_line_that_asks_for_a_place_beyond_a_limit_is_told_where_it_is_first_beyond() {
    let axis = "axis = \"Z\", direction = [0, 0, 1]";
    let text = CUBES.replacen(axis, &format!("{axis}, max_mm = 200"), 1);
    // Lines of 110, 195, 45, 190 and 10 samples, 1 mm and 10 ms each.
    let scene = scene(&text, "G0 Z210\nG0 Z15\nG0 Z60\nG0 Z250\nG0 Z260\nM2");
    let told = |stop_at_first| {
        let over = checked(&scene, &Settings { stop_at_first, ..with_zones(&[]) }).over_travel;
        assert!(over.iter().all(|over| (over.time_s - over.place as f64 / 100.0).abs() < 1e-9));
        over.iter().map(|over| (over.place, over.line, over.cause.value)).collect::<Vec<_>>()
    };
    assert_eq!(told(false), [(101, 1, 210.0), (491, 4, 250.0), (541, 5, 260.0)]);
    // The cubes collide on line 2.
    assert_eq!(told(true), [(101, 1, 210.0)]);
    // A loop tells a line once, however many others are told between its rounds.
    let lines: String = (1..=10).map(|k| format!("G0 Z{}\n", 200 + k)).collect();
    let scene = self::scene(&text, &format!("o1 repeat [2]\n{lines}G0 Z60\no1 endrepeat\nM2"));
    let over = checked(&scene, &with_zones(&[])).over_travel;
    assert_eq!(over.iter().map(|over| over.line).collect::<Vec<_>>(), (2..=11).collect::<Vec<_>>());
    // Lines that leave the axis where it is are not told. Of the two ways round to within the limits one goes farther out first.
    let lines = |program: &str| {
        let over = checked(&self::scene(&text, program), &with_zones(&[])).over_travel;
        over.iter().map(|over| over.line).collect::<Vec<_>>()
    };
    assert_eq!(lines("G0 Z210\nG4 P1\nT2 M6\nG0 X5\nM2"), [1]);
    let round = [2, 3].map(|code| lines(&format!("G18\nG1 Z205 F6000\nG{code} X5 Z200 I5 K0\nM2")));
    assert!(round.contains(&vec![2]) && round.contains(&vec![2, 3]), "{round:?}");
}

#[test]
fn each_line_that_leads_the_tip_with_an_axis_beyond_its_limit_is_told() {
    let axis = "axis = \"Z\", direction = [0, 0, 1]";
    let text = with_tip().replacen(axis, &format!("{axis}, max_mm = 200"), 1);
    // The axis is 10 mm above the tip, and comes to 205.5 and 208.5; line 4 brings it back.
    let scene = scene(&text, "G43.4 H1\nG1 Z195.5 F6000\nG1 Z198.5\nG1 Z100\nG1 Z195.5\nM2");
    let over = checked(&scene, &with_zones(&[])).over_travel;
    let told: Vec<_> = over.iter().map(|over| (over.line, over.cause.value.floor())).collect();
    assert_eq!(told, [(2, 200.0), (3, 206.0), (5, 200.0)]);
}

#[test]
fn the_axes_follow_the_tip_round_whole_turns_however_far_apart_the_samples_are() {
    let table =
        "[[machine.links]]\nname = \"table\"\njoint = { axis = \"C\", direction = [0, 0, 1] }\n[[machine.links]]\n";
    let text = with_tip()
        .replacen("[[machine.links]]\n", table, 1)
        .replacen("{ tool_link = \"head\" }", "{ tool_link = \"head\", work_link = \"table\" }", 1)
        .replacen("[program]\n", "[program]\nstep_mm = 1000\nstep_deg = 2000\n", 1);
    let scene = scene(&text, "G43.4 H1\nG0 X50 Z50\nG0 C1440\nM2");
    let path = Path::new(&scene, scene.program.as_ref().unwrap()).unwrap();
    // At half a turn the place at X 50 of the table is at X -50.
    let least = path.samples().iter().map(|sample| sample.position[Axis::X]).fold(f64::INFINITY, f64::min);
    assert!((least + 50.0).abs() < 1e-9, "{least}");
}

#[test]
fn a_program_that_moves_an_axis_without_a_joint_is_refused() {
    let refused = |text: &str, program: &str, message: &str| {
        let (scene, registry) = (scene(text, program), registry::standard());
        let (run, variant) = (scene.program.as_ref().unwrap(), registry.fastest().unwrap());
        let error = check(&scene, run, variant, &registry, &Settings::standard(), &Silent).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    };
    refused(CUBES, "G0 Z50\nG0 Y5\nM2", ":2: the program moves axis Y to 5 mm");
    // An arc moves both axes of its plane, wherever it ends.
    for arc in ["G2 X20 I10 F500", "G2 I10 F500"] {
        refused(CUBES, &format!("G0 Z50\n{arc}\nM2"), ":2: the program moves axis Y to 0 mm");
    }
    // Under control of the tool's tip C is an axis, though X, Y and Z are not.
    refused(&with_tip(), "G43.4 H1\nG1 X5 C90 F1000\nM2", ":2: the program moves axis C to 90 degrees");
    // What stays where it is at first is not moved.
    let aside = CUBES.replacen("start = { z_mm", "start = { y_mm = 5, z_mm", 1);
    assert!(checked(&scene(&aside, "G0 Z50\nM2"), &with_zones(&[])).events.is_empty());
}

#[test]
fn a_tolerance_below_rounding_ends_the_search_all_the_same() {
    let scene = scene(CUBES, "G0 X5\nG0 Z15\nG0 Z60\nM2");
    let outcome = checked(&scene, &Settings { tolerance_mm: 1e-300, ..with_zones(&[]) });
    let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
    assert!([&event.first, &event.last].iter().all(|extent| (extent.position[Axis::Z] - 20.0).abs() < 1e-3));
    // Four borders of at most 40 halvings, and some 20 whole places.
    assert!(outcome.queries <= 240, "{}", outcome.queries);
}
