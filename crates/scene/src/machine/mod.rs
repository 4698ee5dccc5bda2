//! Machines: a tree of links joined by fixed, prismatic and rotary joints, moved by axis positions.
//!
//! Axis names follow ISO 841. Lengths are mm and angles radians; only the file format ([`mod@file`]) uses degrees.
//!
//! Reading order: [`joint`], [`tree`] (links and their poses), [`travel`] (bounds on the travel of parts), [`tip`] (tool-centre-point
//! control), [`orientation`] (the tool-vector inverse), [`mod@file`] (TOML), `urdf` (machines of ROS, with the feature of that name).

pub mod joint;
pub mod tree;
pub mod travel;
pub mod tip;
pub mod orientation;
pub mod file;
#[cfg(feature = "urdf")]
pub mod urdf;

pub use joint::{Joint, JointError, Limits, Motion, OutOfLimits};
pub use tree::{Link, Machine, MachineError, Poses};
