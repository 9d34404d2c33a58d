//! Results folders: tables without a record, and records with a valid checksum.

use super::right;
use super::scratch::{OSCILLATOR, empty, folder, put};
use gearatlas::input::printable;
use gearatlas::manifest::parse;
use gearatlas::report::{Style, Summary, render};
use gearatlas::store::{
    ColumnKind, Journal, PointRow, ResultTable, RunRecord, StoreError, TableKind, TableStore,
    read_runs, verify,
};
use gearatlas::sweep::{Options, Prepared, Progress, ProgressObserver, Sweep, SweepPlan};
use std::fs;
use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::AtomicBool;

/// Observes nothing.
struct Nobody;

impl ProgressObserver for Nobody {
    fn begun(&mut self, _: &SweepPlan<'_>) {}
    fn warning(&mut self, _: &str) {}
    fn point(&mut self, _: &PointRow, _: &Progress) {}
    fn tick(&mut self, _: &Progress) {}
}

/// A table of points before any change.
static POINTS: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let here = empty("results-of-truth");
    let job = parse(OSCILLATOR, "m.toml", &folder()).expect("a manifest");
    let mut journal = Journal::open(&here, &job.hash, None, true).expect("a journal");
    let parts = Prepared::new(TableStore::open(here.join("tables")));
    let options = Options {
        threads: Some(1),
        ..Options::default()
    };
    let sweep = Sweep {
        job: &job,
        folder: &here,
        options,
        parts: &parts,
        topology: None,
        interrupt: &AtomicBool::new(false),
    };
    sweep.run(&mut journal, &mut Nobody).expect("a run");
    fs::read(here.join("points.parquet")).expect("its table")
});

/// `points.parquet` in a folder without a record.
pub fn table(data: &[u8]) {
    let here = empty("results");
    put(&here.join("points.parquet"), data);
    match ResultTable::read(&here, TableKind::Points) {
        Ok(table) => columns(&table),
        Err(refusal) => said(&refusal),
    }
    summarised(&here);
}

/// The text of `run.json`, with a valid checksum, next to a complete table.
pub fn record(data: &[u8]) {
    let here = empty("results");
    put(&here.join("points.parquet"), &POINTS);
    put(
        &here.join("run.json"),
        &sealed(&String::from_utf8_lossy(data)),
    );
    match read_runs(&here) {
        Ok(runs) => runs.iter().for_each(|run| held(&here, run)),
        Err(refusal) => said(&refusal),
    }
    summarised(&here);
}

fn held(here: &Path, run: &RunRecord) {
    if let Err(refusal) = verify(here, run) {
        said(&refusal);
    }
}

/// The summary of a folder is text for a terminal.
fn summarised(here: &Path) {
    if let Ok(summary) = Summary::read(here) {
        let text = render(&summary, Style::Plain);
        right(printable(&text) == text, || format!("{text:?}"));
    }
}

/// Every column of a table that was read is as long as the table, and its numbers are finite.
fn columns(table: &ResultTable) {
    let Ok(heads) = table.columns() else {
        return;
    };
    for head in heads {
        let name = &head.name;
        let length = match head.kind {
            ColumnKind::Whole => table.u64(name).map(|column| column.len()),
            ColumnKind::Truth => table.bool(name).map(|column| column.len()),
            ColumnKind::Text => table.text(name).map(|column| column.len()),
            ColumnKind::Number | ColumnKind::List => table.numbers(name).map(|column| {
                let mut numbers = column.iter().flatten().flatten();
                right(numbers.all(|x| x.is_finite()), || {
                    format!("{name} is not finite")
                });
                column.len()
            }),
        };
        match length {
            Ok(length) => right(length == table.rows(), || format!("{name}: {length} rows")),
            Err(refusal) => said(&refusal),
        }
    }
}

fn said(refusal: &StoreError) {
    right(!refusal.to_string().is_empty(), || {
        "refused without a word".into()
    });
}

/// A JSON object whose last key is the hash of all text before it, like the end of a run's record.
fn sealed(json: &str) -> Vec<u8> {
    let text = json.trim_end().trim_end_matches('}').trim_end();
    let hash = blake3::hash(text.as_bytes()).to_hex();
    format!("{text},\n  \"blake3\": \"{hash}\"\n}}\n").into_bytes()
}

/// The unchanged table.
pub fn seeds() -> Vec<Vec<u8>> {
    vec![POINTS.clone()]
}
