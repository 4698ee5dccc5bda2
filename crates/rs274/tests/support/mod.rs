//! Helpers that the tests of programs share.

#![allow(dead_code, reason = "each test uses its own part")]

use rs274::{Axis, Program, Setup, interpret};
use std::path::Path;

pub fn run(source: &str, setup: &Setup) -> Program {
    interpret(source, Path::new("part.nc"), setup).unwrap_or_else(|error| panic!("{source}: {error}"))
}

/// The error message of a program that must be refused.
pub fn refused(source: &str, setup: &Setup) -> String {
    interpret(source, Path::new("bad.nc"), setup).map(|program| ends(&program)).expect_err(source).to_string()
}

/// X, Y, Z of every end, mm.
pub fn ends(program: &Program) -> Vec<[f64; 3]> {
    program.moves.iter().map(|step| [Axis::X, Axis::Y, Axis::Z].map(|axis| step.end[axis])).collect()
}

pub fn assert_near(found: [f64; 3], expected: [f64; 3], what: &str) {
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{what}: {found:?}, expected {expected:?}");
}

pub fn assert_ends(source: &str, setup: &Setup, expected: &[[f64; 3]]) {
    let found = ends(&run(source, setup));
    assert_eq!(found.len(), expected.len(), "{source}: {found:?}");
    found.iter().zip(expected).for_each(|(found, expected)| assert_near(*found, *expected, source));
}
