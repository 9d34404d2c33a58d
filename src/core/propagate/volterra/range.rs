//! Is a trajectory a motion still?

use super::Volterra;
use super::position::{Position, Track};
use super::workspace::Workspace;
use crate::numerics::legendre::at_start;
use crate::propagate::Stop;

impl Volterra<'_> {
    /// That a trajectory is a motion still, along every line.
    pub(super) fn check_range(
        &self,
        position: &Position,
        track: Track<'_>,
        workspace: &Workspace,
    ) -> Result<(), Stop> {
        for (view, solution) in track.views().iter().zip(&workspace.solutions) {
            let farthest = self.farthest[view.line];
            let bound = solution.deflection[0].abs() + solution.variation;
            // The series may run far beyond an event that ends the window long before; where the
            // window starts is where the trajectory is.
            if bound.is_nan() || bound > farthest {
                let start = at_start(&solution.deflection).abs();
                if !bound.is_finite() || start > farthest {
                    return Err(Stop::Diverged {
                        cycle: position.cycle,
                    });
                }
            }
        }
        Ok(())
    }
}
