//! `check --certify`: a proof that a program's moves are free of contact, which a program of others can check.
//!
//! Reading order: this file (what is asked and answered), `motion` (what moves do to a pair), `hull` (planes between meshes), `search` (one pair along
//! the path), `text` (the certificate). The mathematics and the format stand in `docs/certificate.md`; `crates/certificate-checker` checks.
//!
//! Method. Conservative advancement in whole (Schwarzer, Saha and Latombe 2005): an interval of the path is free when planes part the pair at its middle by more than
//! both can come towards each other along the plane's normal within it; else it is halved. A pair of meshes is parted by planes between pairs of convex hulls of
//! subtrees. Contact is proved by an edge that pierces a triangle.

mod hull;
mod motion;
mod search;
mod text;

use crate::geometry::Mesh;
use crate::machine::travel::Ball;
use crate::measure::Progress;
use crate::method::Model;
use crate::registry::Variant;
use crate::scene::pairs::{self, Dropped, Reach};
use crate::scene::{Clearances, Pair, Part, ProgramRun, Scene, TipFault};
use crate::tree::{Policy, SplitRule};
use crate::truth::Solid;
use hull::Tree;
use motion::{Course, PairMotion, Step, Track};
use rayon::prelude::*;
use search::{Asked, Entry, Finding, Search};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Verdict on a block of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Every pair that is examined is free: proved.
    Free,
    /// The same but for the cutter, which at a rapid is not proved to stay off the whole workpiece; it may be in what was cut away.
    Stock,
    /// Some pair is neither proved free nor proved in contact.
    Unresolved,
    /// Some pair is in contact: proved.
    Collision,
}

impl Verdict {
    /// Its name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Stock => "stock",
            Self::Unresolved => "unresolved",
            Self::Collision => "collision",
        }
    }
}

/// A stretch of a move on which a pair is not proved free, or a rapid on which the cutter is not proved to stay off the whole workpiece.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// Line of the program; 0 before the first move.
    pub line: u32,
    /// Which move of the line, from 1.
    pub nth: usize,
    /// The parts.
    pub pair: Pair,
    /// Fractions of the move, for a dog-leg of its time. The first contact, or the unresolved stretch, lies between them.
    pub within: [f64; 2],
    /// For a collision the travel between these fractions, mm; for any other stretch the clearance at which the search stopped, mm, and `None` where nothing bounds
    /// the way of the axes there.
    pub size_mm: Option<f64>,
    /// Any but [`Verdict::Free`].
    pub verdict: Verdict,
}

/// A certificate.
#[derive(Clone, Debug)]
pub struct Certificate {
    /// The file's content.
    pub text: String,
    /// Each line of the program that has moves, in order, with what is known of it.
    pub blocks: BTreeMap<u32, Verdict>,
    /// Lines in which a cutter feeds, where it may be in the workpiece.
    pub cutting: BTreeSet<u32>,
    /// Stretches on which a pair is not proved free, by place.
    pub doubts: Vec<Doubt>,
    /// Pairs that are not examined, and why.
    pub skipped: Vec<(Pair, &'static str)>,
    /// Number of pairs that are examined.
    pub examined: usize,
    /// Intervals that are proved free, of all pairs.
    pub intervals: usize,
    /// Planes that the certificate states.
    pub planes: usize,
}

impl Certificate {
    /// How many blocks have a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.blocks.values().filter(|&&other| other == verdict).count()
    }
}

/// Why a pair is not examined, as the certificate says it.
fn skipped(dropped: &Dropped) -> Option<&'static str> {
    match dropped {
        Dropped::Rigid => Some("rigid"),
        Dropped::Neighbours { .. } => Some("neighbours"),
        Dropped::DifferentTools { .. } => Some("tools"),
        Dropped::Ignored => Some("ignored"),
        Dropped::Allowed => Some("allowed"),
        // Where the program goes is what is to be proved.
        Dropped::OutOfReach { .. } | Dropped::NeverMounted { .. } => None,
    }
}

/// Searches for a proof of each block, and writes the certificate of what it found.
///
/// With a variant, the certificate halves meshes as the variant's tree does when it is split at medians, and the variant is asked whether the pair touches at the
/// middle of an interval before planes are sought for it. A wrong answer costs time or a proof, and proves nothing.
///
/// # Errors
/// When a rapid has too many legs to be followed.
pub fn certify(
    scene: &Scene,
    run: &ProgramRun,
    variant: Option<&Variant>,
    progress: &dyn Progress,
) -> Result<Certificate, TipFault> {
    let track = Track::new(&scene.machine, run.tip.as_ref(), motion::steps(scene, run)?);
    let decisions = pairs::decide(scene, &Reach::of_limits(scene), &Clearances::everywhere(&[f64::INFINITY]));
    let (mut examined, mut not) = (Vec::new(), Vec::new());
    for decision in &decisions {
        match decision.dropped.as_ref().and_then(skipped) {
            Some(why) => not.push((decision.pair, why)),
            None => examined.push(work_first(scene, run, decision.pair)),
        }
    }
    progress.begin("certifying", examined.len() as u64);
    let prepare = |mesh: &Mesh| variant.map(|variant| variant.prepare(mesh, Some(Policy::own(SplitRule::Median))));
    let models: Vec<Option<Box<dyn Model>>> = scene.parts.par_iter().map(|part| prepare(&part.mesh)).collect();
    let tree = |(part, model): (&Part, &Option<Box<dyn Model>>)| {
        Tree::new(&part.mesh, model.as_ref().and_then(|model| model.order()))
    };
    let trees: Vec<Tree> = scene.parts.par_iter().zip(&models).map(tree).collect();
    let solids: Vec<Solid> = scene.parts.iter().map(|part| Solid::new(Arc::clone(&part.mesh))).collect();
    let balls: Vec<Ball> = scene.parts.iter().map(pairs::ball).collect();
    let search = |&pair: &Pair| {
        let both = [pair.a, pair.b];
        let [a, b] = both.map(|part| balls[part]);
        let motion = PairMotion { machine: &scene.machine, a, b };
        let mut search = Search::new(
            &track,
            motion,
            both.map(|part| &scene.parts[part].link_from_part),
            both.map(|part| &trees[part]),
            both.map(|part| models[part].as_deref()),
            both.map(|part| &solids[part]),
            Asked { tools: both.map(|part| scene.parts[part].tool), is_cutting: scene.is_cutting(pair) },
        );
        search.run();
        progress.advance(1);
        (pair, search.entries)
    };
    let found: Vec<(Pair, Vec<Entry>)> = examined.par_iter().map(search).collect();
    Ok(conclude(scene, run, &track, &trees, not, &found))
}

/// Orders a pair so that the part on the workpiece's link comes before the part on the tool's link: planes are fixed to the first.
fn work_first(scene: &Scene, run: &ProgramRun, pair: Pair) -> Pair {
    let [a, b] = [pair.a, pair.b].map(|part| scene.parts[part].link);
    let is_work_last = run.tip.as_ref().is_some_and(|tip| a == tip.tool_link && b == tip.work_link);
    if is_work_last { Pair { a: pair.b, b: pair.a } } else { pair }
}

/// For each step which move of its line it is, from 1; the legs of a dog-leg are one move.
fn moves_of_lines(steps: &[Step]) -> Vec<usize> {
    let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
    let nth = |step: &Step| {
        let count = counts.entry(step.line).or_default();
        *count += usize::from(step.within[0] <= 0.0);
        *count
    };
    steps.iter().map(nth).collect()
}

/// The certificate of what was found.
fn conclude(
    scene: &Scene,
    run: &ProgramRun,
    track: &Track<'_>,
    trees: &[Tree],
    skipped: Vec<(Pair, &'static str)>,
    found: &[(Pair, Vec<Entry>)],
) -> Certificate {
    let mut blocks: BTreeMap<u32, Verdict> = track.steps.iter().map(|step| (step.line, Verdict::Free)).collect();
    let (mut cutting, mut doubts, mut intervals) = (BTreeSet::new(), Vec::new(), 0);
    let nths = moves_of_lines(&track.steps);
    for (pair, entries) in found {
        for entry in entries {
            let steps = entry.from.floor() as usize..entry.to.ceil() as usize;
            let (end, size_mm, verdict) = match &entry.finding {
                Finding::Away => continue,
                Finding::Meant => {
                    let feeds = track.steps[steps].iter().filter(|step| step.course != Course::Point);
                    cutting.extend(feeds.map(|step| step.line));
                    continue;
                }
                Finding::Free { .. } => {
                    intervals += 1;
                    continue;
                }
                Finding::Open { apart_mm } if scene.is_cutting(*pair) => (entry.to, *apart_mm, Verdict::Stock),
                Finding::Open { apart_mm } => (entry.to, *apart_mm, Verdict::Unresolved),
                Finding::Hit { place, way_mm, .. } => (*place, Some(*way_mm), Verdict::Collision),
            };
            for step in steps {
                let (Step { line, within: [first, last], .. }, begin) = (&track.steps[step], step as f64);
                let known = blocks.entry(*line).or_insert(verdict);
                *known = verdict.max(*known);
                let within = [entry.from, end].map(|place| (place - begin).clamp(0.0, 1.0));
                let place = begin + within[0];
                let within = within.map(|part| first + part * (last - first));
                doubts.push((place, Doubt { line: *line, nth: nths[step], pair: *pair, within, size_mm, verdict }));
            }
        }
    }
    doubts.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let doubts = doubts.into_iter().map(|(_, doubt)| doubt).collect();
    let text = text::write(&text::Proof { scene, run, steps: &track.steps, trees, skipped: &skipped, found });
    let fronts = text.lines().filter(|line| line.starts_with("free "));
    let planes = fronts.map(|line| line.matches(" p ").count()).sum();
    Certificate { text, blocks, cutting, doubts, skipped, examined: found.len(), intervals, planes }
}
