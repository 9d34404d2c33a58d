//! The tables `[[harmonic_load]]` of a modal file: loads that vary with time at any frequency.

use super::{column, report_repeated_names};
use crate::manifest::reader::{Section, all_or_none};
use crate::structure::HarmonicLoad;

/// The loads; empty if there are none. `teeth` are those of the pinion.
pub(super) fn read(
    root: &Section,
    modes: Option<usize>,
    teeth: Option<u32>,
) -> Option<Vec<HarmonicLoad>> {
    let tables = root.tables("harmonic_load")?;
    let remedy =
        "give each table its own name: keys such as harmonic_load.NAME.amplitude refer to it";
    report_repeated_names(&tables, "harmonic loads", remedy);
    let loads = tables.iter().map(|table| {
        let name = table.text("name");
        let force = column(table, "force", modes);
        let amplitude = table.quantity("amplitude");
        let turns = turns(table);
        let phase = table.quantity("phase");
        let amplitude = amplitude?;
        Some(HarmonicLoad {
            name: name?.to_owned(),
            force: force?.iter().map(|force| force * amplitude).collect(),
            turns_per_cycle: match turns? {
                LoadFrequency::Cycles([p, q]) => p as f64 / q as f64,
                LoadFrequency::Order(order) => order / f64::from(teeth?),
            },
            phase: phase?,
        })
    });
    all_or_none(loads)
}

/// Frequency of a load.
enum LoadFrequency {
    /// p turns in q mesh cycles.
    Cycles([u64; 2]),
    /// A multiple of the pinion's speed.
    Order(f64),
}

fn turns(table: &Section) -> Option<LoadFrequency> {
    if table.has("cycles") {
        table.given_twice(&["order"], "cycles", "give the frequency");
        return table.integers::<2>("cycles").map(LoadFrequency::Cycles);
    }
    table.quantity("order").map(LoadFrequency::Order)
}
