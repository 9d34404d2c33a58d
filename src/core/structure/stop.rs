//! Which contacts does a structure have for a rigid stop?

use super::{ContactLaw, ModalStructure, StopPart, StructureContact};

impl StructureContact {
    /// The two contacts of a rigid stop, impact and rest, with a coefficient of restitution. They take the
    /// cycles and the error of this contact, and the impact takes its gap. Its stiffness and damping have no
    /// effect.
    pub fn rigid(self, restitution: f64) -> [Self; 2] {
        let law_of = |part: StopPart| ContactLaw {
            stiffness: vec![(1.0, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
            damping: 0.0,
            stop: Some(part),
            ..self.law.clone()
        };
        let rest = Self {
            name: format!("{}, {}", self.name, StopPart::REST),
            law: ContactLaw {
                gap: 0.0,
                ..law_of(StopPart::Rest)
            },
            ..self.clone()
        };
        let law = law_of(StopPart::Impact { restitution });
        [Self { law, ..self }, rest]
    }
}

impl ModalStructure {
    /// Number of rigid stops.
    pub fn rigid_stops(&self) -> usize {
        let parts = self.contacts.iter().map(|contact| contact.law.stop);
        parts.filter(|part| *part == Some(StopPart::Rest)).count()
    }
}
