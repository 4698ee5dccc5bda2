//! A cutter along a path above a workpiece: the first collision and the least clearance, with the help of the pose before.
//!
//! `cargo run --example tool_path`

#![allow(clippy::print_stdout, reason = "an example prints what it finds")]

use obbtree::nalgebra::Isometry3;
use obbtree::{Collider, Mesh, Path};
use std::f64::consts::TAU;

/// A closed cylinder, millimetres, upwards from the origin.
fn cylinder(radius: f64, height: f64, sides: u32) -> Result<Collider, obbtree::MeshError> {
    let around = |z: f64| {
        (0..sides).map(move |i| {
            let (sine, cosine) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
            [radius * cosine, radius * sine, z]
        })
    };
    let vertices = around(0.0).chain(around(height)).chain([[0.0, 0.0, 0.0], [0.0, 0.0, height]]);
    let faces = (0..sides).flat_map(|i| {
        let (j, bottom, top) = ((i + 1) % sides, 2 * sides, 2 * sides + 1);
        [[i, j, sides + j], [i, sides + j, sides + i], [j, i, bottom], [sides + i, sides + j, top]]
    });
    Ok(Collider::new(Mesh::new(vertices, faces)?))
}

/// A wavy surface of squares of 1 mm, 100 mm by 100 mm.
fn workpiece() -> Result<Collider, obbtree::MeshError> {
    let height = |i: u32, j: u32| 3.0 * (f64::from(i) * 0.1).sin() * (f64::from(j) * 0.07).cos();
    let vertices = (0..=100).flat_map(|i| (0..=100).map(move |j| [f64::from(i), f64::from(j), height(i, j)]));
    let faces = (0..100).flat_map(|i| {
        (0..100).flat_map(move |j| {
            let corner = 101 * i + j;
            [[corner, corner + 101, corner + 102], [corner, corner + 102, corner + 1]]
        })
    });
    Ok(Collider::new(Mesh::new(vertices, faces)?))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (workpiece, cutter) = (workpiece()?, cylinder(4.0, 40.0, 32)?);
    // Steps of 0.05 mm along a slope that ends in the workpiece.
    let poses: Vec<Isometry3<f64>> =
        (0..1800).map(|i| 0.05 * f64::from(i)).map(|s| Isometry3::translation(5.0 + s, 50.0, 6.0 - 0.08 * s)).collect();

    let mut path = Path::new(&workpiece, &cutter);
    let mut least = f64::INFINITY;
    for (number, pose) in poses.iter().enumerate() {
        if path.collides(pose)? {
            let contacts = workpiece.contacts(&cutter, pose, 100)?;
            println!("pose {number}: the first contact, {} pairs of triangles", contacts.len());
            break;
        }
        if number % 20 == 0 {
            least = least.min(path.distance(pose)?.distance);
        }
    }
    println!("least clearance before: {least:.3} mm");

    // Where the order does not matter, all cores answer.
    let verdicts = workpiece.collides_each(&cutter, &poses)?;
    println!("{} of {} poses collide", verdicts.iter().filter(|&&touching| touching).count(), verdicts.len());
    Ok(())
}
