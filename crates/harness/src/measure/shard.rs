//! Shards: a plan carried out in parts, on several machines, and put together again.
//!
//! A shard is a share of each kind of unit: in a run verdicts of cases, counts of scenes, whole launches; in a study that varies factors the counts and the times
//! of its cells. It works in a folder of its own, keeps its units, and seals them with their hashes when they are all there. [`merge`] gathers the
//! units of all shards in one folder, with the hashes checked. It joins those of a run at once; those of a study are joined by the study's command.
//! Deterministic tables then have the bytes of a run or study without shards.

use super::folder::{self, Folder, difference};
use super::plan::Plan;
use super::run::{MeasureError, Run, stage_folder};
use super::study;
use crate::record::manifest::{PROTOCOL, ShardEntry, Stage};
use crate::record::{FolderLock, Manifest, RecordError};
use crate::registry::Registry;
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use thiserror::Error;

/// Most shards of a plan: beyond any plan's number of units.
const MOST: u32 = 10_000;

/// A share of a plan's units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Its number, from 1.
    pub number: u32,
    /// Shards of the plan.
    pub of: u32,
}

impl Shard {
    /// Whether unit `place` of `places` of a kind is in it. Neighbours are in the same shard as far as possible: they share a scene's truth.
    pub const fn has(self, place: usize, places: usize) -> bool {
        place < places && place * self.of as usize / places == self.number as usize - 1
    }

    /// The manifest of what `whole` plans, or of a shard of it.
    pub fn manifest(shard: Option<Self>, whole: Manifest) -> Manifest {
        let entry = |Self { number, of }| ShardEntry { number, of, plan: whole.plan_hash() };
        Manifest { shard: shard.map(entry), ..whole }
    }
}

impl From<&ShardEntry> for Shard {
    fn from(entry: &ShardEntry) -> Self {
        Self { number: entry.number, of: entry.of }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((number, of)) if 1 <= number && number <= of && of <= MOST => Ok(Self { number, of }),
            _ => Err(format!("`{text}` is no shard: expected I/N with I from 1 to N, and N at most {MOST}")),
        }
    }
}

/// Why shards cannot be merged.
#[derive(Debug, Error)]
pub enum MergeError {
    /// The plan cannot be made here, a folder cannot be read, or the run's folder cannot be written.
    #[error(transparent)]
    Measure(#[from] MeasureError),
    /// No shards are named.
    #[error("no shards are named")]
    None,
    /// A folder holds a whole run.
    #[error("{} holds no shard: its run was made without --shard", .0.display())]
    NotAShard(PathBuf),
    /// Two shards are of different plans.
    #[error("{other} is a shard of another plan than {first}: {difference} differs", first = first.display(), other = other.display())]
    AnotherPlan {
        /// The first shard named.
        first: PathBuf,
        /// The other one.
        other: PathBuf,
        /// What differs.
        difference: &'static str,
    },
    /// A manifest is not that of the plan that its shard began with.
    #[error("the manifest of {} was changed: its plan is not the one that the shard began with; make the shard again with --fresh", .0.display())]
    Edited(PathBuf),
    /// The shards were made by another version.
    #[error("{shard} is of {found}, this is {here}: merge with the program that made the shards", shard = shard.display())]
    AnotherVersion {
        /// The shard.
        shard: PathBuf,
        /// Its version and protocol.
        found: String,
        /// Those of this program.
        here: String,
    },
    /// Two folders hold the same shard.
    #[error("{first} and {other} both hold shard {number}", first = first.display(), other = other.display())]
    Twice {
        /// Number of the shard.
        number: u32,
        /// One of them.
        first: PathBuf,
        /// The other.
        other: PathBuf,
    },
    /// Some shards are not named.
    #[error("of {of} shards these are lacking: {lacking}")]
    Lacking {
        /// Shards of the plan.
        of: u32,
        /// Their numbers.
        lacking: String,
    },
    /// A shard lacks a stage that another one has, or has none, or has units whose hashes its manifest lacks.
    #[error("{} is unfinished: give its command again, with --fresh if its manifest was changed", .0.display())]
    Unfinished(PathBuf),
    /// Launches of two kinds of machine.
    #[error(
        "{first} was timed on {first_cpu}, {other} on {other_cpu}: times of two machines are no one run; merge a run of each and compare them with scripts/across-hosts",
        first = first.display(), other = other.display()
    )]
    AnotherMachine {
        /// A shard.
        first: PathBuf,
        /// Its processor.
        first_cpu: String,
        /// Another shard.
        other: PathBuf,
        /// Its processor.
        other_cpu: String,
    },
}

impl From<RecordError> for MergeError {
    fn from(error: RecordError) -> Self {
        Self::Measure(error.into())
    }
}

/// A shard's folder, which nobody else works in.
struct Part {
    path: PathBuf,
    manifest: Manifest,
    entry: ShardEntry,
    _lock: FolderLock,
}

impl Part {
    fn read(path: &Path) -> Result<Self, MergeError> {
        let manifest = Manifest::read(path)?;
        let entry = manifest.shard.clone().ok_or_else(|| MergeError::NotAShard(path.to_owned()))?;
        let lock = FolderLock::take(path)?;
        manifest.check_rows(path)?;
        Ok(Self { path: path.to_owned(), manifest, entry, _lock: lock })
    }

    /// The manifest of the whole plan, nothing of which is finished.
    fn plan(&self) -> Manifest {
        Manifest { shard: None, finished: Vec::new(), ..self.manifest.clone() }
    }

    fn has_units(&self, kinds: &[&str]) -> bool {
        kinds.iter().any(|kind| folder::units(&self.path, &[kind]).exists())
    }

    fn is_timed(&self) -> bool {
        self.manifest.clock.is_some() || self.has_units(&[study::TIMED])
    }
}

/// Merges shards into the run or study of their plan in `out`; `gzip` compresses a run's raw rows whatever the profile says. `None` for a study: its
/// command joins its tables.
///
/// # Errors
/// When a shard is of another plan, version or protocol, is unfinished, changed, lacking or named twice, when launches were timed on machines of two
/// kinds, when the plan's inputs are not those that are found here, or when `out` cannot be used.
pub fn merge(
    shards: &[PathBuf],
    registry: &Registry,
    out: &Path,
    (fresh, gzip): (bool, bool),
) -> Result<Option<Run>, MergeError> {
    let mut parts = shards.iter().map(|path| Part::read(path)).collect::<Result<Vec<Part>, _>>()?;
    check_plans(&parts)?;
    parts.sort_by_key(|part| part.entry.number);
    check_numbers(&parts)?;
    check_machines(&parts)?;
    if parts.iter().any(|part| part.has_units(&study::KINDS)) {
        return merge_study(&parts, out, fresh).map(|()| None);
    }
    let stages = finished_stages(&parts)?;
    check_sealed(&parts, &stages.iter().map(|&stage| stage_folder(stage)).collect::<Vec<_>>())?;
    // The first launch is in the first shard.
    let mut whole = parts[0].plan();
    if parts.iter().any(|part| part.manifest.program.hash != whole.program.hash) {
        whole.program.hash.clear();
    }
    let mut plan = Plan::of_request(whole.request.clone(), registry).map_err(MeasureError::from)?;
    plan.gzip |= gzip;
    // Shards may be of builds of other hosts, and so may what merges them.
    let mut here = Manifest { binaries: whole.binaries.clone(), ..plan.manifest() };
    here.program.hash.clone_from(&whole.program.hash);
    if let Some(difference) = difference(&whole, &here) {
        return Err(MeasureError::AnotherRun { folder: parts[0].path.clone(), difference }.into());
    }
    let mut run = Run::open_for(plan, whole, out, fresh)?;
    for &stage in &stages {
        run.clear(stage)?;
        for part in &parts {
            run.take_units(&part.path, stage)?;
        }
        run.end(stage)?;
    }
    Ok(Some(run))
}

/// Gathers the units of a study's shards.
fn merge_study(parts: &[Part], out: &Path, fresh: bool) -> Result<(), MergeError> {
    check_sealed(parts, &study::KINDS)?;
    let mut whole = Manifest { rows: BTreeMap::new(), ..parts[0].plan() };
    // The study's command may be of the build of another host.
    whole.program.hash.clear();
    let mut folder = Folder::open(out, whole.clone(), fresh)?;
    folder.manifest = whole;
    for kind in study::KINDS {
        folder.drop_units(&[kind])?;
        parts.iter().try_for_each(|part| folder.take_units(&part.path, &[kind]))?;
    }
    Ok(folder.save()?)
}

/// All are of one plan, and of this program's version.
fn check_plans(parts: &[Part]) -> Result<(), MergeError> {
    let first = parts.first().ok_or(MergeError::None)?;
    for part in parts {
        if (&part.entry.plan, part.entry.of) != (&first.entry.plan, first.entry.of) {
            let difference = difference(&first.plan(), &part.plan()).unwrap_or("the number of shards");
            return Err(MergeError::AnotherPlan { first: first.path.clone(), other: part.path.clone(), difference });
        }
        let named = |version: &str, protocol: &str| format!("version {version}, protocol {protocol}");
        let found = named(&part.manifest.program.version, &part.manifest.protocol);
        let here = named(&super::environment::program().version, PROTOCOL);
        if found != here {
            return Err(MergeError::AnotherVersion { shard: part.path.clone(), found, here });
        }
        // What was edited since the shard began does not go by the hash that was noted then.
        if part.plan().plan_hash() != part.entry.plan {
            return Err(MergeError::Edited(part.path.clone()));
        }
    }
    Ok(())
}

/// Every number is there once; the parts are in their order.
fn check_numbers(parts: &[Part]) -> Result<(), MergeError> {
    if let Some([first, other]) = parts.windows(2).find(|two| two[0].entry.number == two[1].entry.number) {
        let (first, other, number) = (first.path.clone(), other.path.clone(), other.entry.number);
        return Err(MergeError::Twice { number, first, other });
    }
    let of = parts[0].entry.of;
    let is_there = |number: &u32| parts.iter().any(|part| part.entry.number == *number);
    let lacking: Vec<String> = (1..=of).filter(|n| !is_there(n)).map(|n| n.to_string()).collect();
    if lacking.is_empty() { Ok(()) } else { Err(MergeError::Lacking { of, lacking: lacking.join(", ") }) }
}

/// The stages that all have finished; there is one at least, and none that only some have finished.
fn finished_stages(parts: &[Part]) -> Result<Vec<Stage>, MergeError> {
    let of = |part: &Part| {
        [Stage::Verify, Stage::Measure].into_iter().filter(|stage| part.manifest.finished.contains(stage)).collect()
    };
    let most: Vec<Stage> = parts.iter().map(of).max_by_key(Vec::len).unwrap_or_default();
    match parts.iter().find(|part| most.is_empty() || of(part) != most) {
        Some(part) => Err(MergeError::Unfinished(part.path.clone())),
        None => Ok(most),
    }
}

/// All units of these kinds are sealed: a shard does so when it has them all. One of many shards may have none.
fn check_sealed(parts: &[Part], kinds: &[&str]) -> Result<(), MergeError> {
    for part in parts {
        for kind in kinds {
            if !part.manifest.is_sealed_below(&part.path, &folder::units(&part.path, &[kind]))? {
                return Err(MergeError::Unfinished(part.path.clone()));
            }
        }
    }
    Ok(())
}

/// All launches were timed on machines of one kind.
fn check_machines(parts: &[Part]) -> Result<(), MergeError> {
    let timed: Vec<&Part> = parts.iter().filter(|part| part.is_timed()).collect();
    let Some(first) = timed.first() else { return Ok(()) };
    match timed.iter().find(|part| !part.manifest.machine.is_alike(&first.manifest.machine)) {
        Some(other) => Err(MergeError::AnotherMachine {
            first: first.path.clone(),
            first_cpu: first.manifest.machine.cpu.clone(),
            other: other.path.clone(),
            other_cpu: other.manifest.machine.cpu.clone(),
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_is_in_one_shard_and_neighbours_stay_together() {
        for (places, of) in [(0, 3), (1, 7), (3, 7), (7, 7), (40, 7), (41, 1)] {
            let shards: Vec<Shard> = (1..=of).map(|number| Shard { number, of }).collect();
            let owner = |place| shards.iter().filter(move |shard| shard.has(place, places)).map(|shard| shard.number);
            let owners: Vec<u32> = (0..places).flat_map(owner).collect();
            assert_eq!(owners.len(), places, "{places} units in {of} shards");
            assert!(owners.is_sorted(), "{owners:?}");
            let sizes = (1..=of).map(|number| owners.iter().filter(|&&owner| owner == number).count());
            let (least, most) = (sizes.clone().min().unwrap(), sizes.max().unwrap());
            assert!(most - least <= 1, "{owners:?}");
        }
        assert!(Shard { number: 1, of: 7 }.has(0, 1), "the first launch is in the first shard");
    }

    #[test]
    fn a_shard_is_written_as_two_numbers() {
        assert_eq!("3/7".parse(), Ok(Shard { number: 3, of: 7 }));
        for text in ["0/7", "8/7", "3", "/", "3/7/1", "-1/7", "1/0", "1/10001"] {
            assert!(text.parse::<Shard>().unwrap_err().contains(text), "{text}");
        }
    }
}
