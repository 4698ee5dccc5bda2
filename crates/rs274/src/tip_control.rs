//! Tool-centre-point control (G43.4), tool vectors (G43.5), and tilted planes (G68.2, G53.1): X, Y and Z say where the tool's tip is on
//! the workpiece, and the tool's length goes from the offsets into the moves.
//!
//! While all rotary axes stand at zero the tip is below the axes by the tool's length, on every machine. Elsewhere its place hangs on the
//! machine: [`Setup::kinematics`](super::setup::Setup::kinematics) knows.

use super::affine::Affine;
use super::canonical::{Axis, MoveKind, Position};
use super::dialect::Dialect;
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::kinematics::TipKinematics;
use super::modal::{Code, Group, Values};
use super::offsets::{Values9, from_canonical, to_canonical};

/// A rotary axis nearer than this to zero is at zero, degrees.
const AT_ZERO_DEG: f64 = 1e-9;

/// A place nearer than this to another is the same, mm: far above rounding, far below any controller's resolution.
const SAME_PLACE_MM: f64 = 1e-6;

/// Note on another tool length while LinuxCNC's kinematics lead the tip.
const LENGTH_IN_KINEMATICS: &str = "another tool length while a rotary axis is turned and the kinematics lead the tip: LinuxCNC may move X, Y and Z at once (`motion.tooloffset`); here they stay until the next move";

/// Note on kinematics that an output may have switched.
const OUTPUT: &str = "M67 or M68 has set an output before this move with a turned rotary axis: where that switches the kinematics (`motion.switchkins-type`) X, Y and Z go elsewhere; where it does not, `ignored_codes` says so";

/// Note on an origin with a turned axis of the table.
const TURNED_ORIGIN: &str = "a work offset with a turned axis of the table under tool-centre-point control or in a tilted plane: X, Y and Z are taken as if the table stood at zero; the control may take them as they lie on the table turned so";

/// Note on tool-centre-point control that begins on a turned table.
const TURNED_TABLE: &str = "G43.4 or G43.5 while the table is turned: Fanuc's controls (parameter 19696#5 at 0) take X, Y and Z from then on in the work coordinates as they lie on the table turned so; they are taken here as if the table stood at zero";

impl Interpreter<'_> {
    /// From now on the position is the tip's. A move that goes nowhere marks the change.
    pub(super) fn enter_tip_control(&mut self, code: &Code) -> Result<(), Fault> {
        let tool = self.offsets.tool;
        if tool.iter().enumerate().any(|(i, &x)| x != 0.0 && i != Axis::Z as usize) {
            let why = "a tool offset along another axis than Z under tool-centre-point control";
            return Err(code.fault(Cause::NotAllowed(why)));
        }
        let length = tool[Axis::Z as usize];
        let tip = self.through_machine(&self.position, -length, |machine, axes| machine.tip(axes, length));
        self.position = tip.map_err(|cause| code.fault(cause))?;
        self.offsets.tool = [0.0; 9];
        self.tip_mm = Some(length);
        self.emit(MoveKind::Dwell { seconds: 0.0 }, None)
    }

    /// The position is the axes' again, the tool's length an offset again.
    pub(super) fn leave_tip_control(&mut self, code: &Code) -> Result<(), Fault> {
        let Some(length) = self.tip_mm else { return Ok(()) };
        self.position = self.axes_of(&self.position).map_err(|cause| code.fault(cause))?;
        self.tip_mm = None;
        self.has_tool_vectors = false;
        self.offsets.tool[Axis::Z as usize] = length;
        self.emit(MoveKind::Dwell { seconds: 0.0 }, None)
    }

    /// Machine coordinates of a position, which under tool-centre-point control is the tip's: axis positions, unless kinematics lead the tip.
    pub(super) fn machine_coordinates(&self, position: &Values9) -> Result<Values9, Cause> {
        if self.is_switched { Ok(self.world(position)) } else { self.axes_of(position) }
    }

    /// World coordinates of a position, those of LinuxCNC's kinematics: the tip's with the tool's length added to Z.
    pub(super) fn world(&self, position: &Values9) -> Values9 {
        let mut world = *position;
        world[Axis::Z as usize] += self.tip_mm.unwrap_or(0.0);
        world
    }

    /// Notes that a change of the tool's length has moved the place in world coordinates `before`, which LinuxCNC keeps.
    pub(super) fn note_length_in_kinematics(&mut self, before: &Values9) {
        let now = self.world(&self.position);
        if self.is_switched && (0..3).any(|i| (now[i] - before[i]).abs() > SAME_PLACE_MM) {
            self.note_unknown(LENGTH_IN_KINEMATICS.to_owned());
        }
    }

    /// Axis positions of a position, which under tool-centre-point control is the tip's.
    fn axes_of(&self, position: &Values9) -> Result<Values9, Cause> {
        match self.tip_mm {
            Some(length) => self.through_machine(position, length, |machine, tip| machine.axes(tip, length)),
            None => Ok(*position),
        }
    }

    /// A position seen the other way: `shift` along Z while the rotary axes are at zero, else as the machine says.
    fn through_machine(
        &self,
        position: &Values9,
        shift: f64,
        seen: impl Fn(&dyn TipKinematics, &Position) -> Result<Position, String>,
    ) -> Result<Values9, Cause> {
        let mut position = *position;
        if !Axis::ALL.into_iter().any(|axis| is_turned(axis, &position)) {
            position[Axis::Z as usize] += shift;
            return Ok(position);
        }
        let seen = seen(self.machine()?, &to_canonical(&position)).map_err(Cause::Machine)?;
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            position[axis as usize] = seen[axis];
        }
        Ok(position)
    }

    /// Notes that Fanuc's tool-centre-point control begins in a block at whose `start` or end an axis of the table is turned.
    pub(super) fn note_turned_table(&mut self, values: &Values, start: &Values9) {
        let begins =
            matches!(values.number(Group::ToolLength), Some(434 | 435)) && self.setup.dialect == Dialect::Fanuc;
        let Some(machine) = self.setup.kinematics.as_ref().filter(|_| begins) else { return };
        let end = self.position;
        let is_off = |axis| machine.0.turns_work(axis) && (is_turned(axis, start) || is_turned(axis, &end));
        if Axis::ALL.into_iter().any(is_off) {
            self.note_unknown(TURNED_TABLE.to_owned());
        }
    }

    /// Notes that a move to `position` may go elsewhere: what LinuxCNC's outputs switch is not known, nor how Fanuc's and Haas's controls take an origin
    /// with a turned axis of the table while they lead the tip.
    pub(super) fn note_unknown_kinematics(&mut self, position: &Values9) {
        let Some(machine) = &self.setup.kinematics else { return };
        if self.setup.dialect.is_fanuc_like() && self.tip_mm.is_some() {
            let origin = self.offsets.to_machine(&[0.0; 9]);
            if Axis::ALL.into_iter().any(|axis| is_turned(axis, &origin) && machine.0.turns_work(axis)) {
                self.note_unknown(TURNED_ORIGIN.to_owned());
            }
        }
        if self.has_set_output && Axis::ALL.into_iter().any(|axis| is_turned(axis, position)) {
            self.note_unknown(OUTPUT.to_owned());
        }
    }

    /// The machine, or why nothing is known of it.
    fn machine(&self) -> Result<&dyn TipKinematics, Cause> {
        let why = "this while rotary axes are not at zero needs to know the machine: a scene with `[program.tool_centre_point]`";
        self.setup.kinematics.as_ref().map(|machine| &*machine.0).ok_or(Cause::NotAllowed(why))
    }

    /// Moves straight in machine coordinates, also under tool-centre-point control.
    pub(super) fn in_machine_coordinates(
        &mut self,
        values: &Values,
        group: Group,
        act: impl FnOnce(&mut Self) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let (Some(length), Some(code)) = (self.tip_mm, values.code(group)) else { return act(self) };
        if self.is_switched {
            let first = self.moves.len();
            self.position = self.world(&self.position);
            let moved = act(self);
            self.position[Axis::Z as usize] -= length;
            self.moves[first..].iter_mut().for_each(|step| step.end[Axis::Z] -= length);
            return moved;
        }
        let has_tool_vectors = self.has_tool_vectors;
        self.leave_tip_control(code)?;
        act(self)?;
        self.enter_tip_control(code)?;
        self.has_tool_vectors = has_tool_vectors;
        Ok(())
    }

    /// G43.5: turns the target's rotary axes such that the tool points along I, J, K.
    pub(super) fn point_tool(&self, values: &Values, target: &mut Values9) -> Result<(), Fault> {
        if !self.has_tool_vectors || !"ijk".chars().any(|letter| values.has(letter)) {
            return Ok(());
        }
        let code = values.motion_code();
        let given = ['i', 'j', 'k'].map(|letter| values.take(letter).unwrap_or(0.0));
        let mut vector = [0.0; 9];
        vector[..3].copy_from_slice(&given);
        self.offsets.to_machine_vector(&mut vector);
        self.orient(&code, [vector[0], vector[1], vector[2]], target).map(|_| ())
    }

    /// Turns the rotary axes of a position such that the tool points along `vector`. Returns the other positions that would do.
    fn orient(&self, code: &Code, vector: [f64; 3], position: &mut Values9) -> Result<Option<Values9>, Fault> {
        let machine = self.machine().map_err(|cause| code.fault(cause))?;
        let turned = machine.orient(vector, &to_canonical(&self.position));
        let (turned, other) = turned.map_err(|why| code.fault(Cause::Machine(why)))?;
        let turned = from_canonical(&turned);
        for axis in Axis::ALL.into_iter().filter(|axis| axis.is_rotary()) {
            position[axis as usize] = turned[axis as usize];
        }
        Ok(other.map(|other| from_canonical(&other)))
    }

    /// G68.2: coordinates in a plane with its origin at X, Y, Z, tilted by Euler's angles I, J, K (about Z, the new X, the new Z).
    pub(super) fn tilt(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        if self.tip_mm.is_some() && !self.is_tilted {
            let why = "a tilted plane under tool-centre-point control; end that first, by G49 or the machine's M code";
            return Err(code.fault(Cause::NotAllowed(why)));
        }
        if self.transforms.are_on() {
            let why = "a tilted plane in turned, scaled or mirrored coordinates; cancel those first (G69, G50, G50.1)";
            return Err(code.fault(Cause::NotAllowed(why)));
        }
        check_p0(values, "a tilted plane by other than Euler's angles (P0)")?;
        self.untransform(code)?;
        let origin = [Axis::X, Axis::Y, Axis::Z].map(|axis| self.take_axis(values, axis).unwrap_or(0.0));
        self.note_missing_points(values, "ijk");
        let angles = ['i', 'j', 'k'].map(|letter| values.take(letter).unwrap_or(0.0));
        self.enter_tip_control(code)?;
        self.is_tilted = true;
        self.offsets.local = Some(Affine::tilted(angles, origin));
        Ok(())
    }

    /// G53.1: turns the rotary axes until the tool stands upright on the tilted plane; X, Y and Z of the machine stay.
    pub(super) fn turn_upright(&mut self, values: &Values, code: &Code) -> Result<(), Fault> {
        if !self.is_tilted {
            return Err(code.fault(Cause::NotAllowed("G53.1 without a tilted plane (G68.2)")));
        }
        check_p0(values, "another way to choose the rotary axes' positions than that of G53.1 without P")?;
        let mut normal = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        self.offsets.to_machine_vector(&mut normal);
        self.leave_tip_control(code)?;
        let mut target = self.position;
        if let Some(other) = self.orient(code, [normal[0], normal[1], normal[2]], &mut target)? {
            let differ = |axis: &Axis| axis.is_rotary() && target[*axis as usize] != other[*axis as usize];
            let axes: Vec<Axis> = Axis::ALL.into_iter().filter(differ).collect();
            let [taken, other] = [&target, &other].map(|position| degrees(position, &axes));
            self.note(format!(
                "G53.1 turns to {taken}; at {other} the tool is upright, too, and another control may turn there"
            ));
        }
        self.rapid_to(target)?;
        self.enter_tip_control(code)
    }

    /// G69 and what else ends turned, tilted, scaled or mirrored coordinates.
    pub(super) fn untransform(&mut self, code: &Code) -> Result<(), Fault> {
        if self.compensation.on().is_some() {
            return Err(code.fault(Cause::NotAllowed("other coordinates while cutter compensation is on")));
        }
        if self.is_tilted {
            self.leave_tip_control(code)?;
            self.is_tilted = false;
        }
        self.offsets.local = None;
        Ok(())
    }
}

/// Whether an axis is rotary and does not stand at a multiple of 360 degrees.
fn is_turned(axis: Axis, position: &Values9) -> bool {
    let degrees = position[axis as usize];
    axis.is_rotary() && (degrees - 360.0 * (degrees / 360.0).round()).abs() > AT_ZERO_DEG
}

/// Refuses a P other than 0.
fn check_p0(values: &Values, why: &'static str) -> Result<(), Fault> {
    match values.take_whole('p', 0..=9, "P", "a whole number")? {
        None | Some(0) => Ok(()),
        Some(_) => Err(values.fault('p', Cause::NotAllowed(why))),
    }
}

/// Positions of rotary axes as words, to a thousandth of a degree.
fn degrees(position: &Values9, axes: &[Axis]) -> String {
    // Adding zero turns -0 into 0.
    let value = |axis: Axis| (position[axis as usize] * 1e3).round() / 1e3 + 0.0;
    axes.iter().map(|&axis| format!("{}{}", axis.letter(), value(axis))).collect::<Vec<_>>().join(" ")
}
