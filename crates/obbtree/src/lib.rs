#![doc = include_str!("../README.md")]

mod batch;
#[cfg(any(test, feature = "cases"))]
pub mod cases;
mod collider;
pub mod engine;
mod frame;
mod manager;
mod mesh;
mod pair;
mod path;
mod pose;
#[cfg(feature = "serde")]
mod serial;
#[cfg(test)]
mod tests;
mod world;

pub use batch::BatchError;
pub use collider::{Collider, Contact, Nearest};
pub use engine::geometry::MeshError;
pub use manager::{Manager, ManagerError, NearestObjects, ObjectContacts};
pub use mesh::Mesh;
pub use nalgebra;
pub use path::Path;
pub use pose::{PoseError, pose_from_matrix};
