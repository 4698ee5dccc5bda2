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
        let planes = Planes::of(witness::nearest(still, moved), least)?;
        Some(Self {
            of_a: Side::of(a, |place| planes.is_below(&a.triangle(place))),
            of_b: Side::of(b, |place| planes.is_above(&placement.triangle(&b.triangle(place)))),
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

/// The two planes of a slab, square to a direction.
struct Planes {
    /// Where heights are 0.
    origin: Point,
    up: Vector,
    low_mm: f64,
    high_mm: f64,
}

impl Planes {
    /// Between two points that are `least` apart, mm. `None` where they are no distance apart.
    fn of([from, to]: [Point; 2], least: f64) -> Option<Self> {
        let up = (to - from).try_normalize(1e-100)?;
        // Half of what the slab may be narrower is left for each plane.
        let half = 0.5 * NARROWER * least;
        Some(Self { origin: from, up, low_mm: half, high_mm: least - half })
    }

    /// Whether all of a triangle is surely below the lower plane.
    fn is_below(&self, triangle: &Triangle) -> bool {
        self.heights(triangle).iter().all(|[_, most]| *most <= self.low_mm)
    }

    /// Whether all of a triangle is surely above the upper plane.
    fn is_above(&self, triangle: &Triangle) -> bool {
        self.heights(triangle).iter().all(|[least, _]| *least >= self.high_mm)
    }

    /// Between which bounds the heights of the corners are, mm: the errors of the heights are counted.
    fn heights(&self, triangle: &Triangle) -> [[f64; 2]; 3] {
        triangle.corners.map(|corner| {
            let way: Vector = corner - self.origin;
            let (height, error) = (self.up.dot(&way), PROJECTION * (way.x.abs() + way.y.abs() + way.z.abs()));
            [height - error, height + error]
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A slab of 1000 mm along x, narrower by 10⁻⁹ mm. Heights of corners (x, -2·10⁴, 3·10⁴) are wrong by 16·2⁻⁵³·5·10⁴ mm, nearly 10⁻¹⁰.
    #[test]
    fn what_is_on_a_side_is_so_with_the_error_of_its_height() {
        let planes = Planes::of([Point::new(1.0, 0.0, 0.0), Point::new(1001.0, 0.0, 0.0)], 1000.0).unwrap();
        let at = |x: f64| {
            let corner = Point::new(1.0 + x, -2e4, 3e4);
            Triangle::new(corner, corner, corner)
        };
        let [[least, most], ..] = planes.heights(&at(0.0));
        assert!((least + 8.88e-11).abs() < 1e-13 && (most - 8.88e-11).abs() < 1e-13, "{least} {most}");
        for (x, is_below, is_above) in [
            (0.0, true, false),
            (4.0e-10, true, false),
            (4.3e-10, false, false),
            (1000.0 - 4.3e-10, false, false),
            (1000.0 - 3.5e-10, false, true),
            (1000.0, false, true),
        ] {
            assert_eq!((planes.is_below(&at(x)), planes.is_above(&at(x))), (is_below, is_above), "{x}");
        }
        assert!(Planes::of([Point::origin(); 2], 0.0).is_none());
    }
}
