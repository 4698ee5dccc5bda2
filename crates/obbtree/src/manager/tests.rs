//! Managers against every pair of their objects.

use super::*;
use crate::cases::{Draw, meshes};
use crate::engine::geometry::GridMesh;
use crate::mesh::Mesh;
use nalgebra::Point3;
use std::ops::Range;

fn collider(mesh: &GridMesh, factor: f64) -> Collider {
    let vertices = mesh.vertices().iter().map(|p| p * factor);
    Collider::new(Mesh::new(vertices, mesh.faces().iter().copied()).unwrap())
}

fn colliders() -> Vec<Collider> {
    let [cube, torus, tool] =
        [meshes::cuboid(8.0, 5.0, 6.0), meshes::torus(6.0, 2.0, 12, 6), meshes::stepped_tool(8, 5)];
    vec![
        collider(&cube, 1.0),
        collider(&torus, 1.0),
        collider(&tool, 0.5),
        collider(&cube, 100.0),
        collider(&meshes::degenerate(), 0.3),
    ]
}

/// Objects strewn in a box of an edge of 90, of different shapes; number 0 is as large as all the rest.
fn strewn(seed: u64, numbers: Range<usize>) -> Manager {
    let mut draw = Draw::new(seed, &["manager"], 0);
    let colliders = colliders();
    let mut manager = Manager::new();
    for i in numbers {
        let kind = if i == 0 { 3 } else { [0, 1, 2, 4][i % 4] };
        let rotation = draw.rotation();
        let far = if kind == 3 { 600.0 } else { 0.0 };
        let middle = draw.in_ball() * 45.0 + nalgebra::Vector3::x() * far;
        manager
            .insert(format!("object {i}"), colliders[kind].clone(), Isometry3::from_parts(middle.into(), rotation))
            .unwrap();
    }
    manager
}

/// All pairs of one manager, or of two.
fn all_pairs<'a>(ours: &'a Manager, theirs: Option<&'a Manager>) -> Vec<([&'a str; 2], Pair, Isometry3<f64>)> {
    let mut pairs = Vec::new();
    for (a, x) in &ours.objects {
        for (b, y) in &theirs.unwrap_or(ours).objects {
            if theirs.is_some() || a < b && !ours.is_ignored(a, b) {
                let pose = x.world_from_object.inv_mul(&y.world_from_object);
                pairs.push(([a.as_str(), b.as_str()], Pair::new(&x.collider, &y.collider), pose));
            }
        }
    }
    pairs
}

fn brute_force<'a>(ours: &'a Manager, theirs: Option<&'a Manager>) -> (Vec<[&'a str; 2]>, Option<f64>) {
    let pairs = all_pairs(ours, theirs);
    let touching = pairs.iter().filter(|(_, pair, pose)| pair.collides(pose).unwrap()).map(|pair| pair.0).collect();
    let distance = |(_, pair, pose): &([&str; 2], Pair, Isometry3<f64>)| {
        pair.distance_below(pose, f64::INFINITY).unwrap().unwrap().distance
    };
    (touching, pairs.iter().map(distance).reduce(f64::min))
}

fn is_witnessed(manager: &Manager, name: &str, point: &Point3<f64>, face: u32) {
    let (collider, pose) = manager.get(name).unwrap();
    let corners = collider.mesh().triangle(face);
    let [p, q, r] = corners.map(|p| pose * p);
    let on = crate::engine::geometry::Triangle::new(p, q, r);
    assert!(crate::engine::geometry::triangle_distance::point_squared(point, &on).sqrt() < 1e-5, "{name}");
}

#[test]
fn a_manager_answers_as_every_pair_of_objects_does() {
    let (mut touching, mut apart, mut near_of_all) = (0, 0, [0, 0]);
    for seed in 0..40 {
        let mut manager = strewn(seed, 0..2 + seed as usize % 15);
        let names: Vec<String> = manager.names().map(str::to_owned).collect();
        if seed % 3 == 0 {
            manager.ignore(&names[1], &names[0]);
            manager.ignore(&names[0], "nobody");
        }
        let (pairs, distance) = brute_force(&manager, None);
        touching += u32::from(!pairs.is_empty());
        apart += u32::from(pairs.is_empty());
        assert_eq!(manager.colliding_pairs(), pairs);
        assert_eq!(manager.collides(), !pairs.is_empty());
        for reach in [0.0, 10.0] {
            let near = manager.near_pairs(reach);
            for (names, pair, pose) in all_pairs(&manager, None) {
                let is_near = pair.distance_below(&pose, reach).unwrap().is_some() || pairs.contains(&names);
                assert!(!is_near || near.contains(&names), "{reach} {names:?}");
            }
            near_of_all[usize::from(reach > 0.0)] += near.len();
        }
        let contacts = manager.contacts(3);
        assert!(contacts.iter().map(|contacts| contacts.names).eq(pairs.iter().copied()));
        for ObjectContacts { names, contacts } in &contacts {
            assert!((1..=3).contains(&contacts.len()));
            for contact in contacts {
                (0..2).for_each(|i| is_witnessed(&manager, names[i], &contact.point, contact.faces[i]));
            }
        }
        let nearest = manager.nearest().unwrap();
        assert_eq!(nearest.as_ref().map(|nearest| nearest.nearest.distance), distance);
        if let Some(NearestObjects { names, nearest }) = nearest {
            (0..2).for_each(|i| is_witnessed(&manager, names[i], &nearest.points[i], nearest.faces[i]));
            assert!(((nearest.points[0] - nearest.points[1]).norm() - nearest.distance).abs() < 1e-7);
        }
        for name in &names {
            let of_name = all_pairs(&manager, None).into_iter().filter(|(names, ..)| names.contains(&name.as_str()));
            let least =
                of_name.map(|(_, pair, pose)| pair.distance_below(&pose, f64::INFINITY).unwrap().unwrap().distance);
            let found = manager.nearest_to(name).unwrap();
            let expected = least.reduce(f64::min);
            // Seen from the other object of a pair, corners are rounded otherwise.
            match (found, expected) {
                (Some(found), Some(expected)) => {
                    assert_eq!(found.names[0], name);
                    assert!((found.nearest.distance - expected).abs() < 1e-6);
                }
                (found, expected) => assert!(found.is_none() && expected.is_none()),
            }
        }
    }
    assert!(touching > 8 && apart > 5, "{touching} {apart}");
    let all: usize = (0..40).map(|seed| 2 + seed % 15).map(|count| count * (count - 1) / 2).sum();
    assert!(near_of_all[0] < near_of_all[1] && near_of_all[1] < all / 2, "{near_of_all:?} of {all}");
}

/// Squares of such gaps are infinite, or zero.
#[test]
fn objects_of_any_size_are_as_near_as_they_are() {
    for unit in [1e150, 1.0, 1e-145] {
        let cube = collider(&meshes::cuboid(2.0, 2.0, 2.0), unit);
        let mut manager = Manager::new();
        for (name, x) in [("a", 0.0), ("b", 1e5), ("c", 2e4)] {
            manager.insert(name, cube.clone(), Isometry3::translation(x * unit, 0.0, 0.0)).unwrap();
        }
        assert_eq!(manager.near_pairs(1.9e4 * unit), Vec::<[&str; 2]>::new(), "{unit}");
        assert_eq!(manager.near_pairs(2.1e4 * unit), [["a", "c"]], "{unit}");
        let nearest = manager.nearest().unwrap().unwrap();
        assert_eq!(nearest.names, ["a", "c"], "{unit}");
        assert!((nearest.nearest.distance / (19_998.0 * unit) - 1.0).abs() < 1e-9, "{unit}: {nearest:?}");
    }
}

/// In the unit of a point, or of a mesh that is nearly a point, most other objects are far away.
#[test]
fn points_and_far_objects_leave_the_nearest_to_be_found() {
    let point = Collider::new(Mesh::new([[0.0; 3]], [[0, 0, 0]]).unwrap());
    let [cube, speck] = [1.0, 1e-13].map(|factor| collider(&meshes::cuboid(2.0, 2.0, 2.0), factor));
    let mut manager = Manager::new();
    for (name, collider, at) in
        [("a", &point, [0.0, 0.0]), ("b", &point, [5.0, 0.0]), ("c", &cube, [1e30, 0.0]), ("d", &speck, [0.0, 40.0])]
    {
        manager.insert(name, collider.clone(), Isometry3::translation(at[0], at[1], 0.0)).unwrap();
    }
    for (name, names, distance) in [("a", ["a", "b"], 5.0), ("d", ["d", "a"], 40.0), ("c", ["c", "a"], 1e30)] {
        let found = manager.nearest_to(name).unwrap().unwrap();
        assert!((found.nearest.distance / distance - 1.0).abs() < 1e-9, "{found:?}");
        assert!(found.names == names || name == "c", "{found:?}");
    }
    assert_eq!(manager.nearest().unwrap().unwrap().names, ["a", "b"]);
}

/// A ring around many small objects, whose box overlaps theirs all: neither its size nor its distance makes pairs of them wait.
#[test]
fn the_nearest_of_many_is_found_without_a_list_of_all_pairs() {
    let [ring, cube] =
        [meshes::torus(600.0, 10.0, 24, 8), meshes::cuboid(2.0, 2.0, 2.0)].map(|mesh| collider(&mesh, 1.0));
    let mut manager = Manager::new();
    manager.insert("ring", ring, Isometry3::identity()).unwrap();
    for i in 0..400 {
        let at = [i % 20, i / 20].map(|k| 30.0 * f64::from(k) - 285.0);
        manager.insert(format!("{i}"), cube.clone(), Isometry3::translation(at[0], at[1], 0.0)).unwrap();
    }
    manager.set_pose("137", Isometry3::translation(215.5, -105.0, 0.0)).unwrap();
    let (expected, items) = (manager.nearest().unwrap().unwrap(), manager.items());
    let (distance, longest) = (expected.nearest.distance, std::cell::Cell::new(0));
    let counted = |reach| {
        let pairs = manager.pairs(&items, reach);
        longest.set(longest.get().max(pairs.len()));
        pairs
    };
    let least = world::least_gap(&items, |_, _| true);
    assert_eq!(nearest(counted, least, &items, &items).unwrap(), Some(expected));
    assert!(distance < 28.0 && longest.get() < 5 * items.len(), "{distance} {}", longest.get());
}

#[test]
fn two_managers_answer_as_every_pair_of_objects_does() {
    let mut touching = 0;
    for seed in 0..20 {
        let (ours, theirs) = (strewn(seed, 0..3 + seed as usize % 9), strewn(100 + seed, 1..6));
        let (pairs, distance) = brute_force(&ours, Some(&theirs));
        touching += u32::from(!pairs.is_empty());
        assert_eq!(ours.colliding_pairs_with(&theirs), pairs);
        assert_eq!(ours.collides_with(&theirs), !pairs.is_empty());
        let near = ours.near_pairs_with(&theirs, 0.0);
        assert!(near.len() <= ours.len() * theirs.len() && pairs.iter().all(|pair| near.contains(pair)));
        assert!(ours.contacts_with(&theirs, 1).iter().map(|contacts| contacts.names).eq(pairs));
        assert_eq!(ours.nearest_with(&theirs).unwrap().map(|nearest| nearest.nearest.distance), distance);
        assert_eq!(ours.nearest_with(&Manager::new()), Ok(None));
    }
    assert!((5..20).contains(&touching), "{touching}");
}

#[test]
fn rows_of_poses_answer_as_moved_managers_do() {
    let manager = (0..).map(|seed| strewn(seed, 0..5)).find(|manager| !manager.collides()).unwrap();
    let names = ["object 2", "object 4"];
    let mut draw = Draw::new(9, &["rows"], 0);
    let rows: Vec<[Isometry3<f64>; 2]> = (0..200)
        .map(|_| [(); 2].map(|()| Isometry3::from_parts((draw.in_ball() * 40.0).into(), draw.rotation())))
        .collect();
    let verdicts = manager.collides_each(&names, &rows).unwrap();
    for (row, verdict) in rows.iter().zip(&verdicts) {
        let mut moved = manager.clone();
        for (name, pose) in names.iter().zip(row) {
            moved.set_pose(name, *pose).unwrap();
        }
        assert_eq!(moved.collides(), *verdict);
    }
    assert!(verdicts.contains(&true) && verdicts.contains(&false));
    assert_eq!(manager.collides_each(&["nobody"], &rows), Err(ManagerError::NoSuchObject("nobody".to_owned())));
    let error = manager.collides_each(&names[..1], &rows).unwrap_err();
    assert_eq!(error.to_string(), "row 0 has 2 poses for 1 objects");
    let mut rows = rows;
    rows[5][1].translation.x = f64::NAN;
    let error = manager.collides_each(&names, &rows).unwrap_err();
    assert_eq!(error.to_string(), "row 5, object `object 4`: the pose has a number that is not finite");
    let twice =
        manager.collides_each(&["object 2", "object 4", "object 2"], &[[Isometry3::identity(); 3]]).unwrap_err();
    assert_eq!(twice, ManagerError::NamedTwice("object 2".to_owned()));
    assert!(twice.to_string().contains("`object 2` is named twice"), "{twice}");
    assert_eq!(manager.collides_each(&[], &[[]; 2]), Ok(vec![manager.collides(); 2]));
}

/// Two objects are compared on one grid. A small object that passes a large one therefore needs a second tree in the unit of the large one's grid, a power
/// of two; one that stays far away needs none.
#[test]
fn trees_for_rows_of_poses_are_made_before_the_rows_are_asked() {
    let cube = meshes::cuboid(8.0, 5.0, 6.0);
    let [large, near, far] = [100.0, 1.0, 1.0].map(|factor| collider(&cube, factor));
    assert_ne!(large.frame().exponent, near.frame().exponent);
    let mut manager = Manager::new();
    for (name, collider, x) in [("a", &far, 1e4), ("b", &large, 0.0), ("c", &near, 1e5)] {
        manager.insert(name, collider.clone(), Isometry3::translation(x, 0.0, 0.0)).unwrap();
    }
    let (items, before) = (manager.items(), [&far, &near].map(Collider::bytes));
    let rows = [800.0, -800.0].map(|y| [Isometry3::translation(0.0, y, 0.0)]);
    manager.make_trees(&items, &[2], &rows[..0]);
    manager.make_trees(&items, &[2], &rows[..1]);
    assert_eq!([&far, &near].map(Collider::bytes), before);
    manager.make_trees(&items, &[2], &rows);
    let made = [&far, &near].map(Collider::bytes);
    assert!(made[0] == before[0] && made[1] > before[1], "{before:?} {made:?}");
    manager.ignore("b", "c");
    assert_eq!(manager.collides_each(&["c"], &rows), Ok(vec![false; 2]));
}

#[test]
fn objects_come_and_go() {
    let cube = collider(&meshes::cuboid(2.0, 2.0, 2.0), 1.0);
    let mut manager = Manager::new();
    assert!(manager.is_empty() && !manager.collides() && manager.nearest() == Ok(None));
    manager.insert("a", cube.clone(), Isometry3::identity()).unwrap();
    assert_eq!((manager.len(), manager.nearest(), manager.nearest_to("a")), (1, Ok(None), Ok(None)));
    manager.insert("b", cube.clone(), Isometry3::translation(1.0, 0.0, 0.0)).unwrap();
    assert_eq!(manager.colliding_pairs(), [["a", "b"]]);
    manager.ignore("b", "a");
    assert!(!manager.collides() && manager.nearest() == Ok(None) && manager.is_ignored("a", "b"));
    manager.consider("a", "b");
    assert!(manager.collides());
    manager.insert("b", cube.clone(), Isometry3::translation(5.0, 0.0, 0.0)).unwrap();
    assert_eq!(manager.nearest().unwrap().unwrap().nearest.distance, 3.0);
    manager.remove("b").unwrap();
    assert_eq!(manager.remove("b").unwrap_err().to_string(), "no object `b` in the manager");
    assert_eq!(manager.set_pose("b", Isometry3::identity()), Err(ManagerError::NoSuchObject("b".to_owned())));
    assert!(matches!(manager.nearest_to("b"), Err(ManagerError::NoSuchObject(_))));
    let far = manager.insert("c", cube.clone(), Isometry3::translation(1e302, 0.0, 0.0)).unwrap_err();
    let limit = power_of_two(1000);
    let text = format!("object `c`: the translation is above {limit:?} on one axis: too far for a distance");
    assert_eq!(far.to_string(), text);
    for x in [f64::NAN, f64::INFINITY, 1e303] {
        let error = manager.set_pose("a", Isometry3::translation(x, 0.0, 0.0)).unwrap_err();
        assert!(matches!(&error, ManagerError::Pose { name, .. } if name == "a"), "{error}");
        assert!(manager.insert("c", cube.clone(), Isometry3::translation(x, 0.0, 0.0)).is_err());
    }
    assert_eq!(manager.len(), 1);
    manager.insert("far", cube, Isometry3::translation(1e200, 0.0, 0.0)).unwrap();
    assert!(!manager.collides());
    assert!((manager.nearest().unwrap().unwrap().nearest.distance / 1e200 - 1.0).abs() < 1e-9);
}
