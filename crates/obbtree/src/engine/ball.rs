//! A ball, in 16 bytes.
//!
//! It contains its points: the distance of a point from the centre is found in `f64` with fewer than ten roundings, and the pad of
//! [`super::oriented`] is 64 of them; then the radius is rounded up to `f32`.
//!
//! The slack, as in [`super::boxes`]: d = c - s is wrong by at most u|s| + u|d| ≤ 2uD, its length by 2.5u|d| more (squares, two sums and a root), the
//! sum of the radii by u(A + B), the difference by u(D + A + B): together 5.5uD + 2u(A + B).

use super::boxes::{LOWERED, dot};
use super::lanes::{Lanes, Row, three};
use super::node::WIDTH;
use super::oriented::{Extent, PAD, rounded_up};
use super::plain::Plain;
use super::pose::Motion;
use super::visit::Visits;
use super::volume::{Relation, WideVolume, point};
use crate::engine::geometry::Point;
use nalgebra::Matrix3;

/// A ball relative to an origin, mm, about the middle of its contents' bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    centre: [f32; 3],
    radius: f32,
}

/// How far the centres are from one another, the one ball's radius, and the others'.
#[derive(Clone, Copy)]
pub struct BallRelation<L> {
    between: L,
    radius: L,
    radii: L,
}

impl WideVolume for Ball {
    const TURNS: bool = false;
    /// Centre and radius.
    type Eight = [[f32; WIDTH]; 4];
    type Moved<L: Lanes> = L;
    type Relation<L: Lanes> = BallRelation<L>;

    fn fit(_: &Matrix3<f64>, origin: [f32; 3], corners: impl Iterator<Item = [Point; 4]> + Clone) -> Self {
        let Extent { low, high, .. } = Extent::along(&Matrix3::identity(), origin, corners.clone());
        let centre = ((low + high) * 0.5).map(|x| x as f32);
        let middle = point(origin, centre.into());
        let farthest = corners.flatten().map(|p| (p - middle).norm_squared()).fold(0.0, f64::max).sqrt();
        let pad = PAD * (farthest + centre.map(f64::from).norm());
        Self { centre: centre.into(), radius: rounded_up(farthest + pad) }
    }

    #[inline(always)]
    fn centre(&self) -> [f32; 3] {
        self.centre
    }

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.radius
    }

    #[inline(always)]
    fn size(&self) -> f32 {
        self.radius
    }

    #[inline(always)]
    fn put(&self, eight: &mut Self::Eight, place: usize) {
        let [x, y, z] = self.centre;
        for (row, number) in eight.iter_mut().zip([x, y, z, self.radius]) {
            row[place] = number;
        }
    }

    #[inline(always)]
    fn get(eight: &Self::Eight, place: usize) -> Self {
        Self { centre: three!(k => eight[k][place]), radius: eight[3][place] }
    }

    #[inline(always)]
    fn moved<'a, L: Lanes>(one: &impl Fn(usize) -> Self, _: &impl Fn(usize) -> &'a Motion) -> (L, L) {
        let [radius, ..] = L::spread(L::Row::of(|i| [one(i).radius, 0.0, 0.0, 0.0]));
        (radius, radius)
    }

    #[inline(always)]
    fn relation<L: Lanes>(part: usize, visits: &Visits<Self, L>) -> BallRelation<L> {
        let d = three!(k => visits.eight(part, |eight| &eight[k]) - visits.centre[k]);
        BallRelation { between: dot(&d, &d).sqrt(), radius: visits.one, radii: visits.eight(part, |eight| &eight[3]) }
    }

    fn plain(&self, origin: [f32; 3]) -> Plain {
        Plain::Ball { centre: point(origin, self.centre), radius: f64::from(self.radius) }
    }
}

impl<L: Lanes> Relation<L> for BallRelation<L> {
    #[inline(always)]
    fn quick_gaps(&self) -> [L; 3] {
        [self.between - (self.radius + self.radii); 3]
    }

    #[inline(always)]
    fn gap(&self, quick_gaps: [L; 3]) -> L {
        quick_gaps[0]
    }

    #[inline(always)]
    fn larger(&self) -> u32 {
        self.radii.exceeds(self.radius)
    }

    #[inline(always)]
    fn least_mm(&self, slack: L, _: impl Fn(L) -> bool) -> L {
        (self.between - (self.radius + self.radii) - slack).max(L::all(0.0)) * L::all(LOWERED)
    }
}
