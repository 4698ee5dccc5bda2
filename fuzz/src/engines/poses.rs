//! Poses at which verdicts are hard: in contact at a corner, an edge or a face, and just before.

use super::choices::Choices;
use super::truth::Truth;
use bvbench::geometry::grid::STEP_MM;
use bvbench::geometry::{Isometry, Mesh, Point, Vector};
use nalgebra::UnitQuaternion;
use obbtree::engine::geometry::rigid;

/// Doublings of a way that surely leads out of contact.
const DOUBLINGS: u32 = 48;
/// Halvings of the last of them: down to the last bit of a coordinate.
const HALVINGS: u32 = 60;
/// Poses of a long path, and of others.
const LONG: usize = 90;
const SHORT: usize = 1;

/// How long a pose's quaternion is, less 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// As near to 0 as rounding leaves it.
    Unit,
    /// By up to 1e-7.
    Off,
}

/// A corner of the mesh, or a point on an edge or in a face.
fn feature(choices: &mut Choices, mesh: &Mesh) -> Point {
    let face = mesh.faces()[choices.below(mesh.faces().len() as u64) as usize];
    let [p, q, r] = mesh.triangle(face).corners;
    let (u, v) = (choices.unit(), choices.unit());
    match choices.below(4) {
        0 => p + (q - p) * u,
        1 => p + (q - p) * (u * (1.0 - v)) + (r - p) * (u * v),
        _ => p,
    }
}

/// With a quaternion that is not of length 1, one time in two that length is off.
pub fn rotation(choices: &mut Choices, length: Length) -> UnitQuaternion<f64> {
    let rotation = choices.rotation();
    match length {
        Length::Unit => rotation,
        Length::Off => stretched(rotation, choices.between(-40, -24) * choices.of(&[-1.0, 1.0])),
    }
}

fn stretched(rotation: UnitQuaternion<f64>, by: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(rotation.into_inner() * (1.0 + by))
}

/// A pose that puts a feature of `b` on one of `a`, exactly or nearly.
pub fn joined(choices: &mut Choices, a: &Mesh, b: &Mesh, rotation: UnitQuaternion<f64>) -> Isometry {
    let (on_a, on_b) = (feature(choices, a), feature(choices, b));
    let off = match choices.below(4) {
        // Snapping closes it, just so or just not.
        0 => choices.vector().map(|x| 0.5 * STEP_MM * x.signum() * (1.0 - x * x * x * x)),
        1 => choices.vector() * choices.between(-30, -4),
        _ => Vector::zeros(),
    };
    // As the truth turns it, whatever the quaternion's length.
    let turned = rigid::rotation(&Isometry::from_parts(Vector::zeros().into(), rotation)) * on_b.coords;
    Isometry::from_parts((on_a.coords - turned + off).into(), rotation)
}

/// On the way from a touching pose along a direction: the last pose found that touches, and the first that does not.
pub fn border(truth: &Truth, touching: &Isometry, direction: &Vector) -> Option<[Isometry; 2]> {
    let at = |way: f64| Isometry::from_parts((touching.translation.vector + direction * way).into(), touching.rotation);
    let mut ways = (0..DOUBLINGS).map(|k| STEP_MM * 2f64.powi(k as i32)).take_while(|&way| way <= 4096.0);
    let mut apart = ways.find(|&way| !truth.touches(&at(way)))?;
    let mut touches = 0.0;
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(touches, apart);
        if middle <= touches || middle >= apart {
            break;
        }
        if truth.touches(&at(middle)) { touches = middle } else { apart = middle }
    }
    Some([at(touches), at(apart)])
}

/// Poses in small steps that pass a pose; some stretch the quaternion at every step.
pub fn path(choices: &mut Choices, through: &Isometry, size_mm: f64, length: Length) -> Vec<Isometry> {
    let poses = if choices.once_in(9) { LONG } else { SHORT };
    let step = choices.direction() * (size_mm * choices.between(-28, -3)).max(0.25 * STEP_MM);
    let turn = if choices.once_in(2) { UnitQuaternion::identity() } else { choices.small_turn(-40, -5) };
    let before = choices.below(poses as u64) as f64;
    let (mut rotation, mut path) = (through.rotation, Vec::with_capacity(poses));
    for k in 0..poses {
        let jitter = if choices.once_in(64) { choices.vector() * size_mm } else { Vector::zeros() };
        let at = through.translation.vector + step * (k as f64 - before) + jitter;
        path.push(Isometry::from_parts(at.into(), rotation));
        rotation = UnitQuaternion::new_normalize((turn * rotation).into_inner());
        if length == Length::Off {
            rotation = stretched(rotation, choices.between(-40, -24) * choices.of(&[-1.0, 1.0]));
        }
    }
    path
}
