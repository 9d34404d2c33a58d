use super::*;
use crate::shaft::{AssembledMatrices, Assembly, Disc, Freedom, Material, Section};
use proptest::prelude::*;
use std::f64::consts::PI;

const SHEAR: f64 = 0.9;

fn steel() -> Material {
    Material {
        young_modulus: 206e9,
        shear_modulus: 79e9,
        density: 7850.0,
    }
}

/// A uniform shaft of unit length; returns the assembly and its last node.
fn shaft(diameter: f64, shear: f64, elements: usize) -> (Assembly, usize) {
    let stations: Vec<f64> = (0..=elements).map(|i| i as f64 / elements as f64).collect();
    let mut assembly = Assembly::new();
    let section = Section::solid(diameter).unwrap();
    assembly
        .add_shaft(&stations, section, steel(), shear)
        .unwrap();
    (assembly, elements)
}

/// Frees only the given freedoms of every node.
fn only(assembly: &mut Assembly, last: usize, kept: &[Freedom]) {
    for node in 0..=last {
        for freedom in [
            Freedom::X,
            Freedom::Y,
            Freedom::Z,
            Freedom::RotationX,
            Freedom::RotationY,
            Freedom::RotationZ,
        ] {
            if !kept.contains(&freedom) {
                assembly.fix(node, freedom).unwrap();
            }
        }
    }
}

const PLANE: [Freedom; 2] = [Freedom::X, Freedom::RotationY];

fn frequencies(assembly: &Assembly, requested: usize, rigid: usize) -> Vec<f64> {
    let matrices = assembly.matrices().unwrap();
    Modes::lowest(&matrices.mass, &matrices.stiffness, requested, rigid)
        .unwrap()
        .frequencies()
}

fn simply_supported(diameter: f64, shear: f64, elements: usize, requested: usize) -> Vec<f64> {
    let (mut assembly, last) = shaft(diameter, shear, elements);
    only(&mut assembly, last, &PLANE);
    assembly.fix(0, Freedom::X).unwrap();
    assembly.fix(last, Freedom::X).unwrap();
    frequencies(&assembly, requested, 0)
}

/// `√(EI/ρA)` of a solid unit-length shaft, so that `ω = (βL)² ×` this.
fn bending_scale(diameter: f64) -> f64 {
    let section = Section::solid(diameter).unwrap();
    (steel().young_modulus * section.second_moment() / (steel().density * section.area())).sqrt()
}

fn assert_close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f / e - 1.0).abs() < tolerance, "{f} {e}");
    }
}

/// Exact frequencies of a simply supported Timoshenko beam, the lower branch of
/// `(ρ² I/κG) ω⁴ − (ρA + ρI (1 + E/κG) k²) ω² + E I k⁴ = 0`, k = nπ/L.
fn exact_timoshenko(diameter: f64, shear: f64, count: usize) -> Vec<f64> {
    let section = Section::solid(diameter).unwrap();
    let (e, rho) = (steel().young_modulus, steel().density);
    let shear_modulus = shear * steel().shear_modulus;
    (1..=count)
        .map(|n| {
            let k2 = (n as f64 * PI).powi(2);
            let a = rho * rho * section.second_moment() / shear_modulus;
            let b = rho * section.area()
                + rho * section.second_moment() * (1.0 + e / shear_modulus) * k2;
            let c = e * section.second_moment() * k2 * k2;
            (2.0 * c / (b + (b * b - 4.0 * a * c).sqrt())).sqrt()
        })
        .collect()
}

/// Frequencies with rotary inertia but rigid in shear: `ω² = E I k⁴/(ρA + ρI k²)`.
fn rayleigh(diameter: f64, count: usize) -> Vec<f64> {
    let gyration2 = (diameter / 4.0).powi(2);
    (1..=count)
        .map(|n| {
            let k2 = (n as f64 * PI).powi(2);
            k2 * bending_scale(diameter) / (1.0 + gyration2 * k2).sqrt()
        })
        .collect()
}

/// Slender enough (radius of gyration 2.5e-4 of the length) that rotary inertia and shear
/// change the highest frequency below by less than 1e-4.
const SLENDER: f64 = 1e-3;

#[test]
fn euler_bernoulli_simply_supported() {
    let expected: Vec<f64> = (1..=4)
        .map(|n| (f64::from(n) * PI).powi(2) * bending_scale(SLENDER))
        .collect();
    assert_close(&simply_supported(SLENDER, SHEAR, 30, 4), &expected, 5e-5);
}

#[test]
fn euler_bernoulli_cantilever() {
    let (mut assembly, last) = shaft(SLENDER, f64::INFINITY, 30);
    only(&mut assembly, last, &PLANE);
    for freedom in PLANE {
        assembly.fix(0, freedom).unwrap();
    }
    let expected = [
        1.875_104_068_711_961,
        4.694_091_132_974_175,
        7.854_757_438_237_613,
    ]
    .map(|beta| beta * beta * bending_scale(SLENDER));
    assert_close(&frequencies(&assembly, 3, 0), &expected, 2e-5);
}

#[test]
fn euler_bernoulli_free_free() {
    let (mut assembly, last) = shaft(SLENDER, f64::INFINITY, 30);
    only(&mut assembly, last, &PLANE);
    let found = frequencies(&assembly, 5, 2);
    assert_eq!(found[..2], [0.0, 0.0]);
    let expected = [
        4.730_040_744_862_704,
        7.853_204_624_095_838,
        10.995_607_838_001_671,
    ]
    .map(|beta| beta * beta * bending_scale(SLENDER));
    assert_close(&found[2..], &expected, 2e-5);
}

/// Rotary inertia alone (Rayleigh's beam), then shear, which lowers the frequencies further.
#[test]
fn rotary_inertia_and_shear_of_a_stubby_shaft() {
    let diameter = 0.2;
    let rigid_in_shear = simply_supported(diameter, f64::INFINITY, 60, 3);
    assert_close(&rigid_in_shear, &rayleigh(diameter, 3), 1e-6);
    let full = simply_supported(diameter, SHEAR, 60, 3);
    assert_close(&full, &exact_timoshenko(diameter, SHEAR, 3), 5e-4);
    for (shearing, rigid) in full.iter().zip(&rigid_in_shear) {
        assert!(shearing < rigid);
    }
}

/// The dense solution alone has an error of 9e-9 here; discretisation accounts for 3e-10.
#[test]
fn the_lowest_frequency_survives_a_fine_mesh() {
    let found = simply_supported(0.02, f64::INFINITY, 120, 6);
    assert_close(&found[..1], &rayleigh(0.02, 1), 3e-9);
}

/// Cubic interpolation gives order four without shear. The shear strain is constant in an
/// element, so a shear-flexible shaft converges with order two, with a small constant.
#[test]
fn bending_frequencies_converge_from_above_with_their_order() {
    let diameter = 0.1;
    let rigid_in_shear = rayleigh(diameter, 3);
    let flexible = exact_timoshenko(diameter, SHEAR, 3);
    for (shear, exact, elements, expected) in [
        (f64::INFINITY, rigid_in_shear, [8, 16, 32], 4.0),
        (SHEAR, flexible, [24, 48, 96], 2.0),
    ] {
        let errors = elements.map(|count| {
            let found = simply_supported(diameter, shear, count, 3);
            let pairs = found.iter().zip(&exact);
            pairs.map(|(f, e)| f / e - 1.0).collect::<Vec<_>>()
        });
        for pair in errors.windows(2) {
            for mode in 0..3 {
                assert!(pair[1][mode] > 0.0);
                let order = (pair[0][mode] / pair[1][mode]).log2();
                assert!((order - expected).abs() < 0.1, "mode {}: {order}", mode + 1);
            }
        }
    }
}

/// Frequencies of a bar of unit length, one end clamped, by linear elements with consistent
/// mass: `ω² = 6 (c/h)² (1 − cos κh)/(2 + cos κh)`.
fn clamped_bar(speed: f64, elements: usize) -> Vec<f64> {
    (1..=elements)
        .map(|n| {
            let phase = (n as f64 - 0.5) * PI / elements as f64;
            let half = (0.5 * phase).sin();
            let ratio = 12.0 * half * half / (2.0 + phase.cos());
            speed * elements as f64 * ratio.sqrt()
        })
        .collect()
}

/// The discrete spectra of torsion and axial bars tend to `ω = c κ` with order two.
#[test]
fn torsion_and_axial_bars() {
    let bars = [
        (Freedom::RotationZ, steel().shear_modulus),
        (Freedom::Z, steel().young_modulus),
    ];
    for (freedom, modulus) in bars {
        let speed = (modulus / steel().density).sqrt();
        let clamped = |elements: usize| {
            let (mut assembly, last) = shaft(0.03, SHEAR, elements);
            only(&mut assembly, last, &[freedom]);
            assembly.fix(0, freedom).unwrap();
            frequencies(&assembly, elements, 0)
        };
        // The second exceeds the size at which the eigensolver divides the matrix in four.
        for elements in [100, 400] {
            let discrete = clamped_bar(speed, elements);
            assert_close(&clamped(elements), &discrete, 1e-11);
        }
        let error = |n: usize| clamped(n)[0] / (0.5 * PI * speed) - 1.0;
        let order = (error(10) / error(20)).log2();
        assert!((order - 2.0).abs() < 0.01, "{order}");
    }
}

/// Every eigenvalue and vector of a symmetric matrix, with entries of any size, on both sides
/// of the sizes at which the solver divides it.
#[test]
fn the_eigensolver_is_exact_at_any_scale_and_size() {
    for size in [20, 128, 129, 200, 257, 520] {
        for exponent in [-40, 0, 33, 60] {
            let unit = 2f64.powi(exponent);
            // −1, 2, −1 with a graded diagonal: no two halves are equal, none is negligible.
            let matrix = Mat::from_fn(size, size, |i, j| match i.abs_diff(j) {
                0 => unit * (2.0 + i as f64 / size as f64),
                1 => -unit,
                _ => 0.0,
            });
            let (values, vectors) = eigen(&matrix).unwrap();
            let residual = Mat::from_fn(size, size, |i, j| {
                let row = (0..size).map(|k| matrix[(i, k)] * vectors[(k, j)]);
                row.sum::<f64>() - values[j] * vectors[(i, j)]
            });
            let gram = vectors.transpose() * &vectors - Mat::<f64>::identity(size, size);
            let bound = 4.0 * size as f64 * f64::EPSILON;
            let found = [residual.norm_max() / unit, gram.norm_max()];
            assert!(
                found.iter().all(|e| *e < bound),
                "{size} {exponent} {found:?}"
            );
        }
    }
}

/// The lowest frequencies of a shaft on springs. Checks that mass and stiffness are diagonal in the modes.
fn fine_shaft(elements: usize, requested: usize) -> Vec<f64> {
    let (mut assembly, last) = shaft(0.05, SHEAR, elements);
    for node in [0, last] {
        assembly
            .add_spring(node, [1e8, 7e7, 1e8, 0.0, 0.0, 0.0])
            .unwrap();
    }
    let AssembledMatrices {
        mass, stiffness, ..
    } = assembly.matrices().unwrap();
    let modes = Modes::lowest(&mass, &stiffness, requested, 1).unwrap();
    let gram = modes.shape.transpose() * (&mass * &modes.shape);
    let energy = modes.shape.transpose() * (&stiffness * &modes.shape);
    let top = modes.squared_frequency[requested - 1];
    for i in 0..requested {
        for j in 0..requested {
            let unit = f64::from(u8::from(i == j));
            assert!((gram[(i, j)] - unit).abs() < 1e-11, "{}", gram[(i, j)]);
            let off = (energy[(i, j)] - unit * modes.squared_frequency[i]).abs();
            assert!(off < 1e-9 * top, "{i} {j} {off:e} {top:e}");
        }
    }
    modes.frequencies()
}

#[test]
fn hundreds_of_freedoms() {
    let coarse = fine_shaft(20, 16);
    // Freedoms 156 to 606: one to three divisions of the matrix.
    for elements in [25, 43, 60, 100] {
        let fine = fine_shaft(elements, 16);
        for (mode, (fine, coarse)) in fine.iter().zip(&coarse).enumerate().skip(1) {
            let off = fine / coarse - 1.0;
            assert!((-1e-2..=1e-9).contains(&off), "{elements} {mode} {off:e}");
        }
    }
}

/// The modes of large banded matrices are those of a dense solution, for a shaft with equal planes (every
/// frequency twice) and for one with different planes.
#[test]
fn few_modes_of_a_large_structure_are_the_dense_ones() {
    for (x, y) in [(1e8, 7e7), (1e8, 1e8)] {
        let (mut assembly, last) = shaft(0.05, SHEAR, 80);
        for node in [0, last] {
            let springs = [x, y, 1e8, 0.0, 0.0, 0.0];
            assembly.add_spring(node, springs).unwrap();
        }
        let AssembledMatrices {
            mass, stiffness, ..
        } = assembly.matrices().unwrap();
        assert!(mass.nrows() >= LARGE && Banded::width(&[&mass, &stiffness]) < 12);
        let few = Modes::lowest(&mass, &stiffness, 40, 1).unwrap();
        let many = Modes::lowest(&mass, &stiffness, mass.nrows() / 4, 1).unwrap();
        let band = Banded::width(&[&mass, &stiffness]);
        let [m, k] = [&mass, &stiffness].map(|matrix| Banded::of(matrix, band));
        assert!(
            lanczos::lowest(&m, &k, 40, 1).is_some(),
            "it does not fall back"
        );
        assert_eq!(few.squared_frequency[0], 0.0);
        assert_close(&few.frequencies()[1..], &many.frequencies()[1..40], 1e-10);
        // The same spaces: every shape is in the span of the dense ones of its frequency.
        let overlap = many.shape.transpose() * (&mass * &few.shape);
        for mode in 0..39 {
            let near = |other: usize| {
                let [a, b] = [few.squared_frequency[mode], many.squared_frequency[other]];
                a == b || (a / b - 1.0).abs() < 1e-6
            };
            let inside: f64 = (0..many.squared_frequency.len())
                .filter(|&other| near(other))
                .map(|other| overlap[(other, mode)].powi(2))
                .sum();
            assert!((inside - 1.0).abs() < 1e-10, "mode {mode}: {inside}");
        }
    }
}

/// Tests the banded solution: a dense one would take half a minute.
#[test]
fn three_thousand_freedoms() {
    let coarse = fine_shaft(100, 16);
    let fine = fine_shaft(500, 16);
    for (fine, coarse) in fine.iter().zip(&coarse).skip(1) {
        let off = fine / coarse - 1.0;
        assert!((-1e-3..=1e-9).contains(&off), "{off:e}");
    }
    let speed = (steel().shear_modulus / steel().density).sqrt();
    let (mut assembly, last) = shaft(0.03, SHEAR, 3000);
    only(&mut assembly, last, &[Freedom::RotationZ]);
    assembly.fix(0, Freedom::RotationZ).unwrap();
    let expected = clamped_bar(speed, 3000);
    // Entries of K are rounded; the error grows with the square of the number of elements.
    assert_close(&frequencies(&assembly, 40, 0), &expected[..40], 2e-9);
}

#[test]
fn a_free_shaft_has_six_rigid_motions() {
    let (assembly, last) = shaft(0.05, SHEAR, 12);
    let matrices = assembly.matrices().unwrap();
    let modes = Modes::lowest(&matrices.mass, &matrices.stiffness, 10, 6).unwrap();
    assert_eq!(modes.squared_frequency[..6], [0.0; 6]);
    assert!(modes.squared_frequency[6] > 1e5);
    // Rigid shapes neither twist nor stretch.
    for freedom in [
        Freedom::Z,
        Freedom::RotationX,
        Freedom::RotationY,
        Freedom::RotationZ,
    ] {
        let relative = matrices.functional(&[(0, freedom, 1.0), (last, freedom, -1.0)]);
        for value in &modes.participation(&relative)[..6] {
            assert!(value.abs() < 1e-8, "{value}");
        }
    }
    for (expected, found) in [(5, 6), (7, 6), (0, 6)] {
        let result = Modes::lowest(&matrices.mass, &matrices.stiffness, 4, expected);
        match result.err() {
            Some(ShaftError::RigidModes {
                expected: e,
                found: f,
            }) => {
                assert_eq!(e, expected);
                // The solution contains only one mode beyond the expected ones.
                assert_eq!(f, found.min((expected + 1).max(4)));
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn bad_matrices_are_refused() {
    let identity = Mat::<f64>::identity(3, 3);
    let mut massless = identity.clone();
    massless[(1, 1)] = 0.0;
    let error = |m: &Mat<f64>, k: &Mat<f64>, n| Modes::lowest(m, k, n, 0).err().unwrap();
    assert_eq!(
        error(&massless, &identity, 1),
        ShaftError::MassNotPositiveDefinite
    );
    let mut infinite = identity.clone();
    infinite[(2, 0)] = f64::INFINITY;
    assert_eq!(
        error(&identity, &infinite, 1),
        ShaftError::NonFinite {
            matrix: "stiffness",
            row: 2,
            column: 0
        }
    );
    for requested in [0, 4] {
        assert_eq!(
            error(&identity, &identity, requested),
            ShaftError::ModeCount(ModeCount {
                requested,
                least: 1,
                available: 3
            })
        );
    }
    let mut negative = identity.clone();
    negative[(0, 0)] = -1.0;
    assert!(matches!(
        error(&identity, &negative, 1),
        ShaftError::StiffnessIndefinite { .. }
    ));
    let wide = Mat::<f64>::zeros(3, 4);
    assert!(matches!(
        error(&identity, &wide, 1),
        ShaftError::Shape { .. }
    ));
    let mut lopsided = identity.clone();
    lopsided[(0, 2)] = 0.5;
    assert_eq!(
        error(&identity, &lopsided, 3),
        ShaftError::Asymmetric {
            matrix: "stiffness",
            row: 2,
            column: 0,
            entries: [0.0, 0.5],
        }
    );
}

/// The deflection beyond the computed modes is the sum over all others, and only round-off if the
/// computed ones contain all of it.
#[test]
fn static_shapes_are_the_modes_left_out() {
    let (mut assembly, last) = shaft(0.05, SHEAR, 2);
    for node in [0, last] {
        let springs = [1e8, 7e7, 1e8, 0.0, 0.0, 0.0];
        assembly.add_spring(node, springs).unwrap();
    }
    let AssembledMatrices {
        mass, stiffness, ..
    } = assembly.matrices().unwrap();
    let size = mass.nrows();
    let all = Modes::lowest(&mass, &stiffness, size, 1).unwrap();
    let load = |freedom: usize, force: f64| {
        let mut load = vec![0.0; size];
        load[freedom] = force;
        load
    };
    let loads = [load(0, 1e8), load(2, 1e8)];
    let mut none_left = 0;
    for count in 2..size {
        let few = Modes::lowest(&mass, &stiffness, count, 1).unwrap();
        let shapes = few.with_static_shapes(&mass, &stiffness, &loads).unwrap();
        for (number, load) in loads.iter().enumerate() {
            let participation = all.participation(load);
            let deflection = |row: usize, from: usize| -> f64 {
                let modes = (from..size)
                    .map(|m| all.shape[(row, m)] * participation[m] / all.squared_frequency[m]);
                modes.sum()
            };
            let whole = (0..size).fold(0.0_f64, |most, row| most.max(deflection(row, 1).abs()));
            let rest = (0..size).fold(0.0_f64, |most, row| most.max(deflection(row, count).abs()));
            for row in 0..size {
                let off = shapes.shape[(row, count + number)] - deflection(row, count);
                assert!(
                    off.abs() < 1e-10 * whole,
                    "{count} {number} {row}: {off:e} of {whole:e}"
                );
            }
            none_left += usize::from(rest < 1e-10 * whole);
        }
    }
    assert!(none_left > 0);
}

#[test]
fn a_structure_without_stiffness_is_all_rigid() {
    let modes = Modes::lowest(&Mat::identity(2, 2), &Mat::zeros(2, 2), 2, 2).unwrap();
    assert_eq!(modes.squared_frequency, [0.0, 0.0]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// `ΦᵀMΦ = 1`, `ΦᵀKΦ = diag ω²`, ascending, over random shafts with
    /// random discs and bearings; the low modes agree for any number of requested modes.
    #[test]
    fn modes_are_orthonormal_in_mass_and_diagonal_in_stiffness(
        diameter in 0.01..0.08f64,
        elements in 3usize..14,
        disc_diameter in 0.1..0.3f64,
        disc_node in 0.0..1.0f64,
        bearings in prop::array::uniform2(5.0..9.5f64),
        fraction in 0.1..1.0f64,
    ) {
        let (mut assembly, last) = shaft(diameter, SHEAR, elements);
        let node = (disc_node * last as f64) as usize;
        let disc = Disc::annulus(disc_diameter, diameter, 0.03, 7850.0).unwrap();
        assembly.add_disc(node, disc).unwrap();
        for (node, exponent) in [0, last].into_iter().zip(bearings) {
            let k = 10f64.powf(exponent);
            assembly.add_spring(node, [k, 0.7 * k, k, 0.0, 0.0, 0.0]).unwrap();
        }
        let matrices = assembly.matrices().unwrap();
        let size = matrices.mass.nrows();
        let requested = ((size as f64 * fraction) as usize).max(2);
        let modes = Modes::lowest(&matrices.mass, &matrices.stiffness, requested, 1).unwrap();
        let all = Modes::lowest(&matrices.mass, &matrices.stiffness, size, 1).unwrap();
        prop_assert_eq!(modes.squared_frequency[0], 0.0);
        prop_assert!(modes.squared_frequency.is_sorted());
        let top = modes.squared_frequency[requested - 1];
        let gram = modes.shape.transpose() * (&matrices.mass * &modes.shape);
        let energy = modes.shape.transpose() * (&matrices.stiffness * &modes.shape);
        let roundoff = f64::EPSILON * size as f64;
        for i in 0..requested {
            for j in 0..requested {
                let unit = f64::from(i == j);
                prop_assert!((gram[(i, j)] - unit).abs() < 50.0 * roundoff);
                let expected = unit * modes.squared_frequency[i];
                prop_assert!(
                    (energy[(i, j)] - expected).abs()
                        < 50.0 * roundoff * all.squared_frequency[size - 1],
                    "{} {}", energy[(i, j)], expected
                );
            }
            let other = all.squared_frequency[i];
            prop_assert!((modes.squared_frequency[i] - other).abs()
                <= 50.0 * roundoff * all.squared_frequency[size - 1].max(top));
        }
    }
}

/// Round-off of large entries in any unit is not an asymmetry; a part in a thousand is one.
#[test]
fn asymmetry_is_told_against_the_diagonal() {
    let mass = Mat::<f64>::identity(2, 2);
    for unit in [1e-6, 1.0, 1e8] {
        let stiffness = |off: f64| {
            Mat::from_fn(2, 2, |i, j| match i.cmp(&j) {
                std::cmp::Ordering::Equal => 2.0 * unit,
                std::cmp::Ordering::Less => unit,
                std::cmp::Ordering::Greater => unit * (1.0 + off),
            })
        };
        assert!(check(&mass, &stiffness(1e-11)).is_ok());
        assert!(matches!(
            check(&mass, &stiffness(1e-9)),
            Err(ShaftError::Asymmetric {
                row: 1,
                column: 0,
                ..
            })
        ));
    }
}

/// If a mode does not move the flanks, the largest entry of its shape determines its sign.
#[test]
fn modes_that_the_mesh_does_not_feel_have_a_sign_too() {
    let solution = Modes {
        squared_frequency: vec![0.0, 1.0, 2.0],
        shape: faer::mat![[1.0, 0.1, 0.6], [1.0, -0.9, -0.6]],
    };
    assert_eq!(orientation(&[0.5, 0.0, 0.0], 1, &solution), [-1.0, 1.0]);
    assert_eq!(orientation(&[0.5, 2.0, -1e-3], 1, &solution), [1.0, -1.0]);
    assert_eq!(orientation(&[0.5, 2.0, -1e-9], 1, &solution), [1.0, 1.0]);
}
