//! Parts that a spindle turns: in time they stand at every angle, not only at the one that is drawn.
//!
//! A part that is not round about its spindle's axis is examined twice: as drawn, and as rings that hold all that it passes when it turns. Where only the
//! rings touch something, the two may collide. On lathes the nearest joint that turns a workpiece or a fixture is a spindle, and turns all that is fixed to it. Where
//! no joint turns a round workpiece, its axis is a spindle, and turns the balanced fixtures beside it. On mills the spindle is the axis of the tool, where the scene says
//! where that is, and turns cutter, shank and holder. `turns` of a part decides otherwise.

use super::motion::Path;
use super::turning::{WorkAxis, may_be_driven};
use crate::geometry::{Isometry, Mesh, Point, Triangle, Vector};
use crate::interference::revolved::{clipped, line_to_z, nearest_to_axis};
use crate::interference::{ROUND, Revolved};
use crate::machine::{Joint, Motion};
use crate::scene::{Pair, Part, ProgramRun, Role, Scene, Turns};
use rs274::{Plane, Position};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Most rings of a part.
const RINGS: usize = 96;
/// Sides of a ring.
const SIDES: usize = 64;
/// Sine of the angle by which a face of a round part may lean around the axis: prisms with 20 sides and more are round.
const LEANING: f64 = 0.165;
/// A part is round all the same where the faces that lean more have at most this area together, of the square of its greatest radius: slivers, and what hardly stands out.
const LITTLE: f64 = 1e-4;
/// And at most this area, mm²: of a large faceplate that is little, and may be a strap that reaches into something.
const LITTLE_MM2: f64 = 1.0;
/// Corners of a round part that are the farthest from the axis at their height, or the nearest to it, differ by at most this part of their distance: one that is a little
/// eccentric, oval, slanted or wound has faces that hardly lean.
const UNEVEN: f64 = 5e-3;
/// Widest angle around the axis without a corner of a round part: that of a prism with 18 sides.
const WIDEST: f64 = TAU / 18.0;
/// Corners nearer to the axis than this, of the greatest radius, are not asked how a face leans there.
const MIDDLE: f64 = 0.01;
/// Teeth repeat themselves where they fill the same of these sectors around the axis.
const SECTORS: usize = 360;
/// By so many sectors a tooth may be beside where it repeats itself.
const OFF: usize = 5;
/// Half the angle of a sector, radians.
const HALF_SECTOR: f64 = PI / SECTORS as f64;
/// A triangle is seen edge-on from the axis up to this sine, above the rounding of the 24 bits of an STL file.
const EDGE_ON: f64 = 1e-6;
/// A tooth fills a sector where it is this far out, of the greatest radius.
const NEARLY: f64 = 0.99;
/// What a spindle turns is balanced: the middle of its surface is this near to the axis, as a part of its greatest radius.
const OFF_BALANCE: f64 = 0.05;
/// Nearer than this, mm, is the same.
const SAME_MM: f64 = 1e-6;

/// Parts that a spindle turns, and that are not round.
pub(super) struct Spun {
    /// The scene with rings in the place of these parts.
    pub scene: Scene,
    /// Which parts have rings there.
    is_turned: Vec<bool>,
    /// The link of the spindle that turns each part.
    spindles: Vec<Option<Option<usize>>>,
    /// Takes the frame of each part of a tool to one whose z is the axis about which it turns.
    axes: Vec<Option<Isometry>>,
    /// Parts that are examined as drawn alone, because the axis about which they turn is not known, or moves.
    pub as_drawn: Vec<usize>,
    /// Cutters that the tool's spindle may turn, or a drive about their own axis, and what holds them.
    pub unsure: Vec<usize>,
}

/// What turns a part.
struct TurnedBy {
    /// The link of the spindle.
    spindle: Option<usize>,
    /// Takes the part's frame to one whose z is the axis about which it turns; `None` where that is not known, or moves.
    axis_from_part: Option<Isometry>,
    /// Whether the part may turn about its own axis instead.
    is_unsure: bool,
}

impl TurnedBy {
    const fn new(spindle: Option<usize>, axis_from_part: Option<Isometry>) -> Self {
        Self { spindle, axis_from_part, is_unsure: false }
    }
}

impl Spun {
    /// Finds what turns in a program. Nothing does where it starts no spindle.
    pub fn of(scene: &Scene, run: &ProgramRun, path: &Path<'_>) -> Self {
        let count = scene.parts.len();
        let (is_turned, spindles, axes) = (vec![false; count], vec![None; count], vec![None; count]);
        let (as_drawn, unsure) = (Vec::new(), Vec::new());
        let mut spun = Self { scene: scene.clone(), is_turned, spindles, axes, as_drawn, unsure };
        if !run.program.turns_spindle {
            return spun;
        }
        let lathe = (path.first_plane() == Plane::Zx).then(|| WorkSpindles::of(scene, path));
        let tools = run.tools();
        for (number, part) in scene.parts.iter().enumerate() {
            let is_used = part.tool.is_none_or(|tool| tools.contains(&tool));
            if !is_used {
                continue;
            }
            let turned = match (part.turns, &lathe) {
                (Some(Turns::Nothing), _) => None,
                (Some(Turns::Own), _) => Some(driven(scene, number)),
                (_, Some(spindles)) => spindles.turning(scene, path, number),
                (_, None) => on_mill(scene, run, part),
            };
            let Some(TurnedBy { spindle, axis_from_part, is_unsure }) = turned else { continue };
            spun.spindles[number] = Some(spindle);
            if is_unsure {
                spun.unsure.push(number);
            }
            let Some(axis_from_part) = axis_from_part else {
                spun.as_drawn.push(number);
                continue;
            };
            spun.axes[number] = part.role.is_of_tool().then_some(axis_from_part);
            if is_round_about(&part.mesh, &axis_from_part) {
                continue;
            }
            match rings(&slabs(&part.mesh, &axis_from_part), &axis_from_part) {
                Some(mesh) => {
                    spun.scene.parts[number].mesh = Arc::new(mesh);
                    spun.is_turned[number] = true;
                }
                None => spun.as_drawn.push(number),
            }
        }
        // What holds such a cutter turns with it, or stands.
        let holds_unsure = |&number: &usize| {
            let Part { role, tool, turns, .. } = scene.parts[number];
            let is_of_tool = |&cutter: &usize| scene.parts[cutter].tool == tool;
            let is_holder = matches!(role, Role::Shank | Role::Holder) && turns.is_none();
            is_holder && spun.is_turned[number] && spun.unsure.iter().any(is_of_tool)
        };
        let holders: Vec<usize> = (0..count).filter(holds_unsure).collect();
        spun.unsure.extend(holders);
        spun
    }

    /// Whether any part has rings.
    pub fn turns_any(&self) -> bool {
        self.is_turned.contains(&true)
    }

    /// Takes the frame of a part of a tool to one whose z is the axis about which it turns, where that is known.
    pub fn axis_of(&self, part: usize) -> Option<Isometry> {
        self.axes[part]
    }

    /// Whether a part is examined as rings, because a spindle turns it and it is not round about the spindle's axis.
    pub fn is_turned(&self, part: usize) -> bool {
        self.is_turned[part]
    }

    /// Whether a part may turn about its own axis instead of that one.
    pub fn is_unsure(&self, part: usize) -> bool {
        self.unsure.contains(&part)
    }

    /// Whether a spindle turns the workpiece while the part beside it stands.
    pub fn turns_beside(&self, workpiece: usize, part: usize) -> bool {
        self.spindles[workpiece].is_some() && self.spindles[part].is_none()
    }

    /// Whether a part with rings turns against the other part of a pair, and not with it.
    pub fn turns(&self, pair: Pair) -> bool {
        (self.is_turned[pair.a] || self.is_turned[pair.b]) && self.spindles[pair.a] != self.spindles[pair.b]
    }
}

/// The spindles of a lathe.
struct WorkSpindles {
    /// The nearest joint that turns each workpiece, each fixture, such as a chuck without a workpiece, and each part with `turns = "spindle"`.
    joints: Vec<usize>,
    /// Axes of round workpieces that no joint turns.
    axes: Vec<WorkAxis>,
    /// Fixtures beside these workpieces that are balanced about their axes.
    balanced: Vec<usize>,
}

impl WorkSpindles {
    fn of(scene: &Scene, path: &Path<'_>) -> Self {
        let machine = &scene.machine;
        let of_role = |role: Role| (0..scene.parts.len()).filter(move |&part| scene.parts[part].role == role);
        let joint_of = |part: usize| {
            let joint = |link: usize| machine.links()[link].joint.as_ref();
            machine.rigid_body(scene.parts[part].link).filter(|&link| joint(link).is_some_and(Joint::turns))
        };
        // What turns a steady on a turret, or a clamp on a table that carries a spindle, is no spindle.
        let swivels = |joint: usize| {
            let carries = |other: usize| machine.chain(scene.parts[other].link).any(|link| link == joint);
            let has_own = |other: usize| joint_of(other).is_some_and(|own| own != joint);
            let is_work = |other: usize| scene.parts[other].role == Role::Workpiece;
            let matters = |&other: &usize| scene.parts[other].role.is_of_tool() || is_work(other) && has_own(other);
            (0..scene.parts.len()).filter(matters).any(carries)
        };
        let spindle_of = |number: usize| {
            let part = &scene.parts[number];
            joint_of(number).filter(|&joint| match (part.role, part.turns) {
                (Role::Workpiece, _) => true,
                (Role::Fixture, None) => !swivels(joint),
                (_, turns) => turns == Some(Turns::Spindle) && !part.role.is_of_tool(),
            })
        };
        let joints = (0..scene.parts.len()).filter_map(spindle_of).collect();
        let standing = of_role(Role::Workpiece).filter(|&part| joint_of(part).is_none());
        let axes: Vec<WorkAxis> = standing.filter_map(|part| WorkAxis::of(scene, path, part)).collect();
        let mut balanced = Vec::new();
        for axis in &axes {
            let beside = of_role(Role::Fixture).filter(|&part| is_beside(scene, axis, part));
            let all: Vec<usize> = beside.filter(|&part| scene.parts[part].turns.is_none()).collect();
            // The jaws of a chuck may be parts of their own.
            if is_balanced(scene, axis, &all) {
                balanced.extend(all);
            } else {
                balanced.extend(all.into_iter().filter(|&part| is_balanced(scene, axis, &[part])));
            }
        }
        Self { joints, axes, balanced }
    }

    /// What turns a part; `None` where nothing does.
    fn turning(&self, scene: &Scene, path: &Path<'_>, number: usize) -> Option<TurnedBy> {
        let (machine, part) = (&scene.machine, &scene.parts[number]);
        let body = machine.rigid_body(part.link);
        if let Some(spindle) = machine.chain(part.link).find(|link| self.joints.contains(link)) {
            if body != Some(spindle) {
                return Some(TurnedBy::new(Some(spindle), None));
            }
            let joint = machine.links()[spindle].joint.as_ref();
            let Some(Motion::Rotary { direction, point }) = joint.map(|joint| joint.motion) else { return None };
            let zero = machine.forward(&Position::default());
            let spindle_from_part =
                zero.world_from(Some(spindle)).inv_mul(&zero.world_from(part.link)) * part.link_from_part;
            return Some(TurnedBy::new(Some(spindle), Some(line_to_z(&point, &direction) * spindle_from_part)));
        }
        let unknown = TurnedBy::new(body, None);
        let is_said = part.turns == Some(Turns::Spindle);
        match part.role {
            Role::Workpiece | Role::Fixture => {}
            Role::Machine if is_said => {}
            Role::Machine => return None,
            // On a lathe a tool's spindle is one that drives it.
            _ if is_said => return Some(driven(scene, number)),
            _ => return holds_driven(scene, path, number).then_some(unknown),
        }
        if let Some(axis) = self.axes.iter().find(|axis| is_beside(scene, axis, number)) {
            let axis_from_part = axis_from_part(scene, axis, number);
            if part.role == Role::Workpiece || is_said || self.balanced.contains(&number) {
                return Some(TurnedBy::new(body, Some(axis_from_part)));
            }
            // It may be a chuck, or a steady that stands.
            return (!is_round_about(&part.mesh, &axis_from_part)).then_some(unknown);
        }
        (is_said || !is_round(&part.mesh)).then_some(unknown)
    }
}

/// Whether a part is not round and holds a cutter that may be driven: the drive may turn the part, too.
fn holds_driven(scene: &Scene, path: &Path<'_>, number: usize) -> bool {
    let part = &scene.parts[number];
    let place = |part: &Part| (part.tool, scene.machine.rigid_body(part.link));
    let is_driven = |cutter: usize| {
        let other = &scene.parts[cutter];
        other.role == Role::Cutter && place(other) == place(part) && may_be_driven(scene, path, cutter)
    };
    part.role != Role::Cutter && !is_round(&part.mesh) && (0..scene.parts.len()).any(is_driven)
}

/// Whether a mesh is round about its own axis.
fn is_round(mesh: &Mesh) -> bool {
    is_round_about(mesh, &Revolved::around(mesh).tool_from_mesh)
}

/// Whether a mesh is the same at every angle, in its hollows as well: hardly any of its faces lean around the axis.
fn is_round_about(mesh: &Mesh, axis_from_part: &Isometry) -> bool {
    let places: Vec<Point> = mesh.vertices().iter().map(|vertex| axis_from_part * vertex).collect();
    let radius = places.iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
    let leaning = |face: &[u32; 3]| {
        let corners = face.map(|corner| places[corner as usize]);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let outside = corners.iter().filter(|p| p.x.hypot(p.y) > MIDDLE * radius);
        let around = outside.map(|p| (normal.y * p.x - normal.x * p.y).abs() / p.x.hypot(p.y)).fold(0.0, f64::max);
        if around > LEANING * normal.norm() { 0.5 * around } else { 0.0 }
    };
    is_all_around(&places, MIDDLE * radius)
        && mesh.faces().iter().map(leaning).sum::<f64>() <= (LITTLE * radius * radius).min(LITTLE_MM2)
        && is_even(mesh, &places, MIDDLE * radius)
}

/// Whether at every height the corners that are farthest from the axis lie on all sides of it, and those that are nearest, unless nearer than `middle`.
fn is_even(mesh: &Mesh, places: &[Point], middle: f64) -> bool {
    let heights = heights(places);
    let mut slices: Vec<Vec<Point>> = vec![Vec::new(); heights.len().saturating_sub(1)];
    slice(mesh, places, &heights, |slab, _, piece| slices[slab].extend(piece));
    slices.iter().all(|corners| {
        let from_axis = |p: &Point| p.x.hypot(p.y);
        let far = corners.iter().map(from_axis).fold(0.0, f64::max);
        let near = corners.iter().map(from_axis).fold(f64::INFINITY, f64::min);
        let is_near = |p: &&Point| from_axis(p) <= near * (1.0 + UNEVEN) + SAME_MM;
        let nearest: Vec<Point> = corners.iter().filter(is_near).copied().collect();
        is_all_around(corners, far * (1.0 - UNEVEN) - SAME_MM) && (near <= middle || is_all_around(&nearest, 0.0))
    })
}

/// Whether corners farther from the axis than `middle` lie on all sides of it: on one side alone even a sliver is not round.
fn is_all_around(places: &[Point], middle: f64) -> bool {
    let outside = places.iter().filter(|p| p.x.hypot(p.y) > middle);
    let mut angles: Vec<f64> = outside.map(|p| p.y.atan2(p.x)).collect();
    angles.sort_by(f64::total_cmp);
    let Some(first) = angles.first().copied() else { return true };
    angles.push(first + TAU);
    angles.windows(2).all(|pair| pair[1] - pair[0] <= WIDEST)
}

/// Whether no joint is between a part and a workpiece's axis.
fn is_beside(scene: &Scene, axis: &WorkAxis, part: usize) -> bool {
    scene.machine.rigid_body(axis.base) == scene.machine.rigid_body(scene.parts[part].link)
}

/// Takes the frame of a part beside a workpiece's axis to that of the axis.
fn axis_from_part(scene: &Scene, axis: &WorkAxis, part: usize) -> Isometry {
    let zero = scene.machine.forward(&Position::default());
    let Part { link, link_from_part, .. } = scene.parts[part];
    axis.base_from_axis.inverse() * zero.world_from(axis.base).inv_mul(&zero.world_from(link)) * link_from_part
}

/// Whether parts are balanced together about an axis.
fn is_balanced(scene: &Scene, axis: &WorkAxis, parts: &[usize]) -> bool {
    let (mut area, mut moment, mut reach) = (0.0, Vector::zeros(), 0.0_f64);
    for &part in parts {
        let axis_from_part = axis_from_part(scene, axis, part);
        for triangle in scene.parts[part].mesh.triangles() {
            let corners = triangle.corners.map(|corner| (axis_from_part * corner).coords);
            let of_triangle = triangle.double_area_normal().norm();
            area += of_triangle;
            moment += (corners[0] + corners[1] + corners[2]) * (of_triangle / 3.0);
            reach = corners.iter().map(|corner| corner.x.hypot(corner.y)).fold(reach, f64::max);
        }
    }
    moment.x.hypot(moment.y) <= OFF_BALANCE * reach * area
}

/// Whether a mesh shows that it turns about the axis of its body of revolution: it is round about it, or it repeats itself around it and nearly fills that body.
fn is_about(mesh: &Mesh, body: &Revolved) -> bool {
    let axis = &body.tool_from_mesh;
    is_round_about(mesh, axis) || body.filled >= ROUND && repeat(&slabs(mesh, axis))
}

/// What turns a part of a mill. Parts of the tool turn, about the spindle's axis where they are fixed to the spindle.
fn on_mill(scene: &Scene, run: &ProgramRun, part: &Part) -> Option<TurnedBy> {
    let body = |link: Option<usize>| scene.machine.rigid_body(link);
    let spindle =
        run.tip.as_ref().filter(|tip| part.role.is_of_tool() && body(tip.tool_link) == body(part.link)).map(|tip| {
            let zero = scene.machine.forward(&Position::default());
            let tool_from_link = zero.world_from(tip.tool_link).inv_mul(&zero.world_from(part.link));
            line_to_z(&tip.gauge, &tip.direction) * tool_from_link * part.link_from_part
        });
    match (part.turns, spindle) {
        (None, None) if !part.role.is_of_tool() || is_round(&part.mesh) => None,
        (None, None) => {
            let own = Revolved::around(&part.mesh);
            let shown = is_about(&part.mesh, &own).then_some(own.tool_from_mesh);
            Some(TurnedBy::new(body(part.link), shown))
        }
        // The scene says that the spindle turns it, and not where that is.
        (Some(_), None) => Some(TurnedBy::new(body(part.link), None)),
        (turns, Some(axis)) => {
            let is_unsure = turns.is_none() && part.role == Role::Cutter && may_turn_itself(&part.mesh, &axis);
            Some(TurnedBy { is_unsure, ..TurnedBy::new(body(part.link), Some(axis)) })
        }
    }
}

/// A part of a tool that a drive turns. The axis is that of the part, where it is round, else that of a round part of the tool that the same drive turns.
fn driven(scene: &Scene, number: usize) -> TurnedBy {
    let zero = scene.machine.forward(&Position::default());
    let part = &scene.parts[number];
    let drive = |part: &Part| (part.tool, part.turns, scene.machine.rigid_body(part.link));
    let is_driven_too =
        |&other: &usize| scene.parts[other].role.is_of_tool() && drive(&scene.parts[other]) == drive(part);
    let mut parts: Vec<usize> = (0..scene.parts.len()).filter(is_driven_too).collect();
    parts.sort_by_key(|&other| (other != number, scene.parts[other].role != Role::Cutter));
    let round_axis = |other: usize| {
        let Part { ref mesh, link, link_from_part, .. } = scene.parts[other];
        let own = Revolved::around(mesh);
        let link_from_part_link = zero.world_from(link).inv_mul(&zero.world_from(part.link));
        let other_from_part = link_from_part.inverse() * link_from_part_link * part.link_from_part;
        is_about(mesh, &own).then(|| own.tool_from_mesh * other_from_part)
    };
    let axis = parts.into_iter().find_map(round_axis).or_else(|| fluted_axis(&part.mesh));
    TurnedBy::new(scene.machine.rigid_body(part.link), axis)
}

/// The axis of a mesh that is longer than thick and repeats itself around it, as a fluted drill does.
fn fluted_axis(mesh: &Mesh) -> Option<Isometry> {
    let own = Revolved::around(mesh);
    let is_fluted = is_long(&own) && repeat(&slabs(mesh, &own.tool_from_mesh));
    is_fluted.then_some(own.tool_from_mesh)
}

fn is_long(own: &Revolved) -> bool {
    let ([low, high], radius) = (own.profile.span_mm(), own.profile.radius_mm());
    high - low > 2.0 * radius
}

/// Whether a cutter beside the spindle's axis, or across it, may have a drive of its own: it is round about another axis, or longer than thick, as a fluted drill is.
fn may_turn_itself(mesh: &Mesh, spindle_from_part: &Isometry) -> bool {
    if Revolved::about(mesh, *spindle_from_part).filled >= ROUND {
        return false;
    }
    let own = Revolved::around(mesh);
    let own_from_spindle = own.tool_from_mesh * spindle_from_part.inverse();
    let (point, along) = (own_from_spindle * Point::origin(), own_from_spindle * Vector::z());
    let (radius, span) = (own.profile.radius_mm(), own.profile.span_mm());
    own.filled >= ROUND || is_long(&own) && !passes(&point, &along, radius, span)
}

/// Whether a line passes through a cylinder about z.
fn passes(point: &Point, along: &Vector, radius: f64, [low, high]: [f64; 2]) -> bool {
    // The part of the line between the ends of the cylinder.
    let [from, to] = if along.z.abs() < 1e-9 {
        if point.z < low || point.z > high {
            return false;
        }
        [f64::NEG_INFINITY, f64::INFINITY]
    } else {
        let ends = [low, high].map(|z| (z - point.z) / along.z);
        [ends[0].min(ends[1]), ends[0].max(ends[1])]
    };
    let across = along.xy().norm_squared();
    let nearest = if across > 0.0 { -point.coords.xy().dot(&along.xy()) / across } else { from.max(0.0).min(to) };
    let at = point + along * nearest.clamp(from, to);
    at.x.hypot(at.y) < radius
}

/// The slice of a mesh between two heights.
#[derive(Clone, Copy, Debug)]
struct Slab {
    low: f64,
    high: f64,
    /// Least and greatest distance from the axis.
    radii: [f64; 2],
    /// Whether the axis is outside the mesh there: the nearest triangles face it. `None` where they do not tell, because they are seen edge-on from the axis.
    hollow: Option<bool>,
    /// Sectors in which something is nearly as far from the axis as anything.
    sectors: [bool; SECTORS],
}

/// The mesh between heights.
fn slabs(mesh: &Mesh, axis_from_part: &Isometry) -> Vec<Slab> {
    let places: Vec<Point> = mesh.vertices().iter().map(|vertex| axis_from_part * vertex).collect();
    let heights = heights(&places);
    let mut slabs: Vec<Slab> = heights.windows(2).map(|ends| Slab::between(ends[0], ends[1])).collect();
    let mut pieces = Vec::new();
    slice(mesh, &places, &heights, |index, normal, piece| {
        slabs[index].take_in(&piece, normal);
        pieces.push((index, piece));
    });
    for (index, piece) in pieces {
        slabs[index].fill_sectors(&piece);
    }
    slabs.retain(|slab| slab.radii[0] <= slab.radii[1]);
    slabs
}

/// Cuts the faces of a mesh at heights. `take` gets the number of the height below each piece, the normal of its face, and its corners.
fn slice(mesh: &Mesh, places: &[Point], heights: &[f64], mut take: impl FnMut(usize, &Vector, Vec<Point>)) {
    for face in mesh.faces() {
        let corners = face.map(|corner| places[corner as usize]);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let [low, high] = [f64::min, f64::max].map(|of| of(of(corners[0].z, corners[1].z), corners[2].z));
        let first = heights.partition_point(|&height| height <= low).saturating_sub(1);
        let meets = heights.windows(2).enumerate().skip(first).take_while(|(_, ends)| ends[0] < high);
        for (below, ends) in meets {
            // Without what lies in its border: that is of the slab which it closes.
            take(below, &normal, clipped(&corners, ends[0] + SAME_MM, ends[1] - SAME_MM));
        }
    }
}

/// The heights of vertices, or where they are many, as many at equal distances; lowest first.
fn heights(places: &[Point]) -> Vec<f64> {
    let mut all: Vec<f64> = places.iter().map(|place| place.z).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|next, kept| *next - *kept <= 3.0 * SAME_MM);
    let (Some(&low), Some(&high)) = (all.first(), all.last()) else { return all };
    let step = (high - low) / RINGS as f64;
    if all.len() > RINGS { (0..=RINGS).map(|k| low + step * k as f64).collect() } else { all }
}

impl Slab {
    const fn between(low: f64, high: f64) -> Self {
        Self { low, high, radii: [f64::INFINITY, 0.0], hollow: None, sectors: [false; SECTORS] }
    }

    fn is_hollow(&self) -> bool {
        self.hollow == Some(true)
    }

    fn take_in(&mut self, piece: &[Point], normal: &Vector) {
        let Some(nearest) = nearest_to_axis(piece) else { return };
        let distance = nearest.x.hypot(nearest.y);
        if distance < self.radii[0] + SAME_MM {
            let outward = nearest.x * normal.x + nearest.y * normal.y;
            // What lies in a plane through the axis, or across it, tells nothing; what joins it there does.
            let faces_it = (outward.abs() > EDGE_ON * distance * normal.norm()).then_some(outward < 0.0);
            let is_tie = distance > self.radii[0] - SAME_MM;
            self.hollow = match (self.hollow.filter(|_| is_tie), faces_it) {
                (Some(before), Some(faces_it)) => Some(before && faces_it),
                (before, faces_it) => before.or(faces_it),
            };
            self.radii[0] = self.radii[0].min(distance);
        }
        self.radii[1] = piece.iter().map(|p| p.x.hypot(p.y)).fold(self.radii[1], f64::max);
    }

    /// Marks the sectors in which edges of a polygon are nearly as far from the axis as anything.
    fn fill_sectors(&mut self, piece: &[Point]) {
        let far = NEARLY * self.radii[1];
        for (p, q) in piece.iter().zip(piece.iter().cycle().skip(1)) {
            // Steps of less than a sector as long as the edge is that far out.
            let angle = (q - p).xy().norm() / far.max(SAME_MM);
            let steps = (angle / HALF_SECTOR).ceil().clamp(1.0, 4096.0) as usize;
            for step in 0..=steps {
                let at = p + (q - p) * (step as f64 / steps as f64);
                if at.x.hypot(at.y) >= far {
                    let turn = (at.y.atan2(at.x) / TAU).rem_euclid(1.0);
                    self.sectors[((turn * SECTORS as f64) as usize).min(SECTORS - 1)] = true;
                }
            }
        }
    }
}

/// Whether the outermost points at every height come back to themselves after a half, third, fifth or seventh of a turn.
fn repeat(slabs: &[Slab]) -> bool {
    let is_near =
        |slab: &Slab, sector: usize| (0..=2 * OFF).any(|k| slab.sectors[(sector + k + SECTORS - OFF) % SECTORS]);
    let is_there_again = |slab: &Slab, turn: usize| {
        (0..SECTORS).filter(|&sector| slab.sectors[sector]).all(|sector| is_near(slab, sector + turn))
    };
    [2, 3, 5, 7].iter().any(|count| slabs.iter().all(|slab| is_there_again(slab, SECTORS / count)))
}

/// A ring around each slab, as one mesh in the part's frame; `None` where it is larger than a mesh may be.
fn rings(slabs: &[Slab], axis_from_part: &Isometry) -> Option<Mesh> {
    let mut rings: Vec<[f64; 4]> = Vec::new();
    for slab in slabs {
        let inner = if slab.is_hollow() { slab.radii[0] } else { 0.0 };
        match rings.last_mut() {
            Some([.., high, r, s]) if *high == slab.low && *r == inner && *s == slab.radii[1] => *high = slab.high,
            _ => rings.push([slab.low, slab.high, inner, slab.radii[1]]),
        }
    }
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    let part_from_axis = axis_from_part.inverse();
    for [low, high, inner, outer] in rings {
        let first = vertices.len() as u32;
        // Its sides are outside the greatest distance, and its hole within the least.
        let outer = outer / (PI / SIDES as f64).cos() + SAME_MM;
        // Rings reach into each other: each has an inside of its own.
        let (low, high) = (low - SAME_MM, high + SAME_MM);
        for (radius, z) in [(outer, low), (outer, high), (inner, high), (inner, low)] {
            for side in 0..SIDES {
                let (sin, cos) = (TAU * side as f64 / SIDES as f64).sin_cos();
                vertices.push(part_from_axis * Point::new(radius * cos, radius * sin, z));
            }
        }
        let at = |loop_: usize, side: usize| first + (loop_ % 4 * SIDES + side % SIDES) as u32;
        for (loop_, side) in (0..4).flat_map(|loop_| (0..SIDES).map(move |side| (loop_, side))) {
            let [a, b, c, d] = [at(loop_, side), at(loop_, side + 1), at(loop_ + 1, side + 1), at(loop_ + 1, side)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    let corners = |[a, b, c]: [u32; 3]| [a, b, c].map(|corner| vertices[corner as usize]);
    let triangles = faces.into_iter().map(|face| Triangle { corners: corners(face) });
    // Where a ring has no hole, sides of no length fall away.
    let is_area =
        |t: &Triangle| t.corners[0] != t.corners[1] && t.corners[1] != t.corners[2] && t.corners[2] != t.corners[0];
    Mesh::from_triangles(&triangles.filter(is_area).collect::<Vec<_>>()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::{Shape, Tessellation};
    use nalgebra::UnitQuaternion;

    fn mesh(toml: &str) -> Mesh {
        let shape: Shape = toml::from_str(toml).unwrap();
        shape.mesh(&Tessellation::default()).unwrap()
    }

    /// A chuck of radius 100 with three jaws, from 31 to 81 mm.
    fn chuck() -> Mesh {
        mesh(
            r#"kind = "compound"
[[parts]]
shape = { kind = "cylinder", radius_mm = 100, height_mm = 80 }
at = { xyz_mm = [0, 0, -80] }
[[parts]]
shape = { kind = "rounded-box", size_mm = [50, 30, 40] }
at = { xyz_mm = [56, 0, 20] }
repeat = { kind = "around", count = 3 }"#,
        )
    }

    #[test]
    fn a_line_passes_through_a_cylinder_between_its_ends() {
        let (point, along) = (Point::new(3.0, 0.0, 2.0), Vector::new(-0.2, 0.0, 1.0));
        // On the axis at z = 17; 1.8 mm from it at z = 8.
        assert!(passes(&point, &along, 1.0, [10.0, 20.0]));
        assert!(!passes(&point, &along, 1.5, [4.0, 8.0]));
        assert!(passes(&point, &along, 2.0, [4.0, 8.0]));
        // Across, and beside the axis along it.
        assert!(passes(&point, &-Vector::x(), 1.0, [1.0, 3.0]) && !passes(&point, &-Vector::x(), 1.0, [3.0, 4.0]));
        assert!(!passes(&point, &Vector::z(), 3.0, [0.0, 9.0]) && passes(&point, &Vector::z(), 3.1, [0.0, 9.0]));
        // In the plane of an end.
        assert!(passes(&point, &-Vector::x(), 1.0, [2.0, 4.0]) && passes(&point, &-Vector::x(), 1.0, [0.0, 2.0]));
        // On the axis at z = 6, after 5 mm. At z = 10, after 10 mm, it is at x = -3.
        let slanted = Vector::new(-0.6, 0.0, 0.8);
        assert!(passes(&point, &slanted, 1.0, [5.0, 7.0]) && !passes(&point, &slanted, 2.9, [10.0, 20.0]));
    }

    #[test]
    fn vertices_of_one_height_count_once() {
        let at = |z: f64| Point::new(1.0, 2.0, z);
        let found = heights(&[at(5.0), at(0.0), at(5.0 + SAME_MM), at(3.0), at(0.0)]);
        assert_eq!(found, [0.0, 3.0, 5.0]);
        let many: Vec<Point> = (0..=2 * RINGS).map(|k| at(k as f64)).collect();
        assert_eq!(heights(&many), (0..=RINGS).map(|k| 2.0 * k as f64).collect::<Vec<_>>());
        let shifted: Vec<Point> = many.iter().map(|place| place + Vector::z() * 100.0).collect();
        assert_eq!(heights(&shifted), (0..=RINGS).map(|k| 100.0 + 2.0 * k as f64).collect::<Vec<_>>());
        // As many as there are rings stay, at whatever distances.
        let uneven: Vec<f64> = (0..RINGS).map(|k| (k * k) as f64).collect();
        assert_eq!(heights(&uneven.iter().map(|&z| at(z)).collect::<Vec<_>>()), uneven);
    }

    #[test]
    fn what_turns_fills_its_rings() {
        let turned = Isometry::from_parts(
            Vector::new(7.0, -3.0, 20.0).into(),
            UnitQuaternion::from_euler_angles(0.3, 1.0, -2.0),
        );
        let own = chuck();
        let moved = obbtree::cases::meshes::moved(&own, 1.0, &turned);
        let slabs = slabs(&moved, &turned.inverse());
        let found = rings(&slabs, &turned.inverse()).unwrap();
        assert!(found.edge_report().is_watertight());
        // The jaws' corners are at (81, 15) and (31, 0): between those radii there is metal at every angle.
        let radii = |p: &Point| {
            let p = turned.inverse() * p;
            (p.x.hypot(p.y), p.z)
        };
        let jaws: Vec<f64> = found.vertices().iter().map(radii).filter(|(_, z)| *z > 1.0).map(|(r, _)| r).collect();
        let greatest = 81_f64.hypot(15.0);
        assert!(
            jaws.iter().all(|r| (r - 31.0).abs() < 1e-3 || (r - greatest / (PI / 64.0).cos()).abs() < 1e-3),
            "{jaws:?}"
        );
        for vertex in moved.vertices() {
            let (r, z) = radii(vertex);
            let is_in = |slab: &Slab| {
                let inner = if slab.is_hollow() { slab.radii[0] } else { 0.0 };
                (slab.low - 1e-5..=slab.high + 1e-5).contains(&z) && (inner - 1e-5..=slab.radii[1] + 1e-5).contains(&r)
            };
            assert!(slabs.iter().any(is_in), "{r} {z}");
        }
        let around: f64 = PI * (100_f64.powi(2) * 80.0 + (greatest.powi(2) - 31_f64.powi(2)) * 40.0);
        assert!((found.signed_volume() / around - 1.0).abs() < 0.01, "{}", found.signed_volume() / around);
    }

    #[test]
    fn a_slab_is_hollow_where_all_that_is_nearest_faces_the_axis() {
        let piece = |x: f64| [Point::new(x, -1.0, 0.2), Point::new(x, 1.0, 0.2), Point::new(x, 0.0, 0.8)];
        let (inward, outward, aside) = (-Vector::x(), Vector::x(), Vector::y());
        for (pieces, is_hollow) in [
            (vec![(5.0, inward)], true),
            (vec![(5.0, outward)], false),
            (vec![(5.0, inward), (5.0, outward)], false),
            (vec![(5.0, outward), (5.0, inward)], false),
            (vec![(5.0, outward), (4.0, inward)], true),
            (vec![(5.0, inward), (6.0, outward)], true),
            // Of two at an edge the one decides that is not seen edge-on.
            (vec![(5.0, aside), (5.0, inward)], true),
            (vec![(5.0, inward), (5.0, aside)], true),
            (vec![(5.0, aside), (5.0, outward)], false),
            (vec![(5.0, outward), (5.0, aside), (5.0, inward)], false),
            (vec![(5.0, aside)], false),
            (vec![(5.0, inward), (4.0, aside)], false),
        ] {
            for turn in [0.0, 0.5, 2.0, 4.0] {
                let turn = Isometry::rotation(Vector::z() * turn);
                let mut slab = Slab::between(0.0, 1.0);
                pieces.iter().for_each(|(x, normal)| slab.take_in(&piece(*x).map(|p| turn * p), &(turn * normal)));
                assert_eq!(slab.is_hollow(), is_hollow, "{pieces:?}");
                let least = pieces.iter().map(|(x, _)| *x).fold(f64::INFINITY, f64::min);
                assert!((slab.radii[0] - least).abs() < 1e-12, "{slab:?}");
            }
        }
    }

    #[test]
    fn an_edge_fills_all_sectors_in_which_it_is_far_out() {
        for radius in [10.0, 0.1] {
            let at = |degrees: f64| {
                let (sin, cos) = degrees.to_radians().sin_cos();
                Point::new(radius * cos, radius * sin, 0.5)
            };
            let mut slab = Slab { radii: [0.0, radius], ..Slab::between(0.0, 1.0) };
            // Its middle is at 0.996 of the radius, that of the other edges below 0.99.
            slab.fill_sectors(&[at(2.5), at(12.5), Point::new(0.0, 0.0, 0.5)]);
            let filled: Vec<usize> = (0..SECTORS).filter(|&sector| slab.sectors[sector]).collect();
            assert_eq!(filled, (2..=12).collect::<Vec<_>>(), "{radius}");
        }
    }

    #[test]
    fn slabs_of_equal_radii_that_join_are_one_ring() {
        let slab = |low, high, radii| Slab { radii, hollow: Some(true), ..Slab::between(low, high) };
        let mut slabs = vec![slab(0.0, 1.0, [5.0, 9.0]), slab(1.0, 2.0, [5.0, 9.0])];
        let count = |slabs: &[Slab]| rings(slabs, &Isometry::identity()).unwrap().vertices().len() / (4 * SIDES);
        assert_eq!(count(&slabs), 1);
        for apart in [slab(2.5, 3.0, [5.0, 9.0]), slab(2.0, 3.0, [5.0, 8.0]), slab(2.0, 3.0, [6.0, 9.0])] {
            slabs.push(apart);
            assert_eq!(count(&slabs), 2);
            slabs.pop();
        }
    }

    #[test]
    fn the_sides_of_a_ring_are_outside_all_that_it_holds() {
        let slab = Slab { radii: [5.0, 9.0], hollow: Some(true), ..Slab::between(0.0, 1.0) };
        let ring = rings(&[slab], &Isometry::identity()).unwrap();
        let nearest = |t: &Triangle| nearest_to_axis(&t.corners).unwrap().coords.xy().norm();
        let outer = ring.triangles().into_iter().filter(|t| t.corners.iter().all(|p| p.x.hypot(p.y) > 8.0));
        assert!(outer.map(|t| nearest(&t)).all(|distance| distance > 9.0));
    }

    #[test]
    fn the_face_of_a_step_is_of_the_slab_that_it_closes() {
        // A shaft of 10 mm with many heights, and a flange of 50 mm from half a millionth of a millimetre below the border at 48 mm.
        let border = 48.0;
        let shaft = (1..192).map(|k| format!("[{}, {}], ", if k % 2 == 0 { 10.0 } else { 9.9 }, 0.25 * f64::from(k)));
        let (shaft, from): (String, f64) = (shaft.collect(), border - 0.5 * SAME_MM);
        let profile = format!("[0, 0], [10, 0], {shaft}[10, {from}], [50, {from}], [50, 96], [0, 96]");
        let all = slabs(&mesh(&format!("kind = \"revolve\"\nprofile_mm = [{profile}]")), &Isometry::identity());
        let radius_at = |z: f64| all.iter().find(|slab| slab.low < z && z < slab.high).unwrap().radii[1];
        assert!(all.len() == RINGS && all.iter().any(|slab| slab.high == border));
        assert!(radius_at(border - 0.1) < 10.1 && radius_at(border + 0.1) > 49.0);
    }

    #[test]
    fn a_slab_whose_nearest_point_is_a_corner_is_hollow_where_the_face_looks_at_the_axis() {
        // From (3, 4) away along (5, 1): the normals look past the axis, away from it and at it.
        let piece = [Point::new(3.0, 4.0, 0.2), Point::new(8.0, 5.0, 0.2), Point::new(3.0, 4.0, 0.8)];
        for (normal, is_hollow) in [(Vector::new(-0.1, 0.5, 0.0), false), (Vector::new(0.1, -0.5, 0.0), true)] {
            let mut slab = Slab::between(0.0, 1.0);
            slab.take_in(&piece, &normal);
            assert_eq!((slab.is_hollow(), slab.radii[0]), (is_hollow, 5.0));
        }
    }

    #[test]
    fn what_is_not_the_same_at_every_angle_is_not_round() {
        let is_round = |toml: &str| is_round_about(&mesh(toml), &Isometry::identity());
        let prism = |sides: usize| {
            let corner = |k: usize| {
                let (sin, cos) = (TAU * k as f64 / sides as f64).sin_cos();
                format!("[{}, {}]", 20.0 * cos, 20.0 * sin)
            };
            let corners: Vec<String> = (0..sides).map(corner).collect();
            format!("kind = \"extrude\"\nheight_mm = 10\noutline_mm = [{}]", corners.join(", "))
        };
        for (sides, expected) in [(6, false), (12, false), (18, false), (20, true), (48, true)] {
            assert_eq!(is_round(&prism(sides)), expected, "{sides}");
        }
        let toothed = |count: usize| {
            let body =
                "kind = \"compound\"\n[[parts]]\nshape = { kind = \"cylinder\", radius_mm = 20, height_mm = 10 }";
            let tooth = "shape = { kind = \"rounded-box\", size_mm = [4, 1, 8] }\nat = { xyz_mm = [20, 0, 5] }";
            format!("{body}\n[[parts]]\n{tooth}\nrepeat = {{ kind = \"around\", count = {count} }}")
        };
        assert!(!is_round(&toothed(6)) && !is_round(&toothed(60)));
        let with = |tube: &str, other: &str| {
            let tube = format!("{{ shape = {{ kind = \"revolve\", profile_mm = {tube} }} }}");
            format!("kind = \"compound\"\nparts = [{tube}, {other}]")
        };
        let ring = "[[30, 0], [50, 0], [50, 10], [30, 10]]";
        let lug = |x: f64| {
            format!("{{ shape = {{ kind = \"rounded-box\", size_mm = [18, 6, 4] }}, at = {{ xyz_mm = [{x}, 0, 5] }} }}")
        };
        // In a bore, under a rim, and beside so many heights that those of a lug are not all asked.
        assert!(is_round(&with(ring, "{ shape = { kind = \"cylinder\", radius_mm = 5, height_mm = 8 } }")));
        assert!(!is_round(&with(ring, &lug(24.0))));
        assert!(!is_round(&with("[[0, 0], [50, 0], [50, 2], [45, 2], [45, 10], [0, 10]]", &lug(40.0))));
        let cone: String =
            (0..200).map(|k| format!("[{}, {}], ", 45.0 - 0.1 * f64::from(k), 12.0 + f64::from(k))).collect();
        let tall = format!("[[0, 0], [50, 0], [50, 8], [45, 8], {cone}[0, 212]]");
        let alone = format!("kind = \"revolve\"\nprofile_mm = {tall}");
        assert!(is_round(&alone) && !is_round(&with(&tall, &lug(40.0))));
        // A keyway of 9 degrees.
        let keyed: Vec<String> = (0..=78)
            .map(|k| (4.5 * f64::from(k) + 4.5).to_radians().sin_cos())
            .map(|(sin, cos)| format!("[{}, {}]", 20.0 * cos, 20.0 * sin))
            .collect();
        assert!(!is_round(&format!(
            "kind = \"extrude\"\nheight_mm = 10\noutline_mm = [{}, [15, -1.2], [15, 1.2]]",
            keyed.join(", ")
        )));
    }

    #[test]
    fn what_is_round_is_so_at_every_size() {
        let with_teeth = |size: [f64; 3], count: usize| {
            let body = "shape = { kind = \"cylinder\", radius_mm = 20, height_mm = 10 }";
            let tooth =
                format!("shape = {{ kind = \"rounded-box\", size_mm = {size:?} }}\nat = {{ xyz_mm = [20, 0, 5] }}");
            let around = format!("repeat = {{ kind = \"around\", count = {count} }}");
            mesh(&format!("kind = \"compound\"\n[[parts]]\n{body}\n[[parts]]\n{tooth}\n{around}"))
        };
        // Two sides of 0.01 mm² lean; as much as 0.04 mm² may.
        let pip = with_teeth([0.1, 0.1, 0.1], 1);
        // Half a disc so thin that its straight side has 0.06 mm²; as much as 0.09 mm² may lean.
        let corner = |k: u32| f64::from(2 * k).to_radians().sin_cos();
        let corners: Vec<String> =
            (0..=90).map(corner).map(|(sin, cos)| format!("[{}, {}]", 30.0 * cos, 30.0 * sin)).collect();
        let sliver = mesh(&format!("kind = \"extrude\"\nheight_mm = 0.001\noutline_mm = [{}]", corners.join(", ")));
        for scale in [1.0, 0.0025] {
            for (mesh, expected) in [
                (&pip, true),
                (&with_teeth([1.0, 1.0, 1.0], 1), false),
                (&with_teeth([4.0, 1.0, 8.0], 60), false),
                (&sliver, false),
            ] {
                let scaled = obbtree::cases::meshes::moved(mesh, scale, &Isometry::identity());
                assert_eq!(is_round_about(&scaled, &Isometry::identity()), expected, "{scale}");
            }
        }
    }

    #[test]
    fn a_cone_is_round_though_its_point_is_a_little_beside_the_axis() {
        let (count, radius) = (48, 20.0);
        let around = (0..count).map(|k| (TAU * f64::from(k) / f64::from(count)).sin_cos());
        let mut vertices: Vec<Point> = around.map(|(sin, cos)| Point::new(radius * cos, radius * sin, 0.0)).collect();
        // At half of the distance up to which corners are not asked.
        vertices.extend([Point::new(0.5 * MIDDLE * radius, 0.0, 30.0), Point::origin()]);
        let sides = (0..48).flat_map(|k| [[k, (k + 1) % 48, 48], [(k + 1) % 48, k, 49]]);
        assert!(is_round_about(&Mesh::new(vertices, sides.collect()).unwrap(), &Isometry::identity()));
    }

    #[test]
    fn only_what_repeats_itself_around_its_axis_is_fluted() {
        let shank = "{ shape = { kind = \"cylinder\", radius_mm = 10, height_mm = 60 } }";
        let arm = |x: f64| {
            format!(
                "{{ shape = {{ kind = \"rounded-box\", size_mm = [10, 4, 8] }}, at = {{ xyz_mm = [{x}, 0, 10] }} }}"
            )
        };
        let compound = |parts: &[String]| format!("kind = \"compound\"\nparts = [{}]", parts.join(", "));
        let drill = "kind = \"rounded-box\"\nsize_mm = [4, 8, 60]".to_owned();
        for (shape, expected) in [
            (drill, true),
            (compound(&[shank.to_owned(), arm(10.0), arm(-10.0)]), true),
            (compound(&[shank.to_owned(), arm(10.0)]), false),
            // Flat, and not as long as it is thick: 14.1 mm.
            ("kind = \"rounded-box\"\nsize_mm = [10, 10, 4]".to_owned(), false),
            ("kind = \"rounded-box\"\nsize_mm = [10, 10, 12]".to_owned(), false),
        ] {
            let axis = fluted_axis(&mesh(&shape));
            assert_eq!(axis.is_some(), expected, "{shape}");
            let is_along = |axis: Isometry| (axis * Vector::z()).z.abs() > 1.0 - 1e-9;
            assert!(axis.is_none_or(is_along), "{shape}");
        }
    }

    #[test]
    fn teeth_repeat_themselves_up_to_five_degrees_either_way() {
        // Arms on opposite sides of a shank, one of them turned on.
        let arm = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let at = format!("at = {{ xyz_mm = [{}, {}, 10], rpy_deg = [0, 0, {degrees}] }}", 10.0 * cos, 10.0 * sin);
            format!("{{ shape = {{ kind = \"rounded-box\", size_mm = [10, 4, 8] }}, {at} }}")
        };
        let shank = "{ shape = { kind = \"cylinder\", radius_mm = 10, height_mm = 60 } }";
        for (degrees, expected) in [(180.0, true), (184.0, true), (176.0, true), (187.0, false), (173.0, false)] {
            let shape = format!("kind = \"compound\"\nparts = [{shank}, {}, {}]", arm(0.0), arm(degrees));
            assert_eq!(repeat(&slabs(&mesh(&shape), &Isometry::identity())), expected, "{degrees}");
        }
    }

    #[test]
    fn round_parts_stay_as_they_are() {
        let round = r#"kind = "revolve"
profile_mm = [[5, 0], [20, 0], [20, 30], [12, 50], [5, 50]]"#;
        assert!(is_round_about(&mesh(round), &Isometry::identity()) && is_round(&mesh(round)));
        // Beside the axis the same is not round.
        assert!(!is_round_about(&mesh(round), &Isometry::translation(5.0, 0.0, 0.0)));
    }

    /// All of its faces lean by less than those of a prism with 20 sides.
    #[test]
    fn what_is_a_little_beside_the_axis_oval_slanted_or_wound_is_not_round() {
        let disc = mesh("kind = \"cylinder\"\nradius_mm = 100\nheight_mm = 10");
        let tube = mesh("kind = \"revolve\"\nprofile_mm = [[20, 0], [30, 0], [30, 40], [20, 40]]");
        let moved = |mesh: &Mesh, place: &dyn Fn(&Point) -> Point| {
            Mesh::new(mesh.vertices().iter().map(place).collect(), mesh.faces().to_vec()).unwrap()
        };
        let about = |mesh: &Mesh| is_round_about(mesh, &Isometry::identity());
        let beside = |x: f64| move |p: &Point| Point::new(p.x + x, p.y, p.z);
        assert!(about(&moved(&disc, &beside(0.1))) && !about(&moved(&disc, &beside(1.0))));
        assert!(!about(&moved(&disc, &beside(10.0))));
        assert!(about(&disc) && !about(&moved(&disc, &|p| Point::new(p.x, 0.98 * p.y, p.z))));
        let tilt = Isometry::rotation(Vector::new(0.05, 0.0, 0.0));
        assert!(!about(&moved(&disc, &|p| tilt * p)));
        // Round without, and its bore is oval.
        let bored = |p: &Point| if p.x.hypot(p.y) < 25.0 { Point::new(p.x, 0.97 * p.y, p.z) } else { *p };
        assert!(about(&tube) && !about(&moved(&tube, &bored)));
        // Rings each a millimetre beside the axis, at angles that wind.
        let wound =
            mesh("kind = \"revolve\"\nprofile_mm = [[0, 0], [50, 0], [50, 10], [50, 20], [50, 30], [50, 40], [0, 40]]");
        let winds = |p: &Point| Point::new(p.x + (0.05 * p.z).cos(), p.y + (0.05 * p.z).sin(), p.z);
        assert!(about(&wound) && !about(&moved(&wound, &winds)));
    }

    /// 5 x 140 x 2.4 mm on a faceplate of 500 mm radius, between a hub and a rim that are higher: its ends lean, 24 mm² of them.
    #[test]
    fn a_strap_on_a_large_faceplate_is_not_little() {
        let plate = |more: &str| {
            let round = [
                "{ shape = { kind = \"cylinder\", radius_mm = 500, height_mm = 20 } }",
                "{ shape = { kind = \"cylinder\", radius_mm = 50, height_mm = 30 } }",
                "{ shape = { kind = \"revolve\", profile_mm = [[480, 10], [500, 10], [500, 30], [480, 30]] } }",
            ];
            mesh(&format!("kind = \"compound\"\nparts = [{}{more}]", round.join(", ")))
        };
        let strap = ", { shape = { kind = \"rounded-box\", size_mm = [5, 140, 2.4] }, at = { xyz_mm = [450, 0, 21] } }";
        let about = |more: &str| is_round_about(&plate(more), &Isometry::identity());
        assert!(about("") && !about(strap));
    }
}
