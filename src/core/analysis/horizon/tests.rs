use super::measure::*;
use super::*;
use crate::numerics::random::Stream;

#[test]
fn lengths_climb_to_the_longest() {
    assert_eq!(ladder(1), [1]);
    assert_eq!(ladder(60), [1, 2, 5, 10, 20, 50, 60]);
    assert_eq!(ladder(100), [1, 2, 5, 10, 20, 50, 100]);
}

/// Lines of slope 1/2 with different starts. Their crossings and the errors of these are known in closed
/// form.
#[test]
fn a_crossing_and_its_error_are_those_of_the_starts() {
    let starts = [0.0, 1.0, 2.0, 4.0];
    let curves: Vec<Vec<f64>> = starts
        .iter()
        .map(|start| (0..40).map(|n| start + 0.5 * f64::from(n)).collect())
        .collect();
    let crossing = Crossing::of(&curves, 10.1);
    // The mean start is 1.75. The slope is 1/2, so the crossing moves by twice a change of the start.
    assert!((crossing.place.unwrap() - 2.0 * (10.1 - 1.75)).abs() < 1e-12);
    let deviation = (starts.map(|s| (s - 1.75f64).powi(2)).iter().sum::<f64>() / 3.0).sqrt();
    assert!((crossing.stderr.unwrap() - 2.0 * deviation / 2.0).abs() < 1e-12);
    assert_eq!(Crossing::of(&curves, 1.0).place, Some(0.0));
    let never = Crossing::of(&curves, 1e3);
    assert_eq!([never.place, never.stderr], [None, None]);
}

#[test]
fn independent_values_average_with_the_square_root() {
    let mut stream = Stream::new(3, 4, 5);
    let values: Vec<f64> = (0..64_000).map(|_| 7.0 + 2.0 * stream.normal()).collect();
    let measures: Vec<HorizonMeasure> = ladder(400)
        .into_iter()
        .map(|n| {
            let (value, spread) = spread(&values, n as usize);
            let samples = values.len() as u64 / n;
            let exact = 2.0 / (n as f64).sqrt();
            let doubt = 4.0 / (2.0 * (samples - 1) as f64).sqrt();
            assert!((spread / exact - 1.0).abs() < doubt, "{n}: {spread}");
            assert!((value - 7.0).abs() < 0.04);
            HorizonMeasure {
                quantity: HorizonQuantity::Force,
                cycles: n,
                value,
                spread,
                samples,
            }
        })
        .collect();
    let exponent = decay(measures.iter()).unwrap();
    assert!((exponent + 0.5).abs() < 0.03, "{exponent}");
    assert_eq!(decay(measures[..2].iter()), None);
}

/// The distance is the shortest one with at most 256 states, rounded up to a multiple of up to twelve periods of the
/// excitation. The multiple is the largest that leaves enough states.
#[test]
fn strobe_states_have_one_phase_and_one_band() {
    assert_eq!(stride(6400, 1), 36);
    assert_eq!(stride(6400, 15), 180);
    assert_eq!(stride(6400, 100), 200);
    assert_eq!(stride(200, 1), 6);
    // Thirty periods of the excitation are not enough.
    assert_eq!(stride(21_000, 700), 83);
}
