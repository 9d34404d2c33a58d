//! What load sharing has to know of a tooth pair: where it meets, how it yields, what is
//! missing from its flanks.

use super::{Flanks, PairCompliance, PathOfContact};

/// The law of one pair of teeth along the path of contact.
///
/// At mesh phase φ in \[0, 1) the pairs in contact stand at `s = start + (φ + j) base_pitch`,
/// j = 0, 1, …, as far as the path goes.
pub trait FlankLaw: Sync {
    /// The path of contact.
    fn path(&self) -> PathOfContact;

    /// Compliance of a pair at s, `start ≤ s ≤ end`.
    fn compliance(&self, s: f64) -> PairCompliance;

    /// Material removed from both flanks at s \[m\].
    fn relief(&self, s: f64) -> f64;

    /// What is missing besides relief \[m\], at s and at z \[m\] from mid-face: crowning,
    /// errors of form.
    fn deviation(&self, _s: f64, _z: f64) -> f64 {
        0.0
    }

    /// Positions inside the path where compliance or relief has a kink \[m\].
    fn kinks(&self) -> Vec<f64> {
        Vec::new()
    }
}

impl FlankLaw for Flanks {
    fn path(&self) -> PathOfContact {
        self.path()
    }

    fn compliance(&self, s: f64) -> PairCompliance {
        self.compliance(s)
    }

    fn relief(&self, s: f64) -> f64 {
        self.relief(s)
    }
}
