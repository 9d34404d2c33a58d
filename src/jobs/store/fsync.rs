//! Which names survive a power cut? A file is synced before it is renamed, and its folder afterwards: a name that is
//! only in memory would be lost.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::Path;

use tempfile::TempPath;

/// Gives a complete file its name. After a power cut, the name has either the complete file or the previous one.
pub(super) fn publish(file: &File, temporary: TempPath, path: &Path) -> io::Result<()> {
    file.sync_all()?;
    rename(temporary, path)
}

/// As [`publish`], for a file whose bytes are already on the disk.
pub(super) fn rename(temporary: TempPath, path: &Path) -> io::Result<()> {
    temporary.persist(path).map_err(|refused| refused.error)?;
    sync_folder_of(path)
}

/// Makes the names in the folder of `path` durable, including removals.
pub(super) fn sync_folder_of(path: &Path) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if folder.as_os_str().is_empty() => Path::new("."),
        Some(folder) => folder,
        // The root has no name.
        None => return Ok(()),
    };
    let synced = match File::open(folder) {
        Ok(folder) => folder.sync_all(),
        // A user may be allowed to write a folder but not to read it.
        Err(error) if error.kind() == ErrorKind::PermissionDenied => return Ok(()),
        Err(error) => Err(error),
    };
    match synced {
        // Some network file systems store names in another way and report that syncing is unsupported.
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::InvalidInput | ErrorKind::Unsupported
            ) =>
        {
            Ok(())
        }
        other => other,
    }
}

/// Creates a folder and its parents, durably.
pub(super) fn create_folder(folder: &Path) -> io::Result<()> {
    let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let missing: Vec<&Path> = folder.ancestors().take_while(missing).collect();
    fs::create_dir_all(folder)?;
    missing.into_iter().rev().try_for_each(sync_folder_of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_name_has_the_new_file_and_nothing_stays_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/c");
        create_folder(path.parent().unwrap()).unwrap();
        for text in ["first", "second"] {
            let mut temporary = tempfile::NamedTempFile::new_in(path.parent().unwrap()).unwrap();
            temporary.write_all(text.as_bytes()).unwrap();
            let (file, temporary) = temporary.into_parts();
            publish(&file, temporary, &path).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        // An existing folder is not an error.
        create_folder(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn a_folder_that_cannot_be_read_is_no_error_and_one_that_is_none_is() {
        let folder = tempfile::tempdir().unwrap();
        let closed = folder.path().join("closed");
        fs::create_dir(&closed).unwrap();
        fs::set_permissions(&closed, fs::Permissions::from_mode(0o300)).unwrap();
        sync_folder_of(&closed.join("x")).unwrap();
        let missing = sync_folder_of(&folder.path().join("missing/x")).unwrap_err();
        assert_eq!(missing.kind(), ErrorKind::NotFound);
        fs::write(folder.path().join("file"), "").unwrap();
        let refused = create_folder(&folder.path().join("file/x")).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::NotADirectory);
        sync_folder_of(Path::new("/")).unwrap();
        sync_folder_of(Path::new("name")).unwrap();
    }
}
