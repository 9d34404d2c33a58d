//! The tooth of one gear as the basic rack cuts it: involute flank and trochoidal fillet.
//!
//! Coordinates: the gear's axis is the origin, y runs along the tooth's centre line outwards,
//! x to one side of it (half the thickness). Both curves are exact, with exact
//! derivatives:
//!
//! * involute, roll angle t = tan(pressure angle), τ = t − θ_b:
//!   `x = r_b (t cos τ − sin τ)`, `y = r_b (t sin τ + cos τ)`, `y' = r_b t cos τ`;
//! * fillet, angle γ of the normal from α (where it meets the involute) to π/2 (root circle):
//!   the normal at every point passes through the pitch point of gear and rack. For a corner
//!   of radius ρ whose centre is h below the rolling line and b beside the tooth's centre line,
//!   with `φ = (h cot γ + b)/r` and `D = h/sin γ + ρ`,
//!   `x = r sin φ − D cos(γ − φ)`, `y = r cos φ − D sin(γ − φ)`.
//!
//! A rack whose straight flank ends beyond the tangent point of the base circle undercuts the tooth: its
//! corner cuts off the root of the involute. The fillet then crosses the involute at some γ above α, and the
//! flank begins there.
//!
//! A ring has inner teeth. Its number of teeth and its radii are negative, so the formulas of the involute need no
//! change. y still runs outwards from its axis, from the tip to the root. A ring is not cut by a rack: its fillet
//! is an arc of the radius of the rack's corner that touches the involute and the root circle, or the largest such arc
//! that fits between two teeth.
//!
//! Litvin & Fuentes, Gear Geometry and Applied Theory, 2nd ed. 2004, chapter 6.

use super::{BasicRack, GearError, GearPair, inverse_involute, involute};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// One tooth of one gear: radii \[m\], negative for a ring; angles \[rad\].
#[derive(Debug, Clone, PartialEq)]
pub struct Tooth {
    /// Reference radius `m z / 2`, on which gear and rack roll.
    pub reference_radius: f64,
    /// Base radius.
    pub base_radius: f64,
    /// Tip radius.
    pub tip_radius: f64,
    /// Root radius.
    pub root_radius: f64,
    /// Radius at which fillet and involute meet; for undercut teeth, at which they cross.
    pub form_radius: f64,
    /// Roll angle at the form radius, the tangent of the pressure angle there.
    pub form_roll: f64,
    /// The undercut, if the rack cuts off the root of the involute.
    pub undercut: Option<Undercut>,
    /// Roll angle at the tip.
    pub tip_roll: f64,
    /// Half the angle of the tooth on the base circle, θ_b, with the involute extended to it.
    pub base_half_angle: f64,
    /// Half the angle of the tooth where the fillet meets the root circle, θ_f.
    pub root_half_angle: f64,
    /// Profile shift coefficient at which the rack cuts, thinning included, in modules of the section \[1\].
    pub generating_shift: f64,
    fillet: Fillet,
}

/// Undercut of a tooth, in modules of the drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undercut {
    /// Profile shift coefficient at which the tooth is cut, thinning included.
    pub shift: f64,
    /// Smallest coefficient without undercut.
    pub limit: f64,
}

/// The curve between involute and root circle.
#[derive(Debug, Clone, PartialEq)]
struct Fillet {
    curve: FilletCurve,
    /// Radius of the rack's corner, or of the arc \[m\].
    radius: f64,
    /// Angles of the normal at the involute and at the root circle \[rad\].
    range: [f64; 2],
}

#[derive(Debug, Clone, PartialEq)]
enum FilletCurve {
    /// The trochoid of the rack's rounded corner.
    Corner {
        /// Distance of its centre below the rolling line \[m\].
        depth: f64,
        /// Its centre's distance from the tooth's centre line \[m\].
        offset: f64,
    },
    /// An arc about a centre \[m\], for a ring.
    Arc([f64; 2]),
}

/// A point of a profile with its derivative by the curve's parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePoint {
    /// Half the tooth's thickness there \[m\].
    pub x: f64,
    /// Height above the gear's axis \[m\].
    pub y: f64,
    /// dx/dt, t the parameter of the curve \[m/rad\].
    pub dx: f64,
    /// dy/dt \[m/rad\].
    pub dy: f64,
}

impl Tooth {
    /// The tooth of gear `index` (0 = pinion) of a pair in the transverse section.
    ///
    /// # Errors
    ///
    /// [`GearError::RackTip`], [`GearError::PointedTip`], [`GearError::TipBelowForm`], for a ring
    /// [`GearError::RingTip`] and [`GearError::RingSpace`], and those of [`GearPair::tight_centre_distance`].
    pub fn new(pair: &GearPair, index: usize) -> Result<Self, GearError> {
        check_rack(pair)?;
        let tip_radius = Self::tip_radius_of(pair, index)?;
        let section = pair.transverse_section();
        let mut tooth = Self::cut(&section, index, pair.signed_teeth()[index], tip_radius)?;
        // Coefficients of a drawing are in normal modules.
        let cos = pair.helix_angle.cos();
        tooth.undercut = tooth.undercut.map(|undercut| Undercut {
            shift: undercut.shift / cos,
            limit: undercut.limit / cos,
        });
        Ok(tooth)
    }

    /// The tooth of a spur gear cut by the rack of pair `pair`, with any real number of teeth, up to a tip
    /// radius \[m\]. For a ring the number of teeth and the radius are negative, and no rack cuts the tooth.
    ///
    /// # Errors
    ///
    /// [`GearError::PointedTip`], [`GearError::TipBelowForm`]; for a ring [`GearError::RingTip`] and
    /// [`GearError::RingSpace`].
    pub(super) fn cut(
        pair: &GearPair,
        index: usize,
        teeth: f64,
        tip_radius: f64,
    ) -> Result<Self, GearError> {
        if teeth < 0.0 {
            return Self::of_ring(pair, index, teeth, tip_radius);
        }
        let gear = index + 1;
        let (module, angle, rack) = (pair.module, pair.pressure_angle, pair.form.rack);
        let (sin, cos) = angle.sin_cos();
        let reference_radius = 0.5 * module * teeth;
        let base_radius = reference_radius * cos;
        let shift = generating_shift(pair, index);
        let offset = module * (FRAC_PI_2 - land(rack, angle));
        let fillet = Fillet {
            curve: FilletCurve::Corner {
                depth: module * (rack.dedendum - rack.tip_radius - shift),
                offset,
            },
            radius: module * rack.tip_radius,
            range: [angle, FRAC_PI_2],
        };
        // Depth of the end of the rack's straight flank below the rolling line. This end touches the line of action at
        // a distance of depth / sin α before the pitch point.
        let straight = module * (rack.dedendum - rack.tip_radius * (1.0 - sin) - shift);
        let form_roll = (reference_radius * sin - straight / sin) / base_radius;
        let mut tooth = Self {
            reference_radius,
            base_radius,
            tip_radius,
            root_radius: reference_radius + module * (shift - rack.dedendum),
            form_radius: base_radius * form_roll.hypot(1.0),
            form_roll,
            undercut: None,
            tip_roll: ((tip_radius / base_radius).powi(2) - 1.0).sqrt(),
            base_half_angle: base_half_angle(pair, index, teeth),
            root_half_angle: offset / reference_radius,
            generating_shift: shift,
            fillet,
        };
        if form_roll < 0.0 {
            let limit = shift + (straight - reference_radius * sin * sin) / module;
            tooth.undercut = Some(Undercut { shift, limit });
            let start = tooth.crossing();
            tooth.fillet.range[0] = start;
            let crossing = tooth.fillet(start);
            tooth.form_radius = crossing.x.hypot(crossing.y).max(base_radius);
            tooth.form_roll = ((tooth.form_radius / base_radius).powi(2) - 1.0).sqrt();
        }
        if tip_radius <= tooth.form_radius {
            return Err(GearError::TipBelowForm {
                gear,
                tip_diameter: 2.0 * tip_radius,
                form_diameter: 2.0 * tooth.form_radius,
            });
        }
        let tip_thickness = tooth.thickness(tip_radius);
        if tip_thickness <= 0.0 {
            let roll = Self::pointed_roll(pair, index, teeth);
            return Err(GearError::PointedTip {
                gear,
                tip_diameter: 2.0 * tip_radius,
                limit: 2.0 * base_radius * roll.hypot(1.0),
            });
        }
        Ok(tooth)
    }

    /// The tooth of a ring, as [`Self::cut`].
    ///
    /// The centre of an arc of radius ρ lies on the normal of the involute at the roll angle t, at the distance
    /// `r_f − ρ` from the axis: `r_b t = ρ + √((r_f − ρ)² − r_b²)`, with positive radii.
    fn of_ring(
        pair: &GearPair,
        index: usize,
        teeth: f64,
        tip_radius: f64,
    ) -> Result<Self, GearError> {
        let gear = index + 1;
        let (module, rack) = (pair.module, pair.form.rack);
        let reference_radius = 0.5 * module * teeth;
        let base_radius = reference_radius * pair.pressure_angle.cos();
        let generating_shift = generating_shift(pair, index);
        let root_radius = reference_radius + module * (generating_shift - rack.dedendum);
        let base_half_angle = base_half_angle(pair, index, teeth);
        let (base, root) = (base_radius.abs(), root_radius.abs());
        // Roll angle at the start of the arc, and the polar angle of its centre.
        let arc = |radius: f64| {
            let tangent = (((root - radius) / base).powi(2) - 1.0).max(0.0).sqrt();
            let roll = tangent + radius / base;
            [roll, roll - base_half_angle - tangent.atan()]
        };
        let half_pitch = PI / teeth.abs();
        if arc(0.0)[1] >= half_pitch {
            let root_diameter = 2.0 * root;
            return Err(GearError::RingSpace {
                gear,
                root_diameter,
            });
        }
        let mut radius = module * rack.tip_radius;
        if arc(radius)[1] > half_pitch {
            let [mut fits, mut large] = [0.0, radius];
            for _ in 0..f64::MANTISSA_DIGITS {
                let middle = 0.5 * (fits + large);
                if arc(middle)[1] < half_pitch { fits = middle } else { large = middle }
            }
            radius = fits;
        }
        let [form_roll, root_half_angle] = arc(radius);
        let form_radius = base_radius * form_roll.hypot(1.0);
        let pointed = base * Self::pointed_roll(pair, index, teeth).hypot(1.0);
        let tip = tip_radius.abs();
        if !(pointed < tip && tip < form_radius.abs()) {
            return Err(GearError::RingTip {
                gear,
                tip_diameter: 2.0 * tip,
                least: 2.0 * pointed,
                most: 2.0 * form_radius.abs(),
            });
        }
        let (sin, cos) = root_half_angle.sin_cos();
        Ok(Self {
            reference_radius,
            base_radius,
            tip_radius,
            root_radius,
            form_radius,
            form_roll,
            undercut: None,
            tip_roll: ((tip_radius / base_radius).powi(2) - 1.0).sqrt(),
            base_half_angle,
            root_half_angle,
            generating_shift,
            fillet: Fillet {
                curve: FilletCurve::Arc([(root - radius) * sin, (root - radius) * cos]),
                radius,
                range: [form_roll - base_half_angle, FRAC_PI_2 + root_half_angle],
            },
        })
    }

    /// Direction in which the tooth points: 1 outwards, -1 towards the axis.
    pub(super) fn sense(&self) -> f64 {
        self.base_radius.signum()
    }

    /// Angle γ of the normal at which the fillet of an undercut tooth crosses the involute.
    ///
    /// The height of the fillet decreases with γ. At α the fillet is outside the tooth, on the branch of the involute
    /// beyond the base circle; at the base circle it is inside. Rounding hides a very small undercut, which then ends
    /// on the base circle.
    fn crossing(&self) -> f64 {
        let outside = |normal: f64| {
            let point = self.fillet(normal);
            let radius = point.x.hypot(point.y);
            radius > self.base_radius
                && 2.0 * radius * point.x.atan2(point.y) > self.thickness(radius)
        };
        let [mut high, mut low] = self.fillet_range();
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (high + low);
            if outside(middle) { high = middle } else { low = middle }
        }
        high
    }

    /// Roll angle at which the flanks of a tooth meet.
    pub(super) fn pointed_roll(pair: &GearPair, index: usize, teeth: f64) -> f64 {
        inverse_involute(base_half_angle(pair, index, teeth)).tan()
    }

    /// Tip radius of gear `index` (0 = pinion) of a pair \[m\], negative for a ring. If the drawing does not state it,
    /// the addendum is altered so that the tip keeps the rack's clearance. The addendum of a ring is never lengthened.
    ///
    /// # Errors
    ///
    /// Those of [`GearPair::tight_centre_distance`].
    pub fn tip_radius_of(pair: &GearPair, index: usize) -> Result<f64, GearError> {
        if let Some(diameter) = pair.form.tip_diameter[index] {
            return Ok(0.5 * diameter * pair.pitch_radii()[index].signum());
        }
        let spread = pair.tight_centre_distance()? - pair.reference_centre_distance();
        let sum: f64 = pair.form.profile_shift.iter().sum();
        let alteration = match pair.form.ring {
            None => spread / pair.module - sum,
            Some(_) => 0.0,
        };
        let shift = pair.form.profile_shift[index];
        Ok(
            pair.pitch_radii()[index]
                + pair.module * (pair.form.rack.addendum + shift + alteration),
        )
    }

    /// Thickness along the circle of a radius between base and tip, negative for a ring \[m\].
    pub fn thickness(&self, radius: f64) -> f64 {
        let pressure_angle = (self.base_radius / radius).acos();
        2.0 * radius * (self.base_half_angle - involute(pressure_angle))
    }

    /// The involute at roll angle t.
    pub fn flank(&self, roll: f64) -> ProfilePoint {
        let (sin, cos) = self.force_angle(roll).sin_cos();
        let base = self.base_radius;
        ProfilePoint {
            x: base * (roll * cos - sin),
            y: self.sense() * (base * (roll * sin + cos)),
            dx: -base * roll * sin,
            dy: self.sense() * (base * roll * cos),
        }
    }

    /// Angle between the normal of the involute at roll angle t and the perpendicular to the
    /// tooth's centre line, `t − θ_b` \[rad\].
    pub fn force_angle(&self, roll: f64) -> f64 {
        roll - self.base_half_angle
    }

    /// The fillet at angle γ of its normal, from [`Self::fillet_range`].
    pub fn fillet(&self, normal: f64) -> ProfilePoint {
        let radius = self.fillet.radius;
        let (sin, cos) = normal.sin_cos();
        let (depth, offset) = match self.fillet.curve {
            FilletCurve::Corner { depth, offset } => (depth, offset),
            FilletCurve::Arc([x, y]) => {
                return ProfilePoint {
                    x: x - radius * cos,
                    y: y + radius * sin,
                    dx: radius * sin,
                    dy: radius * cos,
                };
            }
        };
        let rolled = (depth * cos / sin + offset) / self.reference_radius;
        let rolled_by = -depth / (self.reference_radius * sin * sin);
        let reach = depth / sin + radius;
        let reach_by = -depth * cos / (sin * sin);
        let (sin_rolled, cos_rolled) = rolled.sin_cos();
        let (sin_rest, cos_rest) = (normal - rolled).sin_cos();
        ProfilePoint {
            x: self.reference_radius * sin_rolled - reach * cos_rest,
            y: self.reference_radius * cos_rolled - reach * sin_rest,
            dx: self.reference_radius * cos_rolled * rolled_by - reach_by * cos_rest
                + reach * sin_rest * (1.0 - rolled_by),
            dy: -self.reference_radius * sin_rolled * rolled_by
                - reach_by * sin_rest
                - reach * cos_rest * (1.0 - rolled_by),
        }
    }

    /// Angles of the fillet's normal at the involute and at the root circle \[rad\].
    pub fn fillet_range(&self) -> [f64; 2] {
        self.fillet.range
    }
}

/// Profile shift coefficient at which the rack cuts, thinning included, in modules of the pair.
fn generating_shift(pair: &GearPair, index: usize) -> f64 {
    let thinning = pair.form.thinning[index] / (2.0 * pair.module * pair.pressure_angle.tan());
    pair.form.profile_shift[index] - thinning
}

/// Half the angle of a tooth on the base circle \[rad\], for this number of teeth.
fn base_half_angle(pair: &GearPair, index: usize, teeth: f64) -> f64 {
    let (sin, cos) = pair.pressure_angle.sin_cos();
    (FRAC_PI_2 + 2.0 * generating_shift(pair, index) * sin / cos) / teeth
        + involute(pair.pressure_angle)
}

/// Half the land of a rack's tip, between the centres of its corners, in modules.
fn land(rack: BasicRack, angle: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    FRAC_PI_4 - (rack.dedendum - rack.tip_radius) * sin / cos - rack.tip_radius / cos
}

/// Checks that the corners of the rack of a pair fit on its tip.
fn check_rack(pair: &GearPair) -> Result<(), GearError> {
    let (rack, angle) = (pair.form.rack, pair.pressure_angle);
    let (sin, cos) = angle.sin_cos();
    if land(rack, angle) < 0.0 || rack.tip_radius * (1.0 - sin) > rack.dedendum {
        let full = (FRAC_PI_4 * cos - rack.dedendum * sin) / (1.0 - sin);
        return Err(GearError::RackTip {
            tip_radius: rack.tip_radius,
            limit: full.min(rack.dedendum / (1.0 - sin)).max(0.0),
        });
    }
    Ok(())
}
