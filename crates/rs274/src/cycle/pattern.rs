//! Haas's G70, G71 and G72 of mills: holes on a circle, on an arc and along a line, by the canned cycle that is active (mill operator's manual, "G70 Bolt
//! Hole Circle", "G71 Bolt Hole Arc", "G72 Bolt Holes Along an Angle").
//!
//! The tool stands at the centre, or goes there by X and Y of the block. I is the radius or the distance of the holes, J the angle of the first hole or of
//! the line, counter-clockwise from X, K the angle from hole to hole on an arc, L their number. The block holds for itself alone.

use super::super::canonical::{Axis, Plane};
use super::super::dialect::own;
use super::super::error::{Cause, Fault};
use super::super::interpret::Interpreter;
use super::super::modal::{FeedMode, Group, Values};
use super::{MAX_REPEATS, is_cycle};

/// Note on G72.
const BOTH_ENDS: &str = "G72: whether the first hole is where the tool stands or a step away is not known; both are drilled here, one hole more than L";

/// Note on a pattern behind L0 with a place.
const SKIPPED_PLACE: &str = "X or Y beside L0 before G70, G71 or G72: whether the tool goes there is not known; here the pattern is about where the tool stands";

/// Places of holes about a centre.
#[derive(Clone, Copy, Debug)]
struct Pattern {
    code: i32,
    /// Radius, or distance from hole to hole, mm.
    length: f64,
    /// Angles of the first hole or the line, and from hole to hole, degrees.
    start: f64,
    step: f64,
    holes: i32,
}

impl Pattern {
    /// The places, from the centre.
    fn places(self) -> impl Iterator<Item = [f64; 2]> {
        let Self { code, length, start, step, holes } = self;
        let is_line = code == own::HOLES_ON_LINE;
        (0..holes + i32::from(is_line)).map(move |hole| {
            let hole = f64::from(hole);
            let (radius, angle) = if is_line { (hole * length, start) } else { (length, start + hole * step) };
            let (sin, cos) = angle.to_radians().sin_cos();
            [radius * cos, radius * sin]
        })
    }
}

impl Interpreter<'_> {
    /// A block of G70, G71 or G72.
    pub(in super::super) fn drill_pattern(&mut self, values: &Values, code: i32) -> Result<(), Fault> {
        let fault = |cause| values.fault_at(Group::NonModal, cause);
        let active = self.modes.motion.filter(|&motion| is_cycle(motion) && motion == self.sticky.code);
        let without = "G70, G71 or G72 without an active cycle (G73, G74, G76, G81 to G89)";
        let cycle = active.ok_or_else(|| fault(Cause::NotAllowed(without)))?;
        self.refuse_other_plane(values)?;
        let pattern = self.read_pattern(values, code)?;
        if self.sticky.skips_place && !(values.has('x') && values.has('y')) {
            self.note_unknown(SKIPPED_PLACE.to_owned());
        }
        if code == own::HOLES_ON_LINE {
            self.note_unknown(BOTH_ENDS.to_owned());
        }
        self.go_to_centre(values)?;
        let centre = self.offsets.to_program(&self.position);
        let mut height = centre[Axis::Z as usize];
        let initial = self.sticky.initial.unwrap_or(height);
        let hole = self.held_hole(values, cycle, Axis::Z, initial)?;
        self.note_low_start(pattern.holes, height, initial, hole.retract);
        self.note_missing_points(values, "jk");
        for [x, y] in pattern.places() {
            let places = [(0, centre[0] + x, false), (1, centre[1] + y, false)];
            self.above_hole(values, &places, (hole.normal, height))?;
            self.along(&hole, hole.retract, None)?;
            self.drill(&hole, values)?;
            height = hole.clear;
        }
        Ok(())
    }

    fn read_pattern(&self, values: &Values, code: i32) -> Result<Pattern, Fault> {
        let missing = |what| values.fault_at(Group::NonModal, Cause::Missing(what));
        let length =
            self.take_length(values, 'i').ok_or_else(|| missing("I, the radius or the distance of the holes,"))?;
        if length <= 0.0 {
            return Err(values.fault('i', Cause::Range("I", "above 0")));
        }
        let range = "a whole number from 1 to 100000";
        let holes = values.take_whole('l', 1..=MAX_REPEATS, "L", range)?;
        let holes = holes.ok_or_else(|| missing("L, the number of holes,"))?;
        let step = match code {
            own::HOLES_ON_CIRCLE => 360.0 / f64::from(holes),
            own::HOLES_ON_ARC => values.take('k').ok_or_else(|| missing("K, the angle from hole to hole,"))?,
            _ => 0.0,
        };
        Ok(Pattern { code, length, start: values.take('j').unwrap_or(0.0), step, holes })
    }

    /// Refuses a pattern or a pocket of Haas's where its manual does not tell what it does.
    pub(in super::super) fn refuse_other_plane(&self, values: &Values) -> Result<(), Fault> {
        let is_other =
            self.modes.plane != Plane::Xy || self.modes.polar || self.modes.feed_mode == FeedMode::InverseTime;
        let why = "G12, G13 or G70 to G72 outside the XY plane (G17), in polar coordinates (G16) or in G93";
        if is_other { Err(values.fault_at(Group::NonModal, Cause::NotAllowed(why))) } else { Ok(()) }
    }

    /// Rapid to X and Y of the block of a pattern or a pocket, if they are there.
    pub(in super::super) fn go_to_centre(&mut self, values: &Values) -> Result<(), Fault> {
        let mut program = self.offsets.to_program(&self.position);
        let before = program;
        for axis in [Axis::X, Axis::Y] {
            if let Some((value, is_step)) = self.take_axis_or_step(values, axis) {
                self.note_step_behind_turn(axis as usize, is_step.then_some(value));
                if !is_step {
                    self.note_unset_origin();
                }
                program[axis as usize] = value + if is_step { before[axis as usize] } else { 0.0 };
            }
        }
        if program == before {
            return Ok(());
        }
        let target = self.offsets.to_machine(&program);
        self.rapid_to(target)
    }
}
