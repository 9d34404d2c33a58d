//! What is a rigid stop to a structure?

use super::{ContactLaw, ModalStructure, StructureContact};

/// The two contacts of a rigid one-sided stop with a coefficient of restitution ε.
///
/// Newton's law of impact reverses the speed δ' of approach. Where impacts accumulate, the stop holds δ at its gap by a force
/// λ that pushes only:
///
/// ```text
/// impact:  δ = b, δ' > 0:   δ' → −ε δ'
/// rest:    δ = b, δ' = 0    until λ = 0
/// ```
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub enum StopPart {
    /// It is hit. The contact closes and opens at the same instant.
    Impact {
        /// ε, from 0 to 1.
        restitution: f64,
    },
    /// It holds the structure.
    Rest,
}

impl StopPart {
    /// What the name of the second contact ends in.
    pub const REST: &str = "rest";
}

impl StructureContact {
    /// The two contacts of a rigid stop with a coefficient of restitution and the gap, cycles and error of a contact, whose
    /// stiffness and damping do not count: impact, rest.
    pub fn rigid(self, restitution: f64) -> [Self; 2] {
        let part = |part: StopPart| ContactLaw {
            stiffness: vec![(1.0, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
            damping: 0.0,
            stop: Some(part),
            ..self.law.clone()
        };
        let rest = Self {
            name: format!("{}, {}", self.name, StopPart::REST),
            law: ContactLaw {
                gap: 0.0,
                ..part(StopPart::Rest)
            },
            ..self.clone()
        };
        let law = part(StopPart::Impact { restitution });
        [Self { law, ..self }, rest]
    }
}

impl ModalStructure {
    /// Number of rigid stops.
    pub fn rigid_stops(&self) -> usize {
        let parts = self.contacts.iter().map(|own| own.law.stop);
        parts.filter(|part| *part == Some(StopPart::Rest)).count()
    }
}
