//! The remaining stock compared with the part that is wanted.
//!
//! Gouges are points of the part that are certainly cut away, rests are points outside it that are certainly left, both farther from the part's
//! surface than the resolution of the stock: nearer to it the two cannot be told apart.

use super::skin::Skin;
use super::{Material, Stock};
use crate::geometry::{Mesh, Point, Vector};
use std::sync::Arc;

/// Points on the wrong side of the part's surface, farther from it than the resolution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// The greatest distance from the part's surface that is certain, mm; 0 where there are no such points.
    pub greatest_mm: f64,
    /// Volume of cells that hold only such points, mm³.
    pub volume_mm3: f64,
}

/// How what is left differs from the part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Comparison {
    /// The part where it was cut away.
    pub gouge: Deviation,
    /// Stock beyond the part.
    pub rest: Deviation,
    /// The part where the uncut workpiece never was.
    pub missing: Deviation,
}

/// Cells smaller than this are not divided to see which side of the uncut workpiece's surface they are on, mm.
const FINE_MM: f64 = 1.0;

impl Stock {
    /// Compares what is left with a part in the same frame.
    ///
    /// # Errors
    /// [`super::StockError::Open`] when the part's mesh is not watertight.
    pub fn compare(&mut self, part: &Arc<Mesh>) -> Result<Comparison, super::StockError> {
        if !part.edge_report().is_watertight() {
            return Err(super::StockError::Open);
        }
        let (skin, uncut) = (Skin::new(part), Arc::clone(&self.uncut));
        let (resolution, cell) = (self.resolution_mm(), self.cell_mm());
        let mut found = Comparison::default();
        // What is wholly near the part's surface deviates by no more than the resolution.
        let divides = |centre: &Point, half: f64| {
            skin.signed_distance_mm(centre, f64::INFINITY).abs() + half * 3f64.sqrt() > resolution
        };
        self.visit(&divides, &mut |centre, half, material| {
            let side = |sign: f64, is_uncut: Option<bool>, deviation: &mut Deviation| {
                let is_here = |p: &Point| is_uncut.is_none_or(|inside| uncut.holds(p) == inside);
                let within = Within { skin: &skin, sign, beyond: resolution, cell };
                within.add(centre, half, &is_here, is_uncut.is_some(), deviation);
            };
            match material {
                Material::Gone => {
                    side(-1.0, Some(true), &mut found.gouge);
                    side(-1.0, Some(false), &mut found.missing);
                }
                Material::Solid => side(1.0, None, &mut found.rest),
                Material::Unknown => {}
            }
        });
        Ok(found)
    }
}

/// What is on one side of a part's surface.
struct Within<'a> {
    skin: &'a Skin,
    /// 1 for outside the part, -1 for inside.
    sign: f64,
    /// How far from the surface points must be, mm.
    beyond: f64,
    /// Side of the finest cells, mm.
    cell: f64,
}

impl Within<'_> {
    /// Adds the points of a cube.
    fn add(
        &self,
        centre: &Point,
        half: f64,
        is_here: &dyn Fn(&Point) -> bool,
        is_bordered: bool,
        deviation: &mut Deviation,
    ) {
        let radius = half * 3f64.sqrt();
        let distance = self.sign * self.skin.signed_distance_mm(centre, f64::INFINITY);
        if distance + radius <= self.beyond {
            return;
        }
        let is_whole = distance - radius >= self.beyond && !(is_bordered && 2.0 * half > FINE_MM);
        if is_whole && !is_here(centre) {
            return;
        }
        if is_whole {
            deviation.volume_mm3 += (2.0 * half).powi(3);
            self.deepest(centre, half, distance, deviation);
            return;
        }
        if 2.0 * half <= 1.01 * self.cell {
            return;
        }
        for index in 0..8 {
            let side = |k: u32| if index >> k & 1 == 0 { -0.5 * half } else { 0.5 * half };
            self.add(&(centre + Vector::new(side(0), side(1), side(2))), 0.5 * half, is_here, is_bordered, deviation);
        }
    }

    /// The greatest distance in a cube that counts as a whole.
    fn deepest(&self, centre: &Point, half: f64, distance: f64, deviation: &mut Deviation) {
        deviation.greatest_mm = deviation.greatest_mm.max(distance);
        let at_most = distance + half * 3f64.sqrt();
        if at_most <= deviation.greatest_mm + self.beyond.max(0.02 * at_most) {
            return;
        }
        for index in 0..8 {
            let side = |k: u32| if index >> k & 1 == 0 { -0.5 * half } else { 0.5 * half };
            let at = centre + Vector::new(side(0), side(1), side(2));
            let distance = self.sign * self.skin.signed_distance_mm(&at, f64::INFINITY);
            self.deepest(&at, 0.5 * half, distance, deviation);
        }
    }
}
