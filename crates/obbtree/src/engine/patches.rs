//! Which triangles share a volume.
//!
//! The two halves of a rectangle have one and the same smallest box, and most of what is near to flat comes in such pairs. So two triangles with an edge
//! in common are one patch, with one volume in the tree, where the box around both has hardly more surface than the two around each; all others are
//! patches of their own. Each looks across its longest edge first, where rectangles are divided, and what is left then across any.
//!
//! Patches decide how good the tree is, never whether it is right.

use crate::engine::geometry::{GridMesh, Point, Triangle, Vector, covariance};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// The surface of a box around two triangles, as a share of that of the two around each, up to which they are one patch.
const NEARLY: f64 = 1.12;
/// From so many edges on they are sorted on several threads.
const PARALLEL: usize = 1 << 12;

/// One face or two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// Of two triangles the corner of the first alone, those of both, and that of the second alone; of one its own, the last one twice; mm.
    pub corners: [Point; 4],
    faces: [u32; 2],
    count: u8,
}

impl Patch {
    /// Of one face.
    pub const fn one([p, q, r]: [Point; 3], face: u32) -> Self {
        Self { corners: [p, q, r, r], faces: [face; 2], count: 1 }
    }

    /// Of two faces, and the corners that are of one of them alone.
    fn two(mesh: &GridMesh, faces: [u32; 2], alone: [usize; 2]) -> Self {
        let (first, second) = (corners(mesh, faces[0]), corners(mesh, faces[1]));
        let of_first = |k: usize| first[(alone[0] + k) % 3];
        Self { corners: [of_first(0), of_first(1), of_first(2), second[alone[1]]], faces, count: 2 }
    }

    #[inline(always)]
    pub const fn is_pair(&self) -> bool {
        self.count > 1
    }

    /// The faces' numbers.
    #[inline(always)]
    pub fn faces(&self) -> &[u32] {
        &self.faces[..self.count as usize]
    }

    /// The axes of its box. Of one triangle along its longest edge; without an area along the segment that it is.
    pub fn frame(&self) -> Matrix3<f64> {
        let [p, q, r, _] = self.corners;
        let first = Triangle { corners: [p, q, r] };
        let own = if self.is_pair() { self.frame_of_both() } else { first.frame() };
        own.unwrap_or_else(|| {
            let covariance = covariance::vertex_weighted(std::slice::from_ref(&first)).1;
            covariance::principal_frame(&covariance)
        })
    }

    /// Of the boxes along an edge of the hull, square to the mean of both planes, the axes of the one with the least surface.
    fn frame_of_both(&self) -> Option<Matrix3<f64>> {
        let [p, u, v, q] = self.corners.map(|p| p - self.corners[1]);
        let (normal, other) = (v.cross(&p), q.cross(&v));
        let z = (if normal.dot(&other) < 0.0 { normal - other } else { normal + other }).try_normalize(0.0)?;
        let level = |x: Vector| (x - z * z.dot(&x)).try_normalize(0.0);
        // Twice, since the first time may leave much of little.
        let x = level(level(v)?)?;
        let y = z.cross(&x);
        let flat = |p: &Vector| [x.dot(p), y.dot(p)];
        let (p, u, v, q, thick) =
            (flat(&p), flat(&u), flat(&v), flat(&q), reach(z.dot(&p), z.dot(&u), z.dot(&v), z.dot(&q)));
        let (mut best, mut along) = (f64::INFINITY, [1.0, 0.0]);
        for (from, to) in [(&p, &u), (&p, &v), (&q, &u), (&q, &v), (&p, &q)] {
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let per_mm = 1.0 / (dx * dx + dy * dy).sqrt();
            let (dx, dy) = (dx * per_mm, dy * per_mm);
            let (on, off) = (|[x, y]: [f64; 2]| dx * x + dy * y, |[x, y]: [f64; 2]| dx * y - dy * x);
            let (wide, high) = (reach(on(p), on(u), on(v), on(q)), reach(off(p), off(u), off(v), off(q)));
            let surface = wide * high + thick * (wide + high);
            if surface < best {
                (best, along) = (surface, [dx, dy]);
            }
        }
        let x = x * along[0] + y * along[1];
        Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
    }
}

/// From the least of four numbers to the greatest.
fn reach(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let less = |x: f64, y: f64| if x < y { x } else { y };
    let more = |x: f64, y: f64| if x > y { x } else { y };
    more(more(a, b), more(c, d)) - less(less(a, b), less(c, d))
}

/// The corners of a face, mm.
fn corners(mesh: &GridMesh, face: u32) -> [Point; 3] {
    let ([p, q, r], at) = (mesh.faces()[face as usize], |vertex: u32| mesh.vertices()[vertex as usize]);
    [at(p), at(q), at(r)]
}

/// An edge of a face: its vertices, the lower one first, the face, and which of its corners is not on the edge.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Edge {
    vertices: [u32; 2],
    face: u32,
    apex: u8,
}

/// All faces of a mesh in patches; the same on every machine.
pub(super) fn of(mesh: &GridMesh) -> Vec<Patch> {
    let mut free = vec![true; mesh.faces().len()];
    let mut patches = Vec::with_capacity(mesh.faces().len());
    let numbers = 0..mesh.faces().len() as u32;
    let longest = numbers.clone().into_par_iter().with_min_len(PARALLEL).map(|face| longest(mesh, face)).collect();
    join(mesh, longest, &mut free, &mut patches);
    let left = numbers.clone().filter(|face| free[*face as usize]);
    let edges = left.flat_map(|face| (0..3).map(move |k| edge(mesh, face, k))).collect();
    join(mesh, edges, &mut free, &mut patches);
    patches.extend(numbers.filter(|face| free[*face as usize]).map(|face| Patch::one(corners(mesh, face), face)));
    patches
}

/// Makes patches of neighbours among `edges` that are free and fit.
fn join(mesh: &GridMesh, mut edges: Vec<Edge>, free: &mut [bool], patches: &mut Vec<Patch>) {
    if edges.len() < PARALLEL {
        edges.sort_unstable();
    } else {
        edges.par_sort_unstable();
    }
    let mut waiting: Option<Edge> = None;
    for edge in edges {
        if !free[edge.face as usize] {
            continue;
        }
        let other = waiting.filter(|other| other.vertices == edge.vertices && free[other.face as usize]);
        if let Some(patch) = other.and_then(|other| both(mesh, other, edge)) {
            patch.faces.iter().for_each(|face| free[*face as usize] = false);
            patches.push(patch);
            waiting = None;
        } else {
            waiting = Some(edge);
        }
    }
}

/// The edge of a face that is behind a corner.
fn edge(mesh: &GridMesh, face: u32, corner: u8) -> Edge {
    let corners = mesh.faces()[face as usize];
    let (u, v) = (corners[(corner as usize + 1) % 3], corners[(corner as usize + 2) % 3]);
    Edge { vertices: [u.min(v), u.max(v)], face, apex: corner }
}

/// The longest edge of a face.
fn longest(mesh: &GridMesh, face: u32) -> Edge {
    let [p, q, r] = corners(mesh, face);
    let [of_p, of_q, of_r] = [(r - q).norm_squared(), (p - r).norm_squared(), (q - p).norm_squared()];
    let corner = if of_p >= of_q.max(of_r) { 0 } else { 1 + u8::from(of_q < of_r) };
    edge(mesh, face, corner)
}

/// The patch of two faces with an edge in common, if the box along it has hardly more surface around both than around each.
fn both(mesh: &GridMesh, one: Edge, other: Edge) -> Option<Patch> {
    let patch = Patch::two(mesh, [one.face, other.face], [one.apex, other.apex].map(usize::from));
    let [p, u, v, q] = patch.corners;
    let (along, p, q) = (v - u, p - u, q - u);
    // Of the first triangle all lies in the plane of the edge and its height.
    let square = along.norm_squared();
    let [px, qx] = [along.dot(&p) / square, along.dot(&q) / square];
    let (first, second) = (p - along * px, q - along * qx);
    let (above, beside) = (first.norm(), second.norm());
    let across = second.dot(&first) / above;
    let out = (beside * beside - across * across).max(0.0).sqrt();
    let length = square.sqrt();
    let (wide, high) = (length * reach(0.0, 1.0, px, qx), reach(0.0, above, across, across));
    let around_both = wide * high + high * out + out * wide;
    let around_each = length * (reach(0.0, 1.0, px, px) * above + reach(0.0, 1.0, qx, qx) * beside);
    // What is not a number, without an area, does not fit.
    (around_both <= NEARLY * around_each).then_some(patch)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::meshes;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn mesh(vertices: &[[f64; 3]], faces: &[[u32; 3]]) -> GridMesh {
        GridMesh::new(vertices.iter().copied().map(Point::from).collect(), faces.to_vec()).unwrap()
    }

    /// The faces of each patch, both sorted.
    fn faces(mesh: &GridMesh) -> Vec<Vec<u32>> {
        let mut found: Vec<Vec<u32>> = of(mesh).iter().map(|patch| patch.faces().to_vec()).collect();
        found.iter_mut().for_each(|faces| faces.sort_unstable());
        found.sort_unstable();
        found
    }

    #[test]
    fn every_face_is_in_one_patch_and_every_corner_in_its_own() {
        for mesh in
            [meshes::stepped_tool(24, 12), meshes::soup(300), meshes::degenerate(), meshes::torus(12.0, 4.0, 40, 20)]
        {
            let patches = of(&mesh);
            let mut seen: Vec<u32> = patches.iter().flat_map(|patch| patch.faces().to_vec()).collect();
            seen.sort_unstable();
            assert_eq!(seen, (0..mesh.faces().len() as u32).collect::<Vec<_>>());
            for patch in &patches {
                let of_faces: Vec<Point> = patch.faces().iter().flat_map(|&face| corners(&mesh, face)).collect();
                assert!(
                    of_faces.iter().all(|p| patch.corners.contains(p))
                        && patch.corners.iter().all(|p| of_faces.contains(p))
                );
            }
        }
    }

    #[test]
    fn a_rectangle_is_one_patch_however_its_corners_are_numbered() {
        // Divided along either diagonal, wound either way; and a triangle beside it, which is left.
        let vertices = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 3.0, 0.0], [0.0, 3.0, 0.0], [8.0, 0.0, 0.0]];
        for (one, other) in
            [([0, 1, 2], [0, 2, 3]), ([2, 0, 1], [3, 2, 0]), ([1, 2, 3], [3, 0, 1]), ([0, 1, 2], [0, 3, 2])]
        {
            assert_eq!(faces(&mesh(&vertices, &[one, [1, 4, 2], other])), [vec![0, 2], vec![1]], "{one:?} {other:?}");
        }
        // A box has six.
        assert!(faces(&meshes::cuboid(3.0, 20.0, 7.0)).iter().all(|faces| faces.len() == 2));
    }

    #[test]
    fn two_triangles_over_a_ridge_are_two_patches() {
        // Two squares' halves with the edge X in common, the second turned up by so many degrees.
        let patches = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            faces(&mesh(
                &[[0.0; 3], [1.0, 0.0, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5 * cos, 0.5 * sin]],
                &[[0, 1, 2], [1, 0, 3]],
            ))
            .len()
        };
        // Half the surfaces: 0.5 and 0.5 of both planes; around both 1·(0.5 + 0.5 cos) and (1.5 + 0.5 cos)·0.5 sin.
        assert_eq!([0.0, 5.0, 30.0, 90.0, 180.0].map(patches), [1, 1, 2, 2, 1]);
    }

    #[test]
    fn what_shares_no_edge_or_has_no_area_stays_alone() {
        let apart = mesh(
            &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [2.0, 2.0, 0.0]],
            &[[0, 1, 2], [3, 4, 1]],
        );
        assert_eq!(faces(&apart).len(), 2);
        let flat = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]], &[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(faces(&flat).len(), 2);
    }

    #[test]
    fn of_three_faces_on_one_edge_two_are_a_patch() {
        let vertices = [[0.0; 3], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [1.0, -0.5, 0.0]];
        assert_eq!(faces(&mesh(&vertices, &[[0, 1, 2], [1, 0, 3], [1, 0, 4]])).len(), 2);
    }

    /// The axes of a patch, each with its sign and place left open.
    fn has_axis(frame: &Matrix3<f64>, axis: Vector) -> bool {
        (0..3).any(|k| frame.column(k).dot(&axis.normalize()).abs() > 1.0 - 1e-12)
    }

    #[test]
    fn the_axes_of_a_rectangle_are_its_sides() {
        let turn = nalgebra::Rotation3::from_scaled_axis(Vector::new(0.4, -1.1, 0.7));
        let at = |x: f64, y: f64| Point::from(turn * Vector::new(x, y, 0.0));
        let patch = |corners: [Point; 4]| Patch { corners, faces: [0, 1], count: 2 };
        for corners in [
            [at(4.0, 0.0), at(4.0, 3.0), at(0.0, 0.0), at(0.0, 3.0)],
            [at(0.0, 0.0), at(4.0, 0.0), at(0.0, 3.0), at(4.0, 3.0)],
        ] {
            let frame = patch(corners).frame();
            assert!((frame.tr_mul(&frame) - Matrix3::identity()).amax() < 1e-15 && frame.determinant() > 0.0);
            assert!(has_axis(&frame, turn * Vector::x()) && has_axis(&frame, turn * Vector::y()));
        }
        // A dart, along the edge that its hull has and neither triangle: 8 by 1.
        let dart = patch([at(0.0, 0.0), at(4.0, 0.5), at(4.0, 1.0), at(8.0, 0.0)]).frame();
        assert!(has_axis(&dart, turn * Vector::x()), "{dart}");
    }

    #[test]
    fn no_other_edge_has_a_smaller_box() {
        let mut random = Pcg64::seed_from_u64(5);
        for round in 0..200 {
            // Flat ones, and ones that are as thick as they are wide.
            let thick = 0.01 * f64::from(round);
            let mut corner = || Point::new(random.random(), random.random(), thick * random.random::<f64>());
            let corners = [corner(), corner(), corner(), corner()];
            let frame = Patch { corners, faces: [0, 1], count: 2 }.frame();
            let surface = |frame: &Matrix3<f64>| {
                let [p, u, v, q] = corners.map(|p| frame.tr_mul(&p.coords));
                let size = |k: usize| reach(p[k], u[k], v[k], q[k]);
                size(0) * size(1) + size(1) * size(2) + size(2) * size(0)
            };
            let z = frame.column(2).into_owned();
            for (i, j) in [(0, 1), (0, 2), (3, 1), (3, 2), (0, 3)] {
                let edge = corners[j] - corners[i];
                let x = (edge - z * z.dot(&edge)).normalize();
                let along = Matrix3::from_columns(&[x, z.cross(&x), z]);
                assert!(surface(&frame) <= surface(&along) * (1.0 + 1e-9), "{round}: {i} {j}");
            }
        }
    }

    #[test]
    fn one_triangle_has_its_own_axes_and_a_segment_has_axes_too() {
        let triangle = Patch::one([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(Point::from), 0).frame();
        assert!(has_axis(&triangle, Vector::new(-3.0, 4.0, 0.0)));
        let segment = Patch::one([[0.0; 3], [1.0, 2.0, 2.0], [2.0, 4.0, 4.0]].map(Point::from), 0).frame();
        assert!(has_axis(&segment, Vector::new(1.0, 2.0, 2.0)));
    }
}
