//! Loops of a full window.

use super::{LANES, Lanes, fma};
use crate::propagate::volterra::TERMS;
use crate::propagate::volterra::feedback::Feedback;
use crate::propagate::volterra::tables::{Row, Series};

/// Deflection and force on a window.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Solution {
    /// Series of δ \[m\].
    pub deflection: Series,
    /// Series of F \[N\]; meaningless in free flight.
    pub force: Series,
    /// `Σ_{n≥1} |deflection[n]|` \[m\]: the most by which δ can leave `deflection[0]`.
    pub variation: f64,
    /// `Σ |d[n]|` of the free deflection \[m\], of which round-off is a fraction.
    pub size: f64,
}

impl Solution {
    /// No motion.
    pub const ZERO: Self = Self {
        deflection: [0.0; TERMS],
        force: [0.0; TERMS],
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

/// `Σ weights[i] rows[i]`; both lengths are the same multiple of 4.
#[inline(always)]
pub(super) fn combine<const SET: u8>(rows: &[Row], weights: &[f64]) -> Series {
    // Four sums in flight hide the latency of the multiply-add.
    let mut sums = [[0.0; TERMS]; 4];
    for (row, weight) in rows.chunks_exact(4).zip(weights.chunks_exact(4)) {
        for u in 0..4 {
            for j in 0..TERMS {
                sums[u][j] = fma::<SET>(row[u].0[j], weight[u], sums[u][j]);
            }
        }
    }
    let mut out = [0.0; TERMS];
    for j in 0..TERMS {
        out[j] = (sums[0][j] + sums[1][j]) + (sums[2][j] + sums[3][j]);
    }
    out
}

/// `Σ |a[n]|`.
#[inline(always)]
pub(super) fn size(a: &Series) -> f64 {
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

/// `matrix d` for the columns of S̃ (`WHICH = 0`) or Q̃ (1), even and odd ones apart.
#[inline(always)]
fn feed_back<const SET: u8, const WHICH: usize>(feedback: &Feedback, d: &Series) -> Series {
    let (mut even, mut odd) = ([0.0; TERMS], [0.0; TERMS]);
    for (pair, weight) in feedback.columns.chunks_exact(2).zip(d.chunks_exact(2)) {
        add_row::<SET>(&mut even, &pair[0][WHICH], weight[0]);
        add_row::<SET>(&mut odd, &pair[1][WHICH], weight[1]);
    }
    for j in 0..TERMS {
        even[j] += odd[j];
    }
    even
}

#[inline(always)]
pub(super) fn solve_body<const SET: u8>(
    rows: &[Row],
    x: &[f64],
    contact: Option<(&Feedback, f64)>,
    out: &mut Solution,
) {
    let free = combine::<SET>(rows, x);
    out.size = size(&free);
    if let Some((feedback, gap)) = contact {
        let mut force = feed_back::<SET, 0>(feedback, &free);
        add_row::<SET>(&mut force, &feedback.gap[0], gap);
        let mut deflection = feed_back::<SET, 1>(feedback, &free);
        add_row::<SET>(&mut deflection, &feedback.gap[1], gap);
        out.variation = size(&deflection) - deflection[0].abs();
        out.force = force;
        out.deflection = deflection;
    } else {
        out.variation = out.size - free[0].abs();
        out.deflection = free;
    }
}

#[inline(always)]
pub(super) fn respond_body<const SET: u8>(rows: &[Row], x: &[f64], feedback: &Feedback) -> Series {
    feed_back::<SET, 0>(feedback, &combine::<SET>(rows, x))
}

#[inline(always)]
pub(super) fn advance_body<const SET: u8>(
    windows: &Windows,
    force: Option<&Series>,
    inputs: &[f64],
    x: &[f64],
    out: &mut [f64],
) {
    let chunks = windows.data.chunks_exact(windows.stride);
    let padded = chunks.len() * LANES;
    let (x1, x2) = x[..2 * padded].split_at(padded);
    let (y1, y2) = out[..2 * padded].split_at_mut(padded);
    let from = x1.chunks_exact(LANES).zip(x2.chunks_exact(LANES));
    let to = y1.chunks_exact_mut(LANES).zip(y2.chunks_exact_mut(LANES));
    for ((chunk, (a, b)), (ya, yb)) in chunks.zip(from).zip(to) {
        let (d, columns) = chunk.split_at(4);
        let (terms, rest) = columns.split_at(2 * TERMS);
        let (mut u, mut v) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        for l in 0..LANES {
            u[0][l] = d[0].0[l] * a[l];
            u[1][l] = d[1].0[l] * b[l];
            v[0][l] = d[2].0[l] * a[l];
            v[1][l] = d[3].0[l] * b[l];
        }
        if let Some(force) = force {
            for (e, f) in terms.chunks_exact(4).zip(force.chunks_exact(2)) {
                for i in 0..2 {
                    for l in 0..LANES {
                        u[i][l] = fma::<SET>(e[2 * i].0[l], f[i], u[i][l]);
                        v[i][l] = fma::<SET>(e[2 * i + 1].0[l], f[i], v[i][l]);
                    }
                }
            }
        }
        for (e, f) in rest.chunks_exact(2).zip(inputs) {
            for l in 0..LANES {
                u[0][l] = fma::<SET>(e[0].0[l], *f, u[0][l]);
                v[0][l] = fma::<SET>(e[1].0[l], *f, v[0][l]);
            }
        }
        for l in 0..LANES {
            ya[l] = u[0][l] + u[1][l];
            yb[l] = v[0][l] + v[1][l];
        }
    }
}
