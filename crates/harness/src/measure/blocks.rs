//! The one loop that times queries: randomised complete blocks.
//!
//! In every block every chunk is visited in a fresh random order, and for a chunk every case runs in a fresh random order, back to back, each
//! after one whole untimed pass over the same poses, the same for fast and slow cases: it brings the parts of its trees they need into the
//! caches and teaches the branch predictor. Without it a short sample mostly measures what ran before it. A sample of half a second needs none:
//! see [`SELF_WARMING_NS`]. The first block finds how often a
//! short chunk must be repeated, and is dropped. Where a chunk takes a case longer than `LONG_SAMPLE_NS`, one timed block of each launch can be
//! enough for it: such a sample averages the machine's noise itself. No case is left out of a launch.
//!
//! A chunk can be read several times in a block, each at a random place of the block's order: the sample is the median reading.

use super::{Progress, timer};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

/// Poses run in the block that is dropped to see whether a chunk takes a case long.
const PROBED_POSES: usize = 2;
/// If they do not show it, so many times more are run, until it is the whole chunk.
const PROBED_AGAIN: usize = 8;

/// A chunk that takes a case longer than this, ns, is long: 50 times the shortest sample. A single sample of a millisecond in each launch left the
/// null duplicate of program times some percent from its original; one of 5 ms holds the ticks of the system's clock in their proportion.
const LONG_SAMPLE_NS: u64 = 50 * timer::SHORTEST_SAMPLE_NS;

/// Most time of all readings of a case and a chunk in a block, ns; a chunk that is to be read several times is long when one reading takes longer.
const READING_NS: u64 = 9 * LONG_SAMPLE_NS;

/// What takes longer than this, ns, is not run untimed first. What its first queries find cold costs them less than 0.1 ms each until the trees
/// are in the caches (`singles.csv`, cold less warm): far less than 1 % of so long a sample.
const SELF_WARMING_NS: u64 = 10 * READING_NS;

/// Cases that run chunks of poses, both by number.
pub trait Work {
    /// How many cases there are.
    fn cases(&self) -> usize;
    /// How many poses each chunk has; none is empty.
    fn chunks(&self) -> Vec<usize>;
    /// How a case takes part in a chunk.
    fn participation(&self, case: usize, chunk: usize) -> Participation;
    /// Most readings of a chunk in a block; what takes long has fewer.
    fn readings(&self, _chunk: usize) -> u32 {
        1
    }
    /// A case runs the first `poses` of a chunk, `passes` times over.
    fn run(&mut self, case: usize, chunk: usize, poses: usize, passes: u32);
}

/// How a case takes part in a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Participation {
    /// Not at all.
    Absent,
    /// By one sample of each launch: it is known to take long.
    Once,
    /// In every block.
    Always,
}

/// How much is timed.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Timed blocks.
    pub blocks: u32,
    /// Whether cases are warmed up and short chunks repeated; else every sample is one run.
    pub warms_up: bool,
    /// Whether one block is enough for long samples.
    pub long_once: bool,
}

/// One sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// The case.
    pub case: usize,
    /// The chunk.
    pub chunk: usize,
    /// The block, from 0.
    pub block: u32,
    /// Runs over the chunk.
    pub passes: u32,
    /// Wall time of all of them, ns.
    pub ns: u64,
}

/// How a case runs a chunk, as the warm-up found.
#[derive(Clone, Copy)]
struct Repetition {
    passes: u32,
    /// Readings in a block.
    readings: u32,
    /// Whether one timed block is enough.
    once: bool,
    /// Whether each sample follows an untimed pass.
    warms_up: bool,
}

impl Repetition {
    const SINGLE: Self = Self { passes: 1, readings: 1, once: false, warms_up: true };
    const LONG: Self = Self { once: true, ..Self::SINGLE };

    /// Of what takes `ns`, which is long.
    const fn of_long(ns: u64) -> Self {
        Self { warms_up: ns <= SELF_WARMING_NS, ..Self::LONG }
    }

    /// Of what takes `ns` where `readings` are asked for: short work is repeated, and a block spends no more than [`READING_NS`] on the
    /// readings of what takes longer.
    fn of(ns: u64, readings: u32, extent: Extent) -> Self {
        if extent.long_once && ns > long_ns(readings) {
            return Self::of_long(ns);
        }
        let fitting = u32::try_from(READING_NS / ns.max(1)).unwrap_or(u32::MAX);
        // An odd number has a middle one.
        let readings = (fitting.clamp(1, readings) - 1) / 2 * 2 + 1;
        Self { passes: timer::passes_for(ns), readings, ..Self::SINGLE }
    }
}

/// From where on a chunk of which `readings` are asked for is long, ns.
const fn long_ns(readings: u32) -> u64 {
    if readings > 1 { READING_NS } else { LONG_SAMPLE_NS }
}

/// Passes, and wall time of all of them, ns.
type Reading = (u32, u64);

/// How often chunks are visited: once in the block that is dropped, and for each of their readings in every block.
pub fn visits(work: &impl Work, extent: Extent) -> u64 {
    let chunks = work.chunks().len();
    let readings: u64 = (0..chunks).map(|chunk| u64::from(work.readings(chunk))).sum();
    u64::from(extent.blocks) * readings + if extent.warms_up { chunks as u64 } else { 0 }
}

/// Times all cases on all chunks; the samples in the order of block, chunk and case, whatever the order of execution. Advances by one for every
/// visit to a chunk.
pub fn time(work: &mut impl Work, extent: Extent, seed: u64, progress: &dyn Progress) -> Vec<Sample> {
    let (cases, poses) = (work.cases(), work.chunks());
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut repetitions = vec![vec![Repetition::SINGLE; cases]; poses.len()];
    let mut samples = Vec::new();
    let mut case_order: Vec<usize> = (0..cases).collect();
    for block in u32::from(!extent.warms_up)..=extent.blocks {
        let mut readings: Vec<Vec<Vec<Reading>>> = vec![vec![Vec::new(); cases]; poses.len()];
        let of_chunk = |chunk: usize| if block == 0 { 1 } else { work.readings(chunk) as usize };
        let mut visits: Vec<usize> =
            (0..poses.len()).flat_map(|chunk| std::iter::repeat_n(chunk, of_chunk(chunk))).collect();
        visits.shuffle(&mut rng);
        for chunk in visits {
            case_order.shuffle(&mut rng);
            for &case in &case_order {
                let place = (case, chunk, poses[chunk]);
                let read = &mut readings[chunk][case];
                read.extend(visit(work, place, block, extent, &mut repetitions[chunk][case], read.len()));
            }
            progress.advance(1);
        }
        for (chunk, of_chunk) in readings.iter_mut().enumerate() {
            for (case, read) in of_chunk.iter_mut().enumerate() {
                samples.extend(median(read).map(|(passes, ns)| Sample { case, chunk, block: block - 1, passes, ns }));
            }
        }
    }
    samples
}

/// The median reading. There is an odd number of them: see [`Repetition::of`].
fn median(readings: &mut [Reading]) -> Option<Reading> {
    readings.sort_unstable_by_key(|(_, ns)| *ns);
    readings.get(readings.len().checked_sub(1)? / 2).copied()
}

/// One reading, or none where `earlier` ones are enough and in the block that warms up.
fn visit(
    work: &mut impl Work,
    (case, chunk, poses): (usize, usize, usize),
    block: u32,
    extent: Extent,
    repetition: &mut Repetition,
    earlier: usize,
) -> Option<Reading> {
    match work.participation(case, chunk) {
        Participation::Absent => return None,
        Participation::Once => *repetition = Repetition::LONG,
        Participation::Always if block == 0 => {
            *repetition = probe(work, (case, chunk, poses), extent);
            return None;
        }
        Participation::Always => {}
    }
    let is_enough = block == 0 || earlier >= repetition.readings as usize || (repetition.once && block > 1);
    if is_enough {
        return None;
    }
    if extent.warms_up && repetition.warms_up {
        work.run(case, chunk, poses, 1);
    }
    let passes = repetition.passes;
    let (ns, ()) = timer::time(|| work.run(case, chunk, poses, passes));
    Some((passes, ns))
}

/// Runs a chunk to see how it is to be repeated. What its first poses show to be long is not run whole; programs begin with quick ones.
fn probe(work: &mut impl Work, (case, chunk, poses): (usize, usize, usize), extent: Extent) -> Repetition {
    let readings = work.readings(chunk);
    let mut probed = PROBED_POSES;
    while extent.long_once && probed < poses {
        let (ns, ()) = timer::time(|| work.run(case, chunk, probed, 1));
        let whole_ns = ns * poses as u64 / probed as u64;
        if whole_ns > 2 * long_ns(readings) {
            return Repetition::of_long(whole_ns);
        }
        probed *= PROBED_AGAIN;
    }
    let (ns, ()) = timer::time(|| work.run(case, chunk, poses, 1));
    Repetition::of(ns, readings, extent)
}

#[cfg(test)]
mod tests {
    use super::super::Silent;
    use super::*;
    use std::time::Duration;

    /// Case, chunk, poses, passes.
    type Run = (usize, usize, usize, u32);

    /// Notes what it is asked to run; case 2 takes as long as `long`.
    struct Noted {
        runs: Vec<Run>,
        long: Duration,
        readings: u32,
    }

    impl Work for Noted {
        fn cases(&self) -> usize {
            4
        }

        fn chunks(&self) -> Vec<usize> {
            vec![8, 3]
        }

        fn participation(&self, case: usize, chunk: usize) -> Participation {
            match (case, chunk) {
                (3, 0) => Participation::Absent,
                (3, _) => Participation::Once,
                _ => Participation::Always,
            }
        }

        fn readings(&self, _: usize) -> u32 {
            self.readings
        }

        fn run(&mut self, case: usize, chunk: usize, poses: usize, passes: u32) {
            self.runs.push((case, chunk, poses, passes));
            std::thread::sleep(if case == 2 { self.long } else { Duration::ZERO });
        }
    }

    fn timed(long: Duration, extent: Extent) -> (Vec<Sample>, Vec<Run>) {
        timed_with(long, extent, 1)
    }

    fn timed_with(long: Duration, extent: Extent, readings: u32) -> (Vec<Sample>, Vec<Run>) {
        let mut work = Noted { runs: Vec::new(), long, readings };
        let samples = time(&mut work, extent, 7, &Silent);
        (samples, work.runs)
    }

    const EXTENT: Extent = Extent { blocks: 3, warms_up: true, long_once: true };

    #[test]
    fn every_case_has_a_sample_of_every_chunk_in_every_block() {
        let (samples, runs) = timed(Duration::ZERO, Extent { long_once: false, ..EXTENT });
        let keys: Vec<_> = samples.iter().map(|s| (s.block, s.chunk, s.case)).collect();
        let all = |block: u32| [0, 1].map(|chunk| [0, 1, 2].map(|case| (block, chunk, case))).concat();
        let mut wanted = [all(0), vec![(0, 1, 3)], all(1), all(2)].concat();
        wanted.sort_unstable();
        assert_eq!(keys, wanted);
        // Work of no time is repeated, after one whole pass in each block but the dropped one.
        assert!(samples.iter().all(|s| s.case == 3 || s.passes > 1), "{samples:?}");
        let of_first: Vec<_> = runs.iter().filter(|run| (run.0, run.1) == (0, 0)).map(|run| (run.2, run.3)).collect();
        assert_eq!(of_first.len(), 7);
        assert!(of_first[1..].chunks(2).all(|run| run[0] == (8, 1) && run[1].0 == 8 && run[1].1 > 1), "{of_first:?}");
    }

    #[test]
    fn what_takes_long_is_timed_in_one_block_of_every_launch_after_a_whole_pass() {
        // 12 ms for a call is far above the limit, in whichever launch.
        let (samples, runs) = timed(Duration::from_millis(12), EXTENT);
        let of_long: Vec<_> = samples.iter().filter(|s| s.case == 2).map(|s| (s.block, s.chunk, s.passes)).collect();
        assert_eq!(of_long, [(0, 0, 1), (0, 1, 1)]);
        let first_chunk: Vec<_> = runs.iter().filter(|run| (run.0, run.1) == (2, 0)).map(|run| run.2).collect();
        assert_eq!(first_chunk, [2, 8, 8], "two poses to see that it is long, a whole pass untimed, the sample");
        // The case that is known to take long is warmed up like the others.
        assert_eq!(runs.iter().filter(|run| (run.0, run.1) == (3, 1)).map(|run| run.2).collect::<Vec<_>>(), [3, 3]);
        let (every, _) = timed(Duration::from_millis(12), Extent { long_once: false, ..EXTENT });
        assert_eq!(every.iter().filter(|s| s.case == 2).count(), 6);
    }

    #[test]
    fn what_takes_half_a_second_warms_itself() {
        // By its first two poses the first chunk takes 480 ms, the second 180 ms.
        let (_, runs) = timed(Duration::from_millis(120), EXTENT);
        let poses = |chunk| runs.iter().filter(|run| (run.0, run.1) == (2, chunk)).map(|run| run.2).collect::<Vec<_>>();
        assert_eq!((poses(0), poses(1)), (vec![2, 8], vec![2, 3, 3]));
    }

    #[test]
    fn a_block_reads_a_chunk_several_times_and_keeps_the_median() {
        let (samples, runs) = timed_with(Duration::ZERO, EXTENT, 5);
        assert_eq!(samples.len(), 3 * 6 + 1);
        // Two poses and a whole pass in the block that is dropped; then a whole pass before each reading.
        let runs = runs.iter().filter(|run| (run.0, run.1) == (0, 0)).count();
        assert!([1, 2, 3, 4, 5].map(|readings| 2 + 3 * 2 * readings).contains(&runs), "{runs}");
        assert_eq!(median(&mut [(1, 9), (1, 1), (1, 5)]), Some((1, 5)));
        assert_eq!(median(&mut []), None);
        // Five readings of 9 ms fit into what a block spends, three of 12 ms, one of 40 ms; what takes longer is read in one block. Four of
        // 11 ms would fit, and two of 20 ms, but an even number has no middle one.
        let ms = |ms: u64| Repetition::of(ms * 1_000_000, 5, EXTENT);
        assert_eq!([9, 11, 12, 20, 40].map(|time| ms(time).readings), [5, 3, 3, 1, 1]);
        assert_eq!([1, 40, 46].map(|time| ms(time).once), [false, false, true]);
        assert!(Repetition::of(6_000_000, 1, EXTENT).once && !Repetition::of(4_000_000, 1, EXTENT).once);
    }

    #[test]
    fn without_warming_up_every_sample_is_one_run() {
        let (samples, runs) = timed(Duration::ZERO, Extent { warms_up: false, ..EXTENT });
        assert_eq!(samples.len(), runs.len());
        assert!(samples.iter().all(|s| s.passes == 1) && samples.len() == 3 * 6 + 1);
        // Each block has an order of its own.
        let order = |block: usize| runs.iter().map(|run| (run.0, run.1)).skip(block * 6).take(6).collect::<Vec<_>>();
        assert!(order(1) != order(2) || order(0) != order(1));
    }
}
