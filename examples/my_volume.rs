//! A bounding volume of one's own, measured beside all the others: an axis-aligned ellipsoid.
//!
//! ```sh
//! cargo run --release --example my_volume -- list
//! cargo run --release --example my_volume -- repro --profile smoke --out results/ellipsoid
//! ```
//!
//! Say how it is fitted, what a tree tests and what it looks like; register the type; hand the registry to the command line: nothing else.
//! (A volume of a shape that bvbench has needs the fit alone: `obb_area.rs`.) The overlap test bounds both
//! ellipsoids along a handful of directions; one along which they are apart proves that they do not meet.

use bvbench::geometry::separating_axes::pad_mm;
use bvbench::geometry::{Isometry, Point, Triangle, Vector, rigid, triangle};
use bvbench::registry::{self, Variant};
use bvbench::tree::SplitRule;
use bvbench::volume::{BoundingVolume, Info, Segment, Shape, Solid, coordinate_axes_by_extent};
use nalgebra::{Matrix3, Unit};
use std::f64::consts::{PI, TAU};
use std::process::ExitCode;

/// A centre and three semi-axes along the coordinate axes, mm, mesh frame.
#[derive(Clone, Debug)]
struct Ellipsoid {
    centre: Point,
    semi: Vector,
}

/// Rotation and translation, mm, from the second mesh to the first.
struct Pose {
    rotation: Matrix3<f64>,
    translation: Vector,
}

/// Flat contents get at least this semi-axis, mm, so that the ellipsoid stays one.
const THINNEST_MM: f64 = 1e-3;

impl Ellipsoid {
    /// Half the extent along a direction in the mesh frame, times the direction's length.
    fn reach(&self, direction: &Vector) -> f64 {
        self.semi.component_mul(direction).norm()
    }

    /// The distance from a point outside, mm, or a little more: of the point of the surface in whose normal direction it lies, by bisection
    /// (D. Eberly, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid", Geometric Tools, 2013, section 4).
    fn distance_mm(&self, point: &Point) -> f64 {
        let out = point - self.centre;
        let squares = self.semi.component_mul(&self.semi);
        // At `t` the point of a surface around or inside this one, as the length of its scaled coordinates is above or below 1.
        let nearest = |t: f64| out.component_mul(&squares).component_div(&squares.add_scalar(t));
        let (mut low, mut high) = (0.0, self.semi.component_mul(&out).norm());
        for _ in 0..100 {
            let t = 0.5 * (low + high);
            let outside = nearest(t).component_div(&self.semi).norm() > 1.0;
            (low, high) = if outside { (t, high) } else { (low, t) };
        }
        (out - nearest(high)).norm()
    }

    /// The direction in which the surface faces where the line to `point` leaves it.
    fn facing(&self, point: &Vector) -> Vector {
        point.component_div(&self.semi.component_mul(&self.semi))
    }
}

impl BoundingVolume for Ellipsoid {
    const INFO: Info = Info {
        id: "ellipsoid",
        label: "ellipsoid",
        reference: "axis-aligned ellipsoid with the proportions of the box (examples/my_volume.rs)",
        safe: true,
    };

    type Shape = Self;

    fn fit(triangles: &[Triangle]) -> Self {
        let (low, high) = triangle::bounds(triangles).expect("a node holds at least one triangle");
        let centre = nalgebra::center(&low, &high);
        let half = ((high - low) * 0.5).map(|h| h.max(THINNEST_MM));
        let scale = triangle::corners(triangles).map(|p| (p - centre).component_div(&half).norm()).fold(0.0, f64::max);
        let pad = pad_mm(low.coords.amax().max(high.coords.amax()));
        Self { centre, semi: half * scale + Vector::repeat(pad) }
    }
}

impl Shape for Ellipsoid {
    type Pose = Pose;

    fn pose(a_from_b: &Isometry) -> Pose {
        Pose { rotation: rigid::rotation(a_from_b), translation: a_from_b.translation.vector }
    }

    fn overlaps(&self, other: &Self, pose: &Pose) -> bool {
        let t = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        let apart = |d: &Vector| d.dot(&t).abs() > self.reach(d) + other.reach(&pose.rotation.tr_mul(d));
        if apart(&t) || apart(&self.facing(&t)) || apart(&(pose.rotation * other.facing(&pose.rotation.tr_mul(&t)))) {
            return false;
        }
        (0..3).all(|i| !apart(&Vector::ith(i, 1.0)) && !apart(&pose.rotation.column(i).into_owned()))
    }

    fn gap_mm(&self, other: &Self, pose: &Pose) -> f64 {
        let t = pose.rotation * other.centre.coords + pose.translation - self.centre.coords;
        let gap = |d: Vector| d.dot(&t).abs() - self.reach(&d) - other.reach(&pose.rotation.tr_mul(&d));
        t.try_normalize(0.0).map_or(0.0, |d| gap(d).max(0.0))
    }

    fn size(&self) -> f64 {
        self.semi.norm_squared()
    }

    fn split_axes(&self, _: &[Triangle]) -> [Unit<Vector>; 3] {
        coordinate_axes_by_extent(&self.semi)
    }
}

impl Solid for Ellipsoid {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        let is_inside = (point - self.centre).component_div(&self.semi).norm() <= 1.0;
        is_inside || (slack_mm > 0.0 && self.distance_mm(point) <= slack_mm)
    }

    fn centre(&self) -> Point {
        self.centre
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.semi.product()
    }

    /// Within 1.1 %: K. Thomsen's formula, 2004.
    fn surface_area(&self) -> f64 {
        const P: f64 = 1.6075;
        let [a, b, c] = [self.semi.x, self.semi.y, self.semi.z].map(|s| s.powf(P));
        4.0 * PI * ((a * b + b * c + c * a) / 3.0).powf(1.0 / P)
    }

    fn outline(&self) -> Vec<Segment> {
        const STEPS: u32 = 48;
        let on = |axis: usize, step: u32| {
            let (sin, cos) = (TAU * f64::from(step) / f64::from(STEPS)).sin_cos();
            let mut offset = Vector::zeros();
            offset[(axis + 1) % 3] = cos;
            offset[(axis + 2) % 3] = sin;
            self.centre + offset.component_mul(&self.semi)
        };
        (0..3).flat_map(|axis| (0..STEPS).map(move |step| [on(axis, step), on(axis, step + 1)])).collect()
    }
}

fn main() -> ExitCode {
    bvbench::cli::main_with(registry::standard().with(Variant::of::<Ellipsoid>(SplitRule::VertexMean)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `cargo test --release --example my_volume`
    #[test]
    fn the_ellipsoid_conforms() {
        bvbench::conformance::check(&Variant::of::<Ellipsoid>(SplitRule::VertexMean))
            .unwrap_or_else(|fault| panic!("{fault}"));
    }
}
