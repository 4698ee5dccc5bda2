//! The one loop that times queries: randomised complete blocks.
//!
//! In every block every chunk is visited in a fresh random order, and for a chunk every case runs in a fresh random order, back to back, each
//! after one whole untimed pass over the same poses, the same for fast and slow cases: it brings the parts of its trees they need into the
//! caches and teaches the branch predictor. Without it a short sample mostly measures what ran before it. The first block finds how often a
//! short chunk must be repeated, and is dropped. Where a chunk takes a case longer than `LONG_SAMPLE_NS`, one timed block of each launch can be
//! enough for it: such a sample averages the machine's noise itself. No case is left out of a launch.

use super::{Progress, timer};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

/// Poses run in the block that is dropped to see whether a chunk takes a case long.
const PROBED_POSES: usize = 2;

/// A chunk that takes a case longer than this, ns, is long: 50 times the shortest sample. A single sample of a millisecond in each launch left the
/// null duplicate of program times some percent from its original; one of 5 ms holds the ticks of the system's clock in their proportion.
const LONG_SAMPLE_NS: u64 = 50 * timer::SHORTEST_SAMPLE_NS;

/// Cases that run chunks of poses, both by number.
pub trait Work {
    /// How many cases there are.
    fn cases(&self) -> usize;
    /// How many poses each chunk has; none is empty.
    fn chunks(&self) -> Vec<usize>;
    /// How a case takes part in a chunk.
    fn participation(&self, case: usize, chunk: usize) -> Participation;
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
    /// Whether one timed block is enough.
    once: bool,
}

/// Times all cases on all chunks; the samples in the order of block, chunk and case, whatever the order of execution. Advances by one for every chunk
/// of a block.
pub fn time(work: &mut impl Work, extent: Extent, seed: u64, progress: &dyn Progress) -> Vec<Sample> {
    let (cases, poses) = (work.cases(), work.chunks());
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut repetitions = vec![vec![Repetition { passes: 1, once: false }; cases]; poses.len()];
    let mut samples = Vec::new();
    let (mut chunk_order, mut case_order): (Vec<usize>, Vec<usize>) =
        ((0..poses.len()).collect(), (0..cases).collect());
    for block in u32::from(!extent.warms_up)..=extent.blocks {
        chunk_order.shuffle(&mut rng);
        for &chunk in &chunk_order {
            case_order.shuffle(&mut rng);
            for &case in &case_order {
                let sample = match work.participation(case, chunk) {
                    Participation::Absent => None,
                    Participation::Once => (block == 1).then(|| {
                        if extent.warms_up {
                            work.run(case, chunk, poses[chunk], 1);
                        }
                        let (ns, ()) = timer::time(|| work.run(case, chunk, poses[chunk], 1));
                        (1, ns)
                    }),
                    Participation::Always => {
                        one(work, (case, chunk, poses[chunk]), block, extent, &mut repetitions[chunk][case])
                    }
                };
                samples.extend(sample.map(|(passes, ns)| Sample { case, chunk, block: block - 1, passes, ns }));
            }
            progress.advance(1);
        }
    }
    samples.sort_by_key(|sample| (sample.block, sample.chunk, sample.case));
    samples
}

/// Passes and time of a case's sample; none in the block that warms up, nor where earlier ones are enough.
fn one(
    work: &mut impl Work,
    (case, chunk, poses): (usize, usize, usize),
    block: u32,
    extent: Extent,
    repetition: &mut Repetition,
) -> Option<(u32, u64)> {
    if repetition.once && block > 1 {
        return None;
    }
    if block == 0 && extent.long_once {
        let probed = poses.min(PROBED_POSES);
        let (ns, ()) = timer::time(|| work.run(case, chunk, probed, 1));
        // What its first poses show to be long need not be run whole to be known as such.
        if ns * poses as u64 / probed as u64 > 2 * LONG_SAMPLE_NS {
            *repetition = Repetition { passes: 1, once: true };
            return None;
        }
    }
    if block > 0 && extent.warms_up {
        work.run(case, chunk, poses, 1);
    }
    let passes = repetition.passes;
    let (ns, ()) = timer::time(|| work.run(case, chunk, poses, passes));
    if block > 0 {
        return Some((passes, ns));
    }
    *repetition = Repetition { passes: timer::passes_for(ns), once: extent.long_once && ns > LONG_SAMPLE_NS };
    None
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

        fn run(&mut self, case: usize, chunk: usize, poses: usize, passes: u32) {
            self.runs.push((case, chunk, poses, passes));
            std::thread::sleep(if case == 2 { self.long } else { Duration::ZERO });
        }
    }

    fn timed(long: Duration, extent: Extent) -> (Vec<Sample>, Vec<Run>) {
        let mut work = Noted { runs: Vec::new(), long };
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
    fn without_warming_up_every_sample_is_one_run() {
        let (samples, runs) = timed(Duration::ZERO, Extent { warms_up: false, ..EXTENT });
        assert_eq!(samples.len(), runs.len());
        assert!(samples.iter().all(|s| s.passes == 1) && samples.len() == 3 * 6 + 1);
        // Each block has an order of its own.
        let order = |block: usize| runs.iter().map(|run| (run.0, run.1)).skip(block * 6).take(6).collect::<Vec<_>>();
        assert!(order(1) != order(2) || order(0) != order(1));
    }
}
