//! Polytopes computed by hand, and the bound by duality compared with the contents and with the exact rotated polytope.

use super::*;
use crate::tree::{Policy, SplitRule, Tree};
use crate::volume::BoundingVolume;
use crate::volume::dop_6::Dop6;
use crate::volume::dop_8::Dop8;
use crate::volume::dop_14::Dop14;
use crate::volume::dop_18::Dop18;
use crate::volume::dop_26::Dop26;
use obbtree::cases::Draw;
use obbtree::cases::meshes;

#[test]
fn the_hulls_of_the_normals_have_the_facets_of_their_solids() {
    let cones = |normals: &[Vector]| cones_over_facets(normals).len();
    assert_eq!(cones(Dop6::NORMALS), 8); // octahedron
    assert_eq!(cones(Dop8::NORMALS), 12); // cube: six squares
    assert_eq!(cones(Dop14::NORMALS), 24); // tetrakis hexahedron
    assert_eq!(cones(Dop18::NORMALS), 32); // 18 corners: 2·18 - 4
    assert_eq!(cones(Dop26::NORMALS), 48); // 26 corners: 2·26 - 4
}

fn resolves<D: Directions<K>, const K: usize>() {
    let mut draw = Draw::new(0, &["dop", "resolves"], K as u64);
    for _ in 0..2000 {
        let e = draw.direction().into_inner();
        let bound = bound::<D, K>(&e, 0.0);
        let normal = |m: usize| if m < K { D::NORMALS[m] } else { -D::NORMALS[m - K] };
        let sum: Vector = bound.members.iter().zip(bound.weights).map(|(&m, w)| normal(m) * w).sum();
        assert!((sum - e).norm() < 1e-12 && bound.weights.iter().all(|w| *w >= 0.0), "{K} {e:?}");
    }
}

#[test]
fn every_direction_is_a_non_negative_sum_of_a_cone() {
    resolves::<Dop6, 3>();
    resolves::<Dop8, 4>();
    resolves::<Dop14, 7>();
    resolves::<Dop18, 9>();
    resolves::<Dop26, 13>();
}

/// The segment from (-1,0,0) to (1,0,0).
fn segment() -> [Triangle; 1] {
    let p = |x: f64| Point::new(x, 0.0, 0.0);
    [Triangle::new(p(-1.0), p(1.0), p(0.0))]
}

#[test]
fn the_eight_dop_of_a_diagonal_segment_is_an_octahedron() {
    // |±x±y±z| <= 1, the octahedron of volume 4/3 and eight faces of √3/2.
    let dop = Dop8::fit(&segment());
    assert!((dop.volume() - 4.0 / 3.0).abs() < 1e-6, "{}", dop.volume());
    assert!((dop.surface_area() - 4.0 * 3.0_f64.sqrt()).abs() < 1e-6);
    assert!(dop.contains(&Point::new(0.0, 0.99, 0.0), 0.0) && !dop.contains(&Point::new(0.5, 0.5, 0.5), 0.01));
}

#[test]
fn octahedra_part_where_their_faces_do() {
    let dop = Dop8::fit(&segment());
    let overlaps = |x: f64| dop.overlaps(&dop, &Dop::<Dop8, 4>::pose(&Isometry::translation(x, x, x)));
    assert!(overlaps(2.0 / 3.0 - 1e-6)); // faces x + y + z = ±1 meet at 3x = 2
    assert!(!overlaps(2.0 / 3.0 + 1e-6));
}

#[test]
fn more_directions_hold_a_sphere_more_tightly() {
    let ball = meshes::sphere(10.0, 48, 24).triangles();
    // The k-DOP of a ball of radius 1 has its inscribed sphere: V = A/3. The cube 8; the octahedron 4√3 = 6.93; with all 26
    // planes it is within a quarter of the ball's 4π/3.
    let unit = |volume: f64| volume / 1000.0;
    assert!((unit(Dop6::fit(&ball).volume()) - 8.0).abs() < 0.05);
    assert!((unit(Dop8::fit(&ball).volume()) - 4.0 * 3.0_f64.sqrt()).abs() < 0.1);
    let volumes = [Dop14::fit(&ball).volume(), Dop18::fit(&ball).volume(), Dop26::fit(&ball).volume()].map(unit);
    assert!(volumes[0] > volumes[2] && volumes[1] > volumes[2] && volumes[2] < 1.25 * 4.19, "{volumes:?}");
}

/// The largest coordinate of the polytope's corners along a direction.
fn exact_support(corners: &[Point], direction: &Vector) -> f64 {
    corners.iter().map(|p| direction.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max)
}

/// Number of posed nodes, and how much wider the bound was than the rotated polytope.
struct Outcome {
    nodes: u32,
    width_mean: f64,
    width_max: f64,
}

/// `nodes` posed nodes of trees over the suite's meshes, every direction of the other mesh.
fn posed_nodes<D: Directions<K>, const K: usize>(nodes: u32) -> Outcome {
    /// Number of nodes that are tested at one pose.
    const PER_POSE: u32 = 100;
    let trees: Vec<Tree<Dop<D, K>>> = meshes::subjects()
        .iter()
        .map(|subject| Tree::build(&Dop::<D, K>::around, &subject.mesh.triangles(), Policy::own(SplitRule::Median)))
        .collect();
    // The rotated polytope's own extents, of every node; those without an inside have no width to compare.
    let corners: Vec<Vec<Vec<Point>>> = trees
        .iter()
        .map(|tree| {
            tree.nodes().iter().map(|node| node.volume.polytope().edges().into_iter().flatten().collect()).collect()
        })
        .collect();
    let mut draw = Draw::new(0, &["dop", "posed nodes"], K as u64);
    let mut pick = |count: usize| ((draw.unit() * count as f64) as usize).min(count - 1);
    let mut outcome = Outcome { nodes: 0, width_mean: 0.0, width_max: 0.0 };
    let (mut sum, mut widths) = (0.0, 0_u32);
    let mut poses = Draw::new(0, &["dop", "poses"], K as u64);
    while outcome.nodes < nodes {
        let pose = Isometry::from_parts((poses.in_ball() * 50.0).into(), poses.rotation());
        let rotation = pose.rotation.to_rotation_matrix().into_inner();
        let bounds = Dop::<D, K>::pose(&pose);
        for _ in 0..PER_POSE {
            let tree = pick(trees.len());
            let index = pick(trees[tree].nodes().len());
            let node = &trees[tree].nodes()[index];
            outcome.nodes += 1;
            for (d, bound) in D::NORMALS.iter().zip(&bounds.along_a) {
                let (negated_low, high) = node.volume.interval(bound);
                let (direction, shift) = (rotation.tr_mul(d), d.dot(&pose.translation.vector));
                for corner in triangle::corners(trees[tree].triangles_of(node)) {
                    let x = direction.dot(&corner.coords) + shift;
                    assert!(x <= high && -x <= negated_low, "{K} directions: {x} not in [{}, {high}]", -negated_low);
                }
                let polytope = &corners[tree][index];
                let exact = exact_support(polytope, &direction) + exact_support(polytope, &-direction);
                if exact > 1e-3 {
                    let ratio = (high + negated_low) / exact;
                    assert!(ratio > 1.0 - 1e-6, "{K} directions: narrower than the polytope by {ratio}");
                    (sum, widths) = (sum + ratio, widths + 1);
                    outcome.width_max = outcome.width_max.max(ratio);
                }
            }
        }
    }
    outcome.width_mean = sum / f64::from(widths);
    outcome
}

fn duality(nodes: u32) -> [Outcome; 5] {
    [
        posed_nodes::<Dop6, 3>(nodes),
        posed_nodes::<Dop8, 4>(nodes),
        posed_nodes::<Dop14, 7>(nodes),
        posed_nodes::<Dop18, 9>(nodes),
        posed_nodes::<Dop26, 13>(nodes),
    ]
}

/// No bound is violated, and the bound by duality is only slightly wider than the exact extent of the rotated polytope. For a box, the
/// bound is exact: the three normals nearest to a direction belong to the corner that is extreme along it.
#[test]
fn no_bound_is_violated_on_a_tenth_of_a_million_posed_nodes() {
    let outcomes = duality(20_000);
    assert_eq!(outcomes.iter().map(|outcome| outcome.nodes).sum::<u32>(), 100_000);
    assert!((outcomes[0].width_max - 1.0).abs() < 1e-4, "{}", outcomes[0].width_max);
    let means = outcomes.map(|outcome| outcome.width_mean);
    assert!(means[1] < 1.35 && means[2..].iter().all(|mean| *mean < 1.35), "{means:?}");
}

/// `cargo test --release --lib volume::dop -- --ignored --nocapture`
#[test]
#[ignore = "a minute; the same with a million posed nodes of each polytope, and prints the widths"]
#[expect(clippy::print_stdout, reason = "its purpose")]
fn no_bound_is_violated_on_a_million_posed_nodes() {
    for (outcome, k) in duality(1_000_000).iter().zip([6, 8, 14, 18, 26]) {
        assert_eq!(outcome.nodes, 1_000_000);
        println!("{k}-DOP: width / exact width: mean {:.4}, max {:.4}", outcome.width_mean, outcome.width_max);
    }
}
