#![doc = include_str!("../README.md")]

pub mod record;
pub mod analysis;
pub mod plot;
pub mod report;
