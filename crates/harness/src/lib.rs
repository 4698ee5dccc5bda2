#![doc = include_str!("../README.md")]
//!
//! The modules are listed in reading order; a module imports only from modules above it. The first twelve are modules of bvbench-record and bvbench-scene.

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
#[path = "../../record/src/record/synthetic.rs"]
mod synthetic;
/// The shipped variants and their list, with which the harness is tested, know it by this name.
#[cfg(test)]
extern crate self as bvbench_harness;
