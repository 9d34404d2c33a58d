//! Which values does no gear drive have? Bounds are far outside the values in handbooks (module, face width, backlash:
//! ISO 53, ISO 6336-1, ISO/TR 10064-2; stresses: ISO 6336-5, the best case-hardened steels). A value beyond a bound
//! usually has the wrong unit.

use super::sizes;
use crate::analysis::Effort;
use crate::gear::GearPair;
use crate::manifest::schema::number;
use crate::manifest::slip::length;
use crate::manifest::{DampingSpec, StructureSource, Variant};
use crate::shaft::GearPlace;
use crate::units::short;
use std::f64::consts::PI;

/// Largest load and speed of a grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct LargestOperation {
    /// Load, divided by the rated mesh force.
    pub load: f64,
    /// Speed of the pinion \[rad/s\].
    pub speed: f64,
}

/// Upper bound of the half gap in modules; drives have 0.01 to 0.1.
const MOST_GAP: f64 = 0.2;
/// Upper bound of the half gap without a drawing \[m\].
const MOST_GAP_LENGTH: f64 = 1e-3;
/// Upper bound of the half gap without a drawing, divided by the mesh deflection under the rated force. Drives have 1
/// to 1000. Dimensionless oscillators have similar ratios, whatever their gap is in metres.
const MOST_GAP_DEFLECTIONS: f64 = 1e3;
/// Lower bound of the half gap \[m\], below roughness.
const LEAST_GAP: f64 = 1e-7;
/// Modules \[m\].
const MODULE: [f64; 2] = [1e-4, 0.1];
/// Upper bound of the face width, divided by the pinion's reference diameter; 0.2 to 1.5 is usual.
const MOST_WIDTH: f64 = 4.0;
/// Mesh stiffness per face width \[N/m²\]; steel has 1e10 to 2.5e10, plastic 1e8.
const STIFFNESS: [f64; 2] = [2e7, 1e11];
/// Upper bound of the contact damping ratio; measured values are 0.01 to 0.2.
const MOST_DAMPING: f64 = 0.5;
/// Upper bound of the damping ratio of elastic modes.
const MOST_MODAL_DAMPING: f64 = 0.3;
/// Upper bound of the coefficient of friction.
const MOST_FRICTION: f64 = 0.5;
/// Upper bound of the Hertzian pressure \[Pa\]; the static strength of case-hardened flanks is 2.5e9.
const MOST_PRESSURE: f64 = 4e9;
/// Upper bound of the nominal root stress \[Pa\]; case-hardened teeth withstand 1e9 in a million cycles, 2.5e9 in one.
const MOST_ROOT_STRESS: f64 = 3e9;
/// Form factor times stress correction factor of a tooth loaded at its tip, ISO 6336-3: 3.5 to 5.
const ROOT_FACTOR: f64 = 4.3;
/// Upper bound of the speed of the pitch circle \[m/s\]; turbo gears reach 200.
const MOST_PITCH_SPEED: f64 = 300.0;
/// Upper bound of the pinion speed without a drawing \[rad/s\].
const MOST_SPEED: f64 = 2e4;
/// Upper bound of the amplitude of transmission error in modules.
const MOST_ERROR: f64 = 0.05;
/// Upper bound of the amplitude of transmission error without a drawing, in half gaps.
const MOST_ERROR_GAPS: f64 = 100.0;
/// Upper bound of the amplitude of torque ripple, divided by the rated torque.
const MOST_RIPPLE: f64 = 20.0;
/// Density \[kg/m³\], from foamed plastic to tungsten.
const DENSITY: [f64; 2] = [300.0, 2e4];
/// Young's modulus \[Pa\], from soft plastic to tungsten carbide.
const YOUNG: [f64; 2] = [1e8, 8e11];

/// Keys with values that no gear drive has, each with a message about its value.
pub(super) fn suspects(variant: &Variant, operating: LargestOperation) -> Vec<(String, String)> {
    let mut words = Words(Vec::new());
    let gears = variant.model.source.gears();
    let is_oscillator = variant.mesh.length.is_some();
    if !is_oscillator {
        mesh(variant, gears.as_ref(), &mut words);
        excitation(variant, gears.as_ref(), &mut words);
    }
    drive(variant, &mut words);
    words.0.extend(sizes::of_shafts(&variant.model.source));
    budget(variant, &mut words);
    match &gears {
        Some(gears) => {
            let keys = drawing_keys(&variant.model.source);
            drawing(gears, &keys, operating, &mut words);
        }
        None => words.add(
            operating.speed > MOST_SPEED && !is_oscillator,
            "grid.speed",
            format!(
                "{:.0} rpm is unusually fast for a gear drive",
                rpm(operating.speed)
            ),
        ),
    }
    words.0
}

struct Words(Vec<(String, String)>);

impl Words {
    fn add(&mut self, suspect: bool, key: &str, message: String) {
        if suspect {
            self.0.push((key.to_owned(), message));
        }
    }
}

/// Advice if `run.cycles` is below the number of measured cycles at which errors are first read.
fn budget(variant: &Variant, words: &mut Words) {
    let Some(config) = variant.analyses.lyapunov else {
        return;
    };
    let (cycles, first) = (variant.run.cycles, config.effort.first_look());
    let advice = match config.effort {
        Effort::Verified => {
            "; points that do not settle end as not_converged: raise it, or set analyses.lyapunov.effort = \"survey\""
        }
        Effort::Survey => {
            "; with fewer, the errors of points that do not settle are too small: raise it"
        }
    };
    words.add(
        cycles < first,
        "run.cycles",
        format!(
            "{cycles} is less than {first}, the measured cycles at which errors are first read{advice}"
        ),
    );
}

fn mesh(variant: &Variant, gears: Option<&GearPair>, words: &mut Words) {
    let mesh = &variant.mesh;
    let gap = mesh.half_gap;
    match gears {
        Some(gears) => words.add(
            gap > MOST_GAP * gears.module,
            "mesh.half_gap",
            format!(
                "{} is {:.2} modules; drives have 0.01 to 0.1",
                length(gap),
                gap / gears.module
            ),
        ),
        None => words.add(
            gap > MOST_GAP_LENGTH && gap > MOST_GAP_DEFLECTIONS * deflection(variant),
            "mesh.half_gap",
            format!(
                "{} is unusually wide for a gear drive (usual: about 10 um)",
                length(gap)
            ),
        ),
    }
    words.add(
        gap < LEAST_GAP,
        "mesh.half_gap",
        format!(
            "{} is less than the roughness of flanks; usual values are about 10 um",
            length(gap)
        ),
    );
    if let (Some(gears), Some(mean)) = (gears, mesh.stiffness.mean()) {
        let each = mean / gears.face_width;
        words.add(
            !(STIFFNESS[0]..=STIFFNESS[1]).contains(&each),
            "mesh.mean_stiffness",
            format!(
                "{mean:.3e} N/m over a face of {} is {} N/(mm um); steel gears have 10 to 25",
                length(gears.face_width),
                short(1e-9 * each, 3)
            ),
        );
    }
    if let DampingSpec::Ratio(ratio) = mesh.damping {
        words.add(
            ratio > MOST_DAMPING,
            "mesh.contact_damping",
            format!(
                "a damping ratio of {} is unusually high for gear contacts (measured: 0.01 to 0.2)",
                number(ratio)
            ),
        );
    }
    if let Some(friction) = mesh.friction.constant() {
        words.add(
            friction > MOST_FRICTION,
            "mesh.friction",
            format!(
                "a coefficient of {} is typical of dry, seizing flanks; lubricated flanks have 0.02 to 0.1",
                number(friction)
            ),
        );
    }
}

/// Deflection of the mesh under the rated force \[m\]; 0 if unknown.
fn deflection(variant: &Variant) -> f64 {
    let force = variant.model.source.rated_force();
    let stiffness = variant.mesh.stiffness.mean();
    force
        .zip(stiffness)
        .map_or(0.0, |(force, stiffness)| force / stiffness)
}

fn excitation(variant: &Variant, gears: Option<&GearPair>, words: &mut Words) {
    let excitation = &variant.excitation;
    let most = gears.map_or(MOST_ERROR_GAPS * variant.mesh.half_gap, |gears| {
        MOST_ERROR * gears.module
    });
    for (index, term) in excitation.transmission_error.iter().enumerate() {
        let amplitude = term.amplitude.abs();
        words.add(
            amplitude > most,
            &format!("excitation.transmission_error.{index}.amplitude"),
            format!(
                "{} is unusually large for a tooth error (usual: 0.1 to 20 um)",
                length(amplitude)
            ),
        );
    }
    let Some(gears) = gears else { return };
    for (index, ripple) in excitation.torque_ripple.iter().enumerate() {
        let amplitude = ripple.amplitude.abs();
        words.add(
            amplitude > MOST_RIPPLE * gears.rated_torque,
            &format!("excitation.torque_ripple.{index}.amplitude"),
            format!(
                "{} N m is {} times the rated torque, which is unusually large",
                number(amplitude),
                short(amplitude / gears.rated_torque, 0)
            ),
        );
    }
}

/// Keys of the module, the face width and the rated torque of a drawing.
fn drawing_keys(source: &StructureSource) -> [String; 3] {
    let StructureSource::Train(train) = source else {
        return ["module", "face_width", "rated_torque"].map(|key| format!("gear.{key}"));
    };
    // Shafts of planets, which have other keys, come last.
    let [one, two] = train.gears;
    let GearPlace { shaft, gear } = if one.shaft < two.shaft { one } else { two };
    let [module, width] =
        ["module", "width"].map(|key| format!("train.shaft.{shaft}.gears.{gear}.{key}"));
    [module, width, "train.rated_torque".to_owned()]
}

/// Advice on the drawing of the gears, with the [`drawing_keys`].
fn drawing(
    gears: &GearPair,
    [module_key, width_key, torque_key]: &[String; 3],
    operating: LargestOperation,
    words: &mut Words,
) {
    let (module, width) = (gears.module, gears.face_width);
    words.add(
        !(MODULE[0]..=MODULE[1]).contains(&module),
        module_key,
        format!(
            "{} is an unusual module (usual: 0.1 to 100 mm)",
            length(module)
        ),
    );
    let [pinion, wheel] = gears.pitch_radii();
    words.add(
        width > MOST_WIDTH * 2.0 * pinion,
        width_key,
        format!(
            "{} is {:.1} times the pinion's diameter, which is unusually wide (usual: up to 1 to 2)",
            length(width),
            0.5 * width / pinion
        ),
    );
    let speed = operating.speed * pinion;
    words.add(
        speed > MOST_PITCH_SPEED,
        "grid.speed",
        format!(
            "at {:.0} rpm the pitch line moves at {speed:.0} m/s, which is unusually fast; turbo gears reach 200 m/s",
            rpm(operating.speed)
        ),
    );
    let force = operating.load * gears.rated_force();
    let root = ROOT_FACTOR * force / (width * module);
    let compliances = gears
        .form
        .material
        .iter()
        .map(|m| (1.0 - m.poisson_ratio.powi(2)) / m.young_modulus);
    let sin = gears.transverse_pressure_angle().sin();
    let curvature = (1.0 / pinion + 1.0 / wheel) / sin;
    let pressure = (force * curvature / (width * PI * compliances.sum::<f64>())).sqrt();
    words.add(
        root > MOST_ROOT_STRESS || pressure > MOST_PRESSURE,
        torque_key,
        format!(
            "at the largest load of the grid the stress is about {:.2e} MPa at the tooth root and {:.2e} MPa on the \
             flank, which exceeds the strength of any steel",
            1e-6 * root,
            1e-6 * pressure
        ),
    );
}

/// Advice on shafts, bodies and materials.
fn drive(variant: &Variant, words: &mut Words) {
    let (gears, shafts, density, young, damping) = match &variant.model.source {
        StructureSource::Flexible(drive) => (
            &drive.gears,
            &drive.shafts,
            drive.density,
            Some(drive.young_modulus),
            drive.damping,
        ),
        StructureSource::Rigid(drive) => (
            &drive.gears,
            &drive.shafts,
            drive.density,
            None,
            drive.damping,
        ),
        StructureSource::Train(_) | StructureSource::Modal(_) => return,
    };
    words.add(
        damping > MOST_MODAL_DAMPING,
        "model.damping",
        format!(
            "a damping ratio of {damping} is unusually high for shafts in bearings (usual: 0.005 to 0.1)"
        ),
    );
    words.add(
        !(DENSITY[0]..=DENSITY[1]).contains(&density),
        "shafts.density",
        format!("{density} kg/m^3 is an unusual density (steel has 7850)"),
    );
    words.add(
        young.is_some_and(|young| !(YOUNG[0]..=YOUNG[1]).contains(&young)),
        "shafts.young_modulus",
        format!(
            "{:.3e} Pa is an unusual Young's modulus (steel has 2.06e11)",
            young.unwrap_or_default()
        ),
    );
    for (index, name) in ["pinion", "wheel"].into_iter().enumerate() {
        let (shaft, other) = (&shafts[index], &shafts[1 - index]);
        let tip =
            gears.pitch_radii()[index] + (1.0 + gears.form.profile_shift[index]) * gears.module;
        if let Ok(centres) = gears.centre_distance() {
            words.add(
                tip + 0.5 * other.diameter > centres,
                &format!("shafts.{}.diameter", ["wheel", "pinion"][index]),
                format!(
                    "this shaft of {} and the tip circle of the {name} do not fit into a centre distance of {}",
                    length(other.diameter),
                    length(centres)
                ),
            );
        }
        let room = 2.0 * shaft.span * shaft.gear_position.min(1.0 - shaft.gear_position);
        words.add(
            gears.body_length[index] > room && variant.model.source.kind() == "flexible",
            "gear.body_length",
            format!(
                "the {name}'s body of {} does not fit between bearings {} apart",
                length(gears.body_length[index]),
                length(shaft.span)
            ),
        );
    }
}

/// Converts rad/s to revolutions per minute.
fn rpm(speed: f64) -> f64 {
    speed * 30.0 / PI
}
