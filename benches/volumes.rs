//! One overlap test of each volume: far apart, nearly touching (the worst case: every axis is tried), overlapping; and what
//! a pose costs to set up.
//!
//! `cargo bench --bench volumes`; `-- --quick` for a first look.

use bvbench::geometry::{Isometry, Triangle, Vector};
use bvbench::volume::aabb::Aabb;
use bvbench::volume::aabb_refit::AabbRefit;
use bvbench::volume::aabb_sat6::AabbSat6;
use bvbench::volume::dop_6::Dop6;
use bvbench::volume::dop_8::Dop8;
use bvbench::volume::dop_8_vertex::Dop8Vertex;
use bvbench::volume::dop_14::Dop14;
use bvbench::volume::dop_18::Dop18;
use bvbench::volume::dop_26::Dop26;
use bvbench::volume::obb_area::ObbArea;
use bvbench::volume::obb_area_f32::ObbAreaF32;
use bvbench::volume::rss::Rss;
use bvbench::volume::sphere_ritter::SphereRitter;
use bvbench::volume::{BoundingVolume, Shape};
use criterion::{Criterion, criterion_group, criterion_main};
use obbtree::cases::meshes;
use std::hint::black_box;

/// Poses per distance: enough orientations that no branch is learnt by heart.
const POSES: usize = 256;

/// A pose at which the volumes are `clearance` (in parts of their size) before or after they first overlap.
fn pose<S: Shape>(a: &S, b: &S, index: usize, clearance: f64) -> Isometry {
    let f = index as f64;
    let turn = Vector::new((1.7 * f).sin(), (2.3 * f).cos(), (0.9 * f).sin()) * 3.0;
    let direction = Vector::new((0.7 * f).cos(), (1.1 * f).sin(), (1.9 * f).cos() + 0.1).normalize();
    let at = |distance: f64| Isometry::new(direction * distance, turn);
    let (mut overlapping, mut apart) = (0.0, 1000.0);
    for _ in 0..40 {
        let middle = f64::midpoint(overlapping, apart);
        if a.overlaps(b, &S::pose(&at(middle))) { overlapping = middle } else { apart = middle }
    }
    at(apart * (1.0 + clearance))
}

fn bench<V: BoundingVolume>(criterion: &mut Criterion, triangles: &[Triangle]) {
    let volume = V::fit(triangles);
    let mut group = criterion.benchmark_group("volume-test");
    for (name, clearance) in [("far", 3.0), ("near-miss", 0.01), ("overlapping", -0.1)] {
        let poses: Vec<<V::Shape as Shape>::Pose> =
            (0..POSES).map(|i| V::Shape::pose(&pose(&volume, &volume, i, clearance))).collect();
        group.bench_function(format!("{}/{name}", V::INFO.id), |bencher| {
            let mut next = poses.iter().cycle();
            bencher.iter(|| next.next().map(|pose| volume.overlaps(black_box(&volume), pose)));
        });
    }
    group.finish();
    let relative = pose(&volume, &volume, 1, 0.0);
    criterion.bench_function(&format!("pose/{}", V::INFO.id), |bencher| {
        bencher.iter(|| V::Shape::pose(black_box(&relative)));
    });
}

fn volumes(criterion: &mut Criterion) {
    let triangles = meshes::stepped_tool(12, 20).triangles();
    bench::<SphereRitter>(criterion, &triangles);
    bench::<Aabb>(criterion, &triangles);
    bench::<AabbSat6>(criterion, &triangles);
    bench::<AabbRefit>(criterion, &triangles);
    bench::<Dop6>(criterion, &triangles);
    bench::<Dop8>(criterion, &triangles);
    bench::<Dop8Vertex>(criterion, &triangles);
    bench::<Dop14>(criterion, &triangles);
    bench::<Dop18>(criterion, &triangles);
    bench::<Dop26>(criterion, &triangles);
    bench::<Rss>(criterion, &triangles);
    // All oriented boxes share one test; what differs is the fit.
    bench::<ObbArea>(criterion, &triangles);
    bench::<ObbAreaF32>(criterion, &triangles);
}

criterion_group!(benches, volumes);
criterion_main!(benches);
