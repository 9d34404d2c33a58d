//! Which force does an oil film exert between approaching flanks, and which layers approximate its law?
//!
//! A full film between two cylinders in line contact is squeezed out with the force
//!
//! ```text
//! F = C h^(−3/2) (−h'),     C = 3√2 π η L R^(3/2),     1/R = 1/ρ₁ + 1/ρ₂
//! ```
//!
//! at its thickness h: an iso-viscous oil of viscosity η, length of contact L, radii ρ, no side leakage, no
//! entraining motion. The film is full on both sides of the line of contact; models with half a film
//! (Rahnejat & Gohar 1985) have half the force. A film between receding flanks cavitates, and does not pull.
//! The flanks touch at the smallest thickness of the film. Layers of constant damping approximate the law.
//! The damping of a layer is the mean of `C h^(−3/2)` over its thickness. The loss of speed in a layer,
//! `∫ c dh / m`, is therefore exact if no other force acts. Each layer is a contact without a spring, which
//! acts from its gap to the gap of the next layer. Closed flanks have no film.
//!
//! The force is the integral of Reynolds' equation over the parabola `h + x²/2R`.

use super::error::{ModelError, check_in_range};
use serde::Serialize;
use std::f64::consts::{PI, SQRT_2};

/// Largest number of layers of a film.
const MOST_LAYERS: usize = 20;

/// A film of oil between the flanks of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Film {
    /// C \[N s √m\]: the damping is `C h^(−3/2)`.
    pub coefficient: f64,
    /// Thickness at which the film begins to act, and thickness at which the flanks touch \[m\].
    pub thickness: [f64; 2],
    /// Number of its layers.
    pub layers: usize,
}

/// A layer of a film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmLayer {
    /// Distance of the flanks at its start and at its end \[m\]. The next layer starts at the end.
    pub distance: [f64; 2],
    /// Damping coefficient \[N s/m\].
    pub damping: f64,
}

impl Film {
    /// C \[N s √m\] of an oil with a viscosity \[Pa s\] between cylinders with an equivalent radius R and a length
    /// \[m\].
    pub fn squeeze_coefficient(viscosity: f64, radius: f64, length: f64) -> f64 {
        3.0 * SQRT_2 * PI * viscosity * length * radius.powf(1.5)
    }

    /// Damping coefficient at a thickness \[m\], `C h^(−3/2)` \[N s/m\].
    pub fn damping(&self, thickness: f64) -> f64 {
        self.coefficient * thickness.powf(-1.5)
    }

    /// Its layers for a half gap \[m\], the outermost first. Their borders are a geometric sequence of
    /// thicknesses. No layer begins beyond the middle of the gap.
    pub fn layers(&self, half_gap: f64) -> Vec<FilmLayer> {
        let [widest, least] = self.thickness;
        let widest = widest.min(least + half_gap);
        let count = self.layers as f64;
        let border = |i: usize| widest * (least / widest).powf(i as f64 / count);
        (0..self.layers)
            .map(|i| {
                let [from, to] = [
                    border(i),
                    if i + 1 == self.layers { least } else { border(i + 1) },
                ];
                let squeezed = 2.0 * self.coefficient * (to.sqrt().recip() - from.sqrt().recip());
                FilmLayer {
                    distance: [from, to].map(|h| (h - least).clamp(0.0, half_gap)),
                    damping: squeezed / (from - to),
                }
            })
            .collect()
    }

    /// Rejects a film with a value out of its range.
    pub(super) fn check(&self) -> Result<(), ModelError> {
        let [widest, least] = self.thickness;
        let c = self.coefficient;
        check_in_range("coefficient of the film", c, c > 0.0, "above 0 N s m^0.5")?;
        check_in_range("thickness of the film", least, least > 0.0, "above 0 m")?;
        let (name, accepted) = ("largest thickness of the film", "above the smallest");
        check_in_range(name, widest, widest > least, accepted)?;
        let fits = (1..=MOST_LAYERS).contains(&self.layers);
        check_in_range(
            "layers of the film",
            self.layers as f64,
            fits,
            "from 1 to 20",
        )
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::model::{Drive, Model, fixtures};

    /// Viscosity 0.05 Pa s, length 20 mm, R 12.8 mm.
    fn film(layers: usize) -> Film {
        Film {
            coefficient: Film::squeeze_coefficient(0.05, 12.8e-3, 20e-3),
            thickness: [50e-6, 1e-6],
            layers,
        }
    }

    /// Numerical values of the closed form.
    #[test]
    fn the_film_of_two_cylinders_has_its_closed_form() {
        let film = film(5);
        assert!((film.coefficient / 1.93019e-5 - 1.0).abs() < 1e-5);
        for (thickness, damping) in [
            (50e-6, 54.6),
            (10e-6, 610.0),
            (2e-6, 6824.0),
            (1e-6, 19302.0),
        ] {
            assert!((film.damping(thickness) / damping - 1.0).abs() < 1e-3);
        }
    }

    /// The layers are contiguous down to the flank, and their total loss of speed is that of the law.
    #[test]
    fn layers_lose_the_speed_of_the_law() {
        for layers in [1, 3, 8] {
            let film = film(layers);
            let found = film.layers(100e-6);
            let lost: f64 = (found.iter())
                .map(|own| own.damping * (own.distance[0] - own.distance[1]))
                .sum();
            let exact = 2.0 * film.coefficient * (1e-6_f64.powf(-0.5) - 50e-6_f64.powf(-0.5));
            assert!(
                (lost / exact - 1.0).abs() < 1e-12,
                "{layers}: {lost} {exact}"
            );
            assert!((found[0].distance[0] - 49e-6).abs() < 1e-19);
            assert_eq!(found[layers - 1].distance[1], 0.0);
            for pair in found.windows(2) {
                assert!((pair[0].distance[1] - pair[1].distance[0]).abs() < 1e-20);
                assert!(pair[0].damping < pair[1].damping);
            }
        }
        let narrow = film(4).layers(10e-6);
        assert_eq!(narrow[0].distance[0], 10e-6);
    }

    #[test]
    fn films_out_of_range_are_refused() {
        let structure = fixtures::one_mode(3000.0);
        let made = |film: Film| {
            let drive = Drive {
                film: Some(film),
                ..fixtures::constant_mesh(1e-5, 4e8)
            };
            Model::new(&structure, &drive, fixtures::strong_rattle()).map(|_| ())
        };
        assert_eq!(made(film(5)), Ok(()));
        let thin = Film {
            thickness: [1e-6, 1e-6],
            ..film(5)
        };
        let dry = Film {
            coefficient: 0.0,
            ..film(5)
        };
        for wrong in [
            thin,
            dry,
            film(0),
            film(21),
            Film {
                thickness: [5e-6, 0.0],
                ..film(5)
            },
        ] {
            assert!(
                matches!(made(wrong), Err(ModelError::OutOfRange { .. })),
                "{wrong:?}"
            );
        }
    }
}
