//! Results that a disk, a copy or a user has changed: every reader names the damaged file in one line, and passes on
//! none of its numbers.

#![allow(clippy::unwrap_used)]

use crate::{place, results, seal};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, UInt64Type};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, UInt64Array};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use place::{OSCILLATOR, Place, status, stderr, stdout};
use seal::reseal;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::Arc;

const TABLES: [&str; 3] = ["points.parquet", "poincare.parquet", "spectra.parquet"];

/// A refusal in one line that names the file.
fn refused(output: &Output, file: &str) -> String {
    let said = stderr(output);
    assert_eq!(status(output), 2, "{file}: {said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(said.starts_with("error: ") && said.contains(file), "{said}");
    said
}

/// Orbits followed over the speed, curves over the load, and a traced trajectory.
const CONTINUATION: &str = r#"
[continuation]
over = "speed"
second = "load"
starts = 2
longest_period = 2
"#;

/// Any changed bit in a table of `atlas follow` or `atlas trace`, or in their records: every command that reads the
/// file reports it.
#[test]
fn every_flipped_bit_of_followed_orbits_and_traces_is_found() {
    const BITS: usize = 24;
    let place = Place::new(&format!("{OSCILLATOR}{CONTINUATION}"));
    for arguments in [
        &["follow", "m.toml", "--out", "f", "--quiet"][..],
        &[
            "trace",
            "m.toml",
            "--point",
            "load=0.05,speed=1050",
            "--skip",
            "10",
            "--cycles",
            "20",
            "--out",
            "t",
        ],
    ] {
        let output = place.atlas(arguments);
        assert_eq!(status(&output), 0, "{}", stderr(&output));
    }
    let readers = |folder: &str| -> Vec<Vec<String>> {
        let all = [
            format!("export {folder} --format csv --out sheets"),
            format!("report {folder} --out page.html --overwrite"),
            format!("plot {folder} --format svg --out pictures"),
            format!("show {folder} --json"),
        ];
        // A trace has no summary.
        let most = if folder == "f" { 4 } else { 3 };
        let words = |line: &String| line.split(' ').map(str::to_owned).collect();
        all[..most].iter().map(words).collect()
    };
    let files = [
        "f/branches.parquet",
        "f/bifurcations.parquet",
        "f/curves.parquet",
        "f/follow.json",
        "t/trace.parquet",
        "t/events.parquet",
        "t/trace.json",
    ];
    for (seed, file) in files.into_iter().enumerate() {
        let path = place.path(file);
        let bytes = fs::read(&path).unwrap();
        let readers = readers(&file[..1]);
        for (nth, bit) in places(7000 + 100 * seed as u64, 8 * bytes.len(), BITS).enumerate() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, damaged).unwrap();
            let reader: Vec<&str> = readers[nth % readers.len()]
                .iter()
                .map(String::as_str)
                .collect();
            refused(&place.atlas(&reader), &format!("{file}` is damaged"));
        }
        fs::write(&path, &bytes).unwrap();
    }
    for folder in ["f", "t"] {
        for reader in readers(folder) {
            let reader: Vec<&str> = reader.iter().map(String::as_str).collect();
            let output = place.atlas(&reader);
            assert_eq!(status(&output), 0, "{reader:?}: {}", stderr(&output));
        }
    }
}

#[test]
fn a_table_that_is_gone_cut_or_changed_is_named_by_all_that_read_it() {
    let place = Place::new(OSCILLATOR);
    place.whole("r", &[]);
    let readers: [&[&str]; 5] = [
        &["show", "r"],
        &["show", "r", "--json"],
        &["plot", "r", "--format", "svg", "--out", "pictures"],
        &["run", "m.toml", "--out", "r"],
        &["run", "m.toml", "--out", "r", "--retry", "failed"],
    ];
    for (table, read_by) in [
        ("points.parquet", &readers[..]),
        ("spectra.parquet", &readers[2..]),
    ] {
        let path = place.path("r").join(table);
        let bytes = fs::read(&path).unwrap();
        let mut flipped = bytes.clone();
        flipped[bytes.len() / 3] ^= 4;
        let longer = [&bytes[..], b" "].concat();
        for (damaged, words) in [
            (None, "it is missing"),
            (Some(&bytes[..bytes.len() - 1]), "were written"),
            (Some(&bytes[..0]), "it has 0 bytes"),
            (Some(&longer[..]), "were written"),
            (Some(&flipped[..]), "differ from the written bytes"),
        ] {
            fs::remove_file(&path).unwrap();
            damaged
                .iter()
                .for_each(|bytes| fs::write(&path, bytes).unwrap());
            for arguments in read_by {
                let said = refused(&place.atlas(arguments), &format!("r/{table}` is damaged"));
                assert!(
                    said.contains(words) && said.contains("--overwrite"),
                    "{arguments:?}: {said}"
                );
            }
            fs::write(&path, &bytes).unwrap();
        }
    }
    let again = place.run("r", &[]);
    assert!(
        stdout(&again).contains("already holds"),
        "put back, it is whole"
    );

    // Points that cannot be restored are computed again.
    let before = TABLES.map(|table| results::physics(&place.path("r"), table));
    fs::write(place.path("r/points.parquet"), "").unwrap();
    fs::write(place.path("r/run.json"), "{}").unwrap();
    place.whole("r", &["--overwrite"]);
    assert_eq!(
        before,
        TABLES.map(|table| results::physics(&place.path("r"), table))
    );
}

/// Positions of bits in a file, from a seed.
fn places(seed: u64, bits: usize, count: usize) -> impl Iterator<Item = usize> {
    (0..count as u64).map(move |k| {
        let mixed = (seed + k).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        ((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 16) as usize % bits
    })
}

/// Flips bits of the tables and the record of a shard, one at a time; each must be refused.
fn flip(count: usize) {
    let place = Place::new(OSCILLATOR);
    for shard in ["1/2", "2/2"] {
        place.whole(&shard[..1], &["--shard", shard]);
    }
    let merge = ["merge", "1", "2", "--out", "joined"];
    for (seed, file) in [
        "1/points.parquet/shard-1-of-2.parquet",
        "1/run.shard-1-of-2.json",
        "1/poincare.parquet/shard-1-of-2.parquet",
    ]
    .into_iter()
    .enumerate()
    {
        let path = place.path(file);
        let bytes = fs::read(&path).unwrap();
        for bit in places(1000 * seed as u64, 8 * bytes.len(), count) {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, damaged).unwrap();
            refused(&place.atlas(&merge), &format!("{file}` is damaged"));
            // A summary does not read the samples.
            if !file.contains("poincare") {
                refused(&place.atlas(&["show", "1"]), &format!("{file}` is damaged"));
            }
        }
        fs::write(&path, bytes).unwrap();
    }
    let output = place.atlas(&merge);
    assert_eq!(
        status(&output),
        0,
        "nothing stands in its way: {}",
        stderr(&output)
    );
}

#[test]
fn no_flipped_bit_passes() {
    flip(70);
}

#[test]
#[ignore = "some minutes: 2400 bits, each merged and shown"]
fn no_flipped_bit_of_many_passes() {
    flip(800);
}

/// Rewrites a column of a table.
fn rewrite(path: &Path, name: &str, change: impl Fn(&ArrayRef) -> ArrayRef) {
    let open = || ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap();
    let metadata = open().metadata().clone();
    let batch = open().build().unwrap().next().unwrap().unwrap();
    let at = batch.schema().index_of(name).unwrap();
    let mut columns = batch.columns().to_vec();
    columns[at] = change(&columns[at]);
    let batch = RecordBatch::try_new(batch.schema(), columns).unwrap();
    let file = File::create(path).unwrap();
    let mut writer = ArrowWriter::try_new(file, batch.schema(), None).unwrap();
    for pair in metadata.file_metadata().key_value_metadata().unwrap() {
        if pair.key != "ARROW:schema" {
            writer.append_key_value_metadata(pair.clone());
        }
    }
    writer.write(&batch).unwrap();
    writer.close().unwrap();
}

fn names(folder: PathBuf) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}

#[test]
fn points_of_no_job_and_numbers_that_no_run_writes_are_refused() {
    let place = Place::new(OSCILLATOR);
    for shard in ["1/2", "2/2"] {
        place.whole(&shard[..1], &["--shard", shard]);
    }
    let merge = || place.atlas(&["merge", "1", "2", "--out", "joined"]);
    let (table, record) = (
        "1/points.parquet/shard-1-of-2.parquet",
        "1/run.shard-1-of-2.json",
    );
    let own = [table, record].map(|file| fs::read(place.path(file)).unwrap());
    let put_back = || {
        fs::write(place.path(table), &own[0]).unwrap();
        fs::write(place.path(record), &own[1]).unwrap();
    };

    // Counting up to this id would allocate 8.8 TB.
    let far = 1 << 40;
    rewrite(&place.path(table), "point_id", |ids| {
        let ids = ids.as_primitive::<UInt64Type>();
        let last = ids.len() - 1;
        let changed = ids.values().iter().enumerate();
        let changed = changed.map(|(row, id)| if row == last { id + far } else { *id });
        Arc::new(changed.collect::<UInt64Array>())
    });
    reseal(&place.path(record), |_| ());
    let said = refused(&merge(), table);
    assert!(
        said.contains(&(4 + far).to_string()) && said.contains("6 points"),
        "{said}"
    );
    assert_eq!(
        names(place.path("joined")),
        [""; 0],
        "nothing is in the way of the next try"
    );

    put_back();
    for (column, value, text) in [
        ("lambda_max", f64::NAN, "NaN"),
        ("deflection_rms", f64::INFINITY, "inf"),
    ] {
        rewrite(&place.path(table), column, |values| {
            let values = values.as_primitive::<Float64Type>().iter().enumerate();
            let changed = values.map(|(row, old)| if row == 1 { Some(value) } else { old });
            Arc::new(changed.collect::<Float64Array>())
        });
        reseal(&place.path(record), |_| ());
        let mut readers = vec![merge(), place.atlas(&["plot", "1"])];
        // A summary reads only the columns that it needs.
        if column == "lambda_max" {
            readers.push(place.atlas(&["show", "1"]));
        }
        for output in readers {
            let said = refused(&output, table);
            let found = format!("has {text} in column `{column}`, row 1 (counted from 0)");
            assert!(said.contains(&found), "{said}");
        }
        put_back();
    }

    // Leave files as a killed merge would.
    fs::create_dir_all(place.path("joined")).unwrap();
    fs::write(
        place.path("joined/.points.parquet.x1.partial"),
        "half of it",
    )
    .unwrap();
    let output = merge();
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    assert!(!place.path("joined/.points.parquet.x1.partial").exists());
}

/// A folder without a record, for example with copied tables: its bytes cannot be checked.
#[test]
fn without_a_record_a_table_is_read_with_a_warning_or_refused_in_one_line() {
    let place = Place::new(OSCILLATOR);
    place.whole("r", &[]);
    fs::remove_file(place.path("r/run.json")).unwrap();
    let shown = place.atlas(&["show", "r"]);
    assert_eq!(status(&shown), 0, "{}", stderr(&shown));
    assert!(
        stdout(&shown).contains("cannot be checked"),
        "{}",
        stdout(&shown)
    );
    let path = place.path("r/points.parquet");
    let bytes = fs::read(&path).unwrap();
    for bit in places(7, 8 * bytes.len(), 60) {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        fs::write(&path, damaged).unwrap();
        let output = place.atlas(&["show", "r"]);
        let said = stderr(&output);
        assert!([0, 2].contains(&status(&output)), "bit {bit}: {said}");
        let lines = usize::from(status(&output) == 2);
        assert_eq!(said.lines().count(), lines, "bit {bit}: {said}");
    }
}
