//! Writes a tool path as a program for a machine, under tool-centre-point control (G43.4), with the positions of the two rotary axes that
//! give the tool its direction.

use super::path::{Corner, Stop};
use crate::geometry::{Isometry, Vector};
use crate::machine::Machine;
use crate::machine::tip::TipControl;
use nalgebra::Unit;
use rs274::{Axis, Position, Setup};
use std::fmt::{Display, Write};
use thiserror::Error;

/// The machine and the job that a program is written for.
#[derive(Clone, Debug)]
pub struct Writer<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// The links that carry tool and workpiece.
    pub tip: &'a TipControl,
    /// Work offsets, tool lengths, and the machine's initial position. The program uses G54.
    pub setup: &'a Setup,
    /// Number of the tool.
    pub tool: u32,
    /// Pose of the surface's frame in the frame of the link that carries the workpiece.
    pub work_from_surface: Isometry,
    /// The cutter's corner.
    pub corner: Corner,
    /// Feed rate of the tip, mm/min.
    pub feed_mm_min: f64,
    /// Distance from the surface, along the tool, at which the approach begins and the retract ends, mm.
    pub retract_mm: f64,
    /// First line of the program, without parentheses.
    pub title: &'a str,
}

/// Why a program cannot be written.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum WriteError {
    /// The path has no positions.
    #[error("the path has no contact points")]
    Empty,
    /// The tool is not in the table.
    #[error("tool {0} is not in the tool table")]
    NoTool(u32),
    /// G54 rotates the axes, which this writer does not support.
    #[error("G54 is rotated; a path is written for work offsets that are not")]
    Rotated,
    /// The machine cannot reach a position as required.
    #[error("contact point {at}: {cause}")]
    Unreachable {
        /// Number of the position, from 1.
        at: usize,
        /// Why.
        cause: String,
    },
}

/// A program, and the line on which each position is reached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The program.
    pub text: String,
    /// The line of each position, from 1.
    pub lines: Vec<u32>,
}

impl Writer<'_> {
    /// Writes the program: an approach along the tool, straight moves of the tip from position to position, and a retract along the tool.
    ///
    /// # Errors
    /// [`WriteError`] with the first position that the machine cannot reach.
    pub fn write(&self, stops: &[Stop]) -> Result<Written, WriteError> {
        let length = self.setup.tools.get(&self.tool).ok_or(WriteError::NoTool(self.tool))?.offset[Axis::Z];
        if self.setup.work_offsets[0].rotation != 0.0 {
            return Err(WriteError::Rotated);
        }
        let mut previous = self.setup.start;
        let mut programmed = Vec::with_capacity(stops.len());
        for (stop, at) in stops.iter().zip(1..) {
            let position = self.programmed(stop, 0.0, &previous, length, at)?;
            programmed.push(position);
            previous = position;
        }
        let ([first, .., last] | [first @ last]) = stops else { return Err(WriteError::Empty) };
        let way_in = self.programmed(first, self.retract_mm, &programmed[0], length, 1)?;
        let way_out = self.programmed(last, self.retract_mm, &previous, length, stops.len())?;
        let highest = programmed.iter().chain([&way_in, &way_out]).map(|p| p[Axis::Z]).fold(f64::MIN, f64::max);
        let safe = highest + self.retract_mm;
        let words = |axes: &[Axis], position: &Position| self.words(axes, position);
        let linear = [Axis::X, Axis::Y, Axis::Z];
        let rotary: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| axis.is_rotary() && self.drives(*axis)).collect();
        let mut at_zero = way_out;
        rotary.iter().for_each(|&axis| at_zero[axis] = self.setup.work_offsets[0].origin[axis]);
        let with_height = |position: &Position| {
            let mut above = *position;
            above[Axis::Z] = safe;
            above
        };
        let mut lines = vec![
            format!("({})", self.title),
            "(Tool-centre-point control: X Y Z are the place of the tool's tip on the workpiece.)".to_owned(),
            "G21 G17 G90 G94 G54".to_owned(),
            format!("T{} M6", self.tool),
            "S12000 M3".to_owned(),
            format!("G43.4 H{}", self.tool),
            format!("G0{}", words(&[Axis::Z], &with_height(&way_in))),
            format!("G0{}{}", words(&[Axis::X, Axis::Y], &way_in), words(&rotary, &way_in)),
            format!("G0{}", words(&linear, &way_in)),
        ];
        let head = lines.len() as u32;
        for (position, index) in programmed.iter().zip(0..) {
            let (code, feed) =
                if index == 0 { ("G1", format!(" F{}", number(self.feed_mm_min))) } else { ("", String::new()) };
            let text = format!("{code}{}{}{feed}", words(&linear, position), words(&rotary, position));
            lines.push(text.trim_start().to_owned());
        }
        lines.extend([
            format!("G0{}", words(&linear, &way_out)),
            format!("G0{}", words(&[Axis::Z], &with_height(&way_out))),
            format!("G0{}", words(&rotary, &at_zero)),
            "G49".to_owned(),
            "M5".to_owned(),
            "M2".to_owned(),
        ]);
        let lines_of_stops = (head + 1..).take(stops.len()).collect();
        Ok(Written { text: lines.join("\n") + "\n", lines: lines_of_stops })
    }

    /// The programmed position of a stop, with the tool lifted by `lifted_mm` along its axis, in machine coordinates.
    fn programmed(
        &self,
        stop: &Stop,
        lifted_mm: f64,
        previous: &Position,
        length: f64,
        at: usize,
    ) -> Result<Position, WriteError> {
        let pose = self.work_from_surface * stop.contact.surface_from_tool(self.corner, stop.sunk_mm);
        let upwards: Vector = pose.rotation * Vector::z();
        let tip = nalgebra::Point3::from(pose.translation.vector) + upwards * lifted_mm;
        // From the frame of the workpiece's link to the one that is the world's at zero.
        let at_zero = self.machine.forward(&Position::default()).world_from(self.tip.work_link).rotation;
        let solutions = self.tip.orient(self.machine, &Unit::new_normalize(at_zero * upwards), previous);
        let fault = |cause: &dyn Display| WriteError::Unreachable { at, cause: cause.to_string() };
        let oriented = solutions.map_err(|cause| fault(&cause))?.chosen.position;
        let programmed = self.tip.programmed(self.machine, &oriented, &tip, length).map_err(|cause| fault(&cause))?;
        let axes = self.tip.axes(self.machine, &programmed, length).map_err(|cause| fault(&cause))?;
        self.machine.check_limits(&axes).map_err(|cause| fault(&cause))?;
        Ok(programmed)
    }

    fn drives(&self, axis: Axis) -> bool {
        self.machine.joints_of(axis).next().is_some()
    }

    /// The words of some axes in G54, each preceded by a space.
    fn words(&self, axes: &[Axis], position: &Position) -> String {
        let origin = &self.setup.work_offsets[0].origin;
        axes.iter().fold(String::new(), |mut text, &axis| {
            let value = position[axis] - origin[axis];
            let value = if axis.is_rotary() { value.to_degrees() } else { value };
            let _ = write!(text, " {}{}", axis.letter(), number(value));
            text
        })
    }
}

/// A number with at most four decimals and no trailing zeros: a tenth of a micrometre, or an angle that moves a point at one metre by less
/// than two micrometres.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::super::path::{Flaw, PathPlan, Pattern, stops};
    use super::super::profile::{P2, Profile};
    use super::*;
    use crate::geometry::shapes::Freeform;
    use crate::geometry::{Isometry, Point};
    use crate::machine::joint::{Joint, Limits};
    use crate::machine::tree::Link;
    use crate::scene::Scene;
    use rs274::{Sampling, Tool, interpret};
    use std::path::Path;

    fn hollow() -> Freeform {
        Freeform {
            size_mm: [60.0, 45.0],
            heights_mm: vec![
                vec![30.0, 29.0, 31.0, 30.0],
                vec![29.0, 22.0, 21.0, 29.0],
                vec![28.0, 23.0, 24.0, 30.0],
                vec![30.0; 4],
            ],
        }
    }

    /// A fork head (B carries A) over a fixed table.
    fn fork() -> (Machine, TipControl, Setup) {
        let link = |name: &str, parent: Option<&str>, z: f64, joint| Link {
            name: name.into(),
            parent: parent.map(Into::into),
            parent_from_link: Isometry::translation(0.0, 0.0, z),
            joint: Some(joint),
        };
        let slide = |axis, direction| Joint::prismatic(axis, direction, Limits::NONE).unwrap();
        let turn =
            |axis, direction| Joint::rotary(axis, direction, Point::origin(), Limits { min: -1.0, max: 1.0 }).unwrap();
        let machine = Machine::new(vec![
            link("x", None, 0.0, slide(Axis::X, Vector::x())),
            link("y", Some("x"), 0.0, slide(Axis::Y, Vector::y())),
            link("z", Some("y"), 300.0, slide(Axis::Z, Vector::z())),
            link("a", Some("z"), 0.0, turn(Axis::A, Vector::x())),
            link("b", Some("a"), 0.0, turn(Axis::B, Vector::y())),
        ])
        .unwrap();
        let gauge = Point::new(0.0, 0.0, -120.0);
        let tip = TipControl { tool_link: Some(4), gauge, direction: -Vector::z_axis(), work_link: None };
        let mut setup = Setup::default();
        setup.tools.insert(3, Tool::with_length(85.0, 10.0));
        setup.work_offsets[0].origin[Axis::X] = 7.0;
        setup.work_offsets[0].origin[Axis::Z] = -4.0;
        (machine, tip, setup)
    }

    /// The trunnion of the shipped scene, whose table tilts and turns.
    fn trunnion() -> (Machine, TipControl, Setup) {
        let scene = Scene::find("trunnion-impeller").unwrap();
        let run = scene.program.unwrap();
        let mut setup = run.setup;
        setup.tools.insert(3, Tool::with_length(90.0, 10.0));
        (scene.machine, run.tip.unwrap(), setup)
    }

    /// Checks the program by interpreting it and moving the machine: the cutter reaches each contact point, tangential and at the planned
    /// depth.
    #[test]
    fn programs_read_back_to_their_contact_points() {
        for (machine, tip, setup) in [fork(), trunnion()] {
            for (radius_mm, corner_mm, pattern) in [(5.0, 5.0, Pattern::ZigZag), (5.0, 2.0, Pattern::Spiral)] {
                let plan = PathPlan { pattern, rows: 4, step_mm: 2.0, margin: 0.1, lead: 0.2, tilt: 0.15 };
                let flaws = [(0.3, Flaw::Gouge { depth_mm: 0.05 }), (0.6, Flaw::Lean { angle: 0.3 })];
                let planned = stops(&plan.contacts(&hollow()).unwrap(), &flaws);
                let work_from_surface = Isometry::translation(3.0, -2.0, 40.0);
                let writer = Writer {
                    machine: &machine,
                    tip: &tip,
                    setup: &setup,
                    tool: 3,
                    work_from_surface,
                    corner: Corner { radius_mm, corner_mm },
                    feed_mm_min: 1500.0,
                    retract_mm: 5.0,
                    title: "Test",
                };
                let written = writer.write(&planned).unwrap();
                let program = interpret(&written.text, Path::new("path.ngc"), &setup).unwrap();
                let sampling = Sampling { step_mm: 1e6, step_deg: 1e6, chord_mm: 1e6 };
                let samples = rs274::sample(&program, &setup.start, &sampling, &rs274::RapidPath::Straight).unwrap();
                let profile = Profile::bull_nose(radius_mm, corner_mm, 60.0).unwrap();
                for (stop, line) in planned.iter().zip(&written.lines) {
                    let sample = samples.iter().find(|sample| sample.line == *line).unwrap();
                    let length = program.moves[sample.move_index].tip_mm.unwrap();
                    let axes = tip.axes(&machine, &sample.position, length).unwrap();
                    // The tool's frame in the surface's, by the machine's own kinematics.
                    let poses = machine.forward(&axes);
                    let tip_in_link = tip.gauge + tip.direction.into_inner() * length;
                    let link_from_tool =
                        Isometry::from_parts(tip_in_link.coords.into(), nalgebra::UnitQuaternion::identity());
                    let work_from_tool =
                        poses.world_from(tip.work_link).inverse() * poses.world_from(tip.tool_link) * link_from_tool;
                    let tool_from_surface = work_from_tool.inverse() * work_from_surface;
                    let q = tool_from_surface * stop.contact.point;
                    let depth = -profile.signed_distance_mm(&P2::new(q.x.hypot(q.y), q.z));
                    assert!((depth - stop.sunk_mm).abs() < 3e-4, "line {line}: {depth} deep, not {}", stop.sunk_mm);
                    let axis = tool_from_surface.inverse() * Vector::z();
                    assert!(axis.angle(&stop.contact.axis) < 1e-5);
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_written_is_said() {
        let (machine, tip, setup) = fork();
        let writer = Writer {
            machine: &machine,
            tip: &tip,
            setup: &setup,
            tool: 3,
            work_from_surface: Isometry::identity(),
            corner: Corner { radius_mm: 5.0, corner_mm: 5.0 },
            feed_mm_min: 1000.0,
            retract_mm: 5.0,
            title: "Test",
        };
        assert_eq!(writer.write(&[]), Err(WriteError::Empty));
        let contacts = |lead| {
            let plan = PathPlan { pattern: Pattern::ZigZag, rows: 2, step_mm: 9.0, margin: 0.1, lead, tilt: 0.0 };
            stops(&plan.contacts(&hollow()).unwrap(), &[])
        };
        let message = |result: Result<Written, WriteError>| result.unwrap_err().to_string();
        // A and B go to one radian, 57 degrees.
        let found = message(writer.write(&contacts(1.3)));
        assert!(found.starts_with("contact point 1: both ways to tilt the tool leave the limits"), "{found}");
        let other = Writer { tool: 8, ..writer.clone() };
        assert_eq!(message(other.write(&contacts(0.1))), "tool 8 is not in the tool table");
        assert_eq!((number(-0.000_04), number(1.25), number(-3.0)), ("0".into(), "1.25".into(), "-3".into()));
    }
}
