//! Propagators `e^{LΔ}` by Taylor series and squaring, and bounds of a row along them.
//!
//! Squaring works on `P = e^{Lh} − I`, `e^{2Lh} − I = 2P + P²`, so that a short step keeps its relative accuracy.
//! Squaring the exponential itself would add the round-off of the 1 at every level.

use super::generator::Generator;
use faer::{Mat, MatRef};

/// Largest product of rate and step for the Taylor series.
const SERIES_REACH: f64 = 0.25;

/// Terms of the series: 0.25¹⁵/15! is 10⁻²¹.
const TERMS: usize = 14;

/// `e^{LΔ} − I` for Δ = `duration` · 2⁻ᵐ, m = 0 … `levels`; `rate` bounds the rates of L.
pub fn levels(generator: &Generator, rate: f64, duration: f64, levels: usize) -> Vec<Mat<f64>> {
    let matrix = generator.matrix();
    let halvings = (rate * duration / SERIES_REACH).log2().ceil().max(0.0) as usize;
    let deepest = levels.max(halvings);
    let step = duration / 2f64.powi(deepest as i32);
    let small = &matrix * faer::Scale(step);
    // Horner: P = A (I + A/2 (I + A/3 (…))).
    let d = matrix.nrows();
    let identity = Mat::<f64>::identity(d, d);
    let mut inner = identity.clone();
    for k in (2..=TERMS).rev() {
        inner = &identity + &small * &inner * faer::Scale(1.0 / k as f64);
    }
    let mut all = vec![&small * &inner];
    for _ in 0..deepest {
        let p = &all[all.len() - 1];
        all.push(p * faer::Scale(2.0) + p * p);
    }
    all.reverse();
    all.truncate(levels + 1);
    all
}

/// `I + P`.
pub fn plus_one(mut p: Mat<f64>) -> Mat<f64> {
    for i in 0..p.nrows() {
        p[(i, i)] += 1.0;
    }
    p
}

/// `e^{LΔ} − I`.
pub fn increment(generator: &Generator, rate: f64, duration: f64) -> Mat<f64> {
    levels(generator, rate, duration, 0).swap_remove(0)
}

/// `A B − I` from `a` = A − I and `b` = B − I: consecutive short steps keep their relative accuracy.
pub fn after(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    a + b + a * b
}

/// `e^{LΔ}`.
pub fn propagator(generator: &Generator, rate: f64, duration: f64) -> Mat<f64> {
    plus_one(increment(generator, rate, duration))
}

/// Largest product of rate and length of a step of a bound; below, its number of terms.
const BOUND_REACH: f64 = 0.25;
const BOUND_TERMS: usize = 12;

/// Allowance for rounding in a bound.
const SLACK: f64 = 1.0 + 1e-9;

/// Raises `bound`, entry by entry, to an upper bound of `|row e^{Lt} through|` for all t in \[0, `duration`\].
pub fn bound_row(
    generator: &Generator,
    rate: f64,
    duration: f64,
    row: &[f64],
    through: Option<MatRef<'_, f64>>,
    bound: &mut [f64],
) {
    let stretch_count = (rate * duration / BOUND_REACH).ceil().max(1.0);
    let step = duration / stretch_count;
    let mut start = row.to_vec();
    let (mut term, mut next) = (vec![0.0; row.len()], vec![0.0; row.len()]);
    for _ in 0..stretch_count as usize {
        term.copy_from_slice(&start);
        let mut size = vec![0.0; row.len()];
        add_sizes(&term, through, &mut size);
        for k in 1..=BOUND_TERMS {
            generator.apply_to_row(&term, &mut next);
            for v in &mut next {
                *v *= step / k as f64;
            }
            std::mem::swap(&mut term, &mut next);
            for (start, v) in start.iter_mut().zip(&term) {
                *start += v;
            }
            add_sizes(&term, through, &mut size);
        }
        for (bound, size) in bound.iter_mut().zip(&size) {
            *bound = bound.max(SLACK * size);
        }
    }
}

/// Adds the absolute values of the entries of `row · through`.
fn add_sizes(row: &[f64], through: Option<MatRef<'_, f64>>, sizes: &mut [f64]) {
    match through {
        None => {
            for (size, v) in sizes.iter_mut().zip(row) {
                *size += v.abs();
            }
        }
        Some(map) => {
            for (j, size) in sizes.iter_mut().enumerate().take(map.ncols()) {
                let column = map.col(j).iter().zip(row);
                *size += column.map(|(m, r)| m * r).sum::<f64>().abs();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fixtures;
    use crate::model::{Model, OperatingPoint};

    /// At 131 times of the motion of a strongly damped mode, no entry exceeds its bound, and no bound is far from the
    /// largest entry. This includes the transmission error, which rotates eight times as fast.
    #[test]
    fn a_bound_lies_close_above_the_row() {
        let (frequency, damping) = (3000.0, 0.3);
        let structure = fixtures::structure(&[frequency], damping, &[1.0], &[1.0]);
        let point = OperatingPoint {
            load: 0.1,
            speed: 1200.0,
        };
        let model = Model::new(&structure, &fixtures::two_level_mesh(1e-5), point).unwrap();
        let generator = Generator::new(&model, &model.contacts[0].cycle(0).segments[0], false);
        let duration = 3.25 / frequency;
        let row: Vec<f64> = (generator.deflection.iter())
            .zip(generator.curvature())
            .map(|(own, bent)| own + 0.3 * bent / (frequency * frequency))
            .collect();
        let mut bound = vec![0.0; row.len()];
        bound_row(
            &generator,
            8.0 * frequency,
            duration,
            &row,
            None,
            &mut bound,
        );
        let size = generator.layout().dimension();
        let mut largest = vec![0.0_f64; size];
        for step in 0..=130 {
            let matrix = propagator(&generator, frequency, duration * f64::from(step) / 130.0);
            for (column, largest) in largest.iter_mut().enumerate() {
                let sum: f64 = (row[..size].iter().enumerate())
                    .map(|(i, r)| r * matrix[(i, column)])
                    .sum();
                *largest = largest.max(sum.abs());
            }
        }
        for (bound, largest) in bound.iter().zip(&largest) {
            assert!(
                largest <= bound && *bound <= 1.4 * largest,
                "{bound} {largest}"
            );
        }
    }
}
