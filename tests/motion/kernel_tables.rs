//! Tables of closed modes: are they valid for every speed, and are those of another model refused?

#![allow(clippy::unwrap_used)]

use crate::common;
use common::advance::follows_volterra;
use gearatlas::propagate::{ClosedModes, InstructionSet, TableArray, TableError};
use gearatlas::sweep::build::BuildError;

/// Tables are bitwise equal at every speed. A kernel that uses them at another speed follows the structured one as well
/// as with new tables.
#[test]
fn bases_serve_every_speed_and_excitation() {
    for (name, case) in common::drives() {
        let own = common::model(&case);
        let arrays = ClosedModes::arrays(&own).unwrap();
        for other in common::other_speeds(&case) {
            let model = common::model(&other);
            assert_eq!(ClosedModes::arrays(&model).unwrap(), arrays, "{name}");
            let set = InstructionSet::best();
            let kernel = ClosedModes::from_kept(&model, 1000, &arrays, set).unwrap();
            let name = format!("{name} {}", other.2.speed);
            follows_volterra(&name, &model, &kernel);
        }
    }
}

/// Tables of another drive, and truncated arrays, are refused by name.
#[test]
fn tables_of_another_model_are_refused() {
    let (two, six) = (
        common::model(&common::two_modes()),
        common::model(&common::six_modes()),
    );
    let arrays = ClosedModes::arrays(&two).unwrap();
    let from_kept = |model, arrays: &Vec<TableArray>| {
        ClosedModes::from_kept(model, 9, arrays, InstructionSet::best()).map(|_| ())
    };
    assert_eq!(from_kept(&two, &arrays), Ok(()));
    let refused = from_kept(&six, &arrays);
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
            let refused = from_kept(&two, &other);
            assert_eq!(refused, Err(TableError::Kept { name: array.name }));
        }
    }
}

/// A refusal suggests the structured kernel if it supports the model, and says so if it does not.
#[test]
fn advice_is_checked_before_it_is_given() {
    let mut case = common::one_degree();
    let model = common::model(&case);
    let told = BuildError::tables(TableError::VaryingStiffness, &model).to_string();
    assert!(
        told.contains("or set run.kernel = \"volterra\", which"),
        "{told}"
    );
    // A cycle of ten hours per tooth is too slow for either kernel.
    case.0 = common::structure(&[0.0], 0.0, &[1.0], &[1.0]);
    case.2.speed = 1e-5;
    let slow = common::model(&case);
    let told = BuildError::tables(TableError::VaryingStiffness, &slow).to_string();
    assert!(told.contains("does not help"), "{told}");
    // Damaged files are not the fault of the model.
    let told = BuildError::tables(TableError::Kept { name: "a" }, &slow).to_string();
    assert!(!told.contains("volterra"), "{told}");
}
