#![allow(clippy::unwrap_used)]
use crate::gear::{
    FaceLaw, Flanks, MeshTable, MeshTableInputs, Relief, SegmentMeans, ToothForm, fixtures,
};
use crate::numerics::point_course::PointCourse;

/// Relief of the ends of the face: its amount and length \[m\].
const AMOUNT: f64 = 5e-6;
const LENGTH: f64 = 3e-3;

/// Means over the cycle of gears whose teeth have end relief, itself or as the same lead through points.
fn means(by_points: bool, angle: f64, torque: f64, face: FaceLaw) -> SegmentMeans {
    let relief = Relief {
        amount: AMOUNT,
        length: LENGTH,
        ..Relief::default()
    };
    let half = 10e-3;
    let points = vec![
        [-half, AMOUNT],
        [LENGTH - half, 0.0],
        [half - LENGTH, 0.0],
        [half, AMOUNT],
    ];
    let through = PointCourse {
        points,
        ..PointCourse::default()
    };
    let mut form = ToothForm {
        bore: [Some(30e-3), Some(40e-3)],
        ..ToothForm::default()
    };
    if by_points {
        form.lead_points = [through.clone(), through];
    } else {
        form.end_relief = [relief; 2];
    }
    let pair = fixtures::pair([20, 30], form);
    let inputs = MeshTableInputs {
        misalignment: vec![angle],
        torque: vec![torque],
        longest_piece: 0.25,
        tolerance: 1e-6,
        slices: 20,
        face,
        ..MeshTableInputs::of_gears(&pair)
    };
    let table = MeshTable::build(&Flanks::new(&pair).unwrap(), &inputs, &|_, _| ()).unwrap();
    table.cycle(0, 0).means([0.0, 1.0])
}

/// Relative differences in stiffness and in deflection F/k by the tangent error.
fn apart(one: &SegmentMeans, other: &SegmentMeans) -> f64 {
    let stiffness = (one.stiffness / other.stiffness - 1.0).abs();
    stiffness.max((one.tangent_error - other.tangent_error).abs() / 1e-6)
}

/// The flat middle of a relieved face lets go of its load almost at once. The table has a result there, and it is the
/// limit of little misalignment and of the same lead through points.
#[test]
fn a_flat_middle_that_lets_go_at_once_has_a_table() {
    for torque in [0.1, 50.0] {
        let aligned = means(false, 0.0, torque, FaceLaw::Coupled);
        let points = means(true, 0.0, torque, FaceLaw::Coupled);
        assert!(apart(&aligned, &points) < 1e-6, "{aligned:?} {points:?}");
        let askew = means(false, 1e-7, torque, FaceLaw::Coupled);
        assert!(apart(&aligned, &askew) < 1e-4, "{aligned:?} {askew:?}");
    }
}

/// Under a load that closes the relief, slices carry nearly the same load and their coupling does not matter.
#[test]
fn a_load_that_closes_end_relief_needs_no_coupling() {
    let [coupled, independent] =
        [FaceLaw::Coupled, FaceLaw::Independent].map(|face| means(false, 0.0, 5e3, face));
    assert!(
        apart(&coupled, &independent) < 1e-8,
        "{coupled:?} {independent:?}"
    );
}
