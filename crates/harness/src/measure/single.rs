//! Single queries: one reading of the clock over one query, warm for percentiles, cold for a control that has other work to do.
//!
//! - *Warm*: the poses of every chunk one by one, after one whole untimed pass over the chunk, as the chunks themselves are timed.
//! - *Cold*: poses of every program, evenly spread. Before each of them a buffer larger than the caches is read outside the timed region, so that
//!   trees, triangles and translations of addresses have left them. Reading does not empty the level-1 cache of instructions by itself, nor
//!   the branch predictor.
//!
//! Cases run in a fresh random order at each chunk, or pose. Cases under their default policies take part, and the null duplicate. The clock's
//! own cost is in every reading; the manifest says how much that is.

use super::binaries::binary_of;
use super::chunk::Participants;
use super::environment;
use super::measured::TimedChunk;
use super::plan::Plan;
use super::query::TimedCase;
use super::{Progress, timer};
use crate::geometry::Isometry;
use crate::method::Kind;
use crate::record::manifest::ColdEntry;
use crate::record::{Cache, NULL_VARIANT, SingleRow};
use crate::scene::{Pair, Scene};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use std::hint::black_box;

/// Launches with single queries, at least; with more binaries than these the first launch of each.
const LAUNCHES: u32 = 3;
/// The buffer is so many times the largest cache, since caches do not replace strictly the line that is longest unused.
const TIMES_THE_CACHE: u64 = 2;
/// Bounds of the buffer's size, bytes: what a machine needs that does not tell its caches, and what any machine can spare.
const BUFFER_BYTES: (u64, u64) = (64 << 20, 512 << 20);
/// A line of every cache there is, or more, words.
const LINE: usize = 8;
/// Parts the streams of random numbers.
const STREAM: u64 = 0x51;

/// How caches are emptied on this machine.
pub fn eviction() -> ColdEntry {
    let largest_cache_bytes = environment::largest_cache_bytes();
    let buffer_bytes = (TIMES_THE_CACHE * largest_cache_bytes).clamp(BUFFER_BYTES.0, BUFFER_BYTES.1);
    ColdEntry { buffer_bytes, largest_cache_bytes }
}

/// A buffer larger than the caches.
struct Evictor(Vec<u64>);

impl Evictor {
    fn new() -> Self {
        let words = eviction().buffer_bytes / size_of::<u64>() as u64;
        // Not zero: pages of zeros are one and the same page until they are written to.
        Self(vec![1; usize::try_from(words).unwrap_or(0)])
    }

    /// Reads a word of every line.
    fn evict(&self) {
        black_box(self.0.iter().step_by(LINE).fold(0, |sum: u64, word| sum.wrapping_add(*word)));
    }
}

/// Times single queries of a scene, warm and cold, in the first launches.
pub fn time_scene(
    plan: &Plan,
    scene: &Scene,
    cases: &[TimedCase],
    chunks: &[TimedChunk],
    launch: u32,
    progress: &dyn Progress,
) -> Vec<SingleRow> {
    if launch >= plan.budget.binaries.max(LAUNCHES) {
        return Vec::new();
    }
    let seed = plan.selection.seed ^ (u64::from(launch) << 32) ^ STREAM;
    let mut singles = Singles { plan, scene, launch, rng: Pcg64Mcg::seed_from_u64(seed), rows: Vec::new() };
    let asked: Vec<&TimedCase> = cases.iter().filter(|case| takes_part(plan, case)).collect();
    let cold_poses = plan.budget.cold_poses;
    let evictor = (cold_poses > 0 && chunks.iter().any(|chunk| chunk.is_program)).then(Evictor::new);
    progress.begin(&format!("{}: single queries", scene.name), chunks.len() as u64);
    let mut first_pose = 0;
    for chunk in chunks {
        match &evictor {
            _ if chunk.participants == Participants::Control => {}
            Some(evictor) if chunk.is_program => singles.cold(chunk, first_pose, &asked, cold_poses, evictor),
            _ if chunk.is_program => {}
            _ => singles.warm(chunk, first_pose, &asked),
        }
        first_pose += chunk.len() as u32;
        progress.advance(1);
    }
    let mut rows = singles.rows;
    rows.sort_by(|x, y| (x.cache, x.pose, &x.case).cmp(&(y.cache, y.pose, &y.case)));
    rows
}

/// The null duplicate, and every case under its variant's default policy but the control.
fn takes_part(plan: &Plan, timed: &TimedCase) -> bool {
    let case = &timed.case;
    case.variant.kind != Kind::Control && (case.id == NULL_VARIANT || plan.is_default(case))
}

/// What is timed so far.
struct Singles<'a> {
    plan: &'a Plan,
    scene: &'a Scene,
    launch: u32,
    rng: Pcg64Mcg,
    rows: Vec<SingleRow>,
}

impl Singles<'_> {
    /// All poses of a chunk, each case after a whole untimed pass.
    fn warm(&mut self, chunk: &TimedChunk, first_pose: u32, cases: &[&TimedCase]) {
        let mut order: Vec<&TimedCase> = cases.iter().filter(|case| runs(case, chunk)).copied().collect();
        order.shuffle(&mut self.rng);
        let mut verdicts = Vec::with_capacity(chunk.len());
        for case in order {
            for (pair, poses) in &chunk.runs {
                let (a, b) = case.models_of(*pair);
                a.first(b, poses, &mut verdicts);
            }
            for (place, (pair, pose)) in queries(chunk).enumerate() {
                let ns = single(case, pair, pose, &mut verdicts);
                self.note(case, Cache::Warm, first_pose + place as u32, ns);
            }
        }
    }

    /// Some poses of a program, each with empty caches.
    fn cold(&mut self, chunk: &TimedChunk, first_pose: u32, cases: &[&TimedCase], count: usize, evictor: &Evictor) {
        let all: Vec<(Pair, &Isometry)> = queries(chunk).collect();
        let mut order: Vec<&TimedCase> = cases.iter().filter(|case| runs(case, chunk)).copied().collect();
        let mut verdicts = Vec::with_capacity(1);
        for place in spread(all.len(), count) {
            let (pair, pose) = all[place];
            order.shuffle(&mut self.rng);
            for case in &order {
                evictor.evict();
                let ns = single(case, pair, pose, &mut verdicts);
                self.note(case, Cache::Cold, first_pose + place as u32, ns);
            }
        }
    }

    fn note(&mut self, case: &TimedCase, cache: Cache, pose: u32, ns: u64) {
        self.rows.push(SingleRow {
            scene: self.scene.name.clone(),
            case: case.case.name(),
            cache,
            binary: binary_of(self.launch, self.plan.budget.binaries),
            launch: self.launch,
            pose,
            ns,
        });
    }
}

/// Peers run some chunks only.
fn runs(case: &TimedCase, chunk: &TimedChunk) -> bool {
    chunk.participants == Participants::Everyone || case.case.variant.kind != Kind::Peer
}

fn queries(chunk: &TimedChunk) -> impl Iterator<Item = (Pair, &Isometry)> {
    chunk.runs.iter().flat_map(|(pair, poses)| poses.iter().map(|pose| (*pair, pose)))
}

/// One query; the pose itself is at hand, as it is where a control has just computed it.
fn single(case: &TimedCase, pair: Pair, pose: &Isometry, verdicts: &mut Vec<bool>) -> u64 {
    let (a, b) = case.models_of(pair);
    let pose = black_box([*pose]);
    verdicts.clear();
    let (ns, ()) = timer::time(|| a.first(b, &pose, verdicts));
    black_box(verdicts.last());
    ns
}

/// Up to `count` places of `all`, evenly spread.
fn spread(all: usize, count: usize) -> impl Iterator<Item = usize> {
    let count = count.min(all);
    (0..count).map(move |i| (2 * i + 1) * all / (2 * count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_spread_evenly() {
        assert_eq!(spread(100, 4).collect::<Vec<_>>(), [12, 37, 62, 87]);
        assert_eq!(spread(3, 16).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(spread(0, 4).count(), 0);
        let places: Vec<usize> = spread(401, 16).collect();
        assert!(places.windows(2).all(|pair| pair[0] < pair[1]) && places.last().is_some_and(|&last| last < 401));
    }

    /// After the walk, what was read before it takes longer to read: some 16 KiB that were warm come from memory.
    #[test]
    fn a_walk_empties_the_caches() {
        let evictor = Evictor::new();
        assert!(evictor.0.len() as u64 * 8 >= eviction().largest_cache_bytes.min(BUFFER_BYTES.1));
        let data: Vec<u64> = (0..2048).collect();
        let read =
            || timer::time(|| black_box(&data).iter().step_by(LINE).fold(0_u64, |sum, word| sum.wrapping_add(*word))).0;
        let median = |mut ns: Vec<u64>| {
            ns.sort_unstable();
            ns[ns.len() / 2]
        };
        let warm = median((0..21).map(|_| (read(), read()).1).collect());
        let cold = median(
            (0..21)
                .map(|_| {
                    evictor.evict();
                    read()
                })
                .collect(),
        );
        assert!(cold > 2 * warm, "cold {cold} ns, warm {warm} ns");
    }
}
