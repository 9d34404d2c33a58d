//! Do workers, the writer and a signal compute every chain once and always end, in any order?
//!
//! The queue and the worker's loop are those of a run. The test adds the surroundings of a run: a short
//! channel, a writer that releases points in order, and a flag that interrupts the run. The library shuttle
//! runs all threads, one at a time. It draws the next one at every send, receive, wait or query of the
//! writer's progress. The queue holds no lock at these places, so the standard library's lock excludes no
//! order.

use super::tests::job;
use super::*;
use shuttle::sync::mpsc::{Receiver, SyncSender, sync_channel};
use shuttle::thread;
use std::collections::BTreeSet;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, LazyLock};

static JOB: LazyLock<Job> = LazyLock::new(|| job(3, 4));

const POINTS: usize = 12;
const WORKERS: usize = 3;
const CHANNEL: usize = 2;
const AHEAD: u64 = 4;
const MOST_CANDIDATES: usize = 6;

/// Number of orders that are tried.
const ORDERS: usize = 2000;

/// Reason for the end of a run.
#[derive(Clone, Copy, PartialEq)]
enum End {
    /// Nothing is left.
    Done,
    /// The flag is raised at a random moment.
    Interrupted,
    /// The writer gives up after this number of rows, as on a full disk.
    WriterGone(usize),
}

fn work(queue: &Queue<'_>, written: &AtomicU64, interrupt: &AtomicBool, rows: &SyncSender<usize>) {
    let written = || {
        let found = written.load(Ordering::Relaxed);
        // The writer may progress before the queue reads the number.
        thread::yield_now();
        found
    };
    queue.serve(written, thread::yield_now, None, interrupt, |turn, _| {
        thread::yield_now();
        rows.send(turn.place).ok()?;
        (!interrupt.load(Ordering::Relaxed)).then_some(())
    });
}

/// Collects the rows in order of arrival; points leave memory in order of their numbers.
fn write(rows: &Receiver<usize>, written: &AtomicU64, end: End) -> Vec<usize> {
    let (mut seen, mut waiting, mut next) = (Vec::new(), BTreeSet::new(), 0);
    while let Ok(place) = rows.recv() {
        assert!(!seen.contains(&place), "{place} twice");
        seen.push(place);
        waiting.insert(place);
        while waiting.remove(&next) {
            next += 1;
        }
        assert!(waiting.len() as u64 <= AHEAD, "{waiting:?} wait for {next}");
        written.store(next as u64, Ordering::Relaxed);
        if end == End::WriterGone(seen.len()) {
            break;
        }
    }
    seen
}

fn in_many_orders(end: End) {
    // Shuttle's threads have too little stack to read a manifest.
    LazyLock::force(&JOB);
    let run = move || {
        let selection = ChainSelection::of_shard(&JOB, None);
        let mut queue = Queue::new(&JOB, selection, FinishedChains::default(), 1, WORKERS, 0);
        (queue.most_candidates, queue.ahead) = (MOST_CANDIDATES, AHEAD);
        let queue = Arc::new(queue);
        let written = Arc::new(AtomicU64::new(0));
        let interrupt = Arc::new(AtomicBool::new(false));
        let (sender, receiver) = sync_channel(CHANNEL);
        let writer = {
            let (written, interrupt) = (written.clone(), interrupt.clone());
            thread::spawn(move || {
                let seen = write(&receiver, &written, end);
                drop(receiver);
                if matches!(end, End::WriterGone(_)) {
                    interrupt.store(true, Ordering::Relaxed);
                }
                seen
            })
        };
        let workers: Vec<_> = (0..WORKERS)
            .map(|_| {
                let (queue, written) = (queue.clone(), written.clone());
                let (interrupt, sender) = (interrupt.clone(), sender.clone());
                thread::spawn(move || work(&queue, &written, &interrupt, &sender))
            })
            .collect();
        drop(sender);
        if end == End::Interrupted {
            thread::yield_now();
            interrupt.store(true, Ordering::Relaxed);
        }
        for worker in workers {
            worker.join().unwrap();
        }
        let mut seen = writer.join().unwrap();
        seen.sort_unstable();
        match end {
            End::Done => assert_eq!(seen, (0..POINTS).collect::<Vec<_>>()),
            End::Interrupted => assert!(seen.len() <= POINTS),
            End::WriterGone(after) => assert_eq!(seen.len(), after),
        }
    };
    shuttle::check_random(run, ORDERS);
    // Few changes of thread at random moments: orders that uniform draws rarely produce.
    shuttle::check_pct(run, ORDERS, 3);
}

#[test]
fn every_chain_is_computed_once_in_whatever_order() {
    in_many_orders(End::Done);
}

#[test]
fn a_run_that_is_called_off_ends_in_whatever_order() {
    in_many_orders(End::Interrupted);
}

#[test]
fn a_run_whose_writer_gives_up_ends_in_whatever_order() {
    in_many_orders(End::WriterGone(5));
}
