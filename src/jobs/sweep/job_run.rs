//! A job from its journal to its record: computes the remaining points, and writes tables and `run.json`.

use super::Prepared;
use super::recorder::ProgressObserver;
use super::run::{Finished, Options, Sweep, SweepError};
use crate::manifest::Job;
use crate::store::{
    Journal, MachineRecord, ProgramRecord, RunRecord, RunState, Stopwatch, StoreError, TableStore,
    Totals, mixed_instructions_warning, write_run,
};
use crate::topology::Topology;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// A run of a job into a folder of results that [`super::inspect_existing_results`] has accepted.
#[derive(Debug)]
pub struct JobRun<'a> {
    /// The job.
    pub job: &'a Job,
    /// Folder of the results.
    pub folder: &'a Path,
    /// Options of the sweep; all points, or those of a shard.
    pub options: Options<'a>,
    /// Whether points of an interrupted run are dropped.
    pub fresh: bool,
    /// Store of computed tables.
    pub tables: TableStore,
    /// The machine, if known.
    pub topology: Option<&'a Topology>,
    /// Warnings before the run, one sentence each.
    pub warnings: Vec<String>,
}

/// A run that ended or was interrupted.
#[derive(Debug)]
pub struct JobRunEnd {
    /// How the sweep ended.
    pub finished: Finished,
    /// The record as written.
    pub record: RunRecord,
}

/// Why a run has no record.
#[derive(Debug, thiserror::Error)]
pub enum JobRunError {
    /// The sweep could not run, or its tables or journal cannot be written.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// The tables exist, but the record cannot be written, or the journal cannot be removed.
    #[error(transparent)]
    Record(StoreError),
}

impl From<StoreError> for JobRunError {
    fn from(error: StoreError) -> Self {
        Self::Sweep(error.into())
    }
}

/// This machine, and a warning if it cannot be described.
pub fn this_machine() -> (Option<Topology>, Vec<String>) {
    match Topology::current() {
        Ok(topology) => (Some(topology), Vec::new()),
        Err(error) => (None, vec![format!("{error}; NUMA nodes are not recorded")]),
    }
}

impl JobRun<'_> {
    /// Continues from the journal of the folder, or starts a new one. A complete run leaves a record and no
    /// journal. An interrupted run leaves both.
    ///
    /// # Errors
    /// [`JobRunError`]; the journal keeps its points.
    pub fn run(
        self,
        interrupt: &AtomicBool,
        watcher: &mut dyn ProgressObserver,
    ) -> Result<JobRunEnd, JobRunError> {
        let Self {
            job,
            folder,
            options,
            topology,
            mut warnings,
            ..
        } = self;
        let mut journal = Journal::open(folder, &job.hash, options.shard, self.fresh)?;
        let instructions = journal.instructions();
        warnings.extend(mixed_instructions_warning(&instructions));
        let parts = Prepared::of_job(job, self.tables);
        for warning in &warnings {
            watcher.warning(warning);
        }
        let watch = Stopwatch::start();
        let sweep = Sweep {
            job,
            folder,
            options,
            parts: &parts,
            topology,
            interrupt,
        };
        let finished = match sweep.run(&mut journal, watcher) {
            Ok(finished) => finished,
            Err(error) => {
                journal.abandon();
                return Err(error.into());
            }
        };
        let kernels = finished.recorded.kernels.records(job, &parts);
        warnings.extend(parts.warnings());
        let record = RunRecord {
            job: job.name.clone(),
            state: match finished.recorded.written.missing {
                0 => RunState::Complete,
                _ => RunState::Interrupted,
            },
            shard: options.shard,
            started: watch.started(),
            finished: watch.now(),
            program: ProgramRecord::current(),
            machine: MachineRecord {
                instructions,
                ..MachineRecord::current(topology)
            },
            placement: finished.placement.clone(),
            totals: totals(&finished, watch.elapsed().as_secs_f64()),
            kernels,
            shards: Vec::new(),
            tables: finished.recorded.written.tables.clone(),
            retries: Vec::new(),
            warnings,
            manifest_hash: job.hash.clone(),
            manifest: job.text.clone(),
            set: job.changes.clone(),
            folder: (std::env::current_dir().unwrap_or_default())
                .join(&job.folder)
                .display()
                .to_string(),
        };
        write_run(folder, &record).map_err(JobRunError::Record)?;
        // Remove the journal last: until the record is written, the next run continues from the journal.
        if record.state == RunState::Complete {
            journal.remove().map_err(JobRunError::Record)?;
        }
        Ok(JobRunEnd { finished, record })
    }
}

/// Counts and times of a sweep with this wall time \[s\].
fn totals(finished: &Finished, wall_time: f64) -> Totals {
    let progress = &finished.recorded.progress;
    Totals {
        not_converged: progress.not_ok - progress.failed,
        missing: finished.recorded.written.missing,
        resumed: progress.resumed,
        ..Totals::new(
            finished.points,
            progress.done - progress.not_ok,
            progress.failed,
            progress.cycles,
            wall_time,
        )
    }
}
