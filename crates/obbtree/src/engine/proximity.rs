//! What distance queries reuse: the queue of pairs that wait, and the pair that was nearest last.
//!
//! The pair with the least bound is opened first, of all that wait (G. R. Hjaltason, H. Samet, "Distance Browsing in Spatial Databases", ACM TODS
//! 24(2), 1999): no pair is opened then whose bound is above the distance.

use super::buckets::Buckets;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Memory that distance queries reuse, and the pair of triangles that was nearest last, which on a path is often nearest again.
#[derive(Clone, Debug)]
pub struct Proximity {
    /// Pairs that wait to be opened.
    pub queue: Queue,
    /// Places of the nearest triangles in the order of the two trees.
    pub nearest: Option<(u32, u32)>,
    /// The answer is the distance times this. Pairs that are not nearer than the answer are left out, so that it is a lower bound.
    kept: f64,
    /// What waits in a wide tree's search, instead of the queue.
    pub(super) buckets: Buckets,
}

impl Default for Proximity {
    fn default() -> Self {
        Self::keeping(1.0)
    }
}

impl Proximity {
    /// For answers that are lower bounds: at least this share of the distance, above 0 and up to 1. A smaller share is found sooner.
    #[must_use]
    pub fn keeping(kept: f64) -> Self {
        Self { queue: Queue::default(), nearest: None, kept, buckets: Buckets::default() }
    }

    /// That share.
    #[inline]
    #[must_use]
    pub const fn kept(&self) -> f64 {
        self.kept
    }
}

/// Pairs that wait to be opened, the nearest first; of those as near the one that came last, which is the smallest.
#[derive(Clone, Debug, Default)]
pub struct Queue {
    /// The bits of a bound, which are in the order of the bounds since none is negative, above the pair's number, counted down from the largest:
    /// one number, so that a comparison is one instruction.
    heap: BinaryHeap<Reverse<u64>>,
    /// All pairs that came, by number.
    pairs: Vec<(u32, u32)>,
}

impl Queue {
    /// Forgets all pairs and keeps the memory.
    pub fn clear(&mut self) {
        self.heap.clear();
        self.pairs.clear();
    }

    /// Adds a pair that is at least `bound_mm` apart.
    #[inline]
    pub fn push(&mut self, bound_mm: f32, pair: (u32, u32)) {
        let number = self.pairs.len() as u32;
        // The negative zero and what is not a number have bits above all others.
        let bound = if bound_mm > 0.0 { bound_mm.to_bits() } else { 0 };
        self.heap.push(Reverse(u64::from(bound) << 32 | u64::from(!number)));
        self.pairs.push(pair);
    }

    /// The nearest pair, if it may be nearer than `least_mm`.
    #[inline]
    pub fn pop_below(&mut self, least_mm: f64) -> Option<(u32, u32)> {
        if self.bound_mm() >= least_mm {
            return None;
        }
        self.heap.pop().map(|Reverse(key)| self.pairs[!(key as u32) as usize])
    }

    /// No pair that waits is nearer than this, mm; infinity where none does.
    #[inline]
    #[must_use]
    pub fn bound_mm(&self) -> f64 {
        self.heap.peek().map_or(f64::INFINITY, |Reverse(key)| f32::from_bits((key >> 32) as u32).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_pair_comes_first_and_of_equals_the_last() {
        let mut queue = Queue::default();
        for (bound, pair) in [(2.5, 0), (0.0, 1), (7.0, 2), (-0.0, 3), (2.5, 4)] {
            queue.push(bound, (pair, 9));
        }
        assert_eq!(queue.bound_mm(), 0.0);
        let order: Vec<u32> = std::iter::from_fn(|| queue.pop_below(7.0)).map(|pair| pair.0).collect();
        assert_eq!(order, [3, 1, 4, 0], "what is no nearer than what is known stays");
        assert_eq!(queue.bound_mm(), 7.0);
        queue.clear();
        assert_eq!((queue.bound_mm(), queue.pop_below(f64::INFINITY)), (f64::INFINITY, None));
    }
}
