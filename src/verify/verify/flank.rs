//! A flank with the same stiffness everywhere, for closed forms.

use crate::gear::{FlankLaw, PairCompliance, PathOfContact};

/// Teeth with the same compliance at all positions, on rigid gear bodies.
pub struct EvenFlank {
    path: PathOfContact,
    compliance: PairCompliance,
}

impl EvenFlank {
    /// A path with the given contact ratio; `stiffness`: stiffness of a pair times width \[N/m²\].
    pub fn new(contact_ratio: f64, stiffness: f64) -> Self {
        let base_pitch = 11.8e-3;
        let start = -0.3 * base_pitch;
        let total = 1.0 / stiffness;
        Self {
            path: PathOfContact {
                base_pitch,
                start,
                end: start + contact_ratio * base_pitch,
                pitch_point: 0.0,
            },
            compliance: PairCompliance {
                tooth: [0.3 * total, 0.5 * total],
                hertz: 0.2 * total,
                foundation: [0.0; 2],
            },
        }
    }
}

impl FlankLaw for EvenFlank {
    fn path(&self) -> PathOfContact {
        self.path
    }

    fn compliance(&self, _: f64) -> PairCompliance {
        self.compliance
    }

    fn relief(&self, _: f64) -> f64 {
        0.0
    }
}
