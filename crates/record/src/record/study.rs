//! Rows of studies that vary factors: which level of which factor a case or a scene has, and counts summed over chunks.
//!
//! A study crosses cases with the chunks of its scenes. Where a row for each pose ([`AnswerRow`](super::AnswerRow)) would be too many, the
//! answers of a chunk are summed up in a [`CountRow`].

use super::rows::{Row, row_file};
use super::vocabulary::Stratum;
use serde::{Deserialize, Serialize};

row_file! { FILES:
    FactorRow => "factors.csv",
    CountRow => "counts.csv",
}

/// The level of one factor, of a case (in all scenes), of a scene (for all cases), or of a case in a scene. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FactorRow {
    /// Scene name; empty for a factor of the case alone.
    pub scene: String,
    /// Case, by its name in `cases.csv`; empty for a factor of the scene alone.
    pub case: String,
    /// Name of the factor; a unit stands at its end.
    pub factor: String,
    /// The level: a name, or a number.
    pub level: String,
}

/// The answers of one case to one chunk of poses, summed. Deterministic.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CountRow {
    /// Scene name.
    pub scene: String,
    /// Case, by its name in `cases.csv`.
    pub case: String,
    /// Chunk within the scene; the same poses for every case.
    pub chunk: u32,
    /// Stratum of all its poses; empty where they are of several.
    pub stratum: Option<Stratum>,
    /// The verdict of the case at all poses of the row, 0 or 1, where these are counted apart; else empty.
    pub verdict: Option<u8>,
    /// Poses, or runs along a path.
    pub poses: u64,
    /// Queries: one for each pose, or one for each sample of a path.
    pub queries: u64,
    /// Volume overlap tests over all queries, mode `first`; of the octree method the tests of its first level.
    pub volume_tests: u64,
    /// Triangle tests over all queries; of the octree method the points compared with a profile.
    pub triangle_tests: u64,
    /// Tests of the second level of the octree method; 0 for all others.
    pub second_level_tests: u64,
    /// Queries that coherence answered; 0 where nothing is kept from pose to pose.
    pub recalled: u64,
    /// Poses that touch, exactly; runs with a contact.
    pub touching: u64,
    /// How many of them the case does not report.
    pub missed: u64,
    /// Sum over runs of the travel from first contact to the first sample that reports it, mm; 0 for single poses.
    pub delay_mm: f64,
}

impl FactorRow {
    /// A factor of a case, the same in all scenes.
    pub fn of_case(case: &str, factor: &str, level: String) -> Self {
        Self { scene: String::new(), case: case.to_owned(), factor: factor.to_owned(), level }
    }

    /// A factor of a scene, the same for all cases.
    pub fn of_scene(scene: &str, factor: &str, level: String) -> Self {
        Self { scene: scene.to_owned(), ..Self::of_case("", factor, level) }
    }
}

impl CountRow {
    /// A row in which nothing is counted yet.
    pub fn new(scene: &str, case: &str, chunk: u32, stratum: Option<Stratum>) -> Self {
        Self { scene: scene.to_owned(), case: case.to_owned(), chunk, stratum, ..Self::default() }
    }

    /// Adds the counts of another row.
    pub fn add(&mut self, other: &Self) {
        self.poses += other.poses;
        self.queries += other.queries;
        self.volume_tests += other.volume_tests;
        self.triangle_tests += other.triangle_tests;
        self.second_level_tests += other.second_level_tests;
        self.recalled += other.recalled;
        self.touching += other.touching;
        self.missed += other.missed;
        self.delay_mm += other.delay_mm;
    }
}
