use super::*;
use crate::geometry::{Isometry, Point};
use crate::machine::joint::{Joint, Limits};
use crate::machine::tree::Link;
use nalgebra::{Translation3, UnitQuaternion};
use proptest::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

fn link(name: &str, parent: Option<&str>, joint: Joint) -> Link {
    let parent_from_link = Isometry::translation(1.0, 2.0, 3.0);
    Link { name: name.into(), parent: parent.map(Into::into), parent_from_link, joint: Some(joint) }
}

fn turn(axis: Axis, direction: Vector, [min, max]: [f64; 2]) -> Joint {
    let limits = Limits { min: min.to_radians(), max: max.to_radians() };
    Joint::rotary(axis, direction, Point::origin(), limits).unwrap()
}

const FREE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

fn control(tool_link: Option<usize>, work_link: Option<usize>) -> TipControl {
    TipControl { tool_link, gauge: Point::origin(), direction: -Vector::z_axis(), work_link }
}

/// A trunnion that tilts about X and carries a table that turns about Z, under an upright spindle.
fn table_table(a: [f64; 2]) -> (Machine, TipControl) {
    let links = vec![
        link("trunnion", None, turn(Axis::A, Vector::x(), a)),
        link("table", Some("trunnion"), turn(Axis::C, Vector::z(), FREE)),
    ];
    (Machine::new(links).unwrap(), control(None, Some(1)))
}

/// A table that turns about Z under a head that tilts about Y.
fn head_table() -> (Machine, TipControl) {
    let links = vec![
        link("table", None, turn(Axis::C, Vector::z(), FREE)),
        link("head", None, turn(Axis::B, Vector::y(), FREE)),
    ];
    (Machine::new(links).unwrap(), control(Some(1), Some(0)))
}

/// A head that rotates about Z and carries a second rotary joint about `second`.
fn head_head(second: Vector) -> (Machine, TipControl) {
    let slide = Joint::prismatic(Axis::Z, Vector::z(), Limits::NONE).unwrap();
    let links = vec![
        link("slide", None, slide),
        link("fork", Some("slide"), turn(Axis::C, Vector::z(), FREE)),
        link("head", Some("fork"), turn(Axis::B, second, FREE)),
    ];
    (Machine::new(links).unwrap(), control(Some(2), None))
}

fn at(values: &[(Axis, f64)]) -> Position {
    let mut position = Position::default();
    values.iter().for_each(|&(axis, degrees)| position[axis] = degrees.to_radians());
    position
}

fn vector(x: f64, y: f64, z: f64) -> Unit<Vector> {
    Unit::new_normalize(Vector::new(x, y, z))
}

/// The angles of two axes in degrees, for the preferred and the other solution.
fn degrees(found: &Solutions, axes: [Axis; 2]) -> [Option<[f64; 2]>; 2] {
    let of = |solution: &Solution| axes.map(|axis| (solution.position[axis].to_degrees() * 1e6).round() / 1e6);
    [Some(of(&found.chosen)), found.other.as_ref().map(of)]
}

#[test]
fn both_solutions_of_a_trunnion() {
    let (machine, control) = table_table(FREE);
    // Seen from the table the tool is Rz(-C) Rx(-A) z = (sin A sin C, sin A cos C, cos A). For (1/2, 0, √3/2): A 30, C 90 or
    // A -30, C -90.
    let tilted = vector(0.5, 0.0, 0.75f64.sqrt());
    let both = |from: f64| {
        let found = control.orient(&machine, &tilted, &at(&[(Axis::C, from)])).unwrap();
        degrees(&found, [Axis::A, Axis::C])
    };
    assert_eq!(both(10.0), [Some([30.0, 90.0]), Some([-30.0, -90.0])]); // 80 and 100 to go
    assert_eq!(both(-10.0), [Some([-30.0, -90.0]), Some([30.0, 90.0])]);
    assert_eq!(both(350.0), [Some([-30.0, 270.0]), Some([30.0, 450.0])]); // 80 back and 100 on
    let seen = control.tool_vector(&machine, &at(&[(Axis::A, 30.0), (Axis::C, 90.0)]));
    assert!((seen.as_ref() - tilted.as_ref()).norm() < 1e-15);
}

#[test]
fn the_axis_nearer_to_the_base_or_the_tables_decides_first() {
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    let (across, along) = 100_f64.to_radians().sin_cos();
    // The directions that the two axes give at 30 and 100 degrees; the other solution is -30 and -80. Fanuc's manual ranks by the travel of
    // the trunnion, of the table under a head, and of the fork, even where the other axis then travels farther.
    for ((machine, control), direction, axes, from) in [
        (table_table(FREE), vector(sine * across, sine * along, cosine), [Axis::A, Axis::C], [20.0, 0.0]),
        (head_table(), vector(sine * along, -sine * across, cosine), [Axis::B, Axis::C], [-90.0, 20.0]),
        (head_head(Vector::x()), vector(sine * across, -sine * along, cosine), [Axis::B, Axis::C], [-90.0, 20.0]),
    ] {
        let from = at(&[(axes[0], from[0]), (axes[1], from[1])]);
        let found = control.orient(&machine, &direction, &from).unwrap();
        assert_eq!(degrees(&found, axes), [Some([30.0, 100.0]), Some([-30.0, -80.0])]);
        let longest = |solution: &Solution| solution.travel[0].abs().max(solution.travel[1].abs());
        assert!(longest(&found.chosen) > longest(&found.other.unwrap()));
    }
}

#[test]
fn on_equal_travels_the_axis_nearer_to_a_whole_turn_decides() {
    let (machine, control) = table_table(FREE);
    let turns = control.turns(&machine).unwrap();
    let solution = |[a, c]: [f64; 2], travel: [f64; 2]| {
        let position = at(&[(Axis::A, a), (Axis::C, c)]);
        Solution { position, free: None, travel, limits: Ok(()) }
    };
    // Travels are those of C and of A; rounding decides nothing.
    for (better, worse) in [
        (solution([50.0, 90.0], [2.0, 1.0]), solution([0.0, 0.0], [1.0, -1.5])),
        (solution([50.0, 90.0], [-1.0, 1.0 + 1e-12]), solution([0.0, 0.0], [2.0, 1.0])),
        (solution([350.0, 90.0], [1.0, 1.0 + 1e-12]), solution([20.0, 0.0], [1.0, -1.0])),
        (solution([20.0, 350.0], [1.0, 1.0]), solution([-20.0, 30.0], [1.0, 1.0])),
    ] {
        assert!(is_better(&better, &worse, &turns) && !is_better(&worse, &better, &turns), "{better:?} {worse:?}");
    }
}

/// A trunnion and a table on axes that turn a degree for each unit.
fn table_table_in_degrees() -> (Machine, TipControl) {
    let links = vec![
        link("trunnion", None, turn(Axis::V, Vector::x(), FREE)),
        link("table", Some("trunnion"), turn(Axis::W, Vector::z(), FREE)),
    ];
    (Machine::new(links).unwrap(), control(None, Some(1)))
}

#[test]
fn axes_that_turn_by_degrees_find_what_axes_of_radians_find() {
    let (machine, control) = table_table_in_degrees();
    let mut previous = Position::default();
    previous[Axis::W] = 350.0;
    let found = control.orient(&machine, &vector(0.5, 0.0, 0.75f64.sqrt()), &previous).unwrap();
    // As in `both_solutions_of_a_trunnion`; the table is nearer to the workpiece.
    for (solution, expected) in
        [(found.chosen, [-30.0, 270.0, -80.0, -30.0]), (found.other.unwrap(), [30.0, 450.0, 100.0, 30.0])]
    {
        let [table, trunnion] = solution.travel.map(f64::to_degrees);
        let seen = [solution.position[Axis::V], solution.position[Axis::W], table, trunnion];
        assert!(seen.iter().zip(expected).all(|(seen, expected)| (seen - expected).abs() < 1e-9), "{seen:?}");
    }
    let turns = control.turns(&machine).unwrap();
    let at_trunnion = |degrees: f64| {
        let mut position = Position::default();
        position[Axis::V] = degrees;
        Solution { position, free: None, travel: [1.0; 2], limits: Ok(()) }
    };
    for (better, worse) in [(350.0, 20.0), (5.0, 350.0), (725.0, 350.0)] {
        assert!(is_better(&at_trunnion(better), &at_trunnion(worse), &turns), "{better} {worse}");
    }
}

#[test]
fn of_equal_positions_the_nearest_within_the_limits_is_taken() {
    for (previous, limits, expected) in [
        (1000.0, [-100.0, 400.0], 370.0),
        (-1000.0, [5.0, 400.0], 10.0),
        // Limits give way to rounding only.
        (-1000.0, [10.0 + 0.5 * LIMIT_SLACK, 400.0], 10.0),
        (-1000.0, [10.0 + 2.0 * LIMIT_SLACK, 400.0], 370.0),
        (1000.0, [-100.0, 370.0 - 0.5 * LIMIT_SLACK], 370.0),
        (1000.0, [-100.0, 370.0 - 2.0 * LIMIT_SLACK], 10.0),
        // None is within them: the nearest of all.
        (700.0, [20.0, 30.0], 730.0),
    ] {
        let [low, high] = limits;
        assert_eq!(nearest(10.0, 360.0, previous, low, high), expected, "{previous} {limits:?}");
    }
}

#[test]
fn limits_rule_out_a_solution_or_both() {
    let tilted = vector(0.5, 0.0, 0.75f64.sqrt());
    let (machine, control) = table_table([-20.0, 100.0]);
    let found = control.orient(&machine, &tilted, &at(&[(Axis::C, -80.0)])).unwrap();
    assert_eq!(degrees(&found, [Axis::A, Axis::C]), [Some([30.0, 90.0]), Some([-30.0, -90.0])]);
    assert!(found.chosen.limits.is_ok() && found.other.unwrap().limits.unwrap_err().axis == 'A');
    let (machine, control) = table_table([-20.0, 20.0]);
    let error = control.orient(&machine, &tilted, &at(&[(Axis::C, -80.0)])).unwrap_err();
    assert_eq!(
        error.to_string().split_once(", axis").unwrap(),
        (
            "both ways to tilt the tool leave the limits; of the nearer one",
            " A at -30 degrees is outside its limits -20 to 20 degrees"
        )
    );
}

#[test]
fn both_solutions_of_heads() {
    // Rz(-C) Ry(B) z = (sin B cos C, -sin B sin C, cos B); sin 36.869898° = 0.6.
    let (machine, control) = head_table();
    let found = control.orient(&machine, &vector(0.0, 0.6, 0.8), &at(&[(Axis::C, -10.0)])).unwrap();
    assert_eq!(degrees(&found, [Axis::B, Axis::C]), [Some([36.869898, -90.0]), Some([-36.869898, 90.0])]);
    // Rz(C) Rx(B) z = (sin B sin C, -sin B cos C, cos B).
    let (machine, control) = head_head(Vector::x());
    let found = control.orient(&machine, &vector(0.6, 0.0, 0.8), &at(&[(Axis::C, 10.0)])).unwrap();
    assert_eq!(degrees(&found, [Axis::B, Axis::C]), [Some([36.869898, 90.0]), Some([-36.869898, -90.0])]);
}

#[test]
fn an_axis_along_the_tool_stays_where_it_was() {
    for (machine, control) in [table_table(FREE), head_table(), head_head(Vector::x())] {
        let from = at(&[(Axis::C, 33.0), (Axis::A, 20.0), (Axis::B, 20.0)]);
        let found = control.orient(&machine, &vector(0.0, 0.0, 1.0), &from).unwrap();
        assert_eq!((found.chosen.free, found.other), (Some(Axis::C), None));
        assert_eq!(found.chosen.position[Axis::C], from[Axis::C]);
        let seen = control.tool_vector(&machine, &found.chosen.position);
        assert!((seen.as_ref() - Vector::z()).norm() < 1e-15);
    }
    // A little aside of it, both solutions are there, and as exact.
    let (machine, control) = table_table(FREE);
    let aside = vector(3e-8, 0.0, 1.0);
    let found = control.orient(&machine, &aside, &at(&[(Axis::C, 80.0)])).unwrap();
    assert_eq!(degrees(&found, [Axis::A, Axis::C])[0].unwrap()[1], 90.0);
    for solution in [found.chosen, found.other.unwrap()] {
        assert!((control.tool_vector(&machine, &solution.position).as_ref() - aside.as_ref()).norm() < 1e-15);
    }
}

#[test]
fn a_spindle_that_turns_about_the_tool_stays_where_it_was() {
    let links = vec![
        link("table", None, turn(Axis::A, Vector::x(), FREE)),
        link("spindle", None, turn(Axis::C, Vector::z(), FREE)),
    ];
    let (machine, control) = (Machine::new(links).unwrap(), control(Some(1), Some(0)));
    let tilted = vector(0.0, 0.5, 0.75f64.sqrt());
    let found = control.orient(&machine, &tilted, &at(&[(Axis::C, 33.0)])).unwrap();
    assert_eq!((found.chosen.free, found.other), (Some(Axis::C), None));
    assert_eq!(degrees(&found, [Axis::A, Axis::C])[0], Some([30.0, 33.0]));
    assert!((control.tool_vector(&machine, &found.chosen.position).as_ref() - tilted.as_ref()).norm() < 1e-15);
}

#[test]
fn a_head_at_45_degrees_reaches_the_horizontal_and_no_farther() {
    let (machine, control) = head_head(Vector::new(0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2));
    // Half a turn about (0, 1, 1) takes z to y; a quarter turn back about z takes y to x.
    let found = control.orient(&machine, &vector(1.0, 0.0, 0.0), &Position::default()).unwrap();
    assert_eq!(found.other, None);
    let [b, c] = degrees(&found, [Axis::B, Axis::C])[0].unwrap();
    assert!((b.abs() - 180.0).abs() < 1e-5 && (c + 90.0).abs() < 1e-5, "{b} {c}");
    let below = control.orient(&machine, &vector(1.0, 0.0, -0.01), &Position::default()).unwrap_err();
    assert_eq!(below.to_string(), "axes C and B cannot tilt the tool this way, whatever their limits");
}

#[test]
fn machines_without_two_such_axes_are_told() {
    let (machine, _) = table_table(FREE);
    let found =
        |control: TipControl| control.orient(&machine, &vector(1.0, 0.0, 1.0), &Position::default()).unwrap_err();
    assert_eq!(found(control(None, Some(0))), OrientationError::NotTwoJoints { found: 1 });
    // What carries both does not count.
    assert_eq!(found(control(Some(0), Some(1))), OrientationError::NotTwoJoints { found: 1 });
    // Two joints of one axis turn together.
    let joints = [("one", Vector::x()), ("other", Vector::y())];
    let links = joints.map(|(name, direction)| link(name, None, turn(Axis::A, direction, FREE)));
    let machine = Machine::new(links.to_vec()).unwrap();
    let error = control(Some(1), Some(0)).orient(&machine, &vector(1.0, 0.0, 1.0), &Position::default()).unwrap_err();
    assert_eq!(error, OrientationError::NotTwoJoints { found: 2 });
    let (machine, control) = head_head(Vector::z());
    let error = control.orient(&machine, &vector(1.0, 0.0, 1.0), &Position::default()).unwrap_err();
    assert_eq!(error, OrientationError::Parallel { axes: ['C', 'B'] });
}

fn direction() -> impl Strategy<Value = Vector> {
    prop::array::uniform3(-1.0..1.0f64)
        .prop_map(Vector::from)
        .prop_filter("no direction", |v| v.norm() > 0.1)
        .prop_map(|v| v.normalize())
}

/// Two rotary axes in random directions on links with random placements: both at the table, one each, or both at the head.
fn random_machine(
    kind: usize,
    axes: [Vector; 2],
    stands: [Vector; 2],
    tool: Vector,
    limits: [Limits; 2],
) -> (Machine, TipControl) {
    let joint = |axis, direction, limits| Joint::rotary(axis, direction, Point::new(3.0, -2.0, 5.0), limits).unwrap();
    let place = |turn: Vector| Isometry::from_parts(Translation3::new(10.0, 20.0, 30.0), UnitQuaternion::new(turn));
    let parents = [[None, Some("first")], [None, None], [None, Some("first")]][kind];
    let link = |name: &str, parent: Option<&str>, stand, joint| Link {
        name: name.into(),
        parent: parent.map(Into::into),
        parent_from_link: place(stand),
        joint: Some(joint),
    };
    let machine = Machine::new(vec![
        link("first", parents[0], stands[0], joint(Axis::A, axes[0], limits[0])),
        link("second", parents[1], stands[1], joint(Axis::C, axes[1], limits[1])),
    ]);
    let (tool_link, work_link) = [(None, Some(1)), (Some(1), Some(0)), (Some(1), None)][kind];
    let direction = Unit::new_normalize(tool);
    (machine.unwrap(), TipControl { tool_link, gauge: Point::origin(), direction, work_link })
}

proptest! {
    #[test]
    fn forward_of_inverse_is_the_direction(
        kind in 0..3usize,
        axes in [direction(), direction()],
        stands in [direction(), direction()],
        tool in direction(),
        angles in prop::array::uniform2(-PI..PI),
        previous in prop::array::uniform2(-15.0..15.0f64),
        limits in prop::array::uniform2((-20.0..0.0f64, 0.0..20.0f64)),
    ) {
        let limits = limits.map(|(min, max)| Limits { min, max });
        let position = |[a, c]: [f64; 2]| at(&[(Axis::A, a.to_degrees()), (Axis::C, c.to_degrees())]);
        let (machine, control) = random_machine(kind, axes, stands, tool, limits);
        let turns = control.turns(&machine).unwrap();
        prop_assume!(turns[0].direction.cross(&turns[1].direction).norm() > 0.1);
        let wanted = control.tool_vector(&machine, &position(angles));
        let found = match control.orient(&machine, &wanted, &position(previous)) {
            Err(OrientationError::OutOfLimits(_)) => return Ok(()),
            found => found.unwrap(),
        };
        let within = |limits: &Limits, x: f64| (limits.min - LIMIT_SLACK..=limits.max + LIMIT_SLACK).contains(&x);
        let mut hits = 0;
        for solution in [Some(found.chosen), found.other].into_iter().flatten() {
            let seen = control.tool_vector(&machine, &solution.position);
            prop_assert!((seen.as_ref() - wanted.as_ref()).norm() < 1e-12);
            let mut apart: f64 = 0.0;
            for (index, axis) in [Axis::A, Axis::C].into_iter().enumerate() {
                let value = solution.position[axis];
                // Nothing nearer to the previous position is allowed and the same.
                for turns in -8..=8 {
                    let same = value + f64::from(turns) * TAU;
                    let nearer = (same - previous[index]).abs() < (value - previous[index]).abs() - 1e-9;
                    prop_assert!(!(nearer && within(&limits[index], same)), "{} is nearer than {}", same, value);
                }
                apart = apart.max((0.5 * (value - angles[index])).sin().abs());
            }
            hits += u32::from(apart < 1e-6);
            prop_assert_eq!(solution.limits.is_ok(), within(&limits[0], solution.position[Axis::A]) && within(&limits[1], solution.position[Axis::C]));
        }
        // The angles we came from are one of the two, unless an axis nearly lies along the tool.
        let distance = |axis: Vector, v: &Unit<Vector>| axis.cross(v).norm();
        let at_zero = control.tool_vector(&machine, &Position::default());
        if distance(turns[0].direction, &wanted) > 1e-3 && distance(turns[1].direction, &at_zero) > 1e-3 {
            prop_assert!(hits >= 1);
        }
        if let Some(other) = found.other {
            prop_assert!(!is_better(&other, &found.chosen, &turns));
        }
    }
}
