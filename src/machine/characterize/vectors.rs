//! Loops with the machine's vectors: streaming through lines, and multiply-adds in registers.
//!
//! They are written with intrinsics to measure exactly the intended operations. A compiler replaces a plain
//! copy by a call of `memcpy`, which chooses its stores by size, and it computes independent sums one after
//! the other. An empty `asm` in the copying loops prevents this replacement.

#![allow(unsafe_code)]

use super::buffer::Line;
use strum::Display;

/// Instruction set of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Display)]
#[strum(serialize_all = "lowercase")]
pub enum Set {
    /// Instructions of every processor of the architecture.
    Baseline,
    /// AVX2 and fused multiply-adds.
    Avx2,
    /// AVX-512.
    Avx512,
}

impl Set {
    /// All sets of this machine, narrowest first.
    pub fn available() -> Vec<Self> {
        #[allow(unused_mut)]
        let mut sets = vec![Self::Baseline];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                sets.push(Self::Avx2);
            }
            if is_x86_feature_detected!("avx512f") {
                sets.push(Self::Avx512);
            }
        }
        sets
    }

    /// The widest set of this machine.
    pub fn widest() -> Self {
        Self::available().last().copied().unwrap_or(Self::Baseline)
    }
}

/// Whether the loops have stores that bypass the caches on this architecture.
pub const NON_TEMPORAL: bool = cfg!(target_arch = "x86_64");

/// Number of parallel sums while reading.
const READERS: usize = 8;

/// Defines the loops of a module for vectors of one width.
#[cfg(target_arch = "x86_64")]
macro_rules! loops {
    ($set:ident, $features:literal, $width:literal, $sums:literal,
     $load:ident, $store:ident, $stream:ident, $splat:ident, $add:ident, $unload:ident,
     |$a:ident, $b:ident, $c:ident| $multiply_add:expr) => {
        mod $set {
            use super::super::buffer::{LANES, Line};
            use crate::characterize::vectors::READERS;
            use std::arch::asm;
            use std::arch::x86_64::*;
            use std::hint::black_box;

            const VECTORS: usize = LANES / $width;

            #[target_feature(enable = $features)]
            pub fn read(lines: &[Line], stride: usize, count: usize, passes: usize) -> f64 {
                let mut sums = [$splat(0.0); READERS];
                let lines = &lines[..(count * stride).min(lines.len())];
                let mut total = 0.0;
                for _ in 0..passes {
                    let lines = black_box(lines);
                    let mut at = 0;
                    while at + (READERS - 1) * stride < lines.len() {
                        for (k, sum) in sums.iter_mut().enumerate() {
                            // SAFETY: k is less than READERS, so that this line is before the end.
                            let line = unsafe { lines.get_unchecked(at + k * stride) };
                            for v in 0..VECTORS {
                                // SAFETY: a vector within an aligned line.
                                *sum =
                                    $add(*sum, unsafe { $load(line.0.as_ptr().add($width * v)) });
                            }
                        }
                        at += READERS * stride;
                    }
                    while at < lines.len() {
                        total += lines[at].0.iter().sum::<f64>();
                        at += stride;
                    }
                }
                for sum in sums {
                    let mut parts = [0.0; $width];
                    // SAFETY: `parts` is as long as the vector; the store needs no alignment.
                    unsafe { $unload(parts.as_mut_ptr(), sum) };
                    total += parts.iter().sum::<f64>();
                }
                total
            }

            #[target_feature(enable = $features)]
            pub fn copy<const PAST: bool>(from: &[Line], to: &mut [Line]) {
                for (from, to) in from.iter().zip(to) {
                    for v in 0..VECTORS {
                        // SAFETY: vectors within aligned lines.
                        unsafe {
                            let value = $load(from.0.as_ptr().add($width * v));
                            let place = to.0.as_mut_ptr().add($width * v);
                            if PAST { $stream(place, value) } else { $store(place, value) }
                        }
                    }
                    // SAFETY: the assembly contains no instruction.
                    unsafe { asm!("", options(nostack, preserves_flags)) };
                }
                _mm_sfence();
            }

            #[target_feature(enable = $features)]
            pub fn triad<const PAST: bool>(b: &[Line], c: &[Line], factor: f64, a: &mut [Line]) {
                let $b = $splat(factor);
                for ((b, c), a) in b.iter().zip(c).zip(a) {
                    for v in 0..VECTORS {
                        // SAFETY: vectors within aligned lines.
                        unsafe {
                            let $c = $load(b.0.as_ptr().add($width * v));
                            let $a = $load(c.0.as_ptr().add($width * v));
                            let place = a.0.as_mut_ptr().add($width * v);
                            if PAST {
                                $stream(place, $multiply_add)
                            } else {
                                $store(place, $multiply_add)
                            }
                        }
                    }
                }
                _mm_sfence();
            }

            #[target_feature(enable = $features)]
            pub fn multiply_add(rounds: usize) -> (f64, usize) {
                let $b = $splat(black_box(0.5));
                let $c = $splat(black_box(1.0));
                let mut sums = [$splat(black_box(0.0)); $sums];
                for _ in 0..rounds {
                    for sum in &mut sums {
                        let $a = *sum;
                        *sum = $multiply_add;
                    }
                }
                let mut smallest = f64::INFINITY;
                for sum in sums {
                    let mut parts = [0.0; $width];
                    // SAFETY: `parts` is as long as the vector; the store needs no alignment.
                    unsafe { $unload(parts.as_mut_ptr(), sum) };
                    smallest = parts.iter().fold(smallest, |m, v| m.min(*v));
                }
                (smallest, 2 * $sums * $width * rounds)
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
loops!(
    avx512,
    "avx512f",
    8,
    16,
    _mm512_load_pd,
    _mm512_store_pd,
    _mm512_stream_pd,
    _mm512_set1_pd,
    _mm512_add_pd,
    _mm512_storeu_pd,
    |a, b, c| _mm512_fmadd_pd(a, b, c)
);
#[cfg(target_arch = "x86_64")]
loops!(
    avx2,
    "avx2,fma",
    4,
    12,
    _mm256_load_pd,
    _mm256_store_pd,
    _mm256_stream_pd,
    _mm256_set1_pd,
    _mm256_add_pd,
    _mm256_storeu_pd,
    |a, b, c| _mm256_fmadd_pd(a, b, c)
);
#[cfg(target_arch = "x86_64")]
loops!(
    baseline,
    "sse2",
    2,
    10,
    _mm_load_pd,
    _mm_store_pd,
    _mm_stream_pd,
    _mm_set1_pd,
    _mm_add_pd,
    _mm_storeu_pd,
    |a, b, c| _mm_add_pd(_mm_mul_pd(a, b), c)
);

/// Loops without intrinsics, and without stores that bypass the caches.
#[cfg(not(target_arch = "x86_64"))]
mod baseline {
    use super::super::buffer::{LANES, Line};
    use crate::characterize::vectors::READERS;
    use std::arch::asm;
    use std::hint::black_box;

    pub fn read(lines: &[Line], stride: usize, count: usize, passes: usize) -> f64 {
        let mut sums = [[0.0; LANES]; READERS];
        for _ in 0..passes {
            let lines = black_box(lines);
            for (k, line) in lines.iter().step_by(stride).take(count).enumerate() {
                for (sum, value) in sums[k % READERS].iter_mut().zip(line.0) {
                    *sum += value;
                }
            }
        }
        sums.as_flattened().iter().sum()
    }

    pub fn copy<const PAST: bool>(from: &[Line], to: &mut [Line]) {
        for (from, to) in from.iter().zip(to) {
            *to = *from;
            // SAFETY: the assembly contains no instruction.
            unsafe { asm!("", options(nostack, preserves_flags)) };
        }
    }

    pub fn triad<const PAST: bool>(b: &[Line], c: &[Line], factor: f64, a: &mut [Line]) {
        for ((b, c), a) in b.iter().zip(c).zip(a) {
            for l in 0..LANES {
                a.0[l] = c.0[l].mul_add(factor, b.0[l]);
            }
        }
    }

    pub fn multiply_add(rounds: usize) -> (f64, usize) {
        const SUMS: usize = 24;
        let (factor, term) = black_box((0.5, 1.0));
        let mut sums = black_box([0.0f64; SUMS]);
        for _ in 0..rounds {
            for sum in &mut sums {
                *sum = sum.mul_add(factor, term);
            }
        }
        (
            sums.into_iter().fold(f64::INFINITY, f64::min),
            2 * SUMS * rounds,
        )
    }
}

/// Calls the loop for the given set.
macro_rules! by_set {
    ($set:expr, $name:ident $(::<$past:tt>)?, $($argument:expr),*) => {
        match $set {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: only `Set::available` makes this set, after it has checked that the processor
            // supports it.
            Set::Avx512 => unsafe { avx512::$name$(::<$past>)?($($argument),*) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as for `Set::Avx512`.
            Set::Avx2 => unsafe { avx2::$name$(::<$past>)?($($argument),*) },
            // SAFETY: every processor supports the baseline.
            #[allow(unused_unsafe)]
            _ => unsafe { baseline::$name$(::<$past>)?($($argument),*) },
        }
    };
}

/// Sum of `count` lines at a distance of `stride` lines, read `passes` times.
pub fn read(set: Set, lines: &[Line], stride: usize, count: usize, passes: usize) -> f64 {
    by_set!(set, read, lines, stride, count, passes)
}

/// Copies lines; bypasses the caches if `past`.
pub fn copy(set: Set, past: bool, from: &[Line], to: &mut [Line]) {
    if past {
        by_set!(set, copy::<true>, from, to)
    } else {
        by_set!(set, copy::<false>, from, to)
    }
}

/// `a = b + factor c`; bypasses the caches if `past`.
pub fn triad(set: Set, past: bool, b: &[Line], c: &[Line], factor: f64, a: &mut [Line]) {
    if past {
        by_set!(set, triad::<true>, b, c, factor, a)
    } else {
        by_set!(set, triad::<false>, b, c, factor, a)
    }
}

/// Iterates `x ← x/2 + 1` from 0 in enough registers to keep the units busy; returns the smallest
/// x and the number of operations.
pub fn multiply_add(set: Set, rounds: usize) -> (f64, usize) {
    by_set!(set, multiply_add, rounds)
}

#[cfg(test)]
mod tests {
    use super::super::buffer::{Buffer, LANES};
    use super::*;

    fn numbered(lines: usize, factor: f64) -> Buffer {
        let mut buffer = Buffer::new(lines).unwrap();
        for (i, line) in buffer.lines_mut().iter_mut().enumerate() {
            *line = Line(std::array::from_fn(|l| factor * (i * LANES + l) as f64));
        }
        buffer
    }

    #[test]
    fn every_set_reads_each_line_once() {
        for set in Set::available() {
            for lines in [1, 7, 8, 9, 64, 100] {
                let buffer = numbered(lines, 1.0);
                for stride in [1, 2, 3, 8] {
                    let count = lines.div_ceil(stride);
                    let exact: f64 = (buffer.lines().iter().step_by(stride))
                        .flat_map(|line| line.0)
                        .sum();
                    assert_eq!(
                        read(set, buffer.lines(), stride, count, 3),
                        3.0 * exact,
                        "{set} {lines} {stride}"
                    );
                }
                let first: f64 = buffer.lines()[0].0.iter().sum();
                assert_eq!(read(set, buffer.lines(), 1, 1, 1), first);
            }
        }
    }

    #[test]
    fn every_set_writes_every_number() {
        let (b, c) = (numbered(33, 1.0), numbered(33, -2.0));
        for set in Set::available() {
            for past in [false, true] {
                let mut a = Buffer::new(33).unwrap();
                copy(set, past, b.lines(), a.lines_mut());
                assert_eq!(a.lines(), b.lines());
                a.fill(f64::NAN);
                triad(set, past, b.lines(), c.lines(), 3.0, a.lines_mut());
                let exact = numbered(33, -5.0);
                assert_eq!(a.lines(), exact.lines(), "{set} {past}");
            }
        }
    }

    #[test]
    fn iterations_converge_and_are_counted() {
        for set in Set::available() {
            assert_eq!(multiply_add(set, 1).0, 1.0);
            assert_eq!(multiply_add(set, 2).0, 1.5);
            let (value, operations) = multiply_add(set, 200);
            assert_eq!(value, 2.0);
            assert_eq!(operations, 200 * multiply_add(set, 1).1);
        }
    }
}
