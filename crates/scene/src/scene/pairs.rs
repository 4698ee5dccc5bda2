//! Decides which parts can collide: every pair is kept, or dropped for a stated reason.
//!
//! Xu and Zhang (2011) choose the pairs by hand, from the machine's structure, the head's range and the tool's size. Here the joint tree
//! and the range of the axes decide.

use super::{Clearances, Pair, Part, Role, Scene};
use crate::geometry::{Mesh, Point};
use crate::machine::Machine;
use crate::machine::travel::Ball;
use rs274::{Axis, Position};
use std::collections::BTreeMap;
use std::fmt;

/// Range of each axis, mm and radians. Infinite for an axis without limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest positions.
    pub low: Position,
    /// Largest positions.
    pub high: Position,
}

impl Range {
    /// The range of a single position.
    pub const fn at(position: Position) -> Self {
        Self { low: position, high: position }
    }

    /// Extends the range to include `position`.
    pub fn take_in(&mut self, position: &Position) {
        for (i, &at) in position.0.iter().enumerate() {
            self.low.0[i] = self.low.0[i].min(at);
            self.high.0[i] = self.high.0[i].max(at);
        }
    }

    /// The range that the joints of a machine permit. An axis without a joint stays at zero.
    pub fn of_limits(machine: &Machine) -> Self {
        let mut range = Self::at(Position::default());
        for axis in Axis::ALL {
            [range.low[axis], range.high[axis]] = machine.axis_limits(axis).unwrap_or_default();
        }
        range
    }

    /// The range with rotary axes reduced to one turn, which gives the same poses, because a joint that turns farther repeats itself.
    fn folded(mut self, machine: &Machine) -> Self {
        for axis in Axis::ALL {
            if let Some(turn) = machine.full_turn(axis)
                && self.high[axis] - self.low[axis] > turn
            {
                let low = [self.low[axis], self.high[axis] - turn].into_iter().find(|x| x.is_finite());
                self.low[axis] = low.unwrap_or(-0.5 * turn);
                self.high[axis] = self.low[axis] + turn;
            }
        }
        self
    }

    /// The middle and the half width of each axis. If an end is infinite, the middle is the other end or zero, and the half width is
    /// infinite.
    fn middle_and_half(&self) -> (Position, Position) {
        let mut half = Position::default();
        let middle = std::array::from_fn(|i| {
            let (low, high) = (self.low.0[i], self.high.0[i]);
            half.0[i] = 0.5 * (high - low);
            let ends = [f64::midpoint(low, high), low, high, 0.0];
            ends.into_iter().find(|x| x.is_finite()).unwrap_or_default()
        });
        (Position(middle), half)
    }
}

/// The ranges that the axes cover, by tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// The range with any tool.
    pub axes: Range,
    /// The range while each tool is in the spindle; `None` when the tools are unknown.
    pub tools: Option<BTreeMap<u32, Range>>,
}

impl Reach {
    /// The range of the machine's limits.
    pub fn of_limits(scene: &Scene) -> Self {
        Self { axes: Range::of_limits(&scene.machine), tools: None }
    }

    /// The range while a tool is in the spindle; `None` if the tool is never there.
    fn with_tool(&self, tool: u32) -> Option<&Range> {
        self.tools.as_ref().map_or(Some(&self.axes), |tools| tools.get(&tool))
    }
}

/// Why a pair is not examined.
#[derive(Clone, Debug, PartialEq)]
pub enum Dropped {
    /// No joint lies between the parts.
    Rigid,
    /// Two parts of the machine's structure, of no tool, with one joint between them: the joint's bearings touch by construction.
    Neighbours {
        /// The joint's axis.
        axis: char,
    },
    /// Over the whole range, the parts stay farther apart than their widest clearance.
    OutOfReach {
        /// Lower bound of their distance, mm.
        apart_mm: f64,
    },
    /// The parts belong to different tools, and only one tool is in the spindle at a time.
    DifferentTools {
        /// The tools.
        tools: [u32; 2],
    },
    /// The tool of the parts is never in the spindle.
    NeverMounted {
        /// The tool.
        tool: u32,
    },
    /// The scene says that the pair is ignored.
    Ignored,
    /// The scene says that the parts may touch.
    Allowed,
}

impl Dropped {
    /// Whether the reason holds for every program, so the pair was not examined at all. A pair out of reach, in contrast, is known to be
    /// free for this program.
    pub const fn is_for_ever(&self) -> bool {
        match self {
            Self::Rigid | Self::Neighbours { .. } | Self::DifferentTools { .. } | Self::Ignored => true,
            Self::OutOfReach { .. } | Self::NeverMounted { .. } | Self::Allowed => false,
        }
    }
}

impl fmt::Display for Dropped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rigid => write!(f, "no joint between them"),
            Self::Neighbours { axis } => write!(f, "neighbours at axis {axis}"),
            Self::OutOfReach { apart_mm } => write!(f, "never nearer than {apart_mm:.0} mm"),
            Self::DifferentTools { tools: [one, other] } => {
                write!(f, "tools {one} and {other} are never there together")
            }
            Self::NeverMounted { tool } => write!(f, "tool {tool} is never in the spindle"),
            Self::Ignored => write!(f, "ignored by the scene"),
            Self::Allowed => write!(f, "may touch, says the scene"),
        }
    }
}

/// A pair, and the reason for which it was dropped, if it was.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The pair.
    pub pair: Pair,
    /// Why it is not examined; `None` when it is.
    pub dropped: Option<Dropped>,
}

/// Decides on every pair of parts, in order. `reach` gives the ranges of the axes; pairs that stay farther apart than their widest clearance are
/// dropped. Pairs that the scene names are kept unless they are ignored, allowed, out of reach, or belong to a tool that is never mounted.
pub fn decide(scene: &Scene, reach: &Reach, clearances: &Clearances) -> Vec<Decision> {
    let balls: Vec<Ball> = scene.parts.iter().map(ball).collect();
    let pairs = (0..scene.parts.len()).flat_map(|a| (a + 1..scene.parts.len()).map(move |b| Pair { a, b }));
    let decide = |pair: Pair| {
        let beyond_mm = clearances.widest_mm(&scene.parts, pair);
        Decision { pair, dropped: why_dropped(scene, &balls, reach, beyond_mm, pair) }
    };
    pairs.map(decide).collect()
}

fn why_dropped(scene: &Scene, balls: &[Ball], reach: &Reach, beyond_mm: f64, pair: Pair) -> Option<Dropped> {
    let is_in = |pairs: &[Pair]| pairs.iter().any(|other| other.is(pair));
    if is_in(&scene.ignored) {
        return Some(Dropped::Ignored);
    }
    if is_in(&scene.allowed) {
        return Some(Dropped::Allowed);
    }
    let bodies = [pair.a, pair.b].map(|part| scene.machine.rigid_body(scene.parts[part].link));
    if bodies[0] == bodies[1] {
        return Some(Dropped::Rigid);
    }
    if let [Some(one), Some(other)] = [pair.a, pair.b].map(|part| scene.parts[part].tool)
        && one != other
    {
        return Some(Dropped::DifferentTools { tools: [one, other] });
    }
    let range = match scene.tool_of(pair) {
        None => &reach.axes,
        Some(tool) => match reach.with_tool(tool) {
            Some(range) => range,
            None => return Some(Dropped::NeverMounted { tool }),
        },
    };
    if let Some(apart_mm) = least_distance(scene, balls, pair, range).filter(|&apart| apart > beyond_mm) {
        return Some(Dropped::OutOfReach { apart_mm });
    }
    let is_structure = |part: &Part| part.role == Role::Machine && part.tool.is_none();
    let is_structure = [pair.a, pair.b].iter().all(|&part| is_structure(&scene.parts[part]));
    (is_structure && !scene.names(pair)).then(|| neighbours(scene, bodies)).flatten()
}

/// The axis between two adjacent bodies of the machine. Only the structure has bearings, so parts that cut, hold, are cut or belong to a tool
/// have no neighbours.
fn neighbours(scene: &Scene, bodies: [Option<usize>; 2]) -> Option<Dropped> {
    let stands_on = |above: Option<usize>, below: Option<usize>| {
        let above = above?;
        let is_next = scene.machine.rigid_body(scene.machine.parent(above)) == below;
        let joint = scene.machine.links()[above].joint.as_ref()?;
        is_next.then(|| Dropped::Neighbours { axis: joint.axis.letter() })
    };
    stands_on(bodies[0], bodies[1]).or_else(|| stands_on(bodies[1], bodies[0]))
}

/// A lower bound of the distance of a pair over a range, mm; `None` when the range gives no bound.
fn least_distance(scene: &Scene, balls: &[Ball], pair: Pair, range: &Range) -> Option<f64> {
    let (middle, half) = range.folded(&scene.machine).middle_and_half();
    let poses = scene.machine.forward(&middle);
    let (a, b) = (&balls[pair.a], &balls[pair.b]);
    let between = (poses.world_from(a.link) * a.centre - poses.world_from(b.link) * b.centre).norm();
    let apart = between - a.radius - b.radius - scene.machine.shift_bound_mm(a, b, &poses, &half);
    apart.is_finite().then_some(apart)
}

/// The ball around a part's bounding box.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Isometry, Point, Vector};
    use crate::machine::{Joint, Limits, Link};
    use std::f64::consts::TAU;

    fn link(name: &str, at: [f64; 3], joint: Joint) -> Link {
        Link {
            name: name.to_owned(),
            parent: None,
            parent_from_link: Isometry::translation(at[0], at[1], at[2]),
            joint: Some(joint),
        }
    }

    /// A machine with separate axes X (from -10 to 30) and C, and a rotary axis W.
    fn machine(x: Limits, c: Limits) -> Machine {
        let turn = |axis, limits| Joint::rotary(axis, Vector::z(), Point::origin(), limits).unwrap();
        let x = Joint::prismatic(Axis::X, Vector::x(), x).unwrap();
        let w = Limits { min: -TAU / 4.0, max: TAU / 4.0 };
        Machine::new(vec![
            link("x", [0.0; 3], x),
            link("c", [100.0, 0.0, 0.0], turn(Axis::C, c)),
            link("w", [0.0; 3], turn(Axis::W, w)),
        ])
        .unwrap()
    }

    #[test]
    fn ranges_are_in_the_units_of_the_axes_and_turns_are_folded() {
        let forty = Limits { min: -10.0, max: 30.0 };
        let range = Range::of_limits(&machine(forty, Limits::NONE));
        assert_eq!((range.low[Axis::X], range.high[Axis::X]), (-10.0, 30.0));
        // A quarter turn either way of an axis that turns a degree per mm is 90 mm.
        assert!((range.low[Axis::W] + 90.0).abs() < 1e-9 && (range.high[Axis::W] - 90.0).abs() < 1e-9);
        assert_eq!((range.low[Axis::C], range.high[Axis::C]), (f64::NEG_INFINITY, f64::INFINITY));
        for (limits, low) in [
            (Limits::NONE, -TAU / 2.0),
            (Limits { min: 1.0, ..Limits::NONE }, 1.0),
            (Limits { max: 1.0, ..Limits::NONE }, 1.0 - TAU),
            (Limits { min: 2.0, max: 100.0 }, 2.0),
        ] {
            let machine = machine(forty, limits);
            let folded = Range::of_limits(&machine).folded(&machine);
            assert_eq!((folded.low[Axis::C], folded.high[Axis::C]), (low, low + TAU));
        }
        let (middle, half) = range.middle_and_half();
        assert_eq!((middle[Axis::X], half[Axis::X]), (10.0, 20.0));
    }

    #[test]
    fn an_unlimited_slide_hides_only_what_it_moves() {
        let bound = |x: Limits, links: [usize; 2]| {
            let machine = machine(x, Limits::NONE);
            let [a, b] = links.map(|link| Ball { link: Some(link), centre: Point::new(5.0, 0.0, 0.0), radius: 1.0 });
            let (middle, half) = Range::of_limits(&machine).folded(&machine).middle_and_half();
            let poses = machine.forward(&middle);
            let between = (poses.0[links[0]] * a.centre - poses.0[links[1]] * b.centre).norm();
            between - 2.0 - machine.shift_bound_mm(&a, &b, &poses, &half)
        };
        let forty = Limits { min: -10.0, max: 30.0 };
        // X in its middle: x = 15; C in its middle: x = 105. Radii 2; X goes 20 either way, C's ball lies 5 beside its axis and
        // is carried 10 across.
        assert!((bound(forty, [0, 1]) - (90.0 - 2.0 - 20.0 - 10.0)).abs() < 1e-9);
        assert_eq!(bound(Limits::NONE, [0, 1]), f64::NEG_INFINITY);
        // W turns by a quarter either way: 2 5 sin 45°.
        assert!((bound(Limits::NONE, [1, 2]) - (100.0 - 2.0 - 10.0 - 50f64.sqrt())).abs() < 1e-9);
    }
}
