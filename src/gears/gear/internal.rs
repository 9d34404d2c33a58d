//! Do the teeth of a gear fit into the spaces of a ring around it, and how much backlash is left?
//!
//! The ring's spaces have the shape of the teeth of an external gear with the same number of teeth. The
//! profile shift is signed as in ISO 21771: positive if it makes the ring's teeth thicker. The width
//! of a space at the reference circle is then `m (π/2 − 2 x tan α)`. On the operating pitch circles
//!
//! ```text
//! cos α' = m (z₂ − z₁) cos α / (2 a),     s' = 2 r' (s/(2r) + inv α − inv α')
//! ```
//!
//! for the tooth of the first gear and the space of the second; the backlash is their difference.

use super::{GearError, GearPair, Tooth, involute};
use std::f64::consts::PI;

/// A gear inside a ring, in the transverse section. Arrays are `[gear, ring]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InternalPair {
    /// Numbers of teeth.
    pub teeth: [u32; 2],
    /// Module \[m\].
    pub module: f64,
    /// Pressure angle \[rad\].
    pub pressure_angle: f64,
    /// Profile shift coefficients x in units of `module` \[1\]; for the ring positive towards the axis.
    pub profile_shift: [f64; 2],
    /// Tip radii \[m\]; that of the ring is its inner radius.
    pub tip_radius: [f64; 2],
    /// Reduction of each tooth's thickness along its reference circle \[m\].
    pub thinning: [f64; 2],
    /// Distance of the axes \[m\].
    pub centre_distance: f64,
}

/// Why a gear cannot run inside a ring.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum InternalError {
    /// The ring has too few teeth.
    #[error(
        "a ring of {ring} teeth has no room for a gear of {gear} teeth; it needs more teeth than the gear"
    )]
    TooFewTeeth {
        /// Teeth of the gear.
        gear: u32,
        /// Teeth of the ring.
        ring: u32,
    },
    /// The base circles touch or cross.
    #[error(
        "the axes are {distance:.6e} m apart, but the base circles need more than {least:.6e} m"
    )]
    TooNear {
        /// Distance of the axes \[m\].
        distance: f64,
        /// Difference of the base radii \[m\].
        least: f64,
    },
    /// The tooth of the gear is thicker than the space of the ring.
    #[error(
        "the teeth of the gear are {overlap:.3e} m thicker than the spaces of the ring at the operating pitch \
         circles; thin the teeth, change a profile shift, or move the axes closer together"
    )]
    Jammed {
        /// Size of the overlap \[m\].
        overlap: f64,
    },
    /// Fewer than one pair of teeth in contact.
    #[error(
        "the contact ratio is {ratio:.3}, but must be at least 1; change the profile shifts or the distance of the axes"
    )]
    ContactRatio {
        /// Contact ratio.
        ratio: f64,
    },
    /// The ring's tips reach beyond the start of the gear's involute.
    #[error(
        "the tips of the ring (radius {tip:.6e} m) touch the gear inside its base circle: the radius must be at \
         least {least:.6e} m; give the ring a negative profile shift or more teeth"
    )]
    Involute {
        /// Tip radius of the ring \[m\].
        tip: f64,
        /// Smallest possible tip radius \[m\].
        least: f64,
    },
    /// Tips of both gears meet outside the path of contact.
    #[error(
        "the tips of the teeth meet outside the contact: they overlap by {overlap:.3e} rad of the ring's rotation; \
         the ring needs more teeth than the gear (commonly at least 8), or a larger difference of the profile shifts"
    )]
    Tips {
        /// Size of the overlap \[rad\].
        overlap: f64,
    },
}

impl InternalPair {
    /// The internal pair of a drawing whose wheel is a ring.
    ///
    /// # Errors
    /// As [`GearPair::tight_centre_distance`], if the drawing does not state the distance or the tips.
    pub fn of(pair: &GearPair) -> Result<Self, GearError> {
        let tips = [
            Tooth::tip_radius_of(pair, 0)?,
            Tooth::tip_radius_of(pair, 1)?,
        ];
        let shift = pair.form.profile_shift;
        Ok(Self {
            teeth: pair.teeth,
            module: pair.transverse_module(),
            pressure_angle: pair.transverse_pressure_angle(),
            profile_shift: shift.map(|shift| shift * pair.helix_angle.cos()),
            tip_radius: tips.map(f64::abs),
            thinning: pair.form.thinning,
            centre_distance: match pair.form.centre_distance {
                Some(distance) => distance,
                None => pair.centre_distance()?.abs(),
            },
        })
    }

    /// Reference radii \[m\].
    fn reference_radii(&self) -> [f64; 2] {
        self.teeth.map(|z| 0.5 * self.module * f64::from(z))
    }

    /// Base radii \[m\].
    fn base_radii(&self) -> [f64; 2] {
        self.reference_radii()
            .map(|r| r * self.pressure_angle.cos())
    }

    /// Operating pressure angle α' \[rad\].
    ///
    /// # Errors
    /// [`InternalError::TooFewTeeth`], [`InternalError::TooNear`].
    pub fn operating_pressure_angle(&self) -> Result<f64, InternalError> {
        let [gear, ring] = self.teeth;
        if ring <= gear {
            return Err(InternalError::TooFewTeeth { gear, ring });
        }
        let [gear_base, outer] = self.base_radii();
        let (distance, least) = (self.centre_distance, outer - gear_base);
        if distance <= least {
            return Err(InternalError::TooNear { distance, least });
        }
        Ok((least / distance).acos())
    }

    /// Half of the backlash along the line of action \[m\].
    ///
    /// # Errors
    /// As [`Self::operating_pressure_angle`].
    pub fn half_gap(&self) -> Result<f64, InternalError> {
        let working = self.operating_pressure_angle()?;
        let bent = involute(self.pressure_angle) - involute(working);
        let [gear_radius, ring] = self.reference_radii();
        let shift = |x: f64| self.module * (0.5 * PI + 2.0 * x * self.pressure_angle.tan());
        let [x1, x2] = self.profile_shift;
        let tooth = (shift(x1) - self.thinning[0]) / (2.0 * gear_radius);
        let space = (shift(-x2) + self.thinning[1]) / (2.0 * ring);
        let [r1, r2] = self.base_radii().map(|base| base / working.cos());
        let backlash = 2.0 * (r2 * (space + bent) - r1 * (tooth + bent));
        Ok(0.5 * backlash * working.cos())
    }

    /// Transverse contact ratio.
    ///
    /// # Errors
    /// As [`Self::operating_pressure_angle`].
    pub fn contact_ratio(&self) -> Result<f64, InternalError> {
        let working = self.operating_pressure_angle()?;
        let [gear, ring] = [0, 1].map(|i| {
            let (tip, base) = (self.tip_radius[i], self.base_radii()[i]);
            (tip * tip - base * base).max(0.0).sqrt()
        });
        let path = gear - ring + self.centre_distance * working.sin();
        Ok(path / (PI * self.module * self.pressure_angle.cos()))
    }

    /// Mesh phase in \[0, ½) at which a tooth of the inner gear, or the middle of a space, is on the line of centres:
    /// as [`GearPair::symmetry`](super::GearPair::symmetry).
    ///
    /// # Errors
    /// As [`Self::operating_pressure_angle`].
    pub fn symmetry(&self) -> Result<f64, InternalError> {
        Ok(self.tooth_phase()?.rem_euclid(0.5))
    }

    /// Mesh phase in \[0, 1) at which a tooth of the inner gear is on the line of centres. The inner gear drives,
    /// so the path of contact starts at the ring's tip.
    ///
    /// # Errors
    /// As [`Self::operating_pressure_angle`].
    pub fn tooth_phase(&self) -> Result<f64, InternalError> {
        let working = self.operating_pressure_angle()?;
        let [base, ring_base] = self.base_radii();
        let tip = self.tip_radius[1];
        let ring = (tip * tip - ring_base * ring_base).max(0.0).sqrt();
        let approach = base * working.tan() - (ring - self.centre_distance * working.sin());
        let gear_radius = self.reference_radii()[0];
        let shift = 0.5 * PI + 2.0 * self.profile_shift[0] * self.pressure_angle.tan();
        let half_angle = (self.module * shift - self.thinning[0]) / (2.0 * gear_radius)
            + involute(self.pressure_angle)
            - involute(working);
        let pitch = PI * self.module * self.pressure_angle.cos();
        // The middle is half a tooth behind the flank: the same length on the base circle and on the line of action.
        Ok(((approach + base * half_angle) / pitch).rem_euclid(1.0))
    }

    /// Checks that the gear runs inside the ring: without overlap of teeth, without interference of tips, and with at
    /// least one pair always in contact.
    ///
    /// # Errors
    /// [`InternalError`].
    pub fn check(&self) -> Result<(), InternalError> {
        let working = self.operating_pressure_angle()?;
        let gap = self.half_gap()?;
        // Drawings whose lengths have twelve digits round the gap by this much.
        if gap < -1e-9 * self.module {
            let overlap = -2.0 * gap / working.cos();
            return Err(InternalError::Jammed { overlap });
        }
        let [gear_tip, ring_tip] = self.tip_radius;
        let [gear_base, ring_base] = self.base_radii();
        // The gear's involute starts at the contact of the line of action with its base circle.
        let start = self.centre_distance * working.sin();
        let least = (ring_base * ring_base + start * start).sqrt();
        if ring_tip < least {
            return Err(InternalError::Involute {
                tip: ring_tip,
                least,
            });
        }
        let a = self.centre_distance;
        let ratio = f64::from(self.teeth[0]) / f64::from(self.teeth[1]);
        let at_tip = |base: f64, tip: f64| involute((base / tip).acos());
        // Intersection of the tip circles, as angles about both axes.
        let apart = (ring_tip * ring_tip - gear_tip * gear_tip - a * a) / (2.0 * a * gear_tip);
        let cosine = (a * a + ring_tip * ring_tip - gear_tip * gear_tip) / (2.0 * a * ring_tip);
        if apart.abs() < 1.0 && cosine.abs() < 1.0 {
            let gear_angle = apart.acos() + at_tip(gear_base, gear_tip) - involute(working);
            let ring = ratio * gear_angle + involute(working) - at_tip(ring_base, ring_tip);
            let overlap = cosine.acos() - ring;
            if overlap > 0.0 {
                return Err(InternalError::Tips { overlap });
            }
        }
        let ratio = self.contact_ratio()?;
        // Written so that a NaN is rejected.
        if ratio >= 1.0 { Ok(()) } else { Err(InternalError::ContactRatio { ratio }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tips are one module plus the profile shift beyond the reference circle.
    fn pair(teeth: [u32; 2], module: f64, shift: [f64; 2], distance: f64) -> InternalPair {
        let beyond = |gear: usize, side: f64| {
            module * (0.5 * f64::from(teeth[gear]) + side * (1.0 + shift[gear]))
        };
        InternalPair {
            tip_radius: [beyond(0, 1.0), beyond(1, -1.0)],
            teeth,
            module,
            pressure_angle: 20f64.to_radians(),
            profile_shift: shift,
            thinning: [0.0; 2],
            centre_distance: distance,
        }
    }

    #[test]
    fn backlash_is_what_thinning_and_distance_leave() {
        // At the reference distance the profiles fit without backlash.
        let mut own = pair([37, 91], 5e-3, [0.0; 2], 0.135);
        assert!(own.half_gap().unwrap().abs() < 1e-15);
        own.thinning = [40e-6, 60e-6];
        let expected = 0.5 * 100e-6 * 20f64.to_radians().cos();
        assert!((own.half_gap().unwrap() - expected).abs() < 1e-12);
        // Compare with the formula of tight pairs: inv α' = inv α + 2 tan α (x₁ + x₂)/(z₁ − z₂) with ISO's signs.
        let (x1, x2) = (0.5039, 0.1171);
        let alpha = 20f64.to_radians();
        let tight = involute(alpha) + 2.0 * alpha.tan() * (x1 + x2) / (36.0 - 93.0);
        let working = super::super::inverse_involute(tight);
        let distance = 0.021 * 57.0 / 2.0 * alpha.cos() / working.cos();
        let own = pair([36, 93], 21e-3, [x1, x2], distance);
        assert!(own.half_gap().unwrap().abs() < 1e-12);
        // Axes closer together increase the backlash.
        let near = pair([36, 93], 21e-3, [x1, x2], distance - 1e-4);
        let grown = near.half_gap().unwrap() / (1e-4 * working.sin());
        assert!((grown - 1.0).abs() < 0.01, "{grown}");
    }

    /// At the reference distance a tooth of 20° is half a pitch thick. The phase of its middle follows from half its
    /// thickness and the length of the path before the pitch point.
    #[test]
    fn the_tooth_stands_on_the_line_of_centres() {
        let own = pair([37, 91], 5e-3, [0.0; 2], 0.135);
        // The phase is the path length from its start (the ring's tip) to the pitch point, plus a quarter of
        // the base pitch.
        let (base, tip) = (0.5 * 0.455 * 20f64.to_radians().cos(), 0.5 * 0.455 - 5e-3);
        let approach = base * 20f64.to_radians().tan() - f64::sqrt(tip * tip - base * base);
        let pitch = PI * 5e-3 * 20f64.to_radians().cos();
        let expected = (approach / pitch + 0.25).rem_euclid(0.5);
        assert!((own.symmetry().unwrap() - expected).abs() < 1e-12);
    }

    /// Published contact ratios of ring meshes: Peng Yue 2025 (37/91 teeth without profile shift), and ISO 6336 reports
    /// of the NREL 5 MW gearbox, whose planets keep the clearance of the rack at the sun.
    #[test]
    fn contact_ratios_are_the_published_ones() {
        let own = pair([37, 91], 5e-3, [0.0; 2], 0.135);
        assert!((own.contact_ratio().unwrap() - 1.941805).abs() < 5e-6);
        let first = pair([17, 56], 45e-3, [0.8021, -0.5013], 0.863);
        let second = pair([36, 93], 21e-3, [0.5039, 0.1171], 0.584);
        for (own, sun, shift, printed) in
            [(first, 19.0, 0.617, 1.278), (second, 18.0, 0.389, 1.618)]
        {
            let apart = own.centre_distance / own.module - 0.5 * (sun + f64::from(own.teeth[0]));
            let mut own = own;
            own.tip_radius[0] += own.module * (apart - (shift + own.profile_shift[0]));
            let found = own.contact_ratio().unwrap();
            assert!((found - printed).abs() < 1e-3, "{found} {printed}");
        }
    }

    #[test]
    fn what_does_not_fit_is_told() {
        let good = pair([37, 91], 5e-3, [0.0; 2], 0.135);
        assert_eq!(good.check(), Ok(()));
        let small = pair([37, 37], 5e-3, [0.0; 2], 0.135);
        assert!(matches!(
            small.check(),
            Err(InternalError::TooFewTeeth { .. })
        ));
        let near = pair([37, 91], 5e-3, [0.0; 2], 0.12);
        assert!(matches!(near.check(), Err(InternalError::TooNear { .. })));
        let jammed = pair([37, 91], 5e-3, [0.2, 0.0], 0.135);
        assert!(matches!(jammed.check(), Err(InternalError::Jammed { .. })));
        // 60 and 64 teeth of 20°: the tips interfere, as every handbook of internal gears warns.
        let tips = pair([60, 64], 5e-3, [0.0; 2], 0.01);
        assert!(
            matches!(tips.check(), Err(InternalError::Tips { .. })),
            "{:?}",
            tips.check()
        );
        // The ring of 30 teeth has tips inside the base circle of its involute.
        let involute = pair([14, 30], 5e-3, [0.0; 2], 0.04);
        assert!(matches!(
            involute.check(),
            Err(InternalError::Involute { .. })
        ));
    }
}
