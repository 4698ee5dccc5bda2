//! The paper's figure 6: the time of the plain and the area-weighted box in each scene. Beside it stand all five volumes of the paper's
//! first figure, and below each the paired ratios to the plain box.

use super::Sketch;
use super::data::{Data, Entry};
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::Scale;
use crate::analysis::ALL;
use crate::record::ProgramTimeRow;

pub(super) fn sketch(data: &Data) -> Sketch<Grouped> {
    let (pair, five) = (&data.claims.comparison.baselines, &data.claims.comparison.five);
    let baseline = pair.first().map_or("", |id| data.variant(id).map_or(id, |entry| &entry.label));
    let panels = vec![
        panel(data, pair, "Plain and area-weighted box", (TIME, Form::Bars, Scale::Linear), total),
        panel(data, five, "The paper's five volumes", (TIME, Form::Markers, Scale::Log), total),
        panel(data, pair, &format!("Paired ratio to {baseline}"), (RATIO, Form::Markers, Scale::Log), ratio),
        panel(data, five, &format!("Paired ratio to {baseline}"), (RATIO, Form::Markers, Scale::Log), ratio),
    ];
    let lacking = if data.program_times.is_empty() {
        "program_times.csv holds no rows: the run timed no whole programs"
    } else {
        "program_times.csv holds none of the volumes of the paper's figure"
    };
    Sketch {
        name: super::PAPER_FIGURE,
        title: "Time of the programs in each scene".to_owned(),
        caption: "The paper's figure 6 measured again. Left: the plain and the area-weighted oriented box, both tight, each \
                  with its own split. Right: all five volumes, on a logarithmic axis. Above: the sum of the query times of the scene's programs, each \
                  from its start to its first collision, or to its end. Below: the paired ratio to the plain box, which decides whether two \
                  methods differ; below 1 is faster. Whiskers are 95 % intervals over binaries, or over the launches of a \
                  single one."
            .to_owned(),
        drawing: Grouped::of(panels, 2, data.reason(lacking)),
    }
}

const TIME: &str = "time of the programs, ms";
const RATIO: &str = "time ratio";

/// The sum of the programs, ms.
fn total(row: &ProgramTimeRow) -> Option<Point> {
    let [value, low, high] = [row.total_ns, row.total_low_ns, row.total_high_ns].map(|ns| ns / 1e6);
    let (low, high) = if low.is_finite() { (low, high) } else { (value, value) };
    Some(Point { value, low, high })
}

/// The ratio to the baseline; `None` for the baseline itself.
fn ratio(row: &ProgramTimeRow) -> Option<Point> {
    let (value, is_itself) = (row.ratio?, row.baseline == row.case().name());
    let end = |end: Option<f64>| end.filter(|end| end.is_finite()).unwrap_or(value);
    (!is_itself).then(|| Point { value, low: end(row.low), high: end(row.high) })
}

fn panel(
    data: &Data,
    variants: &[String],
    title: &str,
    (measure, form, scale): (&'static str, Form, Scale),
    point: impl Fn(&ProgramTimeRow) -> Option<Point>,
) -> Panel {
    let points =
        |entry: &Entry| data.scenes.iter().map(|scene| point(data.program_time_of(scene, ALL, &entry.id)?)).collect();
    Panel {
        title: title.to_owned(),
        measure,
        sorted_by: "",
        scale,
        form,
        reference: (measure == RATIO).then_some(1.0),
        categories: data.scenes.clone(),
        series: Series::of(variants.iter().filter_map(|id| data.variant(id)), points),
    }
}
