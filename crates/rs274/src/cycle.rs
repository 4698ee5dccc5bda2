//! Canned cycles: G73, G74 and G81 to G89, in any plane (LinuxCNC, "Canned Cycles").
//!
//! A cycle drills along the plane's normal. It goes above the hole, comes to R, does what its code says, and ends at R (G99) or where the first
//! of consecutive cycles started (G98). In G91 R counts from there, the bottom from R, and L repeats it a step further each time. R, the
//! bottom, P and Q hold for the next block of the same cycle, on Fanuc's controls of any cycle up to G80: on Fanuc's and Haas's controls R and the
//! bottom as heights, on LinuxCNC as numbers that each block reads again in its own mode and unit; there the height of G98 is such a number, too.
//!
//! How it goes above the hole depends on the control. Fanuc's and Haas's go at the height where they are. LinuxCNC goes to R first, up or down,
//! if the first of consecutive cycles started below R. From above R it goes at its height; else it goes straight to the height where the cycle ends,
//! which is never below R (`interp_cycles.cc`, `CYCLE_MACRO`).
//!
//! G87 bores from behind: it goes down beside the hole, by the words of the plane's two axes among I, J and K, then into its middle, feeds
//! up to the third of those words and back, and leaves as it came (NISTIR 6556, section 3.5.16.7). At the pause of G88 an operator draws the tool
//! out; that is a rapid move here.
//!
//! Haas's G70 to G72 drill the cycle that is active in many places (`pattern`).

use super::canonical::{Axis, MoveKind, Plane};
use super::dialect::{Dialect, own};
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{FeedMode, Group, Spindle, Values};
use super::offsets::Values9;

mod pattern;

/// How far above the last depth a pecking cycle stops its rapid return, mm: LinuxCNC's 0.254.
const PECK_CLEARANCE_MM: f64 = 0.254;

/// Heights that differ by less are one.
const ROUNDING_MM: f64 = 1e-9;

/// Most holes of one block, and most pecks of one hole.
const MAX_REPEATS: i32 = 100_000;

/// Note on Fanuc's and Haas's `G76`.
/// Note on a hole whose depth G51 scales.
const SCALED_HOLE: &str = "G51 scales R and the depth of the hole; whether Haas's controls do is not known";

const STEP_ASIDE: &str = "G76 steps aside by its Q (or I and J) at the bottom of the hole, and goes up there; which way is a setting of the machine: the step is not examined";

/// Note on Fanuc's taps with Q.
const TAP_IN_PECKS: &str = "Q of G74 and G84: the tap goes down in one go here, past the same places as in pecks";

/// Note on Haas's `G73` with Q and K.
const UP_AFTER_PECKS: &str = "K beside Q of G73: the ways up to R after each K are left out; they lie in the hole";

/// Words that hold for the next block of the same cycle, on Fanuc's controls of any cycle: mm and seconds. On Fanuc's and Haas's controls `bottom`,
/// `retract` and `middle` are heights in program coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sticky {
    /// The code they belong to, ten times its number.
    code: i32,
    bottom: f64,
    retract: f64,
    dwell_s: f64,
    /// On Fanuc's controls the last Q, whatever it meant.
    pecks: Pecks,
    beside: [f64; 2],
    middle: f64,
    /// Where the first of consecutive cycles started along the normal, program coordinates.
    initial: Option<f64>,
    /// Whether the block had L0 and also X or Y of another place.
    skips_place: bool,
}

impl Sticky {
    /// The same words in a unit that is smaller by `factor`.
    pub fn unscaled(&self, factor: f64) -> Self {
        Self {
            bottom: self.bottom / factor,
            retract: self.retract / factor,
            pecks: self.pecks.unscaled(factor),
            beside: self.beside.map(|step| step / factor),
            middle: self.middle / factor,
            initial: self.initial.map(|height| height / factor),
            ..*self
        }
    }
}

/// Depths of pecks, mm: the first, by how much each is less than the one before, and the least. None where the first is zero.
#[derive(Clone, Copy, Debug, Default)]
struct Pecks {
    first: f64,
    less: f64,
    least: f64,
}

impl Pecks {
    /// Pecks of one depth.
    const fn even(depth: f64) -> Self {
        Self { first: depth, less: 0.0, least: depth }
    }

    /// How deep the first `count` of them go together.
    fn depth(&self, count: f64) -> f64 {
        let Self { first, less, least } = *self;
        let shrinking = if less > 0.0 { ((first - least) / less).floor() + 1.0 } else { count };
        let shrunk = count.min(shrinking);
        shrunk * first - less * shrunk * (shrunk - 1.0) / 2.0 + (count - shrunk) * least
    }

    /// The same pecks in a program whose lengths are scaled.
    fn unscaled(&self, factor: f64) -> Self {
        Self { first: self.first / factor, less: self.less / factor, least: self.least / factor }
    }
}

/// One hole, in program coordinates, mm.
#[derive(Clone, Copy, Debug)]
struct Hole {
    code: i32,
    /// Index of the axis that drills.
    normal: usize,
    bottom: f64,
    retract: f64,
    /// Where the cycle ends.
    clear: f64,
    dwell_s: f64,
    pecks: Pecks,
    /// Of G87: from the hole's axis to where the tool goes in, along the plane's axes; and how far up it bores.
    beside: [f64; 2],
    middle: f64,
}

/// Whether a motion code is a cycle that is performed here.
pub(super) const fn is_cycle(code: i32) -> bool {
    matches!(code, 730 | 740 | 810..=890 | own::FINE_BORE)
}

/// Whether a code is a peck drilling cycle.
const fn drills_in_pecks(code: i32) -> bool {
    matches!(code, 730 | 830)
}

/// The letter among I, J and K that belongs to X, Y or Z.
const fn centre_letter(axis: Axis) -> char {
    match axis {
        Axis::X => 'i',
        Axis::Y => 'j',
        _ => 'k',
    }
}

impl Interpreter<'_> {
    /// A block of a cycle.
    pub(super) fn cycle(&mut self, values: &Values, code: i32) -> Result<(), Fault> {
        if self.modes.feed_mode == FeedMode::InverseTime {
            return Err(self.fault_at(values, Group::Motion, Cause::NotAllowed("canned cycles in G93")));
        }
        // On Fanuc's lathes drills go along Z whatever the plane.
        let lathe = self.setup.is_fanuc_lathe();
        let goes_along_x = matches!(code, 870 | 880) || (code == 890 && self.setup.dialect == Dialect::Fanuc);
        if lathe && goes_along_x {
            let why = "G87, G88 and Fanuc's G89 on lathes, which go along X";
            return Err(self.fault_at(values, Group::Motion, Cause::NotAllowed(why)));
        }
        if code == 870 && self.setup.dialect.is_fanuc_like() {
            let why = "G87 of Fanuc's controls, which bores back beside a step by Q, and of Haas's, which waits for the operator to retract";
            return Err(self.fault_at(values, Group::Motion, Cause::NotAllowed(why)));
        }
        let [first, second, normal] = if lathe { Plane::Xy.axes() } else { self.modes.plane.axes() };
        let mut axes = vec![first, second, normal];
        if lathe {
            // C turns the workpiece from hole to hole.
            axes.push(Axis::C);
        }
        let has_step = |axis| self.modes.incremental || self.step_letter(axis).is_some_and(|letter| values.has(letter));
        if axes.iter().any(|&axis| has_step(axis) && self.offset_change[axis as usize] != 0.0) {
            let why = "a cycle with a step (G91, U, V, W or H) right behind another tool offset";
            return Err(self.fault_at(values, Group::Motion, Cause::NotAllowed(why)));
        }
        self.note_waiting_length();
        if !self.modes.incremental {
            self.note_unset_origin();
            self.note_lapsed_length();
        }
        axes.iter().for_each(|&axis| self.offset_change[axis as usize] = 0.0);
        let mut start = self.offsets.to_program(&self.position)[normal as usize];
        let initial = self.sticky.initial.unwrap_or(start);
        self.read_cycle_words(values, code, normal, initial)?;
        let hole = self.held_hole(values, code, normal, initial)?;
        let place =
            |&axis: &Axis| self.take_axis_or_step(values, axis).map(|(value, is_step)| (axis as usize, value, is_step));
        let places: Vec<_> = axes.iter().filter(|&&axis| axis != normal).filter_map(place).collect();
        let mut named = [false; 9];
        places.iter().for_each(|&(axis, _, is_step)| named[axis] = !is_step);
        self.note_turned_place(&named);
        if self.setup.dialect == Dialect::Haas && self.transforms.factor(normal as usize) != 1.0 {
            self.note_unknown(SCALED_HOLE.to_owned());
        }
        let repeats = self.repeats(values)?;
        let here = self.offsets.to_program(&self.position);
        let is_elsewhere =
            |&(axis, value, is_step): &(usize, f64, bool)| value != if is_step { 0.0 } else { here[axis] };
        self.sticky.skips_place = repeats == 0 && places.iter().any(is_elsewhere);
        let (retract, like_fanuc) = (hole.retract, self.setup.dialect.is_fanuc_like());
        if like_fanuc {
            self.note_low_start(repeats, start, initial, retract);
        } else if initial < retract {
            self.along(&hole, retract, None)?;
            start = retract;
        }
        let ends_there = !like_fanuc && start - retract <= ROUNDING_MM;
        let mut height = if ends_there { hole.clear } else { start };
        for _ in 0..repeats {
            self.above_hole(values, &places, (hole.normal, height))?;
            self.along(&hole, retract, None)?;
            self.drill(&hole, values)?;
            height = hole.clear;
        }
        Ok(())
    }

    /// The hole that the words in force describe; the first of consecutive cycles started at the height `initial`.
    fn held_hole(&self, values: &Values, code: i32, normal: Axis, initial: f64) -> Result<Hole, Fault> {
        let like_fanuc = self.setup.dialect.is_fanuc_like();
        let sticky = self.sticky;
        let counts = self.modes.incremental && !like_fanuc;
        let retract = if counts { initial + sticky.retract } else { sticky.retract };
        let bottom = if counts { retract + sticky.bottom } else { sticky.bottom };
        if retract < bottom {
            return Err(self.fault_at(values, Group::Motion, Cause::NotAllowed("R below the bottom of the hole")));
        }
        let highest = if like_fanuc { initial } else { initial.max(retract) };
        Ok(Hole {
            code,
            normal: normal as usize,
            bottom,
            retract,
            clear: if self.modes.retract_to_r { retract } else { highest },
            dwell_s: sticky.dwell_s,
            // G51 does not scale pecks.
            pecks: if drills_in_pecks(code) {
                sticky.pecks.unscaled(self.transforms.factor(normal as usize))
            } else {
                Pecks::default()
            },
            beside: sticky.beside,
            middle: if counts { bottom + sticky.middle } else { sticky.middle },
        })
    }

    /// Notes a cycle of Fanuc's controls that begins or ends below R.
    fn note_low_start(&mut self, repeats: i32, start: f64, initial: f64, retract: f64) {
        let is_low = |height: f64| height < retract - ROUNDING_MM;
        if repeats > 0 && (is_low(start) || !self.modes.retract_to_r && is_low(initial)) {
            self.note(
                "a cycle begins below its R: the tool goes to the hole at that height, and with G98 comes back to it"
                    .to_owned(),
            );
        }
    }

    /// How many holes the block drills: L, on Fanuc's controls K, too. On Fanuc's and Haas's 0 only sets the cycle up. Haas's K is a peck.
    fn repeats(&self, values: &Values) -> Result<i32, Fault> {
        const RANGE: &str = "a whole number up to 100000, at least 1, or 0 in the dialects fanuc and haas";
        let like_fanuc = self.setup.dialect.is_fanuc_like();
        let counts_by_k = self.setup.dialect == Dialect::Fanuc;
        let letter = if counts_by_k && !values.has('l') { 'k' } else { 'l' };
        let least = i32::from(!like_fanuc);
        Ok(values.take_whole(letter, least..=MAX_REPEATS, "the number of holes", RANGE)?.unwrap_or(1))
    }

    /// Q, or Haas's I, J and K. Digits of Q without a decimal point count least increments on Fanuc's controls; what a variable holds is a length.
    fn take_pecks(&self, values: &Values) -> Result<Option<Pecks>, Fault> {
        if self.setup.dialect == Dialect::Haas && values.has('i') {
            let [first, less, least] = ['i', 'j', 'k'].map(|letter| self.take_length(values, letter));
            let missing = || self.fault_at(values, Group::Motion, Cause::Missing("J or K of I, J and K"));
            let pecks = Pecks {
                first: first.unwrap_or_default(),
                less: less.ok_or_else(missing)?,
                least: least.ok_or_else(missing)?,
            };
            if pecks.least <= 0.0 || pecks.less < 0.0 || pecks.first < pecks.least {
                let range = "the first peck, by how much each is less, and the least, above 0 and at most the first";
                return Err(values.fault('i', Cause::Range("I, J and K", range)));
            }
            return Ok(Some(pecks));
        }
        match self.take_q(values) {
            Some(peck) if peck <= 0.0 => Err(values.fault('q', Cause::Range("Q", "above 0"))),
            peck => Ok(peck.map(Pecks::even)),
        }
    }

    /// What the block's Q means to a cycle: pecks; on Fanuc's controls the step aside of G76, too, and what is held for the next cycle is that of
    /// any cycle before. Also takes the words that G73, G74, G76 and G84 have beside it.
    fn read_pecks(&mut self, values: &Values, code: i32, held: Option<Pecks>) -> Result<Pecks, Fault> {
        let (taps, dialect) = (matches!(code, 740 | 840), self.setup.dialect);
        if drills_in_pecks(code) {
            // Without Q Fanuc's controls drill in one go.
            let pecks = self.take_pecks(values)?.or(held).or(dialect.is_fanuc_like().then(Pecks::default));
            if dialect == Dialect::Haas && code == 730 && values.has('q') && values.has('k') {
                values.drop_word('k');
                self.note(UP_AFTER_PECKS.to_owned());
            }
            return pecks.ok_or_else(|| values.motion_fault(Cause::Missing("Q, the depth of a peck,")));
        }
        let own_q =
            if code == own::FINE_BORE || (taps && dialect == Dialect::Fanuc) { self.take_q(values) } else { None };
        let pecks = own_q.map(|depth| Pecks::even(depth.abs())).or(held).unwrap_or_default();
        if code == own::FINE_BORE {
            let parts = ['i', 'j'].map(|letter| self.take_length(values, letter).unwrap_or(0.0));
            if pecks.first != 0.0 || parts != [0.0; 2] {
                self.note_unknown(STEP_ASIDE.to_owned());
            }
        }
        if taps && own_q.is_some() {
            self.note(TAP_IN_PECKS.to_owned());
        }
        if taps && dialect == Dialect::Haas {
            // How many times faster a tap comes out.
            values.drop_word('j');
        }
        Ok(pecks)
    }

    fn take_q(&self, values: &Values) -> Option<f64> {
        if values.lacks_point('q') { self.take_count(values, 'q') } else { self.take_length(values, 'q') }
    }

    /// Takes R, the bottom, P and Q from the block, or from the block before when that was the same cycle, on Fanuc's controls any; the first of
    /// consecutive cycles started at the height `initial`.
    fn read_cycle_words(&mut self, values: &Values, code: i32, normal: Axis, initial: f64) -> Result<(), Fault> {
        let is_same = self.sticky.code == code;
        let goes_over = self.setup.dialect == Dialect::Fanuc && self.sticky.code != 0;
        let before = (is_same || goes_over).then_some(self.sticky);
        let fault = |cause| values.motion_fault(cause);
        let needed =
            |given: Option<f64>, held: Option<f64>, what| given.or(held).ok_or_else(|| fault(Cause::Missing(what)));
        let like_fanuc = self.setup.dialect.is_fanuc_like();
        let counts = like_fanuc && self.modes.incremental;
        let r_counts = counts || (self.setup.dialect == Dialect::Fanuc && self.setup.is_fanuc_lathe());
        // The height of a word that counts from another height.
        let above =
            |from: f64, counts: bool, word: Option<f64>| word.map(|word| if counts { from + word } else { word });
        let retract = above(initial, r_counts, self.take_length(values, 'r'));
        // On lathes R may be left out: it is the initial level then.
        let level = before.map(|s| s.retract).or(self.setup.is_fanuc_lathe().then_some(initial));
        let retract = needed(retract, level, "R, the retract height,")?;
        let bottom = self.take_axis_or_step(values, normal);
        let bottom = bottom.map(|(word, is_step)| if like_fanuc && is_step { retract + word } else { word });
        let bottom = needed(bottom, before.map(|s| s.bottom), "the depth of the hole")?;
        let dwells = matches!(code, 820 | 860 | 880 | 890 | own::FINE_BORE);
        let taps = matches!(code, 740 | 840);
        let may_dwell = dwells || taps || drills_in_pecks(code) || like_fanuc;
        let held = before.filter(|_| is_same || dwells || taps).map(|s| s.dwell_s);
        let mut dwell_s = if may_dwell { self.take_dwell(values, 'p') } else { None }.or(held);
        if dwells && !like_fanuc {
            dwell_s = Some(needed(dwell_s, None, "P, the dwell,")?);
        }
        let pecks = self.read_pecks(values, code, before.map(|s| s.pecks))?;
        if dwell_s.is_some_and(|seconds| seconds < 0.0) {
            return Err(values.fault('p', Cause::Range("P", "at least 0")));
        }
        let (mut beside, mut middle) = ([0.0; 2], 0.0);
        if code == 870 {
            if self.modes.spindle == Spindle::Still {
                return Err(fault(Cause::NotAllowed("G87 while the spindle stands still")));
            }
            let letters = self.modes.plane.axes().map(centre_letter);
            let [first, second, third] = letters.map(|letter| self.take_length(values, letter));
            let before = before.filter(|_| is_same);
            let held = |at: usize| before.map(|s| s.beside[at]);
            let way = "I, J and K, the way in and how far to bore,";
            beside = [needed(first, held(0), way)?, needed(second, held(1), way)?];
            middle = needed(above(bottom, counts, third), before.map(|s| s.middle), way)?;
        }
        let dwell_s = dwell_s.unwrap_or(0.0);
        let initial = Some(initial);
        self.sticky = Sticky { code, bottom, retract, dwell_s, pecks, beside, middle, initial, skips_place: false };
        Ok(())
    }

    /// Rapid to above the next hole, at a height along the normal. `places` are the indices of axes, where they go, and whether that is a step.
    fn above_hole(
        &mut self,
        values: &Values,
        places: &[(usize, f64, bool)],
        (normal, height): (usize, f64),
    ) -> Result<(), Fault> {
        let from = self.offsets.to_program(&self.position);
        let mut program = from;
        program[normal] = height;
        for &(axis, value, is_step) in places {
            self.note_step_behind_turn(axis, is_step.then_some(value));
            if !is_step {
                self.note_roll_over(axis, program[axis], value);
            }
            program[axis] = if is_step { program[axis] + value } else { value };
        }
        if let Some([x, y]) = self.take_polar(values, &from) {
            (program[0], program[1]) = (x, y);
        }
        let target = self.offsets.to_machine(&program);
        self.rapid_to(target)
    }

    /// To a height above the hole: rapid, or at the feed rate for the block `values`.
    fn along(&mut self, hole: &Hole, height: f64, feed: Option<&Values>) -> Result<(), Fault> {
        let mut program = self.offsets.to_program(&self.position);
        if (program[hole.normal] - height).abs() < f64::EPSILON * height.abs().max(1.0) {
            return Ok(());
        }
        program[hole.normal] = height;
        let target = self.at_height(hole, &program);
        match feed {
            Some(values) => self.feed_to(target, values),
            None => self.rapid_to(target),
        }
    }

    /// Where the machine is when only the height in `program` differs from where it is now.
    fn at_height(&self, hole: &Hole, program: &Values9) -> Values9 {
        let machine = self.offsets.to_machine(program);
        let mut target = self.position;
        target[hole.normal] = machine[hole.normal];
        let mixed = self.offsets.mixed_axes();
        if hole.normal < mixed {
            target[..mixed].copy_from_slice(&machine[..mixed]);
        }
        target
    }

    /// Feeds a tap to a height. Outside the XY plane LinuxCNC takes the three coordinates for those of other axes, goes there, and carries on as if it had gone
    /// along the hole. Its own tests (`tests/interp/g84`, 2.9) expect that.
    fn tap_to(&mut self, hole: &Hole, height: f64, values: &Values) -> Result<(), Fault> {
        let plane = self.modes.plane;
        if plane == Plane::Xy || self.setup.dialect != Dialect::LinuxCnc {
            return self.along(hole, height, Some(values));
        }
        self.note(
            "outside G17 LinuxCNC taps along other axes than the hole's: it takes the depth for another axis's word"
                .to_owned(),
        );
        let mut program = self.offsets.to_program(&self.position);
        program[hole.normal] = height;
        let believed = self.at_height(hole, &program);
        let [first, second, normal] = plane.axes().map(|axis| program[axis as usize]);
        let taken = if plane == Plane::Yz { [normal, first, second] } else { [second, normal, first] };
        for (axis, value) in plane.axes().into_iter().zip(taken) {
            program[axis as usize] = value;
        }
        self.feed_to(self.offsets.to_machine(&program), values)?;
        self.position = believed;
        Ok(())
    }

    /// G87, from above the hole at its retract height.
    fn bore_from_behind(&mut self, hole: &Hole, values: &Values) -> Result<(), Fault> {
        let spindle = self.modes.spindle;
        self.step_aside(hole, 1.0)?;
        self.modes.spindle = Spindle::Still;
        self.along(hole, hole.bottom, None)?;
        self.step_aside(hole, -1.0)?;
        self.modes.spindle = spindle;
        self.along(hole, hole.middle, Some(values))?;
        self.along(hole, hole.bottom, Some(values))?;
        self.modes.spindle = Spindle::Still;
        self.step_aside(hole, 1.0)?;
        self.along(hole, hole.clear, None)?;
        self.step_aside(hole, -1.0)?;
        self.modes.spindle = spindle;
        Ok(())
    }

    /// Rapid from the hole's axis to beside it, or back.
    fn step_aside(&mut self, hole: &Hole, sign: f64) -> Result<(), Fault> {
        let mut program = self.offsets.to_program(&self.position);
        let [first, second, _] = self.modes.plane.axes().map(|axis| axis as usize);
        program[first] += sign * hole.beside[0];
        program[second] += sign * hole.beside[1];
        let target = self.offsets.to_machine(&program);
        self.rapid_to(target)
    }

    fn drill(&mut self, hole: &Hole, values: &Values) -> Result<(), Fault> {
        if hole.code == 870 {
            return self.bore_from_behind(hole, values);
        }
        self.peck(hole, values)?;
        let spindle = self.modes.spindle;
        let like_fanuc = self.setup.dialect.is_fanuc_like();
        let taps = matches!(hole.code, 740 | 840);
        if taps {
            if spindle == Spindle::Still && like_fanuc {
                // A rigid tap starts the spindle itself.
                self.modes.spindle = if hole.code == 840 { Spindle::Clockwise } else { Spindle::Counterclockwise };
            }
            self.tap_to(hole, hole.bottom, values)?;
            // A tap turns backwards to come out, and does so before it dwells.
            self.modes.spindle = match self.modes.spindle {
                Spindle::Clockwise => Spindle::Counterclockwise,
                Spindle::Counterclockwise => Spindle::Clockwise,
                Spindle::Still => Spindle::Still,
            };
        } else {
            self.along(hole, hole.bottom, Some(values))?;
        }
        let always = matches!(hole.code, 820 | 860 | 880 | 890) && !like_fanuc;
        if always || ((taps || like_fanuc) && hole.dwell_s > 0.0) {
            self.emit(MoveKind::Dwell { seconds: hole.dwell_s }, None)?;
        }
        if matches!(hole.code, 860 | 880 | own::FINE_BORE) {
            // A boring bar, and what an operator draws out, does not turn.
            self.modes.spindle = Spindle::Still;
        }
        match hole.code {
            // Out at feed all the way, as LinuxCNC does; Fanuc's controls feed to R.
            740 | 840 if !like_fanuc => self.tap_to(hole, hole.clear, values)?,
            890 if !like_fanuc => self.along(hole, hole.clear, Some(values))?,
            740 | 840 | 850 | 890 => self.along(hole, hole.retract, Some(values))?,
            _ => {}
        }
        if taps {
            self.modes.spindle = spindle;
        }
        self.along(hole, hole.clear, None)?;
        self.modes.spindle = spindle;
        Ok(())
    }

    /// The pecks above the bottom: G73 breaks the chip, G83 clears the hole.
    fn peck(&mut self, hole: &Hole, values: &Values) -> Result<(), Fault> {
        if hole.pecks.first <= 0.0 {
            return Ok(());
        }
        for peck in 1..=MAX_REPEATS {
            let depth = hole.retract - hole.pecks.depth(f64::from(peck));
            if depth <= hole.bottom {
                return Ok(());
            }
            self.along(hole, depth, Some(values))?;
            if hole.code == 830 {
                self.along(hole, hole.retract, None)?;
            }
            self.along(hole, depth + PECK_CLEARANCE_MM, None)?;
        }
        Err(values.fault('q', Cause::Limit { limit: MAX_REPEATS as usize, what: "pecks in one hole" }))
    }
}
