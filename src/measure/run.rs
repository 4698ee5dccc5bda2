//! The reference study, a run: its stages, and which rows each unit writes. The folder and its units are those of `super::folder`.
//!
//! Units are the verification of a scene, the counts of a scene, and the timings of a scene in one launch.

use super::folder::{self, Folder, RawTable, write_unit};
use super::judged::{self, JudgeError};
use super::measured::Measured;
use super::plan::Plan;
use super::{Progress, accuracy, binaries, build, counts, environment, exits, query, shape, single, timer};
use crate::geometry::cross_check::cross_check;
use crate::record::manifest::{CrossCheckEntry, Stage};
use crate::record::{
    AnswerRow, BuildRow, CaseRow, ExitRow, LineRow, Manifest, MissRow, OutlineRow, PoseRow, RecordError, Row,
    SingleRow, TightnessRow, TimingRow, TreeRow, VerificationRow, read_rows, read_text, write_rows, write_text,
};
use crate::scene::Scene;
use crate::truth::TruthCache;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// File of a timing unit: one complaint about noise per line.
const NOISE_FILE: &str = "noise.txt";

/// Why a run could not be opened or carried on.
#[derive(Debug, Error)]
pub enum MeasureError {
    /// A file could not be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The poses could not be judged.
    #[error(transparent)]
    Judge(#[from] JudgeError),
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
        accuracy::broken_promises(&self.rows)
    }

    /// Whether every promise is kept and the exact test can be trusted.
    #[must_use]
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

    /// Joins a run that the parent process has opened, to carry out a launch of it.
    ///
    /// # Errors
    /// When the folder holds no run of this plan.
    pub fn join_parent(plan: Plan, folder: &Path) -> Result<Self, MeasureError> {
        Ok(Self { folder: Folder::join_parent(folder, &plan.manifest())?, plan, cache: None })
    }

    /// The same run with a place where exact answers are kept.
    #[must_use]
    pub fn with_cache(mut self, cache: TruthCache) -> Self {
        self.cache = Some(cache);
        self
    }

    /// The run's folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// What is known of the run so far.
    #[must_use]
    pub const fn manifest(&self) -> &Manifest {
        &self.folder.manifest
    }

    /// What is being carried out.
    #[must_use]
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Whether a stage is finished.
    #[must_use]
    pub fn has_finished(&self, stage: Stage) -> bool {
        self.folder.has_finished(stage)
    }

    /// Starts a stage: a finished one is made again from nothing, an interrupted one goes on.
    fn start(&mut self, stage: Stage) -> Result<(), MeasureError> {
        if self.has_finished(stage) {
            self.folder.begin_again(stage, &raw_files(stage), stage_folder(stage))?;
        }
        Ok(())
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
        self.start(Stage::Verify)?;
        progress.begin("triangle tests against their integer twin", 1);
        let check = cross_check(self.plan.selection.seed, self.plan.budget.cross_check_pairs);
        let poses = self.plan.budget.verify_poses;
        let unit_of = |scene: &Scene| self.folder.unit(&[stage_folder(Stage::Verify), &scene.name]);
        for scene in &self.plan.scenes {
            let unit = unit_of(scene);
            if !unit.exists() {
                let judged =
                    judged::judge(&self.plan, scene, poses, judged::Strata::NotSought, self.cache.as_ref(), progress)?;
                let of_cases = unit.with_file_name(format!("{}.cases", scene.name));
                let verdicts = accuracy::verify_scene(&self.plan, scene, &judged, &of_cases, progress)?;
                write_unit(&unit, |folder| {
                    write_rows(folder, &verdicts.rows)?;
                    write_rows(folder, &verdicts.lines)?;
                    write_rows(folder, &verdicts.misses)
                })?;
                folder::remove(&of_cases)?;
            }
        }
        let units: Vec<PathBuf> = self.plan.scenes.iter().map(unit_of).collect();
        self.folder.join(&VERDICTS, &units)?;
        self.folder.put(&self.plan.case_rows())?;
        self.folder.manifest.cross_check = Some(CrossCheckEntry {
            pairs: check.pairs,
            touching: check.touching,
            degenerate: check.degenerate,
            disagreements: check.disagreements,
        });
        self.finish(Stage::Verify)?;
        self.verification()
    }

    /// The finished verification.
    ///
    /// # Errors
    /// When its records cannot be read.
    pub fn verification(&self) -> Result<Verification, MeasureError> {
        let cross_check = self.manifest().cross_check.unwrap_or_default();
        Ok(Verification { rows: read_rows(self.folder())?, cross_check })
    }

    /// Counts, describes and times every case on every scene and writes the remaining raw CSV files. `launcher` carries out
    /// launches in processes of their own; a single launch is made in this one.
    ///
    /// # Errors
    /// When poses cannot be judged, a launch fails, or files cannot be written.
    pub fn measure(&mut self, launcher: Launcher<'_>, progress: &dyn Progress) -> Result<(), MeasureError> {
        self.start(Stage::Measure)?;
        self.folder.manifest.binaries = self.plan.binary_entries();
        self.folder.manifest.clock = Some(timer::clock());
        self.folder.manifest.cold = (self.plan.budget.cold_poses > 0).then(single::eviction);
        self.folder.save()?;
        for scene in &self.plan.scenes {
            let unit = self.count_unit(scene);
            if !unit.exists() {
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
        let launches = self.plan.budget.launches;
        for launch in 0..launches {
            if self.plan.scenes.iter().all(|scene| self.time_unit(launch, scene).exists()) {
                continue;
            }
            if launches == 1 && self.plan.binaries.is_empty() {
                self.time_launch(launch, progress)?;
            } else {
                launcher(launch).map_err(|cause| MeasureError::Launch { launch, cause })?;
            }
        }
        self.folder.put(&self.plan.case_rows())?;
        let (counts, times) = (self.count_units(), self.time_units());
        self.folder.join(&COUNTS, &counts)?;
        self.folder.join(&TIMES, &times)?;
        self.folder.manifest.noise = self.noise()?;
        self.finish(Stage::Measure)
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
            let blocks = u64::from(self.plan.budget.blocks + 1);
            let what = format!("{}: timing, launch {} of {}", scene.name, launch + 1, self.plan.budget.launches);
            progress.begin(&what, blocks * chunks.len() as u64);
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

/// What the verification of a scene writes.
const VERDICTS: [RawTable; 3] =
    [RawTable::of::<VerificationRow>(), RawTable::of::<LineRow>(), RawTable::of::<MissRow>()];

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
        Stage::Verify => &[&VERDICTS],
        Stage::Measure => &[&COUNTS, &TIMES],
        Stage::Analyze | Stage::Plot | Stage::Report => return Vec::new(),
    };
    tables.iter().flat_map(|tables| tables.iter().map(|table| table.file)).chain([CaseRow::FILE]).collect()
}

const fn stage_folder(stage: Stage) -> &'static str {
    match stage {
        Stage::Verify => "verify",
        Stage::Measure => "measure",
        Stage::Analyze | Stage::Plot | Stage::Report => "derived",
    }
}
