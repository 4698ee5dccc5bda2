//! Timing construction: every case over every examined part, in a fresh random order each block. What the last block builds is what the
//! launch's queries are timed with.

use super::binaries::binary_of;
use super::plan::{Case, Plan};
use super::study::build_row;
use super::{Progress, timer};
use crate::method::{Kind, Model};
use crate::record::BuildRow;
use crate::scene::Scene;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use std::collections::{BTreeMap, BTreeSet};

/// What was built last, by place of the case in the plan and by part.
pub type Built = BTreeMap<(usize, usize), Box<dyn Model>>;

/// Times the construction of every case's model of every part that belongs to an examined pair. The plan's blocks are
/// dealt out to its launches, and numbered across them.
pub fn time_builds(plan: &Plan, scene: &Scene, launch: u32, progress: &dyn Progress) -> (Vec<BuildRow>, Built) {
    let parts: BTreeSet<usize> = scene.pairs.iter().flat_map(|pair| [pair.a, pair.b]).collect();
    let cases = plan.cases.iter().enumerate().filter(|(_, case)| case.variant.kind != Kind::Control);
    let mut jobs: Vec<((usize, &Case), usize)> =
        cases.flat_map(|case| parts.iter().map(move |&part| (case, part))).collect();
    let mut rng = Pcg64Mcg::seed_from_u64(plan.selection.seed ^ (u64::from(launch) << 32) ^ 0x000b_u64);
    let (mut rows, mut built) = (Vec::new(), Built::new());
    for block in (launch..plan.budget.build_blocks).step_by(plan.budget.launches as usize) {
        jobs.shuffle(&mut rng);
        for &((place, case), part) in &jobs {
            let mesh = &scene.parts[part].mesh;
            // No more than one of a kind at a time.
            built.remove(&(place, part));
            let (ns, model) = timer::time(|| case.variant.prepare(mesh, case.policy));
            built.insert((place, part), model);
            let binary = binary_of(launch, plan.budget.binaries);
            let of_part = (scene.parts[part].name.clone(), mesh.faces().len() as u64);
            rows.push(BuildRow { binary, ..build_row((&scene.name, launch), case.key(), of_part, block, ns) });
            progress.advance(1);
        }
    }
    rows.sort_by(|x: &BuildRow, y| (x.block, &x.part).cmp(&(y.block, &y.part)).then_with(|| x.case().cmp(&y.case())));
    (rows, built)
}
