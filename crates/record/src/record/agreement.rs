//! Rows of posed pairs by the million: exact engines asked about all of them, and their answers compared.

use super::rows::{Row, row_file};
use super::vocabulary::Band;
use serde::{Deserialize, Serialize};

row_file! {
    AgreementRow => "agreement.csv",
    DisagreementRow => "disagreements.csv",
    RoundRow => "rounds.csv",
}

/// The answers of one case to the poses of one band of a workload and pair, summed over rounds. Deterministic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AgreementRow {
    /// Scene name.
    pub scene: String,
    /// Workload name.
    pub workload: String,
    /// The pair, `a:b`.
    pub pair: String,
    /// Case, `variant@policy`.
    pub case: String,
    /// Depth band; of a contact along a path, whose depth nobody computes here, the deepest.
    pub band: Band,
    /// Lines (rays, approaches, stretches of a path) that have such a pose, summed over rounds.
    pub lines: u64,
    /// Poses.
    pub poses: u64,
    /// Poses at which some engine reported a contact, or the exact truth has one.
    pub contacts: u64,
    /// How many of these the case did not report.
    pub missed: u64,
    /// Poses that the exact truth was asked about, too.
    pub exhaustive: u64,
    /// Contacts that the case reported at those and that are none.
    pub false_positives: u64,
}

impl AgreementRow {
    /// What identifies a row.
    pub fn key(&self) -> (&str, &str, &str, &str, Band) {
        (&self.scene, &self.workload, &self.pair, &self.case, self.band)
    }

    /// Adds the counts of another row with the same key.
    pub const fn add(&mut self, other: &Self) {
        self.lines += other.lines;
        self.poses += other.poses;
        self.contacts += other.contacts;
        self.missed += other.missed;
        self.exhaustive += other.exhaustive;
        self.false_positives += other.false_positives;
    }
}

/// One case's answer at a pose at which it is wrong. Deterministic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DisagreementRow {
    /// Seed of the round.
    pub seed: u64,
    /// Scene name.
    pub scene: String,
    /// Workload name.
    pub workload: String,
    /// The pair, `a:b`.
    pub pair: String,
    /// Line within workload and pair.
    pub line: u32,
    /// Depth band.
    pub band: Band,
    /// Case, `variant@policy`.
    pub case: String,
    /// Its verdict, 0 or 1.
    pub verdict: u8,
    /// What says otherwise: `exact`, the exact truth, or `engines`, a contact that another engine found.
    pub against: String,
    /// The bits of the pose, `a` from `b`: quaternion i, j, k, w and translation x, y, z in mm, each 16 hexadecimal digits.
    pub pose: String,
}

/// One round: the posed pairs of one seed. Noisy by its seconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoundRow {
    /// The seed.
    pub seed: u64,
    /// Posed pairs.
    pub poses: u64,
    /// Verdicts of engines.
    pub verdicts: u64,
    /// Posed pairs that touch.
    pub contacts: u64,
    /// Posed pairs that the exact truth was asked about.
    pub exhaustive: u64,
    /// Wrong verdicts.
    pub disagreements: u64,
    /// Duration, poses and truth included, s.
    pub seconds: f64,
}
