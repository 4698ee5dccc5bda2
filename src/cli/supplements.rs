//! What stands beside a run: quick forms of the audit and of two sweeps, by counts alone, of the ablation, and the octree method's verdicts
//! on a free-form surface, in folders of their own within the run's.

use super::options::open_run;
use crate::analysis::ablation::analyze_ablation;
use crate::analysis::audit::analyze_audit;
use crate::analysis::claims::ClaimSet;
use crate::analysis::sweep::analyze_sweep;
use crate::measure::ablation::{self, ablation};
use crate::measure::audit::Audit;
use crate::measure::sweep::{Asked, Sweep, SweepRun};
use crate::measure::{Plan, Profile, Progress, Selection, Verification};
use crate::method::octree_obb;
use crate::plot::SUPPLEMENTS;
use crate::record::manifest::Request;
use crate::registry::Registry;
use crate::truth::TruthCache;
use anyhow::{Context, Result};
use std::path::Path;

/// The orientations that the quick form crosses: the paper's two.
const ORIENTATIONS: [&str; 2] = ["vertex", "area"];

/// The leaf sizes that it crosses: the two ends.
const LEAVES: [u8; 2] = [1, 8];

/// The scene on which the octree method is compared with a tree over the same meshes, and its folder.
const FREEFORM: &str = "freeform-5axis";

/// Carries out what stands beside a run of `request` in `folder`. Where it was done before it is done again only where its folder lacks it.
/// Returns what the octree method says on [`FREEFORM`].
pub fn make(
    folder: &Path,
    request: &Request,
    claims: &ClaimSet,
    cache: &Path,
    registry: &Registry,
    progress: &dyn Progress,
) -> Result<Verification> {
    let [audit, ablation, sweeps @ ..] = SUPPLEMENTS;
    let scenes = request.scenes.iter().take(1).cloned().collect();
    audit_in(&folder.join(audit), scenes, request.seed, cache, registry, progress)?;
    ablation_in(&folder.join(ablation), claims, request.seed, registry, progress)?;
    for name in sweeps {
        sweep_in(&folder.join(name), name.trim_start_matches("sweep-"), request.seed, registry, progress)?;
    }
    freeform_in(&folder.join(FREEFORM), request.seed, cache, registry, progress)
}

fn audit_in(
    folder: &Path,
    scenes: Vec<String>,
    seed: u64,
    cache: &Path,
    registry: &Registry,
    progress: &dyn Progress,
) -> Result<()> {
    let mut plan = Audit::plan(Profile::Smoke, scenes, seed, registry)?;
    plan.scenes.truncate(1);
    let orientations = ORIENTATIONS.map(str::to_owned);
    let mut audit = Audit::open(plan, &orientations, &LEAVES, folder, true)?.with_cache(TruthCache::at(cache)?);
    audit.run(false, progress)?;
    analyze_audit(folder)?;
    crate::plot::draw_audit(folder)?;
    crate::report::write_audit(folder)?;
    Ok(())
}

fn ablation_in(
    folder: &Path,
    claims: &ClaimSet,
    seed: u64,
    registry: &Registry,
    progress: &dyn Progress,
) -> Result<()> {
    let against = registry.fastest().context("no safe variant is registered")?;
    ablation(&ablation::Asked { profile: Profile::Smoke, against, seed, shard: None }, folder, true, true, progress)?;
    analyze_ablation(folder, claims)?;
    crate::plot::draw_ablation(folder)?;
    Ok(())
}

/// Some thousand verdicts of the octree method, with and without the covering radius, and of the reference.
fn freeform_in(
    folder: &Path,
    seed: u64,
    cache: &Path,
    registry: &Registry,
    progress: &dyn Progress,
) -> Result<Verification> {
    let reference = registry.reference().context("no variant is the reference")?;
    let selection = Selection {
        profile: Profile::Smoke,
        scenes: vec![FREEFORM.to_owned()],
        variants: [octree_obb::INFO.id, octree_obb::SAMPLED.id, reference.info.id].map(str::to_owned).to_vec(),
        workloads: Vec::new(),
        policies: vec![reference.policy.context("the reference has no tree")?],
        seed,
    };
    let mut run = open_run(Plan::new(selection, registry)?, folder, cache, true)?;
    Ok(run.verify(progress)?)
}

fn sweep_in(folder: &Path, name: &str, seed: u64, registry: &Registry, progress: &dyn Progress) -> Result<()> {
    let asked = Asked { profile: Profile::Smoke, variants: Vec::new(), seed, density: None, shard: None };
    let sweep = Sweep::find(name)?;
    SweepRun::open(sweep, &asked, registry, folder, true)?.run(false, progress)?;
    analyze_sweep(folder)?;
    crate::plot::draw_sweep(folder, sweep.about, sweep.axis)?;
    Ok(())
}
