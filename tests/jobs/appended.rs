//! Records of several trajectories in a sequence, and their quantities for a stop rule.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance_with, settled, volterra};
use common::{forty_modes, model};
use gearatlas::analysis::{Nvh, NvhOutcome};
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::numerics::legendre::evaluate;
use gearatlas::numerics::statistics::{quantile, standard_error};
use gearatlas::propagate::{Observer, Window};

/// Time averages with their values in two records.
fn averages<'a>(a: &'a NvhOutcome, b: &'a NvhOutcome) -> Vec<(&'static str, f64, f64)> {
    let [v, w] = [a, b].map(|outcome| &outcome.values);
    let mut pairs = vec![
        ("mean", v.deflection_mean, w.deflection_mean),
        ("rms", v.deflection_rms, w.deflection_rms),
        ("pp", a.deflection_pp, b.deflection_pp),
        ("peak", a.deflection_peak, b.deflection_peak),
        ("kurtosis", v.deflection_kurtosis, w.deflection_kurtosis),
        ("force mean", v.force_mean, w.force_mean),
        ("force std", v.force_std, w.force_std),
        ("force peak", a.force_peak, b.force_peak),
        ("impact rate", v.impact_rate, w.impact_rate),
        ("impact velocity", v.impact_velocity, w.impact_velocity),
        ("impact power", v.impact_power, w.impact_power),
    ];
    for (name, a, b) in [
        ("harmonics", &v.harmonics, &w.harmonics),
        (
            "speeds",
            &v.impact_velocity_quantiles,
            &w.impact_velocity_quantiles,
        ),
        (
            "peaks",
            &v.deflection_peak_quantiles,
            &w.deflection_peak_quantiles,
        ),
        (
            "force peaks",
            &v.force_peak_quantiles,
            &w.force_peak_quantiles,
        ),
    ] {
        assert_eq!(a.len(), b.len(), "{name}");
        pairs.extend(a.iter().zip(b).map(|(a, b)| (name, *a, *b)));
    }
    pairs
}

#[track_caller]
fn alike(pairs: &[(&str, f64, f64)], tolerance: f64) {
    for (name, a, b) in pairs {
        let same = a == b || (a / b - 1.0).abs() < tolerance;
        assert!(same, "{name}: {a:e} {b:e}");
    }
}

/// One record of a rattling trajectory, and the same in two parts of given lengths.
fn records(model: &Model, parts: [u64; 2]) -> [Nvh; 3] {
    let kernel = volterra(model);
    let start = settled(model, 200);
    let new = || Nvh::new(model, 3);
    let (mut whole, mut first) = (new(), new());
    let (middle, _) = advance_with(&kernel, &start, parts[0], &mut (&mut whole, &mut first));
    let mut second = new();
    advance_with(&kernel, &middle, parts[1], &mut (&mut whole, &mut second));
    [whole, first, second]
}

#[test]
fn a_record_in_two_parts_has_the_statistics_of_the_whole() {
    let model = model(&forty_modes());
    let [whole, first, second] = records(&model, [240, 240]);
    let exact = whole.outcome().unwrap();
    let mut parts = first.clone();
    parts.append(&second);
    let found = parts.outcome().unwrap();
    assert_eq!((found.cycles, found.impacts), (480, exact.impacts));
    assert_eq!(found.impact_velocity_max, exact.impact_velocity_max);
    alike(&averages(&found, &exact), 1e-12);
    let suborders = found.values.suborders.iter().zip(&exact.values.suborders);
    alike(
        &suborders
            .map(|(a, b)| ("suborders", *a, *b))
            .collect::<Vec<_>>(),
        1e-12,
    );
    // Neither part contains intervals of flight or contact that continue across the boundary of the parts.
    for (a, b) in [
        (found.flights, exact.flights),
        (found.contacts, exact.contacts),
    ] {
        assert!((b - 2..=b).contains(&a));
    }
    let [a, b] = [&found, &exact].map(|of| [of.values.flight_mean, of.values.contact_mean]);
    for (a, b) in a.iter().zip(b) {
        assert!((a.unwrap() / b.unwrap() - 1.0).abs() < 0.02);
    }
    let [a, b] = [&found, &exact].map(|own| own.stderr.as_ref().unwrap());
    let mut errors = vec![
        ("mean", a.deflection_mean, b.deflection_mean),
        ("rms", a.deflection_rms, b.deflection_rms),
        ("kurtosis", a.deflection_kurtosis, b.deflection_kurtosis),
        ("force std", a.force_std, b.force_std),
        ("impact velocity", a.impact_velocity, b.impact_velocity),
    ];
    let lists = (a.harmonics.iter().zip(&b.harmonics))
        .chain(a.suborders.iter().zip(&b.suborders))
        .chain(a.force_peak_quantiles.iter().zip(&b.force_peak_quantiles));
    errors.extend(lists.map(|(a, b)| ("lists", *a, *b)));
    alike(&errors, 1e-9);

    // Appending to an empty record gives the record itself; appending an empty record changes nothing.
    let mut empty = Nvh::new(&model, 3);
    empty.append(&whole);
    empty.append(&Nvh::new(&model, 3));
    let found = empty.outcome().unwrap();
    alike(&averages(&found, &exact), 1e-14);
    let flights =
        [&found, &exact].map(|of| (of.flights, of.values.flight_mean, of.values.flight_median));
    assert_eq!(flights[0], flights[1]);
}

/// Intervals that continue across the boundary of two parts count in every average.
#[test]
fn parts_of_any_length_add_up() {
    let model = model(&forty_modes());
    let [whole, first, second] = records(&model, [233, 14]);
    let exact = whole.outcome().unwrap();
    for [front, back] in [[&first, &second], [&second, &first]] {
        let mut parts = front.clone();
        parts.append(back);
        let found = parts.outcome().unwrap();
        assert_eq!((found.cycles, found.impacts), (247, exact.impacts));
        alike(&averages(&found, &exact), 1e-12);
    }
}

#[test]
fn records_beside_each_other_share_their_centre() {
    let model = model(&forty_modes());
    let kernel = volterra(&model);
    let mut pilot = Nvh::new(&model, 3);
    let (middle, _) = advance_with(&kernel, &settled(&model, 200), 120, &mut pilot);
    let outcome = |mut member: Nvh, start: &TrajectoryState| {
        let (start, _) = advance_with(&kernel, start, 7, &mut member);
        // Restart as after an unmeasured interval.
        member.restart();
        advance_with(&kernel, &start, 240, &mut member);
        let mut both = pilot.clone();
        both.append(&member);
        both.outcome().unwrap()
    };
    let shared = outcome(pilot.for_same_model(), &middle);
    let own = outcome(Nvh::new(&model, 3), &middle);
    assert_eq!(shared.cycles, 360);
    alike(&averages(&shared, &own), 1e-12);
    // A pilot without data has no centre to share.
    let early = Nvh::new(&model, 3).for_same_model();
    alike(&averages(&outcome(early, &middle), &own), 1e-14);
}

#[test]
fn what_is_watched_has_the_errors_of_the_statistics() {
    let model = model(&forty_modes());
    let [_, mut parts, second] = records(&model, [200, 200]);
    parts.append(&second);
    let errors = parts.outcome().unwrap().stderr.unwrap();
    assert_eq!(parts.stretch(), 10);
    let watched = parts.statistics_for_stop_rule();
    let names: Vec<&str> = watched.iter().map(|(name, _)| *name).collect();
    assert_eq!(
        names,
        [
            "deflection_rms",
            "force_std",
            "impact_velocity",
            "harmonics"
        ]
    );
    let known = [
        errors.deflection_rms,
        errors.force_std,
        errors.impact_velocity,
        errors.harmonics[0],
    ];
    for ((name, series), error) in watched.iter().zip(known) {
        assert_eq!(series.len(), 40);
        alike(&[(name, standard_error(series), error)], 1e-12);
    }
    assert!(Nvh::new(&model, 3).statistics_for_stop_rule().is_empty());
}

/// Smallest and largest deflection and largest |force| of every cycle, by a fine search.
#[derive(Default)]
struct Search(Vec<[f64; 3]>, Option<u64>);

impl Observer for Search {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        if self.1.replace(window.cycle) != Some(window.cycle) {
            self.0.push([f64::INFINITY, f64::NEG_INFINITY, 0.0]);
        }
        let [low, high, force] = self.0.last_mut().unwrap();
        for step in 0..=200 {
            let x = -1.0 + f64::from(step) / 100.0;
            let value = evaluate(window.deflection, x);
            (*low, *high) = (low.min(value), high.max(value));
            *force = force.max(evaluate(window.force, x).abs());
        }
    }
}

#[test]
fn quantiles_of_peaks_are_those_of_a_search() {
    let model = model(&forty_modes());
    let mut both = (Nvh::new(&model, 0), Search::default());
    advance_with(&volterra(&model), &settled(&model, 200), 400, &mut both);
    let found = both.0.outcome().unwrap();
    let errors = found.stderr.as_ref().unwrap();
    let cycles = both.1.0;
    assert_eq!(cycles.len(), 400);
    let mean = found.values.deflection_mean;
    let reach = |[low, high, _]: &[f64; 3]| (high - mean).max(mean - low);
    let peaks: Vec<f64> = cycles.iter().map(reach).collect();
    let forces: Vec<f64> = cycles.iter().map(|[_, _, force]| *force).collect();
    // An error of the mean moves all distances from it.
    let of_mean = errors.deflection_mean;
    assert!(of_mean > 0.0);
    for (values, found, errors, largest, shared) in [
        (
            peaks,
            &found.values.deflection_peak_quantiles,
            &errors.deflection_peak_quantiles,
            found.deflection_peak,
            of_mean,
        ),
        (
            forces,
            &found.values.force_peak_quantiles,
            &errors.force_peak_quantiles,
            found.force_peak,
            0.0,
        ),
    ] {
        let (wanted, error) = quantile(&values, 0.99).unwrap();
        alike(&[("0.99", found[0], wanted)], 1e-3);
        alike(&[("its error", errors[0], error.hypot(shared))], 0.05);
        let (wanted, _) = quantile(&values, 0.999).unwrap();
        alike(&[("0.999", found[1], wanted)], 1e-3);
        assert!(errors[1].is_infinite(), "no cycle beyond it is expected");
        assert!(found[0] < found[1] && found[1] < largest);
    }
}
