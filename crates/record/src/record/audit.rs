//! Derived rows of an audit: the factorial experiment on what makes a box good.

use super::rows::{Row, row_file};
use serde::{Deserialize, Serialize};

row_file! { FILES:
    AuditCellRow => "audit_cells.csv",
    AuditEffectRow => "audit_effects.csv",
    AuditShareRow => "audit_shares.csv",
}

/// The names of the four factors, in the order of columns.
pub const FACTORS: [&str; 4] = ["orientation", "centre", "split", "leaf"];

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
    /// What responds: `volume-tests`, `triangle-tests` (1 + triangle tests, since a query may have none), `time`, `build`, `box-area`.
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
