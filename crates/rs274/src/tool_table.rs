//! LinuxCNC's tool table: a tool a line, as in `T1 P1 Z+12.5 D6 ;end mill` (LinuxCNC, "Tool Table").
//!
//! T is the tool's number, P its pocket, X to W what G43 adds to the axes, D the diameter, Q a lathe tool's orientation; I
//! and J, its angles, move nothing and are read past.

use super::canonical::Axis;
use super::error::{Cause, Fault, GcodeError};
use super::setup::Tool;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads a tool table whose lengths are in units of `unit_mm` mm; angles are in degrees. `file` is only named in errors.
///
/// # Errors
/// The first entry that is wrong, with file, line and column.
pub fn read_tool_table(text: &str, file: &Path, unit_mm: f64) -> Result<BTreeMap<u32, Tool>, GcodeError> {
    let mut tools = BTreeMap::new();
    for (line, entry) in (1..).zip(super::source::every_line(text)) {
        let read = entry_of(entry, unit_mm).and_then(|found| match found {
            Some((number, column, tool)) => match tools.insert(number, tool) {
                None => Ok(()),
                Some(_) => Err(Fault::new(column, format!("T{number}"), Cause::DuplicateWord)),
            },
            None => Ok(()),
        });
        read.map_err(|fault| GcodeError::of(file, line, fault))?;
    }
    Ok(tools)
}

/// A line's tool: number, the column it stands at, and what is known of it; `None` for a line without entry.
fn entry_of(line: &str, unit_mm: f64) -> Result<Option<(u32, u32, Tool)>, Fault> {
    let entry = line.split(';').next().unwrap_or_default();
    let (mut number, mut tool) = (None, Tool::default());
    let mut rest = entry;
    loop {
        rest = rest.trim_start();
        let column = (entry.len() - rest.len()) as u32 + 1;
        let Some(word) = rest.split_whitespace().next() else { break };
        rest = &rest[word.len()..];
        let fault = |cause| Fault::new(column, word, cause);
        let mut characters = word.chars();
        let letter = characters.next().unwrap_or_default().to_ascii_uppercase();
        let value: f64 = characters.as_str().parse().map_err(|_| fault(Cause::Expected("a number")))?;
        if !value.is_finite() {
            return Err(fault(Cause::Expected("a finite number")));
        }
        match (letter, Axis::from_letter(letter)) {
            ('T', _) if value.fract() == 0.0 && (0.0..=99_999.0).contains(&value) => {
                number = Some((value as u32, column));
            }
            ('T', _) => return Err(fault(Cause::Range("T", "a whole number from 0 to 99999"))),
            ('D', _) => tool.diameter_mm = value * unit_mm,
            ('Q', _) if value.fract() == 0.0 && (0.0..=9.0).contains(&value) => tool.orientation = value as u8,
            ('Q', _) => return Err(fault(Cause::Range("Q", "an orientation from 0 to 9"))),
            ('P' | 'I' | 'J', _) => {}
            (_, Some(axis)) if axis.is_rotary() => tool.offset[axis] = value.to_radians(),
            (_, Some(axis)) => tool.offset[axis] = value * unit_mm,
            _ => return Err(fault(Cause::UnknownLetter)),
        }
    }
    match number {
        Some((number, column)) => Ok(Some((number, column, tool))),
        None if entry.trim().is_empty() => Ok(None),
        None => Err(Fault::new(1, entry.trim(), Cause::Missing("T, the tool's number,"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<BTreeMap<u32, Tool>, String> {
        read_tool_table(text, Path::new("mill.tbl"), 25.4).map_err(|error| error.to_string())
    }

    #[test]
    fn lengths_are_in_the_tables_unit() {
        let tools = read("; a comment\nT1 P1 D0.125 Z+0.5 ;1/8 end mill\n\nT10 P2 X-1 B90 Q3\n").unwrap();
        assert_eq!(tools[&1].offset[Axis::Z], 12.7);
        assert_eq!(tools[&1].diameter_mm, 3.175);
        assert_eq!((tools[&10].offset[Axis::X], tools[&10].orientation), (-25.4, 3));
        assert_eq!(tools[&10].offset[Axis::B], std::f64::consts::FRAC_PI_2);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        for (text, message) in [
            ("T1 Z1\nT1 Z2", "mill.tbl:2:1: word given twice in one block: `T1`"),
            ("P1 Z1", "mill.tbl:1:1: T, the tool's number, is missing: `P1 Z1`"),
            ("T1 Zx", "mill.tbl:1:4: a number expected: `Zx`"),
            ("T1 K1", "mill.tbl:1:4: letter without meaning: `K1`"),
            ("T1 Q10", "mill.tbl:1:4: Q must be an orientation from 0 to 9: `Q10`"),
            ("T1.5", "mill.tbl:1:1: T must be a whole number from 0 to 99999: `T1.5`"),
        ] {
            assert_eq!(read(text).unwrap_err(), message);
        }
    }
}
