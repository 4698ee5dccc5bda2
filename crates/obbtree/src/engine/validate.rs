//! Whether a wide tree is well formed and its volumes hold their contents.

use super::node::{Contents, WideTree};
use super::volume::WideVolume;
use crate::engine::geometry::Triangle;
use std::fmt;

/// The first thing found wrong with a tree.
#[derive(Clone, Debug, PartialEq)]
pub enum TreeFault {
    /// Children do not divide their parent's triangles.
    Division {
        /// The parent.
        node: usize,
    },
    /// A face is missing or occurs twice.
    Faces,
    /// A corner is outside its node's volume.
    Outside {
        /// The node.
        node: usize,
        /// First coordinate of the corner, mm.
        x: f64,
        /// Second coordinate, mm.
        y: f64,
        /// Third coordinate, mm.
        z: f64,
    },
    /// A volume says something of itself that cannot be true.
    Misstated {
        /// The node.
        node: usize,
        /// What it says, and what is wrong with it.
        what: &'static str,
    },
}

impl fmt::Display for TreeFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Division { node } => write!(f, "node {node}: its children do not divide its triangles"),
            Self::Faces => f.write_str("the tree does not hold every face exactly once"),
            Self::Outside { node, x, y, z } => {
                write!(f, "node {node}: corner ({x}, {y}, {z}) mm lies outside its volume")
            }
            Self::Misstated { node, what } => write!(f, "node {node}: {what}"),
        }
    }
}

impl std::error::Error for TreeFault {}

impl<V: WideVolume> WideTree<V> {
    /// Checks that the nodes form a tree over all faces.
    ///
    /// # Errors
    /// The first [`TreeFault`] found.
    pub fn check_structure(&self) -> Result<(), TreeFault> {
        let mut seen = vec![false; self.len()];
        for &face in &self.faces {
            match seen.get_mut(face as usize) {
                Some(flag) if !*flag => *flag = true,
                _ => return Err(TreeFault::Faces),
            }
        }
        let mut met = vec![0_u32; self.nodes.len()];
        let mut held = vec![0_u32; self.len()];
        met[0] = 1;
        for (index, node) in self.nodes.iter().enumerate() {
            let (inner, count, paired) = (u32::from(node.inner), u32::from(node.count), u32::from(node.paired));
            let nodes = node.first_node as usize..(node.first_node + inner) as usize;
            let leaves = count.saturating_sub(inner);
            let triangles = node.first_triangle as usize..(node.first_triangle + leaves + paired) as usize;
            let least = if index == 0 { 1 } else { 2 };
            let (Some(nodes), Some(triangles)) = (met.get_mut(nodes), held.get_mut(triangles)) else {
                return Err(TreeFault::Division { node: index });
            };
            if inner > count || paired > leaves || count > 8 || count < least {
                return Err(TreeFault::Division { node: index });
            }
            nodes.iter_mut().chain(triangles).for_each(|times| *times += 1);
        }
        match met.iter().position(|&times| times != 1) {
            Some(node) => Err(TreeFault::Division { node }),
            None if held.iter().any(|&times| times != 1) => Err(TreeFault::Faces),
            None => Ok(()),
        }
    }

    /// Checks that every volume contains every corner of the triangles below it, within `slack_mm`.
    ///
    /// # Errors
    /// The first corner outside.
    pub fn check_containment(&self, slack_mm: f64) -> Result<(), TreeFault> {
        let mut ways = vec![Self::ROOT];
        self.check_below(&mut ways, slack_mm)
    }

    /// Checks the last volume of `ways`, the slots from the root down, and all below it: each corner against all volumes on the way.
    fn check_below(&self, ways: &mut Vec<u32>, slack_mm: f64) -> Result<(), TreeFault> {
        let Some(&slot) = ways.last() else { return Ok(()) };
        match self.contents(slot) {
            Contents::Triangles(triangles) => triangles.places().try_for_each(|place| {
                let triangle = self.triangle(place);
                ways.iter().try_for_each(|&slot| self.check_contains(slot, &triangle, slack_mm))
            }),
            Contents::Node(node) => (0..u32::from(self.nodes[node as usize].count)).try_for_each(|place| {
                ways.push(node * 8 + place);
                let result = self.check_below(ways, slack_mm);
                ways.pop();
                result
            }),
        }
    }

    fn check_contains(&self, slot: u32, triangle: &Triangle, slack_mm: f64) -> Result<(), TreeFault> {
        let volume = self.plain(slot);
        for p in &triangle.corners {
            if !volume.contains(p, slack_mm) {
                return Err(TreeFault::Outside { node: slot as usize / 8, x: p.x, y: p.y, z: p.z });
            }
        }
        Ok(())
    }
}
