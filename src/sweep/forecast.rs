//! What a run will take: its time with an interval, its memory and its disk space, from a few
//! points computed beforehand.
//!
//! Points are drawn over the grid by the golden ratio, which meets no period of the grid. The
//! time a point takes, over the work that the manifest asks of it, is averaged; the interval
//! is Student's at 95 % for a sample from so many points, so few calibration points or very
//! different ones make it wide. Of a chain, points are computed as if each were its first.

use super::build::{Parts, tables_wanted};
use super::chain::{Link, compute};
use super::layout::layout;
use super::point::Worker;
use super::queue::{look, work};
use super::run::{Options, SweepError, start_workers};
use super::turns::shard_points;
use crate::manifest::Job;
use crate::numerics::statistics::mean;
use crate::store::{PointRow, ResultWriter, StoreError, journal_bytes};
use crate::topology::{Topology, peak_memory};
use serde::Serialize;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Most calibration points a worker.
const POINTS_A_WORKER: usize = 8;

/// Rows of a row group, the most of one table that is in memory at once.
const GROUP_ROWS: u64 = 16_384;

/// Time between two looks at the clock.
const LOOK_UP: Duration = Duration::from_millis(20);

/// A number with the interval that it lies in at 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// The number.
    pub expected: f64,
    /// Upper end.
    pub high: f64,
}

/// What a run will take.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Forecast {
    /// Points of the grid (of the shard).
    pub points: u64,
    /// Points of a chain; 1 where points are independent.
    pub chain_length: u64,
    /// Mesh tables needed, computed already or not.
    pub tables: u64,
    /// Worker threads.
    pub threads: u64,
    /// Where they are to run, in words.
    pub placement: String,
    /// Points computed to know.
    pub calibrated: u64,
    /// Of these, given up because they took too long: the times are then at least what is
    /// said.
    pub cut_short: u64,
    /// Wall time of the calibration, tables included \[s\].
    pub calibration_time: f64,
    /// Wall time of the run \[s\].
    pub time: Interval,
    /// Memory \[bytes\]; absent where the system does not tell what the calibration took.
    pub memory: Option<u64>,
    /// Result files \[bytes\].
    pub disk: u64,
    /// The journal, which is there while the run lasts \[bytes\].
    pub journal: u64,
}

/// Computes a few points for at most about `budget` (tables that they need come on top), and
/// says what the run will take; nothing where `called_off` was raised meanwhile. Result files
/// are tried out in `scratch`, an empty folder.
///
/// # Errors
/// Threads cannot be started, or `scratch` cannot be written.
pub fn forecast(
    job: &Job,
    options: Options<'_>,
    parts: &Parts,
    topology: Option<&Topology>,
    budget: Duration,
    called_off: &AtomicBool,
    scratch: &Path,
) -> Result<Option<Forecast>, SweepError> {
    let length = job.chain_length();
    let all = shard_points(job.points.len(), length, options.shard);
    let chains = all.len() / length;
    let crew = start_workers(job, all.iter().step_by(length).copied(), options, topology)?;
    let threads = crew.threads;
    let sample = drawn(
        all.len(),
        (all.len() / 4).clamp(2, POINTS_A_WORKER * threads.max(2)),
    );
    let points: Vec<_> = sample.iter().map(|&at| &job.points[all[at]]).collect();

    let clock = Instant::now();
    crew.pool
        .install(|| parts.prepare(points.iter().copied(), &mut || ()));
    let prepared = clock.elapsed().as_secs_f64();
    let over = AtomicBool::new(false);
    let next = AtomicUsize::new(0);
    let tried: Mutex<Vec<(f64, Option<PointRow>)>> = Mutex::default();
    let (done, waiting) = channel::<()>();
    std::thread::scope(|scope| {
        let over = &over;
        scope.spawn(move || {
            let started = Instant::now();
            while waiting.recv_timeout(LOOK_UP) == Err(RecvTimeoutError::Timeout) {
                if started.elapsed() >= budget || called_off.load(Ordering::Relaxed) {
                    over.store(true, Ordering::Relaxed);
                }
            }
        });
        crew.pool.broadcast(|context| {
            let worker = Worker {
                index: context.index() as u32,
                topology,
            };
            while let Some(point) = points.get(next.fetch_add(1, Ordering::Relaxed)) {
                if over.load(Ordering::Relaxed) {
                    return;
                }
                let clock = Instant::now();
                let row = compute(job, point, &Link::default(), parts, worker, over);
                let ratio = clock.elapsed().as_secs_f64() / work(point);
                let mut tried = tried.lock().unwrap_or_else(PoisonError::into_inner);
                tried.push((ratio, row.ok()));
            }
        });
        drop(done);
    });
    if called_off.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let calibration_time = clock.elapsed().as_secs_f64();
    let tried = tried.into_inner().unwrap_or_else(PoisonError::into_inner);
    let ratios: Vec<f64> = tried.iter().map(|(ratio, _)| *ratio).collect();
    let mut rows: Vec<PointRow> = tried.into_iter().filter_map(|(_, row)| row).collect();
    rows.sort_by_key(|row| row.point_id);

    let total_work: f64 = all.iter().map(|&i| work(&job.points[i])).sum();
    let longest = ratios.iter().fold(0.0f64, |most, ratio| most.max(*ratio)) * total_work
        / chains.max(1) as f64;
    let tables = tables_wanted(all.iter().map(|&i| &job.points[i]));
    let known = tables_wanted(points.iter().copied()).max(1);
    let time = wall_time(
        total(&ratios, all.len(), total_work),
        threads as f64,
        longest,
        prepared * (tables as f64 / known as f64),
    );
    let row_bytes = mean_or_zero(&rows, |row| journal_bytes(row) as f64);
    let held = (all.len() as u64).min(GROUP_ROWS + (look(threads) * length) as u64);
    let cut_short = (ratios.len() - rows.len()) as u64;
    // Before the memory is looked at, which encoding takes up too.
    let disk = disk(job, all.len(), rows, scratch)?;
    Ok(Some(Forecast {
        points: all.len() as u64,
        chain_length: length as u64,
        tables: tables as u64,
        threads: threads as u64,
        placement: crew.seats.to_string(),
        calibrated: ratios.len() as u64,
        cut_short,
        calibration_time,
        time,
        memory: peak_memory().map(|peak| peak + held * row_bytes as u64),
        disk,
        journal: (row_bytes * all.len() as f64) as u64,
    }))
}

/// `count` different places among `of`, in an order in which any beginning is spread evenly.
fn drawn(of: usize, count: usize) -> Vec<usize> {
    // Two points may fall on one place; then the next free one is taken.
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut free = vec![true; of];
    let mut places = Vec::new();
    for k in 0..count.min(of) {
        let start = ((k as f64 + 0.5) * golden).fract() * of as f64;
        let place = (0..of)
            .map(|step| (start as usize + step) % of)
            .find(|&place| free[place]);
        places.extend(place.inspect(|&place| free[place] = false));
    }
    places
}

/// Computing time over all points \[s\], from the time per work of some.
fn total(ratios: &[f64], points: usize, work: f64) -> Interval {
    let n = ratios.len() as f64;
    if ratios.is_empty() {
        return Interval {
            low: 0.0,
            expected: 0.0,
            high: 0.0,
        };
    }
    let middle = mean(ratios);
    let spread = ratios.iter().map(|r| (r - middle).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    // Of points drawn without putting them back, the last ones leave nothing open.
    let left = (1.0 - n / points as f64).max(0.0);
    let half = student(ratios.len() - 1) * (spread / n * left).sqrt();
    // What was computed takes its time again.
    let least = ratios.iter().sum::<f64>() / points as f64;
    Interval {
        low: work * (middle - half).max(least),
        expected: work * middle,
        high: work * (middle + half),
    }
}

/// Wall time of so much computing on so many threads: at best evenly shared, at worst with
/// the longest chain begun last.
fn wall_time(computing: Interval, threads: f64, longest: f64, tables: f64) -> Interval {
    let tail = longest * (1.0 - 1.0 / threads);
    Interval {
        low: tables + computing.low / threads,
        expected: tables + computing.expected / threads + 0.5 * tail,
        high: tables + computing.high / threads + tail,
    }
}

/// Student's two-sided 95 % quantile; its expansion in 1/ν beyond a table.
fn student(degrees: usize) -> f64 {
    const FEW: [f64; 10] = [
        12.71, 12.71, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262,
    ];
    let more = 1.96 + 2.37 / degrees.max(1) as f64 + 2.8 / (degrees.max(1) as f64).powi(2);
    FEW.get(degrees).copied().unwrap_or(more)
}

fn mean_or_zero(rows: &[PointRow], value: impl Fn(&PointRow) -> f64) -> f64 {
    match rows.is_empty() {
        true => 0.0,
        false => mean(&rows.iter().map(value).collect::<Vec<f64>>()),
    }
}

/// Size of the result files of so many points like these \[bytes\].
fn disk(job: &Job, points: usize, rows: Vec<PointRow>, scratch: &Path) -> Result<u64, StoreError> {
    let count = rows.len().max(1) as u64;
    let mut sizes = [0, 0];
    for (size, rows) in sizes.iter_mut().zip([Vec::new(), rows]) {
        let ids: Vec<u64> = rows.iter().map(|row| row.point_id).collect();
        let mut writer = ResultWriter::create(scratch, &layout(job, None), ids)?;
        for row in rows {
            writer.push(row)?;
        }
        writer.finish()?;
        let refused = |error| StoreError::io(scratch, "read", error);
        for entry in std::fs::read_dir(scratch).map_err(refused)? {
            *size += entry
                .and_then(|entry| entry.metadata())
                .map_err(refused)?
                .len();
        }
    }
    let [empty, some] = sizes;
    Ok(empty + some.saturating_sub(empty) * points as u64 / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_beginning_of_a_draw_is_spread_evenly() {
        for of in [1, 2, 7, 80, 1000] {
            let mut all = drawn(of, of);
            all.sort_unstable();
            assert_eq!(all, (0..of).collect::<Vec<_>>(), "each once");
        }
        // Of 8 rows of 10, no column and no row is left out by much.
        let places = drawn(80, 20);
        for (group, groups) in [(10, 8), (1, 10)] {
            let mut met = vec![0; groups];
            places
                .iter()
                .for_each(|place| met[place / group % groups] += 1);
            assert!(met.iter().all(|n| (1..=4).contains(n)), "{met:?}");
        }
    }

    #[test]
    fn a_whole_sample_leaves_nothing_open() {
        let found = total(&[1.0, 3.0], 2, 4.0);
        assert_eq!([found.low, found.expected, found.high], [8.0; 3]);
        let found = wall_time(found, 2.0, 1.0, 0.5);
        assert_eq!([found.low, found.expected, found.high], [4.5, 4.75, 5.0]);
    }

    /// The 95 % interval holds the sum in about 95 % of draws from a known set.
    #[test]
    fn the_interval_covers() {
        let costs: Vec<f64> = (0..400u32)
            .map(|i| 1.0 + f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65_536.0)
            .collect();
        let truth: f64 = costs.iter().sum();
        let mut covered = 0;
        for first in 0..200 {
            // Strides prime to 400: a sample without repetition.
            let sample: Vec<f64> = (0..12).map(|k| costs[(first * 7 + k * 33) % 400]).collect();
            let found = total(&sample, 400, 400.0);
            covered += usize::from(found.low <= truth && truth <= found.high);
        }
        assert!((180..=200).contains(&covered), "{covered} of 200");
    }

    #[test]
    fn students_quantile_joins_its_table() {
        assert!((student(9) - 2.262).abs() < 1e-9);
        for (degrees, wanted) in [(10, 2.228), (15, 2.131), (30, 2.042), (120, 1.980)] {
            assert!((student(degrees) - wanted).abs() < 5e-3, "{degrees}");
        }
    }
}
