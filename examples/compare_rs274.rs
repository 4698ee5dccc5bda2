//! Holds the interpreter against LinuxCNC's own: `compare_rs274 PROGRAM OUTPUT TABLE`, where OUTPUT is what the stand-alone
//! `rs274 -g` printed for PROGRAM with the tool table TABLE (in inches, rs274's unit when it has no INI file).
//!
//! rs274 prints its canonical calls with four decimals and the offsets apart. This program adds them up to axis positions
//! and compares each travelling call with ours: kind, end, and for arcs centre and sense of rotation. It prints one line,
//! `match MOVES` or `differ: WHY`, and ends with 0 or 1. `scripts/compare-rs274` runs it over a whole package.

#![expect(clippy::print_stdout, reason = "a program of its own: the line is its result")]

use bvbench::gcode::{self, Axis, Move, MoveKind, Plane, Setup};
use std::path::Path;
use std::process::ExitCode;

const INCH_MM: f64 = 25.4;
/// rs274 alone pretends that a probe trips this far before the end of its move, mm.
const PROBE_STOPS_SHORT_MM: f64 = 0.254;
/// Half of the last printed decimal, and how many printed numbers at most add up to a coordinate: itself, G5x, G92, tool.
const PRINTED_HALF: f64 = 0.5e-4;
const SUMMANDS: f64 = 4.0;
/// Travel below this, mm or degrees, is none: either side may leave such a move out.
const NO_TRAVEL: f64 = 1e-9;

/// A travelling call: mm and degrees, axis positions.
#[derive(Clone, Debug)]
struct Call {
    kind: &'static str,
    end: [f64; 9],
    /// Centre in the plane's axes, and whether the arc turns counter-clockwise.
    arc: Option<(Plane, [f64; 2], bool)>,
    /// Number of the printed call, or our line.
    at: u32,
    tolerance: f64,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [program, output, table] = arguments.as_slice() else {
        println!("usage: compare_rs274 PROGRAM OUTPUT TABLE");
        return ExitCode::from(2);
    };
    match compare(Path::new(program), Path::new(output), Path::new(table)) {
        Ok(moves) => {
            println!("match {moves}");
            ExitCode::SUCCESS
        }
        Err(why) => {
            println!("differ: {why}");
            ExitCode::FAILURE
        }
    }
}

fn compare(program: &Path, output: &Path, table: &Path) -> Result<usize, String> {
    let read = |path: &Path| std::fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    let text = |path: &Path| read(path).map_err(|error| format!("{}: {error}", path.display()));
    let tools = gcode::read_tool_table(&text(table)?, table, INCH_MM).map_err(|error| error.to_string())?;
    let setup = Setup { tools, probe_stops_short_mm: PROBE_STOPS_SHORT_MM, ..Setup::default() };
    let ours = gcode::interpret(&text(program)?, program, &setup).map_err(|error| error.to_string())?;
    let ours = travelling(ours.moves.iter().filter_map(ours_as_call));
    let theirs = travelling(Printed::default().calls(&text(output)?)?.into_iter());
    for (ours, theirs) in ours.iter().zip(&theirs) {
        differ(ours, theirs).map_or(Ok(()), |what| {
            Err(format!("line {}, rs274's call {}: {what}: ours {ours:?}, theirs {theirs:?}", ours.at, theirs.at))
        })?;
    }
    if ours.len() == theirs.len() {
        return Ok(ours.len());
    }
    let extra = ours.get(theirs.len()).or_else(|| theirs.get(ours.len()));
    Err(format!("{} calls, rs274 has {}; first extra one: {extra:?}", ours.len(), theirs.len()))
}

/// Without the straight calls that go nowhere.
fn travelling(calls: impl Iterator<Item = Call>) -> Vec<Call> {
    let mut at = [0.0; 9];
    let mut kept = Vec::new();
    for call in calls {
        let goes =
            call.arc.is_some() || call.end.iter().zip(&at).any(|(a, b)| (a - b).abs() > NO_TRAVEL + call.tolerance);
        if goes {
            at = call.end;
            kept.push(call);
        }
    }
    kept
}

/// What differs, if anything does.
fn differ(ours: &Call, theirs: &Call) -> Option<&'static str> {
    let near = |a: f64, b: f64| (a - b).abs() <= theirs.tolerance;
    if ours.kind != theirs.kind {
        return Some("kind");
    }
    if !ours.end.iter().zip(&theirs.end).all(|(&a, &b)| near(a, b)) {
        return Some("end");
    }
    match (&ours.arc, &theirs.arc) {
        (Some((plane, centre, turn)), Some((their_plane, their_centre, their_turn))) => {
            let same = centre.iter().zip(their_centre).all(|(&a, &b)| near(a, b));
            (plane != their_plane || !same || turn != their_turn).then_some("arc")
        }
        (None, None) => None,
        _ => Some("kind"),
    }
}

fn ours_as_call(step: &Move) -> Option<Call> {
    let end = std::array::from_fn(|i| {
        let axis = Axis::ALL[i];
        if axis.is_rotary() { step.end[axis].to_degrees() } else { step.end[axis] }
    });
    let (kind, arc) = match step.kind {
        MoveKind::Rapid => ("traverse", None),
        MoveKind::Feed => ("feed", None),
        MoveKind::Arc { plane, centre, sweep } => ("arc", Some((plane, centre, sweep > 0.0))),
        MoveKind::Dwell { .. } | MoveKind::ToolChange { .. } => return None,
    };
    Some(Call { kind, end, arc, at: step.line, tolerance: 0.0 })
}

/// The state that rs274 prints apart from its calls.
#[derive(Default)]
struct Printed {
    unit_mm: f64,
    origin: [f64; 9],
    shift: [f64; 9],
    tool: [f64; 9],
    rotation_deg: f64,
    plane: Plane,
    /// Where the last call ended, in printed coordinates.
    last: [f64; 9],
}

impl Printed {
    fn calls(mut self, text: &str) -> Result<Vec<Call>, String> {
        self.unit_mm = 1.0;
        let mut calls = Vec::new();
        for line in text.lines() {
            let Some((number, name, arguments)) = parse(line) else { continue };
            let values: Vec<f64> = arguments
                .split([',', ' '])
                .filter(|word| !word.is_empty())
                .filter_map(|word| word.parse().ok())
                .collect();
            match name {
                "USE_LENGTH_UNITS" => self.change_units(if arguments.contains("INCH") { INCH_MM } else { 1.0 }),
                "SELECT_PLANE" => {
                    self.plane = match arguments.rsplit('_').next() {
                        Some("XZ") => Plane::Zx,
                        Some("YZ") => Plane::Yz,
                        _ => Plane::Xy,
                    }
                }
                "SET_G5X_OFFSET" => self.origin = self.in_mm(values.get(1..).unwrap_or_default()),
                "SET_G92_OFFSET" => self.shift = self.in_mm(&values),
                "USE_TOOL_LENGTH_OFFSET" => self.tool = self.in_mm(&values),
                "SET_XY_ROTATION" => self.rotation_deg = values.first().copied().unwrap_or_default(),
                // A probe is a feed that stops short of what is printed.
                "STRAIGHT_TRAVERSE" | "STRAIGHT_FEED" | "STRAIGHT_PROBE" => {
                    let start = self.last;
                    self.last = self.printed(&values);
                    if name == "STRAIGHT_PROBE" {
                        self.stop_short_of(&start);
                    }
                    let kind = if name == "STRAIGHT_TRAVERSE" { "traverse" } else { "feed" };
                    calls.push(self.call(kind, number, None));
                }
                "ARC_FEED" => calls.push(self.arc(number, &values)?),
                "RIGID_TAP" => return Err("rs274 taps rigidly, which is no move of ours".to_owned()),
                _ => {}
            }
        }
        Ok(calls)
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

    fn printed(&self, values: &[f64]) -> [f64; 9] {
        std::array::from_fn(|i| values.get(i).copied().unwrap_or(self.last[i]))
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

    fn call(&self, kind: &'static str, at: u32, arc: Option<(Plane, [f64; 2], bool)>) -> Call {
        // Twice: a turned coordinate adds the roundings of two.
        let tolerance = 2.0 * SUMMANDS * PRINTED_HALF * self.unit_mm;
        Call { kind, end: self.axes(&self.last), arc, at, tolerance }
    }

    /// ARC_FEED(first end, second end, first centre, second centre, turns, end along the normal, A, B, C, ...).
    fn arc(&mut self, number: u32, values: &[f64]) -> Result<Call, String> {
        let &[first_end, second_end, first_centre, second_centre, turns, normal_end, ref rest @ ..] = values else {
            return Err(format!("call {number}: ARC_FEED with too few values"));
        };
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
        Ok(self.call("arc", number, Some((self.plane, [centre[first], centre[second]], turns > 0.0))))
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
