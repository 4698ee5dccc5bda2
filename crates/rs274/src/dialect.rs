//! Dialects: which control a program is written for, and what that control's codes mean here.
//!
//! LinuxCNC's is the base. Fanuc's and Haas's differ by the tables of this file (codes that move nothing, codes with another meaning), by
//! the macro language (`macro_flow`), by subprograms and calls (`fanuc`) and, on lathes, by G-code system A (`lathe`). Grbl's is LinuxCNC's with
//! lines for the control itself (`block`).

use super::modal::Group;
use std::fmt;
use std::str::FromStr;

/// The control that a program is written for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Dialect {
    /// LinuxCNC's RS274/NGC.
    #[default]
    LinuxCnc,
    /// Fanuc's, custom macro B; on lathes G-code system A.
    Fanuc,
    /// Haas's, which is Fanuc's with codes of its own.
    Haas,
    /// Grbl's and other hobby controllers': LinuxCNC's, beginning in G0, with lines of settings (`$`) among the program's.
    Grbl,
}

impl Dialect {
    /// All dialects.
    pub const ALL: [Self; 4] = [Self::LinuxCnc, Self::Fanuc, Self::Haas, Self::Grbl];

    /// Its name, as [`FromStr`] takes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LinuxCnc => "linuxcnc",
            Self::Fanuc => "fanuc",
            Self::Haas => "haas",
            Self::Grbl => "grbl",
        }
    }

    /// Whether it has Fanuc's macro language, subprograms and decimal points.
    #[must_use]
    pub const fn is_fanuc_like(self) -> bool {
        matches!(self, Self::Fanuc | Self::Haas)
    }
}

impl fmt::Display for Dialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Dialect {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|dialect| dialect.name().eq_ignore_ascii_case(name)).ok_or_else(|| {
            let known = Self::ALL.map(Self::name).join(", ");
            format!("there is no dialect `{name}`; there are {known}")
        })
    }
}

/// A G or M code by letter and number, as in `G187` or `M31`: one that a program may have and that shall be skipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CodeName {
    letter: char,
    /// Ten times the number.
    tenths: i32,
}

impl CodeName {
    /// A code in lower case and ten times its number.
    pub(super) const fn new(letter: char, tenths: i32) -> Self {
        Self { letter, tenths }
    }
}

impl fmt::Display for CodeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.letter.to_ascii_uppercase(), self.tenths / 10)?;
        if self.tenths % 10 == 0 { Ok(()) } else { write!(f, ".{}", self.tenths % 10) }
    }
}

impl FromStr for CodeName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refuse = || format!("`{text}` is no G or M code, as in G187, G5.1 or M31");
        let mut characters = text.trim().chars();
        let letter = characters.next().map(|letter| letter.to_ascii_lowercase()).ok_or_else(refuse)?;
        let digits = characters.as_str();
        let plain =
            digits.chars().all(|c| c.is_ascii_digit() || c == '.') && digits.starts_with(|c: char| c.is_ascii_digit());
        let number: f64 = digits.parse().map_err(|_| refuse())?;
        let tenths = (number * 10.0).round();
        if !matches!(letter, 'g' | 'm') || !plain || number > 9999.0 || (number * 10.0 - tenths).abs() > 1e-6 {
            return Err(refuse());
        }
        Ok(Self { letter, tenths: tenths as i32 })
    }
}

/// Something about a program that is no error and that its reader should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The first line it is about, from 1.
    pub line: u32,
    /// How many further lines it is about.
    pub more: u32,
    /// Whether the machine may move otherwise at this line than the program's moves.
    pub is_unknown: bool,
    /// What it is.
    pub text: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.text)?;
        match self.more {
            0 => Ok(()),
            1 => write!(f, " (and once more)"),
            more => write!(f, " (and {more} times more)"),
        }
    }
}

/// What a code means in a dialect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// As the code of this group and number: ten times the number for G, the number for M.
    Code(Group, i32),
    /// Nothing that moves an axis.
    Nothing,
    /// Nothing that moves an axis, as far as this control's manuals say; the reader is told.
    Noted,
    /// As on LinuxCNC.
    Common,
    /// Not performed.
    Unknown,
}

/// Numbers of codes that LinuxCNC has not, or has for something else, apart from all of LinuxCNC's.
pub(super) mod own {
    /// G31: a feed move that a probe may stop.
    pub const SKIP: i32 = 310;
    /// G65: a call with arguments.
    pub const MACRO_CALL: i32 = 650;
    /// M97: a call to a line of the same program.
    pub const LOCAL_CALL: i32 = 97;
    /// Haas's G12 and G13: circular pockets.
    pub const POCKET_CLOCKWISE: i32 = 20_120;
    pub const POCKET_COUNTERCLOCKWISE: i32 = 20_130;
    /// Haas's G70 to G72 of mills: holes on a circle, on an arc and on a line.
    pub const HOLES_ON_CIRCLE: i32 = 20_700;
    pub const HOLES_ON_ARC: i32 = 20_710;
    pub const HOLES_ON_LINE: i32 = 20_720;
    /// Haas's G100 and G101: mirrors that stand at zero, off and on.
    pub const MIRROR_OFF: i32 = 21_000;
    pub const MIRROR_ON: i32 = 21_010;
    /// M109: the operator is asked for a variable.
    pub const ASK_OPERATOR: i32 = 109;
    /// G76 of mills: boring with a step aside at the bottom.
    pub const FINE_BORE: i32 = 761;
    /// G50 S of lathes: the greatest spindle speed.
    pub const SPEED_LIMIT: i32 = 505;
    /// G90, G92, G94 of lathes: one cut along, one thread, one cut across.
    pub const TURN_CUT: i32 = 10_900;
    pub const THREAD_CUT: i32 = 10_920;
    pub const FACE_CUT: i32 = 10_940;
    /// G70 to G76 of lathes.
    pub const FINISH: i32 = 10_700;
    pub const ROUGH_TURN: i32 = 10_710;
    pub const ROUGH_FACE: i32 = 10_720;
    pub const REPEAT_PATTERN: i32 = 10_730;
    pub const PECK_FACE: i32 = 10_740;
    pub const PECK_GROOVE: i32 = 10_750;
    pub const THREAD: i32 = 10_760;
}

/// What a G code means on a Fanuc or Haas control.
pub(super) fn fanuc_g(tenths: i32, dialect: Dialect, lathe: bool) -> Meaning {
    use Meaning::{Code, Common, Noted, Nothing, Unknown};
    let haas = dialect == Dialect::Haas;
    match tenths {
        320 if lathe => Code(Group::Motion, 330),
        500 if lathe => Code(Group::NonModal, own::SPEED_LIMIT),
        980 if lathe => Code(Group::FeedMode, 940),
        990 if lathe => Code(Group::FeedMode, 950),
        700 | 710 | 720 | 730 | 740 | 750 | 760 | 900 | 920 | 940 if lathe => Code(Group::Motion, 10_000 + tenths),
        120 | 130 if haas && !lathe => Code(Group::NonModal, 20_000 + tenths),
        700 | 710 | 720 if haas => Code(Group::NonModal, 20_000 + tenths),
        1000 | 1010 if haas => Code(Group::Mirror, 20_000 + tenths),
        700 | 710..=712 | 720..=722 => Unknown,
        760 => Code(Group::Motion, own::FINE_BORE),
        842 | 843 => Code(Group::Motion, if tenths == 842 { 840 } else { 740 }),
        // The mirror of double turrets, on lathes.
        680 | 690 if lathe && !haas => Unknown,
        // Fine spindle motion, a tap of a driven tool, and X and Y as X and C, on and off: on Haas's lathes.
        50 | 950 | 1120 | 1130 if haas && lathe => Unknown,
        // Look-ahead, smoothing, exact stop, path modes, stored strokes, look-ahead off.
        50 | 51 | 80 | 1870 | 1030 | 220 | 230 | 640 => Noted,
        90 | 110 | 610 | 620 | 630 | 641 | 670 => Nothing,
        150 | 160 => Code(Group::Polar, tenths),
        310 => Code(Group::NonModal, own::SKIP),
        440 => Code(Group::ToolLength, 440),
        500 | 510 => Code(Group::Scale, tenths),
        501 | 511 => Code(Group::Mirror, tenths),
        541 => Code(Group::Coordinates, 541),
        1540 if haas => Code(Group::Coordinates, 541),
        // Haas: G110 is G154 P1.
        1100..=1290 if haas && tenths % 10 == 0 => Code(Group::Coordinates, tenths),
        2340 if haas => Code(Group::ToolLength, 434),
        650 => Code(Group::Subprogram, own::MACRO_CALL),
        680 => Code(Group::Turn, 680),
        // What these mean on LinuxCNC, they do not here.
        52 | 53 | 70 | 331 | 382..=385 | 411 | 421 | 431 | 432 | 591..=593 | 611 | 901 | 911 | 921..=923 => Unknown,
        _ => Common,
    }
}

/// What an M code means on a Fanuc or Haas control.
pub(super) fn fanuc_m(number: i32, dialect: Dialect, lathe: bool) -> Meaning {
    match number {
        133..=135 | 143..=145 if lathe && dialect == Dialect::Haas => Meaning::Code(Group::Driven, number),
        97 if dialect == Dialect::Haas => Meaning::Code(Group::Subprogram, own::LOCAL_CALL),
        16 if dialect == Dialect::Haas && !lathe => Meaning::Code(Group::ToolChange, 6),
        // A jump that hangs on the pallet.
        46 if dialect == Dialect::Haas => Meaning::Unknown,
        109 if dialect == Dialect::Haas => Meaning::Code(Group::Signal, own::ASK_OPERATOR),
        // Clamps, chucks, tailstocks, conveyors, coolant, gears, doors, lights, chips, probes, rigid tapping: the builder's, not the axes'.
        10..=18
        | 20..=29
        | 31..=36
        | 38
        | 39
        | 40..=46
        | 51..=59
        | 61..=69
        | 70..=89
        | 95
        | 104
        | 105
        | 109..=149
        | 154
        | 155 => Meaning::Noted,
        // Pallets.
        50 | 60 => Meaning::Unknown,
        _ => Meaning::Common,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_read_as_people_write_them() {
        for (text, name) in [("G187", "G187"), ("g5.1", "G5.1"), ("M031", "M31"), (" M6 ", "M6")] {
            assert_eq!(text.parse::<CodeName>().unwrap().to_string(), name);
        }
        for text in ["", "G", "X1", "G1.23", "G-1", "Ginf", "G1e3", "M99999", "G 1x"] {
            assert!(text.parse::<CodeName>().is_err(), "{text}");
        }
        assert_eq!("Haas".parse(), Ok(Dialect::Haas));
        assert!("siemens".parse::<Dialect>().unwrap_err().contains("linuxcnc, fanuc, haas, grbl"));
    }
}
