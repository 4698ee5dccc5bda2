//! A cube of the stock as an octree: gone, solid, or mixed down to the finest cells. Of a workpiece that turns it is a square of (ρ, z), as a quadtree.
//!
//! A cell through which borders run, of sweeps or of the uncut workpiece, keeps the list of them. It divides only when something asks about it: then each child
//! keeps those that run through it, is gone where a sweep holds it, and solid where none is left. So a cut costs what the coarse cells along its border cost, and
//! a question what the fine cells near the question cost. A cell never changes from gone to anything.

use super::blank::Blank;
use super::convex::Least;
use super::sweep::Sweep;
use crate::geometry::{Point, Vector};

/// State of a cell, its children, or its triangles: see the constants.
type Cell = u32;

/// Outside the uncut workpiece.
const OUTSIDE: Cell = 0;
/// Removed, or outside the uncut workpiece.
const CUT: Cell = 1;
/// Material that nothing has touched.
const SOLID: Cell = 2;
/// Of the finest cells: material may be in it, and may not fill it.
const MIXED: Cell = 3;
/// Cells from here on: where their eight children begin.
const FIRST_CHILD: Cell = 8;
/// Of cells through which borders run, and which are not divided yet: the number of their lists.
const UNDIVIDED: Cell = 1 << 31;
/// Side of cells that a cut divides down to, mm; smaller ones wait for a question. Lists at this size are short, and so is the way to the finest cells.
const WAITING_MM: f64 = 1.5;

/// How deep material comes into a part, mm: at least, and at most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Depth {
    /// At least; 0 where contact is not certain.
    pub low: f64,
    /// At most; 0 where there is none.
    pub high: f64,
}

impl Depth {
    /// Bounds of the larger of two.
    pub fn max(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.max(other.high) }
    }
}

/// What is asked about the contact of the stock with what moves.
pub(super) struct Search<'a> {
    pub sweep: &'a Sweep,
    /// Depths up to this are not told apart, mm.
    pub within_mm: f64,
    /// Whether it is enough to know that the depth may be more than that.
    pub only_whether: bool,
    /// Whether cells stay undivided where what cuts leave of them bounds the depth: finer ones bound it less closely.
    pub keeps_cuts: bool,
    /// After this many questions, what is undecided counts as contact. For a mesh that does not turn the limit is [`TOO_LONG`] at most, or [`SHORT`] after [`PATIENCE`].
    pub most: u64,
    pub uncut: &'a Blank,
}

impl Search<'_> {
    fn is_answered(&self, depth: &Depth) -> bool {
        self.only_whether && depth.high.max(depth.low) > self.within_mm
    }
}

/// Latest cuts that are looked through for one that is retraced.
const MOST_TRACED: usize = 512;
/// Part of a depth to which its bounds need not be nearer to one another.
const CLOSE_PART: f64 = 0.05;
/// Questions after which a depth that is certain is bounded no more closely: faces that are as deep everywhere have no deepest cell.
pub(super) const LONG: u64 = 4_000;
/// Greatest over least depth that is close enough in the first round. Past [`LONG`] questions it grows in proportion to the questions.
const APART: f64 = 2.0;
/// Questions after which what is undecided counts as contact, when a depth is asked, or when the part is a mesh that does not turn: each question searches the mesh.
pub(super) const TOO_LONG: u64 = 100_000;
/// Questions about meshes that do not turn, of one tile, after which [`SHORT`] replaces [`TOO_LONG`] for them.
const PATIENCE: u64 = 200_000;
const SHORT: u64 = 2_000;

/// What is known of the material at a point or in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Material {
    /// None: it was removed, or never was there.
    Gone,
    /// All of it is there.
    Solid,
    /// Not decided at the resolution.
    Unknown,
}

#[derive(Clone, Debug)]
pub(super) struct Tile {
    low: Point,
    size: f64,
    /// Divisions down to the finest cells.
    depth: u32,
    is_flat: bool,
    root: Cell,
    cells: Vec<Cell>,
    /// Blocks of eight cells that are free again.
    free: Vec<u32>,
    lists: Vec<Borders>,
    /// Lists that are free again.
    free_lists: Vec<u32>,
    /// What has cut here.
    sweeps: Vec<Sweep>,
    /// Cells that were held against something, and distances from meshes that this took.
    questions: u64,
    /// What that was when the present question of depth began.
    begun: u64,
    /// Greatest over least depth that is close enough in this round; 1 in the last round, which goes by [`CLOSE_PART`].
    apart: f64,
    /// Questions that depths in meshes that do not turn took.
    of_meshes: u64,
}

/// What runs through a cell.
#[derive(Clone, Debug, Default)]
struct Borders {
    /// Triangles of the uncut workpiece.
    triangles: Vec<u32>,
    /// Sweeps that do not hold the cell, and may reach into it.
    sweeps: Vec<u32>,
}

/// A cell's place.
#[derive(Clone, Copy)]
pub(super) struct Cube {
    pub centre: Point,
    pub half: f64,
    /// Divisions left.
    left: u32,
    /// A square of (ρ, 0, z).
    is_flat: bool,
}

impl Cube {
    pub fn radius(&self) -> f64 {
        self.half * 3f64.sqrt()
    }

    /// Distance from a point, mm; 0 inside.
    fn gap_mm(&self, point: &Point) -> f64 {
        (point - self.centre).map(|along| (along.abs() - self.half).max(0.0)).norm()
    }

    /// How many parts it is divided into.
    const fn fan(&self) -> u32 {
        if self.is_flat { 4 } else { 8 }
    }

    fn child(&self, index: u32) -> Self {
        let half = 0.5 * self.half;
        let side = |k: u32| if index >> k & 1 == 0 { -half } else { half };
        let beside =
            if self.is_flat { Vector::new(side(0), 0.0, side(1)) } else { Vector::new(side(0), side(1), side(2)) };
        Self { centre: self.centre + beside, half, left: self.left.saturating_sub(1), is_flat: self.is_flat }
    }

    /// The part that holds a point.
    fn part_of(&self, point: &Point) -> u32 {
        let axes: &[usize] = if self.is_flat { &[0, 2] } else { &[0, 1, 2] };
        axes.iter().enumerate().map(|(k, &axis)| u32::from(point[axis] >= self.centre[axis]) << k).sum()
    }
}

impl Tile {
    /// The cube from `low` of a size, divided `depth` times at most; `triangles` are those of the workpiece that may meet it. Of a workpiece that turns it is the square
    /// in the middle of that.
    pub fn new(low: Point, size: f64, depth: u32, triangles: &[u32], uncut: &Blank) -> Self {
        let mut tile = Self {
            low,
            size,
            depth,
            is_flat: uncut.is_turned(),
            root: OUTSIDE,
            cells: vec![OUTSIDE; FIRST_CHILD as usize],
            free: Vec::new(),
            lists: Vec::new(),
            free_lists: Vec::new(),
            sweeps: Vec::new(),
            questions: 0,
            begun: 0,
            apart: 1.0,
            of_meshes: 0,
        };
        let cube = tile.cube();
        tile.root = if triangles.is_empty() {
            if uncut.holds(&cube.centre) { SOLID } else { OUTSIDE }
        } else {
            tile.cell_of(&cube, &Borders { triangles: triangles.to_vec(), sweeps: Vec::new() }, uncut)
        };
        tile
    }

    fn cube(&self) -> Cube {
        let half = 0.5 * self.size;
        Cube { centre: self.low + Vector::repeat(half), half, left: self.depth, is_flat: self.is_flat }
    }

    /// Corners of the cube, mm.
    pub fn bounds(&self) -> (Point, Point) {
        (self.low, self.low + Vector::repeat(self.size))
    }

    /// Distance of a point from the cube, mm; 0 inside.
    pub fn gap_mm(&self, point: &Point) -> f64 {
        self.cube().gap_mm(point)
    }

    pub const fn size_mm(&self) -> f64 {
        self.size
    }

    /// Bytes of the tree and of what it keeps.
    pub fn bytes(&self) -> usize {
        let of_list = |list: &Borders| 4 * (list.triangles.capacity() + list.sweeps.capacity()) + size_of::<Borders>();
        let of_lists = self.lists.iter().map(of_list).sum::<usize>();
        4 * self.cells.capacity() + of_lists + self.sweeps.capacity() * size_of::<Sweep>()
    }

    /// Cells that were held against something that moves: what time is spent on.
    pub const fn questions(&self) -> u64 {
        self.questions
    }

    /// Whether it is all gone, which needs no further questions.
    pub fn is_gone(&self) -> bool {
        matches!(self.root, OUTSIDE | CUT)
    }

    /// The state of a cell, given what runs through a larger one that holds it.
    fn cell_of(&mut self, cube: &Cube, borders: &Borders, uncut: &Blank) -> Cell {
        let mut sweeps = Vec::new();
        self.questions += borders.sweeps.len() as u64;
        for &index in &borders.sweeps {
            let found = self.sweeps[index as usize].side(&cube.centre, cube.half);
            if found.high <= -cube.radius() {
                return CUT;
            }
            if found.deep < 0.0 {
                sweeps.push(index);
            }
        }
        let triangles = uncut.meeting(&borders.triangles, cube);
        if triangles.is_empty() {
            // Without triangles in the larger cell it is as that is, which has material: sweeps are kept of no other.
            if !borders.triangles.is_empty() && !uncut.holds(&cube.centre) {
                return OUTSIDE;
            }
            if sweeps.is_empty() {
                return SOLID;
            }
        }
        if cube.left == 0 { MIXED } else { self.listed(Borders { triangles, sweeps }) }
    }

    /// An undivided cell with borders.
    fn listed(&mut self, borders: Borders) -> Cell {
        let number = self.free_lists.pop().unwrap_or_else(|| {
            self.lists.push(Borders::default());
            (self.lists.len() - 1) as u32
        });
        self.lists[number as usize] = borders;
        UNDIVIDED | number
    }

    /// Takes the borders of an undivided cell away.
    fn unlisted(&mut self, cell: Cell) -> Borders {
        let number = cell & !UNDIVIDED;
        self.free_lists.push(number);
        std::mem::take(&mut self.lists[number as usize])
    }

    /// Eight equal cells.
    fn divided(&mut self, cell: Cell) -> Cell {
        let first = self.free.pop().unwrap_or_else(|| {
            self.cells.resize(self.cells.len() + 8, cell);
            (self.cells.len() - 8) as u32
        });
        self.cells[first as usize..first as usize + 8].fill(cell);
        first
    }

    /// Divides a cell through which borders run.
    fn divide(&mut self, cell: Cell, cube: &Cube, uncut: &Blank) -> Cell {
        let borders = self.unlisted(cell);
        let first = self.divided(OUTSIDE);
        for index in 0..cube.fan() {
            self.cells[(first + index) as usize] = self.cell_of(&cube.child(index), &borders, uncut);
        }
        first
    }

    /// Takes away what the sweep removes. Cells wholly within it are removed, cells that it does not touch stay as they are.
    pub fn cut(&mut self, sweep: &Sweep, uncut: &Blank) {
        let number = self.sweeps.len() as u32;
        self.sweeps.push(sweep.clone());
        self.root = self.cut_cell(self.root, &self.cube(), number, uncut);
    }

    fn cut_cell(&mut self, cell: Cell, cube: &Cube, number: u32, uncut: &Blank) -> Cell {
        if matches!(cell, OUTSIDE | CUT) {
            return cell;
        }
        self.questions += 1;
        let found = self.sweeps[number as usize].side(&cube.centre, cube.half);
        if found.deep >= 0.0 {
            return cell;
        }
        if found.high <= -cube.radius() {
            self.forget(cell);
            return CUT;
        }
        let waits = 2.0 * cube.half <= WAITING_MM;
        let first = match cell {
            MIXED => return MIXED,
            SOLID if cube.left == 0 => return MIXED,
            SOLID if waits => return self.listed(Borders { triangles: Vec::new(), sweeps: vec![number] }),
            SOLID => self.divided(SOLID),
            cell if cell & UNDIVIDED != 0 && waits => {
                self.lists[(cell & !UNDIVIDED) as usize].sweeps.push(number);
                return cell;
            }
            cell if cell & UNDIVIDED != 0 => self.divide(cell, cube, uncut),
            first => first,
        };
        for index in 0..cube.fan() {
            let at = (first + index) as usize;
            self.cells[at] = self.cut_cell(self.cells[at], &cube.child(index), number, uncut);
        }
        self.joined(first, cube)
    }

    /// The cell whose children begin at `first`, undivided again where they are all alike.
    fn joined(&mut self, first: u32, cube: &Cube) -> Cell {
        let children = &self.cells[first as usize..(first + cube.fan()) as usize];
        let is_gone = children.iter().all(|&cell| matches!(cell, OUTSIDE | CUT));
        let alike = children.iter().all(|&cell| cell == children[0]) && matches!(children[0], OUTSIDE | CUT | SOLID);
        let whole = if alike { children[0] } else { CUT };
        if is_gone || alike {
            self.free.push(first);
            return whole;
        }
        first
    }

    /// Gives the cells below a cell free.
    fn forget(&mut self, cell: Cell) {
        if cell & UNDIVIDED != 0 {
            self.unlisted(cell);
        } else if cell >= FIRST_CHILD {
            for index in 0..8 {
                self.forget(self.cells[(cell + index) as usize]);
            }
            self.free.push(cell);
        }
    }

    /// The part of a way on which the body is not where it has cut before, 0 to 1. Where it has, what is left is not deeper than `within_mm`.
    ///
    /// What the body swept for sure is gone, whether or not the cells show it: a retreat from a cut, and the way back into it, need no fine cells.
    pub fn untraced(&self, sweep: &Sweep, within_mm: f64) -> Option<[f64; 2]> {
        let mut rest = [0.0, 1.0];
        for cut in self.sweeps.iter().rev().take(MOST_TRACED) {
            let Some([from, to]) = sweep.retraced(cut).filter(|_| sweep.retraced_mm(cut) <= within_mm) else {
                continue;
            };
            if from <= rest[0] && to > rest[0] {
                rest[0] = to;
            }
            if to >= rest[1] && from < rest[1] {
                rest[1] = from;
            }
            if rest[0] >= rest[1] {
                return None;
            }
        }
        Some(rest)
    }

    /// How deep the material comes into what moves. Depths up to `search.within_mm` are bounded from above alone.
    pub fn contact(&mut self, search: &Search<'_>) -> Depth {
        let (mut depth, cube) = (Depth::default(), self.cube());
        self.begun = self.questions;
        let is_of_mesh = search.sweep.is_of_mesh();
        let most = match is_of_mesh {
            true if self.of_meshes > PATIENCE => SHORT,
            true => search.most.min(TOO_LONG),
            false => search.most,
        };
        if !self.is_gone() {
            let found = search.sweep.depth(&cube.centre, cube.half, &mut self.questions);
            // Of a part that may be anywhere in its body no depth is certain: whether it may be in contact is all that can be known.
            let is_vague = search.sweep.is_vague();
            let search = Search { only_whether: search.only_whether || is_vague, most, ..*search };
            depth = self.bounded(&cube, found, &search);
            if is_vague && depth.high > search.within_mm {
                depth.high = -found.deep;
            }
            // Where pieces of a body overlap, what is known of all of it may be deeper than any one of them says.
            depth.high = depth.high.max(depth.low);
        }
        if is_of_mesh {
            self.of_meshes += self.questions - self.begun;
        }
        depth
    }

    /// Bounds of the depth, closer in each round, until they are close or [`LONG`] questions were asked.
    fn bounded(&mut self, cube: &Cube, found: Least, search: &Search<'_>) -> Depth {
        let mut depth = Depth { low: 0.0, high: f64::INFINITY };
        self.apart = APART;
        loop {
            let mut closer = Depth { high: 0.0, ..depth };
            self.root = self.contact_cell(self.root, cube, found, search, &mut closer);
            depth.low = closer.low;
            if self.is_late() {
                return depth;
            }
            depth.high = depth.high.min(closer.high);
            if search.only_whether || depth.low == 0.0 || self.apart == 1.0 || self.asked() > LONG {
                return depth;
            }
            let apart = f64::midpoint(self.apart, 1.0);
            self.apart = if apart > 1.0 + CLOSE_PART { apart } else { 1.0 };
        }
    }

    /// Questions that the present one has asked so far.
    const fn asked(&self) -> u64 {
        self.questions - self.begun
    }

    /// Whether a round after the first has asked too many questions.
    const fn is_late(&self) -> bool {
        self.apart < APART && self.asked() > LONG
    }

    fn contact_cell(&mut self, cell: Cell, cube: &Cube, found: Least, search: &Search<'_>, depth: &mut Depth) -> Cell {
        let Least { low, high, deep } = found;
        let (mut at_most, within) = (-deep, search.within_mm);
        let close = within + search.sweep.slack_mm();
        let is_nothing_new = |at_most: f64, depth: &Depth| {
            at_most <= 0.0 || (at_most <= depth.high && (at_most <= within || at_most <= depth.low + close))
        };
        if self.is_late() || search.is_answered(depth) || is_nothing_new(at_most, depth) {
            return cell;
        }
        let mut is_kept = false;
        if cell & UNDIVIDED != 0 && at_most > within {
            let left = self.left(cell, cube, search);
            is_kept = search.keeps_cuts && left < at_most;
            at_most = at_most.min(left);
            if is_nothing_new(at_most, depth) {
                return cell;
            }
        }
        let is_known = !search.only_whether && depth.low > 0.0 && self.apart > 1.0;
        let apart = self.apart * (self.asked() as f64 / LONG as f64).max(1.0);
        let is_enough = is_known && at_most <= apart * depth.low.max(within) || self.asked() > search.most;
        if at_most <= within || cell == MIXED || is_kept || is_enough {
            depth.high = depth.high.max(at_most);
            return cell;
        }
        if cell == SOLID {
            depth.low = depth.low.max(-high);
            // How far the surface of the part is known does not depend on the cell.
            if cube.left == 0 || at_most + low <= within.max(CLOSE_PART * at_most) {
                depth.high = depth.high.max(at_most);
                return cell;
            }
        }
        let first = match cell {
            // Not divided for this: it stays one certainty.
            SOLID => None,
            cell if cell & UNDIVIDED != 0 => Some(self.divide(cell, cube, search.uncut)),
            first => Some(first),
        };
        let child = |tile: &Self, index: u32| first.map_or(SOLID, |first| tile.cells[(first + index) as usize]);
        self.questions += u64::from(cube.fan());
        let mut asked = 0;
        // The deepest first: it makes most of the others needless. What is certain of the solid ones makes more so.
        let mut order: [(u32, Option<Least>); 8] = std::array::from_fn(|index| {
            let index = index as u32;
            let (state, place) = (child(self, index), cube.child(index));
            let is_gone = index >= cube.fan() || matches!(state, OUTSIDE | CUT);
            let found = (!is_gone).then(|| search.sweep.depth(&place.centre, place.half, &mut asked));
            if let Some(found) = found.filter(|found| state == SOLID && -found.deep > within) {
                depth.low = depth.low.max(-found.high);
            }
            (index, found)
        });
        self.questions += asked;
        order.sort_by(|a, b| a.1.map_or(0.0, |l| l.deep).total_cmp(&b.1.map_or(0.0, |l| l.deep)));
        for (index, found) in order {
            let Some(found) = found else { continue };
            let changed = self.contact_cell(child(self, index), &cube.child(index), found, search, depth);
            if let Some(first) = first {
                self.cells[(first + index) as usize] = changed;
            }
        }
        first.map_or(SOLID, |first| self.joined(first, cube))
    }

    /// How deep what the cuts leave of an undivided cell can come into what moves, mm.
    fn left(&mut self, cell: Cell, cube: &Cube, search: &Search<'_>) -> f64 {
        let cuts = &self.lists[(cell & !UNDIVIDED) as usize].sweeps;
        self.questions += cuts.len() as u64;
        let tangents = search.sweep.tangents(&cube.centre, cube.half, &mut self.questions);
        let mut least = f64::INFINITY;
        // What moves is most often where it has cut last.
        for &cut in cuts.iter().rev() {
            least = least.min(self.sweeps[cut as usize].leaves(&cube.centre, cube.half, &tangents, least));
            if least <= search.within_mm {
                break;
            }
        }
        least
    }

    /// What is known at a point, divided as finely as it goes.
    pub fn material_at(&mut self, point: &Point, uncut: &Blank) -> Material {
        let mut cube = self.cube();
        let mut at = None;
        let mut cell = self.root;
        loop {
            if cell & UNDIVIDED != 0 {
                cell = self.divide(cell, &cube, uncut);
                match at {
                    None => self.root = cell,
                    Some(at) => self.cells[at] = cell,
                }
            }
            match cell {
                OUTSIDE | CUT => return Material::Gone,
                SOLID => return Material::Solid,
                MIXED => return Material::Unknown,
                first => {
                    let index = cube.part_of(point);
                    at = Some((first + index) as usize);
                    (cell, cube) = (self.cells[(first + index) as usize], cube.child(index));
                }
            }
        }
    }

    /// Lowers `least` to the distance from a point to the nearest material that may be left, mm. The search ends where `least` is `within_mm` or less.
    pub fn nearest_left(&mut self, point: &Point, within_mm: f64, least: &mut f64, uncut: &Blank) {
        self.root = self.nearest_cell(self.root, &self.cube(), (point, within_mm), least, uncut);
    }

    fn nearest_cell(
        &mut self,
        cell: Cell,
        cube: &Cube,
        (point, within_mm): (&Point, f64),
        least: &mut f64,
        uncut: &Blank,
    ) -> Cell {
        let gap = cube.gap_mm(point);
        if matches!(cell, OUTSIDE | CUT) || gap >= *least || *least <= within_mm {
            return cell;
        }
        let first = match cell {
            SOLID | MIXED => {
                *least = gap;
                return cell;
            }
            cell if cell & UNDIVIDED != 0 => self.divide(cell, cube, uncut),
            first => first,
        };
        // The nearest part first.
        let nearest = cube.part_of(point);
        for index in (0..cube.fan()).map(|index| index ^ nearest) {
            let at = (first + index) as usize;
            self.cells[at] = self.nearest_cell(self.cells[at], &cube.child(index), (point, within_mm), least, uncut);
        }
        first
    }

    /// Calls `visit` with every undivided cell: its centre, half its side, and what is known of it. Cells through which borders run are
    /// divided first where `divides` says so.
    pub fn visit(
        &mut self,
        uncut: &Blank,
        divides: &dyn Fn(&Point, f64) -> bool,
        visit: &mut dyn FnMut(&Point, f64, Material),
    ) {
        self.root = self.visit_cell(self.root, &self.cube(), uncut, divides, visit);
    }

    fn visit_cell(
        &mut self,
        cell: Cell,
        cube: &Cube,
        uncut: &Blank,
        divides: &dyn Fn(&Point, f64) -> bool,
        visit: &mut dyn FnMut(&Point, f64, Material),
    ) -> Cell {
        let first = match cell {
            OUTSIDE | CUT | SOLID | MIXED => {
                let material = match cell {
                    SOLID => Material::Solid,
                    MIXED => Material::Unknown,
                    _ => Material::Gone,
                };
                visit(&cube.centre, cube.half, material);
                return cell;
            }
            cell if cell & UNDIVIDED != 0 => {
                if !divides(&cube.centre, cube.half) {
                    visit(&cube.centre, cube.half, Material::Unknown);
                    return cell;
                }
                self.divide(cell, cube, uncut)
            }
            first => first,
        };
        for index in 0..cube.fan() {
            let at = (first + index) as usize;
            self.cells[at] = self.visit_cell(self.cells[at], &cube.child(index), uncut, divides, visit);
        }
        first
    }
}
