//! Compares two runs: what changed beyond noise, and whether the later run misses more contacts.
//!
//! A scene is compared when its inputs have the same content in both runs. If both runs also requested the same workload, they have the
//! same poses. Times are then paired by launch and chunk, and counts query by query. Counts, trees and misses are deterministic, so any
//! difference is a change. A time has changed when the whole interval of its ratio (see [`super::totals`]) lies outside the range that the run's
//! own null comparison calls equal. Launches of two runs share only their number, so the interval includes the spread of both runs. A single
//! launch decides nothing: what differs between launches is not known.

mod changes;
#[cfg(test)]
mod tests;

pub use changes::{CountChange, MissChange, TimeChange, TreeChange, VerdictChange};

use super::misses::Misses;
use super::table::{self, Scene};
use super::words::listed;
use super::{ALL, AnalysisError, EQUAL};
use crate::record::rows::CaseKey;
use crate::record::vocabulary::named;
use crate::record::{
    ClaimRow, Manifest, NULL_VARIANT, PROGRAM_TIME, RatioRow, TightnessRow, TreeRow, read_rows, read_rows_if_there,
};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// What two runs have in common, and what differs.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Comparison {
    /// All scenes of both runs, and how far each can be compared.
    pub scenes: Vec<SceneMatch>,
    /// How much was compared of each kind.
    pub compared: Compared,
    /// Differences between the runs as wholes, such as another machine or another seed.
    pub notes: Vec<String>,
    /// Cases of the earlier run only, as `scene: variant policy`.
    pub only_before: Vec<String>,
    /// Cases of the later run only, as `scene: variant policy`.
    pub only_after: Vec<String>,
    /// Times of queries, programs and constructions of all cases that both runs timed on the same poses.
    pub times: Vec<TimeChange>,
    /// Cases whose counts differ.
    pub counts: Vec<CountChange>,
    /// Trees that differ.
    pub trees: Vec<TreeChange>,
    /// Cases that miss more or fewer contacts.
    pub misses: Vec<MissChange>,
    /// Verdicts that differ.
    pub verdicts: Vec<VerdictChange>,
}

/// How many pairs of each kind were compared: without any, an empty list of changes says nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Compared {
    /// Times.
    pub times: usize,
    /// Cases and strata with counted queries.
    pub counts: usize,
    /// Trees.
    pub trees: usize,
    /// Cases that both runs verified in a scene.
    pub misses: usize,
    /// Verdicts.
    pub verdicts: usize,
}

/// Why a scene cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NotCompared {
    /// The second run has no such scene.
    OnlyBefore,
    /// The first run has no such scene.
    OnlyAfter,
    /// These inputs differ.
    Inputs(Vec<String>),
}

impl fmt::Display for NotCompared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OnlyBefore => f.write_str("the second run has no such scene"),
            Self::OnlyAfter => f.write_str("the first run has no such scene"),
            Self::Inputs(inputs) if inputs.len() == 1 => write!(f, "{} differs", inputs[0]),
            Self::Inputs(inputs) => write!(f, "{} differ", listed(inputs)),
        }
    }
}

/// How far a scene can be compared between two runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneMatch {
    /// Scene.
    pub scene: String,
    /// Why the scene cannot be compared; `None` when it can.
    pub not_compared: Option<NotCompared>,
    /// Whether the poses are the same, so that times and counts can be paired.
    pub same_poses: bool,
    /// Noise by the null comparisons of both runs: a ratio of times within `[1 / noise, noise]` is no change.
    pub noise: f64,
    /// The same of the times of whole programs; none without programs.
    pub program_noise: Option<f64>,
    /// Geometric mean of the time ratios of all cases. It shows what affected all cases alike, such as another load of the machine.
    pub drift: Option<f64>,
}

named! {
    /// A reason why a later run is not accepted in the place of an earlier one.
    pub enum Gate {
        /// A case misses contacts that it did not miss.
        Misses = "misses",
        /// Operations of a query, or a tree, are others.
        Counts = "counts",
        /// Queries, programs or constructions of a case take longer, beyond noise.
        Slower = "slower",
        /// A scene of the earlier run is not compared, or a case is not there any more.
        Uncompared = "uncompared",
    }
}

impl FromStr for Gate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|gate| gate.id() == text);
        found.ok_or_else(|| format!("`{text}` is no gate: expected misses, counts, slower or uncompared"))
    }
}

impl Comparison {
    /// Whether the runs have nothing in common but verdicts, which may be of sentences that no run judges: no gate can be passed.
    pub fn is_of_nothing(&self) -> bool {
        Compared { verdicts: 0, ..self.compared } == Compared::default()
    }

    /// The gates at which the later run fails. Times are judged over all strata together, as the noise is.
    pub fn failed(&self) -> Vec<Gate> {
        let is_whole = |row: &&TimeChange| [ALL, "-"].contains(&row.stratum.as_str());
        let fails = |gate: &Gate| match gate {
            Gate::Misses => self.misses.iter().any(|change| change.is_regression),
            Gate::Counts => !self.counts.is_empty() || !self.trees.is_empty(),
            Gate::Slower => self.times.iter().filter(is_whole).any(|row| row.change == "slower"),
            Gate::Uncompared => !self.only_before.is_empty() || self.scenes.iter().any(|scene| !scene.same_poses),
        };
        Gate::ALL.into_iter().filter(fails).collect()
    }
}

/// The records of a run that are compared. Files that the analysis derives may be missing.
struct Side {
    manifest: Manifest,
    scenes: BTreeMap<String, Scene>,
    misses: Misses,
    trees: Vec<TreeRow>,
    tightness: Vec<TightnessRow>,
    ratios: Vec<RatioRow>,
    claims: Vec<ClaimRow>,
}

impl Side {
    fn read(folder: &Path) -> Result<Self, AnalysisError> {
        Ok(Self {
            manifest: Manifest::read(folder)?,
            scenes: table::read(folder)?,
            misses: Misses::read(folder)?,
            trees: read_rows(folder)?,
            tightness: read_rows(folder)?,
            ratios: read_rows_if_there(folder)?,
            claims: read_rows_if_there(folder)?,
        })
    }

    fn names(&self) -> impl Iterator<Item = &String> {
        self.manifest.scenes.iter().map(|scene| &scene.name)
    }

    /// The inputs of a scene: those in its folder, and those outside the folder of any scene.
    fn inputs(&self, scene: &str) -> BTreeMap<&str, &str> {
        let is_shared = |path: &str| !self.names().any(|name| is_in_folder(path, name));
        let inputs = self.manifest.inputs.iter().map(|(path, hash)| (path.as_str(), hash.as_str()));
        inputs.filter(|(path, _)| is_in_folder(path, scene) || is_shared(path)).collect()
    }

    /// Noise of a metric in a scene by its null comparison: the larger distance of its interval's ends from 1, as a ratio. It is at least the
    /// upper end of [`EQUAL`]. A run without a null comparison gets the upper end of [`super::STEADY`].
    fn noise(&self, scene: &str, metric: &str) -> f64 {
        let is_null = |row: &&RatioRow| row.variant == NULL_VARIANT && row.metric == metric && row.stratum == ALL;
        let nulls = self.ratios.iter().filter(is_null).filter(|row| row.scene == scene);
        let farthest = nulls.filter_map(RatioRow::interval).map(|(low, high)| high.max(1.0 / low)).reduce(f64::max);
        farthest.map_or(super::STEADY.1, |end| end.max(EQUAL.1))
    }
}

fn is_in_folder(path: &str, name: &str) -> bool {
    path.split('/').rev().skip(1).any(|folder| folder == name)
}

/// Compares the run in `after` with the one in `before`.
///
/// # Errors
/// When a record of either run is missing, malformed or contradicts itself. `ratios.csv` and `claims.csv` may be missing.
pub fn compare_runs(before: &Path, after: &Path) -> Result<Comparison, AnalysisError> {
    let (before, after) = (Side::read(before)?, Side::read(after)?);
    let mut comparison = Comparison { notes: notes(&before.manifest, &after.manifest), ..Comparison::default() };
    let names: BTreeSet<&String> = before.names().chain(after.names()).collect();
    for name in names {
        let mut scene = scene_match(name, &before, &after);
        if scene.not_compared.is_none() {
            changes::of_scene(&mut scene, &before, &after, &mut comparison);
        }
        changes::of_misses(&scene, &before, &after, &mut comparison);
        comparison.scenes.push(scene);
    }
    changes::of_verdicts(&before, &after, &mut comparison);
    comparison.compared.times = comparison.times.len();
    Ok(comparison)
}

fn scene_match(name: &str, before: &Side, after: &Side) -> SceneMatch {
    let (old, new) = (before.inputs(name), after.inputs(name));
    let paths: BTreeSet<&str> = old.keys().chain(new.keys()).copied().collect();
    // What only one run has, and not in the scene's folder, is another scene's: a scene that began to use it has changed itself.
    let is_own = |path: &str| is_in_folder(path, name) || (old.contains_key(path) && new.contains_key(path));
    let is_other = |path: &&str| is_own(path) && old.get(*path) != new.get(*path);
    let differing: Vec<String> = paths.into_iter().filter(is_other).map(str::to_owned).collect();
    let has_scene = |side: &Side| side.names().any(|other| other == name);
    let not_compared = match (has_scene(before), has_scene(after)) {
        (_, false) => Some(NotCompared::OnlyBefore),
        (false, true) => Some(NotCompared::OnlyAfter),
        (true, true) => (!differing.is_empty()).then_some(NotCompared::Inputs(differing)),
    };
    let (a, b) = (&before.manifest.request, &after.manifest.request);
    let same_request = (a.seed, a.measure_poses, &a.workloads) == (b.seed, b.measure_poses, &b.workloads);
    let scenes = before.scenes.get(name).zip(after.scenes.get(name));
    let noise = |metric: &str| before.noise(name, metric).max(after.noise(name, metric));
    let has_programs = scenes.is_some_and(|(_, new)| new.programs().next().is_some());
    SceneMatch {
        scene: name.to_owned(),
        same_poses: not_compared.is_none() && same_request && scenes.is_some_and(|(old, new)| old.has_poses_of(new)),
        not_compared,
        noise: noise("time"),
        program_noise: has_programs.then(|| noise(PROGRAM_TIME)),
        drift: None,
    }
}

/// Differences between the runs as wholes.
fn notes(before: &Manifest, after: &Manifest) -> Vec<String> {
    let mut notes = Vec::new();
    let mut differ = |what: &str, old: String, new: String| {
        if old != new {
            notes.push(format!("{what}: {old} before, {new} after"));
        }
    };
    differ("processor", before.machine.cpu.clone(), after.machine.cpu.clone());
    differ("compiler", before.program.rustc.clone(), after.program.rustc.clone());
    differ("flags", before.program.flags.clone(), after.program.flags.clone());
    differ("git revision", before.program.git_revision.clone(), after.program.git_revision.clone());
    differ("seed", before.request.seed.to_string(), after.request.seed.to_string());
    differ("poses timed", before.request.measure_poses.to_string(), after.request.measure_poses.to_string());
    differ("poses verified", before.request.verify_poses.to_string(), after.request.verify_poses.to_string());
    for (manifest, which) in [(before, "first"), (after, "second")] {
        notes.extend(manifest.noise.iter().map(|note| format!("noise in the {which} run: {note}")));
    }
    notes
}

/// Formats a case as `scene: variant policy`.
fn case_name(scene: &str, case: &CaseKey) -> String {
    format!("{scene}: {} {}", case.variant, case.policy())
}
