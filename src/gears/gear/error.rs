//! What can be wrong with the drawing of a gear pair?

/// The direction along a flank in which the drawing gives missing material by points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlankCourse {
    /// Along the roll length.
    Profile,
    /// Along the face.
    Lead,
}

impl std::fmt::Display for FlankCourse {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Profile => "profile through points (positions are roll lengths)",
            Self::Lead => "lead through points (positions are distances from mid-face)",
        })
    }
}

/// Why a drawing is not a gear pair that can run. Gears are numbered 1 = pinion, 2 = wheel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GearError {
    /// The base circles overlap at the given centre distance.
    #[error(
        "a centre distance of {centre_distance:.6} m is not more than the sum {base_radii:.6} m of the base \
         radii, so there is no line of action; raise it"
    )]
    BaseCirclesOverlap {
        /// Centre distance \[m\].
        centre_distance: f64,
        /// Sum of the base radii \[m\].
        base_radii: f64,
    },
    /// No centre distance is free of backlash: the profile shifts are too negative, or in a ring too positive.
    #[error(
        "profile shifts with the sum {sum} allow no centre distance without backlash; the sum must be {} than {limit:.4}",
        if sum > limit { "less" } else { "more" }
    )]
    ShiftSum {
        /// Sum of the profile shift coefficients.
        sum: f64,
        /// The sum at which the operating pressure angle is 0.
        limit: f64,
    },
    /// A quantity that must be positive and finite is not.
    #[error("{quantity} is {value}, but must be positive and finite")]
    NotPositive {
        /// The quantity, with its unit.
        quantity: &'static str,
        /// The value found.
        value: f64,
    },
    /// A quantity that must be non-negative and finite is not.
    #[error("{quantity} is {value}, but must be finite and not negative")]
    Negative {
        /// The quantity, with its unit.
        quantity: &'static str,
        /// The value found.
        value: f64,
    },
    /// A quantity that is too large.
    #[error("{quantity} is {value}, but must be less than {limit}")]
    TooLarge {
        /// The quantity, with its unit.
        quantity: &'static str,
        /// The value found.
        value: f64,
        /// Its limit.
        limit: f64,
    },
    /// A helix angle outside its range.
    #[error("the helix angle is {value} rad, but must be between -π/2 and π/2")]
    HelixAngle {
        /// Helix angle \[rad\].
        value: f64,
    },
    /// The rounding of the rack's tip is larger than the tip.
    #[error(
        "the rack's tip radius of {tip_radius} modules does not fit on the rack's tip; it must be at most {limit:.4}"
    )]
    RackTip {
        /// Tip radius in modules.
        tip_radius: f64,
        /// Largest tip radius that fits, in modules.
        limit: f64,
    },
    /// The rack cuts off part of the flank that the mate would touch.
    #[error(
        "gear {gear} is undercut up to a diameter of {:.4} mm, but its mate touches it from {:.4} mm on: \
         its profile shift, thinning included, is {shift:.4}; at least {limit:.4} avoids undercut; raise \
         the shift or the number of teeth, or lower the mate's tip diameter",
        1e3 * form_diameter, 1e3 * active_diameter
    )]
    Undercut {
        /// 1 = pinion, 2 = wheel.
        gear: usize,
        /// Profile shift coefficient at which it is cut.
        shift: f64,
        /// Smallest profile shift coefficient without undercut.
        limit: f64,
        /// Diameter at which the involute begins \[m\].
        form_diameter: f64,
        /// Diameter at which contact would begin, or the base circle if that is larger \[m\].
        active_diameter: f64,
    },
    /// The flanks of a tooth meet below its tip circle.
    #[error(
        "the teeth of gear {gear} are pointed at a diameter of {limit:.6} m, below the tip diameter of \
         {tip_diameter:.6} m; lower the profile shift or gear.tip_diameter"
    )]
    PointedTip {
        /// 1 = pinion, 2 = wheel.
        gear: usize,
        /// Tip diameter \[m\].
        tip_diameter: f64,
        /// Diameter at which the flanks meet \[m\].
        limit: f64,
    },
    /// The tip circle leaves nothing of the involute.
    #[error(
        "the tip diameter {tip_diameter:.6} m of gear {gear} is not above {form_diameter:.6} m, where its involute \
         begins; raise the tip diameter"
    )]
    TipBelowForm {
        /// 1 = pinion, 2 = wheel.
        gear: usize,
        /// Tip diameter \[m\].
        tip_diameter: f64,
        /// Diameter at which fillet and involute meet \[m\].
        form_diameter: f64,
    },
    /// The tip circle of a ring is too small, or so large that it lies in the root fillet.
    #[error(
        "the tip diameter {tip_diameter:.6} m of gear {gear}, a ring, must be between {least:.6} m, where its involute \
         or its tooth ends, and {most:.6} m, where its root fillet begins"
    )]
    RingTip {
        /// 1 = pinion, 2 = wheel.
        gear: usize,
        /// Tip diameter \[m\].
        tip_diameter: f64,
        /// Diameter of the base circle, or where the flanks of a tooth meet \[m\].
        least: f64,
        /// Diameter at which fillet and involute meet \[m\].
        most: f64,
    },
    /// The flanks of neighbouring teeth of a ring meet within its root circle.
    #[error(
        "the spaces of gear {gear}, a ring, are pointed within the root diameter {root_diameter:.6} m; raise its profile \
         shift or lower the rack's dedendum"
    )]
    RingSpace {
        /// 1 = pinion, 2 = wheel.
        gear: usize,
        /// Root diameter \[m\].
        root_diameter: f64,
    },
    /// The pinion's tip meets the fillet of a ring.
    #[error(
        "the pinion's tip meets the ring at the roll angle {active_roll:.5} rad, beyond {form_roll:.5} rad where its \
         involute ends at the root fillet; lower the pinion's tip diameter or the rack's tip radius"
    )]
    RingInterference {
        /// Roll angle at which contact would end (tangent of the pressure angle).
        active_roll: f64,
        /// Roll angle at which fillet and involute meet.
        form_roll: f64,
    },
    /// The ring around the teeth is too thin.
    #[error(
        "the outer diameter {outer} m of a ring divided by its root diameter is {ratio:.4} but must be at least {least:.4}; \
         raise the outer diameter"
    )]
    RingBody {
        /// Outer diameter \[m\].
        outer: f64,
        /// Outer diameter over root diameter.
        ratio: f64,
        /// Least ratio.
        least: f64,
    },
    /// A gear that cannot run inside its ring.
    #[error(transparent)]
    Ring(#[from] super::InternalError),
    /// A tip meets its mate's fillet.
    #[error(
        "the mate's tip meets gear {gear} at the roll angle {active_roll:.5} rad, below {form_roll:.5} rad where its involute begins; lower the mate's tip diameter or raise this gear's profile shift"
    )]
    Interference {
        /// Gear whose fillet is met: 1 = pinion, 2 = wheel.
        gear: usize,
        /// Roll angle at which contact would begin (tangent of the pressure angle).
        active_roll: f64,
        /// Roll angle at which fillet and involute meet.
        form_roll: f64,
    },
    /// A pair leaves contact before the next comes into it.
    #[error(
        "the contact ratio is {contact_ratio:.4} and must be at least 1; raise the tip diameters or lower the centre distance"
    )]
    ContactRatio {
        /// Contact ratio.
        contact_ratio: f64,
    },
    /// The teeth are thicker than the spaces.
    #[error(
        "at a centre distance of {centre_distance:.6} m the teeth overlap by {:.3e} m along the line of action; raise the distance or the thinning", -backlash
    )]
    NegativeBacklash {
        /// Backlash along the line of action \[m\], negative.
        backlash: f64,
        /// Centre distance \[m\].
        centre_distance: f64,
    },
    /// A tip reaches below its mate's root circle.
    #[error(
        "the tip of gear {gear} reaches {:.3e} m below its mate's root circle; change its tip diameter for shorter teeth, or raise the rack's dedendum",
        -clearance
    )]
    TipInRoot {
        /// Gear whose tip it is: 1 = pinion, 2 = wheel.
        gear: usize,
        /// Distance from tip to root \[m\], negative.
        clearance: f64,
    },
    /// The drawing does not say where the body of a gear is clamped.
    #[error(
        "gear {gear} has no bore, on which its body stands; give `bore` in the table of this gear (of planets \
         train.planetary.*.bore), or the diameter of its shaft"
    )]
    NoBore {
        /// 1 = pinion, 2 = wheel.
        gear: usize,
    },
    /// The rim below the teeth is too thin.
    #[error(
        "gear {gear}: root diameter divided by bore ({bore} m) is {ratio:.3} but must be at least {least}; \
         set gear.bore to the diameter below which the body is rigid"
    )]
    BodyRatio {
        /// 1 = pinion, 2 = wheel.
        gear: usize,
        /// Bore \[m\].
        bore: f64,
        /// Root diameter over bore.
        ratio: f64,
        /// Least ratio.
        least: f64,
    },
    /// A profile or lead is given by one point only.
    #[error("the {course} of gear {gear} has one point, but needs two or more")]
    OnePoint {
        /// Which course.
        course: FlankCourse,
        /// 1 = pinion, 2 = wheel.
        gear: usize,
    },
    /// The positions of the points do not increase.
    #[error(
        "point {point} of the {course} of gear {gear} is not beyond the previous one, or is not a number; \
         list the points with increasing positions"
    )]
    PointOrder {
        /// Which course.
        course: FlankCourse,
        /// 1 = pinion, 2 = wheel.
        gear: usize,
        /// Which point, counted from 1.
        point: usize,
    },
    /// A point that is not on the flank.
    #[error(
        "the {course} of gear {gear} has a point at {:.4} mm, but the flank reaches from {:.4} to {:.4} mm; remove the point",
        1e3 * place, 1e3 * from, 1e3 * to
    )]
    PointOffFlank {
        /// Which course.
        course: FlankCourse,
        /// 1 = pinion, 2 = wheel.
        gear: usize,
        /// Where it is \[m\]: roll length, or distance from mid-face.
        place: f64,
        /// Where the flank begins \[m\].
        from: f64,
        /// Where it ends \[m\].
        to: f64,
    },
    /// A law of friction gives a value outside the range of a coefficient of friction.
    #[error(
        "the law of friction gives a coefficient of {coefficient:.3e}, which must be above 0 and below 1; check mesh.roughness, mesh.oil_viscosity and the speed, or give mesh.friction"
    )]
    MeanFriction {
        /// Coefficient of friction that the law gives.
        coefficient: f64,
    },
    /// A crack is requested in a tooth of a ring.
    #[error(
        "a ring has no critical section at 30°, so that the effect of a crack is not known; give `stiffness` instead"
    )]
    CrackInRing,
    /// A crack through most of the tooth.
    #[error(
        "a crack of {:.4} mm is too deep; at most {:.4} mm are possible, 60 % of the critical section",
        1e3 * depth, 1e3 * limit
    )]
    CrackDepth {
        /// Its depth \[m\].
        depth: f64,
        /// Largest depth \[m\].
        limit: f64,
    },
}

/// `value` if it is positive and finite.
pub(crate) fn positive(quantity: &'static str, value: f64) -> Result<f64, GearError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(GearError::NotPositive { quantity, value })
    }
}

/// `value` if it is zero or positive, and finite.
pub(crate) fn non_negative(quantity: &'static str, value: f64) -> Result<f64, GearError> {
    if value.is_finite() && value >= 0.0 {
        Ok(value)
    } else {
        Err(GearError::Negative { quantity, value })
    }
}
