//! Files that get their final name only when they are complete.

use super::StoreError;
use super::checksum::sealed;
use super::file::{publish, temporary_file};
use serde::Serialize;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// An unfinished file. If it is dropped without [`AtomicFile::publish`], no file remains.
pub struct AtomicFile {
    file: File,
    temporary: TempPath,
    path: PathBuf,
}

impl AtomicFile {
    /// Starts a file in the folder of its final name, which must exist.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn create(path: &Path) -> Result<Self, StoreError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let (file, temporary) = temporary_file(folder, &format!(".{name}."))?.into_parts();
        let path = path.to_path_buf();
        Ok(Self {
            file,
            temporary,
            path,
        })
    }

    /// The file to which the bytes are written.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Gives the file its name. An existing file or symbolic link of this name is replaced, not written through.
    ///
    /// # Errors
    /// Its bytes cannot be written to the disk.
    pub fn publish(self) -> Result<(), StoreError> {
        publish(&self.file, self.temporary, &self.path)
    }
}

/// Writes a file completely or not at all, as [`AtomicFile`] does.
///
/// # Errors
/// The file cannot be written.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let file = AtomicFile::create(path)?;
    let written = file.file().write_all(bytes);
    written.map_err(|source| StoreError::io(path, "write", source))?;
    file.publish()
}

/// Writes a record as JSON with the hash of its text, completely or not at all.
pub(super) fn write_sealed(path: &Path, record: &impl Serialize) -> Result<(), StoreError> {
    let text = serde_json::to_string_pretty(record)
        .map_err(|error| StoreError::io(path, "write", error.into()))?;
    write_atomically(path, sealed(&text).as_bytes())
}
