//! Predictability compared with known results: the growth of twins is that of the exponent, the horizon agrees with a
//! straight line, and threads do not change the result.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{settled, volterra};
use common::{model, one_degree, two_modes};
use gearatlas::analysis::{
    EnergyNorm, HorizonConfig, HorizonOutcome, HorizonQuantity, TangentGrowth, predictability,
};
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::numerics::random::{PointSeed, Stream};
use gearatlas::numerics::statistics::mean;
use gearatlas::propagate::{Counters, Kernel};
use std::sync::atomic::AtomicBool;

const POINT: PointSeed = PointSeed {
    seed: 3,
    point_id: 4,
};

const QUESTION: HorizonConfig = HorizonConfig {
    twins: 24,
    separation: 1e-8,
    cycles: 60,
    averages: 200,
};

fn ask(model: &Model, start: &TrajectoryState) -> HorizonOutcome {
    let kernel = volterra(model);
    predictability(
        model,
        &kernel,
        start,
        &QUESTION,
        POINT,
        &AtomicBool::new(false),
    )
    .unwrap()
}

/// The largest exponent by tangents over many cycles.
fn exponent(model: &Model, start: &TrajectoryState) -> f64 {
    let kernel = volterra(model);
    let norm = EnergyNorm::new(model);
    let mut growth = TangentGrowth::new(&norm, model.modes(), 1, &mut Stream::new(1, 2, 3));
    let (mut trajectory, mut workspace) = (start.clone(), kernel.workspace());
    for _ in 0..6000 {
        kernel
            .advance_cycle(
                &mut trajectory,
                growth.tangents(),
                &mut workspace,
                &mut (),
                &mut Counters::default(),
            )
            .unwrap();
        growth.cycle(&norm);
    }
    mean(growth.averages().values())
}

/// A chaotic drive, according to its exponent.
fn rattling() -> (Model, TrajectoryState, f64) {
    let [one, two] = [one_degree(), two_modes()].map(|case| model(&case));
    for model in [one, two] {
        let start = settled(&model, 500);
        let lambda = exponent(&model, &start);
        if lambda > 0.1 {
            return (model, start, lambda);
        }
    }
    panic!("no drive rattles chaotically");
}

#[test]
fn twins_part_with_the_exponent_and_reach_the_horizon() {
    let (model, start, lambda) = rattling();
    let found = ask(&model, &start);
    let of = |quantity| {
        found
            .measures
            .iter()
            .filter(move |m| m.quantity == quantity)
    };
    let separation: Vec<f64> = (of(HorizonQuantity::Separation)).map(|m| m.value).collect();
    assert_eq!(separation.len(), 61);
    assert!((separation[0] / 1e-8 - 1.0).abs() < 1e-12);

    // Between a thousand times the start and a thousandth of the end, growth is that of λ.
    let within = |s: &f64| *s > 1e-7 && *s < 1e-3 * found.saturation;
    let inside: Vec<usize> = (0..61).filter(|&n| within(&separation[n])).collect();
    let (first, last) = (inside[0], *inside.last().unwrap());
    let slope = (separation[last] / separation[first]).ln() / (last - first) as f64;
    assert!((slope / lambda - 1.0).abs() < 0.25, "{slope} {lambda}");

    let horizon = found.horizon.unwrap();
    let error = found.stderr.unwrap();
    let line = (0.1 * found.saturation / 1e-8).ln() / lambda;
    assert!(error > 0.0 && error < 0.2 * horizon, "{error}");
    assert!((horizon / line - 1.0).abs() < 0.35, "{horizon} {line}");
    // The separation levels off at the distance of unrelated states.
    let end = separation[55..].iter().map(|s| s.ln()).sum::<f64>() / 6.0;
    assert!((end.exp() / found.saturation).ln().abs() < 0.3);

    for m in of(HorizonQuantity::Exponent) {
        let doubt = 5.0 * m.spread / (m.samples as f64).sqrt() + 0.05 * lambda;
        assert!((m.value - lambda).abs() < doubt, "{m:?} {lambda}");
    }
    let spreads: Vec<f64> = of(HorizonQuantity::Exponent).map(|m| m.spread).collect();
    // The spread of 16 averages is accurate to a fifth.
    assert!(
        spreads.windows(2).all(|pair| pair[1] < 1.2 * pair[0]),
        "{spreads:?}"
    );
    let decay = found.averaging_exponent.unwrap();
    assert!((-0.8..-0.3).contains(&decay), "{decay}");
    // By momentum, the mean force over n cycles differs from the load by the difference of the ends, divided by n.
    let force: Vec<_> = of(HorizonQuantity::Force).collect();
    let [short, long] = [20, 200].map(|n| force.iter().find(|m| m.cycles == n).unwrap());
    let power = (long.spread / short.spread).log10();
    assert!((-1.3..-0.8).contains(&power), "{power}");
    let load = 0.05 * 1330.0;
    assert!((long.value / load - 1.0).abs() < 0.02, "{}", long.value);
    assert_eq!(found.cycles, 100 + 16 * 200 + 24 * 60);
}

#[test]
fn the_same_question_has_the_same_answer_to_the_last_bit() {
    let (model, start, _) = rattling();
    let [a, b] = [(), ()].map(|()| ask(&model, &start));
    assert_eq!(a, b);
    let other = PointSeed {
        point_id: 5,
        ..POINT
    };
    let kernel = volterra(&model);
    let c = predictability(
        &model,
        &kernel,
        &start,
        &QUESTION,
        other,
        &AtomicBool::new(false),
    )
    .unwrap();
    assert_ne!(a.horizon, c.horizon);
}
