//! Top-down construction, on as many threads as there are; the same tree for any number of them.
//!
//! A range of triangles becomes the children of a node by dividing its largest part again and again ([`super::split`]) until there are eight or
//! every part fits a node. Then parts of few triangles hand them to the node directly while it has room, which fills it.

use super::node::{Node, WIDTH, WideTree};
use super::split::{self, Frames, Item, Scratch};
use super::visit::node_slack;
use super::volume::WideVolume;
use crate::geometry::{Mesh, Point, Triangle, triangle};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Ranges with more triangles than this are built on several threads; part of what decides the order of nodes.
const PARALLEL: usize = 4096;
/// Widening of the ball around a mesh, relative: its radius is a few operations of `f64`, this is four thousand times 2⁻⁵³.
const BALL_PAD: f64 = 1e-12;

/// A range of items that becomes one child.
#[derive(Clone, Copy)]
struct Part {
    start: usize,
    end: usize,
    /// Which part is divided next.
    size: f32,
}

impl Part {
    const fn len(&self) -> usize {
        self.end - self.start
    }
}

/// Nodes and triangles of a subtree, numbered from 0; node 0 is its root.
struct Subtree<V: WideVolume> {
    nodes: Vec<Node<V>>,
    faces: Vec<u32>,
}

impl<V: WideVolume> WideTree<V> {
    /// The tree over a mesh; the same on every machine and for any number of threads.
    ///
    /// # Panics
    /// When the mesh has more than 2²⁸ triangles: slots are numbered in 32 bits.
    #[must_use]
    pub fn build(mesh: &Mesh) -> Self {
        let triangles = mesh.triangles();
        assert!(triangles.len() < (1 << 28), "slots are numbered in 32 bits");
        let (low, high) = triangle::bounds(&triangles).expect("a mesh has a triangle");
        let middle = nalgebra::center(&low, &high);
        let mut items: Vec<Item> =
            triangles.iter().zip(0..).map(|(triangle, face)| Item::new(triangle, &middle, face)).collect();
        let origin = middle.coords.map(|x| x as f32).into();
        let mut root = Node::empty(origin);
        root.count = 1;
        let mut nodes = vec![root];
        let mut faces = vec![0];
        if items.len() == 1 {
            nodes[0].put(0, &around_one(&triangles[0], origin));
        } else {
            nodes[0].inner = 1;
            nodes[0].first_node = 1;
            let frames = Frames::of(&items);
            let volume: V = around(&triangles, &items, &frames, origin);
            nodes[0].put(0, &volume);
            let mut subtree = subtree(&triangles, &mut items, &frames, centre_of(&volume, origin));
            shift(&mut subtree.nodes, 1, 0);
            nodes.append(&mut subtree.nodes);
            faces = subtree.faces;
        }
        nodes[0].slack = node_slack(&nodes[0]);
        let (triangles, vertices) = in_order(mesh, &faces);
        let farthest = |from: &Point| vertices.iter().map(|v| (v - from).norm_squared()).fold(0.0, f64::max).sqrt();
        let (reach, radius) = (farthest(&Point::origin()), farthest(&middle));
        let ball = (middle, radius + BALL_PAD * (reach + radius));
        Self { nodes, triangles, vertices, faces, ball, reach: reach * (1.0 + BALL_PAD) }
    }
}

/// The triangles in tree order as places in their vertices, which are numbered as they come.
fn in_order(mesh: &Mesh, faces: &[u32]) -> (Vec<[u32; 3]>, Vec<Point>) {
    const UNSEEN: u32 = u32::MAX;
    let mut place = vec![UNSEEN; mesh.vertices().len()];
    let mut vertices = Vec::with_capacity(mesh.vertices().len());
    let triangles = faces
        .iter()
        .map(|&face| {
            mesh.faces()[face as usize].map(|vertex| {
                let place = &mut place[vertex as usize];
                if *place == UNSEEN {
                    *place = vertices.len() as u32;
                    vertices.push(mesh.vertices()[vertex as usize]);
                }
                *place
            })
        })
        .collect();
    vertices.shrink_to_fit();
    (triangles, vertices)
}

/// The volume around a single triangle.
fn around_one<V: WideVolume>(triangle: &Triangle, origin: [f32; 3]) -> V {
    let axes = if V::TURNS { split::frame_of(triangle) } else { Matrix3::identity() };
    V::fit(&axes, origin, std::iter::once(triangle.corners.as_slice()))
}

/// The volume around several, of which `frames` were made.
fn around<V: WideVolume>(triangles: &[Triangle], items: &[Item], frames: &Frames, origin: [f32; 3]) -> V {
    let points = items.iter().map(|item| triangles[item.face as usize].corners.as_slice());
    let axes = if V::TURNS { frames.least(items) } else { Matrix3::identity() };
    V::fit(&axes, origin, points)
}

/// Where a volume's node has its origin.
fn centre_of<V: WideVolume>(volume: &V, origin: [f32; 3]) -> [f32; 3] {
    let centre = volume.centre();
    std::array::from_fn(|k| origin[k] + centre[k])
}

/// The subtree over at least two items, its root's candidate frames and origin given.
fn subtree<V: WideVolume>(triangles: &[Triangle], items: &mut [Item], frames: &Frames, origin: [f32; 3]) -> Subtree<V> {
    let mut own = Subtree { nodes: vec![Node::empty(origin)], faces: Vec::new() };
    let mut scratch = Scratch::default();
    if items.len() <= PARALLEL {
        grow(triangles, items, frames, &mut own, 0, &mut scratch);
        return own;
    }
    let inner = fill(triangles, items, frames, &mut own, 0, &mut scratch);
    let origins: Vec<[f32; 3]> = own.nodes[1..].iter().map(|node| node.origin).collect();
    let mut ranges = Vec::with_capacity(inner.len());
    let (mut rest, mut done) = (items, 0);
    for ((part, frames), origin) in inner.iter().zip(origins) {
        let (_, after) = std::mem::take(&mut rest).split_at_mut(part.start - done);
        let (range, after) = after.split_at_mut(part.len());
        (rest, done) = (after, part.end);
        ranges.push((range, frames, origin));
    }
    let subtrees: Vec<Subtree<V>> =
        ranges.into_par_iter().map(|(range, frames, origin)| subtree(triangles, range, frames, origin)).collect();
    for (child, mut subtree) in subtrees.into_iter().enumerate() {
        let (first_node, first_triangle) = (own.nodes.len() as u32, own.faces.len() as u32);
        // The subtree's root already has its place among its siblings.
        shift(&mut subtree.nodes, first_node - 1, first_triangle);
        let mut nodes = subtree.nodes.into_iter();
        own.nodes[1 + child] = nodes.next().expect("a subtree has a root");
        own.nodes.extend(nodes);
        own.faces.append(&mut subtree.faces);
    }
    own
}

/// Adds to the numbers of nodes and triangles that nodes refer to.
fn shift<V: WideVolume>(nodes: &mut [Node<V>], by_nodes: u32, by_triangles: u32) {
    for node in nodes {
        node.first_node += by_nodes;
        node.first_triangle += by_triangles;
    }
}

/// Builds what is below a node, on this thread.
fn grow<V: WideVolume>(
    triangles: &[Triangle],
    items: &mut [Item],
    frames: &Frames,
    subtree: &mut Subtree<V>,
    at: usize,
    scratch: &mut Scratch,
) {
    let first = subtree.nodes.len();
    for (child, (part, frames)) in fill(triangles, items, frames, subtree, at, scratch).iter().enumerate() {
        grow(triangles, &mut items[part.start..part.end], frames, subtree, first + child, scratch);
    }
}

/// Gives node `at` its children: volumes, and empty nodes at the end of the list. Returns the ranges of the latter with their candidate frames, in
/// order.
fn fill<V: WideVolume>(
    triangles: &[Triangle],
    items: &mut [Item],
    frames: &Frames,
    subtree: &mut Subtree<V>,
    at: usize,
    scratch: &mut Scratch,
) -> Vec<(Part, Frames)> {
    let parts = children(items, frames, scratch);
    let (inner, single): (Vec<Part>, Vec<Part>) = parts.iter().partition(|part| part.len() > 1);
    let mut node = Node::empty(subtree.nodes[at].origin);
    node.first_node = subtree.nodes.len() as u32;
    node.first_triangle = subtree.faces.len() as u32;
    node.inner = inner.len() as u8;
    node.count = parts.len() as u8;
    let framed = |part: Part| {
        let items = &items[part.start..part.end];
        let frames = Frames::of(items);
        (part, frames, around(triangles, items, &frames, node.origin))
    };
    let framed: Vec<(Part, Frames, V)> = if items.len() > PARALLEL {
        inner.into_par_iter().map(framed).collect()
    } else {
        inner.into_iter().map(framed).collect()
    };
    for (place, (_, _, volume)) in framed.iter().enumerate() {
        node.put(place, volume);
        subtree.nodes.push(Node::empty(centre_of(volume, node.origin)));
    }
    for (place, part) in (framed.len()..).zip(&single) {
        let face = items[part.start].face;
        node.put(place, &around_one(&triangles[face as usize], node.origin));
        subtree.faces.push(face);
    }
    node.slack = node_slack(&node);
    subtree.nodes[at] = node;
    framed.into_iter().map(|(part, frames, _)| (part, frames)).collect()
}

/// Divides at least two items into two to eight parts, in the order of the items.
fn children(items: &mut [Item], frames: &Frames, scratch: &mut Scratch) -> Vec<Part> {
    let mut parts = vec![Part { start: 0, end: items.len(), size: 1.0 }];
    while parts.len() < WIDTH {
        let divisible = (0..parts.len()).filter(|&i| parts[i].len() > WIDTH);
        let Some(largest) = divisible.max_by(|&i, &j| parts[i].size.total_cmp(&parts[j].size)) else { break };
        let Part { start, end, .. } = parts[largest];
        let (left, sizes) = split::divide(&mut items[start..end], frames, scratch);
        parts[largest] = Part { start, end: start + left, size: sizes[0] };
        parts.push(Part { start: start + left, end, size: sizes[1] });
    }
    loop {
        let few = (0..parts.len()).filter(|&i| (2..=WIDTH).contains(&parts[i].len())).min_by_key(|&i| parts[i].len());
        match few {
            Some(i) if parts.len() - 1 + parts[i].len() <= WIDTH => {
                let Part { start, end, size } = parts.swap_remove(i);
                parts.extend((start..end).map(|k| Part { start: k, end: k + 1, size }));
            }
            _ => break,
        }
    }
    parts.sort_unstable_by_key(|part| part.start);
    parts
}
