//! Queries along a path: what a pose leaves behind may settle the next one. Verdicts are those of fresh queries, always.
//!
//! Three things are kept. An *axis*, a direction along which the boxes around the meshes were apart (`super::axis`). A *witness*, the pair of
//! triangles that touched last (M. C. Lin, J. F. Canny 1991 keep a pair of features likewise): while it touches, the meshes do. And *evidence* of a
//! free pose, a distance that the meshes were apart there: while no point of `b` has moved that far, they are apart (the motion bound of
//! F. Schwarzer, M. Saha, J.-C. Latombe 2005).
//!
//! Evidence comes from the search for a contact itself, which leaves out only what is farther apart than a margin (`traverse::contact_within`): the
//! margin, or the distance of the nearest triangles that it has met within it, is what the meshes are apart. The margin is as many steps ahead as cost
//! little more than the search alone; where the distance settles few poses, as along a surface, it is left out for a while.
//!
//! Why a kept verdict is the fresh one. Free at pose 0: the triangles as the truth sees them are at least `d` apart, less `MEASURED_PAD`.
//! Their corners are within the pose's slack (`Pose::ball_slack`) of where a rigid motion has them, at either pose. A point p of `b`
//! moves by (R₁ - R₀)p + t₁ - t₀, which is the move of the ball's centre and (R₁ - R₀)(p - centre). With unit quaternions R(q)v = q v q*, so
//! (R₁ - R₀)v = (q₁ - q₀) v q₁* + q₀ v (q₁ - q₀)*, at most 2|q₁ - q₀||v| long; q and -q are the same rotation.

use super::axis::Axis;
use super::lanes::Simd;
use super::node::WideTree;
use super::pose::Pose;
use super::traverse::{self, Scratch, Tally};
use super::triangles;
use super::volume::WideVolume;
use crate::engine::geometry::grid::Placement;
use crate::engine::geometry::{Isometry, Point};
use nalgebra::Vector4;
use std::fmt;
use std::ops::ControlFlow;
use std::str::FromStr;

/// How many steps like the last one a margin reaches ahead: at first, at least, and at most.
const FIRST_AHEAD: u32 = 8;
const LEAST_AHEAD: u32 = 4;
const MOST_AHEAD: u32 = 128;
/// Poses that a distance or an axis must settle to have paid.
const PAYS: u32 = 4;
/// Searches with a margin after which one without tells again what a margin costs.
const WITH_MARGIN: u32 = 16;
/// Fewest nodes that some fresh query of the path has opened where a margin is looked for: below, there is next to nothing to spare.
const WORTH_VISITS: u32 = 6;
/// What a margin loses by rounding, relative: it is added to a slack in `f32` three times, each time less than 2⁻²³ of it.
const MARGIN_PAD: f64 = 1.0 / 1_048_576.0;
/// Most poses that are asked afresh before a distance, or an axis, is looked for again. Searches that fail are dearer than a fresh query alone:
/// so they are fewer than one in a hundred.
const LONGEST_REST: u32 = 127;

/// How much larger a measured distance of two triangles may be than the true one, relative to the size of everything: 2⁻²². The distance of two
/// edges at an angle φ is taken at a place that rounding misplaces along the edges by at most 8·2⁻⁵³ r / φ² (r: how far the corners are from
/// one another), which lengthens it by at most 8·2⁻⁵³ r / φ; at angles below √(8·2⁻⁵³) = 3·10⁻⁸ any place on both is within 3·10⁻⁸ r
/// of the nearest. A corner over a face with a small angle φ is the same case, its edges taking over. 2⁻²² is eight times that.
pub(super) const MEASURED_PAD: f64 = 1.0 / 4_194_304.0;

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
    /// That, and how far apart the meshes were.
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
    evidence: Option<Kept<Evidence>>,
    evidence_rest: Rest,
    margin: Margin,
    /// Where `b` was asked about last.
    last: Option<Place>,
    /// Most nodes that a fresh query has opened.
    dearest: u32,
}

/// How far a margin reaches, and what it costs.
#[derive(Clone, Copy, Debug)]
struct Margin {
    /// Steps ahead.
    ahead: u32,
    /// Nodes that the last search without one has opened at a free pose.
    plain_visits: u32,
    /// Searches with one since then.
    since: u32,
}

impl Default for Margin {
    fn default() -> Self {
        Self { ahead: FIRST_AHEAD, plain_visits: 0, since: WITH_MARGIN }
    }
}

impl Margin {
    /// Whether what is known of the cost of a search without a margin is recent; counts one with it if so.
    const fn is_known(&mut self) -> bool {
        let known = self.since < WITH_MARGIN;
        self.since = if known { self.since + 1 } else { 0 };
        known
    }

    /// Nodes that a search with a margin may open before the margin is given up.
    const fn most_visits(&self) -> u32 {
        self.plain_visits + self.plain_visits / 2 + 2
    }

    /// After a search with a margin at a free pose: farther ahead if it has opened hardly more nodes than one without, less far if many more.
    fn after(&mut self, visits: u32) {
        if visits <= self.plain_visits + self.plain_visits / 4 + 1 {
            self.ahead = (2 * self.ahead).min(MOST_AHEAD);
        } else if visits > self.most_visits() {
            self.ahead = (self.ahead / 2).max(LEAST_AHEAD);
        }
    }
}

/// What a search with a margin is about.
#[derive(Clone, Copy, Debug)]
struct Sought {
    here: Place,
    margin_mm: f32,
    /// How much less than what the search finds the meshes may be apart, mm.
    pad_mm: f64,
    step_mm: f64,
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

/// A pose at which the meshes were apart.
#[derive(Clone, Copy, Debug)]
struct Evidence {
    at: Place,
    /// No point of `b` may have moved so far, mm; what the pose there needs is off already.
    reach_mm: f64,
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
        (self.axis, self.witness, self.evidence, self.last) = (None, None, None, None);
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
            // How far the path has come meanwhile says nothing of its steps.
            (self.axis, self.last) = (None, None);
        }
        // Before a fresh query, not after one: where there is an axis it costs less, and no pose pays for both.
        if self.axis_is_likely && self.axis_rest.is_over() {
            self.axis = Axis::of(a, b, a_from_b).map(Kept::new);
            if self.axis.is_some() {
                return false;
            }
            self.axis_rest.after(0);
        }
        let sought = if coherence == Coherence::Evidence {
            match self.by_evidence(a, b, a_from_b) {
                ControlFlow::Break(()) => return false,
                ControlFlow::Continue(sought) => sought,
            }
        } else {
            None
        };
        let within = (sought.map_or(0.0, |sought| sought.margin_mm), self.margin.most_visits());
        let touching = traverse::contact_within((a, b), a_from_b, within, simd, &mut self.scratch);
        let Tally { visits, apart_mm, .. } = self.scratch.tally;
        self.dearest = self.dearest.max(visits);
        if coherence != Coherence::Axis {
            self.witness = touching;
        }
        self.axis_is_likely = touching.is_none() && visits == 1;
        match sought {
            _ if touching.is_some() => {}
            Some(sought) => self.keep(&sought, apart_mm, visits),
            None => self.margin.plain_visits = visits,
        }
        touching.is_some()
    }

    /// Ends where evidence settles that the meshes are apart; else says what evidence is to be sought, if any.
    fn by_evidence<V: WideVolume>(
        &mut self,
        a: &WideTree<V>,
        b: &WideTree<V>,
        a_from_b: &Isometry,
    ) -> ControlFlow<(), Option<Sought>> {
        if self.dearest < WORTH_VISITS {
            return ControlFlow::Continue(None);
        }
        let here = Place::new(b, a_from_b);
        let slack = Pose::ball_slack(a_from_b, a.reach + b.reach);
        let last = self.last.replace(here);
        if let Some(evidence) = &mut self.evidence {
            if here.moved_mm(&evidence.what.at, b) + slack < evidence.what.reach_mm {
                evidence.settled += 1;
                return ControlFlow::Break(());
            }
            self.evidence_rest.after(evidence.settled);
            self.evidence = None;
        }
        let balls_mm = traverse::balls_apart_mm(a, b, a_from_b);
        if balls_mm > 0.0 {
            self.evidence = Some(Kept::new(Evidence { at: here, reach_mm: balls_mm }));
            return ControlFlow::Break(());
        }
        let Some(last) = last else { return ControlFlow::Continue(None) };
        let step_mm = here.moved_mm(&last, b);
        if !self.evidence_rest.is_over() || !self.margin.is_known() {
            return ControlFlow::Continue(None);
        }
        let size = (here.centre - a.ball.0).norm() + a.ball.1 + b.ball.1;
        let pad_mm = slack + MEASURED_PAD * size;
        let margin_mm = (f64::from(self.margin.ahead) * step_mm + 2.0 * pad_mm) as f32;
        ControlFlow::Continue(Some(Sought { here, margin_mm, pad_mm, step_mm }))
    }

    /// Keeps how far apart the meshes are at a free pose, if that is of use.
    fn keep(&mut self, sought: &Sought, apart_mm: f64, visits: u32) {
        self.margin.after(visits);
        let reach_mm = apart_mm * (1.0 - MARGIN_PAD) - sought.pad_mm;
        if reach_mm > sought.step_mm {
            self.evidence = Some(Kept::new(Evidence { at: sought.here, reach_mm }));
        } else {
            self.evidence_rest.after(0);
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
    fn a_margin_reaches_as_far_as_it_costs_little() {
        let mut margin = Margin::default();
        assert!(!margin.is_known(), "no search has told yet");
        margin.plain_visits = 20;
        margin.after(26);
        assert_eq!(margin.ahead, 2 * FIRST_AHEAD);
        margin.after(27);
        margin.after(32);
        assert_eq!(margin.ahead, 2 * FIRST_AHEAD);
        (0..9).for_each(|_| margin.after(33));
        assert_eq!(margin.ahead, LEAST_AHEAD);
        (0..9).for_each(|_| margin.after(0));
        assert_eq!(margin.ahead, MOST_AHEAD);
        assert_eq!((0..=WITH_MARGIN).filter(|_| margin.is_known()).count(), WITH_MARGIN as usize);
    }

    #[test]
    fn evidence_settles_most_free_poses_and_a_witness_the_others() {
        let (a, b) = trees();
        // Whether queries so cheap as these are worth a search is not the question here.
        let mut memory = Memory { dearest: WORTH_VISITS, ..Memory::default() };
        let (mut tests, mut touching) = (0, 0);
        for step in 0..4000_u32 {
            let pose = Isometry::translation(40.0 - 0.01 * f64::from(step), 1.0, -3.0);
            memory.scratch.tally.counts = Counts::default();
            touching += u32::from(memory.first(&a, &b, &pose, Simd::in_use(), Coherence::Evidence));
            tests += u32::from(memory.scratch.counts() != Counts::default());
        }
        assert!((400..3600).contains(&touching), "{touching}");
        assert!(tests < 200, "{tests} fresh queries");
    }

    #[test]
    fn a_forgotten_path_leaves_what_has_paid_but_nothing_that_settles_a_pose() {
        let (a, b) = trees();
        let mut memory = Memory { dearest: WORTH_VISITS, ..Memory::default() };
        let ask = |memory: &mut Memory, x| {
            memory.first(&a, &b, &Isometry::translation(x, 1.0, -3.0), Simd::in_use(), Coherence::Evidence)
        };
        while memory.evidence.is_none() || memory.last.is_none() {
            assert!(!ask(&mut memory, 25.0));
        }
        memory.evidence_rest.after(0);
        memory.forget();
        assert!(
            memory.axis.is_none() && memory.witness.is_none() && memory.evidence.is_none() && memory.last.is_none()
        );
        assert_eq!((memory.evidence_rest.wait, memory.dearest >= WORTH_VISITS), (1, true));
        assert!(ask(&mut memory, 12.0) && memory.witness.is_some());
        memory.forget();
        assert!(memory.witness.is_none() && !ask(&mut memory, 25.0));
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
