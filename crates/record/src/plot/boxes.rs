//! Figure of the boxes on the tool: the paper's plain box as in its text, centred on the mean, beside the tight box along the same axes.
//! The shift between the two is what the paper calls drift.

use super::Sketch;
use super::canvas::{Area, DrawResult, Drawing, PANEL_PX, TEXT_PX, text};
use super::data::{Data, Entry};
use super::marks::{LEGEND_PX, Pixel, label, wrap};
use crate::record::{MESH_OUTLINE, OutlineRow};
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

const VIEW_WIDTH: u32 = 620;
const VIEW_HEIGHT: u32 = 520;
const LABELS_PX: u32 = 78;
const MARGIN_PX: u32 = 16;

/// Largest number of edges drawn; more are thinned evenly, because they would print as a solid area.
const EDGES_MAX: usize = 6000;

const AXES: [&str; 3] = ["x, mm", "y, mm", "z, mm"];

/// Coordinate axes as records name them.
const VIEWS: [&str; 3] = ["x", "y", "z"];

type Segment = [[f64; 3]; 2];

/// A box with its look.
#[derive(Clone, Debug)]
struct DrawnBox {
    entry: Entry,
    edges: Vec<Segment>,
}

/// One part seen along one coordinate axis.
#[derive(Clone, Debug)]
struct View {
    title: String,
    /// Coordinate axes that point right and up in the drawing.
    axes: [usize; 2],
    mesh: Vec<Segment>,
    boxes: Vec<DrawnBox>,
}

/// All views, two in a row.
#[derive(Clone, Debug)]
pub struct Boxes {
    views: Vec<View>,
}

pub(super) fn sketch(data: &Data) -> Sketch<Boxes> {
    Sketch {
        name: "boxes-on-the-tool",
        title: "The paper's box and the tight box, drawn on the part".to_owned(),
        caption: "Root boxes over the edges and the silhouette of the part (grey), in two orthogonal projections of the part's own frame, at equal \
                  scales. Of each scene the part is shown on which the boxes differ most. The paper-literal box is centred on \
                  the mean of the triangle corners and has half the extent of the part: where the mean is not in the middle the \
                  box is shifted toward the side with more corners, cuts off part of the mesh on the other side, and leaves \
                  an equal gap opposite."
            .to_owned(),
        drawing: Boxes::of(data),
    }
}

impl Boxes {
    fn of(data: &Data) -> Result<Self, &'static str> {
        let mut views = Vec::new();
        for scene in &data.scenes {
            let mut parts: Vec<&str> =
                data.outlines.iter().filter(|row| row.scene == *scene).map(|row| row.part.as_str()).collect();
            parts.sort_unstable();
            parts.dedup();
            let candidates = parts.into_iter().filter_map(|part| Part::of(data, scene, part));
            if let Some(part) = candidates.max_by(|a, b| length(a.shift).total_cmp(&length(b.shift))) {
                views.extend(part.views(scene));
            }
        }
        if views.is_empty() {
            Err("outlines.csv holds no part with a box that the claims draw")
        } else {
            Ok(Self { views })
        }
    }
}

/// A part with the boxes drawn on it.
struct Part<'a> {
    name: &'a str,
    /// The edges seen along each coordinate axis.
    mesh: [Vec<Segment>; 3],
    boxes: Vec<DrawnBox>,
    /// Vector from the last box's centre to the first one's, mm.
    shift: [f64; 3],
}

impl<'a> Part<'a> {
    fn of(data: &Data, scene: &str, name: &'a str) -> Option<Self> {
        let edges = |variant: &str| -> Vec<Segment> {
            let rows = data.outlines.iter().filter(|row| row.scene == scene && row.part == name);
            rows.filter(|row| row.variant == variant).map(segment).collect()
        };
        let drawn = data.claims.comparison.drawn.iter().filter_map(|id| {
            let edges = edges(id);
            (!edges.is_empty()).then_some(DrawnBox { entry: data.variant(id)?.clone(), edges })
        });
        let boxes: Vec<DrawnBox> = drawn.collect();
        let (first, last) = (centre(&boxes.first()?.edges), centre(&boxes.last()?.edges));
        let mesh = VIEWS.map(|view| {
            let rows = data.outlines.iter().filter(|row| row.scene == scene && row.part == name);
            let rows = rows.filter(|row| row.variant == MESH_OUTLINE && (row.view.is_empty() || row.view == view));
            let seen: Vec<Segment> = rows.map(segment).collect();
            let every = seen.len().div_ceil(EDGES_MAX).max(1);
            seen.into_iter().step_by(every).collect()
        });
        Some(Self { name, mesh, boxes, shift: std::array::from_fn(|i| first[i] - last[i]) })
    }

    /// Two projections that contain the direction of the shift, drawn to the right.
    fn views(self, scene: &str) -> [View; 2] {
        let [x, y, z] = self.shift.map(f64::abs);
        let across = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        let [up, other] = [(across + 1) % 3, (across + 2) % 3];
        [up, other].map(|up| View {
            title: format!("{scene}: {}", self.name),
            axes: [across, up],
            mesh: self.mesh[3 - across - up].clone(),
            boxes: self.boxes.clone(),
        })
    }
}

fn segment(row: &OutlineRow) -> Segment {
    [[row.x1_mm, row.y1_mm, row.z1_mm], [row.x2_mm, row.y2_mm, row.z2_mm]]
}

/// The centre of a box: the mean of the ends of its edges.
fn centre(edges: &[Segment]) -> [f64; 3] {
    let count = (2 * edges.len()) as f64;
    std::array::from_fn(|i| edges.iter().flatten().map(|point| point[i]).sum::<f64>() / count)
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl Drawing for Boxes {
    fn size(&self) -> (u32, u32) {
        (2 * VIEW_WIDTH + LEGEND_PX, self.views.len().div_ceil(2) as u32 * VIEW_HEIGHT)
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let (left, right) = area.split_horizontally(2 * VIEW_WIDTH);
        for (view, place) in self.views.iter().zip(left.split_evenly((self.views.len().div_ceil(2), 2))) {
            view.draw(&place)?;
        }
        let mut y = 60;
        let mut line = |name: &str, style: ShapeStyle| -> DrawResult {
            right.draw(&PathElement::new(vec![(16, y), (56, y)], style))?;
            for words in wrap(name, 30) {
                label(&right, &words, TEXT_PX, (66, y), HPos::Left)?;
                y += 28;
            }
            y += 10;
            Ok(())
        };
        line("edges of the part", MESH_COLOUR.stroke_width(2))?;
        let boxes = self.views.first().map_or(&[][..], |view| &view.boxes);
        let mut widths = stroke_widths(boxes.len());
        boxes.iter().try_for_each(|drawn| {
            line(&drawn.entry.label, drawn.entry.look.colour.stroke_width(widths.next().unwrap_or(THIN_PX)))
        })
    }
}

/// Width of the first box's lines, px.
const THIN_PX: u32 = 2;

/// Stroke widths of the boxes. Each further box is drawn wider and beneath the others, so that all boxes show where their edges coincide.
fn stroke_widths(boxes: usize) -> impl Iterator<Item = u32> {
    (0..boxes as u32).map(|i| THIN_PX + 4 * i)
}

const MESH_COLOUR: RGBColor = RGBColor(110, 110, 110);

impl View {
    /// Ranges of both axes that contain everything, with equal millimetres per pixel.
    fn ranges(&self) -> [(f64, f64); 2] {
        let pixels = [VIEW_WIDTH - LABELS_PX - 2 * MARGIN_PX, VIEW_HEIGHT - LABELS_PX - 2 * MARGIN_PX - 34];
        let segments = || self.mesh.iter().chain(self.boxes.iter().flat_map(|drawn| &drawn.edges)).flatten();
        let extents = self.axes.map(|axis| {
            segments()
                .map(|point| point[axis])
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
        });
        let scale = [0, 1]
            .map(|i| 1.08 * (extents[i].1 - extents[i].0) / f64::from(pixels[i]))
            .into_iter()
            .fold(f64::MIN_POSITIVE.sqrt(), f64::max);
        [0, 1].map(|i| {
            let (middle, half) = (f64::midpoint(extents[i].0, extents[i].1), 0.5 * scale * f64::from(pixels[i]));
            (middle - half, middle + half)
        })
    }

    fn draw(&self, area: &Area<'_>) -> DrawResult {
        let [(left, right), (low, high)] = self.ranges();
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, text(PANEL_PX))
            .margin(MARGIN_PX)
            .x_label_area_size(LABELS_PX)
            .y_label_area_size(LABELS_PX)
            .build_cartesian_2d(left..right, low..high)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .label_style(text(TEXT_PX))
            .axis_desc_style(text(TEXT_PX))
            .x_labels(6)
            .y_labels(6)
            .x_label_formatter(&|x| super::ticks::number(*x))
            .y_label_formatter(&|y| super::ticks::number(*y))
            .x_desc(AXES[self.axes[0]])
            .y_desc(AXES[self.axes[1]])
            .draw()?;
        let place = chart.plotting_area().strip_coord_spec();
        let base = place.get_base_pixel();
        let pixel = |point: &[f64; 3]| -> Pixel {
            let (x, y) = chart.backend_coord(&(point[self.axes[0]], point[self.axes[1]]));
            (x - base.0, y - base.1)
        };
        let stroke = |edge: &Segment, style: ShapeStyle| {
            place.draw(&PathElement::new(edge.iter().map(pixel).collect::<Vec<_>>(), style))
        };
        self.mesh.iter().try_for_each(|edge| stroke(edge, MESH_COLOUR.stroke_width(1)))?;
        let widths: Vec<u32> = stroke_widths(self.boxes.len()).collect();
        for (drawn, width) in self.boxes.iter().zip(widths).rev() {
            drawn.edges.iter().try_for_each(|edge| stroke(edge, drawn.entry.look.colour.stroke_width(width)))?;
        }
        Ok(())
    }
}
