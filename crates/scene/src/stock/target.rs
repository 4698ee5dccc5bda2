//! The remaining stock compared with the part that is wanted.
//!
//! Gouges are points of the part that are certainly cut away, rests are points outside it that are certainly left, both farther from the part's
//! surface than the resolution of the stock: nearer to it the two cannot be told apart. What may be such a point is bounded from above. A thin wall of the part has no point as
//! far from the part's surface, so that the distance from that surface to all that may be left is asked too.

use super::skin::Skin;
use super::tile::Tile;
use super::{Blank, Material, ROUNDING_MM, Stock, is_between};
use crate::geometry::{Mesh, Point, Triangle, Vector};
use rayon::prelude::*;
use std::sync::Arc;

/// Points on the wrong side of the part's surface, farther from it than the resolution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// The greatest distance from the part's surface that is certain, mm; 0 where there are no such points for sure.
    pub greatest_mm: f64,
    /// The greatest distance that is possible, mm; 0 where there cannot be such points.
    pub at_most_mm: f64,
    /// Volume of cells that hold only such points, mm³.
    pub volume_mm3: f64,
}

impl Deviation {
    fn join(&mut self, other: &Self) {
        self.greatest_mm = self.greatest_mm.max(other.greatest_mm);
        self.at_most_mm = self.at_most_mm.max(other.at_most_mm);
        self.volume_mm3 += other.volume_mm3;
    }
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
    /// How far the part's surface is from all that is left; without a volume. A thin wall that is gone shows here alone.
    pub surface: Deviation,
}

impl Comparison {
    fn join(&mut self, other: &Self) {
        self.gouge.join(&other.gouge);
        self.rest.join(&other.rest);
        self.missing.join(&other.missing);
        self.surface.join(&other.surface);
    }
}

/// Cells smaller than this are not divided to see which side of the uncut workpiece's surface they are on, mm.
const FINE_MM: f64 = 1.0;
/// Cells across the part beyond the stock, unless so few find none of it.
const MOST_ACROSS: f64 = 128.0;
/// Places of the part's surface are the resolution apart, or as far as makes so many squares of the surface.
const MOST_PLACES: f64 = 1e6;
/// Part of the resolution to which the part's surface may be away from what may be left. That reaches beyond what is left by the resolution at most, so that a
/// wall 1.5 times as high as the resolution is not gone.
const CLOSE: f64 = 0.5;
/// How often a finest cell is halved to bound how far from the surface its points are.
const HALVINGS: u32 = 2;
/// Latest balls without surface that are kept: which side of the surface a point in one of them is on is known.
const BALLS: usize = 16;

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
        // What is wholly near the part's surface deviates by no more than the resolution.
        let divides =
            |centre: &Point, half: f64| skin.distance_mm(centre, f64::INFINITY) + half * 3f64.sqrt() > resolution;
        let of_tile = |tile: &mut Tile| {
            let mut cells = Cells::new(&skin, Some(&uncut), resolution, cell);
            tile.visit(&uncut, &divides, &mut |centre, half, material| cells.add(centre, half, None, material));
            cells.found
        };
        let of_tiles: Vec<Comparison> = self.tiles.par_iter_mut().map(of_tile).collect();
        let mut found = self.beyond_tiles(&skin);
        of_tiles.iter().for_each(|of_tile| found.join(of_tile));
        found.surface = self.surface(&part.triangles(), skin.bounds());
        Ok(found)
    }

    /// The part where no tile is, in cubes as fine as its size allows, or as it takes to find any of it: a part in the wrong unit has a large surface.
    fn beyond_tiles(&self, skin: &Skin) -> Comparison {
        let (tiles, tile, (low, high)) = (self.bounds(), self.tile_mm(), skin.bounds());
        let reach = (low - tiles.0).amax().max((high - tiles.0).amax());
        // About a corner of the tiles, so that no tile is in two cubes of its size.
        let half = tile * (reach / tile).log2().ceil().max(0.0).exp2();
        let mut cell = self.cell_mm().max(reach / MOST_ACROSS);
        loop {
            let mut cells = Cells::new(skin, None, self.resolution_mm(), cell);
            cells.add_beyond(&tiles.0, half, &tiles, tile);
            if cells.found.missing.volume_mm3 > 0.0 || cell <= self.cell_mm() {
                return cells.found;
            }
            cell = self.cell_mm().max(0.5 * cell);
        }
    }

    /// How far the surface of a part between two corners is from all that is left.
    fn surface(&mut self, triangles: &[Triangle], (low, high): (Point, Point)) -> Deviation {
        let (uncut, most, close) = (Arc::clone(&self.uncut), (high - low).norm(), CLOSE * self.resolution_mm);
        let spacing = self.resolution_mm.max((triangles.iter().map(Triangle::area).sum::<f64>() / MOST_PLACES).sqrt());
        let far_of_tile = |tile: &mut Tile| {
            let (bounds, mut far) = (tile.bounds(), Vec::new());
            let skips = |piece: &Triangle| {
                let (low, high) = piece.bounds();
                (0..3).any(|k| high[k] < bounds.0[k] || low[k] > bounds.1[k])
            };
            let mut add = |place: &Point| {
                let mut least = most;
                if is_between(place, &bounds) {
                    tile.nearest_left(place, close, &mut least, &uncut);
                    far.extend((least > close).then_some(*place));
                }
            };
            triangles.iter().for_each(|triangle| places(triangle, spacing, &skips, &mut add));
            far
        };
        // Far from what may be left of their own tiles.
        let far: Vec<Point> = self.tiles.par_iter_mut().flat_map_iter(far_of_tile).collect();
        let (bounds, mut greatest, mut last) = (self.bounds(), close, (Point::origin(), f64::INFINITY));
        let mut add = |place: &Point| {
            // Not farther than the last place by more than the two are apart.
            if last.1 + (place - last.0).norm() > greatest {
                last = (*place, self.nearest_left_mm(place, greatest, most));
                greatest = greatest.max(last.1);
            }
        };
        far.iter().for_each(&mut add);
        let is_in_tiles = |piece: &Triangle| piece.corners.iter().all(|corner| is_between(corner, &bounds));
        let mut add_beyond = |place: &Point| {
            if !is_between(place, &bounds) {
                add(place);
            }
        };
        triangles.iter().for_each(|triangle| places(triangle, spacing, &is_in_tiles, &mut add_beyond));
        let resolution = self.resolution_mm;
        Deviation {
            greatest_mm: if greatest > resolution { greatest } else { 0.0 },
            // The places are less than the spacing from all of the surface.
            at_most_mm: if greatest > close { greatest + resolution + spacing } else { 0.0 },
            volume_mm3: 0.0,
        }
    }
}

/// Calls `add` with the centroid of each piece of a triangle, which is halved until no edge is longer than `spacing`. Pieces that `skips` names are left out.
fn places(triangle: &Triangle, spacing: f64, skips: &dyn Fn(&Triangle) -> bool, add: &mut dyn FnMut(&Point)) {
    if skips(triangle) {
        return;
    }
    let corner = |k: usize| triangle.corners[k % 3];
    let length = |k: usize| (corner(k + 1) - corner(k)).norm();
    let longest = (0..3).fold(0, |longest, k| if length(k) > length(longest) { k } else { longest });
    if length(longest) <= spacing {
        return add(&triangle.centroid());
    }
    let [from, to, opposite] = [0, 1, 2].map(|k| corner(longest + k));
    let middle = from + 0.5 * (to - from);
    for corners in [[from, middle, opposite], [middle, to, opposite]] {
        places(&Triangle { corners }, spacing, skips, add);
    }
}

/// The centre of one of the eight parts of a cube.
fn part_of(centre: &Point, half: f64, index: u32) -> Point {
    let side = |k: u32| if index >> k & 1 == 0 { -0.5 * half } else { 0.5 * half };
    centre + Vector::new(side(0), side(1), side(2))
}

/// Cells, held against a part.
struct Cells<'a> {
    skin: &'a Skin,
    /// The uncut workpiece; `None` beyond its tiles.
    uncut: Option<&'a Blank>,
    /// How far from the surface points must be, mm.
    beyond: f64,
    /// Side of the finest cells, mm.
    cell: f64,
    /// Balls without surface: centre, radius, and whether they are inside the part.
    balls: Vec<(Point, f64, bool)>,
    found: Comparison,
}

impl<'a> Cells<'a> {
    fn new(skin: &'a Skin, uncut: Option<&'a Blank>, beyond: f64, cell: f64) -> Self {
        Self { skin, uncut, beyond, cell, balls: Vec::new(), found: Comparison::default() }
    }

    /// Whether the part holds a point at a distance from its surface. To ask the mesh takes most of the time; a ball around another point often knows.
    fn is_inside(&mut self, point: &Point, away: f64) -> bool {
        let known = self.balls.iter().rev().find(|(centre, radius, _)| (point - centre).norm() < *radius);
        let is_inside = known.map_or_else(|| self.skin.holds(point), |ball| ball.2);
        if self.balls.len() == BALLS {
            self.balls.remove(0);
        }
        self.balls.push((*point, away - ROUNDING_MM, is_inside));
        is_inside
    }

    /// Adds the points of a cube of one material. `is_inside` says on which side of the part's surface it is, where that is known.
    fn add(&mut self, centre: &Point, half: f64, is_inside: Option<bool>, material: Material) {
        let radius = half * 3f64.sqrt();
        let away = self.skin.distance_mm(centre, f64::INFINITY);
        if away + radius <= self.beyond {
            return;
        }
        let is_inside = is_inside.unwrap_or_else(|| self.is_inside(centre, away));
        let deviates = match material {
            Material::Gone => is_inside,
            Material::Solid => !is_inside,
            Material::Unknown => true,
        };
        let distance = if deviates { away } else { -away };
        if distance + radius <= self.beyond {
            return;
        }
        // The surface of the uncut workpiece may run through a cube that is gone.
        let is_one = material != Material::Gone || self.uncut.is_none() || 2.0 * half <= FINE_MM.max(1.01 * self.cell);
        let is_whole = distance - radius >= self.beyond && is_one;
        if is_whole || 2.0 * half <= 1.01 * self.cell {
            return self.tell(centre, half, distance, material, is_inside);
        }
        // A cube through which the surface does not run is on one side.
        let is_inside = (away > radius).then_some(is_inside);
        (0..8).for_each(|index| self.add(&part_of(centre, half, index), 0.5 * half, is_inside, material));
    }

    /// Adds a cube that is not divided any more, at a distance from the part's surface, negative on the side where it does not deviate.
    fn tell(&mut self, centre: &Point, half: f64, distance: f64, material: Material, is_inside: bool) {
        let (skin, beyond) = (self.skin, self.beyond);
        let deviation = match material {
            Material::Gone if self.uncut.is_some_and(|uncut| uncut.holds(centre)) => &mut self.found.gouge,
            Material::Gone => &mut self.found.missing,
            Material::Unknown if is_inside => &mut self.found.gouge,
            _ => &mut self.found.rest,
        };
        let radius = half * 3f64.sqrt();
        if distance + radius > deviation.at_most_mm {
            let at_most = at_most(skin, beyond, (centre, half), distance, HALVINGS);
            deviation.at_most_mm = deviation.at_most_mm.max(if at_most > beyond { at_most } else { 0.0 });
        }
        if material == Material::Unknown || distance <= beyond {
            return;
        }
        deviation.greatest_mm = deviation.greatest_mm.max(distance);
        if distance - radius >= beyond {
            deviation.volume_mm3 += (2.0 * half).powi(3);
            deepest(skin, beyond, (centre, half), distance, deviation);
        }
    }

    /// Adds the points of a cube of whole tiles that are in no tile between two corners.
    fn add_beyond(&mut self, centre: &Point, half: f64, tiles: &(Point, Point), tile: f64) {
        if half * 3f64.sqrt() - self.skin.signed_distance_mm(centre, f64::INFINITY) <= self.beyond {
            return;
        }
        let slack = 0.25 * tile;
        let is_beyond = |k: usize| centre[k] + half < tiles.0[k] + slack || centre[k] - half > tiles.1[k] - slack;
        if (0..3).any(is_beyond) {
            self.add(centre, half, None, Material::Gone);
        } else if half > 0.75 * tile {
            (0..8).for_each(|index| self.add_beyond(&part_of(centre, half, index), 0.5 * half, tiles, tile));
        }
    }
}

/// How far the points of a cube are from a surface at most, mm, where that may be more than `beyond`; closer with each halving.
fn at_most(skin: &Skin, beyond: f64, (centre, half): (&Point, f64), distance: f64, halvings: u32) -> f64 {
    let bound = distance + half * 3f64.sqrt();
    if halvings == 0 || distance > beyond || bound <= beyond {
        return bound;
    }
    let of_part = |index: u32| {
        let place = part_of(centre, half, index);
        let away = skin.distance_mm(&place, f64::INFINITY);
        at_most(skin, beyond, (&place, 0.5 * half), away, halvings - 1)
    };
    (0..8).map(of_part).fold(0.0, f64::max)
}

/// The greatest distance in a cube that counts as a whole, and so is on one side of the surface.
fn deepest(skin: &Skin, beyond: f64, (centre, half): (&Point, f64), distance: f64, deviation: &mut Deviation) {
    deviation.greatest_mm = deviation.greatest_mm.max(distance);
    let at_most = distance + half * 3f64.sqrt();
    if at_most <= deviation.greatest_mm + beyond.max(0.02 * at_most) {
        return;
    }
    for index in 0..8 {
        let at = part_of(centre, half, index);
        let distance = skin.distance_mm(&at, f64::INFINITY);
        deepest(skin, beyond, (&at, 0.5 * half), distance, deviation);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Body, Step};
    use super::*;
    use crate::geometry::Isometry;
    use crate::geometry::shapes::{Shape, Tessellation};

    /// A block between two corners, mm.
    fn block(low: [f64; 3], high: [f64; 3]) -> Arc<Mesh> {
        let corner = |bits: usize| Point::from([0, 1, 2].map(|k| if bits >> k & 1 == 1 { high[k] } else { low[k] }));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Arc::new(Mesh::new((0..8).map(corner).collect(), faces).unwrap())
    }

    /// A block of 20 x 20 x 10 mm at a resolution of 0.5 mm, milled down to a height.
    fn milled(floor: f64) -> Stock {
        let cutter = toml::from_str::<Shape>("kind = \"cylinder\"\nradius_mm = 40\nheight_mm = 30").unwrap();
        let cutter = Body::turning(&Arc::new(cutter.mesh(&Tessellation::default()).unwrap()), 0.0);
        let [from, to] = [-60.0, 80.0].map(|x| Isometry::translation(x, 10.0, floor));
        let mut stock = Stock::new(&block([0.0; 3], [20.0, 20.0, 10.0]), 0.5).unwrap();
        stock.run(&[Step { examined: Vec::new(), cutting: vec![cutter.sweep([&from, &to], 0.0)] }], 0.01);
        stock
    }

    #[test]
    fn what_may_be_deeper_than_the_resolution_is_never_called_none() {
        for (at, deep) in
            [0.0, 0.07, 0.13, 0.21].into_iter().flat_map(|at| [0.0, 1.05, 1.2, 1.5, 2.0, 2.5].map(|k| (at, 0.5 * k)))
        {
            let floor = 5.0 + at;
            let of = |height: f64| milled(floor).compare(&block([0.0; 3], [20.0, 20.0, height])).unwrap();
            let (over, under) = (of(floor + deep), of(floor - deep));
            for found in [over.gouge, under.rest] {
                let Deviation { greatest_mm, at_most_mm, volume_mm3 } = found;
                assert!(greatest_mm <= deep + 1e-9 && volume_mm3 <= 400.0 * deep, "{floor} {deep}: {found:?}");
                assert_eq!(at_most_mm > 0.0, deep > 0.0, "{floor} {deep}: {found:?}");
                assert!(at_most_mm >= deep && at_most_mm <= deep + 0.5, "{floor} {deep}: {found:?}");
                assert!(greatest_mm > 0.0 || deep < 1.25, "{floor} {deep}: {found:?}");
            }
            assert_eq!((over.rest.at_most_mm, under.gouge.at_most_mm, under.surface), (0.0, 0.0, Deviation::default()));
            assert!(
                over.surface.greatest_mm <= deep + 1e-9 && (deep < 0.75 || over.surface.at_most_mm >= deep),
                "{over:?}"
            );
        }
    }

    #[test]
    fn a_thin_wall_that_is_gone_is_found_and_a_thin_fin_that_is_left_is_not_called_none() {
        for thick in [0.2, 0.5, 0.95] {
            let (low, high) = ([10.0, 0.0, 5.0], [10.0 + thick, 20.0, 10.0]);
            let Comparison { gouge, surface, .. } = milled(5.0).compare(&block(low, high)).unwrap();
            assert_eq!(gouge.greatest_mm, 0.0);
            assert!((4.0..=5.0).contains(&surface.greatest_mm) && surface.at_most_mm >= 5.0, "{thick}: {surface:?}");
            // A wall beyond the uncut workpiece, and one in it.
            let above = block([10.0, 0.0, 20.0], [10.0 + thick, 20.0, 25.0]);
            let surface = milled(5.0).compare(&above).unwrap().surface;
            assert!((19.0..=20.0).contains(&surface.greatest_mm), "{thick}: {surface:?}");
            let inside = block([10.0, 0.0, 1.0], [10.0 + thick, 20.0, 4.0]);
            assert_eq!(milled(5.0).compare(&inside).unwrap().surface, Deviation::default());
            let rest = Stock::new(&block(low, high), 0.5).unwrap().compare(&block([0.0; 3], [5.0; 3])).unwrap().rest;
            assert!(rest.at_most_mm > 5.0, "{thick}: {rest:?}");
        }
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
