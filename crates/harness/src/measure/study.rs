//! The engine of studies that vary factors: an audit, a sweep and an ablation are plans of it and differ in data.
//!
//! A study has scenes. A scene is prepared once, then described, then its cases are counted and timed in units: [`carry_out`]. Where cases are
//! trees over meshes, their queries are counted by [`count`] and timed by [`time`]; what is built is timed by [`time_builds`].

use super::blocks::{self, Extent, Participation, Sample, Work};
use super::folder::{Folder, RawTable, write_unit};
use super::shard::Shard;
use super::{MeasureError, Progress, Silent, timer};
use crate::geometry::Isometry;
use crate::method::Model;
use crate::record::manifest::Stage;
use crate::record::rows::CaseKey;
use crate::record::{
    BuildRow, CaseRow, CountRow, ExitRow, FactorRow, PoseRow, RecordError, Row, Stratum, TimingRow, TreeRow, write_rows,
};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A study: what its scenes are, and what is counted and timed there.
pub trait Study: Sync {
    /// A scene made ready: its bodies, its poses with their truth, its cases.
    type Place<'a>: Sync
    where
        Self: 'a;

    /// Names of the scenes.
    fn scenes(&self) -> Vec<String>;

    /// Names of a scene's units of counts.
    fn counted(&self, _scene: usize) -> Vec<String> {
        vec!["all".to_owned()]
    }

    /// Names of a scene's units of times.
    fn timed(&self, _scene: usize) -> Vec<String> {
        vec!["all".to_owned()]
    }

    /// Makes a scene ready.
    ///
    /// # Errors
    /// When bodies cannot be made or poses cannot be judged.
    fn prepare<'a>(&'a self, scene: usize, progress: &dyn Progress) -> Result<Self::Place<'a>, MeasureError>;

    /// What there is to say of a scene, whatever is counted.
    fn describe(&self, place: &Self::Place<'_>) -> Rows;

    /// Carries out a unit of counts. Several run at a time.
    fn count(&self, place: &Self::Place<'_>, unit: usize) -> Rows;

    /// Carries out a unit of times, alone.
    fn time(&self, place: &Self::Place<'_>, unit: usize) -> Rows;
}

/// Raw rows of a unit.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// `cases.csv`.
    pub cases: Vec<CaseRow>,
    /// `factors.csv`.
    pub factors: Vec<FactorRow>,
    /// `poses.csv`.
    pub poses: Vec<PoseRow>,
    /// `counts.csv`.
    pub counts: Vec<CountRow>,
    /// `exits.csv`.
    pub exits: Vec<ExitRow>,
    /// `trees.csv`.
    pub trees: Vec<TreeRow>,
    /// `timings.csv`.
    pub timings: Vec<TimingRow>,
    /// `builds.csv`.
    pub builds: Vec<BuildRow>,
}

const COUNTS: [RawTable; 6] = [
    RawTable::of_some::<CaseRow>(),
    RawTable::of_some::<FactorRow>(),
    RawTable::of_some::<PoseRow>(),
    RawTable::of_some::<CountRow>(),
    RawTable::of_some::<ExitRow>(),
    RawTable::of_some::<TreeRow>(),
];
const TIMES: [RawTable; 2] = [RawTable::of_some::<TimingRow>(), RawTable::of_some::<BuildRow>()];

/// The files of raw rows that a study may write.
pub fn raw_files() -> Vec<&'static str> {
    COUNTS.iter().chain(&TIMES).map(|table| table.file).collect()
}

impl Rows {
    fn write(&self, folder: &Path) -> Result<(), RecordError> {
        fn write<R: Row>(folder: &Path, rows: &[R]) -> Result<(), RecordError> {
            if rows.is_empty() { Ok(()) } else { write_rows(folder, rows) }
        }
        write(folder, &self.cases)?;
        write(folder, &self.factors)?;
        write(folder, &self.poses)?;
        write(folder, &self.counts)?;
        write(folder, &self.exits)?;
        write(folder, &self.trees)?;
        write(folder, &self.timings)?;
        write(folder, &self.builds)
    }
}

/// Kinds of units, each with a folder of its own.
pub const KINDS: [&str; 3] = [DESCRIPTIONS, COUNTED, TIMED];
const DESCRIPTIONS: &str = "scenes";
const COUNTED: &str = "counts";
/// The kind that depends on the machine.
pub const TIMED: &str = "times";

/// A unit, which may be another shard's.
struct Unit {
    path: PathBuf,
    is_own: bool,
}

impl Unit {
    fn is_lacking(&self) -> bool {
        self.is_own && !self.path.exists()
    }
}

/// The units of a scene.
struct Units {
    description: Unit,
    counts: Vec<Unit>,
    times: Vec<Unit>,
}

/// The units of every scene. A scene is described in the shard that has its first unit of counts.
fn units<S: Study>(study: &S, folder: &Folder, timed: bool) -> Vec<Units> {
    let unit = |names: &[&str]| Unit { path: folder.unit(names), is_own: true };
    let of_scene = |(number, scene): (usize, &String)| {
        let named = |kind: &str, names: Vec<String>| names.iter().map(|name| unit(&[kind, scene, name])).collect();
        Units {
            description: unit(&[DESCRIPTIONS, scene]),
            counts: named(COUNTED, study.counted(number)),
            times: if timed { named(TIMED, study.timed(number)) } else { Vec::new() },
        }
    };
    let mut scenes: Vec<Units> = study.scenes().iter().enumerate().map(of_scene).collect();
    if let Some(shard) = folder.manifest.shard.as_ref().map(Shard::from) {
        choose(shard, scenes.iter_mut().flat_map(|units| &mut units.counts).collect());
        choose(shard, scenes.iter_mut().flat_map(|units| &mut units.times).collect());
        for units in &mut scenes {
            units.description.is_own = units.counts.first().is_some_and(|first| first.is_own);
        }
    }
    scenes
}

/// Marks the shard's share of the units of a kind.
fn choose(shard: Shard, units: Vec<&mut Unit>) {
    let places = units.len();
    units.into_iter().enumerate().for_each(|(place, unit)| unit.is_own = shard.has(place, places));
}

/// Carries out a study, or the units it lacks, and joins its raw rows; without `timed`, only the deterministic ones. A shard carries out its
/// share of the units and seals them.
///
/// # Errors
/// When a scene cannot be prepared or a file cannot be written.
pub fn carry_out<S: Study>(
    study: &S,
    folder: &mut Folder,
    timed: bool,
    progress: &dyn Progress,
) -> Result<(), MeasureError> {
    let scenes = units(study, folder, timed);
    for ((number, scene), units) in study.scenes().iter().enumerate().zip(&scenes) {
        carry_out_scene(study, number, scene, units, progress)?;
    }
    Ok(conclude(folder, scenes, timed)?)
}

/// Joins the tables; a shard seals its units instead.
fn conclude(folder: &mut Folder, scenes: Vec<Units>, timed: bool) -> Result<(), RecordError> {
    if folder.manifest.shard.is_some() {
        KINDS.iter().try_for_each(|kind| folder.seal_units(&[kind]))?;
    } else {
        join(folder, scenes, timed)?;
    }
    if timed { folder.finish(Stage::Measure) } else { folder.save() }
}

fn join(folder: &mut Folder, scenes: Vec<Units>, timed: bool) -> Result<(), RecordError> {
    let (mut counts, mut descriptions, mut times) = (Vec::new(), Vec::new(), Vec::new());
    for units in scenes {
        descriptions.push(units.description.path);
        counts.extend(units.counts.into_iter().map(|unit| unit.path));
        times.extend(units.times.into_iter().map(|unit| unit.path));
    }
    counts.extend(descriptions);
    folder.join(&COUNTS, &counts)?;
    if timed { folder.join(&TIMES, &times) } else { Ok(()) }
}

fn carry_out_scene<S: Study>(
    study: &S,
    number: usize,
    scene: &str,
    units: &Units,
    progress: &dyn Progress,
) -> Result<(), MeasureError> {
    let lacking = |units: &[Unit]| (0..units.len()).filter(|&unit| units[unit].is_lacking()).collect::<Vec<usize>>();
    let (uncounted, untimed) = (lacking(&units.counts), lacking(&units.times));
    if uncounted.is_empty() && untimed.is_empty() && !units.description.is_lacking() {
        return Ok(());
    }
    let write = |unit: &Path, rows: &Rows| write_unit(unit, |folder| rows.write(folder));
    let place = study.prepare(number, progress)?;
    if units.description.is_lacking() {
        write(&units.description.path, &study.describe(&place))?;
    }
    progress.begin(&format!("{scene}: counting"), uncounted.len() as u64);
    uncounted.par_iter().try_for_each(|&unit| {
        let rows = study.count(&place, unit);
        progress.advance(1);
        write(&units.counts[unit].path, &rows)
    })?;
    progress.begin(&format!("{scene}: timing"), untimed.len() as u64);
    for unit in untimed {
        write(&units.times[unit].path, &study.time(&place, unit))?;
        progress.advance(1);
    }
    Ok(())
}

/// Poses of two parts that are counted and timed together.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Number of the chunk in the scene.
    pub chunk: u32,
    /// Stratum of all its poses.
    pub stratum: Stratum,
    /// The parts, by number.
    pub parts: [usize; 2],
    /// The second part in the frame of the first.
    pub poses: Vec<Isometry>,
    /// Whether they touch, exactly.
    pub touching: Vec<bool>,
}

/// A case with its models of a scene's parts.
pub struct Subject {
    /// The case.
    pub case: CaseKey,
    /// The models, by number of the part.
    pub models: BTreeMap<usize, Box<dyn Model>>,
}

impl Subject {
    /// The models of the two parts of a batch.
    pub fn pair(&self, batch: &Batch) -> [&dyn Model; 2] {
        batch.parts.map(|part| self.models[&part].as_ref())
    }
}

/// Asks a case about every pose of a batch.
pub fn count(scene: &str, subject: &Subject, batch: &Batch) -> CountRow {
    let [a, b] = subject.pair(batch);
    let mut row = CountRow::new(scene, &subject.case.name(), batch.chunk, Some(batch.stratum));
    for (pose, &touching) in batch.poses.iter().zip(&batch.touching) {
        let (verdict, counts) = a.first_counted(b, pose);
        row.poses += 1;
        row.queries += 1;
        row.volume_tests += counts.volume_tests;
        row.triangle_tests += counts.triangle_tests;
        row.touching += u64::from(touching);
        row.missed += u64::from(touching && !verdict);
    }
    row
}

/// Cases on the batches of a scene.
struct Queries<'a> {
    subjects: &'a [&'a Subject],
    batches: &'a [Batch],
    verdicts: Vec<bool>,
}

impl Work for Queries<'_> {
    fn cases(&self) -> usize {
        self.subjects.len()
    }

    fn chunks(&self) -> Vec<usize> {
        self.batches.iter().map(|batch| batch.poses.len()).collect()
    }

    fn participation(&self, _: usize, _: usize) -> Participation {
        Participation::Always
    }

    fn run(&mut self, case: usize, chunk: usize, poses: usize, passes: u32) {
        let batch = &self.batches[chunk];
        let [a, b] = self.subjects[case].pair(batch);
        for _ in 0..passes {
            self.verdicts.clear();
            a.first(b, &batch.poses[..poses], &mut self.verdicts);
        }
        std::hint::black_box(self.verdicts.last());
    }
}

/// Times every case on every batch.
pub fn time(
    (scene, launch): (&str, u32),
    subjects: &[&Subject],
    batches: &[Batch],
    blocks: u32,
    seed: u64,
) -> Vec<TimingRow> {
    let mut queries = Queries { subjects, batches, verdicts: Vec::new() };
    let extent = Extent { blocks, warms_up: true, long_once: false };
    let samples = blocks::time(&mut queries, extent, seed, &Silent);
    let names: Vec<String> = subjects.iter().map(|subject| subject.case.name()).collect();
    samples.iter().map(|sample| timing_row((scene, launch), &names, batches[sample.chunk].chunk, sample)).collect()
}

/// The row of a sample; `names` are those of the cases.
pub fn timing_row((scene, launch): (&str, u32), names: &[String], chunk: u32, sample: &Sample) -> TimingRow {
    TimingRow {
        scene: scene.to_owned(),
        case: names[sample.case].clone(),
        binary: 0,
        launch,
        block: sample.block,
        chunk,
        passes: sample.passes,
        ns: sample.ns,
    }
}

/// Something that is built: a case over a part.
pub struct Job<'a, M> {
    /// The case.
    pub case: CaseKey,
    /// Name of the part, and how many triangles it has.
    pub part: (String, u64),
    /// Builds it.
    pub build: Box<dyn Fn() -> M + 'a>,
}

/// Times every job once a block, in a fresh random order, and returns what the last block built, in the order of the jobs.
pub fn time_builds<M>(
    (scene, launch): (&str, u32),
    jobs: &[Job<'_, M>],
    blocks: u32,
    seed: u64,
) -> (Vec<BuildRow>, Vec<M>) {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    let mut built: Vec<Option<M>> = jobs.iter().map(|_| None).collect();
    let mut rows = Vec::new();
    for block in 0..blocks {
        order.shuffle(&mut rng);
        for &place in &order {
            let job = &jobs[place];
            // No more than one of a kind at a time.
            built[place] = None;
            let (ns, model) = timer::time(&job.build);
            built[place] = Some(model);
            rows.push((block, place, ns));
        }
    }
    rows.sort_unstable();
    let row = |(block, place, ns): (u32, usize, u64)| {
        let job = &jobs[place];
        build_row((scene, launch), job.case.clone(), job.part.clone(), block, ns)
    };
    (rows.into_iter().map(row).collect(), built.into_iter().flatten().collect())
}

/// The row of a construction over a part, given by its name and its triangles.
pub fn build_row(
    (scene, launch): (&str, u32),
    case: CaseKey,
    (part, triangles): (String, u64),
    block: u32,
    ns: u64,
) -> BuildRow {
    let CaseKey { variant, split, split_axes, leaf } = case;
    BuildRow {
        scene: scene.to_owned(),
        part,
        variant,
        split,
        split_axes,
        leaf,
        triangles,
        binary: 0,
        launch,
        block,
        ns,
    }
}
