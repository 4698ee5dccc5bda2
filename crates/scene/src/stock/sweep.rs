//! A part that moves through the stock, and how deep a point of the stock comes into it.

use super::convex::{Cube, Least};
use super::course::Course;
use super::round::Round;
use super::skin::Skin;
use super::turned::{Shift, Turned};
use crate::geometry::{Isometry, Mesh, Point, Vector};
use crate::interference::ROUND;
use nalgebra::UnitQuaternion;
use std::sync::Arc;

/// What rounding may do to a depth, mm: a thousand times the rounding of a coordinate of 4 m, and the least height of a profile's step.
pub const ROUNDING_MM: f64 = 1e-6;
/// How far a body may be from where it was to be in the same place, mm.
const RETRACED_MM: f64 = 1e-6;
/// Part of the radius by which the faces of what stands may be nearer to its axis than its edges, for it to count as a body of revolution.
const FACETED: f64 = 0.02;
/// Travel to which the place is found where a mesh that does not turn is deepest, mm.
const SKIN_STEP_MM: f64 = 0.02;
/// Part of a depth in such a mesh to which it is found.
const SKIN_PART: f64 = 0.05;

/// A part as the stock meets it.
#[derive(Clone, Debug)]
pub struct Body {
    form: Arc<Form>,
}

#[derive(Clone, Debug)]
pub(super) enum Form {
    Round(Round),
    Rigid(Skin),
}

impl Body {
    /// A part that its spindle turns about its own axis: the body of revolution around it. Grooves of its outline that are at most `groove_mm` wide, along
    /// the axis, count as filled.
    pub fn turning(mesh: &Arc<Mesh>, groove_mm: f64) -> Self {
        Self { form: Arc::new(Form::Round(Round::new(mesh, groove_mm))) }
    }

    /// A workpiece that turns about its own axis.
    pub fn stock(mesh: &Arc<Mesh>) -> Self {
        Self { form: Arc::new(Form::Round(Round::stock(mesh))) }
    }

    /// A part that turns about z of the frame to which `axis_from_part` leads.
    pub fn turning_about(mesh: &Arc<Mesh>, axis_from_part: Isometry, groove_mm: f64) -> Self {
        Self { form: Arc::new(Form::Round(Round::about(mesh, axis_from_part, groove_mm))) }
    }

    /// A part that does not turn, or the body of revolution around it where the two are nearly one.
    pub fn standing(mesh: &Arc<Mesh>) -> Self {
        let is_smooth = |round: &Round| round.is_solid() && round.slack_mm <= FACETED * round.radius_mm;
        let round = Round::standing(mesh).filter(is_smooth).map(Form::Round);
        Self { form: Arc::new(round.unwrap_or_else(|| Form::Rigid(Skin::new(mesh)))) }
    }

    /// A round mesh where it is, with the points of it that are in the mesh for sure however it is turned; `None` of all others.
    pub fn round_as_drawn(mesh: &Arc<Mesh>) -> Option<Self> {
        let round = Round::standing(mesh).filter(Round::is_solid)?;
        Some(Self { form: Arc::new(Form::Round(round)) })
    }

    /// The same body of revolution of which no point is in the part for sure: it takes nothing away, and what comes into it is not certain.
    pub fn vague(&self) -> Self {
        match &*self.form {
            Form::Round(round) => Self { form: Arc::new(Form::Round(round.vague())) },
            Form::Rigid(_) => self.clone(),
        }
    }

    /// Centre and radius of a ball around it, in the part's frame, mm.
    pub fn ball(&self) -> (Point, f64) {
        match &*self.form {
            Form::Round(Round { radius_mm, span_mm: [low, high], body_from_part, .. }) => {
                let centre = Point::new(0.0, 0.0, f64::midpoint(*low, *high));
                (body_from_part.inverse() * centre, radius_mm.hypot(0.5 * (high - low)))
            }
            Form::Rigid(skin) => {
                let (low, high) = skin.bounds();
                (nalgebra::center(&low, &high), 0.5 * (high - low).norm())
            }
        }
    }

    /// A point of its axis and the axis's direction, in the part's frame, where the mesh is round about it.
    pub fn axis(&self) -> Option<(Point, Vector)> {
        match &*self.form {
            Form::Round(round) if round.filled >= ROUND => {
                let part_from_body = round.body_from_part.inverse();
                Some((part_from_body * Point::origin(), part_from_body * Vector::z()))
            }
            _ => None,
        }
    }

    /// Whether it is a body of revolution.
    pub fn is_round(&self) -> bool {
        matches!(&*self.form, Form::Round(_))
    }

    /// How deep a point can be in it, mm; where that is more than `out_mm`, in what is thin of it and stands out of the rest by more than `out_mm`, or 1.5 `out_mm`
    /// where it is no body of revolution.
    pub fn deepest_mm(&self, out_mm: f64) -> f64 {
        match &*self.form {
            Form::Round(round) => round.deepest_mm(out_mm),
            Form::Rigid(skin) => skin.thinnest_mm(out_mm),
        }
    }

    /// Part of the body of revolution that the mesh fills, 0 to 1; 1 of a part that does not turn.
    pub fn filled(&self) -> f64 {
        if let Form::Round(round) = &*self.form { round.filled } else { 1.0 }
    }

    /// The part from one pose to another, as frames of its mesh in the stock's, mm. Every point of the stock that it meets is within `pad_mm` of where it would be if
    /// it went straight in the part's frame.
    pub fn sweep(&self, [first, last]: [&Isometry; 2], pad_mm: f64) -> Sweep {
        let body_from_part = match &*self.form {
            Form::Round(round) => round.body_from_part,
            Form::Rigid(_) => Isometry::identity(),
        };
        let body_from_stock = [first, last].map(|pose| body_from_part * pose.inverse());
        let [(low, high), (end_low, end_high)] = body_from_stock.map(|pose| self.form.bounds(&pose.inverse()));
        let beyond = Vector::repeat(pad_mm + ROUNDING_MM);
        let (low, high) = (low.inf(&end_low) - beyond, high.sup(&end_high) + beyond);
        let (centre, radius_mm) = self.ball();
        let turn = first.rotation.angle_to(&last.rotation);
        let way_mm = (last * centre - first * centre).norm() + turn * radius_mm;
        let course = Course::new(&body_from_stock[0], &body_from_stock[1]);
        let way = Way::Chords { form: Arc::clone(&self.form), course };
        Sweep { way, way_mm, pad: pad_mm + ROUNDING_MM, low, high, drawn: None }
    }
}

impl Form {
    const fn slack_mm(&self) -> f64 {
        match self {
            Self::Round(round) => round.slack_mm,
            Self::Rigid(_) => 0.0,
        }
    }

    /// A box around the body where it is placed.
    fn bounds(&self, stock_from_body: &Isometry) -> (Point, Point) {
        let (centre, half) = match self {
            Self::Round(Round { radius_mm, span_mm: [low, high], .. }) => {
                let axis = stock_from_body * Vector::z();
                let across = axis.map(|x| (1.0 - x * x).max(0.0).sqrt());
                let centre = Point::new(0.0, 0.0, f64::midpoint(*low, *high));
                (centre, axis.abs() * (0.5 * (high - low)) + across * *radius_mm)
            }
            Self::Rigid(skin) => {
                let (low, high) = skin.bounds();
                let rotation = stock_from_body.rotation.to_rotation_matrix();
                (nalgebra::center(&low, &high), rotation.matrix().abs() * (0.5 * (high - low)))
            }
        };
        let centre = stock_from_body * centre;
        (centre - half, centre + half)
    }
}

/// A workpiece's axis of turning.
#[derive(Clone, Copy, Debug)]
pub struct Spindle {
    /// Takes the stock's frame to that of the axis, which is its z.
    pub axis_from_stock: Isometry,
    /// Whether the stock is a half section, (ρ, z), in the axis's frame ([`super::Stock::turned`]).
    pub is_flat: bool,
}

/// A cutter that stands while the workpiece turns, its frame turned against that of the axis by a fixed rotation.
#[derive(Clone, Debug)]
pub struct TurningTool {
    section: Arc<Turned>,
    rotation: UnitQuaternion<f64>,
}

impl TurningTool {
    /// The section of a mesh whose frame is turned by `rotation` against the axis's; x of that frame leads from the axis to the tool. Of what
    /// `cuts`, more is known to be swept.
    pub fn new(mesh: &Mesh, rotation: UnitQuaternion<f64>, beside_mm: f64, cuts: bool) -> Self {
        let axis_from_part = Isometry::from_parts(Vector::new(0.0, beside_mm, 0.0).into(), rotation);
        Self { section: Arc::new(Turned::new(mesh, &axis_from_part, cuts)), rotation }
    }

    /// The same of which nothing is known but that it is within its outline: it takes nothing away for sure.
    pub fn vague(&self) -> Self {
        Self { section: Arc::new(self.section.vague()), rotation: self.rotation }
    }

    /// How deep a point of the section can be in it at most, mm.
    pub fn deepest_mm(&self) -> f64 {
        self.section.deepest_mm()
    }

    /// Whether the mesh is turned as another place wants it.
    pub fn is_turned_by(&self, rotation: &UnitQuaternion<f64>) -> bool {
        self.rotation.angle_to(rotation) < 1e-9
    }

    /// The way of the mesh's origin from `start` by `travel`, both (x, z) in the frame of the axis, mm.
    pub fn sweep(&self, spindle: &Spindle, start: [f64; 2], travel: [f64; 2], pad_mm: f64) -> Sweep {
        let shift = self.section.shift(start, travel);
        let axis_from_stock = spindle.axis_from_stock;
        let ring = if spindle.is_flat { [1.0, 1.0] } else { ring(&axis_from_stock) };
        let way = Way::Turned { section: Arc::clone(&self.section), shift, axis_from_stock, ring };
        let everywhere = Vector::repeat(f64::INFINITY);
        let way_mm = travel[0].hypot(travel[1]);
        let (low, high) = ((-everywhere).into(), everywhere.into());
        Sweep { way, way_mm, pad: pad_mm + ROUNDING_MM, low, high, drawn: None }
    }
}

/// A part on a piece of its way.
#[derive(Clone, Debug)]
pub struct Sweep {
    pub(super) way: Way,
    /// How far a point of the part goes at most, mm.
    pub(super) way_mm: f64,
    pub(super) pad: f64,
    /// Box around all of it, stock frame, mm.
    pub(super) low: Point,
    pub(super) high: Point,
    /// Of a body of revolution around a part that stands: the part as drawn. Depth in this alone is certain.
    pub(super) drawn: Option<Box<Self>>,
}

#[derive(Clone, Debug)]
pub(super) enum Way {
    Chords {
        form: Arc<Form>,
        course: Course,
    },
    Turned {
        section: Arc<Turned>,
        shift: Shift,
        axis_from_stock: Isometry,
        /// How far from that of its centre the distance from the axis and the place along it may be in a cube of half a side of 1.
        ring: [f64; 2],
    },
}

/// What is asked of a mesh that does not turn.
struct SkinSearch<'a> {
    /// Whether a depth beyond that of a cube that is inside is looked for.
    is_deepest: bool,
    /// Distances from the mesh that were found.
    asked: &'a mut u64,
}

/// Half the extents of a cube of half a side of 1 across an axis and along it.
fn ring(axis_from_stock: &Isometry) -> [f64; 2] {
    let corner = |k: u32| {
        let side = |axis: u32| if k >> axis & 1 == 0 { -1.0 } else { 1.0 };
        axis_from_stock.rotation * Vector::new(side(0), side(1), side(2))
    };
    let corners = (0..8).map(corner);
    corners.fold([0.0, 0.0], |[across, along], p| [p.x.hypot(p.y).max(across), p.z.abs().max(along)])
}

impl Sweep {
    /// The part of the way from one part to another, 0 to 1. Its box stays that of the whole.
    pub(super) fn part(&self, from: f64, to: f64) -> Self {
        let way = match &self.way {
            Way::Chords { form, course } => Way::Chords { form: Arc::clone(form), course: course.part(from, to) },
            Way::Turned { section, shift, axis_from_stock, ring } => Way::Turned {
                section: Arc::clone(section),
                shift: shift.part(from, to),
                axis_from_stock: *axis_from_stock,
                ring: *ring,
            },
        };
        let drawn = self.drawn.as_ref().map(|drawn| Box::new(drawn.part(from, to)));
        Sweep { way, way_mm: self.way_mm * (to - from), drawn, ..*self }
    }

    /// The same of a part that stands, nobody knows at which angle, and that `drawn` shows at one.
    pub fn standing(self, drawn: Self) -> Self {
        Self { drawn: Some(Box::new(drawn)), ..self }
    }

    /// The part of the way on which the same body is where it is on the way of `cut`, up to rounding, 0 to 1; `None` where there is none of it.
    pub(super) fn retraced(&self, cut: &Self) -> Option<[f64; 2]> {
        let (start, way, first, along) = match (&self.way, &cut.way) {
            // Where a part turns it is never exactly where it was.
            (Way::Chords { form, course }, Way::Chords { form: other, course: there })
                if Arc::ptr_eq(form, other) && !course.turns() && !there.turns() && course.is_turned_as(there) =>
            {
                let ((start, way), (first, along)) = (course.of_origin(), there.of_origin());
                (start, way, first, along)
            }
            (Way::Turned { section, shift, .. }, Way::Turned { section: other, shift: there, .. })
                if Arc::ptr_eq(section, other) =>
            {
                let flat = |v: [f64; 2]| Vector::new(v[0], 0.0, v[1]);
                (flat(shift.start), flat(shift.travel), flat(there.start), flat(there.travel))
            }
            _ => return None,
        };
        let length = along.norm();
        let direction = if length > RETRACED_MM { along / length } else { return None };
        let aside = |p: Vector| (p - direction * direction.dot(&p)).norm();
        let from = start - first;
        if aside(from) > RETRACED_MM || aside(from + way) > RETRACED_MM {
            return None;
        }
        let (begin, end) = (direction.dot(&from), direction.dot(&(from + way)));
        let inside = |x: f64| (-RETRACED_MM..=length + RETRACED_MM).contains(&x);
        if (end - begin).abs() <= RETRACED_MM {
            return (inside(begin) && inside(end)).then_some([0.0, 1.0]);
        }
        let at = |x: f64| ((x - begin) / (end - begin)).clamp(0.0, 1.0);
        let (one, other) = (at(0.0), at(length));
        let is_met = begin.min(end) <= length && begin.max(end) >= 0.0;
        is_met.then_some([one.min(other), one.max(other)])
    }

    /// How deep material can be in a body that retraces the way of `cut`, mm.
    pub(super) fn retraced_mm(&self, cut: &Self) -> f64 {
        // A cutter that turns is what it was there.
        let slack = if self.is_of_mesh() { f64::INFINITY } else { 0.0 };
        RETRACED_MM + self.pad + cut.pad + slack
    }

    /// Whether it is of a mesh that does not turn, and is no body of revolution.
    pub(super) fn is_of_mesh(&self) -> bool {
        matches!(&self.way, Way::Chords { form, .. } if matches!(&**form, Form::Rigid(_)))
    }

    /// Whether no point is in the part for sure, its mesh being open.
    pub fn is_vague(&self) -> bool {
        match &self.way {
            Way::Chords { form, .. } => matches!(&**form, Form::Round(round) if round.is_vague()),
            Way::Turned { section, .. } => section.is_empty(),
        }
    }

    /// How deep a point must be in the part's body to be in the part for sure, mm, where that is known.
    pub(super) fn slack_mm(&self) -> f64 {
        match &self.way {
            Way::Chords { form, .. } => form.slack_mm(),
            Way::Turned { .. } => 0.0,
        }
    }

    /// Whether it comes near a box.
    pub(super) fn reaches(&self, low: &Point, high: &Point) -> bool {
        (0..3).all(|k| self.low[k] <= high[k] && low[k] <= self.high[k])
    }

    /// Whether a cube of the stock is inside, outside or neither: a depth beyond that of a cube that is inside is not looked for.
    pub(super) fn side(&self, centre: &Point, half: f64) -> Least {
        self.least(centre, half, SkinSearch { is_deepest: false, asked: &mut 0 })
    }

    /// How deep a cube of the stock comes into the part: minus the depth, mm. Adds the distances from a mesh that it finds to `asked`.
    pub(super) fn depth(&self, centre: &Point, half: f64, asked: &mut u64) -> Least {
        self.least(centre, half, SkinSearch { is_deepest: true, asked })
    }

    fn least(&self, centre: &Point, half: f64, search: SkinSearch<'_>) -> Least {
        let radius = half * 3f64.sqrt();
        match &self.way {
            Way::Chords { form, course } => {
                let (q, travel) = course.at(centre);
                let bent = course.bend() * radius;
                match &**form {
                    Form::Round(round) => {
                        let sure = -(radius + self.pad);
                        let inside = if search.is_deepest { f64::NEG_INFINITY } else { sure };
                        let cube = Cube { half, radius, axes: course.axes(), inside, outside: self.pad + bent };
                        let found = round.least(&q, &travel, &cube);
                        self.padded(Least { deep: found.deep - bent, ..found })
                    }
                    Form::Rigid(skin) => self.padded(self.least_of_skin(skin, &q.into(), &travel, radius, search)),
                }
            }
            Way::Turned { section, shift, axis_from_stock, ring } => {
                let at = axis_from_stock * centre;
                self.padded(section.least(at.x.hypot(at.y), at.z, shift, ring.map(|part| part * half)))
            }
        }
    }

    fn padded(&self, found: Least) -> Least {
        Least { low: found.low - self.pad, high: found.high + self.pad, deep: found.deep - self.pad }
    }

    /// The distance changes by no more than the point moves, so that its values at both ends of a piece of the way bound it between them. A piece is divided until it
    /// decides nothing, or is short: beside a cube, or at all (Shubert 1972). Adds the distances that it finds to `asked`.
    fn least_of_skin(&self, skin: &Skin, start: &Point, travel: &Vector, radius: f64, search: SkinSearch<'_>) -> Least {
        let SkinSearch { is_deepest, asked } = search;
        let way = travel.norm();
        let beyond = way + radius + self.pad + 1.0;
        // What is farther away is so all along the way.
        let mut distance = |at: f64| {
            *asked += 1;
            skin.signed_distance_mm(&(start - travel * at), beyond).min(beyond)
        };
        let piece = |[from, to]: [f64; 2], ends: [f64; 2]| {
            let low = 0.5 * (ends[0] + ends[1] - (to - from) * way);
            (low.min(ends[0]).min(ends[1]), [from, to], ends)
        };
        let first = distance(0.0);
        let ends = [first, if way > 0.0 { distance(1.0) } else { first }];
        let (mut low, mut high, mut open) = (f64::INFINITY, ends[0].min(ends[1]), vec![piece([0.0, 1.0], ends)]);
        while let Some((bound, [from, to], ends)) = open.pop() {
            let is_inside = if is_deepest { high - bound <= SKIN_PART * -high } else { high <= -(radius + self.pad) };
            let is_short = (to - from) * way <= SKIN_STEP_MM.max(0.5 * radius);
            if is_inside || is_short || bound - radius >= self.pad || bound >= low {
                low = low.min(bound);
                continue;
            }
            // Where the bounds from both ends meet, but not next to an end.
            let meet = f64::midpoint(from, to) + 0.5 * (ends[0] - ends[1]) / way;
            let inset = 0.1 * (to - from);
            let at = meet.clamp(from + inset, to - inset);
            let middle = distance(at);
            high = high.min(middle);
            let halves = [piece([from, at], [ends[0], middle]), piece([at, to], [middle, ends[1]])];
            // The one that may be deeper is next.
            let [one, other] = halves;
            open.extend(if one.0 < other.0 { [other, one] } else { [one, other] });
        }
        Least { low, high, deep: low - radius }
    }
}
