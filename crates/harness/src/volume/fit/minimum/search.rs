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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;
    use nalgebra::Rotation3;
    use obbtree::cases::meshes;

    fn search(turn: Vector, pad: f64) -> Search {
        let turn = Isometry::rotation(turn);
        let corners: Vec<Point> = meshes::cuboid(20.0, 12.0, 5.0).vertices().iter().map(|p| turn * p).collect();
        Search::new(corners.iter(), pad)
    }

    #[test]
    fn a_search_begins_with_the_coordinate_axes_and_takes_what_is_smaller_alone() {
        let mut search = search(Vector::zeros(), 0.5);
        assert!((search.best.0 - 21.0 * 13.0 * 6.0).abs() < 1e-9);
        assert!((search.diameter - (400.0_f64 + 144.0 + 25.0).sqrt()).abs() < 1e-9);
        let aslant = Rotation3::from_axis_angle(&Vector::z_axis(), 0.1).into_inner();
        assert!(!search.offer(&Matrix3::identity()) && !search.offer(&aslant));
        assert!((0..3).all(|column| !search.turn_about(&Matrix3::identity(), column)));
        assert_eq!(search.best.1, Matrix3::identity());
    }

    #[test]
    fn a_turn_about_the_right_axis_finds_the_box_and_one_about_another_does_not() {
        let mut about = search(Vector::z() * 0.4, 0.0);
        assert!(about.turn_about(&Matrix3::identity(), 2) && (about.best.0 - 1200.0).abs() < 1e-6);
        let axes = about.best.1;
        assert!((axes.tr_mul(&axes) - Matrix3::identity()).amax() < 1e-12 && axes.determinant() > 0.0);
        let mut about = search(Vector::z() * 0.4, 0.0);
        about.turn_about(&Matrix3::identity(), 0);
        assert!(about.best.0 > 1300.0);
    }

    #[test]
    fn the_descent_ends_where_no_turn_makes_the_box_smaller() {
        for turn in [[0.4, -0.9, 0.5], [0.2, 0.1, 0.3], [-0.5, 0.4, 0.7], [0.1, 0.6, -0.4]] {
            let mut search = search(Vector::from(turn), 0.0);
            let before = search.best.0;
            search.descend();
            assert!(search.best.0 < before);
            let axes = search.best.1;
            assert!((0..3).all(|column| !search.turn_about(&axes, column)), "{turn:?}");
        }
    }
}
