//! Prints the canonical moves of a program: `cargo run --package rs274 --example moves PROGRAM`.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example prints")]

use rs274::canonical::render;
use rs274::{Setup, interpret};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(file) = std::env::args().nth(1) else {
        eprintln!("usage: moves PROGRAM");
        return ExitCode::from(2);
    };
    let moves = std::fs::read_to_string(&file)
        .map_err(|error| format!("{file}: {error}"))
        .and_then(|text| interpret(&text, Path::new(&file), &Setup::default()).map_err(|error| error.to_string()));
    match moves {
        Ok(program) => {
            print!("{}", render(&program.moves));
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
