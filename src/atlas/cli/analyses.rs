//! The requested analyses of a point, in words.

use crate::analysis::{GrowthNorm, NvhConfig, Section, SliceOf};
use crate::manifest::PointSpec;
use crate::units::plural;

/// The requested analyses with their main settings, separated by commas; `none` if there are none.
pub(super) fn analyses(point: &PointSpec) -> String {
    let analyses = &point.analyses;
    let lyapunov = analyses.lyapunov.map(|lyapunov| {
        let stop = lyapunov.stop_at_stderr.map_or(String::new(), |bound| {
            format!(", until standard error {bound}")
        });
        let raw = match lyapunov.norm {
            GrowthNorm::Raw => ", in the raw norm",
            GrowthNorm::Energy => "",
        };
        format!(
            "lyapunov ({}{raw}{stop})",
            plural(lyapunov.exponents, "exponent"),
        )
    });
    let poincare = analyses.poincare.as_ref().map(|poincare| {
        let section = match &poincare.section {
            Section::Strobe { phase: 0.0 } => String::new(),
            Section::Strobe { phase } => format!(" at mesh phase {phase}"),
            Section::Entry => " on entry into drive contact".to_owned(),
            Section::Extremum => " at extrema".to_owned(),
            Section::Release => " where drive contact ends".to_owned(),
            Section::CoastEntry => " on entry into coast contact".to_owned(),
            Section::CoastRelease => " where coast contact ends".to_owned(),
            Section::ForceMaximum => " at maxima of the mesh force".to_owned(),
            Section::Surface(_) => " on the given surface".to_owned(),
        };
        let refine = match poincare.refine {
            0 => String::new(),
            1 => ", changes located by 1 halving".to_owned(),
            halvings => format!(", changes located by {halvings} halvings"),
        };
        format!("poincare ({} samples{section}{refine})", poincare.samples)
    });
    let nvh = analyses.nvh.map(nvh);
    let multistability = analyses.multistability.map(|config| {
        let slice = config.slice.map_or_else(String::new, |slice| {
            let [first, second] = slice.modes.map(|mode| mode + 1);
            let along = match slice.of {
                SliceOf::PhasePlane => format!("in the phase plane of mode {first}"),
                _ => format!("along modes {first} and {second}"),
            };
            format!(", a slice of {0} x {0} {along}", slice.count)
        });
        format!(
            "multistability ({} initial conditions over {} decades of energy{slice}, {} + {} cycles each)",
            config.initial_conditions, config.decades, config.transient, config.cycles
        )
    });
    let orbits = analyses.orbits.as_ref().map(|config| {
        let periods: Vec<String> = config.periods.iter().map(u32::to_string).collect();
        format!(
            "orbits (periods {}; {} guesses and {} given states each; kicks over {} returns)",
            periods.join(", "),
            config.guesses,
            config.states.len(),
            config.returns
        )
    });
    let horizon = analyses.horizon.map(|config| {
        format!(
            "horizon ({} twins over {} cycles, averages up to {} cycles)",
            config.twins, config.cycles, config.averages
        )
    });
    let covariant = analyses.covariant.map(|config| {
        format!(
            "covariant vectors ({} over {} cycles)",
            config.vectors, config.cycles
        )
    });
    let all: Vec<String> = [
        lyapunov,
        poincare,
        nvh,
        multistability,
        orbits,
        horizon,
        covariant,
    ]
    .into_iter()
    .flatten()
    .collect();
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}

fn nvh(nvh: NvhConfig) -> String {
    let spectra = if nvh.spectrum.is_some() { ", spectra" } else { "" };
    let more = [
        (nvh.orders.is_some(), ", orders"),
        (nvh.outputs.bearings, ", bearings"),
        (nvh.outputs.torques, ", torques"),
        (nvh.outputs.accelerations, ", accelerations"),
        (nvh.outputs.meshes, ", meshes"),
        (nvh.power, ", power balance"),
    ];
    let more: String = more
        .iter()
        .filter(|part| part.0)
        .map(|part| part.1)
        .collect();
    let stop = nvh.stop_at_stderr.map_or(String::new(), |bound| {
        format!(", until relative standard error {bound}")
    });
    format!("nvh ({} harmonics{spectra}{more}{stop})", nvh.harmonics)
}
