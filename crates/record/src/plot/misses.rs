//! Figure of the contacts that each method misses, by depth.

use super::Sketch;
use super::data::Data;
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::Scale;
use crate::record::{Band, VerificationRow};
use std::collections::BTreeSet;

pub(super) fn sketch(data: &Data) -> Sketch<Grouped> {
    let (mut panels, mut spared) = (Vec::new(), Vec::new());
    for scene in &data.scenes {
        let of_scene = || data.verification.iter().filter(|row| row.scene == *scene);
        let workloads: BTreeSet<&str> = of_scene().map(|row| row.workload.as_str()).collect();
        for workload in workloads {
            let rows: Vec<&VerificationRow> = of_scene().filter(|row| row.workload == workload).collect();
            let asked = |count: fn(&VerificationRow) -> u64| {
                rows.iter().filter(|row| row.band.is_above_grazing()).map(|row| count(row)).sum::<u64>()
            };
            match (asked(|row| row.asked_exact), asked(|row| row.asked_missed)) {
                (0, _) => {}
                (_, 0) => spared.push(format!("{scene}, {workload}")),
                _ => panels.push(panel(data, &format!("{scene}, {workload}"), &rows)),
            }
        }
    }
    let spared = if spared.is_empty() || panels.is_empty() {
        String::new()
    } else {
        format!(" Without a panel, since nobody missed a contact there: {}.", spared.join("; "))
    };
    Sketch {
        name: "misses-by-depth",
        title: "Contacts missed, by travel past first contact".to_owned(),
        caption: format!(
            "Share of the contacts at which a variant's own query was asked that it reports as free, by workload and by travel past \
             first contact in mm (intervals open below, closed above; shallower than 1e-6 mm is grazing and not counted). The row `none` below the \
             axis holds the variants that missed none of those asked. There are no intervals: contacts of one line depend on one another, and the record \
             does not say on which lines those of a band lie; the table of contacts missed has intervals by line.{spared}"
        ),
        drawing: Grouped::of(panels, 1, "verification.csv holds no contact that a variant was asked about and missed"),
    }
}

fn panel(data: &Data, title: &str, rows: &[&VerificationRow]) -> Panel {
    let bands: Vec<Band> = Band::ALL.into_iter().filter(|band| band.is_above_grazing()).collect();
    let shares: Vec<Vec<Option<f64>>> = data
        .variants
        .iter()
        .map(|entry| bands.iter().map(|band| share(data, rows, &entry.id, *band)).collect())
        .collect();
    let series = data.variants.iter().zip(shares).map(|(entry, shares)| Series {
        points: shares.into_iter().map(|share| share.map(Point::bare)).collect(),
        entry: entry.clone(),
    });
    Panel {
        title: title.to_owned(),
        measure: "share of contacts missed",
        sorted_by: "travel past first contact, mm",
        scale: Scale::Log,
        form: Form::Markers,
        reference: None,
        categories: bands.iter().map(|band| band.id().to_owned()).collect(),
        series: series.filter(|series| series.points.iter().any(Option::is_some)).collect(),
    }
}

/// The share of the contacts of a band that a variant missed, of those it was asked about under its default policy; `None` of none.
fn share(data: &Data, rows: &[&VerificationRow], variant: &str, band: Band) -> Option<f64> {
    let rows = rows.iter().filter(|row| row.variant == variant && row.band == band && data.is_default(&row.case()));
    let (missed, asked) = rows.fold((0, 0), |(m, n), row| (m + row.asked_missed, n + row.asked_exact));
    (asked > 0).then(|| missed as f64 / asked as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::canvas::svg;
    use crate::record::synthetic::{Plan, Run};
    use crate::record::write_rows;

    /// A contact that follows from a witness is not one that the variant was asked about, and no interval is drawn around a share.
    #[test]
    fn shares_are_of_contacts_asked_by_workload() {
        let mut run = Run::generate(&Plan::default());
        for row in run.verification.iter_mut().filter(|row| row.variant == "obb-vertex-centroid") {
            // As many derived contacts again, all found.
            (row.exact, row.brute) = (2 * row.asked_exact, 2 * row.asked_exact);
        }
        let missed = run
            .verification
            .iter()
            .find(|row| row.variant == "obb-vertex-centroid" && row.band.is_above_grazing() && row.asked_missed > 0);
        let row = missed.unwrap().clone();
        let asked = |row: &VerificationRow| row.asked_missed as f64 / row.asked_exact as f64;
        let folder = tempfile::tempdir().unwrap();
        run.write(folder.path());
        write_rows(folder.path(), &run.verification).unwrap();
        let drawing = sketch(&Data::read(folder.path()).unwrap()).drawing.unwrap();
        assert!(drawing.panels.iter().all(|panel| panel.title.contains(", ")));
        let title = format!("{}, {}", row.scene, row.workload);
        let panel = drawing.panels.iter().find(|panel| panel.title == title).unwrap();
        let series = panel.series.iter().find(|series| series.entry.id == row.variant).unwrap();
        let points: Vec<&Point> = series.points.iter().flatten().collect();
        assert!(points.iter().any(|point| (point.value - asked(&row)).abs() < 1e-12), "{points:?} {row:?}");
        assert!(points.iter().all(|point| point.low == point.high));
        // What missed nothing has a row of its own.
        assert!(panel.series.iter().flat_map(|series| series.points.iter().flatten()).any(|point| point.value == 0.0));
        assert!(svg(&drawing).unwrap().lines().filter(|line| *line == "none").count() == drawing.panels.len());
    }
}
