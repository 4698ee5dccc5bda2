//! Whether a solid lies wholly inside another.
//!
//! A vertex is inside the other mesh exactly when a ray from it along +x leaves that mesh more often than it enters. One vertex of each
//! connected component is tested. Crossings are counted with their direction, not by parity alone, so that solids made of overlapping
//! bodies have an interior too, and an inner shell that faces a cavity makes the cavity outside. Bodies of the other winding that are no
//! cavity are turned round first ([`stray_components`]). The ray starts at (x, y + e, z + e²) for
//! an infinitesimal e > 0, so it never meets an edge or a vertex. Where a projected edge passes exactly through the start, the sign of the
//! first nonzero derivative decides (simulation of simplicity, Edelsbrunner and Mücke 1990). The test is exact. It is used only when the
//! surfaces do not touch, so the start lies on no triangle.

use super::boxes::{Bounds, BoxTree, Mover};
use super::{PairOracle, Posed};
use crate::geometry::grid::{Placement, STEP_MM};
use crate::geometry::{Isometry, Mesh, Point, Triangle, exact};
use std::sync::{Arc, OnceLock};

/// A mesh for containment queries without a fixed partner. Immutable and shared between threads. Most of its data is computed on first use,
/// because most solids are never near being inside one another.
#[derive(Clone, Debug)]
pub struct Solid {
    mesh: Arc<Mesh>,
    bounds: Bounds,
    /// One vertex of each connected component, mm.
    representatives: Vec<Point>,
    /// The tree over the mesh, stray components turned round; `None` when the mesh is not watertight, and therefore contains nothing.
    inside: OnceLock<Option<BoxTree>>,
    /// Whether a component has no volume.
    is_flat: OnceLock<bool>,
}

impl Solid {
    /// Prepares a mesh.
    pub fn new(mesh: Arc<Mesh>) -> Self {
        let bounds = Bounds::around(mesh.vertices().iter().copied());
        let representatives = representatives(&mesh);
        Self { bounds, representatives, inside: OnceLock::new(), is_flat: OnceLock::new(), mesh }
    }

    /// Whether a component of either solid lies inside the other when `b` is placed in the frame of `a`. Their surfaces must not touch
    /// there. Exact, like [`super::Verdict::contained`]; `of_open` is the answer about a component within the bounds of a mesh that is not
    /// watertight, and true also where a component of that mesh has no volume.
    pub fn one_in_the_other(a: &Self, b: &Self, a_from_b: &Isometry, of_open: bool) -> bool {
        let mover = Mover::new(a_from_b, &b.bounds);
        let moved = mover.bounds(&b.bounds);
        if !a.bounds.overlap(&moved) {
            return false;
        }
        let placement = Placement::new(a_from_b);
        a.representatives.iter().filter(|point| moved.contains(point)).any(|point| {
            let in_b = |b: &BoxTree| is_inside(point, b, |bounds| mover.bounds(bounds), |t| placement.triangle(t));
            b.tree().map_or(of_open, in_b) || of_open && b.is_flat()
        }) || b.representatives.iter().map(|point| placement.point(point)).any(|point| {
            let in_a = |a: &BoxTree| is_inside(&point, a, |bounds| *bounds, |triangle| *triangle);
            a.bounds.contains(&point) && (a.tree().map_or(of_open, in_a) || of_open && a.is_flat())
        })
    }

    /// Whether a point, mm, in the mesh's frame, is inside the mesh. The point must lie on no triangle. Exact; a mesh that is not
    /// watertight contains nothing.
    pub fn holds(&self, point: &Point) -> bool {
        self.bounds.contains(point)
            && self.tree().is_some_and(|tree| is_inside(point, tree, |bounds| *bounds, |triangle| *triangle))
    }

    /// Whether the mesh encloses a space; a mesh that does not contains nothing.
    pub fn is_watertight(&self) -> bool {
        self.mesh.edge_report().is_watertight()
    }

    /// Whether a component has no volume, exactly: rays do not see a body that is there both ways round. The certificate checker asks the same.
    fn is_flat(&self) -> bool {
        // Components that a compound shape draws apart may share vertices.
        let of = |mesh: Mesh| {
            let (component_of, components) = mesh.components();
            let mut volumes = vec![0_i128; components];
            for (triangle, &component) in mesh.triangles().iter().zip(&component_of) {
                let [a, b, c] = triangle.corners.map(|p| [p.x, p.y, p.z].map(|x| (x / STEP_MM) as i128));
                let part = |i: usize, j: usize, k: usize| a[i] * (b[j] * c[k] - b[k] * c[j]);
                let six = part(0, 1, 2) + part(1, 2, 0) + part(2, 0, 1);
                volumes[component as usize] = volumes[component as usize].wrapping_add(six);
            }
            volumes.contains(&0)
        };
        *self.is_flat.get_or_init(|| Mesh::from_triangles(&self.mesh.triangles()).is_ok_and(of))
    }

    fn tree(&self) -> Option<&BoxTree> {
        self.inside.get_or_init(|| enclosing(&self.mesh).map(|triangles| BoxTree::new(&triangles))).as_ref()
    }
}

/// The first vertex by X, then Y, then Z of each connected component of a mesh, mm. The certificate checker asks about the same ones: of a mesh that is
/// not watertight the answer depends on the vertex.
pub(super) fn representatives(mesh: &Mesh) -> Vec<Point> {
    let (component_of, components) = mesh.components();
    let mut found: Vec<Option<Point>> = vec![None; components];
    let is_before = |p: Point, q: Point| [p.x, p.y, p.z] < [q.x, q.y, q.z];
    for (face, &component) in mesh.faces().iter().zip(&component_of) {
        let first = &mut found[component as usize];
        for vertex in mesh.triangle(*face).corners {
            if first.is_none_or(|first| is_before(vertex, first)) {
                *first = Some(vertex);
            }
        }
    }
    found.into_iter().flatten().collect()
}

/// The triangles of a mesh in face order, [stray components](stray_components) turned round, so that what these enclose is inside; `None` when
/// the mesh is not watertight.
pub(super) fn enclosing(mesh: &Mesh) -> Option<Vec<Triangle>> {
    let report = mesh.surface_report();
    if report.leaking > 0 {
        return None;
    }
    let mut triangles = mesh.triangles();
    if (1..report.components).contains(&report.inward) {
        let strays = stray_components(mesh);
        for (triangle, component) in triangles.iter_mut().zip(mesh.components().0) {
            if strays.contains(&component) {
                triangle.corners.swap(1, 2);
            }
        }
    }
    Some(triangles)
}

/// Closed components of a mesh that face against the mesh as a whole and have a vertex outside all that face with it: bodies of the other winding,
/// and not cavities.
pub fn stray_components(mesh: &Mesh) -> Vec<u32> {
    let (component_of, components) = mesh.components();
    let mut triangles = vec![Vec::new(); components];
    for (triangle, &component) in mesh.triangles().into_iter().zip(&component_of) {
        triangles[component as usize].push(triangle);
    }
    let closed =
        (0..).zip(triangles).filter_map(|(number, triangles)| Some((number, Mesh::from_triangles(&triangles).ok()?)));
    let closed = closed.filter(|(_, component)| component.edge_report().is_watertight());
    let is_inside_out = mesh.signed_volume() < 0.0;
    let is_against = |(_, component): &(u32, Mesh)| (component.signed_volume() < 0.0) != is_inside_out;
    let (against, with) = closed.partition::<Vec<_>, _>(is_against);
    let with: Vec<Triangle> = with.iter().flat_map(|(_, component)| component.triangles()).collect();
    let with = Mesh::from_triangles(&with).ok().map(|mesh| Solid::new(Arc::new(mesh)));
    let is_held = |vertex: &Point| with.as_ref().is_some_and(|with| with.holds(vertex));
    let strays = against.iter().filter(|(_, component)| !component.vertices().iter().all(is_held));
    strays.map(|(number, _)| *number).collect()
}

impl PairOracle {
    /// Whether a component of either mesh lies inside the other mesh; the surfaces must not touch.
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

/// Whether the ray from `point` leaves the placed mesh of the tree a different number of times than it enters.
fn is_inside(
    point: &Point,
    tree: &BoxTree,
    move_bounds: impl Fn(&Bounds) -> Bounds,
    place: impl Fn(&Triangle) -> Triangle,
) -> bool {
    let (mut stack, mut leavings) = (vec![0], 0_i64);
    while let Some(node) = stack.pop() {
        if !move_bounds(&tree.nodes[node as usize].bounds).meets_ray_along_x(point) {
            continue;
        }
        stack.extend(tree.children(node).into_iter().flatten());
        let crossings = tree.triangles[tree.range(node)].iter().map(|triangle| crossing(point, &place(triangle)));
        leavings += crossings.map(i64::from).sum::<i64>();
    }
    leavings != 0
}

/// How the ray from the displaced point along +x crosses the triangle: 1 from behind its face, -1 from in front, 0 not at all. The point
/// must not lie on the triangle.
fn crossing(point: &Point, triangle: &Triangle) -> i8 {
    let shadow = |p: &Point| [p.y, p.z];
    let [a, b, c] = triangle.corners.each_ref().map(shadow);
    let winding = exact::turn(a, b, c);
    if winding == 0 {
        return 0; // Parallel to the ray: the nudged ray passes by.
    }
    let start = shadow(point);
    if [(a, b), (b, c), (c, a)].into_iter().any(|(u, v)| nudged_turn(u, v, start) != winding) {
        return 0;
    }
    // `side` is 1 where the corners appear clockwise. Seen from +x they wind by `winding`, so there it is -winding, and
    // the point must be on the -x side. A face that winds counter-clockwise seen from +x looks there, and the ray leaves by it.
    if exact::side(triangle, point) == winding { winding } else { 0 }
}

/// The sign of turn(u, v, p + (e, e²)), which is never 0 for u ≠ v. The turn is (v - u) × (p - u), so its derivative is -(v - u)_2 along
/// the first axis and (v - u)_1 along the second.
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
        let (a, b) = (Arc::new(a.clone()), Arc::new(b.clone()));
        let verdict = PairOracle::new(Arc::clone(&a), Arc::clone(&b)).judge(&pose);
        assert!(!verdict.touches());
        let (a, b) = (Solid::new(a), Solid::new(b));
        assert_eq!(Solid::one_in_the_other(&a, &b, &pose, false), verdict.contained);
        let are_closed = a.is_watertight() && b.is_watertight();
        assert!(!are_closed || Solid::one_in_the_other(&a, &b, &pose, true) == verdict.contained);
        verdict.contained
    }

    /// Both meshes as one; the second is shifted.
    fn both(one: &Mesh, other: &[Triangle], shift: f64) -> Mesh {
        let shifted = other.iter().map(|t| t.map(|p| p + Vector::x() * shift));
        Mesh::from_triangles(&one.triangles().into_iter().chain(shifted).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn where_two_bodies_of_a_solid_overlap_is_inside_and_a_cavity_is_outside() {
        let (large, ball) = (solids::block(8.0, 8.0, 8.0), solids::ball(1.0, 8));
        // From -4 to 4 and from -1 to 7: the ball at 1.5 is in both.
        let overlapping = both(&large, &large.triangles(), 3.0);
        assert!(contained(&overlapping, &ball, [1.5, 0.0, 0.0]));
        assert!(contained(&overlapping, &ball, [5.5, 0.0, 0.0]));
        assert!(!contained(&overlapping, &ball, [9.5, 0.0, 0.0]));
        // A block of 6 cut out of one of 8, and the same inside out as a whole.
        let small = solids::block(6.0, 6.0, 6.0);
        assert!(!contained(&both(&large, &turned(&small), 0.0), &ball, [0.5, 0.0, 0.0]));
        let inside_out = Mesh::from_triangles(&turned(&large)).unwrap();
        assert!(!contained(&both(&inside_out, &small.triangles(), 0.0), &ball, [0.5, 0.0, 0.0]));
        // A body of the other winding is no cavity: as large as the first, smaller, and larger.
        for other in [8.0, 7.0, 9.0].map(|size| solids::block(size, size, size)) {
            let mixed = both(&large, &turned(&other), 3.0);
            for (x, is_inside) in [(1.5, true), (5.25, true), (-2.7, true), (9.5, false)] {
                assert_eq!(contained(&mixed, &ball, [x, 0.0, 0.0]), is_inside, "{x}");
            }
        }
    }

    /// The triangles inside out.
    fn turned(mesh: &Mesh) -> Vec<Triangle> {
        mesh.triangles().iter().map(|t| Triangle::new(t.corners[0], t.corners[2], t.corners[1])).collect()
    }

    #[test]
    fn inward_components_are_strays_outside_outward_ones() {
        let turned = turned(&solids::block(6.0, 6.0, 6.0));
        let strays_of = |mesh: &Mesh| stray_components(mesh).len();
        let large = solids::block(8.0, 8.0, 8.0);
        assert_eq!(strays_of(&large), 0);
        assert_eq!(strays_of(&both(&large, &turned, 0.0)), 0);
        assert_eq!(strays_of(&both(&large, &turned, 20.0)), 1);
        assert_eq!(strays_of(&both(&large, &turned, 3.0)), 1, "partly inside");
        // A second body about the stray one makes it a cavity.
        let second = both(&large, &large.triangles(), 20.0);
        assert_eq!(strays_of(&both(&second, &turned, 20.0)), 0);
        assert_eq!(strays_of(&Mesh::from_triangles(&turned).unwrap()), 0, "inside out as a whole");
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
    fn two_bodies_with_an_edge_in_common_have_an_inside() {
        let large = solids::block(8.0, 8.0, 8.0);
        let shifted = large.triangles().into_iter().map(|t| t.map(|p| p + Vector::new(8.0, 8.0, 0.0)));
        let two = Mesh::from_triangles(&large.triangles().into_iter().chain(shifted).collect::<Vec<_>>()).unwrap();
        assert!(two.edge_report().is_watertight());
        let small = solids::block(2.0, 2.0, 2.0);
        assert!(contained(&two, &small, [0.0; 3]) && contained(&two, &small, [8.0, 8.0, 0.0]));
        assert!(!contained(&two, &small, [8.0, 0.0, 0.0]) && !contained(&two, &small, [0.0, 8.0, 0.0]));
    }

    #[test]
    fn what_is_within_a_mesh_with_a_component_of_no_volume_may_be_taken_for_inside() {
        let (large, small) = (solids::block(8.0, 8.0, 8.0), solids::block(2.0, 2.0, 2.0));
        let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]].map(|[y, z]| Point::new(0.0, y, z));
        // A square from both sides, each divided along another diagonal.
        let sheet = [[0, 1, 2], [0, 2, 3], [3, 2, 1], [1, 0, 3]]
            .map(|[i, j, k]| Triangle::new(corners[i], corners[j], corners[k]));
        let with_sheet = both(&large, &sheet, 20.0);
        // The same body both ways round.
        let twice = both(&large, &turned(&large), 0.0);
        for (mesh, x, is_within) in [
            (&with_sheet, 10.0, true),
            (&with_sheet, 30.0, false),
            (&both(&large, &large.triangles(), 20.0), 10.0, false),
            (&twice, 0.0, true),
            (&twice, 10.0, false),
        ] {
            assert!(mesh.edge_report().is_watertight());
            let [mesh, small] = [mesh, &small].map(|mesh| Solid::new(Arc::new(mesh.clone())));
            let pose = Isometry::translation(x, 0.0, 0.0);
            assert_eq!(Solid::one_in_the_other(&mesh, &small, &pose, true), is_within, "{x}");
            assert_eq!(Solid::one_in_the_other(&small, &mesh, &pose.inverse(), true), is_within, "{x}");
            assert!(!Solid::one_in_the_other(&mesh, &small, &pose, false), "{x}");
        }
    }

    #[test]
    fn an_open_mesh_contains_nothing() {
        let large = solids::block(8.0, 8.0, 8.0);
        let open = Mesh::new(large.vertices().to_vec(), large.faces()[1..].to_vec()).unwrap();
        let small = solids::block(2.0, 2.0, 2.0);
        assert!(!contained(&open, &small, [0.0; 3]));
        // What is within its bounds may be taken for inside.
        let [open, small] = [open, small].map(|mesh| Solid::new(Arc::new(mesh)));
        for (x, is_within) in [(0.0, true), (20.0, false)] {
            let pose = Isometry::translation(x, 0.0, 0.0);
            assert_eq!(Solid::one_in_the_other(&open, &small, &pose, true), is_within);
            assert_eq!(Solid::one_in_the_other(&small, &open, &pose.inverse(), true), is_within);
        }
    }
}
