//! Fills a mesh table: one phase of the cycle is one piece of parallel work.

use super::super::friction::friction_direction;
use super::super::sharing::{Contact, Face, LoadSharing, MOST_PAIRS, SharingError, pairs_at};
use super::breaks::breaks;
use super::{MeshTable, MeshTableError, MeshTableInputs, NODES};
use crate::gear::FlankLaw;
use crate::numerics::legendre::transforms8;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What the mesh does at one phase under one load.
struct Cell {
    stiffness: f64,
    centre: f64,
    transmission_error: f64,
    friction: f64,
    friction_lever: f64,
    contact_fraction: f64,
    share: [f64; MOST_PAIRS],
    /// Line load on each slice; empty where it is not asked for.
    pattern: Vec<f64>,
}

impl MeshTable {
    /// Computes the table of a law, on the threads of the current rayon pool; the bits do not
    /// depend on them.
    ///
    /// * `progress(done, all)`: called after each of all phases, from any thread.
    ///
    /// # Errors
    /// Inputs outside their ranges, a path shorter than a base pitch, a law that gives
    /// unphysical values or more than [`MOST_PAIRS`] pairs at once.
    pub fn build(
        law: &impl FlankLaw,
        inputs: &MeshTableInputs,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, MeshTableError> {
        check(inputs)?;
        let breaks = breaks(law, inputs.longest_piece)?;
        let nodes = transforms8().nodes();
        let phases: Vec<f64> = (breaks.windows(2))
            .flat_map(|piece| {
                nodes.map(|x| 0.5 * ((piece[1] - piece[0]) * x + (piece[1] + piece[0])))
            })
            .collect();
        let done = AtomicUsize::new(0);
        let columns: Vec<Result<Vec<Cell>, SharingError>> = phases
            .par_iter()
            .map(|&phase| {
                let cells = cells(law, inputs, phase);
                progress(done.fetch_add(1, Ordering::Relaxed) + 1, phases.len());
                cells
            })
            .collect();
        // The first phase that failed, whichever thread came first.
        let columns: Vec<Vec<Cell>> = (columns.into_iter().zip(&phases))
            .map(|(cells, &phase)| {
                cells.map_err(|source| MeshTableError::Sharing { phase, source })
            })
            .collect::<Result<_, _>>()?;

        let cases = inputs.misalignment.len() * inputs.torque.len();
        let in_order = || (0..cases).flat_map(|case| columns.iter().map(move |c| &c[case]));
        let gather = |pick: fn(&Cell) -> f64| in_order().map(pick).collect::<Vec<f64>>();
        debug_assert_eq!(phases.len(), (breaks.len() - 1) * NODES);
        Ok(Self {
            base_radius: inputs.base_radius,
            misalignment: inputs.misalignment.clone(),
            torque: inputs.torque.clone(),
            breaks,
            node: nodes.to_vec(),
            stiffness: gather(|cell| cell.stiffness),
            centre: gather(|cell| cell.centre),
            transmission_error: gather(|cell| cell.transmission_error),
            friction: gather(|cell| cell.friction),
            friction_lever: gather(|cell| cell.friction_lever),
            contact_fraction: gather(|cell| cell.contact_fraction),
            share: in_order().flat_map(|cell| cell.share).collect(),
            pattern: in_order()
                .flat_map(|cell| cell.pattern.iter().copied())
                .collect(),
            slices: inputs.slices,
        })
    }
}

/// All loads at one phase, misalignment by misalignment.
fn cells(
    law: &impl FlankLaw,
    inputs: &MeshTableInputs,
    phase: f64,
) -> Result<Vec<Cell>, SharingError> {
    let face = Face {
        width: inputs.face_width,
        slices: inputs.slices,
    };
    let pairs = pairs_at(law, phase, face)?;
    let pitch_point = law.path().pitch_point;
    let positions: Vec<f64> = pairs.iter().map(|p| p.position - pitch_point).collect();
    let mut cells = Vec::with_capacity(inputs.misalignment.len() * inputs.torque.len());
    for &misalignment in &inputs.misalignment {
        let mut sharing = LoadSharing::new(&pairs, face, misalignment)?;
        for &torque in &inputs.torque {
            let force = torque / inputs.base_radius;
            if inputs.contact == Contact::LoadDependent {
                sharing = LoadSharing::under(law, phase, face, misalignment, force)?;
            }
            let load = sharing.bear(force);
            let friction = friction_direction(&positions, &load.share);
            let pattern = if inputs.pattern {
                let pairs = sharing.pattern(force);
                (0..inputs.slices)
                    .map(|slice| pairs.iter().skip(slice).step_by(inputs.slices).sum())
                    .collect()
            } else {
                Vec::new()
            };
            cells.push(Cell {
                stiffness: load.stiffness,
                centre: load.centre,
                transmission_error: load.deflection,
                friction: friction.direction,
                friction_lever: friction.lever,
                contact_fraction: load.contact_fraction,
                share: load.share,
                pattern,
            });
        }
    }
    Ok(cells)
}

fn check(inputs: &MeshTableInputs) -> Result<(), MeshTableError> {
    for (axis, values) in [
        ("misalignment", &inputs.misalignment),
        ("torque", &inputs.torque),
    ] {
        let increases = values.windows(2).all(|v| v[0] < v[1]);
        if values.is_empty() || !increases || !values.iter().all(|v| v.is_finite()) {
            return Err(MeshTableError::Axis {
                axis,
                values: values.clone(),
            });
        }
    }
    let longest = inputs.longest_piece;
    for (name, value, valid, accepted) in [
        (
            "lowest torque [N m]",
            inputs.torque[0],
            inputs.torque[0] > 0.0,
            "positive",
        ),
        (
            "base radius of the pinion [m]",
            inputs.base_radius,
            inputs.base_radius > 0.0 && inputs.base_radius.is_finite(),
            "positive and finite",
        ),
        (
            "longest piece [cycles]",
            longest,
            (1e-3..=1.0).contains(&longest),
            "from 0.001 to 1",
        ),
    ] {
        if !valid {
            return Err(MeshTableError::OutOfRange {
                name,
                value,
                accepted,
            });
        }
    }
    Ok(())
}
