//! Loops that are written with the machine's vectors: the compiler would keep the sums of several
//! columns in memory, and gather where rows are summed along.

use super::{LANES, Lanes, WIDE, fma};
use crate::propagate::volterra::TERMS;
use crate::propagate::volterra::tables::{Row, Series};

/// Numbers in whole lane groups on cache lines of their own.
///
/// # Safety
/// The type is `repr(C, align(64))` and made of nothing but a multiple of 8 numbers.
#[allow(unsafe_code)]
pub(super) unsafe trait Lined: Sized {}

// SAFETY: 24 numbers, aligned.
#[allow(unsafe_code)]
unsafe impl Lined for Row {}

// SAFETY: 8 numbers, aligned.
#[allow(unsafe_code)]
unsafe impl Lined for Lanes {}

/// The sums of a batch: two a column, of the even and of the odd rows, each of `GROUPS` lane
/// groups. Twice as many sums in flight hide the latency of the multiply-add.
pub(super) type Sums<const GROUPS: usize, const COLUMNS: usize> = [[[Lanes; GROUPS]; COLUMNS]; 2];

/// `sums[i % 2][c] += weights[c][i] · row i` for all rows of a table and every column c; a row has
/// `GROUPS` lane groups, and the number of rows is even.
#[inline(always)]
#[allow(unsafe_code)]
pub(super) fn accumulate<
    const SET: u8,
    const GROUPS: usize,
    const COLUMNS: usize,
    T: Lined,
>(
    table: &[T],
    weights: &[&[f64]; COLUMNS],
    sums: &mut Sums<GROUPS, COLUMNS>,
) {
    // SAFETY: the table's memory is that of so many numbers, by what `Lined` promises.
    let table = unsafe {
        let length = size_of_val(table) / size_of::<f64>();
        std::slice::from_raw_parts(table.as_ptr().cast::<f64>(), length)
    };
    let rows = table.len() / (GROUPS * LANES);
    for weights in weights {
        assert!(weights.len() >= rows && rows.is_multiple_of(2));
    }
    #[cfg(target_arch = "x86_64")]
    if SET == WIDE {
        // SAFETY: a body with this constant runs only inside a function compiled for AVX-512
        // and reached after the processor was asked for it. Tables are on cache lines, and every
        // column has a weight for every row.
        return unsafe { accumulate_avx512(table, rows, weights, sums) };
    }
    for c in 0..COLUMNS {
        for (i, pair) in table.chunks_exact(2 * GROUPS * LANES).enumerate() {
            for (way, row) in pair.chunks_exact(GROUPS * LANES).enumerate() {
                let weight = weights[c][2 * i + way];
                for g in 0..GROUPS {
                    for l in 0..LANES {
                        let sum = &mut sums[way][c][g].0[l];
                        *sum = fma::<SET>(row[g * LANES + l], weight, *sum);
                    }
                }
            }
        }
    }
}

/// [`accumulate`] over `rows` rows.
///
/// # Safety
/// The table starts on a cache line and holds the rows; so many weights has every column.
#[cfg(target_arch = "x86_64")]
#[inline]
#[target_feature(enable = "avx512f")]
#[allow(unsafe_code)]
unsafe fn accumulate_avx512<const GROUPS: usize, const COLUMNS: usize>(
    table: &[f64],
    rows: usize,
    weights: &[&[f64]; COLUMNS],
    sums: &mut Sums<GROUPS, COLUMNS>,
) {
    use std::arch::x86_64::{
        __m512d, _mm512_fmadd_pd, _mm512_load_pd, _mm512_set1_pd, _mm512_setzero_pd,
        _mm512_store_pd,
    };
    let mut held = [[[_mm512_setzero_pd(); GROUPS]; COLUMNS]; 2];
    for way in 0..2 {
        for c in 0..COLUMNS {
            for g in 0..GROUPS {
                // SAFETY: lane groups are on cache lines.
                held[way][c][g] = unsafe { _mm512_load_pd(sums[way][c][g].0.as_ptr()) };
            }
        }
    }
    for i in (0..rows).step_by(2) {
        for way in 0..2 {
            let mut row: [__m512d; GROUPS] = [_mm512_setzero_pd(); GROUPS];
            for g in 0..GROUPS {
                // SAFETY: within the table, at a multiple of 64 bytes from its start.
                row[g] = unsafe {
                    _mm512_load_pd(table.as_ptr().add(((i + way) * GROUPS + g) * LANES))
                };
            }
            for c in 0..COLUMNS {
                // SAFETY: every column has so many weights.
                let weight = _mm512_set1_pd(unsafe { *weights[c].get_unchecked(i + way) });
                for g in 0..GROUPS {
                    held[way][c][g] = _mm512_fmadd_pd(row[g], weight, held[way][c][g]);
                }
            }
        }
    }
    for way in 0..2 {
        for c in 0..COLUMNS {
            for g in 0..GROUPS {
                // SAFETY: lane groups are on cache lines.
                unsafe { _mm512_store_pd(sums[way][c][g].0.as_mut_ptr(), held[way][c][g]) };
            }
        }
    }
}

/// `Σ_j rows[k][j] weights[j]` for every k.
#[inline(always)]
#[allow(unsafe_code)]
pub(super) fn products_of_rows<const SET: u8>(rows: &[Row; TERMS], weights: &Row) -> Series {
    #[cfg(target_arch = "x86_64")]
    if SET == WIDE {
        // SAFETY: a body with this constant runs only inside a function compiled for AVX-512
        // and reached after the processor was asked for it.
        return unsafe { products_of_rows_avx512(rows, weights) };
    }
    let mut out = [0.0; TERMS];
    for (out, row) in out.iter_mut().zip(rows) {
        let mut sums = [0.0; LANES];
        for (v, w) in row.0.chunks_exact(LANES).zip(weights.0.chunks_exact(LANES)) {
            for l in 0..LANES {
                sums[l] = fma::<SET>(v[l], w[l], sums[l]);
            }
        }
        *out = ((sums[0] + sums[4]) + (sums[2] + sums[6]))
            + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
    }
    out
}

/// Sums along a vector by folding two rows into one until one is left: the compiler would
/// rather gather columns.
#[cfg(target_arch = "x86_64")]
#[inline]
#[target_feature(enable = "avx512f")]
#[allow(unsafe_code)]
fn products_of_rows_avx512(rows: &[Row; TERMS], weights: &Row) -> Series {
    use std::arch::x86_64::{
        __m512d, _mm512_add_pd, _mm512_fmadd_pd, _mm512_load_pd, _mm512_mul_pd,
        _mm512_shuffle_f64x2, _mm512_storeu_pd, _mm512_unpackhi_pd, _mm512_unpacklo_pd,
    };
    let load = |row: &Row, group: usize| -> __m512d {
        let lanes = &row.0[group * LANES..(group + 1) * LANES];
        // SAFETY: 8 doubles of a row, which starts at a multiple of 64 bytes.
        unsafe { _mm512_load_pd(lanes.as_ptr()) }
    };
    let w: [__m512d; TERMS / LANES] = std::array::from_fn(|group| load(weights, group));
    let dot = |row: &Row| {
        let mut sum = _mm512_mul_pd(load(row, 0), w[0]);
        for (group, w) in w.iter().enumerate().skip(1) {
            sum = _mm512_fmadd_pd(load(row, group), *w, sum);
        }
        sum
    };
    let fold4 = |a: __m512d, b: __m512d| {
        let low = _mm512_shuffle_f64x2::<0x44>(a, b);
        _mm512_add_pd(low, _mm512_shuffle_f64x2::<0xEE>(a, b))
    };
    let fold2 = |a: __m512d, b: __m512d| {
        let low = _mm512_shuffle_f64x2::<0x88>(a, b);
        _mm512_add_pd(low, _mm512_shuffle_f64x2::<0xDD>(a, b))
    };
    let mut out = [0.0; TERMS];
    for (out, r) in out.chunks_exact_mut(LANES).zip(rows.chunks_exact(LANES)) {
        let quarter = |i: usize| fold4(dot(&r[i]), dot(&r[i + 4]));
        let even = fold2(quarter(0), quarter(2));
        let odd = fold2(quarter(1), quarter(3));
        let (low, high) = (_mm512_unpacklo_pd(even, odd), _mm512_unpackhi_pd(even, odd));
        let sums = _mm512_add_pd(low, high);
        let sums = _mm512_shuffle_f64x2::<0xD8>(sums, sums);
        // SAFETY: `out` is a group of 8 doubles.
        unsafe { _mm512_storeu_pd(out.as_mut_ptr(), sums) };
    }
    out
}
