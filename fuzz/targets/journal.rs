//! Journals: for any bytes on the disk, only appended points come back.

use super::right;
use super::scratch::{OSCILLATOR, empty, folder};
use gearatlas::manifest::{Job, parse};
use gearatlas::store::{Journal, PointRow, TableStore, journal_path};
use gearatlas::sweep::{ChainState, Prepared, Worker, compute};
use std::fs;
use std::sync::LazyLock;
use std::sync::atomic::AtomicBool;

/// A job, its first points, and the journal with them.
struct Truth {
    job: Job,
    rows: Vec<PointRow>,
    bytes: Vec<u8>,
    /// Position of its first point.
    points: usize,
}

static TRUTH: LazyLock<Truth> = LazyLock::new(|| {
    let folder = folder();
    let job = parse(OSCILLATOR, "m.toml", &folder).expect("a manifest");
    let parts = Prepared::new(TableStore::open(folder.join("tables")));
    let worker = Worker {
        index: 0,
        topology: None,
        seat: None,
    };
    let rows: Vec<PointRow> = (0..3)
        .map(|id| {
            let point = job.points.at(id);
            let go_on = AtomicBool::new(false);
            let mut row = compute(&job, &point, &ChainState::default(), &parts, worker, &go_on)
                .expect("nobody calls it off");
            // Short records.
            row.outcome.poincare.clear();
            row.outcome.spectra.clear();
            row.outcome.orders.clear();
            // A journal of another process is also valid.
            row.placement.wall_time = 0.0;
            row
        })
        .collect();
    let here = empty("journal-of-truth");
    let mut journal = Journal::open(&here, &job.hash, None, true).expect("a journal");
    let read = || fs::read(journal_path(&here, None)).expect("a journal");
    let points = read().len();
    for row in &rows {
        journal.append(row).expect("a journal");
    }
    Truth {
        bytes: read(),
        points,
        job,
        rows,
    }
});

/// A journal with any bytes.
pub fn journal(data: &[u8]) {
    let found = replayed(data);
    for row in &found {
        let known = TRUTH.rows.contains(row);
        right(known, || format!("a point that nobody appended: {row:?}"));
    }
}

/// The payload of a point's record, in a valid frame after a valid header.
pub fn sealed(data: &[u8]) {
    let mut bytes = TRUTH.bytes[..TRUTH.points].to_vec();
    bytes.extend((data.len() as u64).to_le_bytes());
    bytes.extend(&blake3::hash(data).as_bytes()[..8]);
    bytes.extend(data);
    right(replayed(&bytes).len() <= 1, || {
        "two points of a record".into()
    });
}

/// The points of a journal with some bytes: the same when read twice, and with one more at the end after it is
/// appended.
fn replayed(bytes: &[u8]) -> Vec<PointRow> {
    let here = empty("journal");
    fs::write(journal_path(&here, None), bytes).expect("a folder of its own");
    let Ok(mut journal) = Journal::open(&here, &TRUTH.job.hash, None, false) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let take = |into: &mut Vec<PointRow>, journal: &mut Journal| {
        journal.replay(|row| {
            into.push(row);
            Ok(())
        })
    };
    take(&mut found, &mut journal).expect("a file that can be read");
    journal
        .append(&TRUTH.rows[0])
        .expect("a file that can be written");
    drop(journal);
    let mut journal = Journal::open(&here, &TRUTH.job.hash, None, false).expect("its own journal");
    let mut again = Vec::new();
    take(&mut again, &mut journal).expect("a file that can be read");
    let last = again.pop();
    right(last.as_ref() == Some(&TRUTH.rows[0]), || {
        format!("appended {last:?}")
    });
    // NaN is not equal to itself.
    right(format!("{again:?}") == format!("{found:?}"), || {
        format!("{} points, then {}", found.len(), again.len())
    });
    found
}

/// A complete journal, one that ends early, one with a point twice.
pub fn seeds() -> Vec<Vec<u8>> {
    let whole = &TRUTH.bytes;
    let twice = [whole, &whole[TRUTH.points..]].concat();
    vec![
        whole.clone(),
        whole[..whole.len() - 7].to_vec(),
        whole[..TRUTH.points].to_vec(),
        twice,
    ]
}

/// The payloads of its points.
pub fn sealed_seeds() -> Vec<Vec<u8>> {
    const FRAME: usize = 16;
    let mut rest = &TRUTH.bytes[TRUTH.points..];
    let mut found = Vec::new();
    while let Some((length, _)) = rest.split_first_chunk::<8>() {
        let end = FRAME + u64::from_le_bytes(*length) as usize;
        found.push(rest[FRAME..end].to_vec());
        rest = &rest[end..];
    }
    found
}
