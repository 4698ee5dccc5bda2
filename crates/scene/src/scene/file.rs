//! The TOML form of a scene. It is separate from the model, so that the spelling in files can stay when the model changes.

use super::{Role, Turns};
use crate::geometry::import::Unit;
use crate::geometry::shapes::{Shape, Tessellation};
use crate::machine::file::{Form, LinkFile, PlacementFile};
use rs274::{Axis, Position};
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// `scene.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// One line on what the scene shows.
    pub title: String,
    /// A longer description of what the scene shows.
    #[serde(default)]
    pub description: String,
    /// Source of the geometry and of the motion.
    #[serde(default)]
    pub provenance: String,
    /// The machine.
    #[serde(default)]
    pub machine: MachineFile,
    /// Parts, in addition to those of the machine's file.
    #[serde(default)]
    pub parts: Vec<PartFile>,
    /// The pairs examined; when absent, every two parts that can move relative to each other.
    pub pairs: Option<Vec<Spanned<[String; 2]>>>,
    /// The program that moves the machine.
    pub program: Option<ProgramFile>,
    /// Approaches.
    #[serde(default)]
    pub approaches: Vec<ApproachFile>,
    /// The pairs posed at random; when absent, all examined pairs.
    pub random: Option<Vec<Spanned<[String; 2]>>>,
    /// Recorded poses.
    pub recorded: Option<RecordedFile>,
    /// Settings of `check` for the scene.
    #[serde(default)]
    pub check: CheckFile,
}

/// Settings of `check` for a scene.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CheckFile {
    /// Pairs of parts never examined.
    pub ignore: Vec<Spanned<[String; 2]>>,
    /// Pairs of parts that may touch.
    pub allow: Vec<Spanned<[String; 2]>>,
    /// Permitted depth of the cutter in the workpiece, mm; giving it states that the workpiece is the finished part.
    pub gouge_mm: Option<Spanned<f64>>,
    /// How near pairs may come before it is told, as `--clearance` takes it.
    pub clearance: Vec<Spanned<String>>,
    /// Path of rapid moves.
    pub rapid: RapidFile,
    /// Rapid rate of X, Y, Z, U, V, W, mm/min.
    pub rapid_mm_min: Option<Spanned<f64>>,
    /// Rapid rate of A, B, C, degrees/min.
    pub rapid_deg_min: Option<Spanned<f64>>,
    /// Rapid rates of single axes, by letter, mm/min or degrees/min.
    pub rapid_rates: BTreeMap<String, Spanned<f64>>,
    /// Greatest feed rates of single axes, by letter, mm/min or degrees/min.
    pub feed_limits: BTreeMap<String, Spanned<f64>>,
    /// Collisions that the scene's own program is known to have.
    pub expect: Vec<ExpectFile>,
}

/// Path of rapid moves.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RapidFile {
    /// Straight in axis space.
    #[default]
    Straight,
    /// Every axis at its own rate.
    DogLeg,
}

/// A known collision.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpectFile {
    /// The program's line on which contact begins.
    pub line: u32,
    /// The parts.
    pub pair: Spanned<[String; 2]>,
}

/// The `[machine]` of a scene.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineFile {
    /// A file with `links` and `parts`. Excludes `links` in this table; the file's parts come first.
    pub file: Option<Spanned<String>>,
    /// A URDF file with links and their geometry. Excludes `file` and `links`; the file's parts come first.
    pub urdf: Option<Spanned<String>>,
    /// Axis letters for joints of the URDF file, by the joint's name; joints that are not named here get the next free letters.
    #[serde(default)]
    pub axes: BTreeMap<String, char>,
    /// Which description of the URDF file's links is used: visual or collision.
    #[serde(default)]
    pub form: Form,
    /// Density of the tessellation of the file's shapes; overrides the densities of its parts.
    pub density: Option<f64>,
    /// Links.
    #[serde(default)]
    pub links: Vec<LinkFile>,
    /// Parts.
    #[serde(default)]
    pub parts: Vec<PartFile>,
}

/// A machine's own file, which several scenes may share.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SharedMachineFile {
    /// Links.
    pub links: Vec<LinkFile>,
    /// Parts.
    pub parts: Vec<PartFile>,
}

/// A part. It has either a `shape` or a `mesh`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartFile {
    /// Name, unique in the scene.
    pub name: Spanned<String>,
    /// The link to which the part is fixed; when absent, the world.
    pub link: Option<Spanned<String>>,
    /// The role of the part.
    #[serde(default)]
    pub role: Role,
    /// The tool to which the part belongs: the part is mounted only while that tool is in the spindle.
    pub tool: Option<u32>,
    /// Grooves of a cutter's outline up to this width, along its axis, leave no ridges, mm.
    #[serde(default)]
    pub groove_mm: f64,
    /// What turns the part while a spindle runs.
    pub turns: Option<Turns>,
    /// The part's frame in its link's frame.
    #[serde(default)]
    pub at: PlacementFile,
    /// A parametric shape.
    pub shape: Option<Shape>,
    /// Tessellation of the shape.
    pub tessellation: Option<Tessellation>,
    /// A mesh file.
    pub mesh: Option<String>,
    /// The mesh file's unit.
    pub unit: Option<Unit>,
    /// Distance within which vertices of the mesh file are merged, mm; when absent, only equal vertices are merged.
    pub weld_mm: Option<f64>,
}

/// The program that moves the machine, and its controller.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgramFile {
    /// The G-code file.
    pub file: Spanned<String>,
    /// Other G-code files for the same machine, tools and offsets.
    #[serde(default)]
    pub more: Vec<Spanned<String>>,
    /// The controller's defaults.
    #[serde(default)]
    pub controller: ControllerFile,
    /// The control that the program is written for: `linuxcnc`, `fanuc`, `haas` or `grbl`.
    pub dialect: Option<Spanned<String>>,
    /// The unit of lengths before any G20 or G21: `mm` or `inch`; when absent, mm with a note.
    pub units: Option<Spanned<String>>,
    /// Codes that are skipped, as in `["G187", "M31"]`.
    #[serde(default)]
    pub ignored_codes: Vec<Spanned<String>>,
    /// Largest linear travel between poses, mm.
    pub step_mm: Option<Spanned<f64>>,
    /// Largest rotation between poses, degrees.
    pub step_deg: Option<Spanned<f64>>,
    /// Largest distance of an arc from its chords, mm.
    pub chord_mm: Option<Spanned<f64>>,
    /// Initial position of the machine; when absent, every axis at zero.
    pub start: Option<Spanned<PositionFile>>,
    /// Target of G28; when absent, every axis at zero.
    pub home: Option<Spanned<PositionFile>>,
    /// Target of G30; when absent, every axis at zero, with a note.
    pub second_home: Option<Spanned<PositionFile>>,
    /// Position for tool changes by M6: axis letters, mm and degrees. When absent, tools change at the current position.
    #[serde(default)]
    pub tool_change: BTreeMap<String, Spanned<f64>>,
    /// Origins in machine coordinates of G54 to G59.3, for Fanuc's and Haas's controls also of `G54.1P1` and on, for Haas's of `G154P1` and on.
    #[serde(default)]
    pub work_offsets: BTreeMap<String, Spanned<PositionFile>>,
    /// The tool table.
    #[serde(default)]
    pub tools: Vec<Spanned<ToolFile>>,
    /// The tool in the spindle at the start.
    #[serde(default)]
    pub tool: u32,
    /// The links that carry tool and workpiece, for tool-centre-point control.
    pub tool_centre_point: Option<Spanned<TipFile>>,
    /// Effects of the machine's own M codes: `M428 = "tool-centre-point-on"`.
    #[serde(default)]
    pub user_codes: BTreeMap<String, Spanned<UserCodeFile>>,
}

/// The links that carry tool and workpiece.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipFile {
    /// The link that carries the tool; without it, the world.
    pub tool_link: Option<Spanned<String>>,
    /// Position of the tip of a tool of length zero, in that link's frame.
    #[serde(default)]
    pub gauge_mm: [f64; 3],
    /// Direction from that position towards the tip.
    #[serde(default = "down")]
    pub direction: [f64; 3],
    /// The link that carries the workpiece; without it, the world.
    pub work_link: Option<Spanned<String>>,
}

const fn down() -> [f64; 3] {
    [0.0, 0.0, -1.0]
}

/// The effect of a machine's own M code.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UserCodeFile {
    /// Tool-centre-point control on.
    ToolCentrePointOn,
    /// Off.
    ToolCentrePointOff,
    /// The spindle turns clockwise.
    SpindleOn,
    /// The spindle stands still.
    SpindleOff,
    /// No effect on the axes.
    Ignore,
}

/// A controller's defaults before any G word.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ControllerFile {
    /// G17, G8.
    #[default]
    Mill,
    /// G18; X words are diameters in the dialects `fanuc` and `haas`, in the others from G7 on.
    Lathe,
}

/// An entry of the tool table, with the tool's dimensions.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolFile {
    /// Its number.
    pub number: u32,
    /// Description of the tool for readers.
    #[serde(default)]
    #[expect(dead_code, reason = "for readers of the file")]
    pub name: String,
    /// Offset that G43 adds; when absent, the length of the tool if its dimensions are given, otherwise zero.
    pub offset: Option<PositionFile>,
    /// Cutting diameter, or twice the nose radius, mm.
    #[serde(default)]
    pub diameter_mm: f64,
    /// Orientation of a lathe tool, 1 to 9.
    #[serde(default)]
    pub orientation: u8,
    /// Radius between end and side of the cutter, mm; half the diameter for a ball end.
    pub corner_mm: Option<f64>,
    /// Full angle of a drill's point, degrees.
    pub point_deg: Option<f64>,
    /// Length from the tip to the end of the cutting part, mm.
    pub flute_mm: Option<f64>,
    /// Diameter above the flutes, mm; when absent, the cutting diameter.
    pub shank_mm: Option<f64>,
    /// Length from the tip to the holder, mm.
    pub stickout_mm: Option<f64>,
    /// Length from the tip to the spindle's gauge line, mm: stick-out plus holder.
    pub length_mm: Option<f64>,
    /// The steps of the holder, from the tool's side upwards.
    pub holder: Option<Vec<HolderStepFile>>,
}

/// A step of a tool's holder.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HolderStepFile {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Diameter at its upper end, mm; when absent, the same as `diameter_mm`.
    pub top_mm: Option<f64>,
    /// Length, mm.
    pub length_mm: f64,
}

/// A tool library.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LibraryFile {
    /// The tools.
    pub tools: Vec<Spanned<ToolFile>>,
}

/// Axis positions; absent axes are 0.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PositionFile {
    pub x_mm: f64,
    pub y_mm: f64,
    pub z_mm: f64,
    pub a_deg: f64,
    pub b_deg: f64,
    pub c_deg: f64,
    pub u_mm: f64,
    pub v_mm: f64,
    pub w_mm: f64,
}

impl PositionFile {
    /// The position in mm and radians.
    pub fn position(&self) -> Position {
        let mut position = Position([
            self.x_mm, self.y_mm, self.z_mm, self.a_deg, self.b_deg, self.c_deg, self.u_mm, self.v_mm, self.w_mm,
        ]);
        for axis in Axis::ALL.into_iter().filter(|axis| axis.is_rotary()) {
            position[axis] = position[axis].to_radians();
        }
        position
    }
}

/// An approach of the second part of a pair to the first.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ApproachFile {
    /// Name, unique in the scene.
    pub name: Spanned<String>,
    /// The pair.
    pub pair: Spanned<[String; 2]>,
    /// A machine position on the line of approach.
    pub at: PositionFile,
    /// Direction in which the second part moves relative to the first, world frame; any length but zero.
    pub direction: [f64; 3],
    /// Offsets at which the second part stops, mm before first contact; negative past it.
    pub offsets_mm: Option<Vec<f64>>,
}

/// Recorded poses.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedFile {
    /// The CSV file.
    pub file: Spanned<String>,
}
