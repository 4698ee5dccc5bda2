//! Stock that is cut: what is left of a workpiece while a program runs, between two bounds.
//!
//! J. H. Sullivan, L. Zhao and others, "Analytical and adaptive distance fields for machining simulation", 2012, and T. Van Hook, "Real-time shaded NC milling
//! display", 1986, model the remaining stock; the bounds are our addition. The outer bound holds all material that may be left, the inner one
//! only material that is left for sure. Both are cells of an octree in the workpiece's frame: gone, solid, or, of the finest cells alone, unknown. A cell
//! is removed when it is wholly inside what a cutter sweeps for sure, and stays solid while nothing may have touched it. So the outer bound is all
//! cells that are not gone, the inner one all that are solid.
//!
//! A cell that is not removed although a sweep's border runs through it reaches at most its diagonal into what the sweep took away. That is less
//! than the resolution: what slides along a surface that has just been cut may seem to be that deep in the stock, and no deeper.
//!
//! Of a workpiece that turns under tools that stand, the cells are squares of its half section, (ρ, z), in a quadtree ([`Stock::turned`]).
//!
//! Reading order: this file (the stock), `sweep` (what moves), `course` (how), [`motion`] (pieces of an axis move), `convex`, `round`, `bore`, `turned`, `skin` (shapes),
//! `blank` (the uncut workpiece), `cover` (what a cut leaves), `tile` (the tree of cells), `finished` (a workpiece that stays whole), [`export`] (as a mesh), [`target`] (compared with the part that is wanted).

mod blank;
mod convex;
mod bore;
mod round;
mod turned;
mod skin;
mod course;
mod sweep;
mod finished;
mod cover;
mod tile;
pub mod motion;
pub mod export;
pub mod target;
#[cfg(test)]
mod tests;

pub use finished::{Finished, Surface};
pub use sweep::{Body, ROUNDING_MM, Spindle, Sweep, TurningTool};
pub use tile::{Depth, Material};

use crate::geometry::{Isometry, Mesh, Point, Vector, triangle};
use crate::truth::Solid;
use blank::Blank;
use rayon::prelude::*;
use std::sync::Arc;
use thiserror::Error;
use tile::{LONG, Search, TOO_LONG, Tile};

/// Resolution where nobody says otherwise, mm, but not finer than [`RESOLUTION_PART`] of the workpiece's longest side.
pub const RESOLUTION_MM: f64 = 0.1;
/// Finest resolution where nobody says otherwise, as a part of the workpiece's longest side: 0.1 mm of a metre.
pub const RESOLUTION_PART: f64 = 1e-4;
/// Side of the finest cells as a part of the resolution. The diagonal is 0.78 of the resolution; the rest is for chords of arcs and turns, on both sides of a border.
const CELL: f64 = 0.45;
/// Most tiles along the longest side of a workpiece: tiles are what threads share out, and what a sweep is held against first.
const TILES: f64 = 8.0;
/// Most divisions of a tile.
const MOST_DIVISIONS: u32 = 20;

/// Why a workpiece cannot be cut.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum StockError {
    /// Nobody knows what is inside.
    #[error("its mesh is not watertight")]
    Open,
    /// It does not fill its body of revolution about the axis.
    #[error("it is not round about the axis that turns it")]
    NotRound,
    /// The resolution is no length, or much finer than the workpiece is large.
    #[error(
        "the resolution is {0} mm; it must be a finite number above 0, and at least a millionth of the workpiece's size"
    )]
    Resolution(f64),
}

/// What is left of a workpiece, in the frame of its mesh.
#[derive(Clone, Debug)]
pub struct Stock {
    uncut: Arc<Blank>,
    tiles: Vec<Tile>,
    resolution_mm: f64,
}

/// A move of parts against the stock along one straight piece.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// What must not come into the stock. A depth within the resolution is no contact.
    pub examined: Vec<Sweep>,
    /// What cuts meanwhile.
    pub cutting: Vec<Sweep>,
}

/// A part that comes, or may come, into the stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Index of the step.
    pub step: usize,
    /// Index among the parts that the step examines.
    pub part: usize,
    /// Parts of the way between which it may be deeper than the resolution, 0 to 1. Both are 0 where it never is.
    pub from: f64,
    /// The end of that.
    pub to: f64,
    /// How deep.
    pub depth: Depth,
}

impl Stock {
    /// The uncut stock.
    ///
    /// # Errors
    /// [`StockError`] when the mesh is open or the resolution is no length.
    pub fn new(mesh: &Arc<Mesh>, resolution_mm: f64) -> Result<Self, StockError> {
        if !mesh.edge_report().is_watertight() {
            return Err(StockError::Open);
        }
        let solid = Solid::new(Arc::clone(mesh));
        let triangles = mesh.triangles();
        let tiling = Tiling::new(triangle::bounds(&triangles).unwrap_or_default(), resolution_mm)?;
        let mut lists: Vec<Vec<u32>> = vec![Vec::new(); tiling.counts.iter().product()];
        for (number, triangle) in triangles.iter().enumerate() {
            for tile in tiling.meeting(triangle.bounds()) {
                lists[tile].push(number as u32);
            }
        }
        Ok(Self::of_tiles(Blank::Mesh { triangles, solid }, &tiling, &lists, resolution_mm))
    }

    /// The uncut stock of a workpiece that turns about z of the frame that `axis_from_stock` leads to, and under cutters that stand: its half section, (ρ, z), is all there is to know.
    ///
    /// # Errors
    /// [`StockError`] when the mesh is open, or not round about the axis, or the resolution is no length.
    pub fn turned(mesh: &Arc<Mesh>, axis_from_stock: Isometry, resolution_mm: f64) -> Result<Self, StockError> {
        if !mesh.edge_report().is_watertight() {
            return Err(StockError::Open);
        }
        let blank = Blank::turned(mesh, axis_from_stock)?;
        let places = mesh.vertices().iter().map(|vertex| blank.place(vertex));
        let (low, high) = places
            .fold((Point::new(0.0, 0.0, f64::INFINITY), Point::new(0.0, 0.0, f64::NEG_INFINITY)), |(l, h), p| {
                (Point::new(0.0, 0.0, l.z.min(p.z)), h.sup(&p))
            });
        let mut tiling = Tiling::new((low, high), resolution_mm)?;
        tiling.low.y = -0.5 * tiling.size;
        let lists = vec![vec![0]; tiling.counts.iter().product()];
        Ok(Self::of_tiles(blank, &tiling, &lists, resolution_mm))
    }

    fn of_tiles(blank: Blank, tiling: &Tiling, lists: &[Vec<u32>], resolution_mm: f64) -> Self {
        let tile = |(number, list): (usize, &Vec<u32>)| {
            Tile::new(tiling.place(number), tiling.size, tiling.divisions, list, &blank)
        };
        let tiles = lists.par_iter().enumerate().map(tile).collect();
        Self { uncut: Arc::new(blank), tiles, resolution_mm }
    }

    /// The resolution, mm.
    pub const fn resolution_mm(&self) -> f64 {
        self.resolution_mm
    }

    /// Side of the finest cells, mm.
    pub const fn cell_mm(&self) -> f64 {
        CELL * self.resolution_mm
    }

    /// Side of the tiles, mm: the coarsest cells.
    pub fn tile_mm(&self) -> f64 {
        self.tiles.first().map_or(0.0, Tile::size_mm)
    }

    /// The box of all tiles.
    fn bounds(&self) -> (Point, Point) {
        let wider = |(low, high): (Point, Point), (l, h): (Point, Point)| (low.inf(&l), high.sup(&h));
        self.tiles.iter().map(Tile::bounds).reduce(wider).unwrap_or_default()
    }

    /// Calls `visit` with every cell: its centre, half its side, and what is known of it. Cells through which the uncut surface runs are divided where
    /// `divides` says so.
    fn visit(&mut self, divides: &dyn Fn(&Point, f64) -> bool, visit: &mut dyn FnMut(&Point, f64, Material)) {
        for tile in &mut self.tiles {
            tile.visit(&self.uncut, divides, visit);
        }
    }

    /// Whether something that moves comes near what may be left.
    pub fn is_near(&self, sweep: &Sweep) -> bool {
        let meets = |tile: &Tile| {
            let (low, high) = tile.bounds();
            !tile.is_gone() && sweep.reaches(&low, &high)
        };
        self.tiles.iter().any(meets)
    }

    /// Cells that were held against something that moves so far: what time is spent on, the same on every machine.
    pub fn questions(&self) -> u64 {
        self.tiles.iter().map(Tile::questions).sum()
    }

    /// Bytes of the cells.
    pub fn bytes(&self) -> usize {
        self.tiles.iter().map(Tile::bytes).sum()
    }

    /// Runs steps in their order. What is examined is held against the stock as it is at that moment: while something cuts, the way is halved until the two
    /// can be told apart, down to `tolerance_mm`. The contacts come in the order of the steps.
    pub fn run(&mut self, steps: &[Step], tolerance_mm: f64) -> Vec<Contact> {
        let (uncut, resolution_mm) = (Arc::clone(&self.uncut), self.resolution_mm);
        let found = self.tiles.par_iter_mut().map(|tile| {
            let mut run = TileRun { tile, uncut: &uncut, resolution_mm, tolerance_mm, found: Vec::new() };
            for (index, step) in steps.iter().enumerate() {
                run.step(index, step);
            }
            run.found
        });
        let mut found: Vec<Contact> = found.flatten().collect();
        found.sort_by_key(|contact| (contact.step, contact.part));
        let mut joined: Vec<Contact> = Vec::with_capacity(found.len());
        for contact in found {
            match joined.last_mut() {
                Some(last) if (last.step, last.part) == (contact.step, contact.part) => last.join(&contact),
                _ => joined.push(contact),
            }
        }
        joined
    }

    /// Distance from a point to the nearest material that may be left, mm, or `most_mm` where that is less; where it is within `within_mm`, anything up to that.
    fn nearest_left_mm(&mut self, point: &Point, within_mm: f64, most_mm: f64) -> f64 {
        let mut tiles: Vec<(f64, &mut Tile)> =
            self.tiles.iter_mut().map(|tile| (tile.gap_mm(point), tile)).filter(|(gap, _)| *gap < most_mm).collect();
        tiles.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut least = most_mm;
        tiles.into_iter().for_each(|(_, tile)| tile.nearest_left(point, within_mm, &mut least, &self.uncut));
        least
    }

    /// What is known at a point.
    pub fn material_at(&mut self, point: &Point) -> Material {
        let (uncut, point) = (&self.uncut, &self.uncut.place(point));
        let holds = |tile: &&mut Tile| is_between(point, &tile.bounds());
        self.tiles.iter_mut().find(holds).map_or(Material::Gone, |tile| tile.material_at(point, uncut))
    }
}

/// Whether a place is in a box, whose upper sides do not belong to it.
fn is_between(place: &Point, (low, high): &(Point, Point)) -> bool {
    (0..3).all(|k| low[k] <= place[k] && place[k] < high[k])
}

/// The tiles of a stock.
struct Tiling {
    low: Point,
    size: f64,
    counts: [usize; 3],
    /// How often a tile is divided to its finest cells.
    divisions: u32,
}

impl Tiling {
    fn new((low, high): (Point, Point), resolution_mm: f64) -> Result<Self, StockError> {
        let cell = CELL * resolution_mm;
        let divisions = ((high - low).amax() / TILES / cell).log2().ceil().max(0.0);
        if !(cell > 0.0 && cell.is_finite() && divisions <= f64::from(MOST_DIVISIONS)) {
            return Err(StockError::Resolution(resolution_mm));
        }
        let divisions = divisions as u32;
        let size = cell * f64::from(1_u32 << divisions);
        // Off the planes of the workpiece's faces, which would else be in the cells of both sides.
        let low = low - Vector::repeat(OFF_GRID * cell);
        let counts = std::array::from_fn(|k| (((high[k] - low[k]) / size).floor() as usize) + 1);
        Ok(Self { low, size, counts, divisions })
    }

    /// Numbers of the tiles that a box may meet.
    fn meeting(&self, (low, high): (Point, Point)) -> impl Iterator<Item = usize> {
        let Self { counts, .. } = *self;
        let [xs, ys, zs]: [_; 3] = std::array::from_fn(|k| {
            let place = |x: f64| (((x - self.low[k]) / self.size).floor().max(0.0) as usize).min(counts[k] - 1);
            // A border belongs to both sides.
            place(low[k] - ROUNDING_MM)..=place(high[k] + ROUNDING_MM)
        });
        zs.flat_map(move |z| ys.clone().map(move |y| [y, z]))
            .flat_map(move |[y, z]| xs.clone().map(move |x| x + counts[0] * (y + counts[1] * z)))
    }

    /// The lowest corner of a tile.
    fn place(&self, number: usize) -> Point {
        let counts = self.counts;
        let at = [number % counts[0], number / counts[0] % counts[1], number / counts[0] / counts[1]];
        self.low + Vector::from(at.map(|n| n as f64)) * self.size
    }
}

/// The resolution where nobody says otherwise, mm: [`RESOLUTION_MM`], or [`RESOLUTION_PART`] of a workpiece's longest side where that is more.
pub fn standard_resolution_mm(mesh: &Mesh) -> f64 {
    let (low, high) = triangle::bounds(&mesh.triangles()).unwrap_or_default();
    RESOLUTION_MM.max(RESOLUTION_PART * (high - low).amax())
}

/// Depth below which nothing is told, mm: what rounding and the chords of a mesh make of a surface that was just cut.
const TOUCH_MM: f64 = 1e-4;
/// Part of a way that is not halved any more, however small the tolerance.
const FINEST: f64 = 1e-9;
/// Part of a cell by which the grid is off the workpiece's box.
const OFF_GRID: f64 = 0.31;

impl Contact {
    /// Takes in what another tile found of the same part in the same step.
    fn join(&mut self, other: &Self) {
        let is_deep = |contact: &Self| contact.to > 0.0;
        (self.from, self.to) = match (is_deep(self), is_deep(other)) {
            (true, true) => (self.from.min(other.from), self.to.max(other.to)),
            (false, true) => (other.from, other.to),
            _ => (self.from, self.to),
        };
        self.depth = self.depth.max(other.depth);
    }
}

/// Steps through one tile.
struct TileRun<'a> {
    tile: &'a mut Tile,
    uncut: &'a Blank,
    resolution_mm: f64,
    tolerance_mm: f64,
    found: Vec<Contact>,
}

impl TileRun<'_> {
    fn step(&mut self, index: usize, step: &Step) {
        let (low, high) = self.tile.bounds();
        let reaches = |sweep: &&Sweep| sweep.reaches(&low, &high);
        if self.tile.is_gone() || !step.examined.iter().chain(&step.cutting).any(|sweep| reaches(&sweep)) {
            return;
        }
        let cutting: Vec<&Sweep> = step.cutting.iter().filter(reaches).collect();
        let examined = step.examined.iter().enumerate().filter(|(_, sweep)| reaches(sweep));
        // A body that is where it has cut before meets nothing there. While something cuts, its way stays whole: both go it at the same time.
        let examined: Vec<(usize, Sweep, [f64; 2])> = examined
            .filter_map(|(part, sweep)| {
                let rest = self.tile.untraced(sweep, TOUCH_MM.min(self.resolution_mm))?;
                let rest = if cutting.is_empty() { rest } else { [0.0, 1.0] };
                Some((part, if rest == [0.0, 1.0] { sweep.clone() } else { sweep.part(rest[0], rest[1]) }, rest))
            })
            .collect();
        let mut open: Vec<Meeting<'_>> = Vec::new();
        for (part, sweep, rest) in &examined {
            let (part, rest) = (*part, *rest);
            let high = self.at_most(sweep);
            if high > self.resolution_mm {
                open.push(Meeting { part, sweep, rest, depth: Depth::default(), from: None });
            } else if high > TOUCH_MM {
                let depth = Depth { low: 0.0, high };
                self.found.push(Contact { step: index, part, from: 0.0, to: 0.0, depth });
            }
        }
        if cutting.is_empty() {
            for Meeting { part, sweep, rest, .. } in open {
                let [from, to] = self.ends(sweep).map(|at| rest[0] + at * (rest[1] - rest[0]));
                let depth = self.depth(sweep);
                self.found.push(Contact { step: index, part, from, to, depth });
            }
            return;
        }
        if open.is_empty() {
            self.cut(&cutting, 0.0, 1.0);
            return;
        }
        self.advance(&mut open, &cutting, 0.0, 1.0);
        for Meeting { part, sweep, depth, from, .. } in open {
            let Some(from) = from else {
                // Only touched what was taken away before.
                if depth.high > 0.0 {
                    self.found.push(Contact { step: index, part, from: 0.0, to: 0.0, depth });
                }
                continue;
            };
            // What is left behind the cut was there before it.
            let left = self.depth(&sweep.part(from, 1.0));
            let depth = Depth { low: depth.low.max(left.low), high: depth.high.max(left.high) };
            self.found.push(Contact { step: index, part, from, to: 1.0, depth });
        }
    }

    /// Examines and cuts a part of the way. What may be in contact before the cut is asked again on halves, until it is not or too little of the way is left.
    fn advance(&mut self, open: &mut [Meeting<'_>], cutting: &[&Sweep], from: f64, to: f64) {
        let mut is_open = false;
        let mut longest: f64 = 0.0;
        let tolerance_mm = self.tolerance_mm;
        let is_short = |way_mm: f64| (to - from) * way_mm <= tolerance_mm || to - from <= FINEST;
        for meeting in open.iter_mut().filter(|meeting| meeting.from.is_none()) {
            let high = self.at_most(&meeting.sweep.part(from, to));
            if high <= self.resolution_mm {
                meeting.depth.high = meeting.depth.high.max(high);
                continue;
            }
            is_open = true;
            longest = longest.max(meeting.sweep.way_mm);
            if is_short(meeting.sweep.way_mm) {
                meeting.from = Some(from.max(f64::MIN_POSITIVE));
                // The rest of the way against the stock as it is now is an upper bound.
                meeting.depth.high = self.depth(&meeting.sweep.part(from, 1.0)).high;
            }
        }
        if !is_open || is_short(longest) {
            self.cut(cutting, from, to);
            for meeting in open.iter_mut().filter(|meeting| meeting.from == Some(from.max(f64::MIN_POSITIVE))) {
                let left = self.depth(&meeting.sweep.part(from, to));
                meeting.depth.low = meeting.depth.low.max(left.low);
            }
            return;
        }
        let middle = f64::midpoint(from, to);
        self.advance(open, cutting, from, middle);
        self.advance(open, cutting, middle, to);
    }

    fn cut(&mut self, cutting: &[&Sweep], from: f64, to: f64) {
        for sweep in cutting {
            if from == 0.0 && to == 1.0 {
                self.tile.cut(sweep, self.uncut);
            } else {
                self.tile.cut(&sweep.part(from, to), self.uncut);
            }
        }
    }

    fn depth(&mut self, sweep: &Sweep) -> Depth {
        let found = self.depth_in(sweep);
        let Some(drawn) = &sweep.drawn else { return found };
        if found.high <= self.resolution_mm {
            return Depth { low: 0.0, ..found };
        }
        let drawn = self.depth_in(drawn);
        let low = if drawn.high > self.resolution_mm { drawn.low.min(found.high) } else { 0.0 };
        Depth { low, ..found }
    }

    fn depth_in(&mut self, sweep: &Sweep) -> Depth {
        self.search(sweep, false, TOO_LONG)
    }

    /// How deep a part comes at most, mm, where that is within the resolution, and 0 where it does not touch; where it may be deeper, some depth beyond it.
    fn at_most(&mut self, sweep: &Sweep) -> f64 {
        let high = self.search(sweep, true, u64::MAX).high;
        let may_touch = high > self.resolution_mm || high > TOUCH_MM && self.touches(sweep);
        if may_touch { high } else { 0.0 }
    }

    /// Whether a part may touch. A large cell within the resolution of a part is not divided for its depth, however far its material is from the part; it is divided for
    /// this. What [`LONG`] questions do not decide counts as touching.
    fn touches(&mut self, sweep: &Sweep) -> bool {
        let Self { uncut, .. } = *self;
        let search = Search { sweep, within_mm: TOUCH_MM, only_whether: true, keeps_cuts: true, most: LONG, uncut };
        self.tile.contact(&search).high > TOUCH_MM
    }

    fn search(&mut self, sweep: &Sweep, only_whether: bool, most: u64) -> Depth {
        let Self { uncut, resolution_mm: within_mm, .. } = *self;
        self.tile.contact(&Search { sweep, within_mm, only_whether, keeps_cuts: false, most, uncut })
    }

    /// Where on its way a part first and last may be deeper than the resolution, found by halving to the tolerance. A stretch that [`LONG`] questions do not decide
    /// counts as deep.
    fn ends(&mut self, sweep: &Sweep) -> [f64; 2] {
        let (resolution_mm, tolerance_mm) = (self.resolution_mm, self.tolerance_mm);
        let mut is_deep = |from: f64, to: f64| self.search(&sweep.part(from, to), true, LONG).high > resolution_mm;
        let step = if sweep.way_mm > 0.0 { (tolerance_mm / sweep.way_mm).max(FINEST) } else { 1.0 };
        let (mut from, mut to) = (0.0, 1.0);
        // It is deep somewhere before `to`, and nowhere before `from`.
        while to - from > step {
            let middle = f64::midpoint(from, to);
            if is_deep(from, middle) { to = middle } else { from = middle }
        }
        let first = from;
        let (mut from, mut to) = (first, 1.0);
        while to - from > step {
            let middle = f64::midpoint(from, to);
            if is_deep(middle, to) { from = middle } else { to = middle }
        }
        [first, to]
    }
}

/// A part that may come into the stock while something cuts.
struct Meeting<'a> {
    part: usize,
    sweep: &'a Sweep,
    /// The part of the step's way that it is.
    rest: [f64; 2],
    depth: Depth,
    /// Where on the way contact begins, once that is known.
    from: Option<f64>,
}
