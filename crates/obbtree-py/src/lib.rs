//! obbtree from Python: a thin layer that turns arrays into meshes and poses, and lets go of the interpreter while a query runs.

mod convert;
mod convex;
mod manager;
mod pair;
mod threads;

use pyo3::prelude::*;

/// Exact collision and distance queries between triangle meshes.
#[pymodule]
mod _obbtree {
    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "Python's name for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    use super::convex::{Convex, Penetration};
    #[pymodule_export]
    use super::manager::Manager;
    #[pymodule_export]
    use super::pair::{Collider, Contacts, Mesh, Nearest, Path};
}
