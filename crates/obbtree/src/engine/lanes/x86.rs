//! AVX-512 and AVX2. Every value of these types comes from a function below that runs only on a processor that was asked ([`super::Simd::run`]); with that all
//! intrinsics here are sound: they touch no memory but the arrays they are given, unaligned.

/// An operator of a register by one instruction; for the rows as well.
macro_rules! operator {
    ($register:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $register {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: see the module.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

/// Methods of a register that are one instruction each; for the rows as well.
macro_rules! methods {
    ($($method:ident($($other:ident),*) $intrinsic:ident;)*) => {$(
        #[inline(always)]
        fn $method(self $(, $other: Self)*) -> Self {
            // SAFETY: see the module.
            Self(unsafe { $intrinsic(self.0 $(, $other.0)*) })
        }
    )*};
}

mod row;

use super::{Add, Coordinate, DOUBLES, Div, DoubleLanes, FOUR, Lanes, Machine, Mul, Sub, WIDTH, Work};
use row::{Row4, Row8};
use std::arch::x86_64::*;

/// Compiled with AVX-512.
///
/// # Safety
/// The processor must have it.
#[target_feature(enable = "avx512f,avx512vl")]
pub(super) unsafe fn on_avx512<W: Work>(work: W) -> W::Output {
    work.run::<Avx512>()
}

/// Compiled with AVX2 and fused multiply-add, which came to processors with it.
///
/// # Safety
/// The processor must have both.
#[target_feature(enable = "avx2,fma")]
pub(super) unsafe fn on_avx2<W: Work>(work: W) -> W::Output {
    work.run::<Avx2>()
}

/// A machine with these lanes; all else is the same on both.
macro_rules! machine {
    ($machine:ident, $single:ident) => {
        struct $machine;
        impl Machine for $machine {
            type Single = $single;
            type Double = Double4;

            #[inline(always)]
            fn join(into: &mut [f32; WIDTH], other: &[f32; WIDTH]) {
                join(into, other);
            }

            #[inline(always)]
            fn least_of(numbers: &[f32; WIDTH], places: u8) -> f32 {
                least_of(numbers, places)
            }
        }
    };
}

machine!(Avx512, Single16);
machine!(Avx2, Single8);

#[inline(always)]
fn join(into: &mut [f32; WIDTH], other: &[f32; WIDTH]) {
    // SAFETY: see the module; eight numbers are stored.
    unsafe {
        let least = _mm256_min_ps(_mm256_loadu_ps(other.as_ptr()), _mm256_loadu_ps(into.as_ptr()));
        _mm256_storeu_ps(into.as_mut_ptr(), least);
    }
}

#[inline(always)]
fn least_of(numbers: &[f32; WIDTH], places: u8) -> f32 {
    // SAFETY: see the module.
    unsafe {
        let bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        let chosen = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(i32::from(places)), bit), bit);
        let numbers = _mm256_loadu_ps(numbers.as_ptr());
        let chosen = _mm256_blendv_ps(_mm256_set1_ps(f32::INFINITY), numbers, _mm256_castsi256_ps(chosen));
        let four = _mm_min_ps(_mm256_castps256_ps128(chosen), _mm256_extractf128_ps::<1>(chosen));
        let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
        _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)))
    }
}

/// Sixteen `f32` lanes: two visits.
#[derive(Clone, Copy)]
pub(super) struct Single16(__m512);
/// Eight `f32` lanes: one visit.
#[derive(Clone, Copy)]
pub(super) struct Single8(__m256);
/// Four `f64` lanes: pairs of triangles seldom come by the eight.
#[derive(Clone, Copy)]
pub(super) struct Double4(__m256d);

operator!(Single16, Add, add, _mm512_add_ps);
operator!(Single16, Sub, sub, _mm512_sub_ps);
operator!(Single16, Mul, mul, _mm512_mul_ps);
operator!(Single16, Div, div, _mm512_div_ps);
operator!(Single8, Add, add, _mm256_add_ps);
operator!(Single8, Sub, sub, _mm256_sub_ps);
operator!(Single8, Mul, mul, _mm256_mul_ps);
operator!(Single8, Div, div, _mm256_div_ps);
operator!(Double4, Add, add, _mm256_add_pd);
operator!(Double4, Sub, sub, _mm256_sub_pd);
operator!(Double4, Mul, mul, _mm256_mul_pd);
operator!(Double4, Div, div, _mm256_div_pd);

impl Lanes for Single16 {
    type Row = Row8;
    const VISITS: usize = 2;
    const PARTS: usize = 1;
    #[inline(always)]
    fn load<'a>(_: usize, of: impl Fn(usize) -> &'a [f32; WIDTH]) -> Self {
        // SAFETY: see the module.
        unsafe {
            let (low, high) = (_mm256_loadu_ps(of(0).as_ptr()), _mm256_loadu_ps(of(1).as_ptr()));
            let both = _mm512_castps_pd(_mm512_castps256_ps512(low));
            Self(_mm512_castpd_ps(_mm512_insertf64x4::<1>(both, _mm256_castps_pd(high))))
        }
    }
    #[inline(always)]
    fn all(x: f32) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm512_set1_ps(x) })
    }
    #[inline(always)]
    fn spread(row: Row8) -> [Self; FOUR] {
        // SAFETY: see the module.
        unsafe {
            let row = _mm512_castps256_ps512(row.0);
            let lane = |k: i32| {
                let l = k + 4;
                Self(_mm512_permutexvar_ps(_mm512_setr_epi32(k, k, k, k, k, k, k, k, l, l, l, l, l, l, l, l), row))
            };
            [lane(0), lane(1), lane(2), lane(3)]
        }
    }
    methods! {
        mul_add(factor, term) _mm512_fmadd_ps;
        neg_mul_add(factor, term) _mm512_fnmadd_ps;
        abs() _mm512_abs_ps;
        sqrt() _mm512_sqrt_ps;
        max(other) _mm512_max_ps;
        min(other) _mm512_min_ps;
    }
    #[inline(always)]
    fn exceeds(self, other: Self) -> u32 {
        // SAFETY: see the module.
        u32::from(unsafe { _mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn store(self, _: usize, to: &mut [[f32; WIDTH]; 2]) {
        // SAFETY: see the module; two arrays of eight are sixteen numbers in a row.
        unsafe { _mm512_storeu_ps(to.as_mut_ptr().cast(), self.0) }
    }
}

impl Lanes for Single8 {
    type Row = Row4;
    const VISITS: usize = 1;
    const PARTS: usize = 1;
    #[inline(always)]
    fn load<'a>(_: usize, of: impl Fn(usize) -> &'a [f32; WIDTH]) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_loadu_ps(of(0).as_ptr()) })
    }
    #[inline(always)]
    fn all(x: f32) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_set1_ps(x) })
    }
    #[inline(always)]
    fn spread(row: Row4) -> [Self; FOUR] {
        // SAFETY: see the module.
        unsafe {
            let row = _mm256_castps128_ps256(row.0);
            let lane = |k: i32| Self(_mm256_permutevar8x32_ps(row, _mm256_set1_epi32(k)));
            [lane(0), lane(1), lane(2), lane(3)]
        }
    }
    methods! {
        mul_add(factor, term) _mm256_fmadd_ps;
        neg_mul_add(factor, term) _mm256_fnmadd_ps;
        sqrt() _mm256_sqrt_ps;
        max(other) _mm256_max_ps;
        min(other) _mm256_min_ps;
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn exceeds(self, other: Self) -> u32 {
        // SAFETY: see the module.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0)) as u32 }
    }
    #[inline(always)]
    fn store(self, _: usize, to: &mut [[f32; WIDTH]; 2]) {
        // SAFETY: see the module.
        unsafe { _mm256_storeu_ps(to[0].as_mut_ptr(), self.0) }
    }
}

impl Coordinate for Double4 {
    #[inline(always)]
    fn all(x: f64) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_set1_pd(x) })
    }
}

impl DoubleLanes for Double4 {
    #[inline(always)]
    fn load(from: &[f64; DOUBLES]) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_loadu_pd(from.as_ptr()) })
    }
    #[inline(always)]
    fn stored(self) -> [f64; DOUBLES] {
        let mut stored = [0.0; DOUBLES];
        // SAFETY: see the module; four numbers are stored.
        unsafe { _mm256_storeu_pd(stored.as_mut_ptr(), self.0) };
        stored
    }
    methods! {
        min(other) _mm256_min_pd;
        max(other) _mm256_max_pd;
        sqrt() _mm256_sqrt_pd;
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }
    #[inline(always)]
    fn exceeds(self, other: Self) -> u8 {
        // SAFETY: see the module.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0)) as u8 }
    }
}
