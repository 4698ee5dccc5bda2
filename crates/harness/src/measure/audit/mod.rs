//! The audit: a full crossing of orientation, centre, split rule and leaf size, with the same queries for every cell.
//!
//! Reading order: [`cell`] (the combinations), `memory` (cached axes), this file (the plan). Counts and trees are deterministic. Each cell
//! is timed beside a second copy of the reference cell, so that disturbances of the machine affect both. The reference is repeated because
//! the trees of four hundred cells do not fit into memory together, and every unit must be complete by itself.
//!
//! A unit is one cell on one scene: an audit that was killed continues with the missing units.

pub mod cell;
mod memory;

use self::memory::Memory;
use super::chunk::{self, Chunk, Participants};
use super::exits;
use super::folder::Folder;
use super::judged::{self, JudgedPair, JudgedPose, Strata};
use super::measured::pose_rows;
use super::plan::{Plan, PlanError, Selection};
use super::shape::tree_row;
use super::shard::Shard;
use super::study::{self, Batch, Job, Rows, Study, Subject};
use super::{MeasureError, Profile, Progress, Silent};
use crate::method::Model;
use crate::record::rows::CaseKey;
use crate::record::{CaseRow, ExitRow, Manifest, NULL_VARIANT, Stratum};
use crate::registry::Registry;
use crate::scene::Scene;
use crate::truth::TruthCache;
use cell::{BoxTree, Cell};
use obbtree::cases::Draw;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::OnceLock;

/// Ratio of generated to measured poses, large enough that every stratum fills its share.
const POSE_RESERVE: usize = 4;

/// Amount of work of an audit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Amount {
    /// Largest number of chunks of each stratum and scene.
    chunks: usize,
    /// Number of timed blocks after the warm-up.
    blocks: u32,
}

const fn amount(profile: Profile) -> Amount {
    match profile {
        Profile::Smoke => Amount { chunks: 1, blocks: 1 },
        Profile::Quick => Amount { chunks: 4, blocks: 2 },
        Profile::Full => Amount { chunks: 32, blocks: 8 },
    }
}

/// An audit: scenes, cells, and the folder that holds it.
#[derive(Debug)]
pub struct Audit {
    folder: Folder,
    design: Design,
}

/// The crossed factors and the scenes.
#[derive(Debug)]
struct Design {
    plan: Plan,
    cells: Vec<Cell>,
    amount: Amount,
    cache: Option<TruthCache>,
}

/// The chosen poses of a scene, with their ground truth.
struct Questions<'a> {
    scene: &'a Scene,
    judged: Vec<JudgedPair>,
    chunks: Vec<Chunk>,
    batches: Vec<Batch>,
    /// The parts that occur in the poses.
    parts: BTreeSet<usize>,
    memory: Memory,
    /// The second copy of the reference cell, built on first use.
    reference: OnceLock<Subject>,
}

impl Audit {
    /// The plan of an audit of some scenes; by default, all scenes that a run examines.
    ///
    /// # Errors
    /// When a scene cannot be loaded.
    pub fn plan(profile: Profile, scenes: Vec<String>, seed: u64, registry: &Registry) -> Result<Plan, PlanError> {
        let selection =
            Selection { profile, scenes, variants: Vec::new(), workloads: Vec::new(), policies: Vec::new(), seed };
        let mut plan = Plan::new(selection, registry)?;
        // The cells take the place of the variants.
        (plan.variants, plan.cases) = (Vec::new(), Vec::new());
        let amount = amount(profile);
        (plan.budget.verify_poses, plan.budget.launches, plan.budget.blocks) = (0, 1, amount.blocks);
        Ok(plan)
    }

    /// Opens an audit's folder, new or to be continued. If `orientations` or `leaves` are given, only cells with these orientations or leaf
    /// sizes are audited; `fresh` replaces an audit of another request.
    ///
    /// # Errors
    /// When an orientation or leaf size does not exist, or the folder holds something else or cannot be written.
    pub fn open(
        plan: Plan,
        orientations: &[String],
        leaves: &[u8],
        folder: &Path,
        fresh: bool,
    ) -> Result<Self, MeasureError> {
        let cells = cells(orientations, leaves)?;
        let mut whole = Manifest { shard: None, ..plan.manifest() };
        whole.request.policies = cells.iter().map(Cell::name).collect();
        let folder = Folder::open(folder, Shard::manifest(plan.shard, whole), fresh)?;
        let amount = amount(plan.selection.profile);
        Ok(Self { folder, design: Design { plan, cells, amount, cache: None } })
    }

    /// The same audit with a cache of the ground truth.
    pub fn with_cache(mut self, cache: TruthCache) -> Self {
        self.design.cache = Some(cache);
        self
    }

    /// The audit's folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Number of cells.
    pub const fn cells(&self) -> usize {
        self.design.cells.len()
    }

    /// Carries out the missing units of the audit and writes its raw records; without `timed`, only the deterministic ones.
    ///
    /// # Errors
    /// When poses cannot be judged or files cannot be written.
    pub fn run(&mut self, timed: bool, progress: &dyn Progress) -> Result<(), MeasureError> {
        study::carry_out(&self.design, &mut self.folder, timed, progress)
    }
}

/// The cells with the given orientations and leaf sizes; an empty list selects all.
fn cells(orientations: &[String], leaves: &[u8]) -> Result<Vec<Cell>, MeasureError> {
    let mut cells = Cell::all();
    if let Some(asked) = orientations.iter().find(|asked| cells.iter().all(|cell| cell.orientation != *asked)) {
        let mut known: Vec<&str> = cells.iter().map(|cell| cell.orientation).collect();
        known.dedup();
        return Err(MeasureError::NoSuchOrientation { asked: asked.clone(), known: known.join(", ") });
    }
    if let Some(&asked) = leaves.iter().find(|asked| !cell::LEAVES.contains(asked)) {
        let known = cell::LEAVES.map(|leaf| leaf.to_string()).join(", ");
        return Err(MeasureError::NoSuchLeaf { asked, known });
    }
    cells.retain(|cell| orientations.is_empty() || orientations.iter().any(|asked| asked == cell.orientation));
    cells.retain(|cell| leaves.is_empty() || leaves.contains(&cell.leaf));
    Ok(cells)
}

impl Study for Design {
    type Place<'a> = Questions<'a>;

    fn scenes(&self) -> Vec<String> {
        self.plan.scenes.iter().map(|scene| scene.name.clone()).collect()
    }

    fn counted(&self, _: usize) -> Vec<String> {
        self.cells.iter().map(Cell::name).collect()
    }

    fn timed(&self, scene: usize) -> Vec<String> {
        self.counted(scene)
    }

    fn prepare<'a>(&'a self, scene: usize, progress: &dyn Progress) -> Result<Questions<'a>, MeasureError> {
        let (scene, poses) = (&self.plan.scenes[scene], self.plan.budget.measure_poses);
        progress.begin(&format!("{}: exact truth", scene.name), 1);
        let count = poses * POSE_RESERVE;
        let judged = judged::judge(&self.plan, scene, count, Strata::Sought, self.cache.as_ref(), &Silent)?;
        let chunks = chosen(&chunk::select_windows(&judged, poses, chunk::LONG), self.amount.chunks);
        let batches: Vec<Batch> = chunks.iter().map(|chunk| batch(chunk, &judged[chunk.pair])).collect();
        let parts = batches.iter().flat_map(|batch| batch.parts).collect();
        let (memory, reference) = (Memory::default(), OnceLock::new());
        Ok(Questions { scene, judged, chunks, batches, parts, memory, reference })
    }

    fn describe(&self, questions: &Questions<'_>) -> Rows {
        Rows {
            cases: vec![null_row()],
            poses: pose_rows(questions.scene, &questions.judged, &questions.chunks),
            exits: reference_exits(questions),
            ..Rows::default()
        }
    }

    /// Counts for a cell: its trees over all parts, and their answers.
    fn count(&self, questions: &Questions<'_>, unit: usize) -> Rows {
        let (cell, scene) = (&self.cells[unit], questions.scene);
        let trees = questions.trees(cell, Some(&questions.memory));
        let describe =
            |(&part, tree): (&usize, &BoxTree)| tree_row(scene, part, cell.key(), &tree.brief_report(), tree.bytes());
        let described = trees.iter().map(describe).collect();
        let subject = subject(cell.key(), trees);
        Rows {
            cases: vec![cell.row()],
            factors: cell.factors(),
            counts: questions.batches.iter().map(|batch| study::count(&scene.name, &subject, batch)).collect(),
            trees: described,
            ..Rows::default()
        }
    }

    /// Times a cell beside the reference, as one launch with two cases; the number of the launch is that of the cell.
    fn time(&self, questions: &Questions<'_>, unit: usize) -> Rows {
        let (cell, scene) = (&self.cells[unit], questions.scene);
        let reference =
            questions.reference.get_or_init(|| subject(null_key(), questions.trees(&Cell::reference(), None)));
        let mut draw = Draw::new(self.plan.selection.seed, &["audit", &scene.name, &cell.name()], 0);
        let mut seed = || (draw.unit() * 2_f64.powi(53)) as u64;
        let launch = (scene.name.as_str(), unit as u32);
        let (mut builds, mut trees) = (Vec::new(), BTreeMap::new());
        for &part in &questions.parts {
            let (name, triangles) = (&scene.parts[part].name, scene.parts[part].mesh.triangles());
            let job = |cell: Cell, case: CaseKey| Job {
                case,
                part: (name.clone(), triangles.len() as u64),
                build: Box::new({
                    let triangles = &triangles;
                    move || cell.tree(triangles, None)
                }),
            };
            let jobs = [job(*cell, cell.key()), job(Cell::reference(), null_key())];
            let (rows, built) = study::time_builds(launch, &jobs, 1, seed());
            builds.extend(rows);
            trees.extend(built.into_iter().next().map(|tree| (part, tree)));
        }
        let own = subject(cell.key(), trees);
        let timings = study::time(launch, &[&own, reference], &questions.batches, self.amount.blocks, seed());
        Rows { timings, builds, ..Rows::default() }
    }
}

impl Questions<'_> {
    /// The tree of a cell over every part that occurs in the poses.
    fn trees(&self, cell: &Cell, memory: Option<&Memory>) -> BTreeMap<usize, BoxTree> {
        let tree = |&part: &usize| (part, cell.tree(&self.scene.parts[part].mesh.triangles(), memory));
        self.parts.iter().map(tree).collect()
    }
}

fn subject(case: CaseKey, trees: BTreeMap<usize, BoxTree>) -> Subject {
    let boxed = |(part, tree)| (part, Box::new(tree) as Box<dyn Model>);
    Subject { case, models: trees.into_iter().map(boxed).collect() }
}

/// The key of the second copy of the reference cell, beside which every cell is timed.
fn null_key() -> CaseKey {
    CaseKey { variant: NULL_VARIANT.to_owned(), ..Cell::reference().key() }
}

fn null_row() -> CaseRow {
    let reference = Cell::reference().row();
    CaseRow {
        case: null_key().name(),
        variant: NULL_VARIANT.to_owned(),
        label: format!("{}, second copy", reference.label),
        default: 0,
        duplicate_of: reference.case.clone(),
        ..reference
    }
}

fn batch(chunk: &Chunk, judged: &JudgedPair) -> Batch {
    let poses = || chunk.poses.iter().map(|&pose| &judged.poses[pose]);
    Batch {
        chunk: chunk.number,
        stratum: chunk.stratum,
        parts: [judged.pair.a, judged.pair.b],
        poses: poses().map(|pose| pose.a_from_b).collect(),
        touching: poses().map(JudgedPose::touches).collect(),
    }
}

/// Where separating-axis tests end, over all volume tests of the reference cell: one row for each stratum and axis, in the order of the
/// test.
fn reference_exits(questions: &Questions<'_>) -> Vec<ExitRow> {
    let trees = questions.trees(&Cell::reference(), None);
    exits::exit_rows(&questions.scene.name, &Cell::reference().key(), |stratum, histogram| {
        for batch in questions.batches.iter().filter(|batch| batch.stratum == stratum) {
            let [a, b] = batch.parts.map(|part| &trees[&part]);
            batch.poses.iter().for_each(|pose| exits::query(a, b, pose, histogram));
        }
    })
}

/// At most `most` chunks of each stratum, evenly spread; chunks of the control are left out.
fn chosen(chunks: &[Chunk], most: usize) -> Vec<Chunk> {
    let mut kept = Vec::new();
    for stratum in Stratum::ALL {
        let of_it: Vec<&Chunk> = chunks
            .iter()
            .filter(|chunk| chunk.stratum == stratum && chunk.participants != Participants::Control)
            .collect();
        let count = of_it.len().min(most);
        kept.extend((0..count).map(|i| of_it[(2 * i + 1) * of_it.len() / (2 * count)].clone()));
    }
    kept
}
