//! The flanks of one mesh cycle in which some teeth differ: every pair has the faults of its two teeth.
//!
//! The pair of tooth n first touches at the start of mesh cycle n, at the start of the path of contact. In mesh cycle c
//! the pair at s therefore belongs to the tooth
//!
//! ```text
//! n = c − ⌊τ⌋,    τ = (s − s_start)/p_bt
//! ```
//!
//! and has touched for τ cycles. The fault leaves the part f₀ of the stiffness 1/C of the pair. Its crack
//! adds the deflection c per force, and material d is missing from its flanks. On a face of width b this pair
//! has the compliance `C/f₀ + b c`, and d adds to its relief. Load sharing then decides which pairs touch.

use super::compliance::{FaceCoupling, PairCompliance};
use super::flank_law::{FlankLaw, forward};
use super::flanks::PathOfContact;
use super::tooth_fault::{FaultyTeeth, ToothFault};
use std::sync::Arc;

/// The flanks of a mesh cycle.
pub struct FaultyFlanks<'a, L> {
    /// The law of equal teeth.
    pub law: &'a L,
    /// The teeth.
    pub teeth: &'a FaultyTeeth,
    /// Width of the face \[m\].
    pub face_width: f64,
    /// 0 for drive flanks, 1 for coast flanks. A cycle of coast flanks runs backwards in time: the mirror image of a cycle
    /// of drive flanks, in which teeth engage in the opposite order.
    pub flank: usize,
    /// The mesh cycle c.
    pub cycle: usize,
}

impl<L: FlankLaw> FaultyFlanks<'_, L> {
    /// The faults of the pair that first touched `since` cycles (τ) ago.
    fn faults(&self, since: f64) -> impl Iterator<Item = &ToothFault> {
        let number = self.cycle as i64 - since.floor() as i64;
        self.teeth.faults.iter().filter(move |fault| {
            let tooth = match self.flank {
                0 => i64::from(fault.tooth),
                // On coast flanks tooth n of the wheel meets tooth n − 1 of the pinion.
                _ => fault.gear as i64 - i64::from(fault.tooth),
            };
            (number - tooth).rem_euclid(i64::from(self.teeth.teeth[fault.gear])) == 0
        })
    }

    /// Time τ for which the pair at s has touched \[cycles\].
    fn since(&self, s: f64) -> f64 {
        let path = self.law.path();
        (s - path.start) / path.base_pitch
    }

    /// Whether a pair within reach differs from the others in this cycle.
    pub fn differ(&self) -> bool {
        let [first, last] = self.law.reach().map(|s| self.since(s).floor() as i64);
        (first..=last).any(|whole| self.faults(whole as f64).next().is_some())
    }
}

impl<L: FlankLaw> FlankLaw for FaultyFlanks<'_, L> {
    forward! { law:
        path() -> PathOfContact;
        helix() -> f64;
        reach() -> [f64; 2];
        coupling(s: f64, ahead: usize) -> f64;
        face_coupling() -> Option<Arc<FaceCoupling>>;
        deviation(s: f64, z: f64) -> f64;
        contact(s: f64, line_load: f64) -> [f64; 2];
        kinks() -> Vec<f64>;
    }

    fn compliance(&self, s: f64) -> PairCompliance {
        let since = self.since(s);
        let sound = self.law.compliance(s);
        let mut own = sound;
        for fault in self.faults(since) {
            let crack = fault.cracks[self.flank].map_or(0.0, |crack| crack.at(since));
            own.tooth[fault.gear] +=
                sound.total() * (1.0 / fault.stiffness - 1.0) + self.face_width * crack;
        }
        own
    }

    fn relief(&self, s: f64) -> f64 {
        let missing = self
            .faults(self.since(s))
            .map(|own| own.missing[self.flank]);
        self.law.relief(s) + missing.sum::<f64>()
    }
}
