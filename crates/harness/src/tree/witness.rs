//! Whether a query would find a known contact.
//!
//! [`traverse::first`](super::traverse::first) opens pairs of nodes by a rule that does not depend on earlier results. Exactly one chain of
//! node pairs therefore leads from the roots to the leaves of two given triangles. If all pairs of the chain overlap, the query reaches
//! that contact, or stops earlier at another one. When the ground truth has named a contact, this verdict takes one test per level of the
//! trees; the query itself may take a hundred thousand.

use super::Tree;
use super::traverse::open;
use crate::geometry::Isometry;
use crate::volume::Shape;

/// Position of each face of a mesh in the order of a tree's triangles.
#[derive(Clone, Debug)]
pub struct Places(Vec<u32>);

impl Places {
    /// The positions of the faces in `tree`.
    pub fn of<S>(tree: &Tree<S>) -> Self {
        let mut places = vec![0; tree.faces.len()];
        for (&face, place) in tree.faces.iter().zip(0..) {
            places[face as usize] = place;
        }
        Self(places)
    }
}

/// Whether all pairs of volumes overlap on the chain that leads to the pair of faces `witness`, (face of `a`, face of `b`). If they do, and
/// the two triangles touch, [`traverse::first`](super::traverse::first) answers that the meshes touch. If not, that query may still find
/// another contact.
pub fn reached<S: Shape>(
    a: (&Tree<S>, &Places),
    b: (&Tree<S>, &Places),
    a_from_b: &Isometry,
    witness: (u32, u32),
) -> bool {
    let pose = S::pose(a_from_b);
    let place_a = a.1.0[witness.0 as usize] as usize;
    let place_b = b.1.0[witness.1 as usize] as usize;
    let mut at = (0, 0);
    loop {
        let (node_a, node_b) = (&a.0.nodes[at.0 as usize], &b.0.nodes[at.1 as usize]);
        if !node_a.volume.overlaps(&node_b.volume, &pose) {
            return false;
        }
        let Some(next) = open(node_a, node_b, at) else { return true };
        let holds = |(i, j): (u32, u32)| {
            a.0.nodes[i as usize].range().contains(&place_a) && b.0.nodes[j as usize].range().contains(&place_b)
        };
        at = if holds(next[0]) { next[0] } else { next[1] };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::traverse::{self, NoProbe, Scratch};
    use crate::tree::{Policy, SplitRule};
    use crate::volume::BoundingVolume;
    use crate::volume::aabb::Aabb;
    use crate::volume::obb_vertex_centroid::ObbVertexCentroid;
    use nalgebra::Vector3;
    use obbtree::cases::{self, meshes};

    /// Compares `reached` with the query over all contacts of many poses: a reached contact implies that the query answers yes, and a query
    /// that answers yes implies that some contact is reached. Returns the number of contacts that were not reached.
    fn agrees_with_the_query<V: BoundingVolume>(policy: Policy) -> usize {
        let triangles = meshes::stepped_tool(8, 4).triangles();
        let tree = Tree::build(&V::fit, &triangles, policy);
        let places = Places::of(&tree);
        let mut unreached = 0;
        for step in 0..40 {
            let shift = Vector3::new(0.7 * f64::from(step), 0.4, 0.3);
            let pose = Isometry::new(shift, Vector3::new(0.3, 0.1, 0.2));
            let contacts = cases::contacts(&triangles, &triangles, &pose);
            let reached = contacts.iter().filter(|&&at| reached((&tree, &places), (&tree, &places), &pose, at)).count();
            let answer = traverse::first(&tree, &tree, &pose, &mut Scratch::default(), &mut NoProbe);
            assert_eq!(answer, reached > 0, "step {step}");
            unreached += contacts.len() - reached;
        }
        unreached
    }

    #[test]
    fn a_safe_volume_reaches_every_contact_and_the_query_says_so() {
        for leaf in [1, 3] {
            let policy = Policy { leaf, ..Policy::own(SplitRule::VertexMean) };
            assert_eq!(agrees_with_the_query::<Aabb>(policy), 0);
        }
    }

    #[test]
    fn a_box_that_has_drifted_does_not_reach_all_and_the_query_still_agrees() {
        assert!(agrees_with_the_query::<ObbVertexCentroid>(Policy::own(SplitRule::VertexMean)) > 0);
    }
}
