//! Links, the path, and how far parts can be from their places at the middle of an interval of it.

use crate::interval::{I, ONE, Pose, V, ZERO, cross, dot, minus, norm, plus, times};
use crate::read::ROTARY;
use crate::{LINK, Part, Work};
use std::array::from_fn;

/// A joint; directions are of length 1.
pub struct Joint {
    pub axis: usize,
    /// A point on the line of one that turns.
    pub turns: Option<V>,
    pub direction: V,
    /// Radians per mm of an axis of mm.
    pub gain: I,
}

/// A link; link 0 is the world. Parents come first.
pub struct Link {
    pub name: String,
    pub parent: usize,
    pub pose: Pose,
    pub joint: Option<Joint>,
}

/// Tool-centre-point control: the links of tool and workpiece; on the tool's link the gauge point and the direction from it to the tip.
pub struct Tip {
    pub tool: usize,
    pub work: usize,
    pub gauge: V,
    pub direction: V,
}

/// A move, or a leg of one; axes in the order X Y Z A B C U V W, mm and radians.
pub struct Step {
    pub line: u32,
    pub tool: u32,
    pub is_point: bool,
    /// Whether the cutter may be in the workpiece: in a feed, or while it stands still after one.
    pub cuts: bool,
    /// Plane; centre and sweep.
    pub arc: Option<([usize; 2], [f64; 3])>,
    pub from: [f64; 9],
    pub to: [f64; 9],
    pub tip: Option<f64>,
}

type Axes = [I; 9];

/// All positions that the axes may have: `mid`, plus `seg` times one number from -1 to 1, plus up to `wide` for each axis, plus an ellipsoid with the half axes `ball`.
#[derive(Default)]
struct Region {
    mid: Axes,
    seg: Axes,
    wide: Axes,
    ball: Axes,
    /// World from each link at the middle.
    poses: Vec<Pose>,
    tip: Option<TipWay>,
}

/// The tip in the frame of the workpiece's link: its place at the middle, its way, and the radius of a ball around both.
struct TipWay {
    place: V,
    way: V,
    round: I,
}

/// Motions of a pair: the pose of `b` in `a` at the middle; and displacements from there of points of `b` less those of `a`, in the axes of `a` at the middle: each way
/// times a number of its own from -1 to 1, plus an ellipsoid, plus a ball.
pub struct Sweep {
    pub a_from_b: Pose,
    pub ways: Vec<V>,
    pub ellipsoid: Vec<V>,
    pub radius: I,
}

#[derive(Default)]
pub struct Machine {
    pub links: Vec<Link>,
    pub tip: Option<Tip>,
    pub steps: Vec<Step>,
    /// All positions of the axes on each step.
    boxes: Vec<Option<Axes>>,
}

/// Farthest that parts may be from their places midway between the end of a step and the beginning of the next one, mm: rounding of arcs and of the tip.
/// Four times that is within [`crate::MARGIN_MM`], so two parts that are parted at both do not meet between them.
const JUMP_MM: f64 = 1e-7;

impl Sweep {
    /// Ways and ellipsoid together, each vector measured by `length`.
    fn reach(&self, length: impl Fn(&V) -> I) -> I {
        let ways = self.ways.iter().fold(ZERO, |sum, way| sum + length(way));
        ways + self.ellipsoid.iter().fold(ZERO, |sum, half| sum + length(half).squared()).sqrt()
    }

    /// Greatest of these displacements against `n`, times the length of `n`, without the ball.
    pub fn towards(&self, n: &V) -> I {
        self.reach(|v| I::of(dot(n, v).most()))
    }

    /// Greatest length of these displacements: the motion bound.
    pub fn bound(&self) -> I {
        self.reach(norm) + self.radius
    }
}

impl Region {
    fn half(&self, axis: usize) -> I {
        I::of(self.seg[axis].most()) + self.wide[axis] + self.ball[axis]
    }
}

impl Machine {
    /// Finds the range of every step, and refuses a path on which a part jumps.
    pub fn finish(&mut self, parts: &[Part], work: &Work) -> Result<(), String> {
        for (index, pair) in (1..).zip(self.steps.windows(2)) {
            let (one, next) = (&pair[0], &pair[1]);
            if one.to == next.from && one.tip == next.tip && one.arc.is_none() {
                continue;
            }
            // An interval whose end has no place is not bounded, so nothing is proved there.
            let ends = self.within(one, [1.0; 2], work).zip(self.within(next, [0.0; 2], work));
            let Some((end, begin)) = ends else { continue };
            let jump = self.around(&from_fn(|axis| end.mid[axis].hull(begin.mid[axis])), work);
            let stays = |part: &Part| {
                let (chain, pose) = (self.chain(part.link, 0), jump.poses[part.link].after(&part.pose));
                let [.., reach] = self.turned(&chain, &pose.point(&part.mesh.centre), part.mesh.radius, &jump);
                work.take(part.link + 5 * chain.len()) && (reach - part.mesh.radius).hi <= JUMP_MM
            };
            if !parts.iter().all(stays) {
                return Err(format!("the path jumps at move {index}, of line {}", next.line));
            }
        }
        let range = |region: Region| from_fn(|axis| region.mid[axis] + region.half(axis).both_ways());
        self.boxes = self.steps.iter().map(|step| self.within(step, [0.0, 1.0], work).map(range)).collect();
        Ok(())
    }

    /// The joints between a link and the nearest link that carries it and the other one, from the link on.
    pub fn chain(&self, mut link: usize, mut other: usize) -> Vec<usize> {
        let mut chain = Vec::new();
        // Parents have smaller numbers.
        while link != other {
            if link > other {
                chain.extend(self.links[link].joint.is_some().then_some(link));
                link = self.links[link].parent;
            } else {
                other = self.links[other].parent;
            }
        }
        chain
    }

    /// Whether this axis is A, B or C, or drives a rotary joint.
    fn turns(&self, axis: usize) -> bool {
        let is_turned = |joint: &Joint| joint.axis == axis && joint.turns.is_some();
        ROTARY.contains(&axis) || self.links.iter().filter_map(|link| link.joint.as_ref()).any(is_turned)
    }

    /// Where every link is in the world.
    fn poses(&self, axes: &Axes) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(self.links.len());
        for Link { parent, pose, joint, .. } in &self.links {
            let mut placed = poses.get(*parent).map_or(*pose, |parent| parent.after(pose));
            if let Some(Joint { axis, turns, direction, gain }) = joint {
                let value = axes[*axis] * *gain;
                placed = match turns {
                    None => Pose { t: placed.point(&times(direction, value)), ..placed },
                    Some(point) => {
                        let turn = Pose::about(direction, value);
                        placed.after(&Pose { t: minus(point, &turn.turn(point)), ..turn })
                    }
                };
            }
            poses.push(placed);
        }
        poses
    }

    /// Where the axes may be between two fractions of a step.
    fn within(&self, step: &Step, [from, to]: [f64; 2], work: &Work) -> Option<Region> {
        // To follow the tip the links are placed three times.
        work.take(LINK * self.links.len() * if step.tip.is_some() { 3 } else { 1 }).then_some(())?;
        let half = I::of(0.5);
        let (middle, part) = ((I::of(from) + I::of(to)) * half, (I::of(to) - I::of(from)) * half);
        let change: Axes = from_fn(|i| I::of(step.to[i]) - I::of(step.from[i]));
        let mid = from_fn(|i| I::of(step.from[i]) + change[i] * middle);
        let mut region = Region { mid, seg: change.map(|change| change * part), ..Region::default() };
        if let Some((plane, [u, v, sweep])) = step.arc {
            let centre = [u, v].map(I::of);
            let offset = |at: &[f64; 9]| [0, 1].map(|k| I::of(at[plane[k]]) - centre[k]);
            let [[x, y], [u, v]] = [&step.from, &step.to].map(offset);
            let [first, last] = [norm(&[x, y, ZERO]), norm(&[u, v, ZERO])];
            if first.lo <= 0.0 {
                return None;
            }
            let (scale, sweep) = (ONE + (last.over(first) - ONE) * middle, I::of(sweep));
            let [sin, cos] = (sweep * middle).sin_cos();
            let turned = [cos * x - sin * y, sin * x + cos * y];
            let radius = I::of(first.hi.max(last.hi));
            for (k, axis) in plane.into_iter().enumerate() {
                region.mid[axis] = centre[k] + scale * turned[k];
                region.seg[axis] = ZERO;
                region.ball[axis] = part * (radius * I::of(sweep.most()) + I::of((last - first).most()));
            }
        }
        if let Some(length) = step.tip {
            return self.follow_tip(region, length, from == to);
        }
        region.poses = self.poses(&region.mid);
        Some(region)
    }

    /// The positions of the axes that follow from the positions of the tip, at a single place or over an interval.
    fn follow_tip(&self, mut region: Region, length: f64, is_place: bool) -> Option<Region> {
        let Tip { tool, work, gauge, direction } = self.tip.as_ref()?;
        let mut chain = self.chain(*tool, *work);
        chain.extend(self.chain(*work, *tool).iter().rev());
        // The second axes stand, so that the first three reach the tip, and where the rotary ones are at 0 all others slide. No arc turns a rotary one.
        let is_ruled_out = |axis: usize| self.turns(axis) || axis > 5 && region.half(axis).hi > 1e-12;
        // Each of the three directions is that of one slide, and turns with it: without one of the three there is no volume below.
        let slides = chain.iter().filter_map(|&link| self.links[link].joint.as_ref()).filter(|joint| joint.axis < 3);
        if (0..3).chain(6..9).any(is_ruled_out) || region.ball[ROTARY] != [ZERO; 3] || slides.count() > 3 {
            return None;
        }
        let point = plus(gauge, &times(direction, I::of(length)));
        let seen = |poses: &[Pose]| poses[*work].inverse().point(&poses[*tool].point(&point));
        let mut flat = region.mid;
        flat[ROTARY].fill(ZERO);
        flat[2] = flat[2] + I::of(length);
        let flat = self.poses(&flat);
        let (place, at_zero) = (seen(&flat), self.slides([*work, *tool], &flat));
        let way = (0..3).fold([ZERO; 3], |sum, i| plus(&sum, &times(&at_zero[i], region.seg[i])));
        let ball = I::of(region.ball.iter().fold(0.0, |most, ball| ball.hi.max(most)));
        let round = (ONE + defect(&at_zero)).sqrt() * ball;

        region.mid[..3].fill(ZERO);
        let base = self.poses(&region.mid);
        let slides = self.slides([*work, *tool], &base);
        let rest = minus(&place, &seen(&base));
        // Cramer's rule.
        let [x, y, z] = [&slides[0], &slides[1], &slides[2]];
        let volume = dot(x, &cross(y, z));
        let solved = [dot(&rest, &cross(y, z)), dot(&rest, &cross(z, x)), dot(&rest, &cross(x, y))];
        for (i, solved) in solved.into_iter().enumerate() {
            (region.mid[i], region.seg[i], region.ball[i]) = (solved.over(volume), ZERO, ZERO);
        }
        region.poses = self.poses(&region.mid);
        // The slides are at rest in this region.
        let [turned, angle, _] = self.turned(&chain, &region.poses[*tool].point(&point), ZERO, &region);
        let off = defect(&slides);
        let least = (ONE - off).sqrt() - I::of(3.0).sqrt() * angle;
        // Where the singular values are above 0.2, the volume is above 0.2³: so each end of an interval that is bounded has a place.
        let is_flat = volume.lo <= 0.008 && volume.hi >= -0.008;
        if is_flat || !is_place && (off.hi >= 1.0 || least.lo <= 0.2) {
            return None;
        }
        region.ball[..3].fill(if is_place { ZERO } else { (norm(&way) + round + turned).over(I::of(least.lo)) });
        region.tip = Some(TipWay { place, way, round });
        Some(region)
    }

    /// Where `b` goes in the frame of link `a` for each mm of an axis that slides.
    fn slides(&self, [a, b]: [usize; 2], poses: &[Pose]) -> [V; 9] {
        let mut slides = [[ZERO; 3]; 9];
        for (chain, sign) in [(self.chain(a, b), -ONE), (self.chain(b, a), ONE)] {
            for link in chain {
                let Some(Joint { axis, turns: None, direction, .. }) = &self.links[link].joint else { continue };
                let seen = poses[a].turn_back(&poses[link].turn(direction));
                slides[*axis] = plus(&slides[*axis], &times(&seen, sign));
            }
        }
        slides
    }

    /// Greatest distance by which the turning joints of a chain move a point of a ball in the world, and the sum of their angles; the radius, and the way by all joints.
    fn turned(&self, chain: &[usize], centre: &V, radius: I, region: &Region) -> [I; 3] {
        let (mut turned, mut angle, mut reach) = (ZERO, ZERO, radius);
        for &link in chain {
            let Some(Joint { axis, turns, direction, gain }) = &self.links[link].joint else { continue };
            let (mut way, pose) = (region.half(*axis) * *gain, &region.poses[link]);
            if let Some(point) = turns {
                angle = angle + way;
                way = way * (norm(&cross(&pose.turn(direction), &minus(centre, &pose.point(point)))) + reach);
                turned = turned + way;
            }
            reach = reach + way;
        }
        [turned, angle, reach]
    }

    /// All positions of the axes within these ranges.
    fn around(&self, all: &Axes, work: &Work) -> Region {
        work.take(LINK * self.links.len());
        let mid = all.map(|range| I::of(0.5 * (range.lo + range.hi)));
        let wide = from_fn(|i| I::of((all[i] - mid[i]).most()));
        Region { wide, poses: self.poses(&mid), ..Region::default() }
    }

    /// All relative motions of two parts between two fractions of a step, or over whole steps from it on; `None` where nothing bounds them.
    pub fn sweep(&self, step: usize, [from, to]: [f64; 2], pair: [&Part; 2], work: &Work) -> Option<Sweep> {
        if to <= 1.0 {
            return Some(self.swept(&self.within(&self.steps[step], [from, to], work)?, pair));
        }
        let boxes = self.boxes[step..step + to as usize].iter().copied();
        let all = boxes.reduce(|all, one| all.zip(one).map(|(all, one)| from_fn(|i| all[i].hull(one[i]))))??;
        Some(self.swept(&self.around(&all, work), pair))
    }

    fn swept(&self, region: &Region, [a, b]: [&Part; 2]) -> Sweep {
        let pose = |part: &Part| region.poses[part.link].after(&part.pose);
        let (mut radius, mut turn) = (ZERO, ZERO);
        for (part, other) in [(a, b), (b, a)] {
            let chain = self.chain(part.link, other.link);
            let [turned, angle, _] =
                self.turned(&chain, &pose(part).point(&part.mesh.centre), part.mesh.radius, region);
            (radius, turn) = (radius + turned, turn + angle);
        }
        let a_from_b = pose(a).inverse().after(&pose(b));
        let (links, mut ellipsoid) = ([a.link, b.link], Vec::new());
        if let (Some(TipWay { place, way, round }), Some(tip)) = (&region.tip, &self.tip)
            && links == [tip.work, tip.tool]
        {
            // The tip's way is known, and the tool turns about it.
            let seen = a.pose.point(&a_from_b.point(&b.mesh.centre));
            let radius = *round + turn * (norm(&minus(&seen, place)) + b.mesh.radius);
            return Sweep { a_from_b, ways: vec![a.pose.turn_back(way)], ellipsoid, radius };
        }
        let slides = self.slides(links, &region.poses).map(|slide| a.pose.turn_back(&slide));
        let mut ways = vec![[ZERO; 3]];
        for (i, slide) in slides.iter().enumerate() {
            ways[0] = plus(&ways[0], &times(slide, region.seg[i]));
            ways.extend((region.wide[i] != ZERO).then(|| times(slide, region.wide[i])));
            ellipsoid.extend((region.ball[i] != ZERO).then(|| times(slide, region.ball[i])));
        }
        Sweep { a_from_b, ways, ellipsoid, radius }
    }
}

/// Frobenius norm of MᵀM - 1 for the first three columns M: 0 where they are orthogonal and of length 1.
fn defect(slides: &[V; 9]) -> I {
    let entry = |k: usize| dot(&slides[k / 3], &slides[k % 3]) - Pose::IDENTITY.r[k / 3][k % 3];
    (0..9).fold(ZERO, |sum, k| sum + entry(k).squared()).sqrt()
}
