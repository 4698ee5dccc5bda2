//! Where a box sits on its axes, and how long it is.

use crate::geometry::Vector;
use std::fmt::Debug;

/// A rule that places a box on its axes.
pub trait CentreRule: Debug + Send + Sync + 'static {
    /// The centre, as an offset from the mean, and the half-lengths, from the smallest and largest coordinates of the
    /// contents as seen from the mean; everything along the axes of the box, mm.
    fn place(low: &Vector, high: &Vector) -> (Vector, Vector);
}

/// In the middle of the extent, half of it long: the smallest box on these axes that holds the contents.
#[derive(Clone, Copy, Debug)]
pub enum MidExtent {}

/// At the mean, and half the extent long: what Xu and Zhang 2011 write, read literally. The tight box shifted by the
/// difference of mean and middle, so it leaves contents out on one side.
#[derive(Clone, Copy, Debug)]
pub enum MeanHalfExtent {}

/// At the mean, and as long to both sides as the contents reach to the farther one: holds the contents, loosely.
#[derive(Clone, Copy, Debug)]
pub enum MeanFarthest {}

impl CentreRule for MidExtent {
    fn place(low: &Vector, high: &Vector) -> (Vector, Vector) {
        ((low + high) / 2.0, (high - low) / 2.0)
    }
}

impl CentreRule for MeanHalfExtent {
    fn place(low: &Vector, high: &Vector) -> (Vector, Vector) {
        (Vector::zeros(), (high - low) / 2.0)
    }
}

impl CentreRule for MeanFarthest {
    fn place(low: &Vector, high: &Vector) -> (Vector, Vector) {
        (Vector::zeros(), high.sup(&-low))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_rules_on_an_extent_of_minus_one_to_five() {
        let (low, high) = (Vector::repeat(-1.0), Vector::repeat(5.0));
        let each = |offset: f64, half: f64| (Vector::repeat(offset), Vector::repeat(half));
        assert_eq!(MidExtent::place(&low, &high), each(2.0, 3.0));
        assert_eq!(MeanHalfExtent::place(&low, &high), each(0.0, 3.0));
        assert_eq!(MeanFarthest::place(&low, &high), each(0.0, 5.0));
    }
}
