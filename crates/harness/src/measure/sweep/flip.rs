//! Flips diagonals, which gives another triangulation of the same surface.

use crate::geometry::{Mesh, Point};
use obbtree::cases::Draw;
use std::collections::BTreeMap;

/// Two faces are coplanar when the dot product of their unit normals is below 1 by at most this. Corners are on a grid of 2⁻²⁶ mm, which
/// rotates the normal of a triangle 0.01 mm high by up to 1.5e-6, and 1 - cos of that is 1e-12.
const COPLANAR: f64 = 1e-11;

/// Flips a share (0 to 1) of the diagonals of plane, strictly convex quadrilaterals; the same seed gives the same mesh. A face belongs to
/// at most one such quadrilateral, so flips do not interfere. Surface, vertices and number of faces are unchanged.
pub fn flip_diagonals(mesh: &Mesh, share: f64, seed: u64) -> Mesh {
    let mut faces = mesh.faces().to_vec();
    let mut edges: BTreeMap<(u32, u32), Vec<(usize, usize)>> = BTreeMap::new();
    for (face, corners) in faces.iter().enumerate() {
        for side in 0..3 {
            let (p, q) = (corners[side], corners[(side + 1) % 3]);
            edges.entry((p.min(q), p.max(q))).or_default().push((face, side));
        }
    }
    let mut draw = Draw::new(seed, &["flips"], 0);
    let mut taken = vec![false; faces.len()];
    for sides in edges.values() {
        let &[(f, side_f), (g, side_g)] = sides.as_slice() else { continue };
        let at = |face: usize, side: usize| faces[face][side % 3];
        // The quadrilateral p, r, q, s around the diagonal pq.
        let (p, q, s, r) = (at(f, side_f), at(f, side_f + 1), at(f, side_f + 2), at(g, side_g + 2));
        if taken[f] || taken[g] || !is_plane_and_convex(mesh, [p, r, q, s]) {
            continue;
        }
        (taken[f], taken[g]) = (true, true);
        if draw.unit() < share {
            (faces[f], faces[g]) = ([p, r, s], [r, q, s]);
        }
    }
    // The same vertices, and the corners of each face are still valid.
    Mesh::new(mesh.vertices().to_vec(), faces).expect("flipping a diagonal keeps a mesh a mesh")
}

/// Whether both diagonals of a quadrilateral divide it into two coplanar triangles of the same orientation.
fn is_plane_and_convex(mesh: &Mesh, quadrilateral: [u32; 4]) -> bool {
    let [p, r, q, s] = quadrilateral.map(|v| mesh.vertices()[v as usize]);
    let normal = |a: Point, b: Point, c: Point| (b - a).cross(&(c - a)).try_normalize(0.0);
    let normals = [normal(p, q, s), normal(q, p, r), normal(p, r, s), normal(r, q, s)];
    let Some(first) = normals[0] else { return false };
    normals.iter().all(|n| n.is_some_and(|n| n.dot(&first) > 1.0 - COPLANAR))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Triangle;
    use obbtree::cases::meshes;

    fn area(mesh: &Mesh) -> f64 {
        mesh.triangles().iter().map(Triangle::area).sum()
    }

    #[test]
    fn a_flipped_cuboid_is_the_same_cuboid() {
        let cuboid = meshes::cuboid(2.0, 3.0, 5.0);
        let flipped = flip_diagonals(&cuboid, 1.0, 1);
        assert!(flipped.edge_report().is_watertight());
        assert!((flipped.signed_volume() - 30.0).abs() < 1e-9 && (area(&flipped) - 62.0).abs() < 1e-9); // 2 (6 + 10 + 15)
        let changed = cuboid.faces().iter().zip(flipped.faces()).filter(|(a, b)| a != b).count();
        assert_eq!(changed, 12); // every face is half of one of six rectangles
        assert_eq!(flip_diagonals(&cuboid, 0.0, 1), cuboid);
    }

    #[test]
    fn a_share_flips_about_that_share() {
        let tool = meshes::stepped_tool(12, 40);
        let changed = |share: f64| {
            let flipped = flip_diagonals(&tool, share, 1);
            assert!(flipped.edge_report().is_watertight());
            assert!((area(&flipped) / area(&tool) - 1.0).abs() < 1e-9);
            tool.faces().iter().zip(flipped.faces()).filter(|(a, b)| a != b).count()
        };
        let all = changed(1.0);
        assert!(all > 100 && (changed(0.5) as f64 / all as f64 - 0.5).abs() < 0.1);
    }
}
