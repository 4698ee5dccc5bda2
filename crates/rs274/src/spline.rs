//! G5 and G5.1: Bézier curves in the XY plane, as straight feed moves (LinuxCNC, "G5 Cubic Spline", "G5.1 Quadratic Spline").
//!
//! G5.1 has one control point, I and J from the start. G5 has two: I and J from the start, P and Q from the end; without I and J the
//! first continues the spline before, a mirror image of its last.

use super::canonical::Plane;
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::Values;
use super::offsets::Values9;

/// Greatest distance of a spline from the chords that stand for it, mm.
pub const SPLINE_CHORD_MM: f64 = 1e-3;

/// Most chords of one spline.
const MAX_CHORDS: f64 = 100_000.0;

type Point = [f64; 2];

impl Interpreter<'_> {
    pub(super) fn spline(&mut self, values: &Values, code: i32) -> Result<(), Fault> {
        let fault = |cause| values.motion_fault(cause);
        if self.compensation.on().is_some() {
            return Err(fault(Cause::NotAllowed("a spline while cutter compensation is on")));
        }
        if self.modes.plane != Plane::Xy {
            return Err(fault(Cause::NotAllowed("a spline outside the XY plane (G17)")));
        }
        if let Some(letter) = "zabcuvw".chars().find(|&letter| values.has(letter)) {
            return Err(values.fault(letter, Cause::NotAllowed("a spline moves X and Y alone")));
        }
        let target = self.target(values);
        let offset = |u: char, v: char| -> Option<Point> {
            let given = [self.take_length(values, u), self.take_length(values, v)];
            if given == [None, None] {
                return None;
            }
            let mut offset: Values9 = [0.0; 9];
            (offset[0], offset[1]) = (given[0].unwrap_or(0.0), given[1].unwrap_or(0.0));
            self.offsets.to_machine_vector(&mut offset);
            Some([offset[0], offset[1]])
        };
        let (start, end) = ([self.position[0], self.position[1]], [target[0], target[1]]);
        let first = offset('i', 'j');
        let plus = |a: Point, b: Point| [a[0] + b[0], a[1] + b[1]];
        let (points, last) = if code == 51 {
            let first = plus(start, first.ok_or_else(|| fault(Cause::Missing("I or J, the control point,")))?);
            (cubic(start, first, end), None)
        } else {
            let last = offset('p', 'q').ok_or_else(|| fault(Cause::Missing("P and Q, the second control point,")))?;
            let missing = "I and J, the first control point; no spline goes before that it could continue;";
            let first = first.or(self.spline_leaves).ok_or_else(|| fault(Cause::Missing(missing)))?;
            ([start, plus(start, first), plus(end, last), end], Some(last.map(|x| -x)))
        };
        let feed = self.straight_feed(&target, values)?;
        let chords = chords(&points);
        for chord in 1..=chords {
            let mut next = target;
            if chord < chords {
                [next[0], next[1]] = point_at(&points, f64::from(chord) / f64::from(chords));
            }
            self.feed_at(next, feed)?;
        }
        self.spline_leaves = last;
        Ok(())
    }
}

/// The cubic form of a quadratic curve: both its control points lie two thirds of the way to the quadratic's.
fn cubic(start: Point, control: Point, end: Point) -> [Point; 4] {
    let towards = |from: Point| [0, 1].map(|i| from[i] + 2.0 / 3.0 * (control[i] - from[i]));
    [start, towards(start), towards(end), end]
}

/// De Casteljau's construction.
fn point_at(points: &[Point; 4], t: f64) -> Point {
    [0, 1].map(|i| {
        let [a, b, c, d] = points.map(|point| point[i]);
        let between = |a: f64, b: f64| a + t * (b - a);
        let (ab, bc, cd) = (between(a, b), between(b, c), between(c, d));
        between(between(ab, bc), between(bc, cd))
    })
}

/// How many chords of equal parameter keep to [`SPLINE_CHORD_MM`]: over a step h a curve leaves its chord by no more than
/// h^2 / 8 times its greatest second derivative, which for a cubic is 6 times the greater second difference of its points.
fn chords(points: &[Point; 4]) -> u32 {
    let second = |i: usize| {
        let [x, y] = [0, 1].map(|k| points[i][k] - 2.0 * points[i + 1][k] + points[i + 2][k]);
        x.hypot(y)
    };
    let bend = 6.0 * second(0).max(second(1));
    (bend / (8.0 * SPLINE_CHORD_MM)).sqrt().ceil().clamp(1.0, MAX_CHORDS) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_and_its_cubic_form_are_one_curve() {
        // Through (0,0), (2,2), (4,0): its middle is (2,1), at a quarter (1, 3/4).
        let points = cubic([0.0, 0.0], [2.0, 2.0], [4.0, 0.0]);
        for (t, expected) in [(0.5, [2.0, 1.0]), (0.25, [1.0, 0.75])] {
            let found = point_at(&points, t);
            assert!((found[0] - expected[0]).abs() + (found[1] - expected[1]).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn chords_keep_to_their_tolerance() {
        // Second derivative 2 x |(0,0) - 2 (2,2) + (4,0)| = 8: (8 / 0.008)^(1/2) = 31.6 chords.
        let points = cubic([0.0, 0.0], [2.0, 2.0], [4.0, 0.0]);
        assert_eq!(chords(&points), 32);
        assert_eq!(chords(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]), 1);
    }
}
