//! Holds the interpreter against LinuxCNC's own: `compare_rs274 PROGRAM OUTPUT TABLE`, where OUTPUT is what the stand-alone
//! `rs274 -g` printed for PROGRAM with the tool table TABLE (in inches, rs274's unit when it has no INI file).
//!
//! Compared are, in their order, all traverses, feeds, arcs, dwells and tool changes: the end of all axes, of arcs plane, centre
//! and number of turns, of feeds the rate, and with each of them what the spindle does. Calls that travel nowhere are left out on both sides. A spline is one
//! call of rs274's, whose course it does not print, and any number of feeds here. It prints one line, `match CALLS` or `differ: WHY`, and
//! ends with 0 or 1. `scripts/compare-rs274` runs it over a whole package.

#![expect(clippy::print_stdout, reason = "a program of its own: the line is its result")]

mod printed;

use printed::Printed;
use rs274::{Axis, Move, MoveKind, Plane, Setup};
use std::f64::consts::TAU;
use std::path::Path;
use std::process::ExitCode;

const INCH_MM: f64 = 25.4;
/// rs274 alone pretends that a probe trips this far before the end of its move, mm.
const PROBE_STOPS_SHORT_MM: f64 = 0.254;
/// Travel below this, mm or degrees, is none: either side may leave such a move out.
const NO_TRAVEL: f64 = 1e-9;
/// Turns beyond a whole number by less than this are that number.
const WHOLE_TURN: f64 = 1e-6;

/// What a call does.
#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Traverse,
    Feed,
    /// Centre in the plane's axes; turns, counter-clockwise above zero, a turn that has begun counting whole.
    Arc {
        plane: Plane,
        centre: [f64; 2],
        turns: f64,
    },
    Spline,
    Dwell(f64),
    ToolChange(f64),
}

/// A call: mm and degrees, axis positions.
#[derive(Clone, Debug)]
struct Call {
    kind: Kind,
    end: [f64; 9],
    /// mm/min or degrees/min; `None` where there is none or it is not known.
    feed: Option<f64>,
    /// Revolutions per minute, clockwise above zero; infinite where only the sense is known.
    spindle: f64,
    /// Number of the printed call, or our line.
    at: u32,
    /// How far numbers may differ: lengths and angles, feed rate.
    tolerance: f64,
    feed_tolerance: f64,
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
    let tools = rs274::read_tool_table(&text(table)?, table, INCH_MM).map_err(|error| error.to_string())?;
    let setup = Setup { tools, probe_stops_short_mm: PROBE_STOPS_SHORT_MM, ..Setup::default() };
    let ours = rs274::interpret(&text(program)?, program, &setup).map_err(|error| error.to_string())?;
    let ours = effective(ours.moves.iter().map(ours_as_call));
    let theirs = effective(Printed::default().calls(&text(output)?)?.into_iter());
    let mut at = 0;
    for call in &theirs {
        let Some(our) = ours.get(at) else { return Err(format!("rs274 has a further call: {call:?}")) };
        at += if call.kind == Kind::Spline {
            ours[at..].iter().take_while(|other| other.at == our.at).count()
        } else {
            1
        };
        if let Some(what) = differ(our, call) {
            return Err(format!("line {}, rs274's call {}: {what}: ours {our:?}, theirs {call:?}", our.at, call.at));
        }
    }
    match ours.get(at) {
        None => Ok(theirs.len()),
        Some(call) => Err(format!("a further call: {call:?}")),
    }
}

/// Without the straight calls that go nowhere and the dwells that do not last.
fn effective(calls: impl Iterator<Item = Call>) -> Vec<Call> {
    let mut at = [0.0; 9];
    let mut kept = Vec::new();
    for call in calls {
        let travels = call.end.iter().zip(&at).any(|(a, b)| (a - b).abs() > NO_TRAVEL + call.tolerance);
        let (moves, counts) = match call.kind {
            Kind::Traverse | Kind::Feed => (true, travels),
            Kind::Arc { .. } | Kind::Spline => (true, true),
            Kind::Dwell(seconds) => (false, seconds > 0.0),
            Kind::ToolChange(_) => (false, true),
        };
        if counts {
            if moves {
                at = call.end;
            }
            kept.push(call);
        }
    }
    kept
}

/// What differs, if anything does.
fn differ(ours: &Call, theirs: &Call) -> Option<&'static str> {
    let near = |a: f64, b: f64| (a - b).abs() <= theirs.tolerance;
    match (&ours.kind, &theirs.kind) {
        // rs274 does not print where a spline goes; the call behind it tells.
        (Kind::Feed, Kind::Spline) => return None,
        (Kind::Dwell(a), Kind::Dwell(b)) | (Kind::ToolChange(a), Kind::ToolChange(b)) => {
            return (!near(*a, *b)).then_some("time or tool");
        }
        (Kind::Arc { plane, centre, turns }, Kind::Arc { plane: p, centre: c, turns: t }) => {
            let same = centre.iter().zip(c).all(|(&a, &b)| near(a, b));
            if plane != p || !same || turns != t {
                return Some("arc");
            }
        }
        (Kind::Traverse, Kind::Traverse) | (Kind::Feed, Kind::Feed) => {}
        _ => return Some("kind"),
    }
    if !ours.end.iter().zip(&theirs.end).all(|(&a, &b)| near(a, b)) {
        return Some("end");
    }
    if let (Some(a), Some(b)) = (ours.feed, theirs.feed)
        && (a - b).abs() > theirs.feed_tolerance
    {
        return Some("feed rate");
    }
    let same_spindle = if theirs.spindle.is_infinite() {
        ours.spindle.signum() == theirs.spindle.signum()
    } else {
        near(ours.spindle, theirs.spindle)
    };
    (!same_spindle).then_some("spindle")
}

fn ours_as_call(step: &Move) -> Call {
    let end = std::array::from_fn(|i| {
        let axis = Axis::ALL[i];
        if axis.is_rotary() { step.end[axis].to_degrees() } else { step.end[axis] }
    });
    let kind = match step.kind {
        MoveKind::Rapid => Kind::Traverse,
        MoveKind::Feed => Kind::Feed,
        MoveKind::Arc { plane, centre, sweep } => {
            let turns = (sweep.abs() / TAU - WHOLE_TURN).ceil().max(1.0).copysign(sweep);
            Kind::Arc { plane, centre, turns }
        }
        MoveKind::Dwell { seconds } => Kind::Dwell(seconds),
        MoveKind::ToolChange { tool } => Kind::ToolChange(f64::from(tool)),
    };
    let (feed, spindle) = (step.feed_mm_min, step.spindle_rpm);
    Call { kind, end, feed, spindle, at: step.line, tolerance: 0.0, feed_tolerance: 0.0 }
}
