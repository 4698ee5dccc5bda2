//! Blocks with a free-form top: a uniform bicubic B-spline over a net of heights.
//!
//! The surface is a height field, z over x and y. It has hollows, saddles, thin fins and walls as steep as the net allows, like the test
//! surfaces of the literature on 5-axis machining, but no undercuts. Basis: Piegl and Tiller, "The NURBS Book", 1997, section 2. Away from
//! the ends, the B-splines of uniform knots are four fixed cubics per interval. The net is extrapolated linearly beyond its ends, so that
//! the surface passes through its corner heights.

use super::super::{Point, Vector};
use super::error::{Fault, ShapeError, length};
use super::solid::Surface;
use super::tessellation::{Sizing, affordable};
use serde::{Deserialize, Serialize};

/// Ratio of the edge length of plane faces to that of the free-form face.
const FINER_THAN_PLANES: f64 = 16.0;

/// A block with a free-form top; x and y extend from minus to plus half the size, and the bottom is at z = 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Freeform {
    /// Size in x and y, mm.
    pub size_mm: [f64; 2],
    /// Heights of the control net, mm, above 0: rows from low to high y, and within a row from low to high x. At least 2 by 2; all rows
    /// have one length.
    pub heights_mm: Vec<Vec<f64>>,
}

/// The four uniform cubic B-splines at t in [0, 1], and their derivatives.
fn basis(t: f64) -> ([f64; 4], [f64; 4]) {
    let s = 1.0 - t;
    let value = [s * s * s, 3.0 * t * t * t - 6.0 * t * t + 4.0, 3.0 * s * s * s - 6.0 * s * s + 4.0, t * t * t];
    let slope = [-s * s, 3.0 * t * t - 4.0 * t, -3.0 * s * s + 4.0 * s, t * t];
    (value.map(|v| v / 6.0), slope.map(|v| v / 2.0))
}

impl Freeform {
    /// Checks all fields.
    ///
    /// # Errors
    /// [`ShapeError`] that names the faulty field.
    pub fn check(&self) -> Result<(), ShapeError> {
        for (i, &size) in self.size_mm.iter().enumerate() {
            length(&format!("size_mm[{i}]"), size)?;
        }
        let columns = self.heights_mm.first().map_or(0, Vec::len);
        if self.heights_mm.len() < 2 || columns < 2 {
            return Err(Fault::TooFewPoints(self.heights_mm.len().min(columns)).at("heights_mm"));
        }
        for (j, row) in self.heights_mm.iter().enumerate() {
            if row.len() != columns {
                return Err(Fault::Ragged { found: row.len(), expected: columns }.at(format!("heights_mm[{j}]")));
            }
            for (i, &height) in row.iter().enumerate() {
                length(&format!("heights_mm[{j}][{i}]"), height)?;
            }
        }
        Ok(())
    }

    /// The height of the net at an integer position, extrapolated linearly beyond the ends.
    fn net(&self, i: isize, j: isize) -> f64 {
        let along = |k: isize, n: usize, at: &dyn Fn(usize) -> f64| {
            let last = n as isize - 1;
            if k < 0 {
                2.0 * at(0) - at(1)
            } else if k > last {
                2.0 * at(n - 1) - at(n - 2)
            } else {
                at(k as usize)
            }
        };
        let rows = &self.heights_mm;
        along(j, rows.len(), &|row| along(i, rows[row].len(), &|column| rows[row][column]))
    }

    /// The point of the top surface at (u, v) in [0, 1]², mm, and its upward unit normal. The net must have passed [`Freeform::check`].
    pub fn at(&self, u: f64, v: f64) -> (Point, Vector) {
        let cell = |w: f64, n: usize| {
            let intervals = (n - 1) as f64;
            let k = (w * intervals).floor().clamp(0.0, intervals - 1.0);
            (k as isize, w * intervals - k, intervals)
        };
        let (i, s, across) = cell(u, self.heights_mm[0].len());
        let (j, t, along) = cell(v, self.heights_mm.len());
        let ((bu, du), (bv, dv)) = (basis(s), basis(t));
        let (mut z, mut zu, mut zv) = (0.0, 0.0, 0.0);
        for (row, (b, d)) in bv.iter().zip(&dv).enumerate() {
            for (column, (c, e)) in bu.iter().zip(&du).enumerate() {
                let height = self.net(i + column as isize - 1, j + row as isize - 1);
                z += b * c * height;
                zu += b * e * height;
                zv += d * c * height;
            }
        }
        let [x, y] = self.size_mm;
        let normal = Vector::new(-zu * across / x, -zv * along / y, 1.0).normalize();
        (Point::new((u - 0.5) * x, (v - 0.5) * y, z), normal)
    }

    pub(super) fn surface(&self, sizing: &Sizing) -> Result<Surface, ShapeError> {
        self.check()?;
        let [n, m] = self.size_mm.map(|size| ((size * FINER_THAN_PLANES / sizing.flat_edge()).round() as usize).max(2));
        affordable("size_mm", &[2, n + 2, m + 2])?;
        let mut surface = Surface::default();
        let at = |i: usize, j: usize| self.at(i as f64 / n as f64, j as f64 / m as f64).0;
        let mut top = Vec::with_capacity((n + 1) * (m + 1));
        for j in 0..=m {
            for i in 0..=n {
                let point = at(i, j);
                if point.z <= 0.0 {
                    return Err(Fault::OutOfRange { value: point.z, low: 0.0, high: f64::MAX }.at("heights_mm"));
                }
                top.push(surface.vertex(point));
            }
        }
        let top = |i: usize, j: usize| top[j * (n + 1) + i];
        for j in 0..m {
            for i in 0..n {
                surface.quad(top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1));
            }
        }
        // The rim, counter-clockwise seen from above; the walls below it; the bottom as a fan.
        let rim: Vec<(usize, usize)> = (0..n)
            .map(|i| (i, 0))
            .chain((0..m).map(|j| (n, j)))
            .chain((0..n).map(|i| (n - i, m)))
            .chain((0..m).map(|j| (0, m - j)))
            .collect();
        let high: Vec<u32> = rim.iter().map(|&(i, j)| top(i, j)).collect();
        let low: Vec<u32> = rim
            .iter()
            .map(|&(i, j)| {
                let p = at(i, j);
                surface.vertex(Point::new(p.x, p.y, 0.0))
            })
            .collect();
        let middle = surface.vertex(Point::origin());
        surface.band(&low, &high);
        for (k, &from) in low.iter().enumerate() {
            surface.triangle(middle, low[(k + 1) % low.len()], from);
        }
        Ok(surface)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Shape, Tessellation};
    use super::*;

    fn saddle() -> Freeform {
        Freeform {
            size_mm: [60.0, 40.0],
            heights_mm: vec![
                vec![20.0, 30.0, 20.0],
                vec![25.0, 20.0, 25.0],
                vec![20.0, 30.0, 20.0],
                vec![10.0, 12.0, 9.0],
            ],
        }
    }

    #[test]
    fn corners_are_the_nets_and_a_tilted_plane_stays_one() {
        let (p, _) = saddle().at(0.0, 0.0);
        assert!((p - Point::new(-30.0, -20.0, 20.0)).norm() < 1e-12);
        let (p, _) = saddle().at(1.0, 1.0);
        assert!((p - Point::new(30.0, 20.0, 9.0)).norm() < 1e-12);
        let plane =
            Freeform { size_mm: [30.0, 20.0], heights_mm: vec![vec![10.0, 13.0, 16.0], vec![11.0, 14.0, 17.0]] };
        let (p, normal) = plane.at(0.3, 0.8);
        assert!((p.z - (10.0 + 0.3 * 6.0 + 0.8)).abs() < 1e-12);
        // Slopes 6 / 30 and 1 / 20.
        assert!((normal - Vector::new(-0.2, -0.05, 1.0).normalize()).norm() < 1e-12);
    }

    #[test]
    fn normals_are_those_of_differences_and_pieces_join_smoothly() {
        let surface = saddle();
        for (u, v) in [(0.2, 0.3), (0.5, 1.0 / 3.0), (0.9, 0.66), (0.5, 0.5)] {
            let h = 1e-6;
            let along_u = surface.at(u + h, v).0 - surface.at(u - h, v).0;
            let along_v = surface.at(u, v + h).0 - surface.at(u, v - h).0;
            let expected = along_u.cross(&along_v).normalize();
            assert!((surface.at(u, v).1 - expected).norm() < 1e-7);
        }
    }

    #[test]
    fn the_solid_is_watertight_at_any_density_and_bad_nets_are_refused() {
        for density in [0.3, 1.0, 3.0] {
            let mesh = Shape::Freeform(saddle()).mesh(&Tessellation { density, grading: 1.0 }).unwrap();
            assert!(mesh.edge_report().is_watertight() && mesh.signed_volume() > 0.0);
        }
        let message = |heights_mm: Vec<Vec<f64>>| {
            let shape = Shape::Freeform(Freeform { heights_mm, ..saddle() });
            shape.mesh(&Tessellation::default()).unwrap_err().to_string()
        };
        assert!(message(vec![vec![1.0, 2.0], vec![1.0]]).starts_with("heights_mm[1]: "));
        assert!(message(vec![vec![1.0, 2.0]]).starts_with("heights_mm: "));
        assert!(message(vec![vec![1.0, -2.0], vec![1.0, 1.0]]).starts_with("heights_mm[0][1]: "));
    }
}
