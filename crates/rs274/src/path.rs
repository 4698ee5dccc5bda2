//! Sampling: from canonical moves to axis positions along the path.
//!
//! Feed moves are straight in axis space. An arc turns about its centre while all other axes, and the radius where start and end
//! differ, change in proportion to the angle. A rapid move is straight too, or a dog-leg: every axis sets out at its own rapid rate
//! and stops where it arrives, one after another, as controllers do that do not interpolate G0. In a tilted plane the axes do so, and the tip
//! goes where they take it.

use super::canonical::{Axis, Move, MoveKind, Position};
use super::feed::{NO_TRAVEL_MM, Travel, travel_by};
use super::interpret::Program;
use super::kinematics::Kinematics;
use thiserror::Error;

/// Most samples of a path: about a gigabyte of them.
pub const MAX_SAMPLES: usize = 10_000_000;

/// A path that would have more than [`MAX_SAMPLES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the path needs more than {limit} samples up to here; larger steps need fewer", limit = MAX_SAMPLES)]
pub struct TooManySamples {
    /// The line on which it becomes too many.
    pub line: u32,
}

/// How rapid moves go.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum RapidPath {
    /// Straight in axis space.
    #[default]
    Straight,
    /// Each axis at its own rate, mm/min or radians/min, above zero. Under tool-centre-point control, and in a tilted plane where a rotary
    /// axis turns, the tip goes straight nevertheless.
    DogLeg([f64; 9]),
}

/// How finely to sample. Steps that are not above zero are taken as infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Greatest linear travel between samples, mm, over X, Y, Z and over U, V, W.
    pub step_mm: f64,
    /// Greatest travel of any rotary axis between samples, degrees.
    pub step_deg: f64,
    /// Greatest distance of an arc from the chord between two samples, mm.
    pub chord_mm: f64,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { step_mm: 1.0, step_deg: 1.0, chord_mm: 0.01 }
    }
}

/// A place on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Axis positions, mm and radians.
    pub position: Position,
    /// Line of the program, from 1; 0 for the start.
    pub line: u32,
    /// Whether the machine gets here at rapid rate.
    pub rapid: bool,
    /// Index into [`Program::moves`].
    pub move_index: usize,
    /// How much of the move is done, above 0 and up to 1.
    pub fraction: f64,
}

/// The samples of a program: each move's inner points and its end, in order. Moves that go nowhere (dwell, tool change)
/// give one sample. The start itself is not among them.
///
/// # Errors
/// When there would be too many.
pub fn sample(
    program: &Program,
    start: &Position,
    sampling: &Sampling,
    rapids: &RapidPath,
) -> Result<Vec<Sample>, TooManySamples> {
    let mut samples = Vec::with_capacity(count(program, start, sampling, rapids)?);
    let mut from = *start;
    for (move_index, step) in program.moves.iter().enumerate() {
        let (line, rapid) = (step.line, step.kind == MoveKind::Rapid);
        let mut begin = 0.0;
        for leg in legs(&from, step, program.kinematics.as_ref(), rapids) {
            let pieces = pieces(&leg.from, step, &leg.to, sampling);
            for piece in 1..=pieces {
                let part = piece as f64 / pieces as f64;
                let last = piece == pieces;
                let position = if last { leg.to } else { point_at(&leg.from, step, &leg.to, part) };
                let fraction = if last { leg.until } else { begin + part * (leg.until - begin) };
                samples.push(Sample { position, line, rapid, move_index, fraction });
            }
            begin = leg.until;
        }
        from = step.end;
    }
    Ok(samples)
}

/// How many samples [`sample`] gives.
///
/// # Errors
/// When they are too many.
pub fn count(
    program: &Program,
    start: &Position,
    sampling: &Sampling,
    rapids: &RapidPath,
) -> Result<usize, TooManySamples> {
    let (mut total, mut from) = (0_usize, *start);
    for step in &program.moves {
        for leg in legs(&from, step, program.kinematics.as_ref(), rapids) {
            total = total.saturating_add(pieces(&leg.from, step, &leg.to, sampling));
        }
        if total > MAX_SAMPLES {
            return Err(TooManySamples { line: step.line });
        }
        from = step.end;
    }
    Ok(total)
}

/// A stretch of a move that is an arc or straight.
#[derive(Clone, Copy, Debug)]
struct Leg {
    from: Position,
    to: Position,
    /// How much of the move's time is over at its end.
    until: f64,
}

/// The legs of a move: one, but for a dog-leg.
fn legs(from: &Position, step: &Move, kinematics: Option<&Kinematics>, rapids: &RapidPath) -> Vec<Leg> {
    let whole = || vec![Leg { from: *from, to: step.end, until: 1.0 }];
    let (RapidPath::DogLeg(rates), MoveKind::Rapid) = (rapids, step.kind) else { return whole() };
    match step.tip_mm {
        None => dog_leg(from, &step.end, rates),
        Some(length) if step.is_tilted => {
            dog_leg_of_tip(from, &step.end, rates, kinematics, length).unwrap_or_else(whole)
        }
        Some(_) => whole(),
    }
}

/// The legs of a tip's way where the axes go along a dog-leg. While no rotary axis turns, the tip's place is an affine function of the axes',
/// so that it goes straight along each leg. `None` where one turns, or the axes cannot take the tip there.
fn dog_leg_of_tip(
    from: &Position,
    to: &Position,
    rates: &[f64; 9],
    kinematics: Option<&Kinematics>,
    length_mm: f64,
) -> Option<Vec<Leg>> {
    if Axis::ALL.into_iter().any(|axis| axis.is_rotary() && from[axis] != to[axis]) {
        return None;
    }
    // Where the machine is not known, the rotary axes are at zero, and the tip is below the axes.
    let Some(Kinematics(machine)) = kinematics else { return Some(dog_leg(from, to, rates)) };
    let (first, mut last) = (machine.axes(from, length_mm).ok()?, machine.axes(to, length_mm).ok()?);
    for (last, first) in last.0.iter_mut().zip(first.0).filter(|(last, first)| (**last - first).abs() < NO_TRAVEL_MM) {
        *last = first; // It has moved by rounding.
    }
    let mut legs = dog_leg(&first, &last, rates);
    let mut begin = *from;
    for leg in &mut legs {
        let end = if leg.until < 1.0 { machine.tip(&leg.to, length_mm).ok()? } else { *to };
        (leg.from, leg.to) = (begin, end);
        begin = end;
    }
    Some(legs)
}

/// The legs of a rapid on which each axis goes at its own rate: one where nothing moves.
fn dog_leg(from: &Position, to: &Position, rates: &[f64; 9]) -> Vec<Leg> {
    // When each axis arrives, minutes.
    let arrivals: [f64; 9] = std::array::from_fn(|i| (to.0[i] - from.0[i]).abs() / rates[i]);
    let mut times: Vec<f64> = arrivals.into_iter().filter(|&time| time > 0.0).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let Some(&end) = times.last() else { return vec![Leg { from: *from, to: *to, until: 1.0 }] };
    let place = |time: f64| {
        Position(std::array::from_fn(|i| {
            if time >= arrivals[i] { to.0[i] } else { from.0[i] + (to.0[i] - from.0[i]) * (time / arrivals[i]) }
        }))
    };
    let mut legs: Vec<Leg> = Vec::with_capacity(times.len());
    for time in times {
        let from = legs.last().map_or(*from, |leg| leg.to);
        legs.push(Leg { from, to: place(time), until: time / end });
    }
    legs
}

/// The place a part `fraction` of the way along a leg of a move.
fn point_at(start: &Position, step: &Move, end: &Position, fraction: f64) -> Position {
    let mut point = Position(std::array::from_fn(|i| start.0[i] + (end.0[i] - start.0[i]) * fraction));
    if let MoveKind::Arc { plane, centre, sweep } = step.kind {
        let [first, second, _] = plane.axes();
        let radius = |at: &Position| (at[first] - centre[0]).hypot(at[second] - centre[1]);
        let radius = radius(start) + (radius(&step.end) - radius(start)) * fraction;
        let angle = (start[second] - centre[1]).atan2(start[first] - centre[0]) + sweep * fraction;
        point[first] = centre[0] + radius * angle.cos();
        point[second] = centre[1] + radius * angle.sin();
    }
    point
}

/// Length of a move as feed rates mean it: mm along the path of X, Y and Z; where none of them moves, of U, V and W; where none of these moves,
/// degrees. The other axes arrive at the same time (LinuxCNC, "Feed Rate"). Of an arc it is that of the arc and of the axis normal to its plane.
#[must_use]
pub fn length(start: &Position, step: &Move) -> f64 {
    let change = |axis: Axis| step.end[axis] - start[axis];
    if let MoveKind::Arc { plane, centre, sweep } = step.kind {
        let [first, second, normal] = plane.axes();
        let radius = (start[first] - centre[0]).hypot(start[second] - centre[1]);
        return (radius * sweep).hypot(change(normal));
    }
    match travel_by(change) {
        Travel::Along(length) => length,
        Travel::Turning(angle) => angle.to_degrees(),
    }
}

/// Radii that differ by less than this, mm, do so by rounding, and leave a circle by no more.
const NO_SPIRAL_MM: f64 = 1e-9;

/// Into how many pieces a leg of a move is cut.
fn pieces(start: &Position, step: &Move, end: &Position, sampling: &Sampling) -> usize {
    // What goes nowhere may still change what positions mean: under tool-centre-point control they are the tip's.
    if matches!(step.kind, MoveKind::Dwell { .. } | MoveKind::ToolChange { .. }) {
        return 1;
    }
    let change = |axis: Axis| end[axis] - start[axis];
    let length = |axes: [Axis; 3]| axes.map(|axis| change(axis).powi(2)).iter().sum::<f64>().sqrt();
    let mut linear = length([Axis::X, Axis::Y, Axis::Z]).max(length([Axis::U, Axis::V, Axis::W]));
    let rotary = [Axis::A, Axis::B, Axis::C].map(|axis| change(axis).abs()).into_iter().fold(0.0, f64::max);
    let mut needed = steps(rotary.to_degrees(), sampling.step_deg);
    if let MoveKind::Arc { plane, centre, sweep } = step.kind {
        let [first, second, normal] = plane.axes();
        let radius = |at: &Position| (at[first] - centre[0]).hypot(at[second] - centre[1]);
        let radii = [radius(start), radius(end)];
        let radius = radii[0].max(radii[1]);
        let grown = (radii[1] - radii[0]).abs();
        linear = linear.max((radius * sweep).hypot(change(normal)));
        // A chord over the angle a leaves a circle by r (1 - cos(a / 2)); no angle asks for more than the next lines where r is
        // smaller than the tolerance.
        let angle = 2.0 * (1.0 - sampling.chord_mm / radius).acos();
        needed = needed.max(steps(sweep.abs(), angle));
        // Where the radius changes by g over the sweep w, the path is a spiral, as a function of the fraction with a second derivative of
        // at most sqrt((2 g w)^2 + (r w^2)^2); a chord over 1/n of a curve leaves it by at most an eighth of that over n^2.
        if grown > NO_SPIRAL_MM && sampling.chord_mm > 0.0 {
            let bend = (2.0 * grown * sweep).hypot(radius * sweep * sweep);
            needed = needed.max(steps((bend / (8.0 * sampling.chord_mm)).sqrt(), 1.0));
        }
        // Fewer than four pieces to the turn would not look like an arc whatever the tolerance.
        needed = needed.max(steps(sweep.abs(), std::f64::consts::FRAC_PI_2));
    }
    needed.max(steps(linear, sampling.step_mm)).max(1)
}

/// How many steps a travel needs. A travel that is a whole number of steps but for rounding needs no further one.
fn steps(travel: f64, step: f64) -> usize {
    const ROUNDING: f64 = 1e-9;
    if step > 0.0 { (travel / step - ROUNDING).ceil() as usize } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canonical::Plane;
    use crate::{Setup, TipKinematics, interpret};
    use std::f64::consts::{FRAC_PI_2, TAU};
    use std::sync::Arc;

    fn run(source: &str) -> Program {
        interpret(source, std::path::Path::new("path.ngc"), &Setup::default()).unwrap()
    }

    fn ends(samples: &[Sample]) -> Vec<(f64, [f64; 3], f64)> {
        samples.iter().map(|s| (s.position[Axis::X], [1, 2, 3].map(|i| s.position.0[i]), s.fraction)).collect()
    }

    #[test]
    fn on_a_dog_leg_every_axis_arrives_in_its_own_time() {
        let program = run("G0 X100 Y50 A90\nM2");
        let coarse = Sampling { step_mm: f64::INFINITY, step_deg: f64::INFINITY, chord_mm: 0.0 };
        // X in 0.1 min, Y in 0.05, A in 0.2: at 0.05 X is half way and A a quarter, at 0.1 A is half way.
        let mut rates = [1000.0; 9];
        rates[3] = 450_f64.to_radians();
        let samples = sample(&program, &Position::default(), &coarse, &RapidPath::DogLeg(rates)).unwrap();
        let angle = |deg: f64| deg.to_radians();
        let expected = [
            (50.0, [50.0, 0.0, angle(22.5)], 0.25),
            (100.0, [50.0, 0.0, angle(45.0)], 0.5),
            (100.0, [50.0, 0.0, angle(90.0)], 1.0),
        ];
        for ((x, others, fraction), wanted) in ends(&samples).into_iter().zip(expected) {
            assert!((x - wanted.0).abs() < 1e-12 && (fraction - wanted.2).abs() < 1e-12);
            assert!(others.iter().zip(wanted.1).all(|(a, b)| (a - b).abs() < 1e-12), "{others:?}");
        }
        assert_eq!(samples.len(), 3);
        assert_eq!(sample(&program, &Position::default(), &coarse, &RapidPath::Straight).unwrap().len(), 1);
    }

    #[test]
    fn a_path_of_too_many_samples_is_refused_before_it_is_made() {
        let program = run("G0 X1\nG1 X100000 F1\nM2");
        let fine = Sampling { step_mm: 0.001, step_deg: 1.0, chord_mm: 0.01 };
        let error = sample(&program, &Position::default(), &fine, &RapidPath::Straight).unwrap_err();
        assert_eq!(error.line, 2);
        let counted = count(&program, &Position::default(), &Sampling::default(), &RapidPath::Straight);
        assert_eq!(counted, Ok(100_000)); // 1 mm at 1 mm, then 99 999 mm
    }

    #[test]
    fn the_largest_number_of_samples_is_allowed() {
        let counted = |source| count(&run(source), &Position::default(), &Sampling::default(), &RapidPath::Straight);
        assert_eq!(counted("G1 X10000000 F1\nM2"), Ok(MAX_SAMPLES));
        assert_eq!(counted("G1 X10000000 F1\nX10000001\nM2"), Err(TooManySamples { line: 2 }));
    }

    /// Whether the samples are these: line, rapid, index of the move, fraction, X, Y.
    fn are(samples: &[Sample], wanted: &[(u32, bool, usize, f64, f64, f64)]) -> bool {
        samples.len() == wanted.len()
            && samples.iter().zip(wanted).all(|(s, w)| {
                let off = [s.fraction - w.3, s.position[Axis::X] - w.4, s.position[Axis::Y] - w.5];
                (s.line, s.rapid, s.move_index) == (w.0, w.1, w.2) && off.iter().all(|d| d.abs() < 1e-12)
            })
    }

    #[test]
    fn samples_divide_each_move_evenly_from_where_the_last_ended() {
        let program = run("G0 X10 Y20\nG1 X13 Y20 F100\nG3 X11 Y22 I-2 J0\nM2");
        let start = at([8.0, 20.0, 0.0]);
        let samples = sample(&program, &start, &Sampling { step_mm: 1.0, ..COARSE }, &RapidPath::Straight).unwrap();
        // An arc of radius 2 over a quarter turn is 3.14 mm: four pieces.
        let round = |part: f64| {
            let angle = part * FRAC_PI_2;
            (3, false, 2, part, 11.0 + 2.0 * angle.cos(), 20.0 + 2.0 * angle.sin())
        };
        let mut wanted = vec![(1, true, 0, 0.5, 9.0, 20.0), (1, true, 0, 1.0, 10.0, 20.0)];
        wanted.extend([1.0, 2.0, 3.0].map(|x| (2, false, 1, x / 3.0, 10.0 + x, 20.0)));
        wanted.extend([0.25, 0.5, 0.75, 1.0].map(round));
        assert!(are(&samples, &wanted), "{samples:#?}");
        assert_eq!(count(&program, &start, &Sampling { step_mm: 1.0, ..COARSE }, &RapidPath::Straight), Ok(9));
    }

    #[test]
    fn samples_of_a_dog_leg_share_the_time_of_the_move() {
        // From (10, 10): 4 mm of X at 1 mm/min in 4 min, 2 mm of Y in 2.
        let program = run("G0 X14 Y12\nM2");
        let rapids = RapidPath::DogLeg([1.0; 9]);
        let by = |step_mm| sample(&program, &at([10.0, 10.0, 0.0]), &Sampling { step_mm, ..COARSE }, &rapids).unwrap();
        let at_part = |fraction: f64, x: f64, y: f64| (1, true, 0, fraction, x, y);
        let turn = at_part(0.5, 12.0, 12.0);
        assert!(are(&by(3.0), &[turn, at_part(1.0, 14.0, 12.0)]), "{:?}", by(3.0));
        // The first leg is 2.83 mm long: three pieces; the second two.
        let diagonal = [1.0, 2.0].map(|x| at_part(x / 6.0, 10.0 + x * 2.0 / 3.0, 10.0 + x * 2.0 / 3.0));
        let straight = [at_part(0.75, 13.0, 12.0), at_part(1.0, 14.0, 12.0)];
        assert!(are(&by(1.0), &[&diagonal[..], &[turn], &straight].concat()), "{:?}", by(1.0));
    }

    /// A table that A turns about X, and an upright spindle.
    #[derive(Debug)]
    struct Table;

    fn turned(position: &Position, angle: f64) -> Position {
        let (sin, cos) = angle.sin_cos();
        let (mut turned, y, z) = (*position, position[Axis::Y], position[Axis::Z]);
        (turned[Axis::Y], turned[Axis::Z]) = (cos * y - sin * z, sin * y + cos * z);
        turned
    }

    impl TipKinematics for Table {
        fn tip(&self, axes: &Position, length_mm: f64) -> Result<Position, String> {
            let mut tip = *axes;
            tip[Axis::Z] -= length_mm;
            Ok(turned(&tip, -axes[Axis::A]))
        }

        fn axes(&self, tip: &Position, length_mm: f64) -> Result<Position, String> {
            let mut axes = turned(tip, tip[Axis::A]);
            axes[Axis::Z] += length_mm;
            Ok(axes)
        }

        fn orient(&self, _: [f64; 3], _: &Position) -> Result<(Position, Option<Position>), String> {
            Err("it has one rotary axis".to_owned())
        }

        fn turns_work(&self, axis: Axis) -> bool {
            axis == Axis::A
        }
    }

    #[test]
    fn in_a_tilted_plane_the_axes_and_not_the_tip_go_along_the_dog_leg() {
        // X and Y at 1 mm/min, Z at 0.5.
        let rates = std::array::from_fn(|i| if i == Axis::Z as usize { 0.5 } else { 1.0 });
        let known = Setup { kinematics: Some(Kinematics(Arc::new(Table))), ..Setup::default() };
        let setups = [Setup::default(), known];
        let both = &setups[..];
        type Case<'a> = (&'a [Setup], &'a str, &'a [[f64; 3]]);
        let cases: [Case<'_>; 7] = [
            (both, "G0 X0 Y0\nG0 X30 Y10", &[[10.0, 10.0, 0.0], [30.0, 10.0, 0.0]]),
            (both, "G68.2 I0\nG0 X30 Y10", &[[10.0, 10.0, 0.0], [30.0, 10.0, 0.0]]),
            // X of the plane is the machine's Y.
            (both, "G68.2 I90\nG0 X30 Y10", &[[-10.0, 10.0, 0.0], [-10.0, 30.0, 0.0]]),
            // Z of the machine takes 20 min to move the tip by 10 mm along Y over the turned table, and Y the other way by 4 mm along Z 4 min.
            (&setups[1..], "G0 A90\nG68.2 I0\nG0 X30 Y10", &[[20.0, 10.0, 0.0], [30.0, 10.0, 0.0]]),
            (&setups[1..], "G0 A90\nG68.2 I0\nG0 Y10 Z4", &[[0.0, 2.0, 4.0], [0.0, 10.0, 4.0]]),
            (&setups[1..], "G0 A90\nG68.2 I0\nG0 X30 Y10 A0", &[[30.0, 10.0, 0.0]]),
            (both, "G43.4 H1\nG0 X30 Y10", &[[30.0, 10.0, 0.0]]),
        ];
        for (setups, text, wanted) in cases {
            for setup in setups {
                let tools = [(1, crate::Tool::with_length(80.0, 10.0))].into();
                let setup = Setup { tools, ..setup.clone() };
                let program = interpret(&format!("{text}\nM2"), std::path::Path::new("path.ngc"), &setup).unwrap();
                let last = program.moves.iter().rposition(|step| step.kind == MoveKind::Rapid).unwrap();
                let start = Position::default();
                let samples = sample(&program, &start, &COARSE, &RapidPath::DogLeg(rates)).unwrap();
                assert_eq!(count(&program, &start, &COARSE, &RapidPath::DogLeg(rates)), Ok(samples.len()), "{text}");
                let own: Vec<&Sample> = samples.iter().filter(|sample| sample.move_index == last).collect();
                assert_eq!(own.len(), wanted.len(), "{text}: {own:?}");
                for (found, wanted) in own.iter().zip(wanted) {
                    let off = found.position.0.iter().zip(wanted).map(|(found, wanted)| (found - wanted).abs());
                    // The tip of G43.4 began below the axes.
                    let off: Vec<f64> = off.take(if text.contains("G43.4") { 2 } else { 3 }).collect();
                    assert!(off.iter().all(|&off| off < 1e-9), "{text}: {own:?}");
                }
                assert_eq!(own.last().unwrap().fraction, 1.0, "{text}");
            }
        }
    }

    fn at(linear: [f64; 3]) -> Position {
        let mut position = Position::default();
        for (axis, value) in [Axis::X, Axis::Y, Axis::Z].into_iter().zip(linear) {
            position[axis] = value;
        }
        position
    }

    fn step(kind: MoveKind, end: Position) -> Move {
        let (is_probe, turns_workpiece, turns_tool) = (false, false, false);
        let (tip_mm, is_tilted, feed_mm_min, spindle_rpm) = (None, false, None, 0.0);
        Move { line: 1, kind, end, tip_mm, is_tilted, is_probe, feed_mm_min, spindle_rpm, turns_workpiece, turns_tool }
    }

    /// About the origin of the plane X, Y.
    fn arc(sweep: f64, end: [f64; 3]) -> Move {
        step(MoveKind::Arc { plane: Plane::Xy, centre: [0.0, 0.0], sweep }, at(end))
    }

    const COARSE: Sampling = Sampling { step_mm: f64::INFINITY, step_deg: f64::INFINITY, chord_mm: 0.0 };

    #[test]
    fn an_arc_leaves_its_chords_by_no_more_than_asked() {
        // Radius 10, chord 0.01: an angle of 2 acos(1 - 0.001) = 0.08945 a piece; pi / 2 takes 17.6 of them.
        let (start, quarter) = (at([10.0, 0.0, 0.0]), arc(FRAC_PI_2, [0.0, 10.0, 0.0]));
        let cut = |chord_mm| pieces(&start, &quarter, &quarter.end, &Sampling { chord_mm, ..COARSE });
        assert_eq!(cut(0.01), 18);
        let middle = point_at(&start, &quarter, &quarter.end, 0.5 / 18.0);
        let end = point_at(&start, &quarter, &quarter.end, 1.0 / 18.0);
        let chord_middle = [Axis::X, Axis::Y].map(|axis| f64::midpoint(start[axis], end[axis]));
        let sagitta = (middle[Axis::X] - chord_middle[0]).hypot(middle[Axis::Y] - chord_middle[1]);
        assert!((0.008..=0.01).contains(&sagitta), "{sagitta}");
        // A tolerance of the radius or more, or none: four pieces to the turn.
        assert_eq!((cut(10.0), cut(0.0)), (1, 1));
        // Of 9 mm, 2 acos(0.1) = 2.94: the quarter turn is the smaller.
        let turn = arc(TAU, [10.0, 0.0, 0.0]);
        assert_eq!(pieces(&start, &turn, &turn.end, &Sampling { chord_mm: 9.0, ..COARSE }), 4);
    }

    #[test]
    fn an_uneven_arc_is_cut_as_its_larger_radius_needs() {
        // Radii 10 and 20, either way round. Chord 0.01 on a spiral: hypot(2 x 10 x 1.571, 20 x 1.571^2) = 58.5, sqrt(58.5 / 0.08) = 27.04.
        // Steps of 1 mm: 20 pi / 2 = 31.4; at 10 only 15.7.
        for (from, to) in [(10.0, 20.0), (20.0, 10.0)] {
            let (start, quarter) = (at([from, 0.0, 0.0]), arc(FRAC_PI_2, [0.0, to, 0.0]));
            let cut = |sampling| pieces(&start, &quarter, &quarter.end, &sampling);
            assert_eq!(cut(Sampling { chord_mm: 0.01, ..COARSE }), 28, "{from} {to}");
            assert_eq!(cut(Sampling { step_mm: 1.0, ..COARSE }), 32, "{from} {to}");
        }
    }

    #[test]
    fn chords_of_a_spiral_keep_to_their_tolerance() {
        for (from, to, sweep) in
            [(1.0, 20.0, FRAC_PI_2), (20.0, 0.5, FRAC_PI_2), (30.0, 30.028, TAU), (0.03, 0.002, -TAU)]
        {
            let (sin, cos) = sweep.sin_cos();
            let (start, spiral) = (at([from, 0.0, 0.0]), arc(sweep, [to * cos, to * sin, 0.0]));
            let sampling = Sampling { chord_mm: 0.01, ..COARSE };
            let count = pieces(&start, &spiral, &spiral.end, &sampling);
            let point = |fraction: f64| {
                let point = point_at(&start, &spiral, &spiral.end, fraction);
                [point[Axis::X], point[Axis::Y]]
            };
            for piece in 0..count {
                let ends = [piece, piece + 1].map(|i| point(i as f64 / count as f64));
                let along = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
                let length = along[0].hypot(along[1]);
                for inner in 1..20 {
                    let p = point((piece as f64 + f64::from(inner) / 20.0) / count as f64);
                    let off = (along[0] * (p[1] - ends[0][1]) - along[1] * (p[0] - ends[0][0])).abs() / length;
                    assert!(off <= 0.01, "{from} to {to}: piece {piece} of {count} is off by {off}");
                }
            }
        }
    }

    #[test]
    fn the_radius_of_an_uneven_arc_changes_with_the_angle() {
        // From radius 10 to 20 over a quarter turn about (0, 0), Z from 0 to 8: half way 15 at 45 degrees, and Z 4.
        let (start, quarter) = (at([10.0, 0.0, 0.0]), arc(FRAC_PI_2, [0.0, 20.0, 8.0]));
        let half = point_at(&start, &quarter, &quarter.end, 0.5);
        let side = 15.0 * 0.5_f64.sqrt();
        assert!([side, side, 4.0].iter().zip(half.0).all(|(a, b)| (a - b).abs() < 1e-12), "{half:?}");
        // About (3, 4), a third of a clockwise quarter from the right: radius 12, 30 degrees below.
        let off =
            step(MoveKind::Arc { plane: Plane::Xy, centre: [3.0, 4.0], sweep: -FRAC_PI_2 }, at([3.0, -12.0, 0.0]));
        let third = point_at(&at([13.0, 4.0, 0.0]), &off, &off.end, 1.0 / 3.0);
        let wanted = [3.0 + 12.0 * 0.75_f64.sqrt(), 4.0 - 6.0];
        assert!(wanted.iter().zip(third.0).all(|(a, b)| (a - b).abs() < 1e-12), "{third:?}");
    }

    #[test]
    fn lengths_and_pieces_are_of_the_way_gone_wherever_it_begins() {
        let mut start = at([100.0, 200.0, 300.0]);
        (start[Axis::A], start[Axis::W]) = (50.0, 400.0);
        let mut end = start;
        for (axis, by) in [(Axis::X, 2.0), (Axis::Y, 3.0), (Axis::Z, 6.0)] {
            end[axis] += by;
        }
        let by_mm = Sampling { step_mm: 1.0, ..COARSE };
        let straight = step(MoveKind::Feed, end);
        assert!((length(&start, &straight) - 7.0).abs() < 1e-12);
        assert_eq!(pieces(&start, &straight, &end, &by_mm), 7);
        // Half a turn about (97, 196), radius 5, up by 3.
        let mut across = at([94.0, 192.0, 303.0]);
        (across[Axis::A], across[Axis::W]) = (50.0, 400.0);
        let helix =
            step(MoveKind::Arc { plane: Plane::Xy, centre: [97.0, 196.0], sweep: std::f64::consts::PI }, across);
        assert!((length(&start, &helix) - (5.0 * std::f64::consts::PI).hypot(3.0)).abs() < 1e-12);
        assert_eq!(pieces(&start, &helix, &across, &by_mm), 16);
        let sampling = Sampling { chord_mm: 0.01, ..COARSE }; // 2 acos(1 - 0.002) = 0.12652: 24.8 in half a turn
        assert_eq!(pieces(&start, &helix, &across, &sampling), 25);
        let quarter = point_at(&start, &helix, &across, 0.5);
        let wanted = [97.0 - 4.0, 196.0 + 3.0, 301.5, 50.0];
        assert!(wanted.iter().zip(quarter.0).all(|(a, b)| (a - b).abs() < 1e-12), "{quarter:?}");
    }

    #[test]
    fn lengths_and_pieces_of_straight_and_helical_moves() {
        let mut end = at([2.0, 3.0, 6.0]); // 7 mm
        assert!((length(&Position::default(), &step(MoveKind::Feed, end)) - 7.0).abs() < 1e-12);
        let cut = |from: &Position, of: &Move, sampling| pieces(from, of, &of.end, &sampling);
        let by_mm = Sampling { step_mm: 1.0, ..COARSE };
        assert_eq!(cut(&Position::default(), &step(MoveKind::Feed, end), by_mm), 7);
        // U, V, W are a second triple: 24 mm, which count in the length where X, Y and Z stand still; A does not count beside them.
        (end[Axis::V], end[Axis::A]) = (24.0, 1.0);
        assert!((length(&Position::default(), &step(MoveKind::Feed, end)) - 7.0).abs() < 1e-12);
        let mut beside = at([2.0, 3.0, 6.0]);
        beside[Axis::A] = 2.0;
        assert!((length(&beside, &step(MoveKind::Feed, end)) - 24.0).abs() < 1e-12);
        assert_eq!(cut(&Position::default(), &step(MoveKind::Feed, end), by_mm), 24);
        // Turns of 90 and 45 degrees: the larger decides how many samples, both the length.
        let mut turned = Position::default();
        (turned[Axis::A], turned[Axis::C]) = (FRAC_PI_2, -FRAC_PI_2 / 2.0);
        let turn = step(MoveKind::Feed, turned);
        assert!((length(&Position::default(), &turn) - 90.0_f64.hypot(45.0)).abs() < 1e-9);
        assert_eq!(cut(&Position::default(), &turn, Sampling { step_deg: 2.0, ..COARSE }), 45);
        // A helix of radius 10: 0.3 radians are 3 mm along the circle, with 4 mm of Z 5 mm along the thread.
        let helix = arc(0.3, [10.0 * 0.3_f64.cos(), 10.0 * 0.3_f64.sin(), 4.0]);
        let start = at([10.0, 0.0, 0.0]);
        assert!((length(&start, &helix) - 5.0).abs() < 1e-12);
        assert_eq!(cut(&start, &helix, by_mm), 5);
        // What goes nowhere is one piece.
        assert_eq!(cut(&start, &step(MoveKind::Dwell { seconds: 1.0 }, end), by_mm), 1);
        assert_eq!(cut(&start, &step(MoveKind::Feed, start), by_mm), 1);
    }
}
