//! Orientation rules: the axes of a box, and the mean that belongs to each rule.

use crate::geometry::hull::Hull;
use crate::geometry::{Point, Triangle, Vector, covariance, triangle};
use nalgebra::Matrix3;

/// A rule that determines the axes of a box.
pub trait FrameRule {
    /// The mean of the rule, mm, and the axes as columns of a rotation.
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>);
}

/// Principal axes of the triangle corners, equation (1) of Xu and Zhang 2011.
#[derive(Clone, Copy, Debug)]
pub struct VertexCovariance;

impl FrameRule for VertexCovariance {
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, covariance) = covariance::vertex_weighted(triangles);
        (mean, covariance::principal_frame(&covariance))
    }
}

/// Principal axes of the surface, equations (4) and (5) of Xu and Zhang 2011.
#[derive(Clone, Copy, Debug)]
pub struct AreaCovariance;

impl FrameRule for AreaCovariance {
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, covariance) = covariance::area_weighted(triangles);
        (mean, covariance::principal_frame(&covariance))
    }
}

/// Principal axes of the surface of the convex hull: Gottschalk, Lin and Manocha 1996, section 4. Points inside the hull have no influence.
#[derive(Clone, Copy, Debug)]
pub struct HullAreaCovariance;

impl FrameRule for HullAreaCovariance {
    /// Uses the corners themselves when the hull has no surface.
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let facets = Hull::of(triangle::corners(triangles)).map(|hull| hull.triangles()).unwrap_or_default();
        AreaCovariance::mean_and_axes(if facets.is_empty() { triangles } else { &facets })
    }
}

/// The frame whose tight box has the least surface, among three: the principal axes of the surface, the mesh's own axes, and the frame of
/// the largest triangle. Machine parts are mostly prisms and turned bodies along their own axes; no covariance finds these axes when
/// symmetry leaves the eigenvectors undetermined. The mean is that of the surface.
#[derive(Clone, Copy, Debug)]
pub struct LeastSurface;

impl FrameRule for LeastSurface {
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, principal) = AreaCovariance::mean_and_axes(triangles);
        let mut largest = &triangles[0];
        for triangle in triangles {
            if triangle.area() > largest.area() {
                largest = triangle;
            }
        }
        let mut best = (surface(triangles, &mean, &principal), principal);
        for axes in [Some(Matrix3::identity()), largest.frame()].into_iter().flatten() {
            let surface = surface(triangles, &mean, &axes);
            if surface < best.0 {
                best = (surface, axes);
            }
        }
        (mean, best.1)
    }
}

/// Half the surface area of the tight box along `axes`, mm².
fn surface(triangles: &[Triangle], mean: &Point, axes: &Matrix3<f64>) -> f64 {
    let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    for corner in triangle::corners(triangles) {
        let x = axes.tr_mul(&(corner - mean));
        (low, high) = (low.inf(&x), high.sup(&x));
    }
    let d = high - low;
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// The largest absolute coordinate of the contents, mm.
pub fn reach_mm(triangles: &[Triangle]) -> f64 {
    triangle::corners(triangles).map(|corner| corner.coords.amax()).fold(0.0, f64::max)
}

/// A rotation whose first column is along `direction`; the identity for a direction of length zero.
pub fn any_frame(direction: &Vector) -> Matrix3<f64> {
    let Some(along) = direction.try_normalize(0.0) else { return Matrix3::identity() };
    let helper = if along.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
    let across = along.cross(&helper).normalize();
    Matrix3::from_columns(&[along, across, along.cross(&across)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;
    use obbtree::cases::meshes;

    #[test]
    fn what_lies_inside_does_not_turn_the_hulls_axes() {
        // A flat 6 x 2 rectangle along x, and inside it a thousand short strips along the diagonal.
        let p = |x: f64, y: f64| Point::new(x, y, 0.0);
        let mut triangles = vec![
            Triangle::new(p(0.0, 0.0), p(6.0, 0.0), p(6.0, 2.0)),
            Triangle::new(p(0.0, 0.0), p(6.0, 2.0), p(0.0, 2.0)),
        ];
        triangles.extend([Triangle::new(p(2.0, 0.1), p(3.8, 1.9), p(3.7, 1.9)); 1000]);
        let first = |axes: Matrix3<f64>| axes.column(0).x.abs();
        assert!(first(HullAreaCovariance::mean_and_axes(&triangles).1) > 1.0 - 1e-12);
        assert!(first(AreaCovariance::mean_and_axes(&triangles).1) < 0.95);
        // A segment has no surface: the corners decide.
        let segment = [Triangle::new(p(0.0, 0.0), p(1.0, 1.0), p(0.0, 0.0))];
        let axes = HullAreaCovariance::mean_and_axes(&segment).1;
        assert!((axes.column(0).x - 0.5_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_box_of_least_surface_is_taken_from_three() {
        let cuboid = meshes::cuboid(2.0, 3.0, 4.0).triangles();
        // Half of 2 (2·3 + 3·4 + 4·2), wherever the mean is.
        assert!((surface(&cuboid, &Point::new(7.0, -5.0, 3.0), &Matrix3::identity()) - 26.0).abs() < 1e-12);
        let place = Isometry::translation(1.0, -9.0, 2.0);
        assert_eq!(reach_mm(&meshes::moved(&meshes::cuboid(2.0, 3.0, 4.0), 1.0, &place).triangles()), 10.5);
        // No covariance knows the axes of a cube; those of its mesh are its own.
        let cube = meshes::cuboid(2.0, 2.0, 2.0).triangles();
        let (mean, axes) = LeastSurface::mean_and_axes(&cube);
        assert!((surface(&cube, &mean, &axes) - 12.0).abs() < 1e-12 && mean.coords.norm() < 1e-12);
        // A right triangle and a smaller one beside it, turned: the frame of the larger one is that of its hypotenuse.
        let turn = Isometry::rotation(Vector::new(0.4, -0.9, 0.5));
        let p = |x: f64, y: f64| turn * Point::new(x, y, 0.0);
        let sail = [
            Triangle::new(p(0.0, 0.0), p(5.0, 0.0), p(1.8, 2.4)),
            Triangle::new(p(0.2, 0.0), p(4.8, 0.0), p(1.9, 2.3)),
        ];
        let (mean, axes) = LeastSurface::mean_and_axes(&sail);
        assert!((surface(&sail, &mean, &axes) - 5.0 * 2.4).abs() < 1e-9);
        // The axes of a turned rod are the principal ones.
        let rod = meshes::moved(&meshes::cuboid(90.0, 6.0, 4.0), 1.0, &Isometry::rotation(Vector::new(0.2, 0.3, -0.4)));
        let (mean, axes) = LeastSurface::mean_and_axes(&rod.triangles());
        assert!((surface(&rod.triangles(), &mean, &axes) - (540.0 + 24.0 + 360.0)).abs() < 1e-3);
    }

    #[test]
    fn any_frame_is_a_rotation_along_its_direction() {
        for d in [Vector::x(), -Vector::y(), Vector::new(1.0, 1.0, 1.0), Vector::zeros()] {
            let frame = any_frame(&d);
            assert!((frame.tr_mul(&frame) - Matrix3::identity()).amax() < 1e-12 && frame.determinant() > 0.0);
            assert!((frame.column(0).dot(&d) - d.norm()).abs() < 1e-12);
        }
    }
}
