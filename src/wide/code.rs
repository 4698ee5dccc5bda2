//! A box in 36 bytes: centre, rotation and half-lengths in `f32`, rounded outward.
//!
//! The box that a code stands for is exact: centre `origin + centre`, axes the rotation of [`super::turn`], half-lengths
//! `half`, all in real numbers. It contains the points it was made for, by this argument. Let u = 2⁻⁵³, d = p - origin for a point p,
//! r the largest |d|, and c the rounded centre. A computed projection on a decoded axis is within 16√3·u|d| (the axis) + u|d| (the
//! difference) + 3u|d| (the products and sums) < 32u·r of the true one, and that of c within 31u|c| likewise. The difference of the two
//! adds 1u(r + |c|), so that the half-length, their largest difference, is at most 34u(r + |c|) too small, and
//! `PAD`·(r + |c|) with 64u restores it. Then the half-length is rounded up to `f32`.

use super::lanes::{DOUBLES, DoubleLanes, Machine, Simd, Work, three};
use super::turn;
use crate::geometry::grid::Coordinate;
use crate::geometry::{Point, Vector};
use nalgebra::Matrix3;

/// What a half-length is lengthened by, relative to the distances involved: 64·2⁻⁵³, see above.
const PAD: f64 = 64.0 / 9_007_199_254_740_992.0;

/// A box relative to an origin, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Code {
    pub centre: [f32; 3],
    /// See [`super::turn`].
    pub turn: [f32; 3],
    pub half: [f32; 3],
}

impl Code {
    /// The tight box around all `points` along the axes of `frame` (columns of a rotation), as near as `f32` has them.
    pub fn fit<'a>(frame: &Matrix3<f64>, origin: [f32; 3], points: impl Iterator<Item = &'a [Point]>) -> Self {
        let turn = turn::encode(frame);
        let axes = turn::decode(turn);
        let Extent { low, high, farthest } =
            Simd::in_use().run(Extents { axes: &axes, from: origin.map(f64::from), points });
        let centre = (axes * ((low + high) * 0.5)).map(|x| x as f32);
        let kept = centre.map(f64::from);
        let middle = axes.tr_mul(&kept);
        let pad = PAD * (farthest + kept.norm());
        let half = (high - middle).sup(&(middle - low)).map(|h| rounded_up(h + pad));
        Self { centre: centre.into(), turn, half: half.into() }
    }

    /// An eighth of the volume, mm³: what tells which of two boxes is the larger. By surface area queries open up to a tenth more nodes, by
    /// length a third.
    #[inline(always)]
    pub fn volume(&self) -> f32 {
        let [x, y, z] = self.half;
        x * y * z
    }
}

/// How far points reach along axes, mm, from an origin; and how far the farthest of them is from it.
struct Extent {
    low: Vector,
    high: Vector,
    farthest: f64,
}

/// The search for it, which sees every corner once on each level of the tree.
struct Extents<'a, I> {
    axes: &'a Matrix3<f64>,
    from: [f64; 3],
    points: I,
}

impl<'a, I: Iterator<Item = &'a [Point]>> Work for Extents<'_, I> {
    type Output = Extent;

    #[inline(always)]
    fn run<M: Machine>(self) -> Extent {
        let Self { axes, from, points } = self;
        let rows = three!(j => M::Double::load(&[axes[(j, 0)], axes[(j, 1)], axes[(j, 2)], 0.0]));
        let (mut low, mut high) = (M::Double::all(f64::INFINITY), M::Double::all(f64::NEG_INFINITY));
        let mut farthest: f64 = 0.0;
        for points in points {
            for p in points {
                let d = [p.x - from[0], p.y - from[1], p.z - from[2]];
                let [x, y, z] = three!(j => rows[j] * M::Double::all(d[j]));
                let along = x + y + z;
                (low, high) = (along.min(low), along.max(high));
                let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                farthest = if squared > farthest { squared } else { farthest };
            }
        }
        let vector = |lanes: [f64; DOUBLES]| Vector::new(lanes[0], lanes[1], lanes[2]);
        Extent { low: vector(low.stored()), high: vector(high.stored()), farthest: farthest.sqrt() }
    }
}

/// The least `f32` that is not less than `x`.
pub(super) fn rounded_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use proptest::prelude::*;

    #[test]
    fn a_box_along_the_axes_is_as_long_as_its_contents() {
        let points = [Point::new(1.0, 2.0, 3.0), Point::new(5.0, 4.0, 3.0)];
        let code = Code::fit(&Matrix3::identity(), [1.0, 1.0, 1.0], std::iter::once(points.as_slice()));
        assert_eq!(code.centre, [2.0, 2.0, 2.0]);
        for (half, exact) in code.half.into_iter().zip([2.0_f32, 1.0, 0.0]) {
            assert!(half >= exact && half <= exact + 1e-6, "{half}");
        }
        assert_eq!((rounded_up(0.1), rounded_up(0.5)), (0.1_f32, 0.5)); // 0.1 in f32 is above 0.1
        assert_eq!(rounded_up(0.3), 0.3_f32.next_down().next_up().max(0.3_f32));
    }

    proptest! {
        /// Every point is inside, at any scale and however far the origin, by a computation whose own error is below the part of the pad
        /// that is left.
        #[test]
        fn the_box_contains_its_points(
            turn in prop::array::uniform3(-4.0..4.0_f64),
            points in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..12),
            offset in prop::array::uniform3(-100.0..100.0_f64),
            exponent in -9..6_i32,
        ) {
            let scale = 10f64.powi(exponent);
            let points: Vec<Point> =
                points.into_iter().map(|p| Point::from((Vector::from(p) + Vector::from(offset)) * scale)).collect();
            let origin = (Vector::from(offset) * scale).map(|x| x as f32);
            let frame = Rotation3::from_scaled_axis(Vector::from(turn)).into_inner();
            let code = Code::fit(&frame, origin.into(), std::iter::once(points.as_slice()));
            let axes = turn::decode(code.turn);
            for p in &points {
                let d = p.coords - origin.map(f64::from) - Vector::from(code.centre.map(f64::from));
                let x = axes.tr_mul(&d);
                for k in 0..3 {
                    prop_assert!(x[k].abs() <= f64::from(code.half[k]), "{} {}", x[k], code.half[k]);
                }
            }
        }
    }
}
