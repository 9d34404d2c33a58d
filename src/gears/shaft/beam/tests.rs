use super::*;
use crate::shaft::{Assembly, Disc, Freedom};
use proptest::prelude::*;

fn steel() -> Material {
    Material {
        young_modulus: 206e9,
        shear_modulus: 79e9,
        density: 7850.0,
    }
}

fn multiply(matrix: &ElementMatrix, vector: &[f64; ELEMENT_FREEDOMS]) -> [f64; ELEMENT_FREEDOMS] {
    std::array::from_fn(|i| {
        (0..ELEMENT_FREEDOMS)
            .map(|j| matrix[i][j] * vector[j])
            .sum()
    })
}

fn form(matrix: &ElementMatrix, vector: &[f64; ELEMENT_FREEDOMS]) -> f64 {
    let image = multiply(matrix, vector);
    image.iter().zip(vector).map(|(a, b)| a * b).sum()
}

/// The six rigid motions of an element of length `l`: translations, then unit rotations
/// about x, y, z through the first node, `u = θ × r`.
fn rigid_motions(l: f64) -> [[f64; ELEMENT_FREEDOMS]; 6] {
    let mut motions = [[0.0; ELEMENT_FREEDOMS]; 6];
    for (axis, motion) in motions.iter_mut().enumerate() {
        motion[axis] = 1.0;
        motion[axis + 6] = 1.0;
    }
    motions[3][7] = -l; // e_x × l e_z = −l e_y
    motions[4][6] = l; // e_y × l e_z = l e_x
    motions
}

#[test]
fn section_properties_of_a_tube() {
    let tube = Section::hollow(0.05, 0.03).unwrap();
    assert!((tube.area() / (PI * 4e-4) - 1.0).abs() < 1e-14);
    let moment = PI / 4.0 * (0.025f64.powi(4) - 0.015f64.powi(4));
    assert!((tube.second_moment() / moment - 1.0).abs() < 1e-14);
    assert!((tube.polar_moment() / (2.0 * moment) - 1.0).abs() < 1e-14);
}

#[test]
fn poissons_ratio() {
    let material = Material {
        young_modulus: 5.2,
        shear_modulus: 2.0,
        density: 0.0,
    };
    assert!((material.poisson() - 0.3).abs() < 1e-15);
}

#[test]
fn shear_coefficient_of_cowper() {
    // Cowper's table: 0.886 solid and 0.530 thin-walled at ν = 0.3; 6/7 and 1/2 at ν = 0.
    let solid = Section::solid(0.05).unwrap();
    let thin = Section::hollow(0.05, 0.05 * (1.0 - 1e-9)).unwrap();
    for (section, poisson, expected) in [
        (solid, 0.3, 7.8 / 8.8),
        (thin, 0.3, 2.6 / 4.9),
        (solid, 0.0, 6.0 / 7.0),
        (thin, 0.0, 0.5),
    ] {
        let found = section.cowper_shear_coefficient(poisson);
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}

/// Tip force on a cantilever: `F L³/(3EI) + F L/(κGA)`, exact with one element.
#[test]
fn static_deflection_of_a_stub_cantilever() {
    let section = Section::solid(0.06).unwrap();
    let (length, shear) = (0.08, 0.9);
    let element = BeamElement::new(section, steel(), shear, length).unwrap();
    let k = element.stiffness();
    for (deflection, rotation) in [(6, 10), (7, 9)] {
        // Eliminate the free rotation of the tip.
        let tip = k[deflection][deflection]
            - k[deflection][rotation] * k[rotation][deflection] / k[rotation][rotation];
        let bending = length.powi(3) / (3.0 * steel().young_modulus * section.second_moment());
        let sliding = length / (shear * steel().shear_modulus * section.area());
        assert!((tip * (bending + sliding) - 1.0).abs() < 1e-12);
    }
}

proptest! {
    #[test]
    fn rigid_motions_cost_nothing_and_carry_the_inertia_of_the_cylinder(
        diameter in 0.005..0.5f64,
        bore in 0.0..0.95f64,
        length in 0.002..2.0f64,
        shear in 0.4..1.0f64,
    ) {
        let section = Section::hollow(diameter, bore * diameter).unwrap();
        let element = BeamElement::new(section, steel(), shear, length).unwrap();
        let (k, m) = (element.stiffness(), element.mass());
        let motions = rigid_motions(length);
        for motion in &motions {
            let force = multiply(&k, motion);
            for (row, f) in force.iter().enumerate() {
                let scale: f64 = (0..ELEMENT_FREEDOMS).map(|j| (k[row][j] * motion[j]).abs()).sum();
                prop_assert!(f.abs() <= 1e-13 * scale);
            }
        }
        let line_mass = steel().density * section.area();
        let rotary = steel().density * section.second_moment();
        let mass = line_mass * length;
        let about_end = line_mass * length.powi(3) / 3.0 + rotary * length;
        let expected = [mass, mass, mass, about_end, about_end, 2.0 * rotary * length];
        for (motion, inertia) in motions.iter().zip(expected) {
            prop_assert!((form(&m, motion) / inertia - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn matrices_are_symmetric(length in 0.002..2.0f64, shear in 0.4..1.0f64) {
        let element =
            BeamElement::new(Section::solid(0.03).unwrap(), steel(), shear, length).unwrap();
        for matrix in [element.stiffness(), element.mass()] {
            for i in 0..ELEMENT_FREEDOMS {
                for j in 0..i {
                    prop_assert_eq!(matrix[i][j], matrix[j][i]);
                }
            }
        }
    }
}

#[test]
fn unphysical_elements_are_refused() {
    assert!(matches!(
        Section::hollow(0.05, 0.05),
        Err(ShaftError::NoWall { .. })
    ));
    assert!(matches!(
        Section::solid(f64::NAN),
        Err(ShaftError::Gear(GearError::NotPositive { .. }))
    ));
    assert!(matches!(
        Section::hollow(0.05, -0.01),
        Err(ShaftError::Gear(GearError::Negative { .. }))
    ));
    let section = Section::solid(0.05).unwrap();
    for (shear, length) in [
        (0.0, 1.0),
        (f64::NAN, 1.0),
        (0.9, 0.0),
        (0.9, f64::INFINITY),
    ] {
        assert!(BeamElement::new(section, steel(), shear, length).is_err());
    }
    assert!(matches!(
        Disc::annulus(0.1, 0.05, 0.0, 7850.0),
        Err(ShaftError::Gear(GearError::NotPositive { .. }))
    ));
}

/// Both bending planes are equal: a shaft loaded at 45° bends at 45°.
#[test]
fn bending_planes_are_alike() {
    let element = BeamElement::new(Section::solid(0.03).unwrap(), steel(), 0.9, 0.2).unwrap();
    let mut assembly = Assembly::new();
    let (a, b) = (assembly.add_node(), assembly.add_node());
    assembly.add_beam(a, b, &element).unwrap();
    let matrices = assembly.matrices().unwrap();
    let swap = |row: usize| match row % 6 {
        0 => (row + 1, 1.0),
        1 => (row - 1, 1.0),
        3 => (row + 1, -1.0),
        4 => (row - 1, -1.0),
        _ => (row, 1.0),
    };
    for matrix in [&matrices.mass, &matrices.stiffness] {
        for i in 0..12 {
            for j in 0..12 {
                let ((p, s), (q, t)) = (swap(i), swap(j));
                assert_eq!(matrix[(i, j)], s * t * matrix[(p, q)]);
            }
        }
    }
    assert_eq!(
        matrices.functional(&[(b, Freedom::RotationZ, 2.0)])[11],
        2.0
    );
}
