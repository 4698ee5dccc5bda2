//! STL, through the `stl_io` crate (3D Systems, StereoLithography Interface Specification, 1989).
//!
//! Deviations from `stl_io`: a file is binary when its size matches the binary header, whatever its first bytes are, because many exporters
//! begin binary files with `solid`. Text may hold several solids, which are merged into one mesh. A solid needs no name, and keywords may
//! be in upper case. Normals are ignored, because the winding gives the same direction and is more often right.

use super::super::{Mesh, Point, Triangle};
use super::error::{ImportError, Place};
use super::lines::Lines;
use super::{MOST, Raw};
use std::cell::Cell;
use std::io::{Cursor, Write};
use std::path::Path;

/// Bytes before the first triangle; below, the bytes of one triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;
/// Characters of a line of text that are looked at; no line of the format is nearly as long.
const LONGEST_LINE: usize = 1 << 12;

/// Number of triangles in the header of a binary file, and the bytes that they take with the header.
fn declared(content: &[u8]) -> Option<(u64, u64)> {
    let count = content.get(HEADER - 4..HEADER)?;
    let count = u64::from(u32::from_le_bytes(count.try_into().ok()?));
    Some((count, HEADER as u64 + TRIANGLE as u64 * count))
}

/// Whether a file has the size that its binary header announces.
pub(super) fn has_declared_size(content: &[u8]) -> bool {
    declared(content).is_some_and(|(_, expected)| expected == content.len() as u64)
}

/// Whether a file is to be read as text.
pub(super) fn is_text(content: &[u8]) -> bool {
    let text = content.trim_ascii_start();
    // In upper case only a word of its own: binary headers begin with `SolidWorks` and the like.
    let word = text.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    (text.starts_with(b"solid") || word.eq_ignore_ascii_case(b"solid")) && !has_declared_size(content)
}

pub(super) fn read_binary(path: &Path, content: &[u8]) -> Result<Raw, ImportError> {
    let (declared, expected) = declared(content).unwrap_or((0, HEADER as u64));
    if expected != content.len() as u64 {
        let message = format!(
            "the header announces {declared} triangles, {expected} bytes, but the file has {} bytes",
            content.len()
        );
        return Err(ImportError::of_file(path, message));
    }
    // stl_io takes a header that begins with `solid` for text; the header means nothing.
    let mut file = content.to_vec();
    file[..HEADER - 4].fill(0);
    let mut cursor = Cursor::new(file);
    let place = |index: usize| Place::Triangle { index, byte: HEADER + TRIANGLE * index };
    collect(path, stl_io::create_stl_reader(&mut cursor), place)
}

pub(super) fn read_text(path: &Path, content: &[u8]) -> Result<Raw, ImportError> {
    let text = String::from_utf8_lossy(content);
    let first_word = |line: &str| line.split_ascii_whitespace().next().map(str::to_ascii_lowercase);
    let last = text.lines().filter_map(first_word).next_back();
    // The lines that begin and end solids are blanked, so that all facets are in one, which has no end when the last
    // has none. Normals, which some exporters write as NaN, become zero. Line numbers stay.
    let neutral = |number: usize, line: &str| match first_word(line).as_deref() {
        _ if number == 1 => "solid ".to_owned(),
        Some("solid" | "endsolid") => String::new(),
        Some("facet") => "facet normal 0 0 0".to_owned(),
        _ => line.trim().chars().take(LONGEST_LINE).collect::<String>().to_ascii_lowercase(),
    };
    let number = Cell::new(0);
    let end = (last.as_deref() == Some("endsolid")).then_some("endsolid");
    let mut reader = Lines::new(&text, neutral, end, &number);
    let stl = stl_io::create_stl_reader(&mut reader);
    collect(path, stl, |_| Place::Line(number.get()))
}

/// The reader that `stl_io` returns.
type Reader<'a> = Box<dyn stl_io::TriangleIterator<Item = std::io::Result<stl_io::Triangle>> + 'a>;

/// All triangles of a reader; `place` converts the index of a triangle to a place in the file.
fn collect(
    path: &Path,
    reader: std::io::Result<Reader<'_>>,
    place: impl Fn(usize) -> Place,
) -> Result<Raw, ImportError> {
    let wrong = |index, message: String| ImportError::at(path, &place(index), message);
    let mut raw = Raw::default();
    for (index, triangle) in reader.map_err(|error| wrong(0, error.to_string()))?.enumerate() {
        if index >= MOST {
            return Err(wrong(index, format!("the file has more than {MOST} triangles")));
        }
        let triangle = triangle.map_err(|error| wrong(index, error.to_string()))?;
        for vertex in &triangle.vertices {
            if vertex.0.iter().any(|x| !x.is_finite()) {
                return Err(wrong(index, format!("{:?} is not finite", vertex.0)));
            }
        }
        let first = raw.vertices.len() as u32;
        raw.vertices.extend(triangle.vertices.iter().map(|v| Point::from(v.0.map(f64::from))));
        raw.faces.push([first, first + 1, first + 2]);
    }
    Ok(raw)
}

/// Writes a mesh as binary STL, mm. Coordinates become single precision: up to 0.12 µm off near 4 m.
///
/// # Errors
/// Errors of the writer.
pub fn write(mesh: &Mesh, to: &mut impl Write) -> std::io::Result<()> {
    write_triangles(&mesh.triangles(), to)
}

/// Writes triangles, mm, as binary STL, in single precision.
///
/// # Errors
/// Errors of the writer.
pub fn write_triangles(triangles: &[Triangle], to: &mut impl Write) -> std::io::Result<()> {
    let single = |v: [f64; 3]| stl_io::Vector::new(v.map(|x| x as f32));
    let triangle = |t: &Triangle| {
        let normal = t.double_area_normal().try_normalize(0.0).unwrap_or_default();
        stl_io::Triangle { normal: single(normal.into()), vertices: t.corners.map(|p| single(p.coords.into())) }
    };
    let triangles: Vec<_> = triangles.iter().map(triangle).collect();
    stl_io::write_stl(to, triangles.iter())
}
