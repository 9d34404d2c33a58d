//! Kernels that integrate the piecewise-linear system, and their common parts: events, saltation, observers, work
//! counters.
//!
//! A kernel is built for one [`Model`] and advances whole mesh cycles. The caller supplies the trajectory,
//! the tangents and the workspace. An integrated cycle allocates no memory, with three exceptions: a contact
//! closes for the first time since the kernel was built, a model with very many contact sets reaches a new
//! one, or the model has rigid stops or dry friction. Kernels are generic over the observer, so that unobserved
//! quantities are not computed.

mod auto;
mod choice;
mod closed_modes;
mod counters;
pub mod events;
mod interrupt;
mod kept;
mod observer;
pub mod saltation;
mod stepping;
mod table_error;
mod tangents;
pub mod varying_speed;
pub(crate) mod vectors;
mod volterra;

pub use auto::{KernelSetting, Why};
pub use choice::{KernelChoice, KernelUse};
pub use closed_modes::{
    ClosedModes, MOST_MODES, PointTables, Seat, SideBySide, map_side_by_side, work_side_by_side,
};
pub use counters::Counters;
pub use interrupt::Interruptible;
pub use kept::{KeptReader, KeptTables, KeptWriter, SharedStorage, TableArray};
pub use observer::{ClosedContact, Event, Observer, Window};
pub use stepping::{Stepping, SteppingWorkspace};
pub use table_error::{TableError, TableSize};
pub use tangents::Tangents;
pub use vectors::{Aligned, InstructionSet};
pub use volterra::Volterra;

use crate::model::{Model, TrajectoryState};
use crate::numerics::instructions::portable;
use std::sync::Arc;

/// Two lengths of cells or windows are equal if their relative difference is at most this.
pub const SAME_LENGTH: f64 = 1e-12;

/// Largest deflection along every line, in the units of its contacts. Beyond it, a motion has diverged. It is
/// [`FARTHEST`] times [`Model::gap_on`], and infinite for a line that shows a force.
fn farthest(model: &Model) -> Vec<f64> {
    (0..model.lines.len())
        .map(|line| {
            // A line with direct effects shows the force of a constraint, which has no bound.
            let is_deflection = model.lines[line].direct.is_empty();
            if is_deflection { FARTHEST * model.gap_on(line) } else { f64::INFINITY }
        })
        .collect()
}

/// Name of the instruction set of this process, or `portable` if it is restricted to instructions that every
/// processor has.
pub fn instructions() -> &'static str {
    if portable() { "portable" } else { InstructionSet::best().name() }
}

/// Reasons for the end of an integration.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Stop {
    /// A deflection is larger than any physical one, or not finite.
    #[error("the state diverged in mesh cycle {cycle}")]
    Diverged {
        /// The mesh cycle.
        cycle: u64,
    },
    /// The mesh deflection of the initial state is out of range.
    #[error(
        "the mesh deflection of the initial state is {half_gaps:.1e} half gaps, but more than {farthest:.0e} half \
         gaps count as diverged; set run.initial to a smaller state"
    )]
    FarStart {
        /// Deflection of the initial state \[half gaps\].
        half_gaps: f64,
        /// The largest allowed deflection \[half gaps\].
        farthest: f64,
    },
    /// Too many events in one mesh cycle.
    #[error("more than {limit} events in mesh cycle {cycle}")]
    EventStorm {
        /// The mesh cycle.
        cycle: u64,
        /// The limit.
        limit: u32,
    },
    /// The integration takes more windows than the mesh cycle can need.
    #[error(
        "mesh cycle {cycle} does not end: after {windows} windows, the integration is at mesh phase {phase}; this is \
         an error of the program, please report it with the manifest. Try another run.kernel, or move the breakpoints \
         of the mesh (mesh.contact_ratio, mesh.coast_symmetry, train.mesh.*.phase)"
    )]
    Stuck {
        /// The mesh cycle.
        cycle: u64,
        /// Start of the last window \[cycles\].
        phase: f64,
        /// Windows in this cycle.
        windows: u64,
    },
    /// The motion has reached a set of closed contacts for which the kernel has no table.
    #[error(
        "a set of closed contacts in mesh cycle {cycle} has no table, because {}; set run.kernel = \"volterra\"", error.cause()
    )]
    Refused {
        /// The mesh cycle.
        cycle: u64,
        /// The reason.
        error: TableError,
    },
    /// The mean rotation stops or reverses.
    #[error(
        "the drive comes to rest or turns back in mesh cycle {cycle}: give speeds and torques under which it keeps running \
         forwards"
    )]
    Backwards {
        /// The mesh cycle.
        cycle: u64,
    },
    /// The user interrupted the integration; the trajectory itself did not fail.
    #[error("interrupted in mesh cycle {cycle}")]
    Interrupted {
        /// The mesh cycle.
        cycle: u64,
    },
}

/// Deflections beyond this many half gaps count as divergence.
pub const FARTHEST: f64 = 1e9;

/// A propagation kernel for one model.
pub trait Kernel {
    /// Deflections beyond this many half gaps count as divergence.
    const FARTHEST: f64 = FARTHEST;

    /// Scratch memory, reused from cycle to cycle.
    type Workspace;

    /// A workspace for this kernel.
    fn workspace(&self) -> Self::Workspace;

    /// Whether the errors of this kernel are within round-off. The energy balance of an approximate kernel
    /// need not close.
    fn exact(&self) -> bool {
        true
    }

    /// Checks that the mesh deflection of the trajectory `start` is at most [`Self::FARTHEST`] half gaps.
    ///
    /// # Errors
    /// [`Stop::FarStart`].
    fn accepts(&self, model: &Model, start: &TrajectoryState) -> Result<(), Stop> {
        let half_gaps = model.deflection(&start.state, 0.0).0.abs() / model.half_gap;
        // Written so that NaN is rejected.
        if half_gaps <= Self::FARTHEST {
            Ok(())
        } else {
            Err(Stop::FarStart {
                half_gaps,
                farthest: Self::FARTHEST,
            })
        }
    }

    /// Integrates one mesh cycle: advances `trajectory` and every tangent, passes windows and events to `observer`,
    /// and adds the work to `counters`.
    ///
    /// # Errors
    /// [`Stop`] if the trajectory diverges, the cycle has too many events, or windows make no progress. Also
    /// if the kernel has no table for a set of closed contacts, or if the observer interrupts the
    /// integration. `trajectory` is then unspecified.
    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Self::Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop>;

    /// The tables of this operating point for [`SideBySide`], which integrates cycles of several points at
    /// once. `None` if the model is not suitable.
    fn point_tables(&self) -> Option<&Arc<PointTables>> {
        None
    }

    /// Integrates `cycles` mesh cycles without tangents.
    ///
    /// # Errors
    /// As [`Kernel::advance_cycle`]; `counters` includes the cycles before the error.
    fn advance<O: Observer>(
        &self,
        cycles: u64,
        trajectory: &mut TrajectoryState,
        workspace: &mut Self::Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let mut none = Tangents::none();
        for _ in 0..cycles {
            self.advance_cycle(trajectory, &mut none, workspace, observer, counters)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{InitialState, fixtures};
    use crate::structure::StructureContact;

    /// A growing mode that does not affect the flanks diverges along the line of its stop.
    #[test]
    fn a_motion_diverges_along_any_line() {
        let mut structure = fixtures::structure(&[900.0, 700.0], 0.02, &[1.0, 0.0], &[1.0, 0.5]);
        structure.damping[1] = -0.2;
        structure.contacts = vec![StructureContact::stop(&[0.0, 1.0], 1e-5, 1e3)];
        let drive = fixtures::constant_mesh(1e-5, 4e8);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        fn stop<K: Kernel>(model: &Model, kernel: &K) -> Stop {
            let mut trajectory = model.start(&InitialState::Static);
            trajectory.state[1] = 1e-6;
            let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
            kernel
                .advance(
                    2000,
                    &mut trajectory,
                    &mut workspace,
                    &mut (),
                    &mut counters,
                )
                .unwrap_err()
        }
        let found = [
            stop(&model, &Volterra::new(&model, f64::EPSILON, 1000)),
            stop(&model, &Stepping::new(&model, 400, 1000)),
        ];
        for found in found {
            // A micrometre grows like e^{140 t}: to ten metres in 440 mesh cycles, to ten kilometres in 630.
            let Stop::Diverged { cycle } = found else {
                panic!("{found:?}");
            };
            assert!((300..800).contains(&cycle), "{cycle}");
        }
    }
}
