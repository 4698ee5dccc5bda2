//! Do the surfaces touch?
//!
//! All pairs of triangles are candidates whose coordinate intervals overlap in the frame of `a`, after the vertices of `b`
//! have been moved and snapped. Groups of pairs are discarded by boxes that provably hold their contents, so no pair with
//! overlapping intervals is ever lost: the answers are those of testing all pairs.

use super::boxes::Bounds;
use super::{PairOracle, Posed};
use crate::geometry::{Isometry, Triangle, exact, intersect};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// What is true of a pair at a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    /// Whether the surfaces share a point; exact, for the snapped vertices.
    pub exact: bool,
    /// Whether the fast triangle test says so for any candidate pair of triangles; no volume is involved.
    pub brute: bool,
    /// Whether the surfaces are apart and part of one solid lies wholly inside the other. Exact. A mesh that is not
    /// watertight contains nothing.
    pub contained: bool,
}

/// Everything known about a pair at a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// Whether the surfaces touch, and how they lie when they do not.
    pub verdict: Verdict,
    /// Distance between the surfaces, mm; 0 when they touch, infinite when it is beyond the cut-off that was asked for.
    pub clearance_mm: f64,
    /// Travel past first contact, mm, where somebody has found it ([`super::path_depths`], or the workload).
    pub depth_mm: Option<f64>,
}

/// Poses per unit of parallel work.
const CHUNK: usize = 32;

/// Judges every pose, in parallel and in order; `depth_mm` is left empty. Clearances beyond `beyond_mm` are infinite.
/// `progress` is called now and then, from any thread, with the number of poses done since it was last called.
///
/// The result does not depend on the number of threads.
pub fn judge_all(
    oracle: &PairOracle,
    poses: &[Isometry],
    beyond_mm: f64,
    progress: &(dyn Fn(u64) + Sync),
) -> Vec<Judgement> {
    let judge = |pose: &Isometry| {
        let verdict = oracle.judge(pose);
        let clearance_mm = if verdict.exact { 0.0 } else { oracle.clearance_of_free_mm(pose, beyond_mm) };
        Judgement { verdict, clearance_mm, depth_mm: None }
    };
    let chunks: Vec<Vec<Judgement>> = poses
        .par_chunks(CHUNK)
        .map(|chunk| {
            let judged = chunk.iter().map(judge).collect();
            progress(chunk.len() as u64);
            judged
        })
        .collect();
    chunks.concat()
}

impl PairOracle {
    /// All verdicts about one pose.
    #[must_use]
    pub fn judge(&self, a_from_b: &Isometry) -> Verdict {
        let posed = self.posed(a_from_b);
        let (mut exact, mut brute) = (false, false);
        let _ = self.candidates(&posed, |a, b| {
            brute = brute || intersect::touch(a, b);
            exact = exact || exact::touch(a, b);
            if exact && brute { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        Verdict { exact, brute, contained: !exact && self.contained(&posed) }
    }

    /// Whether the surfaces share a point; exact, for the snapped vertices.
    #[must_use]
    pub fn touches(&self, a_from_b: &Isometry) -> bool {
        self.candidates(&self.posed(a_from_b), |a, b| {
            if exact::touch(a, b) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .is_break()
    }

    /// Calls `visit` with every pair of triangles (of `a`; of `b`, placed) whose boxes overlap, until it breaks.
    fn candidates(
        &self,
        posed: &Posed,
        mut visit: impl FnMut(&Triangle, &Triangle) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (a, b) = (&self.a.tree, &self.b.tree);
        let mut stack = vec![(0, 0, posed.mover.bounds(self.b.bounds()))];
        while let Some((i, j, moved)) = stack.pop() {
            if !a.nodes[i as usize].bounds.overlap(&moved) {
                continue;
            }
            match (a.children(i), b.children(j)) {
                (_, None) => self.leaf_candidates(posed, i, j, &mut visit)?,
                (Some(children), Some(_)) if a.size(i) > b.size(j) => {
                    stack.extend(children.map(|child| (child, j, moved)));
                }
                (_, Some(children)) => {
                    stack.extend(children.map(|child| (i, child, posed.mover.bounds(&b.nodes[child as usize].bounds))));
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Places the triangles of leaf `j` of `b`, and visits the triangles of `a` below node `i` whose boxes they overlap.
    fn leaf_candidates(
        &self,
        posed: &Posed,
        i: u32,
        j: u32,
        visit: &mut impl FnMut(&Triangle, &Triangle) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let a = &self.a.tree;
        for triangle in &self.b.tree.triangles[self.b.tree.range(j)] {
            let placed = posed.placement.triangle(triangle);
            let bounds = Bounds::of(&placed);
            // A path through the halving tree leaves at most one sibling per level behind.
            let (mut stack, mut height) = ([0; 40], 1);
            stack[0] = i;
            while height > 0 {
                height -= 1;
                let node = stack[height];
                if !a.nodes[node as usize].bounds.overlap(&bounds) {
                    continue;
                }
                if let Some([left, right]) = a.children(node) {
                    (stack[height], stack[height + 1]) = (right, left);
                    height += 2;
                    continue;
                }
                for index in a.range(node) {
                    if a.bounds[index].overlap(&bounds) {
                        visit(&a.triangles[index], &placed)?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}
