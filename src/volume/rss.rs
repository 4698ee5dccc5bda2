//! The rectangle swept by a sphere: all points within a radius of a rectangle.
//!
//! E. Larsen, S. Gottschalk, M. C. Lin, D. Manocha, "Fast Proximity Queries with Swept Sphere Volumes", TR99-018, 1999. The axes come from
//! the area-weighted covariance (equation (5) of Xu and Zhang 2011). Deviations: the rectangle's normal is the axis along which the
//! contents are thinnest, whatever the eigenvalues are. After the fit, the radius is set to the distance of the farthest corner from the
//! rectangle, which absorbs rounding errors. Before the exact distance of two rectangles, a cheaper bound by two boxes is tried.

use super::fit::frame::{AreaCovariance, FrameRule, reach_mm};
use super::shape::obb::ObbPose;
use super::shape::rectangle_distance::{point_squared, squared};
use super::{BoundingVolume, Info, Segment, Shape, Solid};
use crate::geometry::separating_axes::pad_mm;
use crate::geometry::{Isometry, Point, Triangle, Vector, triangle};
use nalgebra::{Matrix3, Unit};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

/// A rectangle and a radius, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct Rss {
    /// The rectangle's two directions and its normal as columns.
    axes: Matrix3<f64>,
    /// The rectangle's middle.
    centre: Point,
    half: [f64; 2],
    radius: f64,
}

impl Rss {
    /// The other rectangle's middle and axes in the frame of this one.
    fn relative(&self, other: &Self, pose: &ObbPose) -> (Vector, Matrix3<f64>) {
        let between = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        (self.axes.tr_mul(&between), self.axes.tr_mul(&(pose.rotation * other.axes)))
    }
}

/// Squared distance between the first rectangle and the box around the second one along the first one's axes, mm².
fn boxes_squared(t: &Vector, r: &Matrix3<f64>, a: [f64; 2], b: [f64; 2]) -> f64 {
    let reach = |i: usize| r[(i, 0)].abs() * b[0] + r[(i, 1)].abs() * b[1];
    let gap = |i: usize, own: f64| (t[i].abs() - own - reach(i)).max(0.0);
    gap(0, a[0]).powi(2) + gap(1, a[1]).powi(2) + gap(2, 0.0).powi(2)
}

impl BoundingVolume for Rss {
    const INFO: Info = Info {
        id: "rss",
        label: "RSS",
        reference: "E. Larsen, S. Gottschalk, M. C. Lin, D. Manocha, Fast Proximity Queries with Swept Sphere Volumes, 1999",
        safe: true,
    };

    type Shape = Self;

    fn fit(triangles: &[Triangle]) -> Self {
        let (mean, frame) = AreaCovariance::mean_and_axes(triangles);
        let axes = thinnest_last(&frame, triangles);
        let points: Vec<Vector> = triangle::corners(triangles).map(|p| axes.tr_mul(&(p - mean))).collect();
        let (low, high) =
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p.z), high.max(p.z)));
        let (middle, radius) = (f64::midpoint(low, high), 0.5 * (high - low));
        let [x, y] = grown_at_corners(
            &points,
            [side(&points, 0, middle, radius), side(&points, 1, middle, radius)],
            middle,
            radius,
        );
        let centre = Vector::new(f64::midpoint(x[0], x[1]), f64::midpoint(y[0], y[1]), middle);
        let half = [0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])];
        let farthest = points.iter().map(|p| point_squared(&(p - centre), half)).fold(0.0, f64::max).sqrt();
        Self { axes, centre: mean + axes * centre, half, radius: farthest + pad_mm(reach_mm(triangles)) }
    }
}

impl Shape for Rss {
    type Pose = ObbPose;

    fn pose(a_from_b: &Isometry) -> ObbPose {
        ObbPose::new(a_from_b)
    }

    #[inline]
    fn overlaps(&self, other: &Self, pose: &ObbPose) -> bool {
        let (t, r) = self.relative(other, pose);
        let reach = (self.radius + other.radius).powi(2);
        boxes_squared(&t, &r, self.half, other.half) <= reach
            && boxes_squared(&-r.tr_mul(&t), &r.transpose(), other.half, self.half) <= reach
            && squared(&t, &r, self.half, other.half) <= reach
    }

    fn gap_mm(&self, other: &Self, pose: &ObbPose) -> f64 {
        let (t, r) = self.relative(other, pose);
        (squared(&t, &r, self.half, other.half).sqrt() - self.radius - other.radius).max(0.0)
    }

    fn size(&self) -> f64 {
        self.half[0].hypot(self.half[1]) + self.radius
    }

    fn split_axes(&self, _: &[Triangle]) -> [Unit<Vector>; 3] {
        let order = if self.half[0] >= self.half[1] { [0, 1, 2] } else { [1, 0, 2] };
        order.map(|column| Unit::new_unchecked(self.axes.column(column).into_owned()))
    }
}

impl Solid for Rss {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        point_squared(&self.axes.tr_mul(&(point - self.centre)), self.half) <= (self.radius + slack_mm).powi(2)
    }

    fn centre(&self) -> Point {
        self.centre
    }

    /// Steiner's formula: A·2r + P·πr²/2 + 4πr³/3 for a rectangle of area A and perimeter P.
    fn volume(&self) -> f64 {
        let ([a, b], r) = (self.half, self.radius);
        8.0 * a * b * r + 2.0 * PI * (a + b) * r * r + 4.0 / 3.0 * PI * r.powi(3)
    }

    /// The derivative of the volume with respect to the radius.
    fn surface_area(&self) -> f64 {
        let ([a, b], r) = (self.half, self.radius);
        8.0 * a * b + 4.0 * PI * (a + b) * r + 4.0 * PI * r * r
    }

    fn axes(&self) -> Matrix3<f64> {
        self.axes
    }

    /// The rectangle, offset to both sides by the radius, and half circles around its corners.
    fn outline(&self) -> Vec<Segment> {
        const STEPS: u32 = 12;
        let at = |x: f64, y: f64, z: f64| self.centre + self.axes * Vector::new(x, y, z);
        let ([a, b], r) = (self.half, self.radius);
        let corners = [(-a, -b), (a, -b), (a, b), (-a, b)];
        let mut segments = Vec::new();
        for (i, &(x, y)) in corners.iter().enumerate() {
            let (next_x, next_y) = corners[(i + 1) % 4];
            segments.extend([-r, r].map(|z| [at(x, y, z), at(next_x, next_y, z)]));
            for (outward_x, outward_y) in [(x.signum(), 0.0), (0.0, y.signum())] {
                let on = |step: u32| {
                    let (sin, cos) = (PI * f64::from(step) / f64::from(STEPS) - FRAC_PI_2).sin_cos();
                    at(x + outward_x * r * cos, y + outward_y * r * cos, r * sin)
                };
                segments.extend((0..STEPS).map(|step| [on(step), on(step + 1)]));
            }
        }
        segments
    }
}

/// The frame with its columns permuted cyclically, so that the last is the axis along which the contents are thinnest.
fn thinnest_last(frame: &Matrix3<f64>, triangles: &[Triangle]) -> Matrix3<f64> {
    let origin = triangles[0].corners[0];
    let (mut low, mut high) = (Vector::zeros(), Vector::zeros());
    for corner in triangle::corners(triangles) {
        let x = frame.tr_mul(&(corner - origin));
        (low, high) = (low.inf(&x), high.sup(&x));
    }
    let thin = (high - low).imin();
    Matrix3::from_columns(&[1, 2, 3].map(|i| frame.column((thin + i) % 3).into_owned()))
}

/// Half-length, in the rectangle's plane, of the sphere of `radius` at the height of `p`.
fn chord(p: &Vector, middle: f64, radius: f64) -> f64 {
    (radius * radius - (p.z - middle).powi(2)).max(0.0).sqrt()
}

/// The shortest side along an axis for which the spheres at its ends reach the first and the last point.
fn side(points: &[Vector], axis: usize, middle: f64, radius: f64) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in points {
        let reach = chord(p, middle, radius);
        (low, high) = (low.min(p[axis] + reach), high.max(p[axis] - reach));
    }
    // One sphere reaches all: any place between will do.
    if low > high { [f64::midpoint(low, high); 2] } else { [low, high] }
}

/// Lengthens the sides where a point beyond a corner is outside the corner's sphere: the corner moves along the diagonal until the sphere
/// reaches the point.
fn grown_at_corners(points: &[Vector], [mut x, mut y]: [[f64; 2]; 2], middle: f64, radius: f64) -> [[f64; 2]; 2] {
    for p in points {
        for (end_x, sign_x) in [(0, -1.0), (1, 1.0)] {
            for (end_y, sign_y) in [(0, -1.0), (1, 1.0)] {
                let (dx, dy) = (sign_x * (p.x - x[end_x]), sign_y * (p.y - y[end_y]));
                if dx <= 0.0 || dy <= 0.0 {
                    continue;
                }
                let (along, across) = ((dx + dy) * FRAC_1_SQRT_2, (dx - dy) * FRAC_1_SQRT_2);
                let reach = (radius * radius - across * across - (p.z - middle).powi(2)).max(0.0).sqrt();
                let step = (along - reach).max(0.0) * FRAC_1_SQRT_2;
                x[end_x] += sign_x * step;
                y[end_y] += sign_y * step;
            }
        }
    }
    [x, y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use obbtree::cases::meshes;

    #[test]
    fn a_ball_gets_a_ball() {
        let fitted = Rss::fit(&meshes::sphere(10.0, 24, 12).triangles());
        // The facets' corners lie on the sphere; the rectangle shrinks to within what the division leaves of it.
        assert!(fitted.half[0] < 1.0 && fitted.half[1] < 1.0 && (fitted.radius - 10.0).abs() < 0.4, "{fitted:?}");
    }

    #[test]
    fn a_plate_gets_its_own_rectangle() {
        let fitted = Rss::fit(&meshes::cuboid(20.0, 12.0, 2.0).triangles());
        let mut half = fitted.half;
        half.sort_by(f64::total_cmp);
        // A corner is in the plane of the top, where the sphere's reach is nil: the rectangle is as large as the plate.
        assert!((half[1] - 10.0).abs() < 1e-6 && (half[0] - 6.0).abs() < 1e-6 && (fitted.radius - 1.0).abs() < 1e-6);
        // 4·10·6·2 + π·1²·(20 + 12) + 4/3 π.
        let volume = 480.0 + PI * 32.0 + 4.0 / 3.0 * PI;
        assert!((fitted.volume() - volume).abs() < 1e-3, "{}", fitted.volume());
        // 8·10·6 + 4π·(10 + 6)·1 + 4π·1².
        let area = 480.0 + PI * 64.0 + PI * 4.0;
        assert!((fitted.surface_area() - area).abs() < 1e-3, "{}", fitted.surface_area());
    }

    #[test]
    fn it_is_around_its_contents_wherever_they_are() {
        let place = Isometry::new(Vector::new(50.0, -30.0, 20.0), Vector::new(0.4, -0.9, 0.5));
        let fitted = Rss::fit(&meshes::moved(&meshes::cuboid(20.0, 12.0, 2.0), 1.0, &place).triangles());
        assert!((fitted.centre() - place * Point::origin()).norm() < 1e-6);
        assert!((fitted.size() - (10.0_f64.hypot(6.0) + 1.0)).abs() < 1e-6);
        let longest = fitted.split_axes(&[])[0].into_inner();
        assert!((longest.dot(&(place * Vector::x())).abs() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn figures_and_outline_are_those_of_rectangle_and_radius() {
        let fitted = Rss { half: [5.0, 3.0], radius: 2.0, ..Rss::fit(&meshes::cuboid(20.0, 12.0, 2.0).triangles()) };
        assert!((fitted.volume() - (240.0 + 64.0 * PI + 32.0 / 3.0 * PI)).abs() < 1e-9);
        assert!((fitted.surface_area() - (120.0 + 64.0 * PI + 16.0 * PI)).abs() < 1e-9);
        let ends: Vec<Vector> =
            fitted.outline().iter().flatten().map(|end| fitted.axes.tr_mul(&(end - fitted.centre))).collect();
        assert!(ends.iter().all(|end| (point_squared(end, fitted.half) - 4.0).abs() < 1e-9));
        // The shortest line is a twelfth of a half circle, as a chord.
        let shortest = 4.0 * (PI / 24.0).sin();
        assert!(fitted.outline().iter().all(|[start, end]| (end - start).norm() > shortest - 1e-9));
        for (axis, most) in [7.0, 5.0, 2.0].into_iter().enumerate() {
            let reach = |sign: f64| ends.iter().map(|end| sign * end[axis]).fold(0.0, f64::max);
            assert!((reach(1.0) - most).abs() < 1e-9 && (reach(-1.0) - most).abs() < 1e-9, "{axis}");
        }
    }

    #[test]
    fn a_corner_moves_out_until_its_sphere_reaches_the_point() {
        for (sign_x, sign_y) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            // On the diagonal through a corner of the square of side 4 around (6, 6); 5 beyond that corner, with spheres of radius 2.
            let corner = Vector::new(6.0 + sign_x * 2.0, 6.0 + sign_y * 2.0, 0.0);
            let point = corner + Vector::new(sign_x, sign_y, 0.0) * (5.0 * FRAC_1_SQRT_2);
            let [x, y] = grown_at_corners(&[point], [[4.0, 8.0]; 2], 0.0, 2.0);
            let moved = Vector::new(x[usize::from(sign_x > 0.0)], y[usize::from(sign_y > 0.0)], 0.0);
            assert!(((point - moved).norm() - 2.0).abs() < 1e-12, "{x:?} {y:?}");
            assert!((moved - corner).norm() > 2.99 && (x[1] - x[0] - y[1] + y[0]).abs() < 1e-12);
            assert_eq!(x[usize::from(sign_x < 0.0)], 6.0 - sign_x * 2.0, "the other side stays");
        }
        // A point beside the diagonal through the corner (1, 1): a sphere of radius 1 around (3, 3) reaches it.
        let [x, y] = grown_at_corners(&[Vector::new(3.0, 4.0, 0.0)], [[-1.0, 1.0]; 2], 0.0, 1.0);
        assert!((x[1] - 3.0).abs() < 1e-12 && (y[1] - 3.0).abs() < 1e-12, "{x:?} {y:?}");
    }

    #[test]
    fn plates_part_at_their_radii() {
        let plate = Rss::fit(&meshes::cuboid(20.0, 12.0, 2.0).triangles());
        for shift in [[0.0, 0.0, 2.0], [22.0, 0.0, 0.0], [20.0 + 1.2, 12.0 + 1.6, 0.0]] {
            let pose = |part: f64| Rss::pose(&Isometry::translation(shift[0] * part, shift[1] * part, shift[2] * part));
            assert!(
                plate.overlaps(&plate, &pose(1.0 - 1e-6)) && !plate.overlaps(&plate, &pose(1.0 + 1e-6)),
                "{shift:?}"
            );
            assert!(plate.gap_mm(&plate, &pose(1.0 + 1e-3)) > 0.0 && plate.gap_mm(&plate, &pose(1.0 - 1e-6)) == 0.0);
        }
    }
}
