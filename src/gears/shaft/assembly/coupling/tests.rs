use super::*;
use crate::gear::GearError;
use crate::numerics::linalg::eigenvalues;
use crate::shaft::modes::Modes;
use crate::shaft::projection;
use crate::shaft::{AssembledMatrices, Disc, Material, Section};
use crate::structure::Coupling;
use num_complex::Complex64;
use std::f64::consts::PI;

/// All modes of an assembly without rigid motions, and their coupling.
fn coupled(assembly: &Assembly) -> (Vec<f64>, Coupling) {
    let matrices = assembly.matrices().unwrap();
    let modes = matrices.mass.nrows();
    let solution = Modes::lowest(&matrices.mass, &matrices.stiffness, modes, 0).unwrap();
    let coupling = projection::coupling(&matrices, &solution, |_| ())
        .0
        .unwrap();
    (solution.frequencies(), coupling)
}

/// Eigenvalues of the coupled modes at the pinion's speed Ω, without modal damping, in
/// the state `(ω q, q')`.
fn rates(frequency: &[f64], coupling: &Coupling, speed: f64) -> Vec<Complex64> {
    let n = frequency.len();
    let state = Mat::from_fn(2 * n, 2 * n, |i, j| match (i / n, j / n) {
        (0, 0) => 0.0,
        (0, _) if i == j - n => frequency[i],
        (0, _) => 0.0,
        (_, 0) => {
            let (i, own) = (i - n, i - n == j);
            let diagonal = if own { frequency[i] } else { 0.0 };
            -diagonal - coupling.stiffness[i * n + j] / frequency[j]
        }
        _ => {
            let at = (i - n) * n + j - n;
            -coupling.damping[at] - speed * coupling.gyroscopic[at]
        }
    });
    eigenvalues(state.as_ref()).unwrap()
}

/// Whirl frequencies \[rad/s\], both senses, ascending.
fn whirl(assembly: &Assembly, speed: f64) -> Vec<f64> {
    let (frequency, coupling) = coupled(assembly);
    let rates = rates(&frequency, &coupling, speed);
    let mut found: Vec<f64> = rates.iter().map(|r| r.im).filter(|w| *w > 0.0).collect();
    found.sort_by(f64::total_cmp);
    found
}

fn fix(assembly: &mut Assembly, node: usize, freedoms: &[Freedom]) {
    for &freedom in freedoms {
        assembly.fix(node, freedom).unwrap();
    }
}

/// A rigid rotor whose disc is in two halves and whose springs are at a distance from its centre:
/// translation `√(2k/m)`, tilt `ω = ∓p/2 + √(p²/4 + 2 k a²/J_d)` with `p = J_p Ω/J_d`.
#[test]
fn a_rigid_rotor_whirls_as_the_closed_form() {
    let (mass, transverse, polar) = (4.0, 0.02, 0.03);
    let (arm, apart, stiffness) = (0.15, 0.04, 3e6);
    for (ratio, speed) in [(1.0, 900.0), (-0.4, 2500.0), (1.0, 0.0)] {
        let mut assembly = Assembly::new();
        let body = assembly.add_node();
        fix(&mut assembly, body, &[Freedom::Z, Freedom::RotationZ]);
        assembly.turn(ratio);
        for offset in [-apart, apart] {
            let node = assembly.add_carried_node(body, offset).unwrap();
            let half = Disc {
                mass: 0.5 * mass,
                transverse_inertia: 0.5 * transverse,
                polar_inertia: 0.5 * polar,
            };
            assembly.add_disc(node, half).unwrap();
        }
        for offset in [-arm, arm] {
            let node = assembly.add_carried_node(body, offset).unwrap();
            let springs = [stiffness, stiffness, 0.0, 0.0, 0.0, 0.0];
            assembly.add_spring(node, springs).unwrap();
        }
        let steiner = transverse + mass * apart * apart;
        let p = polar * (ratio * speed).abs() / steiner;
        let tilt = (0.25 * p * p + 2.0 * stiffness * arm * arm / steiner).sqrt();
        let plain = (2.0 * stiffness / mass).sqrt();
        let mut exact = [plain, plain, tilt - 0.5 * p, tilt + 0.5 * p];
        exact.sort_by(f64::total_cmp);
        for (found, exact) in whirl(&assembly, speed).iter().zip(exact) {
            assert!((found / exact - 1.0).abs() < 1e-12, "{found} {exact}");
        }
    }
}

/// A right-handed rotating disc that is tilted about x drives a tilt about y, by
/// `J_d θx'' + J_p Ω θy' = M_x`, `J_d θy'' − J_p Ω θx' = M_y`. An inertia about the axis alone
/// does not.
#[test]
fn gyroscopic_moments_have_the_sign_of_the_spin() {
    let disc = Disc {
        mass: 1.0,
        transverse_inertia: 2.0,
        polar_inertia: 3.0,
    };
    for ratio in [1.0, -0.75] {
        let mut assembly = Assembly::new();
        let node = assembly.add_node();
        assembly.turn(ratio);
        assembly.add_disc(node, disc).unwrap();
        assembly.add_polar_inertia(node, 5.0).unwrap();
        let g = assembly.matrices().unwrap().coupling.unwrap().gyroscopic;
        assert_eq!([g[(3, 4)], g[(4, 3)]], [3.0 * ratio, -3.0 * ratio]);
        assert_eq!(g.norm_l1(), 6.0 * ratio.abs());
    }
    let mut plain = Assembly::new();
    let node = plain.add_node();
    plain.add_disc(node, disc).unwrap();
    assert!(plain.matrices().unwrap().coupling.is_none());
}

const LENGTH: f64 = 0.5;
const DIAMETER: f64 = 0.08;

fn steel() -> Material {
    Material {
        young_modulus: 206e9,
        shear_modulus: 79e9,
        density: 7850.0,
    }
}

/// A rotating shaft, simply supported at both ends.
fn supported_shaft(shear: f64, elements: usize) -> Assembly {
    let stations: Vec<f64> = (0..=elements)
        .map(|i| LENGTH * i as f64 / elements as f64)
        .collect();
    let section = Section::solid(DIAMETER).unwrap();
    let mut assembly = Assembly::new();
    assembly.turn(1.0);
    assembly
        .add_shaft(&stations, section, steel(), shear)
        .unwrap();
    for node in 0..=elements {
        fix(&mut assembly, node, &[Freedom::Z, Freedom::RotationZ]);
    }
    for node in [0, elements] {
        fix(&mut assembly, node, &[Freedom::X, Freedom::Y]);
    }
    assembly
}

/// First whirl frequency of the simply supported rotating shaft, forward for positive `speed`,
/// backward for negative. With `u = U sin κz`, `β = B cos κz`, κ = π/L:
/// `(k_s κ² − ρ A ω²)(E I κ² + k_s − ρ I ω² + 2 ρ I Ω ω) = (k_s κ)²`, k_s = κ_s G A; without
/// shear `(ρ A + ρ I κ²) ω² − 2 ρ I Ω κ² ω = E I κ⁴` (Zu & Han, J. Appl. Mech. 59, 1992).
fn exact_whirl(shear: f64, speed: f64) -> f64 {
    let section = Section::solid(DIAMETER).unwrap();
    let k = PI / LENGTH;
    let bending = steel().young_modulus * section.second_moment() * k * k;
    let line = steel().density * section.area();
    let rotary = steel().density * section.second_moment();
    if shear.is_infinite() {
        let mass = line + rotary * k * k;
        let half = rotary * speed * k * k / mass;
        return half + (half * half + bending * k * k / mass).sqrt();
    }
    let sliding = shear * steel().shear_modulus * section.area();
    let equation = |w: f64| {
        (sliding * k * k - line * w * w)
            * (bending + sliding - rotary * w * w + 2.0 * rotary * speed * w)
            - (sliding * k).powi(2)
    };
    // Positive at 0, negative where the first factor vanishes.
    let (mut low, mut high) = (0.0, k * (sliding / line).sqrt());
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if equation(middle) > 0.0 { low = middle } else { high = middle }
    }
    low
}

/// Both whirls of a rotating shaft converge from above, with the same order as bending frequencies at
/// rest: four without shear, two with shear.
#[test]
fn a_turning_shaft_converges_to_its_whirl_frequencies() {
    let speed = 3e3;
    for (shear, elements, expected) in [(f64::INFINITY, [2, 4, 8], 4.0), (0.9, [6, 12, 24], 2.0)] {
        let exact = [-speed, speed].map(|speed| exact_whirl(shear, speed));
        assert!(exact[1] / exact[0] - 1.0 > 0.02, "the whirls are apart");
        let errors = elements.map(|count| {
            let found = whirl(&supported_shaft(shear, count), speed);
            [0, 1].map(|i| found[i] / exact[i] - 1.0)
        });
        for pair in errors.windows(2) {
            for i in 0..2 {
                assert!(pair[1][i] > 0.0, "{errors:?}");
                let order = (pair[0][i] / pair[1][i]).log2();
                assert!((order - expected).abs() < 0.1, "{shear} {i}: {order}");
            }
        }
        assert!(errors[2][1] < 2e-4, "{errors:?}");
    }
}

/// Rigid-body rotation of an element tilts all sections equally: the element has the
/// gyroscopic moment of a rod, `J_p = ρ π d⁴/32 L`, with any shear.
#[test]
fn a_beam_that_tilts_as_a_whole_is_a_rod() {
    let section = Section::solid(DIAMETER).unwrap();
    let polar = steel().density * section.polar_moment() * LENGTH;
    for shear in [0.9, f64::INFINITY] {
        let element = BeamElement::new(section, steel(), shear, LENGTH).unwrap();
        let g = element.gyroscopic();
        // Unit tilts about the first node: θx moves y by −z, θy moves x by z.
        let mut about_x = [0.0; 12];
        (about_x[3], about_x[9], about_x[7]) = (1.0, 1.0, -LENGTH);
        let mut about_y = [0.0; 12];
        (about_y[4], about_y[10], about_y[6]) = (1.0, 1.0, LENGTH);
        let form = |left: &[f64; 12], right: &[f64; 12]| -> f64 {
            let row = |i: usize| (0..12).map(|j| g[i][j] * right[j]).sum::<f64>();
            (0..12).map(|i| left[i] * row(i)).sum()
        };
        assert!((form(&about_x, &about_y) / polar - 1.0).abs() < 1e-12);
        assert!((form(&about_y, &about_x) / polar + 1.0).abs() < 1e-12);
        for i in 0..12 {
            for j in 0..12 {
                assert_eq!(g[i][j], -g[j][i]);
            }
        }
    }
}

fn planar(matrix: &Mat<f64>) -> [[f64; 2]; 2] {
    [
        [matrix[(0, 0)], matrix[(0, 1)]],
        [matrix[(1, 0)], matrix[(1, 1)]],
    ]
}

#[test]
fn dampers_between_nodes_feel_their_difference() {
    let mut assembly = Assembly::new();
    let (a, b) = (assembly.add_node(), assembly.add_node());
    let damping = [[3.0, 0.5], [0.5, 2.0]];
    assembly.add_dampers(a, Some(b), damping).unwrap();
    assembly
        .add_dampers(a, None, [[7.0, 0.0], [0.0, 0.0]])
        .unwrap();
    assembly.add_drag(b, None, 11.0).unwrap();
    let c = assembly.matrices().unwrap().coupling.unwrap().damping;
    assert_eq!(planar(&c), [[10.0, 0.5], [0.5, 2.0]]);
    for i in 0..2 {
        for j in 0..2 {
            assert_eq!(c[(6 + i, 6 + j)], damping[i][j]);
            assert_eq!([c[(i, 6 + j)], c[(6 + i, j)]], [-damping[i][j]; 2]);
        }
    }
    assert_eq!(c[(11, 11)], 11.0);
    // The power of the damping matrix is that of the dampers at their velocities.
    let v = [0.3, -0.2, 0.0, 0.0, 0.0, 0.0, 1.1, 0.7, 0.0, 0.0, 0.0, -2.0];
    let power: f64 = (0..12)
        .flat_map(|i| (0..12).map(move |j| (i, j)))
        .map(|(i, j)| v[i] * c[(i, j)] * v[j])
        .sum();
    let (x, y) = (v[0] - v[6], v[1] - v[7]);
    let exact = 3.0 * x * x + x * y + 2.0 * y * y + 7.0 * v[0] * v[0] + 11.0 * v[11] * v[11];
    assert!((power / exact - 1.0).abs() < 1e-14);
}

fn one_mass(stiffness: f64, mass: f64) -> Assembly {
    let mut assembly = Assembly::new();
    let node = assembly.add_node();
    fix(&mut assembly, node, &Freedom::ALL[2..]);
    let body = Disc {
        mass,
        transverse_inertia: 0.0,
        polar_inertia: 0.0,
    };
    assembly.add_disc(node, body).unwrap();
    assembly
        .add_spring(node, [stiffness, stiffness, 0.0, 0.0, 0.0, 0.0])
        .unwrap();
    assembly
}

/// `k_xy = −k_yx = k_c > 0` feeds a whirl from x to y and nothing else:
/// `λ² = −(k ∓ i k_c)/m`.
#[test]
fn cross_coupled_springs_drive_a_whirl() {
    let (stiffness, mass, cross) = (1e6, 2.0, 3e4);
    let mut assembly = one_mass(stiffness, mass);
    assembly
        .add_cross_springs(0, None, [cross, -cross])
        .unwrap();
    let matrix = assembly
        .matrices()
        .unwrap()
        .coupling
        .unwrap()
        .cross_stiffness;
    assert_eq!(planar(&matrix), [[0.0, cross], [-cross, 0.0]]);
    // Power of −K_c u on the whirl u = (cos, sin), u' = (−sin, cos).
    for angle in [0.0, 0.4, 2.0] {
        let (sin, cos) = f64::sin_cos(angle);
        let force = [-cross * sin, cross * cos];
        let k = planar(&matrix);
        for i in 0..2 {
            assert!((force[i] + k[i][0] * cos + k[i][1] * sin).abs() < 1e-9);
        }
        assert!(-force[0] * sin + force[1] * cos > 0.99 * cross);
    }
    let (frequency, coupling) = coupled(&assembly);
    let growing = (Complex64::new(-stiffness, cross) / mass).sqrt();
    let fastest = (rates(&frequency, &coupling, 0.0).iter())
        .map(|rate| rate.re)
        .fold(0.0, f64::max);
    assert!((fastest / growing.re - 1.0).abs() < 1e-12);
    assert!(growing.re > 10.0);
}

/// A damped mass in both directions: `λ = −c/(2m) ± i …`.
#[test]
fn dampers_damp() {
    let mut assembly = one_mass(1e6, 2.0);
    assembly
        .add_dampers(0, None, [[80.0, 0.0], [0.0, 20.0]])
        .unwrap();
    let (frequency, coupling) = coupled(&assembly);
    let mut found: Vec<f64> = (rates(&frequency, &coupling, 0.0).iter())
        .map(|rate| rate.re)
        .collect();
    found.sort_by(f64::total_cmp);
    for (found, exact) in found.iter().zip([-20.0, -20.0, -5.0, -5.0]) {
        assert!((found - exact).abs() < 1e-9, "{found}");
    }
}

#[test]
fn misuse_is_refused() {
    let mut assembly = Assembly::new();
    let node = assembly.add_node();
    let missing = ShaftError::NoSuchNode { node: 1, nodes: 1 };
    let none = [[0.0; 2]; 2];
    assert_eq!(assembly.add_dampers(node, Some(1), none), Err(missing));
    assert!(matches!(
        assembly.add_dampers(node, None, [[-1.0, 0.0], [0.0, 0.0]]),
        Err(ShaftError::Gear(GearError::Negative { .. }))
    ));
    assert!(matches!(
        assembly.add_cross_springs(node, None, [0.0, f64::NAN]),
        Err(ShaftError::NotFinite { .. })
    ));
    assert!(assembly.add_drag(node, None, -1.0).is_err());
    let AssembledMatrices { coupling, .. } = assembly.matrices().unwrap();
    assert!(coupling.is_none());
}
