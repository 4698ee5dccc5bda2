//! Does a tool, at a pose, come too near to the surface?
//!
//! An octant is held against the tool's boxes of level 1, then of level 2, by the separating-axis test; only octants that meet a body's boxes
//! are divided, and only against the bodies they meet. In a gray leaf every point is taken into the tool's frame and held against the bodies'
//! profiles. Wang (2006); the order of the tests follows its abstract.

use super::octree::{SurfaceOctree, Visit};
use super::profile::{P2, Profile};
use super::tool::{BodyKind, BoxedTool, ToolBox};
use crate::geometry::{Isometry, Point, Vector};
use crate::volume::separating_axes::{separated, widened_abs};
use nalgebra::Matrix3;

/// How far octants are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// Every point, without boxes.
    Points,
    /// Every gray leaf.
    Leaves,
    /// Down the octree.
    Octree,
}

impl Search {
    /// Its name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Leaves => "leaves",
            Self::Octree => "octree",
        }
    }
}

/// How near the surface may come to the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowance {
    /// How deep the cutter may go into the surface, mm.
    pub gouge_mm: f64,
    /// How far shank and holder must stay away, mm.
    pub clearance_mm: f64,
}

impl Allowance {
    /// Signed distance below which a body interferes, mm.
    fn of(&self, kind: BodyKind) -> f64 {
        if kind.is_local() { -self.gouge_mm } else { self.clearance_mm }
    }
}

/// Where a tool interferes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The body.
    pub body: BodyKind,
    /// The sample, mm, in the surface's frame.
    pub point: Point,
    /// The triangle it lies on.
    pub face: u32,
    /// How much nearer than allowed it is, mm.
    pub depth_mm: f64,
}

/// What a query costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Separating-axis tests against boxes of level 1.
    pub first_level: u64,
    /// The same of level 2.
    pub second_level: u64,
    /// Points held against profiles.
    pub points: u64,
    /// Queries that the last colliding leaf or its neighbours answered.
    pub recalled: u64,
}

impl Counts {
    /// Separating-axis tests of both levels.
    #[must_use]
    pub const fn box_tests(&self) -> u64 {
        self.first_level + self.second_level
    }
}

/// What is kept from one pose of a path to the next: the leaf in which the tool interfered last. A query begins with it and the leaves that
/// touch it, nearest first; when they say nothing, it goes on as a fresh one.
#[derive(Clone, Debug, Default)]
pub struct Coherence {
    last: Option<(Visit, Vec<Visit>)>,
}

/// A body prepared: its boxes with all allowances in them.
struct Prepared<'a> {
    kind: BodyKind,
    profile: &'a Profile,
    allowance: f64,
    first: ToolBox,
    second: Vec<ToolBox>,
}

/// What safe mode adds to the covering radius, mm: more than meshes are moved when the truth puts their vertices on its grid (2^-27 √3 mm
/// each), and when a profile is found from a mesh ([`super::revolved`]).
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
    /// Takes directions of the surface's frame to the tool's.
    rotation: Matrix3<f64>,
    shift: Vector,
    widened: Matrix3<f64>,
}

impl Posed {
    fn new(tool_from_surface: &Isometry) -> Self {
        let rotation = tool_from_surface.rotation.to_rotation_matrix().into_inner();
        Self { rotation, shift: tool_from_surface.translation.vector, widened: widened_abs(&rotation) }
    }

    /// A place of the surface's frame in the tool's.
    fn in_tool(&self, place: &Point) -> Vector {
        self.rotation * place.coords + self.shift
    }

    fn meets(&self, tool: &ToolBox, octant_centre_in_tool: &Vector, half: f64) -> bool {
        let t = octant_centre_in_tool - tool.centre;
        !separated(&t, &self.rotation, &self.widened, &tool.half, &Vector::repeat(half))
    }
}

impl<'a> Detector<'a> {
    /// Prepares a tool. In safe mode it is widened by the samples' covering radius, so that nothing of the surface that comes too near is missed
    /// between them; without, only the samples count.
    ///
    /// # Panics
    /// Of a tool of more than 32 bodies.
    #[must_use]
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

    /// Whether anything interferes: the first place found. `coherence` may be of any earlier pose; without one every query is fresh.
    pub fn first(
        &self,
        tool_from_surface: &Isometry,
        coherence: Option<&mut Coherence>,
        counts: &mut Counts,
    ) -> Option<Hit> {
        let posed = Posed::new(tool_from_surface);
        let all = ((1_u64 << self.bodies.len()) - 1) as Bodies;
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

    /// For each kind of body that interferes, the deepest place; local interference and global apart.
    pub fn deepest(&self, tool_from_surface: &Isometry, counts: &mut Counts) -> Vec<Hit> {
        let posed = Posed::new(tool_from_surface);
        let all = ((1_u64 << self.bodies.len()) - 1) as Bodies;
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

    /// Offers every interfering place to `take` until it says that it is enough; the leaf of the last one then.
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
            Search::Octree => self.descend(posed, all, counts, take),
        }
    }

    fn descend(
        &self,
        posed: &Posed,
        all: Bodies,
        counts: &mut Counts,
        take: &mut dyn FnMut(Hit) -> bool,
    ) -> Option<Visit> {
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

    /// Which of the bodies an octant meets.
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
                let depth_mm = body.depth_mm(&place);
                if depth_mm > 0.0 && take(Hit { body: body.kind, point, face: self.surface.faces()[index], depth_mm }) {
                    return true;
                }
            }
        }
        false
    }

    /// The least distance of a sample from a body less what the body is allowed, mm: negative where something interferes, `below_mm`
    /// where nothing is nearer than that. By branch and bound: a sample is at most half an octant's diagonal nearer than its middle.
    pub fn least_mm(&self, tool_from_surface: &Isometry, below_mm: f64, counts: &mut Counts) -> f64 {
        let posed = Posed::new(tool_from_surface);
        let mut apart = |place: &Point| {
            counts.points += self.bodies.len() as u64;
            let place = half_plane(&posed.in_tool(place));
            self.bodies.iter().map(|body| -body.depth_mm(&place)).fold(f64::INFINITY, f64::min)
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
                    least = self.bodies.iter().map(|body| -body.depth_mm(&place)).fold(least, f64::min);
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

impl Prepared<'_> {
    /// How much nearer than allowed a place is, mm; negative when it is farther.
    fn depth_mm(&self, place: &P2) -> f64 {
        self.allowance - self.profile.signed_distance_mm(place)
    }
}

/// A place in the tool's frame as (ρ, z).
fn half_plane(place: &Vector) -> P2 {
    P2::new(place.x.hypot(place.y), place.z)
}

#[cfg(test)]
mod tests {
    use super::super::{Body, Division, Samples, SecondLevel, Tool};
    use super::*;
    use crate::conformance::meshes;
    use crate::geometry::Mesh;
    use crate::truth::PairOracle;
    use std::sync::Arc;

    fn tool() -> Tool {
        Tool {
            bodies: vec![
                Body { kind: BodyKind::Cutter, profile: Profile::bull_nose(2.0, 0.5, 6.0).unwrap() },
                Body { kind: BodyKind::Shank, profile: Profile::cone(2.0, 3.0, 4.0).unwrap().raised(6.0) },
                Body { kind: BodyKind::Holder, profile: Profile::cylinder(5.0, 6.0).unwrap().raised(10.0) },
            ],
        }
    }

    fn surface(spacing: f64) -> (Mesh, SurfaceOctree) {
        let mesh = meshes::torus(12.0, 4.0, 40, 20);
        let octree = SurfaceOctree::new(Samples::of(&mesh, spacing), Division { cap: 8, depth: 10 }, &|_| false);
        (mesh, octree)
    }

    /// From free over grazing to deep, in all directions.
    fn poses() -> Vec<Isometry> {
        (0..400)
            .map(|k| {
                let k = f64::from(k);
                let turn = Vector::new(1.3 * (0.37 * k).sin(), 1.1 * (0.53 * k).cos(), 0.2 * k);
                let pose = Isometry::new(Vector::zeros(), turn);
                let at = Point::new(12.0 * (0.05 * k).cos(), 12.0 * (0.05 * k).sin(), 4.5 + 3.0 * (0.29 * k).sin());
                // The tip near that place.
                Isometry::from_parts((-(pose * at).coords).into(), pose.rotation)
            })
            .collect()
    }

    const NONE: Allowance = Allowance { gouge_mm: 0.0, clearance_mm: 0.0 };

    #[test]
    fn all_searches_and_levels_say_what_the_points_say() {
        let (_, surface) = surface(0.7);
        let tool = tool();
        for allowance in [NONE, Allowance { gouge_mm: 0.3, clearance_mm: 1.5 }] {
            let plain = BoxedTool::new(tool.clone(), SecondLevel::None);
            let points = Detector::new(&surface, &plain, allowance, false, Search::Points);
            let (mut hits, mut global) = (0, 0);
            for level in SecondLevel::ALL {
                let boxed = BoxedTool::new(tool.clone(), level);
                for search in [Search::Leaves, Search::Octree] {
                    let detector = Detector::new(&surface, &boxed, allowance, false, search);
                    let mut coherence = Coherence::default();
                    for pose in poses() {
                        let (mut by_points, mut counts, mut warm) =
                            (Counts::default(), Counts::default(), Counts::default());
                        let expected = points.deepest(&pose, &mut by_points);
                        // Of equally deep places either may be told.
                        let depths = |hits: &[Hit]| hits.iter().map(|hit| (hit.body, hit.depth_mm)).collect::<Vec<_>>();
                        assert_eq!(depths(&detector.deepest(&pose, &mut counts)), depths(&expected));
                        assert_eq!(detector.first(&pose, None, &mut counts).is_some(), !expected.is_empty());
                        assert_eq!(
                            detector.first(&pose, Some(&mut coherence), &mut warm).is_some(),
                            !expected.is_empty()
                        );
                        assert_eq!(by_points.points, (surface.points().len() * 3) as u64);
                        hits += usize::from(!expected.is_empty());
                        global += expected.iter().filter(|hit| !hit.body.is_local()).count();
                    }
                }
            }
            assert!(hits > 800 && hits < 2800 && global > 20, "{hits}, {global}");
        }
    }

    #[test]
    fn a_known_gouge_has_its_depth_and_a_known_holder_its_clearance() {
        let samples = Samples { points: vec![Point::origin()], faces: vec![7], covering_mm: 0.25, spacing_mm: 0.4 };
        let surface = SurfaceOctree::new(samples, Division::default(), &|_| false);
        let tool = BoxedTool::new(tool(), SecondLevel::Profile4);
        let depths = |x: f64, z: f64, allowance: Allowance, safe: bool| {
            let detector = Detector::new(&surface, &tool, allowance, safe, Search::Octree);
            let found = detector.deepest(&Isometry::translation(x, 0.0, z), &mut Counts::default());
            found.into_iter().map(|hit| (hit.body, (hit.depth_mm * 1e9).round() / 1e9, hit.face)).collect::<Vec<_>>()
        };
        // The point 0.05 above the tip, on the axis.
        assert_eq!(depths(0.0, 0.05, NONE, false), [(BodyKind::Cutter, 0.05, 7)]);
        assert_eq!(depths(0.0, 0.05, Allowance { gouge_mm: 0.06, clearance_mm: 0.0 }, false), []);
        assert_eq!(depths(0.0, -0.05, NONE, false), []);
        // The covering radius of 0.25, and the slack.
        assert_eq!(depths(0.0, -0.05, NONE, true), [(BodyKind::Cutter, 0.2 + SLACK_MM, 7)]);
        // Beside the holder at its middle height, 1 mm away.
        assert_eq!(depths(6.0, 13.0, NONE, false), []);
        assert_eq!(
            depths(6.0, 13.0, Allowance { gouge_mm: 0.0, clearance_mm: 1.5 }, false),
            [(BodyKind::Holder, 0.5, 7)]
        );
    }

    /// The tool as a mesh, inscribed in its profiles: where it touches the surface, the safe mode must say so.
    #[test]
    fn safe_mode_misses_no_contact_of_the_meshes() {
        let (mesh, surface) = surface(1.5);
        let tool = tool();
        let outline = [
            [0.0, 0.0],
            [1.5, 0.0],
            [1.85, 0.15],
            [2.0, 0.5],
            [2.0, 6.0],
            [3.0, 10.0],
            [5.0, 10.0],
            [5.0, 16.0],
            [0.0, 16.0],
        ];
        let tool_mesh = crate::geometry::shapes::Shape::Revolve(crate::geometry::shapes::Revolve {
            profile_mm: outline.map(crate::geometry::shapes::outline::OutlinePoint::Sharp).to_vec(),
        })
        .mesh(&crate::geometry::shapes::Tessellation::default())
        .unwrap();
        let oracle = PairOracle::new(Arc::new(tool_mesh), Arc::new(mesh));
        let tool = BoxedTool::new(tool, SecondLevel::Axial4);
        let safe = Detector::new(&surface, &tool, NONE, true, Search::Octree);
        let mut touching = 0;
        for pose in poses() {
            if oracle.touches(&pose) {
                touching += 1;
                assert!(safe.first(&pose, None, &mut Counts::default()).is_some());
            }
        }
        assert!(touching > 50, "{touching}");
    }

    #[test]
    fn the_least_distance_is_that_of_all_points() {
        let (_, surface) = surface(0.7);
        let tool = BoxedTool::new(tool(), SecondLevel::None);
        let allowance = Allowance { gouge_mm: 0.1, clearance_mm: 0.5 };
        let detector = Detector::new(&surface, &tool, allowance, false, Search::Octree);
        let (mut counts, mut near) = (Counts::default(), 0);
        for pose in poses() {
            let of_body = |place: &P2| detector.bodies.iter().map(|b| -b.depth_mm(place)).fold(f64::INFINITY, f64::min);
            let of_point = |p: &Point| of_body(&half_plane(&(pose * p).coords));
            let expected = surface.points().iter().map(of_point).fold(f64::INFINITY, f64::min);
            let found = detector.least_mm(&pose, f64::INFINITY, &mut counts);
            assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
            let below = detector.least_mm(&pose, 0.3, &mut counts);
            assert!((below - expected.min(0.3)).abs() < 1e-9);
            near += usize::from(expected < 0.3);
        }
        assert!(near > 50 && near < 350, "{near}");
        // Two questions at 400 poses, 3 bodies.
        assert!(counts.points < 800 * 3 * surface.points().len() as u64 / 10, "{counts:?}");
    }

    #[test]
    fn between_samples_only_the_safe_mode_sees() {
        // A ball of 1 mm through the middle of a triangle that is known by its corners, 5.8 mm away.
        let [a, b, c] = [[0.0, 0.0], [10.0, 0.0], [5.0, 75f64.sqrt()]].map(|[x, y]| Point::new(x, y, 0.0));
        let mesh = Mesh::from_triangles(&[crate::geometry::Triangle::new(a, b, c)]).unwrap();
        let surface = SurfaceOctree::new(Samples::of(&mesh, 20.0), Division::default(), &|_| false);
        let ball = Tool { bodies: vec![Body { kind: BodyKind::Cutter, profile: Profile::ball(1.0, 5.0).unwrap() }] };
        let ball = BoxedTool::new(ball, SecondLevel::None);
        let pose = Isometry::translation(-5.0, -75f64.sqrt() / 3.0, 0.5);
        let sees = |safe| {
            let detector = Detector::new(&surface, &ball, NONE, safe, Search::Octree);
            detector.first(&pose, None, &mut Counts::default()).is_some()
        };
        assert!(!sees(false) && sees(true));
    }

    #[test]
    fn the_hierarchy_and_coherence_save_tests() {
        let (_, surface) = surface(0.5);
        let tool = BoxedTool::new(tool(), SecondLevel::None);
        let cost = |search, coherent: bool| {
            let detector = Detector::new(&surface, &tool, NONE, false, search);
            let (mut counts, mut coherence) = (Counts::default(), Coherence::default());
            for k in 0..200 {
                // Slowly along the surface, in contact all the way.
                let pose = Isometry::translation(-12.0 - 0.01 * f64::from(k), 0.0, -3.5);
                detector.first(&pose, coherent.then_some(&mut coherence), &mut counts);
            }
            counts
        };
        let (flat, tree, warm) = (cost(Search::Leaves, false), cost(Search::Octree, false), cost(Search::Octree, true));
        assert!(flat.box_tests() > 5 * tree.box_tests(), "{flat:?} {tree:?}");
        assert!(tree.box_tests() > 2 * warm.box_tests() && warm.recalled > 190, "{tree:?} {warm:?}");
    }
}
