//! A box in 36 bytes: centre, rotation and half-lengths in `f32`, rounded outward.
//!
//! The box that a code stands for is exact: centre `origin + centre`, axes the rotation of [`super::turn`], half-lengths
//! `half`, all in real numbers. It contains the points it was made for, by this argument. Let u = 2⁻⁵³, d = p - origin for a point p,
//! r the largest |d|, and c the rounded centre. A computed projection on a decoded axis is within 16√3·u|d| (the axis) + u|d| (the
//! difference) + 3u|d| (the products and sums) < 32u·r of the true one, and that of c within 31u|c| likewise. The difference of the two
//! adds 1u(r + |c|), so that the half-length, their largest difference, is at most 34u(r + |c|) too small, and
//! `PAD`·(r + |c|) with 64u restores it. Then the half-length is rounded up to `f32`.

use super::boxes::{BoxRelation, Turned, dot, seen_from};
use super::lanes::{DOUBLES, DoubleLanes, Lanes, Machine, Row, Simd, Work, three};
use super::node::WIDTH;
use super::plain::Plain;
use super::pose::Motion;
use super::turn;
use super::visit::Visits;
use super::volume::{WideVolume, point, row};
use crate::engine::geometry::grid::Coordinate;
use crate::engine::geometry::{Point, Vector};
use nalgebra::Matrix3;

/// What a half-length is lengthened by, relative to the distances involved: 64·2⁻⁵³, see above.
pub(super) const PAD: f64 = 64.0 / 9_007_199_254_740_992.0;

/// A box relative to an origin, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oriented {
    pub(super) centre: [f32; 3],
    /// See [`super::turn`].
    pub(super) turn: [f32; 3],
    pub(super) half: [f32; 3],
}

impl WideVolume for Oriented {
    const TURNS: bool = true;
    /// Centre, rotation and half-lengths.
    type Eight = [[f32; WIDTH]; 9];
    type Moved<L: Lanes> = Turned<L>;
    type Relation<L: Lanes> = BoxRelation<L>;

    /// Tight along the axes as near as `f32` has them.
    fn fit(frame: &Matrix3<f64>, origin: [f32; 3], corners: impl Iterator<Item = [Point; 4]> + Clone) -> Self {
        let turn = turn::encode(frame);
        let (centre, half) = tight(&turn::decode(turn), origin, corners);
        Self { centre, turn, half }
    }

    #[inline(always)]
    fn centre(&self) -> [f32; 3] {
        self.centre
    }

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.half[0] + self.half[1] + self.half[2]
    }

    /// An eighth of the volume, mm³. By surface area queries open up to a tenth more nodes, by length a third.
    #[inline(always)]
    fn size(&self) -> f32 {
        let [x, y, z] = self.half;
        x * y * z
    }

    #[inline(always)]
    fn put(&self, eight: &mut Self::Eight, place: usize) {
        for k in 0..3 {
            eight[k][place] = self.centre[k];
            eight[3 + k][place] = self.turn[k];
            eight[6 + k][place] = self.half[k];
        }
    }

    #[inline(always)]
    fn get(eight: &Self::Eight, place: usize) -> Self {
        Self {
            centre: three!(k => eight[k][place]),
            turn: three!(k => eight[3 + k][place]),
            half: three!(k => eight[6 + k][place]),
        }
    }

    #[inline(always)]
    fn moved<'a, L: Lanes>(one: &impl Fn(usize) -> Self, motion: &impl Fn(usize) -> &'a Motion) -> (Turned<L>, L) {
        let turn = L::spread(Motion::turned(motion, L::Row::of(|i| row(one(i).turn))));
        let [x, y, z, _] = L::spread(L::Row::of(|i| row(one(i).half)));
        (Turned { turn, half: [x, y, z] }, x + y + z)
    }

    #[inline(always)]
    fn relation<L: Lanes>(part: usize, visits: &Visits<Self, L>) -> BoxRelation<L> {
        let turns = three!(k => visits.eight(part, |eight| &eight[3 + k]));
        let b = three!(k => visits.eight(part, |eight| &eight[6 + k]));
        let d = three!(k => visits.eight(part, |eight| &eight[k]) - visits.centre[k]);
        let (r, along_a) = seen_from(&visits.one.turn, &turns, &d);
        let along_b = three!(j => dot(&[r[0][j], r[1][j], r[2][j]], &along_a));
        BoxRelation::new(visits.one.half, b, r, along_a, along_b)
    }

    fn plain(&self, origin: [f32; 3]) -> Plain {
        let (axes, half) = (turn::decode(self.turn), self.half.map(f64::from).into());
        Plain::Box { axes, centre: point(origin, self.centre), half }
    }
}

/// Centre and half-lengths, mm, of the box around corners along `axes` (columns of a rotation), as tight as rounding lets it be.
pub(super) fn tight(
    axes: &Matrix3<f64>,
    origin: [f32; 3],
    corners: impl Iterator<Item = [Point; 4]>,
) -> ([f32; 3], [f32; 3]) {
    let Extent { low, high, farthest } = Extent::along(axes, origin, corners);
    let centre = (axes * ((low + high) * 0.5)).map(|x| x as f32);
    let kept = centre.map(f64::from);
    let middle = axes.tr_mul(&kept);
    let pad = PAD * (farthest + kept.norm());
    let half = (high - middle).sup(&(middle - low)).map(|h| rounded_up(h + pad));
    (centre.into(), half.into())
}

/// How far points reach along axes, mm, from an origin; and how far the farthest of them is from it.
pub(super) struct Extent {
    pub low: Vector,
    pub high: Vector,
    pub farthest: f64,
}

impl Extent {
    /// Of corners, along the columns of a rotation and from an origin, mm.
    pub fn along(axes: &Matrix3<f64>, origin: [f32; 3], corners: impl Iterator<Item = [Point; 4]>) -> Self {
        Simd::in_use().run(Extents { axes, from: origin.map(f64::from), corners })
    }
}

/// The search for it, which sees every corner once on each level of the tree.
struct Extents<'a, I> {
    axes: &'a Matrix3<f64>,
    from: [f64; 3],
    corners: I,
}

impl<I: Iterator<Item = [Point; 4]>> Work for Extents<'_, I> {
    type Output = Extent;

    #[inline(always)]
    fn run<M: Machine>(self) -> Extent {
        let Self { axes, from, corners } = self;
        let rows = three!(j => M::Double::load(&[axes[(j, 0)], axes[(j, 1)], axes[(j, 2)], 0.0]));
        let (mut low, mut high) = (M::Double::all(f64::INFINITY), M::Double::all(f64::NEG_INFINITY));
        let mut farthest: f64 = 0.0;
        for patch in corners {
            for p in &patch {
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
    use crate::engine::geometry::Point;
    use nalgebra::Rotation3;
    use proptest::prelude::*;

    #[test]
    fn a_box_along_the_axes_is_as_long_as_its_contents() {
        let points = [Point::new(1.0, 2.0, 3.0), Point::new(5.0, 4.0, 3.0)];
        let fitted = Oriented::fit(&Matrix3::identity(), [1.0, 1.0, 1.0], points.iter().map(|p| [*p; 4]));
        assert_eq!(fitted.centre, [2.0, 2.0, 2.0]);
        for (half, exact) in fitted.half.into_iter().zip([2.0_f32, 1.0, 0.0]) {
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
            let fitted = Oriented::fit(&frame, origin.into(), points.iter().map(|p| [*p; 4]));
            let axes = turn::decode(fitted.turn);
            for p in &points {
                let d = p.coords - origin.map(f64::from) - Vector::from(fitted.centre.map(f64::from));
                let x = axes.tr_mul(&d);
                for k in 0..3 {
                    prop_assert!(x[k].abs() <= f64::from(fitted.half[k]), "{} {}", x[k], fitted.half[k]);
                }
            }
        }
    }
}
