//! Dense tables refuse a model that they cannot represent, and the message says why.

use crate::common;
use gearatlas::model::{Division, FlankError, Model, Release};
use gearatlas::propagate::TableError;
use gearatlas_paper::kernels::{DenseError, Dyadic, Spectral};

/// The model of a changed drive with six modes.
fn changed(change: impl Fn(&mut common::Case)) -> Model {
    let mut case = common::six_modes();
    change(&mut case);
    common::model(&case)
}

#[test]
fn contacts_that_let_go_by_force_are_refused() {
    let model = changed(|case| case.1.release = Release::Force);
    let refused = Dyadic::new(&model, 60, 100).err();
    assert_eq!(refused, Some(TableError::Release.into()));
}

#[test]
fn an_error_of_loaded_flanks_is_refused() {
    let model = changed(|case| {
        case.1.mesh[0].error = FlankError::series([1e-6, 3e-7, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    });
    let refused = Dyadic::new(&model, 60, 1000).map(|_| ()).unwrap_err();
    assert_eq!(refused, TableError::FlankError.into());
    let message = refused.to_string();
    assert!(message.contains("excitation.table_harmonics"), "{message}");
}

/// A critically damped contact has one eigenvector; nine hours per tooth need too many cells.
#[test]
fn what_is_wrong_is_said() {
    let mut case = common::one_degree();
    case.0 = common::structure(&[0.0], 0.0, &[1.0], &[1.0]);
    case.1.mesh = Division::levels(&[4e8], &[]);
    case.1.damping = 4e4;
    let critical = common::model(&case);
    let refused = Spectral::new(&critical, 60, 9, None)
        .map(|_| ())
        .unwrap_err();
    let message = refused.to_string();
    assert!(message.contains("nearly parallel"), "{message}");
    case.2.speed = 1e-5;
    let slow = common::model(&case);
    let refused = Dyadic::new(&slow, 60, 9).map(|_| ()).unwrap_err();
    assert!(
        matches!(refused, DenseError::TooManyCells { .. }),
        "{refused:?}"
    );
    let message = refused.to_string();
    assert!(message.contains("raise the speed"), "{message}");
}
