//! What LinuxCNC's own tests and its users' programs have shown: each case failed once. Expectations are worked out by hand.

mod support;

use rs274::{Axis, Dialect, MoveKind, Plane, Program, Setup, Tool, Units};
use std::f64::consts::TAU;
use support::assert_near;

fn run(source: &str) -> Program {
    support::run(source, &Setup::default())
}

fn refused(source: &str) -> String {
    support::refused(source, &Setup::default())
}

/// X, Y, Z of the end, mm.
fn end(program: &Program) -> [f64; 3] {
    *support::ends(program).last().expect("the program moves")
}

#[test]
fn what_m66_reads_is_not_known() {
    let noted = |source: &str| {
        let program = support::run(source, &Setup::default());
        program.notes.iter().filter(|note| note.is_unknown && note.text.starts_with("#5399 is read as 0")).count()
    };
    assert_eq!(noted("M66 P0 L3 Q5\no1 if [#5399 EQ -1]\nG0 X8\no1 endif\nG0 X1\nM2"), 1);
    assert_eq!(noted("#5399 = 7\nM66 E0 L0\nG0 X#5399\nM2"), 1);
    support::assert_ends("#5399 = 7\nM66 E0 L0\nG0 X#5399\nM2", &Setup::default(), &[[0.0; 3]]);
    // Nobody asks, or for what the program has put there.
    assert_eq!(noted("M66 P0 L3 Q5\nG0 X1\nM2"), 0);
    assert_eq!(noted("M66 P0 L3 Q5\n#5399 = 2\nG0 X#5399\nM2"), 0);
    assert_eq!(noted("G0 X#5399\nM2"), 0);
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
fn an_origin_written_as_a_parameter_counts_when_its_system_is_selected_after_another() {
    let told = "counts when it is selected after another";
    for (source, expected, is_noted) in [
        ("#5221=5\nG54 G0 X1", 1.0, true),
        ("#5230=90\nG54 G0 X1", 1.0, true),
        ("G54 G0 X1", 1.0, false),
        ("#5221=5\nG55\nG54 G0 X1", 6.0, false),
        ("#5221=5\nM70\nM72\nG0 X1", 1.0, true),
        ("#5221=5\nM70\nG55\nM72\nG0 X1", 6.0, false),
        // G10 has the other words from the parameters.
        ("#5221=5\nG10 L2 P1 Y0\nG54 G0 X1", 6.0, false),
    ] {
        let program = run(&format!("{source}\nM2"));
        assert_near(end(&program), [expected, 0.0, 0.0], source);
        assert_eq!(program.notes.iter().any(|note| note.text.contains(told)), is_noted, "{source}");
    }
}

#[test]
fn a_shifted_system_is_not_turned() {
    for source in [
        "G92 X5\nG10 L2 P1 R90",
        "G52 Y5\nG10 L2 P0 R90",
        "G10 L2 P1 R90\nG92 X5\nG10 L2 P1 R0",
        "G92 X5\n#5230=90\nG10 L20 P1 Y0",
    ] {
        let told = refused(&format!("{source}\nM2"));
        assert!(told.contains("LinuxCNC loses its place"), "{source}: {told}");
    }
    // Another system, the same turn, a shift along Z, none any more.
    for source in [
        "G92 X5\nG10 L2 P2 R90",
        "G10 L2 P1 R90\nG92 X5\nG10 L2 P1 R90",
        "G92 Z5\nG10 L2 P1 R90",
        "G92 X5\nG92.1\nG10 L2 P1 R90",
    ] {
        run(&format!("{source}\nM2"));
    }
}

#[test]
fn only_the_named_axes_of_a_turned_system_go_home() {
    // X is along Y of the machine and Y along its -X: from (-5, 10).
    let turned = "G10 L2 P1 R90\nG0 X10 Y5\nG91";
    for (home, expected) in [
        ("G28 X0", [-5.0, 0.0, 0.0]),
        ("G28 Y0", [0.0, 10.0, 0.0]),
        ("G30 X0 Z1", [-5.0, 0.0, 0.0]),
        ("G28 Z1", [-5.0, 10.0, 0.0]),
        ("G28 X0 Y0", [0.0; 3]),
        ("G28", [0.0; 3]),
    ] {
        assert_near(end(&run(&format!("{turned} {home}\nM2"))), expected, home);
    }
}

#[test]
fn a_tool_measured_in_a_turned_system_keeps_its_offset_along_the_other_axis() {
    let tool = Tool { offset: rs274::Position([3.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), ..Tool::default() };
    let setup = Setup { tools: [(1, tool)].into(), tool: 1, ..Setup::default() };
    // Turned by 90 degrees the program's X is Y: at Y10 it reads X10, shall read X7, so the offset is 3 in Y; along the turned Y axis,
    // which is -X, the table's 3 stays.
    let source = "G10 L2 P1 R90\nG53 G0 X0 Y10\nG10 L10 P1 X7\nG43\nG0 X0 Y0\nM2";
    assert_near(end(&support::run(source, &setup)), [3.0, 3.0, 0.0], source);
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
fn a_rigid_tap_comes_out_i_times_as_fast() {
    for (word, factor) in [("", 1.0), ("I2", 2.0), ("I0.5", 1.0), ("I-3", 1.0)] {
        let program = run(&format!("M3 S200\nG33.1 Z-1 K0.5 {word}\nG33 Z1 K0.5\nM2"));
        let told: Vec<_> =
            program.moves.iter().map(|step| (step.end[Axis::Z], step.spindle_rpm, step.feed_mm_min)).collect();
        let at = |z: f64, times: f64| (z, 200.0 * times, Some(100.0 * times));
        assert_eq!(told, [at(-1.0, 1.0), at(0.0, factor), at(1.0, 1.0)], "{word}");
    }
    assert!(refused("M3 S200\nG33 Z-1 K0.5 I2\nM2").contains("no code of this block uses this word"));
}

#[test]
fn all_spindles_are_the_one() {
    let program = run("S100 $-1\nM3 $-1\nG0 X1\nG97 S50 $0\nM4 $-1\nG0 X2\nM5 $-1\nG0 X3\nM2");
    let speeds: Vec<f64> = program.moves.iter().map(|step| step.spindle_rpm).collect();
    assert_eq!(speeds, [100.0, -50.0, 0.0]);
    for source in ["M3 $1\nM2", "M3 $-2\nM2", "M19 R0 $-1\nM2"] {
        assert!(refused(source).contains("there is one spindle"), "{source}");
    }
}

#[test]
fn what_a_cycle_keeps_is_read_in_the_unit_that_holds() {
    let heights = |source: &str| {
        let program = run(source);
        assert!(program.moves.iter().all(|step| step.end[Axis::Y] == 0.0), "{source}");
        let last = program.moves.iter().skip_while(|step| step.end[Axis::X] == 0.0);
        last.map(|step| (step.end[Axis::Z] * 1e4).round() / 1e4).collect::<Vec<_>>()
    };
    for (source, expected) in [
        // From R at 2 mm straight to 2 inches, an inch below zero, and back.
        ("G0 Z10\nG81 X0 Z-1 R2 F100\nG20\nX1", &[50.8, -25.4, 50.8][..]),
        // The height where the first cycle started is 10 inches, too.
        ("G0 Z10\nG98 G81 X0 Z-1 R2 F100\nG20\nX1", &[254.0, 50.8, -25.4, 254.0]),
        // Inches become mm; from 1 inch, where the cycle before ended, to R at 1 mm.
        ("G20 G0 Z1\nG81 X0 Z-1 R1 F100\nG21\nX1", &[25.4, 1.0, -1.0, 1.0]),
        ("G0 Z3\nG83 X0 Z-1 R1 Q1.5 F100\nG20 X1", &[25.4, -12.7, 25.4, -12.446, -25.4, 25.4]),
        // Kept modes bring the unit back, and with it the words.
        ("F100 G0 Z2\nM70\nG20 G81 X0 Z-1 R2\nM72\nX1", &[2.0, -1.0, 2.0]),
    ] {
        assert_eq!(heights(&format!("{source}\nM2")), expected, "{source}");
    }
}

#[test]
fn taps_outside_the_xy_plane_go_where_linuxcnc_goes() {
    let ends = |source: &str| {
        let program = run(source);
        assert!(program.notes.iter().any(|note| note.text.contains("outside G17")), "{source}");
        program
            .moves
            .iter()
            .map(|step| [Axis::X, Axis::Y, Axis::Z].map(|axis| step.end[axis]))
            .skip(3)
            .collect::<Vec<_>>()
    };
    // LinuxCNC's tests/interp/g84/g18/g98 and g19: above the hole as written, then the depth as another axis's; what follows begins from the hole.
    let zx = "G18 M3 S1 G0 X0 Y2 Z0\nG98 G84 X5 Z7 Y-1 R1 F50\nG0 X9\nM2";
    assert_eq!(ends(zx), [[-1.0, 7.0, 5.0], [2.0, 7.0, 5.0], [9.0, 2.0, 7.0]]);
    let yz = "G19 M3 S1 G0 X2 Y0 Z0\nG98 G84 Y5 Z7 X-1 R1 F50\nG0 Y9\nM2";
    assert_eq!(ends(yz), [[7.0, -1.0, 5.0], [7.0, 2.0, 5.0], [2.0, 9.0, 7.0]]);
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
fn a_feed_rate_is_that_of_x_y_and_z_where_they_move() {
    for (source, minutes) in [
        ("F100 G1 X100 U100", 1.0),
        ("F100 G1 Z30 Y40 W-900 A90", 0.5),
        ("F100 G1 U30 V40 A90", 0.5),
        ("F100 G1 A100", 1.0),
        ("F100 G3 X0 Y0 I10 W500", TAU / 10.0),
        ("F100 G3 X0 Y0 I10 Z20 W500", (TAU / 10.0).hypot(0.2)),
        ("G93 G1 X100 U100 F2", 0.5),
        ("G93 G3 X0 Y0 I10 W500 F2", 0.5),
    ] {
        let program = run(&format!("{source}\nM2"));
        let step = &program.moves[0];
        let found = rs274::path::length(&rs274::Position::default(), step) / step.feed_mm_min.unwrap();
        assert!((found - minutes).abs() < 1e-9, "{source}: {found}");
    }
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
    for name in ["_current_pocket", "_selected_pocket"] {
        assert_near(end(&run(&format!("G0 X EXISTS[#<{name}>]\nM2"))), [1.0, 0.0, 0.0], name);
        assert!(refused(&format!("G0 X#<{name}>\nM2")).contains("a pocket of the tool changer, which is not known"));
        assert!(refused(&format!("#<{name}>=1\nM2")).contains("read-only"));
    }
    assert!(refused("G0 X EXISTS[1]\nM2").contains("parameter's number or name"));
    assert!(refused("G0 X EXISTS[#1+#2]\nM2").contains("`]` expected"));
}

#[test]
fn loops_that_are_left_from_inside_run_on_as_linuxcncs_do() {
    // `/` ends a line, STEP goes on by 1 along X, FOUR opens a loop of four rounds, STEPS one that counts them, and LEAVE may leave it.
    let spelled = |text: &str| {
        let text = text.replace("STEPS", "o4 do / #2=[#2+1]").replace("LEAVE", "o6 if [#2 EQ 9] / o4 break / o6 endif");
        let text = text.replace("STEP", "G91 G0 X1 / G90").replace("FOUR", "#1=0 / o1 while [#1 LT 4] / #1=[#1+1]");
        format!("{}\nM2", text.replace(" / ", "\n"))
    };
    for (source, expected) in [
        // A `repeat` that `return` or a loop around it has left counts on: two of four rounds find nothing left, and go on to Z.
        (
            "o9 sub / o2 repeat [1] / STEP / o9 return / o2 endrepeat / G91 G0 Z1 / o9 endsub / o9 call / o9 call / o9 call / o9 call",
            [2.0, 0.0, 2.0],
        ),
        ("FOUR / o2 repeat [1] / STEP / o1 continue / o2 endrepeat / G91 G0 Z1 / o1 endwhile", [2.0, 0.0, 2.0]),
        (
            "FOUR / o4 while [1] / o2 repeat [3] / #2=[#2+1] / o3 if [#2 EQ 2] / o4 break / o3 endif / STEP / o2 endrepeat / o4 break / o4 endwhile / o1 endwhile",
            [8.0, 0.0, 0.0],
        ),
        // One that has run out begins anew; its count is read at its begin.
        ("FOUR / o2 repeat [3] / STEP / o2 endrepeat / o1 endwhile", [12.0, 0.0, 0.0]),
        ("#1=2 / o2 repeat [#1] / #1=9 / STEP / o2 endrepeat / o3 repeat [-3] / STEP / o3 endrepeat", [2.0, 0.0, 0.0]),
        // A `break` of a `while` loop makes the next `do` loop end at its `continue`: at Y1, not Y4. That of a `do` loop does not.
        (
            "o1 while [1] / o1 break / o1 endwhile / o4 do / #2=[#2+1] / o5 if [#2 EQ 2] / o4 continue / o5 endif / G0 Y#2 / o4 while [#2 LT 4]",
            [0.0, 1.0, 0.0],
        ),
        ("o1 do / o1 break / o1 while [1] / o4 do / #2=[#2+1] / G0 Y#2 / o4 while [#2 LT 4]", [0.0, 4.0, 0.0]),
        // A `break` that is skipped over counts: below a `continue`, and in a `while` loop that ends by its condition. One above the `continue` does not.
        ("STEPS / o5 if [#2 EQ 2] / o4 continue / o5 endif / G0 Y#2 / LEAVE / o4 while [#2 LT 4]", [0.0, 1.0, 0.0]),
        ("STEPS / LEAVE / o5 if [#2 EQ 2] / o4 continue / o5 endif / G0 Y#2 / o4 while [#2 LT 4]", [0.0, 4.0, 0.0]),
        ("o1 while [0] / o1 break / o1 endwhile / STEPS / G0 Y#2 / o4 while [#2 LT 4]", [0.0, 1.0, 0.0]),
        (
            "o1 while [#1 LT 2] / #1=[#1+1] / o3 if [0] / o1 break / o3 endif / o1 endwhile / STEPS / G0 Y#2 / o4 while [#2 LT 4]",
            [0.0, 1.0, 0.0],
        ),
        // A `continue` of a `do` loop makes the next `repeat` run twice, and the next `break` go on with its loop.
        ("o1 do / #1=1 / o1 continue / o1 while [#1 LT 1] / o2 repeat [2] / STEP / o2 endrepeat", [4.0, 0.0, 0.0]),
        (
            "o1 do / #1=1 / o1 continue / o1 while [#1 LT 1] / o2 while [#2 LT 3] / #2=[#2+1] / STEP / o3 if [#2 EQ 1] / o2 break / o3 endif / o2 endwhile",
            [3.0, 0.0, 0.0],
        ),
    ] {
        assert_near(end(&run(&spelled(source))), expected, source);
    }
    for word in ["break", "continue"] {
        let told = refused(&spelled(&format!("o1 repeat [2] / o1 {word} / o1 endrepeat")));
        assert!(told.contains("in no `while` or `do` loop"), "{word}: {told}");
    }
}

#[test]
fn comments_may_stand_between_the_arguments_of_a_call() {
    let source = "o<go> sub\nG0 X#1 Y#2\no<go> endsub\no<go> call [4] (the second is Y) [5]\nM2";
    assert_near(end(&run(source)), [4.0, 5.0, 0.0], source);
}

#[test]
fn a_number_in_angle_brackets_is_the_number() {
    for (defined, called) in [("o7", "o<7>"), ("o<7>", "o7"), ("o07", "o<7>")] {
        let source = format!("{defined} sub\nG0 X4\n{defined} endsub\n{called} call\nM2");
        assert_near(end(&run(&source)), [4.0, 0.0, 0.0], &source);
    }
    assert!(refused("o7 sub\no7 endsub\no<07> call\nM2").contains("subroutine is not defined"));
}

#[test]
fn of_two_programs_with_one_number_the_first_is_called() {
    let source = "M98 P2\nM2\nO2\nG0 X1\nM99\nO0002\nG0 X2\nM99";
    assert_near(end(&run(source)), [1.0, 0.0, 0.0], source);
}

/// X and Z of every end, with whether the move is a rapid one.
fn turned(source: &str) -> Vec<(bool, f64, f64)> {
    let micrometres = |x: f64| (x * 1e4).round() / 1e4 + 0.0;
    let moves = run(source).moves;
    let end = |step: &rs274::Move| {
        (step.kind == MoveKind::Rapid, micrometres(step.end[Axis::X]), micrometres(step.end[Axis::Z]))
    };
    moves.iter().map(end).collect()
}

#[test]
fn turning_cycles_cut_down_to_a_profile_with_fillets_and_chamfers() {
    let profile = "o1 sub\nG0 X4 Z0\nG1 Z-5 C0.5\nU2 A0.5\nW-3 A0.3\nX8\no1 endsub\n";
    let source = format!("G18 F100\n{profile}G0 X8 Z1\nG71 Q1 I4 R0.5\nX20\nM2");
    let expected = [
        (true, 8.0, 1.0),
        (true, 8.0, 1.0),
        // One cut at the start's height, up to the face at Z-8; back by R, and to the start. The next would be at the profile's begin.
        (true, 8.0, 1.0),
        (false, 8.0, -8.0),
        (true, 8.5, -7.5),
        (true, 8.5, 0.5),
        (true, 8.0, 1.0),
        // Along the profile: the chamfer takes 0.5 of both sides, the fillets have centres (5.5, -5.5) and (6.3, -7.7).
        (true, 4.0, 0.0),
        (false, 4.0, -4.5),
        (false, 4.5, -5.0),
        (false, 5.5, -5.0),
        (false, 6.0, -5.5),
        (false, 6.0, -7.7),
        (false, 6.3, -8.0),
        (false, 8.0, -8.0),
        // G1 holds, as the profile's last motion.
        (false, 20.0, -8.0),
    ];
    assert_eq!(turned(&source), expected);
    let arcs: Vec<f64> = run(&source)
        .moves
        .iter()
        .filter_map(|step| if let MoveKind::Arc { sweep, .. } = step.kind { Some(sweep) } else { None })
        .collect();
    assert!((arcs[0] - 0.25 * TAU).abs() < 1e-9 && (arcs[1] + 0.25 * TAU).abs() < 1e-9, "{arcs:?}");
    // The profile is a program: three steps in a loop. The start lies behind its begin, so the tool first goes above that.
    let source = "G18 F100\no1 sub\n#1=4\nG0 X4 Z0\no2 while [#1 LT 7]\n#1=[#1+1]\nG1 W-1\nX#1\no2 endwhile\no1 endsub\nG0 X9 Z-4\nG70 Q1\nM2";
    let steps =
        [(4.0, -1.0), (5.0, -1.0), (5.0, -2.0), (6.0, -2.0), (6.0, -3.0), (7.0, -3.0)].map(|(x, z)| (false, x, z));
    let before = [(true, 9.0, -4.0), (true, 9.0, -4.0), (true, 9.0, 0.0), (true, 9.0, 0.0), (true, 4.0, 0.0)];
    assert_eq!(turned(source), [&before[..], &steps].concat());
    // Two finishing passes at 0.4 and 0.2: (pass - 1) (D - E) / P + E, each from the start that X and Z name.
    let source =
        "G18 F100\no1 sub\nG0 X4 Z-1\nG1 Z-5\nX6\nZ-8\nX8\no1 endsub\nG0 X12 Z1\nG70 Q1 X13 Z2 D0.6 E0.2 P2\nM2";
    let pass = |off: f64| {
        let moves =
            [(true, 13.0, 2.0), (true, 4.0 + off, -1.0), (false, 4.0 + off, off - 5.0), (false, 6.0, off - 5.0)];
        let rest = [(false, 6.0 + off, -5.0), (false, 6.0 + off, off - 8.0), (false, 8.0, off - 8.0)];
        moves.into_iter().chain(rest)
    };
    let expected: Vec<_> =
        [(true, 12.0, 1.0), (true, 13.0, 2.0)].into_iter().chain(pass(0.4)).chain(pass(0.2)).collect();
    let near = |(a, b): (&(bool, f64, f64), &(bool, f64, f64))| {
        a.0 == b.0 && (a.1 - b.1).abs() < 1e-9 && (a.2 - b.2).abs() < 1e-9
    };
    let found = turned(source);
    assert!(found.len() == expected.len() && found.iter().zip(&expected).all(near), "{found:?}, expected {expected:?}");
}

#[test]
fn pockets_are_cut_with_the_rest_or_behind_it() {
    // Up to 5, down to 3, up to the start's 6, in steps of 45 degrees.
    let cycle = |code: &str| {
        turned(&format!(
            "G18 F100\no1 sub\nG0 X4 Z0\nG1 X5 Z-1\nX3 Z-3\nX6 Z-6\no1 endsub\nG0 X6 Z0\n{code} Q1 I1.5 R0.25\nM2"
        ))
        .split_off(2)
    };
    let opening = [
        (true, 6.0, 0.0),
        (false, 6.0, -6.0),
        (true, 6.25, -5.75),
        (true, 6.25, -0.25),
        (true, 6.0, 0.0),
        // At 4.5 it meets the first slope; half of the cut's length, 0.25, is R.
        (true, 4.5, 0.0),
        (false, 4.5, -0.5),
        (true, 4.75, -0.25),
        (true, 4.75, -0.25),
        (true, 4.5, 0.0),
    ];
    // G71.1 passes over the pocket at its rim.
    let over = [(true, 4.0, 0.0), (false, 5.0, -1.0), (false, 5.0, -5.0), (false, 6.0, -6.0)];
    assert_eq!(cycle("G71.1"), [&opening[..], &over].concat());
    // G71.2 cuts it from its rim on: at 5 and 3.5.
    let into = [
        (true, 4.0, 0.0),
        (false, 5.0, -1.0),
        (false, 5.0, -5.0),
        (true, 5.25, -4.75),
        (true, 5.25, -1.25),
        (false, 5.0, -1.0),
        (false, 3.5, -2.5),
        (false, 3.5, -3.5),
        (true, 3.75, -3.25),
        (true, 3.75, -2.75),
        (false, 3.5, -2.5),
        (false, 3.0, -3.0),
        (false, 6.0, -6.0),
    ];
    assert_eq!(cycle("G71.2"), into);
    // G71 does both, in the pocket at the heights of the cuts before: 4.5, and 3 is its bottom.
    let both = [
        (true, 4.0, 0.0),
        (false, 5.0, -1.0),
        (false, 4.5, -1.5),
        (false, 4.5, -4.5),
        (true, 4.75, -4.25),
        (true, 4.75, -1.75),
        (false, 4.5, -1.5),
        (false, 3.0, -3.0),
        (false, 6.0, -6.0),
    ];
    assert_eq!(cycle("G71"), [&opening[..], &both].concat());
    // A bore, towards +Z, is the mirror image.
    let source = "G18 F100\no1 sub\nG0 X8 Z0\nG1 X7 Z1\nX9 Z3\nX6 Z6\no1 endsub\nG0 X6 Z0\nG71.1 Q1 I1.5 R0.25\nM2";
    let mirrored: Vec<_> =
        [&opening[..], &over].concat().iter().map(|&(rapid, x, z)| (rapid, 12.0 - x, 0.0 - z)).collect();
    assert_eq!(turned(source).split_off(2), mirrored);
}

#[test]
fn facing_cycles_cut_along_x() {
    let source = "G18 F100\no1 sub\nG0 X20 Z-4\nG1 X12\nZ-2\nX4\nZ0\no1 endsub\nG0 X20 Z0\nG72.1 Q1 I2 R0.5\nM2";
    let expected = [
        (true, 20.0, 0.0),
        (false, 4.0, 0.0),
        (true, 4.5, 0.5),
        (true, 19.5, 0.5),
        (true, 20.0, 0.0),
        (true, 20.0, -2.0),
        (false, 12.0, -2.0),
        (true, 12.5, -1.5),
        (true, 19.5, -1.5),
        (true, 20.0, -2.0),
        (true, 20.0, -4.0),
        (false, 12.0, -4.0),
        (false, 12.0, -2.0),
        (false, 4.0, -2.0),
        (false, 4.0, 0.0),
    ];
    assert_eq!(turned(source).split_off(2), expected);
}

#[test]
fn turning_cycles_say_what_they_cannot_cut() {
    let profile = "o1 sub\nG0 X4 Z0\nG1 Z-5\nX8\no1 endsub\n";
    for (cycle, text) in [
        ("G17\nG71 Q1", "outside the ZX plane"),
        ("G71 I1", "Q, the subroutine with the profile, is missing"),
        ("G71 Q2", "subroutine is not defined"),
        ("G71 Q1 I0", "I must be above 0"),
        ("G71 Q1 Y5", "no code of this block uses this word: `Y5`"),
        ("G42.1 D1\nG71 Q1", "while cutter compensation is on"),
        ("G71 Q1 I0.0001", "more than 10000 cuts of one cycle"),
    ] {
        let told = refused(&format!("G18 F100\n{profile}G0 X8 Z1\n{cycle}\nM2"));
        assert!(told.contains(text), "{cycle}: {told}");
    }
    for (lines, text) in [
        ("G0 X4 Z0\nG1 X5 Z-5\nX6 Z-4\nX8", "goes back along the cuts"),
        ("G0 X4 Z0\nG1 Z-5 A2\nX5\nX8", "no room for"),
        ("G0 X4 Z0\nG1 Z-5\nX8 A1", "at the profile's end"),
        ("G0 X4 Z0", "a profile of one point"),
        ("M5", "a profile that moves nothing"),
        ("G0 X4 Z0\nG33 Z-5 K1", "another motion than G0 to G3"),
        ("G0 X4 Z0\no2 call\nG1 Z-5", "another subroutine inside a profile"),
        ("G0 X4 Z0\nG3 X4 Z-2 R-1.2\nG1 X8", "goes back along the cuts"),
    ] {
        let told =
            refused(&format!("G18 F100\no1 sub\n{lines}\no1 endsub\no2 sub\no2 endsub\nG0 X8 Z1\nG71 Q1 I1\nM2"));
        assert!(told.contains(text), "{lines}: {told}");
    }
    assert!(
        refused("G18 F100\no1 sub\nG0 X4 Z0\nG1 Z-5\nG2 X6 Z-7 R2\nG1 X8\no1 endsub\nG71 Q1 D3\nM2")
            .contains("narrower than the distance")
    );
}

#[test]
fn the_place_that_a_program_reads_is_a_radius_under_g7() {
    for x in ["#<_x>", "#5420", "#<_abs_x>"] {
        let source = format!("G18 G7 G0 X40\nG0 X{x}\nM2");
        assert_near(end(&run(&source)), [10.0, 0.0, 0.0], &source);
    }
}

#[test]
fn a_lathe_begins_in_radii_and_a_note_says_so() {
    for (dialect, source, x, is_noted) in [
        (Dialect::LinuxCnc, "G0 X80", 80.0, true),
        (Dialect::LinuxCnc, "G8 G0 X80", 80.0, false),
        (Dialect::LinuxCnc, "G7 G0 X80", 40.0, false),
        (Dialect::LinuxCnc, "G0 X0 Z5\nG7\nG0 X80", 40.0, false),
        (Dialect::LinuxCnc, "G91 G0 X80\nG7\nX20", 90.0, true),
        (Dialect::Grbl, "G0 X80", 80.0, false),
        (Dialect::Fanuc, "G0 X80.", 40.0, false),
        (Dialect::Haas, "G0 X80.", 40.0, false),
    ] {
        let program = support::run(&format!("{source}\nM30"), &Setup { dialect, ..Setup::lathe() });
        assert_eq!(end(&program)[0], x, "{dialect} {source}");
        let is_told = program.notes.iter().any(|note| note.line == 1 && note.text.contains("read as a radius"));
        assert_eq!(is_told, is_noted, "{dialect} {source}: {:?}", program.notes);
    }
    assert!(!run("G0 X80\nM2").notes.iter().any(|note| note.text.contains("radius")), "a mill has no diameters");
}

#[test]
fn a_length_before_g20_and_g21_is_noted_unless_the_setup_has_its_unit() {
    for dialect in Dialect::ALL {
        for (units, source, x, is_noted) in [
            (None, "G0 X2.", 2.0, true),
            (None, "G91 G0 X2.\nG20 X1.", 27.4, true),
            (None, "G20 G0 X2.", 50.8, false),
            (None, "G0 X0 A90.\nG21 X2.", 2.0, false),
            (Some(Units::Mm), "G0 X2.", 2.0, false),
            (Some(Units::Inch), "G0 X2.", 50.8, false),
            (Some(Units::Inch), "G21 G0 X2.", 2.0, false),
        ] {
            let program = support::run(&format!("{source}\nM30"), &Setup { dialect, units, ..Setup::default() });
            assert_near(end(&program), [x, 0.0, 0.0], source);
            let is_told = program.notes.iter().any(|note| note.line == 1 && note.text.contains("read as mm"));
            assert_eq!(is_told, is_noted, "{dialect} {units:?} {source}: {:?}", program.notes);
        }
    }
    // H of lathes is an angle: a step of C.
    let program = support::run("G0H90.\nM30", &Setup { dialect: Dialect::Fanuc, ..Setup::lathe() });
    assert!(!program.notes.iter().any(|note| note.text.contains("read as mm")), "{:?}", program.notes);
    assert_eq!(
        program.moves.iter().map(|step| step.end[Axis::C]).collect::<Vec<_>>(),
        [90_f64.to_radians()],
        "H alone is a move"
    );
    assert_eq!("inch".parse::<Units>(), Ok(Units::Inch));
    assert!("inches".parse::<Units>().unwrap_err().contains("mm, inch"));
}
