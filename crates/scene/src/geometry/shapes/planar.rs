//! Plane faces with holes, divided by constrained Delaunay triangulation (the `spade` crate).
//!
//! The triangulation is a Delaunay triangulation on exact predicates because it keeps every point. Ear clipping drops collinear points,
//! such as the corners in a pattern of holes, and so leaves T-junctions.

use super::error::{Fault, ShapeError};
use super::polygon::{self, P2, Polygon};
use super::solid::Surface;
use super::tessellation::{Sizing, affordable};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::VecDeque;

/// A plane face: loops of existing vertices, one outer loop and any number of holes, on the grid and disjoint. Seen from outside the solid,
/// coordinates are right-handed when `mirrored` is false.
pub(super) struct Face<'a> {
    /// The loops, in any order and either orientation.
    pub loops: &'a [Polygon],
    /// Index of the vertex at every point of every loop.
    pub vertices: &'a [Vec<u32>],
    /// Whether the coordinates are left-handed seen from outside.
    pub mirrored: bool,
}

/// Adds the face: the points of the loops, and inside it a lattice with the sizing's flat edge length. `lift` maps plane points to space.
pub(super) fn add_face(
    surface: &mut Surface,
    face: &Face<'_>,
    sizing: &Sizing,
    lift: impl Fn(&P2) -> super::super::Point,
) -> Result<(), ShapeError> {
    let mut points: Polygon = face.loops.iter().flatten().copied().collect();
    let mut vertices: Vec<u32> = face.vertices.iter().flatten().copied().collect();
    for point in lattice(face.loops, sizing)? {
        vertices.push(surface.vertex(lift(&point)));
        points.push(point);
    }
    for [a, b, c] in triangulate(face.loops, &points)? {
        let [a, b, c] = [a, b, c].map(|i| vertices[i]);
        if face.mirrored { surface.triangle(a, c, b) } else { surface.triangle(a, b, c) }
    }
    Ok(())
}

/// The points of a square lattice inside the loops (even-odd rule) that are at least half an edge length from them.
fn lattice(loops: &[Polygon], sizing: &Sizing) -> Result<Polygon, ShapeError> {
    let step = sizing.flat_edge();
    let all = || loops.iter().flatten();
    let low = all().fold(P2::new(f64::INFINITY, f64::INFINITY), |low, p| low.inf(p));
    let high = all().fold(P2::new(f64::NEG_INFINITY, f64::NEG_INFINITY), |high, p| high.sup(p));
    let count = [0, 1].map(|i| ((high[i] - low[i]) / step).round().max(1.0) as usize);
    affordable("density", &[2, count[0], count[1]])?;
    let at = |i: usize, k: usize| low[i] + (high[i] - low[i]) * k as f64 / count[i] as f64;
    let mut points = Vec::new();
    for (j, k) in (1..count[0]).flat_map(|j| (1..count[1]).map(move |k| (j, k))) {
        let p = P2::new(super::super::grid::snap_coordinate(at(0, j)), super::super::grid::snap_coordinate(at(1, k)));
        let inside = loops.iter().filter(|polygon| polygon::contains(polygon, &p)).count() % 2 == 1;
        if inside && loops.iter().all(|polygon| polygon::distance(polygon, &p) > 0.5 * step) {
            points.push(p);
        }
    }
    Ok(points)
}

/// The triangles, counter-clockwise, of the area inside the loops (even-odd rule); `points` begins with the points of the loops.
fn triangulate(loops: &[Polygon], points: &[P2]) -> Result<Vec<[usize; 3]>, ShapeError> {
    let mut edges = Vec::new();
    let mut first = 0;
    for polygon in loops {
        let n = polygon.len();
        edges.extend((0..n).map(|i| [first + i, first + (i + 1) % n]));
        first += n;
    }
    let crossing = |edge: [usize; 2]| Fault::Crossing { x: points[edge[0]].x, y: points[edge[0]].y };
    let mut conflict = None;
    let sites = points.iter().map(|p| Point2::new(p.x, p.y)).collect();
    let cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(sites, edges, |edge| {
        conflict.get_or_insert(edge);
    })
    .map_err(|_| Fault::NotFinite(f64::NAN).at("face"))?;
    if let Some(edge) = conflict {
        return Err(crossing(edge).at("face"));
    }
    if cdt.num_vertices() != points.len() {
        return Err(Fault::Coincident.at("face"));
    }

    // Crossing a constraint changes between outside and inside.
    let mut inside = vec![None; cdt.num_all_faces()];
    let outer = cdt.outer_face().fix().index();
    inside[outer] = Some(false);
    let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); cdt.num_all_faces()];
    for edge in cdt.directed_edges() {
        neighbours[edge.face().fix().index()].push((edge.rev().face().fix().index(), edge.is_constraint_edge()));
    }
    let mut queue = VecDeque::from([outer]);
    while let Some(face) = queue.pop_front() {
        let here = inside[face] == Some(true);
        for &(next, constrained) in &neighbours[face] {
            if inside[next].is_none() {
                inside[next] = Some(here != constrained);
                queue.push_back(next);
            }
        }
    }
    let kept = cdt.inner_faces().filter(|face| inside[face.fix().index()] == Some(true));
    Ok(kept.map(|face| face.vertices().map(|v| v.fix().index())).collect())
}

#[cfg(test)]
mod tests {
    use super::super::outline::circle;
    use super::*;

    #[test]
    fn a_pattern_of_aligned_holes_keeps_every_point() {
        let mut loops = vec![vec![P2::new(0.0, 0.0), P2::new(40.0, 0.0), P2::new(40.0, 20.0), P2::new(0.0, 20.0)]];
        for (x, y) in [(8.0, 10.0), (20.0, 10.0), (32.0, 10.0)] {
            loops.push(circle(P2::new(x, y), 4.0, 16));
        }
        let points: Polygon = loops.iter().flatten().copied().collect();
        let triangles = triangulate(&loops, &points).unwrap();
        // Euler: n + 2h - 2 triangles on n points with h holes.
        assert_eq!(triangles.len(), 4 + 48 + 2 * 3 - 2);
        let area: f64 = triangles.iter().map(|t| polygon::area(&t.map(|i| points[i]))).sum();
        let expected = polygon::area(&loops[0]) - 3.0 * polygon::area(&loops[1]);
        assert!((area - expected).abs() < 1e-6);
    }
}
