//! The variants of bounding volumes, one file each.

pub use bvbench_harness::volume::*;

pub mod aabb;
pub mod aabb_f32;
pub mod aabb_refit;
pub mod aabb_sat6;
pub mod dop_6;
pub mod dop_8;
pub mod dop_8_f32;
pub mod dop_8_vertex;
pub mod dop_14;
pub mod dop_18;
pub mod dop_26;
pub mod obb_area;
pub mod obb_area_centroid;
pub mod obb_area_f32;
pub mod obb_area_symmetric;
pub mod obb_dito14;
pub mod obb_hull_area;
pub mod obb_least;
pub mod obb_min;
pub mod obb_vertex;
pub mod obb_vertex_centroid;
pub mod obb_vertex_f32;
pub mod obb_vertex_symmetric;
pub mod obbrss;
pub mod rss;
pub mod sphere_mean;
pub mod sphere_ritter;
pub mod sphere_ritter_f32;
pub mod sphere_welzl;
