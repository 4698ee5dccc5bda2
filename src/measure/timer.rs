//! The clock.

use std::hint::black_box;
use std::time::Instant;

/// Shortest sample worth keeping, ns: a thousand times the resolution and cost of the clock (some tens of ns).
pub const SHORTEST_SAMPLE_NS: u64 = 100_000;

/// Runs `work` and returns the wall time, ns, and its result, which the compiler must assume is used.
pub fn time<R>(work: impl FnOnce() -> R) -> (u64, R) {
    let start = Instant::now();
    let result = black_box(work());
    let ns = u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX);
    (ns, result)
}

/// How often a piece of work that once took `ns` must be repeated to fill [`SHORTEST_SAMPLE_NS`].
#[must_use]
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
    #[must_use]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Seconds since the start.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_work_is_repeated_until_it_fills_a_sample() {
        assert_eq!(passes_for(100_000), 1);
        assert_eq!(passes_for(99_999), 2);
        assert_eq!(passes_for(1_000), 100);
        assert_eq!(passes_for(0), 100_000);
    }
}
