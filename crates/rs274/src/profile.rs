//! The geometry of LinuxCNC's turning cycles: a profile in the plane of a cycle's frame, the path beside it, and the cuts down to it.
//!
//! The frame has u along the cuts, which go towards smaller u, and v across them, with the material at larger v.

use super::arc::Circle;
use super::error::Cause;
use super::lathe::MAX_PASSES;
use super::offset_curve::{Curve, Point, minus, norm, plus_scaled, turn};
use super::offsets::Values9;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Places that differ by less, mm, are one.
const EQUAL_MM: f64 = 1e-6;
/// How far an element may go back along the cuts, mm: LinuxCNC's limit.
const BACK_MM: f64 = 1e-3;
/// Corners that turn by less, radians, are none: arcs of profiles have ends of few digits.
const SMOOTH: f64 = 1e-2;
/// How far the ends of two elements may be moved to meet at such a corner, mm.
const MENDED_MM: f64 = 5e-2;

/// What joins an element to the next one.
#[derive(Clone, Copy, Debug)]
pub(super) enum Blend {
    /// An arc of this radius, mm.
    Fillet(f64),
    /// The chord of such an arc.
    Chamfer(f64),
}

/// One motion of a profile, in axis positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub to: Values9,
    pub circle: Option<Circle>,
    pub blend: Option<Blend>,
}

/// One motion of a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    Rapid(Point),
    Feed(Point),
    Along(Curve),
}

/// The profile with its fillets and chamfers.
pub(super) fn path_of(ways: impl Iterator<Item = (Curve, Option<Blend>)>) -> Result<Vec<Curve>, &'static str> {
    let mut path: Vec<Curve> = Vec::new();
    let mut pending = None;
    for (curve, blend) in ways {
        if norm(minus(curve.to(), curve.from())) < EQUAL_MM && matches!(curve, Curve::Line { .. }) {
            continue;
        }
        match (pending, path.pop()) {
            (Some(blend), Some(last)) => {
                path.extend(
                    blended(&last, &curve, blend).ok_or("a fillet or chamfer that its corner has no room for")?,
                );
            }
            (_, last) => path.extend(last.into_iter().chain([curve])),
        }
        pending = blend;
    }
    if path.is_empty() {
        return Err("a profile of one point");
    }
    if pending.is_some() {
        return Err("a fillet or chamfer at the profile's end");
    }
    let goes_back = |curve: &Curve| quarters(curve).iter().any(|part| part.to()[0] > part.from()[0] + BACK_MM);
    if path.iter().any(goes_back) {
        return Err("a profile that goes back along the cuts");
    }
    Ok(path)
}

/// Two elements with a fillet or a chamfer between them.
fn blended(last: &Curve, next: &Curve, blend: Blend) -> Option<[Curve; 3]> {
    let turned = turn(last.direction_at_end(), next.direction_at_start());
    let (Blend::Fillet(radius) | Blend::Chamfer(radius)) = blend;
    if turned.abs() < SMOOTH {
        return None;
    }
    let left = radius.copysign(turned);
    let (before, _) = shifted(last, left)?.cut_where_they_meet(&shifted(next, left)?)?;
    let centre = before.to();
    let (from, to) = (foot(last, centre), foot(next, centre));
    let between = match blend {
        Blend::Fillet(_) => Curve::Arc { centre, from, to, sweep: turn(minus(from, centre), minus(to, centre)) },
        Blend::Chamfer(_) => line(from, to),
    };
    Some([last.ending_at(from)?, between, next.starting_at(to)?])
}

fn line(from: Point, to: Point) -> Curve {
    let way = minus(to, from);
    Curve::Line { from, to, direction: way.map(|x| x / norm(way)) }
}

/// The curve shifted to its left; `None` where an arc has no radius left.
fn shifted(curve: &Curve, left: f64) -> Option<Curve> {
    let fits = match *curve {
        Curve::Line { .. } => true,
        Curve::Arc { centre, from, sweep, .. } => norm(minus(from, centre)) > left * sweep.signum() + EQUAL_MM,
    };
    fits.then(|| curve.shifted(left))
}

/// The point of the whole line or circle that is nearest to a point.
fn foot(curve: &Curve, point: Point) -> Point {
    match *curve {
        Curve::Line { from, direction, .. } => {
            let way = minus(point, from);
            plus_scaled(from, way[0] * direction[0] + way[1] * direction[1], direction)
        }
        Curve::Arc { centre, from, .. } => {
            let way = minus(point, centre);
            plus_scaled(centre, norm(minus(from, centre)) / norm(way), way)
        }
    }
}

/// The path at a distance from the profile, on the material's side.
pub(super) fn beside(path: &[Curve], distance: f64) -> Result<Vec<Curve>, &'static str> {
    if distance == 0.0 {
        return Ok(path.to_vec());
    }
    // The path goes towards smaller u; larger v is on its right.
    let left = -distance;
    let mut beside: Vec<Curve> = Vec::with_capacity(path.len());
    let mut before: Option<&Curve> = None;
    for curve in path {
        let next = shifted(curve, left).ok_or("an arc of the profile that is narrower than the distance to it")?;
        let turned = before.map_or(0.0, |before| turn(before.direction_at_end(), curve.direction_at_start()));
        match beside.pop() {
            Some(last) if turned.abs() > SMOOTH && turned * left > 0.0 => {
                let cut = last.cut_where_they_meet(&next);
                let (last, next) = cut.ok_or("an element of the profile that is too short for the distance to it")?;
                beside.extend([last, next]);
            }
            Some(last) if turned.abs() > SMOOTH => {
                let round = Curve::Arc { centre: curve.from(), from: last.to(), to: next.from(), sweep: turned };
                beside.extend([last, round, next]);
            }
            Some(last) => beside.extend(mended(last, next)),
            None => beside.push(next),
        }
        before = Some(curve);
    }
    Ok(beside)
}

/// Two elements at a smooth corner, made to meet as LinuxCNC does it: a line and an arc where the whole line meets the circle through the arc's
/// other end, else at the foot of its centre.
fn mended(mut last: Curve, mut next: Curve) -> [Curve; 2] {
    let touch = match (last, next) {
        (Curve::Arc { centre, from, .. }, Curve::Line { direction, .. }) => {
            plus_scaled(foot(&next, centre), half_chord(&next, centre, from), direction)
        }
        (Curve::Line { direction, .. }, Curve::Arc { centre, to, .. }) => {
            plus_scaled(foot(&last, centre), -half_chord(&last, centre, to), direction)
        }
        // Of two places where circles meet, the first one along the cuts.
        (Curve::Arc { from, .. }, Curve::Arc { to, .. }) => {
            let (last_circle, next_circle) = (with_ends(last, from, from), with_ends(next, to, to));
            let places = last_circle.meets(&next_circle).into_iter().flatten();
            places.max_by(|a, b| a[0].total_cmp(&b[0])).unwrap_or(last.to())
        }
        _ => last.to(),
    };
    let joint = if norm(minus(touch, last.to())) < MENDED_MM { touch } else { last.to() };
    if let Curve::Arc { centre, to, sweep, .. } = &mut last {
        *sweep += turn(minus(*to, *centre), minus(joint, *centre));
    }
    if let Curve::Arc { centre, from, sweep, .. } = &mut next {
        *sweep -= turn(minus(*from, *centre), minus(joint, *centre));
    }
    [with_ends(last, last.from(), joint), with_ends(next, joint, next.to())]
}

/// A curve with other ends.
fn with_ends(curve: Curve, from: Point, to: Point) -> Curve {
    match curve {
        Curve::Line { direction, .. } => Curve::Line { from, to, direction },
        Curve::Arc { centre, sweep, .. } => Curve::Arc { centre, from, to, sweep },
    }
}

/// Half of what a circle through a point cuts out of a whole line.
fn half_chord(line: &Curve, centre: Point, through: Point) -> f64 {
    let (radius, distance) = (norm(minus(through, centre)), norm(minus(foot(line, centre), centre)));
    (radius * radius - distance * distance).max(0.0).sqrt()
}

/// One pass along the path, from the cycle's start.
pub(super) fn finish(start: Point, path: &[Curve]) -> Vec<Step> {
    let begin = path.first().map(Curve::from);
    let there = [Step::Rapid(start)].into_iter().chain(begin.map(Step::Rapid));
    there.chain(path.iter().map(|&curve| Step::Along(curve))).collect()
}

/// An arc in parts that each rise or fall, and go one way.
fn quarters(curve: &Curve) -> Vec<Curve> {
    let Curve::Arc { centre, from, to, sweep } = *curve else { return vec![*curve] };
    let radius = norm(minus(from, centre));
    let begin = (from[1] - centre[1]).atan2(from[0] - centre[0]);
    let mut parts = Vec::new();
    let (mut at, mut done) = (from, 0.0);
    // Quarters of the circle, counted from its +u.
    let first = if sweep > 0.0 { (begin / FRAC_PI_2).floor() + 1.0 } else { (begin / FRAC_PI_2).ceil() - 1.0 };
    for step in 0..=(sweep.abs() / FRAC_PI_2) as i32 + 1 {
        let quarter = first + f64::from(step).copysign(sweep);
        let part = quarter * FRAC_PI_2 - begin;
        if part.abs() >= sweep.abs() - EQUAL_MM / radius {
            break;
        }
        if part.abs() > EQUAL_MM / radius {
            let direction = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][quarter.rem_euclid(4.0) as usize % 4];
            let point = plus_scaled(centre, radius, direction);
            parts.push(Curve::Arc { centre, from: at, to: point, sweep: part - done });
            (at, done) = (point, part);
        }
    }
    parts.push(Curve::Arc { centre, from: at, to, sweep: sweep - done });
    parts
}

/// Where a part reaches a height that lies between its ends.
fn at_height(part: &Curve, v: f64) -> Point {
    let (from, to) = (part.from(), part.to());
    match *part {
        _ if (from[1] - v).abs() <= EQUAL_MM / 2.0 => from,
        _ if (to[1] - v).abs() <= EQUAL_MM / 2.0 => to,
        Curve::Line { .. } => [from[0] + (v - from[1]) / (to[1] - from[1]) * (to[0] - from[0]), v],
        Curve::Arc { centre, .. } => {
            let radius = norm(minus(from, centre));
            let half = (radius * radius - (v - centre[1]).powi(2)).max(0.0).sqrt();
            [centre[0] + half.copysign(f64::midpoint(from[0], to[0]) - centre[0]), v]
        }
    }
}

/// A part before and behind one of its points.
fn split(part: &Curve, point: Point) -> (Curve, Curve) {
    match *part {
        Curve::Line { from, to, direction } => {
            (Curve::Line { from, to: point, direction }, Curve::Line { from: point, to, direction })
        }
        Curve::Arc { centre, from, to, sweep } => {
            let turned = turn(minus(from, centre), minus(point, centre)) * sweep.signum();
            let done = turned.clamp(0.0, sweep.abs()).copysign(sweep);
            (
                Curve::Arc { centre, from, to: point, sweep: done },
                Curve::Arc { centre, from: point, to, sweep: sweep - done },
            )
        }
    }
}

/// Whether a part falls.
fn falls(part: &Curve) -> bool {
    part.to()[1] < part.from()[1] - EQUAL_MM
}

/// The way of a roughing cycle.
struct Cuts {
    parts: Vec<Curve>,
    /// Depth of a cut, and how far the tool retreats behind it.
    increment: f64,
    retreat: f64,
    /// Height of the first cut, where pockets keep to the heights of the cuts before.
    grid: Option<f64>,
    passes: u32,
    steps: Vec<Step>,
}

/// The steps of a roughing cycle: cuts down to the path from the height of the start, if it `opens`, and along the path, into its pockets or over
/// them.
pub(super) fn rough(
    start: Point,
    path: &[Curve],
    increment: f64,
    retreat: f64,
    opens: bool,
    pockets: bool,
) -> Result<Vec<Step>, Cause> {
    let mut parts: Vec<Curve> = path.iter().flat_map(quarters).collect();
    let (Some(begin), Some(end)) = (parts.first().map(Curve::from), parts.last().map(Curve::to)) else {
        return Ok(Vec::new());
    };
    if end[1] < start[1] - EQUAL_MM {
        parts.push(line(end, [end[0], start[1]]));
    }
    let mut cuts = Cuts { parts, increment, retreat, grid: opens.then_some(start[1]), passes: 0, steps: Vec::new() };
    let height = start[1] - begin[1];
    if opens {
        let mut v = start[1];
        while v > begin[1] + EQUAL_MM {
            let from = [start[0] + (start[1] - v) / height * (begin[0] - start[0]), v];
            cuts.steps.push(Step::Rapid(from));
            cuts.cut(from, 0)?;
            cuts.steps.push(Step::Rapid(from));
            v = start[1] - f64::from(cuts.passes) * increment;
        }
    }
    cuts.steps.push(if height > EQUAL_MM { Step::Rapid(begin) } else { Step::Feed(begin) });
    cuts.follow(pockets)?;
    Ok(joined(&cuts.steps))
}

impl Cuts {
    /// Where a cut from the parts before `first` at a height ends: the part, and the place.
    fn meeting(&self, first: usize, v: f64) -> (usize, Point) {
        let found = (first..self.parts.len()).find(|&at| self.parts[at].to()[1] >= v - EQUAL_MM);
        match (found, self.parts.last()) {
            (Some(at), _) => (at, at_height(&self.parts[at], v)),
            (None, Some(last)) => (self.parts.len(), [last.to()[0], v]),
            (None, None) => (0, [0.0, v]),
        }
    }

    /// One cut to the path, and the retreat to above its begin.
    fn cut(&mut self, from: Point, first: usize) -> Result<(), Cause> {
        self.passes += 1;
        if self.passes > MAX_PASSES {
            return Err(Cause::Limit { limit: MAX_PASSES as usize, what: "cuts of one cycle" });
        }
        let (_, to) = self.meeting(first, from[1]);
        let back = self.retreat.min((from[0] - to[0]).abs() / 2.0);
        let above = from[1] + back;
        self.steps.extend([Step::Feed(to), Step::Rapid([to[0] + back, above]), Step::Rapid([from[0] - back, above])]);
        Ok(())
    }

    /// Along the path.
    fn follow(&mut self, pockets: bool) -> Result<(), Cause> {
        let mut at = 0;
        while let Some(&part) = self.parts.get(at) {
            if !falls(&part) {
                self.steps.push(Step::Along(part));
                at += 1;
            } else if pockets {
                at = self.pocket(at)?;
            } else {
                let (there, point) = self.meeting(at + 1, part.from()[1]);
                self.steps.push(Step::Feed(point));
                if let Some(part) = self.parts.get_mut(there) {
                    *part = split(part, point).1;
                }
                at = there;
            }
        }
        Ok(())
    }

    /// Down the falling parts from `at` on, with a cut at every height: the part behind the pocket's bottom.
    fn pocket(&mut self, mut at: usize) -> Result<usize, Cause> {
        let rim = self.parts[at].from()[1];
        let mut v = match self.grid {
            Some(top) => top - ((top - rim - EQUAL_MM) / self.increment).ceil().max(0.0) * self.increment,
            None => rim,
        };
        // A path that rises above the start has no cuts above it.
        v = v.min(rim);
        while let Some(&part) = self.parts.get(at).filter(|part| falls(part)) {
            if part.to()[1] >= v - EQUAL_MM {
                self.steps.push(Step::Along(part));
                at += 1;
                continue;
            }
            let (before, behind) = split(&part, at_height(&part, v));
            self.steps.push(Step::Along(before));
            self.parts[at] = behind;
            self.cut(behind.from(), at + 1)?;
            self.steps.push(Step::Feed(behind.from()));
            v -= self.increment;
        }
        Ok(at)
    }
}

/// The steps without those that go nowhere, arcs in one that were divided at their sides and bottoms.
fn joined(steps: &[Step]) -> Vec<Step> {
    let mut joined: Vec<Step> = Vec::with_capacity(steps.len());
    for &step in steps {
        let Step::Along(next) = step else {
            joined.push(step);
            continue;
        };
        match next {
            Curve::Line { from, to, .. } if norm(minus(to, from)) < EQUAL_MM => continue,
            Curve::Arc { centre, from, sweep, .. } if (sweep * norm(minus(from, centre))).abs() < EQUAL_MM => continue,
            _ => {}
        }
        let Curve::Arc { centre, from: joint, to, sweep } = next else {
            joined.push(step);
            continue;
        };
        let is_top = joint[1] > centre[1] && (joint[0] - centre[0]).abs() < EQUAL_MM;
        match joined.last_mut() {
            Some(Step::Along(Curve::Arc { centre: c, to: end, sweep: total, .. }))
                if !is_top && *c == centre && (*total + sweep).abs() < TAU && *total * sweep > 0.0 =>
            {
                *end = to;
                *total += sweep;
            }
            _ => joined.push(step),
        }
    }
    joined
}
