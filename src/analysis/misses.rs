//! The misses of each case, added up over workloads, pairs and the bands above grazing.

use crate::record::VerificationRow;
use crate::record::rows::CaseKey;
use std::collections::BTreeMap;

/// Verdicts of one case over a scene, above grazing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Posed pairs that touch by the exact test.
    pub colliding: u64,
    /// Posed pairs that touch by the leaves' triangle test.
    pub brute: u64,
    /// Touching pairs that the case does not report, whoever is to blame.
    pub missed: u64,
    /// Pairs the triangle test finds and the volumes hide.
    pub missed_by_volume: u64,
    /// Pairs the triangle test itself does not find; none in records made since that test is exact.
    pub missed_by_leaf: u64,
}

/// The tallies of a run.
#[derive(Clone, Debug, Default)]
pub struct Misses(BTreeMap<String, BTreeMap<CaseKey, Tally>>);

impl Misses {
    /// Adds up the rows.
    #[must_use]
    pub fn of_rows(rows: &[VerificationRow]) -> Self {
        let mut scenes: BTreeMap<String, BTreeMap<CaseKey, Tally>> = BTreeMap::new();
        for row in rows {
            let tally = scenes.entry(row.scene.clone()).or_default().entry(row.case()).or_default();
            if row.band.is_above_grazing() {
                tally.colliding += row.exact;
                tally.brute += row.brute;
                tally.missed += row.missed;
                tally.missed_by_volume += row.missed_by_volume;
                tally.missed_by_leaf += row.missed_by_leaf;
            }
        }
        Self(scenes)
    }

    /// The tally of a case in a scene; `None` when it was not verified.
    #[must_use]
    pub fn of(&self, scene: &str, case: &CaseKey) -> Option<Tally> {
        self.0.get(scene)?.get(case).copied()
    }

    /// Whether a variant missed a contact anywhere, under any policy.
    #[must_use]
    pub fn any_of(&self, variant: &str) -> bool {
        self.iter().any(|(_, case, tally)| case.variant == variant && tally.missed > 0)
    }

    /// All tallies by scene and case.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &CaseKey, Tally)> {
        self.0.iter().flat_map(|(scene, cases)| cases.iter().map(move |(case, tally)| (scene.as_str(), case, *tally)))
    }
}
