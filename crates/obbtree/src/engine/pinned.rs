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
            0xbfa2_0091_72a8_8e16,
            0x8d49_f6a8_18e0_ef93,
            0x61a0_2b22_9223_b79c,
            0xfe77_0f30_5113_ad4d,
            0x487e_a0ba_1728_ab18,
            0x517d_8e43_dd14_f28d
        ]
    );
    assert_eq!(
        trees::<Aligned>(),
        [
            0x1f97_b74f_4559_dc19,
            0x4f0c_5497_3660_77f8,
            0x5b40_d929_4e5e_957c,
            0x4229_6064_6bf1_835d,
            0x2c57_2aab_19d6_354a,
            0x3c6b_5cef_dff0_58b3
        ]
    );
    assert_eq!(
        trees::<Ball>(),
        [
            0x79d6_3b49_46a8_4406,
            0x03f1_ff12_1c89_e00d,
            0xef36_2da2_5898_41ea,
            0x55ee_8630_999f_4fdd,
            0xe65c_a856_bdc6_7652,
            0x1657_7eb7_d692_d1ba
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
    let [oriented, aligned] = if sixteen { [8548, 13_055] } else { [8635, 13_182] };
    let pinned = [
        [[28_267, 585], [132_838, 16_100], [28_267, 585], [28_096, 585], [14_331, 137], [oriented, 158]],
        [[35_181, 1456], [195_474, 37_882], [35_181, 1456], [35_010, 1456], [21_225, 816], [aligned, 957]],
        [[73_592, 7614], [598_310, 145_921], [73_592, 7614], [73_592, 7614], [54_390, 5462], [31_371, 4054]],
    ];
    // Where nothing fuses there is nothing to compare.
    if costs.iter().all(Option::is_some) {
        assert_eq!(costs.map(Option::unwrap_or_default), pinned.map(|of_volume| of_volume.to_vec()));
    }
}
