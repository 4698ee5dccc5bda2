//! Programs for Fanuc's and Haas's controls. Expectations are worked out by hand beside the programs.

mod support;

use rs274::{Axis, Dialect, Limits, MoveKind, Position, Setup, Tool, interpret};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;
use support::{assert_ends, ends, refused, run};

fn fanuc() -> Setup {
    Setup { dialect: Dialect::Fanuc, tools: [(1, Tool::with_length(50.0, 6.0))].into(), ..Setup::default() }
}

fn haas() -> Setup {
    Setup { dialect: Dialect::Haas, ..fanuc() }
}

fn lathe() -> Setup {
    let offset = |x, z| Tool { offset: Position([x, 0.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), ..Tool::default() };
    Setup { dialect: Dialect::Fanuc, tools: [(1, offset(1.0, 2.0)), (12, offset(0.0, 5.0))].into(), ..Setup::lathe() }
}

fn xs(source: &str) -> Vec<f64> {
    ends(&run(source, &fanuc())).into_iter().map(|end| end[0]).collect()
}

#[test]
fn g0_beside_g28_sets_the_mode_alone() {
    // By way of where Z is already, home; then X at rapid rate, and not at the feed that held before.
    for block in ["G0 G91 G28 Z0.", "G28 G91 G0 Z0."] {
        let program = run(&format!("G1 X5. Z10. F100\n{block}\nG90 X7.\nM30"), &fanuc());
        assert_eq!(ends(&program), [[5.0, 0.0, 10.0], [5.0, 0.0, 10.0], [5.0, 0.0, 0.0], [7.0, 0.0, 0.0]], "{block}");
        assert_eq!(program.moves[3].kind, MoveKind::Rapid);
    }
    // LinuxCNC refuses it, and so does its dialect.
    let error = refused("G0 G91 G28 Z0.\nM2", &Setup::default());
    assert!(error.contains("another code of this block uses the axis words"), "{error}");
}

#[test]
fn conditions_jumps_and_loops_of_the_macro_language() {
    assert_eq!(xs("#1=1\nIF[#1EQ1]GOTO10\nG0X1.\nN10G0X2.\nM30"), [2.0]);
    assert_eq!(xs("#1=1\nIF [#1 EQ 2] THEN #1=7.\nIF [#1 EQ 1] THEN #2=5.\nG0 X#1 Y#2\nM30"), [1.0]);
    assert_eq!(xs("#1=0\nWHILE[#1LT3]DO1\n#1=#1+1\nG0X#1\nEND1\nM30"), [1.0, 2.0, 3.0]);
    assert_eq!(
        xs("#1=0\nWHILE[#1LT2]DO1\n#1=#1+1\n#2=0\nWHILE[#2LT2]DO2\n#2=#2+1\nG0X[#1*10+#2]\nEND2\nEND1\nM30"),
        [11.0, 12.0, 21.0, 22.0]
    );
    // A loop without a condition is left by GOTO; a computed GOTO; back and forth.
    assert_eq!(xs("#1=0\nDO1\n#1=#1+1\nG0X#1\nIF[#1GE3]GOTO99\nEND1\nN99M30"), [1.0, 2.0, 3.0]);
    assert_eq!(xs("#5=20\nGOTO#5\nN10 X1.\nM30\nN20 X2.\nGOTO10"), [2.0, 1.0]);
    // Words cut down to two letters; but GO is no GOTO.
    assert_eq!(xs("#1=0\nWH[#1LT2]DO1\n#1=#1+1\nIF[#1EQ1]TH#2=5.\nG0X[#1+#2]\nEN1\nM30"), [6.0, 7.0]);
    assert!(refused("GO10\nN10M30", &fanuc()).contains("bad.nc:1:"));
    // Expressions stand without brackets behind `=`.
    assert_eq!(xs("#1=2.+3.*[4.-1.]-SQRT[16.]/2\nX#1\nM30"), [9.0]);
    assert_eq!(
        xs("#1=FIX[-1.5]\nX#1\n#1=FUP[1.2]\nX#1\n#1=ATAN[1.,1.]\nX#1\n#1=ATAN[1.]/[1.]\nX#1\nM30"),
        [-1.0, 2.0, 45.0, 45.0]
    );
}

#[test]
fn what_never_ends_ends_at_the_limit() {
    let setup = Setup { limits: Limits { blocks: 1000, ..Limits::default() }, ..fanuc() };
    for source in ["N10\nGOTO10", "WHILE[1EQ1]DO1\nEND1", "M98P1\nM30\nO1\nM98P1\nM99", "DO1\nX1.\nEND1\nM30"] {
        let told = refused(source, &setup);
        assert!(
            told.contains("more than 1000 blocks executed") || told.contains("more than 64 subroutine calls"),
            "{told}"
        );
    }
    assert!(refused("GOTO10\nM30", &fanuc()).contains("bad.nc:1:1: there is no line with this number N: `GOTO 10`"));
    assert!(refused("DO1\nM30", &fanuc()).contains("is never ended"));
    assert!(refused("END1\nM30", &fanuc()).contains("no DO with this number"));
    assert!(refused("#3000=1(TOOL BROKEN)\nM30", &fanuc()).contains("bad.nc:1:1: the program raises alarm 1"));
}

#[test]
fn lines_behind_an_optional_end_are_named() {
    let noted = |source: &str, setup: &Setup| {
        let program = run(source, setup);
        assert_eq!(program.moves.last().unwrap().end[Axis::X], 1.0, "{source}");
        program.notes.iter().filter(|note| note.is_unknown && note.text.contains("with `/` ends the program")).count()
    };
    for (source, expected) in [
        ("G0X1.\n/M30\nX9.\nM30", 1),
        ("G0X1.\n/M99\nX9.\nM30", 1),
        ("G0X1.\n/M30\n(OFF)\nN9M9\nM30\nO2\nG0X9.\nM99", 0),
        ("G0X1.\n/M99\nM30", 0),
        ("G0X1.\nM30\nX9.", 0),
    ] {
        assert_eq!(noted(source, &fanuc()), expected, "{source}");
    }
    assert_eq!(noted("G0 X1\n/M2\nX9\nM2", &Setup::default()), 1);
    let skips = Setup { block_delete: true, ..fanuc() };
    assert!(run("G0X1.\n/M30\nX9.\nM30", &skips).notes.iter().all(|note| !note.is_unknown));
    // The number of the line may stand before the slash.
    let ends = |setup: &Setup| run("G0X1.\nN5/2X5.\nN6X9.\nM30", setup).moves.len();
    assert_eq!([ends(&fanuc()), ends(&skips)], [3, 2]);
}

#[test]
fn p_is_no_word_of_fanucs_arcs() {
    for setup in [fanuc(), haas()] {
        let program = run("G2X10.I5.J0F100.M98P3\nM30\nO3\nM99", &setup);
        assert!(matches!(program.moves[0].kind, MoveKind::Arc { sweep, .. } if (sweep + PI).abs() < 1e-9));
        assert!(refused("G2X10.I5.J0F100.P3\nM30", &setup).contains("no code of this block uses this word: `P3`"));
    }
}

#[test]
fn m99_goes_on_with_a_line_or_from_the_start() {
    assert_eq!(xs("X1.\nM99P7\nX9.\nN7X2.\nM30"), [1.0, 2.0]);
    assert!(refused("M99P7\nM30", &fanuc()).contains("there is no line with this number N"));
    // What comes after the last line is the first one, from another place.
    assert_eq!(xs("#1=0\nX1.\nX2.\nM99\nX9."), [1.0, 2.0, 1.0, 2.0]);
    let round = interpret("G21X1.\nM99", Path::new("main.nc"), &fanuc()).unwrap();
    assert_eq!(round.notes.len(), 1);
    let told = round.notes[0].to_string();
    assert_eq!(told, "line 2: M99 goes round for ever; it is followed until a round changes nothing");
    // What counts goes on to where the count leads it, or is left, and named.
    assert_eq!(xs("#100=#100+1\nX0.\nIF[#100EQ3]GOTO9\nX10.\nM99\nN9X90.\nM30"), [0.0, 10.0, 0.0, 10.0, 0.0, 90.0]);
    let steps = interpret("G21M98P2L4000\nM99\nO2G91X1.\nM99", Path::new("main.nc"), &fanuc()).unwrap();
    assert!(steps.moves.len() == 12_000 && steps.notes[0].is_unknown && steps.notes.len() == 1, "{:?}", steps.notes);
    assert!(steps.notes[0].text.ends_with("behind 3 rounds it is not followed"), "{:?}", steps.notes);
    // Jumps by M99 P are no rounds.
    let mixed = "G21#1=0\nN2#1=#1+1\nIF[#1EQ2]GOTO3\nM99P2\nN3M98P2L5001\nM99\nO2X1.\nX2.\nM99";
    assert_eq!(run(mixed, &fanuc()).moves.len(), 2 * 2 * 5001);
    // What goes round for ever is followed twice, whether it begins at the first line or not.
    let source = "X1.\nN5X2.\nX3.\nM99P5";
    assert_eq!(xs(source), [1.0, 2.0, 3.0, 2.0, 3.0]);
    let program = run(&format!("G21{source}"), &fanuc());
    assert_eq!(program.notes.len(), 1);
    assert_eq!(
        program.notes[0].to_string(),
        "line 4: M99 P goes round for ever; it is followed until a round changes nothing"
    );
    assert_eq!(xs("N1M99P1"), [0.0; 0]);
    // A loop that counts ends where it says, by an origin, too.
    assert_eq!(xs("N1G91G10L2P1X1.\nIF[#5221EQ4.]GOTO9\nM99P1\nN9G53G90G0X9.\nM30"), [9.0]);
    assert_eq!(xs("#1=0\nN1#1=#1+1\nX#1\nIF[#1EQ4]GOTO9\nM99P1\nN9M30"), [1.0, 2.0, 3.0, 4.0]);
    let setup = Setup { limits: Limits { blocks: 1000, ..Limits::default() }, ..fanuc() };
    assert!(refused("#1=0\nN1#1=#1+1\nM99P1", &setup).contains("more than 1000 blocks executed"));
}

#[test]
fn g53_of_fanuc_goes_at_rapid_rate() {
    let kinds = |source: &str, setup: &Setup| -> Vec<MoveKind> {
        interpret(source, Path::new("main.nc"), setup).unwrap().moves.iter().map(|step| step.kind).collect()
    };
    let source = "G1X1.F100\nG53X5.\nX6.\nM30";
    assert_eq!(kinds(source, &fanuc()), [MoveKind::Feed, MoveKind::Rapid, MoveKind::Feed]);
    assert_eq!(kinds(source, &haas()), [MoveKind::Feed; 3]);
    assert!(refused("G91G53X5.\nM30", &fanuc()).contains("G53 under G91"));
}

#[test]
fn variables_may_be_vacant() {
    // Nothing has set #1: X has no word, and it equals #0 but not 0.
    assert_ends("G0X5.\nG0X#1Y3.\nM30", &fanuc(), &[[5.0, 0.0, 0.0], [5.0, 3.0, 0.0]]);
    assert_eq!(xs("IF[#1EQ#0]GOTO1\nX9.\nN1X1.\nM30"), [1.0]);
    assert_eq!(xs("IF[#1EQ0]GOTO1\nX9.\nN1X1.\nM30"), [9.0, 1.0]);
    assert_eq!(xs("#1=#2+1\nX#1\nM30"), [1.0]);
    // As a condition on its own it is zero, which is false; Fanuc's controls refuse it.
    for source in
        ["IF[#1]GOTO1\nG0X1.\nN1M30", "WHILE[#1]DO1\nG0X9.\nEND1\nG0X1.\nM30", "IF[-#1]THEN#2=9.\nG0X[1.+#2]\nM30"]
    {
        assert_ends(source, &haas(), &[[1.0, 0.0, 0.0]]);
        assert!(
            refused(source, &fanuc()).contains("bad.nc:1:1: not allowed: a condition that compares nothing"),
            "{source}"
        );
    }
    assert_ends("O1 REPEAT[#1]\nG0X9.\nO1 ENDREPEAT\nG0X1.\nM30", &fanuc(), &[[1.0, 0.0, 0.0]]);
    assert!(refused("X#2001\nM30", &fanuc()).contains("parameter does not exist"));
}

#[test]
fn variables_that_the_control_keeps_must_be_set() {
    for (setup, source, variable) in [
        (fanuc(), "G1Z#510F100\nM30", "510"),
        (fanuc(), "#1=#999+1\nM30", "999"),
        (haas(), "G1Z#10500F100\nM30", "10500"),
        (haas(), "G0X#100\nM30", "100"),
    ] {
        let told = refused(source, &setup);
        assert!(told.starts_with("bad.nc:1:4: nothing has set this variable"), "{source}: {told}");
        assert!(told.ends_with(&format!("(`--variable NUMBER=VALUE`): `#{variable}`")), "{source}: {told}");
        let parameters = [(variable.to_owned(), -5.0)].into();
        run(source, &Setup { parameters, ..setup });
    }
    let given = Setup { parameters: [("510".to_owned(), -5.0)].into(), ..fanuc() };
    assert_ends("G0Z#510\nM30", &given, &[[0.0, 0.0, -5.0]]);
    // Asking whether it is vacant reads it; what is made vacant is set. Fanuc's below #500 begin vacant.
    assert!(refused("IF[#500EQ#0]GOTO1\nN1M30", &fanuc()).contains("nothing has set this variable"));
    assert_ends("#500=#0\nG0X5.Z#500Y#100\nM30", &fanuc(), &[[5.0, 0.0, 0.0]]);
}

#[test]
fn what_m109_asks_the_operator_is_not_what_the_program_wrote_before() {
    let source = "#10501=0\nM109P10501(1 FINISHES)\nIF[#10501EQ49]GOTO100\nG0X10.\nM30\nN100G0X50.\nM30";
    let told = refused(source, &haas());
    assert!(told.starts_with("bad.nc:3:4: nothing has set this variable") && told.ends_with("`#10501`"), "{told}");
    for (key, x) in [(49.0, 50.0), (48.0, 10.0)] {
        let setup = Setup { parameters: [("10501".to_owned(), key)].into(), ..haas() };
        assert_ends(source, &setup, &[[x, 0.0, 0.0]]);
    }
    // What the program writes afterwards counts; on Fanuc's controls M109 is the builder's.
    assert_ends("M109P10501\n#10501=7.\nG0X#10501\nM30", &haas(), &[[7.0, 0.0, 0.0]]);
    assert_ends("#501=7.\nM109P501\nG0X#501\nM30", &fanuc(), &[[7.0, 0.0, 0.0]]);
    assert!(refused("M109\nM30", &haas()).contains("bad.nc:1:1: P, the variable"));
    assert!(refused("M109P5041\nM30", &haas()).contains("bad.nc:1:5: parameter does not exist"));
}

#[test]
fn subprograms_are_called_by_number_with_repeats_and_arguments() {
    assert_eq!(xs("M98P1000\nM30\nO1000\nG91G0X1.\nM99"), [1.0]);
    assert_eq!(xs("G91\nM98P31000\nM30\nO1000\nG0X1.\nM99"), [1.0, 2.0, 3.0]);
    // Haas's P is the whole number.
    assert!(refused("G91\nM98P31000\nM30\nO1000\nG0X1.\nM99", &haas()).contains("subroutine is not defined"));
    assert_ends("M98P31000\nM30\nO1000\nG0X1.\nM99\nO31000\nG0X3.\nM99", &haas(), &[[3.0, 0.0, 0.0]]);
    assert_eq!(xs("G91\nM98P1000L2\nM30\nO1000\nG0X1.\nM99"), [1.0, 2.0]);
    assert_eq!(xs("G65P9010A1.X7.\nX#24\nM30\nO9010\nG0X#1\nX#24\nM99"), [1.0, 7.0]);
    // A vacant argument, and a return to a line of the caller.
    assert_eq!(xs("G65P9010A1.\nX5.\nN7X6.\nM30\nO9010\nIF[#2EQ#0]GOTO5\nX9.\nN5M99P7"), [6.0]);
    // A code beside G65 would be lost.
    for source in ["G90G65P9010Z1.\nM30\nO9010\nM99", "G65P9010M30.\nM30\nO9010\nM99"] {
        assert!(refused(source, &fanuc()).contains("another code beside G65"), "{source}");
    }
    // I, J and K in their order, of which some may be missing; else they are other variables.
    let macro_of = |words: &str| format!("G65P9010{words}\nM30\nO9010\nG0X#4Y#5Z#6\nM99");
    for setup in [fanuc(), haas()] {
        assert_ends(&macro_of("I20.A1.J30.K10."), &setup, &[[20.0, 30.0, 10.0]]);
        assert_ends(&macro_of("K10."), &setup, &[[0.0, 0.0, 10.0]]);
        for words in ["K10.I20.J30.", "I20.K10.J30.", "J30.A1.I20.", "I1.J2.K3.I4.", "I1.I2."] {
            let told = refused(&macro_of(words), &setup);
            assert!(told.starts_with("bad.nc:1:") && told.contains("argument specification II"), "{words}: {told}");
        }
    }
    assert!(refused("G65P9010A1.A2.\nM30\nO9010\nM99", &fanuc()).contains("word given twice"));
    // Haas calls lines of the same program.
    let local = "G91\nM97P100L2\nM30\nN100G0X1.\nM99";
    assert_ends(local, &haas(), &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    assert!(refused("M98P7\nM30", &fanuc()).contains("subroutine is not defined"));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("O1000.nc"), "%\nO1000\nG0X4.\nM99\n%\n").unwrap();
    let main = folder.path().join("main.nc");
    assert_eq!(ends(&interpret("M98P1000\nX5.\nM30", &main, &fanuc()).unwrap()), [[4.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
}

#[test]
fn dwells_have_their_own_units() {
    let seconds = |source: &str| match run(source, &fanuc()).moves[0].kind {
        MoveKind::Dwell { seconds } => seconds,
        kind => panic!("{source}: {kind:?}"),
    };
    for source in ["G04X1.5\nM30", "G04U1.5\nM30", "G04P1500\nM30", "G4P1.5\nM30"] {
        assert!((seconds(source) - 1.5).abs() < 1e-12, "{source}");
    }
    assert!(run("G04\nM30", &fanuc()).moves.is_empty());
    let error = interpret("G04X1.5\nM2", Path::new("bad.ngc"), &Setup::default()).unwrap_err();
    assert!(error.to_string().contains("in the dialects fanuc and haas"), "{error}");
}

#[test]
fn a_lathe_calls_tool_and_offset_in_one() {
    let program = run("T0101\nG0X20.Z10.\nT0112\nG0Z10.\nT0100\nZ0\nM30", &lathe());
    let told: Vec<_> = program.moves.iter().map(|m| (m.kind, m.end[Axis::X], m.end[Axis::Z])).collect();
    let rapid = MoveKind::Rapid;
    // Diameter 20 at offset 1, length 10 at offset 2; then offset 12 with 5 along Z; then none.
    assert_eq!(
        told,
        [(MoveKind::ToolChange { tool: 1 }, 0.0, 0.0), (rapid, 11.0, 12.0), (rapid, 11.0, 15.0), (rapid, 11.0, 0.0)]
    );
    assert!(refused("T0105\nM30", &lathe()).contains("tool is not in the tool table"));
    assert!(refused("T5\nM30", &lathe()).contains("as in T0101"));
    // U and W are steps.
    assert_ends("G0X20.Z10.\nU-4.W-1.\nM30", &lathe(), &[[10.0, 0.0, 10.0], [8.0, 0.0, 9.0]]);
    // Of a word and a step of one axis the later counts.
    let later = "G0X40.Z5.\nX50.U10.\nU10.X50.\nZ10.W-3.\nM30";
    assert_ends(later, &lathe(), &[[20.0, 0.0, 5.0], [25.0, 0.0, 5.0], [25.0, 0.0, 5.0], [25.0, 0.0, 2.0]]);
    // On LinuxCNC the same words change nothing, and that is told.
    let program = run("T0202\nG0 X1\nM2", &Setup::lathe());
    assert!(program.moves.iter().all(|step| step.kind == rapid));
    let told = "T202 selects a tool that no M6 changes to";
    assert!(program.notes.iter().any(|note| note.text.contains(told)), "{:?}", program.notes);
    assert!(run("G21 T2 M6\nG0 X1\nM2", &Setup::default()).notes.is_empty());
}

#[test]
fn a_machine_position_is_what_g53_takes() {
    // On lathes a diameter.
    for (setup, x) in [(lathe(), 50.0), (Setup { dialect: Dialect::Haas, ..lathe() }, 50.0), (fanuc(), 100.0)] {
        let source = "G0X100.Z50.\n#1=#5021\nX0\nG0G53X#1\nM30";
        assert_ends(source, &setup, &[[x, 0.0, 50.0], [0.0, 0.0, 50.0], [x, 0.0, 50.0]]);
        let inches = format!("G20\n{}", source.replace("100.", "4."));
        let x = x * 25.4 / 25.0;
        assert_ends(&inches, &setup, &[[x, 0.0, 1270.0], [0.0, 0.0, 1270.0], [x, 0.0, 1270.0]]);
    }
}

#[test]
fn a_lathes_codes_are_those_of_system_a() {
    // G50 limits the speed, G99 feeds per revolution, G98 per minute, G96 keeps the surface speed.
    let program = run("G50S2000\nG96S200M3\nG0X100.Z0\nG99G1Z-10.F0.2\nX1.\nG98G1Z-20.F100.\nM30", &lathe());
    let rpm = 200_000.0 / (PI * 100.0);
    assert!((program.moves[1].spindle_rpm - rpm).abs() < 1e-6);
    assert!((program.moves[1].feed_mm_min.unwrap() - 0.2 * rpm).abs() < 1e-6);
    assert_eq!(program.moves[2].spindle_rpm, 2000.0);
    assert_eq!(program.moves[3].feed_mm_min, Some(100.0));
    assert_ends("G50X100.Z50.\nG0X80.Z40.\nM30", &lathe(), &[[-10.0, 0.0, -10.0]]);
    assert_ends("G28U0W0\nM30", &lathe(), &[[0.0; 3], [0.0; 3]]);
    // H is a step of C, which alone goes home.
    for source in ["G0X40.Z5.C90.\nG28H0\nM30", "G0X40.Z5.C90.\nG28C90.\nM30"] {
        let program = run(source, &lathe());
        support::assert_near(ends(&program)[2], [20.0, 0.0, 5.0], source);
        assert_eq!(program.moves.iter().map(|m| m.end[Axis::C]).collect::<Vec<_>>(), [FRAC_PI_2, FRAC_PI_2, 0.0]);
    }
    // Drilling goes along Z; R is a step from where the cycle begins.
    assert_ends(
        "G0X0Z5.\nG83Z-9.R-3.F0.1S100M3\nG80\nM30",
        &lathe(),
        &[[0.0, 0.0, 5.0], [0.0, 0.0, 5.0], [0.0, 0.0, 2.0], [0.0, 0.0, -9.0], [0.0, 0.0, 5.0]],
    );
}

#[test]
fn holes_of_a_lathe_are_at_x_and_c_and_their_depth_is_z_or_w() {
    let haas = Setup { dialect: Dialect::Haas, ..lathe() };
    // X and Z, mm, and C, degrees, at the bottom of each hole; the cycles begin at diameter 60 and Z5.
    for (setup, cycles, expected) in [
        // The example of Fanuc's manual.
        (
            lathe(),
            "G83X50.C0.Z-40.R-5.P500F5.\nC90.\nC180.",
            &[[25.0, -40.0, 0.0], [25.0, -40.0, 90.0], [25.0, -40.0, 180.0]][..],
        ),
        (lathe(), "G83Z-10.R-3.F0.1\nH90.\nX40.H90.", &[[30.0, -10.0, 0.0], [30.0, -10.0, 90.0], [20.0, -10.0, 180.0]]),
        (lathe(), "G83U-20.H30.Z-10.R-3.F0.1K2", &[[20.0, -10.0, 30.0], [10.0, -10.0, 60.0]]),
        // W counts from R, which is at Z2.
        (lathe(), "G83W-25.R-3.Q10000F0.1\nC90.", &[[30.0, -23.0, 0.0], [30.0, -23.0, 90.0]]),
        (haas, "G81W-25.R2.F0.1\nC90.", &[[30.0, -23.0, 0.0], [30.0, -23.0, 90.0]]),
    ] {
        let program = run(&format!("S100M3G0X60.Z5.C0\n{cycles}\nG80\nM30"), &setup);
        let deepest = expected[0][1];
        let bottoms = program.moves.iter().filter(|step| step.kind == MoveKind::Feed && step.end[Axis::Z] == deepest);
        let found: Vec<_> = bottoms.map(|m| [m.end[Axis::X], m.end[Axis::Z], m.end[Axis::C].to_degrees()]).collect();
        assert_eq!(found.len(), expected.len(), "{cycles}: {found:?}");
        found.iter().zip(expected).for_each(|(found, expected)| support::assert_near(*found, *expected, cycles));
    }
    // C turns while the tool stands above the holes.
    let moves = run("S100M3G0X60.Z5.\nG83Z-10.R-3.F0.1\nC90.\nM30", &lathe()).moves;
    let turns = moves.windows(2).filter(|pair| pair[0].end[Axis::C] != pair[1].end[Axis::C]);
    assert_eq!(turns.map(|pair| [0, 1].map(|i| pair[i].end[Axis::Z])).collect::<Vec<_>>(), [[5.0; 2]]);
    let told = refused("T0101\nG0X60.Z5.\nT0112\nG83U-2.Z-9.R-3.F0.1S100M3\nM30", &lathe());
    assert!(told.starts_with("bad.nc:4:1:") && told.contains("right behind another tool offset"), "{told}");
}

#[test]
fn coordinates_are_turned_scaled_and_mirrored() {
    assert_ends("G68X1.Y0R90.\nG0X3.Y0\nG69\nX3.Y0\nM30", &fanuc(), &[[1.0, 2.0, 0.0], [3.0, 0.0, 0.0]]);
    // About the place where the tool is: (1, 0).
    assert_ends("G0X1.\nG68R90.\nX3.\nM30", &fanuc(), &[[1.0, 0.0, 0.0], [1.0, 2.0, 0.0]]);
    assert_ends("G51X0Y0Z0P2000\nG0X3.Y1.\nG50\nX3.\nM30", &fanuc(), &[[6.0, 2.0, 0.0], [3.0, 2.0, 0.0]]);
    assert_ends("G51X0Y0Z0P2.\nG0X3.Y1.\nM30", &haas(), &[[6.0, 2.0, 0.0]]);
    assert_ends("G51.1X10.\nG0X3.Y1.\nG50.1X0\nX3.\nM30", &fanuc(), &[[17.0, 1.0, 0.0], [3.0, 1.0, 0.0]]);
    // A circle stays one: turned, larger, the other way round in a mirror.
    let arc = |source: &str| match run(source, &fanuc()).moves[1].kind {
        MoveKind::Arc { centre, sweep, .. } => (centre, sweep),
        kind => panic!("{source}: {kind:?}"),
    };
    let near = |found: ([f64; 2], f64), centre: [f64; 2], sweep: f64| {
        assert!(
            (found.0[0] - centre[0]).hypot(found.0[1] - centre[1]) < 1e-9 && (found.1 - sweep).abs() < 1e-9,
            "{found:?}"
        );
    };
    near(arc("G68X0Y0R90.\nG0X10.Y1.\nG3X0Y11.I-10.F100\nM30"), [-1.0, 0.0], FRAC_PI_2);
    near(arc("G51X0Y0Z0P2.\nG0X10.Y1.\nG3X0Y11.R10.F100\nM30"), [0.0, 2.0], FRAC_PI_2);
    near(arc("G51.1X0\nG0X10.Y1.\nG3X0Y11.I-10.F100\nM30"), [0.0, 1.0], -FRAC_PI_2);
    // In a mirror the tool is on the other side: G41 of radius 3 along +X at X-mirror runs along -X, on its right.
    let comp = run("G51.1X0\nG0X0Y0\nG41D1G1X10.Y10.F100\nX30.\nG40\nM30", &fanuc());
    assert!((comp.moves[2].end[Axis::Y] - 13.0).abs() < 1e-9, "{:?}", ends(&comp));
    // Polar coordinates: radius and angle.
    let root = 50_f64.sqrt();
    assert_ends(
        "G16\nG0X10.Y45.\nY90.\nG15X1.\nM30",
        &fanuc(),
        &[[root, root, 0.0], [0.0, 10.0, 0.0], [1.0, 10.0, 0.0]],
    );
}

#[test]
fn a_turn_goes_the_other_way_in_a_mirror() {
    let told = "G68 turns mirrored coordinates";
    for (setup, source, expected, is_noted) in [
        // Turned to (-1, 3), mirrored to (1, 3); about (2, 0) to (1, 1), mirrored to (-1, 1).
        (fanuc(), "G51.1X0\nG68X0Y0R90.", [1.0, 3.0], false),
        (fanuc(), "G51.1X0\nG68X2.Y0R90.", [-1.0, 1.0], true),
        (fanuc(), "G17G51.1Y0\nG68X2.Y0R90.", [1.0, -1.0], false),
        // Two mirrors are half a turn, and that of the normal is none of the plane's.
        (fanuc(), "G51.1X0Y0\nG68X0Y0R90.", [1.0, -3.0], false),
        (fanuc(), "G51.1Z0\nG68X0Y0R90.", [-1.0, 3.0], false),
        // About the tool, at (2, 0).
        (fanuc(), "G51.1X0\nG0X-2.Y0\nG68R90.", [3.0, 5.0], false),
        (fanuc(), "G51X0Y0Z0I-1.J1.K1.\nG68X0Y0R90.", [-1.0, -3.0], true),
        (haas(), "G51.1X0\nG68X0Y0R90.", [1.0, 3.0], true),
        (haas(), "G68X0Y0R90.\nG51.1X0", [-1.0, -3.0], true),
    ] {
        let program = run(&format!("{source}\nG0X3.Y1.\nM30"), &setup);
        support::assert_near(*ends(&program).last().unwrap(), [expected[0], expected[1], 0.0], source);
        let notes: Vec<_> = program.notes.iter().filter(|note| note.text.contains(told)).collect();
        assert!(
            notes.len() == usize::from(is_noted) && notes.iter().all(|note| note.is_unknown),
            "{source}: {notes:?}"
        );
    }
    for (on, off) in [("G68X0Y0R90.", "G69"), ("G51X0Y0Z0P2.", "G50")] {
        for mirror in ["G51.1X0", "G50.1X0"] {
            let told = refused(&format!("{on}\n{mirror}\nG0X3.Y1.\nM30"), &fanuc());
            assert!(
                told.starts_with("bad.nc:2:1: ") && told.contains("a mirror set or ended"),
                "{on} {mirror}: {told}"
            );
            run(&format!("{on}\n{off}{mirror}\nG0X3.Y1.\nM30"), &fanuc());
        }
    }
}

#[test]
fn the_angle_of_a_turn_in_g91_may_be_a_step() {
    let told = "R of G68 in G91 is taken for the whole angle";
    for (setup, source, lines) in [
        (fanuc(), "G91G68X0Y0R90.\nG91G68X0Y0R90.\nG68X0Y0R90.", &[2, 3][..]),
        (fanuc(), "G91G68X0Y0R90.\nG69\nG68X0Y0R90.", &[]),
        (fanuc(), "G68X0Y0R90.\nG90G68X0Y0R90.", &[]),
        (haas(), "G91G68X0Y0R90.\nG69\nG68X0Y0R90.", &[1, 3]),
    ] {
        let program = run(&format!("{source}\nG90G0X3.Y1.\nM30"), &setup);
        support::assert_near(ends(&program)[0], [-1.0, 3.0, 0.0], source);
        let noted: Vec<_> =
            program.notes.iter().filter(|note| note.text.starts_with(told) && note.is_unknown).collect();
        let found = noted.first().map(|note| (note.line, note.more as usize + 1));
        assert_eq!(found, lines.first().map(|&line| (line, lines.len())), "{source}: {:?}", program.notes);
    }
}

#[test]
fn the_first_move_behind_g69_is_to_a_place() {
    let told = "the first move of an axis behind G69 is a step";
    for (setup, source, is_noted) in [
        (fanuc(), "G91G0X5.", true),
        (fanuc(), "G0X1.\nG91Y5.", true),
        (fanuc(), "G91G81X5.Z-1.R0F100", true),
        (fanuc(), "G91G28X5.", true),
        (fanuc(), "G0X1.Y1.\nG91X5.", false),
        (fanuc(), "G91G0Z5.", false),
        (fanuc(), "G53X1.Y1.\nG91X5.", false),
        (fanuc(), "G91G28X0Y0\nX5.", false),
        (fanuc(), "G81X1.Y1.Z-1.R0F100\nG91X5.", false),
        (haas(), "G91G0X5.", false),
    ] {
        let program = run(&format!("G68X0Y0R90.\nG0X10.Y0\nG69\n{source}\nM30"), &setup);
        let noted: Vec<_> = program.notes.iter().filter(|note| note.text.starts_with(told)).collect();
        assert!(
            noted.len() == usize::from(is_noted) && noted.iter().all(|note| note.is_unknown),
            "{source}: {noted:?}"
        );
    }
    // No turn has ended.
    assert!(!run("G69G91\nG0X5.\nM30", &fanuc()).notes.iter().any(|note| note.text.starts_with(told)));
}

#[test]
fn a_turn_or_scale_without_a_centre_is_about_where_the_tool_is() {
    for (source, expected) in [
        // (10, 0) turned by 90 degrees is at (0, 10), which the second turn leaves where it is.
        ("G68X0Y0R90.\nG0X10.Y0\nG68R45.\nG0X0Y10.", [0.0, 10.0, 0.0]),
        // One word: about (5, 10), from which (5, 0) is 10 down, and after a half turn 10 up.
        ("G68X0Y0R90.\nG0X10.Y0\nG68X5.R180.\nG0X5.Y0", [5.0, 20.0, 0.0]),
        ("G51.1X0\nG0X10.\nG51P2.\nG0X10.", [-10.0, 0.0, 0.0]),
        ("G51.1X0\nG0X10.\nG51P2.\nG0X9.", [-8.0, 0.0, 0.0]),
        // The turn comes behind the scale.
        ("G68X0Y0R90.\nG0X10.Y0\nG51P2.\nG0X11.", [0.0, 12.0, 0.0]),
        ("G0X10.\nG68R90.\nG0X11.Y0", [10.0, 1.0, 0.0]),
    ] {
        let program = run(&format!("{source}\nM30"), &fanuc());
        support::assert_near(*ends(&program).last().unwrap(), expected, source);
    }
}

#[test]
fn another_zero_in_turned_scaled_or_mirrored_coordinates() {
    for (on, off) in [("G68X0Y0R90.", "G69"), ("G51X0Y0Z0P2.", "G50"), ("G51.1X0", "G50.1")] {
        for zero in ["G92X0Y0", "G52X1.", "G55", "G54.1P2"] {
            let told = refused(&format!("{on}\nG0X10.Y1.\n{zero}\nM30"), &fanuc());
            assert!(told.starts_with("bad.nc:3:1: ") && told.contains("another zero"), "{on} {zero}: {told}");
            run(&format!("{on}\n{off}\n{zero}\nG0X1.\nM30"), &fanuc());
        }
        run(&format!("G54{on}\nG92S500\nG53G0X1.\n{off}G55\nM30"), &fanuc());
    }
    // Haas: (10, 0) is at (0, 10); read as (0, 0) it stays there, and X goes along Y.
    for (source, expected) in [
        ("G68X0Y0R90.\nG0X10.Y0\nG92X0Y0\nG0X5.", [0.0, 15.0, 0.0]),
        // (10, 4) is at (-4, 10), and read as (0, 4).
        ("G68X0Y0R90.\nG0X10.Y4.\nG92X0\nG0X5.", [-4.0, 15.0, 0.0]),
        ("G68X0Y0R90.\nG0X10.Y4.\nG92X0\nG0Y0", [0.0, 10.0, 0.0]),
        ("G51X0Y0Z0P2.\nG0X3.Y1.\nG92X0Y0\nX1.", [8.0, 2.0, 0.0]),
        ("G51.1X10.\nG0X3.Y1.\nG92X0\nX1.", [16.0, 1.0, 0.0]),
        // G52 by 2 along X, in front of which stands the turn: (10, 0) is at (2, 10).
        ("G52X2.\nG68X0Y0R90.\nG0X10.Y0\nG92X0Y0\nG0X5.", [2.0, 15.0, 0.0]),
    ] {
        let program = run(&format!("{source}\nM30"), &haas());
        support::assert_near(*ends(&program).last().unwrap(), expected, source);
    }
}

#[test]
fn there_are_more_coordinate_systems() {
    assert_ends("G10L20P3X100.Y10.\nG54.1P3G0X1.Y1.\nG54X1.\nM30", &fanuc(), &[[101.0, 11.0, 0.0], [1.0, 11.0, 0.0]]);
    assert_ends("#7041=100.\nG54P3G0X1.\nM30", &fanuc(), &[[101.0, 0.0, 0.0]]);
    assert_ends("G10L20P2X7.\nG154P2G0X1.\nG111X2.\nM30", &haas(), &[[8.0, 0.0, 0.0], [9.0, 0.0, 0.0]]);
    // Another code's P: Haas's G54 is G54; Fanuc's may be G54.1, which has no system 1000.
    let sub = "G0X1.\nM99";
    for (source, setup, noted) in [
        (format!("#7041=100.\nG54M98P3\nM30\nO3{sub}"), fanuc(), true),
        (format!("G54M98P1000\nM30\nO1000{sub}"), fanuc(), false),
        (format!("#7041=100.\nG54M98P3\nM30\nO3{sub}"), haas(), false),
        (format!("G54M97P20\nM30\nN20{sub}"), haas(), false),
        ("#7041=100.\nG54G4P3\nG0X1.\nM30".to_owned(), fanuc(), true),
        ("#7041=100.\nG54G99G82X1.Z-1.R0P3F100.\nM30".to_owned(), fanuc(), true),
        ("#7041=100.\nG82X2.Z-1.R0P1000F100.\nG54X1.P3\nM30".to_owned(), fanuc(), true),
        ("#7041=100.\nG10L2P3X5.G54\nG0X1.\nM30".to_owned(), fanuc(), true),
    ] {
        let program = run(&source, &setup);
        assert_eq!(ends(&program).last().unwrap()[0], 1.0, "{source}");
        let told = program.notes.iter().any(|note| note.is_unknown && note.text.contains("may take it for G54.1 P3"));
        assert_eq!(told, noted, "{source}");
    }
    for (source, setup) in
        [("G54.1M98P3\nM30\nO3\nM99", fanuc()), ("G154G4P3\nM30", haas()), ("G10L2P3X5.G54.1\nM30", fanuc())]
    {
        assert!(refused(source, &setup).contains("another code that takes P"), "{source}");
    }
    assert_ends("G10L20P3X100.\nG54.1P3G99G81X1.Z0R0F100.\nM30", &fanuc(), &[[101.0, 0.0, 0.0]; 2]);
    assert!(refused("G54P1\nM30", &haas()).contains("no code of this block uses this word"));
    assert_ends("G10L20P2X7.\nG154P2G0X1.M11\nM30", &haas(), &[[8.0, 0.0, 0.0]]);
    // On Haas's lathes G112 and G113 are something else, and so are G5 and G95.
    let haas_lathe = Setup { dialect: Dialect::Haas, ..lathe() };
    for code in ["G112", "G113", "G5R90.F40.Z-70.", "G95X40.Z-1.F1."] {
        assert!(refused(&format!("{code}\nM30"), &haas_lathe).starts_with("bad.nc:1:1:"), "{code}");
    }
    assert_ends("G10L20P5Z7.\nG114G0Z1.\nM30", &haas_lathe, &[[0.0, 0.0, 8.0]]);
    let program = run("G54.1P298G0X1.\nM30", &fanuc());
    assert!(program.notes[0].text.contains("G54.1P298 is taken to be zero"), "{:?}", program.notes);
    assert!(refused("G54.1P299\nM30", &fanuc()).contains("1 to 298"));
    // Given from outside; a number that there is not, and another dialect, change nothing.
    let at = |x| Position([x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let more_work_offsets: BTreeMap<u32, Position> =
        [(0, 9.0), (2, 7.0), (3, 0.0), (298, 5.0), (299, 9.0)].map(|(n, x)| (n, at(x))).into();
    for (source, setup, expected) in [
        ("G54.1P2G0X1.\nM30", fanuc(), 8.0),
        ("G154P298G0X1.\nM30", haas(), 6.0),
        ("G20G54.1P2G0X0.\nM30", fanuc(), 7.0),
        ("G54.1P3G0X1.\nM30", fanuc(), 1.0),
    ] {
        let program = run(source, &Setup { more_work_offsets: more_work_offsets.clone(), ..setup });
        support::assert_near(ends(&program)[0], [expected, 0.0, 0.0], source);
        let is_unset = program.notes.iter().any(|note| note.text.contains("to be zero"));
        assert!(!is_unset, "{source}: {:?}", program.notes);
    }
    assert_ends("G10L2P1X5.\nG54G0X1.\nG91G10L2P1X2.\nG90X1.\nM30", &fanuc(), &[[6.0, 0.0, 0.0], [8.0, 0.0, 0.0]]);
    // G10 L10 sets a length, L12 a radius.
    assert_ends("G10L10P5R20.\nG43H5G0Z1.\nM30", &fanuc(), &[[0.0, 0.0, 21.0]]);
    // G44 subtracts it.
    assert_ends("G44H1G0Z1.\nM30", &fanuc(), &[[0.0, 0.0, -49.0]]);
}

#[test]
fn a_skip_goes_all_the_way_and_the_motion_before_goes_on() {
    let program = run("G1X1.F100\nG31X5.F50\nX6.\nM30", &fanuc());
    let told: Vec<_> = program.moves.iter().map(|m| (m.end[Axis::X], m.feed_mm_min)).collect();
    assert_eq!(told, [(1.0, Some(100.0)), (5.0, Some(50.0)), (6.0, Some(50.0))]);
}

#[test]
fn corners_are_rounded_and_cut() {
    let source = "G0X0Y0\nG1X10.,R2.F100\nY10.,C3.\nX0\nM30";
    let corners = [[0.0; 3], [8.0, 0.0, 0.0], [10.0, 2.0, 0.0], [10.0, 7.0, 0.0], [7.0, 10.0, 0.0], [0.0, 10.0, 0.0]];
    assert_ends(source, &fanuc(), &corners);
    let program = run(source, &fanuc());
    let MoveKind::Arc { centre, sweep, .. } = program.moves[2].kind else { panic!("{:?}", program.moves[2]) };
    assert!((centre[0] - 8.0).abs() < 1e-9 && (centre[1] - 2.0).abs() < 1e-9 && (sweep - FRAC_PI_2).abs() < 1e-9);
    assert_eq!(program.moves.iter().map(|m| m.line).collect::<Vec<_>>(), [1, 2, 2, 3, 3, 4]);
    // To the right the arc is clockwise; with a tool beside the path its radius is another.
    let program = run("G0X0Y0\nG1X10.,R2.F100\nY-10.\nM30", &fanuc());
    assert!(matches!(program.moves[2].kind, MoveKind::Arc { sweep, .. } if (sweep + FRAC_PI_2).abs() < 1e-9));
    let program = run("G0X0Y-10.\nG41D1G1X0Y0F100\nX20.,R5.\nY20.\nG40X30.\nM30", &fanuc());
    let at_corner = |m: &rs274::Move| matches!(m.kind, MoveKind::Arc { centre, .. } if (centre[0] - 15.0).hypot(centre[1] - 5.0) < 1e-9);
    assert_eq!(program.moves.iter().filter(|m| at_corner(m)).count(), 1, "{:?}", program.moves);
    assert!(refused("G1X10.,R2.F100\nM30", &fanuc()).contains("right behind its own: `,R2.`"));
    assert!(refused("G1X10.,R2.F100\nG0Y5.\nM30", &fanuc()).contains("right behind its own"));
    assert!(refused("G1X10.,R20.F100\nY5.\nM30", &fanuc()).contains("longer than one of its two moves"));
    assert!(refused("G1X10.,R2.F100\nX20.\nM30", &fanuc()).contains("straight on"));
}

#[test]
fn a_lathes_c_without_a_comma_may_be_a_chamfer() {
    let haas = Setup { dialect: Dialect::Haas, ..lathe() };
    for (block, expected) in [
        ("G1Z-20.C2.F0.1", 1),
        ("G1X30.C2.F0.1", 1),
        ("G1U-2.C2.F0.1", 1),
        ("G1W-2.C2.F0.1", 1),
        // An axis for sure.
        ("M5\nG98G1Z-20.C2.F100.", 0),
        ("G1X30.Z-20.C2.F0.1", 0),
        ("G98G1C2.F100.", 0),
        ("G0Z-20.C2.F0.1", 0),
        ("G1Z-20.,C2.F0.1", 0),
    ] {
        for setup in [lathe(), haas.clone()] {
            let program = run(&format!("G21S100M3G0X20.Z0\n{block}\nG1X40.\nM30"), &setup);
            let unknown: Vec<_> = program.notes.iter().filter(|note| note.is_unknown).collect();
            assert_eq!(unknown.len(), expected, "{block}: {unknown:?}");
            assert!(unknown.iter().all(|note| note.line == 2 && note.text.contains("`,C`")), "{unknown:?}");
        }
    }
    assert!(run("S100M3\nG1Z-20.C2.F0.1\nM30", &fanuc()).notes.iter().all(|note| !note.is_unknown));
}

#[test]
fn cycles_return_to_where_they_began_and_dwell_in_milliseconds() {
    let program = run("G0Z5.\nG82X1.Z-1.R1.P500F100\nX2.K0\nX3.\nG80\nX9.\nM30", &fanuc());
    let told: Vec<_> = program.moves.iter().map(|m| (m.kind, m.end[Axis::X], m.end[Axis::Z])).collect();
    let (rapid, feed, dwell) = (MoveKind::Rapid, MoveKind::Feed, MoveKind::Dwell { seconds: 0.5 });
    let hole = |x| [(rapid, x, 5.0), (rapid, x, 1.0), (feed, x, -1.0), (dwell, x, -1.0), (rapid, x, 5.0)];
    let expected: Vec<_> =
        [(rapid, 0.0, 5.0)].into_iter().chain(hole(1.0)).chain(hole(3.0)).chain([(rapid, 9.0, 5.0)]).collect();
    assert_eq!(told, expected);
    // A tap feeds to R and goes on at rapid; G76 bores.
    let kinds =
        |source: &str| run(source, &fanuc()).moves.iter().skip(3).map(|m| (m.kind, m.end[Axis::Z])).collect::<Vec<_>>();
    assert_eq!(kinds("M3S1G0Z5.\nG84X1.Z-1.R1.F100\nM30"), [(feed, -1.0), (feed, 1.0), (rapid, 5.0)]);
    assert_eq!(kinds("M3S1G0Z5.\nG76X1.Z-1.R1.Q0.3F100\nM30"), [(feed, -1.0), (rapid, 5.0)]);
}

#[test]
fn what_moves_nothing_is_noted() {
    let program = run("%\n:1(PART)\n/1G21G0X1.\nG187P1E0.1\nG5.1Q1\nM31\nG64\nX2.M35\nDPRNT[X#1]\nM30\n%", &haas());
    assert_eq!(program.moves.len(), 2);
    let notes: Vec<String> = program.notes.iter().map(ToString::to_string).collect();
    // Of G187 and M31 everybody knows it.
    let expected =
        ["line 5: G5.1", "line 7: G64", "line 8: M35"].map(|code| format!("{code} is taken to move no axis"));
    assert_eq!(notes, expected);
    // A length without a decimal point may be another.
    let program = run("G21G0X100Y0Z1.\nX200\nM30", &fanuc());
    assert_eq!(program.notes.len(), 1);
    assert!(program.notes[0].to_string().starts_with("line 1: X has no decimal point") && program.notes[0].more == 1);
    // Block delete with a switch's number.
    let setup = Setup { block_delete: true, ..fanuc() };
    assert_eq!(ends(&run("/1G0X1.\nX2.\nM30", &setup)), [[2.0, 0.0, 0.0]]);
}

/// X and Z of every end, mm, and whether the machine gets there at rapid rate.
fn turned(source: &str) -> Vec<(f64, f64, bool)> {
    let round = |x: f64| (x * 1e6).round() / 1e6 + 0.0;
    let moves = run(source, &lathe()).moves;
    moves.iter().map(|m| (round(m.end[Axis::X]), round(m.end[Axis::Z]), m.kind == MoveKind::Rapid)).collect()
}

#[test]
fn single_cuts_of_a_lathe_hold_for_the_next_block() {
    // To diameter 40 at rapid, along, out, back; then the same at 38.
    assert_eq!(
        turned("S100M3G0X50.Z2.\nG90X40.Z-20.F0.2\nX38.\nG0X60.\nM30"),
        [
            (25.0, 2.0, true),
            (20.0, 2.0, true),
            (20.0, -20.0, false),
            (25.0, -20.0, false),
            (25.0, 2.0, true),
            (19.0, 2.0, true),
            (19.0, -20.0, false),
            (25.0, -20.0, false),
            (25.0, 2.0, true),
            (30.0, 2.0, true)
        ]
    );
    assert_eq!(
        turned("S100M3G0X50.Z2.\nG94X10.Z-1.F0.2\nM30")[1..],
        [(25.0, -1.0, true), (5.0, -1.0, false), (5.0, 2.0, false), (25.0, 2.0, true)]
    );
    // A thread with a taper: it begins 1 mm nearer to the axis.
    assert_eq!(
        turned("S100M3G0X50.Z2.\nG92X40.Z-20.R-1.F1.5\nM30")[1..],
        [(19.0, 2.0, true), (20.0, -20.0, false), (25.0, -20.0, true), (25.0, 2.0, true)]
    );
    assert!(refused("G0X50.Z2.\nG92X40.Z-20.F1.5\nM30", &lathe()).contains("spindle stands still"));
    // Haas calls the taper I, along Z K.
    let haas = Setup { dialect: Dialect::Haas, ..lathe() };
    for (code, letter) in [("G90", 'I'), ("G92", 'I'), ("G94", 'K')] {
        let source = |letter: char| format!("S100M3\nG0X50.Z2.\n{code}X40.Z-20.{letter}-1.F0.2\nX38.\nM30");
        assert_eq!(ends(&run(&source(letter), &haas)), ends(&run(&source('R'), &haas)), "{code}");
        assert!(refused(&source(letter), &lathe()).contains("no code of this block uses this word"), "{code}");
    }
    assert!(refused("S100M3\nG90X40.F0.2\nM30", &lathe()).contains("X and Z, where the cut ends"));
}

const CONTOUR: &str = "N10G0X10.\nG1Z-10.F0.1\nX20.Z-20.\nN20X30.\n";

#[test]
fn roughing_cuts_to_the_contour_and_finishing_follows_it() {
    // From diameter 30: cuts at 26, 22, 18, 14 with 2 mm each; the contour is 10 up to Z-10, then a cone up to 20 at Z-20, then 30.
    let source = format!("S100M3G0X30.Z2.\nG71U2.R1.\nG71P10Q20U0W0F0.2\n{CONTOUR}G70P10Q20\nG0X99.\nM30");
    let cut = |x: f64, z: f64| [(x, 2.0, true), (x, z, false), (x + 1.0, z + 1.0, true), (x + 1.0, 2.0, true)];
    let finish = [(5.0, 2.0, true), (5.0, -10.0, false), (10.0, -20.0, false), (15.0, -20.0, false), (15.0, 2.0, true)];
    let expected: Vec<_> = [(15.0, 2.0, true)]
        .into_iter()
        .chain(cut(13.0, -20.0))
        .chain(cut(11.0, -20.0))
        .chain(cut(9.0, -18.0))
        .chain(cut(7.0, -14.0))
        .chain([(15.0, 2.0, true)])
        .chain(finish)
        .chain(finish)
        .chain([(49.5, 2.0, true)])
        .collect();
    assert_eq!(turned(&source), expected);
    let program = run(&source, &lathe());
    // Roughing at its own feed, finishing at the contour's; each move at its own line.
    let told: Vec<_> =
        program.moves.iter().filter(|m| m.kind == MoveKind::Feed).map(|m| (m.line, m.feed_mm_min.unwrap())).collect();
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    assert!(
        told[..7].iter().all(|(_, feed)| near(*feed, 20.0)) && told[7..].iter().all(|(_, feed)| near(*feed, 10.0)),
        "{told:?}"
    );
    assert_eq!(told.iter().map(|t| t.0).collect::<Vec<_>>(), [3, 3, 3, 3, 5, 6, 7, 5, 6, 7]);
    // With allowances the last cut is further out, by half of U, and to the right, by W.
    let source = format!("S100M3G0X30.Z2.\nG71U5.R1.\nG71P10Q20U1.W0.5F0.2\n{CONTOUR}M30");
    assert_eq!(
        turned(&source)[5..],
        [
            (15.0, 2.0, true),
            (5.5, 2.5, true),
            (5.5, -9.5, false),
            (10.5, -19.5, false),
            (15.5, -19.5, false),
            (15.0, 2.0, true)
        ]
    );
}

#[test]
fn compensation_that_is_on_behind_a_finishing_cut_is_not_followed() {
    let nose = Tool { diameter_mm: 0.8, orientation: 2, ..Tool::default() };
    let setup = Setup { tools: [(1, nose)].into(), ..lathe() };
    let told = |off_in_contour: &str| {
        let contour = format!("N10G0X10.\nG1Z-10.F0.1\nN20{off_in_contour}X30.");
        let roughing = format!("G71U5.R1.\nG71P10Q20U0W0F0.2\n{contour}");
        let source = format!("T0101\nS100M3G0X40.Z5.\n{roughing}\nG42G0X32.Z3.\nG70P10Q20\nG1X35.\nM30");
        let is_told = |text: &str| text.starts_with("cutter compensation is on where G70 ends");
        run(&source, &setup).notes.iter().any(|note| note.is_unknown && is_told(&note.text))
    };
    assert!(told("") && !told("G40"));
}

#[test]
fn a_tool_in_a_contour_is_the_finishing_tool() {
    let source = |word: &str, then: &str| {
        let roughing = "T0101\nS100M3G0X30.Z2.\nG71U5.R1.\nG71P10Q20U0W0F0.2";
        format!("{roughing}\nN10G0X10.{word}\nG1Z-10.F0.1\nN20X30.\n{then}\nM30")
    };
    for setup in [lathe(), Setup { dialect: Dialect::Haas, ..lathe() }] {
        let changes = |then: &str| {
            let change = |kind: MoveKind| if let MoveKind::ToolChange { tool } = kind { Some(tool) } else { None };
            let moves = run(&source("T0212", then), &setup).moves;
            moves.iter().filter_map(|step| Some((step.line, change(step.kind)?))).collect::<Vec<_>>()
        };
        assert_eq!(ends(&run(&source("T0212", ""), &setup)), ends(&run(&source("", ""), &setup)));
        assert_eq!(changes(""), [(1, 1)]);
        assert_eq!(changes("T0212"), [(1, 1), (8, 2)]);
        assert_eq!(changes("G70P10Q20"), [(1, 1), (5, 2)]);
        let told = refused(&source("\nG52Z5.", ""), &setup);
        assert!(told.contains("another zero or tool offset inside the contour"), "{told}");
    }
}

#[test]
fn a_pattern_is_repeated_nearer_and_nearer() {
    let source = format!("S100M3G0X30.Z2.\nG73U4.W2.R3\nG73P10Q20U0W0F0.2\n{CONTOUR}M30");
    let pass = |x: f64, z: f64| {
        [
            (5.0 + x, 2.0 + z, true),
            (5.0 + x, -10.0 + z, false),
            (10.0 + x, -20.0 + z, false),
            (15.0 + x, -20.0 + z, false),
            (15.0, 2.0, true),
        ]
    };
    let expected: Vec<_> =
        [(15.0, 2.0, true)].into_iter().chain(pass(4.0, 2.0)).chain(pass(2.0, 1.0)).chain(pass(0.0, 0.0)).collect();
    assert_eq!(turned(&source), expected);
    // The same in one block, the only form of Haas's controls: I is a radius, D a number of passes.
    let in_one = |words: &str| source.replace("G73U4.W2.R3\nG73P10Q20", &format!("G73P10Q20{words}"));
    for setup in [lathe(), Setup { dialect: Dialect::Haas, ..lathe() }] {
        assert_eq!(ends(&run(&in_one("D3I4.K2."), &setup)), ends(&run(&source, &lathe())));
        for (words, why) in [
            ("I4.K2.", "D, the number of passes,"),
            ("D0I4.K2.", "the number of passes, from 1 to 9999"),
            ("R3", "no code of this block uses this word: `R3`"),
        ] {
            let told = refused(&in_one(words), &setup);
            assert!(told.starts_with("bad.nc:2:") && told.contains(why), "{words}: {told}");
        }
        // Beside G71 they are an allowance, which is not followed.
        for (words, expected) in [("I0.5", 1), ("K0.5", 1), ("I0.5K0.5", 1), ("I0K0", 0)] {
            let program = run(&in_one(&format!("D2.{words}")).replace("G73", "G71"), &setup);
            assert_eq!(program.notes.iter().filter(|note| note.is_unknown).count(), expected, "{words}");
        }
    }
}

#[test]
fn haas_calls_the_steps_of_pecks_by_i_and_k() {
    let ends = |dialect, source: &str| {
        let setup = Setup { dialect, ..lathe() };
        ends(&run(&format!("S100M3G0X20.Z0\n{source}\nM30"), &setup))
    };
    // Along X by 2 mm of radius, at Z0 and, 3 mm on, at Z-3.
    let by_counts = ends(Dialect::Fanuc, "G75X12.Z-3.P2000Q3000F0.1");
    assert_eq!(ends(Dialect::Haas, "G75X12.Z-3.I2.K3.F0.1"), by_counts);
    assert_eq!(by_counts[2], [8.0, 0.0, 0.0]);
    assert_eq!(by_counts.len(), 12);
}

#[test]
fn pecks_and_threads_of_a_lathe() {
    // Q2000 is 2 mm: to -2, back by 0.5, to -4, back, to -5, out.
    assert_eq!(
        turned("S100M3G0X0Z1.\nG74R0.5\nG74Z-5.Q2000F0.1\nM30")[1..],
        [
            (0.0, 1.0, true),
            (0.0, -1.0, false),
            (0.0, -0.5, true),
            (0.0, -3.0, false),
            (0.0, -2.5, true),
            (0.0, -5.0, false),
            (0.0, 1.0, true),
            (0.0, 1.0, true)
        ]
    );
    // R, the relief: nothing behind the first cut, then a step of 0.5 back towards the cut before.
    let relieved = "S100M3G0X40.Z2.\nG74X30.Z-5.P2500R0.5F0.1\nM30";
    let expected = [
        (20.0, 2.0, true),
        (20.0, -5.0, false),
        (20.0, 2.0, true),
        (17.5, 2.0, true),
        (17.5, -5.0, false),
        (18.0, -5.0, true),
        (18.0, 2.0, true),
        (15.0, 2.0, true),
        (15.0, -5.0, false),
        (15.5, -5.0, true),
        (15.5, 2.0, true),
        (20.0, 2.0, true),
    ];
    assert_eq!(turned(relieved)[1..], expected);
    assert_eq!(
        turned("S100M3G0X40.Z0\nG75X30.Z-3.P5000Q3000R0.5F0.1\nM30")[5..],
        [(15.0, -3.0, false), (15.0, -2.5, true), (20.0, -2.5, true), (20.0, 0.0, true)]
    );
    assert_eq!(turned(&relieved.replace("R0.5", "R0")).len(), 11);
    for words in ["Z-5.Q2000", "X30.Z-5."] {
        let source = format!("S100M3G0X40.Z2.\nG74{words}R0.5F0.1\nM30");
        assert!(
            refused(&source, &lathe()).contains("the relief at the bottom, in a cycle with a single cut"),
            "{source}"
        );
        turned(&source.replace("R0.5", "R0"));
    }
    // A thread 1 mm high with a first cut of 0.5: at 0.5, 0.707, 0.866, 1, and once more as P says.
    let cuts: Vec<f64> = turned("S100M3G0X30.Z5.\nG76P020060Q50R0\nG76X20.Z-20.P1000Q500F1.5\nM30")
        .into_iter()
        .filter(|step| !step.2)
        .map(|step| step.0)
        .collect();
    let expected = [10.5, 11.0 - 0.5 * 2_f64.sqrt(), 11.0 - 0.5 * 3_f64.sqrt(), 10.0, 10.0];
    assert!(cuts.len() == 5 && cuts.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{cuts:?}");
}

#[test]
fn depths_of_a_thread_without_a_point_count_thousandths() {
    let cuts = |set_up: &str, cut: &str| {
        let program = run(&format!("G21\nG97S100M3\nG0X30.Z5.\n{set_up}\nG76X20.Z-20.{cut}F1.5\nM30"), &lathe());
        assert!(!program.notes.iter().any(|note| note.text.contains("no decimal point")), "{:?}", program.notes);
        ends(&program)
    };
    let (last, first) = ("P010060Q100R0.05", "P1000Q400");
    assert_eq!(cuts(&format!("G76{}", last.replace("R0.05", "R50")), first), cuts(&format!("G76{last}"), first));
    assert_eq!(cuts("", "K1.D400"), cuts("", "K1.D0.4"));
}

#[test]
fn a_cycle_that_begins_at_its_r_does_not_begin_below_it() {
    let is_told = |height: &str| {
        let tools = [(1, Tool::with_length(123.456, 6.0))].into();
        let source = format!("G20G90G54\nT1M6\nG43H1\nG0X0Y0Z{height}\nG98G81X0Y0Z-1.R.1F10.\nX1.\nM30");
        run(&source, &Setup { tools, ..fanuc() }).notes.iter().any(|note| note.text.contains("begins below its R"))
    };
    assert!(!is_told(".1") && is_told(".0999"));
}

#[test]
fn beside_k_p_of_a_thread_is_the_cutting_method() {
    let cuts = |method: &str, dialect| {
        let source = format!("G97S100M3\nG0X30.Z5.\nG76X20.Z-20.K1.D0.4{method}F1.5\nM30");
        let moves = run(&source, &Setup { dialect, ..lathe() }).moves;
        let fed = moves.iter().filter(|step| step.kind == MoveKind::Feed).map(|step| 11.0 - step.end[Axis::X]);
        fed.map(|depth| (depth * 1e3).round()).collect::<Vec<_>>()
    };
    for dialect in [Dialect::Haas, Dialect::Fanuc] {
        let by_area = [400.0, 566.0, 693.0, 800.0, 894.0, 980.0, 1000.0];
        for (method, expected) in [("", &by_area[..]), ("P2", &by_area[..]), ("P3", &[400.0, 800.0, 1000.0][..])] {
            assert_eq!(cuts(method, dialect), expected, "{method}");
        }
    }
}

#[test]
fn fanucs_r_of_an_arc_takes_precedence() {
    let source = "G0X10.Y0\nG17G2X0Y10.I-10.J0R10.F100.\nM30";
    let MoveKind::Arc { centre, sweep, .. } = run(source, &fanuc()).moves[1].kind else { panic!("no arc") };
    assert!((centre[0] - 10.0).hypot(centre[1] - 10.0) < 1e-9 && (sweep + FRAC_PI_2).abs() < 1e-9, "{centre:?}");
    assert!(refused(source, &haas()).contains("no code of this block uses this word"));
}

#[test]
fn contours_have_bounds_and_their_errors_their_lines() {
    let start = "S100M3G0X30.Z2.\nG71U2.R1.\n";
    assert!(
        refused(&format!("{start}G71P10Q20F0.2\nM30"), &lathe())
            .contains("bad.nc:3:4: there is no line with this number N: `P10`")
    );
    assert!(
        refused(&format!("{start}G71P10Q20F0.2\nN10G1X10.F0.1\nN20GOTO10\nM30"), &lathe())
            .contains("a jump or an end inside")
    );
    assert!(
        refused(&format!("{start}G71P10Q20F0.2\nN10G1X10.F0.1\nN20G71P10Q20\nM30"), &lathe())
            .contains("inside a cycle's contour")
    );
    assert!(
        refused("S100M3G0X30.Z2.\nG71P10Q20F0.2\nN10G0X10.\nN20G1Z-5.F0.1\nM30", &lathe()).contains("the depth of cut")
    );
    assert!(
        refused(&format!("S100M3G0X30.Z2.\nG71U0.0001\nG71P10Q20F0.2\n{CONTOUR}M30"), &lathe())
            .contains("more than 10000 cuts")
    );
    // Cycles in an endless loop count the lines of their contours.
    let setup = Setup { limits: Limits { blocks: 1000, ..Limits::default() }, ..lathe() };
    assert!(refused(&format!("{start}DO1\nG71P10Q20F0.2\n{CONTOUR}END1"), &setup).contains("more than 1000 blocks"));
}

#[test]
fn a_contours_numbers_stand_on_one_line_of_the_program() {
    let first = format!("S100M3G0X30.Z2.\nG71U2.R1.\nG71P10Q20F0.2\n{CONTOUR}G70P10Q20\n");
    let second = "G71P10Q20F0.2\nN10G0X12.\nG1Z-5.F0.1\nN20X30.\n";
    let only_last = second.replace("10Q20", "30Q20").replace("N10", "N30");
    for (second, place) in [(second, "bad.nc:3:4:"), (&only_last, "bad.nc:3:7:")] {
        let told = refused(&format!("{first}{second}M30"), &lathe());
        let why = "more than one line of this program has this number N";
        assert!(told.starts_with(place) && told.contains(why), "{told}");
    }
    let renumbered = only_last.replace("Q20", "Q40").replace("N20", "N40");
    run(&format!("{first}{renumbered}G70P30Q40\nM30"), &lathe());
    // Another program has numbers of its own.
    run(&format!("{first}M98P2\nM30\nO2\n{second}M99"), &lathe());
}

#[test]
fn a_feed_rate_is_that_of_all_axes_together() {
    for (source, minutes) in [
        ("G91 G1 X20. B40. F300.", 20_f64.hypot(40.0) / 300.0),
        ("G20\nG91 G1 X2. B40. F30.", 2_f64.hypot(40.0) / 30.0),
        ("G91 G1 Z3. W4. F10.", 0.5),
        ("G91 G1 B40. F40.", 1.0),
        ("G91 G93 G1 X20. B40. F2.", 0.5),
    ] {
        let program = run(&format!("{source}\nM30"), &fanuc());
        let step = &program.moves[0];
        let found = rs274::path::length(&Position::default(), step) / step.feed_mm_min.unwrap();
        assert!((found - minutes).abs() < 1e-9, "{source}: {found}");
    }
}
