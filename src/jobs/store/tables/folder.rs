//! The folder of tables: the one place that decides whether a table is read or computed.

use std::fmt;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use serde_json::Value;

use super::arrays::Arrays;
use super::header::CacheHeader;
use super::key::{CacheKind, canonical, key};
use super::mapped::{MappedTable, open_head};
use super::write::write;
use super::{CacheError, CacheFault};

/// How the name of a table file ends.
const EXTENSION: &str = ".table";
/// Digits of the key in a file name. The inputs are compared as well, so that a collision
/// costs a computation and no more.
const DIGITS: usize = 32;
/// A table's time of last use is this exact, to spare the disk.
const USE_RESOLUTION: Duration = Duration::from_secs(3600);

/// A folder of tables. Any number of processes may use one at once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableStore {
    folder: PathBuf,
    /// Whether tables are looked for in the folder and written there.
    keeps: bool,
}

/// A table, and how it was come by.
#[derive(Debug)]
pub struct Fetched {
    /// The table.
    pub table: MappedTable,
    /// Whether it was there.
    pub origin: Origin,
    /// What the user should know.
    pub warnings: Vec<CacheWarning>,
}

/// How a table was come by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// Read from its file.
    Found,
    /// Computed, and kept for the next time.
    Built,
    /// Computed, and lost when it is dropped: it could not be kept, or was not to be.
    BuiltInMemory,
}

/// Something about the cache that does not keep the program from going on; one line each.
#[derive(Debug)]
pub enum CacheWarning {
    /// A file was there but was not read.
    Refused {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: CacheFault,
    },
    /// A computed table could not be kept.
    NotKept {
        /// Why.
        error: CacheError,
    },
}

impl fmt::Display for CacheWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused { path, fault } => {
                write!(f, "`{}` {fault}: it is computed anew", path.display())
            }
            Self::NotKept { error } => {
                write!(f, "a computed table is not kept for the next run: {error}")
            }
        }
    }
}

/// A table file in the folder.
#[derive(Debug)]
pub struct CacheEntry {
    /// The file.
    pub path: PathBuf,
    /// Its length \[bytes\].
    pub bytes: u64,
    /// When it was last made or read, to an hour.
    pub used: SystemTime,
    /// Its header, whose checksum holds (that of the data is not looked at), or what is wrong.
    pub header: Result<CacheHeader, CacheFault>,
}

/// Tables to remove.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unwanted {
    /// Those that this program cannot read.
    Unusable,
    /// These, and those not used since.
    UnusedSince(SystemTime),
    /// Every table.
    All,
}

/// What was removed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Cleaned {
    /// The files.
    pub files: Vec<PathBuf>,
    /// Their length \[bytes\].
    pub bytes: u64,
}

impl TableStore {
    /// A store in a folder, which is created when the first table is kept.
    pub fn open(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            keeps: true,
        }
    }

    /// A store without a folder: every table is computed, and lost when it is dropped.
    pub fn in_memory() -> Self {
        Self {
            folder: PathBuf::new(),
            keeps: false,
        }
    }

    /// Where the tables lie.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file of a table.
    ///
    /// `inputs` is everything that decides the content, with the version of the method where
    /// that can change; JSON has no number that is not finite, and turns one into null.
    pub fn path(&self, kind: CacheKind, inputs: &Value) -> PathBuf {
        self.path_of(kind, &canonical(inputs))
    }

    fn path_of(&self, kind: CacheKind, inputs: &str) -> PathBuf {
        let digits = &key(kind, inputs)[..DIGITS];
        self.folder
            .join(format!("{}-{digits}{EXTENSION}", kind.name()))
    }

    /// The table of these inputs (see [`TableStore::path`]): the one on disk if there is one
    /// and every byte of it is right, else the one that `build` computes, which is kept.
    ///
    /// # Errors
    /// Those of `build`, and no others: a cache that cannot be read or written costs time, is
    /// told in the warnings, and stops nobody.
    pub fn get_or_build<E>(
        &self,
        kind: CacheKind,
        inputs: &Value,
        build: impl FnOnce() -> Result<Arrays, E>,
    ) -> Result<Fetched, E> {
        let inputs = canonical(inputs);
        let path = self.path_of(kind, &inputs);
        let mut warnings = Vec::new();
        if !self.keeps {
            return Ok(Fetched {
                table: MappedTable::in_memory(kind, inputs, build()?),
                origin: Origin::BuiltInMemory,
                warnings,
            });
        }
        match MappedTable::open_as(&path, kind, &inputs) {
            Ok(table) => {
                note_use(&path);
                return Ok(Fetched {
                    table,
                    origin: Origin::Found,
                    warnings,
                });
            }
            Err(CacheFault::Missing) => {}
            Err(fault) => {
                let path = path.clone();
                warnings.push(CacheWarning::Refused { path, fault });
            }
        }
        let arrays = build()?;
        let (table, origin) = match self.keep(&path, kind, &inputs, &arrays) {
            Ok(table) => (table, Origin::Built),
            Err(error) => {
                warnings.push(CacheWarning::NotKept { error });
                let table = MappedTable::in_memory(kind, inputs, arrays);
                (table, Origin::BuiltInMemory)
            }
        };
        Ok(Fetched {
            table,
            origin,
            warnings,
        })
    }

    /// Writes a table and reads it back, so that from now on its memory is shared.
    fn keep(
        &self,
        path: &Path,
        kind: CacheKind,
        inputs: &str,
        arrays: &Arrays,
    ) -> Result<MappedTable, CacheError> {
        write(&self.folder, path, kind, inputs, arrays)?;
        MappedTable::open_as(path, kind, inputs).map_err(|fault| CacheError::NotReadBack {
            path: path.to_path_buf(),
            fault,
        })
    }

    /// The tables of the folder by file name; none where there is no folder. Files with other
    /// names are passed over.
    ///
    /// # Errors
    /// The folder cannot be listed.
    pub fn entries(&self) -> Result<Vec<CacheEntry>, CacheError> {
        let mut entries = Vec::new();
        for path in self.files()? {
            // Removed in the meantime: no longer an entry.
            let Ok(metadata) = fs::metadata(&path) else {
                continue;
            };
            entries.push(CacheEntry {
                bytes: metadata.len(),
                used: metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH),
                header: open_head(&path).map(|head| head.header),
                path,
            });
        }
        Ok(entries)
    }

    /// The file that a user means: a path, or the first digits of a key, with or without its
    /// kind.
    ///
    /// # Errors
    /// None or several fit, or the folder cannot be listed.
    pub fn find(&self, wanted: &str) -> Result<PathBuf, CacheError> {
        if Path::new(wanted).is_file() {
            return Ok(wanted.into());
        }
        let fits = |path: &PathBuf| {
            let (name, digits) = (file_name(path), digits(file_name(path)));
            !wanted.is_empty()
                && (name.starts_with(wanted) || digits.is_some_and(|d| d.starts_with(wanted)))
        };
        let mut found = self.files()?;
        found.retain(fits);
        match &found[..] {
            [] => Err(CacheError::Unknown {
                wanted: wanted.into(),
                folder: self.folder.clone(),
            }),
            [one] => Ok(one.clone()),
            _ => Err(CacheError::Ambiguous {
                wanted: wanted.into(),
                found: found.iter().map(|path| file_name(path).into()).collect(),
            }),
        }
    }

    /// Removes tables, and what killed processes left unfinished. Processes that have one of
    /// them open keep it.
    ///
    /// # Errors
    /// The folder cannot be listed, or a file cannot be removed.
    pub fn clean(&self, unwanted: Unwanted) -> Result<Cleaned, CacheError> {
        let mut cleaned = Cleaned::default();
        for entry in self.entries()? {
            let remove = match unwanted {
                Unwanted::All => true,
                Unwanted::UnusedSince(since) if entry.used < since => true,
                _ => MappedTable::open(&entry.path).is_err(),
            };
            if remove {
                fs::remove_file(&entry.path)
                    .map_err(|error| CacheError::io(&entry.path, "remove", error))?;
                cleaned.bytes += entry.bytes;
                cleaned.files.push(entry.path);
            }
        }
        // What cannot be listed or removed does no harm.
        _ = crate::store::file::remove_stale(&self.folder);
        Ok(cleaned)
    }

    /// Files that are named like tables, sorted.
    fn files(&self) -> Result<Vec<PathBuf>, CacheError> {
        let refused = |error| CacheError::io(&self.folder, "read", error);
        let entries = match fs::read_dir(&self.folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(refused(error)),
        };
        let mut files = Vec::new();
        for entry in entries {
            let path = entry.map_err(refused)?.path();
            if digits(file_name(&path)).is_some() {
                files.push(path);
            }
        }
        files.sort();
        Ok(files)
    }
}

fn file_name(path: &Path) -> &str {
    path.file_name()
        .and_then(|name| name.to_str())
        .unwrap_or_default()
}

/// The digits of the key in a table's file name; none where it is not one. Kinds of later
/// versions count as well.
fn digits(name: &str) -> Option<&str> {
    let (kind, digits) = name.strip_suffix(EXTENSION)?.rsplit_once('-')?;
    let is_kind = !kind.is_empty() && kind.bytes().all(|b| b.is_ascii_lowercase() || b == b'-');
    let is_key = digits.len() == DIGITS
        && (digits.bytes()).all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b));
    (is_kind && is_key).then_some(digits)
}

/// Makes the time of last use now. That it cannot (another user's file) matters to nobody but
/// `clean`.
fn note_use(path: &Path) {
    let Ok(file) = File::open(path) else { return };
    let used = file.metadata().and_then(|metadata| metadata.modified());
    let recent = |time: SystemTime| time.elapsed().is_ok_and(|age| age < USE_RESOLUTION);
    if !used.is_ok_and(recent) {
        _ = file.set_modified(SystemTime::now());
    }
}
