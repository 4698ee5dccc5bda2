//! The deadline as a measured quantity: how long from a sample to its verdict.
//!
//! `judge` times the judge alone over stretches of a program, warm (as in a watch) and cold (caches evicted, and what the last sample said
//! forgotten, before each of a few hundred samples), until the samples or the time of the row are used up. `network` runs the simulated control and the watch over the loopback address, and takes
//! the time from the sample's entry in the server to the control's confirmation of the verdict, by the machine's one clock.

use crate::config::Config;
use crate::control;
use crate::judge::{self, Judge, State};
use crate::monitor::Monitor;
use crate::numbers::between;
use crate::play::Plan;
use crate::watch;
use anyhow::{Context as _, Result};
use bvbench::measure::timer;
use bvbench::registry::Variant;
use bvbench::scene::{ProgramRun, Scene};
use clap::Args;
use rs274::Position;
use serde::{Deserialize, Serialize};
use std::hint::black_box;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio::runtime::Runtime;
use tokio_util::sync::CancellationToken;

/// Cycles that are measured, ms.
pub const CYCLES_MS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
/// Buffer that is read to evict caches, and by each thread of the load, bytes: larger than the caches of most processors.
const BUFFER_BYTES: usize = 64 << 20;
/// Stretches of the program in which consecutive samples are judged.
const STRETCHES: usize = 20;
/// Order in which they are: every `STRIDE`th, so that a row whose time is used up has samples from the whole program. No divisor of `STRETCHES`.
const STRIDE: usize = 7;
/// Bytes of a cache line.
const LINE: usize = 64;

/// A row of `latency.csv`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct LatencyRow {
    /// `judge` or `network`.
    pub way: String,
    /// The scene.
    pub scene: String,
    /// The variant.
    pub variant: String,
    /// Cycle of the control, ns.
    pub cycle_ns: u64,
    /// `idle`, or `busy` with a thread per processor that reads memory.
    pub load: String,
    /// `warm` or `cold`.
    pub cache: String,
    /// Samples.
    pub samples: u64,
    /// Median.
    pub p50_ns: u64,
    /// 99th percentile.
    pub p99_ns: u64,
    /// 99.9th percentile.
    pub p999_ns: u64,
    /// Longest.
    pub max_ns: u64,
    /// Deadline of the configuration.
    pub deadline_ns: u64,
    /// Samples that took longer than the deadline.
    pub late: u64,
    /// Samples that came with newer ones and were not judged.
    pub superseded: u64,
}

/// What is measured.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Most samples of the judge alone
    #[arg(long, default_value_t = 10_000)]
    pub samples: usize,
    /// Samples of the judge alone with cold caches
    #[arg(long, default_value_t = 200)]
    pub cold: usize,
    /// Seconds per row of the judge alone, after which it has fewer samples
    #[arg(long, default_value_t = 4.0, value_parser = between(3600.0, "s"))]
    pub judge_s: f64,
    /// Seconds per row over the network; 0 to leave it out
    #[arg(long, default_value_t = 3.0, value_parser = between(3600.0, "s"))]
    pub network_s: f64,
}

/// One measurement's conditions.
#[derive(Clone, Copy, Debug)]
struct Conditions<'a> {
    scene: &'a Scene,
    variant: &'a Variant,
    config: &'a Config,
    load: &'static str,
}

/// Measures every variant at every cycle, idle and busy; `told` hears of each row.
///
/// # Errors
/// When the program cannot be sampled, a variant is refused, or the network fails.
pub fn measure(
    scene: &Arc<Scene>,
    run: &ProgramRun,
    config: &Config,
    variants: &[&Variant],
    budget: &Budget,
    told: &mut dyn FnMut(&LatencyRow),
) -> Result<Vec<LatencyRow>> {
    let mut rows = Vec::new();
    for load in ["idle", "busy"] {
        let _load = (load == "busy").then(Load::start);
        for cycle_ms in CYCLES_MS {
            let config = Config { cycle_s: cycle_ms / 1e3, ..config.clone() };
            for &variant in variants {
                let conditions = Conditions { scene, variant, config: &config, load };
                let mut add = |row: LatencyRow| {
                    told(&row);
                    rows.push(row);
                };
                let stretches = stretches(scene, run, &config, budget.samples)?;
                add(conditions.judge(&stretches, budget.judge_s, false)?);
                let stretches = self::stretches(scene, run, &config, budget.cold)?;
                add(conditions.judge(&stretches, budget.judge_s, true)?);
                if budget.network_s > 0.0 {
                    add(conditions.network(run, budget.network_s)?);
                }
            }
        }
    }
    Ok(rows)
}

/// Samples of a program that nobody holds: about `most`, in stretches from its beginning to its end, in the order in which they are judged.
fn stretches(scene: &Scene, run: &ProgramRun, config: &Config, most: usize) -> Result<Vec<Vec<State>>> {
    let dynamics = config.dynamics(&scene.machine)?;
    let plan = Plan::new(scene, run, &dynamics, config.cycle_s)?;
    let count = (plan.duration_s() / config.cycle_s) as usize;
    let state = |cycle: usize| {
        let [before, now] = [cycle, cycle + 1].map(|cycle| plan.at(cycle as f64 * config.cycle_s));
        let speed = |i: usize| (now.position.0[i] - before.position.0[i]) / config.cycle_s;
        let velocity = Position(std::array::from_fn(speed));
        let error = |i: usize| judge::velocity_error(velocity.0[i], dynamics.resolution[i], config.cycle_s, 0.0);
        State {
            position: now.position,
            velocity,
            velocity_error: Position(std::array::from_fn(error)),
            interval_s: config.cycle_s,
            spread_s: 0.0,
            tool: now.tool,
        }
    };
    let length = (most.min(count) / STRETCHES).max(1);
    let stretch = |index: usize| {
        let begin = (index * STRIDE % STRETCHES) * count / STRETCHES;
        // One more, which only warms up.
        (begin..=begin + length).map(state).collect()
    };
    Ok((0..STRETCHES).map(stretch).collect())
}

impl Conditions<'_> {
    /// The judge alone, for as long as `most_s` allows.
    fn judge(&self, stretches: &[Vec<State>], most_s: f64, is_cold: bool) -> Result<LatencyRow> {
        let mut judge = Judge::new(self.scene, self.variant, self.config.rule(self.scene)?)?;
        let evictor = Evictor::new();
        let (begin, mut times) = (Instant::now(), Vec::new());
        // Each stretch has its share of the time; what a quick one leaves is for the others.
        for (index, stretch) in stretches.iter().enumerate() {
            let until_s = most_s * (index + 1) as f64 / stretches.len() as f64;
            if begin.elapsed().as_secs_f64() >= most_s {
                break;
            }
            let mut states = stretch.iter();
            states.next().map(|first| judge.judge(first));
            for state in states {
                if is_cold {
                    evictor.evict();
                    judge.forget();
                }
                times.push(timer::time(|| judge.judge(state)).0);
                if begin.elapsed().as_secs_f64() >= until_s {
                    break;
                }
            }
        }
        Ok(self.row("judge", if is_cold { "cold" } else { "warm" }, times, 0))
    }

    /// Control and watch over the loopback address.
    fn network(&self, run: &ProgramRun, seconds: f64) -> Result<LatencyRow> {
        let folder = TempDir::new()?;
        let log = folder.path().join("log.csv");
        let own = Runtime::new()?;
        let listener = own.block_on(async { control::listen(SocketAddr::from(([127, 0, 0, 1], 0))) })?;
        let config = Config { endpoint: format!("opc.tcp://{}/", listener.local_addr()?), ..self.config.clone() };
        let stop = CancellationToken::new();
        let result = thread::scope(|scope| {
            let control = scope.spawn(|| {
                own.block_on(async {
                    let options = control::Options { repeat: true, ..control::Options::default() };
                    let (status, _) = tokio::sync::watch::channel(None);
                    control::control(self.scene, run, &config, &options, listener, status, stop.clone()).await
                })
            });
            let judge = Judge::new(self.scene, self.variant, config.rule(self.scene)?)?;
            let monitor = Monitor::new(self.scene, judge, &config);
            let (reports, _) = tokio::sync::watch::channel(None);
            let settings = watch::Settings { log: Some(log.clone()), pki: None, reports, stop: stop.clone() };
            let summary = Runtime::new()?.block_on(async {
                let end = stop.clone();
                tokio::spawn(async move {
                    tokio::time::sleep(Duration::from_secs_f64(seconds)).await;
                    end.cancel();
                });
                watch::run(self.scene, monitor, &config, settings).await
            });
            stop.cancel();
            let control = control.join().map_err(|_| anyhow::anyhow!("the control failed"))?;
            control.and(summary.map_err(anyhow::Error::msg))
        });
        let summary = result?;
        let times = times(&log)?;
        Ok(self.row("network", "warm", times, summary.superseded))
    }

    fn row(&self, way: &str, cache: &str, mut times: Vec<u64>, superseded: u64) -> LatencyRow {
        times.sort_unstable();
        let deadline_ns = (self.config.deadline_s * 1e9) as u64;
        let at = |share: f64| percentile(&times, share);
        LatencyRow {
            way: way.to_owned(),
            scene: self.scene.name.clone(),
            variant: self.variant.info.id.to_owned(),
            cycle_ns: (self.config.cycle_s * 1e9).round() as u64,
            load: self.load.to_owned(),
            cache: cache.to_owned(),
            samples: times.len() as u64,
            p50_ns: at(0.5),
            p99_ns: at(0.99),
            p999_ns: at(0.999),
            max_ns: at(1.0),
            deadline_ns,
            late: times.iter().filter(|&&time| time > deadline_ns).count() as u64,
            superseded,
        }
    }
}

/// The time that a share of the sorted times does not exceed; 0 of none.
pub(crate) fn percentile(sorted: &[u64], share: f64) -> u64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.clamp(1, sorted.len().max(1)) - 1).copied().unwrap_or(0)
}

/// From a sample's entry in the server to the confirmed verdict, ns.
fn times(log: &Path) -> Result<Vec<u64>> {
    #[derive(Deserialize)]
    struct Times {
        published_ns: i64,
        written_ns: i64,
    }
    let mut reader = csv::Reader::from_path(log).with_context(|| format!("cannot read {}", log.display()))?;
    let mut times = Vec::new();
    for row in reader.deserialize() {
        let Times { published_ns, written_ns } = row?;
        if published_ns > 0 && written_ns > 0 {
            times.push(u64::try_from(written_ns - published_ns).unwrap_or(0));
        }
    }
    Ok(times)
}

/// A buffer larger than the caches.
struct Evictor(Vec<u64>);

impl Evictor {
    fn new() -> Self {
        // Not zero: pages of zeros are one and the same page until they are written to.
        Self(vec![1; BUFFER_BYTES / size_of::<u64>()])
    }

    /// Reads a word of every line.
    fn evict(&self) {
        let words = self.0.iter().step_by(LINE / size_of::<u64>());
        black_box(words.fold(0, |sum: u64, word| sum.wrapping_add(*word)));
    }
}

/// A thread per processor that reads memory, until it is dropped.
struct Load(Arc<AtomicBool>, Vec<thread::JoinHandle<()>>);

impl Load {
    fn start() -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let threads = thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let spin = |stop: Arc<AtomicBool>| {
            move || {
                let evictor = Evictor::new();
                while !stop.load(Ordering::Relaxed) {
                    evictor.evict();
                }
            }
        };
        let threads = (0..threads).map(|_| thread::spawn(spin(Arc::clone(&stop)))).collect();
        Self(stop, threads)
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
        for thread in self.1.drain(..) {
            thread.join().ok();
        }
    }
}
