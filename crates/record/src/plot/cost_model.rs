//! Figure of predicted against measured query times: chunks by the cost model and by the clock.

use super::Sketch;
use super::canvas::{Area, DrawResult, Drawing, PANEL_PX, TEXT_PX, text};
use super::data::{Data, Entry};
use super::marks::{LEGEND_PX, legend, legend_height};
use super::ticks::{Axis, Scale};
use crate::record::CostChunkRow;
use plotters::prelude::*;

const PANEL: (u32, u32) = (760, 700);

/// A chunk: its variant, its measured time and its predicted time, ns.
type Point = (Entry, f64, f64);

/// A panel for each scene.
#[derive(Clone, Debug)]
pub struct CostModel {
    panels: Vec<(String, Vec<Point>)>,
    entries: Vec<Entry>,
}

pub(super) fn sketch(data: &Data) -> Sketch<CostModel> {
    let point = |row: &CostChunkRow| {
        let entry = data.variant(&row.variant).filter(|_| data.cases.is_default(&row.variant, &row.policy))?;
        Some((entry.clone(), row.measured_ns, row.predicted_ns))
    };
    let panels: Vec<_> = data
        .scenes
        .iter()
        .map(|scene| (scene.clone(), data.cost_chunks.iter().filter(|r| r.scene == *scene).filter_map(point).collect()))
        .filter(|(_, points): &(String, Vec<_>)| !points.is_empty())
        .collect();
    let has_points = |entry: &&Entry| panels.iter().any(|(_, points)| points.iter().any(|(e, ..)| e.id == entry.id));
    let entries = data.variants.iter().filter(has_points).cloned().collect();
    Sketch {
        name: "cost-model",
        title: "Query time by the cost model against the clock".to_owned(),
        caption: "Each mark is a chunk of poses of one variant (default tree policy). Predicted: setup + volume tests × cost + triangle \
                  tests × cost, with costs fitted to the other scenes of the run (costs.csv holds those fitted to all). On the line, counts \
                  and three costs say all there is to say; the grey lines are a factor 1.25 off."
            .to_owned(),
        drawing: if panels.is_empty() { Err(data.reason("cost_chunks.csv holds no rows: no volume was timed and counted on the same chunks")) } else { Ok(CostModel { panels, entries }) },
    }
}

impl Drawing for CostModel {
    fn size(&self) -> (u32, u32) {
        (self.panels.len() as u32 * PANEL.0 + LEGEND_PX, PANEL.1.max(legend_height(&self.entries)))
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let (left, right) = area.split_horizontally(self.panels.len() as u32 * PANEL.0);
        for ((scene, points), place) in self.panels.iter().zip(left.split_evenly((1, self.panels.len()))) {
            panel(&place, scene, points)?;
        }
        legend(&right, &self.entries, (24, 40))
    }
}

fn panel(area: &Area<'_>, scene: &str, points: &[Point]) -> DrawResult {
    let (low, high) = Scale::Log.range(points.iter().flat_map(|(_, measured, predicted)| [*measured, *predicted]));
    let axis = || Axis { ends: (low, high), ticks: Scale::Log.ticks(low, high) };
    let mut chart = ChartBuilder::on(area)
        .caption(scene, text(PANEL_PX))
        .margin(12)
        .margin_right(24)
        .x_label_area_size(76)
        .y_label_area_size(104)
        .build_cartesian_2d(axis(), axis())?;
    chart
        .configure_mesh()
        .bold_line_style(BLACK.mix(0.15))
        .light_line_style(TRANSPARENT)
        .label_style(text(TEXT_PX))
        .axis_desc_style(text(TEXT_PX))
        .x_labels(50)
        .y_labels(50)
        .x_label_formatter(&|x| Scale::Log.tick_label(*x))
        .y_label_formatter(&|y| Scale::Log.tick_label(*y))
        .x_desc("measured, ns")
        .y_desc("predicted, ns")
        .draw()?;
    let place = chart.plotting_area().strip_coord_spec();
    let (corner_x, corner_y) = place.get_base_pixel();
    let pixel = |x: f64, y: f64| {
        let (x, y) = chart.backend_coord(&(x.clamp(low, high), y.clamp(low, high)));
        (x - corner_x, y - corner_y)
    };
    for (factor, style) in
        [(1.0, BLACK.stroke_width(2)), (1.25, BLACK.mix(0.3).stroke_width(1)), (0.8, BLACK.mix(0.3).stroke_width(1))]
    {
        let shift = f64::log10(factor);
        let ends = [
            (low.max(low - shift), low.max(low - shift) + shift),
            (high.min(high - shift), high.min(high - shift) + shift),
        ];
        place.draw(&PathElement::new(ends.map(|(x, y)| pixel(x, y)).to_vec(), style))?;
    }
    for (entry, measured, predicted) in points {
        entry.look.mark(&place, pixel(Scale::Log.coordinate(*measured), Scale::Log.coordinate(*predicted)))?;
    }
    Ok(())
}
