//! Whether two surfaces touch.
//!
//! A pair of triangles is a candidate when the coordinate intervals overlap in the frame of `a`, after the vertices of `b` were moved and
//! snapped. Groups of pairs are discarded by boxes that provably contain their triangles, so no candidate is ever lost: the verdicts equal
//! those of testing all pairs.

use super::boxes::{Bounds, Memo};
use super::clearance::{Nearest, Sought};
use super::{PairOracle, Posed};
use crate::geometry::grid::Placement;
use crate::geometry::plane::Plane;
use crate::geometry::{Isometry, Triangle, certified};
use rayon::prelude::*;
use std::ops::ControlFlow;

/// The exact verdict on a pair at a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    /// The first candidate pair of triangles that share a point, (face of `a`, face of `b`). Exact for the snapped vertices, and
    /// independent of any bounding volume.
    pub witness: Option<(u32, u32)>,
    /// Whether the surfaces are disjoint and part of one solid lies wholly inside the other. Exact. A mesh that is not watertight contains
    /// nothing.
    pub contained: bool,
}

impl Verdict {
    /// Whether the surfaces share a point; exact, for the snapped vertices.
    pub const fn touches(&self) -> bool {
        self.witness.is_some()
    }

    /// Whether the solids share a point: the surfaces do, or one solid lies wholly inside the other.
    pub const fn collides(&self) -> bool {
        self.touches() || self.contained
    }
}

/// The verdict, clearance and depth of a pair at a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// The verdict: whether the surfaces touch or one contains the other.
    pub verdict: Verdict,
    /// Distance between the surfaces, mm; 0 when they touch, infinite when it exceeds the cut-off.
    pub clearance_mm: f64,
    /// Travel past first contact, mm; `None` until [`super::path_depths`] or the workload provides it.
    pub depth_mm: Option<f64>,
}

/// Poses per unit of parallel work.
const CHUNK: usize = 32;

/// Judges every pose, in parallel; the results are in order, and `depth_mm` is left empty. Clearances have the accuracy of `sought`, and
/// are infinite beyond its cut-off. `progress` is called occasionally, from any thread, with the number of poses finished since its last
/// call.
///
/// The result does not depend on the number of threads.
pub fn judge_all(
    oracle: &PairOracle,
    poses: &[Isometry],
    sought: &Sought,
    progress: &(dyn Fn(u64) + Sync),
) -> Vec<Judgement> {
    let judge = |pose: &Isometry, nearest: &mut Nearest| {
        let verdict = oracle.judge(pose);
        let clearance_mm = if verdict.touches() { 0.0 } else { oracle.clearance_of_free_mm(pose, sought, nearest) };
        Judgement { verdict, clearance_mm, depth_mm: None }
    };
    let chunks: Vec<Vec<Judgement>> = poses
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut nearest = None;
            let judged = chunk.iter().map(|pose| judge(pose, &mut nearest)).collect();
            progress(chunk.len() as u64);
            judged
        })
        .collect();
    chunks.concat()
}

/// A triangle of `b`, in the frame of `a`, on the grid.
struct Placed {
    triangle: Triangle,
    bounds: Bounds,
    plane: Plane,
}

impl Placed {
    fn new(placement: &Placement, triangle: &Triangle) -> Self {
        let triangle = placement.triangle(triangle);
        Self { triangle, bounds: Bounds::of(&triangle), plane: Plane::of(&triangle) }
    }
}

/// A pair of triangles whose boxes overlap.
struct Candidate<'c> {
    a: &'c Triangle,
    /// The plane of `a`.
    plane: &'c Plane,
    b: &'c Placed,
    /// Face numbers in the two meshes.
    faces: (u32, u32),
}

impl Candidate<'_> {
    /// Whether the two triangles touch; exact.
    #[inline(always)]
    fn touches(&self) -> bool {
        certified::touch_by_planes((self.a, self.plane), (&self.b.triangle, &self.b.plane))
    }
}

impl PairOracle {
    /// The verdict at one pose.
    pub fn judge(&self, a_from_b: &Isometry) -> Verdict {
        let posed = self.posed(a_from_b);
        let witness = self.witness(&posed);
        Verdict { witness, contained: witness.is_none() && self.contained(&posed) }
    }

    /// Whether the surfaces share a point; exact, for the snapped vertices.
    pub fn touches(&self, a_from_b: &Isometry) -> bool {
        self.witness(&self.posed(a_from_b)).is_some()
    }

    /// The first candidate pair that touches.
    fn witness(&self, posed: &Posed) -> Option<(u32, u32)> {
        let found = self.candidates(posed, |pair| {
            if pair.touches() { ControlFlow::Break(pair.faces) } else { ControlFlow::Continue(()) }
        });
        found.break_value()
    }

    /// How many pairs of triangles share a point; exact, for the snapped vertices.
    pub fn touching_pairs(&self, a_from_b: &Isometry) -> u64 {
        let mut pairs = 0;
        let _ = self.candidates(&self.posed(a_from_b), |pair| {
            pairs += u64::from(pair.touches());
            ControlFlow::<()>::Continue(())
        });
        pairs
    }

    /// Calls `visit` with every pair of triangles whose boxes overlap, until it breaks.
    fn candidates<B>(&self, posed: &Posed, mut visit: impl FnMut(&Candidate) -> ControlFlow<B>) -> ControlFlow<B> {
        let (a, b) = (&self.a.tree, &self.b.tree);
        let (mut moved, mut placed) = (Memo::new(b), Memo::new(b));
        let mut stack = vec![(0, 0)];
        while let Some((i, j)) = stack.pop() {
            let bounds = &moved.of(j, 1, |_| posed.mover.bounds(&b.nodes[j as usize].bounds))[0];
            if !a.nodes[i as usize].bounds.overlap(bounds) {
                continue;
            }
            match (a.children(i), b.children(j)) {
                (_, None) => {
                    let range = b.range(j);
                    let place = |k| Placed::new(&posed.placement, &b.triangles[range.start + k]);
                    for (placed, index) in placed.of(j, range.len(), place).iter().zip(range.clone()) {
                        self.candidates_of(placed, b.faces[index], i, &mut visit)?;
                    }
                }
                (Some([left, right]), Some(_)) if a.size(i) > b.size(j) => stack.extend([(left, j), (right, j)]),
                (_, Some([left, right])) => stack.extend([(i, left), (i, right)]),
            }
        }
        ControlFlow::Continue(())
    }

    /// Visits the triangles of `a` below node `i` whose boxes overlap that of a triangle of `b`.
    fn candidates_of<B>(
        &self,
        of_b: &Placed,
        face_b: u32,
        i: u32,
        visit: &mut impl FnMut(&Candidate) -> ControlFlow<B>,
    ) -> ControlFlow<B> {
        let a = &self.a.tree;
        // A path through the halving tree leaves at most one sibling per level behind.
        let (mut stack, mut height) = ([0; 40], 1);
        stack[0] = i;
        while height > 0 {
            height -= 1;
            let node = stack[height];
            if !a.nodes[node as usize].bounds.overlap(&of_b.bounds) {
                continue;
            }
            if let Some([left, right]) = a.children(node) {
                (stack[height], stack[height + 1]) = (right, left);
                height += 2;
                continue;
            }
            for index in a.range(node) {
                if a.bounds[index].overlap(&of_b.bounds) {
                    let plane = &self.planes[index];
                    visit(&Candidate { a: &a.triangles[index], plane, b: of_b, faces: (a.faces[index], face_b) })?;
                }
            }
        }
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::solids;
    use super::*;
    use crate::geometry::{Mesh, Vector, exact};
    use proptest::prelude::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn block_on_block() -> PairOracle {
        PairOracle::new(Arc::new(solids::block(4.0, 4.0, 4.0)), Arc::new(solids::block(2.0, 2.0, 2.0)))
    }

    /// Touches, contained.
    type Answers = (bool, bool);

    fn answers(verdict: Verdict) -> Answers {
        (verdict.touches(), verdict.contained)
    }

    #[test]
    fn blocks_touch_until_they_are_a_step_apart() {
        let step = crate::geometry::grid::STEP_MM;
        for (x, expected) in [
            (0.0, (false, true)),
            (1.0, (true, false)),
            (2.0, (true, false)),
            (3.0, (true, false)),
            (3.0 + step, (false, false)),
            (1.0 - step, (false, true)),
            (50.0, (false, false)),
        ] {
            let pose = Isometry::translation(x, 0.25, 0.5);
            assert_eq!(answers(block_on_block().judge(&pose)), expected, "x = {x}");
            assert_eq!(block_on_block().touches(&pose), expected.0, "x = {x}");
        }
    }

    /// Number of touching pairs among all pairs of triangles, found without boxes or error bounds.
    fn by_all_pairs(a: &Mesh, b: &Mesh, pose: &Isometry) -> u64 {
        let placement = Placement::new(pose);
        let moved: Vec<Triangle> = b.triangles().iter().map(|t| placement.triangle(t)).collect();
        a.triangles().iter().map(|t| moved.iter().filter(|other| exact::touch(t, other)).count() as u64).sum()
    }

    fn pose_of(turn: [f64; 3], shift: [f64; 3]) -> Isometry {
        Isometry::new(Vector::from(shift), Vector::from(turn))
    }

    proptest! {
        #[test]
        fn boxes_change_nothing(
            turn in prop::array::uniform3(-3.0..3.0f64),
            shift in prop::array::uniform3(-14.0..14.0f64),
            which in 0..3usize,
        ) {
            let (a, b) = match which {
                0 => (solids::torus(8.0, 2.0, 16, 8), solids::torus(6.0, 1.5, 16, 8)),
                1 => (solids::torus(8.0, 2.0, 16, 8), solids::ball(3.0, 6)),
                _ => (solids::block(9.0, 5.0, 3.0), solids::torus(6.0, 1.5, 16, 8)),
            };
            let pose = pose_of(turn, shift);
            let oracle = PairOracle::new(Arc::new(a.clone()), Arc::new(b.clone()));
            let verdict = oracle.judge(&pose);
            let touching = by_all_pairs(&a, &b, &pose);
            prop_assert_eq!(verdict.touches(), touching > 0);
            prop_assert_eq!(oracle.touching_pairs(&pose), touching);
            if let Some((face_a, face_b)) = verdict.witness {
                let moved = Placement::new(&pose).triangle(&b.triangles()[face_b as usize]);
                prop_assert!(exact::touch(&a.triangles()[face_a as usize], &moved));
            }
            prop_assert_eq!(oracle.touches(&pose), verdict.touches());
            let clearance = oracle.clearance_mm(&pose, f64::INFINITY);
            prop_assert_eq!(clearance == 0.0, verdict.touches());
            let cut_off = if clearance <= 0.5 { clearance } else { f64::INFINITY };
            prop_assert_eq!(oracle.clearance_mm(&pose, 0.5), cut_off);
        }
    }

    #[test]
    fn the_batch_keeps_the_order_for_any_number_of_threads() {
        let oracle = PairOracle::new(Arc::new(solids::torus(8.0, 2.0, 16, 8)), Arc::new(solids::ball(3.0, 6)));
        let poses: Vec<Isometry> =
            (0..500).map(|i| pose_of([0.01 * f64::from(i); 3], [0.08 * f64::from(i) - 20.0, 1.0, 0.5])).collect();
        let run = |threads| {
            let done = AtomicU64::new(0);
            let progress = |n| {
                done.fetch_add(n, Ordering::Relaxed);
            };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let judged = pool.install(|| judge_all(&oracle, &poses, &Sought::Distance { beyond_mm: 2.0 }, &progress));
            assert_eq!(done.into_inner(), 500);
            judged
        };
        let judged = run(1);
        assert_eq!(judged, run(3));
        for (pose, judgement) in poses.iter().zip(&judged) {
            assert_eq!(judgement.verdict, oracle.judge(pose));
            assert_eq!(judgement.clearance_mm, oracle.clearance_mm(pose, 2.0));
        }
        assert!(judged.iter().any(|j| j.verdict.touches()) && judged.iter().any(|j| j.clearance_mm == f64::INFINITY));
    }

    #[test]
    fn a_mad_pose_is_harmless() {
        for x in [f64::NAN, f64::INFINITY, 1e300] {
            let pose = Isometry::translation(x, 0.0, 0.0);
            assert_eq!(block_on_block().judge(&pose), Verdict::default());
            assert_eq!(block_on_block().clearance_mm(&pose, 10.0), f64::INFINITY);
        }
    }
}
