//! The planes that touch a convex solid along one of its edges, represented by their normals.

use crate::geometry::Vector;
use crate::geometry::hull::Edge;

/// The outward normals of planes that touch the solid along one edge: a great-circle arc between the normals of the
/// edge's two faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub(super) ends: [Vector; 2],
    /// Unit tangent at the first end, toward the second.
    tangent: Vector,
    /// Unit direction of the edge: the arc's axis.
    pub(super) edge: Vector,
    /// Angle of the arc, rad, below π.
    pub(super) angle: f64,
}

impl Arc {
    /// The arc of an edge; `None` when the normals of its two faces are equal to rounding.
    pub(super) fn new(edge: &Edge, normals: &[Vector]) -> Option<Self> {
        let [from, to] = edge.faces.map(|face| normals[face as usize]);
        let tangent = (to - from * from.dot(&to)).try_normalize(1e-12)?;
        Some(Self {
            ends: [from, to],
            tangent,
            edge: from.cross(&tangent),
            angle: tangent.dot(&to).atan2(from.dot(&to)),
        })
    }

    /// The normal at an angle from the first end, rad.
    fn at(&self, angle: f64) -> Vector {
        let (sin, cos) = angle.sin_cos();
        self.ends[0] * cos + self.tangent * sin
    }

    /// The normal halfway.
    pub(super) fn middle(&self) -> Vector {
        (self.ends[0] + self.ends[1]).normalize()
    }

    /// The part between two angles from the first end, rad.
    pub(super) fn part(&self, low: f64, high: f64) -> Self {
        self.between([self.at(low), self.at(high)], high - low)
    }

    pub(super) fn halves(&self) -> [Self; 2] {
        let middle = self.middle();
        [[self.ends[0], middle], [middle, self.ends[1]]].map(|ends| self.between(ends, 0.5 * self.angle))
    }

    fn between(&self, ends: [Vector; 2], angle: f64) -> Self {
        Self { ends, tangent: self.edge.cross(&ends[0]), edge: self.edge, angle }
    }

    /// The parts of this arc whose normals are perpendicular to some normal of `other`: those at which the two ends of `other` lie on
    /// different sides of the plane perpendicular to the normal. At most two.
    pub(super) fn meets(&self, other: &Self) -> [Option<Self>; 2] {
        /// A cosine below this rounding error counts as perpendicular.
        const ROUNDING: f64 = 1e-12;
        let sides = self.ends.map(|n| other.ends.map(|m| n.dot(&m)));
        let all = sides.as_flattened();
        if all.iter().all(|&x| x > ROUNDING) || all.iter().all(|&x| x < -ROUNDING) {
            return [None; 2];
        }
        // m·n(φ) = (m·n0) cos φ + (m·t) sin φ changes sign at most once in less than half a turn.
        let zero = |m: &Vector| {
            let angle = (-m.dot(&self.ends[0])).atan2(m.dot(&self.tangent));
            let angle = if angle < 0.0 { angle + std::f64::consts::PI } else { angle };
            angle.min(self.angle)
        };
        let [z0, z1] = [zero(&other.ends[0]), zero(&other.ends[1])];
        let cuts = [0.0, z0.min(z1), z0.max(z1), self.angle];
        let part = |i: usize| {
            let n = self.at(f64::midpoint(cuts[i], cuts[i + 1]));
            let opposite = n.dot(&other.ends[0]) * n.dot(&other.ends[1]) <= 0.0;
            (opposite && cuts[i + 1] > cuts[i]).then(|| self.part(cuts[i], cuts[i + 1]))
        };
        // Between the zeros the ends are on different sides or the same; outside of both it is the other way round.
        match part(1) {
            Some(between) => [Some(between), None],
            None => [part(0), part(2)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn arc(from: Vector, to: Vector) -> Arc {
        let tangent = (to - from * from.dot(&to)).normalize();
        Arc { ends: [from, to], tangent, edge: from.cross(&tangent), angle: from.angle(&to) }
    }

    #[test]
    fn arcs_meet_where_a_normal_of_the_other_is_perpendicular() {
        // From x to y against the arc from x to z: n = (cos φ, sin φ, 0) is perpendicular to m = (cos θ, 0, sin θ) when
        // cos φ cos θ = 0: at φ = 90° for all m, and for m = z at all φ.
        let [first, second] = arc(Vector::x(), Vector::y()).meets(&arc(Vector::x(), Vector::z()));
        assert!(first.is_some() && second.is_none());
        // Twenty degrees about x each: never perpendicular.
        let near = |angle: f64| Vector::new(angle.cos(), angle.sin(), 0.0);
        assert!(arc(near(-0.2), near(0.2)).meets(&arc(near(0.3), near(0.5))).iter().all(Option::is_none));
        // From 0 to 0.4 rad against π/2 to π/2 + 0.1: perpendicular from 0 to 0.1 rad.
        let [part, _] = arc(near(0.0), near(0.4))
            .meets(&arc(near(std::f64::consts::FRAC_PI_2), near(std::f64::consts::FRAC_PI_2 + 0.1)));
        let part = part.unwrap();
        assert!((part.ends[0] - near(0.0)).norm() < 1e-9 && (part.ends[1] - near(0.1)).norm() < 1e-9);
        let [first, second] = part.halves();
        assert!((first.ends[1] - near(0.05)).norm() < 1e-9 && (second.middle() - near(0.075)).norm() < 1e-9);
        assert!((second.part(0.01, 0.04).middle() - near(0.075)).norm() < 1e-9);
    }

    proptest! {
        #[test]
        fn the_parts_that_meet_are_those_with_a_perpendicular_normal(
            ends in prop::array::uniform4(prop::array::uniform3(-1.0..1.0_f64)),
        ) {
            let ends = ends.map(Vector::from);
            prop_assume!(ends.iter().all(|end| end.norm() > 0.1));
            let [from, to, other_from, other_to] = ends.map(|end| end.normalize());
            prop_assume!(from.cross(&to).norm() > 0.1 && other_from.cross(&other_to).norm() > 0.1);
            let (this, other) = (arc(from, to), arc(other_from, other_to));
            let parts = this.meets(&other);
            for step in 0..=100 {
                let normal = this.at(this.angle * f64::from(step) / 100.0);
                // Between its ends the other arc passes through the plane square to the normal.
                let sides = [other_from, other_to].map(|end| end.dot(&normal));
                if sides.iter().any(|side| side.abs() < 1e-6) {
                    continue;
                }
                let holds = |part: &Arc| {
                    part.ends[0].angle(&normal) <= part.angle + 1e-9 && part.ends[1].angle(&normal) <= part.angle + 1e-9
                };
                prop_assert_eq!(parts.iter().flatten().any(holds), sides[0] * sides[1] < 0.0, "{}", step);
            }
        }
    }
}
