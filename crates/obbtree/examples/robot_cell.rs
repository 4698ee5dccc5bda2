//! A gripper above a table: which objects touch, how near the others are, and many places of the gripper at once.
//!
//! `cargo run --example robot_cell`

#![allow(clippy::print_stdout, reason = "an example prints what it finds")]

use obbtree::nalgebra::{Isometry3, Vector3};
use obbtree::{Collider, Manager, Mesh};

/// A box with the given edges, metres, about its middle.
fn cuboid(edges: [f64; 3]) -> Collider {
    let corner = |i: usize| [0, 1, 2].map(|k| edges[k] * if i >> k & 1 == 1 { 0.5 } else { -0.5 });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Collider::new(Mesh::new((0..8).map(corner), faces).expect("a box is a mesh"))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let finger = cuboid([0.02, 0.02, 0.1]);
    let mut cell = Manager::new();
    cell.insert("table", cuboid([1.2, 0.8, 0.05]), Isometry3::translation(0.0, 0.0, -0.025))?;
    cell.insert("part", cuboid([0.06, 0.06, 0.06]), Isometry3::translation(0.2, 0.1, 0.03))?;
    cell.insert("left finger", finger.clone(), Isometry3::translation(0.1605, 0.1, 0.08))?;
    cell.insert("right finger", finger, Isometry3::translation(0.2395, 0.1, 0.08))?;
    // The part is meant to stand on the table.
    cell.ignore("part", "table");

    for [first, second] in cell.colliding_pairs() {
        println!("{first} touches {second}");
    }
    for found in cell.contacts(1) {
        let contact = &found.contacts[0];
        println!("faces {:?} touch at {:.4}", contact.faces, contact.point);
    }

    // Lower both fingers step by step; all heights are answered on all cores.
    let lowered = |step: i32| {
        let down = Vector3::new(0.0, 0.0, -0.001 * f64::from(step));
        [0.155, 0.245].map(|x| Isometry3::from(Vector3::new(x, 0.1, 0.08) + down))
    };
    let heights: Vec<_> = (0..60).map(lowered).collect();
    let verdicts = cell.collides_each(&["left finger", "right finger"], &heights)?;
    match verdicts.iter().position(|&touching| touching) {
        Some(step) => println!("lowered by {step} mm, a finger touches"),
        None => println!("60 mm are free"),
    }

    cell.set_pose("left finger", heights[20][0])?;
    cell.set_pose("right finger", heights[20][1])?;
    if let Some(nearest) = cell.nearest_to("part")? {
        println!("{} is {:.4} m from the part", nearest.names[1], nearest.nearest.distance);
    }
    Ok(())
}
