//! Derived rows about what queries and trees cost: the cost model, deadlines, and when a dearer tree has paid for itself.

use super::rows::{Row, row_file};
use super::vocabulary::Stratum;
use serde::{Deserialize, Serialize};

row_file! { FILES:
    CostRow => "costs.csv",
    CostChunkRow => "cost_chunks.csv",
    DeadlineRow => "deadlines.csv",
    RepayRow => "repay.csv",
}

/// What the operations of one case cost on the machine of the run: T = setup + tests of volumes × cost + tests of triangles ×
/// cost. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CostRow {
    /// Variant id.
    pub variant: String,
    /// Its policy, `split/axes/leaf`.
    pub policy: String,
    /// Cost of a query without any operation, ns.
    pub setup_ns: f64,
    /// Cost of a volume test, with the traversal around it, ns.
    pub volume_test_ns: f64,
    /// Cost of a triangle test, with the placement of the triangle, ns.
    pub triangle_test_ns: f64,
    /// Chunks that went in, over all scenes.
    pub chunks: u64,
    /// Median over chunks of |predicted / measured - 1|; each scene predicted from the others where there are others.
    pub error_median: f64,
    /// 95th percentile of the same.
    pub error_p95: f64,
}

/// One chunk as measured and as the cost model predicts it. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CostChunkRow {
    /// Scene name.
    pub scene: String,
    /// Variant id.
    pub variant: String,
    /// Its policy.
    pub policy: String,
    /// Chunk within the scene.
    pub chunk: u32,
    /// Its stratum.
    pub stratum: Stratum,
    /// Mean volume tests of its queries.
    pub volume_tests: f64,
    /// Mean triangle tests.
    pub triangle_tests: f64,
    /// Query time, median over blocks and launches, ns.
    pub measured_ns: f64,
    /// Query time by the model fitted to the other scenes (to this one, where there is no other), ns.
    pub predicted_ns: f64,
}

/// How often a query of one case takes longer than a control cycle, by the cost model applied to every counted query. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeadlineRow {
    /// Scene name.
    pub scene: String,
    /// Variant id.
    pub variant: String,
    /// Its policy.
    pub policy: String,
    /// How many times slower than the machine of the run the controller is.
    pub slowdown: f64,
    /// Counted queries, strata weighted equally in what follows.
    pub queries: u64,
    /// 99.9th percentile of the time of a query, ns.
    pub p999_ns: f64,
    /// Share of queries that take longer than 1 ms.
    pub over_1_ms: f64,
    /// Longer than 2 ms.
    pub over_2_ms: f64,
    /// Longer than 4 ms.
    pub over_4_ms: f64,
    /// Longer than 8 ms.
    pub over_8_ms: f64,
}

/// After how many queries a case's faster queries have paid for its dearer trees. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RepayRow {
    /// Scene name.
    pub scene: String,
    /// Variant id.
    pub variant: String,
    /// Its policy.
    pub policy: String,
    /// The case whose trees are built fastest: what it is compared with.
    pub baseline: String,
    /// That case's policy.
    pub baseline_policy: String,
    /// Time to build the trees of all parts, ns: sum of medians.
    pub build_ns: f64,
    /// Mean time of a query, ns, strata weighted equally.
    pub query_ns: f64,
    /// Queries after which build and queries together take less than with the baseline; empty when they never do.
    pub queries: Option<f64>,
}
