//! Timing a sweep's queries and constructions.

use super::super::timer;
use super::stage::Bodies;
use super::{Batch, Prepared, SweepRun};
use crate::record::{SweepBuildRow, SweepTimingRow};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

impl SweepRun {
    /// Randomised complete blocks: in every block every batch is visited once, and every case runs it in a fresh random order.
    pub(super) fn time(&self, x: f64, models: &[Prepared], batches: &[Batch]) -> Vec<SweepTimingRow> {
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed ^ x.to_bits());
        let mut order: Vec<usize> = (0..models.len()).collect();
        let (mut verdicts, mut rows) = (Vec::new(), Vec::new());
        let mut passes = vec![vec![1; models.len()]; batches.len()];
        for block in 0..=self.amount.blocks {
            for (batch, passes) in batches.iter().zip(&mut passes) {
                order.shuffle(&mut rng);
                for &k in &order {
                    let (case, a, b) = &models[k];
                    let mut run = |passes: u32| {
                        for _ in 0..passes {
                            verdicts.clear();
                            a.first(b.as_ref(), &batch.poses, &mut verdicts);
                        }
                    };
                    if block > 0 {
                        run(1);
                    }
                    let (ns, ()) = timer::time(|| run(passes[k]));
                    if block == 0 {
                        passes[k] = timer::passes_for(ns);
                        continue;
                    }
                    let (split, axes, leaf) = case.policy_columns();
                    rows.push(SweepTimingRow {
                        sweep: self.sweep.name.to_owned(),
                        x,
                        variant: case.id.clone(),
                        split,
                        axes,
                        leaf,
                        group: batch.group,
                        stratum: batch.stratum,
                        block: block - 1,
                        poses: batch.poses.len() as u32,
                        passes: passes[k],
                        ns,
                    });
                }
            }
        }
        rows.sort_by(|a, b| (a.block, a.group, a.stratum, &a.variant).cmp(&(b.block, b.group, b.stratum, &b.variant)));
        rows
    }

    /// Constructions of every case's trees, in every block in a fresh random order.
    pub(super) fn time_builds(
        &self,
        x: f64,
        triangles: u64,
        stage: &Bodies,
        models: &[Prepared],
    ) -> Vec<SweepBuildRow> {
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed ^ x.to_bits() ^ 0x000b_u64);
        let mut order: Vec<usize> = (0..models.len()).collect();
        let mut rows = Vec::new();
        for block in 0..self.amount.blocks {
            order.shuffle(&mut rng);
            for &k in &order {
                let case = &models[k].0;
                let build = || [&stage.a, &stage.b].map(|mesh| case.variant.prepare(mesh, case.policy));
                let (ns, _models) = timer::time(build);
                let (split, axes, leaf) = case.policy_columns();
                let (sweep, variant) = (self.sweep.name.to_owned(), case.id.clone());
                rows.push(SweepBuildRow { sweep, x, variant, split, axes, leaf, triangles, block, ns });
            }
        }
        rows.sort_by(|a, b| (a.block, &a.variant).cmp(&(b.block, &b.variant)));
        rows
    }
}
