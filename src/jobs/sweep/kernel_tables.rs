//! Tables of kernels of a job: fetched from the cache or computed, once for all points that share them. On a
//! machine with several NUMA nodes they are copied if that saves time.

use super::shared::lock;
use crate::model::Model;
use crate::propagate::TableError;
use crate::store::{Fetched, KernelArrays, TableStore};
use crate::topology::{CopyRoom, TABLES_AT_HAND};
use std::collections::{BTreeSet, HashMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, Weak};

/// Largest number of known tables. Beyond it, tables that no kernel uses are removed.
const MOST_PLACES: usize = 1 << 14;

/// Largest number of recently used small tables in memory, and their total size \[bytes\]: a plane of small
/// structures then reads every file once. The latest [`TABLES_AT_HAND`] tables stay in memory at any size.
const MOST_SMALL_TABLES: usize = 256;
const MOST_SMALL_BYTES: usize = 1 << 20;

/// A table while a kernel uses it, or the reason why the model has none. The reason is determined once.
type Place = Arc<Mutex<Result<Weak<KernelArrays>, TableError>>>;

/// The state that workers of all nodes share.
#[derive(Debug)]
struct Common {
    store: TableStore,
    places: Mutex<HashMap<PathBuf, Place>>,
    warnings: Mutex<BTreeSet<String>>,
}

/// Kernel tables in memory. Only the most recently used ones stay in memory, so that memory does not grow with the
/// grid; the others remain as files.
#[derive(Debug)]
pub struct KernelTables {
    common: Arc<Common>,
    /// The most recently used tables, latest first.
    at_hand: Mutex<VecDeque<(PathBuf, Arc<KernelArrays>)>>,
    /// For the workers of one NUMA node: its room for copies.
    room: Option<CopyRoom>,
}

impl KernelTables {
    /// Tables that are stored in `store`.
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

    /// Shares the tables with the workers of one NUMA node, which make copies of them if there is room.
    pub fn on_node(&self, room: CopyRoom) -> Self {
        Self {
            common: self.common.clone(),
            at_hand: Mutex::default(),
            room: Some(room),
        }
    }

    /// The table of closed modes for a model. If several workers want the same one, one computes it and the others
    /// wait.
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
            .is_some_and(|room| room.should_copy(common.bytes() as u64));
        // The calling thread writes the copy, so that its pages belong to the node.
        let near = if pays { Arc::new(common.copied()) } else { common };
        at_hand.push_front((path, near.clone()));
        let mut bytes = 0;
        let is_kept = |(place, (_, table)): (usize, &(PathBuf, Arc<KernelArrays>))| {
            bytes += table.bytes();
            place < TABLES_AT_HAND || (place < MOST_SMALL_TABLES && bytes <= MOST_SMALL_BYTES)
        };
        let kept = at_hand.iter().enumerate().map(is_kept);
        let kept = kept.take_while(|kept| *kept).count();
        at_hand.truncate(kept);
        Ok(near)
    }

    /// Finds a table in memory and makes it the most recently used one.
    fn found(&self, path: &Path) -> Option<Arc<KernelArrays>> {
        let mut at_hand = lock(&self.at_hand);
        let place =
            (at_hand.iter()).position(|(known, _)| known.as_os_str() == path.as_os_str())?;
        let entry = at_hand.remove(place)?;
        let found = entry.1.clone();
        at_hand.push_front(entry);
        Some(found)
    }

    /// Calls `visit` with the longest array of each copy of the node.
    pub(super) fn for_each_copy(&self, mut visit: impl FnMut(&[f64])) {
        for (_, table) in lock(&self.at_hand).iter() {
            let pays = self
                .room
                .is_some_and(|room| room.should_copy(table.bytes() as u64));
            if pays {
                visit(table.longest());
            }
        }
    }

    /// Warnings about the cache, each once.
    pub fn warnings(&self) -> Vec<String> {
        lock(&self.common.warnings).iter().cloned().collect()
    }
}

impl Common {
    /// The table that all nodes share.
    fn get(&self, path: &Path, model: &Model) -> Result<Arc<KernelArrays>, TableError> {
        let nothing = || Arc::new(Mutex::new(Ok(Weak::new())));
        let mut places = lock(&self.places);
        if places.len() >= MOST_PLACES && !places.contains_key(path) {
            // Keep only tables that a worker waits for or a kernel uses.
            places.retain(|_, place| Arc::strong_count(place) > 1 || is_used(place));
        }
        let place = (places.entry(path.into())).or_insert_with(nothing).clone();
        drop(places);
        let mut table_slot = lock(&place);
        if let Some(table) = table_slot.clone()?.upgrade() {
            return Ok(table);
        }
        let fetched = self.store.systems(model);
        if let Err(error) = &fetched {
            *table_slot = Err(*error);
        }
        let Fetched {
            table, warnings, ..
        } = fetched?;
        lock(&self.warnings).extend(warnings.iter().map(ToString::to_string));
        let table = Arc::new(table);
        *table_slot = Ok(Arc::downgrade(&table));
        Ok(table)
    }
}

/// Whether a table is in use.
fn is_used(place: &Place) -> bool {
    (lock(place).as_ref()).is_ok_and(|table| table.strong_count() > 0)
}
