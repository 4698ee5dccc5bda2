//! The one traversal of two trees; every query is a closure over it.

use super::{Node, Tree};
use crate::geometry::grid::Placement;
use crate::geometry::{Isometry, Triangle, certified};
use crate::volume::Shape;
pub use obbtree::engine::traverse::Counts;
use std::ops::ControlFlow;

/// Events that a traversal reports. [`NoProbe`] compiles to nothing, so timed queries pay nothing for it.
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

impl Probe for Counts {
    fn volume_test(&mut self) {
        self.volume_tests += 1;
    }
    fn triangle_test(&mut self) {
        self.triangle_tests += 1;
    }
}

/// Buffers that queries reuse, so that a timed query does not allocate.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    stack: Vec<(u32, u32)>,
}

/// Visits every pair of triangles in leaves with overlapping volumes. Calls `on_contact(face_of_a, face_of_b)` for the pairs that touch,
/// until it breaks.
///
/// Uses an explicit stack, and tests a pair of nodes before pushing it. Of two inner nodes, the one with the larger [`Shape::size`] is
/// opened; on a tie, the first.
pub fn traverse<S: Shape, B>(
    a: &Tree<S>,
    b: &Tree<S>,
    a_from_b: &Isometry,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
    mut on_contact: impl FnMut(u32, u32) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let pose = S::pose(a_from_b);
    let placement = Placement::new(a_from_b);
    let overlap = |node_a: &Node<S>, node_b: &Node<S>| node_a.volume.overlaps(&node_b.volume, &pose);
    let stack = &mut scratch.stack;
    stack.clear();
    probe.volume_test();
    if overlap(&a.nodes[0], &b.nodes[0]) {
        stack.push((0, 0));
    }
    while let Some((i, j)) = stack.pop() {
        let (node_a, node_b) = (&a.nodes[i as usize], &b.nodes[j as usize]);
        let Some(next) = open(node_a, node_b, (i, j)) else {
            leaf_pairs(a, node_a.range(), b, node_b.range(), &placement, probe, &mut on_contact)?;
            continue;
        };
        let [(i1, j1), (i2, j2)] = next;
        let (one, other) = if j1 == j2 {
            // With nothing written in between and one `node_b` for both, the compiler moves it to the pose once.
            (overlap(&a.nodes[i1 as usize], node_b), overlap(&a.nodes[i2 as usize], node_b))
        } else {
            (overlap(node_a, &b.nodes[j1 as usize]), overlap(node_a, &b.nodes[j2 as usize]))
        };
        for (pair, touching) in next.into_iter().zip([one, other]) {
            probe.volume_test();
            if touching {
                stack.push(pair);
            }
        }
    }
    ControlFlow::Continue(())
}

/// The two pairs that replace the pair of nodes `at` when the larger node is opened; `None` for two leaves.
#[inline(always)]
pub(super) fn open<S>(node_a: &Node<S>, node_b: &Node<S>, at: (u32, u32)) -> Option<[(u32, u32); 2]> {
    let (i, j) = at;
    match (node_a.children(), node_b.children()) {
        (None, None) => None,
        (Some((left, right)), None) => Some([(left, j), (right, j)]),
        (None, Some((left, right))) => Some([(i, left), (i, right)]),
        (Some((left, right)), Some(_)) if node_a.size >= node_b.size => Some([(left, j), (right, j)]),
        (Some(_), Some((left, right))) => Some([(i, left), (i, right)]),
    }
}

/// Tests all pairs of two leaves' triangles.
#[inline]
fn leaf_pairs<S, B>(
    a: &Tree<S>,
    range_a: std::ops::Range<usize>,
    b: &Tree<S>,
    range_b: std::ops::Range<usize>,
    placement: &Placement,
    probe: &mut impl Probe,
    on_contact: &mut impl FnMut(u32, u32) -> ControlFlow<B>,
) -> ControlFlow<B> {
    for index_b in range_b {
        let moved: Triangle = placement.triangle(&b.triangles[index_b]);
        for index_a in range_a.clone() {
            probe.triangle_test();
            if certified::touch(&a.triangles[index_a], &moved) {
                on_contact(a.faces[index_a], b.faces[index_b])?;
            }
        }
    }
    ControlFlow::Continue(())
}

/// Mode `first`: whether the meshes touch at all.
pub fn first<S: Shape>(
    a: &Tree<S>,
    b: &Tree<S>,
    a_from_b: &Isometry,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
) -> bool {
    traverse(a, b, a_from_b, scratch, probe, |_, _| ControlFlow::Break(())).is_break()
}

/// Mode `all`: every pair of faces that touch, appended to `contacts` as (face of `a`, face of `b`), in traversal order.
pub fn all<S: Shape>(
    a: &Tree<S>,
    b: &Tree<S>,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::{Policy, SplitRule};
    use crate::volume::BoundingVolume;
    use crate::volume::aabb::Aabb;
    use obbtree::cases::{self, meshes};

    fn tree(triangles: &[Triangle]) -> Tree<<Aabb as BoundingVolume>::Shape> {
        Tree::build(&Aabb::fit, triangles, Policy::own(SplitRule::Median))
    }

    fn counted(
        a: &Tree<<Aabb as BoundingVolume>::Shape>,
        b: &Tree<<Aabb as BoundingVolume>::Shape>,
        pose: &Isometry,
    ) -> (bool, Counts) {
        let mut counts = Counts::default();
        (first(a, b, pose, &mut Scratch::default(), &mut counts), counts)
    }

    #[test]
    fn roots_apart_cost_one_test() {
        let cube = tree(&meshes::cuboid(2.0, 2.0, 2.0).triangles());
        let (touching, counts) = counted(&cube, &cube, &Isometry::translation(2.1, 0.0, 0.0));
        assert_eq!((touching, counts), (false, Counts { volume_tests: 1, triangle_tests: 0 }));
    }

    #[test]
    fn two_single_triangles_cost_one_test_each() {
        let one = tree(&meshes::cuboid(2.0, 2.0, 2.0).triangles()[..1]);
        let (touching, counts) = counted(&one, &one, &Isometry::identity());
        assert_eq!((touching, counts), (true, Counts { volume_tests: 1, triangle_tests: 1 }));
    }

    #[test]
    fn the_larger_node_is_opened_first() {
        // A large row of two triangles against a small one of two, both in the plane z = 0: the root test, then the large row's
        // two halves against the small root. The small row lies at the right half only, and touches nothing: 4 tests of
        // volumes (root, left, right, and the small row's two halves make 5), then its triangles.
        let row = |pitch: f64| {
            let triangle = |x: f64| Triangle {
                corners: [[x, 0.0, 0.0], [x + pitch, 0.0, 0.0], [x, pitch, 0.0]].map(crate::geometry::Point::from),
            };
            tree(&[triangle(0.0), triangle(10.0 * pitch)])
        };
        let (large, small) = (row(1.0), row(0.01));
        let pose = Isometry::translation(10.2, 0.2, 0.0);
        let (touching, counts) = counted(&large, &small, &pose);
        assert_eq!((touching, counts.triangle_tests), (true, 1));
        assert_eq!(counts.volume_tests, 5); // roots; large left, large right; small left, small right
        assert_eq!(counted(&small, &large, &pose.inverse()).1.volume_tests, 5);
    }

    #[test]
    fn of_two_nodes_the_larger_is_opened_and_of_equal_ones_the_first() {
        let cuboid = |size: f64| tree(&meshes::cuboid(size, size, size).triangles());
        let (large, small) = (cuboid(2.0), cuboid(1.0));
        let Some((left, right)) = large.nodes[0].children() else { panic!("a leaf") };
        assert_eq!(open(&large.nodes[0], &small.nodes[0], (0, 7)), Some([(left, 7), (right, 7)]));
        assert_eq!(open(&small.nodes[0], &large.nodes[0], (7, 0)), Some([(7, left), (7, right)]));
        assert_eq!(open(&large.nodes[0], &large.nodes[0], (0, 7)), Some([(left, 7), (right, 7)]));
        // A leaf cannot be opened, however large.
        let leaf = tree(&meshes::cuboid(9.0, 9.0, 9.0).triangles()[..1]);
        assert_eq!(open(&leaf.nodes[0], &large.nodes[0], (7, 0)), Some([(7, left), (7, right)]));
        assert_eq!(open(&leaf.nodes[0], &leaf.nodes[0], (0, 0)), None);
    }

    #[test]
    fn a_tree_with_other_volumes_is_the_same_tree() {
        let torus = tree(&meshes::torus(12.0, 4.0, 14, 7).triangles());
        let numbered = torus.with_volumes(|volume| Some(volume.size())).unwrap();
        assert_eq!(numbered.nodes().len(), torus.nodes().len());
        for (number, node) in numbered.nodes().iter().zip(torus.nodes()) {
            assert_eq!((number.volume, number.children()), (node.volume.size(), node.children()));
        }
        let smallest = torus.nodes().iter().map(|node| node.size).fold(f64::INFINITY, f64::min);
        assert!(torus.with_volumes(|volume| (volume.size() > smallest).then_some(())).is_none());
    }

    #[test]
    fn counting_changes_no_answer_and_all_lists_every_contact_once() {
        let triangles = meshes::torus(12.0, 4.0, 14, 7).triangles();
        let torus = tree(&triangles);
        let mut scratch = Scratch::default();
        for step in 0..12 {
            let pose = Isometry::new(
                nalgebra::Vector3::new(2.6 * f64::from(step), 1.0, 0.3),
                nalgebra::Vector3::new(0.3, 0.1, 0.2),
            );
            let expected = cases::contacts(&triangles, &triangles, &pose);
            let silent = first(&torus, &torus, &pose, &mut scratch, &mut NoProbe);
            assert_eq!(silent, counted(&torus, &torus, &pose).0);
            assert_eq!(silent, !expected.is_empty());
            let mut contacts = Vec::new();
            all(&torus, &torus, &pose, &mut scratch, &mut NoProbe, &mut contacts);
            contacts.sort_unstable();
            assert_eq!(contacts, expected);
        }
    }

    #[test]
    fn a_query_may_stop_at_any_contact() {
        let cube = tree(&meshes::cuboid(2.0, 2.0, 2.0).triangles());
        let mut seen = 0;
        let stopped = traverse(&cube, &cube, &Isometry::identity(), &mut Scratch::default(), &mut NoProbe, |_, _| {
            seen += 1;
            if seen == 3 { ControlFlow::Break(seen) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(stopped, ControlFlow::Break(3));
    }
}
