//! Limits of the machine: multiply-adds in registers, and numbers read from a buffer of a given size. One core, with
//! its widest vectors.

#![allow(unsafe_code)]

use std::hint::black_box;
use std::time::{Duration, Instant};

type Lanes = [f64; 8];

/// Number of timed batches, of which the fastest is the result.
const BATCHES: usize = 15;

/// Approximate duration of a batch.
const BATCH: Duration = Duration::from_millis(4);

/// Number of sums that fit into the registers of AVX-512, and of narrower sets.
const WIDE: usize = 16;
const NARROW: usize = 3;

#[inline(always)]
fn multiply_add_body<const SUMS: usize>(rounds: usize) -> f64 {
    let (factor, term): (Lanes, Lanes) = black_box(([0.999; 8], [1e-3; 8]));
    let mut sums: [Lanes; SUMS] = black_box([[1.0; 8]; SUMS]);
    for _ in 0..rounds {
        for sum in &mut sums {
            for l in 0..8 {
                sum[l] = sum[l].mul_add(factor[l], term[l]);
            }
        }
    }
    sums.as_flattened().iter().sum()
}

#[inline(always)]
fn read_body<const SUMS: usize>(data: &[Lanes], rounds: usize) -> f64 {
    let mut sums: [Lanes; SUMS] = [[0.0; 8]; SUMS];
    for _ in 0..rounds {
        for group in black_box(data).chunks_exact(SUMS) {
            for (sum, lanes) in sums.iter_mut().zip(group) {
                for l in 0..8 {
                    sum[l] += lanes[l];
                }
            }
        }
    }
    sums.as_flattened().iter().sum()
}

/// Uses explicit vectors, because the compiler would process the lanes one by one.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn multiply_add_avx512(rounds: usize) -> f64 {
    use std::arch::x86_64::{_mm512_fmadd_pd, _mm512_reduce_add_pd, _mm512_set1_pd};
    let (factor, term) = black_box((0.999, 1e-3));
    let (factor, term) = (_mm512_set1_pd(factor), _mm512_set1_pd(term));
    let mut sums = [_mm512_set1_pd(black_box(1.0)); WIDE];
    for _ in 0..rounds {
        for sum in &mut sums {
            *sum = _mm512_fmadd_pd(*sum, factor, term);
        }
    }
    sums.iter().map(|sum| _mm512_reduce_add_pd(*sum)).sum()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx2,fma")]
fn read_avx512(data: &[Lanes], rounds: usize) -> f64 {
    read_body::<WIDE>(data, rounds)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn multiply_add_avx2(rounds: usize) -> f64 {
    use std::arch::x86_64::{_mm256_cvtsd_f64, _mm256_fmadd_pd, _mm256_set1_pd};
    let (factor, term) = black_box((0.999, 1e-3));
    let (factor, term) = (_mm256_set1_pd(factor), _mm256_set1_pd(term));
    let mut sums = [_mm256_set1_pd(black_box(1.0)); 4 * NARROW];
    for _ in 0..rounds {
        for sum in &mut sums {
            *sum = _mm256_fmadd_pd(*sum, factor, term);
        }
    }
    sums.iter().map(|sum| _mm256_cvtsd_f64(*sum)).sum()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn read_avx2(data: &[Lanes], rounds: usize) -> f64 {
    read_body::<NARROW>(data, rounds)
}

/// Runs the loop; returns the number of multiply-adds per round.
fn multiply_add(rounds: usize) -> usize {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            // SAFETY: the processor was asked for what the function needs.
            black_box(unsafe { multiply_add_avx512(rounds) });
            return 8 * WIDE;
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: as above.
            black_box(unsafe { multiply_add_avx2(rounds) });
            return 16 * NARROW;
        }
    }
    black_box(multiply_add_body::<NARROW>(rounds));
    8 * NARROW
}

fn read(data: &[Lanes], rounds: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            // SAFETY: the processor was asked for what the function needs.
            black_box(unsafe { read_avx512(data, rounds) });
            return;
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: as above.
            black_box(unsafe { read_avx2(data, rounds) });
            return;
        }
    }
    black_box(read_body::<NARROW>(data, rounds));
}

/// Nanoseconds of the fastest round.
fn fastest(mut rounds_of: impl FnMut(usize)) -> f64 {
    let mut rounds = 1;
    let timed = |rounds: usize, run: &mut dyn FnMut(usize)| {
        let clock = Instant::now();
        run(rounds);
        clock.elapsed()
    };
    while timed(rounds, &mut rounds_of) < BATCH {
        rounds *= 2;
    }
    let best = (0..BATCHES).map(|_| timed(rounds, &mut rounds_of)).min();
    best.map_or(f64::NAN, |time| time.as_secs_f64() * 1e9 / rounds as f64)
}

/// Multiply-adds per nanosecond, for numbers in registers.
pub fn multiply_adds() -> f64 {
    let mut numbers = 0;
    let time = fastest(|rounds| numbers = multiply_add(rounds));
    numbers as f64 / time
}

/// Nanoseconds to read a buffer of `numbers` numbers that was just read.
pub fn reading(numbers: usize) -> f64 {
    #[repr(C, align(64))]
    #[derive(Clone, Copy)]
    struct Aligned([Lanes; WIDE]);
    let groups = numbers.div_ceil(8 * WIDE);
    let data = vec![Aligned([[1.0; 8]; WIDE]); groups];
    // SAFETY: `Aligned` is an array of lane groups and nothing else (its size is a multiple of
    // its alignment), so that the vector's memory is that of `WIDE` times as many groups.
    let flat = unsafe { std::slice::from_raw_parts(data.as_ptr().cast::<Lanes>(), groups * WIDE) };
    fastest(|rounds| read(flat, rounds)) * numbers as f64 / (groups * 8 * WIDE) as f64
}
