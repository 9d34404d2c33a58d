//! `[analyses]`: one table per analysis; an absent table means that it is not computed.

use super::optional::optional;
use super::{covariant, orbits, poincare, slice};
use crate::analysis::{
    Analyses, Effort, GrowthNorm, HorizonConfig, LyapunovConfig, MultistabilityConfig, NvhConfig,
    OrderConfig, Signals, SpectrumConfig,
};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;
use crate::manifest::schema;
use crate::manifest::spec::{ModelSpec, RunSpec};

pub(super) fn read(
    section: &Section,
    issues: &mut Issues,
    model: Option<&ModelSpec>,
    run: Option<&RunSpec>,
    carried: bool,
) -> Option<Analyses> {
    let retained = model.map(|model| model.retained);
    let cycles = run.map(|run| run.cycles);
    let lyapunov = optional(section, issues, "lyapunov", |table, issues| {
        lyapunov(table, issues, model, run)
    });
    let poincare = optional(section, issues, "poincare", |table, issues| {
        poincare::read(table, issues, cycles, carried, retained)
    });
    let nvh = optional(section, issues, "nvh", |table, issues| {
        let harmonics = table.count_or_default(issues, "harmonics");
        let spectrum = optional(table, issues, "spectrum", spectrum);
        let orders = optional(table, issues, "orders", orders);
        let stop_at_stderr = stop_at_stderr(table, issues);
        let [bearings, torques, accelerations, meshes, power] =
            ["bearings", "torques", "accelerations", "meshes", "power"]
                .map(|name| table.boolean_or_default(issues, name));
        Some(NvhConfig {
            harmonics: harmonics?,
            outputs: Signals {
                bearings: bearings?,
                torques: torques?,
                accelerations: accelerations?,
                meshes: meshes?,
                ..Signals::NONE
            },
            power: power?,
            spectrum: spectrum?,
            orders: orders?,
            stop_at_stderr: stop_at_stderr?,
        })
    });
    let multistability = optional(section, issues, "multistability", |table, issues| {
        multistability(table, issues, retained, run)
    });
    let orbits = optional(section, issues, "orbits", |table, issues| {
        orbits::read(table, issues, retained)
    });
    let horizon = optional(section, issues, "horizon", horizon);
    let covariant = optional(section, issues, "covariant", |table, issues| {
        covariant::read(table, issues, model)
    });
    let without = ["horizon", "covariant"]
        .into_iter()
        .filter(|name| section.has(name) && !section.has("lyapunov"));
    let before = issues.count();
    for name in without {
        let path = format!("analyses.{name}");
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                section.span_of(name),
                &path,
                format!(
                    "`{path}` needs the kind of motion, and only a Lyapunov exponent determines it"
                ),
            )
            .label("needs `analyses.lyapunov`")
            .remedy("add `lyapunov = {}` to [analyses]"),
        );
    }
    if issues.count() > before {
        return None;
    }
    Some(Analyses {
        lyapunov: lyapunov?,
        poincare: poincare?,
        nvh: nvh?,
        multistability: multistability?,
        orbits: orbits?,
        horizon: horizon?,
        covariant: covariant?,
    })
}

fn spectrum(table: &Section, issues: &mut Issues) -> Option<SpectrumConfig> {
    let signals = signals(table, issues);
    let highest_order = table.integer_or_default(issues, "highest_order");
    let resolution = table.integer_or_default(issues, "resolution");
    Some(SpectrumConfig {
        signals: signals?,
        highest_order: u32::try_from(highest_order?).ok()?,
        resolution: u32::try_from(resolution?).ok()?,
    })
}

fn orders(table: &Section, issues: &mut Issues) -> Option<OrderConfig> {
    let signals = signals(table, issues);
    let mesh = table.integer_or_default(issues, "mesh");
    let shafts = table.integer_or_default(issues, "shafts");
    Some(OrderConfig {
        signals: signals?,
        mesh: u32::try_from(mesh?).ok()?,
        shafts: u32::try_from(shafts?).ok()?,
    })
}

pub(super) fn signals(table: &Section, issues: &mut Issues) -> Option<Signals> {
    let words = table.choices_or_default(issues, "signals")?;
    Some(Signals {
        deflection: words.contains(&"deflection"),
        force: words.contains(&"force"),
        bearings: words.contains(&"bearings"),
        torques: words.contains(&"torques"),
        accelerations: words.contains(&"accelerations"),
        meshes: words.contains(&"meshes"),
        rotations: false,
    })
}

fn lyapunov(
    table: &Section,
    issues: &mut Issues,
    model: Option<&ModelSpec>,
    run: Option<&RunSpec>,
) -> Option<LyapunovConfig> {
    let exponents = table.count_or_default(issues, "exponents");
    let stop_at_stderr = stop_at_stderr(table, issues);
    let align = table.integer_or_default(issues, "align");
    let twin = table.boolean_or_default(issues, "twin");
    let separation =
        (table.if_effective(twin != Some(false))).quantity_or_default(issues, "separation");
    let course = table.count_or_default(issues, "course");
    let norm = table.choice_or_default(issues, "norm");
    let effort = table.choice_or_default(issues, "effort");
    let lifetime = lifetime(table, issues, run);
    let chains = table.boolean_or_default(issues, "chains");
    if twin == Some(false) {
        table.without_effect(
            issues,
            &["separation"],
            "with twin = false",
            "remove separation, or remove twin",
        );
    }
    let exponents = exponents?;
    covariant::has_exponents(table, issues, "exponents", exponents, model)?;
    Some(LyapunovConfig {
        exponents,
        stop_at_stderr: stop_at_stderr?,
        align: align?,
        twin: twin?,
        separation: separation?,
        course: course?,
        norm: match norm? {
            "raw" => GrowthNorm::Raw,
            _ => GrowthNorm::Energy,
        },
        effort: match effort? {
            "survey" => Effort::Survey,
            _ => Effort::Verified,
        },
        lifetime: lifetime?,
        chains: chains?,
    })
}

/// The life of chaos that must be detectable, if any: the budget must have at least three times as many cycles.
fn lifetime(table: &Section, issues: &mut Issues, run: Option<&RunSpec>) -> Option<Option<u64>> {
    if !table.has("lifetime") {
        return Some(None);
    }
    let lifetime = table.integer(issues, "lifetime")?;
    let needed = lifetime.saturating_mul(3);
    if let Some(run) = run.filter(|run| run.cycles < needed) {
        let path = table.path_of("lifetime");
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                table.span_of("lifetime"),
                &path,
                format!(
                    "evidence for a mean life of {lifetime} cycles needs {needed} chaotic cycles, but `run.cycles` is {}",
                    run.cycles
                ),
            )
            .label(format!("at most {}", run.cycles / 3))
            .remedy(format!("raise run.cycles to {needed}, or lower lifetime")),
        );
        return None;
    }
    Some(Some(lifetime))
}

/// An optional stop rule.
fn stop_at_stderr(table: &Section, issues: &mut Issues) -> Option<Option<f64>> {
    if table.has("stop_at_stderr") {
        table.quantity(issues, "stop_at_stderr").map(Some)
    } else {
        Some(None)
    }
}

fn horizon(table: &Section, issues: &mut Issues) -> Option<HorizonConfig> {
    let twins = table.integer_or_default(issues, "twins");
    let separation = table.quantity_or_default(issues, "separation");
    let cycles = table.integer_or_default(issues, "cycles");
    let averages = table.integer_or_default(issues, "averages");
    Some(HorizonConfig {
        twins: u32::try_from(twins?).ok()?,
        separation: separation?,
        cycles: cycles?,
        averages: averages?,
    })
}

/// Default limit of the measured mesh cycles of a probe.
const PROBE_CYCLES: u64 = 4_000;

/// By default, probes are integrated as long as the point itself, up to [`PROBE_CYCLES`].
fn multistability(
    table: &Section,
    issues: &mut Issues,
    retained: Option<usize>,
    run: Option<&RunSpec>,
) -> Option<MultistabilityConfig> {
    let initial_conditions = table.integer_or_default(issues, "initial_conditions");
    let decades = table.quantity_or_default(issues, "decades");
    let as_long_as_run = run.map_or((0, 0), |run| (run.transient, run.cycles));
    let transient = table.integer_or(issues, "transient", as_long_as_run.0);
    let cycles = table.integer_or(
        issues,
        "cycles",
        as_long_as_run.1.clamp(schema::FEWEST_CYCLES, PROBE_CYCLES),
    );
    let slice = optional(table, issues, "slice", |table, issues| {
        slice::read(table, issues, retained)
    });
    Some(MultistabilityConfig {
        initial_conditions: u32::try_from(initial_conditions?).ok()?,
        decades: decades?,
        transient: transient?,
        cycles: cycles?,
        slice: slice?,
    })
}
