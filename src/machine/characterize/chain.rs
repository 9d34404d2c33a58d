//! A chain of loads: a ring of lines, each of which contains the address of the next one.
//!
//! Lines contain addresses, not indices. The conversion of an index to an address would take one cycle, and a
//! load from the first-level cache takes only five or six.

#![allow(unsafe_code)]

use super::buffer::{Buffer, LINE, PAGE};
use super::error::MeasurementError;
use super::memory;
use super::plan::Walk;
use crate::numerics::random::Stream;

/// Number of loads of the warm-up: one round of 64 MiB of lines, eight rounds of 8 MiB. Newly written lines
/// are in the last-level cache only after some rounds. Until then a load takes up to twice the time.
const WARM_UP_LOADS: usize = 1 << 20;

/// A ring through the first lines of a buffer: each contains the address of the next one.
pub struct AddressRing {
    buffer: Buffer,
    at: u64,
}

impl AddressRing {
    /// A ring of one line.
    pub fn new(buffer: Buffer) -> Self {
        let mut ring = Self { buffer, at: 0 };
        ring.link(1, Walk::Pages);
        ring
    }

    /// Writes a ring through the first `count` lines, and moves to its start.
    pub fn link(&mut self, count: usize, walk: Walk) {
        let lines = self.buffer.lines_mut();
        let start = lines.as_ptr().addr();
        let address = |line: usize| (start + line * LINE) as u64;
        let link = |line: usize, next: usize| lines[line].0[0] = f64::from_bits(address(next));
        let first = match walk {
            Walk::Pages => page_by_page(count, link),
            Walk::Hops | Walk::HopsHuge => page_to_page(count, link),
        };
        self.at = address(first);
        // Expose the buffer, because loads follow these addresses until the next ring is written.
        self.buffer.lines().as_ptr().expose_provenance();
    }

    /// A ring of one line in a buffer near the calling thread, on the pages that a walk needs.
    pub fn near(lines: usize, walk: Walk) -> Result<Self, MeasurementError> {
        Ok(Self::new(match walk {
            Walk::HopsHuge => memory::on_huge_pages(lines, 0.0)?,
            Walk::Pages | Walk::Hops => memory::near(lines, 0.0)?,
        }))
    }

    /// Writes a ring through the first `count` lines, and follows it for a warm-up, so that the caches contain its
    /// lines as in later rounds.
    pub fn write_ring(&mut self, count: usize, walk: Walk) {
        self.link(count, walk);
        self.follow(WARM_UP_LOADS);
    }

    /// Follows the ring for `loads` loads.
    pub fn follow(&mut self, loads: usize) {
        let mut at = self.at;
        for _ in 0..loads {
            at = self.next(at);
        }
        self.at = at;
    }

    /// The address that the line at an address of the ring contains.
    #[inline]
    fn next(&self, at: u64) -> u64 {
        let line = std::ptr::with_exposed_provenance::<u64>(at as usize);
        // SAFETY: `at` is the address of a line on the ring. `link` wrote these addresses and exposed the buffer. The
        // first word of every line on the ring is such an address, and only `link` writes to the buffer.
        unsafe { line.read() }
    }

    /// Index of the current line.
    pub fn place(&self) -> usize {
        let start = self.buffer.lines().as_ptr() as u64;
        (self.at.wrapping_sub(start) / LINE as u64) as usize
    }
}

/// Links the lines page by page. The order of the pages, and of the lines within a page, is random. Returns the first
/// line.
fn page_by_page(lines: usize, mut link: impl FnMut(usize, usize)) -> usize {
    let mut stream = Stream::new(1, 0, 0);
    let (mut last, mut first) = (None, 0);
    for start in shuffled(lines.div_ceil(PAGE), &mut stream) {
        let start = start * PAGE;
        for line in shuffled(PAGE.min(lines - start), &mut stream) {
            match last {
                None => first = start + line,
                Some(last) => link(last, start + line),
            }
            last = Some(start + line);
        }
    }
    if let Some(last) = last {
        link(last, first);
    }
    first
}

/// Links lines in the order of [`PageToPage`]. Returns the first line.
fn page_to_page(lines: usize, mut link: impl FnMut(usize, usize)) -> usize {
    let order = PageToPage::new(lines);
    let page_count = order.pages.len();
    // Write page by page, not along the ring, so that each page is looked up once.
    for page in 0..page_count {
        for lap in 0..order.places.len() {
            let at = lap * page_count + page;
            link(order.line(at), order.line((at + 1) % order.ring()));
        }
    }
    order.line(0)
}

/// An order of lines. Each line is on another page than the line before, and all pages are visited before one
/// repeats. It is the order of `lat_mem_rd -t` of lmbench (C. Staelin, L. McVoy). An incomplete last page is
/// omitted.
struct PageToPage {
    pages: Vec<usize>,
    places: Vec<usize>,
}

impl PageToPage {
    fn new(lines: usize) -> Self {
        let mut stream = Stream::new(1, 0, 0);
        let places = shuffled(lines.min(PAGE), &mut stream);
        let pages = shuffled((lines / PAGE).max(1), &mut stream);
        Self { pages, places }
    }

    /// Number of lines on the ring.
    fn ring(&self) -> usize {
        self.pages.len() * self.places.len()
    }

    /// The line at a position of the ring. A lap visits every page once, each lap at another line of the page.
    fn line(&self, at: usize) -> usize {
        let (lap, page) = (at / self.pages.len(), at % self.pages.len());
        self.pages[page] * PAGE + self.places[(page + lap) % self.places.len()]
    }
}

/// Numbers below `count` in random order.
fn shuffled(count: usize, stream: &mut Stream) -> Vec<usize> {
    let mut values: Vec<usize> = (0..count).collect();
    for i in (1..count).rev() {
        let j = (stream.uniform() * (i + 1) as f64) as usize;
        values.swap(i, j.min(i));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_meets_every_line_once_and_comes_back() {
        for lines in [1, 10, 64, 128, 1000, 1024, 65 * 64] {
            for walk in [Walk::Pages, Walk::Hops] {
                let mut ring = AddressRing::new(Buffer::new(lines + PAGE).unwrap());
                ring.link(lines, walk);
                let (first, mut changes) = (ring.place(), 0);
                let visited = match walk {
                    Walk::Pages => lines,
                    _ => lines / PAGE.min(lines) * PAGE.min(lines),
                };
                let mut was_visited = vec![false; lines];
                for _ in 0..visited {
                    let at = ring.place();
                    assert!(
                        !std::mem::replace(&mut was_visited[at], true),
                        "{lines} {walk:?}"
                    );
                    ring.follow(1);
                    changes += usize::from(at / PAGE != ring.place() / PAGE);
                }
                assert_eq!(ring.place(), first, "{lines} {walk:?}");
                // The walk goes to another page at the end of each page, or with every load.
                let pages = lines.div_ceil(PAGE);
                let wanted = match walk {
                    _ if visited <= PAGE => 0,
                    Walk::Pages => pages,
                    _ => visited,
                };
                assert_eq!(changes, wanted, "{lines} {walk:?}");
            }
        }
    }

    /// No page is visited again before all other pages have been visited.
    #[test]
    fn hops_lead_through_all_pages_in_a_lap() {
        let pages = 7;
        let mut ring = AddressRing::new(Buffer::new(pages * PAGE).unwrap());
        ring.link(pages * PAGE, Walk::Hops);
        let visited: Vec<usize> = (0..pages * PAGE)
            .map(|_| {
                let page = ring.place() / PAGE;
                ring.follow(1);
                page
            })
            .collect();
        for lap in visited.chunks(pages) {
            let mut lap = lap.to_vec();
            lap.sort_unstable();
            assert!(lap.into_iter().eq(0..pages));
        }
    }
}
