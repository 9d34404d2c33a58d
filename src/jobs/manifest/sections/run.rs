//! `[run]`: number of cycles, kernel and initial state.

use super::modal_state;
use crate::analysis::Effort;
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::{Given, Section};
use crate::manifest::spec::RunSpec;
use crate::manifest::tree::Value;
use crate::model::InitialState;
use crate::propagate::{KernelChoice, KernelSetting};
use std::collections::BTreeSet;

/// Default number of mesh cycles of the energy audit. A shorter measurement is audited completely.
const AUDIT_CYCLES: u64 = 20;

pub(super) fn read(root: &Section, retained: Option<usize>) -> Option<RunSpec> {
    let section = root.child_or_empty("run")?;
    let transient = section.integer("transient");
    let cycles = section.integer_or("cycles", default_cycles(root));
    let kernel = kernel(&section);
    let portable = portable(&section, kernel.as_ref());
    let initial = initial(&section, retained);
    let settle = section.boolean("settle");
    let event_limit = section.integer("event_limit");
    let default_audit = cycles.map_or(AUDIT_CYCLES, |cycles| AUDIT_CYCLES.min(cycles));
    let audit_cycles = section.integer_or("audit_cycles", default_audit);
    let (cycles, audit_cycles) = (cycles?, audit_cycles?);
    if audit_cycles > cycles {
        let message = format!(
            "`run.audit_cycles` = {audit_cycles} is more than the {cycles} measured cycles"
        );
        return section
            .inconsistent("audit_cycles", message)
            .label(format!("at most {cycles}"))
            .remedy("lower audit_cycles or raise run.cycles")
            .fail(section.issues);
    }
    Some(RunSpec {
        transient: transient?,
        cycles,
        kernel: kernel?,
        initial: initial?,
        settle: settle?,
        audit_cycles,
        event_limit: event_limit?,
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

/// Whether `instructions` requests only the instructions that every processor has.
fn portable(section: &Section, kernel: Option<&KernelSetting>) -> Option<bool> {
    let portable = section.choice("instructions")? == "portable";
    if let Some(KernelSetting::Named(kernel)) = kernel
        && portable
        && kernel.keeps_tables()
    {
        let message = format!(
            "the tables of kernel = \"{}\" are not the same on every processor",
            kernel.name()
        );
        return section
            .fault(DiagnosticKind::Unavailable, "instructions", message)
            .label("not with this kernel")
            .remedy("set kernel = \"volterra\" or \"stepping\", or instructions = \"auto\"")
            .fail(section.issues);
    }
    Some(portable)
}

fn kernel(section: &Section) -> Option<KernelSetting> {
    let chosen = section.choice("kernel");
    let settings = KernelSetting::SETTINGS;
    if let Some((name, keys)) = settings.iter().find(|(name, _)| Some(*name) == chosen) {
        let all = settings.iter().flat_map(|(_, keys)| keys.iter());
        let idle: BTreeSet<&str> = all.filter(|key| !keys.contains(key)).copied().collect();
        let why = format!("with kernel = \"{name}\"");
        let remedy = "remove it, or set the kernel that uses it";
        let idle: Vec<&str> = idle.into_iter().collect();
        section.without_effect(&idle, &why, remedy);
    }
    Some(KernelSetting::Named(match chosen {
        Some("auto") => return Some(KernelSetting::Auto),
        Some("volterra") => KernelChoice::Volterra,
        Some("closed_modes") => KernelChoice::ClosedModes,
        Some(_) => KernelChoice::Stepping {
            steps: section.integer("steps")?,
        },
        None => {
            // The kernel is faulty, so `steps` may have no effect; its faults are still reported.
            section.integer::<u32>("steps");
            return None;
        }
    }))
}

fn initial(section: &Section, retained: Option<usize>) -> Option<InitialState> {
    const PATH: &str = "run.initial";
    let Some(entry) = section.entry("initial") else {
        return Some(InitialState::Static);
    };
    let given = Given {
        issues: section.issues,
        node: &entry.node,
        path: PATH,
        spec: section.spec(PATH),
    };
    match &entry.node.value {
        Value::Text(text) if text == "static" => Some(InitialState::Static),
        Value::Text(text) if text == "rest" => Some(InitialState::Rest),
        Value::Text(text) => given.not_a_choice(text, &["static", "rest"]),
        Value::Table(_) => modal_state::read(&section.child("initial")??, retained),
        _ => given.wrong_type(),
    }
}
