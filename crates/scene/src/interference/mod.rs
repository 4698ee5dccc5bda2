//! The thesis: hierarchical boxes of a tool against an octree of the surface.
//!
//! Z. Wang, "Research on the Interference Detection in 5-Axis NC Machining", 2006 (abstract only; the method mirrors S. Ding, M. A. Mannan,
//! A. N. Poo, "Oriented bounding box and octree based global interference detection in 5-axis machining of free-form surfaces",
//! Computer-Aided Design 36(13), 2004). The method knows the surface only by samples, so it may miss interference between them. The safe
//! mode widens the tool by the samples' covering radius to prevent that.
//!
//! `docs/octree.md` lists the commands that demonstrate the method.
//!
//! | file | what |
//! |---|---|
//! | [`profile`] | a tool's generating line, and the distance from it |
//! | [`tool`] | cutter, shank and holder; their boxes in two levels |
//! | [`sample`] | a mesh as points with a covering radius |
//! | [`octree`] | gray, white and black octants |
//! | [`detect`] | does the tool, at a pose, come too near to the surface, where, and how deep? |
//! | [`revolved`] | a mesh as a tool |
//! | [`path`] | contact points over a free-form surface, and the tool there |
//! | [`program`] | a path as a program under tool-centre-point control |

pub mod profile;
pub mod tool;
pub mod sample;
pub mod octree;
pub mod detect;
pub mod revolved;
pub mod path;
pub mod program;

pub use detect::{Coherence, Counts, Detector, Hit, Search};
pub use octree::{Division, SurfaceOctree};
pub use profile::Profile;
pub use revolved::{ROUND, Revolved};
pub use sample::Samples;
pub use tool::{Body, BodyKind, BoxedTool, SecondLevel, Tool};
