//! Scenes: parts with meshes on a machine, the pairs of them that are examined, and what moves them.

use crate::geometry::Mesh;
use std::sync::Arc;

/// A part: a mesh on a link of the machine.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name, unique in the scene.
    pub name: String,
    /// Its mesh, mm, in the part's own frame.
    pub mesh: Arc<Mesh>,
}

/// Two parts that may collide, as indices into [`Scene::parts`]. `a` is the one whose frame the poses are given in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Pair {
    /// The part whose frame poses are given in.
    pub a: usize,
    /// The other part.
    pub b: usize,
}

/// A scene, loaded and checked.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name: the folder's.
    pub name: String,
    /// One line on what it shows.
    pub title: String,
    /// The parts.
    pub parts: Vec<Part>,
    /// The pairs examined.
    pub pairs: Vec<Pair>,
    /// Path or name to content hash of everything the scene was made from.
    pub inputs: std::collections::BTreeMap<String, String>,
}

impl Scene {
    /// `a:b`, the name of a pair in files.
    #[must_use]
    pub fn pair_name(&self, pair: Pair) -> String {
        format!("{}:{}", self.parts[pair.a].name, self.parts[pair.b].name)
    }
}
