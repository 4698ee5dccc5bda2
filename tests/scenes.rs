//! The shipped scenes: what they are made of, and what their workloads must contain.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use bvbench::geometry::{Isometry, Mesh};
use bvbench::record::vocabulary::{Band, Stratum};
use bvbench::scene::{Overrides, Scene};
use bvbench::truth::{Judgement, PairOracle, judge_all};
use bvbench::workload::{PairPoses, Source, Workload, generate};
use std::collections::BTreeSet;
use std::sync::Arc;

/// What a scene is expected to be. A change of shapes or programs that moves these numbers is a change of the benchmark.
struct Expected {
    name: &'static str,
    /// Part `a`, part `b` of the pair, with their triangles.
    pair: [(&'static str, usize); 2],
    /// First line of the program on which they touch.
    first_colliding_line: u32,
    /// Smallest distance on all lines before it, mm.
    closest_before_mm: f64,
}

const EXPECTED: [Expected; 3] = [
    Expected {
        name: "lathe-toolpost",
        pair: [("tool-post", 12_832), ("tool", 10_368)],
        first_colliding_line: 62,
        closest_before_mm: 0.6,
    },
    Expected {
        name: "lathe-tailstock",
        pair: [("tailstock", 19_862), ("cutter", 15_440)],
        first_colliding_line: 56,
        closest_before_mm: 0.2,
    },
    Expected {
        name: "trunnion-impeller",
        pair: [("impeller", 17_912), ("tool", 16_170)],
        first_colliding_line: 60,
        closest_before_mm: 0.666,
    },
];

/// Poses per scene: enough for every band of every workload, and judged in seconds.
const POSES: usize = 2000;
const SEED: u64 = 1;

fn load(name: &str) -> Scene {
    Scene::find(name).unwrap_or_else(|error| panic!("{error}"))
}

fn workloads(scene: &Scene) -> Vec<Workload> {
    generate(scene, POSES, SEED).unwrap_or_else(|error| panic!("{error}"))
}

fn judged(scene: &Scene, poses: &PairPoses) -> Vec<Judgement> {
    let mesh = |part: usize| Arc::clone(&scene.parts[part].mesh);
    let oracle = PairOracle::new(mesh(poses.pair.a), mesh(poses.pair.b));
    let isometries: Vec<Isometry> = poses.poses.iter().map(|pose| pose.a_from_b).collect();
    judge_all(&oracle, &isometries, 20.0, &|_| ())
}

#[test]
fn shipped_scenes_are_those_expected() {
    assert_eq!(Scene::SHIPPED, EXPECTED.map(|expected| expected.name));
}

#[test]
fn parts_are_watertight_with_pinned_triangle_counts() {
    for expected in EXPECTED {
        let scene = load(expected.name);
        for part in &scene.parts {
            assert!(part.mesh.edge_report().is_watertight(), "{}: {}", scene.name, part.name);
            assert!(part.mesh.signed_volume() > 0.0, "{}: {}", scene.name, part.name);
        }
        let [pair] = scene.pairs[..] else { panic!("one pair expected") };
        let found =
            [pair.a, pair.b].map(|part| (scene.parts[part].name.as_str(), scene.parts[part].mesh.faces().len()));
        assert_eq!(found, expected.pair, "{}", scene.name);
        assert!(found.iter().all(|(_, triangles)| (5_000..=20_000).contains(triangles)));
    }
}

#[test]
fn the_shipped_scenes_are_those_in_the_folder() {
    for name in Scene::SHIPPED {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("bench-scenes").join(name);
        let on_disk = Scene::load(&folder).unwrap_or_else(|error| panic!("{error}"));
        let compiled_in = load(name);
        assert_eq!(on_disk.inputs, compiled_in.inputs);
        assert!(
            (2..=3).contains(&on_disk.inputs.len()),
            "scene and program, and the machine where it has a file of its own"
        );
        assert_eq!((on_disk.name, on_disk.pairs), (compiled_in.name, compiled_in.pairs));
    }
}

#[test]
fn programs_come_near_and_collide_where_they_should() {
    for expected in EXPECTED {
        let scene = load(expected.name);
        let workloads = workloads(&scene);
        let program = workloads.iter().find(|workload| workload.source == Source::Program).expect("a program");
        let pair = &program.pairs[0];
        let judged = judged(&scene, pair);
        let first = judged.iter().position(|judgement| judgement.verdict.exact).expect("a collision");
        assert_eq!(pair.poses[first].line, Some(expected.first_colliding_line), "{}", scene.name);
        let before = pair.poses.iter().zip(&judged).filter(|(pose, _)| pose.line < Some(expected.first_colliding_line));
        let closest = before.map(|(_, judgement)| judgement.clearance_mm).fold(f64::INFINITY, f64::min);
        // The faces are plane there, or curved by less than a tenth of this.
        assert!((closest - expected.closest_before_mm).abs() < 0.03, "{}: {closest}", scene.name);
        let strata: BTreeSet<Stratum> =
            judged.iter().map(|judgement| Stratum::of(judgement.verdict.exact, judgement.clearance_mm)).collect();
        assert_eq!(strata.len(), Stratum::ALL.len(), "{}: {strata:?}", scene.name);
    }
}

#[test]
fn prescribed_poses_are_apart_before_contact_and_touch_right_after_it_in_every_band() {
    for name in Scene::SHIPPED {
        let scene = load(name);
        for workload in workloads(&scene).iter().filter(|workload| workload.source != Source::Program) {
            let pair = &workload.pairs[0];
            let (mut bands, mut strata) = (BTreeSet::new(), BTreeSet::new());
            for (pose, judgement) in pair.poses.iter().zip(judged(&scene, pair)) {
                let touching = judgement.verdict.exact;
                let depth = pose.depth_mm.expect("a prescribed depth");
                let place = format!("{name}, {}, cluster {}, {depth} mm", workload.name, pose.cluster);
                assert!(depth >= -Band::GRAZING_MM || !touching, "touching too early: {place}");
                let just_after = Band::GRAZING_MM < depth && depth <= 1e-3;
                assert!(!just_after || touching, "apart too late: {place}");
                strata.insert(Stratum::of(touching, judgement.clearance_mm));
                if touching {
                    bands.insert(Band::of_depth(depth));
                }
            }
            let above_grazing = bands.iter().filter(|band| band.is_above_grazing()).count();
            assert_eq!(above_grazing, 6, "{name}, {}: {bands:?}", workload.name);
            assert_eq!(strata.len(), Stratum::ALL.len(), "{name}, {}: {strata:?}", workload.name);
        }
    }
}

#[test]
fn overrides_change_the_triangles_but_not_the_shape() {
    let volume = |mesh: &Mesh| mesh.signed_volume();
    let plain = load("lathe-toolpost");
    for overrides in [Overrides { grading: Some(4.0), density: None }, Overrides { grading: None, density: Some(0.5) }]
    {
        let changed = Scene::find_with("lathe-toolpost", &overrides).unwrap_or_else(|error| panic!("{error}"));
        for part in [plain.pairs[0].a, plain.pairs[0].b] {
            let (before, after) = (&plain.parts[part].mesh, &changed.parts[part].mesh);
            assert_ne!(before.faces().len(), after.faces().len());
            // Chords cut off more of a curve the fewer they are: a percent for these.
            assert!((volume(after) / volume(before) - 1.0).abs() < 0.02);
        }
    }
}
