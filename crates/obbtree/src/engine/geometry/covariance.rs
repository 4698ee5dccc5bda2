//! Means, covariances and the axes that follow from them: equations (1), (4) and (5) of Xu and Zhang 2011.
//!
//! Everything is computed about a local origin (the first corner). Otherwise the difference of two large second moments would lose its
//! significant digits.

use super::{Point, Triangle, Vector, eigen, triangle};
use nalgebra::{Matrix3, Unit};

/// Mean (mm) and covariance (mm²) of the triangle corners, equation (1). Every triangle contributes its three corners, so a vertex shared
/// by six triangles counts six times.
#[must_use]
pub fn vertex_weighted(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
    let origin = triangles[0].corners[0];
    let count = 3.0 * triangles.len() as f64;
    let mean = triangle::corners(triangles).map(|p| p - origin).sum::<Vector>() / count;
    let mut covariance = Matrix3::zeros();
    for corner in triangle::corners(triangles) {
        let d = corner - origin - mean;
        covariance += d * d.transpose();
    }
    (origin + mean, covariance / count)
}

/// Mean (mm), equation (4), and covariance (mm²), equation (5), of the surface. Every point of every triangle has the same weight, which
/// gives Gottschalk's closed form (2000). Triangles of zero area have no weight; when all have zero area, the corners are used instead
/// ([`vertex_weighted`]).
#[must_use]
pub fn area_weighted(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
    let origin = triangles[0].corners[0];
    let (mut total, mut first, mut second) = (0.0, Vector::zeros(), Matrix3::zeros());
    for t in triangles {
        let area = t.area();
        let [p, q, r] = &t.corners;
        let (p, q, r) = (p - origin, q - origin, r - origin);
        let n = (p + q + r) / 3.0;
        total += area;
        first += n * area;
        let outer = |v: &Vector| v * v.transpose();
        second += (outer(&n) * 9.0 + outer(&p) + outer(&q) + outer(&r)) * (area / 12.0);
    }
    if total <= 0.0 {
        return vertex_weighted(triangles);
    }
    let mean = first / total;
    (origin + mean, second / total - mean * mean.transpose())
}

/// The eigenvectors of a covariance as the columns of a rotation (right-handed, orthonormal), largest eigenvalue first.
///
/// Equal eigenvalues (a cylinder, a torus) leave the axes undetermined. The result is then whatever the iteration returns, which is the
/// same on every run, and still a rotation. Signs are fixed by making the largest component of the first two columns positive. A covariance
/// that is not finite or is zero gives the identity.
#[must_use]
pub fn principal_frame(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let scale = covariance.amax();
    if !(scale > 0.0 && scale.is_finite()) {
        return Matrix3::identity();
    }
    // To the last bit; scaled to order 1 nothing overflows or is lost.
    let (along, axes) = eigen::axes(&(covariance / scale), f64::EPSILON / 2.0);
    // Equal ones keep their order.
    let mut order = [0, 1, 2];
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if along[order[i]] < along[order[j]] {
            order.swap(i, j);
        }
    }
    right_handed(&axes.column(order[0]).into_owned(), &axes.column(order[1]).into_owned())
}

/// A rotation whose first column is along `first`, and whose second is the component of `second` perpendicular to it, normalised.
fn right_handed(first: &Vector, second: &Vector) -> Matrix3<f64> {
    let x = with_positive_largest_component(first.normalize());
    let y = with_positive_largest_component((second - x * x.dot(second)).normalize());
    Matrix3::from_columns(&[x, y, x.cross(&y)])
}

fn with_positive_largest_component(v: Vector) -> Vector {
    if v[v.iamax()] < 0.0 { -v } else { v }
}

/// The matrix whose columns are three axes.
#[must_use]
pub fn frame_of(axes: &[Unit<Vector>; 3]) -> Matrix3<f64> {
    Matrix3::from_columns(&[*axes[0], *axes[1], *axes[2]])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat rectangle a x b in the xy plane about the origin, two triangles.
    fn rectangle(a: f64, b: f64) -> [Triangle; 2] {
        let p = |x: f64, y: f64| Point::new(x * a / 2.0, y * b / 2.0, 0.0);
        [
            Triangle::new(p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0)),
            Triangle::new(p(-1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)),
        ]
    }

    #[test]
    fn the_surface_of_a_rectangle_has_its_textbook_moments() {
        let (mean, c) = area_weighted(&rectangle(6.0, 2.0));
        assert!(mean.coords.norm() < 1e-12);
        assert!((c.m11 - 36.0 / 12.0).abs() < 1e-12); // a²/12
        assert!((c.m22 - 4.0 / 12.0).abs() < 1e-12);
        assert!(c.m12.abs() < 1e-12); // whichever diagonal
    }

    #[test]
    fn the_corners_of_a_rectangle_feel_its_diagonal() {
        // Corners with multiplicity: (-3,-1) twice, (3,1) twice, (3,-1) and (-3,1) once each.
        let (mean, c) = vertex_weighted(&rectangle(6.0, 2.0));
        assert!(mean.coords.norm() < 1e-12);
        assert!((c.m11 - 9.0).abs() < 1e-12);
        assert!((c.m12 - (4.0 * 3.0 - 2.0 * 3.0) / 6.0).abs() < 1e-12); // (4·3 - 2·3) / 6 = 1
    }

    #[test]
    fn moments_survive_a_distant_origin() {
        let far: Vec<Triangle> = rectangle(6.0, 2.0).iter().map(|t| t.map(|p| p + Vector::repeat(4000.0))).collect();
        let (_, c) = area_weighted(&far);
        assert!((c.m11 - 3.0).abs() < 1e-9);
    }

    #[test]
    fn without_area_the_corners_count() {
        let t = Triangle::new(Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(3.0, 0.0, 0.0));
        assert_eq!(area_weighted(&[t]), vertex_weighted(&[t]));
    }

    #[test]
    fn frames_are_rotations_with_the_longest_axis_first() {
        let (_, c) = area_weighted(&rectangle(2.0, 6.0));
        for frame in [principal_frame(&c), principal_frame(&Matrix3::identity()), principal_frame(&Matrix3::zeros())] {
            assert!((frame.determinant() - 1.0).abs() < 1e-12);
            assert!((frame.transpose() * frame - Matrix3::identity()).amax() < 1e-12);
        }
        assert!((principal_frame(&c).column(0).dot(&Vector::y()).abs() - 1.0).abs() < 1e-12);
    }
}
