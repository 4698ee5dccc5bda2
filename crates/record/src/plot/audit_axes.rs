//! Figure of the axis at which the separating-axis test of two boxes ends.

use super::Sketch;
use super::canvas::{Area, DrawResult, Drawing, PANEL_PX, TEXT_PX};
use super::marks::{Look, label};
use crate::record::ExitRow;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

const WIDTH: i32 = 1300;
const PANEL_HEIGHT: i32 = 380;
const LEFT_PX: i32 = 90;
const TOP_PX: i32 = 50;
const BOTTOM_PX: i32 = 60;

/// A panel of bars for each scene: share of volume tests by the axis that ends them.
#[derive(Clone, Debug)]
pub struct ExitAxes {
    panels: Vec<(String, Vec<(u8, f64)>)>,
}

pub(super) fn sketch(rows: &[ExitRow]) -> Sketch<ExitAxes> {
    let mut panels: Vec<(String, Vec<(u8, f64)>)> = Vec::new();
    for row in rows {
        if !panels.iter().any(|(scene, _)| *scene == row.scene) {
            panels.push((row.scene.clone(), Vec::new()));
        }
        let Some((_, bars)) = panels.iter_mut().find(|(scene, _)| *scene == row.scene) else { continue };
        match bars.iter_mut().find(|(axis, _)| *axis == row.axis) {
            Some((_, tests)) => *tests += row.tests as f64,
            None => bars.push((row.axis, row.tests as f64)),
        }
    }
    for (_, bars) in &mut panels {
        let total: f64 = bars.iter().map(|(_, tests)| tests).sum();
        bars.iter_mut().for_each(|(_, tests)| *tests /= total);
    }
    Sketch {
        name: "audit-exit-axes",
        title: "Which axis ends the separating-axis test".to_owned(),
        caption: "Share of the volume tests of the reference cell that each axis ends, in the order of the test: 1 to 3 the first box's \
                  normals, 4 to 6 the second's, 7 to 15 products of edges; the last bar are pairs that no axis separates."
            .to_owned(),
        drawing: if panels.is_empty() {
            Err("exits.csv holds no rows; let the audit finish first")
        } else {
            Ok(ExitAxes { panels })
        },
    }
}

impl Drawing for ExitAxes {
    fn size(&self) -> (u32, u32) {
        (WIDTH as u32, (self.panels.len() as i32 * PANEL_HEIGHT) as u32)
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        for ((scene, bars), place) in self.panels.iter().zip(area.split_evenly((self.panels.len(), 1))) {
            label(&place, scene, PANEL_PX, (WIDTH / 2, 22), HPos::Center)?;
            let slot = (WIDTH - LEFT_PX - 20) / bars.len() as i32;
            let bottom = PANEL_HEIGHT - BOTTOM_PX;
            let largest = bars.iter().map(|(_, share)| *share).fold(0.0, f64::max);
            for (i, &(axis, share)) in bars.iter().enumerate() {
                let (x, height) =
                    (LEFT_PX + i as i32 * slot, (share / largest * f64::from(bottom - TOP_PX - 24)) as i32);
                let kind = if axis == 0 { 3 } else { usize::from(axis > 3) + usize::from(axis > 6) };
                let colour = Look::nth(kind).colour;
                let bar = [(x + 6, bottom - height), (x + slot - 6, bottom)];
                place.draw(&Rectangle::new(bar, colour.mix(0.8).filled()))?;
                let words = format!("{:.1} %", 100.0 * share);
                label(&place, &words, 18, (x + slot / 2, bottom - height - 12), HPos::Center)?;
                let name = if axis == 0 { "none".to_owned() } else { axis.to_string() };
                label(&place, &name, TEXT_PX, (x + slot / 2, bottom + 20), HPos::Center)?;
            }
            place.draw(&PathElement::new(vec![(LEFT_PX, bottom), (WIDTH - 20, bottom)], BLACK.stroke_width(2)))?;
        }
        Ok(())
    }
}
