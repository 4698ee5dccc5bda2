//! Verification: every variant's verdict against the exact truth, over many poses, counted by depth band.
//!
//! A hundred thousand poses of a loose volume's query would take minutes, and most of that would go into poses where
//! nothing can be missed. So the query of a safe volume answers a sample of poses only, and the witness argument of
//! [`crate::tree::witness`] answers the others, with the same verdicts. Whatever promises nothing, or is no volume, answers everywhere by its
//! own query; peers, of whose insides that argument says nothing, answer the sample alone. `asked` says how many were asked.

use super::Progress;
use super::folder::write_unit;
use super::judged::{JudgedPair, JudgedPose};
use super::plan::{Case, Plan};
use crate::geometry::Isometry;
use crate::method::{Kind, Model};
use crate::record::rows::CaseKey;
use crate::record::{Band, LineRow, MissRow, RecordError, VerificationRow, write_rows};
use crate::scene::Scene;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Poses that one thread takes at a time.
const BATCH: usize = 256;
/// To as many poses a tree amounts in the progress; some volumes take longer to fit than to ask.
const TREE_STEPS: u64 = 1024;

/// The cases that a verification asks. The control is not run: it tests every pair of triangles by the exact test.
pub fn verified_cases(plan: &Plan) -> Vec<&Case> {
    plan.cases.iter().filter(|case| case.variant.kind != Kind::Control).collect()
}

/// Verdicts of cases over all judged poses, each written to the unit beside it.
///
/// # Errors
/// When a unit cannot be written.
pub fn verify_cases(
    plan: &Plan,
    scene: &Scene,
    judged: &[JudgedPair],
    units: Vec<(&Case, PathBuf)>,
    progress: &dyn Progress,
) -> Result<(), RecordError> {
    let poses: usize = judged.iter().map(|pair| pair.poses.len()).sum();
    let parts: BTreeSet<usize> = judged.iter().flat_map(|pair| [pair.pair.a, pair.pair.b]).collect();
    let steps = poses as u64 + parts.len() as u64 * TREE_STEPS;
    progress.begin(&format!("{}: trees and verdicts", scene.name), steps * units.len() as u64);
    units.into_par_iter().try_for_each(|(case, unit)| {
        let (rows, misses) = verify_case(case, scene, (judged, &parts), plan.budget.asked_poses, progress);
        write_unit(&unit, |folder| {
            write_rows(folder, &rows)?;
            write_rows(folder, &misses)
        })
    })
}

/// Lines with contacts above grazing.
pub fn lines(scene: &Scene, judged: &[JudgedPair], asked_poses: usize) -> Vec<LineRow> {
    judged.iter().flat_map(|pair| lines_of(scene, pair, asked_poses)).collect()
}

/// The golden ratio less one, times 2^64.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// Whether all cases are asked at a pose, of so many poses of a pair. Poses repeat a pattern of offsets, and a constant stride that has a
/// divisor in common with its length meets some offsets only. Multiples of the golden ratio are spread evenly over every residue class
/// (Weyl 1916, Mathematische Annalen 77; Knuth, The Art of Computer Programming, volume 3, section 6.4).
pub(super) fn is_asked(index: usize, poses: usize, asked_poses: usize) -> bool {
    if asked_poses >= poses {
        return true;
    }
    let share = ((asked_poses as u128) << 64) / poses as u128;
    u128::from((index as u64).wrapping_mul(GOLDEN)) < share
}

fn lines_of(scene: &Scene, pair: &JudgedPair, asked_poses: usize) -> Vec<LineRow> {
    let mut lines: BTreeMap<u32, LineRow> = BTreeMap::new();
    for (index, pose) in pair.poses.iter().enumerate().filter(|(_, pose)| pose.band.is_above_grazing()) {
        let row = lines.entry(pose.line).or_insert_with(|| LineRow {
            scene: scene.name.clone(),
            workload: pair.workload.clone(),
            pair: scene.pair_name(pair.pair),
            line: pose.line,
            contacts: 0,
            sampled: 0,
        });
        row.contacts += 1;
        row.sampled += u64::from(is_asked(index, pair.poses.len(), asked_poses));
    }
    lines.into_values().collect()
}

fn verify_case(
    case: &Case,
    scene: &Scene,
    (judged, parts): (&[JudgedPair], &BTreeSet<usize>),
    asked_poses: usize,
    progress: &dyn Progress,
) -> (Vec<VerificationRow>, Vec<MissRow>) {
    let mut models: BTreeMap<usize, Box<dyn Model>> = BTreeMap::new();
    for &part in parts {
        models.insert(part, case.variant.prepare(&scene.parts[part].mesh, case.policy));
        progress.advance(TREE_STEPS);
    }
    let has_others = case.variant.kind.is_ours();
    let everywhere = case.is_asked_everywhere();
    let (mut rows, mut misses) = (Vec::new(), Vec::new());
    for pair in judged {
        let (a, b) = (models[&pair.pair.a].as_ref(), models[&pair.pair.b].as_ref());
        let asked = |index: usize| everywhere || is_asked(index, pair.poses.len(), asked_poses);
        let answers = pair.poses.iter().enumerate();
        let answers = answers.map(|(index, pose)| Answered { pose, asked: asked(index), touching: false });
        let mut answers: Vec<Answered> = answers.filter(|answer| answer.asked || has_others).collect();
        answers.par_chunks_mut(BATCH).for_each(|batch| {
            answer(a, b, batch, true);
            answer(a, b, batch, false);
            progress.advance(batch.len() as u64);
        });
        progress.advance((pair.poses.len() - answers.len()) as u64);
        rows.extend(tally(case, scene, pair, &answers));
        misses.extend(misses_by_line(case, scene, pair, &answers));
    }
    (rows, misses)
}

fn misses_by_line(case: &Case, scene: &Scene, pair: &JudgedPair, answers: &[Answered]) -> Vec<MissRow> {
    let mut lines: BTreeMap<u32, MissRow> = BTreeMap::new();
    for answer in answers.iter().filter(|answer| answer.pose.band.is_above_grazing() && !answer.touching) {
        let row = lines.entry(answer.pose.line).or_insert_with(|| MissRow {
            scene: scene.name.clone(),
            case: case.name(),
            workload: pair.workload.clone(),
            pair: scene.pair_name(pair.pair),
            line: answer.pose.line,
            missed: 0,
            missed_asked: 0,
        });
        row.missed += 1;
        row.missed_asked += u64::from(answer.asked);
    }
    lines.into_values().collect()
}

/// A pose with a method's verdict.
struct Answered<'a> {
    pose: &'a JudgedPose,
    /// Whether the method's own query gave the verdict.
    asked: bool,
    /// The verdict.
    touching: bool,
}

/// Fills in the verdicts of those members of a batch that are asked, or of the others.
fn answer(a: &dyn Model, b: &dyn Model, batch: &mut [Answered], asked: bool) {
    let members: Vec<&mut Answered> = batch.iter_mut().filter(|member| member.asked == asked).collect();
    let poses: Vec<Isometry> = members.iter().map(|member| member.pose.a_from_b).collect();
    let mut verdicts = Vec::with_capacity(poses.len());
    if asked {
        a.first(b, &poses, &mut verdicts);
    } else {
        let witnesses: Vec<_> = members.iter().map(|member| member.pose.witness).collect();
        a.first_given(b, &poses, &witnesses, &mut verdicts);
    }
    for (member, verdict) in members.into_iter().zip(verdicts) {
        member.touching = verdict;
    }
}

/// One row per band that has poses.
fn tally(case: &Case, scene: &Scene, pair: &JudgedPair, answers: &[Answered]) -> Vec<VerificationRow> {
    let CaseKey { variant, split, split_axes, leaf } = case.key();
    let row = |band| {
        let members: Vec<&Answered> = answers.iter().filter(|answer| answer.pose.band == band).collect();
        let count = |condition: fn(&JudgedPose, bool) -> bool| {
            members.iter().filter(|member| condition(member.pose, member.touching)).count() as u64
        };
        VerificationRow {
            scene: scene.name.clone(),
            workload: pair.workload.clone(),
            pair: scene.pair_name(pair.pair),
            variant: variant.clone(),
            split: split.clone(),
            split_axes: split_axes.clone(),
            leaf,
            safe: u8::from(case.variant.info.safe),
            band,
            poses: members.len() as u64,
            asked: members.iter().filter(|member| member.asked).count() as u64,
            asked_exact: members.iter().filter(|member| member.asked && member.pose.touches()).count() as u64,
            asked_missed: members.iter().filter(|m| m.asked && m.pose.touches() && !m.touching).count() as u64,
            exact: count(|pose, _| pose.touches()),
            brute: count(|pose, _| pose.touches()),
            tree: count(|_, verdict| verdict),
            missed_by_volume: count(|pose, verdict| pose.touches() && !verdict),
            // The triangle test of the leaves is exact; only records of older versions have others.
            missed_by_leaf: 0,
            missed: count(|pose, verdict| pose.touches() && !verdict),
            false_positives: count(|pose, verdict| !pose.touches() && verdict),
        }
    };
    Band::ALL.into_iter().map(row).filter(|row| row.poses > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 250 000 poses in a pattern of 15 offsets, of which 2500 are asked: every offset has its share, about 167. Every hundredth pose meets
    /// the offsets 0, 5 and 10 alone.
    #[test]
    fn every_offset_of_a_pattern_is_asked() {
        for (poses, asked_poses) in [(250_000, 2500), (250_000, 2451), (40_000, 300)] {
            for pattern in [7, 15, 64] {
                let mut of_offset = vec![0_usize; pattern];
                let asked = (0..poses).filter(|&index| is_asked(index, poses, asked_poses));
                asked.for_each(|index| of_offset[index % pattern] += 1);
                let (share, sum) = (asked_poses / pattern, of_offset.iter().sum::<usize>());
                assert!(sum.abs_diff(asked_poses) <= 3, "{sum} of {asked_poses}");
                let even = of_offset.iter().all(|&count| count.abs_diff(share) <= 3 + share / 10);
                assert!(even, "{poses} {asked_poses} {pattern}: {of_offset:?}");
            }
        }
        assert!((0..10).all(|index| is_asked(index, 10, 10)) && !(0..10).any(|index| is_asked(index, 10, 0)));
    }
}
