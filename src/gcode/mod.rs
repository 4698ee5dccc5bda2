//! RS274/NGC programs: from text to canonical moves to sampled axis positions.

pub mod canonical;
pub mod error;
pub mod setup;
mod lex;
pub mod expression;
mod parameters;
mod block;
mod modal;
mod offsets;
pub mod arc;
mod datum;
mod motion;
mod cycle;
mod thread;
pub mod oword;
mod source;
pub mod interpret;
pub mod path;
pub mod tool_table;

pub use canonical::{Axis, Move, MoveKind, Plane, Position};
pub use error::{Cause, GcodeError};
pub use interpret::{Program, interpret};
pub use path::{Sample, Sampling, sample};
pub use setup::{Setup, Tool, UserCode, WorkOffset};
pub use tool_table::read_tool_table;
