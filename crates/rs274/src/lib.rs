#![doc = include_str!("../README.md")]
//!
//! # How it works
//!
//! A line becomes a block, the block changes modes, offsets and parameters and adds moves ([`canonical`]), and the moves are walked by
//! [`path`].

pub mod canonical;
pub mod error;
pub mod dialect;
pub mod kinematics;
pub mod file;
pub mod setup;
mod lex;
pub mod expression;
mod parameters;
mod block;
mod modal;
mod affine;
mod offsets;
pub mod arc;
mod datum;
mod tip_control;
mod feed;
mod motion;
mod offset_curve;
mod compensation;
mod spline;
mod cycle;
mod pocket;
mod thread;
pub mod oword;
mod macro_flow;
mod transform;
mod fanuc;
mod corner;
mod lathe;
mod contour;
mod profile;
mod profile_cycle;
mod source;
mod foreign;
mod unread;
pub mod interpret;
pub mod path;
pub mod tool_table;
pub mod parameter_file;

/// This version of the interpreter.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

pub use canonical::{Axis, Move, MoveKind, Plane, Position};
pub use dialect::{CodeName, Dialect, Note};
pub use error::{Cause, GcodeError};
pub use interpret::{Program, interpret};
pub use kinematics::{Kinematics, TipKinematics};
pub use parameter_file::read_parameter_file;
pub use path::{MAX_SAMPLES, RapidPath, Sample, Sampling, TooManySamples, sample};
pub use setup::{Limits, Setup, Tool, Units, UserCode, WorkOffset};
pub use tool_table::read_tool_table;
