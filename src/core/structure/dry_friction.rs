//! Which contacts does a structure have for an element of dry friction?

use super::{ContactLaw, FrictionPart, ModalStructure, SliderPart, StructureContact};

/// The law of an element of dry friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionLaw {
    /// Force F of sliding friction \[N\], for a rotation \[N m\].
    pub force: f64,
    /// Largest force F_s of static friction, at least F \[N\], for a rotation \[N m\].
    pub static_force: f64,
    /// Speed u of the surface along the line \[m/s\], for a rotation \[rad/s\].
    pub belt_speed: f64,
}

impl StructureContact {
    /// The three contacts of dry friction along a line: the forward slip, the backward slip, the stick.
    ///
    /// * `participation`: participation of the deflection, one entry per mode \[1/√kg\].
    pub fn dry_friction(name: &str, participation: &[f64], law: FrictionLaw) -> [Self; 3] {
        let parts = [
            (FrictionPart::Forwards, law.force),
            (FrictionPart::Backwards, law.force),
            (
                FrictionPart::Stick {
                    static_force: law.static_force,
                    belt_speed: law.belt_speed,
                },
                1.0,
            ),
        ];
        let suffixes = SliderPart::ALL.map(|(_, suffix)| suffix);
        let mut suffixes = suffixes.into_iter();
        parts.map(|(part, force)| {
            // A slip has a constant force. The quantity along the line of the stick is the force itself, so
            // that the stiffness of the stick is 1.
            let mut series = [0.0; 8];
            series[0] = force;
            let law = ContactLaw {
                stiffness: vec![(1.0, series)],
                dry_friction: Some(part),
                ..ContactLaw::default()
            };
            let name = format!("{name}, {}", suffixes.next().unwrap_or_default());
            Self::plain(name, participation.to_vec(), law)
        })
    }
}

impl ModalStructure {
    /// Number of elements of dry friction.
    pub fn dry_frictions(&self) -> usize {
        let parts = self.contacts.iter().map(|contact| contact.law.dry_friction);
        parts
            .filter(|part| *part == Some(FrictionPart::Forwards))
            .count()
    }
}
