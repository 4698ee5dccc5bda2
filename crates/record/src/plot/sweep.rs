//! A sweep as curves: one panel for each metric and stratum, with the metric against the swept quantity.

use super::data::{Entry, entries};
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::{Scale, number};
use super::{FOLDER, Gallery, Sketch, add, write_index};
use crate::analysis::growth::COSTS;
use crate::analysis::summary::ALL;
use crate::analysis::{AnalysisError, distinct};
use crate::record::{BuildRow, Manifest, Stratum, SweepGrowthRow, SweepSummaryRow, has_rows, read_rows};
use std::collections::BTreeSet;
use std::path::Path;

/// Metric, its axis, and its scale.
const MEASURES: [(&str, &str, Scale); 5] = [
    ("volume-tests", "volume tests of a query", Scale::Log),
    ("triangle-tests", "triangle tests of a query", Scale::Log),
    ("time", "time of a query, ns", Scale::Log),
    ("miss-rate", "share of contacts missed", Scale::Linear),
    ("delay", "travel before the contact is reported, mm", Scale::Log),
];

/// Draws the sweep in `folder` into its `plots/`. `about` describes the sweep, and `axis` is the label of the horizontal axis.
///
/// # Errors
/// When a record is missing or malformed, or the figure cannot be written.
pub fn draw_sweep(folder: &Path, about: &str, axis: &'static str) -> Result<Gallery, AnalysisError> {
    let variants = entries(&Manifest::read(folder)?);
    let rows: Vec<SweepSummaryRow> = read_rows(folder)?;
    let mut gallery = Gallery::default();
    let mut sweep = sketch(&variants, &rows, about, axis);
    if has_rows::<SweepGrowthRow>(folder) {
        let (builds, growth) = (read_rows(folder)?, read_rows(folder)?);
        if let Ok(grouped) = &mut sweep.drawing {
            grouped.add([builds_panel(&variants, &builds, axis), growth_panel(&variants, &growth)]);
        }
    }
    add(folder, &mut gallery, sweep)?;
    write_index(&folder.join(FOLDER), &gallery)?;
    Ok(gallery)
}

/// The time to build the trees of both bodies: the median over blocks, with the smallest and the largest.
fn builds_panel(variants: &[Entry], rows: &[BuildRow], axis: &'static str) -> Panel {
    let sizes: Vec<u64> = rows.iter().map(|row| row.triangles).collect::<BTreeSet<_>>().into_iter().collect();
    let point = |entry: &Entry, triangles: u64| {
        let of_it = rows.iter().filter(|row| row.variant == entry.id && row.triangles == triangles);
        Point::spread(of_it.map(|row| row.ns as f64 / 1e6).collect())
    };
    Panel {
        title: "construction of both trees".to_owned(),
        measure: "time of a construction, ms",
        sorted_by: axis,
        scale: Scale::Log,
        form: Form::Lines,
        reference: None,
        categories: sizes.iter().map(|size| number(*size as f64)).collect(),
        series: each(variants, |entry| sizes.iter().map(|size| point(entry, *size)).collect()),
    }
}

/// The exponents of growth.
fn growth_panel(variants: &[Entry], rows: &[SweepGrowthRow]) -> Panel {
    let point = |entry: &Entry, cost: &str| {
        let mut of_it = rows.iter().filter(|row| row.variant == entry.id && row.metric == cost);
        let row = of_it.find(|row| row.stratum == ALL)?;
        Some(Point { value: row.exponent, low: row.low, high: row.high })
    };
    Panel {
        title: "growth: cost ~ triangles^x".to_owned(),
        measure: "exponent x",
        sorted_by: "",
        scale: Scale::Linear,
        form: Form::Markers,
        reference: None,
        categories: COSTS.map(str::to_owned).to_vec(),
        series: each(variants, |entry| COSTS.iter().map(|cost| point(entry, cost)).collect()),
    }
}

fn each(variants: &[Entry], points: impl Fn(&Entry) -> Vec<Option<Point>>) -> Vec<Series> {
    variants.iter().map(|entry| Series { points: points(entry), entry: entry.clone() }).collect()
}

fn sketch(variants: &[Entry], rows: &[SweepSummaryRow], about: &str, axis: &'static str) -> Sketch<Grouped> {
    let values = distinct(rows.iter().map(|row| row.x));
    let strata: Vec<Stratum> =
        Stratum::ALL.into_iter().filter(|stratum| rows.iter().any(|row| row.stratum == *stratum)).collect();
    // A quantity that itself decides the stratum is one curve; else each stratum has its panel.
    let decides = values
        .iter()
        .all(|x| strata.iter().filter(|s| rows.iter().any(|row| row.x == *x && row.stratum == **s)).count() == 1);
    let sets: Vec<Option<Stratum>> = if decides { vec![None] } else { strata.into_iter().map(Some).collect() };
    let panel = |metric: &(&str, &'static str, Scale), stratum: Option<Stratum>| {
        let point = |variant: &Entry, x: f64| {
            let mut of_it = rows.iter().filter(|row| row.metric == metric.0 && row.variant == variant.id && row.x == x);
            // A logarithm has no zero, and a peer no counts.
            let row = of_it.find(|row| stratum.is_none_or(|stratum| row.stratum == stratum));
            row.filter(|row| metric.2 == Scale::Linear || row.value > 0.0).map(|row| Point {
                value: row.value,
                low: row.low,
                high: row.high,
            })
        };
        Panel {
            title: stratum.map_or_else(|| metric.1.to_owned(), |stratum| format!("{}, {}", metric.1, stratum.id())),
            measure: metric.1,
            sorted_by: axis,
            scale: metric.2,
            form: Form::Lines,
            reference: None,
            categories: values.iter().map(|x| number(*x)).collect(),
            series: each(variants, |entry| values.iter().map(|x| point(entry, *x)).collect()),
        }
    };
    let panels =
        MEASURES.iter().flat_map(|metric| sets.iter().map(|stratum| panel(metric, *stratum)).collect::<Vec<_>>());
    // Where nothing is counted, or the same everywhere, there is nothing to see.
    let panels = panels.filter(|panel| {
        let mut points = panel.series.iter().flat_map(|series| series.points.iter().flatten());
        let first = points.next().map(|point| point.value);
        first.is_some_and(|first| points.any(|point| point.value != first))
    });
    let sweep = rows.first().map_or("", |row| &row.sweep);
    Sketch {
        name: "sweep",
        title: format!("Sweep: {sweep}"),
        caption: format!(
            "Along the horizontal axis: {about}. Each variant under its default tree policy; means over lines of approach with 95 % \
             bootstrap intervals."
        ),
        drawing: Grouped::of(panels.collect(), 2, "sweep_summary.csv holds no rows; analyse the sweep first"),
    }
}
