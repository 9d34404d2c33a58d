//! Runs of a manifest.

use crate::attended::attended;
use crate::errors::{failed, refused};
use crate::manifest::Manifest;
use gearatlas::store::{PointRow, RunRecord, TableStore};
use gearatlas::sweep::{
    ExistingResults, JobRun, Options, Progress, ProgressObserver, SweepPlan,
    inspect_existing_results, this_machine,
};
use gearatlas::topology::Pinning;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// The progress of a sweep, for another thread.
struct News<'a>(&'a Mutex<Option<Progress>>);

impl News<'_> {
    fn put(&self, progress: &Progress) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(*progress);
    }
}

impl ProgressObserver for News<'_> {
    fn begun(&mut self, begun: &SweepPlan<'_>) {
        self.put(&begun.progress);
    }

    // The record of the run contains the warnings.
    fn warning(&mut self, _: &str) {}

    fn point(&mut self, _: &PointRow, progress: &Progress) {
        self.put(progress);
    }

    fn tick(&mut self, progress: &Progress) {
        self.put(progress);
    }
}

/// Computes the missing results of a manifest in a folder, and returns the record of the run as JSON. Calls `progress`
/// with the latest numbers of a sweep's progress about every 20 ms, and at the end.
#[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
#[pyfunction]
#[pyo3(signature = (manifest, folder, *, threads, overwrite, tables, max_failures, progress))]
pub fn run(
    py: Python<'_>,
    manifest: &Manifest,
    folder: PathBuf,
    threads: Option<u32>,
    overwrite: bool,
    tables: PathBuf,
    max_failures: Option<u64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let job = &*manifest.job;
    if job.portable() {
        return Err(refused(
            py,
            "run.instructions = \"portable\" is not possible in Python, because it needs a process that starts with \
             these instructions; compute this manifest with `atlas run`, and read the results with gearatlas.open",
        ));
    }
    let earlier = py.detach(|| inspect_existing_results(&folder, job, None, overwrite));
    if let ExistingResults::Complete(record) = earlier.map_err(|error| failed(py, &error))? {
        return json(py, &record);
    }
    let news = Mutex::new(None);
    let work = |interrupt: &_| {
        let (topology, warnings) = this_machine();
        let run = JobRun {
            job,
            folder: &folder,
            options: Options {
                threads: threads.map(|threads| threads as usize),
                pinning: Pinning::Full,
                shard: None,
                only: None,
                most_failures: max_failures,
            },
            fresh: overwrite,
            tables: TableStore::open(tables),
            topology: topology.as_ref(),
            warnings,
        };
        run.run(interrupt, &mut News(&news))
    };
    let report_progress = |py: Python<'_>| {
        let latest = news.lock().unwrap_or_else(PoisonError::into_inner).take();
        match (&progress, latest) {
            (Some(progress), Some(latest)) => report_progress(py, progress, &latest),
            _ => Ok(()),
        }
    };
    match attended(py, work, report_progress)? {
        Ok(ran) => json(py, &ran.record),
        Err(error) => Err(failed(py, &error)),
    }
}

fn report_progress(py: Python<'_>, progress: &Py<PyAny>, latest: &Progress) -> PyResult<()> {
    let numbers = (
        latest.done,
        latest.points,
        latest.failed,
        latest.not_ok - latest.failed,
        latest.resumed,
        latest.cycles,
        latest.elapsed.as_secs_f64(),
        latest.open,
    );
    progress.call1(py, numbers).map(drop)
}

fn json(py: Python<'_>, record: &RunRecord) -> PyResult<String> {
    serde_json::to_string(record).map_err(|error| failed(py, &error))
}
