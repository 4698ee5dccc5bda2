//! Outlines of lines and arcs with rounded or bevelled corners, and their division into polygons.

use super::super::grid;
use super::error::{Fault, ShapeError, coordinates, length, length_or_zero};
use super::polygon::{self, P2, Polygon};
use super::tessellation::Sizing;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Points nearer than this, mm, count as one point: 67 steps of the coordinate grid, and a thousandth of the smallest length that a
/// description may contain.
const SAME_POINT_MM: f64 = 1e-6;
/// Most points of one divided outline; the limit keeps excessive densities from exhausting memory.
const MOST_POINTS: usize = 100_000;

/// A point of an outline: `[x, y]`, or `[x, y, fillet]`, or a table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a point: [x, y], or [x, y, fillet], or { at_mm = [x, y], fillet_mm | chamfer_mm | arc_mm = ... }"
)]
pub enum OutlinePoint {
    /// A sharp corner at x, y, mm.
    Sharp([f64; 2]),
    /// A corner at x, y, mm, rounded with a radius, mm.
    Rounded([f64; 3]),
    /// A corner with all its properties.
    Detailed(OutlineCorner),
}

/// A corner of an outline, and the line or arc from it to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutlineCorner {
    /// Position of the corner before it is rounded, mm.
    pub at_mm: [f64; 2],
    /// Radius of the rounding, mm; 0 for none. Needs straight edges on both sides.
    #[serde(default)]
    pub fillet_mm: f64,
    /// How far from the corner, on both edges, a bevel begins, mm; 0 for none. Needs straight edges on both sides.
    #[serde(default)]
    pub chamfer_mm: f64,
    /// Radius of an arc to the next point, mm, of at most half a turn; positive when it runs counter-clockwise about its centre, negative
    /// when clockwise. 0 makes a straight line.
    #[serde(default)]
    pub arc_mm: f64,
}

impl From<OutlinePoint> for OutlineCorner {
    fn from(point: OutlinePoint) -> Self {
        match point {
            OutlinePoint::Sharp(at_mm) => Self { at_mm, ..Self::default() },
            OutlinePoint::Rounded([x, y, fillet_mm]) => Self { at_mm: [x, y], fillet_mm, ..Self::default() },
            OutlinePoint::Detailed(corner) => corner,
        }
    }
}

/// A checked corner, with the extent of its rounding.
struct Corner {
    given: OutlineCorner,
    at: P2,
    /// Length of each adjacent edge that the rounding uses, mm.
    reach: f64,
    /// Angle between the edges before and after, radians, positive for a left turn.
    turn: f64,
    /// Unit direction of the edge before; below, of the edge after.
    before: Vector2<f64>,
    after: Vector2<f64>,
}

/// Divides the curves of an outline. The polygon lies on the coordinate grid, is simple and runs counter-clockwise.
pub(super) fn divide(field: &str, outline: &[OutlinePoint], sizing: &Sizing) -> Result<Polygon, ShapeError> {
    let corners = corners(field, outline)?;
    let mut points: Polygon = Vec::new();
    let mut add = |p: P2| {
        let p = P2::new(grid::snap_coordinate(p.x), grid::snap_coordinate(p.y));
        if points.last().is_none_or(|last| (last - p).norm() > SAME_POINT_MM) {
            points.push(p);
        }
    };
    for (i, corner) in corners.iter().enumerate() {
        let next = &corners[(i + 1) % corners.len()];
        add_corner(corner, sizing, &mut add);
        if corner.given.arc_mm != 0.0 {
            add_arc(&format!("{field}[{i}].arc_mm"), corner, next, sizing, &mut add)?;
        }
    }
    if points.len() > 1 && (points[points.len() - 1] - points[0]).norm() <= SAME_POINT_MM {
        points.pop();
    }
    if points.len() > MOST_POINTS {
        return Err(Fault::TooManyTriangles(MOST_POINTS).at(field));
    }
    let loops = [points];
    polygon::check_disjoint(field, &loops)?;
    let [points] = loops;
    if polygon::area(&points) <= 0.0 {
        return Err(Fault::Clockwise.at(field));
    }
    Ok(points)
}

/// The polygon on the coordinate grid, with every edge divided into its number of equal pieces.
pub(super) fn cut_edges(polygon: &[P2], pieces: &[usize]) -> Polygon {
    let cut = |((from, to), &pieces): ((P2, P2), &usize)| {
        let point = move |k: usize| (from + (to - from) * (k as f64 / pieces as f64)).map(grid::snap_coordinate);
        (0..pieces).map(point)
    };
    polygon::edges(polygon).zip(pieces).flat_map(cut).collect()
}

/// Number of pieces of each edge of a polygon, by the permitted edge length of plane faces.
pub(super) fn pieces(polygon: &[P2], sizing: &Sizing) -> Vec<usize> {
    polygon::edges(polygon).map(|(from, to)| sizing.straight((to - from).norm())).collect()
}

/// A circle as a polygon on the coordinate grid.
pub(super) fn circle(centre: P2, radius: f64, segments: usize) -> Polygon {
    let point = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / segments as f64).sin_cos();
        P2::new(grid::snap_coordinate(centre.x + radius * cos), grid::snap_coordinate(centre.y + radius * sin))
    };
    (0..segments).map(point).collect()
}

fn corners(field: &str, outline: &[OutlinePoint]) -> Result<Vec<Corner>, ShapeError> {
    let n = outline.len();
    let given: Vec<OutlineCorner> = outline.iter().map(|&p| p.into()).collect();
    // An arc and its chord enclose an area; two straight edges do not.
    if n < 2 || (n == 2 && given.iter().all(|c| c.arc_mm == 0.0)) {
        return Err(Fault::TooFewPoints(n).at(field));
    }
    if n > MOST_POINTS {
        return Err(Fault::TooManyTriangles(MOST_POINTS).at(field));
    }
    for (i, corner) in given.iter().enumerate() {
        coordinates(&format!("{field}[{i}]"), corner.at_mm)?;
    }
    let at = |i: usize| P2::from(given[i % n].at_mm);
    let mut corners = Vec::with_capacity(n);
    for (i, corner) in given.iter().enumerate() {
        let name = |part: &str| format!("{field}[{i}]{part}");
        let fillet = length_or_zero(&name(".fillet_mm"), corner.fillet_mm)?;
        let chamfer = length_or_zero(&name(".chamfer_mm"), corner.chamfer_mm)?;
        if corner.arc_mm != 0.0 {
            length(&name(".arc_mm"), corner.arc_mm.abs())?;
        }
        let (before, after) = (at(i) - at(i + n - 1), at(i + 1) - at(i));
        if after.norm() <= SAME_POINT_MM {
            return Err(Fault::Coincident.at(name("")));
        }
        let turn = before.perp(&after).atan2(before.dot(&after));
        let on_arc = corner.arc_mm != 0.0 || given[(i + n - 1) % n].arc_mm != 0.0;
        if fillet > 0.0 && chamfer > 0.0 {
            return Err(Fault::FilletAndChamfer.at(name("")));
        }
        if fillet + chamfer > 0.0 && on_arc {
            return Err(Fault::CornerOnArc.at(name("")));
        }
        let reach = if fillet > 0.0 { fillet * (turn.abs() / 2.0).tan() } else { chamfer };
        corners.push(Corner {
            given: *corner,
            at: at(i),
            reach,
            turn,
            before: before.normalize(),
            after: after.normalize(),
        });
    }
    for (i, corner) in corners.iter().enumerate() {
        let next = &corners[(i + 1) % n];
        let (needed, available) = (corner.reach + next.reach, (next.at - corner.at).norm());
        if needed > available + SAME_POINT_MM {
            return Err(Fault::CornerTooLarge { needed, available }.at(format!("{field}[{i}]")));
        }
    }
    Ok(corners)
}

/// Adds a corner: its point, the two ends of its bevel, or the points of its rounding.
fn add_corner(corner: &Corner, sizing: &Sizing, add: &mut impl FnMut(P2)) {
    let (from, to) = (corner.at - corner.before * corner.reach, corner.at + corner.after * corner.reach);
    if corner.reach <= 0.0 {
        return add(corner.at);
    }
    let radius = corner.given.fillet_mm;
    add(from);
    if radius > 0.0 {
        let inward = Vector2::new(-corner.before.y, corner.before.x) * (radius * corner.turn.signum());
        add_turning(from + inward, from, corner.turn, sizing.arc(radius, corner.turn), add);
    }
    add(to);
}

/// Adds the inner points of the arc from a corner to the next.
fn add_arc(
    field: &str,
    corner: &Corner,
    next: &Corner,
    sizing: &Sizing,
    add: &mut impl FnMut(P2),
) -> Result<(), ShapeError> {
    let radius = corner.given.arc_mm;
    let chord = next.at - corner.at;
    let half = chord.norm() / 2.0;
    if radius.abs() < half - SAME_POINT_MM {
        return Err(Fault::ArcTooSmall { radius: radius.abs(), chord: 2.0 * half }.at(field));
    }
    let left = Vector2::new(-chord.y, chord.x) / (2.0 * half);
    let centre = corner.at + chord / 2.0 + left * (radius.powi(2) - half.powi(2)).max(0.0).sqrt() * radius.signum();
    let sweep = 2.0 * (half / radius.abs()).min(1.0).asin() * radius.signum();
    // Never a bare chord: half a circle needs its middle, and a division into one would lose the arc.
    add_turning(centre, corner.at, sweep, sizing.arc(radius.abs(), sweep).max(2), add);
    Ok(())
}

/// Adds the points strictly between the ends of an arc of `sweep` radians about `centre` that begins at `from`.
fn add_turning(centre: P2, from: P2, sweep: f64, pieces: usize, add: &mut impl FnMut(P2)) {
    let arm = from - centre;
    for k in 1..pieces {
        add(centre + nalgebra::Rotation2::new(sweep * k as f64 / pieces as f64) * arm);
    }
}

#[cfg(test)]
mod tests {
    use super::super::tessellation::Tessellation;
    use super::*;
    use std::f64::consts::PI;

    fn fine() -> Sizing {
        Sizing::new(&Tessellation { density: 20.0, grading: 1.0 }, 1.0)
    }

    fn area_of(outline: &[OutlinePoint]) -> Result<f64, ShapeError> {
        divide("outline_mm", outline, &fine()).map(|p| polygon::area(&p))
    }

    #[test]
    fn rounded_corners_take_their_area_away() {
        let square =
            [[0.0, 0.0, 2.0], [10.0, 0.0, 2.0], [10.0, 10.0, 2.0], [0.0, 10.0, 2.0]].map(OutlinePoint::Rounded);
        // 100 - (4 - pi) r²
        assert!((area_of(&square).unwrap() - (100.0 - (4.0 - PI) * 4.0)).abs() < 1e-3);
        let bevel = |x: f64, y: f64| {
            OutlinePoint::Detailed(OutlineCorner { at_mm: [x, y], chamfer_mm: 1.0, ..OutlineCorner::default() })
        };
        let square = [bevel(0.0, 0.0), bevel(10.0, 0.0), bevel(10.0, 10.0), bevel(0.0, 10.0)];
        assert!((area_of(&square).unwrap() - 98.0).abs() < 1e-9); // 100 - 4 · 1²/2
    }

    #[test]
    fn two_half_arcs_are_a_circle_and_corners_may_meet() {
        let half =
            |x: f64| OutlinePoint::Detailed(OutlineCorner { at_mm: [x, 0.0], arc_mm: 3.0, ..OutlineCorner::default() });
        assert!((area_of(&[half(3.0), half(-3.0)]).unwrap() - 9.0 * PI).abs() < 1e-2);
        // Roundings that use up every edge: a circle of radius 5.
        let square =
            [[0.0, 0.0, 5.0], [10.0, 0.0, 5.0], [10.0, 10.0, 5.0], [0.0, 10.0, 5.0]].map(OutlinePoint::Rounded);
        assert!((area_of(&square).unwrap() - 25.0 * PI).abs() < 1e-2);
    }

    #[test]
    fn faults_name_the_corner() {
        let fault = |outline: &[OutlinePoint]| area_of(outline).unwrap_err();
        let sharp = |points: &[[f64; 2]]| points.iter().map(|&p| OutlinePoint::Sharp(p)).collect::<Vec<_>>();
        let error = fault(&[[0.0, 0.0, 6.0], [10.0, 0.0, 6.0], [10.0, 10.0, 0.0]].map(OutlinePoint::Rounded));
        assert_eq!(error.field, "outline_mm[0]");
        assert!(matches!(error.fault, Fault::CornerTooLarge { available: 10.0, .. }));
        assert_eq!(fault(&sharp(&[[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]])).fault, Fault::Clockwise);
        assert_eq!(fault(&sharp(&[[0.0, 0.0], [1.0, 0.0]])).fault, Fault::TooFewPoints(2));
        assert_eq!(fault(&sharp(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])).field, "outline_mm[1]");
        assert!(matches!(fault(&sharp(&[[0.0, 0.0], [1.0, f64::NAN], [1.0, 1.0]])).fault, Fault::NotFinite(_)));
        let arc = OutlineCorner { at_mm: [0.0, 0.0], arc_mm: 4.0, ..OutlineCorner::default() };
        let error =
            fault(&[OutlinePoint::Detailed(arc), OutlinePoint::Sharp([10.0, 0.0]), OutlinePoint::Sharp([5.0, 9.0])]);
        assert_eq!(error.fault, Fault::ArcTooSmall { radius: 4.0, chord: 10.0 });
    }
}
