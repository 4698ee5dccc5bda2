//! How far apart are the surfaces?
//!
//! Branch and bound over the same boxes as the verdict, nearest pair of nodes first. The boxes' gap is a lower bound but
//! for its own rounding; the distance of the triangles is accurate to rounding (about 1e-12 mm at machine size).

use super::boxes::Bounds;
use super::{PairOracle, Posed, triangle_distance};
use crate::geometry::Isometry;

impl PairOracle {
    /// Euclidean distance between the surfaces, mm: 0 when they touch (exactly), infinite when it is more than `beyond_mm`,
    /// which may itself be infinite. A solid inside the other is as far as its surface is.
    #[must_use]
    pub fn clearance_mm(&self, a_from_b: &Isometry, beyond_mm: f64) -> f64 {
        if self.touches(a_from_b) { 0.0 } else { self.clearance_of_free_mm(a_from_b, beyond_mm) }
    }

    /// The same for surfaces known not to touch.
    pub(super) fn clearance_of_free_mm(&self, a_from_b: &Isometry, beyond_mm: f64) -> f64 {
        let posed = self.posed(a_from_b);
        let (a, b) = (&self.a.tree, &self.b.tree);
        let mut least = beyond_mm * beyond_mm;
        let mut found = false;
        let moved = posed.mover.bounds(self.b.bounds());
        let mut stack = vec![(self.a.bounds().gap_squared(&moved), 0, 0, moved)];
        while let Some((gap, i, j, moved)) = stack.pop() {
            if gap > least {
                continue;
            }
            let mut children = match (a.children(i), b.children(j)) {
                (None, None) => {
                    found |= self.leaves_squared(&posed, i, j, &mut least);
                    continue;
                }
                (Some(children), other) if other.is_none() || a.size(i) > b.size(j) => {
                    children.map(|child| (a.nodes[child as usize].bounds.gap_squared(&moved), child, j, moved))
                }
                (_, Some(children)) => children.map(|child| {
                    let moved = posed.mover.bounds(&b.nodes[child as usize].bounds);
                    (a.nodes[i as usize].bounds.gap_squared(&moved), i, child, moved)
                }),
                (Some(_), None) => continue, // Covered by the arm with the guard.
            };
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            stack.extend(children.into_iter().filter(|child| child.0 <= least));
        }
        if found { least.sqrt() } else { f64::INFINITY }
    }

    /// Lowers `least` to the least squared distance between the triangles of two leaves; whether any was as near.
    fn leaves_squared(&self, posed: &Posed, i: u32, j: u32, least: &mut f64) -> bool {
        let (a, b) = (&self.a.tree, &self.b.tree);
        let mut found = false;
        for triangle in &b.triangles[b.range(j)] {
            let placed = posed.placement.triangle(triangle);
            let bounds = Bounds::of(&placed);
            for index in a.range(i) {
                if a.bounds[index].gap_squared(&bounds) <= *least {
                    let squared = triangle_distance::squared(&a.triangles[index], &placed);
                    if squared <= *least {
                        (*least, found) = (squared, true);
                    }
                }
            }
        }
        found
    }
}
