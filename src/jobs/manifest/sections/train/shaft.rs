//! The tables `[[train.shaft]]`.

use super::hubs::{check_hub_distances, hub_is_on_shaft, hubs_leave_bearings};
use super::rolling;
use crate::gear::{GearPair, ToothForm};
use crate::manifest::diagnostic::DiagnosticKind;
use crate::manifest::reader::{Section, all_of, all_or_none};
use crate::manifest::sections::gear;
use crate::shaft::{Bearing, Disc, Drag, LooseGear, ShaftSection, TrainGear, TrainShaft};
use std::collections::BTreeSet;

/// Default difference between the diameters of a ring's body and its pitch circle, in modules.
const RIM: f64 = 8.0;

/// All shafts, and the drawing data of the gears on each.
pub(super) fn read_all(
    tables: &[Section],
    density: f64,
) -> Option<(Vec<TrainShaft>, Vec<Vec<ToothForm>>)> {
    let mut names = BTreeSet::new();
    let both = all_or_none((tables.iter()).map(|table| shaft(table, density, &mut names)))?;
    Some(both.into_iter().unzip())
}

fn shaft(
    table: &Section,
    density: f64,
    names: &mut BTreeSet<String>,
) -> Option<(TrainShaft, Vec<ToothForm>)> {
    let name = unused_name(table, names);
    let origin = table.triple("origin");
    let direction = table.triple("direction");
    let motion = table.variant("motion");
    let sections = table.each("sections", section);
    let element = table.if_given("element", Section::quantity);
    let torque_at = table.quantity("torque_at");
    let output = table.quantity("output");
    let drag = drag(table);
    let discs = placed(table, "discs", body);
    let bearings = placed(table, "bearings", bearing);
    let sections = sections?;
    let gears = table.each("gears", |table| {
        toothed_on_shaft(table, (&sections, density), names)
    });
    let gears = gears?;
    check_hub_distances(table, &gears)?;
    let bearings = bearings?;
    hubs_leave_bearings(table, &gears, &bearings)?;
    let (gears, drawn) = gears.into_iter().unzip();
    let shaft = TrainShaft {
        name: name?,
        origin: origin?,
        direction: direction?,
        sections,
        element: element?,
        motion: motion?,
        discs: discs?,
        gears,
        bearings,
        torque_at: torque_at?,
        output: output?,
        drag: drag?,
    };
    if shaft.direction == [0.0; 3] {
        let message = "the direction of an axis must not be 0";
        return table
            .fault(DiagnosticKind::OutOfRange, "direction", message)
            .label("all three are 0")
            .fail(table.issues);
    }
    Some((shaft, drawn))
}

/// Parts of a shaft with their positions.
fn placed<T>(
    table: &Section,
    name: &str,
    read: impl Fn(&Section) -> Option<T>,
) -> Option<Vec<(f64, T)>> {
    table.each(name, |table| {
        let (at, part) = (table.quantity("at"), read(table));
        Some((at?, part?))
    })
}

/// A name that no other shaft or gear has.
fn unused_name(table: &Section, names: &mut BTreeSet<String>) -> Option<String> {
    let name = table.text("name")?.to_owned();
    if names.insert(name.clone()) {
        return Some(name);
    }
    table
        .inconsistent(
            "name",
            format!("another shaft or gear has the name `{name}`"),
        )
        .label("names must differ")
        .fail(table.issues)
}

fn section(table: &Section) -> Option<ShaftSection> {
    let length = table.quantity("length");
    let outer = table.quantity("outer");
    let inner = table.quantity("inner");
    let (outer, inner) = (outer?, inner?);
    if inner >= outer {
        let message = format!(
            "an inner diameter of {inner} m leaves no wall in an outer diameter of {outer} m"
        );
        return table
            .inconsistent("inner", message)
            .label("not less than the outer diameter")
            .remedy("make the inner diameter smaller than the outer diameter")
            .fail(table.issues);
    }
    Some(ShaftSection {
        length: length?,
        outer,
        inner,
        element: None,
    })
}

fn body(table: &Section) -> Option<Disc> {
    all_of!(Disc {
        polar_inertia: table.quantity("polar_inertia"),
        transverse_inertia: table.quantity("transverse_inertia"),
        mass: table.quantity("mass"),
    })
}

fn drag(table: &Section) -> Option<Drag> {
    all_of!(Drag {
        viscous: table.quantity("drag"),
        constant: table.quantity("drag_torque"),
    })
}

fn bearing(table: &Section) -> Option<Bearing> {
    let rolling = rolling::read(table, &["x", "y"]);
    let [x, y] = ["x", "y"].map(|key| match rolling {
        Some(None) => table.quantity(key),
        _ => Some(0.0),
    });
    let [axial, tilt] = ["axial", "tilt"].map(|key| table.quantity(key));
    let damping =
        ["damping_x", "damping_xy", "damping_yx", "damping_y"].map(|key| table.quantity(key));
    let cross = ["cross_xy", "cross_yx"].map(|key| table.quantity(key));
    let [xx, xy, yx, yy] = damping;
    Some(Bearing {
        x: x?,
        y: y?,
        axial: axial?,
        tilt: tilt?,
        damping: [[xx?, xy?], [yx?, yy?]],
        cross: [cross[0]?, cross[1]?],
        rolling: rolling?,
        pedestal: None,
    })
}

fn toothed_on_shaft(
    table: &Section,
    (sections, density): (&[ShaftSection], f64),
    names: &mut BTreeSet<String>,
) -> Option<(TrainGear, ToothForm)> {
    let name = unused_name(table, names);
    let at = table.quantity("at");
    let internal = table.boolean("internal");
    let outer = table.if_given("outer", Section::quantity);
    let loose = table.optional("loose", loose);
    let bore = at.and_then(|at| ShaftSection::at(sections, at));
    let bore = bore.map_or(0.0, |section| section.outer);
    let (internal, outer) = (internal?, outer?);
    if outer.is_some() && !internal {
        let remedy = "remove it, or set internal = true";
        table.without_effect(&["outer"], "with external teeth", remedy);
    }
    let rim = internal.then_some(outer);
    let loose = loose?;
    let has_hub = !internal && loose.is_none() && !sections.is_empty();
    let (gear, drawn) = toothed(table, density, (bore, rim, has_hub))?;
    let at = at?;
    if let Some(hub) = gear.hub {
        hub_is_on_shaft(table, (at, hub), sections)?;
    }
    let gear = TrainGear {
        name: name?,
        at,
        internal,
        loose,
        ..gear
    };
    Some((gear, drawn))
}

/// A planet of `[[train.planetary]]`, and its drawing data.
pub(super) fn planet(table: &Section, density: f64) -> Option<(TrainGear, ToothForm)> {
    let name = table.text("name");
    let bore = table.quantity("bore");
    let (gear, drawn) = toothed(table, density, (bore?, None, false))?;
    let gear = TrainGear {
        name: name?.to_owned(),
        ..gear
    };
    Some((gear, drawn))
}

/// Teeth and body of a gear around a bore \[m\]. `rim` is `None` for external teeth, otherwise the outer diameter of
/// the body \[m\] if it is given. `has_hub` means that the gear may have a hub, which becomes part of the shaft.
fn toothed(
    table: &Section,
    density: f64,
    (bore, rim, has_hub): (f64, Option<Option<f64>>, bool),
) -> Option<(TrainGear, ToothForm)> {
    let teeth = table.integer("teeth");
    let module = table.quantity("module");
    let width = table.quantity("width");
    let pressure_angle = table.quantity("pressure_angle");
    let helix_angle = table.quantity("helix_angle");
    let given = table.optional("body", body);
    let gear = || {
        Some(TrainGear {
            name: String::new(),
            at: 0.0,
            // The schema bounds the teeth far below the range of u32.
            teeth: teeth?,
            internal: false,
            module: module?,
            pressure_angle: pressure_angle?,
            helix_angle: helix_angle?,
            width: width?,
            body: Disc::default(),
            hub: None,
            loose: None,
        })
    };
    let gear = gear();
    let pair = gear.as_ref().map(|gear| pair_of([gear, gear], 1.0));
    let form = gear::of_one(table, width, pair.as_ref());
    let (gear, mut form) = (gear?, form?);
    let pitch = 2.0 * gear.pitch_radius();
    if has_hub {
        gear::warn_of_hub_length(table);
    } else {
        form.body[0].hub = None;
        let where_none = "on planets, rings, loose gears and shafts without sections";
        table.without_effect(&["hub_diameter", "hub_length"], where_none, "remove it");
    }
    form.ring = rim.map(|outer| outer.unwrap_or(pitch + RIM * gear.module));
    let inside = ("the shaft", bore, "teeth");
    let hub = form.body[0]
        .hub
        .map(|hub| ("the hub", hub.diameter, "hub_diameter"));
    let pitch = ("the pitch circle", pitch, "teeth");
    let outside = form
        .ring
        .map(|outer| ("the outside of the ring", outer, "outer"));
    let body = match given? {
        Some(body) => {
            if let Some(hub) = hub {
                lie_outside(table, &[inside, hub, pitch])?;
            }
            body
        }
        None => {
            let web = form.body[0].web;
            let rim = web.map(|web| ("the inside of the rim", web.rim_diameter, "rim_diameter"));
            let parts: Vec<_> = match outside {
                None => [Some(inside), hub, rim, Some(pitch)]
                    .into_iter()
                    .flatten()
                    .collect(),
                Some(_) => [Some(pitch), rim, outside].into_iter().flatten().collect(),
            };
            lie_outside(table, &parts)?;
            let hub_side = if outside.is_some() { pitch } else { hub.unwrap_or(inside) };
            let outer = outside.unwrap_or(pitch);
            Disc::webbed([outer.1, hub_side.1], gear.width, web, density).ok()?
        }
    };
    let hub = form.body[0].hub;
    Some((TrainGear { body, hub, ..gear }, form))
}

/// Checks that parts of a body lie outside one another, in this order: what, diameter \[m\], key.
fn lie_outside(table: &Section, parts: &[(&str, f64, &str)]) -> Option<()> {
    let Some(wrong) = parts.windows(2).find(|pair| pair[0].1 >= pair[1].1) else {
        return Some(());
    };
    let [(inside, inner, inner_key), (outside, outer, other)] = [wrong[0], wrong[1]];
    let key = [other, inner_key]
        .into_iter()
        .find(|key| *key != "teeth" && table.has(key))
        .unwrap_or("teeth");
    let [inner, outer] = [inner, outer].map(|diameter| 1e3 * diameter);
    let what = format!("{outside} ({outer:.3} mm) must lie outside of {inside} ({inner:.3} mm)");
    table
        .inconsistent(key, what)
        .label("does not fit")
        .remedy("check the module and the diameters, or give the body of the gear")
        .fail(table.issues)
}

/// Two gears as a pair without further drawing data, for a torque on the first one \[N m\].
pub(super) fn pair_of(gears: [&TrainGear; 2], rated_torque: f64) -> GearPair {
    GearPair {
        teeth: gears.map(|gear| gear.teeth),
        module: gears[0].module,
        pressure_angle: gears[0].pressure_angle,
        helix_angle: gears[0].helix_angle,
        face_width: gears[0].width.min(gears[1].width),
        body_length: gears.map(|gear| gear.width),
        rated_torque,
        form: ToothForm::default(),
    }
}

fn loose(table: &Section) -> Option<LooseGear> {
    let [x, y, axial, tilt] = ["x", "y", "axial", "tilt"].map(|key| table.quantity(key));
    let rolling = rolling::read(table, &["x", "y"]);
    let drag = drag(table);
    Some(LooseGear {
        bearing: Bearing {
            x: x?,
            y: y?,
            axial: axial?,
            tilt: tilt?,
            rolling: rolling?,
            ..Bearing::default()
        },
        drag: drag?,
    })
}
