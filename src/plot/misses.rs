//! Figure of the contacts that each method misses, by depth.

use super::Sketch;
use super::data::Data;
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::Scale;
use crate::analysis::stats;
use crate::record::Band;

pub(super) fn sketch(data: &Data) -> Sketch<Grouped> {
    let panels = data.scenes.iter().map(|scene| panel(data, scene)).collect();
    Sketch {
        name: "misses-by-depth",
        title: "Contacts missed, by travel past first contact".to_owned(),
        caption: "Share of the colliding poses that a variant reports as free although the triangle test over all pairs finds \
                  them, by travel past first contact in mm (intervals open below, closed above; shallower than 1e-6 mm is \
                  grazing and not counted). Whiskers are 95 % Wilson intervals; an arrow marks a variant that missed none of n \
                  poses, drawn from 3/n, the 95 % upper limit of its rate."
            .to_owned(),
        drawing: Grouped::of(panels, 1, "verification.csv holds no colliding poses; verify first"),
    }
}

fn panel(data: &Data, scene: &str) -> Panel {
    let bands: Vec<Band> = Band::ALL.into_iter().filter(|band| band.is_above_grazing()).collect();
    let point = |variant: &str, band: Band| {
        let rows = data.verification.iter().filter(|row| row.scene == scene && row.variant == variant);
        let rows = rows.filter(|row| row.band == band && data.is_default(&row.case()));
        let (missed, colliding) = rows.fold((0, 0), |(m, n), row| (m + row.missed_by_volume, n + row.brute));
        let (low, high) = stats::miss_rate(missed, colliding);
        (colliding > 0).then(|| Point { value: missed as f64 / colliding as f64, low, high })
    };
    let series = data.variants.iter().map(|entry| Series {
        points: bands.iter().map(|band| point(&entry.id, *band)).collect(),
        entry: entry.clone(),
    });
    Panel {
        title: scene.to_owned(),
        measure: "share of contacts missed",
        sorted_by: "travel past first contact, mm",
        scale: Scale::Log,
        form: Form::Markers,
        reference: None,
        categories: bands.iter().map(|band| band.id().to_owned()).collect(),
        series: series.filter(|series| series.points.iter().any(Option::is_some)).collect(),
    }
}
