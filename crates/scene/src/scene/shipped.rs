//! The scenes compiled into the program, so that a run needs nothing but the binary.

/// Names of the shipped scenes, the paper's first.
pub const NAMES: &[&str] = &[
    "lathe-toolpost",
    "lathe-tailstock",
    "trunnion-impeller",
    "mill-vise",
    "turn-mill",
    "robot-cell",
    "freeform-5axis",
];

/// Families of scenes: one tool and one housing with increasing numbers of triangles, and one tool and one sleeve with their triangles
/// moved towards one end.
pub const FAMILIES: &[&str] =
    &["size-1e3", "size-1e4", "size-1e5", "size-1e6", "grading-1", "grading-10", "grading-100"];

/// The scenes of a run by default: two lathes modelled on the paper's scenes, and a mill with five axes.
pub const BY_DEFAULT: &[&str] = &["lathe-toolpost", "lathe-tailstock", "trunnion-impeller"];

macro_rules! files {
    ($($path:literal),* $(,)?) => { &[$(($path, include_str!(concat!("../../../../bench-scenes/", $path)))),*] };
}

/// Every file of every shipped scene, by its path in `bench-scenes`.
const FILES: &[(&str, &str)] = files![
    "lathe/machine.toml",
    "lathe-toolpost/scene.toml",
    "lathe-toolpost/program.ngc",
    "lathe-toolpost/rapid.ngc",
    "lathe-toolpost/swivelled.ngc",
    "lathe-toolpost/clear.ngc",
    "lathe-tailstock/scene.toml",
    "lathe-tailstock/program.ngc",
    "lathe-tailstock/plunge.ngc",
    "lathe-tailstock/hand-wheel.ngc",
    "lathe-tailstock/clear.ngc",
    "trunnion-impeller/scene.toml",
    "trunnion-impeller/program.ngc",
    "mill-vise/scene.toml",
    "mill-vise/program.ngc",
    "turn-mill/scene.toml",
    "turn-mill/program.ngc",
    "robot-cell/scene.toml",
    "robot-cell/program.ngc",
    "freeform-5axis/scene.toml",
    "freeform-5axis/program.ngc",
    "size/machine.toml",
    "size/program.ngc",
    "size-1e3/scene.toml",
    "size-1e4/scene.toml",
    "size-1e5/scene.toml",
    "size-1e6/scene.toml",
    "grading/program.ngc",
    "grading-1/scene.toml",
    "grading-10/scene.toml",
    "grading-100/scene.toml",
];

/// The text of a file, by its path in `bench-scenes`.
pub fn file(path: &str) -> Option<&'static str> {
    FILES.iter().find(|(name, _)| *name == path).map(|(_, text)| *text)
}
