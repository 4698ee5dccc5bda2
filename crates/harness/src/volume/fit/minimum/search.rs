//! The smallest box found so far around some points, and the turns about its own axes that make it smaller.

use crate::geometry::{Point, Vector, rectangle};
use nalgebra::Matrix3;

/// A relative improvement below this is rounding error.
pub(super) const PROGRESS: f64 = 1e-12;

/// The search for the smallest box around some points.
pub(super) struct Search {
    /// The points relative to their middle, mm.
    pub(super) points: Vec<Vector>,
    pub(super) pad: f64,
    /// Upper bound on the distance between two points, mm.
    pub(super) diameter: f64,
    /// The smallest volume so far, including the pad, mm³, and its axes.
    pub(super) best: (f64, Matrix3<f64>),
}

impl Search {
    /// Starts with the coordinate axes.
    pub(super) fn new<'a>(points: impl Iterator<Item = &'a Point> + Clone, pad: f64) -> Self {
        let (low, high) = points.clone().fold((None, None), |(low, high): (Option<Point>, Option<Point>), p| {
            (Some(low.map_or(*p, |l| l.inf(p))), Some(high.map_or(*p, |h| h.sup(p))))
        });
        let (low, high) = (low.unwrap_or_else(Point::origin), high.unwrap_or_else(Point::origin));
        let middle = nalgebra::center(&low, &high);
        let points: Vec<Vector> = points.map(|p| p - middle).collect();
        let radius = points.iter().map(Vector::norm).fold(0.0, f64::max);
        let mut search = Self {
            points,
            pad,
            diameter: (2.0 * radius).min((high - low).norm()),
            best: (f64::INFINITY, Matrix3::identity()),
        };
        search.offer(&Matrix3::identity());
        search
    }

    /// Extents along the columns of `axes`, including the pad, mm.
    pub(super) fn widths(&self, axes: &Matrix3<f64>) -> Vector {
        let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        for p in &self.points {
            let x = axes.tr_mul(p);
            (low, high) = (low.inf(&x), high.sup(&x));
        }
        (high - low).add_scalar(2.0 * self.pad)
    }

    /// Keeps the axes if their box is the smallest so far, and returns whether it is.
    pub(super) fn offer(&mut self, axes: &Matrix3<f64>) -> bool {
        let volume = self.widths(axes).product();
        let is_better = volume < self.best.0 * (1.0 - PROGRESS);
        if is_better {
            self.best = (volume, *axes);
        }
        is_better
    }

    /// Offers `axes`, turned about one of their columns to the smallest rectangle seen along it; returns whether that box is the smallest
    /// so far.
    pub(super) fn turn_about(&mut self, axes: &Matrix3<f64>, column: usize) -> bool {
        let (n, u, v) = (axes.column(column), axes.column((column + 1) % 3), axes.column((column + 2) % 3));
        let seen: Vec<[f64; 2]> = self.points.iter().map(|p| [u.dot(p), v.dot(p)]).collect();
        let Some(found) = rectangle::smallest(&seen, self.pad) else { return false };
        let along = (u * found.along[0] + v * found.along[1]).normalize();
        self.offer(&Matrix3::from_columns(&[along, n.cross(&along), n.into_owned()]))
    }

    /// Turns the smallest box about its own axes until no turn makes it smaller.
    pub(super) fn descend(&mut self) {
        /// Limit on the rounds, more than any contents have needed, so that rounding errors cannot cause an endless loop.
        const ROUNDS: u32 = 50;
        for _ in 0..ROUNDS {
            let before = self.best.0;
            for column in 0..3 {
                let axes = self.best.1;
                self.turn_about(&axes, column);
            }
            if self.best.0 >= before {
                return;
            }
        }
    }
}
