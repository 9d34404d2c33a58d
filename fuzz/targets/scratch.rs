//! A folder per thread, with the files for manifests among the seeds.

use std::cell::OnceCell;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

thread_local! {
    static FOLDER: OnceCell<TempDir> = const { OnceCell::new() };
}

/// Files of manifests, by name.
const FILES: [(&str, &str); 4] = [
    ("oscillator.modal.toml", OSCILLATOR_MODAL),
    (
        "coast.modal.toml",
        include_str!("../../tests/manifests/coast.modal.toml"),
    ),
    (
        "basins.modal.toml",
        include_str!("../../manifests/basins.modal.toml"),
    ),
    ("points.csv", include_str!("../../manifests/points.csv")),
];

/// A drive of one degree of freedom, the job of most targets.
pub const OSCILLATOR: &str = include_str!("../../tests/data/oscillator.toml");

const OSCILLATOR_MODAL: &str = include_str!("../../tests/data/oscillator.modal.toml");

/// The folder of this thread.
pub fn folder() -> PathBuf {
    FOLDER.with(|folder| {
        let folder = folder.get_or_init(|| {
            let folder = tempfile::tempdir().expect("a folder of its own");
            for (name, text) in FILES {
                put(&folder.path().join(name), text.as_bytes());
            }
            folder
        });
        folder.path().to_path_buf()
    })
}

/// A new, empty folder in it.
pub fn empty(name: &str) -> PathBuf {
    let path = folder().join(name);
    if path.exists() {
        fs::remove_dir_all(&path).expect("a folder that can be removed");
    }
    fs::create_dir(&path).expect("a folder that can be written");
    path
}

/// Writes a file, replacing an existing one.
pub fn put(path: &Path, bytes: &[u8]) {
    if path.exists() {
        fs::remove_file(path).expect("a file that can be removed");
    }
    fs::write(path, bytes).expect("a file that can be written");
}
