//! Queries along a path: what a pose leaves behind may settle the next one. Verdicts are those of fresh queries, always.
//!
//! Three things are kept. An *axis*, a direction along which the boxes around the meshes were apart (`super::axis`). A *witness*, the pair of
//! triangles that touched last (M. C. Lin, J. F. Canny 1991 keep a pair of features likewise): while it touches, the meshes do. And *evidence* of a
//! free pose, the front of the search that found no contact there (`super::front`): how far each pair of volumes was apart that it left out. While no point of
//! `b` has moved as far as the least of these distances, the meshes are apart (the motion bound of F. Schwarzer, M. Saha, J.-C. Latombe 2005);
//! after that only what is used up is looked at again.
//!
//! Around a pose that one of the three has settled, or the balls around the meshes, or a search of one node, there is a *bubble* of poses with the same
//! verdict (`super::bubble`), at which nothing else is asked.
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
use super::bubble::Bubble;
use super::lanes::Simd;
use super::node::WideTree;
use super::pose::Pose;
use super::traverse::{self, Scratch, Tally};
use super::volume::WideVolume;
use crate::engine::geometry::crossing::crossing_mm;
use crate::engine::geometry::grid::Placement;
use crate::engine::geometry::{Isometry, Point, certified, rigid};
use nalgebra::Vector4;
use std::fmt;
use std::str::FromStr;

/// Poses that a front or an axis must settle to have paid.
const PAYS: u32 = 8;
/// Poses that a bubble must settle to have paid: one costs less than two looks at what it is made from.
const BUBBLE_PAYS: u32 = 2;
/// Fewest nodes that some fresh query of the path has opened where a front is kept: of one node a bubble is all that is of use.
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
    /// A direction along which the boxes around the meshes were apart, or how far they were.
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
    /// Poses around the last one that was looked at, at which the verdict is the same.
    bubble: Option<Bubble>,
    /// Between bubbles of free poses, and of touching ones.
    free_rest: Rest,
    touching_rest: Rest,
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

    /// After a search: whether what it found has paid. Nothing found has not.
    fn after(&mut self, paid: bool) {
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
        (self.bubble, self.axis, self.witness, self.evidence, self.was_free) = (None, None, None, None, false);
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
        if coherence != Coherence::None
            && let Some(bubble) = &mut self.bubble
            && bubble.holds(a_from_b)
        {
            return bubble.touching;
        }
        // What is kept of a pose is right for quaternions of length 1.
        let unit = (!rigid::is_unit(a_from_b)).then(|| rigid::rigid(a_from_b));
        let a_from_b = unit.as_ref().unwrap_or(a_from_b);
        match coherence {
            Coherence::None => traverse::first(a, b, a_from_b, simd, &mut self.scratch),
            _ => self.look((a, b), a_from_b, simd, coherence),
        }
    }

    /// The verdict at a pose outside the bubble.
    fn look<V: WideVolume>(
        &mut self,
        pair: (&WideTree<V>, &WideTree<V>),
        a_from_b: &Isometry,
        simd: Simd,
        coherence: Coherence,
    ) -> bool {
        let settled = self.burst();
        if self.witness.is_some_and(|triangles| self.go_on_touching(pair, a_from_b, triangles)) {
            return true;
        }
        self.witness = None;
        if self.is_parted(pair, a_from_b, settled) {
            return false;
        }
        let touching = match self.carry_on(pair, a_from_b, settled, simd) {
            Some(touching) => touching,
            None => self.afresh(pair, a_from_b, simd, coherence == Coherence::Evidence),
        };
        if coherence != Coherence::Axis {
            self.witness = touching;
        }
        self.was_free = touching.is_none();
        !self.was_free
    }

    /// Takes the bubble away, and returns how many poses it has settled.
    fn burst(&mut self) -> u32 {
        let Some(bubble) = self.bubble.take() else { return 0 };
        let rest = if bubble.touching { &mut self.touching_rest } else { &mut self.free_rest };
        rest.after(bubble.settled >= BUBBLE_PAYS);
        bubble.settled
    }

    /// Whether the two triangles that touched last touch at this pose, too. Makes a bubble where they cross.
    fn go_on_touching<V: WideVolume>(
        &mut self,
        (a, b): (&WideTree<V>, &WideTree<V>),
        a_from_b: &Isometry,
        (i, j): (u32, u32),
    ) -> bool {
        let (of_a, of_b) = (a.triangle(i), Placement::new(a_from_b).triangle(&b.triangle(j)));
        let touching = certified::touch(&of_a, &of_b);
        if touching && self.touching_rest.is_over() {
            let room_mm = crossing_mm(&of_a, &of_b) - Pose::ball_slack(a_from_b, a.reach_with(b));
            self.bubble = Bubble::around((a, b), a_from_b, room_mm, true);
            if self.bubble.is_none() {
                self.touching_rest.after(false);
            }
        }
        touching
    }

    /// Whether an axis is kept and still parts the meshes. If it does, makes a bubble.
    fn is_parted<V: WideVolume>(
        &mut self,
        (a, b): (&WideTree<V>, &WideTree<V>),
        a_from_b: &Isometry,
        settled: u32,
    ) -> bool {
        let Some(axis) = &mut self.axis else { return false };
        axis.settled += settled;
        let apart_mm = axis.what.apart_mm(a, b, a_from_b);
        if apart_mm > 0.0 {
            axis.settled += 1;
            self.keep_bubble((a, b), a_from_b, apart_mm);
            return true;
        }
        self.axis_rest.after(axis.settled >= PAYS);
        self.axis = None;
        false
    }

    /// Makes a bubble around a free pose, unless such bubbles have not paid of late.
    fn keep_bubble<V: WideVolume>(&mut self, pair: (&WideTree<V>, &WideTree<V>), a_from_b: &Isometry, room_mm: f64) {
        if self.free_rest.is_over() {
            self.bubble = Bubble::around(pair, a_from_b, room_mm, false);
        }
    }

    /// Goes on from the front of the last search: the triangles that touch, if any. `None` without a front, and where it is better to begin anew.
    fn carry_on<V: WideVolume>(
        &mut self,
        (a, b): (&WideTree<V>, &WideTree<V>),
        a_from_b: &Isometry,
        settled: u32,
        simd: Simd,
    ) -> Option<Option<(u32, u32)>> {
        let mut kept = self.evidence.take()?;
        let here = Place::new(b, a_from_b);
        let front = &mut self.scratch.front;
        front.step(here.moved_mm(&kept.what, b), Pose::ball_slack(a_from_b, a.reach_with(b)));
        kept = Kept { what: here, settled: kept.settled + settled + 1 };
        if !front.holds() {
            if front.due() as u32 > self.fresh_visits - self.fresh_visits / 4 {
                self.evidence_rest.after(kept.settled > PAYS);
                return None;
            }
            let touching = traverse::search_on((a, b), a_from_b, self.fresh_visits, simd, &mut self.scratch);
            let front = &mut self.scratch.front;
            if !front.is_open() {
                if touching.is_none() {
                    self.evidence_rest.after(false);
                }
                return touching.map(Some);
            }
            front.carried_on();
            // One that has grown has much in it that is no longer of use.
            if front.len() > 2 * self.first_len {
                return Some(None);
            }
        }
        self.evidence = Some(kept);
        let room_mm = self.scratch.front.room_mm();
        self.keep_bubble((a, b), a_from_b, room_mm);
        Some(None)
    }

    /// Asks the balls, the boxes of the roots, then searches. What is apart gives a bubble; a search keeps its front if it `may_keep`.
    fn afresh<V: WideVolume>(
        &mut self,
        (a, b): (&WideTree<V>, &WideTree<V>),
        a_from_b: &Isometry,
        simd: Simd,
        may_keep: bool,
    ) -> Option<(u32, u32)> {
        let apart_mm = traverse::balls_apart_mm(a, b, a_from_b);
        if apart_mm > 0.0 {
            self.scratch.tally = Tally::BALLS;
            self.has_searched(true);
            self.keep_bubble((a, b), a_from_b, apart_mm);
            return None;
        }
        // Before a search, not after one: where there is an axis it costs less, and no pose pays for both.
        if self.axis_is_likely && self.axis_rest.is_over() {
            if let Some((axis, apart_mm)) = Axis::of(a, b, a_from_b) {
                self.axis = Some(Kept::new(axis));
                self.keep_bubble((a, b), a_from_b, apart_mm);
                return None;
            }
            self.axis_rest.after(false);
        }
        let is_worth = self.dearest >= WORTH_VISITS;
        let keeps =
            self.was_free && if is_worth { may_keep && self.evidence_rest.is_over() } else { self.free_rest.is_over() };
        if !keeps {
            let touching = traverse::contact_of_near((a, b), a_from_b, simd, &mut self.scratch);
            self.has_searched(touching.is_none());
            return touching;
        }
        self.scratch.front.open(Pose::ball_slack(a_from_b, a.reach_with(b)));
        let touching = traverse::search_on((a, b), a_from_b, MOST_VISITS, simd, &mut self.scratch);
        self.has_searched(touching.is_none());
        let front = &self.scratch.front;
        if front.is_open() {
            let room_mm = front.room_mm();
            if is_worth {
                self.first_len = front.len();
                self.evidence = Some(Kept::new(Place::new(b, a_from_b)));
            }
            self.bubble = Bubble::around((a, b), a_from_b, room_mm, false);
        }
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
                rest.after(false);
            }
        }
        assert_eq!(searches[..8], [0, 2, 6, 14, 30, 62, 126, 254]);
        assert!(searches.windows(2).skip(7).all(|two| two[1] - two[0] == LONGEST_REST as usize + 1), "{searches:?}");
        rest.after(true);
        assert!(rest.is_over());
        rest.after(false);
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

    /// A touching pose leaves the bubble of its two triangles: how far they may go, less the slack.
    #[test]
    fn a_bubble_of_a_touching_pose_is_that_of_its_triangles() {
        let (a, b) = trees();
        let mut memory = Memory::default();
        let mut bubbles = 0;
        for step in 0..400 {
            let pose = Isometry::translation(12.0 - 0.01 * f64::from(step), 1.0, -3.0);
            let had = memory.bubble.is_some();
            memory.first(&a, &b, &pose, Simd::in_use(), Coherence::Witness);
            if let (false, Some(bubble), Some((i, j))) = (had, memory.bubble, memory.witness) {
                let crossing = crossing_mm(&a.triangle(i), &Placement::new(&pose).triangle(&b.triangle(j)));
                let room_mm = crossing - Pose::ball_slack(&pose, a.reach_with(&b));
                let expected = Bubble::around((&a, &b), &pose, room_mm, true).unwrap();
                assert_eq!(format!("{bubble:?}"), format!("{expected:?}"));
                bubbles += 1;
            }
        }
        assert!(bubbles > 0);
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
        memory.evidence_rest.after(false);
        assert!(memory.bubble.is_some());
        memory.forget();
        assert!(
            memory.bubble.is_none() && memory.axis.is_none() && memory.witness.is_none() && memory.evidence.is_none()
        );
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
