//! Meshes on the grid of 2⁻²⁶ mm: hulls of ranges of triangles beside planes, piercing edges, and what is inside.

use crate::Work;
use crate::interval::{I, Pose, V, ZERO, cross, dot, minus, norm, plus, times};
use crate::read::Words;
use std::collections::BTreeSet;
use std::ops::Neg;

/// Steps of the grid in a mm.
const STEPS: f64 = 67_108_864.0; // 2^26
/// Largest coordinate: 4096 mm. Numbers of 38 bits are exact in mm.
const LIMIT: u64 = 1 << 38;

/// Directions of rays, in Y and Z for 1 in X.
const WAYS: [[f64; 2]; 6] =
    [[0.0123, 0.0271], [-0.0317, 0.0071], [0.0557, -0.0413], [-0.071, -0.0887], [0.213, 0.151], [-0.317, 0.273]];

/// A point of the grid.
type Point = [i64; 3];

/// Faces, in the order of the tree: node 1 has all faces, the halves of node `i` are `2i` and `2i + 1`.
#[derive(Debug, Default)]
pub struct Mesh {
    /// The vertices that lines of faces name. Faces have their own, so that vertices in one place are one.
    vertices: Vec<Point>,
    pub faces: Vec<[Point; 3]>,
    /// Boxes around nodes, mm.
    boxes: Vec<V>,
    /// A ball around all, mm.
    pub centre: V,
    pub radius: I,
    has_inside: bool,
    /// The factor of a crossing of each face: -1 in components that face against the whole mesh and are no cavities, else 1. Empty without an inside.
    weights: Vec<i32>,
    /// One vertex of each connected component, mm.
    components: Vec<V>,
}

/// A range of faces.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    id: usize,
    low: usize,
    high: usize,
}

/// A plane n·x = c, and the node of the second mesh that lies beyond it.
pub struct Plane {
    pub normal: V,
    pub offset: I,
    pub b: Node,
}

impl Node {
    fn halves(self) -> Option<[Self; 2]> {
        let middle = self.low + (self.high - self.low) / 2;
        let halves =
            [Self { id: 2 * self.id, high: middle, ..self }, Self { id: 2 * self.id + 1, low: middle, ..self }];
        (self.high - self.low > 1).then_some(halves)
    }
}

fn mm(p: &Point) -> V {
    p.map(|x| I::of(x as f64 / STEPS))
}

fn hull(a: &V, b: &V) -> V {
    [0, 1, 2].map(|i| a[i].hull(b[i]))
}

fn are_apart(a: &V, b: &V) -> bool {
    (0..3).any(|i| a[i].hi < b[i].lo || a[i].lo > b[i].hi)
}

impl Mesh {
    pub fn vertex(&mut self, words: &mut Words<'_>) -> Result<(), String> {
        let p: Point = [words.whole()?, words.whole()?, words.whole()?];
        self.vertices.push(p);
        if p.iter().all(|x| x.unsigned_abs() <= LIMIT) { Ok(()) } else { Err("a vertex out of range".to_owned()) }
    }

    pub fn face(&mut self, words: &mut Words<'_>) -> Result<(), String> {
        let face: [usize; 3] = [words.whole()?, words.whole()?, words.whole()?];
        let face = face.map(|v| self.vertices.get(v).copied());
        self.faces.push(face.map(Option::unwrap_or_default));
        if face.contains(&None) { Err("no such vertex".to_owned()) } else { Ok(()) }
    }

    /// Boxes around nodes, a ball around all, and what is inside.
    pub fn finish(&mut self, work: &Work) -> Result<(), String> {
        if self.faces.is_empty() {
            return Err("a mesh without a face".to_owned());
        }
        self.boxes = vec![V::default(); 2 * self.faces.len().next_power_of_two()];
        self.centre = self.enclose(self.root()).map(|x| I::of(0.5 * (x.lo + x.hi)));
        let away = |p: &Point| norm(&minus(&mm(p), &self.centre)).hi;
        self.radius = I::of(self.faces.iter().flatten().map(away).fold(0.0, f64::max));
        let mut points = self.faces.as_flattened().to_vec();
        points.sort_unstable();
        points.dedup();
        let number = |p: Point| points.partition_point(|q| *q < p);
        let numbered: Vec<_> = self.faces.iter().map(|face| face.map(number)).collect();
        self.has_inside = is_closed(&numbered);
        let first = components(&numbered, points.len());
        self.components = (0..points.len()).filter(|v| first[*v] == *v).map(|v| mm(&points[v])).collect();
        let of_faces: Vec<_> = numbered.iter().map(|[v, ..]| first[*v]).collect();
        self.weigh(&points, &first, &of_faces, work);
        Ok(())
    }

    fn root(&self) -> Node {
        Node { id: 1, low: 0, high: self.faces.len() }
    }

    /// The corners of a face, mm.
    pub fn triangle(&self, face: usize) -> Option<[V; 3]> {
        self.faces.get(face).map(|face| face.map(|p| mm(&p)))
    }

    fn enclose(&mut self, node: Node) -> V {
        let found = match node.halves().map(|halves| halves.map(|half| self.enclose(half))) {
            Some([a, b]) => hull(&a, &b),
            None => self.triangle(node.low).map(|[a, b, c]| hull(&hull(&a, &b), &c)).unwrap_or_default(),
        };
        self.boxes[node.id] = found;
        found
    }

    /// Whether n·x >= c (mm) for every corner x of a node's faces. The node's box is tried first.
    pub fn is_beyond(&self, node: Node, n: &V, c: f64, work: &Work) -> bool {
        let is_there = |p: &V| dot(n, p).lo >= c;
        let are_there = |node: Node| match node.halves() {
            Some(halves) => halves.into_iter().all(|half| self.is_beyond(half, n, c, work)),
            None => self.triangle(node.low).is_some_and(|corners| corners.iter().all(is_there)),
        };
        work.take(1) && (is_there(&self.boxes[node.id]) || are_there(node))
    }

    /// Sets the weights; `first` and `of_faces` have, for each vertex and for each face, the first vertex of its component.
    fn weigh(&mut self, points: &[Point], first: &[usize], of_faces: &[usize], work: &Work) {
        let mut volumes = vec![0_i128; points.len()];
        for (face, component) in self.faces.iter().zip(of_faces) {
            let [a, b, c] = face.map(|p| p.map(i128::from));
            let volume = |i: usize, j: usize, k: usize| a[i] * (b[j] * c[k] - b[k] * c[j]);
            let sum = volume(0, 1, 2) + volume(1, 2, 0) + volume(2, 0, 1);
            volumes[*component] = volumes[*component].wrapping_add(sum);
        }
        // Rays do not see a body that is there both ways round.
        self.has_inside &= of_faces.iter().all(|component| volumes[*component] != 0);
        if !self.has_inside {
            return;
        }
        let is_inside_out = volumes.iter().fold(0, |sum: i128, volume| sum.wrapping_add(*volume)) < 0;
        let is_against = |component: usize| (volumes[component] < 0) != is_inside_out;
        self.weights = of_faces.iter().map(|component| i32::from(!is_against(*component))).collect();
        let mut strays = BTreeSet::new();
        for (p, &component) in points.iter().zip(first) {
            let is_asked = is_against(component) && !strays.contains(&component);
            if is_asked && matches!(self.leaves(&mm(p), work), None | Some(0)) {
                strays.insert(component);
            }
        }
        self.weights = of_faces.iter().map(|component| if strays.contains(component) { -1 } else { 1 }).collect();
    }

    /// The number of times that an edge leaves a node's faces, less the number of times that it enters; `None` where it passes too near to an edge to decide.
    fn leavings(&self, node: Node, edge: [&V; 2], work: &Work) -> Option<i32> {
        let (bounds, reach) = (&self.boxes[node.id], hull(edge[0], edge[1]));
        if !work.take(1) {
            return None;
        }
        if are_apart(&reach, bounds) {
            return Some(0);
        }
        match node.halves() {
            Some([one, other]) => Some(self.leavings(one, edge, work)? + self.leavings(other, edge, work)?),
            None if self.weights[node.low] == 0 => Some(0),
            None => work.take(10).then_some(self.weights[node.low] * crossing(edge, &self.triangle(node.low)?)?),
        }
    }

    /// The leavings of a ray from a point to 1 mm beyond the last face, in the first direction that decides.
    fn leaves(&self, p: &V, work: &Work) -> Option<i32> {
        WAYS.into_iter().find_map(|[y, z]| {
            let way = times(&[1.0, y, z].map(I::of), I::of(self.boxes[1][0].hi + 1.0) - p[0]);
            self.leavings(self.root(), [p, &plus(p, &way)], work)
        })
    }
}

/// For each of `count` vertices, which are numbered by X, then Y, then Z, the first one of its component.
fn components(faces: &[[usize; 3]], count: usize) -> Vec<usize> {
    let mut first: Vec<_> = (0..count).collect();
    for [u, v, w] in faces {
        for edge in [[u, v], [v, w]] {
            let [one, other] = edge.map(|&(mut v)| {
                while first[v] != v {
                    first[v] = first[first[v]];
                    v = first[v];
                }
                v
            });
            first[one.max(other)] = one.min(other);
        }
    }
    // What a vertex names comes before it.
    (0..count).for_each(|v| first[v] = first[first[v]]);
    first
}

/// Whether faces pass along every edge as often one way as the other. Only then does every ray from a point leave the mesh equally often, and there is an inside.
pub fn is_closed<T: Copy + Ord>(faces: &[[T; 3]]) -> bool {
    let mut edges: Vec<_> = faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    let mut reversed: Vec<_> = edges.iter().map(|&[u, v]| [v, u]).collect();
    edges.sort_unstable();
    reversed.sort_unstable();
    edges == reversed
}

/// 1 or -1 where an edge surely passes through a triangle to one side or the other, 0 where it surely does not; `None` where neither is sure.
fn crossing([p, q]: [&V; 2], [u, v, w]: &[V; 3]) -> Option<i32> {
    let volume = |a: &V, b: &V, c: &V, d: &V| dot(&cross(&minus(b, a), &minus(c, a)), &minus(d, a));
    let ends = [volume(u, v, w, p), -volume(u, v, w, q)];
    let sides = [volume(p, q, u, v), volume(p, q, v, w), volume(p, q, w, u)];
    let differ = |numbers: &[I]| numbers.iter().any(|x| x.lo > 0.0) && numbers.iter().any(|x| x.hi < 0.0);
    if differ(&ends) || differ(&sides) {
        return Some(0);
    }
    let is_sure = ends.iter().chain(&sides).all(|x| x.lo > 0.0 || x.hi < 0.0);
    is_sure.then_some(if ends[0].lo > 0.0 { 1 } else { -1 })
}

/// Whether, of two triangles, an edge of either passes through the other for sure.
pub fn touch(a: &[V; 3], b: &[V; 3]) -> bool {
    let pierces = |one: &[V; 3], other| (0..3).any(|k| crossing([&one[k], &one[(k + 1) % 3]], other).unwrap_or(0) != 0);
    pierces(a, b) || pierces(b, a)
}

/// Whether no part of `inner` lies inside `outer`, given that their surfaces do not meet. Where `outer` has no inside, that is known beyond its box alone.
pub fn is_outside(inner: &Mesh, outer: &Mesh, outer_from_inner: &Pose, work: &Work) -> bool {
    let mut points = inner.components.iter().map(|p| outer_from_inner.point(p));
    let is_outside = |p: &V| outer.has_inside && outer.leaves(p, work) == Some(0);
    points.all(|p| work.take(1) && (are_apart(&p, &outer.boxes[1]) || is_outside(&p)))
}

/// Reads planes and halvings; all of the first mesh must be behind its planes.
pub fn front([a, b]: [&Mesh; 2], words: &mut Words<'_>, work: &Work) -> Result<Vec<Plane>, String> {
    let halved = |node: Node| node.halves().ok_or("one triangle is not halved");
    let (mut planes, mut open) = (Vec::new(), vec![[a.root(), b.root()]]);
    while let Some([x, y]) = open.pop() {
        match words.word()? {
            "a" => open.extend(halved(x)?.map(|half| [half, y]).into_iter().rev()),
            "b" => open.extend(halved(y)?.map(|half| [x, half]).into_iter().rev()),
            "p" => {
                let (normal, offset) = (words.vector()?, words.number()?);
                if normal == [ZERO; 3] || !a.is_beyond(x, &normal.map(Neg::neg), -offset, work) {
                    return Err(format!("the first part is not behind plane {}", planes.len() + 1));
                }
                planes.push(Plane { normal, offset: I::of(offset), b: y });
            }
            other => return Err(format!("`{other}` is neither a plane nor a halving")),
        }
    }
    Ok(planes)
}

/// A point of a file, mm, on the grid.
pub fn on_grid(p: [f64; 3]) -> Point {
    p.map(|x| (x * STEPS).round_ties_even() as i64)
}
