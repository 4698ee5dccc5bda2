//! The distance of the nearest pair along the path.

use super::Models;
use super::data::Distances;
use super::motion::Motion;
use super::pack::Packed;
use crate::check::{Outcome, Path};
use crate::measure::Progress;
use crate::scene::{Pair, Scene};
use crate::tree::distance::Proximity;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Beyond this a distance is not told, mm.
pub(super) const FARTHEST_MM: f64 = 100.0;
/// Most places at which it is found. On a screen of 2000 pixels each has half of one.
const MOST_PLACES: usize = 4096;
/// Places that one thread takes at a time; within them a query begins with what the last one found.
const CHUNK: usize = 128;

/// Whether a pair touches before the first move.
fn touch_at_first(outcome: &Outcome, pair: Pair) -> bool {
    outcome.events.iter().any(|event| event.kind.is_collision() && event.first.place <= 0.0 && event.pair.is(pair))
}

/// The nearest pair and its distance at places along the path and where events are nearest. Cutter and workpiece do not count, nor
/// pairs that `check` takes for neighbours.
pub(super) fn along(
    scene: &Scene,
    path: &Path,
    motion: &Motion,
    outcome: &Outcome,
    models: &Models,
    progress: &dyn Progress,
) -> Distances {
    let counts = |pair: &Pair| !scene.is_cutting(*pair) && !touch_at_first(outcome, *pair);
    let kept = outcome.decisions.iter().filter(|decision| decision.dropped.is_none()).map(|decision| decision.pair);
    let pairs: Vec<Pair> = kept.filter(counts).collect();
    let stride = path.samples().len().div_ceil(MOST_PLACES).max(1);
    let mut places: Vec<f64> = (0..=path.samples().len()).step_by(stride).map(|at| at as f64).collect();
    places.extend(outcome.events.iter().flat_map(|event| [event.first.place, event.nearest.place, event.last.place]));
    places.sort_by(f64::total_cmp);
    places.dedup();
    let of_chunk = |chunk: &[f64]| {
        let mut nearest = Nearest { scene, path, pairs: &pairs, models, states: BTreeMap::new(), last: 0 };
        let found: Vec<_> = chunk.iter().map(|&place| nearest.at(place)).collect();
        progress.advance((chunk.len() * stride) as u64);
        found
    };
    let found: Vec<Option<(f64, usize)>> = places.par_chunks(CHUNK).flat_map_iter(of_chunk).collect();
    Distances {
        pairs: pairs.iter().map(|pair| [pair.a, pair.b]).collect(),
        farthest_mm: FARTHEST_MM,
        keys: Packed::f32(places.iter().map(|&place| motion.key_at(place))),
        mm: Packed::f32(found.iter().map(|found| found.map_or(FARTHEST_MM, |(mm, _)| mm))),
        nearest: Packed::u32(found.iter().map(|found| found.map_or(u32::MAX, |(_, pair)| pair as u32))),
    }
}

/// Asks all pairs at one place after another.
struct Nearest<'a> {
    scene: &'a Scene,
    path: &'a Path<'a>,
    pairs: &'a [Pair],
    models: &'a Models,
    /// What the last query of each pair left behind.
    states: BTreeMap<usize, Proximity>,
    /// The pair that was nearest: asked first, so that the others have less to look for.
    last: usize,
}

impl Nearest<'_> {
    /// The least distance, mm, and the number of its pair; `None` when none is nearer than [`FARTHEST_MM`].
    fn at(&mut self, place: f64) -> Option<(f64, usize)> {
        let poses = self.scene.machine.forward(&self.path.position_at(place));
        let tool = self.path.tool(place.ceil() as usize);
        let mut least: Option<(f64, usize)> = None;
        let others = (0..self.pairs.len()).filter(|&pair| pair != self.last);
        for number in std::iter::once(self.last).chain(others) {
            let Some(&pair) = self.pairs.get(number) else { continue };
            if !self.scene.is_mounted(pair, tool) {
                continue;
            }
            let below = least.map_or(FARTHEST_MM, |(mm, _)| mm);
            let Some([a, b]) = self.models.of(pair) else { continue };
            let state = self.states.entry(number).or_default();
            let mm = a.distance_mm(b, &self.scene.a_from_b(pair, &poses), below, state);
            if mm < below {
                least = Some((mm, number));
            }
        }
        if let Some((_, pair)) = least {
            self.last = pair;
        }
        least
    }
}
