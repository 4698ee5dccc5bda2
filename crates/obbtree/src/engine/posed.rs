//! Two trees at a pose: which volume of a pair is opened, and how the other looks from its node.

use super::buckets::Waiting;
use super::node::{Contents, WIDTH, WideTree};
use super::pose::Pose;
use super::visit::Visit;
use super::volume::WideVolume;
use crate::engine::geometry::grid::Placement;
use crate::engine::geometry::{Isometry, rigid};
use std::hint::select_unpredictable;

/// The trees, and the constants of the pose.
pub(super) struct Posed<'a, V: WideVolume> {
    pub a: &'a WideTree<V>,
    pub b: &'a WideTree<V>,
    pub placement: Placement,
    pose: Pose,
}

/// What is opened in a visit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Opened {
    /// The slot that stays as it is.
    pub one: u32,
    /// The node whose children are tested against it.
    pub node: u32,
    /// Whether that node is of `b`.
    pub of_b: bool,
}

impl Opened {
    /// The pair (slot of `a`, slot of `b`) of the volume that stays and a slot of the other tree.
    #[inline(always)]
    pub const fn pair(self, slot: u32) -> (u32, u32) {
        if self.of_b { (self.one, slot) } else { (slot, self.one) }
    }
}

/// The pairs of the one volume of a visit and each child.
#[derive(Clone, Copy, Debug)]
pub(super) struct Below {
    opened: Opened,
    one: Contents,
    /// A bit for each child that stays while the one volume's node is opened.
    stay: u8,
    /// A bit for each child that is a node.
    inner: u8,
    first_node: u32,
}

impl Below {
    /// What is next of the pair with the child in a place.
    #[inline(always)]
    pub fn at(&self, place: u32) -> Waiting {
        let Self { opened, one, .. } = *self;
        let (stays, is_node) = (self.stay >> place & 1 != 0, self.inner >> place & 1 != 0);
        let slot = opened.node * WIDTH as u32 + place;
        match one {
            Contents::Triangles(_) if !is_node => Waiting::Leaves(opened.pair(slot)),
            Contents::Node(below) => Waiting::Node(Opened {
                one: select_unpredictable(stays, slot, opened.one),
                node: select_unpredictable(stays, below, self.first_node + place),
                of_b: opened.of_b ^ stays,
            }),
            Contents::Triangles(_) => Waiting::Node(Opened { node: self.first_node + place, ..opened }),
        }
    }
}

impl<'a, V: WideVolume> Posed<'a, V> {
    /// The quaternion may have any length: volumes are moved as the leaves are.
    #[inline]
    pub fn new(a: &'a WideTree<V>, b: &'a WideTree<V>, a_from_b: &Isometry) -> Self {
        let unit = (!rigid::is_unit(a_from_b)).then(|| rigid::rigid(a_from_b));
        let a_from_b = unit.as_ref().unwrap_or(a_from_b);
        let rotation = a_from_b.rotation.to_rotation_matrix().into_inner();
        let pose = Pose::of(a_from_b, rotation.into(), a.reach_with(b));
        Self { a, b, placement: Placement::of(rotation, a_from_b.translation.vector), pose }
    }

    /// The tree that is opened, and the other one.
    #[inline(always)]
    pub const fn trees(&self, opened: Opened) -> (&'a WideTree<V>, &'a WideTree<V>) {
        if opened.of_b { (self.b, self.a) } else { (self.a, self.b) }
    }

    /// What a search opens first: the larger root, the second on a tie, and never one that is triangles, since a pass over the children tells as much as
    /// one over the root alone and costs the same. Where both are triangles, the node that holds the second, whose number is that of its first child.
    #[inline(always)]
    pub fn first(&self) -> Opened {
        let (a, b) = (&self.a.nodes[0], &self.b.nodes[0]);
        let is_larger = a.volume(0).size() > b.volume(0).size();
        let of_a = a.is_inner(0) & (is_larger | !b.is_inner(0));
        // Which one it is cannot be foreseen: both are worked out, and one is taken without a jump.
        Opened { one: 0, node: select_unpredictable(of_a, a.child(0), b.child(0)), of_b: !of_a }
    }

    /// What is below a visit: `larger` has a bit for each child that is larger than the one volume. Of two volumes the larger is opened, never a
    /// triangle's.
    #[inline(always)]
    pub fn below(&self, opened: Opened, larger: u8) -> Below {
        let (tree, other) = self.trees(opened);
        let node = &tree.nodes[opened.node as usize];
        let inner = ((1_u32 << node.inner) - 1) as u8;
        let one = other.contents(opened.one);
        let stay = if let Contents::Node(_) = one { !(larger & inner) } else { 0 };
        Below { opened, one, stay, inner, first_node: node.first_node }
    }

    /// The pairs of triangles, by their places, of two volumes without nodes.
    pub fn pairs(&self, (x, y): (u32, u32)) -> impl Iterator<Item = (u32, u32)> + use<V> {
        let places = |tree: &WideTree<V>, slot| match tree.contents(slot) {
            Contents::Triangles(triangles) => triangles.places(),
            Contents::Node(_) => 0..0,
        };
        let (of_a, of_b) = (places(self.a, x), places(self.b, y));
        of_a.flat_map(move |i| of_b.clone().map(move |j| (i, j)))
    }

    /// The visit of a node.
    #[inline(always)]
    pub fn see(&self, opened: Opened) -> Visit<'_, V> {
        let (tree, other) = self.trees(opened);
        let motion = if opened.of_b { &self.pose.b_from_a } else { &self.pose.a_from_b };
        let (holder, place) = other.slot(opened.one);
        Visit { node: &tree.nodes[opened.node as usize], holder, place, motion, slack: self.pose.slack }
    }
}
