//! Between program coordinates and axis positions.
//!
//! axis = rotate(program + G92) + work origin + tool offset, the turn being about Z (LinuxCNC, "Coordinate Systems").
//! Values here are mm and degrees, as programs give them; [`to_canonical`] turns them to radians.

use super::canonical::{Axis, Position};

/// Nine values: mm and degrees.
pub(super) type Values9 = [f64; 9];

/// Everything between program coordinates and axis positions.
#[derive(Clone, Debug, Default)]
pub(super) struct Offsets {
    /// Origin of the work coordinate system.
    pub origin: Values9,
    /// Turn of the work coordinate system about Z, degrees.
    pub rotation: f64,
    /// G92 or G52.
    pub shift: Values9,
    /// G43 and relatives.
    pub tool: Values9,
}

impl Offsets {
    /// Axis positions of a point in program coordinates.
    pub fn to_machine(&self, program: &Values9) -> Values9 {
        let mut shifted: Values9 = std::array::from_fn(|i| program[i] + self.shift[i]);
        turn(&mut shifted, self.rotation);
        std::array::from_fn(|i| shifted[i] + self.origin[i] + self.tool[i])
    }

    /// Program coordinates of axis positions.
    pub fn to_program(&self, machine: &Values9) -> Values9 {
        let mut shifted: Values9 = std::array::from_fn(|i| machine[i] - self.origin[i] - self.tool[i]);
        turn(&mut shifted, -self.rotation);
        std::array::from_fn(|i| shifted[i] - self.shift[i])
    }
}

/// Turns X and Y about Z by `degrees`; by nothing at all when that is 0, so that numbers stay as they are.
pub(super) fn turn(values: &mut Values9, degrees: f64) {
    if degrees != 0.0 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        (values[0], values[1]) = (values[0] * cos - values[1] * sin, values[0] * sin + values[1] * cos);
    }
}

/// mm and degrees to mm and radians.
pub(super) fn to_canonical(values: &Values9) -> Position {
    Position(std::array::from_fn(|i| if Axis::ALL[i].is_rotary() { values[i].to_radians() } else { values[i] }))
}

/// mm and radians to mm and degrees.
pub(super) fn from_canonical(position: &Position) -> Values9 {
    std::array::from_fn(|i| if Axis::ALL[i].is_rotary() { position.0[i].to_degrees() } else { position.0[i] })
}
