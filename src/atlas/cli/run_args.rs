//! The options of `atlas run`.

use super::manifest_args::ManifestArgs;
use super::table::TablesFolder;
use super::threads::Threads;
use crate::store::Shard;
use crate::topology::Pinning;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Arguments of `atlas run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub(super) manifest: ManifestArgs,
    /// Write the results to this folder [default: results/JOB].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub(super) threads: Threads,
    /// Bind workers to cores even if there are fewer workers than cores.
    #[arg(long, conflicts_with = "no_pin")]
    pub pin: bool,
    /// Let the operating system place the workers.
    #[arg(long)]
    pub no_pin: bool,
    /// Compute only part i of n, such as 1/4: every n-th point, or every n-th chain of points [default: all points].
    #[arg(long, value_name = "i/n", value_parser = parse_shard)]
    pub shard: Option<Shard>,
    /// Replace the results in the folder and discard an interrupted run [default: continue it].
    #[arg(long)]
    pub overwrite: bool,
    /// Recompute points of finished results that have no result (status failed, diverged, event_storm or inaccurate),
    /// and keep the others.
    #[arg(long, value_name = "WHAT", conflicts_with = "overwrite")]
    pub retry: Option<Retry>,
    /// Stop the job after this many failed points; the same command continues it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub max_failures: Option<u64>,
    #[command(flatten)]
    pub(super) tables: TablesFolder,
    /// Print nothing but errors.
    #[arg(long, short)]
    pub quiet: bool,
    /// Print events to standard output, one JSON object per line. `event` gives the kind: started, point, progress
    /// (every second), warning, or finished (with the record, run.json).
    #[arg(long)]
    pub json: bool,
}

impl RunArgs {
    /// When workers are bound to cores, from `--pin` and `--no-pin`.
    pub(super) fn pinning(&self) -> Pinning {
        match (self.pin, self.no_pin) {
            (true, _) => Pinning::Always,
            (false, true) => Pinning::Never,
            (false, false) => Pinning::Full,
        }
    }
}

/// What is to be computed again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Retry {
    /// Points without a result.
    Failed,
}

/// Largest number of shards of a job.
const MOST_SHARDS: u32 = 100_000;

pub(super) fn parse_shard(text: &str) -> Result<Shard, String> {
    let shard = text.split_once('/').and_then(|(index, count)| {
        Some(Shard {
            index: index.parse().ok()?,
            count: count.parse().ok()?,
        })
    });
    shard
        .filter(|s| (1..=s.count).contains(&s.index) && s.count <= MOST_SHARDS)
        .ok_or_else(|| format!("a shard is i/n with 1 ≤ i ≤ n ≤ {MOST_SHARDS}, such as 2/8"))
}
