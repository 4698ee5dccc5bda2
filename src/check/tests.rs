use super::event::runs;
use super::motion::axes_s;
use super::scan::{Scan, Stretch};
use super::{Bodies, Gouge, Kind, Outcome, Path, Settings, check, is_tool_and_workpiece};
use crate::measure::Silent;
use crate::registry::Registry;
use crate::scene::{Clearances, Overrides, Pair, Role, Scene};
use rs274::{Axis, MoveKind, Position, Sample};
use std::collections::BTreeMap;

/// A cube of 20 mm on a slide along Z that stands at 100 at first, over one that is fixed, both about their origins: they are Z - 20
/// apart. X slides it sideways. Rapids at 100 mm/s.
const CUBES: &str = r#"
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

fn scene(text: &str, program: &str) -> Scene {
    let files = [("scene.toml", text), ("own.ngc", program)];
    let files = files.map(|(name, text)| (name.to_owned(), text.as_bytes().to_vec()));
    Scene::from_memory("cubes", BTreeMap::from(files), &Overrides::default()).unwrap()
}

fn checked(scene: &Scene, settings: &Settings) -> Outcome {
    let registry = Registry::standard();
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
    let scene = scene(CUBES, "G0 X5\nG0 Z15\nG0 Z60\nM2");
    let outcome = checked(&scene, &with_zones(&[]));
    let [event] = &outcome.events[..] else { panic!("{:?}", outcome.events) };
    assert_eq!((event.kind, event.first.line, event.last.line, event.least_mm), (Kind::Collision, 2, 3, 0.0));
    for extent in [&event.first, &event.last] {
        assert!((extent.position[Axis::Z] - 20.0).abs() < 0.02, "{extent:?}");
    }
    assert!(outcome.collides() && !event.to_the_end && !event.inside);
    // 0.05 s aside, 0.85 s down, 0.45 s up.
    assert!((outcome.duration_s - 1.35).abs() < 1e-9);
}

#[test]
fn the_search_ends_with_the_first_collision_when_asked() {
    let scene = scene(CUBES, "G0 Z15\nG0 Z60\nG0 Z15\nG0 Z60\nM2");
    let lines = |stop_at_first| {
        let outcome = checked(&scene, &Settings { stop_at_first, ..with_zones(&[]) });
        outcome.events.iter().map(|event| event.first.line).collect::<Vec<_>>()
    };
    assert_eq!((lines(false), lines(true)), (vec![1, 3], vec![1]));
}

#[test]
fn the_next_place_is_not_nearer_than_the_widest_zone() {
    let scene = scene(CUBES, "G0 Z25\nM2");
    let path = Path::new(&scene, scene.program.as_ref().unwrap()).unwrap();
    let (pair, registry) = (Pair { a: 0, b: 1 }, Registry::standard());
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
            assert_eq!(Gouge::of(&scene, pair).is_some(), gouges, "{one:?} {other:?}");
        }
    }
}
