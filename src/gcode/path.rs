//! Sampling: from canonical moves to axis positions along the path.
//!
//! Straight moves are straight in axis space. An arc turns about its centre while all other axes, and the radius where
//! start and end differ, change in proportion to the angle.

use super::canonical::{Axis, Move, MoveKind, Position};
use super::interpret::Program;

/// Most samples of one move. A finer step than this allows is coarsened.
pub const MAX_SAMPLES_PER_MOVE: usize = 10_000_000;

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
#[must_use]
pub fn sample(program: &Program, start: &Position, sampling: &Sampling) -> Vec<Sample> {
    let mut samples = Vec::new();
    let mut from = *start;
    for (move_index, step) in program.moves.iter().enumerate() {
        let pieces = pieces(&from, step, sampling);
        for piece in 1..=pieces {
            let fraction = piece as f64 / pieces as f64;
            let position = if piece == pieces { step.end } else { point_at(&from, step, fraction) };
            let rapid = step.kind == MoveKind::Rapid;
            samples.push(Sample { position, line: step.line, rapid, move_index, fraction });
        }
        from = step.end;
    }
    samples
}

/// The place a part `fraction` of the way along a move from `start`.
#[must_use]
pub fn point_at(start: &Position, step: &Move, fraction: f64) -> Position {
    let mut point = Position(std::array::from_fn(|i| start.0[i] + (step.end.0[i] - start.0[i]) * fraction));
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

/// Length of a move as feed rates mean it: mm along the path of the linear axes, or, for a move that only turns, degrees.
#[must_use]
pub fn length(start: &Position, step: &Move) -> f64 {
    let change = |axis: Axis| step.end[axis] - start[axis];
    let norm = |axes: &[Axis]| axes.iter().map(|&axis| change(axis).powi(2)).sum::<f64>().sqrt();
    if let MoveKind::Arc { plane, centre, sweep } = step.kind {
        let [first, second, normal] = plane.axes();
        let radius = (start[first] - centre[0]).hypot(start[second] - centre[1]);
        let others: Vec<Axis> =
            Axis::ALL.into_iter().filter(|a| !a.is_rotary() && *a != first && *a != second).collect();
        debug_assert!(others.contains(&normal));
        return (radius * sweep).hypot(norm(&others));
    }
    let linear: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| !axis.is_rotary()).collect();
    let along = norm(&linear);
    if along > 1e-9 { along } else { norm(&[Axis::A, Axis::B, Axis::C]).to_degrees() }
}

/// Into how many pieces a move is cut.
fn pieces(start: &Position, step: &Move, sampling: &Sampling) -> usize {
    // What goes nowhere may still change what positions mean: under tool-centre-point control they are the tip's.
    if matches!(step.kind, MoveKind::Dwell { .. } | MoveKind::ToolChange { .. }) {
        return 1;
    }
    let change = |axis: Axis| step.end[axis] - start[axis];
    let length = |axes: [Axis; 3]| axes.map(|axis| change(axis).powi(2)).iter().sum::<f64>().sqrt();
    let mut linear = length([Axis::X, Axis::Y, Axis::Z]).max(length([Axis::U, Axis::V, Axis::W]));
    let rotary = [Axis::A, Axis::B, Axis::C].map(|axis| change(axis).abs()).into_iter().fold(0.0, f64::max);
    let mut needed = count(rotary.to_degrees(), sampling.step_deg);
    if let MoveKind::Arc { plane, centre, sweep } = step.kind {
        let [first, second, normal] = plane.axes();
        let radius = |at: &Position| (at[first] - centre[0]).hypot(at[second] - centre[1]);
        let radius = radius(start).max(radius(&step.end));
        linear = linear.max((radius * sweep).hypot(change(normal)));
        // A chord over the angle a leaves a circle by r (1 - cos(a / 2)).
        if sampling.chord_mm > 0.0 && radius > sampling.chord_mm {
            let angle = 2.0 * (1.0 - sampling.chord_mm / radius).acos();
            needed = needed.max(count(sweep.abs(), angle));
        }
        // Fewer than four pieces to the turn would not look like an arc whatever the tolerance.
        needed = needed.max(count(sweep.abs(), std::f64::consts::FRAC_PI_2));
    }
    needed.max(count(linear, sampling.step_mm)).clamp(1, MAX_SAMPLES_PER_MOVE)
}

/// How many steps a travel needs. A travel that is a whole number of steps but for rounding needs no further one.
fn count(travel: f64, step: f64) -> usize {
    const ROUNDING: f64 = 1e-9;
    if step > 0.0 { (travel / step - ROUNDING).ceil() as usize } else { 1 }
}
