//! Rigid stops compared with an independent integrator.

use crate::common::advance::{Events, advance_with, volterra};
use gearatlas::analysis::EnergyAudit;
use gearatlas::model::{Drive, Model, OperatingPoint, TrajectoryState};
use gearatlas::numerics::random::Stream;
use gearatlas::propagate::{Counters, Event, Kernel, Tangents};
use gearatlas::reference::{Crossing, Extended, Reference, ReferenceError};
use gearatlas::structure::{
    ContactLaw, Coupling, HarmonicLoad, MeshHarmonic, ModalStructure, StructureContact,
};
use std::f64::consts::TAU;

/// A gap of the mesh larger than all motions in these tests.
const WIDE: f64 = 1e3;

/// Speed of impact below which impacts accumulate: each integrator ends them differently.
const SLOW: f64 = 1e-4;

/// Difference of states, as a part of their size, after impacts that alternate between stops. The other integrator
/// resolves their times by the round-off of the position divided by the speed.
const AT_SEVERAL: f64 = 1e-8;

/// Events of a cycle above which impacts alternate between stops.
const ALTERNATE: usize = 200;

/// Time \[s\] below which a rest that ends belongs to impacts that accumulate at several stops.
const SHORT: f64 = 1e-6;

/// A structure of one to four modes with one to three rigid stops, every other one with a spring as well, and every
/// third one with stops that move.
fn structure(number: u64, stream: &mut Stream) -> ModalStructure {
    let modes = 1 + number as usize % 4;
    let mut draw = |count: usize| -> Vec<f64> { (0..count).map(|_| stream.normal()).collect() };
    let mut frequency: Vec<f64> = draw(modes).iter().map(|x| 1.0 + 2.0 * x.abs()).collect();
    frequency.sort_by(f64::total_cmp);
    if number.is_multiple_of(5) {
        frequency[0] = 0.0;
    }
    let mut structure =
        ModalStructure::of_modes(&frequency, 0.03, &vec![1.0; modes], &vec![1.0; modes]);
    let stops = 1 + number / 4 % 3;
    for stop in 0..stops.min(modes as u64) {
        let felt = draw(modes);
        let tilt = draw(modes);
        let part = draw(2);
        let moves = MeshHarmonic::new(1 + stop as u32, 0.05 * part[0], 3.0 * part[1]);
        let law = ContactLaw {
            gap: 0.05 + 0.1 * draw(1)[0].abs(),
            error: if number.is_multiple_of(3) { vec![moves] } else { Vec::new() },
            ..ContactLaw::default()
        };
        let restitution = (0.45 * draw(1)[0].abs()).min(0.9);
        let tilted = number.is_multiple_of(7);
        let pairs = felt.iter().zip(&tilt);
        let force: Vec<f64> = pairs
            .map(|(p, t)| if tilted { p + 0.1 * t } else { *p })
            .collect();
        let own = StructureContact {
            force,
            ..StructureContact::plain(format!("stop {stop}"), felt, law)
        };
        structure
            .contacts
            .extend(own.rigid(if number.is_multiple_of(6) { 0.0 } else { restitution }));
    }
    if number.is_multiple_of(2) {
        let law = ContactLaw {
            gap: 0.08,
            stiffness: vec![(1.0, [60.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
            damping: 0.7,
            ..ContactLaw::default()
        };
        let felt = draw(modes);
        structure
            .contacts
            .push(StructureContact::plain("spring".to_owned(), felt, law));
    }
    structure.constant_load = draw(modes);
    structure.harmonic_loads = vec![HarmonicLoad {
        name: "load".to_owned(),
        force: draw(modes).iter().map(|x| 2.0 * x).collect(),
        turns_per_cycle: 1.0,
        phase: 0.3,
    }];
    structure
}

/// Compared properties of an event: time, contact, whether it closes, rate.
type Seen = (f64, usize, bool, f64);

/// Events without the accumulating impacts.
fn counted(model: &Model, events: impl Iterator<Item = Seen>) -> Vec<Seen> {
    let mut kept: Vec<Seen> = Vec::new();
    for event in events {
        if model.is_rest(event.1) {
            let last = kept.iter().rposition(|own| own.1 == event.1);
            if let Some(last) = last.filter(|last| event.0 - kept[*last].0 < SHORT) {
                kept.remove(last);
                continue;
            }
        }
        let slow = model
            .stop_of(event.1)
            .is_some_and(|stop| stop.impact == event.1)
            && event.3.abs() < SLOW;
        if !slow {
            kept.push(event);
        }
    }
    kept
}

/// Events and states agree with those of the other integrator, cycle by cycle, so that errors do not accumulate.
#[test]
fn random_stops_are_followed_as_by_another_integrator() {
    let mut stream = Stream::new(11, 0, 0);
    let mut faults: Vec<String> = Vec::new();
    let mut endless = 0;
    let (mut rests, mut impacts, mut worst, mut late) = (0, 0, 0.0_f64, 0.0_f64);
    for number in 0..100 {
        let structure = structure(number, &mut stream);
        let point = OperatingPoint {
            load: 0.0,
            speed: TAU / 2.3,
        };
        let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), point);
        // The model refuses a force so inclined that it closes its own stop.
        let Ok(model) = model else { continue };
        let kernel = volterra(&model);
        let reference = Reference::new(&model);
        let start = (0..2 * model.modes())
            .map(|_| 0.3 * stream.normal())
            .collect();
        let mut trajectory = TrajectoryState::new(&model, start, 0);
        let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
        for cycle in 0..12 {
            let from = trajectory.clone();
            let mut seen = Events::default();
            let advanced = kernel.advance_cycle(
                &mut trajectory,
                &mut Tangents::none(),
                &mut workspace,
                &mut seen,
                &mut counters,
            );
            let exact = reference.advance(&from, 1);
            if let Err(ReferenceError::Chatter { .. }) = exact
                && model.stops.len() > 1
            {
                endless += 1;
                break;
            }
            let (Ok(()), Ok(exact)) = (advanced, &exact) else {
                let fault = format!("{number} {cycle}: {advanced:?} {:?}", exact.err());
                faults.push(fault);
                break;
            };
            let of_kernel = seen
                .0
                .iter()
                .map(|own| (own.time, own.contact, own.closes(), own.rate));
            let of_other =
                |own: &Crossing| (own.time, own.contact, own.to.holds(own.contact), own.rate);
            let own = counted(&model, of_kernel);
            let other = counted(&model, exact.crossings.iter().map(of_other));
            let what = |list: &[Seen]| list.iter().map(|own| (own.1, own.2)).collect::<Vec<_>>();
            if what(&own) != what(&other) {
                let last = |list: &[Seen]| list[list.len().saturating_sub(9)..].to_vec();
                let fault = format!("{number} {cycle}: {:?} {:?}", last(&own), last(&other));
                faults.push(fault);
                break;
            }
            for (a, b) in own.iter().zip(&other) {
                late = late.max((a.0 - b.0).abs());
            }
            let size = from.state.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            let off = trajectory
                .state
                .iter()
                .zip(&exact.end.state)
                .map(|(a, b)| (a - b).abs() / size);
            let off = off.fold(0.0, f64::max);
            let limit = if model.stops.len() > 1 { AT_SEVERAL } else { 1e-11 };
            if off > limit || trajectory.contact != exact.end.contact {
                faults.push(format!("{number} {cycle}: {off:e}"));
                break;
            }
            worst = worst.max(off / limit);
            rests += own
                .iter()
                .filter(|own| model.is_rest(own.1) && own.2)
                .count();
            impacts += own
                .iter()
                .filter(|own| !model.is_rest(own.1) && own.2)
                .count();
        }
    }
    println!(
        "{impacts} impacts, {rests} rests, states off by {worst:.1e} of the limit, events by {late:.1e} s"
    );
    assert!(faults.is_empty(), "{faults:?}");
    // At several stops the impacts may not end in the arithmetic of the reference.
    assert!(endless <= 2, "{endless}");
    assert!(impacts > 1000 && rests > 200, "{impacts} {rests}");
    assert!(late < 1e-5, "{worst:e} {late:e}");
}

/// Tangents are the limits of differences of trajectories with the same events, also if the impact on one stop ends the
/// rest on another.
#[test]
fn tangents_of_several_stops_are_differences_of_trajectories() {
    let mut stream = Stream::new(29, 0, 0);
    let (mut compared, mut let_go, mut worst) = (0, 0, 0.0_f64);
    for number in (0..150).filter(|number| number % 4 > 0 && number / 4 % 3 > 0) {
        let structure = structure(number, &mut stream);
        let point = OperatingPoint {
            load: 0.0,
            speed: TAU / 2.3,
        };
        let Ok(model) = Model::new(&structure, &Drive::constant(WIDE, 1.0), point) else {
            continue;
        };
        let (kernel, size) = (volterra(&model), 2 * model.modes());
        let start = (0..size).map(|_| 0.3 * stream.normal()).collect();
        let mut from = TrajectoryState::new(&model, start, 0);
        for _ in 0..12 {
            let direction: Vec<f64> = (0..size).map(|_| stream.normal()).collect();
            let follow = |part: f64| {
                let mut end = from.clone();
                end.state
                    .iter_mut()
                    .zip(&direction)
                    .for_each(|(x, d)| *x += part * d);
                let mut tangents = Tangents::zeros(model.modes(), 1);
                tangents.vector_mut(0).copy_from_slice(&direction);
                let (mut seen, mut workspace) = (Events::default(), kernel.workspace());
                let counters = &mut Counters::default();
                (kernel.advance_cycle(
                    &mut end,
                    &mut tangents,
                    &mut workspace,
                    &mut seen,
                    counters,
                ))
                .unwrap();
                (end, tangents.vector(0).to_vec(), seen.0)
            };
            let held = model.active_constraints(from.contact).is_empty();
            let step = 1e-7;
            let [ahead, middle, behind] = [step, 0.0, -step].map(follow);
            from = middle.0.clone();
            let met = |seen: &[Event]| {
                seen.iter()
                    .map(|own| (own.contact, own.to))
                    .collect::<Vec<_>>()
            };
            if !held || met(&ahead.2) != met(&middle.2) || met(&behind.2) != met(&middle.2) {
                continue;
            }
            // The step of a damper's force frees a stop, or impacts alternate between stops until round-off hides them.
            let freed = |pair: &[Event]| {
                let frees = model.is_rest(pair[1].contact) && !pair[1].closes();
                frees && model.stop_of(pair[0].contact).is_none() && pair[0].time == pair[1].time
            };
            if middle.2.windows(2).any(freed) || middle.2.len() > ALTERNATE {
                continue;
            }
            compared += 1;
            let ends = |pair: &[Event]| {
                let frees = model.is_rest(pair[1].contact) && !pair[1].closes();
                frees && !model.is_rest(pair[0].contact)
            };
            let_go += middle.2.windows(2).filter(|pair| ends(pair)).count();
            let largest = middle.1.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            for i in 0..size {
                let difference = (ahead.0.state[i] - behind.0.state[i]) / (2.0 * step);
                worst = worst.max((difference - middle.1[i]).abs() / largest);
            }
        }
    }
    println!("{compared} cycles, {let_go} stops let go, off by {worst:.1e}");
    assert!(compared > 300 && let_go > 40, "{compared} {let_go}");
    assert!(worst < 1e-4, "{worst:e}");
}

/// Opposite stops need room between them. Crossed lines and a gap of zero leave room.
#[test]
fn opposite_stops_leave_room() {
    let built = |felt: [f64; 2], gap: f64| {
        let mut structure = ModalStructure::of_modes(&[1.0, 2.0], 0.03, &[1.0; 2], &[1.0; 2]);
        for (felt, gap) in [([1.0, 0.5], -0.2), (felt, gap)] {
            let law = ContactLaw {
                gap,
                ..ContactLaw::default()
            };
            let own = StructureContact::plain("stop".to_owned(), felt.to_vec(), law);
            structure.contacts.extend(own.rigid(0.5));
        }
        let point = OperatingPoint {
            load: 0.0,
            speed: 1.0,
        };
        Model::new(&structure, &Drive::constant(WIDE, 1.0), point).map(|_| ())
    };
    let error = built([-2.0, -1.0], 0.39).unwrap_err().to_string();
    assert!(
        error.contains("clearance between opposite rigid stops"),
        "{error}"
    );
    assert!(built([-2.0, -1.0], 0.4).is_ok());
    assert!(built([-2.0, -1.1], 0.39).is_ok());
    assert!(built([2.0, 1.0], -0.4).is_ok());
}

/// The force of a rest depends only on inputs if the mass is free, and on the deflection as an opposite stop's margin
/// does if the stiffness is 1. Still the forces and deflections of opposite stops are four quantities.
#[test]
fn forces_of_rests_are_no_deflections() {
    for frequency in [0.0, 1.0] {
        let mut structure = ModalStructure::of_modes(&[frequency], 0.0, &[1.0], &[1.0]);
        for felt in [1.0, -1.0] {
            let law = ContactLaw {
                gap: 0.5,
                ..ContactLaw::default()
            };
            let own = StructureContact::plain("stop".to_owned(), vec![felt], law);
            structure.contacts.extend(own.rigid(0.5));
        }
        let point = OperatingPoint {
            load: 0.0,
            speed: 1.0,
        };
        let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), point).unwrap();
        let line = |contact: usize| model.line(&model.contacts[contact].cycles[0].segments[0]);
        let stops = &model.stops[..];
        let mut lines: Vec<usize> = (stops.iter())
            .flat_map(|stop| [line(stop.impact), line(stop.rest())])
            .collect();
        for (stop, sign) in stops.iter().zip([1.0, -1.0]) {
            assert!(model.lines[line(stop.impact)].direct.is_empty());
            let direct = model.lines[line(stop.rest())].direct[0];
            assert_eq!(direct.map(f64::signum)[1], sign, "{frequency}: {direct:?}");
        }
        lines.sort_unstable();
        lines.dedup();
        assert_eq!(lines.len(), 4, "{frequency}");
    }
}

/// Impulses, rests and springs convert exactly the reported energy, with modal damping and with a matrix.
#[test]
fn energy_balances_through_impacts_and_rests() {
    let mut stream = Stream::new(5, 0, 0);
    let (mut hits, mut rests, mut worst) = (0, 0, 0.0_f64);
    for number in 0..24 {
        let mut structure = structure(number, &mut stream);
        let modes = structure.frequency.len();
        if number.is_multiple_of(3) {
            let diagonal = |i: usize| if i.is_multiple_of(modes + 1) { 0.15 } else { 0.02 };
            structure.coupling = Some(Coupling {
                damping: (0..modes * modes).map(diagonal).collect(),
                gyroscopic: vec![0.0; modes * modes],
                stiffness: vec![0.0; modes * modes],
            });
        }
        let point = OperatingPoint {
            load: 0.0,
            speed: TAU / 2.3,
        };
        let Ok(model) = Model::new(&structure, &Drive::constant(WIDE, 1.0), point) else {
            continue;
        };
        let start = TrajectoryState::new(&model, vec![0.0; 2 * modes], 0);
        let mut both = (EnergyAudit::new(&model), Events::default());
        let (end, _) = advance_with(&volterra(&model), &start, 30, &mut both);
        worst = worst.max(both.0.residual(&end).unwrap());
        let closing = both.1.0.iter().filter(|own| own.closes());
        let (held, hit): (Vec<&Event>, Vec<&Event>) =
            closing.partition(|own| model.is_rest(own.contact));
        (rests, hits) = (rests + held.len(), hits + hit.len());
    }
    println!("{hits} impacts, {rests} rests, residual {worst:.1e}");
    assert!(hits > 500 && rests > 50, "{hits} {rests}");
    assert!(worst < 1e-9, "{worst:e}");
}

/// Double-double numbers cannot follow accumulating impacts.
#[test]
fn the_extended_integrator_refuses_rigid_stops() {
    let mut stream = Stream::new(3, 0, 0);
    let structure = structure(1, &mut stream);
    let point = OperatingPoint {
        load: 0.0,
        speed: 1.0,
    };
    let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), point).unwrap();
    let start = TrajectoryState::new(&model, vec![0.0; 2 * model.modes()], 0);
    let refused = Extended::new(&model).advance(&start, 1).map(|_| ());
    assert_eq!(refused, Err(ReferenceError::RigidStop));
}

/// A state that a stop holds starts at rest there: the rest is no event, in whatever cycle a motion starts.
#[test]
fn a_start_at_rest_on_a_stop_has_no_event() {
    let mut structure = ModalStructure::of_modes(&[1.0], 0.05, &[1.0], &[1.0]);
    let law = ContactLaw {
        gap: -0.5,
        ..ContactLaw::default()
    };
    let own = StructureContact::plain("stop".to_owned(), vec![1.0], law);
    structure.contacts.extend(own.rigid(0.5));
    structure.constant_load = vec![1.0];
    let point = OperatingPoint {
        load: 0.0,
        speed: TAU / 2.3,
    };
    let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), point).unwrap();
    let kernel = volterra(&model);
    // At −0.5 the spring and the load press with 1.5 N. Off the stop by 1e-9, the mass hits it.
    for (start, events) in [(-0.5, 0), (-0.5 - 1e-9, 1)] {
        let start = TrajectoryState::new(&model, vec![start, 0.0], 0);
        assert_eq!(start.contact.touching(), events == 0);
        let (end, counters) = advance_with(&kernel, &start, 1, &mut ());
        assert_eq!(counters.events > 0, events > 0, "{}", counters.events);
        let again = TrajectoryState::new(&model, end.state.clone(), end.cycle);
        assert_eq!(again.contact, end.contact);
    }
    // A load of −2 N lifts it off.
    structure.constant_load = vec![-2.0];
    let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), point).unwrap();
    let start = TrajectoryState::new(&model, vec![-0.5, 0.0], 0);
    assert!(!start.contact.touching());
}
