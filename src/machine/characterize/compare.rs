//! Do two runs of `atlas machine` agree, figure by figure, within their stated spreads? How fast does a
//! machine integrate a job?

use super::plan::POINTS;
use crate::store::{Characteristics, Figure, Measurement, SolverKey};
use serde::Serialize;
use std::collections::BTreeMap;

/// One figure of two runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pair {
    /// Name of the measurement.
    pub what: String,
    /// The first run's value.
    pub a: f64,
    /// The second run's value.
    pub b: f64,
    /// b over a.
    pub ratio: f64,
    /// Largest relative difference at which both values agree; absent if neither run states a spread.
    pub spread: Option<f64>,
    /// Whether both values agree within the spread; absent if there is none.
    pub agrees: Option<bool>,
}

/// Two runs, figure by figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Figures that both runs have.
    pub pairs: Vec<Pair>,
    /// Number of figures that only the first run has.
    pub only_a: usize,
    /// Number of figures that only the second run has.
    pub only_b: usize,
}

impl Comparison {
    /// Number of figures that agree, and number of figures that can be judged.
    pub fn agreeing(&self) -> (usize, usize) {
        let judgements = self.pairs.iter().filter_map(|pair| pair.agrees);
        (
            judgements.clone().filter(|agrees| *agrees).count(),
            judgements.count(),
        )
    }

    /// For each kind of measurement: its name (the words before the first comma), its number of figures, the
    /// median of b over a, the number of figures that agree, and the number of figures that can be judged.
    pub fn by_kind(&self) -> Vec<(String, usize, f64, usize, usize)> {
        let mut kinds: BTreeMap<&str, Vec<&Pair>> = BTreeMap::new();
        for pair in &self.pairs {
            let kind = pair.what.split(',').next().unwrap_or_default();
            kinds.entry(kind).or_default().push(pair);
        }
        (kinds.into_iter())
            .map(|(kind, pairs)| {
                let mut ratios: Vec<f64> = pairs.iter().map(|pair| pair.ratio).collect();
                let judged = pairs.iter().filter_map(|pair| pair.agrees);
                let agreeing = judged.clone().filter(|agrees| *agrees).count();
                let middle = super::figure::median(&mut ratios);
                (
                    kind.to_owned(),
                    pairs.len(),
                    middle,
                    agreeing,
                    judged.count(),
                )
            })
            .collect()
    }
}

/// Compares two runs.
pub fn compare(a: &Characteristics, b: &Characteristics) -> Comparison {
    let figures = |run: &Characteristics| -> BTreeMap<_, _> { run.figures().collect() };
    let (a, b) = (figures(a), figures(b));
    let pairs: Vec<Pair> = (a.iter())
        .filter_map(|(what, a)| Some(pair(what, a, b.get(what)?)))
        .collect();
    Comparison {
        only_a: a.len() - pairs.len(),
        only_b: b.len() - pairs.len(),
        pairs,
    }
}

fn pair(what: &str, a: &Figure, b: &Figure) -> Pair {
    // Each run states a spread of its values. Use the wider one, which includes more disturbances.
    let spread = [a.spread, b.spread].into_iter().flatten().reduce(f64::max);
    let ratio = b.value / a.value;
    Pair {
        what: what.to_owned(),
        a: a.value,
        b: b.value,
        ratio,
        spread,
        agrees: spread.map(|spread| (a.value - b.value).abs() <= spread * a.value.max(b.value)),
    }
}

/// How fast a machine integrates a job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MachineRate {
    /// Name of the machine.
    pub host: String,
    /// Time of the measurement.
    pub measured: String,
    /// Number of modes of the measurement: the measured number closest to that of the job.
    pub modes: u64,
    /// Number of threads of the measurement: the largest measured team that is not larger than that of the
    /// job.
    pub threads: u64,
    /// Mesh cycles of the default drive per second, by `volterra`.
    pub rate: f64,
    /// Ratio of the rate to that of one thread, measured alternately, divided by the number of threads.
    pub efficiency: f64,
    /// Smallest number of threads whose rate is within two per cent of the highest one.
    pub worthwhile: u64,
    /// Whether the machine was quiet while it was measured.
    pub quiet: bool,
}

/// The rate of `volterra` with about `modes` modes on up to `threads` threads; `None` if it was not measured.
pub fn machine_rate(machine: &Characteristics, modes: usize, threads: u64) -> Option<MachineRate> {
    let row = usual(&machine.solver, modes, threads)?;
    let same_key = machine.solver.iter().filter(|other| {
        let (a, b) = (&other.key, &row.key);
        (&a.kernel, a.modes, a.points) == (&b.kernel, b.modes, b.points)
    });
    Some(MachineRate {
        host: machine.host.clone(),
        measured: machine.started.clone(),
        modes: row.key.modes,
        threads: row.key.threads,
        rate: row.figure.value,
        efficiency: row.key.efficiency,
        worthwhile: worthwhile(same_key)?,
        quiet: machine.noise.quiet,
    })
}

type Row = Measurement<SolverKey>;

/// The row of `volterra` with modes closest to `modes`, at the usual number of points and at most `threads` threads.
/// Of several, the one with the most threads.
fn usual<'r>(
    rows: impl IntoIterator<Item = &'r Row>,
    modes: usize,
    threads: u64,
) -> Option<&'r Row> {
    let distance = |row: &Row| (row.key.modes as f64 / modes as f64).ln().abs();
    rows.into_iter()
        .filter(|row| row.key.kernel == "volterra" && row.key.points == POINTS as u64)
        .filter(|row| row.key.threads <= threads)
        .min_by(|a, b| {
            let near = distance(a).total_cmp(&distance(b));
            near.then(b.key.threads.cmp(&a.key.threads))
        })
}

/// The smallest number of threads whose rate is within two per cent of the highest one; `None` without rows.
fn worthwhile<'r>(rows: impl IntoIterator<Item = &'r Row>) -> Option<u64> {
    let gain = |row: &Row| row.key.efficiency * row.key.threads as f64;
    let rows: Vec<&Row> = rows.into_iter().collect();
    let best = rows.iter().map(|row| gain(row)).fold(0.0, f64::max);
    let good = rows.iter().filter(|row| gain(row) >= 0.98 * best);
    good.map(|row| row.key.threads).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(value: f64, spread: Option<f64>) -> Figure {
        Figure {
            value,
            best: value,
            median: value,
            spread,
            rounds: 3,
            repetitions: 9,
        }
    }

    #[test]
    fn figures_agree_within_the_wider_spread() {
        let near = pair("x", &figure(100.0, Some(0.01)), &figure(104.0, Some(0.05)));
        assert_eq!(near.agrees, Some(true));
        assert_eq!(near.ratio, 1.04);
        let far = pair("x", &figure(100.0, Some(0.01)), &figure(104.0, Some(0.02)));
        assert_eq!(far.agrees, Some(false));
        let unknown = pair("x", &figure(100.0, None), &figure(104.0, None));
        assert_eq!((unknown.agrees, unknown.spread), (None, None));
        let comparison = Comparison {
            pairs: vec![near, far, unknown],
            only_a: 0,
            only_b: 1,
        };
        assert_eq!(comparison.agreeing(), (1, 2));
        assert_eq!(comparison.by_kind(), [("x".to_owned(), 3, 1.04, 1, 2)]);
    }

    /// A team not larger than the job's, at the closest measured number of modes.
    #[test]
    fn a_rate_is_that_of_the_nearest_measurement() {
        let row = |kernel: &str, modes, threads, rate, efficiency| Measurement {
            key: SolverKey {
                kernel: kernel.to_owned(),
                tables: "private".to_owned(),
                modes,
                points: POINTS as u64,
                threads,
                table_bytes: 1000,
                efficiency,
            },
            figure: figure(rate, None),
        };
        let rows = [
            row("volterra", 10, 1, 900.0, 1.0),
            row("volterra", 40, 1, 100.0, 1.0),
            row("volterra", 40, 2, 190.0, 0.95),
            row("volterra", 40, 4, 191.0, 0.4775),
            row("closed_modes", 30, 1, 500.0, 1.0),
        ];
        let wide = SolverKey {
            points: 64,
            ..rows[1].key.clone()
        };
        let rate = |modes, threads| {
            let wide = Measurement {
                key: wide.clone(),
                figure: figure(50.0, None),
            };
            let found = usual(rows.iter().chain([&wide]), modes, threads);
            found.map(|row| (row.key.modes, row.key.threads))
        };
        assert_eq!(rate(30, 3), Some((40, 2)));
        assert_eq!(rate(15, 8), Some((10, 1)));
        assert_eq!(rate(80, 0), None);
        assert_eq!(worthwhile(&rows[1..4]), Some(2));
    }
}
