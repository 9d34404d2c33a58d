//! Mesh cycles.

use super::cycle_integration::{CycleIntegration, ReturnReason, pass};
use super::sets::MOST_CONTACTS;
use super::workspace::{CyclePosition, Workspace};
use super::{ClosedModes, PointTables};
use crate::model::{ActiveSet, TrajectoryState};
use crate::propagate::events::Changes;
use crate::propagate::{Counters, Kernel, Observer, Stop, Tangents};
use std::sync::Arc;

impl Kernel for ClosedModes<'_> {
    type Workspace = Workspace;

    fn workspace(&self) -> Workspace {
        Workspace::new(self)
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let cycle = trajectory.cycle;
        self.begin(trajectory, tangents, workspace)
            .map_err(|error| Stop::Refused { cycle, error })?;
        self.pass_cycle(trajectory, workspace, observer, counters)?;
        self.end(trajectory, tangents, workspace);
        Ok(())
    }

    fn point_tables(&self) -> Option<&Arc<PointTables>> {
        (self.point_tables)
            .get_or_init(|| PointTables::new(self).map(Arc::new))
            .as_ref()
    }
}

impl ClosedModes<'_> {
    /// Integrates one cycle in the coordinates of the systems.
    fn pass_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        workspace: &mut Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let mut integration = CycleIntegration {
            kernel: self,
            place: CyclePosition {
                cycle: trajectory.cycle,
                time: 0.0,
                active: trajectory.contact,
                crossed: ActiveSet::FREE,
            },
            rates: [0.0; MOST_CONTACTS],
            changes: Changes::new(self.event_limit, self.planned),
            next: None,
            shows: O::WINDOWS,
            w: workspace,
            counters,
        };
        loop {
            if observer.is_interrupted() {
                let CyclePosition { cycle, .. } = integration.place;
                return Err(Stop::Interrupted { cycle });
            }
            match pass(self.instructions, &mut integration)? {
                ReturnReason::Window(duration) => {
                    self.show(&integration.place, duration, integration.w, observer);
                }
                ReturnReason::Event(event) => {
                    (integration.changes).meet(&event, observer, integration.counters)?;
                }
                ReturnReason::End => break,
            }
        }
        trajectory.contact = integration.place.active;
        trajectory.cycle += 1;
        counters.cycles += 1;
        Ok(())
    }
}
