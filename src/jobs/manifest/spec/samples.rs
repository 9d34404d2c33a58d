//! How the values of axes are drawn from distributions, and the rows of the design.

use crate::manifest::distribution::Distribution;
use crate::numerics::random::Stream;
use serde::Serialize;
use sobol_burley::{NUM_DIMENSIONS, sample};
use strum::{EnumString, IntoStaticStr};

/// Largest number of samples of a sequence, a limit of the crate.
const MOST_SAMPLES: usize = 1 << 16;

/// The random stream of the scramble, distinct from those of points.
const STREAM: [u64; 2] = [u64::MAX, 0x736f_626f];

/// Half the spacing of the numbers of the sequence; the spacing is 2⁻²³.
const HALF_STEP: f64 = 1.0 / (1 << 24) as f64;

/// Axes whose values are drawn from distributions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Samples {
    /// Indices of the axes in [`Job::axes`](crate::manifest::Job::axes), ascending, each with its distribution.
    pub axes: Vec<(usize, Distribution)>,
    /// How samples become rows.
    pub design: Design,
    /// Number of samples of the sequence.
    pub count: usize,
}

/// How samples become rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, IntoStaticStr, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum Design {
    /// One row per sample.
    Sobol,
    /// For each sample a row of matrix A, the rows of A with one column from B, axis by axis, and the row of B:
    /// Saltelli et al., Computer Physics Communications 181 (2010) 259–270, in the order of SALib
    /// (`calc_second_order=False`).
    Saltelli,
}

impl Design {
    /// Name in manifests and result files.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Number of rows per sample of `axes` axes.
    pub fn rows_per_sample(self, axes: usize) -> usize {
        match self {
            Self::Sobol => 1,
            Self::Saltelli => axes + 2,
        }
    }

    /// Largest number of axes: a row of the sequence has 256 numbers.
    pub fn most_axes(self) -> usize {
        let most = NUM_DIMENSIONS as usize;
        match self {
            Self::Sobol => most,
            Self::Saltelli => most / 2,
        }
    }

    /// The numbers of each axis, all in (0, 1), over the rows of `count` samples, at most 65536. They come from a
    /// Sobol' sequence with an Owen scramble (Burley, J. Comput. Graph. Tech. 9 (2020) 4) that depends on the seed.
    pub(in crate::manifest) fn shares(self, axes: usize, count: usize, seed: u64) -> Vec<Vec<f64>> {
        debug_assert!(count <= MOST_SAMPLES && axes <= self.most_axes());
        let scramble = Stream::new(seed, STREAM[0], STREAM[1]).uniform() * f64::from(u32::MAX);
        let step = self.rows_per_sample(axes);
        let share = |axis: usize, row: usize| {
            let (index, place) = (row / step, row % step);
            let of_b = place == axis + 1 || place == axes + 1;
            let column = if of_b { axes + axis } else { axis };
            f64::from(sample(index as u32, column as u32, scramble as u32)) + HALF_STEP
        };
        (0..axes)
            .map(|axis| (0..count * step).map(|row| share(axis, row)).collect())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sobol_burley::parts::{sobol_rev, u32_to_f32_norm};

    /// The direction numbers of the crate are those of Joe & Kuo (new-joe-kuo-6.21201): the first points of their
    /// published sequence, in the order of whole numbers instead of Gray codes.
    #[test]
    fn the_sequence_is_the_published_one() {
        let points = [
            [0.0, 0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5, 0.5],
            [0.25, 0.75, 0.75, 0.75],
            [0.75, 0.25, 0.25, 0.25],
            [0.125, 0.625, 0.375, 0.125],
            [0.625, 0.125, 0.875, 0.625],
            [0.375, 0.375, 0.625, 0.875],
            [0.875, 0.875, 0.125, 0.375],
        ];
        for (index, point) in points.iter().enumerate() {
            for (axis, value) in point.iter().enumerate() {
                let bits = sobol_rev((index as u32).reverse_bits(), axis as u32).reverse_bits();
                assert_eq!(u32_to_f32_norm(bits), *value, "{index} {axis}");
            }
        }
    }

    /// Scrambled or not, 2^k points of the first two axes are a (0, k, 2)-net: every box of area 2^−k from halving the
    /// square contains one point.
    #[test]
    fn scrambled_points_are_a_net() {
        const K: u32 = 8;
        for seed in 0..20 {
            let shares = Design::Sobol.shares(2, 1 << K, seed);
            for first in 0..=K {
                let mut boxes = vec![0; 1 << K];
                for (x, y) in shares[0].iter().zip(&shares[1]) {
                    let [columns, rows] =
                        [first, K - first].map(|halvings| f64::from(1 << halvings));
                    boxes[((x * columns).floor() * rows + (y * rows).floor()) as usize] += 1;
                }
                assert!(boxes.iter().all(|points| *points == 1), "{seed} {first}");
            }
        }
    }

    #[test]
    fn seeds_scramble_and_samples_only_add_rows() {
        let few = Design::Sobol.shares(3, 10, 1);
        let more = Design::Sobol.shares(3, 20, 1);
        assert!(
            few.iter()
                .zip(&more)
                .all(|(few, more)| few[..] == more[..10])
        );
        assert_ne!(few, Design::Sobol.shares(3, 10, 2));
        let inside = |share: &f64| *share > 0.0 && *share < 1.0;
        let all = Design::Sobol.shares(1, MOST_SAMPLES, 3);
        assert!(all[0].iter().all(inside));
    }

    /// Row k (d + 2) + 1 + i is that of A except for column i, which is that of B.
    #[test]
    fn the_rows_of_saltelli_are_those_of_the_matrices() {
        let (d, count) = (3, 5);
        let both = Design::Sobol.shares(2 * d, count, 7);
        let rows = Design::Saltelli.shares(d, count, 7);
        for k in 0..count {
            for axis in 0..d {
                let [a, b] = [both[axis][k], both[d + axis][k]];
                let own: Vec<f64> = (0..d + 2)
                    .map(|place| rows[axis][k * (d + 2) + place])
                    .collect();
                let expected: Vec<f64> = (0..d + 2)
                    .map(|place| if place == axis + 1 || place == d + 1 { b } else { a })
                    .collect();
                assert_eq!(own, expected, "{k} {axis}");
            }
        }
    }

    /// The mean of √(x y) is 4/9; over scrambled nets the error falls faster than that of independent points.
    #[test]
    fn means_converge_faster_than_those_of_independent_points() {
        let error = |count: usize| {
            let square = (0..32).map(|seed| {
                let shares = Design::Sobol.shares(2, count, seed);
                let values = shares[0]
                    .iter()
                    .zip(&shares[1])
                    .map(|(x, y)| (x * y).sqrt());
                (values.sum::<f64>() / count as f64 - 4.0 / 9.0).powi(2)
            });
            (square.sum::<f64>() / 32.0).sqrt()
        };
        let [few, many] = [64, 4096].map(error);
        // The error of independent points would be 8 times smaller.
        assert!(many < few / 20.0, "{few} {many}");
        let independent = (1.0f64 / 4.0 - 16.0 / 81.0).sqrt() / 64.0;
        assert!(many < independent / 10.0, "{many} {independent}");
    }
}
