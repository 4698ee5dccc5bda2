//! Threads: G33, a move in step with the spindle, G33.1, tapping, and G76, the threading cycle (LinuxCNC, "G33", "G33.1", "G76").
//!
//! Pass n of G76 goes J n^(1/R) deep below the thread's peak until it is K deep, then H more times. Each pass starts
//! further along by the tangent of the compound slide's angle Q; E and L cut the entry or the exit as a slope.

use super::canonical::Plane;
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{Group, Spindle, Values};

/// A cut this near the full depth, mm, is the full depth but for rounding.
const ROUNDING_MM: f64 = 1e-9;
/// Least pitch of G33, mm: a smaller one is no thread, and takes no finite time.
const LEAST_PITCH_MM: f64 = 1e-6;
/// Most passes of one thread.
const MAX_PASSES: u32 = 10_000;
/// Index of X and Z.
const X: usize = 0;
const Z: usize = 2;

/// A threading cycle, in axis positions, mm.
struct Thread {
    pitch: f64,
    /// Where the cycle starts: the drive line.
    start: [f64; 9],
    /// Where every pass ends.
    end_z: f64,
    /// +1 for an inside thread, which is cut towards larger X; -1 for an outside one.
    inward: f64,
    /// From the drive line to the thread's peak, and from there to its bottom.
    peak: f64,
    height: f64,
    /// Tangent of the compound slide's angle, signed with the direction of travel.
    slide: f64,
    /// Length of a sloped end along Z, signed against the direction of travel; 0 for none.
    slope: f64,
    slope_in: bool,
    slope_out: bool,
}

impl Interpreter<'_> {
    /// G33: a straight move whose feed is K per revolution; G33.1 goes back the same way, I times as fast, at least as fast as in.
    pub(super) fn thread_move(&mut self, values: &Values, returns: bool) -> Result<(), Fault> {
        let fault = |cause| self.fault_at(values, Group::Motion, cause);
        let pitch = if self.setup.is_fanuc_lathe() {
            // The pitch is F, and Q the angle at which a thread of several starts begins.
            values.drop_word('q');
            Some(self.modes.feed)
        } else {
            self.take_length(values, 'k')
        };
        let pitch = pitch.ok_or_else(|| fault(Cause::Missing("K, the pitch,")))?;
        if pitch.abs() < LEAST_PITCH_MM {
            return Err(values.fault('k', Cause::Range("K, the pitch,", "at least 1e-6 mm")));
        }
        if !values.has_axis() {
            return Err(fault(Cause::Missing("an axis word")));
        }
        if self.modes.spindle == Spindle::Still && self.driven_rpm() == 0.0 {
            return Err(fault(Cause::NotAllowed("a thread while the spindle stands still")));
        }
        let (start, target) = (self.position, self.target(values));
        self.synchronous_to(target, pitch)?;
        if !returns {
            return Ok(());
        }
        let speed = self.modes.speed;
        self.modes.speed *= values.take('i').map_or(1.0, |times| times.max(1.0));
        let back = self.synchronous_to(start, pitch);
        self.modes.speed = speed;
        back
    }

    /// A move that feeds `pitch` mm for each revolution.
    pub(super) fn synchronous_to(&mut self, target: [f64; 9], pitch: f64) -> Result<(), Fault> {
        let feed = self.synchronous_rate(pitch.abs(), &target);
        self.feed_at(target, feed)
    }

    /// G76.
    pub(super) fn thread_cycle(&mut self, values: &Values) -> Result<(), Fault> {
        let fault = |cause| self.fault_at(values, Group::Motion, cause);
        if self.modes.plane != Plane::Zx {
            return Err(fault(Cause::NotAllowed("G76 outside the ZX plane (G18)")));
        }
        let needed = |letter, what| self.take_length(values, letter).ok_or_else(|| fault(Cause::Missing(what)));
        let pitch = needed('p', "P, the pitch,")?;
        // In G7 they are diameters, as X is.
        let part = if self.modes.diameter { 0.5 } else { 1.0 };
        let peak = part * needed('i', "I, the offset of the thread's peak,")?;
        let first_cut = part * needed('j', "J, the first depth of cut,")?;
        let height = part * needed('k', "K, the depth of the thread,")?;
        for (letter, value) in [('p', pitch), ('j', first_cut), ('k', height)] {
            if value <= 0.0 {
                return Err(values.fault(letter, Cause::Range("P, J and K", "above 0")));
            }
        }
        if first_cut > height {
            return Err(values.fault('j', Cause::Range("J", "at most K")));
        }
        let degression = values.take('r').unwrap_or(1.0).max(1.0);
        let angle = values.take('q').unwrap_or(0.0);
        if !(0.0..90.0).contains(&angle) {
            return Err(values.fault('q', Cause::Range("Q", "from 0 to less than 90")));
        }
        let springs = values.take_whole('h', 0..=1000, "H", "a whole number from 0 to 1000")?.unwrap_or(0);
        let slope = self.take_length(values, 'e').unwrap_or(0.0).max(0.0);
        let ends = values.take_whole('l', 0..=3, "L", "0, 1, 2 or 3")?.unwrap_or(0);
        if values.has('x') {
            return Err(values.fault('x', Cause::NotAllowed("a tapered thread")));
        }
        if !values.has('z') {
            return Err(fault(Cause::Missing("Z, the end of the thread,")));
        }
        if self.modes.spindle == Spindle::Still {
            return Err(fault(Cause::NotAllowed("G76 while the spindle stands still")));
        }
        let target = self.target(values);
        let backwards = if target[Z] > self.position[Z] { -1.0 } else { 1.0 };
        let thread = Thread {
            pitch,
            start: self.position,
            end_z: target[Z] + height * backwards * angle.to_radians().tan(),
            inward: if peak > 0.0 { 1.0 } else { -1.0 },
            peak: peak.abs(),
            height,
            slide: backwards * angle.to_radians().tan(),
            slope: backwards * slope,
            slope_in: slope > 0.0 && ends & 1 != 0,
            slope_out: slope > 0.0 && ends & 2 != 0,
        };
        for pass in 1..=MAX_PASSES {
            let cut = first_cut * f64::from(pass).powf(1.0 / degression);
            if cut >= height - ROUNDING_MM {
                for _ in 0..=springs {
                    self.thread_pass(&thread, height)?;
                }
                return self.rapid_to(target);
            }
            self.thread_pass(&thread, cut)?;
        }
        Err(values.fault('j', Cause::Limit { limit: MAX_PASSES as usize, what: "passes of one thread" }))
    }

    /// One pass, `cut` mm below the peak.
    fn thread_pass(&mut self, thread: &Thread, cut: f64) -> Result<(), Fault> {
        let at = |depth: f64, z: f64| {
            let mut point = thread.start;
            point[X] += thread.inward * depth;
            point[Z] = z;
            point
        };
        let along = cut * thread.slide;
        let (from, to) = (thread.start[Z] - along, thread.end_z - along);
        let bottom = thread.peak + cut;
        // Where the tool waits beside the part: as far out as the last pass's start is from the drive line.
        let out = cut - thread.height;
        let above = bottom - thread.height;
        let slope_pitch = thread.pitch * thread.slope.hypot(thread.height) / thread.slope.abs();
        self.rapid_to(at(out, from))?;
        if thread.slope_in {
            self.synchronous_to(at(above, from), slope_pitch)?;
            self.synchronous_to(at(bottom, from - thread.slope), slope_pitch)?;
        } else {
            self.rapid_to(at(bottom, from))?;
        }
        if thread.slope_out {
            self.synchronous_to(at(bottom, to + thread.slope), thread.pitch)?;
            self.synchronous_to(at(above, to), slope_pitch)?;
        } else {
            self.synchronous_to(at(bottom, to), thread.pitch)?;
        }
        self.rapid_to(at(out, to))
    }
}
