//! One joint: how a link moves relative to its parent when an axis moves.

use crate::geometry::{self, Isometry, Point, Vector};
use nalgebra::{Translation3, Unit, UnitQuaternion};
use rs274::{Axis, Position};
use thiserror::Error;

/// Permitted distance of an axis beyond its limits, mm or radians: the rounding error that a controller's arithmetic may add to a
/// programmed limit. A nanometre is far below any controller's resolution, and far above rounding (4096 mm · 2⁻⁵² ≈ 1e-12 mm).
pub const LIMIT_SLACK: f64 = 1e-6;

/// Rotation of a joint driven by one of X, Y, Z, U, V, W, radians per mm of its axis: one degree. Robots have more rotary joints than there
/// are letters for rotary axes.
const DEGREE_PER_MM: f64 = std::f64::consts::PI / 180.0;

/// Why the numbers of a joint are invalid.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum JointError {
    /// A direction without length.
    #[error("the direction of axis {axis} is zero")]
    ZeroDirection {
        /// Letter of the axis.
        axis: char,
    },
    /// A component is NaN or infinite.
    #[error("joint of axis {axis}: {what} is not finite")]
    NotFinite {
        /// Letter of the axis.
        axis: char,
        /// Which component.
        what: &'static str,
    },
    /// The lower limit is above the upper one.
    #[error("the limits of axis {axis} are the wrong way round: {min} is above {max} (mm or degrees)")]
    EmptyLimits {
        /// Letter of the axis.
        axis: char,
        /// Lower limit, mm or degrees.
        min: f64,
        /// Upper limit, mm or degrees.
        max: f64,
    },
}

/// The range of an axis at a joint, mm or radians. Infinite without a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

impl Limits {
    /// No limits.
    pub const NONE: Self = Self { min: f64::NEG_INFINITY, max: f64::INFINITY };
}

/// How a joint moves. Directions and points are in the frame of the link at axis position zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Slides along a direction.
    Prismatic {
        /// Direction of motion for a positive axis value.
        direction: Unit<Vector>,
    },
    /// Turns about a line.
    Rotary {
        /// Direction of the line. Positive values rotate counter-clockwise when seen against this direction.
        direction: Unit<Vector>,
        /// A point on the line, mm.
        point: Point,
    },
}

/// An axis and the motion that it drives. One axis may drive several joints (both sides of a gantry): each moves by the axis value, and has
/// its own limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// The axis.
    pub axis: Axis,
    /// The motion of the link.
    pub motion: Motion,
    /// The permitted range of the axis at this joint.
    pub limits: Limits,
}

/// An axis value outside a joint's limits.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("axis {axis} at {value} {unit} is outside its limits {min} to {max} {unit}")]
pub struct OutOfLimits {
    /// Letter of the axis.
    pub axis: char,
    /// Value of the axis, in `unit`.
    pub value: f64,
    /// Lower limit, in `unit`.
    pub min: f64,
    /// Upper limit, in `unit`.
    pub max: f64,
    /// `mm` or `degrees`.
    pub unit: &'static str,
}

impl Joint {
    /// A joint that slides along `direction` (any length but zero, link frame).
    ///
    /// # Errors
    /// [`JointError`] when a number is not finite, the direction is zero or the limits (mm) are the wrong way round.
    pub fn prismatic(axis: Axis, direction: Vector, limits: Limits) -> Result<Self, JointError> {
        let direction = unit(axis, direction)?;
        check_limits(axis, limits, 1.0)?;
        Ok(Self { axis, motion: Motion::Prismatic { direction }, limits })
    }

    /// A joint that turns about the line through `point` (mm) along `direction` (any length but zero), link frame.
    ///
    /// # Errors
    /// [`JointError`] when a number is not finite, the direction is zero or the limits (radians) are the wrong way round.
    pub fn rotary(axis: Axis, direction: Vector, point: Point, limits: Limits) -> Result<Self, JointError> {
        let direction = unit(axis, direction)?;
        if !point.coords.iter().all(|x| x.is_finite()) {
            return Err(JointError::NotFinite { axis: axis.letter(), what: "the point" });
        }
        check_limits(axis, limits, 1f64.to_degrees())?;
        Ok(Self { axis, motion: Motion::Rotary { direction, point }, limits })
    }

    /// Motion of the joint per unit of its axis: 1, except for a rotary joint whose axis values are in mm, which has radians per mm.
    pub const fn gain(&self) -> f64 {
        match self.motion {
            Motion::Rotary { .. } if !self.axis.is_rotary() => DEGREE_PER_MM,
            _ => 1.0,
        }
    }

    /// Whether the joint is rotary; otherwise it is prismatic.
    pub const fn turns(&self) -> bool {
        matches!(self.motion, Motion::Rotary { .. })
    }

    /// The joint's value at an axis position, mm or radians; also the change of that value when axes change by `position`.
    pub fn value(&self, position: &Position) -> f64 {
        position[self.axis] * self.gain()
    }

    /// The pose of the link at an axis position, relative to its pose at zero (link frame).
    pub fn displacement(&self, position: &Position) -> Isometry {
        let value = self.value(position);
        match self.motion {
            Motion::Prismatic { direction } => Translation3::from(direction.into_inner() * value).into(),
            Motion::Rotary { direction, point } => {
                Isometry::rotation_wrt_point(UnitQuaternion::from_axis_angle(&direction, value), point)
            }
        }
    }

    /// Checks that the axis is within the joint's limits.
    ///
    /// # Errors
    /// [`OutOfLimits`] with the value and the range, mm or degrees.
    pub fn check(&self, position: &Position) -> Result<(), OutOfLimits> {
        let value = self.value(position);
        let Limits { min, max } = self.limits;
        if (min - LIMIT_SLACK..=max + LIMIT_SLACK).contains(&value) {
            return Ok(());
        }
        let (scale, unit) = if self.turns() { (1f64.to_degrees(), "degrees") } else { (1.0, "mm") };
        // Without the noise of converting radians to degrees.
        let [value, min, max] = [value, min, max].map(|x| (x * scale * 1e9).round() / 1e9);
        Err(OutOfLimits { axis: self.axis.letter(), value, min, max, unit })
    }
}

fn unit(axis: Axis, direction: Vector) -> Result<Unit<Vector>, JointError> {
    if !direction.iter().all(|x| x.is_finite()) {
        return Err(JointError::NotFinite { axis: axis.letter(), what: "the direction" });
    }
    geometry::direction(direction).ok_or(JointError::ZeroDirection { axis: axis.letter() })
}

fn check_limits(axis: Axis, limits: Limits, scale: f64) -> Result<(), JointError> {
    let axis = axis.letter();
    if limits.min.is_nan() || limits.max.is_nan() {
        return Err(JointError::NotFinite { axis, what: "a limit" });
    }
    if limits.min > limits.max {
        return Err(JointError::EmptyLimits { axis, min: limits.min * scale, max: limits.max * scale });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn at(axis: Axis, value: f64) -> Position {
        let mut position = Position::default();
        position[axis] = value;
        position
    }

    #[test]
    fn sliding_goes_along_the_direction_whatever_its_length() {
        let joint = Joint::prismatic(Axis::Z, Vector::new(0.0, 0.0, -7.0), Limits::NONE).unwrap();
        let moved = joint.displacement(&at(Axis::Z, 30.0)) * Point::new(1.0, 2.0, 3.0);
        assert!((moved - Point::new(1.0, 2.0, -27.0)).norm() < 1e-12);
    }

    #[test]
    fn turning_goes_counter_clockwise_about_the_line() {
        // A quarter turn about the vertical through (10, 0): (12, 0) is 2 to the right of it and goes 2 above it.
        let joint = Joint::rotary(Axis::C, Vector::z(), Point::new(10.0, 0.0, 0.0), Limits::NONE).unwrap();
        let moved = joint.displacement(&at(Axis::C, FRAC_PI_2)) * Point::new(12.0, 0.0, 5.0);
        assert!((moved - Point::new(10.0, 2.0, 5.0)).norm() < 1e-12);
    }

    #[test]
    fn an_axis_in_mm_may_turn_a_joint_a_degree_at_a_time() {
        let limits = Limits { min: -FRAC_PI_2, max: FRAC_PI_2 };
        let joint = Joint::rotary(Axis::U, Vector::z(), Point::origin(), limits).unwrap();
        let moved = joint.displacement(&at(Axis::U, 90.0)) * Point::new(1.0, 0.0, 0.0);
        assert!((moved - Point::new(0.0, 1.0, 0.0)).norm() < 1e-12);
        assert_eq!(joint.check(&at(Axis::U, 90.0)), Ok(()));
        assert_eq!(
            joint.check(&at(Axis::U, 135.0)).unwrap_err().to_string(),
            "axis U at 135 degrees is outside its limits -90 to 90 degrees"
        );
    }

    #[test]
    fn limits_are_reported_in_mm_and_degrees() {
        let slide = Joint::prismatic(Axis::X, Vector::x(), Limits { min: -1.0, max: 2.0 }).unwrap();
        assert_eq!(slide.check(&at(Axis::X, 2.0)), Ok(()));
        assert_eq!(
            slide.check(&at(Axis::X, 2.5)).unwrap_err().to_string(),
            "axis X at 2.5 mm is outside its limits -1 to 2 mm"
        );
        let turn = Joint::rotary(Axis::B, Vector::y(), Point::origin(), Limits { min: 0.0, max: FRAC_PI_2 }).unwrap();
        assert_eq!(
            turn.check(&at(Axis::B, PI)).unwrap_err().to_string(),
            "axis B at 180 degrees is outside its limits 0 to 90 degrees"
        );
    }

    #[test]
    fn limits_give_way_to_rounding_only() {
        let slide = Joint::prismatic(Axis::X, Vector::x(), Limits { min: -1.0, max: 2.0 }).unwrap();
        for (value, is_allowed) in
            [(2.0 + 0.9e-6, true), (2.0 + 1.1e-6, false), (-1.0 - 0.9e-6, true), (-1.0 - 1.1e-6, false)]
        {
            assert_eq!(slide.check(&at(Axis::X, value)).is_ok(), is_allowed, "{value}");
        }
    }

    #[test]
    fn bad_numbers_are_refused() {
        let none = Limits::NONE;
        assert_eq!(Joint::prismatic(Axis::X, Vector::zeros(), none), Err(JointError::ZeroDirection { axis: 'X' }));
        assert_eq!(
            Joint::prismatic(Axis::X, Vector::new(0.0, f64::NAN, 0.0), none),
            Err(JointError::NotFinite { axis: 'X', what: "the direction" })
        );
        assert_eq!(
            Joint::rotary(Axis::A, Vector::x(), Point::new(f64::INFINITY, 0.0, 0.0), none),
            Err(JointError::NotFinite { axis: 'A', what: "the point" })
        );
        assert_eq!(
            Joint::prismatic(Axis::Y, Vector::y(), Limits { min: 2.0, max: 1.0 }),
            Err(JointError::EmptyLimits { axis: 'Y', min: 2.0, max: 1.0 })
        );
        assert_eq!(
            Joint::rotary(Axis::A, Vector::x(), Point::origin(), Limits { min: PI, max: FRAC_PI_2 }),
            Err(JointError::EmptyLimits { axis: 'A', min: 180.0, max: 90.0 })
        );
        // A clamped axis.
        assert!(Joint::prismatic(Axis::Y, Vector::y(), Limits { min: 2.0, max: 2.0 }).is_ok());
        assert_eq!(
            Joint::prismatic(Axis::Y, Vector::y(), Limits { min: f64::NAN, max: 1.0 }),
            Err(JointError::NotFinite { axis: 'Y', what: "a limit" })
        );
    }
}
