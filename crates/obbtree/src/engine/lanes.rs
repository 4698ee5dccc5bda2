//! The three instruction sets: AVX-512, AVX2, and what every machine has; chosen when the program runs.
//!
//! The tests are written once, over `Lanes` and `DoubleLanes`, and do the same IEEE operations in the same order. AVX-512 and AVX2 fuse
//! products of `f32` with the sums they go into, which has one rounding less; plain code rounds both, since a fused operation would be a call
//! there. So the first two have the same bits, and with them the same counts; plain code may open another node now and then. Verdicts are the
//! exact truth on all. Trees are the same on all: what builds them fuses nothing, in `f32` or `f64`.

#![expect(unsafe_code, reason = "vector instructions; here alone")]

mod row;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use row::{FOUR, Row, WideRow};

use crate::engine::geometry::grid::Coordinate;
use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};
use std::sync::OnceLock;

/// Boxes per visit of a node: the lanes that belong together.
pub use super::node::WIDTH;

/// An array of three, written out: closures would not surely be inlined, and what is not inlined is not compiled for the machine.
macro_rules! three {
    ($k:ident => $of:expr) => {
        [
            {
                let $k = 0;
                $of
            },
            {
                let $k = 1;
                $of
            },
            {
                let $k = 2;
                $of
            },
        ]
    };
}
pub(super) use three;

/// `f32` lanes: eight for each visit that fits a register, or half of the eight of one.
pub trait Lanes: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// Four numbers for each visit that fits a register.
    type Row: Row;
    /// How many visits fit a register.
    const VISITS: usize;
    /// How many registers the lanes of a visit take.
    const PARTS: usize;
    /// For each visit as many of eight numbers as fit, those of the given part.
    fn load<'a>(part: usize, of: impl Fn(usize) -> &'a [f32; WIDTH]) -> Self;
    /// The same number everywhere.
    fn all(x: f32) -> Self;
    /// Each of the four numbers of a row, in all lanes of its visit.
    fn spread(row: Self::Row) -> [Self; FOUR];
    /// `self`·`factor` + `term`, rounded once where the machine can ([`Simd::fuses`]).
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// `term` - `self`·`factor`, rounded likewise.
    fn neg_mul_add(self, factor: Self, term: Self) -> Self;
    /// The absolute values.
    fn abs(self) -> Self;
    /// The square roots.
    fn sqrt(self) -> Self;
    /// The larger, lane by lane; either when one is not a number.
    fn max(self, other: Self) -> Self;
    /// The smaller, lane by lane; either when one is not a number.
    fn min(self, other: Self) -> Self;
    /// A bit for each lane that is larger than the other's; the first visit's are the lowest.
    fn exceeds(self, other: Self) -> u32;
    /// The numbers of each visit, to where the part belongs.
    fn store(self, part: usize, to: &mut [[f32; WIDTH]; 2]);
}

/// Lanes of [`DoubleLanes`].
pub const DOUBLES: usize = 4;

/// Four `f64` lanes.
pub trait DoubleLanes: Coordinate + Div<Output = Self> {
    /// These numbers.
    fn load(from: &[f64; DOUBLES]) -> Self;
    /// The numbers.
    fn stored(self) -> [f64; DOUBLES];
    /// The absolute values.
    fn abs(self) -> Self;
    /// The square roots.
    fn sqrt(self) -> Self;
    /// The smaller, lane by lane; the other when one is not a number.
    fn min(self, other: Self) -> Self;
    /// The larger, lane by lane; the other when one is not a number.
    fn max(self, other: Self) -> Self;
    /// A bit for each lane that is larger than the other's.
    fn exceeds(self, other: Self) -> u8;
}

/// What the traversal is compiled for.
pub(super) trait Machine {
    type Single: Lanes;
    type Double: DoubleLanes;
    /// Puts the smaller number in each place of `into`. Written as a comparison, it would be stored place by place with AVX-512, which the next
    /// one would wait for.
    fn join(into: &mut [f32; WIDTH], other: &[f32; WIDTH]);
    /// The least of the numbers in the places with a bit, infinity where there is none; for the same reason.
    fn least_of(numbers: &[f32; WIDTH], places: u8) -> f32;
}

/// Something to be done on lanes, whichever they are.
pub(super) trait Work {
    type Output;
    /// Does it. Implementations are `#[inline(always)]`, so that all of it is compiled for the machine.
    fn run<M: Machine>(self) -> Self::Output;
}

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Simd(Set);

/// What queries of this process use.
static IN_USE: OnceLock<Simd> = OnceLock::new();

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    Portable,
}

impl Simd {
    /// What every machine has.
    pub const PORTABLE: Self = Self(Set::Portable);

    /// All that this machine has, the widest first.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let mut sets = Vec::with_capacity(3);
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl") {
                sets.push(Self(Set::Avx512));
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                sets.push(Self(Set::Avx2));
            }
        }
        sets.push(Self::PORTABLE);
        sets
    }

    /// What queries of this process use: the widest that this machine has, unless another one was chosen.
    #[must_use]
    pub fn in_use() -> Self {
        *IN_USE.get_or_init(|| Self::available()[0])
    }

    /// Chooses what [`Simd::in_use`] is, before anything has used it. Whether it could still be chosen.
    #[must_use]
    pub fn choose(self) -> bool {
        *IN_USE.get_or_init(|| self) == self
    }

    /// The one of this machine with that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::available().into_iter().find(|simd| simd.name() == name)
    }

    /// The name in files: `avx512`, `avx2` or `portable`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "avx512",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "avx2",
            Set::Portable => "portable",
        }
    }

    /// Whether products of `f32` are fused with the sums they go into: sets of which this is so do the very same.
    #[must_use]
    pub const fn fuses(self) -> bool {
        !matches!(self.0, Set::Portable)
    }

    /// Does `work` on it.
    #[inline]
    pub(super) fn run<W: Work>(self, work: W) -> W::Output {
        match self.0 {
            // SAFETY: a `Simd` of this set is made in `available` alone, after the processor was asked.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { x86::on_avx512(work) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { x86::on_avx2(work) },
            Set::Portable => work.run::<Portable>(),
        }
    }
}

/// Arrays, which the compiler turns into whatever vectors the target always has.
struct Portable;

impl Machine for Portable {
    type Single = Array<f32>;
    type Double = Array<f64>;

    #[inline(always)]
    fn join(into: &mut [f32; WIDTH], other: &[f32; WIDTH]) {
        for (x, y) in into.iter_mut().zip(other) {
            *x = if y < x { *y } else { *x };
        }
    }

    #[inline(always)]
    fn least_of(numbers: &[f32; WIDTH], places: u8) -> f32 {
        let at = |k: usize| if places >> k & 1 != 0 { numbers[k] } else { f32::INFINITY };
        (1..WIDTH).fold(at(0), |least, k| if at(k) < least { at(k) } else { least })
    }
}

/// Four, of which the registers that every machine has hold as many as are needed at a time; of eight, some would always wait in memory.
#[derive(Clone, Copy)]
pub(super) struct Array<T>([T; 4]);

macro_rules! array_operator {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl<T: Copy + $trait<Output = T>> $trait for Array<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(from_fn(|i| self.0[i] $operator other.0[i]))
            }
        }
    };
}
array_operator!(Add, add, +);
array_operator!(Sub, sub, -);
array_operator!(Mul, mul, *);
array_operator!(Div, div, /);

impl Lanes for Array<f32> {
    type Row = Self;
    const VISITS: usize = 1;
    const PARTS: usize = 2;
    #[inline(always)]
    fn load<'a>(part: usize, of: impl Fn(usize) -> &'a [f32; WIDTH]) -> Self {
        Self(of(0).as_chunks().0[part])
    }
    #[inline(always)]
    fn all(x: f32) -> Self {
        Self([x; 4])
    }
    #[inline(always)]
    fn spread(row: Self) -> [Self; FOUR] {
        row.each()
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, term: Self) -> Self {
        term - self * factor
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(from_fn(|i| if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(from_fn(|i| if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn exceeds(self, other: Self) -> u32 {
        (0..4).fold(0, |bits, i| bits | u32::from(self.0[i] > other.0[i]) << i)
    }
    #[inline(always)]
    fn store(self, part: usize, to: &mut [[f32; WIDTH]; 2]) {
        to[0].as_chunks_mut().0[part] = self.0;
    }
}

impl Coordinate for Array<f64> {
    #[inline(always)]
    fn all(x: f64) -> Self {
        Self([x; 4])
    }
}

impl DoubleLanes for Array<f64> {
    #[inline(always)]
    fn load(from: &[f64; DOUBLES]) -> Self {
        Self(*from)
    }
    #[inline(always)]
    fn stored(self) -> [f64; DOUBLES] {
        self.0
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(from_fn(|i| if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(from_fn(|i| if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn exceeds(self, other: Self) -> u8 {
        (0..4).fold(0, |bits, i| bits | u8::from(self.0[i] > other.0[i]) << i)
    }
}
