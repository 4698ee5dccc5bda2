//! How tightly each level of the trees holds its contents.

use super::Sketch;
use super::data::Data;
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::Scale;

/// Deeper levels hold few nodes and little volume.
const LEVELS_MAX: u32 = 16;

pub(super) fn sketch(data: &Data) -> Sketch<Grouped> {
    let panels = data.scenes.iter().map(|scene| panel(data, scene)).collect();
    Sketch {
        name: "tightness-by-level",
        title: "Looseness of the volumes by tree level".to_owned(),
        caption: "Sum of the volumes of a level's nodes over the sum of the volumes of the convex hulls of their contents, all \
                  parts of the scene together; 1 would be perfectly tight. Level 0 is the root. Default tree policies. Nodes \
                  whose contents are flat have no hull volume and are left out. An unsafe variant's volume can look tight \
                  because it does not hold its contents."
            .to_owned(),
        drawing: Grouped::of(panels, 2, "tightness.csv holds no rows; measure first"),
    }
}

fn panel(data: &Data, scene: &str) -> Panel {
    let rows: Vec<_> = data
        .tightness
        .iter()
        .filter(|row| row.scene == scene && row.level < LEVELS_MAX && data.is_default(&row.case()))
        .collect();
    let levels = rows.iter().map(|row| row.level + 1).max().unwrap_or(0);
    let looseness = |variant: &str, level: u32| {
        let of_it = rows.iter().filter(|row| row.variant == variant && row.level == level);
        let (volume, hull) = of_it.fold((0.0, 0.0), |(v, h), row| (v + row.hulled_volume_mm3, h + row.hull_mm3));
        (hull > 0.0).then(|| Point::bare(volume / hull))
    };
    let series = data.variants.iter().map(|entry| Series {
        points: (0..levels).map(|level| looseness(&entry.id, level)).collect(),
        entry: entry.clone(),
    });
    Panel {
        title: scene.to_owned(),
        measure: "volume / hull volume",
        sorted_by: "tree level",
        scale: Scale::Log,
        form: Form::Lines,
        categories: (0..levels).map(|level| level.to_string()).collect(),
        series: series.filter(|series| series.points.iter().any(Option::is_some)).collect(),
    }
}
