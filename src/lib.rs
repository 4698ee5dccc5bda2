//! bvbench: a benchmark of bounding volumes. The modules are listed in reading order; a module imports only from modules above it. The first
//! twelve know no volume and are crates of their own, so that a change of a volume does not build them again.

pub use bvbench_record::{analysis, plot, record, report};
pub use bvbench_scene::{geometry, interference, machine, picture, scene, stock, truth, workload};
pub mod volume;
pub mod tree;
pub mod space;
pub mod method;
pub mod registry;
pub mod conformance;
pub mod measure;
pub mod certify;
pub mod check;
pub mod view;
pub mod cli;

/// Made-up records for tests, shared with `bvbench-record`.
#[cfg(test)]
#[path = "../crates/record/src/record/synthetic.rs"]
mod synthetic;
