//! A cutter that stands while the workpiece turns: its section through the workpiece's axis, as convex pieces.
//!
//! The workpiece turns many times while the cutter feeds, so what the cutter takes away is a body of revolution about the workpiece's axis: all
//! points whose distance ρ from the axis and place z along it are those of a point of the cutter. Two regions of (ρ, z) bound it. Sections of the cutter
//! are swept for sure: that with the plane of the axis, and of what cuts those at its ends beside the plane. The hull of its outline, widened by what points beside
//! the plane have a ρ greater than their x, holds all.
//!
//! A section at the distance y from the plane passes ρ = √((x + X)² + y²), with X the place of the cutter. Seen from the cutter, at ρ - X, its x is a concave function
//! of that, and grows with X: a tangent at the greatest X bounds it from above, and the greatest difference of the two, at the least X, from below.
//!
//! The widening, of each half plane a ρ + b z <= c of the hull. Take x from the axis. Points with x >= 0 are looked for at (ρ, z), all others at (-ρ, z), each in a hull of
//! their own. As ρ >= |x|, the former need no widening where a <= 0, and the latter none where a >= 0. For the rest let r = √(max(±x, 0)² + y²). It is ρ for the
//! points in question, and has a value for all. As the norm of convex functions that are nowhere negative, max(±x, 0) and |y|, r is convex in the point and X together. So is
//! the excess, in which r has the factor |a|. So no point in question is farther beyond than some corner, and along a way in x the chord between both ends bounds it.
//! Of a part on both sides of the axis, a second half plane is widened by |a| times the greatest |y|, which ρ - |x| does not exceed, and each hull ends at the least and greatest z of what is
//! ever on its side.
//!
//! If no point is nearer to the plane of the axis than h > 0, none has ρ < h. So a place at ρ < h is outside by h - ρ at least, and any other is at most ρ - h deep.

use super::convex::{Convex, HalfPlane, Least};
use crate::geometry::hull::Hull;
use crate::geometry::{Isometry, Mesh, Point, Vector};
use std::sync::Arc;

/// Heights nearer than this are one, mm.
const SAME_MM: f64 = 1e-7;
/// How far sections at the ends of a cutter are inside it, mm: a face may lie in the plane of the axis.
const INSIDE_MM: f64 = 1e-4;
/// A section this near to the plane of the axis, mm, counts as one in it, narrowed by as much.
const IN_PLANE_MM: f64 = 0.01;
/// Least part of the outline that a section beside the plane must fill to be kept.
const LEAST_PART: f64 = 0.1;

/// A cutter's section, x away from the axis, in the frame of the axis.
#[derive(Clone, Debug)]
pub(super) struct Turned {
    /// Convex pieces of (x, z), mm; their union is the section. None where the plane of the axis misses the cutter.
    section: Vec<Convex>,
    /// The same beside the plane, by their distances from it, mm, as outlines.
    beside_it: Vec<(f64, Vec<Outline>)>,
    /// The hull of the cutter's outline.
    hull: Option<Convex>,
    /// The corners of the same.
    outline: Outline,
    /// Half the least extent of the outline along the normals of its sides, mm.
    deepest: f64,
    /// Corners of the cutter's hull: what widens a plane is convex in the point, so that all others widen it less.
    corners: Vec<Point>,
    /// Largest distance from the plane, mm.
    beside: f64,
    /// Least distance from the plane, mm: no point comes nearer to the axis. Minus infinity where the part is in the plane or as near to it as a section that counts as in it.
    hole: f64,
}

/// Corners of a convex outline, (x, z), counter-clockwise, mm.
type Outline = Vec<[f64; 2]>;

/// Where a section is at first and how it goes, in (x, z), mm.
#[derive(Clone, Debug)]
pub(super) struct Shift {
    pub start: [f64; 2],
    pub travel: [f64; 2],
    /// The hull, widened by what is beside the plane, for what is on either side of the axis: 1 or -1.
    hulls: Vec<(f64, Widened)>,
    /// What the sections beside the plane pass for sure.
    beside_it: Arc<Vec<Convex>>,
}

/// A hull whose half planes move outwards along a way.
#[derive(Clone, Debug)]
struct Widened {
    convex: Convex,
    /// By how much `c` of each half plane grows from the beginning to the end, mm.
    growth: Vec<f64>,
}

impl Turned {
    /// The section of a mesh in the frame that `axis_from_part` leads to; its z is the axis, its x and z span the plane. What `cuts` has sections beside it.
    pub fn new(mesh: &Mesh, axis_from_part: &Isometry, cuts: bool) -> Self {
        let vertices: Vec<Point> = mesh.vertices().iter().map(|vertex| axis_from_part * vertex).collect();
        let range = |of: fn(&Point) -> f64| {
            let values = vertices.iter().map(of);
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        };
        let [[left, right], [near, far], [low, high]] = [range(|v| v.x), range(|v| v.y), range(|v| v.z)];
        let outline = hull(vertices.iter().map(|v| [v.x, v.z]).collect());
        // Its box as well: where two slanted half planes are widened, they meet beyond it.
        let of_box = [[1.0, 0.0, right], [-1.0, 0.0, -left], [0.0, 1.0, high], [0.0, -1.0, -low]];
        let hull = convex(&outline).map(|Convex { mut planes }| {
            planes.extend(of_box.map(|[a, b, c]| HalfPlane { a, b, c }));
            Convex { planes }
        });
        let beside = near.abs().max(far.abs());
        let section_at = |y: f64| {
            let above = |corner: u32| vertices[corner as usize] - Vector::new(0.0, y, 0.0);
            pieces(&mesh.faces().iter().filter_map(|face| cut(face.map(above))).collect::<Vec<_>>())
        };
        // What an open mesh fills nobody knows.
        let is_known = mesh.edge_report().is_watertight();
        let inset = INSIDE_MM.min(0.25 * (far - near));
        let ends = [near + inset, far - inset];
        let middle = 0.0_f64.clamp(ends[0], ends[1]);
        let is_met = is_known && middle.abs() <= IN_PLANE_MM;
        let narrowed = |plane: &mut HalfPlane| plane.c -= plane.a.abs() * middle.abs();
        let mut section: Vec<Convex> =
            if is_met { section_at(middle).iter().filter_map(|piece| convex(piece)).collect() } else { Vec::new() };
        section.iter_mut().flat_map(|piece| &mut piece.planes).for_each(narrowed);
        let least = if is_met { LEAST_PART * area(&outline) } else { 0.0 };
        let is_other = |y: &f64| !is_met || (y - middle).abs() > IN_PLANE_MM;
        let beside_it = ends.into_iter().filter(|_| is_known && cuts).filter(is_other).map(|y| (y, section_at(y)));
        let is_large = |(_, pieces): &(f64, Vec<Outline>)| pieces.iter().map(|piece| area(piece)).sum::<f64>() >= least;
        let beside_it = beside_it.filter(is_large).collect();
        let width =
            |HalfPlane { a, b, c }: &HalfPlane| outline.iter().map(|[x, z]| c - a * x - b * z).fold(0.0, f64::max);
        let widths = hull.iter().flat_map(|hull| &hull.planes).map(width);
        let apart = near.max(-far);
        let hole = if apart > IN_PLANE_MM { apart } else { f64::NEG_INFINITY };
        // Wherever the part is, some point of it is at least this far from the axis. Where none is farther, no place is deeper than half the way from there to the hole.
        let reach = beside.max(0.5 * (right - left));
        let deepest = 0.5 * widths.fold(reach - hole, f64::min);
        let corners = match Hull::of(vertices.iter()) {
            Some(Hull::Solid(solid)) => solid.vertices,
            _ => vertices,
        };
        Self { section, beside_it, hull, outline, deepest, corners, beside, hole }
    }

    /// The same without a section.
    pub fn vague(&self) -> Self {
        Self { section: Vec::new(), beside_it: Vec::new(), ..self.clone() }
    }

    /// How deep a point can be in the section at most, mm.
    pub const fn deepest_mm(&self) -> f64 {
        self.deepest
    }

    /// Whether nothing is swept for sure: its mesh is open, or it does not cut and the plane of the axis misses it.
    pub const fn is_empty(&self) -> bool {
        self.section.is_empty() && self.beside_it.is_empty()
    }

    /// A way from `start` to `start + travel`.
    pub fn shift(&self, start: [f64; 2], travel: [f64; 2]) -> Shift {
        let ways = [start[0], start[0] + travel[0]];
        let range = [ways[0].min(ways[1]), ways[0].max(ways[1])];
        let hulls = self.hull.iter().flat_map(|hull| self.widened(hull, ways, range)).collect();
        let passed = |(y, pieces): &(f64, Vec<Outline>)| {
            pieces.iter().filter_map(|piece| passed(piece, *y, range)).collect::<Vec<_>>()
        };
        Shift { start, travel, hulls, beside_it: Arc::new(self.beside_it.iter().flat_map(passed).collect()) }
    }

    /// For each side of the axis on which some of the cutter is, the hull with all of that in it, on the way from one `x` to another: beside the plane ρ exceeds x the more, the
    /// nearer the axis is.
    fn widened(&self, hull: &Convex, ways: [f64; 2], [least, most]: [f64; 2]) -> Vec<(f64, Widened)> {
        let heights = [(1.0, -most), (-1.0, -least)].map(|(side, x)| (side, heights_beyond(&self.outline, x, side)));
        let crosses = heights.iter().all(|(_, heights)| heights.is_some());
        let of_side = |(side, heights): (f64, Option<[f64; 2]>)| {
            let [low, high] = heights?;
            let by = |&HalfPlane { a, b, c }: &HalfPlane| {
                let beyond = |x: f64| {
                    let of = |v: &Point| a * (side * (side * (v.x + x)).max(0.0).hypot(v.y) - x) + b * v.z - c;
                    self.corners.iter().map(of).fold(0.0, f64::max)
                };
                match side * a > 0.0 {
                    true if crosses => vec![ways.map(beyond), [a.abs() * self.beside; 2]],
                    true => vec![ways.map(beyond)],
                    false => vec![[0.0; 2]],
                }
            };
            let ends = [(1.0, high), (-1.0, -low)].map(|(b, c)| (HalfPlane { a: 0.0, b, c }, 0.0));
            let widened = |plane: &HalfPlane| {
                let HalfPlane { a, b, c } = *plane;
                by(plane).into_iter().map(move |[first, last]| (HalfPlane { a, b, c: c + first }, last - first))
            };
            let ends = ends.into_iter().filter(|_| crosses);
            let (planes, growth) = hull.planes.iter().flat_map(widened).chain(ends).unzip();
            Some((side, Widened { convex: Convex { planes }, growth }))
        };
        heights.into_iter().filter_map(of_side).collect()
    }

    /// Linear functions of (ρ, 0, z) below the excess, one for each side of the axis: values at a point, and gradients. They leave the hole out.
    pub fn tangents(&self, rho: f64, z: f64, shift: &Shift) -> impl Iterator<Item = (f64, Vector)> {
        shift.hulls.iter().map(move |(side, hull)| {
            let OnLine { low, normal: [a, b], .. } = hull.least(shift.seen(side * rho, z), shift.travel);
            (low, Vector::new(side * a, 0.0, b))
        })
    }

    /// The piece of a section that comes nearest to a point (ρ, z), or holds it the deepest, and where on the way it does, 0 to 1.
    pub fn nearest<'a>(&'a self, rho: f64, z: f64, shift: &'a Shift) -> Option<(&'a Convex, f64)> {
        let of = |piece| (piece, OnLine::least(piece, shift.seen(rho, z), shift.travel));
        let nearest = self.sections(shift).map(of).min_by(|(_, a), (_, b)| a.high.total_cmp(&b.high));
        nearest.map(|(piece, found)| (piece, found.at))
    }

    /// What is swept for sure.
    fn sections<'a>(&'a self, shift: &'a Shift) -> impl Iterator<Item = &'a Convex> {
        self.section.iter().chain(&*shift.beside_it)
    }

    /// As [`Convex::lowest`], of a point (ρ, z) and all that are as near as `ring` says.
    pub fn least(&self, rho: f64, z: f64, shift: &Shift, [across, along]: [f64; 2]) -> Least {
        let of = |piece: &Convex, side: f64| OnLine::least(piece, shift.seen(side * rho, z), shift.travel);
        let mut found = Least { low: f64::INFINITY, high: f64::INFINITY, deep: f64::INFINITY };
        for (side, hull) in &shift.hulls {
            let OnLine { low, normal: [a, b], .. } = hull.least(shift.seen(side * rho, z), shift.travel);
            let spread = a.abs() * across + b.abs() * along;
            (found.low, found.deep) = (found.low.min(low), found.deep.min(low - spread));
        }
        found.low = found.low.max(self.hole - rho);
        found.deep = found.deep.max(self.hole - rho - across);
        // What is outside is not asked whether it is inside.
        if found.deep < 0.0 {
            let highs = self.sections(shift).map(|piece| of(piece, 1.0).high.min(of(piece, -1.0).high));
            found.high = highs.fold(f64::INFINITY, f64::min);
        }
        found
    }
}

impl Shift {
    /// The part of the way from one part to another, 0 to 1.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let (start, travel) = (self.at(from), self.travel.map(|d| d * (to - from)));
        let hulls = self.hulls.iter().map(|(side, hull)| (*side, hull.part(from, to))).collect();
        Self { start, travel, hulls, beside_it: Arc::clone(&self.beside_it) }
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

impl Widened {
    /// Along a part of the way, 0 to 1.
    fn part(&self, from: f64, to: f64) -> Self {
        let planes = self.convex.planes.iter().zip(&self.growth);
        let planes = planes.map(|(plane, growth)| HalfPlane { c: plane.c + growth * from, ..*plane }).collect();
        Self { convex: Convex { planes }, growth: self.growth.iter().map(|growth| growth * (to - from)).collect() }
    }

    fn least(&self, q: [f64; 2], travel: [f64; 2]) -> OnLine {
        OnLine::of(&self.convex.planes.iter().zip(self.growth.iter().copied()), q, travel)
    }
}

/// The least and the greatest z of an outline on a side of x; `None` where nothing of it is there.
fn heights_beyond(outline: &[[f64; 2]], x: f64, side: f64) -> Option<[f64; 2]> {
    let above = |corner: &[f64; 2]| side * (corner[0] - x);
    let next = outline.iter().cycle().skip(1);
    let met = outline.iter().zip(next).filter(|(p, q)| above(p) * above(q) < 0.0);
    let met = met.map(|(p, q)| p[1] + (q[1] - p[1]) * (above(p) / (above(p) - above(q))));
    let there = outline.iter().filter(|corner| above(corner) >= 0.0).map(|corner| corner[1]);
    there
        .chain(met)
        .fold(None, |ends: Option<[f64; 2]>, z| Some(ends.map_or([z, z], |[low, high]| [low.min(z), high.max(z)])))
}

/// What a section beside the plane passes for sure, y from it, its place X in a range: in (ρ - X, z).
fn passed(outline: &Outline, y: f64, [least, most]: [f64; 2]) -> Option<Convex> {
    let xs = outline.iter().map(|corner| corner[0]);
    let [left, right] = xs.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    // What is on the other side of the axis is left out.
    let left = left.max(-least);
    if left + SAME_MM >= right {
        return None;
    }
    let (first, last) = ((left + least).hypot(y) - least, (right + most).hypot(y) - most);
    let (exceeds, slope) = (first - left, (right + most).hypot(y) / (right + most));
    let seen = |HalfPlane { a, b, c }: HalfPlane| {
        if a <= 0.0 {
            return HalfPlane { a, b, c: c + a * exceeds };
        }
        let length = (a * slope).hypot(b);
        HalfPlane { a: a * slope / length, b: b / length, c: (c + a * (slope * last - right)) / length }
    };
    let mut planes: Vec<HalfPlane> = convex(outline)?.planes.into_iter().map(seen).collect();
    planes.push(HalfPlane { a: -1.0, b: 0.0, c: -first });
    Some(Convex { planes })
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
        Self::of(&piece.planes.iter().map(|plane| (plane, 0.0)), q, travel)
    }

    /// Of half planes and by how much `c` of each grows along the way.
    fn of<'a>(
        planes: &(impl ExactSizeIterator<Item = (&'a HalfPlane, f64)> + Clone),
        q: [f64; 2],
        travel: [f64; 2],
    ) -> Self {
        let greatest = |at: f64| {
            let of = |(plane, growth): (&HalfPlane, f64)| {
                let slope = -(plane.a * travel[0] + plane.b * travel[1] + growth);
                let value = plane.a * q[0] + plane.b * q[1] - plane.c + slope * at;
                Greatest { at, value, slope, normal: [plane.a, plane.b] }
            };
            let nothing = Greatest { at, value: f64::INFINITY, slope: 0.0, normal: [0.0; 2] };
            planes.clone().map(of).reduce(|a, b| if b.value > a.value { b } else { a }).unwrap_or(nothing)
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
        let mut steps = 2 * planes.len();
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
fn pieces(segments: &[[[f64; 2]; 2]]) -> Vec<Outline> {
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
        return vec![whole];
    }
    trapezoids.iter().map(|trapezoid| hull(trapezoid.to_vec())).collect()
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

/// The convex hull, counter-clockwise.
fn hull(mut points: Vec<[f64; 2]>) -> Outline {
    points.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    points.dedup();
    let turn = |p: &[f64; 2], q: &[f64; 2], r: &[f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    crate::geometry::hull::around(&points, turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::{Shape, Tessellation};
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    const HALF_MM: [f64; 3] = [4.0, 2.0, 3.0];

    #[test]
    fn a_slanted_blade_is_as_thin_as_an_upright_one() {
        let shape: Shape = toml::from_str("kind = \"rounded-box\"\nsize_mm = [8, 4, 0.6]").unwrap();
        let mesh = shape.mesh(&Tessellation::default()).unwrap();
        for turn in [0.0, 0.8, 1.5] {
            let turn = UnitQuaternion::from_euler_angles(0.0, turn, 0.0);
            let turned = Turned::new(&mesh, &Isometry::from_parts(Vector::zeros().into(), turn), false);
            assert!((turned.deepest_mm() - 0.3).abs() < 1e-6, "{}", turned.deepest_mm());
        }
    }

    fn cuboid(at: [f64; 3]) -> Turned {
        let shape: Shape = toml::from_str("kind = \"rounded-box\"\nsize_mm = [8, 4, 6]").unwrap();
        let mesh = shape.mesh(&Tessellation::default()).unwrap();
        Turned::new(&mesh, &Isometry::translation(at[0], at[1], at[2]), true)
    }

    #[test]
    fn beside_the_plane_no_point_is_nearer_to_the_axis_than_the_plane_is() {
        for (beside, hole) in [(2.05, 0.05), (-2.05, 0.05), (5.0, 3.0), (1.0, f64::NEG_INFINITY)] {
            // From x = -0.8 to 7.2 at the end of the way.
            let turned = cuboid([4.0, beside, 0.0]);
            let shift = turned.shift([20.0, 0.0], [-20.8, 0.0]);
            for rho in [0.0, 0.02, 1.0, 2.9] {
                let found = turned.least(rho, 0.0, &shift, [0.01, 0.01]);
                let is_held = found.low >= hole - rho - 1e-9 && found.deep >= hole - rho - 0.01 - 1e-9;
                assert!(is_held, "{beside} {rho}: {found:?}");
                assert!(found.high >= found.low, "{beside} {rho}: {found:?}");
                assert_eq!(found.low < 0.0, rho > hole, "{beside} {rho}: {found:?}");
            }
        }
        // 10 to 14.56 mm from the axis where its middle is over the axis.
        assert_eq!(cuboid([0.0, 12.0, 0.0]).deepest_mm(), 2.0);
    }

    #[test]
    fn on_the_other_side_of_the_axis_nothing_is_farther_than_its_corners() {
        // From x = -6 to 2 at first, and then away from the axis and from the place.
        let turned = cuboid([-4.0, 0.0, 0.0]);
        let shift = turned.shift([2.0, 0.0], [98.0, 200.0]);
        let greatest = 6f64.hypot(2.0);
        for rho in [greatest - 0.1, greatest + 0.1, 7.0, 9.0] {
            let found = turned.least(rho, 0.0, &shift, [0.0; 2]);
            assert!((found.low - (rho - greatest)).abs() < 0.01, "{rho}: {found:?}");
        }
    }

    #[test]
    fn what_is_all_on_one_side_of_the_axis_is_as_far_from_it_on_the_other() {
        // From x = -8 to 0 about its place: between 60 and 70 mm behind the axis.
        let turned = cuboid([-4.0, 0.0, 0.0]);
        let shift = turned.shift([-62.0, 0.0], [2.0, 0.0]);
        for (rho, expected) in [(20.0, 40.0), (59.0, 1.0), (72.0, 1.9)] {
            let found = turned.least(rho, 0.0, &shift, [0.0; 2]);
            assert!((found.low - expected).abs() < 0.1, "{rho}: {found:?}");
        }
    }

    #[test]
    fn an_edge_that_leans_towards_the_face_cuts_no_deeper_past_the_axis() {
        // A box leaning by 5 degrees, its lower edge the lower the farther out, whose corner is 0.8 mm past the axis: at the axis nothing is below that edge there.
        let shape: Shape = toml::from_str("kind = \"rounded-box\"\nsize_mm = [12, 8, 10]").unwrap();
        let mesh = shape.mesh(&Tessellation::default()).unwrap();
        let leaning = UnitQuaternion::from_euler_angles(0.0, 5_f64.to_radians(), 0.0);
        let corner = leaning * Vector::new(-6.0, 0.0, -5.0);
        let turned = Turned::new(&mesh, &Isometry::from_parts((-corner).into(), leaning), true);
        let shift = turned.shift([-0.8, 0.0], [0.0, 2.0]);
        let at_axis = -0.8 * 5_f64.to_radians().tan();
        for below in [0.05, 0.5] {
            let found = turned.least(0.0, at_axis - below, &shift, [0.0; 2]);
            assert!(found.low >= 0.9 * below, "{below}: {found:?}");
        }
        assert!(turned.least(0.0, at_axis + 0.05, &shift, [0.0; 2]).high < 0.0);
    }

    proptest! {
        /// Of a box anywhere beside an axis, on any way in x: its points are in the hull, and what the sections hold is passed at that place.
        #[test]
        fn the_hull_holds_the_body_and_the_body_passes_what_sections_hold(
            turns in prop::array::uniform3(-1.6..1.6f64),
            is_upright in any::<bool>(),
            beside in -4.0..4.0f64,
            way in prop::array::uniform2(-8.0..30.0f64),
            at in 0.0..1.0f64,
            share in prop::array::uniform3(-1.0..1.0f64),
            seen in prop::array::uniform2(0.0..1.0f64),
        ) {
            let shape: Shape = toml::from_str("kind = \"rounded-box\"\nsize_mm = [8, 4, 6]").unwrap();
            let mesh = shape.mesh(&Tessellation::default()).unwrap();
            let turn = if is_upright { UnitQuaternion::identity() } else { UnitQuaternion::from_euler_angles(turns[0], turns[1], turns[2]) };
            let axis_from_part = Isometry::from_parts(Vector::new(0.0, beside, 0.0).into(), turn);
            let turned = Turned::new(&mesh, &axis_from_part, true);
            prop_assert!(!turned.is_empty());
            let shift = turned.shift([way[0], 0.0], [way[1] - way[0], 0.0]).part(at, at);
            let x = shift.start[0];
            let point = axis_from_part * Point::from(Vector::from_fn(|k, _| share[k] * HALF_MM[k]));
            let found = turned.least((point.x + x).hypot(point.y), point.z, &shift, [0.0; 2]);
            prop_assert!(found.low <= 1e-9, "{found:?}");
            let (rho, z) = ((x.abs() + 12.0) * seen[0], 12.0 * seen[1] - 6.0);
            if turned.least(rho, z, &shift, [0.0; 2]).high <= 0.0 {
                // How far the nearest point of the circle is from the box.
                let outside = |k: u32| {
                    let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 20_000.0).sin_cos();
                    let at = axis_from_part.inverse() * Point::new(rho * cos - x, rho * sin, z);
                    (0..3).map(|axis| at[axis].abs() - HALF_MM[axis]).fold(f64::NEG_INFINITY, f64::max)
                };
                let nearest = (0..20_000).map(outside).fold(f64::INFINITY, f64::min);
                prop_assert!(nearest <= 0.02, "{nearest} at {rho} {z}");
            }
        }
    }
}
