//! Figures of how tightly each level of the trees encloses its contents.

use super::Sketch;
use super::data::{Data, Entry};
use super::grouped::{Form, Grouped, Panel, Point, Series};
use super::ticks::Scale;

/// Deepest level that is drawn; deeper levels hold few nodes and little volume.
const LEVELS_MAX: u32 = 16;

/// Reasons for a missing figure.
const NO_ROWS: &str = "tightness.csv holds no rows: no volume is measured";
const FLAT: &str = "tightness.csv holds no contents with a convex hull: the parts are flat";

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
        drawing: Grouped::of(panels, 2, if data.tightness.is_empty() { NO_ROWS } else { FLAT }),
    }
}

fn panel(data: &Data, scene: &str) -> Panel {
    let rows: Vec<_> = data
        .tightness
        .iter()
        .filter(|row| row.scene == scene && row.frame == 0 && row.level < LEVELS_MAX && data.is_default(&row.case()))
        .collect();
    let levels = rows.iter().map(|row| row.level + 1).max().unwrap_or(0);
    let looseness = |variant: &str, level: u32| {
        let of_it = rows.iter().filter(|row| row.variant == variant && row.level == level);
        let (volume, hull) = of_it.fold((0.0, 0.0), |(v, h), row| (v + row.hulled_volume_mm3, h + row.hull_mm3));
        (hull > 0.0).then(|| Point::bare(volume / hull))
    };
    Panel {
        title: scene.to_owned(),
        measure: "volume / hull volume",
        sorted_by: "tree level",
        scale: Scale::Log,
        form: Form::Lines,
        reference: None,
        categories: (0..levels).map(|level| level.to_string()).collect(),
        series: Series::of(&data.variants, |entry| (0..levels).map(|level| looseness(&entry.id, level)).collect()),
    }
}

/// The measures that show the influence of a frame: label of the axis, and title.
const MEASURES: [(&str, &str); 3] = [
    ("volume / hull volume", "looseness"),
    ("distance to the contents' hull, mm", "reach beyond the contents"),
    ("sibling overlap / volume", "what siblings share"),
];

pub(super) fn frames(data: &Data) -> Sketch<Grouped> {
    let panels = data.scenes.iter().flat_map(|scene| (0..MEASURES.len()).map(|measure| by_frame(data, scene, measure)));
    let reason = match () {
        () if data.tightness.is_empty() => NO_ROWS,
        () if data.tightness.iter().all(|row| row.frame == 0) => "tightness.csv holds no random frames",
        () => FLAT,
    };
    Sketch {
        name: "tightness-by-frame",
        title: "Tightness in the parts' own frames and in random ones".to_owned(),
        caption: "Over the upper levels of the trees of all parts, own frame against frames turned at random: the volumes over the volumes of the convex hulls of their contents; the largest distance from a volume to that hull; the share of the volumes that two siblings both claim. What changes with the frame depends on the modeller's choice of axes, not on the shape. Default tree policies. Axes are logarithmic; values of zero are in a row `none` below them."
            .to_owned(),
        drawing: Grouped::of(panels.collect(), MEASURES.len(), reason),
    }
}

fn by_frame(data: &Data, scene: &str, measure: usize) -> Panel {
    let value = |variant: &str, is_own: bool| {
        let rows = data.tightness.iter().filter(|row| {
            row.scene == scene
                && row.variant == variant
                && (row.frame == 0) == is_own
                && row.hausdorff_mm.is_some()
                && data.is_default(&row.case())
        });
        let (mut above, mut below, mut farthest) = (0.0, 0.0, None);
        for row in rows {
            match measure {
                0 => (above, below) = (above + row.hulled_volume_mm3, below + row.hull_mm3),
                1 => farthest = row.hausdorff_mm.into_iter().chain(farthest).reduce(f64::max),
                _ => {
                    above += row.sibling_overlap_mm3.unwrap_or(0.0);
                    below += row.sibling_overlap_mm3.map_or(0.0, |_| row.volume_mm3);
                }
            }
        }
        if measure == 1 { farthest.map(Point::bare) } else { (below > 0.0).then(|| Point::bare(above / below)) }
    };
    let has_frames = data.tightness.iter().any(|row| row.frame > 0);
    let points = |entry: &Entry| [true, false].map(|is_own| value(&entry.id, is_own).filter(|_| has_frames)).to_vec();
    Panel {
        title: format!("{scene}, {}", MEASURES[measure].1),
        measure: MEASURES[measure].0,
        sorted_by: "",
        scale: Scale::Log,
        form: Form::Lines,
        reference: None,
        categories: vec!["own frame".to_owned(), "random".to_owned()],
        series: Series::of(&data.variants, points),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::canvas::svg;
    use crate::record::synthetic::{Plan, Run};

    /// One loose volume leaves the others their room on the axis, and a value of zero has a place.
    #[test]
    fn a_loose_volume_hides_no_others() {
        let mut run = Run::generate(&Plan::default());
        for row in &mut run.tightness {
            match row.variant.as_str() {
                "ellipsoid" => row.hulled_volume_mm3 *= 1e4,
                "aabb" => row.sibling_overlap_mm3 = Some(0.0),
                _ => {}
            }
        }
        let folder = tempfile::tempdir().unwrap();
        run.write(folder.path());
        let drawing = frames(&Data::read(folder.path()).unwrap()).drawing.unwrap();
        let ends = |panel: &Panel| {
            let points = panel.series.iter().flat_map(|series| series.points.iter().flatten());
            let range = panel.scale.range(points.clone().map(|point| point.value));
            let aabb = panel.series.iter().find(|series| series.entry.id == "aabb").unwrap();
            let height = panel.scale.coordinate(aabb.points[0].unwrap().value);
            (height - range.0) / (range.1 - range.0)
        };
        assert!(ends(&drawing.panels[0]) > 0.05, "{}", ends(&drawing.panels[0]));
        assert!(svg(&drawing).unwrap().lines().any(|line| line == "none"));
    }
}
