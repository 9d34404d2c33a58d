//! Streaming through large arrays: read, copy and triad on teams, and from node to node.

use super::buffer::{Buffer, LANES, LINE};
use super::error::MeasurementError;
use super::measured::Measured;
use super::memory;
use super::plan::StreamKernel;
use super::team::{self, HardwareThread, RepetitionTime};
use super::vectors::{self, Set};
use crate::topology::Topology;

/// Contents of the arrays.
const A: f64 = 1.0;
const B: f64 = 2.0;
const FACTOR: f64 = 3.0;

/// The arrays of a member: it writes a, and reads b and c.
struct Arrays {
    a: Buffer,
    b: Buffer,
    c: Buffer,
    right: bool,
}

/// Times per repetition of each kernel on a team \[s\].
pub fn streams(
    topology: &Topology,
    team: &[HardwareThread],
    lines: usize,
    pace: RepetitionTime,
) -> Result<Measured, MeasurementError> {
    let (set, kernels) = (Set::widest(), StreamKernel::available());
    let results = team::work(
        topology,
        team,
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
        |arrays| (arrays.right, ()),
    )?;
    Ok(results.checked("streaming")?.into())
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

/// Bytes that all members read and write in a repetition of a kernel.
pub fn bytes(kernel: StreamKernel, members: usize, lines: usize) -> u64 {
    (kernel.arrays() * members * lines * LINE) as u64
}

/// Times per repetition in which a team reads the memory of a node \[s\].
pub fn nodes(
    topology: &Topology,
    team: &[HardwareThread],
    node: u32,
    lines: usize,
    pace: RepetitionTime,
) -> Result<Measured, MeasurementError> {
    let set = Set::widest();
    let pass = |(buffer, right): &mut (Buffer, bool), _| {
        let sum = vectors::read(set, buffer.lines(), 1, lines, 1);
        *right &= sum == (lines * LANES) as f64;
    };
    let results = team::work(
        topology,
        team,
        1,
        pace,
        |_| Ok((memory::on_node(topology, node, lines)?, true)),
        pass,
        pass,
        |(_, right)| (right, ()),
    )?;
    Ok(results.checked("reading from node to node")?.into())
}

/// Times per operation in registers \[s\], for the multiply-adds of the whole team.
pub fn arithmetic(
    topology: &Topology,
    team: &[HardwareThread],
    set: Set,
    pace: RepetitionTime,
) -> Result<Measured, MeasurementError> {
    /// Number of iterations, which take less than a millisecond.
    const ROUNDS: usize = 100_000;
    let iterate = |(right, operations): &mut (bool, u64), _| {
        let (value, done) = vectors::multiply_add(set, ROUNDS);
        // The limit of x ← x/2 + 1.
        *right &= value == 2.0;
        *operations = done as u64;
    };
    let results = team::work(
        topology,
        team,
        1,
        pace,
        |_| Ok((true, 0)),
        iterate,
        iterate,
        |state| state,
    )?;
    let checked = results.checked("arithmetic")?;
    let operations = checked.results.iter().sum::<u64>() as f64;
    Ok(checked.per_unit(&[operations]).into())
}
