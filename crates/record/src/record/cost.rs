//! Derived tables about what queries and trees cost: the cost model, deadlines, and when a dearer tree has paid for itself.

use super::file::Head;
use super::rows::{Row, row_file};
use super::vocabulary::Stratum;
use serde::{Deserialize, Serialize};

/// The files of these tables.
pub const FILES: &[&str] = &[CASE_COSTS.file, CostChunkRow::FILE, DEADLINES.file, REPAY.file];

row_file! { CostChunkRow => "cost_chunks.csv" }

/// What the operations of one case cost on the machine of the run: T = setup + tests of volumes × cost + tests of triangles ×
/// cost. Derived.
pub const CASE_COSTS: Head = Head {
    file: "costs.csv",
    columns: "variant,policy,setup_ns,volume_test_ns,triangle_test_ns,chunks,error_median,error_p95",
};

/// How often a query of one case takes longer than a control cycle, by the cost model applied to every counted query. Derived.
pub const DEADLINES: Head = Head {
    file: "deadlines.csv",
    columns: "scene,variant,policy,slowdown,queries,p999_ns,over_1_ms,over_2_ms,over_4_ms,over_8_ms",
};

/// After how many queries a case's faster queries have paid for its dearer trees. Derived.
pub const REPAY: Head =
    Head { file: "repay.csv", columns: "scene,variant,policy,baseline,baseline_policy,build_ns,query_ns,queries" };

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
