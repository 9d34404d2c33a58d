//! The attractor on which a separately integrated motion ends.

use super::same::Attractor;
use crate::analysis::config::PointConfig;
use crate::analysis::interrupt::Interrupted;
use crate::analysis::norm::EnergyNorm;
use crate::analysis::outcome::PointOutcome;
use crate::analysis::point::investigate_onward;
use crate::model::{Model, TrajectoryState};
use crate::propagate::Kernel;
use std::sync::atomic::AtomicBool;

/// The context in which trajectories are integrated.
pub(super) struct IntegrationContext<'a, K: Kernel> {
    pub model: &'a Model,
    pub kernel: &'a K,
    pub norm: &'a EnergyNorm,
    pub interrupt: &'a AtomicBool,
}

/// A motion investigated in full.
#[derive(Debug)]
pub(super) struct InvestigatedMotion {
    pub found: PointOutcome,
    /// `None` if it settled on no attractor.
    pub attractor: Option<Attractor>,
}

impl<K: Kernel> IntegrationContext<'_, K> {
    /// The same context with another kernel.
    pub fn with<'b, L: Kernel>(&'b self, kernel: &'b L) -> IntegrationContext<'b, L> {
        IntegrationContext {
            model: self.model,
            kernel,
            norm: self.norm,
            interrupt: self.interrupt,
        }
    }

    /// Investigates the motion from `trajectory` on.
    ///
    /// # Errors
    /// [`Interrupted`] if the work was interrupted.
    pub fn investigate(
        &self,
        mut trajectory: TrajectoryState,
        config: &PointConfig,
    ) -> Result<InvestigatedMotion, Interrupted> {
        let mut found = investigate_onward(
            self.model,
            self.kernel,
            &mut trajectory,
            config,
            self.interrupt,
        )?;
        let recognised = Attractor::of(self.model, self.kernel, &found, trajectory);
        let attractor = match recognised {
            Ok(attractor) => attractor,
            Err(stop) => {
                found.status = stop.try_into()?;
                found.reason = stop.to_string();
                None
            }
        };
        // The statistics no longer need the samples, and thousands of probes may wait in memory.
        found.poincare = Vec::new();
        Ok(InvestigatedMotion { found, attractor })
    }
}
