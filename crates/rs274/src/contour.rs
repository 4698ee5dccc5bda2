//! Cycles of Fanuc's and Haas's lathes along a contour, which stands between the lines N of P and Q: roughing along Z (G71) and along X
//! (G72), repeating (G73), finishing (G70).
//!
//! Roughing cuts each depth from the start to where it first meets the contour with its allowance, backs off, and goes back; then the
//! contour with its allowance is followed. A pocket behind that first meeting is left to the pass along the contour, as with type I.

use super::canonical::{Axis, MoveKind};
use super::compensation::Compensation;
use super::dialect::own;
use super::error::{Cause, Fault};
use super::interpret::{Interpreter, Next};
use super::lathe::{MAX_PASSES, X, Z};
use super::modal::{Code, Values};
use super::offsets::{Values9, from_canonical};
use super::oword::{FlowTable, Lines};

/// Most lines of a contour.
const MAX_LINES: usize = 10_000;
/// Chords per full turn of a contour's arcs, where a roughing cut looks for it: 0.05 mm off an arc of 100 mm radius.
const CHORDS_PER_TURN: f64 = 100.0;

/// The value of R or D of G73, as messages name it.
const PASSES: &str = "the number of passes, from 1 to 9999";

/// A piece of a contour, in axis positions.
#[derive(Clone, Debug)]
struct Piece {
    to: Values9,
    rapid: bool,
    /// Centre along Z and X, and sweep.
    arc: Option<([f64; 2], f64)>,
    line: u32,
}

/// Whether a code follows a contour.
pub(super) const fn follows_contour(code: i32) -> bool {
    matches!(code, own::FINISH | own::ROUGH_TURN | own::ROUGH_FACE | own::REPEAT_PATTERN)
}

impl Interpreter<'_> {
    /// A block of one of the cycles, at index `at`: the index of the line to go on with.
    pub(super) fn contour_cycle(
        &mut self,
        lines: &Lines,
        table: &FlowTable,
        values: &Values,
        code: &Code,
        at: usize,
    ) -> Result<usize, Fault> {
        if self.in_contour {
            return Err(code.fault(Cause::NotAllowed("a cycle inside a cycle's contour")));
        }
        if !(values.has('p') && values.has('q')) {
            self.set_up_contour_cycle(values, code)?;
            return Ok(at + 1);
        }
        let line = |letter: char| {
            let number = values.take(letter).unwrap_or_default();
            self.only_line_of(table, number, at).map_err(|cause| values.fault(letter, cause))
        };
        let (first, last) = (line('p')?, line('q')?);
        if last < first || last - first >= MAX_LINES || (first..=last).contains(&at) {
            return Err(values
                .fault('q', Cause::Range("Q", "a line behind that of P, at most 10000 lines on, without the cycle")));
        }
        let start = self.position;
        if code.number == own::FINISH {
            self.run_contour(lines, table, first, last)?;
            if self.compensation.on().is_some() {
                let told = "cutter compensation is on where G70 ends: the way back to its start, and what follows, is taken without it";
                self.note_unknown(told.to_owned());
            }
            self.rapid_to(start)?;
            return Ok(at + 1);
        }
        if self.compensation.on().is_some() {
            return Err(code.fault(Cause::NotAllowed("roughing while cutter compensation is on")));
        }
        let allowance = [self.take_x(values, 'u'), self.take_length(values, 'w').unwrap_or(0.0)];
        self.take_contour_words(values, code)?;
        let pieces = self.read_contour(lines, table, first, last)?;
        let Some(first_piece) = pieces.first() else {
            return Err(code.fault(Cause::NotAllowed("a contour that moves nothing")));
        };
        let entry = first_piece.to;
        if code.number == own::REPEAT_PATTERN {
            let passes = self.lathe.passes.clamp(1, MAX_PASSES);
            for pass in (0..passes).rev() {
                let part = if passes > 1 { f64::from(pass) / f64::from(passes - 1) } else { 0.0 };
                let shift = [0, 1].map(|i| allowance[i] + part * self.lathe.relief[i]);
                self.follow_contour(&pieces, shift, values)?;
                self.rapid_to(start)?;
            }
        } else {
            let (across, along) = if code.number == own::ROUGH_TURN { (X, Z) } else { (Z, X) };
            self.rough(&start, &entry, &pieces, allowance, (across, along), values, code)?;
            self.follow_contour(&pieces, allowance, values)?;
            self.rapid_to(start)?;
        }
        Ok(if first > at { last + 1 } else { at + 1 })
    }

    /// Takes D, I and K beside P and Q. Of G73, D is the number of passes, and I (a radius) and K are how far the first is from the last along X and Z.
    /// Of G71 and G72, D is the depth of a cut, and I and K are an allowance that is not followed.
    fn take_contour_words(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        if code.number == own::REPEAT_PATTERN {
            let relief = ['i', 'k'].map(|letter| self.take_length(values, letter));
            let passes = values.take_whole('d', 1..=9999, "D", PASSES)?.map(i32::unsigned_abs);
            self.lathe.passes = passes.unwrap_or(self.lathe.passes);
            if relief != [None, None] && self.lathe.passes == 0 {
                return Err(code.fault(Cause::Missing("D, the number of passes,")));
            }
            self.lathe.relief = [0, 1].map(|i| relief[i].unwrap_or(self.lathe.relief[i]));
            return Ok(());
        }
        if let Some(depth) = self.take_count(values, 'd') {
            self.lathe.depth = depth.abs();
        }
        let allowance = ['i', 'k'].map(|letter| values.take(letter));
        if allowance.into_iter().flatten().any(|length| length != 0.0) {
            self.note_unknown("I and K of G71 and G72, an allowance of the roughing cuts, are not followed".to_owned());
        }
        values.drop_word('r');
        Ok(())
    }

    /// A length along X in the program's words: a diameter or a radius; 0 without the word.
    fn take_x(&self, values: &Values, letter: char) -> f64 {
        let length = self.take_length(values, letter).unwrap_or(0.0);
        if self.modes.diameter { length / 2.0 } else { length }
    }

    /// The first of two blocks: G71 U R, G72 W R, G73 U W R.
    fn set_up_contour_cycle(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        let needed = |value: Option<f64>| {
            value.ok_or_else(|| code.fault(Cause::Missing("P and Q, or the depth of cut U or W,")))
        };
        match code.number {
            own::ROUGH_TURN => self.lathe.depth = needed(self.take_length(values, 'u'))?.abs(),
            own::ROUGH_FACE => self.lathe.depth = needed(self.take_length(values, 'w'))?.abs(),
            own::REPEAT_PATTERN => {
                self.lathe.relief = ['u', 'w'].map(|letter| self.take_length(values, letter).unwrap_or(0.0));
                let passes = values.take_whole('r', 1..=9999, "R", PASSES)?;
                self.lathe.passes = passes.unwrap_or(1).unsigned_abs();
                return Ok(());
            }
            _ => return Err(code.fault(Cause::Missing("P and Q, the lines of the contour,"))),
        }
        self.lathe.back_off = self.take_length(values, 'r').unwrap_or(0.0).abs();
        Ok(())
    }

    /// Executes the lines of a contour, one after another.
    fn run_contour(&mut self, lines: &Lines, table: &FlowTable, first: usize, last: usize) -> Result<(), Fault> {
        let (line, at) = (self.line, self.at);
        self.in_contour = true;
        for index in first..=last {
            self.at = index;
            if index < table.own {
                self.line = index as u32 + 1;
            }
            self.steps += 1;
            let block = lines[index].as_ref().map_err(Clone::clone)?;
            let plain = block.flow.is_none() && block.jump.is_none() && block.condition.is_none();
            let next = if plain { self.execute(block, lines, table, index)? } else { Next::End };
            if next != Next::Line(index + 1) {
                return Err(Fault::new(1, "", Cause::NotAllowed("a jump or an end inside a cycle's contour")));
            }
        }
        self.in_contour = false;
        (self.line, self.at) = (line, at);
        Ok(())
    }

    /// The contour's pieces: its lines are executed without cutter compensation and T, and all that they change but variables is undone.
    fn read_contour(
        &mut self,
        lines: &Lines,
        table: &FlowTable,
        first: usize,
        last: usize,
    ) -> Result<Vec<Piece>, Fault> {
        let (position, modes, sticky, before) = (self.position, self.modes.clone(), self.sticky, self.moves.len());
        let offset_change = self.offset_change;
        let (offsets, tools) = (self.offsets.clone(), self.tools.clone());
        self.ignores_compensation = true;
        let outcome = self.run_contour(lines, table, first, last);
        self.ignores_compensation = false;
        self.in_contour = false;
        let moves = self.moves.split_off(before.min(self.moves.len()));
        self.corner = None;
        self.offset_change = offset_change;
        (self.position, self.modes, self.sticky, self.compensation) = (position, modes, sticky, Compensation::Off);
        outcome?;
        if self.offsets != offsets || self.tools != tools {
            let why = "another zero or tool offset inside the contour of G71, G72 or G73";
            return Err(Fault::new(1, "", Cause::NotAllowed(why)));
        }
        let piece = |step: super::canonical::Move| {
            let (rapid, arc) = match step.kind {
                MoveKind::Rapid => (true, None),
                MoveKind::Feed => (false, None),
                MoveKind::Arc { plane, centre, sweep } => match plane.axes() {
                    [Axis::Z, Axis::X, _] => (false, Some((centre, sweep))),
                    _ => return None,
                },
                MoveKind::Dwell { .. } | MoveKind::ToolChange { .. } => return None,
            };
            Some(Piece { to: from_canonical(&step.end), rapid, arc, line: step.line })
        };
        Ok(moves.into_iter().filter_map(piece).collect())
    }

    /// Follows the contour, shifted along X and Z, at the cycle's feed.
    fn follow_contour(&mut self, pieces: &[Piece], shift: [f64; 2], values: &Values) -> Result<(), Fault> {
        let line = self.line;
        for piece in pieces {
            let target = shifted(&piece.to, shift);
            self.line = piece.line;
            match piece.arc {
                _ if piece.rapid => self.rapid_to(target)?,
                None => self.feed_to(target, values)?,
                Some((centre, sweep)) => {
                    let feed = self.straight_feed(&target, values)?;
                    self.position = target;
                    let centre = [centre[0] + shift[1], centre[1] + shift[0]];
                    self.emit(MoveKind::Arc { plane: super::canonical::Plane::Zx, centre, sweep }, feed)?;
                }
            }
        }
        self.line = line;
        Ok(())
    }

    /// The cuts of G71 and G72, down to the contour with its allowance. `axes` are the indices of the axes across the cuts and along them.
    #[expect(clippy::too_many_arguments, reason = "all of them are the cycle")]
    fn rough(
        &mut self,
        start: &Values9,
        entry: &Values9,
        pieces: &[Piece],
        allowance: [f64; 2],
        (across, along): (usize, usize),
        values: &Values,
        code: &Code,
    ) -> Result<(), Fault> {
        let depth = self.lathe.depth;
        if depth <= 0.0 {
            return Err(code.fault(Cause::Missing("the depth of cut: U or W of a block before, or D,")));
        }
        let outline = outline(pieces, allowance);
        let bottom = shifted(entry, allowance)[across];
        let sign = (bottom - start[across]).signum();
        let enters_at_rapid = pieces.first().is_some_and(|piece| piece.rapid);
        let place = |a: f64, l: f64| {
            let mut place = *start;
            (place[across], place[along]) = (a, l);
            place
        };
        for pass in 1..=MAX_PASSES {
            let level = start[across] + sign * f64::from(pass) * depth;
            if sign * (bottom - level) <= 0.0 {
                return self.rapid_to(*start);
            }
            let end = meeting(&outline, level, sign, (across, along));
            let down = place(level, start[along]);
            if enters_at_rapid {
                self.rapid_to(down)?;
            } else {
                self.feed_to(down, values)?;
            }
            self.feed_to(place(level, end), values)?;
            let back = self.lathe.back_off.min((start[along] - end).abs()).copysign(start[along] - end);
            let lifted = level - sign * self.lathe.back_off;
            self.rapid_to(place(lifted, end + back))?;
            self.rapid_to(place(lifted, start[along]))?;
        }
        Err(code.fault(Cause::Limit { limit: MAX_PASSES as usize, what: "cuts of one cycle" }))
    }
}

fn shifted(place: &Values9, [x, z]: [f64; 2]) -> Values9 {
    let mut place = *place;
    place[X] += x;
    place[Z] += z;
    place
}

/// The contour as points, with its allowance; arcs as chords.
fn outline(pieces: &[Piece], allowance: [f64; 2]) -> Vec<Values9> {
    let mut points: Vec<Values9> = Vec::with_capacity(pieces.len());
    for piece in pieces {
        if let (Some((centre, sweep)), Some(from)) = (piece.arc, points.last().copied()) {
            let centre = [centre[0] + allowance[1], centre[1] + allowance[0]];
            let (along, across) = (from[Z] - centre[0], from[X] - centre[1]);
            let (radius, angle) = (along.hypot(across), across.atan2(along));
            let chords = (sweep.abs() / std::f64::consts::TAU * CHORDS_PER_TURN).ceil().clamp(1.0, 1000.0);
            for chord in 1..chords as u32 {
                let (sin, cos) = (angle + sweep * f64::from(chord) / chords).sin_cos();
                let mut point = from;
                (point[Z], point[X]) = (centre[0] + radius * cos, centre[1] + radius * sin);
                points.push(point);
            }
        }
        points.push(shifted(&piece.to, allowance));
    }
    points
}

/// Where a cut at `level` first meets the outline, along; its end when it never does.
fn meeting(outline: &[Values9], level: f64, sign: f64, (across, along): (usize, usize)) -> f64 {
    // Above zero where the outline lies deeper than the cut.
    let deeper = |point: &Values9| sign * (point[across] - level);
    for pair in outline.windows(2) {
        let [before, after] = [&pair[0], &pair[1]].map(deeper);
        if before > 0.0 && after <= 0.0 {
            let part = before / (before - after);
            return pair[0][along] + part * (pair[1][along] - pair[0][along]);
        }
    }
    outline.last().map_or(0.0, |point| point[along])
}
