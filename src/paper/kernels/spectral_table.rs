//! A basis at one speed: the steady responses to excitation, the deflection in its coordinates, and the factors that
//! advance these over a cell.
//!
//! ```text
//! y = W⁻¹ x − S c,   x = W (y + S c),   c = (f, s b, cos θ₁, sin θ₁, …)
//! ```
//!
//! S contains the steady responses to the carried entries c. Those of waves to a harmonic ω are scalars, `(λ² + ω²)⁻¹`
//! times the product of W⁻¹ with the input; those of the slow group follow from a small system. A late wave has |λ|
//! below half a radian per mesh cycle at this speed. It is advanced with the slow group: splitting a constant input off
//! it would lose accuracy.

use super::DenseError;
use super::basis::{Basis, POWERS};
use super::generator::Generator;
use super::matrix::{Operator, padded};
use super::rates::SLOW;
use super::waves;
use crate::numerics::linalg;
use crate::propagate::TableError;
use faer::Mat;
use num_complex::{Complex64, c64};
use std::sync::Arc;

/// Smallest relative distance of an eigenvalue from a carried harmonic.
const RESONANCE: f64 = 1e-7;

/// Whether an eigenvalue \[1/s\] belongs to an undamped mode with the frequency of a harmonic \[rad/s\].
fn in_resonance(lambda: Complex64, omega: f64) -> bool {
    let denominator = lambda * lambda + Complex64::from(omega * omega);
    denominator.norm() < RESONANCE * (lambda.norm_sqr() + omega * omega)
}

/// A basis with the data for one speed.
#[derive(Debug)]
pub struct SpectralTable {
    basis: Arc<Basis>,
    /// −S: the contribution of the carried entries c to spectral coordinates.
    steady: Operator,
    /// W S: their contribution to the state.
    response: Operator,
    /// Number 2N of components of x, and number of carried entries after them.
    states: usize,
    carried: usize,
    /// Waves that are advanced with the slow group.
    late: Vec<usize>,
    /// Rates of the waves and of the harmonics after them.
    pub alpha: Vec<f64>,
    pub nu: Vec<f64>,
    /// |λ| of the waves.
    pub sizes: Vec<f64>,
    /// Growth rate of the fastest growing wave \[1/s\], which exists only with friction; 0 without one.
    pub growth: f64,
    /// Deflection in terms of u and v; zero for waves that are advanced with the slow group.
    pub gains: [Vec<f64>; 2],
    /// Deflection of the slow group, row k times the k-th power of time; each row has `slow` entries.
    pub polynomial: Vec<f64>,
    /// Number of coordinates advanced with the slow group: its own, (u, v) of the late waves, f and s b.
    pub slow: usize,
    /// Gᵏ/k! for the generator G of the slow group, row by row.
    powers: Vec<Vec<f64>>,
    /// δ'' as a row over z.
    pub curvature: Vec<f64>,
    /// Factors over the whole cell.
    pub whole: Factors,
}

/// Factors that advance spectral coordinates over a time.
#[derive(Debug, Clone)]
pub struct Factors {
    pub time: f64,
    /// `e^{αt} cos νt` of each wave, then of each harmonic.
    cosine: Vec<f64>,
    /// `e^{αt} sin νt` of the same.
    sine: Vec<f64>,
    /// `e^{Gt}`, row by row.
    slow: Vec<f64>,
}

impl Factors {
    pub fn new(lanes: usize, slow: usize) -> Self {
        Self {
            time: f64::NAN,
            cosine: vec![0.0; lanes],
            sine: vec![0.0; lanes],
            slow: vec![0.0; slow * slow],
        }
    }
}

/// Spectral coordinates of a state.
#[derive(Debug)]
pub struct Coordinates {
    /// u, v and the coordinates of the slow group, in whole lane groups.
    pub y: Vec<f64>,
    /// The slow group with its late waves and constants.
    pub slow: Vec<f64>,
    carried: Vec<f64>,
    spare: Vec<f64>,
}

impl Coordinates {
    /// Room for any of these tables.
    pub fn new<'a>(tables: impl Iterator<Item = &'a SpectralTable> + Clone) -> Self {
        let most = |size: fn(&SpectralTable) -> usize| tables.clone().map(size).max();
        let room = |size| vec![0.0; most(size).unwrap_or(0)];
        Self {
            y: room(|table| padded(table.basis.length())),
            slow: room(|table| table.slow),
            carried: room(|table| table.carried),
            spare: room(|table| table.slow),
        }
    }
}

/// Products of W⁻¹ with the inputs of the carried entries, and the steady responses to them.
struct Excitation {
    input_products: Mat<f64>,
    steady: Mat<f64>,
}

impl Excitation {
    fn new(basis: &Basis, generator: &Generator, late: &[usize]) -> Result<Self, DenseError> {
        let layout = generator.layout();
        let (states, carried) = (2 * layout.modes, layout.dimension() - 2 * layout.modes);
        let (lanes, m, length) = (basis.alpha.len(), basis.slow(), basis.length());
        let mut input_products = Mat::<f64>::zeros(length, carried);
        let (mut unit, mut input) = (vec![0.0; layout.padded()], vec![0.0; layout.padded()]);
        let mut column = vec![0.0; padded(length)];
        for j in 0..carried {
            unit[states + j] = 1.0;
            generator.apply(&unit, &mut input);
            unit[states + j] = 0.0;
            basis.inverse.apply(&input[..states], &mut column);
            for i in 0..length {
                input_products[(i, j)] = column[i];
            }
        }
        let mut steady = Mat::<f64>::zeros(length, carried);
        for w in 0..basis.waves {
            let lambda = c64(basis.alpha[w], basis.nu[w]);
            let force = |j: usize| c64(input_products[(w, j)], input_products[(lanes + w, j)]);
            let mut put = |j: usize, value: Complex64| {
                steady[(w, j)] = value.re;
                steady[(lanes + w, j)] = value.im;
            };
            if !late.contains(&w) {
                for j in 0..2 {
                    put(j, -(force(j) / lambda));
                }
            }
            for (h, &omega) in generator.frequencies.iter().enumerate() {
                let (c, s) = (force(2 + 2 * h), force(3 + 2 * h));
                let denominator = lambda * lambda + Complex64::from(omega * omega);
                if in_resonance(lambda, omega) {
                    return Err(TableError::Resonance { frequency: omega }.into());
                }
                put(2 + 2 * h, -(lambda * c + s * omega) / denominator);
                put(3 + 2 * h, (c * omega - lambda * s) / denominator);
            }
        }
        let g = |i: usize, j: usize| basis.slow_generator[i * m + j];
        let slow = linalg::eigenvalues(Mat::from_fn(m, m, g).as_ref()).unwrap_or_default();
        for (h, &omega) in generator.frequencies.iter().enumerate() {
            if m == 0 {
                break;
            }
            if slow.iter().any(|lambda| in_resonance(*lambda, omega)) {
                return Err(TableError::Resonance { frequency: omega }.into());
            }
            let column = |j: usize| -> Vec<f64> {
                (0..m).map(|i| input_products[(2 * lanes + i, j)]).collect()
            };
            let (c, s) = (column(2 + 2 * h), column(3 + 2 * h));
            let times = |x: &[f64]| -> Vec<f64> {
                (0..m)
                    .map(|i| (0..m).map(|j| g(i, j) * x[j]).sum())
                    .collect()
            };
            let square = Mat::from_fn(m, m, |i, j| {
                let product: f64 = (0..m).map(|k| g(i, k) * g(k, j)).sum();
                product + if i == j { omega * omega } else { 0.0 }
            });
            let (ac, as_) = (times(&c), times(&s));
            let first: Vec<f64> = (0..m).map(|i| -(ac[i] + omega * s[i])).collect();
            let second: Vec<f64> = (0..m).map(|i| omega * c[i] - as_[i]).collect();
            let solved = [first, second].map(|side| linalg::solve(square.as_ref(), &side));
            for i in 0..m {
                steady[(2 * lanes + i, 2 + 2 * h)] = solved[0][i];
                steady[(2 * lanes + i, 3 + 2 * h)] = solved[1][i];
            }
        }
        Ok(Self {
            input_products,
            steady,
        })
    }

    /// W S.
    fn response(&self, basis: &Basis, states: usize) -> Mat<f64> {
        let length = basis.length();
        let mut response = Mat::<f64>::zeros(states, self.steady.ncols());
        let mut row = vec![0.0; padded(states)];
        for j in 0..self.steady.ncols() {
            let column: Vec<f64> = (0..length).map(|i| self.steady[(i, j)]).collect();
            basis.matrix.apply(&column, &mut row);
            for i in 0..states {
                response[(i, j)] = row[i];
            }
        }
        response
    }
}

impl SpectralTable {
    /// A basis at the speed of a generator's harmonics, for cells of a length \[s\] in a mesh period \[s\].
    ///
    /// # Errors
    /// An undamped mode is in resonance with a harmonic.
    pub fn new(
        basis: Arc<Basis>,
        generator: &Generator,
        duration: f64,
        period: f64,
    ) -> Result<Self, DenseError> {
        let layout = generator.layout();
        let (states, carried) = (2 * layout.modes, layout.dimension() - 2 * layout.modes);
        let lanes = basis.alpha.len();
        let late: Vec<usize> = (0..basis.waves)
            .filter(|&w| basis.alpha[w].hypot(basis.nu[w]) * period < SLOW)
            .collect();
        let excitation = Excitation::new(&basis, generator, &late)?;
        let response = excitation.response(&basis, states);
        let gain = |j: usize| -> f64 {
            let sum: f64 = (0..states)
                .map(|i| generator.deflection[i] * response[(i, j)])
                .sum();
            generator.deflection[states + j] + sum
        };
        let (mut nu, mut gains) = (basis.nu.clone(), basis.gains.clone());
        let mut slow_row = basis.slow_gains.clone();
        for &w in &late {
            slow_row.extend(gains.each_mut().map(|gain| std::mem::take(&mut gain[w])));
        }
        slow_row.extend([gain(0), gain(1)]);
        for (h, frequency) in generator.frequencies.iter().enumerate() {
            nu[basis.waves + h] = *frequency;
            gains[0][basis.waves + h] = gain(2 + 2 * h);
            gains[1][basis.waves + h] = gain(3 + 2 * h);
        }
        let powers = powers(&slow_generator(&basis, &excitation.input_products, &late));
        let steady = Mat::from_fn(basis.length(), carried, |i, j| -excitation.steady[(i, j)]);
        let rates = basis.alpha.iter().zip(&nu);
        let sizes = rates.map(|(a, n)| a.hypot(*n)).collect();
        let slow = slow_row.len();
        let mut table = Self {
            steady: Operator::new(steady.as_ref()),
            response: Operator::new(response.as_ref()),
            states,
            carried,
            sizes,
            growth: basis.alpha.iter().fold(0.0, |most: f64, a| most.max(*a)),
            alpha: basis.alpha.clone(),
            nu,
            gains,
            polynomial: polynomial(&slow_row, &powers),
            slow,
            powers,
            late,
            curvature: generator.curvature(),
            whole: Factors::new(lanes, slow),
            basis,
        };
        let mut whole = table.whole.clone();
        table.prepare(duration, &mut whole);
        table.whole = whole;
        Ok(table)
    }

    /// The operators that depend on the speed.
    pub fn operators(&self) -> [&Operator; 2] {
        [&self.steady, &self.response]
    }

    /// Transforms a state, or a tangent vector, to spectral coordinates.
    pub fn to_spectral(&self, z: &[f64], at: &mut Coordinates) {
        let lanes = self.alpha.len();
        let slow_count = self.basis.slow();
        let excitation = &z[self.states..self.states + self.carried];
        self.basis.to_spectral(&z[..self.states], &mut at.y);
        self.steady.apply_more(excitation, &mut at.y);
        for (h, pair) in excitation[2..].chunks_exact(2).enumerate() {
            at.y[self.basis.waves + h] = pair[0];
            at.y[lanes + self.basis.waves + h] = pair[1];
        }
        at.slow[..slow_count].copy_from_slice(&at.y[2 * lanes..2 * lanes + slow_count]);
        for (pair, &w) in at.slow[slow_count..].chunks_exact_mut(2).zip(&self.late) {
            pair.copy_from_slice(&[at.y[w], at.y[lanes + w]]);
        }
        at.slow[self.slow - 2..self.slow].copy_from_slice(&excitation[..2]);
    }

    /// Factors over a time.
    pub fn prepare(&self, time: f64, factors: &mut Factors) {
        let lanes = self.alpha.len();
        waves::factors(
            [&self.alpha, &self.nu],
            time,
            &mut factors.cosine[..lanes],
            &mut factors.sine[..lanes],
        );
        let entries = self.slow * self.slow;
        factors.slow[..entries].fill(0.0);
        for power in self.powers.iter().rev() {
            for (entry, p) in factors.slow[..entries].iter_mut().zip(power) {
                *entry = *entry * time + p;
            }
        }
        factors.time = time;
    }

    /// Advances spectral coordinates in place.
    pub fn advance(&self, factors: &Factors, at: &mut Coordinates) {
        let lanes = self.alpha.len();
        let slow_count = self.basis.slow();
        let (u, rest) = at.y.split_at_mut(lanes);
        let (v, rest) = rest.split_at_mut(lanes);
        waves::turn([&factors.cosine[..lanes], &factors.sine[..lanes]], u, v);
        let rows = factors.slow[..self.slow * self.slow].chunks_exact(self.slow);
        let old = &at.slow[..self.slow];
        for (new, row) in at.spare.iter_mut().zip(rows) {
            *new = row.iter().zip(old).map(|(g, x)| g * x).sum();
        }
        rest[..slow_count].copy_from_slice(&at.spare[..slow_count]);
        for (pair, &w) in at.spare[slow_count..].chunks_exact(2).zip(&self.late) {
            (u[w], v[w]) = (pair[0], pair[1]);
        }
    }

    /// Transforms spectral coordinates back to a state.
    pub fn to_state(&self, at: &mut Coordinates, z: &mut [f64]) {
        let lanes = self.alpha.len();
        let excitation = &mut at.carried[..self.carried];
        excitation[..2].copy_from_slice(&at.slow[self.slow - 2..self.slow]);
        for (h, pair) in excitation[2..].chunks_exact_mut(2).enumerate() {
            let place = self.basis.waves + h;
            pair.copy_from_slice(&[at.y[place], at.y[lanes + place]]);
        }
        self.basis.to_state(&at.y, z);
        self.response.apply_more(excitation, z);
        z[self.states..self.states + self.carried].copy_from_slice(excitation);
    }
}

/// The generator of the slow group with its late waves and constants.
fn slow_generator(basis: &Basis, input_products: &Mat<f64>, late: &[usize]) -> Mat<f64> {
    let (lanes, slow_count) = (basis.alpha.len(), basis.slow());
    let size = slow_count + 2 * late.len() + 2;
    let mut g = Mat::<f64>::zeros(size, size);
    let mut drive = |row: usize, place: usize| {
        for j in 0..2 {
            g[(row, size - 2 + j)] = input_products[(place, j)];
        }
    };
    for row in 0..slow_count {
        drive(row, 2 * lanes + row);
    }
    for (k, &w) in late.iter().enumerate() {
        drive(slow_count + 2 * k, w);
        drive(slow_count + 2 * k + 1, lanes + w);
    }
    for i in 0..slow_count {
        for j in 0..slow_count {
            g[(i, j)] = basis.slow_generator[i * slow_count + j];
        }
    }
    for (k, &w) in late.iter().enumerate() {
        let at = slow_count + 2 * k;
        let (alpha, nu) = (basis.alpha[w], basis.nu[w]);
        (g[(at, at)], g[(at, at + 1)]) = (alpha, -nu);
        (g[(at + 1, at)], g[(at + 1, at + 1)]) = (nu, alpha);
    }
    g
}

/// Gᵏ/k!, k = 0 … [`POWERS`] or until they vanish, row by row.
fn powers(g: &Mat<f64>) -> Vec<Vec<f64>> {
    let size = g.nrows();
    let flat = |power: &Mat<f64>| -> Vec<f64> {
        let entries = 0..size * size;
        entries.map(|i| power[(i / size, i % size)]).collect()
    };
    let mut power = Mat::<f64>::identity(size, size);
    let mut all = vec![flat(&power)];
    for k in 1..=POWERS {
        power = g * &power * faer::Scale(1.0 / k as f64);
        // The series of a nilpotent generator ends early.
        if power.norm_max() == 0.0 {
            break;
        }
        all.push(flat(&power));
    }
    all
}

/// The products of a row that gives the deflection with every power, without the zero rows at the end.
fn polynomial(row: &[f64], powers: &[Vec<f64>]) -> Vec<f64> {
    let size = row.len();
    let rows_seen = powers.iter().map(|power| -> Vec<f64> {
        let entry = |j: usize| (0..size).map(|i| row[i] * power[i * size + j]).sum();
        (0..size).map(entry).collect()
    });
    let mut rows: Vec<Vec<f64>> = rows_seen.collect();
    while rows.len() > 1 && rows.last().is_some_and(|row| row.iter().all(|p| *p == 0.0)) {
        rows.pop();
    }
    rows.concat()
}

/// The deflection of a stretch in closed form.
pub(super) struct Guard<'t> {
    pub table: &'t SpectralTable,
    pub amplitudes: [&'t [f64]; 2],
    pub polynomial: [f64; POWERS + 1],
    /// Powers of time in use.
    pub terms: usize,
}

impl Guard<'_> {
    /// δ, δ', δ'' at a time.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let table = self.table;
        let [a, b, c] = waves::sum([&table.alpha, &table.nu], self.amplitudes, time);
        let [mut value, mut slope, mut half_curvature] = [0.0; 3];
        for q in self.polynomial[..self.terms].iter().rev() {
            half_curvature = half_curvature * time + slope;
            slope = slope * time + value;
            value = value * time + q;
        }
        [a + value, b + slope, c + 2.0 * half_curvature]
    }

    /// Bounds of the polynomial's first three derivatives up to a time.
    pub fn bounds(&self, time: f64) -> [f64; 3] {
        let mut bounds = [0.0; 3];
        for (order, bound) in bounds.iter_mut().enumerate() {
            for k in (order + 1..self.terms).rev() {
                let falling: usize = (k - order..=k).product();
                *bound = *bound * time + falling as f64 * self.polynomial[k].abs();
            }
        }
        bounds
    }
}
