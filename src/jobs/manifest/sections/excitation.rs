//! `[excitation]`: transmission error, errors of the gears, torque ripple and uneven rotation of either shaft.

use super::{Context, torque_curve};
use crate::manifest::reader::{Section, all_of};
use crate::manifest::spec::{CoastSpec, ExcitationSpec, MeshSpec, StiffnessSpec, StructureSource};
use crate::model::{ImposedMotion, MeshHarmonic, StiffnessHarmonic, TorqueRipple};
use std::f64::consts::TAU;

pub(super) fn read(
    section: &Section,
    source: Option<&StructureSource>,
    mesh: Option<&MeshSpec>,
    context: &mut Context,
) -> Option<ExcitationSpec> {
    let errors = harmonics(section, "transmission_error");
    const OF_COAST: &str = "coast_transmission_error";
    let same_line = mesh.is_some_and(|mesh| mesh.coast == CoastSpec::SameLine);
    if same_line {
        section.without_effect(
            &[OF_COAST],
            "with mesh.coast_flank = \"same_line\"",
            "remove it, or set mesh.coast_flank = \"mirrored\"",
        );
    }
    let of_coast = (section.if_effective(!same_line)).if_given(OF_COAST, harmonics);
    let teeth = source.map(|source| [false, true].map(|wheel| teeth(source, wheel)));
    let of_gears = errors_of_gears(section, ("shaft", ["pinion", "wheel"]), teeth)
        .map(|errors| errors.concat());
    let on_shafts = |name: &str| section.each(name, |table| ripple(table, source));
    let ripples = on_shafts("torque_ripple");
    let motions = on_shafts("imposed_motion");
    let curve = torque_curve::read(section, source, context);
    let idle = mesh.and_then(|mesh| match &mesh.stiffness {
        stiffness if stiffness.is_of_pairs() => Some((
            "with mesh.resolution = \"pairs\": the gaps of the pairs contain the error of the flanks",
            "remove it, or remove mesh.resolution",
        )),
        StiffnessSpec::Table(_) => None,
        _ => Some((
            "without a mesh table",
            "remove it, or set mesh.stiffness = \"table\"",
        )),
    });
    if let Some((why, remedy)) = idle {
        section.without_effect(&["table_harmonics"], why, remedy);
    }
    let table_harmonics =
        (section.if_effective(idle.is_none())).if_given("table_harmonics", Section::integer);
    Some(ExcitationSpec {
        table_harmonics: table_harmonics?,
        transmission_error: [errors?, of_gears.clone()?].concat(),
        // An error of tooth positions moves both flanks.
        coast_transmission_error: of_coast?
            .map(|of_coast| [of_coast, of_gears.unwrap_or_default()].concat()),
        torque_ripple: [ripples?, curve?].concat(),
        imposed_motion: (motions?.into_iter())
            .map(|motion| ImposedMotion {
                shaft: motion.shaft,
                order: motion.order,
                amplitude: motion.amplitude,
                phase: motion.phase,
            })
            .collect(),
    })
}

/// The harmonics of a stiffness, a list of tables; empty if it is absent.
pub(super) fn stiffness_harmonics(section: &Section) -> Option<Vec<StiffnessHarmonic>> {
    section.each("stiffness_harmonics", |table| {
        let (harmonic, amplitude, phase) = harmonic(table)?;
        Some(StiffnessHarmonic {
            harmonic,
            amplitude,
            phase,
        })
    })
}

/// The harmonics of a transmission error, a list of tables; empty if it is absent.
pub(super) fn harmonics(section: &Section, name: &str) -> Option<Vec<MeshHarmonic>> {
    section.each(name, |table| {
        let (harmonic, amplitude, phase) = harmonic(table)?;
        Some(MeshHarmonic::new(harmonic, amplitude, phase))
    })
}

/// Number, amplitude and phase of a harmonic.
fn harmonic(table: &Section) -> Option<(u32, f64, f64)> {
    let harmonic = table.integer("harmonic");
    let amplitude = table.quantity("amplitude");
    let phase = table.quantity("phase");
    Some((harmonic?, amplitude?, phase?))
}

/// Number of teeth of a gear of the first mesh, if known.
fn teeth(source: &StructureSource, wheel: bool) -> Option<u32> {
    match source {
        StructureSource::Modal(structure) if wheel => structure.wheel_teeth,
        StructureSource::Modal(structure) => Some(structure.teeth),
        // Gears on crossed axes have teeth, too.
        StructureSource::Train(train) => Some(train.pair.teeth[usize::from(wheel)]),
        drawn => drawn.gears().map(|gears| gears.teeth[usize::from(wheel)]),
    }
}

/// Errors that rotate with the two gears of a mesh, as orders of their shafts: those of `gear_error`, whose phases are
/// at time 0, then those of `pitch_deviation`, whose phases are at the start of a mesh cycle. In the manifest, the key
/// `key` names the gear by one of `names`. `teeth` has the known numbers of teeth; `None` if faults of the gears have
/// already been reported.
pub(super) fn errors_of_gears(
    section: &Section,
    (key, names): (&str, [&str; 2]),
    teeth: Option<[Option<u32>; 2]>,
) -> Option<[Vec<MeshHarmonic>; 2]> {
    let orders = section.each("gear_error", |table| {
        Some(order(table, (key, names), teeth))
    })?;
    let mut whole = teeth.is_some();
    let mut all = Vec::new();
    if let Some(deviation) = section.child("pitch_deviation").flatten() {
        for (gear, name) in names.into_iter().enumerate() {
            if !deviation.has(name) {
                continue;
            }
            let teeth = teeth.map(|teeth| teeth[gear]);
            match deviations(&deviation, name, teeth) {
                Some(values) => all.extend(orders_of_teeth(&values)),
                None => whole = false,
            }
        }
    }
    let orders: Option<Vec<MeshHarmonic>> = orders.into_iter().collect();
    let orders = orders?;
    whole.then_some([orders, all])
}

/// The error of a gear at one order of its shaft.
fn order(
    table: &Section,
    (key, names): (&str, [&str; 2]),
    teeth: Option<[Option<u32>; 2]>,
) -> Option<MeshHarmonic> {
    let gear = table.choice(key);
    let order = table.integer("order");
    let amplitude = table.quantity("amplitude");
    let phase = table.quantity("phase");
    let harmonic = MeshHarmonic::new(order?, amplitude?, phase?);
    let Some(cycles) = teeth?[usize::from(gear? == names[1])] else {
        unknown_teeth(table, key);
        return None;
    };
    Some(MeshHarmonic { cycles, ..harmonic })
}

/// Deviations of the teeth of a gear, one per tooth.
fn deviations(table: &Section, name: &str, teeth: Option<Option<u32>>) -> Option<Vec<f64>> {
    let values = table.quantities(name, None)?;
    let Some(teeth) = teeth? else {
        unknown_teeth(table, name);
        return None;
    };
    if values.len() == teeth as usize {
        return Some(values);
    }
    table
        .inconsistent(name, format!("{} values for {teeth} teeth", values.len()))
        .label("one value per tooth")
        .accepted(format!("give {teeth} lengths"))
        .fail(table.issues)
}

fn unknown_teeth(table: &Section, key: &str) {
    table
        .inconsistent(key, "the number of teeth of this gear is unknown")
        .label("unknown number of teeth")
        .remedy("add teeth_wheel to the modal file, or remove the error".to_owned())
        .report(table.issues);
}

/// The orders of a shaft whose sum has the values of the teeth minus their mean: the value of tooth n at the
/// start of mesh cycle n.
fn orders_of_teeth(values: &[f64]) -> Vec<MeshHarmonic> {
    let teeth = values.len();
    (1..=teeth / 2)
        .filter_map(|order| {
            let turn = TAU * order as f64 / teeth as f64;
            let (cos, sin) = values
                .iter()
                .enumerate()
                .fold((0.0, 0.0), |sum, (n, value)| {
                    let (sin, cos) = (turn * n as f64).sin_cos();
                    (sum.0 + value * cos, sum.1 + value * sin)
                });
            let weight = if 2 * order == teeth { 1.0 } else { 2.0 } / teeth as f64;
            let amplitude = weight * cos.hypot(sin);
            let largest = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            // Smaller amplitudes are round-off.
            (amplitude > 1e-12 * largest).then(|| MeshHarmonic {
                cycles: teeth as u32,
                ..MeshHarmonic::new(order as u32, amplitude, (-sin).atan2(cos))
            })
        })
        .collect()
}

fn ripple(table: &Section, source: Option<&StructureSource>) -> Option<TorqueRipple> {
    let ripple = all_of!(TorqueRipple {
        shaft: table.variant("shaft"),
        order: table.quantity("order"),
        amplitude: table.quantity("amplitude"),
        phase: table.quantity("phase"),
    })?;
    torque_curve::check_torque_can_act(table, source, ripple.shaft)?;
    Some(ripple)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of the orders of a shaft has the values of its teeth minus their mean, for even and odd
    /// numbers of teeth.
    #[test]
    fn orders_take_the_values_of_the_teeth() {
        for teeth in [1_u32, 2, 7, 20] {
            let value = |n: u32| 1e-6 * (f64::from(n * n % 11) - 2.0 * f64::from(n % 3));
            let values: Vec<f64> = (0..teeth).map(value).collect();
            let mean = values.iter().sum::<f64>() / f64::from(teeth);
            let orders = orders_of_teeth(&values);
            assert!(orders.iter().all(|order| order.cycles == teeth));
            assert!(orders.len() <= teeth as usize / 2);
            for cycle in 0..2 * teeth {
                let sum: f64 = (orders.iter())
                    .map(|order| {
                        let turned = TAU * order.turns_per_cycle() * f64::from(cycle);
                        order.amplitude * (turned + order.phase).cos()
                    })
                    .sum();
                let exact = values[(cycle % teeth) as usize] - mean;
                assert!(
                    (sum - exact).abs() < 1e-18,
                    "{teeth} {cycle}: {sum} {exact}"
                );
            }
        }
        // Equal teeth have no error.
        assert!(orders_of_teeth(&[3e-6; 12]).is_empty());
    }

    /// Faults of the gears do not hide messages about their errors.
    #[test]
    fn errors_of_gears_are_read_beside_faults_of_the_gears() {
        let text = include_str!("../../../../manifests/quickstart.toml");
        let faults = "gear_error = [{ shaft = \"pinion\", order = 0, amplitude = 1e-6 }]\n\
                      pitch_deviation = { wheel = [\"1 s\"] }\n";
        let text = text
            .replacen("teeth = [20, 30]", "teeth = [20, 1]", 1)
            .replacen(
                "\ntransmission_error",
                &format!("\n{faults}transmission_error"),
                1,
            );
        let message = crate::manifest::parse(&text, "m.toml", std::path::Path::new(""))
            .unwrap_err()
            .to_string();
        for key in ["gear.teeth", "gear_error.0.order", "pitch_deviation.wheel"] {
            assert!(message.contains(key), "{key}: {message}");
        }
    }
}
