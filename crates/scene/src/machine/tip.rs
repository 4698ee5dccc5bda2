//! Tool-centre-point control: from the position of the tool's tip relative to the workpiece to the positions of the linear axes.
//!
//! Under this control, a program gives the positions of the rotary axes, and the path of the tip over the workpiece as if the rotary axes
//! were at zero. For given rotary axes, the tip in the workpiece's frame is an affine function of X, Y and Z, whatever the machine's
//! structure is: rotary table, rotary head, or one axis on each. Three linear equations give the unique solution.

use super::tree::Machine;
use crate::geometry::{Point, Vector};
use nalgebra::{Matrix3, Unit};
use rs274::{Axis, Kinematics, Position, TipKinematics};
use std::sync::Arc;
use thiserror::Error;

/// The linear axes that follow the tip.
const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
/// Smallest singular value of the three equations, mm of tip per mm of axis, for which they are solved. Below it, an axis would move more
/// than a thousand times as far as the tip.
const SINGULAR: f64 = 1e-3;

/// The links that carry the tool and the workpiece.
#[derive(Clone, Debug, PartialEq)]
pub struct TipControl {
    /// The link that carries the tool; `None` is the world.
    pub tool_link: Option<usize>,
    /// Position of the tip of a tool of length zero, in that link's frame, mm.
    pub gauge: Point,
    /// Direction from that position towards the tip, in that link's frame.
    pub direction: Unit<Vector>,
    /// The link that carries the workpiece.
    pub work_link: Option<usize>,
}

/// Largest distance of the tip from the requested position at the solution, mm. A nanometre is far above rounding, and far below any
/// controller's resolution.
const MISSED_MM: f64 = 1e-6;

/// X, Y and Z cannot bring the tip to the requested position.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum TipError {
    /// The three axes move the tip in one plane, or along one line.
    #[error("with the rotary axes where they are, X, Y and Z cannot move the tool's tip in every direction")]
    Singular,
    /// The tip is not where the three linear equations say: an axis among X, Y and Z does not slide, or positions are too large for
    /// their arithmetic.
    #[error("X, Y and Z cannot bring the tool's tip to its place: at the solution it is {mm:e} mm off")]
    Missed {
        /// Distance from the requested position, mm.
        mm: f64,
    },
}

/// A letter of a linear axis turns a joint between tool and workpiece, which tool-centre-point control does not know as a rotary axis.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "axis {axis} turns link `{link}` between tool and workpiece; under tool-centre-point control X Y Z U V W must slide there, and A B C turn"
)]
pub struct TurningLetter {
    /// The letter.
    pub axis: char,
    /// The link that it turns.
    pub link: String,
}

impl TipControl {
    /// Checks that all joints between tool and workpiece that turn have a letter of a rotary axis.
    ///
    /// # Errors
    /// [`TurningLetter`] for the first joint, from the tool to the workpiece, that does not.
    pub fn check(&self, machine: &Machine) -> Result<(), TurningLetter> {
        let tool = machine.up_to_shared(self.tool_link, self.work_link);
        for link in tool.chain(machine.up_to_shared(self.work_link, self.tool_link)) {
            let link = &machine.links()[link];
            if let Some(joint) = link.joint.as_ref().filter(|joint| joint.turns() && !joint.axis.is_rotary()) {
                return Err(TurningLetter { axis: joint.axis.letter(), link: link.name.clone() });
            }
        }
        Ok(())
    }

    /// Directions in which X, Y and Z move the tip over the workpiece at a position, mm per mm, in the frame of the workpiece's link. The
    /// direction of an axis that the machine lacks, as a lathe lacks Y, completes a right-handed frame; it is zero where two are missing. It
    /// is zero, too, for an axis that moves something else.
    pub fn directions(&self, machine: &Machine, position: &Position) -> [Vector; 3] {
        let at = self.tip(machine, position, 0.0);
        let mut columns = LINEAR.map(|axis| {
            let mut moved = *position;
            moved[axis] += UNIT_MM;
            (self.tip(machine, &moved, 0.0) - at) / UNIT_MM
        });
        for i in 0..3 {
            if columns[i] == Vector::zeros() && machine.joints_of(LINEAR[i]).next().is_none() {
                columns[i] = columns[(i + 1) % 3].cross(&columns[(i + 2) % 3]);
            }
        }
        columns
    }

    /// [`TipControl::directions`] with all axes at zero, in the world frame, as columns. Where two axes are missing, nothing but the world's axes
    /// say where they would go.
    pub fn axes_at_zero(&self, machine: &Machine) -> Matrix3<f64> {
        let zero = Position::default();
        let world_from_work = machine.forward(&zero).world_from(self.work_link).rotation;
        let mut columns = self.directions(machine, &zero).map(|direction| world_from_work * direction);
        for (axis, column) in columns.iter_mut().enumerate().filter(|(_, column)| **column == Vector::zeros()) {
            *column = Vector::ith(axis, 1.0);
        }
        Matrix3::from_columns(&columns)
    }

    /// Takes a direction as programs give it, along X, Y and Z as they are while all axes are at zero, to the frame of
    /// [`TipControl::tool_vector`].
    ///
    /// # Errors
    /// [`TipError::Singular`] when these three axes lie in one plane.
    pub fn world_direction(&self, machine: &Machine, direction: &Unit<Vector>) -> Result<Unit<Vector>, TipError> {
        let axes = self.axes_at_zero(machine);
        if axes.singular_values().min() < SINGULAR {
            return Err(TipError::Singular);
        }
        Ok(Unit::new_normalize(axes * direction.into_inner()))
    }

    /// The first of X, Y and Z that the machine has and that moves neither the tool nor the workpiece against the other: the link of one of the
    /// two is then another one.
    pub fn idle_axis(&self, machine: &Machine, position: &Position) -> Option<Axis> {
        let directions = LINEAR.into_iter().zip(self.directions(machine, position));
        let mut idle = directions.filter(|(_, direction)| *direction == Vector::zeros()).map(|(axis, _)| axis);
        idle.find(|&axis| machine.joints_of(axis).next().is_some())
    }

    /// The tip of a tool of `length_mm` in the frame of the workpiece's link, mm.
    pub fn tip(&self, machine: &Machine, position: &Position, length_mm: f64) -> Point {
        let poses = machine.forward(position);
        let tip = self.gauge + self.direction.into_inner() * length_mm;
        poses.world_from(self.work_link).inverse() * (poses.world_from(self.tool_link) * tip)
    }

    /// Axis positions that bring the tip to `programmed`. X, Y and Z of `programmed` are the tip's position in machine coordinates with all
    /// rotary axes at zero (there, an axis position is the tip's position plus the tool length along Z). The other axes of `programmed` are
    /// kept.
    ///
    /// # Errors
    /// When the linear axes cannot bring the tip there.
    pub fn axes(&self, machine: &Machine, programmed: &Position, length_mm: f64) -> Result<Position, TipError> {
        let mut at_zero = *programmed;
        for axis in Axis::ALL.into_iter().filter(|axis| axis.is_rotary()) {
            at_zero[axis] = 0.0;
        }
        at_zero[Axis::Z] += length_mm;
        let wanted = self.tip(machine, &at_zero, length_mm);
        self.linear_axes(machine, programmed, &wanted, length_mm)
    }

    /// The position that a program gives under tool-centre-point control for a tip at `tip`, mm, in the frame of the link that carries the
    /// workpiece. The rotary axes are those of `position`. X, Y, Z are in machine coordinates, as [`TipControl::axes`] expects them.
    ///
    /// # Errors
    /// When the linear axes cannot move the tip in every direction with all rotary axes at zero.
    pub fn programmed(
        &self,
        machine: &Machine,
        position: &Position,
        tip: &Point,
        length_mm: f64,
    ) -> Result<Position, TipError> {
        let mut at_zero = *position;
        for axis in Axis::ALL.into_iter().filter(|axis| axis.is_rotary()) {
            at_zero[axis] = 0.0;
        }
        let solved = self.linear_axes(machine, &at_zero, tip, length_mm)?;
        let mut programmed = *position;
        LINEAR.iter().for_each(|&axis| programmed[axis] = solved[axis]);
        programmed[Axis::Z] -= length_mm;
        Ok(programmed)
    }

    /// The control of this machine in the form that the interpreter of programs uses.
    pub fn kinematics(&self, machine: &Machine) -> Kinematics {
        Kinematics(Arc::new(ControlledMachine { machine: machine.clone(), control: self.clone() }))
    }

    /// The position with the linear axes set such that the tip is at `wanted`, in the frame of the workpiece's link.
    fn linear_axes(
        &self,
        machine: &Machine,
        position: &Position,
        wanted: &Point,
        length_mm: f64,
    ) -> Result<Position, TipError> {
        let mut position = *position;
        LINEAR.iter().for_each(|&axis| position[axis] = 0.0);
        let base = self.tip(machine, &position, length_mm);
        let columns = LINEAR.map(|axis| {
            let mut moved = position;
            moved[axis] = UNIT_MM;
            (self.tip(machine, &moved, length_mm) - base) / UNIT_MM
        });
        let matrix = Matrix3::from_columns(&columns);
        if matrix.singular_values().min() < SINGULAR {
            return Err(TipError::Singular);
        }
        let solution = matrix.lu().solve(&(wanted - base)).ok_or(TipError::Singular)?;
        LINEAR.iter().zip(solution.iter()).for_each(|(&axis, &value)| position[axis] = value);
        match (self.tip(machine, &position, length_mm) - wanted).norm() {
            mm if mm <= MISSED_MM => Ok(position),
            mm => Err(TipError::Missed { mm }),
        }
    }
}

/// A machine, and the links that carry tool and workpiece.
#[derive(Debug)]
struct ControlledMachine {
    machine: Machine,
    control: TipControl,
}

impl TipKinematics for ControlledMachine {
    fn tip(&self, axes: &Position, length_mm: f64) -> Result<Position, String> {
        let tip = self.control.tip(&self.machine, axes, length_mm);
        self.control.programmed(&self.machine, axes, &tip, length_mm).map_err(|error| error.to_string())
    }

    fn axes(&self, tip: &Position, length_mm: f64) -> Result<Position, String> {
        self.control.axes(&self.machine, tip, length_mm).map_err(|error| error.to_string())
    }

    fn orient(&self, vector: [f64; 3], axes: &Position) -> Result<(Position, Option<Position>), String> {
        let vector = Unit::try_new(Vector::from(vector), f64::MIN_POSITIVE);
        let vector = vector.ok_or_else(|| "a tool vector of no length".to_owned())?;
        let vector = self.control.world_direction(&self.machine, &vector).map_err(|error| error.to_string())?;
        let solutions = self.control.orient(&self.machine, &vector, axes).map_err(|error| error.to_string())?;
        solutions.chosen.limits.map_err(|error| error.to_string())?;
        let other = solutions.other.filter(|other| other.limits.is_ok());
        Ok((solutions.chosen.position, other.map(|other| other.position)))
    }

    fn turns_work(&self, axis: Axis) -> bool {
        let links = self.machine.up_to_shared(self.control.work_link, self.control.tool_link);
        let mut joints = links.filter_map(|link| self.machine.links()[link].joint.as_ref());
        joints.any(|joint| joint.axis == axis && joint.turns())
    }
}

/// Travel by which the effect of an axis is determined, mm; large, so that rounding errors are relatively small.
const UNIT_MM: f64 = 1024.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;
    use crate::machine::joint::{Joint, Limits};
    use crate::machine::tree::Link;
    use nalgebra::Matrix4;
    use proptest::prelude::*;

    fn link(name: &str, parent: Option<&str>, shift: [f64; 3], joint: Joint) -> Link {
        let parent_from_link = Isometry::translation(shift[0], shift[1], shift[2]);
        Link { name: name.into(), parent: parent.map(Into::into), parent_from_link, joint: Some(joint) }
    }

    fn slide(axis: Axis, direction: Vector) -> Joint {
        Joint::prismatic(axis, direction, Limits::NONE).unwrap()
    }

    fn turn(axis: Axis, direction: Vector, point: [f64; 3]) -> Joint {
        Joint::rotary(axis, direction, Point::from(point), Limits::NONE).unwrap()
    }

    /// A machine with X and Y under a table that tilts about A and rotates about C, and with the head on Z.
    fn table_table() -> (Machine, TipControl) {
        let machine = Machine::new(vec![
            link("x", None, [0.0; 3], slide(Axis::X, -Vector::x())),
            link("y", Some("x"), [0.0; 3], slide(Axis::Y, -Vector::y())),
            link("a", Some("y"), [0.0; 3], turn(Axis::A, -Vector::x(), [0.0, 3.0, 40.0])),
            link("c", Some("a"), [0.0; 3], turn(Axis::C, -Vector::z(), [1.0, 2.0, 0.0])),
            link("z", None, [0.0, 0.0, 200.0], slide(Axis::Z, Vector::z())),
        ])
        .unwrap();
        let control = TipControl {
            tool_link: Some(4),
            gauge: Point::new(0.0, 0.0, -10.0),
            direction: -Vector::z_axis(),
            work_link: Some(3),
        };
        (machine, control)
    }

    /// A head that tilts about B over a table that turns about C.
    fn head_table() -> (Machine, TipControl) {
        let machine = Machine::new(vec![
            link("x", None, [0.0; 3], slide(Axis::X, -Vector::x())),
            link("c", Some("x"), [0.0; 3], turn(Axis::C, Vector::z(), [5.0, 0.0, 0.0])),
            link("y", None, [0.0; 3], slide(Axis::Y, Vector::y())),
            link("z", Some("y"), [0.0, 0.0, 300.0], slide(Axis::Z, Vector::z())),
            link("b", Some("z"), [0.0; 3], turn(Axis::B, Vector::y(), [0.0, 0.0, 30.0])),
        ])
        .unwrap();
        let control =
            TipControl { tool_link: Some(4), gauge: Point::origin(), direction: -Vector::z_axis(), work_link: Some(1) };
        (machine, control)
    }

    /// A fork head: C carries A.
    fn head_head() -> (Machine, TipControl) {
        let machine = Machine::new(vec![
            link("x", None, [0.0; 3], slide(Axis::X, Vector::x())),
            link("y", Some("x"), [0.0; 3], slide(Axis::Y, Vector::y())),
            link("z", Some("y"), [0.0, 0.0, 500.0], slide(Axis::Z, Vector::z())),
            link("c", Some("z"), [0.0; 3], turn(Axis::C, Vector::z(), [0.0; 3])),
            link("a", Some("c"), [0.0; 3], turn(Axis::A, Vector::x(), [0.0, 0.0, 80.0])),
        ])
        .unwrap();
        let control =
            TipControl { tool_link: Some(4), gauge: Point::origin(), direction: -Vector::z_axis(), work_link: None };
        (machine, control)
    }

    #[test]
    fn what_is_programmed_brings_the_tip_back() {
        for (machine, control) in [table_table(), head_table(), head_head()] {
            let mut position = Position::default();
            (position[Axis::A], position[Axis::B], position[Axis::C]) = (0.3, -0.2, 1.1);
            let tip = Point::new(12.0, -34.0, 56.0);
            let programmed = control.programmed(&machine, &position, &tip, 80.0).unwrap();
            assert_eq!(programmed[Axis::A], 0.3);
            let axes = control.axes(&machine, &programmed, 80.0).unwrap();
            assert!((control.tip(&machine, &axes, 80.0) - tip).norm() < 1e-9);
        }
    }

    /// The tip in the workpiece's frame by homogeneous matrices, written out for each machine without the joint tree.
    fn independent(which: usize, q: &Position, length: f64) -> Point {
        let shift = |x: f64, y: f64, z: f64| Matrix4::new_translation(&Vector::new(x, y, z));
        let about = |axis: Vector, angle: f64, p: [f64; 3]| {
            shift(p[0], p[1], p[2])
                * Matrix4::from_axis_angle(&Unit::new_normalize(axis), angle)
                * shift(-p[0], -p[1], -p[2])
        };
        let (x, y, z) = (q[Axis::X], q[Axis::Y], q[Axis::Z]);
        let (work, tool) = match which {
            0 => (
                shift(-x, -y, 0.0)
                    * about(-Vector::x(), q[Axis::A], [0.0, 3.0, 40.0])
                    * about(-Vector::z(), q[Axis::C], [1.0, 2.0, 0.0]),
                shift(0.0, 0.0, 200.0 + z - 10.0 - length),
            ),
            1 => (
                shift(-x, 0.0, 0.0) * about(Vector::z(), q[Axis::C], [5.0, 0.0, 0.0]),
                shift(0.0, y, 300.0 + z) * about(Vector::y(), q[Axis::B], [0.0, 0.0, 30.0]) * shift(0.0, 0.0, -length),
            ),
            _ => (
                Matrix4::identity(),
                shift(x, y, 500.0 + z)
                    * about(Vector::z(), q[Axis::C], [0.0; 3])
                    * about(Vector::x(), q[Axis::A], [0.0, 0.0, 80.0])
                    * shift(0.0, 0.0, -length),
            ),
        };
        let inverse = work.try_inverse().expect("a rigid motion has an inverse");
        Point::from_homogeneous(inverse * tool * Point::origin().to_homogeneous()).expect("an affine motion")
    }

    proptest! {
        #[test]
        fn the_tip_stays_where_the_program_says(
            which in 0..3usize,
            linear in prop::array::uniform3(-200.0..200.0f64),
            angles in prop::array::uniform2(-3.0..3.0f64),
            length in 0.0..150.0f64,
        ) {
            let (machine, control) = [table_table(), head_table(), head_head()][which].clone();
            let mut programmed = Position::default();
            LINEAR.iter().zip(linear).for_each(|(&axis, value)| programmed[axis] = value);
            let rotary = [[Axis::A, Axis::C], [Axis::B, Axis::C], [Axis::A, Axis::C]][which];
            rotary.iter().zip(angles).for_each(|(&axis, angle)| programmed[axis] = angle);
            let axes = control.axes(&machine, &programmed, length).unwrap();
            let mut at_zero = programmed;
            rotary.iter().for_each(|&axis| at_zero[axis] = 0.0);
            at_zero[Axis::Z] += length;
            let (found, wanted) = (independent(which, &axes, length), independent(which, &at_zero, length));
            prop_assert!((found - wanted).norm() < 1e-9, "{} {}", found, wanted);
            // With the rotary axes at zero nothing follows: the axes are the programmed ones and the length.
            let plain = control.axes(&machine, &Position(std::array::from_fn(|i| if i < 3 { programmed.0[i] } else { 0.0 })), length).unwrap();
            prop_assert!(LINEAR.iter().all(|&axis| (plain[axis] - at_zero[axis]).abs() < 1e-9));
        }
    }

    fn setup(machine: &Machine, control: &TipControl) -> rs274::Setup {
        let tool = rs274::Tool::with_length(80.0, 10.0);
        rs274::Setup {
            tools: [(1, tool)].into(),
            kinematics: Some(control.kinematics(machine)),
            ..rs274::Setup::default()
        }
    }

    fn interpreted(program: &str, machine: &Machine, control: &TipControl) -> Result<rs274::Program, String> {
        rs274::interpret(program, std::path::Path::new("tip.ngc"), &setup(machine, control))
            .map_err(|error| error.to_string())
    }

    /// The axes at the end of a program's moves, and the last tool length under tool-centre-point control.
    fn axes_after(program: &str, machine: &Machine, control: &TipControl) -> Position {
        let program = interpreted(program, machine, control).unwrap_or_else(|e| panic!("{e}"));
        let last = program.moves.last().unwrap();
        last.tip_mm.map_or(last.end, |length| control.axes(machine, &last.end, length).unwrap())
    }

    fn differ(a: &Position, b: &Position) -> f64 {
        a.0.iter().zip(b.0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn control_is_switched_while_the_axes_are_tilted_and_moves_nothing() {
        for (machine, control) in [table_table(), head_table(), head_head()] {
            let rotary = if machine.links().iter().any(|link| link.name == "b") { "B" } else { "A" };
            let there = format!("G0 X20 Y-30 Z100 {rotary}30 C45\n");
            let before = axes_after(&format!("{there}M2"), &machine, &control);
            for switch in ["G43.4 H1\n", "G43.4 H1\nG49\n", "G43 H1\nG43.4 H1\nG49\n", "G43.5 H1\nG43.4 H1\n"] {
                let after = axes_after(&format!("{there}{switch}M2"), &machine, &control);
                assert!(differ(&before, &after) < 1e-9, "{switch}: {before:?} {after:?}");
            }
            // The tip goes where the program says: 5 mm above the workpiece's zero.
            let at = axes_after(&format!("{there}G43.4 H1\nG0 X0 Y0 Z5\nM2"), &machine, &control);
            let upright = Position([0.0, 0.0, 85.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let [found, wanted] = [&at, &upright].map(|axes| control.tip(&machine, axes, 80.0));
            assert!((found - wanted).norm() < 1e-9, "{found} {wanted}");
            // The machine's own coordinates are still to be had: Z alone goes to 200.
            let up = axes_after(&format!("{there}G43.4 H1\nG0 X0 Y0 Z5\nG53 G0 Z200\nM2"), &machine, &control);
            let mut wanted = at;
            wanted[Axis::Z] = 200.0;
            assert!(differ(&up, &wanted) < 1e-9, "{up:?} {wanted:?}");
            let home = axes_after(&format!("{there}G43.4 H1\nG0 X0 Y0 Z5\nG91 G28 Z0\nM2"), &machine, &control);
            wanted[Axis::Z] = 0.0;
            assert!(differ(&home, &wanted) < 1e-9, "{home:?} {wanted:?}");
        }
    }

    #[test]
    fn control_of_fanucs_that_begins_on_a_turned_table_is_told() {
        let tables = [(table_table(), [true, true]), (head_table(), [false, true]), (head_head(), [false, false])];
        for ((machine, control), turn_work) in tables {
            let tilting = if machine.links().iter().any(|link| link.name == "b") { "B" } else { "A" };
            let is_told = |program: &str, dialect| {
                let setup = rs274::Setup { dialect, units: Some(rs274::Units::Mm), ..setup(&machine, &control) };
                let program = format!("{program}\nM30");
                let found = rs274::interpret(&program, std::path::Path::new("tip.nc"), &setup).unwrap();
                found.notes.iter().any(|note| note.is_unknown && note.text.contains("while the table is turned"))
            };
            for (axis, turns_work) in [tilting, "C"].into_iter().zip(turn_work) {
                for (program, is_turned) in [
                    ("G0Z50.?30.\nG43.4H1", true),
                    ("G43.4H1G0Z50.?30.", true),
                    ("G0Z50.?30.\nG43.5H1?0.", true),
                    ("G0Z50.?360.\nG43.4H1", false),
                    ("G43.4H1G0Z50.\n?30.", false),
                    ("G0Z50.?30.\nG43H1", false),
                ] {
                    let program = program.replace('?', axis);
                    assert_eq!(is_told(&program, rs274::Dialect::Fanuc), is_turned && turns_work, "{program}");
                    assert!(!is_told(&program, rs274::Dialect::LinuxCnc), "{program}");
                }
            }
            // A vector turns in the block that begins.
            assert_eq!(is_told("G43.5H1G0Z50.I0.J1.K3.", rs274::Dialect::Fanuc), turn_work.contains(&true));
        }
    }

    #[test]
    fn in_a_tilted_plane_the_tool_stands_upright_on_it_and_the_tip_is_where_the_program_says() {
        for (machine, control) in [table_table(), head_table(), head_head()] {
            for tool in
                ["G43 H1\nG68.2 X10 Y20 Z-5 I30 J25 K0\nG53.1\n", "G68.2 X10 Y20 Z-5 I30 J25 K0\nG53.1\nG43 H1\n"]
            {
                let at = axes_after(&format!("{tool}G0 X3 Y4 Z2\nM2"), &machine, &control);
                // The plane's axes: X turned by 30 about Z, then the plane by 25 about that X.
                let turn = nalgebra::Rotation3::from_axis_angle(&Vector::z_axis(), 30_f64.to_radians())
                    * nalgebra::Rotation3::from_axis_angle(&Vector::x_axis(), 25_f64.to_radians());
                let place = Vector::new(10.0, 20.0, -5.0) + turn * Vector::new(3.0, 4.0, 2.0);
                let upright = Position([place.x, place.y, place.z + 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                let [found, wanted] = [&at, &upright].map(|axes| control.tip(&machine, axes, 80.0));
                assert!((found - wanted).norm() < 1e-9, "{tool}: {found} {wanted}");
                let vector = control.tool_vector(&machine, &at);
                assert!((vector.into_inner() - turn * Vector::z()).norm() < 1e-9, "{tool}: {vector:?}");
                // G53.1 itself moves the rotary axes alone, and after G69 X, Y and Z are the machine's.
                let turned = axes_after("G0 X1 Y2 Z3\nG68.2 I30 J25 K0\nG53.1\nG69\nM2", &machine, &control);
                assert!(LINEAR.iter().zip([1.0, 2.0, 3.0]).all(|(&axis, wanted)| (turned[axis] - wanted).abs() < 1e-9));
                let plain = axes_after(&format!("{tool}G69\nG0 X7 Y8 Z9\nM2"), &machine, &control);
                assert_eq!((plain[Axis::X], plain[Axis::Y], plain[Axis::Z]), (7.0, 8.0, 89.0));
            }
        }
    }

    #[test]
    fn upright_takes_the_least_travel_of_the_axis_nearer_to_the_base_and_names_the_other_way() {
        let (machine, control) = table_table();
        let plane = "G0 A20 C0\nG68.2 I100 J30 K0\n";
        for code in ["G53.1", "G53.1 P0"] {
            let at = axes_after(&format!("{plane}{code}\nM2"), &machine, &control);
            let found = [Axis::A, Axis::C].map(|axis| (at[axis].to_degrees() * 1e6).round() / 1e6);
            assert_eq!(found, [30.0, 100.0], "{code}");
        }
        let program = interpreted(&format!("{plane}G53.1\nM2"), &machine, &control).unwrap();
        let told = "G53.1 turns to A30 C100; at A-30 C-80 the tool is upright, too, and another control may turn there";
        assert_eq!(program.notes.iter().map(|note| (note.line, &*note.text)).collect::<Vec<_>>(), [(3, told)]);
        let error = interpreted(&format!("{plane}G53.1 P1\nM2"), &machine, &control).unwrap_err();
        assert!(error.contains("tip.ngc:3:7") && error.contains("another way to choose"), "{error}");
    }

    #[test]
    fn tool_vectors_turn_the_rotary_axes() {
        for (machine, control) in [table_table(), head_table(), head_head()] {
            let at = axes_after("G43.5 H1\nG1 X5 Y6 Z7 I1 J2 K3 F100\nM2", &machine, &control);
            let vector = control.tool_vector(&machine, &at).into_inner();
            assert!((vector - Vector::new(1.0, 2.0, 3.0).normalize()).norm() < 1e-9, "{vector}");
            let upright = Position([5.0, 6.0, 87.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let [found, wanted] = [&at, &upright].map(|axes| control.tip(&machine, axes, 80.0));
            assert!((found - wanted).norm() < 1e-9, "{found} {wanted}");
        }
    }

    /// The machine as a drawing has it that stands askew in the world.
    fn askew(machine: &Machine, control: &TipControl) -> (Machine, TipControl) {
        let mut links = machine.links().to_vec();
        let base = Some(links.len());
        for link in links.iter_mut().filter(|link| link.parent.is_none()) {
            link.parent = Some("base".to_owned());
        }
        let turn = nalgebra::UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0);
        let parent_from_link = Isometry::from_parts(nalgebra::Translation3::new(70.0, 80.0, 90.0), turn);
        links.push(Link { name: "base".to_owned(), parent: None, parent_from_link, joint: None });
        let (tool_link, work_link) = (control.tool_link.or(base), control.work_link.or(base));
        (Machine::new(links).unwrap(), TipControl { tool_link, work_link, ..control.clone() })
    }

    #[test]
    fn a_machine_that_is_drawn_askew_turns_its_axes_no_other_way() {
        for (machine, control) in [table_table(), head_table(), head_head()] {
            let (askew_machine, askew_control) = askew(&machine, &control);
            for program in [
                "G43 H1\nG68.2 X10 Y20 Z-5 I30 J25 K0\nG53.1\nG0 X3 Y4 Z2\nM2",
                "G43 H1\nG68.2 X10 Y20 Z-5\nG53.1\nG0 X3 Y4 Z2\nM2",
                "G43.5 H1\nG1 X5 Y6 Z7 I1 J2 K3 F100\nM2",
            ] {
                let wanted = axes_after(program, &machine, &control);
                let found = axes_after(program, &askew_machine, &askew_control);
                assert!(differ(&found, &wanted) < 1e-9, "{program}: {found:?} {wanted:?}");
            }
        }
    }

    #[test]
    fn without_the_machine_control_is_switched_at_rotary_zero_only() {
        let setup =
            rs274::Setup { tools: [(1, rs274::Tool::with_length(80.0, 10.0))].into(), ..rs274::Setup::default() };
        let run = |text: &str| rs274::interpret(text, std::path::Path::new("tip.ngc"), &setup);
        assert!(run("G43.4 H1\nG1 X1 A30 F100\nG0 A0\nG49\nM2").is_ok());
        let error = run("G0 A30\nG43.4 H1\nM2").unwrap_err().to_string();
        assert!(error.contains("tip.ngc:2:1") && error.contains("[program.tool_centre_point]"), "{error}");
        let error = run("G68.2 J30\nG53.1\nM2").unwrap_err().to_string();
        assert!(error.contains("tip.ngc:2:1") && error.contains("[program.tool_centre_point]"), "{error}");
    }

    #[test]
    fn a_machine_without_y_is_refused() {
        let machine = Machine::new(vec![link("z", None, [0.0; 3], slide(Axis::Z, Vector::z()))]).unwrap();
        let control =
            TipControl { tool_link: Some(0), gauge: Point::origin(), direction: -Vector::z_axis(), work_link: None };
        assert_eq!(control.axes(&machine, &Position::default(), 10.0), Err(TipError::Singular));
        // A direction has a meaning all the same, unless two axes go the same way.
        let lean = Unit::new_normalize(Vector::new(1.0, 2.0, 3.0));
        assert!((control.world_direction(&machine, &lean).unwrap().into_inner() - lean.into_inner()).norm() < 1e-12);
        let mut links = machine.links().to_vec();
        links.push(link("x", None, [0.0; 3], slide(Axis::X, Vector::x())));
        links.push(link("y", Some("x"), [0.0; 3], slide(Axis::Y, Vector::x())));
        let control = TipControl { work_link: Some(2), ..control };
        assert_eq!(control.world_direction(&Machine::new(links.clone()).unwrap(), &lean), Err(TipError::Singular));
        // Nor do axes follow the tip where two go nearly the same way.
        links[2] = link("y", Some("x"), [0.0; 3], slide(Axis::Y, Vector::new(1.0, 1e-5, 0.0)));
        let machine = Machine::new(links).unwrap();
        assert_eq!(control.axes(&machine, &Position::default(), 10.0), Err(TipError::Singular));
    }

    #[test]
    fn an_axis_of_a_table_that_is_not_named_is_idle() {
        let zero = Position::default();
        for (machine, control) in [table_table(), head_table(), head_head()] {
            assert_eq!(control.idle_axis(&machine, &zero), None);
        }
        let (machine, control) = head_table();
        let control = TipControl { work_link: None, ..control };
        assert_eq!(control.idle_axis(&machine, &zero), Some(Axis::X));
        assert_eq!(control.directions(&machine, &zero)[0], Vector::zeros());
        // An axis that the machine lacks is not.
        let links: Vec<_> = machine.links().iter().filter(|link| !["x", "c"].contains(&&*link.name)).cloned().collect();
        let lathe = Machine::new(links).unwrap();
        let control = TipControl { tool_link: Some(2), ..control };
        assert_eq!(control.idle_axis(&lathe, &zero), None);
        assert_eq!(control.directions(&lathe, &zero)[0], Vector::x());
    }

    #[test]
    fn a_linear_letter_that_turns_is_refused_between_tool_and_workpiece_alone() {
        // The head-table machine with its head tilted by `letter`, and a door that turns beside it.
        let tilted = |letter: Axis, work: Option<usize>| {
            let (machine, control) = head_table();
            let mut links = machine.links().to_vec();
            links[4].joint = Some(turn(letter, Vector::y(), [0.0, 0.0, 30.0]));
            links.push(link("door", Some("z"), [0.0; 3], turn(Axis::V, Vector::x(), [0.0; 3])));
            TipControl { work_link: work, ..control }.check(&Machine::new(links).unwrap())
        };
        assert_eq!(tilted(Axis::B, Some(1)), Ok(()));
        let refused = TurningLetter { axis: 'U', link: "b".to_owned() };
        assert_eq!(tilted(Axis::U, Some(1)), Err(refused.clone()));
        assert_eq!(tilted(Axis::U, None), Err(refused));
        // On the tilted link itself, tool and workpiece turn together.
        assert_eq!(tilted(Axis::U, Some(4)), Ok(()));
    }

    #[test]
    fn a_tip_that_misses_its_place_is_an_error() {
        // X turns a table: from where its three unit moves take the tip, the linear equations say where it is not.
        let machine = Machine::new(vec![
            link("x", None, [0.0; 3], turn(Axis::X, Vector::z(), [200.0, 0.0, 0.0])),
            link("y", None, [0.0; 3], slide(Axis::Y, Vector::new(0.6, 0.8, 0.0))),
            link("z", Some("y"), [0.0; 3], slide(Axis::Z, Vector::z())),
        ])
        .unwrap();
        let control =
            TipControl { tool_link: Some(2), gauge: Point::origin(), direction: -Vector::z_axis(), work_link: Some(0) };
        let mut programmed = Position::default();
        (programmed[Axis::X], programmed[Axis::Y]) = (30.0, 5.0);
        assert!(matches!(control.axes(&machine, &programmed, 10.0), Err(TipError::Missed { .. })));
    }
}
