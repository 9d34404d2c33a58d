//! Packs files into an archive, the same bytes each time.

use super::FmuError;
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// The archive of files, each with its path in it.
///
/// # Errors
/// [`FmuError::Archive`], for a file of more than 4 GB.
pub fn archive(files: &[(String, Vec<u8>)]) -> Result<Vec<u8>, FmuError> {
    let fault = |error: &dyn std::error::Error| FmuError::Archive(error.to_string());
    // The first date that there is: that of the day would be another each time.
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
