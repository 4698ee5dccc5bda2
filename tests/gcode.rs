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
