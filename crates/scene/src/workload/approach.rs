//! Approaches: `b` moves along a line of the scene and stops at given offsets from first contact.
//!
//! When more poses are requested than the scene's approaches have, the lines are varied at random: shifted sideways and tilted. When these
//! become many, each has more poses instead, at random depths and distances.

use super::ray::{Contact, POSES_PER_ROUND, Ray};
use super::{Budget, PosedPair, WorkloadError};
use crate::geometry::{Isometry, Vector};
use crate::scene::{Approach, Scene};
use nalgebra::{Translation3, Unit};
use obbtree::cases::Draw;
use rayon::prelude::*;

/// Largest sideways shift of a varied line, as a multiple of the radius of the smaller part.
const SHIFT: f64 = 0.25;

/// Largest tilt of a varied line, as a tangent: 15 degrees.
const TILT: f64 = 0.268;

/// Number of attempts to draw a varied line that touches, before it is given up.
const ATTEMPTS: usize = 16;

/// Up to about this number of lines, a line stops at the offsets of its approach only: finding first contact on a line costs as much as
/// judging hundreds of poses.
const MOST_LINES: usize = 2048;

/// All approaches of one pair that the scene defines, then varied ones up to about `budget.poses` poses. Each line is a cluster.
///
/// # Errors
/// [`WorkloadError::NoContact`] when an approach of the scene never touches.
pub fn poses(
    scene: &Scene,
    approaches: &[&Approach],
    contact: &Contact<'_>,
    budget: &Budget<'_>,
) -> Result<Vec<PosedPair>, WorkloadError> {
    let lines: Vec<Line> = approaches.iter().map(|approach| Line::of(scene, approach)).collect();
    let per_round: usize = approaches.iter().map(|approach| approach.offsets_mm.len()).sum();
    let most = (MOST_LINES / lines.len()).max(1);
    let more_of_round = lines.len() * POSES_PER_ROUND;
    let more = budget.poses.div_ceil(most).saturating_sub(per_round).div_ceil(more_of_round);
    let rounds = budget.poses.div_ceil(per_round + more * more_of_round).max(1);
    let count = rounds * lines.len();
    let rays: Vec<Option<Ray>> = (0..count)
        .into_par_iter()
        .map(|index| {
            let line = &lines[index % lines.len()];
            if index < lines.len() { line.cast(contact) } else { line.cast_varied(contact, &mut budget.draw(index)) }
        })
        .collect();
    if let Some(missed) = rays[..lines.len()].iter().position(Option::is_none) {
        let approach = approaches[missed];
        return Err(WorkloadError::NoContact { approach: approach.name.clone(), pair: scene.pair_name(approach.pair) });
    }
    let mut poses = Vec::with_capacity(rounds * (per_round + more * more_of_round));
    for (index, ray) in rays.iter().enumerate() {
        let Some(ray) = ray else { continue };
        let offsets = &approaches[index % approaches.len()].offsets_mm;
        poses.extend(offsets.iter().map(|offset| ray.posed(index, -offset)));
        poses.extend(ray.rounds(index, more, &mut budget.draw(count + index)));
    }
    Ok(poses)
}

/// An approach in the frame of `a`.
struct Line {
    through: Isometry,
    direction: Unit<Vector>,
}

impl Line {
    fn of(scene: &Scene, approach: &Approach) -> Self {
        let poses = scene.machine.forward(&approach.at);
        let a_from_world = scene.world_from_part(approach.pair.a, &poses).rotation.inverse();
        let direction = a_from_world * approach.direction;
        Self { through: scene.a_from_b(approach.pair, &poses), direction }
    }

    fn cast(&self, contact: &Contact<'_>) -> Option<Ray> {
        Ray::cast(contact, &self.through, self.direction)
    }

    fn cast_varied(&self, contact: &Contact<'_>, draw: &mut Draw) -> Option<Ray> {
        let reach = SHIFT * contact.a.radius.min(contact.b.radius);
        (0..ATTEMPTS).find_map(|_| {
            let shift = draw.in_ball() * reach;
            let direction = Unit::new_normalize(*self.direction + draw.in_ball() * TILT);
            let through = Translation3::from(shift) * self.through;
            Ray::cast(contact, &through, direction)
        })
    }
}
