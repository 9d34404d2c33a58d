//! The kernel of closed modes: each set of closed contacts in its own eigenvectors.
//!
//! While no contact opens, closes or changes its stiffness the drive is linear, and in the eigenvectors of its present
//! system ([`bases`]) every coordinate pair moves by itself. A block of a mesh cycle costs one 2 × 2 product a pair, and
//! the deflection of each line at eight nodes one small product. Bounds of the deflection's second derivative prove that
//! nothing happens between the nodes ([`search`]); what they cannot prove is halved. A change of the system is one dense
//! product. The bases depend on neither speed nor load nor gap: they are made once for a structure and its mesh.
//!
//! Inputs (constant torques, ripple, transmission errors) have steady responses in closed form ([`excitation`]): a state
//! is `z = y + steady · inputs`, and y moves without any input.

mod bases;
mod change;
mod cycle;
mod excitation;
mod grid;
mod lanes;
mod search;
mod seen;
mod sets;
mod shown;
mod system;
mod workspace;

use super::dense::KeptReader;
use super::vectors::InstructionSet;
use super::{DenseError, KeptTables, TableArray};
use crate::model::Model;
use bases::{Bases, Basis};
use excitation::Frequencies;
use sets::{Sets, Stop};
use system::System;

/// The kernel of closed modes for one model.
#[derive(Debug)]
pub struct ClosedModes<'m> {
    model: &'m Model,
    sets: Sets,
    bases: Bases<'m>,
    frequencies: Frequencies,
    /// At this operating point.
    systems: Vec<System>,
    /// Series of what each system sees along each line on a block, where windows are shown.
    series: Vec<Vec<shown::Series>>,
    stops: Vec<Vec<Stop>>,
    /// (cos, sin) of all frequencies over a block.
    turns: Vec<[f64; 2]>,
    /// Distance of nodes \[s\].
    step: f64,
    /// Blocks and stops of a mesh cycle.
    planned: usize,
    event_limit: u32,
    instructions: InstructionSet,
    farthest: Vec<f64>,
}

impl<'m> ClosedModes<'m> {
    /// Builds the kernel of a model, bases included.
    ///
    /// * `event_limit`: most events in a mesh cycle before integration stops.
    ///
    /// # Errors
    /// As for [`Self::arrays`], or an undamped mode in resonance with a harmonic.
    pub fn new(
        model: &'m Model,
        event_limit: u32,
        instructions: InstructionSet,
    ) -> Result<Self, DenseError> {
        let sets = Sets::new(model)?;
        let bases = Bases::new(model, &sets)?;
        Self::of_bases(model, event_limit, sets, bases, instructions)
    }

    /// The kernel of a model whose bases are kept, other arguments as for [`Self::new`]: they serve every speed, load and
    /// half gap.
    ///
    /// # Errors
    /// As for [`Self::new`], or the tables are not those of this model.
    pub fn of_kept(
        model: &'m Model,
        event_limit: u32,
        kept: &'m dyn KeptTables,
        instructions: InstructionSet,
    ) -> Result<Self, DenseError> {
        let sets = Sets::new(model)?;
        let mut reader = KeptReader::new(kept);
        let bases = Bases::read(model, &sets, &mut reader)?;
        reader.finish()?;
        Self::of_bases(model, event_limit, sets, bases, instructions)
    }

    fn of_bases(
        model: &'m Model,
        event_limit: u32,
        sets: Sets,
        bases: Bases<'m>,
        instructions: InstructionSet,
    ) -> Result<Self, DenseError> {
        let frequencies = Frequencies::new(model);
        let (step, blocks) = grid::step(model, &sets, &bases, &frequencies);
        let stops = sets.stops(model);
        for set in 0..sets.count() {
            resonates(model, bases.of(set), &frequencies)?;
        }
        let systems = (0..sets.count())
            .map(|set| {
                let closed: Vec<_> = sets.closed(set).collect();
                System::new(model, bases.of(set), &closed, &frequencies, step)
            })
            .collect();
        let mut own = Self {
            systems,
            series: Vec::new(),
            planned: blocks as usize + stops.iter().map(Vec::len).max().unwrap_or(0),
            farthest: super::farthest(model),
            turns: frequencies.turns(grid::NODES as f64 * step),
            model,
            sets,
            bases,
            frequencies,
            stops,
            step,
            event_limit,
            instructions,
        };
        own.series = (0..own.sets.count())
            .map(|set| own.series_of(set))
            .collect();
        Ok(own)
    }

    /// The bases of a model as arrays to be kept.
    ///
    /// # Errors
    /// Stiffness that varies within a segment, flanks with errors, contacts that let go by force, coupled modes, too many
    /// sets of closed contacts, eigenvectors too nearly parallel.
    pub fn arrays(model: &Model) -> Result<Vec<TableArray>, DenseError> {
        bases::arrays(model)
    }

    /// A system at this operating point.
    #[inline]
    fn system(&self, set: usize) -> &System {
        &self.systems[set]
    }
}

/// Refuses an undamped block that turns with a harmonic.
fn resonates(
    model: &Model,
    basis: &Basis<'_>,
    frequencies: &Frequencies,
) -> Result<(), DenseError> {
    for &[omega, _] in &frequencies.all {
        if (0..model.modes()).any(|i| excitation::in_resonance(&basis.block(i), omega)) {
            return Err(DenseError::Resonance { frequency: omega });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
