//! What rs274 prints, as calls in axis positions. It prints lengths with four decimals in the program's unit, and offsets,
//! feed rates and the spindle's state apart from the moves they belong to.

use super::{Call, INCH_MM, Kind, NO_TRAVEL, PROBE_STOPS_SHORT_MM};
use rs274::{Axis, Plane};

/// Half of the last printed decimal, and how many printed numbers at most add up to a coordinate: itself, G5x, G92, tool.
const PRINTED_HALF: f64 = 0.5e-4;
const SUMMANDS: f64 = 4.0;

/// The state that rs274 prints apart from its calls.
#[derive(Default)]
pub struct Printed {
    unit_mm: f64,
    origin: [f64; 9],
    shift: [f64; 9],
    tool: [f64; 9],
    rotation_deg: f64,
    plane: Plane,
    /// Where the last call ended, in printed coordinates.
    last: [f64; 9],
    /// As printed, per minute or per revolution.
    feed: f64,
    per_revolution: bool,
    /// Travel per revolution while a thread is cut.
    pitch: Option<f64>,
    /// 1 for clockwise, -1, or 0.
    turns: f64,
    speed: f64,
    surface_speed: bool,
}

impl Printed {
    /// All calls of an output.
    pub fn calls(mut self, text: &str) -> Result<Vec<Call>, String> {
        self.unit_mm = 1.0;
        let mut calls = Vec::new();
        for line in text.lines() {
            let Some((number, name, arguments)) = parse(line) else { continue };
            let values: Vec<f64> = arguments
                .split([',', ' '])
                .filter(|word| !word.is_empty())
                .filter_map(|word| word.parse().ok())
                .collect();
            let first = values.first().copied().unwrap_or_default();
            match name {
                "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED" | "STRAIGHT_PROBE" | "RIGID_TAP" => {
                    self.straight(&mut calls, name, number, &values);
                }
                "ARC_FEED" => calls.push(self.arc(number, &values)?),
                "NURBS_FEED" => calls.push(self.call(Kind::Spline, number, None)),
                "DWELL" => calls.push(self.call(Kind::Dwell(first), number, None)),
                "CHANGE_TOOL" => calls.push(self.call(Kind::ToolChange(first), number, None)),
                _ => self.note(name, arguments, &values),
            }
        }
        Ok(calls)
    }

    /// A call that moves nothing.
    fn note(&mut self, name: &str, arguments: &str, values: &[f64]) {
        let first = values.first().copied().unwrap_or_default();
        let second = values.get(1).copied().unwrap_or_default();
        match name {
            "USE_LENGTH_UNITS" => self.change_units(if arguments.contains("INCH") { INCH_MM } else { 1.0 }),
            "SELECT_PLANE" => {
                self.plane = match arguments.rsplit('_').next() {
                    Some("XZ") => Plane::Zx,
                    Some("YZ") => Plane::Yz,
                    _ => Plane::Xy,
                }
            }
            "SET_G5X_OFFSET" | "SET_G92_OFFSET" | "USE_TOOL_LENGTH_OFFSET" | "SET_XY_ROTATION" => {
                // The tool stays where it is, and its printed coordinates become others.
                let axes = self.axes(&self.last);
                match name {
                    "SET_G5X_OFFSET" => self.origin = self.in_mm(values.get(1..).unwrap_or_default()),
                    "SET_G92_OFFSET" => self.shift = self.in_mm(values),
                    "USE_TOOL_LENGTH_OFFSET" => self.tool = self.in_mm(values),
                    _ => self.rotation_deg = first,
                }
                self.last = self.printed(&axes);
            }
            "SET_FEED_RATE" => self.feed = first,
            "SET_FEED_MODE" => self.per_revolution = second != 0.0,
            "START_SPEED_FEED_SYNC" => self.pitch = Some(first),
            "STOP_SPEED_FEED_SYNCH" => self.pitch = None,
            "SET_SPINDLE_SPEED" => self.speed = second,
            // The second number is the greatest speed; 0 is G97.
            "SET_SPINDLE_MODE" => self.surface_speed = second > 0.0,
            "START_SPINDLE_CLOCKWISE" => self.turns = 1.0,
            "START_SPINDLE_COUNTERCLOCKWISE" => self.turns = -1.0,
            "STOP_SPINDLE_TURNING" => self.turns = 0.0,
            _ => {}
        }
    }

    fn straight(&mut self, calls: &mut Vec<Call>, name: &str, number: u32, values: &[f64]) {
        let start = self.last;
        self.last = std::array::from_fn(|i| values.get(i).copied().unwrap_or(self.last[i]));
        // A probe is a feed that stops short of what is printed.
        if name == "STRAIGHT_PROBE" {
            self.stop_short_of(&start);
        }
        let kind = if name == "STRAIGHT_TRAVERSE" { Kind::Traverse } else { Kind::Feed };
        let (from, to) = (self.axes(&start), self.axes(&self.last));
        calls.push(self.call(kind, number, (name != "STRAIGHT_TRAVERSE").then_some((from, to))));
        // A tap comes back as it went.
        if name == "RIGID_TAP" {
            self.last = start;
            calls.push(self.call(Kind::Feed, number, Some((to, from))));
        }
    }

    /// Moves the last point back towards where its call started, by what a probe stops short.
    fn stop_short_of(&mut self, start: &[f64; 9]) {
        let length = (0..3).map(|i| (self.last[i] - start[i]).powi(2)).sum::<f64>().sqrt();
        if length > 0.0 {
            let back = PROBE_STOPS_SHORT_MM / self.unit_mm / length;
            for (last, start) in self.last.iter_mut().zip(start) {
                *last += back * (start - *last);
            }
        }
    }

    /// Printed lengths to mm; angles stay degrees.
    fn in_mm(&self, values: &[f64]) -> [f64; 9] {
        let scale = |i: usize| if Axis::ALL[i].is_rotary() { 1.0 } else { self.unit_mm };
        std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0) * scale(i))
    }

    fn change_units(&mut self, unit_mm: f64) {
        let factor = self.unit_mm / unit_mm;
        for (value, axis) in self.last.iter_mut().zip(Axis::ALL) {
            if !axis.is_rotary() {
                *value *= factor;
            }
        }
        self.feed *= factor;
        self.unit_mm = unit_mm;
    }

    /// Axis positions of printed coordinates.
    fn axes(&self, printed: &[f64; 9]) -> [f64; 9] {
        let mut point = self.in_mm(printed);
        point.iter_mut().zip(&self.shift).for_each(|(x, shift)| *x += shift);
        let (sin, cos) = self.rotation_deg.to_radians().sin_cos();
        (point[0], point[1]) = (point[0] * cos - point[1] * sin, point[0] * sin + point[1] * cos);
        std::array::from_fn(|i| point[i] + self.origin[i] + self.tool[i])
    }

    /// Printed coordinates of axis positions.
    fn printed(&self, axes: &[f64; 9]) -> [f64; 9] {
        let mut point: [f64; 9] = std::array::from_fn(|i| axes[i] - self.origin[i] - self.tool[i]);
        let (sin, cos) = (-self.rotation_deg).to_radians().sin_cos();
        (point[0], point[1]) = (point[0] * cos - point[1] * sin, point[0] * sin + point[1] * cos);
        let scale = |i: usize| if Axis::ALL[i].is_rotary() { 1.0 } else { self.unit_mm };
        std::array::from_fn(|i| (point[i] - self.shift[i]) / scale(i))
    }

    /// A call that ends at the last point; with start and end it feeds.
    fn call(&self, kind: Kind, at: u32, feeds: Option<([f64; 9], [f64; 9])>) -> Call {
        // Twice: a turned coordinate adds the roundings of two.
        let tolerance = 2.0 * SUMMANDS * PRINTED_HALF * self.unit_mm;
        let only_turns = feeds.is_some_and(|(from, to)| {
            let linear = [0, 1, 2, 6, 7, 8];
            linear.iter().all(|&i| (from[i] - to[i]).abs() <= NO_TRAVEL)
        });
        let (rate, per_revolution) = match self.pitch {
            Some(pitch) => (pitch, true),
            None => (self.feed, self.per_revolution),
        };
        let mut scale = if only_turns { 1.0 } else { self.unit_mm };
        if per_revolution {
            scale *= self.speed;
        }
        let feed = (feeds.is_some() && !(per_revolution && self.surface_speed)).then_some(rate * scale);
        let spindle = match self.turns {
            0.0 => 0.0,
            sense if self.surface_speed => f64::INFINITY.copysign(sense),
            sense => sense * self.speed,
        };
        let feed_tolerance = 2.0 * PRINTED_HALF * scale.max(1.0);
        Call { kind, end: self.axes(&self.last), feed, spindle, at, tolerance, feed_tolerance }
    }

    /// ARC_FEED(first end, second end, first centre, second centre, turns, end along the normal, A, B, C, ...).
    fn arc(&mut self, number: u32, values: &[f64]) -> Result<Call, String> {
        let &[first_end, second_end, first_centre, second_centre, turns, normal_end, ref rest @ ..] = values else {
            return Err(format!("call {number}: ARC_FEED with too few values"));
        };
        let start = self.axes(&self.last);
        let [first, second, normal] = self.plane.axes().map(|axis| axis as usize);
        for (i, value) in [(first, first_end), (second, second_end), (normal, normal_end)] {
            self.last[i] = value;
        }
        for (i, &value) in (3..).zip(rest) {
            self.last[i] = value;
        }
        let mut centre = self.last;
        (centre[first], centre[second]) = (first_centre, second_centre);
        let centre = self.axes(&centre);
        let kind = Kind::Arc { plane: self.plane, centre: [centre[first], centre[second]], turns };
        // An arc travels although its ends may be one point.
        let mut elsewhere = start;
        elsewhere[first] += 1.0;
        Ok(self.call(kind, number, Some((start, elsewhere))))
    }
}

/// Number, name and arguments of a printed call: `  12 N..... STRAIGHT_FEED(1.0000, ...)`.
fn parse(line: &str) -> Option<(u32, &str, &str)> {
    let mut words = line.trim_start().splitn(3, ' ');
    let number = words.next()?.parse().ok()?;
    words.next()?;
    let (name, arguments) = words.next()?.trim().split_once('(')?;
    Some((number, name, arguments.trim_end_matches(')')))
}
