//! A mesh that does not turn: how far a point is from its surface, negative inside.

use crate::geometry::{Mesh, Point, Triangle, Vector};
use crate::truth::Solid;
use crate::truth::boxes::{Bounds, BoxTree};
use rayon::prelude::*;
use std::sync::Arc;

/// Part of a mesh's greatest depth to which it is found.
const DEPTH_PART: f64 = 0.02;
/// Least depth that is looked for, as a part of the greatest.
const LEAST_PART: f64 = 1e-3;
/// What rounding may do to the radius of a ball that touches a triangle, as a part of it.
const TOUCHING_PART: f64 = 1e-6;

/// How far below a place of the surface the search for the greatest depth near it may begin, as parts of the depth that is looked for.
const BEGINNINGS: [f64; 4] = [1.0, 0.3, 0.03, 0.003];
/// How far from a place of the surface that depth may be, as parts of itself. Corners of prisms with edges of 60 degrees do not stand out.
const NEAR: f64 = 2.5;
/// Steps of that search.
const CLIMBS: usize = 48;

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

    /// A ball around the box of a node: its centre and its radius, mm. The root is node 0.
    pub fn ball(&self, node: u32) -> (Point, f64) {
        let Bounds { low, high } = self.tree.nodes[node as usize].bounds;
        (nalgebra::center(&low, &high), 0.5 * (high - low).norm())
    }

    /// The two parts of a node; `None` of a leaf.
    pub fn children(&self, node: u32) -> Option<[u32; 2]> {
        self.tree.children(node)
    }

    /// The triangles of a leaf.
    pub fn triangles(&self, node: u32) -> &[Triangle] {
        &self.tree.triangles[self.tree.range(node)]
    }

    /// Distance from the surface, mm, negative inside a watertight mesh; where it is more than `beyond_mm`, anything above that.
    pub fn signed_distance_mm(&self, p: &Point, beyond_mm: f64) -> f64 {
        // Inside, the distance is at most the box's size.
        if self.holds(p) { -self.distance_mm(p, f64::INFINITY) } else { self.distance_mm(p, beyond_mm) }
    }

    /// A depth that a point of it has, mm, near the greatest one; infinite where that is more than `most_mm`. It is the radius of the largest ball inside that touches
    /// a triangle at its centroid or in the middle of an edge: half the thickness of a sheet, however that is bent. Of an open mesh it is half the least side of the box.
    pub fn deepest_mm(&self, most_mm: f64) -> f64 {
        if !self.solid.is_watertight() {
            let (low, high) = self.bounds();
            return 0.5 * (high - low).min();
        }
        let beyond = most_mm * (1.0 + DEPTH_PART);
        let mut deepest = 0.0;
        for triangle in &self.tree.triangles {
            let Some(normal) = triangle.double_area_normal().try_normalize(0.0) else { continue };
            let places = [triangle.centroid()].into_iter().chain(middles(triangle));
            // A mirrored mesh faces inwards.
            for (place, inwards) in places.flat_map(|place| [(place, -normal), (place, normal)]) {
                let fits = |radius: f64| {
                    let distance = self.signed_distance_mm(&(place + inwards * radius), radius);
                    -distance >= radius * (1.0 - TOUCHING_PART)
                };
                // Where a ball fits, all smaller ones that touch the same place fit.
                let deeper = f64::max(deepest * (1.0 + DEPTH_PART), beyond * LEAST_PART);
                if !fits(deeper) {
                    continue;
                }
                if fits(beyond) {
                    return f64::INFINITY;
                }
                let mut above = beyond;
                deepest = deeper;
                while above > deepest * (1.0 + DEPTH_PART) {
                    let radius = f64::midpoint(deepest, above);
                    if fits(radius) {
                        deepest = radius;
                    } else {
                        above = radius;
                    }
                }
            }
        }
        deepest
    }

    /// [`Self::deepest_mm`] where that is finite. Else about the depth in the thinnest piece that stands out of the rest: some place of its surface is farther than 1.5
    /// `out_mm` from every ball inside the mesh with the radius `out_mm`. Infinite where there is no such piece.
    pub fn thinnest_mm(&self, out_mm: f64) -> f64 {
        let deepest = self.deepest_mm(out_mm);
        if deepest.is_finite() {
            return deepest;
        }
        let of_triangle = |triangle: &Triangle| {
            let Some(normal) = triangle.double_area_normal().try_normalize(0.0) else { return f64::INFINITY };
            let ([a, b, c], middle) = (triangle.corners, triangle.centroid());
            let places = triangle.corners.into_iter().chain(middles(triangle));
            let near = |place: &Point, toward: &[Point]| self.depth_near_mm(place, &normal, toward, out_mm);
            let of_middle = near(&middle, &[middle, a, b, c]);
            places.map(|place| near(&place, &[middle])).fold(of_middle, f64::min)
        };
        self.tree.triangles.par_iter().map(of_triangle).reduce(|| f64::INFINITY, f64::min)
    }

    /// About the greatest depth, mm, within [`NEAR`] times `enough_mm` of a place of a triangle; infinite where that is `enough_mm` or more. The search begins below the
    /// place, some way toward other points of the triangle.
    fn depth_near_mm(&self, place: &Point, normal: &Vector, toward: &[Point], enough_mm: f64) -> f64 {
        let mut greatest = 0.0;
        for way in toward.iter().map(|to| to - place) {
            let aside = way.try_normalize(0.0).unwrap_or_default() * way.norm().min(1.5 * enough_mm);
            // A mirrored mesh faces inwards.
            for (part, inwards) in BEGINNINGS.into_iter().flat_map(|part| [(part, -normal), (part, *normal)]) {
                let begin = place + (inwards * enough_mm + aside) * part;
                if self.holds(&begin) {
                    greatest = f64::max(greatest, self.climb(begin, place, enough_mm));
                }
                if greatest >= enough_mm * (1.0 - TOUCHING_PART) {
                    return f64::INFINITY;
                }
            }
        }
        // What begins on the surface tells nothing, as in the plane of another face.
        if greatest > TOUCHING_PART * enough_mm { greatest } else { f64::INFINITY }
    }

    /// Goes from a point inside away from the surface, no farther than [`NEAR`] times `enough_mm` from a place, and ends at the depth `enough_mm`. Returns the depth that
    /// it has reached, mm.
    fn climb(&self, mut at: Point, place: &Point, enough_mm: f64) -> f64 {
        let from_surface = |at: &Point| self.nearest(at, f64::INFINITY).map_or_else(Vector::zeros, |near| at - near);
        let mut away = from_surface(&at);
        let (mut ways, mut step) = (vec![away], 0.5 * enough_mm);
        for _ in 0..CLIMBS {
            if away.norm() >= enough_mm * (1.0 - TOUCHING_PART) {
                break;
            }
            // Where several faces are as near, away from all of them.
            let Some(along) = ways.iter().map(Vector::normalize).sum::<Vector>().try_normalize(1e-9) else { break };
            let mut next = at + along * step;
            let way = next - place;
            if way.norm() > NEAR * enough_mm {
                next = place + way * (NEAR * enough_mm / way.norm());
            }
            let next_away = from_surface(&next);
            if next_away.norm() > away.norm() * (1.0 + 1e-9) && self.holds(&next) {
                (at, away) = (next, next_away);
                ways = vec![away];
            } else if ways.len() < 4 && next_away.norm() > 0.0 && self.holds(&next) {
                ways.push(next_away);
            } else {
                step *= 0.5;
                ways.truncate(1);
            }
        }
        away.norm()
    }

    /// Whether a watertight mesh holds a point. That is exact, and takes longer than the distance.
    pub fn holds(&self, p: &Point) -> bool {
        self.tree.nodes[0].bounds.contains(p) && self.solid.holds(p)
    }

    /// Distance from the surface, mm; where it is more than `beyond_mm`, anything above that.
    pub fn distance_mm(&self, p: &Point, beyond_mm: f64) -> f64 {
        self.nearest(p, beyond_mm).map_or(f64::INFINITY, |nearest| (nearest - p).norm())
    }

    /// The nearest point of the surface; `None` where it is farther than `beyond_mm`, or any.
    fn nearest(&self, p: &Point, beyond_mm: f64) -> Option<Point> {
        let (mut least, beyond, mut found) = (f64::INFINITY, beyond_mm * beyond_mm, None);
        let at = Bounds { low: *p, high: *p };
        let bounded = |node: u32| (self.tree.nodes[node as usize].bounds.gap_squared(&at), node);
        let mut stack = vec![bounded(0)];
        while let Some((bound, node)) = stack.pop() {
            if bound >= least || bound > beyond {
                continue;
            }
            let Some(children) = self.tree.children(node) else {
                for triangle in &self.tree.triangles[self.tree.range(node)] {
                    let nearest = nearest(triangle, p);
                    let squared = (nearest - p).norm_squared();
                    if squared < least {
                        (least, found) = (squared, Some(nearest));
                    }
                }
                continue;
            };
            let mut children = children.map(bounded);
            if children[0].0 < children[1].0 {
                children.swap(0, 1);
            }
            stack.extend(children);
        }
        found
    }
}

/// The middles of a triangle's edges.
fn middles(triangle: &Triangle) -> [Point; 3] {
    let [a, b, c] = triangle.corners;
    [(a, b), (b, c), (c, a)].map(|(p, q)| nalgebra::center(&p, &q))
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
    use crate::geometry::shapes::{Shape, Tessellation};
    use crate::geometry::triangle_distance::point_squared;
    use obbtree::cases::meshes;
    use proptest::prelude::*;

    #[test]
    fn a_bent_sheet_is_as_deep_as_a_flat_one() {
        // Along a way of corners in (x, z), 20 mm wide: a sheet of 0.15 mm, tilted, and bent to an L with legs of 30 mm.
        let tilted = [[0.0, 0.0], [24.0, 18.0], [23.91, 18.12], [-0.09, 0.12]];
        let bent = [[0.0, 0.0], [30.0, 0.0], [30.0, 0.15], [0.15, 0.15], [0.15, 30.0], [0.0, 30.0]];
        let cube = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let deepest = |outline: &[[f64; 2]], most_mm: f64| {
            let corners = outline.iter().map(|[x, z]| format!("[{x:?}, {z:?}]")).collect::<Vec<_>>().join(", ");
            let text = format!("kind = \"extrude\"\nheight_mm = 20\noutline_mm = [{corners}]");
            let shape: Shape = toml::from_str(&text).unwrap();
            Skin::new(&Arc::new(shape.mesh(&Tessellation::default()).unwrap())).deepest_mm(most_mm)
        };
        for outline in [&tilted[..], &bent] {
            let found = deepest(outline, 0.5);
            // In the bend a ball of 0.088 mm would fit.
            assert!((0.073..=0.088).contains(&found), "{found}");
        }
        // A depth of 1 mm in the middle of its faces.
        assert!((0.97..=1.0001).contains(&deepest(&cube, 1.0)));
        assert_eq!(deepest(&cube, 0.9), f64::INFINITY);
    }

    #[test]
    fn a_piece_is_thin_where_it_stands_out_of_the_rest() {
        let thinnest = |text: &str, out_mm: f64| {
            let shape: Shape = toml::from_str(text).unwrap();
            Skin::new(&Arc::new(shape.mesh(&Tessellation::default()).unwrap())).thinnest_mm(out_mm)
        };
        let thick = [
            "kind = \"rounded-box\"\nsize_mm = [4, 5, 20]",
            "kind = \"rounded-box\"\nsize_mm = [4, 5, 20]\nfillet_mm = 1",
            "kind = \"cylinder\"\nradius_mm = 5\nheight_mm = 20",
            "kind = \"sphere\"\nradius_mm = 5",
            // Edges of 90, 63 and 63 degrees.
            "kind = \"extrude\"\nheight_mm = 20\noutline_mm = [[0, 0], [20, 0], [10, 20]]",
        ];
        for (text, out_mm) in thick.iter().flat_map(|text| [0.1, 0.5, 1.5].map(|out_mm| (text, out_mm))) {
            assert_eq!(thinnest(text, out_mm), f64::INFINITY, "{text} {out_mm}");
        }
        let on_block = |piece: &str| {
            let block = "{ shape = { kind = \"rounded-box\", size_mm = [60, 60, 40] } }";
            format!("kind = \"compound\"\nparts = [{block}, {{ {piece} }}]")
        };
        for (piece, out_mm, expected) in [
            // A wire of 0.4 mm and a sheet of 0.1 mm on a block, and how far they stand out of it.
            ("shape = { kind = \"cylinder\", radius_mm = 0.2, height_mm = 60 }", 0.5, 0.2),
            ("shape = { kind = \"rounded-box\", size_mm = [0.1, 40, 60] }", 0.3, 0.05),
            ("shape = { kind = \"rounded-box\", size_mm = [0.1, 40, 40.8] }", 0.3, 0.05),
            ("shape = { kind = \"rounded-box\", size_mm = [0.1, 40, 40.2] }", 0.3, f64::INFINITY),
            ("shape = { kind = \"rounded-box\", size_mm = [0.1, 40, 60] }", 0.04, f64::INFINITY),
        ] {
            let found = thinnest(&on_block(piece), out_mm);
            // The search may end where several faces are as near.
            let is_near = (0.4 * expected..=1.05 * expected).contains(&found);
            assert!(found == expected || is_near, "{piece} {out_mm}: {found}");
        }
    }

    proptest! {
        #[test]
        fn distances_are_those_of_all_triangles(which in 0..64usize, at in prop::array::uniform3(-1.5..1.5f64)) {
            let subjects = meshes::subjects();
            let mesh = Arc::new(subjects[which % subjects.len()].mesh.clone());
            let skin = Skin::new(&mesh);
            let size = mesh.vertices().iter().map(|v| v.coords.amax()).fold(0.0, f64::max);
            let p = Point::from(Vector::from(at) * size);
            let exact = mesh.triangles().iter().map(|t| point_squared(&p, t)).fold(f64::INFINITY, f64::min).sqrt();
            let found = skin.signed_distance_mm(&p, f64::INFINITY);
            prop_assert!((found.abs() - exact).abs() <= 1e-6 * (1.0 + size), "{found} {exact}");
            prop_assert_eq!(found.abs(), skin.distance_mm(&p, f64::INFINITY));
            prop_assert_eq!(found < 0.0, skin.holds(&p) && found != 0.0);
        }
    }
}
