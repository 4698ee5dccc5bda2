//! The command line over the variants that bvbench ships.

use std::process::ExitCode;

fn main() -> ExitCode {
    bvbench::cli::main_with(bvbench::registry::standard())
}
