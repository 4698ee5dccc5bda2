//! The tool-vector inverse: from the direction of the tool relative to the workpiece to the positions of two rotary axes.
//!
//! Two rotary joints lie between workpiece and tool: both on the table's side, both on the head's side, or one on each. Prismatic joints do
//! not change directions. In the world frame with all axes at zero, the tool vector is `exp(w1 t1) exp(w2 t2) p`. Here `w1` is the axis
//! nearer to the workpiece, `w2` the axis nearer to the tool, and `p` the tool vector at zero. Angles of table joints are negated, because
//! these joints rotate the workpiece instead of the tool. For two axes that are not parallel, this has two solutions in closed form: B.
//! Paden, "Kinematics and control of robot manipulators", thesis, Berkeley 1986, second subproblem; R. Murray, Z. Li, S. Sastry, "A
//! mathematical introduction to robotic manipulation", 1994, section 3.3.
//!
//! Of two solutions within the limits, the one is preferred that Fanuc's controls take for G53.1: the axes are compared in turn, the one
//! nearer to the machine's base first, or the table's where the other is the head's. The solution with the least travel of the first axis
//! is taken; on a tie, with the least travel of the second, then with the first nearest to a whole turn, then the second. Fanuc, "Series
//! 16i/18i/180is-MB5 operator's manual", "Angle of rotation axis".

use super::joint::{LIMIT_SLACK, Motion, OutOfLimits};
use super::tip::TipControl;
use super::tree::Machine;
use crate::geometry::Vector;
use nalgebra::{Rotation3, Unit};
use rs274::{Axis, Position};
use std::cmp::Ordering;
use std::f64::consts::TAU;
use thiserror::Error;

/// Sine of the angle below which two axes count as parallel. The relative accuracy of the solutions falls in proportion to this sine.
const PARALLEL: f64 = 1e-4;
/// Sine of the angle below which two directions count as equal, and difference below which two travels do, radians: a thousandth of the
/// resolution of any rotary axis, and far above rounding (1e-16 over [`PARALLEL`]).
const SAME: f64 = 1e-9;
/// The two solutions count as one when the square of half their distance is below this fraction of the vector's distance from the first
/// axis. This is the rounding error of a difference that should be zero.
const TOGETHER: f64 = 1e-15;

/// Axis positions at which the tool has the requested direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// The previous position with the two rotary axes changed.
    pub position: Position,
    /// The rotary axis that has no effect because the tool lies along it; it keeps its previous position.
    pub free: Option<Axis>,
    /// Travel of the two axes from the previous position, radians; the axis nearer to the workpiece first.
    pub travel: [f64; 2],
    /// Whether the position is within the machine's limits.
    pub limits: Result<(), OutOfLimits>,
}

/// Both solutions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solutions {
    /// The preferred solution: within the limits, and of two such solutions the one that Fanuc's controls take.
    pub chosen: Solution,
    /// The other solution, possibly outside the limits; `None` when the two coincide.
    pub other: Option<Solution>,
}

/// Why there is no solution.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum OrientationError {
    /// There are not exactly two rotary joints.
    #[error(
        "there are {found} turning joints between workpiece and tool; a tool vector is found for two, of different axes"
    )]
    NotTwoJoints {
        /// How many there are.
        found: usize,
    },
    /// The two axes are parallel.
    #[error("axes {0} and {1} are parallel, so they tilt the tool in one plane only", axes[0], axes[1])]
    Parallel {
        /// Letters of the axes.
        axes: [char; 2],
    },
    /// The axes cannot reach the direction.
    #[error("axes {0} and {1} cannot tilt the tool this way, whatever their limits", axes[0], axes[1])]
    Unreachable {
        /// Letters of the axes.
        axes: [char; 2],
    },
    /// All solutions are outside the limits.
    #[error("both ways to tilt the tool leave the limits; of the nearer one, {0}")]
    OutOfLimits(#[from] OutOfLimits),
}

/// A rotary joint in the world frame with all axes at zero.
#[derive(Clone, Copy, Debug)]
struct Turn {
    axis: Axis,
    /// Radians of the joint per unit of the axis, negative when the joint carries the workpiece.
    gain: f64,
    direction: Vector,
    /// Whether the joint carries the workpiece.
    carries_work: bool,
}

impl TipControl {
    /// The direction from the tool's tip up the tool, in a frame fixed to the workpiece that coincides with the world frame when all axes
    /// are at zero.
    pub fn tool_vector(&self, machine: &Machine, position: &Position) -> Unit<Vector> {
        let (at_zero, poses) = (machine.forward(&Position::default()), machine.forward(position));
        let carried = at_zero.world_from(self.work_link).rotation * poses.world_from(self.work_link).rotation.inverse();
        carried * (poses.world_from(self.tool_link).rotation * -self.direction)
    }

    /// The positions of the two rotary axes at which the tool has the direction `vector` ([`TipControl::tool_vector`]); all other axes stay
    /// at `previous`. Among equivalent angles, those nearest to `previous` within the limits are used, so angles may exceed one turn.
    ///
    /// # Errors
    /// When the machine does not have two such axes, they cannot reach the direction, or the limits forbid it.
    pub fn orient(
        &self,
        machine: &Machine,
        vector: &Unit<Vector>,
        previous: &Position,
    ) -> Result<Solutions, OrientationError> {
        let turns = self.turns(machine)?;
        let axes = turns.map(|turn| turn.axis.letter());
        let at_zero = self.tool_vector(machine, &Position::default());
        let angles = angles(&turns.map(|turn| turn.direction), &at_zero, vector).map_err(|cause| match cause {
            Cause::Parallel => OrientationError::Parallel { axes },
            Cause::Unreachable => OrientationError::Unreachable { axes },
        })?;
        let mut solutions = angles.into_iter().map(|angles| solution(machine, &turns, angles, previous));
        let Some(first) = solutions.next() else { return Err(OrientationError::Unreachable { axes }) };
        let (chosen, other) = match solutions.next() {
            Some(second) if is_better(&second, &first, &turns) => (second, Some(first)),
            second => (first, second),
        };
        chosen.limits?;
        Ok(Solutions { chosen, other })
    }

    /// The rotary joints between workpiece and tool, in this order.
    fn turns(&self, machine: &Machine) -> Result<[Turn; 2], OrientationError> {
        let at_zero = machine.forward(&Position::default());
        let turn = |link: usize, sign: f64| {
            let joint = machine.links()[link].joint.as_ref()?;
            let Motion::Rotary { direction, .. } = joint.motion else { return None };
            let direction = at_zero.world_from(Some(link)).rotation * direction.into_inner();
            Some(Turn { axis: joint.axis, gain: sign * joint.gain(), direction, carries_work: sign < 0.0 })
        };
        let work = machine.up_to_shared(self.work_link, self.tool_link);
        let mut turns: Vec<Turn> = work.filter_map(|link| turn(link, -1.0)).collect();
        let tool = machine.up_to_shared(self.tool_link, self.work_link);
        let mut head: Vec<Turn> = tool.filter_map(|link| turn(link, 1.0)).collect();
        head.reverse();
        turns.append(&mut head);
        match turns[..] {
            [one, other] if one.axis != other.axis => Ok([one, other]),
            _ => Err(OrientationError::NotTwoJoints { found: turns.len() }),
        }
    }
}

/// Whether `one` is preferred to `other`: within the limits, then by the first of their [`costs`] that differs.
fn is_better(one: &Solution, other: &Solution, turns: &[Turn; 2]) -> bool {
    let mut pairs = costs(one, turns).into_iter().zip(costs(other, turns));
    let decisive = pairs.find(|(one, other)| (one - other).abs() > SAME);
    let by_cost = decisive.map_or(Ordering::Equal, |(one, other)| one.total_cmp(&other));
    other.limits.is_ok().cmp(&one.limits.is_ok()).then(by_cost).is_lt()
}

/// Travels of the two axes and their distances from a whole turn, radians, in the order in which they decide.
fn costs(solution: &Solution, turns: &[Turn; 2]) -> [f64; 4] {
    // Of two axes of the table, the second is nearer to the base.
    let first = usize::from(turns[1].carries_work);
    let [one, other] = [first, 1 - first].map(|index| {
        let angle = solution.position[turns[index].axis] * turns[index].gain;
        [solution.travel[index].abs(), (angle - TAU * (angle / TAU).round()).abs()]
    });
    [one[0], other[0], one[1], other[1]]
}

/// The axis positions for two joint angles; an angle of `None` has no effect.
fn solution(machine: &Machine, turns: &[Turn; 2], angles: [Option<f64>; 2], previous: &Position) -> Solution {
    let mut position = *previous;
    let (mut free, mut travel) = (None, [0.0; 2]);
    for (index, (turn, angle)) in turns.iter().zip(angles).enumerate() {
        let [low, high] = machine.axis_limits(turn.axis).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        position[turn.axis] = match angle {
            Some(angle) => nearest(angle / turn.gain, TAU / turn.gain.abs(), previous[turn.axis], low, high),
            None => {
                free = Some(turn.axis);
                previous[turn.axis].max(low).min(high)
            }
        };
        travel[index] = (position[turn.axis] - previous[turn.axis]) * turn.gain.abs();
    }
    let limits = turns.iter().try_for_each(|turn| machine.check_axis(turn.axis, &position));
    Solution { position, free, travel, limits }
}

/// Among the positions `value + k period`, the one nearest to `previous` within `low..=high`; if there is none, the nearest of all.
fn nearest(value: f64, period: f64, previous: f64, low: f64, high: f64) -> f64 {
    let turns = ((previous - value) / period).round();
    let slack = LIMIT_SLACK / period;
    let (least, most) = (((low - value) / period - slack).ceil(), ((high - value) / period + slack).floor());
    // Clamped one side after the other, since an empty range has no meaning for `clamp`.
    value + if least <= most { turns.max(least).min(most) } else { turns } * period
}

enum Cause {
    Parallel,
    Unreachable,
}

/// The pairs of angles for which `exp(w1 t1) exp(w2 t2) p = q`, one or two; an angle is `None` when it has no effect.
fn angles([w1, w2]: &[Vector; 2], p: &Unit<Vector>, q: &Unit<Vector>) -> Result<Vec<[Option<f64>; 2]>, Cause> {
    let (p, q) = (p.as_ref(), q.as_ref());
    let normal = w1.cross(w2);
    let sine = normal.norm();
    if sine < PARALLEL {
        return Err(Cause::Parallel);
    }
    // Halfway, z = exp(w2 t2) p = exp(-w1 t1) q has q's share along w1, q's distance from w1, and p's share along w2.
    let (along, distance) = (w1.dot(q), w1.cross(q).norm());
    let cosine = w1.dot(w2);
    let in_plane = (w2.dot(p) - cosine * along) / sine;
    let across_squared = (distance - in_plane) * (distance + in_plane);
    let across = normal * (across_squared.max(0.0).sqrt() / sine);
    let base = w1 * along + (w2 - w1 * cosine) * (in_plane / sine);
    let (first_free, second_free) = (distance < SAME, w2.cross(p).norm() < SAME);
    let halfway = match (first_free, second_free) {
        (true, _) => vec![*q],
        (false, true) => vec![*p],
        _ if across_squared <= TOGETHER * distance => vec![base + across],
        _ => vec![base + across, base - across],
    };
    let mut found = Vec::with_capacity(2);
    for z in halfway {
        let (first, second) = (angle_about(w1, &z, q), angle_about(w2, p, &z));
        let turned = |axis: &Vector, angle: f64| Rotation3::from_axis_angle(&Unit::new_unchecked(*axis), angle);
        if (turned(w1, first) * (turned(w2, second) * p) - q).norm() > SAME {
            return Err(Cause::Unreachable);
        }
        found.push([(!first_free).then_some(first), (!second_free).then_some(second)]);
    }
    Ok(found)
}

/// The angle of the rotation about `axis` that takes `from` to `to`, radians.
fn angle_about(axis: &Vector, from: &Vector, to: &Vector) -> f64 {
    let (from, to) = (from - axis * axis.dot(from), to - axis * axis.dot(to));
    axis.dot(&from.cross(&to)).atan2(from.dot(&to))
}

#[cfg(test)]
mod tests;
