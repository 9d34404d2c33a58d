//! The spectral form of one structure and mesh: damped sinusoids and a slow group, the same at every speed.
//!
//! ```text
//! x = W y,   y = (u + iv of every wave, slow coordinates)
//! ```
//!
//! Fast eigenvalues of the blocks become waves `e^{(α + iν)t}`. Slow ones are mainly rigid rotations, whose
//! eigenvectors may be parallel, and are never diagonalised. Their invariant subspace is the orthogonal complement of
//! the fast left eigenvectors. Its generator is small and (nearly) nilpotent, so that its exponential is a polynomial.
//! Sylvester equations decouple waves from the slow group; they are scalar or 2 × 2 in these coordinates. Slow blocks
//! without an effect on the mesh stay exactly separate, so that even a large drift of these blocks does not change the
//! deflection.
//!
//! The structure and its mesh determine the slow group, independent of the speed and the excitation.
//! [`SpectralTable`](super::spectral_table::SpectralTable) adds the parts that depend on the speed.

use super::DenseError;
use super::conditioning::Conditioning;
use super::eigen::{eigen, follow, invert, refine};
use super::exponential;
use super::generator::Generator;
use super::matrix::{Operator, padded};
use super::rates::Rates;
use super::single::SingleOperator;
use crate::propagate::TableError;
use faer::Mat;
use num_complex::Complex64;

/// Largest product of a table's step and the fastest rate.
pub const REACH: f64 = 8.0;

/// Highest power of the slow group's polynomial: 0.5¹⁵/15! is 10⁻¹⁷.
pub const POWERS: usize = 14;

/// Unit of the velocities of rigid blocks, in units of the fastest rate.
const RIGID: f64 = 1.0 / 32.0;

/// The spectral form.
#[derive(Debug)]
pub struct Basis {
    /// y from x: rows of W⁻¹.
    pub inverse: Operator,
    /// x from y: W.
    pub matrix: Operator,
    /// `inverse` and `matrix` in single precision, if products with states use 32 bits.
    single: Option<[SingleOperator; 2]>,
    /// Number of waves; the remaining lanes are for the harmonics that a speed adds.
    pub waves: usize,
    /// α of the waves, in whole lane groups.
    pub alpha: Vec<f64>,
    /// ν of the waves, in whole lane groups.
    pub nu: Vec<f64>,
    /// Deflection in terms of u and v, in whole lane groups.
    pub gains: [Vec<f64>; 2],
    /// Deflection in terms of the slow coordinates.
    pub slow_gains: Vec<f64>,
    /// Generator of the slow group, row by row.
    pub slow_generator: Vec<f64>,
    pub conditioning: Conditioning,
}

impl Basis {
    /// The spectral form of a generator on a mesh segment; `touching`: whether the mesh couples the blocks.
    ///
    /// # Errors
    /// The eigenvectors are not a complete set, or are nearly parallel.
    pub fn new(
        generator: &Generator,
        rates: &Rates,
        segment: usize,
        touching: bool,
    ) -> Result<Self, DenseError> {
        let n = generator.layout().modes;
        let full = generator.matrix();
        // Powers of two scale the entries to similar sizes without rounding.
        let floor = RIGID * rates.fastest;
        let scale: Vec<f64> = (0..2 * n)
            .map(|i| {
                if i < n {
                    1.0
                } else {
                    (generator.frequency(i - n).max(floor).log2().round()).exp2()
                }
            })
            .collect();
        let a = Mat::from_fn(2 * n, 2 * n, |i, j| full[(i, j)] * scale[j] / scale[i]);

        let apart: Vec<usize> = (0..n)
            .filter(|&i| block_rate_bound(&a, n, i) < rates.slow && is_isolated(&a, n, i))
            .collect();
        let rest: Vec<usize> = (0..n).filter(|i| !apart.contains(i)).collect();
        let groups: Vec<Vec<usize>> = match touching {
            true if rest.is_empty() => Vec::new(),
            true => vec![rest.clone()],
            false => rest.iter().map(|&i| vec![i]).collect(),
        };
        let components_of = |blocks: &[usize]| -> Vec<usize> {
            blocks
                .iter()
                .copied()
                .chain(blocks.iter().map(|i| n + i))
                .collect()
        };
        let mut waves = Vec::new();
        let mut columns: Vec<[Vec<f64>; 2]> = Vec::new();
        let mut slow: Vec<Vec<f64>> = Vec::new();
        for group in &groups {
            let index = components_of(group);
            let part = Mat::from_fn(index.len(), index.len(), |i, j| a[(index[i], index[j])]);
            let mut eigenvectors = eigen(&part, rates.slow)?;
            refine(&part, &mut eigenvectors);
            let spread = |part: &Vec<f64>| {
                let mut whole = vec![0.0; 2 * n];
                for (&i, v) in index.iter().zip(part) {
                    whole[i] = *v;
                }
                whole
            };
            waves.extend(eigenvectors.waves);
            columns.extend(
                eigenvectors
                    .columns
                    .iter()
                    .map(|c| [spread(&c[0]), spread(&c[1])]),
            );
            slow.extend(eigenvectors.slow.iter().map(spread));
        }
        let Some((inner, condition)) = invert(&components_of(&rest), &columns, &slow) else {
            return Err(TableError::Defective {
                condition: f64::INFINITY,
                error: f64::INFINITY,
            }
            .into());
        };
        follow(&a, &apart, &waves, &mut columns);
        let form = Form::assemble(
            generator,
            &BasisParts {
                a,
                scale,
                apart,
                rest,
                waves,
                columns,
                slow,
                inner,
            },
        );
        let duration = REACH / rates.fastest;
        let propagator = exponential::propagator(generator, rates.fastest, duration);
        let conditioning = Conditioning {
            segment,
            touching,
            condition,
            reconstruction: form.reconstruction(&propagator, duration, n, rates.fastest),
        };
        conditioning.check()?;
        let lanes = form.alpha.len();
        let gain = |j: usize| -> f64 {
            (0..2 * n)
                .map(|i| generator.deflection[i] * form.matrix[(i, j)])
                .sum()
        };
        let m = form.slow_generator.nrows();
        Ok(Self {
            inverse: Operator::new(form.inverse.as_ref()),
            matrix: Operator::new(form.matrix.as_ref()),
            single: None,
            waves: form.waves,
            gains: [0, lanes].map(|from| (from..from + lanes).map(gain).collect()),
            slow_gains: (2 * lanes..2 * lanes + m).map(gain).collect(),
            slow_generator: (0..m * m)
                .map(|i| form.slow_generator[(i / m, i % m)])
                .collect(),
            alpha: form.alpha,
            nu: form.nu,
            conditioning,
        })
    }

    /// The same basis with products in single precision, for states of `size` components.
    pub fn in_single_precision(mut self, size: usize) -> Self {
        let length = self.length();
        let round = |operator: &Operator, rows, columns| {
            let entry = |i, j| operator.entry(i, j);
            SingleOperator::new(Mat::from_fn(rows, columns, entry).as_ref())
        };
        self.single = Some([
            round(&self.inverse, length, size),
            round(&self.matrix, size, length),
        ]);
        self
    }

    /// Takes a state to spectral coordinates.
    pub fn to_spectral(&self, x: &[f64], y: &mut [f64]) {
        match &self.single {
            Some([inverse, _]) => inverse.apply(x, y),
            None => self.inverse.apply(x, y),
        }
    }

    /// Takes spectral coordinates back to a state.
    pub fn to_state(&self, y: &[f64], x: &mut [f64]) {
        match &self.single {
            Some([_, matrix]) => matrix.apply(y, x),
            None => self.matrix.apply(y, x),
        }
    }

    /// Number of slow coordinates.
    pub fn slow(&self) -> usize {
        self.slow_gains.len()
    }

    /// Number of spectral coordinates.
    pub fn length(&self) -> usize {
        2 * self.alpha.len() + self.slow()
    }
}

/// The spectral form as matrices.
struct Form {
    inverse: Mat<f64>,
    matrix: Mat<f64>,
    waves: usize,
    alpha: Vec<f64>,
    nu: Vec<f64>,
    slow_generator: Mat<f64>,
}

impl Form {
    fn assemble(generator: &Generator, parts: &BasisParts) -> Self {
        let n = generator.layout().modes;
        let harmonics = generator.frequencies.len();
        let count = parts.waves.len();
        let lanes = padded(count + harmonics);
        let unit_vectors: Vec<Vec<f64>> = (parts.apart.iter().copied())
            .chain(parts.apart.iter().map(|i| n + i))
            .map(|i| (0..2 * n).map(|j| f64::from(u8::from(i == j))).collect())
            .collect();
        let slow: Vec<&Vec<f64>> = parts.slow.iter().chain(&unit_vectors).collect();
        let m = slow.len();
        let length = 2 * lanes + m;

        // Maps from waves and slow coordinates to scaled blocks, and back.
        let mut forward = Mat::<f64>::zeros(2 * n, length);
        for (j, pair) in parts.columns.iter().enumerate() {
            for i in 0..2 * n {
                forward[(i, j)] = pair[0][i];
                forward[(i, lanes + j)] = pair[1][i];
            }
        }
        for (j, column) in slow.iter().enumerate() {
            for i in 0..2 * n {
                forward[(i, 2 * lanes + j)] = column[i];
            }
        }
        let mut back = Mat::<f64>::zeros(length, 2 * n);
        let place = |row: usize| match row {
            row if row < 2 * count => (row % 2) * lanes + row / 2,
            row => 2 * lanes + row - 2 * count,
        };
        let rest: Vec<usize> = (parts.rest.iter().copied())
            .chain(parts.rest.iter().map(|i| n + i))
            .collect();
        for row in 0..parts.inner.nrows() {
            for (j, &column) in rest.iter().enumerate() {
                back[(place(row), column)] = parts.inner[(row, j)];
            }
        }
        // Subtract the contributions of the waves to the separate blocks.
        for (k, column) in unit_vectors.iter().enumerate() {
            let block = (0..2 * n).find(|&i| column[i] != 0.0).unwrap_or(0);
            let row = 2 * lanes + parts.slow.len() + k;
            back[(row, block)] = 1.0;
            for &j in &rest {
                let brought: f64 = (0..count)
                    .map(|w| {
                        let pair = &parts.columns[w];
                        pair[0][block] * back[(w, j)] + pair[1][block] * back[(lanes + w, j)]
                    })
                    .sum();
                back[(row, j)] = -brought;
            }
        }

        let rows: Vec<usize> = (2 * lanes..2 * lanes + m).collect();
        let product = &parts.a * &forward;
        let generator_slow = {
            let mut g = Mat::<f64>::zeros(m, m);
            for (i, &row) in rows.iter().enumerate() {
                for (j, &column) in rows.iter().enumerate() {
                    g[(i, j)] = (0..2 * n)
                        .map(|k| back[(row, k)] * product[(k, column)])
                        .sum();
                }
            }
            g
        };
        let rates = |value: fn(&Complex64) -> f64| {
            let mut all: Vec<f64> = parts.waves.iter().map(value).collect();
            all.resize(lanes, 0.0);
            all
        };
        Self {
            inverse: Mat::from_fn(length, 2 * n, |j, i| back[(j, i)] / parts.scale[i]),
            matrix: Mat::from_fn(2 * n, length, |i, j| parts.scale[i] * forward[(i, j)]),
            waves: count,
            alpha: rates(|wave| wave.re),
            nu: rates(|wave| wave.im),
            slow_generator: generator_slow,
        }
    }

    /// `e^{Gt}` of the slow group.
    fn slow_exponential(&self, time: f64) -> Mat<f64> {
        let size = self.slow_generator.nrows();
        let identity = Mat::<f64>::identity(size, size);
        let mut sum = identity.clone();
        for k in (1..=POWERS).rev() {
            sum = &identity + &self.slow_generator * &sum * faer::Scale(time / k as f64);
        }
        sum
    }

    /// Largest error of `W e^{…Δ} W⁻¹` against the propagator, relative to its largest entry, for the blocks only, with
    /// velocities in units of `rate`.
    fn reconstruction(&self, propagator: &Mat<f64>, duration: f64, modes: usize, rate: f64) -> f64 {
        let lanes = self.alpha.len();
        let slow = self.slow_exponential(duration);
        let size = slow.nrows();
        let mut propagated = self.inverse.clone();
        for j in 0..propagated.ncols() {
            for w in 0..lanes {
                let (sin, cos) = (self.nu[w] * duration).sin_cos();
                let size = (self.alpha[w] * duration).exp();
                let (u, v) = (self.inverse[(w, j)], self.inverse[(lanes + w, j)]);
                propagated[(w, j)] = size * (cos * u - sin * v);
                propagated[(lanes + w, j)] = size * (sin * u + cos * v);
            }
            for i in 0..size {
                propagated[(2 * lanes + i, j)] = (0..size)
                    .map(|k| slow[(i, k)] * self.inverse[(2 * lanes + k, j)])
                    .sum();
            }
        }
        let rebuilt = &self.matrix * &propagated;
        let unit = |i: usize| if i < modes { 1.0 } else { rate };
        let (mut error, mut size) = (0.0f64, 0.0f64);
        for i in 0..2 * modes {
            for j in 0..2 * modes {
                let scale = unit(j) / unit(i);
                let difference = (rebuilt[(i, j)] - propagator[(i, j)]).abs() * scale;
                // NaN must not count as a small error, as it would with `max`.
                if difference.is_nan() {
                    return f64::NAN;
                }
                error = error.max(difference);
                size = size.max(propagator[(i, j)].abs() * scale);
            }
        }
        error / size
    }
}

/// The parts of a basis, in scaled coordinates.
struct BasisParts {
    a: Mat<f64>,
    scale: Vec<f64>,
    /// Slow blocks without an effect on other blocks.
    apart: Vec<usize>,
    rest: Vec<usize>,
    waves: Vec<Complex64>,
    columns: Vec<[Vec<f64>; 2]>,
    slow: Vec<Vec<f64>>,
    /// Inverse of the basis over the blocks `rest`: rows u₀, v₀, u₁, … and the slow ones.
    inner: Mat<f64>,
}

/// Bound of the eigenvalues of block `i` alone \[1/s\].
fn block_rate_bound(a: &Mat<f64>, n: usize, i: usize) -> f64 {
    let det = a[(i, i)] * a[(n + i, n + i)] - a[(i, n + i)] * a[(n + i, i)];
    det.abs().sqrt() + (a[(i, i)] + a[(n + i, n + i)]).abs()
}

/// Whether block `i` has no effect on the other blocks.
fn is_isolated(a: &Mat<f64>, n: usize, i: usize) -> bool {
    let is_of_block = |row: usize| row == i || row == n + i;
    (0..2 * n).all(|row| is_of_block(row) || (a[(row, i)] == 0.0 && a[(row, n + i)] == 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three blocks; the second has no effect on the others.
    #[test]
    fn blocks_are_unfelt_where_no_other_has_them() {
        let n = 3;
        let mut a = Mat::<f64>::zeros(2 * n, 2 * n);
        for (block, frequency) in [3.0, 0.5, 4.0].into_iter().enumerate() {
            a[(block, n + block)] = 1.0;
            a[(n + block, block)] = -frequency * frequency;
            a[(n + block, n + block)] = -0.2 * frequency;
            let bound = block_rate_bound(&a, n, block);
            assert!(bound >= frequency && bound < 1.3 * frequency, "{bound}");
        }
        // The other blocks affect the second block and one another.
        for (row, column) in [(1, 0), (4, 2), (1, 5), (3, 2), (5, 0), (0, 2), (2, 3)] {
            a[(row, column)] = 0.3;
        }
        assert_eq!(
            [0, 1, 2].map(|block| is_isolated(&a, n, block)),
            [false, true, false]
        );
        for (row, column) in [(0, 1), (5, 1), (2, 4), (3, 4)] {
            let mut felt = a.clone();
            felt[(row, column)] = 1e-300;
            assert!(!is_isolated(&felt, n, 1), "{row} {column}");
        }
    }
}
