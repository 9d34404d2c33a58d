//! The eigenvectors of each system of a structure and its mesh, and the maps of states from one system to another.

use super::basis::{Basis, FoundBasis, Map, columns, padded};
use super::lanes::MixedModes;
use super::reached_sets::ReachedSets;
use super::sets::Sets;
use crate::model::{Block, Model};
use crate::propagate::{KeptReader, KeptWriter, SharedStorage, TableArray, TableError, TableSize};
use std::sync::Arc;

/// The bases of a structure and its mesh.
#[derive(Debug)]
pub enum Bases<'t> {
    /// The bases of all systems, if these are few.
    All {
        /// One per system, in order.
        bases: Vec<Arc<Basis<'t>>>,
        /// For each system, the maps to the systems that a change of one contact leads to, except free
        /// flight. Each entry has the contact, its state after the change, and the map.
        changes: Vec<Vec<(usize, usize, Map<'t>)>>,
    },
    /// The bases of the systems that motions reach.
    Reached {
        /// Fastest rate of all systems \[1/s\].
        fastest: f64,
        /// The bases computed so far.
        reached: Arc<ReachedSets>,
    },
}

impl<'t> Bases<'t> {
    /// Computes the bases of all systems if these are few, or else only the fastest rate: each basis then follows when
    /// a motion reaches its system.
    ///
    /// # Errors
    /// As for [`arrays`].
    pub fn new(model: &Model, sets: &Sets) -> Result<Self, TableError> {
        if !sets.are_few() {
            return Ok(Self::Reached {
                fastest: fastest(&stiffest(model, sets)?),
                reached: Arc::default(),
            });
        }
        let found_bases: Vec<FoundBasis> = (0..sets.count())
            .map(|set| FoundBasis::new(model, sets, set))
            .collect::<Result<_, _>>()?;
        let changes = (0..sets.count()).map(|set| {
            between(sets, set)
                .map(|(contact, state)| {
                    let to = &found_bases[sets.with(set, contact, state)];
                    let map = columns(&(&to.from_modes * &found_bases[set].to_modes));
                    (contact, state, map)
                })
                .collect()
        });
        Ok(Self::All {
            changes: changes.collect(),
            bases: (found_bases.iter().enumerate())
                .map(|(set, found_basis)| Arc::new(found_basis.basis(set)))
                .collect(),
        })
    }

    /// Reads the bases that [`arrays`] returned. Kernels of the same structure share the bases of the sets
    /// that they reach in `shared_storage`.
    ///
    /// # Errors
    /// They belong to another model.
    pub fn read(
        model: &Model,
        sets: &Sets,
        kept: &mut KeptReader<'t>,
        shared_storage: Option<&SharedStorage>,
    ) -> Result<Self, TableError> {
        let n = model.modes();
        if !sets.are_few() {
            return Ok(Self::Reached {
                fastest: fastest(kept.take("generators", 4 * n)?),
                reached: ReachedSets::stored_in(shared_storage),
            });
        }
        let (mut bases, mut all_changes) = (Vec::new(), Vec::new());
        for set in 0..sets.count() {
            let mut map = |name| -> Result<_, TableError> {
                Ok(Map::Kept(kept.take(name, 4 * n * padded(n))?))
            };
            let maps = match set {
                Sets::FREE => None,
                _ => Some([map("to_modes")?, map("from_modes")?]),
            };
            let changes = between(sets, set)
                .map(|(contact, state)| Ok((contact, state, map("changes")?)))
                .collect::<Result<_, TableError>>()?;
            all_changes.push(changes);
            let generators = kept.take("generators", 4 * n)?.into();
            bases.push(Arc::new(Basis { generators, maps }));
        }
        Ok(Self::All {
            bases,
            changes: all_changes,
        })
    }

    /// The basis of a set.
    ///
    /// # Errors
    /// The set is reached for the first time, and its eigenvectors are too nearly parallel.
    pub fn of(&self, model: &Model, sets: &Sets, set: usize) -> Result<Arc<Basis<'t>>, TableError> {
        match self {
            Self::All { bases, .. } => Ok(bases[set].clone()),
            Self::Reached { reached, .. } => reached.basis(model, sets, set),
        }
    }

    /// The map from a system with closed contacts to another one, in which `contact` has the state `state`.
    /// `None` if there is no table of this map.
    #[inline]
    pub fn change(&self, set: usize, contact: usize, state: usize) -> Option<&Map<'t>> {
        let Self::All { changes, .. } = self else {
            return None;
        };
        (changes[set].iter())
            .find(|(known, behind, _)| (*known, *behind) == (contact, state))
            .map(|(_, _, map)| map)
    }

    /// The modes that maps between systems mix: all modes, if the maps are computed on demand.
    pub fn mixed(&self, modes: usize) -> MixedModes {
        let padded = padded(modes);
        let is_mixed = |mode: &usize| match self {
            Self::Reached { .. } => true,
            Self::All { bases, changes } => {
                let maps = bases.iter().filter_map(|basis| basis.maps.as_ref());
                let between = changes.iter().flatten().map(|(_, _, map)| map);
                (maps.flatten().chain(between)).any(|map| !leaves_alone(map, *mode, modes))
            }
        };
        let (mixed, others): (Vec<_>, Vec<_>) = (0..modes).partition(is_mixed);
        let mut alone = vec![0.0; 2 * padded];
        for mode in others {
            [alone[mode], alone[padded + mode]] = [1.0; 2];
        }
        MixedModes {
            all: modes,
            modes: mixed,
            alone,
        }
    }

    /// Fastest rate of a pair of coordinates in any system \[1/s\].
    pub fn fastest(&self) -> f64 {
        match self {
            Self::All { bases, .. } => (bases.iter())
                .map(|basis| fastest(&basis.generators))
                .fold(0.0, f64::max),
            Self::Reached { fastest, .. } => *fastest,
        }
    }
}

/// Whether a map has the columns and rows of a unit matrix at both components of a mode.
fn leaves_alone(map: &[f64], mode: usize, modes: usize) -> bool {
    let padded = padded(modes);
    let entries = [(mode, mode), (modes + mode, padded + mode)];
    entries.into_iter().all(|(place, row)| {
        let unit = |of: usize| f64::from(u8::from(of == place));
        let column = &map[2 * padded * place..][..2 * padded];
        (column.iter().enumerate()).all(|(i, x)| *x == f64::from(u8::from(i == row)))
            && (map.chunks_exact(2 * padded).enumerate()).all(|(j, column)| column[row] == unit(j))
    })
}

/// Fastest rate of some blocks, four numbers per block \[1/s\].
fn fastest(generators: &[f64]) -> f64 {
    let rate = |&[a, b, c, d]: &[f64; 4]| {
        let block = Block {
            generator: [[a, b], [c, d]],
            static_input: [0.0; 2],
        };
        let turns = block.damped_frequency().or(block.spread()).unwrap_or(0.0);
        block.growth().abs() + turns
    };
    let blocks = generators.as_chunks().0;
    blocks.iter().map(rate).fold(0.0, f64::max)
}

/// The blocks of the system in which every contact is closed at its stiffest. Its fastest rate is used for
/// all systems.
fn stiffest(model: &Model, sets: &Sets) -> Result<Vec<f64>, TableError> {
    let basis = FoundBasis::new(model, sets, sets.stiffest())?;
    Ok(basis.generators.as_flattened().as_flattened().to_vec())
}

/// The changes out of a closed set that do not lead to free flight.
fn between(sets: &Sets, set: usize) -> impl Iterator<Item = (usize, usize)> {
    let closed = move |&(contact, state): &(usize, usize)| {
        set != Sets::FREE && sets.with(set, contact, state) != Sets::FREE
    };
    sets.changes(set).into_iter().filter(closed)
}

/// Size of the arrays for a number of modes. With many sets, the arrays have only the generators of one
/// system.
pub fn size(modes: usize, sets: &Sets) -> TableSize {
    let maps = |set| match set {
        Sets::FREE => 0,
        _ => 2 + between(sets, set).count(),
    };
    let numbers = if sets.are_few() {
        (0..sets.count()).map(maps).sum::<usize>() * padded(modes) + sets.count()
    } else {
        1
    };
    TableSize {
        systems: sets.count(),
        bytes: 4 * modes * numbers * size_of::<f64>(),
    }
}

/// The bases of a model as arrays to be kept. They are valid for every load and gap, and for every speed that does not
/// change the structure.
///
/// # Errors
/// Eigenvectors too nearly parallel.
pub fn arrays(model: &Model, sets: &Sets) -> Result<Vec<TableArray>, TableError> {
    let mut out = KeptWriter::default();
    if !sets.are_few() {
        out.push("generators", "1/s", &stiffest(model, sets)?);
    } else if let Bases::All { bases, changes } = Bases::new(model, sets)? {
        for (basis, changes) in bases.iter().zip(&changes) {
            if let Some([to, from]) = &basis.maps {
                out.push("to_modes", "mixed", to);
                out.push("from_modes", "mixed", from);
            }
            for (_, _, map) in changes {
                out.push("changes", "mixed", map);
            }
            out.push("generators", "1/s", &basis.generators);
        }
    }
    Ok(out.finish())
}
