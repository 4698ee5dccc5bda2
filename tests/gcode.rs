//! The interpreter from outside: programs, the moves they mean, and the errors they deserve. All expectations are worked
//! out by hand beside the program.

use bvbench::gcode::{Axis, MoveKind, Plane, Program, Sampling, Setup, interpret, sample};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

fn run(source: &str) -> Program {
    interpret(source, Path::new("test.ngc"), &Setup::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// X, Y, Z of every end, mm.
fn ends(program: &Program) -> Vec<[f64; 3]> {
    program.moves.iter().map(|m| [m.end[Axis::X], m.end[Axis::Y], m.end[Axis::Z]]).collect()
}

fn assert_ends(source: &str, expected: &[[f64; 3]]) {
    let found = ends(&run(source));
    assert_eq!(found.len(), expected.len(), "{source}: {found:?}");
    for (f, e) in found.iter().zip(expected) {
        assert!(f.iter().zip(e).all(|(x, y)| (x - y).abs() < 1e-9), "{source}: {found:?}, expected {expected:?}");
    }
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
    let samples = sample(&program, &Setup::default().start, &sampling);
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
        &[
            [0.0, 0.0, 1.0],
            [0.0, 0.0, 2.0],
            [5.0, 0.0, 2.0],
            [5.0, 0.0, -1.0],
            [5.0, 0.0, 2.0],
            [7.0, 0.0, 2.0],
            [7.0, 0.0, -1.0],
            [7.0, 0.0, 2.0],
        ],
    );
    // From Z 10, back to it in G98, to R in G99.
    assert_ends(
        "G0 Z10\nG98 G81 Z-1 R2 F50\nG99 X1\nM2",
        &[
            [0.0, 0.0, 10.0],
            [0.0, 0.0, 10.0],
            [0.0, 0.0, 2.0],
            [0.0, 0.0, -1.0],
            [0.0, 0.0, 10.0],
            [1.0, 0.0, 10.0],
            [1.0, 0.0, 2.0],
            [1.0, 0.0, -1.0],
            [1.0, 0.0, 2.0],
        ],
    );
    // Incremental: R is 2 above the start at 0, the bottom 3 below R, twice, a step of 4 each.
    assert_ends(
        "G91 G81 X4 Z-3 R2 L2 F50\nM2",
        &[
            [0.0, 0.0, 2.0],
            [4.0, 0.0, 2.0],
            [4.0, 0.0, -1.0],
            [4.0, 0.0, 2.0],
            [8.0, 0.0, 2.0],
            [8.0, 0.0, -1.0],
            [8.0, 0.0, 2.0],
        ],
    );
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
fn under_tool_centre_point_control_moves_are_the_tips() {
    let tool = bvbench::gcode::Tool::with_length(90.0, 6.0);
    let other = bvbench::gcode::Tool::with_length(80.0, 6.0);
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
        ("G0 X1\nG42 D1\nM2", 2, 1, "not supported"),         // not performed
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
