//! Parts of one file that are filled side by side: columns of a format that keeps each in one piece.

use crate::store::StoreError;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

/// A file that is written at any place.
pub struct Places<'a> {
    pub file: &'a File,
    /// What errors name.
    pub path: &'a Path,
}

impl Places<'_> {
    /// Writes at a place from the file's start.
    pub fn write(&self, at: u64, bytes: &[u8]) -> Result<(), StoreError> {
        let written = self.file.write_all_at(bytes, at);
        written.map_err(|source| StoreError::io(self.path, "write", source))
    }
}

/// A part of a file that is filled from its front.
#[derive(Debug)]
pub struct Region {
    next: u64,
}

impl Region {
    /// One that begins at a place of the file.
    pub fn at(start: u64) -> Self {
        Self { next: start }
    }

    /// Writes behind what it holds.
    pub fn append(&mut self, places: &Places<'_>, bytes: &[u8]) -> Result<(), StoreError> {
        places.write(self.next, bytes)?;
        self.next += bytes.len() as u64;
        Ok(())
    }
}
