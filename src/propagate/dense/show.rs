//! A piece as the observer sees it: Legendre series of deflection and force.
//!
//! They follow from Taylor series of the structured generator, so that what is shown does not
//! depend on the kernel's tables.

use super::course::Course;
use super::generator::Generator;
use super::march::Piece;
use super::matrix::dot;
use crate::numerics::legendre::transforms24;
use crate::propagate::{Observer, Window};

/// Longest step of the series, in units of the fastest rate, and its terms: 2²⁸/28! is 10⁻²¹.
const REACH: f64 = 2.0;
const TERMS: usize = 28;

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

    /// The state at the end of the piece last shown.
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

    /// Hands `Lᵏ z / k!`, k = 0 … `last`, to `see`.
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
            for v in &mut self.next {
                *v /= k as f64;
            }
            std::mem::swap(&mut self.term, &mut self.next);
            see(k, &self.term);
        }
    }

    /// `z = e^{L time} z` by the terms up to `last`.
    pub fn step(&mut self, generator: &Generator, time: f64, last: usize, z: &mut [f64]) {
        self.term.copy_from_slice(z);
        for k in 1..=last {
            generator.apply(&self.term, &mut self.next);
            let scale = time / k as f64;
            for (v, z) in self.next.iter_mut().zip(z.iter_mut()) {
                *v *= scale;
                *z += *v;
            }
            std::mem::swap(&mut self.term, &mut self.next);
        }
    }
}

/// Shows the first `duration` of a piece that starts at `time` from the state `start`.
pub(super) fn show<O: Observer>(
    course: &Course<'_>,
    piece: &Piece,
    cycle: u64,
    time: f64,
    duration: f64,
    start: &[f64],
    picture: &mut Picture,
    observer: &mut O,
) {
    let generator = course.generator(piece.cell, piece.contact);
    let segment = &course.model.cycle.segments[course.grid.cells[piece.cell].segment];
    let transforms = transforms24();
    let (mut deflection, mut force) = ([0.0; 24], [0.0; 24]);
    picture.state.copy_from_slice(start);
    let chunks = (course.grid.rate * duration / REACH).ceil().max(1.0);
    let step = duration / chunks;
    let mut node = 0;
    for chunk in 0..chunks as usize {
        let from = step * chunk as f64;
        let (mut places, mut rates) = ([0.0; TERMS + 1], [0.0; TERMS + 1]);
        let Picture { state, end, taylor } = picture;
        end.fill(0.0);
        let mut power = 1.0;
        taylor.terms(generator, state, TERMS, |k, term| {
            places[k] = dot(&generator.deflection, term);
            rates[k] = dot(&generator.rate, term);
            for (end, term) in end.iter_mut().zip(term) {
                *end += power * term;
            }
            power *= step;
        });
        std::mem::swap(state, end);
        let last = chunk + 1 == chunks as usize;
        while let Some(x) = transforms.nodes().get(node) {
            let place = 0.5 * (x + 1.0) * duration;
            if place > from + step && !last {
                break;
            }
            let at =
                |series: &[f64]| (series.iter().rev()).fold(0.0, |sum, c| sum * (place - from) + c);
            deflection[node] = at(&places);
            force[node] = (course.model).force(
                segment,
                piece.contact,
                time + place,
                deflection[node],
                at(&rates),
            );
            node += 1;
        }
    }
    let n = course.layout.modes;
    observer.window(&Window {
        cycle,
        start: time,
        duration,
        segment,
        contact: piece.contact,
        deflection: &transforms.interpolate(&deflection),
        force: &transforms.interpolate(&force),
        first: &start[..n],
        second: &start[n..2 * n],
    });
}
