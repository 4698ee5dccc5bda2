//! Planes that part two meshes: a mesh as a tree of convex hulls, and the planes that part pairs of them.
//!
//! A node is a range of the mesh's triangles in the order of the tree, halved again and again; its volume is the convex hull of its
//! triangles, which needs no storage. Support points come from boxes around the nodes; planes from parry's GJK (Gilbert, Johnson, Keerthi 1988; van den Bergen 2003)
//! on the hull of one and the swept hull of the other.

use super::motion::Sweep;
use crate::geometry::{Isometry, Mesh, Point, Vector};
use parry3d_f64::math::{Pose, Vector as Glam};
use parry3d_f64::query::gjk::{CsoPoint, GJKResult, VoronoiSimplex, closest_points};
use parry3d_f64::shape::SupportMap;
use std::cell::Cell;

/// Triangles up to which a node has no box of its own.
const BARE: u32 = 4;
/// Length of a unit normal in whole numbers.
const SCALE: f64 = 16_777_216.0; // 2^24
/// Clearance that the search leaves between hull and plane beyond the motion, mm: twice what the checker asks for, and far above rounding.
pub(super) const MARGIN_MM: f64 = 2e-6;
/// Most planes of a front, and most pairs of hulls tried for one.
const MOST_PLANES: usize = 3_000;
const MOST_TRIED: usize = 6_000;
/// Most pairs of nodes that are looked at for a proof of contact.
const MOST_PIERCING: usize = 1_000_000;

/// A range of triangles in the order of the tree. `id` is 1 for all; halves of `i` are `2i` and `2i + 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Node {
    id: usize,
    pub low: u32,
    pub high: u32,
}

impl Node {
    fn len(self) -> u32 {
        self.high - self.low
    }

    fn halves(self) -> [Self; 2] {
        let middle = self.low + self.len() / 2;
        [Self { id: 2 * self.id, high: middle, ..self }, Self { id: 2 * self.id + 1, low: middle, ..self }]
    }
}

/// A mesh in the order of its tree.
pub(super) struct Tree {
    /// The mesh's faces by the order of the tree.
    pub faces: Vec<[u32; 3]>,
    /// Their corners, mm.
    pub triangles: Vec<[Point; 3]>,
    /// Lowest and highest corner of each node by its id, where it has more than [`BARE`] triangles.
    boxes: Vec<[Point; 2]>,
}

impl Tree {
    /// With the faces in the order of another tree whose nodes are halved, or in an order of its own.
    pub fn new(mesh: &Mesh, order: Option<&[u32]>) -> Self {
        let mut faces = mesh.faces().to_vec();
        if let Some(order) = order {
            faces = order.iter().map(|&face| mesh.faces()[face as usize]).collect();
        } else {
            let middle = |face: &[u32; 3]| -> Vector { face.iter().map(|&v| mesh.vertices()[v as usize].coords).sum() };
            sort(&mut faces, &middle);
        }
        let triangles = faces.iter().map(|face| face.map(|v| mesh.vertices()[v as usize])).collect();
        let mut tree = Self { faces, triangles, boxes: Vec::new() };
        tree.enclose(tree.root());
        tree
    }

    pub fn root(&self) -> Node {
        Node { id: 1, low: 0, high: self.faces.len() as u32 }
    }

    fn enclose(&mut self, node: Node) -> [Point; 2] {
        if node.len() <= BARE {
            return self.bounds(node);
        }
        let [[a, b], [c, d]] = node.halves().map(|half| self.enclose(half));
        if self.boxes.len() <= node.id {
            self.boxes.resize(node.id + 1, [Point::origin(); 2]);
        }
        self.boxes[node.id] = [a.inf(&c), b.sup(&d)];
        self.boxes[node.id]
    }

    /// The box around a node, mm.
    pub fn bounds(&self, node: Node) -> [Point; 2] {
        if node.len() > BARE {
            return self.boxes[node.id];
        }
        let corners = self.triangles[node.low as usize..node.high as usize].as_flattened();
        corners.iter().fold([corners[0]; 2], |[low, high], p| [low.inf(p), high.sup(p)])
    }

    /// The corner of a node that lies farthest along `n`, and how far.
    fn farthest(&self, node: Node, n: &Vector) -> (f64, Point) {
        let mut best = (f64::NEG_INFINITY, Point::origin());
        self.farther(node, n, &mut best);
        best
    }

    fn farther(&self, node: Node, n: &Vector, best: &mut (f64, Point)) {
        if node.len() <= BARE {
            for p in self.triangles[node.low as usize..node.high as usize].as_flattened() {
                let along = n.dot(&p.coords);
                if along > best.0 {
                    *best = (along, *p);
                }
            }
            return;
        }
        let reach = |half: Node| {
            if half.len() <= BARE {
                return f64::INFINITY;
            }
            let [low, high] = &self.boxes[half.id];
            (0..3).map(|i| n[i] * if n[i] > 0.0 { high[i] } else { low[i] }).sum::<f64>()
        };
        let mut halves = node.halves().map(|half| (reach(half), half));
        if halves[1].0 > halves[0].0 {
            halves.swap(0, 1);
        }
        for (reach, half) in halves {
            if reach > best.0 {
                self.farther(half, n, best);
            }
        }
    }
}

/// Halves triangles again and again along the axis on which their middles spread most.
fn sort(faces: &mut [[u32; 3]], middle: &impl Fn(&[u32; 3]) -> Vector) {
    if faces.len() < 2 {
        return;
    }
    let first = middle(&faces[0]);
    let (low, high) = faces.iter().map(middle).fold((first, first), |(low, high), m| (low.inf(&m), high.sup(&m)));
    let axis = (high - low).imax();
    let half = faces.len() / 2;
    faces.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
    let (left, right) = faces.split_at_mut(half);
    sort(left, middle);
    sort(right, middle);
}

/// An entry of a front, read from left to right: a plane that separates a pair of nodes, or the halving of one of them, after which both pairs follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token {
    /// n·x <= c for all points x of the first node, in whole numbers.
    Plane {
        normal: [i32; 3],
        offset: i64,
    },
    HalveA,
    HalveB,
}

/// The meshes of a pair, with all their relative motions over a region.
pub(super) struct Parting<'a> {
    pub a: &'a Tree,
    pub b: &'a Tree,
    pub sweep: &'a Sweep,
    /// Number of pairs of hulls between which a plane was sought.
    pub tried: &'a Cell<u64>,
}

/// A node of `a`, fixed.
struct Still<'a>(&'a Tree, Node);
/// A node of `b`, moved to the middle of the region and swept over it, in the frame of `a`.
struct Swept<'a>(&'a Parting<'a>, Node);

impl SupportMap for Still<'_> {
    fn local_support_point(&self, dir: Glam) -> Glam {
        self.0.farthest(self.1, &dir.into()).1.into()
    }
}

impl SupportMap for Swept<'_> {
    fn local_support_point(&self, dir: Glam) -> Glam {
        let (n, sweep) = (Vector::from(dir), self.0.sweep);
        let in_b = sweep.a_from_b.rotation.inverse() * n;
        let point = sweep.a_from_b * self.0.b.farthest(self.1, &in_b).1;
        (point + sweep.support(&n)).into()
    }
}

impl Parting<'_> {
    /// Whether the planes of a front separate the pair over the whole region.
    pub fn holds(&self, front: &[Token]) -> bool {
        let mut open = vec![[self.a.root(), self.b.root()]];
        for token in front {
            let Some([a, b]) = open.pop() else { return false };
            match token {
                Token::HalveA => open.extend(a.halves().map(|half| [half, b]).into_iter().rev()),
                Token::HalveB => open.extend(b.halves().map(|half| [a, half]).into_iter().rev()),
                Token::Plane { normal, offset } => {
                    if !self.is_behind(b, &Vector::from(normal.map(f64::from)), *offset as f64) {
                        return false;
                    }
                }
            }
        }
        open.is_empty()
    }

    /// Whether a node of `b` stays on the far side of a plane.
    fn is_behind(&self, b: Node, n: &Vector, offset: f64) -> bool {
        let in_b = self.sweep.a_from_b.rotation.inverse() * n;
        let nearest = n.dot(&self.sweep.a_from_b.translation.vector) - self.b.farthest(b, &-in_b).0;
        nearest - self.sweep.towards(n) - (self.sweep.radius + MARGIN_MM) * n.norm() >= offset
    }

    /// A plane between two nodes.
    fn plane(&self, a: Node, b: Node, hint: &Vector) -> Option<(Token, Vector)> {
        self.plane_along(a, b, hint).or_else(|| {
            let (still, swept) = (Still(self.a, a), Swept(self, b));
            let middle = |bounds: [Point; 2]| nalgebra::center(&bounds[0], &bounds[1]);
            let way = self.sweep.a_from_b * middle(self.b.bounds(b)) - middle(self.a.bounds(a));
            let first = if way.norm() > 0.0 { way.normalize() } else { Vector::z() };
            let mut simplex = VoronoiSimplex::new();
            simplex.reset(CsoPoint::from_shapes(&Pose::IDENTITY, &still, &swept, first.into()));
            let needed = self.sweep.radius + 1.5 * MARGIN_MM;
            match closest_points(&Pose::IDENTITY, &still, &swept, needed, false, &mut simplex) {
                GJKResult::NoIntersection(direction) => self.plane_along(a, b, &direction.into()),
                _ => None,
            }
        })
    }

    /// The plane between two nodes across a direction, if there is one.
    fn plane_along(&self, a: Node, b: Node, direction: &Vector) -> Option<(Token, Vector)> {
        let rounded = (direction * SCALE).map(f64::round);
        let farthest = self.a.farthest(a, &rounded).0;
        let offset = (farthest + 0.1 * MARGIN_MM * rounded.norm()).ceil();
        let normal = [rounded.x as i32, rounded.y as i32, rounded.z as i32];
        let token = Token::Plane { normal, offset: offset as i64 };
        (normal != [0; 3] && self.is_behind(b, &rounded, offset)).then_some((token, *direction))
    }

    /// The planes that separate the pair over the whole region. Otherwise the places in the trees of the two triangles for which no plane was found, where the search came to two.
    pub fn front(&self, hint: &mut Vector) -> Result<Vec<Token>, Option<[u32; 2]>> {
        let (mut front, mut planes, mut tried) = (Vec::new(), 0, 0);
        let mut open = vec![[self.a.root(), self.b.root()]];
        while let Some([a, b]) = open.pop() {
            tried += 1;
            self.tried.set(self.tried.get() + 1);
            if tried > MOST_TRIED || planes > MOST_PLANES {
                return Err(None);
            }
            if let Some((token, direction)) = self.plane(a, b, hint) {
                *hint = direction;
                front.push(token);
                planes += 1;
                continue;
            }
            let size = |[low, high]: [Point; 2]| (high - low).norm_squared();
            let halves_a = b.len() == 1 || a.len() > 1 && size(self.a.bounds(a)) >= size(self.b.bounds(b));
            if a.len() == 1 && b.len() == 1 {
                return Err(Some([a.low, b.low]));
            }
            if halves_a {
                front.push(Token::HalveA);
                open.extend(a.halves().map(|half| [half, b]).into_iter().rev());
            } else {
                front.push(Token::HalveB);
                open.extend(b.halves().map(|half| [a, half]).into_iter().rev());
            }
        }
        Ok(front)
    }

    /// Whether a plane separates two triangles, named by their places in the trees.
    pub fn parts_triangles(&self, [i, j]: [u32; 2]) -> bool {
        let single = |place: u32| Node { id: 0, low: place, high: place + 1 };
        self.plane(single(i), single(j), &Vector::zeros()).is_some()
    }

    /// Distance of two triangles at the middle of the region, mm.
    pub fn apart_mm(&self, [i, j]: [u32; 2]) -> f64 {
        use crate::geometry::{Triangle, triangle_distance};
        let still = Triangle { corners: self.a.triangles[i as usize] };
        let moved = Triangle { corners: self.b.triangles[j as usize] }.map(|p| self.sweep.a_from_b * p);
        triangle_distance::squared(&still, &moved).sqrt()
    }
}

/// Two triangles of which an edge of one surely pierces the other when `b` is placed, by their places in the trees.
pub(super) fn piercing(a: &Tree, b: &Tree, a_from_b: &Isometry) -> Option<[u32; 2]> {
    let rotation = a_from_b.rotation.to_rotation_matrix().into_inner();
    let moved = |[low, high]: [Point; 2]| {
        let middle = a_from_b * nalgebra::center(&low, &high);
        let half = rotation.abs() * (0.5 * (high - low)) + Vector::repeat(1e-9);
        [middle - half, middle + half]
    };
    let mut open = vec![[a.root(), b.root()]];
    for _ in 0..MOST_PIERCING {
        let [x, y] = open.pop()?;
        let ([low, high], [l, h]) = (a.bounds(x), moved(b.bounds(y)));
        if (0..3).any(|i| high[i] < l[i] || h[i] < low[i]) {
            continue;
        }
        if x.len() > 1 && (y.len() == 1 || (high - low).norm() > (h - l).norm()) {
            open.extend(x.halves().map(|half| [half, y]));
        } else if y.len() > 1 {
            open.extend(y.halves().map(|half| [x, half]));
        } else {
            let (i, j) = (x.low, y.low);
            let (still, turned) = (a.triangles[i as usize], b.triangles[j as usize].map(|p| a_from_b * p));
            let edge_through =
                |one: &[Point; 3], other: &[Point; 3]| (0..3).any(|k| pierces(&one[k], &one[(k + 1) % 3], other));
            if edge_through(&still, &turned) || edge_through(&turned, &still) {
                return Some([i, j]);
            }
        }
    }
    None
}

/// Whether an edge passes through the inside of a triangle, by more than the rounding error.
fn pierces(p: &Point, q: &Point, [a, b, c]: &[Point; 3]) -> bool {
    let volume = |u: &Point, v: &Point, w: &Point, x: &Point| (v - u).cross(&(w - u)).dot(&(x - u));
    let size = [b - a, c - a, q - p].iter().map(Vector::norm_squared).fold(0.0, f64::max);
    let least = 1e-9 * size.max(1e-3);
    let (above, below) = (volume(a, b, c, p), volume(a, b, c, q));
    let sides = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
    above.min(-below).max(below.min(-above)) > least
        && (sides.iter().all(|&side| side > least) || sides.iter().all(|&side| side < -least))
}
