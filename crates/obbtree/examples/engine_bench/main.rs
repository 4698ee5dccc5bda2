//! Times the engine by class of query and writes every query's least time and operation counts.
//!
//!     cargo run --release -p obbtree --features cases --example engine_bench -- --out FILE [--passes N] [--only TEXT] [PAIR...]
//!
//! A `PAIR` is a folder that `bvbench peers run --out DIR` leaves in `DIR/SCENE/PAIR` (`docs/adding-a-peer.md` lists its arrays); shapes that are
//! hard in one way each (needles, coaxial cylinders, faces that touch flat) are made here. `FILE` gets one line per query: pair, class, number,
//! nanoseconds (the least of all passes, less a reading of the clock), volume tests, triangle tests, answer. `scripts/engine-compare` runs the
//! binaries of two revisions in turn and prints the ratios by class.

#![allow(clippy::print_stdout, reason = "an example prints what it finds")]

mod pairs;
mod poses;

use obbtree::engine::distance::distance_mm;
use obbtree::engine::geometry::{GridMesh, Isometry};
use obbtree::engine::oriented::Oriented;
use obbtree::engine::path::{Coherence, Memory};
use obbtree::engine::proximity::Proximity;
use obbtree::engine::traverse::{Scratch, all, first};
use obbtree::engine::{Simd, WideTree};
use std::error::Error;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

/// The tree that is timed.
type Tree = WideTree<Oriented>;

/// What is asked of a pair of trees at each pose of a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// Whether the meshes touch.
    First,
    /// How many pairs of triangles touch.
    All,
    /// How far apart the meshes are, mm.
    Distance,
    /// As `First`, with what earlier poses left behind.
    Path,
    /// As `First`, fresh, at the poses of `Path`.
    PathFresh,
}

/// Poses that are asked about in order.
pub struct Class {
    /// What tells it from others of its pair.
    pub name: String,
    /// What is asked.
    pub query: Query,
    /// Mesh `b` in the frame of `a`.
    pub poses: Vec<Isometry>,
}

/// Two meshes.
pub struct Pair {
    /// Unique among all.
    pub name: String,
    /// The mesh in whose frame poses are given.
    pub a: GridMesh,
    /// The mesh that is moved.
    pub b: GridMesh,
}

/// What one query took and said.
#[derive(Clone, Copy)]
struct Answer {
    ns: f64,
    volume_tests: u64,
    triangle_tests: u64,
    value: f64,
}

struct Options {
    out: PathBuf,
    passes: usize,
    only: String,
    folders: Vec<PathBuf>,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options = Self { out: PathBuf::new(), passes: 5, only: String::new(), folders: Vec::new() };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
            match word.as_str() {
                "--out" => options.out = value()?.into(),
                "--passes" => options.passes = value()?.parse()?,
                "--only" => options.only = value()?,
                folder => options.folders.push(folder.into()),
            }
        }
        if options.out.as_os_str().is_empty() {
            return Err("usage: engine_bench --out FILE [--passes N] [--only TEXT] [PAIR...]".into());
        }
        Ok(options)
    }
}

/// Nanoseconds that a reading of the clock takes: the least of many.
fn clock_ns() -> f64 {
    let readings = (0..10_000).map(|_| {
        let start = Instant::now();
        start.elapsed().as_nanos() as f64
    });
    readings.fold(f64::INFINITY, f64::min)
}

/// Memory of all kinds of queries.
#[derive(Default)]
struct Memories {
    scratch: Scratch,
    proximity: Proximity,
    memory: Memory,
}

fn ask(query: Query, (a, b): (&Tree, &Tree), pose: &Isometry, simd: Simd, memories: &mut Memories) -> f64 {
    let Memories { scratch, proximity, memory } = memories;
    match query {
        Query::First | Query::PathFresh => f64::from(first(a, b, pose, simd, scratch)),
        Query::All => all(a, b, pose, simd, scratch).len() as f64,
        Query::Distance => {
            proximity.nearest = None;
            distance_mm(a, b, pose, simd, f64::INFINITY, proximity)
        }
        Query::Path => f64::from(memory.first(a, b, pose, simd, Coherence::Evidence)),
    }
}

fn time_class(class: &Class, trees: (&Tree, &Tree), passes: usize, clock: f64) -> Vec<Answer> {
    let simd = Simd::in_use();
    let mut memories = Memories::default();
    let mut answers =
        vec![Answer { ns: f64::INFINITY, volume_tests: 0, triangle_tests: 0, value: 0.0 }; class.poses.len()];
    for _ in 0..passes {
        // Each pass of a path is fresh.
        memories.memory = Memory::default();
        for (pose, answer) in class.poses.iter().zip(&mut answers) {
            let start = Instant::now();
            let value = ask(class.query, trees, pose, simd, &mut memories);
            let ns = (start.elapsed().as_nanos() as f64 - clock).max(1.0);
            let counts = memories.scratch.counts();
            *answer = Answer {
                ns: answer.ns.min(ns),
                volume_tests: counts.volume_tests,
                triangle_tests: counts.triangle_tests,
                value,
            };
        }
    }
    answers
}

fn time_build(pair: &Pair, passes: usize) -> (f64, f64) {
    let mut least = f64::INFINITY;
    let mut bytes = 0;
    for _ in 0..passes {
        let start = Instant::now();
        let (a, b) = (Tree::build(&pair.a), Tree::build(&pair.b));
        least = least.min(start.elapsed().as_nanos() as f64);
        bytes = a.bytes() + b.bytes();
    }
    (least, bytes as f64 / (pair.a.faces().len() + pair.b.faces().len()) as f64)
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let clock = clock_ns();
    let mut text = String::new();
    let mut pairs = Vec::new();
    for folder in &options.folders {
        pairs.push(pairs::read(folder)?);
    }
    pairs.extend(pairs::made());
    for (pair, recorded) in &pairs {
        let trees = (&Tree::build(&pair.a), &Tree::build(&pair.b));
        for class in poses::classes(pair, trees, recorded) {
            let name = format!("{}/{}", pair.name, class.name);
            if !name.contains(&options.only) {
                continue;
            }
            for (number, answer) in time_class(&class, trees, options.passes, clock).iter().enumerate() {
                let Answer { ns, volume_tests, triangle_tests, value } = answer;
                let (pair, class) = (&pair.name, &class.name);
                writeln!(text, "{pair}\t{class}\t{number}\t{ns:.0}\t{volume_tests}\t{triangle_tests}\t{value:e}")?;
            }
        }
        if format!("{}/build", pair.name).contains(&options.only) {
            let (ns, bytes) = time_build(pair, options.passes.min(5));
            writeln!(text, "{}\tbuild\t0\t{ns:.0}\t0\t0\t{bytes:e}", pair.name)?;
        }
    }
    std::fs::write(&options.out, text)?;
    println!("{} written; `scripts/engine-compare` compares two of them", options.out.display());
    Ok(())
}
