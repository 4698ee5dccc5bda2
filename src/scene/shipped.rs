//! The scenes compiled into the program, so that a run needs nothing but the binary.

/// Names of the shipped scenes, the paper's first.
pub const NAMES: &[&str] = &["lathe-toolpost", "lathe-tailstock", "trunnion-impeller"];

/// Those of the paper: what a run is about unless it is told otherwise.
pub const OF_THE_PAPER: &[&str] = &["lathe-toolpost", "lathe-tailstock"];

macro_rules! files {
    ($($path:literal),* $(,)?) => { &[$(($path, include_str!(concat!("../../bench-scenes/", $path)))),*] };
}

/// Every file of every shipped scene, by its path in `bench-scenes`.
const FILES: &[(&str, &str)] = files![
    "lathe/machine.toml",
    "lathe-toolpost/scene.toml",
    "lathe-toolpost/program.ngc",
    "lathe-tailstock/scene.toml",
    "lathe-tailstock/program.ngc",
    "trunnion-impeller/scene.toml",
    "trunnion-impeller/program.ngc",
];

/// The text of a file, by its path in `bench-scenes`.
pub fn file(path: &str) -> Option<&'static str> {
    FILES.iter().find(|(name, _)| *name == path).map(|(_, text)| *text)
}
