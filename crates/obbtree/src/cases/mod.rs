//! Meshes and posed pairs made to be nasty, for tests: needles, points, duplicates, parts far from their origin, all around first contact.
//!
//! Behind the feature `cases`. Whoever adds a volume or an engine tests it on these.

mod draw;
pub mod meshes;
mod posed;

pub use draw::Draw;
pub use posed::{Case, Cases, contacts};
