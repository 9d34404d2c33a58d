//! How long does a point take in a run? It is tried out over a few cycles.
//!
//! A motion that settles does so during its transient or shortly after: such a point is computed completely.
//! For other motion, a few cycles are measured to predict the number of cycles ([`ExpectedCycles`]). Some
//! more cycles after these, with all observers, give the time of one cycle. The other analyses (attractors,
//! orbits, horizon and covariant vectors) have fewer probes, guesses and cycles.

use super::build::point_config;
use super::carried::CarriedState;
use super::chain::{motion_only, verdict, with_level_if_refined};
use super::estimate::PointTime;
use super::parts::Prepared;
use super::point::{PointResult, Step, Worker, compute_point, row};
use super::queue::work;
use crate::analysis::{Analyses, Class, Interrupted, MultistabilityOutcome};
use crate::analysis::{ExpectedCycles, LyapunovConfig, MultistabilityConfig};
use crate::manifest::{Direction, Job, PointSpec};
use crate::store::{ChainEnd, ChainPart, PointRow};
use crate::topology::ProcessorClock;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Measured cycles of motion that does not settle: enough for an error bar.
const MEASURED: u64 = 400;

/// Number of cycles for timing one cycle.
const TIMED: u64 = 128;

/// Factor by which analyses after the integration are reduced.
const PART: u32 = 32;

/// Largest number of cells along each side of a slice in a trial.
const MOST_CELLS: u32 = 8;

/// Relative standard deviation of a time that is extrapolated from a reduced analysis.
const UNEVEN: f64 = 0.5;

/// A point that was tried out.
pub(super) struct TriedPoint {
    pub id: usize,
    /// Processor time for mesh tables and structures that were not in memory yet \[s\].
    pub prepared: f64,
    pub sampled: PointTime,
    /// Expected time of the point if its motion did not settle \[s\].
    pub most: f64,
    /// Class of its motion, if it is known; motion that did not settle counts as chaos.
    pub motion: Option<Class>,
    /// `None` if the point was abandoned.
    pub row: Option<PointRow>,
}

/// Tries out point `id`, until `over` is raised. A point of a chain is tried out after the point before it, which is
/// treated as the first.
///
/// # Errors
/// [`Interrupted`] if `over` was raised while the point before it, or one cycle, was computed. If it was raised during
/// the trial, the result is an abandoned point.
pub(super) fn try_out(
    job: &Job,
    id: usize,
    parts: &Prepared,
    worker: Worker<'_>,
    clock: ProcessorClock,
    over: &AtomicBool,
) -> Result<TriedPoint, Interrupted> {
    let point = job.points.at(id);
    let begun = clock.now();
    parts.prepare(job, [id], over, &mut || ());
    // A structure is assembled once and kept; the point reports errors of its model.
    _ = parts.model(&point);
    let prepared = clock.now() - begun;
    let before = if id.is_multiple_of(job.chain_length()) {
        None
    } else {
        let before = motion_only(shortened(&job.points.at(id - 1)));
        compute_point(&before, None, parts, None, over)?.end
    };
    let carried = |end| CarriedState {
        end,
        displacement: job
            .carried
            .as_ref()
            .map_or(0.0, |carried| carried.displacement),
    };
    let short = shortened(&with_level_if_refined(&point));
    let (begun, wall) = (clock.now(), Instant::now());
    let trial = compute_point(&short, before.as_ref().map(carried), parts, None, over);
    let took = clock.now() - begun;
    let mut sampled = PointTime {
        time: took,
        spread: 0.0,
        work: work(job.points.variant_near(id)),
    };
    let Ok(mut result) = trial else {
        return Ok(TriedPoint {
            id,
            prepared,
            sampled,
            most: took,
            motion: None,
            row: None,
        });
    };
    let mut motion = verdict(&result.outcome);
    let seed = point.random();
    let outlook = ExpectedCycles::of(&point_config(&point, seed), &result.outcome);
    let measured = result.outcome.measured_cycles;
    let cycle = result.times[Step::Integration as usize] / result.outcome.cycles.max(1) as f64;
    let most = cycle * outlook.expected;
    if measured < point.run.cycles && measured >= short.run.cycles {
        motion = Some(Class::Chaotic);
        let cycle = cycle_time(&short, result.end.as_ref(), parts, over)?;
        sampled.time += cycle * (outlook.expected - measured as f64).max(0.0);
        sampled.spread = cycle * outlook.spread;
    }
    let more = other_analyses_time(&point.analyses, &short.analyses, &result);
    sampled.time += more;
    sampled.spread = sampled.spread.hypot(UNEVEN * more);
    if let (Some(found), Some(config)) = (&mut result.multistability, point.analyses.multistability)
    {
        enlarge(found, &config);
    }
    let end = result.end.take();
    let chain = point.direction.map(|direction| {
        Box::new(ChainPart {
            upwards: direction == Direction::Up,
            transition: None,
            level: None,
            end,
        })
    });
    let row = PointRow {
        chain,
        ..row(&point, result, worker, wall)
    };
    Ok(TriedPoint {
        id,
        prepared,
        sampled,
        most: most.max(sampled.time),
        motion,
        row: Some(row),
    })
}

/// Processor time of a measured cycle from `end` on \[s\]; 0 without an end.
fn cycle_time(
    point: &PointSpec,
    end: Option<&ChainEnd>,
    parts: &Prepared,
    over: &AtomicBool,
) -> Result<f64, Interrupted> {
    let Some(end) = end else {
        return Ok(0.0);
    };
    let mut onward = point.clone();
    let run = Arc::make_mut(&mut onward.run);
    (run.transient, run.cycles, run.settle) = (0, TIMED, false);
    // The cycles of an audit, of a twin and of other analyses do not grow with those of the point.
    run.audit_cycles = 0;
    let analyses = &point.analyses;
    onward.analyses = Arc::new(Analyses {
        lyapunov: analyses.lyapunov.map(|config| LyapunovConfig {
            align: 0,
            twin: false,
            ..config
        }),
        poincare: analyses.poincare.clone(),
        nvh: analyses.nvh,
        ..Analyses::default()
    });
    let start = CarriedState {
        end,
        displacement: 0.0,
    };
    let result = compute_point(&onward, Some(start), parts, None, over)?;
    Ok(result.times[Step::Integration as usize] / result.outcome.cycles.max(1) as f64)
}

/// The point with fewer cycles and reduced analyses.
fn shortened(point: &PointSpec) -> PointSpec {
    let mut short = point.clone();
    let run = Arc::make_mut(&mut short.run);
    if run.cycles > 2 * MEASURED {
        run.cycles = MEASURED;
    }
    let analyses = Arc::make_mut(&mut short.analyses);
    let part = |count: u32, least: u32| (count / PART).max(least).min(count);
    if let Some(config) = &mut analyses.multistability {
        config.initial_conditions = part(config.initial_conditions, 2);
        if let Some(slice) = &mut config.slice {
            slice.count = slice.count.min(MOST_CELLS);
        }
    }
    if let Some(config) = &mut analyses.orbits {
        config.guesses = part(config.guesses, 1);
    }
    if let Some(config) = &mut analyses.horizon {
        config.twins = part(config.twins, 2);
        config.averages = (config.averages / u64::from(PART)).max(1);
    }
    if let Some(config) = &mut analyses.covariant {
        config.cycles = (config.cycles / u64::from(PART)).max(1);
    }
    short
}

/// Processor time of the other analyses, minus that of their reduced form \[s\].
fn other_analyses_time(requested: &Analyses, short: &Analyses, result: &PointResult) -> f64 {
    let more = |step: Step, whole: f64, part: f64| {
        result.times[step as usize] * (whole / part.max(1.0) - 1.0).max(0.0)
    };
    let mut time = 0.0;
    if let (Some(found), Some(requested)) = (&result.multistability, &requested.multistability) {
        let whole = probed(found, requested);
        time += more(Step::Multistability, whole, found.cycles() as f64);
    }
    if let (Some(requested), Some(short)) = (&requested.orbits, &short.orbits) {
        time += more(Step::Orbits, requested.guesses.into(), short.guesses.into());
    }
    if let (Some(requested), Some(short)) = (&requested.horizon, &short.horizon) {
        time += more(Step::Horizon, requested.twins.into(), short.twins.into());
    }
    if let (Some(requested), Some(short)) = (&requested.covariant, &short.covariant) {
        let [requested, short] =
            [requested, short].map(|config| (config.cycles + config.align) as f64);
        time += more(Step::Covariant, requested, short);
    }
    time
}

/// Cycles of all requested probes and cells, extrapolated from some.
fn probed(outcome: &MultistabilityOutcome, config: &MultistabilityConfig) -> f64 {
    let all = |cycles: Vec<u64>, count: f64| {
        cycles.iter().sum::<u64>() as f64 * count / cycles.len().max(1) as f64
    };
    let probes = outcome.probes.iter().map(|probe| probe.cycles).collect();
    let cells = outcome.cells.iter().map(|cell| cell.cycles).collect();
    let side = config.slice.map_or(0.0, |slice| f64::from(slice.count));
    all(probes, config.initial_conditions.into()) + all(cells, side * side)
}

/// Repeats probes and cells up to the requested number, for rows of the final size.
fn enlarge(outcome: &mut MultistabilityOutcome, config: &MultistabilityConfig) {
    fn repeat<T: Clone>(list: &mut Vec<T>, count: usize) {
        *list = list.iter().cloned().cycle().take(count).collect();
    }
    let side = config.slice.map_or(0, |slice| slice.count as usize);
    repeat(&mut outcome.probes, config.initial_conditions as usize);
    repeat(&mut outcome.cells, side * side);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest;
    use crate::store::TableStore;
    use std::path::Path;

    /// The trial of a point that settles is its full computation. Trials of all points take a twentieth of the cycles.
    #[test]
    fn points_are_tried_out_over_few_cycles() {
        let text = include_str!("../../../tests/data/oscillator.toml")
            .replace("15 um", "10 um")
            .replace("cycles = 300", "cycles = 160000")
            .replace("exponents = 2", "stop_at_stderr = 0.01");
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
        let job = manifest::parse(&text, "m.toml", &data).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let parts = Prepared::new(TableStore::open(folder.path()));
        let worker = Worker {
            index: 0,
            topology: None,
            seat: None,
        };
        let over = AtomicBool::new(false);
        let (mut few, mut all, mut open) = (0, 0, 0);
        for id in 0..job.points.len() {
            let whole = compute_point(&job.points.at(id), None, &parts, None, &over).unwrap();
            let trial = try_out(&job, id, &parts, worker, ProcessorClock::Thread, &over).unwrap();
            let row = trial.row.unwrap();
            few += row.outcome.cycles;
            all += whole.outcome.cycles;
            if row.outcome.measured_cycles < MEASURED {
                assert_eq!(row.outcome.cycles, whole.outcome.cycles);
                assert_eq!(row.outcome.class, whole.outcome.class);
                assert_eq!(trial.sampled.spread, 0.0);
            } else {
                assert!(trial.sampled.spread > 0.0 && trial.most > 0.0);
                assert_eq!(trial.motion, Some(Class::Chaotic));
                open += 1;
            }
        }
        assert_eq!(open, 3, "three points are chaotic");
        assert!(20 * few < all, "{few} of {all} cycles");
    }

    /// The trial runs analyses beside the integration, such as `horizon`, in a reduced form, and extrapolates their time.
    #[test]
    fn the_time_of_a_reduced_analysis_is_extrapolated() {
        let text = include_str!("../../../tests/data/oscillator.toml").replace(
            "[analyses]",
            "[analyses]\nhorizon = { twins = 64, separation = 1e-6, cycles = 20, averages = 320 }",
        );
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
        let job = manifest::parse(&text, "m.toml", &data).unwrap();
        let point = job.points.at(0);
        let short = shortened(&point);
        let horizon = short.analyses.horizon.unwrap();
        assert_eq!((horizon.twins, horizon.averages), (2, 10));
        let folder = tempfile::tempdir().unwrap();
        let parts = Prepared::new(TableStore::open(folder.path()));
        let over = AtomicBool::new(false);
        let mut result = compute_point(&short, None, &parts, None, &over).unwrap();
        result.times[Step::Horizon as usize] = 0.5;
        // 64 twins take 32 times as long as two.
        assert_eq!(
            other_analyses_time(&point.analyses, &short.analyses, &result),
            15.5
        );
    }
}
