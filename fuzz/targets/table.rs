//! Kept tables: a damaged one is refused and built again, and no reader leaves the file.

use super::right;
use super::scratch::{OSCILLATOR, empty, folder, put};
use gearatlas::manifest::parse;
use gearatlas::model::Model;
use gearatlas::propagate::{KeptTables, KernelTable};
use gearatlas::report::TableSummary;
use gearatlas::store::{MappedTable, TableStore};
use gearatlas::sweep::Parts;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

/// A model, and a table of its systems.
struct Truth {
    model: Model,
    bytes: Vec<u8>,
    numbers: Vec<(String, Vec<u64>)>,
}

static TRUTH: LazyLock<Truth> = LazyLock::new(|| {
    let job = parse(OSCILLATOR, "m.toml", &folder()).expect("a manifest");
    let here = empty("tables-of-truth");
    let store = TableStore::open(&here);
    let model = (Parts::new(TableStore::open(&here)).model(&job.points.at(0))).expect("a model");
    let fetched = (store.kernel_table(KernelTable::Systems, &model)).expect("tables");
    Truth {
        bytes: fs::read(store.kernel_table_path(KernelTable::Systems, &model)).expect("its file"),
        numbers: numbers(&fetched.table),
        model,
    }
});

fn numbers(table: &MappedTable) -> Vec<(String, Vec<u64>)> {
    let bits = |name: &str| {
        let values = table.numbers(name).unwrap_or_default().iter();
        (
            name.to_owned(),
            values.map(|value| value.to_bits()).collect(),
        )
    };
    table.names().map(bits).collect()
}

/// A table as it lies on the disk: the numbers that a kernel gets are those that were computed.
pub fn table(data: &[u8]) {
    let here = empty("tables");
    let store = TableStore::open(&here);
    let path = store.kernel_table_path(KernelTable::Systems, &TRUTH.model);
    put(&path, data);
    look(&path);
    right(store.entries().is_ok(), || {
        "a folder that cannot be listed".into()
    });
    let fetched = (store.kernel_table(KernelTable::Systems, &TRUTH.model)).expect("tables");
    right(numbers(&fetched.table) == TRUTH.numbers, || {
        format!("{:?}: other numbers", fetched.origin)
    });
}

/// A table whose checksums are made to fit whatever its bytes are.
pub fn sealed(data: &[u8]) {
    let here = empty("tables");
    let path = TableStore::open(&here).kernel_table_path(KernelTable::Systems, &TRUTH.model);
    put(&path, &with_checksums(data).unwrap_or_default());
    look(&path);
}

/// Reads all there is of a file that passes for a table.
fn look(path: &Path) {
    if let Ok(summary) = TableSummary::read(path) {
        right(!summary.render().is_empty(), || {
            "a summary without words".into()
        });
    }
    let Ok(table) = MappedTable::open(path) else {
        return;
    };
    let mut bytes = 0;
    for name in table.names() {
        let (shape, values) = table.array(name).expect("an array of its own");
        right(shape.iter().product::<usize>() == values.len(), || {
            format!("{name}: {shape:?}, {} numbers", values.len())
        });
        bytes += size_of_val(values);
    }
    right(bytes == table.bytes(), || {
        format!("{bytes} bytes of {}", table.bytes())
    });
    right(
        bytes as u64 <= fs::metadata(path).expect("a file").len(),
        || "more numbers than bytes".into(),
    );
    let copied = table.copied().map(|copy| numbers(&copy));
    right(
        copied.is_none_or(|copied| copied == numbers(&table)),
        || "a copy differs".into(),
    );
}

/// The file with the checksums of its data and of what comes before them put right, where it is long
/// enough to have any.
fn with_checksums(data: &[u8]) -> Option<Vec<u8>> {
    const PRELUDE: usize = 64;
    let mut bytes = data.to_vec();
    let length = |at: usize| {
        let number = data.get(at..at + 8)?.try_into().ok()?;
        usize::try_from(u64::from_ne_bytes(number)).ok()
    };
    let header = length(16)?;
    let front = PRELUDE.checked_add(header)?.checked_add(length(24)?)?;
    let start = front.checked_next_multiple_of(PRELUDE)?;
    let sum = blake3::hash(data.get(start..)?).to_hex();
    let text = bytes.get(PRELUDE..PRELUDE.checked_add(header)?)?;
    const KEY: &[u8] = b"\"data\":\"";
    if let Some(at) = text.windows(KEY.len()).position(|window| window == KEY) {
        let at = PRELUDE + at + KEY.len();
        bytes
            .get_mut(at..at + sum.len())?
            .copy_from_slice(sum.as_bytes());
    }
    let mut hash = blake3::Hasher::new();
    hash.update(&bytes[..32]);
    hash.update(&bytes[PRELUDE..start]);
    bytes[32..PRELUDE].copy_from_slice(hash.finalize().as_bytes());
    Some(bytes)
}

/// The table as it was written.
pub fn seeds() -> Vec<Vec<u8>> {
    vec![TRUTH.bytes.clone()]
}
