//! Computed tables on disk: a cache that may be deleted at any time.
//!
//! A table is a set of named arrays of numbers that takes long to compute and is needed
//! again: by the next run, and by other processes of the same machine, which share the
//! pages of a large one. A file is named by a hash of what it was computed from; it is written under a
//! temporary name and renamed, never changed afterwards, and every byte of it is checked
//! before one is used. What is damaged or foreign is computed anew.

mod arrays;
mod error;
mod fault;
mod folder;
mod header;
mod key;
mod layout;
mod map;
mod mapped;
mod mesh;
mod operators;
mod watch;
mod write;

pub use arrays::Arrays;
pub use error::CacheError;
pub use fault::CacheFault;
pub use folder::{CacheEntry, CacheWarning, Cleaned, Fetched, Origin, TableStore, Unwanted};
pub use header::{ArrayHeader, CacheHeader};
pub use key::CacheKind;
pub use mapped::MappedTable;
pub use mesh::{FetchedMesh, MeshFetchError};
pub use operators::OperatorFetchError;
pub use watch::cut_down;

#[cfg(test)]
mod tests;
