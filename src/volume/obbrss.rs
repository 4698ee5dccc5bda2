//! A box for overlap tests and a sphere-swept rectangle for distances in one node.
//!
//! J. Pan, S. Chitta, D. Manocha, "FCL: A General Purpose Library for Collision and Proximity Queries", ICRA 2012, whose nodes hold both.
//! Deviations: the axes of both come from the area-weighted covariance; the lower bound of a distance is the larger of both bounds.

use super::obb_area::ObbArea;
use super::rss::Rss;
use super::shape::obb::{Obb, ObbPose};
use super::{BoundingVolume, Info, Segment, Shape, Solid};
use crate::geometry::{Isometry, Point, Triangle, Vector};
use nalgebra::{Matrix3, Unit};

/// A box and a sphere-swept rectangle around the same contents. Size, shape and containment are those of the box.
#[derive(Clone, Debug)]
pub struct ObbRss {
    obb: Obb,
    rss: Rss,
}

impl BoundingVolume for ObbRss {
    const INFO: Info = Info {
        id: "obbrss",
        label: "OBB and RSS",
        reference: "J. Pan, S. Chitta, D. Manocha, FCL: A General Purpose Library for Collision and Proximity Queries, ICRA 2012",
        safe: true,
    };

    type Shape = Self;

    fn fit(triangles: &[Triangle]) -> Self {
        Self { obb: ObbArea::fit(triangles), rss: Rss::fit(triangles) }
    }
}

impl Shape for ObbRss {
    type Pose = ObbPose;

    fn pose(a_from_b: &Isometry) -> ObbPose {
        ObbPose::new(a_from_b)
    }

    #[inline]
    fn overlaps(&self, other: &Self, pose: &ObbPose) -> bool {
        self.obb.overlaps(&other.obb, pose)
    }

    fn gap_mm(&self, other: &Self, pose: &ObbPose) -> f64 {
        self.rss.gap_mm(&other.rss, pose).max(self.obb.gap_mm(&other.obb, pose))
    }

    fn size(&self) -> f64 {
        self.obb.size()
    }

    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        self.obb.split_axes(triangles)
    }
}

impl Solid for ObbRss {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        self.obb.contains(point, slack_mm)
    }

    fn centre(&self) -> Point {
        self.obb.centre()
    }

    fn volume(&self) -> f64 {
        self.obb.volume()
    }

    fn surface_area(&self) -> f64 {
        self.obb.surface_area()
    }

    fn outline(&self) -> Vec<Segment> {
        self.obb.outline()
    }

    fn axes(&self) -> Matrix3<f64> {
        self.obb.axes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use obbtree::cases::meshes;

    #[test]
    fn the_gap_of_two_balls_is_better_than_that_of_their_boxes() {
        let ball = meshes::sphere(10.0, 24, 12).triangles();
        let fitted = ObbRss::fit(&ball);
        // Along the diagonal of the boxes the balls are 10 mm apart.
        let pose =
            ObbRss::pose(&Isometry::translation(30.0 / 3.0_f64.sqrt(), 30.0 / 3.0_f64.sqrt(), 30.0 / 3.0_f64.sqrt()));
        let (both, alone) = (fitted.gap_mm(&fitted, &pose), fitted.obb.gap_mm(&fitted.obb, &pose));
        assert!(both > 8.0 && both <= 10.0 && alone < 1.0, "{both} {alone}");
        assert!(fitted.contains(&Point::origin(), 0.0) && !fitted.contains(&Point::new(0.0, 0.0, 30.0), 1.0));
    }
}
