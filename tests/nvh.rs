//! NVH statistics against closed forms and against brute-force counting along a trajectory.

#![allow(clippy::unwrap_used)]

mod common;

use atlas::analysis::{Nvh, NvhOutcome};
use atlas::model::{Contact, FlankError, Model, Segment, Stiffness};
use atlas::numerics::exponential::legendre_series;
use atlas::numerics::random::Stream;
use atlas::propagate::{Event, Observer, Window};
use common::march::{Events, march_with, settled, volterra};
use common::{forty_modes, model, one_degree};
use std::f64::consts::{SQRT_2, TAU};

/// A mean \[m\] and cosines: (order of the mesh frequency, amplitude \[m\], phase \[rad\]).
struct Signal(f64, Vec<(f64, f64, f64)>);

/// Shows a signal as deflection over some mesh cycles, its force a thousand N/m of it.
fn show(model: &Model, nvh: &mut Nvh, signal: &Signal, cycles: std::ops::Range<u64>) {
    let segment = Segment {
        start: 0.0,
        end: 1.0,
        stiffness: Stiffness::constant(1.0),
        error: FlankError::NONE,
        direction: 0,
        damping: 0.0,
    };
    // Uneven on purpose: cuts and the window that comes again and again.
    let places = [0.0, 0.1, 0.2, 0.3, 0.37, 0.5, 0.6, 0.7, 0.81, 0.9, 1.0];
    let period = model.period();
    for cycle in cycles {
        for ends in places.windows(2) {
            let [start, duration] = [ends[0] * period, (ends[1] - ends[0]) * period];
            let mut deflection = [0.0; 16];
            deflection[0] = signal.0;
            for (order, amplitude, phase) in &signal.1 {
                let omega = TAU * order / period;
                let mut series = [(0.0, 0.0); 16];
                legendre_series((0.0, omega), duration, &mut series);
                let turned = TAU * (order * cycle as f64).fract() + omega * start + phase;
                let (sin, cos) = turned.sin_cos();
                for (a, u) in deflection.iter_mut().zip(series) {
                    *a += amplitude * (cos * u.0 - sin * u.1);
                }
            }
            nvh.window(&Window {
                cycle,
                start,
                duration,
                segment: &segment,
                contact: Contact::Free,
                deflection: &deflection,
                force: &deflection.map(|a| 1e3 * a),
                first: &[],
                second: &[],
            });
        }
    }
}

#[track_caller]
fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs().max(1e-12), "{a} {b}");
}

#[test]
fn a_sine_has_its_crest_and_kurtosis() {
    let model = model(&one_degree());
    let mut nvh = Nvh::new(&model, 4);
    let signal = Signal(2e-5, vec![(2.0, 3e-6, 0.7)]);
    show(&model, &mut nvh, &signal, 5..45);
    nvh.repeats(1);
    let found = nvh.outcome().unwrap();
    close(found.dte_mean, 2e-5, 1e-13);
    close(found.dte_rms, 3e-6 / SQRT_2, 1e-12);
    close(found.dte_crest, SQRT_2, 1e-9);
    close(found.dte_kurtosis, 1.5, 1e-11);
    close(found.dte_pp, 6e-6, 1e-9);
    close(found.harmonics[1], 3e-6, 1e-12);
    assert!([0, 2, 3].iter().all(|&h| found.harmonics[h] < 1e-17));
    close(found.force_std, 3e-3 / SQRT_2, 1e-12);
    assert_eq!(found.suborders, [0.0; 5]);
    assert_eq!(found.stderr, None);
}

/// Amplitudes at 1/4, 1/3, 1/2, 2/3, 3/4 of a motion with a period of `period` cycles.
fn suborders(signal: &Signal, period: Option<u32>, cycles: u64) -> NvhOutcome {
    let model = model(&one_degree());
    let mut nvh = Nvh::new(&model, 2);
    show(&model, &mut nvh, signal, 7..7 + cycles);
    if let Some(period) = period {
        nvh.repeats(period);
    }
    nvh.outcome().unwrap()
}

#[test]
fn periods_of_two_three_and_four_have_their_suborders() {
    let two = Signal(1e-6, vec![(1.0, 4e-6, 0.1), (0.5, 3e-6, 1.0)]);
    // Whole periods, but not whole windows of 24 cycles.
    let found = suborders(&two, Some(2), 30).suborders;
    close(found[2], 3e-6, 1e-12);
    assert_eq!(
        [found[0], found[1], found[3], found[4]].map(|a| a > 1e-18),
        [false; 4]
    );

    let three = Signal(
        1e-6,
        vec![
            (1.0, 4e-6, 0.1),
            (1.0 / 3.0, 2e-6, 0.4),
            (2.0 / 3.0, 1e-6, 2.0),
        ],
    );
    let found = suborders(&three, Some(3), 33).suborders;
    close(found[1], 2e-6, 1e-12);
    close(found[3], 1e-6, 1e-12);

    let four = Signal(
        0.0,
        vec![(0.25, 5e-6, 0.0), (0.5, 1e-6, 0.2), (0.75, 2e-6, 0.3)],
    );
    for (period, cycles) in [(Some(4), 28), (None, 72)] {
        let found = suborders(&four, period, cycles).suborders;
        for (index, exact) in [(0, 5e-6), (2, 1e-6), (4, 2e-6)] {
            close(found[index], exact, 1e-12);
        }
        assert!(found[1] < 1e-17 && found[3] < 1e-17, "{found:?}");
    }
    assert!(suborders(&four, None, 20).suborders.is_empty());
}

/// Durations and impacts by a second count along a rattling trajectory.
#[test]
fn impacts_and_stays_are_those_of_the_events() {
    let model = model(&forty_modes());
    let start = settled(&model, 200);
    let (mut nvh, mut events) = (Nvh::new(&model, 0), Events::default());
    march_with(&volterra(&model), &start, 400, &mut (&mut nvh, &mut events));
    let found = nvh.outcome().unwrap();
    let events = events.0;
    let time = |e: &Event| e.cycle as f64 * model.period() + e.time;
    let entries = |to: Contact| events.iter().filter(|e| e.to == to).count() as u64;
    assert_eq!(
        found.impacts,
        [entries(Contact::Drive), entries(Contact::Coast)]
    );
    assert!(found.impacts[0] > 200);

    let mut speeds: Vec<f64> = (events.iter().filter(|e| e.to.touching()))
        .map(|e| e.rate.abs())
        .collect();
    speeds.sort_by(f64::total_cmp);
    let below = |speed: f64| speeds.iter().filter(|s| **s <= speed).count() as f64;
    let shares = [0.5, 0.9, 0.99];
    for (quantile, share) in found.impact_velocity_quantiles.iter().zip(shares) {
        let n = speeds.len() as f64;
        assert!((below(*quantile) - share * n).abs() <= 1.5, "{share}");
    }
    assert_eq!(found.impact_velocity_max, speeds.last().copied());

    for (touching, stays) in [(false, found.flights), (true, found.contacts)] {
        let pairs = events.windows(2).filter(|p| p[0].to.touching() == touching);
        let mut lengths: Vec<f64> = pairs.map(|p| time(&p[1]) - time(&p[0])).collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(stays.count, lengths.len() as u64);
        close(
            stays.mean.unwrap(),
            lengths.iter().sum::<f64>() / lengths.len() as f64,
            1e-9,
        );
        let middle = [(lengths.len() - 1) / 2, lengths.len() / 2].map(|i| lengths[i]);
        close(stays.median.unwrap(), 0.5 * (middle[0] + middle[1]), 1e-9);
    }
}

/// Two flights of different length a cycle: the one that the record's ends cut in two counts.
#[test]
fn stays_of_a_motion_that_repeats_are_whole() {
    let model = model(&one_degree());
    let mut nvh = Nvh::new(&model, 0);
    let period = model.period();
    let still = Signal(0.0, Vec::new());
    for cycle in 3..13 {
        show(&model, &mut nvh, &still, cycle..cycle + 1);
        let changes = [
            (0.1, Contact::Drive),
            (0.3, Contact::Free),
            (0.4, Contact::Coast),
            (0.7, Contact::Free),
        ];
        let mut from = Contact::Free;
        for (place, to) in changes {
            nvh.event(&Event {
                cycle,
                time: place * period,
                from,
                to,
                surface: atlas::model::Surface::Drive,
                rate: place,
            });
            from = to;
        }
    }
    nvh.repeats(1);
    let found = nvh.outcome().unwrap();
    assert_eq!([found.flights.count, found.contacts.count], [20, 20]);
    close(found.flights.mean.unwrap(), 0.25 * period, 1e-12);
    close(found.contacts.mean.unwrap(), 0.25 * period, 1e-12);
    assert_eq!(found.impacts, [10, 10]);
    assert_eq!(found.impact_velocity_max, Some(0.4));
}

/// Sines whose amplitude is drawn anew every ten cycles: means over stretches are independent
/// draws, so that standard errors have closed forms.
#[test]
fn standard_errors_are_those_of_independent_draws() {
    let model = model(&one_degree());
    let mut nvh = Nvh::new(&model, 1);
    let mut stream = Stream::new(5, 6, 7);
    let blocks = 1024u64;
    for block in 0..blocks {
        let amplitude = 1e-6 * (3.0 + stream.normal());
        let mean = 1e-7 * stream.normal();
        let signal = Signal(mean, vec![(1.0, amplitude, 0.3)]);
        show(&model, &mut nvh, &signal, 10 * block..10 * (block + 1));
    }
    let errors = nvh.outcome().unwrap().stderr.unwrap();
    let root = (blocks as f64).sqrt();
    // σ(a) = 1 µm, σ(a²) = √(4·9 + 2) µm²; the mean of squares a²/2 is 5 µm².
    let exact = [
        (errors.dte_mean, 1e-7),
        (errors.harmonics[0], 1e-6),
        (
            errors.dte_rms,
            38f64.sqrt() / 2.0 * 1e-12 / (2.0 * 5f64.sqrt() * 1e-6),
        ),
        (errors.force_mean, 1e-4),
    ];
    for (found, one) in exact {
        let ratio = found / (one / root);
        assert!((0.8..1.45).contains(&ratio), "{ratio}");
    }
    assert!(errors.flight_mean.is_infinite() && errors.flight_median.is_infinite());
}
