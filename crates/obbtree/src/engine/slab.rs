//! Triangles that need not be measured with one another, since a slab is between them.
//!
//! Where many triangles of both meshes are as near as the nearest, as around two apexes, no bound leaves out their pairs: each is below the distance by
//! some rounding. A slab across the line between two nearest points, from one to the other, is as wide as the distance. Of two triangles on its two
//! sides none is nearer, and one pass over both meshes finds all of these.

use super::buckets::Waiting;
use super::node::{Contents, WideTree};
use super::posed::{Opened, Posed};
use super::volume::WideVolume;
use crate::engine::geometry::triangle_distance::PROJECTION;
use crate::engine::geometry::{Point, Triangle, Vector, witness};

/// By how much the slab may be narrower than the distance, relative to that. It adds to the error of a distance, and is small against
/// [`ACCURACY`](crate::engine::geometry::triangle_distance::ACCURACY).
const NARROWER: f64 = 1e-12;

/// A slab, as the triangles of both trees that lie on its two sides.
pub(super) struct Slab {
    of_a: Side,
    of_b: Side,
}

impl Slab {
    /// The slab from the first of two triangles to the second, `least` wide, mm. The second is in the frame of `a`. `None` where rounding leaves no
    /// direction.
    #[cold]
    pub fn between<V: WideVolume>(
        posed: &Posed<V>,
        (still, moved): (&Triangle, &Triangle),
        least: f64,
    ) -> Option<Self> {
        let Posed { a, b, placement, .. } = posed;
        let [from, to] = witness::nearest(still, moved);
        let across = (to - from).try_normalize(1e-100)?;
        let height = |corner: &Point| {
            let way: Vector = corner - from;
            (across.dot(&way), PROJECTION * (way.x.abs() + way.y.abs() + way.z.abs()))
        };
        // Errors of the heights are counted; half of what the slab may be narrower is left for each plane.
        let (near, far) = (0.5 * NARROWER * least, (1.0 - 0.5 * NARROWER) * least);
        let is_before = |t: Triangle| t.corners.iter().map(height).all(|(height, error)| height + error <= near);
        let is_beyond = |t: Triangle| t.corners.iter().map(height).all(|(height, error)| height - error >= far);
        Some(Self {
            of_a: Side::of(a, |place| is_before(a.triangle(place))),
            of_b: Side::of(b, |place| is_beyond(placement.triangle(&b.triangle(place)))),
        })
    }

    /// Whether the slab parts the two meshes: all triangles of one are below it, all of the other above.
    #[inline(never)]
    pub fn is_between<V: WideVolume>(&self, posed: &Posed<V>, waiting: Waiting) -> bool {
        let (of_a, of_b) = match waiting {
            Waiting::Leaves((x, y)) => (posed.a.contents(x), posed.b.contents(y)),
            Waiting::Node(opened @ Opened { one, node, of_b }) => {
                let (node, one) = (Contents::Node(node), posed.trees(opened).1.contents(one));
                if of_b { (one, node) } else { (node, one) }
            }
        };
        self.of_a.holds(of_a) && self.of_b.holds(of_b)
    }
}

/// The triangles of a tree on one side of a slab, by place, and the nodes that have no others.
struct Side {
    triangles: Vec<bool>,
    nodes: Vec<bool>,
}

impl Side {
    fn of<V: WideVolume>(tree: &WideTree<V>, holds: impl Fn(u32) -> bool) -> Self {
        let triangles: Vec<bool> = (0..tree.len() as u32).map(holds).collect();
        let mut nodes = vec![false; tree.nodes.len()];
        // A node's children come after it.
        for (at, node) in tree.nodes.iter().enumerate().rev() {
            let (inner, triangles_below) = (node.inner as usize, (node.count - node.inner + node.paired) as usize);
            let all =
                |held: &[bool], first: u32, count: usize| held[first as usize..][..count].iter().all(|held| *held);
            nodes[at] = all(&nodes, node.first_node, inner) && all(&triangles, node.first_triangle, triangles_below);
        }
        Self { triangles, nodes }
    }

    fn holds(&self, contents: Contents) -> bool {
        match contents {
            Contents::Node(node) => self.nodes[node as usize],
            Contents::Triangles(triangles) => triangles.places().all(|place| self.triangles[place as usize]),
        }
    }
}
