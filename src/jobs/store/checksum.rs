//! Are the bytes of a result file those that were written?
//!
//! A table is hashed while it is written. `run.json` keeps the hash beside name and size, and ends in a hash
//! of its text. Readers first compare a file with its record, because decoding detects few of the bits that a
//! disk, a copy or an editor changes.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::StoreError;
use super::error::Damage;

/// A table's file as written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableRecord {
    /// Path in the results folder, such as `points.parquet`.
    pub name: String,
    /// Number of rows.
    pub rows: u64,
    /// Size \[bytes\].
    pub bytes: u64,
    /// BLAKE3 of the bytes, hexadecimal.
    pub blake3: String,
}

/// A sink that hashes the bytes written to it.
pub(super) struct Hashed<W> {
    pub(super) sink: W,
    hasher: blake3::Hasher,
}

impl<W> Hashed<W> {
    pub(super) fn new(sink: W) -> Self {
        let hasher = blake3::Hasher::new();
        Self { sink, hasher }
    }

    /// The record of the bytes so far, as the file `path` in `folder` with `rows` rows.
    pub(super) fn record(&self, folder: &Path, path: &Path, rows: u64) -> TableRecord {
        TableRecord {
            name: name_in(folder, path),
            rows,
            bytes: self.hasher.count(),
            blake3: self.hasher.finalize().to_hex().to_string(),
        }
    }
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.sink.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

/// The records of the tables of some results. While `--retry` replaces tables, a name occurs twice, and the
/// file agrees with one of the two records.
#[derive(Debug, Clone, Copy)]
pub(super) struct RecordedTables<'a> {
    pub folder: &'a Path,
    pub tables: &'a [TableRecord],
}

impl RecordedTables<'_> {
    /// Whether a record lists a table of this path.
    pub(super) fn lists(&self, path: &Path) -> bool {
        self.of(path).next().is_some()
    }

    fn of(&self, path: &Path) -> impl Iterator<Item = &TableRecord> {
        let name = name_in(self.folder, path);
        (self.tables.iter()).filter(move |table| table.name == name)
    }

    /// All files in the records, sorted.
    pub(super) fn paths(&self) -> Vec<PathBuf> {
        let mut paths: Vec<PathBuf> = (self.tables.iter())
            .map(|table| self.folder.join(&table.name))
            .collect();
        paths.sort();
        paths.dedup();
        paths
    }

    /// Opens a table after comparing all of it with its record.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] if it is missing, has no record or differs from it; or it cannot be read.
    pub(super) fn open(&self, path: &Path) -> Result<File, StoreError> {
        let damaged = |damage| StoreError::Damaged {
            path: path.to_path_buf(),
            damage,
        };
        let refused = |source| StoreError::io(path, "read", source);
        let size = match fs::metadata(path) {
            Ok(metadata) if metadata.is_file() => metadata.len(),
            Ok(_) => return Err(damaged(Damage::NoFile)),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                return Err(damaged(Damage::Gone));
            }
            Err(source) => return Err(refused(source)),
        };
        let file = File::open(path).map_err(refused)?;
        let Some(first) = self.of(path).next() else {
            return Err(damaged(Damage::Unrecorded));
        };
        if self.of(path).all(|table| table.bytes != size) {
            return Err(damaged(Damage::Size {
                found: size,
                written: first.bytes,
            }));
        }
        let found = hash(&file).map_err(refused)?;
        if self.of(path).all(|table| table.blake3 != found) {
            return Err(damaged(Damage::Changed {
                found,
                written: first.blake3.clone(),
            }));
        }
        Ok(file)
    }
}

/// A file's path relative to its results folder.
fn name_in(folder: &Path, path: &Path) -> String {
    let name = path.strip_prefix(folder).unwrap_or(path);
    name.to_string_lossy().into_owned()
}

/// BLAKE3 of a whole file, hexadecimal. The file is then at its start again.
fn hash(mut file: &File) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    let mut buffer = vec![0; 1 << 17];
    loop {
        match file.read(&mut buffer) {
            Ok(0) => break,
            Ok(read) => _ = hasher.update(&buffer[..read]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    io::Seek::rewind(&mut file)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// The text before the hash and after it.
const SEAL: [&str; 2] = [",\n  \"blake3\": \"", "\"\n}\n"];

/// Adds a last key to an indented JSON object: the hash of all text before this key.
pub(super) fn sealed(json: &str) -> String {
    let text = json.trim_end().trim_end_matches('}').trim_end();
    let hash = blake3::hash(text.as_bytes()).to_hex();
    format!("{text}{}{hash}{}", SEAL[0], SEAL[1])
}

/// Whether a text ends in the hash of the text before it.
pub(super) fn is_sealed(text: &[u8]) -> bool {
    let body = text.strip_suffix(SEAL[1].as_bytes());
    let parts = body.and_then(|body| body.split_last_chunk::<64>());
    let Some((body, hash)) = parts.map(|(body, hash)| (body, &hash[..])) else {
        return false;
    };
    body.strip_suffix(SEAL[0].as_bytes())
        .is_some_and(|body| blake3::hash(body).to_hex().as_bytes() == hash)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flipped_bit_of_a_text_breaks_its_seal() {
        let json = "{\n  \"job\": \"x}\",\n  \"totals\": {\n    \"points\": 3\n  }\n}";
        let text = sealed(json);
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(value["totals"]["points"], 3);
        assert_eq!(value["blake3"].as_str().unwrap().len(), 64);
        assert!(is_sealed(text.as_bytes()));
        for bit in 0..8 * text.len() {
            let mut bytes = text.clone().into_bytes();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(!is_sealed(&bytes), "bit {bit}");
        }
        for end in 0..text.len() {
            assert!(!is_sealed(&text.as_bytes()[..end]), "cut at {end}");
        }
    }

    #[test]
    fn what_is_hashed_while_written_is_what_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.parquet");
        let mut sink = Hashed::new(File::create(&path).unwrap());
        for piece in 0..100_u32 {
            sink.write_all(&vec![piece as u8; 5000]).unwrap();
        }
        let tables = [sink.record(folder.path(), &path, 7)];
        assert_eq!((&*tables[0].name, tables[0].bytes), ("t.parquet", 500_000));
        let recorded = RecordedTables {
            folder: folder.path(),
            tables: &tables,
        };
        let mut bytes = Vec::new();
        recorded
            .open(&path)
            .unwrap()
            .read_to_end(&mut bytes)
            .unwrap();
        assert_eq!(bytes.len(), 500_000, "read from its beginning");
        let damage = |bytes: &[u8]| {
            fs::write(&path, bytes).unwrap();
            match recorded.open(&path) {
                Err(StoreError::Damaged { damage, .. }) => damage,
                other => panic!("{other:?}"),
            }
        };
        assert!(matches!(damage(&bytes[1..]), Damage::Size { .. }));
        bytes[77_777] ^= 1;
        assert!(matches!(damage(&bytes), Damage::Changed { .. }));
        fs::remove_file(&path).unwrap();
        let message = recorded.open(&path).unwrap_err().to_string();
        assert!(message.contains("t.parquet` is damaged") && message.contains("--overwrite"));
    }
}
