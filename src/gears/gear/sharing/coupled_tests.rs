#![allow(clippy::unwrap_used)]
use super::*;
use std::f64::consts::PI;

const WIDTH: f64 = 20e-3;
/// Compliance of teeth and bodies under a uniform load, and that of the contact \[m²/N\].
const EVEN: f64 = 4e-11;
const CONTACT: f64 = 6e-12;

fn face(slices: usize) -> Face {
    Face {
        width: WIDTH,
        slices,
    }
}

/// One pair with different compliances per wave, misaligned by an angle.
fn one(compliance: impl Fn(usize) -> f64, waves: usize, slices: usize, angle: f64) -> Coupled {
    let diagonal = Mat::from_fn(
        waves,
        waves,
        |i, j| if i == j { compliance(i) } else { 0.0 },
    );
    let gap = |border: usize| angle * face(slices).border(border);
    let gaps = vec![(0..=slices).map(gap).collect()];
    Coupled::of(diagonal, waves, vec![CONTACT], gaps, face(slices), true).unwrap()
}

/// Load centroid \[m\], loaded length \[m\], force \[N\] and stiffness \[N/m\].
fn figures(coupled: &Coupled, force: f64) -> [f64; 4] {
    let solution = coupled.solve(force);
    let pair = &coupled.pairs(&solution)[0];
    [
        pair.moment / pair.load,
        pair.loaded * WIDTH,
        pair.load,
        solution.stiffness,
    ]
}

/// A strip with the bending stiffness 1/c and the twisting stiffness l²/c, ends free, loaded all along by a wedge:
/// `d − l² d″ = c (x − ε z − d)/h` has `d = β (x − ε z) + β ε sinh κz/(κ cosh κb/2)`, `β = c/(c + h)` and
/// `κ² l² = 1 + c/h`. The error falls with the fifth power of the number of waves.
#[test]
fn a_wedge_on_a_strip_has_hyperbolic_sines() {
    let (length, angle, force) = (4e-3, 2e-5, 2e3);
    let kappa = (1.0 + EVEN / CONTACT).sqrt() / length;
    let half = 0.5 * WIDTH;
    // ∫ z q dz for q = (x − ε z − d)/h.
    let beta = EVEN / (EVEN + CONTACT);
    let third = 2.0 * half.powi(3) / 3.0;
    let hyperbolic = 2.0 * (half - (kappa * half).tanh() / kappa) / (kappa * kappa);
    let moment = -angle * ((1.0 - beta) * third + beta * hyperbolic) / CONTACT;
    let error = |waves: usize| {
        let strip = |n: usize| EVEN / (1.0 + (n as f64 * PI * length / WIDTH).powi(2));
        let [centre, loaded, load, _] = figures(&one(strip, waves, 1, angle), force);
        assert!((loaded / WIDTH - 1.0).abs() < 1e-12);
        assert!((load / force - 1.0).abs() < 1e-12);
        (centre * force / moment - 1.0).abs()
    };
    let errors = [8, 16, 32].map(error);
    assert!(errors[0] < 3e-4, "{errors:?}");
    for pair in errors.windows(2) {
        assert!((20.0..40.0).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

/// Teeth that are compliant to a uniform load but do not twist: only the contact closes the wedge,
/// `½ ε ℓ²/h = F`.
#[test]
fn stiff_teeth_leave_a_wedge_to_the_contact() {
    let (angle, force) = (1e-3, 2e3);
    let stiff = |n: usize| if n == 0 { EVEN } else { 1e-9 * EVEN };
    let length = (2.0 * force * CONTACT / angle).sqrt();
    for (sign, slices) in [(1.0, 1), (-1.0, 7)] {
        let [centre, loaded, _, _] = figures(&one(stiff, 6, slices, sign * angle), force);
        assert!((loaded / length - 1.0).abs() < 1e-6, "{loaded}");
        let exact = -sign * (0.5 * WIDTH - length / 3.0);
        assert!((centre / exact - 1.0).abs() < 1e-6, "{centre}");
    }
}

/// The slices of a straight gap only divide the output.
#[test]
fn the_number_of_slices_does_not_matter_to_a_straight_gap() {
    let falling = |n: usize| EVEN / (1.0 + (n * n) as f64);
    for angle in [5e-5, 4e-4, -2e-3] {
        let of = |slices: usize| figures(&one(falling, 6, slices, angle), 2e3);
        let whole = of(1);
        for slices in [3, 64] {
            for (one, other) in whole.iter().zip(of(slices)) {
                assert!((one / other - 1.0).abs() < 1e-9, "{angle}: {whole:?}");
            }
        }
    }
}

/// Two pairs, the second behind a gap: their loads sum to the force, the stiffness is the derivative of the force by
/// the approach, and open parts carry no load.
#[test]
fn two_pairs_bear_the_force_with_its_tangent() {
    let waves = 6;
    let compliance = Mat::from_fn(2 * waves, 2 * waves, |i, j| {
        let (n, m) = (i % waves, j % waves);
        let own = EVEN / (1.0 + (n * n) as f64);
        match (i / waves == j / waves, n == m) {
            (_, false) => 0.0,
            (true, true) => own,
            (false, true) => 0.2 * own,
        }
    });
    let slices = 16;
    let gap = |offset: f64| {
        let crowned = move |border: usize| {
            let z = face(slices).border(border);
            offset + 3e-4 * z + 0.05 * z * z
        };
        (0..=slices).map(crowned).collect()
    };
    let gaps = vec![gap(0.0), gap(2e-6)];
    let contact = vec![CONTACT, 1.2 * CONTACT];
    let coupled = Coupled::of(compliance, waves, contact, gaps, face(slices), false).unwrap();
    for force in [200.0, 1e3, 5e3] {
        let solution = coupled.solve(force);
        let pairs = coupled.pairs(&solution);
        let load: f64 = pairs.iter().map(|pair| pair.load).sum();
        assert!((load / force - 1.0).abs() < 1e-12, "{load}");
        let least = pairs
            .iter()
            .flat_map(|pair| &pair.pattern)
            .fold(f64::INFINITY, |a, b| a.min(*b));
        assert!(least >= -1e-12 * force, "{least}");
        let step = 1e-5 * force;
        let rise = coupled.solve(force + step).approach - coupled.solve(force - step).approach;
        let tangent = 2.0 * step / rise;
        assert!((solution.stiffness / tangent - 1.0).abs() < 1e-6, "{force}");
    }
    // The second pair comes into contact in between.
    let loaded = |force: f64| coupled.pairs(&coupled.solve(force))[1].loaded;
    assert_eq!(loaded(20.0), 0.0);
    assert!(loaded(5e3) > 0.5);
}

/// A hollow lead carries load at both ends of the face.
#[test]
fn contact_may_be_in_two_places() {
    let slices = 32;
    let hollow = |border: usize| {
        let z = face(slices).border(border);
        -0.3 * z * z
    };
    let gaps = vec![(0..=slices).map(hollow).collect()];
    let waves = 6;
    let falling = Mat::from_fn(waves, waves, |i, j| {
        if i == j { EVEN / (1.0 + (i * i) as f64) } else { 0.0 }
    });
    let coupled = Coupled::of(falling, waves, vec![CONTACT], gaps, face(slices), false).unwrap();
    let solution = coupled.solve(500.0);
    assert_eq!(solution.touching.0[0].len(), 2);
    let pair = &coupled.pairs(&solution)[0];
    assert!(pair.moment.abs() < 1e-12 * 500.0 * WIDTH);
    assert!(pair.loaded < 0.9);
}

/// The slope is that of one function of y and x. With a constant contact the second derivatives of this function are
/// symmetric, and the slope vanishes in equilibrium.
#[test]
fn slopes_are_those_of_one_function() {
    let mean = 1e5;
    let strip = |n: usize| EVEN / (1.0 + n as f64).powi(2);
    let coupled = one(strip, 4, 1, 2e-5);
    let patch = coupled.patch(vec![vec![Interval::WHOLE]]);
    let (least, _) = coupled.minimum(&patch, mean);
    let step = |y: f64, approach: f64| Iterate {
        y: Mat::from_fn(4, 1, |row, _| y * (1.0 + row as f64)),
        approach,
    };
    let [one, other] = [step(1e-3, 0.0), step(0.0, 1e-6)];
    let after = |by: &Iterate| Iterate {
        y: &least.y + &by.y,
        approach: least.approach + by.approach,
    };
    let [mixed, turned] = [[&one, &other], [&other, &one]]
        .map(|[by, along]| coupled.slope(&after(by), &patch, along, mean));
    let own = coupled.slope(&after(&one), &patch, &one, mean);
    assert!(coupled.slope(&least, &patch, &one, mean).abs() < 1e-12 * own);
    assert!(coupled.slope(&least, &patch, &other, mean).abs() < 1e-12 * own);
    assert!(own > 0.0 && coupled.slope(&after(&other), &patch, &other, mean) > 0.0);
    assert!(
        (mixed - turned).abs() < 1e-9 * mixed.abs(),
        "{mixed} {turned}"
    );
}
