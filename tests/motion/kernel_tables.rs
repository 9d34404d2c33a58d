//! Tables of closed modes: do they serve every speed, and are those of another model refused?

#![allow(clippy::unwrap_used)]

use crate::common;
use common::Case;
use common::advance::{Events, advance_with, settled};
use gearatlas::model::TrajectoryState;
use gearatlas::propagate::{ClosedModes, InstructionSet, TableArray, TableError, Volterra};
use gearatlas::sweep::build::BuildError;

/// The same drive at other speeds, with other excitation of as many harmonics.
fn others(case: &Case) -> Vec<Case> {
    let scaled = [0.2, 0.5, 0.97, 1.0 + 1e-15, 2.0].map(|factor| {
        let mut case = case.clone();
        case.2.speed *= factor;
        case
    });
    let mut shaken = case.clone();
    shaken.1.transmission_error[0].amplitude *= 1.3;
    shaken.1.transmission_error[0].phase += 0.4;
    for ripple in &mut shaken.1.torque_ripple {
        ripple.amplitude *= 0.7;
    }
    scaled.into_iter().chain([shaken]).collect()
}

/// Systems of one speed are those of every other, to the last bit, and a kernel that uses them at
/// another speed follows the structured one as one with bases of its own would.
#[test]
fn bases_serve_every_speed_and_excitation() {
    for (name, case) in common::drives() {
        let own = common::model(&case);
        let arrays = ClosedModes::arrays(&own).unwrap();
        for other in others(&case) {
            let model = common::model(&other);
            assert_eq!(ClosedModes::arrays(&model).unwrap(), arrays, "{name}");
            let set = InstructionSet::best();
            let kernel = ClosedModes::of_kept(&model, 1000, &arrays, set).unwrap();
            let exact = Volterra::new(&model, f64::EPSILON, 1000);
            let mut start = settled(&model, 20);
            let mut compared = 0;
            for _ in 0..10 {
                let (mut seen, mut told) = (Events::default(), Events::default());
                let (end, _) = advance_with(&exact, &start, 1, &mut seen);
                let (found, _) = advance_with(&kernel, &start, 1, &mut told);
                let moved: Vec<f64> = start.state.iter().map(|x| x * (1.0 + 1e-9)).collect();
                let beside = TrajectoryState {
                    state: moved,
                    ..start.clone()
                };
                let (beside, _) = advance_with(&exact, &beside, 1, &mut Events::default());
                let gain: f64 = 1e9 * common::state_difference(&model, &beside.state, &end.state);
                if gain < 1e3 {
                    let off = common::state_difference(&model, &found.state, &end.state);
                    assert!(
                        off < 1e-12 * gain.max(1.0),
                        "{name} {}: {off:e} {gain:e}",
                        other.2.speed
                    );
                    assert_eq!(told.0.len(), seen.0.len(), "{name}");
                    compared += 1;
                }
                start = end;
            }
            assert!(compared > 3, "{name} {}: {compared}", other.2.speed);
        }
    }
}

/// Tables of another drive, and arrays that were cut, are refused by name.
#[test]
fn tables_of_another_model_are_refused() {
    let (two, six) = (
        common::model(&common::two_modes()),
        common::model(&common::six_modes()),
    );
    let arrays = ClosedModes::arrays(&two).unwrap();
    let of_kept = |model, arrays: &Vec<TableArray>| {
        ClosedModes::of_kept(model, 9, arrays, InstructionSet::best()).map(|_| ())
    };
    assert_eq!(of_kept(&two, &arrays), Ok(()));
    let refused = of_kept(&six, &arrays);
    assert!(
        matches!(refused, Err(TableError::Kept { .. })),
        "{refused:?}"
    );
    for (index, array) in arrays.iter().enumerate() {
        for change in [-1, 1] {
            let mut other = arrays.clone();
            let mut values = other[index].values.to_vec();
            values.resize(values.len().saturating_add_signed(change), 0.0);
            other[index].values = values[..].into();
            let refused = of_kept(&two, &other);
            assert_eq!(refused, Err(TableError::Kept { name: array.name }));
        }
    }
}

/// A refusal names the structured kernel where it fits the model, and says so where it does not.
#[test]
fn advice_is_checked_before_it_is_given() {
    let mut case = common::one_degree();
    let model = common::model(&case);
    let told = BuildError::tables(TableError::VaryingStiffness, &model).to_string();
    assert!(
        told.contains("or set run.kernel = \"volterra\", which"),
        "{told}"
    );
    // Too slow for either: ten hours a tooth.
    case.0 = common::structure(&[0.0], 0.0, &[1.0], &[1.0]);
    case.2.speed = 1e-5;
    let slow = common::model(&case);
    let told = BuildError::tables(TableError::VaryingStiffness, &slow).to_string();
    assert!(told.contains("does not help"), "{told}");
    // Damaged files are no fault of the model.
    let told = BuildError::tables(TableError::Kept { name: "a" }, &slow).to_string();
    assert!(!told.contains("volterra"), "{told}");
}
