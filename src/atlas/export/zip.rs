//! An archive of files as they are (ZIP, method `stored`), whose sizes are known before their bytes.
//!
//! Every entry and the archive itself have the records of sizes above 4 GiB (ZIP64), so that there
//! is one layout for all. Entries carry no time.

use super::region::{Places, Region};
use crate::store::StoreError;
use crc32fast::Hasher;

/// Version of the format that knows ZIP64.
const VERSION: u16 = 45;

/// 1980-01-01, the earliest day of the format.
const DAY: u16 = 0x21;

/// Bytes of the head of an entry without its name.
const HEAD: u64 = 30 + EXTRA;

/// Bytes of both sizes with their tag.
const EXTRA: u64 = 20;

/// A file in the archive.
pub struct Entry {
    name: String,
    start: u64,
    size: u64,
    region: Region,
    hasher: Hasher,
}

impl Entry {
    /// Writes behind what it holds.
    pub fn append(&mut self, places: &Places<'_>, bytes: &[u8]) -> Result<(), StoreError> {
        self.hasher.update(bytes);
        self.region.append(places, bytes)
    }
}

/// Lays files out one behind the other: `(name, size)`.
pub fn lay_out(files: impl IntoIterator<Item = (String, u64)>) -> Vec<Entry> {
    let mut start = 0;
    let mut entries = Vec::new();
    for (name, size) in files {
        let data = start + HEAD + name.len() as u64;
        entries.push(Entry {
            name,
            start,
            size,
            region: Region::at(data),
            hasher: Hasher::new(),
        });
        start = data + size;
    }
    entries
}

/// Writes what stands before and behind the files, all of them being whole.
pub fn finish(entries: Vec<Entry>, places: &Places<'_>) -> Result<(), StoreError> {
    let count = entries.len() as u64;
    let last = entries.last();
    let directory = last.map_or(0, |last| {
        last.start + HEAD + last.name.len() as u64 + last.size
    });
    let mut tail = Vec::new();
    for entry in entries {
        let crc = entry.hasher.finalize();
        let name = entry.name.as_bytes();
        let mut head = Vec::new();
        put(&mut head, &[&0x0403_4b50_u32.to_le_bytes()]);
        put(
            &mut head,
            &[&description(crc, name), &(EXTRA as u16).to_le_bytes(), name],
        );
        put(
            &mut head,
            &[
                &sizes(16),
                &entry.size.to_le_bytes(),
                &entry.size.to_le_bytes(),
            ],
        );
        places.write(entry.start, &head)?;

        put(
            &mut tail,
            &[&0x0201_4b50_u32.to_le_bytes(), &VERSION.to_le_bytes()],
        );
        put(&mut tail, &[&description(crc, name), &28_u16.to_le_bytes()]);
        // No comment, first disk, no attributes, and the place of the head in the extra field.
        put(
            &mut tail,
            &[&[0; 10], &u32::MAX.to_le_bytes(), name, &sizes(24)],
        );
        put(
            &mut tail,
            &[
                &entry.size.to_le_bytes(),
                &entry.size.to_le_bytes(),
                &entry.start.to_le_bytes(),
            ],
        );
    }
    let (length, end) = (tail.len() as u64, directory + tail.len() as u64);
    put(
        &mut tail,
        &[&0x0606_4b50_u32.to_le_bytes(), &44_u64.to_le_bytes()],
    );
    put(
        &mut tail,
        &[&VERSION.to_le_bytes(), &VERSION.to_le_bytes(), &[0; 8]],
    );
    put(
        &mut tail,
        &[
            &count.to_le_bytes(),
            &count.to_le_bytes(),
            &length.to_le_bytes(),
            &directory.to_le_bytes(),
        ],
    );
    put(
        &mut tail,
        &[
            &0x0706_4b50_u32.to_le_bytes(),
            &[0; 4],
            &end.to_le_bytes(),
            &1_u32.to_le_bytes(),
        ],
    );
    put(
        &mut tail,
        &[
            &0x0605_4b50_u32.to_le_bytes(),
            &[0; 4],
            &[0xff; 12],
            &[0; 2],
        ],
    );
    places.write(directory, &tail)
}

/// What the head of an entry and the directory both say: version, UTF-8, stored, day, checksum, sizes
/// in the extra field, length of the name.
fn description(crc: u32, name: &[u8]) -> [u8; 24] {
    let mut said = Vec::with_capacity(24);
    put(
        &mut said,
        &[
            &VERSION.to_le_bytes(),
            &0x0800_u16.to_le_bytes(),
            &[0; 4],
            &DAY.to_le_bytes(),
        ],
    );
    put(
        &mut said,
        &[
            &crc.to_le_bytes(),
            &[0xff; 8],
            &(name.len() as u16).to_le_bytes(),
        ],
    );
    let mut bytes = [0; 24];
    bytes.copy_from_slice(&said);
    bytes
}

/// Tag and length of the extra field of ZIP64.
fn sizes(length: u16) -> [u8; 4] {
    let [low, high] = length.to_le_bytes();
    [1, 0, low, high]
}

fn put(text: &mut Vec<u8>, parts: &[&[u8]]) {
    parts.iter().for_each(|part| text.extend_from_slice(part));
}
