//! Scenes: parts with meshes on a machine, the pairs of them that are examined, and what moves them.
//!
//! Reading order: this file (the model), [`file`] (how a scene is written), `load` (from one to the other), `urdf` (machines
//! of ROS), [`recording`]
//! (poses as CSV), `assembly` (rotating tools by their measures), `stock_spec` and [`set_up`] (tools and stock without editing the file),
//! [`extents`] (sizes, and what they say of units), [`template`] (files for new machines), `folder` and `shipped` (where files come from), [`pairs`] (which parts can collide), [`error`].

pub mod error;
mod shipped;
mod folder;
mod file;
pub mod recording;
mod program;
mod load;
mod numbers;
mod assembly;
pub mod extents;
pub mod set_up;
mod stock_spec;
pub mod template;
#[cfg(feature = "urdf")]
mod urdf;
pub mod pairs;

pub use assembly::{Assembly, ToolEntry};
pub use error::{Place, SceneError};
pub use program::{ProgramRun, TipCause, TipFault};
pub use recording::Recording;
pub use stock_spec::StockSpec;

use crate::geometry::import::ImportReport;
use crate::geometry::shapes::Shape;
use crate::geometry::{Isometry, Mesh, Vector};
use crate::machine::{Machine, Poses};
use folder::Folder;
use nalgebra::Unit;
use rs274::{Position, RapidPath};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// A part: a mesh on a link of the machine.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name, unique in the scene.
    pub name: String,
    /// Its mesh, mm, in the part's own frame.
    pub mesh: Arc<Mesh>,
    /// Index of the link it is fixed to; `None` is the world.
    pub link: Option<usize>,
    /// The part's frame in its link's, mm.
    pub link_from_part: Isometry,
    /// The parametric shape that the mesh was made from, where it was.
    pub shape: Option<Arc<Shape>>,
    /// What it is to the work.
    pub role: Role,
    /// The tool that it belongs to: it is there only while that tool is in the spindle. `None` is always there.
    pub tool: Option<u32>,
}

/// What was found in a part's mesh file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    /// The part.
    pub part: String,
    /// The file, relative to the scene's folder.
    pub file: String,
    /// What was found in it and what was done about it.
    pub report: ImportReport,
}

/// What a part is to the work: decides which contact is intended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Neither cuts nor is cut.
    #[default]
    Machine,
    /// Is cut.
    Workpiece,
    /// Cuts: may touch the workpiece in a feed move.
    Cutter,
    /// The smooth part of a tool between cutter and holder; touches nothing.
    Shank,
    /// Holds a tool; touches nothing.
    Holder,
    /// Holds the workpiece; touches nothing that moves against it, unless the scene allows it.
    Fixture,
}

impl Role {
    /// Every role, in the order of their declaration.
    pub const ALL: [Self; 6] = [Self::Machine, Self::Workpiece, Self::Cutter, Self::Shank, Self::Holder, Self::Fixture];

    /// Its name in files.
    #[must_use]
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

/// What `check` needs to know of a scene beside its parts and motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates {
    /// Rapid rate of each axis, mm/min or radians/min.
    pub rapid: [f64; 9],
    /// Greatest feed rate of each axis, mm/min or radians/min; infinite where the scene names none.
    pub feed: [f64; 9],
    /// How rapid moves go.
    pub rapid_path: RapidPath,
}

/// A collision that a scene's program is known to have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expected {
    /// Line on which contact begins.
    pub line: u32,
    /// The parts.
    pub pair: Pair,
}

/// Two parts that may collide, as indices into [`Scene::parts`]. `a` is the one whose frame the poses are given in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pair {
    /// The part whose frame poses are given in.
    pub a: usize,
    /// The other part.
    pub b: usize,
}

impl Pair {
    /// Whether both are the same two parts, in whatever order.
    #[must_use]
    pub fn is(self, other: Self) -> bool {
        self == other || self == Self { a: other.b, b: other.a }
    }
}

/// A straight line along which a pair's part `b` comes to part `a`.
#[derive(Clone, Debug)]
pub struct Approach {
    /// Name, unique in the scene.
    pub name: String,
    /// The pair.
    pub pair: Pair,
    /// A position of the machine on the line, mm and radians.
    pub at: Position,
    /// The way `b` goes relative to `a`, world frame.
    pub direction: Unit<Vector>,
    /// Where to stop, mm before first contact; negative is past it.
    pub offsets_mm: Vec<f64>,
}

impl Approach {
    /// Where an approach stops when the scene does not say: every depth band, every stratum, and contact itself.
    pub const OFFSETS_MM: [f64; 15] =
        [-8.0, -3.0, -0.5, -0.05, -5e-3, -5e-4, -1e-5, 0.0, 1e-3, 0.5, 3.0, 8.0, 20.0, 50.0, 100.0];
}

/// A scene, loaded and checked.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name: the folder's.
    pub name: String,
    /// One line on what it shows.
    pub title: String,
    /// What it shows, at length.
    pub description: String,
    /// Where geometry and motion come from.
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
    /// Pairs that may touch: never a collision.
    pub allowed: Vec<Pair>,
    /// How deep the cutter may go into the workpiece, which is then the finished part, mm; `None` where it is uncut.
    pub gouge_mm: Option<f64>,
    /// How fast the machine's rapid moves are.
    pub rates: Rates,
    /// Collisions that the program is known to have.
    pub expected: Vec<Expected>,
    /// The program that moves the machine.
    pub program: Option<ProgramRun>,
    /// Other programs under the same controller, timed as wholes beside the first.
    pub more_programs: Vec<ProgramRun>,
    /// The approaches.
    pub approaches: Vec<Approach>,
    /// The pairs posed at random.
    pub random: Vec<Pair>,
    /// Recorded poses.
    pub recording: Option<Recording>,
    /// What was found in mesh files, by part.
    pub mesh_files: Vec<MeshFile>,
    /// Path or name to content hash of everything the scene was made from.
    pub inputs: BTreeMap<String, String>,
}

/// What a caller may change about a scene while it is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Overrides {
    /// How unevenly shapes are triangulated, instead of what each part says.
    pub grading: Option<f64>,
    /// How finely shapes are triangulated, instead of what each part says.
    pub density: Option<f64>,
    /// Whether the scene's own program stays unread: another one runs under its setup.
    pub skips_program: bool,
}

impl Scene {
    /// Names of the machines that are compiled into the program.
    pub const SHIPPED: &'static [&'static str] = shipped::NAMES;

    /// Names of those that a run examines unless it is told otherwise: two after the paper's, and a mill with five axes.
    pub const BY_DEFAULT: &'static [&'static str] = shipped::BY_DEFAULT;

    /// Names of the shipped scenes that belong to a family: one shape, triangulated in several ways.
    pub const FAMILIES: &'static [&'static str] = shipped::FAMILIES;

    /// Loads a scene from a folder, or from a scene file in one.
    ///
    /// # Errors
    /// [`SceneError`] with file, line and column of the first thing wrong.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Self::load_with(path, &Overrides::default())
    }

    /// As [`Scene::load`], with shapes triangulated otherwise.
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

    /// Loads a scene from files that are only in memory, by their paths relative to the scene's folder; one is `scene.toml`.
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

    /// Loads a scene by path, or a shipped one by name. A folder that holds a `scene.toml` goes before a shipped name.
    ///
    /// # Errors
    /// As [`Scene::load`]; [`SceneError::Missing`] lists the shipped scenes.
    pub fn find(name_or_path: &str) -> Result<Self, SceneError> {
        Self::find_with(name_or_path, &Overrides::default())
    }

    /// As [`Scene::find`], with shapes triangulated otherwise.
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

    /// `a:b`, the name of a pair in files.
    #[must_use]
    pub fn pair_name(&self, pair: Pair) -> String {
        format!("{}:{}", self.parts[pair.a].name, self.parts[pair.b].name)
    }

    /// Whether the scene itself names a pair for examination.
    #[must_use]
    pub fn names(&self, pair: Pair) -> bool {
        self.names_pairs && self.pairs.iter().any(|named| named.is(pair))
    }

    /// Whether a pair is a cutter and the workpiece, whose contact in a feed move is intended.
    #[must_use]
    pub fn is_cutting(&self, pair: Pair) -> bool {
        let roles = [pair.a, pair.b].map(|part| self.parts[part].role);
        roles == [Role::Cutter, Role::Workpiece] || roles == [Role::Workpiece, Role::Cutter]
    }

    /// Index of the part with a name.
    #[must_use]
    pub fn part(&self, name: &str) -> Option<usize> {
        self.parts.iter().position(|part| part.name == name)
    }

    /// Whether anything is mounted only while its tool is in the spindle.
    #[must_use]
    pub fn changes_tools(&self) -> bool {
        self.parts.iter().any(|part| part.tool.is_some())
    }

    /// Whether both parts of a pair are there while `tool` is in the spindle.
    #[must_use]
    pub fn is_mounted(&self, pair: Pair, tool: u32) -> bool {
        [pair.a, pair.b].iter().all(|&part| self.parts[part].tool.is_none_or(|own| own == tool))
    }

    /// The tool without which a pair is not there; `None` where it always is. Of parts of different tools, which are never a
    /// pair, the first part's.
    #[must_use]
    pub fn tool_of(&self, pair: Pair) -> Option<u32> {
        self.parts[pair.a].tool.or(self.parts[pair.b].tool)
    }

    /// `world_from_part` when the links are at `poses`.
    #[must_use]
    pub fn world_from_part(&self, part: usize, poses: &Poses) -> Isometry {
        let Part { link, link_from_part, .. } = &self.parts[part];
        poses.world_from(*link) * link_from_part
    }

    /// Part `b` of a pair in the frame of part `a` when the links are at `poses`.
    #[must_use]
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
