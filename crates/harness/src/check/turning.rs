//! Cutters on lathes: the workpiece turns, so its axis and the tool's place beside it say what is cut.
//!
//! On a machine with a lathe's controller a cutter is held against the stock as its section through the workpiece's axis: the nearest joint that turns the
//! workpiece, or the axis of a round workpiece that no joint turns. A cutter is driven, and cuts as on a mill, where that axis turns it as the program says between two of its
//! feeds, and where it is round and ever feeds otherwise than on that axis. A round insert is taken for one, which takes away less than it does, unless `turns` of the
//! part says that it stands. One that is not round may stand all the same: it takes nothing away for sure, unless `turns` says that it is driven.

use super::motion::Path;
use super::stock::mount;
use crate::geometry::{Isometry, Mesh, Point, Vector};
use crate::interference::{ROUND, Revolved};
use crate::machine::{Joint, Motion};
use crate::scene::{Part, Role, Scene, Turns};
use crate::stock::motion::{Chain, Mount, Piece};
use crate::stock::{Body, Spindle, Sweep, TurningTool};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use rs274::{Axis, Move, Plane, Position};
use std::cell::{OnceCell, RefCell};
use std::sync::Arc;

/// A round cutter is on the axis when the cosine of the angle between the two is at least this, and it is this near, mm.
const ALONG: f64 = 0.999;
const ON_AXIS_MM: f64 = 0.05;
/// Turns of the workpiece that are none, radians.
const STILL: f64 = 1e-9;
/// Sections of a part turned or moved across the plane in different ways that are kept.
const MOST_SECTIONS: usize = 64;
/// How far a tool's frame may be off the one its section was made in, mm.
const SAME_MM: f64 = 1e-6;

/// A part beside the axis of a workpiece that turns.
pub(super) struct Turning {
    mesh: Arc<Mesh>,
    spindle: Spindle,
    cuts: bool,
    /// From the part to what carries the workpiece's axis: the axis is that chain's stock.
    pub to_base: Chain,
    /// The section as the part is at first, and as it is turned, and away from the plane, later.
    sections: RefCell<Vec<Section>>,
    /// The part's frame at first, in that of the axis.
    at_first: Isometry,
    /// The body of revolution that the part is about the axis, where the axis passes through its box.
    around: OnceCell<Option<Body>>,
}

/// A part's section, and the distance of the part's frame from its plane, mm.
struct Section {
    tool: TurningTool,
    beside_mm: f64,
}

/// The axis of a workpiece that turns.
pub(super) struct WorkAxis {
    /// What carries it.
    pub base: Option<usize>,
    /// The axis of the machine that turns it.
    turned_by: Option<Axis>,
    /// Its frame in that of what carries it; z is the axis.
    pub base_from_axis: Isometry,
    /// Takes the workpiece's frame to that of the axis.
    pub axis_from_stock: Isometry,
}

impl Turning {
    /// Part number `part`, which has this body. Whether the stock is flat, [`Spindle::is_flat`] says.
    pub fn new(scene: &Scene, path: &Path<'_>, axis: &WorkAxis, is_flat: bool, part: usize, body: &Body) -> Self {
        let (mesh, mount) = (&scene.parts[part].mesh, mount(scene, part, body));
        let to = |base_from_axis| {
            let base = Mount { link: axis.base, link_from_mesh: base_from_axis, ..mount };
            let chain = Chain::new(&scene.machine, mount, base);
            let at_first = chain.stock_from_part(&scene.machine, &path.position(0));
            (chain, at_first)
        };
        let (mut to_base, mut at_first) = to(axis.base_from_axis);
        // A tool may begin on the other side of the axis. One on the axis has no side there.
        let x_at = |at: usize| (to_base.stock_from_part(&scene.machine, &path.position(at)) * mount.centre).x;
        let at_work = feeds_of(scene, path, part).next().map(x_at).filter(|x| x.abs() > ON_AXIS_MM);
        if at_work.unwrap_or_else(|| x_at(0)) < 0.0 {
            // X leads away from where the tool is.
            let half_turn = UnitQuaternion::from_axis_angle(&Vector::z_axis(), std::f64::consts::PI);
            (to_base, at_first) = to(axis.base_from_axis * half_turn);
        }
        let beside_mm = at_first.translation.y;
        let cuts = scene.parts[part].role == Role::Cutter;
        let first = Section { tool: TurningTool::new(mesh, at_first.rotation, beside_mm, cuts), beside_mm };
        let axis_from_stock = if is_flat { Isometry::identity() } else { axis.axis_from_stock };
        let spindle = Spindle { axis_from_stock, is_flat };
        let (mesh, sections, around) = (Arc::clone(mesh), RefCell::new(vec![first]), OnceCell::new());
        Self { mesh, spindle, cuts, to_base, sections, at_first, around }
    }

    /// Whether part number `part`, a cutter, turns itself and not the workpiece.
    pub fn is_driven(&self, scene: &Scene, path: &Path<'_>, axis: &WorkAxis, part: usize, body: &Body) -> bool {
        let feeds = || feeds_of(scene, path, part);
        let turned_to = |at: usize| axis.turned_by.map_or(0.0, |axis| path.position(at)[axis]);
        let is_turned = feeds().next().is_some_and(|first| {
            let wanted = turned_to(first);
            feeds().any(|at| (turned_to(at) - wanted).abs() > STILL || (turned_to(at - 1) - wanted).abs() > STILL)
        });
        match scene.parts[part].turns {
            // On a lathe a tool's spindle is one that drives it.
            Some(turns) => turns != Turns::Nothing,
            None => is_turned || body.axis().is_some_and(|axis| self.feeds_off_axis(scene, path, part, axis)),
        }
    }

    /// Whether part number `part`, round about an axis, ever feeds otherwise than on the workpiece's axis.
    fn feeds_off_axis(&self, scene: &Scene, path: &Path<'_>, part: usize, (point, direction): (Point, Vector)) -> bool {
        feeds_of(scene, path, part).any(|at| {
            let base_from_part = self.to_base.stock_from_part(&scene.machine, &path.position(at));
            let place = base_from_part * point;
            (base_from_part * direction).z.abs() < ALONG || place.x.hypot(place.y) > ON_AXIS_MM
        })
    }

    /// All that the part may pass on a piece of its way in [`Self::to_base`], however it is turned.
    pub fn sweep(&self, piece: &Piece, chord_mm: f64) -> Sweep {
        let known = self.sweep_around(piece, chord_mm).or_else(|| self.sweep_of_section(piece, chord_mm));
        known.unwrap_or_else(|| self.sweep_as(piece, chord_mm, TurningTool::clone))
    }

    /// What a part around the axis passes while it moves along that axis: the hull of its section would close its bore. `None` of cutters and of all other ways.
    fn sweep_around(&self, piece: &Piece, chord_mm: f64) -> Option<Sweep> {
        let is_along = |pose: &Isometry| {
            let off = (pose.translation.vector - self.at_first.translation.vector).xy().norm();
            off <= SAME_MM && pose.rotation.angle_to(&self.at_first.rotation) < 1e-9
        };
        let ends = [piece.first, piece.last];
        if self.cuts || piece.turn > 0.0 || !ends.iter().all(is_along) {
            return None;
        }
        let body = self.body_around()?;
        let stock_from_axis = self.spindle.axis_from_stock.inverse();
        let [first, last] = ends.map(|pose| stock_from_axis * pose);
        Some(body.sweep([&first, &last], 2.0 * SAME_MM + chord_mm))
    }

    /// What the part takes away on the piece: nothing for sure while it turns, or goes across the plane of its section.
    pub fn cut(&self, piece: &Piece, chord_mm: f64) -> Sweep {
        self.sweep_of_section(piece, chord_mm).unwrap_or_else(|| self.sweep_as(piece, chord_mm, TurningTool::vague))
    }

    fn sweep_as(&self, piece: &Piece, chord_mm: f64, of: impl Fn(&TurningTool) -> TurningTool) -> Sweep {
        let (start, (travel, pad_mm)) = (piece.first, self.to_base.unturned(piece));
        let tool = TurningTool::new(&self.mesh, start.rotation, start.translation.y + 0.5 * travel.y, false);
        let pad_mm = pad_mm + chord_mm + 0.5 * travel.y.abs();
        of(&tool).sweep(&self.spindle, [start.translation.x, start.translation.z], [travel.x, travel.z], pad_mm)
    }

    /// The part's section on the piece; `None` where it turns, or goes across the plane.
    fn sweep_of_section(&self, piece: &Piece, chord_mm: f64) -> Option<Sweep> {
        let (start, (travel, _)) = (piece.first, self.to_base.unturned(piece));
        if piece.turn > 0.0 || travel.y.abs() > SAME_MM {
            return None;
        }
        let beside_mm = start.translation.y;
        let mut sections = self.sections.borrow_mut();
        let is_same = |section: &Section| {
            (section.beside_mm - beside_mm).abs() <= SAME_MM && section.tool.is_turned_by(&start.rotation)
        };
        let known = sections.iter().position(is_same).unwrap_or_else(|| {
            sections.truncate(MOST_SECTIONS);
            let tool = TurningTool::new(&self.mesh, start.rotation, beside_mm, self.cuts);
            sections.push(Section { tool, beside_mm });
            sections.len() - 1
        });
        let place = [start.translation.x, start.translation.z];
        Some(sections[known].tool.sweep(&self.spindle, place, [travel.x, travel.z], 2.0 * SAME_MM + chord_mm))
    }

    /// How deep a point can be in the part at most, mm: in its section, or in its body of revolution, of which thin pieces count as in [`Body::deepest_mm`].
    pub fn deepest_mm(&self, out_mm: f64) -> f64 {
        let of_section = self.sections.borrow()[0].tool.deepest_mm();
        self.body_around().map_or(of_section, |body| of_section.min(body.deepest_mm(out_mm)))
    }

    /// The body of revolution that the part is about the axis; `None` for a cutter, and where the axis misses the part's box.
    fn body_around(&self) -> Option<&Body> {
        let of_axis = || {
            let is_around = !self.cuts && is_around(&self.mesh, &self.at_first);
            is_around.then(|| Body::turning_about(&self.mesh, self.at_first, 0.0))
        };
        self.around.get_or_init(of_axis).as_ref()
    }
}

/// Whether the axis passes through the box of a mesh in the axis's frame.
pub(super) fn is_around(mesh: &Mesh, axis_from_part: &Isometry) -> bool {
    let places = || mesh.vertices().iter().map(|vertex| axis_from_part * vertex);
    (0..2).all(|k| places().any(|place| place[k] < 0.0) && places().any(|place| place[k] > 0.0))
}

/// Spindle that a cutter needs to cut.
#[derive(Clone, Copy)]
pub(super) enum Needs {
    /// Either spindle.
    Any,
    /// The workpiece's spindle.
    OfWorkpiece,
    /// The spindle that drives the cutter.
    OfTool,
}

impl Needs {
    /// Spindle that a cutter needs in a workpiece. A round cutter on the workpiece's axis cuts whichever of the two turns. A cutter that is not round and has no
    /// `turns` may be driven or stand where the workpiece turns between its feeds.
    pub fn of(scene: &Scene, path: &Path<'_>, workpiece: usize, cutter: usize) -> Self {
        if path.moves().iter().all(|step| step.turns_workpiece == step.turns_tool) {
            return Self::Any;
        }
        let Some(axis) = WorkAxis::of(scene, path, workpiece) else { return Self::Any };
        let part = &scene.parts[cutter];
        let body = Body::turning(&part.mesh, 0.0);
        let turning = Turning::new(scene, path, &axis, false, cutter, &body);
        let is_on_axis = body.axis().is_some_and(|axis| !turning.feeds_off_axis(scene, path, cutter, axis));
        match part.turns {
            Some(Turns::Nothing) => Self::OfWorkpiece,
            _ if is_on_axis => Self::Any,
            Some(_) => Self::OfTool,
            None if !turning.is_driven(scene, path, &axis, cutter, &body) => Self::OfWorkpiece,
            None if body.axis().is_some() => Self::OfTool,
            None => Self::Any,
        }
    }

    /// Whether that spindle stands still in a move.
    pub const fn stands(self, step: &Move) -> bool {
        match self {
            Self::Any => !(step.turns_workpiece || step.turns_tool),
            Self::OfWorkpiece => !step.turns_workpiece,
            Self::OfTool => !step.turns_tool,
        }
    }
}

/// Places at the ends of a part's feeds.
pub(super) fn feeds_of(scene: &Scene, path: &Path<'_>, part: usize) -> impl Iterator<Item = usize> {
    let is_feed = move |at: &usize| path.step(*at as f64).kind.is_feed();
    let is_mounted = move |at: &usize| scene.parts[part].tool.is_none_or(|tool| tool == path.tool(*at));
    (1..=path.samples().len()).filter(is_feed).filter(is_mounted)
}

/// Whether a cutter on a lathe is driven, or may be: it is round and never feeds.
pub(super) fn may_be_driven(scene: &Scene, path: &Path<'_>, cutter: usize) -> bool {
    let part = &scene.parts[cutter];
    if let Some(turns) = part.turns {
        return turns != Turns::Nothing;
    }
    let body = Body::turning(&part.mesh, 0.0);
    if body.axis().is_some() && feeds_of(scene, path, cutter).next().is_none() {
        return true;
    }
    let workpieces = (0..scene.parts.len()).filter(|&part| scene.parts[part].role == Role::Workpiece);
    let mut axes = workpieces.filter_map(|workpiece| WorkAxis::of(scene, path, workpiece));
    axes.any(|axis| Turning::new(scene, path, &axis, false, cutter, &body).is_driven(scene, path, &axis, cutter, &body))
}

impl WorkAxis {
    /// On a lathe the nearest joint that turns the workpiece; else its own axis, if it is round.
    pub fn of(scene: &Scene, path: &Path<'_>, workpiece: usize) -> Option<Self> {
        if path.first_plane() != Plane::Zx {
            return None;
        }
        let machine = &scene.machine;
        let Part { link, link_from_part, ref mesh, .. } = scene.parts[workpiece];
        let joint_of = |link: usize| machine.links()[link].joint.as_ref();
        let nearest = machine.rigid_body(link).filter(|&link| joint_of(link).is_some_and(Joint::turns));
        let zero = machine.forward(&Position::default());
        let turned_by = nearest.and_then(joint_of).map(|joint| joint.axis);
        let (base, base_from_stock, point, direction) = match nearest {
            Some(spindle) => {
                let Some(Motion::Rotary { direction, point }) = joint_of(spindle).map(|joint| joint.motion) else {
                    return None;
                };
                let base = machine.parent(spindle);
                let base_from_spindle = machine.links()[spindle].parent_from_link;
                let spindle_from_stock =
                    zero.world_from(Some(spindle)).inv_mul(&zero.world_from(link)) * link_from_part;
                let direction = base_from_spindle * direction.into_inner();
                (base, base_from_spindle * spindle_from_stock, base_from_spindle * point, direction)
            }
            None => {
                let round = Revolved::within(mesh);
                let base_from_body = link_from_part * round.tool_from_mesh.inverse();
                let (point, direction) = (base_from_body * Point::origin(), base_from_body * Vector::z());
                let is_round = round.filled >= ROUND || Body::stock(mesh).axis().is_some();
                is_round.then_some((link, link_from_part, point, direction))?
            }
        };
        // X leads from the axis to the tool, as the machine's axis X does.
        let world_from_base = zero.world_from(base);
        let x = machine.links().iter().enumerate().find_map(|(index, link)| {
            let joint = link.joint.as_ref().filter(|joint| joint.axis == Axis::X)?;
            let Motion::Prismatic { direction } = joint.motion else { return None };
            Some(world_from_base.inverse() * (zero.world_from(Some(index)) * direction.into_inner()))
        })?;
        let x = (x - direction * direction.dot(&x)).try_normalize(1e-6)?;
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, direction.cross(&x), direction]));
        let rotation = UnitQuaternion::from_rotation_matrix(&rotation);
        let base_from_axis = Isometry::from_parts(point.coords.into(), rotation);
        Some(Self { base, turned_by, base_from_axis, axis_from_stock: base_from_axis.inverse() * base_from_stock })
    }
}
