//! What LinuxCNC's own tests and its users' programs have shown: each case failed once. Expectations are worked out by hand.

use rs274::{Axis, MoveKind, Plane, Program, Setup, Tool, interpret};
use std::f64::consts::TAU;
use std::path::Path;

fn run(source: &str) -> Program {
    run_with(source, &Setup::default())
}

fn run_with(source: &str, setup: &Setup) -> Program {
    interpret(source, Path::new("test.ngc"), setup).unwrap_or_else(|error| panic!("{source}: {error}"))
}

fn refused(source: &str) -> String {
    interpret(source, Path::new("bad.ngc"), &Setup::default()).expect_err("the program is wrong").to_string()
}

/// X, Y, Z of the end, mm.
fn end(program: &Program) -> [f64; 3] {
    let end = program.moves.last().expect("the program moves").end;
    [end[Axis::X], end[Axis::Y], end[Axis::Z]]
}

fn assert_near(found: [f64; 3], expected: [f64; 3], what: &str) {
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{what}: {found:?}, expected {expected:?}");
}

#[test]
fn a_reading_set_in_a_turned_system_moves_its_origin_along_both_axes() {
    let (cos, sin) = (30_f64.to_radians().cos(), 0.5);
    // In G54, turned by 30 degrees, the tool goes to X10, which shall read X0; X5 is then at 15 along the turned X axis.
    let source = "G54 G10 L2 P1 R30\nG0 X10 Y0\nG10 L20 P1 X0\nG0 X5\nM2";
    assert_near(end(&run(source)), [15.0 * cos, 15.0 * sin, 0.0], source);
    // Y keeps its reading, which is 4: a move to Y0 goes back by 4 along the turned Y axis.
    let source = "G54 G10 L2 P1 R30\nG0 X10 Y4\nG10 L20 P1 X-2\nG0 X0 Y0\nM2";
    assert_near(end(&run(source)), [12.0 * cos, 12.0 * sin, 0.0], source);
    // Another system than the one in force has its own turn and origin.
    let source = "G10 L2 P2 X100 Y0 R90\nG0 X10 Y4\nG10 L20 P2 X1\nG55 G0 X0 Y0\nM2";
    // In G55 the place (10, 4) reads X4 Y90; it shall read X1 Y90: (0, 0) is a step back of 1 along Y and of 90 along -X.
    assert_near(end(&run(source)), [100.0, 3.0, 0.0], source);
    assert!(refused("G10 L20 P1 X0 R30\nM2").contains("G10 L2 sets it"));
}

#[test]
fn a_tool_measured_in_a_turned_system_keeps_its_offset_along_the_other_axis() {
    let tool = Tool { offset: rs274::Position([3.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), ..Tool::default() };
    let setup = Setup { tools: [(1, tool)].into(), tool: 1, ..Setup::default() };
    // Turned by 90 degrees the program's X is Y: at Y10 it reads X10, shall read X7, so the offset is 3 in Y; along the turned Y axis,
    // which is -X, the table's 3 stays.
    let source = "G10 L2 P1 R90\nG53 G0 X0 Y10\nG10 L10 P1 X7\nG43\nG0 X0 Y0\nM2";
    assert_near(end(&run_with(source, &setup)), [3.0, 3.0, 0.0], source);
}

#[test]
fn a_tap_leaves_at_feed_to_where_the_cycle_ends() {
    let told = |source: &str| {
        let program = run(source);
        let moves = program.moves.iter().skip(1);
        moves.map(|step| (step.kind, step.end[Axis::Z], step.spindle_rpm)).collect::<Vec<_>>()
    };
    // From Z 2 under G98: to R at 1, in, the spindle turns back, the dwell, out at feed to 2.
    let (rapid, feed) = (MoveKind::Rapid, MoveKind::Feed);
    let expected = [(rapid, 2.0, 100.0), (rapid, 1.0, 100.0), (feed, -1.0, 100.0), (feed, 2.0, -100.0)];
    assert_eq!(told("M3 S100 G0 Z2\nG98 G84 X1 Z-1 R1 F50\nM2"), expected);
    let dwell = MoveKind::Dwell { seconds: 0.5 };
    let expected =
        [(rapid, 2.0, -100.0), (rapid, 1.0, -100.0), (feed, -1.0, -100.0), (dwell, -1.0, 100.0), (feed, 2.0, 100.0)];
    assert_eq!(told("M4 S100 G0 Z2\nG98 G74 X1 Z-1 R1 P0.5 F50\nM2"), expected);
    // A reamer too; a boring bar's feed ends at R.
    let kinds = |source| told(source).into_iter().skip(2).map(|(kind, z, _)| (kind, z)).collect::<Vec<_>>();
    assert_eq!(kinds("M3 S1 G0 Z2\nG98 G89 X1 Z-1 R1 P0.5 F50\nM2"), [(feed, -1.0), (dwell, -1.0), (feed, 2.0)]);
    assert_eq!(kinds("M3 S1 G0 Z2\nG98 G85 X1 Z-1 R1 F50\nM2"), [(feed, -1.0), (feed, 1.0), (rapid, 2.0)]);
}

#[test]
fn the_safety_line_cancels_cycles_and_lets_its_motion_be() {
    for line in ["G00 G17 G21 G40 G49 G80 G90", "G80 G17 G21 G40 G49 G0 G90", "G80 G80 G0"] {
        let program = run(&format!("G81 X1 Z-1 R1 F50\n{line}\nX7\nM2"));
        assert_eq!(program.moves.last().unwrap().kind, MoveKind::Rapid, "{line}");
        assert_near(end(&program), [7.0, 0.0, 1.0], line);
    }
    assert_eq!(run("G1 G80 X5 F100\nM2").moves[0].kind, MoveKind::Feed);
    assert!(refused("G0 G1 X1\nM2").contains("excludes G0"));
}

#[test]
fn arcs_within_linuxcncs_tolerance_are_spirals() {
    // Radii 25.014 and 24.986 mm, 250 and 249.93 mm, and in inches 2.5014 and 2.4986: just inside.
    for (source, sweep) in [
        ("G0 X25.014 Y0\nG2 X-24.986 Y0 I-25.014 F100\nM2", -0.5 * TAU),
        ("G0 X250 Y0\nG3 X0 Y249.76 I-250 F100\nM2", 0.25 * TAU),
        ("G20 G0 X2.5014 Y0\nG2 X-2.4986 Y0 I-2.5014 F10\nM2", -0.5 * TAU),
    ] {
        let MoveKind::Arc { sweep: found, .. } = run(source).moves[1].kind else { panic!("{source}") };
        assert!((found - sweep).abs() < 1e-9, "{source}: {found}");
    }
    // What is refused in mm is not in inches, and 3 mm is refused anyway.
    assert!(refused("G0 X25.02 Y0\nG2 X-24.98 Y0 I-25.02 F100\nM2").contains("arc radius is 25.02 mm"));
    assert!(refused("G0 X9000 Y0\nG2 X-8997 Y0 I-9000 F100\nM2").contains("arc radius is 9000 mm"));
}

#[test]
fn a_full_circle_needs_its_centre_alone() {
    let program = run("G0 X10\nG3 I-10 F100\nI-5\nM2");
    let sweeps: Vec<f64> = program.moves[1..]
        .iter()
        .map(|step| if let MoveKind::Arc { sweep, .. } = step.kind { sweep } else { 0.0 })
        .collect();
    assert_eq!(sweeps, [TAU, TAU]);
    assert!(refused("G0 X10\nI-5\nM2").contains("no code of this block uses this word"));
}

#[test]
fn arcs_outside_xy_turn_with_their_system() {
    // A half circle in ZX about Y, in a system turned by 30 degrees: it lies in the plane of Z and the turned X axis.
    let source = "G10 L2 P1 R30\nG18 G0 X10 Y2 Z0\nG2 X-10 Z0 I-10 K0 F100\nM2";
    let program = run(source);
    let (cos, sin) = (30_f64.to_radians().cos(), 0.5);
    assert_near(end(&program), [-10.0 * cos - 2.0 * sin, -10.0 * sin + 2.0 * cos, 0.0], source);
    assert!(program.moves.len() > 40, "{}", program.moves.len());
    for step in &program.moves[1..] {
        // Back in the system: Y is 2 and the radius 10.
        let (x, y) = (step.end[Axis::X], step.end[Axis::Y]);
        let (along, across) = (x * cos + y * sin, y * cos - x * sin);
        assert!((across - 2.0).abs() < 1e-9 && (along.hypot(step.end[Axis::Z]) - 10.0).abs() < 1e-9, "{:?}", step.end);
        assert_eq!(step.kind, MoveKind::Feed);
    }
    // Clockwise about +Y seen from +Y: from X towards -Z is counter-clockwise in ZX; G2 goes the other way, by positive Z.
    assert!(program.moves[20].end[Axis::Z] > 0.0);
    let upright = run("G18 G0 X10 Y2 Z0\nG2 X-10 Z0 I-10 K0 F100\nM2");
    assert!(matches!(upright.moves[1].kind, MoveKind::Arc { plane: Plane::Zx, sweep, .. } if sweep < 0.0));
}

#[test]
fn a_parameter_exists_or_not() {
    let source = "#<a>=999\n#1=2\n#2=99999\nG0 X EXISTS[#1] Y EXISTS[#99999] Z EXISTS[#<a>]\nM2";
    assert_near(end(&run(source)), [1.0, 0.0, 1.0], source);
    let source = "#1=2\n#2=99999\nG0 X EXISTS[##1] Y EXISTS[##2] Z EXISTS[###1]\nM2";
    assert_near(end(&run(source)), [1.0, 0.0, 0.0], source);
    assert!(refused("G0 X EXISTS[1]\nM2").contains("parameter's number or name"));
    assert!(refused("G0 X EXISTS[#1+#2]\nM2").contains("`]` expected"));
}

#[test]
fn comments_may_stand_between_the_arguments_of_a_call() {
    let source = "o<go> sub\nG0 X#1 Y#2\no<go> endsub\no<go> call [4] (the second is Y) [5]\nM2";
    assert_near(end(&run(source)), [4.0, 5.0, 0.0], source);
}

#[test]
fn of_two_programs_with_one_number_the_first_is_called() {
    let source = "M98 P2\nM2\nO2\nG0 X1\nM99\nO0002\nG0 X2\nM99";
    assert_near(end(&run(source)), [1.0, 0.0, 0.0], source);
}
