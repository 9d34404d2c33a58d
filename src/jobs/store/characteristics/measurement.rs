//! A measured figure with its key.

use crate::store::table::{Column, Table, columns};
use serde::{Deserialize, Serialize};

/// A measured figure, in the unit of its measurement.
///
/// A measurement is repeated within a round. Rounds are repeated minutes apart, with new memory. Disturbances can only
/// worsen a repetition, so the best one represents a round. Differences between rounds show how much the next run will
/// differ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Median over the rounds of each round's best repetition.
    pub value: f64,
    /// Best repetition of all.
    pub best: f64,
    /// Median of all repetitions.
    pub median: f64,
    /// Half width of the 95 % prediction interval for the value of another run, relative to `value`; absent
    /// after one round.
    pub spread: Option<f64>,
    /// Number of rounds.
    pub rounds: u64,
    /// Number of repetitions in all rounds.
    pub repetitions: u64,
}

/// A row of a measurement's file: the key and the result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement<K> {
    /// The key, which identifies the measurement.
    #[serde(flatten)]
    pub key: K,
    /// The result.
    pub figure: Figure,
}

/// The key of a measurement: the quantities that distinguish it from others, and further columns.
pub trait Key: Sized + 'static {
    /// Name of the measurement and, with `.parquet`, of its file.
    const NAME: &'static str;

    /// Name, unit and description of the measured figure.
    const MEASURED: [&'static str; 3];

    /// The key in words, equal for the same measurement in another run.
    fn words(&self) -> String;

    /// The columns before those of the figure.
    fn columns() -> Vec<Column<Measurement<Self>>>;
}

impl<K: Key> Measurement<K> {
    /// `bandwidth, read, compact, 4 threads`, and so on.
    pub fn words(&self) -> String {
        format!("{}, {}", K::NAME, self.key.words())
    }

    /// The columns of the key, then those of the figure.
    pub fn table() -> Table<Self> {
        let [name, unit, description] = K::MEASURED;
        let named = |part: &str| format!("{name}_{part}");
        let of = |what: &str| format!("{what} ({description})");
        let mut all = K::columns();
        all.extend(columns![row: Self;
            f64 name, unit, row.figure.value, &of("Median over rounds of the best repetition per round");
            f64 &named("best"), unit, row.figure.best, &of("Best repetition");
            f64 &named("median"), unit, row.figure.median, &of("Median repetition");
            f64 &named("spread"), "1", row.figure.spread,
                "Half width of the 95 % prediction interval for the value of another run, as a fraction of this value";
            u64 "rounds", "1", row.figure.rounds, "Rounds";
            u64 "repetitions", "1", row.figure.repetitions, "Number of repetitions in all rounds";
        ]);
        Table::new(all)
    }
}
