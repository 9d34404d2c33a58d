//! Eight lanes in the machine's vectors.
//!
//! For vectors of two numbers, the compiler packs loops over arrays. For vectors of eight numbers, it would
//! keep the sums of several columns in memory and use gathers for sums along rows. Vectors of four and of
//! eight numbers are therefore written out in separate files.

use super::shapes::{LANES, Lanes, Row, Series, TERMS};

/// Eight numbers and their operations.
pub trait Vector: Copy {
    /// Whether multiply-adds are fused.
    const FUSED: bool;
    /// Whether there are enough registers for the sums of several columns at a time.
    const WIDE: bool;

    /// The same number in all lanes.
    fn splat(value: f64) -> Self;

    /// A number in the first lane, zero in the others.
    fn first(value: f64) -> Self;

    /// The first 8 numbers of a slice.
    fn read(from: &[f64]) -> Self;

    /// Writes the first 8 numbers of a slice.
    fn write(self, to: &mut [f64]);

    /// The number of one lane in all lanes.
    fn lane(self, lane: usize) -> Self;

    /// `self · factor + term`.
    fn multiply_add(self, factor: Self, term: Self) -> Self;

    /// `self · factor`.
    fn times(self, factor: Self) -> Self;

    /// Magnitudes.
    fn size(self) -> Self;

    /// The lanes in reverse order.
    fn reversed(self) -> Self;

    /// Every number one lane later, with `first` in the first lane. The last number is lost.
    fn shifted_in(self, first: f64) -> Self;

    /// Bit mask of the lanes that are at most those of `other`, the first lane in bit 0. Lanes with NaN count.
    fn at_most(self, other: Self) -> u32;

    /// `self + other`.
    fn plus(self, other: Self) -> Self;

    /// `self − other`.
    fn minus(self, other: Self) -> Self;

    /// `self / divisor`.
    fn divided_by(self, divisor: Self) -> Self;

    /// `self` in the lanes of a bit mask, `other` in the others.
    fn chosen(self, mask: u32, other: Self) -> Self;

    /// The larger number of each lane; if `self` or `other` is NaN, the number of `other`.
    fn larger(self, other: Self) -> Self;

    /// The smaller number of each lane; if `self` or `other` is NaN, the number of `other`.
    fn smaller(self, other: Self) -> Self;

    /// The sum of every vector, one per lane.
    #[inline(always)]
    fn sums(vectors: [Self; LANES]) -> Self {
        let mut sums = Lanes::ZERO;
        for l in 0..LANES {
            sums.0[l] = vectors[l].sum();
        }
        Self::read(&sums.0)
    }

    /// `Σ_j rows[k][j] weights[j]` for every k.
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

    /// Zero in all lanes.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// The lanes as an aligned array.
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
        if Self::FUSED { a.mul_add(b, c) } else { a * b + c }
    }
}

/// Lanes that the compiler packs, without fused multiply-adds.
#[derive(Clone, Copy)]
pub struct Packed([f64; LANES]);

impl Vector for Packed {
    const FUSED: bool = false;
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
            self.0[l] = self.0[l] * factor.0[l] + term.0[l];
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
    fn minus(mut self, other: Self) -> Self {
        for l in 0..LANES {
            self.0[l] -= other.0[l];
        }
        self
    }

    #[inline(always)]
    fn divided_by(mut self, divisor: Self) -> Self {
        for l in 0..LANES {
            self.0[l] /= divisor.0[l];
        }
        self
    }

    #[inline(always)]
    fn chosen(self, mask: u32, mut other: Self) -> Self {
        for l in 0..LANES {
            other.0[l] = if mask >> l & 1 == 1 { self.0[l] } else { other.0[l] };
        }
        other
    }

    #[inline(always)]
    fn larger(mut self, other: Self) -> Self {
        for l in 0..LANES {
            self.0[l] = if self.0[l] > other.0[l] { self.0[l] } else { other.0[l] };
        }
        self
    }

    #[inline(always)]
    fn smaller(mut self, other: Self) -> Self {
        for l in 0..LANES {
            self.0[l] = if self.0[l] < other.0[l] { self.0[l] } else { other.0[l] };
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
    fn shifted_in(mut self, first: f64) -> Self {
        self.0.rotate_right(1);
        self.0[0] = first;
        self
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        let mut bits = 0;
        for l in 0..LANES {
            let beyond = self.0[l] > other.0[l];
            bits |= u32::from(!beyond) << l;
        }
        bits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::propagate::vectors::{InstructionSet, for_each_set};

    const ONE: [f64; LANES] = [1.5, -2.0, f64::NAN, 0.0, -0.0, 7.25, -3.5, 1e-3];
    const OTHER: [f64; LANES] = [2.0, -2.0, 1.0, f64::NAN, 0.0, 6.5, -4.0, f64::INFINITY];

    fn results_of<V: Vector>() -> (Vec<f64>, Vec<u32>) {
        let (a, b) = (V::read(&ONE), V::read(&OTHER));
        let masks = vec![
            a.at_most(b),
            b.at_most(a),
            a.at_most(a),
            V::zero().at_most(a),
        ];
        let mut vectors = vec![
            V::splat(0.1),
            V::first(0.1),
            a.lane(5),
            a.times(b),
            a.plus(b),
            a.minus(b),
            a.divided_by(b),
            a.size(),
            a.reversed(),
            a.shifted_in(0.1),
            a.larger(b),
            b.larger(a),
            a.smaller(b),
            b.smaller(a),
            a.multiply_add(V::splat(2.0), b),
        ];
        for mask in 0..1 << LANES {
            vectors.push(a.chosen(mask, b));
        }
        let finite = V::read(&[0.1, 0.7, 1e-9, 3.3, -0.1, 1e5, 0.3, -7.0]);
        vectors.push(V::splat(finite.sum()));
        vectors.push(V::sums([
            V::zero(),
            finite,
            a.size(),
            V::splat(0.1),
            finite,
            finite,
            b,
            b,
        ]));
        let mut numbers = Vec::new();
        for vector in vectors {
            numbers.extend(vector.lanes().0);
        }
        (numbers, masks)
    }

    for_each_set! {
        /// The results of all operations.
        fn results() -> (Vec<f64>, Vec<u32>) = results_of
    }

    #[test]
    fn all_instruction_sets_give_the_same_results() {
        let (plain, masks) = results(InstructionSet::PORTABLE);
        assert_eq!(masks, [0b1001_1111, 0b0111_1110, 0b1111_1111, 0b1011_1101]);
        for set in InstructionSet::available() {
            let (found, found_masks) = results(set);
            assert_eq!(masks, found_masks, "{}", set.name());
            for (i, (x, y)) in plain.iter().zip(&found).enumerate() {
                let same = x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan();
                assert!(same, "{}: number {i}, {x} and {y}", set.name());
            }
        }
    }
}
