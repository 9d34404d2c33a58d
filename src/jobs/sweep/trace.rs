//! Records the trajectory of one operating point.

use super::build::BuildError;
use super::chain::chain_state_before;
use super::parts::Prepared;
use super::point_kernel::PointKernel;
use crate::analysis::{Interrupted, TraceConfig, TraceOutcome, TraceSink, trace};
use crate::manifest::{Job, PointSpec};
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Interruptible, Kernel, KernelUse};
use std::sync::atomic::AtomicBool;

/// A trajectory to be recorded.
#[derive(Debug)]
pub struct PointTrace<'a> {
    /// The job.
    pub job: &'a Job,
    /// The point; it need not be on the grid.
    pub point: &'a PointSpec,
    /// Whether the trajectory starts from the sweep that the manifest requests; otherwise from `run.initial`.
    pub swept: bool,
    /// Which part of the trajectory is recorded, and how it is sampled.
    pub config: TraceConfig,
    /// Structures and tables that points share.
    pub parts: &'a Prepared,
}

/// Reason why a trajectory cannot be recorded.
#[derive(Debug, thiserror::Error)]
pub enum PointTraceError<E: std::error::Error + 'static> {
    /// The drive or its kernel cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The recording was interrupted before it began.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// The sink refuses a sample.
    #[error(transparent)]
    Sink(E),
}

impl PointTrace<'_> {
    /// The system of the point, which its kernel can integrate in reasonable time.
    ///
    /// # Errors
    /// The drive cannot be built, or its mesh cycle would take too long.
    pub fn model(&self) -> Result<Model, BuildError> {
        let model = self.parts.model(self.point)?;
        PointKernel::of(self.point, &model, self.parts)?;
        Ok(model)
    }

    /// Integrates `model` and passes samples and events to the sink that `open` returns once the kernel is ready.
    /// Returns the sink and a summary of the trace.
    ///
    /// # Errors
    /// [`PointTraceError`]. If the integration stops, or `interrupt` is raised meanwhile, the outcome has the reason.
    pub fn record<S: TraceSink<Error: std::error::Error>>(
        &self,
        model: &Model,
        interrupt: &AtomicBool,
        open: impl Fn() -> Result<S, S::Error>,
    ) -> Result<(TraceOutcome, S), PointTraceError<S::Error>> {
        let run = &self.point.run;
        let swept = if self.swept {
            chain_state_before(self.job, self.point, self.parts, interrupt)?
                .start(self.job, self.point, model)
        } else {
            // A point without a sweep starts from `run.initial`.
            None
        };
        let start = swept.unwrap_or_else(|| model.start(&run.initial));
        let recording = |_: &PointKernel| Recording {
            model,
            start: start.clone(),
            config: &self.config,
            interrupt,
            open: &open,
        };
        let kernel = PointKernel::of(self.point, model, self.parts)?;
        let recorded = kernel.apply(model, self.parts, recording)?;
        recorded.map_err(PointTraceError::Sink)
    }
}

/// A request to record a trajectory, which a kernel carries out.
struct Recording<'a, F> {
    model: &'a Model,
    start: TrajectoryState,
    config: &'a TraceConfig,
    interrupt: &'a AtomicBool,
    open: F,
}

impl<S: TraceSink, F: FnOnce() -> Result<S, S::Error>> KernelUse for Recording<'_, F> {
    type Output = Result<(TraceOutcome, S), S::Error>;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output {
        let kernel = &Interruptible::new(kernel, self.interrupt);
        let mut sink = (self.open)()?;
        let outcome = trace(self.model, kernel, self.start, self.config, &mut sink)?;
        Ok((outcome, sink))
    }
}
