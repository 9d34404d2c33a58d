//! Do hubs fit between the other parts on their shaft?

use crate::gear::{Hub, ToothForm};
use crate::manifest::reader::Section;
use crate::shaft::{Bearing, ShaftSection, TrainGear};

/// Checks that no hub reaches under another gear of its shaft or into the hub of that gear.
pub(super) fn check_hub_distances(table: &Section, gears: &[(TrainGear, ToothForm)]) -> Option<()> {
    let tables = table.tables("gears")?;
    for (gear_table, (gear, _)) in tables.iter().zip(gears) {
        let Some(hub) = gear.hub else { continue };
        let reach = |other: &TrainGear| {
            0.5 * other
                .hub
                .map_or(other.width, |hub| hub.length.max(other.width))
        };
        let touched = gears.iter().find(|(other, _)| {
            let distance = (other.at - gear.at).abs();
            other.name != gear.name && distance < (0.5 * hub.length + reach(other)) * (1.0 - 1e-9)
        });
        if let Some((other, _)) = touched {
            let room = 2e3 * ((other.at - gear.at).abs() - reach(other)).max(0.0);
            let what = format!(
                "the hub of `{}` is {:.3} mm long and reaches under `{}`",
                gear.name,
                1e3 * hub.length,
                other.name
            );
            let remedy = if room > 0.0 {
                format!("make hub_length at most {room:.3} mm")
            } else {
                "move the gears apart, or remove the hub".to_owned()
            };
            return hub_fault(gear_table, "hub_length", what, ["too long", &remedy]);
        }
    }
    Some(())
}

/// Checks that no hub covers a bearing of its shaft.
pub(super) fn hubs_leave_bearings(
    table: &Section,
    gears: &[(TrainGear, ToothForm)],
    bearings: &[(f64, Bearing)],
) -> Option<()> {
    let tables = table.tables("gears")?;
    for (gear_table, (gear, _)) in tables.iter().zip(gears) {
        let Some(hub) = gear.hub else { continue };
        let room = |bearing: &(f64, Bearing)| 2.0 * (bearing.0 - gear.at).abs();
        let nearest = (1..)
            .zip(bearings)
            .min_by(|(_, a), (_, b)| room(a).total_cmp(&room(b)));
        let covered = nearest.filter(|(_, bearing)| room(bearing) < hub.length * (1.0 - 1e-9));
        if let Some((number, bearing)) = covered {
            let what = format!(
                "the hub of `{}` is {:.3} mm long and covers bearing {number} at {:.3} mm",
                gear.name,
                1e3 * hub.length,
                1e3 * bearing.0
            );
            let remedy = match room(bearing) {
                0.0 => "move the gear or the bearing, or remove the hub".to_owned(),
                room => format!("make hub_length at most {:.3} mm", 1e3 * room),
            };
            return hub_fault(gear_table, "hub_length", what, ["too long", &remedy]);
        }
    }
    Some(())
}

/// Checks that the sections of a shaft extend over the whole hub at a place.
pub(super) fn hub_is_on_shaft(
    table: &Section,
    (at, hub): (f64, Hub),
    sections: &[ShaftSection],
) -> Option<()> {
    let length: f64 = sections.iter().map(|section| section.length).sum();
    let [start, end] = hub.ends(at);
    let beyond = (-start).max(end - length);
    if beyond <= 1e-9 * length {
        return Some(());
    }
    let [hub, beyond] = [hub.length, beyond].map(|length| 1e3 * length);
    let what = format!(
        "the hub is {hub} mm long and reaches {beyond:.6} mm beyond the sections of its shaft"
    );
    hub_fault(
        table,
        "hub_length",
        what,
        ["too long", "shorten hub_length, or lengthen the sections"],
    )
}

/// Reports a fault of a hub, at its diameter if `key` is absent, and returns `None`.
fn hub_fault(table: &Section, key: &str, what: String, [label, remedy]: [&str; 2]) -> Option<()> {
    let key = if table.has(key) { key } else { "hub_diameter" };
    let fault = table.inconsistent(key, what);
    fault.label(label).remedy(remedy).fail(table.issues)
}
