//! Points that follow from each other: each starts where the one before it ended, and a
//! change of motion between neighbours is narrowed down by points between them.
//!
//! A change is sought by halving the interval between the last point that has a verdict and
//! the present one. Every trial starts from the state that the near side left, as the sweep
//! itself would have with a finer grid; one that moves as the near side becomes the near
//! side. A trial without a verdict (at a bifurcation motions settle ever more slowly) ends the
//! search with the bracket reached.

use super::build::Parts;
use super::point::{Answer, Worker, attempt, row};
use crate::analysis::{CalledOff, Class, PointOutcome, Status};
use crate::manifest::{Direction, Job, LyapunovSpec, PointSpec, RunSpec};
use crate::model::{Model, TrajectoryState};
use crate::store::{ChainEnd, ChainPart, PointRow, Transition};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// What the next point of a chain has to know of those before it.
#[derive(Debug, Clone, Default)]
pub struct Link {
    /// Points passed.
    passed: usize,
    /// The state that the last one left.
    end: Option<ChainEnd>,
    /// How the work on the last one ended, where it left no state.
    trouble: Option<Status>,
    /// The last point with a verdict.
    near: Option<Near>,
}

/// One side of a change of motion.
#[derive(Debug, Clone)]
struct Near {
    /// Value on the swept axis.
    value: f64,
    class: Class,
    end: ChainEnd,
}

impl Link {
    /// Points of the chain passed so far.
    pub fn passed(&self) -> usize {
        self.passed
    }

    /// Where the next point starts; none for `run.initial`.
    pub fn start(&self, model: &Model) -> Option<TrajectoryState> {
        let end = self.end.as_ref()?;
        Some(TrajectoryState::new(model, end.state.clone(), end.cycle))
    }

    /// Goes past a finished point, computed now or taken over from a journal.
    pub fn pass(&mut self, job: &Job, row: &PointRow) {
        self.passed += 1;
        self.end = row.chain.as_ref().and_then(|chain| chain.end.clone());
        self.trouble = self.end.is_none().then(|| row.outcome.status.clone());
        if let (Some(carried), Some(class), Some(end)) =
            (&job.carried, verdict(&row.outcome), &self.end)
        {
            self.near = Some(Near {
                value: row.axis_values[carried.axis],
                class,
                end: end.clone(),
            });
        }
    }
}

/// What a sweep would know when it reached `point`: all points of its chain before it are
/// computed. The point need not be on the grid: it stands where its value on the swept axis
/// belongs.
///
/// # Errors
/// [`CalledOff`] when `called_off` was raised meanwhile.
pub fn lead_up(
    job: &Job,
    point: &PointSpec,
    parts: &Parts,
    called_off: &AtomicBool,
) -> Result<Link, CalledOff> {
    let mut link = Link::default();
    let (Some(carried), Some(direction)) = (&job.carried, point.direction) else {
        return Ok(link);
    };
    let first = point.point_id as usize / carried.length * carried.length;
    let value = point.axis_values[carried.axis];
    let swept = job.axes[carried.axis].name.as_str();
    for mut before in (first..first + carried.length).map(|id| job.points.at(id)) {
        let reached = before.axis_values[carried.axis];
        if match direction {
            Direction::Up => reached >= value,
            Direction::Down => reached <= value,
        } {
            break;
        }
        if swept != "load" {
            before.load = point.load;
        }
        if swept != "speed" {
            before.speed = point.speed;
        }
        if let Some(poincare) = &mut Arc::make_mut(&mut before.analyses).poincare {
            poincare.refine = 0;
        }
        let worker = Worker {
            index: 0,
            topology: None,
        };
        let row = compute(job, &before, &link, parts, worker, called_off)?;
        link.pass(job, &row);
    }
    Ok(link)
}

/// The kind of motion, where there is a verdict.
pub(super) fn verdict(outcome: &PointOutcome) -> Option<Class> {
    outcome.class.filter(|class| *class != Class::NotConverged)
}

/// Computes a point that comes behind `link`.
///
/// # Errors
/// [`CalledOff`] when `called_off` was raised meanwhile.
pub fn compute(
    job: &Job,
    point: &PointSpec,
    link: &Link,
    parts: &Parts,
    worker: Worker<'_>,
    called_off: &AtomicBool,
) -> Result<PointRow, CalledOff> {
    let clock = Instant::now();
    let mut answer = attempt(point, link.end.as_ref(), job.seed, parts, called_off)?;
    let mut chain = None;
    if let Some(direction) = point.direction {
        if let Some(trouble) = &link.trouble {
            let how = match trouble {
                Status::Diverged => "diverged",
                Status::EventStorm => "ended in an event storm",
                Status::Inaccurate => "was not followed accurately",
                Status::Ok | Status::NotConverged | Status::Failed => "failed",
            };
            let note = format!("; started from run.initial, because the point before it {how}");
            answer.outcome.reason.push_str(&note);
        }
        let search = Search {
            job,
            point,
            parts,
            called_off,
        };
        chain = Some(Box::new(ChainPart {
            upwards: direction == Direction::Up,
            transition: search.narrow(link, &mut answer)?,
            end: answer.end.take(),
        }));
    }
    Ok(PointRow {
        chain,
        ..row(point, answer, worker, clock)
    })
}

/// The search for a change of motion just before a point.
struct Search<'a> {
    job: &'a Job,
    point: &'a PointSpec,
    parts: &'a Parts,
    called_off: &'a AtomicBool,
}

impl Search<'_> {
    /// The change, if there is one and it is to be refined. The work is added to the
    /// point's.
    fn narrow(&self, link: &Link, answer: &mut Answer) -> Result<Option<Transition>, CalledOff> {
        let halvings = self.point.analyses.poincare.map_or(0, |asked| asked.refine);
        let (Some(near), Some(to)) = (&link.near, verdict(&answer.outcome)) else {
            return Ok(None);
        };
        let Some(carried) = self.job.carried.as_ref() else {
            return Ok(None);
        };
        if halvings == 0 || near.class == to {
            return Ok(None);
        }
        let mut near = near.clone();
        let mut found = Transition {
            from: near.class,
            to,
            bracket: [near.value, self.point.axis_values[carried.axis]],
            trials: 0,
        };
        let asked = self.trial();
        for _ in 0..halvings {
            let value = 0.5 * (near.value + found.bracket[1]);
            let Some(between) = self.job.point_between(&asked, value) else {
                break;
            };
            let tried = attempt(
                &between,
                Some(&near.end),
                self.job.seed,
                self.parts,
                self.called_off,
            )?;
            found.trials += 1;
            answer.outcome.cycles += tried.outcome.cycles;
            match (verdict(&tried.outcome), tried.end) {
                (Some(class), Some(end)) if class == found.from => {
                    near = Near { value, class, end };
                    found.bracket[0] = value;
                }
                (Some(class), Some(_)) => {
                    found.to = class;
                    found.bracket[1] = value;
                }
                _ => break,
            }
        }
        Ok(Some(found))
    }

    /// The point with no more asked of it than its verdict takes.
    fn trial(&self) -> PointSpec {
        let mut trial = self.point.clone();
        let analyses = Arc::make_mut(&mut trial.analyses);
        analyses.lyapunov = analyses.lyapunov.map(|asked| LyapunovSpec {
            twin: false,
            ..asked
        });
        analyses.poincare = None;
        analyses.nvh = None;
        analyses.multistability = None;
        trial.run = Arc::new(RunSpec {
            audit_cycles: 0,
            ..(*trial.run).clone()
        });
        trial
    }
}
