//! `[analyses.multistability.slice]`: a plane of initial states, along two modes or in the phase plane of one.

use crate::analysis::{SliceConfig, SliceOf};
use crate::manifest::reader::Section;

/// Reads the table. Whether the mesh excites the modes of the slice is checked when the structure is known.
pub(super) fn read(table: &Section, retained: Option<usize>) -> Option<SliceConfig> {
    let modes = if table.has("mode") {
        of_one_mode(table, retained)
    } else {
        of_two_modes(table, retained)
    };
    let extent = table.quantity("extent");
    let count = table.integer("count");
    let (modes, of, speed) = modes?;
    Some(SliceConfig {
        modes: modes.map(|mode| mode as usize - 1),
        of,
        extent: extent?,
        speed,
        count: count?,
    })
}

/// Modes counted from 1, the varied quantities, and the speed of a phase plane.
type Modes = ([u64; 2], SliceOf, Option<f64>);

/// The phase plane of a mode.
fn of_one_mode(table: &Section, retained: Option<usize>) -> Option<Modes> {
    let mode = table.integer("mode");
    let speed = table.if_given("speed", Section::quantity);
    table.given_twice(&["modes", "of"], "mode", "name the plane");
    let mode = retained_mode(table, "mode", [mode?; 2], retained)?;
    Some((mode, SliceOf::PhasePlane, speed?))
}

fn of_two_modes(table: &Section, retained: Option<usize>) -> Option<Modes> {
    let modes = table.integers::<2>("modes");
    let of = table.variant("of");
    table.without_effect(
        &["speed"],
        "without `mode`",
        "remove speed, or name one mode instead of `modes`",
    );
    let modes = modes?;
    if modes[0] == modes[1] {
        let same = modes[0];
        let message = format!("a slice needs two different modes, but both are mode {same}");
        return table
            .inconsistent("modes", message)
            .label("the same mode twice")
            .remedy(format!(
                "name two different modes, such as [3, 7], or `mode = {same}` for its phase plane"
            ))
            .fail(table.issues);
    }
    let modes = retained_mode(table, "modes", modes, retained)?;
    Some((modes, of?, None))
}

/// The modes, if all are retained.
fn retained_mode(
    table: &Section,
    key: &str,
    modes: [u64; 2],
    retained: Option<usize>,
) -> Option<[u64; 2]> {
    let most = retained.map_or(u64::MAX, |retained| retained as u64);
    let Some(mode) = modes.into_iter().find(|&mode| mode > most) else {
        return Some(modes);
    };
    let message = format!("there is no mode {mode}: {most} modes are retained");
    table
        .inconsistent(key, message)
        .label("not retained")
        .remedy(format!(
            "name modes from 1 to {most}, or raise model.retained"
        ))
        .fail(table.issues)
}
