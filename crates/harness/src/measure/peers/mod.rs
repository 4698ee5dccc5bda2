//! Whole collision engines side by side, each in a process of its own, called a runner.
//!
//! The protocol between the driver ([`drive`]) and a runner, whatever language it is written in:
//!
//! - `RUNNER ARGUMENTS... MODE PAIR OUT ROUNDS` starts it. `PAIR` is a folder of arrays ([`posed`]), `OUT` the folder for its
//!   answers, `ROUNDS` how often at most each pose is asked about.
//! - It loads the arrays, puts the poses into its own form, and says `ready`; or `unsupported` when it has no such mode.
//! - `build`: it builds its structures over both meshes from the triangles in memory, in the place of earlier ones, and says
//!   `done NS`, the time of that in ns.
//! - `bytes`: it says `done N`, what the structures hold in memory, triangles included; 0 when it does not know.
//! - `chunk I J`: it answers the poses I, I+1, ..., J-1 again and again: once to warm up; then timed as a whole, repeated until
//!   the sample is long enough; then pose by pose, each timed alone. It says `done NS`, the time of one pass over the chunk.
//!   Where one pass pose by pose takes longer than [`drive::LONG_CHUNK_NS`], that pass is enough.
//!   In mode `batch` a pass is answered on all cores, and the times pose by pose are its time divided by the poses.
//! - `quit`: it writes `verdicts.npy` (u1), `ns.npy` (u8; a row per round, 0 where it was not asked) and, in modes `all`,
//!   `distance` and `motion`, `values.npy` (f8: touching pairs of triangles; mm; time of first contact, infinite without) to `OUT`, says `done 0`
//!   and ends.
//!
//! Anything else it says is taken for an error. It uses one thread, but in mode `batch`. Since the driver waits for each answer, no two runners
//! work at the same time; since within a round all answer a chunk before the next one comes, noise hits all alike.
//!
//! Files: [`npy`] (arrays), [`posed`] and [`motions`] (what is asked), [`answer`] (our own variants as runners), [`engine`] (engines as data), [`drive`],
//! [`verify`] (right answers before any timing).

pub mod answer;
pub mod drive;
pub mod engine;
pub mod motions;
pub mod npy;
pub mod posed;
pub mod verify;

use super::MeasureError;
use crate::geometry::MeshError;
use crate::record::RecordError;
use npy::NpyError;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use thiserror::Error;

/// What is asked of an engine at each pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Whether the meshes touch.
    First,
    /// The same along fine steps of a path, in order: what a pose leaves behind may help the next one.
    Path(Step),
    /// How many pairs of triangles touch.
    All,
    /// How far the meshes are apart, mm.
    Distance,
    /// Whether the meshes touch, at many poses at once, on all cores.
    Batch,
    /// When the meshes touch first on a motion from one pose to another, from 0 to 1.
    Motion,
}

/// The longest step of a path: no point of the moved mesh goes farther from pose to pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    um: u32,
}

impl Step {
    /// A servo cycle of 1 ms at a feed of 1.2 m/min: 0.02 mm.
    pub const SERVO: Self = Self { um: 20 };

    /// From mm, to the nearest µm; from 1 µm to 10 mm.
    fn of_mm(mm: f64) -> Option<Self> {
        let um = (mm * 1000.0).round();
        (1.0..=10_000.0).contains(&um).then_some(Self { um: um as u32 })
    }

    /// In mm.
    pub fn mm(self) -> f64 {
        f64::from(self.um) / 1000.0
    }
}

impl Mode {
    /// All modes, paths in steps of a servo cycle.
    pub const ALL: [Self; 6] =
        [Self::First, Self::Path(Step::SERVO), Self::All, Self::Distance, Self::Batch, Self::Motion];

    /// The name in the protocol. In files paths of other steps than a servo cycle's have them in their name.
    pub const fn id(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::Path(_) => "path",
            Self::All => "all",
            Self::Distance => "distance",
            Self::Batch => "batch",
            Self::Motion => "motion",
        }
    }

    /// Whether the answer is a number, and not only a verdict.
    pub const fn has_values(self) -> bool {
        matches!(self, Self::All | Self::Distance | Self::Motion)
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Path(step) if *step != Step::SERVO => f.pad(&format!("path-{}", step.mm())),
            _ => f.pad(self.id()),
        }
    }
}

impl FromStr for Mode {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let step = text.strip_prefix("path-").and_then(|mm| Step::of_mm(mm.parse().ok()?));
        let found = step.map(Self::Path).or_else(|| Self::ALL.into_iter().find(|mode| mode.id() == text));
        found.ok_or_else(|| {
            format!(
                "`{text}` is not a mode: expected first, path, path-STEP (mm from 0.001 to 10, as in path-0.05), all, distance, batch or motion"
            )
        })
    }
}

/// Why engines cannot be compared.
#[derive(Debug, Error)]
pub enum PeersError {
    /// The poses cannot be made or judged.
    #[error(transparent)]
    Measure(#[from] MeasureError),
    /// A file cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// An array is not what it should be.
    #[error(transparent)]
    Npy(#[from] NpyError),
    /// A file holds no mesh.
    #[error("{folder}: mesh {side}: {cause}", folder = folder.display())]
    Mesh {
        /// The folder of the pair.
        folder: PathBuf,
        /// `a` or `b`.
        side: char,
        /// Why.
        cause: MeshError,
    },
    /// The arrays of a folder do not fit together.
    #[error("{folder}: {message}", folder = folder.display())]
    Pair {
        /// The folder of the pair.
        folder: PathBuf,
        /// What does not fit.
        message: String,
    },
    /// The scene has no poses for the mode.
    #[error("scene `{scene}` has no poses for mode {mode}: it needs a program whose parts come near each other")]
    NoPoses {
        /// The scene.
        scene: String,
        /// The mode.
        mode: Mode,
    },
    /// A file does not name engines.
    #[error("{path}: {message}", path = path.display())]
    Engines {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// The driver asked a runner of ours for something it does not know.
    #[error("`{line}` is not a command: expected build, bytes, chunk I J or quit")]
    Command {
        /// What was asked.
        line: String,
    },
    /// The other end of the protocol has gone away.
    #[error("the other end has gone away: {0}")]
    Gone(std::io::Error),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_are_known_by_name_and_paths_by_their_step() {
        for mode in Mode::ALL {
            assert_eq!(mode.to_string().parse(), Ok(mode));
        }
        let fine: Mode = "path-0.05".parse().unwrap();
        assert_eq!((fine.to_string().as_str(), fine.id(), fine), ("path-0.05", "path", Mode::Path(Step { um: 50 })));
        assert_eq!("path-0.02".parse(), Ok(Mode::Path(Step::SERVO)));
        for wrong in ["path-", "path-0", "path--1", "path-11", "path-nan", "paths", "path-0.0001"] {
            assert!(wrong.parse::<Mode>().unwrap_err().contains(wrong), "{wrong}");
        }
    }
}
