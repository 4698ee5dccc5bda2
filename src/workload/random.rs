//! Random poses: `b`, in a random orientation, moves along a random line and stops in every depth band and at every distance.

use super::ray::{Contact, Ray};
use super::{Budget, PosedPair};
use crate::geometry::Isometry;
use nalgebra::Translation3;
use obbtree::cases::Draw;
use rayon::prelude::*;

/// Depths of a ray's poses: travel past first contact, mm, log-uniform in each interval, with one interval per depth band of the
/// specification. The first interval starts at twice the grazing limit, so that rounding makes none of its poses grazing. The deepest band
/// is open-ended; its interval ends at about the thickness of small tools.
const DEPTHS_MM: [(f64, f64); 6] = [(2e-6, 1e-3), (1e-3, 0.01), (0.01, 0.1), (0.1, 1.0), (1.0, 5.0), (5.0, 15.0)];

/// Like [`DEPTHS_MM`], before first contact: two intervals each for near miss, medium and far, so that a ray has as many free as colliding
/// poses.
const DISTANCES_MM: [(f64, f64); 6] =
    [(1e-4, 1.0), (1e-4, 1.0), (1.0, 10.0), (1.0, 10.0), (10.0, 100.0), (10.0, 100.0)];

/// Poses of one ray in one round: one in each interval.
const POSES_PER_ROUND: usize = DEPTHS_MM.len() + DISTANCES_MM.len();

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

/// A line on which a random point of `b`'s surface meets a random point of `a`'s. Drawing a direction first would miss slender parts, and
/// aiming at centres would never reach their ends.
fn ray(contact: &Contact<'_>, draw: &mut Draw) -> Option<Ray> {
    let rotation = draw.rotation();
    let direction = draw.direction();
    let (on_a, on_b) = (contact.a.point(draw), contact.b.point(draw));
    let through = Isometry::from_parts(Translation3::from(on_a - rotation * on_b), rotation);
    Ray::cast(contact, &through, direction)
}
