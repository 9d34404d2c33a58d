use super::*;

const STEEL: Material = Material {
    young_modulus: 206e9,
    poisson_ratio: 0.3,
};

/// A straight bar of half thickness x, 3 long and loaded at the end, at an angle.
fn bar(angle: f64, arm: f64) -> ToothCompliance {
    let rule = GaussLegendre::new(4);
    let (sin, cos) = angle.sin_cos();
    let load = Load {
        height: 3.0,
        arm,
        sin,
        cos,
    };
    let slices = nodes(&rule, 0.0, 3.0).map(|(height, dy)| Slice {
        height,
        half: 0.25,
        dy,
    });
    cantilever(&load, &STEEL, slices)
}

fn close(value: f64, expected: f64) {
    assert!((value / expected - 1.0).abs() < 1e-14, "{value} {expected}");
}

#[test]
fn a_straight_cantilever_gives_as_in_the_textbook() {
    let (young, shear) = (STEEL.young_modulus, STEEL.shear_modulus());
    let (area, inertia) = (0.5, 0.5f64.powi(3) / 12.0);
    let across = bar(0.0, 0.25);
    close(across.bending, 27.0 / (3.0 * young * inertia));
    close(across.shear, 1.2 * 3.0 / (shear * area));
    assert_eq!(across.axial, 0.0);
    // Pressed along the bar, off its centre line: a pure moment beside the compression.
    let along = bar(std::f64::consts::FRAC_PI_2, 0.25);
    close(along.bending, 0.0625 * 3.0 / (young * inertia));
    close(along.axial, 3.0 / (young * area));
    assert!(along.shear < 1e-30);
}
