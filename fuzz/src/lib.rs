//! What the fuzz targets do with their bytes: one function per target, each a line in [`TARGETS`]. A target must survive
//! any bytes; what it finds out about them is thrown away.
//!
//! `tests/fuzz_corpus.rs` of the package above includes this file and replays `corpus/` through it.

mod gcode;

/// A target's name, which is its folder's in `corpus/`, and what it does.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const TARGETS: &[Target] = &[("gcode", gcode::run)];

/// Runs a target of [`TARGETS`].
///
/// # Panics
/// When there is no such target, or when it has found a fault.
pub fn run(target: &str, bytes: &[u8]) {
    let known = TARGETS.iter().find(|(name, _)| *name == target);
    known.unwrap_or_else(|| panic!("no target `{target}`")).1(bytes);
}
