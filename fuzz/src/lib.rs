//! What the fuzz targets do with their bytes: one function per target, each a line in [`TARGETS`]. A target must survive
//! any bytes; what it finds out about them is thrown away.
//!
//! `tests/fuzz.rs` of the package above includes this file and replays `corpus/` through it.

pub mod engines;
mod gcode;
mod mesh;
mod record;
mod scene;
mod stock;

use bvbench::registry;
use rs274::Dialect;

/// A target's name, which is its folder's in `corpus/`, and what it does.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const TARGETS: &[Target] = &[
    ("gcode", |bytes| gcode::run(bytes, Dialect::LinuxCnc)),
    ("fanuc", |bytes| gcode::run(bytes, Dialect::Fanuc)),
    ("haas", |bytes| gcode::run(bytes, Dialect::Haas)),
    ("grbl", |bytes| gcode::run(bytes, Dialect::Grbl)),
    ("stl", |bytes| mesh::run("a.stl", bytes)),
    ("obj", |bytes| mesh::run("a.obj", bytes)),
    ("off", |bytes| mesh::run("a.off", bytes)),
    ("ply", |bytes| mesh::run("a.ply", bytes)),
    ("glb", |bytes| mesh::run("a.glb", bytes)),
    ("three_mf", |bytes| mesh::run("a.3mf", bytes)),
    ("scene", scene::run),
    ("npy", record::npy),
    ("manifest", record::manifest),
    ("stock", stock::run),
    ("engines", ask_engines),
];

/// Makes a case of the bytes and asks the wide trees and one variant of the registry.
fn ask_engines(bytes: &[u8]) {
    let asked = engines::check(&mut engines::Choices::new(bytes, 0, 0), &registry::standard(), 1);
    if let Err(mismatch) = asked {
        panic!("{mismatch}");
    }
}

/// Runs a target of [`TARGETS`].
///
/// # Panics
/// When there is no such target, or when it has found a fault.
pub fn run(target: &str, bytes: &[u8]) {
    let known = TARGETS.iter().find(|(name, _)| *name == target);
    known.unwrap_or_else(|| panic!("no target `{target}`")).1(bytes);
}
