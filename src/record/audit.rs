//! The rows of an audit: the factorial experiment on what makes a box good.

use super::rows::{Row, row_file};
use super::vocabulary::Stratum;
use serde::{Deserialize, Serialize};

row_file! {
    AuditRow => "audit.csv",
    AuditTreeRow => "audit_trees.csv",
    AuditTimingRow => "audit_timings.csv",
    AuditBuildRow => "audit_builds.csv",
    AuditAxisRow => "audit_axes.csv",
    AuditCellRow => "audit_cells.csv",
    AuditEffectRow => "audit_effects.csv",
    AuditShareRow => "audit_shares.csv",
}

/// The names of the four factors, in the order of columns.
pub const FACTORS: [&str; 4] = ["orientation", "centre", "split", "leaf"];

/// One cell asked about the poses of one chunk. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditRow {
    /// Scene name.
    pub scene: String,
    /// Workload name.
    pub workload: String,
    /// `a:b`, the two parts.
    pub pair: String,
    /// Stratum of all poses of the chunk.
    pub stratum: Stratum,
    /// Chunk within the scene; the same poses for every cell.
    pub chunk: u32,
    /// Poses in the chunk.
    pub poses: u32,
    /// How the boxes' axes are found.
    pub orientation: String,
    /// Where the boxes' centres lie.
    pub centre: String,
    /// Split rule.
    pub split: String,
    /// Leaf size.
    pub leaf: u8,
    /// Volume overlap tests over all poses, mode `first`.
    pub volume_tests: u64,
    /// Triangle tests over all poses, mode `first`.
    pub triangle_tests: u64,
    /// Poses that touch by the shared triangle test.
    pub touching: u64,
    /// How many of them the cell does not report.
    pub missed: u64,
}

/// The tree of one cell over one part. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditTreeRow {
    /// Scene name.
    pub scene: String,
    /// Part the tree is over.
    pub part: String,
    /// How the boxes' axes are found.
    pub orientation: String,
    /// Where the boxes' centres lie.
    pub centre: String,
    /// Split rule.
    pub split: String,
    /// Leaf size.
    pub leaf: u8,
    /// Triangles of the part.
    pub triangles: u64,
    /// Nodes of the tree.
    pub nodes: u64,
    /// Depth of the deepest leaf; the root has depth 0.
    pub depth_max: u32,
    /// Mean depth of a leaf, weighted by its triangles.
    pub depth_mean: f64,
    /// Mean over inner nodes of smaller child count / larger child count, weighted by the node's count; 1 is balanced.
    pub child_ratio: f64,
    /// Volume of the root box, mm³.
    pub root_volume_mm3: f64,
    /// Volume of the part's convex hull, mm³; empty when it is flat.
    pub hull_mm3: Option<f64>,
    /// Sum of the surface areas of all boxes, mm².
    pub boxes_area_mm2: f64,
    /// Area of the part, mm².
    pub part_area_mm2: f64,
    /// Nodes with a corner outside their box.
    pub outside_nodes: u64,
    /// Corners, counted once for each node that holds them, that lie outside the node's box, percent.
    pub outside_corners_pct: f64,
    /// Largest distance of a corner from its node's box, mm.
    pub overhang_mm: f64,
}

/// How many volume tests of the reference cell end with one axis of the separating-axis test. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditAxisRow {
    /// Scene name.
    pub scene: String,
    /// Stratum of the poses.
    pub stratum: Stratum,
    /// The axis that separates, in the order of the test: 1 to 3 the first box's normals, 4 to 6 the second's, 7 to 15 products
    /// of edges; 0 when none does.
    pub axis: u8,
    /// Volume tests.
    pub tests: u64,
}

/// One timed chunk of one cell beside the reference cell. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditTimingRow {
    /// Scene name.
    pub scene: String,
    /// Chunk within the scene.
    pub chunk: u32,
    /// How the boxes' axes are found.
    pub orientation: String,
    /// Where the boxes' centres lie.
    pub centre: String,
    /// Split rule.
    pub split: String,
    /// Leaf size.
    pub leaf: u8,
    /// Block, from 0.
    pub block: u32,
    /// How often the cell ran through the chunk.
    pub passes: u32,
    /// Wall time of all its passes, ns.
    pub ns: u64,
    /// How often the reference cell did, just before or after.
    pub reference_passes: u32,
    /// Wall time of all its passes, ns.
    pub reference_ns: u64,
}

/// One timed construction of a cell's tree beside the reference cell's. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditBuildRow {
    /// Scene name.
    pub scene: String,
    /// Part the tree is over.
    pub part: String,
    /// How the boxes' axes are found.
    pub orientation: String,
    /// Where the boxes' centres lie.
    pub centre: String,
    /// Split rule.
    pub split: String,
    /// Leaf size.
    pub leaf: u8,
    /// Wall time, ns.
    pub ns: u64,
    /// Wall time of the reference cell's construction just before or after, ns.
    pub reference_ns: u64,
}

/// One cell in one scene, or over all scenes. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditCellRow {
    /// Scene name, or `all`.
    pub scene: String,
    /// How the boxes' axes are found.
    pub orientation: String,
    /// Where the boxes' centres lie.
    pub centre: String,
    /// Split rule.
    pub split: String,
    /// Leaf size.
    pub leaf: u8,
    /// 1 when no box leaves anything out.
    pub safe: u8,
    /// Geometric mean over chunks of a query's volume tests, strata and scenes weighted equally.
    pub volume_tests: f64,
    /// The same of 1 + a query's triangle tests, less 1.
    pub triangle_tests: f64,
    /// Geometric mean of the ratio of query time to the reference cell's; empty where nothing was timed.
    pub time_ratio: Option<f64>,
    /// The same of the time to build the trees.
    pub build_ratio: Option<f64>,
    /// Geometric mean over parts of the boxes' surface area / the part's.
    pub box_area_ratio: f64,
    /// Poses that touch by the shared triangle test.
    pub touching: u64,
    /// How many of them the cell does not report.
    pub missed: u64,
    /// Corners outside their boxes, percent; mean over parts.
    pub outside_corners_pct: f64,
    /// Largest distance of a corner from its box, mm.
    pub overhang_mm: f64,
}

/// What one level of a factor, or a pair of levels of two factors, does to a response. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditEffectRow {
    /// Scene name, or `all`: every scene weighted equally.
    pub scene: String,
    /// Which cells went in: `safe` (those whose boxes contain everything), `all`, or those of one safe centre, by its name.
    pub cells: String,
    /// What responds: `volume-tests`, `triangle-tests`, `time`, `build`, `box-area`.
    pub response: String,
    /// A factor, or two joined by `:`.
    pub term: String,
    /// Its level, or two joined by `:`.
    pub level: String,
    /// Factor on the response, relative to the geometric mean over all cells; for two factors, beyond what each does alone.
    pub effect: f64,
    /// Lower end of the 95 % bootstrap interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// How much of the variance between cells one term explains. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AuditShareRow {
    /// Scene name, or `all`.
    pub scene: String,
    /// Which cells went in, as in [`AuditEffectRow::cells`].
    pub cells: String,
    /// What responds.
    pub response: String,
    /// A factor, two joined by `:`, or `rest`: three and four factors together.
    pub term: String,
    /// Share of the sum of squares of the log response over cells, 0 to 1.
    pub share: f64,
    /// Lower end of the 95 % bootstrap interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

macro_rules! levels {
    ($($row:ty),*) => { $(impl $row {
        /// The levels of the four factors, in the order of [`FACTORS`].
        #[must_use]
        pub fn levels(&self) -> [String; 4] {
            [self.orientation.clone(), self.centre.clone(), self.split.clone(), self.leaf.to_string()]
        }
    })* };
}

levels!(AuditRow, AuditTreeRow, AuditTimingRow, AuditBuildRow, AuditCellRow);
