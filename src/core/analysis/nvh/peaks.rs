//! How large do deflection and force become in each mesh cycle and over the record?
//!
//! The largest value of a record grows with the length of the record. The largest value of a mesh cycle has a
//! distribution, whose quantiles do not depend on the length. Few operations per window are needed: values at
//! the nodes of the rule, which other statistics also need, bound the extremes of a window. Only
//! windows that may contain the extreme of their cycle are searched.

use super::rule::{NodeValues, peaks};
use super::sample::Sample;
use crate::analysis::modal_series::{Series, TERMS};
use crate::numerics::statistics::quantile;

/// Shares of mesh cycles whose peaks do not exceed the quantiles.
pub(super) const PEAK_SHARES: [f64; 2] = [0.99, 0.999];

/// Tolerance for the round-off of a share times a count.
const ROUND_OFF: f64 = 1e-9;

/// Least possible values of −δ, δ and |F|, before any window.
const NOTHING: [f64; 3] = [f64::NEG_INFINITY, f64::NEG_INFINITY, 0.0];

/// The extremes of a mesh cycle or of a record.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extremes {
    /// Smallest deflection \[m\].
    pub(super) smallest: f64,
    /// Largest deflection \[m\].
    pub(super) largest: f64,
    /// Largest |force| \[N\].
    pub(super) force: f64,
}

impl Extremes {
    const NONE: Self = Self {
        smallest: f64::INFINITY,
        largest: f64::NEG_INFINITY,
        force: 0.0,
    };

    fn take(&mut self, other: &Self) {
        self.smallest = self.smallest.min(other.smallest);
        self.largest = self.largest.max(other.largest);
        self.force = self.force.max(other.force);
    }

    /// Largest distance of the deflection from its mean \[m\].
    pub(super) fn reach(&self, mean: f64) -> f64 {
        (self.largest - mean).max(mean - self.smallest)
    }
}

/// The largest value of a signal in the present cycle: a lower bound, and the one window that
/// may exceed it.
#[derive(Debug, Clone)]
struct Highest {
    /// A value that the signal reaches.
    least: f64,
    /// Upper bound of the waiting window; at most `least` if none waits.
    most: f64,
    /// The waiting window, and the node where its search begins.
    series: Series,
    place: f64,
}

impl Highest {
    fn new(least: f64) -> Self {
        Self {
            least,
            most: f64::NEG_INFINITY,
            series: [0.0; TERMS],
            place: 0.0,
        }
    }

    fn restart(&mut self, least: f64) {
        self.least = least;
        self.most = f64::NEG_INFINITY;
    }

    fn waits(&self) -> bool {
        self.most > self.least
    }

    /// Takes a window into account; `upwards` for its maximum, else for the negative of its minimum.
    fn offer(&mut self, at_nodes: &NodeValues<'_>, upwards: bool) {
        let range = at_nodes.range;
        let high = if upwards { range.high } else { -range.low };
        let most = high + range.rise;
        if most <= self.least {
            return;
        }
        self.least = self.least.max(high);
        if self.waits() {
            let found = peaks([&self.series; 4], [self.place; 4])[0];
            self.least = self.least.max(found);
        }
        self.most = most;
        if self.waits() {
            let sign = if upwards { 1.0 } else { -1.0 };
            self.series = at_nodes.series.map(|a| sign * a);
            self.place = at_nodes.start(sign * high);
        }
    }
}

/// Extremes by mesh cycle.
#[derive(Debug, Clone)]
pub(super) struct Peaks {
    /// Highest −δ, δ and |F| in the present cycle.
    present: [Highest; 3],
    cycles: Sample<Extremes>,
    record: Extremes,
}

impl Peaks {
    pub(super) fn new() -> Self {
        Self {
            present: NOTHING.map(Highest::new),
            cycles: Sample::new(),
            record: Extremes::NONE,
        }
    }

    pub(super) fn restart(&mut self) {
        self.begin();
        self.cycles.restart();
        self.record = Extremes::NONE;
    }

    /// Begins a cycle.
    fn begin(&mut self) {
        for (highest, least) in self.present.iter_mut().zip(NOTHING) {
            highest.restart(least);
        }
    }

    /// Adds a window, with the force of the mesh, if there is any.
    pub(super) fn window(&mut self, deflection: &NodeValues<'_>, force: Option<&NodeValues<'_>>) {
        let [lowest, highest, strongest] = &mut self.present;
        lowest.offer(deflection, false);
        highest.offer(deflection, true);
        if let Some(force) = force {
            // Contact damping can make the force negative before the release, so either sign may have the
            // larger modulus.
            strongest.offer(force, true);
            strongest.offer(force, false);
        }
    }

    /// Ends a mesh cycle.
    pub(super) fn advance(&mut self) {
        if self.present.iter().any(Highest::waits) {
            let [low, high, force] = &self.present;
            let all = [low, high, force, force];
            let found = peaks(
                all.map(|record| &record.series),
                all.map(|record| record.place),
            );
            for (highest, found) in self.present.iter_mut().zip(found) {
                if highest.waits() {
                    highest.least = highest.least.max(found);
                }
            }
        }
        let [lowest, largest, force] = self.present.each_ref().map(|highest| highest.least);
        let cycle = Extremes {
            smallest: -lowest,
            largest,
            force,
        };
        self.record.take(&cycle);
        self.cycles.push(cycle);
        self.begin();
    }

    /// Appends the record of another trajectory. The last cycles of both are complete.
    pub(super) fn append(&mut self, other: &Self) {
        self.cycles.append(&other.cycles);
        self.record.take(&other.record);
    }

    /// Keeps only the first `cycles`.
    pub(super) fn cut(&mut self, cycles: u64) {
        self.cycles.cut(cycles);
        if self.cycles.is_whole() {
            self.record = Extremes::NONE;
            (self.cycles.values().iter()).for_each(|cycle| self.record.take(cycle));
        }
    }

    /// The extremes over all complete cycles.
    pub(super) fn record(&self) -> Extremes {
        self.record
    }

    /// Quantiles of `peak` over mesh cycles at [`PEAK_SHARES`], and their standard errors; `None` before the
    /// end of a cycle.
    ///
    /// If the motion repeats after `repeats` cycles, the quantiles are those of one period, or of all kept cycles
    /// if some were dropped. A quantile is then the smallest peak that this share of the cycles does not exceed.
    /// Its error is zero.
    pub(super) fn quantiles(
        &self,
        repeats: Option<u32>,
        peak: impl Fn(&Extremes) -> f64,
    ) -> Option<[(f64, f64); 2]> {
        let mut values: Vec<f64> = self.cycles.values().iter().map(peak).collect();
        if values.is_empty() {
            return None;
        }
        let Some(period) = repeats else {
            let [first, second] = PEAK_SHARES.map(|share| {
                let (value, error) = quantile(&values, share)?;
                // In a short record, no cycle beyond the quantile is expected, and the value is only the largest peak.
                let is_observed = (1.0 - share) * values.len() as f64 >= 1.0 - ROUND_OFF;
                Some((value, if is_observed { error } else { f64::INFINITY }))
            });
            return Some([first?, second?]);
        };
        if self.cycles.is_whole() {
            values.drain(..values.len().saturating_sub(period as usize));
        }
        values.sort_by(f64::total_cmp);
        Some(PEAK_SHARES.map(|share| {
            let place = (share * values.len() as f64 - ROUND_OFF).ceil() as usize;
            (values[place.saturating_sub(1)], 0.0)
        }))
    }
}
