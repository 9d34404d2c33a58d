//! Mesh stiffness compared with published values (`tests/data/mesh-stiffness.toml`), within the margins of the methods.
//! Each test explains its margin.

#![allow(clippy::unwrap_used)]

use gearatlas::gear::{
    FlankLaw, Flanks, GearPair, Material, PairCompliance, SecantContact, Tooth, ToothForm,
};
use std::f64::consts::PI;

/// Root diameter over bore of a solid disc on its shaft.
const DISC: f64 = 3.0;

/// Root diameter over bore of a body that is supported just below its rim.
const RIM: f64 = 1.4;

fn published(table: &str) -> toml::Table {
    let file: toml::Table = include_str!("../data/mesh-stiffness.toml").parse().unwrap();
    file[table].as_table().unwrap().clone()
}

fn number(table: &toml::Table, key: &str) -> f64 {
    table[key].as_float().unwrap()
}

fn steel_pair(teeth: [u32; 2], module: f64, shift: [f64; 2]) -> GearPair {
    GearPair {
        teeth,
        module,
        pressure_angle: 20f64.to_radians(),
        helix_angle: 0.0,
        face_width: 20e-3,
        body_length: [20e-3; 2],
        rated_torque: 50.0,
        form: ToothForm {
            profile_shift: shift,
            ..ToothForm::default()
        },
    }
}

/// The pair on bodies with a ratio of root diameter to bore.
fn on_bodies(mut pair: GearPair, ratio: f64) -> Flanks {
    for index in [0, 1] {
        let root = Tooth::new(&pair, index).unwrap().root_radius;
        pair.form.bore[index] = Some(2.0 * root / ratio);
    }
    Flanks::new(&pair).unwrap_or_else(|error| panic!("{error}"))
}

/// Torsional compliance of the bodies between bore and root, per unit width and in plane stress. All pairs share it,
/// `Σ (r_b/r_f)² ((r_f/r_i)² − 1) (1 + ν)/(2 π E)`.
fn winding(flanks: &Flanks, ratio: f64, material: &Material) -> f64 {
    let disc = (ratio * ratio - 1.0) * (1.0 + material.poisson_ratio)
        / (2.0 * PI * material.young_modulus);
    let arm = |tooth: &Tooth| tooth.base_radius / tooth.root_radius;
    flanks
        .teeth
        .iter()
        .map(|tooth| disc * arm(tooth).powi(2))
        .sum()
}

/// Stiffness per unit width of one or two pairs at a mesh phase, with shared bodies.
fn shared(flanks: &Flanks, s: f64, compliance: &dyn Fn(f64) -> PairCompliance) -> f64 {
    let near = compliance(s);
    match flanks.body_coupling(s, 1) {
        None => near.total().recip(),
        Some(coupling) => {
            let far = compliance(s + flanks.path().base_pitch);
            let parallel = near.uncoupled(coupling).recip() + far.uncoupled(coupling).recip();
            (parallel.recip() + coupling[0] + coupling[1]).recip()
        }
    }
}

/// Mean over the mesh cycle.
fn mean(flanks: &Flanks, value: impl Fn(f64) -> f64) -> f64 {
    let count = 500;
    let phase = |i: i32| (f64::from(i) + 0.5) / f64::from(count);
    (0..count)
        .map(|i| value(flanks.path().position(phase(i))))
        .sum::<f64>()
        / f64::from(count)
}

fn within(value: f64, published: f64, margin: f64) {
    let deviation = value / published - 1.0;
    assert!(
        deviation.abs() < margin,
        "{value:e}: {:+.1} %",
        100.0 * deviation
    );
}

/// With separate bodies per pair the mean stiffness is 4.133e8 N/m, 10.6 % above the published one. The other program
/// models teeth as cantilevers on a fitted foundation, which counts a part of the root twice. Such a program whose
/// lever is the height where the force crosses the centre line has 3.905e8 N/m. With shared bodies the mean is
/// 3.05e8 N/m: separate bodies make two pairs a third too stiff.
#[test]
fn another_code_without_shared_bodies() {
    let table = published("other_code");
    let mut pair = steel_pair([62, 62], number(&table, "module"), [0.0; 2]);
    pair.form.bore = [Some(number(&table, "bore")); 2];
    let flanks = Flanks::new(&pair).unwrap();
    assert!((flanks.contact_ratio() - number(&table, "contact_ratio")).abs() < 1e-5);
    let width = number(&table, "face_width");
    let apart = mean(&flanks, |s| {
        let next = s + flanks.path().base_pitch;
        let alone = |s| width / flanks.compliance(s).total();
        if next > flanks.path().end { alone(s) } else { alone(s) + alone(next) }
    });
    within(apart, number(&table, "mean_stiffness"), 0.12);
    // The larger published value for the pair is not computed.
    let young_modulus = number(&table, "young_modulus");
    let thumb = flanks.contact_ratio() * width * young_modulus / 18.0;
    within(thumb, number(&table, "rule_of_thumb"), 1e-4);
    let together = mean(&flanks, |s| {
        width * shared(&flanks, s, &|s| flanks.compliance(s))
    });
    assert!(together < 0.8 * apart, "{together:e} {apart:e}");
}

/// Solid discs on shafts of a third of their root diameter. The torsion of a disc between root and bore is not a
/// deflection of teeth and is subtracted here. At ISO's load the mean stiffness is within 13 %, and 17 % above for the
/// smallest pinions with large shift. The stiffness of one pair is up to 15 % above, and 28 % for those pinions. A
/// linear contact with the flattening at zero load is too stiff for this: c' is then 20 to 62 % above.
///
/// ISO's c' and c_γ are based on Weber and Banaschek's deflections, multiplied by 0.8 to agree with tests; their
/// scatter is 10 %.
#[test]
fn iso_method_b_at_its_own_load() {
    let table = published("iso");
    let c: Vec<f64> = (table["coefficients"].as_array().unwrap().iter())
        .map(|value| value.as_float().unwrap())
        .collect();
    let load = number(&table, "line_load");
    // Module, profile shift; deviations of c' and c_γ at ISO's load and with the linear contact:
    for (teeth, module, shift, loaded, linear) in [
        ([20, 30], 4e-3, [0.0, 0.0], [0.135, 0.022], [0.406, 0.218]),
        (
            [19, 48],
            3.175e-3,
            [0.0, 0.0],
            [0.097, -0.026],
            [0.339, 0.145],
        ),
        ([20, 30], 4e-3, [0.3, 0.2], [0.146, 0.033], [0.445, 0.252]),
        ([40, 40], 3e-3, [0.0, 0.0], [0.080, -0.057], [0.301, 0.090]),
        ([62, 62], 2e-3, [0.0, 0.0], [0.036, -0.125], [0.204, -0.021]),
        ([24, 96], 3e-3, [0.2, -0.2], [0.036, -0.104], [0.245, 0.035]),
        ([17, 17], 3e-3, [0.3, 0.3], [0.276, 0.166], [0.623, 0.432]),
    ] {
        let flanks = on_bodies(steel_pair(teeth, module, shift), DISC);
        let winding = winding(&flanks, DISC, &Material::default());
        let [z1, z2] = teeth.map(f64::from);
        let [x1, x2] = shift;
        let q = c[0]
            + c[1] / z1
            + c[2] / z2
            + c[3] * x1
            + c[4] * x1 / z1
            + c[5] * x2
            + c[6] * x2 / z2
            + c[7] * x1 * x1
            + c[8] * x2 * x2;
        let rack = 1.0 + 0.5 * (1.2 - 1.25);
        // N/(mm µm) are 1e9 N/m².
        let single = 1e9 * number(&table, "theory_to_test") * rack / q;
        let mesh = single * (0.75 * flanks.contact_ratio() + 0.25);
        let path = flanks.path();
        let compare = |compliance: &dyn Fn(f64) -> PairCompliance, expected: [f64; 2]| {
            let stiffest = (0..=100)
                .map(|i| path.start + (path.end - path.start) * f64::from(i) / 100.0)
                .map(|s| (compliance(s).total() - winding).recip())
                .fold(0.0, f64::max);
            let own = mean(&flanks, |s| {
                (shared(&flanks, s, compliance).recip() - winding).recip()
            });
            for (value, expected) in [stiffest / single, own / mesh].iter().zip(expected) {
                let deviation = value - 1.0;
                assert!(
                    (deviation - expected).abs() < 2e-3,
                    "{teeth:?}: {deviation:+.3}"
                );
            }
        };
        let under_load = SecantContact {
            law: &flanks,
            line_load: load,
        };
        compare(&|s| under_load.compliance(s), loaded);
        compare(&|s| flanks.compliance(s), linear);
    }
}

/// On bores of 50 and 78.57 mm, under the drive's rated 66.5 N/mm, double pairs are 2.8 % above and single pairs 14 %
/// below the published levels; the mean is 2.7 % below 4e8 N/m. With the linear contact, double pairs are 30 % and
/// single pairs 15 % above. On bores as small as the drive's shafts all are 40 % softer: the published levels assume
/// bodies without torsion.
#[test]
fn calibrated_levels_of_the_default_pair() {
    let table = published("calibrated");
    let pair = steel_pair([20, 30], number(&table, "module"), [0.0; 2]);
    let line_load = pair.rated_force() / pair.face_width;
    let flanks = on_bodies(pair, RIM);
    let width = number(&table, "face_width");
    let path = flanks.path();
    let [lowest, highest] = path.single_pair().unwrap();
    let levels = |compliance: &dyn Fn(f64) -> PairCompliance| -> [f64; 3] {
        let stiffness = |s: f64| width * shared(&flanks, s, compliance);
        let average = |from: f64, to: f64| -> f64 {
            (0..100)
                .map(|i| stiffness(from + (to - from) * (f64::from(i) + 0.5) / 100.0))
                .sum::<f64>()
                / 100.0
        };
        let (double, single) = (average(path.start, lowest), average(lowest, highest));
        [double, single, mean(&flanks, stiffness)]
    };
    let under_load = SecantContact {
        law: &flanks,
        line_load,
    };
    let [double, single, all] = levels(&|s| under_load.compliance(s));
    within(double, number(&table, "double_pair"), 0.05);
    within(single, number(&table, "single_pair"), 0.16);
    within(all, 4e8, 0.05);
    let [double, single, _] = levels(&|s| flanks.compliance(s));
    within(double, 1.3 * number(&table, "double_pair"), 0.01);
    within(single, 1.15 * number(&table, "single_pair"), 0.01);
}

/// A cast-iron wheel on a steel pinion: ISO has one factor for all such pairs.
#[test]
fn unlike_materials() {
    let table = published("iso");
    let steel = on_bodies(steel_pair([20, 30], 4e-3, [0.0; 2]), DISC);
    let mut mixed = steel_pair([20, 30], 4e-3, [0.0; 2]);
    mixed.form.material[1] = Material {
        young_modulus: number(&table, "cast_iron_alone") * 206e9,
        poisson_ratio: 0.25,
    };
    let mixed = on_bodies(mixed, DISC);
    let ratio = mean(&mixed, |s| shared(&mixed, s, &|s| mixed.compliance(s)))
        / mean(&steel, |s| shared(&steel, s, &|s| steel.compliance(s)));
    within(ratio, number(&table, "cast_iron_on_steel"), 0.03);
}
