//! A grid of operating points over the cores of this machine.
//!
//! Workers of a rayon pool take points in order and answer them one by one; a writer
//! thread, fed through a bounded channel, streams the rows to Parquet in point order. A
//! point's numbers depend on the point alone, so they are the same for any number of
//! threads. A point that fails or panics is a row, never the end of the job. Every row is in
//! the journal before it reaches the writer, so that a killed run can be taken up.

pub mod build;
mod point;
mod run;

pub use point::{Worker, compute};
pub use run::{Finished, Options, Progress, SweepError, Watcher, run, shard_points};
