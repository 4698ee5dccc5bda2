//! `,R` and `,C` of Fanuc's and Haas's controls: the corner between two straight feeds is rounded, or cut off at a length from its point.
//!
//! C without a comma is an angle of the axis C, with a note where a control without that axis may take it for a chamfer.
//!
//! The first move waits until the second is known; between them nothing else may move.

use super::arc::Circle;
use super::canonical::MoveKind;
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{Group, Spindle, Values};
use super::offset_curve::{minus, norm, plus_scaled};
use super::offsets::Values9;
use std::f64::consts::PI;

/// Directions that differ from straight on, or straight back, by less, radians, make no corner.
const STRAIGHT: f64 = 1e-9;

/// What is wrong where a corner has no second move.
pub(super) const OPEN_CORNER: Cause =
    Cause::NotAllowed("a corner (`,R` or `,C`) needs a straight feed move (G1) right behind its own");

/// Note on C without a comma where it may be a corner.
const BARE_CHAMFER: &str = "C of a straight feed along X or Z while the spindle turns is taken for an angle of the axis C; a control without that axis cuts a chamfer, to be written as `,C`";

/// A straight move that waits for the next.
#[derive(Clone, Debug)]
pub(super) struct Corner {
    /// Where it begins, as axis positions.
    from: Values9,
    feed: Option<f64>,
    /// Radius, or distance from the point of the corner, mm.
    size: f64,
    rounds: bool,
    line: u32,
    /// The corner's word.
    pub text: String,
}

impl Interpreter<'_> {
    /// G1: with `,R` or `,C` it waits, behind such a move it begins where the corner ends.
    pub(super) fn feed_with_corners(&mut self, target: Values9, values: &Values) -> Result<(), Fault> {
        if let Some(corner) = self.corner.take() {
            self.cut_corner(&corner, &target, values)?;
        }
        self.note_bare_chamfer(values);
        let (radius, length) = (self.take_length(values, 'R'), self.take_length(values, 'C'));
        let (size, rounds) = match (radius, length) {
            (None, None) => return self.feed_to(target, values),
            (Some(radius), None) => (radius, true),
            (None, Some(length)) => (length, false),
            (Some(_), Some(_)) => return Err(values.fault('C', Cause::NotAllowed("`,R` and `,C` at one corner"))),
        };
        let letter = if rounds { 'R' } else { 'C' };
        if size <= 0.0 {
            return Err(values.fault(letter, Cause::Range("a corner", "larger than 0")));
        }
        let text = values.fault(letter, OPEN_CORNER).text;
        let feed = self.straight_feed(&target, values)?;
        self.corner = Some(Corner { from: self.position, feed, size, rounds, line: self.line, text });
        self.position = target;
        Ok(())
    }

    /// Notes C in a feed along one of X and Z while a lathe's spindle turns.
    fn note_bare_chamfer(&mut self, values: &Values) {
        let moves = |letters: [char; 2]| letters.iter().any(|&letter| values.has(letter));
        let is_along_one = moves(['x', 'u']) != moves(['z', 'w']);
        let turns = self.setup.is_fanuc_lathe() && self.modes.spindle != Spindle::Still;
        if turns && is_along_one && values.has('c') {
            self.note_unknown(BARE_CHAMFER.to_owned());
        }
    }

    /// A fault when the program ends at a corner.
    pub(super) fn refuse_open_corner(&self, values: &Values) -> Result<(), Fault> {
        match &self.corner {
            Some(corner) => Err(Fault { text: corner.text.clone(), ..self.fault_at(values, Group::Stop, OPEN_CORNER) }),
            None => Ok(()),
        }
    }

    /// The waiting move and the corner; the position is then where the next move begins.
    fn cut_corner(&mut self, corner: &Corner, next: &Values9, values: &Values) -> Result<(), Fault> {
        let fault = |cause| Fault::new(1, corner.text.clone(), cause);
        let point = self.position;
        let plane = self.modes.plane;
        let similar =
            self.offsets.similar(plane).ok_or_else(|| fault(Cause::NotAllowed("a corner in a tilted plane")))?;
        let axes = plane.axes().map(|axis| axis as usize);
        let leaves = |other: &Values9| (0..9).any(|i| i != axes[0] && i != axes[1] && other[i] != point[i]);
        if leaves(&corner.from) || leaves(next) {
            return Err(fault(Cause::NotAllowed("a corner of moves that leave the plane")));
        }
        let flat = |position: &Values9| [position[axes[0]], position[axes[1]]];
        let at = flat(&point);
        let (back, on) = (minus(flat(&corner.from), at), minus(flat(next), at));
        let size = corner.size * similar.scale;
        let (before, after) = (norm(back), norm(on));
        let between = (back[0] * on[1] - back[1] * on[0]).atan2(back[0] * on[0] + back[1] * on[1]);
        let opening = between.abs();
        if before <= 0.0 || after <= 0.0 || !(STRAIGHT..=PI - STRAIGHT).contains(&opening) {
            return Err(fault(Cause::NotAllowed("a corner between moves that go straight on, or back, or nowhere")));
        }
        let length = if corner.rounds { size / (opening / 2.0).tan() } else { size };
        if length > before || length > after {
            return Err(fault(Cause::Arc("the corner is longer than one of its two moves")));
        }
        let (back, on) = (back.map(|x| x / before), on.map(|x| x / after));
        let raised = |flat: [f64; 2]| {
            let mut position = point;
            (position[axes[0]], position[axes[1]]) = (flat[0], flat[1]);
            position
        };
        let ends = [plus_scaled(at, length, back), plus_scaled(at, length, on)].map(raised);
        let line = std::mem::replace(&mut self.line, corner.line);
        self.position = corner.from;
        self.straight_to(ends[0], MoveKind::Feed, corner.feed, values)?;
        if corner.rounds {
            let middle = [back[0] + on[0], back[1] + on[1]];
            let centre = plus_scaled(at, size / (opening / 2.0).sin() / norm(middle), middle);
            // The path turns by what is left of half a turn, towards the side of the corner's inside.
            let sweep = (PI - opening).copysign(-between);
            self.round_to(ends[1], &Circle { centre, sweep }, corner.feed, values)?;
        } else {
            self.straight_to(ends[1], MoveKind::Feed, corner.feed, values)?;
        }
        self.line = line;
        Ok(())
    }
}
