//! Random numbers that are the same on every machine.
//!
//! Every ray has its own generator, seeded by a hash of what it is for: adding a scene, a pair or a ray changes no other,
//! and threads do not matter. Only operations that IEEE 754 rounds correctly (no `exp`, no `sin`) stand between
//! the generator and a pose.

use crate::engine::geometry::Vector;
use nalgebra::{Quaternion, Unit, UnitQuaternion};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// A seeded source of random quantities.
pub struct Draw(Pcg64);

impl Draw {
    /// A generator for one purpose: `labels` say which, `index` counts within it.
    pub fn new(seed: u64, labels: &[&str], index: u64) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&seed.to_le_bytes());
        for label in labels {
            // The length keeps ["ab", "c"] and ["a", "bc"] apart.
            hasher.update(&(label.len() as u64).to_le_bytes());
            hasher.update(label.as_bytes());
        }
        hasher.update(&index.to_le_bytes());
        Self(Pcg64::from_seed(*hasher.finalize().as_bytes()))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        // 53 random bits, as many as an f64 below 1 has.
        (self.0.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform in [-1, 1).
    pub fn signed_unit(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Uniform in the unit ball, without the very middle.
    pub fn in_ball(&mut self) -> Vector {
        loop {
            let v = Vector::new(self.signed_unit(), self.signed_unit(), self.signed_unit());
            // The middle is left out because its directions would be rounding.
            if (1e-6..=1.0).contains(&v.norm_squared()) {
                return v;
            }
        }
    }

    /// Uniform over all directions.
    pub fn direction(&mut self) -> Unit<Vector> {
        Unit::new_normalize(self.in_ball())
    }

    /// Uniform over all rotations: a uniform direction in four dimensions is a uniform quaternion.
    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        loop {
            let [w, i, j, k] = [(); 4].map(|()| self.signed_unit());
            let q = Quaternion::new(w, i, j, k);
            if (1e-6..=1.0).contains(&q.norm_squared()) {
                return UnitQuaternion::from_quaternion(q);
            }
        }
    }

    /// Log-uniform in [low, high], both above 0.
    pub fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        let mut u = self.unit();
        // low · (high / low)^u by the binary digits of u: digit k multiplies by the 2^k-th root. Thirty digits resolve a
        // decade to 1e-9; `powf` would differ between machines.
        let (mut value, mut root) = (low, high / low);
        for _ in 0..30 {
            root = root.sqrt();
            u *= 2.0;
            if u >= 1.0 {
                u -= 1.0;
                value *= root;
            }
        }
        value.min(high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn purposes_and_indices_have_streams_of_their_own() {
        let first = |seed, labels: &[&str], index| Draw::new(seed, labels, index).unit();
        let base = first(1, &["a", "bc"], 0);
        assert_eq!(base, first(1, &["a", "bc"], 0));
        for other in [first(2, &["a", "bc"], 0), first(1, &["ab", "c"], 0), first(1, &["a", "bc"], 1)] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn log_uniform_fills_every_decade_alike() {
        let mut draw = Draw::new(7, &["decades"], 0);
        let mut counts = [0_u32; 3];
        for _ in 0..3000 {
            let x = draw.log_uniform(1e-3, 1.0);
            assert!((1e-3..=1.0).contains(&x));
            counts[if x < 1e-2 {
                0
            } else if x < 1e-1 {
                1
            } else {
                2
            }] += 1;
        }
        // Binomial: 1000 ± 26; five standard deviations.
        assert!(counts.iter().all(|count| (870..=1130).contains(count)), "{counts:?}");
    }

    #[test]
    fn rotations_and_directions_have_no_preference() {
        let mut draw = Draw::new(7, &["sphere"], 0);
        let n = 4000;
        let mean: Vector = (0..n).map(|_| *draw.direction()).sum::<Vector>() / f64::from(n);
        let turned: Vector = (0..n).map(|_| draw.rotation() * Vector::x()).sum::<Vector>() / f64::from(n);
        // Each component has variance 1/3: standard deviation of the mean 0.0091; five of them.
        assert!(mean.amax() < 0.046 && turned.amax() < 0.046, "{mean} {turned}");
    }
}
