//! `[runup]`: a run-up or run-down.

use super::analyses::signals;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::{Child, Section};
use crate::manifest::spec::RunUpSpec;

/// The section, `Some(None)` where there is none; `None` where it is faulty.
pub(in crate::manifest) fn read(root: &Section, issues: &mut Issues) -> Option<Option<RunUpSpec>> {
    let section = match root.child(issues, "runup") {
        Child::Absent => return Some(None),
        Child::Invalid => return None,
        Child::Present(section) => section,
    };
    let course = (section.required_child(issues, "speed")).and_then(|speed| {
        let from = speed.quantity(issues, "from");
        let to = speed.quantity(issues, "to");
        let duration = speed.quantity(issues, "in");
        Some(([from?, to?], duration?))
    });
    let load = if section.has("load") {
        section.one_or_pair(issues, "load").map(Some)
    } else {
        Some(None)
    };
    let settle = section.quantity_or_default(issues, "settle");
    let sample_rate = section.integer_or_default(issues, "sample_rate");
    let revolutions = section.integer_or_default(issues, "revolutions");
    let orders = if section.has("orders") {
        section.quantities(issues, "orders", None).map(Some)
    } else {
        Some(None)
    };
    let frequency_step = section.integer_or_default(issues, "frequency_step");
    let signals = signals(&section, issues);
    if let (Some(rate), Some(([from, to], duration))) = (sample_rate, course) {
        /// Most samples of one signal: a quarter of a gigabyte.
        const MOST: f64 = 32e6;
        let longest = MOST / rate as f64;
        if duration > longest {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::OutOfRange,
                    section.span_of("speed"),
                    "runup.speed.in",
                    format!(
                        "a run-up of {duration} s at {rate} samples per second is too long: at most {longest:.4} s fit in memory"
                    ),
                )
                .label("too long")
                .remedy("shorten it, or lower runup.sample_rate"),
            );
        }
        if from == to {
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    section.span_of("speed"),
                    "runup.speed",
                    "both speeds of the run-up are the same".to_owned(),
                )
                .label("no run-up")
                .remedy("give two different speeds; `atlas trace` records a motion at one speed"),
            );
        }
    }
    let (speed, duration) = course?;
    Some(Some(RunUpSpec {
        speed,
        duration,
        load: load?,
        settle: settle?,
        sample_rate: u32::try_from(sample_rate?).ok()?,
        revolutions: u32::try_from(revolutions?).ok()?,
        orders: orders?,
        frequency_step: u32::try_from(frequency_step?).ok()?,
        signals: signals?,
    }))
}
