//! Results of a million points, drawn by the real program: in seconds, with the memory of a small machine.

#![allow(clippy::unwrap_used)]

use crate::place;
use arrow_array::{ArrayRef, Float64Array, RecordBatch, UInt32Array, UInt64Array};
use arrow_select::take::take;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::metadata::KeyValue;
use place::{OSCILLATOR, Place, status, stderr, stdout};
use std::fs::{self, File};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

const POINTS: usize = 1_000_000;
/// Rows per write.
const PIECE: usize = 50_000;

/// Time limit for a picture or a page of a million points on a busy machine.
const LONGEST: Duration = Duration::from_secs(60);
/// Limit of memory \[bytes\].
const MOST_MEMORY: u64 = 480 << 20;
/// Largest size of a picture \[bytes\].
const LARGEST: u64 = 2 << 20;

/// A folder with repeated rows of a small run, at `loads` loads and different speeds, without a record.
fn tiled(place: &Place, loads: usize) {
    place.whole("small", &[]);
    let file = File::open(place.path("small/points.parquet")).unwrap();
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).unwrap();
    let schema = builder.schema().clone();
    let told = builder
        .metadata()
        .file_metadata()
        .key_value_metadata()
        .cloned();
    let own: Vec<RecordBatch> = builder.build().unwrap().map(Result::unwrap).collect();
    let own = &own[0];
    fs::create_dir(place.path("many")).unwrap();
    let sink = File::create(place.path("many/points.parquet")).unwrap();
    let mut writer = ArrowWriter::try_new(sink, schema.clone(), None).unwrap();
    for KeyValue { key, value } in told.unwrap() {
        if key != "ARROW:schema" {
            writer.append_key_value_metadata(KeyValue { key, value });
        }
    }
    let speeds = POINTS / loads;
    for first in (0..POINTS).step_by(PIECE) {
        let ids = || first..first + PIECE;
        let rows: UInt32Array = ids().map(|id| (id % own.num_rows()) as u32).collect();
        let columns =
            own.columns()
                .iter()
                .zip(schema.fields())
                .map(|(column, field)| -> ArrayRef {
                    match field.name().as_str() {
                        "point_id" => {
                            Arc::new(ids().map(|id| Some(id as u64)).collect::<UInt64Array>())
                        }
                        "load" => Arc::new(
                            ids()
                                .map(|id| Some(0.1 + (id / speeds) as f64 * 1e-3))
                                .collect::<Float64Array>(),
                        ),
                        "speed" => Arc::new(
                            ids()
                                .map(|id| Some(500.0 + (id % speeds) as f64 * 1e-2))
                                .collect::<Float64Array>(),
                        ),
                        _ => take(column, &rows, None).unwrap(),
                    }
                });
        let batch = RecordBatch::try_new(schema.clone(), columns.collect()).unwrap();
        writer.write(&batch).unwrap();
    }
    writer.close().unwrap();
}

/// Runs `atlas` and returns the time and the peak memory \[bytes\].
fn measured(place: &Place, arguments: &[&str]) -> (Duration, u64) {
    let said = place.path("said");
    let mut process = Command::new(env!("CARGO_BIN_EXE_atlas"))
        .current_dir(place.path(""))
        .args(arguments)
        .stdout(File::create(&said).unwrap())
        .stderr(Stdio::inherit())
        .spawn()
        .unwrap();
    let clock = Instant::now();
    let mut most = 0;
    while process.try_wait().unwrap().is_none() {
        let now = fs::read_to_string(format!("/proc/{}/status", process.id())).unwrap_or_default();
        let line = now.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kibibytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        most = most.max(kibibytes.unwrap_or(0) << 10);
        if clock.elapsed() > LONGEST {
            process.kill().unwrap();
        }
        sleep(Duration::from_millis(20));
    }
    assert!(
        process.wait().unwrap().success(),
        "after {:?}",
        clock.elapsed()
    );
    (clock.elapsed(), most)
}

#[test]
fn a_million_points_are_drawn() {
    let place = Place::new(OSCILLATOR);
    tiled(&place, 1000);
    let page = measured(&place, &["report", "many", "--out", "page.html"]);
    let what = "lambda,classes,deflection_rms";
    let pictures = measured(
        &place,
        &["plot", "many", "--what", what, "--out", "pictures"],
    );
    for (took, memory) in [page, pictures] {
        assert!(
            took < LONGEST && memory < MOST_MEMORY,
            "{took:?}, {memory} bytes"
        );
    }
    for picture in fs::read_dir(place.path("pictures")).unwrap() {
        let picture = picture.unwrap();
        let size = picture.metadata().unwrap().len();
        assert!(size < LARGEST, "{:?}: {size} bytes", picture.file_name());
    }
    let said = fs::read_to_string(place.path("said")).unwrap();
    assert!(said.contains(".svg") && said.contains(".png"), "{said}");
    assert!(said.contains("that lie within a pixel of others"), "{said}");
}

#[test]
fn of_few_points_none_is_left_out() {
    let place = Place::new(OSCILLATOR);
    place.whole("small", &[]);
    let output = place.atlas(&["plot", "small", "--out", "pictures"]);
    assert_eq!(status(&output), 0, "{}", stderr(&output));
    let said = stdout(&output);
    assert!(
        !said.contains("within a pixel"),
        "six points are all drawn: {said}"
    );
}
