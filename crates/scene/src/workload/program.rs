//! Poses along the scene's program, in the order in which the machine takes them.

use super::{PosedPair, WorkloadError, block_of};
use crate::machine::Poses;
use crate::scene::{Pair, ProgramRun, Scene};
use rs274::{RapidPath, Sample, Sampling, path};

/// Relative tolerance on the requested number of samples.
const COUNT_TOLERANCE: f64 = 0.02;

/// Largest number of corrections of the step. The number of samples is nearly proportional to 1 / step, so few are needed.
const CORRECTIONS: usize = 8;

/// About `count` machine poses along the path, with their program lines.
pub struct Run {
    poses: Vec<MachinePose>,
}

/// The machine at a moment of the program.
struct MachinePose {
    line: u32,
    /// The tool in the spindle.
    tool: u32,
    poses: Poses,
}

impl Run {
    /// Runs the program with about `count` poses; every move has at least one.
    ///
    /// # Errors
    /// [`WorkloadError::OutOfLimits`] at the first line that leaves the machine's limits.
    pub fn new(scene: &Scene, run: &ProgramRun, count: usize) -> Result<Self, WorkloadError> {
        let rapids = &scene.rates.rapid_path;
        let samples = run.samples(&scene.machine, &sampling(run, rapids, count), rapids)?;
        let tools = run.tools();
        let mut poses = Vec::with_capacity(samples.len());
        for Sample { position, line, move_index, .. } in samples {
            scene.machine.check_limits(&position).map_err(|cause| WorkloadError::OutOfLimits {
                file: run.file.clone(),
                line,
                cause,
            })?;
            poses.push(MachinePose { line, tool: tools[move_index], poses: scene.machine.forward(&position) });
        }
        Ok(Self { poses })
    }

    /// The poses of one pair while both parts are mounted. Blocks of neighbouring poses on the path are clusters.
    pub fn poses_of(&self, scene: &Scene, pair: Pair) -> Vec<PosedPair> {
        self.steps_of(scene, pair).map(|(_, pose)| pose).collect()
    }

    /// Like [`Run::poses_of`], with the number of each pose's step in the program.
    pub fn steps_of(&self, scene: &Scene, pair: Pair) -> impl Iterator<Item = (usize, PosedPair)> {
        let pose = move |(index, (step, at)): (usize, (usize, &MachinePose))| {
            let a_from_b = scene.a_from_b(pair, &at.poses);
            (step, PosedPair { a_from_b, cluster: block_of(index), line: Some(at.line), depth_mm: None })
        };
        let mounted = self.poses.iter().enumerate().filter(move |(_, at)| scene.is_mounted(pair, at.tool));
        mounted.enumerate().map(pose)
    }
}

/// The sampling, a common multiple of the scene's steps, that gives about `count` samples.
fn sampling(run: &ProgramRun, rapids: &RapidPath, count: usize) -> Sampling {
    // Too many are counted as twice the most.
    let found = |factor: f64| {
        let sampling = scaled(&run.sampling, factor);
        path::count(&run.program, &run.start, &sampling, rapids).unwrap_or(2 * path::MAX_SAMPLES)
    };
    let wanted = count.max(1) as f64;
    let error = |found: usize| (found as f64 / wanted - 1.0).abs();
    let (mut factor, mut best) = (1.0, 1.0);
    let mut samples = found(factor);
    let mut best_error = error(samples);
    for _ in 0..CORRECTIONS {
        if best_error <= COUNT_TOLERANCE || samples == 0 {
            break;
        }
        factor *= samples as f64 / wanted;
        samples = found(factor);
        if error(samples) < best_error {
            (best, best_error) = (factor, error(samples));
        }
    }
    scaled(&run.sampling, best)
}

/// Multiplies the steps by `factor`, and the chord tolerance by its square, because the sagitta of a chord grows with the square of its
/// length.
fn scaled(sampling: &Sampling, factor: f64) -> Sampling {
    Sampling {
        step_mm: sampling.step_mm * factor,
        step_deg: sampling.step_deg * factor,
        chord_mm: sampling.chord_mm * factor * factor,
    }
}
