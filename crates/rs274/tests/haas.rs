//! Codes that Haas's controls have beside Fanuc's: pockets, patterns of holes, mirrors. Expectations are worked out by hand beside the programs.

mod support;

use rs274::{Dialect, MoveKind, Setup, Tool, Units};
use std::f64::consts::TAU;
use support::{assert_ends, assert_near, ends, refused, run};

fn haas() -> Setup {
    let tools = [(1, Tool::with_length(50.0, 6.0)), (2, Tool::with_length(30.0, 10.0))].into();
    Setup { dialect: Dialect::Haas, tools, units: Some(Units::Mm), ..Setup::default() }
}

fn fanuc() -> Setup {
    Setup { dialect: Dialect::Fanuc, ..haas() }
}

fn lathe(dialect: Dialect) -> Setup {
    Setup { dialect, units: Some(Units::Mm), ..Setup::lathe() }
}

fn assert_refused(source: &str, setup: &Setup, place: &str, text: &str) {
    let told = refused(source, setup);
    assert!(told.starts_with(&format!("bad.nc:{place}: ")) && told.contains(text), "{source}: {told}");
}

/// Whether a note says that the machine may move otherwise, and begins so.
fn is_unknown(source: &str, text: &str) -> bool {
    run(source, &haas()).notes.iter().any(|note| note.is_unknown && note.text.starts_with(text))
}

/// X and Y of the centre and the sweep of every arc.
fn arcs(source: &str) -> Vec<([f64; 2], f64)> {
    let arc = |kind| if let MoveKind::Arc { centre, sweep, .. } = kind { Some((centre, sweep)) } else { None };
    run(source, &haas()).moves.iter().filter_map(|step| arc(step.kind)).collect()
}

#[test]
fn g101_mirrors_about_zero_until_g100() {
    let source = "G101X0\nG0X5.Y5.\nG101Y0\nX6.Y6.\nG100X0\nX7.Y7.\nG100Y0\nX8.Y8.\nM30";
    let expected = [[-5.0, 5.0, 0.0], [-6.0, -6.0, 0.0], [7.0, -7.0, 0.0], [8.0, 8.0, 0.0]];
    assert_ends(source, &haas(), &expected);
    // The number counts for nothing, and a mirror that is off may be ended.
    assert_ends("G100X0Y0Z0A0\nG101X3.\nG0X5.\nM30", &haas(), &[[-5.0, 0.0, 0.0]]);
    // One mirror turns arcs the other way and changes the side of the cutter, two do not.
    let sweeps = |mirror: &str| arcs(&format!("{mirror}\nG0X5.\nG3I-5.F100.\nM30"))[0].1;
    assert_eq!([sweeps("G100X0"), sweeps("G101X0"), sweeps("G101X0Y0")], [TAU, -TAU, TAU]);
    let end = |mirror: &str| ends(&run(&format!("{mirror}\nG41D1G1X10.F100.\nY-50.\nM30"), &haas())).pop().unwrap();
    assert_near(end(""), [13.0, -50.0, 0.0], "left of the way down");
    assert_near(end("G101X0"), [-13.0, -50.0, 0.0], "mirrored");
    assert_refused("G101\nM30", &haas(), "1:1", "an axis word, which names the axis to mirror, is missing");
    assert_refused("G101A0\nM30", &haas(), "1:5", "a mirror of another axis than X, Y and Z");
    assert_refused("G101X0\nM30", &fanuc(), "1:1", "code is not supported");
}

#[test]
fn a_mirror_at_a_shifted_zero_is_told() {
    for (source, expected) in [
        ("G101X0", false),
        ("G52X5.\nG101X0", true),
        ("G101X0\nG52X5.", true),
        ("G52Y5.\nG101X0", false),
        ("G52X5.\nG52X0\nG101X0", false),
        ("G52X5.\nG101X0\nG100X0", true),
    ] {
        assert_eq!(is_unknown(&format!("{source}\nG0X9.\nM30"), "G101 mirrors about"), expected, "{source}");
    }
    assert_ends("G52X20.\nG101X0\nG0X5.\nM30", &haas(), &[[15.0, 0.0, 0.0]]);
}

#[test]
fn r_of_a_lathes_cycle_is_the_initial_level_where_it_is_left_out() {
    for dialect in [Dialect::Fanuc, Dialect::Haas] {
        let setup = lathe(dialect);
        for cycle in ["G83", "G84", "G85"] {
            let source = format!("G97S100M3\nG0X0Z5.\n{cycle}Z-10.F0.1\nG80\nM30");
            let heights: Vec<f64> = ends(&run(&source, &setup)).iter().map(|end| end[2]).collect();
            assert_eq!((heights[0], heights.last()), (5.0, Some(&5.0)), "{source}");
            assert!(heights.contains(&-10.0) && heights.iter().all(|z| [5.0, -10.0].contains(z)), "{heights:?}");
        }
        // R of the hole before holds.
        let r = if dialect == Dialect::Fanuc { "R-3." } else { "R2." };
        let source = format!("G97S100M3\nG0X0Z5.\nG83Z-10.{r}F0.1\nZ-12.\nG80\nM30");
        let heights: Vec<f64> = ends(&run(&source, &setup)).iter().map(|end| end[2]).collect();
        assert_eq!(heights.iter().filter(|&&z| z == 2.0).count(), 2, "{heights:?}");
    }
    for cycle in ["G81", "G82"] {
        run(&format!("G97S100M3\nG0X0Z5.\n{cycle}Z-10.F0.1\nG80\nM30"), &lathe(Dialect::Haas));
    }
    assert_refused("G0Z5.\nG81Z-1.F100.\nM30", &haas(), "2:1", "R, the retract height, is missing");
}

#[test]
fn codes_that_are_not_read_are_named() {
    for (code, setup, text) in [
        ("G47P1X1.Y1.", haas(), "text engraving is not read"),
        ("G150P1Z-1.", haas(), "general purpose pocket milling is not read"),
        ("G254", haas(), "the dynamic work offset (G254, G255) is not read"),
        ("G163X1.", haas(), "a 5-axis cycle of holes (G153 to G169) is not read"),
        ("G77", haas(), "the back bore cycle is not read"),
        ("G112", lathe(Dialect::Haas), "XY to XC interpolation (G112, G113) is not read"),
        ("G12.1", fanuc(), "polar coordinate interpolation is not read"),
    ] {
        let told = refused(&format!("{code}\nM30"), &setup);
        let name: String = code.chars().take_while(|c| "G.0123456789".contains(*c)).collect();
        assert_eq!(told, format!("bad.nc:1:1: {text}: `{name}`"));
    }
}

#[test]
fn cutter_compensation_in_a_tilted_plane_is_named() {
    let source = "G68.2X0Y0Z0I0J30.K0\nG43H1\nG41D1X5.\nM30";
    for setup in [haas(), fanuc()] {
        assert_refused(source, &setup, "3:1", "cutter compensation: it is not read in a tilted plane (G68.2)");
    }
}
