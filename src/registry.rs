//! The list of variants, one per line.

use crate::tree::SplitRule::{AreaMean, Sah16, VertexMean};
use crate::volume::aabb::Aabb;
use crate::volume::aabb_f32::AabbF32;
use crate::volume::aabb_refit::AabbRefit;
use crate::volume::aabb_sat6::AabbSat6;
use crate::volume::dop_6::Dop6;
use crate::volume::dop_8::Dop8;
use crate::volume::dop_8_f32::Dop8F32;
use crate::volume::dop_8_vertex::Dop8Vertex;
use crate::volume::dop_14::Dop14;
use crate::volume::dop_18::Dop18;
use crate::volume::dop_26::Dop26;
use crate::volume::obb_area::ObbArea;
use crate::volume::obb_area_centroid::ObbAreaCentroid;
use crate::volume::obb_area_f32::ObbAreaF32;
use crate::volume::obb_area_symmetric::ObbAreaSymmetric;
use crate::volume::obb_dito14::ObbDito14;
use crate::volume::obb_hull_area::ObbHullArea;
use crate::volume::obb_least::ObbLeast;
use crate::volume::obb_min::ObbMin;
use crate::volume::obb_vertex::ObbVertex;
use crate::volume::obb_vertex_centroid::ObbVertexCentroid;
use crate::volume::obb_vertex_f32::ObbVertexF32;
use crate::volume::obb_vertex_symmetric::ObbVertexSymmetric;
use crate::volume::obbrss::ObbRss;
use crate::volume::rss::Rss;
use crate::volume::sphere_mean::SphereMean;
use crate::volume::sphere_ritter::SphereRitter;
use crate::volume::sphere_ritter_f32::SphereRitterF32;
use crate::volume::sphere_welzl::SphereWelzl;

pub use bvbench_harness::registry::*;

/// The registry of all variants that bvbench ships: the volumes, and the methods that are none.
pub fn standard() -> Registry {
    let volumes = [
        Variant::of::<SphereRitter>(VertexMean),
        Variant::of::<Aabb>(VertexMean),
        Variant::of::<Dop8>(VertexMean),
        Variant::of::<ObbVertex>(VertexMean),
        Variant::of::<ObbArea>(AreaMean).reference(),
        Variant::of::<ObbVertexCentroid>(VertexMean),
        Variant::of::<ObbAreaCentroid>(AreaMean),
        Variant::of::<ObbVertexSymmetric>(VertexMean),
        Variant::of::<ObbAreaSymmetric>(AreaMean),
        Variant::of::<ObbHullArea>(AreaMean).on_request(),
        Variant::of::<ObbDito14>(AreaMean).on_request(),
        Variant::of::<ObbMin>(AreaMean).on_request(),
        Variant::of::<SphereMean>(VertexMean).on_request(),
        Variant::of::<SphereWelzl>(VertexMean).on_request(),
        Variant::of::<AabbSat6>(VertexMean).on_request(),
        Variant::of::<AabbRefit>(VertexMean).on_request(),
        Variant::of::<Dop6>(VertexMean).on_request(),
        Variant::of::<Dop14>(VertexMean).on_request(),
        Variant::of::<Dop18>(VertexMean).on_request(),
        Variant::of::<Dop26>(VertexMean).on_request(),
        Variant::of::<Dop8Vertex>(VertexMean).on_request(),
        Variant::of::<Rss>(AreaMean).on_request(),
        Variant::of::<ObbRss>(AreaMean).on_request(),
        Variant::of::<SphereRitterF32>(VertexMean).on_request(),
        Variant::of::<AabbF32>(VertexMean).on_request(),
        Variant::of::<Dop8F32>(VertexMean).on_request(),
        Variant::of::<ObbVertexF32>(VertexMean).on_request(),
        Variant::of::<ObbAreaF32>(AreaMean).on_request(),
        Variant::of::<ObbLeast>(Sah16).on_request(),
    ];
    Registry::of(volumes.into_iter().chain(Variant::without_volume()))
}
