//! OFF, the Object File Format of Geomview, as text.
//!
//! This reader is the project's own, because `off-rs`, the crate on the registry, keeps coordinates in single precision and accepts no
//! header but a bare `OFF` line. The format consists of numbers on lines: a header (`OFF`, preceded by `ST`, `C`, `N` when vertices have
//! more than a position, which is ignored), three counts, the vertices, and the faces, each beginning with its number of corners. Polygons
//! are divided into triangles ([`super::polygon`]). Lines after the announced faces are refused.

use super::super::Point;
use super::error::{ImportError, Place, quote};
use super::{MOST, Raw};
use std::path::Path;

/// Whether the content begins as an OFF file does.
pub(super) fn is_off(content: &[u8]) -> bool {
    const LONGEST_HEADER: usize = 4096;
    let text = String::from_utf8_lossy(&content[..content.len().min(LONGEST_HEADER)]);
    lines(&text).next().is_some_and(|(_, line)| header_ends(line).is_some())
}

/// The lines that are not blank, without comments, with their numbers from 1.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let content = |line: &'_ str| line.split('#').next().map_or(0, str::len);
    let bare = move |(i, line)| (i + 1, str::trim(&line[..content(line)]));
    text.lines().enumerate().map(bare).filter(|(_, line)| !line.is_empty())
}

/// The rest of the header line after its keyword; `None` without a keyword.
fn header_ends(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("ST").unwrap_or(line);
    let rest = rest.strip_prefix('C').unwrap_or(rest);
    let rest = rest.strip_prefix('N').unwrap_or(rest);
    let rest = rest.strip_prefix("OFF")?;
    (rest.is_empty() || rest.starts_with(char::is_whitespace)).then(|| rest.trim())
}

/// Reads the lines of one file.
struct Reader<'a, I> {
    path: &'a Path,
    lines: I,
    /// Number of the line read last.
    line: usize,
}

impl<'a, I: Iterator<Item = (usize, &'a str)>> Reader<'a, I> {
    fn wrong(&self, message: String) -> ImportError {
        ImportError::at(self.path, &Place::Line(self.line), message)
    }

    fn next_line(&mut self, what: &str) -> Result<&'a str, ImportError> {
        let Some((number, line)) = self.lines.next() else {
            return Err(self.wrong(format!("the file ends before {what}")));
        };
        self.line = number;
        Ok(line)
    }

    /// The first `count` words of a line as numbers.
    fn numbers<T: std::str::FromStr>(&self, line: &str, count: usize, what: &str) -> Result<Vec<T>, ImportError> {
        let numbers: Vec<T> = line.split_whitespace().take(count).map_while(|word| word.parse().ok()).collect();
        if numbers.len() == count {
            Ok(numbers)
        } else {
            Err(self.wrong(format!("expected {what}, found {}", quote(line))))
        }
    }
}

pub(super) fn read(path: &Path, content: &[u8]) -> Result<Raw, ImportError> {
    let text = String::from_utf8_lossy(content);
    let mut reader = Reader { path, lines: lines(&text), line: 1 };
    let header = reader.next_line("its header")?;
    let Some(rest) = header_ends(header) else {
        return Err(reader.wrong(format!("expected `OFF`, found {}", quote(header))));
    };
    if rest.starts_with("BINARY") {
        return Err(reader.wrong("binary OFF is not read".to_owned()));
    }
    let counts = if rest.is_empty() { reader.next_line("its counts")? } else { rest };
    let counts = reader.numbers::<u32>(counts, 2, "the numbers of vertices and faces")?;

    // The counts are the file's claim: nothing is reserved for them.
    let mut raw = Raw::default();
    for i in 0..counts[0] {
        let line = reader.next_line(&format!("vertex {i} of {}", counts[0]))?;
        let p = reader.numbers::<f64>(line, 3, "three coordinates")?;
        if !p.iter().all(|x| x.is_finite()) {
            return Err(reader.wrong(format!("{} is not finite", quote(line))));
        }
        if raw.vertices.len() >= MOST {
            return Err(reader.wrong(format!("the file has more than {MOST} vertices")));
        }
        raw.vertices.push(Point::new(p[0], p[1], p[2]));
    }
    for i in 0..counts[1] {
        let line = reader.next_line(&format!("face {i} of {}", counts[1]))?;
        let corners = reader.numbers::<u32>(line, 1, "a number of corners")?[0] as usize;
        let words = line.split_whitespace().count();
        if corners >= words {
            return Err(reader.wrong(format!("expected {corners} corners, found {}", quote(line))));
        }
        let face = &reader.numbers::<u32>(line, corners + 1, "vertex numbers")?[1..];
        if let Some(vertex) = face.iter().find(|&&v| v >= counts[0]) {
            return Err(reader.wrong(format!("there is no vertex {vertex}, only {}", counts[0])));
        }
        raw.add_polygon(face).map_err(|why| reader.wrong(why))?;
    }
    if let Some((number, line)) = reader.lines.next() {
        reader.line = number;
        let counts = format!("{} vertices and {} faces", counts[0], counts[1]);
        return Err(reader.wrong(format!("the header announces {counts}, and the file goes on with {}", quote(line))));
    }
    Ok(raw)
}
