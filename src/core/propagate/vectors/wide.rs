//! Eight lanes in an AVX-512 register.

#![allow(unsafe_code)]

use super::shapes::{LANES, Row, Series, TERMS};
use super::vector::Vector;
use std::arch::x86_64::{
    __m512d, _CMP_NGT_UQ, _mm512_abs_pd, _mm512_add_pd, _mm512_cmp_pd_mask, _mm512_div_pd,
    _mm512_fmadd_pd, _mm512_loadu_pd, _mm512_mask_mov_pd, _mm512_maskz_mov_pd, _mm512_max_pd,
    _mm512_min_pd, _mm512_mul_pd, _mm512_permutexvar_pd, _mm512_set1_epi64, _mm512_set1_pd,
    _mm512_setr_epi64, _mm512_shuffle_f64x2, _mm512_storeu_pd, _mm512_sub_pd, _mm512_unpackhi_pd,
    _mm512_unpacklo_pd,
};

/// An AVX-512 register.
///
/// It is only used as a type argument of the bodies that `for_each_set` inlines into functions compiled for AVX-512.
/// These are only called after the processor was checked for AVX-512. Every `unsafe` below relies on this.
#[derive(Clone, Copy)]
pub struct Wide(__m512d);

impl Vector for Wide {
    const FUSED: bool = true;
    const WIDE: bool = true;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn first(value: f64) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_maskz_mov_pd(1, _mm512_set1_pd(value)) })
    }

    #[inline(always)]
    fn read(from: &[f64]) -> Self {
        // SAFETY: as above; the slice has 8 numbers.
        Self(unsafe { _mm512_loadu_pd(from[..LANES].as_ptr()) })
    }

    #[inline(always)]
    fn write(self, to: &mut [f64]) {
        // SAFETY: as above; the slice has 8 numbers.
        unsafe { _mm512_storeu_pd(to[..LANES].as_mut_ptr(), self.0) }
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_permutexvar_pd(_mm512_set1_epi64(lane as i64), self.0) })
    }

    #[inline(always)]
    fn multiply_add(self, factor: Self, term: Self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_fmadd_pd(self.0, factor.0, term.0) })
    }

    #[inline(always)]
    fn times(self, factor: Self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_mul_pd(self.0, factor.0) })
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_add_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_sub_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn divided_by(self, divisor: Self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_div_pd(self.0, divisor.0) })
    }

    #[inline(always)]
    fn chosen(self, mask: u32, other: Self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_mask_mov_pd(other.0, mask as u8, self.0) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn sums(vectors: [Self; LANES]) -> Self {
        folded(vectors)
    }

    #[inline(always)]
    fn size(self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe { _mm512_abs_pd(self.0) })
    }

    #[inline(always)]
    fn reversed(self) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe {
            let order = _mm512_setr_epi64(7, 6, 5, 4, 3, 2, 1, 0);
            _mm512_permutexvar_pd(order, self.0)
        })
    }

    #[inline(always)]
    fn shifted_in(self, first: f64) -> Self {
        // SAFETY: the processor has AVX-512.
        Self(unsafe {
            let order = _mm512_setr_epi64(0, 0, 1, 2, 3, 4, 5, 6);
            let moved = _mm512_permutexvar_pd(order, self.0);
            _mm512_mask_mov_pd(moved, 1, _mm512_set1_pd(first))
        })
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        // SAFETY: the processor has AVX-512.
        u32::from(unsafe { _mm512_cmp_pd_mask::<_CMP_NGT_UQ>(self.0, other.0) })
    }

    /// Forms the sums of 8 rows at a time: adds pairs of vectors until one vector with the 8 sums is left.
    #[inline(always)]
    fn products_of_rows(rows: &[Row; TERMS], weights: &Row) -> Series {
        let mut w = [Self::zero(); TERMS / LANES];
        for g in 0..TERMS / LANES {
            w[g] = Self::read(&weights.0[g * LANES..]);
        }
        let mut out = [0.0; TERMS];
        for (out, rows) in out.chunks_exact_mut(LANES).zip(rows.chunks_exact(LANES)) {
            let mut sums = [Self::zero(); LANES];
            for (sum, row) in sums.iter_mut().zip(rows) {
                *sum = Self::read(&row.0).times(w[0]);
                for g in 1..TERMS / LANES {
                    *sum = Self::read(&row.0[g * LANES..]).multiply_add(w[g], *sum);
                }
            }
            folded(sums).write(out);
        }
        out
    }
}

/// The sum of every vector, one per lane.
#[inline(always)]
fn folded(v: [Wide; LANES]) -> Wide {
    let mut quarters = [Wide::zero(); 4];
    for i in 0..4 {
        let (a, b) = (v[i].0, v[i + 4].0);
        // SAFETY: the processor has AVX-512.
        let (low, high) = unsafe {
            (
                _mm512_shuffle_f64x2::<0x44>(a, b),
                _mm512_shuffle_f64x2::<0xEE>(a, b),
            )
        };
        quarters[i] = Wide(low).plus(Wide(high));
    }
    let mut halves = [Wide::zero(); 2];
    for i in 0..2 {
        let (a, b) = (quarters[i].0, quarters[i + 2].0);
        // SAFETY: the processor has AVX-512.
        let (low, high) = unsafe {
            (
                _mm512_shuffle_f64x2::<0x88>(a, b),
                _mm512_shuffle_f64x2::<0xDD>(a, b),
            )
        };
        halves[i] = Wide(low).plus(Wide(high));
    }
    let [even, odd] = halves;
    // SAFETY: the processor has AVX-512.
    unsafe {
        let low = _mm512_unpacklo_pd(even.0, odd.0);
        let sums = _mm512_add_pd(low, _mm512_unpackhi_pd(even.0, odd.0));
        Wide(_mm512_shuffle_f64x2::<0xD8>(sums, sums))
    }
}
