//! What a run forecasts of itself from its own first points, to be held against what it took.
//!
//! Independent points are drawn over the grid and computed before the others, which costs
//! nothing: they are points of the run. Where the state is carried, the first tenth of the points
//! has to do: the beginnings of chains, which are forecast as if all of each went on like that.

use super::estimate::{Interval, Load, Sampled, drawn};
use super::queue::work;
use super::turns::{Share, TakenOver};
use crate::manifest::Job;
use crate::store::PointRow;
use std::collections::BTreeSet;
use std::time::Duration;

/// Most points of a sample, a worker.
const POINTS_A_WORKER: usize = 8;

/// Fewer points than these forecast nothing: they are the run.
const FEWEST: usize = 8;

/// What a run forecast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EarlyForecast {
    /// Points that it was forecast from.
    pub points: u64,
    /// When, since the run was begun \[s\].
    pub after: f64,
    /// Wall time of the run \[s\].
    pub wall_time: Interval,
}

/// Points of a sample of so many, on so many threads.
pub(super) fn sample(points: usize, threads: usize) -> usize {
    (points / 4).clamp(2, POINTS_A_WORKER * threads.max(2))
}

/// Watches the first points of a run.
pub(super) struct EarlySample<'a> {
    job: &'a Job,
    load: Load,
    /// Points whose times are wanted; any where the state is carried.
    wanted: Option<BTreeSet<u64>>,
    /// How many.
    needed: usize,
    /// What they took.
    sampled: Vec<Sampled>,
    /// Time before the first point was begun \[s\].
    prepared: f64,
    forecast: Option<EarlyForecast>,
}

impl<'a> EarlySample<'a> {
    /// Of what an earlier run has left of a share.
    pub fn new(job: &'a Job, share: &Share, taken_over: &TakenOver, threads: usize) -> Self {
        let length = job.chain_length();
        let (mut points, mut chains, mut total) = (0, 0, 0.0);
        for place in (0..share.chains()).filter(|&place| !taken_over.has(share, place)) {
            let end = (place + 1) * length;
            let left = taken_over.left(share, place);
            points += left;
            chains += usize::from(left > 0);
            total += (end - left..end)
                .map(|n| work(job.points.variant_near(share.id(n))))
                .sum::<f64>();
        }
        let load = Load {
            points,
            chains,
            length,
            work: total,
            threads,
            shared: shared(job),
        };
        Self {
            job,
            load,
            wanted: None,
            needed: match points < FEWEST {
                true => 0,
                false if length > 1 => sample(points, threads).max(points / 10),
                false => sample(points, threads),
            },
            sampled: Vec::new(),
            prepared: 0.0,
            forecast: None,
        }
    }

    /// Places of the points that are to come first, where points are independent.
    pub fn draw(&mut self, share: &Share, taken_over: &TakenOver) -> Vec<usize> {
        if self.load.length > 1 {
            return Vec::new();
        }
        let numbers = drawn(self.load.points, self.needed);
        let mut places = vec![0; numbers.len()];
        let left = (0..share.chains()).filter(|&place| !taken_over.has(share, place));
        for (number, place) in left.enumerate() {
            if let Some(at) = numbers.iter().position(|wanted| *wanted == number) {
                places[at] = place;
            }
        }
        let ids = places.iter().map(|&place| share.id(place) as u64);
        self.wanted = Some(ids.collect());
        places
    }

    /// Points are begun, so long after the run was.
    pub fn begin(&mut self, prepared: Duration) {
        self.prepared = prepared.as_secs_f64();
    }

    /// Learns from a finished point, so long after the first was begun.
    pub fn count(&mut self, row: &PointRow, elapsed: Duration) {
        let wanted = match &mut self.wanted {
            Some(wanted) => wanted.remove(&row.point_id),
            None => true,
        };
        if !wanted || self.sampled.len() >= self.needed {
            return;
        }
        self.sampled.push(Sampled {
            time: row.placement.wall_time,
            spread: 0.0,
            work: work(self.job.points.variant_near(row.point_id as usize)),
        });
        if self.sampled.len() == self.needed {
            let wall_time = self.load.wall_time(&self.sampled);
            self.forecast = Some(EarlyForecast {
                points: self.needed as u64,
                after: self.prepared + elapsed.as_secs_f64(),
                wall_time: wall_time.after(self.prepared),
            });
        }
    }

    /// What was forecast; none before enough points are finished.
    pub fn forecast(&self) -> Option<EarlyForecast> {
        self.forecast
    }
}

/// Whether threads share points.
pub(super) fn shared(job: &Job) -> bool {
    let mut variants = job.points.variants().iter();
    variants.any(|variant| variant.analyses.multistability.is_some())
}
