//! Where a file that is made of objects puts them: affine maps, and the mesh that grows as objects are placed.

use super::super::{Point, Vector};
use super::Raw;
use nalgebra::Matrix3;

/// Most triangles, and most vertices, that placing objects may add up to. A few bytes can place one object any number
/// of times, so that the size of the file is no bound; 2^24 vertices and triangles take 0.6 GiB.
const MOST: usize = 1 << 24;

/// An affine map from the coordinates of an object to those of whatever holds it, both in the file's unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub linear: Matrix3<f64>,
    pub offset: Vector,
}

impl Placement {
    pub fn identity() -> Self {
        Self { linear: Matrix3::identity(), offset: Vector::zeros() }
    }

    /// This placement of what `inner` places.
    pub fn of(&self, inner: &Self) -> Self {
        Self { linear: self.linear * inner.linear, offset: self.linear * inner.offset + self.offset }
    }
}

/// Adds a mesh at its place. A placement that mirrors turns the winding, which is turned back, as both glTF and 3MF ask.
/// Face indices must be valid.
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
