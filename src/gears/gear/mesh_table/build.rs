//! Fills a mesh table: one stretch of the cycle is one parallel task.

use super::breaks::breaks;
use super::law::{PhaseLaw, PhaseState};
use super::pieces::{Piece, pieces};
use super::{FaceLaw, MeshTable, MeshTableError, MeshTableInputs};
use crate::gear::{FlankLaw, IndependentSlices};
use crate::numerics::legendre::transforms8;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Rounding error of polynomials through eight nodes.
const FINEST: f64 = 1e-12;

impl MeshTable {
    /// Computes the table of a law, on the threads of the current rayon pool. Every bit of the result is
    /// the same for any number of threads.
    ///
    /// * `progress(done, all)`: called after each stretch of the cycle between the cuts of the
    ///   flanks, from any thread.
    ///
    /// # Errors
    /// Inputs outside their ranges, a path shorter than a base pitch, a law that gives
    /// unphysical values or more than [`MOST_PAIRS`](crate::gear::MOST_PAIRS) pairs at once, and
    /// [`MeshTableError::Unresolved`].
    pub fn build(
        law: &impl FlankLaw,
        inputs: &MeshTableInputs,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, MeshTableError> {
        check(inputs)?;
        match inputs.face {
            FaceLaw::Coupled => Self::of_law(law, inputs, progress),
            FaceLaw::Independent => Self::of_law(&IndependentSlices(law), inputs, progress),
        }
    }

    fn of_law(
        law: &impl FlankLaw,
        inputs: &MeshTableInputs,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Result<Self, MeshTableError> {
        let stretches = breaks(law, inputs.face_width, inputs.longest_piece)?;
        let all = stretches.len() - 1;
        let law = PhaseLaw::new(law, inputs);
        let done = AtomicUsize::new(0);
        let cut: Vec<Result<Vec<Piece>, MeshTableError>> = stretches
            .par_windows(2)
            .map(|ends| {
                let pieces = pieces(&law, [ends[0], ends[1]]);
                progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
                pieces
            })
            .collect();
        // Returns the error of the failed stretch with the lowest phase, whichever thread failed first.
        let cut: Vec<Vec<Piece>> = cut.into_iter().collect::<Result<_, _>>()?;
        let pieces = || cut.iter().flatten();
        let breaks = [0.0]
            .into_iter()
            .chain(pieces().map(|piece| piece.end))
            .collect();

        let case_count = inputs.misalignment.len() * inputs.torque.len();
        let columns = || pieces().flat_map(|piece| &piece.nodes);
        let in_order = || (0..case_count).flat_map(|case| columns().map(move |c| &c.cells[case]));
        let gather = |pick: fn(&PhaseState) -> f64| in_order().map(pick).collect::<Vec<f64>>();
        Ok(Self {
            base_radius: inputs.base_radius,
            misalignment: inputs.misalignment.clone(),
            torque: inputs.torque.clone(),
            breaks,
            node: transforms8().nodes().to_vec(),
            stiffness: gather(|cell| cell.stiffness),
            centre: gather(|cell| cell.centre),
            transmission_error: gather(|cell| cell.transmission_error),
            friction: gather(|cell| cell.friction),
            friction_lever: gather(|cell| cell.friction_lever),
            contact_fraction: gather(|cell| cell.contact_fraction),
            loaded_pairs: gather(|cell| cell.loaded_pairs),
            share: in_order().flat_map(|cell| cell.share).collect(),
            pattern: in_order()
                .flat_map(|cell| cell.pattern.iter().copied())
                .collect(),
            slices: inputs.slices,
        })
    }
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
        (
            "tolerance of the table [1]",
            inputs.tolerance,
            inputs.tolerance >= FINEST,
            "at least 1e-12",
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::{Flanks, ToothForm, fixtures};
    use std::sync::Mutex;

    /// Progress counts every stretch once, in any order of the threads.
    #[test]
    fn progress_counts_to_the_end() {
        let form = ToothForm {
            bore: [Some(30e-3), Some(40e-3)],
            ..ToothForm::default()
        };
        let pair = fixtures::pair([20, 30], form);
        let flanks = Flanks::new(&pair).unwrap();
        let inputs = MeshTableInputs {
            slices: 1,
            ..MeshTableInputs::of_gears(&pair)
        };
        let reports = Mutex::new(Vec::new());
        let table = MeshTable::build(&flanks, &inputs, &|done, all| {
            reports.lock().unwrap().push((done, all));
        });
        let stretches = breaks(&flanks, inputs.face_width, inputs.longest_piece).unwrap();
        let all = stretches.windows(2).count();
        let mut reports = reports.into_inner().unwrap();
        reports.sort_unstable();
        assert_eq!(
            reports,
            (1..=all).map(|done| (done, all)).collect::<Vec<_>>()
        );
        // Each stretch has at least one piece.
        assert!(table.unwrap().breaks.len() > all);
    }
}
