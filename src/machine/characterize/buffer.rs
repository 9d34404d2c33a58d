//! Memory directly from the system: untouched pages, in lines of 64 bytes.
//!
//! The allocator may reuse pages that another thread touched first, perhaps on another node. Pages of a new
//! mapping are on the node of the thread that writes to them first.

#![allow(unsafe_code)]

use memmap2::{Advice, MmapMut, MmapOptions};
use std::io;

/// Doubles per line.
pub const LANES: usize = 8;

/// Bytes per line.
pub const LINE: usize = 8 * LANES;

/// Lines per ordinary page.
pub const PAGE: usize = 4096 / LINE;

/// A line of memory.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Line(pub [f64; LANES]);

/// Lines of memory in a separate mapping.
#[derive(Debug)]
pub struct Buffer {
    map: MmapMut,
    lines: usize,
}

impl Buffer {
    /// Untouched lines, at least one.
    ///
    /// # Errors
    /// The system does not grant the memory.
    pub fn new(lines: usize) -> io::Result<Self> {
        let lines = lines.max(1);
        let map = MmapOptions::new().len(lines * LINE).map_anon()?;
        Ok(Self { map, lines })
    }

    /// Requests huge pages; call it before pages are touched.
    ///
    /// # Errors
    /// The system has no huge pages.
    pub fn ask_for_huge_pages(&self) -> io::Result<()> {
        self.map.advise(Advice::HugePage)
    }

    /// The lines.
    pub fn lines(&self) -> &[Line] {
        // SAFETY: a mapping starts on a page, so it is aligned for lines. It is `lines * LINE` bytes long, and any bits
        // are a double.
        unsafe { std::slice::from_raw_parts(self.map.as_ptr().cast(), self.lines) }
    }

    /// The lines, mutable.
    pub fn lines_mut(&mut self) -> &mut [Line] {
        // SAFETY: as in `lines`, and the mapping is borrowed mutably.
        unsafe { std::slice::from_raw_parts_mut(self.map.as_mut_ptr().cast(), self.lines) }
    }

    /// Writes a number to all places. This makes the system provide the pages.
    pub fn fill(&mut self, value: f64) {
        self.lines_mut().fill(Line([value; LANES]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_aligned_zero_and_one_after_the_other() {
        let mut buffer = Buffer::new(100).unwrap();
        assert_eq!(buffer.lines().len(), 100);
        assert_eq!(buffer.lines().as_ptr() as usize % LINE, 0);
        assert!(buffer.lines().iter().all(|line| line.0 == [0.0; LANES]));
        buffer.fill(3.0);
        buffer.lines_mut()[99].0[7] = 4.0;
        let sum: f64 = buffer.lines().iter().flat_map(|line| line.0).sum();
        assert_eq!(sum, 800.0 * 3.0 + 1.0);
        assert_eq!(buffer.lines()[99].0[6..], [3.0, 4.0]);
    }

    #[test]
    fn more_than_there_is_is_refused() {
        assert!(Buffer::new(usize::MAX / 128).is_err());
    }
}
