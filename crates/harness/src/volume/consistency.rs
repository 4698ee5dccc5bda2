//! Checks that a volume's reported figures are consistent with its contents.
//!
//! Drawings, the tightness of trees, the order of a traversal and the division of nodes depend on these figures. No verdict depends on
//! them, so without these checks an error would stay unnoticed.

use super::Shape;
use crate::geometry::{Isometry, Point, Triangle, Vector};
use nalgebra::Matrix3;
use std::f64::consts::PI;

/// Rounding error of the end points of an outline, mm.
const TOLERANCE_MM: f64 = 1e-6;
/// Cells along each axis of the grid that measures a volume.
const CELLS: usize = 12;
/// Largest permitted difference of the measured volume, as a fraction of the box around the outline. The grid counts cells on the surface
/// whole or not at all.
const MEASURED: f64 = 0.08;
/// Permitted relative error of a surface area: for some bodies, such as ellipsoids, only approximations are known.
const APPROXIMATE: f64 = 0.02;

/// The first reported figure of a volume around `triangles` that cannot be true; `None` when all are consistent. Volumes are assumed to be
/// convex.
pub fn inconsistency<S: Shape>(volume: &S, triangles: &[Triangle]) -> Option<&'static str> {
    // What is checked is gathered first, so that there is one copy of the checks and not one of each volume.
    let said = Said {
        frame: Matrix3::from_columns(&volume.split_axes(triangles).map(nalgebra::Unit::into_inner)),
        centre: volume.centre(),
        ends: volume.outline().into_iter().flatten().collect(),
        size: volume.size(),
        volume: volume.volume(),
        surface_area: volume.surface_area(),
        from_itself_mm: volume.gap_mm(volume, &S::pose(&Isometry::identity())),
        contains: &|point, slack_mm| volume.contains(point, slack_mm),
    };
    said.in_space().or_else(|| said.sizes()).or_else(|| said.slack(&triangles.first()?.corners[0]))
}

/// The figures that a volume reports.
struct Said<'a> {
    frame: Matrix3<f64>,
    centre: Point,
    ends: Vec<Point>,
    size: f64,
    volume: f64,
    surface_area: f64,
    from_itself_mm: f64,
    contains: &'a dyn Fn(&Point, f64) -> bool,
}

impl Said<'_> {
    fn in_space(&self) -> Option<&'static str> {
        let Self { frame, centre, ends, contains, .. } = self;
        // Not a number is not near either.
        let is_rotation = (frame.tr_mul(frame) - Matrix3::identity()).amax() < 1e-9;
        let beyond = |end: &Point| {
            let out = end - centre;
            end + out * 0.01 + out.try_normalize(0.0).unwrap_or_else(Vector::zeros) * TOLERANCE_MM
        };
        let checks = [
            (is_rotation, "split_axes: the axes are not square to one another or not of length 1"),
            (contains(centre, TOLERANCE_MM), "centre: it lies outside the volume"),
            (!ends.is_empty(), "outline: there is none"),
            (ends.iter().all(|end| contains(end, TOLERANCE_MM)), "outline: it leaves the volume"),
            (!ends.iter().any(|end| contains(&beyond(end), 0.0)), "outline: it ends within the volume"),
            (self.from_itself_mm == 0.0, "gap_mm: the volume is apart from itself"),
        ];
        checks.into_iter().find(|(holds, _)| !holds).map(|(_, what)| what)
    }

    fn sizes(&self) -> Option<&'static str> {
        let (v, a) = (self.volume, self.surface_area);
        if ![v, a, self.size].iter().all(|x| x.is_finite() && *x > 0.0) {
            return Some("volume, surface_area, size: not all are positive numbers");
        }
        let around = self.around();
        // No solid has more volume than the ball of its area (the isoperimetric inequality), and none in a box more area when it is convex.
        if 36.0 * PI * v * v > a.powi(3) * (1.0 + APPROXIMATE) {
            return Some("surface_area: it is too little to enclose the volume");
        }
        if a > super::box_area(&(around.lengths * 0.5)) * (1.0 + APPROXIMATE) {
            return Some("surface_area: it is more than that of a box around the outline");
        }
        let part = |i: usize| (i as f64 + 0.5) / CELLS as f64;
        let cells = (0..CELLS.pow(3)).map(|n| [n % CELLS, n / CELLS % CELLS, n / CELLS.pow(2)].map(part));
        let held = cells.filter(|parts| (self.contains)(&around.at(*parts), 0.0)).count();
        let measured = held as f64 / CELLS.pow(3) as f64 * around.volume();
        ((v - measured).abs() > MEASURED * around.volume())
            .then_some("volume: it is not that of the points that the volume contains")
    }

    /// Checks the slack of `contains`: a point at that distance from a contained point is contained with the slack, and a point beyond it
    /// is not.
    fn slack(&self, corner: &Point) -> Option<&'static str> {
        let away = Vector::new(3.0, -4.0, 12.0); // 13 mm
        let contains = self.contains;
        if contains(corner, 0.0) && !contains(&(corner + away), away.norm() + TOLERANCE_MM) {
            return Some("contains: a point nearer than the slack is left out");
        }
        let outside = self.around().at([0.5, 0.5, 1.2]) + self.frame.column(2) * 2.0;
        contains(&outside, 1.0).then_some("contains: a point farther than the slack is let in")
    }

    fn around(&self) -> Around {
        let along = || self.ends.iter().map(|end| self.frame.tr_mul(&end.coords));
        let low = along().fold(Vector::repeat(f64::INFINITY), |low, p| low.inf(&p));
        let high = along().fold(Vector::repeat(f64::NEG_INFINITY), |high, p| high.sup(&p));
        Around { frame: self.frame, low, lengths: high - low }
    }
}

/// The box around an outline, along the volume's split axes.
struct Around {
    frame: Matrix3<f64>,
    low: Vector,
    lengths: Vector,
}

impl Around {
    /// The point at the given fractions of the box's lengths.
    fn at(&self, parts: [f64; 3]) -> Point {
        Point::from(self.frame * (self.low + self.lengths.component_mul(&Vector::from(parts))))
    }

    fn volume(&self) -> f64 {
        self.lengths.product()
    }
}
