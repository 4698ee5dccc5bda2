//! Properties of every registered volume by itself, without a tree: contents that share a point are never separated, the
//! test is symmetric, fits hold their contents, and what a volume says of its size is true.
//!
//! Failing seeds are printed by proptest.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use bvbench::geometry::{Isometry, Point, Triangle, Vector, grid};
use bvbench::volume::aabb::Aabb;
use bvbench::volume::aabb_f32::AabbF32;
use bvbench::volume::aabb_refit::AabbRefit;
use bvbench::volume::aabb_sat6::AabbSat6;
use bvbench::volume::dop_6::Dop6;
use bvbench::volume::dop_8::Dop8;
use bvbench::volume::dop_8_f32::Dop8F32;
use bvbench::volume::dop_8_vertex::Dop8Vertex;
use bvbench::volume::dop_14::Dop14;
use bvbench::volume::dop_18::Dop18;
use bvbench::volume::dop_26::Dop26;
use bvbench::volume::obb_area::ObbArea;
use bvbench::volume::obb_area_f32::ObbAreaF32;
use bvbench::volume::obb_area_symmetric::ObbAreaSymmetric;
use bvbench::volume::obb_dito14::ObbDito14;
use bvbench::volume::obb_hull_area::ObbHullArea;
use bvbench::volume::obb_least::ObbLeast;
use bvbench::volume::obb_min::ObbMin;
use bvbench::volume::obb_vertex::ObbVertex;
use bvbench::volume::obb_vertex_f32::ObbVertexF32;
use bvbench::volume::obb_vertex_symmetric::ObbVertexSymmetric;
use bvbench::volume::obbrss::ObbRss;
use bvbench::volume::rss::Rss;
use bvbench::volume::sphere_mean::SphereMean;
use bvbench::volume::sphere_ritter::SphereRitter;
use bvbench::volume::sphere_ritter_f32::SphereRitterF32;
use bvbench::volume::sphere_welzl::SphereWelzl;
use bvbench::volume::{BoundingVolume, Shape, Solid, consistency};
use nalgebra::{Quaternion, UnitQuaternion};
use proptest::prelude::*;

/// The example's own test runs here: an ellipsoid passes the conformance suite.
#[path = "../examples/my_volume.rs"]
#[allow(dead_code, reason = "its `main` is for the command line")]
mod my_volume;

/// A property for each safe volume that is quick to fit.
macro_rules! for_each_safe_volume {
    ($property:ident, $($argument:expr),*) => {
        $property::<SphereRitter>($($argument),*)?;
        $property::<Aabb>($($argument),*)?;
        $property::<Dop8>($($argument),*)?;
        $property::<ObbVertex>($($argument),*)?;
        $property::<ObbArea>($($argument),*)?;
        $property::<ObbVertexSymmetric>($($argument),*)?;
        $property::<ObbAreaSymmetric>($($argument),*)?;
        $property::<SphereMean>($($argument),*)?;
        $property::<SphereWelzl>($($argument),*)?;
        $property::<AabbSat6>($($argument),*)?;
        $property::<Dop6>($($argument),*)?;
        $property::<Dop14>($($argument),*)?;
        $property::<Dop18>($($argument),*)?;
        $property::<Dop26>($($argument),*)?;
        $property::<Dop8Vertex>($($argument),*)?;
        $property::<Rss>($($argument),*)?;
        $property::<ObbRss>($($argument),*)?;
        $property::<SphereRitterF32>($($argument),*)?;
        $property::<AabbF32>($($argument),*)?;
        $property::<Dop8F32>($($argument),*)?;
        $property::<ObbVertexF32>($($argument),*)?;
        $property::<ObbAreaF32>($($argument),*)?;
    };
}

/// A property for the volume whose test treats the two sides differently: it re-fits the second to the first's axes.
macro_rules! for_the_one_sided_volume {
    ($property:ident, $($argument:expr),*) => {
        $property::<AabbRefit>($($argument),*)?;
    };
}

/// A property for each box whose fit takes a hull or a search; their overlap test is that of the others.
macro_rules! for_each_slow_box {
    ($property:ident, $($argument:expr),*) => {
        $property::<ObbHullArea>($($argument),*)?;
        $property::<ObbDito14>($($argument),*)?;
        $property::<ObbLeast>($($argument),*)?;
        $property::<ObbMin>($($argument),*)?;
    };
}

fn vector(size: f64) -> impl Strategy<Value = Vector> {
    [-size..size, -size..size, -size..size].prop_map(|[x, y, z]| Vector::new(x, y, z))
}

/// Up to eight triangles on the grid, near a place up to 1000 mm from the origin, flattened by up to six orders of
/// magnitude along z.
fn triangles() -> impl Strategy<Value = Vec<Triangle>> {
    let corners = prop::collection::vec([vector(10.0), vector(10.0), vector(10.0)], 1..8);
    (corners, vector(1000.0), 0..7_i32).prop_map(|(corners, place, flat)| {
        let squash = Vector::new(1.0, 1.0, 10.0_f64.powi(-flat));
        let corner = |v: Vector| grid::snap(&Point::from(place + v.component_mul(&squash)));
        corners.into_iter().map(|c| Triangle { corners: c.map(corner) }).collect()
    })
}

/// Any rotation; or none; or nearly none; or quarter turns: where edges are parallel, tests of edges break down.
fn rotation() -> impl Strategy<Value = UnitQuaternion<f64>> {
    let any = [-1.0..1.0, -1.0..1.0, -1.0..1.0, -1.0..1.0_f64]
        .prop_filter("a quaternion has a length", |q| q.iter().map(|x| x * x).sum::<f64>() > 1e-3)
        .prop_map(|[w, i, j, k]| UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)));
    let nearly_none =
        (vector(1.0), 3..17_i32).prop_map(|(v, small)| UnitQuaternion::from_scaled_axis(v * 10.0_f64.powi(-small)));
    let quarters = [0..4, 0..4, 0..4_i32].prop_map(|turns| {
        let [x, y, z] = turns.map(|turn| f64::from(turn) * std::f64::consts::FRAC_PI_2);
        UnitQuaternion::from_euler_angles(x, y, z)
    });
    prop_oneof![any, nearly_none, quarters, Just(UnitQuaternion::identity())]
}

/// A point of some triangle, by numbers in [0, 1).
fn point_of(triangles: &[Triangle], [which, u, v]: [f64; 3]) -> Point {
    let [a, b, c] = &triangles[(which * triangles.len() as f64) as usize].corners;
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    a + (b - a) * u + (c - a) * v
}

/// The pose at which a point of `b` lies on a point of `a`.
fn joined(rotation: UnitQuaternion<f64>, in_a: &Point, in_b: &Point) -> Isometry {
    Isometry::from_parts((in_a - rotation * in_b).into(), rotation)
}

fn never_separated<V: BoundingVolume>(a: &[Triangle], b: &[Triangle], pose: &Isometry) -> Result<(), TestCaseError> {
    let (left, right) = (V::fit(a), V::fit(b));
    prop_assert!(left.overlaps(&right, &V::Shape::pose(pose)), "{} at {pose}", V::INFO.id);
    prop_assert!(right.overlaps(&left, &V::Shape::pose(&pose.inverse())), "{} at the inverse of {pose}", V::INFO.id);
    Ok(())
}

/// Nearer than this to contact, mm, exchanging the meshes may change the verdict by rounding.
const ROUNDING_MM: f64 = 1e-6;

fn symmetric<V: BoundingVolume>(a: &[Triangle], b: &[Triangle], pose: &Isometry) -> Result<(), TestCaseError> {
    let (left, right) = (V::fit(a), V::fit(b));
    let overlap = |pose: &Isometry| {
        (left.overlaps(&right, &V::Shape::pose(pose)), right.overlaps(&left, &V::Shape::pose(&pose.inverse())))
    };
    let (direct, exchanged) = overlap(pose);
    if direct != exchanged {
        // Then a step of a micron toward or away from each other must change one of the two.
        let between = (pose * right.centre() - left.centre()).try_normalize(0.0).unwrap_or_else(Vector::x);
        let changed = [-ROUNDING_MM, ROUNDING_MM].map(|step| {
            overlap(&Isometry::from_parts((pose.translation.vector + between * step).into(), pose.rotation))
        });
        prop_assert!(changed.contains(&(true, true)), "{} at {pose}", V::INFO.id);
    }
    Ok(())
}

fn holds_its_contents<V: BoundingVolume>(triangles: &[Triangle], inside: [f64; 3]) -> Result<(), TestCaseError> {
    let volume = V::fit(triangles);
    let (name, point) = (V::INFO.id, point_of(triangles, inside));
    prop_assert!(volume.contains(&point, 0.0), "{name}");
    Ok(())
}

fn says_what_is_so<V: BoundingVolume>(triangles: &[Triangle]) -> Result<(), TestCaseError> {
    prop_assert_eq!(consistency::inconsistency(&V::fit(triangles), triangles), None, "{}", V::INFO.id);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn contents_that_share_a_point_are_never_separated(
        a in triangles(), b in triangles(), rotation in rotation(), s in [0.0..1.0, 0.0..1.0, 0.0..1.0], t in [0.0..1.0, 0.0..1.0, 0.0..1.0],
    ) {
        let pose = joined(rotation, &point_of(&a, s), &point_of(&b, t));
        for_each_safe_volume!(never_separated, &a, &b, &pose);
        for_the_one_sided_volume!(never_separated, &a, &b, &pose);
    }

    /// The same contents against themselves, nearly parallel: every box has the other's axes up to rounding.
    #[test]
    fn near_parallel_twins_that_share_a_point_are_never_separated(
        a in triangles(), rotation in rotation(), small in vector(1.0), order in 9..17_i32,
        s in [0.0..1.0, 0.0..1.0, 0.0..1.0], t in [0.0..1.0, 0.0..1.0, 0.0..1.0],
    ) {
        // `b` is `a` turned in its own frame; the pose turns it back, up to a small error.
        let b: Vec<Triangle> = a.iter().map(|t| t.map(|p| grid::snap(&(rotation * p)))).collect();
        let back = UnitQuaternion::from_scaled_axis(small * 10.0_f64.powi(-order)) * rotation.inverse();
        let pose = joined(back, &point_of(&a, s), &point_of(&b, t));
        for_each_safe_volume!(never_separated, &a, &b, &pose);
        for_the_one_sided_volume!(never_separated, &a, &b, &pose);
    }

    #[test]
    fn exchanging_the_meshes_changes_nothing(
        a in triangles(), b in triangles(), rotation in rotation(), apart in vector(20.0),
    ) {
        let (p, q) = (point_of(&a, [0.0; 3]), point_of(&b, [0.0; 3]));
        let pose = joined(rotation, &(p + apart), &q);
        for_each_safe_volume!(symmetric, &a, &b, &pose);
    }

    #[test]
    fn fits_hold_their_contents(triangles in triangles(), inside in [0.0..1.0, 0.0..1.0, 0.0..1.0]) {
        for_each_safe_volume!(holds_its_contents, &triangles, inside);
        for_the_one_sided_volume!(holds_its_contents, &triangles, inside);
    }

    #[test]
    fn volumes_say_what_is_so(triangles in triangles()) {
        for_each_safe_volume!(says_what_is_so, &triangles);
        for_the_one_sided_volume!(says_what_is_so, &triangles);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn boxes_by_hull_or_search_hold_and_never_separate_their_contents(
        a in triangles(), b in triangles(), rotation in rotation(), s in [0.0..1.0, 0.0..1.0, 0.0..1.0], t in [0.0..1.0, 0.0..1.0, 0.0..1.0],
    ) {
        let pose = joined(rotation, &point_of(&a, s), &point_of(&b, t));
        for_each_slow_box!(never_separated, &a, &b, &pose);
        for_each_slow_box!(holds_its_contents, &a, s);
        for_each_slow_box!(says_what_is_so, &b);
    }
}
