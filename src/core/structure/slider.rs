//! What are a dry slider and its spring to a structure?

use super::{ContactLaw, ModalStructure, StructureContact};

/// The three states of a dry slider in series with a spring, each a contact of its own. Exactly one of them is closed.
///
/// The element bears `f = k (δ − s)` with the place s of its slider, but never more than its limit F:
///
/// ```text
/// stick:  s' = 0                       until f = ±F
/// slip:   f = ±F,  s = δ ∓ F/k         until δ' changes its sign
/// ```
///
/// Source: Jenkins 1962; Iwan 1966 for several elements on one line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum SliderPart {
    /// It slips in the direction in which δ grows.
    Forwards,
    /// It slips in the other direction.
    Backwards,
    /// It sticks: its spring bears.
    Spring,
}

impl SliderPart {
    /// All parts in the order of their contacts, each with what its name ends in.
    pub const ALL: [(Self, &'static str); 3] = [
        (Self::Forwards, "slip forwards"),
        (Self::Backwards, "slip backwards"),
        (Self::Spring, "stick"),
    ];
}

impl StructureContact {
    /// The three contacts of a dry slider along a line: the slips forwards and backwards, then the spring.
    ///
    /// * `participation`: of its deflection, one entry per mode \[1/√kg\].
    /// * `stiffness`: k of the spring \[N/m\], against twist \[N m/rad\].
    /// * `limit`: F of the slider \[N\], \[N m\].
    pub fn slider(name: &str, participation: &[f64], stiffness: f64, limit: f64) -> [Self; 3] {
        let mut series = [0.0; 8];
        series[0] = stiffness;
        SliderPart::ALL.map(|(part, suffix)| Self {
            name: format!("{name}, {suffix}"),
            participation: participation.to_vec(),
            force: participation.to_vec(),
            tilt: Vec::new(),
            rubbing: Default::default(),
            cycles: [1, 1],
            law: ContactLaw {
                gap: if part == SliderPart::Spring { 0.0 } else { limit / stiffness },
                stiffness: vec![(1.0, series)],
                slider: Some(part),
                ..ContactLaw::default()
            },
            copies: None,
        })
    }
}

impl ModalStructure {
    /// Number of dry sliders.
    pub fn sliders(&self) -> usize {
        let springs = self.contacts.iter();
        springs
            .filter(|own| own.law.slider == Some(SliderPart::Spring))
            .count()
    }
}
