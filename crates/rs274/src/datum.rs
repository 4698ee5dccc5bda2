//! Codes that say where zero is: G54 to G59.3, G10, G52, G92, G43, G49; and G28, G30, which use stored places.
//!
//! The parameters that hold them have LinuxCNC's numbers: 5061 (probe), 5161 (G28), 5181 (G30), 5210 (G92), 5220 (system),
//! 5221 + 20 n (origin of system n, rotation at 5230 + 20 n). Values there are mm and degrees, but for the probe's, which are in the program's
//! units; programs for Fanuc's controls read and write origins in theirs.

use super::canonical::{Axis, Plane, Position};
use super::dialect::{Dialect, own};
use super::error::{Cause, Fault};
use super::fanuc::origin_of;
use super::feed::NO_TRAVEL_MM;
use super::interpret::Interpreter;
use super::modal::{Code, Group, Spindle, Values};
use super::offsets::{Offsets, Values9, from_canonical, to_canonical, turn};
use super::setup::{MORE_OFFSETS, Tool, UserCode, WorkOffset};
use std::collections::BTreeMap;

const PROBED: usize = 5061;
const HOME: usize = 5161;
const SECOND_HOME: usize = 5181;
const SHIFT_ACTIVE: usize = 5210;
const SHIFT: usize = 5211;
const SYSTEM: usize = 5220;
pub(super) const ORIGINS: usize = 5221;
pub(super) const ORIGIN_STRIDE: usize = 20;
/// G54 to G59.3.
pub(super) const SYSTEMS: usize = 9;
/// Index of G59.3.
const LAST_SYSTEM: usize = SYSTEMS - 1;
/// From the first value of an origin to its rotation.
const ROTATION: usize = 9;

/// Whether a parameter holds a place, an offset or the choice of a system.
const fn is_stored(index: usize) -> bool {
    HOME <= index && index < ORIGINS + (LAST_SYSTEM + 1) * ORIGIN_STRIDE
}

impl Interpreter<'_> {
    /// Puts the setup's places into the parameters and selects the system they name, G54 if they name none.
    pub(super) fn load_datums(&mut self) {
        let setup = self.setup;
        self.store(HOME, &from_canonical(&setup.home));
        if let Some(place) = &setup.second_home {
            self.store(SECOND_HOME, &from_canonical(place));
        }
        let is_known = |system: usize, offset| setup.known_offsets[system] || offset != &WorkOffset::default();
        for (system, offset) in
            setup.work_offsets.iter().enumerate().filter(|&(system, offset)| is_known(system, offset))
        {
            let base = ORIGINS + system * ORIGIN_STRIDE;
            self.store(base, &from_canonical(&offset.origin));
            self.parameters.put(base + ROTATION, offset.rotation.to_degrees());
        }
        let more = setup.more_work_offsets.range(1..=MORE_OFFSETS);
        for (&number, origin) in more.filter(|_| setup.dialect.is_fanuc_like()) {
            self.store(origin_of(LAST_SYSTEM + number as usize), &from_canonical(origin));
        }
        // What is given by number is said more exactly.
        for (name, &value) in &setup.parameters {
            if let Some(index) = name.parse().ok().filter(|&index| is_stored(index)) {
                self.parameters.put(index, value);
            }
        }
        if self.parameters.at(SHIFT_ACTIVE) != 0.0 {
            self.offsets.shift = self.load(SHIFT);
        }
        let system = self.parameters.at(SYSTEM);
        self.select_system(if (1.0..=9.0).contains(&system) { system as usize - 1 } else { 0 });
    }

    fn store(&mut self, base: usize, values: &Values9) {
        for (i, &value) in values.iter().enumerate() {
            self.parameters.put(base + i, value);
        }
    }

    /// The program's units in a mm or a degree, by axis; for X, where that is a diameter, two of them if it `doubles`.
    fn program_units(&self, doubles: bool) -> Values9 {
        Axis::ALL.map(|axis| match axis {
            axis if axis.is_rotary() => 1.0,
            Axis::X if doubles && self.modes.diameter => 2.0 / self.modes.unit_mm(),
            _ => self.modes.unit_mm().recip(),
        })
    }

    /// Tells the parameters the program's units. On LinuxCNC a cycle's lengths are from now on as many of the new unit.
    pub(super) fn note_units(&mut self) {
        let (units, z) = (self.program_units(true), Axis::Z as usize);
        if !self.setup.dialect.is_fanuc_like() {
            self.sticky = self.sticky.unscaled(units[z] / self.parameters.units[z]);
        }
        self.parameters.units = units;
    }

    pub(super) fn load(&self, base: usize) -> Values9 {
        std::array::from_fn(|i| self.parameters.at(base + i))
    }

    /// G54 is 0.
    pub(super) fn select_system(&mut self, system: usize) {
        self.modes.system = system;
        self.parameters.put(SYSTEM, system as f64 + 1.0);
        let base = origin_of(system);
        self.offsets.origin = self.load(base);
        self.offsets.rotation = self.parameters.at(base + ROTATION);
    }

    /// G54 and its like. On LinuxCNC the system in force, named again, changes nothing, even when the program has written its origin meanwhile.
    pub(super) fn change_system(&mut self, system: usize) {
        if system != self.modes.system || self.setup.dialect.is_fanuc_like() {
            return self.select_system(system);
        }
        let base = origin_of(system);
        let written = (self.load(base), self.parameters.at(base + ROTATION));
        if written != (self.offsets.origin, self.offsets.rotation) {
            self.note(
                "a system that is in force and named again keeps its origin on LinuxCNC; what the program has written into its parameters (#5221 and on) counts when it is selected after another"
                    .to_owned(),
            );
        }
    }

    /// Notes where a probe ended and that it met nothing.
    pub(super) fn note_probe(&mut self) {
        let place = self.reading(&self.position);
        let units = self.program_units(self.setup.dialect.is_fanuc_like());
        self.store(PROBED, &std::array::from_fn(|i| place[i] * units[i]));
        self.parameters.put(PROBED + 9, 0.0);
    }

    /// Whether a code other than a motion uses the block's axis words.
    pub(super) fn uses_axis_words(&self, values: &Values) -> bool {
        let like_fanuc = self.setup.dialect.is_fanuc_like();
        matches!(values.number(Group::NonModal), Some(code) if like_fanuc || !matches!(code, 40 | 281 | 301 | 921..=923))
            || matches!(values.number(Group::Turn), Some(code) if code != 690)
            || matches!(values.number(Group::Scale), Some(510))
            || values.code(Group::Mirror).is_some()
            || matches!(values.number(Group::ToolLength), Some(431 | 432))
    }

    /// G43, G43.1, G43.2, G43.4, G43.5, G44, G49.
    pub(super) fn set_tool_offset(&mut self, values: &Values) -> Result<(), Fault> {
        let (before, was_at_tip) = (self.offsets.tool, self.tip_mm.is_some());
        self.obey_tool_length(values)?;
        if !was_at_tip && self.tip_mm.is_none() {
            self.note_offset_change(&before);
        }
        Ok(())
    }

    /// On Fanuc's controls a step of an axis (G91, U, W) ends further by what its tool offset has changed.
    pub(super) fn note_offset_change(&mut self, before: &Values9) {
        if self.setup.dialect.is_fanuc_like() {
            for ((change, old), new) in self.offset_change.iter_mut().zip(before).zip(self.offsets.tool) {
                *change += new - old;
            }
        }
    }

    /// Notes a move of a mill's other axes while Z waits for another length. At home nothing is in the way.
    pub(super) fn note_waiting_length(&mut self) {
        let z = Axis::Z as usize;
        let waits = self.has_offset_numbers() && self.offset_change[z] != 0.0;
        if waits && (self.position[z] - self.parameters.at(HOME + z)).abs() > NO_TRAVEL_MM {
            self.note_unknown(
                "the tool length offset has changed and Z has not been sent anywhere since: a control may move Z by the change at once (Fanuc's parameter 5006#6)"
                    .to_owned(),
            );
        }
    }

    /// Takes note that G28, G30 or G53 has moved Z on a Fanuc mill.
    pub(super) fn lapse_length(&mut self) {
        let adds = self.numbers.adds_length && self.offsets.tool[Axis::Z as usize] != 0.0;
        self.numbers.lapses |= adds && self.setup.dialect == Dialect::Fanuc;
    }

    /// Notes that Z goes to a place of the program while it is open whether the tool length counts.
    pub(super) fn note_lapsed_length(&mut self) {
        if std::mem::take(&mut self.numbers.lapses) {
            self.note_unknown(
                "Z goes to a place behind G28, G30 or G53 without another G43, H or G49: Fanuc's controls cancel the tool length there, until the next block with parameter 5001#6 (EVO) at 1, and with 0 until G43 or H; it is kept here"
                    .to_owned(),
            );
        }
    }

    /// Notes that an axis goes to a place of a work coordinate system that nothing has set. G54 is taken to be at zero on purpose.
    pub(super) fn note_unset_origin(&mut self) {
        let system = self.modes.system;
        if system == 0 || self.parameters.is_set(origin_of(system)) {
            return;
        }
        let name = match system {
            1..=5 => format!("G{}", 54 + system),
            6..SYSTEMS => format!("G59.{}", system - 5),
            _ if self.setup.dialect == Dialect::Haas => format!("G154P{}", system - SYSTEMS + 1),
            _ => format!("G54.1P{}", system - SYSTEMS + 1),
        };
        self.note_unknown(format!(
            "the origin of {name} is taken to be zero: nothing has set it (`--offset {name}=X,Y,Z`)"
        ));
    }

    fn obey_tool_length(&mut self, values: &Values) -> Result<(), Fault> {
        let Some(code) = values.code(Group::ToolLength) else { return Ok(()) };
        let like_fanuc = self.setup.dialect.is_fanuc_like();
        // The length in force, named again, changes nothing. On Fanuc's and Haas's controls G43 is of the group of G43.4 and G234, and replaces them.
        let keeps = code.number == 430 && (self.is_tilted || !like_fanuc);
        if keeps && self.tip_mm.is_some_and(|length| self.is_length(length, values, code)) {
            return Ok(());
        }
        // In a tilted plane, and where kinematics lead the tip, the length is the tip's, whichever code sets it.
        if self.is_tilted || self.is_switched {
            if matches!(code.number, 434 | 435) {
                let why = if self.is_tilted {
                    "tool-centre-point control in a tilted plane; G69 cancels the plane"
                } else {
                    "G43.4 or G43.5 where the machine's own M code has switched tool-centre-point control on"
                };
                return Err(code.fault(Cause::NotAllowed(why)));
            }
            let before = self.world(&self.position);
            self.leave_tip_control(code)?;
            self.change_tool_offset(values, code)?;
            self.enter_tip_control(code)?;
            self.note_length_in_kinematics(&before);
            return Ok(());
        }
        match code.number {
            490 => {
                self.leave_tip_control(code)?;
                self.change_tool_offset(values, code)
            }
            434 | 435 => {
                let offset = self.tool_offset(values, code)?;
                self.leave_tip_control(code)?;
                self.offsets.tool = offset;
                self.enter_tip_control(code)?;
                self.has_tool_vectors = code.number == 435;
                Ok(())
            }
            430 | 440 if self.tip_mm.is_some() && like_fanuc => {
                if self.setup.dialect == Dialect::Fanuc {
                    let note = "G43 or G44 under tool-centre-point control is taken to end that, as G49 does; Fanuc's controls may stop with an alarm";
                    self.note_unknown(note.to_owned());
                }
                self.leave_tip_control(code)?;
                let before = self.offsets.tool;
                self.change_tool_offset(values, code)?;
                self.note_offset_change(&before);
                Ok(())
            }
            _ if self.tip_mm.is_some() => {
                Err(code.fault(Cause::NotAllowed("another tool length under tool-centre-point control")))
            }
            _ => self.change_tool_offset(values, code),
        }
    }

    /// Sets what is added to the axes.
    fn change_tool_offset(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        self.numbers.adds_length = matches!(code.number, 430 | 440);
        self.numbers.lapses = false;
        match code.number {
            490 => self.offsets.tool = [0.0; 9],
            432 if values.has('h') && values.has_axis() => {
                return Err(code.fault(Cause::NotAllowed("both H and axis words with G43.2")));
            }
            432 if !values.has('h') && !values.has_axis() => {
                return Err(code.fault(Cause::Missing("H or an axis word")));
            }
            number if number == 431 || (number == 432 && !values.has('h')) => {
                for axis in Axis::ALL {
                    if let Some(value) = self.take_axis(values, axis) {
                        let old = &mut self.offsets.tool[axis as usize];
                        *old = value + if number == 432 { *old } else { 0.0 };
                    }
                }
            }
            _ => {
                let offset = self.tool_offset(values, code)?;
                let (kept, sign) = (code.number == 432, if code.number == 440 { -1.0 } else { 1.0 });
                for (old, new) in self.offsets.tool.iter_mut().zip(offset) {
                    *old = if kept { *old } else { 0.0 } + sign * new;
                }
            }
        }
        if matches!(code.number, 431 | 432) {
            self.spindle_offsets.insert(self.tool, self.offsets.tool);
        }
        Ok(())
    }

    /// The tool table, with what G43.1 and G43.2 have given its tools.
    pub(super) fn last_tools(&mut self) -> BTreeMap<u32, Tool> {
        let mut tools = std::mem::take(&mut self.tools);
        for (number, offset) in &self.spindle_offsets {
            if let Some(tool) = tools.get_mut(number) {
                tool.offset = to_canonical(offset);
            }
        }
        tools
    }

    /// What G43 and its relatives add: on Fanuc's mills for the number of H, which holds and of which 0 is none; else for the tool of H,
    /// or for the one in the spindle, which LinuxCNC calls H0, too.
    fn tool_offset(&self, values: &Values, code: &Code) -> Result<Values9, Fault> {
        let number = if self.has_offset_numbers() {
            self.numbers.length.ok_or_else(|| code.fault(Cause::Missing("H, the number of the tool length offset,")))?
        } else {
            let range = "a whole number from 0 to 99999";
            let named = values.take_whole('h', 0..=99_999, "H", range)?.map(i32::unsigned_abs);
            named.filter(|&number| number != 0).unwrap_or(self.tool)
        };
        if number == 0 && self.has_offset_numbers() {
            return Ok([0.0; 9]);
        }
        match self.tools.get(&number) {
            Some(tool) => Ok(from_canonical(&tool.offset)),
            None if number == 0 => Ok([0.0; 9]),
            None if values.has('h') => Err(values.fault('h', Cause::UnknownTool)),
            None => Err(code.fault(Cause::UnknownTool)),
        }
    }

    /// Whether what G43 adds is a length of `length` mm and nothing else.
    fn is_length(&self, length: f64, values: &Values, code: &Code) -> bool {
        let mut wanted = [0.0; 9];
        wanted[Axis::Z as usize] = length;
        self.tool_offset(values, code).is_ok_and(|offset| offset == wanted)
    }

    /// M codes of the machine's own, and M60, after which another workpiece may be there.
    pub(super) fn obey_user_code(&mut self, values: &Values) -> Result<(), Fault> {
        if values.number(Group::Stop) == Some(60) {
            let told =
                "M60 changes the pallet: what comes in is not known; what follows is checked on the stock that was cut";
            self.note_unknown(told.to_owned());
        }
        let Some(code) = values.code(Group::User) else { return Ok(()) };
        let [p, _] = ['p', 'q'].map(|letter| values.take(letter));
        match self.setup.user_codes.get(&code.number.unsigned_abs()) {
            Some(UserCode::TipOn) if self.tip_mm.is_none() => {
                self.enter_tip_control(code)?;
                self.is_switched = !self.setup.dialect.is_fanuc_like();
                Ok(())
            }
            Some(UserCode::TipOff) => {
                self.leave_tip_control(code)?;
                self.is_switched = false;
                Ok(())
            }
            // Without any S the speed is that of P.
            Some(UserCode::SpindleOn) => {
                match p.filter(|&speed| speed > 0.0 && self.modes.speed == 0.0) {
                    Some(speed) => self.modes.driven_rpm[0] = speed,
                    None => self.modes.spindle = Spindle::Clockwise,
                }
                Ok(())
            }
            Some(UserCode::SpindleOff) => {
                (self.modes.spindle, self.modes.driven_rpm) = (Spindle::Still, [0.0; 2]);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    pub(super) fn obey_datum_codes(&mut self, values: &Values) -> Result<(), Fault> {
        if !matches!(values.number(Group::NonModal), Some(40 | 100)) {
            let why = match values.number(Group::NonModal) {
                Some(own::POCKET_CLOCKWISE..=own::HOLES_ON_LINE) => {
                    "G12, G13 and G70 to G72 while cutter compensation is on; G40 ends it"
                }
                _ => "places and offsets of coordinates while cutter compensation is on",
            };
            self.refuse_compensated(values, Group::NonModal, why)?;
        }
        let was_transformed = self.transforms.are_on();
        self.obey_transforms(values)?;
        if was_transformed && self.transforms.are_on() {
            self.refuse_other_zero(values)?;
        }
        match values.number(Group::NonModal) {
            Some(531) => match values.code(Group::NonModal) {
                Some(code) => self.turn_upright(values, code),
                None => Ok(()),
            },
            Some(100) if self.setup.dialect.is_fanuc_like() => self.set_fanuc_data(values),
            Some(100) => self.set_data(values),
            Some(own::SKIP) => self.probe(values),
            Some(code @ (own::POCKET_CLOCKWISE | own::POCKET_COUNTERCLOCKWISE)) => self.circular_pocket(values, code),
            Some(code @ own::HOLES_ON_CIRCLE..=own::HOLES_ON_LINE) => self.drill_pattern(values, code),
            Some(own::SPEED_LIMIT) if values.has_axis() => self.shift(values, 920),
            Some(920) if self.setup.dialect.is_fanuc_like() && !values.has_axis() => Ok(()),
            Some(280) => self.go_home(values, HOME),
            Some(300) => self.go_home(values, SECOND_HOME),
            Some(code @ (281 | 301)) => {
                let place = self.machine_coordinates(&self.position);
                let place = place.map_err(|cause| self.fault_at(values, Group::NonModal, cause));
                self.store(if code == 281 { HOME } else { SECOND_HOME }, &place?);
                Ok(())
            }
            Some(code @ (520 | 920..=923)) => self.shift(values, code),
            _ => Ok(()),
        }
    }

    /// Refuses G52, G54 to G59 and G92 where Fanuc's manuals forbid them: in turned, scaled or mirrored coordinates.
    fn refuse_other_zero(&self, values: &Values) -> Result<(), Fault> {
        let sets_zero = |code: &&Code| code.number == 520 || (code.number == 920 && values.has_axis());
        let code = values.code(Group::NonModal).filter(sets_zero).or_else(|| values.code(Group::Coordinates));
        let why = "another zero (G52, G54 to G59, G92) while coordinates are turned, scaled or mirrored, on Fanuc's controls; cancel that first (G69, G50, G50.1)";
        match code.filter(|_| self.setup.dialect == Dialect::Fanuc) {
            Some(code) => Err(code.fault(Cause::NotAllowed(why))),
            None => Ok(()),
        }
    }

    /// G28 and G30: by way of the point the axis words name; only the named axes go home, all if none is named. In a turned system of LinuxCNC's those
    /// are the program's axes. Haas's G28 then cancels tool length offsets.
    fn go_home(&mut self, values: &Values, base: usize) -> Result<(), Fault> {
        let home = self.load(base);
        if base == SECOND_HOME && !self.parameters.is_set(base) {
            self.note_unknown(
                "G30 goes to zero of the axes: nothing has set its place (`second_home` of `[program]` in a scene)"
                    .to_owned(),
            );
        }
        if base == SECOND_HOME && self.setup.dialect.is_fanuc_like() {
            values.take_whole('p', 2..=2, "P", "2: the third and the fourth reference point are not known")?;
        }
        let named = Axis::ALL.map(|axis| {
            let step = self.step_letter(axis).is_some_and(|letter| values.has(letter));
            step || (values.has(axis.letter().to_ascii_lowercase()) && !self.is_step_axis(axis))
        });
        let names_any = named.contains(&true);
        let goes = |i: usize| named[i] || !names_any;
        let change = std::mem::take(&mut self.offset_change);
        if names_any {
            if (self.modes.incremental || self.setup.is_fanuc_lathe()) && (0..9).any(|i| named[i] && change[i] != 0.0) {
                let note = "G28 or G30 in G91 behind another tool offset: a control may first move by the change of the offset";
                self.note(note.to_owned());
            }
            let between = self.target(values);
            self.rapid_to(between)?;
        }
        self.offset_change = std::array::from_fn(|i| if goes(i) { 0.0 } else { change[i] });
        self.turned_back = std::array::from_fn(|i| self.turned_back[i] && !goes(i));
        let cancels_length = self.setup.dialect == Dialect::Haas && base == HOME;
        if cancels_length && self.tip_mm.is_some() {
            let why = "G28 under tool-centre-point control or in a tilted plane, whose tool length it cancels";
            return Err(self.fault_at(values, Group::NonModal, Cause::NotAllowed(why)));
        }
        let is_turned = !self.setup.dialect.is_fanuc_like() && goes(0) != goes(1);
        let rotation = if is_turned { self.offsets.rotation } else { 0.0 };
        self.in_machine_coordinates(values, Group::NonModal, |interpreter| {
            let (mut home, mut target) = (home, interpreter.position);
            turn(&mut home, -rotation);
            turn(&mut target, -rotation);
            target = std::array::from_fn(|i| if goes(i) { home[i] } else { target[i] });
            turn(&mut target, rotation);
            for axis in Axis::ALL.into_iter().filter(|axis| axis.is_rotary()) {
                interpreter.note_roll_over(axis as usize, interpreter.position[axis as usize], target[axis as usize]);
            }
            interpreter.rapid_to(target)
        })?;
        if goes(Axis::Z as usize) {
            self.lapse_length();
        }
        if cancels_length {
            self.offsets.tool = [0.0; 9];
            self.numbers.adds_length = false;
        }
        Ok(())
    }

    /// M6: to where the machine changes tools, Z first, on lathes X.
    pub(super) fn go_to_tool_change(&mut self, values: &Values) -> Result<(), Fault> {
        let named = self.setup.tool_change;
        if named.iter().all(Option::is_none) {
            return Ok(());
        }
        let retreats = if self.setup.plane == Plane::Zx { Axis::X } else { Axis::Z } as usize;
        let place = from_canonical(&Position(named.map(Option::unwrap_or_default)));
        self.offset_change = [0.0; 9];
        self.in_machine_coordinates(values, Group::ToolChange, |interpreter| {
            for is_retreat in [true, false] {
                let start = interpreter.position;
                let goes = |i: usize| named[i].is_some() && (i == retreats) == is_retreat;
                let target = std::array::from_fn(|i| if goes(i) { place[i] } else { start[i] });
                if target != start {
                    interpreter.rapid_to(target)?;
                }
            }
            Ok(())
        })
    }

    /// G52 and the G92 family. On LinuxCNC they share one shift; on Fanuc's and Haas's controls G52 sets another, which G92 cancels for the axes that it
    /// names.
    fn shift(&mut self, values: &Values, code: i32) -> Result<(), Fault> {
        match code {
            520 | 920 => {
                if !values.has_axis() {
                    return Err(self.fault_at(values, Group::NonModal, Cause::Missing("an axis word")));
                }
                let words = Axis::ALL.map(|axis| self.take_axis(values, axis));
                if code == 520 {
                    let Offsets { shift, local_zero, .. } = &mut self.offsets;
                    let zero = if self.setup.dialect.is_fanuc_like() { local_zero } else { shift };
                    zero.iter_mut().zip(words).for_each(|(old, word)| *old = word.unwrap_or(*old));
                } else {
                    self.shift_to_reading(&words);
                }
                let shift = self.offsets.shift;
                self.store(SHIFT, &shift);
                self.parameters.put(SHIFT_ACTIVE, 1.0);
            }
            923 => {
                self.offsets.shift = self.load(SHIFT);
                self.parameters.put(SHIFT_ACTIVE, 1.0);
            }
            _ => {
                self.offsets.shift = [0.0; 9];
                self.parameters.put(SHIFT_ACTIVE, 0.0);
                if code == 921 {
                    self.store(SHIFT, &[0.0; 9]);
                }
            }
        }
        self.note_shifted_mirror();
        Ok(())
    }

    /// G92: the present position shall read as the words say, and on axes without a word as it did.
    fn shift_to_reading(&mut self, words: &[Option<f64>; 9]) {
        let mut before = self.offsets.to_program(&self.position);
        let mut after: Values9 = std::array::from_fn(|i| words[i].unwrap_or(before[i]));
        let Offsets { shift, local_zero, local, .. } = &mut self.offsets;
        // The shift is behind turns, scales and tilts, where a word for X may move Y and Z.
        let mixes = local.is_some() && words[..3].iter().any(Option::is_some);
        if let Some(local) = local {
            local.apply(&mut before);
            local.apply(&mut after);
        }
        for axis in Axis::ALL {
            let i = axis as usize;
            if words[i].is_some() {
                shift[i] += std::mem::take(&mut local_zero[i]);
            }
            if words[i].is_some() || (mixes && i < 3) {
                shift[i] += before[i] - after[i];
            }
        }
    }

    /// G10 L0, L1, L2, L10, L11 and L20.
    fn set_data(&mut self, values: &Values) -> Result<(), Fault> {
        let fault = |cause| self.fault_at(values, Group::NonModal, cause);
        let kind =
            values.take_whole('l', 0..=20, "L", "0, 1, 2, 10, 11 or 20")?.ok_or_else(|| fault(Cause::Missing("L")))?;
        match kind {
            // The tool table as it was at first: nobody edits it meanwhile.
            0 => {
                self.tools.clone_from(&self.setup.tools);
                Ok(())
            }
            1 | 10 | 11 => self.set_tool(values, kind),
            2 | 20 => {
                let system =
                    values.take_whole('p', 0..=9, "P", "a coordinate system from 0 to 9")?.ok_or_else(|| {
                        self.fault_at(values, Group::NonModal, Cause::Missing("P, the coordinate system,"))
                    })?;
                let system = if system == 0 { self.modes.system } else { system.unsigned_abs() as usize - 1 };
                if system == self.modes.system {
                    let why = "another origin of the system in force while cutter compensation is on";
                    self.refuse_compensated(values, Group::NonModal, why)?;
                }
                if kind == 20 {
                    self.set_origin_by_reading(values, system)?;
                } else {
                    self.set_origin(values, system);
                }
                if system == self.modes.system {
                    self.refuse_turn_of_shifted_system(values)?;
                    self.select_system(system);
                }
                Ok(())
            }
            _ => Err(values.fault('l', Cause::Unsupported)),
        }
    }

    /// Refuses another turn of the system in force while G52 or G92 shifts X or Y: LinuxCNC then turns the place without the shift
    /// (`interp_convert.cc`, `convert_setup`).
    fn refuse_turn_of_shifted_system(&self, values: &Values) -> Result<(), Fault> {
        let rotation = self.parameters.at(origin_of(self.modes.system) + ROTATION);
        if rotation == self.offsets.rotation || self.offsets.shift[..2] == [0.0; 2] {
            return Ok(());
        }
        let why = "another turn of the system in force (G10 L2 R) while G52 or G92 shifts X or Y: LinuxCNC loses its place; cancel the shift first (G92.1)";
        Err(self.fault_at(values, Group::NonModal, Cause::NotAllowed(why)))
    }

    /// G10 L2: the words are the origin and the turn.
    fn set_origin(&mut self, values: &Values, system: usize) {
        let base = ORIGINS + system * ORIGIN_STRIDE;
        if let Some(rotation) = values.take('r') {
            self.parameters.put(base + ROTATION, rotation);
        }
        for axis in Axis::ALL {
            if let Some(value) = self.take_axis(values, axis) {
                self.parameters.put(base + axis as usize, value);
            }
        }
    }

    /// G10 L20: the present position shall read as the words say in a system, and on axes without a word as it did there.
    fn set_origin_by_reading(&mut self, values: &Values, system: usize) -> Result<(), Fault> {
        if values.has('r') {
            return Err(values.fault('r', Cause::NotAllowed("R, a turn, with G10 L20; G10 L2 sets it")));
        }
        let base = ORIGINS + system * ORIGIN_STRIDE;
        let mut offsets = self.offsets.clone();
        (offsets.origin, offsets.rotation) = (self.load(base), self.parameters.at(base + ROTATION));
        let words = Axis::ALL.map(|axis| self.take_axis(values, axis));
        let reading = offsets.to_program(&self.position);
        let wanted: Values9 = std::array::from_fn(|i| words[i].unwrap_or(reading[i]));
        offsets.origin = [0.0; 9];
        let without_origin = offsets.to_machine(&wanted);
        // In a turned system a word for X moves the origin in X and in Y.
        let turns = offsets.rotation != 0.0 && (words[0].is_some() || words[1].is_some());
        for i in 0..9 {
            if words[i].is_some() || (turns && i < 2) {
                self.parameters.put(base + i, self.position[i] - without_origin[i]);
            }
        }
        Ok(())
    }

    /// G10 L1: an entry of the tool table; L10: the offset with which the present position would read as the words say; L11: the same
    /// in G59.3 and without G92.
    fn set_tool(&mut self, values: &Values, kind: i32) -> Result<(), Fault> {
        let number = values
            .take_whole('p', 1..=99_999, "P", "a tool number from 1 to 99999")?
            .ok_or_else(|| self.fault_at(values, Group::NonModal, Cause::Missing("P, the tool's number,")))?;
        let mut tool = self.tools.get(&number.unsigned_abs()).copied().unwrap_or_default();
        let words = Axis::ALL.map(|axis| self.take_axis(values, axis));
        let entry = from_canonical(&tool.offset);
        let offset = if kind == 1 { words } else { self.offset_for(&words, &entry, kind == 11) };
        for (axis, value) in Axis::ALL.into_iter().zip(offset) {
            if let Some(value) = value {
                tool.offset[axis] = if axis.is_rotary() { value.to_radians() } else { value };
            }
        }
        if let Some(radius) = self.take_length(values, 'r') {
            tool.diameter_mm = 2.0 * radius;
        }
        if let Some(orientation) = values.take_whole('q', 0..=9, "Q", "an orientation from 0 to 9")? {
            tool.orientation = orientation as u8;
        }
        // The angles of a lathe tool move no axis.
        for letter in ['i', 'j'] {
            values.take(letter);
        }
        self.tools.insert(number.unsigned_abs(), tool);
        Ok(())
    }

    /// The tool offset with which the present position reads as the words say; `None` for axes that keep the table's. In a turned system
    /// a word for X sets the part of the offset along the turned X axis, and the table's `entry` keeps its part along the turned Y axis.
    fn offset_for(&self, words: &[Option<f64>; 9], entry: &Values9, in_last_system: bool) -> [Option<f64>; 9] {
        let base = ORIGINS + LAST_SYSTEM * ORIGIN_STRIDE;
        let mut offsets = self.offsets.clone();
        if in_last_system {
            (offsets.origin, offsets.rotation) = (self.load(base), self.parameters.at(base + ROTATION));
            offsets.shift = [0.0; 9];
        }
        offsets.tool = [0.0; 9];
        let reading = offsets.to_program(&self.world(&self.position));
        let mut offset = *entry;
        turn(&mut offset, -offsets.rotation);
        for i in 0..9 {
            offset[i] = words[i].map_or(offset[i], |word| reading[i] - word);
        }
        turn(&mut offset, offsets.rotation);
        let turns = offsets.rotation != 0.0 && (words[0].is_some() || words[1].is_some());
        std::array::from_fn(|i| (words[i].is_some() || (turns && i < 2)).then_some(offset[i]))
    }
}
