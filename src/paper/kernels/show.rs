//! A stretch in the form for observers: Legendre series of deflection and force.
//!
//! The series follow from Taylor series with the generator (`generator`), so that they do not depend on the tables.

use super::cell_model::CellModel;
use super::generator::Generator;
use super::matrix::{add_scaled, dot, scale};
use super::state_part::StatePart;
use crate::numerics::legendre::transforms24;
use crate::propagate::{ClosedContact, Observer, Window};

/// Largest product of a step and the fastest rate for the series, and its number of terms: 2²⁸/28! is 10⁻²¹.
const REACH: f64 = 2.0;
const TERMS: usize = 28;

/// Terms of a series below this fraction of the first are left out.
const NEGLIGIBLE: f64 = 1e-20;

/// Highest power of a series of the step `reach` ≤ [`REACH`].
fn terms_needed(reach: f64) -> usize {
    let mut size = 1.0;
    (1..TERMS)
        .find(|&k| {
            size *= reach / k as f64;
            size < NEGLIGIBLE
        })
        .unwrap_or(TERMS)
}

/// Scratch memory of [`show`].
#[derive(Debug)]
pub(super) struct Picture {
    state: Vec<f64>,
    end: Vec<f64>,
    taylor: Taylor,
}

impl Picture {
    /// Room for augmented states of `padded` doubles.
    pub fn new(padded: usize) -> Self {
        Self {
            state: vec![0.0; padded],
            end: vec![0.0; padded],
            taylor: Taylor::new(padded),
        }
    }

    /// The state at the end of the last shown stretch.
    pub fn last_state(&self) -> &[f64] {
        &self.state
    }
}

/// Scratch memory of a Taylor step.
#[derive(Debug)]
pub(super) struct Taylor {
    term: Vec<f64>,
    next: Vec<f64>,
}

impl Taylor {
    /// Room for augmented states of `padded` doubles.
    pub fn new(padded: usize) -> Self {
        Self {
            term: vec![0.0; padded],
            next: vec![0.0; padded],
        }
    }

    /// Passes `Lᵏ z / k!`, k = 0 … `last`, to `see`.
    pub fn terms(
        &mut self,
        generator: &Generator,
        z: &[f64],
        last: usize,
        mut see: impl FnMut(usize, &[f64]),
    ) {
        self.term.copy_from_slice(z);
        see(0, &self.term);
        for k in 1..=last {
            generator.apply(&self.term, &mut self.next);
            scale(1.0 / k as f64, &mut self.next);
            std::mem::swap(&mut self.term, &mut self.next);
            see(k, &self.term);
        }
    }

    /// `z = e^{L time} z`, with the terms up to `last`.
    pub fn step(&mut self, generator: &Generator, time: f64, last: usize, z: &mut [f64]) {
        self.term.copy_from_slice(z);
        for k in 1..=last {
            generator.apply(&self.term, &mut self.next);
            scale(time / k as f64, &mut self.next);
            add_scaled(1.0, &self.next, z);
            std::mem::swap(&mut self.term, &mut self.next);
        }
    }
}

/// Values of a power series at 24 times.
fn evaluate(series: &[f64], times: &[f64; 24]) -> [f64; 24] {
    let mut sums = [0.0; 24];
    for c in series.iter().rev() {
        for (sum, time) in sums.iter_mut().zip(times) {
            *sum = *sum * time + c;
        }
    }
    sums
}

/// Passes to the observer the first `duration` of a stretch that starts at `time` from the state `start`.
#[expect(
    clippy::too_many_arguments,
    reason = "the state of the published algorithms"
)]
pub(super) fn show<O: Observer>(
    cell_model: &CellModel<'_>,
    stretch: &StatePart,
    cycle: u64,
    time: f64,
    duration: f64,
    start: &[f64],
    picture: &mut Picture,
    observer: &mut O,
) {
    let generator = cell_model.generator(stretch.cell, stretch.contact);
    let segment =
        &cell_model.model.first_cycle().segments[cell_model.grid.cells[stretch.cell].segment];
    let transforms = transforms24();
    let (mut deflection, mut force) = ([0.0; 24], [0.0; 24]);
    picture.state.copy_from_slice(start);
    let chunk_count = (cell_model.grid.rate * duration / REACH).ceil().max(1.0);
    let step = duration / chunk_count;
    let last_term = terms_needed(cell_model.grid.rate * step);
    let mut node = 0;
    for chunk in 0..chunk_count as usize {
        let from = step * chunk as f64;
        let (mut places, mut rates) = ([0.0; TERMS + 1], [0.0; TERMS + 1]);
        let Picture { state, end, taylor } = picture;
        end.fill(0.0);
        let mut power = 1.0;
        places[0] = dot(&generator.deflection, state);
        taylor.terms(generator, state, last_term, |k, term| {
            rates[k] = dot(&generator.rate, term);
            if let Some(place) = places.get_mut(k + 1) {
                *place = rates[k] / (k + 1) as f64;
            }
            add_scaled(power, term, end);
            power *= step;
        });
        std::mem::swap(state, end);
        let last = chunk + 1 == chunk_count as usize;
        let place = |x: &f64| 0.5 * (x + 1.0) * duration;
        let ahead = &transforms.nodes()[node..];
        let within = if last {
            ahead.len()
        } else {
            ahead.partition_point(|x| place(x) <= from + step)
        };
        // Evaluate all nodes at once: for a single node, every sum would wait for the one before.
        let mut times = [0.0; 24];
        for (time, x) in times.iter_mut().zip(&ahead[..within]) {
            *time = place(x) - from;
        }
        let [shown, speeds] =
            [&places, &rates].map(|series| evaluate(&series[..=last_term], &times));
        for at in 0..within {
            deflection[node] = shown[at];
            if let Some(contact) = stretch.contact.only() {
                let contact = &cell_model.model.contacts[contact];
                let now = time + from + times[at];
                force[node] = contact.force(segment, now, shown[at], speeds[at]);
            }
            node += 1;
        }
    }
    let n = cell_model.layout.modes;
    let [deflection, force] = [deflection, force].map(|values| transforms.interpolate(&values));
    let closed = stretch.contact.only().map(|contact| ClosedContact {
        contact,
        deflection: &deflection,
        force: &force,
    });
    observer.window(&Window {
        cycle,
        start: time,
        duration,
        segments: &[*segment; 2],
        contact: stretch.contact,
        deflection: &deflection,
        force: &force,
        closed: closed.as_slice(),
        first: &start[..n],
        second: &start[n..2 * n],
        ..Window::default()
    });
}
