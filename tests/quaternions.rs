//! Poses whose quaternion is not quite of unit length: every method that promises to miss nothing still misses nothing.

use bvbench::geometry::{Isometry, Mesh, Vector};
use bvbench::registry;
use bvbench::truth::PairOracle;
use nalgebra::{Quaternion, UnitQuaternion};
use obbtree::cases::meshes;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::sync::Arc;

/// Travel past first contact, mm.
const DEPTHS_MM: [f64; 3] = [1e-7, 1e-6, 1e-5];
const APPROACHES: u32 = 12;

/// The pose with every component of its quaternion multiplied.
fn scaled(pose: &Isometry, factor: f64) -> Isometry {
    let quaternion: Quaternion<f64> = *pose.rotation.quaternion() * factor;
    Isometry::from_parts(pose.translation, UnitQuaternion::new_unchecked(quaternion))
}

/// Poses just past first contact along random directions, at random orientations, quaternions scaled by `factor`.
fn poses(oracle: &PairOracle, factor: f64, random: &mut Pcg64) -> Vec<Isometry> {
    let mut poses = Vec::new();
    for _ in 0..APPROACHES {
        let mut vector = || Vector::from_fn(|_, _| random.random_range(-1.0..1.0f64));
        let (turn, direction) = (vector() * 3.0, vector().normalize());
        let rotation = UnitQuaternion::from_scaled_axis(turn);
        let (middle_a, middle_b) = (centre(oracle.mesh_a()), centre(oracle.mesh_b()));
        let at = |distance: f64| {
            let shift = middle_a + direction * distance - rotation * middle_b;
            scaled(&Isometry::from_parts(shift.into(), rotation), factor)
        };
        let (mut apart, mut touching) = (60.0, 0.0);
        for i in 0..120 {
            let distance = 60.0 - 0.5 * f64::from(i);
            if oracle.touches(&at(distance)) {
                touching = distance;
                break;
            }
            apart = distance;
        }
        for _ in 0..40 {
            let middle = f64::midpoint(apart, touching);
            if oracle.touches(&at(middle)) { touching = middle } else { apart = middle }
        }
        poses.extend(DEPTHS_MM.map(|depth| at(touching - depth)));
    }
    poses.retain(|pose| oracle.touches(pose));
    poses
}

fn centre(mesh: &Mesh) -> Vector {
    mesh.vertices().iter().map(|p| p.coords).sum::<Vector>() / mesh.vertices().len() as f64
}

#[test]
fn a_quaternion_a_little_too_long_or_short_hides_no_contact() {
    // Away from their origins, as parts of a machine are: there a stretched rotation moves the most.
    let far = |mesh: &Mesh, x: f64, y: f64| {
        let motion = Isometry::new(Vector::new(x, y, 800.0), Vector::new(0.7, 0.1 * x / y, -0.4));
        Arc::new(meshes::moved(mesh, 1.0, &motion))
    };
    let (a, b) =
        (far(&meshes::cuboid(12.0, 4.0, 8.0), 500.0, -300.0), far(&meshes::cuboid(9.0, 7.0, 5.0), -400.0, 900.0));
    let oracle = PairOracle::new(Arc::clone(&a), Arc::clone(&b));
    let mut random = Pcg64::seed_from_u64(21);
    let poses: Vec<Isometry> = [1.0 + 1e-7, 1.0 - 1e-7, 1.0 + 1e-6, 1.0 - 1e-6]
        .into_iter()
        .flat_map(|factor| poses(&oracle, factor, &mut random))
        .collect();
    assert!(poses.len() > 100, "{} poses touch", poses.len());
    let mut missed = Vec::new();
    for variant in registry::standard().variants().iter().filter(|variant| variant.info.safe) {
        let (model_a, model_b) = (variant.prepare(&a, None), variant.prepare(&b, None));
        let mut verdicts = Vec::new();
        model_a.first(&*model_b, &poses, &mut verdicts);
        let count = verdicts.iter().filter(|&&touching| !touching).count();
        let counted = poses.iter().filter(|pose| !model_a.first_counted(&*model_b, pose).0).count();
        if count + counted > 0 {
            missed.push(format!("{} misses {count}, counting {counted}, of {}", variant.info.id, poses.len()));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
