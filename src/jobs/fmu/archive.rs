//! Packs files into a ZIP archive. Equal files give equal bytes.

use super::FmuError;
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// The bytes of a ZIP archive of files, each with its path in the archive.
///
/// # Errors
/// [`FmuError::Archive`] if a file has more than 4 GB or two files have the same path.
pub fn archive(files: &[(String, Vec<u8>)]) -> Result<Vec<u8>, FmuError> {
    let fault = |error: &dyn std::error::Error| FmuError::Archive(error.to_string());
    // Use the earliest date. The date of today would change the bytes every day.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, bytes) in files {
        zip.start_file(path.as_str(), options)
            .map_err(|e| fault(&e))?;
        zip.write_all(bytes).map_err(|e| fault(&e))?;
    }
    Ok(zip.finish().map_err(|e| fault(&e))?.into_inner())
}
