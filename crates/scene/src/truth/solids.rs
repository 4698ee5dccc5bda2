//! Watertight solids for the tests of this module.

use crate::geometry::{Mesh, Point};
use std::f64::consts::TAU;

/// A block about the origin with the given sides, mm, 12 triangles.
pub(super) fn block(x: f64, y: f64, z: f64) -> Mesh {
    let corner = |bits: usize| {
        let pick = |i: usize, side: f64| if bits >> i & 1 == 1 { side / 2.0 } else { -side / 2.0 };
        Point::new(pick(0, x), pick(1, y), pick(2, z))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh::new((0..8).map(corner).collect(), faces).unwrap()
}

/// A torus about the z axis, mm, 2·`around`·`section` triangles.
pub(super) fn torus(major: f64, minor: f64, around: u32, section: u32) -> Mesh {
    let vertex = |i: u32, j: u32| {
        let (u, v) = (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(section));
        let rho = major + minor * v.cos();
        Point::new(rho * u.cos(), rho * u.sin(), minor * v.sin())
    };
    let index = |i: u32, j: u32| (i % around) * section + j % section;
    let grid = || (0..around).flat_map(|i| (0..section).map(move |j| (i, j)));
    let faces = grid().flat_map(|(i, j)| {
        let (a, b, c, d) = (index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
        [[a, b, c], [a, c, d]]
    });
    Mesh::new(grid().map(|(i, j)| vertex(i, j)).collect(), faces.collect()).unwrap()
}

/// A ball about the origin with poles on the z axis, mm, 4·`rings`·(`rings` - 1) triangles.
pub(super) fn ball(radius: f64, rings: u32) -> Mesh {
    let sectors = 2 * rings;
    let mut vertices = vec![Point::new(0.0, 0.0, radius), Point::new(0.0, 0.0, -radius)];
    for i in 1..rings {
        for j in 0..sectors {
            let (polar, azimuth) =
                (TAU / 2.0 * f64::from(i) / f64::from(rings), TAU * f64::from(j) / f64::from(sectors));
            let rho = radius * polar.sin();
            vertices.push(Point::new(rho * azimuth.cos(), rho * azimuth.sin(), radius * polar.cos()));
        }
    }
    let index = |i: u32, j: u32| match i {
        0 => 0,
        i if i == rings => 1,
        i => 2 + (i - 1) * sectors + j % sectors,
    };
    let mut faces = Vec::new();
    for j in 0..sectors {
        for i in 0..rings {
            let (a, b, c, d) = (index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
            if i + 1 < rings {
                faces.push([a, b, c]);
            }
            if i > 0 {
                faces.push([a, c, d]);
            }
        }
    }
    // At the poles one corner of the quadrilateral is doubled; the other half remains.
    Mesh::new(vertices, faces).unwrap()
}
