//! A part that stands beside a workpiece that turns: how deep the circle of a point of the stock comes into it.

use super::convex::Least;
use super::skin::Skin;
use crate::geometry::{Isometry, Point, Vector};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

/// Travel to which the place is found where the circle is deepest, mm.
const STEP_MM: f64 = 0.02;

/// The circle of a point, and the part's way.
pub(super) struct Ringed<'a> {
    pub skin: &'a Skin,
    /// Takes the frame of the axis, its z, to the part's at first.
    pub part_from_axis: &'a Isometry,
    /// The part's way in its own frame, mm.
    pub travel: &'a Vector,
}

/// Angles and parts of the way, and the distance in their middle less how far a point moves from there.
struct Open {
    low: f64,
    angles: [f64; 2],
    way: [f64; 2],
}

impl Ringed<'_> {
    /// Distance of the circle with (ρ, z) from the part's surface, negative inside: bounds of its least, `deep` for all circles nearer than `spread`. Ends early where
    /// it is `inside` at some place or `outside` at all.
    pub fn least(&self, rho: f64, z: f64, spread: f64, [inside, outside]: [f64; 2]) -> Least {
        let length = self.travel.norm();
        let reach =
            |angles: [f64; 2], way: [f64; 2]| 0.5 * ((angles[1] - angles[0]) * rho + (way[1] - way[0]) * length);
        let measured = |angles: [f64; 2], way: [f64; 2]| {
            let (sin, cos) = f64::midpoint(angles[0], angles[1]).sin_cos();
            let at = self.part_from_axis * Point::new(rho * cos, rho * sin, z);
            let at = at - self.travel * f64::midpoint(way[0], way[1]);
            let reach = reach(angles, way);
            let distance = self.skin.signed_distance_mm(&at, reach + spread + outside + 1.0);
            (distance, Open { low: distance - reach, angles, way })
        };
        let mut open = BinaryHeap::new();
        let (mut high, first) = measured([-PI, PI], [0.0, 1.0]);
        open.push(first);
        while let Some(Open { low, angles, way }) = open.pop() {
            let is_decided = high <= inside || low - spread >= outside;
            if is_decided || reach(angles, way) <= STEP_MM {
                return Least { low, high, deep: low - spread };
            }
            let halves = |[from, to]: [f64; 2]| [[from, f64::midpoint(from, to)], [f64::midpoint(from, to), to]];
            let is_turn = (angles[1] - angles[0]) * rho >= (way[1] - way[0]) * length;
            for k in 0..2 {
                let part = if is_turn { (halves(angles)[k], way) } else { (angles, halves(way)[k]) };
                let (distance, next) = measured(part.0, part.1);
                high = high.min(distance);
                open.push(next);
            }
        }
        Least { low: high, high, deep: high - spread }
    }
}

impl Ord for Open {
    /// The least first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.low.total_cmp(&self.low)
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

#[cfg(test)]
mod tests {
    use super::*;
    use obbtree::cases::meshes;
    use proptest::prelude::*;
    use std::sync::Arc;

    proptest! {
        #[test]
        fn the_least_is_between_its_bounds(
            which in 0..64usize,
            at in prop::array::uniform2(0.0..2.0f64),
            offset in prop::array::uniform3(-1.0..1.0f64),
            travel in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let subjects = meshes::subjects();
            let mesh = Arc::new(subjects[which % subjects.len()].mesh.clone());
            prop_assume!(mesh.edge_report().is_watertight());
            let size = mesh.vertices().iter().map(|v| v.coords.amax()).fold(0.0, f64::max);
            let skin = Skin::new(&mesh);
            let part_from_axis = Isometry::translation(offset[0] * size, offset[1] * size, offset[2] * size);
            let travel = Vector::from(travel) * size;
            let ringed = Ringed { skin: &skin, part_from_axis: &part_from_axis, travel: &travel };
            let [rho, z] = at.map(|x| x * size);
            let found = ringed.least(rho, z, 0.0, [f64::NEG_INFINITY, f64::INFINITY]);
            let mut sampled = f64::INFINITY;
            for i in 0..48 {
                for k in 0..=24 {
                    let (sin, cos) = (f64::from(i) * PI / 24.0).sin_cos();
                    let p = part_from_axis * Point::new(rho * cos, rho * sin, z) - travel * (f64::from(k) / 24.0);
                    sampled = sampled.min(skin.signed_distance_mm(&p, f64::INFINITY));
                }
            }
            let between = rho * PI / 48.0 + travel.norm() / 48.0;
            prop_assert!(found.low <= sampled + 1e-9 && found.high >= sampled - between, "{found:?} {sampled}");
            prop_assert!(found.high - found.low <= 2.0 * STEP_MM);
        }
    }
}
