//! Runs a sweep: the thread pool, and the channel between workers and writer.

use super::chain::compute;
use super::chain_tasks::{ChainSelection, FinishedChains};
use super::layout::layout;
use super::panic_hook::WORKER;
use super::parts::Prepared;
use super::point::Worker;
use super::point_kernel::KernelTally;
use super::queue::Queue;
use super::recorder::{CHANNEL, Progress, ProgressObserver, Recorded, Recorder, SweepPlan};
use super::refine::Refinement;
use super::shared::lock;
use crate::manifest::Job;
use crate::store::{Journal, PlacementRecord, PointRow, ResultWriter, Shard, StoreError};
use crate::topology::{Copies, Pinning, Plan, Topology, copies, default_workers, plan};
use crossbeam_channel::{Sender, bounded};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Options of a sweep.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options<'a> {
    /// Worker threads; one per core if absent.
    pub threads: Option<usize>,
    /// Whether workers are bound to their cores.
    pub pinning: Pinning,
    /// The part of a split job.
    pub shard: Option<Shard>,
    /// Only these points, with their whole chains; the files are those of an undivided run.
    pub only: Option<&'a BTreeSet<u64>>,
    /// Number of failed points, without those of earlier runs, that interrupts the sweep.
    pub most_failures: Option<u64>,
}

/// The end of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Finished {
    /// Points of this run; for an interrupted refined grid, those known to be needed.
    pub points: u64,
    /// Threads, their places and the copies of structures and mesh tables.
    pub placement: PlacementRecord,
    /// The recorded points and tables.
    pub recorded: Recorded,
}

/// Why a sweep could not run.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Results cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Threads cannot be started.
    #[error(
        "cannot start {threads} worker threads: {reason}; ask for fewer with --threads, or raise the limit \
         on threads (`ulimit -u`, or pids.max of the control group)"
    )]
    Threads {
        /// Requested number of threads.
        threads: usize,
        /// Message of the system.
        reason: String,
    },
}

impl SweepError {
    /// The error if this number of threads cannot be started.
    pub(super) fn threads(threads: usize, reason: &dyn std::error::Error) -> Self {
        Self::Threads {
            threads,
            reason: reason.to_string(),
        }
    }
}

/// A job, its output folder and the resources of its run.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    /// The job.
    pub job: &'a Job,
    /// Folder of its tables.
    pub folder: &'a Path,
    /// Options.
    pub options: Options<'a>,
    /// Structures and mesh tables.
    pub parts: &'a Prepared,
    /// The machine, if it can be described.
    pub topology: Option<&'a Topology>,
    /// If raised, unfinished points are dropped and finished ones written.
    pub interrupt: &'a AtomicBool,
}

/// The state of a sweep after its journal was read.
struct ResumedSweep {
    writer: ResultWriter,
    progress: Progress,
    kernels: KernelTally,
    refinement: Option<Refinement>,
    /// Points of this run.
    selection: ChainSelection,
    finished: FinishedChains,
}

impl Sweep<'_> {
    /// Runs the job and writes its tables. Points in the journal are taken from it; the others are computed and
    /// appended to it. The caller removes the journal once everything else is written.
    ///
    /// # Errors
    /// Threads cannot be started, or results cannot be written, which stops the sweep.
    pub fn run(
        &self,
        journal: &mut Journal,
        watcher: &mut dyn ProgressObserver,
    ) -> Result<Finished, SweepError> {
        let Self {
            job,
            options,
            parts,
            topology,
            interrupt,
            ..
        } = *self;
        let mut resumed = self.resume(journal)?;
        let workers = start_workers(job, &resumed.selection, options, topology)?;
        let threads = workers.threads;
        if let Some(refinement) = &mut resumed.refinement {
            resumed.selection = ChainSelection::of_points(refinement.next_round());
            resumed.finished = FinishedChains::default();
        }
        resumed.progress.points = match &resumed.refinement {
            Some(refinement) => refinement.points(),
            None => resumed.selection.points() as u64,
        };
        let asked = workers.places.to_string();
        watcher.begun(&SweepPlan {
            progress: resumed.progress,
            threads,
            asked: &asked,
            obtained: &workers.obtained,
        });
        let shown = self.prepare(&resumed, &workers.pool, watcher);

        let copies = copies(&workers.places);
        let rooms = topology.map_or_else(Vec::new, |topology| topology.rooms(&copies));
        let of_nodes: Vec<Prepared> = rooms.into_iter().map(|room| parts.on_node(room)).collect();
        let written = AtomicU64::new(match &resumed.refinement {
            // Points of a refined grid do not wait in memory for others.
            Some(_) => u64::MAX / 2,
            None => resumed.progress.done - resumed.writer.waiting() as u64,
        });
        let points = AtomicU64::new(resumed.progress.points);
        let refinement = resumed.refinement.map(Mutex::new);
        let shared = Shared {
            sweep: self,
            workers: &workers,
            of_nodes: &of_nodes,
            copies: &copies,
            written: &written,
            points: &points,
            refinement: refinement.as_ref(),
        };
        let (sender, receiver) = bounded(CHANNEL);
        let ended = std::thread::scope(|scope| {
            let recorder = Recorder {
                writer: resumed.writer,
                journal,
                progress: resumed.progress,
                kernels: resumed.kernels,
                watcher: &mut *watcher,
                begun: Instant::now(),
                written: &written,
                points: &points,
                refinement: refinement.as_ref(),
                most_failures: options.most_failures,
                interrupt,
            };
            let record = move || {
                let recorded = recorder.record_all(&receiver);
                if recorded.is_err() {
                    // Further points could not be recorded.
                    interrupt.store(true, Ordering::Relaxed);
                }
                recorded
            };
            let writing = std::thread::Builder::new()
                .spawn_scoped(scope, record)
                .map_err(|error| SweepError::threads(threads + 1, &error))?;
            shared.compute(resumed.selection, resumed.finished, &sender);
            drop(sender);
            let recorded = writing
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
            Ok::<_, SweepError>(recorded)
        });
        // Tables of meshes may be made after the preparation: for later points of a chain or later rounds.
        for warning in parts
            .warnings()
            .iter()
            .filter(|&warning| !shown.contains(warning))
        {
            watcher.warning(warning);
        }
        let recorded = ended?;
        let placement = PlacementRecord {
            threads_asked: options.threads.map(|threads| threads as u32),
            threads: threads as u32,
            asked,
            copies_obtained: copies_obtained(&of_nodes, &copies, topology),
            copies_asked: copies.to_string(),
            obtained: workers.obtained,
        };
        Ok(Finished {
            points: points.into_inner(),
            placement,
            recorded,
        })
    }

    /// The shard whose tables are written; `None` if only some points are computed.
    fn shard(&self) -> Option<Shard> {
        let Options { shard, only, .. } = self.options;
        shard.filter(|_| only.is_none())
    }

    /// Reads the points in the journal.
    fn resume(&self, journal: &mut Journal) -> Result<ResumedSweep, SweepError> {
        let (job, options) = (self.job, self.options);
        let mut selection = ChainSelection::of_shard(job, options.shard);
        if let Some(only) = options.only {
            selection = selection.with(only);
        }
        let mut writer = ResultWriter::create(self.folder, &layout(job, self.shard()), [])?;
        let mut progress = Progress {
            open: job.refine.is_some(),
            ..Progress::default()
        };
        let mut refinement = job.refine.as_ref().map(Refinement::new);
        if refinement.is_none() {
            writer.expect(selection.clone().ids());
        }
        let mut kernels = KernelTally::default();
        let finished = FinishedChains::replay(job, journal, |row| {
            progress.count(&row);
            kernels.count(&row);
            match &mut refinement {
                Some(refinement) => {
                    refinement.record_point(&row);
                    Ok(())
                }
                None => writer.push(row),
            }
        })?;
        progress.resumed = progress.done;
        Ok(ResumedSweep {
            writer,
            progress,
            kernels,
            refinement,
            selection,
            finished,
        })
    }

    /// Prepares the mesh tables, and their structures, of the first points of all unfinished chains. Returns the
    /// warnings, which it passes to `watcher`.
    fn prepare(
        &self,
        resumed: &ResumedSweep,
        pool: &rayon::ThreadPool,
        watcher: &mut dyn ProgressObserver,
    ) -> Vec<String> {
        let length = self.job.chain_length();
        // The writer cannot be shared with the workers.
        let ResumedSweep {
            selection,
            finished,
            ..
        } = resumed;
        let left = (0..selection.chains()).filter(|&place| !finished.has(selection, place));
        let firsts = left.map(|place| selection.id(place * length));
        let mut tables = 0;
        let mut prepared = || {
            tables += 1;
            watcher.prepared(tables);
        };
        pool.install(|| {
            (self.parts).prepare(self.job, firsts, self.interrupt, &mut prepared);
        });
        let warnings = self.parts.meshes().warnings();
        for warning in &warnings {
            watcher.warning(warning);
        }
        warnings
    }
}

/// State that the workers of a sweep share.
struct Shared<'a> {
    sweep: &'a Sweep<'a>,
    workers: &'a Workers,
    of_nodes: &'a [Prepared],
    copies: &'a Copies,
    written: &'a AtomicU64,
    points: &'a AtomicU64,
    refinement: Option<&'a Mutex<Refinement>>,
}

impl Shared<'_> {
    /// Computes all points of a selection; for a refined grid those of all rounds.
    fn compute(
        &self,
        selection: ChainSelection,
        finished: FinishedChains,
        sender: &Sender<PointRow>,
    ) {
        let Sweep {
            job,
            parts,
            interrupt,
            ..
        } = *self.sweep;
        let shards = (self.sweep.shard()).map_or(1, |shard| shard.count as usize);
        let queue = |selection, finished| {
            let (threads, nodes) = (self.workers.threads, self.of_nodes.len());
            Queue::new(job, selection, finished, shards, threads, nodes)
        };
        let mut present = queue(selection, finished);
        loop {
            (self.workers.pool).broadcast(|context| self.work(&present, context.index(), sender));
            let Some(refinement) = self.refinement else {
                break;
            };
            let next = lock(refinement).next_round();
            if next.is_empty() {
                break;
            }
            (self.points).store(lock(refinement).points(), Ordering::Relaxed);
            if interrupt.load(Ordering::Relaxed) {
                break;
            }
            let firsts = next.iter().copied();
            (self.workers.pool).install(|| parts.prepare(job, firsts, interrupt, &mut || ()));
            present = queue(ChainSelection::of_points(next), FinishedChains::default());
        }
    }

    /// Makes worker `index` compute chains until none is left or the run is interrupted. The chains do not
    /// depend on each other: they are all chains of a job, or of one round of a refined grid.
    fn work(&self, queue: &Queue<'_>, index: usize, sender: &Sender<PointRow>) {
        let Sweep {
            job,
            topology,
            interrupt,
            ..
        } = *self.sweep;
        let copy = self.copies.of_worker.get(index).copied().flatten();
        let parts = copy.map_or(self.sweep.parts, |copy| &self.of_nodes[copy]);
        let written = || self.written.load(Ordering::Relaxed);
        let pause = || std::thread::sleep(Duration::from_millis(1));
        queue.serve(written, pause, copy, interrupt, |turn, seat| {
            let index = index as u32;
            let (first, mut link) = (turn.first, turn.link);
            let worker = Worker {
                index,
                topology,
                seat,
            };
            while link.passed() < job.chain_length() {
                let point = job.points.at(first + link.passed());
                let row = compute(job, &point, &link, parts, worker, interrupt).ok()?;
                link.pass(job, &row);
                if let Some(refinement) = self.refinement {
                    lock(refinement).record_point(&row);
                }
                // The channel is closed if the writer has given up.
                sender.send(row).ok()?;
                if interrupt.load(Ordering::Relaxed) {
                    return None;
                }
            }
            Some(())
        });
    }
}

/// Threads that are ready for work.
pub(super) struct Workers {
    pub pool: rayon::ThreadPool,
    pub threads: usize,
    /// Intended places of the threads.
    pub places: Plan,
    /// Actual placement of the threads, in words.
    pub obtained: String,
}

/// Upper limit of workers: four per hardware thread, but at least 32, so that other numbers can be tried. Each has the
/// workspace of a point; more workers would only wait for memory and for each other.
fn most_workers(hardware_threads: usize) -> usize {
    const A_HARDWARE_THREAD: usize = 4;
    const LEAST_LIMIT: usize = 32;
    (A_HARDWARE_THREAD * hardware_threads).max(LEAST_LIMIT)
}

/// Starts the workers for these chains: the requested number, or one per core, but not more than the pieces of work or
/// the upper limit.
pub(super) fn start_workers(
    job: &Job,
    selection: &ChainSelection,
    options: Options<'_>,
    topology: Option<&Topology>,
) -> Result<Workers, SweepError> {
    let cores = topology.map_or(&[][..], |t| &t.cores);
    let parallelism = std::thread::available_parallelism().ok();
    let threads = options
        .threads
        .unwrap_or_else(|| default_workers(cores.len(), parallelism.map(usize::from)));
    let most = most_workers(parallelism.map_or(1, usize::from));
    let threads = threads.min(most);
    let threads = threads.clamp(1, pieces(job, selection, threads).max(1));
    let places = plan(cores, threads, options.pinning);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("{WORKER}{i}"))
        .build()
        .map_err(|error| SweepError::threads(threads, &error))?;
    let obtained = take_places(&pool, &places, topology);
    Ok(Workers {
        pool,
        threads,
        places,
        obtained,
    })
}

/// Binds every worker to its place if planned, and describes the result. A worker that cannot be bound runs where the
/// system puts it.
fn take_places(pool: &rayon::ThreadPool, places: &Plan, topology: Option<&Topology>) -> String {
    let Some(topology) = topology.filter(|_| places.pinned) else {
        return "not pinned".into();
    };
    let bindings = pool.broadcast(|context| {
        let place = &places.places[context.index()];
        topology.bind_current_thread(&place.threads)
    });
    let bound = bindings.iter().filter(|binding| binding.is_ok()).count();
    match bindings.iter().find_map(|binding| binding.as_ref().err()) {
        None => "pinned".into(),
        Some(error) => format!("{bound} of {} workers pinned: {error}", bindings.len()),
    }
}

/// The actual nodes of the copies, in words.
fn copies_obtained(of_nodes: &[Prepared], copies: &Copies, topology: Option<&Topology>) -> String {
    if of_nodes.is_empty() {
        return copies.to_string();
    }
    let nodes_of = |parts: &Prepared| topology.map_or_else(BTreeSet::new, |t| parts.nodes(t));
    let actual_nodes: Vec<BTreeSet<u32>> = of_nodes.iter().map(nodes_of).collect();
    if actual_nodes.iter().all(BTreeSet::is_empty) {
        return format!(
            "{} copies; the system does not report their nodes",
            of_nodes.len()
        );
    }
    let mut pairs = actual_nodes.iter().zip(&copies.nodes);
    if pairs.all(|(nodes, node)| nodes.iter().eq([node])) {
        return copies.to_string();
    }
    let words = copies.nodes.iter().zip(&actual_nodes).map(|(node, nodes)| {
        let node_texts: Vec<String> = nodes.iter().map(u32::to_string).collect();
        format!("the copy of node {node} on [{}]", node_texts.join(", "))
    });
    words.collect::<Vec<String>>().join("; ")
}

/// Number of pieces of work that can run at the same time: chains, or their probes or cells if there are any. At most
/// `enough` chains count; for a refined grid the number is `enough`.
pub(super) fn pieces(job: &Job, selection: &ChainSelection, enough: usize) -> usize {
    // Later rounds may have more points than the first.
    if job.refine.is_some() {
        return enough;
    }
    let chains = selection.chains().min(enough);
    let pieces = (0..chains).map(|place| {
        let first = job
            .points
            .variant_near(selection.id(place * job.chain_length()));
        let probes = first.analyses.multistability;
        probes.map_or(1, |config| {
            let cells = config
                .slice
                .map_or(0, |slice| (slice.count as usize).pow(2));
            cells.max(config.initial_conditions as usize)
        })
    });
    pieces.sum()
}
