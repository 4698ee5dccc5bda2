//! The remaining stock as a mesh, and its volume.
//!
//! The mesh is the surface of equal cubes: all that hold a cell which is not gone, so that it holds the outer bound. Where two cubes would share an edge and nothing
//! else, a third is added, so that every edge joins exactly two triangles.

use super::{Material, Stock};
use crate::geometry::{Mesh, Point, Vector};

/// Most cubes of the grid: 16 MiB of bits.
const MOST_CUBES: f64 = (1_u32 << 27) as f64;
/// Most triangles of the mesh, but for cubes as large as tiles: 100 MB as STL.
const MOST_TRIANGLES: usize = 2_000_000;

/// Most cubes of the grid in which pieces are counted.
const MOST_CUBES_OF_PIECES: f64 = (1_u32 << 23) as f64;
/// Smallest fraction of the stock that counts as a piece; less is a crumb.
const LEAST_PIECE: f64 = 1e-3;

/// Half the side of cells that are divided to measure volumes, mm.
const VOLUME_MM: f64 = 0.2;

/// A mesh around what may be left.
#[derive(Clone, Debug)]
pub struct Hull {
    /// The mesh, in the frame of the workpiece's. `None` where nothing is left.
    pub mesh: Option<Mesh>,
    /// Side of its cubes, mm.
    pub cube_mm: f64,
}

/// Bounds of a volume, mm³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Volume {
    /// Of what is there for sure.
    pub low: f64,
    /// Of what may be there.
    pub high: f64,
}

impl Stock {
    /// What is left, between two bounds.
    pub fn volume(&mut self) -> Volume {
        let mut volume = Volume::default();
        self.visit(&|_, half| half > VOLUME_MM, &mut |_, half, material| {
            let cube = (2.0 * half).powi(3);
            if material != Material::Gone {
                volume.high += cube;
            }
            if material == Material::Solid {
                volume.low += cube;
            }
        });
        volume
    }

    /// A watertight mesh around all that may be left, of the smallest cubes that make no more than two million triangles.
    pub fn hull(&mut self) -> Hull {
        let mut cube_mm = self.cube_mm(MOST_CUBES);
        loop {
            let grid = self.grid(cube_mm);
            if grid.quads() * 2 <= MOST_TRIANGLES || cube_mm >= self.tile_mm() {
                return Hull { mesh: grid.mesh(), cube_mm };
            }
            cube_mm *= 2.0;
        }
    }

    /// Number of disjoint pieces of what may be left, without crumbs. They are found in cubes: a gap of less than three cubes may not show.
    pub fn pieces(&mut self) -> usize {
        let pieces = self.grid(self.cube_mm(MOST_CUBES_OF_PIECES)).pieces();
        let least = LEAST_PIECE * pieces.iter().sum::<usize>() as f64;
        pieces.iter().filter(|&&cubes| cubes as f64 >= least).count()
    }

    /// Side of the finest cubes of which a grid has at most so many, mm.
    fn cube_mm(&self, most: f64) -> f64 {
        let (low, high) = self.bounds();
        let mut cube_mm = self.cell_mm();
        while ((high - low) / cube_mm).iter().map(|n| n.ceil() + 2.0).product::<f64>() > most {
            cube_mm *= 2.0;
        }
        cube_mm
    }

    fn grid(&mut self, cube_mm: f64) -> Grid {
        let (low, high) = self.bounds();
        // A layer of empty cubes around.
        let counts = std::array::from_fn(|k| ((high[k] - low[k]) / cube_mm).round() as usize + 2);
        let origin = low - Vector::repeat(cube_mm);
        let bits = vec![0; counts.iter().product::<usize>().div_ceil(64)];
        let mut grid = Grid { origin, cube_mm, counts, bits };
        // Squares of a half section are one cube thick.
        let thick = if self.uncut.is_turned() { 0.0 } else { 1.0 };
        self.visit(&|_, half| 2.0 * half > 1.5 * cube_mm, &mut |centre, half, material| {
            if material == Material::Gone {
                return;
            }
            let halves = [half, thick * half, half];
            let first: [usize; 3] =
                std::array::from_fn(|k| ((centre[k] - halves[k] - origin[k]) / cube_mm + 1e-6).floor() as usize);
            let many = halves.map(|half| (2.0 * half / cube_mm).round().max(1.0) as usize);
            for z in first[2]..first[2] + many[2] {
                for y in first[1]..first[1] + many[1] {
                    for x in first[0]..first[0] + many[0] {
                        grid.fill([x, y, z]);
                    }
                }
            }
        });
        grid.join_corners();
        grid
    }
}

/// Cubes, filled or not; those on the border are empty.
struct Grid {
    origin: Point,
    cube_mm: f64,
    counts: [usize; 3],
    bits: Vec<u64>,
}

impl Grid {
    fn index(&self, at: [usize; 3]) -> usize {
        at[0] + self.counts[0] * (at[1] + self.counts[1] * at[2])
    }

    fn fill(&mut self, at: [usize; 3]) {
        let index = self.index(at);
        self.bits[index / 64] |= 1 << (index % 64);
    }

    fn is_full(&self, at: [usize; 3]) -> bool {
        let index = self.index(at);
        self.bits[index / 64] >> (index % 64) & 1 == 1
    }

    fn places(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let [x, y, z] = self.counts;
        (0..z).flat_map(move |z| (0..y).flat_map(move |y| (0..x).map(move |x| [x, y, z])))
    }

    /// Fills a third cube wherever two that share an edge alone have the other two around it empty.
    fn join_corners(&mut self) {
        loop {
            let mut changed = false;
            for at in self.places() {
                if !self.is_full(at) {
                    continue;
                }
                for axis in 0..3 {
                    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
                    for back in [false, true] {
                        let step = |mut at: [usize; 3], along: usize, back: bool| {
                            at[along] = if back { at[along] - 1 } else { at[along] + 1 };
                            at
                        };
                        let (one, other) = (step(at, u, false), step(at, v, back));
                        let across = step(one, v, back);
                        if self.is_full(across) && !self.is_full(one) && !self.is_full(other) {
                            self.fill(one);
                            changed = true;
                        }
                    }
                }
            }
            if !changed {
                return;
            }
        }
    }

    /// Counts of full cubes that are joined by faces. Empties the grid.
    fn pieces(mut self) -> Vec<usize> {
        let [x, y, _] = self.counts;
        let steps = [1, x, x * y];
        let mut pieces = Vec::new();
        for word in 0..self.bits.len() {
            while self.bits[word] != 0 {
                let first = 64 * word + self.bits[word].trailing_zeros() as usize;
                self.take(first);
                let (mut open, mut cubes) = (vec![first], 0);
                while let Some(index) = open.pop() {
                    cubes += 1;
                    // Cubes on the border of the grid are empty: the neighbours of a full one are in the grid.
                    let beside = steps.iter().flat_map(|step| [index - step, index + step]);
                    open.extend(beside.filter(|&next| self.take(next)));
                }
                pieces.push(cubes);
            }
        }
        pieces
    }

    /// Empties a cube; whether it was full.
    fn take(&mut self, index: usize) -> bool {
        let (word, bit) = (&mut self.bits[index / 64], 1_u64 << (index % 64));
        let was_full = *word & bit != 0;
        *word &= !bit;
        was_full
    }

    /// Calls `quad` with each face of a full cube towards an empty one: the cube, the axis, and whether it is the far face.
    fn faces(&self, mut quad: impl FnMut([usize; 3], usize, bool)) {
        for at in self.places().filter(|&at| self.is_full(at)) {
            for axis in 0..3 {
                for far in [false, true] {
                    let mut next = at;
                    next[axis] = if far { at[axis] + 1 } else { at[axis] - 1 };
                    if !self.is_full(next) {
                        quad(at, axis, far);
                    }
                }
            }
        }
    }

    fn quads(&self) -> usize {
        let mut count = 0;
        self.faces(|_, _, _| count += 1);
        count
    }

    fn mesh(&self) -> Option<Mesh> {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        let mut number_of = std::collections::BTreeMap::new();
        let mut vertex = |at: [usize; 3]| {
            *number_of.entry(at).or_insert_with(|| {
                vertices.push(self.origin + Vector::from(at.map(|n| n as f64)) * self.cube_mm);
                (vertices.len() - 1) as u32
            })
        };
        self.faces(|at, axis, far| {
            let mut corner = at;
            corner[axis] += usize::from(far);
            let along = |mut at: [usize; 3], axis: usize| {
                at[axis] += 1;
                at
            };
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let mut quad = [corner, along(corner, u), along(along(corner, u), v), along(corner, v)].map(&mut vertex);
            if !far {
                quad.reverse();
            }
            let [a, b, c, d] = quad;
            faces.extend([[a, b, c], [a, c, d]]);
        });
        Mesh::new(vertices, faces).ok()
    }
}
