//! The flanks of a pair in mesh: checked geometry, path of contact, backlash, relief and sliding. All are in the
//! transverse section, in which helical gears equal spur gears. [`FlankLaw`](super::FlankLaw) has the compliances of
//! inclined teeth.
//!
//! Positions s \[m\] lie on the line of action, 0 at the pitch point, growing in the sense of
//! running with the pinion driving: contact begins at the wheel's tip (s < 0) and ends at the
//! pinion's (s > 0). The roll angles are `tan α_w + s/r_b1` of the pinion and
//! `tan α_w − s/r_b2` of the wheel.
//!
//! The wheel may be a ring ([`ToothForm::ring`](super::ToothForm::ring)) with negative radii. The same formulas apply.

use super::compliance::GearBodies;
use super::drawing_checks::{bores, check_points, check_values};
use super::pair::NO_BACKLASH;
use super::tip_contact::TipContact;
use super::{FaceCoupling, GearError, GearPair, InternalPair, Tooth, Undercut};
use std::sync::Arc;

/// Gap \[modules\] up to which tip edges beyond the ends of the path are considered: several times the gap
/// that a load within the strength of the teeth closes.
const TIP_GAP: f64 = 0.03;

/// A virtual tooth is thick enough to carry load up to this part of the roll angle at which its flanks meet; for a ring
/// the reciprocal.
const LAST_ROLL: f64 = 0.99;

/// Largest number of pairs in contact at once, those off the path included: a little less than three.
const MOST_RATIO: f64 = 2.99;

/// Where rigid gears can touch on the line of action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathOfContact {
    /// Distance between neighbouring pairs in contact, `π m_t cos α_t` \[m\].
    pub base_pitch: f64,
    /// Where contact begins, at the wheel's tip \[m\].
    pub start: f64,
    /// Where it ends, at the pinion's tip \[m\].
    pub end: f64,
    /// The pitch point \[m\]: 0.
    pub pitch_point: f64,
}

impl PathOfContact {
    /// Mean number of pairs in contact, `(end − start) / base pitch`.
    pub fn contact_ratio(&self) -> f64 {
        (self.end - self.start) / self.base_pitch
    }

    /// First and last position at which a single pair is in contact \[m\]; `None` from a contact ratio of 2.
    pub fn single_pair(&self) -> Option<[f64; 2]> {
        let [lowest, highest] = [self.end - self.base_pitch, self.start + self.base_pitch];
        (lowest < highest).then_some([lowest, highest])
    }

    /// Position \[m\] of the pair that came into contact `cycles` mesh cycles ago.
    pub fn position(&self, cycles: f64) -> f64 {
        self.start + cycles * self.base_pitch
    }

    /// Mesh phase in \[0, 1) at which a pair is at position s.
    pub fn phase(&self, s: f64) -> f64 {
        ((s - self.start) / self.base_pitch).rem_euclid(1.0)
    }
}

/// The checked geometry of a pair. Arrays are `[pinion, wheel]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Flanks {
    /// Tooth of each gear.
    pub teeth: [Tooth; 2],
    /// Operating pressure angle \[rad\].
    pub pressure_angle: f64,
    /// Helix angle at the base cylinders \[rad\], positive with a right-handed pinion.
    pub base_helix_angle: f64,
    /// Centre distance, negative for a ring \[m\].
    pub centre_distance: f64,
    /// Radii on which the gears roll, negative for a ring \[m\].
    pub operating_pitch_radii: [f64; 2],
    /// Backlash along the line of action, at both flanks together \[m\]: twice the half gap.
    pub backlash: f64,
    /// Distance of each gear's tip from its mate's root \[m\].
    pub clearance: [f64; 2],
    /// Face width \[m\].
    pub face_width: f64,
    /// Diameters at which the gear bodies are clamped \[m\]: their bores; for a ring minus its outer diameter.
    pub bores: [f64; 2],
    /// Cosine and tangent of the helix angle at the base cylinders.
    pub(super) base_helix: [f64; 2],
    path: PathOfContact,
    /// tan α_w.
    tangent: f64,
    reach: [f64; 2],
    /// Tip edges of pinion and wheel on their mates' flanks.
    tips: [TipContact; 2],
    pub(super) bodies: GearBodies,
    /// For helical gears the spur pair of their normal section, whose teeth have the same compliance;
    /// `None` for spur gears.
    pub(super) normal_section: Option<Box<Flanks>>,
    pub(super) face_coupling: Option<Arc<FaceCoupling>>,
    pub(super) pair: GearPair,
}

impl Flanks {
    /// Derives and checks the geometry of a pair.
    ///
    /// # Errors
    ///
    /// [`GearError`]: undercut where the mate would touch, pointed tips, interference, contact ratio below 1, negative
    /// backlash, tips in the mate's root, missing or too large bores, points off the flanks, and invalid lengths or
    /// moduli. For a ring also [`InternalPair::check`].
    pub fn new(pair: &GearPair) -> Result<Self, GearError> {
        check_values(pair)?;
        if pair.form.ring.is_some() {
            InternalPair::of(pair)?.check()?;
        }
        let pressure_angle = pair.operating_pressure_angle()?;
        let centre_distance = pair.centre_distance()?;
        let teeth = [Tooth::new(pair, 0)?, Tooth::new(pair, 1)?];
        let operating_pitch_radii = pair.operating_pitch_radii()?;

        let [pinion, wheel] = &teeth;
        let clearance = [
            centre_distance - pinion.tip_radius - wheel.root_radius,
            centre_distance - wheel.tip_radius - pinion.root_radius,
        ];
        for (gear, clearance) in (1..).zip(clearance) {
            if clearance < 0.0 {
                return Err(GearError::TipInRoot { gear, clearance });
            }
        }

        let tangent = pressure_angle.tan();
        let path = PathOfContact {
            base_pitch: pair.base_pitch(),
            start: wheel.base_radius * (tangent - wheel.tip_roll),
            end: pinion.base_radius * (pinion.tip_roll - tangent),
            pitch_point: 0.0,
        };
        let lowest = [
            tangent + path.start / pinion.base_radius,
            tangent - path.end / wheel.base_radius,
        ];
        for ((gear, tooth), roll) in (1..).zip(&teeth).zip(lowest) {
            // With a negative roll angle contact would lie beyond the end of the line of action.
            if tooth.sense() < 0.0 {
                if roll > tooth.form_roll {
                    return Err(GearError::RingInterference {
                        active_roll: roll,
                        form_roll: tooth.form_roll,
                    });
                }
            } else if roll < tooth.form_roll {
                return Err(match tooth.undercut {
                    Some(Undercut { shift, limit }) => GearError::Undercut {
                        gear,
                        shift,
                        limit,
                        form_diameter: 2.0 * tooth.form_radius,
                        active_diameter: 2.0 * tooth.base_radius * roll.max(0.0).hypot(1.0),
                    },
                    None => GearError::Interference {
                        gear,
                        active_roll: roll,
                        form_roll: tooth.form_roll,
                    },
                });
            }
        }
        let contact_ratio = path.contact_ratio();
        if contact_ratio < 1.0 {
            return Err(GearError::ContactRatio { contact_ratio });
        }

        let backlash = pair.action_backlash()?;
        if backlash < -NO_BACKLASH * pair.module {
            return Err(GearError::NegativeBacklash {
                backlash,
                centre_distance: centre_distance.abs(),
            });
        }
        check_points(pair, &teeth)?;
        let bores = bores(pair, &teeth)?;
        let tips = tips(&teeth, centre_distance, pressure_angle);
        let furthest = (0.5 * (MOST_RATIO - contact_ratio)).clamp(0.0, 0.5) * path.base_pitch;
        let [after, before] = tips.map(|tip| tip.reach(TIP_GAP * pair.module, furthest));
        let reach = [path.start - before, path.end + after];
        let mut flanks = Self {
            teeth,
            pressure_angle,
            base_helix_angle: pair.base_helix_angle(),
            base_helix: [pair.base_helix_angle().cos(), pair.base_helix_angle().tan()],
            centre_distance,
            operating_pitch_radii,
            backlash: backlash.max(0.0),
            clearance,
            face_width: pair.face_width,
            bores,
            path,
            tangent,
            reach,
            tips,
            bodies: GearBodies::default(),
            normal_section: None,
            face_coupling: None,
            pair: pair.clone(),
        };
        if pair.helix_angle != 0.0 {
            flanks.normal_section = Some(Box::new(flanks.in_normal_section()?));
        } else if pair.form.ring.is_none() {
            flanks.face_coupling = Some(Arc::new(FaceCoupling::of(&flanks)));
        }
        Ok(flanks)
    }

    /// The spur pair that has the teeth and the curvature of the normal section. Its path of contact
    /// is that of these flanks with all lengths over cos β_b, as radii of curvature are. With the base radius
    /// `r_b/(cos β_b cos β)` of the virtual teeth its operating pressure angle is `tan α = tan α_w cos β`. Its bodies
    /// have the same ratios of root to bore, and the number of teeth nearest to that of the virtual teeth.
    /// Virtual teeth become pointed at a slightly smaller radius than helical teeth, whose helix angle grows outwards.
    /// Teeth and positions of loads end before that radius.
    fn in_normal_section(&self) -> Result<Self, GearError> {
        let pair = &self.pair;
        let [cos, _] = self.base_helix;
        let mut section = GearPair {
            helix_angle: 0.0,
            ..pair.clone()
        };
        section.form.thinning = pair.form.thinning.map(|part| part * pair.helix_angle.cos());
        let counts = pair.virtual_teeth();
        section.teeth = counts.map(|count| count.abs().round() as u32);
        let last_roll = [0, 1].map(|index| {
            let pointed = Tooth::pointed_roll(&section, index, counts[index]);
            // The teeth of a ring end at the smallest roll angle.
            if counts[index] < 0.0 { pointed / LAST_ROLL } else { pointed * LAST_ROLL }
        });
        let tooth = |index: usize| {
            let this_tooth = &self.teeth[index];
            let radius = 0.5 * pair.module * counts[index];
            let addendum = this_tooth.tip_radius - this_tooth.reference_radius;
            let last = radius * section.pressure_angle.cos() * last_roll[index].hypot(1.0);
            Tooth::cut(&section, index, counts[index], last.min(radius + addendum))
        };
        let teeth = [tooth(0)?, tooth(1)?];
        let tangent = self.pressure_angle.tan() * pair.helix_angle.cos();
        let pressure_angle = tangent.atan();
        let radius = |index: usize| teeth[index].base_radius / pressure_angle.cos();
        let operating_pitch_radii = [radius(0), radius(1)];
        let bore = |index: usize| {
            self.bores[index] * teeth[index].root_radius / self.teeth[index].root_radius
        };
        let centre_distance = operating_pitch_radii.iter().sum();
        let path = PathOfContact {
            base_pitch: self.path.base_pitch / cos,
            start: (self.path.start / cos).max(teeth[1].base_radius * (tangent - last_roll[1])),
            end: (self.path.end / cos).min(teeth[0].base_radius * (last_roll[0] - tangent)),
            pitch_point: self.path.pitch_point / cos,
        };
        let reach = self.reach.map(|end| end / cos);
        Ok(Self {
            pressure_angle,
            base_helix_angle: 0.0,
            base_helix: [1.0, 0.0],
            centre_distance,
            operating_pitch_radii,
            backlash: self.backlash * cos,
            clearance: self.clearance,
            face_width: self.face_width / cos,
            bores: [bore(0), bore(1)],
            path,
            tangent: pressure_angle.tan(),
            reach,
            tips: tips(&teeth, centre_distance, pressure_angle),
            bodies: GearBodies::default(),
            normal_section: None,
            face_coupling: None,
            pair: section,
            teeth,
        })
    }

    /// The path of contact.
    pub fn path(&self) -> PathOfContact {
        self.path
    }

    /// Where loaded pairs can touch on the line of action \[m\]: their tip edges also touch before and after
    /// the path of contact.
    pub fn reach(&self) -> [f64; 2] {
        self.reach
    }

    /// Gap of a pair off the path of contact \[m\], between a tip edge and its mate's flank; 0 on the path.
    pub fn tip_gap(&self, s: f64) -> f64 {
        let [pinion, wheel] = &self.tips;
        let gap = if s > self.path.end {
            pinion.gap(s - self.path.end)
        } else if s < self.path.start {
            wheel.gap(self.path.start - s)
        } else {
            return 0.0;
        };
        // Every edge within the reach is above a flank, so the gap is finite except by rounding at the ends.
        gap.unwrap_or(f64::INFINITY)
    }

    /// Mean number of pairs in contact in one transverse section, ε_α.
    pub fn contact_ratio(&self) -> f64 {
        self.path.contact_ratio()
    }

    /// Phase lead of one end of the face over the other in mesh cycles, ε_β: the mean number of helical pairs
    /// in contact beyond [`Self::contact_ratio`].
    pub fn overlap_ratio(&self) -> f64 {
        self.pair.overlap_ratio()
    }

    /// Roll angles of pinion and wheel at position s, clamped to the path of contact.
    pub fn roll(&self, s: f64) -> [f64; 2] {
        let s = s.clamp(self.path.start, self.path.end);
        let tangent = self.tangent;
        [
            tangent + s / self.teeth[0].base_radius,
            tangent - s / self.teeth[1].base_radius,
        ]
    }

    /// Roll length of a gear at position s \[m\], its base radius times its roll angle.
    pub fn roll_length(&self, gear: usize, s: f64) -> f64 {
        let pitch = self.teeth[gear].base_radius * self.tangent;
        if gear == 0 { pitch + s } else { self.teeth[gear].sense() * (pitch - s) }
    }

    /// The position at which a gear has a roll length \[m\].
    pub fn at_roll_length(&self, gear: usize, length: f64) -> f64 {
        let pitch = self.teeth[gear].base_radius * self.tangent;
        if gear == 0 {
            length - pitch
        } else {
            pitch - self.teeth[gear].sense() * length
        }
    }

    /// Radius of relative curvature of the flanks at position s \[m\]:
    /// `1/R = 1/(r_b1 t₁) + 1/(r_b2 t₂)`.
    pub fn relative_radius(&self, s: f64) -> f64 {
        self.relative_radius_at(self.roll(s))
    }

    /// Radius of relative curvature at the roll angles of both flanks \[m\].
    pub(super) fn relative_radius_at(&self, [one, two]: [f64; 2]) -> f64 {
        let (one, two) = (
            one * self.teeth[0].base_radius,
            two * self.teeth[1].base_radius,
        );
        one * two / (one + two)
    }

    /// Sliding velocity at position s for a pinion speed of 1 rad/s, `s (1 + z₁/z₂)` \[m/s\]:
    /// positive after the pitch point, where the pinion's flank moves towards its own root over the
    /// wheel's.
    pub fn sliding(&self, s: f64) -> f64 {
        let [pinion, wheel] = self.pair.signed_teeth();
        s * (1.0 + pinion / wheel)
    }
}

/// The tip edges of pinion and wheel on their mates' flanks.
pub(super) fn tips(
    teeth: &[Tooth; 2],
    centre_distance: f64,
    pressure_angle: f64,
) -> [TipContact; 2] {
    [[0, 1], [1, 0]].map(|[gear, mate]| TipContact {
        base_radius: teeth[gear].base_radius,
        tip_roll: teeth[gear].tip_roll,
        mate_base_radius: teeth[mate].base_radius,
        mate_form_roll: teeth[mate].form_roll,
        centre_distance,
        pressure_angle,
    })
}
