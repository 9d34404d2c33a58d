//! A file as memory: read-only, and of large ones one copy for all processes.
//!
//! Table files are made under a temporary name, renamed, and never written again; their mode
//! forbids writing. Renaming another file over one, and removing it, leave pages as they are. But a
//! program that cuts a mapped file down in place ends, by SIGBUS, every process that reads beyond
//! the cut. What is small is therefore read: no table of the drives known needs the bound, and a
//! process more pays a copy of it. What is larger is mapped, and watched (`watch.rs`), so that
//! the end of a process has a reason that can be told.

use std::fs::File;
use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;

use memmap2::{Mmap, MmapMut};

use super::layout::NUMBER;
use super::watch::Watch;

/// Files up to this length are read, longer ones are mapped \[bytes\]. Every byte is hashed before
/// one is used, so that reading adds a copy to what is read anyway.
pub(super) const MOST_READ: u64 = 64 << 20;

/// A file in memory.
#[derive(Debug)]
pub(super) struct Mapping {
    pages: Mmap,
    /// Present where the pages are those of the file.
    _watch: Option<Watch>,
}

impl Mapping {
    /// A whole file; `path` is what is said of it.
    pub fn of(file: File, path: &Path) -> io::Result<Self> {
        let length = file.metadata()?.len();
        match length <= MOST_READ {
            true => Self::read(file, length),
            false => Self::map(file, path),
        }
    }

    fn read(mut file: File, length: u64) -> io::Result<Self> {
        let length = usize::try_from(length).map_err(io::Error::other)?;
        let mut pages = MmapMut::map_anon(length)?;
        // A file that was cut down meanwhile is an error like any other.
        file.read_exact(&mut pages)?;
        Ok(Self {
            pages: pages.make_read_only()?,
            _watch: None,
        })
    }

    #[allow(unsafe_code)]
    fn map(file: File, path: &Path) -> io::Result<Self> {
        // SAFETY: the pages are never written through this mapping, and table files are not
        // written in place (module documentation).
        let pages = unsafe { Mmap::map(&file) }?;
        let watch = Watch::over(file, pages.len() as u64, path);
        Ok(Self {
            pages,
            _watch: Some(watch),
        })
    }

    /// The same bytes in pages of its own, which lie where the calling thread runs.
    pub fn copied(&self) -> io::Result<Self> {
        let mut copy = MmapMut::map_anon(self.pages.len())?;
        copy.copy_from_slice(&self.pages);
        Ok(Self {
            pages: copy.make_read_only()?,
            _watch: None,
        })
    }

    /// Every byte of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.pages
    }

    /// Some of the bytes as numbers; none where these do not lie within the file, do not start
    /// at a number's alignment or are not whole numbers.
    #[allow(unsafe_code)]
    pub fn numbers(&self, range: Range<usize>) -> Option<&[f64]> {
        let bytes = self.pages.get(range)?;
        let start = bytes.as_ptr().cast::<f64>();
        if !start.is_aligned() || !bytes.len().is_multiple_of(NUMBER) {
            return None;
        }
        // SAFETY: the range is within the mapping, aligned and whole; every bit pattern is an
        // f64, and the borrow of the mapping outlives the slice.
        Some(unsafe { std::slice::from_raw_parts(start, bytes.len() / NUMBER) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Seek, Write};

    /// A file in memory, read and mapped.
    fn both(bytes: &[u8]) -> [Mapping; 2] {
        let open = || {
            let mut file = tempfile::tempfile().unwrap();
            file.write_all(bytes).unwrap();
            file.rewind().unwrap();
            file
        };
        let read = Mapping::of(open(), Path::new("small")).unwrap();
        assert!(read._watch.is_none());
        [read, Mapping::map(open(), Path::new("large")).unwrap()]
    }

    #[test]
    fn numbers_are_the_bytes_of_the_file() {
        let values: Vec<f64> = (0..1024).map(|i| f64::from(i).sqrt()).collect();
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
        for mapping in both(&bytes) {
            assert_eq!(mapping.bytes(), bytes);
            let copy = mapping.copied().unwrap();
            assert_eq!(copy.numbers(0..bytes.len()), Some(&values[..]));
            assert_ne!(copy.bytes().as_ptr(), mapping.bytes().as_ptr());
            assert_eq!(mapping.numbers(0..bytes.len()), Some(&values[..]));
            assert_eq!(mapping.numbers(4096..4112), Some(&values[512..514]));
            assert_eq!(mapping.numbers(8192..8192), Some(&[][..]));
        }
    }

    #[test]
    fn what_is_not_whole_aligned_numbers_of_the_file_is_none() {
        for mapping in both(&[0; 64]) {
            let backwards = Range { start: 16, end: 8 };
            for range in [
                1..9,
                4..12,
                0..7,
                8..17,
                0..72,
                64..72,
                backwards,
                8..usize::MAX,
            ] {
                assert_eq!(mapping.numbers(range.clone()), None, "{range:?}");
            }
        }
    }

    #[test]
    fn a_small_file_that_is_cut_down_stays_as_it_was_read() {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&[7; 8192]).unwrap();
        file.rewind().unwrap();
        let read = Mapping::of(file.try_clone().unwrap(), Path::new("table")).unwrap();
        file.set_len(0).unwrap();
        assert_eq!(read.bytes(), [7; 8192]);
        // Shorter than it said before it was read.
        let error = Mapping::read(file, 8192).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::UnexpectedEof);
    }

    #[test]
    fn a_large_file_is_mapped() {
        let file = tempfile::tempfile().unwrap();
        file.set_len(MOST_READ + 1).unwrap();
        let mapping = Mapping::of(file, Path::new("large")).unwrap();
        assert!(mapping._watch.is_some());
        assert_eq!(mapping.bytes().len() as u64, MOST_READ + 1);
    }
}
