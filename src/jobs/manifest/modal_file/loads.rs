//! The tables `[[harmonic_load]]` of a modal file: loads that vary with time at any frequency.

use super::column;
use crate::manifest::diagnostic::Issues;
use crate::manifest::reader::Section;
use crate::structure::HarmonicLoad;

/// The loads; empty if there are none. `teeth` are those of the pinion.
pub(super) fn read(
    root: &Section,
    issues: &mut Issues,
    modes: Option<usize>,
    teeth: Option<u64>,
) -> Option<Vec<HarmonicLoad>> {
    let tables = root.tables(issues, "harmonic_load")?;
    let all: Vec<Option<HarmonicLoad>> = (tables.iter())
        .map(|table| {
            let name = table.text(issues, "name");
            let force = column(table, issues, "force", modes);
            let amplitude = table.quantity_or_default(issues, "amplitude");
            let turns = turns(table, issues);
            let phase = table.quantity_or_default(issues, "phase");
            let amplitude = amplitude?;
            Some(HarmonicLoad {
                name: name?.to_owned(),
                force: force?.iter().map(|force| force * amplitude).collect(),
                turns_per_cycle: match turns? {
                    Turns::Cycles([p, q]) => p as f64 / q as f64,
                    Turns::Order(order) => order / teeth? as f64,
                },
                phase: phase?,
            })
        })
        .collect();
    all.into_iter().collect()
}

/// Frequency of a load.
enum Turns {
    /// p turns in q mesh cycles.
    Cycles([u64; 2]),
    /// A multiple of the pinion's speed.
    Order(f64),
}

fn turns(table: &Section, issues: &mut Issues) -> Option<Turns> {
    if table.has("cycles") {
        table.given_twice(issues, &["order"], "cycles", "give the frequency");
        return table.integers::<2>(issues, "cycles").map(Turns::Cycles);
    }
    table.quantity(issues, "order").map(Turns::Order)
}
