//! Time to build a tree.

use super::Sketch;
use super::data::{Data, Entry};
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::Scale;
use crate::analysis::grouped;
use crate::analysis::stats::quantile;
use std::collections::BTreeMap;

pub(super) fn sketch(data: &Data) -> Sketch<Grouped> {
    let panels = data.scenes.iter().map(|scene| panel(data, scene)).collect();
    let single = if has_single(data) {
        " A marker without a whisker is a single build, the first and so with cold caches: it decides nothing."
    } else {
        ""
    };
    Sketch {
        name: "build-time",
        title: "Time to build a tree".to_owned(),
        caption: format!(
            "Time to build the tree over one part, by part and variant (default tree policy). Markers are medians over all \
                  builds, whiskers reach from the 5th to the 95th percentile (of a few builds nearly from the least to the most). Trees of eight-wide \
                  nodes are built on all threads, the others on one. The number after a part's name is its count of triangles.{single}"
        ),
        drawing: Grouped::of(panels, 2, "builds.csv holds no rows; measure first"),
    }
}

/// Whether the run built any of the trees only once.
fn has_single(data: &Data) -> bool {
    let builds = data.builds.iter().map(|row| ((&row.scene, row.case(), &row.part), ()));
    grouped(builds).values().any(|builds| builds.len() == 1)
}

fn panel(data: &Data, scene: &str) -> Panel {
    let mut times: BTreeMap<(&str, &str), Vec<f64>> = BTreeMap::new();
    let mut parts: BTreeMap<&str, u64> = BTreeMap::new();
    for row in data.builds.iter().filter(|row| row.scene == scene && data.is_default(&row.case())) {
        times.entry((&row.variant, &row.part)).or_default().push(row.ns as f64 / 1e6);
        parts.insert(&row.part, row.triangles);
    }
    times.values_mut().for_each(|times| times.sort_unstable_by(f64::total_cmp));
    let point = |times: &Vec<f64>| {
        let [low, value, high] = [0.05, 0.5, 0.95].map(|q| quantile(times, q));
        Point { value, low, high }
    };
    let points = |entry: &Entry| parts.keys().map(|part| times.get(&(&*entry.id, *part)).map(point)).collect();
    Panel {
        title: scene.to_owned(),
        measure: "build time, ms",
        sorted_by: "part (triangles)",
        scale: Scale::Log,
        form: Form::Markers,
        reference: None,
        series: Series::of(&data.variants, points),
        categories: parts.iter().map(|(part, triangles)| format!("{part} ({triangles})")).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::synthetic::{Plan, Run};

    #[test]
    fn a_single_build_is_told() {
        for launches in [1, 3] {
            let mut run = Run::generate(&Plan { launches, ..Plan::default() });
            run.builds.retain(|row| row.block == 0);
            let folder = tempfile::tempdir().unwrap();
            run.write(folder.path());
            let caption = sketch(&Data::read(folder.path()).unwrap()).caption;
            assert_eq!(caption.contains("is a single build"), launches == 1, "{caption}");
        }
    }
}
