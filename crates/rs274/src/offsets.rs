//! Between program coordinates and axis positions.
//!
//! axis = rotate(local(program) + G92) + work origin + tool offset, the turn being about Z (LinuxCNC, "Coordinate Systems"). `local` is
//! what a block of codes does to X, Y and Z before all else: a turn, a scale, a mirror or a tilted plane.
//! Values here are mm and degrees, as programs give them; [`to_canonical`] turns them to radians.

use super::affine::Affine;
use super::canonical::{Axis, Plane, Position};
use super::setup::WorkOffset;

/// Nine values: mm and degrees.
pub(super) type Values9 = [f64; 9];

/// Parts of a matrix below this are rounding.
const ROUNDING: f64 = 1e-12;

/// Everything between program coordinates and axis positions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Offsets {
    /// Origin of the work coordinate system.
    pub origin: Values9,
    /// Turn of the work coordinate system about Z, degrees.
    pub rotation: f64,
    /// G92, on LinuxCNC G52, too.
    pub shift: Values9,
    /// G52 of Fanuc's and Haas's controls.
    pub local_zero: Values9,
    /// G43 and relatives.
    pub tool: Values9,
    /// Turned, scaled, mirrored or tilted coordinates of the program.
    pub local: Option<Affine>,
}

/// What a plane's circles become in axis positions: circles of the same plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Similar {
    /// By how much they grow.
    pub scale: f64,
    /// Whether left becomes right.
    pub mirrors: bool,
}

impl Offsets {
    fn shifts(&self) -> Values9 {
        std::array::from_fn(|i| self.shift[i] + self.local_zero[i])
    }

    /// Where the origin and G92 have zero, and how it is turned.
    pub fn zero(&self) -> WorkOffset {
        let mut zero = self.shift;
        turn(&mut zero, self.rotation);
        zero.iter_mut().zip(self.origin).for_each(|(zero, origin)| *zero += origin);
        WorkOffset { origin: to_canonical(&zero), rotation: self.rotation.to_radians() }
    }

    /// Axis positions of a point in program coordinates.
    pub fn to_machine(&self, program: &Values9) -> Values9 {
        let mut shifted = *program;
        if let Some(local) = &self.local {
            local.apply(&mut shifted);
        }
        for (value, shift) in shifted.iter_mut().zip(self.shifts()) {
            *value += shift;
        }
        turn(&mut shifted, self.rotation);
        std::array::from_fn(|i| shifted[i] + self.origin[i] + self.tool[i])
    }

    /// Program coordinates of axis positions.
    pub fn to_program(&self, machine: &Values9) -> Values9 {
        let mut shifted: Values9 = std::array::from_fn(|i| machine[i] - self.origin[i] - self.tool[i]);
        turn(&mut shifted, -self.rotation);
        for (value, shift) in shifted.iter_mut().zip(self.shifts()) {
            *value -= shift;
        }
        if let Some(local) = &self.local {
            local.undo(&mut shifted);
        }
        shifted
    }

    /// Turns a difference of two points in program coordinates into one of axis positions.
    pub fn to_machine_vector(&self, vector: &mut Values9) {
        if let Some(local) = &self.local {
            local.apply_linear(vector);
        }
        turn(vector, self.rotation);
    }

    /// How many of X, Y and Z, from the first, a word for one of them may move: none for an upright system but that one.
    pub fn mixed_axes(&self) -> usize {
        match (&self.local, self.rotation) {
            (Some(_), _) => 3,
            (None, 0.0) => 0,
            _ => 2,
        }
    }

    /// Whether circles of a plane stay circles of that plane, and which.
    pub fn similar(&self, plane: Plane) -> Option<Similar> {
        if self.local.is_none() && (self.rotation == 0.0 || plane == Plane::Xy) {
            return Some(Similar { scale: 1.0, mirrors: false });
        }
        let [first, second, normal] = plane.axes().map(|axis| axis as usize);
        let column = |axis: usize| {
            let mut vector = [0.0; 9];
            vector[axis] = 1.0;
            self.to_machine_vector(&mut vector);
            vector
        };
        let [u, v, w] = [first, second, normal].map(column);
        let (scale, other) = (u[first].hypot(u[second]), v[first].hypot(v[second]));
        let slack = ROUNDING * scale.max(other).max(1.0);
        let stays = u[normal].abs() <= slack && v[normal].abs() <= slack;
        let upright = w[first].abs() <= slack && w[second].abs() <= slack;
        let round =
            (scale - other).abs() <= slack && (u[first] * v[first] + u[second] * v[second]).abs() <= slack * scale;
        let mirrors = u[first] * v[second] - u[second] * v[first] < 0.0;
        (stays && upright && round).then_some(Similar { scale, mirrors })
    }

    /// The most by which a length grows from program coordinates to axis positions, or a little more.
    pub fn largest_scale(&self) -> f64 {
        self.local.as_ref().map_or(1.0, Affine::norm)
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
