//! Haas's G12 and G13: circular pockets, clockwise and counter-clockwise (mill operator's manual, "G12 Circular Pocket Milling CW / G13 Circular Pocket
//! Milling CCW").
//!
//! The tool stands at the centre, or goes there by X and Y of the block. It feeds to Z, goes round circles of the radii I, I + Q, I + 2 Q and so on up to K
//! (with I alone, round that one), and comes back to the centre. L repeats that; in G91 each time by Z deeper. The radii are the pocket's: the tool's centre
//! stays inside by the radius of the offset D, or of the last D before, without G41 or G42; D0 leaves it on the circle.
//!
//! The manual gives the ways from the centre to the first circle, from circle to circle, and back in a figure alone. They are straight feeds along X
//! here. Where the circles alone clear the pocket, that makes no difference: every such way is inside the circles.

use super::arc::Circle;
use super::canonical::{Axis, Plane};
use super::dialect::own;
use super::error::{Cause, Fault};
use super::interpret::Interpreter;
use super::modal::{Group, Values};
use super::offsets::Values9;
use std::f64::consts::TAU;

/// Radii that differ by less, mm, are one.
const ROUNDING_MM: f64 = 1e-6;

/// Most repeats of one pocket, and most circles at one depth.
const MAX_CIRCLES: i32 = 10_000;

/// Note on a pocket that the circles alone do not clear.
const WAYS_BETWEEN: &str = "G12 or G13: the ways from the centre to the first circle, from circle to circle, and back are straight here, along X; how the control goes is not known, and matters where the circles leave material or a boss between them";

/// Radii of the pocket, mm of the program.
#[derive(Clone, Copy, Debug)]
struct Radii {
    first: f64,
    last: f64,
    step: f64,
}

impl Radii {
    /// All circles from the first to the last, less `inside`.
    fn circles(self, inside: f64) -> impl Iterator<Item = f64> {
        let Self { first, last, step } = self;
        let count = if step > 0.0 { ((last - first - ROUNDING_MM) / step).ceil().max(0.0) as i32 } else { 0 };
        (0..=count).map(move |circle| (first + f64::from(circle) * step).min(last) - inside)
    }

    /// Whether circles of a tool of this radius leave something between them, or about the centre.
    fn leave_something(self, inside: f64, tool: f64) -> bool {
        self.first - inside > tool + ROUNDING_MM || self.step > 2.0 * tool + ROUNDING_MM
    }
}

impl Interpreter<'_> {
    /// A block of G12 or G13.
    pub(super) fn circular_pocket(&mut self, values: &Values, code: i32) -> Result<(), Fault> {
        let fault = |cause| values.fault_at(Group::NonModal, cause);
        self.refuse_other_plane(values)?;
        if self.transforms.is_uneven() {
            return Err(fault(Cause::NotAllowed("a circle in a plane of axes that are scaled differently")));
        }
        let radii = self.read_radii(values)?;
        let (diameter, _) = self.compensated_tool(values, code)?;
        // Lengths of the program grow by this.
        let scale = self.offsets.similar(Plane::Xy).map_or(1.0, |similar| similar.scale);
        let inside = diameter / 2.0 / scale;
        if radii.first - inside <= ROUNDING_MM {
            return Err(values.fault('i', Cause::Range("I", "above the radius of the tool offset D")));
        }
        let in_spindle = self.tools.get(&self.tool).map_or(0.0, |tool| tool.diameter_mm);
        let cutter = if diameter > 0.0 { inside } else { in_spindle / 2.0 / scale };
        if radii.leave_something(inside, cutter) {
            self.note_unknown(WAYS_BETWEEN.to_owned());
        }
        let repeats = values.take_whole('l', 1..=MAX_CIRCLES, "L", "a whole number from 1 to 10000")?.unwrap_or(1);
        self.go_to_centre(values)?;
        let depth = self.take_depth(values)?;
        for _ in 0..repeats {
            let mut centre = self.offsets.to_program(&self.position);
            let z = centre[Axis::Z as usize];
            centre[Axis::Z as usize] = depth.map_or(z, |(value, is_step)| if is_step { z + value } else { value });
            self.feed_to_program(&centre, values)?;
            for radius in radii.circles(inside) {
                let mut start = centre;
                start[Axis::X as usize] += radius;
                self.feed_to_program(&start, values)?;
                self.full_circle(&centre, code == own::POCKET_CLOCKWISE, values)?;
            }
            self.feed_to_program(&centre, values)?;
        }
        Ok(())
    }

    /// Z, and whether it is a step.
    fn take_depth(&mut self, values: &Values) -> Result<Option<(f64, bool)>, Fault> {
        let depth = self.take_axis_or_step(values, Axis::Z);
        let Some((_, is_step)) = depth else { return Ok(None) };
        if is_step && self.offset_change[Axis::Z as usize] != 0.0 {
            return Err(values.fault('z', Cause::NotAllowed("a step of Z right behind another tool offset")));
        }
        if !is_step {
            self.note_unset_origin();
        }
        self.offset_change[Axis::Z as usize] = 0.0;
        Ok(depth)
    }

    /// I, and K and Q beside it.
    fn read_radii(&self, values: &Values) -> Result<Radii, Fault> {
        let missing = |what| values.fault_at(Group::NonModal, Cause::Missing(what));
        let [first, last, step] = ['i', 'k', 'q'].map(|letter| self.take_length(values, letter));
        let first = first.ok_or_else(|| missing("I, the radius of the first circle,"))?;
        let Some(last) = last else {
            return match step {
                Some(_) => Err(missing("K, the radius of the last circle, beside Q")),
                None => Ok(Radii { first, last: first, step: 0.0 }),
            };
        };
        let step = step.ok_or_else(|| missing("Q, from circle to circle, beside K"))?;
        if last <= first {
            return Err(values.fault('k', Cause::Range("K", "above I")));
        }
        if step <= 0.0 || (last - first) / step > f64::from(MAX_CIRCLES) {
            return Err(values.fault('q', Cause::Range("Q", "above 0, and at least a ten-thousandth of K - I")));
        }
        Ok(Radii { first, last, step })
    }

    /// A straight feed to a place of the program, unless the tool is there.
    fn feed_to_program(&mut self, program: &Values9, values: &Values) -> Result<(), Fault> {
        let target = self.offsets.to_machine(program);
        if target.iter().zip(self.position).all(|(to, from)| (to - from).abs() <= ROUNDING_MM) {
            return Ok(());
        }
        self.feed_to(target, values)
    }

    /// Once round a place of the program, from where the tool is.
    fn full_circle(&mut self, centre: &Values9, clockwise: bool, values: &Values) -> Result<(), Fault> {
        let turn = |clockwise: bool| if clockwise { -TAU } else { TAU };
        let target = self.position;
        match self.offsets.similar(Plane::Xy) {
            Some(similar) => {
                let [x, y, ..] = self.offsets.to_machine(centre);
                let circle = Circle { centre: [x, y], sweep: turn(clockwise != similar.mirrors) };
                let feed = self.arc_feed(&circle, &target, values)?;
                self.round_to(target, &circle, feed, values)
            }
            None => self.bend_to(&target, &Circle { centre: [centre[0], centre[1]], sweep: turn(clockwise) }, values),
        }
    }
}
