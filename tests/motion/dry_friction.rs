//! Dry friction that sticks: pieces in closed form, an independent integrator, energy, tangents.

#![allow(clippy::unwrap_used)]

mod closed_forms;
mod pieces;

use crate::common::advance::{Events, advance_with, volterra};
use gearatlas::analysis::EnergyAudit;
use gearatlas::model::{ActiveSet, Drive, Model, ModelError, OperatingPoint, TrajectoryState};
use gearatlas::numerics::random::Stream;
use gearatlas::propagate::{Counters, Event, Kernel, Tangents};
use gearatlas::reference::{Crossing, Extended, Reference, ReferenceError};
use gearatlas::structure::{
    ContactLaw, Coupling, FrictionLaw, HarmonicLoad, ModalStructure, StructureContact,
};
use pieces::{Rubbing, State};
use std::f64::consts::TAU;

/// A gap of the mesh that no motion in these tests crosses.
const WIDE: f64 = 1e3;

impl Rubbing {
    fn structure(&self) -> ModalStructure {
        let mut structure = ModalStructure::of_modes(&[1.0], 0.5 * self.damping, &[1.0], &[1.0]);
        let law = FrictionLaw {
            force: self.force,
            static_force: self.static_force,
            belt_speed: self.belt_speed,
        };
        structure.contacts = StructureContact::dry_friction("rub", &[1.0], law).into();
        structure.harmonic_loads = vec![HarmonicLoad {
            name: "load".to_owned(),
            force: vec![self.load],
            turns_per_cycle: 1.0,
            phase: 0.0,
        }];
        structure
    }

    fn model_of(&self, structure: &ModalStructure) -> Model {
        let point = OperatingPoint {
            load: 0.0,
            speed: self.frequency,
        };
        Model::new(structure, &Drive::constant(WIDE, 1.0), point).unwrap()
    }

    fn model(&self) -> Model {
        self.model_of(&self.structure())
    }
}

/// Den Hartog's motions with one and with two stops per half cycle, and belts: all events agree with the closed forms
/// of the pieces.
#[test]
fn forced_motions_are_their_pieces() {
    let plain = Rubbing {
        damping: 0.0,
        force: 0.3,
        static_force: 0.3,
        belt_speed: 0.0,
        load: 1.0,
        frequency: 0.5,
    };
    for (name, own, stops) in [
        (
            "one stop",
            Rubbing {
                force: 0.5,
                static_force: 0.5,
                frequency: 0.7,
                load: 0.6,
                ..plain
            },
            Some(1),
        ),
        (
            "two stops",
            Rubbing {
                force: 0.15,
                static_force: 0.15,
                frequency: 0.28,
                damping: 0.1,
                ..plain
            },
            Some(2),
        ),
        (
            "no stop",
            Rubbing {
                force: 0.2,
                static_force: 0.2,
                frequency: 0.7,
                damping: 0.1,
                ..plain
            },
            Some(0),
        ),
        (
            "higher static force",
            Rubbing {
                static_force: 0.5,
                damping: 0.1,
                ..plain
            },
            None,
        ),
        (
            "belt",
            Rubbing {
                static_force: 0.6,
                belt_speed: 0.4,
                damping: 0.05,
                ..plain
            },
            None,
        ),
        (
            "fast belt",
            Rubbing {
                belt_speed: -3.0,
                damping: 0.1,
                ..plain
            },
            None,
        ),
    ] {
        let model = own.model();
        let start = TrajectoryState::new(&model, vec![1.25, 0.0], 0);
        let mut seen = Events::default();
        let cycles = 12;
        let (end, _) = advance_with(&volterra(&model), &start, cycles, &mut seen);
        let length = cycles as f64 * model.period();
        let way = own.way(&model, &start);
        let (exact, changes) = own.follow(
            State {
                time: 0.0,
                x: 1.25,
                v: 0.0,
                way,
            },
            length,
        );
        // In the kernel's list a turn is the end of one slip and the start of the other.
        let mut turned = 0;
        let mut merged: Vec<(f64, &Event)> = Vec::new();
        for event in &seen.0 {
            let time = event.cycle as f64 * model.period() + event.time;
            if merged.last().is_some_and(|(last, _)| *last == time) {
                merged.pop();
                turned += 1;
            }
            merged.push((time, event));
        }
        assert_eq!(
            merged.len(),
            changes.len(),
            "{name}: {merged:?} {changes:?}"
        );
        let late = merged
            .iter()
            .zip(&changes)
            .map(|((time, _), change)| (time - change.0).abs());
        let late = late.fold(0.0, f64::max);
        for ((_, event), (_, way)) in merged.iter().zip(&changes) {
            let own = model.frictions[0];
            let state = if *way == 0.0 { own.stick() } else { own.slip_towards(*way) };
            assert!(event.to.holds(state), "{name} {event:?} {way}");
        }
        let off = (end.state[0] - exact.x)
            .abs()
            .max((end.state[1] - exact.v).abs());
        let sticks = changes.iter().filter(|(_, way)| *way == 0.0).count();
        println!("{name}: {sticks} sticks, {turned} turns, late by {late:.1e} s, off by {off:.1e}");
        assert!(late < 1e-11 && off < 1e-12, "{name} {late:e} {off:e}");
        let late_half = changes
            .iter()
            .filter(|(time, way)| *way == 0.0 && *time > 0.5 * length);
        if let Some(stops) = stops {
            assert_eq!(late_half.count(), stops * 12, "{name}");
        }
    }
}

/// A structure with one to four modes and one to three elements of dry friction. Every other one has a spring as well.
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
    for element in 0..(1 + number / 4 % 3).min(modes as u64) {
        let felt = draw(modes);
        let part = draw(3);
        let force = 0.1 + 0.5 * part[0].abs();
        let law = FrictionLaw {
            force,
            static_force: if number.is_multiple_of(2) {
                force
            } else {
                force * (1.0 + 0.5 * part[1].abs())
            },
            belt_speed: if number.is_multiple_of(3) { 0.3 * part[2] } else { 0.0 },
        };
        let name = format!("element {element}");
        structure
            .contacts
            .extend(StructureContact::dry_friction(&name, &felt, law));
    }
    if number % 4 < 2 {
        let law = ContactLaw {
            gap: 0.08,
            stiffness: vec![(1.0, [60.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
            ..ContactLaw::default()
        };
        let felt = draw(modes);
        structure
            .contacts
            .push(StructureContact::plain("spring".to_owned(), felt, law));
    }
    structure.constant_load = draw(modes).iter().map(|x| 0.2 * x).collect();
    structure.harmonic_loads = vec![HarmonicLoad {
        name: "load".to_owned(),
        force: draw(modes).iter().map(|x| 2.0 * x).collect(),
        turns_per_cycle: 1.0,
        phase: 0.3,
    }];
    structure
}

const POINT: OperatingPoint = OperatingPoint {
    load: 0.0,
    speed: TAU / 2.3,
};

/// Times of events with the contacts closed after them. Events at the same time are merged.
fn moments(events: impl Iterator<Item = (f64, ActiveSet)>) -> Vec<(f64, ActiveSet)> {
    let mut all: Vec<(f64, ActiveSet)> = Vec::new();
    for (time, to) in events {
        match all.last_mut() {
            Some(last) if time - last.0 < 1e-9 => last.1 = to,
            _ => all.push((time, to)),
        }
    }
    all
}

/// Events and states agree with those of the other integrator, cycle by cycle, so that errors do not accumulate.
#[test]
fn random_elements_are_followed_as_by_another_integrator() {
    let mut stream = Stream::new(17, 0, 0);
    let mut faults: Vec<(usize, String)> = Vec::new();
    let (mut sticks, mut slips, mut worst, mut late) = (0, 0, 0.0_f64, 0.0_f64);
    for number in 0..120 {
        let structure = structure(number, &mut stream);
        let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), POINT).unwrap();
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
            let (Ok(()), Ok(exact)) = (advanced, &exact) else {
                let fault = format!("{number} {cycle}: {advanced:?} {:?}", exact.err());
                faults.push((model.frictions.len(), fault));
                break;
            };
            // The release of one element may release another at the same time; the order does not matter.
            let of_kernel = seen.0.iter().map(|own| (own.time, own.to));
            let of_other = |own: &Crossing| (own.time, own.to);
            let own = moments(of_kernel);
            let other = moments(exact.crossings.iter().map(of_other));
            let what = |list: &[(f64, ActiveSet)]| list.iter().map(|own| own.1).collect::<Vec<_>>();
            if what(&own) != what(&other) {
                let fault = format!("{number} {cycle}: {own:?} {other:?}");
                faults.push((model.frictions.len(), fault));
                break;
            }
            for (a, b) in own.iter().zip(&other) {
                late = late.max((a.0 - b.0).abs());
            }
            let size = from.state.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            let pairs = trajectory.state.iter().zip(&exact.end.state);
            let off = pairs.map(|(a, b)| (a - b).abs() / size).fold(0.0, f64::max);
            if off > 1e-10 || trajectory.contact != exact.end.contact {
                faults.push((model.frictions.len(), format!("{number} {cycle}: {off:e}")));
                break;
            }
            worst = worst.max(off);
            let of_friction = seen
                .0
                .iter()
                .filter(|own| model.friction_of(own.contact).is_some());
            for own in of_friction {
                let friction = model.friction_of(own.contact).unwrap();
                if own.to.holds(friction.stick()) { sticks += 1 } else { slips += 1 }
            }
        }
    }
    println!("{sticks} sticks, {slips} slips, states off by {worst:.1e}, events by {late:.1e} s");
    for (elements, fault) in &faults {
        println!("{elements} elements: {fault}");
    }
    assert!(faults.is_empty(), "{} faults", faults.len());
    assert!(sticks > 1000 && slips > 1000, "{sticks} {slips}");
    assert!(worst < 1e-11 && late < 1e-5, "{worst:e} {late:e}");
}

/// Energy balances with the reported losses by friction and the work of belts, with modal damping and with a matrix.
#[test]
fn energy_balances_through_sticks_and_slips() {
    let mut stream = Stream::new(5, 0, 0);
    let (mut events, mut worst) = (0, 0.0_f64);
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
        let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), POINT).unwrap();
        let start = TrajectoryState::new(&model, vec![0.0; 2 * modes], 0);
        let mut both = (EnergyAudit::new(&model), Events::default());
        let (end, _) = advance_with(&volterra(&model), &start, 30, &mut both);
        // An element that always sticks has no energy for a comparison.
        if both.1.0.len() > 10 {
            worst = worst.max(both.0.residual(&end).unwrap());
            events += both.1.0.len();
        }
    }
    println!("{events} events, residual {worst:.1e}");
    assert!(events > 500, "{events}");
    assert!(worst < 1e-9, "{worst:e}");
}

/// Tangents are the limits of differences of trajectories with the same events.
#[test]
fn tangents_are_differences_of_trajectories() {
    let mut stream = Stream::new(23, 0, 0);
    let (mut looked, mut worst) = (0, 0.0_f64);
    for number in 0..60 {
        let structure = structure(number, &mut stream);
        let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), POINT).unwrap();
        let kernel = volterra(&model);
        let size = 2 * model.modes();
        let start: Vec<f64> = (0..size).map(|_| 0.5 * stream.normal()).collect();
        let direction: Vec<f64> = (0..size).map(|_| stream.normal()).collect();
        let follow = |part: f64| {
            let moved = start.iter().zip(&direction).map(|(x, d)| x + part * d);
            let mut trajectory = TrajectoryState::new(&model, moved.collect(), 0);
            let mut tangents = Tangents::zeros(model.modes(), 1);
            tangents.vector_mut(0).copy_from_slice(&direction);
            let mut seen = Events::default();
            let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
            for _ in 0..2 {
                let to = (&mut trajectory, &mut tangents);
                (kernel.advance_cycle(to.0, to.1, &mut workspace, &mut seen, &mut counters))
                    .unwrap();
            }
            let events: Vec<_> = seen.0.iter().map(|own| (own.contact, own.to)).collect();
            (trajectory.state, tangents.vector(0).to_vec(), events)
        };
        let step = 1e-5;
        let [ahead, middle, behind] = [step, 0.0, -step].map(follow);
        if ahead.2 != middle.2 || behind.2 != middle.2 {
            continue;
        }
        looked += 1;
        let largest = middle.1.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for i in 0..size {
            let difference = (ahead.0[i] - behind.0[i]) / (2.0 * step);
            let off = (difference - middle.1[i]).abs() / largest;
            assert!(off < 1e-3, "{number}: {off:e} {:?}", middle.2);
            worst = worst.max(off);
        }
    }
    println!("{looked} trajectories, off by {worst:.1e}");
    assert!(looked > 40, "{looked}");
    assert!(worst < 1e-4, "{worst:e}");
}

#[test]
fn what_cannot_follow_dry_friction_says_so() {
    let mut stream = Stream::new(3, 0, 0);
    let mut structure = structure(1, &mut stream);
    let model = Model::new(&structure, &Drive::constant(WIDE, 1.0), POINT).unwrap();
    let start = TrajectoryState::new(&model, vec![0.0; 2 * model.modes()], 0);
    let refused = Extended::new(&model).advance(&start, 1).map(|_| ());
    assert_eq!(refused, Err(ReferenceError::DryFriction));
    let felt = vec![1.0; structure.frequency.len()];
    let stop = StructureContact::plain(
        "stop".to_owned(),
        felt,
        ContactLaw {
            gap: 1.0,
            ..ContactLaw::default()
        },
    );
    structure.contacts.extend(stop.rigid(0.5));
    let refused = Model::new(&structure, &Drive::constant(WIDE, 1.0), POINT).map(|_| ());
    assert_eq!(refused, Err(ModelError::FrictionWithStops));
}

/// A mass slips behind its belt towards a spring on the same line: `x = 0.3 + 0.2 cos t + 0.25 sin t` reaches its gap.
#[test]
fn a_stop_on_the_line_of_a_belt_closes_while_the_mass_slips() {
    let rubbing = Rubbing {
        damping: 0.0,
        force: 0.3,
        static_force: 0.3,
        belt_speed: 0.3,
        load: 0.0,
        frequency: 1.0,
    };
    let mut structure = rubbing.structure();
    let law = ContactLaw {
        gap: 0.6,
        stiffness: vec![(1.0, [10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
        ..ContactLaw::default()
    };
    let stop = StructureContact::plain("stop".to_owned(), vec![1.0], law);
    structure.contacts.push(stop);
    let model = rubbing.model_of(&structure);
    let start = TrajectoryState::new(&model, vec![0.5, 0.25], 0);
    let exact = Reference::new(&model).advance(&start, 1).unwrap();
    let mut seen = Events::default();
    let (end, _) = advance_with(&volterra(&model), &start, 1, &mut seen);
    let (size, lead) = (0.2_f64.hypot(0.25), 0.25_f64.atan2(0.2));
    let closes = lead - (0.3 / size).acos();
    for time in [seen.0[0].time, exact.crossings[0].time] {
        assert!((time - closes).abs() < 1e-12, "{time} {closes}");
    }
    let apart = end.state.iter().zip(&exact.end.state);
    let off = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-12, "{off:e}");
}
