//! Kernels that march the piecewise-linear system, and what they share: events, saltation,
//! observers, work counters.
//!
//! A kernel is built for one [`Model`](crate::model::Model), owns no state, and marches
//! whole mesh cycles: the caller supplies the trajectory, the tangents and the workspace,
//! and a marched cycle allocates nothing. Kernels are statically dispatched over the
//! observer, so that what nobody watches is not computed.

mod counters;
mod dense;
pub mod events;
mod observer;
pub mod saltation;
mod stepping;
mod tangents;
mod volterra;

pub use counters::Counters;
pub use dense::{
    Conditioning, DenseError, Dyadic, Fused, Hermite, KeptTables, Operator, PowerJumps, Spectral,
    TableArray, TableSize,
};
pub use observer::{Event, Observer, Window};
pub use stepping::{Stepping, SteppingWorkspace};
pub use tangents::Tangents;
pub use volterra::{InstructionSet, Volterra};

use crate::model::TrajectoryState;
use crate::numerics::instructions::portable;

/// What this process computes with: the name of its instruction set, or `portable` where it keeps
/// to what every processor has.
pub fn instructions() -> &'static str {
    match portable() {
        true => "portable",
        false => InstructionSet::best().name(),
    }
}

/// Why a trajectory cannot be marched on.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Stop {
    /// The state left every physical range or became non-finite.
    #[error("the state diverged in mesh cycle {cycle}")]
    Diverged {
        /// The mesh cycle.
        cycle: u64,
    },
    /// Too many events in one mesh cycle.
    #[error("more than {limit} events in mesh cycle {cycle}")]
    EventStorm {
        /// The mesh cycle.
        cycle: u64,
        /// The limit that was passed.
        limit: u32,
    },
}

/// A propagation kernel for one model.
pub trait Kernel {
    /// Scratch memory, reused from cycle to cycle.
    type Workspace;

    /// A workspace for this kernel.
    fn workspace(&self) -> Self::Workspace;

    /// Marches one mesh cycle: advances `trajectory` and every tangent, shows windows and
    /// events to `observer`, adds the work done to `counters`.
    ///
    /// # Errors
    /// [`Stop`] where the trajectory diverges or more than the kernel's limit of events
    /// falls in this cycle; `trajectory` is then unspecified.
    fn march<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Self::Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop>;
}
