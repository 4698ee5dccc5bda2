//! Links, the path, and how far parts can be from their places at the middle of an interval of it.

use crate::Part;
use crate::interval::{I, ONE, Pose, V, ZERO, cross, dot, minus, norm, plus, times};
use crate::read::ROTARY;

/// A joint; directions are of length 1.
#[derive(Clone, Debug)]
pub struct Joint {
    pub axis: usize,
    /// A point on the line of one that turns.
    pub turns: Option<V>,
    pub direction: V,
    /// Radians per mm of an axis of mm.
    pub gain: I,
}

#[derive(Clone, Debug)]
pub struct Link {
    pub name: String,
    pub parent: Option<usize>,
    pub pose: Pose,
    pub joint: Option<Joint>,
}

/// Tool-centre-point control: the links of tool and workpiece; on the tool's link the gauge point and the direction from it to the tip.
#[derive(Debug)]
pub struct Tip {
    pub tool: Option<usize>,
    pub work: Option<usize>,
    pub gauge: V,
    pub direction: V,
}

/// A move, or a leg of one; axes in the order X Y Z A B C U V W, mm and radians.
#[derive(Clone, Debug)]
pub struct Step {
    pub line: u32,
    pub tool: u32,
    pub is_point: bool,
    pub is_rapid: bool,
    /// Plane, centre and sweep.
    pub arc: Option<([usize; 2], [f64; 2], f64)>,
    pub from: [f64; 9],
    pub to: [f64; 9],
    pub tip: Option<f64>,
}

impl Step {
    fn begin(&self) -> &[f64; 9] {
        if self.is_point { &self.to } else { &self.from }
    }
}

/// All positions that the axes may have: `mid`, plus `seg` times one number from -1 to 1, plus up to `wide` for each axis, plus a ball over the axes of `group`.
#[derive(Clone)]
struct Region {
    mid: [I; 9],
    seg: [I; 9],
    wide: [I; 9],
    ball: I,
    group: Vec<usize>,
    tip: Option<TipWay>,
}

/// The tip in the frame of the workpiece's link: its place at the middle, its way, and the radius of a ball around both; where the links are at the middle.
#[derive(Clone)]
struct TipWay {
    place: V,
    way: V,
    round: I,
    poses: Poses,
}

/// All motions of `b` in the frame of `a`: a pose, plus each way times a number of its own from -1 to 1, plus an ellipsoid, plus a ball.
pub struct Sweep {
    pub a_from_b: Pose,
    ways: Vec<V>,
    group: Vec<V>,
    ball: I,
    pub radius: I,
}

#[derive(Debug, Default)]
pub struct Machine {
    pub links: Vec<Link>,
    pub tip: Option<Tip>,
    pub steps: Vec<Step>,
    /// Lowest and highest positions of the axes on each step.
    boxes: Vec<Option<[[f64; 2]; 9]>>,
    /// With all axes at 0: the link of the workpiece from that of the tool, and the ways of the latter in the former for each mm of an axis.
    zero: Option<(Pose, [V; 9])>,
}

/// Greatest distance between the end of a step and the beginning of the next one: rounding of arcs and of the tip. Where an axis of mm turns joints,
/// the smaller one, which is then of a degree.
const JUMP_MM: f64 = 1e-7;
const JUMP_RAD: f64 = 1e-10;

/// A ball on a link.
type Ball = (Option<usize>, V, I);

/// World from each link.
#[derive(Clone)]
struct Poses(Vec<Pose>);

impl Poses {
    fn of(&self, link: Option<usize>) -> Pose {
        link.map_or(Pose::IDENTITY, |link| self.0[link])
    }
}

impl Sweep {
    /// Ways and ellipsoid together, each vector measured by `length`.
    fn reach(&self, length: impl Fn(&V) -> I) -> I {
        let ways = self.ways.iter().fold(ZERO, |sum, way| sum + length(way));
        let group = self.group.iter().fold(ZERO, |sum, e| sum + length(e).squared()).sqrt();
        ways + self.ball * group
    }

    /// Greatest motion of any point against `n`, times the length of `n`, without the ball.
    pub fn towards(&self, n: &V) -> I {
        self.reach(|v| I::of(dot(n, v).most()))
    }

    /// The farthest that any point goes from its place at the middle.
    pub fn bound(&self) -> I {
        self.reach(norm) + self.radius
    }
}

impl Region {
    fn half(&self, axis: usize) -> I {
        let ball = if self.group.contains(&axis) { self.ball } else { ZERO };
        I::of(self.seg[axis].most()) + self.wide[axis] + ball
    }
}

impl Machine {
    /// Finds the range of every step, and refuses a path that jumps.
    pub fn finish(&mut self) -> Result<(), String> {
        self.zero = self.tip.as_ref().map(|tip| {
            let poses = self.poses(&[ZERO; 9]);
            (poses.of(tip.work).inverse().after(&poses.of(tip.tool)), self.slides([tip.work, tip.tool], &poses))
        });
        let range = |step| {
            let region = self.within(step, [0.0, 1.0])?;
            let side = |axis: usize| region.mid[axis] + region.half(axis).both_ways();
            Some([0, 1, 2, 3, 4, 5, 6, 7, 8].map(|axis| [side(axis).lo, side(axis).hi]))
        };
        // No arc before, the same tip and the same numbers: both steps have the same place there.
        let is_joined = |step: usize| {
            let [one, next] = [&self.steps[step - 1], &self.steps[step]];
            one.to == *next.begin() && one.tip == next.tip && one.arc.is_none()
        };
        let jumps = |step: usize| {
            let [end, begin] =
                [self.within(step - 1, [1.0; 2])?, self.within(step, [0.0; 2])?].map(|region| region.mid);
            let is_far = |i: usize| (end[i] - begin[i]).most() > if self.turns(i) { JUMP_RAD } else { JUMP_MM };
            (0..9).any(is_far).then_some(step)
        };
        if let Some(step) = (1..self.steps.len()).filter(|&step| !is_joined(step)).find_map(jumps) {
            return Err(format!("the path jumps at move {step}, of line {}", self.steps[step].line));
        }
        self.boxes = (0..self.steps.len()).map(range).collect();
        Ok(())
    }

    /// Whether the cutter may be in the workpiece: it feeds, or it stands where the move before ended.
    pub fn cuts(&self, step: usize) -> bool {
        let Step { is_point, is_rapid, tool, .. } = self.steps[step];
        !is_rapid && (!is_point || step > 0 && self.steps[step - 1].tool == tool)
    }

    /// The link, then its parent, and so on to the world.
    fn up(&self, link: Option<usize>) -> impl Iterator<Item = usize> {
        std::iter::successors(link, |&link| self.links[link].parent)
    }

    fn shared(&self, [a, b]: [Option<usize>; 2]) -> Option<usize> {
        self.up(a).find(|&link| self.up(b).any(|other| other == link))
    }

    /// The joints between each of two links and the nearest link that carries both.
    pub fn between(&self, links: [Option<usize>; 2]) -> [Vec<usize>; 2] {
        let shared = self.shared(links);
        let is_moved = |link: &usize| self.links[*link].joint.is_some();
        links.map(|link| self.up(link).take_while(|&link| Some(link) != shared).filter(is_moved).collect())
    }

    /// Whether a position of this axis is an angle for any joint.
    fn turns(&self, axis: usize) -> bool {
        ROTARY.contains(&axis)
            || self
                .links
                .iter()
                .filter_map(|link| link.joint.as_ref())
                .any(|joint| joint.axis == axis && joint.turns.is_some())
    }

    /// Where every link is in the world.
    fn poses(&self, axes: &[I; 9]) -> Poses {
        let mut poses = Poses(Vec::with_capacity(self.links.len()));
        for Link { parent, pose, joint, .. } in &self.links {
            let placed = parent.map_or(*pose, |parent| poses.0[parent].after(pose));
            let Some(Joint { axis, turns, direction, gain }) = joint else {
                poses.0.push(placed);
                continue;
            };
            let value = axes[*axis] * *gain;
            poses.0.push(match turns {
                None => Pose { t: placed.point(&times(direction, value)), ..placed },
                Some(point) => {
                    let turn = Pose::about(direction, value);
                    placed.after(&Pose { t: minus(point, &turn.turn(point)), ..turn })
                }
            });
        }
        poses
    }

    /// Where every link is after slides along X, Y and Z from 0.
    fn slid(&self, Poses(mut poses): Poses, axes: &[I; 9]) -> Poses {
        let mut shifts = vec![[ZERO; 3]; poses.len()];
        for (index, Link { parent, joint, .. }) in self.links.iter().enumerate() {
            shifts[index] = parent.map_or([ZERO; 3], |parent| shifts[parent]);
            if let Some(Joint { axis: axis @ 0..3, direction, .. }) = joint {
                shifts[index] = plus(&shifts[index], &times(&poses[index].turn(direction), axes[*axis]));
            }
            poses[index].t = plus(&poses[index].t, &shifts[index]);
        }
        Poses(poses)
    }

    /// Where the axes may be between two fractions of a step.
    fn within(&self, index: usize, [from, to]: [f64; 2]) -> Option<Region> {
        let step = &self.steps[index];
        let half = |x: I| I { lo: 0.5 * x.lo, hi: 0.5 * x.hi };
        let (middle, part) = (half(I::of(from) + I::of(to)), half(I::of(to) - I::of(from)));
        let begin = step.begin();
        let change: [I; 9] = std::array::from_fn(|i| I::of(step.to[i]) - I::of(begin[i]));
        let mid = std::array::from_fn(|i| I::of(begin[i]) + change[i] * middle);
        let seg = change.map(|change| change * part);
        let mut region = Region { mid, seg, wide: [ZERO; 9], ball: ZERO, group: Vec::new(), tip: None };
        if let Some((plane, centre, sweep)) = step.arc {
            let offset = |at: &[f64; 9]| [0, 1].map(|k| I::of(at[plane[k]]) - I::of(centre[k]));
            let [[x, y], [u, v]] = [offset(&step.from), offset(&step.to)];
            let [first, last] = [norm(&[x, y, ZERO]), norm(&[u, v, ZERO])];
            if first.lo <= 0.0 {
                return None;
            }
            let (scale, sweep) = (ONE + (last.over(first) - ONE) * middle, I::of(sweep));
            let [sin, cos] = (sweep * middle).sin_cos();
            region.mid[plane[0]] = I::of(centre[0]) + scale * (cos * x - sin * y);
            region.mid[plane[1]] = I::of(centre[1]) + scale * (sin * x + cos * y);
            plane.iter().for_each(|&axis| region.seg[axis] = ZERO);
            let radius = I::of(first.hi.max(last.hi));
            region.ball = part * (radius * I::of(sweep.most()) + I::of((last - first).most()));
            region.group = plane.to_vec();
        }
        step.tip.map_or(Some(region.clone()), |length| self.follow_tip(&region, length))
    }

    /// The positions of the axes that follow from the positions of the tip.
    fn follow_tip(&self, tip: &Region, length: f64) -> Option<Region> {
        let Tip { tool, work, gauge, direction } = self.tip.as_ref()?;
        let (work_from_tool, at_zero) = self.zero.as_ref()?;
        // The second axes stand, so that the first three reach the tip, and where the rotary ones are at 0 all others slide. No arc turns a rotary one.
        let is_ruled_out = |axis: usize| self.turns(axis) || axis > 5 && tip.half(axis).hi > 1e-12;
        if (0..3).chain(6..9).any(is_ruled_out) || tip.group.iter().any(|axis| ROTARY.contains(axis)) {
            return None;
        }
        let point = plus(gauge, &times(direction, I::of(length)));
        let links = [*work, *tool];
        let mut zero = tip.mid;
        zero[3..6].fill(ZERO);
        zero[2] = zero[2] + I::of(length);
        let wanted = (0..9).fold(work_from_tool.point(&point), |sum, i| plus(&sum, &times(&at_zero[i], zero[i])));
        let by = |m: &[V; 9], x: &V| plus(&plus(&times(&m[0], x[0]), &times(&m[1], x[1])), &times(&m[2], x[2]));
        let seg = [tip.seg[0], tip.seg[1], tip.seg[2]];
        let stretch = (ONE + defect(at_zero)).sqrt();
        let (way, ball) = (by(at_zero, &seg), stretch * tip.ball);

        let mut mid = tip.mid;
        mid[..3].fill(ZERO);
        let base = self.poses(&mid);
        let slides = self.slides(links, &base);
        let rest = minus(&wanted, &base.of(*work).inverse().point(&base.of(*tool).point(&point)));
        // Cramer's rule.
        let [x, y, z] = [&slides[0], &slides[1], &slides[2]];
        let volume = dot(x, &cross(y, z));
        let solved = [dot(&rest, &cross(y, z)), dot(&rest, &cross(z, x)), dot(&rest, &cross(x, y))];
        (0..3).for_each(|i| mid[i] = solved[i].over(volume));
        if !mid.iter().all(|x| x.lo.is_finite() && x.hi.is_finite()) {
            return None;
        }
        let mut region = Region { mid, group: vec![0, 1, 2], ball: ZERO, ..tip.clone() };
        region.seg[..3].fill(ZERO);
        let poses = self.slid(base, &mid);
        let [of_work, of_tool] = self.between(links);
        let chain: Vec<usize> = of_tool.into_iter().chain(of_work.into_iter().rev()).collect();
        // Each of the three directions is that of one slide, and turns with it.
        let slides_along = |axis| {
            chain
                .iter()
                .filter(|&&link| self.links[link].joint.as_ref().is_some_and(|joint| joint.axis == axis))
                .count()
        };
        if (0..3).any(|axis| slides_along(axis) > 1) {
            return None;
        }
        // The slides are at rest in this region.
        let turned = self.turned(&chain, &(*tool, point, ZERO), &region, &poses);
        let off = defect(&slides);
        let least = (ONE - off).sqrt() - I::of(3.0).sqrt() * self.turn_of(&chain, &region);
        if off.hi >= 1.0 || least.lo <= 0.2 {
            return None;
        }
        region.ball = (stretch * norm(&seg) + ball + turned).over(I::of(least.lo));
        region.tip = Some(TipWay { place: wanted, way, round: ball, poses });
        Some(region)
    }

    /// Where `b` goes in the frame of link `a` for each mm of an axis that slides.
    fn slides(&self, links: [Option<usize>; 2], poses: &Poses) -> [V; 9] {
        let mut slides = [[ZERO; 3]; 9];
        let world_from_a = poses.of(links[0]);
        for (chain, sign) in self.between(links).iter().zip([-ONE, ONE]) {
            for &link in chain {
                let Some(Joint { axis, turns: None, direction, .. }) = &self.links[link].joint else { continue };
                let seen = world_from_a.turn_back(&poses.0[link].turn(direction));
                slides[*axis] = plus(&slides[*axis], &times(&seen, sign));
            }
        }
        slides
    }

    /// Greatest distance by which a turning joint moves a point within `reach` of `centre`; `None` for a joint that slides.
    fn turn(&self, link: usize, region: &Region, poses: &Poses, centre: &V, reach: I) -> Option<I> {
        let Joint { axis, turns, direction, gain } = self.links[link].joint.as_ref()?;
        let pose = &poses.0[link];
        let arm = norm(&cross(&pose.turn(direction), &minus(centre, &pose.point(turns.as_ref()?))));
        Some(region.half(*axis) * *gain * (arm + reach))
    }

    /// Sum of the angles by which the joints turn, radians.
    fn turn_of(&self, chain: &[usize], region: &Region) -> I {
        let joints = chain.iter().filter_map(|&link| self.links[link].joint.as_ref());
        joints.filter(|joint| joint.turns.is_some()).fold(ZERO, |sum, joint| sum + region.half(joint.axis) * joint.gain)
    }

    /// Greatest distance by which the turning joints move a point of a ball, in the frame of the link that carries both parts.
    fn turned(&self, chain: &[usize], ball: &Ball, region: &Region, poses: &Poses) -> I {
        let centre = poses.of(ball.0).point(&ball.1);
        let (mut turned, mut reach) = (ZERO, ball.2);
        for &link in chain {
            let way = self.turn(link, region, poses, &centre, reach);
            let slide = self.links[link].joint.as_ref().map_or(ZERO, |joint| region.half(joint.axis));
            turned = turned + way.unwrap_or(ZERO);
            reach = reach + way.unwrap_or(slide);
        }
        turned
    }

    /// All relative motions of two parts between two places on the path; `None` where nothing bounds them.
    pub fn sweep(&self, [from, to]: [f64; 2], pair: [&Part; 2]) -> Option<Sweep> {
        let first = from.floor();
        if to <= first + 1.0 {
            return self.sweep_on(first as usize, [from - first, to - first], pair);
        }
        let mut all = [[f64::INFINITY, f64::NEG_INFINITY]; 9];
        for ranges in &self.boxes[first as usize..to as usize] {
            for (all, [low, high]) in all.iter_mut().zip((*ranges)?) {
                *all = [all[0].min(low), all[1].max(high)];
            }
        }
        let mid = all.map(|[low, high]| I::of(0.5 * (low + high)));
        let wide = std::array::from_fn(|i| I::of((I { lo: all[i][0], hi: all[i][1] } - mid[i]).most()));
        Some(self.swept(&Region { mid, seg: [ZERO; 9], wide, ball: ZERO, group: Vec::new(), tip: None }, pair))
    }

    /// The same between two fractions of one step.
    pub fn sweep_on(&self, step: usize, fractions: [f64; 2], pair: [&Part; 2]) -> Option<Sweep> {
        Some(self.swept(&self.within(step, fractions)?, pair))
    }

    fn swept(&self, region: &Region, [a, b]: [&Part; 2]) -> Sweep {
        let links = [a.link, b.link];
        let poses = region.tip.as_ref().map_or_else(|| self.poses(&region.mid), |tip| tip.poses.clone());
        let [world_from_a, world_from_b] = links.map(|link| poses.of(link));
        let a_from_b = world_from_a.after(&a.pose).inverse().after(&world_from_b.after(&b.pose));
        let ball = |part: &Part| (part.link, part.pose.point(&part.mesh.ball.0), part.mesh.ball.1);
        let chains = self.between(links);
        let known = region.tip.as_ref().zip(self.tip.as_ref()).filter(|(_, tip)| links == [tip.work, tip.tool]);
        if let Some((TipWay { place, way, round, .. }, _)) = known {
            // The tip's way is known, and the tool turns about it.
            let (_, centre, radius) = ball(b);
            let seen = world_from_a.inverse().point(&world_from_b.point(&centre));
            let turned = chains.iter().fold(ZERO, |sum, chain| sum + self.turn_of(chain, region));
            let radius = *round + turned * (norm(&minus(&seen, place)) + radius);
            let ways = vec![a.pose.turn_back(way)];
            return Sweep { a_from_b, ways, group: Vec::new(), ball: ZERO, radius };
        }
        let slides = self.slides(links, &poses).map(|slide| a.pose.turn_back(&slide));
        let along = (0..9).fold([ZERO; 3], |sum, i| plus(&sum, &times(&slides[i], region.seg[i])));
        let ways = std::iter::once(along)
            .chain((0..9).filter(|&i| region.wide[i].hi > 0.0).map(|i| times(&slides[i], region.wide[i])));
        let group = region.group.iter().map(|&axis| slides[axis]).collect();
        let radius =
            self.turned(&chains[0], &ball(a), region, &poses) + self.turned(&chains[1], &ball(b), region, &poses);
        Sweep { a_from_b, ways: ways.collect(), group, ball: region.ball, radius }
    }
}

/// Frobenius norm of MᵀM - 1 for the first three columns M: 0 where they are orthogonal and of length 1.
fn defect(slides: &[V; 9]) -> I {
    let entry = |k: usize| {
        let (i, j) = (k / 3, k % 3);
        (dot(&slides[i], &slides[j]) - if i == j { ONE } else { ZERO }).squared()
    };
    (0..9).fold(ZERO, |sum, k| sum + entry(k)).sqrt()
}
