//! A cutter that stands while the workpiece turns: its section through the workpiece's axis, as convex pieces.
//!
//! The workpiece turns many times while the cutter feeds, so what the cutter takes away is a body of revolution about the workpiece's axis: all
//! points whose distance ρ from the axis and place z along it are those of a point of the cutter. Two regions of (ρ, z) bound it. The section of the cutter
//! with the plane of the axis is swept for sure. The hull of its outline, widened by what points beside the plane have a ρ greater than their x, holds all.
//!
//! The widening, of each half plane a ρ + b z <= c of the hull. For a point p of a triangle ρ(p) is between |x(p)| and the mixture of the corners' ρ, as the norm is
//! convex. Where x(p) >= 0 and a < 0, (x, z) in the half plane puts (ρ, z) into it; where a >= 0, p is beyond it by no more than some corner at (ρ, z)
//! is. Where x(p) < 0 the same holds of (-ρ, z) and the other sign of a, and ρ - |x| is at most |y|.

use super::convex::{Convex, HalfPlane, Least};
use crate::geometry::hull::Hull;
use crate::geometry::{Isometry, Mesh, Point, Vector};
use std::sync::Arc;

/// Heights nearer than this are one, mm.
const SAME_MM: f64 = 1e-7;

/// A cutter's section, x away from the axis, in the frame of the axis.
#[derive(Clone, Debug)]
pub(super) struct Turned {
    /// Convex pieces of (x, z), mm; their union is the section. None where the plane of the axis misses the cutter.
    section: Vec<Convex>,
    /// The hull of the cutter's outline.
    hull: Option<Convex>,
    /// Half the lesser extent of the outline, mm.
    deepest: f64,
    /// Corners of the cutter's hull: what widens a plane is convex in the point, so that all others widen it less.
    corners: Vec<Point>,
    /// Largest distance from the plane, mm.
    beside: f64,
}

/// Where a section is at first and how it goes, in (x, z), mm.
#[derive(Clone, Debug)]
pub(super) struct Shift {
    pub start: [f64; 2],
    pub travel: [f64; 2],
    /// The hull, widened by what is beside the plane.
    hull: Option<Arc<Convex>>,
}

impl Turned {
    /// The section of a mesh in the frame that `axis_from_part` leads to; its z is the axis, its x and z span the plane.
    pub fn new(mesh: &Mesh, axis_from_part: &Isometry) -> Self {
        let vertices: Vec<Point> = mesh.vertices().iter().map(|vertex| axis_from_part * vertex).collect();
        let segments: Vec<[[f64; 2]; 2]> =
            mesh.faces().iter().filter_map(|face| cut(face.map(|corner| vertices[corner as usize]))).collect();
        let hull = convex(&hull(vertices.iter().map(|v| [v.x, v.z]).collect()));
        let beside = vertices.iter().map(|v| v.y.abs()).fold(0.0, f64::max);
        // What an open mesh fills nobody knows.
        let section = if mesh.edge_report().is_watertight() { pieces(&segments) } else { Vec::new() };
        let extent = |of: fn(&Point) -> f64| {
            let (low, high) =
                vertices.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        let deepest = 0.5 * extent(|v| v.x).min(extent(|v| v.z));
        let corners = match Hull::of(vertices.iter()) {
            Some(Hull::Solid(solid)) => solid.vertices,
            _ => vertices,
        };
        Self { section, hull, deepest, corners, beside }
    }

    /// The same without a section.
    pub fn vague(&self) -> Self {
        Self { section: Vec::new(), ..self.clone() }
    }

    /// How deep a point can be in the section at most, mm.
    pub const fn deepest_mm(&self) -> f64 {
        self.deepest
    }

    /// Whether the plane of the axis misses the cutter, or its mesh is open.
    pub const fn is_empty(&self) -> bool {
        self.section.is_empty()
    }

    /// A way from `start` to `start + travel`.
    pub fn shift(&self, start: [f64; 2], travel: [f64; 2]) -> Shift {
        let hull = self.hull.as_ref().map(|hull| Arc::new(self.widened(hull, start[0].min(start[0] + travel[0]))));
        Shift { start, travel, hull }
    }

    /// The hull with all points of the cutter in it, when it is moved by `x` or more: beside the plane ρ exceeds x the more, the nearer the axis is.
    fn widened(&self, hull: &Convex, x: f64) -> Convex {
        let crosses = self.corners.iter().any(|v| v.x + x < 0.0);
        let widened = |plane: &HalfPlane| {
            let HalfPlane { a, b, c } = *plane;
            let beyond = |side: f64| {
                let of = |v: &Point| a * (side * (v.x + x).hypot(v.y) - x) + b * v.z - c;
                self.corners.iter().map(of).fold(0.0, f64::max)
            };
            let by = match (a >= 0.0, crosses) {
                (true, _) => beyond(1.0),
                (false, true) => beyond(-1.0).min(-a * self.beside),
                (false, false) => 0.0,
            };
            HalfPlane { a, b, c: c + by }
        };
        Convex { planes: hull.planes.iter().map(widened).collect() }
    }

    /// Linear functions of (ρ, 0, z) below the excess, one for each side of the axis: values at a point, and gradients.
    pub fn tangents(&self, rho: f64, z: f64, shift: &Shift) -> impl Iterator<Item = (f64, Vector)> {
        let of = move |(hull, side): (&Convex, f64)| {
            let OnLine { low, normal: [a, b], .. } = OnLine::least(hull, shift.seen(side * rho, z), shift.travel);
            (low, Vector::new(side * a, 0.0, b))
        };
        shift.hull.iter().flat_map(|hull| [(&**hull, 1.0), (&**hull, -1.0)]).map(of)
    }

    /// The piece of the section that comes nearest to a point (ρ, z), or holds it the deepest, and where on the way it does, 0 to 1.
    pub fn nearest(&self, rho: f64, z: f64, shift: &Shift) -> Option<(&Convex, f64)> {
        let of = |piece| (piece, OnLine::least(piece, shift.seen(rho, z), shift.travel));
        let nearest = self.section.iter().map(of).min_by(|(_, a), (_, b)| a.high.total_cmp(&b.high));
        nearest.map(|(piece, found)| (piece, found.at))
    }

    /// As [`Convex::lowest`], of a point (ρ, z) and all that are as near as `ring` says.
    pub fn least(&self, rho: f64, z: f64, shift: &Shift, [across, along]: [f64; 2]) -> Least {
        let of = |piece: &Convex, side: f64| OnLine::least(piece, shift.seen(side * rho, z), shift.travel);
        let mut found = Least { low: f64::INFINITY, high: f64::INFINITY, deep: f64::INFINITY };
        for (hull, side) in shift.hull.iter().flat_map(|hull| [(hull, 1.0), (hull, -1.0)]) {
            let OnLine { low, normal: [a, b], .. } = of(hull, side);
            let spread = a.abs() * across + b.abs() * along;
            (found.low, found.deep) = (found.low.min(low), found.deep.min(low - spread));
        }
        // What is outside is not asked whether it is inside.
        if found.deep < 0.0 {
            let highs = self.section.iter().map(|piece| of(piece, 1.0).high.min(of(piece, -1.0).high));
            found.high = highs.fold(f64::INFINITY, f64::min);
        }
        found
    }
}

impl Shift {
    /// The part of the way from one part to another, 0 to 1.
    pub fn part(&self, from: f64, to: f64) -> Self {
        Self { start: self.at(from), travel: self.travel.map(|d| d * (to - from)), hull: self.hull.clone() }
    }

    /// Where the section is at a part of the way.
    pub fn at(&self, part: f64) -> [f64; 2] {
        std::array::from_fn(|k| self.start[k] + part * self.travel[k])
    }

    /// A point as the section sees it at first.
    fn seen(&self, rho: f64, z: f64) -> [f64; 2] {
        [rho - self.start[0], z - self.start[1]]
    }
}

/// The least of the greatest of linear functions along a way: bounds that rounding alone parts.
#[derive(Clone, Copy)]
struct OnLine {
    low: f64,
    high: f64,
    /// Where on the way it is, 0 to 1.
    at: f64,
    /// Gradient of a linear function that is `low` at the point, and below the least at all others.
    normal: [f64; 2],
}

/// The greatest of linear functions at a place of the way: its value, slope along the way, and gradient.
#[derive(Clone, Copy)]
struct Greatest {
    at: f64,
    value: f64,
    slope: f64,
    normal: [f64; 2],
}

impl OnLine {
    fn least(piece: &Convex, q: [f64; 2], travel: [f64; 2]) -> Self {
        let greatest = |at: f64| {
            let of = |plane: &HalfPlane| {
                let slope = -(plane.a * travel[0] + plane.b * travel[1]);
                let value = plane.a * q[0] + plane.b * q[1] - plane.c + slope * at;
                Greatest { at, value, slope, normal: [plane.a, plane.b] }
            };
            let nothing = Greatest { at, value: f64::INFINITY, slope: 0.0, normal: [0.0; 2] };
            piece.planes.iter().map(of).reduce(|a, b| if b.value > a.value { b } else { a }).unwrap_or(nothing)
        };
        let at_end = |Greatest { at, value, normal, .. }| Self { low: value, high: value, at, normal };
        let (mut before, mut behind) = (greatest(0.0), greatest(1.0));
        if before.slope >= 0.0 {
            return at_end(before);
        }
        if behind.slope <= 0.0 {
            return at_end(behind);
        }
        // Each step drops one of finitely many lines.
        let mut steps = 2 * piece.planes.len();
        loop {
            let meet = ((before.value - before.slope * before.at) - (behind.value - behind.slope * behind.at))
                / (behind.slope - before.slope);
            let bound = before.value + before.slope * (meet - before.at);
            let found = greatest(meet.clamp(before.at, behind.at));
            // What neither falls nor rises is least there, however far below the lines of both sides meet.
            if found.slope == 0.0 {
                return at_end(found);
            }
            if found.value <= bound + 1e-12 || steps == 0 {
                // The mixture of both that has no slope.
                let share = behind.slope / (behind.slope - before.slope);
                let mixed = |k: usize| share * before.normal[k] + (1.0 - share) * behind.normal[k];
                let low = bound.min(found.value);
                return Self { low, high: found.value, at: found.at, normal: [mixed(0), mixed(1)] };
            }
            steps -= 1;
            if found.slope < 0.0 {
                before = found;
            } else {
                behind = found;
            }
        }
    }
}

/// Where a triangle meets the plane y = 0, as a segment of (x, z). Corners in the plane count to the side y > 0.
fn cut(corners: [Point; 3]) -> Option<[[f64; 2]; 2]> {
    let mut ends = Vec::with_capacity(2);
    for k in 0..3 {
        let (p, q) = (corners[k], corners[(k + 1) % 3]);
        if (p.y >= 0.0) != (q.y >= 0.0) {
            let at = p + (q - p) * (p.y / (p.y - q.y));
            ends.push([at.x, at.z]);
        }
    }
    (ends.len() == 2).then(|| [ends[0], ends[1]])
}

/// The inside of a closed outline, given by its segments in any order: as one convex piece where it is one, else as trapezoids.
fn pieces(segments: &[[[f64; 2]; 2]]) -> Vec<Convex> {
    let mut heights: Vec<f64> = segments.iter().flatten().map(|end| end[1]).collect();
    heights.sort_by(f64::total_cmp);
    heights.dedup_by(|next, kept| *next - *kept <= SAME_MM);
    let mut trapezoids: Vec<[[f64; 2]; 4]> = Vec::new();
    for slab in heights.windows(2) {
        let x_at = |segment: &[[f64; 2]; 2], z: f64| {
            let [p, q] = segment;
            p[0] + (q[0] - p[0]) * ((z - p[1]) / (q[1] - p[1]))
        };
        let middle = f64::midpoint(slab[0], slab[1]);
        let mut crossing: Vec<&[[f64; 2]; 2]> =
            segments.iter().filter(|segment| (segment[0][1] < middle) != (segment[1][1] < middle)).collect();
        crossing.sort_by(|a, b| x_at(a, middle).total_cmp(&x_at(b, middle)));
        for pair in crossing.as_chunks::<2>().0 {
            let corner = |segment: &[[f64; 2]; 2], z: f64| [x_at(segment, z), z];
            trapezoids.push([
                corner(pair[0], slab[0]),
                corner(pair[1], slab[0]),
                corner(pair[1], slab[1]),
                corner(pair[0], slab[1]),
            ]);
        }
    }
    let all: Vec<[f64; 2]> = trapezoids.iter().flatten().copied().collect();
    let whole = hull(all);
    let area = trapezoids.iter().map(|trapezoid| area(trapezoid)).sum::<f64>();
    if self::area(&whole) <= area * (1.0 + 1e-9) {
        return convex(&whole).into_iter().collect();
    }
    trapezoids.iter().filter_map(|trapezoid| convex(&hull(trapezoid.to_vec()))).collect()
}

fn area(outline: &[[f64; 2]]) -> f64 {
    let next = outline.iter().cycle().skip(1);
    0.5 * outline.iter().zip(next).map(|(p, q)| p[0] * q[1] - q[0] * p[1]).sum::<f64>()
}

/// The half planes of a convex outline that runs counter-clockwise.
fn convex(outline: &[[f64; 2]]) -> Option<Convex> {
    let next = outline.iter().cycle().skip(1);
    let planes: Vec<HalfPlane> = outline.iter().zip(next).filter_map(|(&p, &q)| HalfPlane::below_line(p, q)).collect();
    (planes.len() >= 3 && area(outline) > 0.0).then_some(Convex { planes })
}

/// The convex hull, counter-clockwise (Andrew 1979).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    points.dedup();
    let turn = |p: &[f64; 2], q: &[f64; 2], r: &[f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let half = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., q, r] = chain.as_slice()
                && turn(q, r, p) <= 0.0
            {
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let (lower, upper) = (half(&mut points.iter()), half(&mut points.iter().rev()));
    [lower, upper].concat()
}
