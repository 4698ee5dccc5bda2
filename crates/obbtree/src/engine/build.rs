//! Top-down construction, on as many threads as there are; the same tree for any number of them.
//!
//! A range of triangles becomes the children of a node by dividing its largest part again and again ([`super::split`]) until there are eight or
//! every part fits a node. Then parts of few triangles hand them to the node directly while it has room, which fills it.

use super::axis::Around;
use super::node::{Node, WIDTH, WideTree};
use super::patches::{self, Patch};
use super::split::{self, Frames, Halves, Item, Scratch};
use super::visit::node_slack;
use super::volume::WideVolume;
use crate::engine::geometry::{GridMesh, Point};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Ranges with more triangles than this are built on several threads; part of what decides the order of nodes.
const PARALLEL: usize = 512;
/// Parts of such a range that are divided before it is their turn, two at a time; both will be, unless one is much the larger.
const EAGER: usize = 4;
/// Widening of the ball around a mesh, relative: its radius is a few operations of `f64`, this is four thousand times 2⁻⁵³.
const BALL_PAD: f64 = 1e-12;

/// A range of items that becomes one child.
#[derive(Clone, Copy)]
struct Part {
    start: usize,
    end: usize,
    /// Which part is divided next.
    size: f32,
    /// How it is divided, where that is done already.
    halves: Option<Halves>,
}

impl Part {
    const fn new(start: usize, end: usize, size: f32) -> Self {
        Self { start, end, size, halves: None }
    }

    const fn len(&self) -> usize {
        self.end - self.start
    }
}

/// A part of the tree: its nodes, of which the first is its root, numbered from it on, and its triangles. The parts that hang below, if it was
/// divided among threads, are those of the nodes behind the root, in order.
struct Subtree<V: WideVolume> {
    nodes: Vec<Node<V>>,
    faces: Vec<u32>,
    below: Vec<Self>,
}

impl<V: WideVolume> Subtree<V> {
    /// How many nodes there are below the root of it and of all that hangs below.
    fn len(&self) -> usize {
        self.nodes.len() - 1 + self.below.iter().map(Self::len).sum::<usize>()
    }

    /// Puts the triangles of it and of all that hangs below behind those that are there.
    fn gather(&self, faces: &mut Vec<u32>) {
        faces.extend_from_slice(&self.faces);
        self.below.iter().for_each(|subtree| subtree.gather(faces));
    }

    /// Puts all nodes to where they belong, the root to place `at`, the others behind those that are there. `triangles` is how many come before
    /// its own; how many come before what follows is returned.
    fn lay(self, at: usize, nodes: &mut Vec<Node<V>>, triangles: u32) -> u32 {
        let first_node = nodes.len();
        let mut own = self.nodes.into_iter().map(|mut node| {
            node.first_node += first_node as u32 - 1;
            node.first_triangle += triangles;
            node
        });
        nodes[at] = own.next().expect("a subtree has a root");
        nodes.extend(own);
        let own = triangles + self.faces.len() as u32;
        (first_node..).zip(self.below).fold(own, |triangles, (at, subtree)| subtree.lay(at, nodes, triangles))
    }
}

impl<V: WideVolume> WideTree<V> {
    /// The tree over a mesh; the same on every machine and for any number of threads.
    ///
    /// # Panics
    /// When the mesh has more than 2²⁸ triangles: slots are numbered in 32 bits.
    #[must_use]
    pub fn build(mesh: &GridMesh) -> Self {
        assert!(mesh.faces().len() < (1 << 28), "slots are numbered in 32 bits");
        // Their corners are copies, gathered once: found by their vertices anew on each level they would cost a tenth of the build.
        let patches = patches::of(mesh);
        let (low, high) = patches
            .par_iter()
            .with_min_len(PARALLEL)
            .map(|patch| {
                patch.corners.iter().fold((patch.corners[0], patch.corners[0]), |(l, h), p| (l.inf(p), h.sup(p)))
            })
            .reduce_with(|(low, high), (l, h)| (low.inf(&l), high.sup(&h)))
            .expect("a mesh has a triangle");
        let middle = nalgebra::center(&low, &high);
        let origin = middle.coords.map(|x| x as f32).into();
        let mut root = Node::empty(origin);
        root.count = 1;
        let (nodes, (faces, triangles, vertices)) = if let [patch] = &*patches {
            root.put(0, &around_patch(patch, origin));
            root.paired = u8::from(patch.is_pair());
            root.slack = node_slack(&root);
            (vec![root], in_order(mesh, patch.faces().to_vec()))
        } else {
            let numbered = patches.par_iter().enumerate().with_min_len(PARALLEL);
            let mut items: Vec<Item> =
                numbered.map(|(number, patch)| Item::new(patch, &middle, number as u32)).collect();
            let frames = Frames::of(&items, V::TURNS);
            let volume: V = around(&patches, &items, &frames, origin);
            root.put(0, &volume);
            (root.inner, root.first_node) = (1, 1);
            root.slack = node_slack(&root);
            // The pool is entered once for all of it: each call from outside would wake a thread and wait for it. Entered for the whole build it
            // would cost page faults, since its threads give freed memory back: of 34 000 triangles 750 in the place of 90.
            let subtree = rayon::scope(|_| subtree(&patches, &mut items, &frames, centre_of(&volume, origin)));
            let mut faces = Vec::with_capacity(mesh.faces().len());
            subtree.gather(&mut faces);
            let nodes = || {
                let mut nodes = Vec::with_capacity(2 + subtree.len());
                nodes.extend([root, Node::empty(origin)]);
                subtree.lay(1, &mut nodes, 0);
                nodes
            };
            rayon::join(nodes, || in_order(mesh, faces))
        };
        let farthest = |from: &Point| vertices.iter().map(|v| (v - from).norm_squared()).fold(0.0, f64::max).sqrt();
        let (reach, radius) = (farthest(&Point::origin()), farthest(&middle));
        let ball = (middle, radius + BALL_PAD * (reach + radius));
        let mut tree = Self { nodes, triangles, vertices, faces, ball, reach: reach * (1.0 + BALL_PAD), around: None };
        tree.around = Around::of(&tree);
        tree
    }
}

/// Face numbers in tree order, the triangles as places in their vertices, and these as they come.
fn in_order(mesh: &GridMesh, faces: Vec<u32>) -> (Vec<u32>, Vec<[u32; 3]>, Vec<Point>) {
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
    (faces, triangles, vertices)
}

/// The volume around a patch.
fn around_patch<V: WideVolume>(patch: &Patch, origin: [f32; 3]) -> V {
    let axes = if V::TURNS { patch.frame() } else { Matrix3::identity() };
    V::fit(&axes, origin, std::iter::once(patch.corners))
}

/// The volume around several, of which `frames` were made.
fn around<V: WideVolume>(patches: &[Patch], items: &[Item], frames: &Frames, origin: [f32; 3]) -> V {
    V::fit(frames.least(), origin, items.iter().map(|item| patches[item.patch as usize].corners))
}

/// Where a volume's node has its origin.
fn centre_of<V: WideVolume>(volume: &V, origin: [f32; 3]) -> [f32; 3] {
    let centre = volume.centre();
    std::array::from_fn(|k| origin[k] + centre[k])
}

/// The subtree over at least two items, its root's candidate frames and origin given.
fn subtree<V: WideVolume>(patches: &[Patch], items: &mut [Item], frames: &Frames, origin: [f32; 3]) -> Subtree<V> {
    let mut own = Subtree { nodes: vec![Node::empty(origin)], faces: Vec::new(), below: Vec::new() };
    let mut scratch = Scratch::default();
    if items.len() <= PARALLEL {
        own.nodes.reserve(items.len() / 4);
        own.faces.reserve(2 * items.len());
        grow(patches, items, frames, &mut own, 0, &mut scratch);
        return own;
    }
    let inner = fill(patches, items, frames, &mut own, 0, &mut scratch);
    let mut ranges = Vec::with_capacity(inner.len());
    let (mut rest, mut done) = (items, 0);
    for ((part, frames, _), node) in inner.iter().zip(&own.nodes[1..]) {
        let (_, after) = std::mem::take(&mut rest).split_at_mut(part.start - done);
        let (range, after) = after.split_at_mut(part.len());
        (rest, done) = (after, part.end);
        ranges.push((range, frames, node.origin));
    }
    own.below = ranges.into_par_iter().map(|(range, frames, origin)| subtree(patches, range, frames, origin)).collect();
    own
}

/// Builds what is below a node, on this thread.
fn grow<V: WideVolume>(
    patches: &[Patch],
    items: &mut [Item],
    frames: &Frames,
    subtree: &mut Subtree<V>,
    at: usize,
    scratch: &mut Scratch,
) {
    let first = subtree.nodes.len();
    for (child, (part, frames, _)) in fill(patches, items, frames, subtree, at, scratch).iter().enumerate() {
        grow(patches, &mut items[part.start..part.end], frames, subtree, first + child, scratch);
    }
}

/// Gives node `at` its children: volumes, and empty nodes at the end of the list. Returns the ranges of the latter with their candidate frames and
/// volumes, in order.
fn fill<V: WideVolume>(
    patches: &[Patch],
    items: &mut [Item],
    frames: &Frames,
    subtree: &mut Subtree<V>,
    at: usize,
    scratch: &mut Scratch,
) -> Vec<(Part, Frames, V)> {
    let parts = children(items, frames, scratch);
    let (inner, single) = parts.split_at(parts.partition_point(|part| part.len() > 1));
    let mut node = Node::empty(subtree.nodes[at].origin);
    node.first_node = subtree.nodes.len() as u32;
    node.first_triangle = subtree.faces.len() as u32;
    node.inner = inner.len() as u8;
    node.count = parts.len() as u8;
    let framed = |&part: &Part| {
        let items = &items[part.start..part.end];
        let frames = Frames::of(items, V::TURNS);
        (part, frames, around(patches, items, &frames, node.origin))
    };
    let framed: Vec<(Part, Frames, V)> = if items.len() > PARALLEL {
        inner.par_iter().map(framed).collect()
    } else {
        inner.iter().map(framed).collect()
    };
    for (place, (_, _, volume)) in framed.iter().enumerate() {
        node.put(place, volume);
        subtree.nodes.push(Node::empty(centre_of(volume, node.origin)));
    }
    for (place, part) in (framed.len()..).zip(single) {
        let patch = &patches[items[part.start].patch as usize];
        node.put(place, &around_patch(patch, node.origin));
        node.paired += u8::from(patch.is_pair());
        subtree.faces.extend_from_slice(patch.faces());
    }
    node.slack = node_slack(&node);
    subtree.nodes[at] = node;
    framed
}

/// Divides at least two items into two to eight parts: those of several items first, each kind in the order of the items.
fn children(items: &mut [Item], frames: &Frames, scratch: &mut Scratch) -> Vec<Part> {
    let mut parts = Vec::with_capacity(WIDTH);
    parts.push(Part::new(0, items.len(), 1.0));
    while parts.len() < WIDTH {
        let divisible = (0..parts.len()).filter(|&i| parts[i].len() > WIDTH);
        let Some(largest) = divisible.max_by(|&i, &j| parts[i].size.total_cmp(&parts[j].size)) else { break };
        let Part { start, end, halves, .. } = parts[largest];
        let Halves { left, sizes } = halves.unwrap_or_else(|| split::divide(&mut items[start..end], frames, scratch));
        let (mut first, mut second) =
            (Part::new(start, start + left, sizes[0]), Part::new(start + left, end, sizes[1]));
        // While there are few of them, each is likely to be divided next.
        if parts.len() < EAGER && end - start > PARALLEL {
            let (ours, theirs) = items[start..end].split_at_mut(left);
            let halves = |items: &mut [Item]| {
                (items.len() > WIDTH).then(|| split::divide(items, frames, &mut Scratch::default()))
            };
            (first.halves, second.halves) = rayon::join(|| halves(ours), || halves(theirs));
        }
        parts[largest] = first;
        parts.push(second);
    }
    loop {
        let few = (0..parts.len()).filter(|&i| (2..=WIDTH).contains(&parts[i].len())).min_by_key(|&i| parts[i].len());
        match few {
            Some(i) if parts.len() - 1 + parts[i].len() <= WIDTH => {
                let Part { start, end, size, .. } = parts.swap_remove(i);
                parts.extend((start..end).map(|k| Part::new(k, k + 1, size)));
            }
            _ => break,
        }
    }
    let order = |part: &Part| if part.len() > 1 { 0 } else { 1 + u8::from(!items[part.start].is_pair) };
    parts.sort_unstable_by_key(|part| (order(part), part.start));
    parts
}
