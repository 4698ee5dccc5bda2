//! Cutter compensation, G40 to G42.1: the tool's centre runs beside the programmed path, at the distance of its radius.
//!
//! Each line or arc of the programmed path is shifted sideways as it comes; how it joins the one before depends on the corner
//! between them (LinuxCNC, "Cutter Compensation"; details as in its version 2.9):
//!
//! - An outside corner gets an arc about the programmed corner; in a rapid move a straight line to that arc's end. On Fanuc's controls it gets
//!   straight lines: both shifted curves go straight on until they meet, or at a corner of more than a right angle for a radius each.
//! - At an inside corner the element before ends, and the new one begins, where the two shifted curves meet.
//! - A corner of no more than [`SMOOTH_CORNER`] is none.
//!
//! Fanuc's controls look through one block without a move in the plane. Behind [`BLIND_BLOCKS`] of them an element ends beside its programmed end, and at an
//! inside corner the tool goes straight from there to the end of the next (B-63534EN, "A block without tool movement").
//!
//! The first move leads from where the tool is to the shifted end; it must be at least a radius long. On Fanuc's and Haas's controls, at an inside
//! corner, it leads to beside the start of the next element, which stays whole. At an outside corner Fanuc's do so with start-up type A
//! (parameter 5003#0 at 0), which is followed; with type B they go round the corner. An arc that leads in goes
//! through the tool's place and ends in the programmed direction. G40 changes nothing until the next move, which must be
//! straight and leads to its programmed end. On lathes (G18) what is shifted is the centre of the nose, and the tool's
//! orientation says where the point lies that moves are about.

use super::arc::Circle;
use super::canonical::{MoveKind, Plane};
use super::dialect::Dialect;
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{Group, Values};
use super::offset_curve::{Curve, Point, ROUNDING_MM, leading_in, minus, norm, plus_scaled, turn};
use super::offsets::Values9;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

#[cfg(test)]
mod tests;

/// Corners that turn by no more than this, radians, are passed as if there were none: LinuxCNC's `TOLERANCE_CONCAVE_CORNER`. The path
/// then comes nearer to an inside corner than the radius by at most radius x (1 - cos 0.05), an eighth of a percent of it.
pub const SMOOTH_CORNER: f64 = 0.05;

/// Number of blocks without a move behind which Fanuc's controls do not see the next move: parameter 19625 at its least.
const BLIND_BLOCKS: usize = 2;

/// Lead-ins of types A and B that end no farther apart than this are one.
const LEAD_IN_TOLERANCE_MM: f64 = 0.05;

/// Corners that turn by no more than this beyond a right angle, radians, are right angles.
const SHARP_CORNER: f64 = 1e-9;

const GOUGE: Cause = Cause::Compensation("the tool does not fit into this inside corner without gouging");
const SHORT_LEAD_IN: Cause = Cause::Compensation("the move that leads in is shorter than the tool's radius");
const BLIND_ARC: Cause = Cause::Compensation(
    "an arc at an inside corner behind two or more blocks without a move, where controls overcut (Fanuc's parameter 19625)",
);
const NO_LEAD_IN: Cause = Cause::Compensation("no arc leads from the tool's place into the shifted one");
const NARROW_ARC: Cause = Cause::Compensation("the tool's radius is not less than the arc's");

const IN_TILTED_PLANE: Cause =
    Cause::Compensation("it is not read in a tilted plane (G68.2): post the path of the tool's centre");

const STRAIGHT_IN: &str = "the move that leads in is followed by an outside corner: it goes straight to beside the start of the next move, as with Fanuc's parameter 5003#0 (SUP) at 0, type A; with type B the tool goes beside its end and round the corner";
const ROUND_IN: &str = "the move that leads in is followed by an outside corner: the tool goes beside its end and round the corner, as with type B (Haas's Setting 43, Fanuc's parameter 5003#0); with type A it goes straight to beside the start of the next move";

/// Whether and how the tool's centre leaves the programmed path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum Compensation {
    #[default]
    Off,
    On(Offset),
    /// Off, but the tool still is at this point of the plane.
    Leaving(Plane, Point),
}

/// Compensation in force. Points are axis positions of the plane's first and second axis, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offset {
    /// 410, 411, 420 or 421.
    pub code: i32,
    plane: Plane,
    /// Of the tool's centre to the left of the path; negative to the right.
    left: f64,
    /// From the tool's centre to the point that moves are about: not zero for lathe tools.
    control: Point,
    /// Whose corners it goes round.
    dialect: Dialect,
    /// Where the tool's centre is.
    at: Point,
    /// The last element; `None` before the move that leads in.
    last: Option<Element>,
}

/// An element of the shifted path and its index among the moves. Those behind it have moved none of the plane's axes.
#[derive(Clone, Copy, Debug)]
struct Element {
    index: usize,
    curve: Curve,
    leads_in: bool,
    /// `Interpreter::nc_blocks` at the element's block.
    block: usize,
}

/// How an element joins the one before.
#[derive(Clone, Copy, Debug)]
struct Joint {
    /// What is left of the element before.
    before: Option<Curve>,
    /// What leads round an outside corner.
    round: [Option<Curve>; 3],
    /// What is left of the new element.
    curve: Curve,
    /// Whether blocks without a move keep the control from seeing the new element in time: it overcuts.
    is_blind: bool,
    /// Whether the move before is the lead-in and a setting of the control decides where it ends.
    is_open: bool,
}

impl Joint {
    const fn plain(curve: Curve) -> Self {
        Self { before: None, round: [None; 3], curve, is_blind: false, is_open: false }
    }
}

impl Compensation {
    /// The compensation in force.
    pub fn on(&self) -> Option<&Offset> {
        if let Self::On(offset) = self { Some(offset) } else { None }
    }

    /// Whether G40 has been said and no move has been made since.
    pub fn is_leaving(&self) -> bool {
        matches!(self, Self::Leaving(..))
    }

    /// Puts the tool's place into a programmed position.
    pub fn place(&self, position: &mut Values9) {
        let (plane, [u, v]) = match self {
            Self::Off => return,
            Self::On(offset) => (offset.plane, plus_scaled(offset.at, 1.0, offset.control)),
            Self::Leaving(plane, point) => (*plane, *point),
        };
        let [first, second, _] = plane.axes();
        (position[first as usize], position[second as usize]) = (u, v);
    }
}

impl Offset {
    fn of_plane(&self, position: &Values9) -> Point {
        in_plane(position, self.plane)
    }

    /// How the shifted curve of the block of this count joins the element before, at the programmed corner.
    fn join(&self, corner: Point, curve: Curve, block: usize) -> Result<Joint, Cause> {
        // A line sets out from where the tool is; that is beside its shifted course in the move that leads in and behind a smooth corner.
        let plain = match curve {
            Curve::Line { to, direction, .. } => Curve::Line { from: self.at, to, direction },
            Curve::Arc { .. } => curve,
        };
        let plain = Joint::plain(plain);
        let Some(Element { curve: last, leads_in, block: before, .. }) = self.last else { return Ok(plain) };
        if self.left == 0.0 {
            return Ok(plain);
        }
        let turned = turn(last.direction_at_end(), curve.direction_at_start());
        let side = self.left.signum();
        let inwards = turned * side;
        if inwards.abs() <= SMOOTH_CORNER {
            return Ok(plain);
        }
        // Where the path turns back on itself, how the curves bend tells whether the tool is between them: it is where together they
        // bend away from its side.
        let is_inside = if inwards.abs() > PI - SMOOTH_CORNER {
            side * (last.bend(self.left) + curve.bend(self.left)) < 0.0
        } else {
            inwards > 0.0
        };
        // Type A leads to beside the start of the next element.
        let straight_in = match last {
            Curve::Line { from, direction, .. } if leads_in => Some(Curve::Line { from, to: curve.from(), direction }),
            _ => None,
        };
        let is_blind = self.dialect == Dialect::Fanuc && block > before + BLIND_BLOCKS;
        if is_inside {
            if is_blind {
                let is_arc = matches!(curve, Curve::Arc { .. });
                return if is_arc { Err(BLIND_ARC) } else { Ok(Joint { is_blind: true, ..plain }) };
            }
            if let Some(before) = straight_in.filter(|_| self.dialect.is_fanuc_like()) {
                return Ok(Joint { before: Some(before), curve, ..plain });
            }
            let (before, curve) = last.cut_where_they_meet(&curve).ok_or(GOUGE)?;
            return Ok(Joint { before: Some(before), curve, ..plain });
        }
        // Back on itself the path goes round its end, whichever side the turn seems to be to.
        let angle = if inwards < 0.0 { turned.abs() } else { TAU - turned.abs() };
        let apart = norm(minus(curve.from(), self.at));
        let is_open = straight_in.is_some() && self.dialect.is_fanuc_like() && apart > LEAD_IN_TOLERANCE_MM;
        if let Some(before) = straight_in.filter(|_| self.dialect == Dialect::Fanuc && !is_blind) {
            return Ok(Joint { before: Some(before), curve, is_open, ..plain });
        }
        if self.dialect == Dialect::Fanuc {
            return Ok(Joint { is_open, ..self.mitre(&last, curve, angle) });
        }
        let round = Curve::Arc { centre: corner, from: self.at, to: curve.from(), sweep: angle.copysign(-self.left) };
        Ok(Joint { round: [Some(round), None, None], curve, is_open, ..plain })
    }

    /// An outside corner that turns by `angle` in straight lines: one corner up to a right angle, then two, and what is left of an arc's
    /// tangent.
    fn mitre(&self, last: &Curve, curve: Curve, angle: f64) -> Joint {
        let radius = self.left.abs();
        let is_sharp = angle > FRAC_PI_2 + SHARP_CORNER;
        let beyond = if is_sharp { radius } else { radius * (angle / 2.0).tan() };
        let start = curve.direction_at_start();
        let first = plus_scaled(self.at, beyond, last.direction_at_end());
        let second = plus_scaled(curve.from(), -beyond, start);
        let line = |from: Point, to: Point| {
            let length = norm(minus(to, from));
            (length > ROUNDING_MM).then(|| Curve::Line { from, to, direction: minus(to, from).map(|x| x / length) })
        };
        let (rest, curve) = match curve {
            Curve::Line { to, direction, .. } => (None, Curve::Line { from: second, to, direction }),
            Curve::Arc { from, .. } => (line(second, from), curve),
        };
        let between = if is_sharp { line(first, second) } else { None };
        Joint { round: [line(self.at, first), between, rest], ..Joint::plain(curve) }
    }
}

fn in_plane(position: &Values9, plane: Plane) -> Point {
    let [first, second, _] = plane.axes();
    [position[first as usize], position[second as usize]]
}

/// From the centre of a lathe tool's nose to the point that moves are about, in radii along Z and X, by orientation (LinuxCNC, "Lathe
/// Tool Orientation"): 1 to 4 are corners of the square round the nose, 5 to 8 middles of its sides, 0 and 9 the centre.
const fn control_point(orientation: u8) -> Point {
    match orientation {
        1 => [1.0, -1.0],
        2 => [-1.0, -1.0],
        3 => [-1.0, 1.0],
        4 => [1.0, 1.0],
        5 => [1.0, 0.0],
        6 => [0.0, -1.0],
        7 => [-1.0, 0.0],
        8 => [0.0, 1.0],
        _ => [0.0, 0.0],
    }
}

impl Interpreter<'_> {
    /// G40, G41, G42, G41.1, G42.1.
    pub(super) fn set_compensation(&mut self, values: &Values) -> Result<(), Fault> {
        let Some(code) = values.code(Group::CutterCompensation) else { return Ok(()) };
        if self.ignores_compensation {
            values.drop_word('d');
            return Ok(());
        }
        if code.number == 400 {
            if let Compensation::On(offset) = self.compensation {
                let at = plus_scaled(offset.at, 1.0, offset.control);
                self.compensation = if at == offset.of_plane(&self.position) {
                    Compensation::Off
                } else {
                    Compensation::Leaving(offset.plane, at)
                };
            }
            return Ok(());
        }
        let plane = self.modes.plane;
        let (diameter, orientation) = self.compensated_tool(values, code.number)?;
        let similar = self.offsets.similar(plane);
        let refused = match plane {
            _ if self.is_tilted => return Err(code.fault(IN_TILTED_PLANE)),
            _ if self.compensation.on().is_some() => Some("cutter compensation is on already"),
            _ if self.tip_mm.is_some() => Some("cutter compensation under tool-centre-point control"),
            Plane::Yz => Some("cutter compensation in the YZ plane (G19)"),
            _ if similar.is_none() => {
                Some("cutter compensation in a plane that is turned, scaled or tilted out of the machine's")
            }
            Plane::Xy if orientation != 0 => Some("a lathe tool's orientation outside the ZX plane (G18)"),
            _ => None,
        };
        if let Some(why) = refused {
            return Err(code.fault(Cause::NotAllowed(why)));
        }
        let radius = diameter / 2.0;
        // A mirror makes left right.
        let is_left = matches!(code.number, 410 | 411) != similar.is_some_and(|similar| similar.mirrors);
        let left = if is_left { radius } else { -radius };
        let control = control_point(orientation).map(|x| x * radius);
        let mut tool = self.position;
        self.compensation.place(&mut tool);
        let at = minus(in_plane(&tool, plane), control);
        let offset = Offset { code: code.number, plane, left, control, dialect: self.setup.dialect, at, last: None };
        self.compensation = Compensation::On(offset);
        Ok(())
    }

    /// Diameter, mm, and orientation: of the tool of D, or of the one in the spindle; on Fanuc's mills of the offset of D, on its lathes of the
    /// offset of T; D and L themselves for G41.1 and G42.1.
    pub(super) fn compensated_tool(&self, values: &Values, code: i32) -> Result<(f64, u8), Fault> {
        let at_code = |cause| self.fault_at(values, Group::CutterCompensation, cause);
        if matches!(code, 411 | 421) {
            let diameter =
                self.take_length(values, 'd').ok_or_else(|| at_code(Cause::Missing("D, the tool's diameter,")))?;
            let orientation = values.take_whole('l', 0..=9, "L", "an orientation from 0 to 9")?.unwrap_or(0);
            return Ok((diameter, orientation as u8));
        }
        let has_numbers = self.has_offset_numbers();
        let number = if has_numbers {
            self.numbers.radius.ok_or_else(|| at_code(Cause::Missing("D, the number of the radius offset,")))?
        } else if let Some(offset) = self.numbers.radius {
            offset
        } else {
            let range = "a whole number from 0 to 99999";
            let named = values.take_whole('d', 0..=99_999, "D", range)?.map(i32::unsigned_abs);
            named.filter(|&tool| tool != 0).unwrap_or(self.tool)
        };
        if number == 0 && self.setup.dialect.is_fanuc_like() {
            return Ok((0.0, 0));
        }
        match self.tools.get(&number) {
            Some(tool) => Ok((tool.diameter_mm, tool.orientation)),
            None if number == 0 => Ok((0.0, 0)),
            None if values.has('d') => Err(values.fault('d', Cause::UnknownTool)),
            None => Err(at_code(Cause::UnknownTool)),
        }
    }

    /// A fault at the block's code of a group when compensation is on: it would change what the shifted path is about.
    pub(super) fn refuse_compensated(&self, values: &Values, group: Group, why: &'static str) -> Result<(), Fault> {
        match (values.code(group), self.compensation.on()) {
            (Some(code), Some(_)) => Err(code.fault(Cause::NotAllowed(why))),
            _ => Ok(()),
        }
    }

    /// A straight move to a programmed place.
    pub(super) fn straight_to(
        &mut self,
        target: Values9,
        kind: MoveKind,
        feed: Option<f64>,
        values: &Values,
    ) -> Result<(), Fault> {
        let Compensation::On(offset) = self.compensation else {
            self.compensation = Compensation::Off;
            self.position = target;
            return self.emit(kind, feed);
        };
        let (from, to) = (offset.of_plane(&self.position), offset.of_plane(&target));
        let length = norm(minus(to, from));
        let stays = length <= ROUNDING_MM;
        // Fanuc's and Haas's controls wait for a move in the plane.
        let waits = stays && offset.dialect.is_fanuc_like();
        if offset.last.is_none() && !waits && (length < offset.left.abs() - ROUNDING_MM || stays) {
            return Err(values.motion_fault(SHORT_LEAD_IN));
        }
        if !stays {
            let direction = minus(to, from).map(|x| x / length);
            let shifted = Curve::Line { from, to, direction }.shifted(offset.left);
            let joint = offset.join(from, shifted, self.nc_blocks).map_err(|cause| values.motion_fault(cause))?;
            self.follow(&joint, kind, feed)?;
        }
        self.position = target;
        self.emit(kind, feed)
    }

    /// An arc that is programmed as `circle`; the feed rate is the programmed arc's.
    pub(super) fn compensated_arc(
        &mut self,
        target: Values9,
        circle: &Circle,
        turns: i32,
        feed: Option<f64>,
        values: &Values,
    ) -> Result<(), Fault> {
        let Compensation::On(offset) = self.compensation else { return Ok(()) };
        let fault = |cause| values.motion_fault(cause);
        let (from, to) = (offset.of_plane(&self.position), offset.of_plane(&target));
        let radius = norm(minus(from, circle.centre)).min(norm(minus(to, circle.centre)));
        let leads_in = offset.last.is_none();
        if (leads_in || offset.left * circle.sweep > 0.0) && radius <= offset.left.abs() + ROUNDING_MM {
            return Err(fault(NARROW_ARC));
        }
        let shifted = Curve::Arc { centre: circle.centre, from, to, sweep: circle.sweep }.shifted(offset.left);
        let joint = if leads_in {
            let curve = leading_in(offset.at, &shifted, turns).ok_or_else(|| fault(NO_LEAD_IN))?;
            Joint::plain(curve)
        } else {
            offset.join(from, shifted, self.nc_blocks).map_err(fault)?
        };
        self.follow(&joint, MoveKind::Feed, feed)?;
        self.position = target;
        self.emit(offset.arc_move(&joint.curve), feed)
    }

    /// Shortens the element before, goes round the corner, and takes note of the new element, which is emitted next.
    fn follow(&mut self, joint: &Joint, kind: MoveKind, feed: Option<f64>) -> Result<(), Fault> {
        if joint.is_blind {
            self.note("an inside corner behind two or more blocks without a move in the plane: the control does not see this move in time and overcuts the corner; with a larger parameter 19625 it does not".to_owned());
        }
        if joint.is_open {
            let told = if joint.before.is_some() { STRAIGHT_IN } else { ROUND_IN };
            self.note_unknown(told.to_owned());
        }
        let block = self.nc_blocks;
        let Compensation::On(offset) = &mut self.compensation else { return Ok(()) };
        if let (Some(before), Some(Element { index, .. })) = (joint.before, offset.last) {
            let [u, v] = plus_scaled(before.to(), 1.0, offset.control);
            let [first, second, _] = offset.plane.axes();
            for step in &mut self.moves[index..] {
                (step.end[first], step.end[second]) = (u, v);
            }
            if let Curve::Arc { .. } = before {
                self.moves[index].kind = offset.arc_move(&before);
            }
        }
        for round in joint.round.into_iter().flatten() {
            let Compensation::On(offset) = &mut self.compensation else { return Ok(()) };
            offset.at = round.to();
            let kind = if kind == MoveKind::Rapid { kind } else { offset.arc_move(&round) };
            self.emit(kind, feed)?;
            if self.setup.dialect == Dialect::Haas {
                self.note_unknown("outside corners are rounded; where a control goes straight on there, the tool's centre goes up to 0.42 radii farther".to_owned());
            }
        }
        if let Compensation::On(offset) = &mut self.compensation {
            offset.at = joint.curve.to();
            let leads_in = offset.last.is_none();
            offset.last = Some(Element { index: self.moves.len(), curve: joint.curve, leads_in, block });
        }
        Ok(())
    }
}

impl Offset {
    /// A curve as a move: what has no arc in it is a feed.
    fn arc_move(&self, curve: &Curve) -> MoveKind {
        match *curve {
            Curve::Line { .. } => MoveKind::Feed,
            Curve::Arc { centre, sweep, .. } => {
                MoveKind::Arc { plane: self.plane, centre: plus_scaled(centre, 1.0, self.control), sweep }
            }
        }
    }
}
