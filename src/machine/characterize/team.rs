//! The method of all measurements: threads that are bound to cores do the same work at the same time. The
//! time of a repetition is from the first start to the last end.
//!
//! Every thread allocates its memory itself, after it is bound, and warms up before the
//! timing starts.

use super::error::MeasurementError;
use crate::topology::Topology;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// A hardware thread that a member of a team is bound to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HardwareThread {
    /// The system's number of the thread.
    pub index: u32,
    /// The system's number of its NUMA node.
    pub node: u32,
}

/// Duration and number of repetitions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RepetitionTime {
    /// Time after which repetitions end.
    pub slice: Duration,
    /// Smallest number of repetitions.
    pub least: usize,
    /// Largest number of repetitions.
    pub most: usize,
}

/// Results of a team.
#[derive(Debug)]
pub struct TeamResults<R> {
    /// Times of the repetitions of every task \[s\].
    pub times: Vec<Vec<f64>>,
    /// Result of each member.
    pub results: Vec<R>,
    /// Why members could not be bound; `None` if they were.
    pub unbound: Option<String>,
}

impl<R> TeamResults<R> {
    /// Times per unit of work; `units` is the number of units per repetition of each task.
    pub fn per_unit(mut self, units: &[f64]) -> Self {
        for (times, units) in self.times.iter_mut().zip(units) {
            times.iter_mut().for_each(|time| *time /= units);
        }
        self
    }
}

impl<R> TeamResults<(bool, R)> {
    /// The times, if the computed results were right.
    ///
    /// # Errors
    /// A member reports a wrong result.
    pub fn checked(self, what: &'static str) -> Result<TeamResults<R>, MeasurementError> {
        let (right, results): (Vec<bool>, Vec<R>) = self.results.into_iter().unzip();
        if right.contains(&false) {
            Err(MeasurementError::Wrong { what })
        } else {
            Ok(TeamResults {
                times: self.times,
                results,
                unbound: self.unbound,
            })
        }
    }
}

/// Runs a member on every hardware thread. Each member prepares its state. For each of `tasks` pieces of work
/// it then calls `warm` once, and repeats `once`. At the end it calls `finish`. If a preparation fails,
/// nothing is repeated.
///
/// # Errors
/// A preparation failed.
#[expect(clippy::too_many_arguments, reason = "four steps of a measurement")]
pub fn work<S, R: Send>(
    topology: &Topology,
    threads: &[HardwareThread],
    tasks: usize,
    pace: RepetitionTime,
    prepare: impl Fn(usize) -> Result<S, MeasurementError> + Sync,
    warm: impl Fn(&mut S, usize) + Sync,
    once: impl Fn(&mut S, usize) + Sync,
    finish: impl Fn(S) -> R + Sync,
) -> Result<TeamResults<R>, MeasurementError> {
    let intervals: Vec<Interval> = threads.iter().map(|_| Interval::default()).collect();
    let (barrier, failed, on) = (
        SpinBarrier::new(threads.len()),
        AtomicBool::new(false),
        AtomicBool::new(true),
    );
    let epoch = Instant::now();
    let member = |index: usize| {
        let _after_panic = ReleaseAfterPanic(&barrier, &on);
        let unbound = (topology.bind_current_thread(&[threads[index].index]))
            .err()
            .map(|error| error.to_string());
        let prepared = prepare(index);
        failed.fetch_or(prepared.is_err(), Ordering::SeqCst);
        barrier.wait();
        let mut state = match prepared {
            Err(error) => return Err(error),
            Ok(_) if failed.load(Ordering::SeqCst) => return Ok(None),
            Ok(state) => state,
        };
        let mut times = vec![Vec::new(); tasks];
        for (task, times) in times.iter_mut().enumerate() {
            if barrier.is_open() {
                break;
            }
            warm(&mut state, task);
            barrier.wait();
            let begun = Instant::now();
            loop {
                barrier.wait();
                let start = epoch.elapsed();
                once(&mut state, task);
                intervals[index].set(start, epoch.elapsed());
                barrier.wait();
                if index == 0 {
                    times.push(Interval::over_all(&intervals));
                    let enough = times.len() >= pace.least && begun.elapsed() >= pace.slice;
                    on.store(!enough && times.len() < pace.most, Ordering::SeqCst);
                }
                barrier.wait();
                if !on.load(Ordering::SeqCst) || barrier.is_open() {
                    break;
                }
            }
        }
        Ok(Some((times, finish(state), unbound)))
    };
    // Start a new thread even for one member, so that the calling thread is not bound.
    let ended: Vec<_> = std::thread::scope(|scope| {
        let member = &member;
        let started: Vec<_> = (0..threads.len())
            .map(|index| scope.spawn(move || member(index)))
            .collect();
        (started.into_iter())
            .map(|thread| (thread.join()).unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    let mut worked = TeamResults {
        times: Vec::new(),
        results: Vec::new(),
        unbound: None,
    };
    for end in ended {
        if let Some((times, result, unbound)) = end? {
            if worked.results.is_empty() {
                worked.times = times;
            }
            worked.results.push(result);
            worked.unbound = worked.unbound.or(unbound);
        }
    }
    Ok(worked)
}

/// Number of rounds of `run` that take about the time `wanted`. It tries 1, 2, 4, … rounds.
pub fn rounds_for(wanted: Duration, mut run: impl FnMut(usize)) -> usize {
    let mut rounds = 1;
    loop {
        let begun = Instant::now();
        run(rounds);
        let elapsed = begun.elapsed();
        if 2 * elapsed >= wanted || rounds > 1 << 40 {
            let scale = wanted.as_secs_f64() / elapsed.as_secs_f64().max(1e-9);
            return ((rounds as f64 * scale) as usize).max(1);
        }
        rounds *= 2;
    }
}

/// Working time of one member \[ns since the epoch\], on a separate cache line.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Interval {
    start: AtomicU64,
    end: AtomicU64,
}

impl Interval {
    fn set(&self, start: Duration, end: Duration) {
        self.start.store(start.as_nanos() as u64, Ordering::SeqCst);
        self.end.store(end.as_nanos() as u64, Ordering::SeqCst);
    }

    /// From the first start to the last end \[s\].
    fn over_all(intervals: &[Self]) -> f64 {
        let starts = intervals
            .iter()
            .map(|interval| interval.start.load(Ordering::SeqCst));
        let ends = intervals
            .iter()
            .map(|interval| interval.end.load(Ordering::SeqCst));
        let (first, last) = (starts.min().unwrap_or(0), ends.max().unwrap_or(0));
        1e-9 * last.saturating_sub(first) as f64
    }
}

/// A barrier at which members spin, and yield the processor only after many checks. A member that the system
/// must wake up would start late.
struct SpinBarrier {
    members: usize,
    waiting: AtomicUsize,
    passed: AtomicUsize,
    /// Whether a member has panicked. Then no member waits.
    open: AtomicBool,
}

/// If the member that owns this value panics, the other members neither wait for it nor repeat further.
struct ReleaseAfterPanic<'a>(&'a SpinBarrier, &'a AtomicBool);

impl Drop for ReleaseAfterPanic<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.1.store(false, Ordering::SeqCst);
            self.0.open.store(true, Ordering::SeqCst);
        }
    }
}

/// Number of checks of the barrier before the thread yields the processor.
pub const SPINS: usize = 20_000;

impl SpinBarrier {
    /// Whether a member has panicked.
    fn is_open(&self) -> bool {
        self.open.load(Ordering::SeqCst)
    }

    fn new(members: usize) -> Self {
        Self {
            members,
            waiting: AtomicUsize::new(0),
            passed: AtomicUsize::new(0),
            open: AtomicBool::new(false),
        }
    }

    /// Waits for all members.
    fn wait(&self) {
        let turn = self.passed.load(Ordering::SeqCst);
        if self.waiting.fetch_add(1, Ordering::SeqCst) + 1 == self.members {
            self.waiting.store(0, Ordering::SeqCst);
            self.passed.fetch_add(1, Ordering::SeqCst);
            return;
        }
        let mut spins = 0;
        while self.passed.load(Ordering::SeqCst) == turn && !self.open.load(Ordering::SeqCst) {
            spins += 1;
            if spins < SPINS { std::hint::spin_loop() } else { std::thread::yield_now() }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: RepetitionTime = RepetitionTime {
        slice: Duration::ZERO,
        least: 3,
        most: 10,
    };

    fn shared_core(count: usize) -> (Topology, Vec<HardwareThread>) {
        let topology = Topology::current().unwrap();
        let index = topology.cores[0].threads[0];
        (topology, vec![HardwareThread { index, node: 0 }; count])
    }

    /// Three members on one core: the barrier does not need separate cores.
    #[test]
    fn all_members_do_all_tasks_equally_often() {
        let (topology, threads) = shared_core(3);
        let worked = work(
            &topology,
            &threads,
            2,
            PACE,
            |index| Ok((index, [0, 0])),
            |(_, done), task| done[task] += 10,
            |(_, done), task| done[task] += 1,
            |state| state,
        )
        .unwrap();
        assert_eq!(worked.results, [0, 1, 2].map(|index| (index, [13, 13])));
        assert!(worked.times.iter().all(|times| times.len() == 3));
        assert!(worked.times.iter().flatten().all(|time| *time >= 0.0));
    }

    #[test]
    fn one_failed_preparation_lets_everybody_go() {
        let (topology, threads) = shared_core(2);
        let ended = work(
            &topology,
            &threads,
            1,
            PACE,
            |index| match index {
                1 => Err(MeasurementError::Wrong { what: "this" }),
                _ => Ok(()),
            },
            |(), _| (),
            |(), _| (),
            |()| (),
        );
        assert!(matches!(
            ended,
            Err(MeasurementError::Wrong { what: "this" })
        ));
    }

    /// The panic of one member ends the work of both, and reaches the caller.
    #[test]
    fn a_panic_keeps_nobody_waiting() {
        let (topology, threads) = shared_core(2);
        let ended = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            work(
                &topology,
                &threads,
                1,
                PACE,
                Ok,
                |_, _| (),
                |index, _| assert_eq!(*index, 0, "the second member fails"),
                |_| (),
            )
        }));
        assert!(ended.is_err());
    }

    #[test]
    fn rounds_fill_the_time_wanted() {
        let spin = |rounds: usize| {
            for i in 0..rounds {
                std::hint::black_box(i);
            }
        };
        let wanted = Duration::from_millis(2);
        assert!(rounds_for(wanted, spin) > 1000);
        assert_eq!(rounds_for(Duration::ZERO, |_| ()), 1);
    }
}
