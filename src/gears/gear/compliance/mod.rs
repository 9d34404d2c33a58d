//! How compliant is a pair of teeth under load, at any point of the path of contact?
//!
//! A gear is a plane elastic body: its teeth are plates on a ring that is clamped at its bore. One
//! solution ([`GearBody`]) gives the compliance of tooth, body and neighbouring teeth. The deflection is taken along
//! the line of action, at its intersection with the tooth's centre line. Between this point and the contact the flanks
//! flatten like a half space (Weber & Banaschek 1953).
//! Compliances are per unit face width: metres of approach along the line of action for a line load of 1 N/m. A spring
//! of width L has the stiffness `L / compliance`.

mod body;
mod face_coupling;
pub(super) mod hertz;
mod plate;
mod ring;
mod solid;

use super::Flanks;
use body::GearBody;
pub(super) use body::{GearBodies, LEAST_BODY_RATIO};
pub use face_coupling::FaceCoupling;

/// Compliance of one pair at one position, per unit face width \[m²/N\]. Arrays are
/// `[pinion, wheel]`.
///
/// Pairs in contact at the same time share the gear bodies, and the load of one displaces the other
/// ([`Flanks::body_coupling`]). If two pairs carry F₁ and F₂, the first deflects by
/// `(tooth + hertz + foundation₁) F₁ + coupling F₂`. This equals a spring of compliance [`Self::uncoupled`] per pair,
/// and one of the coupling's compliance that carries `F₁ + F₂`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairCompliance {
    /// Each tooth above its root circle, with its foot clamped.
    pub tooth: [f64; 2],
    /// Flattening of the contact.
    pub hertz: f64,
    /// The body of each gear below this tooth.
    pub foundation: [f64; 2],
}

impl PairCompliance {
    /// Teeth and contact without the bodies \[m²/N\].
    pub fn without_bodies(&self) -> f64 {
        self.tooth[0] + self.tooth[1] + self.hertz
    }

    /// Compliance that the pair does not share with a second pair in contact \[m²/N\]; `coupling` is the
    /// [`Flanks::body_coupling`] of both pairs.
    pub fn uncoupled(&self, coupling: [f64; 2]) -> f64 {
        self.total() - coupling[0] - coupling[1]
    }

    /// Compliance of a pair alone in contact: all parts in series \[m²/N\].
    pub fn total(&self) -> f64 {
        self.without_bodies() + self.foundation[0] + self.foundation[1]
    }
}

impl Flanks {
    /// Compliance of the pair in contact at position s (clamped to the path of contact), with a linear
    /// contact: `1/k_h = 2/π Σ (1 − ν²)/E` at any load.
    pub fn compliance(&self, s: f64) -> PairCompliance {
        let rolls = self.roll(s);
        let bodies = self.gear_bodies();
        let each = |of: fn(&GearBody, f64) -> f64| {
            [0, 1].map(|gear| {
                bodies[gear]
                    .as_ref()
                    .map_or(f64::NAN, |body| of(body, rolls[gear]))
            })
        };
        PairCompliance {
            tooth: each(GearBody::tooth),
            hertz: hertz::linear(&self.pair.form.material),
            foundation: each(GearBody::foundation),
        }
    }

    /// Approach of the flanks at position s by their flattening under a line load \[m\], between
    /// the centre lines of both teeth.
    pub fn hertz_approach(&self, s: f64, line_load: f64) -> f64 {
        let rolls = self.roll(s);
        let depths = [0, 1].map(|gear| {
            let tooth = &self.teeth[gear];
            // Distance from the contact to the tooth's centre line, along the force.
            tooth.base_radius * (rolls[gear] - tooth.force_angle(rolls[gear]).tan())
        });
        hertz::approach(
            &self.pair.form.material,
            self.relative_radius_at(rolls),
            depths,
            line_load,
        )
    }

    /// Displacements of the bodies of pinion and wheel at the pair at position s, per unit width \[m²/N\]. A unit line
    /// load acts on the pair `pairs_ahead` base pitches further along the path. Exchanging the pairs gives the same
    /// values. `None` if `pairs_ahead` is 0, or if the two pairs are not in contact at the same time.
    pub fn body_coupling(&self, s: f64, pairs_ahead: usize) -> Option<[f64; 2]> {
        let path = self.path();
        let further = s + pairs_ahead as f64 * path.base_pitch;
        // A pair at an end of the path within round-off is still in contact.
        let slack = 1e-9 * path.base_pitch;
        if pairs_ahead == 0 || s < path.start - slack || further > path.end + slack {
            return None;
        }
        self.coupled(s, pairs_ahead)
    }

    /// As [`Self::body_coupling`], also for pairs within reach whose tip edges touch off the path. `None` if
    /// `pairs_ahead` is 0 or beyond the teeth of the solution.
    pub(super) fn coupled(&self, s: f64, pairs_ahead: usize) -> Option<[f64; 2]> {
        let further = s + pairs_ahead as f64 * self.path().base_pitch;
        let (near, far) = (self.roll(s), self.roll(further));
        let [pinion, wheel] = self.gear_bodies();
        // Forces act in the −x direction of their tooth. Teeth further along the path are ahead in the sense of
        // rotation: on the pinion in the +x direction, on the wheel in the −x direction.
        Some([
            pinion.as_ref().map_or(Some(f64::NAN), |body| {
                body.coupling(near[0], pairs_ahead, far[0])
            })?,
            wheel.as_ref().map_or(Some(f64::NAN), |body| {
                body.coupling(far[1], pairs_ahead, near[1])
            })?,
        ])
    }

    /// The bodies, solved at the first call.
    fn gear_bodies(&self) -> &[Option<GearBody>; 2] {
        self.bodies.0.get_or_init(|| {
            let path = self.path();
            let (start, end) = (self.roll(path.start), self.roll(path.end));
            let [first, last] = self.reach();
            [0, 1].map(|gear| {
                let tooth = &self.teeth[gear];
                let form = &self.pair.form;
                GearBody::new(
                    tooth,
                    self.pair.teeth[gear],
                    2.0 * tooth.root_radius / self.bores[gear],
                    &form.material[gear].in_plane(form.plane),
                    [start[gear].min(end[gear]), start[gear].max(end[gear])],
                    ((last - first) / path.base_pitch) as usize,
                )
            })
        })
    }
}
