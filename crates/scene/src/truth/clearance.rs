//! The distance between two surfaces.
//!
//! Branch and bound over the same boxes as the verdict, with the nearest pair of nodes first. The gap between boxes is a lower bound except
//! for its own rounding. The distance of triangles is accurate to rounding (about 1e-12 mm at machine size).

use super::boxes::Bounds;
use super::{PairOracle, Posed};
use crate::geometry::Isometry;
use crate::geometry::triangle_distance;

/// The accuracy with which a clearance is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sought<'a> {
    /// No clearance: infinite for all surfaces that do not touch.
    Nothing,
    /// The distance if it is at most the cut-off; otherwise infinite.
    Distance {
        /// The cut-off, mm.
        beyond_mm: f64,
    },
    /// Only the interval between successive borders, mm, ascending, that contains the distance. The answer is the distance of some two
    /// triangles, on the same side of all borders as the least distance. The search ends much earlier when many triangles are nearly
    /// equally near.
    Borders(&'a [f64]),
}

impl Sought<'_> {
    fn beyond_mm(&self) -> f64 {
        match self {
            Self::Nothing => 0.0,
            Self::Distance { beyond_mm } => *beyond_mm,
            Self::Borders(borders) => borders.last().copied().unwrap_or(0.0),
        }
    }

    /// The squared distance, mm², below which a pair can change the answer, when the nearest pair so far is `least` apart.
    #[inline]
    fn limit(&self, least: f64) -> f64 {
        match self {
            Self::Nothing | Self::Distance { .. } => least,
            // The highest border that the least distance is above of; at the start it is the cut-off itself.
            Self::Borders(borders) => {
                let reached = |border: &&f64| *border * *border < least;
                match borders.iter().rev().find(reached) {
                    _ if least == self.beyond_mm() * self.beyond_mm() => least,
                    Some(border) => border * border,
                    None => -1.0,
                }
            }
        }
    }
}

/// Positions of the two nearest triangles in the orders of the two trees.
pub(super) type Nearest = Option<(usize, usize)>;

impl PairOracle {
    /// Euclidean distance between the surfaces, mm: exactly 0 when they touch, and infinite when it exceeds `beyond_mm`, which may itself
    /// be infinite. For a solid inside the other, it is the distance between the surfaces.
    pub fn clearance_mm(&self, a_from_b: &Isometry, beyond_mm: f64) -> f64 {
        if self.touches(a_from_b) {
            0.0
        } else {
            self.clearance_of_free_mm(a_from_b, &Sought::Distance { beyond_mm }, &mut None)
        }
    }

    /// The clearance of surfaces known not to touch, with the accuracy of `sought`. `nearest` holds the nearest triangles of the last pose.
    /// Along a path they are often nearest again, and starting from their small distance shortens the search.
    pub(super) fn clearance_of_free_mm(&self, a_from_b: &Isometry, sought: &Sought, nearest: &mut Nearest) -> f64 {
        if *sought == Sought::Nothing {
            return f64::INFINITY;
        }
        let beyond_mm = sought.beyond_mm();
        let posed = self.posed(a_from_b);
        let (a, b) = (&self.a.tree, &self.b.tree);
        let mut least = beyond_mm * beyond_mm;
        let mut found = false;
        if let Some((i, j)) = *nearest {
            let squared = triangle_distance::squared(&a.triangles[i], &posed.placement.triangle(&b.triangles[j]));
            (least, found) = if squared <= least { (squared, true) } else { (least, false) };
        }
        let moved = posed.mover.bounds(self.b.bounds());
        let mut stack = vec![(self.a.bounds().gap_squared(&moved), 0, 0, moved)];
        while let Some((gap, i, j, moved)) = stack.pop() {
            if gap > sought.limit(least) {
                continue;
            }
            let of_a = |child: u32| (a.nodes[child as usize].bounds.gap_squared(&moved), child, j, moved);
            let of_b = |child: u32| {
                let moved = posed.mover.bounds(&b.nodes[child as usize].bounds);
                (a.nodes[i as usize].bounds.gap_squared(&moved), i, child, moved)
            };
            let mut children = match (a.children(i), b.children(j)) {
                (None, None) => {
                    found |= self.leaves_squared(&posed, i, j, sought, &mut least, nearest);
                    continue;
                }
                (None, Some(children)) => children.map(of_b),
                (Some(_), Some(children)) if a.size(i) <= b.size(j) => children.map(of_b),
                (Some(children), _) => children.map(of_a),
            };
            // The nearer child is looked at first.
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            let limit = sought.limit(least);
            stack.extend(children.into_iter().filter(|child| child.0 <= limit));
        }
        if found { least.sqrt() } else { f64::INFINITY }
    }

    /// Lowers `least` to the least squared distance between the triangles of two leaves; returns whether any pair was that near.
    fn leaves_squared(
        &self,
        posed: &Posed,
        i: u32,
        j: u32,
        sought: &Sought,
        least: &mut f64,
        nearest: &mut Nearest,
    ) -> bool {
        let (a, b) = (&self.a.tree, &self.b.tree);
        let mut found = false;
        for index_b in b.range(j) {
            let placed = posed.placement.triangle(&b.triangles[index_b]);
            let bounds = Bounds::of(&placed);
            for index in a.range(i) {
                let (still, limit) = (&a.triangles[index], sought.limit(*least));
                if a.bounds[index].gap_squared(&bounds) > limit || triangle_distance::exceeds(still, &placed, limit) {
                    continue;
                }
                let squared = triangle_distance::squared(still, &placed);
                if squared <= *least {
                    (*least, found, *nearest) = (squared, true, Some((index, index_b)));
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::super::solids;
    use super::*;
    use crate::geometry::grid::Placement;
    use crate::geometry::{Mesh, Vector};
    use proptest::prelude::*;
    use std::sync::Arc;

    fn oracle(a: &Mesh, b: &Mesh) -> PairOracle {
        PairOracle::new(Arc::new(a.clone()), Arc::new(b.clone()))
    }

    #[test]
    fn borders_put_a_clearance_where_the_distance_puts_it() {
        let pair = oracle(&solids::torus(8.0, 2.0, 16, 8), &solids::torus(6.0, 1.5, 16, 8));
        let borders = [1.0, 10.0];
        let (mut seen, mut nearest) = ([0; 3], None);
        for step in 0..200 {
            let pose = Isometry::new(Vector::new(0.2 * f64::from(step), 3.0, 1.0), Vector::new(0.3, 0.1, 0.2));
            if pair.touches(&pose) {
                continue;
            }
            let exact = pair.clearance_mm(&pose, f64::INFINITY);
            let found = pair.clearance_of_free_mm(&pose, &Sought::Borders(&borders), &mut nearest);
            let side = |d: f64| borders.iter().filter(|&&border| d > border).count();
            assert_eq!(side(found), side(exact), "step {step}: {found}, exactly {exact}");
            seen[side(exact)] += 1;
        }
        assert!(seen.iter().all(|&count| count > 3), "{seen:?}");
    }

    #[test]
    fn blocks_are_as_far_apart_as_their_nearest_features() {
        let pair = oracle(&solids::block(4.0, 4.0, 4.0), &solids::block(2.0, 2.0, 2.0));
        for (at, distance) in [
            ([5.0, 0.0, 0.0], 2.0),   // face from face
            ([6.0, 7.0, 0.0], 5.0),   // edge from edge: 3, 4
            ([5.0, 6.0, 9.0], 7.0),   // corner from corner: 2, 3, 6
            ([2.0, 2.0, 2.0], 0.0),   // through each other
            ([3.0, 3.0, 3.0], 0.0),   // corner on corner
            ([0.0, 0.25, 0.0], 0.75), // inside
        ] {
            let pose = Isometry::new(Vector::from(at), Vector::zeros());
            assert!((pair.clearance_mm(&pose, f64::INFINITY) - distance).abs() < 1e-12, "{at:?}");
            assert_eq!(pair.clearance_mm(&pose, 8.0), pair.clearance_mm(&pose, f64::INFINITY));
            if distance > 0.0 {
                assert_eq!(pair.clearance_mm(&pose, distance * 0.999), f64::INFINITY);
            }
        }
    }

    proptest! {
        #[test]
        fn boxes_change_nothing(
            turn in prop::array::uniform3(-3.0..3.0f64),
            shift in prop::array::uniform3(-20.0..20.0f64),
        ) {
            let (a, b) = (solids::torus(8.0, 2.0, 12, 6), solids::block(3.0, 7.0, 5.0));
            let (pair, pose) = (oracle(&a, &b), Isometry::new(Vector::from(shift), Vector::from(turn)));
            prop_assume!(!pair.touches(&pose));
            let placement = Placement::new(&pose);
            let all = a.triangles().into_iter().flat_map(|s| {
                b.triangles().into_iter().map(move |t| (s, t))
            });
            let least = all.map(|(s, t)| triangle_distance::squared(&s, &placement.triangle(&t))).fold(f64::INFINITY, f64::min);
            prop_assert!((pair.clearance_mm(&pose, f64::INFINITY) - least.sqrt()).abs() < 1e-12);
        }
    }
}
