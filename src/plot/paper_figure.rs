//! The paper's figure 6, the time of the plain and the area-weighted box in each scene, and beside it all five volumes of
//! its first figure.

use super::Sketch;
use super::data::{Data, NO_SUMMARY};
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::Scale;
use crate::analysis::ALL;

pub(super) fn sketch(data: &Data) -> Sketch<Grouped> {
    let panels = vec![
        panel(data, &data.claims.comparison.baselines, "Plain and area-weighted box", Form::Bars, Scale::Linear),
        panel(data, &data.claims.comparison.five, "The paper's five volumes", Form::Markers, Scale::Log),
    ];
    Sketch {
        name: super::PAPER_FIGURE,
        title: "Time of the programs in each scene".to_owned(),
        caption: "The paper's figure 6 measured again. Left: the plain and the area-weighted oriented box, both tight, each \
                  with its own split. Right: all five volumes, on a logarithmic axis. Sum of the query times of the scene's programs, each \
                  from its start to its first collision, or to its end; whiskers are 95 % intervals over launches. Whether two methods \
                  differ is decided by the paired ratios, which leave out what all methods have in common."
            .to_owned(),
        drawing: Grouped::of(panels, 2, NO_SUMMARY),
    }
}

fn panel(data: &Data, variants: &[String], title: &str, form: Form, scale: Scale) -> Panel {
    let series = variants.iter().filter_map(|id| {
        let points = data.scenes.iter().map(|scene| {
            let row = data.program_time_of(scene, ALL, id)?;
            let [value, low, high] = [row.total_ns, row.total_low_ns, row.total_high_ns].map(|ns| ns / 1e6);
            let (low, high) = if low.is_finite() { (low, high) } else { (value, value) };
            Some(Point { value, low, high })
        });
        Some(Series { entry: data.variant(id)?.clone(), points: points.collect() })
    });
    Panel {
        title: title.to_owned(),
        measure: "time of the programs, ms",
        sorted_by: "scene",
        scale,
        form,
        categories: data.scenes.clone(),
        series: series.collect(),
    }
}
