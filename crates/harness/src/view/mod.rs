//! The machine in motion, for people who would rather look than read: one page that opens from disk, and GLB for other viewers.
//!
//! Reading order: this file (what is asked and gathered), [`data`] (what the page gets), `pack` (numbers as text), `motion`
//! (the path in few keys), `events` (what `check` found, with its triangles), `distances` (the nearest pair along the path),
//! `tool_path` (what the way of the tool is drawn from), `trees` (volumes by level), `page` (the document; its scripts are in `page/`), [`glb`].
//!
//! The page does not get poses but axis positions, and the links with their joints: it does the forward kinematics itself. So a
//! program costs a few numbers per block, and between two keys the machine is where `check` looked for contact.

pub mod data;
mod distances;
mod events;
pub mod glb;
mod motion;
mod pack;
mod page;
mod tool_path;
mod trees;

pub use data::ViewData;
pub use page::{fragment, page};

use crate::check::{self, CheckError, Outcome, Path, Settings};
use crate::measure::Progress;
use crate::method::Model;
use crate::picture::Up;
use crate::registry::{Registry, Variant};
use crate::scene::{Pair, ProgramRun, Scene, TipFault};
use motion::Motion;
use rayon::prelude::*;
use rs274::Plane;
use std::collections::{BTreeMap, BTreeSet};
use thiserror::Error;

/// What is shown.
#[derive(Clone, Debug)]
pub struct Choice<'a> {
    /// The variant whose trees `check` uses.
    pub method: &'a Variant,
    /// All variants: `check` asks the fastest about pairs that `method` is not made for.
    pub registry: &'a Registry,
    /// Variants whose trees are drawn, side by side when there are two.
    pub variants: Vec<&'a Variant>,
    /// How many levels of them.
    pub levels: u32,
    /// The axis that is up.
    pub up: Up,
    /// Zones and tolerance of `check`.
    pub settings: Settings,
    /// What the check says nothing about, a line each.
    pub notes: fn(&Scene, &ProgramRun, &Outcome) -> Vec<String>,
}

/// Most levels of a tree that a page may hold: 2¹² volumes of each part are more than an eye can tell apart.
pub const MOST_LEVELS: u32 = 12;

/// Why there is no view.
#[derive(Debug, Error)]
pub enum ViewError {
    /// The program cannot be checked.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// The program cannot be followed.
    #[error(transparent)]
    Tip(#[from] TipFault),
    /// A variant has no tree of ours to draw.
    #[error("`{0}` has no tree that could be drawn")]
    NoTree(&'static str),
    /// More levels than a page can show, or none.
    #[error("1 to {MOST_LEVELS} levels of a tree can be drawn, not {0}")]
    Levels(u32),
    /// The scene has nothing to look at.
    #[error("scene `{0}` has no parts")]
    NoParts(String),
}

/// Checks a program on a scene's machine and gathers what a page shows of it; without a program, the machine as it stands at zero.
///
/// # Errors
/// When the program cannot be run, or the choice is none.
pub fn gather(
    scene: &Scene,
    run: Option<&ProgramRun>,
    choice: &Choice,
    progress: &dyn Progress,
) -> Result<ViewData, ViewError> {
    if !(1..=MOST_LEVELS).contains(&choice.levels) {
        return Err(ViewError::Levels(choice.levels));
    }
    if scene.parts.is_empty() {
        return Err(ViewError::NoParts(scene.name.clone()));
    }
    let mut data = ViewData::of_scene(scene, choice.up);
    if let Some(run) = run {
        let path = Path::new(scene, run)?;
        let outcome = examine(scene, run, choice, progress)?;
        let motion = Motion::new(&path, run, &outcome.events);
        data.set_program(scene, run, &motion);
        let models = Models::new(scene, &outcome, choice.method);
        progress.begin("finding the nearest pair", path.samples().len() as u64);
        data.distances = distances::along(scene, &path, &motion, &outcome, &models, progress);
        data.events = events::all(scene, &path, &motion, &outcome, &models);
        data.faults = events::faults(scene, &path, &motion, &outcome);
        data.notes = (choice.notes)(scene, run, &outcome);
    }
    progress.begin("drawing trees", (choice.variants.len() * scene.parts.len()) as u64);
    for &variant in &choice.variants {
        data.variants.push(trees::of_variant(scene, variant, choice.levels, progress)?);
    }
    Ok(data)
}

/// The examined parts, prepared for one variant.
struct Models(BTreeMap<usize, Box<dyn Model>>);

impl Models {
    fn new(scene: &Scene, outcome: &Outcome, method: &Variant) -> Self {
        let kept = outcome.decisions.iter().filter(|decision| decision.dropped.is_none());
        let parts: BTreeSet<usize> = kept.flat_map(|decision| [decision.pair.a, decision.pair.b]).collect();
        let prepare = |part: usize| (part, method.prepare(&scene.parts[part].mesh, None));
        Self(parts.into_par_iter().map(prepare).collect::<Vec<_>>().into_iter().collect())
    }

    /// Those of a pair; `None` when it is not examined.
    fn of(&self, pair: Pair) -> Option<[&dyn Model; 2]> {
        let model = |part: usize| self.0.get(&part).map(AsRef::as_ref);
        Some([model(pair.a)?, model(pair.b)?])
    }
}

/// The axis that is up unless somebody says otherwise: y under a lathe's controller, whose bed lies along z; else z.
pub fn upright(scene: &Scene) -> Up {
    match &scene.program {
        Some(run) if run.setup.plane == Plane::Zx => Up::Y,
        _ => Up::Z,
    }
}

/// What `check` says. A scene without pairs, or a program without moves, is no reason not to look at it.
fn examine(scene: &Scene, run: &ProgramRun, choice: &Choice, progress: &dyn Progress) -> Result<Outcome, CheckError> {
    let settings = Settings { stop_at_first: false, ..choice.settings.clone() };
    match check::check(scene, run, choice.method, choice.registry, &settings, progress) {
        Err(CheckError::NoPairs(_) | CheckError::NoMoves(_)) => Ok(Outcome::default()),
        other => other,
    }
}
