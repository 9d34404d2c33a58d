//! `[analyses]`: a table for each analysis; absent = not computed.

use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{Child, Section};
use crate::manifest::schema;
use crate::manifest::spec::{
    AnalysesSpec, HorizonSpec, LyapunovSpec, MultistabilitySpec, NvhSpec, PoincareSpec, RunSpec,
};

const DEFAULT_EXPONENTS: usize = 1;
const DEFAULT_ALIGN: u64 = 100;
const DEFAULT_SAMPLES: usize = 200;
const DEFAULT_HARMONICS: usize = 10;
const DEFAULT_INITIAL_CONDITIONS: u64 = 32;
const DEFAULT_DECADES: f64 = 4.0;
const DEFAULT_TWINS: u64 = 16;
const DEFAULT_SEPARATION: f64 = 1e-6;
const DEFAULT_FOLLOWED: u64 = 60;
const DEFAULT_AVERAGES: u64 = 400;

pub(super) fn read(
    section: &Section,
    issues: &mut Issues,
    retained: Option<usize>,
    run: Option<&RunSpec>,
) -> Option<AnalysesSpec> {
    let cycles = run.map(|run| run.cycles);
    let lyapunov = optional(section, issues, "lyapunov", |table, issues| {
        lyapunov(table, issues, retained)
    });
    let poincare = optional(section, issues, "poincare", |table, issues| {
        poincare(table, issues, cycles)
    });
    let nvh = optional(section, issues, "nvh", |table, issues| {
        let harmonics = table.count_or(issues, "harmonics", DEFAULT_HARMONICS);
        let spectrum = table.boolean_or(issues, "spectrum", false);
        let bearings = table.boolean_or(issues, "bearings", false);
        Some(NvhSpec {
            harmonics: harmonics?,
            spectrum: spectrum?,
            bearings: bearings?,
        })
    });
    let multistability = optional(section, issues, "multistability", |table, issues| {
        multistability(table, issues, run)
    });
    let horizon = optional(section, issues, "horizon", horizon);
    if section.has("horizon") && !section.has("lyapunov") {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                section.span_of("horizon"),
                "analyses.horizon",
                "`analyses.horizon` is measured where the motion is chaotic, which only an exponent tells"
                    .to_owned(),
            )
            .label("needs `analyses.lyapunov`")
            .remedy("add `lyapunov = {}` to [analyses]"),
        );
        return None;
    }
    Some(AnalysesSpec {
        lyapunov: lyapunov?,
        poincare: poincare?,
        nvh: nvh?,
        multistability: multistability?,
        horizon: horizon?,
    })
}

/// `Some(None)` when absent, `None` when faulty.
fn optional<T>(
    section: &Section,
    issues: &mut Issues,
    name: &str,
    read: impl FnOnce(&Section, &mut Issues) -> Option<T>,
) -> Option<Option<T>> {
    match section.child(issues, name) {
        Child::Absent => Some(None),
        Child::Invalid => None,
        Child::Present(table) => read(&table, issues).map(Some),
    }
}

fn lyapunov(table: &Section, issues: &mut Issues, retained: Option<usize>) -> Option<LyapunovSpec> {
    let exponents = table.count_or(issues, "exponents", DEFAULT_EXPONENTS);
    let stop_at_stderr = if table.has("stop_at_stderr") {
        table.quantity(issues, "stop_at_stderr").map(Some)
    } else {
        Some(None)
    };
    let align = table.integer_or(issues, "align", DEFAULT_ALIGN);
    let twin = table.boolean_or(issues, "twin", true);
    let exponents = exponents?;
    if let Some(retained) = retained.filter(|retained| exponents > 2 * retained) {
        let most = 2 * retained;
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                table.span_of("exponents"),
                "analyses.lyapunov.exponents",
                format!(
                    "there are no {exponents} exponents: {retained} retained modes have {most}"
                ),
            )
            .label(format!("at most {most}"))
            .accepted(format!(
                "a whole number from 1 to {most}, twice the retained modes"
            )),
        );
        return None;
    }
    Some(LyapunovSpec {
        exponents,
        stop_at_stderr: stop_at_stderr?,
        align: align?,
        twin: twin?,
    })
}

fn horizon(table: &Section, issues: &mut Issues) -> Option<HorizonSpec> {
    let twins = table.integer_or(issues, "twins", DEFAULT_TWINS);
    let separation = table.quantity_or(issues, "separation", DEFAULT_SEPARATION);
    let cycles = table.integer_or(issues, "cycles", DEFAULT_FOLLOWED);
    let averages = table.integer_or(issues, "averages", DEFAULT_AVERAGES);
    Some(HorizonSpec {
        twins: u32::try_from(twins?).ok()?,
        separation: separation?,
        cycles: cycles?,
        averages: averages?,
    })
}

/// Probes are marched as long as the point itself unless the table says otherwise.
fn multistability(
    table: &Section,
    issues: &mut Issues,
    run: Option<&RunSpec>,
) -> Option<MultistabilitySpec> {
    let initial_conditions =
        table.integer_or(issues, "initial_conditions", DEFAULT_INITIAL_CONDITIONS);
    let decades = table.quantity_or(issues, "decades", DEFAULT_DECADES);
    let as_long_as_run = run.map_or((0, 0), |run| (run.transient, run.cycles));
    let transient = table.integer_or(issues, "transient", as_long_as_run.0);
    let cycles = table.integer_or(
        issues,
        "cycles",
        as_long_as_run.1.max(schema::FEWEST_CYCLES),
    );
    Some(MultistabilitySpec {
        initial_conditions: u32::try_from(initial_conditions?).ok()?,
        decades: decades?,
        transient: transient?,
        cycles: cycles?,
    })
}

fn poincare(table: &Section, issues: &mut Issues, cycles: Option<u64>) -> Option<PoincareSpec> {
    let most = cycles.map_or(usize::MAX, |cycles| {
        usize::try_from(cycles).unwrap_or(usize::MAX)
    });
    let samples = table.count_or(issues, "samples", DEFAULT_SAMPLES.min(most))?;
    if samples <= most {
        return Some(PoincareSpec { samples });
    }
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            table.span_of("samples"),
            "analyses.poincare.samples",
            format!(
                "`analyses.poincare.samples` = {samples} is more than the {most} measured cycles"
            ),
        )
        .label(format!("at most {most}"))
        .remedy("there is one sample a mesh cycle: lower samples or raise run.cycles"),
    );
    None
}
