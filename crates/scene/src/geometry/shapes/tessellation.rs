//! How finely a shape is divided, and where.
//!
//! A curve is divided as in a CAD kernel, by the distance of a chord from the curve. The sagitta of a chord that spans the angle a at
//! radius r is r·a²/8, so a full turn takes 2π·√(r/8s) segments for a sagitta s. Straight edges and plane faces need no division to keep
//! their shape. They are divided all the same, at a fixed edge length, because a change of the grading moves triangles between them and the
//! details.

use super::error::{Fault, ShapeError, within};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Sagitta of a chord at density 1 and grading 1, mm: as in a coarse STL export of a machine model.
const SAGITTA_MM: f64 = 0.02;
/// Edge length of plane faces at density 1 and grading 1, mm.
const FLAT_EDGE_MM: f64 = 40.0;
/// The radius that grading does not change, mm. Smaller radii are details, larger ones are large areas: a clamping screw's thread, a hole
/// and a fillet have a few mm, a chuck or a hand wheel 50 and more.
const NEUTRAL_RADIUS_MM: f64 = 10.0;
/// Fewest and most segments of a full turn. Fewer than 8 no longer look round; more than 2048 have no use.
const TURN: (f64, f64) = (8.0, 2048.0);
/// Most triangles of one shape.
pub(super) const MOST_TRIANGLES: usize = 4_000_000;
/// Limits of [`Tessellation::density`].
const DENSITY: (f64, f64) = (0.05, 20.0);
/// Limits of [`Tessellation::grading`].
const GRADING: (f64, f64) = (1.0 / 16.0, 16.0);

/// How finely a shape is divided, and where.
///
/// A curve of radius r mm gets 2π·√(r/0.16) segments per full turn times `density · grading^(e/2)`, where e = (10 -
/// r)/(10 + r) runs from 1 for the finest detail over 0 at a radius of 10 mm to -1 for a plane. Straight edges and
/// plane faces are divided so that their edges are about 40 mm or shorter, divided by `density · grading^(-1/2)`.
///
/// When the grading is not 1, all numbers of segments are scaled by a common factor, found by bisection, that restores the number of
/// triangles at grading 1. Whole segments and their minimum numbers (8 per turn, 1 per edge) limit its accuracy to a few per cent for a
/// part of some thousand triangles. If a shape has only details or only large areas, as a plain ball does, the grading hardly changes it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tessellation {
    /// Balance between details and large areas, 1/16 to 16; neutral at 1. Above 1, triangles move from large areas to fillets, holes and
    /// threads; below 1, the other way. At either limit, the number of segments of the finest curves changes by a factor of 16 relative to
    /// that of plane faces.
    pub grading: f64,
    /// Factor on the number of segments everywhere, so the number of triangles grows roughly with its square; 0.05 to 20.
    pub density: f64,
}

impl Default for Tessellation {
    fn default() -> Self {
        Self { grading: 1.0, density: 1.0 }
    }
}

impl Tessellation {
    /// Checks the limits.
    ///
    /// # Errors
    /// [`ShapeError`] naming `grading` or `density`.
    pub fn check(&self) -> Result<(), ShapeError> {
        within("grading", self.grading, GRADING.0, GRADING.1)?;
        within("density", self.density, DENSITY.0, DENSITY.1)?;
        Ok(())
    }
}

/// A tessellation with its common factor; the builders of surfaces take their numbers of segments from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizing {
    density: f64,
    grading: f64,
}

impl Sizing {
    pub fn new(tessellation: &Tessellation, factor: f64) -> Self {
        Self { density: tessellation.density * factor, grading: tessellation.grading }
    }

    /// The same sizing, `factor` times as dense.
    pub fn denser(&self, factor: f64) -> Self {
        Self { density: self.density * factor, grading: self.grading }
    }

    /// Segments of a full turn of radius `radius` mm, before rounding to an integer.
    fn turn(&self, radius: f64) -> f64 {
        let detail = (NEUTRAL_RADIUS_MM - radius) / (NEUTRAL_RADIUS_MM + radius);
        let by_sagitta = TAU * (radius / (8.0 * SAGITTA_MM)).sqrt();
        (by_sagitta.max(TURN.0) * self.density * self.grading.powf(detail / 2.0)).clamp(TURN.0, TURN.1)
    }

    /// Segments of a full circle: a multiple of 4, so that circles have vertices on the axes.
    pub fn circle(&self, radius: f64) -> usize {
        4 * (self.turn(radius) / 4.0).round() as usize
    }

    /// Segments of an arc of `sweep` radians; at least 1.
    pub fn arc(&self, radius: f64, sweep: f64) -> usize {
        ((self.turn(radius) * sweep.abs() / TAU).round() as usize).max(1)
    }

    /// Longest edge of a plane face, mm.
    pub fn flat_edge(&self) -> f64 {
        FLAT_EDGE_MM * self.grading.sqrt() / self.density
    }

    /// Pieces of a straight edge; at least 1.
    pub fn straight(&self, length: f64) -> usize {
        ((length / self.flat_edge()).round() as usize).max(1)
    }
}

/// Steps of the bisection. The factor is then known to 2^(1/64), finer than the resolution of whole segments.
const BISECTIONS: usize = 10;

/// The factor at which `count` is closest to its value at grading 1.
pub(super) fn balance(
    tessellation: &Tessellation,
    count: impl Fn(&Sizing) -> Result<usize, ShapeError>,
) -> Result<f64, ShapeError> {
    if tessellation.grading == 1.0 {
        return Ok(1.0);
    }
    let target = count(&Sizing::new(&Tessellation { grading: 1.0, ..*tessellation }, 1.0))?;
    // Exponents of 2. Where the grading itself is the largest change possible, its inverse undoes it: 2⁴.
    let (mut low, mut high) = (-5.0_f64, 5.0_f64);
    let mut best = (usize::MAX, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let factor = middle.exp2();
        let triangles = match count(&Sizing::new(tessellation, factor)) {
            Err(ShapeError { fault: Fault::TooManyTriangles(_), .. }) => usize::MAX,
            other => other?,
        };
        if triangles.abs_diff(target) < best.0 {
            best = (triangles.abs_diff(target), factor);
        }
        if triangles < target { low = middle } else { high = middle }
    }
    Ok(best.1)
}

/// Checks that a number of triangles is below the limit. Overflow of `usize` counts as above it.
pub(super) fn affordable(field: &str, factors: &[usize]) -> Result<(), ShapeError> {
    let product = factors.iter().try_fold(1_usize, |product, &factor| product.checked_mul(factor));
    match product {
        Some(triangles) if triangles <= MOST_TRIANGLES => Ok(()),
        _ => Err(Fault::TooManyTriangles(MOST_TRIANGLES).at(field)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_follow_the_sagitta() {
        let sizing = Sizing::new(&Tessellation::default(), 1.0);
        // 2π·√(25 / 0.16) = 2π · 12.5 = 78.5 -> 80
        assert_eq!(sizing.circle(25.0), 80);
        assert_eq!(sizing.arc(25.0, TAU / 4.0), 20);
        assert_eq!(sizing.straight(100.0), 3);
        assert_eq!(sizing.straight(1.0), 1);
    }

    /// The figure that the documents name for tools and stock, at density 3.
    #[test]
    fn circles_of_tools_leave_out_little() {
        let sizing = Sizing::new(&Tessellation { grading: 1.0, density: 3.0 }, 1.0);
        let left_out = |radius: f64| {
            let of_sides = |sides: usize| radius * (1.0 - (0.5 * TAU / sides as f64).cos());
            of_sides(sizing.circle(radius)).max(of_sides(4 * sizing.arc(radius, TAU / 4.0)))
        };
        let largest = (0..20_000).map(|i| left_out(0.01 * 1.000_605_f64.powi(i))).fold(0.0, f64::max);
        assert!((0.0026..0.0027).contains(&largest), "{largest}");
        assert!(left_out(2250.0) < 0.0027 && left_out(2400.0) > 0.0027);
    }

    #[test]
    fn grading_moves_segments_from_planes_to_details_and_spares_the_neutral_radius() {
        let even = Sizing::new(&Tessellation::default(), 1.0);
        let graded = Sizing::new(&Tessellation { grading: 4.0, density: 1.0 }, 1.0);
        assert_eq!(graded.circle(10.0), even.circle(10.0));
        assert!(graded.circle(2.0) > even.circle(2.0));
        assert!(graded.circle(80.0) < even.circle(80.0));
        assert_eq!(graded.flat_edge(), 2.0 * even.flat_edge());
    }

    #[test]
    fn absurd_numbers_are_refused() {
        for (grading, density) in [(f64::NAN, 1.0), (0.0, 1.0), (1.0, -1.0), (1.0, f64::INFINITY), (17.0, 1.0)] {
            assert!(Tessellation { grading, density }.check().is_err());
        }
        assert!(affordable("x", &[usize::MAX, 2]).is_err());
    }
}
