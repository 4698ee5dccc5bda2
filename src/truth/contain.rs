//! Is a solid wholly inside the other?
//!
//! A ray along +x from one vertex of each connected component crosses the other mesh an odd number of times exactly when
//! the vertex is inside it. The ray is thought of as starting at (x, y + e, z + e²) for an infinitesimal e > 0, so that it
//! never meets an edge or a vertex: where a projected edge passes exactly through the start, the sign of the first
//! derivative that is not zero decides (simulation of simplicity, Edelsbrunner and Mücke 1990). Exact; asked only when the
//! surfaces do not touch, so that the start lies on no triangle.

use super::boxes::{Bounds, BoxTree};
use super::{PairOracle, Posed};
use crate::geometry::{Point, Triangle, exact};

impl PairOracle {
    /// Whether a component of either mesh lies inside the other mesh, given that the surfaces do not touch.
    pub(super) fn contained(&self, posed: &Posed) -> bool {
        let (a, b) = (&self.a, &self.b);
        let moved = posed.mover.bounds(b.bounds());
        if !a.bounds().overlap(&moved) {
            return false;
        }
        let a_in_b = b.watertight
            && a.representatives.iter().any(|point| {
                moved.contains(point)
                    && is_inside(point, &b.tree, |bounds| posed.mover.bounds(bounds), |t| posed.placement.triangle(t))
            });
        a_in_b
            || a.watertight
                && b.representatives.iter().map(|point| posed.placement.point(point)).any(|point| {
                    a.bounds().contains(&point) && is_inside(&point, &a.tree, |bounds| *bounds, |triangle| *triangle)
                })
    }
}

/// Whether the ray from `point` crosses the mesh of the tree, as placed, an odd number of times.
fn is_inside(
    point: &Point,
    tree: &BoxTree,
    move_bounds: impl Fn(&Bounds) -> Bounds,
    place: impl Fn(&Triangle) -> Triangle,
) -> bool {
    let (mut stack, mut odd) = (vec![0], false);
    while let Some(node) = stack.pop() {
        if !move_bounds(&tree.nodes[node as usize].bounds).meets_ray_along_x(point) {
            continue;
        }
        stack.extend(tree.children(node).into_iter().flatten());
        odd ^= tree.triangles[tree.range(node)].iter().filter(|t| ray_crosses(point, &place(t))).count() % 2 == 1;
    }
    odd
}

/// Whether the ray from the nudged point along +x crosses the triangle, on which the point does not lie.
fn ray_crosses(point: &Point, triangle: &Triangle) -> bool {
    let shadow = |p: &Point| [p.y, p.z];
    let [a, b, c] = triangle.corners.each_ref().map(shadow);
    let winding = exact::turn(a, b, c);
    if winding == 0 {
        return false; // Parallel to the ray: the nudged ray passes by.
    }
    let start = shadow(point);
    if [(a, b), (b, c), (c, a)].into_iter().any(|(u, v)| nudged_turn(u, v, start) != winding) {
        return false;
    }
    // `side` is 1 where the corners appear clockwise. Seen from +x they wind by `winding`, so there it is -winding, and
    // the point must be on the -x side.
    exact::side(triangle, point) == winding
}

/// The sign of turn(u, v, p + (e, e²)), never 0 for u ≠ v. The turn is (v - u) × (p - u), so its derivative is -(v - u)_2
/// along the first axis and (v - u)_1 along the second.
fn nudged_turn(u: [f64; 2], v: [f64; 2], p: [f64; 2]) -> i8 {
    let sign = |x: f64| i8::from(x > 0.0) - i8::from(x < 0.0);
    [exact::turn(u, v, p), sign(u[1] - v[1]), sign(v[0] - u[0])].into_iter().find(|&s| s != 0).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::super::solids;
    use super::*;
    use crate::geometry::{Isometry, Mesh, Vector};
    use std::sync::Arc;

    fn contained(a: &Mesh, b: &Mesh, shift: [f64; 3]) -> bool {
        let pose = Isometry::new(Vector::from(shift), Vector::zeros());
        let verdict = PairOracle::new(Arc::new(a.clone()), Arc::new(b.clone())).judge(&pose);
        assert!(!verdict.exact);
        verdict.contained
    }

    #[test]
    fn rays_through_edges_and_vertices_count_once() {
        // The first vertex of the small box is (-1, -1, -1): its ray meets the large boxes' faces in corners and on the
        // diagonals, depending on the shift.
        let (large, small) = (solids::block(8.0, 8.0, 8.0), solids::block(2.0, 2.0, 2.0));
        for y in -2..=2 {
            for z in -2..=2 {
                let shift = [0.0, f64::from(y), f64::from(z)];
                assert!(contained(&large, &small, shift), "{shift:?}");
                assert!(contained(&small, &large, shift), "{shift:?}");
                for x in [-20.0, 20.0] {
                    assert!(!contained(&large, &small, [x, shift[1], shift[2]]), "{shift:?}");
                }
            }
        }
        // The ray runs in the plane of a face, and along an edge.
        for shift in [[-20.0, 5.0, 0.0], [-20.0, 5.0, 5.0], [-20.0, -3.0, -3.0], [-20.0, -3.0, 5.0]] {
            assert!(!contained(&large, &small, shift), "{shift:?}");
        }
    }

    #[test]
    fn the_hole_of_a_torus_is_outside() {
        let (torus, ball) = (solids::torus(20.0, 5.0, 48, 24), solids::ball(2.0, 8));
        assert!(!contained(&torus, &ball, [0.0; 3]));
        assert!(contained(&torus, &ball, [20.0, 0.0, 0.0]));
        assert!(contained(&torus, &ball, [0.0, -20.0, 0.0]));
        assert!(!contained(&torus, &ball, [20.0, 20.0, 0.0]));
    }

    #[test]
    fn one_of_two_components_inside_is_enough() {
        let near = solids::block(2.0, 2.0, 2.0).triangles();
        let far = near.iter().map(|t| t.map(|p| p + Vector::x() * 100.0));
        let both = Mesh::from_triangles(&far.chain(near.clone()).collect::<Vec<_>>()).unwrap();
        assert!(contained(&solids::block(8.0, 8.0, 8.0), &both, [0.0; 3]));
        assert!(!contained(&solids::block(8.0, 8.0, 8.0), &both, [50.0, 0.0, 0.0]));
    }

    #[test]
    fn an_open_mesh_contains_nothing() {
        let large = solids::block(8.0, 8.0, 8.0);
        let open = Mesh::new(large.vertices().to_vec(), large.faces()[1..].to_vec()).unwrap();
        assert!(!contained(&open, &solids::block(2.0, 2.0, 2.0), [0.0; 3]));
    }
}
