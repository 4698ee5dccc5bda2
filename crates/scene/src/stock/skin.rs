//! A mesh that does not turn: how far a point is from its surface, negative inside.

use crate::geometry::{Mesh, Point, Triangle};
use crate::truth::Solid;
use crate::truth::boxes::{Bounds, BoxTree};
use std::sync::Arc;

/// A mesh in a tree of boxes.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    tree: BoxTree,
    solid: Solid,
}

impl Skin {
    pub fn new(mesh: &Arc<Mesh>) -> Self {
        Self { tree: BoxTree::new(&mesh.triangles()), solid: Solid::new(Arc::clone(mesh)) }
    }

    /// The box around it.
    pub fn bounds(&self) -> (Point, Point) {
        let Bounds { low, high } = self.tree.nodes[0].bounds;
        (low, high)
    }

    /// Distance from the surface, mm, negative inside a watertight mesh; where it is more than `beyond_mm`, anything above that.
    pub fn signed_distance_mm(&self, p: &Point, beyond_mm: f64) -> f64 {
        // Inside, the distance is at most the box's size.
        if self.holds(p) { -self.distance_mm(p, f64::INFINITY) } else { self.distance_mm(p, beyond_mm) }
    }

    /// Whether a watertight mesh holds a point. That is exact, and takes longer than the distance.
    pub fn holds(&self, p: &Point) -> bool {
        self.tree.nodes[0].bounds.contains(p) && self.solid.holds(p)
    }

    /// Distance from the surface, mm; where it is more than `beyond_mm`, anything above that.
    pub fn distance_mm(&self, p: &Point, beyond_mm: f64) -> f64 {
        let (mut least, beyond) = (f64::INFINITY, beyond_mm * beyond_mm);
        let at = Bounds { low: *p, high: *p };
        let bounded = |node: u32| (self.tree.nodes[node as usize].bounds.gap_squared(&at), node);
        let mut stack = vec![bounded(0)];
        while let Some((bound, node)) = stack.pop() {
            if bound >= least || bound > beyond {
                continue;
            }
            let Some(children) = self.tree.children(node) else {
                for triangle in &self.tree.triangles[self.tree.range(node)] {
                    least = least.min((nearest(triangle, p) - p).norm_squared());
                }
                continue;
            };
            let mut children = children.map(bounded);
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            stack.extend(children);
        }
        least.sqrt()
    }
}

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
fn nearest(triangle: &Triangle, p: &Point) -> Point {
    let [a, b, c] = triangle.corners;
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 && (d4 - d3) + (d5 - d6) > 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let whole = va + vb + vc;
    if whole > 0.0 { a + ab * (vb / whole) + ac * (vc / whole) } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle_distance::point_squared;
    use obbtree::cases::meshes;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn distances_are_those_of_all_triangles(which in 0..64usize, at in prop::array::uniform3(-1.5..1.5f64)) {
            let subjects = meshes::subjects();
            let mesh = Arc::new(subjects[which % subjects.len()].mesh.clone());
            let skin = Skin::new(&mesh);
            let size = mesh.vertices().iter().map(|v| v.coords.amax()).fold(0.0, f64::max);
            let p = Point::from(crate::geometry::Vector::from(at) * size);
            let exact = mesh.triangles().iter().map(|t| point_squared(&p, t)).fold(f64::INFINITY, f64::min).sqrt();
            let found = skin.signed_distance_mm(&p, f64::INFINITY);
            prop_assert!((found.abs() - exact).abs() <= 1e-6 * (1.0 + size), "{found} {exact}");
            prop_assert_eq!(found.abs(), skin.distance_mm(&p, f64::INFINITY));
            prop_assert_eq!(found < 0.0, skin.holds(&p) && found != 0.0);
        }
    }
}
