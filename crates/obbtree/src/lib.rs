#![doc = include_str!("../README.md")]

#[cfg(any(test, feature = "cases"))]
pub mod cases;
pub mod engine;
