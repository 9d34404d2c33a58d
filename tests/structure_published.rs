//! Beam elements, discs, bearings and ties against published natural frequencies, within
//! half a unit of the last digit printed (one unit where the source truncates).
// Helpers outside the test functions may unwrap, too.
#![allow(clippy::unwrap_used)]

use atlas::shaft::{Assembly, BeamElement, Disc, Freedom, Material, Modes, Section};
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
        let section = Section::solid(Self::DIAMETER).unwrap();
        let shear = section.cowper_shear_coefficient(Self::MATERIAL.poisson());
        let stations: Vec<f64> = (0..=6).map(|i| Self::ELEMENT * f64::from(i)).collect();
        let mut assembly = Assembly::new();
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

    /// Elastic frequencies \[rad/s\]; the axial and the turning motion are free.
    fn frequencies(&self, elastic: usize) -> Vec<f64> {
        let matrices = self.assembly.matrices().unwrap();
        let modes = Modes::lowest(&matrices.mass, &matrices.stiffness, elastic + 2, 2).unwrap();
        modes.frequencies()[2..].to_vec()
    }
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

/// Branched geared system: an inertia of 400e-6 kg m² drives through 1e4 N m/rad the first
/// of two equal gears of 25e-6 each, in rigid mesh; two inertias of 700e-6 hang on the
/// gears by 5e3 each. At ratio 1 it does not matter which gear carries which branch.
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
