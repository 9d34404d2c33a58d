//! How much more does a tooth bend if its root has a crack?
//!
//! The crack starts at the critical section of ISO 6336-3, where the tangent of the fillet makes 30° with the centre
//! line of the tooth. The crack lies in this section, of chord h, over the whole face width b. A force F along the
//! line of action has the angle α to the section and crosses the centre line above the section. It bends the section
//! with the moment `F ℓ`, `ℓ = r_b − y cos α` (y: radius of the section). A crack of depth a = s h adds the rotation
//! C F ℓ and the deflection C F ℓ²,
//!
//! ```text
//! C = 72π/(E' b h²) ∫₀ˢ x Y²(x) dx,    E' = E/(1 − ν²) in plane strain,
//! Y = 1.122 − 1.40 x + 7.33 x² − 13.08 x³ + 14.0 x⁴,
//! ```
//!
//! from the energy release rate K²/E'. Y is the factor of an edge crack in pure bending (Brown & Srawley 1966, ASTM STP
//! 410, within 0.2 % up to 0.6). Shear and compression of the section do not open the crack and are left out. A force
//! on the other flank closes the crack.

use super::tooth::Tooth;
use super::{GearError, GearPair};
use serde::Serialize;
use std::f64::consts::{FRAC_PI_6, PI};

/// Deepest crack, as a part of the section: the limit of Y.
const DEEPEST: f64 = 0.6;

/// Coefficients of Y.
const FACTOR: [f64; 5] = [1.122, -1.40, 7.33, -13.08, 14.0];

/// Number of bisections of the angle of the fillet's normal.
const HALVINGS: usize = 60;

/// A tooth with a crack at its root, through the whole face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RootCrack {
    /// Rotation of the tooth per bending moment C \[rad/(N m)\].
    pub compliance: f64,
    /// Base radius r_b \[m\].
    pub base_radius: f64,
    /// Radius y of the cracked section, on the centre line of the tooth \[m\].
    pub section: f64,
    /// Angle α when the pair first touches \[rad\], and its change per mesh cycle.
    pub angle: [f64; 2],
}

impl RootCrack {
    /// A crack of some depth \[m\] in a tooth of gear `index` (0 = pinion).
    ///
    /// # Errors
    /// Those of [`Tooth::new`] and [`GearPair::approach`]; [`GearError::CrackInRing`]; [`GearError::CrackDepth`].
    pub fn new(pair: &GearPair, index: usize, depth: f64) -> Result<Self, GearError> {
        if index == 1 && pair.form.ring.is_some() {
            return Err(GearError::CrackInRing);
        }
        let tooth = Tooth::new(pair, index)?;
        let [half_chord, section] = critical_section(&tooth);
        let chord = 2.0 * half_chord;
        if depth > DEEPEST * chord {
            return Err(GearError::CrackDepth {
                depth,
                limit: DEEPEST * chord,
            });
        }
        let modulus = (pair.form.material[index].in_plane(pair.form.plane)).young_modulus;
        let radius = tooth.base_radius;
        let sense = [1.0, -1.0][index];
        let at_pitch = radius * pair.operating_pressure_angle()?.tan();
        let first_roll = (at_pitch - sense * pair.approach()?) / radius;
        Ok(Self {
            compliance: bending(depth / chord) / (modulus * pair.face_width * chord * chord),
            base_radius: radius,
            section,
            angle: [
                tooth.force_angle(first_roll),
                sense * pair.base_pitch() / radius,
            ],
        })
    }

    /// Deflection along the line of action per force along this line \[m/N\], at a time after the pair's first touch at
    /// mid-face \[mesh cycles\].
    pub fn at(&self, since: f64) -> f64 {
        let lever = self.base_radius - self.section * (self.angle[0] + self.angle[1] * since).cos();
        self.compliance * lever * lever
    }
}

/// Half the chord of the critical section and its radius \[m\].
fn critical_section(tooth: &Tooth) -> [f64; 2] {
    let [mut upper, mut lower] = tooth.fillet_range();
    for _ in 0..HALVINGS {
        let middle = 0.5 * (upper + lower);
        let point = tooth.fillet(middle);
        if point.dx.abs().atan2(point.dy.abs()) < FRAC_PI_6 {
            upper = middle;
        } else {
            lower = middle;
        }
    }
    let point = tooth.fillet(lower);
    [point.x, point.y]
}

/// `72π ∫₀ˢ x Y² dx`.
fn bending(s: f64) -> f64 {
    let mut integral = 0.0;
    for (i, a) in FACTOR.iter().enumerate() {
        for (j, b) in FACTOR.iter().enumerate() {
            let power = (i + j + 2) as i32;
            integral += a * b * s.powi(power) / f64::from(power);
        }
    }
    72.0 * PI * integral
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::{ToothForm, fixtures};

    fn pair() -> GearPair {
        fixtures::pair([20, 30], ToothForm::default())
    }

    /// The polynomial of Chondros, Dimarogonas & Yao (1998, J. Sound Vib. 215, 17), from the same Y: 6π h/(E I) Φ.
    #[test]
    fn a_crack_bends_as_the_published_polynomial() {
        for s in [0.05, 0.2, 0.35, 0.5, 0.6] {
            let terms = [
                0.6272, -1.04533, 4.5948, -9.973, 20.2948, -33.0351, 47.1063, -40.7556, 19.6,
            ];
            let phi = terms.iter().rev().fold(0.0, |sum, term| sum * s + term) * s * s;
            let found = bending(s) / (72.0 * PI * phi);
            assert!((found - 1.0).abs() < 0.006, "{s}: {found}");
        }
    }

    /// Compares with the moments of the components of the force about the middle of the section. Equal gears are
    /// symmetric about the pitch point.
    #[test]
    fn the_lever_is_that_of_the_force_about_the_section() {
        let pair = pair();
        for (gear, sense) in [(0, 1.0), (1, -1.0)] {
            let crack = RootCrack::new(&pair, gear, 1e-3).unwrap();
            let tooth = Tooth::new(&pair, gear).unwrap();
            for since in [0.0, 0.7, 1.5] {
                let [pitch, path] = [
                    pair.operating_pressure_angle().unwrap().tan(),
                    pair.approach().unwrap(),
                ];
                let along = since * pair.base_pitch() - path;
                let roll = pitch + sense * along / tooth.base_radius;
                let (point, angle) = (tooth.flank(roll), tooth.force_angle(roll));
                let moment = (point.y - crack.section) * angle.cos() - point.x * angle.sin();
                let found = crack.at(since) / crack.compliance;
                assert!(
                    (found / moment.powi(2) - 1.0).abs() < 1e-12,
                    "{gear} {since}"
                );
            }
        }
    }

    /// The tangent at the section makes 30° with the centre line, and the tooth is thinner above.
    #[test]
    fn the_section_is_at_the_tangent_of_30_degrees() {
        let tooth = Tooth::new(&pair(), 0).unwrap();
        let [half, radius] = critical_section(&tooth);
        assert!(radius > tooth.root_radius && radius < tooth.form_radius);
        let slope = |step: f64| {
            let [upper, lower] = tooth.fillet_range();
            let at = |share: f64| tooth.fillet(upper + share * (lower - upper));
            let nearest = (0..=100_000)
                .map(|i| at(f64::from(i) * step))
                .min_by(|a, b| (a.y - radius).abs().total_cmp(&(b.y - radius).abs()));
            nearest.map(|point| ((point.x - half).abs(), point.dx.abs() / point.dy.abs()))
        };
        let (apart, slope) = slope(1e-5).unwrap();
        assert!(
            apart < 1e-7 && (slope - FRAC_PI_6.tan()).abs() < 1e-3,
            "{apart} {slope}"
        );
    }

    #[test]
    fn a_crack_through_the_tooth_is_refused() {
        let deep = RootCrack::new(&pair(), 0, 1.0).unwrap_err();
        assert!(matches!(deep, GearError::CrackDepth { depth: 1.0, limit } if limit > 0.0));
    }
}
