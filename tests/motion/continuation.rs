//! Continuation compared with closed forms and published motions of oscillators with a stop.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use crate::stopped;
use gearatlas::analysis::continuation::branch::{StepSettings, follow};
use gearatlas::analysis::continuation::curve::{self, CurveSettings};
use gearatlas::analysis::continuation::drive::{DriveMap, ParametricDrive};
use gearatlas::analysis::continuation::end::End;
use gearatlas::analysis::continuation::kind::Kind;
use gearatlas::analysis::continuation::map::{CycleMap, MapParameters};
use gearatlas::analysis::continuation::onset::onset;
use gearatlas::analysis::continuation::orbit::{OrbitCondition, find};
use gearatlas::analysis::continuation::path::Span;
use gearatlas::model::{
    Basis, Division, Drive, InitialState, Model, ModelDerivative, OperatingPoint, Release,
    StateChange,
};
use gearatlas::structure::{HarmonicLoad, ModalStructure};
use stopped::{OFF, PUBLISHED, Stopped};

/// The amplitude at which the linear oscillator just reaches the stop.
fn grazing(omega: f64, damping: f64) -> f64 {
    (1.0 - omega * omega).hypot(2.0 * damping * omega)
}

/// Published: an oscillator with a stop 29 times as stiff behind a gap of 1, damping ratio 0.01, under 0.9·0.8²/1.26 at
/// ω = 0.8, reaches from rest an orbit of two periods with these strobes.
#[test]
fn a_bilinear_oscillator_is_the_published_one() {
    let family = Stopped {
        damping: 0.01,
        stop: 29.0,
        whirls: false,
    };
    let at = [0.8, PUBLISHED];
    let mut map = DriveMap::new(&family, at).unwrap();
    let model = map.model(at).unwrap().clone();
    let rest = model.basis.state(&[OFF], &[0.0]);
    let mut state = gearatlas::model::TrajectoryState::new(&model, rest, 0);
    map.advance(at, 2000, &mut state, &mut ()).unwrap();
    let guess = map.coordinates(&state.state);
    let orbit = find(&mut map, &guess, at, 2, &OrbitCondition::Parameters).unwrap();
    let strobes: Vec<[f64; 2]> = (orbit.details.strobes.iter())
        .map(|u| {
            let state = map.state(u).state;
            [state[0] - OFF, state[1]]
        })
        .collect();
    println!("{strobes:?} {:?}", orbit.multipliers);
    let published = [[1.175847, -0.158646], [0.384678, 0.077491]];
    for wanted in published {
        let near = strobes
            .iter()
            .map(|s| (s[0] - wanted[0]).abs().max((s[1] - wanted[1]).abs()));
        assert!(near.fold(f64::INFINITY, f64::min) < 1e-6, "{wanted:?}");
    }
    for axis in 0..2 {
        let exact = map.by_parameter(&orbit.u, at, 2, axis).unwrap();
        let near = map.near_derivative(&orbit.u, at, 2, (axis, 1e-7)).unwrap();
        let off = exact.iter().zip(&near).map(|(a, b)| (a - b).abs());
        let (off, size) = (
            off.fold(0.0, f64::max),
            exact.iter().fold(0.0, |m: f64, a| m.max(a.abs())),
        );
        println!("derivative by axis {axis}: {off:.1e} of {size:.1e}");
        assert!(off < 1e-5 * size, "{off:e} {size:e}");
    }
    // Follow the branch over the frequency. A search from every bifurcation finds the bifurcation again.
    let span = Span {
        axis: 0,
        from: 0.6,
        to: 1.2,
    };
    let branch = follow(&mut map, &span, orbit, &StepSettings::default()).unwrap();
    for own in &branch.bifurcations {
        println!(
            "{} at {:.10} ({:?})",
            own.kind.name(),
            own.orbit.at[0],
            own.critical()
        );
        let (place, [low, high]) = (own.orbit.at[0], own.bracket);
        assert!(
            low - 1e-9 <= place && place <= high + 1e-9,
            "{place} {low} {high}"
        );
    }
    println!(
        "{} orbits, {} and {}",
        branch.orbits.len(),
        branch.ends[0],
        branch.ends[1]
    );
    assert_eq!(
        branch.ends,
        [End::Merged { period: 1 }, End::Merged { period: 1 }]
    );
    // If the branch ends at a smooth doubling of orbits of one period, the branch of those orbits has a doubling at the
    // same value.
    let mut smooth = 0;
    for own in branch.bifurcations.iter().filter(|b| b.merges().is_some()) {
        let omega = own.orbit.at[0];
        let beside = [omega + 1e-3, at[1]];
        let parent = find(
            &mut map,
            &own.orbit.u,
            beside,
            1,
            &OrbitCondition::Parameters,
        )
        .unwrap();
        let near = Span {
            axis: 0,
            from: omega - 1e-2,
            to: omega + 1e-2,
        };
        let parents = follow(&mut map, &near, parent, &StepSettings::default()).unwrap();
        let doublings = parents.bifurcations.iter();
        for doubling in doublings.filter(|b| b.kind == Kind::PeriodDoubling) {
            let apart = (doubling.orbit.at[0] - omega).abs();
            println!("merging at {omega:.10}, doubling {apart:.1e} away");
            assert!(apart < 1e-8, "{apart:e}");
            smooth += 1;
        }
    }
    assert!(smooth > 0);
    // If multipliers jump instead of crossing, a graze is near.
    let places = |wanted: fn(&Kind) -> bool| -> Vec<f64> {
        let all = branch.bifurcations.iter().filter(move |b| wanted(&b.kind));
        all.map(|b| b.orbit.at[0]).collect()
    };
    let grazes = places(|kind| matches!(kind, Kind::Graze { .. }));
    assert!(grazes.len() >= 3, "{grazes:?}");
    for jump in places(|kind| *kind == Kind::Jump) {
        assert!(
            grazes.iter().any(|graze| (graze - jump).abs() < 6e-3),
            "{jump}: {grazes:?}"
        );
    }
}

/// The coupled modes change with the speed. A map that was made at another speed has the derivatives of its images
/// nevertheless, and follows an orbit to the same one that is found there.
#[test]
fn coordinates_keep_their_meaning_where_modes_are_coupled() {
    let family = Stopped {
        damping: 0.02,
        stop: 2.0,
        whirls: true,
    };
    let (from, at) = ([0.7, 1.0], [1.2, 1.0]);
    let mut map = DriveMap::new(&family, from).unwrap();
    let first = map.model(from).unwrap().basis.clone();
    let mut state = map.model(at).unwrap().start(&InitialState::Static);
    let change = map.model(at).unwrap().basis.change_to(&first);
    assert_ne!(change, Ok(StateChange::Same));
    map.advance(at, 20, &mut state, &mut ()).unwrap();
    let u = map.coordinates(&state.state);
    let image = map.image(&u, at, 1).unwrap();
    assert!(map.details(&u, at, 1).unwrap().touches.sequence.len() > 1);
    let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let check = |exact: &[f64], moved: &mut dyn FnMut(f64) -> Vec<f64>| {
        let h = 1e-7;
        let [more, less] = [h, -h].map(moved);
        let pairs = more.iter().zip(&less).zip(exact);
        let off: Vec<f64> = pairs.map(|((a, b), e)| (a - b) / (2.0 * h) - e).collect();
        println!("{:.1e} of {:.1e}", largest(&off), largest(exact));
        assert!(largest(&off) < 1e-7 * largest(exact).max(1.0));
    };
    for j in 0..u.len() {
        let column: Vec<f64> = image.monodromy.col(j).iter().copied().collect();
        check(&column, &mut |h| {
            let mut moved = u.clone();
            moved[j] += h;
            map.image(&moved, at, 1).unwrap().end
        });
    }
    for axis in 0..2 {
        let exact = map.by_parameter(&u, at, 1, axis).unwrap();
        check(&exact, &mut |h| {
            let mut there = at;
            there[axis] += h;
            map.image(&u, there, 1).unwrap().end
        });
    }
    let span = Span {
        axis: 0,
        from: from[0],
        to: at[0],
    };
    let rest = map.model(from).unwrap().start(&InitialState::Static);
    let guess = map.coordinates(&rest.state);
    let orbit = find(&mut map, &guess, from, 1, &OrbitCondition::Parameters).unwrap();
    let branch = follow(&mut map, &span, orbit, &StepSettings::default()).unwrap();
    let last = branch
        .orbits
        .iter()
        .max_by(|a, b| a.at[0].total_cmp(&b.at[0]));
    let last = last.unwrap();
    let mut local = DriveMap::new(&family, last.at).unwrap();
    map.model(last.at).unwrap();
    let guess = local.coordinates(&map.state(&last.u).state);
    let found = find(&mut local, &guess, last.at, 1, &OrbitCondition::Parameters).unwrap();
    println!(
        "{} orbits to {:?}: {:?}",
        branch.orbits.len(),
        last.at,
        last.multipliers
    );
    assert!(last.at[0] > from[0] + 0.1);
    for (a, b) in last.multipliers.iter().zip(&found.multipliers) {
        assert!((a - b).norm() < 1e-8, "{a} {b}");
    }
    for half in 0..2 {
        let pairs = last.details.start[half]
            .iter()
            .zip(&found.details.start[half]);
        assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-8);
    }
}

/// The orbit without contact grazes at the value of the closed form, over the amplitude and along the whole curve in
/// (ω, A).
#[test]
fn grazing_is_where_the_closed_form_says() {
    let damping = 0.05;
    let family = Stopped {
        damping,
        stop: 100.0,
        whirls: false,
    };
    for omega in [0.7, 1.0, 1.3] {
        let mut map = DriveMap::new(&family, [omega, 0.01]).unwrap();
        let state = map
            .model([omega, 0.01])
            .unwrap()
            .start(&InitialState::Static);
        let guess = map.coordinates(&state.state);
        let first = find(
            &mut map,
            &guess,
            [omega, 0.01],
            1,
            &OrbitCondition::Parameters,
        )
        .unwrap();
        let span = Span {
            axis: 1,
            from: 0.0,
            to: 2.0 * grazing(omega, damping),
        };
        let branch = follow(&mut map, &span, first, &StepSettings::default()).unwrap();
        let graze = branch
            .bifurcations
            .iter()
            .find(|b| matches!(b.kind, Kind::Graze { .. }))
            .unwrap();
        let off = graze.orbit.at[1] / grazing(omega, damping) - 1.0;
        println!(
            "omega {omega}: {off:.1e}, {} and {}",
            branch.ends[0], branch.ends[1]
        );
        assert!(off.abs() < 1e-10, "{off:e}");
        assert_eq!(branch.ends[0], End::Interval);
        if omega == 1.0 {
            assert!((grazing(omega, damping) - 0.1).abs() < 1e-15);
            let plane = CurveSettings {
                from: [0.5, 0.0],
                to: [1.5, 1.5],
                longest: 0.05,
                most: 500,
            };
            let locus = curve::follow(&mut map, &plane, graze).unwrap();
            let worst = (locus.points.iter())
                .map(|point| (point.orbit.at[1] / grazing(point.orbit.at[0], damping) - 1.0).abs())
                .fold(0.0, f64::max);
            println!(
                "locus: {} points, {worst:.1e}, ends {:?}",
                locus.points.len(),
                locus.ends
            );
            assert!(worst < 1e-10 && locus.points.len() > 20, "{worst:e}");
            let reach = locus.points.iter().map(|p| p.orbit.at[0]);
            let (low, high) =
                reach.fold((f64::INFINITY, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
            assert!(low < 0.55 && high > 1.45, "{low} {high}");
        }
    }
}

/// A mass on a spring of the mesh under load L and force A: contact is lost at the load for which the linear response
/// reaches back to the flank.
struct Pressed {
    /// Periods of the force per mesh cycle.
    turns: f64,
}

const PRESSED: f64 = 0.03;

impl ParametricDrive for Pressed {
    fn model(&self, [omega, load]: MapParameters) -> Result<Model, String> {
        let mut structure = ModalStructure::of_modes(&[0.5], PRESSED, &[1.0], &[1.0]);
        structure.harmonic_loads = vec![HarmonicLoad {
            name: "force".to_owned(),
            force: vec![0.2],
            turns_per_cycle: self.turns,
            phase: 0.0,
        }];
        let drive = Drive {
            half_gap: 1.0,
            mesh: Division::levels(&[2.0], &[]),
            damping: 0.1,
            friction: 0.0,
            release: Release::Deflection,
            coast: None,
            transmission_error: Vec::new(),
            torque_ripple: Vec::new(),
            further: Vec::new(),
            imposed_motion: Vec::new(),
            film: None,
            tooth_cycles: Default::default(),
        };
        let point = OperatingPoint { load, speed: omega };
        Model::new(&structure, &drive, point).map_err(|error| error.to_string())
    }

    fn derivative(&self, _: MapParameters, _: usize, _: &Basis) -> Result<ModelDerivative, String> {
        Err("none is needed".to_owned())
    }

    fn event_limit(&self) -> u32 {
        1000
    }
}

/// With a force of two periods in five mesh cycles the map repeats after five cycles.
#[test]
fn the_unit_of_a_map_is_the_period_of_what_drives_it() {
    for (turns, unit) in [(1.0, 1), (0.4, 5), (1.25, 4)] {
        let pressed = Pressed { turns };
        let map = DriveMap::new(&pressed, [0.9, 3.0]);
        assert_eq!(map.unwrap().unit(), unit);
    }
}

/// `x'' + (2ζω + c) x' + (ω² + k) x = L + k b + 0.2 cos Ωt`: the smallest x is b under
/// `L = ω² b + |H| 0.2 (ω² + k)`.
#[test]
fn onset_of_rattle_is_where_the_closed_form_says() {
    let map_at = [0.9, 3.0];
    let mut map = DriveMap::new(&Pressed { turns: 1.0 }, map_at).unwrap();
    // With this number of values, the peak of some is near the border of two windows.
    for omega in (0..150).map(|i| 0.4 + 0.016 * f64::from(i)) {
        let found = onset(&mut map, [omega, 0.0], 1).unwrap().unwrap();
        let (spring, rate) = (0.25 + 2.0, 2.0 * PRESSED * 0.5 + 0.1);
        let answer = 0.2 / (spring - omega * omega).hypot(rate * omega);
        let exact = 0.25 + spring * answer;
        assert!(
            (found.at[1] / exact - 1.0).abs() < 1e-10,
            "{omega}: {}",
            found.at[1]
        );
        assert!(found.radius < 1.0);
    }
    assert_eq!(map.unit(), 1);
}
