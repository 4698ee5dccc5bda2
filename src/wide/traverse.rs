//! Which triangles of two trees touch at a pose.
//!
//! A stack of pairs of slots whose boxes may overlap. Two pairs are taken at a time; of each the larger box is opened and the
//! other moved into its node's frame, where one pass over the lanes ([`super::boxes`]) tests it against all children. Pairs of
//! triangles gather and are tested four at a time ([`super::triangles`]). The deepest overlap is taken first: that is where a contact is likely.

use super::boxes::{self, Found};
use super::lanes::{Machine, Simd, Work};
use super::node::{Contents, WIDTH, WideTree};
use super::pose::Pose;
use super::posed::{Opened, Posed};
use super::triangles::{self, Batch};
use crate::geometry::Isometry;
use crate::tree::traverse::Probe;
use std::ops::ControlFlow;

/// Memory that queries reuse, so that a timed query does not allocate.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// A slot of `a` and a slot of `b`.
    stack: Vec<(u32, u32)>,
    /// Nodes that the last query opened.
    pub(super) visits: u32,
}

/// Calls `on_contact(place_in_a, place_in_b)` for every pair of triangles that touch, exactly, until it breaks. Places are those of the
/// trees' orders.
fn traverse<B>(
    (a, b): (&WideTree, &WideTree),
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
    mut on_contact: impl FnMut(u32, u32) -> ControlFlow<B>,
) -> ControlFlow<B> {
    probe.volume_test();
    scratch.visits = 0;
    if balls_apart_mm(a, b, a_from_b) > 0.0 {
        return ControlFlow::Continue(());
    }
    let posed = Posed::new(a, b, a_from_b);
    let contact = |(i, j): (u32, u32)| on_contact(i, j);
    simd.run(Traversal {
        posed,
        stack: &mut scratch.stack,
        visits: &mut scratch.visits,
        probe,
        contact,
        batch: Batch::default(),
    })
}

/// A pair of triangles that touch, by their places in the trees' orders, if there is any.
pub(super) fn contact(
    a: &WideTree,
    b: &WideTree,
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
    probe: &mut impl Probe,
) -> Option<(u32, u32)> {
    traverse((a, b), a_from_b, simd, scratch, probe, |i, j| ControlFlow::Break((i, j))).break_value()
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
    contact(a, b, a_from_b, simd, scratch, probe).is_some()
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
    let _ = traverse((a, b), a_from_b, simd, scratch, probe, |i, j| {
        contacts.push((a.faces[i as usize], b.faces[j as usize]));
        ControlFlow::<()>::Continue(())
    });
    contacts.sort_unstable();
    contacts
}

/// How far the balls around the meshes are surely apart, mm, which settles most poses of a machine; negative where they may meet. The radii
/// have been widened against rounding here ([`super::build`]).
#[inline]
pub(super) fn balls_apart_mm(a: &WideTree, b: &WideTree, a_from_b: &Isometry) -> f64 {
    let (centre_a, radius_a) = a.ball;
    let (centre_b, radius_b) = b.ball;
    let between = a_from_b * centre_b - centre_a;
    let reach = radius_a + radius_b + Pose::ball_slack(a_from_b, a.reach + b.reach);
    // The root is taken only where it is needed.
    let squared = between.norm_squared();
    if squared > reach * reach { squared.sqrt() - reach } else { -1.0 }
}

/// One query.
struct Traversal<'a, P, F> {
    posed: Posed<'a>,
    stack: &'a mut Vec<(u32, u32)>,
    visits: &'a mut u32,
    probe: &'a mut P,
    contact: F,
    batch: Batch,
}

impl<B, P: Probe, F: FnMut((u32, u32)) -> ControlFlow<B>> Work for Traversal<'_, P, F> {
    type Output = ControlFlow<B>;

    #[inline(always)]
    fn run<M: Machine>(mut self) -> ControlFlow<B> {
        self.stack.clear();
        let first = self.posed.first();
        self.visit::<M>(&[first])?;
        while let Some(top) = self.stack.pop() {
            let top = self.posed.open(top);
            match self.stack.pop() {
                Some(next) => self.visit::<M>(&[top, self.posed.open(next)])?,
                None => self.visit::<M>(&[top])?,
            }
        }
        self.test::<M>()
    }
}

impl<B, P: Probe, F: FnMut((u32, u32)) -> ControlFlow<B>> Traversal<'_, P, F> {
    /// Tests the one box of each visit against the children of its node, and keeps what may overlap.
    #[inline(always)]
    fn visit<M: Machine>(&mut self, opened: &[Opened]) -> ControlFlow<B> {
        *self.visits += opened.len() as u32;
        let mut found = [Found::default(); 2];
        match *opened {
            [one] => boxes::visit::<M::Single>(&[self.posed.see::<M::Double>(one)], &mut found),
            [one, other] => boxes::visit::<M::Single>(
                &[self.posed.see::<M::Double>(one), self.posed.see::<M::Double>(other)],
                &mut found,
            ),
            _ => {}
        }
        // The last on the stack is the next to be opened: the first visit's.
        for (opened, found) in opened.iter().zip(&found).rev() {
            self.keep::<M>(*opened, found)?;
        }
        ControlFlow::Continue(())
    }

    /// Pairs with a node in them go to the stack, the deepest overlap last; pairs of triangles to the batch.
    #[inline(always)]
    fn keep<M: Machine>(&mut self, opened: Opened, found: &Found) -> ControlFlow<B> {
        let (tree, other) = self.posed.trees(opened);
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
                if self.batch.push(Opened { one, ..opened }.pair(triangle)) {
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
            self.stack.push(opened.pair(later));
        }
        if let Some((_, slot)) = deepest {
            self.stack.push(opened.pair(slot));
        }
        ControlFlow::Continue(())
    }

    /// Tests the pairs that wait, if any.
    #[inline(always)]
    fn test<M: Machine>(&mut self) -> ControlFlow<B> {
        if self.batch.len() == 0 {
            return ControlFlow::Continue(());
        }
        for _ in 0..self.batch.len() {
            self.probe.triangle_test();
        }
        let pairs = self.batch;
        let Posed { a, b, placement, .. } = &self.posed;
        let mut left = self.batch.unparted::<M::Double>(a, b, placement);
        while left != 0 {
            let pair = pairs.pair(left.trailing_zeros() as usize);
            left &= left - 1;
            if triangles::touch(a, b, placement, pair) {
                (self.contact)(pair)?;
            }
        }
        ControlFlow::Continue(())
    }
}
