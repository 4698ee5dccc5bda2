//! Reads mesh files: STL (binary and text), OBJ, OFF, PLY, GLB and 3MF, and reports what the file held and what was repaired.
//!
//! A file is read whole, and its triangles are scaled to mm and welded: vertices that fall on the same point of the coordinate grid are
//! merged, or, with a tolerance, vertices within that tolerance ([`super::weld`]). Then:
//!
//! - A triangle that collapses (two corners weld) is dropped. In a closed mesh its points belong to its neighbours.
//!
//! - A triangle with the same three corners as an earlier one is dropped. Triangles that wind against an earlier one stay if the mesh is
//!   watertight only with them, as of bodies with a side in common, and no component consists of such pairs alone. Beside other components,
//!   what is left of one that does (a cavity and the body that fills it) faces outwards.
//!
//! - A triangle with three different corners on a line is kept. It has no area, but its corners count, and dropping it would open the
//!   surface between its neighbours.
//!
//! Nothing else is repaired. The report counts these repairs; [`Mesh::surface_report`] describes the resulting surface.

mod clean;
mod error;
mod glb;
mod lines;
mod obj;
mod off;
mod placement;
mod ply;
mod polygon;
mod stl;
#[cfg(feature = "3mf")]
mod three_mf;
#[cfg(test)]
mod tests;

pub use error::ImportError;
pub use stl::{write as write_stl, write_triangles as write_stl_triangles};

use super::{Mesh, Point};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::ffi::OsStr;
use std::fmt;
use std::path::{Path, PathBuf};

/// The unit of a file's coordinates. Only two formats define it: GLB is in metres, and 3MF names its unit.
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
    /// The unit of a name in files: `mm`, `cm`, `m` or `inch`.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "mm" => Some(Self::Mm),
            "cm" => Some(Self::Cm),
            "m" => Some(Self::M),
            "inch" => Some(Self::Inch),
            _ => None,
        }
    }

    /// Length of one unit, mm.
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

/// How a file is to be read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The unit of the coordinates. When absent: the unit named in the file (3MF), the unit of the format (GLB: metres), or mm.
    pub unit: Option<Unit>,
    /// Welding distance, mm: vertices at most this far apart are merged. 0 merges only vertices on the same point of the grid; otherwise
    /// 1e-6 to 1.
    pub weld_mm: f64,
}

impl From<Option<Unit>> for Options {
    /// Options with this unit that weld only equal vertices.
    fn from(unit: Option<Unit>) -> Self {
        Self { unit, weld_mm: 0.0 }
    }
}

/// A mesh file as a command line names it: `FILE` or `FILE:UNIT`.
#[derive(Clone, Debug, PartialEq)]
pub struct FileInUnit {
    /// The file.
    pub path: PathBuf,
    /// The unit of its coordinates; when absent, as [`Options::unit`] has it.
    pub unit: Option<Unit>,
}

impl From<&OsStr> for FileInUnit {
    fn from(text: &OsStr) -> Self {
        let parts = text.to_str().and_then(|text| text.rsplit_once(':'));
        match parts.and_then(|(path, unit)| Some((path, Unit::named(unit)?))) {
            Some((path, unit)) => Self { path: path.into(), unit: Some(unit) },
            None => Self { path: text.into(), unit: None },
        }
    }
}

/// Permitted welding tolerances, mm. The smallest is about 70 steps of the coordinate grid, below which all tolerances have the same
/// effect. The largest is the size at which a gap is a feature of the part.
const WELD_MM: (f64, f64) = (1e-6, 1.0);

/// What a mesh file held, and the repairs made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportReport {
    /// The format it was read as.
    pub format: Format,
    /// Length of one unit of the file, mm.
    pub unit_mm: f64,
    /// Largest distance at which vertices were merged, mm; 0 when only vertices on the same point of the grid were.
    pub weld_mm: f64,
    /// Triangles in the file; a polygon counts as the triangles that it is divided into.
    pub triangles_read: usize,
    /// Triangles dropped because an earlier one has the same corners.
    pub duplicate: usize,
    /// Triangles dropped because two of their corners were merged.
    pub collapsed: usize,
    /// Vertices of the file's triangles that were merged with an earlier vertex. STL has three vertices per triangle.
    pub welded_vertices: usize,
}

impl fmt::Display for ImportReport {
    /// Formats as one line, such as `OFF in units of 1 mm, 4 triangles`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} in units of {} mm, {} triangles", self.format, self.unit_mm, self.triangles_read)?;
        for (number, what) in [
            (self.welded_vertices, "vertices welded"),
            (self.collapsed, "collapsed triangles dropped"),
            (self.duplicate, "duplicate triangles dropped"),
        ] {
            if number > 0 {
                write!(f, ", {number} {what}")?;
            }
        }
        Ok(())
    }
}

/// A mesh from a file, mm.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The mesh, mm, in the file's frame.
    pub mesh: Mesh,
    /// What the file held, and the repairs made.
    pub report: ImportReport,
}

/// Output of a reader: vertices in the file's unit, and faces with valid indices.
#[derive(Debug, Default)]
struct Raw {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
    /// Length of the unit that the file or its format names, mm.
    unit_mm: Option<f64>,
}

/// Length of the unit of a GLB file, mm.
const METRE: f64 = Unit::M.in_mm();

/// Most triangles of a file, and most vertices that its triangles share. 2^24 of each take 0.6 GiB.
const MOST: usize = 1 << 24;

/// Largest file that is read, bytes. Text has at least 20 bytes per triangle, so vertex indices of any smaller file fit 32 bits.
const LARGEST_FILE: u64 = 1 << 30;

/// Reads a mesh file. The extension decides the format (`.stl`, `.obj`, `.off`, `.ply`, `.glb`, `.3mf`); a file without one of these is
/// recognised by its first bytes. `options` may be just a unit.
///
/// # Errors
/// [`ImportError`] with the file and the line, or the triangle and the byte, when the file cannot be read, is not a
/// mesh, is cut short, disagrees with its own header, or has a coordinate that is not finite or beyond ±4096 mm.
pub fn load(path: &Path, options: impl Into<Options>) -> Result<Imported, ImportError> {
    let content = rs274::file::bytes(path, LARGEST_FILE);
    parse(path, &content.map_err(|cause| ImportError::of_file(path, cause))?, options)
}

/// Like [`load`], from the content of a file; `path` is used for its extension and for messages.
///
/// # Errors
/// As [`load`].
pub fn parse(path: &Path, content: &[u8], options: impl Into<Options>) -> Result<Imported, ImportError> {
    let Options { unit, weld_mm } = options.into();
    parse_in(path, content, unit.map(Unit::in_mm), weld_mm)
}

/// Like [`parse`], with a unit of any length, mm; only corners on the same point of the grid are merged.
///
/// # Errors
/// As [`load`].
pub fn parse_scaled(path: &Path, content: &[u8], unit_mm: f64) -> Result<Imported, ImportError> {
    parse_in(path, content, Some(unit_mm), 0.0)
}

/// What a file that is not read seems to be, by its beginning or its extension, and what converts that. The tutorial has the commands.
fn converter(path: &Path, content: &[u8]) -> &'static str {
    const GMSH: &str = "; STEP, IGES and BREP become STL by `gmsh part.step -2 -clcurv 60 -format stl -bin -o part.stl` (pip install gmsh)";
    const ASSIMP: &str =
        "; Collada, FBX and X3D become STL by `assimp export part.dae part.stl` (apt install assimp-utils)";
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default().to_ascii_lowercase();
    let holds = |words: &[u8]| content[..content.len().min(1024)].windows(words.len()).any(|window| window == words);
    match extension.as_str() {
        _ if holds(b"ISO-10303-21") => GMSH,
        _ if holds(b"<COLLADA") => ASSIMP,
        "step" | "stp" | "iges" | "igs" | "brep" => GMSH,
        "dae" | "fbx" | "x3d" => ASSIMP,
        _ => "",
    }
}

fn parse_in(path: &Path, content: &[u8], unit_mm: Option<f64>, weld_mm: f64) -> Result<Imported, ImportError> {
    let wrong = |message: &str| ImportError::of_file(path, message);
    if weld_mm != 0.0 && !(WELD_MM.0..=WELD_MM.1).contains(&weld_mm) {
        let (least, most) = WELD_MM;
        let allowed = format!("it must be 0, or from {least} to {most}");
        return Err(wrong(&format!("vertices cannot be welded within {weld_mm} mm; {allowed}")));
    }
    if content.len() as u64 >= LARGEST_FILE {
        return Err(wrong(&format!("{} bytes, and at most {LARGEST_FILE} are read", content.len())));
    }
    let content = &*plain(content);
    let Some(format) = format_of(path, content) else {
        let hint = converter(path, content);
        return Err(wrong(&format!("not an STL, OBJ, OFF, PLY, GLB or 3MF file{hint}")));
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
        Format::ThreeMf => Err(wrong("3MF is read by a build with `--features 3mf`; this one was built without")),
    }?;
    let unit_mm = unit_mm.or(raw.unit_mm).unwrap_or(Unit::Mm.in_mm());
    clean::clean(raw, format, unit_mm, weld_mm).map_err(|cause| ImportError::of_file(path, cause))
}

/// The content in the form that the readers expect: text, and the header of a binary PLY file, in UTF-8 without a byte-order mark, with
/// line feeds. Other binary files, recognised by their zero bytes, are unchanged.
fn plain(content: &[u8]) -> Cow<'_, [u8]> {
    let header = ply::binary_header(content);
    if let Some(header) = header.filter(|header| !header.contains(&b'\n')) {
        let text = rs274::file::decode(header.to_vec()).into_bytes();
        return Cow::Owned([&text, &content[header.len()..]].concat());
    }
    let is_marked = content.starts_with(b"\xef\xbb\xbf") || rs274::file::utf16_order(content).is_some();
    let has_returns = || content.contains(&b'\r') && !content.contains(&0);
    if header.is_none() && !stl::has_declared_size(content) && (is_marked || has_returns()) {
        Cow::Owned(rs274::file::decode(content.to_vec()).into_bytes())
    } else {
        Cow::Borrowed(content)
    }
}

/// First bytes of a ZIP archive, and therefore of a 3MF file.
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
