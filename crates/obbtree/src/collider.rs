//! Meshes that can be asked about.

use crate::batch::{self, BatchError};
use crate::engine::geometry::{GridMesh, MeshError};
use crate::engine::node::WideTree;
use crate::engine::oriented::Oriented;
use crate::frame::Frame;
use crate::mesh::Mesh;
use crate::pair::Pair;
use crate::pose::PoseError;
use nalgebra::{Isometry3, Point3};
use std::iter;
use std::sync::{Arc, OnceLock};

/// The tree of a collider.
pub(crate) type Tree = WideTree<Oriented>;

/// A mesh with the tree that queries need. Clones share both.
///
/// Lengths are in the mesh's unit. A pose `a_from_b` takes coordinates in the frame of the other mesh `b` to those in the frame of this one, `a`; where
/// both have a pose in a common world, it is `world_from_a.inverse() * world_from_b`.
///
/// Contact and distance are those of surfaces: a mesh wholly inside another does not touch it. Verdicts are exact for the vertices as the engine
/// holds them: rounded to 2⁻³⁰ of the largest coordinate of the larger mesh or finer, before and after they are moved by the pose.
#[derive(Clone, Debug)]
pub struct Collider(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    mesh: Mesh,
    /// Smallest and largest coordinates, asked for by every query of a manager.
    bounds: [Point3<f64>; 2],
    frame: Frame,
    tree: Tree,
    /// Trees in larger units, for pairs with larger meshes and for distances far away: the first of a list.
    coarser: OnceLock<Box<Coarser>>,
}

/// A tree in a larger unit, and the next one. Nothing that is in the list changes, so that no query waits for a lock: a process that is forked meanwhile would
/// wait for ever.
#[derive(Debug)]
struct Coarser {
    exponent: i32,
    tree: Arc<Tree>,
    next: OnceLock<Box<Coarser>>,
}

/// The nearest points of two meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Nearest {
    /// The distance, in the meshes' unit: 0 exactly where they touch.
    pub distance: f64,
    /// The nearest point of the first mesh and that of the second, in the frame of the first unless said otherwise.
    pub points: [Point3<f64>; 2],
    /// The faces that the points lie on.
    pub faces: [u32; 2],
}

/// Two triangles that touch.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contact {
    /// The face of the first mesh and that of the second.
    pub faces: [u32; 2],
    /// A point that both have, up to rounding, in the frame of the first mesh unless said otherwise.
    pub point: Point3<f64>,
}

impl Collider {
    /// Builds the tree over a mesh, on as many threads as there are; about a second for a million triangles.
    #[must_use]
    pub fn new(mesh: Mesh) -> Self {
        let bounds = mesh.bounds();
        let frame = Frame::of(bounds);
        let tree = tree_of(&mesh, &frame, frame.exponent);
        Self(Arc::new(Inner { mesh, bounds, frame, tree, coarser: OnceLock::new() }))
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.0.mesh
    }

    /// Whether the meshes share a point at a pose. Touching counts.
    ///
    /// ```
    /// use obbtree::{Collider, Mesh};
    /// use obbtree::nalgebra::Isometry3;
    ///
    /// let plate = Collider::new(Mesh::new([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], [[0, 1, 2]])?);
    /// assert!(plate.collides(&plate, &Isometry3::translation(1.0, 1.0, 0.0))?);
    /// assert!(!plate.collides(&plate, &Isometry3::translation(1.0, 1.0, 1e-6))?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`PoseError`] when the pose is not finite or has no rotation.
    pub fn collides(&self, other: &Self, a_from_b: &Isometry3<f64>) -> Result<bool, PoseError> {
        Pair::new(self, other).collides(a_from_b)
    }

    /// Pairs of triangles that touch, at most `limit` of them, sorted by faces. Which ones are found where there are more is unspecified.
    ///
    /// # Errors
    /// As [`Collider::collides`].
    pub fn contacts(&self, other: &Self, a_from_b: &Isometry3<f64>, limit: usize) -> Result<Vec<Contact>, PoseError> {
        Pair::new(self, other).contacts(a_from_b, limit)
    }

    /// The distance of the meshes and their nearest points, in the frame of this mesh. For the vertices as the engine holds them it is right within 4·10⁻¹¹
    /// of how far apart the corners of the two nearest faces are at most, by a count of roundings; in tests within 10⁻¹² of that. Rounding the vertices adds up to
    /// 2⁻²⁸ of the larger mesh's largest coordinate: one vertex is rounded once, the other twice, by 0.87 of a step of the grid each time. For a translation
    /// far beyond the size of both meshes (2⁴⁸ times and more) their vertices are rounded to 2⁻⁷⁸ of the translation, and each such scale has a tree of its own.
    ///
    /// ```
    /// use obbtree::{Collider, Mesh};
    /// use obbtree::nalgebra::{Isometry3, Point3};
    ///
    /// let plate = Collider::new(Mesh::new([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], [[0, 1, 2]])?);
    /// let nearest = plate.distance(&plate, &Isometry3::translation(12.0, 0.0, 4.0))?;
    /// assert_eq!(nearest.distance, 5.0);
    /// assert_eq!(nearest.points, [Point3::new(9.0, 0.0, 0.0), Point3::new(12.0, 0.0, 4.0)]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`PoseError`] when the pose is not finite, has no rotation, or translates by more than 2¹⁰²² on an axis.
    pub fn distance(&self, other: &Self, a_from_b: &Isometry3<f64>) -> Result<Nearest, PoseError> {
        let found = Pair::new(self, other).distance_below(a_from_b, f64::INFINITY)?;
        Ok(found.expect("two meshes have a distance"))
    }

    /// As [`Collider::distance`] if the distance is below `limit`; otherwise `None`, which is found sooner. `None` if `limit` is NaN.
    ///
    /// # Errors
    /// As [`Collider::distance`].
    pub fn distance_below(
        &self,
        other: &Self,
        a_from_b: &Isometry3<f64>,
        limit: f64,
    ) -> Result<Option<Nearest>, PoseError> {
        Pair::new(self, other).distance_below(a_from_b, limit)
    }

    /// [`Collider::collides`] at many poses, on as many threads as there are.
    ///
    /// # Errors
    /// The first pose, by its number, that [`Collider::collides`] refuses.
    pub fn collides_each(&self, other: &Self, a_from_b: &[Isometry3<f64>]) -> Result<Vec<bool>, BatchError> {
        let pair = Pair::new(self, other);
        batch::each(a_from_b, |pose| pair.collides(pose))
    }

    /// [`Collider::distance`] at many poses, on as many threads as there are.
    ///
    /// # Errors
    /// The first pose, by its number, that [`Collider::distance`] refuses.
    pub fn distance_each(&self, other: &Self, a_from_b: &[Isometry3<f64>]) -> Result<Vec<Nearest>, BatchError> {
        let pair = Pair::new(self, other);
        batch::each(a_from_b, |pose| {
            let found = pair.distance_below(pose, f64::INFINITY)?;
            Ok(found.expect("two meshes have a distance"))
        })
    }

    pub(crate) fn bounds(&self) -> [Point3<f64>; 2] {
        self.0.bounds
    }

    pub(crate) fn frame(&self) -> &Frame {
        &self.0.frame
    }

    /// The tree in the mesh's own unit.
    pub(crate) fn tree(&self) -> &Tree {
        &self.0.tree
    }

    /// The tree in units of 2 to the power of `exponent`, which is not below the mesh's own; built when it is first needed. `None` where it is the mesh's own.
    pub(crate) fn coarser(&self, exponent: i32) -> Option<Arc<Tree>> {
        let Inner { mesh, frame, coarser, .. } = &*self.0;
        if exponent == frame.exponent {
            return None;
        }
        if let Some(found) = self.kept().find(|kept| kept.exponent == exponent) {
            return Some(found.tree.clone());
        }
        let tree = Arc::new(tree_of(mesh, frame, exponent));
        let mut built = Box::new(Coarser { exponent, tree: tree.clone(), next: OnceLock::new() });
        let mut end = coarser;
        while let Err(back) = end.set(built) {
            // Another thread has put a tree here, perhaps this one.
            let kept = end.get().expect("it is set");
            if kept.exponent == exponent {
                return Some(kept.tree.clone());
            }
            (built, end) = (back, &kept.next);
        }
        Some(tree)
    }

    fn kept(&self) -> impl Iterator<Item = &Coarser> {
        iter::successors(self.0.coarser.get(), |kept| kept.next.get()).map(Box::as_ref)
    }

    /// Memory that the collider holds, bytes: the mesh and its trees.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let Inner { mesh, tree, .. } = &*self.0;
        size_of_val(mesh.vertices())
            + size_of_val(mesh.faces())
            + tree.bytes()
            + self.kept().map(|kept| kept.tree.bytes()).sum::<usize>()
    }
}

/// The tree in units of 2 to the power of `exponent`. Vertices that no face has may be anywhere and are left at the origin.
fn tree_of(mesh: &Mesh, frame: &Frame, exponent: i32) -> Tree {
    let mut vertices = vec![Point3::origin(); mesh.vertices().len()];
    for &vertex in mesh.faces().as_flattened() {
        vertices[vertex as usize] = frame.seen(&mesh.vertices()[vertex as usize], exponent);
    }
    let on_grid: Result<GridMesh, MeshError> = GridMesh::new(vertices, mesh.faces().to_vec());
    Tree::build(&on_grid.expect("the frame holds the mesh"))
}
