//! The gear pair as drawn.

use super::{GearError, ToothForm, inverse_involute, involute};
use std::f64::consts::PI;

/// A backlash below this part of a module, positive or negative, is round-off of a pair
/// without backlash.
pub(super) const NO_BACKLASH: f64 = 1e-9;

/// An involute pair on parallel axes, spur or helical, with one normal module, one normal pressure angle
/// and opposite helix angles. Two gears do not mesh without these, so other drawings cannot
/// be expressed. Arrays are `[pinion, wheel]`.
///
/// The wheel may be a ring ([`ToothForm::ring`]), with helices of the same hand as the pinion's. Its number of teeth is
/// negative in all formulas (ISO 21771), and so are its radii and the centre distance derived from it. The distance
/// and the diameters of the drawing are positive.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct GearPair {
    /// Number of teeth.
    pub teeth: [u32; 2],
    /// Normal module m_n \[m\].
    pub module: f64,
    /// Normal pressure angle α_n \[rad\].
    pub pressure_angle: f64,
    /// Helix angle β at the reference cylinder \[rad\], between −π/2 and π/2: positive for a
    /// right-handed pinion and a left-handed wheel, 0 for spur gears.
    pub helix_angle: f64,
    /// Width of the common face, on which flanks touch \[m\].
    pub face_width: f64,
    /// Axial length of the gear bodies \[m\]. Like the torque it does not affect the flanks.
    pub body_length: [f64; 2],
    /// Rated torque on the pinion \[N m\]: load = 1.
    pub rated_torque: f64,
    /// Shape and material of the teeth.
    pub form: ToothForm,
}

impl GearPair {
    /// Reference radii `r = m_t z / 2` \[m\], negative for a ring.
    pub fn pitch_radii(&self) -> [f64; 2] {
        let module = self.transverse_module();
        self.signed_teeth().map(|z| 0.5 * module * z)
    }

    /// Numbers of teeth, negative for a ring.
    pub(super) fn signed_teeth(&self) -> [f64; 2] {
        let [pinion, wheel] = self.teeth.map(f64::from);
        [pinion, self.wheel_sign() * wheel]
    }

    /// -1 for a ring, 1 for an external wheel.
    pub(super) fn wheel_sign(&self) -> f64 {
        if self.form.ring.is_some() { -1.0 } else { 1.0 }
    }

    /// The centre distance of the drawing, negative for a ring \[m\]; `None` if the drawing does not state it.
    fn given_centre_distance(&self) -> Option<f64> {
        let given = self.form.centre_distance;
        given.map(|distance| self.wheel_sign() * distance)
    }

    /// Base radii `r_b = r cos α_t` \[m\].
    pub fn base_radii(&self) -> [f64; 2] {
        let cos = self.transverse_pressure_angle().cos();
        self.pitch_radii().map(|r| r * cos)
    }

    /// Reference centre distance `m_t (z₁ + z₂) / 2` \[m\].
    pub fn reference_centre_distance(&self) -> f64 {
        self.pitch_radii().iter().sum()
    }

    /// Operating pressure angle α_w in the transverse section \[rad\]: `cos α_w = (r_b1 + r_b2) / a`
    /// for a given centre distance a, else `inv α_w = inv α_t + 2 tan α_n (x₁ + x₂) / (z₁ + z₂)`.
    /// Exactly the transverse pressure angle at the reference centre distance.
    ///
    /// # Errors
    ///
    /// [`GearError::BaseCirclesOverlap`], [`GearError::ShiftSum`].
    pub fn operating_pressure_angle(&self) -> Result<f64, GearError> {
        let Some(centre_distance) = self.given_centre_distance() else {
            return self.tight_pressure_angle();
        };
        if centre_distance == self.reference_centre_distance() {
            return Ok(self.transverse_pressure_angle());
        }
        let base_radii: f64 = self.base_radii().iter().sum();
        let (distance, least) = (centre_distance.abs(), base_radii.abs());
        if distance > least {
            Ok((base_radii / centre_distance).acos())
        } else {
            Err(GearError::BaseCirclesOverlap {
                centre_distance: distance,
                base_radii: least,
            })
        }
    }

    /// Pressure angle \[rad\] at which teeth of the given profile shifts without thinning mesh
    /// without backlash (ISO 21771, 5.3).
    fn tight_pressure_angle(&self) -> Result<f64, GearError> {
        let sum: f64 = self.form.profile_shift.iter().sum();
        let angle = self.transverse_pressure_angle();
        if sum == 0.0 {
            return Ok(angle);
        }
        let teeth: f64 = self.signed_teeth().iter().sum();
        let rise = 2.0 * self.pressure_angle.tan() / teeth;
        let value = involute(angle) + rise * sum;
        if value > 0.0 {
            Ok(inverse_involute(value))
        } else {
            let limit = -involute(angle) / rise;
            Err(GearError::ShiftSum { sum, limit })
        }
    }

    /// Centre distance without backlash for the profile shifts \[m\].
    ///
    /// # Errors
    ///
    /// [`GearError::ShiftSum`].
    pub fn tight_centre_distance(&self) -> Result<f64, GearError> {
        let ratio = self.transverse_pressure_angle().cos() / self.tight_pressure_angle()?.cos();
        Ok(self.reference_centre_distance() * ratio)
    }

    /// Centre distance at which the pair runs \[m\].
    ///
    /// # Errors
    ///
    /// As [`Self::operating_pressure_angle`].
    pub fn centre_distance(&self) -> Result<f64, GearError> {
        self.operating_pressure_angle()?;
        match self.given_centre_distance() {
            Some(given) => Ok(given),
            None => self.tight_centre_distance(),
        }
    }

    /// Operating pitch radii `r_w = r_b / cos α_w` \[m\], on which the gears roll.
    ///
    /// # Errors
    ///
    /// As [`Self::operating_pressure_angle`].
    pub fn operating_pitch_radii(&self) -> Result<[f64; 2], GearError> {
        let angle = self.operating_pressure_angle()?;
        if angle == self.transverse_pressure_angle() {
            return Ok(self.pitch_radii());
        }
        Ok(self.base_radii().map(|base| base / angle.cos()))
    }

    /// Normal backlash `j_bn = j_bt cos β_b` \[m\]: distance of the flanks along their normal, at
    /// both flanks together.
    ///
    /// # Errors
    ///
    /// As [`Self::operating_pressure_angle`].
    pub fn normal_backlash(&self) -> Result<f64, GearError> {
        Ok(self.action_backlash()? * self.base_helix_angle().cos())
    }

    /// Backlash along the line of action in the transverse section `j_bt = j_t cos α_w` \[m\], at both
    /// flanks together. `j_t` is the circumferential backlash on the operating pitch circles, their
    /// pitch less the thickness of both teeth; negative if teeth overlap.
    ///
    /// # Errors
    ///
    /// As [`Self::operating_pressure_angle`].
    pub fn action_backlash(&self) -> Result<f64, GearError> {
        let angle = self.operating_pressure_angle()?;
        let radii = self.operating_pitch_radii()?;
        let pitch = 2.0 * PI * radii[0] / f64::from(self.teeth[0]);
        let [pinion, wheel] = [self.operating_thickness(0)?, self.operating_thickness(1)?];
        Ok((pitch - pinion - wheel) * angle.cos())
    }

    /// Half gap \[m\] of the drawing, half of the backlash along the line of action. `None` if
    /// thinning and centre distance leave only round-off: such a drawing is nominal.
    ///
    /// # Errors
    ///
    /// As [`Self::operating_pressure_angle`].
    pub fn drawn_half_gap(&self) -> Result<Option<f64>, GearError> {
        let backlash = self.action_backlash()?;
        Ok((backlash > NO_BACKLASH * self.module).then_some(0.5 * backlash))
    }

    /// This pair with the thinning of both gears changed by the same amount, so that the drawing has a half
    /// gap \[m\].
    ///
    /// # Errors
    ///
    /// As [`Self::operating_pressure_angle`].
    pub fn with_half_gap(&self, half_gap: f64) -> Result<Self, GearError> {
        let thinned = |by: f64| {
            let mut pair = self.clone();
            pair.form
                .thinning
                .iter_mut()
                .for_each(|thinning| *thinning += by);
            pair
        };
        // The backlash is linear in the thinning.
        let step = 1e-2 * self.module;
        let drawn = self.action_backlash()?;
        let slope = (thinned(step).action_backlash()? - drawn) / step;
        Ok(thinned((2.0 * half_gap - drawn) / slope))
    }

    /// The pair with the bores that the drawing does not state set to the diameters of its shafts \[m\].
    pub fn on_shafts(&self, diameters: [f64; 2]) -> Self {
        let mut pair = self.clone();
        for (bore, diameter) in pair.form.bore.iter_mut().zip(diameters) {
            bore.get_or_insert(diameter);
        }
        pair
    }

    /// Mesh force at rated torque along the line of action in the transverse section, `T / r_b1` \[N\].
    pub fn rated_force(&self) -> f64 {
        self.rated_torque / self.base_radii()[0]
    }
}
