//! Dialects: which control a program is written for, and what that control's codes mean here.
//!
//! LinuxCNC's is the base. Fanuc's and Haas's differ by the tables of this file (codes that move nothing, codes with another meaning), by
//! the macro language (`macro_flow`), by subprograms and calls (`fanuc`) and, on lathes, by G-code system A (`lathe`).

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
}

impl Dialect {
    /// All dialects.
    pub const ALL: [Self; 3] = [Self::LinuxCnc, Self::Fanuc, Self::Haas];

    /// Its name, as [`FromStr`] takes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LinuxCnc => "linuxcnc",
            Self::Fanuc => "fanuc",
            Self::Haas => "haas",
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
        assert!("siemens".parse::<Dialect>().unwrap_err().contains("linuxcnc, fanuc, haas"));
    }
}
