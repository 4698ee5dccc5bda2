//! The remaining stock as a mesh.
