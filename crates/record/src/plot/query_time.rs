//! Query time by stratum, every variant.

use super::Sketch;
use super::data::{Data, Entry};
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::Scale;
use crate::record::{Stratum, SummaryRow};

pub(super) fn sketch(data: &Data) -> Sketch<Grouped> {
    let point = |row: &SummaryRow| {
        let (low, high) = row.interval().unwrap_or((row.mean_ns, row.mean_ns));
        let [value, low, high] = [row.mean_ns, low, high].map(|ns| ns / 1e3);
        value.is_finite().then_some(Point { value, low, high })
    };
    let panels = data.workloads().into_iter().map(|(scene, workload)| {
        let title = format!("{scene}, {workload}");
        by_stratum(data, (&scene, &workload), title, "mean query time, µs", point)
    });
    Sketch {
        name: "query-time-by-stratum",
        title: "Query time by distance of the two parts".to_owned(),
        caption: "Mean time of one query, by stratum: colliding, near miss (apart by at most 1 mm), medium (up to 10 mm), far. \
                  Every variant under its default tree policy; whiskers are 95 % bootstrap intervals of the mean. Unsafe \
                  variants are drawn but are not to be compared by speed: some of their time is saved by missing contacts."
            .to_owned(),
        drawing: Grouped::of(panels.collect(), 2, data.reason("summary.csv holds no query time of a default tree policy")),
    }
}

/// A panel with one category per stratum and one series per variant.
pub(super) fn by_stratum(
    data: &Data,
    (scene, workload): (&str, &str),
    title: String,
    measure: &'static str,
    point: impl Fn(&SummaryRow) -> Option<Point>,
) -> Panel {
    let points = |entry: &Entry| {
        Stratum::ALL.map(|s| data.summary_of(scene, workload, s.id(), &entry.id).and_then(&point)).to_vec()
    };
    Panel {
        title,
        measure,
        sorted_by: "stratum",
        scale: Scale::Log,
        form: Form::Markers,
        reference: None,
        categories: Stratum::ALL.map(|s| s.id().to_owned()).to_vec(),
        series: Series::of(&data.variants, points),
    }
}
