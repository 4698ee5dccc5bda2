//! Programs for Grbl and other hobby controllers.

use rs274::{Axis, Dialect, MoveKind, Plane, Program, Setup, interpret};
use std::path::Path;

fn run(source: &str, dialect: Dialect) -> Result<Program, String> {
    interpret(source, Path::new("part.gcode"), &Setup { dialect, ..Setup::default() })
        .map_err(|error| error.to_string())
}

#[test]
fn lines_for_the_control_itself_are_skipped_with_a_note() {
    let source = "$$\n?  ; state\n$100=250.5\nG21 X5\nG1 X6 F100\n$G\nG2 X8 I1\nM2";
    let program = run(source, Dialect::Grbl).unwrap();
    // The first move is a rapid one: Grbl begins in G0.
    let told: Vec<(bool, f64)> = program.moves.iter().map(|m| (m.kind == MoveKind::Rapid, m.end[Axis::X])).collect();
    assert_eq!(told, [(true, 5.0), (false, 6.0), (false, 8.0)]);
    let notes: Vec<String> = program.notes.iter().map(ToString::to_string).collect();
    assert_eq!(notes, ["line 1: a line for the control itself (`$`, `?`, `!`, `~`) is skipped (and 3 times more)"]);
    assert!(run(source, Dialect::LinuxCnc).is_err());
}

#[test]
fn behind_m2_and_m30_the_next_program_runs() {
    // The second program has none of the first one's modes, but its units.
    for end in ["M2", "M30"] {
        let first = "G10 L2 P2 X100\nG55 G20 G91 G18 G93 F1 S500 M3\nG0 X1";
        let source = format!("{first}\n{end}\n(next)\nX2 F10\nG2 X3 Y1 J1\n{end}");
        let moves = run(&source, Dialect::Grbl).unwrap().moves;
        let told: Vec<_> =
            moves.iter().map(|m| ((m.end[Axis::X] / 25.4).round(), m.spindle_rpm, m.feed_mm_min)).collect();
        assert_eq!(told, [(1.0, 500.0, None), (2.0, 0.0, Some(254.0)), (3.0, 0.0, Some(254.0))], "{end}");
        assert!(matches!(moves[2].kind, MoveKind::Arc { plane: Plane::Xy, .. }));
        assert_eq!(run(&source, Dialect::LinuxCnc).unwrap().moves.len(), 1);
    }
}

#[test]
fn commands_that_move_the_machine_are_refused() {
    for command in ["$H", "$HX", "$J=X10 F100", "$ j = G91 X1 F10", "$SLP", "$RST=#"] {
        let told = run(&format!("G0 X1\n{command}\nM2"), Dialect::Grbl).unwrap_err();
        assert!(told.starts_with("part.gcode:2:1: not allowed: a command to the control"), "{command}: {told}");
    }
}

#[test]
fn a_comment_inside_a_comment_is_noted() {
    let source = "G0 X1 (7 depth cut(s) at 0.3 mm) Y2\nM2";
    let program = run(source, Dialect::Grbl).unwrap();
    assert_eq!(program.moves[0].end.0[..2], [1.0, 2.0]);
    assert!(program.notes[0].text.contains("Grbl ends comments at the first `)`"), "{:?}", program.notes);
    for (source, dialect, text) in [
        (source, Dialect::LinuxCnc, "comment inside a comment"),
        (source, Dialect::Fanuc, "comment inside a comment"),
        ("G0 X1 (a (b)\nM2", Dialect::Grbl, "comment is not closed"),
    ] {
        let told = run(source, dialect).unwrap_err();
        assert!(told.contains(text), "{told}");
    }
}
