//! A rigid motion between two poses, and the time of first contact along it by conservative advancement.
//!
//! B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996, section 2.3: within a time dt no point of the moved mesh goes farther than the greatest
//! speed times dt, so as long as that is below the distance of the meshes they do not touch.

use super::Model;
use crate::geometry::{Isometry, Mesh, Vector};
use crate::tree::distance::Proximity;
use nalgebra::{Translation3, UnitQuaternion};

/// Distance at which meshes count as touching, mm.
pub const CONTACT_MM: f64 = 1e-4;
/// Most steps of one motion. A motion that needs more counts as in contact at the last.
const MOST_STEPS: u32 = 1_000_000;

/// The origin of part `b` goes straight and evenly, and the part turns about it at a constant rate, the shorter way. Times are from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Pose at time 0, part `b` in the frame of part `a`.
    pub start: Isometry,
    /// Way of the origin, mm.
    pub way: Vector,
    /// Axis times angle of the turn, in the frame of `a`, radians.
    pub turn: Vector,
}

impl Motion {
    /// From one pose to another.
    pub fn between(start: &Isometry, end: &Isometry) -> Self {
        let way = end.translation.vector - start.translation.vector;
        let turn = (end.rotation * start.rotation.inverse()).scaled_axis();
        Self { start: *start, way, turn }
    }

    /// The pose at a time.
    pub fn at(&self, time: f64) -> Isometry {
        let turn = UnitQuaternion::from_scaled_axis(self.turn * time);
        let place = Translation3::from(self.start.translation.vector + self.way * time);
        Isometry::from_parts(place, turn * self.start.rotation)
    }

    /// How far at most a point goes that is up to `reach_mm` from the origin of `b`, mm per unit of time.
    pub fn speed_mm(&self, reach_mm: f64) -> f64 {
        self.way.norm() + self.turn.norm() * reach_mm
    }

    /// The first time at which the meshes are within [`CONTACT_MM`] of each other. `distance_mm` is asked for the distance at a pose where it is below a limit; it may answer
    /// infinity where it is not.
    pub fn first_contact(&self, reach_mm: f64, mut distance_mm: impl FnMut(&Isometry, f64) -> f64) -> Option<f64> {
        let speed_mm = self.speed_mm(reach_mm);
        let mut time = 0.0;
        for _ in 0..MOST_STEPS {
            // What is farther away than this does not come near any more.
            let left_mm = speed_mm * (1.0 - time) + CONTACT_MM;
            let apart_mm = distance_mm(&self.at(time), left_mm);
            if apart_mm <= CONTACT_MM {
                return Some(time);
            }
            // Half of the tolerance is left, so that steps do not become ever shorter.
            let step = (apart_mm - 0.5 * CONTACT_MM) / speed_mm;
            if apart_mm >= left_mm || time + step >= 1.0 {
                return None;
            }
            time += step;
        }
        Some(time)
    }
}

/// How far a mesh reaches from its origin, mm.
pub fn reach_mm(mesh: &Mesh) -> f64 {
    mesh.vertices().iter().map(|p| p.coords.norm()).fold(0.0, f64::max)
}

/// First contact of two models of one method by the distances that it finds.
pub(super) fn by_distances<M: Model + ?Sized>(a: &M, b: &dyn Model, motion: &Motion, reach_mm: f64) -> Option<f64> {
    // The pair of triangles that is nearest stays near.
    let mut proximity = Proximity::default();
    motion.first_contact(reach_mm, |pose, below_mm| a.distance_mm(b, pose, below_mm, &mut proximity))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry;
    use obbtree::cases::meshes;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_motion_goes_from_one_pose_to_the_other_evenly() {
        let start = Isometry::new(Vector::new(1.0, 2.0, 3.0), Vector::new(0.3, 0.0, 0.0));
        let end = Isometry::new(Vector::new(3.0, 2.0, 1.0), Vector::new(0.0, 0.0, FRAC_PI_2));
        let motion = Motion::between(&start, &end);
        for (time, pose) in [(0.0, start), (1.0, end), (0.25, start.lerp_slerp(&end, 0.25))] {
            assert!((motion.at(time).to_homogeneous() - pose.to_homogeneous()).amax() < 1e-14, "{time}");
        }
        // 2 sqrt 2 mm along, and an angle of 2 acos(cos 0.15 cos 45 deg) times 10 mm.
        let angle = 2.0 * (0.15_f64.cos() * (0.5 * FRAC_PI_2).cos()).acos();
        assert!((motion.speed_mm(10.0) - (8.0_f64.sqrt() + 10.0 * angle)).abs() < 1e-12);
    }

    /// A cuboid of 2 mm that goes 10 mm along X towards one whose face is 4 mm from its own: contact at 0.4. And a rod of 20 mm that turns about its
    /// middle by a right angle: its tip corner meets the face Y = 6 of a cuboid.
    #[test]
    fn every_engine_finds_the_contacts_that_are_known() {
        let registry = registry::standard();
        let (cube, rod) = (meshes::cuboid(2.0, 2.0, 2.0), meshes::cuboid(20.0, 2.0, 2.0));
        let ahead = Motion::between(&Isometry::identity(), &Isometry::translation(10.0, 0.0, 0.0));
        let ahead = Motion { start: Isometry::translation(-6.0, 0.0, 0.0), ..ahead };
        let turn = |from: f64| Motion {
            start: Isometry::new(Vector::new(0.0, -7.0, 0.0), Vector::z() * from),
            way: Vector::zeros(),
            turn: Vector::z() * FRAC_PI_2,
        };
        // The corner (10, 1) is at the angle atan 0.1 from the X axis, sqrt 101 from the middle, and meets Y = -1, 6 above the middle, at asin(6 / sqrt 101).
        let expected = ((6.0 / 101.0_f64.sqrt()).asin() - 0.1_f64.atan()) / FRAC_PI_2;
        let wide = meshes::cuboid(40.0, 2.0, 40.0);
        for id in ["obb-wide", "obb-area", "parry-trimesh"] {
            let variant = registry.find(id).unwrap();
            let first = |a: &Mesh, b: &Mesh, motion: &Motion| {
                let (a, model) = (variant.prepare(a, None), variant.prepare(b, None));
                a.first_contact(model.as_ref(), motion, reach_mm(b))
            };
            let found = first(&cube, &cube, &ahead).unwrap();
            assert!((found - 0.4).abs() < 2e-4, "{id}: {found}");
            let found = first(&wide, &rod, &turn(0.0)).unwrap();
            assert!((found - expected).abs() < 2e-4, "{id}: {found} {expected}");
            assert_eq!(first(&cube, &cube, &Motion { way: Vector::y() * 10.0, ..ahead }), None, "{id}");
        }
    }
}
