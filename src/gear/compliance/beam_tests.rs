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

fn default_pair(teeth: [u32; 2]) -> [Tooth; 2] {
    let pair = crate::gear::GearPair {
        teeth,
        module: 4e-3,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        face_width: 20e-3,
        body_length: [20e-3; 2],
        rated_torque: 50.0,
        form: crate::gear::ToothForm::default(),
    };
    [0, 1].map(|index| Tooth::new(&pair, index).unwrap())
}

fn parts(gear: &Tooth, roll: f64, nodes: usize) -> [f64; 3] {
    let compliance = tooth(gear, roll, &STEEL, &GaussLegendre::new(nodes));
    [compliance.bending, compliance.shear, compliance.axial]
}

/// The error falls geometrically, by thirty or more for each four nodes until round-off.
#[test]
fn quadrature_converges_on_every_profile() {
    for gear in default_pair([18, 200]) {
        for roll in [
            gear.form_roll + 0.01,
            0.5 * (gear.form_roll + gear.tip_roll),
            gear.tip_roll,
        ] {
            let exact = parts(&gear, roll, 64);
            let error = |nodes: usize| -> f64 {
                (parts(&gear, roll, nodes).iter().zip(&exact))
                    .map(|(value, exact)| (value / exact - 1.0).abs())
                    .fold(0.0, f64::max)
            };
            for nodes in [4, 8, 12] {
                let (coarse, fine) = (error(nodes), error(nodes + 4));
                assert!(
                    fine < (coarse / 30.0).max(1e-12),
                    "{nodes}: {coarse} {fine}"
                );
            }
            let taken = error(crate::gear::flanks::NODES);
            assert!(taken < 1e-10, "{taken}");
        }
    }
}

/// Against slices of equal height whose thickness is looked up on the profile: no derivative of
/// the curves and no Gauss rule.
#[test]
fn slices_of_equal_height_give_the_same() {
    for gear in default_pair([20, 30]) {
        let roll = 0.7 * gear.tip_roll + 0.3 * gear.form_roll;
        let point = gear.flank(roll);
        let [joint, root] = gear.fillet_range();
        let (foot, seam) = (gear.fillet(root).y, gear.fillet(joint).y);
        // Half the thickness at a height, by bisection in the parameter of the curve.
        let half = |height: f64| {
            let (mut low, mut high, curve): (f64, f64, &dyn Fn(f64) -> (f64, f64)) =
                if height < seam {
                    (root, joint, &|t| (gear.fillet(t).x, gear.fillet(t).y))
                } else {
                    (gear.form_roll, roll, &|t| {
                        (gear.flank(t).x, gear.flank(t).y)
                    })
                };
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if curve(middle).1 < height {
                    low = middle
                } else {
                    high = middle
                }
            }
            curve(low).0
        };
        let (sin, cos) = gear.force_angle(roll).sin_cos();
        let load = Load {
            height: point.y,
            arm: point.x,
            sin,
            cos,
        };
        let count = 20_000;
        let dy = (point.y - foot) / f64::from(count);
        let slices = (0..count).map(|i| {
            let height = foot + (f64::from(i) + 0.5) * dy;
            Slice {
                height,
                half: half(height),
                dy,
            }
        });
        let sum = cantilever(&load, &STEEL, slices);
        let taken = parts(&gear, roll, crate::gear::flanks::NODES);
        for (one, other) in [sum.bending, sum.shear, sum.axial].iter().zip(taken) {
            assert!((one / other - 1.0).abs() < 2e-5, "{one} {other}");
        }
    }
}
