//! `[analyses]`: one table per analysis. An analysis without a table is not computed.

use super::{covariant, orbits, poincare, slice};
use crate::analysis::{
    Analyses, HorizonConfig, LyapunovConfig, MultistabilityConfig, NvhConfig, OrderConfig, Signals,
    SpectrumConfig,
};
use crate::manifest::reader::{Section, all_of};
use crate::manifest::schema;
use crate::manifest::spec::{ModelSpec, RunSpec};

pub(super) fn read(
    section: &Section,
    model: Option<&ModelSpec>,
    run: Option<&RunSpec>,
    carried: bool,
) -> Option<Analyses> {
    let retained = model.map(|model| model.retained);
    let cycles = run.map(|run| run.cycles);
    let lyapunov = section.optional("lyapunov", |table| lyapunov(table, model, run));
    let poincare = section.optional("poincare", |table| {
        poincare::read(table, cycles, carried, retained)
    });
    let nvh = section.optional("nvh", |table| {
        all_of!(NvhConfig {
            harmonics: table.integer("harmonics"),
            outputs: all_of!(Signals {
                bearings: table.boolean("bearings"),
                torques: table.boolean("torques"),
                accelerations: table.boolean("accelerations"),
                meshes: table.boolean("meshes"),
                ..Signals::NONE
            }),
            power: table.boolean("power"),
            spectrum: table.optional("spectrum", spectrum),
            orders: table.optional("orders", orders),
            stop_at_stderr: stop_at_stderr(table),
        })
    });
    let multistability = section.optional("multistability", |table| {
        multistability(table, retained, run)
    });
    let orbits = section.optional("orbits", |table| orbits::read(table, retained));
    let horizon = section.optional("horizon", horizon);
    let covariant = section.optional("covariant", |table| covariant::read(table, model));
    let without = ["horizon", "covariant"]
        .into_iter()
        .filter(|name| section.has(name) && !section.has("lyapunov"));
    let before = section.issues.count();
    for name in without {
        let path = format!("analyses.{name}");
        let message = format!(
            "`{path}` needs the kind of motion, and only a Lyapunov exponent determines it"
        );
        section
            .inconsistent(name, message)
            .label("needs `analyses.lyapunov`")
            .remedy("add `lyapunov = {}` to [analyses]")
            .report(section.issues);
    }
    if section.issues.count() > before {
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

fn spectrum(table: &Section) -> Option<SpectrumConfig> {
    all_of!(SpectrumConfig {
        signals: signals(table),
        highest_order: table.integer("highest_order"),
        resolution: table.integer("resolution"),
    })
}

fn orders(table: &Section) -> Option<OrderConfig> {
    all_of!(OrderConfig {
        signals: signals(table),
        mesh: table.integer("mesh"),
        shafts: table.integer("shafts"),
    })
}

pub(super) fn signals(table: &Section) -> Option<Signals> {
    let words = table.choices("signals")?;
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
    model: Option<&ModelSpec>,
    run: Option<&RunSpec>,
) -> Option<LyapunovConfig> {
    let exponents = table.integer("exponents");
    let stop_at_stderr = stop_at_stderr(table);
    let align = table.integer("align");
    let twin = table.boolean("twin");
    let separation = (table.if_effective(twin != Some(false))).quantity("separation");
    let course = table.integer("course");
    let norm = table.variant("norm");
    let effort = table.variant("effort");
    let lifetime = lifetime(table, run);
    let chains = table.boolean("chains");
    if twin == Some(false) {
        table.without_effect(
            &["separation"],
            "with twin = false",
            "remove separation, or remove twin",
        );
    }
    let exponents = exponents?;
    covariant::check_exponents(table, "exponents", exponents, model)?;
    Some(LyapunovConfig {
        exponents,
        stop_at_stderr: stop_at_stderr?,
        align: align?,
        twin: twin?,
        separation: separation?,
        course: course?,
        norm: norm?,
        effort: effort?,
        lifetime: lifetime?,
        chains: chains?,
    })
}

/// The lower bound of the mean life of chaos to be shown; `Some(None)` if it is not given, `None` if it is faulty.
/// `run.cycles` must be at least three times as large.
fn lifetime(table: &Section, run: Option<&RunSpec>) -> Option<Option<u64>> {
    if !table.has("lifetime") {
        return Some(None);
    }
    let lifetime: u64 = table.integer("lifetime")?;
    let needed = lifetime.saturating_mul(3);
    if let Some(run) = run.filter(|run| run.cycles < needed) {
        let message = format!(
            "evidence for a mean life of {lifetime} cycles needs {needed} chaotic cycles, but `run.cycles` is {}",
            run.cycles
        );
        return table
            .inconsistent("lifetime", message)
            .label(format!("at most {}", run.cycles / 3))
            .remedy(format!("raise run.cycles to {needed}, or lower lifetime"))
            .fail(table.issues);
    }
    Some(Some(lifetime))
}

/// The standard error at which measuring stops, if it is given.
fn stop_at_stderr(table: &Section) -> Option<Option<f64>> {
    table.if_given("stop_at_stderr", Section::quantity)
}

fn horizon(table: &Section) -> Option<HorizonConfig> {
    all_of!(HorizonConfig {
        twins: table.integer("twins"),
        separation: table.quantity("separation"),
        cycles: table.integer("cycles"),
        averages: table.integer("averages"),
    })
}

/// Default limit of the measured mesh cycles of a probe.
const PROBE_CYCLES: u64 = 4_000;

/// By default, probes have the transient and the cycles of the point, but at least [`schema::FEWEST_CYCLES`] and
/// at most [`PROBE_CYCLES`] measured cycles.
fn multistability(
    table: &Section,
    retained: Option<usize>,
    run: Option<&RunSpec>,
) -> Option<MultistabilityConfig> {
    let (transient, cycles) = run.map_or((0, 0), |run| (run.transient, run.cycles));
    let cycles = cycles.clamp(schema::FEWEST_CYCLES, PROBE_CYCLES);
    all_of!(MultistabilityConfig {
        initial_conditions: table.integer("initial_conditions"),
        decades: table.quantity("decades"),
        transient: table.integer_or("transient", transient),
        cycles: table.integer_or("cycles", cycles),
        slice: table.optional("slice", |table| slice::read(table, retained)),
    })
}
