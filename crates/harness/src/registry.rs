//! A method with its name, and the list of those that a program knows.

use crate::geometry::Mesh;
use crate::method::brute::AllPairs;
use crate::method::octree_obb::{self, OctreeObb};
use crate::method::parry::ParryMesh;
use crate::method::{Kind, Model, brute, parry, space, wide};
use crate::record::{ALL_VARIANTS, NULL_VARIANT};
use crate::space::grid::Grid;
use crate::space::octree::Octree;
use crate::tree::{Policy, SplitRule, Tree};
use crate::volume::{BoundingVolume, Info};
use obbtree::engine::aligned::Aligned;
use obbtree::engine::ball::Ball;
use obbtree::engine::oriented::Oriented;
use obbtree::engine::{WideTree, WideVolume};

/// The list of the package `bvbench`, for tests.
#[cfg(test)]
#[path = "../../../src/registry.rs"]
mod list;

#[cfg(test)]
pub use list::standard;

/// Prepares a mesh for queries.
pub type Prepare = fn(&Mesh, Policy) -> Box<dyn Model>;

/// A method: its name, and how it is prepared for a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// Name, reference and safety.
    pub info: Info,
    /// Kind of the method, such as volume, engine or peer.
    pub kind: Kind,
    /// The default tree policy; `None` for methods without a tree of this project.
    pub policy: Option<Policy>,
    /// Whether a duplicate of this variant shows the noise of comparisons.
    pub is_reference: bool,
    /// Whether `check` uses this variant by default: the fastest safe variant of the committed run.
    pub is_fastest: bool,
    /// Whether a run that names no variants measures this one; other variants are measured on request.
    pub is_standard: bool,
    /// Whether the variant is made for a tool against a surface: `check` uses it for tools and workpieces, and the fastest variant for
    /// other pairs.
    pub is_for_tools: bool,
    prepare: Prepare,
}

impl Variant {
    /// A variant with a tree over the shape of `V`, fitted as `V` does, and by default split by `split` along the axes of its volumes.
    pub fn of<V: BoundingVolume>(split: SplitRule) -> Self {
        Self::tree(V::INFO, split, |mesh, policy| Box::new(Tree::build(&V::fit, &mesh.triangles(), policy)))
    }

    /// A variant with a wide tree of volumes of type `V`; its policy is fixed.
    pub fn wide<V: WideVolume>(info: Info) -> Self {
        Self::without_tree(info, Kind::Engine, |mesh, _| Box::new(WideTree::<V>::build(mesh)))
    }

    const fn tree(info: Info, split: SplitRule, prepare: Prepare) -> Self {
        Self { policy: Some(Policy::own(split)), ..Self::without_tree(info, Kind::Volume, prepare) }
    }

    /// A method that prepares its meshes in its own way; it has no policy unless one is set.
    pub const fn without_tree(info: Info, kind: Kind, prepare: Prepare) -> Self {
        Self {
            info,
            kind,
            policy: None,
            is_reference: false,
            is_fastest: false,
            is_standard: true,
            is_for_tools: false,
            prepare,
        }
    }

    /// The same variant, marked as the one whose duplicate shows the noise of comparisons.
    pub const fn reference(mut self) -> Self {
        self.is_reference = true;
        self
    }

    /// The same variant, marked as the one that `check` uses by default.
    pub const fn fastest(mut self) -> Self {
        self.is_fastest = true;
        self
    }

    /// The same variant, left out of runs that do not name it.
    pub const fn on_request(mut self) -> Self {
        self.is_standard = false;
        self
    }

    /// The same variant, which `check` uses only for tools and workpieces.
    pub const fn for_tools(mut self) -> Self {
        self.is_for_tools = true;
        self
    }

    /// The shipped methods that are no bounding volume: the wide trees, the octree of samples, the divisions of space, the control and the
    /// peer. They are compiled here, so that a change of a volume does not build them again.
    pub fn without_volume() -> Vec<Self> {
        vec![
            Variant::wide::<Oriented>(wide::ORIENTED).fastest(),
            Variant::wide::<Aligned>(wide::ALIGNED).on_request(),
            Variant::wide::<Ball>(wide::BALL).on_request(),
            Variant::without_tree(octree_obb::INFO, Kind::Sampling, |mesh, _| Box::new(OctreeObb::new(mesh, true)))
                .on_request()
                .for_tools(),
            Variant::without_tree(octree_obb::SAMPLED, Kind::Sampling, |mesh, _| Box::new(OctreeObb::new(mesh, false)))
                .on_request()
                .for_tools(),
            Variant::without_tree(space::GRID, Kind::Volume, |mesh, _| Box::new(Grid::build(mesh.triangles())))
                .on_request(),
            Variant::without_tree(space::OCTREE, Kind::Volume, |mesh, _| Box::new(Octree::build(mesh.triangles())))
                .on_request(),
            Variant::without_tree(brute::INFO, Kind::Control, |mesh, _| Box::new(AllPairs(mesh.triangles()))),
            Variant::without_tree(parry::INFO, Kind::Peer, |mesh, _| Box::new(ParryMesh::new(mesh))),
        ]
    }

    /// Prepares a mesh; methods without a tree of this project ignore `policy`.
    pub fn prepare(&self, mesh: &Mesh, policy: Option<Policy>) -> Box<dyn Model> {
        (self.prepare)(mesh, policy.or(self.policy).unwrap_or(Policy::own(SplitRule::Median)))
    }
}

/// The variants of a run, in the order of tables and plots.
#[derive(Clone, Debug)]
pub struct Registry {
    variants: Vec<Variant>,
}

impl Registry {
    /// The registry of `variants`, in their order.
    ///
    /// # Panics
    /// As [`Registry::with`].
    pub fn of(variants: impl IntoIterator<Item = Variant>) -> Self {
        variants.into_iter().fold(Self { variants: Vec::new() }, Self::with)
    }

    /// The registry with one more variant at the end.
    ///
    /// # Panics
    /// When a variant of that id is registered already, because an id names one method. Also when the id is a word that files and options
    /// reserve, or has characters other than letters, digits, `-` and `+`.
    pub fn with(mut self, variant: Variant) -> Self {
        let id = variant.info.id;
        let is_plain = !id.is_empty() && id.chars().all(|c| c.is_ascii_alphanumeric() || "-+_".contains(c));
        assert!(is_plain && ![NULL_VARIANT, ALL_VARIANTS].contains(&id), "`{id}` cannot be a variant's id");
        assert!(self.find(variant.info.id).is_none(), "variant `{}` is registered twice", variant.info.id);
        self.variants.push(variant);
        self
    }

    /// All variants.
    pub fn variants(&self) -> &[Variant] {
        &self.variants
    }

    /// The variant with which others are compared: the marked reference, or the first safe variant.
    pub fn reference(&self) -> Option<&Variant> {
        self.safe(|variant| variant.is_reference)
    }

    /// The variant that is fastest: the marked one, or the first safe variant.
    pub fn fastest(&self) -> Option<&Variant> {
        self.safe(|variant| variant.is_fastest)
    }

    /// The safe variant with a mark, or the first safe variant.
    fn safe(&self, is_marked: fn(&Variant) -> bool) -> Option<&Variant> {
        let safe = || self.variants.iter().filter(|variant| variant.info.safe);
        safe().find(|variant| is_marked(variant)).or_else(|| safe().next())
    }

    /// Finds a variant by its id.
    pub fn find(&self, id: &str) -> Option<&Variant> {
        self.variants.iter().find(|variant| variant.info.id == id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "`all` cannot be a variant's id")]
    fn words_of_options_are_no_ids() {
        let info = Info { id: "all", label: "all", reference: "made for a test", safe: true };
        let _ = Registry::of([])
            .with(Variant::without_tree(info, Kind::Volume, |mesh, _| Box::new(AllPairs(mesh.triangles()))));
    }
}
