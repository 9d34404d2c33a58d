//! How does an interruption stop an integration before the end of the mesh cycle?

use super::{Counters, Kernel, Observer, PointTables, Stop, Tangents};
use crate::model::TrajectoryState;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A kernel that checks a flag at least once per mesh cycle, and stops once it is raised. The checks do not change
/// results.
#[derive(Debug, Clone, Copy)]
pub struct Interruptible<'a, K> {
    kernel: &'a K,
    interrupt: &'a AtomicBool,
}

impl<'a, K: Kernel> Interruptible<'a, K> {
    /// The kernel, with the flag that ends its integrations.
    pub fn new(kernel: &'a K, interrupt: &'a AtomicBool) -> Self {
        Self { kernel, interrupt }
    }
}

impl<K: Kernel> Kernel for Interruptible<'_, K> {
    const FARTHEST: f64 = K::FARTHEST;

    type Workspace = K::Workspace;

    fn workspace(&self) -> K::Workspace {
        self.kernel.workspace()
    }

    fn exact(&self) -> bool {
        self.kernel.exact()
    }

    fn point_tables(&self) -> Option<&Arc<PointTables>> {
        self.kernel.point_tables()
    }

    fn advance_cycle<O: Observer>(
        &self,
        trajectory: &mut TrajectoryState,
        tangents: &mut Tangents,
        workspace: &mut K::Workspace,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        let mut attentive = (observer, Flag(self.interrupt));
        (self.kernel).advance_cycle(trajectory, tangents, workspace, &mut attentive, counters)
    }
}

/// An observer that only checks the flag.
struct Flag<'a>(&'a AtomicBool);

impl Observer for Flag<'_> {
    const WINDOWS: bool = false;

    fn is_interrupted(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
