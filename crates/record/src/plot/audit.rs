//! The results of an audit in one figure: for each response, the share of every factor and pair of factors in the variance between cells,
//! and the effect of every level.

use super::canvas::{Area, DrawResult, Drawing, PANEL_PX, TEXT_PX};
use super::marks::{Look, label};
use super::ticks::Scale;
use super::{FOLDER, Gallery, Sketch, add, write_index};
use crate::analysis::audit::{RESPONSES, SAFE};
use crate::analysis::{ALL, AnalysisError};
use crate::record::audit::FACTORS;
use crate::record::{AuditCellRow, AuditEffectRow, AuditShareRow, ExitRow, read_rows, read_rows_if_there};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;
use std::path::Path;

/// Height of the row of one response, px; then its top and bottom margins, px.
const ROW_PX: i32 = 420;
const TOP_PX: i32 = 86;
const BOTTOM_PX: i32 = 66;
/// Width of the bars of shares with their names, px; then the widths of the names and of the axis, px.
const SHARES_PX: i32 = 620;
const NAMES_PX: i32 = 250;
const AXIS_PX: i32 = 110;
/// Width of a level, px; then the space between factors, px.
const LEVEL_PX: i32 = 98;
const GAP_PX: i32 = 30;
/// Text size of levels and shares, px.
const SMALL_PX: u32 = 18;

/// A response's row of the figure.
#[derive(Clone, Debug)]
struct Response {
    title: &'static str,
    shares: Vec<AuditShareRow>,
    /// For each factor, the effects of its levels.
    effects: Vec<Vec<AuditEffectRow>>,
}

/// Shares and effects, with one row for each response.
#[derive(Clone, Debug)]
pub struct Factors {
    responses: Vec<Response>,
}

/// The title of a response.
fn title_of(response: &str) -> &'static str {
    match response {
        "volume-tests" => "volume tests of a query",
        "triangle-tests" => "1 + triangle tests of a query",
        "time" => "query time",
        "build" => "time to build the trees",
        _ => "surface area of all boxes",
    }
}

/// Draws an audit's figures into `plots/` of its folder and lists them there.
///
/// # Errors
/// When a record is missing or malformed, or a figure cannot be written.
pub fn draw_audit(folder: &Path) -> Result<Gallery, AnalysisError> {
    let (effects, shares): (Vec<AuditEffectRow>, Vec<AuditShareRow>) = (read_rows(folder)?, read_rows(folder)?);
    let cells: Vec<AuditCellRow> = read_rows(folder)?;
    let mut gallery = Gallery::default();
    add(folder, &mut gallery, factors(SAFE, "audit-factors", &effects, &shares))?;
    if let Some(centre) = best_centre(&effects) {
        add(folder, &mut gallery, factors(&centre, "audit-best-centre", &effects, &shares))?;
    }
    add(folder, &mut gallery, super::audit_containment::sketch(&cells))?;
    let axes: Vec<ExitRow> = read_rows_if_there(folder)?;
    add(folder, &mut gallery, super::audit_axes::sketch(&axes))?;
    write_index(&folder.join(FOLDER), &gallery)?;
    Ok(gallery)
}

/// The safe centre rule with the fewest volume tests, when there are several.
fn best_centre(effects: &[AuditEffectRow]) -> Option<String> {
    let rows = effects.iter().filter(|row| row.cells == SAFE && row.response == RESPONSES[0] && row.term == FACTORS[1]);
    let rows: Vec<&AuditEffectRow> = rows.collect();
    let together = rows.iter().any(|row| row.scene == ALL);
    let candidates: Vec<_> = rows.into_iter().filter(|row| !together || row.scene == ALL).collect();
    let best = candidates.iter().min_by(|a, b| a.effect.total_cmp(&b.effect))?;
    (candidates.len() > 1).then(|| best.level.clone())
}

/// The figure over a set of cells: the safe cells, or those of one centre.
fn factors(cells: &str, name: &'static str, effects: &[AuditEffectRow], shares: &[AuditShareRow]) -> Sketch<Factors> {
    // A factor with one level explains nothing, and its terms would be empty lines.
    let is_centre = |term: &str| term.split(':').any(|factor| factor == FACTORS[1]);
    let varies = |term: &str| cells == SAFE || !is_centre(term);
    let together = |scene: &str| if shares.iter().any(|row| row.scene == ALL) { scene == ALL } else { true };
    let responses = RESPONSES.iter().filter_map(|response| {
        let shares: Vec<AuditShareRow> = shares
            .iter()
            .filter(|row| row.cells == cells && row.response == *response && together(&row.scene))
            .filter(|row| varies(&row.term))
            .cloned()
            .collect();
        let of_factor = |factor: &str| {
            let rows = effects.iter().filter(|row| row.cells == cells && row.response == *response);
            rows.filter(|row| row.term == factor && together(&row.scene)).cloned().collect()
        };
        let effects = FACTORS.iter().filter(|factor| varies(factor)).map(|factor| of_factor(factor)).collect();
        (!shares.is_empty()).then(|| Response { title: title_of(response), shares, effects })
    });
    let responses: Vec<Response> = responses.collect();
    let which = match cells {
        SAFE => "all cells whose boxes contain everything".to_owned(),
        centre => format!("the cells of the centre {centre}"),
    };
    Sketch {
        name,
        title: format!("What makes a box tree good: shares of variance, and what each level does ({which})"),
        caption: format!(
            "A full crossing of orientation, centre, split rule and leaf size; over {which}. Left: \
                  how much of the variance of the log response between cells each factor, each pair of factors beyond the \
                  sum of the two, and the rest explain. Right: the effect of each level as a factor on the geometric mean over \
                  all cells; below 1 is less work. One vertical axis per row, so that the factor with the tallest spread matters \
                  most. Whiskers are 95 % bootstrap intervals over chunks of poses and scenes."
        ),
        drawing: if responses.is_empty() {
            Err("audit_shares.csv holds no shares of safe cells; analyse the audit first")
        } else {
            Ok(Factors { responses })
        },
    }
}

impl Factors {
    fn levels_width(&self) -> i32 {
        let widths = self.responses[0].effects.iter().map(|levels| levels.len() as i32 * LEVEL_PX + GAP_PX);
        widths.sum()
    }
}

impl Drawing for Factors {
    fn size(&self) -> (u32, u32) {
        ((SHARES_PX + AXIS_PX + self.levels_width() + GAP_PX) as u32, (self.responses.len() as i32 * ROW_PX) as u32)
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        for (row, place) in self.responses.iter().zip(area.split_evenly((self.responses.len(), 1))) {
            label(&place, row.title, PANEL_PX, (16, 24), HPos::Left)?;
            row.draw_shares(&place)?;
            row.draw_effects(&place)?;
        }
        Ok(())
    }
}

impl Response {
    fn draw_shares(&self, area: &Area<'_>) -> DrawResult {
        let line = (ROW_PX - TOP_PX - 16) / self.shares.len() as i32;
        let full = f64::from(SHARES_PX - NAMES_PX - 110);
        for (i, row) in self.shares.iter().enumerate() {
            let y = TOP_PX - 14 + i as i32 * line + line / 2;
            let x = |share: f64| NAMES_PX + 10 + (full * share) as i32;
            let is_main = FACTORS.contains(&row.term.as_str());
            let colour = if is_main { look_of(&row.term).colour } else { RGBColor(150, 150, 150) };
            label(area, &row.term.replace(':', " × "), SMALL_PX, (NAMES_PX, y), HPos::Right)?;
            area.draw(&Rectangle::new([(x(0.0), y - line / 3), (x(row.share), y + line / 3)], colour.filled()))?;
            if row.low.is_finite() {
                area.draw(&PathElement::new(vec![(x(row.low), y), (x(row.high), y)], BLACK.stroke_width(2)))?;
            }
            let words = format!("{:.1} %", 100.0 * row.share);
            label(area, &words, SMALL_PX, (x(row.high.max(row.share)) + 10, y), HPos::Left)?;
        }
        Ok(())
    }

    fn draw_effects(&self, area: &Area<'_>) -> DrawResult {
        let values = self.effects.iter().flatten().flat_map(|row| [row.effect, row.low, row.high, 0.9, 1.1]);
        let (low, high) = Scale::Log.range(values);
        let (top, bottom) = (TOP_PX, ROW_PX - BOTTOM_PX);
        let y = |effect: f64| {
            let share = (Scale::Log.coordinate(effect) - low) / (high - low);
            bottom - (share * f64::from(bottom - top)).round() as i32
        };
        let left = SHARES_PX + AXIS_PX;
        let right =
            left + self.effects.iter().map(|levels| levels.len() as i32 * LEVEL_PX + GAP_PX).sum::<i32>() - GAP_PX;
        for tick in Scale::Log.ticks(low, high) {
            let at = y(Scale::Log.value(tick));
            area.draw(&PathElement::new(vec![(left, at), (right, at)], BLACK.mix(0.15)))?;
            label(area, &format!("×{}", Scale::Log.tick_label(tick)), SMALL_PX, (left - 10, at), HPos::Right)?;
        }
        area.draw(&PathElement::new(vec![(left, y(1.0)), (right, y(1.0))], BLACK.stroke_width(2)))?;
        let mut x = left;
        for levels in &self.effects {
            let factor = levels.first().map_or("", |row| row.term.as_str());
            let look = look_of(factor);
            let width = levels.len() as i32 * LEVEL_PX;
            label(area, factor, TEXT_PX, (x + width / 2, top - 22), HPos::Center)?;
            area.draw(&Rectangle::new([(x, top), (x + width, bottom)], BLACK.mix(0.25)))?;
            let mut path = Vec::new();
            for (i, row) in levels.iter().enumerate() {
                let middle = x + i as i32 * LEVEL_PX + LEVEL_PX / 2;
                if row.low.is_finite() {
                    look.whisker(area, middle, y(row.low), y(row.high))?;
                }
                look.mark(area, (middle, y(row.effect)))?;
                path.push((middle, y(row.effect)));
                for (line, words) in in_two_lines(&row.level).into_iter().enumerate() {
                    label(area, words, SMALL_PX, (middle, bottom + 18 + 21 * line as i32), HPos::Center)?;
                }
            }
            area.draw(&PathElement::new(path, look.colour.stroke_width(2)))?;
            x += width + GAP_PX;
        }
        Ok(())
    }
}

/// The look of a factor, the same in all figures.
fn look_of(factor: &str) -> Look {
    Look::nth(FACTORS.iter().position(|name| *name == factor).unwrap_or(FACTORS.len()))
}

/// A name split after its hyphen, if it has one.
fn in_two_lines(name: &str) -> Vec<&str> {
    match name.find('-') {
        Some(hyphen) => vec![&name[..=hyphen], &name[hyphen + 1..]],
        None => vec![name],
    }
}
