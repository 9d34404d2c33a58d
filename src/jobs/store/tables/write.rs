//! A table on its way to disk: whole under its final name, or not there at all.

use std::fs::{File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use super::CacheError;
use super::arrays::Arrays;
use super::header::CacheHeader;
use super::key::CacheKind;
use super::layout::{ALIGNMENT, NUMBER};
use crate::store::durable;
use crate::store::file::partial_file;

/// Numbers turned to bytes at a time.
const CHUNK: usize = 8192;
/// No user may write: a table is never changed.
const READ_ONLY: u32 = 0o444;

/// Writes a table to `path` in `folder`, which is created where needed; durable when it
/// returns. Of two processes that write the same table at once the second replaces the
/// first's file by an equal one.
///
/// # Errors
/// The folder or the file cannot be written; nothing new is then under `path`.
pub(super) fn write(
    folder: &Path,
    path: &Path,
    kind: CacheKind,
    inputs: &str,
    arrays: &Arrays,
) -> Result<(), CacheError> {
    durable::create_folder(folder).map_err(|error| CacheError::io(folder, "create", error))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut temporary = partial_file(folder, &format!(".{name}."))
        .map_err(|error| CacheError::io(folder, "write", error))?;
    let refused = |error| CacheError::io(path, "write", error);
    encode(temporary.as_file_mut(), kind, inputs, arrays).map_err(refused)?;
    let (file, temporary) = temporary.into_parts();
    protect(&file)
        .and_then(|()| durable::publish(&file, temporary, path))
        .map_err(refused)
}

/// Takes away what the user's umask let through of the permission to write.
fn protect(file: &File) -> io::Result<()> {
    let mode = file.metadata()?.permissions().mode();
    file.set_permissions(Permissions::from_mode(mode & READ_ONLY))
}

/// The bytes of a table file.
pub(super) fn encode(
    sink: &mut impl Write,
    kind: CacheKind,
    inputs: &str,
    arrays: &Arrays,
) -> io::Result<()> {
    let mut hash = blake3::Hasher::new();
    data(arrays, |bytes| {
        hash.update(bytes);
        Ok(())
    })?;
    let sum = hash.finalize().to_hex().to_string();
    sink.write_all(&CacheHeader::new(kind, inputs, arrays, sum).encode(inputs)?)?;
    data(arrays, |bytes| sink.write_all(bytes))
}

/// Hands the bytes of the data to `take`, piece by piece.
fn data(arrays: &Arrays, mut take: impl FnMut(&[u8]) -> io::Result<()>) -> io::Result<()> {
    let mut buffer = Vec::with_capacity(NUMBER * CHUNK);
    let mut end: usize = 0;
    for array in arrays.iter() {
        let gap = end.next_multiple_of(ALIGNMENT) - end;
        take(&[0; ALIGNMENT][..gap])?;
        for values in array.values.chunks(CHUNK) {
            buffer.clear();
            buffer.extend(values.iter().flat_map(|value| value.to_ne_bytes()));
            take(&buffer)?;
        }
        end += gap + NUMBER * array.values.len();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::OpenOptions;

    #[test]
    fn a_full_disk_is_said_as_such() {
        let mut sink = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut arrays = Arrays::new();
        arrays.push("x", "1", &[3], vec![1.0; 3]).unwrap();
        let error = encode(&mut sink, CacheKind::Mesh, "{}", &arrays).unwrap_err();
        let error = CacheError::io(Path::new("tables/mesh"), "write", error);
        assert!(error.to_string().contains("is full"), "{error:?}");
    }
}
