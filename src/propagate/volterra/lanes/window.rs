//! Loops of a full window.

use super::columns::{combine, in_batches, series};
use super::varying::{deflection_columns, force_columns};
use super::vectors::accumulate;
use super::{LANES, Lanes, fma};
use crate::propagate::volterra::TERMS;
use crate::propagate::volterra::feedback::{Closed, Feedback};
use crate::propagate::volterra::tables::{Row, Series};

/// Deflection on a window.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Solution {
    /// Series of δ \[m\].
    pub deflection: Series,
    /// `Σ_{n≥1} |deflection[n]|` \[m\]: the most by which δ can leave `deflection[0]`.
    pub variation: f64,
    /// `Σ |d[n]|` of the free deflection \[m\], of which round-off is a fraction.
    pub size: f64,
}

impl Solution {
    /// No motion.
    pub const ZERO: Self = Self {
        deflection: [0.0; TERMS],
        variation: 0.0,
        size: 0.0,
    };
}

/// D, E and the inputs' responses for all chunks of blocks, chunk after chunk: D row by row
/// (4 lane groups), then for every force term and every input the two components.
#[derive(Debug)]
pub struct Windows {
    /// Lane groups of one chunk.
    stride: usize,
    data: Vec<Lanes>,
}

impl Windows {
    /// Room for `chunks` chunks and `inputs` inputs, all zero.
    pub fn new(chunks: usize, inputs: usize) -> Self {
        let stride = 4 + 2 * (TERMS + inputs);
        Self {
            stride,
            data: vec![Lanes::ZERO; chunks * stride],
        }
    }

    /// Numbers held.
    pub fn numbers(&self) -> usize {
        self.data.len() * LANES
    }

    /// Sets the propagator of a block.
    pub fn set_propagator(&mut self, block: usize, d: [[f64; 2]; 2]) {
        let (chunk, lane) = (block / LANES, block % LANES);
        for (k, value) in d.as_flattened().iter().enumerate() {
            self.data[chunk * self.stride + k].0[lane] = *value;
        }
    }

    /// Sets a block's response to force term or input `column`; inputs follow the terms.
    pub fn set_response(&mut self, block: usize, column: usize, e: [f64; 2]) {
        let (chunk, lane) = (block / LANES, block % LANES);
        for (k, value) in e.into_iter().enumerate() {
            self.data[chunk * self.stride + 4 + 2 * column + k].0[lane] = value;
        }
    }
}

/// `Σ |a[n]|`.
#[inline(always)]
fn size(a: &Series) -> f64 {
    let mut sums = [0.0; LANES];
    for group in a.chunks_exact(LANES) {
        for l in 0..LANES {
            sums[l] += group[l].abs();
        }
    }
    ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
}

/// `sum += row · weight`.
#[inline(always)]
pub(super) fn add_row<const SET: u8>(sum: &mut Series, row: &Row, weight: f64) {
    for j in 0..TERMS {
        sum[j] = fma::<SET>(row.0[j], weight, sum[j]);
    }
}

#[inline(always)]
pub(super) fn solve_body<const SET: u8>(
    rows: &[Row],
    inputs: &[f64],
    columns: &[f64],
    contact: Option<(Closed<'_>, f64)>,
    forces: &mut [Row],
    out: &mut Solution,
) {
    let (rows, of_inputs) = rows.split_at(rows.len() - inputs.len());
    let [driven] = combine::<SET, 1>(of_inputs, &[inputs]);
    if let Some((closed, gap)) = contact {
        in_batches!(SET, forces.len(), |first| solve_batch(
            rows,
            &columns[first * rows.len()..],
            closed,
            (first == 0).then_some((&driven, gap)),
            &mut forces[first..],
            out,
        ));
    } else {
        let [mut free] = combine::<SET, 1>(rows, &[&columns[..rows.len()]]);
        add_row::<SET>(&mut free.0, &driven, 1.0);
        out.size = size(&free.0);
        out.variation = out.size - free.0[0].abs();
        out.deflection = free.0;
    }
}

/// Forces of a batch of columns in contact; of the trajectory, which comes first and has what
/// `driven` and the gap add, the deflection too.
#[inline(always)]
fn solve_batch<const SET: u8, const COLUMNS: usize>(
    rows: &[Row],
    columns: &[f64],
    closed: Closed<'_>,
    trajectory: Option<(&Row, f64)>,
    forces: &mut [Row],
    out: &mut Solution,
) {
    let mut x: [&[f64]; COLUMNS] = [&[]; COLUMNS];
    for c in 0..COLUMNS {
        x[c] = &columns[c * rows.len()..][..rows.len()];
    }
    let mut free = combine::<SET, COLUMNS>(rows, &x);
    let mut gap = 0.0;
    if let Some((driven, own)) = trajectory {
        add_row::<SET>(&mut free[0].0, driven, 1.0);
        out.size = size(&free[0].0);
        gap = own;
    }
    let force = match closed {
        Closed::Table(feedback) => feed_back::<SET, COLUMNS>(feedback, &free, gap),
        Closed::Factors(nodal, factors) => {
            force_columns::<SET, COLUMNS>(nodal, factors, &free, gap)
        }
    };
    if trajectory.is_some() {
        out.deflection = match closed {
            Closed::Table(feedback) => {
                let [mut deflection] = combine::<SET, 1>(&feedback.deflection, &[&free[0].0]);
                add_row::<SET>(&mut deflection.0, &feedback.gap[1], gap);
                deflection.0
            }
            Closed::Factors(nodal, _) => deflection_columns::<SET>(nodal, &free[0], &force[0]).0,
        };
        out.variation = size(&out.deflection) - out.deflection[0].abs();
    }
    forces[..COLUMNS].copy_from_slice(&force);
}

/// Forces from free deflections; `gap` is that of the first column.
#[inline(always)]
fn feed_back<const SET: u8, const COLUMNS: usize>(
    feedback: &Feedback,
    free: &[Row; COLUMNS],
    gap: f64,
) -> [Row; COLUMNS] {
    let mut force = combine::<SET, COLUMNS>(&feedback.force, &series(free));
    add_row::<SET>(&mut force[0].0, &feedback.gap[0], gap);
    force
}

#[inline(always)]
pub(super) fn advance_body<const SET: u8>(
    windows: &Windows,
    forces: &[Row],
    inputs: &[f64],
    columns: &mut [f64],
) {
    let length = 2 * LANES * (windows.data.len() / windows.stride);
    in_batches!(SET, columns.len() / length, |first| advance_batch(
        windows,
        forces.get(first..).unwrap_or(&[]),
        if first == 0 { inputs } else { &[] },
        &mut columns[first * length..],
    ));
}

/// Moves a batch of columns; `inputs` act on the first of them.
#[inline(always)]
fn advance_batch<const SET: u8, const COLUMNS: usize>(
    windows: &Windows,
    forces: &[Row],
    inputs: &[f64],
    columns: &mut [f64],
) {
    let chunks = windows.data.chunks_exact(windows.stride);
    let padded = chunks.len() * LANES;
    let forces = forces.first_chunk::<COLUMNS>();
    for (index, chunk) in chunks.enumerate() {
        let (d, responses) = chunk.split_at(4);
        let (terms, rest) = responses.split_at(2 * TERMS);
        let mut sums = [[[Lanes::ZERO; 2]; COLUMNS]; 2];
        for c in 0..COLUMNS {
            let at = 2 * c * padded + index * LANES;
            for way in 0..2 {
                let x = &columns[at + way * padded..][..LANES];
                for i in 0..2 {
                    for l in 0..LANES {
                        sums[way][c][i].0[l] = d[2 * i + way].0[l] * x[l];
                    }
                }
            }
        }
        if let Some(forces) = forces {
            accumulate::<SET, 2, COLUMNS, _>(terms, &series(forces), &mut sums);
        }
        for (e, f) in rest.chunks_exact(2).zip(inputs) {
            for i in 0..2 {
                for l in 0..LANES {
                    let sum = &mut sums[0][0][i].0[l];
                    *sum = fma::<SET>(e[i].0[l], *f, *sum);
                }
            }
        }
        for c in 0..COLUMNS {
            let at = 2 * c * padded + index * LANES;
            for i in 0..2 {
                let x = &mut columns[at + i * padded..][..LANES];
                for l in 0..LANES {
                    x[l] = sums[0][c][i].0[l] + sums[1][c][i].0[l];
                }
            }
        }
    }
}
