//! A sweep as curves: each metric against the swept quantity, a panel for each metric and stratum.

use super::data::{Entry, entries};
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::{Scale, number};
use super::{FOLDER, Gallery, PlotError, Sketch, add, write_index};
use crate::record::{Manifest, Stratum, SweepSummaryRow, read_rows};
use std::path::Path;

/// Metric, its axis, and its scale.
const MEASURES: [(&str, &str, Scale); 5] = [
    ("volume-tests", "volume tests of a query", Scale::Log),
    ("triangle-tests", "triangle tests of a query", Scale::Log),
    ("time", "time of a query, ns", Scale::Log),
    ("miss-rate", "share of contacts missed", Scale::Linear),
    ("delay", "travel before the contact is reported, mm", Scale::Log),
];

/// Draws the sweep in `folder`, into its `plots/`. `about` says what is swept, `axis` what its axis
/// measures.
///
/// # Errors
/// When a record is missing or malformed, or the figure cannot be written.
pub fn draw_sweep(folder: &Path, about: &str, axis: &'static str) -> Result<Gallery, PlotError> {
    let variants = entries(&Manifest::read(folder)?);
    let rows: Vec<SweepSummaryRow> = read_rows(folder)?;
    let mut gallery = Gallery::default();
    add(folder, &mut gallery, sketch(&variants, &rows, about, axis))?;
    write_index(&folder.join(FOLDER), &gallery)?;
    Ok(gallery)
}

fn sketch(variants: &[Entry], rows: &[SweepSummaryRow], about: &str, axis: &'static str) -> Sketch<Grouped> {
    let mut values: Vec<f64> = Vec::new();
    for row in rows {
        if !values.contains(&row.x) {
            values.push(row.x);
        }
    }
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
            of_it.find(|row| stratum.is_none_or(|stratum| row.stratum == stratum)).map(|row| Point {
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
            categories: values.iter().map(|x| number(*x)).collect(),
            series: variants
                .iter()
                .map(|entry| Series { points: values.iter().map(|x| point(entry, *x)).collect(), entry: entry.clone() })
                .collect(),
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
