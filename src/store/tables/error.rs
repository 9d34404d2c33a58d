//! What can go wrong with the cache of tables, said with what to do about it.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::CacheFault;

/// A table could not be kept, found or removed.
#[derive(Debug, Error)]
pub enum CacheError {
    /// No space left on the device, or the quota is used up.
    #[error(
        "the disk that holds `{}` is full: free some space (`atlas table clean` helps) or choose \
         another folder with --tables", path.display()
    )]
    DiskFull {
        /// The file being written.
        path: PathBuf,
    },
    /// The file system or a resource limit forbids a file this large.
    #[error(
        "`{}` outgrew the largest file allowed here: raise `ulimit -f` or choose another file \
         system with --tables", path.display()
    )]
    FileTooLarge {
        /// The file being written.
        path: PathBuf,
    },
    /// The user may not read or write there.
    #[error(
        "no permission to {action} `{}`: check who owns it (`ls -ld`), or choose another folder \
         with --tables", path.display()
    )]
    PermissionDenied {
        /// The file or folder.
        path: PathBuf,
        /// `read`, `write`, `create` or `remove`.
        action: &'static str,
    },
    /// The file system is mounted read-only.
    #[error(
        "`{}` lies on a read-only file system: choose another folder with --tables", path.display()
    )]
    ReadOnly {
        /// The file or folder.
        path: PathBuf,
    },
    /// A part of the path is a file where a folder is needed.
    #[error(
        "`{}` cannot be used: a part of this path is a file, not a folder; move that file away or \
         choose another folder with --tables", path.display()
    )]
    NotADirectory {
        /// The folder wanted.
        path: PathBuf,
    },
    /// Any other failure of the operating system.
    #[error("cannot {action} `{}`: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// `read`, `write`, `create` or `remove`.
        action: &'static str,
        /// The system's own words.
        source: io::Error,
    },
    /// A table that was just written does not come back as it was.
    #[error("`{}` was written, but {fault}", path.display())]
    NotReadBack {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: CacheFault,
    },
    /// A shape without a place for each value.
    #[error("array `{name}` of shape {shape:?} has {values} values")]
    Shape {
        /// The array.
        name: String,
        /// Extent of each axis.
        shape: Vec<usize>,
        /// Number of values.
        values: usize,
    },
    /// Two arrays of one name.
    #[error("there are two arrays `{name}`")]
    NameTaken {
        /// The name.
        name: String,
    },
    /// The table has no such array.
    #[error("the table has no array `{name}`; it has: {known}")]
    NoArray {
        /// The name asked for.
        name: String,
        /// Arrays that are there.
        known: String,
    },
    /// No table has a key that begins like this.
    #[error(
        "no table `{wanted}` in `{}`: give a file, or the first digits of a key that \
         `atlas table list` shows", folder.display()
    )]
    Unknown {
        /// What was asked for.
        wanted: String,
        /// The folder searched.
        folder: PathBuf,
    },
    /// Several tables have.
    #[error("`{wanted}` fits several tables: {}", found.join(", "))]
    Ambiguous {
        /// What was asked for.
        wanted: String,
        /// Names of the files.
        found: Vec<String>,
    },
}

impl CacheError {
    /// Sorts an error of the operating system into the cases a user can act on.
    pub(super) fn io(path: &Path, action: &'static str, source: io::Error) -> Self {
        let path = path.to_path_buf();
        match source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::DiskFull { path },
            io::ErrorKind::FileTooLarge => Self::FileTooLarge { path },
            io::ErrorKind::PermissionDenied => Self::PermissionDenied { path, action },
            io::ErrorKind::ReadOnlyFilesystem => Self::ReadOnly { path },
            io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
                Self::NotADirectory { path }
            }
            _ => Self::Io {
                path,
                action,
                source,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_common_failure_is_one_line_with_path_and_remedy() {
        let path = Path::new("/data/tables");
        for (errno, words) in [
            (28, "is full"),       // ENOSPC
            (122, "is full"),      // EDQUOT
            (27, "outgrew"),       // EFBIG
            (13, "no permission"), // EACCES
            (30, "read-only"),     // EROFS
            (20, "not a folder"),  // ENOTDIR
            (17, "not a folder"),  // EEXIST
        ] {
            let error = CacheError::io(path, "write", io::Error::from_raw_os_error(errno));
            let text = error.to_string();
            assert!(text.contains(words), "errno {errno}: {text}");
            assert!(text.contains("/data/tables"), "{text}");
            assert!(text.contains("--tables"), "{text}");
            assert!(!text.contains('\n'), "{text}");
        }
    }
}
