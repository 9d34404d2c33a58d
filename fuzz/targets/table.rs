//! Kept tables: a damaged one is refused and built again, and no reader leaves the file.

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

/// Bytes in front of the part of a file that its checksum is of, and where the checksum starts.
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

/// A table as it lies on the disk: the numbers that a kernel gets are those that were computed.
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

/// A table whose checksum is made to fit whatever its bytes are.
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

/// Reads all there is of a file that passes for a table.
fn look(path: &Path) {
    // A mesh table can be drawn, any other file is refused.
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

/// The table as it was written.
pub fn seeds() -> Vec<Vec<u8>> {
    vec![TRUTH.bytes.clone()]
}
