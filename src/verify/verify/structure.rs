//! Compares natural frequencies of structures of beams, discs, bearings and ties with published ones, within
//! half a unit of the last printed digit. Compares the default drive with another assembly.

use super::report::worse;
use super::{CheckError, Line, Subjects, drives};
use crate::shaft::{Assembly, BeamElement, Disc, Freedom, Material, Modes, Section, ShaftError};
use std::f64::consts::TAU;

/// Modes of the default drive from an independent finite-element assembly.
const ASSEMBLY: &str = include_str!("../../../tests/data/default-drive.modal.toml");

/// The steel shaft of both rotors: 1.5 m long, diameter 50 mm, six Timoshenko elements with Cowper's shear
/// coefficient.
struct Rotor(Assembly);

impl Rotor {
    const DIAMETER: f64 = 0.05;
    const MATERIAL: Material = Material {
        young_modulus: 211e9,
        shear_modulus: 81.2e9,
        density: 7810.0,
    };

    fn new() -> Result<Self, ShaftError> {
        let section = Section::solid(Self::DIAMETER)?;
        let shear = section.cowper_shear_coefficient(Self::MATERIAL.poisson());
        let stations: Vec<f64> = (0..=6).map(|i| 0.25 * f64::from(i)).collect();
        let mut assembly = Assembly::new();
        assembly.add_shaft(&stations, section, Self::MATERIAL, shear)?;
        Ok(Self(assembly))
    }

    /// A disc 70 mm thick around the shaft.
    fn disc(mut self, node: usize, diameter: f64) -> Result<Self, ShaftError> {
        let disc = Disc::annulus(diameter, Self::DIAMETER, 0.07, Self::MATERIAL.density)?;
        self.0.add_disc(node, disc)?;
        Ok(self)
    }

    fn bearing(mut self, node: usize, stiffness: f64) -> Result<Self, ShaftError> {
        let springs = [stiffness, stiffness, 0.0, 0.0, 0.0, 0.0];
        self.0.add_spring(node, springs)?;
        Ok(self)
    }

    /// The lowest elastic frequencies \[rad/s\]. The two rigid modes, axial motion and rotation, are left
    /// out.
    fn frequencies(&self, elastic: usize) -> Result<Vec<f64>, ShaftError> {
        let matrices = self.0.matrices()?;
        let modes = Modes::lowest(&matrices.mass, &matrices.stiffness, elastic + 2, 2)?;
        Ok(modes.frequencies()[2..].to_vec())
    }
}

fn worst(computed: &[f64], published: &[f64]) -> f64 {
    if computed.len() != published.len() {
        return f64::NAN;
    }
    let differences = computed.iter().zip(published).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, worse)
}

/// Natural frequencies of two rotors at rest.
pub fn shafts(_: &Subjects) -> Result<Vec<Line>, CheckError> {
    let two_discs = Rotor::new()?
        .disc(2, 0.28)?
        .disc(4, 0.35)?
        .bearing(0, 1e6)?
        .bearing(6, 1e6)?
        .frequencies(6)?;
    let overhung = Rotor::new()?
        .disc(6, 0.35)?
        .bearing(0, 1e7)?
        .bearing(4, 1e7)?
        .frequencies(6)?;
    let (first, last) = two_discs.split_at(5);
    Ok(vec![
        Line::at_most(
            "two discs between bearings, modes 1-5",
            "Friswell et al. 2010, 5.9.1",
            worst(first, &[86.66, 86.66, 274.31, 274.31, 650.41]),
            0.005,
            "rad/s",
        ),
        Line::at_most(
            // The book truncates this value: the computed frequency is 716.786.
            "the same, mode 6 (truncated in print)",
            "Friswell et al. 2010, 5.9.1",
            worst(last, &[716.78]),
            0.01,
            "rad/s",
        ),
        Line::at_most(
            "overhung disc, modes 1-6",
            "Friswell et al. 2010, 5.9.9",
            worst(&overhung, &[90.14, 90.14, 630.73, 630.73, 830.43, 830.43]),
            0.005,
            "rad/s",
        ),
    ])
}

/// Adds a massless torsional spring as a beam without density.
fn add_torsional_spring(
    assembly: &mut Assembly,
    from: usize,
    to: usize,
    stiffness: f64,
) -> Result<(), ShaftError> {
    let section = Section::solid(1.0)?;
    let material = Material {
        young_modulus: 1.0,
        shear_modulus: stiffness / section.polar_moment(),
        density: 0.0,
    };
    let spring = BeamElement::new(section, material, 1.0, 1.0)?;
    assembly.add_beam(from, to, &spring)
}

/// Branched torsional system with gears. A motor of 400e-6 kg m² drives a gear through a shaft of 1e4 N
/// m/rad. This gear is in rigid mesh with an equal one; both have 25e-6 kg m². A load of 700e-6 kg m² is on
/// each gear through 5e3 N m/rad.
pub fn geared_torsion(_: &Subjects) -> Result<Vec<Line>, CheckError> {
    let mut assembly = Assembly::new();
    let [motor, gear_1, gear_2, load_1, load_2] = [(); 5].map(|()| assembly.add_node());
    for (node, inertia) in [
        (motor, 400e-6),
        (gear_1, 25e-6),
        (gear_2, 25e-6),
        (load_1, 700e-6),
        (load_2, 700e-6),
    ] {
        for &freedom in Freedom::ALL.iter().filter(|f| **f != Freedom::RotationZ) {
            assembly.fix(node, freedom)?;
        }
        assembly.add_polar_inertia(node, inertia)?;
    }
    for (from, to, stiffness) in [
        (motor, gear_1, 1e4),
        (gear_1, load_1, 5e3),
        (gear_2, load_2, 5e3),
    ] {
        add_torsional_spring(&mut assembly, from, to, stiffness)?;
    }
    assembly.tie(gear_2, gear_1, Freedom::RotationZ, -1.0)?;
    let matrices = assembly.matrices()?;
    let modes = Modes::lowest(&matrices.mass, &matrices.stiffness, 4, 1)?;
    let hertz: Vec<f64> = modes.frequencies().iter().map(|w| w / TAU).collect();
    Ok(vec![Line::at_most(
        "branched geared torsion, modes 1-4",
        "0, 425.4, 634.1, 3247.2 Hz (published)",
        worst(&hertz, &[0.0, 425.4, 634.1, 3247.2]),
        0.05,
        "Hz",
    )])
}

/// Relative differences of the elastic frequencies of the default drive from those of another assembly.
pub fn assembly(_: &Subjects) -> Result<Vec<Line>, CheckError> {
    const MISSING: CheckError = CheckError::Missing {
        what: "the frequencies of the other assembly",
    };
    let table: toml::Table = ASSEMBLY.parse().map_err(|_| MISSING)?;
    let column = table.get("frequency").and_then(toml::Value::as_array);
    let theirs: Vec<f64> = (column.ok_or(MISSING)?.iter())
        .filter_map(toml::Value::as_float)
        .collect();
    let ours = drives::shafts()?.modes(theirs.len(), theirs.len(), false)?;
    let elastic = (ours.frequency.iter().zip(&theirs)).filter(|(_, other)| **other > 0.0);
    let ratios: Vec<f64> = elastic.map(|(a, b)| a / b).collect();
    Ok(vec![Line::at_most(
        format!("default drive, {} elastic modes", ratios.len()),
        "independent finite-element assembly",
        worst(&ratios, &vec![1.0; theirs.len() - 2]),
        1e-6,
        "relative",
    )])
}
