//! A program at its real feed, with accelerations: what a simulated control plays.
//!
//! The path of the program is a chain of straight segments in axis space ([`bvbench::check::Path`]). A speed profile along it keeps every
//! axis below its acceleration: within a segment the speed rises and falls at a share of it, and at a corner the velocity changes within a cycle by another. An override from 0 to 1 scales the clock
//! of the program, so that a hold stays on its path.
//!
//! Shares. In a window of one cycle an axis gains `TANGENTIAL` of its acceleration from the segment, `CORNER` from a corner that stands
//! alone, `CORNER` from corners that follow within the cycle, and `RESUME` from an override that rises. They sum to 1.

use crate::judge::Dynamics;
use bvbench::check::Path;
use bvbench::scene::{ProgramRun, Scene, TipFault};
use rs274::Position;
use std::sync::Arc;

const TANGENTIAL: f64 = 0.4;
const CORNER: f64 = 0.15;
const RESUME: f64 = 0.3;
/// Length of a radian, mm: only the shares of the axes in a path's length depend on it.
const RADIAN_MM: f64 = 100.0;
/// Segments shorter than this are left out, mm.
const SHORTEST_MM: f64 = 1e-9;

/// A segment of the path with its speed profile: it gains speed, keeps it, and loses it.
#[derive(Clone, Copy, Debug)]
struct Segment {
    from: Position,
    /// Change of each axis per mm of path.
    direction: [f64; 9],
    length_mm: f64,
    /// Speed that the program asks for, mm/s of path.
    feed: f64,
    /// Gain and loss of speed, mm/s².
    rate: f64,
    /// Speeds at the beginning, in the middle and at the end.
    speeds: [f64; 3],
    /// Durations of the three parts, s; a dwell has the middle one alone.
    durations: [f64; 3],
    /// When it begins, s.
    begin: f64,
    line: u32,
    tool: u32,
}

impl Segment {
    fn duration(&self) -> f64 {
        self.durations.iter().sum()
    }

    /// Way along the segment, mm, and speed, mm/s, after `time` s.
    fn after(&self, time: f64) -> (f64, f64) {
        let [first, top, _] = self.speeds;
        let [rise, keep, fall] = self.durations;
        let t = time.clamp(0.0, rise + keep + fall);
        let (up, kept, down) = (t.min(rise), (t - rise).clamp(0.0, keep), (t - rise - keep).max(0.0));
        let way = first * up + 0.5 * self.rate * up * up + top * (kept + down) - 0.5 * self.rate * down * down;
        let speed = if t < rise { first + self.rate * up } else { top - self.rate * down };
        (way.min(self.length_mm), speed)
    }
}

/// Where a program is at a time of its own clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Positions, mm and radians.
    pub position: Position,
    /// Velocities, mm/s and radians/s.
    pub velocity: Position,
    /// Line of the program; 0 before its first move.
    pub line: u32,
    /// Tool in the spindle.
    pub tool: u32,
}

/// A program with its times.
#[derive(Clone, Debug)]
pub struct Plan {
    segments: Vec<Segment>,
    start: Place,
}

impl Plan {
    /// Plans a program for a control of the given cycle, s.
    ///
    /// # Errors
    /// When the program cannot be sampled.
    pub fn new(scene: &Scene, run: &ProgramRun, dynamics: &Dynamics, cycle_s: f64) -> Result<Self, TipFault> {
        let path = Path::new(scene, run)?;
        let start = Place { position: path.position(0), velocity: Position::default(), line: 0, tool: path.tool(0) };
        let mut segments: Vec<Segment> =
            (1..=path.samples().len()).filter_map(|at| segment(&path, at, dynamics)).collect();
        limit(&mut segments, dynamics, cycle_s);
        time(&mut segments);
        Ok(Self { segments, start })
    }

    /// Duration of the program without a hold, s.
    pub fn duration_s(&self) -> f64 {
        self.segments.last().map_or(0.0, |last| last.begin + last.duration())
    }

    /// Where the program is at a time of its own clock, s.
    pub fn at(&self, time_s: f64) -> Place {
        let after = self.segments.partition_point(|segment| segment.begin <= time_s);
        let Some(segment) = after.checked_sub(1).and_then(|index| self.segments.get(index)) else { return self.start };
        let (way, speed) = segment.after(time_s - segment.begin);
        let at = |i: usize| segment.from.0[i] + segment.direction[i] * way;
        Place {
            position: Position(std::array::from_fn(at)),
            velocity: Position(segment.direction.map(|share| share * speed)),
            line: segment.line,
            tool: segment.tool,
        }
    }

    /// Largest speed of each axis between two times of the program's own clock, mm/s and radians/s.
    pub fn fastest(&self, from_s: f64, to_s: f64) -> [f64; 9] {
        let first = self.segments.partition_point(|segment| segment.begin + segment.duration() < from_s);
        let within = self.segments[first..].iter().take_while(|segment| segment.begin <= to_s);
        within.fold([0.0; 9], |fastest, segment| {
            std::array::from_fn(|i| f64::max(fastest[i], (segment.direction[i] * segment.speeds[1]).abs()))
        })
    }

    /// Time in which an override may rise from 0 to 1, s.
    fn resume_s(&self, dynamics: &Dynamics) -> f64 {
        let slowest = |segment: &Segment| {
            let share = |i: usize| segment.direction[i].abs() * segment.speeds[1] / (RESUME * dynamics.acceleration[i]);
            (0..9).filter(|&i| segment.direction[i] != 0.0).map(share).fold(0.0, f64::max)
        };
        self.segments.iter().map(slowest).fold(0.0, f64::max)
    }
}

/// The segment that leads to a sample; `None` when nothing moves and no time passes.
fn segment(path: &Path<'_>, at: usize, dynamics: &Dynamics) -> Option<Segment> {
    let (from, to) = (path.position(at - 1), path.position(at));
    let asked_s = path.time_s(at as f64) - path.time_s((at - 1) as f64);
    let scale = |i: usize| if (3..6).contains(&i) { RADIAN_MM } else { 1.0 };
    let length_mm = (0..9).map(|i| ((to.0[i] - from.0[i]) * scale(i)).powi(2)).sum::<f64>().sqrt();
    let moves = length_mm > SHORTEST_MM;
    if !moves && asked_s <= 0.0 {
        return None;
    }
    let direction = if moves { std::array::from_fn(|i| (to.0[i] - from.0[i]) / length_mm) } else { [0.0; 9] };
    let own_rate = |i: usize| TANGENTIAL * dynamics.acceleration[i] / direction[i].abs();
    let rate = (0..9).filter(|&i| direction[i] != 0.0).map(own_rate).fold(f64::INFINITY, f64::min);
    let feed = if asked_s > 0.0 { length_mm / asked_s } else { f64::MAX.sqrt() };
    Some(Segment {
        from,
        direction,
        length_mm: if moves { length_mm } else { 0.0 },
        feed,
        rate,
        speeds: [0.0; 3],
        durations: [0.0, if moves { 0.0 } else { asked_s }, 0.0],
        begin: 0.0,
        line: path.line_at(at as f64),
        tool: path.tool(at),
    })
}

/// Sets the speeds at both ends of every segment: those of the corners, lowered until every segment is long enough for the change.
fn limit(segments: &mut [Segment], dynamics: &Dynamics, cycle_s: f64) {
    let corner = |one: &Segment, other: &Segment| {
        let short = one.length_mm.min(other.length_mm);
        if short == 0.0 || one.tool != other.tool {
            return 0.0;
        }
        let change = |i: usize| (other.direction[i] - one.direction[i]).abs();
        let speed = |i: usize| {
            let gain = CORNER * dynamics.acceleration[i] / change(i);
            (gain * cycle_s).min((gain * short).sqrt())
        };
        (0..9).filter(|&i| change(i) > 0.0).map(speed).fold(one.feed.min(other.feed), f64::min)
    };
    let mut ends: Vec<f64> = segments.windows(2).map(|pair| corner(&pair[0], &pair[1])).collect();
    ends.insert(0, 0.0);
    ends.push(0.0);
    let reach = |from: f64, segment: &Segment| (from * from + 2.0 * segment.rate * segment.length_mm).sqrt();
    for i in 0..segments.len() {
        ends[i + 1] = ends[i + 1].min(reach(ends[i], &segments[i]));
    }
    for i in (0..segments.len()).rev() {
        ends[i] = ends[i].min(reach(ends[i + 1], &segments[i]));
    }
    for (segment, ends) in segments.iter_mut().zip(ends.windows(2)) {
        segment.speeds = [ends[0], 0.0, ends[1]];
    }
}

/// Sets the speeds in the middle, and all times.
fn time(segments: &mut [Segment]) {
    let mut begin = 0.0;
    for segment in segments {
        segment.begin = begin;
        if segment.length_mm > 0.0 {
            let [first, _, last] = segment.speeds;
            let highest = (0.5 * (first * first + last * last) + segment.rate * segment.length_mm).sqrt();
            let top = segment.feed.min(highest).max(first).max(last);
            segment.speeds[1] = top;
            let ramps = (top * top - 0.5 * (first * first + last * last)) / segment.rate;
            let keep = ((segment.length_mm - ramps) / top).max(0.0);
            segment.durations = [(top - first) / segment.rate, keep, (top - last) / segment.rate];
        }
        begin += segment.duration();
    }
}

/// Plays a plan in cycles, with an override that a hold takes to zero.
#[derive(Clone, Debug)]
pub struct Player {
    plan: Arc<Plan>,
    dynamics: Dynamics,
    cycle_s: f64,
    resume_s: f64,
    /// The program's own clock, s.
    time_s: f64,
    /// 1 forth, -1 back.
    direction: f64,
    /// From 0, standing, to 1.
    ratio: f64,
    /// Change of the override per second while it falls; set when a hold begins.
    fall: Option<f64>,
}

impl Player {
    /// A player that stands at the start of the program.
    pub fn new(plan: Plan, dynamics: Dynamics, cycle_s: f64) -> Self {
        let resume_s = plan.resume_s(&dynamics);
        Self { plan: Arc::new(plan), dynamics, cycle_s, resume_s, time_s: 0.0, direction: 1.0, ratio: 0.0, fall: None }
    }

    /// A cycle passes; the program goes on, or brakes.
    pub fn cycle(&mut self, permitted: bool) {
        if permitted {
            self.fall = None;
            self.ratio = (self.ratio + self.cycle_s / self.resume_s.max(self.cycle_s)).min(1.0);
            self.time_s += self.direction * self.cycle_s * self.ratio;
            return;
        }
        let velocity = self.plan.at(self.time_s).velocity;
        let brake_s = (0..9).map(|i| velocity.0[i].abs() / self.dynamics.deceleration[i]).fold(0.0, f64::max);
        let fall = *self.fall.get_or_insert(1.0 / brake_s.max(f64::MIN_POSITIVE));
        // Exact over the cycle: the override falls linearly and may end within it.
        let falling_s = (self.ratio / fall).min(self.cycle_s);
        self.time_s += self.direction * falling_s * (self.ratio - 0.5 * fall * falling_s);
        self.ratio = (self.ratio - fall * self.cycle_s).max(0.0);
    }

    /// The program's own clock when the machine stands, if it goes on for `deadline_s` and is then held.
    pub fn reach_s(&self, deadline_s: f64) -> f64 {
        let mut ahead = self.clone();
        (0..(deadline_s / self.cycle_s).ceil() as u32).for_each(|_| ahead.cycle(true));
        while !ahead.stands() {
            ahead.cycle(false);
        }
        ahead.time_s
    }

    /// Turns round: at its end the program goes back the way it came, and at its beginning forth again.
    pub const fn turn(&mut self) {
        self.direction = -self.direction;
        self.ratio = 0.0;
    }

    /// Where the machine is.
    pub fn place(&self) -> Place {
        let mut place = self.plan.at(self.time_s);
        place.velocity = Position(place.velocity.0.map(|speed| speed * self.ratio * self.direction));
        place
    }

    /// Whether the machine stands.
    pub fn stands(&self) -> bool {
        self.ratio == 0.0 || self.is_over()
    }

    /// Whether the program is over, or back at its beginning.
    pub fn is_over(&self) -> bool {
        if self.direction > 0.0 { self.time_s >= self.plan.duration_s() } else { self.time_s <= 0.0 }
    }

    /// The program's own clock, s.
    pub const fn time_s(&self) -> f64 {
        self.time_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use rs274::Axis;

    const CYCLE_S: f64 = 0.004;

    /// Largest acceleration of each axis over a whole run, by the second difference of positions.
    fn accelerations(places: &[Place]) -> [f64; 9] {
        std::array::from_fn(|i| {
            let change =
                |three: &[Place]| three[2].position.0[i] - 2.0 * three[1].position.0[i] + three[0].position.0[i];
            places.windows(3).map(|three| change(three).abs() / (CYCLE_S * CYCLE_S)).fold(0.0, f64::max)
        })
    }

    #[test]
    fn no_axis_exceeds_its_acceleration_with_corners_arcs_and_holds() {
        let scene = testing::mill();
        let dynamics = testing::dynamics(1500.0);
        let run = testing::run(&scene, "G0 X10 Y0\nG1 X40 F3000\nG1 Y30\nG3 X20 Y50 R20\nG1 X0 Y0 F6000\nG0 Z-20\n");
        let plan = Plan::new(&scene, &run, &dynamics, CYCLE_S).unwrap();
        for period in [u32::MAX, 97] {
            let mut player = Player::new(plan.clone(), dynamics, CYCLE_S);
            let mut places = vec![player.place(); 3];
            let mut cycles = 0;
            while !player.is_over() {
                player.cycle(cycles % period < 60 || period == u32::MAX);
                places.push(player.place());
                cycles += 1;
            }
            let found = accelerations(&places);
            // A hold adds its deceleration to the program's own.
            let allowed = if period == u32::MAX { 1500.0 } else { 3000.0 };
            assert!(found.iter().all(|&found| found <= allowed * (1.0 + 1e-9)), "{found:?}");
            assert!(found[0] > 150.0, "the test would pass if nothing moved: {found:?}");
            let end = places.last().unwrap().position;
            assert!((end[Axis::X] - 0.0).abs() < 1e-6 && end[Axis::Y].abs() < 1e-6, "{end:?}");
        }
    }

    #[test]
    fn a_hold_stands_within_the_time_and_way_that_the_judge_assumes() {
        let scene = testing::mill();
        let dynamics = testing::dynamics(1000.0);
        let run = testing::run(&scene, "G1 X100 F6000\n");
        let plan = Plan::new(&scene, &run, &dynamics, CYCLE_S).unwrap();
        let mut player = Player::new(plan, dynamics, CYCLE_S);
        while player.place().velocity[Axis::X] < 99.999 {
            player.cycle(true);
        }
        let from = player.place().position[Axis::X];
        let mut cycles = 0;
        while !player.stands() {
            player.cycle(false);
            cycles += 1;
        }
        // 100 mm/s at 1000 mm/s²: 0.1 s and 5 mm.
        assert!(cycles <= 26, "{cycles}");
        assert!((player.place().position[Axis::X] - from - 5.0).abs() < 0.01);
    }

    #[test]
    fn a_dwell_lasts_as_long_as_it_says() {
        let scene = testing::mill();
        let dynamics = testing::dynamics(1000.0);
        let without = Plan::new(&scene, &testing::run(&scene, "G1 X10 F600\nG1 X20\n"), &dynamics, CYCLE_S).unwrap();
        let with =
            Plan::new(&scene, &testing::run(&scene, "G1 X10 F600\nG4 P1.5\nG1 X20\n"), &dynamics, CYCLE_S).unwrap();
        // Braking to a stand and starting again takes at most 2 · 10 mm/s / 400 mm/s² longer.
        let longer = with.duration_s() - without.duration_s();
        assert!((1.5..1.56).contains(&longer), "{longer}");
    }
}
