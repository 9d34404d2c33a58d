//! Figure 5c: many trajectories with one shared table, over the number of threads.

use super::rattle::{CELLS, LIMIT, sixty_levels};
use super::scenes::{drive, model_of, settled, volterra};
use gearatlas_core::model::{Model, TrajectoryState};
use gearatlas_core::propagate::{Counters, Kernel};
use gearatlas_paper::kernels::{Fused, Spectral};
use serde_json::{Map, Value, json};
use std::sync::Barrier;
use std::time::{Duration, Instant};

/// Duration for which every thread advances its trajectory.
const RUN_DURATION: Duration = Duration::from_millis(400);

/// Repetitions; the fastest counts, because disturbances only slow down.
const ROUNDS: usize = 3;

/// Cycles per second of all threads together.
fn rate<K: Kernel + Sync>(kernel: &K, start: &TrajectoryState, threads: usize) -> f64 {
    let barrier = Barrier::new(threads);
    let work = || {
        let (mut trajectory, mut workspace) = (start.clone(), kernel.workspace());
        let mut counters = Counters::default();
        barrier.wait();
        let clock = Instant::now();
        while clock.elapsed() < RUN_DURATION {
            kernel
                .advance(16, &mut trajectory, &mut workspace, &mut (), &mut counters)
                .expect("the default drive does not diverge");
        }
        counters.cycles as f64 / clock.elapsed().as_secs_f64()
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let rates = workers.into_iter().map(|w| w.join().expect("a worker"));
        rates.sum()
    })
}

/// Cycles per second of every kernel over the number of threads.
pub fn scaling() -> Value {
    let model: Model = model_of(&sixty_levels(drive(40, 0.05, 1200.0)));
    let start = settled(&model);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut counts: Vec<usize> = (0..).map(|e| 1 << e).take_while(|n| *n < cores).collect();
    counts.push(cores);
    let spectral = Spectral::new(&model, CELLS, LIMIT, None).expect("tables");
    let fused = Fused::new(&model, CELLS, LIMIT).expect("tables");
    let structured = volterra(&model);
    let mut found = Map::new();
    for &threads in &counts {
        let mut best = [0.0f64; 3];
        for _ in 0..ROUNDS {
            let rates = [
                rate(&spectral, &start, threads),
                rate(&fused, &start, threads),
                rate(&structured, &start, threads),
            ];
            for (best, rate) in best.iter_mut().zip(rates) {
                *best = best.max(rate);
            }
        }
        let [spectral, fused, volterra] = best;
        found.insert(
            threads.to_string(),
            json!({ "spectral": spectral, "fused": fused, "volterra": volterra }),
        );
    }
    Value::Object(found)
}
