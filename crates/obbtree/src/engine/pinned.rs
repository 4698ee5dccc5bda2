//! What trees look like and what queries cost, pinned: a change to how trees are built or walked shows here, whether it was meant or not. Verdicts
//! and lists are held against the exact truth elsewhere; nothing there would notice a tree that is twice as slow.
//!
//! After a change that was meant, the numbers come from the message of the failed test.

#![cfg(all(target_os = "linux", target_arch = "x86_64"))] // Sines and roots of other systems may differ in the last bit.

use super::aligned::Aligned;
use super::ball::Ball;
use super::lanes::Simd;
use super::oriented::Oriented;
use super::plain::Plain;
use super::traverse::{Counts, Scratch, all, first};
use super::*;
use crate::cases::meshes;
use crate::engine::geometry::{GridMesh, Isometry, Vector};

/// FNV-1a, 64 bits.
fn mix(hash: u64, value: u64) -> u64 {
    value.to_le_bytes().iter().fold(hash, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Every volume, and the triangles in tree order.
fn fingerprint<V: WideVolume>(tree: &WideTree<V>) -> u64 {
    let (mut hash, mut slots) = (0xcbf2_9ce4_8422_2325, vec![WideTree::<V>::ROOT]);
    while let Some(slot) = slots.pop() {
        let numbers: Vec<f64> = match tree.plain(slot) {
            Plain::Box { axes, centre, half } => axes.iter().chain(&centre.coords).chain(&half).copied().collect(),
            Plain::Ball { centre, radius } => centre.coords.iter().copied().chain([radius]).collect(),
        };
        hash = numbers.into_iter().fold(hash, |hash, x| mix(hash, x.to_bits()));
        slots.extend(tree.children(slot).rev());
    }
    let corners = tree.leaves().flat_map(|triangle| triangle.corners).flat_map(|corner| [corner.x, corner.y, corner.z]);
    corners.fold(hash, |hash, x| mix(hash, x.to_bits()))
}

fn subjects() -> [GridMesh; 6] {
    let turn = Isometry::new(Vector::new(700.0, -300.0, 50.0), Vector::new(0.4, -1.1, 0.7));
    [
        meshes::stepped_tool(24, 12),
        meshes::torus(12.0, 4.0, 40, 20),
        meshes::soup(300),
        meshes::cuboid(3.0, 20.0, 7.0),
        meshes::degenerate(),
        // So large that its frames are sought in a part of it, and that it is divided among threads.
        meshes::moved(&meshes::torus(60.0, 21.0, 250, 150), 1.0, &turn),
    ]
}

fn trees<V: WideVolume>() -> [u64; 6] {
    subjects().map(|mesh| fingerprint(&WideTree::<V>::build(&mesh)))
}

#[test]
fn trees_are_as_they_were() {
    assert_eq!(
        trees::<Oriented>(),
        [
            0x3b25_be0c_3087_5c59,
            0x2207_8732_417f_ac6e,
            0x0d3a_af89_0148_4606,
            0x92a9_5604_042b_4885,
            0xcddd_aaae_b072_b2d7,
            0xc23a_c37c_d207_89b6
        ]
    );
    assert_eq!(
        trees::<Aligned>(),
        [
            0xb76e_b878_9679_0483,
            0x491f_9495_0498_c390,
            0x5b40_d929_4e5e_957c,
            0x92a9_5604_042b_4885,
            0x2c55_9657_76e5_7083,
            0xf1f1_0d0f_998f_330e
        ]
    );
    assert_eq!(
        trees::<Ball>(),
        [
            0x010e_c298_af4f_bf60,
            0x5cc7_5892_8124_7a91,
            0xef36_2da2_5898_41ea,
            0x3ad6_1b48_a229_1025,
            0x6024_58bb_dc48_87e9,
            0x630e_c904_5ed0_4023
        ]
    );
}

/// Volume and triangle tests over the poses of a path: of verdicts, of lists, and of verdicts with each coherence. Only where products are
/// fused: elsewhere some gaps round to other numbers.
fn costs<V: WideVolume>() -> Option<Vec<[u64; 2]>> {
    let simd = Simd::available().into_iter().find(|simd| simd.fuses())?;
    let (a, b) =
        (WideTree::<V>::build(&meshes::torus(12.0, 4.0, 40, 20)), WideTree::build(&meshes::stepped_tool(24, 12)));
    let poses: Vec<Isometry> = (0..600)
        .map(|i| 0.05 * f64::from(i))
        .map(|x| Isometry::new(Vector::new(60.0 - 2.0 * x, 2.0, 0.3 * x - 6.0), Vector::new(0.01 * x, 0.2, -0.02 * x)))
        .collect();
    let mut scratch = Scratch::default();
    let mut sums = Vec::new();
    let mut sum = |counts: &mut dyn FnMut(&Isometry) -> Counts| {
        sums.push(
            poses
                .iter()
                .map(&mut *counts)
                .fold([0, 0], |sum, counts| [sum[0] + counts.volume_tests, sum[1] + counts.triangle_tests]),
        );
    };
    sum(&mut |pose| {
        first(&a, &b, pose, simd, &mut scratch);
        scratch.counts()
    });
    sum(&mut |pose| {
        let _ = all(&a, &b, pose, simd, &mut scratch);
        scratch.counts()
    });
    for coherence in Coherence::ALL {
        let mut memory = Memory::default();
        sum(&mut |pose| memory.counted(&a, &b, pose, simd, coherence));
    }
    Some(sums)
}

#[test]
fn queries_cost_what_they_did() {
    let costs = [costs::<Oriented>(), costs::<Aligned>(), costs::<Ball>()];
    // With sixteen lanes the axes of edges are asked for both visits of a pass or for neither, so a path keeps other gaps than with eight.
    let sixteen = Simd::available()[0].name() == "avx512";
    let [oriented, aligned] = if sixteen { [5487, 7737] } else { [5609, 7839] };
    let pinned = [
        [[22_575, 612], [92_197, 21_948], [22_575, 612], [20_869, 612], [10_942, 184], [oriented, 198]],
        [[27_173, 1704], [113_984, 42_816], [27_173, 1704], [25_467, 1704], [14_184, 932], [aligned, 1070]],
        [[36_499, 9128], [240_713, 146_220], [36_499, 9128], [34_600, 9128], [23_502, 6024], [12_927, 4128]],
    ];
    // Where nothing fuses there is nothing to compare.
    if costs.iter().all(Option::is_some) {
        assert_eq!(costs.map(Option::unwrap_or_default), pinned.map(|of_volume| of_volume.to_vec()));
    }
}
