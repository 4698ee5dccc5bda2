//! How much is measured.

use crate::record::vocabulary::named;
use std::fmt;
use std::str::FromStr;

named! {
    /// A named amount of work.
    pub enum Profile {
        /// Half a minute: for continuous integration and for trying a new volume.
        Smoke = "smoke",
        /// Five minutes: for a reader, who gets a preview.
        Quick = "quick",
        /// Some three hours over five binaries: for publication.
        Full = "full",
    }
}

/// What a profile amounts to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// Posed pairs per scene whose verdicts are verified; a program is sampled to within 2 % of its share, so a little more
    /// than the round number that is promised.
    pub verify_poses: usize,
    /// Poses per pair and workload, evenly spread, at which a verification asks the queries of safe volumes too ([`super::accuracy`]); all others
    /// are asked everywhere.
    pub asked_poses: usize,
    /// Posed pairs per scene that are counted and timed.
    pub measure_poses: usize,
    /// Steps that each program is sampled in, about, when it is timed as a whole.
    pub program_steps: usize,
    /// Most readings of a whole program in a block. Programs are few and take some milliseconds: of one reading in each of 20 blocks the null
    /// duplicate was up to 2.4 % from its original.
    pub program_readings: u32,
    /// Timed blocks per launch, after the warm-up block.
    pub blocks: u32,
    /// Process launches, of all binaries together.
    pub launches: u32,
    /// Binaries that take turns, launch by launch.
    pub binaries: u32,
    /// Poses of each program, evenly spread, that are asked with cold caches.
    pub cold_poses: usize,
    /// Timed constructions of every tree, over all launches.
    pub build_blocks: u32,
    /// Random frames of each part, beside its own, in which the tightness of the trees is measured.
    pub frames: u32,
    /// Random triangle pairs on which the triangle tests are compared with their integer twin.
    pub cross_check_pairs: u64,
}

impl Budget {
    /// The same amounts over so many binaries: each has the launches that the profile gives to one, and every launch times a construction.
    pub const fn over(self, binaries: u32) -> Self {
        let launches = self.launches * binaries;
        let build_blocks = if binaries > 1 && launches > self.build_blocks { launches } else { self.build_blocks };
        Self { launches, binaries, build_blocks, ..self }
    }
}

impl Profile {
    /// Its amounts.
    pub const fn budget(self) -> Budget {
        match self {
            Self::Smoke => Budget {
                verify_poses: 2_000,
                asked_poses: 1_000,
                measure_poses: 512,
                program_steps: 64,
                program_readings: 5,
                blocks: 3,
                launches: 1,
                binaries: 1,
                cold_poses: 4,
                build_blocks: 1,
                frames: 1,
                cross_check_pairs: 20_000,
            },
            Self::Quick => Budget {
                verify_poses: 102_000,
                asked_poses: 250,
                measure_poses: 576,
                program_steps: 400,
                program_readings: 5,
                blocks: 3,
                launches: 3,
                binaries: 1,
                cold_poses: 4,
                build_blocks: 4,
                frames: 4,
                cross_check_pairs: 1_000_000,
            },
            Self::Full => Budget {
                verify_poses: 1_000_000,
                asked_poses: 40_000,
                measure_poses: 2_048,
                program_steps: 2_048,
                program_readings: 15,
                blocks: 8,
                launches: 4,
                binaries: 1,
                cold_poses: 64,
                build_blocks: 8,
                frames: 8,
                cross_check_pairs: 10_000_000,
            },
        }
    }
}

impl fmt::Display for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.id())
    }
}

impl FromStr for Profile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|profile| profile.id() == text);
        found.ok_or_else(|| format!("`{text}` is not a profile: expected smoke, quick or full"))
    }
}
