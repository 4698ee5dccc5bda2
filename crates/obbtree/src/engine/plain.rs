//! Volumes of a tree in `f64`, for drawings and checks, and the way from slot to slot.

use super::node::{Contents, WIDTH, WideTree};
use super::volume::WideVolume;
use crate::engine::geometry::{Point, Triangle, Vector};
use nalgebra::Matrix3;
use std::ops::Range;

/// A volume in `f64`, mm, mesh frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Plain {
    /// A box.
    Box {
        /// Its axes, as columns of a rotation.
        axes: Matrix3<f64>,
        /// Its middle, mm.
        centre: Point,
        /// Its half-lengths along the axes, mm.
        half: Vector,
    },
    /// A ball.
    Ball {
        /// Its middle, mm.
        centre: Point,
        /// Its radius, mm.
        radius: f64,
    },
}

impl Plain {
    /// The middle, mm.
    #[must_use]
    pub const fn centre(&self) -> Point {
        match self {
            Self::Box { centre, .. } | Self::Ball { centre, .. } => *centre,
        }
    }

    /// Axes, middle and half-lengths of a box.
    #[must_use]
    pub const fn as_box(&self) -> Option<(Matrix3<f64>, Point, Vector)> {
        match self {
            Self::Box { axes, centre, half } => Some((*axes, *centre, *half)),
            Self::Ball { .. } => None,
        }
    }

    /// Whether `point` (mm, mesh frame) lies inside or within `slack_mm` of the volume.
    #[must_use]
    pub fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        match self {
            Self::Box { axes, centre, half } => {
                let outside = (axes.tr_mul(&(point - centre)).abs() - half).sup(&Vector::zeros());
                outside.norm_squared() <= slack_mm * slack_mm
            }
            Self::Ball { centre, radius } => (point - centre).norm() <= radius + slack_mm,
        }
    }
}

impl<V: WideVolume> WideTree<V> {
    /// The slot of the volume around the whole mesh.
    pub const ROOT: u32 = 0;

    /// The volume of a slot.
    ///
    /// # Panics
    /// When no walk from [`WideTree::ROOT`] by [`WideTree::children`] leads to the slot.
    #[must_use]
    pub fn plain(&self, slot: u32) -> Plain {
        let (node, place) = self.slot(slot);
        node.volume(place).plain(node.origin)
    }

    /// The slots below a slot; none below one of triangles.
    ///
    /// # Panics
    /// As [`WideTree::plain`].
    #[must_use]
    pub fn children(&self, slot: u32) -> Range<u32> {
        match self.contents(slot) {
            Contents::Node(node) => {
                let first = node * WIDTH as u32;
                first..first + u32::from(self.nodes[node as usize].count)
            }
            Contents::Triangles(_) => 0..0,
        }
    }

    /// The triangles of a slot, mm, mesh frame: none where it has children.
    ///
    /// # Panics
    /// As [`WideTree::plain`].
    pub fn leaf(&self, slot: u32) -> impl Iterator<Item = Triangle> {
        let places = match self.contents(slot) {
            Contents::Node(_) => 0..0,
            Contents::Triangles(triangles) => triangles.places(),
        };
        places.map(|place| self.triangle(place))
    }

    /// All triangles in tree order, mm, mesh frame.
    pub fn leaves(&self) -> impl Iterator<Item = Triangle> {
        (0..self.len() as u32).map(|place| self.triangle(place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_and_a_ball_contain_what_is_within_the_slack() {
        let centre = Point::new(1.0, 0.0, 0.0);
        let volumes = [
            Plain::Box { axes: Matrix3::identity(), centre, half: Vector::new(2.0, 2.0, 2.0) },
            Plain::Ball { centre, radius: 2.0 },
        ];
        for volume in volumes {
            assert!(
                volume.contains(&Point::new(3.0, 0.0, 0.0), 0.0) && !volume.contains(&Point::new(3.5, 0.0, 0.0), 0.25)
            );
            assert!(volume.contains(&Point::new(3.5, 0.0, 0.0), 0.5));
        }
        // The corner (3, 2, 2) is of the box alone.
        assert_eq!(volumes.map(|volume| volume.contains(&Point::new(3.0, 2.0, 2.0), 0.0)), [true, false]);
    }
}
