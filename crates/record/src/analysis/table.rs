//! The observations in a form for computation: names interned, rows grouped once by scene and case, and sorted by their pairing key. Two
//! cases are paired by merging their sorted lists, so the order of rows in the files has no influence.

use super::stats::median;
use super::summary::Cell;
use super::totals::{self, Binaries, Estimate, Observation, Totals};
use super::{AnalysisError, grouped};
use crate::record::manifest::{Manifest, Request};
use crate::record::rows::CaseKey;
use crate::record::{
    AnswerRow, BuildRow, CONTROL_WORKLOAD, Cache, CaseRow, PROGRAM_TIME, PoseRow, RECORDED, Row, SingleRow, Stratum,
    TimingRow, for_each_row, has_rows, read_rows,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// All observations of one scene.
#[derive(Debug, Default)]
pub struct Scene {
    /// Chunks by number.
    pub chunks: BTreeMap<u32, Chunk>,
    /// Timed chunks by case, sorted by (launch, block, chunk).
    pub timings: BTreeMap<CaseKey, Vec<Sample>>,
    /// Counted queries by case, sorted by pose.
    pub queries: BTreeMap<CaseKey, Vec<Query>>,
    /// Timed constructions by case, sorted by (launch, block, part).
    pub builds: BTreeMap<CaseKey, Vec<Sample>>,
    /// Readings of single queries by case, sorted by (cache, pose, launch).
    pub singles: BTreeMap<CaseKey, Vec<Single>>,
    /// Number of launches seen in timings or builds: 1 + the largest number of a launch.
    pub launches: usize,
    /// The binary that each launch ran.
    pub binaries: Binaries,
    /// The chunk and the line of each pose.
    poses: BTreeMap<u32, (u32, u32)>,
    /// Numbers of the parts, by name; `Sample::item` of a build is such a number.
    parts: BTreeMap<String, u32>,
}

/// Properties of a chunk, from its poses.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Chunk {
    /// Workload of all its poses.
    pub workload: String,
    /// Name of the program if the chunk is a whole program; otherwise empty.
    pub program: String,
    /// The pair of parts, from the first pose.
    pub pair: String,
    /// Stratum of all its poses; for a program, the stratum of the first pose.
    pub stratum: Stratum,
    /// Number of the first pose within its pair and workload.
    pub first_step: u32,
    /// Number of poses.
    pub poses: u32,
    /// Number of poses of its workload that were judged, of its pair and stratum; `None` where the records do not have it.
    pub judged: Option<u32>,
    /// Whether the last pose of the chunk touches; for a program, whether it ends in a collision.
    pub ends_in_contact: bool,
    /// Number of its cluster; chunks that share a line are in the same cluster.
    pub cluster: u32,
    /// Whether the cluster has chunks in other strata.
    pub spans_strata: bool,
}

impl Chunk {
    /// Whether the chunk is a whole program.
    pub fn is_program(&self) -> bool {
        self.workload == PROGRAM_TIME
    }

    /// Whether the chunk is one of the single poses on which the exhaustive control ran.
    pub fn is_control(&self) -> bool {
        self.workload == CONTROL_WORKLOAD
    }

    /// The chunk without the numbers that another version of the program may assign differently, or not record.
    fn held(&self) -> Self {
        Self { cluster: 0, spans_strata: false, judged: None, ..self.clone() }
    }
}

/// One timing: a chunk of queries, or the construction of a part's tree.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Launch.
    pub launch: u32,
    /// Block.
    pub block: u32,
    /// Chunk or part.
    pub item: u32,
    /// Time of one query or construction, ns.
    pub ns: f64,
}

/// One reading over a single query.
#[derive(Clone, Copy, Debug)]
pub struct Single {
    /// State of the caches at the start of the query.
    pub cache: Cache,
    /// Its pose.
    pub pose: u32,
    /// The chunk that the pose belongs to.
    pub chunk: u32,
    /// Launch.
    pub launch: u32,
    /// The reading, ns.
    pub ns: f64,
}

/// One counted query.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// Its pose.
    pub pose: u32,
    /// The chunk that the pose belongs to.
    pub chunk: u32,
    /// The line that the pose lies on, unique in the scene.
    pub line: u32,
    /// Stratum.
    pub stratum: Stratum,
    /// The case's verdict.
    pub touches: bool,
    /// Volume tests.
    pub volume_tests: u64,
    /// Triangle tests.
    pub triangle_tests: u64,
}

/// Which operations of a query are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counter {
    /// Volume overlap tests.
    Volume,
    /// Triangle tests.
    Triangle,
}

impl Query {
    /// The count asked for.
    pub const fn count(&self, counter: Counter) -> u64 {
        match counter {
            Counter::Volume => self.volume_tests,
            Counter::Triangle => self.triangle_tests,
        }
    }
}

/// Reads poses, timings, answers and builds of a run's folder, by scene.
///
/// # Errors
/// When one of the files is missing or malformed, or contradicts another or the request in the manifest.
pub fn read(folder: &Path) -> Result<BTreeMap<String, Scene>, AnalysisError> {
    let cases = read_rows::<CaseRow>(folder)?.into_iter().map(|row| (row.case.clone(), row.case())).collect();
    let request = Manifest::read(folder)?.request;
    let mut reading = Reading { cases, request, lines: BTreeMap::new(), scenes: BTreeMap::new(), wrong: None };
    for_each_row(folder, |row| {
        reading.add_pose(row);
        Ok(())
    })?;
    for_each_row(folder, |row| reading.add_timing(row))?;
    for_each_row(folder, |row| {
        reading.add_answer(row);
        Ok(())
    })?;
    if has_rows::<SingleRow>(folder) {
        for_each_row(folder, |row| reading.add_single(row))?;
    }
    for_each_row(folder, |row| reading.add_build(row))?;
    if let Some(error) = reading.wrong {
        return Err(error);
    }
    for (name, scene) in &mut reading.scenes {
        scene.sort(name)?;
    }
    Ok(reading.scenes)
}

/// The scenes as far as they have been read.
struct Reading {
    cases: BTreeMap<String, CaseKey>,
    request: Request,
    /// Numbers of lines by scene, workload, pair and line.
    lines: BTreeMap<(String, String, String, u32), u32>,
    scenes: BTreeMap<String, Scene>,
    /// The error of the first row that contradicts rows before it.
    wrong: Option<AnalysisError>,
}

impl Reading {
    fn add_pose(&mut self, row: PoseRow) {
        if !self.scenes.entry(row.scene.clone()).or_default().add_pose(&row, &mut self.lines) {
            self.wrong.get_or_insert(AnalysisError::Pose { scene: row.scene, pose: row.pose });
        }
    }

    fn add_timing(&mut self, row: TimingRow) -> Result<(), &'static str> {
        self.check_launch(row.launch)?;
        if row.block >= self.request.blocks {
            return Err("a launch has fewer blocks (manifest.json)");
        }
        let scene = self.scenes.entry(row.scene.clone()).or_default();
        let (Some(case), Some(chunk)) = (self.cases.get(&row.case), scene.chunks.get(&row.chunk)) else {
            self.note_unknown(TimingRow::FILE, row.scene, format!("case `{}` or chunk {}", row.case, row.chunk));
            return Ok(());
        };
        let ns = row.ns as f64 / (f64::from(chunk.poses) * f64::from(row.passes));
        let sample = Sample { launch: row.launch, block: row.block, item: row.chunk, ns };
        scene.timings.entry(case.clone()).or_default().push(sample);
        scene.launches = scene.launches.max(row.launch as usize + 1);
        self.note_binary(row.scene, row.launch, row.binary);
        Ok(())
    }

    fn add_answer(&mut self, row: AnswerRow) {
        let scene = self.scenes.entry(row.scene.clone()).or_default();
        let (Some(case), Some(&(chunk, line))) = (self.cases.get(&row.case), scene.poses.get(&row.pose)) else {
            self.note_unknown(AnswerRow::FILE, row.scene, format!("case `{}` or pose {}", row.case, row.pose));
            return;
        };
        let AnswerRow { pose, volume_tests, triangle_tests, .. } = row;
        let (stratum, touches) = (scene.chunks[&chunk].stratum, row.verdict == 1);
        let query = Query { pose, chunk, line, stratum, touches, volume_tests, triangle_tests };
        scene.queries.entry(case.clone()).or_default().push(query);
    }

    fn add_single(&mut self, row: SingleRow) -> Result<(), &'static str> {
        self.check_launch(row.launch)?;
        let scene = self.scenes.entry(row.scene.clone()).or_default();
        let (Some(case), Some(&(chunk, _))) = (self.cases.get(&row.case), scene.poses.get(&row.pose)) else {
            self.note_unknown(SingleRow::FILE, row.scene, format!("case `{}` or pose {}", row.case, row.pose));
            return Ok(());
        };
        let SingleRow { cache, pose, launch, ns, .. } = row;
        scene.singles.entry(case.clone()).or_default().push(Single { cache, pose, chunk, launch, ns: ns as f64 });
        self.note_binary(row.scene, launch, row.binary);
        Ok(())
    }

    fn add_build(&mut self, row: BuildRow) -> Result<(), &'static str> {
        self.check_launch(row.launch)?;
        let (case, scene) = (row.case(), self.scenes.entry(row.scene.clone()).or_default());
        let item = intern(&mut scene.parts, row.part);
        let sample = Sample { launch: row.launch, block: row.block, item, ns: row.ns as f64 };
        scene.builds.entry(case).or_default().push(sample);
        scene.launches = scene.launches.max(row.launch as usize + 1);
        self.note_binary(row.scene, row.launch, row.binary);
        Ok(())
    }

    /// Launches number cells of memory, so each is compared with the request before it is used.
    const fn check_launch(&self, launch: u32) -> Result<(), &'static str> {
        if launch < self.request.launches { Ok(()) } else { Err("the run has fewer launches (manifest.json)") }
    }

    fn note_binary(&mut self, scene: String, launch: u32, binary: u32) {
        if !self.scenes.entry(scene.clone()).or_default().binaries.note(launch, binary) {
            self.wrong.get_or_insert(AnalysisError::Binary { scene, launch });
        }
    }

    fn note_unknown(&mut self, file: &'static str, scene: String, what: String) {
        self.wrong.get_or_insert(AnalysisError::Unknown { file, scene, what });
    }
}

fn intern<K: Ord>(numbers: &mut BTreeMap<K, u32>, key: K) -> u32 {
    let next = u32::try_from(numbers.len()).expect("fewer than 2^32 names");
    *numbers.entry(key).or_insert(next)
}

/// For each number given in order of appearance, the rank of its name among the sorted names.
fn ranks<K: Ord>(numbers: &BTreeMap<K, u32>) -> Vec<u32> {
    let mut ranks = vec![0; numbers.len()];
    for (rank, &number) in (0..).zip(numbers.values()) {
        ranks[number as usize] = rank;
    }
    ranks
}

impl Scene {
    /// Adds a pose to its chunk; `false` when it contradicts the chunk, or was added before.
    fn add_pose(&mut self, row: &PoseRow, lines: &mut BTreeMap<(String, String, String, u32), u32>) -> bool {
        let line = intern(lines, (row.scene.clone(), row.workload.clone(), row.pair.clone(), row.line));
        if self.poses.insert(row.pose, (row.chunk, line)).is_some() {
            return false;
        }
        let new = || Chunk {
            workload: row.workload.clone(),
            program: row.program.clone(),
            pair: row.pair.clone(),
            stratum: row.stratum,
            first_step: row.step,
            poses: 0,
            judged: row.judged,
            ends_in_contact: false,
            cluster: row.chunk,
            spans_strata: false,
        };
        let chunk = self.chunks.entry(row.chunk).or_insert_with(new);
        chunk.poses += 1;
        chunk.ends_in_contact = row.exact == 1;
        let alike = chunk.workload == row.workload && chunk.program == row.program;
        alike && (chunk.is_program() || (chunk.stratum == row.stratum && chunk.pair == row.pair))
    }

    fn sort(&mut self, name: &str) -> Result<(), AnalysisError> {
        let parts = ranks(&self.parts);
        let twice = |case: &CaseKey, what: String| {
            Err(AnalysisError::Twice {
                scene: name.to_owned(),
                case: format!("{} {}", case.variant, case.policy()),
                what,
            })
        };
        self.builds.values_mut().flatten().for_each(|sample| sample.item = parts[sample.item as usize]);
        for (case, samples) in self.timings.iter_mut().chain(&mut self.builds) {
            samples.sort_by_key(Sample::key);
            if let Some(pair) = samples.windows(2).find(|pair| pair[0].key() == pair[1].key()) {
                let (launch, block, item) = pair[0].key();
                return twice(case, format!("launch {launch}, block {block}, chunk or part {item}"));
            }
        }
        for (case, queries) in &mut self.queries {
            queries.sort_by_key(Query::key);
            if let Some(pair) = queries.windows(2).find(|pair| pair[0].key() == pair[1].key()) {
                return twice(case, format!("pose {}", pair[0].pose));
            }
        }
        for (case, singles) in &mut self.singles {
            singles.sort_by_key(Single::key);
            if let Some(pair) = singles.windows(2).find(|pair| pair[0].key() == pair[1].key()) {
                return twice(case, format!("the single query at pose {} in launch {}", pair[0].pose, pair[0].launch));
            }
        }
        self.find_clusters();
        Ok(())
    }

    /// Gives chunks that share a line, directly or through others, the same cluster: the smallest of their numbers. Whole programs are not
    /// a sample of poses, so each stays a cluster of its own.
    fn find_clusters(&mut self) {
        let poses = self.poses.values().copied().filter(|(chunk, _)| !self.chunks[chunk].is_program());
        for (number, cluster) in totals::clusters(poses) {
            self.chunks.get_mut(&number).expect("its pose was read").cluster = cluster;
        }
        let mut strata: BTreeMap<u32, BTreeSet<Stratum>> = BTreeMap::new();
        self.chunks.values().for_each(|chunk| {
            strata.entry(chunk.cluster).or_default().insert(chunk.stratum);
        });
        self.chunks.values_mut().for_each(|chunk| chunk.spans_strata = strata[&chunk.cluster].len() > 1);
    }

    /// The workloads of the scene's chunks, each once, in order; whole programs are left out.
    pub fn workloads(&self) -> BTreeSet<&str> {
        self.chunks.values().filter(|chunk| !chunk.is_program()).map(|chunk| chunk.workload.as_str()).collect()
    }

    /// The programs that were timed as a whole: file and chunk.
    pub fn programs(&self) -> impl Iterator<Item = (&str, u32)> {
        let programs = self.chunks.iter().filter(|(_, chunk)| chunk.is_program());
        programs.map(|(&number, chunk)| (chunk.program.as_str(), number))
    }

    /// The weight of each of the chunks of a cell in sums over it. The pairs and strata of a recording are timed in equal shares. Over all its
    /// strata, a chunk therefore has the weight of the judged poses of its pair and stratum, divided by those in `chunks`. Elsewhere, and in
    /// records without that number, every weight is 1. Chunks of other cells are left out.
    pub fn weights(&self, cell: Cell<'_>, chunks: impl Iterator<Item = u32>) -> BTreeMap<u32, f64> {
        let known = chunks.filter_map(|number| Some((number, self.chunks.get(&number)?)));
        let within: BTreeMap<u32, &Chunk> = known.filter(|(_, chunk)| cell.has(chunk)).collect();
        let mut timed: BTreeMap<(&str, Stratum), u32> = BTreeMap::new();
        for chunk in within.values() {
            *timed.entry((chunk.pair.as_str(), chunk.stratum)).or_default() += chunk.poses;
        }
        let is_weighted = cell.workload == RECORDED && cell.stratum.is_none();
        let weight = |chunk: &Chunk| match chunk.judged.filter(|_| is_weighted) {
            Some(judged) => f64::from(judged) / f64::from(timed[&(chunk.pair.as_str(), chunk.stratum)]),
            None => 1.0,
        };
        within.iter().map(|(&number, chunk)| (number, weight(chunk))).collect()
    }

    /// The total query time of one case divided by that of another, over the chunks of a cell that both ran.
    pub fn time_ratio(&self, above: &CaseKey, below: &CaseKey, cell: Cell<'_>, seed: u64) -> Option<Estimate> {
        let (above, below) = (chunk_times(self.timings.get(above)?), chunk_times(self.timings.get(below)?));
        let both: Vec<_> = above.iter().filter_map(|(key, a)| Some((*key, *a, *below.get(key)?))).collect();
        let weights = self.weights(cell, both.iter().map(|((_, number), ..)| *number));
        let totals = Totals::of(both.into_iter().filter_map(|((launch, number), a, b)| {
            let (chunk, weight) = (self.chunks.get(&number)?, weights.get(&number)?);
            let poses = weight * f64::from(chunk.poses);
            Some(observation(chunk, launch, (a * poses, b * poses)))
        }))?;
        Some(totals.of_binaries(&self.binaries).estimate(seed, &format!("time {cell}")))
    }

    /// The mean query time of a case in a cell, ns.
    pub fn mean_time(&self, case: &CaseKey, cell: Cell<'_>, seed: u64) -> Option<Estimate> {
        let times = chunk_times(self.timings.get(case)?);
        let weights = self.weights(cell, times.keys().map(|(_, number)| *number));
        let totals = Totals::of(times.into_iter().filter_map(|((launch, number), ns)| {
            let (chunk, weight) = (self.chunks.get(&number)?, weights.get(&number)?);
            let poses = weight * f64::from(chunk.poses);
            Some(observation(chunk, launch, (ns * poses, poses)))
        }))?;
        Some(totals.of_binaries(&self.binaries).estimate(seed, &format!("mean {cell}")))
    }

    /// The total count of one case divided by that of another, over the poses of a cell at which both were queried. `None` for a case whose
    /// counts are all zero, because such a case does not count.
    pub fn count_ratio(
        &self,
        above: &CaseKey,
        below: &CaseKey,
        counter: Counter,
        cell: Cell<'_>,
        seed: u64,
    ) -> Option<Estimate> {
        let pairs = merge(self.queries.get(above)?, self.queries.get(below)?, Query::key);
        let pairs: Vec<_> = pairs.filter(|(query, _)| cell.has(&self.chunks[&query.chunk])).collect();
        let sum = |count: &dyn Fn(&(&Query, &Query)) -> u64| pairs.iter().map(count).sum::<u64>();
        if sum(&|(a, _)| a.count(counter)) == 0 || sum(&|(_, b)| b.count(counter)) == 0 {
            return None;
        }
        let weights = self.weights(cell, pairs.iter().map(|(query, _)| query.chunk));
        let totals = Totals::of(pairs.iter().map(|(a, b)| Observation {
            stratum: a.stratum as u32,
            cluster: a.line,
            launch: 0,
            numerator: weights[&a.chunk] * a.count(counter) as f64,
            denominator: weights[&a.chunk] * b.count(counter) as f64,
        }))?;
        Some(totals.estimate(seed, &format!("count {cell}")))
    }

    /// The total construction time of one case divided by that of another, over the parts that both built. A few parts are no sample:
    /// binaries are resampled, and blocks in a run of a single launch. Over several launches of one binary the interval is Student's, as
    /// for programs, because blocks of one launch are not independent.
    pub fn build_ratio(&self, above: &CaseKey, below: &CaseKey, seed: u64) -> Option<Estimate> {
        let pairs: Vec<_> = merge(self.builds.get(above)?, self.builds.get(below)?, Sample::key).collect();
        let several = self.binaries.launches().len() > 1;
        let by_launch = self.binaries.added_up(pairs.iter().map(|(a, b)| (a.launch, a.ns, b.ns)));
        if !several && by_launch.len() > 1 {
            return totals::over_launches(&by_launch);
        }
        let totals = Totals::of(pairs.into_iter().map(|(a, b)| Observation {
            stratum: 0,
            cluster: if several { self.binaries.of(a.launch) } else { a.block },
            launch: 0,
            numerator: a.ns,
            denominator: b.ns,
        }))?;
        Some(totals.estimate(seed, "build"))
    }

    /// Whether constructions were timed in several launches, so that their ratios are over launches or binaries.
    pub fn has_built_in_launches(&self) -> bool {
        let mut launches = self.builds.values().flatten().map(|sample| sample.launch);
        launches.next().is_some_and(|first| launches.any(|launch| launch != first))
    }

    /// The total time of a program, or of all programs, in each launch, ns: the median over the blocks of the launch. `None` when one of
    /// the programs was not timed.
    pub fn program_totals(&self, case: &CaseKey, program: Option<&str>) -> Option<Vec<f64>> {
        let wanted: Vec<u32> =
            self.programs().filter(|(file, _)| program.is_none_or(|p| p == *file)).map(|(_, chunk)| chunk).collect();
        let times = chunk_times(self.timings.get(case)?);
        let total = |launch: u32| {
            let of = wanted.iter().map(|chunk| {
                let ns = times.get(&(launch, *chunk))?;
                Some(ns * f64::from(self.chunks[chunk].poses))
            });
            of.sum::<Option<f64>>()
        };
        let totals: Option<Vec<f64>> = (0..self.launches as u32).map(total).collect();
        totals.filter(|totals| !wanted.is_empty() && !totals.is_empty())
    }

    /// The total time of a program, or of all programs, for one case divided by that for another.
    pub fn program_ratio(&self, above: &CaseKey, below: &CaseKey, program: Option<&str>) -> Option<Estimate> {
        let (above, below) = (self.program_totals(above, program)?, self.program_totals(below, program)?);
        let by_launch: Vec<(f64, f64)> = above.into_iter().zip(below).collect();
        totals::over_launches(&self.binaries.repeated(&by_launch))
    }

    /// The total time of the cold queries of a program, or of all programs, for one case divided by that for another, over the poses at
    /// which both were queried in a launch.
    pub fn cold_ratio(&self, above: &CaseKey, below: &CaseKey, program: Option<&str>) -> Option<Estimate> {
        let pairs = merge(self.singles.get(above)?, self.singles.get(below)?, Single::key);
        let is_wanted = |single: &Single| {
            let chunk = &self.chunks[&single.chunk];
            single.cache == Cache::Cold && program.is_none_or(|program| chunk.program == program)
        };
        let wanted = pairs.filter(|(a, _)| is_wanted(a)).map(|(a, b)| (a.launch, a.ns, b.ns));
        totals::over_launches(&self.binaries.added_up(wanted))
    }

    /// Whether the chunks of the two runs hold the same poses, so that their queries can be paired.
    pub fn has_poses_of(&self, other: &Self) -> bool {
        let held = |scene: &Self| scene.chunks.values().map(Chunk::held).collect::<BTreeSet<_>>();
        self.poses.keys().eq(other.poses.keys()) && held(self) == held(other)
    }

    /// A case's query time in this run over that in the run `before`, at the same poses: over all strata, then in each. Chunks are paired by
    /// launch, and matched by their content, because another version of the program may number them differently. The time of a chunk is the
    /// median over blocks in either run.
    pub fn time_changes(&self, before: &Self, case: &CaseKey) -> Vec<(Option<Stratum>, Totals)> {
        let (Some(after), Some(earlier)) = (self.timings.get(case), before.timings.get(case)) else {
            return Vec::new();
        };
        let earlier = chunk_times(earlier);
        let numbers: BTreeMap<Chunk, u32> =
            before.chunks.iter().map(|(&number, chunk)| (chunk.held(), number)).collect();
        let pairs = chunk_times(after).into_iter().filter_map(|((launch, number), ns)| {
            let chunk = self.chunks.get(&number).filter(|chunk| !chunk.is_program())?;
            let old = earlier.get(&(launch, *numbers.get(&chunk.held())?))?;
            let poses = f64::from(chunk.poses);
            Some((chunk.stratum, observation(chunk, launch, (ns * poses, old * poses))))
        });
        let pairs: Vec<(Stratum, Observation)> = pairs.collect();
        let totals = |wanted: Option<Stratum>| {
            let of = pairs.iter().filter(|(stratum, _)| wanted.is_none_or(|wanted| wanted == *stratum));
            Some((wanted, Totals::of(of.map(|(_, pair)| *pair))?.of_binaries(self.binaries_with(before))))
        };
        [None].into_iter().chain(Stratum::ALL.map(Some)).filter_map(totals).collect()
    }

    /// The total time of all programs for a case in this run over that in the run `before`, paired by launch.
    pub fn program_change(&self, before: &Self, case: &CaseKey) -> Option<Estimate> {
        let (after, earlier) = (self.program_totals(case, None)?, before.program_totals(case, None)?);
        let by_launch = (0..).zip(after.into_iter().zip(earlier)).map(|(launch, (n, d))| (launch, n, d));
        totals::over_launches(&self.binaries_with(before).added_up(by_launch))
    }

    /// A case's total construction time in this run over that in the run `before`, over the parts. Samples are paired by launch and block; the
    /// interval is over launches or binaries, because blocks of one launch are not independent.
    pub fn build_change(&self, before: &Self, case: &CaseKey) -> Option<Estimate> {
        if !self.parts.keys().eq(before.parts.keys()) {
            return None;
        }
        let pairs = merge(self.builds.get(case)?, before.builds.get(case)?, Sample::key);
        totals::over_launches(&self.binaries_with(before).added_up(pairs.map(|(a, b)| (a.launch, a.ns, b.ns))))
    }

    /// The binaries of this run, or of the run `before` where this one has a single binary.
    fn binaries_with<'a>(&'a self, before: &'a Self) -> &'a Binaries {
        if self.binaries.launches().len() > 1 { &self.binaries } else { &before.binaries }
    }

    /// The queries of a case that both runs have: (this run's, the other run's).
    pub fn both_queries<'a>(
        &'a self,
        before: &'a Self,
        case: &CaseKey,
    ) -> impl Iterator<Item = (&'a Query, &'a Query)> + use<'a> {
        let of = |scene: &'a Self| scene.queries.get(case).map_or(&[][..], Vec::as_slice);
        merge(of(self), of(before), Query::key)
    }
}

fn observation(chunk: &Chunk, launch: u32, (numerator, denominator): (f64, f64)) -> Observation {
    // Clusters that span strata are drawn as one.
    let stratum = if chunk.spans_strata { Stratum::ALL.len() as u32 } else { chunk.stratum as u32 };
    Observation { stratum, cluster: chunk.cluster, launch, numerator, denominator }
}

impl Sample {
    const fn key(&self) -> (u32, u32, u32) {
        (self.launch, self.block, self.item)
    }
}

impl Single {
    const fn key(&self) -> (Cache, u32, u32) {
        (self.cache, self.pose, self.launch)
    }
}

impl Query {
    const fn key(&self) -> u32 {
        self.pose
    }
}

/// The median over blocks for each launch and chunk, ns.
pub(super) fn chunk_times(samples: &[Sample]) -> BTreeMap<(u32, u32), f64> {
    let blocks = grouped(samples.iter().map(|sample| ((sample.launch, sample.item), sample.ns)));
    blocks.into_iter().map(|(key, ns)| (key, median(ns))).collect()
}

/// The elements of two sorted lists that have equal keys.
fn merge<'a, T, K: Ord>(a: &'a [T], b: &'a [T], key: impl Fn(&T) -> K) -> impl Iterator<Item = (&'a T, &'a T)> {
    let mut rest = b;
    a.iter().filter_map(move |left| {
        let skip = rest.iter().take_while(|right| key(right) < key(left)).count();
        rest = &rest[skip..];
        rest.first().filter(|right| key(right) == key(left)).map(|right| (left, right))
    })
}
