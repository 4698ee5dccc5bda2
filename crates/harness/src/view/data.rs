//! What a page gets: the wire format `bvbench-view/2`, JSON with arrays as base64 (docs/view.md).

use super::motion::Motion;
use super::pack::{Lattice, Packed};
use super::tool_path::ToolPath;
use crate::geometry::{Isometry, Mesh};
use crate::machine::joint::Motion as JointMotion;
use crate::picture::Up;
use crate::scene::{Part, ProgramRun, Scene};
use rs274::{Axis, MoveKind};
use serde::Serialize;

/// Everything that a page shows.
#[derive(Clone, Debug, Serialize)]
pub struct ViewData {
    format: &'static str,
    name: String,
    pub(super) title: String,
    description: String,
    provenance: String,
    up: char,
    links: Vec<LinkData>,
    parts: Vec<PartData>,
    program: Option<ProgramData>,
    path: Option<ToolPath>,
    pub(super) events: Vec<EventData>,
    pub(super) faults: Vec<FaultData>,
    /// What `check` says nothing about, a line each.
    pub(super) notes: Vec<String>,
    pub(super) distances: Distances,
    pub(super) variants: Vec<DrawnVariant>,
}

/// A link: where it stands on its parent, and how it moves there.
#[derive(Clone, Debug, Serialize)]
struct LinkData {
    name: String,
    /// Its number in `links`; `None` is the world.
    parent: Option<usize>,
    /// x, y, z in mm, then a unit quaternion i, j, k, w.
    at: [f64; 7],
    joint: Option<JointData>,
}

#[derive(Clone, Debug, Serialize)]
struct JointData {
    axis: usize,
    turns: bool,
    direction: [f64; 3],
    point: [f64; 3],
    /// mm or radians per unit of the axis.
    gain: f64,
    /// `None` where there is no limit.
    min: Option<f64>,
    max: Option<f64>,
}

/// A part: its mesh on a lattice.
#[derive(Clone, Debug, Serialize)]
struct PartData {
    name: String,
    role: &'static str,
    tool: Option<u32>,
    link: Option<usize>,
    at: [f64; 7],
    /// Whether some pair with it is examined.
    examined: bool,
    low: [f64; 3],
    step: [f64; 3],
    /// 16 bits, three per vertex.
    vertices: Packed,
    /// Three per triangle, of 16 bits up to 65 536 vertices, else of 32.
    faces: Packed,
    wide: bool,
}

/// The program: its text, its moves and the keys between which axes are linear in time.
#[derive(Clone, Debug, Serialize)]
struct ProgramData {
    file: String,
    lines: Vec<String>,
    duration_s: f64,
    first_tool: u32,
    /// Axes with a value in `values`, by number (X, Y, Z, A, B, C, U, V, W).
    axes: Vec<usize>,
    keys: usize,
    /// Time from the key before, s; 32 bits.
    durations: Packed,
    /// Key by key the axes' values, mm and radians, 32 bits.
    values: Packed,
    moves: Moves,
}

/// One number per move.
#[derive(Clone, Debug, Serialize)]
struct Moves {
    line: Packed,
    /// 0 rapid, 1 feed, 2 arc, 3 dwell, 4 tool change.
    kind: Packed,
    /// mm/min; 0 for none.
    feed: Packed,
    /// 32 bits.
    tool: Packed,
    rpm: Packed,
    last_key: Packed,
}

/// An event of `check`; places are in keys.
#[derive(Clone, Debug, Serialize)]
pub(super) struct EventData {
    pub kind: &'static str,
    pub zone_mm: Option<f64>,
    pub pair: [usize; 2],
    pub first: f64,
    pub last: f64,
    pub nearest: f64,
    pub line: u32,
    pub last_line: u32,
    pub time_s: f64,
    pub least_mm: f64,
    pub inside: bool,
    pub to_the_end: bool,
    pub contacts: Vec<Contact>,
}

/// What makes a check fail and is of no pair; places are in keys.
#[derive(Clone, Debug, Serialize)]
pub(super) struct FaultData {
    /// `over-travel` or `tool-without-part`.
    pub kind: &'static str,
    pub line: u32,
    pub first: f64,
    pub last: f64,
    pub text: String,
}

/// The triangles of a collision at one key, in the frame of its first part.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Contact {
    pub key: f64,
    /// How many pairs of triangles touch.
    pub pairs: usize,
    pub a: Packed,
    pub b: Packed,
    pub at: Option<[f64; 3]>,
    /// Six numbers of 32 bits per line, mm.
    pub lines: Packed,
}

/// The nearest pair along the path.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Distances {
    pub pairs: Vec<[usize; 2]>,
    pub farthest_mm: f64,
    pub keys: Packed,
    pub mm: Packed,
    /// Number in `pairs`, of 32 bits; 4294967295 for none.
    pub nearest: Packed,
}

/// The trees of one variant.
#[derive(Clone, Debug, Serialize)]
pub(super) struct DrawnVariant {
    pub id: &'static str,
    pub label: &'static str,
    pub safe: bool,
    pub trees: Vec<DrawnTree>,
}

/// The upper levels of a part's tree, in the part's frame.
#[derive(Clone, Debug, Serialize)]
pub(super) struct DrawnTree {
    pub part: usize,
    pub levels: Vec<Level>,
    pub low: [f64; 3],
    pub step: [f64; 3],
    /// A byte per node.
    pub level_of: Packed,
    /// 1 for a leaf, 2 where corners of its triangles are outside.
    pub flags: Packed,
    pub shapes: Shapes,
}

/// Sums over the nodes that cover the mesh on one level: its own nodes, and the leaves above it.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Level {
    pub nodes: u32,
    pub volume_mm3: f64,
    /// Nodes with a corner outside.
    pub leaking: u32,
    /// Corners outside.
    pub outside: u32,
}

/// The volumes themselves.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub(super) enum Shapes {
    /// Each node an affine image of one shape: four points, of which the weights give all others.
    Images { weights: Packed, edges: Packed, faces: Packed, frames: Packed },
    /// Each node by itself: counts of points, edges and faces, then all of them.
    Own { counts: Packed, points: Packed, edges: Packed, faces: Packed },
}

/// x, y, z, then the unit quaternion i, j, k, w.
fn seven(isometry: &Isometry) -> [f64; 7] {
    let (at, q) = (isometry.translation.vector, isometry.rotation.coords);
    [at.x, at.y, at.z, q.x, q.y, q.z, q.w]
}

impl ViewData {
    /// The scene without motion.
    pub(super) fn of_scene(scene: &Scene, up: Up) -> Self {
        let links = scene.machine.links().iter().enumerate();
        let examined =
            |part: usize| scene.names_pairs && scene.pairs.iter().any(|pair| pair.a == part || pair.b == part);
        Self {
            format: "bvbench-view/2",
            name: scene.name.clone(),
            title: scene.title.clone(),
            description: scene.description.clone(),
            provenance: scene.provenance.clone(),
            up: match up {
                Up::Y => 'y',
                Up::Z => 'z',
            },
            links: links.map(|(index, link)| LinkData::of(link, scene.machine.parent(index))).collect(),
            parts: scene.parts.iter().enumerate().map(|(index, part)| PartData::of(part, examined(index))).collect(),
            program: None,
            path: None,
            events: Vec::new(),
            faults: Vec::new(),
            notes: Vec::new(),
            distances: Distances::default(),
            variants: Vec::new(),
        }
    }

    pub(super) fn set_program(&mut self, scene: &Scene, run: &ProgramRun, motion: &Motion) {
        self.path = ToolPath::of(scene, run);
        let moves = &run.program.moves;
        let drives = |axis: &Axis| {
            scene.machine.axis_limits(*axis).is_some() || motion.positions.iter().any(|position| position[*axis] != 0.0)
        };
        let axes: Vec<Axis> = Axis::ALL.into_iter().filter(drives).collect();
        let values = motion.positions.iter().flat_map(|position| axes.iter().map(|&axis| position[axis]));
        let durations = std::iter::once(0.0).chain(motion.times_s.windows(2).map(|pair| pair[1] - pair[0]));
        self.program = Some(ProgramData {
            file: run.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
            lines: run.program.blocks.iter().map(|block| block.trim_end().to_owned()).collect(),
            duration_s: motion.times_s.last().copied().unwrap_or(0.0),
            first_tool: run.setup.tool,
            axes: axes.iter().map(|&axis| axis as usize).collect(),
            keys: motion.places.len(),
            durations: Packed::f32(durations),
            values: Packed::f32(values),
            moves: Moves {
                line: Packed::u32(moves.iter().map(|step| step.line)),
                kind: Packed::u8(moves.iter().map(|step| kind(&step.kind))),
                feed: Packed::f32(moves.iter().map(|step| step.feed_mm_min.unwrap_or(0.0))),
                tool: Packed::u32(run.tools()),
                rpm: Packed::f32(moves.iter().map(|step| step.spindle_rpm)),
                last_key: Packed::u32(motion.last_keys.iter().copied()),
            },
        });
    }
}

const fn kind(kind: &MoveKind) -> u8 {
    match kind {
        MoveKind::Rapid => 0,
        MoveKind::Feed => 1,
        MoveKind::Arc { .. } => 2,
        MoveKind::Dwell { .. } => 3,
        MoveKind::ToolChange { .. } => 4,
    }
}

impl LinkData {
    fn of(link: &crate::machine::Link, parent: Option<usize>) -> Self {
        let joint = link.joint.as_ref().map(|joint| {
            let (direction, point) = match joint.motion {
                JointMotion::Prismatic { direction } => (direction, [0.0; 3]),
                JointMotion::Rotary { direction, point } => (direction, point.into()),
            };
            let bound = |value: f64| value.is_finite().then_some(value);
            JointData {
                axis: joint.axis as usize,
                turns: joint.turns(),
                direction: direction.into_inner().into(),
                point,
                gain: joint.gain(),
                min: bound(joint.limits.min),
                max: bound(joint.limits.max),
            }
        });
        Self { name: link.name.clone(), parent, at: seven(&link.parent_from_link), joint }
    }
}

impl PartData {
    fn of(part: &Part, examined: bool) -> Self {
        let mesh: &Mesh = &part.mesh;
        let lattice = Lattice::over(mesh.vertices().iter());
        let wide = mesh.vertices().len() > usize::from(u16::MAX) + 1;
        let corners = || mesh.faces().as_flattened().iter().copied();
        Self {
            name: part.name.clone(),
            role: part.role.name(),
            tool: part.tool,
            link: part.link,
            at: seven(&part.link_from_part),
            examined,
            low: lattice.low.into(),
            step: lattice.step.into(),
            vertices: Packed::u16(mesh.vertices().iter().flat_map(|vertex| lattice.place(vertex))),
            faces: if wide { Packed::u32(corners()) } else { Packed::u16(corners().map(|corner| corner as u16)) },
            wide,
        }
    }
}
