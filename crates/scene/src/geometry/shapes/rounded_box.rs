//! Cuboids with rounded edges and corners, and holes in their faces.
//!
//! The surface consists of the outer cells of a lattice. Cells of the outermost layers are bent round the edges: a lattice point there
//! represents a direction whose components are tangents of equal angles. A quarter turn is therefore divided evenly along the edges, and
//! nearly evenly at the corners.

use super::super::{Point, Vector};
use super::box_holes::{BoxHole, Drilled, check_holes};
use super::error::{Fault, ShapeError, length, length_or_zero};
use super::planar::{Face, add_face};
use super::polygon::{P2, Polygon};
use super::solid::Surface;
use super::tessellation::{Sizing, affordable};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// A cuboid about the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoundedBox {
    /// Lengths along x, y and z, mm.
    pub size_mm: [f64; 3],
    /// Radius of all edges and corners, mm; 0 (the default) leaves them sharp.
    #[serde(default)]
    pub fillet_mm: f64,
    /// Holes in the faces. They must lie within the plane part of their faces and must not meet.
    #[serde(default)]
    pub holes: Vec<BoxHole>,
}

impl RoundedBox {
    pub(super) fn surface(&self, sizing: &Sizing) -> Result<Surface, ShapeError> {
        for (axis, size) in self.size_mm.into_iter().enumerate() {
            length(&format!("size_mm[{axis}]"), size)?;
        }
        let fillet = length_or_zero("fillet_mm", self.fillet_mm)?;
        let shortest = self.size_mm.into_iter().fold(f64::INFINITY, f64::min);
        if 2.0 * fillet >= shortest {
            return Err(Fault::CornerTooLarge { needed: 2.0 * fillet, available: shortest }.at("fillet_mm"));
        }
        check_holes(self.size_mm, fillet, &self.holes)?;

        let mut body = Body::new(self.size_mm, fillet, sizing)?;
        let drilled: Vec<Drilled> =
            self.holes.iter().map(|hole| Drilled::new(hole, self.size_mm, sizing, &mut body.surface)).collect();
        for axis in 0..3 {
            for positive in [false, true] {
                let openings: Vec<_> = drilled.iter().filter_map(|hole| hole.opening(axis, positive)).collect();
                body.add_bent_cells(axis, positive, !openings.is_empty());
                if !openings.is_empty() {
                    body.add_drilled_face(axis, positive, &openings, sizing)?;
                }
            }
        }
        Ok(body.surface)
    }
}

/// The lattice of a cuboid under construction.
struct Body {
    surface: Surface,
    /// Half the lengths of the plane faces, mm.
    flat_half: [f64; 3],
    fillet: f64,
    /// Number of cells of an eighth of a turn; 0 without fillet.
    bent: usize,
    /// Number of cells of the plane part, per axis.
    flat: [usize; 3],
    vertex_at: HashMap<[usize; 3], u32>,
}

impl Body {
    fn new(size: [f64; 3], fillet: f64, sizing: &Sizing) -> Result<Self, ShapeError> {
        let flat_half = size.map(|s| s / 2.0 - fillet);
        let flat = flat_half.map(|half| sizing.straight(2.0 * half));
        let bent = if fillet > 0.0 { sizing.arc(fillet, FRAC_PI_2).div_ceil(2) } else { 0 };
        let all = flat.map(|n| n + 2 * bent);
        for axis in 0..3 {
            affordable("size_mm", &[12, all[axis], all[(axis + 1) % 3]])?;
        }
        Ok(Self { surface: Surface::default(), flat_half, fillet, bent, flat, vertex_at: HashMap::new() })
    }

    /// Cells along an axis.
    fn cells(&self, axis: usize) -> usize {
        self.flat[axis] + 2 * self.bent
    }

    /// The vertex of a lattice point on the cuboid's surface.
    fn vertex(&mut self, at: [usize; 3]) -> u32 {
        if let Some(&vertex) = self.vertex_at.get(&at) {
            return vertex;
        }
        let (mut core, mut direction) = (Point::origin(), Vector::zeros());
        for axis in 0..3 {
            let (i, bent, flat) = (at[axis], self.bent, self.flat[axis]);
            let clamped = i.clamp(bent, bent + flat) - bent;
            core[axis] = self.flat_half[axis] * (2.0 * clamped as f64 / flat as f64 - 1.0);
            let tangent = |steps: usize| (FRAC_PI_4 * steps as f64 / bent as f64).tan();
            if i < bent {
                direction[axis] = -tangent(bent - i);
            } else if i > bent + flat {
                direction[axis] = tangent(i - bent - flat);
            }
        }
        let position = if self.bent == 0 { core } else { core + direction.normalize() * self.fillet };
        let vertex = self.surface.vertex(position);
        self.vertex_at.insert(at, vertex);
        vertex
    }

    /// The vertex at lattice position j, k of the face perpendicular to `axis`.
    fn face_vertex(&mut self, axis: usize, positive: bool, j: usize, k: usize) -> u32 {
        let mut at = [0; 3];
        at[axis] = if positive { self.cells(axis) } else { 0 };
        (at[(axis + 1) % 3], at[(axis + 2) % 3]) = (j, k);
        self.vertex(at)
    }

    /// Adds the cells of a face: all of them, or only those outside its plane part.
    fn add_bent_cells(&mut self, axis: usize, positive: bool, spare_plane: bool) {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let plane = |i: usize, axis: usize, body: &Self| (body.bent..body.bent + body.flat[axis]).contains(&i);
        for j in 0..self.cells(b) {
            for k in 0..self.cells(c) {
                if spare_plane && plane(j, b, self) && plane(k, c, self) {
                    continue;
                }
                let corners = [(j, k), (j + 1, k), (j + 1, k + 1), (j, k + 1)];
                let [p, q, r, s] = corners.map(|(j, k)| self.face_vertex(axis, positive, j, k));
                if positive { self.surface.quad(p, q, r, s) } else { self.surface.quad(p, s, r, q) }
            }
        }
    }

    /// Adds the plane part of a face, with the openings of its holes.
    fn add_drilled_face(
        &mut self,
        axis: usize,
        positive: bool,
        openings: &[(&Polygon, &Vec<u32>)],
        sizing: &Sizing,
    ) -> Result<(), ShapeError> {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let (bent, m, n) = (self.bent, self.flat[b], self.flat[c]);
        let mut rim: Vec<(usize, usize)> = (0..m).map(|j| (j, 0)).collect();
        rim.extend((0..n).map(|k| (m, k)));
        rim.extend((1..=m).rev().map(|j| (j, n)));
        rim.extend((1..=n).rev().map(|k| (0, k)));
        let coordinate = |i: usize, axis: usize| {
            super::super::grid::snap_coordinate(self.flat_half[axis] * (2.0 * i as f64 / self.flat[axis] as f64 - 1.0))
        };
        let mut loops =
            vec![rim.iter().map(|&(j, k)| P2::new(coordinate(j, b), coordinate(k, c))).collect::<Polygon>()];
        let height = (self.flat_half[axis] + self.fillet) * if positive { 1.0 } else { -1.0 };
        let rim = rim.iter().map(|&(j, k)| self.face_vertex(axis, positive, bent + j, bent + k)).collect();
        let mut vertices: Vec<Vec<u32>> = vec![rim];
        for (opening, ring) in openings {
            loops.push((*opening).clone());
            vertices.push((*ring).clone());
        }
        let lift = |p: &P2| {
            let mut point = Point::origin();
            (point[axis], point[b], point[c]) = (height, p.x, p.y);
            point
        };
        add_face(&mut self.surface, &Face { loops: &loops, vertices: &vertices, mirrored: !positive }, sizing, lift)
    }
}
