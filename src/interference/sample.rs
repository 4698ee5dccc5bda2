//! The surface as points: a mesh sampled so densely that no point of it is farther from a sample than a stated radius.

use crate::geometry::{Mesh, Point};
use std::collections::BTreeSet;

/// Samples of a surface, in its mesh's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Samples {
    /// The samples, mm.
    pub points: Vec<Point>,
    /// The triangle that each one lies on (one of them, on an edge).
    pub faces: Vec<u32>,
    /// Every point of the surface has a sample at most this far, mm.
    pub covering_mm: f64,
    /// The longest edge of the grid on a triangle, mm.
    pub spacing_mm: f64,
}

impl Samples {
    /// Divides each triangle into n² similar ones whose edges are at most `spacing_mm` long and takes their corners. No point of a
    /// triangle is farther from its corners than its longest edge over √3 (the equilateral one's circumradius; others are
    /// less: in an obtuse one every point is within half the longest edge of a corner), which gives the covering radius.
    #[must_use]
    pub fn of(mesh: &Mesh, spacing_mm: f64) -> Self {
        let mut samples = Self { points: Vec::new(), faces: Vec::new(), covering_mm: 0.0, spacing_mm: 0.0 };
        let mut corners_taken = vec![false; mesh.vertices().len()];
        let mut edges_taken = BTreeSet::new();
        for (face, &corners) in mesh.faces().iter().enumerate() {
            let [a, b, c] = corners.map(|corner| mesh.vertices()[corner as usize]);
            let longest = [(a, b), (b, c), (c, a)].into_iter().map(|(p, q)| (q - p).norm()).fold(0.0, f64::max);
            let n = (longest / spacing_mm).ceil().max(1.0);
            samples.spacing_mm = samples.spacing_mm.max(longest / n);
            let n = n as u32;
            // Edges that two triangles divide alike are taken once.
            let owned = [0, 1, 2].map(|i| {
                let (from, to) = (corners[i], corners[(i + 1) % 3]);
                edges_taken.insert((from.min(to), from.max(to), n))
            });
            for i in 0..=n {
                for j in 0..=n - i {
                    // Weights: b gets i, c gets j, a the rest.
                    let rest = n - i - j;
                    let corner = [(rest, 0), (i, 1), (j, 2)].into_iter().find(|(weight, _)| *weight == n);
                    let is_new = if let Some((_, corner)) = corner {
                        !std::mem::replace(&mut corners_taken[corners[corner] as usize], true)
                    } else {
                        // The edge on which the third corner has no weight.
                        [(j, 0), (rest, 1), (i, 2)].into_iter().all(|(weight, edge)| weight > 0 || owned[edge])
                    };
                    if is_new {
                        let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                        samples.points.push(a + (b - a) * u + (c - a) * v);
                        samples.faces.push(face as u32);
                    }
                }
            }
        }
        samples.covering_mm = samples.spacing_mm / 3f64.sqrt();
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::meshes;
    use crate::geometry::Triangle;
    use proptest::prelude::*;

    #[test]
    fn a_square_of_two_triangles_has_its_grid_once() {
        let [a, b, c, d] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, y]| Point::new(x, y, 0.0));
        let mesh = Mesh::from_triangles(&[Triangle::new(a, b, c), Triangle::new(a, c, d)]).unwrap();
        // The diagonal is 2.83 long: three pieces; 4 x 4 grid points, the diagonal's four shared.
        let samples = Samples::of(&mesh, 1.0);
        assert_eq!(samples.points.len(), 16);
        assert!((samples.spacing_mm - 8f64.sqrt() / 3.0).abs() < 1e-15);
        let mut seen: Vec<_> = samples.points.iter().map(|p| [p.x, p.y].map(|x| (3.0 * x).round() as i32)).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 16);
        assert_eq!(Samples::of(&mesh, 10.0).points.len(), 4);
    }

    proptest! {
        #[test]
        fn no_point_of_the_surface_is_farther_than_the_covering_radius(
            spacing in 0.3..8.0f64, face in 0..10_000usize, u in 0.0..1.0f64, v in 0.0..1.0f64,
        ) {
            let mesh = meshes::stepped_tool(12, 3);
            let samples = Samples::of(&mesh, spacing);
            let triangle = mesh.triangles()[face % mesh.faces().len()];
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let [a, b, c] = triangle.corners;
            let p = a + (b - a) * u + (c - a) * v;
            let nearest = samples.points.iter().map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest <= samples.covering_mm + 1e-12, "{nearest} > {}", samples.covering_mm);
            prop_assert!(samples.spacing_mm <= spacing);
        }
    }
}
