//! The path of a program: axis positions, and the time at which the machine is there.
//!
//! No acceleration. A feed move takes its length over its rate, or longer where an axis would go faster than it may; a rapid
//! move as long as its slowest axis needs at its rapid rate. A feed whose rate hangs on a spindle speed that is not known takes
//! what its axes need.

use crate::scene::pairs::{Range, Reach};
use crate::scene::{ProgramRun, Scene, TipFault};
use rs274::{Move, MoveKind, Plane, Position, Sample, path};
use std::collections::BTreeMap;

/// A program's samples with their times. Place 0 is where the machine stands at first, place n + 1 is sample n; places
/// between are straight between their neighbours.
pub struct Path<'a> {
    run: &'a ProgramRun,
    samples: Vec<Sample>,
    /// The tool in the spindle during each move.
    tools: Vec<u32>,
    /// When each move begins, s, and when the last one ends.
    begins: Vec<f64>,
    /// For each sample, whether a probe comes to it, or goes back to it.
    probing: Vec<bool>,
}

impl<'a> Path<'a> {
    /// Samples a program as its run says.
    ///
    /// # Errors
    /// When the program is too long, or moves the tool's tip as the machine cannot.
    pub fn new(scene: &Scene, run: &'a ProgramRun) -> Result<Self, TipFault> {
        let samples = run.samples(&scene.machine, &run.sampling, &scene.rates.rapid_path)?;
        let (mut begins, mut from, mut time) = (vec![0.0], run.start, 0.0);
        let mut rest = samples.as_slice();
        let mut axes_from = run.start;
        for (index, step) in run.program.moves.iter().enumerate() {
            let (own, behind) = rest.split_at(rest.iter().take_while(|sample| sample.move_index == index).count());
            let rates = if step.kind == MoveKind::Rapid { &scene.rates.rapid } else { &scene.rates.feed };
            let by_rate = match step.kind {
                MoveKind::Feed | MoveKind::Arc { .. } => {
                    step.feed_mm_min.map_or(0.0, |feed| 60.0 * path::length(&from, step) / feed)
                }
                MoveKind::Dwell { seconds } => seconds,
                MoveKind::Rapid | MoveKind::ToolChange { .. } => 0.0,
            };
            time += by_rate.max(axes_s(&axes_from, own, rates));
            begins.push(time);
            from = step.end;
            axes_from = own.last().map_or(axes_from, |sample| sample.position);
            rest = behind;
        }
        let probing = probing(run, &samples);
        Ok(Self { run, samples, tools: run.tools(), begins, probing })
    }

    /// The samples.
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// The range of every axis over the program, and over what of it each tool is in the spindle.
    pub fn reach(&self) -> Reach {
        let mut axes = Range::at(self.position(0));
        let mut tools = BTreeMap::from([(self.tool(0), axes)]);
        for at in 1..=self.samples.len() {
            let position = self.position(at);
            axes.take_in(&position);
            tools.entry(self.tool(at)).or_insert_with(|| Range::at(position)).take_in(&position);
        }
        Reach { axes, tools: Some(tools) }
    }

    /// The tool in the spindle at a whole place and on the way to it.
    pub fn tool(&self, at: usize) -> u32 {
        if at == 0 { self.run.setup.tool } else { self.tools[self.samples[at - 1].move_index] }
    }

    /// The position at a whole place.
    pub fn position(&self, at: usize) -> Position {
        if at == 0 { self.run.start } else { self.samples[at - 1].position }
    }

    /// The position at any place.
    pub fn position_at(&self, place: f64) -> Position {
        let (at, part) = (place.floor() as usize, place.fract());
        if part == 0.0 {
            return self.position(at);
        }
        let (from, to) = (self.position(at), self.position(at + 1));
        Position(std::array::from_fn(|i| from.0[i] + part * (to.0[i] - from.0[i])))
    }

    /// The sample that a place belongs to: the one it leads to.
    pub fn sample_at(&self, place: f64) -> &Sample {
        &self.samples[(place.ceil() as usize).clamp(1, self.samples.len()) - 1]
    }

    /// The program's moves.
    pub fn moves(&self) -> &[Move] {
        &self.run.program.moves
    }

    /// The move that a place belongs to.
    pub fn step(&self, place: f64) -> &Move {
        &self.run.program.moves[self.sample_at(place).move_index]
    }

    /// Whether a probe goes to a place, or back from where it ends on its own way: its tip may touch the workpiece, and cuts nothing.
    pub fn is_probing(&self, place: f64) -> bool {
        place > 0.0 && self.probing[place.ceil() as usize - 1]
    }

    /// The time at a place, s from the program's start.
    pub fn time_s(&self, place: f64) -> f64 {
        if place <= 0.0 {
            return 0.0;
        }
        let index = self.sample_at(place).move_index;
        let (begin, end) = (self.begins[index], self.begins[index + 1]);
        begin + self.fraction(place) * (end - begin)
    }

    /// How much of the move that a place belongs to is done there, 0 to 1.
    pub fn fraction(&self, place: f64) -> f64 {
        if place <= 0.0 {
            return 0.0;
        }
        let to = self.sample_at(place);
        let before = (place.ceil() as usize).checked_sub(2).map(|at| &self.samples[at]);
        let from = before.filter(|before| before.move_index == to.move_index).map_or(0.0, |before| before.fraction);
        let part = if place.fract() == 0.0 { 1.0 } else { place.fract() };
        from + part * (to.fraction - from)
    }

    /// The plane before any G17, G18 or G19: that of Z and X on lathes.
    pub const fn first_plane(&self) -> Plane {
        self.run.setup.plane
    }

    /// Line of the program at a place; 0 before its first move.
    pub fn line_at(&self, place: f64) -> u32 {
        if place <= 0.0 { 0 } else { self.sample_at(place).line }
    }

    /// How far an arc, or the way of a tool's tip, may be from the chords between samples, mm.
    pub const fn chord_mm(&self) -> f64 {
        self.run.sampling.chord_mm
    }

    /// How long the program takes, s.
    pub fn duration_s(&self) -> f64 {
        self.begins.last().copied().unwrap_or(0.0)
    }

    /// Text of a line of the program.
    pub fn block(&self, line: u32) -> &str {
        self.run.block(line)
    }
}

/// For each sample, whether a probe comes to it, or goes back to it on the line on which it came. What goes forward again, or on from where the probe set out, is no
/// way back.
fn probing(run: &ProgramRun, samples: &[Sample]) -> Vec<bool> {
    // Where the probe set out, and how far on its way it still is.
    let mut way: Option<[Position; 2]> = None;
    let mut from = run.start;
    let is_probing = |sample: &Sample| {
        let (start, to) = (from, sample.position);
        from = to;
        let step = &run.program.moves[sample.move_index];
        if step.is_probe {
            // Where there is a way, it sets out on it.
            let first = way.filter(|[first, _]| is_between(&start, first, &to)).map(|[first, _]| first);
            way = Some([first.unwrap_or(start), to]);
            return true;
        }
        let is_other_tool = matches!(step.kind, MoveKind::ToolChange { .. });
        way = way.filter(|[first, last]| !is_other_tool && is_between(&to, first, last)).map(|[first, _]| [first, to]);
        way.is_some()
    };
    samples.iter().map(is_probing).collect()
}

/// Whether a position lies on the straight line between two others, up to rounding.
fn is_between(position: &Position, first: &Position, last: &Position) -> bool {
    let apart = |a: &Position, b: &Position| (0..9).map(|i| (a.0[i] - b.0[i]).powi(2)).sum::<f64>().sqrt();
    apart(first, position) + apart(position, last) - apart(first, last) <= 1e-9
}

/// How long the axes need at their rates for the way through `samples`, s: between two of them, as long as the slowest.
pub(super) fn axes_s(from: &Position, samples: &[Sample], rates: &[f64; 9]) -> f64 {
    let mut from = from;
    let mut minutes = 0.0;
    for Sample { position, .. } in samples {
        let slowest = (0..9).map(|i| (position.0[i] - from.0[i]).abs() / rates[i]).fold(0.0, f64::max);
        minutes += slowest;
        from = position;
    }
    60.0 * minutes
}
