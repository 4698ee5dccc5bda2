//! Chunks: the poses that are counted and timed together.
//!
//! A chunk holds poses of one workload, one pair and one stratum, consecutive where they come from a path. Every case runs
//! the same chunks, which is what makes the comparison paired. Strata get equal shares, because a program spends most of
//! its time far from everything and a mean over it would say little about the rest. No two chunks of a run share a line (an approach, a ray,
//! a stretch of a path), so that chunks are independent of one another. The exception is a recording, where a stratum that finds no line of
//! its own shares another's: the mean is that of all its poses, so that no stratum may be left out.

use super::judged::JudgedPair;
use crate::analysis::grouped;
use crate::record::{RECORDED, Stratum};
use std::collections::BTreeSet;

/// Most poses in a chunk of a run. Intervals come from how chunks differ, so that of the few hundred poses of a quick run many short ones
/// say more than few long ones; still a run over one of them is long against a call and what it finds cold.
pub const SHORT: usize = 16;
/// A shorter chunk of a run is not worth timing, unless it is the first of a stratum of a recording.
const SHORTEST: usize = 8;
/// Poses in a chunk where something is kept or done for each chunk besides: a row of every cell of an audit, a message to every engine.
pub const LONG: usize = 64;
/// Chunks of a stratum, pair and workload that the peers run too, at most; spread evenly over all of them.
const PEER_CHUNKS: usize = 4;
/// Of how many pairs and workloads of a stratum the control runs a pose: it tests some 10^8 pairs of triangles there, and nobody asks for
/// more of it than an order of magnitude over all strata.
const CONTROL_PAIRS: usize = 1;
/// A stratum with fewer poses than this in a workload is left out there, unless the workload is a recording.
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
/// are fewer chunks. Every stratum of a recording has a chunk, of lines of other chunks where no other line is left.
pub fn select(judged: &[JudgedPair], budget: usize) -> Vec<Chunk> {
    let mut chosen: Vec<(Stratum, usize, Vec<Vec<usize>>)> = Vec::new();
    let members = |stratum: Stratum| judged.iter().filter(|pair| is_member(pair, stratum)).count();
    let quotas = Stratum::ALL.map(|stratum| (budget / Stratum::ALL.len() / members(stratum).max(1) / SHORT).max(1));
    for (index, pair) in judged.iter().enumerate() {
        let mut strata = supplies(pair, quotas);
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

/// Whether a pair has enough poses of a stratum for it to be timed.
fn is_member(pair: &JudgedPair, stratum: Stratum) -> bool {
    let count = pair.poses.iter().filter(|pose| pose.stratum == stratum).count();
    count >= if pair.workload == RECORDED { 1 } else { FEWEST_POSES }
}

/// The strata of a pair that are timed, the rarest first: it has the first choice of lines.
fn supplies(pair: &JudgedPair, quotas: [usize; Stratum::ALL.len()]) -> Vec<Supply> {
    let members = Stratum::ALL.into_iter().zip(quotas).filter(|(stratum, _)| is_member(pair, *stratum));
    let mut strata: Vec<Supply> = members.map(|(stratum, quota)| Supply::new(pair, stratum, quota)).collect();
    strata.sort_by_key(|supply| supply.lines.len());
    if pair.workload == RECORDED {
        let lines: BTreeSet<u32> = pair.poses.iter().map(|pose| pose.line).collect();
        let share = (lines.len() / strata.len().max(1)).max(1);
        strata.iter_mut().for_each(|supply| supply.share = Some(share));
    }
    strata
}

/// The lines of a pair that have poses of a stratum, and the chunks made of them.
struct Supply {
    stratum: Stratum,
    quota: usize,
    /// Of a recording, whose strata must all be timed: most lines of a chunk, so that the other strata find lines, too.
    share: Option<usize>,
    /// Lines with their poses, in an order that spreads over all of them.
    lines: Vec<(u32, Vec<usize>)>,
    chunks: Vec<Vec<usize>>,
}

impl Supply {
    fn new(pair: &JudgedPair, stratum: Stratum, quota: usize) -> Self {
        let of_stratum = pair.poses_in(stratum).into_iter();
        let mut lines: Vec<_> = grouped(of_stratum.map(|pose| (pair.poses[pose].line, pose))).into_iter().collect();
        // Multiples of the golden ratio modulo 1 divide the lines evenly, however many are taken.
        let place = |line: u32| (f64::from(line) * 0.618_033_988_749_895).fract();
        lines.sort_by(|a, b| place(a.0).total_cmp(&place(b.0)));
        Self { stratum, quota, share: None, lines, chunks: Vec::new() }
    }

    /// Makes one more chunk of lines that are not used yet; `false` when there need not or cannot be one. The first chunk of a stratum of a
    /// recording may be of any length, and takes used lines where no other is left.
    fn take(&mut self, used: &mut BTreeSet<u32>) -> bool {
        if self.chunks.len() == self.quota {
            return false;
        }
        let must_be = self.share.is_some() && self.chunks.is_empty();
        let shortest = if must_be { 1 } else { SHORTEST };
        let takes_used = must_be && self.lines.iter().all(|(line, _)| used.contains(line));
        let free = self.lines.iter().filter(|(line, _)| takes_used || !used.contains(line));
        let (mut poses, mut lines) = (Vec::new(), Vec::new());
        for (line, of_line) in free.take(self.share.unwrap_or(usize::MAX)) {
            poses.extend(of_line.iter().copied().take(SHORT - poses.len()));
            lines.push(*line);
            if poses.len() == SHORT {
                break;
            }
        }
        if poses.len() < shortest {
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

    /// One pair, with so many far and so many colliding poses on each line.
    fn pair_of(workload: &str, lines: &[(usize, usize)]) -> JudgedPair {
        let pose = |(line, stratum)| JudgedPose {
            a_from_b: Isometry::identity(),
            witness: None,
            contained: false,
            stratum,
            band: Band::Clear,
            clearance_mm: 0.0,
            line,
        };
        let of_line = |(line, &(far, colliding)): (u32, &(usize, usize))| {
            [vec![(line, Stratum::Far); far], vec![(line, Stratum::Colliding); colliding]].concat()
        };
        let poses = (0..).zip(lines).flat_map(of_line).map(pose).collect();
        JudgedPair { workload: workload.to_owned(), pair: Pair { a: 0, b: 1 }, poses }
    }

    /// The mean over a recording is that of all its poses, so that each of its strata is timed.
    #[test]
    fn no_stratum_of_a_recording_is_left_out() {
        assert_eq!(crate::workload::Source::Recorded.name(), RECORDED);
        let (hit, far) = (|poses: usize| (Stratum::Colliding, poses), |poses: usize| (Stratum::Far, poses));
        let none: &[(usize, usize)] = &[];
        let spread: &[(usize, usize)] = &[(60, 4), (60, 4), (60, 4), (61, 3), (61, 3)];
        let grouped: &[(usize, usize)] = &[(46, 18), (64, 0), (64, 0), (64, 0), (64, 0)];
        for (workload, lines, expected) in [
            (RECORDED, none, vec![]),
            (RECORDED, &[(0, 1)], vec![hit(1)]),
            // A single line is shared.
            (RECORDED, &[(14, 9)], vec![hit(9), far(14)]),
            (RECORDED, &[(40, 15)], vec![hit(15), far(16)]),
            (RECORDED, &[(10, 3), (10, 3)], vec![hit(3), far(10)]),
            // The same poses in two orders.
            (RECORDED, spread, vec![hit(8), far(16), far(16), far(16)]),
            (RECORDED, grouped, vec![hit(16), far(16), far(16), far(16), far(16)]),
            ("random", &[(40, 15)], vec![far(16)]),
            ("random", &[(14, 15)], vec![]),
        ] {
            let pairs = [pair_of(workload, lines)];
            let chunks = select(&pairs, 512);
            let timed = || chunks.iter().filter(|chunk| chunk.participants != Participants::Control);
            let found: Vec<(Stratum, usize)> = timed().map(|chunk| (chunk.stratum, chunk.poses.len())).collect();
            assert_eq!(found, expected, "{workload} {lines:?}");
            // Where there are lines for all strata, no two chunks share one.
            let lines_of = |chunk: &Chunk| -> BTreeSet<u32> {
                chunk.poses.iter().map(|&pose| pairs[0].poses[pose].line).collect()
            };
            let distinct: BTreeSet<u32> = timed().flat_map(lines_of).collect();
            let total: usize = timed().map(|chunk| lines_of(chunk).len()).sum();
            assert!(lines.len() < 2 || total == distinct.len(), "{workload} {lines:?}");
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
