//! Mode `first` of every variant, a tool against a ring of about 10 000 triangles each, at poses that collide, nearly do,
//! and are far apart. `brute` is left out: it takes a second per pose.
//!
//! `cargo bench --bench queries`; `-- --quick` for a first look.

use bvbench::geometry::{Isometry, Mesh, Vector};
use bvbench::method::Kind;
use bvbench::registry::{self, Variant};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use obbtree::cases::meshes;

/// Poses per measurement.
const POSES: u32 = 64;

/// Approaches of the tool (upright, along its own axis or from the side) to the ring, stopped at `clearance` mm from first
/// contact.
fn poses(ring: &Mesh, tool: &Mesh, judge: &Variant, clearance: f64) -> Vec<Isometry> {
    let (a, b) = (judge.prepare(ring, None), judge.prepare(tool, None));
    (0..POSES)
        .map(|i| {
            let f = f64::from(i);
            let turn = Vector::new((1.7 * f).sin(), (2.3 * f).cos(), (0.9 * f).sin());
            let direction = Vector::new(f.cos(), f.sin(), 0.5 * (0.7 * f).sin()).normalize();
            let at = |distance: f64| Isometry::new(direction * distance, turn);
            let (mut touching, mut apart) = (60.0, 400.0);
            for _ in 0..30 {
                let middle = f64::midpoint(touching, apart);
                if a.first_counted(&*b, &at(middle)).0 { touching = middle } else { apart = middle }
            }
            at(apart + clearance)
        })
        .collect()
}

fn queries(criterion: &mut Criterion) {
    let (ring, tool) = (meshes::torus(60.0, 20.0, 100, 50), meshes::stepped_tool(64, 70));
    let registry = registry::standard();
    let Some(judge) = registry.variants().iter().find(|variant| variant.is_reference) else { return };
    let mut group = criterion.benchmark_group("query");
    group.sample_size(10);
    group.throughput(Throughput::Elements(u64::from(POSES)));
    for (name, clearance) in [("colliding", -2.0), ("near-miss", 0.3), ("medium", 5.0), ("far", 50.0)] {
        let poses = poses(&ring, &tool, judge, clearance);
        for variant in registry.variants().iter().filter(|variant| variant.kind != Kind::Control) {
            let (a, b) = (variant.prepare(&ring, None), variant.prepare(&tool, None));
            let mut verdicts = Vec::with_capacity(poses.len());
            group.bench_function(format!("{name}/{}", variant.info.id), |bencher| {
                bencher.iter(|| {
                    verdicts.clear();
                    a.first(&*b, &poses, &mut verdicts);
                    verdicts.iter().filter(|&&touching| touching).count()
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, queries);
criterion_main!(benches);
