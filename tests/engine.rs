//! The engine on the shipped scenes against the exact truth, on every instruction set this machine has.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use bvbench::scene::{Pair, Scene};
use bvbench::truth::PairOracle;
use bvbench::workload::generate;
use obbtree::engine::aligned::Aligned;
use obbtree::engine::oriented::Oriented;
use obbtree::engine::traverse::{Scratch, first};
use obbtree::engine::{Isometry, Simd, WideTree, WideVolume};
use rayon::prelude::*;
use std::sync::Arc;

#[test]
fn on_the_shipped_scenes_every_instruction_set_says_the_exact_truth() {
    fn says<V: WideVolume>(trees: &[WideTree<V>], a: usize, b: usize, pose: &Isometry, exact: bool) {
        for simd in Simd::available() {
            let says = first(&trees[a], &trees[b], pose, simd, &mut Scratch::default());
            assert_eq!(says, exact, "{}, {}, {pose}", std::any::type_name::<V>(), simd.name());
        }
    }
    let (mut touching, mut poses) = (0, 0);
    for name in ["lathe-toolpost", "lathe-tailstock", "trunnion-impeller"] {
        let scene = Scene::find(name).unwrap();
        let oriented: Vec<WideTree<Oriented>> = scene.parts.iter().map(|part| WideTree::build(&part.mesh)).collect();
        let aligned: Vec<WideTree<Aligned>> = scene.parts.iter().map(|part| WideTree::build(&part.mesh)).collect();
        for pair in generate(&scene, 600, 3).unwrap().iter().flat_map(|workload| &workload.pairs) {
            let Pair { a, b, .. } = pair.pair;
            let mesh = |part: usize| Arc::clone(&scene.parts[part].mesh);
            let oracle = PairOracle::new(mesh(a), mesh(b));
            let exact: Vec<bool> = pair.poses.par_iter().map(|pose| oracle.touches(&pose.a_from_b)).collect();
            for (pose, exact) in pair.poses.iter().zip(&exact) {
                says(&oriented, a, b, &pose.a_from_b, *exact);
                says(&aligned, a, b, &pose.a_from_b, *exact);
            }
            poses += exact.len();
            touching += exact.iter().filter(|&&touching| touching).count();
        }
    }
    assert!(touching > poses / 20 && touching < poses, "{touching} of {poses}");
}
