//! Missed contacts of each case, by line: those of the case's own queries, and those after answers by witness are added.

use super::stats::{clustered_rate, equal_lines};
use crate::record::rows::CaseKey;
use crate::record::{CaseRow, Kind, LineRow, MissRow, RecordError, VerificationRow, read_rows};
use std::collections::BTreeMap;
use std::path::Path;

/// The contacts above grazing of one case, and how many of them it missed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// (missed, contacts) of each line on which the case's own query was run.
    pub lines: Vec<(u64, u64)>,
    /// All contacts, whether the verdict came from the query or from the witness.
    pub contacts_in_all: u64,
    /// How many of all contacts were missed.
    pub missed_in_all: u64,
}

impl Tally {
    /// Contacts at which the case's own query was run.
    pub fn contacts(&self) -> u64 {
        self.lines.iter().map(|(_, contacts)| contacts).sum()
    }

    /// Number of those contacts that the case's own query missed.
    pub fn missed(&self) -> u64 {
        self.lines.iter().map(|(missed, _)| missed).sum()
    }

    /// The 95 % interval of the miss rate, with lines as clusters.
    pub fn interval(&self) -> (f64, f64) {
        clustered_rate(&self.lines)
    }

    /// The number of equal lines that bound the rate as well as the lines do.
    pub fn equal_lines(&self) -> f64 {
        equal_lines(&self.lines)
    }
}

/// Case, scene, workload, pair, line.
type LineOfCase = (String, String, String, String, u32);

/// The tally of a workload without a contact.
static NO_CONTACT: Tally = Tally { lines: Vec::new(), contacts_in_all: 0, missed_in_all: 0 };

/// The tallies of a run.
#[derive(Clone, Debug, Default)]
pub struct Misses {
    /// By scene and case, then by workload with contacts.
    tallies: BTreeMap<(String, CaseKey), BTreeMap<String, Tally>>,
    /// Poses at which a case was verified, by scene, case and workload.
    poses: BTreeMap<(String, CaseKey, String), u64>,
}

impl Misses {
    /// Reads and adds up `lines.csv` and `misses.csv`; `verification.csv` says at how many poses each case was verified.
    ///
    /// # Errors
    /// When a file is missing or malformed.
    pub fn read(folder: &Path) -> Result<Self, RecordError> {
        let mut missed: BTreeMap<LineOfCase, (u64, u64)> = BTreeMap::new();
        for row in read_rows::<MissRow>(folder)? {
            missed.insert((row.case, row.scene, row.workload, row.pair, row.line), (row.missed, row.missed_asked));
        }
        let mut lines = read_rows::<LineRow>(folder)?;
        // Sums of rounded numbers depend on the order.
        lines.sort_by(|a, b| (&a.scene, &a.workload, &a.pair, a.line).cmp(&(&b.scene, &b.workload, &b.pair, b.line)));
        let mut misses = Self::default();
        let verified = |case: &CaseRow| case.kind != Kind::Control && case.duplicate_of.is_empty();
        for case in read_rows::<CaseRow>(folder)?.iter().filter(|case| verified(case)) {
            let everywhere = case.asked_everywhere == 1;
            for line in &lines {
                let key = (case.case.clone(), line.scene.clone(), line.workload.clone(), line.pair.clone(), line.line);
                let (all, asked) = missed.get(&key).copied().unwrap_or_default();
                let workloads = misses.tallies.entry((line.scene.clone(), case.case())).or_default();
                let tally = workloads.entry(line.workload.clone()).or_default();
                let contacts = if everywhere { line.contacts } else { line.sampled };
                if contacts > 0 {
                    tally.lines.push((asked, contacts));
                }
                tally.contacts_in_all += if case.kind.is_ours() { line.contacts } else { line.sampled };
                tally.missed_in_all += all;
            }
        }
        for row in read_rows::<VerificationRow>(folder)? {
            let case = row.case();
            *misses.poses.entry((row.scene, case, row.workload)).or_default() += row.poses;
        }
        Ok(misses)
    }

    /// The tallies of a case in a scene by workload; `None` when the case was not verified. Rates are never summed over workloads, because
    /// the lines of two workloads hold contacts of different numbers.
    pub fn of(&self, scene: &str, case: &CaseKey) -> Option<&BTreeMap<String, Tally>> {
        self.tallies.get(&(scene.to_owned(), case.clone()))
    }

    /// How many contacts of all workloads of a scene the case's own query missed; `None` when the case was not verified.
    pub fn missed(&self, scene: &str, case: &CaseKey) -> Option<u64> {
        Some(self.of(scene, case)?.values().map(Tally::missed).sum())
    }

    /// The tally of a case in a workload of a scene; empty when the case was not verified there.
    pub fn in_workload(&self, scene: &str, case: &CaseKey, workload: &str) -> Tally {
        self.of(scene, case).and_then(|workloads| workloads.get(workload)).cloned().unwrap_or_default()
    }

    /// Whether a variant missed a contact anywhere, under any policy.
    pub fn any_of(&self, variant: &str) -> bool {
        self.iter().any(|(_, case, _, tally)| case.variant == variant && tally.missed_in_all > 0)
    }

    /// All tallies with contacts: scene, case, workload, tally.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &CaseKey, &str, &Tally)> {
        self.tallies.iter().flat_map(|((scene, case), workloads)| {
            workloads.iter().map(move |(workload, tally)| (scene.as_str(), case, workload.as_str(), tally))
        })
    }

    /// Like [`Self::iter`], and the empty tallies of what was verified without a contact.
    pub fn verified(&self) -> impl Iterator<Item = (&str, &CaseKey, &str, &Tally)> {
        let without = self
            .poses
            .keys()
            .filter(move |(scene, case, workload)| self.of(scene, case).is_none_or(|of| !of.contains_key(workload)));
        self.iter().chain(without.map(|(scene, case, workload)| (scene.as_str(), case, workload.as_str(), &NO_CONTACT)))
    }

    /// Poses that were verified, by scene and workload.
    pub fn poses(&self) -> BTreeMap<(&str, &str), u64> {
        let mut most = BTreeMap::new();
        for ((scene, _, workload), &poses) in &self.poses {
            let known: &mut u64 = most.entry((scene.as_str(), workload.as_str())).or_default();
            *known = (*known).max(poses);
        }
        most
    }
}
