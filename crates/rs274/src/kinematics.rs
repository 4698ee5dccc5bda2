//! What a program needs to know of the machine that runs it: where the tool's tip is while rotary axes are tilted.

use super::canonical::{Axis, Position};
use std::fmt::Debug;
use std::sync::Arc;

/// A machine with rotary axes. Lengths are mm, angles radians; `length_mm` is the tool's length.
pub trait TipKinematics: Debug + Send + Sync {
    /// What a program under tool-centre-point control says at these axis positions: X, Y and Z of the tip in machine coordinates as if
    /// all rotary axes stood at zero, the rotary axes as they are.
    ///
    /// # Errors
    /// Why there is no such place.
    fn tip(&self, axes: &Position, length_mm: f64) -> Result<Position, String>;

    /// The opposite of [`TipKinematics::tip`].
    ///
    /// # Errors
    /// Why the axes cannot hold the tip there.
    fn axes(&self, tip: &Position, length_mm: f64) -> Result<Position, String>;

    /// Turns the rotary axes until the tool points along `vector`; linear axes stay. `vector` goes from the tip up the tool, as the workpiece sees
    /// it, along X, Y and Z as they are while all rotary axes are at zero. Returns these axis positions, and the others within the machine's
    /// limits that do the same, if there are any.
    ///
    /// # Errors
    /// Why the rotary axes cannot.
    fn orient(&self, vector: [f64; 3], axes: &Position) -> Result<(Position, Option<Position>), String>;

    /// Whether the workpiece turns with an axis: one of a table.
    fn turns_work(&self, axis: Axis) -> bool;
}

/// A machine that interpreters share.
#[derive(Clone, Debug)]
pub struct Kinematics(pub Arc<dyn TipKinematics>);

impl PartialEq for Kinematics {
    /// Whether both are one and the same machine.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}
