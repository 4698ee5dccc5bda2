//! `check`: runs a program on a machine and says what collides, where, when, and what comes near.
//!
//! Reading order: this file (what is asked and answered), [`motion`] (positions and times along the program), `scan` (one
//! pair along the path), `event` (from stretches of the path to events), `stock` (what is cut), `turning` (on lathes), `spun` (what a spindle turns).
//!
//! Method. The path is sampled as the scene says, straight in axis space between samples. At a sample the distance of a pair is
//! found on the trees of the chosen variant, and where it is not 0, whether one part lies inside the other; as long as the pair cannot have travelled that far
//! ([`crate::machine::travel`]) the samples are skipped. Two samples between which contact cannot be excluded by their distances
//! are halved until it can, or until less than [`Settings::tolerance_mm`] of travel is left. Where contact, or a near-miss
//! zone, begins and ends is found by halving to the same travel. How deep a cutter goes into a finished workpiece is found on the workpiece's
//! triangles ([`Finished`]) whatever the variant.

mod event;
pub mod motion;
mod scan;
mod spun;
mod turning;
mod stock;
#[cfg(test)]
mod tests;

pub use event::{Event, Extent, Kind};
pub use motion::Path;
pub use stock::{Remaining, Touch};

use crate::geometry::{Isometry, rigid};
use crate::machine::OutOfLimits;
use crate::machine::travel::Ball;
use crate::measure::{Progress, timer};
use crate::method::Model;
use crate::registry::{Registry, Variant};
use crate::scene::pairs::{self, Decision};
use crate::scene::{Clearances, Pair, ProgramRun, Role, Scene, TipFault, Turns};
use crate::stock::motion::Chain;
use crate::stock::{Finished, StockError, Surface};
use crate::truth::Solid;
use rayon::prelude::*;
use rs274::{Axis, Move, MoveKind, Position};
use scan::DIP_MM;
use spun::Spun;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use stock::{Met, StockContact, Workpiece};
use thiserror::Error;

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// How near pairs may come before it is told; `None` for what the scene says.
    pub clearances: Option<Clearances>,
    /// Travel below which contact is not looked for between two free poses, and to which beginnings and ends are found, mm.
    pub tolerance_mm: f64,
    /// Whether nothing behind the first collision is of interest.
    pub stop_at_first: bool,
    /// Whether the cutter takes material away, and how finely.
    pub cutting: Cutting,
    /// Whether what is left is wanted as a solid: on lathes it is a half section otherwise, which takes much less time.
    pub is_solid: bool,
    /// Cells of a stock that are held against what moves before the program is given up: contact with the workpiece is unresolved from there on.
    pub stock_budget: u64,
}

/// Whether the cutter takes material from the workpiece, and to which depth contact with what is left is not told from touching.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Cutting {
    /// At the stock's own resolution ([`crate::stock::RESOLUTION_MM`]); five times as coarse on lathes where a half section is not enough.
    #[default]
    Standard,
    /// At this resolution, mm.
    At(f64),
    /// The workpiece stays whole: a rapid that begins inside it is taken for a retreat, and may be a crash.
    Never,
}

impl Settings {
    /// The scene's clearances, and hundredths of a millimetre.
    pub fn standard() -> Self {
        Self {
            clearances: None,
            tolerance_mm: 0.01,
            stop_at_first: false,
            cutting: Cutting::Standard,
            is_solid: false,
            stock_budget: stock::MOST_QUESTIONS,
        }
    }

    fn clearances<'a>(&'a self, scene: &'a Scene) -> &'a Clearances {
        self.clearances.as_ref().unwrap_or(&scene.clearances)
    }

    /// The distances at which something is told of a pair.
    fn distances(&self, scene: &Scene, pair: Pair) -> Distances {
        let zones_mm = self.clearances(scene).of(&scene.parts, pair);
        let mut borders_mm = zones_mm.clone();
        borders_mm.push(PARTED_MM);
        borders_mm.extend(self.touching_mm(scene));
        borders_mm.sort_by(f64::total_cmp);
        borders_mm.dedup();
        Distances { zones_mm, borders_mm }
    }

    /// How much farther a cutter may go where it is in a finished workpiece by the tolerance, mm; `None` where that is a gouge already.
    /// The tolerance, because surfaces of triangles that slide on each other are in each other by chance.
    fn touching_mm(&self, scene: &Scene) -> Option<f64> {
        scene.gouge_mm.map(|allowed| allowed - self.tolerance_mm).filter(|&spare| spare > 0.0)
    }
}

/// The distances at which something is told of a pair.
struct Distances {
    /// Clearances, widest first, mm.
    zones_mm: Vec<f64>,
    /// Where nearness changes, narrowest first, mm: the clearances, [`PARTED_MM`], and where a cutter touches a finished workpiece.
    borders_mm: Vec<f64>,
}

/// How far apart two parts must have been for a new contact to be another event on the same line, mm.
pub const PARTED_MM: f64 = 1.0;

/// Why a program could not be checked.
#[derive(Debug, Error)]
pub enum CheckError {
    /// The program moves an axis that the machine lacks.
    #[error("{file}:{line}: the program moves axis {axis} to {value} {unit}, and no joint of the machine has that axis", file = file.display())]
    NoSuchAxis {
        /// The program.
        file: PathBuf,
        /// Line.
        line: u32,
        /// Letter of the axis.
        axis: char,
        /// Where to, in `unit`.
        value: f64,
        /// `mm` or `degrees`.
        unit: &'static str,
    },
    /// The program moves the tool's tip as the machine cannot.
    #[error(transparent)]
    Tip(#[from] TipFault),
    /// No pair of parts is left to examine, wherever the axes go.
    #[error("scene `{0}` has no two parts that could collide; `bvbench scene pairs` says why")]
    NoPairs(String),
    /// The stock cannot be divided as finely as asked.
    #[error("--stock-resolution: {0}")]
    Resolution(StockError),
    /// The program moves nothing.
    #[error("{file}: the program has no moves", file = .0.display())]
    NoMoves(PathBuf),
}

/// What was found.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Collisions and near misses, by the time at which they begin.
    pub events: Vec<Event>,
    /// What was decided on each pair of parts.
    pub decisions: Vec<Decision>,
    /// Where the program leaves the machine's limits: once for each line and axis, in the order of the program.
    pub over_travel: Vec<OverTravel>,
    /// Examined parts whose meshes are not watertight: whether something lies wholly inside them, nobody knows.
    pub open_parts: Vec<usize>,
    /// Tools that are in the spindle at some time and have no part: nobody knows what these touch. Tool 0 where the program feeds with none.
    pub tools_without_parts: Vec<u32>,
    /// Parts that a spindle turns, that are not round and are examined as drawn, because the axis about which they turn is not known, or moves.
    pub as_drawn: Vec<usize>,
    /// Cutters, and their holders, that either the tool's spindle or a drive of their own may turn. What only one of the two would cut or meet is unresolved.
    pub unsure: Vec<usize>,
    /// Cutters that are taken as driven on a lathe, because they are round and feed beside the workpiece's axis, or because the program turns that between their feeds.
    pub driven: Vec<usize>,
    /// Parts that stay within the resolution of what is left of a workpiece, so that nobody knows whether they touch it; once for each pair.
    pub touches: Vec<Touch>,
    /// What is left of each workpiece that is cut.
    pub remaining: Vec<Remaining>,
    /// Workpieces that cannot be cut: their meshes are open, or on a lathe nobody knows about which axis they turn.
    pub uncut: Vec<usize>,
    /// Whether a workpiece stays whole, and rapids that begin inside it are taken for retreats.
    pub stays_whole: bool,
    /// Cutters so thin that no depth in them is 0.05 mm more than the finished workpiece allows. Between samples their gouges may be missed, except where their middle is
    /// inside it.
    pub thin_cutters: Vec<usize>,
    /// Cutters with open meshes: what they cut nobody knows, so that they take nothing away for sure.
    pub open_cutters: Vec<usize>,
    /// Samples of the path.
    pub samples: usize,
    /// Poses of a pair at which a distance was found.
    pub queries: u64,
    /// How long the program takes, s.
    pub duration_s: f64,
    /// How long it took to build the trees, ns.
    pub trees_ns: u64,
}

impl Outcome {
    /// Whether anything collides.
    pub fn collides(&self) -> bool {
        self.events.iter().any(|event| event.kind.is_collision())
    }

    /// Whether the program may run: nothing collides, no axis leaves its limits, and every tool in use has a part.
    pub fn is_clear(&self) -> bool {
        !self.collides() && self.over_travel.is_empty() && self.tools_without_parts.is_empty()
    }
}

/// An axis beyond its limits.
#[derive(Clone, Debug, PartialEq)]
pub struct OverTravel {
    /// The first sample beyond, a whole place on the [`Path`].
    pub place: usize,
    /// Line.
    pub line: u32,
    /// Text of the line.
    pub block: String,
    /// Time from the program's start, s.
    pub time_s: f64,
    /// The axis, its range, and what the line asks for; of an arc and of a tool's tip, the first sample beyond.
    pub cause: OutOfLimits,
}

/// Samples that one thread takes at a time.
const CHUNK: usize = 256;

/// Runs a program on a scene's machine and looks for contact of every pair that can collide, with the trees of `variant`; where that is
/// made for tools ([`Variant::is_for_tools`]), of tools with workpieces, and with those of the fastest variant of `registry` of all others.
///
/// # Errors
/// When the program leaves the machine's limits or there is nothing to examine.
pub fn check(
    scene: &Scene,
    run: &ProgramRun,
    variant: &Variant,
    registry: &Registry,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Outcome, CheckError> {
    let path = Path::new(scene, run)?;
    if path.samples().is_empty() {
        return Err(CheckError::NoMoves(run.file.clone()));
    }
    refuse_missing_axes(scene, run)?;
    let reach = path.reach();
    let spun = Spun::of(scene, run, &path);
    let Examined { decisions, pairs, turned, of_stock, mut workpieces, uncut } =
        Examined::of(scene, &path, &reach, &spun, settings)?;
    progress.begin("building trees", 1);
    let for_the_rest = registry.fastest().unwrap_or(variant);
    let (trees_ns, [bodies, turned_bodies]) = timer::time(|| {
        let bodies = |scene: &Scene, pairs: &[Pair]| Bodies::new(scene, [variant, for_the_rest], pairs);
        [bodies(scene, &pairs), bodies(&spun.scene, &turned)]
    });
    let distances: Vec<Distances> = pairs.iter().map(|&pair| settings.distances(scene, pair)).collect();
    let is_stock = |pair: Pair| of_stock.contains(&pair);
    let stays_whole =
        |pair: Pair| settings.cutting == Cutting::Never && scene.is_cutting(pair) && scene.gouge_mm.is_none();
    let writer = event::EventWriter {
        scene,
        path: &path,
        pairs: &pairs,
        distances: &distances,
        is_stock: &is_stock,
        stays_whole: &stays_whole,
    };
    progress.begin("checking", path.samples().len().div_ceil(CHUNK) as u64);
    let queries = AtomicU64::new(0);
    let scanned = scan_all(&writer, &bodies, settings, &queries, progress);
    let turned_distances: Vec<Distances> = turned.iter().map(|&pair| settings.distances(&spun.scene, pair)).collect();
    let turned_writer = event::EventWriter { pairs: &turned, distances: &turned_distances, ..writer };
    let mut turned_scanned = Vec::new();
    if !turned.is_empty() {
        progress.begin("checking what turns", path.samples().len().div_ceil(CHUNK) as u64);
        turned_scanned = scan_all(&turned_writer, &turned_bodies, settings, &queries, progress);
    }
    // What is left at the end is wanted whatever collides before.
    let stops = settings.stop_at_first && !settings.is_solid;
    let mut end = path.samples().len();
    if stops {
        let mut known = writer.events(&scanned, &[], settings);
        writer.add_turned(&mut known, turned_writer.events(&turned_scanned, &[], settings));
        let first = known.iter().find(|event| event.kind.is_collision());
        end = first.map_or(end, |event| end.min(event.first.place.ceil() as usize));
    }
    progress.begin("cutting", workpieces.len() as u64);
    let mut met: Vec<Met> = workpieces
        .iter_mut()
        .map(|workpiece| {
            let stretches = |pair: Pair, is_turned: bool| {
                // A round workpiece touches at every angle what it touches as drawn.
                match turned.iter().position(|&other| other == pair).filter(|_| is_turned) {
                    Some(index) => of_pair(&turned_scanned, Some(index)),
                    None => of_pair(&scanned, pairs.iter().position(|&other| other == pair)),
                }
            };
            let met = workpiece.run(end, stops, settings, &stretches);
            if stops {
                end = end.min(met.last);
            }
            progress.advance(1);
            met
        })
        .collect();
    Workpiece::join(&workpieces, &mut met);
    let (of_turned, contacts): (Vec<StockContact>, Vec<StockContact>) =
        met.iter().flat_map(|met| met.contacts.iter().copied()).partition(|contact| contact.is_turned);
    let mut events = writer.events(&scanned, &contacts, settings);
    writer.add_turned(&mut events, turned_writer.events(&turned_scanned, &of_turned, settings));
    let mut over_travel = over_travel(scene, run, &path);
    if settings.stop_at_first
        && let Some(first) = events.iter().position(|event| event.kind.is_collision())
    {
        events.truncate(first + 1);
        over_travel.retain(|over| over.place as f64 <= events[first].first.place);
    }
    let open_cutters = workpieces.iter().flat_map(Workpiece::open_cutters).collect();
    let thin_cutters = &bodies.thin_cutters() | &turned_bodies.thin_cutters();
    let driven: BTreeSet<usize> = workpieces.iter().flat_map(|workpiece| workpiece.driven.iter().copied()).collect();
    Ok(Outcome {
        events,
        decisions,
        over_travel,
        open_parts: bodies.open_parts(),
        as_drawn: spun.as_drawn,
        unsure: spun.unsure,
        driven: driven.into_iter().collect(),
        tools_without_parts: tools_without_parts(scene, run, &reach),
        touches: met.into_iter().flat_map(|met| met.touches).collect(),
        remaining: workpieces.into_iter().map(Workpiece::remaining).collect(),
        stays_whole: pairs.iter().any(|&pair| stays_whole(pair)),
        uncut,
        thin_cutters: thin_cutters.into_iter().collect(),
        open_cutters,
        samples: path.samples().len(),
        queries: queries.into_inner(),
        duration_s: path.duration_s(),
        trees_ns,
    })
}

/// What a check examines.
struct Examined<'a> {
    decisions: Vec<Decision>,
    /// Pairs that are examined as drawn.
    pairs: Vec<Pair>,
    /// Pairs that are examined at every angle of a spindle.
    turned: Vec<Pair>,
    /// Those of both that are held against what is left of a workpiece.
    of_stock: Vec<Pair>,
    workpieces: Vec<Workpiece<'a>>,
    /// Workpieces that cannot be cut.
    uncut: Vec<usize>,
}

impl<'a> Examined<'a> {
    fn of(
        scene: &'a Scene,
        path: &'a Path<'a>,
        reach: &pairs::Reach,
        spun: &Spun,
        settings: &Settings,
    ) -> Result<Self, CheckError> {
        let mut decisions = pairs::decide(scene, reach, settings.clearances(scene));
        let pairs: Vec<Pair> = decisions.iter().filter(|d| d.dropped.is_none()).map(|d| d.pair).collect();
        if pairs.is_empty() && decisions.iter().filter_map(|d| d.dropped.as_ref()).all(pairs::Dropped::is_for_ever) {
            return Err(CheckError::NoPairs(scene.name.clone()));
        }
        let (cutting, mut turned): (Vec<Pair>, Vec<Pair>) =
            turned_pairs(spun, reach, settings).into_iter().partition(|&pair| scene.is_cutting(pair));
        let of_stock: Vec<Pair> =
            pairs.iter().chain(cutting.iter().filter(|pair| !pairs.contains(pair))).copied().collect();
        let (workpieces, uncut) = Workpiece::all(scene, path, &of_stock, (spun, &turned), settings)?;
        // A cutter is held against the stock alone; whatever else touches the uncut workpiece, is held against what is left of it.
        let is_stock = |pair: Pair| workpieces.iter().any(|workpiece| workpiece.has(pair));
        let pairs: Vec<Pair> = pairs.into_iter().filter(|&pair| !(scene.is_cutting(pair) && is_stock(pair))).collect();
        turned.extend(cutting.into_iter().filter(|&pair| !is_stock(pair)));
        let of_stock: Vec<Pair> = pairs.iter().chain(&turned).copied().filter(|&pair| is_stock(pair)).collect();
        // Out of reach as drawn, a pair may be within reach at another angle: it is examined then.
        let is_turned: BTreeSet<Pair> = turned.iter().copied().collect();
        let is_examined = |decision: &&mut Decision| is_turned.contains(&decision.pair) || is_stock(decision.pair);
        decisions.iter_mut().filter(is_examined).for_each(|decision| decision.dropped = None);
        Ok(Self { decisions, pairs, turned, of_stock, workpieces, uncut })
    }
}

/// The pairs in which a part turns and the other does not turn with it, that come near at some angle.
fn turned_pairs(spun: &Spun, reach: &pairs::Reach, settings: &Settings) -> Vec<Pair> {
    if !spun.turns_any() {
        return Vec::new();
    }
    let decisions = pairs::decide(&spun.scene, reach, settings.clearances(&spun.scene));
    // Of two parts without a joint between them one may be known to stand while the other turns.
    let stands = |pair: Pair| [pair.a, pair.b].iter().any(|&part| spun.scene.parts[part].turns == Some(Turns::Nothing));
    let is_examined = |decision: &Decision| match decision.dropped {
        None => true,
        Some(pairs::Dropped::Rigid) => stands(decision.pair),
        Some(_) => false,
    };
    let examined = decisions.into_iter().filter(is_examined).map(|decision| decision.pair);
    examined.filter(|&pair| spun.turns(pair)).collect()
}

/// Scans every pair of a writer along the path: for each chunk of it and each pair its stretches. In order and in groups, so that a search for the first
/// collision ends soon after it, whatever the number of threads.
fn scan_all(
    writer: &event::EventWriter<'_>,
    bodies: &Bodies,
    settings: &Settings,
    queries: &AtomicU64,
    progress: &dyn Progress,
) -> Vec<Vec<Vec<scan::Stretch>>> {
    let event::EventWriter { scene, path, pairs, distances, .. } = *writer;
    let scan_chunk = |&first: &usize| {
        let last = (first + CHUNK).min(path.samples().len());
        let poses: Vec<_> = (first..=last).map(|at| scene.machine.forward(&path.position(at))).collect();
        let scan_pair = |(&pair, Distances { borders_mm, .. }): (&Pair, &Distances)| {
            let mut scan = scan::Scan::new(scene, path, bodies, pair, borders_mm, settings.tolerance_mm);
            let stretches = scan.run(first, last, &poses);
            queries.fetch_add(scan.queries, Ordering::Relaxed);
            stretches
        };
        let scans: Vec<Vec<scan::Stretch>> = pairs.iter().zip(distances).map(scan_pair).collect();
        progress.advance(1);
        scans
    };
    let chunks: Vec<usize> = (0..path.samples().len()).step_by(CHUNK).collect();
    let mut scanned: Vec<Vec<Vec<scan::Stretch>>> = Vec::with_capacity(chunks.len());
    for group in chunks.chunks(GROUP) {
        scanned.extend(group.par_iter().map(scan_chunk).collect::<Vec<_>>());
        let found = || writer.events(&scanned, &[], settings);
        if settings.stop_at_first && found().iter().any(|event| event.kind.is_collision()) {
            break;
        }
    }
    scanned
}

/// The stretches of one of the pairs, in the order of the path.
fn of_pair(scanned: &[Vec<Vec<scan::Stretch>>], index: Option<usize>) -> Vec<scan::Stretch> {
    let of_chunk = |chunk: &Vec<Vec<scan::Stretch>>| index.and_then(|index| chunk.get(index)).cloned();
    scanned.iter().filter_map(of_chunk).flatten().collect()
}

/// Where the program leaves the machine's limits: the first sample of each line that takes an axis beyond, or ends with it beyond.
fn over_travel(scene: &Scene, run: &ProgramRun, path: &Path<'_>) -> Vec<OverTravel> {
    let (mut found, mut told) = (Vec::new(), BTreeSet::new());
    for (index, sample) in path.samples().iter().enumerate() {
        if scene.machine.check_limits(&sample.position).is_ok() {
            continue;
        }
        let (place, line, step) = (index + 1, sample.line, &run.program.moves[sample.move_index]);
        // Of the tip, which names a place on the workpiece, the last sample says where the axes end.
        let is_tip = step.tip_mm.is_some();
        let last = path.samples().partition_point(|other| other.move_index <= sample.move_index) - 1;
        let end = if is_tip { path.samples()[last].position } else { step.end };
        for axis in Axis::ALL {
            let Err(cause) = scene.machine.check_axis(axis, &sample.position) else { continue };
            let before = path.position(index);
            let came = scene.machine.check_axis(axis, &before).is_ok();
            let ends = scene.machine.check_axis(axis, &end).err();
            let (from, to) = (before[axis], sample.position[axis]);
            let moves = index == 0 || (to - from).abs() > STILL;
            let goes_on = moves && (to > from) == (cause.value > cause.max);
            if !(came || goes_on || (moves && ends.is_some())) || !told.insert((line, cause.axis)) {
                continue;
            }
            let (block, time_s) = (path.block(line).to_owned(), path.time_s(place as f64));
            // What the line asks for says more than the first sample beyond.
            let cause = ends.filter(|_| !is_tip).unwrap_or(cause);
            found.push(OverTravel { place, line, block, time_s, cause });
        }
    }
    found
}

/// Refuses a program that moves an axis which no joint follows: what is where, nobody would know. An axis may be named as long as it
/// stays where it is.
fn refuse_missing_axes(scene: &Scene, run: &ProgramRun) -> Result<(), CheckError> {
    let is_missing = |axis: &Axis| scene.machine.joints_of(*axis).next().is_none();
    let missing: Vec<Axis> = Axis::ALL.into_iter().filter(is_missing).collect();
    for step in &run.program.moves {
        // X, Y and Z of a tip under control are not axes.
        let is_axis = |axis: &&Axis| step.tip_mm.is_none() || **axis as usize > Axis::Z as usize;
        let moved = |axis: &&Axis| {
            let is_of_arc = matches!(step.kind, MoveKind::Arc { plane, sweep, .. } if sweep != 0.0 && plane.axes()[..2].contains(axis));
            is_of_arc || (step.end[**axis] - run.start[**axis]).abs() > STILL
        };
        if let Some(&axis) = missing.iter().filter(is_axis).find(moved) {
            let (value, unit) =
                if axis.is_rotary() { (step.end[axis].to_degrees(), "degrees") } else { (step.end[axis], "mm") };
            let (file, letter) = (run.file.clone(), axis.letter());
            return Err(CheckError::NoSuchAxis { file, line: step.line, axis: letter, value, unit });
        }
    }
    Ok(())
}

/// By how much rounding may move an axis that stays where it is, mm or radians.
const STILL: f64 = 1e-9;

/// Tools in use without a part; tool 0, no tool, where the program feeds with none. Where no part has a number, a cutter or shank is of every tool;
/// without either, only feeding with a turning spindle tells that a tool is missing, as presses and robots feed without one.
fn tools_without_parts(scene: &Scene, run: &ProgramRun, reach: &pairs::Reach) -> Vec<u32> {
    let (changes, has_role) = (scene.changes_tools(), |role: Role| scene.parts.iter().any(|part| part.role == role));
    if !changes && (has_role(Role::Cutter) || has_role(Role::Shank)) {
        return Vec::new();
    }
    // A holder alone says nothing of what it holds.
    let has_part = |tool: u32| scene.parts.iter().any(|part| part.tool == Some(tool) && part.role != Role::Holder);
    let needs_tool =
        |step: &Move| step.kind.is_feed() && (changes || (step.spindle_rpm != 0.0 && has_role(Role::Workpiece)));
    let feeds_without = || run.program.moves.iter().zip(run.tools()).any(|(step, tool)| tool == 0 && needs_tool(step));
    let used = reach.tools.iter().flatten().map(|(&tool, _)| tool);
    used.filter(|&tool| !has_part(tool) && (tool != 0 || feeds_without())).collect()
}

/// Chunks that are scanned before it is looked whether there is a collision among them.
const GROUP: usize = 64;

/// An examined part, prepared for its variants and for the question what lies in it.
struct Body {
    /// For the variant that was asked for and for the fastest, where a pair needs it.
    models: [Option<Box<dyn Model>>; 2],
    solid: Solid,
    ball: Ball,
}

/// Every examined part.
struct Bodies {
    parts: BTreeMap<usize, Body>,
    /// Which of the two variants each pair is asked of, but for those of `gouges`.
    asked: BTreeMap<Pair, usize>,
    gouges: BTreeMap<Pair, Gouge>,
}

impl Bodies {
    fn new(scene: &Scene, variants: [&Variant; 2], pairs: &[Pair]) -> Self {
        let mut surfaces = BTreeMap::new();
        let gouge = |&pair: &Pair| Some((pair, Gouge::of(scene, pair, &mut surfaces)?));
        let gouges: BTreeMap<Pair, Gouge> = pairs.iter().filter_map(gouge).collect();
        let is_for_tools = variants[0].is_for_tools;
        let asked: BTreeMap<Pair, usize> = pairs
            .iter()
            .filter(|&pair| !gouges.contains_key(pair))
            .map(|&pair| (pair, usize::from(is_for_tools && !is_tool_and_workpiece(scene, pair))))
            .collect();
        let mut parts: Vec<usize> = pairs.iter().flat_map(|pair| [pair.a, pair.b]).collect();
        parts.sort_unstable();
        parts.dedup();
        let prepare = |part: usize| {
            let mesh = &scene.parts[part].mesh;
            let is_asked = |which| asked.iter().any(|(pair, &of)| of == which && (pair.a == part || pair.b == part));
            let models = [0, 1].map(|which| is_asked(which).then(|| variants[which].prepare(mesh, None)));
            (part, Body { models, solid: Solid::new(Arc::clone(mesh)), ball: pairs::ball(&scene.parts[part]) })
        };
        let parts = parts.into_par_iter().map(prepare).collect::<Vec<_>>().into_iter().collect();
        Self { parts, asked, gouges }
    }

    fn of(&self, pair: Pair) -> (&dyn Model, &dyn Model) {
        let model = |part: usize| self.parts[&part].models[self.asked[&pair]].as_deref();
        let [a, b] = [pair.a, pair.b].map(|part| model(part).expect("prepared for every pair that it is of"));
        (a, b)
    }

    fn balls(&self, pair: Pair) -> [Ball; 2] {
        [pair.a, pair.b].map(|part| self.parts[&part].ball)
    }

    /// Whether one part is wholly inside the other, given that their surfaces do not touch.
    fn one_in_the_other(&self, pair: Pair, a_from_b: &Isometry) -> bool {
        Solid::one_in_the_other(&self.parts[&pair.a].solid, &self.parts[&pair.b].solid, a_from_b, false)
    }

    /// Cutters that are too thin, or have a blade or pin that is, for a gouge to be found.
    fn thin_cutters(&self) -> BTreeSet<usize> {
        let thin = self.gouges.iter().filter(|(_, gouge)| gouge.is_thin);
        thin.map(|(pair, gouge)| if gouge.workpiece_first { pair.b } else { pair.a }).collect()
    }

    /// Parts that are not watertight, in order.
    fn open_parts(&self) -> Vec<usize> {
        self.parts.iter().filter(|(_, body)| !body.solid.is_watertight()).map(|(&part, _)| part).collect()
    }
}

/// Whether one part is of a tool and the other the workpiece.
fn is_tool_and_workpiece(scene: &Scene, pair: Pair) -> bool {
    let roles = [pair.a, pair.b].map(|part| scene.parts[part].role);
    roles.contains(&Role::Workpiece) && roles.into_iter().any(Role::is_of_tool)
}

/// A cutter against a finished workpiece.
struct Gouge {
    finished: Finished,
    /// Whether the workpiece is the pair's part `a`.
    workpiece_first: bool,
    /// How deep the cutter may go, mm.
    allowed_mm: f64,
    /// Whether a blade or a pin of the cutter, or all of it, is too thin for a gouge between samples to be found.
    is_thin: bool,
    /// The joints between the cutter and the workpiece.
    chain: Chain,
}

impl Gouge {
    /// `None` when the pair is not these two, or the scene's workpiece is uncut.
    fn of(scene: &Scene, pair: Pair, surfaces: &mut BTreeMap<usize, Surface>) -> Option<Self> {
        let allowed_mm = scene.gouge_mm?;
        let workpiece_first = scene.is_cutting(pair).then(|| scene.parts[pair.a].role == Role::Workpiece)?;
        let (workpiece, cutter) = if workpiece_first { (pair.a, pair.b) } else { (pair.b, pair.a) };
        let surface = surfaces.entry(workpiece).or_insert_with(|| Surface::of(&scene.parts[workpiece].mesh));
        let finished = Finished::new(surface.clone(), &scene.parts[cutter].mesh);
        let body = crate::stock::Body::turning(&scene.parts[cutter].mesh, 0.0);
        // Between two samples a gouge is found where it is that much deeper.
        let findable_mm = allowed_mm + DIP_MM;
        let is_thin = body.deepest_mm(findable_mm) <= findable_mm;
        let chain = stock::chain(scene, stock::mount(scene, cutter, &body), workpiece);
        Some(Self { finished, workpiece_first, allowed_mm, is_thin, chain })
    }

    /// Whether the cutter may get more than `beyond_mm` deeper than allowed while the axes go straight from one position to another.
    fn may_gouge(&self, scene: &Scene, from: &Position, to: &Position, beyond_mm: f64) -> bool {
        let piece = self.chain.piece(&scene.machine, from, to, 0, 1);
        let ways = [piece.first, piece.last].map(|pose| rigid::inverse(&pose));
        self.finished.may_be_deeper([&ways[0], &ways[1]], piece.sag_mm, self.allowed_mm + beyond_mm)
    }

    /// How much farther the cutter may go, mm, negative where it gouges; `below_mm` where it is at least that.
    fn spare_mm(&self, a_from_b: &Isometry, below_mm: f64) -> f64 {
        self.finished.least_mm(&self.cutter_from_workpiece(a_from_b), below_mm - self.allowed_mm) + self.allowed_mm
    }

    /// Whether the cutter's middle is inside the workpiece.
    fn is_inside(&self, a_from_b: &Isometry) -> bool {
        self.finished.holds(&self.cutter_from_workpiece(a_from_b))
    }

    fn cutter_from_workpiece(&self, a_from_b: &Isometry) -> Isometry {
        if self.workpiece_first { rigid::inverse(a_from_b) } else { *a_from_b }
    }
}
