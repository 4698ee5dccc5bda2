//! The interpreter from outside: programs, the moves they mean, and the errors they deserve. All expectations are worked
//! out by hand beside the program.

mod support;

use proptest::prelude::*;
use rs274::{Axis, Dialect, MoveKind, Plane, Program, RapidPath, Sampling, Setup, interpret, sample};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;
use support::{ends, points};

fn run(source: &str) -> Program {
    support::run(source, &Setup::default())
}

fn assert_ends(source: &str, expected: &[[f64; 3]]) {
    support::assert_ends(source, &Setup::default(), expected);
}

#[test]
fn control_characters_around_a_programs_lines_are_nothing() {
    for source in
        ["%\nG0 X1\nM2\n%\n\u{1a}", "\u{12}%\nG0 X1\nM2\n%\n\u{14}", "G0 X1\nM2\n%\n\u{14}", "\0\0%\nG0 X1\nM2\n%\n\0"]
    {
        for setup in [Setup::default(), Setup { dialect: Dialect::Haas, ..Setup::default() }] {
            support::assert_ends(source, &setup, &[[1.0, 0.0, 0.0]]);
        }
    }
    // Beside words they are errors.
    assert!(support::refused("G0 X1 \u{14} Y2\nM2", &Setup::default()).contains("unexpected character"));
}

#[test]
fn straight_moves_follow_units_and_distance_mode() {
    assert_ends("G21 G90 G0 X1 Y2 Z3\nG1 F100 X4\nM2", &[[1.0, 2.0, 3.0], [4.0, 2.0, 3.0]]);
    assert_ends("G21 G91 G0 X1\nX1\nG90 X1\nM2", &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    assert_ends("G20 G0 X1\nM2", &[[25.4, 0.0, 0.0]]);
    assert_ends("g0x1(a comment)y2 ; another\nm2", &[[1.0, 2.0, 0.0]]);
}

#[test]
fn each_move_knows_its_line_and_kind() {
    let program = run("(first line)\nG0 X1\n\nG1 F200 X2\nM2");
    let lines: Vec<u32> = program.moves.iter().map(|m| m.line).collect();
    assert_eq!(lines, [2, 4]);
    assert_eq!(program.moves[0].kind, MoveKind::Rapid);
    assert_eq!((program.moves[1].kind, program.moves[1].feed_mm_min), (MoveKind::Feed, Some(200.0)));
}

#[test]
fn a_quarter_circle_by_centre_and_by_radius_are_one_arc() {
    for arc in ["G3 X0 Y10 I-10 J0 F100", "G3 X0 Y10 R10 F100"] {
        let program = run(&format!("G0 X10 Y0\n{arc}\nM2"));
        let MoveKind::Arc { plane, centre, sweep } = program.moves[1].kind else { panic!("{arc} is no arc") };
        assert_eq!(plane, Plane::Xy);
        assert!(centre[0].abs() < 1e-9 && centre[1].abs() < 1e-9 && (sweep - FRAC_PI_2).abs() < 1e-9, "{arc}");
    }
    let clockwise = run("G0 X10 Y0\nG2 X0 Y10 I-10 J0 F100\nM2");
    let MoveKind::Arc { sweep, .. } = clockwise.moves[1].kind else { panic!("no arc") };
    assert!((sweep + 1.5 * PI).abs() < 1e-9); // three quarters the other way round
    let full = run("G0 X10 Y0\nG3 I-10 F100\nM2");
    let MoveKind::Arc { sweep, .. } = full.moves[1].kind else { panic!("no arc") };
    assert!((sweep - TAU).abs() < 1e-9);
}

#[test]
fn samples_of_an_arc_lie_on_it_and_end_where_it_ends() {
    let program = run("G0 X10 Y0\nG3 X-10 Y0 I-10 J0 Z4 F100\nM2");
    let sampling = Sampling { step_mm: 0.5, step_deg: 1.0, chord_mm: 0.01 };
    let samples = sample(&program, &Setup::default().start, &sampling, &RapidPath::Straight).unwrap();
    let on_arc: Vec<_> = samples.iter().filter(|s| s.line == 2).collect();
    assert!(on_arc.len() as f64 >= 10.0 * PI / 0.5);
    for s in &on_arc {
        let (x, y) = (s.position[Axis::X], s.position[Axis::Y]);
        assert!((x.hypot(y) - 10.0).abs() < 1e-9, "radius at ({x}, {y})");
        // A helix: height grows with the angle, 4 mm over half a turn.
        assert!((s.position[Axis::Z] - 4.0 * y.atan2(x).rem_euclid(TAU) / PI).abs() < 1e-6);
    }
    let last = on_arc.last().unwrap().position;
    assert!((last[Axis::X] + 10.0).abs() < 1e-9 && (last[Axis::Z] - 4.0).abs() < 1e-9);
}

#[test]
fn offsets_shift_the_program() {
    assert_ends("G92 X5\nG0 X5\nG92.1\nX5\nM2", &[[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
    assert_ends("G10 L2 P1 X100\nG54 G0 X1\nG53 G0 X1\nM2", &[[101.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
}

#[test]
fn parameters_expressions_and_loops_are_evaluated() {
    assert_ends("#1=3\n#<depth>=[#1*2]\nG0 X[#1+1] Y[SQRT[16]] Z#<depth>\nM2", &[[4.0, 4.0, 6.0]]);
    assert_ends("G0 X[SIN[30]*2] Y[2**3] Z[7 MOD 4]\nM2", &[[1.0, 8.0, 3.0]]);
    assert_ends(
        "#1=0\no1 while [#1 LT 3]\n#1=[#1+1]\nG0 X#1\no1 endwhile\nM2",
        &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
    );
    assert_ends("o<go> sub\nG0 X#1 Y#2\no<go> endsub\no<go> call [4] [5]\nM2", &[[4.0, 5.0, 0.0]]);
    assert_ends(
        "#1=2\no1 if [#1 EQ 1]\nG0 X1\no1 elseif [#1 EQ 2]\nG0 X2\no1 else\nG0 X3\no1 endif\nM2",
        &[[2.0, 0.0, 0.0]],
    );
    assert_ends("o1 repeat [2]\nG91 G0 X5\no1 endrepeat\nM2", &[[5.0, 0.0, 0.0], [10.0, 0.0, 0.0]]);
}

#[test]
fn a_drilling_cycle_rises_crosses_dives_and_returns() {
    // From Z 1 below R 2: up to 2, over to the hole, down to -1, up to the higher of R and the start: 2.
    assert_ends(
        "G0 Z1\nG81 X5 Z-1 R2 F50\nX7\nG80\nM2",
        &points("0 0 1, 0 0 2, 5 0 2, 5 0 -1, 5 0 2, 7 0 2, 7 0 -1, 7 0 2"),
    );
    // From Z 10, back to it in G98, to R in G99.
    assert_ends(
        "G0 Z10\nG98 G81 Z-1 R2 F50\nG99 X1\nM2",
        &points("0 0 10, 0 0 10, 0 0 2, 0 0 -1, 0 0 10, 1 0 10, 1 0 2, 1 0 -1, 1 0 2"),
    );
    // Incremental: R is 2 above the start at 0, the bottom 3 below R, twice, a step of 4 each.
    assert_ends("G91 G81 X4 Z-3 R2 L2 F50\nM2", &points("0 0 2, 4 0 2, 4 0 -1, 4 0 2, 8 0 2, 8 0 -1, 8 0 2"));
}

#[test]
fn pecks_clear_or_break_the_chip() {
    let depths = |source: &str| ends(&run(source)).into_iter().map(|end| end[2]).collect::<Vec<_>>();
    // Q 2 from R 1 to -4: at -1 and -3, then the bottom. G83 goes out to R each time and comes back to 0.254 above.
    let found = depths("G0 Z1\nG83 Z-4 R1 Q2 F50\nM2");
    let expected = [1.0, 1.0, -1.0, 1.0, -0.746, -3.0, 1.0, -2.746, -4.0, 1.0];
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9),
        "{found:?}"
    );
    let found = depths("G0 Z1\nG73 Z-4 R1 Q2 F50\nM2");
    let expected = [1.0, 1.0, -1.0, -0.746, -3.0, -2.746, -4.0, 1.0];
    assert!(
        found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9),
        "{found:?}"
    );
}

#[test]
fn cycles_dwell_and_draw_out_as_their_codes_say() {
    let kinds = |source: &str| run(source).moves.iter().skip(2).map(|step| step.kind).collect::<Vec<_>>();
    let (rapid, feed, dwell) = (MoveKind::Rapid, MoveKind::Feed, MoveKind::Dwell { seconds: 0.5 });
    assert_eq!(kinds("G0 Z1\nG82 Z-1 R1 P0.5 F50\nM2"), [feed, dwell, rapid]);
    assert_eq!(kinds("G0 Z1\nG85 Z-1 R1 F50\nM2"), [feed, feed]);
    assert_eq!(kinds("G0 Z1\nG89 Z-1 R1 P0.5 F50\nM2"), [feed, dwell, feed]);
}

#[test]
fn cycles_drill_along_the_normal_of_the_plane() {
    assert_ends("G18 G81 X3 Z4 Y-2 R1 F50\nM2", &[[0.0, 1.0, 0.0], [3.0, 1.0, 4.0], [3.0, -2.0, 4.0], [3.0, 1.0, 4.0]]);
}

#[test]
fn a_thread_is_cut_in_passes_of_falling_depth() {
    // Outside thread: peak 1 below the drive line at X 20, 0.9 deep, first cut 0.3: passes at 0.3, 0.6, 0.9.
    let program = run("G18 G8 G97 S100 M3\nG0 X20 Z5\nG76 P1.5 Z-10 I-1 J0.3 K0.9\nM2");
    let cuts: Vec<f64> =
        program.moves.iter().filter(|step| step.kind == MoveKind::Feed).map(|step| step.end[Axis::X]).collect();
    let expected = [20.0 - 1.3, 20.0 - 1.6, 20.0 - 1.9];
    assert!(cuts.len() == 3 && cuts.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{cuts:?}");
    let last = program.moves.last().unwrap();
    assert_eq!((last.end[Axis::X], last.end[Axis::Z], last.kind), (20.0, -10.0, MoveKind::Rapid));
    // With degression 2 the n-th pass is 0.3 √n deep: 0.3, 0.424, ..., 0.849 (n = 8), then 0.9.
    let program = run("G18 G8 G97 S100 M3\nG0 X20 Z5\nG76 P1.5 Z-10 I-1 J0.3 K0.9 R2 H1\nM2");
    assert_eq!(program.moves.iter().filter(|step| step.kind == MoveKind::Feed).count(), 10); // 8, the last, a spring pass
    let feed = program.moves.iter().find(|step| step.kind == MoveKind::Feed).unwrap();
    assert_eq!(feed.feed_mm_min, Some(150.0)); // 1.5 mm at 100 turns a minute
}

#[test]
fn boring_from_behind_goes_in_beside_the_hole() {
    // NISTIR 6556, 3.5.16.7: aside, down, in; up to K and back; aside, up, back to the middle.
    let source = "M3 S100\nG0 Z5\nG99 G87 X1 Y1 Z-3 R2 I0.5 J0 K-1 F50\nM2";
    assert_ends(
        source,
        &points("0 0 5, 1 1 5, 1 1 2, 1.5 1 2, 1.5 1 -3, 1 1 -3, 1 1 -1, 1 1 -3, 1.5 1 -3, 1.5 1 2, 1 1 2"),
    );
    let turning: Vec<f64> = run(source).moves[3..].iter().map(|step| step.spindle_rpm).collect();
    assert_eq!(turning, [100.0, 0.0, 0.0, 100.0, 100.0, 0.0, 0.0, 0.0]);
}

#[test]
fn a_tap_turns_back_to_come_out() {
    let program = run("G0 Z1\nM3 S200\nG84 Z-1 R1 F50\nG33.1 Z0 K0.5\nM2");
    let told: Vec<_> = program.moves[1..].iter().map(|m| (m.end[Axis::Z], m.spindle_rpm, m.feed_mm_min)).collect();
    let (cycle, tap) = (Some(50.0), Some(100.0)); // half a millimetre a turn, 200 turns a minute
    assert_eq!(
        told,
        [(1.0, 200.0, None), (-1.0, 200.0, cycle), (1.0, -200.0, cycle), (0.0, 200.0, tap), (1.0, 200.0, tap)]
    );
}

#[test]
fn splines_are_chords_near_enough() {
    // The parabola with control point (10, 10): at x it is x (20 - x) / 20 high.
    let program = run("G5.1 X20 Y0 I10 J10 F100\nM2");
    assert!(program.moves.len() > 30 && program.moves.iter().all(|step| step.kind == MoveKind::Feed));
    for end in ends(&program) {
        assert!((end[1] - end[0] * (20.0 - end[0]) / 20.0).abs() < 1e-9, "{end:?}");
    }
    assert_eq!(ends(&program).last(), Some(&[20.0, 0.0, 0.0]));
    // A cubic, and one that continues it: its first control point mirrors the last, so that no corner is between them.
    let program = run("G5 X20 Y0 I5 J10 P-5 Q10 F100\nG5 X40 Y0 P-5 Q-10\nM2");
    let places = ends(&program);
    let middle = places.iter().position(|end| end[0] == 20.0).unwrap();
    let direction = |a: [f64; 3], b: [f64; 3]| (b[1] - a[1]).atan2(b[0] - a[0]);
    let turned = direction(places[middle - 1], places[middle]) - direction(places[middle], places[middle + 1]);
    assert!(turned.abs() < 0.1, "{turned}");
}

#[test]
fn feeds_per_revolution_follow_the_spindle() {
    let feeds = |source: &str| run(source).moves.iter().filter_map(|step| step.feed_mm_min).collect::<Vec<_>>();
    assert_eq!(feeds("G95 S500 G1 X10 F0.2\nM2"), [100.0]);
    // 100 m/min at diameter 40: 1e5 / (40 pi) turns a minute, 0.2 mm each.
    let rate = |diameter: f64| 0.2 * 1e5 / (diameter * PI);
    let near = |found: &[f64], expected: &[f64]| {
        let same = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(same, "{found:?} is not {expected:?}");
    };
    near(&feeds("G18 G8 G0 X20 Z0\nG96 S100 M3\nG95 G1 Z-10 F0.2\nM2"), &[rate(40.0)]);
    // Facing from 40 to 20: as long as at the mean diameter. With D 1000 that is the limit: 200 mm/min.
    near(&feeds("G18 G8 G0 X20 Z0\nG96 S100 M3\nG95 G1 X10 F0.2\nM2"), &[rate(30.0)]);
    near(&feeds("G18 G8 G0 X10 Z0\nG96 S100 D1000 M3\nG95 G1 X5 F0.2\nM2"), &[200.0]);
    let program = run("G18 G8 G0 X20 Z0\nG96 S100 M4\nG95 G1 Z-10 F0.2\nM2");
    near(&[program.moves[1].spindle_rpm], &[-1e5 / (40.0 * PI)]);
    // Degrees a minute are the same in inches.
    assert_eq!(feeds("G20\nG1 A90 F100\nX1\nM2"), [100.0, 2540.0]);
}

#[test]
fn tool_offsets_are_set_from_where_the_tool_is() {
    // G10 L10: with the offset 10 - 5 the place at 10 reads 5; L11 counts from G59.3, 3 higher, and not from G92.
    assert_ends("T1 M61 Q1\nG0 Z10\nG10 L10 P1 Z5\nG43\nG0 Z1\nM2", &[[0.0; 3], [0.0, 0.0, 10.0], [0.0, 0.0, 6.0]]);
    assert_ends(
        "M61 Q1\nG10 L2 P9 Z3\nG0 Z10\nG92 Z7\nG10 L11 P1 Z5\nG43 G92.1\nG0 Z1\nM2",
        &[[0.0; 3], [0.0, 0.0, 10.0], [0.0, 0.0, 3.0]],
    );
    // Another tool is in the spindle from there on.
    let kinds: Vec<MoveKind> = run("M61 Q1\nM61 Q1\nG0 Z10\nM61 Q0\nM2").moves.iter().map(|step| step.kind).collect();
    assert_eq!(kinds, [MoveKind::ToolChange { tool: 1 }, MoveKind::Rapid, MoveKind::ToolChange { tool: 0 }]);
}

#[test]
fn an_oriented_spindle_stands() {
    let speeds: Vec<f64> = run("M3 S1000 G1 X1 F100\nM19\nX2\nM2").moves.iter().map(|step| step.spindle_rpm).collect();
    assert_eq!(speeds, [1000.0, 0.0]);
}

#[test]
fn programs_may_ask_what_is_in_force() {
    let asked = |before: &str, name: &str| ends(&run(&format!("{before}\nG0 X#<{name}>\nM2")))[0][0];
    for (before, name, expected) in [
        ("", "_retract_r_plane", 1.0),
        ("G98", "_retract_old_z", 1.0),
        ("M4 S1", "_spindle_on", 1.0),
        ("M4 S1", "_spindle_cw", 0.0),
        ("G96 S1", "_spindle_css_mode", 1.0),
        ("M7", "_mist", 1.0),
        ("M8", "_flood", 1.0),
        ("M49", "_feed_override", 0.0),
        ("M51 P0", "_speed_override", 0.0),
        ("M52", "_adaptive_feed", 1.0),
        ("G90.1", "_ijk_absolute_mode", 1.0),
        ("G41.1 D0", "_ccomp", 411.0),
        ("G43.1 Z1", "_tool_offset", 1.0),
        ("F250", "_feed", 250.0),
    ] {
        let program = format!("{before}\nG40 G49");
        let found =
            if name.starts_with("_c") || name.starts_with("_t") { asked(before, name) } else { asked(&program, name) };
        assert_eq!(found, expected, "{name} after {before}");
    }
}

#[test]
fn parameters_set_beforehand_hold_offsets() {
    let parameters = [("5221", 100.0), ("5241", 5.0), ("5210", 1.0), ("5211", 2.0), ("31", 7.0), ("5220", 2.0)];
    let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).into();
    let setup = Setup { parameters, ..Setup::default() };
    let program = interpret("G0 X#31\nG54\nX0\nG92.1\nX0\nM2", Path::new("var.ngc"), &setup).unwrap();
    // G55 and G92 are in force at first: 7 + 5 + 2; then G54: 100 + 2; then without G92.
    assert_eq!(ends(&program).iter().map(|end| end[0]).collect::<Vec<_>>(), [14.0, 102.0, 100.0]);
}

#[test]
fn codes_of_one_modal_group_exclude_each_other() {
    for (source, column) in [
        ("M8 M9", 4),
        ("M7 M8", 4),
        ("M3 M4", 4),
        ("M48 M50", 5),
        ("G17 G18", 5),
        ("G53 G4 P1", 5),
        ("G40 G41", 5),
        ("M70 M72", 5),
    ] {
        let error = interpret(source, Path::new("x.ngc"), &Setup::default()).unwrap_err();
        assert!(error.column == column && error.to_string().contains("modal group"), "{source}: {error}");
    }
}

#[test]
fn a_program_without_end_is_given_up_with_its_line() {
    use rs274::Limits;
    let setup = Setup { limits: Limits { moves: 1000, blocks: 10_000 }, ..Setup::default() };
    for (source, what) in [
        ("G91\no1 while [1]\nG0 X1\no1 endwhile\nM2", "1000 moves"),
        ("G91\no1 while [1]\n#1=[#1+1]\no1 endwhile\nM2", "10000 blocks"),
        ("G91\n\nG81 X1 Z-1 R1 L5000 F1\nM2", "1000 moves"),
    ] {
        let error = interpret(source, Path::new("x.ngc"), &setup).unwrap_err();
        assert!((2..=4).contains(&error.line) && error.to_string().contains(what), "{error}");
    }
    let far = interpret("G0 X1\nG0 X99999999999\nM2", Path::new("x.ngc"), &Setup::default()).unwrap_err();
    assert_eq!((far.line, far.text.as_str()), (2, "X"));
}

#[test]
fn under_tool_centre_point_control_moves_are_the_tips() {
    let tool = rs274::Tool::with_length(90.0, 6.0);
    let other = rs274::Tool::with_length(80.0, 6.0);
    let setup = Setup { tools: [(1, tool), (2, other)].into(), ..Setup::default() };
    let run = |source: &str| interpret(source, Path::new("tip.ngc"), &setup);
    let program = run("T1 M6\nG0 Z200\nG43.4 H1\nG1 X5 Z50 A-30 F100\nG0 A0\nG49\nG0 Z150\nM2").unwrap();
    let told: Vec<_> = program.moves.iter().map(|m| (m.line, m.end[Axis::Z], m.tip_mm)).collect();
    // The tool change; the axis at 200; the tip 90 below it; the tip at 50 on the workpiece; and back to the axis: 50 + 90.
    let tip = Some(90.0);
    assert_eq!(
        told,
        [
            (1, 0.0, None),
            (2, 200.0, None),
            (3, 110.0, tip),
            (4, 50.0, tip),
            (5, 50.0, tip),
            (6, 140.0, None),
            (7, 150.0, None)
        ]
    );
    let error = run("T1 M6\nG43.4 H1\nG1 A-30 F100\nG49\nM2").unwrap_err();
    assert_eq!((error.line, error.column), (4, 1), "{error}");
    let error = run("T1 M6\nG43.4 H1\nG43 H2\nM2").unwrap_err();
    assert_eq!(error.line, 3, "{error}");
    // The same length again is none but the same, and a whole turn is no turn.
    let program = run("T1 M6\nG0 Z200\nG43.4 H1\nG43 H1\nG0 C-720\nG49\nM2").unwrap();
    assert_eq!(program.moves.last().map(|m| (m.end[Axis::Z], m.tip_mm)), Some((200.0, None)));
}

#[test]
fn polar_words_stand_for_x_and_y() {
    assert_ends("G0 @2 ^90\n^180\nG91 @1\nM2", &[[0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], [-3.0, 0.0, 0.0]]);
}

#[test]
fn kept_modes_come_back() {
    assert_ends("G21\nM70\nG20 G0 X1\nM72\nG0 X1\nM2", &[[25.4, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    assert_ends(
        "o<in> sub\nM73\nG91 G0 X5\no<in> endsub\nG0 X1\no<in> call\nG0 X1\nM2",
        &[[1.0, 0.0, 0.0], [6.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
    );
}

#[test]
fn a_subroutine_may_stand_in_a_file_beside_the_program() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("hole.ngc"), "; a hole\no<hole> sub\nG1 Z#1 F10\nG0 Z0\no<hole> endsub\n")
        .unwrap();
    let main = folder.path().join("main.ngc");
    let program = interpret("G0 X1\no<hole> call [-3]\nM2", &main, &Setup::default()).unwrap();
    assert_eq!(ends(&program), [[1.0, 0.0, 0.0], [1.0, 0.0, -3.0], [1.0, 0.0, 0.0]]);
    // Its moves are told by the line that calls it; what is wrong with it, by its own file and line.
    assert_eq!(program.moves.iter().map(|step| step.line).collect::<Vec<_>>(), [1, 2, 2]);
    std::fs::write(folder.path().join("hole.ngc"), "o<hole> sub\nG1 Z#1 F10\nG999\no<hole> endsub\n").unwrap();
    let error = interpret("G0 X1\no<hole> call [-3]\nM2", &main, &Setup::default()).unwrap_err();
    assert!(error.file.ends_with("hole.ngc") && (error.line, error.column) == (3, 1), "{error}");
}

#[test]
fn ten_programs_that_must_fail_fail_at_their_line() {
    for (source, line, column, text) in [
        ("G0 Z1\nG81 X1 Z-1 F50\nM2", 2, 1, "R"),             // no retract height
        ("G0 Z1\nG83 Z-4 R1 F50\nM2", 2, 1, "Q"),             // no peck
        ("G0 Z1\nG83 Z-4 R1 Q0 F50\nM2", 2, 12, "Q"),         // a peck that gets nowhere
        ("G0 Z1\nG82 Z-4 R1 F50\nM2", 2, 1, "P"),             // no dwell
        ("G93 G81 Z-1 R1 F50\nM2", 1, 5, "G93"),              // a cycle in inverse time
        ("G0 Z1\nG81 Z5 R1 F50\nM2", 2, 1, "bottom"),         // R below the bottom
        ("G17 M3 S1\nG76 P1 Z-1 I-1 J1 K1\nM2", 2, 1, "G18"), // a thread in the wrong plane
        ("G18\nG0 X5\nG33 Z-5 K1\nM2", 3, 1, "spindle"),      // a thread without a spindle
        ("G0 X1\nG42 D1\nM2", 2, 5, "tool table"),            // no such tool
        ("G0 X1\no<gone> call\nM2", 2, 1, "not defined"),     // no such subroutine
    ] {
        let error = interpret(source, Path::new("bad.ngc"), &Setup::default()).unwrap_err();
        assert_eq!((error.line, error.column), (line, column), "{source}: {error}");
        assert!(error.to_string().contains(text), "{source}: {error}");
    }
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    for (source, line, text) in [
        ("G0 X1\nG1 X2\nM2", 2, "feed"),
        ("G0 X1\n\nG0 X\nM2", 3, ""),
        ("G0 G1 X1 F1\nM2", 1, "G1"),
        ("G0 X1\nG999\nM2", 2, "G999"),
        ("G0 X10\nG3 X0 Y10 I-3 F100\nM2", 2, "radi"),
        ("G0 X[1/0]\nM2", 1, ""),
        ("G0 X#<nothing>\nM2", 1, "nothing"),
        ("o1 while [1]\nM2", 1, ""),
        ("G0 Q1 X1 X2\nM2", 1, "X"),
    ] {
        let error = interpret(source, Path::new("bad.ngc"), &Setup::default()).map(|p| ends(&p)).unwrap_err();
        let message = error.to_string();
        assert!(message.starts_with(&format!("bad.ngc:{line}:")), "{source}: {message}");
        assert!(message.to_lowercase().contains(&text.to_lowercase()), "{source}: {message}");
    }
}

#[test]
fn a_pitch_of_nothing_is_no_thread() {
    for pitch in ["0", "0.00000000000000000001", "-0.000000001"] {
        let source = format!("G18 M3 S100\nG33 Z-10 K{pitch}\nM2");
        let error = interpret(&source, Path::new("bad.ngc"), &Setup::lathe()).unwrap_err();
        assert_eq!((error.line, error.column), (2, 10), "{error}");
        assert!(error.to_string().contains("K, the pitch, must be at least 1e-6 mm"), "{error}");
    }
    assert!(interpret("G18 M3 S100\nG33 Z-10 K0.000001\nM2", Path::new("good.ngc"), &Setup::lathe()).is_ok());
}

#[test]
fn a_carriage_return_alone_ends_a_line() {
    let program = interpret("G0 X1\rG0 X2\rM2\r", Path::new("mac.ngc"), &Setup::default()).unwrap();
    assert_eq!(ends(&program), [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    assert_eq!(program.moves.iter().map(|step| step.line).collect::<Vec<_>>(), [1, 2]);
    let error = interpret("G0 X1\rG0 !\r", Path::new("mac.ngc"), &Setup::default()).unwrap_err();
    assert_eq!((error.line, error.column), (2, 4));
}

#[test]
fn a_subroutine_that_cannot_be_read_is_not_called_undefined() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("hole.ngc")).unwrap();
    let main = folder.path().join("main.ngc");
    let error = interpret("o<hole> call\nM2", &main, &Setup::default()).unwrap_err();
    assert!(error.file.ends_with("hole.ngc"), "{error}");
    assert!(error.to_string().ends_with("the file cannot be read: it is a folder, not a regular file"), "{error}");
}

#[test]
fn lines_have_a_limit_that_the_message_names() {
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("main.ngc");
    let long = "\n".repeat(2_000_001);
    let error = interpret(&long, &main, &Setup::default()).unwrap_err();
    assert!(error.file == main && error.line == 2_000_001, "{error}");
    assert!(error.to_string().contains("more than 2000000 lines"), "{error}");
    std::fs::write(folder.path().join("hole.ngc"), long).unwrap();
    let error = interpret("o<hole> call\nM2", &main, &Setup::default()).unwrap_err();
    assert!(error.file.ends_with("hole.ngc") && error.to_string().contains("more than 2000000 lines"), "{error}");
}

#[test]
fn an_endless_program_ends_in_an_error() {
    let error = interpret("o1 while [1 EQ 1]\n#1=1\no1 endwhile\nM2", Path::new("x.ngc"), &Setup::default());
    assert!(error.is_err());
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "[GMXYZIJFRPLOo0-9#<>\\[\\]=+*/. \n-]{0,80}") {
        let _ = interpret(&text, Path::new("random.ngc"), &Setup::default());
    }
}

#[test]
fn a_byte_order_mark_is_no_part_of_a_program() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("side.ngc"), "\u{feff}o<side> sub\nG0 X2\no<side> endsub\n").unwrap();
    let main = folder.path().join("main.ngc");
    let program = interpret("\u{feff}G0 X1\no<side> call\nM2", &main, &Setup::default()).unwrap();
    assert_eq!(ends(&program), [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    assert_eq!(program.blocks[0], "G0 X1");
    let error = interpret("\u{feff}G0 !\nM2", &main, &Setup::default()).unwrap_err();
    assert_eq!((error.line, error.column), (1, 4));
}

#[test]
fn control_flow_of_fanucs_macro_language_is_named() {
    for (line, column, word) in [
        ("if [#1 eq 1] goto 100", 1, "if ["),
        ("N10 IF[#1EQ1]THEN#2=3", 5, "IF["),
        ("GOTO 100", 1, "GOTO"),
        ("WHILE [#1 LT 3] DO1", 1, "WHILE"),
        ("END1", 1, "END"),
    ] {
        let source = format!("#1=1\n{line}\nM2");
        let error = interpret(&source, Path::new("fanuc.ngc"), &Setup::default()).unwrap_err();
        assert_eq!((error.line, error.column, error.text.as_str()), (2, column, word), "{error}");
        assert!(error.to_string().contains("Fanuc") && error.to_string().contains("O-words"), "{error}");
    }
    // A word whose value is a function's.
    assert_ends("G2 X2 Y0 I FIX[1.5] J0 F100\nM2", &[[2.0, 0.0, 0.0]]);
}
