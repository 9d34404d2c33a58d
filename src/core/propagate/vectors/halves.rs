//! Eight lanes in two AVX registers.
//!
//! The compiler would turn loops over arrays into comparisons one by one and into masked stores. Some
//! processors execute masked stores slowly.

#![allow(unsafe_code)]

use super::shapes::{LANES, Lanes};
use super::vector::Vector;
use std::arch::x86_64::{
    __m256d, _CMP_NGT_UQ, _mm_add_pd, _mm_add_sd, _mm_cvtsd_f64, _mm_unpackhi_pd, _mm256_add_pd,
    _mm256_andnot_pd, _mm256_blendv_pd, _mm256_castpd256_pd128, _mm256_cmp_pd, _mm256_div_pd,
    _mm256_extractf128_pd, _mm256_fmadd_pd, _mm256_loadu_pd, _mm256_max_pd, _mm256_min_pd,
    _mm256_movemask_pd, _mm256_mul_pd, _mm256_permute4x64_pd, _mm256_set1_pd, _mm256_setr_pd,
    _mm256_storeu_pd, _mm256_sub_pd,
};

/// Lanes of a register.
const HALF: usize = LANES / 2;

/// Two AVX registers.
///
/// It is only used as a type argument of the bodies that `for_each_set` inlines into functions compiled for AVX2 with
/// fused multiply-adds. These are only called after the processor was checked for both. Every `unsafe` below relies on
/// this.
#[derive(Clone, Copy)]
pub struct Halves([__m256d; 2]);

/// A register for every pattern of four bits: NaN, with the sign bit, in the lanes of bits that are 1.
static MASKS: [[f64; HALF]; 1 << HALF] = {
    let mut masks = [[0.0; HALF]; 1 << HALF];
    let mut bits = 0;
    while bits < masks.len() {
        let mut lane = 0;
        while lane < HALF {
            if bits >> lane & 1 == 1 {
                masks[bits][lane] = f64::from_bits(u64::MAX);
            }
            lane += 1;
        }
        bits += 1;
    }
    masks
};

/// Applies an instruction to both halves of the operands.
macro_rules! both {
    ($instruction:ident($first:expr $(, $other:expr)*)) => {
        // SAFETY: the processor has AVX2 and fused multiply-adds.
        Self(unsafe { [$instruction($first.0[0] $(, $other.0[0])*), $instruction($first.0[1] $(, $other.0[1])*)] })
    };
}

impl Vector for Halves {
    const FUSED: bool = true;
    const WIDE: bool = false;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: the processor has AVX2.
        Self([unsafe { _mm256_set1_pd(value) }; 2])
    }

    #[inline(always)]
    fn first(value: f64) -> Self {
        // SAFETY: the processor has AVX2.
        Self(unsafe { [_mm256_setr_pd(value, 0.0, 0.0, 0.0), _mm256_set1_pd(0.0)] })
    }

    #[inline(always)]
    fn read(from: &[f64]) -> Self {
        let from = &from[..LANES];
        // SAFETY: the slice has eight numbers, and the processor has AVX2.
        Self(unsafe {
            [
                _mm256_loadu_pd(from.as_ptr()),
                _mm256_loadu_pd(from.as_ptr().add(HALF)),
            ]
        })
    }

    #[inline(always)]
    fn write(self, to: &mut [f64]) {
        let to = &mut to[..LANES];
        // SAFETY: as for `read`.
        unsafe {
            _mm256_storeu_pd(to.as_mut_ptr(), self.0[0]);
            _mm256_storeu_pd(to.as_mut_ptr().add(HALF), self.0[1]);
        }
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> Self {
        Self::splat(self.lanes().0[lane])
    }

    #[inline(always)]
    fn multiply_add(self, factor: Self, term: Self) -> Self {
        both!(_mm256_fmadd_pd(self, factor, term))
    }

    #[inline(always)]
    fn times(self, factor: Self) -> Self {
        both!(_mm256_mul_pd(self, factor))
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        both!(_mm256_add_pd(self, other))
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        both!(_mm256_sub_pd(self, other))
    }

    #[inline(always)]
    fn divided_by(self, divisor: Self) -> Self {
        both!(_mm256_div_pd(self, divisor))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        both!(_mm256_max_pd(self, other))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        both!(_mm256_min_pd(self, other))
    }

    #[inline(always)]
    fn size(self) -> Self {
        both!(_mm256_andnot_pd(Self::splat(-0.0), self))
    }

    #[inline(always)]
    fn reversed(self) -> Self {
        const ORDER: i32 = 0b00_01_10_11;
        let [low, high] = self.0;
        // SAFETY: the processor has AVX2.
        Self(unsafe {
            [
                _mm256_permute4x64_pd::<ORDER>(high),
                _mm256_permute4x64_pd::<ORDER>(low),
            ]
        })
    }

    #[inline(always)]
    fn shifted_in(self, first: f64) -> Self {
        let Lanes([a, b, c, d, e, f, g, _]) = self.lanes();
        // SAFETY: the processor has AVX2.
        Self(unsafe { [_mm256_setr_pd(first, a, b, c), _mm256_setr_pd(d, e, f, g)] })
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        let mut bits = 0;
        for half in 0..2 {
            // SAFETY: the processor has AVX2.
            let mask = unsafe {
                _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_NGT_UQ>(self.0[half], other.0[half]))
            };
            bits |= (mask as u32) << (HALF * half);
        }
        bits
    }

    #[inline(always)]
    fn chosen(self, mask: u32, other: Self) -> Self {
        let mut out = other;
        for half in 0..2 {
            let mask = &MASKS[(mask >> (HALF * half)) as usize % MASKS.len()];
            // SAFETY: the mask has four numbers, and the processor has AVX2.
            out.0[half] = unsafe {
                _mm256_blendv_pd(other.0[half], self.0[half], _mm256_loadu_pd(mask.as_ptr()))
            };
        }
        out
    }

    #[inline(always)]
    fn sum(self) -> f64 {
        let [low, high] = self.0;
        // SAFETY: the processor has AVX2.
        unsafe {
            let four = _mm256_add_pd(low, high);
            let upper = _mm256_extractf128_pd::<1>(four);
            let two = _mm_add_pd(_mm256_castpd256_pd128(four), upper);
            _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)))
        }
    }
}
