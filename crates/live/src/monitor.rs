//! From readings to permission: joins the readings of axes into samples, asks the judge, and keeps the state of the hold.
//!
//! Nothing here knows the network or a clock: times come with the readings. The rules of safe behaviour stand in `docs/live.md`; each is a
//! [`Fault`].

use crate::config::{Config, Release};
use crate::judge::{self, Answer, Ignorance, Judge, State, Verdict};
use bvbench::machine::Machine;
use bvbench::scene::{Pair, Scene};
use rs274::{Axis, Position};
use std::collections::VecDeque;
use thiserror::Error;

/// Ticks of OPC UA in a second: a tick is 100 ns.
pub const TICKS_PER_S: f64 = 1e7;
/// Samples over which the least delay is sought that later ones are compared with.
const DELAYS: usize = 100;

/// What a reading is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// Position of an axis, mm or radians.
    Axis(Axis),
    /// Line of the program.
    Line,
    /// Tool in the spindle.
    Tool,
}

/// A value that arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// What it is of.
    pub slot: Slot,
    /// The value, or the name of its status code.
    pub value: Result<f64, String>,
    /// When the control had it, ticks of its clock.
    pub source_ticks: i64,
}

/// Why the machine is held.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Fault {
    /// Contact cannot be excluded.
    #[error("contact cannot be excluded: {0}")]
    Contact(String),
    /// The look-ahead is clear again, but the hold waits for its release.
    #[error("held since contact could not be excluded")]
    Latched,
    /// The judge knows nothing.
    #[error(transparent)]
    Unknown(#[from] Ignorance),
    /// Too few samples for a velocity.
    #[error("no velocity yet")]
    NoVelocity,
    /// The clock of the control went back, or forth without as much time passing here.
    #[error("the control's clock jumped by {0:.3} s")]
    Clock(f64),
    /// A sample was long on its way.
    #[error("a sample came {0:.3} s late")]
    Late(f64),
    /// An axis has an older value than the others.
    #[error("the value of axis {0} is {1:.3} s older than the others")]
    Spread(char, f64),
    /// A value came with a bad status.
    #[error("{0:?}: {1}")]
    Status(Slot, String),
    /// No value came.
    #[error("no sample for {0:.3} s")]
    Stale(f64),
    /// There is no connection.
    #[error("no connection: {0}")]
    Lost(String),
    /// A node cannot be read or written.
    #[error("{0}")]
    Node(String),
    /// The log cannot be written.
    #[error("the log cannot be written: {0}")]
    Log(String),
}

impl Fault {
    /// Name of the kind, in logs.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Contact(_) => "contact",
            Self::Latched => "latched",
            Self::Unknown(_) => "unknown",
            Self::NoVelocity => "no-velocity",
            Self::Clock(_) => "clock",
            Self::Late(_) => "late",
            Self::Spread(..) => "spread",
            Self::Status(..) => "status",
            Self::Stale(_) => "stale",
            Self::Lost(_) => "lost",
            Self::Node(_) => "node",
            Self::Log(_) => "log",
        }
    }
}

/// What follows from a sample, or from none.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Source time of the sample, ticks; the oldest of its axes. 0 without a sample.
    pub source_ticks: i64,
    /// Where the axes were.
    pub position: Position,
    /// The verdict.
    pub verdict: Verdict,
    /// Clearance guaranteed over the look-ahead, mm, at most the near distance.
    pub clearance_mm: f64,
    /// The pair with that clearance; `None` when nothing is near.
    pub pair: Option<Pair>,
    /// Length of the look-ahead, s.
    pub horizon_s: f64,
    /// Distances that were found.
    pub queries: u32,
    /// Whether the machine is held.
    pub holds: bool,
    /// Why.
    pub fault: Option<Fault>,
    /// Line of the program; 0 when nobody says it.
    pub line: u32,
    /// Older samples that came with this one and were not judged.
    pub superseded: u32,
    /// How much longer the sample was on its way than the quickest one of the connection, s.
    pub delay_s: f64,
}

/// A value of an axis, and its source time, ticks.
type Value = (i64, f64);

/// The last two values of an axis.
#[derive(Clone, Debug, Default)]
struct Track {
    last: Option<Value>,
    /// Of an axis that turns without end: on the turn of the last, so that their difference is the way between them.
    before: Option<Value>,
    bad: Option<String>,
}

/// Watches one machine.
pub struct Monitor<'a> {
    scene: &'a Scene,
    judge: Judge<'a>,
    stale_s: f64,
    deadline_s: f64,
    source_jitter_s: f64,
    release: Release,
    axes: Vec<(Axis, Track)>,
    /// Largest error of each position, mm and radians.
    resolution: [f64; 9],
    /// A full turn of each axis that turns without end, in the unit of the axis.
    full_turn: [Option<f64>; 9],
    /// Tool in the spindle, or why it is not known.
    tool: Result<u32, Fault>,
    /// The tool until a node reports one.
    first_tool: Result<u32, Fault>,
    line: u32,
    /// Newest source time and when it was received, ticks and s.
    newest: Option<(i64, f64)>,
    delays: VecDeque<f64>,
    /// Least delay since the start, s, and by how much the last one was longer.
    least_delay_s: f64,
    delay_s: f64,
    /// Whether a hold for contact waits for its release, and since when the look-ahead has been clear, s.
    latched: bool,
    clear_since: Option<f64>,
    outside: Option<Fault>,
}

impl<'a> Monitor<'a> {
    /// A monitor that has seen nothing and holds.
    pub fn new(scene: &'a Scene, judge: Judge<'a>, config: &Config) -> Self {
        let axes = Axis::ALL.into_iter().filter(|axis| config.axes.contains_key(&axis.letter()));
        let first_tool = match &config.nodes.tool {
            Some(_) => Err(Fault::Status(Slot::Tool, "no value yet".to_owned())),
            None => Ok(config.tool.unwrap_or(0)),
        };
        Self {
            scene,
            judge,
            stale_s: config.stale_s,
            deadline_s: config.deadline_s,
            source_jitter_s: config.source_jitter_s,
            release: config.release,
            axes: axes.map(|axis| (axis, Track::default())).collect(),
            resolution: Axis::ALL.map(|axis| config.axes.get(&axis.letter()).map_or(0.0, |own| own.resolution)),
            full_turn: Axis::ALL.map(|axis| endless_turn(&scene.machine, axis)),
            tool: first_tool.clone(),
            first_tool,
            line: 0,
            newest: None,
            delays: VecDeque::new(),
            least_delay_s: f64::INFINITY,
            delay_s: 0.0,
            latched: false,
            clear_since: None,
            outside: None,
        }
    }

    /// A fault outside the samples: it holds until [`Monitor::recover`].
    pub fn fail(&mut self, fault: Fault) {
        self.outside = Some(fault);
    }

    /// The fault outside the samples is gone.
    pub fn recover(&mut self) {
        self.outside = None;
    }

    /// Forgets all that a connection said: the next sample has no velocity, and the tool is unknown until its node says it again.
    pub fn restart(&mut self) {
        self.tool = self.first_tool.clone();
        self.forget_samples();
    }

    /// Forgets all samples. The tool stays: a server need not send a value again that did not change.
    fn forget_samples(&mut self) {
        for (_, track) in &mut self.axes {
            *track = Track::default();
        }
        (self.newest, self.clear_since) = (None, None);
        (self.least_delay_s, self.delay_s) = (f64::INFINITY, 0.0);
        self.delays.clear();
        self.judge.forget();
    }

    /// What follows from a fault that leaves nothing to judge.
    pub fn without_sample(&mut self, fault: Fault) -> Outcome {
        self.clear_since = None;
        self.held(fault, 0)
    }

    /// Source time of the newest values, ticks: that of the oldest among the axes; 0 when one has none.
    pub fn source_ticks(&self) -> i64 {
        self.axes.iter().map(|(_, track)| track.last.map_or(0, |(ticks, _)| ticks)).min().unwrap_or(0)
    }

    /// Takes readings that came together at `received_s`, and judges the newest sample among them. `None` when no axis is among them.
    pub fn take(&mut self, readings: &[Reading], received_s: f64) -> Option<Outcome> {
        let mut jump = None;
        let mut times: Vec<i64> = Vec::new();
        for reading in readings {
            match reading.slot {
                Slot::Line => self.line = whole(reading).unwrap_or(0),
                Slot::Tool => self.tool = whole(reading).ok_or_else(|| status(reading)),
                Slot::Axis(axis) => {
                    jump = self.note(axis, reading).or(jump);
                    times.push(reading.source_ticks);
                }
            }
        }
        if times.is_empty() {
            // A tool that is no longer known holds at once, and not with the next sample.
            return self.tool.clone().err().map(|fault| self.without_sample(fault));
        }
        times.sort_unstable();
        times.dedup();
        let superseded = u32::try_from(times.len().saturating_sub(1)).unwrap_or(u32::MAX);
        let state = match jump.map_or_else(|| self.state(received_s), Err) {
            Ok(state) => state,
            Err(fault) => {
                if matches!(fault, Fault::Clock(_)) {
                    self.forget_samples();
                }
                self.clear_since = None;
                return Some(self.held(fault, superseded));
            }
        };
        let answer = self.judge.judge(&state);
        Some(self.decide(&answer, received_s, superseded))
    }

    /// Notes a value of an axis; a clock that went back is a fault.
    fn note(&mut self, axis: Axis, reading: &Reading) -> Option<Fault> {
        let (_, track) = self.axes.iter_mut().find(|(own, _)| *own == axis)?;
        let value = match &reading.value {
            Ok(value) => *value,
            Err(status) => {
                track.bad = Some(status.clone());
                return None;
            }
        };
        track.bad = None;
        match track.last {
            Some((ticks, _)) if reading.source_ticks < ticks => {
                Some(Fault::Clock(seconds(reading.source_ticks.saturating_sub(ticks))))
            }
            Some((ticks, _)) if reading.source_ticks == ticks => None,
            last => {
                let now = (reading.source_ticks, value);
                let before = match (last, self.full_turn[axis as usize]) {
                    (Some(last), Some(turn)) => Some(on_the_turn(turn, track.before, last, now)),
                    _ => last,
                };
                (track.before, track.last) = (before, Some(now));
                None
            }
        }
    }

    /// The sample that the newest values form.
    fn state(&mut self, received_s: f64) -> Result<State, Fault> {
        let mut position = Position::default();
        let (mut velocity, mut velocity_error) = (Position::default(), Position::default());
        let jitter_s = 2.0 * self.source_jitter_s;
        let is_usable = |over_s: f64| over_s > jitter_s && over_s <= self.stale_s;
        let (mut oldest, mut newest) = (i64::MAX, i64::MIN);
        let (mut slowest, mut interval_s) = ('X', 0.0_f64);
        let mut has_velocity = true;
        for (axis, track) in &self.axes {
            if let Some(bad) = &track.bad {
                return Err(Fault::Status(Slot::Axis(*axis), bad.clone()));
            }
            let Some((ticks, value)) = track.last else { return Err(Fault::NoVelocity) };
            position[*axis] = value;
            if ticks < oldest {
                (oldest, slowest) = (ticks, axis.letter());
            }
            newest = newest.max(ticks);
            match track.before {
                Some((before, from)) if is_usable(seconds(ticks.saturating_sub(before))) => {
                    let over_s = seconds(ticks.saturating_sub(before));
                    velocity[*axis] = (value - from) / over_s;
                    let resolution = self.resolution[*axis as usize];
                    velocity_error[*axis] = judge::velocity_error(velocity[*axis], resolution, over_s, jitter_s);
                    interval_s = interval_s.max(over_s + jitter_s);
                }
                _ => has_velocity = false,
            }
        }
        self.check_clock(newest, received_s)?;
        let spread_s = seconds(newest.saturating_sub(oldest));
        if spread_s > self.deadline_s {
            return Err(Fault::Spread(slowest, spread_s));
        }
        if !has_velocity {
            return Err(Fault::NoVelocity);
        }
        let (spread_s, tool) = (spread_s + jitter_s, self.tool.clone()?);
        Ok(State { position, velocity, velocity_error, interval_s, spread_s, tool })
    }

    /// Compares the control's clock with the time that passed here.
    fn check_clock(&mut self, ticks: i64, received_s: f64) -> Result<(), Fault> {
        if let Some((before, at)) = self.newest.replace((ticks, received_s)) {
            let ahead = seconds(ticks.saturating_sub(before)) - (received_s - at);
            if ahead > self.stale_s {
                return Err(Fault::Clock(ahead));
            }
        }
        let delay = received_s - seconds(ticks);
        self.least_delay_s = self.least_delay_s.min(delay);
        self.delay_s = delay - self.least_delay_s;
        let least = self.delays.iter().copied().fold(delay, f64::min);
        self.delays.push_back(delay);
        if self.delays.len() > DELAYS {
            self.delays.pop_front();
        }
        if delay - least > self.stale_s { Err(Fault::Late(delay - least)) } else { Ok(()) }
    }

    /// The state of the hold after an answer.
    fn decide(&mut self, answer: &Answer, received_s: f64, superseded: u32) -> Outcome {
        let fault = match (answer.verdict, &answer.cause) {
            (Verdict::Clear | Verdict::Near, _) => None,
            (_, Some(cause)) => Some(Fault::Unknown(cause.clone())),
            _ => Some(Fault::Contact(answer.pair.map(|pair| self.scene.pair_name(pair)).unwrap_or_default())),
        };
        self.latched |= answer.verdict == Verdict::Collision;
        if fault.is_some() {
            self.clear_since = None;
        } else {
            let since = *self.clear_since.get_or_insert(received_s);
            if matches!(self.release, Release::After(wait_s) if received_s - since >= wait_s) {
                self.latched = false;
            }
        }
        let fault = fault.or_else(|| self.outside.clone()).or_else(|| self.latched.then_some(Fault::Latched));
        let Answer { verdict, clearance_mm, pair, horizon_s, queries, .. } = *answer;
        let holds = fault.is_some();
        Outcome { verdict, clearance_mm, pair, horizon_s, queries, holds, fault, superseded, ..self.outcome() }
    }

    fn held(&self, fault: Fault, superseded: u32) -> Outcome {
        Outcome { holds: true, fault: Some(fault), superseded, ..self.outcome() }
    }

    /// An outcome about the newest values, unknown so far.
    fn outcome(&self) -> Outcome {
        let mut position = Position::default();
        for (axis, track) in &self.axes {
            position[*axis] = track.last.map_or(0.0, |(_, value)| value);
        }
        Outcome {
            source_ticks: self.source_ticks(),
            position,
            verdict: Verdict::Unknown,
            clearance_mm: 0.0,
            pair: None,
            horizon_s: 0.0,
            queries: 0,
            holds: true,
            fault: None,
            line: self.line,
            superseded: 0,
            delay_s: self.delay_s,
        }
    }
}

/// A full turn of an axis that turns without end: a control may show such an axis modulo a turn.
fn endless_turn(machine: &Machine, axis: Axis) -> Option<f64> {
    let is_endless = machine.axis_limits(axis) == Some([f64::NEG_INFINITY, f64::INFINITY]);
    machine.full_turn(axis).filter(|_| is_endless)
}

/// `last`, whole turns away from where it is: of the ways from there to `now`, the one nearest to the way at the velocity before. Without that, the
/// shortest one.
fn on_the_turn(turn: f64, before: Option<Value>, last: Value, now: Value) -> Value {
    let over_s = |from: Value, to: Value| seconds(to.0.saturating_sub(from.0));
    let velocity = before.map(|before| (last.1 - before.1) / over_s(before, last)).filter(|v| v.is_finite());
    let expected = velocity.unwrap_or(0.0) * over_s(last, now);
    (last.0, last.1 + turn * ((now.1 - last.1 - expected) / turn).round())
}

fn seconds(ticks: i64) -> f64 {
    ticks as f64 / TICKS_PER_S
}

/// A number of a tool or a line.
fn whole(reading: &Reading) -> Option<u32> {
    let value = *reading.value.as_ref().ok()?;
    (value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0).then_some(value as u32)
}

fn status(reading: &Reading) -> Fault {
    let cause = match &reading.value {
        Ok(value) => format!("{value} is no number of a tool"),
        Err(status) => status.clone(),
    };
    Fault::Status(reading.slot, cause)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use bvbench::registry;
    use std::path::Path;

    const CYCLE: i64 = 40_000;

    fn config(more: &str) -> Config {
        let text = format!(
            "scene = \"x\"\nendpoint = \"opc.tcp://127.0.0.1\"\npreset = \"sinumerik\"\naxes.X.acceleration = 1000\naxes.Y.acceleration = 1000\naxes.Z.acceleration = 1000\n{more}\n"
        );
        let text = if text.contains("[nodes]") { text } else { format!("{text}nodes.heartbeat = \"ns=2;s=beat\"\n") };
        Config::parse(Path::new("live.toml"), &text).unwrap()
    }

    struct Bench<'a> {
        monitor: Monitor<'a>,
        ticks: i64,
        received_s: f64,
    }

    impl<'a> Bench<'a> {
        fn new(scene: &'a Scene, more: &str) -> Self {
            let config = config(more);
            let rule = config.rule(scene).unwrap();
            let judge = Judge::new(scene, registry::standard().fastest().unwrap(), rule).unwrap();
            Self { monitor: Monitor::new(scene, judge, &config), ticks: 10 * CYCLE, received_s: 0.0 }
        }

        fn readings(&self, x: f64) -> Vec<Reading> {
            let axes = [(Axis::X, x), (Axis::Y, 0.0), (Axis::Z, 0.0)];
            let reading =
                |(axis, value)| Reading { slot: Slot::Axis(axis), value: Ok(value), source_ticks: self.ticks };
            axes.map(reading).into()
        }

        fn pass(&mut self) {
            (self.ticks, self.received_s) = (self.ticks + CYCLE, self.received_s + 0.004);
        }

        fn sample(&mut self, x: f64) -> Outcome {
            self.pass();
            self.monitor.take(&self.readings(x), self.received_s).unwrap()
        }

        fn fault(&mut self, x: f64) -> &'static str {
            self.sample(x).fault.map_or("none", |fault| fault.name())
        }
    }

    #[test]
    fn the_first_sample_holds_and_the_second_permits() {
        let scene = testing::mill();
        let mut bench = Bench::new(&scene, "");
        assert_eq!(bench.fault(0.0), "no-velocity");
        let second = bench.sample(0.1);
        assert!(!second.holds && second.verdict == Verdict::Clear, "{second:?}");
        assert_eq!(second.source_ticks, bench.ticks);
    }

    #[test]
    fn a_hold_for_contact_is_latched_or_released_after_a_while() {
        let scene = testing::mill();
        for (more, expected) in [("", "latched"), ("release_after_s = 0.02", "none")] {
            let mut bench = Bench::new(&scene, more);
            bench.sample(44.6);
            let held = bench.sample(45.0);
            assert!(held.holds && held.fault.unwrap().name() == "contact");
            for _ in 0..3 {
                assert!(bench.sample(30.0).holds, "a jump of position is a velocity, then the hold waits");
            }
            (0..7).for_each(|_| drop(bench.sample(30.0)));
            assert_eq!(bench.fault(30.0), expected);
        }
    }

    #[test]
    fn faults_hold_and_are_recovered_from() {
        let scene = testing::mill();
        let mut bench = Bench::new(&scene, "");
        (0..3).for_each(|_| drop(bench.sample(0.0)));
        assert_eq!(bench.fault(0.0), "none");

        // The clock goes back, then goes on from there.
        bench.ticks -= 5 * CYCLE;
        assert_eq!(bench.fault(0.0), "clock");
        assert_eq!((bench.fault(0.0), bench.fault(0.0)), ("no-velocity", "none"));
        // The clock goes a second ahead.
        bench.ticks += 10_000_000;
        assert_eq!(bench.fault(0.0), "clock");
        assert_eq!((bench.fault(0.0), bench.fault(0.0)), ("no-velocity", "none"));

        // A sample that was half a second on its way, and one after it in time.
        bench.pass();
        let late = bench.monitor.take(&bench.readings(0.0), bench.received_s + 0.5).unwrap();
        assert_eq!(late.fault.unwrap().name(), "late");
        assert_eq!(bench.fault(0.0), "clock", "half a second passed there in 4 ms here");
        bench.sample(0.0);
        assert_eq!(bench.fault(0.0), "none");

        // An axis with a bad status, one beyond its limits, one that stays behind.
        bench.pass();
        let mut readings = bench.readings(0.0);
        readings[1].value = Err("BadSensorFailure".into());
        let bad = bench.monitor.take(&readings, bench.received_s).unwrap();
        assert_eq!(bad.fault.unwrap().to_string(), "Axis(Y): BadSensorFailure");
        assert_eq!(bench.fault(0.0), "none");
        for _ in 0..6 {
            bench.pass();
            let mut readings = bench.readings(0.0);
            readings.truncate(2);
            bench.monitor.take(&readings, bench.received_s).unwrap();
        }
        bench.pass();
        let behind = bench.monitor.take(&bench.readings(0.0)[..2], bench.received_s).unwrap();
        assert_eq!(behind.fault.unwrap().name(), "spread");
        bench.sample(0.0);
        assert_eq!(bench.fault(0.0), "none");

        // Silence, and a fault from outside.
        assert_eq!(bench.monitor.without_sample(Fault::Stale(0.3)).fault.unwrap().to_string(), "no sample for 0.300 s");
        bench.monitor.fail(Fault::Log("disk full".into()));
        assert_eq!(bench.fault(0.0), "log");
        bench.monitor.recover();
        assert_eq!(bench.fault(0.0), "none");
    }

    #[test]
    fn errors_of_positions_and_source_times_widen_the_look_ahead() {
        let scene = testing::mill();
        let horizon_s = |more: &str| {
            let mut bench = Bench::new(&scene, more);
            bench.sample(0.0);
            bench.sample(0.4).horizon_s
        };
        // v = 0.4 mm / 4 ms = 100 mm/s, wrong by up to e = 2 · 0.001 mm / 4 ms = 0.5 mm/s; s = v + e + 1000 · (0.02 + 2 · 0.004) = 128.5 mm/s;
        // H = D + s / 2000.
        assert!((horizon_s("") - (0.02 + 0.06425)).abs() < 1e-9);
        assert!((horizon_s("axes.X.resolution = 0.01") - (0.02 + 0.0665)).abs() < 1e-9);
        // With j = 1 ms v is wrong by up to (v · 2 ms + 0.002 mm) / (4 - 2) ms = 101 mm/s, h at most 6 ms and D 21 ms: s = 201 + 33 mm/s.
        assert!((horizon_s("source_jitter_ms = 1") - (0.021 + 0.117)).abs() < 1e-9);
        // An interval that may be none has no velocity.
        let mut bench = Bench::new(&scene, "source_jitter_ms = 1");
        bench.sample(0.0);
        bench.ticks -= CYCLE / 2;
        assert_eq!((bench.fault(0.4), bench.fault(0.4)), ("no-velocity", "none"));
    }

    /// A block on a table that turns by C, and the faults when C is shown at these angles, degrees, a cycle apart.
    fn faults_of_turning(limits: &str, degrees: &[f64]) -> Vec<&'static str> {
        let table = format!(
            "[[machine.links]]\nname = \"c\"\njoint = {{ axis = \"C\", direction = [0, 0, 1]{limits} }}\n[[parts]]"
        );
        let text = testing::SCENE.replacen("[[parts]]", &table, 1);
        let scene = testing::scene(&text.replace("role = \"fixture\"", "role = \"fixture\"\nlink = \"c\""));
        let mut bench = Bench::new(&scene, "axes.C.acceleration = 9000");
        let fault = |&angle: &f64| {
            bench.pass();
            let turned =
                Reading { slot: Slot::Axis(Axis::C), value: Ok(angle.to_radians()), source_ticks: bench.ticks };
            let readings = [bench.readings(0.0), vec![turned]].concat();
            bench.monitor.take(&readings, bench.received_s).unwrap().fault.map_or("none", |fault| fault.name())
        };
        degrees.iter().map(fault).collect()
    }

    #[test]
    fn an_axis_that_turns_without_end_may_be_shown_modulo_a_turn() {
        let rest = |faults: Vec<&'static str>| faults[1..].to_vec();
        for degrees in [
            [359.92, 359.96, 0.0, 0.04],
            [0.04, 0.0, 359.96, 359.92],
            [179.92, 179.96, -180.0, -179.96],
            [719.92, 719.96, 720.0, 720.04],
        ] {
            assert_eq!(rest(faults_of_turning("", &degrees)), ["none"; 3], "{degrees:?}");
        }
        // Where the joint has limits, what looks like a turn is one.
        let limits = ", min_deg = -720, max_deg = 720";
        assert_eq!(rest(faults_of_turning(limits, &[359.92, 359.96, 0.0])), ["none", "contact"]);
        // A value that is no number is forgotten after two samples.
        let faults = faults_of_turning("", &[0.0, 0.0, f64::NAN, 0.0, 0.0]);
        assert_eq!(rest(faults), ["none", "unknown", "unknown", "none"]);
    }

    #[test]
    fn of_the_ways_around_that_one_counts_that_differs_least_from_the_last() {
        let way = |before: Option<f64>, last: f64, now: f64, cycles: i64| {
            let from = on_the_turn(360.0, before.map(|angle| (0, angle)), (CYCLE, last), ((1 + cycles) * CYCLE, now));
            now - from.1
        };
        // Without a velocity, the shorter way.
        assert_eq!(
            (way(None, 350.0, 20.0, 1), way(None, 20.0, 350.0, 1), way(None, 10.0, 50.0, 1)),
            (30.0, -30.0, 40.0)
        );
        // At 8 degrees a cycle, 25 cycles without a sample are 200 degrees and not 160 the other way, however the axis is shown.
        assert_eq!((way(Some(2.0), 10.0, 210.0, 25), way(Some(202.0), 210.0, 50.0, 25)), (200.0, 200.0));
        assert_eq!(way(Some(8.0), 0.0, 160.0, 25), -200.0);
    }

    #[test]
    fn a_delay_that_grows_slowly_is_seen() {
        let scene = testing::mill();
        let mut bench = Bench::new(&scene, "");
        (0..3).for_each(|_| drop(bench.sample(0.0)));
        assert_eq!(bench.sample(0.0).delay_s, 0.0);
        // Each sample comes 0.1 ms later than the one before: none of them is late among the last hundred.
        for count in 1..=1000 {
            bench.received_s += 1e-4;
            let outcome = bench.sample(0.0);
            assert!(!outcome.holds, "{outcome:?}");
            assert!((outcome.delay_s - 1e-4 * f64::from(count)).abs() < 1e-6, "{outcome:?}");
        }
    }

    const TOOL: &str = "[nodes]\nheartbeat = \"ns=2;s=beat\"\ntool = \"ns=2;s=tool\"";

    fn tool(value: Result<f64, String>) -> Reading {
        Reading { slot: Slot::Tool, value, source_ticks: 0 }
    }

    #[test]
    fn an_unknown_tool_holds_until_it_is_known() {
        let scene = testing::tools();
        let mut bench = Bench::new(&scene, TOOL);
        // No tool yet: it is not taken for tool 0, which has no parts.
        assert_eq!((bench.fault(0.0), bench.fault(0.0)), ("no-velocity", "status"));
        assert!(bench.monitor.take(&[tool(Ok(1.0))], bench.received_s).is_none());
        assert_eq!(bench.fault(0.0), "none");
        // A bad value holds at once, and goes on holding: the tool before it is not judged.
        for value in [Err("BadNotReadable".to_owned()), Ok(1.5), Ok(-1.0)] {
            let alone = bench.monitor.take(&[tool(value)], bench.received_s).unwrap();
            assert_eq!((alone.holds, alone.fault.unwrap().name()), (true, "status"));
            assert_eq!((bench.fault(0.0), bench.fault(0.0)), ("status", "status"));
            bench.monitor.take(&[tool(Ok(1.0))], bench.received_s);
            assert_eq!(bench.fault(0.0), "none");
        }
        // A bad value does not hide the axes behind it, which have a velocity when the tool is back.
        bench.pass();
        let readings = [vec![tool(Err("BadNotReadable".into()))], bench.readings(0.1)].concat();
        let held = bench.monitor.take(&readings, bench.received_s).unwrap();
        assert_eq!((held.position[Axis::X], held.source_ticks), (0.1, bench.ticks));
        bench.pass();
        let readings = [vec![tool(Ok(1.0))], bench.readings(0.2)].concat();
        assert!(!bench.monitor.take(&readings, bench.received_s).unwrap().holds);
        // A jump of the clock leaves the tool as it is; a new connection says it anew.
        bench.ticks -= 5 * CYCLE;
        assert_eq!((bench.fault(0.0), bench.fault(0.0), bench.fault(0.0)), ("clock", "no-velocity", "none"));
        bench.monitor.restart();
        assert_eq!((bench.fault(0.0), bench.fault(0.0)), ("no-velocity", "status"));
    }

    #[test]
    fn the_tool_that_is_known_is_the_one_that_is_judged() {
        let scene = testing::tools();
        let mut bench = Bench::new(&scene, TOOL);
        for (number, expected) in [(2.0, "none"), (1.0, "contact"), (3.0, "unknown")] {
            bench.monitor.take(&[tool(Ok(number))], bench.received_s);
            bench.sample(49.0);
            assert_eq!(bench.fault(49.0), expected, "tool {number}");
        }
    }

    #[test]
    fn a_joint_out_of_its_limits_holds_until_it_is_back() {
        let scene = testing::mill();
        let mut bench = Bench::new(&scene, "");
        (0..2).for_each(|_| drop(bench.sample(-199.95)));
        assert_eq!(bench.fault(-199.95), "none");
        let beyond = bench.sample(-200.05);
        assert_eq!(beyond.fault.unwrap().to_string(), "axis X at -200.05 mm is outside its limits -200 to 200 mm");
        assert_eq!(bench.fault(-199.95), "none");
    }

    #[test]
    fn of_samples_that_come_together_the_newest_is_judged() {
        let scene = testing::mill();
        let mut bench = Bench::new(&scene, "");
        bench.sample(0.0);
        let mut readings = Vec::new();
        for x in [0.1, 0.2, 0.3] {
            bench.pass();
            readings.extend(bench.readings(x));
        }
        let outcome = bench.monitor.take(&readings, bench.received_s).unwrap();
        assert_eq!((outcome.superseded, outcome.source_ticks), (2, bench.ticks));
        assert_eq!(outcome.position[Axis::X], 0.3);
        assert!(!outcome.holds);
    }
}
