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
/// Cells across the part beyond the stock, unless so few find none of it.
const MOST_ACROSS: f64 = 128.0;

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
        let divides =
            |centre: &Point, half: f64| skin.distance_mm(centre, f64::INFINITY) + half * 3f64.sqrt() > resolution;
        self.visit(&divides, &mut |centre, half, material| {
            let side = |sign: f64, is_uncut: Option<bool>, deviation: &mut Deviation| {
                let is_here = |p: &Point| is_uncut.is_none_or(|inside| uncut.holds(p) == inside);
                let within = Within { skin: &skin, sign, beyond: resolution, cell };
                within.add(centre, half, None, &is_here, is_uncut.is_some(), deviation);
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
        let beyond = self.beyond_tiles(&skin);
        found.missing.greatest_mm = found.missing.greatest_mm.max(beyond.greatest_mm);
        found.missing.volume_mm3 += beyond.volume_mm3;
        Ok(found)
    }

    /// The part where no tile is, in cubes as fine as its size allows, or as it takes to find any of it: a part in the wrong unit has a large surface.
    fn beyond_tiles(&self, skin: &Skin) -> Deviation {
        let (tiles, tile, (low, high)) = (self.bounds(), self.tile_mm(), skin.bounds());
        let reach = (low - tiles.0).amax().max((high - tiles.0).amax());
        // About a corner of the tiles, so that no tile is in two cubes of its size.
        let half = tile * (reach / tile).log2().ceil().max(0.0).exp2();
        let mut cell = self.cell_mm().max(reach / MOST_ACROSS);
        loop {
            let (within, mut found) =
                (Within { skin, sign: -1.0, beyond: self.resolution_mm(), cell }, Deviation::default());
            within.add_beyond(&tiles.0, half, &tiles, tile, &mut found);
            if found.volume_mm3 > 0.0 || cell <= self.cell_mm() {
                return found;
            }
            cell = self.cell_mm().max(0.5 * cell);
        }
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
    /// Adds the points of a cube. `is_inside` says on which side of the part's surface it is, where that is known: asking takes most of the time.
    fn add(
        &self,
        centre: &Point,
        half: f64,
        is_inside: Option<bool>,
        is_here: &dyn Fn(&Point) -> bool,
        is_bordered: bool,
        deviation: &mut Deviation,
    ) {
        let radius = half * 3f64.sqrt();
        let away = self.skin.distance_mm(centre, f64::INFINITY);
        if away + radius <= self.beyond {
            return;
        }
        let is_inside = is_inside.unwrap_or_else(|| self.skin.holds(centre));
        let distance = if is_inside == (self.sign < 0.0) { away } else { -away };
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
        // A cube through which the surface does not run is on one side.
        let is_inside = (away > radius).then_some(is_inside);
        for index in 0..8 {
            let side = |k: u32| if index >> k & 1 == 0 { -0.5 * half } else { 0.5 * half };
            let centre = centre + Vector::new(side(0), side(1), side(2));
            self.add(&centre, 0.5 * half, is_inside, is_here, is_bordered, deviation);
        }
    }

    /// Adds the points of a cube of whole tiles that are in no tile between two corners.
    fn add_beyond(&self, centre: &Point, half: f64, tiles: &(Point, Point), tile: f64, deviation: &mut Deviation) {
        if self.sign * self.skin.signed_distance_mm(centre, f64::INFINITY) + half * 3f64.sqrt() <= self.beyond {
            return;
        }
        let slack = 0.25 * tile;
        let is_beyond = |k: usize| centre[k] + half < tiles.0[k] + slack || centre[k] - half > tiles.1[k] - slack;
        if (0..3).any(is_beyond) {
            self.add(centre, half, None, &|_| true, false, deviation);
        } else if half > 0.75 * tile {
            for index in 0..8 {
                let side = |k: u32| if index >> k & 1 == 0 { -0.5 * half } else { 0.5 * half };
                let centre = centre + Vector::new(side(0), side(1), side(2));
                self.add_beyond(&centre, 0.5 * half, tiles, tile, deviation);
            }
        }
    }

    /// The greatest distance in a cube that counts as a whole, and so is on one side of the surface.
    fn deepest(&self, centre: &Point, half: f64, distance: f64, deviation: &mut Deviation) {
        deviation.greatest_mm = deviation.greatest_mm.max(distance);
        let at_most = distance + half * 3f64.sqrt();
        if at_most <= deviation.greatest_mm + self.beyond.max(0.02 * at_most) {
            return;
        }
        for index in 0..8 {
            let side = |k: u32| if index >> k & 1 == 0 { -0.5 * half } else { 0.5 * half };
            let at = centre + Vector::new(side(0), side(1), side(2));
            let distance = self.skin.distance_mm(&at, f64::INFINITY);
            self.deepest(&at, 0.5 * half, distance, deviation);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block between two corners, mm.
    fn block(low: [f64; 3], high: [f64; 3]) -> Arc<Mesh> {
        let corner = |bits: usize| Point::from([0, 1, 2].map(|k| if bits >> k & 1 == 1 { high[k] } else { low[k] }));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Arc::new(Mesh::new((0..8).map(corner).collect(), faces).unwrap())
    }

    #[test]
    fn a_part_that_is_larger_than_the_uncut_workpiece_lacks_what_is_beyond_it() {
        let uncut = block([0.0; 3], [20.0, 20.0, 10.0]);
        for (low, high, volume_mm3, greatest_mm) in [
            ([0.0; 3], [20.0, 20.0, 10.0], 0.0, 0.0),
            // Within the resolution of 0.5 mm.
            ([-0.4; 3], [20.4, 20.4, 10.4], 0.0, 0.0),
            // Half a millimetre within the part's surface 19 x 19 x 9.5 mm are below the workpiece, beside it, and above it.
            ([0.0, 0.0, -10.0], [20.0, 20.0, 10.0], 19.0 * 19.0 * 9.5, 10.0),
            ([-10.0, 0.0, 0.0], [20.0, 20.0, 10.0], 9.5 * 19.0 * 9.0, 5.0),
            ([0.0; 3], [20.0, 20.0, 30.0], 19.0 * 19.0 * 19.5, 10.0),
        ] {
            let mut stock = Stock::new(&uncut, 0.5).unwrap();
            let Comparison { gouge, missing, .. } = stock.compare(&block(low, high)).unwrap();
            assert_eq!(gouge.volume_mm3, 0.0);
            let (least, most) = (0.7 * volume_mm3, 1.001 * volume_mm3);
            assert!((least..=most).contains(&missing.volume_mm3), "{low:?} {high:?} {missing:?}");
            assert!((0.8 * greatest_mm..=greatest_mm).contains(&missing.greatest_mm), "{low:?} {high:?} {missing:?}");
        }
        // In the wrong unit.
        let mut stock = Stock::new(&uncut, 0.1).unwrap();
        let missing = stock.compare(&block([0.0; 3], [508.0, 508.0, 254.0])).unwrap().missing;
        assert!(missing.greatest_mm > 100.0 && missing.volume_mm3 > 1e7, "{missing:?}");
    }
}
