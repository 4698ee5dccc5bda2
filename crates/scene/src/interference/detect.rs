//! Whether a tool at a pose interferes with the surface.
//!
//! An octant is tested against the boxes of level 1 and then of level 2, by the separating-axis test. Only octants that meet a body's boxes
//! are divided, and their children are tested only against the bodies they met. In a gray leaf, every point is transformed to the tool's
//! frame and compared with the profiles of the bodies. Wang (2006); the order of the tests follows its abstract.

use super::octree::{SurfaceOctree, Visit};
use super::profile::{P2, Profile};
use super::tool::{BodyKind, BoxedTool, ToolBox};
use crate::geometry::separating_axes::{separated, widened_abs};
use crate::geometry::{Isometry, Point, Vector, rigid};
use nalgebra::Matrix3;

/// How the search finds the leaves near the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// Tests every point, without boxes.
    Points,
    /// Tests every gray leaf.
    Leaves,
    /// Descends the octree.
    Octree,
}

impl Search {
    /// Name of the search in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Leaves => "leaves",
            Self::Octree => "octree",
        }
    }
}

/// How close the surface may come to the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowance {
    /// Permitted depth of the cutter in the surface, mm.
    pub gouge_mm: f64,
    /// Required distance of shank and holder from the surface, mm.
    pub clearance_mm: f64,
}

impl Allowance {
    /// Signed distance below which a body interferes, mm.
    fn of(&self, kind: BodyKind) -> f64 {
        if kind.is_local() { -self.gouge_mm } else { self.clearance_mm }
    }
}

/// A place where a tool interferes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The body.
    pub body: BodyKind,
    /// The sample, mm, in the surface's frame.
    pub point: Point,
    /// The triangle on which the sample lies.
    pub face: u32,
    /// How much closer than permitted the sample is, mm.
    pub depth_mm: f64,
}

/// Operation counts of queries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Separating-axis tests against boxes of level 1.
    pub first_level: u64,
    /// Separating-axis tests against boxes of level 2.
    pub second_level: u64,
    /// Points compared with profiles.
    pub points: u64,
    /// Queries that the last colliding leaf or its neighbours answered.
    pub recalled: u64,
}

impl Counts {
    /// Separating-axis tests of both levels.
    pub const fn box_tests(&self) -> u64 {
        self.first_level + self.second_level
    }
}

/// State kept from one pose of a path to the next: the leaf in which the tool last interfered. A query starts with that leaf and the leaves
/// that touch it, nearest first. If none of them interferes, a full search follows.
#[derive(Clone, Debug, Default)]
pub struct Coherence {
    last: Option<(Visit, Vec<Visit>)>,
}

/// A prepared body, with boxes that include all allowances.
struct Prepared<'a> {
    kind: BodyKind,
    profile: &'a Profile,
    allowance: f64,
    first: ToolBox,
    second: Vec<ToolBox>,
}

/// Added to the covering radius in safe mode, mm. It covers the displacement of mesh vertices that the ground truth snaps to its grid
/// (2^-27 √3 mm each), and the rounding of a profile that is derived from a mesh ([`super::revolved`]).
pub const SLACK_MM: f64 = 1e-6;

/// A tool and a surface, ready for queries.
pub struct Detector<'a> {
    surface: &'a SurfaceOctree,
    bodies: Vec<Prepared<'a>>,
    search: Search,
    leaves: Vec<Visit>,
}

/// A set of bodies, a bit each.
type Bodies = u32;

/// A pose: constants of all separating-axis tests.
struct Posed {
    /// Maps directions of the surface's frame to the tool's frame.
    rotation: Matrix3<f64>,
    shift: Vector,
    widened: Matrix3<f64>,
}

impl Posed {
    fn new(tool_from_surface: &Isometry) -> Self {
        let rotation = rigid::rotation(tool_from_surface);
        Self { rotation, shift: tool_from_surface.translation.vector, widened: widened_abs(&rotation) }
    }

    /// A point of the surface's frame, in the tool's frame.
    fn in_tool(&self, place: &Point) -> Vector {
        self.rotation * place.coords + self.shift
    }

    fn meets(&self, tool: &ToolBox, octant_centre_in_tool: &Vector, half: f64) -> bool {
        let t = octant_centre_in_tool - tool.centre;
        !separated(&t, &self.rotation, &self.widened, &tool.half, &Vector::repeat(half))
    }
}

impl<'a> Detector<'a> {
    /// Prepares a tool. In safe mode the tool is widened by the samples' covering radius, so that no part of the surface between samples is
    /// missed; otherwise only the samples count.
    ///
    /// # Panics
    /// When the tool has more than 32 bodies.
    pub fn new(
        surface: &'a SurfaceOctree,
        tool: &'a BoxedTool,
        allowance: Allowance,
        is_safe: bool,
        search: Search,
    ) -> Self {
        let added = if is_safe { surface.covering_mm + SLACK_MM } else { 0.0 };
        let prepare = |(body, first, second): (&'a super::Body, &ToolBox, &[ToolBox])| {
            let allowance = allowance.of(body.kind) + added;
            Prepared {
                kind: body.kind,
                profile: &body.profile,
                allowance,
                first: first.widened(allowance),
                second: second.iter().map(|b| b.widened(allowance)).collect(),
            }
        };
        let bodies: Vec<Prepared> = tool.bodies().map(prepare).collect();
        assert!(bodies.len() <= Bodies::BITS as usize, "a tool has at most 32 bodies");
        let leaves = if search == Search::Leaves { surface.leaves() } else { Vec::new() };
        Self { surface, bodies, search, leaves }
    }

    fn all_bodies(&self) -> Bodies {
        ((1_u64 << self.bodies.len()) - 1) as Bodies
    }

    /// Distance of a point from the nearest body, minus that body's permitted distance, mm.
    fn beyond_mm(&self, place: &P2) -> f64 {
        self.bodies.iter().map(|body| -body.depth_mm(place)).fold(f64::INFINITY, f64::min)
    }

    /// Whether the tool interferes; returns the first interfering place found. `coherence` may come from any earlier pose; with `None`
    /// every query is a full search.
    pub fn first(
        &self,
        tool_from_surface: &Isometry,
        coherence: Option<&mut Coherence>,
        counts: &mut Counts,
    ) -> Option<Hit> {
        let posed = Posed::new(tool_from_surface);
        let all = self.all_bodies();
        let mut found = None;
        let mut stop_at_first = |hit: Hit| {
            found = Some(hit);
            true
        };
        let Some(coherence) = coherence else {
            self.search(&posed, all, counts, &mut stop_at_first);
            return found;
        };
        if let Some((leaf, around)) = &coherence.last {
            for near in std::iter::once(leaf).chain(around) {
                if self.leaf(&posed, near, self.meeting(&posed, near, all, counts), counts, &mut stop_at_first) {
                    counts.recalled += 1;
                    let is_other = near.node != leaf.node;
                    let near = *near;
                    if is_other {
                        coherence.last = Some((near, self.surface.neighbours(&near)));
                    }
                    return found;
                }
            }
        }
        let at = self.search(&posed, all, counts, &mut stop_at_first);
        coherence.last = at.map(|leaf| (leaf, self.surface.neighbours(&leaf)));
        found
    }

    /// The deepest place of each kind of body that interferes, so local and global interference are reported separately.
    pub fn deepest(&self, tool_from_surface: &Isometry, counts: &mut Counts) -> Vec<Hit> {
        let posed = Posed::new(tool_from_surface);
        let all = self.all_bodies();
        let mut deepest: Vec<Hit> = Vec::new();
        self.search(&posed, all, counts, &mut |hit| {
            match deepest.iter_mut().find(|known| known.body == hit.body) {
                Some(known) if known.depth_mm >= hit.depth_mm => {}
                Some(known) => *known = hit,
                None => deepest.push(hit),
            }
            false
        });
        deepest.sort_by_key(|hit| hit.body);
        deepest
    }

    /// Passes every interfering place to `take` until it returns true; returns the leaf of the last place in that case.
    fn search(
        &self,
        posed: &Posed,
        all: Bodies,
        counts: &mut Counts,
        take: &mut dyn FnMut(Hit) -> bool,
    ) -> Option<Visit> {
        match self.search {
            Search::Points => {
                let everything = 0..self.surface.points().len();
                let root = self.surface.root();
                self.points(posed, everything, all, counts, take).then_some(root)
            }
            Search::Leaves => self
                .leaves
                .iter()
                .find(|leaf| self.leaf(posed, leaf, self.meeting(posed, leaf, all, counts), counts, take))
                .copied(),
            Search::Octree => {
                let root = self.surface.root();
                let mut stack = vec![(root, self.meeting(posed, &root, all, counts))];
                while let Some((visit, bodies)) = stack.pop() {
                    if bodies == 0 {
                        continue;
                    }
                    if self.surface.is_leaf(&visit) {
                        if self.leaf(posed, &visit, bodies, counts, take) {
                            return Some(visit);
                        }
                    } else {
                        let children = self.surface.children(&visit);
                        stack.extend(children.map(|child| (child, self.meeting(posed, &child, bodies, counts))));
                    }
                }
                None
            }
        }
    }

    /// The bodies of `among` whose boxes the octant meets.
    fn meeting(&self, posed: &Posed, visit: &Visit, among: Bodies, counts: &mut Counts) -> Bodies {
        let centre = posed.in_tool(&visit.octant.centre);
        let half = visit.octant.half;
        let mut meeting = 0;
        for (index, body) in self.bodies.iter().enumerate().filter(|(index, _)| among >> index & 1 == 1) {
            counts.first_level += 1;
            if !posed.meets(&body.first, &centre, half) {
                continue;
            }
            let meets = |b: &ToolBox| {
                counts.second_level += 1;
                posed.meets(b, &centre, half)
            };
            if body.second.is_empty() || body.second.iter().any(meets) {
                meeting |= 1 << index;
            }
        }
        meeting
    }

    fn leaf(
        &self,
        posed: &Posed,
        leaf: &Visit,
        bodies: Bodies,
        counts: &mut Counts,
        take: &mut dyn FnMut(Hit) -> bool,
    ) -> bool {
        bodies != 0 && self.points(posed, self.surface.range(leaf), bodies, counts, take)
    }

    fn points(
        &self,
        posed: &Posed,
        range: std::ops::Range<usize>,
        bodies: Bodies,
        counts: &mut Counts,
        take: &mut dyn FnMut(Hit) -> bool,
    ) -> bool {
        for index in range {
            let point = self.surface.points()[index];
            let place = half_plane(&posed.in_tool(&point));
            for body in self.bodies.iter().enumerate().filter(|(i, _)| bodies >> i & 1 == 1).map(|(_, body)| body) {
                counts.points += 1;
                if !body.may_reach(&place) {
                    continue;
                }
                let depth_mm = body.depth_mm(&place);
                if depth_mm > 0.0 && take(Hit { body: body.kind, point, face: self.surface.faces()[index], depth_mm }) {
                    return true;
                }
            }
        }
        false
    }

    /// The smallest distance of a sample from a body minus that body's permitted distance, mm. Negative when the tool interferes;
    /// `below_mm` when no sample is nearer than that. Uses branch and bound: a sample is nearer than the middle of its octant by at most
    /// half the octant's diagonal.
    pub fn least_mm(&self, tool_from_surface: &Isometry, below_mm: f64, counts: &mut Counts) -> f64 {
        let posed = Posed::new(tool_from_surface);
        let mut apart = |place: &Point| {
            counts.points += self.bodies.len() as u64;
            let place = half_plane(&posed.in_tool(place));
            self.beyond_mm(&place)
        };
        let mut bound = |visit: &Visit| apart(&visit.octant.centre) - 3f64.sqrt() * visit.octant.half;
        let (root, mut least) = (self.surface.root(), below_mm);
        let mut stack = vec![(bound(&root), root)];
        let mut leaves = Vec::new();
        while let Some((at_least, visit)) = stack.pop() {
            if at_least >= least {
                continue;
            }
            if self.surface.is_leaf(&visit) {
                leaves.push(visit);
                for point in &self.surface.points()[self.surface.range(&visit)] {
                    let place = half_plane(&posed.in_tool(point));
                    least = least.min(self.beyond_mm(&place));
                }
            } else {
                let first = stack.len();
                stack.extend(self.surface.children(&visit).map(|child| (bound(&child), child)));
                // The nearest last, which is taken first.
                stack[first..].sort_by(|(x, _), (y, _)| y.total_cmp(x));
            }
        }
        let in_leaves: usize = leaves.iter().map(|leaf| self.surface.range(leaf).len()).sum();
        counts.points += (in_leaves * self.bodies.len()) as u64;
        least
    }
}

/// Bound on the rounding error of signed distances of profiles, mm.
const DISTANCE_ROUNDING_MM: f64 = 1e-9;

impl Prepared<'_> {
    /// Whether a point may interfere, by the rectangle around the profile; rejects most points of a leaf cheaply.
    fn may_reach(&self, place: &P2) -> bool {
        let [low, high] = self.profile.span_mm();
        let across = (place.x - self.profile.radius_mm()).max(0.0);
        let along = (low - place.y).max(place.y - high).max(0.0);
        let allowed = self.allowance + DISTANCE_ROUNDING_MM;
        (allowed > 0.0 && across * across + along * along <= allowed * allowed) || (across == 0.0 && along == 0.0)
    }

    /// How far a point is inside the permitted distance, mm; negative when it does not interfere.
    fn depth_mm(&self, place: &P2) -> f64 {
        self.allowance - self.profile.signed_distance_mm(place)
    }
}

/// A point of the tool's frame as (ρ, z).
fn half_plane(place: &Vector) -> P2 {
    P2::new((place.x * place.x + place.y * place.y).sqrt(), place.z)
}

#[cfg(test)]
mod tests;
