//! Cycles of Fanuc's and Haas's lathes that need no contour: one cut along (G90), one thread (G92), one cut across (G94), pecks (G74,
//! G75), and the threading cycle (G76). Infeed is straight: the angle of G76 moves nothing. The cycles with a contour are in `contour`.
//!
//! R of G74 and G75 is the relief at the bottom: from the second cut on the tool steps aside by it before it returns, back towards the cut before.
//! The first cut has no free side and no relief. Of a single cut the sign of R gives the side, and controls differ: it is an error.
//!
//! Each ends where it began. G90, G92 and G94 hold for the blocks behind them, with the words that these do not give.

use super::dialect::{Dialect, own};
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{Group, Spindle, Values};
use super::offsets::Values9;

/// Index of X and Z.
pub(super) const X: usize = 0;
pub(super) const Z: usize = 2;
/// Most passes of one cycle.
pub(super) const MAX_PASSES: u32 = 10_000;

/// What cycles keep for later blocks, mm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LatheMemory {
    /// Of G71 and G72: depth of a cut, and how far the tool backs off behind it.
    pub depth: f64,
    pub back_off: f64,
    /// Of G73: from the first pass to the last along X and Z, and how many there are.
    pub relief: [f64; 2],
    pub passes: u32,
    /// Of G74 and G75: how far a peck comes back.
    pub peck_back: f64,
    /// Of G76: passes at full depth, least cut, last cut.
    springs: u32,
    least_cut: f64,
    last_cut: f64,
    /// Of G90, G92 and G94: the code, where the cut ends along X and Z, the taper.
    held: Option<(i32, [f64; 2], f64)>,
}

impl Interpreter<'_> {
    /// A length that Fanuc's controls count in thousandths of a millimetre, or tenths of that of an inch, where it has no decimal point.
    pub(super) fn take_count(&self, values: &Values, letter: char) -> Option<f64> {
        if self.setup.dialect != Dialect::Fanuc || values.has_point(letter) {
            return self.take_length(values, letter);
        }
        let least = if self.modes.inches { 1e-4 } else { 1e-3 };
        values.take(letter).map(|count| count * least * self.modes.unit_mm())
    }

    /// A block of one of the cycles.
    pub(super) fn lathe_cycle(&mut self, values: &Values, code: i32) -> Result<(), Fault> {
        match code {
            own::TURN_CUT | own::THREAD_CUT | own::FACE_CUT => self.single_cut(values, code),
            own::PECK_FACE | own::PECK_GROOVE => self.peck_across(values, code),
            _ => self.repeat_thread(values),
        }
    }

    /// G90, G92, G94.
    fn single_cut(&mut self, values: &Values, code: i32) -> Result<(), Fault> {
        let held = self.lathe.held.filter(|held| held.0 == code);
        let start = self.position;
        let mut target = self.target(values);
        for (at, axis, letters) in [(0, X, ['x', 'u']), (1, Z, ['z', 'w'])] {
            if !letters.iter().any(|&letter| values.has(letter)) {
                let missing = || values.motion_fault(Cause::Missing("X and Z, where the cut ends,"));
                target[axis] = held.ok_or_else(missing)?.1[at];
            }
        }
        let of_haas = if code == own::FACE_CUT { 'k' } else { 'i' };
        let letter = if self.setup.dialect == Dialect::Haas && values.has(of_haas) { of_haas } else { 'r' };
        let taper = self.take_length(values, letter).or(held.map(|held| held.2)).unwrap_or(0.0);
        self.lathe.held = Some((code, [target[X], target[Z]], taper));
        let place = |x: f64, z: f64| {
            let mut place = target;
            (place[X], place[Z]) = (x, z);
            place
        };
        match code {
            own::FACE_CUT => {
                self.rapid_to(place(start[X], target[Z] + taper))?;
                self.feed_to(target, values)?;
                self.feed_to(place(target[X], start[Z]), values)?;
            }
            own::THREAD_CUT => {
                self.refuse_still_spindle(values)?;
                // The angle at which a thread of several starts begins.
                values.drop_word('q');
                self.rapid_to(place(target[X] + taper, start[Z]))?;
                self.synchronous_to(target, self.modes.feed)?;
                self.rapid_to(place(start[X], target[Z]))?;
            }
            _ => {
                self.rapid_to(place(target[X] + taper, start[Z]))?;
                self.feed_to(target, values)?;
                self.feed_to(place(start[X], target[Z]), values)?;
            }
        }
        self.rapid_to(start)
    }

    fn refuse_still_spindle(&self, values: &Values) -> Result<(), Fault> {
        match self.modes.spindle {
            Spindle::Still if self.driven_rpm() == 0.0 => {
                Err(values.motion_fault(Cause::NotAllowed("a thread while the spindle stands still")))
            }
            _ if self.modes.feed <= 0.0 => Err(values.motion_fault(Cause::Missing("F, the pitch,"))),
            _ => Ok(()),
        }
    }

    /// Whether the block says where to go along X or Z; without, it sets a cycle up.
    pub(super) fn has_lathe_target(values: &Values) -> bool {
        "xzuw".chars().any(|letter| values.has(letter))
    }

    /// G74: pecks along Z at places along X, P apart; G75: pecks along X at places along Z, Q apart.
    fn peck_across(&mut self, values: &Values, code: i32) -> Result<(), Fault> {
        if !Self::has_lathe_target(values) {
            self.lathe.peck_back = self.take_length(values, 'r').unwrap_or(0.0).abs();
            return Ok(());
        }
        let (start, target) = (self.position, self.target(values));
        // Haas's controls call the steps along X and Z by I and K, in the unit of lengths.
        let step_along =
            |count, length| self.take_count(values, count).or_else(|| self.take_length(values, length)).map(f64::abs);
        let (p, q) = (step_along('p', 'i'), step_along('q', 'k'));
        let relief = self.take_length(values, 'r').unwrap_or(0.0).abs();
        let (along, across, peck, step) = if code == own::PECK_FACE { (Z, X, q, p) } else { (X, Z, p, q) };
        let stops = |from: f64, to: f64, step: Option<f64>| -> Result<Vec<f64>, Fault> {
            let steps =
                step.filter(|&step| step > 0.0).map_or(1.0, |step| ((to - from).abs() / step - 1e-9).ceil().max(1.0));
            if steps > f64::from(MAX_PASSES) {
                return Err(values
                    .motion_fault(Cause::Limit { limit: MAX_PASSES as usize, what: "pecks or places of one cycle" }));
            }
            let step = step.filter(|_| steps > 1.0).unwrap_or(0.0).copysign(to - from);
            Ok((1..steps as u32).map(|i| from + f64::from(i) * step).chain([to]).collect())
        };
        let mut places = vec![start[across]];
        if start[across] != target[across] {
            places.extend(stops(start[across], target[across], step)?);
        }
        if relief > 0.0 && (places.len() == 1 || step.is_none()) {
            let why = "R, the relief at the bottom, in a cycle with a single cut or without a step between cuts: its sign would give the side, and controls differ; remove R or give the step";
            return Err(values.fault('r', Cause::NotAllowed(why)));
        }
        let aside = relief.copysign(start[across] - target[across]);
        let depths = stops(start[along], target[along], peck)?;
        let back = self.lathe.peck_back.copysign(start[along] - target[along]);
        for (cut, place) in places.into_iter().enumerate() {
            let mut at = start;
            at[across] = place;
            self.rapid_to(at)?;
            for (i, &depth) in depths.iter().enumerate() {
                at[along] = depth;
                self.feed_to(at, values)?;
                if i + 1 < depths.len() {
                    at[along] = depth + back;
                    self.rapid_to(at)?;
                }
            }
            if cut > 0 && relief > 0.0 {
                at[across] += aside;
                self.rapid_to(at)?;
            }
            at[along] = start[along];
            self.rapid_to(at)?;
        }
        self.rapid_to(start)
    }

    /// G76: a block without X and Z sets it up (P: passes at full depth, run-out, angle; Q least cut; R last cut), the next cuts (P or K the
    /// thread's height, Q or D the first cut, R the taper, F the pitch; beside K, P is the cutting method: 1 and 2 cut equal areas, 3 and 4 equal depths).
    fn repeat_thread(&mut self, values: &Values) -> Result<(), Fault> {
        if !Self::has_lathe_target(values) {
            let digits = values.take_whole('p', 0..=999_999, "P", "six digits: passes, run-out, angle")?.unwrap_or(0);
            self.lathe.springs = (digits / 10_000).unsigned_abs();
            self.lathe.least_cut = self.take_count(values, 'q').unwrap_or(0.0).abs();
            self.lathe.last_cut = self.take_count(values, 'r').unwrap_or(0.0).abs();
            return Ok(());
        }
        self.refuse_still_spindle(values)?;
        let needed = |value: Option<f64>, what| {
            value.map(f64::abs).filter(|&value| value > 0.0).ok_or_else(|| values.motion_fault(Cause::Missing(what)))
        };
        let (height, method) = match self.take_length(values, 'k') {
            Some(height) => (Some(height), values.take_whole('p', 1..=4, "P", "a cutting method from 1 to 4")?),
            None => (self.take_count(values, 'p'), None),
        };
        let height = needed(height, "P or K, the height of the thread,")?;
        let first = self.take_count(values, 'd').or_else(|| self.take_count(values, 'q'));
        // Beside D it is the angle at which a thread of several starts begins.
        values.drop_word('q');
        let first = needed(first, "Q or D, the first depth of cut,")?;
        let taper = self.take_length(values, 'r').or_else(|| self.take_length(values, 'i')).unwrap_or(0.0);
        values.drop_word('a');
        let (start, target) = (self.position, self.target(values));
        let outwards = (start[X] - target[X]).signum();
        let LatheMemory { springs, least_cut, last_cut, .. } = self.lathe;
        let rough = (height - last_cut).max(0.0);
        let mut depth = 0.0;
        for pass in 1..=MAX_PASSES {
            let cuts = if matches!(method, Some(3 | 4)) { f64::from(pass) } else { f64::from(pass).sqrt() };
            depth = (first * cuts).max(depth + least_cut).min(rough);
            if depth <= 0.0 || depth >= rough {
                break;
            }
            self.thread_at(&start, &target, outwards * (height - depth), taper)?;
            if pass == MAX_PASSES {
                return Err(
                    values.motion_fault(Cause::Limit { limit: MAX_PASSES as usize, what: "passes of one thread" })
                );
            }
        }
        if last_cut > 0.0 && rough > 0.0 {
            self.thread_at(&start, &target, outwards * last_cut, taper)?;
        }
        for _ in 0..springs.max(1) {
            self.thread_at(&start, &target, 0.0, taper)?;
        }
        Ok(())
    }

    /// One pass of a thread, `above` its root; back to the start.
    fn thread_at(&mut self, start: &Values9, target: &Values9, above: f64, taper: f64) -> Result<(), Fault> {
        let place = |x: f64, z: f64| {
            let mut place = *start;
            (place[X], place[Z]) = (x, z);
            place
        };
        let root = target[X] + above;
        self.rapid_to(place(root + taper, start[Z]))?;
        self.synchronous_to(place(root, target[Z]), self.modes.feed)?;
        self.rapid_to(place(start[X], target[Z]))?;
        self.rapid_to(*start)
    }

    /// Forgets what G90, G92 and G94 hold, when another code stands in the block.
    pub(super) fn forget_held_cut(&mut self, values: &Values) {
        if values.number(Group::Motion).is_some_and(|code| self.lathe.held.is_some_and(|held| held.0 != code)) {
            self.lathe.held = None;
        }
    }
}
