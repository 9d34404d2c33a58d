//! `[analyses.multistability.slice]`: a plane of initial states, along two modes or in the phase plane of one.

use crate::analysis::{SliceConfig, SliceOf};
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues};
use crate::manifest::reader::Section;

/// Reads the table. Whether the mesh excites its modes is checked when the structure is known.
pub(super) fn read(
    table: &Section,
    issues: &mut Issues,
    retained: Option<usize>,
) -> Option<SliceConfig> {
    let modes = if table.has("mode") {
        of_one_mode(table, issues, retained)
    } else {
        of_two_modes(table, issues, retained)
    };
    let extent = table.quantity(issues, "extent");
    let count = table.integer_or_default(issues, "count");
    let (modes, of, speed) = modes?;
    Some(SliceConfig {
        modes: modes.map(|mode| mode as usize - 1),
        of,
        extent: extent?,
        speed,
        count: u32::try_from(count?).ok()?,
    })
}

/// Modes counted from 1, the varied quantities, and the speed of a phase plane.
type Modes = ([u64; 2], SliceOf, Option<f64>);

/// The phase plane of a mode.
fn of_one_mode(table: &Section, issues: &mut Issues, retained: Option<usize>) -> Option<Modes> {
    let mode = table.integer(issues, "mode");
    let speed = if table.has("speed") {
        table.quantity(issues, "speed").map(Some)
    } else {
        Some(None)
    };
    table.given_twice(issues, &["modes", "of"], "mode", "name the plane");
    let mode = retained_mode(table, issues, "mode", [mode?; 2], retained)?;
    Some((mode, SliceOf::PhasePlane, speed?))
}

fn of_two_modes(table: &Section, issues: &mut Issues, retained: Option<usize>) -> Option<Modes> {
    let modes = table.integers::<2>(issues, "modes");
    let of = table.choice_or_default(issues, "of");
    table.without_effect(
        issues,
        &["speed"],
        "without `mode`",
        "remove speed, or name one mode instead of `modes`",
    );
    let modes = modes?;
    if modes[0] == modes[1] {
        let same = modes[0];
        issues.push(
            Diagnostic::new(
                DiagnosticKind::Inconsistent,
                table.span_of("modes"),
                "analyses.multistability.slice.modes",
                format!("a slice needs two different modes, but both are mode {same}"),
            )
            .label("the same mode twice")
            .remedy(format!(
                "name two different modes, such as [3, 7], or `mode = {same}` for its phase plane"
            )),
        );
        return None;
    }
    let modes = retained_mode(table, issues, "modes", modes, retained)?;
    let of = match of? {
        "velocity" => SliceOf::Velocity,
        _ => SliceOf::Displacement,
    };
    Some((modes, of, None))
}

/// The modes, if all are retained.
fn retained_mode(
    table: &Section,
    issues: &mut Issues,
    key: &str,
    modes: [u64; 2],
    retained: Option<usize>,
) -> Option<[u64; 2]> {
    let most = retained.map_or(u64::MAX, |retained| retained as u64);
    let Some(mode) = modes.into_iter().find(|&mode| mode > most) else {
        return Some(modes);
    };
    issues.push(
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            table.span_of(key),
            &table.path_of(key),
            format!("there is no mode {mode}: {most} modes are retained"),
        )
        .label("not retained")
        .remedy(format!(
            "name modes from 1 to {most}, or raise model.retained"
        )),
    );
    None
}
