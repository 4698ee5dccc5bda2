//! Mesh files: STL (binary and text), OBJ, OFF, PLY, GLB and 3MF, with what was found in them and what was done about it.
//!
//! A file is read whole, its triangles are scaled to mm and welded: corners that fall on the same point of the
//! coordinate grid become one vertex. Then, because a triangle is a set of points here:
//!
//! - a triangle that collapses (two corners weld) is dropped: in a closed mesh its points belong to its neighbours;
//! - a triangle with the same three corners as an earlier one, in any order, is dropped;
//! - a triangle with three different corners on a line is kept: it weighs nothing, its corners count, and dropping it
//!   would open its neighbours.
//!
//! Nothing else is repaired. What the edges are like afterwards is in the report.

mod error;
mod glb;
mod lines;
mod obj;
mod off;
mod placement;
mod ply;
mod stl;
#[cfg(feature = "3mf")]
mod three_mf;
#[cfg(test)]
mod tests;

pub use error::{ImportError, Place};
pub use stl::write as write_stl;

use super::{Mesh, Point, mesh::EdgeReport};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::fmt;
use std::path::Path;

/// The unit of a file's coordinates. Only GLB, which is in metres, and 3MF, which names its unit, say it themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unit {
    /// Millimetres.
    #[default]
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches.
    Inch,
}

impl Unit {
    /// How many mm one unit is.
    #[must_use]
    pub const fn in_mm(self) -> f64 {
        match self {
            Self::Mm => 1.0,
            Self::Cm => 10.0,
            Self::M => 1000.0,
            Self::Inch => 25.4,
        }
    }
}

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// STL as triangles of 50 bytes.
    BinaryStl,
    /// STL as text.
    TextStl,
    /// Wavefront OBJ.
    Obj,
    /// Object File Format, as text.
    Off,
    /// Polygon File Format, as text or binary.
    Ply,
    /// The binary form of glTF.
    Glb,
    /// 3D Manufacturing Format.
    ThreeMf,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BinaryStl => "binary STL",
            Self::TextStl => "text STL",
            Self::Obj => "OBJ",
            Self::Off => "OFF",
            Self::Ply => "PLY",
            Self::Glb => "GLB",
            Self::ThreeMf => "3MF",
        })
    }
}

/// What was found in a file and what was done about it.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportReport {
    /// The format it was read as.
    pub format: Format,
    /// What one unit of the file was taken to be, mm.
    pub unit_mm: f64,
    /// Triangles in the file; polygons count as the triangles of their fans.
    pub triangles_read: usize,
    /// Triangles dropped because an earlier one has the same corners.
    pub duplicate: usize,
    /// Triangles dropped because corners of theirs fell together.
    pub collapsed: usize,
    /// Triangles kept although their corners are on a line.
    pub degenerate: usize,
    /// Vertices of the file's triangles that became one with an earlier vertex. STL has three per triangle.
    pub welded_vertices: usize,
    /// How the edges of the mesh fit together.
    pub edges: EdgeReport,
    /// Whether the mesh is closed but its triangles wind the wrong way round: its volume comes out negative.
    pub inside_out: bool,
}

impl fmt::Display for ImportReport {
    /// In a line, what an engineer wants to know: `OFF in units of 1 mm, 4 triangles, watertight`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kept = self.triangles_read - self.duplicate - self.collapsed;
        write!(f, "{} in units of {} mm, {kept} triangles", self.format, self.unit_mm)?;
        for (number, what) in [
            (self.welded_vertices, "vertices welded"),
            (self.duplicate, "duplicate triangles dropped"),
            (self.collapsed, "collapsed triangles dropped"),
            (self.degenerate, "degenerate triangles kept"),
        ] {
            if number > 0 {
                write!(f, ", {number} {what}")?;
            }
        }
        let EdgeReport { open, non_manifold, flipped } = self.edges;
        match (self.edges.is_watertight(), self.inside_out) {
            (true, false) => f.write_str(", watertight"),
            (true, true) => f.write_str(", watertight but inside out"),
            (false, _) => write!(
                f,
                ", not watertight: {open} open edges, {non_manifold} between more than two triangles, {flipped} between \
                 triangles that wind against each other"
            ),
        }
    }
}

/// A mesh from a file, mm.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The mesh, mm, in the file's frame.
    pub mesh: Mesh,
    /// How it came about.
    pub report: ImportReport,
}

/// What a reader returns: vertices in the file's unit and faces whose indices are valid.
#[derive(Debug, Default)]
struct Raw {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
    /// The unit that the file or its format names, mm.
    unit_mm: Option<f64>,
}

/// The unit of a GLB file, mm.
const METRE: f64 = Unit::M.in_mm();

/// Largest file that is read, bytes. Text has at least 20 bytes per triangle, so that vertex indices fit 32 bits.
const LARGEST_FILE: u64 = 1 << 32;

/// Reads a mesh file. The extension says what it is (`.stl`, `.obj`, `.off`, `.ply`, `.glb`, `.3mf`);
/// without one of these, its beginning does. Without a unit, the file's own holds (3MF), the format's (GLB: metres), or mm.
///
/// # Errors
/// [`ImportError`] with the file and the line, or the triangle and the byte, when the file cannot be read, is not a
/// mesh, is cut short, disagrees with its own header, or has a coordinate that is not finite or beyond ±4096 mm.
pub fn load(path: &Path, unit: Option<Unit>) -> Result<Imported, ImportError> {
    let unreadable = |source| ImportError::Unreadable { path: path.into(), source };
    let bytes = std::fs::metadata(path).map_err(unreadable)?.len();
    if bytes >= LARGEST_FILE {
        return Err(ImportError::TooLarge { path: path.into(), bytes, most: LARGEST_FILE });
    }
    parse(path, &std::fs::read(path).map_err(unreadable)?, unit)
}

/// As [`load`], of a file's content; the path serves for its extension and for messages.
///
/// # Errors
/// As [`load`].
pub fn parse(path: &Path, content: &[u8], unit: Option<Unit>) -> Result<Imported, ImportError> {
    parse_in(path, content, unit.map(Unit::in_mm))
}

/// As [`parse`], with a unit of any length, mm.
///
/// # Errors
/// As [`load`].
pub fn parse_scaled(path: &Path, content: &[u8], unit_mm: f64) -> Result<Imported, ImportError> {
    parse_in(path, content, Some(unit_mm))
}

fn parse_in(path: &Path, content: &[u8], unit_mm: Option<f64>) -> Result<Imported, ImportError> {
    let Some(format) = format_of(path, content) else {
        return Err(ImportError::UnknownFormat { path: path.into() });
    };
    let raw = match format {
        Format::BinaryStl => stl::read_binary(path, content),
        Format::TextStl => stl::read_text(path, content),
        Format::Obj => obj::read(path, content),
        Format::Off => off::read(path, content),
        Format::Ply => ply::read(path, content),
        Format::Glb => glb::read(path, content),
        #[cfg(feature = "3mf")]
        Format::ThreeMf => three_mf::read(path, content),
        #[cfg(not(feature = "3mf"))]
        Format::ThreeMf => Err(ImportError::NotBuiltIn { path: path.into(), format: "3MF", feature: "3mf" }),
    }?;
    let unit_mm = unit_mm.or(raw.unit_mm).unwrap_or(Unit::Mm.in_mm());
    clean(raw, format, unit_mm).map_err(|source| ImportError::NotAMesh { path: path.into(), source })
}

/// How an archive begins, which a 3MF file is.
const ZIP: &[u8] = b"PK\x03\x04";

fn format_of(path: &Path, content: &[u8]) -> Option<Format> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    let stl = if stl::is_text(content) { Format::TextStl } else { Format::BinaryStl };
    match extension.as_deref() {
        Some("stl") => Some(stl),
        Some("obj") => Some(Format::Obj),
        Some("off") => Some(Format::Off),
        Some("ply") => Some(Format::Ply),
        Some("glb") => Some(Format::Glb),
        Some("3mf") => Some(Format::ThreeMf),
        _ if ply::is_ply(content) => Some(Format::Ply),
        _ if glb::is_glb(content) => Some(Format::Glb),
        _ if content.starts_with(ZIP) => Some(Format::ThreeMf),
        _ if off::is_off(content) => Some(Format::Off),
        _ if stl == Format::TextStl || stl::has_declared_size(content) => Some(stl),
        _ if obj::is_obj(content) => Some(Format::Obj),
        _ => None,
    }
}

/// Scales, welds and drops, as the module's header says.
fn clean(raw: Raw, format: Format, unit_mm: f64) -> Result<Imported, super::MeshError> {
    let triangles_read = raw.faces.len();
    let referenced: HashSet<u32> = raw.faces.iter().flatten().copied().collect();
    let scaled = Mesh::new(raw.vertices.iter().map(|p| p * unit_mm).collect(), raw.faces)?;
    let welded = Mesh::from_triangles(&scaled.triangles())?;
    let welded_vertices = referenced.len() - welded.vertices().len();

    let (mut duplicate, mut collapsed) = (0, 0);
    let mut seen = HashSet::new();
    let mut faces = Vec::with_capacity(triangles_read);
    for &face in welded.faces() {
        let mut corners = face;
        corners.sort_unstable();
        if corners[0] == corners[1] || corners[1] == corners[2] {
            collapsed += 1;
        } else if seen.insert(corners) {
            faces.push(face);
        } else {
            duplicate += 1;
        }
    }
    let kept = Mesh::new(welded.vertices().to_vec(), faces)?;
    // Once more, to leave out vertices that only dropped triangles used.
    let mesh = Mesh::from_triangles(&kept.triangles())?;
    let degenerate = mesh.triangles().iter().filter(|t| t.area() <= 0.0).count();
    let edges = mesh.edge_report();
    let inside_out = edges.is_watertight() && mesh.signed_volume() < 0.0;
    let report = ImportReport {
        format,
        unit_mm,
        triangles_read,
        duplicate,
        collapsed,
        degenerate,
        welded_vertices,
        edges,
        inside_out,
    };
    Ok(Imported { mesh, report })
}
