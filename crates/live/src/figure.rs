//! The figure of `latency`: from a sample to its verdict, per variant, on a logarithmic scale.

use crate::latency::LatencyRow;
use bvbench::plot::canvas::{Area, DrawResult, Drawing, TEXT_PX, text};
use plotters::prelude::*;

const SIZE: (u32, u32) = (1400, 640);
const MARGINS: [i32; 4] = [96, 24, 56, 150];
/// Cycle whose rows are drawn, ns.
const CYCLE_NS: u64 = 4_000_000;
/// Lowest and highest decade, ns.
const DECADES: [i32; 2] = [3, 11];
const LABELS: [&str; 9] = ["1 µs", "10 µs", "100 µs", "1 ms", "10 ms", "100 ms", "1 s", "10 s", "100 s"];
const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(0, 158, 115), RGBColor(230, 159, 0), RGBColor(213, 94, 0)];
const NAMES: [&str; 4] = ["p50", "p99", "p99.9", "max"];

/// Where a time stands between the lowest decade (0) and the highest (1).
fn share(ns: f64) -> f64 {
    let share = (ns.max(1.0).log10() - f64::from(DECADES[0])) / f64::from(DECADES[1] - DECADES[0]);
    share.clamp(0.0, 1.0)
}

/// Panels side by side: the judge alone and the network, idle and busy.
#[derive(Clone, Copy, Debug)]
pub struct Figure<'a>(pub &'a [LatencyRow]);

impl Figure<'_> {
    fn panel(&self, way: &str, load: &str) -> Vec<&LatencyRow> {
        let is_drawn =
            |row: &&LatencyRow| row.way == way && row.load == load && row.cache == "warm" && row.cycle_ns == CYCLE_NS;
        self.0.iter().filter(is_drawn).collect()
    }
}

impl Drawing for Figure<'_> {
    fn size(&self) -> (u32, u32) {
        SIZE
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let panels = [("judge", "idle"), ("judge", "busy"), ("network", "idle"), ("network", "busy")];
        let [left, right, top, bottom] = MARGINS;
        let width = (SIZE.0 as i32 - left - right) / panels.len() as i32;
        let (low, high) = (SIZE.1 as i32 - bottom, top);
        let y = |ns: f64| low - (share(ns) * f64::from(low - high)) as i32;
        for decade in DECADES[0]..=DECADES[1] {
            let at = y(10f64.powi(decade));
            area.draw(&PathElement::new(vec![(left, at), (SIZE.0 as i32 - right, at)], RGBColor(220, 220, 220)))?;
            area.draw(&Text::new(LABELS[(decade - DECADES[0]) as usize], (8, at - 10), text(TEXT_PX - 3)))?;
        }
        for (index, (way, load)) in panels.into_iter().enumerate() {
            let begin = left + width * index as i32;
            area.draw(&Text::new(format!("{way}, {load}"), (begin + 12, 16), text(TEXT_PX)))?;
            area.draw(&PathElement::new(vec![(begin, low), (begin, high)], RGBColor(180, 180, 180)))?;
            let rows = self.panel(way, load);
            for (place, row) in rows.iter().enumerate() {
                let x = begin + width * (2 * place as i32 + 1) / (2 * rows.len() as i32);
                let values = [row.p50_ns, row.p99_ns, row.p999_ns, row.max_ns].map(|ns| y(ns as f64));
                area.draw(&PathElement::new(vec![(x, values[0]), (x, values[3])], RGBColor(150, 150, 150)))?;
                for (at, colour) in values.into_iter().zip(COLOURS) {
                    area.draw(&Circle::new((x, at), 6, colour.filled()))?;
                }
                let style = text(TEXT_PX - 5).transform(FontTransform::Rotate90);
                area.draw(&Text::new(row.variant.clone(), (x + 8, low + 10), style))?;
            }
        }
        for (index, (name, colour)) in NAMES.into_iter().zip(COLOURS).enumerate() {
            let x = SIZE.0 as i32 - 420 + 105 * index as i32;
            area.draw(&Circle::new((x, SIZE.1 as i32 - 16), 6, colour.filled()))?;
            area.draw(&Text::new(name, (x + 12, SIZE.1 as i32 - 28), text(TEXT_PX - 3)))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_stand_apart() {
        let [one, thirteen, hundred] = [1e9, 13e9, 1e11].map(share);
        assert!(0.7 < one && one < thirteen && thirteen < hundred && hundred == 1.0, "{one} {thirteen} {hundred}");
        assert_eq!(LABELS.len() as i32, DECADES[1] - DECADES[0] + 1);
    }
}
