//! Every engine and volume against a judge of their own: meshes and poses made from numbers, verdicts, lists of touching faces and distances, each
//! held against all pairs of triangles, which [`integers`] decides.
//!
//! `tests/fuzz.rs` runs seeded cases, the fuzz target `engines` those that libFuzzer makes up.
//!
//! Reading order: [`choices`], [`meshes`], [`integers`], [`truth`], [`poses`], [`ask`].

mod ask;
mod choices;
mod integers;
mod meshes;
mod poses;
mod truth;

pub use choices::Choices;

use bvbench::geometry::{Isometry, Mesh};
use bvbench::method::Kind;
use bvbench::registry::{Registry, Variant};
use poses::Length;
use truth::Truth;

/// Farthest that a corner of a posed mesh is from the origin along an axis, mm: what [`integers`] can hold.
const FARTHEST_MM: f64 = 24_000.0;

/// One case in as many may ask methods that sample a mesh.
const SAMPLING: u64 = 1024;

/// An answer that is wrong.
#[derive(Debug)]
pub struct Mismatch(String);

impl std::fmt::Display for Mismatch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

/// What has been asked.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Pairs of meshes.
    pub cases: u64,
    /// Poses at which every question was asked.
    pub poses: u64,
    /// Those of them at which the meshes touch.
    pub touching: u64,
    /// Poses of paths.
    pub path_poses: u64,
    /// Those of them at which the meshes touch.
    pub path_touching: u64,
    /// Questions, to whichever engine.
    pub questions: u64,
}

impl std::ops::Add for Tally {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            cases: self.cases + other.cases,
            poses: self.poses + other.poses,
            touching: self.touching + other.touching,
            path_poses: self.path_poses + other.path_poses,
            path_touching: self.path_touching + other.path_touching,
            questions: self.questions + other.questions,
        }
    }
}

/// A pose, and every pair of faces that touch there.
struct Posed {
    a_from_b: Isometry,
    contacts: Vec<(u32, u32)>,
    /// The distance and the size of everything, mm; of use where nothing touches.
    distance_and_size_mm: (f64, f64),
}

/// Two meshes, poses, and what is so there.
struct Case {
    a: Mesh,
    b: Mesh,
    poses: Vec<Posed>,
    path: Vec<(Isometry, bool)>,
}

impl Case {
    fn new(choices: &mut Choices) -> Self {
        // Some cases aim at one slack each: the snapping, the rotation, and what a node contributes.
        let (a, b, length) = match choices.below(9) {
            0 => (meshes::of_the_grid(choices), meshes::of_the_grid(choices), Length::Unit),
            1 => (meshes::far(choices), meshes::far(choices), Length::Off),
            2 => (meshes::fan(choices), meshes::of_the_grid(choices), Length::Unit),
            3 => (meshes::fan(choices), meshes::any(choices), Length::Unit),
            n => (meshes::any(choices), meshes::any(choices), if n == 4 { Length::Off } else { Length::Unit }),
        };
        let (a, b) = if choices.once_in(2) { (a, b) } else { (b, a) };
        let truth = Truth::new(&a, &b);
        let rotation = poses::rotation(choices, length);
        let joined = poses::joined(choices, &a, &b, rotation);
        let [(low_a, high_a), (low_b, high_b)] = [&a, &b].map(extent);
        let size_mm = (high_a - low_a).norm().min((high_b - low_b).norm());
        let direction = choices.direction();
        let border = if truth.touches(&joined) { poses::border(&truth, &joined, &direction) } else { None };
        let mut all: Vec<Isometry> = border.into_iter().flatten().chain([joined]).collect();
        let mut off = all[0];
        off.translation.vector += choices.vector() * (size_mm * choices.between(-30, 0));
        all.push(off);
        let path = poses::path(choices, &all[0], size_mm, length);
        let reach = b.vertices().iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
        let fits = |pose: &Isometry| pose.translation.vector.amax() + 1.001 * reach <= FARTHEST_MM;
        let posed = |a_from_b: Isometry| Posed {
            contacts: truth.contacts(&a_from_b),
            distance_and_size_mm: truth.distance_and_size_mm(&a_from_b),
            a_from_b,
        };
        let poses = all.into_iter().filter(fits).map(posed).collect();
        let path = path.into_iter().filter(fits).map(|pose| (pose, truth.touches(&pose))).collect();
        Self { a, b, poses, path }
    }
}

fn extent(mesh: &Mesh) -> (bvbench::geometry::Point, bvbench::geometry::Point) {
    let first = mesh.vertices()[0];
    mesh.vertices().iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
}

/// Makes a case and asks every wide tree, and `variants` of those in the registry that promise to miss nothing, which differ from case to case.
///
/// # Errors
/// The first answer that is wrong.
pub fn check(choices: &mut Choices, registry: &Registry, variants: usize) -> Result<Tally, Mismatch> {
    let first = choices.below(u64::MAX) as usize;
    let case = Case::new(choices);
    let mut questions = ask::wide_trees(&case, first)?;
    // What samples a mesh takes a thousand times as long to build.
    let with_samples = choices.once_in(SAMPLING);
    let asked = |variant: &&Variant| ask::is_asked(variant) && (with_samples || variant.kind != Kind::Sampling);
    let safe: Vec<_> = registry.variants().iter().filter(asked).collect();
    for k in 0..variants.min(safe.len()) {
        questions += ask::variant(&case, safe[(first % safe.len() + k) % safe.len()])?;
    }
    Ok(Tally {
        cases: 1,
        poses: case.poses.len() as u64,
        touching: case.poses.iter().filter(|pose| !pose.contacts.is_empty()).count() as u64,
        path_poses: case.path.len() as u64,
        path_touching: case.path.iter().filter(|(_, touching)| *touching).count() as u64,
        questions,
    })
}
