//! Which triangles of two trees touch at a pose.
//!
//! A stack of pairs of slots whose boxes may overlap. Two pairs are taken at a time; of each the larger box is opened and the
//! other moved into its node's frame, where one pass over the lanes ([`super::boxes`]) tests it against all children. Pairs of
//! triangles gather until there are eight ([`super::triangles`]). The deepest overlap is taken first: that is where a contact is likely.

use super::boxes::{self, Found, Visit};
use super::lanes::{Machine, Simd, Work};
use super::node::{Contents, WIDTH, WideTree};
use super::pose::{Pose, Seen};
use super::triangles::{self, Batch};
use crate::geometry::Isometry;
use crate::geometry::grid::Placement;
use crate::tree::traverse::Probe;
use std::ops::ControlFlow;

/// Memory that queries reuse, so that a timed query does not allocate.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// A slot of `a` and a slot of `b`.
    stack: Vec<(u32, u32)>,
}

/// Calls `on_contact(face_of_a, face_of_b)` for every pair of triangles that touch, exactly, until it breaks.
pub fn traverse<B>(
    trees: (&WideTree, &WideTree),
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
    mut on_contact: impl FnMut(u32, u32) -> ControlFlow<B>,
) -> ControlFlow<B> {
    let (a, b) = trees;
    probe.volume_test();
    if balls_apart(a, b, a_from_b) {
        return ControlFlow::Continue(());
    }
    let pose = Pose::new(a_from_b, a.reach + b.reach);
    let placement = Placement::new(a_from_b);
    let contact = |(i, j): (u32, u32)| on_contact(a.faces[i as usize], b.faces[j as usize]);
    simd.run(Traversal { a, b, pose, placement, stack: &mut scratch.stack, probe, contact, batch: Batch::default() })
}

/// Mode `first`: whether the meshes touch at all.
pub fn first(
    a: &WideTree,
    b: &WideTree,
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
) -> bool {
    traverse((a, b), a_from_b, simd, scratch, probe, |_, _| ControlFlow::Break(())).is_break()
}

/// Mode `all`: every pair of faces that touch, as (face of `a`, face of `b`), sorted.
pub fn all(
    a: &WideTree,
    b: &WideTree,
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
) -> Vec<(u32, u32)> {
    let mut contacts = Vec::new();
    let _ = traverse((a, b), a_from_b, simd, scratch, probe, |face_a, face_b| {
        contacts.push((face_a, face_b));
        ControlFlow::<()>::Continue(())
    });
    contacts.sort_unstable();
    contacts
}

/// Whether the balls around the meshes are apart, which settles most poses of a machine. The radii have been widened against
/// rounding here ([`super::build`]).
fn balls_apart(a: &WideTree, b: &WideTree, a_from_b: &Isometry) -> bool {
    let (centre_a, radius_a) = a.ball;
    let (centre_b, radius_b) = b.ball;
    let between = a_from_b * centre_b - centre_a;
    let slack = Pose::ball_slack(a_from_b, a.reach + b.reach);
    between.norm_squared() > (radius_a + radius_b + slack).powi(2)
}

/// One query.
struct Traversal<'a, P, F> {
    a: &'a WideTree,
    b: &'a WideTree,
    pose: Pose,
    placement: Placement,
    stack: &'a mut Vec<(u32, u32)>,
    probe: &'a mut P,
    contact: F,
    batch: Batch,
}

/// What is opened in a visit.
#[derive(Clone, Copy)]
struct Opened {
    /// The slot that stays as it is.
    one: u32,
    /// The node whose children are tested against it.
    node: u32,
    /// Whether that node is of `b`.
    of_b: bool,
}

impl<B, P: Probe, F: FnMut((u32, u32)) -> ControlFlow<B>> Work for Traversal<'_, P, F> {
    type Output = ControlFlow<B>;

    #[inline(always)]
    fn run<M: Machine>(mut self) -> ControlFlow<B> {
        self.stack.clear();
        // Node 0 of `a` holds the root alone; `b`'s root is slot 0.
        self.visit::<M>(&[Opened { one: 0, node: 0, of_b: false }])?;
        while let Some(top) = self.stack.pop() {
            let top = self.open(top);
            match self.stack.pop() {
                Some(next) => self.visit::<M>(&[top, self.open(next)])?,
                None => self.visit::<M>(&[top])?,
            }
        }
        self.test::<M>()
    }
}

impl<'a, B, P: Probe, F: FnMut((u32, u32)) -> ControlFlow<B>> Traversal<'a, P, F> {
    /// Of two boxes the larger is opened, the second on a tie; never a triangle's. Not both are triangles'.
    #[inline(always)]
    fn open(&self, (x, y): (u32, u32)) -> Opened {
        let area = |tree: &WideTree, slot| {
            let (node, place) = tree.slot(slot);
            node.code(place).area()
        };
        match (self.a.contents(x), self.b.contents(y)) {
            (Contents::Node(node), Contents::Triangle(_)) => Opened { one: y, node, of_b: false },
            (Contents::Node(node), Contents::Node(_)) if area(self.a, x) > area(self.b, y) => {
                Opened { one: y, node, of_b: false }
            }
            // Two triangles are tested, never pushed.
            (_, Contents::Node(node) | Contents::Triangle(node)) => Opened { one: x, node, of_b: true },
        }
    }

    /// Tests the one box of each visit against the children of its node, and keeps what may overlap.
    #[inline(always)]
    fn visit<M: Machine>(&mut self, opened: &[Opened]) -> ControlFlow<B> {
        let mut found = [Found::default(); 2];
        match *opened {
            [one] => boxes::visit::<M::Single>(&[self.see(one)], &mut found),
            [one, other] => boxes::visit::<M::Single>(&[self.see(one), self.see(other)], &mut found),
            _ => {}
        }
        // The last on the stack is the next to be opened: the first visit's.
        for (opened, found) in opened.iter().zip(&found).rev() {
            self.keep::<M>(*opened, found)?;
        }
        ControlFlow::Continue(())
    }

    /// The one box as seen from the node.
    #[inline(always)]
    fn see(&self, opened: Opened) -> Visit<'a> {
        let (tree, other, motion) =
            if opened.of_b { (self.b, self.a, &self.pose.b_from_a) } else { (self.a, self.b, &self.pose.a_from_b) };
        let node = &tree.nodes[opened.node as usize];
        let (holder, place) = other.slot(opened.one);
        let one = Seen::new(motion, &holder.code(place), &holder.origin, node, self.pose.slack);
        Visit { node, one }
    }

    /// Pairs with a node in them go to the stack, the deepest overlap last; pairs of triangles to the batch.
    #[inline(always)]
    fn keep<M: Machine>(&mut self, opened: Opened, found: &Found) -> ControlFlow<B> {
        let tree = if opened.of_b { self.b } else { self.a };
        let other = if opened.of_b { self.a } else { self.b };
        let node = &tree.nodes[opened.node as usize];
        for _ in 0..node.count {
            self.probe.volume_test();
        }
        let mut live = found.live;
        if live == 0 {
            return ControlFlow::Continue(());
        }
        if let Contents::Triangle(one) = other.contents(opened.one) {
            let inner = ((1_u32 << node.inner) - 1) as u8;
            let mut pairs = live & !inner;
            live &= inner;
            while pairs != 0 {
                let place = pairs.trailing_zeros();
                pairs &= pairs - 1;
                let triangle = node.first_triangle + place - u32::from(node.inner);
                let (i, j) = if opened.of_b { (one, triangle) } else { (triangle, one) };
                if self.batch.push(i, j) {
                    self.test::<M>()?;
                }
            }
        }
        let mut deepest: Option<(f32, u32)> = None;
        while live != 0 {
            let place = live.trailing_zeros();
            live &= live - 1;
            let slot = opened.node * WIDTH as u32 + place;
            let gap = found.gap[place as usize];
            let later = match deepest {
                Some((least, before)) if gap < least => {
                    deepest = Some((gap, slot));
                    before
                }
                Some(_) => slot,
                None => {
                    deepest = Some((gap, slot));
                    continue;
                }
            };
            self.stack.push(if opened.of_b { (opened.one, later) } else { (later, opened.one) });
        }
        if let Some((_, slot)) = deepest {
            self.stack.push(if opened.of_b { (opened.one, slot) } else { (slot, opened.one) });
        }
        ControlFlow::Continue(())
    }

    /// Tests the pairs that wait.
    #[inline(always)]
    fn test<M: Machine>(&mut self) -> ControlFlow<B> {
        for _ in 0..self.batch.len() {
            self.probe.triangle_test();
        }
        let pairs = self.batch;
        let mut left = self.batch.unparted::<M::Double>(self.a, self.b, &self.placement);
        while left != 0 {
            let pair = pairs.pair(left.trailing_zeros() as usize);
            left &= left - 1;
            if triangles::touch(self.a, self.b, &self.placement, pair) {
                (self.contact)(pair)?;
            }
        }
        ControlFlow::Continue(())
    }
}
