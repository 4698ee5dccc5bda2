//! Results of an ablation: tests of each form, split by colliding and free poses, its time, and the sweeps of its parameters.

use super::data::Entry;
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::marks::Look;
use super::ticks::{Scale, number};
use super::{FOLDER, Gallery, Sketch, add, write_index};
use crate::analysis::ablation::{self, Ablation, Counted, PARTS, Timed};
use crate::analysis::{AnalysisError, distinct};
use crate::record::Kind;
use std::path::Path;

/// Draws an ablation's figures into `plots/` of its folder and lists them there.
///
/// # Errors
/// When a record is missing or malformed, or a figure cannot be written.
pub fn draw_ablation(folder: &Path) -> Result<Gallery, AnalysisError> {
    let Ablation { rows, times, .. } = Ablation::read(folder)?;
    let mut gallery = Gallery::default();
    add(folder, &mut gallery, parts(&rows, &times))?;
    add(folder, &mut gallery, sweeps(&rows))?;
    add(folder, &mut gallery, sizes(&times))?;
    write_index(&folder.join(FOLDER), &gallery)?;
    Ok(gallery)
}

/// A form of the method that is drawn as a line or bar: search, second level, coherence.
type Key<'a> = (&'a str, &'a str, u8);

fn key(form: &ablation::Form) -> Key<'_> {
    (&form.search, &form.second_level, form.coherence)
}

fn label((search, level, coherence): Key) -> String {
    let level = if level == "none" { String::new() } else { format!(" + {level}") };
    format!("{search}{level}{}", if coherence == 1 { " + coherence" } else { "" })
}

fn entry(label: String, number: usize) -> Entry {
    Entry { id: label.clone(), label, look: Look::nth(number), safe: true, kind: Kind::Sampling }
}

/// Mean number of tests per pose, over colliding and free poses.
fn mean(rows: &[&Counted], part: fn(&Counted) -> u64) -> Option<Point> {
    let poses: u64 = rows.iter().map(|row| row.counts.poses).sum();
    // A logarithmic axis has no place for nothing.
    let total: u64 = rows.iter().map(|row| part(row)).sum();
    (poses > 0 && total > 0).then(|| Point::bare(total as f64 / poses as f64))
}

/// A function that reads a count from a row.
type Part = fn(&Counted) -> u64;

const MEASURES: [(&str, Part); 2] =
    [("box tests of a pose", Counted::box_tests), ("point tests of a pose", |row| row.counts.triangle_tests)];

/// The parts of the method in safe mode: one panel per kind of test and kind of pose, and one for time. Categories are surfaces.
fn parts(rows: &[Counted], times: &[Timed]) -> Sketch<Grouped> {
    let rows: Vec<&Counted> = rows.iter().filter(|row| row.form.sweep == PARTS && row.form.safe == 1).collect();
    let times: Vec<&Timed> = times.iter().filter(|row| row.form.sweep == PARTS && row.form.safe == 1).collect();
    let surfaces = distinct(rows.iter().map(|row| row.surface()));
    let keys = distinct(rows.iter().map(|row| key(&row.form)));
    let series = |point: &dyn Fn(Key, &str) -> Option<Point>| -> Vec<Series> {
        let of = |(number, &key): (usize, &Key)| Series {
            entry: entry(label(key), number),
            points: surfaces.iter().map(|surface| point(key, surface)).collect(),
        };
        keys.iter().enumerate().map(of).collect()
    };
    let panel = |title: String, measure: &'static str, series: Vec<Series>| Panel {
        title,
        measure,
        sorted_by: "",
        scale: Scale::Log,
        form: Form::Markers,
        reference: None,
        categories: surfaces.iter().map(|surface| (*surface).to_owned()).collect(),
        series,
    };
    let mut panels = Vec::new();
    for (measure, part) in MEASURES {
        for (hit, poses) in [(1, "poses that hit"), (0, "free poses")] {
            let point = |wanted: Key, surface: &str| {
                let of_it =
                    rows.iter().filter(|row| key(&row.form) == wanted && row.surface() == surface && row.hit() == hit);
                mean(&of_it.copied().collect::<Vec<_>>(), part)
            };
            panels.push(panel(format!("{measure}, {poses}"), measure, series(&point)));
        }
    }
    let time = |wanted: Key, surface: &str| {
        let of_it = times.iter().filter(|row| key(&row.form) == wanted && row.surface == surface);
        Point::spread(of_it.map(|row| row.ns as f64 / 1e3 / row.poses.max(1) as f64).collect())
    };
    panels.push(panel("time of a pose, all poses".to_owned(), "µs", series(&time)));
    Sketch {
        name: "ablation-parts",
        title: "What octree, second tool level and coherence save".to_owned(),
        caption: "Safe mode. Of a tree of volumes, volume and triangle tests. Whiskers on times span the rounds."
            .to_owned(),
        drawing: Grouped::of(panels, 2, "counts.csv holds no rows of the parts"),
    }
}

/// A function that reads a swept quantity from a row.
type Quantity = fn(&Counted) -> f64;

/// The swept quantities: sweep, label of the axis, and how the quantity is read from a row.
const SWEEPS: [(&str, &str, Quantity); 4] = [
    ("cap", "most points of a leaf", |row| f64::from(row.form.cap)),
    ("depth", "greatest depth", |row| f64::from(row.form.depth)),
    ("spacing", "spacing of samples, mm", |row| row.form.spacing_mm),
    ("step", "mean way of the tip between poses, mm", |row| row.form.step_mm),
];

/// The sweeps: tests against the swept quantity, over all surfaces; for the spacing, also the contacts that sampling misses.
fn sweeps(rows: &[Counted]) -> Sketch<Grouped> {
    let panels = SWEEPS.into_iter().flat_map(|sweep| panels_of(rows, sweep)).collect();
    Sketch {
        name: "ablation-sweeps",
        title: "What cap, depth, spacing and step do".to_owned(),
        caption: "The octree without a second tool level, safe mode unless said otherwise, over all surfaces."
            .to_owned(),
        drawing: Grouped::of(panels, 2, "the sweeps were not made; they are with --profile quick"),
    }
}

/// The panels of one sweep.
fn panels_of(rows: &[Counted], (sweep, axis, quantity): (&str, &'static str, Quantity)) -> Vec<Panel> {
    let of_sweep: Vec<&Counted> = rows.iter().filter(|row| row.form.sweep == sweep).collect();
    // Steps differ a little from surface to surface: the n-th value of each is one category.
    let rank = |row: &Counted| {
        let same = of_sweep.iter().filter(|other| other.surface() == row.surface());
        let mut values = distinct(same.map(|other| quantity(other)));
        values.sort_by(f64::total_cmp);
        values.iter().position(|value| *value == quantity(row)).unwrap_or(0)
    };
    let ranked: Vec<(usize, &Counted)> = of_sweep.iter().map(|row| (rank(row), *row)).collect();
    let count = ranked.iter().map(|(rank, _)| rank + 1).max().unwrap_or(0);
    let name = |rank: usize| {
        let values: Vec<f64> = ranked.iter().filter(|(of, _)| *of == rank).map(|(_, row)| quantity(row)).collect();
        number((values.iter().sum::<f64>() / values.len().max(1) as f64 * 100.0).round() / 100.0)
    };
    let categories: Vec<String> = (0..count).map(name).collect();
    let line = |number: usize, text: &str, coherence: u8, safe: u8, part: &dyn Fn(&[&Counted]) -> Option<Point>| {
        let of_rank = |rank: usize| {
            let members = ranked
                .iter()
                .filter(|(of, row)| *of == rank && (row.form.coherence, row.form.safe) == (coherence, safe));
            part(&members.map(|(_, row)| *row).collect::<Vec<_>>())
        };
        Series { entry: entry(text.to_owned(), number), points: (0..count).map(of_rank).collect() }
    };
    let panel = |title: String, measure: &'static str, scale: Scale, series: Vec<Series>| Panel {
        title,
        measure,
        sorted_by: axis,
        scale,
        form: Form::Lines,
        reference: None,
        categories: categories.clone(),
        series,
    };
    let mut series = Vec::new();
    for (n, (measure, part)) in MEASURES.into_iter().enumerate() {
        for coherence in [0, 1] {
            let text = format!("{measure}{}", if coherence == 1 { ", coherence" } else { "" });
            series.push(line(2 * n + usize::from(coherence), &text, coherence, 1, &|rows| mean(rows, part)));
        }
    }
    let mut panels = vec![panel(format!("sweep of the {sweep}"), "tests of a pose", Scale::Log, series)];
    if sweep == "spacing" {
        let missed = |rows: &[&Counted]| {
            let (touching, missed) =
                rows.iter().fold((0, 0), |(t, m), row| (t + row.counts.touching, m + row.counts.missed));
            (touching > 0).then(|| Point::bare(missed as f64 / touching as f64))
        };
        let series =
            vec![line(4, "samples only", 0, 0, &missed), line(5, "widened by the covering radius", 0, 1, &missed)];
        panels.push(panel("contacts missed".to_owned(), "share of touching poses", Scale::Linear, series));
    }
    panels
}

/// Time of a pose, and time of building, against the number of samples.
fn sizes(times: &[Timed]) -> Sketch<Grouped> {
    let rows: Vec<&Timed> = times.iter().filter(|row| row.form.sweep == "size").collect();
    let spacings = distinct(rows.iter().map(|row| row.form.spacing_mm));
    let keys = distinct(rows.iter().map(|row| key(&row.form)));
    let samples = |spacing: f64| {
        let of_octree = rows.iter().find(|row| row.form.spacing_mm == spacing && row.form.coherence == 1);
        of_octree.map_or_else(String::new, |row| format!("{} samples", row.form.points))
    };
    let panel = |title: &str, measure: &'static str, part: fn(&Timed) -> f64| {
        let series = keys.iter().enumerate().map(|(n, &wanted)| {
            let of_it = |spacing: f64| {
                let values = rows.iter().filter(|row| key(&row.form) == wanted && row.form.spacing_mm == spacing);
                Point::spread(values.map(|row| part(row)).collect())
            };
            Series { entry: entry(label(wanted), n), points: spacings.iter().map(|&spacing| of_it(spacing)).collect() }
        });
        Panel {
            title: title.to_owned(),
            measure,
            sorted_by: "",
            scale: Scale::Log,
            form: Form::Lines,
            reference: None,
            categories: spacings.iter().map(|&spacing| samples(spacing)).collect(),
            series: series.collect(),
        }
    };
    let panels = vec![
        panel("time of a pose", "µs", |row| row.ns as f64 / 1e3 / row.poses.max(1) as f64),
        panel("time to build", "s", |row| row.build_ns as f64 / 1e9),
    ];
    Sketch {
        name: "ablation-sizes",
        title: "From ten thousand samples to a million".to_owned(),
        caption: "One surface, safe mode, one thread; whiskers span the rounds. All points are asked at every hundredth pose of the largest."
            .to_owned(),
        drawing: Grouped::of(panels, 2, "the sweep of the size was not made; it is with --profile quick"),
    }
}
