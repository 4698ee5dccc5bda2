//! Lower bounds on the volume of the boxes with two neighbouring faces on two given edges of a solid.
//!
//! For two edges, the box's first normal n runs along the first edge's [`Arc`], with φ as its angle. The second normal is perpendicular to
//! n and to the direction e of the other edge. With s = e×n and r = n×s = e - n (n·e), both of length σ = √(1 - (n·e)²), the box's axes are
//! n, s/σ and r/σ.
//!
//! The bounds use, for each axis in the middle of a part of the arc, the two corners that are farthest apart along it. If d is the vector
//! from one to the other, no width along an axis u is less than d·u. Each bound is a product of three linear functions over the part, each
//! at least zero. Such a product is smallest at one end of the part, because its logarithm is concave.
//!
//! *By numerators*: d·n and d·s are sinusoids of φ and concave where positive, so they lie above the line between their ends. d·r = d·e -
//! (d·n)(n·e) and σ² have second derivatives of at most 2ρ|d'| and 2ρ², where ρ and |d'| are the lengths of the parts of e and d
//! perpendicular to the first edge. Over an angle δ they deviate from the line between their ends by at most δ²/8 times these bounds.
//!
//! *By the tilt*: when the two edges are nearly perpendicular and σ is small, linear bounds of the numerators say little about s/σ. But
//! s·(n×e₁) = -e·e₁. The axes s/σ and r/σ are therefore those of the frame of n and the first edge's direction e₁, turned about n by the
//! angle with sine e·e₁/σ. The widths along the unturned frame are sinusoids, and turning reduces each width by at most |d| √2 |e·e₁|/σ.

use super::arc::Arc;
use crate::geometry::Vector;

/// The boxes with one normal on a part of an arc and one perpendicular to another edge.
pub(super) struct Family<'a> {
    part: &'a Arc,
    /// Unit direction of the other edge, e.
    along: &'a Vector,
    /// For each axis, the vector between the two corners that are farthest apart along it, mm. The width along an axis is at least the
    /// component of this vector along it.
    spans: [Vector; 3],
    /// Margin added to each width, mm.
    margin: f64,
    /// e·e₁.
    cosine: f64,
    /// ρ.
    rho: f64,
    /// ρδ²/4: the largest deviation of n·e times a sinusoid of amplitude 1 from the line between its ends.
    bend: f64,
    /// σ² at both ends of the part.
    squares: [f64; 2],
}

impl<'a> Family<'a> {
    pub(super) fn new(part: &'a Arc, along: &'a Vector, spans: [Vector; 3], margin: f64) -> Self {
        let cosine = part.edge.dot(along);
        let rho = (1.0 - cosine * cosine).max(0.0).sqrt();
        let squares = part.ends.map(|n| 1.0 - n.dot(along).powi(2));
        Self { part, along, spans, margin, cosine, rho, bend: rho * part.angle.powi(2) / 4.0, squares }
    }

    /// Lower bound on the volume of the family's boxes, mm³: the numerators of the widths, divided by the largest σ.
    pub(super) fn least_by_numerators(&self) -> f64 {
        let sigma = self.largest_sigma();
        let [first, second, third] = self.numerators();
        least_product(&[first, second.map(|x| x / sigma), third.map(|x| x / sigma)], [self.margin; 3])
    }

    fn largest_sigma(&self) -> f64 {
        (self.squares[0].max(self.squares[1]) + self.rho * self.bend).min(1.0).sqrt()
    }

    /// Linear lower bounds of d·n, d·s and d·r (the first two where they are positive), given by their values at the ends, mm.
    fn numerators(&self) -> [[f64; 2]; 3] {
        let [first, second, third] = &self.spans;
        let across = second.cross(self.along);
        let reach = (third - self.part.edge * self.part.edge.dot(third)).norm();
        [
            self.part.ends.map(|n| first.dot(&n)),
            self.part.ends.map(|n| across.dot(&n)),
            self.part.ends.map(|n| third.dot(self.along) - third.dot(&n) * n.dot(self.along) - reach * self.bend),
        ]
    }

    /// Lower bound on the volume of the family's boxes, mm³, by the unturned frames; `across` is the second axis in the middle of the part.
    pub(super) fn least_by_tilt(&self, across: &Vector) -> f64 {
        let least_square = self.squares[0].min(self.squares[1]) - self.rho * self.bend;
        if least_square <= self.cosine * self.cosine {
            return 0.0;
        }
        let tilt = (2.0 / least_square).sqrt() * self.cosine.abs();
        let still = self.part.edge * self.part.edge.dot(across).signum();
        let [first, second, third] = &self.spans;
        let lines = [
            self.part.ends.map(|n| first.dot(&n)),
            [still.dot(second) - tilt * second.norm(); 2],
            self.part.ends.map(|n| n.cross(&still).dot(third) - tilt * third.norm()),
        ];
        least_product(&lines, [self.margin; 3])
    }
}

/// The least product of linear functions over an interval, each given by its values at the two ends and raised by its margin. A function
/// that is negative at one end counts as zero everywhere.
pub(super) fn least_product<const N: usize>(lines: &[[f64; 2]; N], margins: [f64; N]) -> f64 {
    let at = |end: usize| {
        let values = lines.iter().map(|line| if line[0].min(line[1]) < 0.0 { 0.0 } else { line[end] });
        values.zip(margins).map(|(value, margin)| value + margin).product::<f64>()
    };
    at(0).min(at(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::geometry::hull::{Hull, Solid};
    use proptest::prelude::*;

    /// The vector from the lowest to the highest corner along an axis.
    fn span(solid: &Solid, axis: &Vector) -> Vector {
        let height = |p: &&Point| axis.dot(&p.coords);
        let highest = solid.vertices.iter().max_by(|p, q| height(p).total_cmp(&height(q))).unwrap();
        let lowest = solid.vertices.iter().min_by(|p, q| height(p).total_cmp(&height(q))).unwrap();
        highest - lowest
    }

    /// The axes of the family's box with a given normal.
    fn axes(normal: &Vector, along: &Vector) -> [Vector; 3] {
        let second = along.cross(normal).normalize();
        [*normal, second, normal.cross(&second)]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        /// No box of a family is smaller than its bounds; on a short part, the better bound is close to the volume of the box in the
        /// middle.
        #[test]
        fn bounds_are_below_and_close(
            corners in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 4..16),
            flat in prop_oneof![Just(1.0), Just(0.1), Just(0.01)],
            (i, j) in (any::<prop::sample::Index>(), any::<prop::sample::Index>()),
            halvings in prop::collection::vec(0..2_usize, 0..24),
            margin in prop_oneof![Just(0.0), Just(0.1)],
        ) {
            let points: Vec<Point> = corners.iter().map(|[x, y, z]| Point::new(*x, *y, z * flat)).collect();
            let Some(Hull::Solid(solid)) = Hull::of(points.iter()) else { return Ok(()) };
            let normals = solid.normals();
            let arcs: Vec<Arc> = solid.edges().iter().filter_map(|edge| Arc::new(edge, &normals)).collect();
            let (moving, other) = (i.get(&arcs), j.get(&arcs));
            let Some(whole) = moving.meets(other).into_iter().flatten().next() else { return Ok(()) };
            let part = halvings.iter().fold(whole, |part, &half| part.halves()[half]);
            let sines = part.ends.map(|n| n.cross(&other.edge).norm());
            prop_assume!(sines[0].min(sines[1]) > 1e-4); // where the frame turns too fast, parts are not divided for ever
            let volume = |normal: &Vector| -> f64 {
                axes(normal, &other.edge).iter().map(|u| u.dot(&span(&solid, u)) + margin).product()
            };
            let middle = axes(&part.middle(), &other.edge);
            let family = Family::new(&part, &other.edge, middle.map(|u| span(&solid, &u)), margin);
            let bounds = [family.least_by_numerators(), family.least_by_tilt(&middle[1])];
            for x in (0..=16).map(|k| f64::from(k) / 16.0) {
                let normal = part.part(x * part.angle, part.angle).ends[0];
                let at = volume(&normal);
                prop_assert!(bounds[0].max(bounds[1]) <= at * (1.0 + 1e-9) + 1e-12, "{bounds:?} {at} at {x}");
                let (across, [low, high]) = (other.edge.cross(&normal), family.numerators()[2]);
                prop_assert!(family.largest_sigma() >= across.norm() - 1e-12);
                prop_assert!(family.spans[2].dot(&normal.cross(&across)) >= low + x * (high - low) - 1e-12);
            }
            let thinnest = middle.iter().map(|u| u.dot(&span(&solid, u))).fold(f64::INFINITY, f64::min);
            if part.angle < 1e-5 && thinnest > 0.01 && sines[0].min(sines[1]) > 0.1 {
                prop_assert!(bounds[0] > (1.0 - 5e-3) * volume(&part.middle()), "{bounds:?}");
            }
        }

        /// Boxes around a cuboid that are turned about one of the cuboid's edges: the bound by the tilt equals their volume, even when a
        /// normal is nearly along the other edge.
        #[test]
        fn perpendicular_edges_turn_about_the_first(sides in prop::array::uniform3(0.1..10.0_f64), away in 1e-6..0.1_f64) {
            let corners = (0..8).map(|i| Point::from([0, 1, 2].map(|k| if i >> k & 1 == 1 { sides[k] } else { 0.0 })));
            let Some(Hull::Solid(solid)) = Hull::of(corners.collect::<Vec<_>>().iter()) else { panic!("a cuboid is a solid") };
            let normals = solid.normals();
            let arcs: Vec<Arc> = solid.edges().iter().filter_map(|edge| Arc::new(edge, &normals)).collect();
            for (moving, other) in arcs.iter().flat_map(|a| arcs.iter().map(move |b| (a, b))) {
                if moving.edge.dot(&other.edge).abs() > 0.5 {
                    continue;
                }
                let part = moving.part(away, 1.5 * away);
                let middle = axes(&part.middle(), &other.edge);
                let family = Family::new(&part, &other.edge, middle.map(|u| span(&solid, &u)), 0.0);
                let own: f64 = sides.iter().product();
                prop_assert!(family.least_by_tilt(&middle[1]) > (1.0 - 1e-6) * own);
            }
        }
    }
}
