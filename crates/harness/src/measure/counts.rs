//! Verdict and operation counts of every case at every measured pose: the deterministic tier beside the timings.

use super::Progress;
use super::chunk::Participants;
use super::measured::{Measured, Numbered};
use super::plan::{Case, Plan};
use crate::method::{Kind, Model};
use crate::record::AnswerRow;
use crate::scene::Scene;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// One row per case and pose of a chunk. The control answers only at its own few poses, where all others answer too; poses of whole programs are timed
/// and not counted.
pub fn count_scene(plan: &Plan, scene: &Scene, measured: &Measured, progress: &dyn Progress) -> Vec<AnswerRow> {
    let poses = |wanted: fn(Participants) -> bool| {
        measured.numbered().filter(|pose| wanted(pose.participants)).collect::<Vec<_>>()
    };
    let everyone = poses(|_| true);
    let peers = poses(|who| who == Participants::Everyone);
    let control = poses(|who| who == Participants::Control);
    progress.begin(&format!("{}: operation counts", scene.name), (everyone.len() * plan.cases.len()) as u64);
    let of_case = |case: &Case| {
        let poses = match case.variant.kind {
            Kind::Volume | Kind::Engine | Kind::Sampling => &everyone,
            Kind::Peer => &peers,
            Kind::Control => &control,
        };
        count_case(case, scene, measured, poses, progress)
    };
    let rows: Vec<_> = plan.cases.par_iter().map(of_case).collect();
    rows.concat()
}

fn count_case(
    case: &Case,
    scene: &Scene,
    Measured { judged, .. }: &Measured,
    poses: &[Numbered],
    progress: &dyn Progress,
) -> Vec<AnswerRow> {
    let mut models: BTreeMap<usize, Box<dyn Model>> = BTreeMap::new();
    for pose in poses {
        for part in [judged[pose.pair].pair.a, judged[pose.pair].pair.b] {
            models.entry(part).or_insert_with(|| case.variant.prepare(&scene.parts[part].mesh, case.policy));
        }
    }
    let name = case.name();
    let row = |asked: &Numbered| {
        let pair = &judged[asked.pair];
        let (a, b) = (models[&pair.pair.a].as_ref(), models[&pair.pair.b].as_ref());
        let (verdict, counts) = a.first_counted(b, &pair.poses[asked.pose].a_from_b);
        progress.advance(1);
        AnswerRow {
            scene: scene.name.clone(),
            case: name.clone(),
            pose: asked.number,
            verdict: u8::from(verdict),
            volume_tests: counts.volume_tests,
            triangle_tests: counts.triangle_tests,
        }
    };
    poses.par_iter().map(row).collect()
}
