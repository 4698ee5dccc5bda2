//! Wavefront OBJ, through the `tobj` crate.
//!
//! Only vertex positions and faces are used. `tobj` receives only these, without texture and normal indices, so that a broken texture index
//! cannot spoil a good mesh. It receives one line at a time, so that its errors have line numbers. Polygons are divided into triangles
//! ([`super::polygon`]). Lines, points and curves are ignored; objects and groups are merged into one mesh. A statement that is not known is
//! refused, because it may be a surface.

use super::super::Point;
use super::error::{ImportError, Place, quote};
use super::lines::Lines;
use super::{MOST, Raw};
use std::cell::Cell;
use std::collections::HashMap;
use std::path::Path;

/// Statements that define no surface: coordinates of textures, normals and parameters, groups, materials, display, lines, points, curves.
const WITHOUT_SURFACE: &str = "vt vn vp g o s mg mtllib usemtl maplib usemap lod bevel c_interp d_interp shadow_obj trace_obj l p cstype \
                               deg bmat step curv curv2 parm sp end ctech stech scrv";

/// What a line states.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Statement {
    Vertex,
    Face,
    WithoutSurface,
    Unknown,
}

fn statement(line: &str) -> Statement {
    match line.split_ascii_whitespace().next() {
        Some("v") => Statement::Vertex,
        // The older name of a face.
        Some("f" | "fo") => Statement::Face,
        Some(word) if !word.starts_with('#') && !WITHOUT_SURFACE.split(' ').any(|known| known == word) => {
            Statement::Unknown
        }
        _ => Statement::WithoutSurface,
    }
}

/// Whether content without a known extension looks like OBJ: its first vertex comes before any line that is not OBJ.
pub(super) fn is_obj(content: &[u8]) -> bool {
    let text = String::from_utf8_lossy(content);
    let first = text.lines().map(statement).find(|found| matches!(found, Statement::Vertex | Statement::Unknown));
    first == Some(Statement::Vertex)
}

pub(super) fn read(path: &Path, content: &[u8]) -> Result<Raw, ImportError> {
    let text = String::from_utf8_lossy(content);
    let number = Cell::new(0);
    let mut reader = Lines::new(&text, |_, line| positions_only(line), None, &number);
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let wrong = |line: usize, message: String| {
        let quoted = quote(text.lines().nth(line.saturating_sub(1)).unwrap_or(""));
        ImportError::at(path, &Place::Line(line), format!("{message}: {quoted}"))
    };
    if let Some(index) = text.lines().position(|line| statement(line) == Statement::Unknown) {
        return Err(wrong(index + 1, "this statement is not read, and may be a surface".to_owned()));
    }
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
    match statement(line) {
        Statement::Face => corners(line).count().saturating_sub(2),
        _ => 0,
    }
}

/// The corners of a face, as they are written.
fn corners(line: &str) -> impl Iterator<Item = &str> {
    line.split_ascii_whitespace().skip(1).take_while(|word| !word.starts_with('#'))
}

/// The line, counted from 1, with which a file has more than `most` vertices or triangles.
fn line_beyond(text: &str, most: usize) -> Option<usize> {
    let (mut vertices, mut faces) = (0, 0);
    let is_beyond = |line: &str| {
        vertices += usize::from(statement(line) == Statement::Vertex);
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
    match statement(line) {
        Statement::Vertex => line.split_ascii_whitespace().take(4).collect::<Vec<_>>().join(" "),
        Statement::Face => {
            let index = |word| str::split(word, '/').next().unwrap_or("");
            std::iter::once("f").chain(corners(line).map(index)).collect::<Vec<_>>().join(" ")
        }
        _ => String::new(),
    }
}

/// The first line, counted from 1, with a face that refers to an undefined vertex; 0 when there is none. An index above 0 counts all vertices
/// of the file, one below 0 those before its line.
fn line_of_missing_vertex(text: &str) -> usize {
    let all = text.lines().filter(|line| statement(line) == Statement::Vertex).count();
    let mut before = 0;
    let is_wrong = |line: &str| {
        before += usize::from(statement(line) == Statement::Vertex);
        let is_missing = |index: i64| {
            let among = if index > 0 { all } else { before };
            index == 0 || index.unsigned_abs() as usize > among
        };
        let is_face = statement(line) == Statement::Face;
        is_face && positions_only(line).split_ascii_whitespace().any(|word| word.parse::<i64>().is_ok_and(is_missing))
    };
    text.lines().position(is_wrong).map_or(0, |index| index + 1)
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
        for (faces, line) in [("f -1 -2 -3", 0), ("f -1 -2 -4", 4), ("fo 1 2 4", 0), ("f 1 2 5", 4), ("f 1 2 0/1", 4)] {
            let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}\nv 1 1 0\n");
            assert_eq!(line_of_missing_vertex(&text), line, "{faces}");
        }
    }
}
