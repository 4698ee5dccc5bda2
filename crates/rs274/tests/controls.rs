//! Where controls differ from what one might expect: each case failed once. Expectations are worked out by hand beside the programs.

mod support;

use rs274::{Axis, Dialect, Kinematics, MoveKind, Position, Setup, TipKinematics, Tool, UserCode, interpret};
use std::sync::Arc;
use support::{assert_ends, assert_near, assert_refused, ends, fanuc, haas, linuxcnc, points, refused, run};

fn lathe() -> Setup {
    let tool = |x, z, nose, orientation| Tool {
        offset: Position([x, 0.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        diameter_mm: nose,
        orientation,
    };
    let tools = [(1, tool(1.0, 2.0, 0.8, 3)), (12, tool(0.0, 5.0, 1.6, 2))].into();
    Setup { dialect: Dialect::Fanuc, tools, ..Setup::lathe() }
}

fn assert_end(source: &str, setup: &Setup, expected: [f64; 3]) {
    assert_near(*ends(&run(source, setup)).last().expect("the program moves"), expected, source);
}

fn notes(source: &str, setup: &Setup) -> String {
    run(source, setup).notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// The notes on what the machine may do otherwise.
fn unknown(source: &str, setup: &Setup) -> String {
    let notes = run(source, setup).notes.into_iter().filter(|note| note.is_unknown);
    notes.map(|note| note.text).collect::<Vec<_>>().join("\n")
}

/// A table that A turns about the machine's X axis.
#[derive(Debug)]
struct TiltingTable;

impl TipKinematics for TiltingTable {
    fn tip(&self, axes: &Position, length_mm: f64) -> Result<Position, String> {
        let mut tip = *axes;
        tip[Axis::Z] -= length_mm;
        Ok(turned(&tip, axes[Axis::A]))
    }

    fn axes(&self, tip: &Position, length_mm: f64) -> Result<Position, String> {
        let mut axes = turned(tip, -tip[Axis::A]);
        axes[Axis::Z] += length_mm;
        Ok(axes)
    }

    fn orient(&self, _: [f64; 3], axes: &Position) -> Result<(Position, Option<Position>), String> {
        Ok((*axes, None))
    }

    fn turns_work(&self, axis: Axis) -> bool {
        axis == Axis::A
    }
}

/// Y and Z of a position turned by an angle about X.
fn turned(position: &Position, angle: f64) -> Position {
    let (sin, cos) = angle.sin_cos();
    let (y, z) = (position[Axis::Y], position[Axis::Z]);
    let mut turned = *position;
    (turned[Axis::Y], turned[Axis::Z]) = (y * cos - z * sin, y * sin + z * cos);
    turned
}

fn with_table(setup: Setup) -> Setup {
    Setup { kinematics: Some(Kinematics(Arc::new(TiltingTable))), ..setup }
}

#[test]
fn tip_control_that_begins_on_a_turned_table_is_told() {
    for (source, is_told) in [
        ("G0Z90.A30.\nG43.4H1", true),
        ("G43.4H1G0Z90.A30.", true),
        ("G0Z90.A30.\nG43.5H1A0.", true),
        ("G91G0Z90.A30.\nG90G43.4H1A30.", true),
        ("G43.4H1G0Z90.\nA30.", false),
        ("G0Z90.A360.B10.\nG43.4H1", false),
        ("G0Z90.A30.\nG43H1", false),
    ] {
        let has_note = |setup: Setup| {
            let program = run(&format!("{source}\nM30"), &with_table(setup));
            program.notes.iter().any(|note| note.is_unknown && note.text.contains("while the table is turned"))
        };
        assert_eq!(has_note(fanuc()), is_told, "{source}");
        assert!(!has_note(linuxcnc()), "{source}");
    }
}

/// LinuxCNC's control of a machine whose M428 and M429 switch the kinematics.
fn switched() -> Setup {
    let to_z = |z| Position([0.0, 0.0, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut tool_change = [None; 9];
    tool_change[Axis::Z as usize] = Some(500.0);
    let user_codes = [(428, UserCode::TipOn), (429, UserCode::TipOff)].into();
    Setup { start: to_z(400.0), home: to_z(500.0), tool_change, user_codes, ..with_table(linuxcnc()) }
}

/// The axes on the [`TiltingTable`] at the end of a program.
fn axes_after(source: &str, setup: &Setup) -> [f64; 3] {
    let program = run(source, setup);
    let last = program.moves.last().expect("the program moves");
    let axes =
        last.tip_mm.map_or(last.end, |length| TiltingTable.axes(&last.end, length).expect("the table reaches all"));
    [Axis::X, Axis::Y, Axis::Z].map(|axis| axes[axis])
}

#[test]
fn on_fanucs_and_haass_controls_g43_ends_tip_control() {
    // From (0, 0, 300) the axes turn where they stand.
    for (setup, on, is_told) in [(haas(), "G234H1", false), (haas(), "G43.4H1", false), (fanuc(), "G43.4H1", true)] {
        let setup = with_table(setup);
        for (off, z) in [("G43H1", 300.0), ("G43H2", 300.0), ("G44H2", 300.0), ("G43H1Z200.", 250.0)] {
            let source = format!("G0Z300.\n{on}\n{off}\nG0A30.\nM30");
            assert_near(axes_after(&source, &setup), [0.0, 0.0, z], &source);
            let told =
                run(&source, &setup).notes.iter().any(|note| note.is_unknown && note.text.contains("to end that"));
            assert_eq!(told, is_told, "{source}");
        }
        // The next step of Z ends by the change of the offset farther: 20 less.
        let source = format!("G0Z300.\n{on}\nG43H2\nG91G0Z10.\nM30");
        assert_near(axes_after(&source, &setup), [0.0, 0.0, 290.0], &source);
        // In a tilted plane the length is the tip's.
        let plane = "G68.2X0Y0Z0I0J0K0\nG43H1\nG43H1\nG0Z10.\nM30";
        assert!(run(plane, &setup).moves.iter().any(|step| step.is_tilted && step.tip_mm == Some(50.0)));
    }
}

#[test]
fn outputs_that_may_switch_the_kinematics_are_told() {
    let ignored = || Setup { ignored: ["M68".parse().unwrap()].into(), ..with_table(linuxcnc()) };
    for (source, setup, is_told) in [
        ("M68 E3 Q1\nM66 E0 L0\nG0 A30", with_table(linuxcnc()), true),
        ("M67 E3 Q1\nG1 A30 F100", with_table(linuxcnc()), true),
        ("G0 A30\nM68 E3 Q1\nG0 A0\nG0 X5", with_table(linuxcnc()), false),
        ("M68 E3 Q1\nG0 X5 A360", with_table(linuxcnc()), false),
        ("M62 P0\nG0 A30", with_table(linuxcnc()), false),
        ("M68 E3 Q1\nG0 A30", ignored(), false),
        ("M68 E3 Q1\nG0 A30", linuxcnc(), false),
    ] {
        let program = run(&format!("{source}\nM2"), &setup);
        let told = program.notes.iter().any(|note| note.is_unknown && note.text.contains("`motion.switchkins-type`"));
        assert_eq!(told, is_told, "{source}");
    }
}

#[test]
fn a_work_offset_that_turns_the_table_is_told_while_the_tip_is_led() {
    let with_offset = |axis: Axis, setup: Setup| {
        let mut setup = with_table(setup);
        setup.work_offsets[0].origin[axis] = std::f64::consts::FRAC_PI_2;
        setup
    };
    for (source, is_told) in [
        ("G43.4H1\nG0X5.Y0Z50.", true),
        ("G0A0.\nG43.4H1\nG0X5.Y0Z50.", true),
        ("G55G43.4H1\nG54\nG0X5.", true),
        ("G55G43.4H1\nG52A90.\nG0X5.", true),
        ("G68.2X0Y0Z0I0J0K0\nG0X5.", true),
        ("G55G43.4H1\nG0X5.", false),
        ("G0A0.\nG43H1\nG0X5.", false),
    ] {
        let has_note = |setup: &Setup| {
            let program = run(&format!("{source}\nM30"), setup);
            program.notes.iter().any(|note| note.is_unknown && note.text.contains("a work offset with a turned axis"))
        };
        assert_eq!(has_note(&with_offset(Axis::A, fanuc())), is_told, "{source}");
        assert_eq!(has_note(&with_offset(Axis::A, haas())), is_told, "{source}");
        // B turns no table.
        assert!(!has_note(&with_offset(Axis::B, haas())) || source.contains("G52"), "{source}");
    }
    // LinuxCNC's kinematics know the axes alone.
    let setup = Setup { user_codes: switched().user_codes, ..with_offset(Axis::A, linuxcnc()) };
    assert_eq!(notes("M428\nG0 X5 A0\nM2", &setup), "");
}

#[test]
fn a_turn_that_fanucs_tables_may_take_the_other_way_is_told() {
    let endless =
        |setup: Setup| Setup { endless: [false, false, false, false, false, true, false, false, false], ..setup };
    for (source, is_told) in [
        ("G0C20.\nC340.", true),
        ("G0C180.", true),
        ("G0C-90.", true),
        ("G1C1440.F100.", true),
        ("G0C170.\nC340.\nC510.\nG91G28C0.", true),
        ("G0C170.\nC340.\nG53C0.", true),
        ("G0C90.\nC250.\nC360.\nC250.\nC90.\nC0.", false),
        ("G91G0C340.\nC-720.", false),
        ("G0C170.\nG91G28C0.", false),
        ("G0A340.\nA-90.", false),
    ] {
        let told = |setup: Setup| {
            let notes = run(&format!("{source}\nM30"), &setup).notes;
            notes.iter().filter(|note| note.is_unknown && note.text.starts_with("C is sent to a place")).count()
        };
        assert_eq!(told(endless(fanuc())), usize::from(is_told), "{source}");
        assert_eq!([told(fanuc()), told(endless(haas())), told(endless(linuxcnc()))], [0; 3], "{source}");
    }
    // From hole to hole of a lathe.
    for (angle, is_told) in [(100, false), (200, true)] {
        let source = format!("G98G0X40.Z2.C10.\nG83Z-9.R-3.F100.\nC{angle}.\nG80\nM30");
        assert_eq!(notes(&source, &endless(lathe())).contains("C is sent to a place"), is_told, "{source}");
    }
}

#[test]
fn kinematics_that_an_m_code_has_switched_stay_until_another_does() {
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    // The tip at Z 400 without a tool offset, and 50 mm below Z 400.
    let (bare, with_tool) = ([0.0, 400.0 * sin, 400.0 * cos], [0.0, 350.0 * sin, 350.0 * cos + 50.0]);
    for (source, expected) in [
        ("M428\nG0 A30", bare),
        ("M428\nG17 G40 G49 G80\nG0 A30", bare),
        ("G43 H1\nM428\nG49\nG0 A30", bare),
        ("M428\nG49\nM429\nG0 A30", [0.0, 0.0, 400.0]),
        ("G43 H1\nM428\nG0 A30", with_tool),
        ("M428\nG43 H1\nG0 A30", with_tool),
        ("M428\nG43 H2\nG43 H1\nG0 A30", with_tool),
        ("M428\nG43.1 Z50\nG0 A30", with_tool),
    ] {
        assert_near(axes_after(&format!("{source}\nM2"), &switched()), expected, source);
        assert_eq!(notes(&format!("{source}\nM2"), &switched()), "", "{source}");
    }
    // Another length moves the axes while the table is turned, and only then.
    for (source, is_told) in [
        ("M428\nG0 A30\nG43 H1", true),
        ("G43 H1\nM428\nG0 A30\nG49", true),
        ("G43 H1\nM428\nG0 A30\nG43 H1", false),
        ("M428\nG0 A30\nG49", false),
        ("M428\nG0 A360\nG43 H1", false),
    ] {
        let program = run(&format!("{source}\nM2"), &switched());
        let told =
            program.notes.iter().any(|note| note.is_unknown && note.text.contains("may move X, Y and Z at once"));
        assert_eq!(told, is_told, "{source}");
    }
    assert_refused("M428\nG43.4 H1\nM2", &switched(), "2:1", "where the machine's own M code has switched");
    assert_refused("M428\nG49\nG68.2\nM2", &switched(), "3:1", "a tilted plane under tool-centre-point control");
    // On Fanuc's controls G49 ends it.
    let fanuc = Setup { dialect: Dialect::Fanuc, ..switched() };
    assert_near(axes_after("M428\nG49\nG0A30.\nM30", &fanuc), [0.0, 0.0, 400.0], "on Fanuc's");
}

#[test]
fn machine_coordinates_are_world_coordinates_while_kinematics_are_switched() {
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    let at = |world: f64| [0.0, (world - 50.0) * sin, (world - 50.0) * cos + 50.0];
    for (source, expected) in [
        ("G0 Z450", at(500.0)),
        ("G53 G0 Z500", at(500.0)),
        ("G53 G1 Z500 F100", at(500.0)),
        ("G91 G28 Z0", at(500.0)),
        ("T2 M6", at(500.0)),
        ("G30.1\nG0 Z0\nG30", at(400.0)),
        ("#1=#<_abs_z>\nG53 G0 Z[#1+100]", at(500.0)),
        ("G53 G0 A0", [0.0, 0.0, 400.0]),
        ("M429\nG53 G0 Z500", [0.0, 350.0 * sin, 500.0]),
    ] {
        let program = format!("G43 H1\nM428\nG0 A30\n{source}\nM2");
        assert_near(axes_after(&program, &switched()), expected, source);
    }
    // The whole length is found by touching off: the next length is 400.
    let touched = "G43 H1\nM428\nG10 L10 P1 Z0\nG43 H1\nG0 Z10\nM2";
    assert_near(axes_after(touched, &switched()), [0.0, 0.0, 410.0], "touched off");
}

#[test]
fn a_move_that_fails_under_cutter_compensation_is_no_corner() {
    // The arc ends too far out; the line behind it must not look for what it was to join.
    let source = "G41.1 D2 G1 X10 F100\nG3 X10 Y3000000000 J1500000000\nG1 X10 Y0\nM2";
    let told = refused(source, &linuxcnc());
    assert!(told.starts_with("bad.nc:2:1: an axis farther than 1e9 from zero"), "{told}");
}

#[test]
fn fanucs_cycles_go_to_the_hole_at_the_height_where_they_are() {
    for setup in [fanuc(), haas()] {
        // From Z 1 below R 2: over at 1, up to 2, down. With G99 the next begins at 2; with G98 it comes back to 1.
        assert_ends(
            "G0Z1.\nG99G81X5.Z-1.R2.F50\nX7.\nM30",
            &setup,
            &points("0 0 1, 5 0 1, 5 0 2, 5 0 -1, 5 0 2, 7 0 2, 7 0 -1, 7 0 2"),
        );
        let below = "G0Z1.\nG98G81X5.Z-1.R2.F50\nM30";
        assert_end(below, &setup, [5.0, 0.0, 1.0]);
        assert!(notes(below, &setup).contains("line 2: a cycle begins below its R"));
        assert_eq!(notes("G0Z5.\nG98G81X5.Z-1.R2.F50\nM30", &setup), "");
        // Behind G99 the next hole is reached at R, whatever R is there.
        assert_ends(
            "G0Z10.\nG99G81X1.Z-1.R1.F50\nX2.R4.\nM30",
            &setup,
            &points("0 0 10, 1 0 10, 1 0 1, 1 0 -1, 1 0 1, 2 0 1, 2 0 4, 2 0 -1, 2 0 4"),
        );
    }
}

#[test]
fn fanucs_cycles_hold_heights() {
    // R 2 and the bottom at -5 stay where they are when G91 follows; a new depth counts from the R that holds.
    let second = |source: &str, [x, y, retract]: [f64; 3], bottom: f64| {
        for setup in [fanuc(), haas()] {
            let found = ends(&run(source, &setup));
            let expected = [[x, y, bottom], [x, y, retract]];
            assert_eq!(found.len(), 8, "{source}: {found:?}");
            found[6..].iter().zip(expected).for_each(|(found, expected)| assert_near(*found, expected, source));
        }
    };
    let first = "G0Z12.\nG99G81X1.Z-5.R2.F50\n";
    second(&format!("{first}G91Y10.\nM30"), [1.0, 10.0, 2.0], -5.0);
    second(&format!("{first}G91Y10.Z-3.\nM30"), [1.0, 10.0, 2.0], -1.0);
    // Steps become heights, too, and stay them in G90: R at 12 - 10, the bottom 7 below.
    second("G0Z12.\nG91G99G81X1.Z-7.R-10.F50\nG90X9.\nM30", [9.0, 0.0, 2.0], -5.0);
    // LinuxCNC reads the numbers again: R 2 above the 12, the bottom 5 below R.
    assert_end("G0 Z12\nG99 G81 X1 Z-5 R2 F50\nG91 Y10\nM2", &linuxcnc(), [1.0, 10.0, 14.0]);
}

#[test]
fn linuxcncs_cycles_go_to_the_hole_where_the_cycle_ends() {
    // From R under G99 to G98: straight to the first height above the second hole, and down.
    assert_ends(
        "G0 Z10\nG99 G81 X1 Z-1 R2 F50\nG98 X5\nM2",
        &linuxcnc(),
        &points("0 0 10, 1 0 10, 1 0 2, 1 0 -1, 1 0 2, 5 0 10, 5 0 2, 5 0 -1, 5 0 10"),
    );
    // Below a new R, but the first height was above it: straight there.
    assert_ends(
        "G0 Z10\nG99 G81 X1 Z-1 R1 F50\nX2 R4\nM2",
        &linuxcnc(),
        &points("0 0 10, 1 0 10, 1 0 1, 1 0 -1, 1 0 1, 2 0 4, 2 0 -1, 2 0 4"),
    );
    // The first height was below both R: down to the lower one before the way over.
    assert_ends(
        "G0 Z1\nG99 G81 X1 Z-1 R20 F50\nX5 R5\nM2",
        &linuxcnc(),
        &points("0 0 1, 0 0 20, 1 0 20, 1 0 -1, 1 0 20, 1 0 5, 5 0 5, 5 0 -1, 5 0 5"),
    );
}

#[test]
fn a_subprogram_must_end() {
    // In the program: the body would run on into the next one.
    assert_refused("M98P1\nM30\nO1\nG0X1.\nO2\nG0X2.\nM99", &fanuc(), "5:1", "not ended by M99: `O2`");
    assert_refused("M98P1\nG0X9.\nM30\nO1\nG0X1.", &fanuc(), "6:1", "not ended by M99");
    assert_refused("M98 P1\nG0 X9\nM2\nO1\nG0 X1", &linuxcnc(), "6:1", "not ended by M99");
    // The main program, too; but it may begin again.
    assert_refused("O1\nG0X1.\nO2\nG0X2.\nM30", &fanuc(), "3:1", "not ended by M30, M2 or M99: `O2`");
    assert_ends("(PART)\nO1\nG0X1.\nM99\nO2\nG0X9.\nM99", &haas(), &[[1.0, 0.0, 0.0]; 2]);
    // In a file of its own: everything would end with it.
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("main.nc");
    std::fs::write(folder.path().join("O1000.nc"), "%\nO1000\nG0X4.\n%\n").unwrap();
    let told = interpret("M98P1000\nX5.\nM30", &main, &fanuc()).unwrap_err();
    assert!(told.file.ends_with("O1000.nc") && told.to_string().contains("not ended by M99"), "{told}");
    // M30 ends a program wherever it stands.
    assert_ends("M98P1\nG0X9.\nM30\nO1\nG0X1.\nM30", &fanuc(), &[[1.0, 0.0, 0.0]]);
}

#[test]
fn a_program_stands_between_its_percent_signs() {
    assert_ends("PART 12-B, CUSTOMER X\n%\nO1\nG0X1.\nM30\n%", &fanuc(), &[[1.0, 0.0, 0.0]]);
    assert_eq!(run("(PART)\n%\nO1\nG0X1.\nM30\n%", &fanuc()).moves[0].line, 4);
    assert_ends("G0X1.\nM30\n%\n(END)\n", &fanuc(), &[[1.0, 0.0, 0.0]]);
    assert_refused("G0X1.\nM30\n%\nG0X2.\nM30\n%", &fanuc(), "3:1", "codes stand on both sides");
    assert_refused("G0 X1\n%\nG0 X2\nM2", &linuxcnc(), "2:1", "which ends the program");
    assert_ends("%\nG0 X1\n%\nG0 X2\n", &linuxcnc(), &[[1.0, 0.0, 0.0]]);
}

#[test]
fn what_stands_beside_a_programs_number_is_obeyed() {
    assert_ends("O1000 #1=5.\nG0X#1\nM30", &fanuc(), &[[5.0, 0.0, 0.0]]);
    assert_ends("O1 IF[#1EQ#0]GOTO5\nG0X9.\nN5X1.\nM30", &fanuc(), &[[1.0, 0.0, 0.0]]);
    assert_ends("M98P7\nM30\nO7 #2=3.\nG0X#2\nM99", &fanuc(), &[[3.0, 0.0, 0.0]]);
}

#[test]
fn axis_words_of_codes_that_move_nothing_are_no_move() {
    for block in ["G5.1Q2X0Y0Z0", "G5P10000X0Y0", "G22X5.Y5.Z5.I0J0K0"] {
        let source = format!("G0X1.Y2.\n{block}\nM30");
        assert_ends(&source, &fanuc(), &[[1.0, 2.0, 0.0]]);
        assert!(notes(&source, &fanuc()).contains("are taken to move no axis"), "{source}");
    }
    assert_refused("G5.1Q1G0X5.\nM30", &fanuc(), "1:7", "another code beside axis words");
    // The words of others are not swallowed with those of a noted code.
    assert_refused("G0X1.\nL2Z5.M88\nM30", &fanuc(), "2:1", "no code of this block uses this word");
    assert_ends("G0X1.\nM31P1\nG187P1E0.1\nG103P1\nM30", &haas(), &[[1.0, 0.0, 0.0]]);
}

#[test]
fn ignoring_a_code_leaves_the_words_of_the_others() {
    let ignoring = |name: &str, setup: Setup| Setup { ignored: [name.parse().unwrap()].into(), ..setup };
    // Z alone goes home, not all axes.
    let setup = ignoring("G64", linuxcnc());
    assert_ends("G0 X1 Z5\nG64 G91 G28 Z0\nM2", &setup, &[[1.0, 0.0, 5.0], [1.0, 0.0, 5.0], [1.0, 0.0, 0.0]]);
    assert_ends("G0 X1\nG64 G53 G0 X2\nM2", &setup, &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let program = run("T1 G64 M6\nM2", &setup);
    assert_eq!(program.moves[0].kind, MoveKind::ToolChange { tool: 1 });
    // Nothing tells whether X is of G10 or of G0 before.
    let setup = ignoring("G10", linuxcnc());
    assert_refused("G0 X1\nG10 L2 P1 X5 M8\nM2", &setup, "2:11", "nothing tells whose they are");
}

#[test]
fn numbers_of_offsets_hold_on_fanucs_mills() {
    // H holds, H0 adds nothing, and the tool in the spindle does not matter.
    assert_end("T2M6\nG43H1G0Z1.\nG49\nG43Z1.\nM30", &fanuc(), [0.0, 0.0, 51.0]);
    assert_end("T2M6\nG43H0G0Z1.\nM30", &haas(), [0.0, 0.0, 1.0]);
    assert_end("H1\nG43G0Z1.\nM30", &haas(), [0.0, 0.0, 51.0]);
    assert_refused("T2M6\nG43G0Z1.\nM30", &fanuc(), "2:1", "H, the number of the tool length offset, is missing");
    assert_refused("G43H1G0Z1.\nZ2.H2\nM30", &fanuc(), "2:4", "G43 H changes it");
    // D too: at D2 the tool's centre is 5 to the left, at D0 on the path.
    assert_end("G0Y-10.\nG41D2G1X0Y0F100\nY10.\nM30", &fanuc(), [-5.0, 10.0, 0.0]);
    assert_end("T2M6\nG0Y-10.\nG41D0G1X0Y0F100\nY10.\nM30", &fanuc(), [0.0, 10.0, 0.0]);
    assert_end("D2\nT1M6\nG0Y-10.\nG41G1X0Y0F100\nY10.\nM30", &haas(), [-5.0, 10.0, 0.0]);
    assert_refused("T2M6\nG41G1X10.F100\nM30", &haas(), "2:1", "D, the number of the radius offset, is missing");
}

#[test]
fn linuxcncs_h0_is_the_tool_in_the_spindle() {
    assert_end("T2 M6\nG43 H0\nG0 Z1\nM2", &linuxcnc(), [0.0, 0.0, 31.0]);
    let with_zero =
        Setup { tools: [(0, Tool::with_length(7.0, 0.0)), (2, Tool::with_length(30.0, 0.0))].into(), ..linuxcnc() };
    assert_end("T2 M6\nG43 H0\nG0 Z1\nM2", &with_zero, [0.0, 0.0, 31.0]);
}

#[test]
fn axis_words_beside_g28_1_are_a_move() {
    // From the stored place, in the mode that holds.
    let expected = [[1.0, 0.0, 0.0], [5.0, 2.0, 0.0], [1.0, 0.0, 0.0]];
    assert_ends("G0 X1\nG28.1 X5 Y2\nG28\nM2", &linuxcnc(), &expected);
    assert_ends("G0 X1\nG1 G30.1 X5 Y2 F100\nG30\nM2", &linuxcnc(), &expected);
    assert_refused("G28.1 X5\nM2", &linuxcnc(), "1:7", "no code of this block uses this word");
}

#[test]
fn axis_words_beside_g92_1_and_its_like_are_a_move() {
    // The shift is cancelled or restored first.
    let expected = [[5.0, 0.0, 0.0], [7.0, 0.0, 0.0], [8.0, 0.0, 0.0], [14.0, 0.0, 0.0]];
    assert_ends("G0 X5\nG92 X0\nG92.2 G0 X7\nG1 F100 G92.2 X8\nG92.3 X9\nM2", &linuxcnc(), &expected);
    assert_ends("G0 X5\nG92 X0\nG92.1 X7\nM2", &linuxcnc(), &expected[..2]);
    assert_refused("G92.1 X5\nM2", &linuxcnc(), "1:7", "no code of this block uses this word");
    assert_refused("G92 G0 X5\nM2", &linuxcnc(), "1:5", "another code of this block uses the axis words");
}

#[test]
fn haass_g28_cancels_the_tool_length() {
    let source = "G43H1G0Z100.\nG91G28Z0\nG90\nG0Z20.\nM30";
    assert_end(source, &haas(), [0.0, 0.0, 20.0]);
    assert_end(source, &fanuc(), [0.0, 0.0, 70.0]);
    assert_end("G43H1G0Z100.\nG91G30Z0\nG90\nG0Z20.\nM30", &haas(), [0.0, 0.0, 70.0]);
}

#[test]
fn a_length_that_fanucs_controls_cancel_at_home_is_told() {
    let told = |source: &str, setup: &Setup| {
        let source = format!("T1M6\nG90G54G0X0Y0\nG43H1Z100.\nG1Z-1.F100\nG0Z100.\n{source}\nM30");
        let notes = run(&source, &Setup { second_home: Some(Position::default()), ..setup.clone() }).notes;
        notes.iter().filter(|note| note.is_unknown).map(|note| note.line).collect::<Vec<_>>()
    };
    for (source, line) in [
        ("G91G28Z0\nM0\nG90G0X40.\nZ5.\nZ2.", 9),
        ("G91G30Z0\nG90G0Z5.", 7),
        ("G91G28\nG90G0Z5.", 7),
        ("G90G53Z300.\nG1Z5.", 7),
        ("G53Z300.\nX1.\nG81X2.Z-1.R5.", 8),
        ("G28Z100.\nG28Z100.", 7),
    ] {
        assert_eq!(told(source, &fanuc()), [line], "{source}");
        assert!(told(source, &haas()).is_empty(), "{source}");
    }
    for source in [
        // The next tool, the end, no length, the same length again.
        "G91G28Z0\nG28X0Y0\nT2M6\nG90G0X40.Y0\nG43H2Z5.\nZ2.",
        "G91G28Z0\nG90\nG0X40.\nG43H1Z5.",
        "G91G28Z0\nG90\nG0X40.\nH1Z5.",
        "G28G91Z0M5\nG49\nG90G0Z5.",
        "G0G49G53Z0\nZ5.",
        "G53Z0\nG53X0Y0\nG91G28Z0",
        "G91G28Z0\nG28Z0\nG0Z-1.",
        "G91G28X0Y0\nG90G0Z5.",
        "G53X0\nG0Z5.",
    ] {
        assert!(told(source, &fanuc()).is_empty(), "{source}");
    }
}

#[test]
fn words_of_g76_are_diameters_in_g7() {
    let cut = |mode: &str| {
        let source = format!("G18 G8 G97 S100 M3\nG0 X20 Z5\n{mode} G76 P1.5 Z-10 I-2 J0.6 K1.8\nM2");
        let moves = run(&source, &linuxcnc()).moves;
        moves.iter().filter(|step| step.kind == MoveKind::Feed).map(|step| step.end[Axis::X]).collect::<Vec<_>>()
    };
    let near = |found: &[f64], expected: [f64; 3]| {
        assert!(found.len() == 3 && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    };
    // The peak 1 below the drive line, passes of 0.3 to 0.9; in G8 twice that.
    near(&cut("G7"), [18.7, 18.4, 18.1]);
    near(&cut("G8"), [17.4, 16.8, 16.2]);
}

#[test]
fn haass_k_counts_no_holes() {
    assert_refused("G0Z5.\nG83X1.Z-1.R1.Q1.K3F100\nM30", &haas(), "2:17", "no code of this block uses this word");
    assert_eq!(run("G0Z5.\nG81G91X1.Z-2.R-4.L2F100\nM30", &haas()).moves.len(), 9);
    assert_eq!(run("G0Z5.\nG81G91X1.Z-2.R-4.K2F100\nM30", &fanuc()).moves.len(), 9);
}

#[test]
fn cycles_of_lathes_that_drill_along_x_are_refused() {
    for code in ["G87", "G88", "G89"] {
        let source = format!("M3S100G0X50.Z0\n{code}X40.R-2.P500F0.1\nM30");
        assert_refused(&source, &lathe(), "2:1", "which go along X");
    }
}

#[test]
fn places_that_nothing_has_set_are_told() {
    let named = |mut setup: Setup, source: &str, known: bool| {
        setup.known_offsets = [known; 9];
        let notes = run(source, &setup).notes;
        let about = |text| notes.iter().any(|note| note.is_unknown && note.text.contains(text));
        (about("the origin of G5"), about("G30 goes to zero"))
    };
    for (source, setup, expected) in [
        ("G55\nG0X1.\nM30", fanuc(), (true, false)),
        ("G59 G0 X0\nM2", linuxcnc(), (true, false)),
        ("G59.3 G81 X1 Z-2 R1 F100\nM2", linuxcnc(), (true, false)),
        ("G54.1P2\nG0X1.\nM30", fanuc(), (true, false)),
        ("G55\nG91G28Z0\nG53G90G0X0\nG54X1.\nM30", haas(), (false, false)),
        ("G55\nG10L2P2X0\nG0X1.\nM30", fanuc(), (false, false)),
        ("#5242=0\nG55\nG0X1.\nM30", haas(), (false, false)),
        ("G10 L20 P2 X0\nG55 G0 X1\nM2", linuxcnc(), (false, false)),
        ("G0X1.\nM30", fanuc(), (false, false)),
        ("G91G30Z0\nM30", fanuc(), (false, true)),
        ("G30.1\nG30\nM2", linuxcnc(), (false, false)),
        ("#5183=0\nG30\nM2", linuxcnc(), (false, false)),
    ] {
        assert_eq!(named(setup, source, false), expected, "{source}");
    }
    assert_eq!(named(linuxcnc(), "G59.3 G0 X1\nM2", true), (false, false));
    let parameters = [("5241".to_owned(), 0.0)].into();
    assert_eq!(named(Setup { parameters, ..linuxcnc() }, "G55 G0 X1\nM2", false), (false, false));
    assert_eq!(named(Setup { second_home: Some(Position::default()), ..fanuc() }, "G30\nM30", false), (false, false));
}

#[test]
fn a_program_tells_its_first_zero_and_its_last_tool_table() {
    // At 0 the program reads -5 and shall read 1: its zero is at -1.
    let first = run("G10 L2 P1 X5\nG92 X1\nG1 X2 F100\nG92.1 X3\nM2", &linuxcnc()).first_zero;
    assert_eq!(first.map(|(line, zero)| (line, zero.origin[Axis::X])), Some((3, -1.0)));
    assert_eq!(run("G55 G1 X2 F100\nG54 G0 X1\nM2", &linuxcnc()).first_zero, None);
    let tools = [(1, Tool::with_length(50.0, 6.0))].into();
    let setup = Setup { tool: 1, tools, ..linuxcnc() };
    for source in ["G43.1 Z95\nG49", "G43 H1\nG43.2 Z45", "G10 L1 P1 Z95"] {
        assert_eq!(run(&format!("{source}\nM2"), &setup).tools[&1], Tool::with_length(95.0, 6.0), "{source}");
    }
}

#[test]
fn g87_of_fanucs_and_haass_mills_is_refused_by_name() {
    for setup in [fanuc(), haas()] {
        assert_refused("M3S100\nG0Z5.\nG87X1.Z-3.R-20.Q1.F50\nM30", &setup, "3:1", "G87 of Fanuc's controls");
    }
}

#[test]
fn the_nose_of_a_lathe_tool_is_that_of_its_offset() {
    // Along -Z with G42 the nose's centre is one radius outside. Offset 12: radius 0.8, the point moves are about one radius inside and one to
    // the left of the centre. Offset 1: radius 0.4, the point one radius outside and one to the left.
    let source = "T0112\nG0X40.Z-5.\nG42G1X20.Z-5.F1.S1M3\nZ-10.\nM30";
    assert_end(source, &lathe(), [10.0, 0.0, -5.0 - 0.8]);
    assert_end(&source.replace("T0112", "T0101"), &lathe(), [11.0 + 0.8, 0.0, -8.0 - 0.4]);
}

#[test]
fn g43_2_adds_axis_words() {
    assert_end("G43 H1\nG43.2 Z3 X2\nG0 X0 Z0\nM2", &linuxcnc(), [2.0, 0.0, 53.0]);
    assert_end("G43 H1\nG43.2 H2\nG0 Z0\nM2", &linuxcnc(), [0.0, 0.0, 80.0]);
    assert_refused("G43.2\nM2", &linuxcnc(), "1:1", "H or an axis word is missing");
    assert_refused("G43.2 H1 Z5\nM2", &linuxcnc(), "1:1", "both H and axis words");
    assert_end("G43.1 Z3\nG0 Z0\nM2", &linuxcnc(), [0.0, 0.0, 3.0]);
}

#[test]
fn in_g91_offsets_set_by_g10_add() {
    assert_end("G10L10P5R20.\nG91G10L10P5R0.5\nG90G43H5G0Z1.\nM30", &fanuc(), [0.0, 0.0, 21.5]);
    // L12 is a radius on Fanuc's controls and a diameter on Haas's.
    let source = "G10L12P5R4.\nG91G10L12P5R1.\nG90G0Y-10.\nG41D5G1X0Y0F100\nY10.\nM30";
    assert_end(source, &fanuc(), [-5.0, 10.0, 0.0]);
    assert_end(source, &haas(), [-2.5, 10.0, 0.0]);
    assert!(notes(source, &haas()).contains("Setting 40"));
}

#[test]
fn on_lathes_g10_sets_offsets_nose_and_tip() {
    let haas = Setup { dialect: Dialect::Haas, ..lathe() };
    // Offset 12 is 5 along Z. X and U are diameters, U and W add; what has no word stays.
    for (words, [x, z]) in
        [("R0.4", [30.0, 10.0]), ("X-8.Z3.", [26.0, 8.0]), ("U2.W1.", [31.0, 11.0]), ("Z3.R0.4Q3", [30.0, 8.0])]
    {
        for (code, setup) in [("G10L10P12", &haas), ("G10L10P12", &lathe()), ("G10P10012", &lathe())] {
            assert_end(&format!("{code}{words}\nT0112\nG0X60.Z5.\nM30"), setup, [x, 0.0, z]);
        }
    }
    // Fanuc's tips 3 and 2 are LinuxCNC's 2 and 3: see the test of the nose.
    let source = "T0112\nG0X40.Z-5.\nG42G1X20.Z-5.F1.S1M3\nZ-10.\nM30";
    assert_end(&format!("G10L10P12R0.8Q3\n{source}"), &lathe(), [10.0, 0.0, -5.0 - 0.8]);
    assert_end(&format!("G10L10P12R0.4Q2\n{source}"), &lathe(), [10.0 + 0.8, 0.0, -5.0 - 0.4]);
    for (source, setup, text) in [
        ("G10P12Z3.", &lathe(), "a wear offset other than 0"),
        ("G10L11P12U0.1", &haas, "a wear offset other than 0"),
        ("G10P10012Z3.", &haas, "L is missing"),
        ("G10P0Z3.", &lathe(), "the number of an offset"),
        ("G10L12P12R1.", &lathe(), "not supported"),
    ] {
        let told = refused(&format!("{source}\nM30"), setup);
        assert!(told.contains(text), "{source}: {told}");
    }
    assert_end("G10L11P12X0Z0R0\nT0112\nG0X60.Z5.\nM30", &lathe(), [30.0, 0.0, 10.0]);
}

#[test]
fn kept_modes_bring_the_tool_offset_back() {
    // LinuxCNC executes G43 and G49 where they differ; G43 is then that of the tool in the spindle.
    assert_end("T2 M6\nG43 H1\nM70\nG49\nG0 Z0\nM72\nG0 Z1\nM2", &linuxcnc(), [0.0, 0.0, 31.0]);
    assert_end("M70\nG43 H1\nG0 Z0\nM72\nG0 Z1\nM2", &linuxcnc(), [0.0, 0.0, 1.0]);
    assert_end("o<in> sub\nM73\nG43 H1\no<in> endsub\no<in> call\nG0 Z1\nM2", &linuxcnc(), [0.0, 0.0, 1.0]);
    // F is executed, too: in inches, where the block that gave it was still one of mm.
    let moves = run("G20 F10\nG1 X1\nM70\nG21 F100\nM72\nX2\nM2", &linuxcnc()).moves;
    assert_eq!(moves.iter().map(|step| step.feed_mm_min).collect::<Vec<_>>(), [Some(10.0), Some(254.0)]);
    // Of two lengths the later stays.
    assert_end("G43 H1\nM70\nG43 H2\nM72\nG0 Z1\nM2", &linuxcnc(), [0.0, 0.0, 31.0]);
    assert_refused("M70\nG41.1 D2 G1 X10 F100\nM72\nM2", &linuxcnc(), "3:1", "where cutter compensation is another");
    assert_refused("M70\nG92 X5\nM72\nM2", &linuxcnc(), "3:1", "where G92 is another");
}

#[test]
fn a_call_that_fails_leaves_nothing_behind() {
    // Ten million failing calls in a loop ate the memory; the depth of calls shows that none is open.
    let limits = rs274::Limits { blocks: 5000, ..rs274::Limits::default() };
    let setup = Setup { limits, ..fanuc() };
    assert_refused("N1G65P9\nGOTO1", &setup, "1:6", "subroutine is not defined");
}

#[test]
fn and_or_xor_of_fanucs_macros_are_of_bits() {
    let x = |value: &str| run(&format!("#1=6\n#2=3\nG0X[{value}]\nM30"), &fanuc()).moves[0].end[Axis::X];
    assert_eq!([x("#1AND#2"), x("#1OR#2"), x("#1XOR#2")], [2.0, 7.0, 5.0]);
    // AND binds as *, OR as +: 1 + (6 AND 3), and from left to right (1 + 6) OR 8.
    assert_eq!([x("1+#1AND#2"), x("1+#1OR8"), x("8OR#1*2")], [3.0, 15.0, 12.0]);
    assert_eq!([x("-7MOD3"), x("7MOD-3")], [-1.0, 1.0]);
    // Conditions, each in its brackets.
    assert_ends("#1=1\nIF[[#1EQ1]AND[#2EQ#0]]GOTO5\nG0X9.\nN5G0X1.\nM30", &haas(), &[[1.0, 0.0, 0.0]]);
    assert_refused("IF[#1EQ1AND#2EQ2]GOTO5\nN5M30", &haas(), "1:9", "without brackets of its own");
    assert_refused("#1=1.5AND1\nM30", &fanuc(), "1:7", "not whole");
    // LinuxCNC's are of truth, and MOD is never below zero.
    assert_end("G0 X[6 AND 3] Y[-7 MOD 3]\nM2", &linuxcnc(), [1.0, 2.0, 0.0]);
}

#[test]
fn fanucs_angles_are_not_below_zero() {
    for (value, on_fanuc, on_haas) in [
        ("ATAN[-1.]/[1.]", 315.0, -45.0),
        ("ATAN[-1.,-1.]", 225.0, -135.0),
        ("ASIN[-0.5]", 330.0, -30.0),
        ("ATAN[1.]/[-1.]", 135.0, 135.0),
        ("ATAN[-1.]", -45.0, -45.0),
        ("ASIN[0.5]", 30.0, 30.0),
        ("ACOS[-0.5]", 120.0, 120.0),
    ] {
        let source = format!("#1={value}\nG0X#1\nM30");
        assert_end(&source, &fanuc(), [on_fanuc, 0.0, 0.0]);
        assert_end(&source, &haas(), [on_haas, 0.0, 0.0]);
        let told = notes(&source, &fanuc());
        assert_eq!(told.starts_with("line 1: ATAN of two arguments"), on_fanuc != on_haas, "{value}: {told}");
        assert_eq!(notes(&source, &haas()), "", "{value}");
    }
    assert_end("G0 X[ATAN[-1]/[1]] Y[ASIN[-0.5]]\nM2", &linuxcnc(), [-45.0, -30.0, 0.0]);
}

#[test]
fn round_in_a_word_rounds_to_the_least_increment() {
    assert_end("#1=1.2346\nG0X[ROUND[#1]]\nM30", &fanuc(), [1.235, 0.0, 0.0]);
    assert_end("#1=1.23456\nG20G0X[ROUND[#1]]\nM30", &haas(), [1.2346 * 25.4, 0.0, 0.0]);
    // An assignment rounds to a whole number, and so does LinuxCNC anywhere.
    assert_end("#1=ROUND[1.2346]\nG0X#1\nM30", &fanuc(), [1.0, 0.0, 0.0]);
    assert_end("G0 X[ROUND[1.2346]]\nM2", &linuxcnc(), [1.0, 0.0, 0.0]);
    assert_refused("G65P1A[ROUND[1.5]]\nM30\nO1\nM99", &fanuc(), "1:6", "ROUND in an argument");
}

#[test]
fn g51_scales_the_centre_of_g68() {
    // The centre (1, 0) is at (2, 0); the point (3, 0) at (6, 0), turned to (2, 4).
    assert_end("G51X0Y0Z0P2000\nG68X1.Y0R90.\nG0X3.Y0\nM30", &fanuc(), [2.0, 4.0, 0.0]);
    // About the tool, which stays where it is.
    assert_end("G51X0Y0Z0P2000\nG0X3.Y1.\nG68R90.\nX3.Y1.\nM30", &fanuc(), [6.0, 2.0, 0.0]);
}

#[test]
fn no_ellipses_and_unscaled_pecks() {
    let arc = "G51X0Y0Z0I2.J1.K1.\nG0X10.Y0\nG3X0Y10.I-10.F100\nM30";
    assert_refused(arc, &fanuc(), "3:1", "trace no ellipse");
    // In the plane both axes are scaled alike.
    assert_eq!(run("G51X0Y0Z0I2.J2.K1.\nG0X10.Y0\nG3X0Y10.I-10.F100\nM30", &fanuc()).moves.len(), 2);
    // Scaled by 2: R at 2, the bottom at -10; pecks of 3 end at -1, -4 and -7.
    let source = "G51X0Y0Z0P2.\nG0Z10.\nG83X0Y0Z-5.R1.Q3.F100\nM30";
    let depths: Vec<f64> = run(source, &haas())
        .moves
        .iter()
        .filter(|step| step.kind == MoveKind::Feed)
        .map(|step| step.end[Axis::Z])
        .collect();
    assert_eq!(depths, [-1.0, -4.0, -7.0, -10.0]);
}

#[test]
fn a_polar_radius_in_g91_has_another_pole() {
    assert_refused("G16\nG0X10.Y0\nG91X5.\nM30", &fanuc(), "3:4", "whose pole is where the tool is");
    assert_end("G16\nG0X10.Y0\nG91Y90.\nM30", &fanuc(), [0.0, 10.0, 0.0]);
}

#[test]
fn g52_and_g92_shift_apart_on_fanucs_controls() {
    // G92 makes (0, 0) X5, so that zero is at -5; G52 shifts by 2 more, and its end leaves G92 alone.
    let source = "G92X5.\nG52X2.\nG0X0\nG52X0\nX0\nM30";
    assert_ends(source, &fanuc(), &[[-3.0, 0.0, 0.0], [-5.0, 0.0, 0.0]]);
    // G92 cancels G52 for the axes that it names.
    assert_ends("G52X2.Y3.\nG92X5.\nG0X0Y0\nM30", &haas(), &[[-5.0, 3.0, 0.0]]);
    assert_ends("G92 X5\nG52 X2\nG0 X0\nM2", &linuxcnc(), &[[2.0, 0.0, 0.0]]);
}

#[test]
fn g92_in_a_tilted_plane_sets_the_reading_and_moves_nothing() {
    // (1, 2, 3) in the plane is at (11, -3, 2): its Y is along Z, its Z along -Y.
    let plane = "G68.2 X10 Y0 Z0 I0 J90 K0\nG0 X1 Y2 Z3\n";
    assert_end(&format!("{plane}G92 X0 Y0 Z0\nG0 Y5\nM2"), &linuxcnc(), [11.0, -3.0, 7.0]);
    // X and Z read as before.
    assert_end(&format!("{plane}G92 Y0\nG0 X2 Y5 Z4\nM2"), &linuxcnc(), [12.0, -4.0, 7.0]);
}

#[test]
fn the_axes_place_is_to_be_had_while_the_tip_is_led() {
    // The axes stand where they stood before: at Z 150, turned by A or not.
    for (led, leaves) in
        [("G43H1", "G49"), ("G43.4H1", "G49"), ("G43H1\nG68.2X0Y0Z0I0J0K0", "G69\nG49"), ("A30.\nG43.4H1", "G49")]
    {
        let to = |setup: &Setup, code: &str, then: &str| {
            assert_end(
                &format!("G0X3.Y4.Z150.\n{led}\n{code}\n{leaves}\nG0X0Y0Z0\n{then}\nM30"),
                setup,
                [3.0, 4.0, 150.0],
            );
        };
        for setup in [with_table(fanuc()), with_table(haas())] {
            to(&setup, "#101=#5021\n#102=#5022\n#103=#5023", "G53G0X#101Y#102Z#103");
        }
        let setup = with_table(linuxcnc());
        to(&setup, "#1=#<_abs_x>\n#2=#<_abs_y>\n#3=#<_abs_z>", "G53 G0 X#1 Y#2 Z#3");
        to(&setup, "G28.1", "G28");
        to(&setup, "G30.1", "G30");
    }
    // Without the machine they are known while nothing is turned.
    assert_end("G43.4H1\nG0Z10.\n#101=#5023\nG49\nG53G0Z#101\nM30", &fanuc(), [0.0, 0.0, 60.0]);
    let why = "where the axes stand under tool-centre-point control while rotary axes";
    assert_refused("G43.4H1\nG0A30.\n#101=#5023\nM30", &fanuc(), "3:6", why);
    assert_refused("G43.4 H1\nG0 A30\n#1=#<_abs_z>\nM2", &linuxcnc(), "3:4", why);
    assert_end("G43.4H1\nG0A30.\n#101=#5024\nG0X#101\nM30", &fanuc(), [30.0, 0.0, -50.0]);
    assert_refused("G43.4 H1\nG0 A30\nG28.1\nM2", &linuxcnc(), "3:1", "[program.tool_centre_point]");
}

#[test]
fn a_tilted_plane_does_not_drop_a_turn_a_scale_or_a_mirror() {
    for setup in [fanuc(), haas()] {
        for (on, off) in [("G51.1X0", "G50.1"), ("G68X0Y0R90.", "G69"), ("G51X0Y0Z0P2.", "G50")] {
            let why = "a tilted plane in turned, scaled or mirrored coordinates";
            assert_refused(&format!("{on}\nG68.2X0Y0Z0I0J0K0\nM30"), &setup, "2:1", why);
            assert_end(&format!("{on}\n{off}\nG68.2X1.Y0Z0I0J0K0\nG0X5.\nM30"), &setup, [6.0, 0.0, 0.0]);
            let why = "turned, scaled or mirrored coordinates in a tilted plane";
            assert_refused(&format!("G68.2X0Y0Z0I0J0K0\n{on}\nM30"), &setup, "2:1", why);
        }
    }
}

#[test]
fn system_variables_take_effect_or_are_errors() {
    // The origin in force, in the program's units.
    assert_ends("G54G0X1.\n#5221=10.\nX1.\nM30", &fanuc(), &[[1.0, 0.0, 0.0], [11.0, 0.0, 0.0]]);
    assert_end("G20\n#5221=1.\nG0X1.\nM30", &haas(), [50.8, 0.0, 0.0]);
    assert_end("G20G10L2P1X1.\nG0X#5221\nM30", &haas(), [50.8, 0.0, 0.0]);
    assert_end("#7001=10.\nG54.1P1G0X1.\n#7001=20.\nX2.\nM30", &fanuc(), [22.0, 0.0, 0.0]);
    // P1 has two numbers; Haas's #7001 and on end at P20.
    for setup in [fanuc(), haas()] {
        assert_end("#14001=10.\nG54.1P1G0X1.\n#7001=20.\nX[#14001+2.]\nM30", &setup, [42.0, 0.0, 0.0]);
        assert_end("#14401=10.\nG54.1P21G0X1.\n#14401=20.\nX2.\nM30", &setup, [22.0, 0.0, 0.0]);
    }
    assert_end("#7401=10.\nG54.1P21G0X1.\nM30", &fanuc(), [11.0, 0.0, 0.0]);
    assert_refused("#7401=10.\nM30", &haas(), "1:1", "a system variable other than origins");
    let given = Setup { parameters: [("7001".to_owned(), 5.0)].into(), ..fanuc() };
    assert_end("G54.1P1G0X1.\nM30", &given, [6.0, 0.0, 0.0]);
    // Where a block ends has no offset in it; Fanuc's place has that of the tool, 50 long, and D2's radius of 5.
    for (source, variable, on_fanuc, on_haas) in [
        ("G43H1G0Z10.", 5003, 10.0, 10.0),
        ("G43H1G0Z10.", 5043, 60.0, 10.0),
        ("G55G43H1G0Z10.", 5043, 60.0, 10.0),
        ("G43.4H1\nG0Z10.", 5043, 60.0, 10.0),
        ("G52Z1.\nG43H1G0Z10.", 5043, 60.0, 10.0),
        ("G41D2G1X20.F100.", 5002, 0.0, 5.0),
        ("G41D2G1X20.F100.", 5042, 5.0, 5.0),
    ] {
        for (setup, expected) in [(fanuc(), on_fanuc), (haas(), on_haas)] {
            let source = format!("G10L2P2Z-7.\n{source}\n#1=#{variable}\nG40G49G0X0Y0Z0\nG54G52Z0\nG0X#1\nM30");
            let found = ends(&run(&source, &setup)).last().expect("the program moves")[0];
            assert!((found - expected).abs() < 1e-9, "{source}: {found}");
        }
    }
    for source in ["#5203=1.", "#2001=5.", "#11001=5.", "#4003=91", "#5001=0", "#3005=0", "#5230=45."] {
        let told = refused(&format!("{source}\nM30"), &fanuc());
        assert!(told.starts_with("bad.nc:1:1: "), "{source}: {told}");
    }
    assert_refused("G41D1G1X20.F100\n#5221=10.\nM30", &fanuc(), "2:1", "while cutter compensation is on");
    // Common variables hold what they are given.
    assert_end("#100=1.\n#500=2.\n#33=3.\nG0X#100Y#500Z#33\nM30", &fanuc(), [1.0, 2.0, 3.0]);
    assert_end("#10100=4.\nG0X#10100\nM30", &haas(), [4.0, 0.0, 0.0]);
}

#[test]
fn what_another_pallet_brings_in_is_not_known() {
    let source = "G0 X1\nM60\nX2\nM30";
    for code in ["M50", "M60"] {
        for setup in [haas(), fanuc()] {
            assert_refused(&source.replace("M60", code), &setup, "2:1", &format!("ignore it (`--ignore {code}`)"));
        }
    }
    let ignored = ["M60".parse().unwrap()].into();
    assert_end(source, &Setup { ignored, ..haas() }, [2.0, 0.0, 0.0]);
    let [note] = &run(source, &linuxcnc()).notes[..] else { panic!("one note") };
    assert!(note.is_unknown && note.to_string().starts_with("line 2: M60 changes the pallet"), "{note}");
}

#[test]
fn a_probed_place_is_in_the_programs_units() {
    assert_ends("G20 F10\nG38.2 X2\nG0 X0\nX#5061\nM2", &linuxcnc(), &[[50.8, 0.0, 0.0], [0.0; 3], [50.8, 0.0, 0.0]]);
    assert_ends("G20F10.\nG31X2.\nG0X0\nX#5061\nM30", &haas(), &[[50.8, 0.0, 0.0], [0.0; 3], [50.8, 0.0, 0.0]]);
    // Fanuc's holds the tool offset, Haas's does not.
    let probed = "G43H1G0Z5.\nG31Z-10.F100.\n#1=#5063\nG0X#1\nM30";
    assert_end(probed, &fanuc(), [40.0, 0.0, 40.0]);
    assert_end(probed, &haas(), [-10.0, 0.0, 40.0]);
    let source = "G98F10.\nG31X40.\nG0X0\nX#5061\nM30";
    assert_ends(source, &lathe(), &[[20.0, 0.0, 0.0], [0.0; 3], [20.0, 0.0, 0.0]]);
}

#[test]
fn what_a_probe_measures_is_not_known() {
    for (source, setup, stops) in [
        ("G31X10.F100\nX#5061\nG31X20.\nM30", haas(), false),
        ("G31X10.F100\nG31X20.\nM30", fanuc(), false),
        ("G38.2 X10 F100\nG38.4 X0\nM2", linuxcnc(), true),
        ("G38.3 X10 F100\nG38.5 X0\nM2", linuxcnc(), false),
    ] {
        let [note] = &run(source, &setup).notes[..] else { panic!("{source}: one note") };
        let told = note.to_string();
        assert!(note.is_unknown && told.starts_with("line 1: nothing stops a probe"), "{source}: {told}");
        assert!(told.ends_with("(and once more)") && told.contains("the control stops") == stops, "{source}: {told}");
    }
}

#[test]
fn a_step_behind_another_tool_offset_ends_by_the_change_further() {
    // From Z 100 by -10 and by the 50 of H1; the next step is one of 10.
    assert_ends(
        "G0Z100.\nG91G43Z-10.H1\nZ-10.\nG90Z0\nM30",
        &fanuc(),
        &[[0.0, 0.0, 100.0], [0.0, 0.0, 140.0], [0.0, 0.0, 130.0], [0.0, 0.0, 50.0]],
    );
    assert_ends("G43H1G0Z0\nG49\nG91X1.\nZ1.\nM30", &fanuc(), &[[0.0, 0.0, 50.0], [1.0, 0.0, 50.0], [1.0, 0.0, 1.0]]);
    // An absolute move has all of it.
    assert_end("G43H1\nG0Z10.\nG91Z1.\nM30", &haas(), [0.0, 0.0, 61.0]);
    assert_refused("G0Z20.\nG91G43H1\nG81Z-5.R-10.F100\nM30", &fanuc(), "3:1", "right behind another tool offset");
    // By way of where Z is, home, with a note; and the change is forgotten.
    let source = "G43H1G0Z0\nG49\nG91G28Z0\nZ-1.\nM30";
    assert_ends(source, &fanuc(), &[[0.0, 0.0, 50.0], [0.0, 0.0, 50.0], [0.0; 3], [0.0, 0.0, -1.0]]);
    assert!(notes(source, &fanuc()).contains("behind another tool offset"));
}

/// The geometry offset of a lathe's tool is a shift of the coordinates (5002#4 at 0), so that a step is as long as its number.
#[test]
fn a_step_behind_t_of_a_lathe_is_as_programmed_and_told() {
    let ends = [[10.0, 0.0, 0.0], [10.0, 0.0, 0.0], [12.0, 0.0, 0.0], [14.0, 0.0, 0.0]];
    for setup in [lathe(), Setup { dialect: Dialect::Haas, ..lathe() }] {
        for (source, is_told) in [
            ("G0X20.\nT0101\nU4.\nU4.\nM30", true),
            // To the diameter 22 of the program, which is 24 by the machine's: the offset counts.
            ("G0X20.\nT0101\nX23.\nU4.\nM30", false),
        ] {
            if is_told {
                assert_ends(source, &setup, &ends);
            } else {
                assert_ends(source, &setup, &[ends[0], ends[1], [12.5, 0.0, 0.0], [14.5, 0.0, 0.0]]);
            }
            assert_eq!(unknown(source, &setup).contains("behind a T with another offset"), is_told, "{source}");
        }
    }
}

#[test]
fn one_axis_behind_a_turn_is_told_where_the_number_of_the_other_has_changed() {
    // At X 10, Y 10; turned by 45 degrees the place is X 14.142, Y 0, of which X stays.
    for (source, is_told) in [
        ("G0X10.Y10.\nG68X0Y0R45.\nY14.142\nM30", true),
        ("G0X10.Y10.\nG68X0Y0R45.\nX1.Y14.142\nY1.\nM30", false),
        ("G0X10.Y10.\nG68X0Y0R45.\nZ1.\nG91X1.\nG90Y1.\nM30", true),
        ("G0X0Y0\nG68X0Y0R45.\nY14.142\nM30", false),
        ("G0X10.Y10.\nG68X0Y0R45.\nX1.Y1.\nG69\nX3.\nM30", true),
        ("G0X10.Y10.\nG69\nX3.\nM30", false),
        ("G0X10.Y10.Z5.\nG68X0Y0R45.\nG81Y9.Z-1.R2.F100.\nM30", true),
    ] {
        for setup in [fanuc(), haas()] {
            let told = unknown(source, &setup).contains("the first place behind G68 or G69");
            assert_eq!(told, is_told, "{source}");
        }
    }
}

#[test]
fn words_that_are_no_lengths_are_told_without_a_point_too() {
    for (source, setup, letter) in [
        ("G68X0Y0R45\nM30", fanuc(), 'R'),
        ("G65P1I5\nM30\nO1\nM99", fanuc(), 'I'),
        ("G65P1R5\nM30\nO1\nM99", haas(), 'R'),
        ("G68.2X0Y0Z0I0J30K0.\nG49\nM30", fanuc(), 'J'),
        ("G0Z5.\nG81Z-1.R2.F100.L0\nG70I9.J30L3\nM30", haas(), 'J'),
    ] {
        let has = |source: &str| notes(source, &setup).contains(&format!("{letter} has no decimal point"));
        assert!(has(source), "{source}: {}", notes(source, &setup));
        let source = source.replace("5\n", "5.\n").replace("30L", "30.L").replace("J30K", "J30.K");
        assert!(!has(&source), "{source}");
    }
}

#[test]
fn f_beside_g20_is_in_inches_on_fanucs_and_haas_controls() {
    let of = |setup: &Setup| run("G21G1F100.\nG20F10.\nG1X1.\nM30", setup).moves[0].feed_mm_min;
    assert_eq!([fanuc(), haas()].map(|setup| of(&setup)), [Some(254.0); 2]);
    assert_eq!(of(&Setup::default()), Some(10.0));
}

#[test]
fn a_program_behind_the_end_is_named() {
    for (source, named) in
        [("O1\nG0X1.\nM30\nO2\nG0X9.\nM30", true), ("O1\nM98P2\nM30\nO2\nG0X9.\nM99", false), ("O1\nG0X1.\nM30", false)]
    {
        assert_eq!(notes(source, &fanuc()).contains("another program, O2"), named, "{source}");
    }
}

#[test]
fn contours_in_files_are_told_by_the_line_that_calls() {
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("main.nc");
    let sub = "O1000\nG71U2.R1.\nG71P10Q20U0W0F0.2\nN10G0X10.\nN20G1Z-10.F0.1\nM99\n";
    std::fs::write(folder.path().join("O1000.nc"), sub).unwrap();
    let program = interpret("S100M3G0X20.Z2.\n\nM98P1000\nM30", &main, &lathe()).unwrap();
    let lines: Vec<u32> = program.moves[1..].iter().map(|step| step.line).collect();
    assert!(lines.len() > 4 && lines.iter().all(|&line| line == 3), "{lines:?}");
}

#[test]
fn words_without_a_decimal_point_are_told_or_counted() {
    let told = |source: &str| notes(&format!("G0X0Y0Z5.\n{source}\nM30"), &fanuc());
    for (source, letter) in
        [("A90", 'A'), ("G2X10.K5I5.F100G18", 'K'), ("G1X10.,R2F100\nY10.", 'R'), ("G1X10.,C2F100\nY10.", 'C')]
    {
        assert!(told(source).contains(&format!("line 2: {letter} has no decimal point")), "{source}: {}", told(source));
    }
    assert_eq!(told("G81X1.Z-1.R1.F100K2\nG5.1Q1\nM27"), "line 4: M27 is taken to move no axis");
    // The machine may go elsewhere.
    let unknown = unknown("G0X0Y0Z5.\nX10Y2.\nG1Y0F100.\nM30", &fanuc());
    assert!(unknown.starts_with("X has no decimal point") && unknown.lines().count() == 1, "{unknown}");
    // Fanuc counts pecks in thousandths; a variable and Haas's do not.
    let pecks =
        |source: &str, setup: &Setup| run(source, setup).moves.iter().filter(|m| m.kind == MoveKind::Feed).count();
    assert_eq!(pecks("G0Z5.\nG83X1.Z-8.R1.Q3000F100\nM30", &fanuc()), 3);
    assert_eq!(pecks("G0Z5.\n#1=3.\nG83X1.Z-8.R1.Q#1F100\nM30", &fanuc()), 3);
    assert_eq!(pecks("G0Z5.\nG83X1.Z-8.R1.Q3F100\nM30", &haas()), 3);
    assert!(notes("G0Z5.\nG83X1.Z-8.R1.Q3F100\nM30", &haas()).contains("line 2: Q has no decimal point"));
}

#[test]
fn fanucs_outside_corners_are_straight() {
    // D2: the centre is 5 to the right. Along +Y to (0, 10), to the left along -X: the corner at (5, 15) is met straight on.
    let start = "G0Y-20.\nG42D2G1Y0F100\nY10.\n";
    let corner = |next: &str, setup: &Setup| ends(&run(&format!("{start}{next}\nM30"), setup)).split_off(3);
    let near = |found: Vec<[f64; 3]>, expected: &[[f64; 2]]| {
        let same = found.iter().zip(expected).all(|(f, e)| (f[0] - e[0]).hypot(f[1] - e[1]) < 1e-9);
        assert!(found.len() == expected.len() && same, "{found:?}, expected {expected:?}");
    };
    near(corner("X-20.", &fanuc()), &[[5.0, 15.0], [-20.0, 15.0]]);
    assert!(
        run(&format!("{start}X-20.\nM30"), &fanuc())
            .moves
            .iter()
            .all(|step| matches!(step.kind, MoveKind::Feed | MoveKind::Rapid))
    );
    // By 135 degrees, back to (-10, 0): 5 on, 5 before, and from there on. The shifted line is 5 to the right of it: up and left.
    let s = 5.0 * 0.5_f64.sqrt();
    near(corner("X-10.Y0", &fanuc()), &[[5.0, 15.0], [0.0, 10.0 + 2.0 * s], [-10.0 - s, s]]);
    // Into an arc, from the corner along its tangent.
    near(corner("G3X-10.Y0R10.", &fanuc()), &[[5.0, 15.0], [0.0, 15.0], [-15.0, 0.0]]);
    // Haas's are rounded, with a note.
    assert_eq!(corner("X-20.", &haas()).len(), 2);
    assert!(notes(&format!("{start}X-20.\nM30"), &haas()).contains("0.42 radii farther"));
    assert!(
        run(&format!("{start}X-20.\nM30"), &haas()).moves.iter().any(|step| matches!(step.kind, MoveKind::Arc { .. }))
    );
}

#[test]
fn words_behind_a_semicolon_are_a_block_on_fanucs_controls() {
    for setup in [fanuc(), haas()] {
        assert_refused("G0X1.;G0Z-5.\nM30", &setup, "1:7", "stand behind `;`");
        assert_refused("G0X1.;X;Y2.\nM30", &setup, "1:9", "`Y2.`");
        assert_refused(";G0X1.\nM30", &setup, "1:2", "stand behind `;`");
        let source = "O1;\nG0X1.;MOVE TO X\nX2.(A;G0Z-5.);\n;(NEXT)\n;TOOL 1 D=10\nM30;";
        assert_ends(source, &setup, &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    }
    assert_ends("G0 X1 ; G0 Z-5\nM2", &linuxcnc(), &[[1.0, 0.0, 0.0]]);
}

#[test]
fn fanucs_lead_in_goes_to_the_start_of_the_next_element() {
    let inside = "G0X-20.Y10.\nG1G41D2X0F100.\nY50.\nM30";
    let at_z = |z: f64, y: f64| [-5.0, y, z];
    for setup in [fanuc(), haas()] {
        assert_ends(inside, &setup, &[[-20.0, 10.0, 0.0], at_z(0.0, 10.0), at_z(0.0, 50.0)]);
        // What stands between goes there, too.
        let down = inside.replace("Y50.", "Z-1.\nY50.");
        let expected = [[-20.0, 10.0, 0.0], at_z(0.0, 10.0), at_z(-1.0, 10.0), at_z(-1.0, 50.0)];
        assert_ends(&down, &setup, &expected);
        // Behind the first element corners are cut to where the shifted curves meet.
        assert_end("G0X-20.Y10.\nG1G41D2X0F100.\nY50.\nX-30.\nM30", &setup, [-30.0, 45.0, 0.0]);
        // Into a pocket by an arc that is narrower than two tools.
        let pocket = "G90G0X10.Y0\nG1G41D2Y-10.F100.\nG3X20.Y0R10.\nI-20.\nX10.Y10.R10.\nG1G40Y0\nM30";
        let flat = [[10.0, 0.0], [10.0, -5.0], [15.0, 0.0], [15.0, 0.0], [10.0, 5.0], [10.0, 0.0]];
        assert_ends(pocket, &setup, &flat.map(|[x, y]| [x, y, 0.0]));
        let MoveKind::Arc { centre, sweep, .. } = run(pocket, &setup).moves[2].kind else { panic!("no arc") };
        assert!((centre[0] - 10.0).hypot(centre[1]) < 1e-9 && (sweep - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    }
    // LinuxCNC's ends where the shifted curves meet.
    assert_ends(inside, &linuxcnc(), &[[-20.0, 10.0, 0.0], at_z(0.0, 15.0), at_z(0.0, 50.0)]);
}

#[test]
fn fanucs_lead_in_before_an_outside_corner_is_of_type_a() {
    let open = |source: &str, setup: &Setup| {
        run(source, setup)
            .notes
            .iter()
            .filter(|note| note.is_unknown && note.text.contains("by an outside corner"))
            .count()
    };
    // The tool is 5 to the left: of +Y at X-5, of +X behind the corner at Y45.
    let outside = "G0Y-30.\nG1G41D2Y40.F100.\nX80.\nM30";
    assert_ends(outside, &fanuc(), &[[0.0, -30.0, 0.0], [0.0, 45.0, 0.0], [80.0, 45.0, 0.0]]);
    assert_eq!(open(outside, &fanuc()), 1);
    // Haas's is left at type B: beside the end, then round it.
    let round = [[0.0, -30.0, 0.0], [-5.0, 40.0, 0.0], [0.0, 45.0, 0.0], [80.0, 45.0, 0.0]];
    assert_ends(outside, &haas(), &round);
    assert_eq!(open(outside, &haas()), 1);
    // By 135 degrees: beside the line down and right, 5 up and right of (0, 40).
    let s = 5.0 * 0.5_f64.sqrt();
    assert_ends(
        "G0Y-30.\nG1G41D2Y40.F100.\nX40.Y0\nM30",
        &fanuc(),
        &[[0.0, -30.0, 0.0], [s, 40.0 + s, 0.0], [40.0 + s, s, 0.0]],
    );
    // What both types do alike: inside corners, straight on, no radius, later corners.
    for source in [
        "G0X-20.Y10.\nG1G41D2X0F100.\nY50.\nM30",
        "G0Y-30.\nG1G41D2Y40.F100.\nY80.\nX80.\nM30",
        "G0Y-30.\nG1G41D2Y40.F100.\nX0.4Y80.\nM30",
        "G0Y-30.\nG1G41D0Y40.F100.\nX80.\nM30",
    ] {
        assert_eq!(open(source, &fanuc()) + open(source, &haas()), 0, "{source}");
    }
    assert_eq!(open("G0 Y-30\nG1 G41 D2 Y40 F100\nX80\nM2", &linuxcnc()), 0);
}

#[test]
fn fanucs_compensation_waits_for_a_move_in_the_plane() {
    let expected = [[-20.0, 0.0, 0.0], [-20.0, 0.0, -5.0], [0.0, 5.0, -5.0], [20.0, 5.0, -5.0]];
    for setup in [fanuc(), haas()] {
        assert_ends("G0X-20.\nG41D2\nG1Z-5.F100.\nX0\nX20.\nM30", &setup, &expected);
    }
}

#[test]
fn a_rigid_tap_starts_the_spindle() {
    let speeds = |source: &str, setup: &Setup| {
        let source = format!("G0Z5.\n{source}X1.Z-1.R1.F100\nM30");
        let moves = run(&source, setup).moves;
        let fed = moves.iter().filter(|step| step.kind == MoveKind::Feed).map(|step| step.spindle_rpm);
        let last = moves.last().map(|step| step.spindle_rpm);
        fed.chain(last).collect::<Vec<_>>()
    };
    assert_eq!(speeds("S500\nG84", &haas()), [500.0, -500.0, 0.0]);
    assert_eq!(speeds("M29S500\nG84", &fanuc()), [500.0, -500.0, 0.0]);
    assert_eq!(speeds("S500\nG74", &fanuc()), [-500.0, 500.0, 0.0]);
    assert_eq!(speeds("M4S500\nG84", &fanuc()), [-500.0, 500.0, -500.0]);
    // Without a speed it stands still, as it does in other cycles.
    assert!(speeds("G84", &fanuc()).iter().all(|rpm| *rpm == 0.0));
    assert_eq!(speeds("S500\nG81", &fanuc()), [0.0; 2]);
    assert!(speeds("S500\nG84", &linuxcnc()).iter().all(|rpm| *rpm == 0.0));
}

#[test]
fn a_program_stop_stops_the_spindle() {
    for (stop, setup, expected) in [
        ("M0\nG1X2.", haas(), [500.0, 0.0]),
        ("M0\nG1X2.", fanuc(), [500.0, 0.0]),
        // After the move of its block.
        ("G1X2.M0", haas(), [500.0, 500.0]),
        ("M0\nM3\nG1X2.", haas(), [500.0, 500.0]),
        // A switch at the machine decides on M1, and LinuxCNC's M0 leaves the spindle on.
        ("M1\nG1X2.", haas(), [500.0, 500.0]),
        ("M1\nG1X2.", fanuc(), [500.0, 500.0]),
        ("M0\nG1X2.", linuxcnc(), [500.0, 500.0]),
    ] {
        let moves = run(&format!("M3S500\nG1X1.F100\n{stop}\nM30"), &setup).moves;
        let speeds: Vec<f64> = moves.iter().map(|step| step.spindle_rpm).collect();
        assert_eq!(speeds, expected, "{stop} {setup:?}");
    }
}

#[test]
fn machine_codes_act_before_or_behind_the_move_of_their_block() {
    let speeds = |source: &str, setup: &Setup| {
        let moves = run(&format!("S500\n{source}\nM30"), setup).moves;
        moves.iter().map(|step| step.spindle_rpm).collect::<Vec<_>>()
    };
    for (source, on_haas, on_fanuc, on_linuxcnc) in [
        ("G1X1.F100M3\nX2.", [0.0, 500.0], [500.0, 500.0], [500.0, 500.0]),
        ("G1X1.F100M4\nX2.", [0.0, -500.0], [-500.0, -500.0], [-500.0, -500.0]),
        ("M3\nG1X1.F100M5\nX2.", [500.0, 0.0], [500.0, 0.0], [0.0, 0.0]),
        ("M3\nG1X1.F100M19\nX2.", [500.0, 0.0], [500.0, 0.0], [0.0, 0.0]),
        ("T1M6M3\nG1X1.F100", [0.0, 500.0], [0.0, 500.0], [0.0, 500.0]),
    ] {
        for (setup, expected) in [(haas(), on_haas), (fanuc(), on_fanuc), (linuxcnc(), on_linuxcnc)] {
            assert_eq!(speeds(source, &setup), expected, "{source} {:?}", setup.dialect);
        }
    }
    let told = |source: &str| notes(&format!("S500\n{source}\nM30"), &fanuc());
    assert!(told("G1X1.F100M3").contains("M3 or M4 beside a feed move"));
    assert_eq!(told("G0X1.M3\nG1X2.F100"), "");
    // The old tool goes up, and the new one over.
    let change = |setup: &Setup| {
        let moves = run("G0Z50.\nT2G91G28Z0M6\nG90G0X10.\nM30", setup).moves;
        moves.iter().position(|step| step.kind == MoveKind::ToolChange { tool: 2 })
    };
    assert_eq!([haas(), fanuc(), linuxcnc()].map(|setup| change(&setup)), [Some(3), Some(3), Some(1)]);
}

#[test]
fn a_machines_own_codes_may_turn_the_spindle() {
    let source = "S500M13\nG1X1.F100\nM15\nX2.\nM30";
    let user_codes = [(13, UserCode::SpindleOn), (15, UserCode::SpindleOff)].into();
    let speeds = |setup: &Setup| run(source, setup).moves.iter().map(|step| step.spindle_rpm).collect::<Vec<_>>();
    assert_eq!(speeds(&Setup { user_codes, ..fanuc() }), [500.0, 0.0]);
    assert_eq!(speeds(&fanuc()), [0.0, 0.0]);
    let told = notes(source, &fanuc());
    assert!(
        told.contains("M13 is taken to move no axis and not to start the spindle; `user_codes = { M13 ="),
        "{told}"
    );
}

#[test]
fn haass_lathes_turn_driven_tools_and_the_sub_spindle_at_the_speed_of_p() {
    let haas_lathe = || Setup { dialect: Dialect::Haas, ..lathe() };
    let speeds = |source: &str, setup: &Setup| {
        run(&format!("{source}\nM30"), setup).moves.iter().map(|step| step.spindle_rpm).collect::<Vec<_>>()
    };
    for (source, expected) in [
        ("M133P2000\nG0X40.\nM135\nX50.", vec![2000.0, 0.0]),
        ("G97S800M3\nG0X40.\nM5\nM134P2000\nX50.\nM135\nM3\nX60.", vec![800.0, -2000.0, 800.0]),
        ("M143P900\nG0X40.\nM133P2000\nX50.\nM135\nX60.\nM145\nX70.", vec![900.0, 2000.0, 900.0, 0.0]),
        ("M144P900\nS500M3\nG0X40.\nM145\nX50.", vec![500.0, 500.0]),
        // They act behind the move of their block.
        ("M133P2000G0X40.\nX50.M135\nX60.", vec![0.0, 2000.0, 0.0]),
    ] {
        assert_eq!(speeds(source, &haas_lathe()), expected, "{source}");
    }
    assert_refused("M133\nM30", &haas_lathe(), "1:1", "P, the speed, at least 0, is missing");
    // Which of them turn: one that holds the workpiece, and that of the tool.
    let turning = |source: &str, setup: &Setup| {
        let moves = run(&format!("{source}\nM30"), setup).moves;
        moves.iter().map(|step| [step.turns_workpiece, step.turns_tool]).collect::<Vec<_>>()
    };
    let all = "M133P2000\nG0X40.\nM135\nS500M3\nX50.\nM143P9\nM5\nX60.\nM145\nX70.";
    assert_eq!(turning(all, &haas_lathe()), [[false, true], [true, false], [true, false], [false; 2]]);
    for setup in [lathe(), fanuc(), haas(), linuxcnc()] {
        assert_eq!(turning("S500M3\nG0X1.\nM5\nX2.", &setup), [[true; 2], [false; 2]]);
    }
    let sub = run("M143P9\nM30", &haas_lathe()).notes;
    assert!(sub.len() == 1 && sub[0].is_unknown && sub[0].text.contains("main and sub spindle"), "{sub:?}");
    // What the machine's own codes turn is not known.
    let user_codes = [(13, UserCode::SpindleOn)].into();
    assert_eq!(turning("M133P2000\nG0X1.", &Setup { user_codes, ..haas_lathe() }), [[true; 2]]);
    // A feed in mm each turn, and a thread, are of the sub spindle, whatever S was.
    let feeds = run("S100\nM143P800\nG99G0X64.Z2.\nG1Z-30.F0.2\nG32Z-40.F2.\nM30", &haas_lathe());
    let feeds: Vec<_> = feeds.moves.iter().filter_map(|step| step.feed_mm_min).collect();
    assert_eq!(feeds, [160.0, 1600.0]);
    // Elsewhere the machine's builder says; P is the speed where no S was given.
    let user_codes = || [(133, UserCode::SpindleOn), (135, UserCode::SpindleOff)].into();
    for (source, expected) in
        [("M133P2000\nG0X1.\nM135\nX2.", vec![2000.0, 0.0]), ("S500M133P2\nG0X1.\nM135\nX2.", vec![500.0, 0.0])]
    {
        for setup in [fanuc(), haas(), lathe(), haas_lathe()] {
            assert_eq!(speeds(source, &Setup { user_codes: user_codes(), ..setup }), expected, "{source}");
        }
    }
    // M5 stops it on mills.
    assert_eq!(speeds("M133P2000\nG0X1.\nM5\nX2.", &Setup { user_codes: user_codes(), ..fanuc() }), [2000.0, 0.0]);
    let told = notes("M133P2000\nG0X1.\nM30", &lathe());
    assert!(told.contains("`user_codes = { M133 = \"spindle-on\" }`"), "{told}");
}

#[test]
fn a_length_that_waits_for_z_is_told() {
    let high = Position([0.0, 0.0, 400.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let told = |source: &str, setup: Setup| {
        let setup = Setup { start: high, home: high, ..setup };
        notes(&format!("{source}\nM30"), &setup)
    };
    let wanted = "the tool length offset has changed and Z has not been sent anywhere since";
    for source in ["G0G43H1Z20.\nG49\nX100.", "G0Z20.\nG43H1\nG81X1.Z-1.R1.F100."] {
        assert!(told(source, fanuc()).contains(&format!("line 3: {wanted}")), "{source}");
        assert!(told(source, haas()).contains(wanted), "{source}");
        assert_eq!(told(source, linuxcnc()), "", "{source}");
    }
    // Z is sent, or stands at home, where nothing is in the way.
    for source in ["G0G43H1Z20.\nG49\nZ50.\nX100.", "G43H1\nG0X1.\nZ20.", "G0G43H1Z20.\nG49\nM5"] {
        assert_eq!(told(source, fanuc()), "", "{source}");
    }
}

#[test]
fn system_variables_are_what_they_are_on_the_control() {
    assert_end("G43H1\nG0X#5083\nM30", &fanuc(), [50.0, 0.0, 0.0]);
    assert_end("G20G43H1\nG0X#5083\nM30", &haas(), [50.0, 0.0, 0.0]);
    // Fanuc's external offset, which is none here, is Haas's G52.
    assert_end("G52X2.\nG0X#5201\nM30", &fanuc(), [2.0, 0.0, 0.0]);
    assert_end("G52X2.\nG0X#5201\nM30", &haas(), [4.0, 0.0, 0.0]);
    assert_end("#14961=10.\nG54.1P49G0X1.\nM30", &fanuc(), [11.0, 0.0, 0.0]);
    assert_end("G20\n#19941=1.\nG54.1P298G0X1.\nM30", &fanuc(), [50.8, 0.0, 0.0]);
    // Modes are the control's own numbers: the last of G0 to G3 and the cycle.
    for setup in [fanuc(), haas()] {
        let source = "G0Z5.\nG1X1.F100.\nG81X2.Z-1.R1.\n#1=#4001\n#2=#4009\nG80G0X#1Y#2\nM30";
        assert_end(source, &setup, [1.0, 81.0, 5.0]);
        assert_end("G0Z5.\nG76X2.Z-1.R1.Q0.3F100.\n#1=#4009\nG80\nG0X#1Y#4009\nM30", &setup, [76.0, 80.0, 5.0]);
    }
    // On lathes G90, G92 and G94 are of the group of G0, and feeds are of G98 and G99.
    for (block, motion, feed_mode) in [
        ("G90X40.Z-20.F0.2", 90.0, 99.0),
        ("G92X40.Z-20.F1.5", 92.0, 99.0),
        ("G94X10.Z-1.F0.2", 94.0, 99.0),
        ("G32Z-10.F2.", 32.0, 99.0),
        ("G98G1X40.F100.", 1.0, 98.0),
        ("G98G83Z-9.R-3.F100.", 0.0, 98.0),
    ] {
        let source = format!("S100M3G0X50.Z2.\n{block}\n#1=#4001\n#2=#4005\nG80\nG0X#1Z#2\nM30");
        assert_end(&source, &lathe(), [motion / 2.0, 0.0, feed_mode]);
        assert_end(&source, &Setup { dialect: Dialect::Haas, ..lathe() }, [motion / 2.0, 0.0, feed_mode]);
    }
    assert_refused("G0X#4009\nM30", &lathe(), "1:4", "parameter does not exist");
    // Haas's timers of tools, at zero, and Fanuc's nothing.
    assert_end("IF[#5403GE3600]THEN#3000=15\nG0X[1.+#5600]\nM30", &haas(), [1.0, 0.0, 0.0]);
    assert_refused("G0X#5403\nM30", &fanuc(), "1:4", "parameter does not exist");
    for variable in [5101, 5161, 5181, 5210, 5211, 5220, 5230, 5341, 5400, 5610, 14_000, 19_999] {
        let source = format!("G0X#{variable}\nM30");
        assert_refused(&source, &fanuc(), "1:4", "parameter does not exist");
        assert_refused(&source, &haas(), "1:4", "parameter does not exist");
    }
    // LinuxCNC's place of G28 is the program's to read.
    assert_end("G28.1\nG0 X[#5161 + 1]\nM2", &linuxcnc(), [1.0, 0.0, 0.0]);
}

#[test]
fn g80_behind_an_arc_moves_nothing() {
    let source = "G2X10.I5.F100.\nG91G28Z0\nG17G40G80G90\nM30";
    for setup in [fanuc(), haas()] {
        assert_ends(source, &setup, &[[10.0, 0.0, 0.0]; 3]);
    }
}

#[test]
fn a_file_is_called_beside_another_m_code() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("O2000.nc"), "O2000\nG0X4.\nM99\n").unwrap();
    std::fs::write(folder.path().join("O3000.nc"), "O3000\nG0X#24\nM99\n").unwrap();
    let main = folder.path().join("main.nc");
    let program = interpret("M8M98P2000\nG65P3000X5.\nM30", &main, &fanuc()).unwrap();
    assert_eq!(ends(&program), [[4.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
}

#[test]
fn words_that_programs_commonly_have_are_taken() {
    let second_home = Position([0.0, 0.0, 90.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let fanuc = Setup { second_home: Some(second_home), ..fanuc() };
    assert_end("G0Z5.\nG91G30P2Z0.\nM30", &fanuc, [0.0, 0.0, 90.0]);
    assert_refused("G91G30P3Z0.\nM30", &fanuc, "1:7", "the third and the fourth reference point are not known");
    assert_end("M19P270\nG67G0X1.\nM30", &haas(), [1.0, 0.0, 0.0]);
    assert_refused("M19 P270\nM2", &linuxcnc(), "1:5", "P must be 0, 1 or 2");
    assert_end("S500\nG0Z5.\nG84X1.Z-1.R1.J2.F100.\nM30", &haas(), [1.0, 0.0, 5.0]);
    assert_end("S500\nG0Z5.\nG84X1.Z-1.R1.Q0.3F100.\nM30", &fanuc, [1.0, 0.0, 5.0]);
    assert_end("G0Z5.\nG73X1.Z-9.R1.Q2.K4.F100.\nM30", &haas(), [1.0, 0.0, 5.0]);
    assert_refused("G0Z5.\nG73X1.Z-9.R1.K4.F100.\nM30", &haas(), "2:14", "no code of this block uses this word");
}

#[test]
fn fanucs_words_of_a_cycle_go_over_to_another() {
    let fed = |source: &str, setup: &Setup| {
        let moves = run(&format!("G0Z5.\n{source}\nM30"), setup).moves;
        moves.iter().filter(|step| step.kind == MoveKind::Feed).map(|step| step.end[Axis::Z]).collect::<Vec<_>>()
    };
    assert_eq!(fed("G99G81X1.Z-3.R2.F100.\nG83X2.Z-6.Q4.", &fanuc()), [-3.0, -2.0, -6.0]);
    // Pecks stay for the next cycle that has some; Q of G76 is one.
    assert_eq!(fed("G83X1.Z-6.R2.Q4.F100.\nG81X2.\nG83X3.", &fanuc()), [-2.0, -6.0, -6.0, -2.0, -6.0]);
    assert_eq!(fed("G76X1.Z-6.R2.Q4.F100.\nG83X2.", &fanuc()), [-6.0, -2.0, -6.0]);
    let dwells = |source: &str| {
        let moves = run(&format!("G0Z5.\n{source}\nM30"), &fanuc()).moves;
        moves.iter().filter(|step| matches!(step.kind, MoveKind::Dwell { .. })).count()
    };
    assert_eq!(dwells("G82X1.Z-3.R2.P500F100.\nG81X2.\nG80"), 1);
    assert_eq!(dwells("G82X1.Z-3.R2.P500F100.\nG89X2.\nG80"), 2);
    for end in ["G80", "G0"] {
        let source = format!("G0Z5.\nG81X1.Z-3.R2.F100.\n{end}\nG83X2.Z-6.Q4.\nM30");
        assert_refused(&source, &fanuc(), "4:1", "R, the retract height, is missing");
    }
    assert_refused("G0Z5.\nG81X1.Z-3.R2.F100.\nG83X2.Z-6.Q4.\nM30", &haas(), "3:1", "R, the retract height");
}

#[test]
fn the_step_aside_of_g76_is_not_examined() {
    let told = |words: &str, setup: &Setup| {
        let program = run(&format!("S100M3\nG0Z5.\nG76X2.Z-1.R1.{words}F100.\nG80\nM30"), setup);
        program.notes.iter().any(|note| note.is_unknown && note.text.starts_with("G76 steps aside"))
    };
    for setup in [fanuc(), haas()] {
        for (words, expected) in [("Q0.3", true), ("I0.2J-0.1", true), ("", false), ("Q0", false), ("I0J0", false)] {
            assert_eq!(told(words, &setup), expected, "{words}");
        }
    }
    // Q of the cycle before.
    assert!(notes("G0Z5.\nG83X1.Z-1.R1.Q0.3F100.\nG76X2.\nM30", &fanuc()).contains("G76 steps aside"));
}

#[test]
fn haass_pecks_may_shrink() {
    let depths = |source: &str| {
        let source = format!("G0Z5.\n{source}\nM30");
        let moves = run(&source, &haas()).moves;
        moves.iter().filter(|step| step.kind == MoveKind::Feed).map(|step| step.end[Axis::Z]).collect::<Vec<_>>()
    };
    // 4, 3, 2, and what is left of 2; the same in the next hole.
    let hole = [-4.0, -7.0, -9.0, -10.0];
    assert_eq!(depths("G83X1.Z-10.R0.I4.J1.K2.F100.\nX2."), [hole, hole].concat());
    assert_eq!(depths("G73X1.Z-10.R0.I4.J0.K2.F100."), [-4.0, -8.0, -10.0]);
    assert_refused("G0Z5.\nG83X1.Z-10.R0.I4.K2.F100.\nM30", &haas(), "2:1", "J or K of I, J and K is missing");
    assert_refused("G0Z5.\nG83X1.Z-10.R0.I1.J1.K2.F100.\nM30", &haas(), "2:15", "I, J and K must be");
    assert_refused("G0Z5.\nG83X1.Z-10.R0.I4.J1.K2.Q1.F100.\nM30", &haas(), "2:24", "no code of this block");
}

#[test]
fn grbl_takes_a_centre_of_the_third_axis() {
    let grbl = Setup { dialect: Dialect::Grbl, ..Setup::default() };
    let program = run("G90 G21\nG0 X10 Y0\nG2 X-10 Y0 I-10 J0 K0.000 F100\nM30", &grbl);
    assert!(matches!(program.moves[1].kind, MoveKind::Arc { .. }));
    assert!(refused("G2 X-10 Y0 I-5 J0 K0 F100\nM2", &Setup::default()).contains("K0"));
}

#[test]
fn starts_of_threads_move_nothing_else() {
    for setup in [lathe(), Setup { dialect: Dialect::Haas, ..lathe() }] {
        for code in ["G92X18.Z-20.F2.", "G32Z-20.F2.", "G76X17.Z-20.D0.3K1.F2."] {
            if setup.dialect == Dialect::Fanuc && code.starts_with("G76") {
                continue;
            }
            let ends = |q: &str| run(&format!("S500M3\nG0X22.Z2.\n{code}{q}\nM30"), &setup).moves;
            assert_eq!(ends("Q180000"), ends(""), "{code}");
        }
    }
}

#[test]
fn signs_of_linuxcnc_are_no_words_elsewhere() {
    for setup in [fanuc(), haas()] {
        assert!(refused("G0@714\nM30", &setup).contains('@'));
    }
}

#[test]
fn a_tool_that_is_got_ready_behind_a_change_is_no_fault() {
    for setup in [fanuc(), haas()] {
        assert_eq!(notes("T1M6\nT2\nG0X1.\nM30", &setup), "");
        assert!(notes("T2\nG0X1.\nM30", &setup).contains("T2 selects a tool that no M6 changes to"));
    }
}

#[test]
fn ignored_codes_that_may_move_axes_are_told() {
    let told = |source: &str, code: &str| {
        let setup = Setup { ignored: [code.parse().unwrap()].into(), ..haas() };
        unknown(&format!("G0X1.\n{source}\nM30"), &setup)
    };
    for (source, code, expected) in [
        ("G65P9810Z-5.", "G65", true),
        ("M98P1", "M98", true),
        ("G150", "G150", true),
        ("G187P1", "G187", false),
        ("M31", "M31", false),
        ("M200", "M200", false),
    ] {
        assert_eq!(!told(source, code).is_empty(), expected, "{code}");
    }
}
