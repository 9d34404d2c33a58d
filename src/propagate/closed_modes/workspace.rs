//! What an integration works on.

use super::ClosedModes;
use super::bases::padded;
use super::search::Known;
use crate::model::{ActiveSet, Segment, TrajectoryState};
use crate::propagate::Tangents;
use crate::propagate::vectors::Lanes;

/// Scratch memory of the kernel of closed modes.
#[derive(Debug)]
pub struct Workspace {
    /// y of the trajectory, then of its tangents: padded states in the coordinates of `set`.
    pub states: Vec<f64>,
    /// Room for as many.
    pub spare: Vec<f64>,
    /// The system whose coordinates they are.
    pub set: usize,
    /// Values of the inputs now, and a zero that makes their number even.
    pub inputs: Vec<f64>,
    /// Inputs at a time that a search asks for.
    pub trial: Vec<f64>,
    /// Numbers of a padded state.
    pub length: usize,
    /// What each line sees on the present block.
    pub seen: Vec<Seen>,
    /// Line of each contact.
    pub line_of: Vec<usize>,
    /// The next stop of the present cycle.
    pub next_stop: usize,
    /// The segment of every contact, where windows are shown.
    pub segments: Vec<Segment>,

    /// State of the structure where a window starts, where windows are shown.
    pub shown: Vec<f64>,
}

/// What a line sees on the present block.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Deflection at its start \[m\].
    pub start: f64,
    /// Deflections at its nodes \[m\].
    pub nodes: Lanes,
    /// Bounds.
    pub known: Known,
    /// Whether nodes and bounds are those of the present block.
    pub fresh: bool,
}

impl Workspace {
    /// Room for a trajectory without tangents.
    pub fn new(kernel: &ClosedModes<'_>) -> Self {
        let model = kernel.model;
        let padded = padded(model.modes());
        let inputs = vec![0.0; kernel.frequencies.inputs() + 1];
        Self {
            states: Vec::new(),
            spare: Vec::new(),
            set: 0,
            length: 2 * padded,
            trial: inputs.clone(),

            inputs,
            seen: vec![
                Seen {
                    start: 0.0,
                    nodes: Lanes::ZERO,
                    known: Known {
                        curvature: 0.0,
                        noise: 0.0,
                    },
                    fresh: false,
                };
                model.lines.len()
            ],
            line_of: vec![0; model.contacts.len()],
            next_stop: 0,
            segments: model.segments_at(0, 0.0),
            shown: vec![0.0; 2 * padded],
        }
    }

    /// Puts the trajectory's modal state where [`Self::states`] begin.
    pub fn put_state(&mut self, state: &[f64]) {
        self.states.clear();
        self.states.resize(self.length, 0.0);
        pad(state, &mut self.states);
    }

    /// Appends the modal states of tangents.
    pub fn put_tangents(&mut self, tangents: &Tangents) {
        let length = self.length;
        for i in 0..tangents.count() {
            let from = self.states.len();
            self.states.resize(from + length, 0.0);
            pad(tangents.vector(i), &mut self.states[from..]);
        }
    }

    /// Hands modal states back.
    pub fn take(&self, trajectory: &mut TrajectoryState, tangents: &mut Tangents) {
        let length = self.length;
        let mut states = self.states.chunks_exact(length);
        if let Some(first) = states.next() {
            unpad(first, &mut trajectory.state);
        }
        for (i, state) in states.enumerate() {
            unpad(state, tangents.vector_mut(i));
        }
    }

    /// The trajectory's modal state where a window starts, first and second components.
    pub fn components(&self, modes: usize) -> [&[f64]; 2] {
        let (first, second) = self.shown.split_at(self.length / 2);
        [&first[..modes], &second[..modes]]
    }

    /// Begins a cycle with some lines of the contacts.
    pub fn begin(&mut self, line_of: impl Iterator<Item = usize>) {
        for (line, now) in self.line_of.iter_mut().zip(line_of) {
            *line = now;
        }
        self.next_stop = 0;
    }
}

/// Where an integration stands.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within it \[s\].
    pub time: f64,
    /// Closed contacts.
    pub active: ActiveSet,
    /// Contacts that opened or closed here.
    pub crossed: ActiveSet,
}

fn pad(from: &[f64], to: &mut [f64]) {
    let (n, padded) = (from.len() / 2, to.len() / 2);
    to[..n].copy_from_slice(&from[..n]);
    to[padded..padded + n].copy_from_slice(&from[n..]);
}

fn unpad(from: &[f64], to: &mut [f64]) {
    let (n, padded) = (to.len() / 2, from.len() / 2);
    to[..n].copy_from_slice(&from[..n]);
    to[n..].copy_from_slice(&from[padded..padded + n]);
}
