//! Checks that a tree is well formed.

pub use obbtree::engine::validate::TreeFault;

use super::Tree;
use crate::geometry::triangle;
use crate::volume::{Shape, consistency};

impl<S> Tree<S> {
    /// Checks that the nodes form a tree over all faces.
    ///
    /// # Errors
    /// The first [`TreeFault`] found.
    pub fn check_structure(&self) -> Result<(), TreeFault> {
        let mut seen = vec![false; self.triangles.len()];
        for &face in &self.faces {
            match seen.get_mut(face as usize) {
                Some(flag) if !*flag => *flag = true,
                _ => return Err(TreeFault::Faces),
            }
        }
        for (index, node) in self.nodes.iter().enumerate() {
            let Some((left, right)) = node.children() else { continue };
            let (l, r) = (self.nodes[left as usize].range(), self.nodes[right as usize].range());
            let whole = node.range();
            if l.start != whole.start || l.end != r.start || r.end != whole.end || l.is_empty() || r.is_empty() {
                return Err(TreeFault::Division { node: index });
            }
        }
        Ok(())
    }
}

impl<S: Shape> Tree<S> {
    /// Checks that every node's volume contains every corner of the node's triangles, within `slack_mm`.
    ///
    /// # Errors
    /// The first corner outside.
    pub fn check_containment(&self, slack_mm: f64) -> Result<(), TreeFault> {
        for (index, node) in self.nodes.iter().enumerate() {
            let outside = triangle::corners(self.triangles_of(node)).find(|p| !node.volume.contains(p, slack_mm));
            if let Some(p) = outside {
                return Err(TreeFault::Outside { node: index, x: p.x, y: p.y, z: p.z });
            }
        }
        Ok(())
    }

    /// Checks that the size and geometry that each node's volume reports are consistent with its outline and contents.
    /// # Errors
    /// The first inconsistent volume.
    pub fn check_consistency(&self) -> Result<(), TreeFault> {
        let misstated =
            |node: usize| consistency::inconsistency(&self.nodes[node].volume, self.triangles_of(&self.nodes[node]));
        let first = (0..self.nodes.len()).find_map(|node| Some((node, misstated(node)?)));
        first.map_or(Ok(()), |(node, what)| Err(TreeFault::Misstated { node, what }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::{Policy, SplitRule};
    use crate::volume::BoundingVolume;
    use crate::volume::aabb::Aabb;
    use obbtree::cases::meshes;

    fn tree() -> Tree<<Aabb as BoundingVolume>::Shape> {
        Tree::build(&Aabb::fit, &meshes::cuboid(2.0, 3.0, 5.0).triangles(), Policy::own(SplitRule::Median))
    }

    #[test]
    fn a_built_tree_is_well_formed() {
        assert_eq!((tree().check_structure(), tree().check_containment(0.0)), (Ok(()), Ok(())));
    }

    #[test]
    fn a_face_twice_or_beyond_the_last_is_found() {
        let mut broken = tree();
        broken.faces[3] = broken.faces[4];
        assert_eq!(broken.check_structure(), Err(TreeFault::Faces));
        broken.faces[3] = 12;
        assert_eq!(broken.check_structure(), Err(TreeFault::Faces));
    }

    #[test]
    fn children_that_overlap_or_leave_something_out_are_found() {
        let mut broken = tree();
        broken.nodes[1].count -= 1;
        assert_eq!(broken.check_structure(), Err(TreeFault::Division { node: 0 }));
        let mut broken = tree();
        broken.nodes[2].first -= 1;
        assert_eq!(broken.check_structure(), Err(TreeFault::Division { node: 0 }));
    }

    #[test]
    fn a_volume_that_does_not_hold_its_triangles_is_found() {
        let mut broken = tree();
        broken.nodes[0].volume = broken.nodes[22].volume.clone(); // a leaf's
        assert!(matches!(broken.check_containment(0.0), Err(TreeFault::Outside { node: 0, .. })));
        assert_eq!(broken.check_containment(6.2), Ok(())); // the diagonal, √(4 + 9 + 25) = 6.16
    }
}
