//! Folders and disks that cannot be written: the work continues with the table in memory.

use std::convert::Infallible;
use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use gearatlas::store::{CacheFault, CacheKind, CacheWarning, Fetched, IoFault, Origin, TableStore};

use crate::made::{inputs, mesh};
use crate::skipped::skipped;

/// Fetches from a folder that cannot store anything; returns the warnings.
fn unkept(folder: &Path) -> Vec<CacheWarning> {
    let build = || Ok::<_, Infallible>(mesh(false));
    let Fetched {
        table,
        file,
        origin,
        warnings,
    } = TableStore::open(folder)
        .get_or_build(&inputs(), build)
        .unwrap();
    assert_eq!(origin, Origin::BuiltInMemory);
    assert!(table == mesh(false) && !file.is_file());
    let lines = warnings.iter().map(ToString::to_string);
    assert!(lines.into_iter().all(|line| !line.contains('\n')));
    warnings
}

/// Why the table was not kept.
fn reason(folder: &Path) -> IoFault {
    match unkept(folder).pop() {
        Some(CacheWarning::NotKept { error }) => error,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_file_in_the_way_of_the_folder_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    for path in [file.clone(), file.join("tables")] {
        let error = reason(&path);
        assert!(error.to_string().contains("not a folder"), "{error:?}");
    }
}

#[test]
fn a_folder_without_permission_is_said() {
    let folder = tempfile::tempdir().unwrap();
    fs::set_permissions(folder.path(), Permissions::from_mode(0o555)).unwrap();
    match fs::write(folder.path().join("probe"), "") {
        Ok(()) => skipped("nothing is forbidden to this user, who is root"),
        Err(_) => {
            let error = reason(folder.path());
            assert!(error.to_string().contains("no permission"), "{error:?}");
        }
    }
    fs::set_permissions(folder.path(), Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn a_folder_or_a_pipe_in_the_place_of_the_file_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = TableStore::open(folder.path()).path(CacheKind::Mesh, &inputs());
    fs::create_dir(&path).unwrap();
    let warnings = unkept(folder.path());
    let [
        CacheWarning::Refused { fault, .. },
        CacheWarning::NotKept { .. },
    ] = &warnings[..]
    else {
        panic!("{warnings:?}");
    };
    assert!(matches!(fault, CacheFault::Unreadable(_)));
    assert!(
        fault
            .to_string()
            .contains("it is a folder, not a regular file")
    );
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        1,
        "a temporary file stayed"
    );
}
