//! The cache of computed tables: a folder that may be deleted at any time.
//!
//! A table takes long to compute and is needed again by the next run. Its file is named by a hash of
//! what the table was computed from. The file is written under a temporary name, renamed, and never
//! changed afterwards. A reader takes the whole file into memory and checks every byte before it uses
//! one: what another program does to the file later cannot harm it. A file that is damaged or foreign is
//! computed anew.
//!
//! ```text
//!   0  magic
//!  12  version  u32, little-endian
//!  16  BLAKE3 of what follows
//!  48  header, then content (postcard)
//! ```

use std::fmt;
use std::fs::{File, Permissions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use strum::IntoStaticStr;
use thiserror::Error;

use super::file::partial_file;
use super::io_fault::{IoFault, Purpose};
use super::{ProgramRecord, fsync};
use crate::input;

/// Says what the file is.
const MAGIC: &[u8; 12] = b"atlastbl\x04\x03\x02\x01";
/// Changes whenever the format does.
const VERSION: u32 = 2;
/// Longer files are not read \[bytes\]. Tables of kernels have at most 256 MB.
const MOST_READ: u64 = 1 << 30;
/// Digits of the key in a file name. The inputs are compared as well, so that a collision costs one
/// computation.
const DIGITS: usize = 32;
/// How the name of a table file ends.
pub(super) const EXTENSION: &str = "table";
/// Nobody may write: a table is never changed.
const READ_ONLY: u32 = 0o444;

/// What a table holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum CacheKind {
    /// Mesh stiffness and its companions over a mesh cycle.
    Mesh,
    /// Eigenvectors of each set of closed contacts, of the kernel `closed_modes`.
    Systems,
}

impl CacheKind {
    /// Its name in file names and messages.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A type of table that can be kept.
pub trait CacheContent: Serialize + DeserializeOwned {
    /// What it is called.
    const KIND: CacheKind;

    /// Why no program wrote these numbers together; `None` if one may have.
    fn fault(&self) -> Option<&'static str> {
        None
    }
}

/// What a table file says about itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CacheHeader {
    /// What the table holds.
    pub kind: CacheKind,
    /// Program that computed it.
    pub program: String,
    /// What it was computed from: JSON with sorted keys.
    pub inputs: String,
}

impl CacheHeader {
    /// Hash of kind and inputs: lower-case hexadecimal, 64 digits.
    pub fn key(&self) -> String {
        key(self.kind, &self.inputs)
    }
}

/// What is wrong with a table file, in words that continue a sentence about it.
#[derive(Debug, Error)]
pub enum CacheFault {
    /// There is none.
    #[error("does not exist")]
    Missing,
    /// The system refuses, or it is no regular file.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// Other first bytes.
    #[error("is not a table file of atlas")]
    Magic,
    /// Another version of the format.
    #[error("has format version {found}; this program reads version {known}")]
    Version {
        /// Version of the file.
        found: u32,
        /// Version of this program.
        known: u32,
    },
    /// Some bytes are not those that were written.
    #[error("is cut off or damaged: its checksum does not match")]
    Checksum,
    /// The bytes are those that were written, but no program writes such.
    #[error("has invalid content: {detail}")]
    Content {
        /// What is wrong.
        detail: String,
    },
    /// A table of another kind.
    #[error("contains a {found} table, but a {wanted} table is expected")]
    Kind {
        /// Kind of the file.
        found: &'static str,
        /// Kind asked for.
        wanted: &'static str,
    },
    /// A table of something else.
    #[error("was computed from other inputs")]
    Inputs,
}

impl CacheFault {
    fn content(detail: impl ToString) -> Self {
        Self::Content {
            detail: detail.to_string(),
        }
    }
}

/// A table file in memory, every byte of it checked.
#[derive(Debug)]
pub struct TableFile {
    /// What it says about itself.
    pub header: CacheHeader,
    bytes: Vec<u8>,
    /// Where the content starts.
    content: usize,
}

impl TableFile {
    /// Reads and checks a table file of any kind.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn open(path: &Path) -> Result<Self, CacheFault> {
        let bytes = input::read(path, MOST_READ).map_err(|error| match error.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => CacheFault::Missing,
            _ => CacheFault::Unreadable(error),
        })?;
        Self::of_bytes(bytes)
    }

    fn of_bytes(bytes: Vec<u8>) -> Result<Self, CacheFault> {
        let rest = checked(&bytes)?;
        let (header, content) = postcard::take_from_bytes(rest).map_err(CacheFault::content)?;
        Ok(Self {
            header,
            content: bytes.len() - content.len(),
            bytes,
        })
    }

    /// The table.
    ///
    /// # Errors
    /// It is of another kind, or its numbers do not fit each other.
    pub fn content<T: CacheContent>(&self) -> Result<T, CacheFault> {
        if self.header.kind != T::KIND {
            return Err(CacheFault::Kind {
                found: self.header.kind.name(),
                wanted: T::KIND.name(),
            });
        }
        let bytes = &self.bytes[self.content..];
        let (content, rest): (T, _) =
            postcard::take_from_bytes(bytes).map_err(CacheFault::content)?;
        match content.fault() {
            Some(fault) => Err(CacheFault::content(fault)),
            None if rest.is_empty() => Ok(content),
            None => Err(CacheFault::content("bytes follow the table")),
        }
    }
}

/// What follows the checksum of a file, which is right.
fn checked(bytes: &[u8]) -> Result<&[u8], CacheFault> {
    if MAGIC.starts_with(bytes) {
        return Err(CacheFault::Checksum);
    }
    let rest = bytes.strip_prefix(MAGIC).ok_or(CacheFault::Magic)?;
    let (version, rest) = rest.split_first_chunk().ok_or(CacheFault::Checksum)?;
    let found = u32::from_le_bytes(*version);
    if found != VERSION {
        let known = VERSION;
        return Err(CacheFault::Version { found, known });
    }
    let (sum, rest) = (rest.split_first_chunk::<32>()).ok_or(CacheFault::Checksum)?;
    if blake3::hash(rest) == *sum { Ok(rest) } else { Err(CacheFault::Checksum) }
}

/// The bytes of a table file.
fn encode<T: CacheContent>(inputs: &str, content: &T) -> Result<Vec<u8>, postcard::Error> {
    let header = CacheHeader {
        kind: T::KIND,
        program: ProgramRecord::current().to_string(),
        inputs: inputs.to_owned(),
    };
    let rest = postcard::to_stdvec(&(header, content))?;
    let (version, sum) = (VERSION.to_le_bytes(), blake3::hash(&rest));
    Ok([&MAGIC[..], &version, sum.as_bytes(), &rest].concat())
}

/// JSON in the one form that is hashed: keys sorted, no spaces, numbers in the shortest digits that
/// give the same bits back.
fn canonical(value: &Value) -> String {
    let mut value = value.clone();
    value.sort_all_objects();
    value.to_string()
}

/// Hash of a kind and inputs in canonical form.
fn key(kind: CacheKind, inputs: &str) -> String {
    let mut hash = blake3::Hasher::new();
    // No name of a kind contains the byte 0, so that the parts cannot run into each other.
    hash.update(format!("atlas table 1\0{}\0", kind.name()).as_bytes());
    hash.update(inputs.as_bytes());
    hash.finalize().to_hex().to_string()
}

/// A folder of tables. Any number of processes may use one at once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableStore {
    folder: PathBuf,
    /// Whether tables are looked for in the folder.
    reads: bool,
    /// Whether they are written there.
    keeps: bool,
}

/// A table, and where it came from.
#[derive(Debug)]
pub struct Fetched<T> {
    /// The table.
    pub table: T,
    /// Its file, which exists unless the table was built in memory.
    pub file: PathBuf,
    /// Whether it was there.
    pub origin: Origin,
    /// What the user should know.
    pub warnings: Vec<CacheWarning>,
}

/// Where a table came from.
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
    /// A file was there but was not used.
    Refused {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: CacheFault,
    },
    /// A computed table could not be kept.
    NotKept {
        /// Why.
        error: IoFault,
    },
}

impl fmt::Display for CacheWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused { path, fault } => {
                write!(
                    f,
                    "`{}` {fault}; the table is computed again",
                    path.display()
                )
            }
            Self::NotKept { error } => {
                write!(
                    f,
                    "a computed table cannot be kept for the next run: {error}"
                )
            }
        }
    }
}

impl TableStore {
    /// A store in a folder, which is created when the first table is kept.
    pub fn open(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            reads: true,
            keeps: true,
        }
    }

    /// The tables of a folder in which nothing is ever written: others are computed, and lost when they are dropped.
    pub fn read_only(folder: impl Into<PathBuf>) -> Self {
        Self {
            keeps: false,
            ..Self::open(folder)
        }
    }

    /// A store without a folder: every table is computed, and lost when it is dropped.
    pub fn in_memory() -> Self {
        Self {
            folder: PathBuf::new(),
            reads: false,
            keeps: false,
        }
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
            .join(format!("{}-{digits}.{EXTENSION}", kind.name()))
    }

    /// The table of these inputs (see [`TableStore::path`]): the one on disk if there is one
    /// and every byte of it is right, else the one that `build` computes, which is kept.
    ///
    /// # Errors
    /// Those of `build`, and no others: a cache that cannot be read or written costs time, gives a
    /// warning, and stops nobody.
    pub fn get_or_build<T: CacheContent, E>(
        &self,
        inputs: &Value,
        build: impl FnOnce() -> Result<T, E>,
    ) -> Result<Fetched<T>, E> {
        let inputs = canonical(inputs);
        let file = self.path_of(T::KIND, &inputs);
        let mut warnings = Vec::new();
        let found = if self.reads { read(&file, &inputs) } else { Err(CacheFault::Missing) };
        let (table, origin) = match found {
            Ok(table) => (table, Origin::Found),
            Err(fault) => {
                if !matches!(fault, CacheFault::Missing) {
                    let path = file.clone();
                    warnings.push(CacheWarning::Refused { path, fault });
                }
                let table = build()?;
                let kept = self.keeps.then(|| self.keep(&file, &inputs, &table));
                let origin = match kept {
                    Some(Ok(())) => Origin::Built,
                    Some(Err(error)) => {
                        warnings.push(CacheWarning::NotKept { error });
                        Origin::BuiltInMemory
                    }
                    None => Origin::BuiltInMemory,
                };
                (table, origin)
            }
        };
        Ok(Fetched {
            table,
            file,
            origin,
            warnings,
        })
    }

    /// Writes a table, durably. Of two processes that write the same table at once the second replaces
    /// the first's file by an equal one.
    fn keep<T: CacheContent>(&self, path: &Path, inputs: &str, table: &T) -> Result<(), IoFault> {
        let folder = &*self.folder;
        let fault = |path: &Path, action, error| IoFault::new(path, action, Purpose::Tables, error);
        fsync::create_folder(folder).map_err(|error| fault(folder, "create", error))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let temporary = partial_file(folder, &format!(".{name}."))
            .map_err(|error| fault(folder, "write", error))?;
        let (mut file, temporary) = temporary.into_parts();
        let bytes = encode(inputs, table).map_err(io::Error::other);
        (bytes.and_then(|bytes| file.write_all(&bytes)))
            .and_then(|()| protect(&file))
            .and_then(|()| fsync::publish(&file, temporary, path))
            .map_err(|error| fault(path, "write", error))
    }
}

fn read<T: CacheContent>(path: &Path, inputs: &str) -> Result<T, CacheFault> {
    let file = TableFile::open(path)?;
    let table = file.content()?;
    if file.header.inputs == inputs { Ok(table) } else { Err(CacheFault::Inputs) }
}

/// Takes away what the user's umask let through of the permission to write.
fn protect(file: &File) -> io::Result<()> {
    let mode = file.metadata()?.permissions().mode();
    file.set_permissions(Permissions::from_mode(mode & READ_ONLY))
}

#[cfg(test)]
mod tests;
