//! Forest plots of time ratios with intervals: all cases against the plain box, and whole engines against a reference engine.

use super::Sketch;
use super::canvas::{Area, DrawResult, Drawing, PANEL_PX, TEXT_PX, text};
use super::data::Data;
use super::marks::{Look, TEXT_LIFT_PX, label};
use super::ticks::{Axis, Scale};
use crate::analysis::stats::mean;
use crate::analysis::words::{capital, quantity};
use crate::analysis::{ALL, is_query_time, ranked_by};
use crate::record::NULL_VARIANT;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

/// Height of a line; below, the widths of the labels and of a panel, px.
const LINE_PX: i32 = 34;
const LABELS_PX: u32 = 560;
const PANEL_PX_WIDE: u32 = 520;
const HEADER_PX: u32 = 48;
const FOOTER_PX: u32 = 84;

/// Largest ratio that is drawn to scale. Larger ratios would compress the others, so they are written at the edge.
const RATIO_MAX: f64 = 6.0;

/// One ratio.
#[derive(Clone, Copy, Debug)]
struct Bar {
    ratio: f64,
    low: f64,
    high: f64,
}

/// One case: its label, its look, and its ratio in each scene.
#[derive(Clone, Debug)]
struct Line {
    label: String,
    look: Look,
    bars: Vec<Option<Bar>>,
}

/// The plot.
#[derive(Clone, Debug)]
pub struct Forest {
    /// Titles of the panels.
    panels: Vec<String>,
    lines: Vec<Line>,
    /// Ratios beyond this are written at the edge.
    most: f64,
}

pub(super) fn sketch(data: &Data) -> Sketch<Forest> {
    let baseline = data.claims.comparison.baselines.first().map_or("", String::as_str);
    let name = data.variant(baseline).map_or(baseline, |entry| &entry.label);
    let what = capital(&quantity(&data.ratios, data.scenes.iter().map(String::as_str), "time of the programs"));
    Sketch {
        name: "time-ratios",
        title: format!("{what} against {name}"),
        caption: format!(
            "{what}, over that of {name} (default policy); left of 1 is faster. Whiskers are 95 % intervals over binaries, or over the \
             launches of a single one, of query times over clusters of poses too; the grey band is [0.95, 1.05], within which two methods are called \
             the same. Lines with a policy (split rule, split axes, leaf size) are trees other than the variant's default. The \
             null line is a second copy of one method against its original: it must lie on 1, or the run was noisy. Unsafe \
             variants are shown, never ranked. Ratios above {RATIO_MAX} are written at the edge."
        ),
        drawing: Forest::of(data, baseline),
    }
}

impl Forest {
    fn of(data: &Data, baseline: &str) -> Result<Self, &'static str> {
        let mut lines: Vec<Line> = Vec::new();
        for (s, scene) in data.scenes.iter().enumerate() {
            let Some(workload) = ranked_by(&data.ratios, scene) else { continue };
            let rows = data
                .ratios
                .iter()
                .filter(|r| r.scene == *scene && r.workload == workload && r.stratum == ALL && is_query_time(r));
            let wanted = rows.filter(|r| {
                r.variant == NULL_VARIANT
                    || (r.baseline == baseline && data.cases.is_default(&r.baseline, &r.baseline_policy))
            });
            for row in wanted {
                let (label, look) = describe(data, &row.variant, &row.policy);
                let (low, high) = row.interval().unwrap_or((f64::NAN, f64::NAN));
                let bar = Bar { ratio: row.ratio, low, high };
                if !lines.iter().any(|line| line.label == label) {
                    lines.push(Line { label: label.clone(), look, bars: vec![None; data.scenes.len()] });
                }
                if let Some(line) = lines.iter_mut().find(|line| line.label == label) {
                    line.bars[s] = Some(bar);
                }
            }
        }
        if lines.is_empty() {
            return Err(data.reason("ratios.csv holds no ratio of times to the first baseline"));
        }
        Ok(Self::sorted(data.scenes.clone(), lines, RATIO_MAX))
    }

    /// Sorts the lines by ratio, fastest first.
    fn sorted(panels: Vec<String>, mut lines: Vec<Line>, most: f64) -> Self {
        let centre = |line: &Line| mean(&line.bars.iter().flatten().map(|bar| bar.ratio.ln()).collect::<Vec<_>>());
        lines.sort_by(|a, b| centre(a).total_cmp(&centre(b)).then_with(|| a.label.cmp(&b.label)));
        Self { panels, lines, most }
    }
}

/// Whole engines against their reference, with one panel per scene and mode; `None` when the run has no engines.
pub(super) fn engines(data: &Data) -> Option<Sketch<Forest>> {
    let reference = &data.peer_ratios.first()?.reference;
    let (mut panels, mut lines): (Vec<String>, Vec<Line>) = (Vec::new(), Vec::new());
    for row in data.peer_ratios.iter().filter(|row| row.stratum == ALL) {
        let panel = format!("{}, {}", row.scene, row.mode);
        let p = panels.iter().position(|known| *known == panel).unwrap_or_else(|| {
            panels.push(panel);
            panels.len() - 1
        });
        let l = lines.iter().position(|line| line.label == row.engine).unwrap_or_else(|| {
            lines.push(Line { label: row.engine.clone(), look: Look::nth(lines.len()), bars: Vec::new() });
            lines.len() - 1
        });
        let bars = &mut lines[l].bars;
        bars.resize(panels.len(), None);
        // The rows say how many times faster; the figure, like the other one, how much of the time is left.
        bars[p] = Some(Bar { ratio: 1.0 / row.ratio, low: 1.0 / row.high, high: 1.0 / row.low });
    }
    lines.iter_mut().for_each(|line| line.bars.resize(panels.len(), None));
    Some(Sketch {
        name: "engines",
        title: "Whole engines: query time against a reference".to_owned(),
        caption: format!(
            "Mean time of a query over that of {reference} (in modes it does not know, over the reference that peer-ratios.csv names), on the same poses, in turn on one thread; left of 1 is faster. Whiskers are 95 % bootstrap intervals over chunks of poses. Missed and false contacts stand in the report's table."
        ),
        drawing: Ok(Forest::sorted(panels, lines, f64::INFINITY)),
    })
}

fn describe(data: &Data, variant: &str, policy: &str) -> (String, Look) {
    let Some(entry) = data.variant(variant) else {
        let label = if variant == NULL_VARIANT { "null (against its original)" } else { variant };
        return (label.to_owned(), Look::nth(data.variants.len()));
    };
    let label =
        if data.cases.is_default(variant, policy) { entry.label.clone() } else { format!("{}, {policy}", entry.label) };
    (label, entry.look)
}

impl Drawing for Forest {
    fn size(&self) -> (u32, u32) {
        let height = HEADER_PX + FOOTER_PX + self.lines.len() as u32 * LINE_PX as u32;
        (LABELS_PX + self.panels.len() as u32 * PANEL_PX_WIDE, height)
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let (names, panels) = area.split_horizontally(LABELS_PX);
        let middle = |i: usize| HEADER_PX as i32 + i as i32 * LINE_PX + LINE_PX / 2;
        for (i, line) in self.lines.iter().enumerate() {
            line.look.mark(&names, (22, middle(i) - TEXT_LIFT_PX))?;
            label(&names, &line.label, TEXT_PX, (42, middle(i)), HPos::Left)?;
        }
        for (s, panel) in panels.split_evenly((1, self.panels.len())).iter().enumerate() {
            self.panel(panel, s, self.range(), &middle)?;
        }
        Ok(())
    }
}

impl Forest {
    /// The ends of the axis, around every mark that is on it; a single launch has ratios without intervals.
    fn range(&self) -> (f64, f64) {
        let bars = self.lines.iter().flat_map(|line| line.bars.iter().flatten()).filter(|bar| bar.ratio <= self.most);
        Scale::Log.range(bars.flat_map(|bar| [bar.ratio, bar.low, bar.high, 0.9, 1.1]))
    }

    fn panel(
        &self,
        area: &Area<'_>,
        scene: usize,
        (low, high): (f64, f64),
        middle: &impl Fn(usize) -> i32,
    ) -> DrawResult {
        label(area, &self.panels[scene], PANEL_PX, (PANEL_PX_WIDE as i32 / 2, 22), HPos::Center)?;
        let height = self.lines.len() as i32 * LINE_PX;
        let mut chart = ChartBuilder::on(area)
            .margin_left(14)
            .margin_right(20)
            .margin_top(HEADER_PX)
            .margin_bottom(8)
            .x_label_area_size(FOOTER_PX - 8)
            .build_cartesian_2d(
                Axis { ends: (low, high), ticks: Scale::Log.ticks(low, high) },
                Axis { ends: (0.0, f64::from(height)), ticks: Vec::new() },
            )?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .disable_y_axis()
            .bold_line_style(BLACK.mix(0.15))
            .light_line_style(TRANSPARENT)
            .label_style(text(TEXT_PX))
            .axis_desc_style(text(TEXT_PX))
            .x_labels(50)
            .x_label_formatter(&|x| Scale::Log.tick_label(*x))
            .x_desc("time ratio")
            .draw()?;
        let left = area.get_base_pixel().0;
        let x = |ratio: f64| chart.backend_coord(&(Scale::Log.coordinate(ratio), 0.0)).0 - left;
        let (top, bottom) = (HEADER_PX as i32, HEADER_PX as i32 + height);
        area.draw(&Rectangle::new([(x(0.95), top), (x(1.05), bottom)], BLACK.mix(0.12).filled()))?;
        area.draw(&PathElement::new(vec![(x(1.0), top), (x(1.0), bottom)], BLACK.stroke_width(2)))?;
        for (i, line) in self.lines.iter().enumerate() {
            let Some(bar) = line.bars[scene] else { continue };
            let (stroke, y) = (line.look.colour.stroke_width(2), middle(i));
            if bar.ratio > self.most {
                let edge = x(Scale::Log.value(high));
                line.look.mark(area, (edge - 10, y))?;
                label(area, &format!("{:.0}×", bar.ratio), TEXT_PX, (edge - 26, y), HPos::Right)?;
                continue;
            }
            if bar.low.is_finite() && bar.high.is_finite() {
                let (from, to) = (x(bar.low), x(bar.high));
                area.draw(&PathElement::new(vec![(from, y), (to, y)], stroke))?;
                for end in [from, to] {
                    area.draw(&PathElement::new(vec![(end, y - 9), (end, y + 9)], stroke))?;
                }
            }
            line.look.mark(area, (x(bar.ratio), y))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_without_intervals_are_on_the_axis() {
        let bar = |ratio| Some(Bar { ratio, low: f64::NAN, high: f64::NAN });
        let line = Line { label: String::new(), look: Look::nth(0), bars: vec![bar(0.05), bar(3.0), bar(500.0)] };
        let (low, high) = Forest { panels: Vec::new(), lines: vec![line], most: RATIO_MAX }.range();
        let at = |ratio| Scale::Log.coordinate(ratio);
        assert!(low < at(0.05) && at(3.0) < high && high < at(500.0), "{low} {high}");
    }
}
