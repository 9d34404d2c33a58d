//! `atlas merge`: joined shards equal one run, and anything except a complete set of shards of one job is refused with
//! the names of its gaps.

#![allow(clippy::unwrap_used)]

use crate::{place, results, seal};
use arrow_array::RecordBatch;
use gearatlas::store::ResultTable;
use gearatlas::store::TableKind;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use place::{OSCILLATOR, Place, status, stderr, stdout};
use results::{assert_same, file_ids};
use seal::reseal;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

const TABLES: [&str; 3] = ["points.parquet", "poincare.parquet", "spectra.parquet"];

/// Every file below a folder, with its bytes.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(contents(&path));
        } else {
            found.insert(path.clone(), fs::read(path).unwrap());
        }
    }
    found
}

fn merge(place: &Place, folders: &[&str], out: &str) -> (i32, String) {
    let output = place.atlas(&[&["merge"], folders, &["--out", out]].concat());
    (status(&output), stderr(&output))
}

/// Rewrites a table with the batches that `change` returns.
fn rewrite(path: &Path, change: impl FnOnce(RecordBatch) -> Vec<RecordBatch>) {
    let reader = ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap();
    let batch = reader.build().unwrap().next().unwrap().unwrap();
    let reader = ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap();
    let (schema, metadata) = (reader.schema().clone(), reader.metadata().clone());
    let pairs = metadata.file_metadata().key_value_metadata().cloned();
    let mut writer = ArrowWriter::try_new(File::create(path).unwrap(), schema, None).unwrap();
    for pair in pairs.unwrap_or_default() {
        if pair.key != "ARROW:schema" {
            writer.append_key_value_metadata(pair);
        }
    }
    for batch in change(batch) {
        writer.write(&batch).unwrap();
    }
    writer.close().unwrap();
}

#[test]
fn shards_joined_are_the_run_undivided() {
    let place = Place::new(OSCILLATOR);
    let whole = place.whole("whole", &[]);
    // Two shards are in one folder, one is in another.
    for (out, shard) in [("a", "3/3"), ("b", "1/3"), ("a", "2/3")] {
        place.whole(out, &["--shard", shard]);
    }
    let before = [contents(&place.path("a")), contents(&place.path("b"))];
    assert_eq!(merge(&place, &["a", "b"], "joined"), (0, String::new()));
    // The merge also accepts a folder of folders, with other files in it.
    for name in ["a", "b", "logs"] {
        let there = place.path("all.shards").join(name);
        fs::create_dir_all(&there).unwrap();
        fs::write(place.path("all.shards/split"), "3").unwrap();
        if name != "logs" {
            fs::remove_dir(&there).unwrap();
            std::os::unix::fs::symlink(place.path(name), there).unwrap();
        }
    }
    assert_eq!(merge(&place, &["all.shards"], "of all"), (0, String::new()));
    assert_same(&TABLES, &whole, &place.path("of all"));
    let joined = place.path("joined");
    assert_same(&TABLES, &whole, &joined);
    for table in TABLES {
        assert!(joined.join(table).is_file());
        let ids = file_ids(&joined.join(table));
        assert!(ids.is_sorted() && ids == file_ids(&whole.join(table)));
    }
    let after = [contents(&place.path("a")), contents(&place.path("b"))];
    assert!(before == after, "inputs stay as they are");

    let (record, undivided) = (place.record("joined"), place.record("whole"));
    for key in ["job", "manifest", "manifest_hash", "program", "state"] {
        assert_eq!(record[key], undivided[key], "{key}");
    }
    for key in [
        "points",
        "ok",
        "not_converged",
        "failed",
        "missing",
        "cycles",
    ] {
        assert_eq!(record["totals"][key], undivided["totals"][key], "{key}");
    }
    assert_eq!(record["shards"].as_array().unwrap().len(), 3);
    assert_eq!(record["shards"][2]["shard"]["index"], 3);
    assert!(record.get("shard").is_none());
    // The metadata are equal too: the joined folder looks like the folder of one run.
    let tables = [&whole, &joined].map(|f| ResultTable::read(f, TableKind::Points).unwrap());
    assert_eq!(tables[0].units().unwrap(), tables[1].units().unwrap());
    assert_eq!(tables[0].axes().unwrap(), tables[1].axes().unwrap());
    let again = place.run("joined", &[]);
    assert!(stdout(&again).contains("already holds"));
    assert_eq!(status(&place.atlas(&["show", "joined"])), 0);
}

#[test]
fn chains_and_their_changes_are_joined() {
    let swept = OSCILLATOR
        .replace("count = 3 }", "count = 4 }\norder = \"both\"")
        .replace("samples = 20", "samples = 20, refine = 2");
    let place = Place::new(&swept);
    let whole = place.whole("whole", &[]);
    for shard in ["1/3", "2/3", "3/3"] {
        place.whole("parts", &["--shard", shard]);
    }
    assert_eq!(merge(&place, &["parts"], "joined"), (0, String::new()));
    assert_same(&TABLES, &whole, &place.path("joined"));
    let changes = ["transitions.parquet"].map(|t| results::physics(&whole, t));
    assert_eq!(
        changes[0],
        results::physics(&place.path("joined"), "transitions.parquet")
    );
}

#[test]
fn what_is_no_whole_is_refused() {
    let place = Place::new(OSCILLATOR);
    let refused = |folders: &[&str], out: &str, words: &[&str]| {
        let (code, said) = merge(&place, folders, out);
        assert_eq!(code, 2, "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        for word in words {
            assert!(said.contains(word), "{word}: {said}");
        }
    };
    for (out, shard) in [("a", "1/3"), ("b", "3/3"), ("c", "1/3"), ("d", "1/2")] {
        place.whole(out, &["--shard", shard]);
    }
    place.whole("whole", &[]);
    refused(
        &["a", "b"],
        "out",
        &["of 3 shards", "missing: 2;", "--shard i/3"],
    );
    refused(
        &["a", "b", "c"],
        "out",
        &["shard 1 of 3 is in `a` and in `c`"],
    );
    refused(&["a", "d"], "out", &["number of shards"]);
    refused(&["a", "whole"], "out", &["`whole` holds the whole"]);
    refused(&["a", "nowhere"], "out", &["nowhere"]);
    assert!(!place.path("out").exists());

    place.whole("b", &["--shard", "2/3"]);
    refused(&["a", "b"], "whole", &["`whole` is not empty"]);
    refused(&["a", "b"], "a", &["`a` is not empty"]);
    // Replace a record by that of another manifest.
    let record = place.path("a/run.shard-1-of-3.json");
    let text = fs::read_to_string(&record).unwrap();
    reseal(&record, |r| r["manifest_hash"] = "0123456789abcdef".into());
    refused(&["a", "b"], "out", &["the manifest differs", "01234567"]);
    fs::write(&record, &text).unwrap();
    reseal(&record, |r| r["state"] = "interrupted".into());
    refused(&["a", "b"], "out", &["shard 1 of 3", "interrupted"]);
    // Make the recorded totals disagree with the table.
    fs::write(&record, &text).unwrap();
    reseal(&record, |r| r["totals"]["points"] = 3.into());
    refused(&["a", "b"], "out", &["2 points", "lists 3"]);
    fs::write(&record, &text).unwrap();

    // Remove rows, then put rows of a point into another shard.
    let table = place.path("a/points.parquet/shard-1-of-3.parquet");
    let own = fs::read(&table).unwrap();
    assert_eq!(file_ids(&table), [0, 3]);
    rewrite(&table, |batch| vec![batch.slice(0, 1)]);
    reseal(&record, |r| r["totals"]["points"] = 1.into());
    refused(&["a", "b"], "out", &["has rows of point 5", "5 points"]);
    rewrite(&table, |batch| vec![batch.clone(), batch]);
    reseal(&record, |r| r["totals"]["points"] = 2.into());
    refused(&["a", "b"], "out", &["no shard has these points: 3"]);
    fs::copy(place.path("b/points.parquet/shard-2-of-3.parquet"), &table).unwrap();
    reseal(&record, |_| ());
    refused(&["a", "b"], "out", &["point 1 is in `a/"]);
    fs::write(&record, &text).unwrap();
    fs::write(&table, &own[..own.len() - 9]).unwrap();
    refused(&["a", "b"], "out", &["shard-1-of-3.parquet` is damaged"]);
    fs::write(&table, own).unwrap();
    let left: Vec<_> = fs::read_dir(place.path("out")).unwrap().collect();
    assert!(left.is_empty(), "nothing half done appears");
    assert_eq!(merge(&place, &["a", "b"], "out"), (0, String::new()));
}
