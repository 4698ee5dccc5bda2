//! Certificates of `check --certify`: planted crossings, random motion against dense exact sampling, and certificates that were tampered with.
//!
//! `BVBENCH_CERTIFY_SEGMENTS=1000000` compares as many random moves with sampling, `BVBENCH_CERTIFY_TAMPERED=1000` tampers as often. Seeds are in the messages.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]
#![allow(clippy::print_stdout, reason = "the long forms tell what they covered")]

mod support;

use bvbench::certify::{Certificate, Doubt, Verdict, certify};
use bvbench::geometry::{Point, Triangle, Vector};
use bvbench::measure::Silent;
use bvbench::measure::peers::motions;
use bvbench::measure::peers::posed::{PosedMeshes, Question};
use bvbench::method::motion::Motion;
use bvbench::registry;
use bvbench::scene::{Pair, Scene};
use bvbench::truth::PairOracle;
use certificate_checker::{MOST_WORK, Refusal, Report};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use support::in_memory;

fn load(scene: &str, program: &str) -> Scene {
    in_memory("planted", &[("scene.toml", scene), ("own.ngc", program)])
}

/// The same with a mesh file, `part.stl`.
fn load_with(scene: &str, program: &str, triangles: &[Triangle]) -> Scene {
    let facet = |t: &Triangle| {
        let corners = t.corners.map(|p| format!("vertex {} {} {}\n", p.x, p.y, p.z)).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let stl = format!("solid\n{}endsolid\n", triangles.iter().map(facet).collect::<String>());
    in_memory("planted", &[("scene.toml", scene), ("own.ngc", program), ("part.stl", &stl)])
}

fn certified(scene: &Scene) -> Certificate {
    certify(scene, scene.program.as_ref().unwrap(), None, &Silent).unwrap()
}

/// The same with the trees of a variant.
fn certified_by(id: &str, scene: &Scene) -> Certificate {
    let registry = registry::standard();
    certify(scene, scene.program.as_ref().unwrap(), registry.find(id), &Silent).unwrap()
}

fn checked(text: &str) -> Result<Report, Refusal> {
    certificate_checker::check(text, None, None, MOST_WORK)
}

fn accepted(certificate: &Certificate, what: &str) -> Report {
    let report = checked(&certificate.text).unwrap_or_else(|Refusal { line, why }| {
        let text = certificate.text.lines().nth(line - 1).unwrap_or_default();
        panic!("{what}: line {line}: {why}: {}", &text[..text.len().min(200)])
    });
    let own: BTreeMap<u32, &str> = certificate.blocks.iter().map(|(line, verdict)| (*line, verdict.name())).collect();
    assert_eq!(report.blocks, own, "{what}");
    assert_eq!(report.cutting, certificate.cutting, "{what}");
    report
}

/// A sheet of 60 x 60 mm across the way of a sheet of 20 x 20 mm, both so thick; the small one comes from 30 mm above and goes 30 mm below.
fn sheets(thick: f64, axis: &str, program: &str) -> Scene {
    let scene = format!(
        r#"
title = "Two sheets"
machine.links = [{{ name = "head", joint = {{ axis = "{axis}", {turns}direction = [{direction}] }} }}]
parts = [
  {{ name = "wall", role = "fixture", at = {{ xyz_mm = [0, 0, {low}] }}, shape = {{ kind = "extrude", height_mm = {thick}, outline_mm = [
    [-30, -30], [30, -30], [30, 30], [-30, 30]] }} }},
  {{ name = "blade", link = "head", role = "shank", at = {{ xyz_mm = [0, 0, {low}] }}, shape = {{ kind = "extrude", height_mm = {thick}, outline_mm = [
    [-10, -10], [12, -9], [11, 10], [-9, 11]] }} }},
]
[program]
file = "own.ngc"
start = {{ {start} }}
"#,
        turns = if axis == "A" { "point_mm = [0, -100, 0], " } else { "" },
        direction = if axis == "A" { "1, 0, 0" } else { "0, 0, 1" },
        start = if axis == "A" { "a_deg = 20" } else { "z_mm = 30" },
        low = -0.5 * thick,
    );
    load(&scene, program)
}

#[test]
fn thin_walls_are_not_jumped_over() {
    for thick in [0.3, 0.1, 0.03, 0.01, 0.003, 0.001] {
        for (axis, program) in
            [("Z", "G0 Z25\nG1 Z-30 F1000\nG0 Z-40\nM2"), ("A", "G0 A19\nG1 A-20 F1000\nG0 A-21\nM2")]
        {
            let scene = sheets(thick, axis, program);
            let certificate = certified(&scene);
            let what = format!("{thick} mm along {axis}");
            assert_eq!(certificate.blocks[&2], Verdict::Collision, "{what}: {:?}", certificate.doubts);
            assert_eq!([certificate.blocks[&1], certificate.blocks[&3]], [Verdict::Free; 2], "{what}");
            let doubt = &certificate.doubts[0];
            assert!(
                doubt.size_mm.is_some_and(|size_mm| size_mm < 1e-3) && doubt.within[1] > doubt.within[0],
                "{what}: {doubt:?}"
            );
            if axis == "Z" {
                // The lower side of the blade meets the upper side of the wall at Z = thick.
                let contact = (25.0 - thick) / 55.0;
                assert!(doubt.within[0] <= contact && contact <= doubt.within[1], "{what}: {contact} {doubt:?}");
            }
            accepted(&certificate, &what);
        }
    }
}

#[test]
fn contact_begins_where_its_move_is_first_unresolved() {
    // A holder with a corner in front passes a corner of a bracket by touching it at Y0, and runs into its wall behind that at Y24.
    let scene = r#"
title = "A bracket beside a slide"
machine.links = [{ name = "slide", joint = { axis = "Y", direction = [0, 1, 0] } }]
parts = [
  { name = "bracket", role = "fixture", shape = { kind = "extrude", height_mm = 10, outline_mm = [
    [0, 0], [10, -10], [30, -10], [30, 40], [-20, 40], [-20, 30], [20, 30], [10, 10]] } },
  { name = "holder", role = "holder", link = "slide", shape = { kind = "extrude", height_mm = 10, outline_mm = [[0, 0], [-6, 6], [-12, 0], [-6, -6]] } },
]
[program]
file = "own.ngc"
start = { y_mm = -20 }
"#;
    let certificate = certified(&load(scene, "G1 Y40 F1000\nM2"));
    assert_eq!(certificate.blocks[&1], Verdict::Collision, "{:?}", certificate.doubts);
    let [Doubt { within, size_mm: Some(size_mm), .. }] = &certificate.doubts[..] else {
        panic!("{:?}", certificate.doubts)
    };
    assert!(within[0] < 1.0 / 3.0 && 44.0 / 60.0 < within[1], "{within:?}");
    // The way is all that lies between the two.
    assert!((size_mm - 60.0 * (within[1] - within[0])).abs() < 1e-5, "{size_mm} {within:?}");
    accepted(&certificate, "a bracket");
}

#[test]
fn fractions_are_of_the_move_and_not_of_the_leg_of_a_dog_leg() {
    let scene = r#"
title = "A clamp at the end of a rapid"
machine.links = [
  { name = "x", joint = { axis = "X", direction = [1, 0, 0] } },
  { name = "y", parent = "x", joint = { axis = "Y", direction = [0, 1, 0] } },
  { name = "z", parent = "y", joint = { axis = "Z", direction = [0, 0, 1] } },
]
parts = [
  { name = "clamp", role = "fixture", at = { xyz_mm = [80, 10, 0] }, shape = { kind = "extrude", height_mm = 10, outline_mm = [
    [0, -5], [10, -5], [10, 5], [0, 5]] } },
  { name = "holder", role = "holder", link = "z", shape = { kind = "extrude", height_mm = 10, outline_mm = [[-3, -3], [3, -3], [3, 3], [-3, 3]] } },
]
[program]
file = "own.ngc"
[program.tool_centre_point]
tool_link = "z"
[check]
rapid = "dog-leg"
rapid_mm_min = 10000
"#;
    // 10 mm in both axes and 90 mm in one. The holder is at the clamp at X77.
    for (program, contact) in [
        ("G0 X100 Y10\nM2", 0.77),
        ("G68.2 X0 Y0 Z0 I0 J0 K0\nG0 X100 Y10\nM2", 0.77),
        ("G0 X50 Y10\nG1 X100 F1000\nM2", 27.0 / 50.0),
    ] {
        let certificate = certified(&load(scene, program));
        let [Doubt { within, verdict: Verdict::Collision, .. }] = &certificate.doubts[..] else {
            panic!("{program}: {:?}", certificate.doubts)
        };
        assert!(within[0] <= contact && contact <= within[1] && within[1] < contact + 1e-4, "{program}: {within:?}");
        accepted(&certificate, program);
    }
}

#[test]
fn what_stays_apart_is_free_however_near_and_what_touches_is_not() {
    // Sideways over the wall: 0.0001 mm above it, on it, and 0.0001 mm within it.
    for (above, verdict) in [(1e-4, Verdict::Free), (0.0, Verdict::Unresolved), (-1e-4, Verdict::Collision)] {
        let scene = sheets(0.25, "Z", &format!("G0 Z{:.6}\nG4 P1\nM2", 0.25 + above));
        let certificate = certified(&scene);
        assert_eq!(certificate.blocks[&2], verdict, "{above}: {:?}", certificate.doubts);
        accepted(&certificate, "near");
    }
}

#[test]
fn what_lies_inside_the_other_is_not_free() {
    let scene = r#"
title = "A box in a box"
machine.links = [{ name = "head", joint = { axis = "X", direction = [1, 0, 0] } }]
parts = [
  { name = "outer", shape = { kind = "rounded-box", size_mm = [100, 100, 100], fillet_mm = 0 } },
  { name = "inner", role = "holder", link = "head", shape = { kind = "rounded-box", size_mm = [10, 10, 10], fillet_mm = 0 } },
]
[program]
file = "own.ngc"
"#;
    let drawn = load(scene, "G0 X20\nM2");
    let is_unresolved = |scene: &Scene, what: &str| {
        let certificate = certified(scene);
        let are = certificate.blocks.values().all(|&verdict| verdict == Verdict::Unresolved);
        assert!(are, "{what}: {:?}", certificate.blocks);
        accepted(&certificate, what);
        certificate
    };
    let certificate = is_unresolved(&drawn, "inside");
    // Who claims that it is free is not believed: no plane parts a box from one around it.
    let claim = |line: &str| {
        if line.starts_with("open") { "free 1 0 p 16777216 0 0 900000000" } else { line }.to_owned() + "\n"
    };
    let claimed: String = certificate.text.lines().map(claim).collect();
    assert!(checked(&signed(&claimed)).is_err());
    // Nor is it where nobody knows what the box encloses.
    let shape = r#"shape = { kind = "rounded-box", size_mm = [100, 100, 100], fillet_mm = 0 }"#;
    let outer = drawn.parts[0].mesh.triangles();
    let read = scene.replace(shape, r#"mesh = "part.stl""#);
    is_unresolved(&load_with(&read, "G0 X20\nM2", &outer[1..]), "inside an open box");
    // In two bodies of opposite winding, neither of which is a cavity.
    let turned = |t: &Triangle| Triangle::new(t.corners[0], t.corners[2], t.corners[1]).map(|p| p + 30.0 * Vector::x());
    let both: Vec<Triangle> = outer.iter().copied().chain(outer.iter().map(turned)).collect();
    is_unresolved(&load_with(&read, "G0 X20\nM2", &both), "inside two bodies");
}

/// A block of 20 mm on the plane of X and Y.
const BLOCK: &str =
    r#"{ kind = "extrude", height_mm = 20, outline_mm = [[-10, -10], [10, -10], [10, 10], [-10, 10]] }"#;

/// A holder that moves along Z and begins 10 mm up, and `blocks` that stand.
fn beside_holder(blocks: &str) -> String {
    format!(
        r#"
title = "A holder and two blocks"
machine.links = [{{ name = "head", joint = {{ axis = "Z", direction = [0, 0, 1] }} }}]
parts = [
  {{ name = "blocks", role = "fixture", {blocks} }},
  {{ name = "holder", role = "holder", link = "head", shape = {{ kind = "extrude", height_mm = 2, outline_mm = [[-2, -2], [2, -2], [0, 2]] }} }},
]
[program]
file = "own.ngc"
start = {{ z_mm = 10 }}
"#
    )
}

#[test]
fn bodies_that_touch_have_an_inside() {
    let is_inside = |scene: &Scene, what: &str| {
        let certificate = certified(scene);
        let are = certificate.blocks.values().all(|&verdict| verdict == Verdict::Unresolved);
        assert!(are, "{what}: {:?}", certificate.blocks);
        accepted(&certificate, what);
    };
    let program = "G0 Z12\nG0 Z9\nM2";
    // On each other, and with one edge in common.
    for at in ["0, 0, 20", "20, 0, 20"] {
        let two = format!("[{{ shape = {BLOCK} }}, {{ shape = {BLOCK}, at = {{ xyz_mm = [{at}] }} }}]");
        let drawn = load(&beside_holder(&format!("shape = {{ kind = \"compound\", parts = {two} }}")), program);
        is_inside(&drawn, at);
        // From a file, where four triangles meet at the edge, and the side in common has the same triangles twice, wound against each other.
        let read = load_with(&beside_holder("mesh = \"part.stl\""), program, &drawn.parts[0].mesh.triangles());
        assert!(read.parts[0].mesh.edge_report().is_watertight());
        is_inside(&read, "from a file");
    }
}

#[test]
fn a_mesh_with_a_component_of_no_volume_has_no_inside() {
    let [left, right] = [-20, 20].map(|x| format!("{{ shape = {BLOCK}, at = {{ xyz_mm = [{x}, 0, 0] }} }}"));
    let program = "G0 Z12\nG0 Z9\nM2";
    let drawn = load(&beside_holder(&format!("shape = {{ kind = \"compound\", parts = [{left}, {right}] }}")), program);
    let mut triangles = drawn.parts[0].mesh.triangles();
    let verdict = |triangles: &[Triangle]| {
        let read = load_with(&beside_holder("mesh = \"part.stl\""), program, triangles);
        assert!(read.parts[0].mesh.edge_report().is_watertight());
        let certificate = certified(&read);
        accepted(&certificate, "two blocks");
        certificate.blocks.into_values().collect::<BTreeSet<Verdict>>().into_iter().collect::<Vec<_>>()
    };
    assert_eq!(verdict(&triangles), [Verdict::Free]);
    // A square from both sides, each divided along another diagonal.
    let corners = [[-5.0, 0.0], [5.0, 0.0], [5.0, 10.0], [-5.0, 10.0]].map(|[x, z]| Point::new(x, 40.0, z));
    let square = [[0, 1, 2], [0, 2, 3], [3, 2, 1], [1, 0, 3]];
    triangles.extend(square.map(|[i, j, k]| Triangle::new(corners[i], corners[j], corners[k])));
    assert_eq!(verdict(&triangles), [Verdict::Unresolved]);
}

#[test]
fn a_circle_that_ends_beside_its_start_is_certified() {
    let scene = r#"
title = "A plate above another"
machine.links = [
  { name = "x", joint = { axis = "X", direction = [1, 0, 0] } },
  { name = "y", parent = "x", joint = { axis = "Y", direction = [0, 1, 0] } },
]
parts = [
  { name = "table", role = "fixture", shape = { kind = "extrude", height_mm = 10, outline_mm = [[-30, -30], [30, -30], [30, 30], [-30, 30]] } },
  { name = "plate", role = "holder", link = "y", at = { xyz_mm = [0, 0, 20] }, shape = { kind = "extrude", height_mm = 10, outline_mm = [
    [-30, -30], [30, -30], [30, 30], [-30, 30]] } },
]
[program]
file = "own.ngc"
"#;
    // 0.0001 mm of 942 mm, before the start and past it.
    for end in ["10.0001", "9.9999"] {
        let program = format!("G0 X-150 Y10\nG2 X-150 Y{end} I150 J0 F1000\nG0 X0 Y0\nM2");
        let certificate = certified(&load(scene, &program));
        assert!(certificate.blocks.values().all(|&verdict| verdict == Verdict::Free), "{:?}", certificate.blocks);
        accepted(&certificate, end);
    }
}

#[test]
fn where_nothing_bounds_the_axes_no_distance_is_told() {
    let scene = r#"
title = "A quill behind the tilt, led by the tip"
machine.links = [
  { name = "x", joint = { axis = "X", direction = [1, 0, 0] } },
  { name = "y", parent = "x", joint = { axis = "Y", direction = [0, 1, 0] } },
  { name = "tilt", parent = "y", joint = { axis = "B", direction = [0, 1, 0] } },
  { name = "quill", parent = "tilt", joint = { axis = "Z", direction = [0, 0, 1] } },
]
parts = [
  { name = "block", role = "fixture", shape = { kind = "rounded-box", size_mm = [20, 20, 20], fillet_mm = 0 } },
  { name = "chuck", role = "holder", link = "quill", shape = { kind = "rounded-box", size_mm = [10, 10, 10], fillet_mm = 0 } },
]
[program]
file = "own.ngc"
start = { z_mm = 200 }
tools = [{ number = 1, offset = { z_mm = 50 } }]
tool = 1
tool_centre_point = { tool_link = "quill" }
"#;
    // X and the quill are too near to one line from 41.5 degrees on. Behind place 8192 halving ends where places have no numbers between them.
    for dwells in [0, 8192] {
        let program = "G4 P1\n".repeat(dwells) + "G43.4 H1\nG1 X0 Y0 Z30 F500\nG1 B40\nG1 B50\nG1 B40\nG1 X5\nM2";
        let certificate = certified(&load(scene, &program));
        let unresolved = [4, 5].map(|line| dwells as u32 + line);
        let is_told = |line: &u32, verdict: &Verdict| (*verdict == Verdict::Unresolved) == unresolved.contains(line);
        assert!(certificate.blocks.iter().all(|(line, verdict)| is_told(line, verdict)), "{:?}", certificate.doubts);
        assert!(certificate.doubts.iter().all(|doubt| doubt.size_mm.is_none()), "{:?}", certificate.doubts);
        accepted(&certificate, "no bound");
    }
}

#[test]
fn a_rapid_through_the_workpiece_is_not_free_and_a_feed_is() {
    let scene = r#"
title = "A block that is cut"
machine.links = [
  { name = "slide", joint = { axis = "X", direction = [1, 0, 0] } },
  { name = "head", parent = "slide", joint = { axis = "Z", direction = [0, 0, 1] } },
]
parts = [
  { name = "block", role = "workpiece", shape = { kind = "rounded-box", size_mm = [100, 40, 20], fillet_mm = 0 } },
  { name = "mill", role = "cutter", link = "head", at = { xyz_mm = [0, 0, 60] }, shape = { kind = "rounded-box", size_mm = [8, 8, 80], fillet_mm = 0 } },
  { name = "chuck", role = "holder", link = "head", at = { xyz_mm = [0, 0, 120] }, shape = { kind = "rounded-box", size_mm = [30, 30, 40], fillet_mm = 0 } },
]
[program]
file = "own.ngc"
start = { z_mm = 20 }
"#;
    // Above it, into it, a dwell, along, out again; then across a corner of it at rapid rate, and a hundredth of a mm above it.
    let program = "G0 X-20\nG1 Z-15 F500\nG4 P1\nG1 X20\nG0 Z20\nG0 X70\nG0 Z-10\nG0 X-70\nG0 Z-9.99\nG0 X70\nM2";
    let certificate = certified(&load(scene, program));
    let found: Vec<&str> = certificate.blocks.values().map(|verdict| verdict.name()).collect();
    // The mill's end is 20 mm above its zero point, the block's top at Z10: at Z-10 one slides over the other.
    let wanted = ["free", "free", "free", "free", "free", "stock", "free", "free", "stock", "free", "free"];
    assert_eq!(found, wanted, "{:?}", certificate.doubts);
    // Where it dwells it does not feed.
    assert_eq!(certificate.cutting.iter().copied().collect::<Vec<_>>(), [2, 4]);
    let report = accepted(&certificate, "a rapid");
    assert!(
        report.notes.contains(&"at rapids alone, against the whole workpiece: block:mill".to_owned()),
        "{:?}",
        report.notes
    );
    // In the block at the start: no feed has brought it there.
    let within = certified(&load(&scene.replace("z_mm = 20", "z_mm = -15"), "G1 X20 F500\nM2"));
    assert_eq!(within.blocks.values().copied().collect::<Vec<_>>(), [Verdict::Stock, Verdict::Free]);
    accepted(&within, "the start");
    // What stands in the block at the start, after a rapid or behind a change of tools, no feed has brought there.
    let brought = certified(&load(scene, "G4 P1\nG0 X-20 Z-15\nG4 P1\nG1 X20 F500\nG4 P1\nT1 M6\nG4 P1\nM2"));
    let found: Vec<&str> = brought.blocks.values().map(|verdict| verdict.name()).collect();
    assert_eq!(found, ["free", "free", "stock", "stock", "free", "free", "stock", "stock"], "{:?}", brought.doubts);
    assert_eq!(brought.cutting.iter().copied().collect::<Vec<_>>(), [4]);
    accepted(&brought, "a dwell");
    // Who says nothing of the rapid is not believed.
    let claimed: String =
        certificate.text.lines().filter(|line| !line.starts_with("open ")).map(|line| line.to_owned() + "\n").collect();
    let refusal = checked(&signed(&claimed)).unwrap_err();
    assert!(refusal.why.contains("no such interval"), "{refusal:?}");
}

/// The certificate with a hash of its content as it is now.
fn signed(text: &str) -> String {
    let body: String =
        text.lines().filter(|line| !line.starts_with("end ")).map(|line| line.to_owned() + "\n").collect();
    format!("{body}end {}\n", blake3::hash(body.as_bytes()).to_hex())
}

/// A machine with slides and turns in some order, two parts, and a program of straight moves and arcs. As cutter and workpiece they go at
/// rapid rate in half of the straight moves.
fn random_scene(random: &mut Pcg64, moves: usize, are_cutting: bool) -> Scene {
    let mut text = "title = \"random\"\n".to_owned();
    let axes = ["X", "Y", "Z", "A", "B", "C"];
    let mut on_table: Vec<bool> = axes.iter().map(|_| random.random::<f64>() < 0.4).collect();
    on_table[2] = false;
    let mut last = [None::<&str>; 2];
    let mut order: Vec<usize> = (0..6).collect();
    for i in (1..6).rev() {
        order.swap(i, random.random_range(0..=i));
    }
    for i in order {
        let side = usize::from(on_table[i]);
        let parent = last[side].map_or(String::new(), |parent| format!("parent = \"{parent}\"\n"));
        let direction = ["1, 0, 0", "0, 1, 0", "0, 0, 1"][i % 3];
        let point = if i < 3 {
            String::new()
        } else {
            format!(
                ", point_mm = [{:.2}, {:.2}, {:.2}]",
                random.random_range(-40.0..40.0),
                random.random_range(-40.0..40.0),
                random.random_range(-40.0..40.0)
            )
        };
        let at = format!(
            "at = {{ xyz_mm = [0, 0, 0], rpy_deg = [{:.1}, {:.1}, 0] }}",
            random.random_range(-20.0..20.0),
            random.random_range(-20.0..20.0)
        );
        writeln!(text, "[[machine.links]]\nname = \"{}\"\n{parent}{at}\njoint = {{ axis = \"{}\", direction = [{direction}]{point} }}", axes[i], axes[i]).unwrap();
        last[side] = Some(axes[i]);
    }
    let shapes = [
        "{ kind = \"torus\", ring_radius_mm = 18, tube_radius_mm = 4 }",
        "{ kind = \"rounded-box\", size_mm = [30, 12, 8], fillet_mm = 0 }",
        "{ kind = \"cylinder\", radius_mm = 5, height_mm = 40 }",
        "{ kind = \"extrude\", height_mm = 30, outline_mm = [[-20, -20], [20, -20], [20, -16], [-16, -16], [-16, 20], [-20, 20]] }",
    ];
    for (name, side) in [("tool", 0), ("work", 1)] {
        let link = last[side].map_or(String::new(), |link| format!("link = \"{link}\"\n"));
        let shape = shapes[random.random_range(0..shapes.len())];
        let role = [["holder", "fixture"], ["cutter", "workpiece"]][usize::from(are_cutting)][side];
        writeln!(
            text,
            "[[parts]]\nname = \"{name}\"\nrole = \"{role}\"\n{link}tessellation = {{ density = 0.2 }}\nshape = {shape}"
        )
        .unwrap();
    }
    text += "[program]\nfile = \"own.ngc\"\nstart = { z_mm = 60 }\n";
    let mut program = "G17 G90 F1000\n".to_owned();
    for _ in 0..moves {
        if random.random::<f64>() < 0.2 {
            // A full circle from wherever the machine stands.
            writeln!(program, "G2 I{:.4} J0", random.random_range(2.0..20.0)).unwrap();
            continue;
        }
        program += if are_cutting && random.random() { "G0" } else { "G1" };
        for (i, axis) in axes.iter().enumerate() {
            let far = if i < 3 { 35.0 } else { 60.0 };
            if i == 0 || random.random::<f64>() < 0.5 {
                write!(program, " {axis}{:.4}", random.random_range(-far..far)).unwrap();
            }
        }
        program += "\n";
    }
    load(&text, &(program + "M2\n"))
}

/// Poses that each move is sampled at.
const DENSE: usize = 64;

/// How often each verdict was given to random moves, of which no free one touches anything.
fn sampled(are_cutting: bool) -> (usize, BTreeMap<&'static str, usize>) {
    let wanted = std::env::var("BVBENCH_CERTIFY_SEGMENTS").ok().and_then(|text| text.parse().ok()).unwrap_or(300);
    let (mut done, mut seed, mut verdicts) = (0, 0, BTreeMap::new());
    while done < wanted {
        seed += 1;
        let moves = 40.min(wanted - done);
        let scene = random_scene(&mut Pcg64::seed_from_u64(seed), moves, are_cutting);
        let certificate = certified(&scene);
        accepted(&certificate, &format!("seed {seed}"));
        for verdict in certificate.blocks.values() {
            *verdicts.entry(verdict.name()).or_insert(0) += 1;
        }
        compare_with_samples(&scene, &certificate, seed);
        done += moves;
    }
    println!("{done} moves of {seed} machines: {verdicts:?}");
    (done, verdicts)
}

#[test]
fn no_free_move_touches_anything_when_it_is_sampled_densely() {
    let (done, verdicts) = sampled(false);
    assert!(verdicts["free"] > done / 20 && verdicts["collision"] > done / 20, "{verdicts:?}");
}

#[test]
fn no_free_rapid_brings_a_cutter_into_the_workpiece() {
    let (done, verdicts) = sampled(true);
    assert!(verdicts["free"] > done / 20 && verdicts["stock"] > done / 20 && verdicts.len() == 2, "{verdicts:?}");
}

/// Exact verdicts at many poses of each move: none in contact where the move is free, and none before a proved first contact.
fn compare_with_samples(scene: &Scene, certificate: &Certificate, seed: u64) {
    let run = scene.program.as_ref().unwrap();
    let pair = Pair { a: 0, b: 1 };
    let oracle = PairOracle::new(Arc::clone(&scene.parts[0].mesh), Arc::clone(&scene.parts[1].mesh));
    let step = rs274::Sampling { step_mm: f64::INFINITY, step_deg: f64::INFINITY, chord_mm: 1e-4 };
    let samples = rs274::sample(&run.program, &run.start, &step, &rs274::RapidPath::Straight).unwrap();
    let mut from = (run.start, 0.0, usize::MAX);
    for sample in &samples {
        let begin = if sample.move_index == from.2 { from.1 } else { 0.0 };
        let kind = run.program.moves[sample.move_index].kind;
        // Between samples of an arc the chord leaves it by 0.0001 mm: there only the ends are on the path.
        let is_arc = matches!(kind, rs274::MoveKind::Arc { .. });
        let is_meant = scene.is_cutting(pair) && kind != rs274::MoveKind::Rapid;
        let count = if is_arc { 1 } else { DENSE };
        for i in 1..=count {
            let part = i as f64 / count as f64;
            let position =
                rs274::Position(std::array::from_fn(|k| from.0.0[k] + part * (sample.position.0[k] - from.0.0[k])));
            let place = begin + part * (sample.fraction - begin);
            let doubts = certificate.doubts.iter().filter(|doubt| doubt.line == sample.line);
            let is_open = doubts.clone().any(|doubt| place >= doubt.within[0] - 1e-9);
            if is_open || is_meant {
                continue;
            }
            let verdict = oracle.judge(&scene.a_from_b(pair, &scene.machine.forward(&position)));
            assert!(
                !verdict.touches() && !verdict.contained,
                "seed {seed}, line {} at {place}: free, and in contact",
                sample.line
            );
        }
        from = (sample.position, sample.fraction, sample.move_index);
    }
}

/// A vise without undersides on a table that turns, a holder on a tilt, and a program of straight moves and arcs with the tip's control and without.
fn random_open_scene(random: &mut Pcg64, moves: usize) -> Scene {
    let mut number = |far: f64| random.random_range(-far..far);
    let [of_tilt, x, y, turned] = [number(60.0), number(20.0), number(20.0), number(30.0)];
    let length = 45.0 + number(15.0);
    let jaw = |y: f64| {
        format!(
            "{{ shape = {{ kind = \"rounded-box\", size_mm = [120, 25, 45], fillet_mm = 0 }}, at = {{ xyz_mm = [0, {y}, 2.5] }} }}"
        )
    };
    let jaws = format!("shape = {{ kind = \"compound\", parts = [{}, {}] }}", jaw(-37.5), jaw(37.5));
    let scene = |jaws: &str| {
        format!(
            r#"
title = "An open vise"
machine.links = [
  {{ name = "x", joint = {{ axis = "X", direction = [1, 0, 0] }} }},
  {{ name = "y", parent = "x", joint = {{ axis = "Y", direction = [0, 1, 0] }} }},
  {{ name = "z", parent = "y", joint = {{ axis = "Z", direction = [0, 0, 1] }} }},
  {{ name = "tilt", parent = "z", joint = {{ axis = "B", direction = [0, 1, 0], point_mm = [0, 0, {of_tilt:.2}] }} }},
  {{ name = "table", at = {{ xyz_mm = [0, 0, 0], rpy_deg = [0, 0, {turned:.1}] }}, joint = {{ axis = "C", direction = [0, 0, 1], point_mm = [{x:.2}, {y:.2}, 0] }} }},
]
parts = [
  {{ name = "jaws", role = "fixture", link = "table", {jaws} }},
  {{ name = "holder", role = "holder", link = "tilt", tessellation = {{ density = 0.2 }}, shape = {{ kind = "cylinder", radius_mm = 5, height_mm = {length:.2} }} }},
]
[program]
file = "own.ngc"
start = {{ z_mm = 100 }}
tools = [{{ number = 1, offset = {{ z_mm = {length:.2} }} }}]
tool = 1
[program.tool_centre_point]
tool_link = "tilt"
work_link = "table"
gauge_mm = [0, 0, {length:.2}]
"#
        )
    };
    let (mut program, mut is_led) = ("G17 G90 F1000\n".to_owned(), false);
    for _ in 0..moves {
        match random.random_range(0..10) {
            0 | 1 => {
                program += if is_led { "G49\n" } else { "G43.4 H1\n" };
                is_led = !is_led;
            }
            2..5 => {
                let [i, j] = [random.random_range(-6.0..6.0), random.random_range(1.0..6.0)];
                writeln!(program, "G2 I{i:.3} J{j:.3}").unwrap();
            }
            _ => {
                program += "G1";
                for (axis, low, high) in
                    [("X", -50.0, 50.0), ("Y", -12.0, 12.0), ("Z", 0.0, 60.0), ("B", -15.0, 15.0), ("C", -25.0, 25.0)]
                {
                    if axis == "X" || random.random::<f64>() < 0.5 {
                        write!(program, " {axis}{:.3}", random.random_range(low..high)).unwrap();
                    }
                }
                program += "\n";
            }
        }
    }
    program += "M2\n";
    let whole = load(&scene(&jaws), &program).parts[0].mesh.triangles();
    let is_below = |triangle: &Triangle| triangle.corners.iter().all(|p| p.z < -19.9);
    let open: Vec<Triangle> = whole.into_iter().filter(|triangle| !is_below(triangle)).collect();
    load_with(&scene("mesh = \"part.stl\""), &program, &open)
}

#[test]
fn open_meshes_with_arcs_and_the_tips_control_are_certified_as_they_are_checked() {
    let mut verdicts: BTreeMap<&str, usize> = BTreeMap::new();
    for seed in 1..=40 {
        let scene = random_open_scene(&mut Pcg64::seed_from_u64(seed), 16);
        assert!(!scene.parts[0].mesh.edge_report().is_watertight());
        let certificate = certified(&scene);
        accepted(&certificate, &format!("seed {seed}"));
        certificate.blocks.values().for_each(|verdict| *verdicts.entry(verdict.name()).or_default() += 1);
    }
    println!("{verdicts:?}");
    assert!(verdicts["free"] > 40, "{verdicts:?}");
}

#[test]
fn open_jaws_are_passed_between_behind_an_arc() {
    // From above them down between them, a full circle there, or the tip's control, and on: all of it is known to be outside.
    let scene = r#"
title = "An open channel"
machine.links = [
  { name = "x", joint = { axis = "X", direction = [1, 0, 0] } },
  { name = "y", parent = "x", joint = { axis = "Y", direction = [0, 1, 0] } },
  { name = "z", parent = "y", joint = { axis = "Z", direction = [0, 0, 1] } },
]
parts = [
  { name = "jaws", role = "fixture", JAWS },
  { name = "holder", role = "holder", link = "z", shape = { kind = "rounded-box", size_mm = [6, 6, 60], fillet_mm = 0 } },
]
[program]
file = "own.ngc"
start = { z_mm = 100 }
tools = [{ number = 1, offset = { z_mm = 30 } }]
tool = 1
tool_centre_point = { tool_link = "z" }
"#;
    let jaw = r#"shape = { kind = "rounded-box", size_mm = [120, 25, 45], fillet_mm = 0 }"#;
    let jaws = [-37.5, 37.5].map(|y| format!("{{ {jaw}, at = {{ xyz_mm = [0, {y}, 0] }} }}")).join(", ");
    let drawn = load(&scene.replace("JAWS", &format!("shape = {{ kind = \"compound\", parts = [{jaws}] }}")), "M2");
    let is_below = |triangle: &Triangle| triangle.corners.iter().all(|p| p.z < -22.0);
    let open: Vec<Triangle> =
        drawn.parts[0].mesh.triangles().into_iter().filter(|triangle| !is_below(triangle)).collect();
    for middle in ["G2 I5", "G43.4 H1", "G43.4 H1\nG2 I5\nG49"] {
        let program = format!("G0 X0 Y0\nG0 Z25\nF500\n{middle}\nG1 Y4\nM2");
        let certificate = certified(&load_with(&scene.replace("JAWS", "mesh = \"part.stl\""), &program, &open));
        assert!(
            certificate.blocks.values().all(|&verdict| verdict == Verdict::Free),
            "{middle}: {:?}",
            certificate.doubts
        );
        accepted(&certificate, middle);
    }
}

#[test]
fn certificates_by_the_trees_of_variants_prove_the_same() {
    for seed in 1..=3 {
        let scene = random_scene(&mut Pcg64::seed_from_u64(seed), 12, false);
        let own = certified(&scene);
        let mut orders = BTreeSet::new();
        for id in ["sphere-ritter", "aabb", "obb-area", "obb-wide", "uniform-grid"] {
            let certificate = certified_by(id, &scene);
            accepted(&certificate, &format!("{id}, seed {seed}"));
            compare_with_samples(&scene, &certificate, seed);
            // Other planes, the same contacts: a proof of either kind cannot be of the other.
            for (line, verdict) in &certificate.blocks {
                let both = [*verdict, own.blocks[line]];
                assert!(both != [Verdict::Free, Verdict::Collision] && both != [Verdict::Collision, Verdict::Free]);
            }
            let count = |verdict| certificate.count(verdict).abs_diff(own.count(verdict));
            assert!(count(Verdict::Free) <= 1 && count(Verdict::Collision) <= 1, "{id}, seed {seed}");
            orders
                .insert(certificate.text.lines().filter(|line| line.starts_with("f ")).collect::<Vec<_>>().join("\n"));
        }
        // Boxes along the parts' principal axes split otherwise than boxes along X, Y and Z; methods without a binary tree leave the order as it is.
        assert!(orders.len() >= 2, "seed {seed}");
    }
}

/// A motion of mode `motion` of the peers as a program: slides along X, Y and Z, and a turn about the motion's own axis.
fn as_program(posed: &PosedMeshes, question: &Question) -> Scene {
    let motion = Motion::between(&question.a_from_b, &question.end.unwrap());
    let thick: f64 = posed.pair["wall-".len()..posed.pair.find(':').unwrap()].parse().unwrap();
    let (roll, pitch, yaw) = motion.start.rotation.euler_angles();
    let axis = motion.turn.try_normalize(0.0).unwrap_or_else(Vector::z);
    let mut text = "title = \"motion\"\n".to_owned();
    for (name, parent, direction) in [
        ("X", "", Vector::x()),
        ("Y", "parent = \"X\"\n", Vector::y()),
        ("Z", "parent = \"Y\"\n", Vector::z()),
        ("A", "parent = \"Z\"\n", axis),
    ] {
        let point = if name == "A" { ", point_mm = [0, 0, 0]" } else { "" };
        let [x, y, z] = [direction.x, direction.y, direction.z];
        writeln!(text, "[[machine.links]]\nname = \"{name}\"\n{parent}joint = {{ axis = \"{name}\", direction = [{x:.17}, {y:.17}, {z:.17}]{point} }}")
            .unwrap();
    }
    let [roll, pitch, yaw] = [roll, pitch, yaw].map(f64::to_degrees);
    let turned = format!("link = \"A\"\nat = {{ xyz_mm = [0, 0, 0], rpy_deg = [{roll:.15}, {pitch:.15}, {yaw:.15}] }}");
    for (name, rest, size) in
        [("wall", "role = \"fixture\"", [60, 60]), ("blade", &format!("role = \"holder\"\n{turned}"), [22, 20])]
    {
        let shape = format!("{{ kind = \"rounded-box\", size_mm = [{}, {}, {thick}] }}", size[0], size[1]);
        writeln!(text, "[[parts]]\nname = \"{name}\"\n{rest}\nshape = {shape}").unwrap();
    }
    let start = motion.start.translation.vector;
    let end = start + motion.way;
    writeln!(
        text,
        "[program]\nfile = \"own.ngc\"\nstart = {{ x_mm = {:.12}, y_mm = {:.12}, z_mm = {:.12} }}",
        start.x, start.y, start.z
    )
    .unwrap();
    let program =
        format!("G1 X{:.12} Y{:.12} Z{:.12} A{:.12} F1000\nM2\n", end.x, end.y, end.z, motion.turn.norm().to_degrees());
    load(&text, &program)
}

#[test]
fn the_truth_about_motions_is_what_certificates_prove() {
    for posed in motions::thin_walls(480, 11) {
        for question in &posed.questions {
            let scene = as_program(&posed, question);
            let certificate = certified(&scene);
            accepted(&certificate, &posed.pair);
            let expected = if question.exact { Verdict::Collision } else { Verdict::Free };
            assert_eq!(certificate.blocks[&1], expected, "{}: {question:?} {:?}", posed.pair, certificate.doubts);
            if let Some(time) = question.value {
                let within = certificate.doubts[0].within;
                assert!(within[0] - 1e-6 <= time && time <= within[1] + 1e-6, "{}: {time} {within:?}", posed.pair);
            }
        }
    }
}

/// Lines that begin with one of these words.
fn numbers_of(lines: &[String], words: &[&str]) -> Vec<usize> {
    (0..lines.len()).filter(|&i| words.contains(&lines[i].split(' ').next().unwrap())).collect()
}

/// Changes a certificate in one of many ways, so that it proves nothing any more; what was done.
fn tamper(lines: &mut Vec<String>, random: &mut Pcg64) -> (&'static str, bool) {
    let mut pick = |found: &[usize]| found[random.random_range(0..found.len())];
    let fronts: Vec<usize> = numbers_of(lines, &["free"]).into_iter().filter(|&i| lines[i].contains(" p ")).collect();
    let (free, vertices, moves) = (
        numbers_of(lines, &["free", "same"]),
        numbers_of(lines, &["v"]),
        numbers_of(lines, &["point", "feed", "rapid"]),
    );
    let way = pick(&(0..11).collect::<Vec<_>>());
    let edit = |line: &str, word: usize, change: &dyn Fn(&str) -> String| {
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        words[word] = change(&words[word]);
        words.join(" ")
    };
    // Whether it is to be refused although its hash is right.
    match way {
        0 | 1 => {
            let i = pick(&fronts);
            let planes: Vec<usize> =
                lines[i].split(' ').enumerate().filter(|(_, word)| *word == "p").map(|(at, _)| at).collect();
            let at = pick(&planes);
            let by = if way == 0 { 50_000_000_000_i64 } else { -50_000_000_000 };
            lines[i] = edit(&lines[i], at + 4, &|offset| (offset.parse::<i64>().unwrap() + by).to_string());
            ("a shifted plane", true)
        }
        2 => {
            let i = pick(&fronts);
            let at = lines[i].split(' ').position(|word| word == "p").unwrap();
            for k in 1..=3 {
                lines[i] = edit(&lines[i], at + k, &|x| (-x.parse::<i64>().unwrap()).to_string());
            }
            ("a plane turned round", true)
        }
        3 => {
            lines.remove(pick(&free));
            ("an interval cut out", false)
        }
        4 => {
            let moving: Vec<usize> = free
                .iter()
                .copied()
                .filter(|&i| lines[i].split(' ').nth(2).unwrap().parse::<f64>().unwrap() > 0.01)
                .collect();
            let i = pick(&moving);
            lines[i] = edit(&lines[i], 2, &|bound| (0.9 * bound.parse::<f64>().unwrap()).to_string());
            ("a smaller motion bound", true)
        }
        5 => {
            let i = pick(&vertices);
            lines[i] = edit(&lines[i], 1, &|x| (x.parse::<i64>().unwrap() + (3000 << 26)).to_string());
            ("another mesh", true)
        }
        6 => {
            let moving: Vec<usize> =
                moves.iter().copied().filter(|&i| moves.contains(&(i + 1)) && lines[i + 1] != lines[i]).collect();
            let i = pick(&moving);
            lines.swap(i, i + 1);
            ("swapped moves", false)
        }
        7 => {
            let pairs: Vec<usize> = free.iter().copied().filter(|&i| free.contains(&(i + 1))).collect();
            let i = pick(&pairs);
            lines.swap(i, i + 1);
            ("swapped intervals", true)
        }
        8 => {
            let i = pick(&numbers_of(lines, &["pair"]));
            lines.remove(i);
            ("a pair left out", true)
        }
        9 => {
            let i = pick(&numbers_of(lines, &["pair"]));
            lines[i] = edit(&lines[i], 3, &|_| "rigid".to_owned());
            ("another reason", true)
        }
        _ => {
            let i = pick(&free);
            lines[i] = edit(&lines[i], 1, &|to| (to.parse::<f64>().unwrap() + 1e7).to_string());
            ("an interval made longer", true)
        }
    }
}

#[test]
fn a_certificate_that_was_tampered_with_is_refused() {
    let wanted: usize = std::env::var("BVBENCH_CERTIFY_TAMPERED").ok().and_then(|text| text.parse().ok()).unwrap_or(60);
    let scenes: Vec<Certificate> =
        (1..=4).map(|seed| certified(&random_scene(&mut Pcg64::seed_from_u64(seed), 12, false))).collect();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for seed in 0..wanted {
        let mut random = Pcg64::seed_from_u64(seed as u64);
        let certificate = &scenes[seed % scenes.len()];
        let mut lines: Vec<String> = certificate.text.lines().map(str::to_owned).collect();
        let (what, is_wrong) = tamper(&mut lines, &mut random);
        let text = lines.join("\n") + "\n";
        let text = if is_wrong { signed(&text) } else { text };
        assert!(text != certificate.text, "{what}: nothing changed");
        assert!(checked(&text).is_err(), "{what}, seed {seed}: accepted");
        *counts.entry(what).or_default() += 1;
    }
    println!("{wanted} tampered certificates refused: {counts:?}");
}

#[test]
fn a_certificate_names_the_files_that_its_program_calls() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("main.ngc", "o<go> call\nM2");
    write("go.ngc", "o<go> sub\nG0 Z10\no<go> endsub\nM2");
    let program = folder.path().join("main.ngc");
    let scene = sheets(0.3, "Z", "M2");
    let run = scene.program.as_ref().unwrap().with_program(&program).unwrap();
    let certificate = certify(&scene, &run, None, &Silent).unwrap();
    let compared = || certificate_checker::check(&certificate.text, None, Some(&program), MOST_WORK);
    assert!(compared().is_ok(), "{:?}", compared().err());
    write("go.ngc", "o<go> sub\nG0 Z-10\no<go> endsub\nM2");
    assert!(compared().unwrap_err().why.contains("go.ngc"));
}

#[test]
fn shipped_programs_are_certified_and_their_scenes_compared() {
    for (name, least_free) in [("trunnion-impeller", 1), ("lathe-toolpost", 1), ("grading-1", 1)] {
        let scene = Scene::find(name).unwrap();
        let certificate = certified(&scene);
        accepted(&certificate, name);
        assert!(certificate.count(Verdict::Free) >= least_free, "{name}: {:?}", certificate.blocks);
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("bench-scenes").join(name);
        let program = Path::new(env!("CARGO_MANIFEST_DIR")).join(&scene.program.as_ref().unwrap().file);
        let report = certificate_checker::check(&certificate.text, Some(&folder), Some(&program), MOST_WORK);
        let report = report.unwrap_or_else(|Refusal { line, why }| panic!("{name}:{line}: {why}"));
        assert!(report.work < MOST_WORK / 100, "{name}: {}", report.work);
        // Of another scene's folder it is no certificate.
        let other = folder.with_file_name("robot-cell");
        assert!(certificate_checker::check(&certificate.text, Some(&other), None, MOST_WORK).is_err(), "{name}");
    }
}
