//! The reference study, a run: its stages, and which rows each unit writes. The folder and its units are those of `super::folder`.
//!
//! Units are the cross-check of the triangle tests, the lines of a scene's verification and its verdicts case by case, the counts of a scene, and the
//! timings of a scene in one launch. A shard carries out its share of them and keeps them; [`super::shard::merge`] joins shards.

use super::folder::{CROSS_CHECK, Folder, RawTable, write_unit};
use super::judged;
use super::measured::Measured;
use super::plan::{Case, Plan, PlanError};
use super::{Progress, accuracy, binaries, build, counts, environment, exits, query, shape, single, timer};
use crate::geometry::cross_check::cross_check;
use crate::geometry::shapes::ShapeError;
use crate::interference::profile::ProfileError;
use crate::record::manifest::{CrossCheckEntry, MachineFacts, Stage};
use crate::record::{
    AnswerRow, BuildRow, CaseRow, ExitRow, LineRow, Manifest, MissRow, OutlineRow, PoseRow, RecordError, Row,
    SingleRow, TightnessRow, TimingRow, TreeRow, VerificationRow, read_json, read_rows, read_rows_if_there, read_text,
    write_json, write_rows, write_text,
};
use crate::scene::Scene;
use crate::truth::{CacheError, TruthCache};
use crate::workload::WorkloadError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// File of a timing unit: one complaint about noise per line.
const NOISE_FILE: &str = "noise.txt";

/// File of the unit [`CROSS_CHECK`].
const CROSS_CHECK_FILE: &str = "cross-check.json";

/// Why a run, an audit, a sweep or an ablation could not be opened or carried on.
#[derive(Debug, Error)]
pub enum MeasureError {
    /// A file could not be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The workload cannot be made.
    #[error(transparent)]
    Workload(#[from] WorkloadError),
    /// The truth cannot be stored.
    #[error(transparent)]
    Cache(#[from] CacheError),
    /// The plan cannot be made.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A surface or the tool of the ablation cannot be meshed.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The tool of the ablation has impossible dimensions.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// The folder holds something that is not a run.
    #[error("{folder} is not empty and holds no {manifest}; name another folder with --out", folder = .0.display(), manifest = Manifest::FILE)]
    NotARun(PathBuf),
    /// The folder holds a run of something else.
    #[error("{folder} holds a run of another request ({difference} differs); name another folder with --out, or replace it with --fresh", folder = folder.display())]
    AnotherRun {
        /// The folder.
        folder: PathBuf,
        /// What differs.
        difference: &'static str,
    },
    /// An orientation is none of the audit's.
    #[error("the audit has no orientation `{asked}`; it has {known}")]
    NoSuchOrientation {
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
    /// A leaf size is none of the audit's.
    #[error("the audit has no leaves of {asked} triangles; it has {known}")]
    NoSuchLeaf {
        /// What was asked for.
        asked: u8,
        /// What there is.
        known: String,
    },
    /// There is no sweep of that name.
    #[error("there is no sweep `{asked}`; there are {known}")]
    NoSuchSweep {
        /// The name given.
        asked: String,
        /// The names of all sweeps.
        known: String,
    },
    /// A body of a sweep cannot be made at the requested value.
    #[error("a body of the sweep cannot be made: {0}")]
    Body(String),
    /// A launch runs in a binary that is not the run's.
    #[error(
        "launch {launch} runs in {running}, but {expected} is the binary of its turn: they were built again since the run began; make the run again with --fresh"
    )]
    AnotherBinary {
        /// Its number.
        launch: u32,
        /// The file that runs.
        running: String,
        /// The file that should.
        expected: String,
    },
    /// A run was timed in part on a machine of another kind.
    #[error("{folder} was timed in part on {begun}; this is {here}: go on there, or time all of it again with --fresh", folder = folder.display())]
    AnotherMachine {
        /// The run.
        folder: PathBuf,
        /// Processor, instruction set and cores of the machine that began.
        begun: String,
        /// Those of this one.
        here: String,
    },
    /// A launch in a process of its own failed.
    #[error("launch {launch} failed: {cause}")]
    Launch {
        /// Its number.
        launch: u32,
        /// Why.
        cause: String,
    },
}

/// Carries out a timing launch in a process of its own, given its number.
pub type Launcher<'a> = &'a dyn Fn(u32) -> Result<(), String>;

/// What a verification found.
#[derive(Clone, Debug)]
pub struct Verification {
    /// `verification.csv`.
    pub rows: Vec<VerificationRow>,
    /// The exact triangle test against its twin.
    pub cross_check: CrossCheckEntry,
}

impl Verification {
    /// The rows that break a promise: a safe variant that misses a contact above grazing.
    pub fn broken_promises(&self) -> impl Iterator<Item = &VerificationRow> {
        self.rows.iter().filter(|row| row.safe == 1 && row.band.is_above_grazing() && row.missed > 0)
    }

    /// Whether every promise is kept and the exact test can be trusted.
    pub fn holds(&self) -> bool {
        self.broken_promises().next().is_none() && self.cross_check.disagreements == 0
    }
}

/// A run: a plan and the folder it is carried out in.
#[derive(Debug)]
pub struct Run {
    folder: Folder,
    plan: Plan,
    cache: Option<TruthCache>,
}

impl Run {
    /// Opens a run's folder: a new one, one that was interrupted, or a finished one that is to be made again. `fresh`
    /// allows a run of another request to be replaced.
    ///
    /// # Errors
    /// When the folder holds something else or cannot be written.
    pub fn open(plan: Plan, folder: &Path, fresh: bool) -> Result<Self, MeasureError> {
        let mut folder = Folder::open(folder, plan.manifest(), fresh)?;
        folder.compresses = plan.gzip;
        Ok(Self { folder, plan, cache: None })
    }

    /// Opens a run's folder for what `manifest` says of the program and the machine, which may be others than these.
    pub(super) fn open_for(plan: Plan, manifest: Manifest, folder: &Path, fresh: bool) -> Result<Self, MeasureError> {
        let manifest = Manifest { rows: BTreeMap::new(), noise: Vec::new(), ..manifest };
        let mut folder = Folder::open(folder, manifest.clone(), fresh)?;
        folder.manifest = manifest;
        folder.compresses = plan.gzip;
        Ok(Self { folder, plan, cache: None })
    }

    /// Removes the units of a stage.
    pub(super) fn clear(&self, stage: Stage) -> Result<(), MeasureError> {
        Ok(self.folder.drop_units(&[stage_folder(stage)])?)
    }

    /// Joins a run that the parent process has opened, to carry out a launch of it.
    ///
    /// # Errors
    /// When the folder holds no run of this plan.
    pub fn join_parent(plan: Plan, folder: &Path) -> Result<Self, MeasureError> {
        Ok(Self { folder: Folder::join_parent(folder, &plan.manifest())?, plan, cache: None })
    }

    /// The same run with a place where exact answers are kept.
    pub fn with_cache(mut self, cache: TruthCache) -> Self {
        self.cache = Some(cache);
        self
    }

    /// The run's folder.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// What is known of the run so far.
    pub const fn manifest(&self) -> &Manifest {
        &self.folder.manifest
    }

    /// What is being carried out.
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Whether a stage is finished.
    pub fn has_finished(&self, stage: Stage) -> bool {
        self.folder.has_finished(stage)
    }

    /// Whether the folder was made by this program with the binaries of the plan.
    pub fn is_own(&self) -> bool {
        let (made, own) = (&self.manifest().binaries, self.plan.binary_entries());
        let is_one = made.iter().map(|binary| &binary.hash).eq(own.iter().map(|binary| &binary.hash));
        is_one && self.folder.is_of(&environment::program())
    }

    /// Whether the folder is a shard's that has finished a stage: it is not made again.
    fn is_whole_shard(&self, stage: Stage) -> bool {
        self.plan.shard.is_some() && self.has_finished(stage)
    }

    /// Joins the units of a stage into its tables, or, of a shard, seals and keeps them, and notes that the stage is finished.
    pub(super) fn end(&mut self, stage: Stage) -> Result<(), MeasureError> {
        if self.plan.shard.is_some() {
            self.folder.seal_units(&[stage_folder(stage)])?;
            return Ok(self.folder.finish(stage)?);
        }
        match stage {
            Stage::Verify => self.join_verdicts()?,
            Stage::Measure => self.join_measured()?,
            Stage::Analyze | Stage::Plot | Stage::Report => {}
        }
        self.finish(stage)
    }

    /// Takes the units of a stage from another folder.
    pub(super) fn take_units(&self, other: &Path, stage: Stage) -> Result<(), MeasureError> {
        Ok(self.folder.take_units(other, &[stage_folder(stage)])?)
    }

    /// Starts a stage: a finished one is made again from nothing, an interrupted one goes on.
    fn start(&mut self, stage: Stage) -> Result<(), MeasureError> {
        if !self.has_finished(stage) {
            return self.folder.begin(stage);
        }
        let stages: Vec<Stage> = [Stage::Verify, Stage::Measure].into_iter().filter(|&of| of >= stage).collect();
        let raw: Vec<&str> = stages.iter().flat_map(|&stage| raw_files(stage)).collect();
        let units: Vec<&str> = stages.iter().map(|&stage| stage_folder(stage)).collect();
        self.folder.manifest.binaries = self.plan.binary_entries();
        self.folder.begin_again(stage, &raw, &units)
    }

    /// Notes that a stage is finished.
    ///
    /// # Errors
    /// When the manifest cannot be written.
    pub fn finish(&mut self, stage: Stage) -> Result<(), MeasureError> {
        self.folder.finish(stage)?;
        Ok(self.folder.drop_units(&[stage_folder(stage)])?)
    }

    /// Compares the triangle tests with their integer twin, verifies every case on every scene, and writes `verification.csv`.
    ///
    /// # Errors
    /// When poses cannot be judged or files cannot be written.
    pub fn verify(&mut self, progress: &dyn Progress) -> Result<Verification, MeasureError> {
        if !self.is_whole_shard(Stage::Verify) {
            self.start(Stage::Verify)?;
            self.cross_check(progress)?;
            for scene in &self.plan.scenes {
                self.verify_scene(scene, progress)?;
            }
            self.end(Stage::Verify)?;
        }
        self.verification()
    }

    /// Compares the triangle tests with their integer twin, unless that is done or another shard's.
    fn cross_check(&self, progress: &dyn Progress) -> Result<(), MeasureError> {
        let unit = self.cross_check_unit();
        if unit.exists() || !self.plan.has_unit(0, 1) {
            return Ok(());
        }
        progress.begin("triangle tests against their integer twin", 1);
        let check = cross_check(self.plan.selection.seed, self.plan.budget.cross_check_pairs);
        let entry = CrossCheckEntry {
            pairs: check.pairs,
            touching: check.touching,
            degenerate: check.degenerate,
            disagreements: check.disagreements,
        };
        write_unit(&unit, |folder| write_json(&folder.join(CROSS_CHECK_FILE), &entry))?;
        Ok(())
    }

    /// Verifies what a scene lacks.
    fn verify_scene(&self, scene: &Scene, progress: &dyn Progress) -> Result<(), MeasureError> {
        let mut lacking = self.verify_units(scene, true);
        lacking.retain(|(_, unit)| !unit.exists());
        if lacking.is_empty() {
            return Ok(());
        }
        let (poses, cache) = (self.plan.budget.verify_poses, self.cache.as_ref());
        let judged = judged::judge(&self.plan, scene, poses, judged::Strata::NotSought, cache, progress)?;
        if let Some((_, unit)) = lacking.iter().find(|(case, _)| case.is_none()) {
            let lines = accuracy::lines(scene, &judged, self.plan.budget.asked_poses);
            write_unit(unit, |folder| write_rows(folder, &lines))?;
        }
        let cases = lacking.into_iter().filter_map(|(case, unit)| Some((case?, unit))).collect();
        Ok(accuracy::verify_cases(&self.plan, scene, &judged, cases, progress)?)
    }

    fn cross_check_unit(&self) -> PathBuf {
        self.folder.unit(&[stage_folder(Stage::Verify), CROSS_CHECK])
    }

    /// Units of a scene's verification: its lines, without a case, then its cases; those of the shard alone, or all.
    fn verify_units(&self, scene: &Scene, of_shard: bool) -> Vec<(Option<&Case>, PathBuf)> {
        let cases = accuracy::verified_cases(&self.plan);
        let of_scene = 1 + cases.len();
        let place = self.plan.scenes.iter().position(|other| other.name == scene.name).unwrap_or_default();
        let places = of_scene * self.plan.scenes.len();
        let is_own = |number: usize| !of_shard || self.plan.has_unit(place * of_scene + number, places);
        let named = |number: usize| if number == 0 { "lines".to_owned() } else { format!("case-{number}") };
        let unit =
            |number: usize| self.folder.unit(&[stage_folder(Stage::Verify), "scenes", &scene.name, &named(number)]);
        let cases = std::iter::once(None).chain(cases.into_iter().map(Some)).enumerate();
        cases.filter(|&(number, _)| is_own(number)).map(|(number, case)| (case, unit(number))).collect()
    }

    fn join_verdicts(&mut self) -> Result<(), MeasureError> {
        let units = self.plan.scenes.iter().flat_map(|scene| self.verify_units(scene, false));
        let (cases, lines): (Vec<_>, Vec<_>) = units.partition(|(case, _)| case.is_some());
        let paths = |units: Vec<(Option<&Case>, PathBuf)>| units.into_iter().map(|(_, unit)| unit).collect();
        let (cases, lines): (Vec<PathBuf>, Vec<PathBuf>) = (paths(cases), paths(lines));
        self.folder.join(&VERDICTS, &cases)?;
        self.folder.join(&LINES, &lines)?;
        self.folder.put(&self.plan.case_rows())?;
        self.folder.manifest.cross_check = Some(read_json(&self.cross_check_unit().join(CROSS_CHECK_FILE))?);
        Ok(())
    }

    /// The finished verification; of a shard, its part.
    ///
    /// # Errors
    /// When its records cannot be read.
    pub fn verification(&self) -> Result<Verification, MeasureError> {
        if self.plan.shard.is_none() {
            let cross_check = self.manifest().cross_check.unwrap_or_default();
            return Ok(Verification { rows: read_rows(self.folder())?, cross_check });
        }
        let mut rows = Vec::new();
        for (_, unit) in self.plan.scenes.iter().flat_map(|scene| self.verify_units(scene, true)) {
            rows.extend(read_rows_if_there(&unit)?);
        }
        let check = self.cross_check_unit().join(CROSS_CHECK_FILE);
        let cross_check = if check.exists() { read_json(&check)? } else { CrossCheckEntry::default() };
        Ok(Verification { rows, cross_check })
    }

    /// Counts, describes and times every case on every scene and writes the remaining raw CSV files. `launcher` carries out
    /// launches in processes of their own; a single launch is made in this one.
    ///
    /// # Errors
    /// When poses cannot be judged, a launch fails, or files cannot be written.
    pub fn measure(&mut self, launcher: Launcher<'_>, progress: &dyn Progress) -> Result<(), MeasureError> {
        if self.is_whole_shard(Stage::Measure) {
            return Ok(());
        }
        self.start(Stage::Measure)?;
        self.count(progress)?;
        self.time(launcher, progress)?;
        self.end(Stage::Measure)
    }

    /// Counts and describes every scene that lacks it.
    fn count(&self, progress: &dyn Progress) -> Result<(), MeasureError> {
        for (place, scene) in self.plan.scenes.iter().enumerate() {
            let unit = self.count_unit(scene);
            if self.plan.has_unit(place, self.plan.scenes.len()) && !unit.exists() {
                let measured = Measured::choose(&self.plan, scene, self.cache.as_ref(), progress)?;
                let rows = counts::count_scene(&self.plan, scene, &measured, progress);
                let exits = exits::count_scene(&self.plan, scene, &measured.judged, &measured.chunks, progress);
                let shapes = shape::describe_scene(&self.plan, scene, progress);
                write_unit(&unit, |folder| {
                    write_rows(folder, &measured.rows(scene))?;
                    write_rows(folder, &rows)?;
                    write_rows(folder, &exits)?;
                    write_rows(folder, &shapes.trees)?;
                    write_rows(folder, &shapes.tightness)?;
                    write_rows(folder, &shapes.outlines)
                })?;
            }
        }
        Ok(())
    }

    /// Carries out the launches that lack something.
    fn time(&mut self, launcher: Launcher<'_>, progress: &dyn Progress) -> Result<(), MeasureError> {
        let launches = self.plan.budget.launches;
        let own = (0..launches).filter(|&launch| self.plan.has_unit(launch as usize, launches as usize));
        let own: Vec<u32> = own.collect();
        if own.is_empty() {
            return Ok(());
        }
        self.note_machine()?;
        for launch in own {
            if self.plan.scenes.iter().all(|scene| self.time_unit(launch, scene).exists()) {
                continue;
            }
            if launches == 1 && self.plan.binaries.is_empty() {
                self.time_launch(launch, progress)?;
            } else {
                launcher(launch).map_err(|cause| MeasureError::Launch { launch, cause })?;
            }
        }
        Ok(())
    }

    /// Notes with what and on what machine it is timed; a run that another kind of machine has begun to time is not mixed.
    fn note_machine(&mut self) -> Result<(), MeasureError> {
        let here = environment::machine();
        let begun = &self.folder.manifest.machine;
        if self.time_units().iter().any(|unit| unit.exists()) && !begun.is_alike(&here) {
            let named = |machine: &MachineFacts| format!("{}, {}, {} cores", machine.cpu, machine.simd, machine.cores);
            let (begun, here) = (named(begun), named(&here));
            return Err(MeasureError::AnotherMachine { folder: self.folder().to_owned(), begun, here });
        }
        self.folder.manifest.machine = here;
        self.folder.manifest.binaries = self.plan.binary_entries();
        self.folder.manifest.clock = Some(timer::clock());
        self.folder.manifest.cold = (self.plan.budget.cold_poses > 0).then(single::eviction);
        Ok(self.folder.save()?)
    }

    fn join_measured(&mut self) -> Result<(), MeasureError> {
        self.folder.put(&self.plan.case_rows())?;
        let (counts, times) = (self.count_units(), self.time_units());
        self.folder.join(&COUNTS, &counts)?;
        self.folder.join(&TIMES, &times)?;
        self.folder.manifest.noise = self.noise()?;
        Ok(())
    }

    /// Whether the binary that is running is the one whose turn a launch is.
    ///
    /// # Errors
    /// When it is not.
    pub fn check_binary(&self, launch: u32) -> Result<(), MeasureError> {
        let turn = binaries::binary_of(launch, self.plan.budget.binaries);
        let expected = self.manifest().binaries.get(turn as usize);
        let running = binaries::running();
        match (expected, running) {
            (Some(expected), Some(running)) if expected.hash != running.hash => {
                let (running, expected) = (running.file, expected.file.clone());
                Err(MeasureError::AnotherBinary { launch, running, expected })
            }
            _ => Ok(()),
        }
    }

    /// One timing launch: every scene's chunks and builds, unit by unit.
    ///
    /// # Errors
    /// When poses cannot be judged or files cannot be written.
    pub fn time_launch(&self, launch: u32, progress: &dyn Progress) -> Result<(), MeasureError> {
        for scene in &self.plan.scenes {
            let unit = self.time_unit(launch, scene);
            if unit.exists() {
                continue;
            }
            let chunks = Measured::choose(&self.plan, scene, self.cache.as_ref(), &super::Silent)?.timed();
            let what = format!("{}: timing, launch {} of {}", scene.name, launch + 1, self.plan.budget.launches);
            progress.begin(&what, query::visits(&self.plan, &chunks));
            let before = environment::BusyMeter::read();
            let (builds, built) = build::time_builds(&self.plan, scene, launch, progress);
            let cases = query::timed_cases(&self.plan, scene, built);
            let timings = query::time_scene(&self.plan, scene, &cases, &chunks, launch, progress);
            let singles = single::time_scene(&self.plan, scene, &cases, &chunks, launch, progress);
            let disturbance =
                environment::BusyMeter::read().zip(before).and_then(|(after, before)| after.since(&before));
            let complaint = disturbance.and_then(|disturbance| disturbance.complaint());
            let noise = complaint.map_or_else(String::new, |text| format!("{}, launch {launch}: {text}\n", scene.name));
            write_unit(&unit, |folder| {
                write_rows(folder, &timings)?;
                write_rows(folder, &builds)?;
                write_rows(folder, &singles)?;
                write_text(&folder.join(NOISE_FILE), &noise)
            })?;
        }
        Ok(())
    }

    /// What the launches complained about.
    fn noise(&self) -> Result<Vec<String>, MeasureError> {
        let mut complaints = Vec::new();
        for unit in self.time_units() {
            let path = unit.join(NOISE_FILE);
            let text = read_text(&path)?;
            complaints.extend(text.lines().map(str::to_owned));
        }
        Ok(complaints)
    }

    fn count_unit(&self, scene: &Scene) -> PathBuf {
        self.folder.unit(&[stage_folder(Stage::Measure), "counts", &scene.name])
    }

    fn time_unit(&self, launch: u32, scene: &Scene) -> PathBuf {
        self.folder.unit(&[stage_folder(Stage::Measure), &format!("launch-{launch}"), &scene.name])
    }

    fn count_units(&self) -> Vec<PathBuf> {
        self.plan.scenes.iter().map(|scene| self.count_unit(scene)).collect()
    }

    fn time_units(&self) -> Vec<PathBuf> {
        let launches = 0..self.plan.budget.launches;
        launches.flat_map(|launch| self.plan.scenes.iter().map(move |scene| self.time_unit(launch, scene))).collect()
    }
}

/// What the verification of a case writes.
const VERDICTS: [RawTable; 2] = [RawTable::of::<VerificationRow>(), RawTable::of::<MissRow>()];

/// What the verification of a scene writes beside its cases.
const LINES: [RawTable; 1] = [RawTable::of::<LineRow>()];

/// What counting and describing a scene writes.
const COUNTS: [RawTable; 6] = [
    RawTable::of::<PoseRow>(),
    RawTable::of::<AnswerRow>(),
    RawTable::of::<ExitRow>(),
    RawTable::of::<TreeRow>(),
    RawTable::of::<TightnessRow>(),
    RawTable::of::<OutlineRow>(),
];

/// What timing a scene writes.
const TIMES: [RawTable; 3] = [RawTable::of::<TimingRow>(), RawTable::of::<BuildRow>(), RawTable::of::<SingleRow>()];

/// The files of raw rows that a stage writes.
fn raw_files(stage: Stage) -> Vec<&'static str> {
    let tables: &[&[RawTable]] = match stage {
        Stage::Verify => &[&VERDICTS, &LINES],
        Stage::Measure => &[&COUNTS, &TIMES],
        Stage::Analyze | Stage::Plot | Stage::Report => return Vec::new(),
    };
    tables.iter().flat_map(|tables| tables.iter().map(|table| table.file)).chain([CaseRow::FILE]).collect()
}

/// The folder of a stage's units.
pub(super) const fn stage_folder(stage: Stage) -> &'static str {
    match stage {
        Stage::Verify => "verify",
        Stage::Measure => "measure",
        Stage::Analyze | Stage::Plot | Stage::Report => "derived",
    }
}
