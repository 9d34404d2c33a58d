//! `atlas run --retry failed` and `--max-failures`: failed points are recomputed and replaced, and nothing else
//! changes.

#![allow(clippy::unwrap_used)]

use crate::{place, results, seal};
use arrow_array::cast::AsArray;
use arrow_array::{ArrayRef, RecordBatch, StringArray};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use place::{OSCILLATOR, Place, status, stderr, stdout};
use results::{assert_same, physics};
use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

const TABLES: [&str; 3] = ["points.parquet", "poincare.parquet", "spectra.parquet"];

/// Marks some rows of `points.parquet` in a results folder as failed, as if a machine had run out of memory. The other
/// tables stay complete, so that all rows that a retry keeps or leaves behind are visible.
fn spoil(path: &Path, rows: &[usize]) {
    let open = || ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap();
    let metadata = open().metadata().clone();
    let batch = open().build().unwrap().next().unwrap().unwrap();
    let at = batch.schema().index_of("status").unwrap();
    let spoilt: StringArray = batch
        .column(at)
        .as_string::<i32>()
        .iter()
        .enumerate()
        .map(
            |(row, status)| {
                if rows.contains(&row) { Some("failed") } else { status }
            },
        )
        .collect();
    let mut columns: Vec<ArrayRef> = batch.columns().to_vec();
    columns[at] = Arc::new(spoilt);
    let batch = RecordBatch::try_new(batch.schema(), columns).unwrap();
    let schema = open().schema().clone();
    let mut writer = ArrowWriter::try_new(File::create(path).unwrap(), schema, None).unwrap();
    for pair in metadata.file_metadata().key_value_metadata().unwrap() {
        if pair.key != "ARROW:schema" {
            writer.append_key_value_metadata(pair.clone());
        }
    }
    writer.write(&batch).unwrap();
    writer.close().unwrap();
}

#[test]
fn failed_points_are_computed_again_and_the_others_kept() {
    let place = Place::new(OSCILLATOR);
    let whole = place.whole("whole", &[]);
    let out = place.whole("r", &[]);
    spoil(&out.join("points.parquet"), &[1, 4]);
    seal::reseal(&out.join("run.json"), |_| ());
    assert_ne!(
        physics(&whole, "points.parquet"),
        physics(&out, "points.parquet")
    );
    let output = place.run("r", &["--retry", "failed"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert!(
        stdout(&output).contains("2 points computed again"),
        "{}",
        stdout(&output)
    );
    assert_same(&TABLES, &whole, &out);
    let (record, before) = (place.record("r"), place.record("whole"));
    assert_eq!(record["totals"]["failed"], 0);
    assert_eq!(record["totals"]["ok"], before["totals"]["ok"]);
    assert_eq!(record["retries"][0]["points"], 2);
    let mut names: Vec<_> = fs::read_dir(&out)
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "poincare.parquet",
            "points.parquet",
            "run.json",
            "spectra.parquet"
        ]
    );

    let bytes = fs::read(out.join("points.parquet")).unwrap();
    let again = place.run("r", &["--retry", "failed"]);
    assert!(
        stdout(&again).contains("no failed points"),
        "{}",
        stdout(&again)
    );
    assert_eq!(fs::read(out.join("points.parquet")).unwrap(), bytes);
}

#[test]
fn a_shard_is_retried_alone_and_a_chain_as_a_whole() {
    let swept = OSCILLATOR.replace("count = 3 }", "count = 3 }\norder = \"sweep-up\"");
    let place = Place::new(&swept);
    for shard in ["1/2", "2/2"] {
        place.whole("whole", &["--shard", shard]);
        place.whole("r", &["--shard", shard]);
    }
    let table = place.path("r/points.parquet/shard-2-of-2.parquet");
    let other = fs::read(place.path("r/points.parquet/shard-1-of-2.parquet")).unwrap();
    spoil(&table, &[1]);
    seal::reseal(&place.path("r/run.shard-2-of-2.json"), |_| ());
    let output = place.run("r", &["--shard", "2/2", "--retry", "failed"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert!(
        stdout(&output).contains("3 points computed again"),
        "{}",
        stdout(&output)
    );
    assert_same(&TABLES, &place.path("whole"), &place.path("r"));
    assert_eq!(
        fs::read(place.path("r/points.parquet/shard-1-of-2.parquet")).unwrap(),
        other
    );
}

#[test]
fn points_that_fail_again_stay_failed() {
    let place = Place::new(&OSCILLATOR.replace("[run]", "[run]\nevent_limit = 1"));
    let out = place.whole("r", &[]);
    let before = physics(&out, "points.parquet");
    let failed = place.record("r")["totals"]["failed"].as_u64().unwrap();
    assert!(failed > 0);
    let output = place.run("r", &["--retry", "failed"]);
    assert_eq!(status(&output), 3, "{}", stderr(&output));
    assert_eq!(physics(&out, "points.parquet"), before);
    assert_eq!(place.record("r")["totals"]["failed"], failed);
    assert_eq!(place.record("r")["retries"][0]["failed"], failed);
}

#[test]
fn there_must_be_something_to_retry() {
    let place = Place::new(OSCILLATOR);
    let output = place.run("r", &["--retry", "failed"]);
    assert_eq!(status(&output), 2);
    assert!(
        stderr(&output).contains("run it without --retry first"),
        "{}",
        stderr(&output)
    );
    for arguments in [
        &["--retry", "ok"][..],
        &["--retry", "failed", "--overwrite"],
    ] {
        assert_eq!(status(&place.run("r", arguments)), 2);
    }
    assert!(!place.path("r").exists());
}

#[test]
fn a_job_is_called_off_after_so_many_failures_and_goes_on() {
    let place = Place::new(
        &OSCILLATOR
            .replace("[run]", "[run]\nevent_limit = 1")
            // There are more points than the channel to the writer can hold, so that the limit acts in time.
            .replace("count = 3", "count = 200"),
    );
    let whole = place.whole("whole", &["--threads", "1"]);
    let all = place.record("whole")["totals"]["failed"].as_u64().unwrap();
    assert!(all > 12, "{all}");
    let mut before = 0;
    for _ in 0..2 {
        let output = place.run("r", &["--threads", "1", "--max-failures", "3"]);
        assert_eq!(status(&output), 3, "{}", stderr(&output));
        assert!(
            stdout(&output).contains("--max-failures"),
            "{}",
            stdout(&output)
        );
        let record = place.record("r");
        assert_eq!(record["state"], "interrupted");
        let failed = record["totals"]["failed"].as_u64().unwrap();
        assert!(
            failed >= before + 3 && failed < all,
            "{before} {failed} {all}"
        );
        before = failed;
    }
    assert_eq!(status(&place.run("r", &["--threads", "2"])), 3);
    assert_eq!(place.record("r")["state"], "complete");
    assert_same(&["points.parquet"], &whole, &place.path("r"));

    // A cancelled retry leaves the results unchanged, and can also be resumed.
    let record = place.record("r");
    let arguments = ["--threads", "1", "--retry", "failed", "--max-failures", "2"];
    let output = place.run("r", &arguments);
    assert_eq!(status(&output), 3, "{}", stderr(&output));
    assert!(
        stdout(&output).contains("stopped by --max-failures")
            && stdout(&output).contains("the same command continues"),
        "{}",
        stdout(&output)
    );
    assert_eq!(place.record("r"), record);
    let journal = place.path("r/.retry/.journal");
    assert!(journal.exists() && !place.path("r/.journal").exists());
    let output = place.run("r", &["--retry", "failed"]);
    assert_eq!(status(&output), 3, "{}", stderr(&output));
    assert!(
        stderr(&output).contains("kept from an interrupted run"),
        "{}",
        stderr(&output)
    );
    assert!(!journal.exists());
    assert_same(&["points.parquet"], &whole, &place.path("r"));
}

#[test]
fn a_retry_that_was_killed_leaves_nothing_behind_once_it_is_repeated() {
    let place = Place::new(OSCILLATOR);
    let whole = place.whole("whole", &[]);
    let out = place.whole("r", &[]);
    let file = |name: &str| out.join(name);
    let read = || TABLES.map(|table| fs::read(file(table)).unwrap());
    let tables = || place.record("r")["tables"].as_array().unwrap().clone();
    spoil(&file("points.parquet"), &[1, 4]);
    seal::reseal(&file("run.json"), |_| ());
    let (old, before) = (read(), tables());
    let record = fs::read(file("run.json")).unwrap();
    assert_eq!(status(&place.run("r", &["--retry", "failed"])), 0);
    let (new, behind) = (read(), tables());

    // Between two renames some tables are old and some are new, and the record names both.
    for exchanged in 0..=TABLES.len() {
        fs::write(file("run.json"), &record).unwrap();
        seal::reseal(&file("run.json"), |record| {
            let both = [&before[..], &behind].concat();
            record["tables"] = both.into();
            let amid = "a retry of these points was interrupted; repeat it with --retry failed";
            record["warnings"] = vec![amid].into();
        });
        // points.parquet comes last.
        for (place, table) in [1, 2, 0].into_iter().enumerate() {
            let bytes = if place < exchanged { &new } else { &old };
            fs::write(file(TABLES[table]), &bytes[table]).unwrap();
        }
        fs::write(file(".points.parquet.x1.partial"), "half of it").unwrap();
        let shown = place.atlas(&["show", "r"]);
        assert_eq!(status(&shown), 0, "{}", stderr(&shown));
        assert!(stdout(&shown).contains("repeat it"), "{}", stdout(&shown));
        let output = place.run("r", &["--retry", "failed"]);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
        assert_same(&TABLES, &whole, &out);
        assert!(!file(".points.parquet.x1.partial").exists());
        assert_eq!(tables().len(), TABLES.len());
        assert_eq!(
            place.record("r")["warnings"],
            place.record("whole")["warnings"]
        );
        assert!(stdout(&place.run("r", &[])).contains("already holds"));
    }
}
