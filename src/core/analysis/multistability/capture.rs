//! On which known orbit does a trajectory end?
//!
//! A motion need not be investigated if it ends on a known orbit. It is integrated until it comes near
//! such an orbit. It ends there if its distance then falls as the monodromy matrix of the orbit predicts
//! ([`approaches`]). All known orbits are attracting.

use super::field::{IntegrationContext, InvestigatedMotion};
use crate::analysis::config::PointConfig;
use crate::analysis::interrupt::Interrupted;
use crate::analysis::orbits::attracting::approaches;
use crate::analysis::orbits::shooting::PeriodicOrbit;
use crate::model::TrajectoryState;
use crate::propagate::{Counters, Kernel, Stop};

/// Distance \[half gaps\] from an orbit below which an approach is observed. The observation costs no extra
/// time, because it advances the trajectory.
const OBSERVED_DISTANCE: f64 = 0.3;

/// How a cell of a slice ended.
#[derive(Debug)]
pub(super) enum CellEnding {
    /// On a known attractor.
    Captured(u32),
    /// Approached no known orbit within the allowed cycles, and was then investigated.
    Open(Box<InvestigatedMotion>),
    /// Stopped by the kernel.
    Stopped(Stop),
}

/// The orbits known so far.
#[derive(Debug)]
pub(super) struct KnownOrbits {
    /// Attractors with their orbits.
    orbits: Vec<(u32, PeriodicOrbit)>,
    /// Mesh cycles after which the excitation repeats.
    excitation: u64,
}

impl KnownOrbits {
    /// An empty list of orbits; `excitation` is the base period in mesh cycles.
    pub fn new(excitation: u64) -> Self {
        Self {
            orbits: Vec::new(),
            excitation,
        }
    }

    /// Adds the orbit of an attractor.
    pub fn add(&mut self, attractor: u32, orbit: PeriodicOrbit) {
        self.orbits.push((attractor, orbit));
    }

    /// Advances `trajectory` for at most `cycles` until it approaches a known orbit. If it approaches none,
    /// investigates its further motion. Returns the result, and the mesh cycles before the investigation.
    ///
    /// # Errors
    /// [`Interrupted`] if the work was interrupted.
    pub fn advance_until_captured<K: Kernel>(
        &self,
        field: &IntegrationContext<'_, K>,
        mut trajectory: TrajectoryState,
        cycles: u64,
        config: &PointConfig,
    ) -> Result<(CellEnding, u64), Interrupted> {
        let mut counters = Counters::default();
        let ending = self.approach(field, &mut trajectory, cycles, &mut counters)?;
        let cell_ending = match ending {
            Some(cell_ending) => cell_ending,
            None => CellEnding::Open(Box::new(field.investigate(trajectory, config)?)),
        };
        Ok((cell_ending, counters.cycles))
    }

    /// Advances `trajectory` until it approaches a known orbit, for at most `cycles` and the observation of
    /// one approach. `None` if the trajectory approached no orbit.
    fn approach<K: Kernel>(
        &self,
        field: &IntegrationContext<'_, K>,
        trajectory: &mut TrajectoryState,
        cycles: u64,
        counters: &mut Counters,
    ) -> Result<Option<CellEnding>, Interrupted> {
        let (kernel, norm) = (field.kernel, field.norm);
        let mut workspace = kernel.workspace();
        while counters.cycles < cycles {
            Interrupted::check(field.interrupt)?;
            let near = self.orbits.iter().find(|(_, orbit)| {
                let cycles_since = trajectory.cycle.abs_diff(orbit.start.cycle);
                cycles_since.is_multiple_of(self.excitation)
                    && norm.distance(&trajectory.state, &orbit.start.state)
                        <= OBSERVED_DISTANCE * norm.unit()
            });
            if let Some((id, orbit)) = near {
                match approaches(kernel, norm, orbit, trajectory, &mut workspace, counters) {
                    Ok(true) => return Ok(Some(CellEnding::Captured(*id))),
                    Ok(false) => {}
                    Err(stop) => return Ok(Some(CellEnding::Stopped(stop))),
                }
            }
            // A cycle also follows a failed approach, because that approach may not have advanced the
            // trajectory.
            let integrated = kernel.advance(1, trajectory, &mut workspace, &mut (), counters);
            if let Err(stop) = integrated {
                return Ok(Some(CellEnding::Stopped(stop)));
            }
        }
        Ok(None)
    }
}
