//! Points of a chain: each starts next to the end of the previous one (see [`CarriedState`]), and points between
//! neighbours narrow down changes of motion.
//!
//! A change is found by halving the interval from the last point with a verdict (near side) to the present one (far
//! side). A point has a verdict if the class of its motion is known. Every trial starts from the state of the near
//! side, as the sweep would with a finer grid. A trial with the motion of the near side becomes the near side,
//! otherwise the far side. A trial without a verdict ends the search with the present bracket: close to a bifurcation,
//! motions settle slowly. Neighbours of one class and period may still lie on different branches. The interval is also
//! halved if the deflection changes much more between them than between the points before. Halving the interval does
//! not change the size of a jump, but it halves a continuous change.
//!
//! Without halving, a change of class is reported between neighbours of the grid. A change of the deflection
//! is reported only if the previous change is known.

use super::carried::CarriedState;
use super::parts::Prepared;
use super::point::{PointResult, Worker, compute_point, row};
use crate::analysis::{
    Analyses, Class, Interrupted, LyapunovConfig, NvhConfig, NvhStatistics, PointOutcome, Signals,
    Status,
};
use crate::manifest::{AxisKey, Direction, Job, PointSpec};
use crate::model::{Model, TrajectoryState};
use crate::propagate::Seat;
use crate::store::{ChainEnd, ChainPart, Level, PointRow, Transition};
use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Change of the deflection's mean or RMS, relative to the RMS, above which a jump is searched for.
const NOTABLE_CHANGE: f64 = 0.1;

/// Ratio of a change to the previous change, above which a jump is searched for.
const STANDS_OUT: f64 = 4.0;

/// Smallest fraction of the first change that must remain across the bracket of a jump.
const REMAINING_CHANGE: f64 = 0.5;

/// Smallest number of halvings that distinguishes a jump from a continuous change.
const FEWEST_HALVINGS: u32 = 3;

/// Two levels count as equal up to this number of standard errors of their difference.
const SIGMAS: f64 = 5.0;

/// Smallest RMS by which a change is divided \[half gaps\].
const SMALLEST_RMS: f64 = 1e-3;

/// Data of earlier points that the next point of a chain needs.
#[derive(Debug, Clone, Default)]
pub struct ChainState {
    /// Number of points so far.
    passed: usize,
    /// State at the end of the last point.
    end: Option<ChainEnd>,
    /// Status of the last point if it has no state at its end.
    trouble: Option<Status>,
    /// The last point whose class of motion is known.
    near: Option<LastVerdict>,
}

/// The last point with a verdict: one side of a change of motion.
#[derive(Debug, Clone)]
struct LastVerdict {
    /// Value on the swept axis.
    value: f64,
    class: Class,
    end: ChainEnd,
    level: Option<Level>,
    /// Change of the level since the previous point with a verdict.
    step: Option<f64>,
    /// Whether the previous point with a verdict had the same class.
    alike: bool,
}

impl ChainState {
    /// Number of points so far.
    pub fn passed(&self) -> usize {
        self.passed
    }

    /// Start of the next point, `point`; `None` for `run.initial`.
    pub fn start(&self, job: &Job, point: &PointSpec, model: &Model) -> Option<TrajectoryState> {
        let seed = point.random();
        Some(carried_from(job, self.end.as_ref())?.start(model, seed))
    }

    /// Adds a finished point, whether computed now or read from a journal.
    pub fn pass(&mut self, job: &Job, row: &PointRow) {
        self.passed += 1;
        self.end = row.chain.as_ref().and_then(|chain| chain.end.clone());
        self.trouble = self.end.is_none().then(|| row.outcome.status.clone());
        if let (Some(carried), Some(class), Some(end)) =
            (&job.carried, verdict(&row.outcome), &self.end)
        {
            let level = row.chain.as_ref().and_then(|chain| chain.level);
            let before = self.near.as_ref();
            let half_gap = job.points.at(row.point_id as usize).mesh.scale();
            self.near = Some(LastVerdict {
                value: row.axis_values[carried.axis],
                class,
                end: end.clone(),
                level,
                step: before.and_then(|near| Some(level_change([near.level?, level?], half_gap))),
                alike: before.is_some_and(|near| near.class == class),
            });
        }
    }
}

/// The start of a point from the end of the previous one.
fn carried_from<'a>(job: &Job, end: Option<&'a ChainEnd>) -> Option<CarriedState<'a>> {
    Some(CarriedState {
        end: end?,
        displacement: job.carried.as_ref()?.displacement,
    })
}

/// The state of a sweep when it reaches `point`: computes all points of its chain before it. The point may lie between
/// points of the grid, at its value on the swept axis.
///
/// # Errors
/// [`Interrupted`] when `interrupt` was raised meanwhile.
pub fn chain_state_before(
    job: &Job,
    point: &PointSpec,
    parts: &Prepared,
    interrupt: &AtomicBool,
) -> Result<ChainState, Interrupted> {
    let mut link = ChainState::default();
    let (Some(carried), Some(direction)) = (&job.carried, point.direction) else {
        return Ok(link);
    };
    let first = point.point_id as usize / carried.length * carried.length;
    let value = point.axis_values[carried.axis];
    let swept = job.tied(carried.axis);
    let sweeps = |key: AxisKey| swept.iter().any(|&axis| job.axes[axis].key == key);
    let sweeps_load = sweeps(AxisKey::Load) || sweeps(AxisKey::Torque);
    for mut before in (first..first + carried.length).map(|id| job.points.at(id)) {
        let reached = before.axis_values[carried.axis];
        if match direction {
            Direction::Up => reached >= value,
            Direction::Down => reached <= value,
        } {
            break;
        }
        if !sweeps_load {
            before.load = point.load;
        }
        if !sweeps(AxisKey::Speed) {
            before.speed = point.speed;
        }
        if let Some(poincare) = &mut Arc::make_mut(&mut before.analyses).poincare {
            poincare.refine = 0;
        }
        let worker = Worker {
            index: 0,
            topology: None,
            seat: None,
        };
        let row = compute(job, &before, &link, parts, worker, interrupt)?;
        link.pass(job, &row);
    }
    Ok(link)
}

/// The class of motion, if it is known. Transient chaos counts as chaos, because chance decides which
/// trajectories leave chaos.
pub(super) fn verdict(outcome: &PointOutcome) -> Option<Class> {
    match outcome.class? {
        Class::NotConverged => None,
        Class::TransientChaos => Some(Class::Chaotic),
        class => Some(class),
    }
}

/// Mean and RMS of a point's deflection, if requested.
fn level(outcome: &PointOutcome) -> Option<Level> {
    let nvh = outcome.nvh.as_ref()?;
    let with_error =
        |of: fn(&NvhStatistics) -> f64| [of(&nvh.values), nvh.stderr.as_ref().map_or(0.0, of)];
    Some(Level {
        mean: with_error(|of| of.deflection_mean),
        rms: with_error(|of| of.deflection_rms),
    })
}

/// Difference of two levels in excess of their errors, divided by the larger RMS.
fn level_change([a, b]: [Level; 2], half_gap: f64) -> f64 {
    let scale = a.rms[0].max(b.rms[0]).max(SMALLEST_RMS * half_gap);
    let beyond = |a: [f64; 2], b: [f64; 2]| {
        let errors = a[1].hypot(b[1]);
        // Unknown errors are infinite: no difference exceeds them.
        ((a[0] - b[0]).abs() - SIGMAS * errors).max(0.0)
    };
    beyond(a.mean, b.mean).max(beyond(a.rms, b.rms)) / scale
}

/// The point, with a request for the level of its deflection if it belongs to a chain whose changes are
/// refined.
pub(super) fn with_level_if_refined(point: &PointSpec) -> Cow<'_, PointSpec> {
    if point.direction.is_some() && halvings(&point.analyses) > 0 {
        Cow::Owned(with_level(point))
    } else {
        Cow::Borrowed(point)
    }
}

/// The point with a request for the level of its deflection.
fn with_level(point: &PointSpec) -> PointSpec {
    let mut levelled = point.clone();
    let analyses = Arc::make_mut(&mut levelled.analyses);
    analyses.nvh.get_or_insert(NvhConfig {
        harmonics: 0,
        outputs: Signals::NONE,
        power: false,
        spectrum: None,
        orders: None,
        stop_at_stderr: None,
    });
    levelled
}

/// Computes the row of a point; `link` is the state of its chain before it.
///
/// # Errors
/// [`Interrupted`] when `interrupt` was raised meanwhile.
pub fn compute(
    job: &Job,
    point: &PointSpec,
    link: &ChainState,
    parts: &Prepared,
    worker: Worker<'_>,
    interrupt: &AtomicBool,
) -> Result<PointRow, Interrupted> {
    let clock = Instant::now();
    let refined = &*with_level_if_refined(point);
    let start = carried_from(job, link.end.as_ref());
    let mut result = compute_point(refined, start, parts, worker.seat, interrupt)?;
    let level = level(&result.outcome).filter(|_| point.direction.is_some());
    if point.analyses.nvh.is_none() {
        result.outcome.nvh = None;
    }
    let mut chain = None;
    if let Some(direction) = point.direction {
        if let Some(trouble) = &link.trouble {
            let how = match trouble {
                Status::Diverged => "diverged",
                Status::EventStorm => "ended in an event storm",
                Status::Inaccurate => "was not followed accurately",
                Status::Ok | Status::NotConverged | Status::Failed => "failed",
            };
            let note = format!("; started from run.initial because the previous point {how}");
            result.outcome.reason.push_str(&note);
        }
        let search = Search {
            job,
            point,
            parts,
            seat: worker.seat,
            interrupt,
        };
        chain = Some(Box::new(ChainPart {
            upwards: direction == Direction::Up,
            transition: search.narrow_change(link, &mut result, level)?,
            level,
            end: result.end.take(),
        }));
    }
    Ok(PointRow {
        chain,
        ..row(point, result, worker, clock)
    })
}

/// Requested number of halvings at changes of motion.
pub(super) fn halvings(analyses: &Analyses) -> u32 {
    let poincare = analyses.poincare.as_ref();
    poincare.map_or(0, |config| config.refine)
}

/// The search for a change of motion just before a point.
struct Search<'a> {
    job: &'a Job,
    point: &'a PointSpec,
    parts: &'a Prepared,
    seat: Option<&'a Seat<'a>>,
    interrupt: &'a AtomicBool,
}

impl Search<'_> {
    /// The change of motion before the point, if there is one, with the requested precision. The cycles of
    /// the trials are added to those of the point.
    fn narrow_change(
        &self,
        link: &ChainState,
        result: &mut PointResult,
        level: Option<Level>,
    ) -> Result<Option<Transition>, Interrupted> {
        let halvings = halvings(&self.point.analyses);
        let (Some(near), Some(to)) = (&link.near, verdict(&result.outcome)) else {
            return Ok(None);
        };
        let Some(carried) = self.job.carried.as_ref() else {
            return Ok(None);
        };
        let half_gap = self.point.mesh.scale();
        let change = |near: &LastVerdict, far: Option<Level>| {
            Some(level_change([near.level?, far?], half_gap))
        };
        let at_first = change(near, level).filter(|change| {
            // Compare with the previous change only if it is known and of the same kind. Otherwise any notable change
            // counts, and halving the interval decides.
            let step = near.step.filter(|_| near.alike || halvings == 0);
            let stands_out = |step| *change > STANDS_OUT * step;
            *change > NOTABLE_CHANGE && step.map_or(halvings > 0, stands_out)
        });
        if near.class == to && at_first.is_none() {
            return Ok(None);
        }
        let (mut near, mut far) = (near.clone(), level);
        let mut transition = Transition {
            from: near.class,
            to,
            bracket: [near.value, self.point.axis_values[carried.axis]],
            trials: 0,
            jump: None,
        };
        // The remaining change at constant class, and whether it is large enough for a jump.
        let left = |near: &LastVerdict, far| change(near, far).unwrap_or(0.0);
        let jumps = |near: &LastVerdict, far| {
            left(near, far) >= REMAINING_CHANGE * at_first.unwrap_or(f64::INFINITY)
        };
        let mut trial_point = motion_only(self.point.clone());
        if near.class == to {
            trial_point = with_level(&trial_point);
        }
        let mut halved = 0;
        let fewest = if near.class == to && halvings > 0 { FEWEST_HALVINGS } else { 0 };
        for _ in 0..halvings.max(fewest) {
            let value = 0.5 * (near.value + transition.bracket[1]);
            let Some(between) = self.job.point_between(&trial_point, value) else {
                break;
            };
            let start = carried_from(self.job, Some(&near.end));
            let trial_result =
                compute_point(&between, start, self.parts, self.seat, self.interrupt)?;
            transition.trials += 1;
            result.outcome.cycles += trial_result.outcome.cycles;
            let here = self::level(&trial_result.outcome);
            let (Some(class), Some(end)) = (verdict(&trial_result.outcome), trial_result.end)
            else {
                break;
            };
            let trial = LastVerdict {
                value,
                class,
                end,
                level: here,
                step: None,
                alike: false,
            };
            // With one class on both sides, the trial belongs to the side with the nearer level.
            let as_before = class == transition.from
                && (transition.to != transition.from || left(&near, here) <= left(&trial, far));
            if as_before {
                near = trial;
                transition.bracket[0] = value;
            } else {
                far = here;
                transition.to = class;
                transition.bracket[1] = value;
            }
            halved += 1;
            if transition.to == transition.from && !jumps(&near, far) {
                return Ok(None);
            }
        }
        if transition.to == transition.from {
            if halved < fewest {
                return Ok(None);
            }
            transition.jump = near.level.zip(far).map(|(before, behind)| [before, behind]);
        }
        Ok(Some(transition))
    }
}

/// The point with only the requests that give its class of motion.
pub(super) fn motion_only(mut point: PointSpec) -> PointSpec {
    Arc::make_mut(&mut point.run).audit_cycles = 0;
    let lyapunov = point.analyses.lyapunov.map(|config| LyapunovConfig {
        twin: false,
        ..config
    });
    point.analyses = Arc::new(Analyses {
        lyapunov,
        ..Analyses::default()
    });
    point
}
