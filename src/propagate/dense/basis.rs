//! The spectral form of one generator: damped sinusoids, harmonics and a slow group.
//!
//! ```text
//! z = W y,   y = (u + iv of every wave, slow coordinates, 1, s)
//! ```
//!
//! Fast eigenvalues of the blocks become waves `e^{(α + iν)t}`; so do the carried harmonics.
//! Slow ones, rigid rotations first of all, whose eigenvectors may be parallel, are never
//! diagonalised: their invariant subspace is the orthogonal complement of the fast left
//! eigenvectors, and its generator together with the constant inputs is small and (nearly)
//! nilpotent, so that its exponential is a polynomial. Waves are decoupled from the carried
//! inputs and from the slow group by Sylvester equations, which are scalar or 2 × 2 in these
//! coordinates. Blocks that the mesh does not feel and that turn slowly stay exactly apart, so
//! that however far they have drifted nothing of them leaks into the deflection.

use super::DenseError;
use super::eigen::{eigen, follow, invert, refine};
use super::generator::Generator;
use super::matrix::padded;
use crate::numerics::linalg;
use faer::Mat;
use num_complex::{Complex64, c64};

/// Eigenvalues below this over a mesh period are slow: splitting the constant input off a wave
/// of rate λ loses a factor (λT)⁻² of accuracy.
const SLOW: f64 = 0.5;

/// Highest power of the slow group's polynomial: 0.5¹⁵/15! is 10⁻¹⁷.
pub const POWERS: usize = 14;

/// Smallest relative distance of an eigenvalue from a carried harmonic.
const RESONANCE: f64 = 1e-7;

/// The spectral form.
#[derive(Debug)]
pub struct Basis {
    /// y from z: rows of W⁻¹.
    pub inverse: Mat<f64>,
    /// z from y: W.
    pub matrix: Mat<f64>,
    /// α of the waves, in whole lane groups.
    pub alpha: Vec<f64>,
    /// ν of the waves, in whole lane groups.
    pub nu: Vec<f64>,
    /// Slow coordinates m; 1 and s follow them.
    pub slow: usize,
    /// Gᵏ/k! of the slow group with its constants, k = 0 … [`POWERS`] or as far as they go.
    pub powers: Vec<Mat<f64>>,
    /// Condition number of the eigenvector basis of the blocks, in scaled coordinates.
    pub condition: f64,
}

impl Basis {
    /// The spectral form of a generator; `period`: the mesh period \[s\]; `touching`: whether
    /// the mesh couples the blocks.
    ///
    /// # Errors
    /// No complete set of eigenvectors, or an undamped mode in resonance with a harmonic. How
    /// good the basis is, [`reconstruction`](Self::reconstruction) says.
    pub fn new(generator: &Generator, period: f64, touching: bool) -> Result<Self, DenseError> {
        let layout = generator.layout();
        let (n, d) = (layout.modes, layout.dimension());
        let full = generator.matrix();
        // Powers of two make the entries alike and rounding what it was.
        let floor = std::f64::consts::TAU / period;
        let scale: Vec<f64> = (0..2 * n)
            .map(|i| match i < n {
                true => 1.0,
                false => (generator.frequency(i - n).max(floor).log2().round()).exp2(),
            })
            .collect();
        let a = Mat::from_fn(2 * n, 2 * n, |i, j| full[(i, j)] * scale[j] / scale[i]);
        let inputs = Mat::from_fn(2 * n, d - 2 * n, |i, j| full[(i, 2 * n + j)] / scale[i]);

        let apart: Vec<usize> = (0..n)
            .filter(|&i| own_rate(&a, n, i) * period < SLOW && unfelt(&a, n, i))
            .collect();
        let rest: Vec<usize> = (0..n).filter(|i| !apart.contains(i)).collect();
        let groups: Vec<Vec<usize>> = match touching {
            true if rest.is_empty() => Vec::new(),
            true => vec![rest.clone()],
            false => rest.iter().map(|&i| vec![i]).collect(),
        };
        let both = |blocks: &[usize]| -> Vec<usize> {
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
            let index = both(group);
            let part = Mat::from_fn(index.len(), index.len(), |i, j| a[(index[i], index[j])]);
            let mut found = eigen(&part, SLOW / period)?;
            refine(&part, &mut found);
            let spread = |part: &Vec<f64>| {
                let mut whole = vec![0.0; 2 * n];
                for (&i, v) in index.iter().zip(part) {
                    whole[i] = *v;
                }
                whole
            };
            waves.extend(found.waves);
            columns.extend(found.columns.iter().map(|c| [spread(&c[0]), spread(&c[1])]));
            slow.extend(found.slow.iter().map(spread));
        }
        let Some((inner, condition)) = invert(&both(&rest), &columns, &slow) else {
            return Err(DenseError::Defective {
                condition: f64::INFINITY,
                error: f64::INFINITY,
            });
        };
        follow(&a, &apart, &waves, &mut columns);
        Self::assemble(
            generator,
            &Parts {
                a,
                inputs,
                scale,
                apart,
                rest,
                waves,
                columns,
                slow,
                inner,
                condition,
            },
        )
    }

    fn assemble(generator: &Generator, parts: &Parts) -> Result<Self, DenseError> {
        let layout = generator.layout();
        let (n, d) = (layout.modes, layout.dimension());
        let harmonics = generator.frequencies.len();
        let count = parts.waves.len();
        let lanes = padded(count + harmonics);
        let own: Vec<Vec<f64>> = (parts.apart.iter().copied())
            .chain(parts.apart.iter().map(|i| n + i))
            .map(|i| (0..2 * n).map(|j| f64::from(u8::from(i == j))).collect())
            .collect();
        let slow: Vec<&Vec<f64>> = parts.slow.iter().chain(&own).collect();
        let m = slow.len();
        let (one, side, length) = (2 * lanes + m, 2 * lanes + m + 1, 2 * lanes + m + 2);

        // Scaled blocks from waves and slow coordinates, and back.
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
        // What the waves bring to the blocks apart is taken off them.
        for (k, column) in own.iter().enumerate() {
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

        // The steady response to every carried input, column by column.
        let felt = &back * &parts.inputs;
        let rows: Vec<usize> = (2 * lanes..2 * lanes + m).collect();
        let turned = &parts.a * &forward;
        let generator_slow = {
            let mut g = Mat::<f64>::zeros(m, m);
            for (i, &row) in rows.iter().enumerate() {
                for (j, &column) in rows.iter().enumerate() {
                    g[(i, j)] = (0..2 * n)
                        .map(|k| back[(row, k)] * turned[(k, column)])
                        .sum();
                }
            }
            g
        };
        let mut steady = Mat::<f64>::zeros(length, d - 2 * n);
        for (w, &lambda) in parts.waves.iter().enumerate() {
            let force = |j: usize| c64(felt[(w, j)], felt[(lanes + w, j)]);
            let mut put = |j: usize, value: Complex64| {
                steady[(w, j)] = value.re;
                steady[(lanes + w, j)] = value.im;
            };
            for j in 0..2 {
                put(j, -(force(j) / lambda));
            }
            for (h, &omega) in generator.frequencies.iter().enumerate() {
                let (c, s) = (force(2 + 2 * h), force(3 + 2 * h));
                let apart = lambda * lambda + Complex64::from(omega * omega);
                let size = lambda.norm_sqr() + omega * omega;
                if apart.norm() < RESONANCE * size {
                    return Err(DenseError::Resonance { frequency: omega });
                }
                put(2 + 2 * h, -(lambda * c + s * omega) / apart);
                put(3 + 2 * h, (c * omega - lambda * s) / apart);
            }
        }
        for (h, &omega) in generator.frequencies.iter().enumerate() {
            let column = |j: usize| -> Vec<f64> { rows.iter().map(|&r| felt[(r, j)]).collect() };
            let (c, s) = (column(2 + 2 * h), column(3 + 2 * h));
            let times = |x: &[f64]| -> Vec<f64> {
                (0..m)
                    .map(|i| (0..m).map(|j| generator_slow[(i, j)] * x[j]).sum())
                    .collect()
            };
            let mut square = &generator_slow * &generator_slow;
            for i in 0..m {
                square[(i, i)] += omega * omega;
            }
            if m > 0 {
                let (ac, as_) = (times(&c), times(&s));
                let first: Vec<f64> = (0..m).map(|i| -(ac[i] + omega * s[i])).collect();
                let second: Vec<f64> = (0..m).map(|i| omega * c[i] - as_[i]).collect();
                let (first, second) = (
                    linalg::solve(square.as_ref(), &first),
                    linalg::solve(square.as_ref(), &second),
                );
                for (i, &row) in rows.iter().enumerate() {
                    steady[(row, 2 + 2 * h)] = first[i];
                    steady[(row, 3 + 2 * h)] = second[i];
                }
            }
        }

        let carried = |j: usize| match j {
            0 => one,
            1 => side,
            j => ((j % 2) * lanes) + count + (j - 2) / 2,
        };
        let mut matrix = Mat::<f64>::zeros(d, length);
        let mut inverse = Mat::<f64>::zeros(length, d);
        let response = &forward * &steady;
        for i in 0..2 * n {
            for j in 0..length {
                matrix[(i, j)] = parts.scale[i] * forward[(i, j)];
                inverse[(j, i)] = back[(j, i)] / parts.scale[i];
            }
            for j in 0..d - 2 * n {
                matrix[(i, carried(j))] += parts.scale[i] * response[(i, j)];
            }
        }
        for j in 0..d - 2 * n {
            for row in 0..length {
                inverse[(row, 2 * n + j)] -= steady[(row, j)];
            }
            matrix[(2 * n + j, carried(j))] = 1.0;
            inverse[(carried(j), 2 * n + j)] += 1.0;
        }

        let mut g = Mat::<f64>::zeros(m + 2, m + 2);
        for (i, &row) in rows.iter().enumerate() {
            for j in 0..m {
                g[(i, j)] = generator_slow[(i, j)];
            }
            for j in 0..2 {
                g[(i, m + j)] = felt[(row, j)];
            }
        }
        let mut powers = vec![Mat::<f64>::identity(m + 2, m + 2)];
        for k in 1..=POWERS {
            let power = &g * &powers[k - 1] * faer::Scale(1.0 / k as f64);
            // A nilpotent group's series ends early.
            if power.norm_max() == 0.0 {
                break;
            }
            powers.push(power);
        }
        let rates = |value: fn(&Complex64) -> f64, harmonic: fn(&f64) -> f64| {
            let own = parts.waves.iter().map(value);
            let mut all: Vec<f64> = own
                .chain(generator.frequencies.iter().map(harmonic))
                .collect();
            all.resize(lanes, 0.0);
            all
        };
        Ok(Self {
            inverse,
            matrix,
            alpha: rates(|wave| wave.re, |_| 0.0),
            nu: rates(|wave| wave.im, |frequency| *frequency),
            slow: m,
            powers,
            condition: parts.condition,
        })
    }

    /// `e^{Gt}` of the slow group with its constants.
    pub fn slow_exponential(&self, time: f64) -> Mat<f64> {
        let size = self.slow + 2;
        let mut sum = Mat::zeros(size, size);
        for power in self.powers.iter().rev() {
            sum = sum * faer::Scale(time) + power;
        }
        sum
    }

    /// Largest error of `W e^{…Δ} W⁻¹` against the propagator, relative to its largest entry,
    /// blocks only, velocities measured by `rate`.
    pub fn reconstruction(
        &self,
        propagator: &Mat<f64>,
        duration: f64,
        modes: usize,
        rate: f64,
    ) -> f64 {
        let lanes = self.alpha.len();
        let slow = self.slow_exponential(duration);
        let mut moved = self.inverse.clone();
        for j in 0..moved.ncols() {
            for w in 0..lanes {
                let (sin, cos) = (self.nu[w] * duration).sin_cos();
                let size = (self.alpha[w] * duration).exp();
                let (u, v) = (self.inverse[(w, j)], self.inverse[(lanes + w, j)]);
                moved[(w, j)] = size * (cos * u - sin * v);
                moved[(lanes + w, j)] = size * (sin * u + cos * v);
            }
            for i in 0..self.slow + 2 {
                moved[(2 * lanes + i, j)] = (0..self.slow + 2)
                    .map(|k| slow[(i, k)] * self.inverse[(2 * lanes + k, j)])
                    .sum();
            }
        }
        let rebuilt = &self.matrix * &moved;
        let unit = |i: usize| if i < modes { 1.0 } else { rate };
        let (mut error, mut size) = (0.0f64, 0.0f64);
        for i in 0..2 * modes {
            for j in 0..2 * modes {
                let scale = unit(j) / unit(i);
                let off = (rebuilt[(i, j)] - propagator[(i, j)]).abs() * scale;
                // What is no number is no small error either, as `max` would have it.
                if off.is_nan() {
                    return f64::NAN;
                }
                error = error.max(off);
                size = size.max(propagator[(i, j)].abs() * scale);
            }
        }
        error / size
    }
}

/// What a basis is assembled from, in scaled coordinates.
struct Parts {
    a: Mat<f64>,
    /// Inputs of the carried entries.
    inputs: Mat<f64>,
    scale: Vec<f64>,
    /// Slow blocks that nothing feels.
    apart: Vec<usize>,
    rest: Vec<usize>,
    waves: Vec<Complex64>,
    columns: Vec<[Vec<f64>; 2]>,
    slow: Vec<Vec<f64>>,
    /// Inverse of the basis of the rest: rows u₀, v₀, u₁, … and the slow ones.
    inner: Mat<f64>,
    condition: f64,
}

/// Bound of the eigenvalues of block `i` by itself \[1/s\].
fn own_rate(a: &Mat<f64>, n: usize, i: usize) -> f64 {
    let det = a[(i, i)] * a[(n + i, n + i)] - a[(i, n + i)] * a[(n + i, i)];
    det.abs().sqrt() + (a[(i, i)] + a[(n + i, n + i)]).abs()
}

/// Whether no other block feels block `i`.
fn unfelt(a: &Mat<f64>, n: usize, i: usize) -> bool {
    let own = |row: usize| row == i || row == n + i;
    (0..2 * n).all(|row| own(row) || (a[(row, i)] == 0.0 && a[(row, n + i)] == 0.0))
}
