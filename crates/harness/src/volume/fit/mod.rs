//! Fits of oriented boxes: a rule for the axes ([`frame`]) and a rule for the centre ([`centre`]), separate so that the effect of each can
//! be measured.

pub mod centre;
pub mod dito;
pub mod frame;
pub mod minimum;

use super::shape::obb::Obb;
use crate::geometry::separating_axes::pad_mm;
use crate::geometry::{Point, Triangle, Vector, triangle};
use centre::CentreRule;
use frame::FrameRule;
use nalgebra::Matrix3;

/// A centre rule: centre and half-lengths from the lowest and highest coordinates, as in [`CentreRule::centre_and_half`].
pub type Centring = fn(&Vector, &Vector) -> (Vector, Vector);

/// The box around `triangles` (at least one, mm) along the axes of the rule `F`, centred by the rule `C`.
pub fn oriented<F: FrameRule, C: CentreRule>(triangles: &[Triangle]) -> Obb {
    around(F::mean_and_axes(triangles), C::centre_and_half, triangles)
}

/// The box around `triangles` (at least one, mm) along `axes` (columns of a rotation); `centring` places its centre relative to `mean`
/// (mm).
pub fn around((mean, axes): (Point, Matrix3<f64>), centring: Centring, triangles: &[Triangle]) -> Obb {
    let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    let mut reach: f64 = 0.0;
    for corner in triangle::corners(triangles) {
        // About the mean, so that a part far from its origin loses nothing.
        let x = axes.tr_mul(&(corner - mean));
        (low, high) = (low.inf(&x), high.sup(&x));
        reach = reach.max(corner.coords.amax());
    }
    let (centre, half) = centring(&low, &high);
    Obb { axes, centre: mean + axes * centre, half: half + Vector::repeat(pad_mm(reach)) }
}
