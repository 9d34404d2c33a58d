//! The trajectory of one operating point, recorded.

use super::build::BuildError;
use super::chain::lead_up;
use super::parts::Prepared;
use super::point_kernel::PointKernel;
use crate::analysis::{CalledOff, TraceConfig, TraceOutcome, TraceSink, trace};
use crate::manifest::{Job, PointSpec};
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Interruptible, Kernel, KernelUse};
use std::sync::atomic::AtomicBool;

/// What is to be recorded.
#[derive(Debug)]
pub struct PointTrace<'a> {
    /// The job.
    pub job: &'a Job,
    /// The point; it need not be on the grid.
    pub point: &'a PointSpec,
    /// Whether it starts where the sweep that the manifest asks for has come to, and not from
    /// `run.initial`.
    pub swept: bool,
    /// The trajectory and its samples.
    pub question: TraceConfig,
    /// Structures and tables at hand.
    pub parts: &'a Prepared,
}

/// Why nothing was recorded.
#[derive(Debug, thiserror::Error)]
pub enum PointTraceError<E: std::error::Error + 'static> {
    /// There is no such drive, or no kernel for it.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// It was called off before anything was recorded.
    #[error(transparent)]
    CalledOff(#[from] CalledOff),
    /// What takes the samples refuses one.
    #[error(transparent)]
    Sink(E),
}

impl PointTrace<'_> {
    /// The system of the point, which its kernel gets through.
    ///
    /// # Errors
    /// There is no such drive, or its mesh cycle would take too long.
    pub fn model(&self) -> Result<Model, BuildError> {
        let model = self.parts.model(self.point)?;
        PointKernel::of(self.point, &model, self.parts)?;
        Ok(model)
    }

    /// Integrates `model` and hands samples and events to the sink that `open` gives once the kernel
    /// is ready; the sink comes back with what the trace amounts to.
    ///
    /// # Errors
    /// [`PointTraceError`]. Where the integration stops, or `called_off` is raised meanwhile, the
    /// outcome says so.
    pub fn record<S: TraceSink<Error: std::error::Error>>(
        &self,
        model: &Model,
        called_off: &AtomicBool,
        open: impl FnOnce() -> Result<S, S::Error>,
    ) -> Result<(TraceOutcome, S), PointTraceError<S::Error>> {
        let run = &self.point.run;
        let swept = if self.swept {
            lead_up(self.job, self.point, self.parts, called_off)?
                .start(self.job, self.point, model)
        } else {
            // Nothing to go through before.
            None
        };
        let recording = Recording {
            model,
            start: swept.unwrap_or_else(|| model.start(&run.initial)),
            question: &self.question,
            called_off,
            open,
        };
        let kernel = PointKernel::of(self.point, model, self.parts)?;
        let recorded = kernel.apply(model, self.parts, recording)?;
        recorded.map_err(PointTraceError::Sink)
    }
}

/// A recording on its way to a kernel.
struct Recording<'a, F> {
    model: &'a Model,
    start: TrajectoryState,
    question: &'a TraceConfig,
    called_off: &'a AtomicBool,
    open: F,
}

impl<S: TraceSink, F: FnOnce() -> Result<S, S::Error>> KernelUse for Recording<'_, F> {
    type Output = Result<(TraceOutcome, S), S::Error>;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output {
        let kernel = &Interruptible::new(kernel, self.called_off);
        let mut sink = (self.open)()?;
        let outcome = trace(self.model, kernel, self.start, self.question, &mut sink)?;
        Ok((outcome, sink))
    }
}
