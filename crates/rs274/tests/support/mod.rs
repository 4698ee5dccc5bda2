//! Helpers that the tests of programs share.

#![allow(dead_code, reason = "each test uses its own part")]

use rs274::{Axis, Dialect, Program, Setup, Tool, Units, interpret};
use std::path::Path;

pub fn linuxcnc() -> Setup {
    let tools = [(1, Tool::with_length(50.0, 6.0)), (2, Tool::with_length(30.0, 10.0))].into();
    Setup { tools, units: Some(Units::Mm), ..Setup::default() }
}

pub fn fanuc() -> Setup {
    Setup { dialect: Dialect::Fanuc, ..linuxcnc() }
}

pub fn haas() -> Setup {
    Setup { dialect: Dialect::Haas, ..linuxcnc() }
}

pub fn run(source: &str, setup: &Setup) -> Program {
    interpret(source, Path::new("part.nc"), setup).unwrap_or_else(|error| panic!("{source}: {error}"))
}

/// The error message of a program that must be refused.
pub fn refused(source: &str, setup: &Setup) -> String {
    interpret(source, Path::new("bad.nc"), setup).map(|program| ends(&program)).expect_err(source).to_string()
}

pub fn assert_refused(source: &str, setup: &Setup, place: &str, text: &str) {
    let told = refused(source, setup);
    assert!(told.starts_with(&format!("bad.nc:{place}: ")) && told.contains(text), "{source}: {told}");
}

/// Points from a text: coordinates between spaces, points between commas.
pub fn points(text: &str) -> Vec<[f64; 3]> {
    let point = |point: &str| {
        let coordinates: Vec<f64> = point.split_whitespace().map(|x| x.parse().expect(text)).collect();
        coordinates.try_into().expect("three coordinates")
    };
    text.split(',').map(point).collect()
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
