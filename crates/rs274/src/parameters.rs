//! Parameters: `#1` to `#5602`, `#<name>` local to a subroutine, `#<_name>` global, and the predefined read-only ones.
//!
//! Subroutine parameters `#1` to `#30` are local to each call (LinuxCNC, "O codes"). Predefined names are those of
//! LinuxCNC's G-code overview, as far as [`SYSTEM_NAMES`] lists them.

use super::dialect::Dialect;
use super::error::Cause;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

/// Highest numbered parameter (LinuxCNC: `RS274NGC_MAX_PARAMETERS` - 1).
pub(super) const MAX_PARAMETER: usize = 5601;

/// Numbered parameters local to a subroutine: `#1` to `#30`.
pub(super) const LOCAL_PARAMETERS: usize = 30;

/// Variables local to a macro of Fanuc's: `#1` to `#33`.
const LOCAL_VARIABLES: usize = 33;

/// Highest variable of Fanuc's and Haas's controls.
const MAX_VARIABLE: usize = 19_999;

/// Value of a variable that holds none: Fanuc's `#0`.
const VACANT: f64 = f64::NAN;

/// Value of a variable that the control keeps from one program to the next or asks the operator for, and that nothing has set: reading it is an error.
const UNSET: f64 = f64::NEG_INFINITY;

/// Value of a system variable that is not modelled, and of an axis position that is not known: reading it is an error.
pub(super) const UNKNOWN: f64 = f64::INFINITY;

/// Error of reading an axis position that is not known.
const UNKNOWN_PLACE: Cause = Cause::NotAllowed(
    "where the axes stand under tool-centre-point control while rotary axes are not at zero and the machine is not known (`[program.tool_centre_point]` of a scene) or cannot hold the tip there",
);

/// The predefined named parameters, in the order of [`Parameters::system`].
pub(super) const SYSTEM_NAMES: [&str; 58] = [
    "_x",
    "_y",
    "_z",
    "_a",
    "_b",
    "_c",
    "_u",
    "_v",
    "_w",
    "_abs_x",
    "_abs_y",
    "_abs_z",
    "_abs_a",
    "_abs_b",
    "_abs_c",
    "_abs_u",
    "_abs_v",
    "_abs_w",
    "_motion_mode",
    "_plane",
    "_coord_system",
    "_metric",
    "_imperial",
    "_absolute",
    "_incremental",
    "_inverse_time",
    "_units_per_minute",
    "_units_per_rev",
    "_feed",
    "_rpm",
    "_current_tool",
    "_selected_tool",
    "_lathe_diameter_mode",
    "_lathe_radius_mode",
    "_call_level",
    "_line",
    "_task",
    "_remap_level",
    "_ccomp",
    "_tool_offset",
    "_retract_r_plane",
    "_retract_old_z",
    "_spindle_rpm_mode",
    "_spindle_css_mode",
    "_ijk_absolute_mode",
    "_spindle_on",
    "_spindle_cw",
    "_mist",
    "_flood",
    "_speed_override",
    "_feed_override",
    "_adaptive_feed",
    "_feed_hold",
    "_metric_machine",
    "_vmajor",
    "_vminor",
    "_value",
    "_value_returned",
];

/// Predefined names of pockets of the tool changer, which are not known: reading one is an error.
const POCKET_NAMES: [&str; 2] = ["_current_pocket", "_selected_pocket"];
const UNKNOWN_POCKET: Cause = Cause::NotAllowed(
    "a pocket of the tool changer, which is not known; `#<_current_tool>` and `#<_selected_tool>` are",
);

/// Where LinuxCNC's M66 puts what it has read.
pub(super) const INPUT: usize = 5399;

/// Values of all parameters.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    numbered: Vec<f64>,
    /// Which parts of origins and of the place of G30 something has set.
    set_places: BTreeSet<usize>,
    /// How many of them, from `#1`, are local to a subroutine.
    locals: usize,
    /// Whether a variable may be vacant, as on Fanuc's controls.
    has_vacant: bool,
    globals: BTreeMap<String, f64>,
    frames: Vec<Frame>,
    /// Haas's have more common variables.
    is_haas: bool,
    /// The program's units in a mm or a degree, by axis: those of Fanuc's origins. The interpreter keeps them up to date.
    pub units: [f64; 9],
    /// Whether, since the interpreter last asked, Fanuc's ATAN or ASIN gave an angle that is 360 degrees less where parameter 6004#0 is 1.
    pub has_full_turn: Cell<bool>,
    /// Whether LinuxCNC's M66 has set [`INPUT`]: its value is not known then.
    holds_input: bool,
    /// The last parameter whose value is not known and that was read since the interpreter last asked: [`INPUT`] behind M66, a clock, a timer.
    pub unknown: Cell<Option<usize>>,
    /// Values of [`SYSTEM_NAMES`]: the interpreter keeps them up to date.
    pub system: [f64; SYSTEM_NAMES.len()],
}

/// What a call hides from its callee.
#[derive(Clone, Debug, Default)]
struct Frame {
    locals: BTreeMap<String, f64>,
    /// The caller's `#1` to `#30`; `None` for M98, which shares them.
    saved: Option<Vec<f64>>,
}

impl Parameters {
    /// All zero but for `defaults`: names as between `<` and `>`, lower case, or numbers in digits.
    pub fn new(defaults: &BTreeMap<String, f64>, dialect: Dialect) -> Self {
        let has_vacant = dialect.is_fanuc_like();
        let mut parameters = Self {
            numbered: if has_vacant { variables(dialect) } else { vec![0.0; MAX_PARAMETER + 1] },
            set_places: BTreeSet::new(),
            locals: if has_vacant { LOCAL_VARIABLES } else { LOCAL_PARAMETERS },
            has_vacant,
            is_haas: dialect == Dialect::Haas,
            units: [1.0; 9],
            has_full_turn: Cell::new(false),
            holds_input: false,
            unknown: Cell::new(None),
            globals: BTreeMap::new(),
            frames: vec![Frame::default()],
            system: [0.0; SYSTEM_NAMES.len()],
        };
        for (name, &value) in defaults {
            match name.parse::<usize>().ok().and_then(|number| parameters.index(number as f64)) {
                Some(index) => parameters.put(index, value),
                None => parameters.insert(name.to_ascii_lowercase(), value),
            }
        }
        parameters
    }

    /// The value of `#number`, or why it has none.
    pub fn numbered(&self, number: f64) -> Result<f64, Cause> {
        if self.has_vacant && number == 0.0 {
            return Ok(VACANT);
        }
        let index = self.index(number).ok_or(Cause::UnknownParameter)?;
        if self.has_vacant && matches!(index, 5000..=5999) && !is_readable(index, self.is_haas) {
            return Err(Cause::UnknownParameter);
        }
        if (self.holds_input && index == INPUT) || (self.has_vacant && is_clock(index)) {
            self.unknown.set(Some(index));
        }
        let value = self.numbered[index];
        if value == UNKNOWN {
            return Err(if matches!(index, 5021..=5029) { UNKNOWN_PLACE } else { Cause::UnknownParameter });
        }
        if value == UNSET {
            return Err(Cause::UnsetVariable);
        }
        let scale = if self.has_vacant { origin_axis(index).map_or(1.0, |axis| self.units[axis]) } else { 1.0 };
        Ok(value * scale)
    }

    /// The value of parameter `index`, which exists.
    pub fn at(&self, index: usize) -> f64 {
        self.numbered[index]
    }

    /// Sets parameter `index`, which exists, whether programs may or not.
    pub fn put(&mut self, index: usize, value: f64) {
        self.numbered[index] = value;
        if matches!(index, 5181..=5189 | 5221..=5400 | 14_001..=19_960) {
            self.set_places.insert(index);
        }
    }

    /// Whether something has set a part of the place, an origin or that of G30, that begins at parameter `base`.
    pub fn is_set(&self, base: usize) -> bool {
        self.set_places.range(base..base + 9).next().is_some()
    }

    /// The value of `#<name>`, or why it has none.
    pub fn named(&self, name: &str) -> Result<f64, Cause> {
        let value = if name.starts_with('_') {
            let system = SYSTEM_NAMES.iter().position(|known| *known == name).map(|index| self.system[index]);
            system.or_else(|| self.globals.get(name).copied())
        } else {
            self.frames.last().and_then(|frame| frame.locals.get(name).copied())
        };
        if value == Some(UNKNOWN) && SYSTEM_NAMES.contains(&name) {
            return Err(UNKNOWN_PLACE);
        }
        value.ok_or(if POCKET_NAMES.contains(&name) { UNKNOWN_POCKET } else { Cause::UnknownParameter })
    }

    /// `#number = value`.
    pub fn assign_numbered(&mut self, number: f64, value: f64) -> Result<(), Cause> {
        let index = self.index(number).ok_or(Cause::UnknownParameter)?;
        if matches!(index, 5400..=5428) && !self.has_vacant {
            return Err(Cause::ReadOnlyParameter);
        }
        if !self.has_vacant {
            self.holds_input &= index != INPUT;
            self.put(index, value);
            return Ok(());
        }
        match index {
            ALARM => return Err(Cause::Alarm(format!("{value}"))),
            _ if is_read_only(index) => return Err(Cause::ReadOnlyParameter),
            _ => {}
        }
        if let Some(axis) = origin_axis(index) {
            self.put(index, if value.is_nan() { 0.0 } else { value / self.units[axis] });
        } else if is_common(index, self.is_haas) || matches!(index, 3001..=3004 | 3006 | 3030) {
            self.numbered[index] = value;
        } else {
            return Err(Cause::NotAllowed("writing a system variable other than origins of work coordinates"));
        }
        Ok(())
    }

    /// LinuxCNC's M66: an input, taken to be 0.
    pub fn read_input(&mut self) {
        self.holds_input = true;
        self.numbered[INPUT] = 0.0;
    }

    /// The values of all numbered parameters but those that tell modes and positions on Fanuc's controls, in bits.
    pub fn bits(&self) -> impl Iterator<Item = u64> {
        let tells = |index: usize| self.has_vacant && is_read_only(index);
        let others = self.numbered.iter().enumerate().filter(move |(index, _)| !tells(*index));
        others.map(|(_, value)| value.to_bits())
    }

    /// `#number`, which must be a common variable, is what the operator enters: `given`, or unset.
    pub fn ask(&mut self, number: f64, given: Option<f64>) -> Result<(), Cause> {
        let index =
            self.index(number).filter(|&index| is_common(index, self.is_haas)).ok_or(Cause::UnknownParameter)?;
        self.numbered[index] = given.unwrap_or(UNSET);
        Ok(())
    }

    /// `#<name> = value`.
    pub fn assign_named(&mut self, name: &str, value: f64) -> Result<(), Cause> {
        if SYSTEM_NAMES.contains(&name) || POCKET_NAMES.contains(&name) {
            return Err(Cause::ReadOnlyParameter);
        }
        self.insert(name.to_owned(), value);
        Ok(())
    }

    fn insert(&mut self, name: String, value: f64) {
        let home =
            if name.starts_with('_') { Some(&mut self.globals) } else { self.frames.last_mut().map(|f| &mut f.locals) };
        if let Some(home) = home {
            home.insert(name, value);
        }
    }

    /// Enters a subroutine: `#1` to `#30` become the arguments, then zeros, or vacant; no named local is seen.
    pub fn enter(&mut self, arguments: &[f64]) {
        let locals = &mut self.numbered[1..=self.locals];
        self.frames.push(Frame { saved: Some(locals.to_vec()), ..Frame::default() });
        let none = if self.has_vacant { VACANT } else { 0.0 };
        for (i, local) in locals.iter_mut().enumerate() {
            *local = arguments.get(i).copied().unwrap_or(none);
        }
    }

    /// Enters a subroutine by M98: it sees its caller's `#1` to `#30`, but none of its named locals.
    pub fn enter_plain(&mut self) {
        self.frames.push(Frame::default());
    }

    /// Sets what the last subroutine returned.
    pub fn set_returned(&mut self, value: Option<f64>) {
        let last = self.system.len();
        self.system[last - 2] = value.unwrap_or(0.0);
        self.system[last - 1] = f64::from(value.is_some());
    }

    /// Leaves a subroutine.
    pub fn leave(&mut self) {
        if self.frames.len() > 1
            && let Some(frame) = self.frames.pop()
            && let Some(saved) = frame.saved
        {
            self.numbered[1..=self.locals].copy_from_slice(&saved);
        }
    }

    /// The index of `#number`: whole within 1e-4 and in range. On Fanuc's controls `#7001` and on are `#14001` and on: origins of G54.1 P1 to P48,
    /// on Haas's of G154 P1 to P20.
    pub fn index(&self, number: f64) -> Option<usize> {
        let whole = number.round();
        let last = (self.numbered.len() - 1) as f64;
        let exists = (number - whole).abs() < 1e-4 && whole >= 1.0 && whole <= last;
        let index = exists.then_some(whole as usize)?;
        let last_alias = if self.is_haas { 7400 } else { 7960 };
        let is_alias = self.has_vacant && (7001..=last_alias).contains(&index);
        Some(if is_alias { index + 7000 } else { index })
    }
}

/// `#3000 = number`: the program stops with this alarm.
const ALARM: usize = 3000;

/// The axis of a variable that holds a part of an origin: G54 to G59, and G54.1 P1 to P298.
fn origin_axis(index: usize) -> Option<usize> {
    let from = match index {
        5221..=5340 => 5221,
        14_001..=19_960 => 14_001,
        _ => return None,
    };
    Some((index - from) % 20).filter(|&axis| axis < 9)
}

/// Which variables from 5000 to 5999 programs may read: positions, where a skip ended, tool offsets, the external offset (Haas's G52), origins, and
/// Haas's timers of tools. Others there are the interpreter's own.
fn is_readable(index: usize, is_haas: bool) -> bool {
    let holds_place = matches!(index, 5001..=5049 | 5061..=5070 | 5081..=5089 | 5201..=5209);
    holds_place || origin_axis(index).is_some() || (is_haas && matches!(index, 5401..=5600))
}

/// Whether a variable that programs for Fanuc's and Haas's controls may read is a clock, or one of Haas's timers of tools.
const fn is_clock(index: usize) -> bool {
    matches!(index, 3001 | 3002 | 3011 | 3012 | 5401..=5600)
}

/// Whether a variable of Fanuc's and Haas's controls tells a mode or a position; programs may not set it.
const fn is_read_only(index: usize) -> bool {
    matches!(index, 4001..=4130 | 5001..=5108)
}

/// Whether a variable of Fanuc's and Haas's controls is the program's own.
fn is_common(index: usize, is_haas: bool) -> bool {
    matches!(index, 1..=33 | 100..=999) || (is_haas && matches!(index, 10_000..=10_999))
}

/// Fanuc's and Haas's variables before a program. Local and common ones are vacant, but those that the control keeps are unset: Fanuc's from #500,
/// all of Haas's. Clocks, messages, modes of execution, the external offset, positions and offsets are zero. Other system variables are unknown.
fn variables(dialect: Dialect) -> Vec<f64> {
    let is_haas = dialect == Dialect::Haas;
    let first_kept = if is_haas { 100 } else { 500 };
    let value = |index| match index {
        _ if is_common(index, is_haas) && index >= first_kept => UNSET,
        _ if is_common(index, is_haas) => VACANT,
        ALARM..=3012 | 5001..=5610 | 14_001..=19_960 => 0.0,
        _ => UNKNOWN,
    };
    (0..=MAX_VARIABLE).map(value).collect()
}
