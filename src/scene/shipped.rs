//! The scenes compiled into the program, so that a run needs nothing but the binary.

/// Names of the shipped scenes, in the order in which they are run.
pub const NAMES: &[&str] = &["lathe-toolpost", "lathe-tailstock", "trunnion-impeller"];

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
