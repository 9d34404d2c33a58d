//! Files that have their name when they are whole, and not before.

use super::StoreError;
use super::file::{publish, temporary_file};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// A file on its way to its name. Dropped without [`WholeFile::publish`], it leaves nothing.
pub struct WholeFile {
    file: File,
    temporary: TempPath,
    path: PathBuf,
}

impl WholeFile {
    /// Starts a file beside the place where it is to have its name, in a folder that exists.
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

    /// What its bytes go to.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Gives the file its name. What has it already, a symbolic link among them, is replaced and
    /// not written through.
    ///
    /// # Errors
    /// Its bytes cannot be written to the disk.
    pub fn publish(self) -> Result<(), StoreError> {
        publish(&self.file, self.temporary, &self.path)
    }
}

/// Writes a file whole or not at all, as [`WholeFile`] does.
///
/// # Errors
/// The file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let whole = WholeFile::create(path)?;
    let written = whole.file().write_all(bytes);
    written.map_err(|source| StoreError::io(path, "write", source))?;
    whole.publish()
}
