//! Workloads: pairs of parts, and the relative poses at which they are examined.
//!
//! Reading order: this file, `program` and `recorded` (poses along a path), `ray` (first contact on a line), `approach`
//! and `random` (poses at known depths).

pub mod ray;
mod program;
mod recorded;
mod approach;
mod random;

use crate::geometry::Isometry;
use crate::machine::OutOfLimits;
use crate::scene::{Approach, Pair, ProgramRun, Role, Scene, TipFault};
use crate::truth::PairOracle;
use obbtree::cases::Draw;
use ray::{Contact, Target};
use std::path::PathBuf;
use thiserror::Error;

/// The source of a workload's poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The scene's G-code program.
    Program,
    /// Approaches along given directions, stopped at prescribed offsets from first contact.
    Approach,
    /// Random orientations and directions, at random offsets from first contact.
    Random,
    /// A CSV of recorded poses.
    Recorded,
}

impl Source {
    /// The name of the source, which is also the name of its workload.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Program => "program",
            Self::Approach => "approach",
            Self::Random => "random",
            Self::Recorded => "recorded",
        }
    }

    /// Whether the seed decides the poses.
    const fn is_drawn(self) -> bool {
        matches!(self, Self::Approach | Self::Random)
    }
}

/// One relative pose of a pair.
#[derive(Clone, Debug)]
pub struct PosedPair {
    /// Part `b` in the frame of part `a`.
    pub a_from_b: Isometry,
    /// Number of the cluster, the unit of resampling: poses of one cluster (one block of the tool path, one approach) depend on one
    /// another.
    pub cluster: u32,
    /// Line of the program; `None` without a program.
    pub line: Option<u32>,
    /// Travel past first contact, mm, negative before it, when the workload prescribes it. `None` for poses along a path, whose depth
    /// [`crate::truth`] computes.
    pub depth_mm: Option<f64>,
}

/// The poses of one pair, in order.
#[derive(Clone, Debug)]
pub struct PairPoses {
    /// The pair.
    pub pair: Pair,
    /// The poses of the pair; consecutive poses of a path are adjacent.
    pub poses: Vec<PosedPair>,
}

/// Named poses of one or more pairs.
#[derive(Clone, Debug)]
pub struct Workload {
    /// Name, unique in the scene.
    pub name: String,
    /// Where the poses come from.
    pub source: Source,
    /// Poses, pair by pair.
    pub pairs: Vec<PairPoses>,
}

impl Workload {
    /// Number of posed pairs, over all pairs.
    pub fn len(&self) -> usize {
        self.pairs.iter().map(|pair| pair.poses.len()).sum()
    }

    /// Whether there is no pose.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Why no poses can be generated.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum WorkloadError {
    /// The program drives an axis out of its limits.
    #[error("{file}:{line}: {cause}", file = file.display())]
    OutOfLimits {
        /// The program.
        file: PathBuf,
        /// Its line.
        line: u32,
        /// The axis and its position.
        cause: OutOfLimits,
    },
    /// The machine cannot follow the path of the tool's tip.
    #[error(transparent)]
    Tip(#[from] TipFault),
    /// An approach passes without contact.
    #[error("approach `{approach}`: {pair} never touch on this line")]
    NoContact {
        /// Its name.
        approach: String,
        /// The pair.
        pair: String,
    },
    /// The scene defines nothing that poses its pairs.
    #[error("scene `{scene}` has no program, approaches, random pairs or recorded poses")]
    Nothing {
        /// The scene.
        scene: String,
    },
}

/// Number of neighbouring poses on a path that form a cluster.
pub const BLOCK: usize = 64;

/// The block that contains the pose of the given index.
const fn block_of(index: usize) -> u32 {
    (index / BLOCK) as u32
}

/// The number of poses that a source may generate for a pair, and its random numbers.
struct Budget<'a> {
    poses: usize,
    seed: u64,
    labels: [&'a str; 3],
}

impl Budget<'_> {
    fn draw(&self, index: usize) -> Draw {
        Draw::new(self.seed, &self.labels, index as u64)
    }
}

/// Names of the workloads of a scene, which are known before any pose is made.
pub fn names(scene: &Scene) -> Vec<&'static str> {
    let recorded = scene.recording.iter().map(|_| Source::Recorded);
    recorded.chain(shares(scene).map(|(source, _)| source)).map(Source::name).collect()
}

/// The sources of a scene, each with its share of the poses that a recording leaves.
fn shares(scene: &Scene) -> impl Iterator<Item = (Source, usize)> {
    let all = [
        (Source::Program, usize::from(scene.program.is_some())),
        (Source::Approach, usize::from(!scene.approaches.is_empty())),
        (Source::Random, if scene.random.is_empty() { 0 } else { 2 }),
    ];
    all.into_iter().filter(|(_, share)| *share > 0)
}

/// The workloads of a scene, with about `poses` posed pairs in total. Recorded poses take up to half. Of the rest, random poses take half,
/// and approaches and the program a quarter each; the share of a source that the scene lacks goes to the others.
///
/// The result is the same for the same scene, number and seed, on every run and for any number of threads.
///
/// # Errors
/// [`WorkloadError`]: the program leaves the machine's limits, an approach passes without contact, or nothing poses the pairs.
pub fn generate(scene: &Scene, poses: usize, seed: u64) -> Result<Vec<Workload>, WorkloadError> {
    let workloads = generate_of(scene, poses, seed, |_| true)?;
    if workloads.is_empty() {
        return Err(WorkloadError::Nothing { scene: scene.name.clone() });
    }
    Ok(workloads)
}

/// Those of [`generate`] that another seed would change; none when program or recording alone pose the pairs.
///
/// # Errors
/// [`WorkloadError`]: an approach passes without contact.
pub fn generate_drawn(scene: &Scene, poses: usize, seed: u64) -> Result<Vec<Workload>, WorkloadError> {
    generate_of(scene, poses, seed, Source::is_drawn)
}

/// The workloads of the sources that are wanted; those of the others have their share all the same.
fn generate_of(
    scene: &Scene,
    poses: usize,
    seed: u64,
    is_wanted: impl Fn(Source) -> bool,
) -> Result<Vec<Workload>, WorkloadError> {
    let mut workloads = Vec::new();
    let total: usize = shares(scene).map(|(_, share)| share).sum();
    let mut left = poses;
    if let Some(recording) = &scene.recording {
        let most = if total == 0 { left } else { left / 2 };
        let count = most / scene.pairs.len();
        let of = |&pair: &Pair| PairPoses { pair, poses: recorded::poses(recording, pair, count) };
        let workload = named(Source::Recorded, scene.pairs.iter().map(of).collect());
        left = left.saturating_sub(workload.len());
        workloads.extend(is_wanted(Source::Recorded).then_some(workload));
    }
    for (source, share) in shares(scene).filter(|(source, _)| is_wanted(*source)) {
        let budget = left * share / total;
        workloads.push(named(
            source,
            match source {
                Source::Program => along_program(scene, budget)?,
                Source::Approach => approaching(scene, budget, seed)?,
                Source::Random | Source::Recorded => at_random(scene, budget, seed),
            },
        ));
    }
    Ok(workloads)
}

/// The poses of one pair along a program, each with the number of its step.
#[derive(Clone, Debug)]
pub struct PairSteps {
    /// The poses.
    pub poses: PairPoses,
    /// The step of each pose.
    pub steps: Vec<u32>,
}

/// A program in about `steps` steps, pair by pair. Pairs whose contact is intended (a cutter and the workpiece, or parts that the scene
/// allows to touch) are left out, because their contact does not end a program.
///
/// # Errors
/// [`WorkloadError`]: the program leaves the machine's limits.
pub fn along(scene: &Scene, run: &ProgramRun, steps: usize) -> Result<Vec<PairSteps>, WorkloadError> {
    let run = program::Run::new(scene, run, steps)?;
    let cuts = |pair: &Pair| {
        let roles = [pair.a, pair.b].map(|part| scene.parts[part].role);
        roles.contains(&Role::Cutter) && roles.contains(&Role::Workpiece)
    };
    let examined = scene.pairs.iter().filter(|pair| !cuts(pair) && !scene.allowed.iter().any(|other| pair.is(*other)));
    let of = |&pair: &Pair| {
        let (steps, poses) = run.steps_of(scene, pair).map(|(step, pose)| (step as u32, pose)).unzip();
        PairSteps { poses: PairPoses { pair, poses }, steps }
    };
    Ok(examined.map(of).filter(|pair| !pair.steps.is_empty()).collect())
}

fn named(source: Source, pairs: Vec<PairPoses>) -> Workload {
    Workload { name: source.name().to_owned(), source, pairs }
}

fn along_program(scene: &Scene, budget: usize) -> Result<Vec<PairPoses>, WorkloadError> {
    let Some(run) = &scene.program else { return Ok(Vec::new()) };
    let run = program::Run::new(scene, run, budget / scene.pairs.len())?;
    let posed = scene.pairs.iter().map(|&pair| PairPoses { pair, poses: run.poses_of(scene, pair) });
    // A pair whose tool is never in the spindle has none.
    Ok(posed.filter(|pair| !pair.poses.is_empty()).collect())
}

fn approaching(scene: &Scene, budget: usize, seed: u64) -> Result<Vec<PairPoses>, WorkloadError> {
    let mut pairs: Vec<Pair> = Vec::new();
    for approach in &scene.approaches {
        if !pairs.contains(&approach.pair) {
            pairs.push(approach.pair);
        }
    }
    let share = budget / pairs.len().max(1);
    let poses_of = |pair: Pair| {
        let approaches: Vec<&Approach> = scene.approaches.iter().filter(|approach| approach.pair == pair).collect();
        with_contact(scene, pair, Source::Approach, share, seed, |contact, budget| {
            approach::poses(scene, &approaches, contact, budget)
        })
    };
    pairs.iter().map(|&pair| Ok(PairPoses { pair, poses: poses_of(pair)? })).collect()
}

fn at_random(scene: &Scene, budget: usize, seed: u64) -> Vec<PairPoses> {
    let share = budget / scene.random.len().max(1);
    let poses_of = |pair: Pair| with_contact(scene, pair, Source::Random, share, seed, random::poses);
    scene.random.iter().map(|&pair| PairPoses { pair, poses: poses_of(pair) }).collect()
}

/// Prepares a pair for casting rays and passes it to a function.
fn with_contact<T>(
    scene: &Scene,
    pair: Pair,
    source: Source,
    poses: usize,
    seed: u64,
    then: impl FnOnce(&Contact<'_>, &Budget<'_>) -> T,
) -> T {
    let (a, b) = (&scene.parts[pair.a].mesh, &scene.parts[pair.b].mesh);
    let oracle = PairOracle::new(a.clone(), b.clone());
    let pair_name = scene.pair_name(pair);
    let budget = Budget { poses, seed, labels: [&scene.name, source.name(), &pair_name] };
    then(&Contact { oracle: &oracle, a: &Target::new(a), b: &Target::new(b) }, &budget)
}

#[cfg(test)]
mod tests;
