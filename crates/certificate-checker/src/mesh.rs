//! Meshes on the grid of 2⁻²⁶ mm, in whole numbers: hulls of ranges of triangles behind planes, piercing edges, and what is inside.

use crate::interval::{I, Pose, V, cross, dot, minus};
use crate::read::Words;
use std::collections::BTreeSet;

/// Steps of the grid in a mm.
const STEPS: i64 = 1 << 26;
/// Largest coordinate, mm.
const LIMIT: i64 = 4096 * STEPS;

/// Lowest and highest corner.
type Bounds = [[i64; 3]; 2];

/// Vertices and faces, in the order of the tree: node 1 has all faces, the halves of node `i` are `2i` and `2i + 1`.
#[derive(Debug, Default)]
pub struct Mesh {
    vertices: Vec<[i64; 3]>,
    faces: Vec<[u32; 3]>,
    boxes: Vec<Bounds>,
    /// Centre and radius of a ball around all, mm.
    pub ball: (V, I),
    is_watertight: bool,
    /// One vertex of each connected component.
    components: Vec<[i64; 3]>,
}

/// A range of faces.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    id: usize,
    low: usize,
    high: usize,
}

/// A plane, and the node of the second mesh that lies beyond it.
#[derive(Debug)]
pub struct Token {
    pub normal: [i32; 3],
    pub offset: i64,
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

fn mm(p: &[i64; 3]) -> V {
    p.map(|x| I::of(x as f64 / STEPS as f64)) // at most 38 bits: exact
}

fn around<'a>(points: impl Iterator<Item = &'a [i64; 3]>) -> Bounds {
    points.fold([[i64::MAX; 3], [i64::MIN; 3]], |[low, high], p| {
        [std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i]))]
    })
}

impl Mesh {
    pub fn vertex(&mut self, words: &mut Words<'_>) -> Result<(), String> {
        let p = [words.whole::<i64>()?, words.whole()?, words.whole()?];
        self.vertices.push(p);
        if p.iter().all(|x| (-LIMIT..=LIMIT).contains(x)) { Ok(()) } else { Err("a vertex out of range".to_owned()) }
    }

    pub fn face(&mut self, words: &mut Words<'_>) -> Result<(), String> {
        let face = [words.whole::<u32>()?, words.whole()?, words.whole()?];
        self.faces.push(face);
        let is_known = face.iter().all(|&v| (v as usize) < self.vertices.len());
        if is_known { Ok(()) } else { Err("no such vertex".to_owned()) }
    }

    /// Boxes around nodes, and a ball around all.
    pub fn finish(&mut self) -> Result<(), String> {
        if self.faces.is_empty() {
            return Err("a mesh without a face".to_owned());
        }
        self.weld()?;
        self.boxes = vec![Bounds::default(); 2 * self.faces.len().next_power_of_two()];
        let [low, high] = self.enclose(self.root());
        let middle = std::array::from_fn(|i| (low[i] + high[i]) / 2);
        let centre = mm(&middle);
        let squared = |p: &[i64; 3]| (0..3).map(|i| i128::from(p[i] - middle[i]).pow(2)).sum::<i128>();
        let farthest = self.vertices.iter().map(squared).max().unwrap_or(0) as f64;
        let radius = I::outward(farthest, farthest).sqrt();
        self.ball = (centre, I::of((radius * I::of(1.0 / STEPS as f64)).hi));
        self.is_watertight = self.has_inside();
        self.components = self.components();
        Ok(())
    }

    /// Makes vertices in one place one, so that neither they nor a face that is there twice can hide that the mesh has an inside.
    fn weld(&mut self) -> Result<(), String> {
        let mut places = std::mem::take(&mut self.vertices);
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_unstable_by_key(|&v| places[v]);
        let mut number = vec![0; places.len()];
        for two in order.windows(2) {
            number[two[1]] = number[two[0]] + u32::from(places[two[0]] != places[two[1]]);
        }
        places.sort_unstable();
        places.dedup();
        self.vertices = places;
        self.faces.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
        let mut faces = self.faces.clone();
        faces.iter_mut().for_each(|face| face.sort_unstable());
        faces.sort_unstable();
        if faces.windows(2).any(|two| two[0] == two[1]) { Err("a face is there twice".to_owned()) } else { Ok(()) }
    }

    fn root(&self) -> Node {
        Node { id: 1, low: 0, high: self.faces.len() }
    }

    fn corners(&self, node: Node) -> impl Iterator<Item = &[i64; 3]> {
        self.faces[node.low..node.high].iter().flatten().map(|&v| &self.vertices[v as usize])
    }

    pub fn triangle(&self, face: usize) -> Option<[V; 3]> {
        self.faces.get(face).map(|face| face.map(|v| mm(&self.vertices[v as usize])))
    }

    /// Triangles as triples of grid points, each from its least corner on; for comparison with a file.
    pub fn triangles(&self) -> BTreeSet<[[i64; 3]; 3]> {
        self.faces.iter().map(|face| canonical(face.map(|v| self.vertices[v as usize]))).collect()
    }

    fn enclose(&mut self, node: Node) -> Bounds {
        let found = match node.halves() {
            None => around(self.corners(node)),
            Some(halves) => {
                let both = halves.map(|half| self.enclose(half));
                around(both.iter().flatten())
            }
        };
        self.boxes[node.id] = found;
        found
    }

    /// Whether all corners of a node are in a half space, which is asked about boxes first; a box of one point is that point.
    fn is_within(&self, node: Node, half_space: &impl Fn(&Bounds) -> bool) -> bool {
        half_space(&self.boxes[node.id])
            || match node.halves() {
                Some(halves) => halves.into_iter().all(|half| self.is_within(half, half_space)),
                None => self.corners(node).all(|p| half_space(&[*p; 2])),
            }
    }

    /// Whether n·x <= c for all corners x of a node, computed in whole numbers, without rounding.
    fn is_behind(&self, node: Node, n: [i64; 3], c: i128) -> bool {
        let farthest =
            |[low, high]: &Bounds, i: usize| i128::from(n[i]) * i128::from(if n[i] > 0 { high[i] } else { low[i] });
        self.is_within(node, &|bounds| (0..3).map(|i| farthest(bounds, i)).sum::<i128>() <= c)
    }

    /// Whether n·x >= c for all corners x of a node, mm.
    pub fn is_beyond(&self, node: Node, n: &V, c: f64) -> bool {
        self.is_within(node, &|bounds| {
            let [low, high] = bounds.each_ref().map(mm);
            dot(n, &[0, 1, 2].map(|i| low[i].hull(high[i]))).lo >= c
        })
    }

    /// Whether every edge joins two faces that agree about the outside: only then is there an inside.
    fn has_inside(&self) -> bool {
        let mut edges: Vec<[u32; 2]> = self.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let mut reversed: Vec<[u32; 2]> = edges.iter().map(|&[u, v]| [v, u]).collect();
        edges.sort_unstable();
        reversed.sort_unstable();
        edges == reversed && edges.windows(2).all(|two| two[0] != two[1])
    }

    fn components(&self) -> Vec<[i64; 3]> {
        let mut beside = vec![Vec::new(); self.vertices.len()];
        for face in &self.faces {
            (0..3).for_each(|k| beside[face[k] as usize].push(face[(k + 1) % 3]));
        }
        let mut found = Vec::new();
        for &[first, ..] in &self.faces {
            if !beside[first as usize].is_empty() {
                found.push(self.vertices[first as usize]);
            }
            let mut open = vec![first];
            while let Some(v) = open.pop() {
                open.append(&mut beside[v as usize]);
            }
        }
        found
    }

    /// The number of times that a ray leaves the mesh, less the number of times that it enters it; `None` where it passes too near to an edge to decide.
    fn leavings(&self, node: Node, start: &V, way: &V) -> Option<i32> {
        let [low, high] = self.boxes[node.id].each_ref().map(mm);
        // Along the ray x grows by as much as the parameter.
        let along = low[0].hull(high[0]) - start[0];
        let meets = |i: usize| {
            let at = start[i] + way[i] * I { lo: along.lo.max(0.0), hi: along.hi };
            at.lo <= high[i].hi && at.hi >= low[i].lo
        };
        if along.hi < 0.0 || !meets(1) || !meets(2) {
            return Some(0);
        }
        if let Some([one, other]) = node.halves() {
            return Some(self.leavings(one, start, way)? + self.leavings(other, start, way)?);
        }
        (node.low..node.high).map(|face| crossing(&self.triangle(face)?, start, way)).sum()
    }
}

/// Whether all numbers surely have one sign.
fn are_alike(numbers: &[I]) -> bool {
    numbers.iter().all(|x| x.lo > 0.0) || numbers.iter().all(|x| x.hi < 0.0)
}

/// 1 where a ray leaves the mesh through a triangle, -1 where it enters, 0 where it misses the triangle.
fn crossing(triangle: &[V; 3], start: &V, way: &V) -> Option<i32> {
    let [a, b, c] = triangle.each_ref().map(|p| minus(p, start));
    let sides = [cross(&a, &b), cross(&b, &c), cross(&c, &a)].map(|side| dot(way, &side));
    if sides.iter().any(|side| side.lo > 0.0) && sides.iter().any(|side| side.hi < 0.0) {
        return Some(0);
    }
    if !are_alike(&sides) {
        return None;
    }
    let normal = cross(&minus(&b, &a), &minus(&c, &a));
    let (height, slope) = (dot(&normal, &a), dot(&normal, way));
    let is_ahead = height.over(slope);
    if is_ahead.hi < 0.0 {
        return Some(0);
    }
    (is_ahead.lo > 0.0).then_some(if slope.lo > 0.0 { 1 } else { -1 })
}

/// Whether no part of `inner` lies inside `outer`, given that their surfaces do not meet.
pub fn is_outside(inner: &Mesh, outer: &Mesh, outer_from_inner: &Pose) -> bool {
    const WAYS: [[f64; 2]; 6] =
        [[0.0123, 0.0271], [-0.0317, 0.0071], [0.0557, -0.0413], [-0.071, -0.0887], [0.213, 0.151], [-0.317, 0.273]];
    if !outer.is_watertight {
        return true; // has no inside
    }
    inner
        .components
        .iter()
        .map(|p| outer_from_inner.point(&mm(p)))
        .all(|p| WAYS.iter().any(|[y, z]| outer.leavings(outer.root(), &p, &[1.0, *y, *z].map(I::of)) == Some(0)))
}

/// Reads planes and halvings; all of the first mesh must be behind its planes.
pub fn front(a: &Mesh, b: &Mesh, words: &mut Words<'_>) -> Result<Vec<Token>, String> {
    let (mut planes, mut open) = (Vec::new(), vec![[a.root(), b.root()]]);
    while let Some([x, y]) = open.pop() {
        match words.word()? {
            "a" => open.extend(x.halves().ok_or("one triangle is not halved")?.map(|half| [half, y]).into_iter().rev()),
            "b" => open.extend(y.halves().ok_or("one triangle is not halved")?.map(|half| [x, half]).into_iter().rev()),
            "p" => {
                let (normal, offset): ([i32; 3], i64) =
                    ([words.whole()?, words.whole()?, words.whole()?], words.whole()?);
                if normal == [0; 3]
                    || offset.unsigned_abs() > 1 << 52
                    || !a.is_behind(x, normal.map(i64::from), i128::from(offset) * i128::from(STEPS))
                {
                    return Err(format!("the first part is not behind the plane {normal:?} {offset}"));
                }
                planes.push(Token { normal, offset, b: y });
            }
            other => return Err(format!("`{other}` is neither a plane nor a halving")),
        }
    }
    Ok(planes)
}

/// Reads an edge and a triangle; the edge must pierce it.
pub fn pierces([a, b]: [&Mesh; 2], a_from_b: &Pose, words: &mut Words<'_>) -> Result<(), String> {
    let (side, of, edge, face) =
        (words.word()?, words.whole::<usize>()?, words.whole::<usize>()?, words.whole::<usize>()?);
    let moved = |face: usize| Some(b.triangle(face)?.each_ref().map(|p| a_from_b.point(p)));
    let found = match side {
        "a" => a.triangle(of).zip(moved(face)),
        "b" => moved(of).zip(a.triangle(face)),
        _ => None,
    };
    let (edges, [u, v, w]) = found.filter(|_| edge < 3).ok_or("no such triangle or edge")?;
    let (p, q) = (edges[edge], edges[(edge + 1) % 3]);
    let volume = |a: &V, b: &V, c: &V, d: &V| dot(&cross(&minus(b, a), &minus(c, a)), &minus(d, a));
    let (above, below) = (volume(&u, &v, &w, &p), volume(&u, &v, &w, &q));
    let sides = [volume(&p, &q, &u, &v), volume(&p, &q, &v, &w), volume(&p, &q, &w, &u)];
    if are_alike(&[above, -below]) && are_alike(&sides) {
        Ok(())
    } else {
        Err("the edge does not pierce the triangle".to_owned())
    }
}

/// The triangle from its least corner on.
pub fn canonical(mut triangle: [[i64; 3]; 3]) -> [[i64; 3]; 3] {
    let least = (0..3).min_by_key(|&k| triangle[k]).unwrap_or(0);
    triangle.rotate_left(least);
    triangle
}

/// A point of a file, mm, on the grid.
pub fn on_grid(p: [f64; 3]) -> [i64; 3] {
    p.map(|x| (x * STEPS as f64).round_ties_even() as i64)
}
