//! Wavefront OBJ, through the `tobj` crate.
//!
//! Only vertex positions and faces are used. `tobj` receives only these, without texture and normal indices, so that a broken texture index
//! cannot spoil a good mesh. It receives one line at a time, so that its errors have line numbers. Polygons are divided into fans from
//! their first corner, which is correct for convex polygons. Lines and points are ignored; objects and groups are merged into one mesh.

use super::super::Point;
use super::Raw;
use super::error::{ImportError, Place, quote};
use super::lines::Lines;
use std::cell::Cell;
use std::collections::HashMap;
use std::path::Path;

/// Whether content without a known extension looks like OBJ: its first vertex comes before any line that is not OBJ.
pub(super) fn is_obj(content: &[u8]) -> bool {
    const KEYWORDS: [&str; 10] = ["#", "v", "vn", "vt", "f", "o", "g", "s", "mtllib", "usemtl"];
    let text = String::from_utf8_lossy(content);
    let mut words = text.lines().filter_map(|line| line.split_ascii_whitespace().next());
    let first = words.find(|word| *word == "v" || !(KEYWORDS.contains(word) || word.starts_with('#')));
    first == Some("v")
}

pub(super) fn read(path: &Path, content: &[u8]) -> Result<Raw, ImportError> {
    let text = String::from_utf8_lossy(content);
    let number = Cell::new(0);
    let mut reader = Lines::new(text.lines().map(positions_only).collect(), &number);
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    let wrong = |line: usize, message: String| ImportError::Content {
        path: path.into(),
        place: Place::Line(line),
        message: format!("{message}: {}", quote(text.lines().nth(line.saturating_sub(1)).unwrap_or(""))),
    };
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| Ok((Vec::new(), HashMap::new())));
    let (models, _) = loaded.map_err(|error| match error {
        // Found only when all lines have been read.
        tobj::LoadError::FaceVertexOutOfBounds => wrong(line_of_missing_vertex(&text), error.to_string()),
        _ => wrong(number.get(), error.to_string()),
    })?;

    let mut raw = Raw::default();
    for model in models {
        let first = raw.vertices.len() as u32;
        raw.vertices.extend(model.mesh.positions.chunks_exact(3).map(|p| Point::new(p[0], p[1], p[2])));
        raw.faces.extend(model.mesh.indices.chunks_exact(3).map(|f| [first + f[0], first + f[1], first + f[2]]));
    }
    Ok(raw)
}

/// The line without texture and normal indices if it defines a vertex or a face; otherwise a blank line.
fn positions_only(line: &str) -> String {
    let mut words = line.split_ascii_whitespace();
    match words.next() {
        Some("v") => line.split_ascii_whitespace().take(4).collect::<Vec<_>>().join(" "),
        Some("f") => {
            let index = |word| str::split(word, '/').next().unwrap_or("");
            let comment = |word: &&str| !word.starts_with('#');
            std::iter::once("f").chain(words.take_while(comment).map(index)).collect::<Vec<_>>().join(" ")
        }
        _ => String::new(),
    }
}

/// The first line, counted from 1, with a face that refers to an undefined vertex; 0 when there is none.
fn line_of_missing_vertex(text: &str) -> usize {
    let lines = || text.lines().map(positions_only);
    let vertices = lines().filter(|line| line.starts_with('v')).count();
    let missing =
        |word: &str| word.parse::<i64>().is_ok_and(|index| index == 0 || index.unsigned_abs() as usize > vertices);
    lines().position(|line| line.split_ascii_whitespace().any(missing) && line.starts_with('f')).map_or(0, |i| i + 1)
}
