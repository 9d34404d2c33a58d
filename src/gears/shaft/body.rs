//! The body of a gear on its shaft: hub, web and rim.
//!
//! ```text
//!        |<---- body_length ---->|
//!        +-----------------------+   pitch circle
//!        |          rim          |
//!        +-------+       +-------+   rim_diameter
//!                |  web  |
//!      +---------+       +---------+ hub_diameter
//!      |            hub            |
//! -----+---------------------------+----- shaft
//! ```
//!
//! A hub bends and twists with its shaft, as a shaft section with the diameter of the hub. The parts
//! outside it are a rigid body. Without a hub the whole body is rigid, and the shaft inside it bends as
//! if it were alone.

use super::disc::Disc;
use super::error::ShaftError;
use crate::gear::positive;
use crate::gear::{GearPair, Hub};

/// The effect of a gear body on its shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GearBody {
    /// The hub, which thickens the shaft.
    pub hub: Option<Hub>,
    /// The rigid part: outside the hub, or without a hub the whole body.
    pub rigid: Disc,
    /// The whole body outside the shaft, hub included.
    pub whole: Disc,
}

impl GearBody {
    /// The body of one gear of a pair on a shaft of a diameter \[m\], of a density \[kg/m³\].
    ///
    /// # Errors
    /// [`GearError::NotPositive`](crate::gear::GearError); [`ShaftError::BodyParts`] if the diameters of shaft, hub, web, rim and pitch circle
    /// do not increase in this order.
    pub fn new(
        gears: &GearPair,
        index: usize,
        shaft_diameter: f64,
        density: f64,
    ) -> Result<Self, ShaftError> {
        let shape = gears.form.body[index];
        let pitch = 2.0 * gears.pitch_radii()[index];
        let length = gears.body_length[index];
        let inner = shape.hub.map_or(shaft_diameter, |hub| hub.diameter);
        let within = |inside: &'static str, inner: f64, outside: &'static str, outer: f64| {
            if inner < outer {
                Ok(())
            } else {
                Err(ShaftError::BodyParts {
                    gear: index + 1,
                    inside,
                    inner_diameter: inner,
                    outside,
                    outer_diameter: outer,
                })
            }
        };
        if let Some(hub) = shape.hub {
            within("the shaft", shaft_diameter, "the hub", hub.diameter)?;
        }
        let held_by = if shape.hub.is_some() { "the hub" } else { "the shaft" };
        match shape.web {
            Some(web) => {
                within(held_by, inner, "the inside of the rim", web.rim_diameter)?;
                within(
                    "the inside of the rim",
                    web.rim_diameter,
                    "the pitch circle",
                    pitch,
                )?;
            }
            None => within(held_by, inner, "the pitch circle", pitch)?,
        }
        let rigid = Disc::webbed([pitch, inner], length, shape.web, density)?;
        let whole = match shape.hub {
            None => rigid,
            Some(hub) => {
                positive("hub length [m]", hub.length)?;
                rigid.with(Disc::annulus(
                    hub.diameter,
                    shaft_diameter,
                    hub.length,
                    density,
                )?)
            }
        };
        Ok(Self {
            hub: shape.hub,
            rigid,
            whole,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::{BodyShape, Web};
    use crate::shaft::flexible::tests::drive;
    use std::f64::consts::PI;

    const STEEL: f64 = 7850.0;

    /// Mass, polar and transverse inertia of a ring summed over thin tubes.
    fn tubes(from: f64, to: f64, length: f64) -> [f64; 3] {
        let count = 20_000;
        let step = 0.5 * (to - from) / f64::from(count);
        let mut sums = [0.0; 3];
        for i in 0..count {
            let radius = 0.5 * from + (f64::from(i) + 0.5) * step;
            let mass = 2.0 * PI * radius * step * length * STEEL;
            sums[0] += mass;
            sums[1] += mass * radius * radius;
            sums[2] += mass * (0.5 * radius * radius + length * length / 12.0);
        }
        sums
    }

    #[test]
    fn hub_web_and_rim_are_the_sum_of_thin_tubes() {
        let mut gears = drive().gears;
        gears.form.body[0] = BodyShape {
            hub: Some(Hub {
                diameter: 28e-3,
                length: 36e-3,
            }),
            web: Some(Web {
                thickness: 8e-3,
                rim_diameter: 44e-3,
            }),
        };
        let pitch = 2.0 * gears.pitch_radii()[0];
        let body = GearBody::new(&gears, 0, 20e-3, STEEL).unwrap();
        let outside = [
            tubes(28e-3, 44e-3, 8e-3),
            tubes(44e-3, pitch, gears.body_length[0]),
        ];
        let hub = tubes(20e-3, 28e-3, 36e-3);
        let of = |disc: Disc| [disc.mass, disc.polar_inertia, disc.transverse_inertia];
        for part in 0..3 {
            let rigid = outside[0][part] + outside[1][part];
            assert!((of(body.rigid)[part] / rigid - 1.0).abs() < 1e-7);
            assert!((of(body.whole)[part] / (rigid + hub[part]) - 1.0).abs() < 1e-7);
        }
        // The other gear is one solid piece.
        let solid = GearBody::new(&gears, 1, 24e-3, STEEL).unwrap();
        assert_eq!((solid.hub, solid.rigid), (None, solid.whole));
    }

    #[test]
    fn parts_lie_outside_of_one_another() {
        let gears = drive().gears;
        let of = |hub: f64, rim: f64| {
            let mut gears = gears.clone();
            gears.form.body[0] = BodyShape {
                hub: Some(Hub {
                    diameter: hub,
                    length: 30e-3,
                }),
                web: Some(Web {
                    thickness: 8e-3,
                    rim_diameter: rim,
                }),
            };
            GearBody::new(&gears, 0, 20e-3, STEEL)
        };
        assert!(of(30e-3, 44e-3).is_ok());
        for (hub, rim) in [(19e-3, 44e-3), (45e-3, 44e-3), (30e-3, 58e-3)] {
            let refused = of(hub, rim);
            assert!(
                matches!(refused, Err(ShaftError::BodyParts { gear: 1, .. })),
                "{refused:?}"
            );
        }
    }
}
