//! Errors of the operating system for a file or folder, as cases that a user can act on.

use std::fmt::{self, Display, Formatter};
use std::io;
use std::path::{Path, PathBuf};

/// The purpose of a folder, which determines the option that chooses another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Results of a run.
    Results,
    /// The cache of tables.
    Tables,
}

/// Why a file or a folder was refused.
#[derive(Debug)]
pub enum Refusal {
    /// No space left on the device, or the quota is used up.
    DiskFull,
    /// The device has space left, but no file can be added to it.
    NoInodes,
    /// A symbolic link has the name of a file of the program.
    SymbolicLink,
    /// The file system or a resource limit forbids a file this large.
    FileTooLarge,
    /// The user may not read or write there.
    PermissionDenied,
    /// The file system is mounted read-only.
    ReadOnly,
    /// A part of the path is a file where a folder is needed.
    NotADirectory,
    /// Anything else, with the system's error.
    Other(io::Error),
}

/// A failure of the operating system, with the path and the remedy.
#[derive(Debug, thiserror::Error)]
pub struct IoFault {
    /// The file or folder.
    pub path: PathBuf,
    /// `read`, `write`, `create` or `remove`.
    pub action: &'static str,
    /// The purpose of the folder.
    pub purpose: Purpose,
    /// The reason.
    pub refusal: Refusal,
}

impl IoFault {
    pub(super) fn new(
        path: &Path,
        action: &'static str,
        purpose: Purpose,
        error: io::Error,
    ) -> Self {
        use io::ErrorKind::*;
        let refusal = match error.kind() {
            StorageFull if lacks_inodes(path) => Refusal::NoInodes,
            StorageFull | QuotaExceeded => Refusal::DiskFull,
            _ if error.raw_os_error() == Some(LOOP) && path.is_symlink() => Refusal::SymbolicLink,
            FileTooLarge => Refusal::FileTooLarge,
            PermissionDenied => Refusal::PermissionDenied,
            ReadOnlyFilesystem => Refusal::ReadOnly,
            NotADirectory | AlreadyExists => Refusal::NotADirectory,
            _ => Refusal::Other(error),
        };
        Self {
            path: path.to_path_buf(),
            action,
            purpose,
            refusal,
        }
    }
}

impl Display for IoFault {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (path, action) = (self.path.display(), self.action);
        // Commands that only read results have no option for another folder.
        let (option, elsewhere) = match self.purpose {
            Purpose::Results => ("--out", ""),
            Purpose::Tables => ("--tables", " with --tables"),
        };
        let (clean, again) = match self.purpose {
            Purpose::Results => ("", ", then repeat the command"),
            Purpose::Tables => (" (computed tables may be deleted)", ""),
        };
        match &self.refusal {
            Refusal::DiskFull => write!(
                f,
                "the disk of `{path}` is full: free some space{clean} or choose another folder with \
                 {option}{again}"
            ),
            Refusal::NoInodes => write!(
                f,
                "the disk of `{path}` cannot hold more files (its inodes are used up; `df -i` counts them): \
                 remove files there or choose another folder with {option}{again}"
            ),
            Refusal::SymbolicLink => write!(
                f,
                "`{path}` is a symbolic link, which atlas does not follow: remove it, or choose another \
                 folder with {option}"
            ),
            Refusal::FileTooLarge => write!(
                f,
                "`{path}` exceeds the largest file allowed here: raise `ulimit -f` or choose another file \
                 system with {option}{again}"
            ),
            Refusal::PermissionDenied => write!(
                f,
                "no permission to {action} `{path}`: check its owner (`ls -ld`), or choose another \
                 folder{elsewhere}"
            ),
            Refusal::ReadOnly => write!(
                f,
                "`{path}` is on a read-only file system: choose another folder with {option}"
            ),
            Refusal::NotADirectory => write!(
                f,
                "`{path}` cannot be used: a part of this path is a file, not a folder; move that file away \
                 or choose another folder{elsewhere}"
            ),
            Refusal::Other(error) => write!(f, "cannot {action} `{path}`: {error}"),
        }
    }
}

/// The system's error number for a symbolic link that is not followed.
const LOOP: i32 = rustix::io::Errno::LOOP.raw_os_error();

/// Whether the file system of a path has space but no inodes left. The path need not exist.
fn lacks_inodes(path: &Path) -> bool {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let found = absolute
        .ancestors()
        .find_map(|at| rustix::fs::statvfs(at).ok());
    // Some file systems do not count inodes and report a total of 0.
    found.is_some_and(|system| system.f_files > 0 && system.f_favail == 0 && system.f_bavail > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_common_failure_is_one_line_with_path_and_remedy() {
        let path = Path::new("/data/flex80");
        for (errno, words) in [
            (28, "is full"),       // ENOSPC
            (122, "is full"),      // EDQUOT
            (27, "exceeds"),       // EFBIG
            (13, "no permission"), // EACCES
            (30, "read-only"),     // EROFS
            (20, "not a folder"),  // ENOTDIR
            (17, "not a folder"),  // EEXIST
        ] {
            for purpose in [Purpose::Results, Purpose::Tables] {
                let error = io::Error::from_raw_os_error(errno);
                let text = IoFault::new(path, "write", purpose, error).to_string();
                assert!(text.contains(words), "errno {errno}: {text}");
                assert!(text.contains("/data/flex80"), "{text}");
                assert!(text.contains("choose another"), "{text}");
                let tables = purpose == Purpose::Tables;
                assert_eq!(text.contains("--tables"), tables, "{text}");
                assert!(!text.contains('\n'), "{text}");
            }
        }
    }
}
