//! What is told of programs that are wrong, or written for another control, and of codes that are skipped.

use rs274::{CodeName, Dialect, GcodeError, MoveKind, Setup, interpret};
use std::path::Path;

fn error_of(source: &str) -> GcodeError {
    interpret(source, Path::new("bad.ngc"), &Setup::default()).expect_err("the program is wrong")
}

#[test]
fn all_errors_that_stand_alone_are_told_at_once() {
    let error = error_of("G0 X1\nG77\nM31\nG1 Y2 !\nM31\nG43 H5\nM31\nX1 X2\nG77\nM2\nG78");
    let told: Vec<String> = error.to_string().lines().map(str::to_owned).collect();
    assert_eq!(
        told,
        [
            "bad.ngc:2:1: code is not supported; if it moves nothing, ignore it (`--ignore G77`): `G77` (and on another line)",
            "bad.ngc:3:1: code is not supported; if it moves nothing, ignore it (`--ignore M31`): `M31` (and on 2 more lines)",
            "bad.ngc:4:7: unexpected character: `!`",
            "bad.ngc:6:5: tool is not in the tool table (`--tool-table`, or `[[program.tools]]` of a scene): `H5`",
            "bad.ngc:8:4: word given twice in one block: `X2`",
        ]
    );
    // What may follow from the first error is not told: without G1 the arc has another start.
    let error = error_of("G1 X10\nG2 X0 Y0 I-5 F100\nM2");
    assert!(error.others().is_empty() && error.to_string().contains("feed rate"), "{error}");
}

#[test]
fn a_line_that_cannot_be_read_is_not_missing_elsewhere() {
    for (dialect, source, lines) in [
        (Dialect::LinuxCnc, "o1 if [atan[1] gt 0]\nG0 X1\no1 else\nG0 X2\no1 endif\nM2", &[1][..]),
        (Dialect::LinuxCnc, "O1 WHILE [#1 LT 1\nG0 X1\nO1 ENDWHILE\nM2", &[1]),
        (Dialect::LinuxCnc, "o1 if [1]\nG0 X1\no1 endif !\nM2", &[3]),
        (Dialect::Fanuc, "WHILE[#1LT3]DO1!\nEND1\nM30", &[1]),
        (Dialect::Fanuc, "DO1\nEND1!\nM30", &[2]),
        // What has no such word hides none.
        (Dialect::LinuxCnc, "G0 X1 !\no1 endif\nM2", &[2, 1]),
    ] {
        let setup = Setup { dialect, ..Setup::default() };
        let error = interpret(source, Path::new("bad.nc"), &setup).expect_err(source);
        let told: Vec<u32> = std::iter::once(&error).chain(error.others()).map(|error| error.line).collect();
        assert_eq!(told, lines, "{error}");
    }
}

#[test]
fn the_number_of_errors_has_a_bound() {
    let source: String = (0..5000).map(|i| format!("M{}\n", 200 + i % 700)).collect();
    let error = error_of(&source);
    assert_eq!(error.others().len(), 19);
    // An error in an endless loop is told once, and the loop ends at its limit.
    let error = error_of("o1 while [1 EQ 1]\nM31\no1 endwhile\nM2");
    assert_eq!((error.line, error.more, error.others().len()), (2, 0, 0), "{error}");
}

#[test]
fn a_code_is_ignored_with_a_note() {
    let ignored = ["G187", "M31", "G5.1"].map(|name| name.parse::<CodeName>().unwrap()).into();
    let setup = Setup { ignored, ..Setup::default() };
    let run = |source: &str| interpret(source, Path::new("part.nc"), &setup);
    let program = run("G187 P3 E0.01\nM31\nG21 G0 X1 M31\nG5.1 Q1\nX2 M31\nG5.1 X50 Q1\nM2").unwrap();
    let ends: Vec<f64> = program.moves.iter().map(|step| step.end.0[0]).collect();
    assert_eq!(ends, [1.0, 2.0]);
    let notes: Vec<String> = program.notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "line 1: G187 is ignored, as asked",
            "line 2: M31 is ignored, as asked (and 2 times more)",
            "line 4: G5.1 is ignored, as asked (and once more)"
        ]
    );
    assert_eq!(program.moves[0].kind, MoveKind::Rapid);
    // Words that no other code uses go with an M code, axes do not.
    assert!(run("M31 P1\nM2").is_ok());
    assert!(run("M31 X1\nM2").is_err());
}

#[test]
fn programs_for_other_controls_are_recognised() {
    let heidenhain =
        error_of("0  BEGIN PGM PART MM\n1  BLK FORM 0.1 Z X+0 Y+0 Z-20\n2  TOOL CALL 1 Z S2000\n3  L X+10 Y+0 R0 FMAX");
    let told = heidenhain.to_string();
    assert!(told.starts_with("bad.ngc:1:1:") && told.contains("Heidenhain") && told.contains("TOOL CALL"), "{told}");
    assert!(told.contains("post it for LinuxCNC, Fanuc or Haas") && heidenhain.others().is_empty());
    let siemens = error_of("N10 G54 G0 X0\nN20 TRAORI\nN30 CYCLE832(0.01,_FINISH,1)\nN40 R1=5\nN50 M30");
    assert!(siemens.line == 2 && siemens.to_string().contains("SINUMERIK"), "{siemens}");
    let one = error_of("N40 R12=5\nN50 M30");
    assert!(one.line == 1 && one.to_string().contains("SINUMERIK"), "{one}");
    for (source, dialect) in [
        ("O1000\nIF[#1EQ1]GOTO10\nN10 M30", Dialect::Fanuc),
        ("G50 S2000\nM30", Dialect::Fanuc),
        ("WHILE[#1LT1]DO1\nEND1", Dialect::Fanuc),
        ("G187 P1\nM30", Dialect::Haas),
        // What a post for Haas writes behind drilling; only the number tells.
        ("%\nO0001 (VISE PART)\nG90 G21\nG0 X0 Y0 Z15.\nG80\nZ15.\nM30\n%", Dialect::Fanuc),
        ("%\nO0001 (VISE PART)\nG90 G21\nG0 X0 Y0 Z15.\nG80\nZ15.\nM30\n%", Dialect::Haas),
    ] {
        let error = error_of(source);
        let hint = error.hint().unwrap_or_default().to_owned();
        assert!(hint.contains(&format!("--dialect {dialect}")), "{source}: {error}");
        assert!(error.to_string().ends_with(&hint), "{error}");
    }
    // A program of LinuxCNC's with an error has no hint.
    assert_eq!(error_of("G0 X1\nM31\nM2").hint(), None);
    assert_eq!(
        error_of("o1 while [#1 LT 1]\n#1=1\no<two> if [#1 EQ 1]\nM31\no<two> endif\no1 endwhile\nM2").hint(),
        None
    );
}

#[test]
fn a_program_that_runs_and_looks_like_another_controls_is_noted_where_no_dialect_is_named() {
    let noted = |source: &str, dialect_is_assumed: bool| {
        let setup = Setup { dialect_is_assumed, ..Setup::default() };
        let notes = interpret(source, Path::new("part.nc"), &setup).expect(source).notes;
        let is_it = |note: &&rs274::Note| note.text.contains("no dialect is named");
        notes.iter().find(is_it).map(|note| (note.line, note.is_unknown, note.text.clone()))
    };
    let both = "`--dialect fanuc` or `--dialect haas`";
    for (source, line, sign, advice) in [
        ("%\nO01002 (FLIP CHIPS)\nG21 G0 X1\nM0\nG0 X2\nM30\n%", 2, "(O01002)", both),
        (
            "%\nO01002 (HAAS VF-2)\nG21 G0 X1\nM30\n%",
            2,
            "(HAAS, O01002)",
            "LinuxCNC's, since no dialect is named: `--dialect haas`",
        ),
        ("G21\nM98 P2\nM2\nO2\nG0 X1\nM99", 2, "(M98P, O2)", both),
        ("G21 G90\nG28 U0 W0\nM2", 2, "(G28U0)", both),
    ] {
        let (at, is_unknown, text) = noted(source, true).expect(source);
        assert!(at == line && is_unknown && text.contains(sign) && text.contains(advice), "{source}: {at} {text}");
        assert_eq!(noted(source, false), None, "{source}");
    }
    for source in [
        "G21 G0 X1\nM2",
        "%\nG21 G0 X1\nM2\n%",
        "G21\no100 sub\nG0 X1\no100 endsub\no100 call\nM2",
        "G21\nO100 if [1 EQ 1] (inner)\nG0 X1\nO100 endif\nM2",
        "G21\n/o100 if [1 EQ 1]\nG0 X1\n/o100 endif\nM2",
        "G21\n#3=1\no<goto> while [#3 GT 0]\n#3=0\no<goto> endwhile\nM2",
        "G21 (a part for O1000)\nG0 X1 ; G65\nM2",
    ] {
        assert_eq!(noted(source, true), None, "{source}");
    }
    // LinuxCNC's thread of a pitch below 1 mm, and Fanuc's P of six digits.
    let thread = |p: &str| {
        let setup = Setup { dialect_is_assumed: true, ..Setup::lathe() };
        let source = format!("G21 G8 S100 M3\nG0 Z-.5 X.2\nG76 P{p} Z-1 I-.075 J.008 K.045 Q29.5 L2 E.045\nM2");
        let notes = interpret(&source, Path::new("part.ngc"), &setup).expect(&source).notes;
        notes.iter().any(|note| note.text.contains("no dialect is named"))
    };
    assert_eq!(["0.05", "010060"].map(thread), [false, true]);
}

#[test]
fn every_dialect_tells_all_errors_and_ignores_any_code() {
    for dialect in Dialect::ALL {
        for setup in [Setup { dialect, ..Setup::default() }, Setup { dialect, ..Setup::lathe() }] {
            let run = |source: &str, setup: &Setup| interpret(source, Path::new("part.nc"), setup);
            let source = "G0 X1\nG77\nX2 !\nM222\nG77\nX3 X4\nM30";
            let error = run(source, &setup).expect_err("the program is wrong");
            let told = error.to_string();
            let places: Vec<&str> = told.lines().filter_map(|line| line.split(' ').next()).collect();
            assert_eq!(
                places[..4],
                ["part.nc:2:1:", "part.nc:3:4:", "part.nc:4:1:", "part.nc:6:4:"],
                "{dialect}: {told}"
            );
            // Codes that nobody knows, that the dialect knows, and that move the axes elsewhere.
            for code in
                ["G77", "M222", "G28", "G4", "G43", "G81", "G71", "M6", "M8", "M98", "G54.1", "G10", "M0", "G92", "G68"]
            {
                let ignored = [code.parse::<CodeName>().unwrap()].into();
                let setup = Setup { ignored, ..setup.clone() };
                let program = run(&format!("G0 X1\n{code} P1 Z5 R1 L1\nG0 X2\nM30"), &setup);
                if code.starts_with('M') {
                    // Axis words beside an M code are the motion's.
                    assert!(program.is_ok() || code != "M222", "{dialect} {code}: {program:?}");
                    let program =
                        run(&format!("G0 X1\n{code} P1\nG0 X2\nM30"), &setup).unwrap_or_else(|e| panic!("{e}"));
                    assert_eq!(program.moves.len(), 2, "{dialect} {code}");
                } else {
                    let program = program.unwrap_or_else(|error| panic!("{dialect} {code}: {error}"));
                    assert_eq!(program.moves.len(), 2, "{dialect} {code}");
                    let told = format!("{code} is ignored, as asked");
                    assert!(
                        program.notes.iter().any(|note| note.text == told),
                        "{dialect} {code}: {:?}",
                        program.notes
                    );
                }
            }
        }
    }
}

#[test]
fn variables_with_names_are_siemens_or_okumas() {
    for source in [
        "PRES[3]=1\nG0 X1\nM30",
        "N10 _Z_HOME=5",
        "TEST=1",
        "G0 X1\nN20 $TC_DP1[1,1]=120",
        "N5 STOPRE",
        "PROC SH204(INT A)",
        "N5 _Contour_Setup(1)",
        "DEF STRING[10] NAME",
        "IF R1<5 GOTOF END",
        "IF R1<>5 GOTOF END",
        "POCKET3(50,0,1)",
    ] {
        let told = error_of(source).to_string();
        assert!(told.contains("SINUMERIK"), "{source}: {told}");
    }
    for source in ["$PART.MIN%\nPRES=1\nG0 X1", "O1\nCALL OCHCK\nG0 X1"] {
        let told = error_of(source).to_string();
        assert!(told.contains("Okuma"), "{source}: {told}");
    }
    // Of LinuxCNC's programs with an error none is taken for one.
    let named = ["#<pocket_depth>=5\nG77", "o<pocket> sub\no<pocket> endsub\nG77", "G0 X[#<a>+#<extern>]\nG77"];
    for source in ["#<length>=5\nG77", "o<callo> call\nM2", "X[1 EQ 1] Y==\nM2"].into_iter().chain(named) {
        assert!(!error_of(source).to_string().contains("not interpreted"), "{source}");
    }
}
