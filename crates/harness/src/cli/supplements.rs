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
    let supplements = Supplements { seed: request.seed, cache, registry, progress };
    supplements.audit(&folder.join(audit), request.scenes.iter().take(1).cloned().collect())?;
    supplements.ablation(&folder.join(ablation), claims)?;
    for name in sweeps {
        supplements.sweep(&folder.join(name), name.trim_start_matches("sweep-"))?;
    }
    supplements.freeform(&folder.join(FREEFORM))
}

/// What all supplements share.
struct Supplements<'a> {
    seed: u64,
    cache: &'a Path,
    registry: &'a Registry,
    progress: &'a dyn Progress,
}

impl Supplements<'_> {
    fn audit(&self, folder: &Path, scenes: Vec<String>) -> Result<()> {
        let mut plan = Audit::plan(Profile::Smoke, scenes, self.seed, self.registry)?;
        plan.scenes.truncate(1);
        let orientations = ORIENTATIONS.map(str::to_owned);
        let audit = Audit::open(plan, &orientations, &LEAVES, folder, true)?;
        let mut audit = audit.with_cache(TruthCache::at(self.cache)?);
        audit.run(false, self.progress)?;
        analyze_audit(folder)?;
        crate::plot::draw_audit(folder)?;
        crate::report::write_audit(folder)?;
        Ok(())
    }

    fn ablation(&self, folder: &Path, claims: &ClaimSet) -> Result<()> {
        let against = self.registry.fastest().context("no safe variant is registered")?;
        let asked = ablation::Asked { profile: Profile::Smoke, against, seed: self.seed, shard: None };
        ablation(&asked, folder, true, true, self.progress)?;
        analyze_ablation(folder, claims)?;
        crate::plot::draw_ablation(folder)?;
        Ok(())
    }

    /// Some thousand verdicts of the octree method, with and without the covering radius, and of the reference.
    fn freeform(&self, folder: &Path) -> Result<Verification> {
        let reference = self.registry.reference().context("no variant is the reference")?;
        let selection = Selection {
            profile: Profile::Smoke,
            scenes: vec![FREEFORM.to_owned()],
            variants: [octree_obb::INFO.id, octree_obb::SAMPLED.id, reference.info.id].map(str::to_owned).to_vec(),
            workloads: Vec::new(),
            policies: vec![reference.policy.context("the reference has no tree")?],
            seed: self.seed,
        };
        let mut run = open_run(Plan::new(selection, self.registry)?, folder, self.cache, true)?;
        Ok(run.verify(self.progress)?)
    }

    fn sweep(&self, folder: &Path, name: &str) -> Result<()> {
        let asked =
            Asked { profile: Profile::Smoke, variants: Vec::new(), seed: self.seed, density: None, shard: None };
        let sweep = Sweep::find(name)?;
        SweepRun::open(sweep, &asked, self.registry, folder, true)?.run(false, self.progress)?;
        analyze_sweep(folder)?;
        crate::plot::draw_sweep(folder, sweep.about, sweep.axis)?;
        Ok(())
    }
}
