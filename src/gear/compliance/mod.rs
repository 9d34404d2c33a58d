//! How much a pair of teeth gives under load, at any point of the path of contact.
//!
//! Improved potential-energy method (Yang & Lin 1987; Tian 2004; from the root circle along the
//! real profile: Ma et al. 2014, Mech. Syst. Signal Process. 43): a tooth is a cantilever that
//! stands on the root circle, its sections those of the involute and the trochoidal fillet.
//! Compliances are per unit face width: metres of approach along the line of action for a line
//! load of 1 N/m, so that a spring of width L has the stiffness `L / compliance`.

mod beam;
mod foundation;
mod hertz;
mod ring;

pub use beam::ToothCompliance;
pub(super) use foundation::BODY_RATIO;
pub(super) use ring::{RingCompliance, rings};

use super::Flanks;
use ring::RootLoad;

/// Compliance of one pair at one position, per unit face width \[m²/N\]. Arrays are
/// `[pinion, wheel]`.
///
/// Pairs in contact at the same time share the gear bodies, and each gives under the other's
/// load ([`Flanks::body_coupling`]): of two pairs with forces F₁ and F₂ the first gives
/// `(tooth + hertz + foundation₁) F₁ + coupling F₂`. That is a spring of compliance
/// [`Self::own`] a pair, and one of the coupling's that carries `F₁ + F₂`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairCompliance {
    /// Bending, shear and compression of each tooth above its root circle.
    pub tooth: [f64; 2],
    /// Flattening of the contact.
    pub hertz: f64,
    /// Fillet foundation of each gear at this contact point.
    pub foundation: [f64; 2],
}

impl PairCompliance {
    /// Teeth and contact without the bodies \[m²/N\].
    pub fn without_bodies(&self) -> f64 {
        self.tooth[0] + self.tooth[1] + self.hertz
    }

    /// What the pair does not share with another in contact, given their
    /// [`Flanks::body_coupling`] \[m²/N\].
    pub fn own(&self, coupling: [f64; 2]) -> f64 {
        self.total() - coupling[0] - coupling[1]
    }

    /// All of it in series: a pair alone in contact \[m²/N\].
    pub fn total(&self) -> f64 {
        self.without_bodies() + self.foundation[0] + self.foundation[1]
    }
}

impl Flanks {
    /// Compliance of the pair in contact at position s (held on the path of contact), the
    /// contact linear: `1/k_h = 2/π Σ (1 − ν²)/E` whatever the load.
    pub fn compliance(&self, s: f64) -> PairCompliance {
        let materials = &self.pair.form.material;
        PairCompliance {
            tooth: [0, 1].map(|gear| self.tooth_compliance(gear, s).total()),
            hertz: hertz::linear(materials),
            foundation: [0, 1].map(|gear| self.foundation_compliance(gear, s)),
        }
    }

    /// As [`Self::compliance`], with the contact's secant compliance at a line load \[N/m\]
    /// that is positive (Weber & Banaschek 1953): its approach over the load.
    pub fn compliance_under(&self, s: f64, line_load: f64) -> PairCompliance {
        PairCompliance {
            hertz: self.hertz_approach(s, line_load) / line_load,
            ..self.compliance(s)
        }
    }

    /// Approach of the flanks at position s by their flattening under a line load \[m\]: from
    /// the contact to the centre line of either tooth.
    pub fn hertz_approach(&self, s: f64, line_load: f64) -> f64 {
        let rolls = self.roll(s);
        let depths = [0, 1].map(|gear| {
            let tooth = &self.teeth[gear];
            tooth.flank(rolls[gear]).x / tooth.force_angle(rolls[gear]).cos()
        });
        hertz::approach(
            &self.pair.form.material,
            self.relative_radius(s),
            depths,
            line_load,
        )
    }

    /// Bending, shear and compression of the tooth of a gear (0 = pinion) loaded at position s.
    pub fn tooth_compliance(&self, gear: usize, s: f64) -> ToothCompliance {
        beam::tooth(
            &self.teeth[gear],
            self.roll(s)[gear],
            &self.pair.form.material[gear],
            &self.rule,
        )
    }

    /// Fillet foundation of a gear (0 = pinion) loaded at position s, per unit width \[m²/N\].
    pub fn foundation_compliance(&self, gear: usize, s: f64) -> f64 {
        foundation::compliance(
            &self.teeth[gear],
            self.roll(s)[gear],
            self.bores[gear],
            self.pair.form.material[gear].young_modulus,
        )
    }

    /// What the bodies of pinion and wheel give at the pair at position s under a unit line load
    /// on the pair `ahead` base pitches further along the path, and the other way round, per unit
    /// width \[m²/N\]; none where the two are not in contact at once.
    pub fn body_coupling(&self, s: f64, ahead: usize) -> Option<[f64; 2]> {
        let path = self.path();
        let further = s + ahead as f64 * path.base_pitch;
        // A pair that leaves contact within round-off is still in it.
        let (slack, [first, last]) = (1e-9 * path.base_pitch, self.reach());
        if ahead == 0 || s < first - slack || further > last + slack {
            return None;
        }
        let rings = self.rings.get(ahead - 1)?;
        let (near, far) = (self.roll(s), self.roll(further));
        Some([0, 1].map(|gear| {
            let tooth = &self.teeth[gear];
            let load = |roll: f64| {
                let angle = tooth.force_angle(roll);
                RootLoad::new(angle, foundation::lever(tooth, angle))
            };
            let young_modulus = self.pair.form.material[gear].young_modulus;
            rings[gear].between(load(far[gear]), load(near[gear])) / young_modulus
        }))
    }
}
