//! Compensated paths worked out by hand. Tool 1 has radius 5 mm; tool 2 is a lathe tool of nose radius 1 mm that points to
//! the lower left (orientation 2).

use crate::{Axis, MoveKind, Plane, RapidPath, Sampling, Setup, Tool, interpret, sample};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

/// A straight end, or the end, centre and sweep of an arc, in the plane's axes.
#[derive(Clone, Copy, Debug)]
enum Expected {
    Line(f64, f64),
    Arc([f64; 2], [f64; 2], f64),
}
use Expected::{Arc, Line};

fn setup() -> Setup {
    let lathe_tool = Tool { orientation: 2, ..Tool::with_length(0.0, 2.0) };
    Setup { tools: [(1, Tool::with_length(0.0, 10.0)), (2, lathe_tool)].into(), tool: 1, ..Setup::default() }
}

fn message(source: &str) -> String {
    interpret(source, Path::new("t.ngc"), &setup()).map(|_| ()).unwrap_err().to_string()
}

/// The moves of a program that begins at the origin.
fn assert_path(source: &str, plane: Plane, expected: &[Expected]) {
    let program = interpret(source, Path::new("t.ngc"), &setup()).unwrap_or_else(|error| panic!("{source}: {error}"));
    let [first, second, _] = plane.axes();
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert_eq!(program.moves.len(), expected.len(), "{source}: {:#?}", program.moves);
    for (step, expected) in program.moves.iter().zip(expected) {
        let end = [step.end[first], step.end[second]];
        let agrees = match (step.kind, expected) {
            (MoveKind::Rapid | MoveKind::Feed | MoveKind::Dwell { .. }, &Line(u, v)) => {
                near(end[0], u) && near(end[1], v)
            }
            (MoveKind::Arc { centre, sweep, plane: p }, &Arc(e, c, s)) => {
                let pairs = end.into_iter().zip(e).chain(centre.into_iter().zip(c));
                p == plane && pairs.into_iter().all(|(a, b)| near(a, b)) && near(sweep, s)
            }
            _ => false,
        };
        assert!(agrees, "{source}: {expected:?} is not {step:?}");
    }
}

fn assert_xy(source: &str, expected: &[Expected]) {
    assert_path(&format!("F100 {source}\nM2"), Plane::Xy, expected);
}

#[test]
fn an_outside_corner_is_rounded_and_the_way_out_is_straight() {
    // 5 to the left of +X, then of -Y.
    let round = Arc([25.0, 0.0], [20.0, 0.0], -FRAC_PI_2);
    assert_xy("G41 G1 X20\nY-20\nG40 X0", &[Line(20.0, 5.0), round, Line(25.0, -20.0), Line(0.0, -20.0)]);
    // Rapids cut the corner off.
    assert_xy("G41 D1 G0 X20\nY-20\nG40", &[Line(20.0, 5.0), Line(25.0, 0.0), Line(25.0, -20.0)]);
    // Back on itself: round the end.
    assert_xy("G41 G1 X20\nX0", &[Line(20.0, 5.0), Arc([20.0, -5.0], [20.0, 0.0], -PI), Line(0.0, -5.0)]);
}

#[test]
fn parameters_tell_the_programmed_place_from_g40_on() {
    // The tool is at Y5, and the lead-out goes to Y0.
    for to in ["X#<_x> Y#<_y>", "X#5420 Y#5421", "X#<_abs_x> Y#<_abs_y>"] {
        let expected = [Line(20.0, 5.0), Line(40.0, 5.0), Line(40.0, 0.0)];
        assert_xy(&format!("G41 G1 X20\nX40\nG40\n{to}"), &expected);
    }
}

#[test]
fn behind_an_arc_a_path_that_turns_back_stays_on_its_side() {
    // A quarter round (10, -10) with the tool outside, at radius 11, then back by 178 degrees: as LinuxCNC does it, the two shifted curves end where
    // they meet, and the tool does not go round the corner between them.
    let direction = [92_f64.to_radians().cos(), 92_f64.to_radians().sin()];
    let to = [20.0 + 20.0 * direction[0], -10.0 + 20.0 * direction[1]];
    // From the centre to the line that is shifted by 1, and along it to the circle.
    let from = [10.0 - direction[1], direction[0]];
    let along = from[0] * direction[0] + from[1] * direction[1];
    let way = (along * along - from[0] * from[0] - from[1] * from[1] + 121.0).sqrt() - along;
    let meeting = [10.0 + from[0] + way * direction[0], -10.0 + from[1] + way * direction[1]];
    let sweep = (meeting[1] + 10.0).atan2(meeting[0] - 10.0) - FRAC_PI_2;
    let source = format!("G41.1 D2 G1 X10\nG2 X20 Y-10 J-10\nG1 X{:.15} Y{:.15}", to[0], to[1]);
    let end = Line(to[0] - direction[1], to[1] + direction[0]);
    assert_xy(&source, &[Line(10.0, 1.0), Arc(meeting, [10.0, -10.0], sweep), end]);
}

#[test]
fn an_inside_corner_cuts_both_sides_short() {
    assert_xy("G41 G1 X20\nY20\nX0", &[Line(15.0, 5.0), Line(15.0, 15.0), Line(0.0, 15.0)]);
    assert_xy("G42 G1 X20\nY-20", &[Line(15.0, -5.0), Line(15.0, -20.0)]);
    // What stands between the two moves goes along; nothing else of it changes.
    let program = interpret("F100 G41 G1 X20\nG4 P1\nZ3 A10\nY20\nM2", Path::new("t.ngc"), &setup()).unwrap();
    let ends: Vec<_> = program.moves.iter().map(|step| [step.end[Axis::X], step.end[Axis::Z]]).collect();
    assert_eq!(ends, [[15.0, 0.0], [15.0, 0.0], [15.0, 3.0], [15.0, 3.0]]);
}

#[test]
fn fanucs_control_does_not_see_through_two_blocks_without_a_move() {
    use crate::Dialect::{Fanuc, Haas, LinuxCnc};
    let run = |between: &str, turn: &str, dialect| {
        let source = format!("F100.\nG41D1G1X10.\nX20.\n{between}\n{turn}\nM30");
        interpret(&source, Path::new("t.nc"), &Setup { dialect, ..setup() })
    };
    for (between, turn, dialect, expected) in [
        ("M8", "Y20.", Fanuc, [15.0, 5.0]),
        ("M8\nS500", "Y20.", Fanuc, [20.0, 5.0]),
        ("N7\nZ0", "Y20.", Fanuc, [20.0, 5.0]),
        ("M8\nS500", "Y20.", Haas, [15.0, 5.0]),
        ("M8\nS500", "Y20.", LinuxCnc, [15.0, 5.0]),
        // What the macro language does, and comments, are no blocks.
        ("#1=1.\n\n(A)\nM98P2\nIF[#1EQ2.]GOTO1\nM8", "Y20.\nM30\nO2\n#2=1.\nM99", Fanuc, [15.0, 5.0]),
        // Outside corners and such as are none need no sight.
        ("M8\nS500", "X30.", Fanuc, [20.0, 5.0]),
    ] {
        let program = run(between, turn, dialect).unwrap_or_else(|error| panic!("{between}: {error}"));
        let end = program.moves[1].end;
        assert!((end[Axis::X] - expected[0]).hypot(end[Axis::Y] - expected[1]) < 1e-9, "{between} {dialect}: {end:?}");
        let told = program.notes.iter().any(|note| note.text.contains("parameter 19625"));
        assert_eq!(told, expected[0] == 20.0 && turn == "Y20.", "{between}");
    }
    // Straight from there to the end of the next.
    let program = run("M8\nS500", "Y20.", Fanuc).unwrap();
    let end = program.moves[2].end;
    assert_eq!([end[Axis::X], end[Axis::Y]], [15.0, 20.0]);
    let told = run("M8\nS500", "G3X0Y20.R20.", Fanuc).unwrap_err().to_string();
    assert!(told.starts_with("t.nc:6:1: cutter compensation: an arc at an inside corner"), "{told}");
}

#[test]
fn lines_meet_arcs_where_the_shifted_curves_do() {
    // The tool outside a circle of radius 8 about (28, 0) runs on radius 13, which is at height 5 12 to either side.
    let half = 2.0 * 5_f64.atan2(12.0);
    assert_xy(
        "G41 G1 X20\nG2 X36 I8\nG1 X60",
        &[Line(16.0, 5.0), Arc([40.0, 5.0], [28.0, 0.0], half - PI), Line(60.0, 5.0)],
    );
    // Two such circles 24 apart meet half way between, 5 up: the second one about (52, 0).
    assert_xy(
        "G41 G1 X20\nG2 X36 I8\nG1 X44\nG2 X60 I8",
        &[
            Line(16.0, 5.0),
            Arc([40.0, 5.0], [28.0, 0.0], half - PI),
            Line(40.0, 5.0),
            Arc([65.0, 0.0], [52.0, 0.0], half / 2.0 - PI),
        ],
    );
    // Touching circles of radius 12 about (32, 0) and (56, 0): on radius 17 the paths meet 12 away, sqrt(17^2 - 12^2) up.
    let (up, angle) = (145_f64.sqrt(), 145_f64.sqrt().atan2(12.0));
    let x = 32.0 - 264_f64.sqrt(); // 17^2 - 5^2
    let entry = 5_f64.atan2(264_f64.sqrt());
    assert_xy(
        "G41 G1 X20\nG2 X44 I12\nG2 X68 I12",
        &[
            Line(x, 5.0),
            Arc([44.0, up], [32.0, 0.0], -(PI - entry - angle)),
            Arc([73.0, 0.0], [56.0, 0.0], -(PI - angle)),
        ],
    );
}

#[test]
fn tangent_arcs_change_their_radius_only() {
    assert_xy("G41 G1 X20\nG3 X30 Y10 J10", &[Line(20.0, 5.0), Arc([25.0, 10.0], [20.0, 10.0], FRAC_PI_2)]);
    assert_xy("G42 G1 X20\nG3 X30 Y10 J10", &[Line(20.0, -5.0), Arc([35.0, 10.0], [20.0, 10.0], FRAC_PI_2)]);
    // Two turns stay two.
    assert_xy("G42 G1 X20\nG3 X20 Y0 J10 P2 Z4", &[Line(20.0, -5.0), Arc([20.0, -5.0], [20.0, 10.0], 2.0 * TAU)]);
    // Outside corners before and behind an arc: up to the circle about (30, 0), tool within it, and away.
    assert_xy(
        "G41 G1 X20\nG3 X40 I10\nG1 X60",
        &[
            Line(20.0, 5.0),
            Arc([25.0, 0.0], [20.0, 0.0], -FRAC_PI_2),
            Arc([35.0, 0.0], [30.0, 0.0], PI),
            Arc([40.0, 5.0], [40.0, 0.0], -FRAC_PI_2),
            Line(60.0, 5.0),
        ],
    );
}

#[test]
fn an_arc_may_lead_in() {
    // The programmed arc ends at (10, 10) going +X, the shifted one at (10, 15). Its centre lies t below that and t from the
    // origin: 10^2 + (15 - t)^2 = t^2, so t = 325 / 30 = 65 / 6, and the origin is 10 left and 25 / 6 below of it.
    let program = interpret("F100 G41 G2 X10 Y10 I10\nG1 X20\nM2", Path::new("t.ngc"), &setup()).unwrap();
    let MoveKind::Arc { centre, sweep, .. } = program.moves[0].kind else { panic!("no arc") };
    assert!((centre[0] - 10.0).abs() < 1e-9 && (centre[1] - 25.0 / 6.0).abs() < 1e-9, "{centre:?}");
    // From the left-hand side, below level, up over it to the top.
    assert!((sweep + FRAC_PI_2 + (25.0_f64 / 6.0).atan2(10.0)).abs() < 1e-9, "{sweep}");
    assert_eq!([program.moves[1].end[Axis::X], program.moves[1].end[Axis::Y]], [20.0, 15.0]);
}

#[test]
fn small_corners_are_passed_as_none() {
    // 0.03 to the left, inside: nothing is cut short; the end is 5 to the left of the new direction.
    let (sin, cos) = (0.6_f64.atan2(20.0)).sin_cos();
    assert_xy("G41 G1 X20\nX40 Y0.6", &[Line(20.0, 5.0), Line(40.0 - 5.0 * sin, 0.6 + 5.0 * cos)]);
}

#[test]
fn on_lathes_the_nose_is_shifted_and_its_point_programmed() {
    // The nose's centre is 1 from the path on the right of it; the point that moves are about lies 1 left and 1 below of that.
    let source = "F100 G8 G18 G42 D2 G1 Z-10\nX20\nZ-20\nG40 X30\nM2";
    let round = Arc([-11.0, 20.0], [-11.0, 19.0], FRAC_PI_2);
    let expected = [Line(-10.0, 0.0), Line(-10.0, 19.0), round, Line(-21.0, 20.0), Line(-20.0, 30.0)];
    assert_path(source, Plane::Zx, &expected);
}

#[test]
fn diameters_may_be_given_and_negative_ones_change_sides() {
    assert_xy("G41.1 D4 G1 X20\nY20", &[Line(18.0, 2.0), Line(18.0, 20.0)]);
    assert_xy("G42.1 D-4 G1 X20\nY20", &[Line(18.0, 2.0), Line(18.0, 20.0)]);
    assert_xy("G41.1 D0 G1 X20\nY20", &[Line(20.0, 0.0), Line(20.0, 20.0)]);
    assert_xy("G20 G41.1 D1 G1 X2", &[Line(50.8, 12.7)]);
}

#[test]
fn behind_g40_the_program_goes_on_from_its_own_place() {
    // A dwell stays where the tool is; an incremental move counts from where the programmed path had come to.
    assert_xy("G41 G1 X20\nG40\nG4 P1\nG91 X1", &[Line(20.0, 5.0), Line(20.0, 5.0), Line(21.0, 0.0)]);
}

#[test]
fn what_the_tool_cannot_follow_is_told_with_line_and_word() {
    for (source, expected) in [
        (
            "G41 G1 X4",
            "t.ngc:1:10: cutter compensation: the move that leads in is shorter than the tool's radius: `G1`",
        ),
        (
            "G41\nG1 Z1",
            "t.ngc:2:1: cutter compensation: the move that leads in is shorter than the tool's radius: `G1`",
        ),
        (
            "G41 G1 X20\nG3 X20 Y8 J4",
            "t.ngc:2:1: cutter compensation: the tool's radius is not less than the arc's: `G3`",
        ),
        (
            "G41 G1 X20\nY3\nX0",
            "t.ngc:2:1: cutter compensation: the tool does not fit into this inside corner without gouging: `Y3`",
        ),
        (
            "G41 G1 X20\nY20\nX18\nY0",
            "t.ngc:3:1: cutter compensation: the tool does not fit into this inside corner without gouging: `X18`",
        ),
        (
            "G41 G1 X20\nG40\nG2 X30 Y-10 J-10",
            "t.ngc:3:1: not allowed: an arc right behind G40: the move that leads out must be straight: `G2`",
        ),
        ("G19 G41", "t.ngc:1:10: not allowed: cutter compensation in the YZ plane (G19): `G41`"),
        ("G41\nG42", "t.ngc:2:1: not allowed: cutter compensation is on already: `G42`"),
        ("G41 D2", "t.ngc:1:6: not allowed: a lathe tool's orientation outside the ZX plane (G18): `G41`"),
        (
            "G41 D9",
            "t.ngc:1:10: tool is not in the tool table (`--tool-table`, or `[[program.tools]]` of a scene): `D9`",
        ),
        ("G41.1", "t.ngc:1:6: D, the tool's diameter, is missing: `G41.1`"),
    ] {
        let found = message(&format!("F100 {source}\nM2"));
        // The prefix moves the first line by five columns.
        let found = found.strip_prefix("t.ngc").unwrap();
        assert_eq!(found, expected.strip_prefix("t.ngc").unwrap(), "{source}");
    }
}

#[test]
fn what_would_move_the_ground_under_the_path_waits_for_g40() {
    for word in [
        "G18",
        "G55",
        "G54",
        "G53 G0 X1",
        "G28",
        "G30.1",
        "G92 X1",
        "G92.1",
        "G52 X1",
        "G43 H1",
        "G49",
        "G43.1 Z1",
        "M6",
        "G81 X1 Z-1 R1",
        "G38.2 X50",
        "G10 L2 P1 X1",
        "G10 L20 P0 X1",
        "G5.1 X50 I1 J1",
    ] {
        let found = message(&format!("F100 G41 G1 X20\n{word}\nM2"));
        assert!(found.starts_with("t.ngc:2:1: not allowed: ") && found.contains("compensation"), "{word}: {found}");
    }
    // These do not.
    for word in ["G17", "G20", "G91", "G10 L2 P2 X1", "G10 L1 P1 R1", "T2", "M8", "G4 P1", "M70\nM72"] {
        let source = format!("F100 G41 G1 X20\n{word}\nG40\nM2");
        assert!(interpret(&source, Path::new("t.ngc"), &setup()).is_ok(), "{word}");
    }
}

/// Distance of a point from a closed polygon's outline.
fn distance(polygon: &[[f64; 2]], [x, y]: [f64; 2]) -> f64 {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    edges
        .map(|(a, b)| {
            let (u, v) = (b[0] - a[0], b[1] - a[1]);
            let t = (((x - a[0]) * u + (y - a[1]) * v) / (u * u + v * v)).clamp(0.0, 1.0);
            (x - a[0] - t * u).hypot(y - a[1] - t * v)
        })
        .fold(f64::INFINITY, f64::min)
}

proptest! {
    /// Round a polygon of eight corners, some of them inside ones, the tool never comes nearer than its radius, but for what
    /// a corner that is passed as none may take away.
    #[test]
    fn the_tool_keeps_its_distance(radii in prop::collection::vec(40.0..60.0_f64, 8), tool in 0.5..4.0_f64) {
        let corner = |i: usize| {
            let (sin, cos) = (i as f64 * TAU / 8.0).sin_cos();
            [radii[i] * cos, radii[i] * sin]
        };
        let polygon: Vec<[f64; 2]> = (0..8).map(corner).collect();
        let mut source = format!("F100 G0 X100 Y-50\nG42.1 D{:.6}\n", 2.0 * tool);
        for [x, y] in polygon.iter().chain(&polygon[..2]) {
            source += &format!("G1 X{x:.9} Y{y:.9}\n");
        }
        let program = interpret(&source, Path::new("t.ngc"), &setup()).unwrap();
        let sampling = Sampling { step_mm: 1.0, step_deg: 1.0, chord_mm: 1e-4 };
        let samples = sample(&program, &Setup::default().start, &sampling, &RapidPath::Straight).unwrap();
        // Line 3 leads in, and nothing has cut line 12 short.
        for place in samples.iter().filter(|place| (4..12).contains(&place.line)) {
            let found = distance(&polygon, [place.position[Axis::X], place.position[Axis::Y]]);
            prop_assert!(found >= tool * super::SMOOTH_CORNER.cos() - 1e-4, "{found} of {tool} at line {}", place.line);
        }
    }
}
