//! The path in as few keys as show it: every end of a move, the ends of events, and what lies between them off the straight.
//!
//! D. H. Douglas and T. K. Peucker, "Algorithms for the reduction of the number of points required to represent a digitized line
//! or its caricature", 1973, in axis space with time as the parameter: between keys the page takes axes to be linear in time.

use crate::check::{Event, Path};
use crate::scene::ProgramRun;
use rs274::{Axis, Position};

/// How far an axis may be from where the keys say, mm and degrees: below what a screen shows of a machine.
const OFF: f64 = 0.005;

/// The keys of a path.
pub(super) struct Motion {
    /// Places on the path, increasing; the first is 0.
    pub places: Vec<f64>,
    /// Time at each, s.
    pub times_s: Vec<f64>,
    /// Axis positions at each, mm and radians.
    pub positions: Vec<Position>,
    /// For each move of the program, the number of its last key; a move without one has its predecessor's.
    pub last_keys: Vec<u32>,
}

impl Motion {
    /// Takes the keys out of a path.
    pub fn new(path: &Path, run: &ProgramRun, events: &[Event]) -> Self {
        let mut fixed: Vec<f64> = vec![0.0];
        for (at, sample) in path.samples().iter().enumerate() {
            let next = path.samples().get(at + 1);
            if next.is_none_or(|next| next.move_index != sample.move_index) {
                fixed.push((at + 1) as f64);
            }
        }
        fixed.extend(events.iter().flat_map(|event| [event.first.place, event.last.place, event.nearest.place]));
        fixed.sort_by(f64::total_cmp);
        fixed.dedup();
        let mut places = vec![0.0];
        for pair in fixed.windows(2) {
            let between: Vec<f64> = std::iter::once(pair[0])
                .chain((pair[0].floor() as usize + 1..pair[1].ceil() as usize).map(|at| at as f64))
                .chain(std::iter::once(pair[1]))
                .collect();
            keep(path, &between, &mut places);
        }
        let mut last_keys = vec![0; run.program.moves.len()];
        for (key, &place) in places.iter().enumerate().skip(1) {
            last_keys[path.sample_at(place).move_index] = key as u32;
        }
        for index in 1..last_keys.len() {
            last_keys[index] = last_keys[index].max(last_keys[index - 1]);
        }
        Self {
            times_s: places.iter().map(|&place| path.time_s(place)).collect(),
            positions: places.iter().map(|&place| path.position_at(place)).collect(),
            places,
            last_keys,
        }
    }

    /// The number of the key at a place of the path, with the part of the way to the next one.
    pub fn key_at(&self, place: f64) -> f64 {
        let next = self.places.partition_point(|&key| key <= place);
        let before = next.saturating_sub(1);
        match self.places.get(next) {
            Some(&after) => before as f64 + (place - self.places[before]) / (after - self.places[before]),
            None => before as f64,
        }
    }
}

/// Appends the places that are needed to go from the first of `between`, which is kept already, to the last.
fn keep(path: &Path, between: &[f64], kept: &mut Vec<f64>) {
    let (Some(&first), Some(&last)) = (between.first(), between.last()) else { return };
    let mut farthest = (OFF, 0);
    if between.len() > 2 {
        let ends = [first, last].map(|place| (path.time_s(place), path.position_at(place)));
        for (index, &place) in between.iter().enumerate().take(between.len() - 1).skip(1) {
            let off =
                off_straight(&ends, path.time_s(place), &path.position_at(place), (place - first) / (last - first));
            if off > farthest.0 {
                farthest = (off, index);
            }
        }
    }
    if farthest.1 == 0 {
        kept.push(last);
    } else {
        keep(path, &between[..=farthest.1], kept);
        keep(path, &between[farthest.1..], kept);
    }
}

/// How far the position that is worst off is from the straight between the ends, mm or degrees. Where no time passes, the part
/// of the way counts.
fn off_straight(ends: &[(f64, Position); 2], time: f64, position: &Position, part: f64) -> f64 {
    let [(begin, from), (end, to)] = ends;
    let part = if end > begin { (time - begin) / (end - begin) } else { part };
    let off = |axis: Axis| {
        let off = (position[axis] - from[axis] - part * (to[axis] - from[axis])).abs();
        if axis.is_rotary() { off.to_degrees() } else { off }
    };
    Axis::ALL.into_iter().map(off).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn shipped(name: &str) -> (Scene, ProgramRun) {
        let scene = Scene::find(name).unwrap();
        let run = scene.program.clone().unwrap();
        (scene, run)
    }

    #[test]
    fn keys_follow_the_path_and_are_few() {
        // Tool-centre-point moves are curves in axis space, and need more.
        for (name, most) in [("mill-vise", 0.33), ("trunnion-impeller", 0.66)] {
            let (scene, run) = shipped(name);
            let path = Path::new(&scene, &run).unwrap();
            let motion = Motion::new(&path, &run, &[]);
            let (keys, samples) = (motion.places.len(), path.samples().len());
            assert!((keys as f64) < most * samples as f64, "{name}: {keys} keys of {samples} samples");
            assert_eq!(*motion.places.last().unwrap(), path.samples().len() as f64);
            for at in 0..=path.samples().len() {
                let key = motion.key_at(at as f64);
                let (before, after) = (key.floor() as usize, key.ceil() as usize);
                let ends = [before, after].map(|key| (motion.times_s[key], motion.positions[key]));
                let off = off_straight(&ends, path.time_s(at as f64), &path.position(at), key.fract());
                assert!(off <= OFF, "{name} at {at}: {off}");
            }
        }
    }

    #[test]
    fn every_move_ends_at_a_key() {
        let (scene, run) = shipped("mill-vise");
        let path = Path::new(&scene, &run).unwrap();
        let motion = Motion::new(&path, &run, &[]);
        for (step, &key) in run.program.moves.iter().zip(&motion.last_keys) {
            assert_eq!(motion.positions[key as usize], step.end, "line {}", step.line);
        }
    }
}
