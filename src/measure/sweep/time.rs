//! Timing a sweep's queries and constructions.

use super::super::blocks::{self, Extent, Participation, Work};
use super::super::{Silent, timer};
use super::stage::Bodies;
use super::{Batch, Prepared, SweepRun};
use crate::record::{SweepBuildRow, SweepTimingRow};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

/// Every case on the batches of one value.
struct Queries<'a> {
    models: &'a [Prepared],
    batches: &'a [Batch],
    verdicts: Vec<bool>,
}

impl Work for Queries<'_> {
    fn cases(&self) -> usize {
        self.models.len()
    }

    fn chunks(&self) -> Vec<usize> {
        self.batches.iter().map(|batch| batch.poses.len()).collect()
    }

    fn participation(&self, _: usize, _: usize) -> Participation {
        Participation::Always
    }

    fn run(&mut self, case: usize, chunk: usize, poses: usize, passes: u32) {
        let (_, a, b) = &self.models[case];
        for _ in 0..passes {
            self.verdicts.clear();
            a.first(b.as_ref(), &self.batches[chunk].poses[..poses], &mut self.verdicts);
        }
    }
}

impl SweepRun {
    /// Queries of every case on every batch.
    pub(super) fn time(&self, x: f64, models: &[Prepared], batches: &[Batch]) -> Vec<SweepTimingRow> {
        let mut queries = Queries { models, batches, verdicts: Vec::new() };
        let extent = Extent { blocks: self.amount.blocks, warms_up: true, long_once: false };
        let samples = blocks::time(&mut queries, extent, self.seed ^ x.to_bits(), &Silent);
        let row = |sample: blocks::Sample| {
            let (case, batch) = (&models[sample.case].0, &batches[sample.chunk]);
            let (split, axes, leaf) = case.policy_columns();
            SweepTimingRow {
                sweep: self.sweep.name.to_owned(),
                x,
                variant: case.id.clone(),
                split,
                split_axes: axes,
                leaf,
                group: batch.group,
                stratum: batch.stratum,
                block: sample.block,
                poses: batch.poses.len() as u32,
                passes: sample.passes,
                ns: sample.ns,
            }
        };
        let mut rows: Vec<SweepTimingRow> = samples.into_iter().map(row).collect();
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
                rows.push(SweepBuildRow { sweep, x, variant, split, split_axes: axes, leaf, triangles, block, ns });
            }
        }
        rows.sort_by(|a, b| (a.block, &a.variant).cmp(&(b.block, &b.variant)));
        rows
    }
}
