//! Inner loops of a full window.

use super::columns::{GROUPS, add_terms, combine, in_batches, load, series, store};
use super::varying::{deflection_columns, force_columns};
use crate::propagate::vectors::Vector;
use crate::propagate::volterra::feedback::{ContactSolve, Feedback};
use crate::propagate::volterra::shapes::{GapError, LANES, Lanes, Row, Series, TERMS};

/// Deflection on a window.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Solution {
    /// Series of δ \[m\].
    pub deflection: Series,
    /// `Σ_{n≥1} |deflection[n]|` \[m\]: the largest possible distance of δ from `deflection[0]`.
    pub variation: f64,
    /// `Σ |d[n]|` of the free deflection \[m\]; round-off is proportional to it.
    pub size: f64,
}

impl Solution {
    /// No motion.
    pub const ZERO: Self = Self {
        deflection: [0.0; TERMS],
        variation: 0.0,
        size: 0.0,
    };

    /// The solution with this series of δ. `free` is `Σ |d[n]|` of the free deflection.
    pub fn of(deflection: &Row, free: f64) -> Self {
        Self {
            deflection: deflection.0,
            variation: size(&deflection.0) - deflection.0[0].abs(),
            size: free,
        }
    }

    /// Adds the gap error of the closed side: δ − s e becomes δ.
    pub fn add_gap_error(&mut self, gap_error: Option<&GapError>) {
        for (n, (term, a)) in (self
            .deflection
            .iter_mut()
            .zip(gap_error.into_iter().flatten()))
        .enumerate()
        {
            *term += a;
            self.variation += if n > 0 { a.abs() } else { 0.0 };
        }
    }
}

/// D, E and the inputs' responses, chunk after chunk: D row by row (4 lane groups), then two components per force
/// term and per input.
#[derive(Debug)]
pub struct Windows {
    chunks: Vec<Chunk>,
    data: Vec<Lanes>,
}

/// Position of a chunk's numbers.
#[derive(Debug, Clone, Copy)]
struct Chunk {
    start: usize,
    end: usize,
    /// Number of force terms that act on its blocks.
    terms: usize,
}

impl Windows {
    /// Zeroed memory for chunks with the given numbers of force terms, each an even number, and `inputs` inputs.
    pub fn new(terms: &[usize], inputs: usize) -> Self {
        let mut start = 0;
        let chunks: Vec<_> = (terms.iter())
            .map(|&terms| {
                let end = start + 4 + 2 * (terms + inputs);
                let chunk = Chunk { start, end, terms };
                start = end;
                chunk
            })
            .collect();
        Self {
            chunks,
            data: vec![Lanes::ZERO; start],
        }
    }

    /// Number of stored numbers.
    pub fn numbers(&self) -> usize {
        self.data.len() * LANES
    }

    /// Sets the propagator of a block.
    pub fn set_propagator(&mut self, block: usize, d: [[f64; 2]; 2]) {
        let start = self.chunks[block / LANES].start;
        for (k, value) in d.as_flattened().iter().enumerate() {
            self.data[start + k].0[block % LANES] = *value;
        }
    }

    /// Sets a block's response to a term of the force, unless its chunk omits that term.
    pub fn set_response(&mut self, block: usize, term: usize, e: [f64; 2]) {
        let chunk = self.chunks[block / LANES];
        if term < chunk.terms {
            self.set(chunk.start + 4 + 2 * term, block, e);
        }
    }

    /// Sets a block's response to an input.
    pub fn set_input(&mut self, block: usize, input: usize, e: [f64; 2]) {
        let chunk = self.chunks[block / LANES];
        self.set(chunk.start + 4 + 2 * (chunk.terms + input), block, e);
    }

    fn set(&mut self, at: usize, block: usize, e: [f64; 2]) {
        for (k, value) in e.into_iter().enumerate() {
            self.data[at + k].0[block % LANES] = value;
        }
    }
}

/// `Σ |a[n]|`.
#[inline(always)]
pub fn size(a: &Series) -> f64 {
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
pub(super) fn add_row<V: Vector>(sum: &mut Series, row: &Row, weight: f64) {
    let weight = V::splat(weight);
    for (sum, row) in sum.chunks_exact_mut(LANES).zip(row.0.chunks_exact(LANES)) {
        V::read(row).multiply_add(weight, V::read(sum)).write(sum);
    }
}

#[inline(always)]
pub(super) fn solve_body<V: Vector>(
    rows: &[Row],
    inputs: &[f64],
    columns: &[f64],
    contact: Option<(ContactSolve<'_>, f64, Option<&GapError>)>,
    forces: &mut [Row],
    out: &mut Solution,
) {
    let (rows, of_inputs) = rows.split_at(rows.len() - inputs.len());
    let [mut driven] = combine::<V, 1>(of_inputs, &[inputs]);
    if let Some((closed, gap, gap_error)) = contact {
        if let Some(gap_error) = gap_error {
            for n in 0..gap_error.len() {
                driven.0[n] -= gap_error[n];
            }
        }
        in_batches!(V, forces.len(), |first| solve_batch(
            rows,
            &columns[first * rows.len()..],
            closed,
            (first == 0).then_some((&driven, gap)),
            &mut forces[first..],
            out,
        ));
    } else {
        let [mut free] = combine::<V, 1>(rows, &[&columns[..rows.len()]]);
        add_row::<V>(&mut free.0, &driven, 1.0);
        out.size = size(&free.0);
        out.variation = out.size - free.0[0].abs();
        out.deflection = free.0;
    }
}

#[inline(always)]
pub(super) fn free_body<V: Vector>(rows: &[Row], inputs: &[f64], columns: &[f64], out: &mut [Row]) {
    let (rows, of_inputs) = rows.split_at(rows.len() - inputs.len());
    let [driven] = combine::<V, 1>(of_inputs, &[inputs]);
    in_batches!(V, out.len(), |first| free_batch(
        rows,
        &columns[first * rows.len()..],
        &mut out[first..],
    ));
    if let Some(first) = out.first_mut() {
        add_row::<V>(&mut first.0, &driven, 1.0);
    }
}

#[inline(always)]
fn free_batch<V: Vector, const COLUMNS: usize>(rows: &[Row], columns: &[f64], out: &mut [Row]) {
    let mut x: [&[f64]; COLUMNS] = [&[]; COLUMNS];
    for c in 0..COLUMNS {
        x[c] = &columns[c * rows.len()..][..rows.len()];
    }
    out[..COLUMNS].copy_from_slice(&combine::<V, COLUMNS>(rows, &x));
}

#[inline(always)]
pub(super) fn yielded_body<V: Vector>(response: &[Row; TERMS], forces: &[Row], out: &mut [Row]) {
    in_batches!(V, forces.len(), |first| yielded_batch(
        response,
        &forces[first..],
        &mut out[first..],
    ));
}

#[inline(always)]
fn yielded_batch<V: Vector, const COLUMNS: usize>(
    response: &[Row; TERMS],
    forces: &[Row],
    out: &mut [Row],
) {
    if let Some(forces) = forces.first_chunk::<COLUMNS>() {
        let yielded = combine::<V, COLUMNS>(response, &series(forces));
        for c in 0..COLUMNS {
            add_row::<V>(&mut out[c].0, &yielded[c], -1.0);
        }
    }
}

#[inline(always)]
pub(super) fn close_body<V: Vector>(
    closed: ContactSolve<'_>,
    gap: f64,
    free: &[Row],
    next: &[Row],
    seen: &mut [Row],
    forces: &mut [Row],
) -> f64 {
    let mut farthest = 0.0_f64;
    for ((free, next), seen) in free.iter().zip(next).zip(&mut *seen) {
        let (mut change, mut scale) = (V::zero(), V::zero());
        for g in 0..GROUPS {
            let at = g * LANES;
            let (from, to) = (V::read(&seen.0[at..]), V::read(&next.0[at..]));
            change = from.multiply_add(V::splat(-1.0), to).size().plus(change);
            scale = V::read(&free.0[at..]).size().plus(to.size()).plus(scale);
        }
        let (change, scale) = (change.sum(), scale.sum());
        // An unchanged deflection is settled, even if its size is 0. NaN never settles.
        if change > 0.0 || change.is_nan() {
            let share = change / scale;
            if share > farthest || share.is_nan() {
                farthest = share;
            }
        }
        *seen = *next;
    }
    in_batches!(V, next.len(), |first| close_batch(
        closed,
        if first == 0 { gap } else { 0.0 },
        &next[first..],
        &mut forces[first..],
    ));
    farthest
}

#[inline(always)]
fn close_batch<V: Vector, const COLUMNS: usize>(
    closed: ContactSolve<'_>,
    gap: f64,
    next: &[Row],
    forces: &mut [Row],
) {
    if let Some(next) = next.first_chunk::<COLUMNS>() {
        let force = in_contact::<V, COLUMNS>(closed, next, gap);
        forces[..COLUMNS].copy_from_slice(&force);
    }
}

/// Forces of a batch of columns in contact. For the trajectory, which comes first and includes `driven` and the gap,
/// also the deflection.
#[inline(always)]
fn solve_batch<V: Vector, const COLUMNS: usize>(
    rows: &[Row],
    columns: &[f64],
    closed: ContactSolve<'_>,
    trajectory: Option<(&Row, f64)>,
    forces: &mut [Row],
    out: &mut Solution,
) {
    let mut x: [&[f64]; COLUMNS] = [&[]; COLUMNS];
    for c in 0..COLUMNS {
        x[c] = &columns[c * rows.len()..][..rows.len()];
    }
    let mut free = combine::<V, COLUMNS>(rows, &x);
    let mut gap = 0.0;
    if let Some((driven, error)) = trajectory {
        add_row::<V>(&mut free[0].0, driven, 1.0);
        out.size = size(&free[0].0);
        gap = error;
    }
    let force = in_contact::<V, COLUMNS>(closed, &free, gap);
    if trajectory.is_some() {
        out.deflection = match closed {
            ContactSolve::Table(feedback) => {
                let [mut deflection] = combine::<V, 1>(&feedback.deflection, &[&free[0].0]);
                add_row::<V>(&mut deflection.0, &feedback.gap[1], gap);
                deflection.0
            }
            ContactSolve::Factors(nodal, _) => {
                deflection_columns::<V>(nodal, &free[0], &force[0]).0
            }
        };
        out.variation = size(&out.deflection) - out.deflection[0].abs();
    }
    forces[..COLUMNS].copy_from_slice(&force);
}

/// Forces from free deflections; `gap` is that of the first column.
#[inline(always)]
fn in_contact<V: Vector, const COLUMNS: usize>(
    closed: ContactSolve<'_>,
    free: &[Row; COLUMNS],
    gap: f64,
) -> [Row; COLUMNS] {
    match closed {
        ContactSolve::Table(feedback) => feed_back::<V, COLUMNS>(feedback, free, gap),
        ContactSolve::Factors(nodal, factors) => {
            force_columns::<V, COLUMNS>(nodal, factors, free, gap)
        }
    }
}

/// As [`in_contact`], with the operator of a table.
#[inline(always)]
fn feed_back<V: Vector, const COLUMNS: usize>(
    feedback: &Feedback,
    free: &[Row; COLUMNS],
    gap: f64,
) -> [Row; COLUMNS] {
    let mut force = combine::<V, COLUMNS>(&feedback.force, &series(free));
    add_row::<V>(&mut force[0].0, &feedback.gap[0], gap);
    force
}

#[inline(always)]
pub(super) fn advance_body<V: Vector>(
    windows: &Windows,
    forces: &[Row],
    inputs: &[f64],
    columns: &mut [f64],
) {
    let length = 2 * LANES * windows.chunks.len();
    in_batches!(V, columns.len() / length, |first| advance_batch(
        windows,
        forces.get(first..).unwrap_or(&[]),
        if first == 0 { inputs } else { &[] },
        &mut columns[first * length..],
    ));
}

/// Moves a batch of columns; `inputs` act on the first of them.
#[inline(always)]
fn advance_batch<V: Vector, const COLUMNS: usize>(
    windows: &Windows,
    forces: &[Row],
    inputs: &[f64],
    columns: &mut [f64],
) {
    let padded = LANES * windows.chunks.len();
    let forces = forces.first_chunk::<COLUMNS>();
    for (index, chunk) in windows.chunks.iter().enumerate() {
        let (d, responses) = windows.data[chunk.start..chunk.end].split_at(4);
        let (responses, _) = responses.as_chunks::<2>();
        let (terms, rest) = responses.split_at(chunk.terms);
        let mut sums = [[[V::zero(); 2]; COLUMNS]; 2];
        for c in 0..COLUMNS {
            let x = load::<V>(&columns[2 * c * padded..], padded, index);
            for way in 0..2 {
                for i in 0..2 {
                    sums[way][c][i] = V::read(&d[2 * i + way].0).times(x[way]);
                }
            }
        }
        if let Some(forces) = forces {
            add_terms::<V, COLUMNS>(terms, &forces.each_ref(), &mut sums);
        }
        for (e, f) in rest.iter().zip(inputs) {
            for i in 0..2 {
                sums[0][0][i] = V::read(&e[i].0).multiply_add(V::splat(*f), sums[0][0][i]);
            }
        }
        for c in 0..COLUMNS {
            let x = [
                sums[0][c][0].plus(sums[1][c][0]),
                sums[0][c][1].plus(sums[1][c][1]),
            ];
            store(&mut columns[2 * c * padded..], padded, index, x);
        }
    }
}
