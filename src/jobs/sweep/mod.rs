//! Computes a grid of operating points on the cores of this machine.
//!
//! Workers of a rayon pool take chains, long ones first, and compute their points one by one. A writer thread, fed
//! through a bounded channel, streams the rows to Parquet in point order. A chain is one point, or all points along an
//! axis if the state is carried from one to the next. Results depend on the chain alone, so they are the same for
//! any number of threads. A point that fails or panics becomes a row and does not end the job. Every row is in the
//! journal before it reaches the writer, so that a killed run can be resumed.
//!
//! Results determine which points a refined grid needs. Such a grid is computed in rounds, and its tables are
//! written after the last round.

mod branch_tables;
pub mod build;
mod carried;
mod chain;
mod chain_tasks;
mod continuation;
mod cycle_map;
mod estimate;
mod existing_results;
mod family;
mod first_force;
mod forecast;
mod further_meshes;
mod job_run;
mod kernel_tables;
mod layout;
mod loaded_mesh;
mod mesh_divisions;
mod mesh_error;
mod mesh_tables;
mod motion_scale;
mod node_copies;
mod pair_meshes;
mod panic_hook;
mod parts;
mod point;
mod point_kernel;
mod queue;
mod recorder;
mod refine;
mod run;
mod run_up;
mod sensitivity;
mod shared;
mod trace;
mod trial;

pub use branch_tables::write_branches;
pub use chain::{ChainState, chain_state_before, compute};
pub use chain_tasks::ChainSelection;
pub use continuation::{Curves, FollowError, Followed, Line, follow_job};
pub use cycle_map::{CycleMap, MapConfig, MapError, MapImage, MapTangents};
pub use estimate::Interval;
pub use existing_results::{
    ExistingResults, ExistingResultsError, inspect as inspect_existing_results,
};
pub use family::PointFamily;
pub use forecast::{Forecast, forecast};
pub use further_meshes::FurtherMeshError;
pub use job_run::{JobRun, JobRunEnd, JobRunError, this_machine};
pub use kernel_tables::KernelTables;
pub use layout::{NO_FLANKS, sample_columns};
pub use loaded_mesh::{LoadedMesh, loaded_further_meshes, loaded_mesh};
pub use mesh_error::MeshError;
pub use mesh_tables::{MeshTables, TabledMesh};
pub use panic_hook::{WORKER, silence_reported_panics};
pub use parts::{Prepared, structures};
pub use point::Worker;
pub use point_kernel::{KernelTally, PointKernel};
pub use recorder::{Progress, ProgressObserver, Recorded, SweepPlan};
pub use run::{Finished, Options, Sweep, SweepError};
pub use run_up::{PointRunUp, RunUpError};
pub use sensitivity::{
    Differentiated, Sensitivities, Sensitivity, SensitivityError, sensitivities,
};
pub use trace::{PointTrace, PointTraceError};
