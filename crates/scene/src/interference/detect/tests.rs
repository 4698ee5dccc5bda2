//! Tests that compare the searches with one another, with known depths, and (in safe mode) with the exact ground truth.

use super::super::{Body, Division, Samples, SecondLevel, Tool};
use super::*;
use crate::geometry::Mesh;
use crate::truth::PairOracle;
use obbtree::cases::meshes;
use std::sync::Arc;

fn tool() -> Tool {
    Tool {
        bodies: vec![
            Body { kind: BodyKind::Cutter, profile: Profile::bull_nose(2.0, 0.5, 6.0).unwrap() },
            Body { kind: BodyKind::Shank, profile: Profile::cone(2.0, 3.0, 4.0).unwrap().raised(6.0) },
            Body { kind: BodyKind::Holder, profile: Profile::cylinder(5.0, 6.0).unwrap().raised(10.0) },
        ],
    }
}

fn surface(spacing: f64) -> (Mesh, SurfaceOctree) {
    let mesh = meshes::torus(12.0, 4.0, 40, 20);
    let octree = SurfaceOctree::new(Samples::of(&mesh, spacing), Division { cap: 8, depth: 10 }, &|_| false);
    (mesh, octree)
}

/// Poses from free over grazing to deep, in all directions.
fn poses() -> Vec<Isometry> {
    (0..400)
        .map(|k| {
            let k = f64::from(k);
            let turn = Vector::new(1.3 * (0.37 * k).sin(), 1.1 * (0.53 * k).cos(), 0.2 * k);
            let pose = Isometry::new(Vector::zeros(), turn);
            let at = Point::new(12.0 * (0.05 * k).cos(), 12.0 * (0.05 * k).sin(), 4.5 + 3.0 * (0.29 * k).sin());
            // The tip near that place.
            Isometry::from_parts((-(pose * at).coords).into(), pose.rotation)
        })
        .collect()
}

const NONE: Allowance = Allowance { gouge_mm: 0.0, clearance_mm: 0.0 };

#[test]
fn all_searches_and_levels_say_what_the_points_say() {
    let (_, surface) = surface(0.7);
    let tool = tool();
    for allowance in [NONE, Allowance { gouge_mm: 0.3, clearance_mm: 1.5 }] {
        let plain = BoxedTool::new(tool.clone(), SecondLevel::None);
        let points = Detector::new(&surface, &plain, allowance, false, Search::Points);
        let (mut hits, mut global) = (0, 0);
        for level in SecondLevel::ALL {
            let boxed = BoxedTool::new(tool.clone(), level);
            for search in [Search::Leaves, Search::Octree] {
                let detector = Detector::new(&surface, &boxed, allowance, false, search);
                let mut coherence = Coherence::default();
                for pose in poses() {
                    let (mut by_points, mut counts, mut warm) =
                        (Counts::default(), Counts::default(), Counts::default());
                    let expected = points.deepest(&pose, &mut by_points);
                    // Of equally deep places either may be told.
                    let depths = |hits: &[Hit]| hits.iter().map(|hit| (hit.body, hit.depth_mm)).collect::<Vec<_>>();
                    assert_eq!(depths(&detector.deepest(&pose, &mut counts)), depths(&expected));
                    assert_eq!(detector.first(&pose, None, &mut counts).is_some(), !expected.is_empty());
                    assert_eq!(detector.first(&pose, Some(&mut coherence), &mut warm).is_some(), !expected.is_empty());
                    assert_eq!(by_points.points, (surface.points().len() * 3) as u64);
                    hits += usize::from(!expected.is_empty());
                    global += expected.iter().filter(|hit| !hit.body.is_local()).count();
                }
            }
        }
        assert!(hits > 800 && hits < 2800 && global > 20, "{hits}, {global}");
    }
}

#[test]
fn a_known_gouge_has_its_depth_and_a_known_holder_its_clearance() {
    let samples = Samples { points: vec![Point::origin()], faces: vec![7], covering_mm: 0.25, spacing_mm: 0.4 };
    let surface = SurfaceOctree::new(samples, Division::default(), &|_| false);
    let tool = BoxedTool::new(tool(), SecondLevel::Profile4);
    let depths = |x: f64, z: f64, allowance: Allowance, safe: bool| {
        let detector = Detector::new(&surface, &tool, allowance, safe, Search::Octree);
        let found = detector.deepest(&Isometry::translation(x, 0.0, z), &mut Counts::default());
        found.into_iter().map(|hit| (hit.body, (hit.depth_mm * 1e9).round() / 1e9, hit.face)).collect::<Vec<_>>()
    };
    // The point 0.05 above the tip, on the axis.
    assert_eq!(depths(0.0, 0.05, NONE, false), [(BodyKind::Cutter, 0.05, 7)]);
    assert_eq!(depths(0.0, 0.05, Allowance { gouge_mm: 0.06, clearance_mm: 0.0 }, false), []);
    assert_eq!(depths(0.0, -0.05, NONE, false), []);
    // The covering radius of 0.25, and the slack.
    assert_eq!(depths(0.0, -0.05, NONE, true), [(BodyKind::Cutter, 0.2 + SLACK_MM, 7)]);
    // Beside the holder at its middle height, 1 mm away.
    assert_eq!(depths(6.0, 13.0, NONE, false), []);
    assert_eq!(depths(6.0, 13.0, Allowance { gouge_mm: 0.0, clearance_mm: 1.5 }, false), [(BodyKind::Holder, 0.5, 7)]);
}

/// The tool as a mesh, inscribed in its profiles: wherever that mesh touches the surface, safe mode must report interference.
#[test]
fn safe_mode_misses_no_contact_of_the_meshes() {
    let (mesh, surface) = surface(1.5);
    let tool = tool();
    let outline = [
        [0.0, 0.0],
        [1.5, 0.0],
        [1.85, 0.15],
        [2.0, 0.5],
        [2.0, 6.0],
        [3.0, 10.0],
        [5.0, 10.0],
        [5.0, 16.0],
        [0.0, 16.0],
    ];
    let tool_mesh = crate::geometry::shapes::Shape::Revolve(crate::geometry::shapes::Revolve {
        profile_mm: outline.map(crate::geometry::shapes::outline::OutlinePoint::Sharp).to_vec(),
    })
    .mesh(&crate::geometry::shapes::Tessellation::default())
    .unwrap();
    let oracle = PairOracle::new(Arc::new(tool_mesh), Arc::new(mesh));
    let tool = BoxedTool::new(tool, SecondLevel::Axial4);
    let safe = Detector::new(&surface, &tool, NONE, true, Search::Octree);
    let mut touching = 0;
    for pose in poses() {
        if oracle.touches(&pose) {
            touching += 1;
            assert!(safe.first(&pose, None, &mut Counts::default()).is_some());
        }
    }
    assert!(touching > 50, "{touching}");
}

#[test]
fn the_least_distance_is_that_of_all_points() {
    let (_, surface) = surface(0.7);
    let tool = BoxedTool::new(tool(), SecondLevel::None);
    let allowance = Allowance { gouge_mm: 0.1, clearance_mm: 0.5 };
    let detector = Detector::new(&surface, &tool, allowance, false, Search::Octree);
    let (mut counts, mut near) = (Counts::default(), 0);
    for pose in poses() {
        let of_body = |place: &P2| detector.bodies.iter().map(|b| -b.depth_mm(place)).fold(f64::INFINITY, f64::min);
        let of_point = |p: &Point| of_body(&half_plane(&(pose * p).coords));
        let expected = surface.points().iter().map(of_point).fold(f64::INFINITY, f64::min);
        let found = detector.least_mm(&pose, f64::INFINITY, &mut counts);
        assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
        let below = detector.least_mm(&pose, 0.3, &mut counts);
        assert!((below - expected.min(0.3)).abs() < 1e-9);
        near += usize::from(expected < 0.3);
    }
    assert!(near > 50 && near < 350, "{near}");
    // Two questions at 400 poses, 3 bodies.
    assert!(counts.points < 800 * 3 * surface.points().len() as u64 / 10, "{counts:?}");
}

#[test]
fn between_samples_only_the_safe_mode_sees() {
    // A ball of 1 mm through the middle of a triangle that is known by its corners, 5.8 mm away.
    let [a, b, c] = [[0.0, 0.0], [10.0, 0.0], [5.0, 75f64.sqrt()]].map(|[x, y]| Point::new(x, y, 0.0));
    let mesh = Mesh::from_triangles(&[crate::geometry::Triangle::new(a, b, c)]).unwrap();
    let surface = SurfaceOctree::new(Samples::of(&mesh, 20.0), Division::default(), &|_| false);
    let ball = Tool { bodies: vec![Body { kind: BodyKind::Cutter, profile: Profile::ball(1.0, 5.0).unwrap() }] };
    let ball = BoxedTool::new(ball, SecondLevel::None);
    let pose = Isometry::translation(-5.0, -75f64.sqrt() / 3.0, 0.5);
    let sees = |safe| {
        let detector = Detector::new(&surface, &ball, NONE, safe, Search::Octree);
        detector.first(&pose, None, &mut Counts::default()).is_some()
    };
    assert!(!sees(false) && sees(true));
}

#[test]
fn the_hierarchy_and_coherence_save_tests() {
    let (_, surface) = surface(0.5);
    let tool = BoxedTool::new(tool(), SecondLevel::None);
    let cost = |search, coherent: bool| {
        let detector = Detector::new(&surface, &tool, NONE, false, search);
        let (mut counts, mut coherence) = (Counts::default(), Coherence::default());
        for k in 0..200 {
            // Slowly along the surface, in contact all the way.
            let pose = Isometry::translation(-12.0 - 0.01 * f64::from(k), 0.0, -3.5);
            detector.first(&pose, coherent.then_some(&mut coherence), &mut counts);
        }
        counts
    };
    let (flat, tree, warm) = (cost(Search::Leaves, false), cost(Search::Octree, false), cost(Search::Octree, true));
    assert!(flat.box_tests() > 5 * tree.box_tests(), "{flat:?} {tree:?}");
    assert!(tree.box_tests() > 2 * warm.box_tests() && warm.recalled > 190, "{tree:?} {warm:?}");
}
