//! Streaming through large arrays: read, copy and triad on teams, and from node to node.

use super::buffer::{Buffer, LANES, LINE};
use super::memory;
use super::plan::{Seat, StreamKernel};
use super::team::{self, Pace, Worked};
use super::trouble::Trouble;
use super::vectors::{self, Set};
use crate::topology::Topology;

/// What the arrays hold.
const A: f64 = 1.0;
const B: f64 = 2.0;
const FACTOR: f64 = 3.0;

/// A member's arrays: a is written, b and c are read.
struct Arrays {
    a: Buffer,
    b: Buffer,
    c: Buffer,
    right: bool,
}

/// Times of every kernel of [`StreamKernel::available`] on a team.
pub fn streams(
    topology: &Topology,
    seats: &[Seat],
    lines: usize,
    pace: Pace,
) -> Result<Worked<()>, Trouble> {
    let kernels = StreamKernel::available();
    let set = Set::widest();
    let worked = team::work(
        topology,
        seats,
        kernels.len(),
        pace,
        |_| {
            Ok(Arrays {
                a: memory::near(lines, 0.0)?,
                b: memory::near(lines, A)?,
                c: memory::near(lines, B)?,
                right: true,
            })
        },
        |arrays: &mut Arrays, task| arrays.pass(set, kernels[task]),
        |arrays: &mut Arrays, task| arrays.pass(set, kernels[task]),
        |arrays| arrays.right,
    )?;
    checked(worked, "streaming")
}

impl Arrays {
    fn pass(&mut self, set: Set, kernel: StreamKernel) {
        let Self { a, b, c, right } = self;
        let last = a.lines().len() - 1;
        match kernel {
            StreamKernel::Read => {
                let sum = vectors::read(set, b.lines(), 1, b.lines().len(), 1);
                *right &= sum == A * (b.lines().len() * LANES) as f64;
            }
            StreamKernel::Copy(past) => {
                vectors::copy(set, past, c.lines(), a.lines_mut());
                *right &= [0, last].iter().all(|&i| a.lines()[i].0 == [B; LANES]);
            }
            StreamKernel::Triad(past) => {
                vectors::triad(set, past, b.lines(), c.lines(), FACTOR, a.lines_mut());
                let exact = [A + FACTOR * B; LANES];
                *right &= [0, last].iter().all(|&i| a.lines()[i].0 == exact);
            }
        }
    }
}

/// Bytes that a repetition of a kernel reads and writes on a team.
pub fn bytes(kernel: StreamKernel, seats: usize, lines: usize) -> u64 {
    (kernel.arrays() * seats * lines * LINE) as u64
}

/// Times of reading memory of a node.
pub fn nodes(
    topology: &Topology,
    seats: &[Seat],
    node: u32,
    lines: usize,
    pace: Pace,
) -> Result<Worked<()>, Trouble> {
    let set = Set::widest();
    let pass = |(buffer, right): &mut (Buffer, bool), _| {
        let sum = vectors::read(set, buffer.lines(), 1, lines, 1);
        *right &= sum == (lines * LANES) as f64;
    };
    let worked = team::work(
        topology,
        seats,
        1,
        pace,
        |_| Ok((memory::on_node(topology, node, lines)?, true)),
        pass,
        pass,
        |(_, right)| right,
    )?;
    checked(worked, "reading from node to node")
}

/// Times of multiply-adds in registers, and the operations of a repetition of the whole team.
pub fn arithmetic(
    topology: &Topology,
    seats: &[Seat],
    set: Set,
    pace: Pace,
) -> Result<(Worked<()>, u64), Trouble> {
    /// Less than a millisecond.
    const ROUNDS: usize = 100_000;
    let iterate = |(right, operations): &mut (bool, u64), _| {
        let (value, done) = vectors::multiply_add(set, ROUNDS);
        // The limit of x ← x/2 + 1.
        *right &= value == 2.0;
        *operations = done as u64;
    };
    let worked = team::work(
        topology,
        seats,
        1,
        pace,
        |_| Ok((true, 0)),
        iterate,
        iterate,
        |state| state,
    )?;
    let operations = worked
        .results
        .iter()
        .map(|(_, operations)| operations)
        .sum();
    let right = Worked {
        results: worked.results.iter().map(|(right, _)| *right).collect(),
        times: worked.times,
        unbound: worked.unbound,
    };
    Ok((checked(right, "arithmetic")?, operations))
}

/// Lets times through whose results were right.
pub fn checked(worked: Worked<bool>, what: &'static str) -> Result<Worked<()>, Trouble> {
    match worked.results.iter().all(|right| *right) {
        true => Ok(Worked {
            times: worked.times,
            results: Vec::new(),
            unbound: worked.unbound,
        }),
        false => Err(Trouble::Wrong { what }),
    }
}
