//! Queries along a path: what a pose leaves behind may settle the next one. Verdicts are those of fresh queries, always.
//!
//! Three things are kept. An *axis*, a direction along which the boxes around the meshes were apart (`super::axis`). A *witness*, the pair of
//! triangles that touched last (M. C. Lin, J. F. Canny 1991 keep a pair of features likewise): while it touches, the meshes do. And *evidence* of a
//! free pose, the front of the search that found no contact there (`super::front`): how far each pair of volumes was apart that it left out. While no point of
//! `b` has moved as far as the least of these distances, the meshes are apart (the motion bound of F. Schwarzer, M. Saha, J.-C. Latombe 2005);
//! after that only what is used up is looked at again.
//!
//! What evidence costs. A search that keeps its front opens the nodes of a fresh one. The front settles a pose only where at most three quarters as many visits
//! are due as a fresh search makes; where that leads to more than a fresh search makes, the search begins anew. Then, and where a front settles few
//! poses, none is kept for a while, at last for all but one search in 128.
//!
//! Why a kept verdict is the fresh one. The corners as the leaves see them are within the pose's slack (`Pose::ball_slack`) of where a rigid motion has
//! them, at either pose. A point p of `b` moves by (R₁ - R₀)p + t₁ - t₀, which is the move of the ball's centre and (R₁ - R₀)(p - centre). With
//! unit quaternions R(q)v = q v q*, so (R₁ - R₀)v = (q₁ - q₀) v q₁* + q₀ v (q₁ - q₀)*, at most 2|q₁ - q₀||v| long; q and -q are the same rotation. As a
//! distance of two places this obeys the triangle inequality, so that the steps of a path may be summed, and the roundings of a place count
//! at both ends of the sum alone.

use super::axis::Axis;
use super::lanes::Simd;
use super::node::WideTree;
use super::pose::Pose;
use super::traverse::{self, Scratch};
use super::triangles;
use super::volume::WideVolume;
use crate::engine::geometry::grid::Placement;
use crate::engine::geometry::{Isometry, Point, rigid};
use nalgebra::Vector4;
use std::fmt;
use std::str::FromStr;

/// Poses that a front or an axis must settle to have paid.
const PAYS: u32 = 8;
/// Fewest nodes that some fresh query of the path has opened where a front is kept: below, there is next to nothing to spare.
const WORTH_VISITS: u32 = 2;
/// Most nodes that a search opens while it keeps its front: one of them is 24 bytes.
const MOST_VISITS: u32 = 1 << 16;
/// Most poses that are asked afresh before a front is kept, or an axis is looked for, again: what has failed that often is tried in less than one pose
/// of a hundred.
const LONGEST_REST: u32 = 127;

/// What a query may use of the pose before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coherence {
    /// Nothing: every query is fresh.
    #[default]
    None,
    /// A direction along which the boxes around the meshes were apart.
    Axis,
    /// That, and the pair of triangles that touched.
    Witness,
    /// That, and how far apart was what the search left out.
    Evidence,
}

impl Coherence {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::None, Self::Axis, Self::Witness, Self::Evidence];

    /// The name on the command line.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Axis => "axis",
            Self::Witness => "witness",
            Self::Evidence => "evidence",
        }
    }
}

impl fmt::Display for Coherence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.id())
    }
}

impl FromStr for Coherence {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|coherence| coherence.id() == text);
        found.ok_or_else(|| format!("`{text}` is not a coherence: expected none, axis, witness or evidence"))
    }
}

/// What the queries about two meshes, and only those, leave behind along a path.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    scratch: Scratch,
    axis: Option<Kept<Axis>>,
    axis_rest: Rest,
    /// Whether one look at the roots was enough for the last fresh query.
    axis_is_likely: bool,
    /// The places of the triangles that touched last.
    witness: Option<(u32, u32)>,
    /// Where `b` was when the front of `scratch` was last asked, and how many poses it has settled.
    evidence: Option<Kept<Place>>,
    evidence_rest: Rest,
    /// Whether the last pose was free, which makes it likely that this one is.
    was_free: bool,
    /// Nodes that the last fresh query of a free pose has opened.
    fresh_visits: u32,
    /// Visits and pairs in the front when it was new.
    first_len: usize,
    /// Most nodes that a fresh query has opened.
    dearest: u32,
}

/// What a pose left behind, and how many it has settled since.
#[derive(Clone, Copy, Debug)]
struct Kept<T> {
    what: T,
    settled: u32,
}

impl<T> Kept<T> {
    const fn new(what: T) -> Self {
        Self { what, settled: 0 }
    }
}

/// How long a search is left out that has not paid: longer after each failure, shorter after each success.
#[derive(Clone, Copy, Debug, Default)]
struct Rest {
    /// Poses before the next search.
    wait: u32,
    /// The last such wait.
    last: u32,
}

impl Rest {
    /// Whether it is over; if not, a pose of it goes by.
    const fn is_over(&mut self) -> bool {
        if self.wait == 0 {
            return true;
        }
        self.wait -= 1;
        false
    }

    /// What a search found has settled as many poses: none if it found nothing.
    fn after(&mut self, settled: u32) {
        let paid = settled >= PAYS;
        self.last = if paid { self.last / 2 } else { (2 * self.last + 1).min(LONGEST_REST) };
        self.wait = if paid { 0 } else { self.last };
    }
}

/// Where `b` is: the centre of its ball, mm, and its unit quaternion.
#[derive(Clone, Copy, Debug)]
struct Place {
    centre: Point,
    turn: Vector4<f64>,
}

impl Place {
    fn new<V: WideVolume>(b: &WideTree<V>, a_from_b: &Isometry) -> Self {
        Self { centre: a_from_b * b.ball.0, turn: a_from_b.rotation.coords }
    }

    /// The farthest that a point of `b` has moved between the two, mm.
    fn moved_mm<V: WideVolume>(&self, other: &Self, b: &WideTree<V>) -> f64 {
        let turned = (self.turn - other.turn).norm_squared().min((self.turn + other.turn).norm_squared()).sqrt();
        (self.centre - other.centre).norm() + 2.0 * b.ball.1 * turned
    }
}

impl Memory {
    /// Forgets all poses, before another path of the same meshes: no verdict rests on them. Which searches have paid is still known.
    pub fn forget(&mut self) {
        (self.axis, self.witness, self.evidence, self.was_free) = (None, None, None, false);
    }

    /// Whether the meshes touch: [`traverse::first`], by a shorter way where `coherence` allows one.
    pub fn first<V: WideVolume>(
        &mut self,
        a: &WideTree<V>,
        b: &WideTree<V>,
        a_from_b: &Isometry,
        simd: Simd,
        coherence: Coherence,
    ) -> bool {
        // What is kept of a pose is right for quaternions of length 1.
        let unit = (!rigid::is_unit(a_from_b)).then(|| rigid::rigid(a_from_b));
        let a_from_b = unit.as_ref().unwrap_or(a_from_b);
        if coherence == Coherence::None {
            return traverse::first(a, b, a_from_b, simd, &mut self.scratch);
        }
        if self.witness.is_some_and(|pair| triangles::touch(a, b, &Placement::new(a_from_b), pair)) {
            return true;
        }
        self.witness = None;
        if let Some(axis) = &mut self.axis {
            if axis.what.parts(a, b, a_from_b) {
                axis.settled += 1;
                return false;
            }
            self.axis_rest.after(axis.settled);
            self.axis = None;
        }
        // Before a fresh query, not after one: where there is an axis it costs less, and no pose pays for both.
        if self.axis_is_likely && self.axis_rest.is_over() {
            self.axis = Axis::of(a, b, a_from_b).map(Kept::new);
            if self.axis.is_some() {
                return false;
            }
            self.axis_rest.after(0);
        }
        let touching = if coherence == Coherence::Evidence {
            self.by_evidence((a, b), a_from_b, simd)
        } else {
            self.fresh((a, b), a_from_b, simd)
        };
        if coherence != Coherence::Axis {
            self.witness = touching;
        }
        self.was_free = touching.is_none();
        !self.was_free
    }

    fn fresh<V: WideVolume>(
        &mut self,
        (a, b): (&WideTree<V>, &WideTree<V>),
        a_from_b: &Isometry,
        simd: Simd,
    ) -> Option<(u32, u32)> {
        let touching = traverse::contact(a, b, a_from_b, simd, &mut self.scratch);
        self.has_searched(touching.is_none());
        touching
    }

    /// After a search that was not cut short.
    fn has_searched(&mut self, is_free: bool) {
        let visits = self.scratch.tally.visits;
        self.dearest = self.dearest.max(visits);
        self.axis_is_likely = is_free && visits == 1;
        if is_free {
            self.fresh_visits = visits;
        }
    }

    /// From the front of the last search on, if that is worth while; else afresh.
    fn by_evidence<V: WideVolume>(
        &mut self,
        (a, b): (&WideTree<V>, &WideTree<V>),
        a_from_b: &Isometry,
        simd: Simd,
    ) -> Option<(u32, u32)> {
        if self.dearest < WORTH_VISITS {
            return self.fresh((a, b), a_from_b, simd);
        }
        let here = Place::new(b, a_from_b);
        let slack_mm = Pose::ball_slack(a_from_b, a.reach + b.reach);
        if let Some(mut kept) = self.evidence.take() {
            let front = &mut self.scratch.front;
            front.step(here.moved_mm(&kept.what, b), slack_mm);
            kept = Kept { what: here, settled: kept.settled + 1 };
            if front.holds() {
                self.evidence = Some(kept);
                return None;
            }
            if front.due() as u32 <= self.fresh_visits - self.fresh_visits / 4 {
                let touching = traverse::contact_keeping((a, b), a_from_b, self.fresh_visits, simd, &mut self.scratch);
                let front = &mut self.scratch.front;
                if front.is_open() {
                    front.carried_on();
                    // One that has grown has much in it that is no longer of use.
                    self.evidence = (front.len() <= 2 * self.first_len).then_some(kept);
                    return None;
                }
                if touching.is_some() {
                    return touching;
                }
                self.evidence_rest.after(0);
            } else {
                self.evidence_rest.after(kept.settled - 1);
            }
        }
        if !self.was_free || !self.evidence_rest.is_over() || traverse::balls_are_apart(a, b, a_from_b) {
            return self.fresh((a, b), a_from_b, simd);
        }
        self.scratch.front.open(slack_mm);
        let touching = traverse::contact_keeping((a, b), a_from_b, MOST_VISITS, simd, &mut self.scratch);
        self.has_searched(touching.is_none());
        if self.scratch.front.is_open() {
            self.first_len = self.scratch.front.len();
            self.evidence = Some(Kept::new(here));
        }
        touching
    }
}

#[cfg(test)]
impl Memory {
    /// Operations of a query, none where what is kept settles it.
    pub(super) fn counted<V: WideVolume>(
        &mut self,
        a: &WideTree<V>,
        b: &WideTree<V>,
        a_from_b: &Isometry,
        simd: Simd,
        coherence: Coherence,
    ) -> traverse::Counts {
        self.scratch.tally.counts = traverse::Counts::default();
        self.first(a, b, a_from_b, simd, coherence);
        self.scratch.counts()
    }
}

#[cfg(test)]
mod tests {
    use super::super::oriented::Oriented;
    use super::traverse::Counts;
    use super::*;
    use crate::cases::meshes;
    use proptest::prelude::*;

    fn trees() -> (WideTree<Oriented>, WideTree<Oriented>) {
        (WideTree::build(&meshes::torus(12.0, 4.0, 28, 14)), WideTree::build(&meshes::stepped_tool(16, 8)))
    }

    #[test]
    fn a_coherence_is_read_from_its_name() {
        for coherence in Coherence::ALL {
            assert_eq!(coherence.to_string().parse(), Ok(coherence));
        }
        assert_eq!("witness".parse(), Ok(Coherence::Witness));
        assert!("".parse::<Coherence>().is_err());
    }

    #[test]
    fn a_step_is_known_from_the_centre_and_the_turn() {
        let (_, b) = trees();
        let place = |x, angle| Place::new(&b, &Isometry::new([x, 0.0, 0.0].into(), [0.0, 0.0, angle].into()));
        assert!((place(1.0, 0.0).moved_mm(&place(4.0, 0.0), &b) - 3.0).abs() < 1e-12);
        // A turn by θ about the centre: half of it in the quaternion, so 2 r · 2 sin(θ/4), here r (1 - small) θ, at least the chord.
        let (radius, turn) = (b.ball.1, Isometry::rotation([0.0, 0.0, 0.1].into()));
        let about =
            nalgebra::Translation3::from(b.ball.0.coords) * turn * nalgebra::Translation3::from(-b.ball.0.coords);
        let moved = Place::new(&b, &about).moved_mm(&Place::new(&b, &Isometry::identity()), &b);
        assert!((moved - 4.0 * radius * 0.025_f64.sin()).abs() < 1e-9 && moved >= 2.0 * radius * 0.05_f64.sin());
        // The other quaternion of the same rotation is the same place.
        let mut other = Place::new(&b, &about);
        other.turn = -other.turn;
        assert!((other.moved_mm(&Place::new(&b, &Isometry::identity()), &b) - moved).abs() < 1e-12);
    }

    #[test]
    fn searches_that_fail_grow_rare_and_one_that_pays_comes_again_at_once() {
        let mut rest = Rest::default();
        let mut searches = Vec::new();
        for pose in 0..1000 {
            if rest.is_over() {
                searches.push(pose);
                rest.after(0);
            }
        }
        assert_eq!(searches[..8], [0, 2, 6, 14, 30, 62, 126, 254]);
        assert!(searches.windows(2).skip(7).all(|two| two[1] - two[0] == LONGEST_REST as usize + 1), "{searches:?}");
        rest.after(PAYS);
        assert!(rest.is_over());
        rest.after(PAYS - 1);
        assert!(!rest.is_over());
    }

    #[test]
    fn evidence_settles_most_free_poses_and_a_witness_the_others() {
        let (a, b) = trees();
        // Whether queries so cheap as these are worth a search is not the question here.
        let mut memory = Memory { dearest: WORTH_VISITS, ..Memory::default() };
        let mut scratch = Scratch::default();
        let (mut searches, mut touching, mut tests, mut fresh_tests) = (0, 0, 0, 0);
        for step in 0..4000_u32 {
            let pose = Isometry::translation(40.0 - 0.01 * f64::from(step), 1.0, -3.0);
            memory.scratch.tally.counts = Counts::default();
            touching += u32::from(memory.first(&a, &b, &pose, Simd::in_use(), Coherence::Evidence));
            traverse::first(&a, &b, &pose, Simd::in_use(), &mut scratch);
            searches += u32::from(memory.scratch.counts() != Counts::default());
            tests += memory.scratch.counts().volume_tests;
            fresh_tests += scratch.counts().volume_tests;
        }
        assert!((400..3600).contains(&touching), "{touching}");
        assert!(searches < 500, "{searches} searches");
        assert!(tests < fresh_tests / 20, "{tests} volume tests, afresh {fresh_tests}");
    }

    #[test]
    fn a_forgotten_path_leaves_what_has_paid_but_nothing_that_settles_a_pose() {
        let (a, b) = trees();
        let mut memory = Memory { dearest: WORTH_VISITS, ..Memory::default() };
        let ask = |memory: &mut Memory, x| {
            memory.first(&a, &b, &Isometry::translation(x, 1.0, -3.0), Simd::in_use(), Coherence::Evidence)
        };
        while memory.evidence.is_none() {
            assert!(!ask(&mut memory, 25.0));
        }
        memory.evidence_rest.after(0);
        memory.forget();
        assert!(memory.axis.is_none() && memory.witness.is_none() && memory.evidence.is_none());
        assert_eq!((memory.evidence_rest.wait, memory.dearest >= WORTH_VISITS), (1, true));
        assert!(ask(&mut memory, 12.0) && memory.witness.is_some());
        memory.forget();
        assert!(memory.witness.is_none() && !ask(&mut memory, 25.0));
    }

    /// By a quaternion of another length a path has the verdicts of the unit one, and costs as much: volumes are not widened for it.
    #[test]
    fn a_quaternion_may_have_any_length() {
        let (a, b) = trees();
        let stretched = |pose: &Isometry, length: f64| {
            let quaternion = *pose.rotation.quaternion() * length;
            Isometry::from_parts(pose.translation, nalgebra::UnitQuaternion::new_unchecked(quaternion))
        };
        let mut scratch = Scratch::default();
        for coherence in Coherence::ALL {
            let mut memories = [(); 4].map(|()| Memory { dearest: WORTH_VISITS, ..Memory::default() });
            let (mut touching, mut searched) = (0, 0);
            for step in 0..600_u32 {
                let angle = 0.01 * f64::from(step);
                let pose = Isometry::new([19.0, 1.0, -3.0].into(), [0.4 * angle, angle, 0.0].into());
                let expected = traverse::first(&a, &b, &pose, Simd::in_use(), &mut scratch);
                let counts = memories[0].counted(&a, &b, &pose, Simd::in_use(), coherence);
                touching += u32::from(expected);
                for (memory, length) in memories[1..].iter_mut().zip([1e-3, 1.0 + 1e-6, 1e90]) {
                    let pose = stretched(&pose, length);
                    assert_eq!(traverse::first(&a, &b, &pose, Simd::in_use(), &mut scratch), expected, "{length}");
                    let found = memory.counted(&a, &b, &pose, Simd::in_use(), coherence);
                    assert_eq!(memory.first(&a, &b, &pose, Simd::in_use(), coherence), expected, "{length}");
                    if coherence == Coherence::None && counts.volume_tests > 1 {
                        assert_eq!(found, counts, "step {step}, {length}");
                        searched += 1;
                    }
                }
            }
            assert!((50..550).contains(&touching), "{touching}");
            assert!(coherence != Coherence::None || searched > 300, "{searched}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        /// Along paths of any step, smooth or jumping, each coherence has the verdicts of fresh queries on every instruction set.
        #[test]
        fn verdicts_are_those_of_fresh_queries(
            start in prop::array::uniform3(-30.0..30.0_f64),
            turn in prop::array::uniform3(-3.0..3.0_f64),
            exponent in -4.0..1.0_f64,
            direction in prop::array::uniform3(-1.0..1.0_f64),
            spin in prop::array::uniform3(-0.01..0.01_f64),
            jumps in prop::collection::vec(0..200_usize, 0..4),
        ) {
            let (a, b) = trees();
            let step = 10f64.powf(exponent);
            // Towards the ring's middle, so that most paths come near it.
            let aim = nalgebra::Vector3::from(direction) - nalgebra::Vector3::from(start) * 0.05;
            for simd in Simd::available() {
                for coherence in Coherence::ALL {
                    let mut memory = Memory::default();
                    let mut scratch = Scratch::default();
                    let mut jumped = 0.0;
                    for k in 0..200_usize {
                        if k == 150 {
                            memory.forget();
                        }
                        jumped += if jumps.contains(&k) { 50.0 } else { 0.0 };
                        let along = step * (k as f64 + jumped);
                        let shift = nalgebra::Vector3::from(start) + aim * along;
                        let pose = Isometry::new(shift, nalgebra::Vector3::from(turn) + nalgebra::Vector3::from(spin) * along);
                        let fresh = traverse::first(&a, &b, &pose, simd, &mut scratch);
                        let kept = memory.first(&a, &b, &pose, simd, coherence);
                        prop_assert_eq!(kept, fresh, "pose {}, {}, {}", k, coherence, simd.name());
                    }
                }
            }
        }
    }
}
