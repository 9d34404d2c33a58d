//! `[analyses.poincare]`: the section for samples.

use super::modal_state::modal_vector;
use crate::analysis::{PoincareConfig, Section as PoincareSection, Surface};
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;

/// Default number of kept samples of a strobe; a strobe with fewer samples keeps all.
const MOST_SAMPLES: usize = 200;

pub(super) fn read(
    table: &Section,
    cycles: Option<u64>,
    carried: bool,
    retained: Option<usize>,
) -> Option<PoincareConfig> {
    let section = section(table, retained);
    let samples = samples(table, cycles, section.as_ref());
    let refine = table.integer("refine");
    if !carried && refine.is_some_and(|halvings| halvings > 0) {
        table.without_effect(
            &["refine"],
            "because points are independent and have no neighbours in a sweep",
            "set grid.order = \"sweep-up\", \"sweep-down\" or \"both\", or remove refine",
        );
    }
    Some(PoincareConfig {
        samples: samples?,
        section: section?,
        refine: if carried { refine? } else { 0 },
    })
}

fn section(table: &Section, retained: Option<usize>) -> Option<PoincareSection> {
    let name = table.choice("section");
    // For an unknown section, phase and surface are still read, so that all faults are found.
    let phase = match name {
        None | Some("strobe") => table.quantity("phase"),
        Some(_) => None,
    };
    let surface = match name {
        None | Some("surface") => {
            table.optional("surface", |surface| self::surface(surface, retained))
        }
        Some(_) => None,
    };
    for (key, owner) in [("phase", "strobe"), ("surface", "surface")] {
        if let Some(name) = name.filter(|name| *name != owner) {
            table.without_effect(
                &[key],
                &format!("with section = \"{name}\""),
                &format!("remove {key}, or set section = \"{owner}\""),
            );
        }
    }
    Some(match name? {
        "entry" => PoincareSection::Entry,
        "extremum" => PoincareSection::Extremum,
        "release" => PoincareSection::Release,
        "coast_entry" => PoincareSection::CoastEntry,
        "coast_release" => PoincareSection::CoastRelease,
        "force_maximum" => PoincareSection::ForceMaximum,
        "surface" => {
            let surface = surface?;
            if surface.is_none() {
                table.missing("surface");
            }
            PoincareSection::Surface(surface?)
        }
        _ => PoincareSection::Strobe { phase: phase? },
    })
}

/// Coefficients that are not given are 0. At least one coefficient must differ from 0.
fn surface(table: &Section, retained: Option<usize>) -> Option<Surface> {
    let coefficients = |name: &str| {
        if table.has(name) {
            modal_vector(table, name, retained)
        } else {
            retained.map(|retained| vec![0.0; retained])
        }
    };
    let [displacement, velocity] = [coefficients("displacement"), coefficients("velocity")];
    let level = table.quantity("level");
    let direction = table.choice("direction");
    let (displacement, velocity) = (displacement?, velocity?);
    if displacement.iter().chain(&velocity).all(|a| *a == 0.0) {
        let message =
            "all coefficients of `analyses.poincare.surface` are 0, so it is not a surface";
        return table
            .whole_fault(DiagnosticKind::Inconsistent, message)
            .label("all 0")
            .remedy("give displacement or velocity one coefficient per retained mode, not all 0")
            .fail(table.issues);
    }
    Some(Surface {
        displacement,
        velocity,
        level: level?,
        rising: match direction? {
            "rising" => Some(true),
            "falling" => Some(false),
            _ => None,
        },
    })
}

/// A strobe has one sample per mesh cycle; the other sections have none or several.
fn samples(
    table: &Section,
    cycles: Option<u64>,
    section: Option<&PoincareSection>,
) -> Option<usize> {
    let strobe = matches!(section, Some(PoincareSection::Strobe { .. }));
    let most = match cycles {
        Some(cycles) if strobe => usize::try_from(cycles).unwrap_or(usize::MAX),
        _ => usize::MAX,
    };
    let samples = table.integer_or("samples", MOST_SAMPLES.min(most))?;
    if samples <= most {
        return Some(samples);
    }
    let message =
        format!("`analyses.poincare.samples` = {samples} is more than the {most} measured cycles");
    table
        .inconsistent("samples", message)
        .label(format!("at most {most}"))
        .remedy("a strobe takes one sample per mesh cycle: lower samples or raise run.cycles")
        .fail(table.issues)
}
