//! What stands beside a run: quick forms of the audit and of two sweeps, by counts alone, and of the ablation, in folders of their own
//! within the run's.

use crate::analysis::ablation::analyze_ablation;
use crate::analysis::audit::analyze_audit;
use crate::analysis::claims::ClaimSet;
use crate::analysis::sweep::analyze_sweep;
use crate::measure::ablation::ablation;
use crate::measure::audit::Audit;
use crate::measure::sweep::{Asked, Sweep, SweepRun};
use crate::measure::{Profile, Progress};
use crate::method::wide_obb;
use crate::plot::ASIDES;
use crate::record::manifest::Request;
use crate::registry::Registry;
use crate::truth::TruthCache;
use anyhow::{Context, Result};
use std::path::Path;

/// The orientations that the quick form crosses: the paper's two.
const ORIENTATIONS: [&str; 2] = ["vertex", "area"];

/// Carries out what stands beside a run of `request` in `folder`. Where it was done before it is done again only where its folder lacks it.
pub fn make(folder: &Path, request: &Request, claims: &ClaimSet, cache: &Path, progress: &dyn Progress) -> Result<()> {
    let [audit, ablation, sweeps @ ..] = ASIDES;
    let scenes = request.scenes.iter().take(1).cloned().collect();
    audit_in(&folder.join(audit), scenes, request.seed, cache, progress)?;
    ablation_in(&folder.join(ablation), claims, request.seed, progress)?;
    for name in sweeps {
        sweep_in(&folder.join(name), name.trim_start_matches("sweep-"), request.seed, progress)?;
    }
    Ok(())
}

fn audit_in(folder: &Path, scenes: Vec<String>, seed: u64, cache: &Path, progress: &dyn Progress) -> Result<()> {
    let mut plan = Audit::plan(Profile::Smoke, scenes, seed)?;
    plan.scenes.truncate(1);
    let orientations = ORIENTATIONS.map(str::to_owned);
    let mut audit = Audit::open(plan, &orientations, folder, true)?.with_cache(TruthCache::at(cache)?);
    audit.run(false, progress)?;
    analyze_audit(folder)?;
    crate::plot::draw_audit(folder)?;
    crate::report::write_audit(folder)?;
    Ok(())
}

fn ablation_in(folder: &Path, claims: &ClaimSet, seed: u64, progress: &dyn Progress) -> Result<()> {
    let registry = Registry::standard();
    let fastest = registry.find(wide_obb::INFO.id).context("the fastest variant is not registered")?;
    ablation(&super::ablation::budget(Profile::Smoke), fastest, seed, folder, progress)?;
    analyze_ablation(folder, claims, seed)?;
    crate::plot::draw_ablation(folder)?;
    Ok(())
}

fn sweep_in(folder: &Path, name: &str, seed: u64, progress: &dyn Progress) -> Result<()> {
    let asked = Asked { profile: Profile::Smoke, variants: Vec::new(), seed, density: None };
    let sweep = Sweep::find(name)?;
    SweepRun::open(sweep, &asked, &Registry::standard(), folder, true)?.run(false, progress)?;
    analyze_sweep(folder)?;
    crate::plot::draw_sweep(folder, sweep.about, sweep.axis)?;
    Ok(())
}
