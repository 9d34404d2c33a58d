//! Result files: only this module turns results into columns.
//!
//! A job writes `points.parquet` and, if requested, `poincare.parquet`, `spectra.parquet`, `orders.parquet`,
//! `probes.parquet` with `attractors.parquet`, `basins.parquet`, `orbits.parquet`, `transitions.parquet` and
//! `horizon.parquet`, then `run.json`. Files get their final name only when complete; until then a journal keeps the
//! finished points. The shards of a split job are files `shard-i-of-n.parquet` in a *folder* of the table's name, which
//! every Parquet reader accepts as one data set.
//!
//! A traced trajectory has a separate folder with `trace.parquet` and `events.parquet`, then `trace.json`. Followed
//! orbits have `branches.parquet`, `bifurcations.parquet` and `curves.parquet`, then `follow.json`. A run-up has
//! `signals.parquet` and tables derived from it, then `runup.json`.
//!
//! The measurements of `atlas machine` also have a separate folder, with `machine.json`.
//!
//! Tables that are expensive to compute are stored between runs in a [`TableStore`].

mod atomic_file;
mod attractors;
mod basins;
mod batches;
mod chain_part;
mod chains;
mod characteristics;
mod checksum;
mod clock;
mod columns;
mod command_record;
mod contents;
mod continuation;
mod covariant;
mod error;
mod file;
mod fsync;
mod horizon;
mod interleave;
mod io_fault;
mod journal;
mod kernel_cache;
mod layout;
mod merge;
mod mesh_cache;
mod mesh_columns;
mod mesh_under_load;
mod nvh;
mod open;
mod orbits;
mod orders;
mod point_row;
mod probes;
mod read;
mod refined;
mod reorder;
mod replace;
mod run;
mod run_up;
mod samples;
mod table;
mod table_cache;
mod table_kind;
mod trace;
mod writer;

pub use atomic_file::{AtomicFile, write_atomically};
pub use attractors::{AttractorRow, attractors_table};
pub use basins::basins_table;
pub use chain_part::{ChainEnd, ChainPart, Level, Transition};
pub use chains::{TransitionRow, transitions_table};
pub use characteristics::{
    ArithmeticKey, BandwidthKey, Characteristics, Description, Figure, HugePages, LatencyKey,
    Measurement, MountainKey, NodeRecord, Noise, RoofRow, SolverKey,
};
pub use checksum::TableRecord;
pub use clock::{Stopwatch, timestamp};
pub use columns::{SpectrumRow, poincare_table, points_table, spectra_table};
pub use contents::Contents;
pub use continuation::{
    BifurcationRow, BranchRow, CurveRow, FollowedRows, OrbitColumns, bifurcation_rows,
    bifurcations_table, branch_rows, branches_table, curve_rows, curves_table,
    with_values_replaced, write_followed,
};
pub use error::{Damage, StoreError};
pub use file::{GROUP_BYTES, Shard, create_folder, remove_stale, table_path};
pub use horizon::horizon_table;
pub use io_fault::{IoFault, Purpose, Refusal};
pub use journal::{Journal, SYNC_INTERVAL, journal_bytes, journal_path};
pub use kernel_cache::{KernelArray, KernelArrays};
pub use layout::ResultLayout;
pub use merge::{MergeError, merge};
pub use mesh_cache::{MeshFetchError, MeshQuantity, mesh_quantities};
pub use mesh_under_load::MeshUnderLoad;
pub use nvh::ListElement;
pub use open::is_decoding;
pub use orbits::{OrbitRow, orbits_table};
pub use orders::{OrderRow, orders_table};
pub use point_row::{AxisColumn, Placement, PointRow, ResultOfPoint};
pub use probes::probes_table;
pub use read::{
    ColumnHead, ColumnKind, ResultTable, present_tables, read_run, read_runs, record_paths, verify,
};
pub use refined::RefinedColumns;
pub use replace::{Exchange, replace, statuses};
pub use run::{
    KernelRecord, MachineRecord, PlacementRecord, ProgramRecord, RetryRecord, RunRecord, RunState,
    ShardRecord, Totals, mixed_instructions_warning, run_path, write_run,
};
pub use run_up::{
    contact_changes_table, levels_table, order_tracks_table, signals_table, spectrogram_table,
    write_run_up,
};
pub use samples::SampleColumns;
pub use table::{Column, Table};
pub use table_cache::{
    CacheContent, CacheFault, CacheHeader, CacheKind, CacheWarning, Fetched, Origin, TableFile,
    TableStore,
};
pub use table_kind::TableKind;
pub use trace::{TraceLabel, TraceTables, TraceWriter, events_table, trace_table};
pub use writer::{ResultWriter, Written};
