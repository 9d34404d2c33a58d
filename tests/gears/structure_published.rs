//! Beam elements, discs, bearings and ties compared with published natural frequencies, within half a unit of the last
//! digit printed (one unit if the source truncates).
// Helpers outside the test functions may also unwrap.
#![allow(clippy::unwrap_used)]

use faer::{Mat, Scale};
use gearatlas::numerics::linalg::eigenvalues;
use gearatlas::shaft::{Assembly, BeamElement, Disc, Freedom, Material, Modes, Section};
use num_complex::Complex64;
use std::f64::consts::TAU;

const ALL_BUT_ROTATION: [Freedom; 5] = [
    Freedom::X,
    Freedom::Y,
    Freedom::Z,
    Freedom::RotationX,
    Freedom::RotationY,
];

/// The steel shaft shared by the rotors of Friswell, Penny, Garvey & Lees, *Dynamics of
/// Rotating Machines*, 2010, examples 5.9.1 and 5.9.9: 1.5 m × 50 mm, six Timoshenko elements
/// with Cowper's shear coefficient, discs 70 mm thick around the shaft.
struct Rotor {
    assembly: Assembly,
}

impl Rotor {
    const DIAMETER: f64 = 0.05;
    const ELEMENT: f64 = 0.25;
    const MATERIAL: Material = Material {
        young_modulus: 211e9,
        shear_modulus: 81.2e9,
        density: 7810.0,
    };

    fn new() -> Self {
        Self::at_speed(0.0)
    }

    /// The rotor with gyroscopic moments.
    fn turning() -> Self {
        Self::at_speed(1.0)
    }

    fn at_speed(ratio: f64) -> Self {
        let section = Section::solid(Self::DIAMETER).unwrap();
        let shear = section.cowper_shear_coefficient(Self::MATERIAL.poisson());
        let stations: Vec<f64> = (0..=6).map(|i| Self::ELEMENT * f64::from(i)).collect();
        let mut assembly = Assembly::new();
        assembly.turn(ratio);
        assembly
            .add_shaft(&stations, section, Self::MATERIAL, shear)
            .unwrap();
        Self { assembly }
    }

    fn disc(mut self, node: usize, diameter: f64) -> Self {
        let density = Self::MATERIAL.density;
        let disc = Disc::annulus(diameter, Self::DIAMETER, 0.07, density).unwrap();
        self.assembly.add_disc(node, disc).unwrap();
        self
    }

    fn bearing(mut self, node: usize, stiffness: f64) -> Self {
        self.assembly
            .add_spring(node, [stiffness, stiffness, 0.0, 0.0, 0.0, 0.0])
            .unwrap();
        self
    }

    /// Elastic frequencies \[rad/s\]; the axial motion and the rotation are free.
    fn frequencies(&self, elastic: usize) -> Vec<f64> {
        let matrices = self.assembly.matrices().unwrap();
        let modes = Modes::lowest(&matrices.mass, &matrices.stiffness, elastic + 2, 2).unwrap();
        modes.frequencies()[2..].to_vec()
    }
}

/// Eigenvalues of the whirl of a rotor at a speed \[1/s\], those with a positive imaginary part, by modulus; axial
/// motion and torsion are excluded.
fn whirl(rotor: Rotor, speed: f64) -> Vec<Complex64> {
    let mut assembly = rotor.assembly;
    for node in 0..=6 {
        for freedom in [Freedom::Z, Freedom::RotationZ] {
            assembly.fix(node, freedom).unwrap();
        }
    }
    let matrices = assembly.matrices().unwrap();
    let n = matrices.mass.nrows();
    let modes = Modes::lowest(&matrices.mass, &matrices.stiffness, n, 0).unwrap();
    let (frequency, shape) = (modes.frequencies(), &modes.shape);
    let coupling = matrices.coupling.unwrap();
    let rate = shape.transpose() * (coupling.damping + Scale(speed) * coupling.gyroscopic) * shape;
    // The matrix is for the state (ω q, q').
    let state = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, false) if i == j - n => frequency[i],
        (false, true) if i - n == j => -frequency[j],
        (false, false) => -rate[(i - n, j - n)],
        _ => 0.0,
    });
    let mut found: Vec<Complex64> = eigenvalues(state.as_ref()).unwrap();
    found.retain(|value| value.im > 0.0);
    found.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    found
}

fn assert_digits(found: &[f64], published: &[f64], unit: f64) {
    assert_eq!(found.len(), published.len());
    for (f, p) in found.iter().zip(published) {
        assert!((f - p).abs() < unit, "{f} against {p}");
    }
}

/// Example 5.9.1 at rest \[rad/s\]. 650.41 is the first torsional mode; 716.78 is printed
/// truncated (716.786).
#[test]
fn rotor_with_two_discs_on_isotropic_bearings() {
    let rotor = Rotor::new()
        .disc(2, 0.28)
        .disc(4, 0.35)
        .bearing(0, 1e6)
        .bearing(6, 1e6);
    let found = rotor.frequencies(6);
    let published = [86.66, 86.66, 274.31, 274.31, 650.41, 716.78];
    assert_digits(&found, &published, 0.01);
    assert_digits(&found[..5], &published[..5], 0.005);
}

/// Example 5.9.9 at rest \[rad/s\].
#[test]
fn overhung_rotor() {
    let rotor = Rotor::new().disc(6, 0.35).bearing(0, 1e7).bearing(4, 1e7);
    let published = [90.14, 90.14, 630.73, 630.73, 830.43, 830.43];
    assert_digits(&rotor.frequencies(6), &published, 0.005);
}

/// Examples 5.9.1 and 5.9.9 at 4000 rev/min \[rad/s\]: backward and forward whirls.
#[test]
fn gyroscopic_moments_part_the_whirls() {
    let speed = 4000.0 / 60.0 * TAU;
    let two_discs = Rotor::turning()
        .disc(2, 0.28)
        .disc(4, 0.35)
        .bearing(0, 1e6)
        .bearing(6, 1e6);
    let overhung = Rotor::turning()
        .disc(6, 0.35)
        .bearing(0, 1e7)
        .bearing(4, 1e7);
    for (rotor, published) in [
        (two_discs, [85.39, 87.80, 251.78, 294.71, 600.18, 827.08]),
        (overhung, [76.19, 103.91, 565.99, 634.23, 647.75, 1174.2]),
    ] {
        let found: Vec<f64> = whirl(rotor, speed).iter().map(|rate| rate.im).collect();
        assert_digits(&found[..5], &published[..5], 0.005);
        assert_digits(&found[5..6], &published[5..], 0.05);
    }
}

/// Example 5.9.5, the rotor of 5.9.1 with dampers of 3 kN s/m in both bearings, at rest and at
/// 4000 rev/min \[Hz\]: moduli and imaginary parts of the eigenvalues.
#[test]
fn dampers_in_the_bearings() {
    for (speed, moduli, damped) in [
        (
            0.0,
            [13.91, 13.91, 48.18, 48.18, 137.06, 137.06],
            [13.89, 13.89, 46.54, 46.54, 103.22, 103.22],
        ),
        (
            4000.0 / 60.0,
            [13.70, 14.09, 43.61, 52.18, 122.37, 149.81],
            [13.68, 14.07, 41.98, 50.65, 104.25, 105.66],
        ),
    ] {
        let mut rotor = Rotor::turning()
            .disc(2, 0.28)
            .disc(4, 0.35)
            .bearing(0, 1e6)
            .bearing(6, 1e6);
        for node in [0, 6] {
            let dampers = [[3e3, 0.0], [0.0, 3e3]];
            rotor.assembly.add_dampers(node, None, dampers).unwrap();
        }
        let found = whirl(rotor, speed * TAU);
        let hertz = |of: fn(&Complex64) -> f64| -> Vec<f64> {
            found[..6].iter().map(|rate| of(rate) / TAU).collect()
        };
        assert_digits(&hertz(|rate| rate.norm()), &moduli, 0.005);
        assert_digits(&hertz(|rate| rate.im), &damped, 0.005);
    }
}

/// Adds a massless torsional spring as a beam without density.
fn add_torsional_spring(assembly: &mut Assembly, from: usize, to: usize, stiffness: f64) {
    let section = Section::solid(1.0).unwrap();
    let material = Material {
        young_modulus: 1.0,
        shear_modulus: stiffness / section.polar_moment(),
        density: 0.0,
    };
    let spring = BeamElement::new(section, material, 1.0, 1.0).unwrap();
    assembly.add_beam(from, to, &spring).unwrap();
}

/// Branched geared system: an inertia of 400e-6 kg m² drives the first of two equal gears of 25e-6 each in rigid mesh
/// through 1e4 N m/rad; on each gear is an inertia of 700e-6 behind 5e3 N m/rad. At ratio 1 it does not matter which
/// gear carries which branch.
#[test]
fn geared_torsional_system() {
    for second_branch_on in [0, 1] {
        let mut assembly = Assembly::new();
        let [motor, gear_1, gear_2, load_1, load_2] = [(); 5].map(|()| assembly.add_node());
        for node in [motor, gear_1, gear_2, load_1, load_2] {
            for freedom in ALL_BUT_ROTATION {
                assembly.fix(node, freedom).unwrap();
            }
        }
        for (node, inertia) in [
            (motor, 400e-6),
            (gear_1, 25e-6),
            (gear_2, 25e-6),
            (load_1, 700e-6),
            (load_2, 700e-6),
        ] {
            assembly.add_polar_inertia(node, inertia).unwrap();
        }
        let carrier = [gear_1, gear_2][second_branch_on];
        add_torsional_spring(&mut assembly, motor, gear_1, 1e4);
        add_torsional_spring(&mut assembly, gear_2, load_1, 5e3);
        add_torsional_spring(&mut assembly, carrier, load_2, 5e3);
        assembly
            .tie(gear_2, gear_1, Freedom::RotationZ, -1.0)
            .unwrap();
        let matrices = assembly.matrices().unwrap();
        let modes = Modes::lowest(&matrices.mass, &matrices.stiffness, 4, 1).unwrap();
        let hertz: Vec<f64> = modes.frequencies().iter().map(|w| w / TAU).collect();
        assert_eq!(hertz[0], 0.0);
        assert_digits(&hertz, &[0.0, 425.4, 634.1, 3247.2], 0.05);
    }
}
