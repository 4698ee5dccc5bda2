//! What a search for a contact has left out, kept along a path: for each visit, how far points may move until a child that was apart may touch.
//!
//! A search that finds no contact has shown for every pair of triangles that some pair of volumes around them is apart, or that they are. Each of these is apart by a
//! distance, and stays so while no point of `b` moves that far. So the next search begins where this one ended: visits whose distance is used up are made
//! again, and what may now overlap is opened as in any search. The front of a search is what S. A. Ehmann, M. C. Lin, "Accurate and Fast Proximity Queries
//! Between Polyhedra Using Convex Surface Decomposition", 2001, and others keep; with distances most of it need not even be looked at.
//!
//! Why it tells the truth. What points of `b` have moved is summed over the steps, so that it is never less than what they have moved since a visit
//! was made. A gap less the slack, times [`LOWERED`], is a lower bound of the distance of two volumes' contents ([`super::boxes`]; the products of edges are no longer
//! than 1, so that the distance along them is no less than the gap), and the slack has what the pose of the visit needs in it. What the pose of the query
//! needs is asked for in addition.

use super::boxes::LOWERED;
use super::lanes::Machine;
use super::posed::Opened;
use super::visit::Overlaps;

/// Relative lengthening of a step, which covers the rounding of its length.
const STEP_PAD: f64 = 32.0 / 9_007_199_254_740_992.0;

/// The visits of a search and its pairs of triangles.
#[derive(Clone, Debug, Default)]
pub(super) struct Front {
    is_open: bool,
    visits: Vec<Visited>,
    pairs: Vec<Apart>,
    /// Pairs of triangles that have to be tested again.
    due_pairs: Vec<(u32, u32)>,
    /// How far points of `b` may have moved since the search began, mm; and that with the slack of the pose.
    gone_mm: f64,
    needed_mm: f64,
    slack_mm: f64,
    /// The least of all `until_mm`.
    soonest_mm: f64,
}

/// A visit, and the motion up to which the children that are not `seen` stay apart.
#[derive(Clone, Copy, Debug)]
struct Visited {
    opened: Opened,
    /// A bit for each child whose pair is elsewhere in the front.
    seen: u8,
    /// How far points may go altogether, mm.
    until_mm: f64,
}

/// A pair of triangles that do not touch, by their places.
#[derive(Clone, Copy, Debug)]
struct Apart {
    pair: (u32, u32),
    until_mm: f64,
}

impl Front {
    pub const fn is_open(&self) -> bool {
        self.is_open
    }

    /// Begins anew, with nothing left out, at a pose with that slack, mm.
    pub fn open(&mut self, slack_mm: f64) {
        self.visits.clear();
        self.pairs.clear();
        (self.is_open, self.gone_mm, self.soonest_mm) = (true, 0.0, f64::INFINITY);
        (self.slack_mm, self.needed_mm) = (slack_mm, slack_mm);
    }

    pub const fn close(&mut self) {
        self.is_open = false;
    }

    /// The slack of the pose that is asked about next, mm, and the farthest that a point of `b` moves to it.
    pub const fn step(&mut self, step_mm: f64, slack_mm: f64) {
        self.gone_mm = (self.gone_mm + step_mm * (1.0 + STEP_PAD)).next_up();
        self.slack_mm = slack_mm;
        self.needed_mm = (self.gone_mm + slack_mm).next_up();
    }

    /// Whether all that was left out is still apart.
    pub const fn holds(&self) -> bool {
        self.needed_mm < self.soonest_mm
    }

    /// How far points may still go, mm, before something has to be looked at again. The slack of the pose is to be taken off.
    pub const fn room_mm(&self) -> f64 {
        (self.soonest_mm - self.gone_mm).next_down()
    }

    /// How many visits and pairs of triangles there are.
    pub const fn len(&self) -> usize {
        self.visits.len() + self.pairs.len()
    }

    /// How many visits have to be made again.
    pub fn due(&self) -> usize {
        self.visits.iter().filter(|visited| visited.until_mm <= self.needed_mm).count()
    }

    /// Takes away the pairs of triangles that have to be tested again.
    pub fn take_due_pairs(&mut self) {
        let (needed_mm, due) = (self.needed_mm, &mut self.due_pairs);
        due.clear();
        self.pairs.retain(|apart| {
            let holds = apart.until_mm > needed_mm;
            if !holds {
                due.push(apart.pair);
            }
            holds
        });
    }

    /// The next pair of triangles that has to be tested again.
    pub fn due_pair(&mut self) -> Option<(u32, u32)> {
        self.due_pairs.pop()
    }

    /// The first visit from a place on that has to be made again.
    #[inline(always)]
    pub fn due_visit(&self, from: usize) -> Option<(usize, Opened)> {
        let due = self.visits[from..].iter().position(|visited| visited.until_mm <= self.needed_mm)?;
        Some((from + due, self.visits[from + due].opened))
    }

    /// Adds a visit with the children that exist.
    #[inline(always)]
    pub fn add<M: Machine>(&mut self, opened: Opened, found: &Overlaps, occupied: u8) {
        if !self.is_open {
            return;
        }
        let until_mm = self.until_mm(M::least_of(&found.gap, occupied & !found.live));
        self.visits.push(Visited { opened, seen: found.live, until_mm });
    }

    /// Makes a visit again; returns the children that may overlap now and did not before.
    #[inline(always)]
    pub fn renew<M: Machine>(&mut self, place: usize, found: &Overlaps, occupied: u8) -> u8 {
        let before = self.visits[place].seen;
        let seen = before | found.live;
        let until_mm = self.until_mm(M::least_of(&found.gap, occupied & !seen));
        let visited = &mut self.visits[place];
        (visited.seen, visited.until_mm) = (seen, until_mm);
        found.live & !before
    }

    /// A pair of triangles that do not touch.
    #[inline(always)]
    pub fn add_pair(&mut self, pair: (u32, u32), apart_mm: f64) {
        if !self.is_open {
            return;
        }
        let until_mm = (self.gone_mm + (apart_mm - self.slack_mm)).next_down();
        self.pairs.push(Apart { pair, until_mm });
        self.soonest_mm = self.soonest_mm.min(until_mm);
    }

    /// The motion up to which children stay apart whose gaps, less the slack, are given, mm.
    #[inline(always)]
    fn until_mm(&mut self, least_mm: f32) -> f64 {
        let until_mm = (self.gone_mm + f64::from(least_mm * LOWERED)).next_down();
        self.soonest_mm = self.soonest_mm.min(until_mm);
        until_mm
    }

    /// Finds the least `until_mm` anew, after a search that went on from this front.
    pub fn carried_on(&mut self) {
        let of_visits = self.visits.iter().map(|visited| visited.until_mm);
        self.soonest_mm = of_visits.chain(self.pairs.iter().map(|apart| apart.until_mm)).fold(f64::INFINITY, f64::min);
    }
}

#[cfg(test)]
mod tests {
    use super::super::lanes::{Simd, WIDTH, Work};
    use super::*;

    /// A visit to which four children come, added or made again.
    struct Visiting<'a>(&'a mut Front, Option<usize>, [f32; WIDTH], u8);

    impl Work for Visiting<'_> {
        type Output = u8;

        #[inline(always)]
        fn run<M: Machine>(self) -> u8 {
            let Self(front, place, gap, live) = self;
            let found = Overlaps { gap, live, larger: 0 };
            if let Some(place) = place {
                return front.renew::<M>(place, &found, 0b1111);
            }
            front.add::<M>(OPENED, &found, 0b1111);
            live
        }
    }

    const OPENED: Opened = Opened { one: 1, node: 2, of_b: false };

    #[test]
    fn what_is_left_out_is_due_when_points_have_moved_as_far_as_it_was_apart() {
        Simd::available().into_iter().for_each(is_due_in_time);
    }

    fn is_due_in_time(simd: Simd) {
        let mut front = Front::default();
        front.open(0.125);
        assert!(front.is_open() && front.len() == 0);
        // Children 0 to 3, the second may overlap: 2 mm is the least, of which the slack is off.
        simd.run(Visiting(&mut front, None, [5.0, 1.0, 2.0, 3.0, 0.5, 0.5, 0.5, 0.5], 0b10));
        front.add_pair((7, 9), 4.125);
        front.step(1.5, 0.25);
        assert!(front.holds() && front.due() == 0);
        // 1.75 mm and a slack of 0.25.
        front.step(0.25, 0.25);
        assert!(!front.holds() && front.due() == 1);
        assert_eq!(front.due_visit(0), Some((0, OPENED)));
        front.take_due_pairs();
        assert_eq!(front.due_pair(), None);
        // Now the first may overlap, and the second no longer does: its pair stays in the front.
        let gap = [-1.0, 0.25, 2.0, 9.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(simd.run(Visiting(&mut front, Some(0), gap, 0b1)), 0b1);
        assert_eq!(simd.run(Visiting(&mut front, Some(0), gap, 0b11)), 0);
        front.carried_on();
        assert!(front.holds());
        // The pair is apart by 4.125 mm less the slack where it was found.
        front.step(2.0, 0.25);
        assert_eq!(front.due(), 1);
        front.take_due_pairs();
        assert_eq!((front.due_pair(), front.due_pair(), front.len()), (Some((7, 9)), None, 1));
        front.close();
        front.add_pair((1, 1), 1.0);
        assert_eq!(front.len(), 1, "what is closed keeps nothing");
    }

    #[test]
    fn small_steps_add_up_to_no_less_than_the_way() {
        let mut front = Front::default();
        front.open(0.0);
        (0..1_000_000).for_each(|_| front.step(0.1, 0.0));
        assert!(front.gone_mm >= 100_000.0 && front.gone_mm < 100_000.001, "{}", front.gone_mm);
    }
}
