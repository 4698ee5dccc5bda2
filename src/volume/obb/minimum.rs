//! Axes of the box of least volume.
//!
//! J. O'Rourke, "Finding Minimal Enclosing Boxes", 1985: each of two neighbouring faces of the smallest box around a convex solid
//! contains an edge of it. (Seen along any face's normal the box is a smallest rectangle, one of whose sides contains
//! an edge.) So for every pair of edges the box whose faces contain them turns about one parameter. Deviations: O'Rourke
//! solves a polynomial on every stretch between changes of contact; here each pair's family is searched by branch and
//! bound, because a width changes by no more than the solid's diameter times the angle. Pairs that no box can have are
//! discarded as in J. Jylänki, "An Exact Algorithm for Finding Minimum Oriented Bounding Boxes", 2015, whose further conjecture
//! is not used.
//!
//! What is promised: up to [`EXACT_VERTICES`] hull vertices and [`MAX_STEPS`] steps, no box is smaller by more than the part
//! [`TOLERANCE`]. With more vertices the search sees the extreme ones along [`EXACT_VERTICES`] directions; of contents
//! thinner than [`FLAT`] it tries only boxes with a face in a face or an edge along an edge. In every case the result is
//! improved until no turn about one of its axes makes it smaller, and is no larger than the boxes along the axes of all
//! other rules, which the search begins with. Volume is that of the box as it is stored, with its pad, so that flat contents
//! are told apart by their area.

use super::super::separating_axes::pad_mm;
use super::dito::Dito14;
use super::frame::{AreaCovariance, FrameRule, HullAreaCovariance, VertexCovariance, any_frame, reach_mm};
use crate::geometry::hull::{Edge, Hull, Solid};
use crate::geometry::{Point, Triangle, Vector, covariance, rectangle, triangle};
use nalgebra::Matrix3;

/// The search may end with a box that is larger than the smallest by this part.
pub const TOLERANCE: f64 = 1e-3;
/// Most hull vertices that are searched exactly.
pub const EXACT_VERTICES: usize = 400;
/// Most boxes the branch and bound looks at.
pub const MAX_STEPS: u32 = 200_000;

/// Contents thinner than this part of their diameter count as flat: the smallest box leans against their plane, and the branch and
/// bound would have to tell angles of this size apart.
pub const FLAT: f64 = 1e-6;

/// An improvement by less than this part is rounding.
const PROGRESS: f64 = 1e-12;
/// Shorter stretches of the parameter are not divided, rad: where an axis is nearly along the other edge the frame turns too
/// fast for the bound, and the frames there are tried by themselves.
const SHORTEST: f64 = 1e-7;

/// Axes of the smallest box.
#[derive(Clone, Copy, Debug)]
pub struct MinimumVolume;

impl FrameRule for MinimumVolume {
    /// The mean is that of the corners.
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, _) = covariance::vertex_weighted(triangles);
        let pad = pad_mm(reach_mm(triangles));
        let axes = match Hull::of(triangle::corners(triangles)) {
            None | Some(Hull::Point(_)) => Matrix3::identity(),
            Some(Hull::Segment([p, q])) => any_frame(&(q - p)),
            Some(Hull::Polygon(corners)) => of_polygon(&corners, pad),
            Some(Hull::Solid(solid)) => of_solid(triangles, &solid, pad),
        };
        (mean, axes)
    }
}

/// The frame of a polygon: its plane's, turned to its smallest rectangle.
fn of_polygon(corners: &[Point], pad: f64) -> Matrix3<f64> {
    let fan = corners.windows(2).skip(1).map(|pair| (pair[0] - corners[0]).cross(&(pair[1] - corners[0])));
    let frame = any_frame(&fan.sum());
    let mut search = Search::new(corners.iter(), pad);
    search.turn_about(&frame, 0);
    search.best.1
}

fn of_solid(triangles: &[Triangle], solid: &Solid, pad: f64) -> Matrix3<f64> {
    let mut search = Search::new(solid.vertices.iter(), pad);
    for axes in [
        VertexCovariance::mean_and_axes(triangles).1,
        AreaCovariance::mean_and_axes(triangles).1,
        HullAreaCovariance::mean_and_axes(triangles).1,
        Dito14::mean_and_axes(triangles).1,
    ] {
        search.offer(&axes);
    }
    search.descend();
    if solid.vertices.len() <= EXACT_VERTICES {
        search.all_boxes(solid);
    } else if let Some(Hull::Solid(coarse)) = Hull::of(extreme_vertices(solid).iter()) {
        let mut on_coarse = Search::new(coarse.vertices.iter(), pad);
        on_coarse.offer(&search.best.1);
        on_coarse.all_boxes(&coarse);
        search.offer(&on_coarse.best.1);
        search.descend();
    }
    search.best.1
}

/// The extreme vertices along [`EXACT_VERTICES`] directions that a golden spiral spreads over the sphere.
fn extreme_vertices(solid: &Solid) -> Vec<Point> {
    let direction = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / EXACT_VERTICES as f64;
        let turn = i as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let radius = (1.0 - z * z).sqrt();
        Vector::new(radius * turn.cos(), radius * turn.sin(), z)
    };
    let extreme = |d: Vector| {
        let height = |p: &&Point| d.dot(&p.coords);
        solid.vertices.iter().max_by(|p, q| height(p).total_cmp(&height(q))).copied()
    };
    (0..EXACT_VERTICES).filter_map(|i| extreme(direction(i))).collect()
}

/// The search for the best box around some points.
struct Search {
    /// About their middle, mm.
    points: Vec<Vector>,
    pad: f64,
    /// No two points are farther apart, mm.
    diameter: f64,
    /// Volume with pad, mm³, and axes.
    best: (f64, Matrix3<f64>),
    steps: u32,
}

impl Search {
    /// Begins with the coordinate axes.
    fn new<'a>(points: impl Iterator<Item = &'a Point> + Clone, pad: f64) -> Self {
        let (low, high) = points.clone().fold((None, None), |(low, high): (Option<Point>, Option<Point>), p| {
            (Some(low.map_or(*p, |l| l.inf(p))), Some(high.map_or(*p, |h| h.sup(p))))
        });
        let (low, high) = (low.unwrap_or_else(Point::origin), high.unwrap_or_else(Point::origin));
        let middle = nalgebra::center(&low, &high);
        let points: Vec<Vector> = points.map(|p| p - middle).collect();
        let radius = points.iter().map(Vector::norm).fold(0.0, f64::max);
        let mut search = Self {
            points,
            pad,
            diameter: (2.0 * radius).min((high - low).norm()),
            best: (f64::INFINITY, Matrix3::identity()),
            steps: 0,
        };
        search.offer(&Matrix3::identity());
        search
    }

    /// Extents along the columns of `axes`, with pad, mm.
    fn widths(&self, axes: &Matrix3<f64>) -> Vector {
        let (mut low, mut high) = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        for p in &self.points {
            let x = axes.tr_mul(p);
            (low, high) = (low.inf(&x), high.sup(&x));
        }
        (high - low).add_scalar(2.0 * self.pad)
    }

    /// Keeps the axes if their box is the smallest yet. Returns whether it is.
    fn offer(&mut self, axes: &Matrix3<f64>) -> bool {
        let volume = self.widths(axes).product();
        let is_better = volume < self.best.0 * (1.0 - PROGRESS);
        if is_better {
            self.best = (volume, *axes);
        }
        is_better
    }

    /// Offers `axes` turned about one of its columns to the smallest rectangle seen along it.
    fn turn_about(&mut self, axes: &Matrix3<f64>, column: usize) -> bool {
        let (n, u, v) = (axes.column(column), axes.column((column + 1) % 3), axes.column((column + 2) % 3));
        let seen: Vec<[f64; 2]> = self.points.iter().map(|p| [u.dot(p), v.dot(p)]).collect();
        let Some(found) = rectangle::smallest(&seen, self.pad) else { return false };
        let along = (u * found.along[0] + v * found.along[1]).normalize();
        self.offer(&Matrix3::from_columns(&[along, n.cross(&along), n.into_owned()]))
    }

    /// Turns the best box about its own axes until that makes it no smaller.
    fn descend(&mut self) {
        /// More rounds than any contents have needed; a bound, so that rounding cannot go round in circles.
        const ROUNDS: u32 = 50;
        for _ in 0..ROUNDS {
            let before = self.best.0;
            for column in 0..3 {
                let axes = self.best.1;
                self.turn_about(&axes, column);
            }
            if self.best.0 >= before {
                return;
            }
        }
    }

    /// Every box that can be the smallest around the solid whose vertices the points are.
    fn all_boxes(&mut self, solid: &Solid) {
        let normals = solid.normals();
        let edges = solid.edges();
        // A face of the box in a face of the solid; and an edge of the box along an edge of the solid.
        let faces: Vec<Vector> = distinct(edges.iter().flat_map(|edge| edge.faces.map(|face| normals[face as usize])));
        let alongs = distinct(edges.iter().filter_map(|edge| (edge.ends[1] - edge.ends[0]).try_normalize(0.0)));
        for axis in faces.iter().chain(&alongs) {
            if self.shadow(solid, axis) * self.width(axis) < self.best.0 && self.turn_about(&any_frame(axis), 0) {
                self.descend();
            }
        }
        if faces.iter().any(|axis| self.width(axis) - 2.0 * self.pad < FLAT * self.diameter) {
            return;
        }
        let arcs: Vec<Arc> = edges.iter().filter_map(|edge| Arc::new(edge, &normals)).collect();
        for (i, moving) in arcs.iter().enumerate() {
            for other in &arcs[i + 1..] {
                for (low, high) in moving.meets(other).into_iter().flatten() {
                    self.branch_and_bound(moving, other, low, high);
                }
            }
        }
    }

    fn width(&self, axis: &Vector) -> f64 {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in &self.points {
            let x = axis.dot(p);
            (low, high) = (low.min(x), high.max(x));
        }
        high - low + 2.0 * self.pad
    }

    /// Area of the solid seen along `axis`, mm²: no rectangle around it is smaller.
    fn shadow(&self, solid: &Solid, axis: &Vector) -> f64 {
        let both_sides: f64 =
            (0..solid.faces.len()).map(|face| solid.triangle(face).double_area_normal().dot(axis).abs()).sum();
        both_sides / 4.0
    }

    /// The smallest box with one normal on `moving` at an angle in [low, high] and one on `other`.
    fn branch_and_bound(&mut self, moving: &Arc, other: &Arc, low: f64, high: f64) {
        let mut open = vec![(low, high)];
        while let Some((low, high)) = open.pop() {
            if self.steps >= MAX_STEPS {
                return;
            }
            self.steps += 1;
            let (middle, half) = (f64::midpoint(low, high), 0.5 * (high - low));
            let normal = moving.at(middle);
            let Some(second) = other.edge.cross(&normal).try_normalize(SHORTEST) else { continue };
            let axes = Matrix3::from_columns(&[normal, second, normal.cross(&second)]);
            let widths = self.widths(&axes);
            if widths.product() < self.best.0 * (1.0 - PROGRESS) {
                self.best = (widths.product(), axes);
                self.descend();
            }
            // Turning the first normal by x turns the second by no more than x |e1·e2| / (1 - (n1·e2)²), and the third by
            // no more than the sum of both.
            let toward = (normal.dot(&other.edge).abs() + half).min(1.0);
            let rate = moving.edge.dot(&other.edge).abs() / (1.0 - toward * toward).max(f64::MIN_POSITIVE);
            let shrink = Vector::new(1.0, rate, 1.0 + rate) * (self.diameter * half);
            let least = (widths - shrink).sup(&Vector::repeat(2.0 * self.pad)).product();
            if least < self.best.0 * (1.0 - TOLERANCE) && half > SHORTEST {
                open.extend([(low, middle), (middle, high)]);
            }
        }
    }
}

/// The unit vectors without those that are the same or opposite to rounding.
fn distinct(vectors: impl Iterator<Item = Vector>) -> Vec<Vector> {
    /// 1 - cos of 1e-7 rad is 5e-15.
    const SAME: f64 = 5e-15;
    let mut kept: Vec<Vector> = Vec::new();
    for v in vectors {
        if kept.iter().all(|k| k.dot(&v).abs() < 1.0 - SAME) {
            kept.push(v);
        }
    }
    kept
}

/// The outward normals of planes that touch the solid along one edge: a great-circle arc between the normals of the
/// edge's two faces.
struct Arc {
    ends: [Vector; 2],
    /// Unit tangent at the first end, toward the second.
    tangent: Vector,
    /// Unit direction of the edge: the arc's axis.
    edge: Vector,
    /// rad, below π.
    angle: f64,
}

impl Arc {
    /// `None` when the two normals are the same to rounding.
    fn new(edge: &Edge, normals: &[Vector]) -> Option<Self> {
        let [from, to] = edge.faces.map(|face| normals[face as usize]);
        let tangent = (to - from * from.dot(&to)).try_normalize(1e-12)?;
        Some(Self {
            ends: [from, to],
            tangent,
            edge: from.cross(&tangent),
            angle: tangent.dot(&to).atan2(from.dot(&to)),
        })
    }

    fn at(&self, angle: f64) -> Vector {
        let (sin, cos) = angle.sin_cos();
        self.ends[0] * cos + self.tangent * sin
    }

    /// The angles on this arc at which `other` has a normal perpendicular to this one's: those at which the other's two ends are on
    /// different sides of the plane perpendicular to it. At most two stretches.
    fn meets(&self, other: &Self) -> [Option<(f64, f64)>; 2] {
        /// Perpendicular to rounding counts as perpendicular.
        const ROUNDING: f64 = 1e-12;
        let sides = self.ends.map(|n| other.ends.map(|m| n.dot(&m)));
        let all = sides.as_flattened();
        if all.iter().all(|&x| x > ROUNDING) || all.iter().all(|&x| x < -ROUNDING) {
            return [None; 2];
        }
        // m·n(φ) = (m·n0) cos φ + (m·t) sin φ changes sign at most once in less than half a turn.
        let zero = |m: &Vector| {
            let angle = (-m.dot(&self.ends[0])).atan2(m.dot(&self.tangent));
            let angle = if angle < 0.0 { angle + std::f64::consts::PI } else { angle };
            angle.min(self.angle)
        };
        let [z0, z1] = [zero(&other.ends[0]), zero(&other.ends[1])];
        let cuts = [0.0, z0.min(z1), z0.max(z1), self.angle];
        let stretch = |i: usize| {
            let n = self.at(f64::midpoint(cuts[i], cuts[i + 1]));
            let opposite = n.dot(&other.ends[0]) * n.dot(&other.ends[1]) <= 0.0;
            (opposite && cuts[i + 1] > cuts[i]).then_some((cuts[i], cuts[i + 1]))
        };
        // Between the zeros the ends are on different sides or the same; outside of both it is the other way round.
        match stretch(1) {
            Some(between) => [Some(between), None],
            None => [stretch(0), stretch(2)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::meshes;
    use crate::geometry::Isometry;

    fn volume(triangles: &[Triangle]) -> f64 {
        let (_, axes) = MinimumVolume::mean_and_axes(triangles);
        Search::new(triangle::corners(triangles), 0.0).widths(&axes).product()
    }

    #[test]
    fn a_turned_cuboid_is_its_own_box() {
        let turn = Isometry::rotation(Vector::new(0.4, -0.9, 0.5));
        let triangles = meshes::moved(&meshes::cuboid(20.0, 12.0, 5.0), 1.0, &turn).triangles();
        assert!((volume(&triangles) - 1200.0).abs() < 1e-3);
    }

    #[test]
    fn a_regular_tetrahedron_fits_a_cube_whose_diagonals_are_its_edges() {
        // Alternate corners of the cube of edge 2, turned: no face of the box contains a face of the tetrahedron.
        let turn = Isometry::rotation(Vector::new(-0.3, 1.9, 0.2));
        let [a, b, c, d] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
            .map(|p: [f64; 3]| turn * Point::from(p));
        let triangles = [Triangle::new(a, b, c), Triangle::new(a, b, d)];
        assert!((volume(&triangles) - 8.0).abs() < 8.0 * TOLERANCE, "{}", volume(&triangles));
    }

    #[test]
    fn a_triangle_gets_its_smallest_rectangle() {
        let t = Triangle::new(Point::new(0.0, 0.0, 1.0), Point::new(4.0, 0.0, 1.0), Point::new(0.0, 3.0, 1.0));
        let (_, axes) = MinimumVolume::mean_and_axes(&[t]);
        let mut widths: Vec<f64> = Search::new(t.corners.iter(), 0.0).widths(&axes).iter().copied().collect();
        widths.sort_by(f64::total_cmp);
        // Either the legs, 3 by 4, or the hypotenuse and its height, 5 by 2.4: both 12.
        assert!(widths[0] < 1e-12 && (widths[1] * widths[2] - 12.0).abs() < 1e-12, "{widths:?}");
    }

    #[test]
    fn arcs_meet_where_a_normal_of_the_other_is_perpendicular() {
        let arc = |from: Vector, to: Vector| {
            let tangent = (to - from * from.dot(&to)).normalize();
            Arc { ends: [from, to], tangent, edge: from.cross(&tangent), angle: from.angle(&to) }
        };
        // From x to y against the arc from x to z: n = (cos φ, sin φ, 0) is perpendicular to m = (cos θ, 0, sin θ) when
        // cos φ cos θ = 0: at φ = 90° for all m, and for m = z at all φ.
        let [first, second] = arc(Vector::x(), Vector::y()).meets(&arc(Vector::x(), Vector::z()));
        assert!(first.is_some() && second.is_none());
        // Twenty degrees about x each: never perpendicular.
        let near = |angle: f64| Vector::new(angle.cos(), angle.sin(), 0.0);
        assert_eq!(arc(near(-0.2), near(0.2)).meets(&arc(near(0.3), near(0.5))), [None; 2]);
        // From 0 to 0.4 rad against π/2 to π/2 + 0.1: perpendicular from 0 to 0.1 rad.
        let [stretch, _] = arc(near(0.0), near(0.4))
            .meets(&arc(near(std::f64::consts::FRAC_PI_2), near(std::f64::consts::FRAC_PI_2 + 0.1)));
        let (low, high) = stretch.unwrap();
        assert!(low.abs() < 1e-9 && (high - 0.1).abs() < 1e-9);
    }
}
