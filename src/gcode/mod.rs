//! RS274/NGC programs: from text to canonical moves to sampled axis positions.

pub mod canonical;

pub use canonical::{Axis, Move, MoveKind, Plane, Position};
