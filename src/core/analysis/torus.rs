//! Is a motion that does not repeat on a torus?
//!
//! Weighted Birkhoff averages (Das, Saiki, Sander & Yorke, *Nonlinearity* 30, 4111, 2017) converge
//! faster than any power of the number of cycles on a torus, and like `n^-1/2` in chaos. Only the second
//! half of a record is used. The growth of neighbours must average to zero over this half and over each of
//! its two parts. The deflection must have the same average in both parts. None of 40 000 records of chaotic
//! motion met both conditions; growth alone would let one record in some thousands pass.

use crate::model::Model;
use crate::numerics::birkhoff;
use crate::numerics::statistics::mean;

use super::norm::EnergyNorm;
use super::recurrence::excitation_period;

/// Largest average growth \[1/cycle\] over the second half of a record.
const NEUTRAL: f64 = 1e-4;

/// Largest average growth \[1/cycle\] over either part of that half.
const PARTS_NEUTRAL: f64 = 1e-3;

/// Largest difference of the averages of the deflection in the two parts, in standard deviations of the
/// deflection.
const STEADY: f64 = 1e-3;

/// Maximum number of closed curves of a torus. The trajectory visits the curves in turn.
const MOST_CURVES: usize = 32;

/// Distance \[1/cycle\] from a multiple of 1/q within which a frequency equals this multiple.
const LOCKING_DISTANCE: f64 = 1e-6;

/// Shortest record with a verdict \[cycles\].
pub const SHORTEST: u64 = 2_000;

/// Properties of a motion on a torus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Torus {
    /// Largest exponent \[1/cycle\], which is zero within its error.
    pub lambda: f64,
    /// The larger of `|lambda|` and the difference of its averages over the two parts \[1/cycle\].
    pub error: f64,
    /// Frequency of the strongest line of the strobe deflection that is not a simple multiple of the mesh
    /// frequency \[1/cycle\].
    pub rotation: Option<f64>,
}

/// The torus from a record of growth and strobe deflection in every cycle, if the motion is on one.
pub fn torus(growth: &[f64], strobe: &[f64]) -> Option<Torus> {
    let cycles = growth.len().min(strobe.len());
    if (cycles as u64) < SHORTEST {
        return None;
    }
    let half = cycles / 2;
    let parts = |series: &[f64]| {
        let late = &series[cycles - half..cycles];
        let (early, late) = late.split_at(half / 2);
        [birkhoff::mean(early), birkhoff::mean(late)]
    };
    let lambda = birkhoff::mean(&growth[cycles - half..cycles]);
    let [early, late] = parts(growth);
    let [before, after] = parts(strobe);
    let deflection = &strobe[cycles - half..cycles];
    let neutral = lambda.abs() < NEUTRAL
        && early.abs() < PARTS_NEUTRAL
        && late.abs() < PARTS_NEUTRAL
        && (before - after).abs() < STEADY * deviation(deflection);
    neutral.then(|| Torus {
        lambda,
        error: lambda.abs().max((early - late).abs()),
        rotation: rotation(deflection),
    })
}

/// Frequency \[1/cycle\] of the strongest line of a strobe series that is not a multiple of 1/q of the mesh
/// frequency. If the strongest line is at such a multiple, the torus has q closed curves. The mean over each
/// curve, that is, over every q-th value, is then subtracted before the search.
fn rotation(strobe: &[f64]) -> Option<f64> {
    let frequency = birkhoff::frequency(strobe)?;
    let near_whole = |q: &usize| {
        let turns = frequency * *q as f64;
        (turns - turns.round()).abs() < LOCKING_DISTANCE * *q as f64
    };
    let Some(curves) = (1..=MOST_CURVES).find(near_whole) else {
        return Some(frequency);
    };
    let means: Vec<f64> = (0..curves)
        .map(|first| {
            let values: Vec<f64> = strobe.iter().skip(first).step_by(curves).copied().collect();
            birkhoff::mean(&values)
        })
        .collect();
    let rest = strobe.iter().zip(means.iter().cycle());
    birkhoff::frequency(&rest.map(|(value, mean)| value - mean).collect::<Vec<_>>())
}

/// Whether a model can have an invariant torus. A map of the plane that contracts areas has none, because the
/// area inside an invariant curve would have to stay constant.
pub fn is_possible(model: &Model, norm: &EnergyNorm) -> bool {
    let plane = norm.dimension() <= 2 && excitation_period(model).is_some();
    let contracts = model.blocks.iter().any(|block| block.growth() < 0.0);
    !(plane && contracts)
}

fn deviation(values: &[f64]) -> f64 {
    let centre = mean(values);
    let square: f64 = values.iter().map(|v| (v - centre).powi(2)).sum();
    (square / values.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::Stream;
    use std::f64::consts::TAU;

    /// Growth and deflection of a quasi-periodic motion with an exponent.
    fn record(cycles: usize, lambda: f64) -> [Vec<f64>; 2] {
        let angle = |n: usize| TAU * 0.618_033_988_749_895 * n as f64;
        [
            (0..cycles).map(|n| lambda + 0.3 * angle(n).cos()).collect(),
            (0..cycles)
                .map(|n| 1e-5 * (angle(n).sin() + 0.2 * (2.0 * angle(n)).cos()))
                .collect(),
        ]
    }

    #[test]
    fn quasi_periodic_motion_is_a_torus_with_its_frequency() {
        let [growth, strobe] = record(2_000, 0.0);
        let found = torus(&growth, &strobe).unwrap();
        assert!(found.lambda.abs() < 1e-9 && found.error < 1e-6, "{found:?}");
        let folded = 1.0 - 0.618_033_988_749_895;
        assert!((found.rotation.unwrap() - folded).abs() < 1e-9, "{found:?}");
    }

    /// A torus of five closed curves: a period of five mesh cycles, and a slow turn about its points.
    #[test]
    fn a_torus_of_several_curves_has_the_frequency_along_them() {
        let turn = 0.012_345_678_9;
        let angle = |n: usize| TAU * turn * n as f64;
        let strobe: Vec<f64> = (0..4_000)
            .map(|n| [3.0, 1.0, -2.0, 0.5, -1.0][n % 5] + 0.1 * angle(n).sin())
            .collect();
        let growth = vec![0.0; 4_000];
        let found = torus(&growth, &strobe).unwrap().rotation.unwrap();
        assert!((found - turn).abs() < 1e-8, "{found}");
    }

    #[test]
    fn weak_chaos_weak_decay_and_short_records_are_none() {
        for lambda in [2e-4, -2e-4] {
            let [growth, strobe] = record(4_000, lambda);
            assert_eq!(torus(&growth, &strobe), None);
        }
        let [growth, strobe] = record(1_999, 0.0);
        assert_eq!(torus(&growth, &strobe), None);
    }

    /// Noise about zero sometimes passes the test of growth, and almost never the test of the deflection.
    #[test]
    fn noise_is_no_torus() {
        for seed in 0..200 {
            let mut stream = Stream::new(seed, 1, 2);
            let growth: Vec<f64> = (0..4_000).map(|_| 0.5 * stream.normal()).collect();
            let strobe: Vec<f64> = (0..4_000).map(|_| stream.normal()).collect();
            assert_eq!(torus(&growth, &strobe), None, "{seed}");
        }
    }
}
