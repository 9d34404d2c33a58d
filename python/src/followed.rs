//! Periodic orbits followed over an axis.

use crate::attended::attended;
use crate::errors::{failed, refused};
use crate::manifest::Manifest;
use gearatlas::store::TableStore;
use gearatlas::sweep::{Prepared, WORKER, follow_job, write_branches};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Follows the orbits that a manifest requests and writes their tables to a folder. Calls `progress` with a sentence
/// for every finished line and plane.
#[pyfunction]
#[pyo3(signature = (manifest, folder, *, threads, tables, progress))]
pub fn follow(
    py: Python<'_>,
    manifest: &Manifest,
    folder: PathBuf,
    threads: Option<usize>,
    tables: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let job = &*manifest.job;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .thread_name(|i| format!("{WORKER}{i}"))
        .build()
        .map_err(|error| refused(py, &format!("cannot start worker threads: {error}")))?;
    let passed = Mutex::new(Vec::new());
    let lines = || passed.lock().unwrap_or_else(PoisonError::into_inner);
    let work = |interrupt: &_| {
        let parts = Prepared::new(TableStore::open(tables));
        let tell = |text: &str| lines().push(text.to_owned());
        pool.install(|| follow_job(job, &parts, interrupt, &tell))
    };
    let tell = |py: Python<'_>| {
        for line in std::mem::take(&mut *lines()) {
            if let Some(progress) = &progress {
                progress.call1(py, (line,))?;
            }
        }
        Ok(())
    };
    let followed = attended(py, work, tell)?.map_err(|error| failed(py, &error))?;
    let written = py.detach(|| write_branches(job, &folder, &followed));
    written.map(drop).map_err(|error| failed(py, &error))
}
