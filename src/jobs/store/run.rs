//! `run.json`: the job, the program, the machine, and the end of a run.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::StoreError;
use super::atomic_file::write_sealed;
use super::checksum::TableRecord;
use super::file::{Shard, create_folder};
use crate::propagate::instructions;
use crate::topology::{Machine, Topology};

/// Everything about a run except its results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Name of the job.
    pub job: String,
    /// Whether every point was computed.
    pub state: RunState,
    /// The part of a split job.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<Shard>,
    /// Start, RFC 3339, UTC.
    pub started: String,
    /// End, RFC 3339, UTC.
    pub finished: String,
    /// The program that ran it.
    pub program: ProgramRecord,
    /// The machine it ran on.
    pub machine: MachineRecord,
    /// Requested and actual threads, and their placement.
    pub placement: PlacementRecord,
    /// Counts and times over all points.
    pub totals: Totals,
    /// The kernels that `run.kernel = "auto"` chose, by name; empty if the manifest names one. A retry of failed points
    /// does not change them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kernels: Vec<KernelRecord>,
    /// The shards from which the results were joined; empty for a single run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shards: Vec<ShardRecord>,
    /// The tables as written; a file of another size or hash is damaged.
    pub tables: Vec<TableRecord>,
    /// Later runs that computed failed points again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub retries: Vec<RetryRecord>,
    /// Warnings for the user, one sentence each.
    pub warnings: Vec<String>,
    /// Hash of everything in the manifest that affects results, hexadecimal.
    pub manifest_hash: String,
    /// The manifest as the user wrote it.
    pub manifest: String,
    /// Keys whose values `--set` changed, each `KEY=VALUE`; the hash includes these values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// The folder in which relative paths of the manifest start.
    #[serde(default)]
    pub folder: String,
}

/// A kernel that was chosen for points of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct KernelRecord {
    /// Name of the kernel.
    pub kernel: String,
    /// Points that it integrated.
    pub points: u64,
    /// The first of these points.
    pub first_point: u64,
    /// Why the kernel was chosen for `first_point`, in words.
    pub why: String,
}

impl KernelRecord {
    /// Adds the kernels of another part of a job to `all`.
    pub fn join(all: &mut Vec<Self>, other: &[Self]) {
        for added in other {
            match all.iter_mut().find(|known| known.kernel == added.kernel) {
                Some(known) => {
                    let points = known.points + added.points;
                    if added.first_point < known.first_point {
                        known.clone_from(added);
                    }
                    known.points = points;
                }
                None => all.push(added.clone()),
            }
        }
        all.sort_by(|a, b| a.kernel.cmp(&b.kernel));
    }
}

/// Data of each shard in a joined record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShardRecord {
    /// The shard.
    pub shard: Shard,
    /// Start, RFC 3339, UTC.
    pub started: String,
    /// End, RFC 3339, UTC.
    pub finished: String,
    /// The machine it ran on.
    pub machine: MachineRecord,
    /// Threads and where they ran.
    pub placement: PlacementRecord,
    /// Counts and times over its points.
    pub totals: Totals,
}

/// A run that computed failed points of finished results again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RetryRecord {
    /// Start, RFC 3339, UTC.
    pub started: String,
    /// End, RFC 3339, UTC.
    pub finished: String,
    /// The program, which may differ from the program of the other points.
    pub program: ProgramRecord,
    /// Points computed again; whole chains if the state is carried.
    pub points: u64,
    /// Number of these that failed again.
    pub failed: u64,
    /// Mesh cycles integrated.
    pub cycles: u64,
    /// Wall time \[s\].
    pub wall_time: f64,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunState {
    /// Every point was computed.
    Complete,
    /// Points are missing.
    Interrupted,
}

/// The commit of the program; `None` before [`ProgramRecord::set_commit`].
static COMMIT: OnceLock<Option<&str>> = OnceLock::new();

/// The program that ran a job.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProgramRecord {
    /// `atlas`.
    pub name: String,
    /// Version.
    pub version: String,
    /// The commit it was built from, with `-dirty` if the sources were changed; absent if built outside a git checkout.
    pub commit: Option<String>,
}

impl ProgramRecord {
    /// This program.
    pub fn current() -> Self {
        Self {
            name: "atlas".to_owned(),
            version: env!("CARGO_PKG_VERSION").into(),
            commit: COMMIT.get().copied().flatten().map(str::to_owned),
        }
    }

    /// Sets the commit that the program was built from; only the first call has an effect. The top crate passes it
    /// down, so that a commit does not recompile this crate.
    pub fn set_commit(commit: Option<&'static str>) {
        COMMIT.get_or_init(|| commit);
    }
}

impl fmt::Display for ProgramRecord {
    /// `atlas 0.1.0 (0123456789ab)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.name, self.version)?;
        match &self.commit {
            Some(commit) => write!(f, " ({commit})"),
            None => Ok(()),
        }
    }
}

/// The machine a job ran on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MachineRecord {
    /// Name of the processor.
    pub cpu: String,
    /// Processor packages.
    pub packages: usize,
    /// Cores this process may use.
    pub cores: usize,
    /// Hardware threads this process may use.
    pub threads: usize,
    /// NUMA nodes.
    pub numa_nodes: usize,
    /// Source of packages, cores, threads and nodes: `hwloc`, or the files of `/sys`; empty if unknown, and in records
    /// of earlier versions.
    #[serde(default)]
    pub topology: String,
    /// Memory \[bytes\]; 0 if unknown.
    pub memory: u64,
    /// Instruction sets that kernels can use, widest last.
    pub isa: Vec<String>,
    /// Instructions that computed the points: `avx512` and `avx2`, which give the same bits, `baseline`, or `portable`,
    /// which gives the same bits on every processor. Several if a run was continued, or shards were joined, across
    /// processors.
    pub instructions: Vec<String>,
    /// Operating system and architecture.
    pub system: String,
}

impl MachineRecord {
    /// This machine; counts are 0 if its topology is unknown.
    pub fn current(topology: Option<&Topology>) -> Self {
        let machine = Machine::current();
        Self {
            cpu: machine.cpu,
            packages: topology.map_or(0, |t| t.packages),
            cores: topology.map_or(0, |t| t.cores.len()),
            threads: topology.map_or(0, Topology::threads),
            numa_nodes: topology.map_or(0, |t| t.numa_nodes.len()),
            topology: topology.map_or_else(String::new, |t| t.source.to_string()),
            memory: machine.memory,
            isa: machine.isa.into_iter().map(str::to_owned).collect(),
            instructions: vec![instructions().to_owned()],
            system: machine.system,
        }
    }
}

/// A warning if points were computed with several instructions; `None` if all of these give the same bits.
pub fn mixed_instructions_warning(instructions: &[String]) -> Option<String> {
    let kind = |name: &str| {
        match name {
            "avx512" | "avx2" => "fused",
            _ => name,
        }
        .to_owned()
    };
    let mut kinds = instructions.iter().map(|name| kind(name));
    let first = kinds.next()?;
    kinds.any(|other| other != first).then(|| {
        format!(
            "points were computed with different instructions ({}), so results differ by rounding, and chaotic motion \
             soon differs completely; run.instructions = \"portable\" gives the same bits on every processor",
            instructions.join(", ")
        )
    })
}

/// Requested and actual threads, and their placement.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlacementRecord {
    /// Requested threads; absent if the program chose their number.
    pub threads_asked: Option<u32>,
    /// Threads used.
    pub threads: u32,
    /// Requested placement, in words.
    pub asked: String,
    /// Actual placement, in words.
    pub obtained: String,
    /// Requested copies of structures and mesh tables, in words.
    #[serde(default)]
    pub copies_asked: String,
    /// Actual places of the copies.
    #[serde(default)]
    pub copies_obtained: String,
}

/// Counts and times over all points of a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Totals {
    /// Points of the grid (of the shard).
    pub points: u64,
    /// Points computed with status ok.
    pub ok: u64,
    /// Points whose results did not settle within their cycles (status not_converged).
    #[serde(default)]
    pub not_converged: u64,
    /// Points with status failed, diverged, event_storm or inaccurate.
    pub failed: u64,
    /// Points not computed (an interrupted run).
    pub missing: u64,
    /// Points taken from an earlier, interrupted run.
    #[serde(default)]
    pub resumed: u64,
    /// Mesh cycles integrated by this run.
    pub cycles: u64,
    /// Wall time of the run \[s\].
    pub wall_time: f64,
    /// Mesh cycles integrated per second of wall time.
    pub cycles_per_second: f64,
    /// Wall time of the run divided by the cycles that all threads integrated \[s\].
    pub wall_time_per_cycle: f64,
}

impl Totals {
    /// Totals with the rates from cycles and wall time (0 if nothing was integrated). All remaining points count as
    /// missing.
    pub fn new(points: u64, ok: u64, failed: u64, cycles: u64, wall_time: f64) -> Self {
        let ratio = |over: f64, under: f64| if under > 0.0 { over / under } else { 0.0 };
        Self {
            points,
            ok,
            not_converged: 0,
            failed,
            missing: points.saturating_sub(ok + failed),
            resumed: 0,
            cycles,
            wall_time,
            cycles_per_second: ratio(cycles as f64, wall_time),
            wall_time_per_cycle: ratio(wall_time, cycles as f64),
        }
    }
}

impl Totals {
    /// Adds the totals of another part of the job: times add up as if the parts ran in sequence.
    pub fn add(&mut self, other: &Self) {
        let sum = Self::new(
            self.points + other.points,
            self.ok + other.ok,
            self.failed + other.failed,
            self.cycles + other.cycles,
            self.wall_time + other.wall_time,
        );
        *self = Self {
            not_converged: self.not_converged + other.not_converged,
            missing: self.missing + other.missing,
            resumed: self.resumed + other.resumed,
            ..sum
        };
    }
}

/// Path of a run's record (of a shard).
pub fn run_path(folder: &Path, shard: Option<Shard>) -> PathBuf {
    folder.join(match shard {
        None => "run.json".to_owned(),
        Some(shard) => format!("run.{}.json", shard.stem()),
    })
}

/// Writes `run.json` (`run.shard-i-of-n.json` for a shard), completely or not at all. Its last key, `blake3`, is the
/// hash of the text before it.
///
/// # Errors
/// The file cannot be written.
pub fn write_run(folder: &Path, record: &RunRecord) -> Result<(), StoreError> {
    create_folder(folder)?;
    write_sealed(&run_path(folder, record.shard), record)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::store::read_runs;

    pub fn record(shard: Option<Shard>) -> RunRecord {
        RunRecord {
            job: "flex80".into(),
            state: RunState::Interrupted,
            shard,
            started: "2026-03-01T12:00:00Z".into(),
            finished: "2026-03-01T12:00:02Z".into(),
            program: ProgramRecord::current(),
            machine: MachineRecord::current(None),
            placement: PlacementRecord {
                threads_asked: None,
                threads: 8,
                asked: "one worker per core".into(),
                obtained: "not bound".into(),
                copies_asked: "one copy for all workers".into(),
                copies_obtained: "one copy for all workers".into(),
            },
            totals: Totals::new(80, 70, 4, 50_000, 2.0),
            kernels: Vec::new(),
            shards: Vec::new(),
            tables: Vec::new(),
            retries: Vec::new(),
            warnings: vec!["binding is not possible here".into()],
            manifest_hash: "0123abcd".into(),
            manifest: "[job]\nname = \"flex80\"\n".into(),
            set: Vec::new(),
            folder: "/drives".into(),
        }
    }

    #[test]
    fn a_record_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(read_runs(folder.path()).unwrap(), []);
        write_run(folder.path(), &record(None)).unwrap();
        assert_eq!(read_runs(folder.path()).unwrap(), [record(None)]);
        let text = std::fs::read_to_string(folder.path().join("run.json")).unwrap();
        assert!(text.contains("\"state\": \"interrupted\""), "{text}");
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "no temporary file stays"
        );
    }

    #[test]
    fn instructions_are_mixed_where_their_bits_differ() {
        let warning_of = |names: &[&str]| {
            mixed_instructions_warning(&names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>())
        };
        for equal in [
            &["avx2"][..],
            &["avx512", "avx2"],
            &["portable"],
            &["baseline"],
            &[],
        ] {
            assert_eq!(warning_of(equal), None, "{equal:?}");
        }
        for unlike in [
            ["avx2", "baseline"],
            ["portable", "avx512"],
            ["baseline", "portable"],
        ] {
            let message = warning_of(&unlike).unwrap();
            assert!(
                unlike.iter().all(|name| message.contains(name)),
                "{message}"
            );
        }
    }

    #[test]
    fn shards_each_have_a_record() {
        let folder = tempfile::tempdir().unwrap();
        let shards = [1, 2].map(|index| Some(Shard { index, count: 2 }));
        for shard in shards {
            write_run(folder.path(), &record(shard)).unwrap();
        }
        assert_eq!(read_runs(folder.path()).unwrap(), shards.map(record));
    }

    #[test]
    fn rates_follow_from_cycles_and_time() {
        let totals = record(None).totals;
        assert_eq!(totals.missing, 6);
        assert_eq!(totals.cycles_per_second, 25_000.0);
        assert_eq!(totals.wall_time_per_cycle, 4e-5);
        let nothing = Totals::new(1, 0, 0, 0, 0.0);
        assert_eq!(
            (nothing.cycles_per_second, nothing.wall_time_per_cycle),
            (0.0, 0.0)
        );
    }

    #[test]
    fn the_program_knows_itself() {
        let program = ProgramRecord::current();
        assert_eq!(program.name, "atlas");
        if let Some(commit) = program.commit {
            let hash = commit.trim_end_matches("-dirty");
            assert!(
                hash.len() >= 7 && hash.chars().all(|c| c.is_ascii_hexdigit()),
                "{commit}"
            );
        }
    }
}
