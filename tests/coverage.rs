//! Do 95 % intervals hold the truth 95 times of a hundred? A small chaotic drive from a
//! hundred initial states, against a run a hundred times as long.

#![allow(clippy::unwrap_used)]

mod common;

use atlas::analysis::{
    GrowthNorm, LyapunovQuestion, NvhQuestion, PointOutcome, Questions, SEPARATION, Section,
    Signals, investigate,
};
use atlas::model::{InitialState, Model, TrajectoryState};
use atlas::numerics::random::{PointSeed, Stream};
use common::advance::volterra;
use std::sync::atomic::AtomicBool;

const SEEDS: u64 = 100;
const CYCLES: u64 = 1280;
/// Cycles of the run that stands for the truth, in four parts from four initial states.
const LONG: u64 = 4 * 64_000;

/// What is known of a run: value and standard error of λ and of the RMS.
type Known = [(f64, f64); 2];

fn ask(model: &Model, seed: u64, cycles: u64, stop_at_stderr: Option<f64>) -> PointOutcome {
    answer(model, seed, cycles, stop_at_stderr, None)
}

/// The same with NVH statistics gathered until they are known so well.
fn answer(
    model: &Model,
    seed: u64,
    cycles: u64,
    stop_at_stderr: Option<f64>,
    nvh_stop_at_stderr: Option<f64>,
) -> PointOutcome {
    let questions = Questions {
        point: PointSeed { seed, point_id: 0 },
        transient: 300,
        cycles,
        settle: false,
        audit_cycles: 0,
        lyapunov: Some(LyapunovQuestion {
            exponents: 1,
            stop_at_stderr,
            align: 50,
            twin: false,
            separation: SEPARATION,
            course: 0,
            norm: GrowthNorm::Energy,
        }),
        poincare_samples: 0,
        section: Section::default(),
        nvh: Some(NvhQuestion {
            harmonics: 0,
            outputs: Signals::NONE,
            spectrum: None,
            orders: None,
            stop_at_stderr: nvh_stop_at_stderr,
        }),
    };
    // A start of its own, some half gaps away from the equilibrium.
    let mut stream = Stream::new(seed, 1, 2);
    let mut start = model.start(&InitialState::Static);
    for x in &mut start.state {
        *x *= 1.0 + 0.1 * stream.normal();
    }
    let start = TrajectoryState::new(model, start.state, 0);
    investigate(
        model,
        &volterra(model),
        start,
        &questions,
        &AtomicBool::new(false),
    )
    .unwrap()
}

fn known(outcome: &PointOutcome) -> Known {
    let lyapunov = outcome.lyapunov.as_ref().unwrap();
    let nvh = outcome.nvh.as_ref().unwrap();
    let stderr = nvh.stderr.as_ref().unwrap();
    [
        (lyapunov.exponents[0], lyapunov.stderr()),
        (nvh.deflection_rms, stderr.deflection_rms),
    ]
}

/// Answers for some seeds, over the two cores that every machine has.
fn answers<T: Send>(seeds: std::ops::Range<u64>, answer: impl Fn(u64) -> T + Sync) -> Vec<T> {
    let middle = seeds.start + (seeds.end - seeds.start) / 2;
    let (early, late) = (seeds.start..middle, middle..seeds.end);
    std::thread::scope(|scope| {
        let other = scope.spawn(|| late.map(&answer).collect::<Vec<T>>());
        let mut all: Vec<T> = early.map(&answer).collect();
        all.extend(other.join().unwrap());
        all
    })
}

fn chaotic() -> Model {
    common::model(&common::one_degree())
}

/// Long-run values of λ and of the RMS.
fn truth(model: &Model) -> [f64; 2] {
    let parts = answers(1000..1004, |seed| known(&ask(model, seed, LONG / 4, None)));
    // Equal parts; the RMS of each is about its own mean, which they share.
    [
        parts.iter().map(|p| p[0].0).sum::<f64>() / 4.0,
        (parts.iter().map(|p| p[1].0.powi(2)).sum::<f64>() / 4.0).sqrt(),
    ]
}

/// Of a hundred, how many intervals hold the truth; and the mean bar over the deviation.
fn coverage(found: &[Known], truth: [f64; 2]) -> [(usize, f64); 2] {
    [0, 1].map(|i| {
        let count = found.len() as f64;
        let square: f64 = found.iter().map(|k| (k[i].0 - truth[i]).powi(2)).sum();
        let bar = found.iter().map(|k| k[i].1).sum::<f64>() / count;
        let held = |k: &&Known| (k[i].0 - truth[i]).abs() < 1.96 * k[i].1;
        let hits = found.iter().filter(held).count();
        (hits, bar / (square / count).sqrt())
    })
}

#[test]
fn intervals_of_a_chaotic_motion_hold_the_long_run_value() {
    let model = chaotic();
    let truth = truth(&model);
    let fixed = answers(0..SEEDS, |seed| known(&ask(&model, seed, CYCLES, None)));
    let fixed = coverage(&fixed, truth);
    // Stopped where the error bar is short enough, which it was asked to be by chance.
    let target = 0.015;
    let stopped = answers(200..200 + SEEDS, |seed| {
        let found = ask(&model, seed, 8 * CYCLES, Some(target));
        (known(&found), found.measured_cycles)
    });
    let cycles = stopped.iter().map(|s| s.1).sum::<u64>() / SEEDS;
    println!("stopped after {cycles} cycles on average");
    let stopped: Vec<Known> = stopped.into_iter().map(|s| s.0).collect();
    let stopped = coverage(&stopped, truth);
    println!("hits and bar over deviation of λ, RMS: {fixed:.2?}, stopped {stopped:.2?}");
    for (hits, _) in fixed.into_iter().chain(stopped) {
        assert!((90..=99).contains(&hits), "{hits} of {SEEDS}");
    }
}

/// Value and standard error of what a stop rule of NVH statistics ends: the deflection's mean and root mean
/// square, those of the force, impacts.
fn statistics(outcome: &PointOutcome) -> [(f64, f64); 6] {
    let nvh = outcome.nvh.as_ref().unwrap();
    let stderr = nvh.stderr.as_ref().unwrap();
    [
        (nvh.deflection_mean, stderr.deflection_mean),
        (nvh.deflection_rms, stderr.deflection_rms),
        (nvh.deflection_kurtosis, stderr.deflection_kurtosis),
        (nvh.force_std, stderr.force_std),
        (nvh.impact_rate, stderr.impact_rate),
        (nvh.impact_power, stderr.impact_power),
    ]
}

/// At three operating points: statistics that were ended because their errors had come out small enough are
/// no further off than these say.
#[test]
fn intervals_of_nvh_statistics_that_ended_by_themselves_hold_the_long_run_value() {
    let (mut held, mut all, mut stopped_early) = ([0; 6], 0, 0);
    for (load, speed) in [(0.05, 1200.0), (0.1, 1300.0), (0.05, 1500.0)] {
        let model = common::model_at(&common::one_degree(), load, speed);
        let parts = answers(1000..1004, |seed| {
            statistics(&ask(&model, seed, LONG / 4, None))
        });
        let truth: [f64; 6] =
            std::array::from_fn(|i| parts.iter().map(|p| p[i].0).sum::<f64>() / 4.0);
        let found = answers(300..300 + SEEDS, |seed| {
            let outcome = answer(&model, seed, 16 * CYCLES, None, Some(0.03));
            (statistics(&outcome), outcome.nvh.unwrap().cycles)
        });
        let cycles: Vec<u64> = found.iter().map(|f| f.1).collect();
        let mut own = [0; 6];
        for (statistics, cycles) in found {
            for (i, (value, error)) in statistics.into_iter().enumerate() {
                own[i] += u32::from((value - truth[i]).abs() < 2.0 * error);
            }
            stopped_early += u32::from(cycles < 16 * CYCLES);
            all += 1;
        }
        println!(
            "load {load}, speed {speed}: {own:?}, {} to {} cycles",
            cycles.iter().min().unwrap(),
            cycles.iter().max().unwrap()
        );
        for (sum, own) in held.iter_mut().zip(own) {
            *sum += own;
        }
    }
    println!("{held:?} of {all}, {stopped_early} of them ended early");
    assert_eq!(stopped_early, all);
    for hits in held {
        let share = f64::from(hits) / f64::from(all);
        assert!((0.9..0.99).contains(&share), "{share}");
    }
}
