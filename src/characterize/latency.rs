//! Latency: a chain of loads, each of which tells where the next one is.
//!
//! Lines hold addresses, not indices: what turns an index into an address would be counted as
//! time of the load, a cycle of five or six in the first-level cache.

#![allow(unsafe_code)]

use super::buffer::{Buffer, LINE, PAGE};
use super::error::MeasurementError;
use super::measured::Measured;
use super::memory;
use super::plan::Walk;
use super::team::{self, HardwareThread, Pace};
use crate::numerics::random::Stream;
use crate::topology::Topology;

/// Loads of a repetition.
const LOADS: usize = 20_000;

/// Loads of the warm-up: once round 64 MiB of lines, eight times round 8 MiB. Lines that were
/// just written settle in a last-level cache only after some rounds, and take up to twice the
/// time until then.
const WARM: usize = 1 << 20;

/// Times of a load, of many one after the other, from so many lines of memory of a node.
pub fn measure(
    topology: &Topology,
    thread: HardwareThread,
    node: u32,
    sizes: &[usize],
    walk: Walk,
    pace: Pace,
) -> Result<Measured, MeasurementError> {
    let most = sizes.iter().copied().max().unwrap_or(1);
    let prepare = |_| {
        let buffer = match (thread.node == node, walk) {
            (false, _) => memory::on_node(topology, node, most)?,
            (true, Walk::HopsHuge) => memory::on_huge_pages(most, 0.0)?,
            (true, Walk::Pages | Walk::Hops) => memory::near(most, 0.0)?,
        };
        Ok(Chain::new(buffer))
    };
    let worked = team::work(
        topology,
        &[thread],
        sizes.len(),
        pace,
        prepare,
        |chain, task| {
            chain.link(sizes[task], walk);
            chain.follow(WARM);
        },
        |chain, _| chain.follow(LOADS),
        |chain| (chain.place() < most, ()),
    )?;
    let checked = worked.checked("a chain of loads")?;
    Ok(checked.per_unit(&vec![LOADS as f64; sizes.len()]).into())
}

/// A ring through the first lines of a buffer: each holds the address of the next one.
struct Chain {
    buffer: Buffer,
    at: u64,
}

impl Chain {
    /// A ring of one line.
    fn new(buffer: Buffer) -> Self {
        let mut chain = Self { buffer, at: 0 };
        chain.link(1, Walk::Pages);
        chain
    }

    /// Writes a ring through so many lines, and goes to its start.
    fn link(&mut self, count: usize, walk: Walk) {
        let lines = self.buffer.lines_mut();
        let start = lines.as_ptr().addr();
        let address = |line: usize| (start + line * LINE) as u64;
        let link = |line: usize, next: usize| lines[line].0[0] = f64::from_bits(address(next));
        let first = match walk {
            Walk::Pages => page_by_page(count, link),
            Walk::Hops | Walk::HopsHuge => page_to_page(count, link),
        };
        self.at = address(first);
        // Loads go by these addresses until the next ring is written.
        self.buffer.lines().as_ptr().expose_provenance();
    }

    /// Goes on by so many loads.
    fn follow(&mut self, loads: usize) {
        let mut at = self.at;
        for _ in 0..loads {
            let line = std::ptr::with_exposed_provenance::<u64>(at as usize);
            // SAFETY: `at` is the address of a line of the buffer, which `link` exposed; the first
            // word of every line on the ring holds another such address, and only `link` writes
            // to the buffer.
            at = unsafe { line.read() };
        }
        self.at = at;
    }

    /// The line it is at.
    fn place(&self) -> usize {
        let start = self.buffer.lines().as_ptr() as u64;
        (self.at.wrapping_sub(start) / LINE as u64) as usize
    }
}

/// Links the lines of a page in random order, then those of the next page, pages in random
/// order. Returns the first line.
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

/// Links lines so that each lies on another page than the one before, and all pages are visited
/// before one is again: the order of `lat_mem_rd -t` of lmbench (C. Staelin, L. McVoy). A last
/// page that is not whole is left out. Returns the first line.
fn page_to_page(lines: usize, mut link: impl FnMut(usize, usize)) -> usize {
    let mut stream = Stream::new(1, 0, 0);
    let whole = lines.min(PAGE);
    let places = shuffled(whole, &mut stream);
    let pages = shuffled((lines / PAGE).max(1), &mut stream);
    for (i, page) in pages.iter().enumerate() {
        // After the last page the next lap begins, one place further on.
        let (next, turn) = match i + 1 < pages.len() {
            true => (i + 1, 0),
            false => (0, 1),
        };
        for lap in 0..whole {
            let from = places[(i + lap) % whole];
            let to = places[(next + lap + turn) % whole];
            link(page * PAGE + from, pages[next] * PAGE + to);
        }
    }
    pages[0] * PAGE + places[0]
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
                let mut chain = Chain::new(Buffer::new(lines + PAGE).unwrap());
                chain.link(lines, walk);
                let (first, mut changes) = (chain.place(), 0);
                let ring = match walk {
                    Walk::Pages => lines,
                    _ => lines / PAGE.min(lines) * PAGE.min(lines),
                };
                let mut met = vec![false; lines];
                for _ in 0..ring {
                    let at = chain.place();
                    assert!(!std::mem::replace(&mut met[at], true), "{lines} {walk:?}");
                    chain.follow(1);
                    changes += usize::from(at / PAGE != chain.place() / PAGE);
                }
                assert_eq!(chain.place(), first, "{lines} {walk:?}");
                // From page to page only when one is through, or every time.
                let pages = lines.div_ceil(PAGE);
                let wanted = match walk {
                    _ if ring <= PAGE => 0,
                    Walk::Pages => pages,
                    _ => ring,
                };
                assert_eq!(changes, wanted, "{lines} {walk:?}");
            }
        }
    }

    /// A page is not visited again before all others were.
    #[test]
    fn hops_lead_through_all_pages_in_a_lap() {
        let pages = 7;
        let mut chain = Chain::new(Buffer::new(pages * PAGE).unwrap());
        chain.link(pages * PAGE, Walk::Hops);
        let visited: Vec<usize> = (0..pages * PAGE)
            .map(|_| {
                let page = chain.place() / PAGE;
                chain.follow(1);
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
