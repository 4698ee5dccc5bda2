//! Derived rows of a sweep: one quantity varied, everything else held.

use super::rows::{Row, row_file};
use super::vocabulary::Stratum;
use serde::{Deserialize, Serialize};

row_file! { FILES:
    SweepSummaryRow => "sweep_summary.csv",
    SweepGrowthRow => "sweep_growth.csv",
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
    /// Stratum of the queries; `all` is the mean of its strata's exponents by group of lines, and of builds.
    pub stratum: String,
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
