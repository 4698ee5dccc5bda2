//! Judges an axis sample: may the machine go on until the next hold would take effect?
//!
//! # The rule
//!
//! A sample says where axis `i` was, `q_i`, and how fast it went over the last interval of length `h`, `v_i`. Let
//!
//! - `A_i` be the largest acceleration of the axis, averaged over a cycle of the control, and `a_i` the deceleration of a hold;
//! - `D` the deadline: from the source time of the sample, a hold takes effect within `D`;
//! - `σ` the spread of the source times of the axes in one sample, and `ε_i` the resolution of the position;
//! - `e_i` the error of `v_i`. Both positions are wrong by up to `ε_i`, and source times by up to `j`: the way of `v_i h ± 2ε_i` may have taken
//!   `h - 2j`, so `e_i = (|v_i| 2j + 2ε_i) / (h - 2j)`; then `D + j`, `h + 2j` and `σ + 2j` stand for `D`, `h` and `σ` below.
//!
//! The control changes its velocity in steps of a cycle, so the velocity at `τ` after the sample differs from `v_i` by at most
//! `e_i + A_i (τ + 2h)`. No axis is faster than `s_i = |v_i| + e_i + A_i (D + 2h)` when the hold takes effect. The hold is an override that falls linearly to zero
//! within `T = max_i s_i / a_i`: the machine stays on the path of the program, and passes through what the program would have done in
//! another `T / 2`. So every place that the machine can reach before it stands is one that the program reaches within
//!
//! ```text
//! H = D + T / 2,      q_i(τ) = q_i + v_i τ ± b_i(τ),      b_i(τ) = ε_i + (|v_i| + e_i) σ + e_i τ + A_i (τ² / 2 + 2hτ),      0 ≤ τ ≤ H.
//! ```
//!
//! The interval `[0, H]` is halved until each piece is judged. At the middle of a piece, axis `i` stays within
//! `δ_i = |v_i| (τ₂ - τ₁) / 2 + b_i(τ₂)`, which moves no point of a pair of parts farther than the motion bound `λ(δ)` of
//! [`bvbench::machine::travel`] (Schwarzer, Saha, Latombe 2005). The pair is free over the piece when its distance there exceeds `λ(δ)`; the
//! difference is the clearance that is guaranteed.
//!
//! A control with a hold of constant path deceleration keeps the promise when half that deceleration is stated: its hold takes no longer
//! than `T / 2` from the same speed, and is never ahead of the program.

use bvbench::machine::Machine;
use bvbench::machine::travel::Ball;
use bvbench::machine::{OutOfLimits, Poses};
use bvbench::method::Model;
use bvbench::registry::Variant;
use bvbench::scene::pairs::{self, Range, Reach};
use bvbench::scene::{Clearances, Pair, Scene};
use bvbench::tree::distance::Proximity;
use bvbench::truth::Solid;
use rs274::interpret::FARTHEST;
use rs274::{Axis, Position};
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// How much farther than needed a distance is looked for, mm: a longer one spares later samples a query, and takes longer to find.
const OUTLOOK_MM: f64 = 10.0;
/// Share of a distance that is found at first: mostly a lower bound is all that is needed, and the distance itself takes many times as long.
const KEPT: f64 = 0.8;
/// How far beyond its limits an axis may be shown, in resolutions: the position is wrong by up to one, the drive holds its axis within one, and the limit
/// was taken from such a position.
const LIMIT_RESOLUTIONS: f64 = 3.0;
/// Most halvings of the look-ahead. Behind them the width of a piece is `b`, which halving does not narrow.
const HALVINGS: u32 = 6;

/// What is promised about a machine's axes, mm and radians, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// Largest acceleration of each axis, averaged over a cycle.
    pub acceleration: [f64; 9],
    /// Deceleration of each axis in a hold.
    pub deceleration: [f64; 9],
    /// Resolution of each position: its largest error.
    pub resolution: [f64; 9],
}

/// What is asked of a judge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// The axes.
    pub dynamics: Dynamics,
    /// Time from the source time of a sample within which a hold takes effect, s.
    pub deadline_s: f64,
    /// Guaranteed clearance below which the verdict is near, mm.
    pub near_mm: f64,
}

/// Where the axes are and how fast they go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Positions, mm and radians.
    pub position: Position,
    /// Velocities over the last interval, mm/s and radians/s.
    pub velocity: Position,
    /// Errors of the velocities, mm/s and radians/s.
    pub velocity_error: Position,
    /// Length of that interval at most, s.
    pub interval_s: f64,
    /// Spread of the source times of the axes, s.
    pub spread_s: f64,
    /// Tool in the spindle.
    pub tool: u32,
}

/// A verdict. Its number is what the verdict node holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is known: treated like a collision.
    Unknown = 0,
    /// Free by at least the near distance.
    Clear = 1,
    /// Free, by less than the near distance.
    Near = 2,
    /// Contact cannot be excluded before the machine would stand.
    Collision = 3,
}

impl Verdict {
    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Near => "near",
            Self::Collision => "collision",
            Self::Unknown => "unknown",
        }
    }

    /// Whether the machine may go on.
    pub const fn permits(self) -> bool {
        matches!(self, Self::Clear | Self::Near)
    }
}

/// An answer to one sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// The verdict.
    pub verdict: Verdict,
    /// Clearance guaranteed over the look-ahead, mm, at most the near distance; 0 when contact cannot be excluded.
    pub clearance_mm: f64,
    /// The pair with that clearance; `None` when nothing is near or nothing is known.
    pub pair: Option<Pair>,
    /// Length of the look-ahead, s.
    pub horizon_s: f64,
    /// Distances that were found.
    pub queries: u32,
    /// Why nothing is known.
    pub cause: Option<Ignorance>,
}

/// Why nothing is known.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Ignorance {
    /// A position or velocity is not a number.
    #[error("axis {0}: the position or velocity is not a finite number")]
    NotFinite(char),
    /// A position is beyond what any machine has.
    #[error("axis {0}: the position is beyond {FARTHEST} mm or radians")]
    TooFar(char),
    /// An axis is beyond its limits.
    #[error(transparent)]
    OutOfLimits(#[from] OutOfLimits),
    /// The tool in the spindle has no part in the scene.
    #[error("tool {0} has no part in the scene")]
    NoPart(u32),
}

/// Why a scene cannot be watched.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum JudgeError {
    /// The variant misses contacts.
    #[error("variant `{0}` misses contacts; choose a safe one: `bvbench list` names them")]
    Unsafe(&'static str),
    /// The variant answers for tools and workpieces only.
    #[error("variant `{0}` is made for tools and workpieces alone; choose another")]
    ForToolsOnly(&'static str),
    /// Nothing could collide.
    #[error("scene `{0}` has no two parts that could collide; `bvbench scene pairs` says why")]
    NoPairs(String),
}

/// A part that is watched.
struct Body {
    model: Box<dyn Model>,
    solid: Solid,
    ball: Ball,
}

/// A pair that is watched, and what its last query said.
struct Watched {
    pair: Pair,
    /// State of the last search for a share of the distance, and of the last one for the distance itself.
    proximity: [Proximity; 2],
    /// Where the last query was, and the distance there.
    last: Option<(Position, Poses, f64)>,
}

/// Judges the samples of one machine. Not shared between threads: it keeps what the last sample said.
pub struct Judge<'a> {
    scene: &'a Scene,
    rule: Rule,
    /// Where the axes may be.
    limits: Range,
    bodies: BTreeMap<usize, Body>,
    pairs: Vec<Watched>,
}

impl<'a> Judge<'a> {
    /// Prepares every part that could collide within the machine's limits. A cutter and the workpiece are not watched, because samples do
    /// not say whether their contact is intended.
    ///
    /// # Errors
    /// When the variant is not safe for every pair, or nothing could collide.
    pub fn new(scene: &'a Scene, variant: &Variant, rule: Rule) -> Result<Self, JudgeError> {
        if !variant.info.safe {
            return Err(JudgeError::Unsafe(variant.info.id));
        }
        if variant.is_for_tools {
            return Err(JudgeError::ForToolsOnly(variant.info.id));
        }
        let reach = reach(scene, &rule.dynamics);
        let decisions = pairs::decide(scene, &reach, &Clearances::everywhere(&[rule.near_mm]));
        let kept = decisions.iter().filter(|d| d.dropped.is_none()).map(|d| d.pair);
        let pairs: Vec<Pair> = kept.filter(|&pair| !scene.is_cutting(pair)).collect();
        if pairs.is_empty() {
            return Err(JudgeError::NoPairs(scene.name.clone()));
        }
        let prepare = |part: usize| {
            let mesh = &scene.parts[part].mesh;
            let model = variant.prepare(mesh, None);
            (part, Body { model, solid: Solid::new(Arc::clone(mesh)), ball: pairs::ball(&scene.parts[part]) })
        };
        let mut parts: Vec<usize> = pairs.iter().flat_map(|pair| [pair.a, pair.b]).collect();
        parts.sort_unstable();
        parts.dedup();
        let bodies = parts.into_iter().map(prepare).collect();
        let watched = |pair| Watched { pair, proximity: fresh(), last: None };
        Ok(Self { scene, rule, limits: reach.axes, bodies, pairs: pairs.into_iter().map(watched).collect() })
    }

    /// The pairs that are watched.
    pub fn pairs(&self) -> impl Iterator<Item = Pair> {
        self.pairs.iter().map(|watched| watched.pair)
    }

    /// Examined parts whose meshes are not watertight: whether something is inside them is not known.
    pub fn open_parts(&self) -> impl Iterator<Item = usize> {
        self.bodies.iter().filter(|(_, body)| !body.solid.is_watertight()).map(|(&part, _)| part)
    }

    /// Forgets what earlier samples said, as after a start.
    pub fn forget(&mut self) {
        for watched in &mut self.pairs {
            (watched.proximity, watched.last) = (fresh(), None);
        }
    }

    /// Judges a sample.
    pub fn judge(&mut self, state: &State) -> Answer {
        if let Some(cause) = self.ignorance(state) {
            let (verdict, cause) = (Verdict::Unknown, Some(cause));
            return Answer { verdict, clearance_mm: 0.0, pair: None, horizon_s: 0.0, queries: 0, cause };
        }
        let mut look = Look::new(self.scene, &self.rule, state);
        let (mut least, mut nearest) = (self.rule.near_mm, None);
        for watched in &mut self.pairs {
            if !self.scene.is_mounted(watched.pair, state.tool) {
                continue;
            }
            let clearance = look.over(watched, &self.bodies, 0.0, look.horizon_s, HALVINGS);
            if clearance < least {
                (least, nearest) = (clearance, Some(watched.pair));
            }
        }
        let verdict = match nearest {
            None => Verdict::Clear,
            Some(_) if least > 0.0 => Verdict::Near,
            Some(_) => Verdict::Collision,
        };
        let (horizon_s, queries) = (look.horizon_s, look.queries);
        Answer { verdict, clearance_mm: least.max(0.0), pair: nearest, horizon_s, queries, cause: None }
    }

    fn ignorance(&self, state: &State) -> Option<Ignorance> {
        let is_finite = |axis: &Axis| state.position[*axis].is_finite() && state.velocity[*axis].is_finite();
        if let Some(axis) = Axis::ALL.into_iter().find(|axis| !is_finite(axis)) {
            return Some(Ignorance::NotFinite(axis.letter()));
        }
        if let Some(axis) = Axis::ALL.into_iter().find(|&axis| state.position[axis].abs() > FARTHEST) {
            return Some(Ignorance::TooFar(axis.letter()));
        }
        let Range { low, high } = &self.limits;
        let is_beyond = |axis: &Axis| !(low[*axis]..=high[*axis]).contains(&state.position[*axis]);
        let check = |axis| self.scene.machine.check_axis(axis, &state.position);
        if let Err(cause) = Axis::ALL.into_iter().filter(is_beyond).try_for_each(check) {
            return Some(cause.into());
        }
        let has_part = self.scene.parts.iter().any(|part| part.tool == Some(state.tool));
        let is_known = !self.scene.changes_tools() || state.tool == 0 || has_part;
        (!is_known).then_some(Ignorance::NoPart(state.tool))
    }
}

/// The look-ahead from one sample.
struct Look<'a> {
    scene: &'a Scene,
    near_mm: f64,
    acceleration: [f64; 9],
    resolution: [f64; 9],
    state: &'a State,
    horizon_s: f64,
    /// Poses at the times that were asked for.
    poses: Vec<(f64, Position, Poses)>,
    queries: u32,
}

impl<'a> Look<'a> {
    fn new(scene: &'a Scene, rule: &Rule, state: &'a State) -> Self {
        let &Dynamics { acceleration, resolution, .. } = &rule.dynamics;
        let horizon_s = horizon_s(scene, rule, state);
        Self { scene, near_mm: rule.near_mm, acceleration, resolution, state, horizon_s, poses: Vec::new(), queries: 0 }
    }

    /// How far each axis may be from its straight course after `time_s`.
    fn width(&self, time_s: f64) -> [f64; 9] {
        let State { velocity, velocity_error, interval_s, spread_s, .. } = self.state;
        let late = 0.5 * time_s * time_s + 2.0 * interval_s * time_s;
        std::array::from_fn(|i| {
            let (speed, error) = (velocity.0[i].abs(), velocity_error.0[i]);
            self.resolution[i] + (speed + error) * spread_s + error * time_s + self.acceleration[i] * late
        })
    }

    /// Index of the poses after `time_s` on the straight course.
    fn at(&mut self, time_s: f64) -> usize {
        if let Some(index) = self.poses.iter().position(|(known, ..)| *known == time_s) {
            return index;
        }
        let State { position, velocity, .. } = self.state;
        let there = Position(std::array::from_fn(|i| position.0[i] + velocity.0[i] * time_s));
        self.poses.push((time_s, there, self.scene.machine.forward(&there)));
        self.poses.len() - 1
    }

    /// The clearance of a pair that is guaranteed from one time to another, mm; 0 or less when contact cannot be excluded.
    fn over(
        &mut self,
        watched: &mut Watched,
        bodies: &BTreeMap<usize, Body>,
        from: f64,
        to: f64,
        halvings: u32,
    ) -> f64 {
        let at = self.at(f64::midpoint(from, to));
        let width = self.width(to);
        let within = Position(std::array::from_fn(|i| 0.5 * self.state.velocity.0[i].abs() * (to - from) + width[i]));
        let [a, b] = [watched.pair.a, watched.pair.b].map(|part| &bodies[&part]);
        let bound = self.scene.machine.travel_bound_mm(&a.ball, &b.ball, &self.poses[at].2, &within);
        let distance = self.distance(watched, [a, b], at, bound);
        // Infinity less infinity: nothing is guaranteed.
        let clearance = Some(distance - bound).filter(|clearance| !clearance.is_nan()).unwrap_or(f64::NEG_INFINITY);
        if clearance >= self.near_mm || distance <= 0.0 || halvings == 0 || to <= from {
            return clearance;
        }
        let middle = f64::midpoint(from, to);
        let first = self.over(watched, bodies, from, middle, halvings - 1);
        if first <= 0.0 { first } else { first.min(self.over(watched, bodies, middle, to, halvings - 1)) }
    }

    /// A lower bound of a pair's distance at a pose, mm: what is left of the last distance that was found, where that is enough, or else
    /// most of the distance, or all of it where only that exceeds the motion `bound`. 0 in contact, and for one part inside the other.
    fn distance(&mut self, watched: &mut Watched, [a, b]: [&Body; 2], at: usize, bound: f64) -> f64 {
        let (_, there, poses) = &self.poses[at];
        let enough = bound + self.near_mm;
        if let Some((from, from_poses, distance)) = &watched.last {
            let change = Position(std::array::from_fn(|i| there.0[i] - from.0[i]));
            let left = distance - self.scene.machine.travel_bound_mm(&a.ball, &b.ball, from_poses, &change);
            if left >= enough {
                return left;
            }
        }
        self.queries += 1;
        let beyond = enough + OUTLOOK_MM;
        let a_from_b = self.scene.a_from_b(watched.pair, poses);
        // `min` would take the other number for one that is none.
        let ask = |proximity| match a.model.distance_mm(b.model.as_ref(), &a_from_b, beyond, proximity) {
            distance if distance.is_nan() => 0.0,
            distance => distance.min(beyond),
        };
        let [share, whole] = &mut watched.proximity;
        let most = ask(share);
        let distance = if most <= bound && most > KEPT * bound { ask(whole) } else { most };
        let inside = distance > 0.0 && Solid::one_in_the_other(&a.solid, &b.solid, &a_from_b, false);
        let distance = if inside { 0.0 } else { distance };
        watched.last = Some((*there, poses.clone(), distance));
        distance
    }
}

/// Whether the machine has a joint that follows this axis.
pub(crate) fn is_driven(machine: &Machine, axis: Axis) -> bool {
    machine.joints_of(axis).next().is_some()
}

/// The machine's limits, widened by what a position that is shown may lie beyond them.
fn reach(scene: &Scene, dynamics: &Dynamics) -> Reach {
    let mut reach = Reach::of_limits(scene);
    for (i, resolution) in dynamics.resolution.into_iter().enumerate() {
        reach.axes.low.0[i] -= LIMIT_RESOLUTIONS * resolution;
        reach.axes.high.0[i] += LIMIT_RESOLUTIONS * resolution;
    }
    reach
}

/// `e`: how wrong the velocity over an interval may be. Both positions are wrong by up to `resolution`, and the interval by up to `jitter_s`, which is
/// less than it.
pub(crate) fn velocity_error(velocity: f64, resolution: f64, interval_s: f64, jitter_s: f64) -> f64 {
    (velocity.abs() * jitter_s + 2.0 * resolution) / (interval_s - jitter_s)
}

/// Nothing to reuse yet.
fn fresh() -> [Proximity; 2] {
    [Proximity::keeping(KEPT), Proximity::default()]
}

/// `H`: how far ahead a sample is judged, s.
fn horizon_s(scene: &Scene, rule: &Rule, state: &State) -> f64 {
    let Rule { dynamics, deadline_s, .. } = rule;
    let brake = |axis: Axis| {
        let i = axis as usize;
        let speed = state.velocity[axis].abs() + state.velocity_error[axis];
        let fastest = speed + dynamics.acceleration[i] * (deadline_s + 2.0 * state.interval_s);
        fastest / dynamics.deceleration[i]
    };
    let moved = Axis::ALL.into_iter().filter(|&axis| is_driven(&scene.machine, axis));
    deadline_s + 0.5 * moved.map(brake).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
