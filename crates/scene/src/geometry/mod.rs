//! Parametric shapes, mesh files and hulls. The meshes and exact tests are in [`obbtree::engine::geometry`].
//!
//! Reading order: [`hull`], [`rectangle`], [`separating_axes`], [`shapes`] and [`import`].

pub mod hull;
pub mod import;
pub mod rectangle;
pub mod separating_axes;
pub mod shapes;

use nalgebra::{Unit, UnitQuaternion};
pub use obbtree::engine::geometry::{
    GridMesh as Mesh, Isometry, MeshError, Point, Triangle, Vector, certified, covariance, cross_check, eigen, exact,
    exact_integer, grid, mesh, plane, rigid, surface, triangle, triangle_distance, weld,
};

/// The direction of a finite vector; `None` for zero. The vector is scaled first if the squares of its components would overflow or
/// underflow.
pub fn direction(vector: Vector) -> Option<Unit<Vector>> {
    const SQUARES: std::ops::Range<f64> = 1e-200..1e200;
    if !vector.iter().all(|x| x.is_finite()) {
        return None;
    }
    let scaled = if SQUARES.contains(&vector.norm_squared()) { vector } else { vector / vector.amax() };
    // Zero divided by zero is not a number, and has no direction.
    Unit::try_new(scaled, 0.0)
}

/// The turn from one direction to another, half a turn about x where they are opposite.
pub fn turn_between(from: &Vector, to: &Vector) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(from, to)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI))
}

/// A hash of the snapped vertices and the faces, as hexadecimal text; equal meshes have equal hashes on every machine.
pub fn content_hash(mesh: &Mesh) -> String {
    let mut hasher = blake3::Hasher::new();
    for p in mesh.vertices() {
        for x in [p.x, p.y, p.z] {
            hasher.update(&(x + 0.0).to_le_bytes());
        }
    }
    for v in mesh.faces().iter().flatten() {
        hasher.update(&v.to_le_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_vector_of_any_magnitude_has_its_direction(
            exponents in prop::array::uniform3(-320..=308_i32),
            signs in prop::array::uniform3(-1..=1_i32),
        ) {
            let vector = Vector::from_fn(|k, _| f64::from(signs[k]) * format!("1e{}", exponents[k]).parse::<f64>().unwrap());
            let found = direction(vector);
            prop_assert_eq!(found.is_some(), vector.amax() > 0.0);
            if let Some(found) = found {
                prop_assert!((found.norm() - 1.0).abs() < 1e-15);
                // The largest component keeps its sign and is the largest; the others keep their ratio to it.
                let largest = vector.iamax();
                prop_assert!(found[largest] * vector[largest].signum() >= 1.0 / 3f64.sqrt() - 1e-15);
                for k in 0..3 {
                    prop_assert!((found[k] / found[largest] - vector[k] / vector[largest]).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn what_has_no_direction() {
        for x in [f64::NAN, f64::INFINITY] {
            assert_eq!(direction(Vector::new(1.0, x, 0.0)), None);
        }
        assert_eq!(direction(Vector::zeros()), None);
    }
}
