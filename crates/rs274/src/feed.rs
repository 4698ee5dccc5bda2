//! Feed rates: what F and S come to in mm/min, for a move of a given length.
//!
//! G93: F moves a minute. G94: F as it stands. G95: F a revolution, at S revolutions a minute, or under G96 at the speed that keeps
//! the surface speed S at the diameter, which changes along the move: then the rate told is the one at which the move takes as long as it
//! really does. The diameter is twice the distance from X zero of the program (LinuxCNC, "G96, G97").

use super::canonical::Axis;
use super::dialect::Dialect;
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{FeedMode, Spindle, Values};
use super::offsets::Values9;
use super::setup::UserCode;
use std::f64::consts::TAU;

/// Travel shorter than this, mm, is none: the move is timed by its rotary travel.
pub(super) const NO_TRAVEL_MM: f64 = 1e-9;

/// Feed rates are along the first of these triples that moves, and of the rotary axes where neither does.
const LINEAR_TRIPLES: [[Axis; 3]; 2] = [[Axis::X, Axis::Y, Axis::Z], [Axis::U, Axis::V, Axis::W]];

/// How far a move goes as feed rates mean it; see [`super::path::length`].
#[derive(Clone, Copy, Debug)]
pub(super) enum Travel {
    /// Of linear axes, mm.
    Along(f64),
    /// Of the rotary ones, degrees, when no other moves.
    Turning(f64),
}

impl Interpreter<'_> {
    /// Feed rate of a move from the present position, mm/min, or degrees/min for one that only turns.
    pub(super) fn feed_for(&self, travel: Travel, target: &Values9, values: &Values) -> Result<Option<f64>, Fault> {
        if self.modes.feed <= 0.0 {
            return Err(values.motion_fault(Cause::Missing("a feed rate F above 0")));
        }
        match (self.modes.feed_mode, travel) {
            (FeedMode::PerMinute, Travel::Along(_)) => Ok(Some(self.modes.feed)),
            (FeedMode::PerMinute, Travel::Turning(_)) => Ok(Some(self.modes.turning_feed)),
            (FeedMode::InverseTime, Travel::Along(length) | Travel::Turning(length)) => {
                Ok(Some(self.modes.feed * length))
            }
            (FeedMode::PerRevolution, _) if self.modes.speed <= 0.0 && self.driven_rpm() == 0.0 => {
                Err(values.motion_fault(Cause::Missing("a spindle speed S above 0")))
            }
            (FeedMode::PerRevolution, _) => Ok(self.synchronous_rate(self.modes.feed, target)),
        }
    }

    /// Feed rate of a straight move from the present position, mm/min, or degrees/min for one that only turns. On Fanuc's controls F is the speed of all
    /// axes together, where a degree counts as a millimetre or, in G20, as an inch (B-63534EN, linear interpolation: `G91 G1 X20. B40. F300.` takes
    /// √(20² + 40²) / 300 min). Under tool-centre-point control F is the speed of the tip.
    pub(super) fn straight_feed(&self, target: &Values9, values: &Values) -> Result<Option<f64>, Fault> {
        let travel = travel(&self.position, target);
        let feed = self.feed_for(travel, target, values)?;
        let is_of_all = self.setup.dialect == Dialect::Fanuc && self.modes.feed_mode == FeedMode::PerMinute;
        let Travel::Along(length) = travel else { return Ok(feed) };
        if !is_of_all || self.tip_mm.is_some() {
            return Ok(feed);
        }
        let change = |axis: Axis| {
            let unit = if axis.is_rotary() { self.modes.unit_mm() } else { 1.0 };
            unit * (target[axis as usize] - self.position[axis as usize])
        };
        let of_all = Axis::ALL.into_iter().map(|axis| change(axis).powi(2)).sum::<f64>().sqrt();
        Ok(feed.map(|feed| feed * length / of_all))
    }

    /// Feed rate in mm/min of a move from the present position that travels `per_revolution` mm each turn of the spindle. `None`
    /// when it has no speed, and where it turns without bound: under G96 without D, on the axis of turning.
    pub(super) fn synchronous_rate(&self, per_revolution: f64, target: &Values9) -> Option<f64> {
        if self.driven_rpm() != 0.0 {
            return Some(per_revolution * self.driven_rpm().abs());
        }
        if self.modes.speed <= 0.0 {
            return None;
        }
        if !self.modes.constant_surface_speed {
            return Some(per_revolution * self.modes.speed);
        }
        let x = |position: &Values9| self.offsets.to_program(position)[Axis::X as usize];
        let minutes = self.minutes_per_revolution(x(&self.position), x(target));
        (minutes > 0.0).then(|| per_revolution / minutes)
    }

    /// Under G96, the mean time of a revolution between two distances from the axis of turning.
    fn minutes_per_revolution(&self, from: f64, to: f64) -> f64 {
        let least = self.modes.greatest_speed.map_or(0.0, f64::recip);
        mean_of_greater(TAU / self.modes.surface_mm_min, from, to, least)
    }

    /// Revolutions per minute of the driven tool, or else of the sub spindle, while the main spindle stands still; 0 when nothing of them turns.
    pub(super) fn driven_rpm(&self) -> f64 {
        if self.modes.spindle != Spindle::Still {
            return 0.0;
        }
        self.modes.driven_rpm.into_iter().find(|&rpm| rpm != 0.0).unwrap_or(0.0)
    }

    /// Revolutions per minute where the tool is: above zero for M3, below for M4; infinite on the axis of turning under G96
    /// without D.
    pub(super) fn spindle_rpm(&self) -> f64 {
        let x = self.offsets.to_program(&self.position)[Axis::X as usize];
        let speed = match self.modes.spindle {
            Spindle::Still => return self.driven_rpm(),
            _ if self.modes.constant_surface_speed && self.modes.speed > 0.0 => {
                self.minutes_per_revolution(x, x).recip()
            }
            _ => self.modes.speed,
        };
        if self.modes.spindle == Spindle::Clockwise { speed } else { -speed }
    }

    /// Whether a spindle turns that may hold the workpiece, and one that may drive the tool. Only Haas's lathes have codes for each, and what
    /// `user_codes` start is not known.
    pub(super) fn turning(&self) -> [bool; 2] {
        let any = self.spindle_rpm() != 0.0;
        let is_haas_lathe = self.setup.dialect == Dialect::Haas && self.setup.is_fanuc_lathe();
        if !is_haas_lathe || self.setup.user_codes.values().any(|code| *code == UserCode::SpindleOn) {
            return [any; 2];
        }
        let [tool, sub] = self.modes.driven_rpm.map(|rpm| rpm != 0.0);
        [sub || (any && self.modes.spindle != Spindle::Still), tool]
    }
}

/// The mean of max(slope |x|, least) over x from `from` to `to`, slope above zero.
fn mean_of_greater(slope: f64, from: f64, to: f64, least: f64) -> f64 {
    if (to - from).abs() < NO_TRAVEL_MM {
        return (slope * f64::midpoint(from, to).abs()).max(least);
    }
    // From 0 to x: a rectangle up to the knee, then a trapezium.
    let knee = least / slope;
    let integral = |x: f64| {
        let beyond = (x.abs() - knee).max(0.0);
        (least * x.abs() + slope * beyond * beyond / 2.0).copysign(x)
    };
    (integral(to) - integral(from)) / (to - from)
}

/// How far a straight move goes.
pub(super) fn travel(from: &Values9, to: &Values9) -> Travel {
    travel_by(|axis| to[axis as usize] - from[axis as usize])
}

/// How far a straight move goes that changes each axis by `change`. If only rotary axes change, it is an angle, in the unit of `change`.
pub(super) fn travel_by(change: impl Fn(Axis) -> f64) -> Travel {
    let norm = |axes: [Axis; 3]| axes.map(|axis| change(axis).powi(2)).iter().sum::<f64>().sqrt();
    let along = LINEAR_TRIPLES.into_iter().map(norm).find(|&length| length > NO_TRAVEL_MM);
    along.map_or_else(|| Travel::Turning(norm([Axis::A, Axis::B, Axis::C])), Travel::Along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_follows_the_knee() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
        near(mean_of_greater(2.0, 3.0, 3.0, 1.0), 6.0);
        near(mean_of_greater(2.0, 1.0, 3.0, 0.0), 4.0); // 2 to 6, straight
        // 1 up to x = 0.5, from there 1 to 4: (0.5 x 1 + 1.5 x 2.5) / 2.
        near(mean_of_greater(2.0, 0.0, 2.0, 1.0), 2.125);
        // The same on the other side of the axis; and across it, from -0.5 to 0.5, all 1.
        near(mean_of_greater(2.0, -2.0, 0.0, 1.0), 2.125);
        near(mean_of_greater(2.0, -0.5, 0.5, 1.0), 1.0);
    }
}
