//! Chunks: the poses that are counted and timed together.
//!
//! A chunk holds poses of one workload, one pair and one stratum, consecutive where they come from a path. Every case runs
//! the same chunks, which is what makes the comparison paired. Strata get equal shares, because a program spends most of
//! its time far from everything and a mean over it would say little about the rest. No two chunks of a run share a line (an approach, a ray,
//! a stretch of a path), so that chunks are independent of one another.

use super::judged::JudgedPair;
use crate::record::{RECORDED, Stratum};
use std::collections::{BTreeMap, BTreeSet};

/// Most poses in a chunk of a run. Intervals come from how chunks differ, so that of the few hundred poses of a quick run many short ones
/// say more than few long ones; still a run over one of them is long against a call and what it finds cold.
pub const SHORT: usize = 16;
/// A shorter chunk of a run is not worth timing, unless a recording has no more poses.
const SHORTEST: usize = 8;
/// Poses in a chunk where something is kept or done for each chunk besides: a row of every cell of an audit, a message to every engine.
pub const LONG: usize = 64;
/// Chunks of a stratum, pair and workload that the peers run too, at most; spread evenly over all of them.
const PEER_CHUNKS: usize = 4;
/// Of how many pairs and workloads of a stratum the control runs a pose: it tests some 10^8 pairs of triangles there, and nobody asks for
/// more of it than an order of magnitude over all strata.
const CONTROL_PAIRS: usize = 1;
/// A stratum with fewer poses than this in a workload is left out there. A recording that has no stratum of so many is timed by its largest.
const FEWEST_POSES: usize = 16;

/// Who runs a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Participants {
    /// Every case but the control; of each workload, pair and stratum a few chunks are also for the peers.
    Everyone,
    /// Every case but the control and the peers, whose queries can be a hundred times slower.
    Volumes,
    /// The control and the reference only: a single pose, since the control tests every pair of triangles.
    Control,
}

/// Poses that are counted and timed together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Number within the scene.
    pub number: u32,
    /// Which of the scene's judged pairs.
    pub pair: usize,
    /// Stratum of all its poses.
    pub stratum: Stratum,
    /// Indices into the judged pair's poses.
    pub poses: Vec<usize>,
    /// Who runs it.
    pub participants: Participants,
}

/// Chooses about `budget` poses from what was judged: equal shares for the strata, then for the pairs that have poses of a stratum. Chunks
/// hold at most [`SHORT`] poses, of whole lines as far as these fit, and no line has poses in two chunks: where lines run out there
/// are fewer chunks.
pub fn select(judged: &[JudgedPair], budget: usize) -> Vec<Chunk> {
    let mut chosen: Vec<(Stratum, usize, Vec<Vec<usize>>)> = Vec::new();
    let of_recording = fewest_recorded(judged);
    let fewest = |pair: &JudgedPair| if pair.workload == RECORDED { of_recording } else { FEWEST_POSES };
    let is_member = |pair: &JudgedPair, stratum: Stratum| count(pair, stratum) >= fewest(pair);
    let members = |stratum: Stratum| judged.iter().filter(|pair| is_member(pair, stratum)).count();
    let quotas = Stratum::ALL.map(|stratum| budget / Stratum::ALL.len() / members(stratum).max(1) / SHORT);
    for (index, pair) in judged.iter().enumerate() {
        let mut strata: Vec<Supply> = Stratum::ALL
            .into_iter()
            .zip(quotas)
            .filter(|(stratum, _)| is_member(pair, *stratum))
            .map(|(stratum, quota)| Supply::new(pair, stratum, quota.max(1), fewest(pair)))
            .collect();
        // The rarest has the first choice.
        strata.sort_by_key(|supply| supply.lines.len());
        let mut used = BTreeSet::new();
        while strata.iter_mut().map(|supply| supply.take(&mut used)).fold(false, |any, taken| any | taken) {}
        chosen.extend(strata.into_iter().map(|supply| (supply.stratum, index, supply.chunks)));
    }
    chosen.sort_by_key(|(stratum, pair, _)| (*stratum, *pair));
    let mut chunks = Vec::new();
    let mut with_control = BTreeSet::new();
    for (stratum, pair, of_pair) in chosen {
        let every = of_pair.len().div_ceil(PEER_CHUNKS).max(1);
        let mut add = |poses: Vec<usize>, participants| {
            chunks.push(Chunk { number: chunks.len() as u32, pair, stratum, poses, participants });
        };
        // One that the others answer too.
        let control = of_pair.get(of_pair.len() / 2).map(|poses| poses[poses.len() / 2]);
        for (place, poses) in of_pair.into_iter().enumerate() {
            add(poses, if place % every == 0 { Participants::Everyone } else { Participants::Volumes });
        }
        if let Some(pose) = control.filter(|_| with_control.insert(stratum)) {
            add(vec![pose], Participants::Control);
        }
    }
    chunks
}

fn count(pair: &JudgedPair, stratum: Stratum) -> usize {
    pair.poses.iter().filter(|pose| pose.stratum == stratum).count()
}

/// The fewest poses of a stratum that are timed in a recording.
fn fewest_recorded(judged: &[JudgedPair]) -> usize {
    let pairs = judged.iter().filter(|pair| pair.workload == RECORDED);
    let largest = pairs.flat_map(|pair| Stratum::ALL.map(|stratum| count(pair, stratum))).max();
    largest.unwrap_or_default().clamp(1, FEWEST_POSES)
}

/// The lines of a pair that have poses of a stratum, and the chunks made of them.
struct Supply {
    stratum: Stratum,
    quota: usize,
    /// A shorter chunk is not worth timing.
    shortest: usize,
    /// Lines with their poses, in an order that spreads over all of them.
    lines: Vec<(u32, Vec<usize>)>,
    chunks: Vec<Vec<usize>>,
}

impl Supply {
    fn new(pair: &JudgedPair, stratum: Stratum, quota: usize, fewest: usize) -> Self {
        let mut lines: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for pose in pair.poses_in(stratum) {
            lines.entry(pair.poses[pose].line).or_default().push(pose);
        }
        let mut lines: Vec<_> = lines.into_iter().collect();
        // Multiples of the golden ratio modulo 1 divide the lines evenly, however many are taken.
        let place = |line: u32| (f64::from(line) * 0.618_033_988_749_895).fract();
        lines.sort_by(|a, b| place(a.0).total_cmp(&place(b.0)));
        Self { stratum, quota, shortest: SHORTEST.min(fewest), lines, chunks: Vec::new() }
    }

    /// Makes one more chunk of lines that are not used yet; `false` when there need not or cannot be one.
    fn take(&mut self, used: &mut BTreeSet<u32>) -> bool {
        if self.chunks.len() == self.quota {
            return false;
        }
        let (mut poses, mut lines) = (Vec::new(), Vec::new());
        for (line, of_line) in self.lines.iter().filter(|(line, _)| !used.contains(line)) {
            poses.extend(of_line.iter().copied().take(SHORT - poses.len()));
            lines.push(*line);
            if poses.len() == SHORT {
                break;
            }
        }
        if poses.len() < self.shortest {
            self.quota = self.chunks.len();
            return false;
        }
        used.extend(lines);
        poses.sort_unstable();
        self.chunks.push(poses);
        true
    }
}

/// As [`select`], but windows of `length` consecutive poses, evenly spread over each pair and stratum, whatever lines they share: for
/// an audit's cells and for other engines, which are asked about few and long chunks.
pub fn select_windows(judged: &[JudgedPair], budget: usize, length: usize) -> Vec<Chunk> {
    let mut chunks = Vec::new();
    for stratum in Stratum::ALL {
        let members: Vec<(usize, Vec<usize>)> = judged
            .iter()
            .enumerate()
            .map(|(index, pair)| (index, pair.poses_in(stratum)))
            .filter(|(_, poses)| poses.len() >= FEWEST_POSES)
            .collect();
        let share = budget / Stratum::ALL.len() / members.len().max(1);
        for (rank, (pair, poses)) in members.into_iter().enumerate() {
            let mut add = |poses: &[usize], participants| {
                chunks.push(Chunk { number: chunks.len() as u32, pair, stratum, poses: poses.to_vec(), participants });
            };
            let starts = windows(poses.len(), share, length);
            let every = starts.len().div_ceil(PEER_CHUNKS);
            for (window, &start) in starts.iter().enumerate() {
                let end = (start + length).min(poses.len());
                add(
                    &poses[start..end],
                    if window % every == 0 { Participants::Everyone } else { Participants::Volumes },
                );
            }
            if rank < CONTROL_PAIRS {
                // One that the others answer too.
                let middle = starts[starts.len() / 2] + length.min(poses.len()) / 2;
                add(&poses[middle..=middle], Participants::Control);
            }
        }
    }
    chunks
}

/// Starts of evenly spread, disjoint windows of `length` out of `available` poses, about `share` poses in all and at
/// least one window.
fn windows(available: usize, share: usize, length: usize) -> Vec<usize> {
    let count = (share / length).clamp(1, (available / length).max(1));
    let slack = available.saturating_sub(count * length);
    (0..count)
        .map(|window| window * length + slack * (2 * window + 1) / (2 * count))
        .map(|start| if available < length { 0 } else { start })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;
    use crate::measure::judged::JudgedPose;
    use crate::record::Band;
    use crate::scene::Pair;

    /// One pair on one line, with so many far and so many colliding poses.
    fn pair_of(workload: &str, (far, colliding): (usize, usize)) -> JudgedPair {
        let pose = |stratum| JudgedPose {
            a_from_b: Isometry::identity(),
            witness: None,
            contained: false,
            stratum,
            band: Band::Clear,
            clearance_mm: 0.0,
            line: 0,
        };
        let strata = [(Stratum::Far, far), (Stratum::Colliding, colliding)];
        let poses = strata.into_iter().flat_map(|(stratum, poses)| vec![pose(stratum); poses]).collect();
        JudgedPair { workload: workload.to_owned(), pair: Pair { a: 0, b: 1 }, poses }
    }

    #[test]
    fn a_recording_is_timed_however_few_poses_it_has() {
        let none: &[(Stratum, usize)] = &[];
        for (workload, poses, expected) in [
            (RECORDED, (0, 0), none),
            (RECORDED, (0, 1), &[(Stratum::Colliding, 1)]),
            (RECORDED, (14, 9), &[(Stratum::Far, 14)]),
            (RECORDED, (15, 15), &[(Stratum::Colliding, 15)]),
            // Where a stratum has enough it is as in other workloads.
            (RECORDED, (40, 15), &[(Stratum::Far, 16)]),
            ("random", (40, 15), &[(Stratum::Far, 16)]),
            ("random", (14, 15), none),
        ] {
            let chunks = select(&[pair_of(workload, poses)], 512);
            let timed = chunks.iter().filter(|chunk| chunk.participants != Participants::Control);
            let timed: Vec<(Stratum, usize)> = timed.map(|chunk| (chunk.stratum, chunk.poses.len())).collect();
            assert_eq!(timed, expected, "{workload} {poses:?}");
        }
    }

    #[test]
    fn windows_are_disjoint_and_inside() {
        for (available, share) in [(16, 1000), (64, 64), (65, 500), (1000, 300), (100_000, 512), (130, 10)] {
            for length in [SHORT, LONG] {
                let starts = windows(available, share, length);
                assert!(!starts.is_empty());
                for pair in starts.windows(2) {
                    assert!(pair[0] + length <= pair[1], "{available} {share}: {starts:?}");
                }
                if available >= length {
                    assert!(starts.last().is_some_and(|last| last + length <= available));
                }
            }
        }
        assert_eq!(windows(1000, 300, LONG).len(), 4); // 300 / 64
    }
}
