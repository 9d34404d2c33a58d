//! What a job would take on another machine, from what both machines were measured to do.

use crate::store::{Characteristics, Measurement, SolverKey};
use serde::Serialize;

/// The rate of a machine for a job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MachineRate {
    /// Name of the machine.
    pub host: String,
    /// When it was measured.
    pub measured: String,
    /// Threads of the rate.
    pub threads: u64,
    /// Mesh cycles of the default drive a second, with the job's number of modes.
    pub rate: f64,
    /// Gain over one thread, measured in turn, over the threads.
    pub efficiency: f64,
    /// Threads beyond which the rate no longer grows by two per cent.
    pub worthwhile: u64,
    /// Whether the machine was quiet while it was measured.
    pub quiet: bool,
}

/// Rates of the structured kernel with a number of modes on a number of threads, interpolated in
/// logarithms between those measured; none where it was not measured.
pub fn machine_rate(machine: &Characteristics, modes: usize, threads: u64) -> Option<MachineRate> {
    let over_modes =
        |threads, value: Value| over_modes(&machine.solver, modes as f64, threads, value);
    let mut counts: Vec<u64> = volterra(&machine.solver)
        .map(|row| row.key.threads)
        .collect();
    counts.sort_unstable();
    counts.dedup();
    let curve = |value: Value| -> Vec<[f64; 2]> {
        let places = counts
            .iter()
            .map(|&count| Some([count as f64, over_modes(count, value)?]));
        places.flatten().collect()
    };
    let (rates, gains) = (curve(|row| Some(row.figure.value)), curve(gain));
    let most = counts.last().copied()?;
    let threads = threads.min(most);
    let best = gains.iter().map(|[_, gain]| *gain).fold(0.0, f64::max);
    let worthwhile = gains.iter().find(|[_, gain]| *gain >= 0.98 * best)?;
    Some(MachineRate {
        host: machine.host.clone(),
        measured: machine.started.clone(),
        threads,
        rate: interpolated(&rates, threads as f64)?,
        efficiency: interpolated(&gains, threads as f64)? / threads as f64,
        worthwhile: worthwhile[0] as u64,
        quiet: machine.noise.quiet,
    })
}

/// What is looked up of a row.
type Value = fn(&Measurement<SolverKey>) -> Option<f64>;

/// What its threads gain over one.
fn gain(row: &Measurement<SolverKey>) -> Option<f64> {
    row.key
        .efficiency
        .map(|efficiency| efficiency * row.key.threads as f64)
}

fn volterra(rows: &[Measurement<SolverKey>]) -> impl Iterator<Item = &Measurement<SolverKey>> {
    let wanted =
        |row: &&Measurement<SolverKey>| row.key.kernel == "volterra" && row.key.tables == "eight";
    rows.iter().filter(wanted)
}

fn over_modes(
    rows: &[Measurement<SolverKey>],
    modes: f64,
    threads: u64,
    value: Value,
) -> Option<f64> {
    let mut places: Vec<[f64; 2]> = volterra(rows)
        .filter(|row| row.key.threads == threads)
        .filter_map(|row| Some([row.key.modes as f64, value(row)?]))
        .collect();
    places.sort_by(|a, b| a[0].total_cmp(&b[0]));
    interpolated(&places, modes)
}

/// A power law between neighbours, that of the last two beyond the ends.
fn interpolated(places: &[[f64; 2]], x: f64) -> Option<f64> {
    match places {
        [] => None,
        [only] => Some(only[1]),
        _ => {
            let after = places.partition_point(|place| place[0] < x);
            let [a, b] = [
                places[after.clamp(1, places.len() - 1) - 1],
                places[after.clamp(1, places.len() - 1)],
            ];
            let slope = (b[1] / a[1]).ln() / (b[0] / a[0]).ln();
            Some(a[1] * (x / a[0]).powf(slope))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Figure;

    /// What threads gain is what was measured in turn, whatever the rates say that were measured apart.
    #[test]
    fn the_gain_of_threads_is_the_measured_one() {
        let row = |modes: u64, rate: f64, efficiency: f64| Measurement {
            key: SolverKey {
                kernel: "volterra".to_owned(),
                tables: "eight".to_owned(),
                modes,
                threads: 2,
                table_bytes: 1000,
                efficiency: Some(efficiency),
            },
            figure: Figure {
                value: rate,
                best: rate,
                median: rate,
                spread: None,
                rounds: 1,
                repetitions: 1,
            },
        };
        let rows = [row(10, 800.0, 0.8), row(40, 100.0, 0.95)];
        let rate: Value = |row| Some(row.figure.value);
        for (modes, gained, known) in [(10.0, 1.6, 800.0), (40.0, 1.9, 100.0)] {
            let found = over_modes(&rows, modes, 2, gain).unwrap();
            assert!((found - gained).abs() < 1e-12, "{found}");
            assert_eq!(over_modes(&rows, modes, 2, rate), Some(known));
        }
        assert_eq!(over_modes(&rows, 10.0, 4, gain), None);
    }

    #[test]
    fn a_power_law_is_followed_between_and_beyond() {
        let places = [[10.0, 100.0], [20.0, 50.0], [40.0, 25.0]];
        for (x, exact) in [
            (10.0, 100.0),
            (15.0, 1000.0 / 15.0),
            (80.0, 12.5),
            (5.0, 200.0),
        ] {
            let found = interpolated(&places, x).unwrap();
            assert!((found / exact - 1.0).abs() < 1e-12, "{x}: {found}");
        }
        assert_eq!(interpolated(&[[4.0, 7.0]], 9.0), Some(7.0));
        assert_eq!(interpolated(&[], 9.0), None);
    }
}
