//! The TOML form of a scene. Apart from the model, so that the file's spelling can stay when the model changes.

use super::Role;
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
    /// One line on what it shows.
    pub title: String,
    /// What it shows, at length.
    #[serde(default)]
    pub description: String,
    /// Where the geometry and the motion come from.
    #[serde(default)]
    pub provenance: String,
    /// The machine.
    #[serde(default)]
    pub machine: MachineFile,
    /// Parts, after those of the machine's file.
    #[serde(default)]
    pub parts: Vec<PartFile>,
    /// The pairs examined; without it, every two parts that can move against each other.
    pub pairs: Option<Vec<Spanned<[String; 2]>>>,
    /// What moves the machine.
    pub program: Option<ProgramFile>,
    /// Approaches.
    #[serde(default)]
    pub approaches: Vec<ApproachFile>,
    /// The pairs posed at random; without it, all pairs examined.
    pub random: Option<Vec<Spanned<[String; 2]>>>,
    /// Recorded poses.
    pub recorded: Option<RecordedFile>,
    /// How `check` treats the scene.
    #[serde(default)]
    pub check: CheckFile,
}

/// How `check` treats a scene.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CheckFile {
    /// Pairs of parts never examined.
    pub ignore: Vec<Spanned<[String; 2]>>,
    /// Pairs of parts that may touch.
    pub allow: Vec<Spanned<[String; 2]>>,
    /// How deep the cutter may go into the workpiece, mm: says that the workpiece is the finished part.
    pub gouge_mm: Option<Spanned<f64>>,
    /// How rapid moves go.
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

/// How rapid moves go.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RapidFile {
    /// Straight in axis space.
    #[default]
    Straight,
    /// Every axis at its own rate.
    DogLeg,
}

/// A collision that is known.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpectFile {
    /// The program's line on which contact begins.
    pub line: u32,
    /// The parts.
    pub pair: Spanned<[String; 2]>,
}

/// The `[machine]` of a scene, or a file of its own, which has the same keys but `file` and `density`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineFile {
    /// A file with `links` and `parts`. Excludes `links` here; its parts come first.
    pub file: Option<String>,
    /// A URDF file with links and what they look like. Excludes `file` and `links`; its parts come first.
    pub urdf: Option<String>,
    /// Letters of axes for joints of the URDF file, by the joint's name; joints not named here get the next free ones.
    #[serde(default)]
    pub axes: BTreeMap<String, char>,
    /// Which of the two descriptions of the URDF file's links is taken.
    #[serde(default)]
    pub form: Form,
    /// How finely the shapes of that file are triangulated, instead of what its parts say.
    pub density: Option<f64>,
    /// Links.
    #[serde(default)]
    pub links: Vec<LinkFile>,
    /// Parts.
    #[serde(default)]
    pub parts: Vec<PartFile>,
}

/// A part. Either `shape` or `mesh`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartFile {
    /// Name, unique in the scene.
    pub name: Spanned<String>,
    /// The link it is fixed to; without it, the world.
    pub link: Option<Spanned<String>>,
    /// What it is to the work.
    #[serde(default)]
    pub role: Role,
    /// The tool that it belongs to: mounted only while that tool is in the spindle.
    pub tool: Option<u32>,
    /// Its frame in its link's.
    #[serde(default)]
    pub at: PlacementFile,
    /// A parametric shape.
    pub shape: Option<Shape>,
    /// How the shape becomes triangles.
    pub tessellation: Option<Tessellation>,
    /// A mesh file.
    pub mesh: Option<String>,
    /// The mesh file's unit.
    pub unit: Option<Unit>,
    /// How far apart vertices of the mesh file may be to become one, mm; without it, they must be equal.
    pub weld_mm: Option<f64>,
}

/// What moves the machine.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgramFile {
    /// The G-code file.
    pub file: Spanned<String>,
    /// Other G-code files for the same machine, tool and offsets.
    #[serde(default)]
    pub more: Vec<String>,
    /// What the controller takes for granted.
    #[serde(default)]
    pub controller: ControllerFile,
    /// The control that the program is written for: `linuxcnc`, `fanuc`, `haas` or `grbl`.
    pub dialect: Option<Spanned<String>>,
    /// Codes that are skipped, as in `["G187", "M31"]`.
    #[serde(default)]
    pub ignored_codes: Vec<Spanned<String>>,
    /// Greatest linear travel between poses, mm.
    pub step_mm: Option<Spanned<f64>>,
    /// Greatest turn between poses, degrees.
    pub step_deg: Option<Spanned<f64>>,
    /// Greatest distance of an arc from its chords, mm.
    pub chord_mm: Option<Spanned<f64>>,
    /// Where the machine stands at first; without it, every axis at zero.
    pub start: Option<Spanned<PositionFile>>,
    /// Where G28 goes; without it, every axis at zero.
    pub home: Option<Spanned<PositionFile>>,
    /// Where G30 goes; without it, every axis at zero.
    pub second_home: Option<Spanned<PositionFile>>,
    /// Where M6 changes tools: letters of axes, mm and degrees. Without it, tools change where the machine stands.
    #[serde(default)]
    pub tool_change: BTreeMap<String, Spanned<f64>>,
    /// Origins of G54 to G59.3 in machine coordinates.
    #[serde(default)]
    pub work_offsets: BTreeMap<String, Spanned<PositionFile>>,
    /// The tool table.
    #[serde(default)]
    pub tools: Vec<Spanned<ToolFile>>,
    /// The tool in the spindle at first.
    #[serde(default)]
    pub tool: u32,
    /// Which links carry tool and workpiece, for tool-centre-point control.
    pub tool_centre_point: Option<Spanned<TipFile>>,
    /// What the machine's own M codes do: `M428 = "tool-centre-point-on"`.
    #[serde(default)]
    pub user_codes: BTreeMap<String, Spanned<UserCodeFile>>,
}

/// Which links carry tool and workpiece.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipFile {
    /// The link that carries the tool; without it, the world.
    pub tool_link: Option<Spanned<String>>,
    /// Where a tool of no length has its tip, in that link's frame.
    #[serde(default)]
    pub gauge_mm: [f64; 3],
    /// From there towards the tip.
    #[serde(default = "down")]
    pub direction: [f64; 3],
    /// The link that carries the workpiece; without it, the world.
    pub work_link: Option<Spanned<String>>,
}

const fn down() -> [f64; 3] {
    [0.0, 0.0, -1.0]
}

/// What an M code of the machine's own does.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UserCodeFile {
    /// Tool-centre-point control on.
    ToolCentrePointOn,
    /// Off.
    ToolCentrePointOff,
    /// Nothing that moves an axis.
    Ignore,
}

/// What a controller takes for granted before any G word.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ControllerFile {
    /// G17, G8.
    #[default]
    Mill,
    /// G18, G7.
    Lathe,
}

/// An entry of the tool table, and what the tool looks like.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolFile {
    /// Its number.
    pub number: u32,
    /// What it is, for readers.
    #[serde(default)]
    #[expect(dead_code, reason = "for readers of the file")]
    pub name: String,
    /// What G43 adds; without it, zero, or the length of the tool where its shape is given.
    pub offset: Option<PositionFile>,
    /// Cutting diameter, or twice the nose radius, mm.
    #[serde(default)]
    pub diameter_mm: f64,
    /// Which way a lathe tool points, 1 to 9.
    #[serde(default)]
    pub orientation: u8,
    /// Radius between end and side of the cutter, mm; half the diameter for a ball.
    pub corner_mm: Option<f64>,
    /// Full angle of a drill's point, degrees.
    pub point_deg: Option<f64>,
    /// From the tip to the end of what cuts, mm.
    pub flute_mm: Option<f64>,
    /// Diameter above the flutes, mm; without it, the cutting diameter.
    pub shank_mm: Option<f64>,
    /// From the tip to the holder, mm.
    pub stickout_mm: Option<f64>,
    /// From the tip to the spindle's gauge line, mm: stick-out and holder.
    pub length_mm: Option<f64>,
    /// The holder's steps from the tool's side up.
    pub holder: Option<Vec<HolderStepFile>>,
}

/// A step of a tool's holder.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HolderStepFile {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Diameter at its upper end, mm; without it, the same.
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

/// Axis positions; those not given are 0.
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
    /// In mm and radians.
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

/// An approach of a pair's second part to its first.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ApproachFile {
    /// Name, unique in the scene.
    pub name: Spanned<String>,
    /// The pair.
    pub pair: Spanned<[String; 2]>,
    /// Where the machine stands: the line of approach runs through this position.
    pub at: PositionFile,
    /// The way the second part goes relative to the first, world frame, any length but zero.
    pub direction: [f64; 3],
    /// Where to stop, mm before first contact; negative is past it.
    pub offsets_mm: Option<Vec<f64>>,
}

/// Recorded poses.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedFile {
    /// The CSV file.
    pub file: String,
}
