//! Wavefront OBJ, through the `tobj` crate.
//!
//! Only vertex positions and faces are used. `tobj` receives only these, without texture and normal indices, so that a broken texture index
//! cannot spoil a good mesh. It receives one line at a time, so that its errors have line numbers. Polygons are divided into triangles
//! ([`super::polygon`]). Lines and points are ignored; objects and groups are merged into one mesh.

use super::super::Point;
use super::error::{ImportError, Place, quote};
use super::lines::Lines;
use super::{MOST, Raw};
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
    let mut reader = Lines::new(&text, |_, line| positions_only(line), None, &number);
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let wrong = |line: usize, message: String| ImportError::Content {
        path: path.into(),
        place: Place::Line(line),
        message: format!("{message}: {}", quote(text.lines().nth(line.saturating_sub(1)).unwrap_or(""))),
    };
    if let Some(line) = line_beyond(&text, MOST) {
        return Err(wrong(line, format!("the file has more than {MOST} vertices or triangles")));
    }
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| Ok((Vec::new(), HashMap::new())));
    let (models, _) = loaded.map_err(|error| match error {
        // Found only when all lines have been read.
        tobj::LoadError::FaceVertexOutOfBounds => wrong(line_of_missing_vertex(&text), error.to_string()),
        _ => wrong(number.get(), error.to_string()),
    })?;

    let mut raw = Raw::default();
    let mut face = 0;
    for model in models {
        let first = raw.vertices.len() as u32;
        raw.vertices.extend(model.mesh.positions.chunks_exact(3).map(|p| Point::new(p[0], p[1], p[2])));
        let corners: Vec<u32> = model.mesh.indices.iter().map(|corner| first + corner).collect();
        // A mesh of triangles alone names no numbers of corners.
        let triangles = std::iter::repeat_n(3, corners.len() / 3);
        let sizes: Box<dyn Iterator<Item = usize>> = match &model.mesh.face_arities[..] {
            [] => Box::new(triangles),
            sizes => Box::new(sizes.iter().map(|&size| size as usize)),
        };
        let mut rest = &corners[..];
        for size in sizes {
            let (polygon, after) = rest.split_at(size.min(rest.len()));
            raw.add_polygon(polygon).map_err(|why| wrong(line_of_face(&text, face), why))?;
            (rest, face) = (after, face + 1);
        }
    }
    Ok(raw)
}

/// The number of triangles that a line defines as a face: a point or a line has none.
fn triangles(line: &str) -> usize {
    let mut words = line.split_ascii_whitespace();
    match words.next() {
        Some("f") => words.take_while(|word| !word.starts_with('#')).count().saturating_sub(2),
        _ => 0,
    }
}

/// The line, counted from 1, with which a file has more than `most` vertices or triangles.
fn line_beyond(text: &str, most: usize) -> Option<usize> {
    let (mut vertices, mut faces) = (0, 0);
    let is_beyond = |line: &str| {
        vertices += usize::from(line.split_ascii_whitespace().next() == Some("v"));
        faces += triangles(line);
        vertices > most || faces > most
    };
    text.lines().position(is_beyond).map(|index| index + 1)
}

/// The line, counted from 1, of a face, counted from 0, among those with triangles; 0 when there is none.
fn line_of_face(text: &str, face: usize) -> usize {
    let faces = text.lines().enumerate().filter(|(_, line)| triangles(line) > 0);
    faces.map(|(index, _)| index + 1).nth(face).unwrap_or(0)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_and_triangles_are_counted_before_they_are_read() {
        let text = "v 0 0 0\nv 1 0 0\nvn 0 0 1\nf 1 2\nv 0 1 0\nv 1 1 0\nf 1/1 2 4 3 # 5 6 7\nf 1 2 3\n";
        for (most, line) in [(4, None), (3, Some(6)), (2, Some(5)), (0, Some(1))] {
            assert_eq!(line_beyond(text, most), line, "{most}");
        }
        assert_eq!(line_beyond("v 0 0 0\nf 1 1 1 1 1 1 1\n", 4), Some(2));
        assert_eq!([0, 1, 2].map(|face| line_of_face(text, face)), [7, 8, 0]);
    }
}
