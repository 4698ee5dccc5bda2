//! What there is of one volume for each visit, in one register: its centre, its rotation, its half-lengths.

use super::Array;
use std::ops::{Add, Mul, Sub};

/// Numbers in a row of one visit: x, y, z and one more.
pub const FOUR: usize = 4;

/// Four `f32` for each visit that fits a register of [`super::Lanes`].
pub trait Row: Copy + Mul<Output = Self> {
    /// The same in `f64`.
    type Wide: WideRow<Narrow = Self>;
    /// The four of each visit.
    fn of(of: impl Fn(usize) -> [f32; FOUR]) -> Self;
    /// The same number everywhere.
    fn all(x: f32) -> Self;
    /// Each of a visit's four, four times.
    fn each(self) -> [Self; FOUR];
    /// `self`·`factor` + `term`, rounded once where the machine can ([`super::Simd::fuses`]).
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// `term` - `self`·`factor`, rounded likewise.
    fn neg_mul_add(self, factor: Self, term: Self) -> Self;
    /// The square roots.
    fn sqrt(self) -> Self;
    /// In `f64`.
    fn widen(self) -> Self::Wide;
}

/// Four `f64` for each visit.
pub trait WideRow: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The same in `f32`.
    type Narrow;
    /// The four of each visit.
    fn of<'a>(of: impl Fn(usize) -> &'a [f64; FOUR]) -> Self;
    /// Each of a visit's four, four times.
    fn each(self) -> [Self; FOUR];
    /// Rounded to `f32`.
    fn narrow(self) -> Self::Narrow;
}

impl Row for Array<f32> {
    type Wide = Array<f64>;
    #[inline(always)]
    fn of(of: impl Fn(usize) -> [f32; FOUR]) -> Self {
        Self(of(0))
    }
    #[inline(always)]
    fn all(x: f32) -> Self {
        Self([x; FOUR])
    }
    #[inline(always)]
    fn each(self) -> [Self; FOUR] {
        self.0.map(|x| Self([x; FOUR]))
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * factor.0[i] + term.0[i]))
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, term: Self) -> Self {
        Self(std::array::from_fn(|i| term.0[i] - self.0[i] * factor.0[i]))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }
    #[inline(always)]
    fn widen(self) -> Array<f64> {
        Array(self.0.map(f64::from))
    }
}

impl WideRow for Array<f64> {
    type Narrow = Array<f32>;
    #[inline(always)]
    fn of<'a>(of: impl Fn(usize) -> &'a [f64; FOUR]) -> Self {
        Self(*of(0))
    }
    #[inline(always)]
    fn each(self) -> [Self; FOUR] {
        self.0.map(|x| Self([x; FOUR]))
    }
    #[inline(always)]
    fn narrow(self) -> Array<f32> {
        Array(self.0.map(|x| x as f32))
    }
}
