//! A box along the axes of its mesh, in 24 bytes.
//!
//! All boxes of a mesh are turned alike, so that the products of the axes, which are most of the work of [`super::boxes`], are the same in all visits
//! of a query, and nothing is decoded. Its box contains its points by the argument of [`super::oriented`], whose axes are exact here. The slack is that
//! of [`super::boxes`] with exact v_j, and with u_i and R rounded once: no term is larger.

use super::boxes::{BoxRelation, dot};
use super::lanes::{Lanes, Row, three};
use super::node::WIDTH;
use super::oriented::tight;
use super::plain::Plain;
use super::pose::Motion;
use super::visit::Visits;
use super::volume::{WideVolume, point, row};
use crate::engine::geometry::Point;
use nalgebra::Matrix3;

/// A box relative to an origin, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aligned {
    centre: [f32; 3],
    half: [f32; 3],
}

/// Boxes of the other mesh in the nodes' frames but for their centres: axes, and half-lengths, mm.
#[derive(Clone, Copy)]
pub struct Tilted<L> {
    axes: [[L; 3]; 3],
    half: [L; 3],
}

impl WideVolume for Aligned {
    const TURNS: bool = false;
    /// Centre and half-lengths.
    type Eight = [[f32; WIDTH]; 6];
    type Moved<L: Lanes> = Tilted<L>;
    type Relation<L: Lanes> = BoxRelation<L>;

    fn fit(_: &Matrix3<f64>, origin: [f32; 3], corners: impl Iterator<Item = [Point; 4]> + Clone) -> Self {
        let (centre, half) = tight(&Matrix3::identity(), origin, corners);
        Self { centre, half }
    }

    #[inline(always)]
    fn centre(&self) -> [f32; 3] {
        self.centre
    }

    #[inline(always)]
    fn reach(&self) -> f32 {
        self.half[0] + self.half[1] + self.half[2]
    }

    #[inline(always)]
    fn size(&self) -> f32 {
        self.half[0] * self.half[1] * self.half[2]
    }

    #[inline(always)]
    fn put(&self, eight: &mut Self::Eight, place: usize) {
        for k in 0..3 {
            (eight[k][place], eight[3 + k][place]) = (self.centre[k], self.half[k]);
        }
    }

    #[inline(always)]
    fn get(eight: &Self::Eight, place: usize) -> Self {
        Self { centre: three!(k => eight[k][place]), half: three!(k => eight[3 + k][place]) }
    }

    #[inline(always)]
    fn moved<'a, L: Lanes>(one: &impl Fn(usize) -> Self, motion: &impl Fn(usize) -> &'a Motion) -> (Tilted<L>, L) {
        let [x, y, z, _] = L::spread(L::Row::of(|i| row(one(i).half)));
        let axes = three!(k => {
            let [x, y, z, _] = L::spread(Motion::axis(motion, k));
            [x, y, z]
        });
        (Tilted { axes, half: [x, y, z] }, x + y + z)
    }

    #[inline(always)]
    fn relation<L: Lanes>(part: usize, visits: &Visits<Self, L>) -> BoxRelation<L> {
        let b = three!(k => visits.eight(part, |eight| &eight[3 + k]));
        let d = three!(k => visits.eight(part, |eight| &eight[k]) - visits.centre[k]);
        let Tilted { axes, half } = visits.one;
        BoxRelation::new(half, b, axes, three!(i => dot(&axes[i], &d)), d)
    }

    fn plain(&self, origin: [f32; 3]) -> Plain {
        let half = self.half.map(f64::from).into();
        Plain::Box { axes: Matrix3::identity(), centre: point(origin, self.centre), half }
    }
}
