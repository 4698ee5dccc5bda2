//! A cutter that stands while the workpiece turns: its section through the workpiece's axis, as convex pieces.
//!
//! The workpiece turns many times while the cutter feeds, so what the cutter takes away is a body of revolution about the workpiece's axis: all
//! points whose distance ρ from the axis and place z along it are those of a point of the cutter. Two regions of (ρ, z) bound it. The section of the cutter
//! with the plane of the axis is swept for sure. The hull of its outline, widened by what points beside the plane have a ρ greater than their x, holds all.
//!
//! The widening. A half plane's excess is a linear function, so the greatest excess over the hull's is convex. For a point p of a triangle
//! ρ(p) is between |x(p)| and the mixture of the corners' ρ, as the norm is convex. Where x(p) >= 0, the first is in the hull, so p exceeds it by no more than some
//! corner at (ρ, z) does. Where x(p) < 0 the same holds of (-ρ, z), and ρ - |x| is at most |y|.

use super::convex::{Convex, HalfPlane, Least};
use crate::geometry::{Isometry, Mesh, Point};

/// Heights nearer than this are one, mm.
const SAME_MM: f64 = 1e-7;

/// A cutter's section, x away from the axis, in the frame of the axis.
#[derive(Clone, Debug)]
pub(super) struct Turned {
    /// Convex pieces of (x, z), mm; their union is the section. None where the plane of the axis misses the cutter.
    section: Vec<Convex>,
    /// The hull of the cutter's outline.
    hull: Option<Convex>,
    vertices: Vec<Point>,
    /// Largest distance from the plane, mm.
    beside: f64,
}

/// Where a section is at first and how it goes, in (x, z), mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shift {
    pub start: [f64; 2],
    pub travel: [f64; 2],
    /// How far the cutter's points come out of its hull, mm.
    pub excess: f64,
}

impl Turned {
    /// The section of a mesh in the frame that `axis_from_part` leads to; its z is the axis, its x and z span the plane.
    pub fn new(mesh: &Mesh, axis_from_part: &Isometry) -> Self {
        let vertices: Vec<Point> = mesh.vertices().iter().map(|vertex| axis_from_part * vertex).collect();
        let segments: Vec<[[f64; 2]; 2]> =
            mesh.faces().iter().filter_map(|face| cut(face.map(|corner| vertices[corner as usize]))).collect();
        let hull = convex(&hull(vertices.iter().map(|v| [v.x, v.z]).collect()));
        let beside = vertices.iter().map(|v| v.y.abs()).fold(0.0, f64::max);
        Self { section: pieces(&segments), hull, vertices, beside }
    }

    /// A way from `start` to `start + travel`.
    pub fn shift(&self, start: [f64; 2], travel: [f64; 2]) -> Shift {
        Shift { start, travel, excess: self.excess(start[0].min(start[0] + travel[0])) }
    }

    /// How far points of the cutter come out of its hull, mm, when it is moved by `x` or more: beside the plane ρ exceeds x the more, the nearer the axis is.
    fn excess(&self, x: f64) -> f64 {
        let Some(hull) = &self.hull else { return 0.0 };
        let over = |side: f64| {
            let of = |v: &Point| hull.excess(side * (v.x + x).hypot(v.y) - x, v.z);
            self.vertices.iter().map(of).fold(0.0, f64::max)
        };
        let crosses = self.vertices.iter().any(|v| v.x + x < 0.0);
        over(1.0).max(if crosses { over(-1.0).min(self.beside) } else { 0.0 })
    }

    /// As [`Convex::least`], of a point (ρ, z).
    pub fn least(&self, rho: f64, z: f64, shift: &Shift, radius: f64) -> Least {
        let on_both = |piece: &Convex| {
            let of = |side: f64| least_on_line(piece, [side - shift.start[0], z - shift.start[1]], shift.travel);
            let (one, other) = (of(rho), of(-rho));
            (one.0.min(other.0), one.1.min(other.1))
        };
        let low = self.hull.as_ref().map_or(f64::INFINITY, |hull| on_both(hull).0) - shift.excess;
        let deep = low - radius;
        // What is outside is not asked whether it is inside.
        let high = if deep >= 0.0 { None } else { self.section.iter().map(|piece| on_both(piece).1).reduce(f64::min) };
        Least { low, high: high.unwrap_or(f64::INFINITY), deep }
    }
}

/// The least of the greatest of linear functions along a way: bounds that rounding alone parts.
fn least_on_line(piece: &Convex, q: [f64; 2], travel: [f64; 2]) -> (f64, f64) {
    let line = |plane: &HalfPlane| {
        let value = plane.a * q[0] + plane.b * q[1] - plane.c;
        (value, -(plane.a * travel[0] + plane.b * travel[1]))
    };
    let at = |t: f64| {
        let of = |plane: &HalfPlane| {
            let (value, slope) = line(plane);
            (value + slope * t, slope)
        };
        piece.planes.iter().map(of).reduce(|a, b| if b.0 > a.0 { b } else { a }).unwrap_or((f64::INFINITY, 0.0))
    };
    let (mut low, mut high) = ((0.0, at(0.0)), (1.0, at(1.0)));
    if low.1.1 >= 0.0 {
        return (low.1.0, low.1.0);
    }
    if high.1.1 <= 0.0 {
        return (high.1.0, high.1.0);
    }
    // Each step drops one of finitely many lines.
    for _ in 0..2 * piece.planes.len() {
        let ((t, (v, s)), (u, (w, r))) = (low, high);
        let meet = ((v - s * t) - (w - r * u)) / (r - s);
        let bound = v + s * (meet - t);
        let found = at(meet.clamp(t, u));
        if found.0 <= bound + 1e-12 || found.1 == 0.0 {
            return (bound.min(found.0), found.0);
        }
        if found.1 < 0.0 {
            low = (meet, found);
        } else {
            high = (meet, found);
        }
    }
    let ((t, (v, s)), (u, (w, r))) = (low, high);
    let meet = ((v - s * t) - (w - r * u)) / (r - s);
    (v + s * (meet - t), at(meet).0)
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
