//! What a controller knows before the program starts.

use super::canonical::{Plane, Position};
use super::dialect::{CodeName, Dialect};
use super::kinematics::Kinematics;
use std::collections::{BTreeMap, BTreeSet};
use std::str::FromStr;

/// The unit of a program's lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Units {
    /// G21.
    Mm,
    /// G20.
    Inch,
}

impl FromStr for Units {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "mm" => Ok(Self::Mm),
            "inch" => Ok(Self::Inch),
            _ => Err(format!("there are no units `{name}`; there are mm, inch")),
        }
    }
}

/// One work coordinate system: its origin in machine coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorkOffset {
    /// Origin, mm and radians.
    pub origin: Position,
    /// Turn about Z, radians.
    pub rotation: f64,
}

/// Highest P of G54.1.
pub const MORE_OFFSETS: u32 = 298;

/// An entry of the tool table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tool {
    /// What G43 adds to the axes: length in Z, on lathes also X; mm and radians.
    pub offset: Position,
    /// Cutting diameter, or twice the nose radius, mm; for G41 and G42.
    pub diameter_mm: f64,
    /// On lathes, which way the tool points: 1 to 9 as in LinuxCNC's tool table; 0 for milling tools.
    pub orientation: u8,
}

impl Tool {
    /// A milling tool.
    #[must_use]
    pub fn with_length(length_mm: f64, diameter_mm: f64) -> Self {
        let offset = Position([0.0, 0.0, length_mm, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        Self { offset, diameter_mm, orientation: 0 }
    }
}

/// What an M code of the machine's own does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UserCode {
    /// Switches tool-centre-point control on, with the tool length in force.
    TipOn,
    /// Switches it off.
    TipOff,
    /// Turns the spindle clockwise, as M3 does.
    SpindleOn,
    /// Stops the spindle.
    SpindleOff,
    /// Nothing that moves an axis.
    Ignore,
}

/// How far a program may go before it is given up as one that never ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most moves: four million take about 700 MB.
    pub moves: usize,
    /// Most blocks executed, those of subroutines and loops each time.
    pub blocks: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { moves: 4_000_000, blocks: 10_000_000 }
    }
}

/// State of the controller at the program's start. The default is a mill: G54 with all offsets zero, G8, G17, G21, G90,
/// G91.1, G94, G97, G99: LinuxCNC's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setup {
    /// Axis positions, mm and radians.
    pub start: Position,
    /// G54, G55, ... G59, G59.1, G59.2, G59.3.
    pub work_offsets: [WorkOffset; 9],
    /// Which of them are known although they are zero: a place in another is noted as not known.
    pub known_offsets: [bool; 9],
    /// Origins of G54.1 P1 to [`MORE_OFFSETS`] by the number of P, machine coordinates, mm and radians; Haas's G154 has the same. Other dialects have none.
    pub more_work_offsets: BTreeMap<u32, Position>,
    /// The tool table.
    pub tools: BTreeMap<u32, Tool>,
    /// The tool in the spindle; 0 is none.
    pub tool: u32,
    /// The plane before any G17, G18 or G19.
    pub plane: Plane,
    /// The unit before any G20 or G21; `None` reads mm, with a note at the first length.
    pub units: Option<Units>,
    /// Where G28 goes, axis positions.
    pub home: Position,
    /// Where G30 goes, axis positions; `None` is zero, with a note.
    pub second_home: Option<Position>,
    /// Where M6 changes tools: the axes that go there at rapid rate, mm and radians, in the order of [`Position`]. Z goes first, on lathes X.
    pub tool_change: [Option<f64>; 9],
    /// Whether lines that start with `/` are skipped.
    pub block_delete: bool,
    /// What the machine's own M codes mean, by number; others that RS274/NGC does not have are errors.
    pub user_codes: BTreeMap<u32, UserCode>,
    /// How far before the end of its move a probe (G38.2 to G38.5) stops, mm; nothing is there for it to touch.
    pub probe_stops_short_mm: f64,
    /// Parameters set beforehand: by name without `#<>`, or by number in digits. On Fanuc's and Haas's controls, also what programs before
    /// have left in variables that the control keeps.
    pub parameters: BTreeMap<String, f64>,
    /// When to give up.
    pub limits: Limits,
    /// The control that the program is written for.
    pub dialect: Dialect,
    /// Whether nobody has named the dialect: a program that looks like another control's then has a note.
    pub dialect_is_assumed: bool,
    /// Codes to skip, each with a note. With a G code the words of its block are skipped, too, unless another code moves the axes.
    pub ignored: BTreeSet<CodeName>,
    /// Which rotary axes turn without limits: Fanuc's controls may take these the nearer way. In the order of [`Position`].
    pub endless: [bool; 9],
    /// The machine's rotary axes, for tool-centre-point control while they are tilted, for tilted planes and for tool vectors.
    pub kinematics: Option<Kinematics>,
}

impl Setup {
    /// A lathe: as the default, with G18. X words are diameters in the dialects `fanuc` and `haas`, and radii (G8) until G7 in the others.
    #[must_use]
    pub fn lathe() -> Self {
        Self { plane: Plane::Zx, ..Self::default() }
    }

    /// Whether programs are those of a Fanuc or Haas lathe: X words as diameters, G-code system A, U and W as steps, T with an offset's number.
    #[must_use]
    pub fn is_fanuc_lathe(&self) -> bool {
        self.dialect.is_fanuc_like() && self.plane == Plane::Zx
    }
}
