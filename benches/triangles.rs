//! The triangle tests: the certified one of the leaves and the truth, the exact one behind it, and their integer twin.
//!
//! `cargo bench --bench triangles`; `-- --quick` for a first look.

use bvbench::geometry::{Triangle, Vector, certified, exact, exact_integer, grid};
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use obbtree::cases::meshes;
use std::hint::black_box;

/// Pairs per case.
const PAIRS: usize = 1024;

/// A triangle test as a plain function.
type Test = fn(&Triangle, &Triangle) -> bool;

/// Pairs of a soup's triangles, the second moved so that the centroids are `apart` mm from each other.
fn pairs(apart: f64) -> Vec<(Triangle, Triangle)> {
    let soup = meshes::soup(PAIRS as u32).triangles();
    let shifted = |(i, t): (usize, &Triangle)| {
        let other = soup[(i + 1) % soup.len()];
        let offset = t.centroid() - other.centroid() + Vector::new(0.6, 0.0, 0.8) * apart;
        (*t, other.map(|p| grid::snap(&(p + offset))))
    };
    soup.iter().enumerate().map(shifted).collect()
}

fn triangles(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("triangle-test");
    for (name, apart) in [("crossing", 0.0), ("near", 1.0), ("apart", 100.0)] {
        let pairs = pairs(apart);
        let tests: [(&str, Test); 3] = [
            ("certified", certified::touch),
            ("exact", exact::touch),
            ("integer", |a, b| exact_integer::touch(a, b) == Some(true)),
        ];
        for (test_name, test) in tests {
            let mut next = pairs.iter().cycle();
            group.bench_function(format!("{test_name}/{name}"), |bencher| {
                bencher.iter_batched(
                    || next.next().copied(),
                    |pair| black_box(pair).map(|(a, b)| test(&a, &b)),
                    BatchSize::SmallInput,
                );
            });
        }
    }
    group.finish();
}

criterion_group!(benches, triangles);
criterion_main!(benches);
