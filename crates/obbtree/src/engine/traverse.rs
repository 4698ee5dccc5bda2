//! Which triangles of two trees touch at a pose.
//!
//! A stack of pairs of volumes that may overlap, of which the larger is opened. Two pairs are taken at a time; of each the volume that stays is
//! moved into the frame of the other's node, where one pass over the lanes ([`super::visit`]) tests it against all children. Pairs of
//! triangles gather and are tested four at a time ([`super::triangles`]). The deepest overlap is taken first: that is where a contact is likely.

use super::front::Front;
use super::lanes::{Machine, Simd, Work};
use super::node::{Contents, Node, Triangles, WIDTH, WideTree};
use super::pose::Pose;
use super::posed::{Opened, Posed};
use super::triangles::{Batch, Sided};
use super::visit::{self, Overlaps};
use super::volume::WideVolume;
use crate::engine::geometry::{Isometry, Vector};
use std::hint::select_unpredictable;
use std::ops::ControlFlow;

/// Operation counts of one query: the same on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Overlap tests between two volumes.
    pub volume_tests: u64,
    /// Contact tests between two triangles.
    pub triangle_tests: u64,
}

/// Memory that queries reuse, so that a timed query does not allocate; and what the last one did.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    stack: Vec<Opened>,
    sided: Sided,
    /// What the last search that kept it has left out.
    pub(super) front: Front,
    pub(super) tally: Tally,
}

impl Scratch {
    /// Operations of the last query.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.tally.counts
    }
}

/// What a query did.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    pub counts: Counts,
    /// Nodes opened.
    pub visits: u32,
}

impl Tally {
    /// The balls around the meshes have been asked.
    pub const BALLS: Self = Self { counts: Counts { volume_tests: 1, triangle_tests: 0 }, visits: 0 };
}

/// Calls `on_contact` with every pair of triangles that touch, exactly, until it breaks. They are named by their places in the trees' orders.
/// Contacts are rare beside what it takes to find them: one compiled search serves all who call. What the balls settle is not worth a call.
#[inline]
pub(crate) fn traverse<V: WideVolume>(
    (a, b): (&WideTree<V>, &WideTree<V>),
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
    on_contact: &mut dyn FnMut((u32, u32)) -> ControlFlow<()>,
) {
    scratch.tally = if balls_are_apart(a, b, a_from_b) {
        Tally::BALLS
    } else {
        search::<V, false>((a, b), a_from_b, simd, scratch, on_contact, u32::MAX)
    };
}

#[inline(never)]
fn search<V: WideVolume, const KEEPS: bool>(
    (a, b): (&WideTree<V>, &WideTree<V>),
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
    on_contact: &mut dyn FnMut((u32, u32)) -> ControlFlow<()>,
    most_visits: u32,
) -> Tally {
    let Scratch { stack, sided, front, .. } = scratch;
    let (posed, batch, tally) = (Posed::new(a, b, a_from_b), Batch::default(), Tally::BALLS);
    let mut traversal = Traversal::<V, KEEPS> { posed, stack, sided, front, on_contact, batch, tally, most_visits };
    simd.run(&mut traversal);
    traversal.tally
}

/// [`contact_of_near`] from the front of the scratch on, which keeps what is left out. It is closed where the meshes
/// touch, and where more nodes than `most_visits` were opened: a search that did not begin with an empty one ends there and knows nothing.
pub(super) fn search_on<V: WideVolume>(
    (a, b): (&WideTree<V>, &WideTree<V>),
    a_from_b: &Isometry,
    most_visits: u32,
    simd: Simd,
    scratch: &mut Scratch,
) -> Option<(u32, u32)> {
    let found = first_found::<V, true>((a, b), a_from_b, most_visits, simd, scratch);
    if found.is_some() {
        scratch.front.close();
    }
    found
}

/// [`contact`] where the balls around the meshes meet.
pub(super) fn contact_of_near<V: WideVolume>(
    pair: (&WideTree<V>, &WideTree<V>),
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
) -> Option<(u32, u32)> {
    first_found::<V, false>(pair, a_from_b, u32::MAX, simd, scratch)
}

/// The contact that ends a search.
fn first_found<V: WideVolume, const KEEPS: bool>(
    pair: (&WideTree<V>, &WideTree<V>),
    a_from_b: &Isometry,
    most_visits: u32,
    simd: Simd,
    scratch: &mut Scratch,
) -> Option<(u32, u32)> {
    let mut found = None;
    let mut on_contact = |triangles| {
        found = Some(triangles);
        ControlFlow::Break(())
    };
    scratch.tally = search::<V, KEEPS>(pair, a_from_b, simd, scratch, &mut on_contact, most_visits);
    found
}

/// A pair of triangles that touch, by their places in the trees' orders, if there is any.
#[inline]
pub(super) fn contact<V: WideVolume>(
    a: &WideTree<V>,
    b: &WideTree<V>,
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
) -> Option<(u32, u32)> {
    let mut found = None;
    traverse((a, b), a_from_b, simd, scratch, &mut |pair| {
        found = Some(pair);
        ControlFlow::Break(())
    });
    found
}

/// Mode `first`: whether the meshes touch at all.
#[inline]
pub fn first<V: WideVolume>(
    a: &WideTree<V>,
    b: &WideTree<V>,
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
) -> bool {
    contact(a, b, a_from_b, simd, scratch).is_some()
}

/// Mode `all`: every pair of faces that touch, as (face of `a`, face of `b`), sorted.
pub fn all<V: WideVolume>(
    a: &WideTree<V>,
    b: &WideTree<V>,
    a_from_b: &Isometry,
    simd: Simd,
    scratch: &mut Scratch,
) -> Vec<(u32, u32)> {
    let mut contacts = Vec::new();
    traverse((a, b), a_from_b, simd, scratch, &mut |(i, j)| {
        contacts.push((a.faces[i as usize], b.faces[j as usize]));
        ControlFlow::Continue(())
    });
    contacts.sort_unstable();
    contacts
}

/// Whether the balls around the meshes are surely apart, which settles most poses of a machine. The radii have been widened against rounding
/// ([`super::build`]).
#[inline]
pub(super) fn balls_are_apart<V: WideVolume>(a: &WideTree<V>, b: &WideTree<V>, a_from_b: &Isometry) -> bool {
    let (way, reach) = way_and_reach(a, b, a_from_b);
    way.norm_squared() > reach * reach
}

/// How far the balls are surely apart, mm; not above 0 where they may meet.
#[inline]
pub(super) fn balls_apart_mm<V: WideVolume>(a: &WideTree<V>, b: &WideTree<V>, a_from_b: &Isometry) -> f64 {
    let (way, reach) = way_and_reach(a, b, a_from_b);
    way.norm() - reach
}

/// The way from the centre of one ball to that of the other, and how far it is at most where they meet, mm.
#[inline(always)]
fn way_and_reach<V: WideVolume>(a: &WideTree<V>, b: &WideTree<V>, a_from_b: &Isometry) -> (Vector, f64) {
    let ((centre_a, radius_a), (centre_b, radius_b)) = (a.ball, b.ball);
    (a_from_b * centre_b - centre_a, radius_a + radius_b + Pose::ball_slack(a_from_b, a.reach_with(b)))
}

/// One query; with `KEEPS` one that keeps what it leaves out.
struct Traversal<'a, V: WideVolume, const KEEPS: bool> {
    posed: Posed<'a, V>,
    stack: &'a mut Vec<Opened>,
    sided: &'a mut Sided,
    front: &'a mut Front,
    on_contact: &'a mut dyn FnMut((u32, u32)) -> ControlFlow<()>,
    batch: Batch,
    tally: Tally,
    /// Nodes that may be opened while the front is kept.
    most_visits: u32,
}

impl<V: WideVolume, const KEEPS: bool> Work for &mut Traversal<'_, V, KEEPS> {
    type Output = ();

    #[inline(always)]
    fn run<M: Machine>(self) {
        let _ = self.search::<M>();
    }
}

impl<V: WideVolume, const KEEPS: bool> Traversal<'_, V, KEEPS> {
    /// Opens pairs until none is left, or until a contact ends it.
    #[inline(always)]
    fn search<M: Machine>(&mut self) -> ControlFlow<()> {
        self.stack.clear();
        let carries_on = KEEPS && self.front.len() > 0;
        if carries_on {
            self.revisit::<M>()?;
        } else {
            self.visit::<M>(&[self.posed.first()])?;
        }
        while let Some(top) = self.stack.pop() {
            if KEEPS && self.tally.visits > self.most_visits {
                self.front.close();
                if carries_on {
                    return ControlFlow::Break(());
                }
            }
            match self.stack.pop() {
                Some(next) => self.visit::<M>(&[top, next])?,
                None => self.visit::<M>(&[top])?,
            }
        }
        self.test::<M>()
    }

    /// Tests the one volume of each visit against the children of its node, and keeps what may overlap.
    #[inline(always)]
    fn visit<M: Machine>(&mut self, opened: &[Opened]) -> ControlFlow<()> {
        let found = self.overlaps::<M>(opened);
        // The last on the stack is the next to be opened: the first visit's.
        for (&opened, found) in opened.iter().zip(&found).rev() {
            if KEEPS {
                self.front.add::<M>(opened, found, self.occupied(opened));
            }
            self.keep::<M>(opened, found)?;
        }
        ControlFlow::Continue(())
    }

    /// Makes those visits of the front again that `b` may have moved too far for, two at a time, and tests such pairs of triangles.
    #[inline(always)]
    fn revisit<M: Machine>(&mut self) -> ControlFlow<()> {
        self.front.take_due_pairs();
        while let Some(pair) = self.front.due_pair() {
            if self.batch.push(pair) {
                self.test::<M>()?;
            }
        }
        let mut place = 0;
        while let Some((one, opened)) = self.front.due_visit(place) {
            let other = self.front.due_visit(one + 1);
            place = other.map_or(one, |(other, _)| other) + 1;
            let both = [opened, other.map_or(opened, |(_, opened)| opened)];
            let visits = if other.is_some() { &both[..] } else { &both[..1] };
            let mut found = self.overlaps::<M>(visits);
            for ((place, opened), found) in
                other.into_iter().chain([(one, opened)]).zip(found[..visits.len()].iter_mut().rev())
            {
                found.live = self.front.renew::<M>(place, found, self.occupied(opened));
                self.keep::<M>(opened, found)?;
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn overlaps<M: Machine>(&mut self, opened: &[Opened]) -> [Overlaps; 2] {
        self.tally.visits += opened.len() as u32;
        let mut found = [Overlaps::default(); 2];
        match *opened {
            [one] => visit::visit::<V, M::Single, KEEPS>(&[self.posed.see(one)], &mut found),
            [one, other] => {
                visit::visit::<V, M::Single, KEEPS>(&[self.posed.see(one), self.posed.see(other)], &mut found);
            }
            _ => {}
        }
        found
    }

    /// A bit for each child of the node that is opened.
    #[inline(always)]
    fn occupied(&self, opened: Opened) -> u8 {
        self.posed.trees(opened).0.nodes[opened.node as usize].occupied()
    }

    /// Pairs with a node in them go to the stack, the deepest overlap last; pairs of triangles to the batch.
    #[inline(always)]
    fn keep<M: Machine>(&mut self, opened: Opened, found: &Overlaps) -> ControlFlow<()> {
        let (tree, other) = self.posed.trees(opened);
        let node = &tree.nodes[opened.node as usize];
        self.tally.counts.volume_tests += u64::from(node.count);
        let mut live = found.live;
        if live == 0 {
            return ControlFlow::Continue(());
        }
        let inner = ((1_u32 << node.inner) - 1) as u8;
        // Of the larger of two volumes the children are next; never of a triangle's, and not both are triangles'.
        let (stay, below) = match other.contents(opened.one) {
            Contents::Node(below) => (!(found.larger & inner), below),
            Contents::Triangles(one) => {
                self.gather::<M>(opened, one, node, live & !inner)?;
                live &= inner;
                (0, 0)
            }
        };
        // Which one it is cannot be foreseen: it is taken without a jump.
        let next = |place: u32| {
            let stays = stay >> place & 1 != 0;
            let slot = opened.node * WIDTH as u32 + place;
            Opened {
                one: select_unpredictable(stays, slot, opened.one),
                node: select_unpredictable(stays, below, node.first_node + place),
                of_b: opened.of_b ^ stays,
            }
        };
        let mut deepest: Option<(f32, u32)> = None;
        while live != 0 {
            let place = live.trailing_zeros();
            live &= live - 1;
            let gap = found.gap[place as usize];
            let later = match deepest {
                Some((least, before)) if gap < least => {
                    deepest = Some((gap, place));
                    before
                }
                Some(_) => place,
                None => {
                    deepest = Some((gap, place));
                    continue;
                }
            };
            self.stack.push(next(later));
        }
        if let Some((_, place)) = deepest {
            self.stack.push(next(place));
        }
        ControlFlow::Continue(())
    }

    /// Puts the pairs of one or two triangles and those in the given places of a node into the batch.
    #[inline(always)]
    fn gather<M: Machine>(
        &mut self,
        opened: Opened,
        ones: Triangles,
        node: &Node<V>,
        mut places: u8,
    ) -> ControlFlow<()> {
        while places != 0 {
            let place = places.trailing_zeros();
            places &= places - 1;
            for triangle in node.triangles(place).places() {
                for one in ones.places() {
                    if self.batch.push(Opened { one, ..opened }.pair(triangle)) {
                        self.test::<M>()?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Tests the pairs that wait, if any.
    #[inline(always)]
    fn test<M: Machine>(&mut self) -> ControlFlow<()> {
        if self.batch.len() == 0 {
            return ControlFlow::Continue(());
        }
        self.tally.counts.triangle_tests += self.batch.len() as u64;
        let pairs = self.batch;
        let Posed { a, b, placement, .. } = &self.posed;
        self.batch.side::<M::Double, V, KEEPS>((a, b), placement, self.sided);
        let sided = &*self.sided;
        let mut left = sided.unparted;
        while left != 0 {
            let lane = left.trailing_zeros();
            left &= left - 1;
            if sided.touch(lane) {
                (self.on_contact)(pairs.pair(lane as usize))?;
            }
        }
        if KEEPS {
            for lane in 0..pairs.len() {
                self.front.add_pair(pairs.pair(lane), sided.apart_mm[lane]);
            }
        }
        ControlFlow::Continue(())
    }
}
