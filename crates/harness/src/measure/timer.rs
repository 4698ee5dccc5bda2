//! The clock.

use crate::record::manifest::ClockEntry;
use std::hint::black_box;
use std::time::Instant;

/// Duration that short work is repeated to, ns: a thousand times the resolution and cost of the clock (some tens of ns). By the time of one
/// pass in the block that is dropped; later passes are often faster, so that a third of the samples of a run last less.
pub const SHORTEST_SAMPLE_NS: u64 = 100_000;

/// Runs `work` and returns the wall time, ns, and its result, which the compiler must assume is used.
pub fn time<R>(work: impl FnOnce() -> R) -> (u64, R) {
    let start = Instant::now();
    let result = black_box(work());
    let ns = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
    (ns, result)
}

/// Measures the clock: how long no work at all takes by it.
pub fn clock() -> ClockEntry {
    const READINGS: usize = 100_001;
    let mut readings: Vec<u64> = (0..READINGS).map(|_| time(|| ()).0).collect();
    readings.sort_unstable();
    let steps = readings.windows(2).map(|pair| pair[1] - pair[0]);
    let tick_ns = steps.filter(|&step| step > 0).min().unwrap_or(0);
    ClockEntry { empty_ns: readings[READINGS / 2], empty_p99_ns: readings[READINGS / 100 * 99], tick_ns }
}

/// How often a piece of work that once took `ns` must be repeated to fill [`SHORTEST_SAMPLE_NS`].
pub const fn passes_for(ns: u64) -> u32 {
    if ns >= SHORTEST_SAMPLE_NS {
        return 1;
    }
    let ns = if ns == 0 { 1 } else { ns };
    SHORTEST_SAMPLE_NS.div_ceil(ns) as u32
}

/// Tells how long something has been going on, for people who wait.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_has_a_cost() {
        let ClockEntry { empty_ns, empty_p99_ns, tick_ns } = clock();
        assert!(empty_ns <= empty_p99_ns && tick_ns > 0);
        assert!(empty_ns < SHORTEST_SAMPLE_NS / 10, "a reading of {empty_ns} ns drowns in no sample");
    }

    #[test]
    fn short_work_is_repeated_until_it_fills_a_sample() {
        assert_eq!(passes_for(100_000), 1);
        assert_eq!(passes_for(99_999), 2);
        assert_eq!(passes_for(1_000), 100);
        assert_eq!(passes_for(0), 100_000);
    }
}
