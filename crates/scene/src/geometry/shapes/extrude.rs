//! Prisms: an outline with holes, extruded along z.

use super::super::Point;
use super::error::{Fault, ShapeError, coordinates, length, length_or_zero};
use super::outline::{OutlinePoint, circle, cut_edges, divide, pieces};
use super::planar::{Face, add_face};
use super::polygon::{self, P2, Polygon};
use super::solid::Surface;
use super::tessellation::{Sizing, affordable};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// An outline extruded from z = 0 to z = `height_mm`: bed ways, slides, T-slot tables, bodies, jaws, plates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extrude {
    /// Closed outline, points `[x, y]`, counter-clockwise.
    pub outline_mm: Vec<OutlinePoint>,
    /// Holes from bottom to top.
    #[serde(default)]
    pub holes: Vec<ExtrudeHole>,
    /// Height, mm.
    pub height_mm: f64,
    /// Treatment of all edges of the bottom, including the holes' edges.
    #[serde(default)]
    pub bottom: Rim,
    /// Treatment of all edges of the top, including the holes' edges.
    #[serde(default)]
    pub top: Rim,
}

/// A hole through an [`Extrude`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a hole: { at_mm = [x, y], radius_mm = r } or { outline_mm = [points] }")]
pub enum ExtrudeHole {
    /// A round hole.
    Round(RoundHole),
    /// A hole with an outline.
    Outlined(OutlinedHole),
}

/// A round hole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoundHole {
    /// Centre `[x, y]`, mm.
    pub at_mm: [f64; 2],
    /// Radius, mm.
    pub radius_mm: f64,
}

/// A hole with an outline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutlinedHole {
    /// Closed outline, points `[x, y]`, counter-clockwise like the outer one.
    pub outline_mm: Vec<OutlinePoint>,
}

/// Treatment of the edges of one end; by default they are sharp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rim {
    /// Radius of a rounding, mm; 0 for none.
    #[serde(default)]
    pub fillet_mm: f64,
    /// Width and height of a bevel, mm; 0 for none.
    #[serde(default)]
    pub chamfer_mm: f64,
}

impl Rim {
    fn width(&self, field: &str) -> Result<f64, ShapeError> {
        let fillet = length_or_zero(&format!("{field}.fillet_mm"), self.fillet_mm)?;
        let chamfer = length_or_zero(&format!("{field}.chamfer_mm"), self.chamfer_mm)?;
        if fillet > 0.0 && chamfer > 0.0 { Err(Fault::FilletAndChamfer.at(field)) } else { Ok(fillet + chamfer) }
    }

    /// Insets and heights above the end, from the end itself to the full outline, both included.
    fn rows(&self, sizing: &Sizing) -> Vec<(f64, f64)> {
        if self.chamfer_mm > 0.0 {
            return vec![(self.chamfer_mm, 0.0), (0.0, self.chamfer_mm)];
        }
        if self.fillet_mm <= 0.0 {
            return vec![(0.0, 0.0)];
        }
        let (radius, pieces) = (self.fillet_mm, sizing.arc(self.fillet_mm, FRAC_PI_2).max(2));
        let row = |k: usize| match k {
            // Exactly on the outline, which 1 - sin(π/2) may not be.
            k if k == pieces => (0.0, radius),
            k => {
                let (sin, cos) = (FRAC_PI_2 * k as f64 / pieces as f64).sin_cos();
                (radius * (1.0 - sin), radius * (1.0 - cos))
            }
        };
        (0..=pieces).map(row).collect()
    }
}

impl Extrude {
    pub(super) fn surface(&self, sizing: &Sizing) -> Result<Surface, ShapeError> {
        let height = length("height_mm", self.height_mm)?;
        let (bottom, top) = (self.bottom.width("bottom")?, self.top.width("top")?);
        if bottom + top >= height {
            return Err(Fault::RimTooWide(bottom + top).at("height_mm"));
        }
        let loops = self.loops(sizing)?;
        let rows = self.rows(sizing, height, bottom, top);
        // Edges are cut after the inset, so that the pieces next to a corner share in what its mitre takes.
        let pieces: Vec<Vec<usize>> = loops.iter().map(|polygon| pieces(polygon, sizing)).collect();
        let around: usize = pieces.iter().flatten().sum();
        affordable("outline_mm", &[2, around, rows.len()])?;
        let mut surface = Surface::default();
        // Vertices by row, loop and point.
        let mut levels = Vec::with_capacity(rows.len());
        for &(inset, z) in &rows {
            let level = inset_loops(&loops, inset)?;
            let level: Vec<Polygon> = level.iter().zip(&pieces).map(|(polygon, n)| cut_edges(polygon, n)).collect();
            let vertices: Vec<Vec<u32>> = level
                .iter()
                .map(|polygon| polygon.iter().map(|p| surface.vertex(Point::new(p.x, p.y, z))).collect())
                .collect();
            levels.push((level, vertices));
        }
        for pair in levels.windows(2) {
            for (i, (low, high)) in pair[0].1.iter().zip(&pair[1].1).enumerate() {
                // The solid is on the other side of a hole's edge.
                if i == 0 { surface.band(low, high) } else { surface.band(high, low) }
            }
        }
        for (end, mirrored) in [(0, true), (levels.len() - 1, false)] {
            let (loops, vertices) = &levels[end];
            if rows[end].0 > 0.0 {
                let field = if mirrored { "bottom" } else { "top" };
                check_nesting(field, loops).map_err(|_| Fault::RimTooWide(rows[end].0).at(field))?;
            }
            let lift = |p: &P2| Point::new(p.x, p.y, rows[end].1);
            add_face(&mut surface, &Face { loops, vertices, mirrored }, sizing, lift)?;
        }
        Ok(surface)
    }

    /// The outline and the holes, all counter-clockwise, checked to be nested and disjoint.
    fn loops(&self, sizing: &Sizing) -> Result<Vec<Polygon>, ShapeError> {
        let mut loops = vec![divide("outline_mm", &self.outline_mm, sizing)?];
        for (i, hole) in self.holes.iter().enumerate() {
            let name = |part: &str| format!("holes[{i}].{part}");
            loops.push(match hole {
                ExtrudeHole::Round(round) => {
                    let radius = length(&name("radius_mm"), round.radius_mm)?;
                    let centre = coordinates(&name("at_mm"), round.at_mm)?;
                    circle(P2::from(centre), radius, sizing.circle(radius))
                }
                ExtrudeHole::Outlined(hole) => divide(&name("outline_mm"), &hole.outline_mm, sizing)?,
            });
        }
        check_nesting("holes", &loops)?;
        Ok(loops)
    }

    /// Insets and heights of the rows of vertices, from bottom to top.
    fn rows(&self, sizing: &Sizing, height: f64, bottom: f64, top: f64) -> Vec<(f64, f64)> {
        let mut rows = self.bottom.rows(sizing);
        let wall = height - bottom - top;
        let pieces = sizing.straight(wall);
        rows.extend((1..pieces).map(|k| (0.0, bottom + wall * k as f64 / pieces as f64)));
        rows.extend(self.top.rows(sizing).into_iter().rev().map(|(inset, depth)| (inset, height - depth)));
        rows
    }
}

/// Checks that all loops after the first lie inside the first and outside one another, and that no two touch.
fn check_nesting(field: &str, loops: &[Polygon]) -> Result<(), ShapeError> {
    polygon::check_disjoint(field, loops)?;
    for (i, hole) in loops.iter().enumerate().skip(1) {
        if !polygon::contains(&loops[0], &hole[0]) {
            return Err(Fault::HoleOutside("the outline").at(format!("{field}[{}]", i - 1)));
        }
        let other = (1..loops.len()).find(|&j| j != i && polygon::contains(&loops[j], &hole[0]));
        if let Some(j) = other {
            return Err(Fault::HolesMeet(format!("{field}[{}]", j - 1)).at(format!("{field}[{}]", i - 1)));
        }
    }
    Ok(())
}

/// The outline made smaller and the holes made larger by `width` mm.
fn inset_loops(loops: &[Polygon], width: f64) -> Result<Vec<Polygon>, ShapeError> {
    if width == 0.0 {
        return Ok(loops.to_vec());
    }
    let moved = |(i, polygon): (usize, &Polygon)| {
        let moved = polygon::inset(polygon, if i == 0 { width } else { -width });
        moved.ok_or_else(|| Fault::RimTooWide(width).at("rim"))
    };
    loops.iter().enumerate().map(moved).collect()
}
