//! What Fanuc's and Haas's controls do otherwise: dwells, tool calls of lathes, more coordinate systems, G10, system variables.

use super::canonical::{Axis, MoveKind};
use super::cycle::is_cycle;
use super::datum::{ORIGIN_STRIDE, ORIGINS, SYSTEMS};
use super::dialect::{Dialect, own};
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{CANCEL_CYCLE, FeedMode, Group, Values, whole};
use super::offsets::{Offsets, Values9, from_canonical};
use super::setup::MORE_OFFSETS;

/// Origins of G54.1 P1 and on; the first have other numbers, too (`parameters`).
const FURTHER_ORIGINS: usize = 14_001;
/// LinuxCNC's orientation of each of Fanuc's tips, 0 to 9: X points the other way in Fanuc's figures than in LinuxCNC's.
const ORIENTATIONS: [u8; 10] = [0, 4, 3, 2, 1, 5, 8, 7, 6, 9];
/// Most coordinate systems behind G59.
const MORE_SYSTEMS: i32 = MORE_OFFSETS as i32;

/// Where the origin of a system stands among the variables.
pub(super) const fn origin_of(system: usize) -> usize {
    match system.checked_sub(SYSTEMS) {
        None => ORIGINS + system * ORIGIN_STRIDE,
        Some(more) => FURTHER_ORIGINS + more * ORIGIN_STRIDE,
    }
}

/// Numbers of offsets that hold until others are given.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OffsetNumbers {
    /// H of mills, and whether G43 or G44 is in force.
    pub length: Option<u32>,
    pub adds_length: bool,
    /// Whether G28, G30 or G53 has moved Z since then: Fanuc's controls cancel the length, and a parameter says until when.
    pub lapses: bool,
    /// D of mills; of lathes the offset of T.
    pub radius: Option<u32>,
}

impl Interpreter<'_> {
    /// Whether H and D are numbers of offsets that hold: on Fanuc's and Haas's mills.
    pub(super) fn has_offset_numbers(&self) -> bool {
        self.setup.dialect.is_fanuc_like() && !self.setup.is_fanuc_lathe()
    }

    /// Takes H and D of a mill's block.
    pub(super) fn keep_offset_numbers(&mut self, values: &Values) -> Result<(), Fault> {
        if !self.has_offset_numbers() {
            return Ok(());
        }
        let range = "a whole number from 0 to 99999";
        if let Some(number) = values.take_whole('h', 0..=99_999, "H", range)?.map(i32::unsigned_abs) {
            let changes = self.numbers.length != Some(number) && values.code(Group::ToolLength).is_none();
            if changes && (self.numbers.adds_length || self.tip_mm.is_some()) {
                let why = "another H while a tool length offset is in force; G43 H changes it";
                return Err(values.fault('h', Cause::NotAllowed(why)));
            }
            self.numbers.length = Some(number);
            self.numbers.lapses = false;
        }
        if let Some(number) = values.take_whole('d', 0..=99_999, "D", range)?.map(i32::unsigned_abs) {
            let changes = self.numbers.radius != Some(number) && values.number(Group::CutterCompensation) != Some(400);
            if changes && self.compensation.on().is_some() {
                return Err(values.fault('d', Cause::NotAllowed("another D while cutter compensation is on")));
            }
            self.numbers.radius = Some(number);
        }
        Ok(())
    }

    /// The seconds of a dwell: P in milliseconds, or with a decimal point in seconds.
    pub(super) fn take_dwell(&self, values: &Values, letter: char) -> Option<f64> {
        let counts = letter == 'p' && self.setup.dialect.is_fanuc_like() && !values.has_point('p');
        values.take(letter).map(|value| if counts { value / 1000.0 } else { value })
    }

    /// Haas's M109: the operator's key goes into the variable of P, whatever the program has put there before.
    pub(super) fn ask_operator(&mut self, values: &Values) -> Result<(), Fault> {
        let missing =
            || values.fault_at(Group::Signal, Cause::Missing("P, the variable that the operator's key goes into,"));
        let number = values.take('p').ok_or_else(missing)?;
        let given = self.setup.parameters.get(&format!("{number}")).copied();
        self.parameters.ask(number, given).map_err(|cause| values.fault('p', cause))
    }

    /// T of a lathe, as in T0101: the tool, and the number of its offset, which holds from now on.
    pub(super) fn call_lathe_tool(&mut self, values: &Values) -> Result<(), Fault> {
        let range = "a tool and its offset, as in T0101";
        let Some(word) = values.take_whole('t', 0..=9999, "T", range)? else { return Ok(()) };
        if self.ignores_compensation {
            self.note("T in the contour of G71, G72 or G73 is of the finishing tool: only G70 calls it".to_owned());
            return Ok(());
        }
        let (tool, offset) = (word.unsigned_abs() / 100, word.unsigned_abs() % 100);
        if tool == 0 && offset != 0 {
            return Err(values.fault('t', Cause::Range("T", range)));
        }
        if self.compensation.on().is_some() {
            return Err(values.fault('t', Cause::NotAllowed("another tool while cutter compensation is on")));
        }
        if tool != 0 {
            self.selected_tool = tool;
            if tool != self.tool {
                self.tool = tool;
                self.emit(MoveKind::ToolChange { tool }, None)?;
            }
        }
        self.numbers.radius = Some(offset);
        let before = self.offsets.tool;
        self.offsets.tool = match self.tools.get(&offset) {
            Some(entry) if offset != 0 => from_canonical(&entry.offset),
            None if offset != 0 => return Err(values.fault('t', Cause::UnknownTool)),
            _ => [0.0; 9],
        };
        self.note_offset_change(&before);
        Ok(())
    }

    /// The coordinate system of G54 to G59, G54.1 P, G154 P and G110 to G129.
    pub(super) fn system_of(&mut self, values: &Values, number: i32) -> Result<usize, Fault> {
        let more = match number {
            1100..=1290 => (number - 1100) / 10 + 1,
            541 if self.has_other_use_of_p(values) => {
                let why = "another code that takes P beside G54.1 or G154: give it a block of its own";
                return Err(self.fault_at(values, Group::Coordinates, Cause::NotAllowed(why)));
            }
            541 => self.take_system(values)?.ok_or_else(|| {
                self.fault_at(values, Group::Coordinates, Cause::Missing("P, the number of the coordinate system,"))
            })?,
            540 if self.setup.dialect == Dialect::Fanuc => self.system_of_g54(values)?,
            _ => 0,
        };
        let system = match more {
            1.. => SYSTEMS as i32 + more - 1,
            _ if number < 590 => (number - 540) / 10,
            _ => 5 + number - 590,
        };
        Ok(system.unsigned_abs() as usize)
    }

    /// The number of the further system that Fanuc's G54 selects, 0 for G54 itself. Its P makes it G54.1, but where another code takes P: then that depends on
    /// the control.
    fn system_of_g54(&mut self, values: &Values) -> Result<i32, Fault> {
        let drills = match values.number(Group::Motion) {
            Some(code) => is_cycle(code),
            None => values.has_axis() && self.modes.motion.is_some_and(is_cycle),
        };
        if !drills && !self.has_other_use_of_p(values) && !values.may_be_left('p') {
            return Ok(self.take_system(values)?.unwrap_or(0));
        }
        if let Some(number) = values.take('p').and_then(whole).filter(|number| (1..=MORE_SYSTEMS).contains(number)) {
            self.note_unknown(format!(
                "G54 beside another code with P is taken for G54; a control with further coordinate systems may take it for G54.1 P{number}"
            ));
        }
        Ok(0)
    }

    /// Whether a code of the block other than that of a coordinate system, or of a cycle that may dwell, takes P.
    fn has_other_use_of_p(&self, values: &Values) -> bool {
        let groups = [Group::Subprogram, Group::Orient, Group::Driven, Group::Signal, Group::User, Group::Scale];
        groups.iter().any(|&group| values.code(group).is_some())
            || matches!(values.number(Group::NonModal), Some(40 | 100 | 300 | 531))
            || values.number(Group::Motion).is_some_and(|code| code >= own::FINISH)
    }

    fn take_system(&self, values: &Values) -> Result<Option<i32>, Fault> {
        values.take_whole('p', 1..=MORE_SYSTEMS, "P", "a coordinate system from 1 to 298")
    }

    /// G10: L2 sets origins, L20 those of G54.1, L10 a mill tool's length and L12 its radius, on Haas's controls its diameter; in G91 they add.
    pub(super) fn set_fanuc_data(&mut self, values: &Values) -> Result<(), Fault> {
        let at_code = |cause| self.fault_at(values, Group::NonModal, cause);
        let kind = values.take_whole('l', 0..=99, "L", "a whole number")?;
        let is_lathe = self.setup.is_fanuc_lathe();
        if is_lathe && (matches!(kind, Some(10 | 11)) || (kind.is_none() && self.setup.dialect == Dialect::Fanuc)) {
            return self.set_lathe_offset(values, kind);
        }
        match kind.ok_or_else(|| at_code(Cause::Missing("L")))? {
            kind @ (2 | 20) => {
                let range = if kind == 2 { 1..=6 } else { 1..=MORE_SYSTEMS };
                let number =
                    values.take_whole('p', range, "P", "a coordinate system: 1 to 6 with L2, 1 to 298 with L20")?;
                let number = number.ok_or_else(|| at_code(Cause::Missing("P, the coordinate system,")))?;
                let system = number.unsigned_abs() as usize - 1 + if kind == 2 { 0 } else { SYSTEMS };
                if system == self.modes.system {
                    let why = "another origin of the system in force while cutter compensation is on";
                    self.refuse_compensated(values, Group::NonModal, why)?;
                }
                let base = origin_of(system);
                for axis in Axis::ALL {
                    if let Some(value) = self.take_axis(values, axis) {
                        let at = base + axis as usize;
                        let old = if self.modes.incremental { self.parameters.at(at) } else { 0.0 };
                        self.parameters.put(at, old + value);
                    }
                }
                if system == self.modes.system {
                    self.select_system(system);
                }
                Ok(())
            }
            kind @ 10..=13 if !is_lathe => {
                let number = values.take_whole('p', 1..=9999, "P", "the number of an offset from 1 to 9999")?;
                let number = number.ok_or_else(|| at_code(Cause::Missing("P, the number of the offset,")))?;
                let value = self.take_length(values, 'r').ok_or_else(|| at_code(Cause::Missing("R, the offset,")))?;
                if kind % 2 == 1 && value != 0.0 {
                    return Err(values.fault('r', Cause::NotAllowed("a wear offset other than 0")));
                }
                let is_haas = self.setup.dialect == Dialect::Haas;
                if kind == 12 && is_haas {
                    self.note_unknown(
                        "G10 L12 is taken for a diameter; where Setting 40 is RADIUS it is a radius".to_owned(),
                    );
                }
                let part = if self.modes.incremental { 1.0 } else { 0.0 };
                let tool = self.tools.entry(number.unsigned_abs()).or_default();
                match kind {
                    10 => tool.offset[Axis::Z] = part * tool.offset[Axis::Z] + value,
                    12 => tool.diameter_mm = part * tool.diameter_mm + if is_haas { value } else { 2.0 * value },
                    _ => {}
                }
                Ok(())
            }
            _ => Err(values.fault('l', Cause::Unsupported)),
        }
    }

    /// G10 L10 of lathes: X, Z, the nose radius R and the tip Q of an offset; U and W add. L11 sets its wear. Without L, which Fanuc's controls allow, P is
    /// the number of a wear, or 10000 more than that of an offset.
    fn set_lathe_offset(&mut self, values: &Values, kind: Option<i32>) -> Result<(), Fault> {
        let at_code = |cause| self.fault_at(values, Group::NonModal, cause);
        let range = "the number of an offset from 1 to 9999, or without L 10000 more";
        let number = values.take_whole('p', 1..=19_999, "P", range)?.map(i32::unsigned_abs);
        let number = number.ok_or_else(|| at_code(Cause::Missing("P, the number of the offset,")))?;
        let (is_wear, offset) = match kind {
            Some(kind) => (kind == 11, number),
            None => (number < 10_000, number % 10_000),
        };
        if !(1..=9999).contains(&offset) {
            return Err(values.fault('p', Cause::Range("P", range)));
        }
        let words = [Axis::X, Axis::Y, Axis::Z].map(|axis| (axis, self.take_axis_or_step(values, axis)));
        let radius = self.take_length(values, 'r');
        let mut tool = self.tools.get(&offset).copied().unwrap_or_default();
        if is_wear {
            let mut lengths = words.iter().filter_map(|(_, word)| word.map(|(length, _)| length)).chain(radius);
            if lengths.any(|length| length != 0.0) {
                return Err(at_code(Cause::NotAllowed("a wear offset other than 0")));
            }
        } else {
            for (axis, word) in words {
                if let Some((length, is_step)) = word {
                    tool.offset[axis] = length + if is_step { tool.offset[axis] } else { 0.0 };
                }
            }
            tool.diameter_mm = radius.map_or(tool.diameter_mm, |radius| 2.0 * radius);
        }
        if let Some(tip) = values.take_whole('q', 0..=9, "Q", "a tip from 0 to 9")? {
            tool.orientation = ORIENTATIONS[tip.unsigned_abs() as usize];
        }
        self.tools.insert(offset, tool);
        Ok(())
    }

    /// G50 S and G92 S: the greatest spindle speed under G96.
    pub(super) fn limit_speed(&mut self, values: &Values) -> bool {
        let limits = matches!(values.number(Group::NonModal), Some(own::SPEED_LIMIT | 920));
        let limits = limits && self.setup.dialect.is_fanuc_like() && values.has('s') && !values.has_axis();
        if limits {
            self.modes.greatest_speed = values.take('s').filter(|&limit| limit != 0.0).map(f64::abs);
        }
        limits
    }

    /// Program coordinates of axis positions as `#5041` and `#5061` give them: Fanuc's leave the tool offset in, and so tell where the spindle or turret is.
    pub(super) fn reading(&self, position: &Values9) -> Values9 {
        if self.setup.dialect != Dialect::Fanuc {
            return self.offsets.to_program(position);
        }
        let offsets = Offsets { tool: [0.0; 9], ..self.offsets.clone() };
        let mut reading = offsets.to_program(position);
        reading[Axis::Z as usize] += self.tip_mm.unwrap_or(0.0);
        reading
    }

    /// Brings the system variables up to date: where the tool is (axis positions), where the last block ends and what the position display reads (in the
    /// program's units), and the modes.
    pub(super) fn refresh_variables(&mut self, position: &Values9, end: &Values9, now: &Values9) {
        let modes = &self.modes;
        let plane = [17.0, 18.0, 19.0][modes.plane as usize];
        let is_lathe = self.setup.is_fanuc_lathe();
        let feed_mode = match (modes.feed_mode, is_lathe) {
            (FeedMode::InverseTime, _) => 93.0,
            (FeedMode::PerMinute, false) => 94.0,
            (FeedMode::PerRevolution, false) => 95.0,
            (FeedMode::PerMinute, true) => 98.0,
            (FeedMode::PerRevolution, true) => 99.0,
        };
        // Cycles are a group of their own beside G0 to G3, but for G90, G92 and G94 of lathes.
        let motion = match modes.motion {
            Some(330) if is_lathe => 320,
            Some(330) => 330,
            Some(own::TURN_CUT) => 900,
            Some(own::THREAD_CUT) => 920,
            Some(own::FACE_CUT) => 940,
            _ => modes.plain_motion.unwrap_or(0),
        };
        let cycle = match modes.motion {
            Some(own::FINE_BORE) => 760,
            Some(code) if is_cycle(code) => code,
            _ => CANCEL_CYCLE,
        };
        let modal = [
            (4001, f64::from(motion) / 10.0),
            (4002, plane),
            (4003, if modes.incremental { 91.0 } else { 90.0 }),
            (4005, feed_mode),
            (4006, if modes.inches { 20.0 } else { 21.0 }),
            (4109, modes.feed / modes.unit_mm()),
            (4119, modes.speed),
            (4120, f64::from(self.tool)),
        ];
        let parameters = &mut self.parameters;
        for (index, value) in modal {
            parameters.put(index, value);
        }
        if !is_lathe {
            parameters.put(4009, f64::from(cycle) / 10.0);
        }
        for i in 0..6 {
            parameters.put(5001 + i, end[i]);
            parameters.put(5021 + i, position[i] * parameters.units[i]);
            parameters.put(5041 + i, now[i]);
        }
        let mut length = self.offsets.tool;
        if let Some(of_tip) = self.tip_mm {
            length[Axis::Z as usize] = of_tip;
        }
        for (i, offset) in length.into_iter().enumerate() {
            parameters.put(5081 + i, offset * parameters.units[i]);
        }
        if self.setup.dialect == Dialect::Haas {
            // Fanuc's external offset, which is zero, is Haas's G52.
            for i in 0..9 {
                parameters.put(5201 + i, self.offsets.local_zero[i] * parameters.units[i]);
            }
        }
    }
}
