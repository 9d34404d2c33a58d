//! Eight lanes as the machine has them.
//!
//! Loops over arrays are left to the compiler for vectors of two and four. For vectors of eight
//! it would keep the sums of several columns in memory, and gather where rows are summed along:
//! these are written out.

use super::{LANES, Lanes};
use crate::propagate::volterra::TERMS;
use crate::propagate::volterra::tables::{Row, Series};

/// Eight numbers and what is done to them.
pub trait Vector: Copy {
    /// Whether multiply-adds are fused.
    const FUSED: bool;
    /// Whether the registers hold the sums of several columns.
    const WIDE: bool;

    /// The same number in all lanes.
    fn splat(value: f64) -> Self;

    /// A number in the first lane, zero in the others.
    fn first(value: f64) -> Self;

    /// The first 8 numbers of a slice.
    fn read(from: &[f64]) -> Self;

    /// Sets the first 8 numbers of a slice.
    fn write(self, to: &mut [f64]);

    /// The number of one lane in all.
    fn lane(self, lane: usize) -> Self;

    /// `self · factor + term`.
    fn multiply_add(self, factor: Self, term: Self) -> Self;

    /// `self · factor`.
    fn times(self, factor: Self) -> Self;

    /// Magnitudes.
    fn size(self) -> Self;

    /// The last lane first.
    fn reversed(self) -> Self;

    /// `self + other`.
    fn plus(self, other: Self) -> Self;

    /// `Σ_j rows[k][j] weights[j]` for every k.
    fn products_of_rows(rows: &[Row; TERMS], weights: &Row) -> Series;

    /// Zero in all lanes.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// As lanes of a table.
    #[inline(always)]
    fn lanes(self) -> Lanes {
        let mut out = Lanes::ZERO;
        self.write(&mut out.0);
        out
    }

    /// The sum of all lanes.
    #[inline(always)]
    fn sum(self) -> f64 {
        let s = self.lanes().0;
        ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
    }

    /// `a b + c` of single numbers.
    #[inline(always)]
    fn fma(a: f64, b: f64, c: f64) -> f64 {
        if Self::FUSED {
            a.mul_add(b, c)
        } else {
            a * b + c
        }
    }
}

/// Lanes that the compiler packs as it can; fused multiply-adds where `FUSED`.
#[derive(Clone, Copy)]
pub struct Packed<const FUSED: bool>([f64; LANES]);

impl<const FUSED: bool> Vector for Packed<FUSED> {
    const FUSED: bool = FUSED;
    const WIDE: bool = false;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn first(value: f64) -> Self {
        let mut out = [0.0; LANES];
        out[0] = value;
        Self(out)
    }

    #[inline(always)]
    fn read(from: &[f64]) -> Self {
        let mut out = [0.0; LANES];
        out.copy_from_slice(&from[..LANES]);
        Self(out)
    }

    #[inline(always)]
    fn write(self, to: &mut [f64]) {
        to[..LANES].copy_from_slice(&self.0);
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> Self {
        Self::splat(self.0[lane])
    }

    #[inline(always)]
    fn multiply_add(mut self, factor: Self, term: Self) -> Self {
        for l in 0..LANES {
            self.0[l] = Self::fma(self.0[l], factor.0[l], term.0[l]);
        }
        self
    }

    #[inline(always)]
    fn times(mut self, factor: Self) -> Self {
        for l in 0..LANES {
            self.0[l] *= factor.0[l];
        }
        self
    }

    #[inline(always)]
    fn plus(mut self, other: Self) -> Self {
        for l in 0..LANES {
            self.0[l] += other.0[l];
        }
        self
    }

    #[inline(always)]
    fn size(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn reversed(mut self) -> Self {
        self.0.reverse();
        self
    }

    #[inline(always)]
    fn products_of_rows(rows: &[Row; TERMS], weights: &Row) -> Series {
        let mut out = [0.0; TERMS];
        for (out, row) in out.iter_mut().zip(rows) {
            let mut sums = Self::zero();
            for (v, w) in row.0.chunks_exact(LANES).zip(weights.0.chunks_exact(LANES)) {
                sums = Self::read(v).multiply_add(Self::read(w), sums);
            }
            *out = sums.sum();
        }
        out
    }
}

#[cfg(target_arch = "x86_64")]
pub use wide::Wide;

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod wide {
    use super::{LANES, Row, Series, TERMS, Vector};
    use std::arch::x86_64::{
        __m512d, _mm512_abs_pd, _mm512_add_pd, _mm512_fmadd_pd, _mm512_loadu_pd,
        _mm512_maskz_mov_pd, _mm512_mul_pd, _mm512_permutexvar_pd, _mm512_set1_epi64,
        _mm512_set1_pd, _mm512_setr_epi64, _mm512_shuffle_f64x2, _mm512_storeu_pd,
        _mm512_unpackhi_pd, _mm512_unpacklo_pd,
    };

    /// A register of AVX-512.
    ///
    /// It is named only as an argument of the bodies that `for_each_set` inlines into functions
    /// compiled for AVX-512, which are reached after the processor was asked for it: that is what
    /// every `unsafe` below relies on.
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

        /// Sums along a vector by folding two rows into one until one is left.
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

    /// The sum of every vector, one a lane.
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
}
