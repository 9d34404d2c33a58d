//! Latency: a chain of loads, each of which tells where the next one is.

use super::buffer::{Buffer, LINE, Line};
use super::plan::{Seat, Walk};
use super::team::{self, Pace, Worked};
use super::trouble::Trouble;
use super::{memory, streaming};
use crate::numerics::random::Stream;
use crate::topology::Topology;

/// Loads of a repetition.
pub const LOADS: usize = 20_000;

/// Loads of the warm-up at most: 64 MiB of lines.
const MOST_WARM: usize = 1 << 20;

/// Lines of a usual page.
const PAGE: usize = 4096 / LINE;

/// Times of [`LOADS`] loads from a buffer on a node, one after the other.
pub fn measure(
    topology: &Topology,
    seat: Seat,
    node: u32,
    lines: usize,
    walk: Walk,
    pace: Pace,
) -> Result<Worked<()>, Trouble> {
    let prepare = |_| {
        let mut buffer = match seat.node == node {
            true => memory::near(lines, walk == Walk::AnywhereHuge, 0.0)?,
            false => memory::on_node(topology, node, lines)?,
        };
        let group = match walk {
            Walk::Pages => PAGE,
            Walk::Anywhere | Walk::AnywhereHuge => lines,
        };
        chain(buffer.lines_mut(), group);
        Ok((buffer, 0))
    };
    let worked = team::work(
        topology,
        &[seat],
        1,
        pace,
        prepare,
        // Once round what fits a cache, so that it is there.
        |(buffer, at), _| *at = follow(buffer, *at, lines.min(MOST_WARM)),
        |(buffer, at), _| *at = follow(buffer, *at, LOADS),
        |(buffer, at)| at < buffer.lines().len(),
    )?;
    streaming::checked(worked, "a chain of loads")
}

/// Goes on from a line.
fn follow(buffer: &Buffer, mut at: usize, loads: usize) -> usize {
    let lines = buffer.lines();
    for _ in 0..loads {
        at = lines[at].0[0].to_bits() as usize;
    }
    at
}

/// Writes into every line the number of the next one: a ring through all, the lines of a group
/// in random order before those of the next group, groups in random order.
fn chain(lines: &mut [Line], group: usize) {
    let mut stream = Stream::new(1, 0, 0);
    let mut groups: Vec<u32> = (0..lines.len().div_ceil(group) as u32).collect();
    shuffle(&mut groups, &mut stream);
    let mut inside: Vec<u32> = Vec::new();
    let (mut last, mut first) = (None, 0);
    for start in groups.into_iter().map(|g| g as usize * group) {
        inside.clear();
        inside.extend(start as u32..lines.len().min(start + group) as u32);
        shuffle(&mut inside, &mut stream);
        for &line in &inside {
            let line = line as usize;
            match last {
                None => first = line,
                Some(last) => point(&mut lines[last], line),
            }
            last = Some(line);
        }
    }
    if let Some(last) = last {
        point(&mut lines[last], first);
    }
}

fn point(line: &mut Line, next: usize) {
    line.0[0] = f64::from_bits(next as u64);
}

/// Fisher and Yates.
fn shuffle(values: &mut [u32], stream: &mut Stream) {
    for i in (1..values.len()).rev() {
        let j = (stream.uniform() * (i + 1) as f64) as usize;
        values.swap(i, j.min(i));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_meets_every_line_once_and_comes_back() {
        for (lines, group) in [(1, 1), (10, 3), (256, 64), (1000, 1000)] {
            let mut buffer = Buffer::new(lines, false).unwrap();
            chain(buffer.lines_mut(), group);
            let mut met = vec![false; lines];
            let (mut at, mut changes) = (0, 0);
            for _ in 0..lines {
                assert!(!std::mem::replace(&mut met[at], true));
                let next = follow(&buffer, at, 1);
                changes += usize::from(at / group != next / group);
                at = next;
            }
            assert_eq!(at, 0);
            // From group to group only when one is through.
            let groups = lines.div_ceil(group);
            assert_eq!(changes, if groups > 1 { groups } else { 0 });
        }
    }
}
