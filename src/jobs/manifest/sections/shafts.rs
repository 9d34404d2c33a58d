//! `[shafts]`: material, stations, bearings, pedestals and end inertias. `[shafts]` has the keys that both shafts
//! share; `[shafts.pinion]` and `[shafts.wheel]` override them.
//!
//! The tables describe a machine; the model kind selects the motions. A kind reads the keys that it needs and checks
//! the others, so that changing `model.kind` alone changes the tier. Only pedestals without effect are not checked.

use super::drive_kind::DriveKind;
use super::ineffective_keys::has_effect;
use crate::gear::GearPair;
use crate::manifest::reader::Section;
use crate::shaft::{Bearing, Drag, Pedestal, Shaft, Tier};

/// Shafts and their material.
pub(super) struct ShaftSet {
    pub shafts: [Shaft; 2],
    pub pedestals: Option<[[Pedestal; 2]; 2]>,
    pub density: f64,
    /// Elastic data. Only rigid model kinds accept `None`.
    pub elastic: Option<Elastic>,
}

/// The data of flexible shafts, and the numbers of their elements.
pub(super) struct Elastic {
    pub young_modulus: f64,
    pub shear_modulus: f64,
    pub shear_coefficient: f64,
    pub elements: [usize; 3],
}

pub(super) fn read(
    section: &Section,
    gears: Option<&GearPair>,
    kind: DriveKind,
) -> Option<ShaftSet> {
    let elastic = elastic(section, kind);
    let density = section.quantity("density");
    let radii = gears.map(GearPair::pitch_radii);
    let pinion = shaft(section, "pinion", radii.map(|r| r[0]), kind);
    let wheel = shaft(section, "wheel", radii.map(|r| r[1]), kind);
    let ((pinion, first), (wheel, second)) = (pinion?, wheel?);
    Some(ShaftSet {
        shafts: [pinion, wheel],
        pedestals: first.zip(second).map(<[_; 2]>::from),
        density: density?,
        elastic: elastic?,
    })
}

/// Moduli and elements, which are checked even if they have no effect. The outer `None` is a fault, the inner one an
/// incomplete set.
fn elastic(section: &Section, kind: DriveKind) -> Option<Option<Elastic>> {
    let is_read = |key: &str| has_effect(kind, key) || section.has(key);
    let modulus = |key: &str| {
        if is_read(key) { section.quantity(key).map(Some) } else { Some(None) }
    };
    let (young, shear) = (modulus("young_modulus"), modulus("shear_modulus"));
    let shear_coefficient = section.quantity("shear_coefficient");
    let elements = if is_read("elements") { elements(section).map(Some) } else { Some(None) };
    let moduli = young?.zip(shear?);
    if let Some((young, shear)) = moduli {
        check_moduli(section, young, shear)?;
    }
    let shear_coefficient = shear_coefficient?;
    let complete = moduli.zip(elements?);
    Some(complete.map(|(moduli, elements)| Elastic {
        young_modulus: moduli.0,
        shear_modulus: moduli.1,
        shear_coefficient,
        elements,
    }))
}

fn elements(section: &Section) -> Option<[usize; 3]> {
    let [overhang, first, second] = section.integers::<3>("elements")?.map(usize::try_from);
    Some([overhang.ok()?, first.ok()?, second.ok()?])
}

/// `ν = E/2G − 1` must be in (−1, 1/2], otherwise one of the moduli is wrong.
fn check_moduli(section: &Section, young: f64, shear: f64) -> Option<()> {
    let poisson = young / (2.0 * shear) - 1.0;
    if poisson <= 0.5 {
        return Some(());
    }
    let message = format!(
        "young_modulus E and shear_modulus G give Poisson's ratio E/(2G) - 1 = {poisson:.3}; no material exceeds 0.5"
    );
    section
        .inconsistent("shear_modulus", message)
        .label("contradicts young_modulus")
        .remedy("check both units; steel has 206 GPa and 79 GPa")
        .fail(section.issues)
}

/// One shaft and the supports of its bearings.
fn shaft(
    shared: &Section,
    name: &'static str,
    pitch_radius: Option<f64>,
    kind: DriveKind,
) -> Option<(Shaft, Option<[Pedestal; 2]>)> {
    let table = shared.required_child(name)?;
    let diameter = table.quantity("diameter");
    let inner = table.quantity("inner_diameter");
    let end_inertia = table.quantity("end_inertia");
    let viscous = table.quantity("drag");
    let constant = table.quantity("drag_torque");
    let layers = LayeredTable {
        shared_table: shared.clone(),
        override_table: Some(table.clone()),
    };
    let either = |key: &str| layers.value(key, |section| section.quantity(key));
    let (span, overhang) = (either("span"), either("overhang"));
    let place = "gear_position";
    let gear_position = if has_effect(kind, place) || layers.of(place).has(place) {
        either(place)
    } else {
        // The position has no effect.
        Some(0.5)
    };
    let bearings = bearings(shared, &table, kind);
    let pedestals = pedestals(shared, &table, kind);
    let diameter = diameter?;
    if pitch_radius.is_some_and(|radius| diameter >= 2.0 * radius) {
        let message = format!(
            "the diameter of the {name} shaft is not less than the pitch diameter of its gear, {} m",
            2.0 * pitch_radius?
        );
        return table
            .inconsistent("diameter", message)
            .label("does not fit into the gear")
            .remedy("check the shaft's diameter, gear.module and gear.teeth")
            .fail(table.issues);
    }
    let inner_diameter = inner?;
    if inner_diameter >= diameter {
        let message = format!("the {name} shaft has no wall: its outer diameter is {diameter} m");
        return table
            .inconsistent("inner_diameter", message)
            .label("not less than the diameter")
            .remedy("check both diameters of the shaft; a solid shaft has no inner_diameter")
            .fail(table.issues);
    }
    let shaft = Shaft {
        diameter,
        inner_diameter,
        span: span?,
        overhang: overhang?,
        gear_position: gear_position?,
        end_inertia: end_inertia?,
        bearings: bearings?,
        drag: Drag {
            viscous: viscous?,
            constant: constant?,
        },
    };
    Some((shaft, pedestals?))
}

/// A table that both shafts share, and a table of one shaft that overrides it key by key.
struct LayeredTable<'t> {
    shared_table: Section<'t>,
    override_table: Option<Section<'t>>,
}

impl<'t> LayeredTable<'t> {
    /// Both layers of the table `name`. The outer `None` means a reported fault. The inner `None` means that neither
    /// layer has the table, which is optional.
    fn read(
        shared: &Section<'t>,
        section: &Section<'t>,
        name: &str,
        required: bool,
    ) -> Option<Option<Self>> {
        let (shared_table, override_table) = (shared.child(name), section.child(name));
        let (shared_table, override_table) = match (shared_table?, override_table?) {
            (None, None) if required => {
                shared.missing(name);
                return None;
            }
            (None, None) => return Some(None),
            (Some(shared_table), override_table) => (shared_table, override_table),
            (None, Some(only)) => (only, None),
        };
        Some(Some(Self {
            shared_table,
            override_table,
        }))
    }

    /// The table from which a key is read: that of one shaft if it has the key, otherwise the shared one.
    fn of(&self, key: &str) -> &Section<'t> {
        match &self.override_table {
            Some(override_table) if override_table.has(key) => override_table,
            _ => &self.shared_table,
        }
    }

    /// The result of `read` for a key; an overridden value is still checked.
    fn value<T>(&self, key: &str, mut read: impl FnMut(&Section<'t>) -> Option<T>) -> Option<T> {
        let section = self.of(key);
        if self
            .override_table
            .as_ref()
            .is_some_and(|override_table| override_table.has(key))
            && self.shared_table.has(key)
        {
            _ = read(&self.shared_table);
        }
        read(section)
    }

    /// The values of a key for both bearings.
    fn both(&self, key: &str) -> Option<[f64; 2]> {
        self.value(key, |section| section.one_or_pair(key))
    }
}

fn bearings(shared: &Section, shaft_table: &Section, kind: DriveKind) -> Option<[Bearing; 2]> {
    let needed = |key: &str| has_effect(kind, &format!("bearings.{key}"));
    let Some(layers) = LayeredTable::read(shared, shaft_table, "bearings", needed("y"))? else {
        return Some([Bearing::default(); 2]);
    };
    let is_read = |key: &str| needed(key) || layers.of(key).has(key);
    let read = |key: &str, is_read: bool| {
        if is_read { layers.both(key) } else { Some([0.0; 2]) }
    };
    let mut optional = |key: &str| read(key, layers.of(key).has(key));
    let damping = ["damping_x", "damping_xy", "damping_yx", "damping_y"].map(&mut optional);
    let cross = ["cross_xy", "cross_yx"].map(&mut optional);
    let pair_of = |key: &str| read(key, is_read(key));
    let x = pair_of("x");
    let y = pair_of("y");
    let tilt = pair_of("tilt");
    let axial = if is_read("axial") {
        layers.value("axial", |section| section.pair("axial"))
    } else {
        Some([0.0; 2])
    };
    if axial == Some([0.0; 2]) && needed("axial") {
        let section = layers.of("axial");
        return section
            .inconsistent("axial", "no bearing holds the shaft axially")
            .label("at least one must be greater than 0")
            .remedy("give one bearing an axial stiffness, for example [\"1e8 N/m\", 0]")
            .fail(section.issues);
    }
    let (x, y, tilt, axial) = (x?, y?, tilt?, axial?);
    let ([xx, xy, yx, yy], [cross_xy, cross_yx]) = (damping, cross);
    let (xx, xy, yx, yy) = (xx?, xy?, yx?, yy?);
    let (cross_xy, cross_yx) = (cross_xy?, cross_yx?);
    Some([0, 1].map(|i| Bearing {
        x: x[i],
        y: y[i],
        axial: axial[i],
        tilt: tilt[i],
        damping: [[xx[i], xy[i]], [yx[i], yy[i]]],
        cross: [cross_xy[i], cross_yx[i]],
        rolling: None,
        pedestal: None,
    }))
}

/// The supports of both bearings. The outer `None` is a fault; the inner one means bearings on the ground.
fn pedestals(
    shared: &Section,
    shaft_table: &Section,
    kind: DriveKind,
) -> Option<Option<[Pedestal; 2]>> {
    if let Some(name) = kind.name().filter(|&name| name != Tier::Pedestal.name()) {
        let why = format!("with kind = \"{name}\": its bearings stand on the ground");
        for section in [shared, shaft_table] {
            section.without_effect(
                &["pedestals"],
                &why,
                "remove it, or set kind = \"pedestal\"",
            );
        }
        return Some(None);
    }
    let required = kind == DriveKind::Rigid(Tier::Pedestal);
    let Some(layers) = LayeredTable::read(shared, shaft_table, "pedestals", required)? else {
        return Some(None);
    };
    let x = layers.both("x");
    let y = layers.both("y");
    let mass = layers.both("mass");
    let (x, y, mass) = (x?, y?, mass?);
    Some(Some([0, 1].map(|i| Pedestal {
        x: x[i],
        y: y[i],
        mass: mass[i],
    })))
}
