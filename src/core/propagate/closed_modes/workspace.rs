//! Scratch memory of an integration.

use super::ClosedModes;
use super::basis::padded;
use super::search::MarginBounds;
use super::sets::CycleBreakpoint;
use crate::model::{ActiveSet, Contact, Segment, TrajectoryState};
use crate::propagate::events::Margin;
use crate::propagate::tangents::{read_padded, write_padded};
use crate::propagate::vectors::{Aligned, Lanes};
use crate::propagate::{Stop, TableError, Tangents};

/// Scratch memory of the kernel of closed modes.
#[derive(Debug)]
pub struct Workspace {
    /// y of the trajectory, then of its tangents: padded states in the coordinates of `set`.
    pub states: Aligned,
    /// Memory of the same size: all states at the time `spare_time`, if there is one.
    pub spare: Aligned,
    /// Time \[s\] from the start of the present block to which a search has moved the inputs in
    /// `spare_inputs` and the states in `spare`. These states lack the contributions of constant inputs to
    /// drifting blocks.
    pub spare_time: Option<f64>,
    /// Memory for amplitudes of the trajectory's blocks.
    pub amplitudes: Aligned,
    /// Whether the bounds of an earlier block are valid in the present system.
    pub bounded: bool,
    /// The system whose coordinates `states` has.
    pub set: usize,
    /// Values of the inputs now, and a zero that makes their number even.
    pub inputs: Vec<f64>,
    /// Memory of the same size: values of the inputs at the time `spare_time`.
    pub spare_inputs: Vec<f64>,
    /// Length of a padded state.
    pub length: usize,
    /// Deflections and bounds of each line on the present block.
    pub line_states: Vec<LineState>,
    /// Line of each contact.
    pub line_of: Vec<usize>,
    /// State that each contact has if it is closed.
    pub closed: Vec<usize>,
    /// The distinct lines of all contacts.
    pub lines: Vec<usize>,
    /// Contacts that may open or close.
    pub watched: Vec<WatchedContact>,
    /// Index of the next breakpoint of the present cycle.
    pub next_breakpoint: usize,
    /// The next breakpoint that concerns the present system.
    pub breakpoint: Option<CycleBreakpoint>,
    /// State of the trajectory at the start of a window, then the values of the inputs, if windows are shown.
    pub weights: Vec<f64>,
    /// The segment of every contact at the start of a window.
    pub segments: Vec<Segment>,
    /// Time of the cycle up to which `segments` is valid \[s\].
    pub segments_end: f64,
    /// State of the trajectory at the start of a window, if observers read it: in the coordinates of `set`, and in
    /// modes.
    pub shown: [Aligned; 2],
}

/// Deflections and bounds of a line on the present block.
#[derive(Debug, Clone, Copy)]
pub struct LineState {
    /// Deflection at its start \[m\].
    pub start: f64,
    /// Its rate there \[m/s\]. It is valid at the start of a cycle and after events and shortened blocks.
    pub rate: f64,
    /// Deflections at its nodes \[m\].
    pub nodes: Lanes,
    /// Largest contributions of all blocks to the deflection \[m\], and of waves (blocks that oscillate) to its
    /// second derivative \[m/s²\].
    pub waves: [f64; 2],
    /// Bounds of the contact margins on this line (curvature, fastest rate, round-off).
    pub bounds: MarginBounds,
}

/// A contact that may open or close, with its margin `scale δ + shift`.
#[derive(Debug, Clone, Copy)]
pub struct WatchedContact {
    /// The contact.
    pub contact: usize,
    /// Its line.
    pub line: usize,
    /// Factor of δ, ±1.
    pub scale: f64,
    /// ± the half gap \[m\].
    pub shift: f64,
    /// Intervals of the present block in which it may open or close, the first in bit 0, and the bit `BEYOND`.
    pub open: u32,
}

impl WatchedContact {
    /// Its margin at a deflection \[m\].
    #[inline(always)]
    pub fn value(&self, deflection: f64) -> f64 {
        self.scale * deflection + self.shift
    }
}

impl Workspace {
    /// Memory for a trajectory without tangents.
    pub fn new(kernel: &ClosedModes<'_>) -> Self {
        let model = kernel.model;
        let padded = padded(model.modes());
        let mut inputs = vec![0.0; kernel.frequencies.inputs() + 1];
        inputs[0] = 1.0;
        Self {
            states: Aligned::zeros(2 * padded),
            spare: Aligned::zeros(2 * padded),
            spare_time: None,
            amplitudes: Aligned::zeros(padded),
            bounded: false,
            set: 0,
            length: 2 * padded,
            weights: vec![0.0; 2 * padded + inputs.len()],
            spare_inputs: inputs.clone(),
            inputs,
            line_states: vec![
                LineState {
                    start: 0.0,
                    rate: 0.0,
                    nodes: Lanes::ZERO,
                    waves: [0.0; 2],
                    bounds: MarginBounds {
                        curvature: 0.0,
                        fastest: 0.0,
                        noise: 0.0,
                    },
                };
                model.lines.len()
            ],
            line_of: vec![0; model.contacts.len()],
            closed: vec![0; model.contacts.len()],
            lines: Vec::with_capacity(model.lines.len()),
            watched: Vec::with_capacity(model.contacts.len()),
            next_breakpoint: 0,
            breakpoint: None,
            segments: model.segments_at(0, 0.0),
            segments_end: 0.0,
            shown: [0, 1].map(|_| Aligned::zeros(2 * padded)),
        }
    }

    /// Loads the modal states of a trajectory and its tangents.
    pub fn put(&mut self, state: &[f64], tangents: &Tangents) {
        let needed = self.length * (1 + tangents.count());
        // The padding of a state stays zero.
        self.states.set_length(needed);
        self.spare.set_length(needed);
        write_padded(&mut self.states, self.length, state, tangents);
    }

    /// Copies the modal states back.
    pub fn take(&self, trajectory: &mut TrajectoryState, tangents: &mut Tangents) {
        read_padded(&self.states, self.length, &mut trajectory.state, tangents);
    }

    /// The trajectory's modal state at the start of a window, first and second components.
    pub fn components(&self, modes: usize) -> [&[f64]; 2] {
        let (first, second) = self.shown[1].split_at(self.length / 2);
        [&first[..modes], &second[..modes]]
    }

    /// Begins a cycle. `starts` has the state of every contact if it is closed, and its line.
    pub fn begin(&mut self, starts: &[(usize, usize)]) {
        for (contact, &(state, line)) in starts.iter().enumerate() {
            self.closed[contact] = state;
            self.line_of[contact] = line;
        }
        self.next_breakpoint = 0;
        self.segments_end = 0.0;
    }

    /// Finds the lines and contacts to watch. An open contact is out of reach while a contact on the other side of its
    /// line is closed.
    pub fn find_watched_contacts(&mut self, contacts: &[Contact], active: ActiveSet) {
        self.lines.clear();
        self.watched.clear();
        for (contact, contact_data) in contacts.iter().enumerate() {
            let line = self.line_of[contact];
            if !self.lines.contains(&line) {
                self.lines.push(line);
            }
            let closed = active.holds(contact);
            let opposite = |other: usize| {
                self.line_of[other] == line && contacts[other].side == -contact_data.side
            };
            if closed || !active.iter().any(opposite) {
                let Margin { scale, shift, .. } = Margin::new(contact_data, contact, closed);
                self.watched.push(WatchedContact {
                    contact,
                    line,
                    scale,
                    shift,
                    open: 0,
                });
            }
        }
    }
}

/// The present time and contacts of an integration.
#[derive(Debug, Clone, Copy)]
pub struct CyclePosition {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within it \[s\].
    pub time: f64,
    /// Closed contacts.
    pub active: ActiveSet,
    /// Contacts that opened or closed at this time.
    pub crossed: ActiveSet,
}

impl CyclePosition {
    /// The error of a motion that has reached a system without a table.
    pub fn refused(&self, error: TableError) -> Stop {
        Stop::Refused {
            cycle: self.cycle,
            error,
        }
    }
}
