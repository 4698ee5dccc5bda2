//! The list of variants, one per line.

use crate::tree::SplitRule::{AreaMean, Sah16, VertexMean};
use crate::volume;

pub use bvbench_harness::registry::*;

/// The registry of all variants that bvbench ships: the volumes, and the methods that are none.
pub fn standard() -> Registry {
    let volumes = [
        Variant::of::<volume::sphere_ritter::SphereRitter>(VertexMean),
        Variant::of::<volume::aabb::Aabb>(VertexMean),
        Variant::of::<volume::dop_8::Dop8>(VertexMean),
        Variant::of::<volume::obb_vertex::ObbVertex>(VertexMean),
        Variant::of::<volume::obb_area::ObbArea>(AreaMean).reference(),
        Variant::of::<volume::obb_vertex_centroid::ObbVertexCentroid>(VertexMean),
        Variant::of::<volume::obb_area_centroid::ObbAreaCentroid>(AreaMean),
        Variant::of::<volume::obb_vertex_symmetric::ObbVertexSymmetric>(VertexMean),
        Variant::of::<volume::obb_area_symmetric::ObbAreaSymmetric>(AreaMean),
        Variant::of::<volume::obb_hull_area::ObbHullArea>(AreaMean).on_request(),
        Variant::of::<volume::obb_dito14::ObbDito14>(AreaMean).on_request(),
        Variant::of::<volume::obb_min::ObbMin>(AreaMean).on_request(),
        Variant::of::<volume::sphere_mean::SphereMean>(VertexMean).on_request(),
        Variant::of::<volume::sphere_welzl::SphereWelzl>(VertexMean).on_request(),
        Variant::of::<volume::aabb_sat6::AabbSat6>(VertexMean).on_request(),
        Variant::of::<volume::aabb_refit::AabbRefit>(VertexMean).on_request(),
        Variant::of::<volume::dop_6::Dop6>(VertexMean).on_request(),
        Variant::of::<volume::dop_14::Dop14>(VertexMean).on_request(),
        Variant::of::<volume::dop_18::Dop18>(VertexMean).on_request(),
        Variant::of::<volume::dop_26::Dop26>(VertexMean).on_request(),
        Variant::of::<volume::dop_8_vertex::Dop8Vertex>(VertexMean).on_request(),
        Variant::of::<volume::rss::Rss>(AreaMean).on_request(),
        Variant::of::<volume::obbrss::ObbRss>(AreaMean).on_request(),
        Variant::of::<volume::sphere_ritter_f32::SphereRitterF32>(VertexMean).on_request(),
        Variant::of::<volume::aabb_f32::AabbF32>(VertexMean).on_request(),
        Variant::of::<volume::dop_8_f32::Dop8F32>(VertexMean).on_request(),
        Variant::of::<volume::obb_vertex_f32::ObbVertexF32>(VertexMean).on_request(),
        Variant::of::<volume::obb_area_f32::ObbAreaF32>(AreaMean).on_request(),
        Variant::of::<volume::obb_least::ObbLeast>(Sah16).on_request(),
    ];
    Registry::of(volumes.into_iter().chain(Variant::without_volume()))
}
