//! What a spindle turns, held against a workpiece that is cut.

use super::*;

/// A head with a spindle along Z, on slides along X and Z.
const HEAD: &str = r#"
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
const LATHE: &str = r#"
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

fn part(name: &str, link: &str, role: &str, at: [f64; 3], shape: &str) -> String {
    let link = if link.is_empty() { String::new() } else { format!("link = \"{link}\"\n") };
    format!("[[parts]]\nname = \"{name}\"\n{link}role = \"{role}\"\nat = {{ xyz_mm = {at:?} }}\nshape = {shape}\n")
}

const TIP: &str = "[program]\nfile = \"own.ngc\"\ntool_centre_point = { tool_link = \"head\", gauge_mm = [0, 0, 0] }\n";
const NO_TIP: &str = "[program]\nfile = \"own.ngc\"\n";

fn found(text: &str, program: &str) -> Outcome {
    checked(&scene(text, program), &with_zones(&[]))
}

fn kinds(outcome: &Outcome) -> Vec<(u32, &'static str)> {
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

fn cylinder(radius: f64, height: f64) -> String {
    format!("{{ kind = \"cylinder\", radius_mm = {radius}, height_mm = {height} }}")
}

fn cuboid(size: [f64; 3]) -> String {
    format!("{{ kind = \"rounded-box\", size_mm = {size:?} }}")
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
}

#[test]
fn an_insert_turns_about_the_spindle_and_not_about_itself() {
    let text = |x: f64, width: f64| {
        [
            HEAD,
            &part("block", "", "workpiece", [x, 0.0, 0.0], &cuboid([width, 20.0, 20.0])),
            &part("insert", "head", "cutter", [35.0, 0.0, 30.0], &cuboid([10.0, 10.0, 4.0])),
            TIP,
        ]
        .concat()
    };
    // The insert passes from 30 to 40.3 mm. On the other side of the axis is a block; another one stands within.
    assert_eq!(kinds(&found(&text(-35.0, 20.0), "M3 S1000\nG0 Z-25\nM2")), [(2, "rapid-into-workpiece")]);
    assert!(found(&text(0.0, 40.0), "M3 S1000\nG0 Z-25\nM2").is_clear());
    // It cuts the ring, and nothing within.
    let cut = found(&text(-35.0, 20.0), "M3 S1000\nG1 Z-25 F100\nG0 Z0\nM2");
    assert!(cut.is_clear(), "{:?}", cut.events);
    let mut stock = cut.remaining[0].stock.clone();
    assert_eq!(stock.material_at(&Point::new(-1.0, 1.0, 8.0)), Material::Gone);
    assert_eq!(stock.material_at(&Point::new(8.0, 1.0, 8.0)), Material::Solid);
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
    // So with any cutter for which the program sets the spindle.
    let square =
        text.replace(&cylinder(3.0, 40.0), &cuboid([4.0, 4.0, 40.0])).replace("[20.0, 0.0, 60.0]", "[20.0, 0.0, 80.0]");
    let told = found(&square, "M3 S500\nG1 Z-40 F100\nG0 Z0\nG0 C90\nG1 Z-30 F100\nG0 C180\nG0 Z0\nM2");
    assert_eq!(kinds(&told)[0], (6, "rapid-into-workpiece"));
    // On the axis it cuts what it would cut standing.
    let text = text.replace("[20.0, 0.0, 60.0]", "[0.0, 0.0, 60.0]");
    let told = found(&text, &format!("{drilled}M2"));
    assert_eq!((told.is_clear(), told.remaining[0].stock.resolution_mm()), (true, 0.1));
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
    for (radius, resolution_mm, kind) in
        [(0.05, 0.1, "unresolved"), (1.0, 0.1, "rapid-into-workpiece"), (1.0, 3.0, "unresolved")]
    {
        let text = [
            HEAD,
            &part("block", "", "workpiece", [0.0; 3], &cuboid([20.0, 20.0, 20.0])),
            &part("cutter", "head", "cutter", [0.0, 0.0, 15.0], &cylinder(radius, 20.0)),
            NO_TIP,
        ]
        .concat();
        let settings = Settings { cutting: Cutting::At(resolution_mm), ..with_zones(&[]) };
        let told = checked(&scene(&text, "M3 S1000\nG0 Z-15\nM2"), &settings);
        assert_eq!(kinds(&told), [(2, kind)], "{radius} {resolution_mm}");
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
