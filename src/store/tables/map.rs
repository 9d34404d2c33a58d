//! A file as memory: read-only, and one copy for all processes that map it, or one of its own.
//!
//! Table files are made under a temporary name, renamed, and never written again; their mode
//! forbids writing. Renaming another file over one, and removing it, leave mapped pages as
//! they are. A program that cut a file down in place all the same would end every process
//! that reads beyond the cut with SIGBUS, as with any mapped file; none would read wrong
//! numbers from before its check.

use std::fs::File;
use std::io;
use std::ops::Range;

use memmap2::{Mmap, MmapMut};

use super::layout::NUMBER;

/// A mapped file.
#[derive(Debug)]
pub(super) struct Mapping(Mmap);

impl Mapping {
    /// Maps a whole file.
    #[allow(unsafe_code)]
    pub fn of(file: &File) -> io::Result<Self> {
        // SAFETY: the pages are never written through this mapping, and table files are not
        // written in place (module documentation).
        unsafe { Mmap::map(file) }.map(Self)
    }

    /// The same bytes in pages of its own, which lie where the calling thread runs.
    pub fn copied(&self) -> io::Result<Self> {
        let mut copy = MmapMut::map_anon(self.0.len())?;
        copy.copy_from_slice(&self.0);
        copy.make_read_only().map(Self)
    }

    /// Every byte of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Some of the bytes as numbers; none where these do not lie within the file, do not start
    /// at a number's alignment or are not whole numbers.
    #[allow(unsafe_code)]
    pub fn numbers(&self, range: Range<usize>) -> Option<&[f64]> {
        let bytes = self.0.get(range)?;
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
    use std::io::Write;

    fn mapped(bytes: &[u8]) -> Mapping {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(bytes).unwrap();
        Mapping::of(&file).unwrap()
    }

    #[test]
    fn numbers_are_the_bytes_of_the_file() {
        let values: Vec<f64> = (0..1024).map(|i| f64::from(i).sqrt()).collect();
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
        let mapping = mapped(&bytes);
        assert_eq!(mapping.bytes(), bytes);
        let copy = mapping.copied().unwrap();
        assert_eq!(copy.numbers(0..bytes.len()), Some(&values[..]));
        assert_ne!(copy.bytes().as_ptr(), mapping.bytes().as_ptr());
        assert_eq!(mapping.numbers(0..bytes.len()), Some(&values[..]));
        assert_eq!(mapping.numbers(4096..4112), Some(&values[512..514]));
        assert_eq!(mapping.numbers(8192..8192), Some(&[][..]));
    }

    #[test]
    fn what_is_not_whole_aligned_numbers_of_the_file_is_none() {
        let mapping = mapped(&[0; 64]);
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
