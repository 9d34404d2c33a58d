//! Does the kernel skip unnecessary work? Its counters show its work; and its results with windows of any length agree
//! with the reference.

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::{advance, advance_with, settled, volterra};
use common::{drives, state_difference};
use gearatlas::model::{ActiveSet, Division, Drive, InitialState, Model, TrajectoryState};
use gearatlas::propagate::{Counters, Kernel, Tangents, Volterra};
use gearatlas::reference::Reference;

/// The work of some cycles with `tangents` tangents.
fn work(model: &Model, start: &TrajectoryState, cycles: u64, tangents: usize) -> Counters {
    let kernel = volterra(model);
    let mut workspace = kernel.workspace();
    let mut trajectory = start.clone();
    let mut tangents = Tangents::zeros(model.modes(), tangents);
    let mut counters = Counters::default();
    for _ in 0..cycles {
        kernel
            .advance_cycle(
                &mut trajectory,
                &mut tangents,
                &mut workspace,
                &mut (),
                &mut counters,
            )
            .unwrap();
    }
    counters
}

/// Every tangent is moved once per window, and does not change the work for the trajectory.
#[test]
fn tangents_cost_windows_of_their_own_and_nothing_else() {
    for (name, case) in drives() {
        let model = common::model(&case);
        let start = settled(&model, 40);
        let alone = work(&model, &start, 6, 0);
        assert!(alone.events > 6, "{name} does not rattle");
        assert_eq!(alone.tangent_windows, 0, "{name}");
        for count in [1, 8] {
            let with = work(&model, &start, 6, count);
            // Fewer windows move tangents than are solved, because an event at their start ended some.
            let moved = with.tangent_windows / count as u64;
            assert_eq!(with.tangent_windows, moved * count as u64);
            assert!(alone.partial_windows < moved && moved <= alone.windows);
            let rest = Counters {
                tangent_windows: 0,
                ..with
            };
            assert_eq!(rest, alone, "{name}");
        }
    }
}

/// Permanent contact needs the windows of its cells, whole and certified at once.
#[test]
fn constant_contact_is_not_cut_or_searched() {
    for (name, mut case) in drives() {
        case.1.mesh = Division::levels(&[4e8], &[]);
        case.1.transmission_error.clear();
        case.1.torque_ripple.clear();
        case.2.load = 1.0;
        for transitions in [vec![], vec![1.0 / 2f64.sqrt()]] {
            let drive = Drive {
                mesh: Division::levels(&[4e8, 3.9e8][..=transitions.len()], &transitions),
                ..case.1.clone()
            };
            let model = Model::new(&case.0, &drive, case.2).unwrap();
            let start = model.start(&InitialState::Static);
            let cells = volterra(&model).windows_per_cycle() as u64;
            let counters = work(&model, &start, 10, 0);
            let expected = Counters {
                cycles: 10,
                windows: 10 * cells,
                certified: 10 * cells,
                ..Counters::default()
            };
            assert_eq!(counters, expected, "{name}");
        }
    }
}

/// Free flight crosses the segments of the mesh uncut: it has as many windows with sixty levels as with one, and the
/// same trajectory.
#[test]
fn free_flight_does_not_see_the_mesh() {
    let (structure, drive, point) = common::one_degree();
    let quiet = Drive {
        transmission_error: Vec::new(),
        ..drive
    };
    let levels =
        |count: u32| -> Vec<f64> { (0..count).map(|i| 3e8 + 1e6 * f64::from(i)).collect() };
    let flights = [(1, vec![]), (60, vec![]), (2, vec![0.37])].map(|(count, transitions)| {
        let drive = Drive {
            mesh: Division::levels(&levels(count), &transitions),
            ..quiet.clone()
        };
        let model = Model::new(&structure, &drive, point).unwrap();
        // The start is in the middle of the gap, at rest.
        let mut start = model.start(&InitialState::Rest);
        start.state[0] = -0.5 * model.half_gap / structure.mesh[0];
        start.contact = ActiveSet::FREE;
        let (end, counters) = advance_with(&volterra(&model), &start, 1, &mut ());
        assert_eq!(counters.events, 0);
        assert_eq!(counters.partial_windows, 0);
        assert_eq!(counters.bisections, 0);
        (
            end.state,
            counters.windows,
            volterra(&model).windows_per_cycle(),
        )
    });
    for (state, windows, cells) in &flights {
        assert_eq!(*windows, *cells as u64);
        for (a, b) in state.iter().zip(&flights[0].0) {
            assert!((a - b).abs() <= 1e-13 * b.abs(), "{a:e} {b:e}");
        }
    }
}

/// Windows of many lengths agree with the reference, within their tolerance.
#[test]
fn every_choice_of_windows_is_the_reference() {
    for (name, case) in drives() {
        for transitions in [vec![0.6], vec![0.6180339887]] {
            let drive = Drive {
                mesh: Division::levels(&[4.444e8, 3.333e8], &transitions),
                ..case.1.clone()
            };
            let model = Model::new(&case.0, &drive, case.2).unwrap();
            let mut start = settled(&model, 40);
            let mut counts = Vec::new();
            for tolerance in [1e-4, 1e-8, 1e-12, f64::EPSILON, 1e-24, 1e-40, 1e-60] {
                let kernel = Volterra::new(&model, tolerance, 10_000);
                counts.push(kernel.windows_per_cycle());
                let exact = Reference::new(&model).advance(&start, 1).unwrap();
                let end = advance(&kernel, &start, 1);
                assert_eq!(end.contact, exact.end.contact);
                let difference = state_difference(&model, &end.state, &exact.end.state);
                println!(
                    "{name}, {tolerance:e}: {} windows, {difference:.1e}",
                    counts.last().unwrap()
                );
                // Hundreds of windows have hundreds of roundings.
                let round_off = 1e-13 * (1.0 + counts.last().map_or(0.0, |c| *c as f64) / 50.0);
                assert!(
                    difference < round_off.max(tolerance),
                    "{name}, {tolerance:e}: {difference:e}"
                );
                start = end;
            }
            assert!(counts.is_sorted());
            counts.dedup();
            assert!(counts.len() >= 3, "{name}: {counts:?}");
        }
    }
}
