//! Which parts can collide at all: every pair is kept or dropped for a stated reason.
//!
//! Xu and Zhang (2011) choose the pairs from the machine's structure, the head's range and the tool's size by hand; here the
//! joint tree and the range of the axes decide.

use super::{Pair, Part, Scene};
use crate::gcode::{Axis, Position};
use crate::geometry::{Mesh, Point};
use crate::machine::travel::Ball;
use std::fmt;

/// Range of each axis, mm and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest positions.
    pub low: Position,
    /// Largest positions.
    pub high: Position,
}

impl Range {
    /// The least range that holds all positions; `None` of none.
    pub fn of(positions: impl IntoIterator<Item = Position>) -> Option<Self> {
        positions.into_iter().fold(None, |range: Option<Self>, at| {
            let Self { low, high } = range.unwrap_or(Self { low: at, high: at });
            Some(Self {
                low: Position(std::array::from_fn(|i| low.0[i].min(at.0[i]))),
                high: Position(std::array::from_fn(|i| high.0[i].max(at.0[i]))),
            })
        })
    }

    /// What the joints of a scene's machine allow; `None` where an axis that drives a joint has no limits.
    #[must_use]
    pub fn of_limits(scene: &Scene) -> Option<Self> {
        let mut range = Self { low: Position::default(), high: Position::default() };
        for axis in Axis::ALL {
            let joints = scene.machine.links().iter().filter_map(|link| link.joint.as_ref());
            let limits: Vec<_> = joints.filter(|joint| joint.axis == axis).map(|joint| joint.limits).collect();
            if limits.is_empty() {
                continue;
            }
            range.low[axis] = limits.iter().map(|limits| limits.min).fold(f64::NEG_INFINITY, f64::max);
            range.high[axis] = limits.iter().map(|limits| limits.max).fold(f64::INFINITY, f64::min);
        }
        range.low.0.iter().chain(&range.high.0).all(|x| x.is_finite()).then_some(range)
    }
}

/// Why a pair is not examined.
#[derive(Clone, Debug, PartialEq)]
pub enum Dropped {
    /// No joint is between them.
    Rigid,
    /// One joint is between them: its bearings touch by construction.
    Neighbours {
        /// The joint's axis.
        axis: char,
    },
    /// Over the whole range they stay farther apart than asked for.
    OutOfReach {
        /// At least this far, mm.
        apart_mm: f64,
    },
    /// The scene says so.
    Ignored,
}

impl fmt::Display for Dropped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rigid => write!(f, "no joint between them"),
            Self::Neighbours { axis } => write!(f, "neighbours at axis {axis}"),
            Self::OutOfReach { apart_mm } => write!(f, "never nearer than {apart_mm:.0} mm"),
            Self::Ignored => write!(f, "ignored by the scene"),
        }
    }
}

/// A pair with the reason for which it was dropped, if it was.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The pair.
    pub pair: Pair,
    /// Why it is not examined; `None` when it is.
    pub dropped: Option<Dropped>,
}

/// Decides on every pair of parts, in order. `range` is what the axes do, if it is known; pairs that stay farther apart than
/// `beyond_mm` are dropped. The pairs that the scene names are kept unless they are ignored or out of reach.
#[must_use]
pub fn decide(scene: &Scene, range: Option<&Range>, beyond_mm: f64) -> Vec<Decision> {
    let balls: Vec<Ball> = scene.parts.iter().map(ball).collect();
    let pairs = (0..scene.parts.len()).flat_map(|a| (a + 1..scene.parts.len()).map(move |b| Pair { a, b }));
    let decide = |pair: Pair| {
        if scene.ignored.iter().any(|ignored| ignored.is(pair)) {
            return Some(Dropped::Ignored);
        }
        let bodies = [pair.a, pair.b].map(|part| scene.machine.rigid_body(scene.parts[part].link));
        if bodies[0] == bodies[1] {
            return Some(Dropped::Rigid);
        }
        if let Some(range) = range
            && let Some(apart_mm) = least_distance(scene, &balls, pair, range).filter(|&apart| apart > beyond_mm)
        {
            return Some(Dropped::OutOfReach { apart_mm });
        }
        (!scene.names(pair)).then(|| neighbours(scene, bodies)).flatten()
    };
    pairs.map(|pair| Decision { pair, dropped: decide(pair) }).collect()
}

/// The axis between two bodies of which one stands on the other.
fn neighbours(scene: &Scene, bodies: [Option<usize>; 2]) -> Option<Dropped> {
    let stands_on = |above: Option<usize>, below: Option<usize>| {
        let above = above?;
        let is_next = scene.machine.rigid_body(scene.machine.parent(above)) == below;
        let joint = scene.machine.links()[above].joint.as_ref()?;
        is_next.then(|| Dropped::Neighbours { axis: joint.axis.letter() })
    };
    stands_on(bodies[0], bodies[1]).or_else(|| stands_on(bodies[1], bodies[0]))
}

/// A lower bound of the distance of a pair over a range, mm; may be negative.
fn least_distance(scene: &Scene, balls: &[Ball], pair: Pair, range: &Range) -> Option<f64> {
    let middle = Position(std::array::from_fn(|i| f64::midpoint(range.low.0[i], range.high.0[i])));
    let half = Position(std::array::from_fn(|i| 0.5 * (range.high.0[i] - range.low.0[i])));
    let poses = scene.machine.forward(&middle);
    let (a, b) = (&balls[pair.a], &balls[pair.b]);
    let between = (poses.world_from(a.link) * a.centre - poses.world_from(b.link) * b.centre).norm();
    let apart = between - a.radius - b.radius - scene.machine.travel_bound_mm(a, b, &poses, &half);
    apart.is_finite().then_some(apart)
}

/// The ball around a part's bounding box.
#[must_use]
pub fn ball(part: &Part) -> Ball {
    let (low, high) = bounds(&part.mesh);
    let centre = part.link_from_part * nalgebra::center(&low, &high);
    let radius = part.mesh.vertices().iter().map(|v| (part.link_from_part * v - centre).norm()).fold(0.0, f64::max);
    Ball { link: part.link, centre, radius }
}

fn bounds(mesh: &Mesh) -> (Point, Point) {
    let first = mesh.vertices().first().copied().unwrap_or_default();
    mesh.vertices().iter().fold((first, first), |(low, high), v| (low.inf(v), high.sup(v)))
}
