//! The drive of an FMU, from which its instances are made.

use super::FmuError;
use super::description::Description;
use super::plant::Plant;
use super::resources::{Resources, TABLES};
use crate::manifest::{Job, Parameter, PointSpec};
use crate::numerics::instructions::keep_portable;
use crate::propagate::InstructionSet;
use crate::store::TableStore;
use crate::structure::ModalStructure;
use crate::sweep::Prepared;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::sync::Arc;

/// A point of a job, with the variables of its FMU.
#[derive(Debug)]
pub struct Drive {
    job: Job,
    point: PointSpec,
    parts: Prepared,
    description: Description,
}

impl Drive {
    /// The drive of a point of a job. `tables` stores its mesh tables.
    ///
    /// # Errors
    /// The structure cannot be computed, or torques cannot act on it.
    pub fn new(job: Job, point: PointSpec, tables: TableStore) -> Result<Self, FmuError> {
        if point.run.portable {
            keep_portable();
        }
        let parts = Prepared::new(tables);
        let structure = in_temporary_pool(|| parts.structure(&point.model))?;
        let description = Description::new(&job, &point, &structure)?;
        Ok(Self {
            job,
            point,
            parts,
            description,
        })
    }

    /// Reads the drive from a folder of resources. `token` is the token in the model description.
    ///
    /// # Errors
    /// A file cannot be read or is faulty, or the token belongs to other resources.
    pub fn open(folder: &Path, token: &str) -> Result<Self, FmuError> {
        let resources = Resources::open(folder)?;
        let job = resources.job(folder)?;
        let point = resources.point(&job)?;
        let drive = Self::new(job, point, TableStore::read_only(folder.join(TABLES)))?;
        let expected = resources.token(&drive.description);
        if token == expected {
            return Ok(drive);
        }
        let given = token.to_owned();
        Err(FmuError::Token { given, expected })
    }

    /// The job.
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// The point.
    pub fn point(&self) -> &PointSpec {
        &self.point
    }

    /// The variables.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The drive that an instance steps, for these values of the parameters.
    ///
    /// # Errors
    /// The values do not describe a drive, or torques cannot turn it.
    pub fn plant(&self, parameters: &[f64]) -> Result<Plant, FmuError> {
        let values: Vec<(&Parameter, f64)> = (self.description.parameters.iter())
            .zip(parameters.iter().copied())
            .collect();
        in_temporary_pool(|| {
            let point =
                (self.job.between.changed(&self.point, &values)).map_err(FmuError::Parameters)?;
            let structure: Arc<ModalStructure> = self.parts.structure(&point.model)?;
            let model = self.parts.model(&point)?;
            let set = if point.run.portable {
                InstructionSet::PORTABLE
            } else {
                InstructionSet::best()
            };
            Plant::new(&point, &structure, &model, set)
        })
    }
}

/// Does `work` in a thread pool whose threads have all ended on return. The importer may unload the library at any
/// time. A thread that is waiting or ending would then run in unloaded memory.
fn in_temporary_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let mut threads = Vec::new();
    let pool = rayon::ThreadPoolBuilder::new()
        .spawn_handler(|thread| {
            threads.push(std::thread::Builder::new().spawn(|| thread.run())?);
            Ok(())
        })
        .build();
    let done = match pool {
        Ok(pool) => catch_unwind(AssertUnwindSafe(|| pool.install(work))),
        // The system refuses new threads: do the work on this one.
        Err(_) => Ok(work()),
    };
    for thread in threads {
        // `done` already holds a panic of `work`.
        _ = thread.join();
    }
    done.unwrap_or_else(|panic| resume_unwind(panic))
}
