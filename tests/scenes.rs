//! The shipped scenes: what they are made of, and what their workloads must contain.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use bvbench::geometry::{Isometry, Mesh};
use bvbench::record::vocabulary::{Band, Stratum};
use bvbench::scene::{Overrides, Scene};
use bvbench::truth::{Judgement, PairOracle, Sought, judge_all};
use bvbench::workload::{PairPoses, Source, Workload, generate};
use std::collections::BTreeSet;
use std::sync::Arc;

/// What a scene is expected to be. A change of shapes or programs that moves these numbers is a change of the benchmark.
struct Expected {
    name: &'static str,
    /// Part `a`, part `b` of the first pair, with their triangles.
    pair: [(&'static str, usize); 2],
    /// First line of the program on which they touch.
    first_colliding_line: u32,
    /// Smallest distance on all lines before it, mm.
    closest_before_mm: f64,
}

const EXPECTED: [Expected; 7] = [
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
    Expected {
        name: "mill-vise",
        pair: [("vise", 13_906), ("holder", 9_520)],
        first_colliding_line: 93,
        closest_before_mm: 0.6,
    },
    Expected {
        name: "turn-mill",
        pair: [("tailstock", 9_158), ("end-mill", 2_016)],
        first_colliding_line: 72,
        closest_before_mm: 0.8,
    },
    Expected {
        name: "robot-cell",
        pair: [("fixture", 10_264), ("spindle", 10_628)],
        first_colliding_line: 98,
        closest_before_mm: 0.8,
    },
    Expected {
        name: "freeform-5axis",
        pair: [("part", 14_832), ("holder", 11_200)],
        first_colliding_line: 339,
        closest_before_mm: 0.447,
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
    judge_all(&oracle, &isometries, &Sought::Distance { beyond_mm: 20.0 }, &|_| ())
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
        assert!((1..=4).contains(&scene.pairs.len()), "{}", scene.name);
        let pair = scene.pairs[0];
        let found =
            [pair.a, pair.b].map(|part| (scene.parts[part].name.as_str(), scene.parts[part].mesh.faces().len()));
        assert_eq!(found, expected.pair, "{}", scene.name);
        assert!(found.iter().all(|(_, triangles)| (2_000..=20_000).contains(triangles)));
        let all: usize = scene.parts.iter().map(|part| part.mesh.faces().len()).sum();
        assert!((10_000..=75_000).contains(&all), "{}: {all}", scene.name);
    }
}

#[test]
fn the_shipped_scenes_are_those_in_the_folder() {
    // The largest is loaded elsewhere, and once is enough.
    let families = Scene::FAMILIES.iter().filter(|name| **name != "size-1e6");
    for name in Scene::SHIPPED.iter().chain(families) {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("bench-scenes").join(name);
        let on_disk = Scene::load(&folder).unwrap_or_else(|error| panic!("{error}"));
        let compiled_in = load(name);
        assert_eq!(on_disk.inputs, compiled_in.inputs);
        assert!(on_disk.inputs.len() >= 2, "{name}: the scene and a program at least");
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
        let first = judged.iter().position(|judgement| judgement.verdict.touches()).expect("a collision");
        assert_eq!(pair.poses[first].line, Some(expected.first_colliding_line), "{}", scene.name);
        let before = pair.poses.iter().zip(&judged).filter(|(pose, _)| pose.line < Some(expected.first_colliding_line));
        let closest = before.map(|(_, judgement)| judgement.clearance_mm).fold(f64::INFINITY, f64::min);
        // The faces are plane there, or curved by less than a tenth of this.
        assert!((closest - expected.closest_before_mm).abs() < 0.03, "{}: {closest}", scene.name);
        let strata: BTreeSet<Stratum> =
            judged.iter().map(|judgement| Stratum::of(judgement.verdict.touches(), judgement.clearance_mm)).collect();
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
                let touching = judgement.verdict.touches();
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
    for overrides in [
        Overrides { grading: Some(4.0), ..Overrides::default() },
        Overrides { density: Some(0.5), ..Overrides::default() },
    ] {
        let changed = Scene::find_with("lathe-toolpost", &overrides).unwrap_or_else(|error| panic!("{error}"));
        for part in [plain.pairs[0].a, plain.pairs[0].b] {
            let (before, after) = (&plain.parts[part].mesh, &changed.parts[part].mesh);
            assert_ne!(before.faces().len(), after.faces().len());
            // Chords cut off more of a curve the fewer they are: a percent for these.
            assert!((volume(after) / volume(before) - 1.0).abs() < 0.02);
        }
    }
}

#[test]
fn the_size_family_has_its_sizes_and_one_shape() {
    let volume = |name: &str| -> Vec<f64> { load(name).parts.iter().map(|part| part.mesh.signed_volume()).collect() };
    let finest = volume("size-1e5");
    for (name, triangles) in [("size-1e3", 1e3), ("size-1e4", 1e4), ("size-1e5", 1e5), ("size-1e6", 1e6)] {
        let scene = load(name);
        assert!(Scene::FAMILIES.contains(&name));
        assert!(scene.parts.iter().all(|part| part.mesh.edge_report().is_watertight()), "{name}");
        let all: usize = scene.parts.iter().map(|part| part.mesh.faces().len()).sum();
        assert!((all as f64 / triangles - 1.0).abs() < 0.12, "{name}: {all}");
        // The coarsest circles are inscribed octagons, with 0.90 of the area: (8/2) sin 45° / π.
        for (found, finest) in volume(name).iter().zip(&finest) {
            assert!((found / finest - 1.0).abs() < 0.11, "{name}: {found} mm³, {finest} mm³");
        }
    }
}

#[test]
fn the_grading_family_has_one_shape_and_one_number_of_triangles() {
    let even = load("grading-1");
    for (name, ratio) in [("grading-1", 1.0), ("grading-10", 10.0), ("grading-100", 100.0)] {
        let scene = load(name);
        assert!(Scene::FAMILIES.contains(&name));
        for (part, like) in scene.parts.iter().zip(&even.parts) {
            assert!(part.mesh.edge_report().is_watertight(), "{name}");
            assert_eq!(part.mesh.faces().len(), like.mesh.faces().len(), "{name}");
            // Corners are rounded to 1e-4 mm along the axis, which moves nothing on a cylinder.
            let (found, expected) = (part.mesh.signed_volume(), like.mesh.signed_volume());
            assert!((found / expected - 1.0).abs() < 1e-9, "{name}: {found} mm³, {expected} mm³");
        }
        let sleeve = &scene.parts[scene.part("sleeve").unwrap()].mesh;
        let mut heights: Vec<f64> = sleeve.vertices().iter().map(|vertex| vertex.z).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        let spaces: Vec<f64> = heights.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let found = spaces[0] / spaces[spaces.len() - 1];
        assert_eq!(spaces.len(), 48);
        // The finest space, 0.113 mm, is known to 5e-5 mm at both ends.
        assert!((found / ratio - 1.0).abs() < 2e-3, "{name}: {found}");
    }
}

/// Each of the paper's scenes has three programs that end in a collision, and one that does not: on these the paper's quantity is taken.
#[test]
fn programs_of_the_papers_scenes_end_as_they_should() {
    for (name, ends) in [
        (
            "lathe-toolpost",
            [("program.ngc", Some(62)), ("rapid.ngc", Some(15)), ("swivelled.ngc", Some(15)), ("clear.ngc", None)],
        ),
        (
            "lathe-tailstock",
            [("program.ngc", Some(56)), ("plunge.ngc", Some(15)), ("hand-wheel.ngc", Some(18)), ("clear.ngc", None)],
        ),
    ] {
        let scene = Scene::find(name).unwrap();
        let programs: Vec<_> = scene.program.iter().chain(&scene.more_programs).collect();
        assert_eq!(programs.len(), ends.len());
        for (run, (file, line)) in programs.into_iter().zip(ends) {
            assert!(run.file.ends_with(file), "{}", run.file.display());
            let pairs = bvbench::workload::along(&scene, run, 1000).unwrap();
            let first = pairs.iter().filter_map(|pair| {
                let mesh = |part: usize| Arc::clone(&scene.parts[part].mesh);
                let oracle = PairOracle::new(mesh(pair.poses.pair.a), mesh(pair.poses.pair.b));
                let poses: Vec<Isometry> = pair.poses.poses.iter().map(|pose| pose.a_from_b).collect();
                let judged = judge_all(&oracle, &poses, &Sought::Nothing, &|_| {});
                let touching = judged.iter().zip(&pair.poses.poses).find(|(judgement, _)| judgement.verdict.touches());
                touching.and_then(|(_, pose)| pose.line)
            });
            assert_eq!(first.min(), line, "{name}/{file}");
        }
    }
}
