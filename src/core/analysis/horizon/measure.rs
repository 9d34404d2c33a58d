//! Spreads, decays and crossings from series along a trajectory.

use super::HorizonMeasure;
use crate::numerics::statistics::{FEWEST_VALUES, deviation, mean, standard_error};

/// Smallest number of cycles per average at which spreads follow a power law. Shorter averages are
/// correlated.
const POWER_LAW_FROM: u64 = 10;

/// Numbers of cycles 1, 2, 5, 10, 20, 50, … up to and including `longest`.
pub(super) fn ladder(longest: u64) -> Vec<u64> {
    let mut rungs = Vec::new();
    let mut power = 1;
    while power <= longest {
        rungs.extend([power, 2 * power, 5 * power]);
        power *= 10;
    }
    rungs.retain(|n| *n < longest);
    rungs.push(longest);
    rungs
}

/// Mean of a series, and standard deviation of its averages over successive stretches of n values.
pub(super) fn spread(values: &[f64], n: usize) -> (f64, f64) {
    let averages: Vec<f64> = values.chunks_exact(n).map(mean).collect();
    (mean(&averages), deviation(&averages))
}

/// Geometric mean, from logarithms.
pub(super) fn mean_logarithms(logarithms: &[f64]) -> f64 {
    mean(logarithms).exp()
}

/// Slope of `ln spread` over `ln cycles`, by least squares. The weights are the numbers of samples minus 1,
/// because the variance of `ln spread` is about `1/(2 (samples − 1))`. `None` from fewer than three lengths.
pub(super) fn decay<'m>(measures: impl Iterator<Item = &'m HorizonMeasure>) -> Option<f64> {
    let points: Vec<[f64; 3]> = measures
        .filter(|m| m.cycles >= POWER_LAW_FROM && m.samples > 2 && m.spread > 0.0)
        .map(|m| {
            [
                (m.samples - 1) as f64,
                (m.cycles as f64).ln(),
                m.spread.ln(),
            ]
        })
        .collect();
    if points.len() < 3 {
        return None;
    }
    let total: f64 = points.iter().map(|[w, _, _]| w).sum();
    let x0 = points.iter().map(|[w, x, _]| w * x).sum::<f64>() / total;
    let y0 = points.iter().map(|[w, _, y]| w * y).sum::<f64>() / total;
    let up: f64 = points.iter().map(|[w, x, y]| w * (x - x0) * (y - y0)).sum();
    let across: f64 = points.iter().map(|[w, x, _]| w * (x - x0).powi(2)).sum();
    Some(up / across)
}

/// Where the mean of some curves first reaches a level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// Position of the crossing in steps of the curves; `None` if the mean stays below the level.
    pub place: Option<f64>,
    /// Standard error of the position by the jackknife. If there are enough pseudo-values, it is at least
    /// that from their block averages, because successive curves are correlated. `None` if the mean without
    /// one of the curves stays below the level.
    pub stderr: Option<f64>,
}

impl Crossing {
    /// The crossing of two or more curves of equal length.
    pub(super) fn of(curves: &[Vec<f64>], level: f64) -> Self {
        let steps = curves.iter().map(Vec::len).min().unwrap_or(0);
        let sums: Vec<f64> = (0..steps)
            .map(|n| curves.iter().map(|c| c[n]).sum())
            .collect();
        let count = curves.len() as f64;
        let whole: Vec<f64> = sums.iter().map(|s| s / count).collect();
        let without: Option<Vec<f64>> = (curves.iter())
            .map(|curve| {
                let others = sums.iter().zip(curve).map(|(s, c)| (s - c) / (count - 1.0));
                first_reached(&others.collect::<Vec<_>>(), level)
            })
            .collect();
        let place = first_reached(&whole, level);
        let stderr = without.filter(|w| w.len() > 1).map(|without| {
            let centre = mean(&without);
            let square: f64 = without.iter().map(|h| (h - centre).powi(2)).sum();
            let independent = ((count - 1.0) / count * square).sqrt();
            let values: Vec<f64> = (without.iter())
                .map(|without| count * centre - (count - 1.0) * without)
                .collect();
            if values.len() >= FEWEST_VALUES {
                standard_error(&values).max(independent)
            } else {
                independent
            }
        });
        Self {
            place,
            stderr: place.and(stderr),
        }
    }
}

/// Where a curve first reaches a level, linear between its points.
fn first_reached(curve: &[f64], level: f64) -> Option<f64> {
    let n = curve.iter().position(|value| *value >= level)?;
    let Some(before) = n.checked_sub(1) else {
        return Some(0.0);
    };
    Some(before as f64 + (level - curve[before]) / (curve[n] - curve[before]))
}
