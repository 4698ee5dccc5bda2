//! LinuxCNC's parameter file: a number and a value a line, as in `5221 -120.5` (LinuxCNC, "Parameter file"). It keeps the places of
//! G28 and G30, the origins of G54 to G59.3, the system in force, G92, and whatever programs have put into parameters 31 to 5000.

use super::canonical::Axis;
use super::error::{Cause, Fault, GcodeError};
use super::parameters::MAX_PARAMETER;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads a parameter file whose lengths are in units of `unit_mm` mm, into what [`super::Setup::parameters`] holds. `file` is only named
/// in errors.
///
/// # Errors
/// The first line that is wrong, with file, line and column.
pub fn read_parameter_file(text: &str, file: &Path, unit_mm: f64) -> Result<BTreeMap<String, f64>, GcodeError> {
    let mut parameters = BTreeMap::new();
    for (line, entry) in (1..).zip(super::source::every_line(text)) {
        let read = entry_of(entry).and_then(|found| match found {
            Some((index, value)) => {
                let value = if is_length(index) { value * unit_mm } else { value };
                match parameters.insert(index.to_string(), value) {
                    None => Ok(()),
                    Some(_) => Err(Fault::new(1, index.to_string(), Cause::DuplicateWord)),
                }
            }
            None => Ok(()),
        });
        read.map_err(|fault| GcodeError::of(file, line, fault))?;
    }
    Ok(parameters)
}

/// A line's parameter and value; `None` for a blank line.
fn entry_of(line: &str) -> Result<Option<(usize, f64)>, Fault> {
    let mut rest = line;
    // The next word and its column in characters.
    let mut next = || {
        rest = rest.trim_start();
        let word = rest.split_whitespace().next()?;
        let column = line[..line.len() - rest.len()].chars().count() as u32 + 1;
        rest = &rest[word.len()..];
        Some((word, column))
    };
    let wrong = |(word, column): (&str, u32), cause| Err(Fault::new(column, word, cause));
    let Some(first) = next() else { return Ok(None) };
    let index = match first.0.parse::<usize>() {
        Ok(index) if (1..=MAX_PARAMETER).contains(&index) => index,
        _ => return wrong(first, Cause::Expected("the number of a parameter, 1 to 5601,")),
    };
    let Some(second) = next() else {
        let end = line.chars().count() as u32 + 1;
        return Err(Fault::new(end, "", Cause::Expected("the parameter's value")));
    };
    let value = match second.0.parse::<f64>() {
        Ok(value) if value.is_finite() => value,
        _ => return wrong(second, Cause::Expected("a finite number")),
    };
    match next() {
        Some(word) => wrong(word, Cause::Expected("the end of the line")),
        None => Ok(Some((index, value))),
    }
}

/// Whether a parameter is a coordinate of a linear axis: they stand in groups of nine, X to W.
fn is_length(index: usize) -> bool {
    let in_group = |first: usize| (first..first + 9).contains(&index).then(|| index - first);
    let group = [5161, 5181, 5211].into_iter().chain((0..9).map(|system| 5221 + 20 * system)).find_map(in_group);
    group.is_some_and(|axis| !Axis::ALL[axis].is_rotary())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<BTreeMap<String, f64>, String> {
        read_parameter_file(text, Path::new("mill.var"), 25.4).map_err(|error| error.to_string())
    }

    #[test]
    fn only_lengths_have_a_unit() {
        let read = read("5161\t2\n\n5220 2.0\n5224 90\n5241 -1\n5250 30\n31 7\n").unwrap();
        let expected = [("31", 7.0), ("5161", 50.8), ("5220", 2.0), ("5224", 90.0), ("5241", -25.4), ("5250", 30.0)];
        assert_eq!(read, expected.map(|(index, value)| (index.to_owned(), value)).into());
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        for (text, message) in [
            ("5161 0\n5700 1", "mill.var:2:1: the number of a parameter, 1 to 5601, expected: `5700`"),
            ("5161", "mill.var:1:5: the parameter's value expected"),
            ("5161 x", "mill.var:1:6: a finite number expected: `x`"),
            ("5161 1 2", "mill.var:1:8: the end of the line expected: `2`"),
            ("5161 1\n5161 2", "mill.var:2:1: word given twice in one block: `5161`"),
        ] {
            assert_eq!(read(text).unwrap_err(), message);
        }
    }
}
