//! bvbench: a benchmark of bounding volumes. This package holds the variants, one file each, their list and the program; everything else is
//! in crates that know no variant and are shown here under their modules' names.

pub use bvbench_harness::*;

pub mod volume;
pub mod registry;
pub mod cli;
