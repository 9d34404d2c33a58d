//! The mean coefficient of friction of a mesh, from load, speed, oil and roughness.
//!
//! ```text
//! μ = 0.048 (w/(v_Σ ρ))^0.2 η^−0.05 Ra^0.25 X_L
//! v_Σ = 2 v_t sin α_w,   ρ = r_w1 r_w2 sin α_w / a
//! ```
//!
//! from Schlenk (*Untersuchungen zur Freßtragfähigkeit von Großzahnrädern*, TU München 1995) and ISO/TR 14179-2:2001. w
//! = F/b is the line load \[N/mm\]. At the pitch point, v_Σ is the sum of both flanks' velocities across the contact
//! \[m/s\] and ρ the relative radius of curvature \[mm\]. The radius is `ρ/cos β_b` across the lines of contact of
//! helical flanks, which also carry F/b: `F/cos β_b` on `b/cos β_b`. η is the dynamic viscosity \[mPa s\] of the oil at
//! its temperature, Ra the mean roughness of both flanks \[µm\] and X_L the factor of the type of oil. The formula is a
//! fit to loaded gears in an FZG rig. As in ISO/TR 14179-2, line loads below 150 N/mm count as 150 N/mm, and pitch line
//! speeds v_t above 50 m/s as 50 m/s.

use super::{GearError, GearPair};

/// Smallest line load of the fit \[N/m\].
const LEAST_LINE_LOAD: f64 = 150e3;

/// Largest pitch line speed of the fit \[m/s\].
const MOST_SPEED: f64 = 50.0;

/// Inputs of Schlenk's law besides load and speed.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct MeanFriction {
    /// Mean of both flanks' arithmetic roughness Ra \[m\].
    pub roughness: f64,
    /// Dynamic viscosity η of the oil at its temperature \[Pa s\].
    pub viscosity: f64,
    /// X_L \[1\]: 1 mineral oil, 0.8 polyalphaolefin or ester, about 0.6 polyglycol, 1.3 phosphoric ester, 1.5
    /// traction fluid.
    pub oil_factor: f64,
}

impl MeanFriction {
    /// Mean coefficient of friction \[1\] of a pair under a mean mesh force \[N\] of either sign at a
    /// pinion speed \[rad/s\].
    ///
    /// # Errors
    /// As [`GearPair::operating_pressure_angle`]; [`GearError::MeanFriction`] if the coefficient is not
    /// above 0 and below 1.
    pub fn coefficient(&self, pair: &GearPair, force: f64, speed: f64) -> Result<f64, GearError> {
        let sine = pair.operating_pressure_angle()?.sin();
        let [pinion, wheel] = pair.operating_pitch_radii()?;
        let line_load = (force.abs() / pair.face_width).max(LEAST_LINE_LOAD);
        let sum_speed = 2.0 * (speed.abs() * pinion).min(MOST_SPEED) * sine;
        let curvature = pinion * wheel * sine / (pinion + wheel) / pair.base_helix_angle().cos();
        // N/mm over (m/s mm) is N/m over (m/s m) times 1e-6.
        let coefficient = 0.048
            * (1e-6 * line_load / (sum_speed * curvature)).powf(0.2)
            * (1e3 * self.viscosity).powf(-0.05)
            * (1e6 * self.roughness).powf(0.25)
            * self.oil_factor;
        if coefficient > 0.0 && coefficient < 1.0 {
            Ok(coefficient)
        } else {
            Err(GearError::MeanFriction { coefficient })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::ToothForm;

    /// FZG C: 16 and 24 teeth of 4.5 mm at 91.5 mm, 14 mm wide.
    fn pair() -> GearPair {
        GearPair {
            teeth: [16, 24],
            module: 4.5e-3,
            pressure_angle: 20f64.to_radians(),
            helix_angle: 0.0,
            face_width: 14e-3,
            body_length: [14e-3; 2],
            rated_torque: 100.0,
            form: ToothForm {
                profile_shift: [0.1817, 0.1715],
                centre_distance: Some(91.5e-3),
                ..ToothForm::default()
            },
        }
    }

    const OIL: MeanFriction = MeanFriction {
        roughness: 0.5e-6,
        viscosity: 20e-3,
        oil_factor: 1.0,
    };

    #[test]
    fn a_coefficient_by_hand() {
        // r_w = 36.6 and 54.9 mm, cos α_w = 84.57234/91.5, sin α_w = 0.381696; 4000 N on 14 mm are
        // 285.714 N/mm; v_t = 5.49 m/s, v_Σ = 4.19102 m/s; ρ = 8.38204 mm.
        let found = OIL.coefficient(&pair(), 4000.0, 150.0).unwrap();
        let by_hand = 0.048
            * (285.714_f64 / (4.19102 * 8.38204)).powf(0.2)
            * 20f64.powf(-0.05)
            * 0.5f64.powf(0.25);
        assert!((found / by_hand - 1.0).abs() < 1e-5, "{found} {by_hand}");
        assert!((0.03..0.08).contains(&found), "{found}");
    }

    #[test]
    fn outside_the_fit_its_ends_hold_and_nonsense_is_refused() {
        let of = |force, speed| OIL.coefficient(&pair(), force, speed);
        assert_eq!(of(10.0, 150.0).unwrap(), of(-2000.0, 150.0).unwrap());
        assert!(of(2200.0, 150.0).unwrap() > of(2000.0, 150.0).unwrap());
        assert_eq!(of(4000.0, 3000.0).unwrap(), of(4000.0, 1500.0).unwrap());
        assert!(matches!(
            of(4000.0, 1e-9),
            Err(GearError::MeanFriction { coefficient }) if coefficient >= 1.0
        ));
        assert!(matches!(
            of(f64::NAN, 0.0),
            Err(GearError::MeanFriction { .. })
        ));
    }
}
