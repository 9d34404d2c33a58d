//! Are error bars right? Chaotic drives from many starts, whose averages are compared with the long-run values:
//! averages must scatter according to their standard errors, and 95 % intervals must contain the truth.
//! `scripts/record coverage` does the same for ten points of four drives, including intermittent ones.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::common;
use common::advance::volterra;
use gearatlas::analysis::{
    Class, LyapunovConfig, NvhConfig, PointConfig, PointOutcome, Section, Signals, Status,
    investigate,
};
use gearatlas::manifest;
use gearatlas::model::{InitialState, Model, TrajectoryState};
use gearatlas::numerics::random::{PointSeed, Stream};
use gearatlas::numerics::statistics::interval_factor;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// The tested statistics; each has a fixed index.
const STATISTICS: [&str; 5] = [
    "lambda",
    "deflection RMS",
    "force deviation",
    "impact speed",
    "first harmonic",
];

/// Rules for the end of a point: its stop rules, and its largest number of cycles.
#[derive(Debug, Clone, Copy)]
struct Rule {
    exponent: Option<f64>,
    statistics: Option<f64>,
    budget: u64,
}

fn ask(model: &Model, seed: u64, rule: Rule) -> PointOutcome {
    let questions = PointConfig {
        point: PointSeed { seed, point_id: 0 },
        transient: 300,
        cycles: rule.budget,
        settle: true,
        audit_cycles: 0,
        lyapunov: Some(LyapunovConfig {
            stop_at_stderr: rule.exponent,
            twin: false,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: Some(NvhConfig {
            harmonics: 1,
            outputs: Signals::NONE,
            power: false,
            spectrum: None,
            orders: None,
            stop_at_stderr: rule.statistics,
        }),
    };
    // Each seed has a separate start near rest, which chaos forgets within the transient. A distant start may settle on
    // another motion.
    let mut stream = Stream::new(seed, 1, 2);
    let mut start = model.start(&InitialState::Static);
    for x in &mut start.state {
        *x *= 1.0 + 1e-6 * stream.normal();
    }
    let start = TrajectoryState::new(model, start.state, 0);
    let interrupt = AtomicBool::new(false);
    investigate(model, &volterra(model), start, &questions, &interrupt).unwrap()
}

/// A value, its standard error, and half the width of its 95 % interval in standard errors.
type Known = (f64, f64, f64);

fn known(outcome: &PointOutcome) -> [Known; STATISTICS.len()] {
    let lyapunov = outcome.lyapunov.as_ref().unwrap();
    let nvh = outcome.nvh.as_ref().unwrap();
    let error = nvh.stderr.as_ref().unwrap();
    // Exponent and statistics are averages over blocks of ten cycles.
    let [growth, motion] =
        [outcome.measured_cycles, nvh.cycles].map(|cycles| interval_factor(cycles as usize / 10));
    [
        (lyapunov.exponents[0], lyapunov.stderr(), growth),
        (nvh.values.deflection_rms, error.deflection_rms, motion),
        (nvh.values.force_std, error.force_std, motion),
        (nvh.values.impact_velocity, error.impact_velocity, motion),
        (nvh.values.harmonics[0], error.harmonics[0], motion),
    ]
}

/// Results for some seeds, on two cores, which every machine has.
fn answers<T: Send>(seeds: Range<u64>, answer: impl Fn(u64) -> T + Sync) -> Vec<T> {
    let middle = seeds.start + (seeds.end - seeds.start) / 2;
    let (early, late) = (seeds.start..middle, middle..seeds.end);
    std::thread::scope(|scope| {
        let other = scope.spawn(|| late.map(&answer).collect::<Vec<T>>());
        let mut all: Vec<T> = early.map(&answer).collect();
        all.extend(other.join().unwrap());
        all
    })
}

/// Long-run values: the means over a hundred other starts of 40 000 cycles each.
fn truth(model: &Model) -> [f64; STATISTICS.len()] {
    const STARTS: u64 = 100;
    let rule = Rule {
        exponent: None,
        statistics: None,
        budget: 40_000,
    };
    let found = answers(1000..1000 + STARTS, |seed| known(&ask(model, seed, rule)));
    std::array::from_fn(|i| found.iter().map(|k| k[i].0).sum::<f64>() / STARTS as f64)
}

/// Results for a statistic from many starts.
#[derive(Debug)]
struct Coverage {
    name: String,
    /// Root mean square of the errors over the mean claimed error.
    scatter: f64,
    /// Share of the 95 % intervals that contain the truth.
    held: f64,
    /// Mean error, in claimed errors.
    bias: f64,
}

/// Runs `starts` starts of a drive under a rule. Every one must be chaotic and `ok`, so that it ended by the rule.
fn coverage(
    drive: &str,
    model: &Model,
    truth: [f64; STATISTICS.len()],
    rule: Rule,
    starts: u64,
) -> Vec<Coverage> {
    let found = answers(0..starts, |seed| ask(model, seed, rule));
    let mut looks: Vec<u64> = Vec::new();
    for outcome in &found {
        let expected = (&Status::Ok, Some(Class::Chaotic));
        let ended = (&outcome.status, outcome.class);
        assert_eq!(ended, expected, "{drive}: {}", outcome.reason);
        let evidence = outcome.evidence.as_ref().unwrap();
        assert_eq!((evidence.trajectories, evidence.verified), (8, true));
        looks.push(outcome.measured_cycles);
    }
    looks.sort_unstable();
    looks.dedup();
    println!("{drive}: ended at {looks:?} cycles");
    let all: Vec<_> = found.iter().map(known).collect();
    let of = |i: usize| {
        let count = all.len() as f64;
        let off = |k: &[Known; STATISTICS.len()]| k[i].0 - truth[i];
        let claimed = all.iter().map(|k| k[i].1).sum::<f64>() / count;
        let square = all.iter().map(|k| off(k).powi(2)).sum::<f64>() / count;
        let hits = (all.iter()).filter(|k| off(k).abs() < k[i].2 * k[i].1);
        let found = Coverage {
            name: format!("{drive}, {}", STATISTICS[i]),
            scatter: square.sqrt() / claimed,
            held: hits.count() as f64 / count,
            bias: all.iter().map(off).sum::<f64>() / count / claimed,
        };
        println!("{found:.2?}");
        found
    };
    (0..STATISTICS.len()).map(of).collect()
}

/// The chaotic impact oscillator of `scripts/record coverage`.
fn oscillator() -> Model {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/manifests");
    let text = include_str!("../manifests/oscillator.toml");
    let job = manifest::parse(text, "oscillator.toml", &folder).unwrap();
    common::parts().model(&job.points.at(0)).unwrap()
}

/// Ends points at their first looks: about half of the starts have reached this standard error of the exponent at the
/// first look.
const fn rule(exponent: f64) -> Rule {
    Rule {
        exponent: Some(exponent),
        statistics: Some(0.01),
        budget: 160_000,
    }
}

/// The oscillator's long-run values, by [`truth`].
const TRUTH: [f64; STATISTICS.len()] = [0.23772, 0.749376, 63.2269, 7.47749, 0.80207];

#[test]
fn error_bars_of_a_chaotic_oscillator_hold() {
    let found = coverage("oscillator", &oscillator(), TRUTH, rule(0.0022), 28);
    for own in found {
        assert!((0.6..1.4).contains(&own.scatter), "{}: {own:?}", own.name);
        assert!(own.held >= 0.85, "{}: {own:?}", own.name);
        assert!(own.bias.abs() < 0.5, "{}: {own:?}", own.name);
    }
}

/// More starts of more drives, compared with their own long-run values.
#[test]
#[ignore = "takes minutes: cargo test --release --test motion -- --ignored coverage; scripts/record coverage is the full size"]
fn error_bars_of_chaotic_drives_hold() {
    let one_degree = |load, speed| common::model_at(&common::one_degree(), load, speed);
    let mut all = Vec::new();
    for (drive, model, rule) in [
        ("oscillator", oscillator(), rule(0.0022)),
        (
            "one degree, load 0.05, 1200 rad/s",
            one_degree(0.05, 1200.0),
            rule(0.0031),
        ),
        (
            "one degree, load 0.1, 1300 rad/s",
            one_degree(0.1, 1300.0),
            rule(0.0031),
        ),
        (
            "one degree, load 0.05, 1500 rad/s",
            one_degree(0.05, 1500.0),
            rule(0.0031),
        ),
    ] {
        let truth = truth(&model);
        println!("{drive}: truth {truth:?}");
        all.extend(coverage(drive, &model, truth, rule, 60));
    }
    let mean = all.iter().map(|own| own.held).sum::<f64>() / all.len() as f64;
    println!("{mean:.3} of all intervals hold");
    for own in &all {
        assert!((0.7..1.25).contains(&own.scatter), "{}: {own:?}", own.name);
        assert!(own.held >= 0.9, "{}: {own:?}", own.name);
        // Truth and mean error are themselves uncertain by a fifth of a claimed error.
        assert!(own.bias.abs() < 0.5, "{}: {own:?}", own.name);
    }
    assert!((0.9..0.99).contains(&mean), "{mean}");
}
