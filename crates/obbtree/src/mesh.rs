//! Triangle meshes as users have them: in any unit, of any size.

use crate::engine::geometry::mesh::check;
use crate::engine::geometry::{MeshError, weld};
use nalgebra::Point3;

/// Vertices and faces, in the mesh's own frame and in any unit of length.
///
/// Coordinates are finite, at most [`Mesh::MAX_COORDINATE`] in magnitude, and there is at least one face, with a coordinate of at least
/// [`Mesh::MIN_COORDINATE`] unless all are 0. The mesh may be open, may have holes, degenerate and duplicate faces: it is a surface, with nothing inside.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    vertices: Vec<Point3<f64>>,
    faces: Vec<[u32; 3]>,
}

impl Mesh {
    /// Largest magnitude of a coordinate: 2⁵⁰⁰, about 3·10¹⁵⁰.
    pub const MAX_COORDINATE: f64 = power_of_two(500);

    /// The largest coordinate has at least this magnitude, unless all are 0: 2⁻⁵⁰⁰, about 3·10⁻¹⁵¹. The grid of smaller meshes would be coarser than their
    /// coordinates.
    pub const MIN_COORDINATE: f64 = power_of_two(-500);

    /// Largest number of faces: 2²⁸ - 1.
    pub const MAX_FACES: usize = (1 << 28) - 1;

    /// A mesh from vertices and faces, which are indices into the vertices.
    ///
    /// ```
    /// use obbtree::Mesh;
    ///
    /// let mesh = Mesh::new([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2]])?;
    /// assert_eq!(mesh.faces().len(), 1);
    /// assert!(Mesh::new([[f64::NAN, 0.0, 0.0]], [[0, 0, 0]]).is_err());
    /// # Ok::<(), obbtree::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError`] when there is no face or more than [`Mesh::MAX_FACES`], a coordinate is not finite or beyond [`Mesh::MAX_COORDINATE`], a face
    /// names a missing vertex, or the largest coordinate of the faces is below [`Mesh::MIN_COORDINATE`] and not 0.
    pub fn new(
        vertices: impl IntoIterator<Item = impl Into<Point3<f64>>>,
        faces: impl IntoIterator<Item = [u32; 3]>,
    ) -> Result<Self, MeshError> {
        let vertices: Vec<Point3<f64>> = vertices.into_iter().map(Into::into).collect();
        let faces: Vec<[u32; 3]> = faces.into_iter().collect();
        few_enough(faces.len())?;
        check(&vertices, &faces, Self::MAX_COORDINATE)?;
        let mesh = Self { vertices, faces };
        let largest = mesh.bounds().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        if largest > 0.0 && largest < Self::MIN_COORDINATE {
            return Err(MeshError::TooSmall { largest, limit: Self::MIN_COORDINATE });
        }
        Ok(mesh)
    }

    /// A mesh from loose triangles. Corners with equal coordinates become one vertex.
    ///
    /// # Errors
    /// As [`Mesh::new`].
    pub fn from_triangles(triangles: impl IntoIterator<Item = [impl Into<Point3<f64>>; 3]>) -> Result<Self, MeshError> {
        let corners: Vec<Point3<f64>> = triangles.into_iter().flatten().map(Into::into).collect();
        few_enough(corners.len() / 3)?;
        let mut number_of = vec![0; corners.len()];
        let mut vertices = Vec::new();
        for (corner, &first) in weld::equal(&corners).iter().enumerate() {
            number_of[corner] = if first as usize == corner {
                vertices.push(corners[corner]);
                vertices.len() as u32 - 1
            } else {
                number_of[first as usize]
            };
        }
        Self::new(vertices, number_of.as_chunks::<3>().0.iter().copied())
    }

    /// The vertices.
    #[must_use]
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// The faces, as indices into [`Mesh::vertices`].
    #[must_use]
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The corners of a face.
    ///
    /// # Panics
    /// When there is no face of that number.
    #[must_use]
    pub fn triangle(&self, face: u32) -> [Point3<f64>; 3] {
        self.faces[face as usize].map(|vertex| self.vertices[vertex as usize])
    }

    /// Smallest and largest coordinate of the faces' corners on each axis.
    #[must_use]
    pub fn bounds(&self) -> [Point3<f64>; 2] {
        let first = self.vertices[self.faces[0][0] as usize];
        let corners = self.faces.as_flattened().iter().map(|&vertex| &self.vertices[vertex as usize]);
        corners.fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)])
    }
}

/// More could not be numbered.
const fn few_enough(faces: usize) -> Result<(), MeshError> {
    if faces <= Mesh::MAX_FACES { Ok(()) } else { Err(MeshError::TooManyFaces { faces, limit: Mesh::MAX_FACES }) }
}

/// 2 to the power of `exponent`, which lies within ±1022.
pub(crate) const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Collider;
    use nalgebra::Isometry3;

    #[test]
    fn bad_input_is_refused_and_the_limit_is_named() {
        let none: [[f64; 3]; 0] = [];
        assert_eq!(Mesh::new(none, []), Err(MeshError::Empty));
        let one = |x: f64| Mesh::new([[0.0; 3], [x, 0.0, 0.0]], [[0, 1, 1]]);
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(matches!(one(x), Err(MeshError::NotFinite { vertex: 1, .. })), "{x}");
        }
        assert!(one(Mesh::MAX_COORDINATE).is_ok());
        let error = one(1e151).unwrap_err();
        assert!(matches!(error, MeshError::OutOfRange { vertex: 1, .. }));
        assert!(error.to_string().contains("farther than 3.27"), "{error}");
        assert_eq!(
            Mesh::new([[0.0; 3]], [[0, 0, 0], [0, 7, 0]]),
            Err(MeshError::NoSuchVertex { face: 1, vertex: 7, vertices: 1 })
        );
    }

    /// What is refused would be rounded to nothing, and touch what it does not.
    #[test]
    fn a_mesh_smaller_than_the_grid_is_refused_unless_it_is_a_point_at_the_origin() {
        let cornered = |x: f64| Mesh::new([[0.0; 3], [-x, 0.0, 0.0], [0.0, 0.5 * x, 0.0], [1.0; 3]], [[0, 1, 2]]);
        let least = Mesh::MIN_COORDINATE;
        for x in [least.next_down(), 1e-160, 5e-324] {
            let error = cornered(x).unwrap_err();
            assert_eq!(error, MeshError::TooSmall { largest: x, limit: least });
            assert!(error.to_string().contains("3.05") && error.to_string().contains("e-151"), "{error}");
        }
        assert!(cornered(0.0).is_ok());
        let collider = Collider::new(cornered(least).unwrap());
        let apart = |x: f64| collider.collides(&collider, &Isometry3::translation(x * least, 0.0, 0.0));
        assert_eq!((apart(1.0), apart(1.0 + 1e-8)), (Ok(true), Ok(false)));
    }

    #[test]
    fn more_faces_than_can_be_numbered_are_refused() {
        assert_eq!(few_enough(Mesh::MAX_FACES), Ok(()));
        let error = few_enough(Mesh::MAX_FACES + 1).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the mesh has 268435456 faces; at most 268435455 can be numbered: divide it into several"
        );
    }

    #[test]
    fn loose_triangles_share_the_corners_that_are_equal() {
        let [p, q, r, s] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let mesh = Mesh::from_triangles([[p, q, r], [q, s, r]]).unwrap();
        assert_eq!((mesh.vertices().len(), mesh.faces()), (4, &[[0, 1, 2], [1, 3, 2]][..]));
        assert_eq!(mesh.triangle(1), [q, s, r].map(Point3::from));
        let none: [[[f64; 3]; 3]; 0] = [];
        assert_eq!(Mesh::from_triangles(none), Err(MeshError::Empty));
    }

    #[test]
    fn bounds_are_those_of_the_faces() {
        let mesh = Mesh::new([[9.0; 3], [0.0, 1.0, 2.0], [1.0, 0.0, 5.0]], [[1, 2, 1]]).unwrap();
        assert_eq!(mesh.bounds(), [Point3::new(0.0, 0.0, 2.0), Point3::new(1.0, 1.0, 5.0)]);
    }
}
