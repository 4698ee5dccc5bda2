//! Lines and arcs in a plane, shifted sideways, and where they meet: the geometry of cutter compensation.

use std::f64::consts::TAU;

/// A point or a vector of the plane, mm.
pub(super) type Point = [f64; 2];

/// Places that differ by less than this along a curve, mm, are one: rounding of positions of up to 10 m.
pub(super) const ROUNDING_MM: f64 = 1e-9;

/// Lengths along a curve, mm for lines and radians for arcs.
const ROUNDING: f64 = ROUNDING_MM;

/// An element of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Curve {
    /// A straight line. `direction` has length 1; on the line that leads in it is the programmed one, not that from `from` to `to`.
    Line { from: Point, to: Point, direction: Point },
    /// An arc that turns by `sweep`, radians, positive counter-clockwise. Its radius may change along it.
    Arc { centre: Point, from: Point, to: Point, sweep: f64 },
}

pub(super) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// a + s b.
pub(super) fn plus_scaled(a: Point, s: f64, b: Point) -> Point {
    [a[0] + s * b[0], a[1] + s * b[1]]
}

pub(super) fn norm(a: Point) -> f64 {
    a[0].hypot(a[1])
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// A vector turned by a quarter, counter-clockwise.
fn left_of(a: Point) -> Point {
    [-a[1], a[0]]
}

/// The angle from direction `a` to direction `b`, radians, above -pi and up to pi, positive counter-clockwise.
pub(super) fn turn(a: Point, b: Point) -> f64 {
    cross(a, b).atan2(dot(a, b))
}

impl Curve {
    pub fn from(&self) -> Point {
        match *self {
            Self::Line { from, .. } | Self::Arc { from, .. } => from,
        }
    }

    pub fn to(&self) -> Point {
        match *self {
            Self::Line { to, .. } | Self::Arc { to, .. } => to,
        }
    }

    /// Unit direction of travel at the start.
    pub fn direction_at_start(&self) -> Point {
        self.direction(self.from())
    }

    /// Unit direction of travel at the end.
    pub fn direction_at_end(&self) -> Point {
        self.direction(self.to())
    }

    fn direction(&self, at: Point) -> Point {
        match *self {
            Self::Line { direction, .. } => direction,
            Self::Arc { centre, sweep, .. } => {
                let radial = minus(at, centre);
                left_of(radial).map(|x| x * sweep.signum() / norm(radial))
            }
        }
    }

    /// How much the programmed curve bends to its left, 1/mm, when this one is it shifted to the left by `left_mm`.
    pub fn bend(&self, left_mm: f64) -> f64 {
        match *self {
            Self::Line { .. } => 0.0,
            Self::Arc { centre, from, sweep, .. } => (norm(minus(from, centre)).copysign(sweep) + left_mm).recip(),
        }
    }

    /// The curve shifted to the left of its direction of travel, or to the right by a negative distance, mm. An arc must stay
    /// an arc: its radius larger than a shift towards its centre.
    pub fn shifted(&self, left_mm: f64) -> Self {
        let shift = |point, direction| plus_scaled(point, left_mm, left_of(direction));
        let from = shift(self.from(), self.direction_at_start());
        let to = shift(self.to(), self.direction_at_end());
        match *self {
            Self::Line { direction, .. } => Self::Line { from, to, direction },
            Self::Arc { centre, sweep, .. } => Self::Arc { centre, from, to, sweep },
        }
    }

    /// How far behind the start a point of the curve is, mm or radians.
    fn behind_start(&self, point: Point) -> f64 {
        match *self {
            Self::Line { from, direction, .. } => dot(direction, minus(point, from)),
            Self::Arc { centre, from, sweep, .. } => {
                (turn(minus(from, centre), minus(point, centre)) * sweep.signum()).rem_euclid(TAU)
            }
        }
    }

    /// How far before the end a point of the curve is, mm or radians.
    pub fn before_end(&self, point: Point) -> f64 {
        match *self {
            Self::Line { to, direction, .. } => dot(direction, minus(to, point)),
            Self::Arc { centre, to, sweep, .. } => {
                (turn(minus(point, centre), minus(to, centre)) * sweep.signum()).rem_euclid(TAU)
            }
        }
    }

    /// Its length, mm or radians.
    fn extent(&self) -> f64 {
        match *self {
            Self::Line { from, to, direction } => dot(direction, minus(to, from)),
            Self::Arc { sweep, .. } => sweep.abs(),
        }
    }

    /// The part of the curve that ends at one of its points; `None` when the point lies before its start.
    pub fn ending_at(&self, point: Point) -> Option<Self> {
        let cut = self.before_end(point);
        (-ROUNDING..=self.extent() + ROUNDING).contains(&cut).then(|| match *self {
            Self::Line { from, direction, .. } => Self::Line { from, to: point, direction },
            Self::Arc { centre, from, sweep, .. } => {
                Self::Arc { centre, from, to: point, sweep: sweep - cut.copysign(sweep) }
            }
        })
    }

    /// The part of the curve that starts at one of its points; `None` when the point lies behind its end.
    pub fn starting_at(&self, point: Point) -> Option<Self> {
        let cut = self.behind_start(point);
        (-ROUNDING..=self.extent() + ROUNDING).contains(&cut).then(|| match *self {
            Self::Line { to, direction, .. } => Self::Line { from: point, to, direction },
            Self::Arc { centre, to, sweep, .. } => {
                Self::Arc { centre, from: point, to, sweep: sweep - cut.copysign(sweep) }
            }
        })
    }

    /// Where the whole lines or circles that two curves lie on meet. The circle of `self` goes through its end, that of
    /// `other` through its start.
    pub fn meets(&self, other: &Self) -> [Option<Point>; 2] {
        match (*self, *other) {
            (Self::Line { to: p, direction: d, .. }, Self::Line { from: q, direction: e, .. }) => {
                // p + t d = q + u e, crossed with e.
                let t = cross(minus(q, p), e) / cross(d, e);
                [t.is_finite().then(|| plus_scaled(p, t, d)), None]
            }
            (Self::Line { to, direction, .. }, Self::Arc { centre, from, .. }) => {
                line_and_circle(to, direction, centre, norm(minus(from, centre)))
            }
            (Self::Arc { centre, to, .. }, Self::Line { from, direction, .. }) => {
                line_and_circle(from, direction, centre, norm(minus(to, centre)))
            }
            (Self::Arc { centre: c, to, .. }, Self::Arc { centre: d, from, .. }) => {
                let (r, s, distance) = (norm(minus(to, c)), norm(minus(from, d)), norm(minus(d, c)));
                // The chord the circles share is at right angles to the line of centres, at this distance from the first.
                let along = (distance * distance + r * r - s * s) / (2.0 * distance);
                let axis = minus(d, c).map(|x| x / distance);
                line_and_circle(plus_scaled(c, along, axis), left_of(axis), c, r)
            }
        }
    }
}

impl Curve {
    /// This curve up to where it meets another one, and that one from there on; where they meet twice, the place nearest to this curve's end.
    pub fn cut_where_they_meet(&self, other: &Self) -> Option<(Self, Self)> {
        let parts = |point: Point| {
            let parts = (self.ending_at(point)?, other.starting_at(point)?);
            Some((self.before_end(point), parts))
        };
        let meetings = self.meets(other).into_iter().flatten().filter_map(parts);
        meetings.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, parts)| parts)
    }
}

fn line_and_circle(through: Point, direction: Point, centre: Point, radius: f64) -> [Option<Point>; 2] {
    let foot = plus_scaled(through, dot(direction, minus(centre, through)), direction);
    let half_squared = radius * radius - dot(minus(foot, centre), minus(foot, centre));
    if half_squared.is_nan() || half_squared < 0.0 {
        return [None, None];
    }
    let half = half_squared.sqrt();
    [Some(plus_scaled(foot, half, direction)), Some(plus_scaled(foot, -half, direction))]
}

/// The arc from a point to the end of the arc `shifted`, with the direction that one has there; `turns` of it. `None` where
/// there is none that turns the same way round.
pub(super) fn leading_in(start: Point, shifted: &Curve, turns: i32) -> Option<Curve> {
    let Curve::Arc { centre: old, to, sweep, .. } = *shifted else { return None };
    // The centre lies from the end towards the old one, t further, as far from the start as from the end:
    // |w - t u| = t for w = start - to, so t = w.w / 2 w.u.
    let inwards = minus(old, to).map(|x| x / norm(minus(old, to)));
    let w = minus(start, to);
    let t = dot(w, w) / (2.0 * dot(w, inwards));
    if !(t.is_finite() && t > ROUNDING_MM) {
        return None;
    }
    let centre = plus_scaled(to, t, inwards);
    let angle = (turn(minus(start, centre), minus(to, centre)) * sweep.signum()).rem_euclid(TAU);
    let sweep = (angle + f64::from(turns - 1) * TAU).copysign(sweep);
    Some(Curve::Arc { centre, from: start, to, sweep })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn assert_near(a: Point, b: Point) {
        assert!(norm(minus(a, b)) < 1e-12, "{a:?} is not {b:?}");
    }

    /// Half of the circle of radius 5 about (5, 0), over the top from the origin to (10, 0).
    fn over() -> Curve {
        Curve::Arc { centre: [5.0, 0.0], from: [0.0, 0.0], to: [10.0, 0.0], sweep: -PI }
    }

    #[test]
    fn left_is_outwards_on_a_clockwise_arc() {
        assert_near(over().direction_at_start(), [0.0, 1.0]);
        assert_near(over().direction_at_end(), [0.0, -1.0]);
        let shifted = over().shifted(2.0);
        assert_near(shifted.from(), [-2.0, 0.0]);
        assert_near(shifted.to(), [12.0, 0.0]);
        assert_near(over().shifted(-2.0).to(), [8.0, 0.0]);
    }

    #[test]
    fn a_line_meets_a_circle_on_both_sides() {
        // Height 3 on a circle of radius 5: 4 to either side.
        let line = Curve::Line { from: [-9.0, 3.0], to: [0.0, 3.0], direction: [1.0, 0.0] };
        let [a, b] = line.meets(&over());
        assert_near(a.unwrap(), [9.0, 3.0]);
        assert_near(b.unwrap(), [1.0, 3.0]);
        let above = Curve::Line { from: [-9.0, 6.0], to: [0.0, 6.0], direction: [1.0, 0.0] };
        assert_eq!(above.meets(&over()), [None, None]);
    }

    #[test]
    fn circles_meet_on_their_chord() {
        // Radius 5 about (5, 0) and about (13, 0): the chord at x 9, 3 high.
        let next = Curve::Arc { centre: [13.0, 0.0], from: [8.0, 0.0], to: [18.0, 0.0], sweep: -PI };
        let [a, b] = over().meets(&next);
        assert_near(a.unwrap(), [9.0, 3.0]);
        assert_near(b.unwrap(), [9.0, -3.0]);
    }

    #[test]
    fn parts_of_an_arc_keep_the_rest_of_its_angle() {
        let top = [5.0, 5.0];
        let Curve::Arc { sweep, .. } = over().ending_at(top).unwrap() else { panic!("no arc") };
        assert!((sweep + FRAC_PI_2).abs() < 1e-12);
        let part = over().starting_at(top).unwrap();
        assert_near(part.from(), top);
        // The lower half is not part of it.
        assert_eq!(over().ending_at([5.0, -5.0]), None);
        assert_eq!(over().starting_at([5.0, -5.0]), None);
    }

    #[test]
    fn an_arc_leads_in_from_anywhere_it_can() {
        // To (12, 0) going down, the centre on the x axis: from (2, 0) that is about (7, 0), half a turn; from (7, 5) a quarter.
        let shifted = over().shifted(2.0);
        let Some(Curve::Arc { centre, sweep, .. }) = leading_in([2.0, 0.0], &shifted, 1) else { panic!("no arc") };
        assert_near(centre, [7.0, 0.0]);
        assert!((sweep + PI).abs() < 1e-12);
        let Some(Curve::Arc { centre, sweep, .. }) = leading_in([7.0, 5.0], &shifted, 2) else { panic!("no arc") };
        assert_near(centre, [7.0, 0.0]);
        assert!((sweep + FRAC_PI_2 + TAU).abs() < 1e-12);
        // From beyond the end it would have to turn the other way.
        assert_eq!(leading_in([13.0, 0.0], &shifted, 1), None);
    }
}
