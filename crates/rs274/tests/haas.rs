//! Codes that Haas's controls have beside Fanuc's: pockets, patterns of holes, mirrors. Expectations are worked out by hand beside the programs.

mod support;

use rs274::{Axis, Dialect, MoveKind, Setup, Units};
use std::f64::consts::TAU;
use support::{assert_ends, assert_near, assert_refused, ends, fanuc, haas, refused, run};

fn lathe(dialect: Dialect) -> Setup {
    Setup { dialect, units: Some(Units::Mm), ..Setup::lathe() }
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

/// X and Y of every hole whose bottom is at this height.
fn holes(source: &str, bottom: f64) -> Vec<[f64; 2]> {
    let moves = run(&format!("{source}\nM30"), &haas()).moves;
    let bottoms = moves.iter().filter(|step| step.kind == MoveKind::Feed && step.end[Axis::Z] == bottom);
    bottoms.map(|step| [step.end[Axis::X], step.end[Axis::Y]]).collect()
}

fn assert_holes(source: &str, expected: &[[f64; 2]]) {
    let found = holes(source, -1.0);
    assert_eq!(found.len(), expected.len(), "{source}: {found:?}");
    let in_space = |[x, y]: [f64; 2]| [x, y, 0.0];
    found.iter().zip(expected).for_each(|(found, expected)| assert_near(in_space(*found), in_space(*expected), source));
}

#[test]
fn a_pocket_of_one_circle_starts_and_ends_at_its_centre() {
    // 3 mm, the radius of D1, inside the circle.
    let source = "G0X10.Y5.Z2.\nG12I8.Z-3.D1F100.\nM30";
    let circle = [[10.0, 5.0, -3.0], [15.0, 5.0, -3.0], [15.0, 5.0, -3.0], [10.0, 5.0, -3.0]];
    assert_ends(source, &haas(), &[&[[10.0, 5.0, 2.0]], &circle[..]].concat());
    assert_eq!(arcs(source), [([10.0, 5.0], -TAU)]);
    assert_eq!(arcs(&source.replace("G12", "G13")), [([10.0, 5.0], TAU)]);
    assert!(run(source, &haas()).moves[1..].iter().all(|step| step.feed_mm_min == Some(100.0)));
    // The centre in the block; rapid, and the mode before goes on.
    let source = "G1X1.F50.\nG12X10.Y5.I8.D1F100.\nX0\nM30";
    let moves = run(source, &haas()).moves;
    assert_eq!((moves[1].kind, moves.last().unwrap().kind), (MoveKind::Rapid, MoveKind::Feed));
    assert_near(ends(&run(source, &haas()))[1], [10.0, 5.0, 0.0], source);
}

#[test]
fn a_pocket_of_many_circles_ends_with_the_radius_of_k() {
    // Radii 5, 8 and 9.5 mm, less 3.
    let source = "G0Z2.\nG13I5.K9.5Q3.Z-3.D1F100.\nM30";
    let xs: Vec<f64> = ends(&run(source, &haas())).iter().map(|end| end[0]).collect();
    assert_eq!(xs, [0.0, 0.0, 2.0, 2.0, 5.0, 5.0, 6.5, 6.5, 0.0]);
    assert_eq!(arcs(source), [([0.0, 0.0], TAU); 3]);
    // In G91, each time deeper.
    let source = "G0Z2.\nG13G91Z-2.I5.L3D1F100.\nG90G0Z2.\nM30";
    let depths = run(source, &haas())
        .moves
        .iter()
        .filter_map(|step| step.kind.is_feed().then_some(step.end[Axis::Z]))
        .collect::<Vec<_>>();
    assert_eq!(depths, [[0.0; 4], [-2.0; 4], [-4.0; 4]].concat());
}

#[test]
fn a_pocket_takes_the_last_d_and_d0_is_none() {
    // Where the circle ends, before the way back.
    let radius = |source: &str| ends(&run(source, &haas())).iter().rev().nth(1).map(|end| end[0]);
    assert_eq!(radius("D1\nG12I8.F100.\nM30"), Some(5.0));
    assert_eq!(radius("G41D2X5.F100.\nG40X0Y0\nG12I8.F100.\nM30"), Some(3.0));
    assert_eq!(radius("D1\nG12I8.D0F100.\nM30"), Some(8.0));
    assert_refused("G12I8.F100.\nM30", &haas(), "1:1", "D, the number of the radius offset, is missing");
}

#[test]
fn the_ways_between_the_circles_of_a_pocket_are_told_where_they_matter() {
    let is_told = |words: &str| is_unknown(&format!("T1M6\nG13{words}F100.\nM30"), "G12 or G13: the ways");
    // The cutter of 6 mm clears the middle of a circle of up to 6 mm radius, and up to 6 mm from circle to circle.
    for (words, expected) in [
        ("I6.D1", false),
        ("I6.1D1", true),
        ("I5.K20.Q6.D1", false),
        ("I5.K20.Q6.1D1", true),
        ("I3.D0", false),
        ("I3.1D0", true),
    ] {
        assert_eq!(is_told(words), expected, "{words}");
    }
    assert!(is_unknown("G13I1.D0F100.\nM30", "G12 or G13: the ways"), "without a tool of known diameter");
}

#[test]
fn a_pocket_is_mirrored_scaled_and_tilted() {
    assert_eq!(arcs("G101X0\nG0X10.\nG12I8.D1F100.\nM30"), [([-10.0, 0.0], TAU)]);
    // 16 mm less the radius of the tool.
    let source = "G51X0Y0Z0P2.\nG0X10.\nG12I8.D1F100.\nM30";
    assert_eq!(arcs(source), [([20.0, 0.0], -TAU)]);
    assert_near(ends(&run(source, &haas()))[1], [33.0, 0.0, 0.0], source);
    // About (10, 0, 0) of a plane that is turned by 30 degrees about X.
    let source = "G68.2X0Y0Z0I0J30.K0\nG43H1\nG0X10.Y0Z0\nG12I8.D1F100.\nM30";
    let moves = run(source, &haas()).moves;
    assert!(moves.len() > 50 && moves.iter().all(|step| !matches!(step.kind, MoveKind::Arc { .. })), "{}", moves.len());
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    for step in moves.iter().filter(|step| step.kind == MoveKind::Feed).rev().skip(1) {
        let [x, y, z] = [Axis::X, Axis::Y, Axis::Z].map(|axis| step.end[axis]);
        assert!(((x - 10.0).hypot(y).hypot(z) - 5.0).abs() < 1e-9 && (z * cos - y * sin).abs() < 1e-9, "{x} {y} {z}");
    }
}

#[test]
fn pockets_that_cannot_be_are_refused() {
    for (source, place, text) in [
        ("G12F100.D1", "1:1", "I, the radius of the first circle, is missing"),
        ("G12I3.F100.D1", "1:4", "I must be above the radius of the tool offset D"),
        ("G12I5.K9.F100.D1", "1:1", "Q, from circle to circle, beside K is missing"),
        ("G12I5.Q2.F100.D1", "1:1", "K, the radius of the last circle, beside Q is missing"),
        ("G12I5.K5.Q2.F100.D1", "1:7", "K must be above I"),
        ("G12I5.K9.Q0F100.D1", "1:10", "Q must be above 0"),
        ("G12I5.D1", "1:1", "a feed rate F above 0 is missing"),
        ("G12I5.D7F100.", "1:7", "tool is not in the tool table"),
        ("G18\nG12I5.D1F100.", "2:1", "outside the XY plane (G17)"),
        ("G41D1X5.F100.\nG12I5.", "2:1", "while cutter compensation is on; G40 ends it"),
        ("G43H1\nG12G91Z-1.I5.D1F100.", "2:7", "a step of Z right behind another tool offset"),
    ] {
        assert_refused(&format!("{source}\nM30"), &haas(), place, text);
    }
    assert_refused("G12I5.D1F100.\nM30", &fanuc(), "1:1", "code is not supported");
    assert_refused("G12I5.F100.\nM30", &lathe(Dialect::Haas), "1:1", "code is not supported");
}

#[test]
fn a_bolt_circle_drills_the_active_cycle_at_each_place() {
    let places = [[1.0, 12.0], [-9.0, 2.0], [1.0, -8.0], [11.0, 2.0]];
    assert_holes("G0X1.Y2.Z5.\nG81Z-1.R1.F100.L0\nG70I10.J90.L4", &places);
    // Without L0 the first block drills at the centre.
    assert_holes("G0X1.Y2.Z5.\nG82Z-1.R1.P0.5F100.\nG70I10.J90.L4", &[&[[1.0, 2.0]], &places[..]].concat());
    assert_holes("G0Z5.\nG81Z-1.R1.F100.L0\nG70X1.Y2.I10.J90.L4\nX3.", &[&places[..], &[[3.0, 2.0]]].concat());
    let source = "G0Z5.\nG81G99Z-1.R1.F100.L0\nG70I10.L2\nG80\nM30";
    let first = [[10.0, 0.0, 5.0], [10.0, 0.0, 1.0], [10.0, 0.0, -1.0], [10.0, 0.0, 1.0]];
    let second = [[-10.0, 0.0, 1.0], [-10.0, 0.0, -1.0], [-10.0, 0.0, 1.0]];
    assert_ends(source, &haas(), &[&[[0.0, 0.0, 5.0]], &first[..], &second[..]].concat());
    assert!(run(source, &haas()).notes.is_empty());
    // Pecks at every place.
    let pecks = ends(&run("G0Z5.\nG83Z-4.R0Q2.F100.L0\nG70I10.L3\nM30", &haas()));
    assert_eq!(pecks.iter().filter(|end| end[2] == -2.0).count(), 3);
}

#[test]
fn holes_on_an_arc_are_k_apart() {
    let half = 3_f64.sqrt() / 2.0;
    let places = [[10.0, 0.0], [10.0 * half, -5.0], [5.0, -10.0 * half]];
    assert_holes("G0Z5.\nG81Z-1.R1.F100.L0\nG71I10.K-30.L3", &places);
}

#[test]
fn holes_on_a_line_begin_here_or_a_step_away() {
    let source = "G0X1.Z5.\nG81Z-1.R1.F100.L0\nG72I5.J90.L2";
    assert_holes(source, &[[1.0, 0.0], [1.0, 5.0], [1.0, 10.0]]);
    assert!(is_unknown(&format!("{source}\nM30"), "G72: whether the first hole"));
}

#[test]
fn a_place_beside_l0_is_told_before_a_pattern() {
    for (source, expected) in [
        ("G81X3.Z-1.R1.F100.L0\nG70I10.L3", true),
        ("G81X0Y0Z-1.R1.F100.L0\nG70I10.L3", false),
        ("G81X3.Z-1.R1.F100.L0\nG70X3.Y0I10.L3", false),
        ("G81X3.Z-1.R1.F100.\nG70I10.L3", false),
    ] {
        assert_eq!(is_unknown(&format!("G0Z5.\n{source}\nM30"), "X or Y beside L0"), expected, "{source}");
    }
}

#[test]
fn patterns_that_cannot_be_are_refused() {
    let cycle = "G0Z5.\nG81Z-1.R1.F100.L0\n";
    for (source, place, text) in [
        ("G70I10.L3".to_owned(), "1:1", "without an active cycle"),
        (format!("{cycle}G80\nG71I10.K5.L3"), "4:1", "without an active cycle"),
        (format!("{cycle}G0X1.\nG72I10.L3"), "4:1", "without an active cycle"),
        (format!("{cycle}G70L3"), "3:1", "I, the radius or the distance of the holes, is missing"),
        (format!("{cycle}G70I-1.L3"), "3:4", "I must be above 0"),
        (format!("{cycle}G70I1."), "3:1", "L, the number of holes, is missing"),
        (format!("{cycle}G70I1.L0"), "3:7", "L must be a whole number from 1"),
        (format!("{cycle}G71I1.L3"), "3:1", "K, the angle from hole to hole, is missing"),
        (format!("{cycle}G70I1.K3.L3"), "3:7", "no code of this block uses this word"),
        (format!("{cycle}G18G70I1.L3"), "3:4", "outside the XY plane (G17)"),
    ] {
        assert_refused(&format!("{source}\nM30"), &haas(), place, text);
    }
    assert_refused(&format!("{cycle}G70I1.L3\nM30"), &fanuc(), "3:1", "code is not supported");
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
fn m16_changes_the_tool_of_a_mill() {
    let changes = |source: &str, setup: &Setup| {
        run(source, setup).moves.iter().filter(|step| step.kind == MoveKind::ToolChange { tool: 2 }).count()
    };
    assert_eq!(changes("T2M16\nM30", &haas()), 1);
    assert_eq!(changes("T2M16\nM30", &fanuc()), 0);
}

#[test]
fn a_jump_that_hangs_on_the_pallet_is_refused() {
    assert_refused("M46Q1P10\nN10G0X1.\nM30", &haas(), "1:1", "M46");
}

#[test]
fn what_g51_may_scale_otherwise_is_told() {
    let of_holes = "G51 scales R and the depth";
    let of_rotary = "A, B and C are taken as written";
    for (source, text, expected) in [
        ("G0Z9.\nG51X0Y0Z0P.5\nG81X1.Z-1.R2.F100.", of_holes, true),
        ("G0Z9.\nG51X0Y0Z0P.5\nG50\nG81X1.Z-1.R2.F100.", of_holes, false),
        ("G51X0Y0Z0P2.\nG0A45.", of_rotary, true),
        ("G51X0Y0Z0P2.\nG0X45.", of_rotary, false),
        ("G0A45.", of_rotary, false),
    ] {
        assert_eq!(is_unknown(&format!("{source}\nM30"), text), expected, "{source}");
    }
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

#[test]
fn a_condition_needs_no_if() {
    assert_ends(
        "#1=0\nN2#1=#1+1\nG0X#1\nN5[#1LT3]M99P2\nG0X9.\nM30",
        &haas(),
        &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [9.0, 0.0, 0.0]],
    );
}

#[test]
fn clocks_and_timers_of_tools_are_not_known() {
    for (source, named) in
        [("#1=#5401\nIF[#1GT3600.]GOTO9\nN9M30", "#5401"), ("IF[#3012GT120000]GOTO9\nN9M30", "#3012")]
    {
        let told: Vec<_> = run(source, &haas()).notes.into_iter().filter(|note| note.is_unknown).collect();
        assert!(told.len() == 1 && told[0].text.starts_with(named) && told[0].text.contains("a clock"), "{told:?}");
    }
}
