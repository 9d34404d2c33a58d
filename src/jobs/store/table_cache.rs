//! The cache of computed tables: a folder that may be deleted at any time.
//!
//! A table takes long to compute, and the next run needs it again. The name of its file is a hash of the table's
//! inputs. The file is written under a temporary name, renamed, and never changed afterwards. A reader loads the whole
//! file into memory and checks every byte before it uses any, so later changes of the file cannot harm it. A damaged or
//! foreign file is computed anew.
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

/// Identifies the file.
const MAGIC: &[u8; 12] = b"atlastbl\x04\x03\x02\x01";
/// Version of the format. It changes whenever the format does.
const VERSION: u32 = 2;
/// Longer files are not read \[bytes\]. Tables of kernels have at most 256 MB.
const MOST_READ: u64 = 1 << 30;
/// Digits of the key in a file name. The inputs are compared as well, so that a collision costs only one computation.
const DIGITS: usize = 32;
/// Suffix of a table file.
pub(super) const EXTENSION: &str = "table";
/// Mode of a table file. Nobody may write it, because a table never changes.
const READ_ONLY: u32 = 0o444;

/// The kind of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
pub enum CacheKind {
    /// Mesh stiffness and the other quantities of a mesh over a mesh cycle.
    Mesh,
    /// Eigenvectors of each set of closed contacts, of the kernel `closed_modes`.
    Systems,
}

impl CacheKind {
    /// Name in file names and messages.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A type of table that can be stored.
pub trait CacheContent: Serialize + DeserializeOwned {
    /// Kind of the table.
    const KIND: CacheKind;

    /// Why the numbers are inconsistent, which this program never writes; `None` if they are consistent.
    fn fault(&self) -> Option<&'static str> {
        None
    }
}

/// Header of a table file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CacheHeader {
    /// Kind of the table.
    pub kind: CacheKind,
    /// Program that computed it.
    pub program: String,
    /// Inputs of the table: JSON with sorted keys.
    pub inputs: String,
}

impl CacheHeader {
    /// Hash of kind and inputs: lower-case hexadecimal, 64 digits.
    pub fn key(&self) -> String {
        key(self.kind, &self.inputs)
    }
}

/// What is wrong with a table file? The words continue a sentence about it.
#[derive(Debug, Error)]
pub enum CacheFault {
    /// The file does not exist.
    #[error("does not exist")]
    Missing,
    /// The system refuses, or it is not a regular file.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// The first bytes are wrong.
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
    /// Some bytes were changed.
    #[error("is cut off or damaged: its checksum does not match")]
    Checksum,
    /// The checksum is right, but the bytes are not a valid table.
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
        /// Requested kind.
        wanted: &'static str,
    },
    /// A table of other inputs.
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

/// A table file in memory, with every byte checked.
#[derive(Debug)]
pub struct TableFile {
    /// Header of the file.
    pub header: CacheHeader,
    bytes: Vec<u8>,
    /// Offset of the content.
    content: usize,
}

impl TableFile {
    /// Reads and checks a table file of any kind.
    ///
    /// # Errors
    /// A fault of the file.
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
    /// It has another kind, or its numbers are inconsistent.
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

/// The bytes after the checksum of a file, once the checksum is verified.
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

/// JSON in the one form that is hashed: keys sorted, no spaces, numbers in the shortest digits that restore the same
/// bits.
fn canonical(value: &Value) -> String {
    let mut value = value.clone();
    value.sort_all_objects();
    value.to_string()
}

/// Hash of a kind and inputs in canonical form.
fn key(kind: CacheKind, inputs: &str) -> String {
    let mut hash = blake3::Hasher::new();
    // No name of a kind contains the byte 0, which therefore separates the parts.
    hash.update(format!("atlas table 1\0{}\0", kind.name()).as_bytes());
    hash.update(inputs.as_bytes());
    hash.finalize().to_hex().to_string()
}

/// A folder of tables. Any number of processes may use it at once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableStore {
    folder: PathBuf,
    /// Whether the folder is searched for tables.
    reads: bool,
    /// Whether tables are written there.
    keeps: bool,
}

/// A table and its origin.
#[derive(Debug)]
pub struct Fetched<T> {
    /// The table.
    pub table: T,
    /// File of the table, which exists unless the table was built in memory.
    pub file: PathBuf,
    /// Origin of the table.
    pub origin: Origin,
    /// Warnings for the user.
    pub warnings: Vec<CacheWarning>,
}

/// The origin of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// Read from its file.
    Found,
    /// Computed and stored for the next time.
    Built,
    /// Computed, but not stored: it is lost when it is dropped.
    BuiltInMemory,
}

/// A problem with the cache that does not stop the program; one line each.
#[derive(Debug)]
pub enum CacheWarning {
    /// A file exists but was not used.
    Refused {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: CacheFault,
    },
    /// A computed table could not be stored.
    NotKept {
        /// Reason.
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
    /// A store in a folder, which is created when the first table is stored.
    pub fn open(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            reads: true,
            keeps: true,
        }
    }

    /// The tables of a folder that is never written to: missing tables are computed, and lost when they are dropped.
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
    /// `inputs` is everything that determines the content, including the version of the method if it can change. JSON
    /// has no numbers that are not finite, and turns them into null.
    pub fn path(&self, kind: CacheKind, inputs: &Value) -> PathBuf {
        self.path_of(kind, &canonical(inputs))
    }

    fn path_of(&self, kind: CacheKind, inputs: &str) -> PathBuf {
        let digits = &key(kind, inputs)[..DIGITS];
        self.folder
            .join(format!("{}-{digits}.{EXTENSION}", kind.name()))
    }

    /// The table of these inputs (see [`TableStore::path`]): the one on disk if it exists and every byte is right,
    /// otherwise the result of `build`, which is stored.
    ///
    /// # Errors
    /// Only errors of `build`: a cache that cannot be read or written costs time and gives a warning.
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

    /// Writes a table, durably. If two processes write the same table at once, the second replaces the first's file by
    /// an equal one.
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

/// Removes the permission to write from the mode that the user's umask allowed.
fn protect(file: &File) -> io::Result<()> {
    let mode = file.metadata()?.permissions().mode();
    file.set_permissions(Permissions::from_mode(mode & READ_ONLY))
}

#[cfg(test)]
mod tests;
