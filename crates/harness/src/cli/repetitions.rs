//! How often a run repeats: binaries, launches, blocks; and how its raw rows are written.

use super::note;
use crate::analysis::variance;
use crate::measure::{Plan, binaries};
use crate::record::{Manifest, VarianceRow, read_rows};
use anyhow::{Context, Result, ensure};
use clap::Args;
use std::path::{Path, PathBuf};

/// Most launches of a binary, and most blocks of a launch, that may be asked for.
const MOST: u32 = 1000;

/// How often a run repeats, beside what its profile says.
#[derive(Args, Clone, Default)]
pub struct Repetitions {
    /// Binary that carries out launches in turn with the others, or a folder of them (see scripts/binaries); repeatable [default: this program]
    #[arg(long = "binary", value_name = "PATH")]
    binaries: Vec<PathBuf>,
    /// Launches of each binary [default: by profile: 1, 3, 4]
    #[arg(long, value_name = "N")]
    launches: Option<u32>,
    /// Timed blocks of each launch [default: by profile: 3, 3, 8]
    #[arg(long, value_name = "N")]
    blocks: Option<u32>,
    /// Poses of each program that are asked with cold caches too [default: by profile: 4, 4, 64]
    #[arg(long, value_name = "N")]
    cold_poses: Option<usize>,
    /// Take launches and blocks from the variance components of an analysed run
    #[arg(long, value_name = "DIR", conflicts_with_all = ["launches", "blocks"])]
    plan_from: Option<PathBuf>,
    /// Write raw rows compressed, as .csv.gz [default: with profile full]
    #[arg(long)]
    gzip: bool,
}

impl Repetitions {
    /// The plan with these repetitions.
    ///
    /// # Errors
    /// When a binary cannot be used, a number is out of range, or the run to plan from says too little.
    pub fn apply(&self, mut plan: Plan) -> Result<Plan> {
        for (name, number) in [("--launches", self.launches), ("--blocks", self.blocks)] {
            ensure!(number.is_none_or(|n| (1..=MOST).contains(&n)), "{name}: from 1 to {MOST}");
        }
        plan.binaries = binaries::gather(&self.binaries)?;
        let (mut launches, mut blocks) = (self.launches, self.blocks);
        if let Some(pilot) = &self.plan_from {
            let next = planned(pilot)?;
            let (row, least) = (&next.decisive, next.binaries);
            let given = plan.binaries.len().max(1);
            ensure!(
                given >= least as usize,
                "{}: {} in {} needs {least} binaries for an interval of ± {} %, {given} given: make them with `scripts/binaries {least}` and name their folder with --binary",
                pilot.display(),
                row.case().name(),
                row.scene,
                100.0 * variance::HALF_WIDTH
            );
            for row in &next.beyond {
                note(format!(
                    "{}: {} in {} needs more than {} binaries for an interval of ± {} %; its interval will be wider",
                    pilot.display(),
                    row.case().name(),
                    row.scene,
                    variance::MOST_BINARIES,
                    100.0 * variance::HALF_WIDTH
                ));
            }
            (launches, blocks) = (Some(next.launches), Some(next.blocks));
        }
        plan.budget.launches = launches.unwrap_or(plan.budget.launches);
        plan.budget.blocks = blocks.unwrap_or(plan.budget.blocks);
        plan.budget.cold_poses = self.cold_poses.unwrap_or(plan.budget.cold_poses);
        plan.budget = plan.budget.over(plan.binaries.len().max(1) as u32);
        plan.gzip |= self.gzip;
        Ok(plan)
    }
}

/// How often the next run repeats.
fn planned(pilot: &Path) -> Result<variance::NextRun> {
    let manifest = Manifest::read(pilot)?;
    let rows: Vec<VarianceRow> = read_rows(pilot)
        .with_context(|| format!("{} is not analysed: run `bvbench stage analyze --out {0}` first", pilot.display()))?;
    variance::next_run(&rows, &manifest).with_context(|| {
        format!(
            "{}: variance.csv plans nothing: a pilot needs two binaries, two launches of each and two blocks of each launch, and components with which {} binaries suffice",
            pilot.display(),
            variance::MOST_BINARIES
        )
    })
}
