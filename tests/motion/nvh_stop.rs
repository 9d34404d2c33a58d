//! NVH statistics that end at a requested accuracy: when they end, their values then, and the work that continues
//! without them.

#![allow(clippy::unwrap_used)]

use crate::{common, place, results};
use common::advance::volterra;
use gearatlas::analysis::{
    Class, Effort, LyapunovConfig, NvhConfig, OrderConfig, PointConfig, PointOutcome, Section,
    Signals, SpectrumConfig, Status, investigate,
};
use gearatlas::model::{InitialState, Model};
use gearatlas::numerics::random::PointSeed;
use gearatlas::store::{ResultTable, TableKind};
use place::Place;
use results::assert_same;
use std::sync::atomic::AtomicBool;

/// Measured cycles of a survey at its first look.
const FIRST_LOOK: u64 = 2000;

fn questions(cycles: u64, stop_at_stderr: Option<f64>) -> PointConfig {
    let signals = Signals {
        deflection: true,
        force: true,
        bearings: true,
        ..Signals::NONE
    };
    PointConfig {
        point: PointSeed {
            seed: 3,
            point_id: 1,
        },
        transient: 200,
        cycles,
        settle: false,
        audit_cycles: 0,
        lyapunov: Some(LyapunovConfig {
            align: 50,
            twin: false,
            effort: Effort::Survey,
            ..LyapunovConfig::default()
        }),
        poincare_samples: 100,
        section: Section::Extremum,
        nvh: Some(NvhConfig {
            harmonics: 3,
            outputs: Signals::NONE,
            power: false,
            spectrum: Some(SpectrumConfig {
                signals,
                highest_order: 4,
                resolution: 16,
            }),
            orders: Some(OrderConfig {
                signals,
                mesh: 3,
                shafts: 2,
            }),
            stop_at_stderr,
        }),
    }
}

fn ask(model: &Model, questions: &PointConfig) -> PointOutcome {
    let start = model.start(&InitialState::Static);
    let kernel = volterra(model);
    investigate(model, &kernel, start, questions, &AtomicBool::new(false)).unwrap()
}

fn chaotic() -> Model {
    common::model(&common::one_degree())
}

fn impact_power_error(outcome: &PointOutcome) -> f64 {
    let nvh = outcome.nvh.as_ref().unwrap();
    nvh.stderr.as_ref().unwrap().impact_power / nvh.values.impact_power
}

/// All NVH statistics are as in a run with exactly these cycles; all other results are as if nothing had ended.
#[test]
fn statistics_end_by_themselves_and_nothing_else_does() {
    let model = chaotic();
    let (cycles, target) = (12_000, 0.03);
    let found = ask(&model, &questions(cycles, Some(target)));
    let gathered = found.nvh.as_ref().unwrap().cycles;
    println!("{gathered} of {cycles} cycles");
    assert!((FIRST_LOOK + 1..cycles / 2).contains(&gathered));
    assert!(impact_power_error(&found) <= target);

    let short = ask(&model, &questions(gathered, None));
    assert_eq!(found.nvh, short.nvh);
    assert_eq!(found.spectra, short.spectra);
    assert_eq!(found.orders, short.orders);
    assert!(!found.orders.is_empty() && !found.spectra.is_empty());
    // At the first look some accuracy was not reached yet.
    let first = ask(&model, &questions(FIRST_LOOK, Some(target)));
    assert_eq!(first.status, Status::NotConverged);
    assert!(first.reason.contains("analyses.nvh.stop_at_stderr is 0.03"));
    assert_eq!(first.class, Some(Class::Chaotic));

    let long = ask(&model, &questions(cycles, None));
    assert_eq!(found.lyapunov, long.lyapunov);
    assert_eq!(found.poincare, long.poincare);
    assert_eq!(found.events_per_cycle, long.events_per_cycle);
    assert_eq!((found.measured_cycles, found.cycles), (cycles, long.cycles));
    assert_eq!((&found.status, &found.reason), (&Status::Ok, &long.reason));
    // The more accurate values of the long run are within some of the error bars.
    let [own, better] = [&found, &long].map(|outcome| outcome.nvh.as_ref().unwrap());
    let bars = own.stderr.as_ref().unwrap();
    let [own, better] = [own, better].map(|outcome| &outcome.values);
    for (value, wanted, bar) in [
        (
            own.deflection_rms,
            better.deflection_rms,
            bars.deflection_rms,
        ),
        (own.force_std, better.force_std, bars.force_std),
        (own.impact_power, better.impact_power, bars.impact_power),
        (own.rattle_index, better.rattle_index, bars.rattle_index),
    ] {
        assert!((value - wanted).abs() < 4.0 * bar, "{value} {wanted} {bar}");
        assert!(value != wanted);
    }
}

#[test]
fn a_point_is_done_when_every_rule_says_so() {
    let model = chaotic();
    let budget = 160_000;
    // Only NVH: the point ends with it.
    let mut alone = questions(budget, Some(0.05));
    alone.lyapunov = None;
    let found = ask(&model, &alone);
    assert_eq!(found.measured_cycles, found.nvh.as_ref().unwrap().cycles);
    assert!(found.measured_cycles < budget && found.status == Status::Ok);

    let both = |exponent: f64, nvh: f64| {
        let mut asked = questions(budget, Some(nvh));
        asked.lyapunov.as_mut().unwrap().stop_at_stderr = Some(exponent);
        ask(&model, &asked)
    };
    let exponent_last = both(0.01, 0.3);
    let nvh = exponent_last.nvh.as_ref().unwrap();
    assert_eq!(nvh.cycles, FIRST_LOOK);
    assert!(nvh.cycles < exponent_last.measured_cycles);
    assert!(exponent_last.lyapunov.as_ref().unwrap().stderr() <= 0.01);

    let nvh_last = both(0.1, 0.03);
    let nvh = nvh_last.nvh.as_ref().unwrap();
    assert_eq!(nvh.cycles, nvh_last.measured_cycles);
    assert!((FIRST_LOOK + 1..budget).contains(&nvh.cycles));
    assert!(impact_power_error(&nvh_last) <= 0.03);
}

/// A periodic motion is measured over one period, for any request.
#[test]
fn a_motion_that_repeats_is_exact_all_the_same() {
    let model = common::model_at(&common::one_degree(), 0.2, 1800.0);
    let mut asked = questions(4000, None);
    asked.settle = true;
    let without = ask(&model, &asked);
    assert_eq!(without.class, Some(Class::Periodic(2)));
    assert_eq!(without.nvh.as_ref().unwrap().cycles, 2);
    asked.nvh.as_mut().unwrap().stop_at_stderr = Some(1e-9);
    assert_eq!(ask(&model, &asked), without);
}

/// Through the program: the same tables on any number of threads and in shards.
#[test]
fn threads_and_shards_change_nothing() {
    let slow = r#"speed = { from = "6000 rpm", to = "12000 rpm", count = 4 }"#;
    let text = include_str!("../../manifests/quickstart.toml");
    assert!(text.contains(slow));
    let place = Place::new(&text.replace(slow, "speed = { from = 1200, to = 1400, count = 2 }"));
    let run = |out: &str, more: &[&str]| {
        let asked = [
            "--set",
            "analyses.nvh.stop_at_stderr=0.2",
            "--set",
            "analyses.lyapunov.effort=survey",
            "--set",
            "run.cycles=4000",
            "--set",
            "model.modes=6",
        ];
        place.whole(out, &[&asked[..], more].concat())
    };
    let one = run("one", &["-j", "1"]);
    let two = run("two", &["-j", "2"]);
    for index in ["1/2", "2/2"] {
        run("parts", &["--shard", index]);
    }
    let tables = ["points.parquet", "poincare.parquet"];
    assert_same(&tables, &one, &two);
    assert_same(&tables, &one, &place.path("parts"));
    let points = ResultTable::read(&one, TableKind::Points).unwrap();
    let cycles = |name: &str| points.u64(name).unwrap();
    let ended = cycles("nvh_cycles")
        .into_iter()
        .zip(cycles("measured_cycles"));
    assert!(ended.filter(|(nvh, all)| nvh < all).count() > 0);
}
