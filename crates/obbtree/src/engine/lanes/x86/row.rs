//! Rows of one visit with AVX2 and of two with AVX-512. Sound for the reason that [`super`] gives.

use super::super::{FOUR, Row, WideRow};
use super::Double4;
use std::arch::x86_64::*;
use std::ops::{Add, Mul, Sub};

/// Four `f32` for one visit.
#[derive(Clone, Copy)]
pub(in super::super) struct Row4(pub(super) __m128);
/// Four `f32` for each of two visits.
#[derive(Clone, Copy)]
pub(in super::super) struct Row8(pub(super) __m256);
/// Four `f64` for each of two visits.
#[derive(Clone, Copy)]
pub(in super::super) struct WideRow8(__m512d);

operator!(Row4, Mul, mul, _mm_mul_ps);
operator!(Row8, Mul, mul, _mm256_mul_ps);
operator!(WideRow8, Add, add, _mm512_add_pd);
operator!(WideRow8, Sub, sub, _mm512_sub_pd);
operator!(WideRow8, Mul, mul, _mm512_mul_pd);

/// The four numbers of each visit in `$register`, each four times, by the permutation `$permute` of fours.
macro_rules! each {
    ($register:expr, $permute:ident) => {
        // SAFETY: see the module.
        unsafe {
            [
                Self($permute::<0b00_00_00_00>($register)),
                Self($permute::<0b01_01_01_01>($register)),
                Self($permute::<0b10_10_10_10>($register)),
                Self($permute::<0b11_11_11_11>($register)),
            ]
        }
    };
}

/// All of [`Row`] that is the same for one visit and two but for the names of the instructions.
macro_rules! row {
    ($wide:ident, $all:ident, $permute:ident, $mul_add:ident, $neg_mul_add:ident, $sqrt:ident, $widen:ident) => {
        type Wide = $wide;
        #[inline(always)]
        fn all(x: f32) -> Self {
            // SAFETY: see the module.
            Self(unsafe { $all(x) })
        }
        #[inline(always)]
        fn each(self) -> [Self; FOUR] {
            each!(self.0, $permute)
        }
        methods! {
            mul_add(factor, term) $mul_add;
            neg_mul_add(factor, term) $neg_mul_add;
            sqrt() $sqrt;
        }
        #[inline(always)]
        fn widen(self) -> $wide {
            // SAFETY: see the module.
            $wide(unsafe { $widen(self.0) })
        }
    };
}

impl Row for Row4 {
    row!(Double4, _mm_set1_ps, _mm_permute_ps, _mm_fmadd_ps, _mm_fnmadd_ps, _mm_sqrt_ps, _mm256_cvtps_pd);
    #[inline(always)]
    fn of(of: impl Fn(usize) -> [f32; FOUR]) -> Self {
        let [x, y, z, w] = of(0);
        // SAFETY: see the module.
        Self(unsafe { _mm_setr_ps(x, y, z, w) })
    }
}

impl Row for Row8 {
    row!(
        WideRow8,
        _mm256_set1_ps,
        _mm256_permute_ps,
        _mm256_fmadd_ps,
        _mm256_fnmadd_ps,
        _mm256_sqrt_ps,
        _mm512_cvtps_pd
    );
    #[inline(always)]
    fn of(of: impl Fn(usize) -> [f32; FOUR]) -> Self {
        let ([x, y, z, w], [p, q, r, s]) = (of(0), of(1));
        // SAFETY: see the module.
        Self(unsafe { _mm256_setr_ps(x, y, z, w, p, q, r, s) })
    }
}

impl WideRow for Double4 {
    type Narrow = Row4;
    #[inline(always)]
    fn of<'a>(of: impl Fn(usize) -> &'a [f64; FOUR]) -> Self {
        // SAFETY: see the module.
        Self(unsafe { _mm256_loadu_pd(of(0).as_ptr()) })
    }
    #[inline(always)]
    fn each(self) -> [Self; FOUR] {
        each!(self.0, _mm256_permute4x64_pd)
    }
    #[inline(always)]
    fn narrow(self) -> Row4 {
        // SAFETY: see the module.
        Row4(unsafe { _mm256_cvtpd_ps(self.0) })
    }
}

impl WideRow for WideRow8 {
    type Narrow = Row8;
    #[inline(always)]
    fn of<'a>(of: impl Fn(usize) -> &'a [f64; FOUR]) -> Self {
        // SAFETY: see the module.
        unsafe {
            let low = _mm512_castpd256_pd512(_mm256_loadu_pd(of(0).as_ptr()));
            Self(_mm512_insertf64x4::<1>(low, _mm256_loadu_pd(of(1).as_ptr())))
        }
    }
    #[inline(always)]
    fn each(self) -> [Self; FOUR] {
        each!(self.0, _mm512_permutex_pd)
    }
    #[inline(always)]
    fn narrow(self) -> Row8 {
        // SAFETY: see the module.
        Row8(unsafe { _mm512_cvtpd_ps(self.0) })
    }
}
