//! A measured figure with what was measured.

use crate::store::file::Row;
use crate::store::table::{Column, Table, columns};
use serde::{Deserialize, Serialize};

/// A measured figure, in the unit of its measurement.
///
/// A measurement is repeated within a round, and rounds are repeated, minutes apart and with
/// memory taken anew. Disturbances only ever make a repetition worse, so a round gives its best
/// one; what differs between rounds is what will differ in the next run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Median over the rounds of the best repetition of each.
    pub value: f64,
    /// Best repetition of all.
    pub best: f64,
    /// Median of all repetitions.
    pub median: f64,
    /// Another run's value lies within this part of `value` with 95 %; absent after one round.
    pub spread: Option<f64>,
    /// Rounds.
    pub rounds: u64,
    /// Repetitions of all rounds.
    pub repetitions: u64,
}

/// What was measured and what came out: a row of a measurement's file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement<K> {
    /// What was measured.
    #[serde(flatten)]
    pub key: K,
    /// What came out.
    pub figure: Figure,
}

/// What one row of a measurement is told from the others by, and what else goes with it.
pub trait Key: Sized + 'static {
    /// Name of the measurement and, with `.parquet`, of its file.
    const NAME: &'static str;

    /// Name of the figure's columns, its unit, and what it is.
    const FIGURE: [&'static str; 3];

    /// What was measured, in words: equal for the same measurement of another run.
    fn words(&self) -> String;

    /// The columns before those of the figure.
    fn columns() -> Vec<Column<Measurement<Self>>>;
}

impl<K: Key> Measurement<K> {
    /// `bandwidth, read, compact, 4 threads`, and so on.
    pub fn words(&self) -> String {
        format!("{}, {}", K::NAME, self.key.words())
    }

    /// The columns: what was measured, then its figure.
    pub fn table() -> Table<Self> {
        let [name, unit, description] = K::FIGURE;
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

impl<K> Row for Measurement<K> {}
