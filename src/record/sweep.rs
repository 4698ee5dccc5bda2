//! The rows of a sweep: one quantity varied, everything else held.

use super::rows::{Row, row_file};
use super::vocabulary::Stratum;
use serde::{Deserialize, Serialize};

row_file! {
    SweepRow => "sweep.csv",
    SweepTimingRow => "sweep_timings.csv",
    SweepBuildRow => "sweep_builds.csv",
    SweepSummaryRow => "sweep_summary.csv",
    SweepGrowthRow => "sweep_growth.csv",
}

/// One case asked about the poses of one group at one value of the swept quantity. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepRow {
    /// Name of the sweep.
    pub sweep: String,
    /// Value of the swept quantity, in the unit that `docs/format.md` gives for the sweep.
    pub x: f64,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Triangles of both meshes.
    pub triangles: u64,
    /// Group of lines of approach: the unit of resampling.
    pub group: u32,
    /// Stratum of all its poses.
    pub stratum: Stratum,
    /// Poses, or in the sweep of the path step runs along a path.
    pub poses: u32,
    /// Queries made: one per pose, or one per sample of a path.
    pub queries: u64,
    /// Volume overlap tests over all queries, mode `first`.
    pub volume_tests: u64,
    /// Triangle tests over all queries.
    pub triangle_tests: u64,
    /// Poses that touch by the shared triangle test; runs with a contact.
    pub touching: u64,
    /// How many of them the variant does not report.
    pub missed: u64,
    /// Sum over runs of the travel from first contact to the first sample that reports it, mm; 0 in other sweeps.
    pub delay_mm: f64,
}

/// One timed group of queries. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepTimingRow {
    /// Name of the sweep.
    pub sweep: String,
    /// Value of the swept quantity.
    pub x: f64,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Group of lines of approach.
    pub group: u32,
    /// Stratum of all its poses.
    pub stratum: Stratum,
    /// Block of random order, from 0.
    pub block: u32,
    /// Poses of a pass.
    pub poses: u32,
    /// Passes in the sample.
    pub passes: u32,
    /// Wall time of all passes, ns.
    pub ns: u64,
}

/// A case at one value of the swept quantity. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepSummaryRow {
    /// Name of the sweep.
    pub sweep: String,
    /// Value of the swept quantity.
    pub x: f64,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Stratum.
    pub stratum: Stratum,
    /// `volume-tests` or `triangle-tests` of a query, `time` (ns of a query), `miss-rate`, `delay` (mm).
    pub metric: String,
    /// Mean.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// One construction of a case's trees over both bodies, in the sweep of the size. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepBuildRow {
    /// Name of the sweep.
    pub sweep: String,
    /// Value of the swept quantity.
    pub x: f64,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Triangles of both bodies.
    pub triangles: u64,
    /// Block of random order, from 0.
    pub block: u32,
    /// Wall time, ns.
    pub ns: u64,
}

/// How what a case costs grows with the number of triangles, in the sweep of the size: cost ~ triangles^exponent. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepGrowthRow {
    /// Name of the sweep.
    pub sweep: String,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// `build` (time of one), `time`, `volume-tests` or `triangle-tests` of a query.
    pub metric: String,
    /// Fewest triangles of both bodies.
    pub from_triangles: u64,
    /// Most.
    pub to_triangles: u64,
    /// The exponent: slope of a straight line through the logarithms.
    pub exponent: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}
