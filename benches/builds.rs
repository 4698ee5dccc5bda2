//! Building a tree over 5 000 triangles: each variant under its own policy, and each split rule with one volume.
//!
//! `cargo bench --bench builds`; `-- --quick` for a first look.

use bvbench::registry;
use bvbench::tree::{Policy, SplitRule};
use criterion::{Criterion, criterion_group, criterion_main};
use obbtree::cases::meshes;

fn builds(criterion: &mut Criterion) {
    let mesh = meshes::torus(60.0, 20.0, 100, 25);
    let registry = registry::standard();
    let mut group = criterion.benchmark_group("build");
    group.sample_size(10);
    for variant in registry.variants() {
        group.bench_function(variant.info.id, |bencher| bencher.iter(|| variant.prepare(&mesh, None)));
    }
    group.finish();
    let mut group = criterion.benchmark_group("build-by-split");
    group.sample_size(10);
    let first = registry.variants().iter().find(|variant| variant.is_reference);
    for split in SplitRule::ALL {
        for policy in [Policy::own(split), Policy::shared(split)] {
            let Some(variant) = first else { continue };
            let name = format!("{}/{policy}", variant.info.id);
            group.bench_function(name, |bencher| bencher.iter(|| variant.prepare(&mesh, Some(policy))));
        }
    }
    group.finish();
}

criterion_group!(benches, builds);
criterion_main!(benches);
