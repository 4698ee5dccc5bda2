//! Placement of the objects of a file: affine maps, and the mesh that grows as objects are placed.

use super::super::{Point, Vector};
use super::{MOST, Raw};
use nalgebra::Matrix3;

/// An affine map from the coordinates of an object to those of its parent, both in the file's unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub linear: Matrix3<f64>,
    pub offset: Vector,
}

impl Placement {
    pub fn identity() -> Self {
        Self { linear: Matrix3::identity(), offset: Vector::zeros() }
    }

    /// Composes two placements: applies `inner` first, then this one.
    pub fn of(&self, inner: &Self) -> Self {
        Self { linear: self.linear * inner.linear, offset: self.linear * inner.offset + self.offset }
    }
}

/// Adds a placed mesh. A few bytes can place one object any number of times, so the size of the file is no bound. A mirroring placement reverses the winding, which is then reversed again, as both glTF and 3MF require. Face indices
/// must be valid.
pub(super) fn add(raw: &mut Raw, vertices: &[Point], faces: &[[u32; 3]], at: &Placement) -> Result<(), String> {
    let (all_vertices, all_faces) = (raw.vertices.len() + vertices.len(), raw.faces.len() + faces.len());
    if all_vertices > MOST || all_faces > MOST {
        return Err(format!("with this object, the file has more than {MOST} vertices or triangles"));
    }
    let first = raw.vertices.len() as u32;
    raw.vertices.extend(vertices.iter().map(|p| Point::from(at.linear * p.coords + at.offset)));
    let mirrored = at.linear.determinant() < 0.0;
    raw.faces.extend(faces.iter().map(|&[a, b, c]| {
        let (b, c) = if mirrored { (c, b) } else { (b, c) };
        [first + a, first + b, first + c]
    }));
    Ok(())
}
