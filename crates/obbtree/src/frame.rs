//! Where the engine sees a mesh. Its grid is 2⁻²⁶ wide and reaches to 4096; a mesh of any size is multiplied by a power of two, which loses
//! nothing, and moved to an origin near it where it is far from its own.
//!
//! Powers are multiples of 2⁸: meshes of similar size then share one, and two meshes of different size need one more tree at most in
//! nearly all scenes. The largest coordinate is then above 16, and the grid 2⁻³⁰ to 2⁻³⁸ of it, by the unit that it has.

use crate::mesh::power_of_two;
use nalgebra::Point3;

/// The engine's coordinates reach to 2 to the power of this.
const REACH: i32 = 12;
/// Largest translation that the engine's single precision can square, as an exponent of two in its units.
pub(crate) const FARTHEST: i32 = 60;
/// Exponents are multiples of this.
const STEP: i32 = 8;
/// The least exponent, with which a coordinate of 2⁻⁵⁰⁰ is 16, for meshes that are a point or were moved to an origin near by.
const LEAST: i32 = -504;
/// How many times its own half-width a mesh must be from its origin to be moved.
const FAR: f64 = 16.0;

/// The origin of the engine's coordinates in the mesh's frame, and the power of two that its unit is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    pub origin: Point3<f64>,
    pub exponent: i32,
}

impl Frame {
    /// The finest that a mesh fits, by its smallest and largest coordinates.
    pub fn of([low, high]: [Point3<f64>; 2]) -> Self {
        let farthest = low.coords.amax().max(high.coords.amax());
        // Halved first: the difference may exceed the largest number.
        let half = (high.coords * 0.5 - low.coords * 0.5).amax();
        let at_home = Self { origin: Point3::origin(), exponent: exponent_for(farthest, REACH) };
        if half == 0.0 || farthest <= FAR * half {
            return at_home;
        }
        // Rounded to a multiple of the mesh's own size, so that nothing is lost when it is subtracted.
        let coarse = power_of_two(exponent_of(half).max(exponent_of(farthest) - 60));
        let origin = (low.coords * 0.5 + high.coords * 0.5).map(|x| (x / coarse).round() * coarse);
        let exponent = exponent_for((low.coords - origin).amax().max((high.coords - origin).amax()), REACH);
        if exponent < at_home.exponent { Self { origin: origin.into(), exponent } } else { at_home }
    }

    /// A point of the mesh as the engine sees it in units of 2 to the power of `exponent`.
    pub fn seen(&self, point: &Point3<f64>, exponent: i32) -> Point3<f64> {
        Point3::from((point - self.origin) * power_of_two(-exponent))
    }
}

/// The largest power of two that is not above a number, as its exponent; subnormal numbers have that of the smallest normal one.
fn exponent_of(x: f64) -> i32 {
    ((x.to_bits() >> 52) as i32 - 1023).max(-1022)
}

/// The least multiple of [`STEP`] in units of which a number is at most 2 to the power of `reach`.
pub(crate) fn exponent_for(farthest: f64, reach: i32) -> i32 {
    let floor = exponent_of(farthest);
    let beyond = floor + i32::from(farthest > power_of_two(floor)) - reach;
    (-(-beyond).div_euclid(STEP) * STEP).max(LEAST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Collider;
    use crate::engine::geometry::grid::{LIMIT_MM, STEP_MM};
    use crate::mesh::Mesh;
    use nalgebra::Isometry3;

    fn frame(points: [[f64; 3]; 2]) -> Frame {
        Frame::of(Mesh::new(points, [[0, 1, 0]]).unwrap().bounds())
    }

    #[test]
    fn the_largest_coordinate_is_in_the_upper_part_of_the_grids_range() {
        assert_eq!(power_of_two(REACH), LIMIT_MM);
        for (x, exponent) in [(4096.0, 0), (4097.0, 8), (16.1, 0), (16.0, -8), (1e6, 8), (1.1e6, 16), (0.05, -16)] {
            assert_eq!(frame([[x, 0.0, 0.0], [-x, 0.0, 0.0]]), Frame { origin: Point3::origin(), exponent }, "{x}");
        }
        for k in -490..=500 {
            let x = 1.37 * power_of_two(k - 1);
            let seen = x * power_of_two(-exponent_for(x, REACH));
            assert!(seen > 16.0 && seen <= LIMIT_MM, "{k}: {seen}");
        }
        assert_eq!([0.0, 5e-324, 1e-160].map(|x| exponent_for(x, REACH)), [LEAST; 3]);
        assert_eq!(exponent_for(Mesh::MAX_COORDINATE, REACH), 488);
        assert_eq!([60, 61, 1022].map(|k| exponent_for(power_of_two(k), FARTHEST)), [0, 8, 968]);
    }

    /// Plates of 4000 mm, 10⁻⁷ mm apart.
    #[test]
    fn the_grid_and_what_nearly_touches_depend_on_the_unit() {
        for (unit, exponent, touching) in
            [(1.0, 0, false), (1e-3, -8, false), (256.0, 8, false), (10.0, 8, true), (1e3, 16, true)]
        {
            let at =
                |z: f64| [[0.0, 0.0, z], [4000.0, 0.0, z], [0.0, 4000.0, z]].map(|corner| corner.map(|x| x * unit));
            let [a, b] = [0.0, 1e-7].map(|z| Collider::new(Mesh::new(at(z), [[0, 1, 2]]).unwrap()));
            assert_eq!(a.frame().exponent, exponent, "{unit}");
            let step = power_of_two(exponent) * STEP_MM / (4000.0 * unit);
            assert!((power_of_two(-38)..=power_of_two(-30)).contains(&step), "{unit}: {step}");
            assert_eq!(a.collides(&b, &Isometry3::identity()), Ok(touching), "{unit}");
        }
    }

    #[test]
    fn a_mesh_far_from_its_origin_is_moved_without_rounding() {
        let points = [[1e9 + 0.125, -3e9, 7.25], [1e9 + 2.5, -3e9 + 1.0, 9.0]];
        let frame = frame(points);
        assert_eq!(frame.exponent, -8);
        for p in points.map(Point3::from) {
            let seen = frame.seen(&p, frame.exponent);
            assert!(seen.coords.amax() <= LIMIT_MM);
            assert_eq!(frame.origin + seen.coords * power_of_two(frame.exponent), p);
        }
        // Nothing is gained: the mesh stays where it is.
        assert_eq!(self::frame([[0.0, 0.0, 0.0], [20.0, 3.0, 1.0]]).origin, Point3::origin());
        assert_eq!(self::frame([[3000.0, 0.0, 0.0], [3040.0, 3.0, 1.0]]).origin, Point3::origin());
        // At the ends of the range.
        let thin = self::frame([[power_of_two(400), 1e-300, 0.0], [power_of_two(400), -1e-300, 0.0]]);
        assert_eq!((thin.origin.x, thin.exponent), (power_of_two(400), LEAST));
    }
}
