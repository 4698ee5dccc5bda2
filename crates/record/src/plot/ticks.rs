//! Axes: a scale maps values to coordinates and chooses its ticks. A logarithmic axis is a linear axis of logarithms with ticks at round
//! values.

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use std::ops::Range;

/// A linear axis with ticks at given coordinates; the library's own decorator for that has no labels.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Coordinates of the ends.
    pub ends: (f64, f64),
    /// Coordinates of the ticks.
    pub ticks: Vec<f64>,
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let length = self.ends.1 - self.ends.0;
        let share = if length > 0.0 { ((value - self.ends.0) / length).clamp(-10.0, 10.0) } else { 0.5 };
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.ends.0..self.ends.1
    }
}

/// How values are laid along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By their logarithm.
    Log,
}

/// Largest number of ticks.
const TICKS_MAX: usize = 9;

impl Scale {
    /// The coordinate of a value; -∞ for a value that is not positive on a logarithmic axis.
    pub fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log if value > 0.0 => value.log10(),
            Self::Log => f64::NEG_INFINITY,
        }
    }

    /// The value at a coordinate.
    pub fn value(self, coordinate: f64) -> f64 {
        match self {
            Self::Linear => coordinate,
            Self::Log => 10_f64.powf(coordinate),
        }
    }

    /// Coordinates of the ends of an axis that contains all values with some margin; linear axes begin at 0.
    pub fn range(self, values: impl Iterator<Item = f64>) -> (f64, f64) {
        let coordinates = values.map(|value| self.coordinate(value)).filter(|c| c.is_finite());
        let (low, high) = coordinates.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
        match self {
            _ if low > high => (0.0, 1.0),
            Self::Linear => (low.min(0.0), if high > 0.0 { high * 1.08 } else { 1.0 }),
            Self::Log => {
                let room = ((high - low) * 0.06).max(0.03);
                (low - room, high + room)
            }
        }
    }

    /// Coordinates of the ticks between two coordinates.
    pub fn ticks(self, low: f64, high: f64) -> Vec<f64> {
        match self {
            Self::Linear => {
                let step = nice_step((high - low) / 6.0);
                let first = (low / step).ceil() as i64;
                (first..).map(|i| i as f64 * step).take_while(|c| *c <= high).collect()
            }
            Self::Log => {
                let mantissas: [&[f64]; 4] = [
                    &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
                    &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
                    &[1.0, 2.0, 5.0],
                    &[1.0],
                ];
                let decades = low.floor() as i32..=high.ceil() as i32;
                let of = |mantissas: &[f64]| -> Vec<f64> {
                    let values = decades.clone().flat_map(|d| mantissas.iter().map(move |m| m.log10() + f64::from(d)));
                    values.filter(|c| low <= *c && *c <= high).collect()
                };
                let finest_that_fits = mantissas.iter().map(|m| of(m)).find(|ticks| ticks.len() <= TICKS_MAX);
                finest_that_fits.unwrap_or_else(|| {
                    let all = of(&[1.0]);
                    let every = all.len().div_ceil(TICKS_MAX);
                    all.into_iter().step_by(every).collect()
                })
            }
        }
    }

    /// The text of a tick.
    pub fn tick_label(self, coordinate: f64) -> String {
        number(self.value(coordinate))
    }
}

/// 1, 2 or 5 times a power of ten, at least `least`.
fn nice_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.max(f64::MIN_POSITIVE).log10().floor());
    [1.0, 2.0, 5.0].map(|m| m * power).into_iter().find(|step| *step >= least).unwrap_or(10.0 * power)
}

/// Letters for thousands, millions and thousand millions.
const LETTERS: [(f64, &str); 3] = [(1e9, "G"), (1e6, "M"), (1e3, "k")];

/// A number without needless digits: 0.001, 0.8, 12, 5k, 2M; the page formats numbers in the same way.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && magnitude < 1e-4 {
        return format!("{value:.0e}");
    }
    let (unit, letter) = LETTERS.into_iter().find(|(unit, _)| magnitude >= 0.9999 * unit).unwrap_or((1.0, ""));
    let text = format!("{:.5}", value / unit);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    // Rounded to the four digits a tick can need.
    let text = if magnitude / unit >= 100.0 { format!("{:.0}", value / unit) } else { text.to_owned() };
    text + letter
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_without_needless_digits() {
        let shown = [0.0, 0.001, 0.8, 1.0, 12.0, 500.0, 5000.0, 1e5, 2e6, 3e-5].map(number);
        assert_eq!(shown, ["0", "0.001", "0.8", "1", "12", "500", "5k", "100k", "2M", "3e-5"]);
    }

    #[test]
    fn ticks_are_round_and_few() {
        let labels = |scale: Scale, low, high| {
            let (low, high) = (scale.coordinate(low), scale.coordinate(high));
            scale.ticks(low, high).into_iter().map(|c| scale.tick_label(c)).collect::<Vec<_>>()
        };
        assert_eq!(labels(Scale::Log, 0.9, 11.0), ["1", "1.5", "2", "3", "5", "7", "10"]);
        assert_eq!(labels(Scale::Log, 0.5, 2000.0).first().map(String::as_str), Some("1"));
        assert!(labels(Scale::Log, 1e-12, 1e12).len() <= TICKS_MAX);
        assert_eq!(labels(Scale::Linear, 0.0, 6.0), ["0", "1", "2", "3", "4", "5", "6"]);
    }
}
