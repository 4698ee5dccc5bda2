//! The one traversal of two trees; every query is a closure over it.

use super::Tree;
use crate::geometry::grid::Placement;
use crate::geometry::{Isometry, Triangle, intersect};
use crate::volume::BoundingVolume;
use std::ops::ControlFlow;

/// What a traversal reports of its work. [`NoProbe`] compiles to nothing, so timed queries pay nothing for it.
pub trait Probe {
    /// Two volumes were tested for overlap.
    fn volume_test(&mut self);
    /// Two triangles were tested for contact.
    fn triangle_test(&mut self);
}

/// Counts nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoProbe;

impl Probe for NoProbe {
    #[inline(always)]
    fn volume_test(&mut self) {}
    #[inline(always)]
    fn triangle_test(&mut self) {}
}

/// Operation counts of one query: the same on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Overlap tests between two volumes.
    pub volume_tests: u64,
    /// Contact tests between two triangles.
    pub triangle_tests: u64,
}

impl Probe for Counts {
    fn volume_test(&mut self) {
        self.volume_tests += 1;
    }
    fn triangle_test(&mut self) {
        self.triangle_tests += 1;
    }
}

/// Memory that queries reuse, so that a timed query does not allocate.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    stack: Vec<(u32, u32)>,
}

/// Visits every pair of triangles whose leaves' volumes overlap and calls `on_contact(face_of_a, face_of_b)` for those
/// that touch, until it breaks.
///
/// An explicit stack; a pair of nodes is tested before it is pushed; of two inner nodes the one with the larger
/// [`BoundingVolume::size`] is opened, the first on a tie.
pub fn traverse<V: BoundingVolume, B>(
    a: &Tree<V>,
    b: &Tree<V>,
    a_from_b: &Isometry,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
    mut on_contact: impl FnMut(u32, u32) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let pose = V::pose(a_from_b);
    let placement = Placement::new(a_from_b);
    let stack = &mut scratch.stack;
    stack.clear();
    probe.volume_test();
    if a.nodes[0].volume.overlaps(&b.nodes[0].volume, &pose) {
        stack.push((0, 0));
    }
    while let Some((i, j)) = stack.pop() {
        let (node_a, node_b) = (&a.nodes[i as usize], &b.nodes[j as usize]);
        let (children_a, children_b) = (node_a.children(), node_b.children());
        let next = match (children_a, children_b) {
            (None, None) => {
                leaf_pairs(a, node_a.range(), b, node_b.range(), &placement, probe, &mut on_contact)?;
                continue;
            }
            (Some((left, right)), None) => [(left, j), (right, j)],
            (None, Some((left, right))) => [(i, left), (i, right)],
            (Some((left, right)), Some(_)) if node_a.size >= node_b.size => [(left, j), (right, j)],
            (Some(_), Some((left, right))) => [(i, left), (i, right)],
        };
        for (i, j) in next {
            probe.volume_test();
            if a.nodes[i as usize].volume.overlaps(&b.nodes[j as usize].volume, &pose) {
                stack.push((i, j));
            }
        }
    }
    ControlFlow::Continue(())
}

/// Tests all pairs of two leaves' triangles.
#[inline]
fn leaf_pairs<V, B>(
    a: &Tree<V>,
    range_a: std::ops::Range<usize>,
    b: &Tree<V>,
    range_b: std::ops::Range<usize>,
    placement: &Placement,
    probe: &mut impl Probe,
    on_contact: &mut impl FnMut(u32, u32) -> ControlFlow<B>,
) -> ControlFlow<B> {
    for index_b in range_b {
        let moved: Triangle = placement.triangle(&b.triangles[index_b]);
        for index_a in range_a.clone() {
            probe.triangle_test();
            if intersect::touch(&a.triangles[index_a], &moved) {
                on_contact(a.faces[index_a], b.faces[index_b])?;
            }
        }
    }
    ControlFlow::Continue(())
}

/// Mode `first`: whether the meshes touch at all.
pub fn first<V: BoundingVolume>(
    a: &Tree<V>,
    b: &Tree<V>,
    a_from_b: &Isometry,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
) -> bool {
    traverse(a, b, a_from_b, scratch, probe, |_, _| ControlFlow::Break(())).is_break()
}

/// Mode `all`: every pair of faces that touch, appended to `contacts` as (face of `a`, face of `b`), in traversal order.
pub fn all<V: BoundingVolume>(
    a: &Tree<V>,
    b: &Tree<V>,
    a_from_b: &Isometry,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
    contacts: &mut Vec<(u32, u32)>,
) {
    let _ = traverse(a, b, a_from_b, scratch, probe, |face_a, face_b| {
        contacts.push((face_a, face_b));
        ControlFlow::<()>::Continue(())
    });
}
