//! Which files are mapped now, and which of them is shorter than it was? Asked by the handler of
//! the signal that ends a process reading beyond the end of one.

use std::fs::File;
use std::path::Path;
use std::sync::{Mutex, PoisonError, TryLockError};

use rustix::fs::fstat;

use crate::input::printable;

static WATCHED: Mutex<Vec<Watched>> = Mutex::new(Vec::new());

/// How often a handler looks for the list while another thread changes it.
const LOOKS: usize = 1_000_000;

#[derive(Debug)]
struct Watched {
    number: u64,
    file: File,
    /// When it was mapped \[bytes\].
    length: u64,
    /// What a terminal can be shown.
    name: Box<str>,
}

/// Keeps a file in the list of those that are mapped.
#[derive(Debug)]
pub(super) struct Watch(u64);

impl Watch {
    pub(super) fn over(file: File, length: u64, path: &Path) -> Self {
        let name = printable(&path.to_string_lossy()).into();
        let mut watched = WATCHED.lock().unwrap_or_else(PoisonError::into_inner);
        let number = watched.last().map_or(0, |last| last.number + 1);
        watched.push(Watched {
            number,
            file,
            length,
            name,
        });
        Self(number)
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let mut watched = WATCHED.lock().unwrap_or_else(PoisonError::into_inner);
        watched.retain(|known| known.number != self.0);
    }
}

/// Tells the names of mapped files that are shorter than they were when they were mapped.
///
/// May be called in the handler of a signal: it asks the system for the lengths, and neither
/// allocates nor waits. The thread that the signal stopped does not change the list: nothing of a
/// mapped file is read while it is changed.
pub fn cut_down(mut tell: impl FnMut(&str)) {
    for _ in 0..LOOKS {
        let watched = match WATCHED.try_lock() {
            Ok(watched) => watched,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => {
                std::hint::spin_loop();
                continue;
            }
        };
        for known in watched.iter() {
            let shorter = |size: i64| u64::try_from(size).is_ok_and(|length| length < known.length);
            if fstat(&known.file).is_ok_and(|found| shorter(found.st_size)) {
                tell(&known.name);
            }
        }
        return;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told() -> Vec<String> {
        let mut names = Vec::new();
        cut_down(|name| names.push(name.to_owned()));
        names
    }

    #[test]
    fn the_file_that_was_cut_down_is_named() {
        let [whole, cut] = [(); 2].map(|()| tempfile::tempfile().unwrap());
        for file in [&whole, &cut] {
            file.set_len(4096).unwrap();
        }
        let same = cut.try_clone().unwrap();
        let first = Watch::over(whole, 4096, Path::new("whole"));
        let second = Watch::over(cut, 4096, Path::new("cut\u{1b}[2J"));
        assert_eq!(told(), [""; 0]);
        same.set_len(4095).unwrap();
        assert_eq!(told(), [r"cut\u001b[2J"]);
        drop(first);
        assert_eq!(told().len(), 1);
        drop(second);
        assert_eq!(told(), [""; 0], "no longer mapped");
    }
}
