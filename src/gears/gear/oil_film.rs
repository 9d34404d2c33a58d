//! The film of oil between the flanks of a pair, as cylinders at the pitch point.
//!
//! ```text
//! R = r_w1 r_w2 sin α_w/(a cos β_b),   L = b/cos β_b
//! ```
//!
//! are the relative radius of curvature across the line of contact and its length (spur gears: β_b = 0). On helical
//! flanks at the distance x along the line of action the film has the thickness `x cos β_b`. The component of its force
//! along this line is `F = C √cos β_b x^(−3/2) (−x')`. Only one pair of teeth has a film.

use super::{GearError, GearPair};
use crate::model::Film;

/// Oil and extent of a film.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct OilFilm {
    /// Dynamic viscosity η of the oil at its temperature \[Pa s\].
    pub viscosity: f64,
    /// Thickness at which the film begins to act, and thickness at which the flanks touch \[m\].
    pub thickness: [f64; 2],
    /// Number of layers.
    pub layers: usize,
}

impl OilFilm {
    /// The film between the flanks of a pair, in distances along the transverse line of action.
    ///
    /// # Errors
    /// As [`GearPair::operating_pressure_angle`].
    pub fn between(&self, pair: &GearPair) -> Result<Film, GearError> {
        let sine = pair.operating_pressure_angle()?.sin();
        let [pinion, wheel] = pair.operating_pitch_radii()?;
        let cos = pair.base_helix_angle().cos();
        let radius = (pinion * wheel * sine / (pinion + wheel)).abs() / cos;
        let squeezed = Film::squeeze_coefficient(self.viscosity, radius, pair.face_width / cos);
        Ok(Film {
            coefficient: squeezed * cos.sqrt(),
            thickness: self.thickness.map(|h| h / cos),
            layers: self.layers,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::{ToothForm, fixtures};

    const OIL: OilFilm = OilFilm {
        viscosity: 20e-3,
        thickness: [50e-6, 1e-6],
        layers: 5,
    };

    /// Compares with a calculation by hand from the radii of curvature at the pitch point.
    #[test]
    fn spur_flanks_are_cylinders_at_the_pitch_point() {
        let pair = fixtures::pair([20, 31], ToothForm::default());
        let angle = pair.operating_pressure_angle().unwrap();
        let radii = pair
            .operating_pitch_radii()
            .unwrap()
            .map(|r| r * angle.sin());
        let radius = 1.0 / (1.0 / radii[0] + 1.0 / radii[1]);
        let film = OIL.between(&pair).unwrap();
        let by_hand = 13.32865 * 20e-3 * pair.face_width * radius.powf(1.5);
        assert!((film.coefficient / by_hand - 1.0).abs() < 1e-6);
        assert_eq!(film.thickness, OIL.thickness);
    }

    /// The power of the film across the flanks equals that along the line of action.
    #[test]
    fn helical_films_have_the_power_of_their_normal_section() {
        let pair = GearPair {
            helix_angle: 0.4,
            ..fixtures::pair([20, 31], ToothForm::default())
        };
        let cos = pair.base_helix_angle().cos();
        let film = OIL.between(&pair).unwrap();
        let angle = pair.operating_pressure_angle().unwrap();
        let radii = pair
            .operating_pitch_radii()
            .unwrap()
            .map(|r| r * angle.sin());
        let radius = radii[0] * radii[1] / (radii[0] + radii[1]) / cos;
        let normal = Film {
            coefficient: Film::squeeze_coefficient(OIL.viscosity, radius, pair.face_width / cos),
            ..film
        };
        // A distance x along the line of action is a thickness x cos β_b.
        let [distance, speed] = [8e-6, 3e-3];
        let power = film.damping(distance) * speed * speed;
        let across = normal.damping(distance * cos) * (speed * cos).powi(2);
        assert!((power / across - 1.0).abs() < 1e-12);
        assert!((film.thickness[1] * cos / 1e-6 - 1.0).abs() < 1e-12);
    }
}
