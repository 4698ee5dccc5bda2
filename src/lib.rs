//! bvbench: a benchmark of bounding volumes. The modules are listed in reading order; a module imports only from modules above it.

pub mod record;
pub mod analysis;
pub mod plot;
pub mod report;
pub mod geometry;
pub mod volume;
pub mod tree;
pub mod space;
pub mod truth;
pub mod machine;
pub mod scene;
pub mod picture;
pub mod workload;
pub mod interference;
pub mod stock;
pub mod method;
pub mod registry;
pub mod conformance;
pub mod measure;
pub mod certify;
pub mod check;
pub mod view;
pub mod cli;
