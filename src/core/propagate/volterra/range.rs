//! Has a motion diverged?

use super::Volterra;
use super::position::{Position, WindowSource};
use super::workspace::Workspace;
use crate::numerics::legendre::at_start;
use crate::propagate::Stop;

impl Volterra<'_> {
    /// Checks along every line that the motion has not diverged.
    pub(super) fn check_range(
        &self,
        position: &Position,
        track: WindowSource<'_>,
        workspace: &Workspace,
    ) -> Result<(), Stop> {
        for (view, solution) in track.views().iter().zip(&workspace.solutions) {
            let farthest = self.farthest[view.line];
            let bound = solution.deflection[0].abs() + solution.variation;
            // The series may be large beyond an event that ends the window early. Only the start of the window
            // certainly belongs to the trajectory.
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
