use super::*;
use crate::geometry::Mesh;
use crate::truth::Verdict;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// A box from the origin to `size`, as an ASCII STL.
fn block(size: [f64; 3]) -> String {
    let mut text = "solid block\n".to_owned();
    for (axis, side) in [(0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0), (2, 0.0), (2, 1.0)] {
        let (u, v) = if side == 0.0 { ((axis + 2) % 3, (axis + 1) % 3) } else { ((axis + 1) % 3, (axis + 2) % 3) };
        let corner = |a: f64, b: f64| {
            let mut p = [0.0; 3];
            (p[axis], p[u], p[v]) = (side, a, b);
            format!("vertex {} {} {}\n", p[0] * size[0], p[1] * size[1], p[2] * size[2])
        };
        for [p, q, r] in [[(0., 0.), (1., 0.), (1., 1.)], [(0., 0.), (1., 1.), (0., 1.)]] {
            let corners: String = [p, q, r].iter().map(|&(a, b)| corner(a, b)).collect();
            write!(text, "facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n").unwrap();
        }
    }
    text + "endsolid block\n"
}

const SCENE: &str = r#"title = "A block slides to another"
pairs = [["wall", "tool"]]
machine.links = [{ name = "slide", joint = { axis = "X", direction = [1, 0, 0], min_mm = -200, max_mm = 50 } }]
parts = [
  { name = "tool", link = "slide", mesh = "tool.stl" },
  { name = "wall", at = { xyz_mm = [20, -10, -10] }, mesh = "wall.stl" },
]
[program]
file = "p.ngc"
start = { x_mm = -100 }
[[approaches]]
name = "head-on"
pair = ["wall", "tool"]
at = { x_mm = -50 }
direction = [1, 0, 0]
"#;

fn scene(scene: &str, program: &str, poses: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("scene.toml", scene),
        ("p.ngc", program),
        ("poses.csv", poses),
        ("tool.stl", &block([4.0, 2.0, 3.0])),
        ("wall.stl", &block([6.0, 40.0, 40.0])),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mut scene = Scene::load(folder.path()).unwrap();
    scene.name = "blocks".to_owned(); // not the temporary folder's, which seeds would depend on
    scene
}

fn slide() -> Scene {
    scene(SCENE, "G0 X-50\nG1 X-4 F100\nG1 X18\nM2\n", "")
}

fn verdicts(scene: &Scene, poses: &PairPoses) -> Vec<Verdict> {
    let mesh = |part: usize| scene.parts[part].mesh.clone();
    let oracle = PairOracle::new(mesh(poses.pair.a), mesh(poses.pair.b));
    poses.poses.iter().map(|pose| oracle.judge(&pose.a_from_b)).collect()
}

#[test]
fn blocks_are_closed() {
    let scene = slide();
    let volumes: Vec<f64> = scene.parts.iter().map(|part| part.mesh.signed_volume()).collect();
    assert!(scene.parts.iter().all(|part| Mesh::edge_report(&part.mesh).is_watertight()));
    assert!((volumes[0] - 24.0).abs() < 1e-9 && (volumes[1] - 9600.0).abs() < 1e-9, "{volumes:?}");
}

#[test]
fn shares_add_up_to_about_the_budget() {
    // With the greater budget, lines of approach have more poses than the scene's offsets.
    for poses in [4000, 200_000] {
        let workloads = generate(&slide(), poses, 1).unwrap();
        let counts: Vec<(&str, usize)> = workloads.iter().map(|w| (w.name.as_str(), w.len())).collect();
        for ((name, count), (expected, parts)) in counts.iter().zip([("program", 1), ("approach", 1), ("random", 2)]) {
            assert_eq!(*name, expected);
            let wanted = (poses * parts / 4) as f64;
            assert!((*count as f64 / wanted - 1.0).abs() < 0.05, "{name}: {count}");
        }
        let lines: BTreeSet<u32> = workloads[1].pairs[0].poses.iter().map(|pose| pose.cluster).collect();
        assert!(lines.len() <= 2048, "{} lines", lines.len());
    }
}

#[test]
fn prescribed_depths_are_what_the_oracle_finds() {
    let scene = slide();
    for workload in generate(&scene, 4000, 1).unwrap() {
        let pair = &workload.pairs[0];
        for (pose, verdict) in pair.poses.iter().zip(verdicts(&scene, pair)) {
            let Some(depth) = pose.depth_mm else { continue };
            assert!(depth >= -1e-6 || !verdict.touches(), "{}: touching {depth} mm", workload.name);
            // Shallow enough that the thin block cannot have come out on the other side, nor vanished inside.
            assert!(!(1.1e-6..0.01).contains(&depth) || verdict.touches(), "{}: apart at {depth} mm", workload.name);
        }
    }
}

#[test]
fn an_approach_along_an_axis_stops_where_the_sum_says() {
    let workloads = generate(&slide(), 60, 1).unwrap();
    let approach = &workloads[1].pairs[0];
    assert_eq!(approach.poses.len(), 15);
    // The tool's front is at x + 4, the wall's face at 20: contact at x = 16, which is -4 in the wall's frame.
    for pose in &approach.poses {
        let depth = pose.depth_mm.unwrap();
        assert!((pose.a_from_b.translation.x - (-4.0 + depth)).abs() < 1e-9);
        assert!((pose.a_from_b.translation.y - 10.0).abs() < 1e-12);
    }
}

#[test]
fn a_program_gives_its_lines_and_runs_into_the_wall_at_the_third() {
    let scene = slide();
    let workloads = generate(&scene, 2000, 1).unwrap();
    let path = &workloads[0].pairs[0];
    let first = verdicts(&scene, path).iter().position(Verdict::touches).unwrap();
    assert_eq!(path.poses[first].line, Some(3));
    assert!(path.poses.iter().all(|pose| pose.depth_mm.is_none()));
    let x: Vec<f64> = path.poses.iter().map(|pose| pose.a_from_b.translation.x).collect();
    assert!(x.windows(2).all(|pair| pair[0] < pair[1]), "the path goes on");
    let clusters: BTreeSet<u32> = path.poses.iter().map(|pose| pose.cluster).collect();
    assert_eq!(clusters.len(), path.poses.len().div_ceil(BLOCK));
}

#[test]
fn the_same_on_every_run_and_any_number_of_threads_but_not_for_another_seed() {
    let numbers = |threads: usize, seed: u64| -> Vec<u64> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let workloads = pool.install(|| generate(&slide(), 1000, seed)).unwrap();
        let poses = workloads.iter().flat_map(|w| &w.pairs).flat_map(|pair| &pair.poses);
        poses.flat_map(|p| p.a_from_b.to_homogeneous().iter().map(|x| x.to_bits()).collect::<Vec<_>>()).collect()
    };
    assert_eq!(numbers(1, 5), numbers(2, 5));
    assert_ne!(numbers(1, 5), numbers(1, 6));
}

#[test]
fn every_depth_band_and_distance_has_its_random_poses() {
    let workloads = generate(&slide(), 400, 3).unwrap();
    let depths: Vec<f64> = workloads[2].pairs[0].poses.iter().filter_map(|pose| pose.depth_mm).collect();
    for (low, high) in [
        (1e-6, 1e-3),
        (1e-3, 0.01),
        (0.01, 0.1),
        (0.1, 1.0),
        (1.0, 5.0),
        (5.0, 99.0),
        (-1.0, 0.0),
        (-10.0, -1.0),
        (-100.0, -10.0),
    ] {
        assert!(depths.iter().any(|&depth| low < depth && depth <= high), "({low}, {high}]");
    }
}

#[test]
fn leaving_the_limits_is_an_error_with_its_line() {
    let error = generate(&scene(SCENE, "G0 X0\n\nG0 X51\nM2\n", ""), 100, 1).unwrap_err();
    assert!(error.to_string().contains("p.ngc:3: axis X at "), "{error}");
}

#[test]
fn an_approach_that_passes_by_is_named() {
    let scene = scene(&SCENE.replace("direction = [1, 0, 0]\n", "direction = [0, 1, 0]\n"), "M2\n", "");
    let error = generate(&scene, 100, 1).unwrap_err();
    assert_eq!(error.to_string(), "approach `head-on`: wall:tool never touch on this line");
}

#[test]
fn recorded_poses_take_part_and_nothing_at_all_is_an_error() {
    let recorded = "title = \"\"\nrandom = []\n[[parts]]\nname = \"a\"\nmesh = \"wall.stl\"\n\
                    [[parts]]\nname = \"b\"\nmesh = \"tool.stl\"\n[recorded]\nfile = \"poses.csv\"\n";
    let poses = "part,qw,qx,qy,qz,tx,ty,tz\nb,1,0,0,0,-30,0,0\nb,1,0,0,0,1,0,0\n";
    let workloads = generate(&scene(recorded, "", poses), 100, 1).unwrap();
    assert_eq!((workloads.len(), workloads[0].len(), workloads[0].source), (1, 2, Source::Recorded));
    let bare = SCENE.split("[program]").next().unwrap().replace("pairs =", "random = []\npairs =");
    assert_eq!(
        generate(&scene(&bare, "", ""), 100, 1).unwrap_err(),
        WorkloadError::Nothing { scene: "blocks".to_owned() }
    );
}
