//! The command line over the variants of a registry.

use crate::measure::environment::Build;
use crate::registry::Registry;
use std::process::ExitCode;

pub use bvbench_harness::cli::refuse_output;

/// What this package was built from.
const BUILD: Build = Build {
    root: env!("CARGO_MANIFEST_DIR"),
    fingerprint: env!("BVBENCH_FINGERPRINT"),
    revision: env!("BVBENCH_GIT_REVISION"),
    dirty: env!("BVBENCH_GIT_DIRTY"),
    rustc: env!("BVBENCH_RUSTC"),
    target: env!("BVBENCH_TARGET"),
    opt_level: env!("BVBENCH_OPT_LEVEL"),
    rustflags: env!("BVBENCH_RUSTFLAGS"),
};

/// Runs the command line with the methods of `registry`, so that a volume from another crate is listed, verified, measured, plotted and
/// reported like the ones that are shipped.
pub fn main_with(registry: Registry) -> ExitCode {
    bvbench_harness::cli::main_with(registry, BUILD)
}
