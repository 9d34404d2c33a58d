//! Mesh stiffness against what others give (`tests/data/mesh-stiffness.toml`), with the margins
//! that the methods leave; each test says why its margin is what it is.

#![allow(clippy::unwrap_used)]

use atlas::gear::{Flanks, GearPair, Material, PairCompliance, Tooth, ToothForm};

/// Root diameter over bore of a body that is held right below its rim: the least of the fit.
const RIM: f64 = 1.4;

fn published(table: &str) -> toml::Table {
    let file: toml::Table = include_str!("data/mesh-stiffness.toml").parse().unwrap();
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

/// The pair on bodies that are held below their rims, as ISO's solid discs are thought to be.
fn on_rims(mut pair: GearPair) -> Flanks {
    for index in [0, 1] {
        let root = Tooth::new(&pair, index).unwrap().root_radius;
        pair.form.bore[index] = Some(2.0 * root / RIM * (1.0 - 1e-12));
    }
    Flanks::new(&pair).unwrap_or_else(|error| panic!("{error}"))
}

/// Stiffness per unit width of one or two pairs at a mesh phase, bodies shared.
fn shared(flanks: &Flanks, s: f64, compliance: impl Fn(f64) -> PairCompliance) -> f64 {
    let near = compliance(s);
    match flanks.body_coupling(s, 1) {
        None => near.total().recip(),
        Some(coupling) => {
            let far = compliance(s + flanks.path().base_pitch);
            let parallel = near.own(coupling).recip() + far.own(coupling).recip();
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

/// 3.905e8 N/m, 4.5 % above, where each pair stands on bodies of its own. Laws in use differ by
/// that much: the lever taken to the contact's height and not to where the force crosses the
/// centre line makes 5 % less, the smaller root angle of some papers 2 % less. With shared bodies
/// it is 2.92e8 N/m: separate ones make two pairs a third too stiff.
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
        if next > flanks.path().end {
            alone(s)
        } else {
            alone(s) + alone(next)
        }
    });
    within(apart, number(&table, "mean_stiffness"), 0.06);
    // The larger figure that is also given for the pair is no computed one.
    let young_modulus = number(&table, "young_modulus");
    let thumb = flanks.contact_ratio() * width * young_modulus / 18.0;
    within(thumb, number(&table, "rule_of_thumb"), 1e-4);
    let together = mean(&flanks, |s| {
        width * shared(&flanks, s, |s| flanks.compliance(s))
    });
    assert!(together < 0.8 * apart, "{together:e} {apart:e}");
}

/// Bodies at the lower end of their law's fit, where finite elements find them 15 to 27 % too soft,
/// and a contact law that no manifest can choose: the agreement is of errors that cancel. With the
/// linear contact of the manifests c' is up to 42 % above.
///
/// ISO's c' and c_γ rest on Weber and Banaschek's deflections of discs with a stiff core,
/// multiplied by 0.8 to meet tests; scatter of its own 10 %.
#[test]
fn iso_method_b_at_its_own_load() {
    let table = published("iso");
    let c: Vec<f64> = (table["coefficients"].as_array().unwrap().iter())
        .map(|value| value.as_float().unwrap())
        .collect();
    let load = number(&table, "line_load");
    // Module, profile shift; deviations of c' and c_γ in per cent:
    for (teeth, module, shift) in [
        ([20, 30], 4e-3, [0.0, 0.0]),     // +5.9, +0.2
        ([19, 48], 3.175e-3, [0.0, 0.0]), // +2.5, −4.1
        ([20, 30], 4e-3, [0.3, 0.2]),     // +5.4, −0.8
        ([40, 40], 3e-3, [0.0, 0.0]),     // +1.8, −5.7
        ([62, 62], 2e-3, [0.0, 0.0]),     // −2.3, −12.1
        ([24, 96], 3e-3, [0.2, -0.2]),    // −3.6, −11.8
        ([17, 17], 3e-3, [0.3, 0.3]),     // +14.7, +8.5
    ] {
        let flanks = on_rims(steel_pair(teeth, module, shift));
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
        let path = flanks.path();
        let stiffest = (0..=100)
            .map(|i| path.start + (path.end - path.start) * f64::from(i) / 100.0)
            .map(|s| flanks.compliance_under(s, load).total().recip())
            .fold(0.0, f64::max);
        within(stiffest, single, 0.16);
        let mesh = single * (0.75 * flanks.contact_ratio() + 0.25);
        let own = mean(&flanks, |s| {
            shared(&flanks, s, |s| flanks.compliance_under(s, load))
        });
        within(own, mesh, 0.14);
        let linear = mean(&flanks, |s| shared(&flanks, s, |s| flanks.compliance(s)));
        assert!((0.97..1.32).contains(&(linear / mesh)), "{}", linear / mesh);
        assert!(linear > 1.08 * own, "{linear:e} {own:e}");
    }
}

/// On bores of 50 and 78.57 mm: double pairs 11 % above, single ones 6 % below, the mean 6 % above
/// 4e8 N/m (`flex80-table.toml` has 48 and 76 mm: 9.5 % above, 6.4 % below, 4.4 % above).
/// On cores as thin as the drive's shafts all is 35 % softer: the levels mean bodies that do not
/// wind up.
#[test]
fn calibrated_levels_of_the_default_pair() {
    let table = published("calibrated");
    let flanks = on_rims(steel_pair([20, 30], number(&table, "module"), [0.0; 2]));
    let width = number(&table, "face_width");
    let stiffness = |s: f64| width * shared(&flanks, s, |s| flanks.compliance(s));
    let path = flanks.path();
    let average = |from: f64, to: f64| -> f64 {
        (0..100)
            .map(|i| stiffness(from + (to - from) * (f64::from(i) + 0.5) / 100.0))
            .sum::<f64>()
            / 100.0
    };
    let [lowest, highest] = path.single_pair().unwrap();
    within(
        average(path.start, lowest),
        number(&table, "double_pair"),
        0.13,
    );
    within(
        average(lowest, highest),
        number(&table, "single_pair"),
        0.08,
    );
}

/// A cast-iron wheel on a steel pinion: ISO has one factor for all.
#[test]
fn unlike_materials() {
    let table = published("iso");
    let steel = on_rims(steel_pair([20, 30], 4e-3, [0.0; 2]));
    let mut mixed = steel_pair([20, 30], 4e-3, [0.0; 2]);
    mixed.form.material[1] = Material {
        young_modulus: number(&table, "cast_iron_alone") * 206e9,
        poisson_ratio: 0.25,
    };
    let mixed = on_rims(mixed);
    let ratio = mean(&mixed, |s| shared(&mixed, s, |s| mixed.compliance(s)))
        / mean(&steel, |s| shared(&steel, s, |s| steel.compliance(s)));
    within(ratio, number(&table, "cast_iron_on_steel"), 0.03);
}
