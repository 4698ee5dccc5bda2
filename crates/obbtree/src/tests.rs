//! Colliders against the engine and against every pair of triangles; the same data at other scales and places.

use crate::cases::{Cases, Draw, meshes};
use crate::engine::geometry::grid::Placement;
use crate::engine::geometry::{GridMesh, Triangle, exact, triangle_distance};
use crate::mesh::power_of_two;
use crate::pair::Pair;
use crate::{Collider, Contact, Mesh, Nearest, Path, PoseError};
use nalgebra::{Isometry3, Point3, Vector3};

fn collider(mesh: &GridMesh) -> Collider {
    scaled(mesh, 1.0, Vector3::zeros())
}

/// Every vertex multiplied by a power of two, and then moved.
fn scaled(mesh: &GridMesh, factor: f64, offset: Vector3<f64>) -> Collider {
    let vertices = mesh.vertices().iter().map(|p| p * factor + offset);
    Collider::new(Mesh::new(vertices, mesh.faces().iter().copied()).unwrap())
}

/// The pairs of faces that touch, sorted, and the least distance: by the exact test on every pair of triangles as the engine holds them.
fn brute_force(a: &Collider, b: &Collider, a_from_b: &Isometry3<f64>) -> (Vec<[u32; 2]>, f64) {
    let exponent = a.frame().exponent.max(b.frame().exponent);
    let pose = Pair::new(a, b).seen(a_from_b).unwrap().unwrap();
    let placement = Placement::new(&pose);
    let triangles = |of: &Collider| -> Vec<Triangle> {
        let corner =
            |p: &Point3<f64>| of.frame().seen(p, exponent).map(|x| (x * 67_108_864.0).round_ties_even() / 67_108_864.0);
        (0..of.mesh().faces().len() as u32)
            .map(|face| Triangle { corners: of.mesh().triangle(face).each_ref().map(corner) })
            .collect()
    };
    let moved: Vec<Triangle> = triangles(b).iter().map(|t| placement.triangle(t)).collect();
    let (mut contacts, mut least) = (Vec::new(), f64::INFINITY);
    for (still, i) in triangles(a).iter().zip(0..) {
        for (moved, j) in moved.iter().zip(0..) {
            if exact::touch(still, moved) {
                contacts.push([i, j]);
                least = 0.0;
            } else {
                least = least.min(triangle_distance::squared(still, moved).sqrt());
            }
        }
    }
    (contacts, least * power_of_two(exponent))
}

/// The least distance of a point from a mesh.
fn off(point: &Point3<f64>, mesh: &Mesh) -> f64 {
    let distance = |face| triangle_distance::point_squared(point, &Triangle { corners: mesh.triangle(face) }).sqrt();
    (0..mesh.faces().len() as u32).map(distance).fold(f64::INFINITY, f64::min)
}

/// Points lie on the meshes and are as far apart as the distance says, within a millionth of a millionth of the size and the grid.
fn is_witnessed(nearest: &Nearest, a: &Collider, b: &Collider, a_from_b: &Isometry3<f64>) {
    let reach = |collider: &Collider| collider.mesh().bounds().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let size = reach(a) + reach(b) + a_from_b.translation.vector.amax();
    let tolerance = size * power_of_two(-28);
    let [p, q] = nearest.points;
    assert!(((p - q).norm() - nearest.distance).abs() <= 1e-10 * size, "{nearest:?}");
    assert!(off(&p, a.mesh()) <= tolerance, "{nearest:?}");
    assert!(off(&a_from_b.inverse_transform_point(&q), b.mesh()) <= tolerance, "{nearest:?}");
    let faces = [(a, p), (b, a_from_b.inverse_transform_point(&q))];
    for ((of, point), face) in faces.into_iter().zip(nearest.faces) {
        let on = Triangle { corners: of.mesh().triangle(face) };
        assert!(triangle_distance::point_squared(&point, &on).sqrt() <= tolerance, "{nearest:?}");
    }
}

#[test]
fn answers_are_those_of_the_engine_and_of_every_pair_of_triangles() {
    let cases = Cases::new();
    let colliders: Vec<Collider> = cases.subjects.iter().map(|subject| collider(&subject.mesh)).collect();
    let (mut touching, mut at_home, mut elsewhere) = (0, 0, 0);
    for case in cases.cases.iter().step_by(3) {
        let (a, b, pose) = (&colliders[case.a], &colliders[case.b], &case.a_from_b);
        let (contacts, distance) = brute_force(a, b, pose);
        let exponent = a.frame().exponent.max(b.frame().exponent);
        if exponent == 0 {
            let engine: Vec<[u32; 2]> = case.contacts.iter().map(|&(i, j)| [i, j]).collect();
            assert_eq!(contacts, engine, "{case:?}");
        }
        *if exponent == 0 { &mut at_home } else { &mut elsewhere } += 1;
        touching += u32::from(!contacts.is_empty());
        assert_eq!(a.collides(b, pose), Ok(!contacts.is_empty()), "{case:?}");
        let found = a.contacts(b, pose, usize::MAX).unwrap();
        assert_eq!(found.iter().map(|contact| contact.faces).collect::<Vec<_>>(), contacts);
        for limit in [0, 1, 5] {
            let some = a.contacts(b, pose, limit).unwrap();
            assert_eq!(some.len(), limit.min(contacts.len()));
            assert!(
                some.is_sorted_by_key(|contact| contact.faces) && some.iter().all(|contact| found.contains(contact))
            );
        }
        let nearest = a.distance(b, pose).unwrap();
        assert_eq!(nearest.distance, distance, "{case:?}");
        is_witnessed(&nearest, a, b, pose);
        for contact in &found {
            is_witnessed(&Nearest { distance: 0.0, points: [contact.point; 2], faces: contact.faces }, a, b, pose);
        }
        assert_eq!(a.distance_below(b, pose, distance), Ok(None));
        assert_eq!(
            a.distance_below(b, pose, 2.0 * distance).unwrap().map(|found| found.distance),
            (distance > 0.0).then_some(distance)
        );
    }
    assert!(touching > 100 && at_home > 200 && elsewhere > 30, "{touching} {at_home} {elsewhere}");
}

/// Everything that queries say about a pair.
#[derive(Debug, PartialEq)]
struct Answers {
    touching: bool,
    contacts: Vec<Contact>,
    nearest: Nearest,
}

/// With lengths divided by a factor.
fn answers(a: &Collider, b: &Collider, pose: &Isometry3<f64>, factor: f64) -> Answers {
    let mut nearest = a.distance(b, pose).unwrap();
    (nearest.distance, nearest.points) = (nearest.distance / factor, nearest.points.map(|p| p / factor));
    let mut contacts = a.contacts(b, pose, usize::MAX).unwrap();
    contacts.iter_mut().for_each(|contact| contact.point /= factor);
    Answers { touching: a.collides(b, pose).unwrap(), contacts, nearest }
}

fn stretched(pose: &Isometry3<f64>, factor: f64) -> Isometry3<f64> {
    Isometry3::from_parts((pose.translation.vector * factor).into(), pose.rotation)
}

#[test]
fn answers_do_not_depend_on_the_unit() {
    let cases = Cases::new();
    let factors = [-480, -104, -24, 8, 32, 200, 440].map(power_of_two);
    for case in cases.cases.iter().step_by(61) {
        let (a, b) = cases.meshes(case);
        let expected = answers(&collider(a), &collider(b), &case.a_from_b, 1.0);
        for factor in factors {
            let [a, b] = [a, b].map(|mesh| scaled(mesh, factor, Vector3::zeros()));
            assert_eq!(answers(&a, &b, &stretched(&case.a_from_b, factor), factor), expected, "{factor} {case:?}");
        }
    }
}

/// Coordinates of few digits lie on the grid at every scale and every place: nothing is rounded, so that nothing may change.
#[test]
fn answers_do_not_depend_on_any_power_of_two_nor_on_the_place_of_the_origin() {
    let [a, b] = [meshes::cuboid(20.0, 12.0, 5.0), meshes::cuboid(3.0, 2.0, 7.0)];
    let mut draw = Draw::new(0, &["face", "scales"], 0);
    let mut touching = 0;
    for round in 0..300 {
        let pose = Isometry3::from(draw.in_ball().map(|x| (x * 15.0).round()));
        let (plain_a, plain_b) = (collider(&a), collider(&b));
        let expected = answers(&plain_a, &plain_b, &pose, 1.0);
        touching += u32::from(expected.touching);
        let factor = power_of_two(round % 120 - 60);
        let [large_a, large_b] = [&a, &b].map(|mesh| scaled(mesh, factor, Vector3::zeros()));
        assert_eq!(answers(&large_a, &large_b, &stretched(&pose, factor), factor), expected, "{factor} {pose}");
        // Both origins far away, each in a direction of its own: the pose makes up for it.
        let [to_a, to_b] = [(); 2].map(|()| draw.in_ball().map(|x| (x * 1e12).round()));
        let [far_a, far_b] = [scaled(&a, 1.0, to_a), scaled(&b, 1.0, to_b)];
        let far = Isometry3::from(pose.translation.vector + to_a - to_b);
        let found = answers(&far_a, &far_b, &far, 1.0);
        assert_eq!(found.touching, expected.touching, "{to_a} {to_b} {pose}");
        assert_eq!(found.nearest.distance, expected.nearest.distance, "{to_a} {to_b} {pose}");
        let faces = |answers: &Answers| answers.contacts.iter().map(|contact| contact.faces).collect::<Vec<_>>();
        assert_eq!(faces(&found), faces(&expected), "{to_a} {to_b} {pose}");
    }
    assert!((50..250).contains(&touching), "{touching}");
}

#[test]
fn meshes_of_very_different_size_meet_exactly() {
    let (large, small) =
        (scaled(&meshes::cuboid(16.0, 16.0, 16.0), 1e5, Vector3::zeros()), collider(&meshes::cuboid(2.0, 2.0, 2.0)));
    assert_ne!(large.frame().exponent, small.frame().exponent);
    for (gap, touching) in [(0.0, true), (-0.5, true), (0.25, false), (2.0, false), (-3.0, false)] {
        let pose = Isometry3::translation(8e5 + 1.0 + gap, 13.0, -7.0);
        assert_eq!(large.collides(&small, &pose), Ok(touching), "{gap}");
        assert_eq!(small.collides(&large, &pose.inverse()), Ok(touching), "{gap}");
        let distance = if touching {
            0.0
        } else if gap < 0.0 {
            -gap - 2.0
        } else {
            gap
        };
        assert_eq!(large.distance(&small, &pose).unwrap().distance, distance);
    }
    let alone = collider(&meshes::cuboid(2.0, 2.0, 2.0));
    assert!(small.bytes() > alone.bytes(), "both trees count: {} {}", small.bytes(), alone.bytes());
}

/// A point is on the finest of all grids, and what is nearly a point on a fine one: most distances are far in units of these.
#[test]
fn meshes_of_hardly_any_extent_have_a_distance_at_any_pose() {
    let point = Collider::new(Mesh::new([[0.0; 3]], [[0, 0, 0]]).unwrap());
    assert_eq!(point.distance(&point, &Isometry3::identity()).unwrap().distance, 0.0);
    let half_widths = [0.0, 1e-60, 1e-13, 1.0];
    let cube = |half_width| scaled(&meshes::cuboid(2.0, 2.0, 2.0), half_width, Vector3::zeros());
    let subjects = half_widths.map(|half| (half, if half > 0.0 { cube(half) } else { point.clone() }));
    for ((of_a, a), (of_b, b)) in subjects.iter().flat_map(|a| subjects.iter().map(move |b| (a, b))) {
        let mut path = Path::new(a, b);
        for gap in [1e-120, 1.0, 17.0, 1e6, 1e30, 1e100] {
            let way = of_a + of_b + gap;
            let pose = Isometry3::translation(0.0, way, 0.0);
            let nearest = a.distance(b, &pose).unwrap();
            assert!((nearest.distance - gap).abs() <= 1e-9 * way, "{of_a} {of_b} {gap}: {nearest:?}");
            is_witnessed(&nearest, a, b, &pose);
            // Another pair of triangles may be as near, and its distance round to the next number.
            let kept = path.distance(&pose).unwrap().distance;
            assert!((kept - nearest.distance).abs() <= f64::EPSILON * way, "{kept} {nearest:?}");
            assert_eq!(a.distance_each(b, &[pose]).unwrap(), [nearest]);
            assert_eq!(a.distance_below(b, &pose, nearest.distance), Ok(None));
        }
    }
}

/// Small faces of meshes that reach far: the grid, not the face, says how wrong a distance may be.
#[test]
fn distances_of_small_faces_are_right_within_the_grid_of_a_large_mesh() {
    let mut draw = Draw::new(0, &["face", "grid"], 0);
    for reach in [3.9e3, 1.04e6, 1.1e6] {
        let (bound, mut worst) = (power_of_two(-28) * reach, 0.0_f64);
        for _ in 0..100 {
            let at = draw.in_ball();
            let (low, high) = (at.x, at.x + 0.1 + at.y.abs());
            let small = |z: f64| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
            let far = [[reach, 0.0, 0.0], [reach, 1.0, 0.0], [reach, 0.0, 1.0]];
            let a = Mesh::new(small(low).into_iter().chain(far), [[0, 1, 2], [3, 4, 5]]).unwrap();
            let [a, b] = [a, Mesh::new(small(high), [[0, 1, 2]]).unwrap()].map(Collider::new);
            let nearest = a.distance(&b, &Isometry3::identity()).unwrap();
            assert_eq!(nearest.faces, [0, 0]);
            worst = worst.max((nearest.distance - (high - low)).abs());
        }
        assert!(worst < bound, "{reach}: {worst} of {bound}");
        assert!(worst > 4e-11 * 3.0, "{reach}: the faces alone do not say {worst}");
    }
}

/// The face and the point of the engine's test: apart, by less than rounding leaves.
#[test]
fn a_distance_is_zero_where_meshes_touch_and_only_there_in_any_unit() {
    let (step, k) = (power_of_two(-26), power_of_two(36));
    let face = [[0.0; 3], [2048.0, 0.0, 0.0], [0.0, (2.0 * k + 1.0) * step, (2.0 * k + 3.0) * step]];
    for unit in [-496, -8, 0, 480].map(power_of_two) {
        let mesh = |corners: [[f64; 3]; 3]| {
            Collider::new(Mesh::new(corners.map(|corner| corner.map(|x| x * unit)), [[0, 1, 2]]).unwrap())
        };
        let (a, b) = (mesh(face), mesh([[512.0, k * step, (k + 1.0) * step]; 3]));
        let still = Isometry3::identity();
        assert_eq!(a.collides(&b, &still), Ok(false), "{unit}");
        let nearest = a.distance(&b, &still).unwrap();
        assert!(nearest.distance >= f64::MIN_POSITIVE, "{unit}: {nearest:?}");
        for limit in [5e-324, f64::MIN_POSITIVE, nearest.distance] {
            assert_eq!(a.distance_below(&b, &still, limit), Ok(None), "{unit} {limit}");
            assert_eq!(a.distance_below(&a, &still, limit).unwrap().map(|found| found.distance), Some(0.0), "{limit}");
        }
        for limit in [0.0, -1.0, f64::NAN] {
            assert_eq!(a.distance_below(&a, &still, limit), Ok(None), "{limit}");
        }
    }
}

#[test]
fn bad_poses_are_refused() {
    let cube = collider(&meshes::cuboid(2.0, 2.0, 2.0));
    for value in [f64::NAN, f64::INFINITY] {
        let pose = Isometry3::translation(value, 0.0, 0.0);
        assert_eq!(cube.collides(&cube, &pose), Err(PoseError::NotFinite));
        assert_eq!(cube.contacts(&cube, &pose, 9), Err(PoseError::NotFinite));
        assert_eq!(cube.distance(&cube, &pose), Err(PoseError::NotFinite));
        assert_eq!(Path::new(&cube, &cube).collides(&pose), Err(PoseError::NotFinite));
        let poses = [Isometry3::identity(), pose, pose];
        assert_eq!(
            cube.collides_each(&cube, &poses).unwrap_err().to_string(),
            "pose 1: the pose has a number that is not finite"
        );
        assert_eq!(cube.distance_each(&cube, &poses).unwrap_err().index, 1);
    }
    // Far away nothing touches, whatever the place; a distance has its limit, and the error names it.
    let limit = power_of_two(1022);
    for far in [1e15, 1e30, 1e300, limit, f64::MAX] {
        let pose = Isometry3::translation(0.0, far, 0.0);
        assert_eq!(cube.collides(&cube, &pose), Ok(false));
        assert_eq!(cube.contacts(&cube, &pose, 9), Ok(vec![]));
        let distance = cube.distance(&cube, &pose).map(|nearest| nearest.distance);
        assert!(far > limit || distance.is_ok_and(|distance| (distance / far - 1.0).abs() < 1e-9), "{far}");
    }
    let error = cube.distance(&cube, &Isometry3::translation(0.0, 1.01 * limit, 0.0)).unwrap_err();
    assert_eq!(error, PoseError::TooFar { limit });
    assert!(error.to_string().contains(&format!("{limit:?}")), "{error}");
}

#[test]
fn paths_and_batches_answer_as_single_queries_do() {
    let [torus, tool] = [meshes::torus(12.0, 4.0, 40, 20), meshes::stepped_tool(20, 10)].map(|mesh| collider(&mesh));
    let at = |y: f64, turn: f64| Isometry3::new(Vector3::new(0.0, y, 1.0), Vector3::new(0.3, turn, -0.2));
    let is_last = |y: &f64| torus.collides(&tool, &at(*y, 0.0)).unwrap();
    let touching = (0..600).rev().map(|i| 0.1 * f64::from(i)).find(is_last).unwrap();
    for (step, turn) in [(0.01, 0.0), (0.05, 0.003), (0.4, 0.05)] {
        let poses: Vec<Isometry3<f64>> =
            (0..600).map(|i| f64::from(i - 300)).map(|i| at(touching + step * i, turn * i)).collect();
        let single: Vec<bool> = poses.iter().map(|pose| torus.collides(&tool, pose).unwrap()).collect();
        assert!(single.contains(&true) && single.contains(&false), "{step}");
        let mut path = Path::new(&torus, &tool);
        let along: Vec<bool> = poses.iter().map(|pose| path.collides(pose).unwrap()).collect();
        assert_eq!(along, single);
        assert_eq!(torus.collides_each(&tool, &poses).unwrap(), single);
        let distances = torus.distance_each(&tool, &poses).unwrap();
        for (pose, batch) in poses.iter().zip(&distances) {
            let nearest = torus.distance(&tool, pose).unwrap();
            assert_eq!(nearest, *batch);
            let along = path.distance(pose).unwrap();
            assert_eq!(along.distance, nearest.distance);
            is_witnessed(&along, &torus, &tool, pose);
        }
    }
}
