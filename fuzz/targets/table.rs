//! Kept tables: a damaged one is refused and built again, and no reader reads beyond the file.

use super::right;
use super::scratch::{OSCILLATOR, empty, folder, put};
use gearatlas::manifest::parse;
use gearatlas::model::Model;
use gearatlas::report::{TableSummary, drawable};
use gearatlas::store::{KernelArrays, TableStore};
use gearatlas::sweep::Prepared;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

/// Bytes before the checksummed part of a file, and position of the checksum.
const CHECKED: usize = 48;
const CHECKSUM: usize = 16;

/// A model, and a table of its closed modes.
struct Truth {
    model: Model,
    bytes: Vec<u8>,
    numbers: Vec<(String, Vec<u64>)>,
}

static TRUTH: LazyLock<Truth> = LazyLock::new(|| {
    let job = parse(OSCILLATOR, "m.toml", &folder()).expect("a manifest");
    let here = empty("tables-of-truth");
    let store = TableStore::open(&here);
    let model = (Prepared::new(TableStore::open(&here)).model(&job.points.at(0))).expect("a model");
    let fetched = store.systems(&model).expect("tables");
    Truth {
        bytes: fs::read(&fetched.file).expect("its file"),
        numbers: numbers(&fetched.table),
        model,
    }
});

fn numbers(table: &KernelArrays) -> Vec<(String, Vec<u64>)> {
    let arrays = table.all().iter();
    arrays
        .map(|array| {
            let bits = array.values.iter().map(|value| value.to_bits());
            (array.name.clone(), bits.collect())
        })
        .collect()
}

/// A table with any bytes: the kernel gets the computed numbers.
pub fn table(data: &[u8]) {
    let here = empty("tables");
    let store = TableStore::open(&here);
    let path = store.systems_path(&TRUTH.model);
    put(&path, data);
    look(&path);
    let fetched = store.systems(&TRUTH.model).expect("tables");
    right(numbers(&fetched.table) == TRUTH.numbers, || {
        format!("{:?}: other numbers", fetched.origin)
    });
}

/// A table with a valid checksum for any bytes.
pub fn sealed(data: &[u8]) {
    let here = empty("tables");
    let path = here.join("any.table");
    let mut bytes = data.to_vec();
    if let Some((head, rest)) = bytes.split_at_mut_checked(CHECKED) {
        head[CHECKSUM..].copy_from_slice(blake3::hash(rest).as_bytes());
    }
    put(&path, &bytes);
    look(&path);
}

/// Reads all parts of a file that is accepted as a table.
fn look(path: &Path) {
    // A mesh table can be drawn; any other file is refused.
    _ = drawable(path);
    let Ok(summary) = TableSummary::read(path) else {
        return;
    };
    right(!summary.render().is_empty(), || {
        "a summary without words".into()
    });
    let length = fs::metadata(path).expect("a file").len();
    right(summary.bytes <= length, || {
        format!("{} bytes of numbers in {length}", summary.bytes)
    });
}

/// The unchanged table.
pub fn seeds() -> Vec<Vec<u8>> {
    vec![TRUTH.bytes.clone()]
}
