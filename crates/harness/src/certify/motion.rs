//! What a program's moves do to a pair of parts: the place at the middle of an interval of the path, and how far from there it can be.
//!
//! The formulas and their derivation stand in `docs/certificate.md`; the checker has them a second time, in intervals.

use crate::geometry::{Isometry, Point, Vector};
use crate::machine::tip::TipControl;
use crate::machine::travel::Ball;
use crate::machine::{Machine, Motion, Poses};
use crate::scene::{ProgramRun, Scene, TipFault};
use nalgebra::Matrix3;
use rs274::{Axis, MoveKind, Position, Sampling};

/// How a step goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Course {
    /// Nothing moves: a dwell, a tool change, the start.
    Point,
    /// Straight in the axes, or in the coordinates of the tool's tip.
    Line,
    /// The same at rapid rate: no move to cut in.
    Rapid,
    /// About a centre in the plane of two axes; the radius and all other axes change in proportion to the angle.
    Arc { plane: [Axis; 2], centre: [f64; 2], sweep: f64 },
}

/// A move of the program, or a leg of a rapid along a dog-leg. Steps are numbered from 0; the place `k + f` on the path is the fraction `f` of step `k`.
#[derive(Clone, Debug)]
pub(super) struct Step {
    /// Line of the program; 0 for the start.
    pub line: u32,
    /// The tool in the spindle.
    pub tool: u32,
    pub course: Course,
    /// Whether a cutter may be in the workpiece: it feeds, or stands where a feed has brought it.
    pub cuts: bool,
    /// The stretch of the move that the step is, by fractions of its time.
    pub within: [f64; 2],
    pub from: Position,
    pub to: Position,
    /// Under tool-centre-point control the tool's length, mm; X, Y and Z are then the tip's.
    pub tip_mm: Option<f64>,
}

/// Every step of a program. Step 0 stands at the start with the tool that is in the spindle then.
///
/// # Errors
/// When a rapid has too many legs.
pub(super) fn steps(scene: &Scene, run: &ProgramRun) -> Result<Vec<Step>, TipFault> {
    // Without limits on its pieces a straight leg is one piece.
    let whole = Sampling { step_mm: f64::INFINITY, step_deg: f64::INFINITY, chord_mm: 0.0 };
    let samples = rs274::sample(&run.program, &run.start, &whole, &scene.rates.rapid_path)
        .map_err(|cause| TipFault { file: run.file.clone(), line: cause.line, cause: cause.into() })?;
    let tools = run.tools();
    let start = run.start;
    let first = Step {
        line: 0,
        tool: run.setup.tool,
        course: Course::Point,
        cuts: false,
        within: [0.0, 1.0],
        from: start,
        to: start,
        tip_mm: None,
    };
    let mut steps = vec![first];
    let (mut from, mut rest) = (start, samples.as_slice());
    for (index, step) in run.program.moves.iter().enumerate() {
        let (own, behind) = rest.split_at(rest.iter().take_while(|sample| sample.move_index == index).count());
        rest = behind;
        let course = match step.kind {
            MoveKind::Dwell { .. } | MoveKind::ToolChange { .. } => Course::Point,
            MoveKind::Rapid => Course::Rapid,
            MoveKind::Feed => Course::Line,
            MoveKind::Arc { plane, centre, sweep } => {
                let [first, second, _] = plane.axes();
                Course::Arc { plane: [first, second], centre, sweep }
            }
        };
        let ends = match step.kind {
            MoveKind::Rapid => own.iter().map(|leg| (leg.position, leg.fraction)).collect(),
            _ => vec![(step.end, 1.0)],
        };
        let cuts = match course {
            Course::Line | Course::Arc { .. } => true,
            Course::Rapid => false,
            Course::Point => steps.last().is_some_and(|before| before.cuts && before.tool == tools[index]),
        };
        let (line, tool, tip_mm, mut begin) = (step.line, tools[index], step.tip_mm, 0.0);
        for (to, end) in ends {
            steps.push(Step { line, tool, course, cuts, within: [begin, end], from, to, tip_mm });
            (from, begin) = (to, end);
        }
        from = step.end;
    }
    Ok(steps)
}

/// Where the axes may be over an interval of the path: within `seg` times one number from -1 to 1, plus `wide` for each axis on its own, plus
/// a ball over the axes of `group`, all about `mid`; mm and radians.
#[derive(Clone, Debug)]
pub(super) struct Region {
    pub mid: Position,
    pub seg: [f64; 9],
    pub wide: [f64; 9],
    pub ball: f64,
    pub group: Vec<Axis>,
    /// Under tool-centre-point control, within one step.
    pub tip: Option<TipWay>,
}

/// How the tool's tip goes over the workpiece: within `way` times one number from -1 to 1, plus a ball; mm, in the frame of the workpiece's link.
#[derive(Clone, Debug)]
pub(super) struct TipWay {
    pub tip: Point,
    pub way: Vector,
    pub ball: f64,
}

impl Region {
    fn at(mid: Position) -> Self {
        Self { mid, seg: [0.0; 9], wide: [0.0; 9], ball: 0.0, group: Vec::new(), tip: None }
    }

    /// How far an axis may be from the middle.
    pub fn half(&self, axis: Axis) -> f64 {
        let i = axis as usize;
        self.seg[i].abs() + self.wide[i] + if self.group.contains(&axis) { self.ball } else { 0.0 }
    }
}

/// The machine with a program on it.
pub(super) struct Track<'a> {
    pub machine: &'a Machine,
    pub control: Option<&'a TipControl>,
    pub steps: Vec<Step>,
    /// Lowest and highest axis positions of each whole step; `None` where nothing bounds them.
    boxes: Vec<Option<[Position; 2]>>,
}

impl<'a> Track<'a> {
    pub fn new(machine: &'a Machine, control: Option<&'a TipControl>, steps: Vec<Step>) -> Self {
        let mut track = Self { machine, control, steps, boxes: Vec::new() };
        let bounds = |step| {
            let region = track.within(step, 0.0, 1.0)?;
            let side = |sign: f64| Position(Axis::ALL.map(|axis| region.mid[axis] + sign * region.half(axis)));
            Some([side(-1.0), side(1.0)])
        };
        track.boxes = (0..track.steps.len()).map(bounds).collect();
        track
    }

    /// All positions of the axes between two places that lie on one step or are both whole numbers; `None` where nothing bounds them.
    pub fn region(&self, from: f64, to: f64) -> Option<Region> {
        let first = from.floor();
        if to <= first + 1.0 {
            return self.within(first as usize, from - first, to - first);
        }
        let mut boxes = self.boxes[first as usize..to as usize].iter();
        let [mut low, mut high] = (*boxes.next()?)?;
        for bounds in boxes {
            let [l, h] = (*bounds)?;
            for i in 0..9 {
                low.0[i] = low.0[i].min(l.0[i]);
                high.0[i] = high.0[i].max(h.0[i]);
            }
        }
        let mut region = Region::at(Position(std::array::from_fn(|i| 0.5 * (low.0[i] + high.0[i]))));
        region.wide = std::array::from_fn(|i| 0.5 * (high.0[i] - low.0[i]));
        Some(region)
    }

    /// Between two fractions of a step.
    pub fn within(&self, index: usize, from: f64, to: f64) -> Option<Region> {
        let step = &self.steps[index];
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let (change, begin): ([f64; 9], &Position) = match step.course {
            Course::Point => ([0.0; 9], &step.to),
            _ => (std::array::from_fn(|i| step.to.0[i] - step.from.0[i]), &step.from),
        };
        let mut region = Region::at(Position(std::array::from_fn(|i| begin.0[i] + change[i] * middle)));
        region.seg = change.map(|change| change * half);
        if let Course::Arc { plane, centre, sweep } = step.course {
            let offset = |at: &Position| [at[plane[0]] - centre[0], at[plane[1]] - centre[1]];
            let [x, y] = offset(&step.from);
            let [end_x, end_y] = offset(&step.to);
            let (radius, last) = (x.hypot(y), end_x.hypot(end_y));
            if radius == 0.0 {
                return None;
            }
            let scale = 1.0 + (last / radius - 1.0) * middle;
            let (sin, cos) = (sweep * middle).sin_cos();
            region.mid[plane[0]] = centre[0] + scale * (cos * x - sin * y);
            region.mid[plane[1]] = centre[1] + scale * (sin * x + cos * y);
            plane.iter().for_each(|&axis| region.seg[axis as usize] = 0.0);
            region.ball = half * (radius.max(last) * sweep.abs() + (last - radius).abs());
            region.group = plane.to_vec();
        }
        match step.tip_mm {
            Some(length) => self.follow_tip(&region, length),
            None => Some(region),
        }
    }

    /// The positions of the axes that follow from the positions of the tip.
    fn follow_tip(&self, tip: &Region, length: f64) -> Option<Region> {
        let control = self.control?;
        let is_linear = |axis: Axis| self.machine.joints_of(axis).all(|joint| !joint.turns());
        let is_still = |axis: Axis| tip.half(axis) == 0.0;
        let turns_in_arc = tip.group.iter().any(|axis| axis.is_rotary());
        if !LINEAR.into_iter().chain(SECOND).all(is_linear) || !SECOND.into_iter().all(is_still) || turns_in_arc {
            return None;
        }
        let point = control.gauge + control.direction.into_inner() * length;
        let pair = PairMotion {
            machine: self.machine,
            a: Ball { link: control.work_link, centre: Point::origin(), radius: 0.0 },
            b: Ball { link: control.tool_link, centre: point, radius: 0.0 },
        };
        // Each of the three directions is that of one slide, and turns with it.
        let slides_along = |axis| pair.joints().filter(|joint| joint.axis == axis).count();
        if LINEAR.into_iter().any(|axis| slides_along(axis) > 1) {
            return None;
        }
        // The tip's way over the workpiece is that of the axes at rotary zero.
        let mut at_zero = tip.mid;
        ROTARY.into_iter().for_each(|axis| at_zero[axis] = 0.0);
        at_zero[Axis::Z] += length;
        let zero = self.machine.forward(&at_zero);
        let tip_at =
            |poses: &Poses| poses.world_from(control.work_link).inv_mul(&poses.world_from(control.tool_link)) * point;
        let (wanted, first) =
            (tip_at(&zero), Matrix3::from_columns(&LINEAR.map(|axis| pair.slides(&zero)[axis as usize])));
        let seg = Vector::new(tip.seg[0], tip.seg[1], tip.seg[2]);
        let stretch = (1.0 + defect(&first)).sqrt();
        let (way, ball) = (first * seg, stretch * tip.ball);

        let mut mid = tip.mid;
        LINEAR.into_iter().for_each(|axis| mid[axis] = 0.0);
        let base = self.machine.forward(&mid);
        let slides = Matrix3::from_columns(&LINEAR.map(|axis| pair.slides(&base)[axis as usize]));
        let solved = slides.lu().solve(&(wanted - tip_at(&base)))?;
        LINEAR.iter().zip(solved.iter()).for_each(|(&axis, &value)| mid[axis] = value);

        let mut region = Region { mid, group: LINEAR.to_vec(), ..tip.clone() };
        region.seg[..3].fill(0.0);
        region.ball = 0.0;
        let poses = self.machine.forward(&mid);
        let [of_tool, of_work] = pair.turned_by(&poses, &region, true);
        let turned: f64 =
            pair.joints().filter(|joint| joint.turns).map(|joint| joint.gain * region.half(joint.axis)).sum();
        let defect = defect(&slides);
        if defect >= 1.0 {
            return None;
        }
        let least = (1.0 - defect).sqrt() - 3f64.sqrt() * turned;
        if least < LEAST_SINGULAR {
            return None;
        }
        region.ball = (stretch * seg.norm() + ball + of_tool + of_work) / least;
        region.tip = Some(TipWay { tip: wanted, way, ball });
        Some(region)
    }
}

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
const ROTARY: [Axis; 3] = [Axis::A, Axis::B, Axis::C];
const SECOND: [Axis; 3] = [Axis::U, Axis::V, Axis::W];
/// Least stretch of the linear axes' directions that is solved for.
const LEAST_SINGULAR: f64 = 0.25;

/// How far the columns are from a right angle to one another and from length 1: Frobenius' norm of MᵀM - I.
fn defect(matrix: &Matrix3<f64>) -> f64 {
    (matrix.tr_mul(matrix) - Matrix3::identity()).norm()
}

/// Two parts by the balls around them, in the frames of their links, on a machine.
pub(super) struct PairMotion<'a> {
    pub machine: &'a Machine,
    pub a: Ball,
    pub b: Ball,
}

/// A joint between two parts.
struct Between {
    axis: Axis,
    gain: f64,
    turns: bool,
}

/// Motions of a pair over a region: the pose of `b` in `a` at its middle, and how far a point of `b` is displaced from there less a point of `a`, both as seen from the
/// link that they share: the sum of ways (each times a number of its own from -1 to 1), of an ellipsoid, and of a ball of radius `radius`; mm, in the axes of `a` at
/// the middle. With the tip's way known, `a` stands and `b` goes.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    pub a_from_b: Isometry,
    pub ways: Vec<Vector>,
    pub group: Vec<Vector>,
    pub ball: f64,
    pub radius: f64,
}

impl Sweep {
    /// The most by which the displacement of a point of `b` differs from one of `a`, mm.
    pub fn bound_mm(&self) -> f64 {
        let group = self.group.iter().map(Vector::norm_squared).sum::<f64>().sqrt();
        self.ways.iter().map(Vector::norm).sum::<f64>() + self.ball * group + self.radius
    }

    /// How far along `n` any point may come towards `a`, times the length of `n`, without the ball.
    pub fn towards(&self, n: &Vector) -> f64 {
        let group = self.group.iter().map(|e| n.dot(e).powi(2)).sum::<f64>().sqrt();
        self.ways.iter().map(|way| n.dot(way).abs()).sum::<f64>() + self.ball * group
    }

    /// Greatest reach of the ways and the ellipsoid along `n`.
    pub fn support(&self, n: &Vector) -> Vector {
        let along = |way: &Vector| way * if n.dot(way) < 0.0 { -1.0 } else { 1.0 };
        let mut point: Vector = self.ways.iter().map(along).sum();
        let length = self.group.iter().map(|e| n.dot(e).powi(2)).sum::<f64>().sqrt();
        if length > 0.0 {
            point += self.group.iter().map(|e| e * (n.dot(e) * self.ball / length)).sum::<Vector>();
        }
        point
    }
}

impl PairMotion<'_> {
    /// Links with joints from a part's own up to the shared one, which is left out.
    fn chain(&self, link: Option<usize>) -> impl Iterator<Item = usize> {
        let base = self.machine.nearest_shared(self.a.link, self.b.link);
        let links = self.machine.chain(link);
        links.take_while(move |&link| Some(link) != base).filter(|&link| self.machine.links()[link].joint.is_some())
    }

    fn joints(&self) -> impl Iterator<Item = Between> {
        let between = |link: usize| {
            let joint = self.machine.links()[link].joint.as_ref()?;
            Some(Between { axis: joint.axis, gain: joint.gain(), turns: joint.turns() })
        };
        self.chain(self.a.link).chain(self.chain(self.b.link)).filter_map(between)
    }

    /// Where `b` goes in the frame of link `a` for each mm of each axis that slides.
    fn slides(&self, poses: &Poses) -> [Vector; 9] {
        let mut slides = [Vector::zeros(); 9];
        let a_from_world = poses.world_from(self.a.link).rotation.inverse();
        for (link, sign) in [(self.a.link, -1.0), (self.b.link, 1.0)] {
            for link in self.chain(link) {
                let Some(joint) = &self.machine.links()[link].joint else { continue };
                if let Motion::Prismatic { direction } = joint.motion {
                    slides[joint.axis as usize] +=
                        a_from_world * (poses.0[link].rotation * direction.into_inner()) * sign;
                }
            }
        }
        slides
    }

    /// How far turning joints move the points of `b`, and those of `a`, as seen from the shared link, mm. With `rigid` the tool's tip alone counts, whose place is
    /// that of `b`, and nothing slides.
    fn turned_by(&self, poses: &Poses, region: &Region, rigid: bool) -> [f64; 2] {
        let mut travel = 0.0;
        [&self.b, &self.a].map(|part| {
            let ball = if rigid { &self.b } else { part };
            let centre = poses.world_from(ball.link) * ball.centre;
            if !rigid {
                travel = 0.0;
            }
            let mut turned = 0.0;
            let mut links: Vec<usize> = self.chain(part.link).collect();
            if rigid && part.link == self.a.link {
                links.reverse();
            }
            for link in links {
                let Some(joint) = &self.machine.links()[link].joint else { continue };
                let step = region.half(joint.axis) * joint.gain();
                match joint.motion {
                    Motion::Prismatic { .. } if rigid => {}
                    Motion::Prismatic { .. } => travel += step,
                    Motion::Rotary { direction, point } => {
                        let pose = &poses.0[link];
                        let arm = (pose * direction.into_inner()).cross(&(centre - pose * point)).norm();
                        let way = step * (arm + ball.radius + travel);
                        turned += way;
                        travel += way;
                    }
                }
            }
            turned
        })
    }

    /// All relative motions of the pair over a region. `control` names the links of tool and workpiece, for whose parts the way of the tip is known.
    pub fn sweep(&self, region: &Region, control: Option<&TipControl>, parts: [&Isometry; 2]) -> Sweep {
        let poses = self.machine.forward(&region.mid);
        let world_from = |ball: &Ball, part: &Isometry| poses.world_from(ball.link) * part;
        let a_from_b = world_from(&self.a, parts[0]).inv_mul(&world_from(&self.b, parts[1]));
        let turn = parts[0].rotation.inverse();
        if let (Some(tip), Some(control)) = (&region.tip, control)
            && self.a.link == control.work_link
            && self.b.link == control.tool_link
        {
            let turned: f64 =
                self.joints().filter(|joint| joint.turns).map(|joint| joint.gain * region.half(joint.axis)).sum();
            let a_from_tool = poses.world_from(self.a.link).inv_mul(&poses.world_from(self.b.link));
            let arm = (a_from_tool * self.b.centre - tip.tip).norm() + self.b.radius;
            let radius = tip.ball + turned * arm;
            return Sweep { a_from_b, ways: vec![turn * tip.way], group: Vec::new(), ball: 0.0, radius };
        }
        let slides = self.slides(&poses).map(|slide| turn * slide);
        let mut ways = Vec::new();
        let along: Vector = (0..9).map(|i| slides[i] * region.seg[i]).sum();
        if along != Vector::zeros() {
            ways.push(along);
        }
        ways.extend((0..9).map(|i| slides[i] * region.wide[i]).filter(|way| *way != Vector::zeros()));
        let group = if region.ball > 0.0 {
            region.group.iter().map(|&axis| slides[axis as usize]).collect()
        } else {
            Vec::new()
        };
        let [b, a] = self.turned_by(&poses, region, false);
        Sweep { a_from_b, ways, group, ball: region.ball, radius: a + b }
    }
}
