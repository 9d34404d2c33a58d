//! Moduli of the eigenvalues of a product of matrices, including small ones.
//!
//! The eigenvalues of the product as a single matrix M have the round-off of its largest entries, so that
//! much smaller eigenvalues are noise. Here the factors are applied one after the other to orthonormal
//! columns (simultaneous iteration),
//!
//! ```text
//! A_c Q_{c−1} = Q_c R_c,        Q_0ᵀ M Q_0 = W D U,    W = Q_0ᵀ Q_k,   D U = R_k … R_1
//! ```
//!
//! with D diagonal, stored as logarithms, and U unit upper triangular. Q_k is the Q_0 of the next sweep.
//! After some sweeps W is block triangular wherever moduli differ. The eigenvalues of each block are computed
//! separately, with a scale that prevents underflow.

use super::linalg::{eigenvalues, product};
use faer::Mat;

/// Largest number of sweeps. After so many sweeps, blocks are separate if their moduli differ by a third.
const MOST_SWEEPS: usize = 60;

/// Largest number of multiplications in all sweeps together. They take one or two seconds.
const MOST_WORK: f64 = 2e9;

/// Entry of W below which blocks count as separate. Such an entry changes eigenvalues by at most this
/// fraction.
const SPLIT: f64 = 1e-10;

/// A logarithm with its error. The error is infinite if the logarithm is unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logarithm {
    /// The logarithm.
    pub value: f64,
    /// Largest error by round-off.
    pub error: f64,
}

impl Logarithm {
    /// The logarithm of a modulus whose relative uncertainty is `noise`.
    pub fn blurred(modulus: f64, noise: f64) -> Self {
        Self {
            value: modulus.ln(),
            error: blur(noise),
        }
    }
}

/// Largest error of a logarithm whose argument has a relative error of `part`: infinite if that
/// is 1 or more, or NaN.
fn blur(part: f64) -> f64 {
    if part < 1.0 { -(-part).ln_1p() } else { f64::INFINITY }
}

/// Matrix entries below this size have lost digits to underflow.
const UNDERFLOW: f64 = 1e-290;

/// Round-off of the eigenvalues of a matrix, relative to a modulus.
pub fn round_off(matrix: &Mat<f64>, modulus: f64) -> f64 {
    matrix.nrows() as f64 * f64::EPSILON * (matrix.norm_max() + UNDERFLOW) / modulus
}

/// Logarithms of the moduli of the eigenvalues of the product `A_k … A_1`, the largest first. The factors are
/// in the order A_1 … A_k. Sweeps end when each of the first `wanted` logarithms has at most the error
/// `enough`, apart from round-off of the factors, or at a limit of work. `None` if a factor is singular, if a
/// single sweep exceeds this limit, or if no sweep gives eigenvalues.
pub fn logarithms(factors: &[Mat<f64>], wanted: usize, enough: f64) -> Option<Vec<Logarithm>> {
    let n = factors.first()?.nrows();
    let work = factors.len() as f64 * 4.0 * (n as f64).powi(3);
    let most = ((MOST_WORK / work) as usize).min(MOST_SWEEPS);
    let mut basis = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
    let mut found: Option<Vec<(Logarithm, f64)>> = None;
    for _ in 0..most {
        let sweep = Sweep::new(factors, basis)?;
        if let Some(now) = sweep.logarithms() {
            let done = now
                .iter()
                .take(wanted)
                .all(|(logarithm, _)| logarithm.error <= enough);
            found = Some(now);
            if done {
                break;
            }
        }
        basis = sweep.end;
    }
    let whole = |(logarithm, of_factors): (Logarithm, f64)| Logarithm {
        error: logarithm.error + of_factors,
        ..logarithm
    };
    found.map(|all| all.into_iter().map(whole).collect())
}

/// One application of the factors to orthonormal columns.
struct Sweep {
    end: Mat<f64>,
    /// `W = Q_0ᵀ Q_k`.
    rotation: Mat<f64>,
    /// `ln D`, column by column.
    lengths: Vec<f64>,
    /// U, unit upper triangular.
    upper: Mat<f64>,
    /// Contribution of round-off of the factors to the error of each of `lengths`.
    errors: Vec<f64>,
}

impl Sweep {
    /// Applies the factors. `None` if columns become dependent.
    fn new(factors: &[Mat<f64>], start: Mat<f64>) -> Option<Self> {
        let n = start.nrows();
        let mut end = start.clone();
        let mut lengths: Vec<f64> = vec![0.0; n];
        let mut errors = vec![0.0; n];
        let mut upper = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
        for factor in factors {
            end = product(factor.as_ref(), end.as_ref());
            let triangle = orthonormalise(&mut end)?;
            for i in 0..n {
                let row: Vec<f64> = (i..n)
                    .map(|l| triangle[(i, l)] / triangle[(i, i)] * (lengths[l] - lengths[i]).exp())
                    .collect();
                for j in i..n {
                    upper[(i, j)] = (i..=j).map(|l| row[l - i] * upper[(l, j)]).sum();
                }
            }
            for i in 0..n {
                lengths[i] += triangle[(i, i)].ln();
                errors[i] += blur(round_off(factor, triangle[(i, i)]));
            }
        }
        let rotation = product(start.transpose(), end.as_ref());
        Some(Self {
            end,
            rotation,
            lengths,
            upper,
            errors,
        })
    }

    /// Largest entry of W below and left of a position on the diagonal.
    fn coupling(&self, place: usize) -> f64 {
        let below = (place..self.lengths.len()).flat_map(|i| (0..place).map(move |j| (i, j)));
        below.map(|at| self.rotation[at].abs()).fold(0.0, f64::max)
    }

    /// The logarithms of all blocks, largest first, each with the contribution of round-off of the factors to its
    /// error. `None` if the eigenvalues of a block cannot be computed.
    fn logarithms(&self) -> Option<Vec<(Logarithm, f64)>> {
        let n = self.lengths.len();
        let mut all = Vec::with_capacity(n);
        let mut first = 0;
        for last in 1..=n {
            if self.coupling(last) <= SPLIT {
                self.block(first, last, &mut all)?;
                first = last;
            }
        }
        all.sort_by(|a: &(Logarithm, f64), b| b.0.value.total_cmp(&a.0.value));
        Some(all)
    }

    fn block(&self, first: usize, last: usize, all: &mut Vec<(Logarithm, f64)>) -> Option<()> {
        let lengths = self.lengths[first..last].iter().copied();
        let largest = lengths.fold(f64::NEG_INFINITY, f64::max);
        let scale = |i: usize| (self.lengths[i] - largest).exp();
        let block = Mat::from_fn(last - first, last - first, |i, j| {
            (first..=first + j)
                .map(|l| self.rotation[(first + i, l)] * scale(l) * self.upper[(l, first + j)])
                .sum::<f64>()
        });
        let of_factors = self.errors[first..last].iter().copied().fold(0.0, f64::max);
        let coupled = self.coupling(first).max(self.coupling(last));
        for value in eigenvalues(block.as_ref())? {
            let modulus = value.norm();
            let logarithm = Logarithm::blurred(modulus, round_off(&block, modulus) + coupled);
            let value = logarithm.value + largest;
            all.push((Logarithm { value, ..logarithm }, of_factors));
        }
        Some(())
    }
}

/// Orthonormalises columns by two passes of Gram–Schmidt, and returns the upper triangle R of the
/// factorisation. `None` if the columns are linearly dependent.
fn orthonormalise(columns: &mut Mat<f64>) -> Option<Mat<f64>> {
    let n = columns.nrows();
    let mut triangle = Mat::zeros(n, n);
    for j in 0..n {
        for _ in 0..2 {
            for i in 0..j {
                let along: f64 = (0..n).map(|k| columns[(k, i)] * columns[(k, j)]).sum();
                triangle[(i, j)] += along;
                for k in 0..n {
                    columns[(k, j)] -= along * columns[(k, i)];
                }
            }
        }
        let length = (0..n).map(|k| columns[(k, j)].powi(2)).sum::<f64>().sqrt();
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        triangle[(j, j)] = length;
        for k in 0..n {
            columns[(k, j)] /= length;
        }
    }
    Some(triangle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Stream;

    /// Factors `S_c T_c S_{c−1}⁻¹` around a cycle. S_c is orthogonal. T_c is upper triangular, except that two
    /// equal moduli form a scaled rotation. The eigenvalues of the product therefore have the powers of the given
    /// moduli with exponent `count`.
    fn factors(count: usize, moduli: &[f64]) -> Vec<Mat<f64>> {
        let n = moduli.len();
        let mut stream = Stream::new(5, 6, 7);
        let mut turned: Vec<Mat<f64>> = (0..count)
            .map(|_| {
                let mut columns = Mat::from_fn(n, n, |_, _| stream.normal());
                orthonormalise(&mut columns).unwrap();
                columns
            })
            .collect();
        turned.push(turned[0].clone());
        (0..count)
            .map(|c| {
                let mut own = Mat::from_fn(n, n, |i, j| {
                    if i < j { 0.3 * moduli[i] * stream.normal() } else { 0.0 }
                });
                for (i, modulus) in moduli.iter().enumerate() {
                    own[(i, i)] = *modulus;
                }
                for i in (0..n - 1).filter(|&i| moduli[i] == moduli[i + 1]) {
                    let (sine, cosine) = 0.7f64.sin_cos();
                    own[(i, i)] *= cosine;
                    own[(i + 1, i + 1)] *= cosine;
                    own[(i, i + 1)] = moduli[i] * sine;
                    own[(i + 1, i)] = -moduli[i] * sine;
                }
                let image = product(turned[c + 1].as_ref(), own.as_ref());
                product(image.as_ref(), turned[c].transpose())
            })
            .collect()
    }

    #[test]
    fn moduli_far_below_round_off_and_underflow_have_all_their_digits() {
        let moduli = [0.9, 0.9, 0.5, 0.1, 0.1, 0.01, 0.002];
        for count in [1, 20, 400] {
            let found = logarithms(&factors(count, &moduli), 7, 1e-8).unwrap();
            for (found, modulus) in found.iter().zip(moduli) {
                let off = (found.value - count as f64 * modulus.ln()).abs();
                assert!(off <= found.error, "{count}: {off:e} {found:?}");
                assert!(found.error < 1e-8, "{count}: {found:?}");
            }
        }
    }

    #[test]
    fn a_modulus_below_the_round_off_of_a_factor_is_not_known() {
        let found = logarithms(&factors(3, &[1.0, 0.5, 1e-17]), 3, 1e-8).unwrap();
        assert!(found[1].error < 1e-8, "{found:?}");
        assert_eq!(found[2].error, f64::INFINITY, "{found:?}");
        let none = [Mat::zeros(2, 2)];
        assert_eq!(logarithms(&none, 2, 1e-8), None);
    }
}
