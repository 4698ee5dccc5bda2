//! The meshes that the suite tries volumes on: small, and together of every kind that has ever broken one.

use super::draw::Draw;
use crate::engine::geometry::{GridMesh, Isometry, Point, Triangle, Vector};
use std::f64::consts::TAU;

/// A mesh and what it is called in a fault.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Its name.
    pub name: &'static str,
    /// Its surface, mm.
    pub mesh: GridMesh,
}

/// The mesh of loose triangles, which are known to be good.
fn mesh(triangles: &[Triangle]) -> GridMesh {
    GridMesh::from_triangles(triangles).expect("the suite's meshes are finite and in range")
}

/// A polygon in the half plane (radius, height), mm, turned about z in `steps` steps. The polygon is closed when `is_closed`
/// (a torus), otherwise its ends should lie on the axis (a sphere, a tool). Triangles without area, at the axis, are left
/// out.
#[must_use]
pub fn revolve(profile: &[[f64; 2]], is_closed: bool, steps: u32) -> GridMesh {
    let at = |[radius, height]: [f64; 2], step: u32| {
        let (sin, cos) = (TAU * f64::from(step % steps) / f64::from(steps)).sin_cos();
        Point::new(radius * cos, radius * sin, height)
    };
    let mut triangles = Vec::new();
    let ends = if is_closed { profile.len() } else { profile.len() - 1 };
    for (i, &from) in profile.iter().enumerate().take(ends) {
        let to = profile[(i + 1) % profile.len()];
        for step in 0..steps {
            let quad = [at(from, step), at(from, step + 1), at(to, step + 1), at(to, step)];
            triangles.push(Triangle::new(quad[0], quad[1], quad[2]));
            triangles.push(Triangle::new(quad[0], quad[2], quad[3]));
        }
    }
    triangles.retain(|t| t.area() > 0.0);
    mesh(&triangles)
}

/// A ring of radius `ring` whose wire has the radius `wire`, mm, with `around` by `across` quadrilaterals.
#[must_use]
pub fn torus(ring: f64, wire: f64, around: u32, across: u32) -> GridMesh {
    let profile: Vec<[f64; 2]> = (0..across)
        .map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(across)).sin_cos();
            [ring + wire * cos, wire * sin]
        })
        .collect();
    revolve(&profile, true, around)
}

/// A sphere of the given radius, mm, with `around` meridians and `across` bands.
#[must_use]
pub fn sphere(radius: f64, around: u32, across: u32) -> GridMesh {
    let profile: Vec<[f64; 2]> = (0..=across)
        .map(|i| {
            let (sin, cos) = (0.5 * TAU * f64::from(i) / f64::from(across)).sin_cos();
            [if i == 0 || i == across { 0.0 } else { radius * sin }, -radius * cos]
        })
        .collect();
    revolve(&profile, false, around)
}

/// A tool: a slim cutter, finely divided along its length, on a shank and a holder with few large faces. Corners crowd at
/// the tip, area at the other end.
#[must_use]
pub fn stepped_tool(around: u32, bands: u32) -> GridMesh {
    let mut profile = vec![[0.0, 0.0]];
    profile.extend((0..=bands).map(|i| [3.0, 20.0 * f64::from(i) / f64::from(bands)]));
    profile.extend([[6.0, 20.0], [6.0, 50.0], [20.0, 50.0], [20.0, 80.0], [0.0, 80.0]]);
    revolve(&profile, false, around)
}

/// A cuboid of twelve triangles about the origin, with the given edge lengths, mm.
#[must_use]
pub fn cuboid(x: f64, y: f64, z: f64) -> GridMesh {
    let corner = |i: u8| {
        let side = |bit: u8, length: f64| if i >> bit & 1 == 1 { length / 2.0 } else { -length / 2.0 };
        Point::new(side(0, x), side(1, y), side(2, z))
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    mesh(&halves.map(|face| Triangle { corners: face.map(corner) }).collect::<Vec<_>>())
}

/// Unconnected triangles of very different sizes inside ±30 mm.
#[must_use]
pub fn soup(count: u32) -> GridMesh {
    let mut draw = Draw::new(0, &["conformance", "soup"], 0);
    let mut triangles = Vec::new();
    for _ in 0..count {
        let middle = Point::from(draw.in_ball() * 20.0);
        let size = draw.log_uniform(0.01, 10.0);
        triangles.push(Triangle { corners: [(); 3].map(|()| middle + draw.in_ball() * size) });
    }
    mesh(&triangles)
}

/// Points, segments, slivers, and the same triangle again and again.
#[must_use]
pub fn degenerate() -> GridMesh {
    let mut draw = Draw::new(0, &["conformance", "degenerate"], 0);
    let mut triangles = Vec::new();
    for _ in 0..4 {
        let [p, q, r] = [(); 3].map(|()| Point::from(draw.in_ball() * 10.0));
        triangles.push(Triangle::new(p, p, p));
        triangles.push(Triangle::new(p, q, p));
        triangles.push(Triangle::new(p, q, nalgebra::center(&p, &q)));
        triangles.push(Triangle::new(p, q, q + (r - q) * 1e-7));
        triangles.extend([Triangle::new(p, q, r); 3]);
    }
    mesh(&triangles)
}

/// A mesh moved and scaled: every vertex `v` becomes `motion · (scale · v)`, snapped.
///
/// # Panics
/// When that leaves the range of a [`GridMesh`].
#[must_use]
pub fn moved(mesh: &GridMesh, scale: f64, motion: &Isometry) -> GridMesh {
    let vertices = mesh.vertices().iter().map(|v| motion * (v * scale)).collect();
    GridMesh::new(vertices, mesh.faces().to_vec()).expect("the suite moves meshes within their range")
}

/// Everything that a tree must be able to hold.
#[must_use]
pub fn subjects() -> Vec<Subject> {
    let p = Point::new;
    let right = Triangle::new(p(0.0, 0.0, 0.0), p(3.0, 0.0, 0.0), p(0.0, 4.0, 0.0));
    let far = Isometry::translation(3000.0, -2500.0, 3900.0);
    let turned = Isometry::rotation(Vector::new(0.3, -1.1, 0.7));
    let subject = |name, mesh| Subject { name, mesh };
    vec![
        subject("sphere", sphere(10.0, 12, 7)),
        subject("torus", torus(12.0, 4.0, 14, 7)),
        subject("stepped tool", stepped_tool(10, 6)),
        subject("soup", soup(60)),
        subject("cuboid", cuboid(20.0, 12.0, 5.0)),
        subject("degenerate", degenerate()),
        subject("one triangle", mesh(&[right])),
        subject("two triangles", mesh(&[right, right.map(|q| q + Vector::z())])),
        subject("a point", mesh(&[Triangle::new(p(1.0, 2.0, 3.0), p(1.0, 2.0, 3.0), p(1.0, 2.0, 3.0))])),
        subject(
            "a segment, five times",
            mesh(&[Triangle::new(p(1.0, 2.0, 3.0), p(4.0, 2.0, 3.0), p(2.0, 2.0, 3.0)); 5]),
        ),
        subject("torus of 0.001 mm", moved(&torus(12.0, 4.0, 14, 7), 0.001 / 32.0, &turned)),
        subject("cuboid of 8000 mm", moved(&cuboid(20.0, 12.0, 5.0), 400.0, &Isometry::identity())),
        subject("stepped tool far from its origin", moved(&stepped_tool(10, 6), 1.0, &far)),
        subject("cuboid, turned", moved(&cuboid(20.0, 12.0, 5.0), 1.0, &turned)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solids_are_watertight_and_of_the_right_size() {
        for solid in [sphere(10.0, 12, 7), torus(12.0, 4.0, 14, 7), stepped_tool(10, 6), cuboid(1.0, 2.0, 3.0)] {
            assert!(solid.edge_report().is_watertight());
            assert!(solid.signed_volume() > 0.0);
        }
        assert_eq!(cuboid(1.0, 2.0, 3.0).signed_volume(), 6.0);
        // Guldin: 2π·12 · π·4² = 3790 for the round torus; the inscribed one is a little smaller.
        let volume = torus(12.0, 4.0, 60, 40).signed_volume();
        assert!(volume > 3700.0 && volume < 3790.0, "{volume}");
    }

    #[test]
    fn names_are_unique() {
        let mut names: Vec<_> = subjects().iter().map(|subject| subject.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), subjects().len());
    }
}
