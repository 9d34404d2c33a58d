//! `[[gear.profile_points]]`, `[[gear.lead_points]]`: courses of flanks through points. In the table of one gear of a
//! train they have no key `gear`, and both returned courses are that of the gear.

use crate::gear::GearPair;
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::Section;
use crate::manifest::schema::draws_one_gear;
use crate::numerics::point_course::PointCourse;

/// The profiles of both gears over their roll lengths. Positions may be given as diameters, which the drawing
/// converts to roll lengths.
pub(super) fn profiles(section: &Section, pair: Option<&GearPair>) -> Option<[PointCourse; 2]> {
    courses(section, "profile_points", |table, gear| {
        match [table.has("roll_length"), table.has("diameter")] {
            [true, true] => {
                let what = "give the positions of the points";
                table.given_twice(&["diameter"], "roll_length", what);
                None
            }
            [_, false] => table.quantities("roll_length", None),
            [false, true] => {
                let diameters = table.quantities("diameter", None)?;
                let base = pair?.base_radii()[gear];
                let below = diameters.iter().find(|&&diameter| 0.5 * diameter < base);
                if let Some(diameter) = below {
                    let message = format!(
                        "a diameter of {:.4} mm is inside the base circle of {:.4} mm",
                        1e3 * diameter,
                        2e3 * base
                    );
                    return table
                        .fault(DiagnosticKind::OutOfRange, "diameter", message)
                        .label("no involute there")
                        .accepted("give diameters on the involute, above the base circle")
                        .fail(table.issues);
                }
                let length = |diameter: f64| (0.25 * diameter * diameter - base * base).sqrt();
                Some(diameters.into_iter().map(length).collect())
            }
        }
    })
}

/// The leads of both gears over the distance from mid-face.
pub(super) fn leads(section: &Section) -> Option<[PointCourse; 2]> {
    courses(section, "lead_points", |table, _| {
        table.quantities("place", None)
    })
}

/// The courses of a list of tables. `places` reads the positions of a table for gear 0 or 1.
fn courses(
    section: &Section,
    name: &str,
    places: impl Fn(&Section, usize) -> Option<Vec<f64>>,
) -> Option<[PointCourse; 2]> {
    let mut found = [PointCourse::default(), PointCourse::default()];
    let mut whole = true;
    let of_one = draws_one_gear(&section.path);
    for table in section.tables(name)? {
        let gear = if of_one { Some("gear") } else { table.choice("gear") };
        let at = places(&table, usize::from(gear == Some("wheel")));
        let missing = table.quantities("missing", None);
        let between = table.variant("between");
        let (Some(gear), Some(at), Some(missing), Some(between)) = (gear, at, missing, between)
        else {
            whole = false;
            continue;
        };
        let fault = if at.len() != missing.len() {
            let (places, values) = (at.len(), missing.len());
            Some((
                "missing",
                format!("{values} values at {places} positions"),
                "one value per position",
            ))
        } else if at.len() < 2 {
            Some((
                "missing",
                "fewer than two points".to_owned(),
                "give two points or more",
            ))
        } else if at.windows(2).any(|pair| pair[1] <= pair[0]) {
            let key = ["roll_length", "diameter", "place"]
                .into_iter()
                .find(|key| table.has(key));
            let what = "positions do not increase".to_owned();
            Some((
                key.unwrap_or("missing"),
                what,
                "give positions in increasing order",
            ))
        } else if !found[usize::from(gear == "wheel")].points.is_empty() {
            Some((
                "gear",
                format!("the {gear} has two curves"),
                "give one table per gear",
            ))
        } else {
            None
        };
        if let Some((key, message, accepted)) = fault {
            table
                .inconsistent(key, message)
                .label("no curve")
                .accepted(accepted)
                .report(table.issues);
            whole = false;
            continue;
        }
        let course = PointCourse {
            points: at
                .into_iter()
                .zip(missing)
                .map(|(at, missing)| [at, missing])
                .collect(),
            between,
        };
        if of_one {
            found = [course.clone(), course];
        } else {
            found[usize::from(gear == "wheel")] = course;
        }
    }
    whole.then_some(found)
}
