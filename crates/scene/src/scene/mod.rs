//! Scenes: parts with meshes on a machine, the pairs of parts that are examined, and the motion.
//!
//! Reading order: this file (the model), [`file`] (the TOML form), `load` (from TOML to model), `parts` (which are taken), `urdf` (machines of ROS), [`recording`]
//! (poses as CSV), `assembly` (rotating tools by their dimensions), `stock_spec` and [`set_up`] (tools and stock without editing the file),
//! [`extents`] (sizes, and warnings about units), [`template`] (files for new machines), `folder` and `shipped` (sources of files),
//! [`pairs`] (which parts can collide), [`error`].

pub mod error;
mod shipped;
mod folder;
mod file;
pub mod recording;
mod program;
mod load;
mod parts;
mod numbers;
mod assembly;
mod clearances;
pub mod extents;
pub mod set_up;
mod stock_spec;
pub mod template;
#[cfg(feature = "urdf")]
mod urdf;
pub mod pairs;

pub use assembly::{Assembly, DrawnTool, ToolEntry};
pub use clearances::{Clearance, Clearances};
pub use error::{Place, SceneError};
pub use program::{ProgramRun, TipCause, TipFault};
pub use recording::Recording;
pub use stock_spec::StockSpec;

use crate::geometry::import::ImportReport;
use crate::geometry::shapes::Shape;
use crate::geometry::{Isometry, Mesh, Vector};
use crate::machine::{Machine, Poses};
use folder::Folder;
pub use folder::LARGEST_FILE;
use nalgebra::Unit;
use rs274::{Position, RapidPath, Tool};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A part: a mesh on a link of the machine.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name, unique in the scene.
    pub name: String,
    /// Mesh of the part, mm, in the part's own frame.
    pub mesh: Arc<Mesh>,
    /// Index of the link it is fixed to; `None` is the world.
    pub link: Option<usize>,
    /// The part's frame in its link's frame, mm.
    pub link_from_part: Isometry,
    /// The parametric shape from which the mesh was made; `None` for a mesh file.
    pub shape: Option<Arc<Shape>>,
    /// The role of the part.
    pub role: Role,
    /// The tool to which the part belongs: the part is present only while that tool is in the spindle. `None` is always present.
    pub tool: Option<u32>,
    /// Grooves of a cutter's outline up to this width, along its axis, are staggered from tooth to tooth and leave no ridges, mm.
    pub groove_mm: f64,
    /// What turns the part while a spindle runs; `None` where the scene does not say.
    pub turns: Option<Turns>,
}

/// What turns a part while a spindle runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Turns {
    /// A drive about the part's own axis: a drill of a bank, the cutter of an angle head, a driven tool.
    Own,
    /// The spindle: of a tool's part the one that holds the tool, of all others the one of a lathe.
    Spindle,
    /// Nothing.
    #[serde(rename = "none")]
    Nothing,
}

impl Turns {
    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Spindle => "spindle",
            Self::Nothing => "none",
        }
    }
}

/// The import report of a part's mesh file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// The part.
    pub part: String,
    /// The file, relative to the scene's folder.
    pub file: String,
    /// Contents of the file, and the repairs made.
    pub report: ImportReport,
}

/// The role of a part in machining; it decides which contacts are intended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Neither cuts nor is cut.
    #[default]
    Machine,
    /// Is cut.
    Workpiece,
    /// Cuts, and may touch the workpiece in a feed move.
    Cutter,
    /// The smooth part of a tool between cutter and holder; must touch nothing.
    Shank,
    /// Holds a tool; must touch nothing.
    Holder,
    /// Holds the workpiece; must touch nothing that moves relative to it, unless the scene allows it.
    Fixture,
}

impl Role {
    /// Every role, in the order of their declaration.
    pub const ALL: [Self; 6] = [Self::Machine, Self::Workpiece, Self::Cutter, Self::Shank, Self::Holder, Self::Fixture];

    /// Whether a part of the role belongs to a tool.
    pub const fn is_of_tool(self) -> bool {
        matches!(self, Self::Cutter | Self::Shank | Self::Holder)
    }

    /// Name of the role in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Machine => "machine",
            Self::Workpiece => "workpiece",
            Self::Cutter => "cutter",
            Self::Shank => "shank",
            Self::Holder => "holder",
            Self::Fixture => "fixture",
        }
    }
}

/// Rates of the machine's axes, which `check` needs in addition to parts and motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates {
    /// Rapid rate of each axis, mm/min or radians/min.
    pub rapid: [f64; 9],
    /// Largest feed rate of each axis, mm/min or radians/min; infinite when the scene gives none.
    pub feed: [f64; 9],
    /// Path of rapid moves.
    pub rapid_path: RapidPath,
}

/// A known collision of a scene's program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Line on which contact begins.
    pub line: u32,
    /// The parts.
    pub pair: Pair,
}

/// Two parts that may collide, as indices into [`Scene::parts`]. Poses are given in the frame of `a`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pair {
    /// The part in whose frame poses are given.
    pub a: usize,
    /// The other part.
    pub b: usize,
}

impl Pair {
    /// Whether both pairs are the same two parts, in either order.
    pub fn is(self, other: Self) -> bool {
        self == other || self == Self { a: other.b, b: other.a }
    }

    /// The part that is not `part`.
    pub const fn other(self, part: usize) -> usize {
        if self.a == part { self.b } else { self.a }
    }
}

/// A straight line along which part `b` of a pair approaches part `a`.
#[derive(Clone, Debug)]
pub struct Approach {
    /// Name, unique in the scene.
    pub name: String,
    /// The pair.
    pub pair: Pair,
    /// A position of the machine on the line, mm and radians.
    pub at: Position,
    /// Direction in which `b` moves relative to `a`, world frame.
    pub direction: Unit<Vector>,
    /// Offsets at which `b` stops, mm before first contact; negative past it.
    pub offsets_mm: Vec<f64>,
}

impl Approach {
    /// Offsets of an approach when the scene gives none: every depth band, every stratum, and contact itself.
    pub const OFFSETS_MM: [f64; 15] =
        [-8.0, -3.0, -0.5, -0.05, -5e-3, -5e-4, -1e-5, 0.0, 1e-3, 0.5, 3.0, 8.0, 20.0, 50.0, 100.0];
}

/// A scene, loaded and checked.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name of the scene, which is the name of its folder.
    pub name: String,
    /// One line on what the scene shows.
    pub title: String,
    /// A longer description of what the scene shows.
    pub description: String,
    /// Source of the geometry and of the motion.
    pub provenance: String,
    /// The machine; without links when the scene has none.
    pub machine: Machine,
    /// The parts.
    pub parts: Vec<Part>,
    /// The pairs examined.
    pub pairs: Vec<Pair>,
    /// Whether the scene names [`Scene::pairs`] itself.
    pub names_pairs: bool,
    /// Pairs that `check` never examines.
    pub ignored: Vec<Pair>,
    /// Pairs whose contact is never a collision.
    pub allowed: Vec<Pair>,
    /// Permitted depth of the cutter in the workpiece, mm; the workpiece is then the finished part. `None` when the workpiece is uncut.
    pub gouge_mm: Option<f64>,
    /// How near pairs may come before `check` tells of it.
    pub clearances: Clearances,
    /// Rapid rates and feed limits of the machine.
    pub rates: Rates,
    /// Collisions that the program is known to have.
    pub expected: Vec<Expected>,
    /// The program that moves the machine.
    pub program: Option<ProgramRun>,
    /// Other programs under the same controller; each is timed as a whole.
    pub more_programs: Vec<ProgramRun>,
    /// The approaches.
    pub approaches: Vec<Approach>,
    /// The pairs posed at random.
    pub random: Vec<Pair>,
    /// Recorded poses.
    pub recording: Option<Recording>,
    /// The tools drawn by their dimensions.
    pub drawn_tools: Vec<DrawnTool>,
    /// Whether a job has put a tool without a shape in the place of one with parts.
    pub lost_tools: bool,
    /// Import reports of the mesh files, by part.
    pub mesh_files: Vec<MeshFile>,
    /// Content hash of every input of the scene, by path or name.
    pub inputs: BTreeMap<String, String>,
    /// Real path of every file of the scene that was read from disk, with those of subroutines.
    pub files: Vec<PathBuf>,
}

/// Changes that a caller may make to a scene while it is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Grading of the tessellation of all shapes; overrides the grading of each part.
    pub grading: Option<f64>,
    /// Density of the tessellation of all shapes; overrides the density of each part.
    pub density: Option<f64>,
    /// Whether the scene's own program is not read, because another program will run under its setup.
    pub skips_program: bool,
    /// Whether the scene's own program is read but not run, because it will run under another setup ([`ProgramRun::again`]); those of `more` are then
    /// not read.
    pub defers_program: bool,
}

impl Scene {
    /// Names of the scenes that are compiled into the program.
    pub const SHIPPED: &'static [&'static str] = shipped::NAMES;

    /// Names of the scenes that a run examines by default: two modelled on the paper's, and a mill with five axes.
    pub const BY_DEFAULT: &'static [&'static str] = shipped::BY_DEFAULT;

    /// Names of the shipped scenes that belong to a family: one shape in several tessellations.
    pub const FAMILIES: &'static [&'static str] = shipped::FAMILIES;

    /// Loads a scene from a folder, or from a scene file in one.
    ///
    /// # Errors
    /// [`SceneError`] with file, line and column of the first thing wrong.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Self::load_with(path, &Overrides::default())
    }

    /// As [`Scene::load`], with `overrides`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_with(path: &Path, overrides: &Overrides) -> Result<Self, SceneError> {
        if path.is_file() {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            let file = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            load::load(Folder::on_disk(folder), &file, overrides)
        } else if path.join(load::SCENE_FILE).is_file() {
            load::load(Folder::on_disk(path), load::SCENE_FILE, overrides)
        } else {
            Err(missing(&path.display().to_string()))
        }
    }

    /// Loads a scene from files in memory, given by their paths relative to the scene's folder; one of them is `scene.toml`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_memory(
        name: &str,
        files: BTreeMap<String, Vec<u8>>,
        overrides: &Overrides,
    ) -> Result<Self, SceneError> {
        load::load(Folder::in_memory(name, files), load::SCENE_FILE, overrides)
    }

    /// Loads a scene by path, or a shipped scene by name. A folder with a `scene.toml` takes precedence over a shipped scene of the same
    /// name.
    ///
    /// # Errors
    /// As [`Scene::load`]; [`SceneError::Missing`] lists the shipped scenes.
    pub fn find(name_or_path: &str) -> Result<Self, SceneError> {
        Self::find_with(name_or_path, &Overrides::default())
    }

    /// As [`Scene::find`], with `overrides`.
    ///
    /// # Errors
    /// As [`Scene::find`].
    pub fn find_with(name_or_path: &str, overrides: &Overrides) -> Result<Self, SceneError> {
        let path = Path::new(name_or_path);
        if path.is_file() || path.join(load::SCENE_FILE).is_file() {
            return Self::load_with(path, overrides);
        }
        if Self::SHIPPED.contains(&name_or_path) || Self::FAMILIES.contains(&name_or_path) {
            return load::load(Folder::shipped(name_or_path), load::SCENE_FILE, overrides);
        }
        Err(missing(name_or_path))
    }

    /// Warnings about the drawn tools under a tool table, one line each: an offset or a diameter that differs from the drawn tool, a missing holder.
    pub fn tool_notes(&self, table: &BTreeMap<u32, Tool>) -> Vec<String> {
        self.drawn_tools.iter().flat_map(|drawn| drawn.notes(table)).collect()
    }

    /// The name of a pair in files, as `a:b`.
    pub fn pair_name(&self, pair: Pair) -> String {
        format!("{}:{}", self.parts[pair.a].name, self.parts[pair.b].name)
    }

    /// Whether the scene itself names a pair for examination.
    pub fn names(&self, pair: Pair) -> bool {
        self.names_pairs && self.pairs.iter().any(|named| named.is(pair))
    }

    /// Whether a pair is a cutter and the workpiece, whose contact in a feed move is intended.
    pub fn is_cutting(&self, pair: Pair) -> bool {
        let roles = [pair.a, pair.b].map(|part| self.parts[part].role);
        roles == [Role::Cutter, Role::Workpiece] || roles == [Role::Workpiece, Role::Cutter]
    }

    /// Index of the part with a name.
    pub fn part(&self, name: &str) -> Option<usize> {
        self.parts.iter().position(|part| part.name == name)
    }

    /// Whether some part is mounted only while its tool is in the spindle, or was before a job replaced it by a tool without a shape.
    pub fn changes_tools(&self) -> bool {
        self.lost_tools || self.parts.iter().any(|part| part.tool.is_some())
    }

    /// Whether both parts of a pair are mounted while `tool` is in the spindle.
    pub fn is_mounted(&self, pair: Pair, tool: u32) -> bool {
        [pair.a, pair.b].iter().all(|&part| self.parts[part].tool.is_none_or(|own| own == tool))
    }

    /// The tool that must be in the spindle for a pair to be mounted; `None` when the pair is always mounted. For parts of different tools,
    /// which never form a pair, the tool of the first part.
    pub fn tool_of(&self, pair: Pair) -> Option<u32> {
        self.parts[pair.a].tool.or(self.parts[pair.b].tool)
    }

    /// `world_from_part` when the links are at `poses`.
    pub fn world_from_part(&self, part: usize, poses: &Poses) -> Isometry {
        let Part { link, link_from_part, .. } = &self.parts[part];
        poses.world_from(*link) * link_from_part
    }

    /// Part `b` of a pair in the frame of part `a` when the links are at `poses`.
    pub fn a_from_b(&self, pair: Pair, poses: &Poses) -> Isometry {
        self.world_from_part(pair.a, poses).inv_mul(&self.world_from_part(pair.b, poses))
    }
}

fn missing(wanted: &str) -> SceneError {
    if Path::new(wanted).is_dir() {
        return SceneError::NoSceneFile { folder: wanted.into() };
    }
    SceneError::Missing { wanted: wanted.to_owned(), known: [Scene::SHIPPED, Scene::FAMILIES].concat().join(", ") }
}
