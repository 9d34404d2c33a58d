//! Opens files that a user names. It accepts only regular files: reading a named pipe can block for ever, and
//! a device has no end.

use std::fs::{self, File, FileType};
use std::io::{self, ErrorKind, Read};
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

/// Opens a regular file for reading, through symbolic links.
///
/// # Errors
/// Errors of the system; [`ErrorKind::InvalidInput`] if it is not a regular file.
pub fn open(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_file() {
        File::open(path)
    } else {
        Err(io::Error::new(
            ErrorKind::InvalidInput,
            format!("it is {}, not a regular file", words(kind)),
        ))
    }
}

/// The bytes of a regular file of at most `most` bytes.
///
/// # Errors
/// As [`open`]; [`ErrorKind::FileTooLarge`] if there are more bytes.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    read_stream(&mut open(path)?, most)
}

/// The bytes of a stream that ends after at most `most` bytes.
///
/// # Errors
/// Errors of the system; [`ErrorKind::FileTooLarge`] if there are more bytes.
pub fn read_stream(stream: &mut dyn Read, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // One byte more than accepted detects a longer stream, whatever its metadata claim.
    stream.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        Err(io::Error::new(
            ErrorKind::FileTooLarge,
            format!("it has more than {} MiB", most >> 20),
        ))
    } else {
        Ok(bytes)
    }
}

fn words(kind: FileType) -> &'static str {
    if kind.is_dir() {
        "a folder"
    } else if kind.is_fifo() {
        "a named pipe"
    } else if kind.is_socket() {
        "a socket"
    } else {
        "a device"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_opened() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "text").unwrap();
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(&file, &link).unwrap();
        assert_eq!(read(&link, 4).unwrap(), b"text");
        assert_eq!(read(&link, 3).unwrap_err().kind(), ErrorKind::FileTooLarge);
        for (path, word) in [
            (folder.path(), "folder"),
            (Path::new("/dev/zero"), "device"),
        ] {
            let error = open(path).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::InvalidInput);
            assert!(error.to_string().contains(word), "{error}");
        }
    }
}
