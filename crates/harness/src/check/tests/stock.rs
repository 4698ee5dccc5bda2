//! Workpieces that are cut, and what comes into what is left of them.

use super::turning::{HEAD, LATHE, NO_TIP, along_x, block_and_cutter, cuboid, cylinder, found, kinds, part};
use super::*;

/// Samples only at the ends of moves: each move is one place.
const COARSE: &str = "step_mm = 1000\n";

/// With the mesh [`OPEN`] in the place of a shape.
fn opened(part: &str) -> String {
    format!("{}mesh = \"open.obj\"\n", &part[..part.find("shape = ").unwrap()])
}

/// A block at X -50 and one at X 50, tops at 10 mm, and a cutter between them whose tip is 20 mm above Z.
fn two_blocks() -> String {
    [
        HEAD,
        &part("left", "", "workpiece", [-50.0, 0.0, 0.0], &cuboid([20.0, 20.0, 20.0])),
        &part("right", "", "workpiece", [50.0, 0.0, 0.0], &cuboid([20.0, 20.0, 20.0])),
        &part("cutter", "head", "cutter", [0.0, 0.0, 20.0], &cylinder(2.0, 20.0)),
        NO_TIP,
    ]
    .concat()
}

/// A cutter of 0.04 mm needs 0.02 mm, a fifth of the standard.
#[test]
fn a_cutter_that_needs_a_stock_more_than_four_times_as_fine_leaves_it_as_it_is() {
    let block = part("block", "", "workpiece", [0.0; 3], &cuboid([20.0, 20.0, 20.0]));
    let cutter = part("cutter", "head", "cutter", [0.0, 0.0, 15.0], &cylinder(0.04, 20.0));
    let told = found(&[HEAD, &block, &cutter, NO_TIP].concat(), "M3 S1000\nG1 Z-6 F500\nM2");
    assert_eq!(told.remaining[0].stock.resolution_mm(), 0.1);
}

/// A wire of 0.02 mm goes 6 mm down through a cube of 4 mm, over which the cutter has passed: alone, and on a block that stays above; and a wire that stays above, too.
#[test]
fn a_thin_piece_of_a_thick_part_is_told_when_it_may_be_in_the_stock() {
    let cube = part("cube", "", "workpiece", [0.0; 3], &cuboid([4.0; 3]));
    let cutter = part("cutter", "head", "cutter", [-100.0, 0.0, 5.0], &cylinder(5.0, 40.0));
    for (pieces, expected) in [
        (&[(cylinder(0.01, 40.0), 5.0)][..], vec![(4, "unresolved")]),
        (&[(cylinder(0.01, 40.0), 5.0), (cuboid([60.0, 60.0, 40.0]), 60.0)], vec![(4, "unresolved")]),
        (&[(cylinder(0.01, 30.0), 45.0), (cuboid([60.0, 60.0, 40.0]), 60.0)], vec![]),
    ] {
        let pieces =
            pieces.iter().map(|(shape, z)| format!("{{ shape = {shape}, at = {{ xyz_mm = [0.31, 0.17, {z}] }} }}"));
        let shape = format!("{{ kind = \"compound\", parts = [{}] }}", pieces.collect::<Vec<_>>().join(", "));
        let head = part("spindle", "head", "machine", [0.0; 3], &shape);
        let program = "M3 S1000\nG0 X100\nG0 X0\nG1 Z-9 F500\nG0 Z20\nM2";
        let told = found(&[HEAD, &cube, &cutter, &head, NO_TIP].concat(), program);
        assert_eq!((kinds(&told), told.touches.len()), (expected, 0), "{shape}");
    }
}

#[test]
fn what_is_open_is_not_free_beside_a_workpiece_that_is_cut() {
    let block = part("block", "", "workpiece", [0.0; 3], &cuboid([60.0, 20.0, 20.0]));
    let cutter = part("cutter", "head", "cutter", [0.0, 0.0, 20.0], &cylinder(2.0, 20.0));
    let (program, cut) = (NO_TIP, "M3 S1000\nG1 Z-12 F500\n");
    // Another workpiece, whose corner is at X 50, and from 0 to 10 mm high.
    let other = opened(&part("other", "", "workpiece", [50.0, -2.0, 0.0], ""));
    let told = found(&[HEAD, &block, &other, &cutter, program].concat(), &format!("{cut}G0 Z0\nG0 X52\nG0 Z-18\nM2"));
    assert_eq!((kinds(&told), told.uncut), (vec![(5, "rapid-into-workpiece")], vec![1]));
    // A holder: its lower side comes 2 mm into the block, 20 mm beside the cutter.
    let holder = opened(&part("holder", "head", "holder", [20.0, 0.0, 20.0], ""));
    let told = found(&[HEAD, &block, &cutter, &holder, program].concat(), &format!("{cut}M2"));
    assert_eq!((kinds(&told), told.uncut), (vec![(2, "collision")], vec![]));
}

/// A mill of 15 mm on a slide along Y, from 5 mm high on; a lower workpiece, whose top is at 10 mm, and an upper one, whose bottom is at Z + 90.
#[test]
fn two_workpieces_touch_where_what_is_left_of_them_does_whatever_their_order() {
    let arm = "[[machine.links]]\nname = \"arm\"\njoint = { axis = \"Y\", direction = [0, 1, 0] }\n";
    let lower = part("lower", "", "workpiece", [0.0; 3], &cuboid([8.0, 8.0, 20.0]));
    let upper = part("upper", "head", "workpiece", [0.0, 0.0, 100.0], &cuboid([4.0, 4.0, 20.0]));
    let mill = part("mill", "arm", "cutter", [0.0, -40.0, 5.0], &cylinder(15.0, 30.0));
    let settings = Settings { cutting: Cutting::At(0.6), ..with_zones(&[]) };
    for parts in [[&lower, &upper, &mill], [&mill, &upper, &lower]] {
        let text = [HEAD, arm, parts[0], parts[1], parts[2], NO_TIP].concat();
        let told = |moves: &str| {
            let scene = scene(&text, &format!("M3 S1000\nG1 Y100 F6000\n{moves}\nM2"));
            kinds(&checked(&scene, &settings))
        };
        // 5 mm are left below. 2 mm above that, and 3 mm in it.
        assert_eq!(told("G0 Z-83\nG0 Z0"), [], "{parts:?}");
        assert_eq!(told("G0 Z-88\nG0 Z0"), [(3, "collision")], "{parts:?}");
        // The mill takes 2 mm from the upper one as well, which then comes 3 mm into the lower one.
        assert_eq!(told("G0 Z-57\nG1 Y-40\nG0 Z-90\nG0 Z0"), [(5, "unresolved")], "{parts:?}");
    }
}

#[test]
fn a_workpiece_without_a_collision_does_not_end_the_search_in_the_next_one() {
    let settings = Settings { stop_at_first: true, ..with_zones(&[]) };
    let scene = scene(&two_blocks(), "M3 S1000\nG0 X-50\nG0 X50\nG0 Z-15\nM2");
    assert_eq!(kinds(&checked(&scene, &settings)), [(4, "rapid-into-workpiece")]);
}

#[test]
fn a_spent_budget_leaves_all_that_follows_unresolved() {
    let text = block_and_cutter() + COARSE;
    let program = "M3 S1000\nG0 X5\nG1 Z-15 F500\nG0 Z0\nG0 X0\nM2";
    let told = |stock_budget: u64, stop_at_first: bool| {
        let told = checked(&scene(&text, program), &Settings { stop_at_first, stock_budget, ..with_zones(&[]) });
        let given_up = told.remaining[0].given_up;
        (told.events, given_up)
    };
    // Nothing may be asked: from the first move on.
    let (events, given_up) = told(0, false);
    let [event] = &events[..] else { panic!("{events:?}") };
    assert_eq!((event.kind, event.first.line, given_up), (Kind::Unresolved, 2, Some(2)));
    assert!(event.first.place < 1e-9 && event.last.place == 4.0 && event.to_the_end, "{event:?}");
    // What is gathered before the stock is asked is examined whole.
    assert_eq!(told(1, false), (vec![], None));
    // Where the first collision is looked for, the stock is asked about each move that comes near. The move up is the first such one.
    let (events, given_up) = told(1, true);
    assert_eq!((events[0].kind, events[0].first.line, given_up), (Kind::Unresolved, 5, Some(5)));
}

#[test]
fn a_workpiece_that_is_given_up_does_not_end_the_search_in_the_next_one() {
    let settings = Settings { stop_at_first: true, stock_budget: 1, ..with_zones(&[]) };
    let program = "M3 S1000\nG0 X50\nG0 Z-15\nG0 Z20\nG0 X-50\nG1 Z-15 F500\nG0 Z20\nG0 X0\nM2";
    let told = checked(&scene(&(two_blocks() + COARSE), program), &settings);
    assert_eq!((kinds(&told), told.remaining[0].given_up), (vec![(3, "rapid-into-workpiece")], Some(8)));
}

#[test]
fn a_part_of_the_machine_that_no_spindle_turns_carries_no_piece_of_a_bar() {
    let told = |of_machine: &str| {
        let text = [
            LATHE,
            &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(10.0, 40.0)),
            &part("insert", "slide", "cutter", [30.0, 0.0, 60.0], &cuboid([20.0, 2.0, 3.0])),
            &part("bed", "", "machine", [0.0, 0.0, 200.0], &cylinder(10.0, 20.0)),
            of_machine,
        ]
        .concat();
        let settings = Settings { cutting: Cutting::At(0.5), ..with_zones(&[]) };
        checked(&scene(&text, "M3 S500\nG0 Z-40\nG1 X-41 F50\nG0 X0\nM2"), &settings).remaining[0].is_parted
    };
    assert_eq!(["", "turns = \"spindle\"\n"].map(told), [false, true]);
}

/// An arc of 8 mm that rises by 0.4 mm in the middle, cut 4 mm deep. Back along its chord the cutter is up to 0.4 mm in what is left.
#[test]
fn an_arc_cuts_nothing_for_sure_that_its_chord_alone_passes() {
    let text = block_and_cutter() + COARSE + "chord_mm = 0.5\n";
    let told = found(&text, "M3 S1000\nG18\nG0 X-4\nG1 Z-14 F500\nG3 X4 Z-14 R20\nG0 X-4\nM2");
    assert_eq!((kinds(&told), told.samples), (vec![(6, "unresolved")], 4));
}

/// The feed ends 1 mm above the block, and the rapid behind it goes on the same way.
#[test]
fn a_rapid_on_the_way_of_a_feed_is_no_feed() {
    let told = found(&(block_and_cutter() + COARSE), "M3 S1000\nG1 Z-9 F500\nG0 Z-15\nM2");
    assert_eq!(kinds(&told), [(3, "rapid-into-workpiece")]);
}

#[test]
fn contact_lasts_while_the_machine_waits() {
    let told = |moves: &str| {
        let told = found(&block_and_cutter(), &format!("G0 Z-15\n{moves}\nM2"));
        told.events.iter().map(|event| (event.first.line, event.last.line, event.to_the_end)).collect::<Vec<_>>()
    };
    assert_eq!(told("G4 P1\nG0 Z0"), [(1, 3, false)]);
    assert_eq!(told("G4 P1"), [(1, 2, true)]);
    // It is over before the machine waits.
    assert_eq!(told("G0 Z0\nG4 P1"), [(1, 2, false)]);
}

#[test]
fn a_standing_cutter_on_an_arc_is_told_once() {
    let told = found(&block_and_cutter(), "M3 S1000\nG1 Z-15 F500\nM5\nG18\nG2 X10 Z-15 R10\nM2");
    assert_eq!(kinds(&told), [(5, "stopped-spindle-into-workpiece")]);
}

/// The shank passes 0.3 mm above the block and over the edge of the slot, where cells of 1.35 mm are not known.
#[test]
fn what_stays_off_the_uncut_workpiece_is_off_what_is_left_however_coarse_that_is() {
    let text = |gap: f64| {
        let shank = part("shank", "head", "shank", [7.0, 0.0, 30.0 + gap], &cuboid([8.0, 8.0, 10.0]));
        block_and_cutter().replacen("[program]", &format!("{shank}[program]"), 1)
    };
    let told = |gap: f64| {
        let settings = Settings { cutting: Cutting::At(3.0), ..with_zones(&[]) };
        let told = checked(&scene(&text(gap), "M3 S1000\nG1 Z-15 F500\nG1 X20\nG1 X-20\nM2"), &settings);
        (told.events.len(), told.touches.iter().map(|touch| touch.pair.other(0)).collect::<Vec<_>>())
    };
    assert_eq!([0.3, -0.3].map(told), [(0, vec![]), (0, vec![2])]);
}

#[test]
fn a_round_cutter_cuts_for_sure_where_the_axis_of_the_spindle_is_not_known() {
    let text = block_and_cutter().replacen("[program]", "turns = \"spindle\"\n[program]", 1);
    let told = found(&text, "M3 S1000\nG1 Z-15 F500\nG1 X10\nG0 Z0\nG0 X5\nG0 Z-15\nM2");
    assert!(told.is_clear(), "{:?}", told.events);
}

/// A driven mill, an arbor that follows it into its hole, and an insert that is there all the time: the bar may turn.
#[test]
fn what_follows_a_driven_cutter_into_a_bar_that_may_turn_meets_it_however_coarse_the_samples_are() {
    let text = |insert: &str| {
        [
            LATHE,
            &part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(30.0, 50.0)),
            &along_x("mill", "cutter", [40.0, 60.0], &cylinder(6.0, 20.0)),
            "turns = \"own\"\n",
            &along_x("arbor", "shank", [60.0, 60.0], &cylinder(4.0, 20.0)),
            insert,
        ]
        .concat()
    };
    // The insert is beside the end of the bar where the mill cuts.
    let program = "M3 S500\nG0 Z-70\nG0 Z-40\nG1 X-80 F200\nM2";
    let insert = part("insert", "slide", "cutter", [50.0, 0.0, 110.0], &cuboid([4.0, 2.0, 4.0]));
    for (sampling, insert, expected) in [
        ("", "", vec![]),
        ("", &insert, vec![(4, "unresolved")]),
        // The whole feed is one sample.
        (COARSE, &insert, vec![(4, "unresolved")]),
    ] {
        let text = text(insert).replacen("[program]\n", &format!("[program]\n{sampling}"), 1);
        assert_eq!(kinds(&found(&text, program)), expected, "{sampling} {insert}");
    }
}

#[test]
fn a_resolution_much_finer_than_the_workpiece_is_refused() {
    let bar = part("bar", "spindle", "workpiece", [0.0; 3], &cylinder(20.0, 50.0));
    let insert = part("insert", "slide", "cutter", [30.0, 0.0, 60.0], &cuboid([4.0, 2.0, 4.0]));
    for (text, program) in [
        (block_and_cutter(), "M3 S1000\nG1 Z-15 F500\nM2"),
        ([LATHE, &bar, &insert].concat(), "M3 S500\nG1 Z-40 F200\nM2"),
    ] {
        let (scene, registry) = (scene(&text, program), registry::standard());
        let (run, variant) = (scene.program.as_ref().unwrap(), registry.fastest().unwrap());
        let settings = Settings { cutting: Cutting::At(1e-9), ..Settings::standard() };
        let error = check(&scene, run, variant, &registry, &settings, &Silent).unwrap_err().to_string();
        assert!(error.starts_with("--stock-resolution: the resolution is 0.000000001 mm"), "{error}");
    }
}
