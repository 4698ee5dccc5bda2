//! Convex pieces of a body of revolution, as half planes of (ρ, z), and how deep a point is in one that moves straight.

use crate::geometry::Vector;

/// A half plane a ρ + b z <= c with a² + b² = 1, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HalfPlane {
    pub a: f64,
    pub b: f64,
    pub c: f64,
}

impl HalfPlane {
    /// The half plane left of the way from (r, z) to (s, w) on a profile that runs upwards; `None` when the points are one.
    pub fn below_line([r, z]: [f64; 2], [s, w]: [f64; 2]) -> Option<Self> {
        let length = (s - r).hypot(w - z);
        let (a, b) = ((w - z) / length, (r - s) / length);
        (length > 0.0).then_some(Self { a, b, c: a * r + b * z })
    }
}

/// The largest excess over the half planes: inside, minus the distance from the border; outside, at most the distance from it, and at
/// least 1/√2 of that at right corners. Convex, and it changes by no more than the point moves.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Convex {
    pub planes: Vec<HalfPlane>,
}

/// A lower and an upper bound of the least excess along a way, mm, and how much lower it may be elsewhere in a cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Least {
    pub low: f64,
    pub high: f64,
    /// Lower bound for all points of the cube.
    pub deep: f64,
}

/// Where on its way a part has the least excess over a point, and a linear function below the excess throughout a cube around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lowest {
    pub least: Least,
    /// Part of the way at which the excess is `least.high`, 0 to 1.
    pub at: f64,
    /// Value of the function at the cube's centre, mm.
    pub value: f64,
    /// Its gradient, in the body's frame.
    pub normal: Vector,
}

/// A cube around a point, and what is asked about it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cube {
    /// Half its side, mm.
    pub half: f64,
    /// Half its diagonal, mm.
    pub radius: f64,
    /// Its axes in the body's frame.
    pub axes: [Vector; 3],
    /// An excess of its centre at which it is wholly inside for sure: nothing lower is looked for.
    pub inside: f64,
    /// An excess of all its points at which it is outside for sure: nothing higher is looked for.
    pub outside: f64,
}

impl Cube {
    /// How much the excess changes from the centre to a corner at most, given its gradient at the centre.
    fn spread(&self, normal: &Vector) -> f64 {
        let along_axes = self.axes.iter().map(|axis| axis.dot(normal).abs()).sum::<f64>();
        (self.half * along_axes).min(self.radius)
    }
}

/// The excess at a part of the way, its slope along the way, and its gradient.
struct Tangent {
    at: f64,
    value: f64,
    slope: f64,
    normal: Vector,
}

impl Tangent {
    /// Value and place of the lower of two.
    fn better(&self, best: (f64, f64)) -> (f64, f64) {
        if self.value < best.0 { (self.value, self.at) } else { best }
    }
}

/// Distance from the axis. Not `hypot`, which takes ten times as long: nothing here is so large or small that a square overflows or vanishes.
pub(super) fn rho(p: &Vector) -> f64 {
    (p.x * p.x + p.y * p.y).sqrt()
}

/// Tangents that are laid at most; half as many as reach rounding on smooth bodies.
const MOST_TANGENTS: usize = 40;

impl Convex {
    /// Where a point that starts at `q` and goes by `-travel` is deepest, the axis being z. Ends early where the cube is
    /// inside at some place, or outside at all.
    pub fn lowest(&self, q: &Vector, travel: &Vector, cube: &Cube) -> Lowest {
        let way = travel.norm();
        let start = if way > 0.0 { (q.dot(travel) / (way * way)).clamp(0.0, 1.0) } else { 0.0 };
        let first = self.tangent(q, travel, start);
        let mut best = (first.value, first.at);
        let reach = way * start.max(1.0 - start);
        // What the point moves changes the excess by no more.
        if best.0 <= cube.inside || best.0 - reach - cube.radius >= cube.outside {
            let low = best.0 - reach;
            let least = Least { low, high: best.0, deep: low - cube.radius };
            return Lowest { least, at: best.1, value: least.deep, normal: Vector::zeros() };
        }
        let found = |value: f64, normal: Vector, best: (f64, f64)| {
            let least = Least { low: value, high: best.0, deep: value - cube.spread(&normal) };
            Lowest { least, at: best.1, value, normal }
        };
        if first.slope == 0.0 || way == 0.0 {
            return found(first.value, first.normal, best);
        }
        // `before` falls, `behind` rises.
        let other = if first.slope > 0.0 { 0.0 } else { 1.0 };
        if start == other {
            return found(first.value, first.normal, best);
        }
        let second = self.tangent(q, travel, other);
        best = second.better(best);
        if (second.slope > 0.0) == (first.slope > 0.0) || second.slope == 0.0 {
            return found(second.value, second.normal, best);
        }
        let (mut before, mut behind) = if first.slope < 0.0 { (first, second) } else { (second, first) };
        let mut tangents = 0;
        loop {
            // Where the tangents meet is below the least, and a mixture of both is a plane below the excess everywhere.
            let share = behind.slope / (behind.slope - before.slope);
            let mixed = |a: f64, b: f64| share * a + (1.0 - share) * b;
            let at = ((before.slope * before.at - before.value) - (behind.slope * behind.at - behind.value))
                / (before.slope - behind.slope);
            let low = mixed(before.value - before.slope * before.at, behind.value - behind.slope * behind.at);
            let mixture = found(low, before.normal * share + behind.normal * (1.0 - share), best);
            tangents += 1;
            let close = (0.01 * cube.radius).max(1e-9);
            let is_decided = best.0 <= cube.inside || mixture.least.deep >= cube.outside;
            if is_decided || best.0 - low <= close || tangents >= MOST_TANGENTS {
                return mixture;
            }
            let next = self.tangent(q, travel, at.clamp(before.at, behind.at));
            best = next.better(best);
            if next.slope == 0.0 {
                return found(next.value, next.normal, best);
            }
            if next.slope < 0.0 {
                before = next;
            } else {
                behind = next;
            }
        }
    }

    /// The excess of (ρ, z).
    pub fn excess(&self, rho: f64, z: f64) -> f64 {
        self.planes.iter().map(|plane| plane.a * rho + plane.b * z - plane.c).fold(f64::NEG_INFINITY, f64::max)
    }

    fn tangent(&self, q: &Vector, travel: &Vector, at: f64) -> Tangent {
        let p = q - travel * at;
        let rho = rho(&p);
        let (mut value, mut which) = (f64::NEG_INFINITY, HalfPlane { a: 0.0, b: 0.0, c: 0.0 });
        for plane in &self.planes {
            let excess = plane.a * rho + plane.b * p.z - plane.c;
            if excess > value {
                (value, which) = (excess, *plane);
            }
        }
        // On the axis 0 is a gradient of ρ.
        let outwards = if rho > 0.0 { which.a / rho } else { 0.0 };
        let normal = Vector::new(outwards * p.x, outwards * p.y, which.b);
        Tangent { at, value, slope: -normal.dot(travel), normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A cylinder of radius 5 from z = 0 to 20 with a cone of 45° below it.
    fn drill() -> Convex {
        let line = |from, to| HalfPlane::below_line(from, to).unwrap();
        let top = HalfPlane { a: 0.0, b: 1.0, c: 20.0 };
        Convex { planes: vec![line([0.0, -5.0], [5.0, 0.0]), line([5.0, 0.0], [5.0, 20.0]), top] }
    }

    fn cube(half: f64) -> Cube {
        let radius = half * 3f64.sqrt();
        Cube { half, radius, axes: [Vector::x(), Vector::y(), Vector::z()], inside: -radius, outside: 0.0 }
    }

    #[test]
    fn depths_known_by_hand() {
        let cube = cube(0.1);
        let least = |q: [f64; 3], travel: [f64; 3]| drill().lowest(&q.into(), &travel.into(), &cube).least;
        let near = |x: f64, y: f64| assert!((x - y).abs() < 2e-3, "{x} {y}");
        near(least([8.0, 0.0, 10.0], [0.0; 3]).low, 3.0);
        near(least([8.0, 0.0, 10.0], [1.0, 0.0, 0.0]).high, 2.0);
        near(least([8.0, 3.0, 10.0], [10.0, 0.0, 0.0]).high, -2.0); // passes 3 mm beside the axis
        near(least([0.0, 0.0, -6.0], [0.0; 3]).low, 0.5f64.sqrt()); // under the tip: 1 mm, the planes say 1/√2
        // A floor's normal is an axis of the cube: no corner is deeper than half its side.
        let floor = least([0.0, 3.0, 19.97], [5.0, 0.0, 0.0]);
        near(floor.deep, -0.03 - 0.1);
    }

    proptest! {
        /// Between the bounds is what dense sampling finds, and no point of the cube is deeper than `deep`.
        #[test]
        fn the_least_is_between_its_bounds(
            q in prop::array::uniform3(-12.0..12.0f64),
            travel in prop::array::uniform3(-9.0..9.0f64),
            half in 0.01..1.0f64,
            corner in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let (body, travel) = (drill(), Vector::from(travel));
            let sampled = |q: Vector| (0..=2000).map(|i| {
                let p = q - travel * (f64::from(i) / 2000.0);
                body.excess(p.x.hypot(p.y), p.z)
            }).fold(f64::INFINITY, f64::min);
            let radius = half * 3f64.sqrt();
            let Lowest { least: found, at, value, normal } = body.lowest(&q.into(), &travel, &cube(half));
            let exact = sampled(q.into());
            let step = travel.norm() / 4000.0 + 1e-9;
            prop_assert!(found.low <= exact + 1e-9 && (found.high >= exact - step), "{found:?} {exact}");
            let there = sampled(Vector::from(q) + Vector::from(corner) * half);
            prop_assert!(there >= found.deep - 1e-9 && there >= value + normal.dot(&(Vector::from(corner) * half)) - 1e-9);
            let p = Vector::from(q) - travel * at;
            prop_assert!((body.excess(p.x.hypot(p.y), p.z) - found.high).abs() <= 1e-9);
            // A decision is never an open one: either the bounds are near one another, or one of them decides.
            let decided = found.high <= -radius || found.deep >= 0.0 || found.low >= radius;
            prop_assert!(decided || found.high - found.low <= 0.011 * radius, "{found:?}");
        }
    }
}
