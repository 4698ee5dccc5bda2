//! Centre rules: the position of a box along its axes, once the axes are chosen.

use crate::geometry::Vector;

/// How centre and half-lengths follow from the extent of the contents.
pub trait CentreRule {
    /// The centre relative to the mean, and the half-lengths, mm, along the box's axes. `low` and `high` are the lowest and highest
    /// coordinates of the corners relative to the mean.
    fn centre_and_half(low: &Vector, high: &Vector) -> (Vector, Vector);
}

/// Centre in the middle of the extent: the tight box, which contains everything.
#[derive(Clone, Copy, Debug)]
pub struct MidExtent;

impl CentreRule for MidExtent {
    fn centre_and_half(low: &Vector, high: &Vector) -> (Vector, Vector) {
        ((low + high) * 0.5, (high - low) * 0.5)
    }
}

/// Centre at the mean, with the half-lengths of the tight box: the text of the paper taken literally. Contents on the side away from the
/// mean lie outside.
#[derive(Clone, Copy, Debug)]
pub struct AtMean;

impl CentreRule for AtMean {
    fn centre_and_half(low: &Vector, high: &Vector) -> (Vector, Vector) {
        (Vector::zeros(), (high - low) * 0.5)
    }
}

/// Centre at the mean, half-lengths up to the farthest corner on either side: contains everything, loosely.
#[derive(Clone, Copy, Debug)]
pub struct SymmetricAboutMean;

impl CentreRule for SymmetricAboutMean {
    fn centre_and_half(low: &Vector, high: &Vector) -> (Vector, Vector) {
        (Vector::zeros(), high.sup(&-low))
    }
}
