//! Comparison with closed forms, and the observed order.

use super::*;
use crate::model::{Division, Drive, MeshHarmonic, OperatingPoint};
use crate::structure::ModalStructure;

/// One rigid degree of freedom with `Σ w g = 4`, the half gap 1 and the mesh period 2π.
fn one_degree(stiffness: f64, damping: f64, error: Vec<MeshHarmonic>) -> Model {
    let structure = ModalStructure {
        mesh: vec![2.0],
        ..ModalStructure::of_modes(&[0.0], 0.0, &[1.0], &[1.0])
    };
    let drive = Drive {
        mesh: Division::levels(&[stiffness; 7], &[]),
        damping,
        transmission_error: error,
        ..Drive::constant(1.0, stiffness)
    };
    let point = OperatingPoint {
        load: 0.0,
        speed: 1.0,
    };
    Model::new(&structure, &drive, point).unwrap()
}

/// Without load and damping, the mass flies from flank to flank: δ − b = 2 cos 4t, then 1/4 s of flight, then
/// half a period on the other flank, and so on.
#[test]
fn bouncing_between_two_flanks_is_the_closed_form_to_thirty_digits() {
    let model = one_degree(4.0, 0.0, Vec::new());
    let start = TrajectoryState::new(&model, vec![1.5, 0.0], 0);
    assert_eq!(start.contact, ActiveSet::DRIVE);
    let passage = Extended::new(&model).advance(&start, 1).unwrap();

    let half_turn = DoubleDouble::HALF_PI * 0.5;
    let flight = DoubleDouble::exact(0.25);
    let mut time = half_turn * 0.5;
    let mut known = Vec::new();
    let mut states = [
        ActiveSet::DRIVE,
        ActiveSet::FREE,
        ActiveSet::COAST,
        ActiveSet::FREE,
    ]
    .into_iter()
    .cycle()
    .peekable();
    while time.value() < model.period() {
        let from = states.next().unwrap();
        known.push((time, from, *states.peek().unwrap()));
        time += if from.touching() { flight } else { half_turn };
    }
    assert!(known.len() > 10);
    assert_eq!(passage.crossings.len(), known.len());
    for (found, (time, from, to)) in passage.crossings.iter().zip(&known) {
        let error = (found.time - *time).abs().value();
        assert!(error < 1e-29, "{error:e} at {}", time.value());
        assert_eq!((found.from, found.to), (*from, *to));
    }
    // Energy: ½ v² + ½ k (δ − s b)²; 8 at the start.
    let (q, v) = (passage.state[0], passage.state[1]);
    let sign = DoubleDouble::exact(passage.contact.sign());
    let compression = if passage.contact.touching() { q * 2.0 - sign } else { DoubleDouble::ZERO };
    let energy = v * v * 0.5 + compression * compression * 2.0;
    assert!((energy - DoubleDouble::exact(8.0)).abs().value() < 1e-28);
}

/// A damped oscillator with excitation by the transmission error, in constant contact: the steady response
/// `Re (A e^{i t})` is a closed form.
#[test]
fn forced_response_in_contact_is_the_closed_form_to_thirty_digits() {
    // δ'' + 4 c δ' + 4 k (δ − b) = −e'', with e = cos(t)/10: −e'' = cos(t)/10, and
    // δ − b = Re (a − i β) e^{it} with (4k − 1 + 4 c i)(a − i β) = 1/10.
    let (k, c) = (4.0, 0.125);
    let model = one_degree(k, c, vec![MeshHarmonic::new(1, 0.1, 0.0)]);
    let real = DoubleDouble::exact(4.0 * k - 1.0);
    let imaginary = DoubleDouble::exact(4.0 * c);
    let scale = DoubleDouble::exact(0.1) / (real * real + imaginary * imaginary);
    let (a, beta) = (real * scale, imaginary * scale);
    // Without load the mass would leave the flank. The test therefore prescribes the contact state of one
    // step.
    let e = DoubleDouble::exact(0.1);
    let q = (DoubleDouble::ONE + a + e) * 0.5;
    let v = beta * 0.5;
    let structure = Structure::new(&model);
    let instant = Instant {
        cycle: 0,
        time: DoubleDouble::ZERO,
        passed: [DoubleDouble::exact(0.25), DoubleDouble::ZERO],
        segments: &model.segments_at(0, 0.0),
        contact: ActiveSet::DRIVE,
    };
    let length = DoubleDouble::exact(0.25);
    let series = structure.expand(&model, &instant, &[q, v], length, ORDER);
    for fraction in [0.3, 1.0] {
        let fraction = DoubleDouble::exact(fraction);
        let (sin, cos) = (length * fraction).sin_cos();
        let known = DoubleDouble::ONE + a * cos + beta * sin;
        let (found, _) = root::evaluate(&series.deflections[0], fraction);
        let error = (found - known).abs().value();
        assert!(error < 1e-30, "{error:e}");
    }
}

/// The error over a cycle with events falls with the power `order` of the step.
#[test]
fn observed_order_is_the_number_of_terms() {
    let model = one_degree(4.0, 0.125, vec![MeshHarmonic::new(3, 0.5, 0.2)]);
    let start = TrajectoryState::new(&model, vec![1.5, 0.0], 0);
    let exact = Extended::new(&model).advance(&start, 1).unwrap();
    assert!(exact.crossings.len() >= 4, "it does not bounce");
    for order in [6, 9, 12] {
        let error = |factor| {
            let passage = Extended::with_order(&model, order)
                .refined(factor)
                .advance(&start, 1)
                .unwrap();
            assert_eq!(passage.crossings.len(), exact.crossings.len());
            (passage.state[1] - exact.state[1]).abs().value()
        };
        let observed = (error(4) / error(16)).log2() / 2.0;
        assert!(
            (observed - order as f64).abs() < 0.5,
            "order {order}: {observed}"
        );
    }
}

#[test]
fn shorter_steps_leave_the_last_digits_only() {
    let model = one_degree(4.0, 0.125, vec![MeshHarmonic::new(3, 0.5, 0.2)]);
    let start = TrajectoryState::new(&model, vec![1.5, 0.0], 0);
    let usual = Extended::new(&model).advance(&start, 2).unwrap();
    let fine = Extended::new(&model).refined(3).advance(&start, 2).unwrap();
    for (a, b) in usual.state.iter().zip(&fine.state) {
        assert!((*a - *b).abs().value() < 1e-27);
    }
}

#[test]
fn non_finite_states_are_reported() {
    let model = one_degree(4.0, 0.0, Vec::new());
    let nan = TrajectoryState::new(&model, vec![f64::NAN, 0.0], 7);
    assert_eq!(
        Extended::new(&model).advance(&nan, 1),
        Err(ReferenceError::NonFinite { cycle: 7 })
    );
}
