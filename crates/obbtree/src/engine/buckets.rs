//! The queue of a search for a distance: nearly the nearest first.
//!
//! All that waits is nearer than the least distance that is known when it comes, so that buckets of equal width up to that distance put it in order
//! without a comparison, and the first that is not empty is found in one instruction. Within a bucket the last comes first. What is opened
//! too soon is what the last bucket holds above the final distance.

use super::posed::Opened;

/// A bit of one number for each bucket.
const BUCKETS: usize = 64;
/// No entry.
const NONE: u32 = u32::MAX;

/// An entry of the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Waiting {
    /// A node to be opened.
    Node(Opened),
    /// Two volumes whose triangles are to be measured, by their slots.
    Leaves((u32, u32)),
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    bound_mm: f32,
    what: Waiting,
    /// The next in the same bucket.
    next: u32,
}

/// What waits, by its bound.
#[derive(Clone, Debug)]
pub(super) struct Buckets {
    first: [u32; BUCKETS],
    /// A bit for each bucket that is not empty.
    filled: u64,
    /// One over the width of a bucket, 1/mm.
    per_mm: f32,
    entries: Vec<Entry>,
}

impl Default for Buckets {
    fn default() -> Self {
        Self { first: [NONE; BUCKETS], filled: 0, per_mm: 0.0, entries: Vec::new() }
    }
}

impl Buckets {
    /// Forgets all and keeps the memory. What comes will be below `below_mm`, or in one bucket where that is infinite.
    pub fn clear(&mut self, below_mm: f64) {
        self.filled = 0;
        self.entries.clear();
        self.per_mm = Self::scale(below_mm);
    }

    /// Puts what waits into buckets anew: nothing from `below_mm` on will be asked for.
    pub fn spread(&mut self, below_mm: f64) {
        self.filled = 0;
        self.per_mm = Self::scale(below_mm);
        let mut kept = 0;
        for i in 0..self.entries.len() {
            let Entry { bound_mm, what, .. } = self.entries[i];
            if f64::from(bound_mm) < below_mm {
                self.entries[kept] = Entry { bound_mm, what, next: self.link(bound_mm, kept as u32) };
                kept += 1;
            }
        }
        self.entries.truncate(kept);
    }

    fn scale(below_mm: f64) -> f32 {
        let per_mm = (BUCKETS as f64 / below_mm) as f32;
        if per_mm.is_finite() { per_mm } else { 0.0 }
    }

    /// Adds what is at least `bound_mm` away.
    #[inline(always)]
    pub fn push(&mut self, bound_mm: f32, what: Waiting) {
        let next = self.link(bound_mm, self.entries.len() as u32);
        self.entries.push(Entry { bound_mm, what, next });
    }

    /// Puts the entry with a number first in its bucket. The number of the next there.
    #[inline(always)]
    fn link(&mut self, bound_mm: f32, number: u32) -> u32 {
        // What is not a number goes to the first.
        let bucket = ((bound_mm * self.per_mm) as usize).min(BUCKETS - 1);
        let next = if self.filled >> bucket & 1 == 0 { NONE } else { self.first[bucket] };
        self.first[bucket] = number;
        self.filled |= 1 << bucket;
        next
    }

    /// What may be nearer than `least_mm`, one of the nearest, and whether its bound is above 0.
    #[inline(always)]
    pub fn pop_below(&mut self, least_mm: f64) -> Option<(Waiting, bool)> {
        while self.filled != 0 {
            let bucket = self.filled.trailing_zeros() as usize;
            let Entry { bound_mm, what, next } = self.entries[self.first[bucket] as usize];
            self.first[bucket] = next;
            self.filled &= !(u64::from(next == NONE) << bucket);
            if f64::from(bound_mm) < least_mm {
                return Some((what, bound_mm > 0.0));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pushed(buckets: &mut Buckets, bounds: &[f32]) {
        for (&bound, number) in bounds.iter().zip(0..) {
            buckets.push(bound, Waiting::Leaves((number, 0)));
        }
    }

    fn order(buckets: &mut Buckets, least_mm: f64) -> Vec<u32> {
        let next = || match buckets.pop_below(least_mm)?.0 {
            Waiting::Leaves((number, _)) => Some(number),
            Waiting::Node(_) => None,
        };
        std::iter::from_fn(next).collect()
    }

    #[test]
    fn the_nearest_comes_first_and_what_is_too_far_never() {
        let mut buckets = Buckets::default();
        buckets.clear(10.0);
        // The second and the fifth, and the third and the seventh, are within a bucket's width of 10/64 mm; the fourth and the last are not.
        pushed(&mut buckets, &[2.5, 0.0, 7.0, 5.0, 0.1, 9.9, 7.01, 5.3]);
        assert_eq!(order(&mut buckets.clone(), 10.0), [4, 1, 0, 3, 7, 6, 2, 5]);
        assert_eq!(order(&mut buckets, 7.0), [4, 1, 0, 3, 7], "what is no nearer than what is known is left out");
        assert_eq!(buckets.pop_below(f64::INFINITY), None);
    }

    #[test]
    fn what_came_before_there_was_a_distance_is_spread_over_the_buckets() {
        let mut buckets = Buckets::default();
        buckets.clear(f64::INFINITY);
        pushed(&mut buckets, &[3.0, 1.0, 2.0, 8.0]);
        let memory = (buckets.entries.as_ptr(), buckets.entries.capacity());
        buckets.spread(4.0);
        assert_eq!((buckets.entries.as_ptr(), buckets.entries.capacity()), memory, "the memory is kept");
        assert_eq!(order(&mut buckets, 4.0), [1, 2, 0]);
        buckets.clear(4.0);
        pushed(&mut buckets, &[f32::NAN, -0.0]);
        assert_eq!(buckets.pop_below(4.0), Some((Waiting::Leaves((1, 0)), false)));
    }
}
