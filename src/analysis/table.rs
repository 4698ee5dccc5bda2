//! The observations in a form to compute with: names interned, rows grouped once by scene and case, sorted by what pairs
//! them. Two cases are paired by merging their sorted lists, so the order of the rows in the files has no influence.

use super::AnalysisError;
use super::stats::{Group, quantile};
use crate::record::rows::CaseKey;
use crate::record::{BuildRow, CONTROL_WORKLOAD, QueryRow, Stratum, TimingRow, for_each_row, read_rows};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;

/// Consecutive poses of one pair that are resampled together in counts of queries where nothing was timed, so that there are no chunks:
/// neighbours along a path depend on one another (a block bootstrap, Künsch 1989).
const POSES_PER_CLUSTER: u32 = 16;

/// What was observed in one scene.
#[derive(Debug, Default)]
pub struct Scene {
    /// Chunks by number: stratum and poses.
    pub chunks: BTreeMap<u32, (Stratum, u32)>,
    /// The (workload, pair) of each chunk of several poses, numbered as in [`Query::pair`].
    pub chunk_pairs: BTreeMap<u32, u32>,
    /// Chunks of single poses on which the exhaustive control ran.
    pub control_chunks: BTreeSet<u32>,
    /// Timed chunks by case, sorted by (launch, block, chunk).
    pub timings: BTreeMap<CaseKey, Vec<Sample>>,
    /// Counted queries by case, sorted by (pair, pose).
    pub queries: BTreeMap<CaseKey, Vec<Query>>,
    /// Timed constructions by case, sorted by (launch, block, part).
    pub builds: BTreeMap<CaseKey, Vec<Sample>>,
    /// Number of launches seen in timings or builds: 1 + the largest.
    pub launches: usize,
    /// Names that `Query::pair` numbers: (workload, pair).
    pairs: BTreeMap<(String, String), u32>,
    /// Names that `Sample::item` numbers in builds.
    parts: BTreeMap<String, u32>,
}

/// One timed thing: a chunk of queries, or the construction of a part's tree.
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

/// One counted query.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// Number of the (workload, pair).
    pub pair: u32,
    /// Pose of it.
    pub pose: u32,
    /// The chunk that the pose was timed in, if it was.
    pub chunk: Option<u32>,
    /// Stratum.
    pub stratum: Stratum,
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
    #[must_use]
    pub const fn count(&self, counter: Counter) -> u64 {
        match counter {
            Counter::Volume => self.volume_tests,
            Counter::Triangle => self.triangle_tests,
        }
    }
}

/// Observations sorted into the strata that have any, with the scene's launches as the other dimension of their cells.
#[derive(Debug)]
pub struct Strata {
    /// The strata, nearest first; `None` for a single group that is not about queries.
    pub names: Vec<Option<Stratum>>,
    /// Their observations.
    pub groups: Vec<Group>,
    /// Launches of the groups.
    pub launches: usize,
}

/// Reads timings, queries and builds of a run's folder, by scene.
///
/// # Errors
/// When `timings.csv`, `queries.csv` or `builds.csv` is missing or malformed, or contradicts itself.
pub fn read(folder: &Path) -> Result<BTreeMap<String, Scene>, AnalysisError> {
    let mut scenes: BTreeMap<String, Scene> = BTreeMap::new();
    let mut contradiction = None;
    for_each_row(folder, |row: TimingRow| {
        let scene = scenes.entry(row.scene.clone()).or_default();
        let chunk = *scene.chunks.entry(row.chunk).or_insert((row.stratum, row.poses));
        if (chunk != (row.stratum, row.poses) || row.poses == 0 || row.passes == 0) && contradiction.is_none() {
            contradiction = Some(AnalysisError::Chunk { scene: row.scene.clone(), chunk: row.chunk });
        }
        scene.launches = scene.launches.max(row.launch as usize + 1);
        let ns = row.ns as f64 / (f64::from(row.poses) * f64::from(row.passes));
        if row.workload == CONTROL_WORKLOAD {
            scene.control_chunks.insert(row.chunk);
        } else if !scene.chunk_pairs.contains_key(&row.chunk) {
            let pair = intern(&mut scene.pairs, (row.workload.clone(), row.pair.clone()));
            scene.chunk_pairs.insert(row.chunk, pair);
        }
        let sample = Sample { launch: row.launch, block: row.block, item: row.chunk, ns };
        scene.timings.entry(row.case()).or_default().push(sample);
    })?;
    for_each_row(folder, |row: QueryRow| {
        let scene = scenes.entry(row.scene.clone()).or_default();
        let case = row.case();
        let pair = intern(&mut scene.pairs, (row.workload, row.pair));
        let QueryRow { pose, stratum, volume_tests, triangle_tests, .. } = row;
        scene.queries.entry(case).or_default().push(Query {
            pair,
            pose,
            chunk: None,
            stratum,
            volume_tests,
            triangle_tests,
        });
    })?;
    for row in read_rows::<BuildRow>(folder)? {
        let scene = scenes.entry(row.scene.clone()).or_default();
        scene.launches = scene.launches.max(row.launch as usize + 1);
        let case = row.case();
        let item = intern(&mut scene.parts, row.part);
        let sample = Sample { launch: row.launch, block: row.block, item, ns: row.ns as f64 };
        scene.builds.entry(case).or_default().push(sample);
    }
    if let Some(error) = contradiction {
        return Err(error);
    }
    for (name, scene) in &mut scenes {
        scene.sort(name)?;
    }
    Ok(scenes)
}

fn intern<K: Ord>(numbers: &mut BTreeMap<K, u32>, key: K) -> u32 {
    let next = u32::try_from(numbers.len()).expect("fewer than 2^32 names");
    *numbers.entry(key).or_insert(next)
}

/// For each number given in order of appearance, its rank among the sorted names.
fn ranks<K: Ord>(numbers: &BTreeMap<K, u32>) -> Vec<u32> {
    let mut ranks = vec![0; numbers.len()];
    for (rank, &number) in (0..).zip(numbers.values()) {
        ranks[number as usize] = rank;
    }
    ranks
}

impl Scene {
    fn sort(&mut self, name: &str) -> Result<(), AnalysisError> {
        let (pairs, parts) = (ranks(&self.pairs), ranks(&self.parts));
        let twice = |case: &CaseKey, what: String| {
            Err(AnalysisError::Twice {
                scene: name.to_owned(),
                case: format!("{} {}", case.variant, case.policy()),
                what,
            })
        };
        self.builds.values_mut().flatten().for_each(|sample| sample.item = parts[sample.item as usize]);
        self.chunk_pairs.values_mut().for_each(|pair| *pair = pairs[*pair as usize]);
        for (case, samples) in self.timings.iter_mut().chain(&mut self.builds) {
            samples.sort_by_key(Sample::key);
            if let Some(pair) = samples.windows(2).find(|pair| pair[0].key() == pair[1].key()) {
                let (launch, block, item) = pair[0].key();
                return twice(case, format!("launch {launch}, block {block}, chunk or part {item}"));
            }
        }
        for (case, queries) in &mut self.queries {
            queries.iter_mut().for_each(|query| query.pair = pairs[query.pair as usize]);
            queries.sort_by_key(Query::key);
            if let Some(pair) = queries.windows(2).find(|pair| pair[0].key() == pair[1].key()) {
                return twice(case, format!("pose {} of a pair", pair[0].pose));
            }
        }
        self.find_chunks();
        Ok(())
    }

    /// Tells each query its chunk. Records do not name it, but chunks of one stratum and pair are numbered in the order of their poses, which
    /// they share with nobody: so the poses of whoever was asked about most, in order, fill them one after another.
    fn find_chunks(&mut self) {
        let mut poses: BTreeMap<(Stratum, u32), VecDeque<u32>> = BTreeMap::new();
        for query in self.queries.values().max_by_key(|queries| queries.len()).into_iter().flatten() {
            poses.entry((query.stratum, query.pair)).or_default().push_back(query.pose);
        }
        let mut chunks: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for (&chunk, &pair) in &self.chunk_pairs {
            let (stratum, count) = self.chunks[&chunk];
            if let Some(rest) = poses.get_mut(&(stratum, pair)).filter(|rest| rest.len() >= count as usize) {
                chunks.extend(rest.drain(..count as usize).map(|pose| ((pair, pose), chunk)));
            }
        }
        self.queries.values_mut().flatten().for_each(|query| query.chunk = chunks.get(&query.key()).copied());
    }

    /// Log ratios of the query times of two cases, paired by launch, block and chunk; of the blocks of a launch and chunk the
    /// median, which a sample that was interrupted does not move.
    #[must_use]
    pub fn time_ratios(&self, above: &CaseKey, below: &CaseKey) -> Option<Strata> {
        let pairs = merge(self.timings.get(above)?, self.timings.get(below)?, Sample::key);
        let mut blocks: BTreeMap<(u32, u32), Vec<f64>> = BTreeMap::new();
        for (a, b) in pairs {
            blocks.entry((a.launch, a.item)).or_default().push((a.ns / b.ns).ln());
        }
        let logs = blocks.into_iter().map(|((launch, item), mut logs)| {
            logs.sort_unstable_by(f64::total_cmp);
            (Some(self.chunks[&item].0), launch, item, quantile(&logs, 0.5))
        });
        Strata::collect(logs, self.launches)
    }

    /// Whether the pairs of the two runs have the same numbers, so that their queries can be held against each other.
    #[must_use]
    pub fn has_pairs_of(&self, other: &Self) -> bool {
        self.pairs.keys().eq(other.pairs.keys())
    }

    /// Log ratios of a case's query times in this run to those in another, `before`, of the same poses: paired by launch and
    /// chunk, of the blocks of either the median. Chunks go by what they hold, as another version of the program may number them otherwise.
    #[must_use]
    pub fn time_changes(&self, before: &Self, case: &CaseKey) -> Option<Strata> {
        let (after, earlier) = (chunk_times(self.timings.get(case)?), chunk_times(before.timings.get(case)?));
        let numbers: BTreeMap<Held, u32> = before.held().map(|(number, held)| (held, number)).collect();
        let held: BTreeMap<u32, Held> = self.held().collect();
        let logs = after.into_iter().filter_map(|((launch, chunk), ns)| {
            let old = earlier.get(&(launch, *numbers.get(&held[&chunk])?))?;
            Some((Some(self.chunks[&chunk].0), launch, chunk, (ns / old).ln()))
        });
        Strata::collect(logs, self.launches.min(before.launches))
    }

    /// What each chunk holds, by its number.
    fn held(&self) -> impl Iterator<Item = (u32, Held)> {
        let mut ranks: BTreeMap<(Stratum, u32, Option<u32>), u32> = BTreeMap::new();
        self.chunks.iter().map(move |(&number, &(stratum, poses))| {
            let kind = (stratum, poses, self.chunk_pairs.get(&number).copied());
            let rank = ranks.entry(kind).or_default();
            *rank += 1;
            (number, (kind, *rank))
        })
    }

    /// Log ratios of a case's construction times in this run to those in another, `before`, paired by block and part. As in
    /// [`Self::build_ratios`] the blocks are resampled.
    #[must_use]
    pub fn build_changes(&self, before: &Self, case: &CaseKey) -> Option<Strata> {
        if !self.parts.keys().eq(before.parts.keys()) {
            return None;
        }
        let pairs = merge(self.builds.get(case)?, before.builds.get(case)?, Sample::key);
        Strata::collect(pairs.map(|(a, b)| (None, 0, a.block, (a.ns / b.ns).ln())), 1)
    }

    /// The queries of a case that both runs have: (this run's, the earlier one's).
    pub fn both_queries<'a>(
        &'a self,
        before: &'a Self,
        case: &CaseKey,
    ) -> impl Iterator<Item = (&'a Query, &'a Query)> + use<'a> {
        let of = |scene: &'a Self| scene.queries.get(case).map_or(&[][..], Vec::as_slice);
        merge(of(self), of(before), Query::key)
    }

    /// Query times of a case, ns: of each launch and chunk the median over blocks, so that all chunks count the same, however often each was
    /// repeated (slow ones are timed once in a launch).
    #[must_use]
    pub fn times(&self, case: &CaseKey) -> Option<Strata> {
        let samples = self.timings.get(case)?;
        // The control's few poses stand for the control alone; a case that ran others is summed up over those.
        let only_control = samples.iter().all(|sample| self.control_chunks.contains(&sample.item));
        let times = chunk_times(samples).into_iter();
        let times = times.filter(|((_, chunk), _)| only_control || !self.control_chunks.contains(chunk));
        let observations = times.map(|((launch, chunk), ns)| (Some(self.chunks[&chunk].0), launch, chunk, ns));
        Strata::collect(observations, self.launches)
    }

    /// Log ratios of the construction times of two cases, paired by launch, block and part.
    #[must_use]
    pub fn build_ratios(&self, above: &CaseKey, below: &CaseKey) -> Option<Strata> {
        let pairs = merge(self.builds.get(above)?, self.builds.get(below)?, Sample::key);
        // A few parts are no sample of anything: what is resampled are the blocks, which are numbered across launches.
        let logs = pairs.map(|(a, b)| (None, 0, a.block, (a.ns / b.ns).ln()));
        Strata::collect(logs, 1)
    }

    /// Log ratios of the counts of two cases, paired by query. Triangle tests are counted from one instead of zero, for a
    /// query that gets by without any would otherwise have no logarithm, and leaving it out would leave out a method's best.
    /// A case whose every count is zero does not count and has no ratios.
    #[must_use]
    pub fn count_ratios(&self, above: &CaseKey, below: &CaseKey, counter: Counter) -> Option<Strata> {
        let (above, below) = (self.queries.get(above)?, self.queries.get(below)?);
        let counts = |queries: &[Query]| queries.iter().any(|query| query.count(counter) > 0);
        if !counts(above) || !counts(below) {
            return None;
        }
        let pairs = merge(above, below, Query::key);
        let start = match counter {
            Counter::Volume => 0,
            Counter::Triangle => 1,
        };
        let logs = pairs.filter_map(|(a, b)| {
            let (over, under) = (start + a.count(counter), start + b.count(counter));
            (over > 0 && under > 0).then(|| (Some(a.stratum), 0, cluster(a), (over as f64 / under as f64).ln()))
        });
        Strata::collect(logs, 1)
    }
}

/// The cluster of a query: its chunk, as in times; without one its neighbours, of a pair's first 2^19 poses, beyond which clusters merely
/// grow together.
fn cluster(query: &Query) -> u32 {
    query.chunk.unwrap_or(1 << 31 | query.pair << 15 | (query.pose / POSES_PER_CLUSTER) & 0x7fff)
}

impl Sample {
    const fn key(&self) -> (u32, u32, u32) {
        (self.launch, self.block, self.item)
    }
}

/// What a chunk holds: stratum, number of poses, (workload, pair) unless it is the control's, and its rank among those alike.
type Held = ((Stratum, u32, Option<u32>), u32);

impl Query {
    const fn key(&self) -> (u32, u32) {
        (self.pair, self.pose)
    }
}

/// Of each launch and chunk the median over blocks, ns.
pub(super) fn chunk_times(samples: &[Sample]) -> BTreeMap<(u32, u32), f64> {
    let mut blocks: BTreeMap<(u32, u32), Vec<f64>> = BTreeMap::new();
    for sample in samples {
        blocks.entry((sample.launch, sample.item)).or_default().push(sample.ns);
    }
    let median = |mut ns: Vec<f64>| {
        ns.sort_unstable_by(f64::total_cmp);
        quantile(&ns, 0.5)
    };
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

impl Strata {
    /// Sorts (stratum, launch, cluster, value) into cells; `None` of nothing.
    fn collect(values: impl Iterator<Item = (Option<Stratum>, u32, u32, f64)>, launches: usize) -> Option<Self> {
        let mut by_stratum: BTreeMap<Option<Stratum>, Vec<(u32, u32, f64)>> = BTreeMap::new();
        for (stratum, launch, cluster, value) in values.filter(|v| v.3.is_finite()) {
            by_stratum.entry(stratum).or_default().push((launch, cluster, value));
        }
        let groups = by_stratum.values().map(|values| {
            let mut clusters: Vec<u32> = values.iter().map(|v| v.1).collect();
            clusters.sort_unstable();
            clusters.dedup();
            let mut group = Group::new(launches, clusters.len());
            for &(launch, cluster, value) in values {
                let place = clusters.binary_search(&cluster).expect("every cluster was listed");
                group.add(launch as usize, place, value);
            }
            group
        });
        let groups: Vec<Group> = groups.collect();
        let names: Vec<_> = by_stratum.into_keys().collect();
        (!names.is_empty()).then_some(Self { names, groups, launches })
    }
}
