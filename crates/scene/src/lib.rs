#![doc = include_str!("../README.md")]

pub mod geometry;
pub mod truth;
pub mod machine;
pub mod scene;
pub mod picture;
pub mod workload;
pub mod interference;
pub mod stock;
