//! Random poses: `b`, in a random orientation, moves along a random line and stops in every depth band and at every distance.

use super::ray::{Contact, POSES_PER_ROUND, Ray};
use super::{Budget, PosedPair};
use crate::geometry::Isometry;
use nalgebra::Translation3;
use obbtree::cases::Draw;
use rayon::prelude::*;

/// Up to this number of rays, each ray has one round of poses. For more poses, each ray has more rounds, because finding first contact on a
/// ray costs as much as judging hundreds of poses.
const RAYS_OF_ONE_ROUND: usize = 700;

/// Number of attempts to draw a ray, when rounding makes it pass without contact.
const ATTEMPTS: usize = 16;

/// About `budget.poses` poses, in whole rays; each ray is a cluster.
pub fn poses(contact: &Contact<'_>, budget: &Budget<'_>) -> Vec<PosedPair> {
    let rounds = budget.poses / POSES_PER_ROUND;
    let rounds_per_ray = (rounds / RAYS_OF_ONE_ROUND).max(1);
    let rays = budget.poses.div_ceil(POSES_PER_ROUND * rounds_per_ray);
    let rays: Vec<Vec<PosedPair>> = (0..rays)
        .into_par_iter()
        .map(|index| {
            let mut draw = budget.draw(index);
            let ray = (0..ATTEMPTS).find_map(|_| ray(contact, &mut draw));
            ray.map_or_else(Vec::new, |ray| ray.rounds(index, rounds_per_ray, &mut draw))
        })
        .collect();
    rays.into_iter().flatten().collect()
}

/// A line on which a random point of `b`'s surface meets a random point of `a`'s. Drawing a direction first would miss slender parts, and
/// aiming at centres would never reach their ends.
fn ray(contact: &Contact<'_>, draw: &mut Draw) -> Option<Ray> {
    let rotation = draw.rotation();
    let direction = draw.direction();
    let (on_a, on_b) = (contact.a.point(draw), contact.b.point(draw));
    let through = Isometry::from_parts(Translation3::from(on_a - rotation * on_b), rotation);
    Ray::cast(contact, &through, direction)
}
