//! `[run]`: number of cycles, kernel and initial state.

use super::modal_state;
use crate::analysis::Effort;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{Child, Section, wrong_type};
use crate::manifest::schema;
use crate::manifest::spec::RunSpec;
use crate::manifest::tree::Value;
use crate::model::InitialState;
use crate::propagate::{KernelChoice, KernelSetting};
use std::collections::BTreeSet;

/// Number of mesh cycles of the audit, if as many are measured.
const AUDIT_CYCLES: u64 = 20;

pub(super) fn read(
    root: &Section,
    issues: &mut Issues,
    retained: Option<usize>,
) -> Option<RunSpec> {
    let section = match root.child(issues, "run") {
        Child::Present(section) => section,
        Child::Absent => root.empty_child("run"),
        Child::Invalid => return None,
    };
    let transient = section.integer_or_default(issues, "transient");
    let cycles = section.integer_or(issues, "cycles", default_cycles(root));
    let kernel = kernel(&section, issues);
    let portable = portable(&section, issues, kernel.as_ref());
    let initial = initial(&section, issues, retained);
    let settle = section.boolean_or_default(issues, "settle");
    let event_limit = section.integer_or_default(issues, "event_limit");
    let default_audit = cycles.map_or(AUDIT_CYCLES, |cycles| AUDIT_CYCLES.min(cycles));
    let audit_cycles = section.integer_or(issues, "audit_cycles", default_audit);
    let (cycles, audit_cycles) = (cycles?, audit_cycles?);
    if audit_cycles > cycles {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                section.span_of("audit_cycles"),
                "run.audit_cycles",
                format!(
                    "`run.audit_cycles` = {audit_cycles} is more than the {cycles} measured cycles"
                ),
            )
            .label(format!("at most {cycles}"))
            .remedy("lower audit_cycles or raise run.cycles"),
        );
        return None;
    }
    Some(RunSpec {
        transient: transient?,
        cycles,
        kernel: kernel?,
        initial: initial?,
        settle: settle?,
        audit_cycles,
        event_limit: u32::try_from(event_limit?).ok()?,
        portable: portable?,
    })
}

/// Default limit of measured cycles, with and without a stop rule.
fn default_cycles(root: &Section) -> u64 {
    const STOPPED: [&str; 2] = [
        "analyses.lyapunov.stop_at_stderr",
        "analyses.nvh.stop_at_stderr",
    ];
    if STOPPED.iter().any(|key| root.has_below(key)) {
        160_000
    } else {
        Effort::Verified.first_look()
    }
}

/// `instructions`: those of this processor, or those of every processor.
fn portable(
    section: &Section,
    issues: &mut Issues,
    kernel: Option<&KernelSetting>,
) -> Option<bool> {
    let portable = section.choice_or_default(issues, "instructions")? == "portable";
    if let Some(KernelSetting::Named(kernel)) = kernel
        && portable
        && kernel.keeps_tables()
    {
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Unavailable,
                section.span_of("instructions"),
                "run.instructions",
                format!(
                    "the tables of kernel = \"{}\" are not the same on every processor",
                    kernel.name()
                ),
            )
            .label("not with this kernel")
            .remedy("set kernel = \"volterra\" or \"stepping\", or instructions = \"auto\""),
        );
        return None;
    }
    Some(portable)
}

fn kernel(section: &Section, issues: &mut Issues) -> Option<KernelSetting> {
    let chosen = section.choice_or_default(issues, "kernel");
    let settings = KernelSetting::SETTINGS;
    if let Some((name, own)) = settings.iter().find(|(name, _)| Some(*name) == chosen) {
        let all = settings.iter().flat_map(|(_, own)| own.iter());
        let idle: BTreeSet<&str> = all.filter(|key| !own.contains(key)).copied().collect();
        let why = format!("with kernel = \"{name}\"");
        let remedy = "remove it, or set the kernel that uses it";
        let idle: Vec<&str> = idle.into_iter().collect();
        section.without_effect(issues, &idle, &why, remedy);
    }
    Some(KernelSetting::Named(match chosen {
        Some("auto") => {
            return Some(KernelSetting::Auto);
        }
        Some("volterra") => KernelChoice::Volterra,
        Some("closed_modes") => KernelChoice::ClosedModes,
        Some(_) => {
            let steps = section.integer_or_default(issues, "steps")?;
            KernelChoice::Stepping {
                steps: u32::try_from(steps).ok()?,
            }
        }
        None => {
            // The key may have no effect; its faults are still reported.
            section.integer_or_default(issues, "steps");
            return None;
        }
    }))
}

fn initial(
    section: &Section,
    issues: &mut Issues,
    retained: Option<usize>,
) -> Option<InitialState> {
    const PATH: &str = "run.initial";
    let Some(entry) = section.entry("initial") else {
        return Some(InitialState::Static);
    };
    let (node, spec) = (&entry.node, section.spec(PATH));
    match &node.value {
        Value::Text(text) if text == "static" => Some(InitialState::Static),
        Value::Text(text) if text == "rest" => Some(InitialState::Rest),
        Value::Text(text) => {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::OutOfRange,
                    node.span,
                    PATH,
                    format!("`{PATH}` cannot be \"{text}\""),
                )
                .label("not one of the choices")
                .accepted(spec.accepted())
                .suggestion(
                    schema::nearest(text, &["static", "rest"]).map(|near| format!("\"{near}\"")),
                ),
            );
            None
        }
        Value::Table(_) => {
            let Child::Present(state) = section.child(issues, "initial") else {
                return None;
            };
            modal_state::read(&state, issues, retained)
        }
        _ => {
            wrong_type(issues, node, PATH, spec);
            None
        }
    }
}
