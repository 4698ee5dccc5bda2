//! Random poses: `b` in a random orientation comes along a random line, and stops in every depth band and at every
//! distance.

use super::ray::{Contact, Ray};
use super::{Budget, PosedPair};
use crate::geometry::Isometry;
use nalgebra::Translation3;
use obbtree::cases::Draw;
use rayon::prelude::*;

/// Where a ray's poses lie: travel past first contact, mm, log-uniform in each interval. One in every depth band of the
/// specification; the first starts at twice the grazing limit, so that no pose of it is grazing by rounding. The deepest is
/// open-ended and gets as deep as small tools are thick.
const DEPTHS_MM: [(f64, f64); 6] = [(2e-6, 1e-3), (1e-3, 0.01), (0.01, 0.1), (0.1, 1.0), (1.0, 5.0), (5.0, 15.0)];

/// As [`DEPTHS_MM`], before first contact: two each to near miss, medium and far, so that a ray is free as often as it
/// touches.
const DISTANCES_MM: [(f64, f64); 6] =
    [(1e-4, 1.0), (1e-4, 1.0), (1.0, 10.0), (1.0, 10.0), (10.0, 100.0), (10.0, 100.0)];

/// Poses of one ray in one round: one in each interval.
const POSES_PER_ROUND: usize = DEPTHS_MM.len() + DISTANCES_MM.len();

/// Up to this many rays each has one round of poses. For more poses each ray has more rounds: finding first contact on a ray
/// costs as much as judging hundreds of poses.
const RAYS_OF_ONE_ROUND: usize = 700;

/// How often a ray is drawn anew when rounding makes it pass by.
const ATTEMPTS: usize = 16;

/// About `budget.poses` poses, whole rays; a ray is a cluster.
pub fn poses(contact: &Contact<'_>, budget: &Budget<'_>) -> Vec<PosedPair> {
    let rounds = budget.poses / POSES_PER_ROUND;
    let rounds_per_ray = (rounds / RAYS_OF_ONE_ROUND).max(1);
    let rays = budget.poses.div_ceil(POSES_PER_ROUND * rounds_per_ray);
    let rays: Vec<Vec<PosedPair>> = (0..rays)
        .into_par_iter()
        .map(|index| {
            let mut draw = budget.draw(index);
            (0..ATTEMPTS).find_map(|_| ray(contact, &mut draw)).map_or_else(Vec::new, |ray| {
                let depths = DEPTHS_MM.iter().map(|&(low, high)| (1.0, low, high));
                let distances = DISTANCES_MM.iter().map(|&(low, high)| (-1.0, low, high));
                let round: Vec<_> = depths.chain(distances).collect();
                (0..rounds_per_ray)
                    .flat_map(|_| round.clone())
                    .map(|(sign, low, high)| {
                        let depth_mm = sign * draw.log_uniform(low, high);
                        let cluster = index as u32;
                        PosedPair { a_from_b: ray.at_depth(depth_mm), cluster, line: None, depth_mm: Some(depth_mm) }
                    })
                    .collect()
            })
        })
        .collect();
    rays.into_iter().flatten().collect()
}

/// A line on which a random point of `b`'s surface meets a random one of `a`'s: a direction drawn first would pass by slender
/// parts, and aiming at centres would leave their ends alone.
fn ray(contact: &Contact<'_>, draw: &mut Draw) -> Option<Ray> {
    let rotation = draw.rotation();
    let direction = draw.direction();
    let (on_a, on_b) = (contact.a.point(draw), contact.b.point(draw));
    let through = Isometry::from_parts(Translation3::from(on_a - rotation * on_b), rotation);
    Ray::cast(contact, &through, direction)
}
