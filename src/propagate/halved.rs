//! The small-step kernel on a grid twice as fine, for a look at its error.

use super::{Counters, Kernel, Observer, Stepping, SteppingWorkspace, Stop, Tangents};
use crate::model::{Model, TrajectoryState};

/// [`Stepping`] with every step halved.
#[derive(Debug, Clone)]
pub struct Halved(Stepping);

impl Halved {
    /// As [`Stepping::new`], with twice the steps.
    pub fn new(model: &Model, steps: u32, event_limit: u32) -> Self {
        Self(Stepping::new(model, 2 * steps, event_limit))
    }
}

impl Kernel for Halved {
    const FARTHEST: f64 = Stepping::FARTHEST;

    type Workspace = SteppingWorkspace;

    fn workspace(&self) -> SteppingWorkspace {
        self.0.workspace()
    }

    fn exact(&self) -> bool {
        self.0.exact()
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut SteppingWorkspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        (self.0).advance_cycle(trajectory, tangents, workspace, observer, counters)
    }
}
