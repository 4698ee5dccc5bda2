//! The drawing that most figures share: panels side by side, each with categories, and in each category one mark per variant with its
//! interval. The legend is outside.

use super::canvas::{Area, DrawResult, Drawing, PANEL_PX, TEXT_PX, text};
use super::data::Entry;
use super::marks::{LEGEND_PX, Pixel, legend, legend_height};
use super::ticks::{Axis, Scale};
use plotters::prelude::*;

/// A value with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The value.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Point {
    /// A value without interval.
    pub const fn bare(value: f64) -> Self {
        Self { value, low: value, high: value }
    }

    /// The median, the upper one of two, with the smallest and largest value as its interval; `None` without values.
    pub fn spread(mut values: Vec<f64>) -> Option<Self> {
        values.sort_unstable_by(f64::total_cmp);
        let (low, high) = (*values.first()?, *values.last()?);
        Some(Self { value: values[values.len() / 2], low, high })
    }
}

/// The values of one variant, one for each category of the panel.
#[derive(Clone, Debug)]
pub struct Series {
    /// The variant.
    pub entry: Entry,
    /// Its values.
    pub points: Vec<Option<Point>>,
}

impl Series {
    /// The series of each variant that has any point.
    pub fn of<'a>(
        variants: impl IntoIterator<Item = &'a Entry>,
        points: impl Fn(&Entry) -> Vec<Option<Point>>,
    ) -> Vec<Self> {
        let series = variants.into_iter().map(|entry| Self { points: points(entry), entry: entry.clone() });
        series.filter(|series| series.points.iter().any(Option::is_some)).collect()
    }
}

/// How values are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Bars from 0: for few values on a linear axis.
    Bars,
    /// Markers.
    Markers,
    /// Markers joined from category to category.
    Lines,
}

/// One panel.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Its title.
    pub title: String,
    /// Quantity and unit of the vertical axis.
    pub measure: &'static str,
    /// Label of the horizontal axis; empty when the categories need none.
    pub sorted_by: &'static str,
    /// The vertical axis.
    pub scale: Scale,
    /// How values are drawn.
    pub form: Form,
    /// A value that is marked by a line across the panel, such as the ratio 1.
    pub reference: Option<f64>,
    /// Categories.
    pub categories: Vec<String>,
    /// Variants.
    pub series: Vec<Series>,
}

/// Panels with a legend.
#[derive(Clone, Debug)]
pub struct Grouped {
    /// The panels, row by row.
    pub panels: Vec<Panel>,
    /// Panels in a row.
    pub columns: usize,
}

/// Width of a panel, px; a panel that is alone in its row is wider.
const fn panel_width(columns: usize) -> u32 {
    if columns == 1 { 1180 } else { 760 }
}

const PANEL_HEIGHT: u32 = 560;

/// Height of the row below a logarithmic axis that holds values of zero, as a share of the axis.
const NONE_ROW: f64 = 0.12;

/// The label of that row.
const NONE: &str = "none";

impl Grouped {
    /// Keeps the panels that have a value. Panels whose categories need much room get rows of their own. If no panel has a value, the error
    /// is `reason`.
    ///
    /// # Errors
    /// When no panel holds a value.
    pub fn of(panels: Vec<Panel>, columns: usize, reason: &'static str) -> Result<Self, &'static str> {
        let filled = |panel: &Panel| panel.series.iter().any(|series| series.points.iter().any(Option::is_some));
        let panels: Vec<Panel> = panels.into_iter().filter(filled).collect();
        let crowded =
            panels.iter().any(|panel| panel.categories.iter().map(|c| c.chars().count() + 2).sum::<usize>() > 60);
        match panels.len() {
            0 => Err(reason),
            _ if crowded => Ok(Self { columns: 1, panels }),
            count => Ok(Self { columns: columns.clamp(1, count), panels }),
        }
    }

    /// Adds panels after the others.
    pub fn add(&mut self, panels: impl IntoIterator<Item = Panel>) {
        self.panels.extend(panels);
    }

    /// The variants that have a value in any panel, each once.
    fn entries(&self) -> Vec<Entry> {
        let mut entries: Vec<Entry> = Vec::new();
        for series in self.panels.iter().flat_map(|panel| &panel.series) {
            let has_value = series.points.iter().any(Option::is_some);
            if has_value && entries.iter().all(|entry| entry.id != series.entry.id) {
                entries.push(series.entry.clone());
            }
        }
        entries
    }
}

impl Drawing for Grouped {
    fn size(&self) -> (u32, u32) {
        let rows = self.panels.len().div_ceil(self.columns) as u32;
        let height = (rows * PANEL_HEIGHT).max(legend_height(&self.entries()));
        (self.columns as u32 * panel_width(self.columns) + LEGEND_PX, height)
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let width = self.columns as u32 * panel_width(self.columns);
        let (left, right) = area.split_horizontally(width);
        let rows = self.panels.len().div_ceil(self.columns);
        for (panel, place) in self.panels.iter().zip(left.split_evenly((rows, self.columns))) {
            panel.draw(&place)?;
        }
        legend(&right, &self.entries(), (24, 40))
    }
}

impl Panel {
    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let points = || self.series.iter().flat_map(|series| series.points.iter().flatten());
        let values = points().flat_map(|p| [p.value, p.low, p.high]).chain(self.reference);
        let (least, high) = self.scale.range(values);
        // What a logarithmic axis cannot show has a row of its own below the axis.
        let has_none = points().any(|p| self.scale.coordinate(p.value) == f64::NEG_INFINITY);
        let row = if has_none { NONE_ROW * (high - least) } else { 0.0 };
        let (low, none) = (least - row, least - 0.5 * row);
        let ticks = self.scale.ticks(least, high).into_iter().chain(has_none.then_some(none));
        let count = self.categories.len();
        let centres: Vec<f64> = (0..count).map(|i| i as f64 + 0.5).collect();
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, text(PANEL_PX))
            .margin(12)
            .margin_right(18)
            .x_label_area_size(if self.sorted_by.is_empty() { 44 } else { 72 })
            .y_label_area_size(98)
            .build_cartesian_2d(
                Axis { ends: (0.0, count as f64), ticks: centres },
                Axis { ends: (low, high), ticks: ticks.collect() },
            )?;
        let category = |x: &f64| self.categories.get(*x as usize).cloned().unwrap_or_default();
        chart
            .configure_mesh()
            .disable_x_mesh()
            .bold_line_style(BLACK.mix(0.15))
            .light_line_style(TRANSPARENT)
            .label_style(text(TEXT_PX))
            .axis_desc_style(text(TEXT_PX))
            .x_labels(count + 1)
            .y_labels(50)
            .x_label_formatter(&category)
            .y_label_formatter(&|y| if *y < least { NONE.to_owned() } else { self.scale.tick_label(*y) })
            .y_desc(self.measure)
            .x_desc(self.sorted_by)
            .draw()?;
        let area = &chart.plotting_area().strip_coord_spec();
        let (corner_x, corner_y) = area.get_base_pixel();
        let bottom = self.scale.range(std::iter::empty()).0.max(low);
        let pixel = |x: f64, y: f64| {
            let y = if y == f64::NEG_INFINITY { none } else { y.clamp(low, high) };
            let (x, y) = chart.backend_coord(&(x, y));
            (x - corner_x, y - corner_y)
        };
        if self.form == Form::Markers {
            for boundary in 1..count {
                let (top, foot) = (pixel(boundary as f64, high), pixel(boundary as f64, low));
                area.draw(&PathElement::new(vec![top, foot], BLACK.mix(0.15)))?;
            }
        }
        if has_none {
            area.draw(&PathElement::new(vec![pixel(0.0, least), pixel(count as f64, least)], BLACK.mix(0.5)))?;
        }
        if let Some(reference) = self.reference.map(|value| self.scale.coordinate(value)) {
            let ends = vec![pixel(0.0, reference), pixel(count as f64, reference)];
            area.draw(&PathElement::new(ends, BLACK.stroke_width(2)))?;
        }
        (0..self.series.len()).try_for_each(|s| self.draw_series(area, s, bottom, &pixel))
    }

    /// Draws the marks of a series in its slot of each category; bars stand on `bottom`.
    fn draw_series(&self, area: &Area<'_>, s: usize, bottom: f64, pixel: &impl Fn(f64, f64) -> Pixel) -> DrawResult {
        let slot = 0.84 / self.series.len() as f64;
        let offset = if self.form == Form::Lines { 0.5 } else { 0.08 + slot * (s as f64 + 0.5) };
        let Series { entry, points } = &self.series[s];
        let look = entry.look;
        let mut path = Vec::new();
        for (c, point) in points.iter().enumerate() {
            let Some(point) = point else { continue };
            let x = c as f64 + offset;
            let [value, from, to] = [point.value, point.low, point.high].map(|v| self.scale.coordinate(v));
            let at = pixel(x, value);
            if self.form == Form::Bars {
                let (near, far) = (pixel(x - slot * 0.42, bottom), pixel(x + slot * 0.42, value));
                area.draw(&Rectangle::new([near, far], look.colour.mix(0.55).filled()))?;
                area.draw(&Rectangle::new([near, far], look.colour.stroke_width(2)))?;
            }
            if point.low < point.high {
                look.whisker(area, at.0, pixel(x, from).1, pixel(x, to).1)?;
            }
            look.mark(area, at)?;
            path.push(at);
        }
        if self.form == Form::Lines {
            area.draw(&PathElement::new(path, look.colour.stroke_width(2)))?;
        }
        Ok(())
    }
}
