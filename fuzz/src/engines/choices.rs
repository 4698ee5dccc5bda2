//! The numbers that a case is made of.

use bvbench::geometry::Vector;
use nalgebra::{Quaternion, UnitQuaternion};

/// Numbers from given bytes, eight for each, and from a generator once they are used up.
pub struct Choices<'a> {
    bytes: &'a [u8],
    state: u64,
}

impl<'a> Choices<'a> {
    /// Without bytes: the numbers of case `number` of a seed, the same on every machine.
    pub fn new(bytes: &'a [u8], seed: u64, number: u64) -> Self {
        let mut choices = Self { bytes: &[], state: seed };
        choices.state = choices.number() ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        Self { bytes, ..choices }
    }

    /// 64 bits; the generator is SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
    fn number(&mut self) -> u64 {
        if let Some((eight, rest)) = self.bytes.split_first_chunk() {
            self.bytes = rest;
            return u64::from_le_bytes(*eight);
        }
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// One of 0, 1, .. n - 1.
    pub fn below(&mut self, n: u64) -> u64 {
        self.number() % n
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    /// An element.
    pub fn of<T: Copy>(&mut self, among: &[T]) -> T {
        among[self.below(among.len() as u64) as usize]
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.number() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// In [-1, 1).
    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// In [2^low, 2^high), each power of two as often as any other.
    pub fn between(&mut self, low: i32, high: i32) -> f64 {
        let exponent = low + self.below((high - low) as u64) as i32;
        (1.0 + self.unit()) * 2f64.powi(exponent)
    }

    /// In the cube of edge 2 about the origin.
    pub fn vector(&mut self) -> Vector {
        Vector::new(self.signed(), self.signed(), self.signed())
    }

    /// Of length 1; along an axis once in four times.
    pub fn direction(&mut self) -> Vector {
        let mut v = self.vector();
        if self.once_in(4) {
            let axis = self.below(3) as usize;
            v = Vector::from_fn(|k, _| if k == axis { v[k] } else { 0.0 });
        }
        v.try_normalize(1e-9).unwrap_or_else(Vector::z)
    }

    /// By a small angle, about 2^`low` to 2^`high` rad.
    pub fn small_turn(&mut self, low: i32, high: i32) -> UnitQuaternion<f64> {
        let half = self.direction() * (0.5 * self.between(low, high));
        UnitQuaternion::from_quaternion(Quaternion::from_imag(half) + Quaternion::new(1.0, 0.0, 0.0, 0.0))
    }

    /// None, a turn of a cube onto itself, nearly such a turn, or any.
    pub fn rotation(&mut self) -> UnitQuaternion<f64> {
        let whole = [self.signed(), self.signed(), self.signed(), self.signed()];
        // One, two or four components that are not 0, all alike.
        let cube = [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 1.0], [1.0; 4]];
        let cube = self.of(&cube).map(|x: f64| if self.once_in(2) { x } else { -x });
        let made = |[w, x, y, z]: [f64; 4]| {
            UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9).unwrap_or_else(UnitQuaternion::identity)
        };
        match self.below(6) {
            0 => UnitQuaternion::identity(),
            1 => made(cube),
            2 => made(cube) * self.small_turn(-50, -8),
            _ => made(whole),
        }
    }
}
