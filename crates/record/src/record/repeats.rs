//! Rows about repetition: readings of single queries, and how much of the spread of a time is due to binary, launch and block.

use serde::{Deserialize, Serialize};

/// What a query finds in the caches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cache {
    /// What the queries before it left there, one whole pass over the same chunk among them.
    Warm,
    /// A buffer larger than the caches, read just before.
    Cold,
}

/// The reading of the clock over one query. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SingleRow {
    /// Scene name.
    pub scene: String,
    /// Case, by its name in `cases.csv`.
    pub case: String,
    /// What the query finds in the caches.
    pub cache: Cache,
    /// Binary that ran, by its number in the manifest.
    pub binary: u32,
    /// Process launch, from 0.
    pub launch: u32,
    /// Pose, by its number in `poses.csv`.
    pub pose: u32,
    /// Wall time of the query with one reading of the clock in it, ns.
    pub ns: u64,
}

/// Where the spread of a total time, or of a ratio of totals, comes from. Standard deviations are of the logarithm, so that 0.01 is one
/// percent. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VarianceRow {
    /// Scene name.
    pub scene: String,
    /// Workload name, or `program-time`.
    pub workload: String,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Case that the total is divided by, block by block; empty for the total itself.
    pub baseline: String,
    /// Binaries.
    pub binaries: u32,
    /// Launches of each binary.
    pub launches: u32,
    /// Blocks of each launch.
    pub blocks: u32,
    /// Geometric mean: of the total, ns, or of the ratio.
    pub value: f64,
    /// Standard deviation between binaries, that of their launches taken off; empty with one binary. With one launch of each binary it holds
    /// what differs between launches.
    pub binary_sd: Option<f64>,
    /// Standard deviation between launches of one binary, that of their blocks taken off; empty with one launch of each.
    pub launch_sd: Option<f64>,
    /// Standard deviation between blocks of one launch; empty with one block. Long chunks are timed in one block of each launch and spread
    /// between launches only.
    pub block_sd: Option<f64>,
    /// Lower end of the 95 % interval over binaries, or over the launches of a single one; empty where there is nothing to compare.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// Lower end of the 95 % interval over launches without what differs between binaries; empty with one launch of each.
    pub low_within: Option<f64>,
    /// Upper end.
    pub high_within: Option<f64>,
    /// Binaries with which the interval's half-width becomes 2.5 %; empty where 64 are too few, and without `launch_sd` and `block_sd`.
    pub planned_binaries: Option<u32>,
    /// Launches of each, with it.
    pub planned_launches: Option<u32>,
    /// Blocks of each launch, with it.
    pub planned_blocks: Option<u32>,
}
