//! What a spindle turns, held against a workpiece that is cut.

use super::*;

/// A head with a spindle along Z, on slides along X and Z.
pub(super) const HEAD: &str = r#"
title = "Spindle"
[[machine.links]]
name = "cross"
joint = { axis = "X", direction = [1, 0, 0] }
[[machine.links]]
name = "head"
parent = "cross"
joint = { axis = "Z", direction = [0, 0, 1] }
"#;

/// A workpiece on a spindle along Z, a turret on slides along Z and X, which turns about its own place, and an insert on it beside the bar.
pub(super) const LATHE: &str = r#"
title = "Lathe"
[[machine.links]]
name = "spindle"
joint = { axis = "C", direction = [0, 0, 1] }
[[machine.links]]
name = "carriage"
joint = { axis = "Z", direction = [0, 0, 1] }
[[machine.links]]
name = "slide"
parent = "carriage"
joint = { axis = "X", direction = [1, 0, 0] }
[[machine.links]]
name = "turret"
parent = "slide"
joint = { axis = "B", direction = [0, 1, 0], point_mm = [30, 0, 70] }
[program]
file = "own.ngc"
controller = "lathe"
"#;

pub(super) fn part(name: &str, link: &str, role: &str, at: [f64; 3], shape: &str) -> String {
    let link = if link.is_empty() { String::new() } else { format!("link = \"{link}\"\n") };
    format!("[[parts]]\nname = \"{name}\"\n{link}role = \"{role}\"\nat = {{ xyz_mm = {at:?} }}\nshape = {shape}\n")
}

const TIP: &str = "[program]\nfile = \"own.ngc\"\ntool_centre_point = { tool_link = \"head\", gauge_mm = [0, 0, 0] }\n";
pub(super) const NO_TIP: &str = "[program]\nfile = \"own.ngc\"\n";

pub(super) fn found(text: &str, program: &str) -> Outcome {
    checked(&scene(text, program), &with_zones(&[]))
}

pub(super) fn kinds(outcome: &Outcome) -> Vec<(u32, &'static str)> {
    outcome.events.iter().map(|event| (event.first.line, event.kind.name())).collect()
}

/// A bar of a regular polygon whose corners are `radius` from the axis; a flat is towards the turret.
fn polygon(sides: usize, radius: f64) -> String {
    let corner = |k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * (k as f64 + 0.5) / sides as f64).sin_cos();
        format!("[{}, {}]", radius * cos, radius * sin)
    };
    let outline: Vec<String> = (0..sides).map(corner).collect();
    format!("{{ kind = \"extrude\", height_mm = 50, outline_mm = [{}] }}", outline.join(", "))
}

pub(super) fn cylinder(radius: f64, height: f64) -> String {
    format!("{{ kind = \"cylinder\", radius_mm = {radius}, height_mm = {height} }}")
}

pub(super) fn cuboid(size: [f64; 3]) -> String {
    format!("{{ kind = \"rounded-box\", size_mm = {size:?} }}")
}

/// A shank of 20 mm along Z and a blade at its lower end that reaches 60 mm towards X: no cylinder around it has its axis.
const FLY: &str = "{ kind = \"compound\", parts = [{ shape = { kind = \"cylinder\", radius_mm = 10, height_mm = 60 } }, { shape = { kind = \"rounded-box\", size_mm = [55, 10, 8] }, at = { xyz_mm = [32.5, 0, 4] } }] }";

/// Jaws pass 25 to 65 mm beside the axis of a bar that no joint turns; a steady on the same link stands from 40 to 60 mm, at another angle.
#[test]
fn what_stands_beside_a_spindle_is_examined_though_no_joint_is_between_them() {
    let slides = HEAD.replace("title = \"Spindle\"", "title = \"Two axes\"");
    let bar = part("bar", "", "workpiece", [0.0, 0.0, 50.0], &cylinder(20.0, 100.0));
    let jaws = [45.0, -45.0].map(|x| part("jaw", "", "fixture", [x, 0.0, 10.0], &cuboid([40.0, 10.0, 20.0])));
    let jaws = [jaws[0].clone(), jaws[1].replace("\"jaw\"", "\"other\"")].concat();
    let insert = part("insert", "head", "cutter", [35.0, 0.0, 125.0], &cuboid([10.0, 4.0, 10.0]));
    let program = "[program]\nfile = \"own.ngc\"\ncontroller = \"lathe\"\n";
    for (y, turns, expected) in
        [(50.0, "turns = \"none\"\n", 2), (90.0, "turns = \"none\"\n", 0), (50.0, "turns = \"spindle\"\n", 0)]
    {
        let steady = part("steady", "", "fixture", [0.0, y, 10.0], &cuboid([10.0, 20.0, 20.0]));
        let text = [&slides, &bar, &jaws, &steady, turns, &insert, program].concat();
        let told = found(&text, "M3 S1000\nG0 X20\nG1 X15 F100\nM2");
        let steady = told.events.iter().filter(|event| event.kind == Kind::Unresolved && event.pair.b == 3).count();
        assert_eq!(steady, expected, "{y} {turns} {:?}", told.events);
    }
}

#[test]
fn a_drive_turns_about_the_axis_that_a_round_part_shows_or_is_named() {
    let chuck = |turns: &str| {
        part("chuck", "head", "holder", [0.0, 0.0, 140.0], &cylinder(10.0, 30.0)) + &format!("tool = 1\n{turns}")
    };
    let (own, nothing) = ("turns = \"own\"\n", "turns = \"none\"\n");
    for (chuck, is_known) in [(String::new(), false), (chuck(own), true), (chuck(nothing), false), (chuck(""), false)] {
        let fly = part("fly", "head", "cutter", [0.0, 0.0, 80.0], FLY) + "tool = 1\n" + own;
        // From 50 mm beside the axis on, on the side without the blade.
        let post = part("post", "", "fixture", [-55.0, 0.0, 25.0], &cuboid([10.0, 10.0, 50.0]));
        let told = found(&[HEAD, &post, &fly, &chuck, NO_TIP].concat(), "T1 M6\nM3 S1000\nG0 Z-60\nM2");
        let expected = if is_known { vec![(3, "unresolved")] } else { vec![] };
        assert_eq!((kinds(&told), told.as_drawn.contains(&1)), (expected, !is_known), "{chuck}");
        // The blade cuts 2 mm deep, and a drill comes down 3 mm deeper later. About an axis along Y the blade would have gone through the block.
        let block = part("block", "", "workpiece", [0.0; 3], &cuboid([100.0, 100.0, 20.0]));
        let drill = part("drill", "head", "cutter", [10.0, 0.0, 30.0], &cylinder(2.0, 40.0)) + "tool = 2\n";
        let program = "T1 M6\nM3 S1000\nG1 Z-72 F100\nG1 Z0\nT2 M6\nM3 S1000\nG0 Z-25\nG0 Z0\nM2";
        let told = found(&[HEAD, &block, &fly, &drill, &chuck, NO_TIP].concat(), program);
        let expected = if is_known { (7, "rapid-into-workpiece") } else { (7, "unresolved") };
        assert_eq!(kinds(&told), [expected], "{chuck}");
    }
}

#[test]
fn a_driven_cutter_without_a_known_axis_cuts_nothing_for_sure_on_a_lathe() {
    let bar = part("bar", "spindle", "workpiece", [0.0, 0.0, -10.0], &cylinder(60.0, 20.0));
    let drill =
        part("drill", "slide", "cutter", [10.0, 0.0, 30.0], &cylinder(2.0, 40.0)) + "tool = 2\nturns = \"own\"\n";
    for turns in ["own", "spindle"] {
        let fly = part("fly", "slide", "cutter", [0.0, 0.0, 80.0], FLY) + &format!("tool = 1\nturns = \"{turns}\"\n");
        let program = "T1 M6\nM3 S1000\nG1 Z-72 F100\nG1 Z0\nT2 M6\nM3 S1000\nG0 Z-25\nG0 Z0\nM2";
        let told = found(&[LATHE, &bar, &fly, &drill].concat(), program);
        assert_eq!((kinds(&told), &told.as_drawn), (vec![(7, "unresolved")], &vec![1]), "{turns}");
    }
}

/// A part on the slide with its axis along X.
pub(super) fn along_x(name: &str, role: &str, [x, z]: [f64; 2], shape: &str) -> String {
    part(name, "slide", role, [x, 0.0, z], shape).replace("] }\nshape", "], rpy_deg = [0, 90, 0] }\nshape")
}

/// The same with a part on a link of its own, which stands on `parent` and has its frame at `link_at`.
fn on_ram(text: &str, name: &str, from: [f64; 3], to: [f64; 3], parent: &str, link_at: [f64; 3]) -> String {
    let parent = if parent.is_empty() { String::new() } else { format!("parent = \"{parent}\"\n") };
    let link = format!("[[machine.links]]\nname = \"ram\"\n{parent}at = {{ xyz_mm = {link_at:?} }}\n");
    let (before, rest) = text.split_once(&format!("name = \"{name}\"\n")).unwrap();
    let (role, rest) = rest[rest.find("role = ").unwrap()..].split_once('\n').unwrap();
    let rest = rest.strip_prefix(&format!("at = {{ xyz_mm = {from:?} ")).unwrap();
    let moved = format!("{before}name = \"{name}\"\nlink = \"ram\"\n{role}\nat = {{ xyz_mm = {to:?} {rest}");
    let at = moved.find("[[parts]]").unwrap();
    format!("{}{link}{}", &moved[..at], &moved[at..])
}

#[test]
fn a_round_part_of_a_driven_tool_turns_about_its_own_axis() {
    let driven = |name: &str, role: &str, at: [f64; 3], shape: &str| {
        part(name, "head", role, at, shape) + "tool = 1\nturns = \"own\"\n"
    };
    let text = |holder: &str| {
        let cutter = driven("cutter", "cutter", [0.0, 0.0, 40.0], &cylinder(5.0, 40.0));
        let holder = driven("holder", "holder", [30.0, 0.0, 80.0], holder);
        // As far from the cutter's axis as the holder, on the other side.
        let post = part("post", "", "fixture", [-35.0, 0.0, 25.0], &cuboid([10.0, 10.0, 50.0]));
        let other =
            part("other", "head", "cutter", [200.0, 0.0, 40.0], &cylinder(5.0, 40.0)) + "tool = 2\nturns = \"own\"\n";
        [HEAD, &post, &other, &cutter, &holder, NO_TIP].concat()
    };
    let program = "T1 M6\nM3 S1000\nG0 Z-60\nM2";
    assert_eq!(kinds(&found(&text(&cylinder(10.0, 30.0)), program)), []);
    assert_eq!(kinds(&found(&text(&polygon(8, 10.0)), program)), []);
    // One that is not round turns about the cutter's, and not about that of another tool.
    assert_eq!(kinds(&found(&text(&cuboid([20.0, 6.0, 30.0])), program)), [(3, "unresolved")]);
    // Nor about that of another round part of the tool; and so on whatever link it is drawn.
    let holder = text(&cuboid([20.0, 6.0, 30.0]));
    let pulley = driven("pulley", "shank", [30.0, 0.0, 120.0], &cylinder(10.0, 10.0));
    let with_pulley =
        holder.replacen("[[parts]]\nname = \"cutter\"", &format!("{pulley}[[parts]]\nname = \"cutter\""), 1);
    assert_eq!(kinds(&found(&with_pulley, program)), [(3, "unresolved")]);
    let on_link = on_ram(&holder, "holder", [30.0, 0.0, 80.0], [5.0, 0.0, 80.0], "head", [25.0, 0.0, 0.0]);
    assert_eq!(kinds(&found(&on_link, program)), [(3, "unresolved")]);
}

#[test]
fn a_lug_of_a_holder_is_at_every_angle_beside_the_workpiece() {
    let holder = "{ kind = \"compound\", parts = [{ shape = { kind = \"cylinder\", radius_mm = 20, height_mm = 30 } }, { shape = { kind = \"rounded-box\", size_mm = [20, 6, 10] }, at = { xyz_mm = [30, 0, 10] } }] }";
    let text = [
        HEAD,
        // From 30 to 50 mm beside the axis, on the side without the lug.
        &part("wall", "", "workpiece", [-40.0, 0.0, 0.0], &cuboid([20.0, 100.0, 60.0])),
        &part("cutter", "head", "cutter", [0.0, 0.0, 40.0], &cylinder(5.0, 30.0)),
        &part("holder", "head", "holder", [0.0, 0.0, 60.0], holder),
    ]
    .concat();
    let turning = "M3 S1000\nG1 Z-50 F500\nM2";
    let told = found(&format!("{text}{TIP}"), turning);
    assert_eq!(kinds(&told), [(2, "unresolved")]);
    assert_eq!(told.events[0].pair.other(0), 2);
    assert!(found(&format!("{text}{TIP}"), "G0 Z-50\nM2").is_clear());
    // Where the axis is not known, the holder is named.
    let told = found(&format!("{text}{NO_TIP}"), turning);
    assert_eq!((told.is_clear(), told.as_drawn), (true, vec![2]));
    // One that is round and has a bore is the same at every angle.
    let bored = "{ kind = \"revolve\", profile_mm = [[10, 0], [20, 0], [20, 30], [10, 30]] }";
    let told = found(&format!("{}{NO_TIP}", text.replace(holder, bored)), turning);
    assert_eq!((told.is_clear(), told.as_drawn), (true, vec![]));
}

/// Its corners reach 12.65 mm from the axis at each turn, and as drawn it reaches 4 mm.
#[test]
fn what_turns_is_told_before_and_behind_where_the_drawing_collides() {
    let text = [
        HEAD,
        &part("wall", "", "fixture", [-50.0, 0.0, 0.0], &cuboid([20.0, 100.0, 200.0])),
        &part("holder", "head", "holder", [0.0, 0.0, 60.0], &cuboid([8.0, 24.0, 10.0])),
        TIP,
    ]
    .concat();
    let spans = |program: &str| -> Vec<(&'static str, u32, u32, bool)> {
        let told = found(&text, program);
        let span = |event: &Event| (event.kind.name(), event.first.line, event.last.line, event.to_the_end);
        told.events.iter().map(span).collect()
    };
    let (turned, drawn) = ("unresolved", "collision");
    let program = "M3 S1000\nG0 X-20\nG0 X-30\nG1 X-32 F500\nG1 X-37\nG1 X-31\nG1 X-29\nG0 X0\nM2";
    let expected = [(turned, 3, 5, false), (drawn, 5, 6, false), (turned, 6, 8, false)];
    assert_eq!(spans(program), expected);
    // What is on the lines of the collision alone is told by it.
    assert_eq!(spans("M3 S1000\nG0 X-37\nG0 X0\nM2"), [(drawn, 2, 3, false)]);
    assert_eq!(spans("M3 S1000\nG0 X-37\nG0 X-30\nG4 P1\nG0 X-29\nM2"), [(drawn, 2, 3, false), (turned, 3, 5, true)]);
    let twice = "M3 S1000\nG0 X-37\nG0 X-34\nG0 X-33\nG0 X-37\nG0 X0\nM2";
    assert_eq!(spans(twice), [(drawn, 2, 3, false), (turned, 3, 5, false), (drawn, 5, 6, false)]);
    let before = "M3 S1000\nG0 X-30\nG0 X0\nG0 X-37\nG0 X0\nG0 X-30\nG0 X0\nM2";
    assert_eq!(spans(before), [(turned, 2, 3, false), (drawn, 4, 5, false), (turned, 6, 7, false)]);
    let settings = Settings { stop_at_first: true, ..with_zones(&[]) };
    let first = checked(&scene(&text, program), &settings).events;
    assert_eq!((first.len(), first[0].first.line), (1, 3));
    // Each part of it has the text of its own line, and lasts to the end only where it does.
    let told = found(&text, "M3 S1000\nG0 X-20\nG0 X-30\nG0 X-32\nG0 X-37\nG0 X-31\nG0 X-30\nM2").events;
    let ends: Vec<_> = told.iter().map(|event| (event.kind.name(), event.block.as_str(), event.to_the_end)).collect();
    assert_eq!(ends, [(turned, "G0 X-30", false), (drawn, "G0 X-37", false), (turned, "G0 X-31", true)]);
    assert!(told.iter().all(|event| event.nearest == event.first), "{told:?}");
    // Neither what is near nor what another part meets tells it.
    let post = part("post", "", "fixture", [-30.0, 0.0, 0.0], &cuboid([4.0, 4.0, 200.0]));
    let with_post = text.replacen("[program]", &format!("{post}[program]"), 1);
    let told = checked(&scene(&with_post, "M3 S1000\nG0 X-30\nM2"), &with_zones(&[25.0]));
    let kinds: Vec<_> = kinds(&told).into_iter().filter(|(_, kind)| *kind != "near").collect();
    assert_eq!(kinds, [(2, "collision"), (2, "unresolved")]);
    // As drawn it stays out of reach.
    let told = found(&text, "M3 S1000\nG0 X-30\nM2");
    assert!(told.decisions.len() == 1 && told.decisions[0].dropped.is_none(), "{:?}", told.decisions);
}

#[test]
fn a_lug_of_a_driven_holder_on_a_lathe_is_at_every_angle() {
    let along_x = |name: &str, role: &str, x: f64, shape: &str| along_x(name, role, [x, 100.0], shape);
    // The lug is from 20 to 40 mm beside the axis of the tool, away from the chuck.
    let holder = "{ kind = \"compound\", parts = [{ shape = { kind = \"cylinder\", radius_mm = 20, height_mm = 30 } }, { shape = { kind = \"rounded-box\", size_mm = [20, 6, 10] }, at = { xyz_mm = [-30, 0, 10] } }] }";
    let steady = part("steady", "", "fixture", [0.0, 40.0, 100.0], &cuboid([200.0, 20.0, 20.0])) + "turns = \"none\"\n";
    let text = |steady: &str, cutter: &str, of_holder: &str| {
        let key = |turns: &str| if turns.is_empty() { String::new() } else { format!("turns = \"{turns}\"\n") };
        [
            LATHE,
            &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
            &along_x("mill", "cutter", 60.0, &cylinder(5.0, 40.0)),
            &key(cutter),
            &along_x("holder", "holder", 100.0, holder),
            &key(of_holder),
            steady,
        ]
        .concat()
    };
    let beside_steady = "M3 S500\nG1 X-60 F200\nM2";
    // A cut into the bar, and then the lug over its end, within the half turn that is not drawn.
    let over_the_end = "M3 S500\nG0 Z-60\nG1 X-90 F200\nG1 X0\nG0 Z0\nG0 X-190\nG1 Z-20 F200\nM2";
    for (cutter, of_holder, meets, is_named) in [
        ("own", "own", true, false),
        ("spindle", "spindle", true, false),
        ("own", "none", false, false),
        ("own", "", false, true),
        ("", "", false, true),
        ("none", "", false, false),
    ] {
        let expected = |line: u32| if meets { vec![(line, "unresolved")] } else { vec![] };
        let named = if is_named { vec![2] } else { vec![] };
        let told = found(&text(&steady, cutter, of_holder), beside_steady);
        assert_eq!((kinds(&told), &told.as_drawn), (expected(2), &named), "{cutter} {of_holder}");
        if cutter == "own" {
            let told = found(&text("", cutter, of_holder), over_the_end);
            assert_eq!((kinds(&told), &told.as_drawn), (expected(7), &named), "{cutter} {of_holder}");
        }
    }
    // With rapids alone nobody knows whether the round cutter is driven.
    assert_eq!(found(&text(&steady, "", ""), "M3 S500\nG0 X-60\nM2").as_drawn, [2]);
}

#[test]
fn what_stands_in_a_milled_hole_meets_the_bar_when_it_turns() {
    let along_x = |name: &str, role: &str, x: f64, shape: &str| along_x(name, role, [x, 60.0], shape) + "tool = 1\n";
    let text = [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(30.0, 50.0)),
        &along_x("mill", "cutter", 40.0, &cylinder(6.0, 20.0)),
        "turns = \"own\"\n",
        &along_x("arbor", "shank", 60.0, &cylinder(4.0, 20.0)),
        &part("shank", "slide", "shank", [45.0, 0.0, 60.0], &cuboid([10.0, 4.0, 8.0])),
        "tool = 2\n",
    ]
    .concat();
    // The bar stands while the mill turns: the arbor is free in the hole.
    let milled = "T1 M6\nM3 S500\nG0 Z-40\nG1 X-80 F200\nG0 X0\n";
    for (hole, x, expected) in [
        (milled, -50, vec![(8, "unresolved")]),
        (milled, -16, vec![]),
        ("\n\nG0 Z-40\n\n\n", -50, vec![(8, "collision")]),
    ] {
        let told = found(&text, &format!("{hole}T2 M6\nM3 S500\nG0 X{x}\nG0 X0\nM2"));
        assert_eq!(kinds(&told), expected, "{hole}{x}");
    }
}

#[test]
fn an_insert_turns_about_the_spindle_and_not_about_itself() {
    let with_key = |x: f64, width: f64, turns: &str| {
        [
            HEAD,
            &part("block", "", "workpiece", [x, 0.0, 0.0], &cuboid([width, 20.0, 20.0])),
            &part("insert", "head", "cutter", [35.0, 0.0, 30.0], &cuboid([10.0, 10.0, 4.0])),
            turns,
            TIP,
        ]
        .concat()
    };
    let text = |x: f64, width: f64| with_key(x, width, "");
    // The insert passes from 30 to 40.3 mm. On the other side of the axis is a block; another one stands within.
    assert_eq!(kinds(&found(&text(-35.0, 20.0), "M3 S1000\nG0 Z-25\nM2")), [(2, "rapid-into-workpiece")]);
    assert!(found(&text(0.0, 40.0), "M3 S1000\nG0 Z-25\nM2").is_clear());
    // What nothing turns is where it is drawn, 1 mm beside the block; its corners would pass 2.07 mm farther out about its own middle.
    let standing = found(&with_key(51.0, 20.0, "turns = \"none\"\n"), "M3 S1000\nG0 Z-25\nM2");
    assert!(standing.is_clear(), "{:?}", standing.events);
    // So where the block stays whole, where it is the finished part, and where its mesh is open.
    let rapid = "M3 S1000\nG0 Z-25\nM2";
    let never = Settings { cutting: Cutting::Never, ..with_zones(&[]) };
    assert_eq!(kinds(&checked(&scene(&text(-35.0, 20.0), rapid), &never)), [(2, "unresolved")]);
    assert!(checked(&scene(&text(-35.0, 20.0), "M3 S1000\nG1 Z-25 F100\nG0 Z0\nM2"), &never).is_clear());
    for program in [rapid, "M3 S1000\nG1 Z-25 F100\nM2"] {
        let mut finished = scene(&text(-35.0, 20.0), program);
        finished.gouge_mm = Some(0.05);
        assert_eq!(kinds(&checked(&finished, &with_zones(&[]))), [(2, "unresolved")], "{program}");
    }
    let open = text(-35.0, 20.0).replacen(&format!("shape = {}", cuboid([20.0, 20.0, 20.0])), "mesh = \"open.obj\"", 1);
    assert_eq!(
        kinds(&found(&open.replace("xyz_mm = [-35.0, 0.0, 0.0]", "xyz_mm = [-40.0, 0.0, 0.0]"), rapid)),
        [(2, "unresolved")]
    );
    // It cuts the ring, and nothing within.
    let cut = found(&text(-35.0, 20.0), "M3 S1000\nG1 Z-25 F100\nG0 Z0\nM2");
    assert!(cut.is_clear(), "{:?}", cut.events);
    let mut stock = cut.remaining[0].stock.clone();
    assert_eq!(stock.material_at(&Point::new(-1.0, 1.0, 8.0)), Material::Gone);
    assert_eq!(stock.material_at(&Point::new(8.0, 1.0, 8.0)), Material::Solid);
}

#[test]
fn a_cutter_that_stands_is_where_it_is_drawn_for_sure_and_maybe_anywhere_it_turns() {
    let plate = "{ kind = \"extrude\", height_mm = 20, outline_mm = [[-30, -30], [30, -30], [30, 30], [-30, 30]], holes = [{ at_mm = [0, 0], radius_mm = 15 }] }";
    // From 4 to 20 mm on one side of the spindle's axis: 8 mm beside the hole's middle it goes through.
    let bar = "{ kind = \"extrude\", height_mm = 4, outline_mm = [[4, -2], [20, -1], [20, 1], [4, 2]] }";
    let text = [
        HEAD,
        &part("plate", "", "workpiece", [0.0, 0.0, -40.0], plate),
        &part("bar", "head", "cutter", [0.0; 3], bar),
        "turns = \"spindle\"\n",
        TIP,
    ]
    .concat();
    for (stop, x, kind) in
        [("M5", -8, "unresolved"), ("M5", 8, "rapid-into-workpiece"), ("", -8, "rapid-into-workpiece")]
    {
        let told = found(&text, &format!("M3 S800\nG0 Z1\n{stop}\nG0 X{x}\nG0 Z-45\nM2"));
        assert_eq!(kinds(&told), [(5, kind)], "{stop} {x}");
    }
    // Back boring: with the wrong sign of I the bar goes down beside the hole.
    for (i, is_certain) in [(-8, false), (8, true)] {
        let told = found(&text, &format!("M3 S800\nG0 Z1\nG98 G87 X0 Z-45 R-18 I{i} J0 K-36 F50\nG80\nM2"));
        let certain = kinds(&told).iter().any(|&(_, kind)| kind == "rapid-into-workpiece");
        assert!(!told.is_clear() && certain == is_certain, "{i}: {:?}", kinds(&told));
    }
}

#[test]
fn lugs_in_a_bore_meet_what_stands_between_them_when_it_turns() {
    let shape = "{ kind = \"compound\", parts = [{ shape = { kind = \"revolve\", profile_mm = [[30, 0], [50, 0], [50, 40], [30, 40]] } }, { shape = { kind = \"rounded-box\", size_mm = [18, 6, 40] }, at = { xyz_mm = [24, 0, 20] } }] }";
    for role in ["workpiece", "fixture"] {
        let text = [
            LATHE,
            &part("chuck", "spindle", role, [0.0; 3], shape),
            &part("probe", "slide", "shank", [0.0, 22.0, 60.0], &cuboid([6.0, 6.0, 20.0])),
            &part("insert", "slide", "cutter", [0.0, 22.0, 100.0], &cuboid([2.0, 2.0, 2.0])),
        ]
        .concat();
        assert_eq!(kinds(&found(&text, "M3 S500\nG0 Z-30\nM2"))[0], (2, "unresolved"), "{role}");
        assert!(found(&text, "G0 Z-30\nM2").is_clear(), "{role}");
    }
}

#[test]
fn on_a_mill_without_a_gauge_point_a_part_turns_about_the_axis_that_it_shows_or_is_named() {
    let screw = "{ kind = \"compound\", parts = [{ shape = { kind = \"cylinder\", radius_mm = 25, height_mm = 50 } }, { shape = { kind = \"cylinder\", radius_mm = 3, height_mm = 8 }, at = { xyz_mm = [-24, 0, 20], rpy_deg = [0, -90, 0] } }] }";
    // Flats of the octagon are 23.1 mm from the axis.
    for (holder, meets, is_named) in
        [(polygon(8, 25.0), true, false), (cylinder(24.0, 50.0), false, false), (screw.to_owned(), false, true)]
    {
        let text = [
            HEAD,
            &part("vise", "", "fixture", [44.0, 0.0, 0.0], &cuboid([40.0, 100.0, 60.0])),
            &part("holder", "head", "holder", [-2.0, 0.0, 60.0], &holder),
            NO_TIP,
        ]
        .concat();
        let told = found(&text.replace("[44.0,", if is_named { "[46.0," } else { "[42.3," }), "M3 S1000\nG0 Z-50\nM2");
        let expected = if meets { vec![(2, "unresolved")] } else { vec![] };
        assert_eq!((kinds(&told), told.as_drawn), (expected, if is_named { vec![1] } else { vec![] }), "{holder}");
    }
    // One that the spindle turns may be beside its axis.
    let holder = part("holder", "head", "holder", [0.0, 0.0, 60.0], &cylinder(24.0, 50.0)) + "turns = \"spindle\"\n";
    let vise = part("vise", "", "fixture", [46.0, 0.0, 0.0], &cuboid([40.0, 100.0, 60.0]));
    assert_eq!(found(&[HEAD, &vise, &holder, NO_TIP].concat(), "M3 S1000\nG0 Z-50\nM2").as_drawn, [1]);
}

#[test]
fn what_turns_within_the_resolution_is_named() {
    let text = [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], &polygon(6, 20.0)),
        &part("insert", "slide", "cutter", [30.0, 0.0, 60.0], &cuboid([4.0, 2.0, 4.0])),
        &part("shank", "slide", "shank", [24.85, 0.0, 60.0], &cuboid([10.0, 4.0, 10.0])),
    ]
    .concat();
    let settings = Settings { cutting: Cutting::At(0.5), ..with_zones(&[]) };
    let told = checked(&scene(&text, "M3 S500\nG1 Z-20 F200\nM2"), &settings);
    assert!(told.is_clear(), "{:?}", told.events);
    assert_eq!(told.touches.iter().map(|touch| (touch.pair.other(0), touch.line)).collect::<Vec<_>>(), [(2, 2)]);
}

#[test]
fn corners_of_a_turning_bar_meet_what_stands_over_its_flats() {
    // As drawn there are 1.5 and 0.5 mm between flat and shank.
    for (sides, radius, gap) in [(6, 23.1, 21.5), (8, 20.0, 19.0)] {
        let text = [
            LATHE,
            &part("bar", "spindle", "workpiece", [0.0; 3], &polygon(sides, radius)),
            &part("insert", "slide", "cutter", [60.0, 0.0, 90.0], &cuboid([4.0, 2.0, 4.0])),
            &part("shank", "slide", "shank", [gap + 5.0, 0.0, 60.0], &cuboid([10.0, 4.0, 10.0])),
        ]
        .concat();
        let told = found(&text, "M3 S500\nG1 Z-20 F200\nM2");
        assert_eq!(kinds(&told), [(2, "unresolved")], "{sides}");
        assert!(found(&text, "G0 Z-20\nM2").is_clear(), "{sides}");
    }
}

#[test]
fn a_bar_in_two_pieces_is_named_where_something_else_may_carry_one() {
    for (is_solid, link, x, is_parted) in [
        (false, "", -41, true),
        (true, "", -41, true),
        // A neck of 1 mm is left.
        (false, "", -39, false),
        (true, "", -39, false),
        (false, "spindle", -41, false),
    ] {
        let text = [
            LATHE,
            &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(10.0, 40.0)),
            &part("insert", "slide", "cutter", [30.0, 0.0, 60.0], &cuboid([20.0, 2.0, 3.0])),
            &part("chuck", link, "fixture", [0.0, 0.0, 200.0], &cylinder(10.0, 20.0)),
        ]
        .concat();
        let settings = Settings { cutting: Cutting::At(0.5), is_solid, ..with_zones(&[]) };
        let told = checked(&scene(&text, &format!("M3 S500\nG0 Z-40\nG1 X{x} F50\nG0 X0\nM2")), &settings);
        assert_eq!(told.remaining[0].is_parted, is_parted, "{is_solid} {link} {x}");
        // A part of the machine that the spindle turns holds the bar as a fixture does.
        let text = text.replace("role = \"fixture\"\n", "role = \"machine\"\nturns = \"spindle\"\n");
        let told = checked(&scene(&text, &format!("M3 S500\nG0 Z-40\nG1 X{x} F50\nG0 X0\nM2")), &settings);
        assert_eq!(told.remaining[0].is_parted, is_parted, "{is_solid} {link} {x}");
    }
}

#[test]
fn a_driven_drill_cuts_holes_and_no_ring() {
    let text = [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(30.0, 50.0)),
        &part("drill", "slide", "cutter", [20.0, 0.0, 60.0], &cylinder(3.0, 40.0)),
    ]
    .concat();
    let drilled = "M3 S500\nG1 Z-20 F100\nG0 Z0\n";
    assert!(found(&text, &format!("{drilled}G0 Z-15\nG0 Z0\nM2")).is_clear());
    assert_eq!(kinds(&found(&text, &format!("{drilled}G0 C90\nG0 Z-15\nG0 Z0\nM2"))), [(5, "rapid-into-workpiece")]);
    // So with any cutter that the scene calls driven. Of one that is not round, and for which the program sets the spindle, nobody knows.
    let square =
        text.replace(&cylinder(3.0, 40.0), &cuboid([4.0, 4.0, 40.0])).replace("[20.0, 0.0, 60.0]", "[20.0, 0.0, 80.0]");
    for (turns, kind) in [("turns = \"own\"\n", "rapid-into-workpiece"), ("", "unresolved")] {
        let program = "M3 S500\nG1 Z-40 F100\nG0 Z0\nG0 C90\nG1 Z-30 F100\nG0 C180\nG0 Z0\nM2";
        let told = found(&format!("{square}{turns}"), program);
        assert_eq!(kinds(&told)[0], (6, kind));
    }
    // On the axis it cuts what it would cut standing.
    let text = text.replace("[20.0, 0.0, 60.0]", "[0.0, 0.0, 60.0]");
    let told = found(&text, &format!("{drilled}M2"));
    assert_eq!((told.is_clear(), told.remaining[0].stock.resolution_mm()), (true, 0.1));
}

#[test]
fn a_round_cutter_across_the_axis_is_driven_wherever_it_crosses() {
    let bar = part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0));
    for (x, turned, driven) in [(0.0, "0, 90, 0", vec![1]), (-20.0, "0, 90, 0", vec![1]), (0.0, "0, 0, 0", vec![])] {
        let mill = part("mill", "slide", "cutter", [x, 0.0, 60.0], &cylinder(3.0, 40.0))
            .replace("] }\nshape", &format!("], rpy_deg = [{turned}] }}\nshape"));
        let told = found(&[LATHE, &bar, &mill].concat(), "M3 S500\nG1 Z-5 F100\nM2");
        assert_eq!(told.driven, driven, "{x} {turned}");
    }
}

/// Whether a spindle may drive a cutter of this shape that stands beside the end of a bar.
fn may_be_driven(at: [f64; 3], shape: &str, program: &str) -> bool {
    let bar = part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(30.0, 50.0));
    let scene = scene(&[LATHE, &bar, &part("mill", "slide", "cutter", at, shape)].concat(), program);
    let path = Path::new(&scene, scene.program.as_ref().unwrap()).unwrap();
    crate::check::turning::may_be_driven(&scene, &path, 1)
}

/// One step of 0.4 degrees, after which nothing turns any more, is enough.
#[test]
fn what_feeds_while_the_workpiece_is_turned_turns_itself() {
    let square = |program: &str| may_be_driven([40.0, 0.0, 60.0], &cuboid([4.0, 4.0, 40.0]), program);
    let may_be_driven = |first: &str| square(&format!("M3 S500\n{first}\nG1 Z-10\nG0 Z0\nM2"));
    assert!(may_be_driven("G1 C0.4 F100") && !may_be_driven("G1 Z-5 F100"));
    // Turned at rapid rate, and fed back.
    assert!(may_be_driven("G1 Z-1 F100\nG0 C0.4\nG1 C0") && !may_be_driven("G1 Z-1 F100\nG0 C0.4\nG0 C0"));
    // Turned before its first feed the workpiece stands at one angle in all of them.
    assert!(!may_be_driven("G0 C90\nG1 Z-5 F100"));
}

/// Nor does the step have to be before another feed.
#[test]
fn what_turns_the_workpiece_with_its_last_feed_turns_itself() {
    let square = |program: &str| may_be_driven([40.0, 0.0, 60.0], &cuboid([4.0, 4.0, 40.0]), program);
    assert!(square("M3 S500\nG1 Z-1 F100\nG1 C0.4\nG0 Z0\nM2"));
}

#[test]
fn only_a_round_cutter_that_never_feeds_may_be_driven_without_a_sign_of_it() {
    let (drill, insert) = (cylinder(3.0, 40.0), cuboid([20.0, 2.0, 3.0]));
    for (shape, program, expected) in [
        (&drill, "M3 S500\nG0 Z-5\nM2", true),
        // On the axis a drill stands.
        (&drill, "M3 S500\nG1 Z-15 F100\nM2", false),
        (&insert, "M3 S500\nG0 Z-5\nM2", false),
    ] {
        assert_eq!(may_be_driven([0.0, 0.0, 60.0], shape, program), expected, "{shape} {program}");
    }
}

#[test]
fn each_cutter_needs_its_own_spindle_where_each_has_codes() {
    let text = |dialect: &str, at: [f64; 3], cutter: &str| {
        let bar = part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0));
        [LATHE, &format!("dialect = \"{dialect}\"\n"), &bar, &part("cutter", "slide", "cutter", at, cutter)].concat()
    };
    let along_x = |text: String| {
        let (before, cutter) = text.rsplit_once("] }\nshape").unwrap();
        format!("{before}], rpy_deg = [0, 90, 0] }}\nshape{cutter}turns = \"own\"\n")
    };
    let insert = |dialect: &str| text(dialect, [31.0, 0.0, 60.0], &cuboid([20.0, 2.0, 3.0]));
    let mill = |dialect: &str| along_x(text(dialect, [31.0, 0.0, 60.0], &cylinder(6.0, 20.0)));
    let drill = text("haas", [0.0, 0.0, 60.0], &cylinder(3.0, 40.0));
    let (across, along) = ("G0Z-30.\nG1X-28.F200.\nG0X0.", "\nG1Z-20.F200.\nG0Z0.");
    let stopped = |start: &str, moves: &str, text: &str| {
        let told = kinds(&found(text, &format!("{start}\nG98\n{moves}\nM30")));
        assert!(told.is_empty() || told == [(4, "stopped-spindle-into-workpiece")], "{start} {text}: {told:?}");
        !told.is_empty()
    };
    // The main spindle, the sub spindle, the driven tool, none.
    let starts = ["S500M3", "M143P500", "M133P2000", "M5"];
    assert_eq!(starts.map(|start| stopped(start, across, &insert("haas"))), [false, false, true, true]);
    assert_eq!(starts.map(|start| stopped(start, across, &mill("haas"))), [true, true, false, true]);
    // On the axis it cuts whichever of the two turns.
    for turns in ["", "turns = \"own\"\n"] {
        let drill = format!("{drill}{turns}");
        assert_eq!(starts.map(|start| stopped(start, along, &drill)), [false, false, false, true], "{turns}");
    }
    // One that stands needs the bar to turn.
    let standing = format!("{drill}turns = \"none\"\n");
    assert_eq!(starts.map(|start| stopped(start, along, &standing)), [false, false, true, true]);
    // Elsewhere M3 may turn either.
    assert!(!stopped("S500M3", across, &insert("fanuc")) && !stopped("S500M3", across, &mill("fanuc")));
    // So where the bar stays whole.
    let settings = Settings { cutting: Cutting::Never, ..with_zones(&[]) };
    let whole = |start: &str| checked(&scene(&insert("haas"), &format!("{start}\nG98\n{across}\nM30")), &settings);
    assert_eq!(kinds(&whole("M133P2000")), [(4, "stopped-spindle-into-workpiece")]);
    assert_eq!(kinds(&whole("S500M3")), []);
}

#[test]
fn a_tool_that_is_turned_later_cuts_all_the_same() {
    let text = [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
        &part("insert", "turret", "cutter", [30.0, 0.0, 68.0], &cuboid([8.0, 2.0, 10.0])),
    ]
    .concat();
    // X is a diameter: turned, it is from 11 to 21 mm beside the axis.
    let told = found(&text, "G0 B90\nM3 S500\nG1 X-24 F200\nG1 Z-50\nG0 X0\nM2");
    assert!(told.is_clear(), "{:?}", told.events);
    // While it turns nothing is taken away for sure, nor left.
    let told = found(&text, "M3 S500\nG1 X-24 Z-40 F200\nG1 B45\nG0 X0\nM2");
    assert!(told.events.iter().all(|event| event.kind == Kind::Unresolved), "{:?}", told.events);
}

#[test]
fn a_chuck_that_carries_a_turning_part_is_on_a_spindle_all_the_same() {
    let text = |spun: &str| {
        let drawbar = "[[machine.links]]\nname = \"drawbar\"\nparent = \"spindle\"\njoint = { axis = \"A\", direction = [1, 0, 0] }\n";
        let chuck = part("chuck", "spindle", "fixture", [0.0; 3], &cuboid([80.0, 20.0, 20.0])) + spun;
        let weight = part("weight", "drawbar", "machine", [0.0, 0.0, -40.0], &cuboid([4.0, 4.0, 4.0]));
        // Beside the chuck as drawn, within its reach when it turns.
        let post = part("post", "", "machine", [0.0, 35.0, 0.0], &cuboid([10.0, 10.0, 10.0]));
        let insert = part("insert", "slide", "cutter", [90.0, 0.0, 60.0], &cuboid([4.0, 2.0, 4.0]));
        [LATHE, drawbar, &chuck, &weight, &post, &insert].concat()
    };
    let told = found(&text(""), "M3 S500\nG1 Z-1 F100\nM2");
    assert_eq!(kinds(&told), [(0, "unresolved")]);
    // As drawn the two never meet, and yet they are examined.
    let of_two = told.decisions.iter().find(|decision| decision.pair == told.events[0].pair).unwrap();
    assert!(of_two.dropped.is_none(), "{of_two:?}");
    assert_eq!(kinds(&found(&text("turns = \"none\"\n"), "M3 S500\nG1 Z-1 F100\nM2")), []);
}

/// A block whose top is at 10 mm, and a cutter whose tip is 20 mm above Z.
pub(super) fn block_and_cutter() -> String {
    let block = part("block", "", "workpiece", [0.0; 3], &cuboid([60.0, 20.0, 20.0]));
    [HEAD, &block, &part("cutter", "head", "cutter", [0.0, 0.0, 20.0], &cylinder(2.0, 20.0)), NO_TIP].concat()
}

/// Its slanted face is two triangles, whose boxes fill the other half of the wedge's.
#[test]
fn beside_the_slanted_face_of_a_workpiece_there_is_no_stock() {
    let wedge = "{ kind = \"extrude\", height_mm = 20, outline_mm = [[0, 0], [60, 0], [0, 60]] }";
    for (y, expected) in [(50.0, vec![]), (12.5, vec![]), (8.0, vec![(3, "rapid-into-workpiece")])] {
        let cutter = part("cutter", "head", "cutter", [0.0, y, 40.0], &cylinder(1.0, 20.0));
        let text = [HEAD, &part("wedge", "", "workpiece", [0.0; 3], wedge), &cutter, NO_TIP].concat();
        let told = found(&text, "M3 S1000\nG0 X50\nG0 Z-35\nM2");
        assert_eq!((kinds(&told), told.touches.len()), (expected, 0), "{y}");
    }
}

#[test]
fn an_arc_cuts_where_it_leads_and_not_along_its_chord() {
    // Through the block down to 1 mm, or above it; the last rapid goes down to 2 mm.
    for (arc, expected) in [("G2", vec![]), ("G3", vec![(7, "rapid-into-workpiece")])] {
        let program = format!("M3 S1000\nG18\nG0 X-10 Z-9\n{arc} X10 Z-9 R10 F500\nG0 Z0\nG0 X0\nG0 Z-18\nM2");
        assert_eq!(kinds(&found(&block_and_cutter(), &program)), expected, "{arc}");
    }
}

#[test]
fn the_first_collision_is_looked_for_in_every_workpiece() {
    let text = [
        HEAD,
        &part("left", "", "workpiece", [-50.0, 0.0, 0.0], &cuboid([20.0, 20.0, 20.0])),
        &part("right", "", "workpiece", [50.0, 0.0, 0.0], &cuboid([20.0, 20.0, 20.0])),
        &part("cutter", "head", "cutter", [0.0, 0.0, 20.0], &cylinder(2.0, 20.0)),
        NO_TIP,
    ]
    .concat();
    let settings = Settings { stop_at_first: true, ..with_zones(&[]) };
    let right = "M3 S1000\nG0 X50\nG0 Z-15\n";
    for program in [format!("{right}M2"), format!("{right}G0 Z20\nG0 X-50\nG0 Z-15\nM2")] {
        assert_eq!(kinds(&checked(&scene(&text, &program), &settings)), [(3, "rapid-into-workpiece")], "{program}");
    }
    let told = found(&text, "M3 S1000\nG0 X-50\nG0 Z-15\nM2");
    assert_eq!((kinds(&told), told.events[0].pair.other(2)), (vec![(3, "rapid-into-workpiece")], 0));
}

#[test]
fn a_standing_cutter_is_told_once_on_each_line_on_which_it_feeds_into_what_is_left() {
    let program = "M3 S1000\nG1 Z-15 F500\nM5\nG1 X3\nG1 X6 Z-16\nG1 X9\nM3 S1000\nG1 X12\nM2";
    let kind = "stopped-spindle-into-workpiece";
    assert_eq!(kinds(&found(&block_and_cutter(), program)), [(4, kind), (5, kind), (6, kind)]);
}

#[test]
fn a_thin_cutter_that_feeds_makes_the_stock_finer() {
    let resolution_mm = |cutter: f64, shank: f64, program: &str| {
        let text = [
            HEAD,
            &part("block", "", "workpiece", [0.0; 3], &cuboid([20.0, 20.0, 20.0])),
            &part("cutter", "head", "cutter", [0.0, 0.0, 15.0], &cylinder(cutter, 20.0)),
            &part("shank", "head", "shank", [0.0, 0.0, 35.0], &cylinder(shank, 20.0)),
            NO_TIP,
        ];
        found(&text.concat(), program).remaining[0].stock.resolution_mm()
    };
    let (feed, rapid) = ("M3 S1000\nG1 Z-6 F500\nM2", "M3 S1000\nG0 Z-4\nM2");
    assert!((resolution_mm(0.08, 2.0, feed) - 0.04).abs() < 0.002);
    assert_eq!([(0.08, 2.0, rapid), (2.0, 0.08, feed)].map(|(c, s, program)| resolution_mm(c, s, program)), [0.1, 0.1]);
}

#[test]
fn an_axis_is_within_a_part_where_it_passes_through_its_box() {
    let block = part("block", "", "fixture", [0.0; 3], &cuboid([10.0, 20.0, 30.0]));
    let scene = scene(&[HEAD, &block, NO_TIP].concat(), "G0 X1\nM2");
    for (x, y, expected) in [
        (0.0, 0.0, true),
        (4.0, 0.0, true),
        (6.0, 0.0, false),
        (-6.0, 0.0, false),
        (0.0, -9.0, true),
        (0.0, 11.0, false),
        (0.0, -11.0, false),
    ] {
        let axis_from_part = crate::geometry::Isometry::translation(x, y, 3.0);
        let is_around = crate::check::turning::is_around(&scene.parts[0].mesh, &axis_from_part);
        assert_eq!(is_around, expected, "{x} {y}");
    }
}

/// Its lowest corner passes 0.3 mm above the block, on a way of 120 degrees that is one sample.
#[test]
fn what_swings_past_the_workpiece_is_as_near_as_it_is_however_coarse_the_samples_are() {
    let swing = "[[machine.links]]\nname = \"swing\"\nparent = \"head\"\njoint = { axis = \"B\", direction = [0, 1, 0], point_mm = [0, 0, 100] }\n";
    let coarse = "[program]\nfile = \"own.ngc\"\nstep_mm = 1000\nstep_deg = 1000\n";
    let told = |above: f64| {
        let top = 100.0 - 5_f64.hypot(70.0) - above;
        let block = part("block", "", "workpiece", [0.0, 0.0, top - 10.0], &cuboid([100.0, 100.0, 20.0]));
        let cutter = part("cutter", "swing", "cutter", [0.0, 0.0, 30.0], &cylinder(5.0, 30.0));
        found(&[HEAD, swing, &block, &cutter, coarse].concat(), "M3 S1000\nG0 B-60\nG0 B60\nM2")
    };
    let clear = told(0.3);
    assert!(clear.is_clear() && clear.touches.is_empty(), "{:?} {:?}", clear.events, clear.touches);
    // Upright it stands in the block before the first move.
    assert_eq!(kinds(&told(-0.3)), [(0, "collision"), (3, "rapid-into-workpiece")]);
}

#[test]
fn a_lathe_without_the_axis_of_its_workpiece_cuts_nothing() {
    let text = [
        LATHE,
        &part("block", "", "workpiece", [0.0; 3], &cuboid([40.0, 40.0, 40.0])),
        &part("insert", "slide", "cutter", [30.0, 0.0, 40.0], &cuboid([4.0, 2.0, 4.0])),
    ]
    .concat();
    let told = found(&text, "M3 S500\nG1 X-26 F200\nG1 Z-50\nM2");
    assert_eq!(told.uncut, [0]);
    assert_eq!(kinds(&told)[0].1, "unresolved");
}

#[test]
fn what_is_thinner_than_the_resolution_is_not_free_in_the_stock() {
    let blade_on =
        |arbor: &str| format!("{{ kind = \"revolve\", profile_mm = [[0, 0], [8, 0], [8, 0.8], {arbor}[0, 0.8]] }}");
    let arbor = blade_on("[3, 0.8], [3, 40], [0, 40], ");
    // The blade is within the block, the arbor above it.
    let (into, blade_into) = ("Z-15", "Z-5.7");
    for (shape, to, resolution_mm, kind) in [
        (cylinder(0.05, 20.0), into, 0.1, "unresolved"),
        (cylinder(1.0, 20.0), into, 0.1, "rapid-into-workpiece"),
        (cylinder(1.0, 20.0), into, 3.0, "unresolved"),
        (blade_on(""), blade_into, 1.0, "unresolved"),
        (arbor.clone(), blade_into, 1.0, "unresolved"),
        (arbor, blade_into, 0.1, "rapid-into-workpiece"),
    ] {
        let text = [
            HEAD,
            &part("block", "", "workpiece", [0.0; 3], &cuboid([20.0, 20.0, 20.0])),
            &part("cutter", "head", "cutter", [0.0, 0.0, 15.0], &shape),
            NO_TIP,
        ]
        .concat();
        let settings = Settings { cutting: Cutting::At(resolution_mm), ..with_zones(&[]) };
        let told = checked(&scene(&text, &format!("M3 S1000\nG0 {to}\nM2")), &settings);
        assert_eq!(kinds(&told), [(2, kind)], "{shape} {resolution_mm}");
        let [least, _] = told.events[0].depth_mm.unwrap();
        assert_eq!(least > 0.0, kind != "unresolved", "{shape} {resolution_mm}: {least}");
        // What is not certain is told from the beginning of the move on.
        assert_eq!(told.events[0].first.place < 1e-9, kind == "unresolved", "{shape} {resolution_mm}");
    }
}

#[test]
fn a_tolerance_below_rounding_ends_the_search_in_the_stock_too() {
    let text = [
        HEAD,
        &part("block", "", "workpiece", [0.0; 3], &cuboid([20.0, 20.0, 20.0])),
        &part("cutter", "head", "cutter", [0.0, 0.0, 15.0], &cylinder(2.0, 20.0)),
        &part("holder", "head", "holder", [0.0, 0.0, 25.0], &cylinder(8.0, 20.0)),
        NO_TIP,
    ]
    .concat();
    let settings = Settings { tolerance_mm: 1e-300, ..with_zones(&[]) };
    for (program, kind) in [("G0 Z-15\nM2", "rapid-into-workpiece"), ("M3 S100\nG1 Z-20 F100\nM2", "collision")] {
        let told = checked(&scene(&text, program), &settings);
        assert!(kinds(&told).iter().any(|(_, found)| *found == kind), "{:?}", told.events);
    }
}

/// A drill of a bank 40 mm beside the spindle's axis, of this shape, and a cutter in the spindle, over a block on a slide along Y.
fn bank(drill: &str, turns: &str) -> String {
    let bed = "[[machine.links]]\nname = \"bed\"\njoint = { axis = \"Y\", direction = [0, -1, 0] }\n";
    [
        HEAD,
        bed,
        &part("block", "bed", "workpiece", [0.0; 3], &cuboid([100.0, 100.0, 20.0])),
        &part("drill", "head", "cutter", [40.0, 0.0, 30.0], drill),
        &format!("tool = 1\n{turns}"),
        &part("mill", "head", "cutter", [0.0, 0.0, 30.0], &cylinder(2.0, 40.0)),
        "tool = 2\n",
        TIP,
    ]
    .concat()
}

/// One hole at X 0, Y 0; then the cutter in the spindle comes down at a place.
fn drilled_and_entered(place: &str) -> String {
    format!("T1 M6\nM3 S1000\nG0 X-40\nG1 Z-35 F100\nG0 Z0\nT2 M6\nM3 S1000\nG0 {place}\nG0 Z-30\nG0 Z0\nM2")
}

#[test]
fn what_holds_a_drill_of_a_bank_turns_with_it_or_stands() {
    let drill = bank(&cylinder(2.0, 40.0), "");
    let unsure = |tool: u32, turns: &str| {
        let holder = part("holder", "head", "holder", [40.0, 0.0, 70.0], &cuboid([10.0, 10.0, 10.0]));
        let holder = format!("{holder}tool = {tool}\n{turns}");
        found(&drill.replacen("[program]", &format!("{holder}[program]"), 1), &drilled_and_entered("X0")).unsure
    };
    assert_eq!([unsure(1, ""), unsure(2, ""), unsure(1, "turns = \"none\"\n")], [vec![1, 3], vec![1], vec![1]]);
}

#[test]
fn a_drill_of_a_bank_cuts_its_hole_alone_for_sure() {
    // At X-12 Y-28 the cutter is on the circle that the drill describes about the spindle's axis, if that turns it.
    let (beside, in_the_hole) = (drilled_and_entered("X-12 Y-28"), drilled_and_entered("X0 Y0"));
    let (drill, fluted) = (cylinder(4.0, 40.0), cuboid([6.0, 6.0, 40.0]));
    for (shape, turns, expected, known) in [
        (&drill, "", Some("unresolved"), true),
        (&fluted, "", Some("unresolved"), false),
        (&drill, "turns = \"own\"\n", Some("rapid-into-workpiece"), true),
        (&fluted, "turns = \"own\"\n", Some("rapid-into-workpiece"), true),
        (&drill, "turns = \"spindle\"\n", None, true),
    ] {
        let text = bank(shape, turns);
        let told = found(&text, &beside);
        assert_eq!(kinds(&told), expected.map(|kind| (9, kind)).into_iter().collect::<Vec<_>>(), "{shape} {turns}");
        assert_eq!(told.unsure, if turns.is_empty() { vec![1] } else { vec![] });
        let told = found(&text, &in_the_hole);
        assert_eq!(told.is_clear(), known, "{shape} {turns}: {:?}", told.events);
    }
    // What nothing turns takes nothing away.
    let told = found(&bank(&drill, "turns = \"none\"\n"), &beside);
    assert_eq!(kinds(&told)[0], (4, "stopped-spindle-into-workpiece"));
}

#[test]
fn the_cutter_of_an_angle_head_cuts_no_disc_for_sure() {
    let text = bank(&cylinder(8.0, 60.0), "").replace("[40.0, 0.0, 30.0]", "[30.0, 0.0, 30.0], rpy_deg = [0, 90, 0]");
    let slot = "T1 M6\nM3 S1000\nG0 X-145\nG0 Z-25\nG1 X-120 F100\nG1 X-145\n";
    assert!(found(&text, &format!("{slot}G0 Z50\nM2")).is_clear());
    let told = found(&text, &format!("{slot}G0 Y25\nG0 X-130\nM2"));
    assert_eq!((kinds(&told), told.unsure), (vec![(8, "unresolved")], vec![1]));
}

fn without_joint() -> String {
    let spindle = "[[machine.links]]\nname = \"spindle\"\njoint = { axis = \"C\", direction = [0, 0, 1] }\n";
    assert!(LATHE.contains(spindle));
    LATHE.replace(spindle, "")
}

/// A lathe without a joint for its spindle: a chuck that is 100 mm across and 20 mm wide, and an insert that comes between 38 and 42 mm from the axis beside it.
fn without_spindle(chuck_at: [f64; 3], turns: &str) -> String {
    [
        &without_joint(),
        &part("bar", "", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
        &part("chuck", "", "fixture", chuck_at, &cuboid([20.0, 100.0, 20.0])),
        turns,
        &part("insert", "slide", "cutter", [60.0, 0.0, -20.0], &cuboid([4.0, 2.0, 4.0])),
    ]
    .concat()
}

#[test]
fn a_chuck_turns_where_no_joint_says_so() {
    let (chuck, program) = ([0.0, 0.0, -20.0], "M3 S500\nG1 X-40 F200\nM2");
    let told = found(&without_spindle(chuck, ""), program);
    assert_eq!((kinds(&told), told.as_drawn), (vec![(2, "unresolved")], vec![]));
    assert!(found(&without_spindle(chuck, ""), "G1 X-40 F200\nM2").is_clear());
    let told = found(&without_spindle(chuck, "turns = \"none\"\n"), program);
    assert_eq!((told.is_clear(), told.as_drawn), (true, vec![]));
    // A steady is on one side: it is named, unless the scene says that it turns.
    let steady = [0.0, 65.0, -20.0];
    let told = found(&without_spindle(steady, ""), program);
    assert_eq!((told.is_clear(), told.as_drawn), (true, vec![1]));
    // 4 mm beside the axis it is off balance.
    let told = found(&without_spindle([0.0, 4.4, -20.0], ""), program);
    assert_eq!((told.is_clear(), told.as_drawn), (true, vec![1]));
    // 2 mm beside it, 0.04 of its reach, it is not.
    let told = found(&without_spindle([0.0, 2.0, -20.0], ""), program);
    assert_eq!((kinds(&told), told.as_drawn), (vec![(2, "unresolved")], vec![]));
    // So wherever its link has its frame; on the carriage it is not beside the bar.
    let own = without_spindle(chuck, "");
    let told = found(&on_ram(&own, "chuck", chuck, [0.0, -30.0, -20.0], "", [0.0, 30.0, 0.0]), program);
    assert_eq!((kinds(&told), told.as_drawn), (vec![(2, "unresolved")], vec![]));
    let told = found(&own.replace("role = \"fixture\"\n", "link = \"carriage\"\nrole = \"fixture\"\n"), program);
    assert_eq!((told.is_clear(), told.as_drawn), (true, vec![1]));
    // A chuck that is a part of the machine turns where the scene says so.
    for (turns, expected) in [("", vec![]), ("turns = \"spindle\"\n", vec![(2, "unresolved")])] {
        let of_machine = without_spindle(chuck, turns).replace("role = \"fixture\"\n", "role = \"machine\"\n");
        let told = found(&of_machine, program);
        assert_eq!((kinds(&told), told.as_drawn), (expected, vec![]), "{turns}");
    }
    // Where it does, the insert is in its ring from the beginning.
    let told = found(&without_spindle(steady, "turns = \"spindle\"\n"), program);
    assert_eq!(kinds(&told), [(0, "unresolved")]);
    // Jaws that are parts of their own are balanced together.
    let jaw = |name: &str, y: f64| part(name, "", "fixture", [0.0, y, -20.0], &cuboid([20.0, 20.0, 20.0]));
    let whole = part("chuck", "", "fixture", chuck, &cuboid([20.0, 100.0, 20.0]));
    let jaws = without_spindle(chuck, "").replace(&whole, &(jaw("one", 40.0) + &jaw("two", -40.0)));
    let told = found(&jaws, program);
    assert!(!told.is_clear() && told.as_drawn.is_empty());
}

#[test]
fn a_chuck_without_a_workpiece_turns_or_is_named() {
    let (chuck, program) = ([0.0, 0.0, -20.0], "M3 S500\nG1 X-40 F200\nM2");
    let bar = part("bar", "", "workpiece", [0.0; 3], &cylinder(20.0, 50.0));
    let told = found(&without_spindle(chuck, "").replace(&bar, ""), program);
    assert_eq!((told.is_clear(), told.as_drawn), (true, vec![0]));
    let text = [
        LATHE,
        &part("chuck", "spindle", "fixture", chuck, &cuboid([20.0, 100.0, 20.0])),
        &part("insert", "slide", "cutter", [60.0, 0.0, -20.0], &cuboid([4.0, 2.0, 4.0])),
    ]
    .concat();
    assert_eq!(kinds(&found(&text, program)), [(2, "unresolved")]);
    // A dog beside the axis passes between 30 and 51 mm from it.
    let dog = part("dog", "spindle", "fixture", [0.0, 40.0, -20.0], &cuboid([20.0, 20.0, 20.0]));
    let insert = part("insert", "slide", "cutter", [60.0, 0.0, -20.0], &cuboid([4.0, 2.0, 4.0]));
    let at = |x: i32| kinds(&found(&[LATHE, &dog, &insert].concat(), &format!("M3 S500\nG1 X{x} F200\nM2")));
    assert_eq!([-4, -20].map(at), [vec![], vec![(2, "unresolved")]]);
}

#[test]
fn what_turns_beside_the_axis_leaves_its_middle_free_wherever_its_sides_are() {
    // The dog is from 30 to 50 mm beside the axis. One of its sides may lie in a plane through the axis. The insert stays within 12.5 mm, or 33.
    for dog in [[0.0, 40.0, -20.0], [10.0, 40.0, -20.0], [-10.0, 40.0, -20.0]] {
        for (x, expected) in [(10.0, vec![]), (31.0, vec![(2, "unresolved")])] {
            let text = [
                LATHE,
                &part("dog", "spindle", "fixture", dog, &cuboid([20.0, 20.0, 20.0])),
                &part("insert", "slide", "cutter", [x, 0.0, -60.0], &cuboid([4.0, 2.0, 4.0])),
            ];
            assert_eq!(kinds(&found(&text.concat(), "M3 S500\nG1 Z80 F200\nM2")), expected, "{dog:?} {x}");
        }
    }
}

#[test]
fn the_chuck_of_a_second_spindle_turns_or_is_named() {
    let second = "[[machine.links]]\nname = \"slide-2\"\njoint = { axis = \"W\", direction = [0, 0, 1] }\n\
        [[machine.links]]\nname = \"spindle-2\"\nparent = \"slide-2\"\njoint = { axis = \"A\", direction = [0, 0, 1] }\n[program]";
    let (spindle, nothing) = ("turns = \"spindle\"\n", "turns = \"none\"\n");
    for (link, role, turns, tool_link, meets, named) in [
        ("spindle-2", "fixture", "", "slide", true, false),
        ("spindle-2", "fixture", spindle, "slide", true, false),
        ("spindle-2", "fixture", nothing, "slide", false, false),
        ("spindle-2", "machine", spindle, "slide", true, false),
        ("spindle-2", "machine", "", "slide", false, false),
        // No joint turns it.
        ("slide-2", "fixture", "", "slide", false, true),
        ("slide-2", "fixture", nothing, "slide", false, false),
        // A steady on a turret.
        ("turret", "fixture", "", "turret", false, true),
    ] {
        let text = [
            &LATHE.replacen("[program]", second, 1),
            &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
            &part("chuck", link, role, [0.0, 0.0, -20.0], &cuboid([20.0, 100.0, 20.0])),
            turns,
            &part("insert", tool_link, "cutter", [60.0, 0.0, -20.0], &cuboid([4.0, 2.0, 4.0])),
        ]
        .concat();
        let told = found(&text, "M3 S500\nG1 X-40 F200\nM2");
        let expected = if meets { vec![(2, "unresolved")] } else { vec![] };
        assert_eq!(
            (kinds(&told), told.as_drawn),
            (expected, if named { vec![1] } else { vec![] }),
            "{link} {role} {turns}"
        );
    }
}

#[test]
fn a_boring_insert_leaves_the_ring_that_it_has_cut() {
    let tube = "{ kind = \"revolve\", profile_mm = [[10, 0], [30, 0], [30, 50], [10, 50]] }";
    let text = [
        LATHE,
        &part("tube", "spindle", "workpiece", [0.0; 3], tube),
        // Its corners are 12.09 mm from the axis.
        &part("insert", "slide", "cutter", [10.0, 0.0, 60.0], &cuboid([4.0, 3.0, 4.0])),
    ]
    .concat();
    for back in ["X-2", "X-12"] {
        let told = found(&text, &format!("M3 S500\nG1 Z-40 F200\nG0 {back}\nG0 Z0\nM2"));
        assert!(told.is_clear(), "{back}: {:?}", told.events);
    }
    let told = found(&text, "M3 S500\nG1 Z-40 F200\nG0 X-2\nG0 X1\nM2");
    assert_eq!(kinds(&told), [(4, "rapid-into-workpiece")]);
    let mut stock = found(&text, "M3 S500\nG1 Z-40 F200\nG0 X-2\nG0 Z0\nM2").remaining[0].stock.clone();
    assert_eq!(stock.material_at(&Point::new(12.02, 0.0, 30.0)), Material::Gone);
    assert_eq!(stock.material_at(&Point::new(12.25, 0.0, 30.0)), Material::Solid);
}

/// A bar of 40 mm and an insert whose outline lies in the plane of the axis, 4 mm thick.
fn with_insert(at: [f64; 3], outline: &str) -> String {
    let insert = format!("{{ kind = \"extrude\", height_mm = 4, outline_mm = {outline} }}");
    let placed =
        part("insert", "slide", "cutter", at, &insert).replace("] }\nshape", "], rpy_deg = [90, 0, 0] }\nshape");
    [LATHE, &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)), &placed].concat()
}

#[test]
fn a_rear_tool_cuts_on_its_side_wherever_the_program_begins() {
    for side in [1, -1] {
        for start in [60, -60] {
            // 17 mm beside the axis at the front, or at the rear.
            let insert = part("insert", "slide", "cutter", [f64::from(2 * side), 0.0, 2.0], &cuboid([4.0, 2.0, 4.0]));
            let shank = part("shank", "slide", "shank", [f64::from(34 * side), 0.0, 4.0], &cuboid([60.0, 10.0, 8.0]));
            let text = [
                LATHE.replace("[program]", &format!("[program]\nstart = {{ x_mm = {start}, z_mm = 60 }}")).as_str(),
                &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
                &insert,
                &shank,
            ]
            .concat();
            let cut =
                format!("M3 S500\nG0 X{}\nG0 X{}\nG1 Z40 F200\nG0 X{} Z45\nG0 Z60\n", 80 * side, 34 * side, 44 * side);
            let told = found(&text, &format!("{cut}M2"));
            assert!(told.is_clear(), "{side} {start}: {:?}", told.events);
            let told = found(&text, &format!("{cut}G0 X{}\nG0 Z30\nM2", 34 * side));
            assert_eq!(kinds(&told)[0], (8, "rapid-into-workpiece"), "{side} {start}");
        }
    }
}

#[test]
fn a_slanted_insert_faces_past_the_centre() {
    let text = with_insert([30.0, 2.0, 60.0], "[[0, 0], [11, 1], [12, 12], [1, 11]]");
    let told = found(&text, "M3 S500\nG0 Z-11\nG1 X-61.6 F200\nG0 Z0\nG0 X0\nM2");
    assert!(told.is_clear(), "{:?}", told.events);
    assert_eq!(kinds(&found(&text, "M3 S500\nG0 Z-11\nG1 X-61.6 F200\nG0 Z-12\nM2")), [(4, "rapid-into-workpiece")]);
}

#[test]
fn an_insert_that_leans_towards_the_face_leaves_it_past_the_centre() {
    for lean in [0, 1, 3, 8] {
        let text = with_insert([30.0, 2.0, 60.0], &format!("[[0, 0], [12, -{lean}], [12, 10], [1, 12]]"));
        let told = found(&text, "M3 S500\nG0 Z-11\nG1 X-61.6 F200\nG0 Z0\nG0 X0\nM2");
        assert!(told.is_clear(), "{lean}: {:?}", told.events);
        let told = found(&text, "M3 S500\nG0 Z-11\nG1 X-61.6 F200\nG0 Z-12\nM2");
        assert_eq!(kinds(&told), [(4, "rapid-into-workpiece")], "{lean}");
    }
}

#[test]
fn a_tool_that_never_feeds_is_free_behind_the_bar_as_in_front_of_it() {
    let text = [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
        &part("insert", "slide", "cutter", [60.0, 0.0, 90.0], &cuboid([20.0, 0.1, 2.0])),
    ]
    .concat();
    for (x, expected) in [(-190, vec![]), (-300, vec![]), (-150, vec![(3, "rapid-into-workpiece")])] {
        assert_eq!(kinds(&found(&text, &format!("M3 S500\nG0 X{x}\nG0 Z-60\nG0 Z0\nM2"))), expected, "{x}");
    }
}

#[test]
fn a_notched_bar_turns_about_the_middle_of_its_outside_wherever_its_file_has_it() {
    let corner = |k: u32| {
        let (sin, cos) = (2.0 * f64::from(k)).to_radians().sin_cos();
        let radius = if (1..=10).contains(&k) { 15.0 } else { 20.0 };
        format!("[{}, {}]", 300.0 + radius * cos, radius * sin)
    };
    let outline: Vec<String> = (0..180).map(corner).collect();
    let bar = format!("{{ kind = \"extrude\", height_mm = 50, outline_mm = [{}] }}", outline.join(", "));
    let insert = |name: &str, x: f64, tool: u32| {
        part(name, "slide", "cutter", [x, 0.0, 90.0], &cuboid([20.0, 0.1, 2.0]))
            + &format!("tool = {tool}\nturns = \"none\"\n")
    };
    let text = [
        without_joint().as_str(),
        &part("bar", "", "workpiece", [-300.0, 0.0, 0.0], &bar),
        &insert("front", 60.0, 1),
        &insert("rear", -60.0, 2),
    ]
    .concat();
    // The front tool turns to 18 mm, the rear one comes to 17.5.
    for (x, expected) in [(65, Some(9)), (63, None)] {
        let program =
            format!("T1 M6\nM3 S500\nG0 Z-60\nG1 X-64 F100\nG0 X0\nT2 M6\nM3 S500\nG1 X-2 F1000\nG0 X{x}\nG0 X0\nM2");
        assert_eq!(kinds(&found(&text, &program)).first().map(|(line, _)| *line), expected, "{x}");
    }
}

#[test]
fn an_insert_beside_the_plane_of_the_axis_faces_past_the_centre_and_leaves_the_middle() {
    for y in [-0.02, -0.05, -1.0, 5.0] {
        let text = with_insert([30.0, y, 60.0], "[[0, 0], [8, 0], [8, 3], [0, 3]]");
        // 0.8 mm past the centre, 1 mm below the face.
        let told = found(&text, "M3 S500\nG0 Z-11\nG1 X-61.6 F200\nG0 Z0\nG0 X0\nM2");
        assert!(told.is_clear(), "{y}: {:?}", told.events);
        if y.abs() >= 1.0 {
            let mut stock = told.remaining[0].stock.clone();
            assert_eq!(stock.material_at(&Point::new(0.8, 0.0, 49.5)), Material::Solid, "{y}");
            assert_eq!(stock.material_at(&Point::new(1.2, 0.0, 49.5)), Material::Gone, "{y}");
        }
        let told = found(&text, "M3 S500\nG0 Z-11\nG1 X-61.6 F200\nG0 Z-12\nM2");
        assert_eq!(kinds(&told), [(4, "rapid-into-workpiece")], "{y}");
    }
}

#[test]
fn an_insert_that_reaches_across_the_axis_leaves_a_bore() {
    let tube = "{ kind = \"revolve\", profile_mm = [[4.5, 0], [25, 0], [25, 50], [4.5, 50]] }";
    let text = [
        LATHE,
        &part("tube", "spindle", "workpiece", [0.0; 3], tube),
        &part("insert", "slide", "cutter", [30.0, 0.0, 70.0], &cuboid([4.0, 4.0, 3.0])),
    ]
    .concat();
    // From x = -2.95 to 1.05, 1 mm deep in the bore: 3.56 mm from the axis at most. Then far out and up.
    let program = |x: f64| format!("M3 S500\nG0 X{x}\nG0 Z-19.5\nG0 X{} Z136.5\nM2", x + 198.0);
    let told = found(&text, &program(-61.9));
    assert!(told.is_clear(), "{:?}", told.events);
    // 4.85 mm from the axis.
    assert_eq!(kinds(&found(&text, &program(-64.84)))[0].0, 3);
}

#[test]
fn an_insert_cuts_wherever_its_rake_face_is() {
    for y in [0.0, 0.001, -0.001, 0.5, 3.9] {
        let text = with_insert([30.0, y, 60.0], "[[0, 0], [9, -5], [9, 5]]");
        let told = found(&text, "M3 S500\nG0 X-22\nG1 Z-40 F200\nG0 X0\nG0 Z0\nG0 X-24\nG1 Z-40\nG0 X0\nG0 Z0\nM2");
        assert!(told.is_clear(), "{y}: {:?}", told.events);
        let told = found(&text, "M3 S500\nG0 X-22\nG1 Z-40 F200\nG0 X-25\nM2");
        assert_eq!(kinds(&told), [(4, "rapid-into-workpiece")], "{y}");
    }
}

#[test]
fn a_button_insert_stands_where_the_scene_says_so() {
    let text = |turns: &str| {
        let insert = part("insert", "slide", "cutter", [36.0, 2.0, 66.0], &cylinder(6.0, 4.0));
        [
            LATHE,
            &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
            &insert.replace("] }\nshape", "], rpy_deg = [90, 0, 0] }\nshape"),
            turns,
            &part("shank", "slide", "shank", [68.0, 0.0, 74.0], &cuboid([60.0, 20.0, 20.0])),
        ]
        .concat()
    };
    let program = "M3 S500\nG0 X-40\nG1 Z-40 F200\nG0 Z0\nM2";
    let told = found(&text("turns = \"none\"\n"), program);
    assert_eq!((told.is_clear(), told.driven.len()), (true, 0), "{:?}", told.events);
    let told = found(&text(""), program);
    assert_eq!((told.is_clear(), told.driven), (false, vec![1]));
    assert!(found(&text("turns = \"own\"\n"), program).driven.is_empty());
}

#[test]
fn an_insert_between_whose_feeds_the_chuck_turns_cuts_no_disc_for_sure() {
    let insert = with_insert([30.0, 2.0, 60.0], "[[0, 0], [9.19, -7.71], [18.38, 0], [9.19, 7.71]]") + "tool = 1\n";
    // Beside the tip, where the insert's own disc has been and its outline has not.
    let probe = part("probe", "slide", "holder", [30.0, 0.0, 63.5], &cuboid([2.0, 2.0, 2.0])) + "tool = 2\n";
    let program =
        "T1 M6\nM3 S500\nG0 Z-30\nG0 C90\nG1 X-10 F1000\nG0 C0\nG1 X-28 F100\nG0 X0\nT2 M6\nG0 X-22\nG0 X0\nM2";
    for (turns, kind, driven) in [("", "unresolved", vec![1]), ("turns = \"none\"\n", "collision", vec![])] {
        let told = found(&[&insert, turns, &probe].concat(), program);
        assert_eq!((kinds(&told), told.driven), (vec![(10, kind)], driven), "{turns}");
    }
    // What turns behind the last feed is no turn between feeds.
    let told = found(&(insert + &probe), "T1 M6\nM3 S500\nG0 Z-30\nG1 X-28 F100\nG0 C90\nG0 X0\nM2");
    assert!(told.driven.is_empty(), "{:?}", told.driven);
}

#[test]
fn a_cutter_without_a_key_needs_the_spindle_by_which_it_can_cut() {
    use crate::check::turning::Needs;
    let needs = |rpy_deg: [f64; 3], shape: &str, moves: &str| {
        let cutter = part("cutter", "slide", "cutter", [31.0, 0.0, 60.0], shape);
        let text = [
            LATHE,
            "dialect = \"haas\"\n",
            &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
            &cutter.replace("] }\nshape", &format!("], rpy_deg = {rpy_deg:?} }}\nshape")),
        ];
        let scene = scene(&text.concat(), &format!("S500M3\nG98\nG0Z-30.\n{moves}\nM30"));
        let path = Path::new(&scene, scene.program.as_ref().unwrap()).unwrap();
        Needs::of(&scene, &path, 0, 1)
    };
    let feed = "G1X-28.F200.\nG0X0.";
    let insert = cuboid([20.0, 2.0, 3.0]);
    assert!(matches!(needs([0.0; 3], &insert, feed), Needs::OfWorkpiece));
    // A round cutter across the axis is driven. An insert between whose feeds the bar is turned may be driven or stand.
    assert!(matches!(needs([0.0, 90.0, 0.0], &cylinder(6.0, 20.0), feed), Needs::OfTool));
    let turned = format!("{feed}\nG0C90.\n{feed}");
    assert!(matches!(needs([0.0; 3], &insert, &turned), Needs::Any));
}

#[test]
fn what_the_head_carries_beside_the_tool_does_not_turn() {
    let (camera, post) = ([40.0, 0.0, 60.0], [-40.0, 0.0, 0.0]);
    for (role, expected) in [("machine", vec![]), ("holder", vec![(2, "unresolved")])] {
        let text = [
            HEAD,
            &part("post", "", "fixture", post, &cuboid([20.0, 20.0, 60.0])),
            &part("camera", "head", role, camera, &cuboid([10.0, 20.0, 20.0])),
            TIP,
        ]
        .concat();
        let told = found(&text, "M3 S1000\nG0 Z-50\nM2");
        assert_eq!((kinds(&told), told.as_drawn), (expected, vec![]), "{role}");
    }
}

#[test]
fn a_round_holder_in_the_spindle_is_round_on_whatever_link_it_is_drawn() {
    let text = [
        HEAD,
        // From 30 to 50 mm beside the axis.
        &part("wall", "", "fixture", [40.0, 0.0, 0.0], &cuboid([20.0, 100.0, 60.0])),
        &part("holder", "head", "holder", [0.0, 0.0, 60.0], &cylinder(20.0, 30.0)),
        TIP,
    ]
    .concat();
    let on_link = on_ram(&text, "holder", [0.0, 0.0, 60.0], [-30.0, 0.0, 60.0], "head", [30.0, 0.0, 0.0]);
    for text in [text, on_link] {
        let told = found(&text, "M3 S1000\nG0 Z-50\nM2");
        assert!(told.is_clear() && told.as_drawn.is_empty(), "{:?}", told.events);
    }
}

#[test]
fn a_fluted_drill_in_the_spindle_is_turned_by_it_wherever_its_file_has_its_axis() {
    // The axis of the drill is at X 40 of its file.
    let drill = "{ kind = \"extrude\", height_mm = 40, outline_mm = [[37, -3], [43, -3], [43, 3], [37, 3]] }";
    let at = |x: f64| {
        let drill = part("drill", "head", "cutter", [x, 0.0, 30.0], drill);
        let block = part("block", "", "workpiece", [0.0; 3], &cuboid([20.0, 20.0, 20.0]));
        found(&[HEAD, &block, &drill, TIP].concat(), "M3 S1000\nG1 Z-22 F100\nG0 Z0\nM2").unsure
    };
    assert_eq!([-40.0, 0.0].map(at), [vec![], vec![1]]);
}

#[test]
fn what_holds_a_driven_cutter_is_named_where_it_is_no_part_of_the_machine_and_not_round() {
    let along_x = |name: &str, role: &str, x: f64, shape: &str| along_x(name, role, [x, 100.0], shape);
    let mill = along_x("mill", "cutter", 60.0, &cylinder(5.0, 40.0)) + "turns = \"own\"\n";
    let (block, round) = (cuboid([30.0, 20.0, 40.0]), cylinder(15.0, 40.0));
    for (role, shape, named) in [
        ("holder", &block, vec![2]),
        ("holder", &round, vec![]),
        // The turret, and an insert on it.
        ("machine", &block, vec![]),
        ("cutter", &block, vec![]),
    ] {
        let bar = part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0));
        let text = [LATHE, &bar, &mill, &along_x("other", role, 100.0, shape)].concat();
        assert_eq!(found(&text, "M3 S500\nG1 X-10 F200\nM2").as_drawn, named, "{role} {shape}");
    }
}

#[test]
fn jaws_that_slide_on_the_chuck_turn_with_it() {
    let jaw =
        "[[machine.links]]\nname = \"jaw\"\nparent = \"spindle\"\njoint = { axis = \"U\", direction = [1, 0, 0] }\n";
    // Beside a flat of the chuck, within the reach of its corners.
    let text = |link: &str| {
        let chuck = part("chuck", "spindle", "fixture", [0.0; 3], &cuboid([80.0, 20.0, 20.0]));
        [LATHE, jaw, &chuck, &part("jaw", link, "fixture", [0.0, 20.0, 0.0], &cuboid([4.0, 4.0, 4.0]))].concat()
    };
    assert_eq!(kinds(&found(&text("jaw"), "M3 S500\nG0 U5\nM2")), []);
    // What stands there is in its way.
    assert_eq!(kinds(&found(&text("slide"), "M3 S500\nG0 X-5\nM2")), [(0, "unresolved")]);
}

#[test]
fn what_turns_a_table_that_carries_a_spindle_is_no_spindle() {
    let table = "[[machine.links]]\nname = \"table\"\njoint = { axis = \"A\", direction = [0, 0, 1] }\n";
    let spindle = "name = \"spindle\"\n";
    let lathe = LATHE.replacen(spindle, &format!("{spindle}parent = \"table\"\n"), 1);
    // The dog passes between 30 and 51 mm from the axis where it turns.
    for (link, expected, named) in [("table", vec![], vec![1]), ("spindle", vec![(2, "unresolved")], vec![])] {
        let text = [
            lathe.replacen("[[machine.links]]\n", &format!("{table}[[machine.links]]\n"), 1).as_str(),
            &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
            &part("dog", link, "fixture", [0.0, 40.0, -20.0], &cuboid([20.0, 20.0, 20.0])),
            &part("insert", "slide", "cutter", [60.0, 0.0, -20.0], &cuboid([4.0, 2.0, 4.0])),
        ]
        .concat();
        let told = found(&text, "M3 S500\nG1 X-40 F200\nM2");
        assert_eq!((kinds(&told), told.as_drawn), (expected, named), "{link}");
    }
}

/// A mill of 12 mm radius along X, and behind it a holder whose corners pass 7.1 mm from its axis.
fn driven_across(bar: &str, mill: [f64; 2], others: &str) -> String {
    let along_x =
        |name: &str, role: &str, x: f64, shape: &str| along_x(name, role, [x, 60.0], shape) + "turns = \"own\"\n";
    let [radius, length] = mill;
    [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], bar),
        &along_x("mill", "cutter", 40.0, &cylinder(radius, length)),
        &along_x("holder", "holder", 50.0 + length, &cuboid([10.0, 10.0, 20.0])),
        others,
    ]
    .concat()
}

#[test]
fn a_driven_holder_follows_its_mill_into_a_round_bar_that_stands() {
    let text = driven_across(&cylinder(30.0, 50.0), [12.0, 20.0], "");
    let told = found(&text, "M3 S500\nG0 Z-40\nG1 X-70 F200\nG0 X0\nM2");
    assert!(told.is_clear() && told.touches.is_empty(), "{:?}", told.events);
    // A mill of 6 mm leaves no room for its corners.
    let text = driven_across(&cylinder(30.0, 50.0), [6.0, 20.0], "");
    let told = found(&text, "M3 S500\nG0 Z-40\nG1 X-70 F200\nG0 X0\nM2");
    assert_eq!(kinds(&told), [(3, "collision")]);
}

#[test]
fn a_driven_holder_is_in_the_way_of_a_bar_with_corners_at_every_angle_of_both() {
    // Flats of the bar are 20 mm from the axis, its corners 23.1. The holder comes to 21.5 mm over the end of the bar, or to 24.
    let text = driven_across(&polygon(6, 23.1), [2.0, 20.0], "");
    for (x, expected) in [(-77, vec![(3, "unresolved")]), (-72, vec![])] {
        let told = found(&text, &format!("M3 S500\nG0 Z-40\nG1 X{x} F200\nG0 X0\nM2"));
        assert_eq!(kinds(&told), expected, "{x}");
    }
}

#[test]
fn a_holder_that_may_be_driven_follows_its_mill_whatever_else_is_on_the_turret() {
    // It comes beside the bar at last.
    let insert = part("insert", "slide", "cutter", [60.0, 0.0, 110.0], &cuboid([4.0, 2.0, 4.0]));
    let text = driven_across(&cylinder(30.0, 50.0), [12.0, 20.0], &insert);
    let without_key = text
        .replace(&format!("{}\nturns = \"own\"\n", cuboid([10.0, 10.0, 20.0])), &(cuboid([10.0, 10.0, 20.0]) + "\n"));
    for (text, named) in [(&text, vec![]), (&without_key, vec![2])] {
        let told = found(text, "M3 S500\nG0 Z-40\nG1 X-70 F200\nG0 X0\nG0 Z-90\nM2");
        assert!(told.is_clear(), "{:?}", told.events);
        assert_eq!(told.as_drawn, named);
    }
}

/// A ring around the axis, its bore 16 mm, that passes over a bar of 20 mm once that is turned to 14 mm as far as 28 mm above its lower end. Its file has it 5 mm
/// beside the axis.
fn ring_over_bar() -> String {
    let ring = "{ kind = \"revolve\", profile_mm = [[16, 0], [30, 0], [30, 10], [16, 10]] }";
    let ring = format!("{{ kind = \"compound\", parts = [{{ shape = {ring}, at = {{ xyz_mm = [-5, 0, 0] }} }}] }}");
    [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
        &part("insert", "slide", "cutter", [36.0, 0.0, 60.0], &cuboid([12.0, 2.0, 4.0])),
        "tool = 1\n",
        &part("ring", "slide", "holder", [5.0, 0.0, 60.0], &ring),
        "tool = 2\n",
    ]
    .concat()
}

#[test]
fn a_ring_around_the_bar_is_free_of_it_along_the_axis_and_not_aside() {
    let turned = "T1 M6\nM3 S500\nG0 X-32\nG1 Z-30 F200\nG0 X0\nG0 Z0\nT2 M6\nM3 S500\n";
    let told = |moves: &str| kinds(&found(&ring_over_bar(), &format!("{turned}{moves}\nM2")));
    assert_eq!(told("G0 Z-30\nG0 Z0"), []);
    // Onto the shoulder, 3 mm deep.
    assert_eq!(told("G0 Z-30\nG0 Z-35"), [(10, "collision")]);
    // 5 mm aside, 3 mm deep.
    for aside in ["X10", "X-10"] {
        assert_eq!(told(&format!("G0 Z-20\nG0 {aside}")), [(10, "collision")], "{aside}");
    }
}

#[test]
fn what_swings_back_to_where_it_was_does_not_go_along_the_axis() {
    // 5 mm around the bar. A swing of 0.2 radians may take it farther aside.
    let ring = "{ kind = \"revolve\", profile_mm = [[25, 0], [35, 0], [35, 10], [25, 10]] }";
    let text = [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
        &part("ring", "slide", "holder", [0.0, 0.0, 30.0], ring),
    ];
    let scene = scene(&text.concat(), "G0 X1\nM2");
    let (turning, axis) = turning_of(&scene);
    let piece = turning.to_base.piece(&scene.machine, &Position::default(), &Position::default(), 0, 1);
    for (turn, is_free) in [(0.0, true), (0.2, false)] {
        let piece = crate::stock::motion::Piece { turn, way_mm: 200.0 * turn, ..piece };
        let mut stock = Stock::turned(&scene.parts[0].mesh, axis.axis_from_stock, 0.1).unwrap();
        let examined = vec![turning.sweep(&piece, 0.0)];
        let met = stock.run(&[Step { examined, cutting: Vec::new() }], 0.01);
        assert_eq!(met.is_empty(), is_free, "{turn}");
    }
}

#[test]
fn nothing_is_cut_for_sure_while_the_tool_turns() {
    let text = [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
        &part("insert", "turret", "cutter", [30.0, 0.0, 68.0], &cuboid([8.0, 2.0, 10.0])),
    ];
    let scene = scene(&text.concat(), "G0 X1\nM2");
    let (turning, _) = turning_of(&scene);
    for (axis, is_vague) in [(Axis::Z, false), (Axis::B, true)] {
        let mut to = Position::default();
        to[axis] = 0.1;
        let piece = turning.to_base.piece(&scene.machine, &Position::default(), &to, 0, 1);
        assert_eq!(turning.cut(&piece, 0.0).is_vague(), is_vague, "{axis:?}");
    }
}

/// [`LATHE`] with an axis Y, and an insert from 1 mm below its place to 3 mm above it.
fn with_cross_slide(start: f64) -> String {
    let cross =
        "[[machine.links]]\nname = \"cross\"\nparent = \"slide\"\njoint = { axis = \"Y\", direction = [0, 1, 0] }\n";
    let start = format!("[program]\nstart = {{ y_mm = {start} }}");
    let insert = "{ kind = \"extrude\", height_mm = 4, outline_mm = [[0, -1], [12, -1], [12, 3], [0, 3]] }";
    [
        &LATHE.replacen("[program]", &start, 1),
        cross,
        &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
        &part("insert", "cross", "cutter", [30.0, 0.0, 60.0], insert),
    ]
    .concat()
}

#[test]
fn an_insert_cuts_where_it_is_beside_the_plane_of_the_axis_and_not_where_it_was() {
    // With its edge 10 mm beside the axis, from 9 to 13 mm above it or from 7 to 11 below, it turns the bar to 13.45 or 12.21 mm.
    for (start, y, radius) in [(0.0, 10.0, 13.45), (10.0, -10.0, 12.21), (-10.0, 10.0, 13.45)] {
        let told = found(&with_cross_slide(start), &format!("M3 S500\nG0 Y{y}\nG0 X-40\nG1 Z-40 F200\nG1 X0\nM2"));
        assert!(told.is_clear(), "{:?}", told.events);
        let mut stock = told.remaining[0].stock.clone();
        let mut is_gone = |rho: f64| stock.material_at(&Point::new(rho, 0.0, 40.0)) == Material::Gone;
        assert_eq!([is_gone(radius - 0.2), is_gone(radius + 0.2)], [false, true], "{start} {y}");
    }
}

/// A disc of 8 mm and 0.1 mm on an arbor of 3 mm.
#[test]
fn thin_pieces_count_of_what_the_axis_passes_through_and_does_not_cut() {
    let disc = "{ kind = \"revolve\", profile_mm = [[0, 0], [8, 0], [8, 0.1], [3, 0.1], [3, 40], [0, 40]] }";
    for (role, x, is_thin) in [("holder", 0.0, true), ("holder", 60.0, false), ("cutter", 0.0, false)] {
        let text = [
            LATHE,
            &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
            &part("disc", "slide", role, [x, 0.0, 60.0], disc),
        ];
        let scene = scene(&text.concat(), "G0 Z1\nM2");
        let deepest_mm = turning_of(&scene).0.deepest_mm(0.1);
        assert!(if is_thin { deepest_mm < 0.051 } else { deepest_mm > 1.0 }, "{role} {x}: {deepest_mm}");
    }
}

#[test]
fn a_shank_beside_the_axis_collides_for_sure_with_a_bar_that_turns() {
    let text = [
        LATHE,
        &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0)),
        &part("insert", "slide", "cutter", [19.0, 0.0, 60.0], &cuboid([4.0, 2.0, 4.0])),
        &part("shank", "slide", "shank", [19.0, 0.0, 70.0], &cuboid([8.0, 6.0, 8.0])),
    ]
    .concat();
    // The insert turns to 17 mm, and the shank behind it comes to 15.
    assert_eq!(kinds(&found(&text, "M3 S500\nG1 Z-40 F200\nG0 X8\nM2"))[0], (2, "collision"));
}
