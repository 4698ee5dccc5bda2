//! Figure of the volume tests and triangle tests of a query; the counts are the same on every machine.

use super::Sketch;
use super::data::Data;
use super::grouped::{Grouped, Point};
use super::query_time::by_stratum;

pub(super) fn sketch(data: &Data) -> Sketch<Grouped> {
    let shown = |count: f64| (count > 0.0).then_some(Point::bare(count));
    let panels = data.workloads().into_iter().flat_map(|(scene, workload)| {
        let place = (scene.as_str(), workload.as_str());
        [
            by_stratum(
                data,
                place,
                format!("{scene}, {workload}: volume tests"),
                "mean volume tests of a query",
                |row| shown(row.volume_tests),
            ),
            by_stratum(
                data,
                place,
                format!("{scene}, {workload}: triangle tests"),
                "mean triangle tests of a query",
                |row| shown(row.triangle_tests),
            ),
        ]
    });
    Sketch {
        name: "volume-and-triangle-tests",
        title: "Work of a query: volume tests and triangle tests".to_owned(),
        caption: "Mean number of overlap tests between two volumes (left) and between two triangles (right) in one query that \
                  stops at the first contact, by stratum. The counts are deterministic: the same on every machine. A test costs \
                  a different time for each volume, so fewer tests are not yet less time. Methods that do not count, and means \
                  of 0, are absent."
            .to_owned(),
        drawing: Grouped::of(panels.collect(), 2, data.reason("summary.csv holds no count above 0 of a default tree policy")),
    }
}
