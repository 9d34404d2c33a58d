//! Tables of dense kernels of a job: fetched from the cache or computed, once for all points
//! that share them.

use crate::model::Model;
use crate::propagate::KeptKernel;
use crate::store::{Fetched, MappedTable, OperatorFetchError, TableStore};
use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// A table, for as long as some kernel uses it.
type Place = Arc<Mutex<Weak<MappedTable>>>;

/// Kernel tables at hand. A table that no kernel uses any more is let go: its file remains, and
/// memory does not grow with the number of speeds.
#[derive(Debug)]
pub struct KernelTables {
    store: TableStore,
    places: Mutex<HashMap<PathBuf, Place>>,
    warnings: Mutex<BTreeSet<String>>,
}

impl KernelTables {
    /// Tables kept in a store.
    pub fn new(store: TableStore) -> Self {
        Self {
            store,
            places: Mutex::default(),
            warnings: Mutex::default(),
        }
    }

    /// The tables of a kernel for a model in so many `cells` a mesh cycle. Workers that want the
    /// same ones wait for the one that computes them.
    ///
    /// # Errors
    /// The kernel cannot be built for the model.
    pub fn get(
        &self,
        kernel: KeptKernel,
        model: &Model,
        cells: u32,
    ) -> Result<Arc<MappedTable>, OperatorFetchError> {
        let path = self.store.kernel_tables_path(kernel, model, cells);
        let place = lock(&self.places).entry(path).or_default().clone();
        let mut held = lock(&place);
        if let Some(table) = held.upgrade() {
            return Ok(table);
        }
        let Fetched {
            table, warnings, ..
        } = self.store.kernel_tables(kernel, model, cells)?;
        lock(&self.warnings).extend(warnings.iter().map(ToString::to_string));
        let table = Arc::new(table);
        *held = Arc::downgrade(&table);
        Ok(table)
    }

    /// What the user should know of the cache, each once.
    pub fn warnings(&self) -> Vec<String> {
        lock(&self.warnings).iter().cloned().collect()
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
