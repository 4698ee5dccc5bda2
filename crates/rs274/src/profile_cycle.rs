//! LinuxCNC's turning cycles: roughing along Z (G71) and along X (G72) down to the profile in a subroutine, and finishing (G70).
//!
//! Meaning as LinuxCNC documents it ("G70 Lathe finishing cycle", "G71 G72 Lathe roughing cycles"). Where the documents leave it open, as its
//! stand-alone interpreter does it: cuts begin on the straight way from the start to the profile; they retreat by R along both axes, by no
//! more than half their length; in pockets G71 and G72 keep to the depths of the cuts before, G71.2 and G72.2 count from the pocket's rim.

use super::block::Keyword;
use super::canonical::{MoveKind, Plane};
use super::error::{Cause, Fault};
use super::feed::Travel;
use super::interpret::Interpreter;
use super::lathe::{MAX_PASSES, X, Z};
use super::modal::{Code, FeedMode, Group, Values};
use super::offset_curve::{Curve, Point, minus, norm};
use super::offsets::Values9;
use super::oword::{FlowTable, Lines};
use super::profile::{Blend, Element, Step, beside, finish, path_of, rough};
use std::ops::Range;

/// Most elements of a profile.
const MAX_ELEMENTS: usize = 10_000;

/// Whether a code is one of these cycles.
pub(super) const fn is_profile_cycle(code: i32) -> bool {
    matches!(code, 700 | 710..=712 | 720..=722)
}

/// A cycle's frame: it travels towards smaller u, and the material lies towards larger v.
#[derive(Clone, Copy, Debug)]
struct Frame {
    /// Indices of the axes of u and v.
    axes: [usize; 2],
    signs: [f64; 2],
}

impl Frame {
    fn point(&self, place: &Values9) -> Point {
        [0, 1].map(|i| self.signs[i] * place[self.axes[i]])
    }

    fn place(&self, point: Point, other_axes: &Values9) -> Values9 {
        let mut place = *other_axes;
        for i in [0, 1] {
            place[self.axes[i]] = self.signs[i] * point[i];
        }
        place
    }

    /// 1 where a turn from Z to X is one from u to v, else -1.
    fn sense(&self) -> f64 {
        let swapped = if self.axes == [Z, X] { 1.0 } else { -1.0 };
        swapped * self.signs[0] * self.signs[1]
    }

    /// An element from the place before, in the frame.
    fn curve(&self, from: &Values9, element: &Element) -> Curve {
        let (from, to) = (self.point(from), self.point(&element.to));
        let way = minus(to, from);
        match element.circle {
            None => Curve::Line { from, to, direction: way.map(|x| x / norm(way)) },
            Some(circle) => {
                let mut centre = [0.0; 9];
                (centre[Z], centre[X]) = (circle.centre[0], circle.centre[1]);
                Curve::Arc { centre: self.point(&centre), from, to, sweep: circle.sweep * self.sense() }
            }
        }
    }
}

impl Interpreter<'_> {
    /// A block of one of the cycles.
    pub(super) fn profile_cycle(
        &mut self,
        lines: &Lines,
        table: &FlowTable,
        values: &Values,
        code: &Code,
    ) -> Result<(), Fault> {
        self.refuse_profile_cycle(values, code)?;
        let label = values.take_whole('q', 0..=i32::MAX, "Q", "a subroutine's number")?;
        let label = label.ok_or_else(|| code.fault(Cause::Missing("Q, the subroutine with the profile,")))?;
        let body = table.body(&label.to_string()).ok_or_else(|| values.fault('q', Cause::UnknownSubroutine))?;
        let mut start = self.position;
        let aimed = self.target(values);
        (start[X], start[Z]) = (aimed[X], aimed[Z]);
        self.rapid_to(start)?;
        let elements = self.read_profile(lines, table, body)?;
        let at_code = |why| code.fault(Cause::NotAllowed(why));
        let (Some(first), Some(last)) = (elements.first(), elements.last()) else {
            return Err(at_code("a profile that moves nothing"));
        };
        let axes = if matches!(code.number, 720..=722) { [X, Z] } else { [Z, X] };
        let falls = |axis: usize| last.to[axis] < first.to[axis];
        let signs =
            [if falls(axes[0]) { 1.0 } else { -1.0 }, if last.to[axes[1]] > first.to[axes[1]] { 1.0 } else { -1.0 }];
        let frame = Frame { axes, signs };
        let ways = elements.windows(2).map(|pair| (frame.curve(&pair[0].to, &pair[1]), pair[1].blend));
        let path = path_of(ways).map_err(at_code)?;
        // From behind the profile's begin the tool first goes above it.
        let mut begin = frame.point(&start);
        if begin[0] < path[0].from()[0] {
            begin[0] = path[0].from()[0];
            self.rapid_to(frame.place(begin, &start))?;
        }
        let length = |letter: char, default: f64| self.take_length(values, letter).unwrap_or(default);
        let distance = length('d', 0.0);
        let steps = if code.number == 700 {
            let end = length('e', 0.0);
            let passes = values
                .take_whole('p', 1..=MAX_PASSES as i32, "P", "the number of passes, from 1 to 10000")?
                .unwrap_or(1);
            let mut steps = Vec::new();
            for pass in (0..passes).rev() {
                let part = f64::from(pass) / f64::from(passes);
                let path = beside(&path, end + part * (distance - end)).map_err(at_code)?;
                steps.extend(finish(begin, &path));
            }
            steps
        } else {
            let unit = self.modes.unit_mm();
            let (increment, retreat) = (length('i', unit), length('r', 0.5 * unit));
            if increment <= 0.0 || retreat < 0.0 || distance < 0.0 {
                return Err(code.fault(Cause::Range("I", "above 0, and D and R at least 0")));
            }
            let path = beside(&path, distance).map_err(at_code)?;
            let kind = code.number % 10;
            rough(begin, &path, increment, retreat, kind != 2, kind != 1).map_err(|cause| code.fault(cause))?
        };
        self.take_steps(&steps, &frame, values)
    }

    fn refuse_profile_cycle(&self, values: &Values, code: &Code) -> Result<(), Fault> {
        if let Some(letter) = "yabcuvw@^".chars().find(|&letter| values.has(letter)) {
            return Err(values.fault(letter, Cause::UnusedWord));
        }
        let why = if self.modes.plane != Plane::Zx || self.offsets.similar(Plane::Zx).is_none() {
            "G70 to G72 outside the ZX plane (G18)"
        } else if self.compensation.on().is_some() {
            "G70 to G72 while cutter compensation is on"
        } else if self.modes.feed_mode == FeedMode::InverseTime {
            "G70 to G72 in G93"
        } else {
            return Ok(());
        };
        Err(code.fault(Cause::NotAllowed(why)))
    }

    /// The profile's elements; the first one only says where it begins. The mode of motion is afterwards that of the last.
    fn read_profile(&mut self, lines: &Lines, table: &FlowTable, body: Range<usize>) -> Result<Vec<Element>, Fault> {
        let (position, at) = (self.position, self.at);
        let mut motion = 10;
        let mut elements = Vec::new();
        let mut next = body.start;
        while body.contains(&next) {
            self.at = next;
            self.steps += 1;
            if self.steps > self.setup.limits.blocks {
                let cause = Cause::Limit { limit: self.setup.limits.blocks, what: "blocks executed" };
                return Err(Fault::new(1, "", cause));
            }
            let block = lines[next].as_ref().map_err(Clone::clone)?;
            if block.reads_parameters {
                self.refresh_parameters();
            }
            if let Some(flow) = &block.flow {
                if matches!(flow.keyword, Keyword::Call | Keyword::Return | Keyword::Sub | Keyword::Label) {
                    let cause = Cause::NotAllowed("another subroutine inside a profile");
                    return Err(Fault::new(flow.column, flow.text.clone(), cause));
                }
                next = self.obey_flow(table, lines, flow, next)?;
                continue;
            }
            next += 1;
            let values = Values::of(block, &self.parameters, self.setup, self.modes.inches)?;
            self.assign(block)?;
            if let Some(code) = values.code(Group::Motion) {
                if !matches!(code.number, 0 | 10 | 20 | 30) {
                    return Err(code.fault(Cause::NotAllowed("another motion than G0 to G3 inside a profile")));
                }
                motion = code.number;
            }
            if values.has_axis() || (motion >= 20 && (values.has('i') || values.has('k'))) {
                if elements.len() >= MAX_ELEMENTS {
                    let cause = Cause::Limit { limit: MAX_ELEMENTS, what: "elements of one profile" };
                    return Err(values.motion_fault(cause));
                }
                elements.push(self.profile_element(&values, motion)?);
            }
        }
        (self.position, self.at) = (position, at);
        self.modes.motion = Some(motion);
        Ok(elements)
    }

    /// One motion of a profile: A and C are the fillet and the chamfer at its end, U and W steps along X and Z.
    fn profile_element(&mut self, values: &Values, motion: i32) -> Result<Element, Fault> {
        if let Some(letter) = "ybv@^".chars().find(|&letter| values.has(letter)) {
            return Err(values.fault(letter, Cause::UnusedWord));
        }
        let blend = match (self.take_length(values, 'a'), self.take_length(values, 'c')) {
            (None, None) => None,
            (Some(radius), None) if radius > 0.0 => Some(Blend::Fillet(radius)),
            (None, Some(length)) if length > 0.0 => Some(Blend::Chamfer(length)),
            _ => {
                return Err(values.motion_fault(Cause::Range("A or C, a fillet or a chamfer,", "above 0, one of them")));
            }
        };
        let from = self.position;
        let aimed = self.target(values);
        let mut to = from;
        (to[X], to[Z]) = (aimed[X], aimed[Z]);
        for (letter, axis) in [('u', X), ('w', Z)] {
            let Some(step) = self.take_length(values, letter) else { continue };
            if self.modes.incremental {
                return Err(values.fault(letter, Cause::NotAllowed("U and W of a profile in G91")));
            }
            to[axis] += if axis == X && self.modes.diameter { step / 2.0 } else { step };
        }
        let similar = self.offsets.similar(Plane::Zx);
        let circle =
            if motion < 20 { None } else { Some(self.circle(values, &from, &to, motion == 20, 1, similar)?) };
        self.position = to;
        Ok(Element { to, circle, blend })
    }

    fn take_steps(&mut self, steps: &[Step], frame: &Frame, values: &Values) -> Result<(), Fault> {
        for step in steps {
            match *step {
                Step::Rapid(to) => self.rapid_to(frame.place(to, &self.position))?,
                Step::Feed(to) => self.feed_to(frame.place(to, &self.position), values)?,
                Step::Along(Curve::Line { to, .. }) => self.feed_to(frame.place(to, &self.position), values)?,
                Step::Along(Curve::Arc { centre, from, to, sweep }) => {
                    let target = frame.place(to, &self.position);
                    let length = norm(minus(from, centre)) * sweep.abs();
                    let feed = self.feed_for(Travel::Along(length), &target, values)?;
                    let centre = frame.place(centre, &[0.0; 9]);
                    self.position = target;
                    let kind = MoveKind::Arc {
                        plane: Plane::Zx,
                        centre: [centre[Z], centre[X]],
                        sweep: sweep * frame.sense(),
                    };
                    self.emit(kind, feed)?;
                }
            }
        }
        Ok(())
    }
}
