//! Figure of the effect of a box's centre on containment: how much of their contents the boxes of an audit leave out, and how many contacts
//! they miss.

use super::Sketch;
use super::canvas::{Area, DrawResult, Drawing, PANEL_PX, TEXT_PX};
use super::marks::label;
use crate::analysis::{ALL, distinct};
use crate::record::AuditCellRow;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

const CELL: (i32, i32) = (190, 64);
const NAMES_PX: i32 = 170;
const TOP_PX: i32 = 100;
const GAP_PX: i32 = 60;

/// A table of shaded numbers for each measure, with orientations as rows and centres as columns.
#[derive(Clone, Debug)]
pub struct Containment {
    orientations: Vec<String>,
    centres: Vec<String>,
    /// Title, unit, and values in the order of orientations.
    tables: [(&'static str, &'static str, Vec<f64>); 3],
}

pub(super) fn sketch(cells: &[AuditCellRow]) -> Sketch<Containment> {
    let scenes_together = cells.iter().any(|row| row.scene == ALL);
    let rows: Vec<&AuditCellRow> = cells.iter().filter(|row| !scenes_together || row.scene == ALL).collect();
    let orientations = distinct(rows.iter().map(|row| row.orientation.clone()));
    let centres = distinct(rows.iter().map(|row| row.centre.clone()));
    let over = |value: &dyn Fn(&[&AuditCellRow]) -> f64| -> Vec<f64> {
        let of = |orientation: &String, centre: &String| {
            let members: Vec<&AuditCellRow> =
                rows.iter().filter(|r| r.orientation == *orientation && r.centre == *centre).copied().collect();
            value(&members)
        };
        orientations.iter().flat_map(|o| centres.iter().map(|c| of(o, c)).collect::<Vec<_>>()).collect()
    };
    let mean = |rows: &[&AuditCellRow], value: &dyn Fn(&AuditCellRow) -> f64| {
        rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64
    };
    let tables = [
        ("corners outside their boxes", "%", over(&|rows| mean(rows, &|row| row.outside_corners_pct))),
        (
            "contacts missed",
            "%",
            over(&|rows| {
                let sum = |f: &dyn Fn(&AuditCellRow) -> u64| rows.iter().map(|row| f(row)).sum::<u64>() as f64;
                100.0 * sum(&|row| row.missed) / sum(&|row| row.touching)
            }),
        ),
        ("farthest corner outside", "mm", over(&|rows| rows.iter().map(|row| row.overhang_mm).fold(0.0, f64::max))),
    ];
    Sketch {
        name: "audit-containment",
        title: "What the boxes leave out, by orientation and centre".to_owned(),
        caption: "Over all split rules, leaf sizes, scenes and parts: corners that lie outside the box of a node that holds them (every \
                  corner counted on each level of the tree), contacts that a query does not report, and the largest distance of a \
                  corner from its box. The darker, the worse. Mean: centre at the mean of the corners; weighted mean: at the area-weighted mean; both with \
                  half the extent to each side, as the paper's text has it."
            .to_owned(),
        drawing: if rows.is_empty() {
            Err("audit_cells.csv holds no rows; analyse the audit first")
        } else {
            Ok(Containment { orientations, centres, tables })
        },
    }
}

impl Containment {
    fn table_width(&self) -> i32 {
        self.centres.len() as i32 * CELL.0
    }
}

impl Drawing for Containment {
    fn size(&self) -> (u32, u32) {
        let width = NAMES_PX + self.tables.len() as i32 * (self.table_width() + GAP_PX);
        (width as u32, (TOP_PX + self.orientations.len() as i32 * CELL.1 + 30) as u32)
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        for (o, name) in self.orientations.iter().enumerate() {
            label(area, name, TEXT_PX, (NAMES_PX - 14, TOP_PX + o as i32 * CELL.1 + CELL.1 / 2), HPos::Right)?;
        }
        let mut left = NAMES_PX;
        for (title, unit, values) in &self.tables {
            label(area, &format!("{title}, {unit}"), PANEL_PX, (left + self.table_width() / 2, 26), HPos::Center)?;
            let largest = values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
            for (c, centre) in self.centres.iter().enumerate() {
                label(area, centre, TEXT_PX, (left + c as i32 * CELL.0 + CELL.0 / 2, 70), HPos::Center)?;
            }
            for (i, &value) in values.iter().enumerate() {
                let (o, c) = (i / self.centres.len(), i % self.centres.len());
                let (x, y) = (left + c as i32 * CELL.0, TOP_PX + o as i32 * CELL.1);
                let depth = if largest > 0.0 && value > 0.0 { value / largest } else { 0.0 };
                let place = [(x + 2, y + 2), (x + CELL.0 - 2, y + CELL.1 - 2)];
                area.draw(&Rectangle::new(place, RGBColor(213, 94, 0).mix(0.75 * depth).filled()))?;
                area.draw(&Rectangle::new(place, BLACK.mix(0.3)))?;
                let words = if value == 0.0 { "0".to_owned() } else { format!("{value:.2}") };
                label(area, &words, TEXT_PX, (x + CELL.0 / 2, y + CELL.1 / 2), HPos::Center)?;
            }
            left += self.table_width() + GAP_PX;
        }
        Ok(())
    }
}
