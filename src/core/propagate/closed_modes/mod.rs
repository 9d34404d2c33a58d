//! The kernel of closed modes: it integrates in the eigenvectors of the system with the present closed contacts.
//!
//! While no contact opens, closes or changes its stiffness, the drive is linear. In the eigenvectors of its present
//! system ([`bases`]) every pair of coordinates moves independently. A block of time has eight nodes. It costs one
//! 2 × 2 product per pair, and one small product for the deflection of each line at the nodes. Bounds of the
//! deflection's second derivative prove that there is no event between nodes ([`search`]); intervals without such a
//! proof are halved. A change of the system is one dense product. The bases do not depend on load or gap, and on the
//! speed only with gyroscopic terms. If there are few sets of closed contacts, all bases are computed once for a
//! structure and its mesh. Otherwise the kernel computes the bases of the sets that a motion reaches ([`build_slot`]).
//!
//! Inputs (constant torques, ripple, transmission errors) have steady responses in closed form ([`excitation`]):
//! a state is `z = y + steady · inputs`, and y moves without input. Only very slow blocks keep a constant input.

mod bases;
mod basis;
mod block_check;
mod build_slot;
mod change;
mod cycle;
mod cycle_integration;
mod excitation;
mod first_event;
mod grid;
mod lanes;
mod reached_sets;
mod search;
mod series;
mod sets;
mod shown;
mod side_by_side;
mod slot;
mod slots;
mod system;
mod workspace;

pub use side_by_side::{
    MOST_MODES, PointTables, Seat, SideBySide, map_side_by_side, work_side_by_side,
};

use super::vectors::InstructionSet;
use super::{KeptReader, KeptTables, TableArray, TableError, TableSize};
use crate::model::Model;
use bases::Bases;
use excitation::{Frequencies, unresonant};
use lanes::MixedModes;
use reached_sets::MOST_BYTES;
use sets::{CycleBreakpoint, Sets};
use slot::Slot;
use slots::Slots;
use std::sync::atomic::AtomicUsize;
use std::sync::{Arc, OnceLock};

/// The kernel of closed modes for one model.
#[derive(Debug)]
pub struct ClosedModes<'m> {
    model: &'m Model,
    sets: Sets,
    bases: Bases<'m>,
    frequencies: Frequencies,
    /// The systems reached so far at this operating point.
    slots: Slots<Slot<'m>>,
    /// Bytes of the bases of these systems.
    used_bytes: AtomicUsize,
    /// Reason why one of these systems has no table.
    refusal: OnceLock<TableError>,
    breakpoints: Vec<Vec<CycleBreakpoint>>,
    /// State that every contact has if it is closed, and its line, at the start of each mesh cycle of a base
    /// period.
    starts: Vec<Vec<(usize, usize)>>,
    /// (cos, sin) of the angle by which each frequency turns from the start of a block to each node.
    turns: Vec<Vec<[f64; 2]>>,
    /// The modes that changes of the system mix.
    mixed: MixedModes,
    /// Distance between nodes \[s\].
    step: f64,
    /// Nodes per second.
    per_step: f64,
    /// Number of blocks of a mesh cycle without events, plus its largest number of breakpoints.
    planned: usize,
    event_limit: u32,
    instructions: InstructionSet,
    farthest: Vec<f64>,
    /// Tables for [`SideBySide`], built when first used. The inner value is `None` if the model is not
    /// suitable.
    point_tables: OnceLock<Option<Arc<PointTables>>>,
}

impl<'m> ClosedModes<'m> {
    /// Largest number of sets of closed contacts for which all tables are computed. With more sets, tables
    /// are computed only for the sets that a motion reaches.
    pub const MOST_PRECOMPUTED: usize = Sets::MOST_PRECOMPUTED;

    /// Builds the kernel of a model, bases included.
    ///
    /// * `event_limit`: largest number of events in a mesh cycle before integration stops.
    ///
    /// # Errors
    /// As for [`Self::arrays`], or an undamped mode in resonance with a harmonic.
    pub fn new(
        model: &'m Model,
        event_limit: u32,
        instructions: InstructionSet,
    ) -> Result<Self, TableError> {
        let (sets, _) = suited(model)?;
        let bases = Bases::new(model, &sets)?;
        Self::of_bases(model, event_limit, sets, bases, instructions)
    }

    /// Builds the kernel of a model from kept bases. They are valid for every load and half gap, and for every speed
    /// that does not change the structure. See [`Self::new`] for the other arguments.
    ///
    /// # Errors
    /// As for [`Self::new`], or if the tables belong to another model.
    pub fn from_kept(
        model: &'m Model,
        event_limit: u32,
        kept: &'m dyn KeptTables,
        instructions: InstructionSet,
    ) -> Result<Self, TableError> {
        let (sets, bases) = read(model, kept)?;
        Self::of_bases(model, event_limit, sets, bases, instructions)
    }

    /// Checks the conditions of [`Self::arrays`] without computing eigenvectors. Returns the number of
    /// systems and the size of their tables \[bytes\], including the maps between systems.
    ///
    /// # Errors
    /// As for [`Self::arrays`], except nearly parallel eigenvectors.
    pub fn suits(model: &Model) -> Result<TableSize, TableError> {
        suited(model).map(|(_, size)| size)
    }

    /// Checks the conditions of [`Self::from_kept`] without building the kernel.
    ///
    /// # Errors
    /// As for [`Self::from_kept`].
    pub fn check_kept(model: &Model, kept: &dyn KeptTables) -> Result<(), TableError> {
        let (sets, bases) = read(model, kept)?;
        all_unresonant(model, &sets, &bases, &Frequencies::new(model))
    }

    fn of_bases(
        model: &'m Model,
        event_limit: u32,
        sets: Sets,
        bases: Bases<'m>,
        instructions: InstructionSet,
    ) -> Result<Self, TableError> {
        let frequencies = Frequencies::new(model);
        let (step, blocks) = grid::step(model, &bases, &frequencies);
        let breakpoints = sets.breakpoints(model);
        all_unresonant(model, &sets, &bases, &frequencies)?;
        let kernel = Self {
            slots: if sets.are_few() {
                Slots::of_all(sets.count())
            } else {
                Slots::hashed(MOST_BYTES / reached_sets::bytes(model.modes()))
            },
            used_bytes: AtomicUsize::new(0),
            refusal: OnceLock::new(),
            point_tables: OnceLock::new(),
            planned: blocks as usize + breakpoints.iter().map(Vec::len).max().unwrap_or(0),
            farthest: super::farthest(model),
            starts: sets.starts(model),
            turns: (1..=grid::NODES)
                .map(|node| frequencies.turns(node as f64 * step))
                .collect(),
            mixed: bases.mixed(model.modes()),
            model,
            sets,
            bases,
            frequencies,
            breakpoints,
            per_step: 1.0 / step,
            step,
            event_limit,
            instructions,
        };
        if kernel.sets.are_few() {
            // Slots are built now, so that an integrated cycle allocates nothing.
            for set in 0..kernel.sets.count() {
                kernel.slot_or_build(set)?;
                kernel.series(set);
            }
        }
        Ok(kernel)
    }

    /// Upper bound of the rates of all systems and inputs \[1/s\].
    fn fastest(&self) -> f64 {
        2.0 * lanes::SHORT * self.per_step
    }

    /// Reason why a motion was stopped at a set of closed contacts without a table, if one was.
    pub fn refusal(&self) -> Option<TableError> {
        self.refusal.get().copied()
    }

    /// The bases of a model as arrays to be kept.
    ///
    /// # Errors
    /// Stiffness that is negative or varies within a segment, flanks with errors, contacts that do not open at the gap,
    /// too many sets of closed contacts, too large tables, eigenvectors too nearly parallel.
    pub fn arrays(model: &Model) -> Result<Vec<TableArray>, TableError> {
        let (sets, _) = suited(model)?;
        bases::arrays(model, &sets)
    }
}

/// The systems of a model for which tables are computed, and the size of the tables.
fn suited(model: &Model) -> Result<(Sets, TableSize), TableError> {
    let sets = Sets::new(model)?;
    let size = bases::size(model.modes(), &sets);
    if size.bytes <= MOST_BYTES {
        Ok((sets, size))
    } else {
        Err(TableError::TooLarge {
            size,
            most: MOST_BYTES,
        })
    }
}

/// The sets of closed contacts of a model, with their modal bases from the stored tables.
fn read<'k>(model: &Model, kept: &'k dyn KeptTables) -> Result<(Sets, Bases<'k>), TableError> {
    let sets = Sets::new(model)?;
    let mut reader = KeptReader::new(kept);
    let bases = Bases::read(model, &sets, &mut reader, kept.shared_storage())?;
    reader.finish()?;
    Ok((sets, bases))
}

/// Refuses an undamped block in resonance with a harmonic. Systems built on demand are checked when they are built.
fn all_unresonant(
    model: &Model,
    sets: &Sets,
    bases: &Bases<'_>,
    frequencies: &Frequencies,
) -> Result<(), TableError> {
    if let Bases::All { bases, .. } = bases {
        for set in 0..sets.count() {
            unresonant(model, &bases[set], frequencies)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
