//! What the fuzz targets do with their bytes: one function per target, each a line in [`TARGETS`]. A target must survive
//! any bytes; what it finds out about them is thrown away.
//!
//! `tests/fuzz_corpus.rs` of the package above includes this file and replays `corpus/` through it.

mod gcode;
mod mesh;
mod scene;

/// A target's name, which is its folder's in `corpus/`, and what it does.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const TARGETS: &[Target] = &[
    ("gcode", gcode::run),
    ("stl", |bytes| mesh::run("a.stl", bytes)),
    ("obj", |bytes| mesh::run("a.obj", bytes)),
    ("off", |bytes| mesh::run("a.off", bytes)),
    ("ply", |bytes| mesh::run("a.ply", bytes)),
    ("glb", |bytes| mesh::run("a.glb", bytes)),
    ("three_mf", |bytes| mesh::run("a.3mf", bytes)),
    ("scene", scene::run),
];

/// Runs a target of [`TARGETS`].
///
/// # Panics
/// When there is no such target, or when it has found a fault.
pub fn run(target: &str, bytes: &[u8]) {
    let known = TARGETS.iter().find(|(name, _)| *name == target);
    known.unwrap_or_else(|| panic!("no target `{target}`")).1(bytes);
}
