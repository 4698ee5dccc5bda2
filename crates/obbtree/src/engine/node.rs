//! What the tree is made of.
//!
//! A volume is named by its slot: the number of the node that holds it times eight, plus its place there. Node 0 holds the
//! root alone, so that the root is a slot like all others.

use super::axis::Around;
use super::lanes::FOUR;
use super::volume::WideVolume;
use crate::engine::geometry::{Point, Triangle};
use std::ops::Range;

/// Children per node.
pub const WIDTH: usize = 8;

/// Up to eight volumes, side by side: those of child nodes first, then those of two triangles, then those of one. Of oriented boxes five cache lines.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub struct Node<V: WideVolume> {
    /// The volumes, relative to `origin`.
    pub volumes: V::Eight,
    /// Near the middle of the node's contents, mm, mesh frame.
    pub(super) origin: [f32; 3],
    /// What the children contribute to the slack of the overlap test ([`super::volume`]), mm.
    pub(super) slack: f32,
    /// The number of the first child node; the others follow it.
    pub(super) first_node: u32,
    /// The place of the first triangle; the others follow it.
    pub(super) first_triangle: u32,
    /// How many children are nodes.
    pub(super) inner: u8,
    /// How many children there are.
    pub(super) count: u8,
    /// How many children are of two triangles.
    pub(super) paired: u8,
}

impl<V: WideVolume> Node<V> {
    /// A node without children.
    pub(super) fn empty(origin: [f32; 3]) -> Self {
        Self {
            volumes: V::Eight::default(),
            origin,
            slack: 0.0,
            first_node: 0,
            first_triangle: 0,
            inner: 0,
            count: 0,
            paired: 0,
        }
    }

    /// Puts a volume into a place.
    pub(super) fn put(&mut self, place: usize, volume: &V) {
        volume.put(&mut self.volumes, place);
    }

    /// The volume in a place.
    #[inline(always)]
    pub(super) fn volume(&self, place: usize) -> V {
        V::get(&self.volumes, place)
    }

    /// The origin and the slack, mm, in a row.
    #[inline(always)]
    pub(super) const fn origin_and_slack(&self) -> [f32; FOUR] {
        let [x, y, z] = self.origin;
        [x, y, z, self.slack]
    }

    /// A bit for each child that is there.
    #[inline(always)]
    pub(super) const fn occupied(&self) -> u8 {
        ((1_u32 << self.count) - 1) as u8
    }

    /// The number of the child node in a place, if there is one.
    #[inline(always)]
    pub(super) const fn child(&self, place: usize) -> u32 {
        self.first_node + place as u32
    }

    /// The triangles of a child that is none.
    #[inline(always)]
    pub(super) const fn triangles(&self, place: u32) -> Triangles {
        let (leaf, paired) = (place - self.inner as u32, self.paired as u32);
        let pairs_before = if leaf < paired { leaf } else { paired };
        Triangles { first: self.first_triangle + leaf + pairs_before, is_pair: leaf < paired }
    }

    /// Whether the child in a place is a node.
    #[inline(always)]
    pub(super) const fn is_inner(&self, place: usize) -> bool {
        place < self.inner as usize
    }
}

/// A tree of volumes over one mesh, in the mesh's own frame.
#[derive(Clone, Debug)]
pub struct WideTree<V: WideVolume> {
    pub(super) nodes: Vec<Node<V>>,
    /// The triangles in tree order, as places in `vertices`.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The vertices in the order in which the triangles first use them, mm.
    pub(super) vertices: Vec<Point>,
    /// For each triangle in tree order, its face number in the mesh.
    pub(crate) faces: Vec<u32>,
    /// A ball around everything: centre and radius, mm.
    pub(super) ball: (Point, f64),
    /// The largest distance of a vertex from the mesh's own origin, mm.
    pub(super) reach: f64,
    /// The root's volume, if it is a box: decoded once, for what paths keep.
    pub(super) around: Option<Around>,
}

impl<V: WideVolume> WideTree<V> {
    /// Memory the tree holds, its triangles included, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice())
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.vertices.as_slice())
            + size_of_val(self.faces.as_slice())
    }

    /// How many triangles there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Never: a mesh has a triangle.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// The sum of both meshes' largest distances from their origins, mm.
    #[inline(always)]
    pub(super) const fn reach_with(&self, other: &Self) -> f64 {
        self.reach + other.reach
    }

    /// A triangle in tree order, mm.
    #[inline(always)]
    pub(crate) fn triangle(&self, place: u32) -> Triangle {
        Triangle { corners: self.triangles[place as usize].map(|vertex| self.vertices[vertex as usize]) }
    }

    /// The node that holds a slot's volume, and the place there.
    #[inline(always)]
    pub(super) fn slot(&self, slot: u32) -> (&Node<V>, usize) {
        (&self.nodes[slot as usize / WIDTH], slot as usize % WIDTH)
    }

    /// The number of the node that a slot's volume surrounds, or its triangles.
    #[inline(always)]
    pub(super) fn contents(&self, slot: u32) -> Contents {
        let (node, place) = self.slot(slot);
        if node.is_inner(place) {
            Contents::Node(node.child(place))
        } else {
            Contents::Triangles(node.triangles(place as u32))
        }
    }
}

/// What a slot's volume surrounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contents {
    /// A node, by its number.
    Node(u32),
    /// One triangle or two.
    Triangles(Triangles),
}

/// One triangle or two, by the place in tree order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Triangles {
    pub first: u32,
    pub is_pair: bool,
}

impl Triangles {
    /// The places.
    #[inline(always)]
    pub fn places(self) -> Range<u32> {
        self.first..self.first + 1 + u32::from(self.is_pair)
    }
}
