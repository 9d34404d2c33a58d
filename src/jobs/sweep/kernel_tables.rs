//! Tables of kernels of a job: fetched from the cache or computed, once for all points
//! that share them; on a machine with several NUMA nodes copied where that pays.

use crate::model::Model;
use crate::propagate::TableError;
use crate::store::{Fetched, KernelArrays, TableStore};
use crate::topology::{Room, TABLES_AT_HAND};
use std::collections::{BTreeSet, HashMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// A table, for as long as some kernel uses it, or why the model has none: that is found out once.
type Place = Arc<Mutex<Result<Weak<KernelArrays>, TableError>>>;

/// What workers of all nodes share.
#[derive(Debug)]
struct Common {
    store: TableStore,
    places: Mutex<HashMap<PathBuf, Place>>,
    warnings: Mutex<BTreeSet<String>>,
}

/// Kernel tables at hand. A few that were used last stay there, so that memory does not grow with
/// the grid; of others the file remains.
#[derive(Debug)]
pub struct KernelTables {
    common: Arc<Common>,
    /// Those used last, the last one first.
    at_hand: Mutex<VecDeque<(PathBuf, Arc<KernelArrays>)>>,
    /// Of the workers of one NUMA node: what it offers to copies.
    room: Option<Room>,
}

impl KernelTables {
    /// Tables kept in a store.
    pub fn new(store: TableStore) -> Self {
        Self {
            common: Arc::new(Common {
                store,
                places: Mutex::default(),
                warnings: Mutex::default(),
            }),
            at_hand: Mutex::default(),
            room: None,
        }
    }

    /// The same tables, of which the workers of one NUMA node make copies of their own where
    /// there is room.
    pub fn on_node(&self, room: Room) -> Self {
        Self {
            common: self.common.clone(),
            at_hand: Mutex::default(),
            room: Some(room),
        }
    }

    /// The table of closed modes for a model. Workers that want the same one wait for the one that
    /// computes it.
    ///
    /// # Errors
    /// The kernel cannot be built for the model.
    pub fn get(&self, model: &Model) -> Result<Arc<KernelArrays>, TableError> {
        let path = self.common.store.systems_path(model);
        if let Some(found) = self.found(&path) {
            return Ok(found);
        }
        let common = self.common.get(&path, model)?;
        let mut at_hand = lock(&self.at_hand);
        if let Some((_, found)) = at_hand.iter().find(|(known, _)| *known == path) {
            return Ok(found.clone());
        }
        let pays = self
            .room
            .is_some_and(|room| room.takes(common.bytes() as u64));
        // Written by the calling thread, so that the pages are of its node.
        let near = if pays { Arc::new(common.copied()) } else { common };
        at_hand.push_front((path, near.clone()));
        at_hand.truncate(TABLES_AT_HAND);
        Ok(near)
    }

    /// A table that is at hand, which is the one last used from now on.
    fn found(&self, path: &Path) -> Option<Arc<KernelArrays>> {
        let mut at_hand = lock(&self.at_hand);
        let place = at_hand.iter().position(|(known, _)| known == path)?;
        let entry = at_hand.remove(place)?;
        let found = entry.1.clone();
        at_hand.push_front(entry);
        Some(found)
    }

    /// Shows the copies of a node that are at hand.
    pub(super) fn each_copy(&self, mut tell: impl FnMut(&[f64])) {
        for (_, table) in lock(&self.at_hand).iter() {
            let pays = self
                .room
                .is_some_and(|room| room.takes(table.bytes() as u64));
            if pays {
                tell(table.longest());
            }
        }
    }

    /// What the user should know of the cache, each once.
    pub fn warnings(&self) -> Vec<String> {
        lock(&self.common.warnings).iter().cloned().collect()
    }
}

impl Common {
    /// The table that all nodes share.
    fn get(&self, path: &Path, model: &Model) -> Result<Arc<KernelArrays>, TableError> {
        let nothing = || Arc::new(Mutex::new(Ok(Weak::new())));
        let place = (lock(&self.places).entry(path.into()))
            .or_insert_with(nothing)
            .clone();
        let mut held = lock(&place);
        if let Some(table) = held.clone()?.upgrade() {
            return Ok(table);
        }
        let fetched = self.store.systems(model);
        if let Err(error) = &fetched {
            *held = Err(*error);
        }
        let Fetched {
            table, warnings, ..
        } = fetched?;
        lock(&self.warnings).extend(warnings.iter().map(ToString::to_string));
        let table = Arc::new(table);
        *held = Ok(Arc::downgrade(&table));
        Ok(table)
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
