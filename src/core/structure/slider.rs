//! Which contacts does a structure have for a dry slider?

use super::{ContactLaw, ModalStructure, SliderPart, StructureContact};

impl StructureContact {
    /// The three contacts of a dry slider along a line: the forward slip, the backward slip, the spring.
    ///
    /// * `participation`: participation of the deflection, one entry per mode \[1/√kg\].
    /// * `stiffness`: stiffness k of the spring \[N/m\], for a rotation \[N m/rad\].
    /// * `limit`: limit F of the force \[N\], for a rotation \[N m\].
    pub fn slider(name: &str, participation: &[f64], stiffness: f64, limit: f64) -> [Self; 3] {
        let mut series = [0.0; 8];
        series[0] = stiffness;
        SliderPart::ALL.map(|(part, suffix)| {
            let law = ContactLaw {
                gap: if part == SliderPart::Spring { 0.0 } else { limit / stiffness },
                stiffness: vec![(1.0, series)],
                slider: Some(part),
                ..ContactLaw::default()
            };
            Self::plain(format!("{name}, {suffix}"), participation.to_vec(), law)
        })
    }
}

impl ModalStructure {
    /// Number of dry sliders.
    pub fn sliders(&self) -> usize {
        let springs = self.contacts.iter();
        springs
            .filter(|contact| contact.law.slider == Some(SliderPart::Spring))
            .count()
    }
}
