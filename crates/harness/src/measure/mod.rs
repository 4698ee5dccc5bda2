//! Measuring: verdicts against the truth, operation counts, tightness, and times. The only module that reads a clock.
//!
//! Reading order: [`profile`] (how much), [`plan`] (what), [`judged`] (poses with their truth), [`accuracy`],
//! [`counts`], [`exits`], [`shape`], then the timed part: [`timer`], [`chunk`], `measured`, [`query`], [`single`], [`build`]; [`binaries`] says with
//! what, [`environment`] where;
//! [`folder`] holds what a study has so far and resumes it; [`shard`] takes a part of a plan and merges parts. [`run`] is the reference study; [`study`] is the engine of those that vary factors:
//! [`audit`], [`sweep`] and [`ablation`]. [`peers`] compares whole engines, each in its own process; [`agreement`] asks exact engines about posed pairs by the million.

pub mod ablation;
pub mod accuracy;
pub mod agreement;
pub mod audit;
pub mod binaries;
mod blocks;
pub mod build;
pub mod chunk;
pub mod counts;
pub mod environment;
pub mod exits;
pub mod folder;
pub mod judged;
mod measured;
pub mod peers;
pub mod plan;
pub mod profile;
pub mod query;
pub mod run;
pub mod shape;
pub mod shard;
pub mod single;
mod sources;
pub mod study;
pub mod sweep;
pub mod timer;

pub use binaries::{Binary, BinaryError};
pub use plan::{Case, Plan, PlanError, Selection};
pub use profile::{Budget, Profile};
pub use run::{MeasureError, Run, Verification};

/// Where a long task says how far it is. Called from several threads.
pub trait Progress: Sync {
    /// A new stretch of work of `total` steps begins; it replaces the one before.
    fn begin(&self, what: &str, total: u64);
    /// Some steps are done.
    fn advance(&self, steps: u64);
}

/// Says nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: &str, _: u64) {}
    fn advance(&self, _: u64) {}
}
