//! The drive of an FMU: what its instances are made of.

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

/// A point of a job whose variables are known.
#[derive(Debug)]
pub struct Drive {
    job: Job,
    point: PointSpec,
    parts: Prepared,
    description: Description,
}

impl Drive {
    /// That of a point of a job; its tables are kept in a store.
    ///
    /// # Errors
    /// The structure cannot be computed, or torques cannot act on it.
    pub fn new(job: Job, point: PointSpec, tables: TableStore) -> Result<Self, FmuError> {
        if point.run.portable {
            keep_portable();
        }
        let parts = Prepared::new(tables);
        let structure = alone(|| parts.structure(&point.model))?;
        let description = Description::new(&job, &point, &structure)?;
        Ok(Self {
            job,
            point,
            parts,
            description,
        })
    }

    /// That of a folder of resources; `token` is what their description says.
    ///
    /// # Errors
    /// A file cannot be read or is faulty, or the token is that of others.
    pub fn open(folder: &Path, token: &str) -> Result<Self, FmuError> {
        let resources = Resources::open(folder)?;
        let job = resources.job(folder)?;
        let point = resources.point(&job)?;
        let drive = Self::new(job, point, TableStore::read_only(folder.join(TABLES)))?;
        let own = resources.token(&drive.description);
        if token == own {
            return Ok(drive);
        }
        let given = token.to_owned();
        Err(FmuError::Token { given, own })
    }

    /// Its job.
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// Its point.
    pub fn point(&self) -> &PointSpec {
        &self.point
    }

    /// Its variables.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// What is stepped where the parameters have these values.
    ///
    /// # Errors
    /// They make no drive, or none that torques turn.
    pub fn plant(&self, parameters: &[f64]) -> Result<Plant, FmuError> {
        let values: Vec<(&Parameter, f64)> = (self.description.parameters.iter())
            .zip(parameters.iter().copied())
            .collect();
        alone(|| {
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

/// Does something with threads of its own, all of which have ended when it is done: the importer may unload the library
/// any time later, and a thread that waits for work, or is on its way out, would run in memory that is no more.
fn alone<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let mut threads = Vec::new();
    let pool = rayon::ThreadPoolBuilder::new()
        .spawn_handler(|thread| {
            threads.push(std::thread::Builder::new().spawn(|| thread.run())?);
            Ok(())
        })
        .build();
    let done = match pool {
        Ok(pool) => catch_unwind(AssertUnwindSafe(|| pool.install(work))),
        // The system refuses threads: what needs none works on.
        Err(_) => Ok(work()),
    };
    for thread in threads {
        // A panic in one of them is one of the work.
        _ = thread.join();
    }
    done.unwrap_or_else(|panic| resume_unwind(panic))
}
