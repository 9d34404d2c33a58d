//! The results of one item of the plan over all rounds.

use super::error::MeasurementError;
use super::figure::{Kind, figure, median};
use super::measured::{Measured, Work};
use crate::store::{Figure, Measurement};

/// The results of all rounds of an item.
#[derive(Debug, Default)]
pub struct Sample {
    /// Times of a unit of work, by figure and round \[s\].
    pub figures: Vec<Vec<Vec<f64>>>,
    /// Ratios of the rate to that of one thread in all rounds, for every team except the first.
    pub gains: Vec<Vec<f64>>,
    /// Bytes of one table; 0 without tables.
    pub bytes: usize,
    /// Work of a mesh cycle, if kernels integrate.
    pub work: Work,
    /// Why threads could not be bound; `None` if they were.
    pub unbound: Option<String>,
    /// The error that ended the measurement.
    pub error: Option<MeasurementError>,
}

impl Sample {
    /// Adds one more round.
    pub fn take(&mut self, round: Result<Measured, MeasurementError>) {
        let measured = match round {
            Ok(measured) => measured,
            Err(error) => {
                self.error = Some(error);
                return;
            }
        };
        self.figures.resize(measured.times.len(), Vec::new());
        for (rounds, times) in self.figures.iter_mut().zip(measured.times) {
            rounds.push(times);
        }
        self.gains.resize(measured.gains.len(), Vec::new());
        for (all, gains) in self.gains.iter_mut().zip(measured.gains) {
            all.extend(gains);
        }
        self.bytes = measured.bytes;
        self.work = measured.work;
        self.unbound = self.unbound.take().or(measured.unbound);
    }

    /// A figure of the item; `None` if there was no time for it.
    pub fn figure(&self, index: usize, kind: Kind) -> Option<Figure> {
        figure(self.figures.get(index)?, kind)
    }

    /// Median ratio of the rate of a team to that of one thread; 1 for the first team.
    pub fn gain(&self, team: usize) -> f64 {
        let gains = team.checked_sub(1).and_then(|i| self.gains.get(i));
        gains.map_or(1.0, |gains| median(&mut gains.clone()))
    }

    /// A figure of the item with its key; `None` if there was no time for it.
    pub fn measurement<K>(&self, index: usize, kind: Kind, key: K) -> Option<Measurement<K>> {
        let figure = self.figure(index, kind)?;
        Some(Measurement { key, figure })
    }
}

/// Relative distance of the median repetition of a round from its best one: the median over all rounds and figures.
/// `None` without repetitions.
pub fn scatter(samples: &[Sample]) -> Option<f64> {
    let mut behind: Vec<f64> = (samples.iter())
        .flat_map(|sample| sample.figures.iter().flatten())
        .filter(|times| times.len() > 1)
        .map(|times| {
            let best = times.iter().copied().fold(f64::INFINITY, f64::min);
            median(&mut times.clone()) / best - 1.0
        })
        .collect();
    (!behind.is_empty()).then(|| median(&mut behind))
}
