//! Poses along the scene's program, in the order in which the machine takes them.

use super::{PosedPair, WorkloadError, block_of};
use crate::gcode::{Sample, Sampling, path};
use crate::machine::Poses;
use crate::scene::{Pair, ProgramRun, Scene};

/// Samples within this part of the wanted number are near enough.
const COUNT_TOLERANCE: f64 = 0.02;

/// How often the step is corrected. The number of samples is nearly proportional to 1 / step, so few corrections do.
const CORRECTIONS: usize = 8;

/// Machine poses along the path, about `count` of them, with their program lines.
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
    /// Runs the program, sampled so finely that there are about `count` poses; every move has at least one.
    ///
    /// # Errors
    /// [`WorkloadError::OutOfLimits`] at the first line that leaves the machine's limits.
    pub fn new(scene: &Scene, run: &ProgramRun, count: usize) -> Result<Self, WorkloadError> {
        let mut samples = sampled(run, count);
        run.follow_tip(&scene.machine, &mut samples)?;
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

    /// The poses of one pair, while both parts are there. Neighbours on the path form blocks, and a block is a cluster.
    pub fn poses_of(&self, scene: &Scene, pair: Pair) -> Vec<PosedPair> {
        let pose = |(index, at): (usize, &MachinePose)| PosedPair {
            a_from_b: scene.a_from_b(pair, &at.poses),
            cluster: block_of(index),
            line: Some(at.line),
            depth_mm: None,
        };
        let mounted = self.poses.iter().filter(|at| scene.is_mounted(pair, at.tool));
        mounted.enumerate().map(pose).collect()
    }
}

/// The path sampled with steps that are a common multiple of the scene's, so that about `count` samples result.
fn sampled(run: &ProgramRun, count: usize) -> Vec<Sample> {
    let sample = |factor: f64| path::sample(&run.program, &run.start, &scaled(&run.sampling, factor));
    let error = |samples: &[Sample]| (samples.len() as f64 / count.max(1) as f64 - 1.0).abs();
    let mut factor = 1.0;
    let mut best = sample(factor);
    let mut found = best.len();
    for _ in 0..CORRECTIONS {
        if error(&best) <= COUNT_TOLERANCE || found == 0 {
            break;
        }
        factor *= found as f64 / count.max(1) as f64;
        let samples = sample(factor);
        found = samples.len();
        if error(&samples) < error(&best) {
            best = samples;
        }
    }
    best
}

/// Steps times `factor`; the chord tolerance goes with its square, as the gap under a chord does with its length.
fn scaled(sampling: &Sampling, factor: f64) -> Sampling {
    Sampling {
        step_mm: sampling.step_mm * factor,
        step_deg: sampling.step_deg * factor,
        chord_mm: sampling.chord_mm * factor * factor,
    }
}
