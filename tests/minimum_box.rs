//! How small boxes are: the smallest box against bodies whose smallest box is known, against every other box, and DiTO's
//! and the covariances' loss against it.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use bvbench::geometry::{Isometry, Point, Triangle, Vector, triangle};
use bvbench::scene::Scene;
use bvbench::volume::aabb::Aabb;
use bvbench::volume::obb_area::ObbArea;
use bvbench::volume::obb_dito14::ObbDito14;
use bvbench::volume::obb_hull_area::ObbHullArea;
use bvbench::volume::obb_min::ObbMin;
use bvbench::volume::obb_vertex::ObbVertex;
use bvbench::volume::{BoundingVolume, Solid};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion};
use obbtree::cases::meshes;

/// A body by its corners, and the volume of its smallest box, mm³.
struct Body {
    name: &'static str,
    corners: Vec<Vector>,
    smallest: f64,
}

fn cuboid(x: f64, y: f64, z: f64) -> Vec<Vector> {
    (0..8_u8).map(|i| Vector::new(f64::from(i & 1) * x, f64::from(i >> 1 & 1) * y, f64::from(i >> 2) * z)).collect()
}

fn prism(outline: &[[f64; 2]], height: f64) -> Vec<Vector> {
    outline.iter().flat_map(|&[x, y]| [0.0, height].map(|z| Vector::new(x, y, z))).collect()
}

/// Ten bodies. Where no proof is given, [`nothing_is_smaller`] is one, to a hundredth.
///
/// Two bounds by Hadamard's maximal determinants, both for any box (indeed any parallelepiped) and any body inside it:
/// a tetrahedron fills at most a third of it, since a 3 x 3 matrix of zeros and ones has a determinant of at most 2, and
/// 2/6 = 1/3; of an octahedron with opposite corners ±v1, ±v2, ±v3 about its middle, 2 |det(v1, v2, v3)| is at most the box's
/// volume, since a matrix of signs has a determinant of at most 4.
fn bodies() -> Vec<Body> {
    let v = Vector::new;
    let hexagon: Vec<[f64; 2]> =
        (0..6).map(|i| (f64::from(i) * std::f64::consts::FRAC_PI_3).sin_cos()).map(|(s, c)| [c, s]).collect();
    let alternate = |x: f64, y: f64, z: f64| vec![v(0.0, 0.0, 0.0), v(x, y, 0.0), v(x, 0.0, z), v(0.0, y, z)];
    vec![
        Body { name: "cuboid", corners: cuboid(20.0, 12.0, 5.0), smallest: 1200.0 },
        // A cube of edge 2 has a tetrahedron of volume 8/3 in it: a third.
        Body { name: "regular tetrahedron", corners: alternate(2.0, 2.0, 2.0), smallest: 8.0 },
        // A third of 7·5·3 again.
        Body { name: "disphenoid", corners: alternate(7.0, 5.0, 3.0), smallest: 105.0 },
        // The cube's corners but for two opposite ones: v = (-1,1,1), (1,-1,1), (1,1,-1), determinant 4.
        Body {
            name: "antiprism in a cube",
            corners: [v(-1.0, 1.0, 1.0), v(1.0, -1.0, 1.0), v(1.0, 1.0, -1.0)].iter().flat_map(|p| [*p, -p]).collect(),
            smallest: 8.0,
        },
        // Still has the disphenoid of the whole.
        Body {
            name: "cuboid without an octant",
            corners: cuboid(6.0, 4.0, 8.0)
                .into_iter()
                .filter(|p| p.norm() > 0.0)
                .chain([v(3.0, 0.0, 0.0), v(0.0, 2.0, 0.0), v(0.0, 0.0, 4.0)])
                .collect(),
            smallest: 192.0,
        },
        // The box along the rows of ((2,2,-1), (2,-1,2), (-1,2,2)) / 3 has half-lengths 2/3: (4/3)³.
        Body {
            name: "regular octahedron",
            corners: [v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0), v(0.0, 0.0, 1.0)].iter().flat_map(|p| [*p, -p]).collect(),
            smallest: 64.0 / 27.0,
        },
        Body {
            name: "prism on a 3-4-5 triangle",
            corners: prism(&[[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]], 6.0),
            smallest: 72.0,
        },
        // Along the arms 4 x 4; along the line from end to end 4√2 x 5/√2 = 20.
        Body {
            name: "L",
            corners: prism(&[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 4.0], [0.0, 4.0]], 3.0),
            smallest: 48.0,
        },
        Body { name: "hexagonal prism", corners: prism(&hexagon, 2.0), smallest: 2.0 * 3.0_f64.sqrt() * 2.0 },
        Body {
            name: "square pyramid",
            corners: vec![v(1.0, 1.0, 0.0), v(1.0, -1.0, 0.0), v(-1.0, 1.0, 0.0), v(-1.0, -1.0, 0.0), v(0.0, 0.0, 1.5)],
            smallest: 6.0,
        },
    ]
}

/// Degenerate triangles that have the points for corners, turned.
fn turned(points: &[Vector], turn: &UnitQuaternion<f64>) -> Vec<Triangle> {
    points.iter().map(|p| Point::from(turn * p)).map(|p| Triangle::new(p, p, p)).collect()
}

/// That no box around the points, however turned, has less than `volume`: branch and bound over all rotations. Rotations are
/// unit quaternions, each on the ray through a point of one of four cubes; in a cell of half-length h about a quaternion the
/// frame turns by at most 2·2·asin(√3 h / 2), and a width changes by at most the diameter times twice the sine of half of that.
fn nothing_is_smaller(points: &[Vector], volume: f64) -> bool {
    /// Cells smaller than this decide nothing to rounding.
    const SMALLEST: f64 = 1e-6;
    let diameter = points.iter().flat_map(|p| points.iter().map(move |q| (p - q).norm())).fold(0.0, f64::max);
    let widths = |axes: &Matrix3<f64>| {
        let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        for p in points {
            let x = axes * p;
            (low, high) = (low.inf(&x), high.sup(&x));
        }
        high - low
    };
    let mut open: Vec<(usize, Vector, f64)> = (0..4).map(|cube| (cube, Vector::zeros(), 1.0)).collect();
    while let Some((cube, middle, half)) = open.pop() {
        let mut q = [1.0; 4];
        for (slot, x) in (0..4).filter(|&i| i != cube).zip(middle.iter()) {
            q[slot] = *x;
        }
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
        let chord = 3.0_f64.sqrt() * half;
        let turn = if chord < 1.0 { 4.0 * (chord / 2.0).asin() } else { std::f64::consts::PI };
        let shrink = diameter * 2.0 * (turn / 2.0).min(std::f64::consts::FRAC_PI_2).sin();
        let least = widths(&rotation.to_rotation_matrix().into_inner()).map(|w| (w - shrink).max(0.0)).product();
        if least >= volume {
            continue;
        }
        if half < SMALLEST {
            return false;
        }
        for octant in 0..8_u8 {
            let step = |bit: u8| if octant >> bit & 1 == 1 { 0.5 * half } else { -0.5 * half };
            open.push((cube, middle + Vector::new(step(0), step(1), step(2)), 0.5 * half));
        }
    }
    true
}

#[test]
fn the_smallest_boxes_of_ten_bodies_are_found() {
    let bodies = bodies();
    assert_eq!(bodies.len(), 10);
    for body in &bodies {
        for turn in [[0.0, 0.0, 0.0], [0.7, -0.4, 1.3], [-2.0, 0.9, 0.1]] {
            let turn = UnitQuaternion::from_scaled_axis(Vector::from(turn));
            let found = ObbMin::fit(&turned(&body.corners, &turn)).volume();
            let ratio = found / body.smallest;
            assert!((1.0 - 1e-6..1.01).contains(&ratio), "{}: {found} for {}", body.name, body.smallest);
        }
    }
}

#[test]
fn nothing_is_smaller_than_what_is_known_of_a_cuboid_and_a_pyramid() {
    for body in bodies().iter().filter(|body| ["cuboid", "square pyramid"].contains(&body.name)) {
        assert!(nothing_is_smaller(&body.corners, 0.9 * body.smallest), "{}", body.name);
        assert!(!nothing_is_smaller(&body.corners, 1.001 * body.smallest), "{}", body.name);
    }
}

/// `cargo test --release --test minimum_box -- --ignored certified`
#[test]
#[ignore = "minutes in the dev profile"]
fn what_is_known_of_ten_bodies_is_certified() {
    for body in bodies() {
        assert!(nothing_is_smaller(&body.corners, 0.99 * body.smallest), "{}", body.name);
    }
}

/// Volume of the smallest box, and of each other one; surface areas likewise.
struct Boxes {
    smallest: f64,
    others: [(&'static str, f64); 5],
}

fn volumes(triangles: &[Triangle]) -> Boxes {
    fn other<V: BoundingVolume>(triangles: &[Triangle]) -> (&'static str, f64) {
        (V::INFO.id, V::fit(triangles).volume())
    }
    Boxes {
        smallest: ObbMin::fit(triangles).volume(),
        others: [
            other::<Aabb>(triangles),
            other::<ObbVertex>(triangles),
            other::<ObbArea>(triangles),
            other::<ObbHullArea>(triangles),
            other::<ObbDito14>(triangles),
        ],
    }
}

/// Two fits of one box differ by less than this part, in the rounding of their centres.
const ROUNDING: f64 = 1e-9;

fn assert_smallest(name: &str, triangles: &[Triangle]) -> Boxes {
    let boxes = volumes(triangles);
    for (id, volume) in boxes.others {
        assert!(boxes.smallest <= volume * (1.0 + ROUNDING), "{name}: {} mm³, {id} {volume} mm³", boxes.smallest);
    }
    boxes
}

#[test]
fn no_box_of_any_mesh_of_the_suite_is_smaller() {
    for subject in meshes::subjects() {
        assert_smallest(subject.name, &subject.mesh.triangles());
        let turn = Isometry::rotation(Vector::new(1.1, 0.2, -0.6));
        if subject.mesh.vertices().iter().all(|v| v.coords.norm() < 3500.0) {
            assert_smallest(subject.name, &meshes::moved(&subject.mesh, 1.0, &turn).triangles());
        }
    }
}

/// `cargo test --release --test minimum_box -- --ignored --nocapture shipped`
#[test]
#[ignore = "a minute: every part of every shipped scene; prints by how much each box is larger"]
#[expect(clippy::print_stdout, reason = "its purpose")]
fn no_box_of_any_part_of_the_shipped_scenes_is_smaller() {
    let mut count = 0;
    for name in Scene::SHIPPED {
        for part in Scene::find(name).unwrap().parts {
            let triangles = part.mesh.triangles();
            let boxes = assert_smallest(&format!("{name}: {}", part.name), &triangles);
            let losses =
                boxes.others.map(|(id, volume)| format!("{id} {:+.1} %", 100.0 * (volume / boxes.smallest - 1.0)));
            println!(
                "{name}: {} ({} corners): {}",
                part.name,
                triangle::corners(&triangles).count(),
                losses.join(", ")
            );
            count += 1;
        }
    }
    assert!(count > 5, "{count} parts");
}
