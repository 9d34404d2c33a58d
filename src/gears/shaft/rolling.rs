//! What load does a rolling bearing carry at a displacement of its inner ring, and how stiff is it there?
//!
//! The inner ring moves by (x, y, z) and tilts about x and y. At the angle φ around the bearing it moves by
//! `u_r = x cos φ + y sin φ` radially and by `u_z = z + R τ` along the axis, `τ = θx sin φ − θy cos φ`. Every
//! rolling element presses with `Q = c δ^p` if its approach δ is positive (ISO/TS 16281).
//!
//! Balls: without load the centres of curvature of both grooves are `A = r_i + r_e − D` apart along the contact
//! angle. With the radial clearance s,
//!
//! ```text
//! δ = |(A cos α − s/2 + u_r, A sin α + u_z)| − A,   p = 3/2,   R = D_pw/2 + (r_i − D/2) cos α
//! ```
//!
//! and c follows from Hertz: `c = (√2 π/3) E_y/(1 − ν²) (Σ K (Σρ/(χ² E))^{1/3})^{-3/2}` over both rings, with the
//! complete elliptic integrals K and E of the contact ellipse with the ratio of axes χ. The standard rounds √2 π/3 to
//! 1.48.
//!
//! Rollers: slices at the positions ξ along the roller have
//!
//! ```text
//! δ = cos α (u_r − s/2) + z sin α + τ (D_pw sin α/2 − ξ),   p = 10/9,   c = 35948 N/mm² · L^{8/9} / slices
//! ```
//!
//! with lengths in mm (steel).

use super::error::ShaftError;
use crate::gear::{non_negative, positive};
use crate::numerics::linalg::dot;
use serde::Serialize;
use std::f64::consts::{PI, SQRT_2, TAU};

/// Freedoms of the inner ring: x, y, z, tilt about x, tilt about y.
pub const RING_FREEDOMS: usize = 5;

/// A displacement of the inner ring \[m, rad\], or a load on it \[N, N m\].
pub type Ring<T = f64> = [T; RING_FREEDOMS];

/// Number of slices of a roller.
const SLICES: usize = 30;

/// c of a steel roller of 1 m \[N/m^{10/9}\]; the units of the standard cancel to 10⁶.
const ROLLER_COEFFICIENT: f64 = 35_948e6;

/// Upper end of the search for the ratio of axes of the contact ellipse of ball and groove.
const LONGEST_ELLIPSE: f64 = 1e4;

/// A rolling bearing by its catalogue data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RollingBearing {
    /// Number of rolling elements Z.
    pub count: u32,
    /// Diameter of the circle of their centres D_pw \[m\].
    pub pitch_diameter: f64,
    /// Nominal contact angle α \[rad\]; positive if the bearing carries a thrust of the shaft along +z.
    pub contact_angle: f64,
    /// Radial clearance s, across the diameter \[m\]; negative for a preload.
    pub clearance: f64,
    /// The rolling elements.
    pub element: RollingElement,
}

/// A rolling element of a bearing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum RollingElement {
    /// A ball between grooves.
    Ball {
        /// Its diameter D \[m\].
        diameter: f64,
        /// Radius of the groove of the inner and of the outer ring, over D.
        conformity: [f64; 2],
        /// Young's modulus of balls and rings \[Pa\].
        young_modulus: f64,
        /// Their Poisson's ratio.
        poisson_ratio: f64,
    },
    /// A straight roller of steel.
    Roller {
        /// Its diameter D \[m\].
        diameter: f64,
        /// Its effective length L \[m\].
        length: f64,
    },
}

/// A bearing with its coefficients of contact.
#[derive(Debug, Clone)]
pub struct RollingLaw {
    bearing: RollingBearing,
    /// c of one element, or of one slice.
    coefficient: f64,
    exponent: f64,
}

/// The load on a bearing at a displacement of its inner ring.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RollingLoad {
    /// Load on the bearing \[N, N m\].
    pub load: Ring,
    /// Derivative of the load by the displacement, symmetric \[N/m, N, N m\].
    pub stiffness: Ring<Ring>,
    /// Number of elements that carry load.
    pub elements: u32,
    /// The largest force on one of them \[N\].
    pub largest: f64,
}

impl RollingElement {
    fn diameter(&self) -> f64 {
        match *self {
            Self::Ball { diameter, .. } | Self::Roller { diameter, .. } => diameter,
        }
    }
}

impl RollingBearing {
    /// The bearing with its coefficients of contact.
    ///
    /// # Errors
    /// [`GearError::NotPositive`](crate::gear::GearError), [`GearError::Negative`](crate::gear::GearError) for a length or a modulus, [`ShaftError::ElementsTouch`],
    /// [`ShaftError::NoGroove`].
    pub fn law(&self) -> Result<RollingLaw, ShaftError> {
        positive("pitch diameter of a bearing [m]", self.pitch_diameter)?;
        let diameter = positive("diameter of rolling elements [m]", self.element.diameter())?;
        let room = self.pitch_diameter * (PI / f64::from(self.count.max(2))).sin();
        if self.count == 0 || diameter > room {
            return Err(ShaftError::ElementsTouch {
                count: self.count,
                diameter,
                room,
            });
        }
        let (coefficient, exponent) = match self.element {
            RollingElement::Ball {
                conformity,
                young_modulus,
                poisson_ratio,
                ..
            } => {
                positive("Young's modulus of a bearing [Pa]", young_modulus)?;
                non_negative("Poisson's ratio of a bearing", poisson_ratio)?;
                let modulus = young_modulus / (1.0 - poisson_ratio * poisson_ratio);
                let cos = self.contact_angle.cos();
                let gamma = diameter * cos / self.pitch_diameter;
                let mut approach = 0.0;
                for (conformity, along) in conformity
                    .into_iter()
                    .zip([gamma / (1.0 - gamma), -gamma / (1.0 + gamma)])
                {
                    approach += ball_approach(diameter, conformity, along)
                        .ok_or(ShaftError::NoGroove { conformity })?;
                }
                let factor = SQRT_2 * PI / 3.0;
                (factor * modulus / approach.powf(1.5), 1.5)
            }
            RollingElement::Roller { length, .. } => {
                let length = positive("length of a roller [m]", length)?;
                let whole = ROLLER_COEFFICIENT * length.powf(8.0 / 9.0);
                (whole / SLICES as f64, 10.0 / 9.0)
            }
        };
        Ok(RollingLaw {
            bearing: *self,
            coefficient,
            exponent,
        })
    }
}

impl RollingLaw {
    /// c of one element in `Q = c δ^p` \[N/m^p\].
    pub fn coefficient(&self) -> f64 {
        match self.bearing.element {
            RollingElement::Ball { .. } => self.coefficient,
            RollingElement::Roller { .. } => self.coefficient * SLICES as f64,
        }
    }

    /// A typical stiffness of a loaded bearing for each freedom \[N/m, N m/rad\].
    pub(super) fn typical(&self) -> Ring {
        let diameter = self.bearing.element.diameter();
        let stiffness = 1e10 * diameter;
        let tilt = stiffness * self.bearing.pitch_diameter.powi(2) / 8.0;
        [stiffness, stiffness, stiffness, tilt, tilt]
    }

    /// The load on the bearing at a displacement of its inner ring.
    pub fn at(&self, moved: &Ring) -> RollingLoad {
        let mut load = RollingLoad::default();
        for number in 0..self.bearing.count {
            let angle = TAU * f64::from(number) / f64::from(self.bearing.count);
            let force = match self.bearing.element {
                RollingElement::Ball {
                    diameter,
                    conformity,
                    ..
                } => self.ball(
                    moved,
                    angle,
                    conformity.map(|part| part * diameter),
                    &mut load,
                ),
                RollingElement::Roller { length, .. } => {
                    self.roller(moved, angle, length, &mut load)
                }
            };
            load.elements += u32::from(force > 0.0);
            load.largest = load.largest.max(force);
        }
        for i in 0..RING_FREEDOMS {
            for j in 0..i {
                load.stiffness[j][i] = load.stiffness[i][j];
            }
        }
        load
    }

    /// Adds a ball between grooves of these radii \[m\]; returns its force \[N\].
    fn ball(&self, moved: &Ring, angle: f64, grooves: [f64; 2], sum: &mut RollingLoad) -> f64 {
        let bearing = &self.bearing;
        let diameter = bearing.element.diameter();
        let (sin, cos) = bearing.contact_angle.sin_cos();
        let apart = grooves[0] + grooves[1] - diameter;
        let radius = 0.5 * bearing.pitch_diameter + (grooves[0] - 0.5 * diameter) * cos;
        let [radial, axial] = directions(angle, radius);
        let reach = [
            apart * cos - 0.5 * bearing.clearance + dot(&radial, moved),
            apart * sin + dot(&axial, moved),
        ];
        let length = reach[0].hypot(reach[1]);
        let normal = reach.map(|part| part / length);
        let gradient = combined([&radial, &axial], normal);
        // Motion across the normal rotates the direction of the force.
        let across = combined([&radial, &axial], [-normal[1], normal[0]]);
        self.press(length - apart, &gradient, Some((&across, length)), sum)
    }

    /// Adds the slices of a roller of this length \[m\]; returns its force \[N\].
    fn roller(&self, moved: &Ring, angle: f64, length: f64, sum: &mut RollingLoad) -> f64 {
        let bearing = &self.bearing;
        let (sin, cos) = bearing.contact_angle.sin_cos();
        let slices = (0..SLICES).map(|slice| {
            let place = length * ((slice as f64 + 0.5) / SLICES as f64 - 0.5);
            // The lever arm of the normal force about the middle of the bearing.
            let [radial, mut axial] = directions(angle, 1.0);
            let arm = 0.5 * bearing.pitch_diameter * sin - place;
            axial[2] = sin;
            axial[3] *= arm;
            axial[4] *= arm;
            let gradient = combined([&radial, &axial], [cos, 1.0]);
            let approach = dot(&gradient, moved) - 0.5 * bearing.clearance * cos;
            self.press(approach, &gradient, None, sum)
        });
        slices.sum()
    }

    /// Adds a contact with this approach and its gradient. If motion across the force rotates the force,
    /// `across` has the derivative of this motion by the displacement of the ring, and the radius of the
    /// rotation \[m\]. Returns the force \[N\].
    fn press(
        &self,
        approach: f64,
        gradient: &Ring,
        across: Option<(&Ring, f64)>,
        sum: &mut RollingLoad,
    ) -> f64 {
        if approach <= 0.0 {
            return 0.0;
        }
        let force = self.coefficient * approach.powf(self.exponent);
        let slope = self.exponent * force / approach;
        for i in 0..RING_FREEDOMS {
            sum.load[i] += force * gradient[i];
            for j in 0..=i {
                sum.stiffness[i][j] += slope * gradient[i] * gradient[j];
                if let Some((across, length)) = across {
                    sum.stiffness[i][j] += force / length * across[i] * across[j];
                }
            }
        }
        force
    }
}

/// Radial and axial motion at an angle and a radius \[m\], as linear functions of the displacement of the ring.
fn directions(angle: f64, radius: f64) -> [Ring; 2] {
    let (sin, cos) = angle.sin_cos();
    [
        [cos, sin, 0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, radius * sin, -radius * cos],
    ]
}

fn combined([one, two]: [&Ring; 2], [a, b]: [f64; 2]) -> Ring {
    std::array::from_fn(|i| a * one[i] + b * two[i])
}

/// Term `K (Σρ/(χ² E))^{1/3}` \[m^{-1/3}\] of Hertz's law for a ball in a groove. `along` is the curvature of the
/// raceway in the plane of rolling, in units of 2/D. `None` if the equation of the axis ratio χ has no solution.
fn ball_approach(diameter: f64, conformity: f64, along: f64) -> Option<f64> {
    let groove = 0.5 / conformity;
    let sum = 2.0 + along - groove;
    let difference = (along + groove) / sum;
    // The equation of the ratio of axes χ: 1 − 2/(χ² − 1) (K/E − 1) rises from 0 at 1 to 1.
    let miss = |ratio: f64| {
        let [first, second] = elliptic_integrals(ratio);
        1.0 - 2.0 / (ratio * ratio - 1.0) * (first / second - 1.0) - difference
    };
    let mut bracket = [1.0 + 1e-6, LONGEST_ELLIPSE];
    // Written so that a NaN is rejected.
    let inside = miss(bracket[0]) < 0.0 && miss(bracket[1]) > 0.0;
    if !inside {
        return None;
    }
    let mut ratio = bracket[0];
    // Bisection on a logarithmic scale, down to round-off.
    for _ in 0..80 {
        ratio = (bracket[0] * bracket[1]).sqrt();
        bracket[usize::from(miss(ratio) > 0.0)] = ratio;
    }
    let [first, second] = elliptic_integrals(ratio);
    Some(first * (2.0 * sum / diameter / (ratio * ratio * second)).cbrt())
}

/// The complete elliptic integrals K and E of the modulus `√(1 − 1/χ²)` (Abramowitz & Stegun 17.6, arithmetic-geometric
/// mean).
fn elliptic_integrals(ratio: f64) -> [f64; 2] {
    let (mut a, mut b) = (1.0, 1.0 / ratio);
    let mut power = 0.5;
    let mut sum = power * (1.0 - b * b);
    while a - b > 1e-15 * a {
        let half = 0.5 * (a - b);
        power *= 2.0;
        sum += power * half * half;
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let first = 0.5 * PI / a;
    [first, first * (1.0 - sum)]
}
