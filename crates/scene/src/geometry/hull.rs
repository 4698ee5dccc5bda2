//! Convex hulls; on which side of a facet a point lies is decided without rounding.
//!
//! C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The Quickhull Algorithm for Convex Hulls", ACM TOMS 22(4), 1996. Deviation: facets made
//! concave by rounding are not merged; instead, a point is beyond a facet only when Shewchuk's adaptive predicate says so. A point in the
//! plane of a facet is not beyond it, so no new facet has its three corners on one line. Points in one plane, on one line or in one place
//! are distinguished from solids exactly, however thin the solid.

use super::{Point, Vector};
use robust::{Coord, Coord3D, orient2d, orient3d};

/// The convex hull of points, by the dimension of its extent.
#[derive(Clone, Debug)]
pub enum Hull {
    /// All points coincide.
    Point(Point),
    /// All points lie on one line; the two ends.
    Segment([Point; 2]),
    /// All points lie in one plane; the corners of a convex polygon in order, none on the line between two others.
    Polygon(Vec<Point>),
    /// Anything else.
    Solid(Solid),
}

/// A convex solid by its triangles. Facets with more corners than three are several triangles in one plane.
#[derive(Clone, Debug)]
pub struct Solid {
    /// The corners, mm.
    pub vertices: Vec<Point>,
    /// Corner numbers, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 3]>,
    /// For each face, the neighbouring face across each edge; edges run from corner 0 to 1, 1 to 2 and 2 to 0.
    neighbours: Vec<[u32; 3]>,
}

/// An edge between two faces that are not coplanar.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Its ends, mm.
    pub ends: [Point; 2],
    /// The two faces that meet there.
    pub faces: [u32; 2],
}

impl Hull {
    /// The hull of the points, mm; points with a coordinate that is not finite are ignored. The order of the points has no influence.
    /// `None` without points.
    pub fn of<'a>(points: impl Iterator<Item = &'a Point>) -> Option<Self> {
        // Adding zero makes the negative zero positive, so that equal points are equal.
        let positive = points.map(|p| [p.x + 0.0, p.y + 0.0, p.z + 0.0]);
        Self::of_finite(positive.filter(|p| p.iter().all(|x| x.is_finite())).collect())
    }

    fn of_finite(mut distinct: Vec<[f64; 3]>) -> Option<Self> {
        distinct.sort_unstable_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(p[2].total_cmp(&q[2])));
        distinct.dedup();
        let (&first, &last) = (distinct.first()?, distinct.last()?);
        if distinct.len() == 1 {
            return Some(Self::Point(Point::from(first)));
        }
        let Some(third) = farthest(&distinct, |p| off_line(&first, &last, p)) else {
            return Some(Self::Segment([Point::from(first), Point::from(last)]));
        };
        let plane = [0, distinct.len() - 1, third];
        let [a, b, c] = plane.map(|i| distinct[i]);
        Some(match farthest(&distinct, |p| above(&a, &b, &c, p).abs()) {
            None => Self::Polygon(polygon(&distinct, &[a, b, c])),
            Some(fourth) => Self::Solid(solid(&distinct, plane, fourth)),
        })
    }

    /// Triangles that cover the hull's surface; a polygon is covered once, for both sides. None for points and segments.
    pub fn triangles(&self) -> Vec<super::Triangle> {
        match self {
            Self::Point(_) | Self::Segment(_) => Vec::new(),
            Self::Polygon(corners) => {
                corners.windows(2).skip(1).map(|pair| super::Triangle::new(corners[0], pair[0], pair[1])).collect()
            }
            Self::Solid(solid) => solid.triangles(),
        }
    }
}

impl Solid {
    /// One face as a triangle.
    pub fn triangle(&self, face: usize) -> super::Triangle {
        super::Triangle { corners: self.faces[face].map(|v| self.vertices[v as usize]) }
    }

    /// All faces as triangles.
    pub fn triangles(&self) -> Vec<super::Triangle> {
        (0..self.faces.len()).map(|face| self.triangle(face)).collect()
    }

    /// The outward unit normal of each face.
    pub fn normals(&self) -> Vec<Vector> {
        (0..self.faces.len()).map(|face| self.triangle(face).double_area_normal().normalize()).collect()
    }

    /// The edges between faces that are not coplanar, each once.
    pub fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        for (face, (corners, neighbours)) in self.faces.iter().zip(&self.neighbours).enumerate() {
            for (i, &other) in neighbours.iter().enumerate() {
                let [a, b, c] = corners.map(|v| self.vertices[v as usize].coords.into());
                let bends = || {
                    let apex = self.faces[other as usize].iter().find(|v| !corners.contains(v));
                    apex.is_some_and(|&v| above(&a, &b, &c, &self.vertices[v as usize].coords.into()) != 0.0)
                };
                if (face as u32) < other && bends() {
                    let ends = [corners[i], corners[(i + 1) % 3]].map(|v| self.vertices[v as usize]);
                    edges.push(Edge { ends, faces: [face as u32, other] });
                }
            }
        }
        edges
    }
}

/// Signed distance of `p` above the plane of a, b, c, which are counter-clockwise seen from above, in an arbitrary unit; the sign is exact.
fn above(a: &[f64; 3], b: &[f64; 3], c: &[f64; 3], p: &[f64; 3]) -> f64 {
    let coord = |&[x, y, z]: &[f64; 3]| Coord3D { x, y, z };
    -orient3d(coord(a), coord(b), coord(c), coord(p))
}

/// Twice the area of the projection of a, b, p along coordinate axis `axis`, signed; the sign is exact.
fn turn(axis: usize, a: &[f64; 3], b: &[f64; 3], p: &[f64; 3]) -> f64 {
    let coord = |q: &[f64; 3]| Coord { x: q[(axis + 1) % 3], y: q[(axis + 2) % 3] };
    orient2d(coord(a), coord(b), coord(p))
}

/// A measure of the distance of `p` from the line through a and b: 0 exactly when the three points are collinear, and larger for points
/// farther from the line.
fn off_line(a: &[f64; 3], b: &[f64; 3], p: &[f64; 3]) -> f64 {
    (0..3).map(|axis| turn(axis, a, b, p).abs()).fold(0.0, f64::max)
}

/// The index of the first point with the largest `measure`; `None` when it is zero everywhere.
fn farthest(points: &[[f64; 3]], measure: impl Fn(&[f64; 3]) -> f64) -> Option<usize> {
    let mut best = (0.0, None);
    for (i, p) in points.iter().enumerate() {
        let value = measure(p);
        if value > best.0 {
            best = (value, Some(i));
        }
    }
    best.1
}

/// The corners of the hull of coplanar points, in order, found in the coordinate plane in which `a`,
/// `b`, `c` span the largest area. `points` are sorted by x, y, z.
fn polygon(points: &[[f64; 3]], [a, b, c]: &[[f64; 3]; 3]) -> Vec<Point> {
    let spans = [0, 1, 2].map(|axis| turn(axis, a, b, c).abs());
    let axis = (0..3).fold(0, |best, axis| if spans[axis] > spans[best] { axis } else { best });
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut sorted = points.to_vec();
    sorted.sort_by(|p, q| p[u].total_cmp(&q[u]).then(p[v].total_cmp(&q[v])));
    around(&sorted, |q, r, p| turn(axis, q, r, p)).into_iter().map(Point::from).collect()
}

/// The corners of the hull of sorted points of a plane, counter-clockwise, by A. M. Andrew's monotone chain (1979). `turn` is positive where three points turn
/// left.
pub(crate) fn around<P: Copy>(sorted: &[P], turn: impl Fn(&P, &P, &P) -> f64) -> Vec<P> {
    let half = |points: &mut dyn Iterator<Item = &P>| {
        let mut chain: Vec<P> = Vec::new();
        for p in points {
            while let [.., q, r] = chain.as_slice() {
                if turn(q, r, p) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut corners = half(&mut sorted.iter());
    corners.extend(half(&mut sorted.iter().rev()));
    corners
}

/// A face of the hull while it grows.
struct Face {
    corners: [u32; 3],
    neighbours: [u32; 3],
    /// Points beyond this face that are not assigned to another face.
    beyond: Vec<u32>,
    is_alive: bool,
    /// The last point for which the visibility of this face was tested.
    seen_from: Option<u32>,
}

/// The growing hull.
struct Growth<'a> {
    points: &'a [[f64; 3]],
    faces: Vec<Face>,
}

/// The hull of points that are not coplanar; `plane` are three points that span a plane, and `fourth` is a point outside it.
fn solid(points: &[[f64; 3]], plane: [usize; 3], fourth: usize) -> Solid {
    let [a, b, c, d] = [plane[0], plane[1], plane[2], fourth].map(|i| i as u32);
    let at = |i: u32| &points[i as usize];
    let (b, c) = if above(at(a), at(b), at(c), at(d)) < 0.0 { (b, c) } else { (c, b) };
    let mut growth = Growth { points, faces: Vec::new() };
    growth.add([a, b, c], [1, 2, 3]);
    growth.add([b, a, d], [0, 3, 2]);
    growth.add([c, b, d], [0, 1, 3]);
    growth.add([a, c, d], [0, 2, 1]);
    growth.distribute(0, (0..points.len() as u32).filter(|i| ![a, b, c, d].contains(i)).collect());
    let mut open: Vec<u32> = vec![0, 1, 2, 3];
    while let Some(face) = open.pop() {
        let Face { is_alive: true, corners, beyond, .. } = &growth.faces[face as usize] else { continue };
        let [a, b, c] = corners.map(at);
        let Some(eye) = farthest_of(beyond, |i| above(a, b, c, at(i))) else { continue };
        open.extend(growth.extend_to(eye, face));
    }
    growth.finish()
}

/// The first of `numbers` with the largest `measure`.
fn farthest_of(numbers: &[u32], measure: impl Fn(u32) -> f64) -> Option<u32> {
    let mut best = None;
    for &i in numbers {
        let value = measure(i);
        if best.is_none_or(|(_, largest)| value > largest) {
            best = Some((i, value));
        }
    }
    best.map(|(i, _)| i)
}

impl Growth<'_> {
    fn add(&mut self, corners: [u32; 3], neighbours: [u32; 3]) {
        self.faces.push(Face { corners, neighbours, beyond: Vec::new(), is_alive: true, seen_from: None });
    }

    fn is_beyond(&self, face: usize, point: u32) -> bool {
        let [a, b, c] = self.faces[face].corners.map(|v| &self.points[v as usize]);
        above(a, b, c, &self.points[point as usize]) > 0.0
    }

    /// Assigns each point to the first face, from `first` on, that it is beyond; a point beyond none lies inside and is dropped.
    fn distribute(&mut self, first: usize, points: Vec<u32>) {
        for point in points {
            if let Some(face) = (first..self.faces.len()).find(|&face| self.is_beyond(face, point)) {
                self.faces[face].beyond.push(point);
            }
        }
    }

    /// Replaces the faces that see `eye`, one of which is `face`, by a cone over their rim. Returns the new faces.
    fn extend_to(&mut self, eye: u32, face: u32) -> std::ops::Range<u32> {
        let mut visible = vec![face];
        self.faces[face as usize].seen_from = Some(eye);
        let mut rim = Vec::new();
        let mut next = 0;
        while next < visible.len() {
            let here = visible[next] as usize;
            next += 1;
            let Face { corners, neighbours, .. } = self.faces[here];
            for (i, other) in neighbours.into_iter().enumerate() {
                if self.faces[other as usize].seen_from == Some(eye) {
                    continue;
                }
                if self.is_beyond(other as usize, eye) {
                    self.faces[other as usize].seen_from = Some(eye);
                    visible.push(other);
                } else {
                    rim.push((corners[i], corners[(i + 1) % 3], other));
                }
            }
        }
        let first = self.faces.len();
        // The new faces by the corner at which their edges of the rim start, and end.
        let sorted = |corner: &dyn Fn(&(u32, u32, u32)) -> u32| {
            let mut faces: Vec<(u32, u32)> = rim.iter().map(corner).zip(first as u32..).collect();
            faces.sort_unstable();
            faces
        };
        let (starting, ending) = (sorted(&|edge| edge.0), sorted(&|edge| edge.1));
        let at = |faces: &[(u32, u32)], corner: u32| faces[faces.partition_point(|face| face.0 < corner)].1;
        for &(from, to, outer) in &rim {
            let new = self.faces.len() as u32;
            let slot = self.faces[outer as usize].corners.iter().position(|&v| v == to);
            let slot = slot.expect("the face beyond an edge has the edge's ends");
            self.faces[outer as usize].neighbours[slot] = new;
            self.add([from, to, eye], [outer, at(&starting, to), at(&ending, from)]);
        }
        let mut loose = Vec::new();
        for face in visible {
            self.faces[face as usize].is_alive = false;
            loose.append(&mut self.faces[face as usize].beyond);
        }
        loose.retain(|&point| point != eye);
        // A point still outside is beyond one of the new faces: where it sees old faces on both sides of the rim, it sees
        // the new face between them, whose normal is a positive combination of theirs.
        self.distribute(first, loose);
        first as u32..self.faces.len() as u32
    }

    fn finish(self) -> Solid {
        let alive: Vec<usize> = (0..self.faces.len()).filter(|&face| self.faces[face].is_alive).collect();
        let face_number = numbers(self.faces.len(), alive.iter().copied());
        let mut used: Vec<u32> = alive.iter().flat_map(|&face| self.faces[face].corners).collect();
        used.sort_unstable();
        used.dedup();
        let vertex_number = numbers(self.points.len(), used.iter().map(|&v| v as usize));
        let renumbered = |old: [u32; 3], numbers: &[u32]| old.map(|number| numbers[number as usize]);
        Solid {
            vertices: used.iter().map(|&v| Point::from(self.points[v as usize])).collect(),
            faces: alive.iter().map(|&face| renumbered(self.faces[face].corners, &vertex_number)).collect(),
            neighbours: alive.iter().map(|&face| renumbered(self.faces[face].neighbours, &face_number)).collect(),
        }
    }
}

/// Renumbers items: an array of length `count` that holds, at each index in `kept`, its position in `kept`, and 0 elsewhere.
fn numbers(count: usize, kept: impl Iterator<Item = usize>) -> Vec<u32> {
    let mut numbers = vec![0; count];
    for (new, old) in (0..).zip(kept) {
        numbers[old] = new;
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn hull(points: &[[f64; 3]]) -> Hull {
        let points: Vec<Point> = points.iter().map(|&p| Point::from(p)).collect();
        Hull::of(points.iter()).unwrap()
    }

    fn cube() -> Vec<[f64; 3]> {
        (0..27).map(|i| [i % 3, i / 3 % 3, i / 9].map(f64::from)).collect()
    }

    #[test]
    fn the_lattice_of_a_cube_keeps_its_corners_and_twelve_edges() {
        let Hull::Solid(solid) = hull(&cube()) else { panic!("a cube is solid") };
        assert_eq!((solid.vertices.len(), solid.faces.len(), solid.edges().len()), (8, 12, 12));
        let volume: f64 = (0..12)
            .map(|f| {
                let [a, b, c] = solid.triangle(f).corners.map(|p| p.coords);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum();
        assert!((volume - 8.0).abs() < 1e-12);
    }

    #[test]
    fn what_spans_less_than_space_is_told_apart() {
        assert!(matches!(hull(&[[1.0, 2.0, 3.0]; 3]), Hull::Point(p) if p == Point::new(1.0, 2.0, 3.0)));
        let line = [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [3.0, 6.0, 9.0], [2.0, 4.0, 6.0]];
        assert!(matches!(hull(&line), Hull::Segment([p, q]) if p == Point::origin() && q == Point::new(3.0, 6.0, 9.0)));
        // A square in the plane x = z with its middle and the middles of its sides.
        let square: Vec<[f64; 3]> = (0..9).map(|i| [f64::from(i % 3), f64::from(i / 3), f64::from(i % 3)]).collect();
        let Hull::Polygon(corners) = hull(&square) else { panic!("a square is flat") };
        assert_eq!(corners.len(), 4);
        let area: f64 = hull(&square).triangles().iter().map(crate::geometry::Triangle::area).sum();
        assert!((area - 2.0 * 8.0_f64.sqrt()).abs() < 1e-12);
        // One step of 2⁻²⁶ out of the plane, and it is a solid.
        let mut bent = square;
        bent[4][0] += 1.0 / 67_108_864.0;
        assert!(matches!(hull(&bent), Hull::Solid(_)));
        assert!(Hull::of(std::iter::empty()).is_none());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        /// On a coarse lattice most points share planes and lines with other points.
        #[test]
        fn nothing_lies_beyond_any_face_and_euler_holds(points in prop::collection::vec(prop::array::uniform3(0..5_i32), 4..60)) {
            let points: Vec<[f64; 3]> = points.iter().map(|p| p.map(f64::from)).collect();
            if let Hull::Solid(solid) = hull(&points) {
                prop_assert_eq!(solid.vertices.len() + solid.faces.len(), solid.faces.len() * 3 / 2 + 2);
                for face in 0..solid.faces.len() {
                    let [a, b, c] = solid.triangle(face).corners.map(|p| p.coords.into());
                    prop_assert!(off_line(&a, &b, &c) > 0.0);
                    prop_assert!(points.iter().all(|p| above(&a, &b, &c, p) <= 0.0));
                    for (i, &other) in solid.neighbours[face].iter().enumerate() {
                        prop_assert!(solid.neighbours[other as usize].contains(&(face as u32)));
                        let (from, to) = (solid.faces[face][i], solid.faces[face][(i + 1) % 3]);
                        prop_assert!(solid.faces[other as usize].contains(&from) && solid.faces[other as usize].contains(&to));
                    }
                }
            }
        }
    }
}
